//! Everything around the program goes wrong: full disks, files that change or never end, processes that are killed,
//! text in another encoding, cells that a spreadsheet would run. The answer is right, or an error that says so.
//!
//! What takes long, or needs file systems of its own, is `tests/faults.sh`.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gearwise::input::{Source, limits};
use gearwise::measured;
use gearwise::report::guarded;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use tempfile::TempDir;

const ROBOT: &str = r#"name = "leg"
[bus]
voltage = "48 V"
drive_current = "40 A"
[[joint]]
name = "knee"
count = 2
ratio = { min = 3, max = 30 }
motor_drag = "off"
gear = { efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2" }
motion = "knee.csv"
objective = "loss"
"#;

const MOTORS: &str = "\
id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],pole_pairs,continuous_current [A],peak_current [A],source,source_kind
alpha-1,q_axis,q_axis,0.2,0.1,0.06,300,300,14,10,40,made up for a test,derived
beta-2,q_axis,q_axis,0.3,0.2,0.09,500,400,14,9,35,made up for a test,derived
gamma-3,q_axis,q_axis,0.7,2.5,0.1,90,190,12,6,30,made up for a test,derived
";

const MODEL: &str = r#"<robot name="arm"><link name="base"/><link name="tip"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="elbow" type="continuous"><parent link="base"/><child link="tip"/><axis xyz="0 1 0"/></joint></robot>
"#;

const RULES: &str = "[[rule]]\nrule = \"voltage-headroom\"\nmin = 0.01\nreason = \"a test\"\n";

fn motion() -> String {
    let mut text = "time [s],torque [N*m],velocity [rad/s]\n".to_string();
    for k in 0..=20 {
        let phase = std::f64::consts::TAU * f64::from(k % 20) / 20.0;
        text.push_str(&format!("{},{:.6},{:.6}\n", f64::from(k) * 0.05, 3.0 * phase.sin(), 4.0 * phase.cos()));
    }
    text
}

/// A log of an electrical test: volts, amperes, speed.
fn bench() -> (String, String) {
    let bench = r#"name = "stand"
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
    let mut log = "t,i,tau\n".to_string();
    for k in 0..1200 {
        let step = f64::from((k / 200) - 3) + 0.5;
        let noise = f64::from((k * 7919) % 101 - 50) * 1e-5;
        log.push_str(&format!("{:.3},{:.4},{:.6}\n", f64::from(k) * 0.01, 4.0 * step + noise, 0.4 * step + noise));
    }
    (bench.into(), log)
}

/// A folder with one good file of each kind.
struct Desk(TempDir);

impl Desk {
    fn new() -> Desk {
        let desk = Desk(tempfile::tempdir().unwrap());
        let (bench, log) = bench();
        for (name, text) in [
            ("robot.toml", ROBOT.to_string()),
            ("knee.csv", motion()),
            ("motors.csv", MOTORS.to_string()),
            ("model.urdf", MODEL.to_string()),
            (
                "arm.urdf",
                MODEL
                    .replace("continuous", "revolute")
                    .replace("<axis", "<limit effort=\"900\" velocity=\"5\" lower=\"-1\" upper=\"1\"/><axis"),
            ),
            ("hardware.toml", "[[joint]]\nnames = [\"elbow\"]\nmodule = \"robstride-rs04\"\n".into()),
            ("row.csv", MOTORS.lines().take(2).map(|line| line.replace("alpha-1", "row-1") + "\n").collect()),
            ("rules.toml", RULES.to_string()),
            ("bench.toml", bench),
            ("log.csv", log),
            ("trajectory.csv", "time [s],elbow [rad]\n0,0\n0.25,0.3\n0.5,0.5\n0.75,0.2\n1,0\n".into()),
            ("study.toml", "requirement = \"robot.toml\"\n[grid]\n\"bus.voltage\" = [\"24 V\", \"48 V\"]\n".into()),
            ("db/a_motors.csv", format!("{DB_MOTORS}\n{}\n{}\n", DB_ROW.replace('#', "1"), DB_ROW.replace('#', "2"))),
            ("db/a_gearboxes.csv", DB_GEARS.into()),
            ("db/b_motors.csv", format!("{DB_MOTORS}\n{}\n", DB_ROW.replace('#', "3").replace("Acme", "Other"))),
        ] {
            desk.write(name, text.as_bytes());
        }
        let written = desk.run(&["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "design.toml"]);
        assert_eq!(written.status.code(), Some(0), "{}", said(&written));
        desk
    }

    /// With what a command needs beside: the shard that is merged.
    fn for_command(arguments: &[&str]) -> Desk {
        let desk = Desk::new();
        if arguments[0] == "merge" {
            let shard = ["study", "study.toml", "--out", "part", "--catalog", "motors.csv", "--shard", "1/1"];
            assert_eq!(desk.run(&shard).status.code(), Some(0));
        }
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), bytes).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
        command.args(arguments).current_dir(self.0.path());
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// The command line in a shell, `gearwise` in `$G`.
    fn shell(&self, script: &str) -> Output {
        let mut command = Command::new("sh");
        command.args(["-c", script]).env("G", env!("CARGO_BIN_EXE_gearwise")).current_dir(self.0.path());
        command.output().unwrap()
    }

    /// What an input that is wrong is answered with: status 2 and the message.
    #[track_caller]
    fn refused(&self, arguments: &[&str], parts: &[&str]) -> String {
        let begun = Instant::now();
        let output = self.run(arguments);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        for part in parts {
            assert!(text.contains(part), "{arguments:?} lacks {part:?}:\n{text}");
        }
        assert!(text.len() < 6000, "{arguments:?}: {} bytes of message", text.len());
        assert!(begun.elapsed() < Duration::from_secs(60), "{arguments:?}: without end");
        text
    }
}

const DB_MOTORS: &str = "key,manufacturer,ID,type,V,k_t,R,L,mass,inertia,omega_nl,I_nl,I_nom,max_int_torque,max_int_speed,max_cont_speed,max_cont_power,coulomb_friction,viscous_friction,Rth1,Rth2";
const DB_ROW: &str = "AC_#,Acme,=cmd|'/C calc'!A#,BLDC,24,0.05,0.5,0.0001,0.3,1e-5,470,0.2,4,inf,900,800,Inf,,,,";
const DB_GEARS: &str = "key,manufacturer,ID,type,stages,ratio,mass,inertia,efficiency,direction,max_int_torque,max_cont_torque\nG_1,Acme,@SUM(1),planetary,1,5,0.1,1e-7,0.9,1,10,5\n";

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Every file below a path with its bytes, names from it on; hidden ones apart.
fn files(path: &Path) -> (BTreeMap<PathBuf, Vec<u8>>, Vec<PathBuf>) {
    let (mut found, mut hidden, mut left) = (BTreeMap::new(), Vec::new(), vec![path.to_path_buf()]);
    while let Some(here) = left.pop() {
        if here.is_dir() {
            left.extend(fs::read_dir(&here).unwrap().map(|e| e.unwrap().path()));
        } else if here.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.')) {
            hidden.push(here);
        } else if here.is_file() {
            found.insert(here.strip_prefix(path).unwrap().to_path_buf(), fs::read(&here).unwrap());
        }
    }
    (found, hidden)
}

/// Every kind of output that is written to files: the command, and where it writes.
const OUTPUTS: &[(&[&str], &str)] = &[
    (&["rank", "motors.csv", "--plot", "out.svg"], "out.svg"),
    #[cfg(feature = "png")]
    (&["rank", "motors.csv", "--plot", "out.png"], "out.png"),
    (&["rank", "motors.csv", "--html", "out.html"], "out.html"),
    (&["optimize", "robot.toml", "--catalog", "motors.csv", "--html", "out.html"], "out.html"),
    (&["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "out.toml"], "out.toml"),
    (&["check", "design.toml", "--junit", "out.xml"], "out.xml"),
    (&["check", "design.toml", "--sarif", "out.sarif"], "out.sarif"),
    (&["check", "design.toml", "--lock"], "design.lock"),
    (&["export", "design.toml", "--to", "mjcf", "--out", "out.xml"], "out.xml"),
    (&["torques", "model.urdf", "trajectory.csv", "--out", "out"], "out"),
    (&["import", "mgdb", "db", "--out", "out"], "out"),
    #[cfg(feature = "packaging")]
    (&["man", "--out", "out"], "out"),
    (&["study", "study.toml", "--out", "out", "--catalog", "motors.csv"], "out"),
    (&["characterize", "bench.toml", "--plot", "out.svg"], "out.svg"),
    (&["check-model", "arm.urdf", "--against", "hardware.toml", "--fix", "--out", "out.urdf"], "out.urdf"),
    (&["catalog", "new", "motor", "--write", "new.csv"], "new.csv"),
    (&["catalog", "add", "row.csv", "--to", "added.csv"], "added.csv"),
    (
        &["explore", "robot.toml", "--catalog", "motors.csv", "--grid", "scale.torque=1,1.5", "--static", "out.html"],
        "out.html",
    ),
    (&["merge", "out", "part"], "out"),
];

/// Files that are written where there is none: a lock is read before it is written, a template is never replaced, and a row is
/// added once.
const ONCE: &[&str] = &["design.lock", "new.csv", "added.csv"];

/// What a command is told where its results are there already.
fn anew(arguments: &[&str]) -> &'static [&'static str] {
    if ["study", "import", "merge"].contains(&arguments[0]) { &["--force"] } else { &[] }
}

#[test]
fn the_good_files_are_good() {
    for (arguments, target) in OUTPUTS {
        let desk = Desk::for_command(arguments);
        let output = desk.run(arguments);
        assert!(output.status.code() < Some(2), "{arguments:?}: {}", said(&output));
        assert!(desk.path(target).exists(), "{arguments:?}");
        if desk.path(target).is_dir() {
            fs::remove_dir_all(desk.path(target)).unwrap();
        }
    }
}

/// `/dev/full` takes nothing.
#[test]
fn a_full_disk_behind_stdout_is_told() {
    let desk = Desk::new();
    for arguments in [
        "--help",
        "rank --help",
        "--version",
        "rank motors.csv",
        "rank motors.csv --json",
        "rank motors.csv --csv",
        "optimize robot.toml --catalog motors.csv",
        "optimize robot.toml --catalog motors.csv --csv",
        "sweep robot.toml --catalog motors.csv --csv",
        "explain alpha-1 robot.toml --catalog motors.csv --json",
        "compare alpha-1 beta-2 --catalog motors.csv",
        "audit motors.csv --csv",
        "check design.toml",
        "check design.toml --github",
        "rule",
        "torques model.urdf trajectory.csv --csv",
        "characterize bench.toml --json",
        "export design.toml --to urdf",
        "import mgdb db --out out --csv",
        "study study.toml --out study --catalog motors.csv",
        #[cfg(feature = "packaging")]
        "man --out man",
        #[cfg(feature = "packaging")]
        "completions bash",
    ] {
        let output = desk.shell(&format!("exec \"$G\" {arguments} > /dev/full"));
        assert_eq!(output.status.code(), Some(2), "{arguments}: {}", said(&output));
        assert!(said(&output).contains("cannot write the result: the disk is full"), "{arguments}: {}", said(&output));
    }
    // Nobody can be told, and nothing falls over.
    for arguments in
        ["optimize nowhere.toml", "optimize robot.toml --catalog nowhere.csv", "--nonsense", "rule nonsense"]
    {
        for stderr in ["/dev/full", "&-"] {
            let output = desk.shell(&format!("exec \"$G\" {arguments} 2> {stderr}").replace("2> &-", "2>&-"));
            assert_eq!(output.status.code(), Some(2), "{arguments}");
        }
    }
    let output = desk.shell("exec \"$G\" study study.toml --out more --catalog motors.csv --progress 2> /dev/full");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn a_closed_pipe_is_no_error_and_no_fall() {
    let desk = Desk::new();
    for arguments in [
        &["optimize", "robot.toml", "--catalog", "motors.csv", "--json"][..],
        &["sweep", "robot.toml", "--catalog", "motors.csv", "--csv"],
        &["rank", "motors.csv"],
        &["torques", "model.urdf", "trajectory.csv", "--csv"],
        &["--help"],
        #[cfg(feature = "packaging")]
        &["completions", "zsh"],
    ] {
        let mut child = desk.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", said(&output));
        assert_eq!(said(&output), "");
    }
    // A reader of messages that has gone away.
    let mut child = desk.command(&["optimize", "nowhere.toml"]).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(2));
}

/// No file may have a byte: as on a full disk, writing fails at once or half way.
#[test]
fn what_does_not_fit_leaves_what_was_there() {
    for blocks in [0, 1] {
        for (arguments, target) in OUTPUTS {
            let desk = Desk::for_command(arguments);
            let folder = *target == "out";
            let old = !folder && !ONCE.contains(target);
            if old {
                desk.write(target, b"old");
            }
            let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$G\" {}", arguments.join(" "));
            let output = desk.shell(&script);
            let (left, hidden) = files(desk.0.path());
            let is_old = |bytes: &[u8]| bytes == b"old";
            if output.status.code() == Some(2) {
                let text = said(&output);
                assert!(text.contains("cannot write") && text.contains("does not allow"), "{arguments:?}: {text}");
                if old {
                    assert!(is_old(&left[Path::new(target)]), "{arguments:?}");
                } else if !folder {
                    assert!(!left.contains_key(Path::new(target)), "{arguments:?}");
                }
            } else {
                // A small file fits into a block.
                assert!(blocks > 0 && output.status.code() < Some(2), "{arguments:?}: {}", said(&output));
            }
            let of_study = |h: &PathBuf| [".study.lock", ".study"].iter().any(|name| h.ends_with(name));
            assert!(hidden.iter().all(of_study), "{arguments:?}: {hidden:?}");
            // What is there is whole: with room it is the same.
            if folder && arguments[0] != "study" {
                let (some, _) = files(&desk.path("out"));
                let again = [arguments, anew(arguments)].concat();
                assert!(desk.run(&again).status.code() < Some(2), "{arguments:?}");
                let (all, _) = files(&desk.path("out"));
                assert!(some.iter().all(|(name, bytes)| all[name] == *bytes), "{arguments:?}");
            }
        }
    }
}

#[test]
fn places_that_cannot_be_written_are_named() {
    let desk = Desk::new();
    fs::write(desk.path("protected.svg"), "old").unwrap();
    fs::set_permissions(desk.path("protected.svg"), fs::Permissions::from_mode(0o444)).unwrap();
    fs::create_dir(desk.path("folder.svg")).unwrap();
    symlink("circle.svg", desk.path("circle.svg")).unwrap();
    let long = format!("{}.svg", "x".repeat(300));
    for (place, why) in [
        ("nowhere/x.svg", "there is no folder `nowhere`"),
        ("motors.csv/x.svg", "not a folder"),
        ("folder.svg", "it is a folder"),
        ("protected.svg", "it is write-protected"),
        ("circle.svg", "links lead in a circle"),
        (&long, "the name is too long"),
    ] {
        let text = desk.refused(&["rank", "motors.csv", "--plot", place], &["cannot write", why]);
        assert!(!text.contains("os error"), "{text}");
    }
    for arguments in [
        ["check", "design.toml", "--sarif", "nowhere/x.sarif"],
        ["check", "design.toml", "--junit", "nowhere/x.xml"],
        ["rank", "motors.csv", "--html", "nowhere/x.html"],
    ] {
        desk.refused(&arguments, &["cannot write `nowhere/x.", "there is no folder `nowhere`"]);
    }
    for arguments in [
        &["torques", "model.urdf", "trajectory.csv", "--out", "motors.csv"][..],
        #[cfg(feature = "packaging")]
        &["man", "--out", "motors.csv"],
        &["study", "study.toml", "--out", "motors.csv"],
        &["import", "mgdb", "db", "--out", "motors.csv"],
    ] {
        let text = desk.refused(arguments, &["motors.csv"]);
        assert!(!text.contains("os error"), "{arguments:?}: {text}");
    }
    assert_eq!(desk.read("protected.svg"), "old");
    assert_eq!(desk.read("motors.csv"), MOTORS);
}

/// A shell's `>` follows a link; so does every output. The link stays.
#[test]
fn outputs_follow_links_and_keep_what_a_file_allows() {
    let desk = Desk::new();
    fs::create_dir(desk.path("elsewhere")).unwrap();
    desk.write("elsewhere/real.svg", b"old");
    fs::set_permissions(desk.path("elsewhere/real.svg"), fs::Permissions::from_mode(0o640)).unwrap();
    symlink("elsewhere/real.svg", desk.path("link.svg")).unwrap();
    symlink("link.svg", desk.path("twice.svg")).unwrap();
    symlink("elsewhere/not yet.svg", desk.path("dangling.svg")).unwrap();
    for (link, real) in [("twice.svg", "elsewhere/real.svg"), ("dangling.svg", "elsewhere/not yet.svg")] {
        let output = desk.run(&["rank", "motors.csv", "--plot", link]);
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        assert!(desk.path(link).is_symlink() && desk.read(real).ends_with("</svg>\n"), "{link}");
    }
    assert_eq!(fs::metadata(desk.path("elsewhere/real.svg")).unwrap().permissions().mode() & 0o777, 0o640);
    // A catalogue folder of links: the files that they point to are replaced.
    let import = ["import", "mgdb", "db", "--out", "out"];
    assert_eq!(desk.run(&import).status.code(), Some(0));
    let (whole, _) = files(&desk.path("out"));
    desk.write("elsewhere/acme.csv", b"old");
    fs::remove_file(desk.path("out/motors/mgdb-acme.csv")).unwrap();
    symlink("../../elsewhere/acme.csv", desk.path("out/motors/mgdb-acme.csv")).unwrap();
    assert_eq!(desk.run(&[&import[..], &["--force"]].concat()).status.code(), Some(0));
    assert!(desk.path("out/motors/mgdb-acme.csv").is_symlink());
    assert_eq!(files(&desk.path("out")).0, whole);
    // A pipe and a device are written to as they are.
    let piped = desk.shell("mkfifo pipe.svg; cat pipe.svg > got.svg & \"$G\" rank motors.csv --plot pipe.svg; wait");
    assert_eq!(piped.status.code(), Some(0), "{}", said(&piped));
    assert_eq!(desk.read("got.svg"), desk.read("elsewhere/real.svg"));
    assert!(!desk.path("pipe.svg").is_file() && files(desk.0.path()).1.is_empty());
    symlink("/dev/full", desk.path("full.svg")).unwrap();
    desk.refused(&["rank", "motors.csv", "--plot", "full.svg"], &["cannot write `full.svg`: the disk is full"]);
}

/// What a killed process left behind must not stop the next one, whose number may be the same.
#[test]
fn leftovers_do_no_harm() {
    let desk = Desk::new();
    // The shell's own number is that of the program which takes its place.
    let script = "for n in 0 1 2; do echo half > .out.svg.$$-$n.part; done; echo half > .out.svg.$$.part; \
                  exec \"$G\" rank motors.csv --plot out.svg";
    let output = desk.shell(script);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(desk.read("out.svg").ends_with("</svg>\n"));
    assert_eq!(files(desk.0.path()).1.len(), 4, "what others left stays");
    // In a folder of catalogues they are no catalogues.
    desk.write("shelf/motors.csv", MOTORS.as_bytes());
    desk.write("shelf/.motors.csv.77-0.part", b"id,term");
    assert_eq!(desk.run(&["rank", "shelf"]).status.code(), Some(0));
}

/// A process and when it was begun; killed when dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn killed_at_any_moment_outputs_are_whole_or_not_there() {
    let mut rng = Pcg64::seed_from_u64(8);
    for (arguments, target) in OUTPUTS {
        let desk = Desk::for_command(arguments);
        let folder = *target == "out";
        let begun = Instant::now();
        assert!(desk.run(arguments).status.code() < Some(2));
        let takes = begun.elapsed();
        let (reference, _) = files(&desk.path(target));
        let again = [arguments, anew(arguments)].concat();
        for _ in 0..6 {
            if folder {
                fs::remove_dir_all(desk.path(target)).unwrap();
            } else if ONCE.contains(target) {
                let _ = fs::remove_file(desk.path(target));
            } else {
                desk.write(target, b"old");
            }
            let child = desk.command(&again).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            let running = Running(child);
            std::thread::sleep(takes.mul_f64(rng.random_range(0.5..1.1)));
            drop(running);
            for (name, bytes) in files(&desk.path(target)).0 {
                let journal = name.starts_with("journal");
                let whole = reference.get(&name) == Some(&bytes) || (!folder && bytes == b"old");
                assert!(whole || journal, "{arguments:?}: {} has {} bytes", name.display(), bytes.len());
            }
            fs::create_dir_all(desk.path("out")).unwrap();
        }
        if ONCE.contains(target) {
            let _ = fs::remove_file(desk.path(target));
        }
        assert!(desk.run(&again).status.code() < Some(2), "{arguments:?}");
        assert_eq!(files(&desk.path(target)).0, reference, "{arguments:?}");
    }
}

