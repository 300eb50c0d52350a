//! What commands write: never in place of what they read or what somebody else has made, nothing lost where two write at once.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

use super::folder::{RULES, folder, run};
use crate::common::repository;
use crate::common::run::{gearwise_in, stderr};

const MODEL: &str = r#"<robot name="arm"><link name="base"/><link name="tip"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/>
<limit effort="900" velocity="5" lower="-1" upper="1"/></joint></robot>
"#;

const HARDWARE: &str = "[[joint]]\nnames = [\"elbow\"]\nmodule = \"robstride-rs04\"\n";

const BENCH: &str = r#"name = "stand"
kind = "stall"
[motor]
id = "delta-4"
pole_pairs = 12
[columns]
time = { name = "t", unit = "s" }
current = { name = "i", unit = "A", convention = "phase_amplitude" }
torque = { name = "tau", unit = "N*m", side = "motor" }
[[log]]
file = "log.csv"
use = "fit"
"#;

/// Everything that commands read.
fn desk() -> TempDir {
    let desk = folder();
    let mut log = "t,i,tau\n".to_string();
    for k in 0..1200 {
        let step = f64::from((k / 200) - 3) + 0.5;
        let noise = f64::from((k * 7919) % 101 - 50) * 1e-5;
        log.push_str(&format!("{:.3},{:.4},{:.6}\n", f64::from(k) * 0.01, 4.0 * step + noise, 0.4 * step + noise));
    }
    for (name, text) in [
        ("model.urdf", MODEL),
        ("hardware.toml", HARDWARE),
        ("trajectory.csv", "time [s],elbow [rad]\n0,0\n0.25,0.3\n0.5,0.5\n0.75,0.2\n1,0\n"),
        ("bench.toml", BENCH),
        ("log.csv", &log),
        ("broken.csv", "id,terminals\nx\n"),
    ] {
        fs::write(desk.path().join(name), text).unwrap();
    }
    for name in ["leg_actuator.toml", "leg_actuator_1.csv", "leg_actuator_2.csv", "leg_actuator_3.csv"] {
        fs::copy(repository("requirements/bench").join(name), desk.path().join(name)).unwrap();
    }
    desk
}

/// Commands with what they write, `OUT`, the ending of its name, and every file that they read.
const COMMANDS: &[(&str, &str, &[&str])] = &[
    ("rank motors.csv --plot OUT", "svg", &["motors.csv"]),
    ("rank motors.csv --html OUT", "html", &["motors.csv"]),
    (
        "optimize robot.toml --catalog motors.csv --rules rules.toml --write-design OUT",
        "toml",
        &["robot.toml", "knee.csv", "motors.csv", "rules.toml"],
    ),
    ("optimize robot.toml --catalog motors.csv --html OUT", "html", &["robot.toml", "knee.csv", "motors.csv"]),
    ("optimize robot.toml --catalog motors.csv --plot OUT", "svg", &["robot.toml", "knee.csv", "motors.csv"]),
    ("sweep robot.toml --catalog motors.csv --html OUT", "html", &["robot.toml", "knee.csv", "motors.csv"]),
    ("explain alpha-1 robot.toml --catalog motors.csv --html OUT", "html", &["robot.toml", "knee.csv", "motors.csv"]),
    ("compare alpha-1 alpha-2 --catalog motors.csv --html OUT", "html", &["motors.csv"]),
    ("audit motors.csv --html OUT", "html", &["motors.csv"]),
    (
        "check design.toml --rules rules.toml --junit OUT",
        "xml",
        &["design.toml", "robot.toml", "knee.csv", "motors.csv", "rules.toml"],
    ),
    ("check design.toml --sarif OUT", "sarif", &["design.toml", "robot.toml", "knee.csv", "motors.csv"]),
    // What is wrong with the input is reported, too, and not over the input.
    ("check design.toml --catalog broken.csv --sarif OUT", "sarif", &["design.toml", "robot.toml", "broken.csv"]),
    ("export design.toml --to mjcf --out OUT", "xml", &["design.toml", "robot.toml", "knee.csv", "motors.csv"]),
    ("export design.toml --into model.urdf --map knee=elbow --out OUT", "urdf", &["design.toml", "model.urdf"]),
    ("check-model model.urdf --against hardware.toml --fix --out OUT", "urdf", &["model.urdf", "hardware.toml"]),
    ("check-model model.urdf --against hardware.toml --junit OUT", "xml", &["model.urdf", "hardware.toml"]),
    ("characterize bench.toml --write OUT", "csv", &["bench.toml", "log.csv"]),
    ("characterize bench.toml --plot OUT", "svg", &["bench.toml", "log.csv"]),
    ("identify leg_actuator.toml --write OUT", "toml", &["leg_actuator.toml", "leg_actuator_2.csv"]),
    ("identify leg_actuator.toml --plan OUT", "csv", &["leg_actuator.toml", "leg_actuator_3.csv"]),
    (
        "explore robot.toml --catalog motors.csv --grid scale.torque=1,2 --static OUT",
        "html",
        &["robot.toml", "knee.csv", "motors.csv"],
    ),
];

