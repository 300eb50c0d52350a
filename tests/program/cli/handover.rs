//! Hand-over to every simulator: the numbers of each format on paper, what it cannot say in its comments, ranges and draws, and
//! what is refused. That simulators then do as the model says is run in them (tests/external).

use std::path::Path;

use approx::assert_relative_eq;
use roxmltree::Document;
use serde_json::Value;

use crate::common::run::{gearwise, stderr, stdout};

const FORMATS: [&str; 12] = [
    "mjcf",
    "dcmotor",
    "isaaclab2",
    "isaaclab3",
    "mjlab",
    "unitree",
    "newton",
    "physx",
    "urdf",
    "sdf",
    "ros2_control",
    "json",
];
const XML: [&str; 5] = ["mjcf", "dcmotor", "urdf", "sdf", "ros2_control"];

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

/// A fitted actuator whose every number is chosen: K_T 0.1, R 0.5 ohm at 25 °C, 20 A, behind N = 10 on 48 V.
const FITTED: &str = "gearwise = \"0.1.0\"\n[motor]\nid = \"f\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\n\
    resistance = \"0.5 ohm\"\ninductance = \"1 mH\"\npole_pairs = 4\ntorque_constant = \"0.1 N*m/A\"\n\
    rotor_inertia = \"2e-5 kg*m^2\"\nrotor_inertia_tolerance = \"1e-6 kg*m^2\"\npeak_current = \"20 A\"\nmax_speed = \"300 rad/s\"\n\
    viscous_friction = \"1e-4 N*m*s/rad\"\nmax_winding_temperature = \"120 degC\"\n\
    thermal_resistance_winding_housing = \"1 K/W\"\nthermal_resistance_housing_ambient = \"3 K/W\"\n\
    thermal_time_constant_winding = \"20 s\"\nthermal_time_constant_housing = \"400 s\"\n\
    source = \"a bench\"\nsource_kind = \"measured\"\n\
    [effects.coulomb_friction]\ntorque = \"0.02 N*m\"\ntorque_tolerance = \"0.004 N*m\"\n\
    [effects.stribeck_friction]\ntorque = \"0.01 N*m\"\nspeed = \"8 rad/s\"\n\
    [effects.gear_compliance]\ncompliance = \"2e-3 rad/(N*m)\"\n\
    [effects.backlash]\nhalf_play = \"0.004 rad\"\n\
    [[provenance]]\nlog = \"run.csv\"\n";

/// Cogging of one order; what is usable is less by its amplitude.
const COGGING: &str = "[[effects.cogging]]\norder = 12\ncosine = \"0.003 N*m\"\nsine = \"-0.004 N*m\"\n";

fn robot(joint: &str, more: &str) -> String {
    format!(
        "name = \"x\"\nbus = {{ voltage = \"48 V\" }}\n[[joint]]\nname = {}\nmotor_drag = \"off\"\nratio = {{ min = 3, max = 30 }}\n\
         gear = {{ efficiency = 0.8, backdrive_efficiency = 0.75, inertia = \"1e-5 kg*m^2\" }}\n\
         points = [ {{ torque = \"0.5 N*m\", speed = \"3 rad/s\", duration = \"1 s\" }} ]\n{more}",
        toml::Value::String(joint.into())
    )
}

/// The example's files, and the arguments that export it.
fn example(folder: &Path, joint: &str, more: &str) -> Vec<String> {
    let fitted = write(folder, "f.toml", FITTED);
    let robot = write(folder, "robot.toml", &robot(joint, more));
    ["export", "f@10", &robot, "--catalog", &fitted].map(String::from).to_vec()
}

fn run(base: &[String], more: &[&str]) -> std::process::Output {
    let arguments: Vec<&str> = base.iter().map(String::as_str).chain(more.iter().copied()).collect();
    gearwise(&arguments)
}

fn text(base: &[String], more: &[&str]) -> String {
    let output = run(base, more);
    assert_eq!(output.status.code(), Some(0), "{more:?}: {}", stderr(&output));
    stdout(&output)
}

fn json(base: &[String], more: &[&str]) -> Value {
    let all: Value = serde_json::from_str(&text(base, &[&["--to", "json"], more].concat())).unwrap();
    all["joints"][0].clone()
}

/// The number behind `key` in Python, USD or as an attribute.
fn number(text: &str, key: &str) -> f64 {
    let at = text.find(key).unwrap_or_else(|| panic!("{key}:\n{text}")) + key.len();
    let rest = text[at..].trim_start_matches([' ', '=', '"', '>']);
    let end = rest.find(|c: char| !matches!(c, '0'..='9' | '.' | '-' | 'e')).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|e| panic!("{key}: {e}: {rest}"))
}

/// The line on paper: K_T I = 2 N*m at the motor, hot R, the voltage circle with L.
fn on_paper() -> (f64, f64, f64, f64) {
    let volt = 48.0 / 2.0_f64.sqrt();
    let hot = 0.5 * (1.0 + 0.00393 / (1.0 + 0.00393 * 5.0) * 95.0);
    let (i, k, pl) = (20.0, 0.1, 4.0 * 1e-3);
    let (a, b, c): (f64, f64, f64) = (k * k + (pl * i) * (pl * i), hot * i * k, (hot * i) * (hot * i) - volt * volt);
    let corner = (-b + (b * b - a * c).sqrt()) / a / 10.0;
    let free = volt / k / 10.0;
    (20.0, 20.0 / (1.0 - corner / free), free, corner)
}