/// With too little memory a process ends where it is, with a message or without: what it writes is whole or not there. A row
/// that is added leaves the rows that were there.
#[test]
fn out_of_memory_outputs_are_whole_or_not_there() {
    for (arguments, target) in OUTPUTS {
        let desk = Desk::for_command(arguments);
        let folder = *target == "out";
        let adds = *target == "added.csv";
        let old = desk.read("motors.csv");
        let begin = || match (folder, adds) {
            (true, _) => drop(fs::remove_dir_all(desk.path(target))),
            (_, true) => desk.write(target, old.as_bytes()),
            _ if ONCE.contains(target) => drop(fs::remove_file(desk.path(target))),
            _ => desk.write(target, b"old"),
        };
        begin();
        assert!(desk.run(arguments).status.code() < Some(2), "{arguments:?}");
        let (reference, _) = files(&desk.path(target));
        let mut ended = 0;
        // In KiB, from what the program does not even begin with.
        for most in [8_000, 16_000, 32_000, 48_000, 64_000, 96_000, 128_000, 192_000, 256_000] {
            begin();
            let output = desk.shell(&format!("ulimit -v {most}; exec \"$G\" {}", arguments.join(" ")));
            let status = output.status.code();
            ended += usize::from(status.is_none_or(|status| status > 1));
            for (name, bytes) in files(&desk.path(target)).0 {
                let journal = name.starts_with("journal");
                let whole = reference.get(&name) == Some(&bytes);
                let stays = !folder && (bytes == b"old" || adds && bytes == old.as_bytes());
                assert!(
                    whole || stays || journal,
                    "{arguments:?}, {most} KiB: {} has {} bytes",
                    name.display(),
                    bytes.len()
                );
                // What is said to be done is done.
                assert!(status.is_none_or(|status| status > 1) || !stays, "{arguments:?}, {most} KiB");
            }
        }
        assert!(ended > 0, "{arguments:?}: no limit was too little");
        // And nothing that is left keeps the next call from its work.
        begin();
        assert!(desk.run(&[arguments, anew(arguments)].concat()).status.code() < Some(2), "{arguments:?}");
        assert_eq!(files(&desk.path(target)).0, reference, "{arguments:?}");
    }
}

