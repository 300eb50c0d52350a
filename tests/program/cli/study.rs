//! Studies of many robots: the same bytes however they came about, and nothing finished is ever lost.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use rand::{RngExt, SeedableRng};
use tempfile::TempDir;

const MOTORS: &str = "id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],pole_pairs,continuous_torque [N*m],source,source_kind
alpha-1,line_to_line,dc,0.5,0.2,0.05,300,200,7,9,a sheet,datasheet
alpha-2,line_to_line,dc,0.7,0.3,0.06,320,210,7,9,a sheet,datasheet
beta-1,line_to_line,dc,0.2,0.1,0.09,900,500,14,9,a sheet,datasheet
beta-2,line_to_line,dc,0.1,0.1,0.08,700,450,14,9,a sheet,datasheet
gamma-1,line_to_line,dc,2.5,0.9,0.03,40,90,4,9,a sheet,datasheet
";

const MOTION: &str = "time [s], torque [N*m], velocity [rad/s]
0,    1.0,  0.5
0.1,  2.0,  1.5
0.2,  1.5,  0.2
0.3, -0.5, -1.0
0.4,  1.0,  0.5
";

/// A leg whose knee does the motion and whose hip holds a torque.
fn leg(name: &str, torque: f64) -> String {
    format!(
        r#"name = "{name}"
[bus]
voltage = "48 V"
drive_current = "40 A"

[[joint]]
name = "knee"
count = 2
ratio = {{ min = 3, max = 30 }}
motor_drag = "off"
gear = {{ efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2" }}
motion = "knee.csv"
[joint.limits]
reflected_inertia = "0.02 kg*m^2"
safety = 1.2

[[joint]]
name = "hip"
ratio = {{ min = 3, max = 30 }}
motor_drag = "off"
points = [
    {{ torque = "{torque} N*m", speed = "0 rad/s", duration = "1 s" }},
    {{ torque = "0.5 N*m", speed = "6 rad/s", duration = "1 s" }},
]
"#
    )
}

const STUDY: &str = r#"requirement = "base.toml"
catalog = ["motors.csv"]

[grid]
"bus.voltage" = ["24 V", "48 V"]
"joint.knee.gear.efficiency" = [0.85, 0.95]
"scale.torque" = { from = 0.5, to = 2, steps = 7 }
"scale.speed" = [1, 1.5, 40]
"#;

/// A folder with a base requirement, a study of 84 robots, and a folder of 30 robots.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("motors.csv", MOTORS);
    write("knee.csv", MOTION);
    write("base.toml", &leg("leg", 4.0));
    write("study.toml", STUDY);
    fs::create_dir(folder.path().join("robots")).unwrap();
    write("robots/knee.csv", MOTION);
    for k in 0..30 {
        write(&format!("robots/leg_{k:02}.toml"), &leg(&format!("leg {k}"), 1.0 + 0.3 * f64::from(k)));
    }
    folder
}

fn command(at: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
    command.args(arguments).current_dir(at);
    command
}

fn run(at: &Path, arguments: &[&str]) -> Output {
    command(at, arguments).output().unwrap()
}

/// Runs it; it must end with this status. What it says on stderr.
fn ends(at: &Path, arguments: &[&str], status: i32) -> String {
    let output = run(at, arguments);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {stderr}");
    stderr
}

/// Every file of a finished study. No other may be left.
fn results(out: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(out).unwrap().map(|e| e.unwrap().path());
    let name = |p: &Path| p.file_name().unwrap().to_str().unwrap().to_string();
    let files: BTreeMap<String, Vec<u8>> = entries
        .filter(|p| name(p) != ".study.lock" && name(p) != "journal")
        .map(|p| (name(&p), fs::read(&p).unwrap()))
        .collect();
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    let expected = ["errors.csv", "inputs.csv", "manifest.json", "results.csv", "summary.json", "summary.svg"];
    assert_eq!(
        names.iter().filter(|n| **n != "results.parquet").copied().collect::<Vec<_>>(),
        expected,
        "{}",
        out.display()
    );
    assert_eq!(names.contains(&"results.parquet"), cfg!(feature = "parquet"));
    files
}

/// The rows of the results, each as column to cell.
fn rows(out: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(out.join("results.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let row = |r: csv::StringRecord| header.iter().zip(r.iter()).map(|(h, c)| (h.into(), c.into())).collect();
    reader.records().map(|r| row(r.unwrap())).collect()
}

fn same(a: &BTreeMap<String, Vec<u8>>, b: &BTreeMap<String, Vec<u8>>, what: &str) {
    for (name, bytes) in a {
        assert!(bytes == &b[name], "{what}: {name} differs");
    }
}

#[test]
fn a_grid_is_every_combination_and_each_is_what_optimize_says_of_it() {
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "study.toml", "--out", "out", "--top", "2"], 0);
    let rows = rows(&at.join("out"));
    let robots: std::collections::BTreeSet<u64> = rows.iter().map(|r| r["robot"].parse().unwrap()).collect();
    assert_eq!(robots.into_iter().collect::<Vec<_>>(), (0..84).collect::<Vec<_>>());
    // One of them by hand: 24 V, efficiency 0.95, torque times 1.75, played 1.5 times as fast.
    let by_hand = leg("leg", 4.0 * 1.75)
        .replace("48 V", "24 V")
        .replace("knee.csv", "fast.csv")
        .replace("0.5 N*m", "0.875 N*m")
        .replace("6 rad/s", "9 rad/s")
        .replace("1 s", &format!("{} s", 1.0 / 1.5));
    let fast: String = MOTION
        .lines()
        .enumerate()
        .map(|(k, line)| {
            if k == 0 {
                return format!("{line}\n");
            }
            let cells: Vec<f64> = line.split(',').map(|c| c.trim().parse().unwrap()).collect();
            format!("{},{},{}\n", cells[0] / 1.5, cells[1] * 1.75, cells[2] * 1.5)
        })
        .collect();
    fs::write(at.join("fast.csv"), fast).unwrap();
    fs::write(at.join("hand.toml"), by_hand).unwrap();
    let output = run(at, &["optimize", "hand.toml", "--catalog", "motors.csv", "--json"]);
    let optimum: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let mut compared = 0;
    for row in &rows {
        let cell = |name: &str| row[name].parse::<f64>().unwrap();
        let here = cell("grid_bus_voltage_v") == 24.0
            && cell("grid_joint_knee_gear_efficiency") == 0.95
            && cell("grid_scale_torque") == 1.75
            && cell("grid_scale_speed") == 1.5;
        if !here {
            continue;
        }
        let joint = optimum["joints"].as_array().unwrap().iter().find(|j| j["joint"] == row["joint"]).unwrap();
        let place = row["rank"].parse::<usize>().unwrap() - 1;
        let candidate = &joint["candidates"][place];
        assert_eq!(candidate["motor"], row["motor"]);
        // The fast motion is differentiated again here, and only scaled there.
        for (column, key) in [("ratio", "ratio"), ("loss_w", "loss_w"), ("mass_kg", "mass_kg")] {
            let (a, b) = (cell(column), candidate[key].as_f64().unwrap());
            assert!((a - b).abs() <= 1e-6 * b.abs(), "{column}: {a} {b}");
        }
        compared += 1;
    }
    assert_eq!(compared, 4, "two joints, two designs each");
    // A joint that no motor can do has one row that says why.
    let none: Vec<_> = rows.iter().filter(|r| r["rank"].is_empty()).collect();
    assert!(!none.is_empty(), "at forty times the speed nothing can");
    assert!(none.iter().all(|r| r["because"].contains("motors: ") && r["motor"].is_empty()));
}

/// A leg whose hip carries the knee's actuators, under budgets.
fn whole(name: &str) -> String {
    let carries = "torque_per_mass = { knee = \"1.5 N*m/kg\" }";
    let text = leg(name, 4.0).replace("name = \"hip\"\n", &format!("name = \"hip\"\n{carries}\n"));
    text.replace("motor_drag = \"off\"", "motor_drag = \"off\"\nobjective = \"loss\"")
        + "[budget]\nmax_distinct_motors = 1\n"
}

#[test]
fn whole_robots_are_what_optimize_says_of_them() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("whole.toml"), whole("whole")).unwrap();
    let study = STUDY.replace("base.toml", "whole.toml");
    fs::write(at.join("study.toml"), study).unwrap();
    let said = run(at, &["study", "study.toml", "--out", "one", "--top", "2", "--threads", "1"]);
    let said = String::from_utf8(said.stdout).unwrap();
    // What the robots lack is a combination: of motors nothing is said.
    assert!(said.contains("no combination of all joints was found") && !said.contains("no motor"), "{said}");
    ends(at, &["study", "study.toml", "--out", "two", "--top", "2", "--threads", "2"], 0);
    same(&results(&at.join("one")), &results(&at.join("two")), "two threads");
    let rows = rows(&at.join("one"));
    let (mut with, mut without) = (0, 0);
    for set in rows.chunk_by(|a, b| a["robot"] == b["robot"]).step_by(5) {
        let first = &set[0];
        let scale = |key: &str| format!("scale.{key}={}", first[&format!("grid_scale_{key}")]);
        let mut arguments = vec!["optimize".into(), "whole.toml".into(), "--catalog".into(), "motors.csv".into()];
        let voltage = format!("bus.voltage={} V", first["grid_bus_voltage_v"]);
        let efficiency = format!("joint.knee.gear.efficiency={}", first["grid_joint_knee_gear_efficiency"]);
        for value in [voltage, efficiency, scale("torque"), scale("speed")] {
            arguments.extend(["--set".into(), value]);
        }
        arguments.extend(["--runner-ups".into(), "1".into(), "--json".into()]);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = run(at, &arguments);
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let (best, of) =
            (&json["robot"]["choice"]["best"], |row: &BTreeMap<String, String>, key: &str| row[key].clone());
        if best.is_null() {
            assert!(set.len() == 2 && of(first, "because").to_lowercase().contains("no "), "{first:?}");
            assert_eq!(of(first, "robot_total"), "");
            without += 1;
            continue;
        }
        with += 1;
        for (joint, row) in best["joints"].as_array().unwrap().iter().zip(set.iter().filter(|r| r["rank"] == "1")) {
            assert_eq!(joint["motor"], of(row, "motor"));
            assert_eq!(best["objective"].as_f64(), of(row, "robot_total").parse().ok());
            assert_eq!(of(row, "robot_proof"), "proved");
            assert_eq!(of(row, "robot_total_is"), "loss [W]");
        }
    }
    assert!(with > 2 && without > 0, "{with} with, {without} without");
    // Phases matter where joints share something alone.
    let quadruped = crate::common::repository("requirements/quadruped_mini_cheetah.toml");
    let phases = format!(
        "requirement = {quadruped:?}\ncatalog = [\"motors.csv\"]\n[grid]\n\"joint.knee.phases\" = [[0, 0, 0, 0], [0, 0.5, 0.5, 0]]\n"
    );
    fs::write(at.join("phases.toml"), phases).unwrap();
    let said = ends(at, &["study", "phases.toml", "--out", "phases"], 1);
    assert!(said.contains("`joint.knee.phases` of [grid] would change nothing"), "{said}");
    // All designs of a whole robot are not found.
    let said = ends(at, &["study", "study.toml", "--out", "all", "--all"], 1);
    assert!(said.contains("`--top`"), "{said}");
}

