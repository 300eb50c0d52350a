//! Logs of a whole robot on the command line: what is said of all joints and of one, and what is wrong with a bench file.

use std::fs;
use std::path::{Path, PathBuf};

use gearwise::measured::read::{read, read_subject};

use crate::common::run::{gearwise, json, stderr, stdout};
use crate::simulator::arm::Arm;

/// A short log of an arm of which the bench file says too small a payload.
fn written(folder: &Path) -> PathBuf {
    let mut arm = Arm::new(21);
    arm.duration = 30.0;
    arm.declared_payload = Some((0.8, arm.payload.1));
    arm.write(folder, 1)
}

#[test]
fn the_masses_come_first_then_a_line_for_each_joint() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let bench = path.to_str().unwrap();
    let output = gearwise(&["identify", bench]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    let at = |part: &str| text.find(part).unwrap_or_else(|| panic!("no `{part}` in\n{text}"));
    assert!(at("The payload at `wrist_3` is not as declared") < at("joint "));
    for joint in ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"] {
        at(&format!("\n{joint}: "));
    }
    let page = folder.path().join("arm.html");
    let output = gearwise(&["identify", bench, "--json", "--html", page.to_str().unwrap()]);
    let answer = json(&output);
    assert_eq!(answer["payload"]["verdict"], "named");
    assert_eq!(answer["joints"].as_array().unwrap().len(), 6);
    let (mass, error) =
        (answer["payload"]["mass_kg"].as_f64().unwrap(), answer["payload"]["mass_tolerance_kg"].as_f64());
    assert!((mass - 1.2).abs() < 0.06 && error.is_some_and(|e| e < 0.1), "{mass} {error:?}");
    let elbow = &answer["joints"][2];
    assert_eq!((elbow["joint"].as_str(), elbow["answer"]["bench"].as_str()), (Some("forearm"), Some("arm, forearm")));
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("The payload at") && page.contains("<figure") && page.contains("wrist_2"));
    let rows = stdout(&gearwise(&["identify", bench, "--csv"]));
    assert!(rows.starts_with("joint,equation,") && rows.lines().any(|l| l.starts_with("wrist_1,")), "{rows}");
}

#[test]
fn one_joint_can_do_what_one_actuator_can() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let bench = path.to_str().unwrap();
    let fitted = folder.path().join("fitted.toml");
    let fitted = fitted.to_str().unwrap();
    let output = gearwise(&["identify", bench, "--joint", "forearm", "--write", fitted]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    assert!(text.starts_with("The payload at `wrist_3`"), "{text}");
    assert!(text.contains("arm, forearm: m-forearm at N = 100") && text.contains("coulomb_friction"), "{text}");
    // The load is that of the whole arm: nothing is simulated with a part of it.
    assert!(!text.contains("simulated forward"), "{text}");
    assert!(fs::read_to_string(fitted).unwrap().contains("coulomb"));
    for (wrong, says) in [
        (vec!["--write", fitted], "`--joint` says which of shoulder, upper_arm"),
        (vec!["--plan", fitted], "`--joint` says which"),
        (vec!["--joint", "forearm", "--plan", fitted], "not planned"),
        (vec!["--joint", "elbow"], "the joints with an actuator are shoulder"),
    ] {
        let output = gearwise(&[&["identify", bench], wrong.as_slice()].concat());
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
        assert!(stderr(&output).contains(says), "{}", stderr(&output));
    }
    let output = gearwise(&["identify", "requirements/bench/leg_actuator.toml", "--joint", "knee"]);
    assert!(stderr(&output).contains("`--joint` is of a bench file of a whole robot"), "{}", stderr(&output));
}

/// What a person reads of a changed bench file.
fn mistake(change: impl FnOnce(&str) -> String) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut arm = Arm::new(22);
    arm.duration = 1.0;
    let path = arm.write(folder.path(), 1);
    let text = fs::read_to_string(&path).unwrap();
    let changed = change(&text);
    assert_ne!(text, changed);
    fs::write(&path, changed).unwrap();
    match read_subject(&path, None, Vec::new()) {
        Ok(_) => panic!("it was read"),
        Err(errors) => errors.iter().map(ToString::to_string).collect(),
    }
}

