//! Transmissions and couplings as a user writes them: answers, and every mistake with its place.

use std::fs;
use std::path::Path;

use super::folder::{Ran, run};

/// A joint by its name, with more of it below.
fn joint(name: &str, more: &str) -> String {
    format!(
        "[[joint]]\nname = \"{name}\"\nratio = {{ min = 1, max = 60 }}\ngear = {{ efficiency = 0.95, mass = \"150 g\" }}\n\
         motors = [\"t-motor-ri50\"]\nmotion = \"knee.csv\"\nobjective = \"loss\"\n{more}\n"
    )
}

const HEAD: &str = "name = \"leg\"\n[bus]\nvoltage = \"48 V\"\n";

/// Text without its line breaks.
fn unfolded(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn motion() -> String {
    let mut text = String::from("time [s], torque [N*m], position [rad]\n");
    for k in 0..=40 {
        let phase = std::f64::consts::TAU * f64::from(k) / 40.0;
        let (q, torque) = (0.4 * phase.sin(), 5.0 + 3.0 * phase.cos());
        text.push_str(&format!("{},{torque},{q}\n", f64::from(k) * 0.02));
    }
    text
}

fn write(folder: &Path, robot: &str) {
    fs::write(folder.join("robot.toml"), robot).unwrap();
    fs::write(folder.join("knee.csv"), motion()).unwrap();
    fs::write(folder.join("speed.csv"), motion().replace("position [rad]", "velocity [rad/s]")).unwrap();
    let table = "position [rad], ratio\n-0.5, 1.5\n-0.2, 1.7\n0.1, 1.9\n0.5, 2.2\n";
    fs::write(folder.join("table.csv"), table).unwrap();
    fs::write(folder.join("short.csv"), table.replace("0.5, 2.2", "0.3, 2.1")).unwrap();
    let both = "position [rad], ratio, actuator_position [rad]\n-0.5, 2, 0\n-0.2, 2, 0.6\n0.1, 2, 1.2\n0.5, 2, 2.0\n";
    fs::write(folder.join("both.csv"), both).unwrap();
    fs::write(folder.join("apart.csv"), both.replace("0.5, 2, 2.0", "0.5, 2, 2.5")).unwrap();
    fs::write(folder.join("unsorted.csv"), table.replace("0.1, 1.9", "-0.4, 1.9")).unwrap();
    for (name, entry) in [("ones.csv", 1), ("zeros.csv", 0)] {
        let mut grid = String::from("position_1 [rad],position_2 [rad],j11,j12,j21,j22\n");
        for (a, b) in (0..16).map(|k| (k / 4, k % 4)) {
            grid += &format!("{},{},{entry},{entry},{entry},{entry}\n", a as f64 - 1.5, b as f64 - 1.5);
        }
        fs::write(folder.join(name), grid).unwrap();
    }
    fs::write(folder.join("nan.csv"), table.replace("1.9", "NaN")).unwrap();
}

/// What the program does with a requirement.
fn optimized(robot: &str, more: &[&str]) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), robot);
    run(&folder, &[&["optimize", "robot.toml"], more].concat())
}

/// The text of stderr of a requirement that is wrong.
fn mistake(robot: &str) -> String {
    let ran = optimized(robot, &[]);
    assert_eq!(ran.status, 2, "{}", ran.out);
    ran.err
}

