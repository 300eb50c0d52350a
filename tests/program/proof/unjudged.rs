//! A limit that the requirement states is judged, or the motor is no choice: in every command, for every key, and for
//! rows with any cells missing.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize_with;
use gearwise::design::options::Options;
use gearwise::input::Source;
use gearwise::requirement;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};
use serde_json::Value;

const COLUMNS: &[(&str, &str)] = &[
    ("terminals", "q_axis"),
    ("current", "q_axis"),
    ("resistance [ohm]", "0.4"),
    ("inductance [mH]", "0.1"),
    ("torque_constant [N*m/A]", "0.1"),
    ("rotor_inertia [g*cm^2]", "100"),
    ("mass [g]", "200"),
    ("pole_pairs", "7"),
    ("continuous_current [A]", "12"),
    ("peak_current [A]", "40"),
    ("max_speed [rpm]", "20000"),
    ("max_winding_temperature [degC]", "120"),
    ("thermal_resistance_winding_housing [K/W]", "0.5"),
    ("thermal_resistance_housing_ambient [K/W]", "1.5"),
    ("source", "a sheet"),
    ("source_kind", "datasheet"),
];

/// A catalogue of rows, each with the cells that differ from [`COLUMNS`].
fn catalog(rows: &[(&str, &[(&str, &str)])]) -> String {
    let header: Vec<&str> = std::iter::once("id").chain(COLUMNS.iter().map(|(name, _)| *name)).collect();
    let row = |(id, changes): &(&str, &[(&str, &str)])| {
        for (column, _) in *changes {
            assert!(COLUMNS.iter().any(|(name, _)| name.starts_with(column)), "no column {column}");
        }
        let cell = |(name, cell): &(&str, &str)| {
            changes.iter().find(|(c, _)| name.starts_with(c)).map_or(*cell, |(_, new)| *new).to_string()
        };
        std::iter::once(id.to_string()).chain(COLUMNS.iter().map(cell)).collect::<Vec<_>>().join(",")
    };
    let rows: Vec<String> = rows.iter().map(row).collect();
    format!("{}\n{}\n", header.join(","), rows.join("\n"))
}

/// A joint with limits; `more` stands at the end of the joint, `top` before it.
fn robot(top: &str, ratio: &str, limits: &str) -> String {
    format!(
        "name = \"leg\"\n[bus]\nvoltage = \"48 V\"\n{top}\n[[joint]]\nname = \"knee\"\nmotor_drag = \"off\"\n{ratio}\n\
         points = [ {{ torque = \"5 N*m\", speed = \"2 rad/s\", duration = \"1 s\" }}, {{ torque = \"-1 N*m\", speed = \"5 rad/s\", duration = \"1 s\" }} ]\n\
         [joint.limits]\n{limits}\n"
    )
}

const RATIO: &str = "ratio = { min = 5, max = 20 }";
const GEARS: &str = "id,kind,ratio,stages,efficiency,mass [g],inertia [g*cm^2],fits,source,source_kind\n\
planetary-9,planetary,9,2,0.95,150,,*,a sheet,datasheet\nplanetary-8,planetary,8,2,0.9,140,5,*,a sheet,datasheet\n";

struct Case {
    folder: tempfile::TempDir,
}

impl Case {
    fn new(motors: &str, robot: &str) -> Case {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("motors.csv"), motors).unwrap();
        fs::write(folder.path().join("gears.csv"), GEARS).unwrap();
        fs::write(folder.path().join("robot.toml"), robot).unwrap();
        Case { folder }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Exit status, stdout, stderr; what a row does not say stays unknown.
    fn run(&self, arguments: &[&str]) -> (i32, String, String) {
        self.run_estimating(&[arguments, &["--no-estimates"]].concat())
    }

    /// The same with what the program estimates.
    fn run_estimating(&self, arguments: &[&str]) -> (i32, String, String) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
        let output = command.args(arguments).current_dir(self.path()).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        (output.status.code().unwrap(), text(&output.stdout), text(&output.stderr))
    }

    fn json(&self, arguments: &[&str]) -> (i32, Value) {
        let all: Vec<&str> = arguments.iter().copied().chain(["--json"]).collect();
        let (status, out, err) = self.run(&all);
        (status, serde_json::from_str(&out).unwrap_or_else(|e| panic!("{arguments:?}: {e}\n{out}{err}")))
    }
}

/// `robot.toml` with the catalogue, as the arguments of a command.
const FILES: [&str; 4] = ["robot.toml", "--catalog", "motors.csv", "gears.csv"];

