//! Frames and words: currents under names that say which, objectives that keep their weight, findings where the input is
//! wrong, and nothing that sounds surer than it is.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

const MOTORS: &str = "id,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],\
pole_pairs,continuous_current [A],peak_current [A],thermal_resistance_winding_housing [K/W],thermal_resistance_housing_ambient [K/W],\
max_winding_temperature [degC],source,source_kind
brushless,q_axis,q_axis,0.4,0.1,0.1,100,200,7,12,40,0.5,1.5,120,a sheet,datasheet
other,q_axis,q_axis,0.7,0.1,0.1,80,150,7,12,40,0.5,1.5,120,a sheet,datasheet
";
const BRUSHED: &str =
    "id,commutation,terminals,current,resistance [ohm],inductance [mH],torque_constant [N*m/A],rotor_inertia [g*cm^2],\
mass [g],continuous_current [A],peak_current [A],source,source_kind
dc,brushed,line_to_line,dc,0.4,0.1,0.1,100,200,12,40,a sheet,datasheet
";

fn robot(bus: &str, joint: &str) -> String {
    format!(
        "name = \"leg\"\n[bus]\nvoltage = \"48 V\"\n{bus}\n[[joint]]\nname = \"knee\"\nratio = {{ min = 5, max = 20 }}\nmotor_drag = \"off\"\n\
         gear = {{ efficiency = 0.9, mass = \"100 g\" }}\n{joint}\n"
    )
}

const POINTS: &str = "points = [ { torque = \"5 N*m\", speed = \"2 rad/s\", duration = \"1 s\" }, \
{ torque = \"-1 N*m\", speed = \"5 rad/s\", duration = \"1 s\" } ]\n";
const DESIGN: &str = "requirement = \"robot.toml\"\ncatalog = [\"motors.csv\"]\n\n[[joint]]\nname = \"knee\"\nmotor = \"brushless\"\nratio = 9\n";

fn folder(robot: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("motors.csv"), MOTORS).unwrap();
    fs::write(folder.path().join("robot.toml"), robot).unwrap();
    fs::write(folder.path().join("design.toml"), DESIGN).unwrap();
    folder
}

fn run(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise")).args(arguments).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let (_, out, err) = run(folder, &[arguments, &["--json"]].concat());
    serde_json::from_str(&out).unwrap_or_else(|e| panic!("{arguments:?}: {e}\n{out}{err}"))
}

const OPTIMIZE: [&str; 4] = ["optimize", "robot.toml", "--catalog", "motors.csv"];
const EXPLAIN: [&str; 5] = ["explain", "brushless", "robot.toml", "--catalog", "motors.csv"];

fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// Peak and rms, each on the phase and on the q axis, in a JSON object of a design.
fn currents(design: &Value) -> [f64; 4] {
    ["peak_current_phase_a", "peak_current_q_a", "rms_current_phase_a", "rms_current_q_a"]
        .map(|name| design[name].as_f64().unwrap_or_else(|| panic!("no {name} in {design}")))
}

