//! Several answers about one design agree: what limits hold it to is what is checked, exported and written.

use std::fs;

use serde_json::Value;
use tempfile::TempDir;

use super::folder::{self, Ran};

const MOTOR: &str = "id,terminals,current,pole_pairs,resistance [ohm],inductance [H],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],peak_current [A],continuous_current [A],max_winding_temperature [degC],thermal_resistance_winding_housing [K/W],thermal_resistance_housing_ambient [K/W],coulomb_friction [N*m],viscous_friction [N*m*s/rad],max_speed [rad/s],price,price_currency,price_date,source,source_kind
m,q_axis,q_axis,7,0.2,0.0001,0.1,1e-4,0.5,40,12,120,0.5,2,0.005,1e-5,,50,EUR,2026-10-01,x,derived
n,q_axis,q_axis,7,0.2,0.0001,0.1,1e-4,0.5,,12,,,,0.005,1e-5,,,,,x,derived
fast,q_axis,q_axis,7,0.2,0.0001,0.1,1e-5,0.3,,10,,,,0,0,300,,,,x,derived
";

const GEAR: &str = "id,kind,ratio,efficiency,mass [kg],inertia [kg*m^2],continuous_torque [N*m],peak_torque [N*m],momentary_peak_torque [N*m],max_input_speed [rad/s],stiffness [N*m/rad],backlash [rad],source,source_kind
g,strain_wave,50,0.8,0.3,1e-5,20,50,100,200,20000,0.001,x,derived
";

const JOINT: &str = "name = \"x\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"30 A\"\n[[joint]]\nname = \"j\"\nratio = { min = 5, max = 20 }\ngear = { efficiency = 0.9, mass = \"0.1 kg\" }\nobjective = \"loss\"\npoints = [ { torque = \"3 N*m\", speed = \"2 rad/s\", duration = \"1 s\" } ]\n";