/// Rows that are added to a catalogue while other calls are killed: every row of a call that said so is there, and no lock is left
/// that a later one would wait for.
#[test]
fn rows_that_were_added_outlive_the_calls_that_are_killed() {
    let desk = Desk::new();
    desk.write("kept.csv", MOTORS.as_bytes());
    let mut rng = Pcg64::seed_from_u64(9);
    let header = MOTORS.lines().next().unwrap();
    let mut added = Vec::new();
    let begun = Instant::now();
    let mut takes = Duration::ZERO;
    for k in 0..24 {
        let id = format!("row-{k}");
        let row = MOTORS.lines().nth(1).unwrap().replace("alpha-1", &id);
        desk.write(&format!("{id}.csv"), format!("{header}\n{row}\n").as_bytes());
        let add = ["catalog", "add", &format!("{id}.csv"), "--to", "kept.csv"];
        let child = desk.command(&add).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let mut running = Running(child);
        if k == 0 {
            assert_eq!(running.0.wait().unwrap().code(), Some(0));
            takes = begun.elapsed();
            added.push(id);
            continue;
        }
        std::thread::sleep(takes.mul_f64(rng.random_range(0.3..1.2)));
        if running.0.try_wait().unwrap().is_some_and(|status| status.success()) {
            added.push(id);
        }
        drop(running);
        let text = desk.read("kept.csv");
        assert!(text.starts_with(MOTORS) && text.ends_with('\n'), "{text}");
        assert!(added.iter().all(|id| text.contains(&format!("\n{id},"))), "{added:?}\n{text}");
    }
}