#[test]
fn threads_shards_and_order_do_not_change_a_byte() {
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "study.toml", "--out", "one", "--threads", "1"], 0);
    let one = results(&at.join("one"));
    for threads in ["2", "8"] {
        ends(at, &["study", "study.toml", "--out", threads, "--threads", threads], 0);
        same(&one, &results(&at.join(threads)), threads);
    }
    for shard in ["3", "1", "2"] {
        ends(at, &["study", "study.toml", "--out", &format!("part{shard}"), "--shard", &format!("{shard}/3")], 0);
    }
    ends(at, &["merge", "merged", "part2", "part3", "part1"], 0);
    same(&one, &results(&at.join("merged")), "merged");
}

#[test]
fn shards_that_do_not_belong_together_are_refused_by_name() {
    let folder = folder();
    let at = folder.path();
    for shard in 1..=2 {
        ends(at, &["study", "study.toml", "--out", &format!("p{shard}"), "--shard", &format!("{shard}/3")], 0);
    }
    let refused = |arguments: &[&str], what: &str| {
        let stderr = ends(at, arguments, 2);
        assert!(stderr.contains(what), "{stderr}");
        assert!(!at.join("m/results.csv").exists());
    };
    refused(&["merge", "m", "p1", "p2"], "a shard is missing: 3/3");
    refused(&["merge", "m", "p1", "p1", "p2"], "duplicate shard 1/3: `p1` and `p1`");
    refused(&["merge", "m", "p1", "robots"], "`robots` has no study");
    ends(at, &["study", "study.toml", "--out", "other", "--shard", "3/3", "--top", "5"], 0);
    refused(&["merge", "m", "p1", "p2", "other"], "`other` is a shard of another study than `p1`: it was begun with");
    ends(at, &["study", "study.toml", "--out", "half", "--shard", "1/2"], 0);
    refused(&["merge", "m", "p1", "p2", "half"], "`half` is shard 1/2, but `p1` is shard 1/3");
    ends(at, &["study", "study.toml", "--out", "p3", "--shard", "3/3"], 0);
    let block = fs::read_dir(at.join("p3/journal")).unwrap().map(|e| e.unwrap().path());
    let block = block.filter(|p| p.extension().is_some_and(|e| e == "jsonl")).max().unwrap();
    fs::remove_file(block).unwrap();
    refused(&["merge", "m", "p1", "p2", "p3"], "shard 3/3 in `p3` is not finished");
    let stderr = ends(at, &["study", "study.toml", "--out", "p3", "--shard", "3/3"], 2);
    assert!(stderr.contains("`p3` has a study that is not finished: `--resume` goes on with it"), "{stderr}");
    ends(at, &["study", "study.toml", "--out", "p3", "--shard", "3/3", "--resume"], 0);
    let stderr = ends(at, &["study", "study.toml", "--out", "p3", "--shard", "3/3"], 2);
    assert!(stderr.contains("`p3` has shard 3/3, finished: `gearwise merge` takes it, `--force` starts"), "{stderr}");
    // Each has its third of the robots, few as they are.
    let sizes: Vec<usize> = (1..=3).map(|k| robots_in(&at.join(format!("p{k}")))).collect();
    assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1, "{sizes:?}");
    ends(at, &["merge", "m", "p1", "p2", "p3"], 0);
    assert!(at.join("m/results.csv").exists());
    for wrong in ["0/3", "4/3", "1", "a/b"] {
        let stderr = ends(at, &["study", "study.toml", "--out", "w", "--shard", wrong], 2);
        assert!(stderr.contains("is not a shard; write i/n"), "{stderr}");
    }
}

