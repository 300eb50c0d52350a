//! What no robot has: numbers that are slips of the pen, parts that contradict themselves, lists with nothing in them. Each is an
//! error that names its key, in every command that reads it, and no answer.

use std::fs;

use super::folder::{DESIGN, MOTORS, REQUIREMENT, folder, run};
use crate::common::repository;

/// Every command that reads a requirement.
const READERS: &[&[&str]] = &[
    &["optimize", "robot.toml", "--catalog", "motors.csv"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--json"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--csv"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--robot"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--robust"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--pareto", "loss,mass"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "new.toml"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--html", "new.html"],
    &["optimize", "robot.toml", "--catalog", "motors.csv", "--search", "bus.voltage=24 V:48 V"],
    &["sweep", "robot.toml", "--catalog", "motors.csv"],
    &["explain", "alpha-1", "robot.toml", "--catalog", "motors.csv"],
    &["explore", "robot.toml", "--catalog", "motors.csv", "--static", "new.html"],
    &["explore", "robot.toml", "--catalog", "motors.csv"],
    &["check", "design.toml"],
    &["export", "design.toml", "--to", "urdf"],
    &["export", "alpha-1", "robot.toml", "--catalog", "motors.csv", "--to", "urdf"],
];

#[test]
fn a_robot_without_joints_is_an_error_in_every_command() {
    let head = REQUIREMENT.split("[[joint]]").next().unwrap();
    for text in [format!("joint = []\n{head}"), head.to_string()] {
        let desk = folder();
        fs::write(desk.path().join("robot.toml"), &text).unwrap();
        for command in READERS {
            let ran = run(&desk, command);
            assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{command:?}: {}", ran.err);
            assert!(ran.err.contains("`joint` is"), "{command:?}: {}", ran.err);
        }
        assert!(!desk.path().join("new.toml").exists() && !desk.path().join("new.html").exists());
        // One robot of a study is broken.
        let ran = run(&desk, &["study", "robot.toml", "--catalog", "motors.csv", "--out", "out", "--quiet"]);
        assert_eq!(ran.status, 1, "{}", ran.err);
        assert!(fs::read_to_string(desk.path().join("out/errors.csv")).unwrap().contains("`joint` is"));
    }
    let empty = [
        ("design.toml", format!("joint = []\n{}", DESIGN.split("[[joint]]").next().unwrap()), READERS[13]),
        (
            "bench.toml",
            "log = []\nname = \"b\"\nkind = \"stall\"\n[motor]\nid = \"x\"\n".into(),
            &["identify", "bench.toml"],
        ),
        ("hardware.toml", "joint = []\n".into(), &["check-model", "m.urdf", "--against", "hardware.toml"]),
    ];
    for (name, text, command) in empty {
        let desk = folder();
        fs::write(desk.path().join("m.urdf"), "<robot name=\"r\"><link name=\"a\"/></robot>").unwrap();
        fs::write(desk.path().join(name), text).unwrap();
        let ran = run(&desk, command);
        assert_eq!(ran.status, 2, "{command:?}: {}", ran.out);
        assert!(ran.err.contains(name), "{}", ran.err);
    }
}