/// A file that is rewritten all the time is read as one or the other, or refused; as a mixture never. (A writer that
/// stops half way through a file that it overwrites without cutting it off leaves a mixture that nobody can tell from
/// a file; what changes in place while it is read is tried in `crates/model/src/input/file.rs`.)
#[test]
fn a_file_that_changes_is_never_read_as_a_mixture() {
    let desk = Desk::new();
    let table = |value: u32| {
        let row = |k: u32| format!("{}.{:03},{value}.5,{value}\n", 100 + k / 1000, k % 1000);
        "t,i,tau\n".to_string() + &(0..20_000).map(row).collect::<String>()
    };
    let (old, new) = (table(1), table(2));
    let path = desk.path("log.csv");
    fs::write(&path, &old).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let writer = {
        let (stop, path, old, new) = (stop.clone(), path.clone(), old.clone(), new.clone());
        std::thread::spawn(move || {
            let mut k = 0_u64;
            while !stop.load(Ordering::Relaxed) {
                k += 1;
                let text = if k.is_multiple_of(2) { &old } else { &new };
                if k % 3 < 2 {
                    fs::write(&path, text).unwrap();
                } else {
                    let beside = path.with_extension("new");
                    fs::write(&beside, text).unwrap();
                    fs::rename(beside, &path).unwrap();
                }
                std::thread::sleep(Duration::from_micros(k % 7 * 700));
            }
        })
    };
    let (mut whole, mut refused) = (0, 0);
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(3) {
        match Source::read(&path) {
            Ok(source) => {
                // Cut off by truncation that was over before it was opened: what stood there then, and no mixture.
                let part = |text: &str| text.starts_with(source.text());
                assert!(part(&old) || part(&new), "a mixture");
                whole += usize::from(source.text().len() == old.len());
            }
            Err(error) => {
                assert!(error.to_string().contains("was changed while it was read"), "{error}");
                refused += 1;
            }
        }
    }
    // The reader of logs goes another way: a stream.
    let (mut logs, mut changed) = (0, 0);
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(3) {
        match measured::read::read_for_row(&desk.path("bench.toml"), None, Vec::new()) {
            Ok(bench) => {
                let torque = bench.logs[0].channels.values().next_back().unwrap();
                assert!(torque.iter().all(|t| (t - torque[0]).abs() < 1e-12), "a mixture");
                logs += 1;
            }
            Err(errors) => {
                let text = errors.iter().map(ToString::to_string).collect::<String>();
                let known = ["was changed while", "is empty", "cells, the header", "rows", "number"];
                assert!(known.iter().any(|k| text.contains(k)), "{text}");
                changed += 1;
            }
        }
    }
    stop.store(true, Ordering::Relaxed);
    writer.join().unwrap();
    println!("{whole} whole, {refused} refused; logs {logs} whole, {changed} refused");
    assert!(whole > 0 && refused > 0 && logs > 0 && changed > 0, "{whole} {refused} {logs} {changed}");
}