#[test]
fn every_format_says_the_numbers_on_paper() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let (e, s, free, corner) = on_paper();
    let of = |to: &str| text(&base, &["--to", to]);
    let is = |text: &str, key: &str, expected: f64| {
        let found = number(text, key);
        assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{key}: {found}, {expected} expected\n{text}");
    };
    let dcmotor = of("dcmotor");
    let document = Document::parse(&dcmotor).unwrap();
    let motor = document.descendants().find(|n| n.has_tag_name("dcmotor")).unwrap();
    let list =
        |name: &str| -> Vec<f64> { motor.attribute(name).unwrap().split(' ').map(|v| v.parse().unwrap()).collect() };
    // Stall K V'/R' and speed without load V'/K, at the motor.
    let (k, r, v) = (list("motorconst")[0], list("resistance")[0], list("controller")[5]);
    assert_relative_eq!(k, 0.1, max_relative = 1e-11);
    assert_relative_eq!(k * v / r, s / 10.0, max_relative = 1e-9);
    assert_relative_eq!(v / k, free * 10.0, max_relative = 1e-9);
    assert_relative_eq!(list("saturation")[0], 2.0, max_relative = 1e-11);
    assert_relative_eq!(list("armature")[0], 3e-5, max_relative = 1e-11);
    assert_relative_eq!(list("damping")[0], 1e-4, max_relative = 1e-11);
    is(&dcmotor, "frictionloss", 0.2);
    assert!(motor.attribute("thermal").is_none() && motor.attribute("inductance").is_none());
    let all = text(&base, &["--to", "dcmotor", "--thermal", "--electrical"]);
    is(&all, "inductance=\"0 ", 2e-3);
    // R_th R_hot/R', no coefficient.
    let hot = 0.5 * (1.0 + 0.00393 / (1.0 + 0.00393 * 5.0) * 95.0);
    is(&all, "thermal=", 4.0 * hot / r);
    let thermal = all.split("thermal=\"").nth(1).unwrap().split('"').next().unwrap();
    assert!(thermal.ends_with(" 0 400 0 120 25"), "{thermal}");

    let lab = of("isaaclab2");
    for (key, expected) in [
        (" effort_limit", e),
        ("saturation_effort", s),
        (" velocity_limit", free),
        ("velocity_limit_sim", 30.0),
        ("armature", 3e-3),
        ("viscous_friction", 1e-2),
        (" friction", 0.3),
        ("dynamic_friction", 0.2),
    ] {
        is(lab.split("def knee").nth(1).unwrap(), &format!("{key}="), expected);
    }
    let unitree = of("unitree");
    for (key, expected) in [("X1", corner), ("X2", free), ("Y1", 0.8 * e), ("Y2", e / 0.75), ("Fs", 0.2), ("Fd", 1e-2)]
    {
        is(&unitree, &format!(" {key}="), expected);
    }
    let newton = of("newton");
    is(&newton, "newton:damping", 1e-2_f64.to_radians());
    is(&newton, "newton:saturationEffort", s);
    let physx = of("physx");
    is(&physx, "speedEffortGradient", (free / s).to_degrees());
    is(&physx, "maxJointVelocity", 30.0_f64.to_degrees());
    is(&physx, "staticFrictionEffort", 0.3);
    let sdf = of("sdf");
    is(&sdf, "<effort", e);
    is(&sdf, "<damping", 1e-2);
    is(&sdf, "<drake:rotor_inertia", 3e-5);
    is(&sdf, "<drake:gear_ratio", 10.0);
    let ros = of("ros2_control");
    is(&ros, "<mechanical_reduction", 10.0);
    is(&ros, "name=\"max\"", e);
    let facts = json(&base, &[]);
    assert_relative_eq!(facts["line"]["stall_nm"].as_f64().unwrap(), s, max_relative = 1e-9);
    assert_relative_eq!(facts["line"]["corner_rad_per_s"].as_f64().unwrap(), corner, max_relative = 1e-9);
    assert_relative_eq!(facts["braking_effort_nm"].as_f64().unwrap(), e, max_relative = 1e-12);
    assert_relative_eq!(facts["backlash_rad"].as_f64().unwrap(), 0.008, max_relative = 1e-9);
    assert_relative_eq!(facts["gear_stiffness_nm_per_rad"].as_f64().unwrap(), 500.0, max_relative = 1e-9);
    // A sin(φ) = −a: what the motor has to supply more pulls at the rotor the other way.
    write(folder.path(), "f.toml", &format!("{FITTED}{COGGING}"));
    let with = of("dcmotor");
    let cogging = with.split("cogging=\"").nth(1).unwrap().split('"').next().unwrap();
    let cogging: Vec<f64> = cogging.split(' ').map(|v| v.parse().unwrap()).collect();
    assert_relative_eq!(cogging[0], 0.005, max_relative = 1e-11);
    assert_eq!(cogging[1], 12.0);
    assert_relative_eq!(cogging[2].sin(), -0.6, max_relative = 1e-9);
    assert_relative_eq!(cogging[2].cos(), 0.8, max_relative = 1e-9);
    write(folder.path(), "f.toml", FITTED);
    // Behind the gear's loss.
    let behind = text(&base, &["--to", "mjlab", "--with-efficiency"]);
    is(&behind, " effort_limit", 0.8 * e);
    is(&behind, "saturation_effort", 0.8 * s);
}

