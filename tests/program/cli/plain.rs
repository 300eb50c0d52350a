//! Numbers as they are read and told: units without a blank, no rests of rounding, heat that has no temperature, a factor
//! below one, progress where it is asked for.

use std::fs;

use super::folder::{MOTORS, REQUIREMENT, folder, run};

/// A unit stands behind its number with a blank or without, everywhere one is read.
#[test]
fn a_blank_before_a_unit_is_not_needed() {
    let folder = folder();
    let answer = |requirement: &str, motors: &str, more: &[&str]| {
        fs::write(folder.path().join("robot.toml"), requirement).unwrap();
        fs::write(folder.path().join("motors.csv"), motors).unwrap();
        let ran = run(&folder, &[&["optimize", "robot.toml", "--catalog", "motors.csv", "--csv"], more].concat());
        assert_eq!(ran.status, 0, "{}", ran.err);
        ran.out
    };
    let plain = answer(REQUIREMENT, MOTORS, &[]);
    let tight = |text: &str| {
        text.replace("48 V", "48V").replace("40 A", "40A").replace("150 g", "150g").replace(" kg*m^2", "kg*m^2")
    };
    assert_eq!(answer(&tight(REQUIREMENT), MOTORS, &[]), plain);
    assert_eq!(answer(REQUIREMENT, &MOTORS.replace(" [", "["), &[]), plain);
    assert_eq!(answer(REQUIREMENT, MOTORS, &["--set", "bus.voltage=48V"]), plain);
    let study = |from: &str| {
        let text = format!(
            "requirement = \"robot.toml\"\ncatalog = [\"motors.csv\"]\n[grid]\n\"bus.voltage\" = {{ from = \"{from}\", to = \"48V\", steps = 2 }}\n"
        );
        fs::write(folder.path().join("study.toml"), text).unwrap();
        run(&folder, &["study", "study.toml", "--out", "of", "--force"])
    };
    let ran = study("24V");
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(fs::read_to_string(folder.path().join("of/results.csv")).unwrap().contains(",24,"));
    let ran = study("24A");
    assert!(ran.status == 2 && ran.err.contains("different units"), "{}", ran.err);
    // Without any unit it is still refused.
    fs::write(folder.path().join("robot.toml"), REQUIREMENT.replace("48 V", "48")).unwrap();
    assert_eq!(run(&folder, &["optimize", "robot.toml"]).status, 2);
}

/// A winding that no temperature balances has none in the text, and one within its limits has.
#[test]
fn heat_without_end_is_called_thermal_runaway() {
    let folder = folder();
    let motors = MOTORS.replace("max_winding_temperature [degC],", "max_winding_temperature [degC],thermal_resistance_winding_housing [K/W],thermal_resistance_housing_ambient [K/W],");
    let motors = motors.replace("60,120,", "60,120,1,4,");
    fs::write(folder.path().join("motors.csv"), motors).unwrap();
    let explain = |scale: &str| {
        let base = ["explain", "alpha-1@9", "robot.toml", "--catalog", "motors.csv", "--set", scale];
        (run(&folder, &base).out, run(&folder, &[&base[..], &["--json"]].concat()).out)
    };
    for (scale, hot) in [("scale.torque=1", false), ("scale.torque=20", true), ("scale.torque=60", true)] {
        let (text, json) = explain(scale);
        assert_eq!(text.contains("thermal runaway"), hot, "{scale}: {text}");
        let temperatures = text.split_whitespace().zip(text.split_whitespace().skip(1));
        let told = temperatures.filter(|(_, unit)| *unit == "degC").filter_map(|(value, _)| value.parse::<f64>().ok());
        assert!(told.clone().all(|t| t < 1000.0), "{scale}: {:?}: {text}", told.collect::<Vec<_>>());
        assert!(!json.is_empty());
    }
}

/// Progress is told where it is asked for, a line for each part, and not otherwise.
#[test]
fn progress_is_told_where_it_is_asked_for() {
    let folder = folder();
    let base = ["optimize", "robot.toml", "--robot"];
    let silent = run(&folder, &base);
    assert!(silent.err.is_empty(), "{}", silent.err);
    let told = run(&folder, &[&base[..], &["--progress"]].concat());
    assert!(
        told.err.contains("optimising: ") && told.err.contains("the whole robot: joints: 1 of 1\n"),
        "{}",
        told.err
    );
    let lines = told.err.lines().filter(|l| l.starts_with("optimising")).count();
    assert!((2..=11).contains(&lines), "{}", told.err);
    assert_eq!(told.out, silent.out, "the answer is the same");
    let quiet = run(&folder, &[&base[..], &["--quiet"]].concat());
    assert!(quiet.err.is_empty() && quiet.out == silent.out);
    let both = run(&folder, &[&base[..], &["--quiet", "--progress"]].concat());
    assert!(both.status == 2 && both.err.contains("cannot be used with"), "{}", both.err);
    // A short study is silent without a terminal; with `--progress` it is not.
    let study = |name: &str, more: &[&str]| {
        run(&folder, &[&["study", "robot.toml", "--catalog", "motors.csv", "--out", name], more].concat())
    };
    assert!(study("a", &[]).err.is_empty());
    assert!(study("b", &["--progress"]).err.contains("1 of 1 robots"));
    assert!(study("c", &["--quiet"]).err.is_empty());
}