fn with(command: &str, options: &[&'static str]) -> Vec<String> {
    std::iter::once(command).chain(FILES).chain(options.iter().copied()).map(String::from).collect()
}

fn names(list: &Value) -> Vec<&str> {
    list.as_array().unwrap_or_else(|| panic!("{list}")).iter().map(|c| c["motor"].as_str().unwrap()).collect()
}

/// Words of a text, however it was wrapped.
fn flat(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A stated limit, what is taken from the row that would win, and the name under which that is said.
type Stated = (&'static str, &'static str, &'static str, &'static [(&'static str, &'static str)], &'static str);

const HEAT: &[(&str, &str)] = &[("thermal_resistance_winding_housing", ""), ("thermal_resistance_housing_ambient", "")];

/// Every key by which a requirement states a limit that a row may leave unknown.
const STATED: &[Stated] = &[
    ("", RATIO, "actuator_mass = \"1 kg\"", &[("mass", "")], "actuator_mass"),
    ("", RATIO, "winding_temperature = \"110 degC\"", HEAT, "winding_temperature"),
    (
        "",
        RATIO,
        "torque_bandwidth = { frequency = \"10 Hz\", amplitude = \"0.5 N*m\" }",
        &[("inductance", "")],
        "torque_bandwidth_voltage",
    ),
    (
        "",
        RATIO,
        "torque_bandwidth = { frequency = \"10 Hz\", amplitude = \"0.5 N*m\" }",
        &[("pole_pairs", "")],
        "torque_bandwidth_voltage",
    ),
    (
        "",
        RATIO,
        "torque_bandwidth = { frequency = \"10 Hz\", amplitude = \"0.5 N*m\" }",
        &[("peak_current", "")],
        "torque_bandwidth_current",
    ),
    ("[budget]\nactuator_mass = \"1 kg\"", RATIO, "", &[("mass", "")], "mass_budget"),
];

/// A row that would be first, but for what is taken from it; and one that can be judged.
fn two(missing: &[(&'static str, &'static str)]) -> String {
    let blank: Vec<(&str, &str)> = std::iter::once(("resistance", "0.2")).chain(missing.iter().copied()).collect();
    catalog(&[("blank", &blank), ("known", &[])])
}

fn only_blank(missing: &[(&'static str, &'static str)]) -> String {
    catalog(&[("blank", missing)])
}

#[test]
fn what_the_requirement_states_is_judged_or_the_motor_is_no_choice() {
    for (top, ratio, limits, missing, name) in STATED {
        let asked = robot(top, ratio, limits);
        let (status, found) =
            Case::new(&two(missing), &asked).json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
        let joint = &found["joints"][0];
        assert_eq!((status, names(&joint["candidates"])), (0, vec!["known"]), "{limits}");
        assert_eq!(names(&joint["unjudged"]), ["blank"], "{limits}");
        assert!(names(&joint["rejected"]).is_empty(), "{limits}");
        let because = joint["unjudged"][0]["because"].as_str().unwrap();
        assert!(because.starts_with("cannot be judged: ") && because.contains(name), "{because}");
        // With every cell the better row is first: it is the missing cell that counts.
        let all = two(&[]);
        let (_, found) = Case::new(&all, &asked).json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
        assert_eq!(names(&found["joints"][0]["candidates"]), ["blank", "known"], "{limits}");
    }
}

/// Heat is always a limit: a row that says nothing of it is no choice, whatever the requirement states.
#[test]
fn heat_has_to_be_judged_though_nobody_states_it() {
    let nothing: Vec<(&str, &str)> = HEAT.iter().copied().chain([("continuous_current", "")]).collect();
    let case = Case::new(&two(&nothing), &robot("", RATIO, ""));
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
    let joint = &found["joints"][0];
    assert_eq!((status, names(&joint["candidates"]), names(&joint["unjudged"])), (0, vec!["known"], vec!["blank"]));
    // One witness is enough, and its blanks beside it are no thing that is not checked.
    for witness in [HEAT, &[("continuous_current", "")]] {
        let case = Case::new(&two(witness), &robot("", RATIO, ""));
        let (_, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
        let first = &found["joints"][0]["candidates"][0];
        assert_eq!((first["motor"].as_str(), first["not_checked"].as_array().map(Vec::len)), (Some("blank"), Some(0)));
    }
}

/// What is estimated is marked wherever the design stands; without estimates it is unknown.
#[test]
fn an_estimate_judges_and_is_marked_everywhere() {
    let nothing: Vec<(&str, &str)> = HEAT.iter().copied().chain([("continuous_current", "")]).collect();
    let motors = two(&nothing).replacen("id,", "id,construction,", 1);
    let motors = motors.replace("blank,", "blank,housed,").replace("known,", "known,housed,");
    let case = Case::new(&motors, &robot("", RATIO, ""));
    let files = ["optimize", "robot.toml", "--catalog", "motors.csv"];
    let (status, out, _) = case.run_estimating(&files);
    assert!(status == 0 && flat(&out).contains("estimated: thermal resistance at most"), "{out}");
    assert!(flat(&out).contains("assumed"), "{out}");
    let (_, full, _) = case.run_estimating(&[&files[..], &["--full"]].concat());
    assert!(flat(&full).contains("#1: assumed: winding_temperature: estimated"), "{full}");
    let (_, out, _) = case.run_estimating(&[&files[..], &["--json"]].concat());
    let found: Value = serde_json::from_str(&out).unwrap();
    let first = &found["joints"][0]["candidates"][0];
    assert_eq!(first["motor"], "blank");
    assert_eq!(first["estimated"][0]["quantity"], "thermal_resistance");
    // The law of docs/estimates.md at 0.2 kg, and its pessimistic end.
    let (middle, value) =
        (first["estimated"][0]["middle"].as_f64().unwrap(), first["estimated"][0]["value"].as_f64().unwrap());
    let page = std::fs::read_to_string(crate::common::repository("docs/estimates.md")).unwrap();
    let law = page.lines().find(|line| line.starts_with("| thermal resistance | housed |")).unwrap();
    let number = |after: &str| -> f64 {
        let rest = &law[law.find(after).unwrap() + after.len()..];
        rest.split([' ', '|']).next().unwrap().parse().unwrap()
    };
    let of_page = number("R_th = ") * 0.2_f64.powf(number("(m/kg)^"));
    assert!((middle / of_page - 1.0).abs() < 1e-3 && value > middle, "{middle} {of_page} {value}");
    let of_known = found["joints"][0]["candidates"][1]["estimated"].as_array().unwrap();
    assert!(of_known.iter().all(|e| e["quantity"] != "thermal_resistance"), "{of_known:?}");
    let (_, out, _) = case.run_estimating(&[&files[..], &["--csv"]].concat());
    assert!(out.lines().nth(1).unwrap().contains("thermal_resistance"), "{out}");
    case.run_estimating(&[&files[..], &["--html", "page.html"]].concat());
    assert!(fs::read_to_string(case.path().join("page.html")).unwrap().contains("estimated"));
    for command in [&["sweep", "robot.toml"][..], &["explain", "blank", "robot.toml"]] {
        let (_, out, _) = case.run_estimating(&[command, &["--catalog", "motors.csv"]].concat());
        assert!(flat(&out).contains("estimated"), "{out}");
    }
    let (_, found) = case.json(&files);
    assert_eq!(names(&found["joints"][0]["candidates"]), ["known"]);
    assert_eq!(names(&found["joints"][0]["unjudged"]), ["blank"]);
}

/// The thermal resistance of the mount is part of every motor's, whatever its row says: a row that says less does not pass
/// where one that says more fails.
#[test]
fn a_mount_counts_for_every_row() {
    let rows =
        catalog(&[("split", &[]), ("rated", HEAT), ("nothing", &[HEAT, &[("continuous_current", "")]].concat())]);
    let asked = |mount: &str| {
        let mount = format!("[joint.mount]\nthermal_resistance_housing_ambient = \"{mount}\"\n");
        robot("", RATIO, "") + &mount
    };
    let case = Case::new(&rows, &asked("1000 K/W"));
    let files = ["optimize", "robot.toml", "--catalog", "motors.csv", "--json"];
    let found = |case: &Case, estimating: bool| {
        let out = if estimating { case.run_estimating(&files) } else { case.run(&files) };
        serde_json::from_str::<Value>(&out.1).unwrap()["joints"][0].clone()
    };
    for estimating in [true, false] {
        let joint = found(&case, estimating);
        assert!(names(&joint["candidates"]).is_empty(), "{joint}");
        let unjudged = names(&joint["unjudged"]);
        assert_eq!(unjudged.contains(&"rated"), !estimating, "{joint}");
        assert!(unjudged.contains(&"nothing") && !unjudged.contains(&"split"), "{joint}");
    }
    // A good one is better than the row's 1.5 K/W: the rated current does not count, the resistances do.
    fs::write(case.path().join("robot.toml"), asked("0.1 K/W")).unwrap();
    let joint = found(&case, true);
    let split = joint["candidates"].as_array().unwrap().iter().find(|c| c["motor"] == "split").unwrap();
    assert!(split["margins"].get("continuous_current").is_none(), "{split}");
    // 95 K over 0.6 K/W and hot copper.
    let bound: f64 = (95.0_f64 / 0.6 / (0.4 * (1.0 + 0.003_93 / (1.0 + 0.003_93 * 5.0) * 95.0))).sqrt();
    let limit = split["limits"].as_array().unwrap().iter().find(|l| l["limit"] == "winding_temperature").unwrap();
    assert!((limit["bound"].as_f64().unwrap() / bound - 1.0).abs() < 1e-6, "{limit} {bound}");
}

/// What the objective counts and nobody knows cannot be ranked: it is told apart with what is known of it.
#[test]
fn an_objective_that_is_not_known_is_no_rank() {
    let asked = robot("", RATIO, "").replace("[joint.limits]", "objective = \"mass\"\n[joint.limits]");
    let case = Case::new(&two(&[("mass", "")]), &asked);
    for options in [&[][..], &["--only-top", "1"]] {
        let (status, found) = case.json(&[&["optimize", "robot.toml", "--catalog", "motors.csv"], options].concat());
        let joint = &found["joints"][0];
        assert_eq!((status, names(&joint["candidates"]), names(&joint["unjudged"])), (0, vec!["known"], vec!["blank"]));
        assert!(joint["unjudged"][0]["because"].as_str().unwrap().contains("(objective)"), "{joint}");
        assert!(joint["unjudged"][0]["design"]["objective"].is_null(), "{joint}");
    }
    // A gear whose mass nobody knows, beside one that is known.
    let geared = asked.replace(RATIO, "gears = [\"planetary-*\"]");
    let case = Case::new(&catalog(&[("known", &[])]), &geared);
    fs::write(case.path().join("gears.csv"), GEARS.replace("0.95,150,", "0.95,,")).unwrap();
    let (_, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv"]);
    assert_eq!(found["joints"][0]["candidates"][0]["gear"], "planetary-8");
    fs::write(case.path().join("robot.toml"), geared.replace("planetary-*", "planetary-9")).unwrap();
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv"]);
    assert_eq!((status, names(&found["joints"][0]["unjudged"])), (1, vec!["known"]), "{found}");
}

#[test]
fn what_nobody_states_rules_nobody_out() {
    for (_, ratio, _, missing, _) in STATED {
        let case = Case::new(&two(missing), &robot("", ratio, ""));
        let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
        let joint = &found["joints"][0];
        assert_eq!((status, names(&joint["candidates"])), (0, vec!["blank", "known"]));
        assert!(names(&joint["unjudged"]).is_empty());
    }
}

/// No command is satisfied where only motors that cannot be judged could do it, and each says so.
#[test]
fn every_command_ends_with_status_1_where_nothing_can_be_judged() {
    for (top, ratio, limits, missing, name) in STATED {
        let case = Case::new(&only_blank(missing), &robot(top, ratio, limits));
        let commands: &[(&str, &[&'static str])] = &[
            ("optimize", &[]),
            ("optimize", &["--only-top", "2"]),
            ("optimize", &["--rejected"]),
            ("optimize", &["--robust"]),
            ("optimize", &["--robot"]),
            ("optimize", &["--only-checked"]),
            ("optimize", &["--pareto", "loss,reflected_inertia"]),
            ("sweep", &[]),
        ];
        for (command, options) in commands {
            let arguments = with(command, options);
            let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
            let (status, out, _) = case.run(&arguments);
            assert_eq!(status, 1, "{limits} {arguments:?}\n{out}");
            let said = flat(&out);
            assert!(said.contains("cannot be judged") || said.contains("cannot be checked"), "{arguments:?}\n{out}");
            assert!(!said.contains("NO motor of the catalogue"), "{limits} {arguments:?}\n{out}");
            let (status, found) = case.json(&arguments);
            assert_eq!(status, 1, "{limits} {arguments:?}");
            let unjudged = &found["joints"][0]["unjudged"];
            if options.contains(&"--only-checked") && names(unjudged).is_empty() {
                // The same blank cell keeps something from being checked that nobody states.
                assert_eq!(names(&found["joints"][0]["rejected"]), ["blank"], "{limits}");
                continue;
            }
            // A sweep lists every ratio.
            let mut listed = names(unjudged);
            listed.dedup();
            assert_eq!(listed, ["blank"], "{limits} {arguments:?}");
            assert!(unjudged[0]["because"].as_str().unwrap().contains(name), "{limits} {arguments:?} {unjudged}");
            if !options.contains(&"--robust") {
                let csv: Vec<&str> = arguments.iter().copied().chain(["--csv"]).collect();
                let (status, out, _) = case.run(&csv);
                assert!(status == 1 && out.contains("cannot be judged"), "{csv:?}\n{out}");
            }
        }
        let explain = ["explain", "blank", "robot.toml", "--catalog", "motors.csv"];
        let (status, out, _) = case.run(&explain);
        assert_eq!(status, 1, "{limits}\n{out}");
        assert!(flat(&out).contains("cannot be judged"), "{out}");
        let (status, found) = case.json(&explain);
        let found = &found["joints"][0];
        assert_eq!(
            (status, &found["design"]["feasible"], &found["judged"]),
            (1, &Value::Bool(true), &Value::Bool(false))
        );
        assert!(found["unjudged"].as_array().unwrap().iter().any(|u| u["limit"] == *name), "{found}");
        let (status, _, err) = case.run(&["export", "blank", "robot.toml", "--catalog", "motors.csv", "--to", "json"]);
        assert!(status == 1 && err.contains("cannot be judged"), "{err}");
    }
}

#[test]
fn nothing_unjudged_is_written_as_a_design() {
    for (top, ratio, limits, missing, _) in STATED {
        let case = Case::new(&only_blank(missing), &robot(top, ratio, limits));
        let (status, _, err) =
            case.run(&["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "design.toml"]);
        assert!(status == 1 && !case.path().join("design.toml").exists(), "{limits}");
        assert!(err.contains("cannot be judged"), "{err}");
    }
}

#[test]
fn a_design_that_cannot_be_judged_fails_its_check() {
    for (top, ratio, limits, missing, name) in STATED {
        let case = Case::new(&only_blank(missing), &robot(top, ratio, limits));
        let design = "requirement = \"robot.toml\"\ncatalog = [\"motors.csv\"]\n[[joint]]\nname = \"knee\"\nmotor = \"blank\"\nratio = 9\n";
        fs::write(case.path().join("design.toml"), design).unwrap();
        let (status, found) = case.json(&["check", "design.toml"]);
        let finding =
            found["findings"].as_array().unwrap().iter().find(|f| f["subject"] == *name && f["code"] == "GW033");
        let finding = finding.unwrap_or_else(|| panic!("{limits}: {found}"));
        assert_eq!((status, finding["severity"].as_str()), (1, Some("error")), "{limits}");
        assert_eq!(found["joints"][0]["judged"], false);
        assert!(finding["asked_for_at"]["line"].as_u64().unwrap() > 1, "{finding}");
        let twice =
            found["findings"].as_array().unwrap().iter().filter(|f| f["subject"] == *name && f["code"] != "GW033");
        assert_eq!(twice.count(), 0, "{limits}: said once");
        // Export of the same design.
        let (status, _, err) = case.run(&["export", "design.toml", "--to", "mjcf"]);
        assert!(status == 1 && err.contains("cannot be judged"), "{err}");
        // Where nobody states it, it is no error.
        fs::write(case.path().join("robot.toml"), robot("", ratio, "")).unwrap();
        let (_, found) = case.json(&["check", "design.toml"]);
        assert!(found["findings"].as_array().unwrap().iter().all(|f| f["code"] != "GW033"), "{found}");
    }
}

#[test]
fn gears_of_the_catalogue_are_judged_with_their_own_numbers() {
    // The gear of 9 is the better one, and its inertia is not known.
    let asked = robot("", "gears = [\"planetary-*\"]", "reflected_inertia = \"0.02 kg*m^2\"");
    let case = Case::new(&catalog(&[("known", &[])]), &asked);
    for options in [&[][..], &["--robust"], &["--only-top", "1"]] {
        let arguments = with("optimize", options);
        let (status, found) = case.json(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        let gear = &found["joints"][0]["candidates"][0]["gear"];
        // The row states no tolerance: the first choice is made, and is not known to keep its limits over any.
        let expected = i32::from(options.contains(&"--robust"));
        assert_eq!((status, gear.as_str()), (expected, Some("planetary-8")), "{options:?}");
    }
    // Nobody states an inertia: the better one is taken.
    fs::write(case.path().join("robot.toml"), robot("", "gears = [\"planetary-*\"]", "")).unwrap();
    let (_, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv"]);
    assert_eq!(found["joints"][0]["candidates"][0]["gear"], "planetary-9");
    // Only the one that cannot be judged.
    let asked = robot("", "gears = [\"planetary-9\"]", "reflected_inertia = \"0.02 kg*m^2\"");
    fs::write(case.path().join("robot.toml"), asked).unwrap();
    for command in ["optimize", "sweep"] {
        let (status, found) = case.json(&[command, "robot.toml", "--catalog", "motors.csv", "gears.csv"]);
        let unjudged = &found["joints"][0]["unjudged"];
        assert_eq!((status, names(unjudged)), (1, vec!["known"]), "{command}");
        assert!(unjudged[0]["because"].as_str().unwrap().contains("gear_inertia"), "{unjudged}");
    }
    // What is known of the inertia is too much already: that is a reason, and the cheaper one.
    let asked = robot("", "gears = [\"planetary-9\"]", "reflected_inertia = \"1e-5 kg*m^2\"");
    fs::write(case.path().join("robot.toml"), asked).unwrap();
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv"]);
    let joint = &found["joints"][0];
    assert_eq!((status, names(&joint["rejected"]), names(&joint["unjudged"])), (1, vec!["known"], vec![]));
}

#[test]
fn what_exceeds_another_limit_is_rejected_and_not_unjudged() {
    // 0.6 A of peak current for 2.5 to 10 A.
    for (top, ratio, limits, missing, _) in STATED.iter().filter(|s| s.3[0].0 != "peak_current") {
        let weak: Vec<(&str, &str)> =
            missing.iter().copied().chain([("peak_current", "0.6"), ("continuous_current", "0.5")]).collect();
        let case = Case::new(&catalog(&[("weak", &weak), ("known", &[])]), &robot(top, ratio, limits));
        let (_, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
        let joint = &found["joints"][0];
        assert_eq!((names(&joint["rejected"]), names(&joint["unjudged"])), (vec!["weak"], vec![]), "{limits}");
    }
    // Half a kilogram of gear alone is too heavy.
    let heavy = "ratio = { min = 5, max = 20 }\ngear = { efficiency = 0.9, mass = \"500 g\" }";
    let case = Case::new(&only_blank(&[("mass", "")]), &robot("", heavy, "actuator_mass = \"400 g\""));
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
    let joint = &found["joints"][0];
    assert_eq!((status, names(&joint["rejected"]), names(&joint["unjudged"])), (1, vec!["blank"], vec![]));
}

#[test]
fn heat_without_durations_cannot_be_judged() {
    let asked = robot("", RATIO, "winding_temperature = \"110 degC\"").replace(", duration = \"1 s\"", "");
    // What could hold the hottest point for ever is kept in any order and for any time, and that is the choice.
    let case = Case::new(&catalog(&[("known", &[])]), &asked);
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
    assert_eq!((status, names(&found["joints"][0]["candidates"])), (0, vec!["known"]), "{found}");
    let hot = asked.replace("torque = \"5 N*m\"", "torque = \"60 N*m\"");
    fs::write(case.path().join("robot.toml"), hot).unwrap();
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
    let because = found["joints"][0]["unjudged"][0]["because"].as_str().unwrap();
    assert!(status == 1 && because.contains("no durations"), "{because}");
    // A rating of the gear that the requirement describes is stated, too.
    let gear =
        "ratio = { min = 5, max = 20 }\ngear = { efficiency = 0.9, mass = \"1 g\", continuous_torque = \"9 N*m\" }";
    let asked = robot("", gear, "").replace(", duration = \"1 s\"", "");
    fs::write(case.path().join("robot.toml"), asked).unwrap();
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
    let because = found["joints"][0]["unjudged"][0]["because"].as_str().unwrap();
    assert!(status == 1 && because.contains("gear_continuous_torque"), "{because}");
}

/// Of the first K no unjudged one counts, whatever its bound.
#[test]
fn the_first_k_are_k_that_can_be_judged() {
    let rows: Vec<(String, Vec<(&str, &str)>)> = (0..30)
        .map(|k| {
            let mut cells = vec![("resistance", ["0.20", "0.21", "0.22", "0.23", "0.24", "0.25"][k % 6])];
            if k % 3 != 2 {
                cells.push(("mass", ""));
            }
            (format!("m{k:02}"), cells)
        })
        .collect();
    let rows: Vec<(&str, &[(&str, &str)])> = rows.iter().map(|(id, cells)| (id.as_str(), cells.as_slice())).collect();
    let case = Case::new(&catalog(&rows), &robot("", RATIO, "actuator_mass = \"1 kg\""));
    let all = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]).1;
    let all = names(&all["joints"][0]["candidates"]).iter().map(|s| s.to_string()).collect::<Vec<_>>();
    assert_eq!(all.len(), 10);
    for k in ["1", "3", "7"] {
        let first = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv", "--only-top", k]).1;
        let first = names(&first["joints"][0]["candidates"]).iter().map(|s| s.to_string()).collect::<Vec<_>>();
        assert_eq!(first, all[..k.parse().unwrap()], "{k}");
    }
}

#[test]
fn a_study_counts_what_cannot_be_judged_and_takes_no_such_motor() {
    let case = Case::new(&two(&[("mass", "")]), &robot("", RATIO, "actuator_mass = \"1 kg\""));
    fs::write(case.path().join("alone.csv"), only_blank(&[("mass", "")])).unwrap();
    for (catalog, first) in [("motors.csv", Some("known")), ("alone.csv", None)] {
        let (status, out, err) = case.run(&["study", "robot.toml", "--out", "result", "--force", "--catalog", catalog]);
        assert_eq!(status, 0, "{out}{err}");
        let text = fs::read_to_string(case.path().join("result/results.csv")).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let header = reader.headers().unwrap().clone();
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        let cell = |name: &str| rows[0].get(header.iter().position(|h| h == name).unwrap()).unwrap().to_string();
        assert_eq!((rows.len(), cell("motor").as_str()), (1, first.unwrap_or("")));
        assert_eq!(cell("unjudged_motors"), "1");
        match first {
            Some(_) => assert_eq!(cell("because"), ""),
            None => {
                assert!(cell("because").contains("cannot be judged"), "{text}");
                assert!(out.contains("no motor that can be judged"), "{out}");
            }
        }
        let summary: Value =
            serde_json::from_str(&fs::read_to_string(case.path().join("result/summary.json")).unwrap()).unwrap();
        let joint = &summary["joints"][0];
        assert_eq!(
            (joint["without_design"].as_u64(), joint["unjudged"].as_u64()),
            match first {
                Some(_) => (Some(0), Some(0)),
                None => (Some(1), Some(1)),
            }
        );
    }
}

#[test]
fn fronts_honour_only_checked_and_say_what_was_not_checked() {
    // Without an inductance, which nobody states: a choice, but not a checked one.
    let motors = catalog(&[("blank", &[("resistance", "0.2"), ("inductance", "")]), ("known", &[])]);
    let case = Case::new(&motors, &robot("", RATIO, ""));
    let front = ["optimize", "robot.toml", "--catalog", "motors.csv", "--pareto", "loss,reflected_inertia"];
    let on = |found: &Value| {
        let mut all: Vec<String> = names(&found["joints"][0]["candidates"]).iter().map(|s| s.to_string()).collect();
        all.dedup();
        all
    };
    let (status, found) = case.json(&front);
    assert_eq!((status, on(&found)), (0, vec!["blank".to_string()]));
    let unchecked = &found["joints"][0]["candidates"][0]["not_checked"];
    assert!(unchecked.as_array().unwrap().iter().any(|u| u["limit"] == "inductance"), "{unchecked}");
    let (_, out, _) = case.run(&front);
    assert!(flat(&out).contains("not checked: inductance, because"), "{out}");
    let (_, out, _) = case.run(&[&front[..], &["--csv"]].concat());
    assert!(out.contains("inductance"), "{out}");
    let checked = [&front[..], &["--only-checked"]].concat();
    let (status, found) = case.json(&checked);
    assert_eq!((status, on(&found)), (0, vec!["known".to_string()]));
    let rejected = &found["joints"][0]["rejected"];
    assert_eq!(names(rejected), ["blank"], "{rejected}");
    let (_, out, _) = case.run(&checked);
    assert!(!out.contains("not checked:"), "{out}");
    // Alone, nothing is left.
    fs::write(case.path().join("motors.csv"), catalog(&[("blank", &[("inductance", "")])])).unwrap();
    assert_eq!(case.run(&checked).0, 1);
    assert_eq!(case.run(&front).0, 0);
}

#[test]
fn pages_tell_who_cannot_be_judged() {
    let case = Case::new(&two(&[("mass", "")]), &robot("", RATIO, "actuator_mass = \"1 kg\""));
    let pages: &[&[&str]] = &[
        &["optimize", "robot.toml", "--catalog", "motors.csv"],
        &["optimize", "robot.toml", "--catalog", "motors.csv", "--pareto", "loss,reflected_inertia"],
        &["sweep", "robot.toml", "--catalog", "motors.csv"],
        &["explain", "blank", "robot.toml", "--catalog", "motors.csv"],
    ];
    for arguments in pages {
        case.run(&[*arguments, &["--html", "page.html"][..]].concat());
        let page = fs::read_to_string(case.path().join("page.html")).unwrap();
        assert!(page.contains("cannot be judged"), "{arguments:?}");
        fs::remove_file(case.path().join("page.html")).unwrap();
    }
}

/// Random requirements and rows with cells missing at random: whatever is first, of it every stated limit was judged,
/// told from the rows themselves.
#[test]
fn no_first_choice_is_unjudged() {
    let mut generator = Pcg64::seed_from_u64(15);
    let mut random = move || (generator.next_u64() >> 11) as f64 * 2.0_f64.powi(-53);
    let (mut first, mut empty, mut blank_would_win) = (0, 0, 0);
    for round in 0..120 {
        let mut chance = |p: f64| random() < p;
        let mut rows = Vec::new();
        for k in 0..8 {
            let mut cells = vec![("resistance".to_string(), format!("{}", 0.2 + 0.05 * f64::from(k)))];
            for column in
                ["inductance", "mass", "pole_pairs", "continuous_current", "peak_current", "max_winding_temperature"]
            {
                if chance(0.3) {
                    cells.push((column.into(), String::new()));
                }
            }
            if chance(0.4) {
                cells.extend(HEAT.iter().map(|(c, e)| (c.to_string(), e.to_string())));
            }
            rows.push((format!("m{k}"), cells));
        }
        let rows: Vec<(String, Vec<(&str, &str)>)> = rows
            .iter()
            .map(|(id, cells)| (id.clone(), cells.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect()))
            .collect();
        let rows: Vec<(&str, &[(&str, &str)])> =
            rows.iter().map(|(id, cells)| (id.as_str(), cells.as_slice())).collect();
        let [mass, heat, inertia, bandwidth, budget, geared] = [0; 6].map(|_| chance(0.4));
        let mut limits = String::new();
        if mass {
            limits.push_str("actuator_mass = \"1 kg\"\n");
        }
        if heat {
            limits.push_str("winding_temperature = \"110 degC\"\n");
        }
        if inertia {
            limits.push_str("reflected_inertia = \"0.02 kg*m^2\"\n");
        }
        if bandwidth {
            limits.push_str("torque_bandwidth = { frequency = \"10 Hz\", amplitude = \"0.5 N*m\" }\n");
        }
        let top = if budget { "[budget]\nactuator_mass = \"1 kg\"" } else { "" };
        let ratio = if geared { "gears = [\"planetary-*\"]" } else { RATIO };
        let sources = [("motors.csv", catalog(&rows)), ("gears.csv", GEARS.to_string())];
        let sources = sources.map(|(name, text)| Arc::new(Source::new(name, text))).to_vec();
        let catalog = Catalog::from_sources(sources).unwrap_or_else(|e| panic!("{}", e[0]));
        let robot = requirement::read_source(&Arc::new(Source::new("robot.toml", robot(top, ratio, &limits)))).unwrap();
        let mut firsts = Vec::new();
        for keep in [None, Some(1), Some(3)] {
            let result = optimize_with(&robot, &catalog, Options { keep, ..Options::default() }).unwrap();
            for design in &result.joints[0].candidates {
                let motor = design.motor;
                let gear = design.gear.map(|id| catalog.gears.iter().find(|g| g.id == id).unwrap());
                let what = format!("round {round}, {keep:?}: {} {:?}", motor.id, design.gear);
                let known_mass = motor.mass.is_some() && gear.is_none_or(|g| g.mass.is_some());
                assert!(!(mass || budget) || known_mass, "mass: {what}");
                assert!(!heat || motor.thermal_resistance.is_some(), "temperature: {what}");
                let witnesses = [motor.continuous_current, motor.continuous_torque, motor.thermal_resistance];
                assert!(witnesses.iter().any(Option::is_some), "heat: {what}");
                assert!(!inertia || gear.is_none_or(|g| g.inertia.is_some()), "inertia: {what}");
                assert!(
                    !bandwidth || (motor.inductance_and_poles().is_some() && motor.peak_current.is_some()),
                    "bandwidth: {what}"
                );
            }
            firsts.push(result.joints[0].candidates.first().map(|d| d.motor.id.clone()));
        }
        assert!(firsts.iter().all(|f| *f == firsts[0]), "round {round}: {firsts:?}");
        match &firsts[0] {
            Some(id) => {
                first += 1;
                blank_would_win += usize::from(id != "m0");
            }
            None => empty += 1,
        }
    }
    assert!(first > 60 && empty > 3 && blank_would_win > 30, "{first} {empty} {blank_would_win}");
}

/// Points whose worst order may be too hot at the best ratio, and is not at another: of the ratios that can be judged
/// the best is the choice, in every command, and no window holds another.
#[test]
fn of_the_ratios_that_can_be_judged_the_best_is_the_choice() {
    let nodes = [("thermal_resistance_winding_housing", "1"), ("thermal_resistance_housing_ambient", "3")];
    let row: Vec<(&str, &str)> = nodes.to_vec();
    let motors = catalog(&[("hot", &row)]).replace(
        "max_winding_temperature [degC]",
        "thermal_time_constant_winding [s],thermal_time_constant_housing [s],max_winding_temperature [degC]",
    );
    let motors = motors.replace(",20000,120,", ",20000,6,600,120,");
    let asked = "name = \"leg\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"60 A\"\n[[joint]]\nname = \"knee\"\n\
                 ratio = { min = 4, max = 40 }\nmotor_drag = \"off\"\nobjective = \"reflected_inertia\"\n\
                 points = [ { torque = \"12 N*m\", speed = \"1 rad/s\", duration = \"6 s\" }, { torque = \"1 N*m\", speed = \"2 rad/s\", duration = \"60 s\" } ]\n\
                 [joint.limits]\nwinding_temperature = \"110 degC\"\n";
    let case = Case::new(&motors, asked);
    let (status, found) = case.json(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
    let joint = &found["joints"][0];
    assert_eq!((status, names(&joint["candidates"])), (0, vec!["hot"]), "{found}");
    let best = &joint["candidates"][0];
    let ratio = best["ratio"].as_f64().unwrap();
    assert_eq!(best["binds_at"]["low"]["limit"], "winding_peak_temperature");
    assert!(best["binds_at"]["low"]["unjudged"].as_str().unwrap().contains("order"), "{best}");
    assert_eq!(best["certificate"]["certified"], false);
    assert!((best["window"][0].as_f64().unwrap() / ratio - 1.0).abs() < 1e-9);
    // Just below it no other limit is exceeded, and it cannot be judged; from it on it can.
    let at = |n: f64| case.json(&["explain", &format!("hot@{n}"), "robot.toml", "--catalog", "motors.csv"]);
    for (n, judged) in [(ratio * 0.999, false), (ratio * 1.0001, true), (ratio * 1.5, true), (39.0, true)] {
        let (status, story) = at(n);
        let story = &story["joints"][0];
        let feasible = story["design"]["feasible"].as_bool();
        assert_eq!((feasible, story["judged"].as_bool()), (Some(true), Some(judged)), "{n} {story}");
        assert_eq!(status, i32::from(!judged));
    }
    // The same in the other commands.
    let (_, swept) = case.json(&["sweep", "robot.toml", "--catalog", "motors.csv", "--ratios", "200"]);
    let judged = swept["joints"][0]["candidates"].as_array().unwrap().iter();
    let least = judged.map(|d| d["ratio"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert!(least >= ratio * (1.0 - 1e-9) && least < ratio * 1.02, "{least} {ratio}");
    let front = ["optimize", "robot.toml", "--catalog", "motors.csv", "--pareto", "loss,reflected_inertia"];
    let (status, front) = case.json(&front);
    let points = front["joints"][0]["candidates"].as_array().unwrap();
    let smallest = points.iter().map(|p| p["ratio"].as_f64().unwrap()).fold(f64::INFINITY, f64::min);
    assert!(status == 0 && (smallest / ratio - 1.0).abs() < 1e-6, "{smallest} {ratio}");
    let (_, out, _) = case.run(&["optimize", "robot.toml", "--catalog", "motors.csv"]);
    assert!(flat(&out).contains("beyond this ratio winding_peak_temperature cannot be judged"), "{out}");
    let (_, out, _) = case.run(&["optimize", "robot.toml", "--catalog", "motors.csv", "--full"]);
    assert!(flat(&out).contains("(winding_peak_temperature cannot be judged beyond) to"), "{out}");
}

/// Within its tolerances a motor may be one that cannot be judged: then it keeps nothing "over its tolerances".
#[test]
fn a_corner_that_cannot_be_judged_is_not_kept() {
    let tolerated = |motors: &str| {
        let motors =
            motors.replace("torque_constant [N*m/A],", "torque_constant [N*m/A],torque_constant_tolerance [%],");
        motors.replace(",0.1,0.1,100,", ",0.1,0.1,20,100,")
    };
    // Twenty seconds of much torque, three minutes of little: the mean is far below the limit.
    let asked = robot("drive_current = \"60 A\"", "ratio = { min = 10, max = 10.5 }", "winding_temperature = \"110 degC\"").replace(
        "points = [ { torque = \"5 N*m\", speed = \"2 rad/s\", duration = \"1 s\" }, { torque = \"-1 N*m\", speed = \"5 rad/s\", duration = \"1 s\" } ]",
        "points = [ { torque = \"TORQUE\", speed = \"2 rad/s\", duration = \"20 s\" }, { torque = \"1 N*m\", speed = \"5 rad/s\", duration = \"180 s\" } ]",
    );
    let motors = catalog(&[("wide", &[])]);
    // The limit for ever is 8.95 A by the resistances: 8.5 N·m are 8.1 A by the printed numbers, and 10.1 A at a corner.
    let case = Case::new(&tolerated(&motors), &asked.replace("TORQUE", "8.5 N*m"));
    let command = ["optimize", "robot.toml", "--catalog", "motors.csv", "--robust"];
    let (_, found) = case.json(&command);
    let joint = &found["joints"][0];
    assert_eq!((names(&joint["candidates"]).len(), names(&joint["rejected"])), (0, vec!["wide"]), "{joint}");
    assert!(joint["rejected"][0]["because"].as_str().unwrap().starts_with("cannot be judged"), "{joint}");
    let share = joint["contenders"][0]["feasible_at_nominal_ratio"]["share"].as_f64().unwrap();
    assert!(share < 0.95, "samples that cannot be judged are not kept: {share}");
    // Where all corners can be judged it is kept.
    let case = Case::new(&tolerated(&motors), &asked.replace("TORQUE", "5 N*m"));
    let (_, found) = case.json(&command);
    assert_eq!(names(&found["joints"][0]["candidates"]), ["wide"], "{found}");
}

/// What is forbidden is no choice, though it keeps every limit.
#[test]
fn a_gear_that_is_not_allowed_or_does_not_fit_is_no_choice() {
    let gears = GEARS
        .replace("planetary-9,planetary,9,2,0.95,150,,*,", "planetary-9,planetary,9,2,0.95,150,1,other-*,")
        + "spur-8,spur,8,1,0.9,140,5,*,a sheet,datasheet\n";
    let case = Case::new(&catalog(&[("known", &[])]), &robot("", "gears = [\"planetary-*\"]", ""));
    fs::write(case.path().join("gears.csv"), gears).unwrap();
    for (gear, why) in
        [("planetary-8", None), ("planetary-9", Some("is not made for")), ("spur-8", Some("does not allow"))]
    {
        let command = ["explain", &format!("known@{gear}"), "robot.toml", "--catalog", "motors.csv", "gears.csv"];
        let (status, story) = case.json(&command);
        assert_eq!(
            (status, story["joints"][0]["allowed"].as_bool()),
            (i32::from(why.is_some()), Some(why.is_none())),
            "{gear}"
        );
        let (_, out, _) = case.run(&command);
        match why {
            Some(why) => assert!(flat(&out).contains(why) && !flat(&out).contains("keeps every limit"), "{out}"),
            None => assert!(flat(&out).contains("keeps every limit that could be checked"), "{out}"),
        }
    }
}

/// What is assumed stands wherever a design does.
#[test]
fn an_assumption_is_told_beside_every_design() {
    // A motor whose own highest temperature is not known, where the requirement has one.
    let case = Case::new(
        &catalog(&[("blank", &[("max_winding_temperature", "")])]),
        &robot("drive_current = \"60 A\"", RATIO, "winding_temperature = \"110 degC\""),
    );
    let files = ["robot.toml", "--catalog", "motors.csv"];
    let tell = "the motor's own highest temperature is not known";
    let commands: [&[&str]; 4] = [
        &["optimize", "--why"],
        &["optimize", "--robust"],
        &["optimize", "--pareto", "loss,reflected_inertia"],
        &["explain", "blank"],
    ];
    // The shortest answer says how many.
    assert!(flat(&case.run(&[&["optimize"], &files[..]].concat()).1).contains("; 1 assumed"));
    for command in commands {
        let all: Vec<&str> = command[..1].iter().chain(&command[1..]).chain(&files).copied().collect();
        let (status, out, err) = case.run(&all);
        // Of a row without tolerances nothing is known over them.
        let robust = command.contains(&"--robust");
        assert!(status == i32::from(robust) && flat(&out).contains(tell), "{command:?} {out}{err}");
        let (_, found) = case.json(&all);
        assert!(found.to_string().contains(tell), "{command:?}");
    }
    for command in ["optimize", "sweep"] {
        let (_, out, _) = case.run(&[&[command], &files[..], &["--csv"]].concat());
        let header: Vec<&str> = out.lines().next().unwrap().split(',').collect();
        let place = header.iter().position(|h| *h == "assumed").unwrap();
        assert!(out.lines().nth(1).unwrap().split(',').nth(place).unwrap().contains("winding_temperature"), "{out}");
    }
    case.run(&[&["optimize"], &files[..], &["--write-design", "design.toml"]].concat());
    let (status, out, _) = case.run(&["check", "design.toml"]);
    assert!(status == 0 && flat(&out).contains(tell), "{out}");
    // With it nothing is assumed.
    fs::write(case.path().join("motors.csv"), catalog(&[("blank", &[])])).unwrap();
    let without = flat(&case.run(&[&["optimize", "--why"], &files[..]].concat()).1);
    assert!(!without.contains(tell) && !without.contains("assumed"), "{without}");
}