#[test]
fn what_a_format_cannot_say_is_in_its_comments() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    write(folder.path(), "f.toml", &format!("{FITTED}{COGGING}"));
    for to in FORMATS.iter().filter(|to| **to != "json") {
        let text = text(&base, &["--to", to]);
        let says = |what: &str| text.lines().any(|line| line.contains("left out: ") && line.contains(what));
        let nearly = |what: &str| text.lines().any(|line| line.contains("nearly: ") && line.contains(what));
        // No simulator here has play or elasticity in a joint of one actuator.
        assert!(says("backlash: β/2") && says("gear_compliance: τ/k"), "{to}\n{text}");
        let cogging = (says("cogging: a_h"), nearly("cogging: a_h"));
        assert_eq!(cogging, if *to == "dcmotor" { (false, true) } else { (true, false) }, "{to}\n{text}");
        let falls = says("torque that falls with speed");
        assert_eq!(falls, ["mjcf", "urdf", "sdf", "ros2_control"].contains(to), "{to}\n{text}");
        let loss = says("gear efficiency 0.8") || nearly("gear efficiency 0.8");
        assert_eq!(loss, *to != "unitree", "{to}\n{text}");
        let at_rest = says("stribeck_friction");
        assert_eq!(at_rest, !["isaaclab2", "isaaclab3", "physx"].contains(to), "{to}\n{text}");
        assert!(says("heating") || nearly("heating"), "{to}\n{text}");
    }
}

/// What is said of a line: how far it is off where it is, and nothing where it is not.
#[test]
fn a_straight_line_says_how_far_it_is_off() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let off = "the line is straight: at ";
    assert!(text(&base, &["--to", "mjlab"]).contains(off));
    let below = text(&base, &["--to", "mjlab", "--line", "below"]);
    assert!(!below.contains("N*m more than the motor") && below.contains("N*m less than the motor"), "{below}");
    let straight = FITTED.replace("inductance = \"1 mH\"\n", "");
    write(folder.path(), "f.toml", &straight);
    let exact = text(&base, &["--to", "mjlab"]);
    assert!(!exact.contains(off), "{exact}");
}

#[test]
fn a_wish_that_a_format_cannot_grant_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let model = write(folder.path(), "m.urdf", "<robot name=\"r\"><joint name=\"knee\" type=\"revolute\"/></robot>");
    for (more, expected) in [
        (vec!["--to", "isaaclab2", "--thermal"], "`--thermal` is not for `isaaclab2`; it is for dcmotor"),
        (vec!["--to", "mjcf", "--with-efficiency"], "`--with-efficiency` is not for `mjcf`"),
        (vec!["--to", "urdf", "--draws", "3"], "`--draws` is not for `urdf`"),
        (vec!["--to", "unitree", "--with-efficiency"], "`--with-efficiency` is not for `unitree`"),
        (vec!["--to", "urdf", "--map", "knee=x"], "`--map` is not for `urdf`"),
        (vec!["--to", "sdf", "--drake"], "`--drake` is not for `sdf`; it is for urdf"),
        (vec!["--to", "json", "--draws", "0"], "0 is not in 1..=1000"),
        (vec!["--to", "json", "--line", "above"], "invalid value 'above'"),
        (vec!["--to", "newton", "--map", "knee=knee"], "`knee` is no path of a prim"),
        (vec!["--to", "newton", "--map", "knee=/Robot/a b"], "is no path of a prim"),
        (vec!["--to", "newton", "--map", "knee=/R/a", "knee=/R/a"], "`/R/a` is meant by two joints"),
        (vec!["--into", &model, "--to", "urdf"], "`--to urdf` is not for a model"),
        (vec!["--into", &model, "--to", "dcmotor"], "`--to dcmotor` is for MJCF"),
        (vec!["--into", &model, "--gear-joint"], "`--gear-joint` is for MJCF"),
        (vec!["--into", &model, "--thermal"], "`--thermal` is not for a model"),
        (vec!["--to", "mjcf", "--gear-joint"], "--into <MODEL>"),
    ] {
        let output = run(&base, &more);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {}", stdout(&output));
        assert!(stderr(&output).contains(expected), "{more:?}: {}", stderr(&output));
        assert!(output.stdout.is_empty(), "{more:?}");
    }
    // What is wished and not known.
    write(
        folder.path(),
        "f.toml",
        &FITTED.replace("inductance = \"1 mH\"\n", "").replace("thermal_time_constant_housing = \"400 s\"\n", ""),
    );
    for (wish, lacks) in
        [("--electrical", "the inductance of f is not known"), ("--thermal", "the thermal time constant")]
    {
        let output = run(&base, &["--to", "dcmotor", wish]);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(lacks), "{}", stderr(&output));
    }
}

/// A module that says a largest torque and a speed without load alone: where a format wants a line, that is said, and the line
/// that is offered instead is called assumed.
#[test]
fn a_line_that_is_not_known_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let robot = "name = \"x\"\nbus = { voltage = \"48 V\" }\n[[joint]]\nname = \"j\"\nmodules = [\"*\"]\n\
                 points = [ { torque = \"0.1 N*m\", speed = \"1 rad/s\", duration = \"1 s\" } ]\n";
    let robot = write(folder.path(), "robot.toml", robot);
    let base = ["export", "damiao-j3507-2ec-48v", &robot].map(String::from);
    for to in ["dcmotor", "isaaclab2", "isaaclab3", "mjlab", "unitree", "newton", "physx"] {
        let output = run(&base, &["--to", to]);
        assert_eq!(output.status.code(), Some(2), "{to}");
        assert!(stderr(&output).contains("up to which speed it has its largest torque is not known"), "{to}");
        let output = run(&base, &["--to", to, "--line", "below"]);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{to}: {}", stderr(&output));
        assert!(stdout(&output).contains("ASSUMED: up to which speed"), "{to}");
    }
    let output = run(&base, &["--to", "json"]);
    let joint: Value = serde_json::from_slice::<Value>(&output.stdout).unwrap()["joints"][0].clone();
    assert!(joint["line"].is_null() && joint["line_below"]["assumed"] == true, "{joint}");
    assert!(joint["heat"].is_null() && joint["electrical_time_constant_s"].is_null());
}