#[test]
fn currents_have_names_that_say_which_everywhere() {
    let folder = folder(&robot("", POINTS));
    let path = folder.path();
    let sweep = ["sweep", "robot.toml", "--catalog", "motors.csv", "--ratios", "3"];
    let whole = [&OPTIMIZE[..], &["--robot"]].concat();
    let designs = [
        ("optimize", json(path, &OPTIMIZE)["joints"][0]["candidates"][0].clone()),
        ("sweep", json(path, &sweep)["joints"][0]["candidates"][0].clone()),
        ("explain", json(path, &EXPLAIN)["joints"][0]["design"].clone()),
        ("check", json(path, &["check", "design.toml"])["joints"][0]["design"].clone()),
        ("robot", json(path, &whole)["robot"]["choice"]["best"]["joints"][0].clone()),
    ];
    for (command, design) in &designs {
        let [peak_phase, peak_q, rms_phase, rms_q] = currents(design);
        // Power invariant: three halves of the amplitude's square.
        assert!(near(peak_q, 1.5_f64.sqrt() * peak_phase) && near(rms_q, 1.5_f64.sqrt() * rms_phase), "{command}");
        assert!(peak_q > rms_q && rms_q > 0.0, "{command}");
        let text = design.to_string();
        for old in ["\"peak_current_a\"", "\"rms_current_a\"", "\"peak_drive_current_a\""] {
            assert!(!text.contains(old), "{command}: {old} does not say which");
        }
    }
    // At N = 9 by hand: 5 N m through a gear of 0.9 on 0.1 N m/A.
    let at_nine = json(path, &["explain", "brushless@9", "robot.toml", "--catalog", "motors.csv"]);
    let at_nine = &at_nine["joints"][0]["design"];
    assert!(near(currents(at_nine)[1], 5.0 / 0.9 / 9.0 / 0.1), "{at_nine}");
    for arguments in [&OPTIMIZE[..], &sweep[..]] {
        let (_, out, _) = run(path, &[arguments, &["--csv"]].concat());
        let header: Vec<&str> = out.lines().next().unwrap().split(',').collect();
        assert!(header.contains(&"peak_current_phase_a") && header.contains(&"peak_current_q_a"), "{header:?}");
        assert!(!header.contains(&"peak_current_a"), "{header:?}");
    }
    run(path, &["study", "robot.toml", "--out", "result", "--catalog", "motors.csv"]);
    let header = fs::read_to_string(path.join("result/results.csv")).unwrap();
    let header: Vec<&str> = header.lines().next().unwrap().split(',').collect();
    for name in ["peak_current_phase_a", "peak_current_q_a", "rms_current_phase_a", "rms_current_q_a"] {
        assert!(header.contains(&name), "{header:?}");
    }
    // Tables say which, and which one limits compare.
    let (_, out, _) = run(path, &OPTIMIZE);
    let head = out.lines().next().unwrap();
    assert!(head.contains("phase amplitudes") && !out.contains("q axis"), "{out}");
    fs::write(path.join("current.toml"), robot("", &format!("objective = \"peak_current\"\n{POINTS}"))).unwrap();
    let (_, out, _) = run(path, &["optimize", "current.toml", "--catalog", "motors.csv"]);
    assert!(out.contains("The objective's current is on the q axis"), "{out}");
    let (_, out, _) = run(path, &EXPLAIN);
    assert!(out.contains("A (phase amplitude)") && out.contains("A (q axis)"), "{out}");
    assert!(flat(&out).contains("compare q-axis amperes"), "{out}");
}

#[test]
fn the_current_of_a_brushed_motor_is_one() {
    let folder = folder(&robot("", POINTS));
    fs::write(folder.path().join("motors.csv"), BRUSHED).unwrap();
    let design = json(folder.path(), &OPTIMIZE)["joints"][0]["candidates"][0].clone();
    let [peak_phase, peak_q, rms_phase, rms_q] = currents(&design);
    assert!(near(peak_phase, peak_q) && near(rms_phase, rms_q), "{design}");
}

#[test]
fn a_finding_about_a_current_says_which_ampere() {
    let folder = folder(&robot("drive_current = \"3 A\"", POINTS));
    let (status, out, _) = run(folder.path(), &["check", "design.toml"]);
    // 6.17 A on the q axis where 3 A of amplitude are 3.674.
    assert!(status == 1 && flat(&out).contains("A (q axis) where the drive allows 3.674 A (q axis)"), "{out}");
}