fn answer(robot: &str, more: &[&str]) -> serde_json::Value {
    let ran = optimized(robot, &[more, &["--json"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    serde_json::from_str(&ran.out).unwrap()
}

fn with(transmission: &str) -> String {
    HEAD.to_string() + &joint("knee", &format!("[joint.transmission]\n{transmission}"))
}

fn pair(coupling: &str) -> String {
    let joints = joint("pitch", "") + &joint("roll", "scale = { torque = 0.5 }");
    format!("{HEAD}{joints}[[coupling]]\nname = \"ankle\"\njoints = [\"pitch\", \"roll\"]\n{coupling}\n")
}

#[test]
fn every_mistake_in_a_transmission_has_its_place() {
    for (transmission, says) in [
        ("", "one of"),
        ("ratio = 0", "0 is not a ratio"),
        ("ratio = \"1.9\"", "ratio"),
        ("ratoi = 2", "did you mean `ratio`"),
        ("ratio = 2\ntable = \"table.csv\"", "not both"),
        ("table = \"no.csv\"", "no.csv"),
        ("table = \"short.csv\"", "outside of the table"),
        ("table = \"unsorted.csv\"", "do not rise"),
        ("table = \"nan.csv\"", "nan.csv"),
        ("table = \"apart.csv\"", "do not agree"),
        ("ratio = 2\nefficiency = 1.4", "efficiency"),
        ("ratio = 2\nmass = \"-1 kg\"", "mass"),
        ("ratio = 2\nmass = 0.3", "unit"),
        ("ratio = 2\nmax_force = \"100 N\"", "needs a rod"),
        ("lever = { pivot = [\"0 mm\", \"180 mm\"], arm = \"50 mm\" }", "lead"),
        ("lever = { pivot = [\"0 mm\"], arm = \"50 mm\", lead = \"5 mm\" }", "[x, y]"),
        (
            "lever = { pivot = [\"0 mm\", \"180 mm\"], arm = \"50 mm\", arm_zero = \"80 deg\", lead = \"5 mm\" }",
            "no torque reaches",
        ),
        (
            "four_bar = { ground = [\"0 mm\", \"250 mm\"], crank = \"40 mm\", coupler = \"100 mm\", rocker = \"45 mm\" }",
            "do not reach",
        ),
        (
            "four_bar = { ground = [\"0 mm\", \"250 mm\"], crank = \"40 mm\", coupler = \"250 mm\", rocker = \"45 mm\", branch = \"up\" }",
            "open",
        ),
    ] {
        let text = mistake(&with(transmission));
        if transmission.is_empty() {
            assert!(text.contains("ratio"), "{text}");
        } else {
            assert!(text.contains(says), "{transmission}: {text}");
        }
        assert!(text.contains("robot.toml:") || text.contains(".csv:"), "{transmission}: {text}");
    }
    // A ratio that goes with the angle needs the angle.
    let text = mistake(&with("table = \"table.csv\"").replace("knee.csv", "speed.csv"));
    assert!(text.contains("needs the position"), "{text}");
    let points = "points = [ { torque = \"5 N*m\", speed = \"1 rad/s\", duration = \"1 s\" } ]";
    let text = mistake(&with("table = \"table.csv\"").replace("motion = \"knee.csv\"", points));
    assert!(text.contains("operating points have none"), "{text}");
    // A spring whose torque goes through a loss that depends on it.
    let spring = "limits = { spring = { stiffness = [\"0 N*m/rad\", \"9 N*m/rad\"], rest_angle = [\"-1 rad\", \"1 rad\"] } }\n[joint.transmission]";
    let text = mistake(&with("ratio = 2\nefficiency = 0.9").replace("[joint.transmission]", spring));
    assert!(text.contains("spring.at = \"actuator\""), "{text}");
}

#[test]
fn every_mistake_in_a_coupling_has_its_place() {
    for (coupling, says) in [
        ("", "matrix"),
        ("matrix = [[1, 1], [1, 1]]", "cannot be inverted"),
        ("matrix = [[1, 1]]", "two rows"),
        ("matrix = [[1, 1], [1, -1]]\ntable = \"table.csv\"", "not both"),
        ("table = \"table.csv\"", "table.csv"),
        ("rods = []", "two rods"),
        ("rods = [ { axis_at = [\"0 mm\", \"0 mm\", \"0 mm\"] } ]", "crank_pin"),
        ("matrix = [[1, 1], [1, -1]]\nefficency = 0.9", "did you mean `efficiency`"),
        ("matrix = [[1, 1], [1, -1]]\nfirst_axis = [1, 0, 0]", "says nothing without `rods`"),
        ("table = \"ones.csv\"", "same direction"),
        ("table = \"zeros.csv\"", "same direction"),
    ] {
        let text = mistake(&pair(coupling));
        assert!(text.contains(says), "{coupling}: {text}");
        assert!(text.contains("robot.toml:") || text.contains(".csv:"), "{coupling}: {text}");
    }
    let good = pair("matrix = [[1, 1], [1, -1]]");
    for (from, to, says) in [
        ("joints = [\"pitch\", \"roll\"]", "joints = [\"pitch\"]", "two joints, not 1"),
        ("joints = [\"pitch\", \"roll\"]", "joints = [\"pitch\", \"rol\"]", "did you mean `roll`"),
        ("joints = [\"pitch\", \"roll\"]", "joints = [\"pitch\", \"pitch\"]", "twice"),
        (
            "name = \"roll\"\nratio = { min = 1, max = 60 }",
            "name = \"roll\"\nratio = { min = 3, max = 20 }",
            "their `ratio` differs",
        ),
        ("name = \"roll\"", "name = \"roll\"\ncount = 2", "their `count` differs"),
        ("scale = { torque = 0.5 }", "scale = { speed = 2 }", "not the same times"),
        ("scale = { torque = 0.5 }", "transmission = { ratio = 2 }", "does not go with a coupling"),
    ] {
        assert!(good.contains(from));
        let text = mistake(&good.replacen(from, to, 1));
        assert!(text.contains(says), "{to}: {text}");
    }
}

#[test]
fn what_a_transmission_makes_of_a_joint_is_said() {
    let plain = answer(&with("ratio = 1"), &[]);
    let belt = answer(&with("ratio = 2\nefficiency = 0.9\nmass = \"100 g\""), &[]);
    let table = answer(&with("table = \"both.csv\""), &[]);
    let of = |json: &serde_json::Value, key: &str| json["joints"][0]["candidates"][0][key].as_f64().unwrap();
    let transmission = &belt["joints"][0]["transmission"];
    assert_eq!(transmission["kind"], "ratio");
    assert!((transmission["joints"][0]["peak_torque_nm"].as_f64().unwrap() - 8.0).abs() < 1e-3);
    assert!(transmission["loss_w"].as_f64().unwrap() > 0.0);
    assert!(table["joints"][0]["transmission"]["loss_w"].is_null(), "no efficiency is given: its loss is not known");
    assert!((of(&belt, "mass_kg") - of(&plain, "mass_kg") - 0.1).abs() < 1e-9);
    // A table of one ratio is that ratio.
    let two = answer(&with("ratio = 2"), &[]);
    assert!((of(&table, "ratio") / of(&two, "ratio") - 1.0).abs() < 1e-6);
    assert!((of(&two, "ratio") * 2.0 / of(&plain, "ratio") - 1.0).abs() < 1e-2, "N r");
    // In words, and what is not known is not said to be nothing.
    for (robot, says, not) in [
        (with("ratio = 2\nefficiency = 0.9"), "it loses", "is not known"),
        (with("ratio = 2"), "its loss is not known", "it loses"),
    ] {
        let text = unfolded(&optimized(&robot, &["--full"]).out);
        assert!(text.contains("Transmission (ratio): r = 2") && text.contains(says), "{text}");
        let line = text.split("Transmission (ratio)").nth(1).unwrap().split(". Torques").nth(1).unwrap();
        let line = &line[..line.len().min(200)];
        assert!(!line.contains(not), "{line}");
    }
}

#[test]
fn a_coupling_is_one_joint_of_two_actuators() {
    let json = answer(&pair("matrix = [[1, 1], [1, -1]]"), &[]);
    let joint = &json["joints"][0];
    assert_eq!((joint["joint"].as_str(), joint["count"].as_u64()), (Some("ankle"), Some(2)));
    assert_eq!(json["joints"].as_array().unwrap().len(), 1);
    let transmission = &joint["transmission"];
    assert_eq!(transmission["joints"][1]["of"], "roll");
    assert_eq!(transmission["actuators"][1]["of"], "actuator 2");
    // τ_θ = ½ (τ_1 ± τ_2), and roll is half of pitch.
    let peak = |k: usize| transmission["actuators"][k]["peak_torque_nm"].as_f64().unwrap();
    assert!((peak(0) - 6.0).abs() < 1e-2 && (peak(1) - 2.0).abs() < 1e-2, "{} {}", peak(0), peak(1));
}

#[test]
fn a_search_over_one_number_says_what_is_proved() {
    let robot = with("ratio = 2\nefficiency = 0.97\ninertia = \"1e-3 kg*m^2\"");
    let over = |range: &str, more: &[&str]| optimized(&robot, &[&["--search", range, "--points", "5"], more].concat());
    let whole = "joint.knee.transmission.ratio=0.5:6";
    let json = answer(&robot, &["--search", whole, "--points", "5"]);
    let values = json["values"].as_array().unwrap();
    let at = |v: &serde_json::Value| (v["value"].as_f64().unwrap(), v["objective"].as_f64().unwrap());
    let least = values.iter().map(at).fold((0.0, f64::INFINITY), |a, b| if b.1 < a.1 { b } else { a });
    assert_eq!(json["best"].as_f64().unwrap(), least.0);
    assert!(values.len() > 12 && values.windows(2).all(|w| at(&w[0]).0 < at(&w[1]).0));
    // Each value is what the requirement with it gives.
    let value = at(&values[0]).0;
    let objective = values[0]["joints"][0]["objective"].as_f64().unwrap();
    let set = format!("joint.knee.transmission.ratio={value}");
    let alone = answer(&robot, &["--set", &set]);
    assert_eq!(alone["joints"][0]["candidates"][0]["objective"].as_f64().unwrap(), objective);
    let text = unfolded(&over(whole, &[]).out);
    assert!(text.contains("not between the values"), "{text}");
    assert!(!text.contains("proved optimum"), "{text}");
    for (range, says) in [
        ("joint.knee.transmission.ratio", "there is no `=`"),
        ("joint.knee.transmission.ratio=2", "no `:`"),
        ("joint.knee.transmission.ratio=3:1", "upside down"),
        ("joint.knee.transmission.ratio=a:b", "not a number"),
        ("joint.knee.transmission.ratoi=1:3", "ratoi"),
    ] {
        let ran = over(range, &[]);
        assert_eq!(ran.status, 2, "{range}");
        assert!(ran.err.contains(says), "{range}: {}", ran.err);
    }
}