#[test]
fn ranges_come_from_tolerances_and_draws_keep_what_belongs_together() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let facts = json(&base, &["--ranges"]);
    let ranges = facts["ranges"].as_array().unwrap();
    let range = |name: &str| {
        ranges.iter().find(|r| r["name"] == name).map(|r| (r["low"].as_f64().unwrap(), r["high"].as_f64().unwrap()))
    };
    // N² 1e-6 and N 0.004, either way.
    let (low, high) = range("armature").unwrap();
    assert_relative_eq!(low, 2.9e-3, max_relative = 1e-6);
    assert_relative_eq!(high, 3.1e-3, max_relative = 1e-6);
    let (low, high) = range("friction_loss").unwrap();
    assert_relative_eq!((low, high).0, 0.16, max_relative = 1e-6);
    assert_relative_eq!(high, 0.24, max_relative = 1e-6);
    // Nothing else has a ±.
    assert_eq!(ranges.len(), 2, "{ranges:?}");
    assert_eq!(ranges[0]["from"], serde_json::json!(["motor.rotor_inertia"]));
    assert_eq!(facts["draws_are_correlated"], false);

    // Fitted together: Coulomb and viscous friction pull against each other.
    let together = format!(
        "{FITTED}[covariance]\nnames = [\"motor.viscous_friction\", \"effects.coulomb_friction.torque\"]\n\
         matrix = [[1e-10, -1.8e-8], [-1.8e-8, 4e-6]]\n"
    );
    write(folder.path(), "f.toml", &together);
    let facts = json(&base, &["--draws", "800"]);
    assert_eq!(facts["draws_are_correlated"], true);
    let draws = facts["draws"].as_array().unwrap();
    assert_eq!(draws.len(), 800);
    let column = |name: &str| -> Vec<f64> { draws.iter().map(|d| d[name].as_f64().unwrap()).collect() };
    let moments = |x: &[f64], y: &[f64]| {
        let n = x.len() as f64;
        let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
        x.iter().zip(y).map(|(a, b)| (a - mx) * (b - my)).sum::<f64>() / n
    };
    let (damping, friction) = (column("damping"), column("friction_loss"));
    // N² 1e-5 and N 2e-3; correlation −0.9.
    assert!((moments(&damping, &damping).sqrt() / 1e-3 - 1.0).abs() < 0.1);
    assert!((moments(&friction, &friction).sqrt() / 2e-2 - 1.0).abs() < 0.1);
    let correlation =
        moments(&damping, &friction) / (moments(&damping, &damping) * moments(&friction, &friction)).sqrt();
    assert!((correlation + 0.9).abs() < 0.05, "{correlation}");
    let bytes = |threads| run(&base, &["--to", "isaaclab3", "--draws", "4", "--threads", threads]).stdout;
    assert_eq!(bytes("1"), bytes("3"));

    // Without any ± there is no range, and that is said.
    let without: String =
        FITTED.lines().filter(|line| !line.contains("_tolerance")).map(|line| format!("{line}\n")).collect();
    write(folder.path(), "f.toml", &without);
    let output = run(&base, &["--to", "json", "--ranges"]);
    assert!(stderr(&output).contains("no number of f has a ±: no range is written"), "{}", stderr(&output));
    let facts: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(facts["joints"][0]["ranges"].as_array().unwrap().is_empty());
    assert!(!stdout(&run(&base, &["--to", "isaaclab2", "--ranges"])).contains("RANGES"));
}

/// A no-load current of which any part may grow with speed: Coulomb friction is 0 to K_T I_0, viscous friction 0 to K_T I_0/ω_0.
#[test]
fn drag_known_as_a_sum_has_ranges_and_draws_on_its_segment() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let (before, rest) = FITTED.split_once("[effects.coulomb_friction]").unwrap();
    let (_, after) = rest.split_once("[effects.gear_compliance]").unwrap();
    let before = before
        .replace("viscous_friction = \"1e-4 N*m*s/rad\"", "no_load_current = \"0.2 A\"\nno_load_speed = \"400 rad/s\"")
        .replace("rotor_inertia_tolerance = \"1e-6 kg*m^2\"\n", "");
    write(folder.path(), "f.toml", &format!("{before}[effects.gear_compliance]{after}"));
    let facts = json(&base, &["--ranges", "--draws", "200"]);
    let of = |facts: &Value, name: &str| {
        let ranges = facts["ranges"].as_array().unwrap();
        let range = ranges.iter().find(|r| r["name"] == name).unwrap_or_else(|| panic!("{name}: {ranges:?}"));
        assert_eq!(range["from"], serde_json::json!(["motor.no_load_current"]));
        [&range["low"], &range["high"]].map(|end| end.as_f64().unwrap())
    };
    let [low, high] = of(&facts, "friction_loss");
    assert_eq!(low, 0.0);
    assert_relative_eq!(high, 10.0 * 0.02, max_relative = 1e-9);
    let [low, high] = of(&facts, "damping");
    assert_eq!(low, 0.0);
    assert_relative_eq!(high, 100.0 * 0.02 / 400.0, max_relative = 1e-9);
    assert_eq!(facts["ranges"].as_array().unwrap().len(), 2);
    let draws = facts["draws"].as_array().unwrap();
    let shares: Vec<f64> = draws.iter().map(|draw| draw["friction_loss"].as_f64().unwrap() / 0.2).collect();
    for (share, draw) in shares.iter().zip(draws) {
        assert_relative_eq!(draw["damping"].as_f64().unwrap(), (1.0 - share) * 0.005, max_relative = 1e-9);
    }
    assert!((shares.iter().sum::<f64>() / 200.0 - 0.5).abs() < 0.1 && shares.iter().any(|share| *share < 0.05));

    // With a ± of the current the upper ends go with it.
    let wider = before.replace("\"0.2 A\"\n", "\"0.2 A\"\nno_load_current_tolerance = \"10 %\"\n");
    write(folder.path(), "f.toml", &format!("{wider}[effects.gear_compliance]{after}"));
    let facts = json(&base, &["--ranges"]);
    assert_relative_eq!(of(&facts, "friction_loss")[1], 0.22, max_relative = 1e-6);
    assert_relative_eq!(of(&facts, "damping")[1], 0.0055, max_relative = 1e-6);
}