/// Commands that read, and the file of each kind that they read.
const READERS: &[(&[&str], &str)] = &[
    (&["optimize", "robot.toml", "--catalog", "motors.csv"], "robot.toml"),
    (&["optimize", "robot.toml", "--catalog", "motors.csv"], "knee.csv"),
    (&["optimize", "robot.toml", "--catalog", "motors.csv"], "motors.csv"),
    (&["check", "design.toml"], "design.toml"),
    (&["check", "design.toml", "--rules", "rules.toml"], "rules.toml"),
    (&["study", "study.toml", "--out", "out", "--catalog", "motors.csv", "--force"], "study.toml"),
    (&["torques", "model.urdf", "trajectory.csv"], "model.urdf"),
    (&["torques", "model.urdf", "trajectory.csv"], "trajectory.csv"),
    (&["export", "design.toml", "--into", "model.urdf", "--map", "knee=elbow"], "model.urdf"),
    (&["characterize", "bench.toml"], "bench.toml"),
    (&["characterize", "bench.toml"], "log.csv"),
];

#[test]
fn no_file_at_all_is_one_clear_error_and_never_waits() {
    for (arguments, input) in READERS {
        let desk = Desk::new();
        let good = fs::read(desk.path(input)).unwrap();
        let spoil = |make: &dyn Fn(&Path), parts: &[&str]| {
            fs::remove_file(desk.path(input)).unwrap();
            make(&desk.path(input));
            let text = desk.refused(arguments, parts);
            assert!(!text.contains("os error"), "{arguments:?}: {text}");
            let _ = fs::remove_file(desk.path(input)).or_else(|_| fs::remove_dir_all(desk.path(input)));
            desk.write(input, &good);
        };
        let pipe = |path: &Path| assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
        spoil(&|_| (), &["there is no"]);
        if !(arguments[0] == "optimize" && *input == "motors.csv") {
            spoil(&|p| fs::create_dir(p).unwrap(), &["folder"]);
        }
        spoil(&pipe, &["this is a named pipe, not a file"]);
        spoil(&|p| symlink("/dev/zero", p).unwrap(), &["this is a device, not a file"]);
        spoil(
            &|p| symlink("circle", p.with_file_name("circle")).and_then(|()| symlink("circle", p)).unwrap(),
            &["circle"],
        );
        let _ = fs::remove_file(desk.path("circle"));
        // No rule at all is what rules may be.
        if *input != "rules.toml" {
            spoil(&|p| fs::write(p, "").unwrap(), &[]);
        }
        let most = if input.ends_with(".csv") { limits::TABLE_BYTES } else { limits::TEXT_BYTES };
        let (most, told) = match *input {
            "log.csv" => (limits::LOG_BYTES, "at most 4 GiB are read"),
            name if name.ends_with(".csv") => (most, "at most 512 MiB are read"),
            _ => (most, "at most 64 MiB are read"),
        };
        // A file with nothing in it but its length.
        spoil(&|p| File::create(p).unwrap().set_len(most + 1).unwrap(), &[told]);
        let wide = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        let text = String::from_utf8(good.clone()).unwrap();
        spoil(&|p| fs::write(p, wide(&text)).unwrap(), &["UTF-16", "save it as UTF-8", "1 mistake in 1 file"]);
        let marked = [b"\xff\xfe".to_vec(), wide(&text)].concat();
        spoil(&|p| fs::write(p, &marked).unwrap(), &["UTF-16", "1 mistake in 1 file"]);
    }
}