/// A folder with motors, a gear and the files that are given.
fn with(files: &[(&str, &str)]) -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, text) in [("m.csv", MOTOR), ("g.csv", GEAR)].iter().chain(files) {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn parsed(ran: &Ran) -> Value {
    serde_json::from_str(&ran.out).unwrap_or_else(|_| panic!("{}", ran.err))
}

/// The first joint of an export as JSON.
fn exported(folder: &TempDir, design: &str, catalog: &[&str]) -> Value {
    let ran = folder::run(folder, &[&["export", design, "r.toml", "--to", "json", "--catalog"], catalog].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    parsed(&ran)["joints"][0].clone()
}

fn near(value: &Value, expected: f64) {
    let found = value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    assert!((found / expected - 1.0).abs() < 1e-3, "{found} {expected}");
}

#[test]
fn the_worst_of_two_actuators_counts_everywhere() {
    let row = |speed: u32| (0..6).map(|k| format!("{},2,{speed},0,0,0\n", 0.02 * f64::from(k))).collect::<String>();
    let head = "time [s],torque [N*m],velocity [rad/s],acceleration [rad/s^2],torque_rate [N*m/s],jerk [rad/s^3]\n";
    let (slow, fast) = (format!("{head}{}", row(5)), format!("{head}{}", row(40)));
    for matrix in ["[[1, 0], [0, 1]]", "[[0, 1], [1, 0]]"] {
        let joint = |name: &str, motion: &str| {
            format!(
                "[[joint]]\nname = \"{name}\"\nratio = {{ min = 5, max = 50 }}\ngear = {{ efficiency = 1.0 }}\nmotion = \"{motion}\"\nobjective = \"loss\"\n"
            )
        };
        let robot = format!(
            "name = \"x\"\n[bus]\nvoltage = \"100 V\"\n{}{}[[coupling]]\nname = \"cc\"\njoints = [\"j1\", \"j2\"]\nmatrix = {matrix}\n",
            joint("j1", "a.csv"),
            joint("j2", "b.csv")
        );
        let design = "requirement = \"r.toml\"\n[[joint]]\nname = \"cc\"\nmotor = \"fast\"\nratio = 10\n";
        let folder = with(&[("r.toml", &robot), ("design.toml", design), ("a.csv", &slow), ("b.csv", &fast)]);
        let ran = folder::run(&folder, &["check", "design.toml", "--catalog", "m.csv", "--json"]);
        let answer = parsed(&ran);
        let found: Vec<&Value> =
            answer["findings"].as_array().unwrap().iter().filter(|f| f["subject"] == "max_speed").collect();
        assert_eq!((ran.status, found.len()), (1, 1), "{answer}");
        // 40 rad/s behind 10:1 of 300 rad/s.
        near(&found[0]["value"], 400.0);
        let ran = folder::run(&folder, &["explain", "fast@10", "r.toml", "--catalog", "m.csv", "--json"]);
        let text = parsed(&ran).to_string();
        let margin = text.split("\"margins\":").nth(1).and_then(|rest| rest.split("\"max_speed\":").nth(1)).unwrap();
        let margin: f64 = margin.split([',', '}']).next().unwrap().parse().unwrap();
        assert!((margin - (1.0 - 400.0 / 300.0)).abs() < 1e-9, "{margin}");
    }
}

#[test]
fn a_price_that_all_points_share_holds_between_them() {
    let point = |ratio: u32, efficiency: f64, price: u32| {
        format!(
            "[[point]]\nratio = {ratio}\nefficiency = {efficiency}\nmass = \"0.2 kg\"\ninertia = \"1e-6 kg*m^2\"\npeak_torque = \"80 N*m\"\nmax_input_speed = \"400 rad/s\"\nprice = {price}\nprice_currency = \"EUR\"\nprice_date = \"2026-10-01\"\n"
        )
    };
    let family = |other: u32| {
        let head =
            "name = \"fam\"\nkind = \"planetary\"\nmass_covers = \"gear\"\nsource = \"x\"\nsource_kind = \"derived\"\n";
        format!("{head}{}{}", point(5, 0.95, 100), point(20, 0.9, other))
    };
    let robot = "name = \"f\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"30 A\"\n[prices]\ncurrency = \"EUR\"\ndate = \"2026-11-01\"\n[[joint]]\nname = \"j\"\nmotors = [\"m\"]\nfamily = [\"fam\"]\nbetween = true\nobjective = \"loss\"\npoints = [ { torque = \"10 N*m\", speed = \"8 rad/s\", duration = \"0.2 s\" }, { torque = \"-3 N*m\", speed = \"6 rad/s\", duration = \"0.3 s\" } ]\n[joint.limits]\nprice = \"200 EUR\"\n";
    let run = |other: u32| {
        let folder = with(&[("r.toml", robot), ("fam.toml", &family(other))]);
        folder::run(&folder, &["optimize", "r.toml", "--catalog", "m.csv", "fam.toml", "--json"])
    };
    let ran = run(100);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
    let answer = parsed(&ran);
    // 100 EUR and 50 EUR of 200.
    near(&answer["joints"][0]["candidates"][0]["margins"]["price"], 0.25);
    // A price that differs is not known between the points: the requirement is refused.
    assert_eq!(run(101).status, 2);
}

#[test]
fn a_model_is_held_to_what_the_gear_allows() {
    let hardware = "[[joint]]\nnames = [\"a\"]\nmotor = \"m\"\ngear = \"g\"\nvoltage = \"48 V\"\n[[joint]]\nnames = [\"b\"]\nmotor = \"n\"\ngear = \"g\"\nvoltage = \"48 V\"\n";
    let model = |effort: [f64; 2], velocity: f64| {
        let joint = |name: &str, effort: f64, parent: u8| {
            format!(
                "<joint name=\"{name}\" type=\"revolute\"><parent link=\"l{parent}\"/><child link=\"l{}\"/><axis xyz=\"0 0 1\"/><limit effort=\"{effort}\" velocity=\"{velocity}\" lower=\"-1\" upper=\"1\"/></joint>",
                parent + 1
            )
        };
        format!(
            "<robot name=\"r\"><link name=\"l0\"/><link name=\"l1\"/><link name=\"l2\"/>{}{}</robot>",
            joint("a", effort[0], 0),
            joint("b", effort[1], 1)
        )
    };
    let found = |effort: [f64; 2], velocity: f64| {
        let folder = with(&[("hw.toml", hardware), ("r.urdf", &model(effort, velocity))]);
        let arguments = ["check-model", "r.urdf", "--against", "hw.toml", "--catalog", "m.csv", "g.csv", "--json"];
        let answer = parsed(&folder::run(&folder, &arguments));
        let one = |f: &Value| (f["code"].as_str().unwrap().to_string(), f["bound"].as_f64().unwrap_or(f64::NAN));
        let all: Vec<(String, f64)> = answer["findings"].as_array().unwrap().iter().map(one).collect();
        let of = |code: &str| all.iter().filter(|(c, _)| c == code).map(|(_, bound)| *bound).collect::<Vec<f64>>();
        (of("GW401"), of("GW403"))
    };
    // The peak of the gear, not its momentary one; of a motor without a peak as well. Its input turns with 200/50 rad/s at the joint.
    assert_eq!(found([100.0, 500.0], 6.7), (vec![50.0; 2], vec![4.0; 2]));
    assert_eq!(found([50.0, 50.0], 4.0), (vec![], vec![]));
}

#[test]
fn both_rotors_of_a_coupling_are_the_armature() {
    let hardware = "[[joint]]\nnames = [\"*\"]\nmotor = \"m\"\nratio = 1\n[[coupling]]\njoints = [\"p\", \"q\"]\nmatrix = [[1, 1], [2, -1]]\n";
    let model = |p: f64, q: f64| {
        format!(
            "<mujoco><worldbody><body><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><joint name=\"p\" armature=\"{p}\" frictionloss=\"0.015\"/><body><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><joint name=\"q\" armature=\"{q}\" frictionloss=\"0.01\"/></body></body></worldbody></mujoco>"
        )
    };
    let found = |p: f64, q: f64| {
        let folder = with(&[("hw.toml", hardware), ("r.xml", &model(p, q))]);
        let arguments = ["check-model", "r.xml", "--against", "hw.toml", "--catalog", "m.csv", "--json"];
        let answer = parsed(&folder::run(&folder, &arguments));
        let of = answer["findings"].as_array().unwrap().iter().filter(|f| f["code"] == "GW406");
        of.map(|f| f["bound"].as_f64().unwrap()).collect::<Vec<f64>>()
    };
    // JᵀJ of [[1, 1], [2, −1]] has 5 and 2 on its diagonal.
    assert_eq!(found(5e-4, 2e-4), Vec::<f64>::new());
    let wrong = found(1e-4, 1e-4);
    assert!(
        wrong.len() == 2 && (wrong[0] / 5e-4 - 1.0).abs() < 1e-12 && (wrong[1] / 2e-4 - 1.0).abs() < 1e-12,
        "{wrong:?}"
    );
}

#[test]
fn the_continuous_torque_is_the_least_that_the_limits_hold() {
    let hot = JOINT.replace(
        "drive_current = \"30 A\"\n",
        "drive_current = \"30 A\"\ndrive_continuous_current = \"4 A\"\n[ambient]\ntemperature = \"80 degC\"\n",
    );
    let folder = with(&[("r.toml", &hot)]);
    // 4 A of amplitude are √1.5 · 4 A on the q axis.
    near(&exported(&folder, "m@10", &["m.csv"])["continuous_effort_nm"], 1.5_f64.sqrt() * 4.0 * 0.1 * 10.0);
    // Above 40 °C what is left of 12 A; the winding allows less or more by its resistances, and there are none here.
    let bare = MOTOR.replace("40,12,120,0.5,2,0.005", "40,12,120,,,0.005");
    let folder = with(&[("r.toml", &hot.replace("drive_continuous_current = \"4 A\"\n", "")), ("bare.csv", &bare)]);
    let held = exported(&folder, "m@10", &["bare.csv"])["continuous_effort_nm"].as_f64().unwrap();
    assert!(held <= 12.0 * 0.5_f64.sqrt() * 0.1 * 10.0 * (1.0 + 1e-9), "{held}");
}

#[test]
fn the_corner_behind_a_transmission_is_that_of_its_torque() {
    let robot = format!("{JOINT}[joint.transmission]\nratio = 2\npeak_torque = \"20 N*m\"\n");
    let joint = exported(&with(&[("r.toml", &robot)]), "m@10", &["m.csv"]);
    near(&joint["effort_nm"], 20.0);
    near(&joint["velocity_at_effort_rad_per_s"], joint["line"]["corner_rad_per_s"].as_f64().unwrap());
    near(&joint["continuous_effort_nm"], 20.0);
}

#[test]
fn brushes_are_friction_that_is_exported() {
    let motor = "id,terminals,current,commutation,resistance [ohm],inductance [H],torque_constant [N*m/A],rotor_inertia [kg*m^2],mass [kg],peak_current [A],continuous_current [A],no_load_current [A],no_load_speed [rad/s],voltage [V],source,source_kind\nb,line_to_line,dc,brushed,0.5,0.0001,0.05,1e-5,0.3,20,6,0.5,460,24,x,derived\n";
    let folder = with(&[("r.toml", &JOINT.replace("max = 20", "max = 100")), ("b.csv", motor)]);
    // N K_T I_0.
    near(&exported(&folder, "b@50", &["b.csv"])["friction_loss_nm"], 50.0 * 0.05 * 0.5);
}

#[test]
fn the_bench_gear_is_not_the_gear_that_is_mounted() {
    let fitted = "gearwise = \"0.1.0\"\n[motor]\nid = \"fit\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\npole_pairs = 7\nresistance = \"0.2 ohm\"\ninductance = \"0.1 mH\"\ntorque_constant = \"0.1 N*m/A\"\nrotor_inertia = \"1e-4 kg*m^2\"\nmass = \"0.5 kg\"\npeak_current = \"40 A\"\ncontinuous_current = \"12 A\"\ncoulomb_friction = \"0.005 N*m\"\n[gear]\nratio = 6\n[effects.gear_compliance]\ncompliance = \"1e-3 rad/(N*m)\"\n[effects.backlash]\nhalf_play = \"0.02 rad\"\n";
    let robot = JOINT.replace(
        "ratio = { min = 5, max = 20 }\ngear = { efficiency = 0.9, mass = \"0.1 kg\" }\n",
        "gears = [\"g\"]\n",
    );
    let folder = with(&[("r.toml", &robot), ("fit.toml", fitted)]);
    let joint = exported(&folder, "fit@g", &["fit.toml", "g.csv"]);
    near(&joint["gear_stiffness_nm_per_rad"], 20000.0);
    near(&joint["backlash_rad"], 0.001);
}

#[test]
fn a_negative_gear_of_a_model_stays_negative() {
    let body = "<worldbody><body name=\"b\"><joint name=\"knee\" type=\"hinge\"/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/></body></worldbody>";
    let own =
        format!("<mujoco>{body}<actuator><motor name=\"p\" joint=\"knee\" gear=\"-4 0 0 0 0 0\"/></actuator></mujoco>");
    // Stated by a class, which the actuator names or which all inherit from; the actuator's own gear comes first.
    let of_class = |defaults: &str, motor: &str| {
        format!(
            "<mujoco><default>{defaults}</default>{body}<actuator><motor name=\"p\" joint=\"knee\" {motor}/></actuator></mujoco>"
        )
    };
    let turned = "<default class=\"turned\"><motor gear=\"-4\"/></default>";
    for (model, gear) in [
        (own, "-10"),
        (of_class(turned, "class=\"turned\""), "-10"),
        (of_class("<general gear=\"-4\"/>", ""), "-10"),
        (of_class(turned, ""), "10"),
        (of_class("<motor gear=\"-4\"/>", "gear=\"4\""), "10"),
    ] {
        let folder = with(&[("r.toml", JOINT), ("robot.xml", &model)]);
        let arguments = ["export", "m@10", "r.toml", "--catalog", "m.csv", "--into", "robot.xml", "--map", "j=knee"];
        let ran = folder::run(&folder, &arguments);
        assert_eq!(ran.status, 0, "{}", ran.err);
        let document = roxmltree::Document::parse(&ran.out).unwrap();
        let motor = document.descendants().find(|n| n.has_tag_name("actuator")).unwrap().first_element_child().unwrap();
        assert_eq!(motor.attribute("gear").unwrap().split(' ').next(), Some(gear), "{model}");
    }
}

#[test]
fn a_mechanism_played_faster_asks_for_the_torque_of_the_fast_motion() {
    let arm = "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"l1\" pos=\"0 0 0\"><joint name=\"j1\" type=\"hinge\" axis=\"0 0 1\"/><inertial pos=\"0.5 0 0\" mass=\"2\" diaginertia=\"0.01 0.1 0.1\"/></body></worldbody></mujoco>";
    let swing = |period: f64| {
        let row = |k: u32| {
            let part = f64::from(k) / 40.0;
            format!("{},{}\n", period * part, 0.5 * (std::f64::consts::TAU * part).sin())
        };
        format!("time [s],j1 [rad]\n{}", (0..=40).map(row).collect::<String>())
    };
    let explained = |trajectory: &str, scale: &str, set: &[&str]| {
        let robot = format!(
            "name = \"s\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"60 A\"\n[mechanism]\nmodel = \"arm.xml\"\ntrajectory = \"t.csv\"\n[[joint]]\nname = \"j\"\nmechanism_joint = \"j1\"\nratio = {{ min = 2, max = 60 }}\ngear = {{ efficiency = 0.9, mass = \"0.1 kg\" }}\nobjective = \"loss\"\n{scale}"
        );
        let folder = with(&[("r.toml", &robot), ("arm.xml", arm), ("t.csv", trajectory)]);
        let ran = folder::run(&folder, &[&["explain", "m@20", "r.toml", "--catalog", "m.csv", "--json"], set].concat());
        let text = parsed(&ran).to_string();
        let of = |key: &str| -> f64 {
            let rest = text.split(&format!("\"{key}\":")).nth(1).unwrap_or_else(|| panic!("{key}: {text}"));
            rest.split([',', '}']).next().unwrap().parse().unwrap()
        };
        (of("loss_w"), of("peak_current_q_a"))
    };
    let fast = explained(&swing(0.5), "", &[]);
    for (scale, set) in [
        ("scale = { speed = 2 }\n", &[][..]),
        ("", &["--set", "scale.speed=2"]),
        ("scale = { speed = 4 }\n", &["--set", "scale.speed=0.5"]),
    ] {
        let scaled = explained(&swing(1.0), scale, set);
        assert!(
            (scaled.0 / fast.0 - 1.0).abs() < 1e-6 && (scaled.1 / fast.1 - 1.0).abs() < 1e-6,
            "{scaled:?} {fast:?}"
        );
    }
    // All of the torque is inertia, and half the torque at half the speed would be another answer.
    assert!(fast.1 > 2.0 * explained(&swing(1.0), "", &[]).1);
}