#[test]
fn hostile_names_are_text_in_every_format() {
    for joint in ["a\"<script>&'--", "x\"\"\";import os", "b\\", "]]>", "#usda\u{2028}import os"] {
        let folder = tempfile::tempdir().unwrap();
        let base = example(folder.path(), joint, "");
        for to in FORMATS {
            let text = text(&base, &["--to", to]);
            if XML.contains(&to) {
                let document = Document::parse(&text).unwrap_or_else(|e| panic!("{to}: {e}\n{text}"));
                assert!(document.descendants().all(|n| n.tag_name().name() != "script"), "{to}");
            }
            // Nothing of it starts a line of Python or of USD.
            if !XML.contains(&to) && to != "json" {
                assert!(
                    text.lines().all(|line| !line.starts_with("import os") && !line.starts_with("def\"")),
                    "{to}\n{text}"
                );
            }
        }
    }
}

const SDF: &str = r#"<?xml version="1.0"?>
<sdf version="1.9">
  <!-- a leg -->
  <model name="leg">
    <link name="base"/><link name="link"/>
    <joint name="left_knee" type="revolute">
      <parent>base</parent><child>link</child>
      <axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper><effort>1</effort></limit></axis>   <!-- keep -->
    </joint>
    <joint name="ankle" type="revolute">
      <parent>base</parent><child>link</child>
      <axis><xyz>0 1 0</xyz><limit><effort>7</effort></limit></axis>
    </joint>
  </model>
</sdf>
"#;

#[test]
fn an_sdf_is_patched_where_it_should_and_stays_as_it_is_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let model = write(folder.path(), "model.sdf", SDF);
    let into = |model: &str| text(&base, &["--into", model, "--map", "knee=*_knee"]);
    let patched = into(&model);
    let document = Document::parse(&patched).unwrap();
    let joint = |name: &str| document.descendants().find(|n| n.attribute("name") == Some(name)).unwrap();
    let of = |name: &str, tag: &str| {
        joint(name).descendants().find(|n| n.tag_name().name() == tag).and_then(|n| n.text()).map(str::to_string)
    };
    assert_eq!(of("left_knee", "effort").as_deref(), Some("20"));
    assert_eq!(of("left_knee", "lower").as_deref(), Some("-1"));
    assert_eq!(of("left_knee", "damping").as_deref(), Some("0.01"));
    assert_eq!(of("left_knee", "gear_ratio").as_deref(), Some("10"));
    assert_eq!(of("ankle", "effort").as_deref(), Some("7"));
    assert!(of("ankle", "gear_ratio").is_none());
    assert!(patched.contains("</axis>   <!-- keep -->") || patched.contains("<!-- keep -->"), "{patched}");
    assert!(patched.contains("<!-- a leg -->"));
    let again = write(folder.path(), "again.sdf", &patched);
    assert_eq!(into(&again), patched);
}

/// What was written is read back by `check-model` without findings: behind the gear's loss of every format, and without it with
/// no more than the note that says so.
#[test]
fn what_was_exported_is_read_back_without_findings() {
    let folder = tempfile::tempdir().unwrap();
    // No loss here: with one the effort of a joint without loss is above what arrives at the load, which is said.
    let lossless = |text: String| text.replace("efficiency = 0.8, backdrive_efficiency = 0.75, ", "");
    let fitted = write(folder.path(), "f.toml", FITTED);
    let robot_path = write(folder.path(), "robot.toml", &lossless(robot("knee", "")));
    let base = ["export", "f@10", &robot_path, "--catalog", &fitted].map(String::from);
    let hardware = write(
        folder.path(),
        "hardware.toml",
        "[[joint]]\nnames = [\"knee\"]\nmotor = \"f\"\nratio = 10\nvoltage = \"48 V\"\nefficiency = 1\n",
    );
    let mjcf = "<mujoco><worldbody><body name=\"l\"><joint name=\"knee\"/></body></worldbody></mujoco>";
    let urdf = "<robot name=\"r\"><link name=\"a\"/><link name=\"b\"/><joint name=\"knee\" type=\"revolute\"><parent link=\"a\"/><child link=\"b\"/></joint></robot>";
    let sdf = "<sdf version=\"1.9\"><model name=\"m\"><joint name=\"knee\" type=\"revolute\"><axis><xyz>0 1 0</xyz></axis></joint></model></sdf>";
    for (name, model, more) in
        [("m.xml", mjcf, &[][..]), ("d.xml", mjcf, &["--to", "dcmotor"]), ("m.urdf", urdf, &[]), ("m.sdf", sdf, &[])]
    {
        let bare = write(folder.path(), name, model);
        let patched = text(&base, &[&["--into", &bare], more].concat());
        let patched = write(folder.path(), &format!("out_{name}"), &patched);
        let output = gearwise(&["check-model", &patched, "--against", &hardware, "--catalog", &fitted, "--json"]);
        let found: Value =
            serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", stderr(&output)));
        assert_eq!(output.status.code(), Some(0), "{name}: {found}");
        assert_eq!(
            found["findings"].as_array().map(Vec::len),
            Some(0),
            "{name}: {found}\n{}",
            std::fs::read_to_string(&patched).unwrap()
        );
    }
    // With a loss: a note, no more.
    let robot_path = write(folder.path(), "lossy.toml", &robot("knee", ""));
    let base = ["export", "f@10", &robot_path, "--catalog", &fitted].map(String::from);
    write(
        folder.path(),
        "hardware.toml",
        "[[joint]]\nnames = [\"knee\"]\nmotor = \"f\"\nratio = 10\nvoltage = \"48 V\"\nefficiency = 0.8\n",
    );
    let bare = write(folder.path(), "m.xml", mjcf);
    let patched = write(folder.path(), "out.xml", &text(&base, &["--into", &bare]));
    let output = gearwise(&["check-model", &patched, "--against", &hardware, "--catalog", &fitted]);
    assert_eq!(output.status.code(), Some(0), "{}", stdout(&output));
    assert!(stdout(&output).contains("the peak torque before the gear's loss"), "{}", stdout(&output));
    // More than that is an error still.
    let more = std::fs::read_to_string(&patched)
        .unwrap()
        .replace("actuatorfrcrange=\"-20 20\"", "actuatorfrcrange=\"-24 24\"")
        .replace("ctrlrange=\"-2 2\"", "ctrlrange=\"-2.4 2.4\"")
        .replace("forcerange=\"-2 2\"", "forcerange=\"-2.4 2.4\"");
    let patched = write(folder.path(), "more.xml", &more);
    let output = gearwise(&["check-model", &patched, "--against", &hardware, "--catalog", &fitted]);
    assert_eq!(output.status.code(), Some(1), "{}", stdout(&output));
}