/// Line ends of Windows and a byte order mark, in every kind of file.
#[test]
fn line_ends_and_marks_change_nothing() {
    for (arguments, input) in READERS.iter().filter(|(a, _)| a[0] != "study") {
        let desk = Desk::new();
        let before = desk.run(arguments);
        let text = desk.read(input);
        desk.write(input, format!("\u{feff}{}", text.replace('\n', "\r\n")).as_bytes());
        let after = desk.run(arguments);
        let shown = |o: &Output| String::from_utf8_lossy(&o.stdout).replace("\r\n", "\n").replace('\u{feff}', "");
        assert_eq!(
            (before.status.code(), shown(&before)),
            (after.status.code(), shown(&after)),
            "{arguments:?} {input}"
        );
        assert!(before.status.code() < Some(2) && !before.stdout.is_empty());
    }
}

#[test]
fn decimal_commas_are_named_once() {
    let desk = Desk::new();
    let german = |text: &str| text.replace(',', ";").replace('.', ",");
    for (arguments, input) in READERS.iter().filter(|(_, input)| input.ends_with(".csv")) {
        let good = desk.read(input);
        desk.write(input, german(&good).as_bytes());
        let text = desk.refused(arguments, &["separated by semicolons", "points in numbers", "1 mistake in 1 file"]);
        assert!(text.len() < 900, "{text}");
        // Quoted: the number itself is at fault, and says so.
        let row = good.lines().nth(3).unwrap();
        let spoilt = row.split(',').map(|c| if c.parse::<f64>().is_ok() { "\"1,5\"" } else { c });
        desk.write(input, good.replace(row, &spoilt.collect::<Vec<_>>().join(",")).as_bytes());
        desk.refused(arguments, &["decimal point"]);
        // Not quoted: every row has too many cells, which is one mistake.
        let commas: Vec<String> = good
            .lines()
            .enumerate()
            .map(|(k, line)| if k == 0 { line.to_string() } else { line.replace('.', ",") })
            .collect();
        if *input == "knee.csv" || *input == "log.csv" {
            desk.write(input, commas.join("\n").as_bytes());
            desk.refused(arguments, &["cells, the header has 3", "decimal point"]);
        }
        desk.write(input, good.as_bytes());
    }
    desk.write("robot.toml", ROBOT.replace("\"48 V\"", "\"48,5 V\"").as_bytes());
    desk.refused(READERS[0].0, &["`48,5 V` has a decimal comma", "48.5 V", "1 mistake"]);
    desk.write("robot.toml", ROBOT.replace("max = 30", "max = 30,5").as_bytes());
    desk.refused(READERS[0].0, &["numbers have a decimal point, not a comma"]);
}

#[test]
fn names_with_spaces_and_letters_of_any_script_are_names() {
    let desk = Desk::new();
    let home = "Mein Röboter (v2)/прив од";
    let place = |name: &str| format!("{home}/{name}");
    let (bench, log) = bench();
    desk.write(&place("ro bot ☃.toml"), ROBOT.replace("knee.csv", "Bewe gung/ü 'k'.csv").as_bytes());
    desk.write(&place("Bewe gung/ü 'k'.csv"), motion().as_bytes());
    desk.write(&place("mo toren.csv"), MOTORS.as_bytes());
    desk.write(&place("Prüf stand.toml"), bench.replace("log.csv", "Mess ung/№ 1.csv").as_bytes());
    desk.write(&place("Mess ung/№ 1.csv"), log.as_bytes());
    desk.write(&place("Regeln ß.toml"), RULES.as_bytes());
    let study =
        "requirements = [\"ro bot*.toml\"]\ncatalog = [\"mo toren.csv\"]\n[grid]\n\"bus.voltage\" = [\"24 V\"]\n";
    desk.write(&place("Stu die.toml"), study.as_bytes());
    let (robot, motors) = (place("ro bot ☃.toml"), place("mo toren.csv"));
    let outputs = ["o ü.html", "o ü.svg", "Ent wurf.toml"].map(place);
    let design = place("Ent wurf.toml");
    for arguments in [
        &[
            "optimize",
            &robot,
            "--catalog",
            &motors,
            "--html",
            &outputs[0],
            "--plot",
            &outputs[1],
            "--write-design",
            &design,
        ][..],
        &[
            "check",
            &design,
            "--rules",
            &place("Regeln ß.toml"),
            "--junit",
            &place("j ü.xml"),
            "--sarif",
            &place("s ü.sarif"),
        ],
        &["check", &design, "--lock"],
        &["export", &design, "--to", "json", "--out", &place("ex port.json")],
        &["characterize", &place("Prüf stand.toml"), "--plot", &place("c ü.svg")],
        &["study", &place("Stu die.toml"), "--out", &place("Ergeb nis ☃")],
        &["torques", "model.urdf", "trajectory.csv", "--out", &place("Mo mente")],
        &["import", "mgdb", "db", "--out", &place("Kata log")],
        #[cfg(feature = "packaging")]
        &["man", "--out", &place("ma n")],
    ] {
        let output = desk.run(arguments);
        assert!(output.status.code() < Some(2), "{arguments:?}: {}", said(&output));
    }
    for made in ["o ü.html", "o ü.svg", "j ü.xml", "s ü.sarif", "ex port.json", "c ü.svg", "Ergeb nis ☃/results.csv"]
    {
        assert!(desk.path(&place(made)).is_file(), "{made}");
    }
    // What was read is found again by its name: the study says its inputs, and resumes.
    let inputs = desk.read(&place("Ergeb nis ☃/inputs.csv"));
    assert!(inputs.contains("ü 'k'.csv"), "{inputs}");
    let again = desk.run(&["study", &place("Stu die.toml"), "--out", &place("Ergeb nis ☃"), "--resume"]);
    assert_eq!(again.status.code(), Some(0), "{}", said(&again));
}