#[test]
fn a_broken_robot_is_told_and_does_not_stop_the_others() {
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "robots", "--out", "good", "--catalog", "motors.csv"], 0);
    let broken = at.join("robots/leg_07.toml");
    let text = fs::read_to_string(&broken).unwrap();
    fs::write(&broken, text.replace("48 V", "48 N")).unwrap();
    let stderr = ends(at, &["study", "robots", "--out", "out", "--catalog", "motors.csv"], 1);
    assert!(stderr.contains("robot 7, `robots/leg_07.toml`"), "{stderr}");
    assert!(stderr.contains("leg_07.toml:3:11"), "{stderr}");
    let errors = fs::read_to_string(at.join("out/errors.csv")).unwrap();
    assert!(errors.contains("robots/leg_07.toml:3:11"), "{errors}");
    assert_eq!(csv::Reader::from_reader(errors.as_bytes()).records().count(), 1);
    let others: Vec<_> = rows(&at.join("good")).into_iter().filter(|r| r["robot"] != "7").collect();
    assert_eq!(others, rows(&at.join("out")));
    // Once it is mended, `--resume` does it alone, and all is as if it had never been broken.
    fs::write(&broken, text).unwrap();
    let stderr = ends(at, &["study", "robots", "--out", "out", "--catalog", "motors.csv", "--resume"], 0);
    assert!(stderr.contains("29 of 30 robots were finished before"), "{stderr}");
    same(&results(&at.join("good")), &results(&at.join("out")), "mended");
}

