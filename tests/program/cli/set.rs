//! `--set KEY=VALUE`: the same as the value in the file, told where it was written, and kept by whatever is written.

use std::fs;

use serde_json::Value;

use super::folder::{REQUIREMENT, Ran, folder, run};

const CATALOG: [&str; 2] = ["--catalog", "motors.csv"];

fn optimize(folder: &tempfile::TempDir, more: &[&str]) -> Ran {
    run(folder, &[&["optimize", "robot.toml"], &CATALOG[..], more].concat())
}

fn json(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|e| panic!("{e}: {}{}", ran.out, ran.err))
}

/// What a command says of a value that is set is what it says of a file that has it; the robot's `set` apart.
#[test]
fn a_value_that_is_set_is_as_one_of_the_file() {
    let folder = folder();
    let cases: [(&str, &str, &str); 5] = [
        ("bus.voltage=24 V", "voltage = \"48 V\"", "voltage = \"24 V\""),
        ("bus.voltage=\"24V\"", "voltage = \"48 V\"", "voltage = \"24 V\""),
        ("joint.knee.limits.safety=1.5", "safety = 1.2", "safety = 1.5"),
        ("joint.*.ratio={ min = 4, max = 12 }", "{ min = 3, max = 30 }", "{ min = 4, max = 12 }"),
        ("joint.knee.limits.actuator_mass=360 g", "safety = 1.2", "safety = 1.2\nactuator_mass = \"360 g\""),
    ];
    let plain = json(&optimize(&folder, &["--json"]));
    for (set, from, to) in cases {
        assert!(REQUIREMENT.contains(from));
        fs::write(folder.path().join("other.toml"), REQUIREMENT.replace(from, to)).unwrap();
        let written = run(&folder, &[&["optimize", "other.toml", "--json"], &CATALOG[..]].concat());
        let mut told = json(&optimize(&folder, &["--json", "--set", set]));
        let noted = told["robot"].as_object_mut().unwrap().remove("set").unwrap();
        assert_eq!(noted[0]["key"], set.split_once('=').unwrap().0);
        assert_eq!(told, json(&written), "{set}");
        assert_ne!(told, plain, "{set} changes something");
    }
    assert!(plain["robot"].get("set").is_none(), "nothing was set");
}

/// The keys of a study's grid, and what they do, are the same.
#[test]
fn keys_are_those_of_a_study() {
    let folder = folder();
    let study = |keys: &str, name: &str| {
        let text = format!("requirement = \"robot.toml\"\ncatalog = [\"motors.csv\"]\n[grid]\n{keys}");
        fs::write(folder.path().join("study.toml"), text).unwrap();
        let ran = run(&folder, &["study", "study.toml", "--out", name]);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let text = fs::read_to_string(folder.path().join(name).join("results.csv")).unwrap();
        let mut rows = text.lines().map(|l| l.split(',').map(String::from).collect::<Vec<_>>());
        let header = rows.next().unwrap();
        let at = |name: &str| header.iter().position(|h| h == name).unwrap();
        let (motor, loss) = (at("motor"), at("loss_w"));
        let first = rows.next().unwrap();
        (first[motor].clone(), first[loss].parse::<f64>().unwrap())
    };
    for (grid, set) in [
        ("\"bus.voltage\" = [\"24 V\"]", "bus.voltage=24 V"),
        ("\"scale.torque\" = [1.3]", "scale.torque=1.3"),
        ("\"scale.speed\" = [1.2]", "scale.speed=1.2"),
        ("\"joint.knee.gear.efficiency\" = [0.8]", "joint.knee.gear.efficiency=0.8"),
    ] {
        let (motor, loss) = study(grid, set.split(['=', ' ']).next().unwrap());
        let told = json(&optimize(&folder, &["--json", "--set", set]));
        let first = &told["joints"][0]["candidates"][0];
        assert_eq!(first["motor"], motor.as_str(), "{set}");
        let here = first["loss_w"].as_f64().unwrap();
        assert!((here - loss).abs() <= 1e-9 * loss, "{set}: {here} {loss}");
    }
}