#[test]
fn one_weighted_quantity_keeps_its_weight() {
    let plain = |quantity: &str| robot("", &format!("objective = \"{quantity}\"\n{POINTS}"));
    for (quantity, reference, factor) in [
        ("loss", "2 W", 0.87 / 2.0),
        ("peak_current", "1 A", 0.87),
        ("energy", "5 J", 0.87 / 5.0),
        ("peak_power", "1 W", 0.87),
        ("reflected_inertia", "0.01 kg*m^2", 87.0),
        ("mass", "500 g", 0.87 / 0.5),
    ] {
        let weighted = robot(
            "",
            &format!("objective = {{ {quantity} = 0.87 }}\nreference = {{ {quantity} = \"{reference}\" }}\n{POINTS}"),
        );
        let (one, other) = (folder(&plain(quantity)), folder(&weighted));
        for more in [&[][..], &["--only-top", "1"]] {
            let arguments = [&OPTIMIZE[..], more].concat();
            let (one, other) = (json(one.path(), &arguments), json(other.path(), &arguments));
            let (a, b) = (&one["joints"][0]["candidates"][0], &other["joints"][0]["candidates"][0]);
            let value = |design: &Value| design["objective"].as_f64().unwrap();
            assert!(near(value(b), factor * value(a)), "{quantity}: {} {}", value(a), value(b));
            assert_eq!(
                (&a["motor"], &a["ratio"], &a["loss_w"]),
                (&b["motor"], &b["ratio"], &b["loss_w"]),
                "{quantity}"
            );
            let bound = |design: &Value| design["certificate"]["lower_bound"].as_f64().unwrap();
            assert!(near(bound(b), factor * bound(a)), "{quantity}");
            assert_eq!(a["certificate"]["gap"], b["certificate"]["gap"], "{quantity}");
            assert_eq!(b["objective_unit"], "1", "{quantity}: a weighted value is a pure number");
            assert_eq!(other["joints"][0]["objective"], format!("weighted {quantity}"));
        }
        // Over a whole robot the totals are in the same proportion.
        let total = |folder: &Path| {
            let found = json(folder, &[&OPTIMIZE[..], &["--robot"]].concat());
            found["robot"]["choice"]["best"]["objective"].as_f64().unwrap()
        };
        assert!(near(total(other.path()), factor * total(one.path())), "{quantity}");
        // The table shows the objective itself beside the quantity.
        let (_, out, _) = run(other.path(), &OPTIMIZE);
        assert!(out.contains(&format!("least weighted {}", quantity.replace('_', " "))), "{out}");
        let (_, out, _) = run(other.path(), &EXPLAIN);
        assert!(!out.contains(" 1 (exact)") && !out.contains(" 1 (gap"), "{out}");
    }
}

/// A swing of half a radian, and the torque that a spring leaves of 1 N m.
fn swing(spring: Option<(f64, f64)>) -> String {
    let mut text = String::from("time [s],torque [N*m],velocity [rad/s],position [rad],acceleration [rad/s^2]\n");
    let turn = std::f64::consts::TAU;
    for k in 0..=100 {
        let t = f64::from(k) / 100.0;
        let angle = turn * f64::from(k % 100) / 100.0;
        let position = 0.5 * angle.sin();
        let torque = 1.0 - spring.map_or(0.0, |(stiffness, rest)| stiffness * (rest - position));
        let (velocity, acceleration) = (0.5 * turn * angle.cos(), -turn * turn * position);
        text.push_str(&format!("{t},{torque},{velocity},{position},{acceleration}\n"));
    }
    text
}

const SWING: &str = "motion = \"swing.csv\"\n";

fn sprung(stiffness: &str) -> String {
    robot(
        "",
        &format!(
            "{SWING}[joint.limits]\nspring = {{ stiffness = {stiffness}, rest_angle = [\"-10 deg\", \"10 deg\"] }}"
        ),
    )
}