/// Robots that are recorded in a journal.
fn robots_in(out: &Path) -> usize {
    let entries = fs::read_dir(out.join("journal")).unwrap().map(|e| e.unwrap().path());
    let blocks = entries.filter(|p| p.extension().is_some_and(|e| e == "jsonl"));
    blocks.map(|p| fs::read_to_string(p).unwrap().lines().count()).sum()
}

fn journal_bytes(out: &Path) -> u64 {
    let entries = fs::read_dir(out.join("journal")).into_iter().flatten().flatten();
    let blocks = entries.filter(|e| e.file_name().to_string_lossy().starts_with("block-"));
    blocks.filter_map(|e| e.metadata().ok()).map(|m| m.len()).sum()
}

#[test]
fn killed_at_twenty_random_moments_it_resumes_to_the_same_bytes() {
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "study.toml", "--out", "whole"], 0);
    let whole = results(&at.join("whole"));
    ends(at, &["study", "study.toml", "--out", "size", "--shard", "1/1"], 0);
    let size = journal_bytes(&at.join("size"));
    let mut random = rand_pcg::Pcg64::seed_from_u64(6);
    let mut killed = 0;
    for round in 0..20 {
        let out = at.join(format!("killed{round}"));
        let name = out.to_str().unwrap().to_string();
        // A share of the journal, and a moment after that: also while the results are assembled.
        let reached = random.random_range(0..=size);
        let after = std::time::Duration::from_micros(random.random_range(0..4000));
        let mut child = command(at, &["study", "study.toml", "--out", &name, "--threads", "2"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        while child.try_wait().unwrap().is_none() && journal_bytes(&out) < reached {
            std::thread::sleep(std::time::Duration::from_micros(200));
        }
        std::thread::sleep(after);
        child.kill().unwrap();
        killed += u32::from(child.wait().unwrap().code().is_none());
        ends(at, &["study", "study.toml", "--out", &name, "--resume"], 0);
        same(&whole, &results(&out), &name);
        assert!(!out.join("journal").exists());
    }
    assert!(killed >= 10, "only {killed} of 20 were still at work when they were killed");
}

#[test]
fn torn_and_damaged_lines_are_done_again() {
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "robots", "--out", "whole", "--catalog", "motors.csv"], 0);
    ends(at, &["study", "robots", "--out", "part", "--catalog", "motors.csv", "--shard", "1/1"], 0);
    let damaged = |block: u32, damage: &dyn Fn(&mut Vec<u8>)| {
        let path = at.join(format!("part/journal/block-{block:08}.jsonl"));
        let mut bytes = fs::read(&path).unwrap();
        damage(&mut bytes);
        fs::write(&path, bytes).unwrap();
    };
    damaged(0, &|bytes| {
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
    });
    damaged(1, &|bytes| bytes.truncate(bytes.len() - 100));
    // A line that was being written after one that is whole.
    damaged(2, &|bytes| bytes.extend_from_within(..100));
    let again = ["study", "robots", "--out", "part", "--catalog", "motors.csv", "--shard", "1/1", "--resume"];
    let stderr = ends(at, &again, 0);
    assert!(stderr.contains("28 of 30 robots were finished before"), "{stderr}");
    ends(at, &["merge", "merged", "part"], 0);
    same(&results(&at.join("whole")), &results(&at.join("merged")), "damaged");
}