/// Through a link files are looked for beside the link, as with any other path.
#[test]
fn links_to_inputs_are_followed() {
    let desk = Desk::new();
    fs::create_dir_all(desk.path("desk")).unwrap();
    let plain = desk.run(&["optimize", "robot.toml", "--catalog", "motors.csv", "--json"]);
    for name in ["robot.toml", "knee.csv", "motors.csv"] {
        symlink(format!("../{name}"), desk.path(&format!("desk/{name}"))).unwrap();
    }
    let linked = desk.run(&["optimize", "desk/robot.toml", "--catalog", "desk/motors.csv", "--json"]);
    assert_eq!(plain.stdout, linked.stdout);
    fs::remove_file(desk.path("desk/knee.csv")).unwrap();
    desk.refused(
        &["optimize", "desk/robot.toml", "--catalog", "motors.csv"],
        &["desk/robot.toml", "there is no such file"],
    );
    // A pipe of the shell is read, once.
    let script = "exec bash -c '\"$G\" rank <(cat motors.csv) --json'";
    if Command::new("bash").arg("--version").output().is_ok() {
        let piped = desk.shell(script);
        assert_eq!(piped.stdout, desk.run(&["rank", "motors.csv", "--json"]).stdout, "{}", said(&piped));
    }
}

/// Names that a spreadsheet would run, wherever names come from, in every CSV that is written.
#[test]
fn no_cell_of_any_csv_is_run_by_a_spreadsheet() {
    let desk = Desk::new();
    let evil = ["=cmd|' /C calc'!A0", "+1+1", "-2+3", "@SUM(1)", "=HYPERLINK(\"http://x\")", "－1"];
    let joint = ROBOT.split("[[joint]]").nth(1).unwrap();
    let head = ROBOT.split("[[joint]]").next().unwrap().replace("\"leg\"", "\"=1+1\"");
    let joints: String =
        evil.iter().map(|e| format!("[[joint]]{}", joint.replace("\"knee\"", &format!("'''{e}'''")))).collect();
    desk.write("=robot.toml", format!("{head}{joints}").as_bytes());
    let cells = MOTORS.replace("made up for a test", "=1+1").replace("alpha-1", "-alpha");
    desk.write("-motors.csv", cells.as_bytes());
    desk.write("@study.toml", "requirement = \"=robot.toml\"\ncatalog = [\"-motors.csv\"]\n".as_bytes());
    let model = MODEL.replace("elbow", "=elbow+1").replace("\"tip\"", "\"@tip\"");
    desk.write("evil.urdf", model.as_bytes());
    desk.write("evil.csv", desk.read("trajectory.csv").replace("elbow", "=elbow+1").as_bytes());
    let mut texts = Vec::new();
    for arguments in [
        &["optimize", "=robot.toml", "--catalog", "./-motors.csv", "--csv"][..],
        &["optimize", "=robot.toml", "--catalog", "./-motors.csv", "--csv", "--robust"],
        &["optimize", "=robot.toml", "--catalog", "./-motors.csv", "--csv", "--pareto", "loss,mass"],
        &["sweep", "=robot.toml", "--catalog", "./-motors.csv", "--csv", "--ratios", "3"],
        &["rank", "./-motors.csv", "--csv"],
        &["audit", "./-motors.csv", "--csv"],
        &["torques", "evil.urdf", "evil.csv", "--csv", "--out", "motions"],
        &["import", "mgdb", "db", "--out", "catalog", "--csv"],
        &["characterize", "bench.toml", "--csv"],
    ] {
        let output = desk.run(arguments);
        assert!(output.status.code() < Some(2), "{arguments:?}: {}", said(&output));
        texts.push((format!("{arguments:?}"), String::from_utf8(output.stdout).unwrap()));
    }
    let study = desk.run(&["study", "@study.toml", "--out", "result"]);
    assert!(study.status.code() < Some(2), "{}", said(&study));
    for folder in ["result", "catalog", "motions"] {
        for (name, bytes) in files(&desk.path(folder)).0 {
            if name.extension().is_some_and(|e| e == "csv") {
                texts.push((name.display().to_string(), String::from_utf8(bytes).unwrap()));
            }
        }
    }
    let (mut guards, mut cells) = (0, 0);
    for (what, text) in &texts {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        for cell in reader.records().flat_map(|r| r.unwrap().iter().map(String::from).collect::<Vec<_>>()) {
            cells += 1;
            let runs =
                cell.trim_start().starts_with(['=', '+', '-', '@', '－']) || cell.starts_with(['\t', '\r', '\n']);
            assert!(!runs || cell.parse::<f64>().is_ok(), "{what}: {cell:?}");
            guards += usize::from(cell.starts_with("'=") || cell.starts_with("'-") || cell.starts_with("'@"));
        }
    }
    println!("{} tables, {cells} cells, {guards} guarded", texts.len());
    assert!(texts.len() > 12 && guards > 60);
    // What we wrote is read back as what it was.
    let torques = desk.run(&["torques", "evil.urdf", "evil.csv", "--json"]);
    let guarded_header = desk.read("evil.csv").replace("=elbow", &guarded("=elbow"));
    desk.write("evil.csv", guarded_header.as_bytes());
    assert_eq!(desk.run(&["torques", "evil.urdf", "evil.csv", "--json"]).stdout, torques.stdout);
    let resumed = desk.run(&["study", "@study.toml", "--out", "result", "--resume"]);
    assert!(said(&resumed).contains("finished already") || resumed.status.code() == Some(0), "{}", said(&resumed));
    let rank = desk.run(&["rank", "./-motors.csv", "--json"]);
    desk.write("-motors.csv", cells_guarded(&cells_of(&desk.read("-motors.csv"))).as_bytes());
    assert!(desk.read("-motors.csv").contains("'-alpha") && desk.read("-motors.csv").contains("'=1+1"));
    assert_eq!(desk.run(&["rank", "./-motors.csv", "--json"]).stdout, rank.stdout);
}

fn cells_of(text: &str) -> Vec<Vec<String>> {
    text.lines().map(|line| line.split(',').map(String::from).collect()).collect()
}

fn cells_guarded(rows: &[Vec<String>]) -> String {
    let row = |row: &Vec<String>| row.iter().map(|c| guarded(c).into_owned()).collect::<Vec<_>>().join(",");
    rows.iter().map(|r| row(r) + "\n").collect()
}

