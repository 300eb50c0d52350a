//! A wrong kind of file is named in one line, for every pair of what was given and what was wanted.

use std::fs;

use tempfile::TempDir;

use super::folder::{DESIGN, MOTION, MOTORS, REQUIREMENT, RULES, folder, run};

const GEARS: &str = "id,kind,ratio,stages,efficiency,mass [g],inertia [g*cm^2],continuous_torque [N*m],peak_torque [N*m],fits,source,source_kind
planetary-1,planetary,9,2,0.9,150,5,4,8,*,a sheet,datasheet
";
const BENCH: &str = "name = \"b\"\nkind = \"dynamometer\"\nactuator = { motor = \"t-motor-ri50\", ratio = 9 }\n[[log]]\nfile = \"a.csv\"\n";
const STUDY: &str = "requirement = \"robot.toml\"\n[grid]\n\"bus.voltage\" = [\"24 V\"]\n";
const FITTED: &str = "gearwise = \"0.1.0\"\n[motor]\nid = \"a\"\n";
const URDF: &str = "<?xml version=\"1.0\"?>\n<robot name=\"arm\"><link name=\"base\"/></robot>\n";
const MJCF: &str = "<mujoco model=\"arm\"><worldbody/></mujoco>\n";
const LOCK: &str = "version = 1\nrobot = \"leg\"\ndesign = \"design.toml\"\n";
const RESULT: &str = "{\n  \"schema_version\": 1,\n  \"command\": \"optimize\"\n}\n";

/// Each kind with the file's name, its text, and what it is called.
const KINDS: [(&str, &str, &str); 13] = [
    ("requirement.toml", REQUIREMENT, "a requirement"),
    ("design.toml", DESIGN, "a design"),
    ("rules.toml", RULES, "a rules file"),
    ("bench.toml", BENCH, "a bench file"),
    ("study.toml", STUDY, "a study file"),
    ("motion.csv", MOTION, "a motion"),
    ("motors.csv", MOTORS, "a catalogue of motors"),
    ("gears.csv", GEARS, "a catalogue of gears"),
    ("fitted.toml", FITTED, "a fitted actuator"),
    ("arm.urdf", URDF, "a description of a robot"),
    ("arm.xml", MJCF, "a description of a robot"),
    ("design.lock", LOCK, "the lock of a design"),
    ("result.json", RESULT, "a JSON text"),
];

/// A folder with a file of each kind, and a picture and noise.
fn all() -> TempDir {
    let folder = folder();
    KINDS.iter().for_each(|(name, text, _)| fs::write(folder.path().join(name), text).unwrap());
    fs::write(folder.path().join("picture.png"), b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0").unwrap();
    let noise: Vec<u8> = (0..4000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    fs::write(folder.path().join("noise.bin"), noise).unwrap();
    folder
}

/// Where a file of a kind is given, the command that wants it; `FILE` stands for it.
const WANTED: [(&[&str], &str, &[&str]); 9] = [
    (&["optimize", "FILE"], "a requirement", &["a requirement"]),
    (&["sweep", "FILE"], "a requirement", &["a requirement"]),
    (&["explain", "alpha-1", "FILE"], "a requirement", &["a requirement"]),
    (&["check", "FILE"], "a design", &["a design"]),
    (&["check", "design.toml", "--rules", "FILE"], "a rules file", &["a rules file"]),
    (&["identify", "FILE"], "a bench file", &["a bench file"]),
    (&["characterize", "FILE"], "a bench file", &["a bench file"]),
    (
        &["rank", "FILE"],
        "a catalogue of motors or gears",
        &["a catalogue of motors", "a catalogue of gears", "a fitted actuator"],
    ),
    (&["torques", "FILE", "motion.csv"], "a description of a robot", &["a description of a robot"]),
];

#[test]
fn every_pair_of_kinds_is_one_line() {
    let folder = all();
    for (command, wanted, fits) in WANTED {
        for (file, _, what) in KINDS.iter().filter(|(_, _, what)| !fits.contains(what)) {
            let arguments: Vec<&str> = command.iter().map(|a| if *a == "FILE" { *file } else { *a }).collect();
            let ran = run(&folder, &arguments);
            assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.out);
            assert!(ran.err.contains(&format!("this is {what}")), "{arguments:?}: {}", ran.err);
            assert!(ran.err.contains(&format!("{wanted} is wanted")), "{arguments:?}: {}", ran.err);
            assert!(ran.err.contains("\n1 mistake in 1 file\n"), "{arguments:?}: {}", ran.err);
        }
        for (file, said) in [("picture.png", "this is a PNG picture, not a text"), ("noise.bin", "not a text file")] {
            let arguments: Vec<&str> = command.iter().map(|a| if *a == "FILE" { file } else { *a }).collect();
            let ran = run(&folder, &arguments);
            assert!(ran.status == 2 && ran.err.contains(said), "{arguments:?}: {}", ran.err);
            assert!(ran.err.contains("\n1 mistake in 1 file\n"), "{arguments:?}: {}", ran.err);
        }
    }
}

/// Files that a file names: a joint's motion, a design's fitted actuator.
#[test]
fn a_wrong_kind_of_named_file_is_told_too() {
    let folder = all();
    for (file, _, what) in KINDS.iter().filter(|(name, ..)| *name != "motion.csv") {
        fs::write(folder.path().join("r.toml"), REQUIREMENT.replace("knee.csv", file)).unwrap();
        let ran = run(&folder, &["optimize", "r.toml"]);
        assert!(ran.status == 2 && ran.err.contains(&format!("this is {what}")), "{file}: {}", ran.err);
        assert!(ran.err.contains("a motion is wanted"), "{file}: {}", ran.err);
    }
    for (file, _, what) in KINDS.iter().filter(|(name, ..)| *name != "fitted.toml") {
        let design = DESIGN.replace("motor = \"alpha-1\"", &format!("actuator = \"{file}\""));
        fs::write(folder.path().join("d.toml"), design).unwrap();
        fs::write(folder.path().join("robot.toml"), REQUIREMENT).unwrap();
        let ran = run(&folder, &["check", "d.toml"]);
        assert!(ran.status == 2 && ran.err.contains(&format!("this is {what}")), "{file}: {}", ran.err);
        assert!(ran.err.contains("a fitted actuator is wanted"), "{file}: {}", ran.err);
    }
}

/// A file with slips is not called another kind of file: its own mistakes are told.
#[test]
fn a_slip_does_not_make_another_kind() {
    let folder = folder();
    for (text, said) in [
        (REQUIREMENT.replace("voltage", "voltag"), "unknown key `voltag`"),
        (REQUIREMENT.replace("[bus]", "[bsu]"), "unknown key `bsu`"),
        (REQUIREMENT.replace("[[joint]]", "[[jiont]]"), "unknown key `jiont`"),
        (REQUIREMENT.replace("[bus]", "[bus"), "not valid TOML"),
        ("name = \"a, b\"\n".into(), "`bus` is missing"),
    ] {
        fs::write(folder.path().join("robot.toml"), text).unwrap();
        let ran = run(&folder, &["optimize", "robot.toml"]);
        assert!(ran.status == 2 && ran.err.contains(said) && !ran.err.contains("is wanted"), "{said}: {}", ran.err);
    }
}