/// A limit on the size of files stands in for a full disk: a write fails in the middle either way. Blocks of
/// the shell's `ulimit -f` have 512 or 1024 bytes.
#[cfg(unix)]
#[test]
fn a_full_disk_loses_nothing_finished() {
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "study.toml", "--out", "whole"], 0);
    let whole = results(&at.join("whole"));
    let journal = 16 * 1024;
    let mut failed_at = Vec::new();
    for blocks in [8, 16, 40, 120] {
        let out = at.join(format!("full{blocks}"));
        let script = format!(
            "trap '' XFSZ; ulimit -f {blocks}; exec '{}' study study.toml --out '{}'",
            env!("CARGO_BIN_EXE_gearwise"),
            out.display()
        );
        let output = Command::new("sh").args(["-c", &script]).current_dir(at).output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        if output.status.code() == Some(2) {
            assert!(stderr.contains("cannot write"), "{stderr}");
            assert!(!out.join("manifest.json").exists() && !out.join("results.csv").exists());
            failed_at.push(journal_bytes(&out));
        }
        ends(at, &["study", "study.toml", "--out", out.to_str().unwrap(), "--resume"], 0);
        same(&whole, &results(&out), &format!("{blocks} blocks: {stderr}"));
    }
    assert!(failed_at.len() >= 2 && failed_at[0] < journal * 16, "the limits were reached: {failed_at:?}");
}