/// Every command that reads a requirement takes it, and says in text and JSON what was set.
#[test]
fn every_command_that_reads_a_requirement_takes_it() {
    let folder = folder();
    let of_catalog: [&[&str]; 6] = [
        &["optimize", "robot.toml"],
        &["optimize", "robot.toml", "--pareto", "loss,mass"],
        &["optimize", "robot.toml", "--robust"],
        &["sweep", "robot.toml", "--ratios", "3"],
        &["explain", "alpha-1@9", "robot.toml"],
        &["check", "design.toml"],
    ];
    for command in of_catalog {
        let arguments = [command, &CATALOG, &["--set", "bus.voltage=30 V"]].concat();
        let text = run(&folder, &arguments);
        assert!(text.out.starts_with("Set: bus.voltage = \"30 V\"\n"), "{command:?}: {}{}", text.out, text.err);
        let told = json(&run(&folder, &[&arguments[..], &["--json"]].concat()));
        assert_eq!(told["robot"]["set"][0]["value"], "\"30 V\"", "{command:?}");
        // A wrong key is refused by all of them, at the option.
        let wrong = run(&folder, &[command, &CATALOG, &["--set", "bus.voltag=30 V"]].concat());
        assert_eq!(wrong.status, 2, "{command:?}");
        assert!(wrong.err.contains("--set:1:1") && wrong.err.contains("did you mean `voltage`?"), "{}", wrong.err);
    }
    let arguments = ["export", "alpha-1@9", "robot.toml", "--catalog", "motors.csv", "--set", "bus.voltage=30 V"];
    let told = json(&run(&folder, &[&arguments[..], &["--to", "json"]].concat()));
    assert_eq!(told["robot"]["set"][0]["key"], "bus.voltage");
    let mjcf = run(&folder, &[&arguments[..], &["--to", "mjcf"]].concat());
    assert!(mjcf.out.contains("with bus.voltage = \"30 V\""), "{}", mjcf.out);
    let study = ["study", "robot.toml", "--catalog", "motors.csv", "--out", "of", "--set", "bus.voltage=30 V"];
    assert_eq!(run(&folder, &study).status, 0);
    let results = fs::read_to_string(folder.path().join("of/results.csv")).unwrap();
    assert!(results.lines().next().unwrap().contains("grid_bus_voltage_v"), "{results}");
    let manifest = fs::read_to_string(folder.path().join("of/manifest.json")).unwrap();
    assert!(manifest.contains("bus.voltage"));
    // A study with another value is another study.
    let other = [&study[..study.len() - 1], &["bus.voltage=31 V", "--resume"]].concat();
    let ran = run(&folder, &other);
    assert!(ran.status == 2 && ran.err.contains("the grid is another"), "{}", ran.err);
}

/// What a design was chosen for stands in it: `check` compares with that, not with the file alone.
#[test]
fn a_written_design_keeps_what_was_set() {
    let folder = folder();
    let ran =
        optimize(&folder, &["--set", "bus.voltage=12 V", "--set", "scale.torque=0.9", "--write-design", "d.toml"]);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
    let text = fs::read_to_string(folder.path().join("d.toml")).unwrap();
    assert!(text.contains("set = { \"bus.voltage\" = \"12 V\", \"scale.torque\" = 0.9 }\n"), "{text}");
    // Which part of the voltage the design needs.
    let needed = |ran: &Ran| 1.0 - json(ran)["joints"][0]["design"]["margins"]["voltage"].as_f64().unwrap();
    let as_written = needed(&run(&folder, &["check", "d.toml", "--json"]));
    // The call goes before the design, and what the design sets besides stays.
    let again = run(&folder, &["check", "d.toml", "--json", "--set", "bus.voltage=48 V"]);
    assert!((as_written / needed(&again) - 4.0).abs() < 1e-9, "{as_written}");
    assert_eq!(json(&again)["robot"]["set"].as_array().unwrap().len(), 2);
    // Without `set` the file's own value holds.
    let plain: String = text.lines().filter(|l| !l.starts_with("set")).map(|l| format!("{l}\n")).collect();
    fs::write(folder.path().join("d.toml"), plain).unwrap();
    let plain = needed(&run(&folder, &["check", "d.toml", "--json"]));
    assert!(
        plain < as_written / 4.0 * 1.2 && plain > as_written / 4.0,
        "the torque is larger, the voltage too: {plain}"
    );
}