/// A belt behind the gear: torque times, speed by r, in every number of the line.
#[test]
fn a_transmission_of_one_ratio_is_in_every_number() {
    let folder = tempfile::tempdir().unwrap();
    let plain = json(&example(folder.path(), "knee", ""), &[]);
    let other = tempfile::tempdir().unwrap();
    let belt = json(&example(other.path(), "knee", "transmission = { ratio = 1.5 }\n"), &[]);
    let of =
        |facts: &Value, path: &[&str]| path.iter().fold(facts.clone(), |at, key| at[*key].clone()).as_f64().unwrap();
    for (path, factor) in [
        (&["line", "effort_nm"][..], 1.5),
        (&["line", "stall_nm"], 1.5),
        (&["line", "corner_rad_per_s"], 1.0 / 1.5),
        (&["line", "no_load_rad_per_s"], 1.0 / 1.5),
        (&["line", "excess_nm"], 1.5),
        (&["armature_kgm2"], 2.25),
        (&["damping_nms_per_rad"], 2.25),
        (&["friction_at_rest_nm"], 1.5),
        (&["gear_stiffness_nm_per_rad"], 2.25),
        (&["backlash_rad"], 1.0 / 1.5),
        (&["mechanical_velocity_rad_per_s"], 1.0 / 1.5),
        (&["braking_effort_nm"], 1.5),
    ] {
        assert_relative_eq!(of(&belt, path), factor * of(&plain, path), max_relative = 1e-9);
    }
}

#[test]
fn the_page_of_an_export_lists_what_is_said_and_what_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let page = folder.path().join("page.html");
    text(&base, &["--to", "isaaclab2", "--ranges", "--html", page.to_str().unwrap()]);
    let page = std::fs::read_to_string(page).unwrap();
    for said in
        ["Of what is known of the actuators the file says", "as viscous_friction", "Ranges of 95 %", "gear compliance"]
    {
        assert!(page.contains(said), "{said}");
    }
    assert!(!page.contains("says everything that is known"));
}

/// A ratio that goes with the angle: torque over the angle where a format has it, and elsewhere a warning that the numbers are those
/// before the transmission.
#[test]
fn a_ratio_over_the_angle_is_a_table_or_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    // r = 1 + q over 0 to 1 rad.
    let rows: String = (0..=20).map(|k| f64::from(k) / 20.0).map(|q| format!("{q},{}\n", 1.0 + q)).collect();
    write(folder.path(), "knee.csv", &format!("position [rad],ratio\n{rows}"));
    let swing: String = (0..=40)
        .map(|k| f64::from(k) / 40.0)
        .map(|t| {
            let (sine, cosine) = (std::f64::consts::TAU * t).sin_cos();
            format!("{t},0.5,{},{}\n", 0.4 * std::f64::consts::TAU * cosine, 0.5 + 0.4 * sine)
        })
        .collect();
    write(folder.path(), "swing.csv", &format!("time [s],torque [N*m],velocity [rad/s],position [rad]\n{swing}"));
    let fitted = write(folder.path(), "f.toml", FITTED);
    let robot = "name = \"x\"\nbus = { voltage = \"48 V\" }\n[[joint]]\nname = \"knee\"\nmotor_drag = \"off\"\n\
                 ratio = { min = 3, max = 30 }\nmotion = \"swing.csv\"\nperiodic = true\ntransmission = { table = \"knee.csv\" }\n";
    let robot = write(folder.path(), "robot.toml", robot);
    let base = ["export", "f@10", &robot, "--catalog", &fitted].map(String::from);
    let facts = json(&base, &[]);
    let table = facts["over_angle_rad_ratio_nm"].as_array().unwrap();
    assert_eq!(table.len(), 33);
    for row in table {
        let [q, ratio, torque] = [0, 1, 2].map(|k| row[k].as_f64().unwrap());
        assert!((0.1 - 1e-3..=0.9 + 1e-3).contains(&q), "{q}");
        assert_relative_eq!(ratio, 10.0 * (1.0 + q), max_relative = 1e-6);
        // 2 N*m at the motor.
        assert_relative_eq!(torque, 20.0 * (1.0 + q), max_relative = 1e-6);
    }
    let (warning, left) = ("its transmission has no one ratio", "speed, inertia and friction are left out");
    for (to, key) in [
        ("isaaclab2", "RemotizedPDActuatorCfg("),
        ("isaaclab3", "RemotizedPDActuatorCfg("),
        ("newton", "newton:lookupEfforts"),
    ] {
        let output = run(&base, &["--to", to]);
        assert!(stdout(&output).contains(key) && !stderr(&output).contains(warning), "{to}: {}", stderr(&output));
        assert!(stderr(&output).contains(left) && !stdout(&output).contains("the line is straight"), "{to}");
        assert!(!stdout(&output).contains("saturation"), "{to}");
    }
    for to in ["mjcf", "dcmotor", "mjlab", "unitree", "physx", "urdf", "sdf", "ros2_control"] {
        let output = run(&base, &["--to", to]);
        assert!(stderr(&output).contains(warning), "{to}: {}", stderr(&output));
        assert!(stdout(&output).contains("the numbers written are those of the actuator before it"), "{to}");
    }
}