/// A spring that has to be there breaks what the bare joint keeps: what is told is told with such a spring.
#[test]
fn a_spring_that_must_be_there_is_there_in_what_is_explained() {
    let folder = folder(&sprung("[\"400 N*m/rad\", \"800 N*m/rad\"]"));
    fs::write(folder.path().join("swing.csv"), swing(None)).unwrap();
    let (status, out, err) = run(folder.path(), &EXPLAIN);
    assert_eq!(status, 1, "{out}{err}");
    let said = flat(&out);
    assert!(said.contains("No spring will do") && !said.contains("without a spring"), "{out}");
    let story = json(folder.path(), &EXPLAIN)["joints"][0].clone();
    assert_eq!(story["design"]["feasible"], false);
    let with = &story["spring"]["all_else_with"];
    let (stiffness, rest) = (with["stiffness_nm_per_rad"].as_f64().unwrap(), with["rest_angle_rad"].as_f64().unwrap());
    assert!((400.0..=800.0).contains(&stiffness) && rest.abs() <= 10.0_f64.to_radians() * (1.0 + 1e-12));
    // The same joint whose motion has the spring's torque in it, written by hand.
    let ratio = story["design"]["ratio"].as_f64().unwrap();
    fs::write(folder.path().join("swing.csv"), swing(Some((stiffness, rest)))).unwrap();
    fs::write(folder.path().join("robot.toml"), robot("", SWING)).unwrap();
    let design = format!("brushless@{ratio}");
    let bare = json(folder.path(), &["explain", &design, "robot.toml", "--catalog", "motors.csv"]);
    let bare = &bare["joints"][0]["design"];
    for (name, current) in [("peak_current_q_a", currents(bare)[1]), ("rms_current_q_a", currents(bare)[3])] {
        assert!(
            (story["design"][name].as_f64().unwrap() / current - 1.0).abs() < 1e-6,
            "{name}: {} {current}",
            story["design"][name]
        );
    }
    // Where zero is allowed too, the joint without a spring is one of those that were asked for.
    fs::write(folder.path().join("swing.csv"), swing(None)).unwrap();
    fs::write(folder.path().join("robot.toml"), sprung("[\"0 N*m/rad\", \"800 N*m/rad\"]")).unwrap();
    let (status, out, _) = run(folder.path(), &EXPLAIN);
    assert_eq!(status, 0, "{out}");
}

#[test]
fn one_weighted_quantity_keeps_its_weight_with_a_spring() {
    let limits = "[joint.limits]\nspring = { stiffness = [\"0 N*m/rad\", \"8 N*m/rad\"], rest_angle = [\"-10 deg\", \"10 deg\"] }";
    let first = |objective: &str| {
        let folder = folder(&robot("", &format!("{objective}\n{SWING}{limits}")));
        fs::write(folder.path().join("swing.csv"), swing(None)).unwrap();
        json(folder.path(), &OPTIMIZE)["joints"][0]["candidates"][0].clone()
    };
    for (quantity, unit) in [("loss", "W"), ("peak_current", "A")] {
        let plain = first(&format!("objective = \"{quantity}\""));
        let weighted =
            first(&format!("objective = {{ {quantity} = 0.87 }}\nreference = {{ {quantity} = \"1 {unit}\" }}"));
        let value = |design: &Value| design["objective"].as_f64().unwrap();
        assert!(near(value(&weighted), 0.87 * value(&plain)), "{quantity}: {plain} {weighted}");
        assert_eq!(plain["ratio"], weighted["ratio"]);
    }
}

#[test]
fn a_limit_of_nothing_has_no_multiples() {
    // Lowering a load: more comes back than copper and gear take.
    let lowering = "points = [ { torque = \"-5 N*m\", speed = \"20 rad/s\", duration = \"1 s\" } ]\n";
    let folder = folder(&robot("regeneration = \"none\"", lowering));
    let (status, out, _) = run(folder.path(), &[&OPTIMIZE[..], &["--rejected"]].concat());
    let said = flat(&out);
    assert!(status == 1 && said.contains("regeneration"), "{out}");
    assert!(!said.contains("unbounded") && !said.contains('∞'), "{out}");
    assert!(said.contains("a limit of zero"), "{out}");
    let (_, out, _) = run(folder.path(), &EXPLAIN);
    let said = flat(&out);
    assert!(!said.contains("unbounded") && !said.contains('∞') && said.contains("a limit of zero"), "{out}");
}