fn gearwise(desk: &TempDir, line: &str, out: &str) -> Output {
    let words: Vec<&str> = line.split(' ').map(|word| if word == "OUT" { out } else { word }).collect();
    gearwise_in(desk.path(), &words)
}

fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    all.sort();
    all
}

#[test]
fn no_command_writes_over_what_it_reads_by_whatever_name() {
    for (line, ending, inputs) in COMMANDS {
        let desk = desk();
        for input in *inputs {
            let before = fs::read(desk.path().join(input)).unwrap();
            let mut ways = Vec::new();
            let hard = format!("hard.{ending}");
            fs::hard_link(desk.path().join(input), desk.path().join(&hard)).unwrap();
            ways.push(hard.clone());
            #[cfg(unix)]
            {
                let soft = format!("soft.{ending}");
                std::os::unix::fs::symlink(input, desk.path().join(&soft)).unwrap();
                ways.push(soft);
            }
            if input.ends_with(&format!(".{ending}")) {
                ways.push(format!("../{}/{input}", desk.path().file_name().unwrap().to_str().unwrap()));
            }
            for way in &ways {
                let there = names(desk.path());
                let output = gearwise(&desk, line, way);
                assert_eq!(output.status.code(), Some(2), "{line} {input} as {way}: {}", stderr(&output));
                assert!(stderr(&output).contains(&format!("cannot write `{way}`")), "{}", stderr(&output));
                assert_eq!(fs::read(desk.path().join(input)).unwrap(), before, "{line} {input} as {way}");
                assert_eq!(names(desk.path()), there, "{line}");
            }
            ways.iter().filter(|way| !way.contains('/')).for_each(|w| fs::remove_file(desk.path().join(w)).unwrap());
        }
        // Another file is replaced (these take long, or make no whole row).
        if !line.starts_with("identify") && *line != "characterize bench.toml --write OUT" {
            let other = format!("other.{ending}");
            fs::write(desk.path().join(&other), "old").unwrap();
            let output = gearwise(&desk, line, &other);
            assert_ne!(fs::read(desk.path().join(&other)).unwrap(), b"old", "{line}: {}", stderr(&output));
        }
    }
}