/// What a module's row rates has its gear's loss in it: it is not taken off again.
#[test]
fn a_module_s_rating_has_its_loss_in_it() {
    let folder = tempfile::tempdir().unwrap();
    // Unitree's own numbers of this motor: X1 13.5, X2 30, Y1 20.2, Y2 23.4.
    let id = "unitree-go2hv";
    let robot = "name = \"x\"\nbus = { voltage = \"48 V\" }\n[[joint]]\nname = \"j\"\nmodules = [\"*\"]\n\
                 points = [ { torque = \"0.1 N*m\", speed = \"1 rad/s\", duration = \"1 s\" } ]\n";
    let robot = write(folder.path(), "robot.toml", robot);
    let base = ["export", id, &robot].map(String::from);
    let of = |to: &str, more: &[&str]| stdout(&run(&base, &[&["--to", to], more].concat()));
    let facts: Value = serde_json::from_str(&of("json", &[])).unwrap();
    let joint = &facts["joints"][0];
    assert_eq!(joint["effort_is_behind_loss"], true, "{id}");
    let (effort, braking) = (joint["effort_nm"].as_f64().unwrap(), joint["braking_effort_nm"].as_f64().unwrap());
    let unitree = of("unitree", &[]);
    for (key, expected) in [(" X1=", 13.5), (" X2=", 30.0), (" Y1=", 20.2), (" Y2=", 23.4)] {
        // The row has the speed without load in rpm with five digits.
        assert_relative_eq!(number(&unitree, key), expected, max_relative = 1e-5);
    }
    assert_relative_eq!(effort, 20.2, max_relative = 1e-9);
    assert_relative_eq!(braking, 23.4, max_relative = 1e-9);
    // Behind the loss already: the option changes nothing.
    let effort_of = |text: &str| number(text, " effort_limit=");
    assert_eq!(effort_of(&of("mjlab", &[])), effort_of(&of("mjlab", &["--with-efficiency"])));
    let plain = of("mjlab", &[]);
    assert!(
        plain.contains("a module's rating: its gear's loss is in it") && !plain.contains("before the gear's loss"),
        "{id}"
    );
}

/// A model that would be wrong afterwards is refused, and what it has of its own does not count twice.
#[test]
fn a_model_of_its_own_mind_is_written_right_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let model = |inside: &str, before: &str, behind: &str| {
        let text = format!(
            "<mujoco>{before}<worldbody><body name=\"l\">{inside}<geom size=\"0.1\"/></body></worldbody>{behind}</mujoco>"
        );
        write(folder.path(), "model.xml", &text)
    };
    let refused = |model: &str, more: &[&str], why: &str| {
        let output = run(&base, &[&["--into", model], more].concat());
        assert_eq!(output.status.code(), Some(2), "{why}: {}", stdout(&output));
        assert!(stderr(&output).contains(why), "{}", stderr(&output));
    };
    let knee = "<joint name=\"knee\"/>";
    refused(&model(knee, "", "<keyframe><key qpos=\"0.5\"/></keyframe>"), &["--gear-joint"], "the model has keyframes");
    refused(&model("<joint name=\"knee\" type=\"slide\"/>", "", ""), &["--gear-joint"], "is no hinge");
    refused(
        &model(knee, "", "<actuator><position joint=\"knee\"/></actuator>"),
        &["--to", "dcmotor"],
        "is driven by a <position>",
    );
    // The gear's joint takes nothing of its class.
    let sprung = model(knee, "<default><joint springref=\"60\" springdamper=\"0.1 1\"/></default>", "");
    let text_of = text(&base, &["--into", &sprung, "--gear-joint"]);
    let gear = text_of.split("name=\"knee_gear\"").nth(1).unwrap().split("/>").next().unwrap();
    assert!(gear.contains("springref=\"0\"") && gear.contains("springdamper=\"0 0\""), "{gear}");
    // An actuator by `jointinparent` is the joint's; a dcmotor that is there says nothing else of itself.
    let driven = model(
        "<joint name=\"knee\" actuatorfrcrange=\"-5 5\"/>",
        "",
        "<actuator><dcmotor jointinparent=\"knee\" nominal=\"24 3 100\" thermal=\"1 2 0 0 0 0\"/></actuator>",
    );
    let text_of = text(&base, &["--into", &driven, "--to", "dcmotor"]);
    assert_eq!(text_of.matches("<dcmotor").count(), 1, "{text_of}");
    for said in ["nominal=\"0 0 0\"", "thermal=\"0 0 0 0 0 0\"", "actuatorfrcrange=\"-20 20\""] {
        assert!(text_of.contains(said), "{said}: {text_of}");
    }
    // A prefix of another namespace; a transmission without Drake's elements gets them.
    let other = write(
        folder.path(),
        "other.urdf",
        "<robot name=\"r\" xmlns:drake=\"drake.mit.edu\"><joint name=\"knee\" type=\"revolute\"/></robot>",
    );
    refused(&other, &[], "its prefix `drake` is the namespace");
    let old = "<robot name=\"r\">\n  <joint name=\"knee\" type=\"revolute\"/>\n  <transmission name=\"t\">\n    <joint name=\"knee\"/>\n    <actuator name=\"m\">\n      <mechanicalReduction>1</mechanicalReduction>\n    </actuator>\n  </transmission>\n</robot>\n";
    let old = write(folder.path(), "old.urdf", old);
    let patched = text(&base, &["--into", &old]);
    assert!(
        patched.contains("<drake:rotor_inertia value=\"0.00003\"/>")
            && patched.contains("<drake:gear_ratio value=\"10\"/>"),
        "{patched}"
    );
    assert!(patched.contains("<mechanicalReduction>10<"), "{patched}");
    let again = write(folder.path(), "again.urdf", &patched);
    assert_eq!(text(&base, &["--into", &again]), patched);
    // What is not known leaves the model's own number, which is said.
    write(folder.path(), "f.toml", &FITTED.replace("viscous_friction = \"1e-4 N*m*s/rad\"\n", ""));
    let own = model("<joint name=\"knee\" damping=\"0.5\"/>", "", "");
    let output = run(&base, &["--into", &own]);
    assert!(
        stderr(&output).contains("damping of f is not known; the model's own 0.5 N*m*s/rad stays"),
        "{}",
        stderr(&output)
    );
}