/// The lock is that of catalogue rows: no value of a requirement is in it.
#[test]
fn a_lock_knows_nothing_of_what_is_set() {
    let folder = folder();
    let lock = |more: &[&str]| {
        run(&folder, &[&["check", "design.toml", "--update-lock"], more].concat());
        fs::read_to_string(folder.path().join("design.lock")).unwrap()
    };
    assert_eq!(lock(&[]), lock(&["--set", "bus.voltage=30 V", "--set", "joint.knee.limits.safety=2"]));
}

/// Wrong keys and values: one error that names what was typed, and nothing is assumed.
#[test]
fn what_cannot_be_set_is_refused_at_its_place() {
    let folder = folder();
    for (set, said) in [
        (&["bus.voltage"][..], "`--set bus.voltage`: write KEY=VALUE"),
        (&["=5"], "is not a path"),
        (&["bus..voltage=5 V"], "is not a path"),
        (&["bus.voltage="], "there is no value"),
        (&["bus.voltage=48"], "--set:1:13"),
        (&["bus.voltage=48 A"], "--set:1:13"),
        (&["bus.voltage=48 V", "joint.knee.count=0"], "--set:2:18"),
        (&["bus.voltage=48 V", "bus.voltage=24 V"], "`bus.voltage` is set twice"),
        (&["bsu.voltage=48 V"], "did you mean `bus`?"),
        (&["joint.kne.count=2"], "did you mean `knee`?"),
        (&["joint.knee.cuont=2"], "did you mean `count`?"),
        (&["joint.knee.motion.x=2"], "leads through `joint.knee.motion`"),
        (&["joint.knee.ratio={ min = 3"], "the value is not TOML"),
        (&["joint.knee.ratio={ min = 3, max = 9, mix = 4 }"], "unknown key `mix` in [ratio]"),
        (&["scale.torqe=1.1"], "did you mean `scale.torque`?"),
        (&["scale.torque=0"], "expected a bare number between 1e-6 and 1e6"),
        (&["scale.torque=2 N*m"], "expected a bare number between 1e-6 and 1e6"),
        (&["voltage=48 V"], "unknown key `voltage` at the top level"),
    ] {
        let options: Vec<&str> = set.iter().flat_map(|s| ["--set", *s]).collect();
        let ran = optimize(&folder, &options);
        assert_eq!(ran.status, 2, "{set:?}: {}", ran.out);
        assert!(ran.out.is_empty() && ran.err.contains(said), "{set:?}: {}", ran.err);
        assert_eq!(ran.err.matches("error:").count(), 1, "{set:?}: one error: {}", ran.err);
    }
    let study =
        |set: &str| run(&folder, &["study", "robot.toml", "--catalog", "motors.csv", "--out", "x", "--set", set]);
    for (set, said) in [("bus.voltag=3 V", "--set:1:1"), ("scale.torque=-1", "--set:1:14")] {
        let ran = study(set);
        assert!(ran.status == 2 && ran.err.contains(said), "{}", ran.err);
        assert!(!folder.path().join("x").exists(), "nothing is begun");
    }
}

/// A design's own `set` is read as strictly, at its place in the design.
#[test]
fn a_wrong_set_of_a_design_is_told_in_the_design() {
    let folder = folder();
    for (set, said) in [
        ("set = { \"bus.voltag\" = \"24 V\" }", "design.toml:1:9"),
        ("set = { \"bus.voltage\" = 24 }", "design.toml:1:25"),
        ("set = { bus.voltage = \"24 V\" }", "expected a path in quotes"),
        ("set = \"bus.voltage\"", "design.toml:1:7"),
    ] {
        let design = format!("{set}\n{}", super::folder::DESIGN);
        fs::write(folder.path().join("design.toml"), design).unwrap();
        let ran = run(&folder, &["check", "design.toml"]);
        assert!(ran.status == 2 && ran.err.contains(said), "{set}: {}", ran.err);
    }
}