#[test]
fn what_is_written_below_a_folder_is_not_put_in_place_of_an_input() {
    let desk = desk();
    let at = |name: &str| desk.path().join(name);
    let good = |words: &[&str]| {
        let output = gearwise_in(desk.path(), words);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {}", stderr(&output));
    };
    let refused = |words: &[&str], input: &str| {
        let before = fs::read(at(input)).unwrap();
        let output = gearwise_in(desk.path(), words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", stderr(&output));
        assert_eq!(fs::read(at(input)).unwrap(), before, "{words:?}");
    };
    let torques = ["torques", "model.urdf", "trajectory.csv", "--out", "motions"];
    good(&torques);
    let written = names(&at("motions"));
    assert!(!written.is_empty());
    fs::remove_file(at("motions").join(&written[0])).unwrap();
    fs::hard_link(at("trajectory.csv"), at("motions").join(&written[0])).unwrap();
    refused(&torques, "trajectory.csv");
    fs::create_dir(at("db")).unwrap();
    let motors = "key,manufacturer,ID,type,V,k_t,R,L,mass,inertia,omega_nl,I_nl,I_nom,max_int_torque,max_int_speed,max_cont_speed,max_cont_power,coulomb_friction,viscous_friction,Rth1,Rth2\n\
        AC_1,Acme,one,BLDC,24,0.05,0.5,0.0001,0.3,1e-5,470,0.2,4,inf,900,800,Inf,,,,\n";
    fs::write(at("db/a_motors.csv"), motors).unwrap();
    let gears = "key,manufacturer,ID,type,stages,ratio,mass,inertia,efficiency,direction,max_int_torque,max_cont_torque\n\
        G_1,Acme,g,planetary,1,5,0.1,1e-7,0.9,1,10,5\n";
    fs::write(at("db/a_gearboxes.csv"), gears).unwrap();
    let import = ["import", "mgdb", "db", "--out", "own", "--force"];
    good(&import);
    fs::remove_file(at("own/motors/mgdb-acme.csv")).unwrap();
    fs::hard_link(at("db/a_motors.csv"), at("own/motors/mgdb-acme.csv")).unwrap();
    refused(&import, "db/a_motors.csv");
}

#[test]
fn two_results_of_one_command_are_two_files() {
    let desk = folder();
    let both = ["check", "design.toml", "--junit", "report.xml", "--sarif", "report.xml"];
    let ran = run(&desk, &both);
    assert_eq!(ran.status, 2, "{}", ran.err);
    assert!(fs::read_to_string(desk.path().join("report.xml")).unwrap().starts_with("<?xml"), "the first is whole");
    // What the next command writes there takes its place.
    assert_eq!(run(&desk, &both[..4]).status, 0);
}

#[test]
fn a_model_is_fixed_in_place_where_that_is_said() {
    let desk = desk();
    let at = desk.path().join("model.urdf");
    let fix = ["check-model", "model.urdf", "--against", "hardware.toml", "--fix"];
    let output = gearwise_in(desk.path(), &[&fix[..], &["--out", "model.urdf"]].concat());
    assert_eq!((output.status.code(), fs::read_to_string(&at).unwrap().as_str()), (Some(2), MODEL));
    let output = gearwise_in(desk.path(), &[&fix[..], &["--in-place"]].concat());
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let fixed = fs::read_to_string(&at).unwrap();
    assert!(fixed != MODEL && !fixed.contains("\"900\"") && fixed.contains("<joint name=\"elbow\""), "{fixed}");
    assert!(!desk.path().join("model.fixed.urdf").exists());
    let output = gearwise_in(desk.path(), &["check-model", "model.urdf", "--in-place", "--against", "hardware.toml"]);
    assert_eq!(output.status.code(), Some(2), "without --fix there is nothing to write");
}

/// The requirement and catalogue of a study of two robots, and the call.
const STUDY: [&str; 7] = ["study", "study.toml", "--catalog", "motors.csv", "--out", "d", "--quiet"];

fn study() -> TempDir {
    let desk = folder();
    let text = "requirement = \"robot.toml\"\n[grid]\n\"bus.voltage\" = [\"24 V\", \"48 V\"]\n";
    fs::write(desk.path().join("study.toml"), text).unwrap();
    desk
}

#[test]
fn a_study_removes_only_what_a_study_has_made() {
    // A folder of the journal's name that somebody else has made.
    for more in [&[][..], &["--force"], &["--resume"]] {
        for name in ["diary.txt", "list.txt", "plan.json"] {
            let desk = study();
            fs::create_dir_all(desk.path().join("d/journal")).unwrap();
            fs::write(desk.path().join("d/journal").join(name), "{\"mine\": 1}").unwrap();
            let ran = run(&desk, &[&STUDY[..], more].concat());
            assert_eq!(ran.status, 2, "{more:?} {name}: {}", ran.err);
            assert_eq!(names(&desk.path().join("d")), ["journal"], "{more:?}");
            assert_eq!(fs::read_to_string(desk.path().join("d/journal").join(name)).unwrap(), "{\"mine\": 1}");
        }
    }
    // A file of a result's name.
    for name in ["manifest.json", "summary.json", "results.csv"] {
        let desk = study();
        fs::create_dir(desk.path().join("d")).unwrap();
        fs::write(desk.path().join("d").join(name), "{\"outputs\": []}").unwrap();
        for more in [&[][..], &["--force"]] {
            let ran = run(&desk, &[&STUDY[..], more].concat());
            assert_eq!(ran.status, 2, "{more:?}: {}", ran.err);
            assert_eq!(fs::read_to_string(desk.path().join("d").join(name)).unwrap(), "{\"outputs\": []}");
        }
    }
    // Its own results are replaced; of the folder of its own journal what is not its own stays.
    let desk = study();
    let out = desk.path().join("d");
    let part = [&STUDY[..], &["--shard", "1/1"]].concat();
    assert_eq!(run(&desk, &part).status, 0);
    assert!(out.join("journal/plan.json").is_file());
    fs::write(out.join("journal/notes.txt"), "mine").unwrap();
    fs::write(out.join("notes.txt"), "mine").unwrap();
    assert_eq!(run(&desk, &[&STUDY[..], &["--force"]].concat()).status, 0);
    assert_eq!(names(&out.join("journal")), ["notes.txt"]);
    let whole = fs::read(out.join("results.csv")).unwrap();
    fs::remove_dir_all(out.join("journal")).unwrap();
    assert_eq!(run(&desk, &[&STUDY[..], &["--force"]].concat()).status, 0);
    assert_eq!(fs::read(out.join("results.csv")).unwrap(), whole);
    assert!(!out.join("journal").exists() && out.join("notes.txt").is_file());
    // Results that were begun and not finished are its own as well: the manifest comes last.
    fs::remove_file(out.join("manifest.json")).unwrap();
    assert_eq!(run(&desk, &[&STUDY[..], &["--force"]].concat()).status, 0);
    assert!(out.join("manifest.json").is_file());
}

#[test]
#[cfg(unix)]
fn a_link_in_place_of_a_study_s_result_is_followed() {
    let desk = study();
    let out = desk.path().join("d");
    assert_eq!(run(&desk, &STUDY).status, 0);
    let whole = fs::read(out.join("results.csv")).unwrap();
    fs::create_dir(desk.path().join("elsewhere")).unwrap();
    for name in ["results.csv", "manifest.json"] {
        fs::rename(out.join(name), desk.path().join("elsewhere").join(name)).unwrap();
        std::os::unix::fs::symlink(Path::new("../elsewhere").join(name), out.join(name)).unwrap();
    }
    let ran = run(&desk, &[&STUDY[..], &["--force", "--set", "scale.torque=1.5"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    for name in ["results.csv", "manifest.json"] {
        assert!(out.join(name).is_symlink(), "{name}");
    }
    let linked = fs::read(desk.path().join("elsewhere/results.csv")).unwrap();
    assert!(linked != whole && fs::read(out.join("results.csv")).unwrap() == linked);
}

/// A row of a motor.
fn row(id: &str) -> String {
    format!(
        "id,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind\n{id},q_axis,q_axis,0.2,0.1,bench,measured\n"
    )
}

#[test]
fn rows_that_are_added_at_once_are_all_there() {
    let desk = tempfile::tempdir().unwrap();
    let ids: Vec<String> = (0..12).map(|k| format!("row-{k}")).collect();
    ids.iter().for_each(|id| fs::write(desk.path().join(format!("{id}.csv")), row(id)).unwrap());
    for (to, file) in [(&[][..], "own/motors/mine.csv"), (&["--to", "kept.csv"], "kept.csv")] {
        let add = |id: &String| {
            let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
            command.env("GEARWISE_CATALOG", desk.path().join("own")).current_dir(desk.path());
            command.args(["catalog", "add", &format!("{id}.csv")]).args(to);
            command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null()).spawn().unwrap()
        };
        let all: Vec<std::process::Child> = ids.iter().map(add).collect();
        for mut child in all {
            assert_eq!(child.wait().unwrap().code(), Some(0));
        }
        let text = fs::read_to_string(desk.path().join(file)).unwrap();
        let missing: Vec<&String> = ids.iter().filter(|id| !text.contains(&format!("\n{id},"))).collect();
        assert!(missing.is_empty(), "{missing:?} are lost:\n{text}");
    }
    let hidden = |folder: PathBuf| names(&folder).into_iter().filter(|name| name.starts_with('.')).count();
    assert_eq!(hidden(desk.path().into()) + hidden(desk.path().join("own/motors")), 0, "no lock is left");
}

/// Threads whose stacks are larger than any memory cannot be started.
#[test]
#[cfg(target_os = "linux")]
fn where_no_thread_can_be_started_one_does_all_or_it_is_told() {
    let desk = study();
    let optimize = ["optimize", "robot.toml", "--catalog", "motors.csv", "--json"];
    let with = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
        command.env("RUST_MIN_STACK", (1_u64 << 46).to_string()).args(words).current_dir(desk.path());
        command.output().unwrap()
    };
    let plain = gearwise_in(desk.path(), &optimize);
    for threads in [&[][..], &["--threads", "1"]] {
        let alone = with(&[&optimize[..], threads].concat());
        assert_eq!(
            (alone.status.code(), alone.stdout),
            (Some(0), plain.stdout.clone()),
            "{}",
            String::from_utf8_lossy(&alone.stderr)
        );
    }
    assert_eq!(with(&STUDY).status.code(), Some(0));
    assert_eq!(with(&["rank", "motors.csv"]).status.code(), Some(0));
    for refused in [&[&optimize[..], &["--threads", "3"]].concat()[..], &["explore", "robot.toml"]] {
        let output = with(refused);
        assert_eq!(output.status.code(), Some(2), "{refused:?}: {}", stderr(&output));
        assert!(stderr(&output).contains("cannot start"), "{}", stderr(&output));
    }
}

#[test]
fn rules_are_an_input_too() {
    // The rules that a requirement names itself are read late.
    let desk = folder();
    let requirement = fs::read_to_string(desk.path().join("robot.toml")).unwrap();
    fs::write(desk.path().join("robot.toml"), format!("rules = \"rules.toml\"\n{requirement}")).unwrap();
    let ran = run(&desk, &["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "rules.toml"]);
    assert_eq!(ran.status, 2, "{}", ran.err);
    assert_eq!(fs::read_to_string(desk.path().join("rules.toml")).unwrap(), RULES);
}