#[test]
fn every_mistake_of_a_robots_bench_file_is_said_at_its_place() {
    let joint = "[[joint]]\nname = \"wrist_3\"\nmechanism_joint = \"wrist_3_joint\"\nactuator = { motor = \"m-wrist_3\", ratio = 100 }\n";
    let swap = |from: &'static str, to: &'static str| move |text: &str| text.replacen(from, to, 1);
    let cases: Vec<(String, &str)> = vec![
        (mistake(swap("\"wrist_3_joint\"", "\"wrist_3_joint_\"")), "did you mean `wrist_3_joint`?"),
        (mistake(|text| text.replace(joint, "")), "nothing says where the joint `wrist_3_joint` of the description is"),
        (mistake(|text| text.replace(joint, &format!("{joint}{joint}"))), "has two tables [[joint]]"),
        (mistake(swap("q_{joint}", "q_wrist_1_joint")), "have one column, `q_wrist_1_joint`"),
        (mistake(swap("q_{joint}", "q_{joint}s")), "q_shoulder_joints"),
        (mistake(swap("model = \"arm.urdf\"", "model = \"arm2.urdf\"")), "model `arm2.urdf`"),
        (mistake(swap("model = \"arm.urdf\"", "modell = \"arm.urdf\"")), "did you mean `model`?"),
        (mistake(swap("link = \"wrist_3\"", "link = \"wrist_9\"")), "there is no link `wrist_9`"),
        (mistake(swap("mass = \"2 kg\"", "mass = \"-2 kg\"")), "mass"),
        (mistake(swap("mass = \"2 kg\"", "mass = 2")), "mass"),
        (mistake(swap("kind = \"free\"", "kind = \"servo\"")), "cannot be of kind `servo`"),
        (
            mistake(|text| text.replace("position = {", "velocity = {").replace("unit = \"rad\"", "unit = \"rad/s\"")),
            "needs `time` and `position`",
        ),
        (
            mistake(|text| text.lines().filter(|l| !l.starts_with("current")).collect::<Vec<_>>().join("\n")),
            "joint `shoulder`: a log of kind `free` needs",
        ),
        (mistake(swap("file = \"run1.csv\"", "file = \"run7.csv\"")), "log `run7.csv`"),
        (mistake(swap("payload =", "fixed = { wrist_3_joint = \"3 deg\" }, payload =")), "is `fixed`, and has a table"),
        (
            mistake(swap("payload =", "fixed = { wrist_4_joint = \"3 deg\" }, payload =")),
            "no joint `wrist_4_joint` moves",
        ),
        (mistake(swap("payload =", "fixed = { wrist_3_joint = \"3 mm\" }, payload =")), "mm"),
        (mistake(swap("payload =", "fixed = { wrist_3_joint = 3 }, payload =")), "is not a text with a unit"),
        (mistake(swap("[[log]]", "[[log]]\nload = { mass = \"1 kg\", distance = \"1 m\" }")), "unknown key `load`"),
        (
            mistake(swap("[[log]]", "[[log]]\npayload = { link = \"wrist\", mass = \"1 kg\" }")),
            "there is no link `wrist`",
        ),
        (mistake(swap("kind = \"free\"", "kind = \"free\"\nwithout = [\"coging\"]")), "did you mean `cogging`?"),
        (mistake(|text| text.replace("mechanism = {", "mechanics = {")), "mechanism"),
    ];
    for (said, wanted) in &cases {
        assert!(said.contains(wanted), "`{wanted}` is not in\n{said}");
        assert!(said.contains("arm.toml:") || said.contains("run1.csv:"), "{said}");
    }
    // One actuator is not a robot.
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path());
    let errors = read(&path).unwrap_err();
    assert!(errors[0].to_string().contains("this bench file is of a whole robot"), "{}", errors[0]);
    let output = gearwise(&["characterize", path.to_str().unwrap()]);
    assert!(stderr(&output).contains("this bench file is of a whole robot"), "{}", stderr(&output));
}

/// A joint that only moves, one that stays, and a payload of one log: all of it counts in the load of the others.
#[test]
fn joints_without_an_actuator_and_joints_that_stay_count_in_the_load() {
    let folder = tempfile::tempdir().unwrap();
    let mut arm = Arm::new(23);
    arm.duration = 16.0;
    arm.moves[5] = false;
    arm.declared_payload = None;
    let path = arm.write(folder.path(), 1);
    let text = fs::read_to_string(&path).unwrap();
    let last = "[[joint]]\nname = \"wrist_3\"\nmechanism_joint = \"wrist_3_joint\"\nactuator = { motor = \"m-wrist_3\", ratio = 100 }\n";
    let at = arm.payload.1;
    let changed = text
        .replace(last, "")
        .replace("\"arm.urdf\"", "\"arm.urdf\", fixed = { wrist_3_joint = \"0.2 rad\" }")
        .replace("actuator = { motor = \"m-wrist_2\", ratio = 100 }\n", "")
        .replace(
            "[[log]]",
            &format!(
                "[[log]]\npayload = {{ link = \"wrist_3\", mass = \"{} kg\", at = [\"{} m\", \"{} m\", \"{} m\"] }}",
                arm.payload.0, at.x, at.y, at.z
            ),
        );
    fs::write(&path, changed).unwrap();
    let answer = json(&gearwise(&["identify", path.to_str().unwrap(), "--json"]));
    assert_eq!(answer["payload"]["verdict"], "enough", "{}", answer["payload"]);
    let joints = answer["joints"].as_array().unwrap();
    assert_eq!(joints.len(), 4);
    for joint in joints {
        let errors = &joint["answer"]["errors"];
        let (before, after) = (errors["declared"]["held_out"].as_f64(), errors["final"]["held_out"].as_f64());
        assert!(after < before.map(|b| 0.1 * b), "{joint}");
    }
}