#[test]
fn a_study_looks_at_budgets() {
    let folder = folder(&robot("", POINTS));
    let arguments = ["study", "study.toml", "--out", "result", "--force", "--catalog", "motors.csv"];
    for grid in [
        "[grid]\n\"budget.power\" = [\"100 W\", \"2000 W\"]\n",
        "[grid]\nbudget.actuator_mass = [\"1 kg\", \"2 kg\"]\n",
        "[grid.budget]\nmax_distinct_motors = [1, 2]\n",
    ] {
        fs::write(folder.path().join("study.toml"), format!("requirement = \"robot.toml\"\n{grid}")).unwrap();
        let (status, out, err) = run(folder.path(), &arguments);
        assert_eq!(status, 0, "{grid}\n{out}{err}");
    }
    let good = "requirement = \"robot.toml\"\n[grid]\n\"bus.voltage\" = [\"24 V\", \"48 V\"]\n";
    fs::write(folder.path().join("study.toml"), good).unwrap();
    let (status, out, err) =
        run(folder.path(), &["study", "study.toml", "--out", "result", "--force", "--catalog", "motors.csv"]);
    assert_eq!(status, 0, "{out}{err}");
}

/// A pipeline that waits for findings gets the mistakes of the input, each with its place, and status 2 as before.
#[test]
fn a_check_of_wrong_input_writes_its_findings() {
    let folder = folder(&robot("", POINTS));
    let path = folder.path();
    // What an earlier run left must not stay.
    fs::write(path.join("out.sarif"), "{}").unwrap();
    let cases = [
        ("design.toml", DESIGN.replace("ratio = 9", "ratoi = 9"), "design.toml", 7, 1),
        ("design.toml", DESIGN.replace("\"brushless\"", "\"brushles\""), "design.toml", 6, 9),
        ("robot.toml", robot("", POINTS).replace("\"48 V\"", "\"48 A\""), "robot.toml", 3, 11),
        ("motors.csv", MOTORS.replace("0.4,0.1", "-0.4,0.1"), "motors.csv", 2, 25),
    ];
    for (file, text, named, line, column) in cases {
        let good = fs::read_to_string(path.join(file)).unwrap();
        fs::write(path.join(file), text).unwrap();
        let (status, out, err) =
            run(path, &["check", "design.toml", "--github", "--sarif", "out.sarif", "--junit", "out.xml"]);
        assert_eq!(status, 2, "{named}: {out}{err}");
        assert!(err.contains("mistake"), "{err}");
        let place = format!("::error file={named},line={line},col={column},");
        assert!(out.lines().any(|l| l.starts_with(&place)), "{place}\n{out}");
        assert!(out.lines().all(|l| l.starts_with("::error ")), "{out}");
        let sarif: Value = serde_json::from_str(&fs::read_to_string(path.join("out.sarif")).unwrap()).unwrap();
        let run_of = &sarif["runs"][0];
        assert_eq!(run_of["invocations"][0]["executionSuccessful"], false);
        let placed = run_of["results"].as_array().unwrap().iter().any(|r| {
            let at = &r["locations"][0]["physicalLocation"];
            let region = &at["region"];
            r["level"] == "error"
                && at["artifactLocation"]["uri"] == named
                && (region["startLine"].as_i64(), region["startColumn"].as_i64()) == (Some(line), Some(column))
        });
        assert!(placed, "{sarif}");
        let junit = fs::read_to_string(path.join("out.xml")).unwrap();
        let document = roxmltree::Document::parse(&junit).unwrap();
        assert_eq!(document.root_element().attribute("errors"), Some("1"));
        assert!(junit.contains(&format!("{named}:{line}:{column}")), "{junit}");
        let (status, out, _) = run(path, &["check", "design.toml", "--json"]);
        let found: Value = serde_json::from_str(&out).unwrap();
        assert_eq!((status, &found["passes"]), (2, &Value::Bool(false)));
        let placed = found["input_errors"].as_array().unwrap().iter();
        assert!(placed.clone().any(|e| e["line"] == line && e["column"] == column), "{found}");
        fs::write(path.join(file), good).unwrap();
    }
    // A file that is not there has a name and no line.
    fs::remove_file(path.join("robot.toml")).unwrap();
    let (status, out, _) = run(path, &["check", "design.toml", "--github", "--sarif", "out.sarif"]);
    assert!(status == 2 && out.starts_with("::error file="), "{out}");
}