#[test]
fn numbers_beyond_any_machine_are_errors() {
    let gear = "gear = { efficiency = 0.95, mass = \"150 g\", inertia = \"2e-6 kg*m^2\" }";
    let with = |more: &str| REQUIREMENT.replace(gear, &format!("gear = {{ efficiency = 0.95, {more} }}"));
    let cases = [
        ("safety", REQUIREMENT.replace("safety = 1.2", "safety = 0.99")),
        ("safety", REQUIREMENT.replace("safety = 1.2", "safety = 1e-6")),
        ("voltage", REQUIREMENT.replace("48 V", "24 MV")),
        ("mass", REQUIREMENT.replace("150 g", "1e17 kg")),
        ("mass", REQUIREMENT.replace("150 g", "1e15 kg")),
        ("inertia", REQUIREMENT.replace("2e-6 kg", "1e14 kg")),
        ("temperature", format!("ambient = {{ temperature = \"-273.14 degC\" }}\n{REQUIREMENT}")),
        ("temperature", format!("ambient = {{ temperature = \"-300 degC\" }}\n{REQUIREMENT}")),
        ("temperature", format!("ambient = {{ temperature = \"20 K\" }}\n{REQUIREMENT}")),
        ("temperature", format!("ambient = {{ temperature = \"1e6 K\" }}\n{REQUIREMENT}")),
        ("winding_temperature", REQUIREMENT.replace("safety = 1.2", "winding_temperature = \"99999 degC\"")),
        ("drive_current", REQUIREMENT.replace("40 A", "1e15 A")),
        ("continuous_torque", with("peak_torque = \"20 N*m\", continuous_torque = \"200 N*m\"")),
        ("average_torque", with("peak_torque = \"20 N*m\", average_torque = \"21 N*m\"")),
        ("peak_torque", with("peak_torque = \"20 N*m\", momentary_peak_torque = \"19 N*m\"")),
        ("continuous_torque", with("momentary_peak_torque = \"19 N*m\", continuous_torque = \"20 N*m\"")),
        ("momentary_peak_torque", with("momentary_peak_torque = \"19 N*m\", ratcheting_torque = \"18 N*m\"")),
        ("average_input_speed", with("max_input_speed = \"100 rpm\", average_input_speed = \"101 rpm\"")),
        (
            "continuous_current",
            REQUIREMENT
                .replace("count = 2", "count = 2\ndrive = { current = \"20 A\", continuous_current = \"21 A\" }"),
        ),
        ("drive_continuous_current", REQUIREMENT.replace("\"40 A\"", "\"40 A\"\ndrive_continuous_current = \"41 A\"")),
    ];
    for (key, text) in cases {
        assert_ne!(text, REQUIREMENT, "{key}");
        let desk = folder();
        fs::write(desk.path().join("robot.toml"), &text).unwrap();
        let ran = run(&desk, READERS[1]);
        assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{key}: {}", ran.err);
        assert!(ran.err.contains(&format!("`{key}`")) && ran.err.contains("1 mistake in 1 file"), "{key}: {}", ran.err);
    }
    // What is at the edge of sense is taken.
    for text in [
        REQUIREMENT.replace("safety = 1.2", "safety = 1"),
        REQUIREMENT.replace("48 V", "10 kV"),
        format!("ambient = {{ temperature = \"-150 degC\" }}\n{REQUIREMENT}"),
        with("peak_torque = \"20 N*m\", continuous_torque = \"20 N*m\""),
    ] {
        let desk = folder();
        fs::write(desk.path().join("robot.toml"), &text).unwrap();
        let ran = run(&desk, READERS[1]);
        assert!(ran.status < 2, "{}\n{text}", ran.err);
    }
}

#[test]
fn cells_beyond_any_machine_are_errors() {
    for (key, from, to) in [
        ("mass", ",300,200,", ",300,1e15,"),
        ("max_winding_temperature", ",60,120,", ",60,-250,"),
        ("rotor_inertia", ",300,200,", ",1e25,200,"),
    ] {
        let desk = folder();
        let motors = MOTORS.replacen(from, to, 1);
        assert_ne!(motors, MOTORS);
        fs::write(desk.path().join("motors.csv"), motors).unwrap();
        let ran = run(&desk, READERS[1]);
        assert_eq!(ran.status, 2, "{key}");
        assert!(ran.err.contains(&format!("`{key}`")) && ran.err.contains("motors.csv:2:"), "{}", ran.err);
    }
    // A map of a gear over its ratio.
    let desk = folder();
    let gear = "gear = { efficiency = 0.95, mass = \"150 g\", inertia = \"2e-6 kg*m^2\" }";
    fs::write(desk.path().join("robot.toml"), REQUIREMENT.replace(gear, "gear = { map = \"map.csv\" }")).unwrap();
    let map = "ratio,peak_torque [N*m],continuous_torque [N*m]\n3,20,10\n10,20,21\n30,20,10\n";
    fs::write(desk.path().join("map.csv"), map).unwrap();
    let ran = run(&desk, READERS[1]);
    assert!(ran.status == 2 && ran.err.contains("map.csv:3:"), "{}", ran.err);
}

#[test]
fn a_log_is_not_colder_than_anything() {
    let desk = folder();
    let bench = repository("requirements/bench");
    for name in ["leg_actuator.toml", "leg_actuator_2.csv", "leg_actuator_3.csv"] {
        fs::copy(bench.join(name), desk.path().join(name)).unwrap();
    }
    let log = fs::read_to_string(bench.join("leg_actuator_1.csv")).unwrap();
    // One row of it, the temperature of which is its last cell.
    let (head, row) = (log.lines().take(400).collect::<Vec<_>>().join("\n"), log.lines().nth(400).unwrap());
    let cells = row.rsplit_once(',').unwrap().0;
    let rest: String = log.lines().skip(401).map(|line| format!("{line}\n")).collect();
    fs::write(desk.path().join("leg_actuator_1.csv"), format!("{head}\n{cells},-300\n{rest}")).unwrap();
    let ran = run(&desk, &["identify", "leg_actuator.toml", "--json"]);
    assert_eq!((ran.status, ran.out.as_str()), (2, ""), "{}", ran.err);
    assert!(ran.err.contains("leg_actuator_1.csv:401:") && ran.err.contains("1 mistake in 1 file"), "{}", ran.err);
}