/// The loss of a transmission is in what is written behind the losses, in ranges too; its direction in ROS.
#[test]
fn the_loss_and_the_direction_of_a_transmission_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "transmission = { ratio = -1.5, efficiency = 0.6 }\n");
    write(
        folder.path(),
        "f.toml",
        &FITTED.replace("peak_current =", "torque_constant_tolerance = \"0.01 N*m/A\"\npeak_current ="),
    );
    let effort = |text: &str| number(text, " effort_limit=");
    let behind = text(&base, &["--to", "mjlab", "--with-efficiency", "--ranges"]);
    // 20 N*m at the gear, 1.5, 0.8 and 0.6.
    assert_relative_eq!(effort(&behind), 14.4, max_relative = 1e-9);
    assert!(behind.contains("behind the loss of gear and transmission"), "{behind}");
    let range = behind.split("\"effort_limits\": (").nth(1).unwrap().split(')').next().unwrap();
    let ends: Vec<f64> = range.split(", ").map(|v| v.parse().unwrap()).collect();
    assert_relative_eq!(ends[0], 0.9 * 14.4, max_relative = 1e-3);
    assert_relative_eq!(ends[1], 1.1 * 14.4, max_relative = 1e-3);
    assert_relative_eq!(number(&text(&base, &["--to", "unitree"]), " Y1="), 14.4, max_relative = 1e-9);
    assert_relative_eq!(number(&text(&base, &["--to", "ros2_control"]), "<mechanical_reduction"), -15.0);
    // Isaac Lab's function would set viscous friction with friction: no range of it is written.
    let lab = text(&base, &["--to", "isaaclab2", "--ranges"]);
    assert!(
        !lab.contains("friction_distribution_params\"") && lab.contains("friction has no range in the code"),
        "{lab}"
    );
}

/// A module whose curve ends upright before the speed without load keeps its torque under `--line below`.
#[test]
fn a_line_below_keeps_the_torque_of_a_module() {
    let folder = tempfile::tempdir().unwrap();
    let robot = "name = \"x\"\nbus = { voltage = \"48 V\" }\n[[joint]]\nname = \"j\"\nmodules = [\"*\"]\n\
                 points = [ { torque = \"0.1 N*m\", speed = \"1 rad/s\", duration = \"1 s\" } ]\n";
    let robot = write(folder.path(), "robot.toml", robot);
    let base = ["export", "robstride-rs04", &robot].map(String::from);
    let output = run(&base, &["--to", "json"]);
    let line = serde_json::from_slice::<Value>(&output.stdout).unwrap()["joints"][0]["line_below"].clone();
    assert!(line["effort_nm"].as_f64().unwrap() > 110.0, "{line}");
    assert!(line["excess_nm"].as_f64().unwrap() < 1e-6, "{line}");
}

/// At standstill the voltage drives no more than it does through the hot winding and what is in series with it.
#[test]
fn a_torque_that_the_voltage_ends_is_that_of_the_hot_winding() {
    let folder = tempfile::tempdir().unwrap();
    let base = example(folder.path(), "knee", "");
    let set = ["--set", "bus.voltage=6 V", "--set", "bus.drive_phase_resistance=0.5 ohm"];
    let output = run(&base, &[&["--to", "json"], &set[..]].concat());
    let joint = serde_json::from_slice::<Value>(&output.stdout).unwrap()["joints"][0].clone();
    let hot = 0.5 * (1.0 + 0.00393 / (1.0 + 0.00393 * 5.0) * 95.0);
    let expected = 10.0 * 0.1 * (6.0 / 2.0_f64.sqrt()) / (hot + 0.5);
    assert_relative_eq!(joint["effort_nm"].as_f64().unwrap(), expected, max_relative = 1e-9);
    assert_eq!(joint["effort_by"], "voltage at standstill");
    // While the load drives, the current counts alone.
    assert_relative_eq!(joint["braking_effort_nm"].as_f64().unwrap(), 20.0, max_relative = 1e-9);
}