#[test]
fn changed_inputs_and_settings_are_refused() {
    let folder = folder();
    let at = folder.path();
    let study = |extra: &[&str], status| {
        let mut arguments = vec!["study", "study.toml", "--out", "out", "--shard", "1/1"];
        arguments.extend(extra);
        ends(at, &arguments, status)
    };
    study(&[], 0);
    let stderr = study(&[], 2);
    assert!(stderr.contains("`--resume` goes on with it, `--force` starts again"), "{stderr}");
    study(&["--resume"], 0);
    let stderr = study(&["--resume", "--top", "4"], 2);
    assert!(stderr.contains("it was begun with --top 3, now it is --top 4"), "{stderr}");
    let changed = |file: &str, from: &str, to: &str, says: &str| {
        let text = fs::read_to_string(at.join(file)).unwrap();
        assert!(text.contains(from));
        fs::write(at.join(file), text.replacen(from, to, 1)).unwrap();
        let stderr = study(&["--resume"], 2);
        assert!(stderr.contains(says), "{stderr}");
        fs::write(at.join(file), text).unwrap();
        study(&["--resume"], 0);
    };
    changed("knee.csv", "2.0", "2.1", "`knee.csv` has changed since robot 0 was finished with it");
    changed("base.toml", "0.02", "0.03", "`base.toml` has changed");
    changed("motors.csv", "0.05", "0.06", "the catalogue is another: `motors.csv` differs");
    changed("study.toml", "1.5,", "1.6,", "the grid is another");
    changed("study.toml", "requirement", "# a note\nrequirement", "the study file has changed");
    fs::remove_file(at.join("knee.csv")).unwrap();
    assert!(study(&["--resume"], 2).contains("`knee.csv` cannot be read any more"));
    fs::write(at.join("knee.csv"), MOTION).unwrap();
    // A finished study knows its inputs too.
    ends(at, &["study", "study.toml", "--out", "done"], 0);
    let stderr = ends(at, &["study", "study.toml", "--out", "done", "--resume"], 0);
    assert!(stderr.contains("is finished already"), "{stderr}");
    let stderr = ends(at, &["study", "study.toml", "--out", "done"], 2);
    assert!(stderr.contains("`--force` replaces them"), "{stderr}");
    fs::write(at.join("knee.csv"), MOTION.replace("2.0", "2.1")).unwrap();
    let stderr = ends(at, &["study", "study.toml", "--out", "done", "--resume"], 2);
    assert!(stderr.contains("`knee.csv` has changed since"), "{stderr}");
    ends(at, &["study", "study.toml", "--out", "done", "--force"], 0);
    // A robot more is another list.
    ends(at, &["study", "robots", "--out", "list", "--catalog", "motors.csv", "--shard", "1/1"], 0);
    fs::write(at.join("robots/leg_99.toml"), leg("late", 1.0)).unwrap();
    let again = ["study", "robots", "--out", "list", "--catalog", "motors.csv", "--shard", "1/1", "--resume"];
    assert!(ends(at, &again, 2).contains("it had 30 files, now it has 31"));
}