/// Letters that would clear a screen, or type a command, stand in files: they do not come out again.
#[test]
fn no_text_of_a_file_drives_the_terminal() {
    let desk = Desk::new();
    let motors = MOTORS.replacen("terminals", "manufacturer,model,terminals", 1);
    let mut rows = motors.lines().enumerate().map(|(k, line)| {
        if k == 0 { line.to_string() } else { line.replacen(',', ",A\u{1b}[2JB,\u{9b}31mC\u{7},", 1) }
    });
    let text = rows.by_ref().collect::<Vec<_>>().join("\n").replace("made up", "made\u{1b}]0;up");
    desk.write("motors.csv", text.as_bytes());
    let bad = |c: char| c.is_control() && !['\n', '\t', '\r'].contains(&c);
    for arguments in [
        &["rank", "motors.csv"][..],
        &["rank", "motors.csv", "--csv"],
        &["rank", "motors.csv", "--json"],
        &["audit", "motors.csv"],
        &["compare", "alpha-1", "beta-2", "--catalog", "motors.csv"],
        &["explain", "alpha-1", "robot.toml", "--catalog", "motors.csv"],
        &["optimize", "robot.toml", "--catalog", "motors.csv", "--html", "out.html"],
        &["export", "design.toml", "--to", "mjcf"],
    ] {
        let output = desk.run(arguments);
        assert!(output.status.code() < Some(2), "{}", said(&output));
        let shown = String::from_utf8_lossy(&output.stdout);
        assert!(!shown.contains(bad) && !said(&output).contains(bad), "{arguments:?}");
    }
    assert!(!desk.read("out.html").contains(bad));
    desk.write(
        "robot.toml",
        ROBOT.replace("\"48 V\"", "\"48 \u{1b}[31mV\"").replace("count", "co\u{1b}[2Junt").as_bytes(),
    );
    desk.write("motors.csv", text.replace("0.09", "0.0\u{1b}[5m9").as_bytes());
    for arguments in [
        &["optimize", "robot.toml", "--catalog", "motors.csv"][..],
        &["rank", "motors.csv"],
        &["rank", "no\u{1b}[2Jwhere.csv"],
        &["rank", "motors.csv", "--plot", "no\u{1b}[2J/x.svg"],
    ] {
        assert!(!desk.refused(arguments, &["error"]).contains(bad), "{arguments:?}");
    }
}

#[test]
fn what_is_too_much_is_refused_with_the_limit() {
    let desk = Desk::new();
    let joint = "[[joint]]\nname = \"j#\"\nratio = { min = 3, max = 30 }\npoints = [{ torque = \"1 N*m\", speed = \"1 rad/s\" }]\n";
    let head = ROBOT.split("[[joint]]").next().unwrap();
    let joints = |count: usize| -> String { (0..count).map(|k| joint.replace('#', &k.to_string())).collect() };
    desk.write("many.toml", format!("{head}{}", joints(limits::JOINTS + 1)).as_bytes());
    let many = ["optimize", "many.toml", "--catalog", "motors.csv"];
    desk.refused(&many, &["10001 joints are more than can be taken: at most 10000", "several requirements"]);
    for text in [format!("a = {}1{}", "[".repeat(100_000), "]".repeat(100_000)), format!("[{}a]", "a.".repeat(100_000))]
    {
        desk.write("deep.toml", text.as_bytes());
        desk.refused(&["optimize", "deep.toml", "--catalog", "motors.csv"], &["recurs"]);
    }
    let body = |depth: usize| {
        format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", "<body>".repeat(depth), "</body>".repeat(depth))
    };
    desk.write("deep.xml", body(100_000).as_bytes());
    desk.refused(&["torques", "deep.xml", "trajectory.csv"], &["deep.xml", "at most 200"]);
    let values: Vec<String> = (0..40_000).map(|k| format!("{k}.5")).collect();
    let list = format!("[{}]", values.join(","));
    let study = format!("requirement = \"robot.toml\"\n[grid]\n\"scale.torque\" = {list}\n\"scale.speed\" = {list}\n");
    desk.write("study.toml", study.as_bytes());
    let text = desk.refused(&["study", "study.toml", "--out", "out"], &["more than 1000000000 points", "fewer values"]);
    assert!(!desk.path("out").exists(), "{text}");
    // Joints that differ have a panel each.
    let lasts = joint.replace("\"1 rad/s\"", "\"1 rad/s\", duration = \"1 s\"");
    let different = |k: usize| lasts.replace("\"1 N*m\"", &format!("\"{} N*m\"", k + 100));
    let different = |k: usize| different(k).replace('#', &k.to_string()).replace(" N*m", "e-2 N*m");
    let tall: String = (0..400).map(different).collect();
    desk.write("tall.toml", format!("{head}{tall}").as_bytes());
    if cfg!(feature = "png") {
        let tall = ["optimize", "tall.toml", "--catalog", "motors.csv", "--plot", "tall.png"];
        desk.refused(&tall, &["pixels are more than 67108864", "draw an .svg"]);
        assert!(!desk.path("tall.png").exists());
    }
    let mut rows = "time [s],elbow [rad]\n".to_string();
    (0..=limits::TABLE_ROWS).for_each(|k| rows.push_str(if k % 2 == 0 { "0,0\n" } else { "1,0\n" }));
    desk.write("trajectory.csv", rows.as_bytes());
    desk.refused(&["torques", "model.urdf", "trajectory.csv"], &["more than 2000000 rows", "split the file"]);
}

#[test]
fn a_study_of_nothing_leaves_nothing() {
    let desk = Desk::new();
    for (arguments, why) in [
        (&["study", "nowhere/*.toml", "--out", "out"][..], "no file matches"),
        (&["study", "nowhere.toml", "--out", "out"], "nowhere.toml"),
        (&["study", "db", "--out", "out"], "db"),
    ] {
        desk.refused(arguments, &[why]);
        assert!(!desk.path("out").exists(), "{arguments:?}");
    }
    // A folder that was there stays, with what is in it.
    fs::create_dir(desk.path("mine")).unwrap();
    desk.write("mine/notes.txt", b"mine");
    desk.refused(&["study", "nowhere/*.toml", "--out", "mine"], &["no file matches"]);
    assert_eq!(desk.read("mine/notes.txt"), "mine");
}