/// A tolerance for all numbers that state none, and none without it.
#[test]
fn a_tolerance_may_be_assumed() {
    let folder = folder();
    let robust = |more: &[&str]| {
        let base = ["optimize", "robot.toml", "--catalog", "motors.csv", "--robust", "--json"];
        let ran = run(&folder, &[&base[..], more].concat());
        // Without any tolerance nothing is known to be kept over them.
        assert_eq!(ran.status, i32::from(more.is_empty()), "{}", ran.err);
        assert_eq!(ran.err.contains("states no tolerance"), more.is_empty(), "{}", ran.err);
        serde_json::from_str::<serde_json::Value>(&ran.out).unwrap()["joints"][0].clone()
    };
    let (plain, wide) = (robust(&[]), robust(&["--tolerance", "5%"]));
    assert!(plain.get("assumed_tolerance").is_none() && wide["assumed_tolerance"] == 0.05);
    assert_eq!(plain["candidates"][0]["nominal_only"], true);
    let tolerances = wide["candidates"][0]["tolerances"].as_array().unwrap();
    let of = |name: &str| tolerances.iter().find(|t| t["column"] == name);
    let resistance = of("resistance").unwrap();
    let share = resistance["tolerance"].as_f64().unwrap() / resistance["value"].as_f64().unwrap();
    assert!((share - 0.05).abs() < 1e-12);
    assert!(of("max_winding_temperature").is_none(), "a share of kelvin says nothing");
    let of = |of: &serde_json::Value, name: &str| of["candidates"][0][name].clone();
    assert!(of(&plain, "worst_objective").is_null());
    assert!(of(&wide, "worst_objective").as_f64().unwrap() > of(&plain, "objective").as_f64().unwrap());
    // What a row states itself stays.
    let motors = MOTORS
        .replace("resistance [ohm],", "resistance [ohm],resistance_tolerance [ohm],")
        .replace("dc,0.5,", "dc,0.5,0.01,");
    fs::write(folder.path().join("motors.csv"), motors.replace("dc,0.7,", "dc,0.7,,")).unwrap();
    let stated = robust(&["--tolerance", "5%"]);
    let all = stated["candidates"].as_array().unwrap();
    let alpha = all.iter().find(|c| c["motor"] == "alpha-1").unwrap();
    let resistance = alpha["tolerances"].as_array().unwrap().iter().find(|t| t["column"] == "resistance").unwrap();
    assert!((resistance["tolerance"].as_f64().unwrap() / resistance["value"].as_f64().unwrap() - 0.02).abs() < 1e-12);
    for (wrong, said) in [("5", "is not a tolerance"), ("120%", "is not a tolerance"), ("x", "is not a tolerance")] {
        let ran =
            run(&folder, &["optimize", "robot.toml", "--catalog", "motors.csv", "--robust", "--tolerance", wrong]);
        assert!(ran.status == 2 && ran.err.contains(said), "{wrong}: {}", ran.err);
    }
    let alone = run(&folder, &["optimize", "robot.toml", "--tolerance", "5%"]);
    assert!(alone.status == 2 && alone.err.contains("--robust"), "{}", alone.err);
}

/// The first gears of each motor alone, in the order that is asked for.
#[test]
fn gears_per_motor() {
    let folder = folder();
    let header = "id,kind,ratio,stages,efficiency,mass [g],inertia [g*cm^2],continuous_torque [N*m],peak_torque [N*m],fits,source,source_kind\n";
    let rows: String = [7, 9, 12]
        .iter()
        .map(|n| format!("planetary-{n},planetary,{n},1,0.9,150,5,40,80,*,a sheet,datasheet\n"))
        .collect();
    fs::write(folder.path().join("gears.csv"), format!("{header}{rows}")).unwrap();
    let geared = REQUIREMENT.replace("ratio = { min = 3, max = 30 }\n", "gears = [\"*\"]\n");
    let geared: String = geared.lines().filter(|l| !l.starts_with("gear = ")).map(|l| format!("{l}\n")).collect();
    fs::write(folder.path().join("geared.toml"), geared).unwrap();
    let sweep = |more: &[&str]| {
        let base = ["sweep", "geared.toml", "--catalog", "motors.csv", "gears.csv", "--csv"];
        let ran = run(&folder, &[&base[..], more].concat());
        assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
        ran.out.lines().skip(1).map(String::from).collect::<Vec<_>>()
    };
    let all = sweep(&[]);
    assert_eq!(all.len(), 6);
    let two = sweep(&["--gears-per-motor", "2"]);
    assert_eq!(two.len(), 4);
    assert!(two.iter().all(|row| all.contains(row)), "nothing else is changed");
    let one = sweep(&["--gears-per-motor", "1"]);
    assert!(one.len() == 2 && two.contains(&one[0]) && one[0] == all[0]);
    let text =
        run(&folder, &["sweep", "geared.toml", "--catalog", "motors.csv", "gears.csv", "--gears-per-motor", "1"]);
    assert!(text.out.contains("Only the first 1 of each motor's gears: 4 designs are left out."), "{}", text.out);
    let wrong = run(&folder, &["sweep", "robot.toml", "--catalog", "motors.csv", "--gears-per-motor", "1"]);
    assert!(wrong.status == 2 && wrong.err.contains("takes gears of the catalogue"), "{}", wrong.err);
}