#[test]
fn a_folder_has_one_process_at_a_time() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("out")).unwrap();
    let lock = fs::File::create(at.join("out/.study.lock")).unwrap();
    lock.lock().unwrap();
    let stderr = ends(at, &["study", "study.toml", "--out", "out"], 2);
    assert!(stderr.contains("another process works on the study in `out`"), "{stderr}");
    drop(lock);
    ends(at, &["study", "study.toml", "--out", "out"], 0);
}

#[test]
fn the_summary_counts_what_the_rows_say() {
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "study.toml", "--out", "out"], 0);
    let rows = rows(&at.join("out"));
    let summary: serde_json::Value = serde_json::from_slice(&fs::read(at.join("out/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["rows"], rows.len());
    let knee = summary["joints"].as_array().unwrap().iter().find(|j| j["joint"] == "knee").unwrap();
    let of_knee: Vec<_> = rows.iter().filter(|r| r["joint"] == "knee").collect();
    for motor in knee["motors"].as_array().unwrap() {
        let count = |first: bool| {
            let here = |r: &&&BTreeMap<String, String>| motor["motor"] == r["motor"] && (!first || r["rank"] == "1");
            of_knee.iter().filter(here).count()
        };
        assert_eq!(motor["first"], count(true));
        assert_eq!(motor["among"], count(false));
    }
    assert_eq!(knee["without_design"], of_knee.iter().filter(|r| r["rank"].is_empty()).count());
    // The effect of the torque on the hip, by hand: twice the least factor against it, all else equal.
    let loss = |torque: &str, rest: &BTreeMap<String, String>| {
        let same = |r: &&BTreeMap<String, String>| {
            r["joint"] == "hip"
                && r["rank"] == "1"
                && r["grid_scale_torque"] == torque
                && ["grid_bus_voltage_v", "grid_joint_knee_gear_efficiency", "grid_scale_speed"]
                    .iter()
                    .all(|c| r[*c] == rest[*c])
        };
        rows.iter().find(same).map(|r| r["loss_w"].parse::<f64>().unwrap())
    };
    let firsts = rows.iter().filter(|r| r["joint"] == "hip" && r["rank"] == "1" && r["grid_scale_torque"] == "0.5");
    let logs: Vec<f64> = firsts.filter_map(|r| Some((loss("1", r)? / loss("0.5", r)?).ln())).collect();
    let effects = summary["effects"].as_array().unwrap();
    let effect =
        effects.iter().find(|e| e["parameter"] == "scale.torque" && e["value"] == "1.0" && e["joint"] == "hip");
    let effect = effect.unwrap();
    assert_eq!(effect["pairs"], logs.len());
    let mean = (logs.iter().sum::<f64>() / logs.len() as f64).exp();
    assert!((effect["loss_ratio"].as_f64().unwrap() / mean - 1.0).abs() < 1e-9);
    assert!(mean > 1.5, "twice the torque costs more: {mean}");
}

/// A study file with one thing spoilt: exit status 2, and this in the report.
fn mistake(from: &str, to: &str, says: &[&str]) {
    let folder = folder();
    assert!(STUDY.contains(from));
    fs::write(folder.path().join("study.toml"), STUDY.replacen(from, to, 1)).unwrap();
    let stderr = ends(folder.path(), &["study", "study.toml", "--out", "out"], 2);
    for part in says {
        assert!(stderr.contains(part), "{part}\n{stderr}");
    }
    assert!(!folder.path().join("out/journal").exists());
}

#[test]
fn mistakes_in_the_study_file_are_shown_where_they_are_written() {
    mistake("\"48 V\"]", "\"48 A\"]", &["study.toml:5:26", "`voltage` of [bus]", "48 A"]);
    mistake(
        "bus.voltage",
        "bus.voltge",
        &["study.toml:5:1", "unknown key `voltge` in [bus]", "did you mean `voltage`?"],
    );
    mistake("joint.knee", "joint.kne", &["study.toml:6:1", "names no `joint`", "did you mean `knee`?"]);
    mistake("gear.efficiency", "gear.eficiency", &["study.toml:6:1", "did you mean `efficiency`?"]);
    mistake("0.85, 0.95", "0.85, 95", &["study.toml:6:39", "out of range", "for 95 % write 0.95"]);
    mistake("scale.torque", "scale.torqe", &["study.toml:7:1", "did you mean `scale.torque`?"]);
    mistake("[1, 1.5, 40]", "[1, -1.5]", &["study.toml:8:21", "is a factor"]);
    mistake("[1, 1.5, 40]", "[1, 1]", &["duplicate"]);
    mistake("[1, 1.5, 40]", "[]", &["`scale.speed` of [grid] is empty"]);
    mistake("[1, 1.5, 40]", "1", &["not a list of values", "{ from = 0.8"]);
    mistake("steps = 7", "steps = 1", &["`steps` is a whole number from 2"]);
    mistake("steps = 7", "step = 7", &["unknown key `step` in a range", "did you mean `steps`?"]);
    mistake("requirement =", "requirment =", &["did you mean `requirement`?"]);
    mistake(
        "base.toml",
        "bose.toml",
        &["there is no file or folder `bose.toml`", "there is `base.toml` in that folder"],
    );
    mistake("motors.csv", "motor.csv", &["there is `motors.csv` in that folder"]);
}

#[test]
fn lists_that_name_nothing_are_refused() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("empty")).unwrap();
    let refused = |paths: &[&str], says: &str| {
        let mut arguments = vec!["study"];
        arguments.extend(paths);
        arguments.extend(["--out", "out"]);
        let stderr = ends(at, &arguments, 2);
        assert!(stderr.contains(says), "{stderr}");
    };
    refused(&["empty"], "there is no .toml file in the folder `empty`");
    refused(&["robots/*.tml"], "no file matches `robots/*.tml`");
    refused(&["robts/*.toml"], "there is no folder `robts`");
    refused(&["robots/leg_00.tom"], "there is `leg_00.toml` in that folder");
    refused(&["robots/[.toml"], "is not a pattern");
    ends(at, &["study", "robots/leg_0?.toml", "robots/**/leg_1*.toml", "--out", "out", "--catalog", "motors.csv"], 0);
    let inputs = fs::read_to_string(at.join("out/inputs.csv")).unwrap();
    assert_eq!(inputs.matches(",robots/knee.csv,").count(), 20);
    assert!(inputs.contains("robots/leg_09.toml,robots/leg_09.toml,"));
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_told() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("out")).unwrap();
    fs::set_permissions(at.join("out"), fs::Permissions::from_mode(0o555)).unwrap();
    if fs::write(at.join("out/try"), "").is_ok() {
        eprintln!("skipped: this user may write everywhere");
        return;
    }
    let stderr = ends(at, &["study", "study.toml", "--out", "out"], 2);
    assert!(stderr.contains("cannot write"), "{stderr}");
    fs::set_permissions(at.join("out"), fs::Permissions::from_mode(0o755)).unwrap();
}

/// The hash of every input stands in the results, as any other program computes it.
#[test]
fn the_manifest_has_the_hashes_of_what_was_read_and_written() {
    use sha2::{Digest, Sha256};
    let folder = folder();
    let at = folder.path();
    ends(at, &["study", "study.toml", "--out", "out"], 0);
    let hash = |path: PathBuf| -> String {
        Sha256::digest(fs::read(path).unwrap()).iter().map(|b| format!("{b:02x}")).collect()
    };
    let manifest: serde_json::Value = serde_json::from_slice(&fs::read(at.join("out/manifest.json")).unwrap()).unwrap();
    for output in manifest["outputs"].as_array().unwrap() {
        assert_eq!(output["sha256"], hash(at.join("out").join(output["file"].as_str().unwrap())));
    }
    assert_eq!(manifest["outputs"].as_array().unwrap().len(), if cfg!(feature = "parquet") { 6 } else { 5 });
    assert_eq!(manifest["plan"]["study"]["sha256"], hash(at.join("study.toml")));
    assert_eq!(manifest["plan"]["catalog"][0]["sha256"], hash(at.join("motors.csv")));
    let inputs = fs::read_to_string(at.join("out/inputs.csv")).unwrap();
    for file in ["base.toml", "knee.csv"] {
        assert!(inputs.contains(&format!("base.toml,{file},{}", hash(at.join(file)))), "{inputs}");
    }
}
