//! Design rules as a user meets them: every rule broken and kept, wrong files refused with their place, machine
//! forms that validate, and the shipped designs.

use std::collections::{BTreeMap, HashSet};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::Arc;

use gearwise::catalog::Catalog;
use gearwise::input::Source;
use gearwise::requirement::DesignFile;
use gearwise::rules::file::{RulesFile, read_source};
use gearwise::rules::lock::Lock;
use gearwise::rules::measure::measures;
use gearwise::rules::{Finding, RULES, Report, Severity};
use serde_json::Value;

use crate::common;

const ROBOT: &str = r#"name = "leg"

[bus]
voltage = "48 V"
drive_current = "40 A"
power = "200 W"
current = "10 A"
regeneration = "100 W"
drive_continuous_current = "30 A"
max_voltage = "48.5 V"

[prices]
currency = "EUR"
rates = { CNY = 0.125 }
date = "2026-11-01"

[budget]
actuator_mass = "6 kg"
max_distinct_motors = 1

[[joint]]
name = "knee"
count = 2
ratio = { min = 8, max = 9.5 }
motor_drag = "off"
gear = { efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2", peak_torque = "20 N*m", continuous_torque = "12 N*m", max_input_speed = "6000 rpm", momentary_peak_torque = "44 N*m", ratcheting_torque = "45 N*m", average_input_speed = "3000 rpm", continuous_torque_is = "rated_life", rated_life = "7000 h", rated_speed = "2000 rpm", life_quantile = "L10", starting_torque = "0 N*m", backlash = "1 arcmin", stiffness = "9000 N*m/rad", outer_diameter = "85 mm", length = "9 mm", price = "800 CNY", lead_time = "7 d" }
motion = "knee.csv"
transmission = { four_bar = { ground = ["0 mm", "250 mm"], crank = "50 mm", coupler = "250 mm", rocker = "50 mm" }, backlash = "0 arcmin", stiffness = "1e9 N*m/rad", peak_torque = "21 N*m", max_force = "2000 N", max_input_speed = "20 rad/s", outer_diameter = "9 mm", length = "0 mm", price = "0 EUR", lead_time = "0 d" }
[joint.limits]
actuator_mass = "0.6 kg"
outer_diameter = "90 mm"
axial_length = "40 mm"
price = "300 EUR"
lead_time = "30 d"
reflected_inertia = "0.02 kg*m^2"
torque_bandwidth = { frequency = "20 Hz", amplitude = "1 N*m" }
winding_temperature = "110 degC"
safety = 1.2
shock_torque = "30 N*m"
life = "10 h"
max_backlash = "2 arcmin"
min_stiffness = "5000 N*m/rad"
max_backdriving_torque = "4 N*m"

[[joint]]
name = "hip"
ratio = { min = 8, max = 9.5 }
motor_drag = "off"
gear = { average_torque = "5 N*m" }
points = [ { torque = "1 N*m", speed = "1 rad/s", duration = "1 s" } ]
"#;

const DESIGN: &str = r#"requirement = "robot.toml"
catalog = ["motors.csv", "gears.csv", "modules.csv"]
rules = "rules.toml"

[[joint]]
name = "knee"
motor = "alpha-1"
ratio = 9

[[joint]]
name = "hip"
motor = "alpha-1"
ratio = 9
"#;

const GEARS: &str = "id,kind,ratio,stages,efficiency,mass [g],inertia [g*cm^2],continuous_torque [N*m],peak_torque [N*m],fits,source,source_kind
planetary-9,planetary,9,2,0.9,150,5,14,28,beta-*,a sheet,datasheet
planetary-40,planetary,40,2,0.9,150,5,14,28,*,a sheet,datasheet
";

/// Modules that each break one limit of their own, and nothing else.
const MODULES: &str = "id,drive,ratio,peak_torque [N*m],rated_torque [N*m],no_load_speed [rad/s],voltage [V],min_voltage [V],max_voltage [V],driving_curve [rad/s : N*m],overload [N*m : s],armature [kg*m^2],armature_side,mass [g],source,source_kind
slow,built_in,9,60,50,100,48,20,60,0:60 4:0.1 100:0,,0.002,output,500,a sheet,datasheet
weak,built_in,9,60,1.5,100,48,20,60,0:60 90:60 100:0,,0.002,output,500,a sheet,datasheet
warm,built_in,9,60,1.5,100,48,20,60,0:60 90:60 100:0,2:100 3:20 5:4,0.002,output,500,a sheet,datasheet
low,built_in,9,60,50,100,48,12,30,0:60 90:60 100:0,,0.002,output,500,a sheet,datasheet
";

/// A design with a module at the knee; its requirement states no temperature of a winding.
const AT_THE_KNEE: [(&str, &str); 2] = [
    ("ratio = { min = 8, max = 9.5 }", "ratio = { min = 8, max = 9.5 }\nmodules = [\"*\"]"),
    ("winding_temperature = \"110 degC\"", ""),
];

/// Columns of the motor with their cells.
const MOTOR: &[(&str, &str)] = &[
    ("id", "alpha-1"),
    ("terminals", "q_axis"),
    ("current", "q_axis"),
    ("resistance [ohm]", "0.2"),
    ("inductance [mH]", "0.1"),
    ("torque_constant [N*m/A]", "0.08"),
    ("motor_constant [N*m/W^0.5]", ""),
    ("rotor_inertia [g*cm^2]", "300"),
    ("mass [g]", "200"),
    ("outer_diameter [mm]", "80"),
    ("length [mm]", "30"),
    ("price", "150"),
    ("price_currency", "EUR"),
    ("price_date", "2026-01-31"),
    ("lead_time [d]", "14"),
    ("pole_pairs", "7"),
    ("continuous_current [A]", "12"),
    ("peak_current [A]", "40"),
    ("continuous_torque [N*m]", "0.96"),
    ("peak_torque [N*m]", "2.5"),
    ("max_speed [rpm]", "8000"),
    ("thermal_resistance_winding_housing [K/W]", "0.5"),
    ("thermal_resistance_housing_ambient [K/W]", "1.5"),
    ("thermal_time_constant_winding [s]", "5"),
    ("thermal_time_constant_housing [s]", "500"),
    ("max_winding_temperature [degC]", "120"),
    ("viscous_friction [N*m*s/rad]", "1e-5"),
    ("coulomb_friction [N*m]", "1e-9"),
    ("source", "a sheet"),
    ("source_kind", "datasheet"),
];

/// The motor's row with cells changed, and a second motor like it.
fn motors(changes: &[(&str, &str)]) -> String {
    let header: Vec<&str> = MOTOR.iter().map(|(name, _)| *name).collect();
    let row = |id: &str| -> Vec<String> {
        let changed = |name: &str, cell: &str| {
            let new = changes.iter().find(|(column, _)| name == *column || name.starts_with(&format!("{column} [")));
            new.map_or(cell.to_string(), |(_, new)| format!("\"{}\"", new.replace('"', "\"\"")))
        };
        MOTOR.iter().map(|(name, cell)| if *name == "id" { id.into() } else { changed(name, cell) }).collect()
    };
    format!("{}\n{}\n{}\n", header.join(","), row("alpha-1").join(","), row("alpha-2").join(","))
}

/// Rest, then to and fro: a load of 0.01 kg m² and a constant torque of 3 N m. The joint's linkage is a parallelogram.
fn motion() -> String {
    let mut text = String::from("time [s], torque [N*m], velocity [rad/s], position [rad], acceleration [rad/s^2]\n");
    let pi = std::f64::consts::PI;
    for k in 0..=100 {
        let t = f64::from(k) / 100.0;
        let s = ((t - 0.3) / 0.7).max(0.0);
        let (two, one) = (2.0 * pi * s, pi * s);
        let velocity = if k == 100 || s == 0.0 { 0.0 } else { 8.0 * two.sin() * one.sin().powi(2) };
        let rate = 2.0 * pi * two.cos() * one.sin().powi(2) + pi * two.sin() * two.sin();
        let acceleration = if velocity == 0.0 && k != 65 { 0.0 } else { 8.0 * rate / 0.7 };
        let position = 0.7 * 8.0 * (1.0 - two.cos()).powi(2) / (8.0 * pi);
        text.push_str(&format!("{t},{},{velocity},{position},{acceleration}\n", 3.0 + 0.01 * acceleration));
    }
    text
}

/// The good text with each `(from, to)` replaced; every `from` must occur.
fn spoil(good: &str, changes: &[(&str, &str)]) -> String {
    let mut text = good.to_string();
    for (from, to) in changes {
        assert!(text.contains(from), "`{from}` is not in the good file");
        text = text.replacen(from, to, 1);
    }
    text
}

type Changes<'a> = &'a [(&'a str, &'a str)];

/// What is changed about the good files.
#[derive(Clone, Copy, Default)]
struct Case<'a> {
    robot: Changes<'a>,
    design: Changes<'a>,
    motor: Changes<'a>,
    rules: &'a str,
}

fn write(folder: &Path, case: Case) {
    let file = |name: &str, text: String| fs::write(folder.join(name), text).unwrap();
    file("robot.toml", spoil(ROBOT, case.robot));
    file("design.toml", spoil(DESIGN, case.design));
    file("motors.csv", motors(case.motor));
    file("gears.csv", GEARS.into());
    file("modules.csv", MODULES.into());
    file("rules.toml", case.rules.into());
    file("knee.csv", motion());
}

/// Checks a case in memory and looks at the report.
fn checked<T>(case: Case, lock: bool, look: impl FnOnce(&Report) -> T) -> T {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), case);
    let design = DesignFile::read(&folder.path().join("design.toml")).unwrap_or_else(|e| panic!("{}", e[0]));
    let catalog = Catalog::read(&design.catalog).unwrap_or_else(|e| panic!("{}", e[0]));
    let catalog = catalog.with_modules(design.robot.modules(), |module| module);
    let rules = Source::new("rules.toml", case.rules);
    let rules: RulesFile = read_source(&Arc::new(rules)).unwrap_or_else(|e| panic!("{e}"));
    // The lock is that of the good row.
    let locked = lock.then(|| {
        fs::write(folder.path().join("good.csv"), motors(&[])).unwrap();
        let files = ["good.csv", "gears.csv", "modules.csv"].map(|name| folder.path().join(name));
        let good = Catalog::read(&files).unwrap();
        let text = Lock::of(&design, &design.choices(&good).unwrap(), &good).to_toml();
        Arc::new(Source::new("design.lock", text))
    });
    let report = gearwise::rules::check(&design, &catalog, &rules, locked.as_ref(), Path::new("design.lock"));
    look(&report.unwrap_or_else(|e| panic!("{}", e[0])))
}

fn codes(report: &Report) -> Vec<String> {
    report.findings.iter().map(|f| report.rule_of(f).code.clone()).collect()
}

/// For each rule what breaks it. What is not named is as in the good files, which keep every rule.
fn breaking(code: &str) -> Case<'static> {
    let robot = |robot| Case { robot, ..Case::default() };
    let design = |design| Case { design, ..Case::default() };
    let motor = |motor| Case { motor, ..Case::default() };
    let rules = |rules| Case { rules, ..Case::default() };
    match code {
        "GW001" => robot(&[("\"40 A\"", "\"4 A\""), ("\"30 A\"", "\"4 A\"")]),
        "GW002" => motor(&[("peak_torque", "0.3")]),
        "GW003" | "GW007" => motor(&[("continuous_current", "2")]),
        "GW004" => motor(&[("continuous_torque", "0.2")]),
        "GW005" | "GW006" => motor(&[("thermal_resistance_housing_ambient", "200")]),
        "GW008" => robot(&[("\"48 V\"", "\"5 V\"")]),
        "GW009" => motor(&[("max_speed", "200")]),
        "GW010" => robot(&[("\"6000 rpm\"", "\"200 rpm\""), ("\"3000 rpm\"", "\"150 rpm\"")]),
        "GW011" => robot(&[("\"20 N*m\"", "\"3 N*m\""), ("\"12 N*m\"", "\"2 N*m\"")]),
        "GW012" => robot(&[("\"12 N*m\"", "\"2 N*m\"")]),
        "GW013" => robot(&[("\"0.02 kg*m^2\"", "\"0.001 kg*m^2\"")]),
        "GW014" | "GW015" => robot(&[("\"1 N*m\" }", "\"300 N*m\" }")]),
        "GW016" => robot(&[("\"200 W\"", "\"5 W\"")]),
        "GW017" => robot(&[("\"10 A\"", "\"0.1 A\"")]),
        "GW018" => robot(&[("\"100 W\"", "\"none\"")]),
        "GW019" => robot(&[("\"0.6 kg\"", "\"0.3 kg\"")]),
        "GW020" => robot(&[("\"90 mm\"", "\"60 mm\"")]),
        "GW021" => robot(&[("\"40 mm\"", "\"20 mm\"")]),
        "GW022" => robot(&[("average_torque = \"5 N*m\"", "average_torque = \"0.5 N*m\"")]),
        "GW023" => robot(&[("\"44 N*m\"", "\"29 N*m\"")]),
        "GW024" => robot(&[("\"45 N*m\"", "\"31 N*m\""), ("\"44 N*m\"", "\"30 N*m\"")]),
        "GW025" => robot(&[("\"3000 rpm\"", "\"10 rpm\"")]),
        "GW026" => robot(&[("life = \"10 h\"", "life = \"9999999 h\"")]),
        "GW027" => robot(&[("\"2 arcmin\"", "\"0.5 arcmin\"")]),
        "GW028" => robot(&[("\"5000 N*m/rad\"", "\"50000 N*m/rad\"")]),
        "GW029" => robot(&[("starting_torque = \"0 N*m\"", "starting_torque = \"1 N*m\"")]),
        "GW030" => motor(&[("rotor_inertia", "")]),
        "GW031" => motor(&[("inductance", "")]),
        "GW032" => motor(&[("viscous_friction", ""), ("coulomb_friction", "")]),
        "GW033" => motor(&[("mass", "")]),
        "GW034" => robot(&[("\"30 A\"", "\"0.3 A\"")]),
        "GW035" => robot(&[("\"48.5 V\"", "\"4.05 V\""), ("\"48 V\"", "\"4 V\"")]),
        "GW036" => robot(&[("\"48.5 V\"", "\"48.5 V\"\ninternal_resistance = \"2000 ohm\"")]),
        "GW037" => robot(&[("\"300 EUR\"", "\"200 EUR\"")]),
        "GW038" => robot(&[("\"30 d\"", "\"10 d\"")]),
        "GW040" => robot(&[("\"6 kg\"", "\"0.5 kg\"")]),
        "GW041" => design(&[("name = \"hip\"\nmotor = \"alpha-1\"", "name = \"hip\"\nmotor = \"alpha-2\"")]),
        "GW043" => robot(&[("\"6 kg\"", "\"6 kg\"\npower = \"1 W\"")]),
        // Each joint keeps its voltage alone.
        "GW044" => robot(&[("\"48.5 V\"", "\"480 V\"\ninternal_resistance = \"14 ohm\"")]),
        "GW045" => robot(&[("\"6 kg\"", "\"6 kg\"\nregeneration = \"0 W\"")]),
        "GW046" => Case {
            robot: &AT_THE_KNEE,
            design: &[("\"alpha-1\"\nratio = 9", "\"slow\"\nratio = 9")],
            ..Case::default()
        },
        "GW047" => Case {
            robot: &AT_THE_KNEE,
            design: &[("\"alpha-1\"\nratio = 9", "\"weak\"\nratio = 9")],
            ..Case::default()
        },
        "GW048" => Case {
            robot: &AT_THE_KNEE,
            design: &[("\"alpha-1\"\nratio = 9", "\"warm\"\nratio = 9")],
            ..Case::default()
        },
        "GW050" => robot(&[("\"21 N*m\"", "\"2 N*m\"")]),
        "GW051" => robot(&[("\"2000 N\"", "\"20 N\"")]),
        "GW052" => robot(&[("\"20 rad/s\"", "\"2 rad/s\"")]),
        "GW049" => {
            Case { robot: &AT_THE_KNEE, design: &[("\"alpha-1\"\nratio = 9", "\"low\"\nratio = 9")], ..Case::default() }
        }
        "GW042" => design(&[("ratio = 9", "gear = \"planetary-9\"")]),
        // Kept without the safety factor, but barely.
        "GW101" => Case {
            robot: &[("safety = 1.2", "safety = 1.0"), ("\"20 N*m\"", "\"3.6 N*m\""), ("\"12 N*m\"", "\"2 N*m\"")],
            ..Case::default()
        },
        "GW102" => robot(&[
            ("safety = 1.2", "safety = 1.0"),
            ("\"1 N*m\" }", "\"0.01 N*m\" }"),
            ("\"40 A\"", "\"4.5 A\""),
            ("\"30 A\"", "\"4.5 A\""),
        ]),
        "GW103" => motor(&[("continuous_current", "4.5")]),
        "GW104" => motor(&[("max_speed", "470")]),
        "GW105" => robot(&[("\"110 degC\"", "\"38 degC\"")]),
        "GW106" => robot(&[("\"48 V\"", "\"7.4 V\"")]),
        "GW107" => design(&[("ratio = 9", "ratio = 9\nload_inertia = \"0.1 kg*m^2\"")]),
        "GW108" => {
            robot(&[("\"1 N*m\" }", "\"22.5 N*m\" }"), ("safety = 1.2", "safety = 1.0"), ("\"40 A\"", "\"32 A\"")])
        }
        "GW109" => motor(&[("inductance", "2000")]),
        "GW110" => robot(&[("peak_torque = \"20 N*m\", ", "")]),
        "GW111" => robot(&[("max = 9.5", "max = 30")]),
        "GW201" => motor(&[("motor_constant", "0.5")]),
        "GW202" => motor(&[("source_kind", "secondary")]),
        "GW203" => motor(&[("torque_constant", "0.079")]),
        "GW204" => rules("[[rule]]\nrule = \"lock-missing\"\nseverity = \"error\"\nreason = \"released\"\n"),
        "GW301" => rules("[[allow]]\nrule = \"voltage\"\nreason = \"bench only\"\n"),
        "GW302" => rules("[[rule]]\nrule = \"voltage-headroom\"\nmin = 0.05\njoints = [\"kneee\"]\nreason = \"lab\"\n"),
        other => panic!("{other} has no design that breaks it: add one here"),
    }
}

#[test]
fn the_good_design_keeps_every_rule_that_it_can_be_judged_by() {
    checked(Case::default(), true, |report| {
        let found: Vec<&Finding> = report.findings.iter().collect();
        assert!(found.is_empty(), "{found:#?}");
        for (index, rule) in RULES.iter().enumerate() {
            let judged = report.judged.iter().any(|j| j.rule == index && j.skipped.is_none());
            // A supply without a resistance does not rise, and there is no module in it.
            let of_modules = ["GW046", "GW047", "GW048", "GW049"].contains(&rule.code);
            assert!(judged || of_modules || ["GW204", "GW036"].contains(&rule.code), "{rule:?} was not judged");
        }
    });
}

#[test]
fn every_rule_has_a_design_that_breaks_it() {
    let mut failures = Vec::new();
    for rule in RULES {
        let lock = rule.code == "GW203";
        let found = checked(breaking(rule.code), lock, codes);
        if !found.iter().any(|code| code == rule.code) {
            failures.push(format!("{rule:?}: only {found:?}"));
        }
        // A limit that the requirement sets is shown where the requirement asks for it.
        let case = breaking(rule.code);
        // Of a module its row asks.
        let of_module = case.robot == AT_THE_KNEE;
        if matches!(rule.test, gearwise::rules::Test::Limit(_)) && !case.robot.is_empty() && !of_module {
            let shown = checked(case, lock, |report| {
                let of = |f: &&Finding| report.rule_of(f).code == rule.code;
                report.findings.iter().filter(of).all(|f| f.asked.is_some())
            });
            if !shown {
                failures.push(format!("{rule:?}: rules/place.rs does not know where it is asked for"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn rules_and_measures_are_unique_and_documented() {
    let (mut codes, mut names) = (HashSet::new(), HashSet::new());
    let mut last = "";
    for rule in RULES {
        assert!(codes.insert(rule.code) && names.insert(rule.name), "{rule:?} stands twice");
        assert!(rule.code > last, "{rule:?} is not in order");
        last = rule.code;
        assert!(rule.code.len() == 5 && rule.code.starts_with("GW"), "{rule:?}");
        assert!(rule.name.chars().all(|c| c.is_ascii_lowercase() || c == '-'), "{rule:?}");
        for text in [rule.summary, rule.what, rule.why, rule.example, rule.fix] {
            assert!(text.len() >= 10, "{rule:?} lacks a text");
        }
        if let gearwise::rules::Test::Bounds { measures, .. } = &rule.test {
            for name in *measures {
                assert!(gearwise::rules::measure::measure(name).is_some(), "{rule:?} measures {name}");
            }
        }
    }
    let limits: Vec<&str> = gearwise::actuator::limits::LIMITS.iter().map(|l| l.name).collect();
    for limit in &limits {
        let of = RULES.iter().filter(|r| matches!(r.test, gearwise::rules::Test::Limit(l) if l == *limit));
        assert_eq!(of.count(), 1, "the limit {limit} has one rule");
    }
    let mut seen = HashSet::new();
    for measure in measures() {
        assert!(seen.insert(&measure.name) && !measure.meaning.is_empty(), "{} stands twice", measure.name);
    }
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .env_remove("COLUMNS")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn said(output: &Output) -> (Option<i32>, String, String) {
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn a_failing_design_as_its_user_reads_it() {
    let folder = tempfile::tempdir().unwrap();
    let rules = r#"
[[rule]]
name = "battery-life"
measure = "robot_loss"
max = "1 W"
severity = "warning"
reason = "the battery has to last an hour"

[[allow]]
rule = "reflected-inertia"
joints = ["knee"]
reason = "the foot is soft"
"#;
    let robot: Changes = &[("\"48 V\"", "\"6 V\""), ("\"0.02 kg*m^2\"", "\"0.001 kg*m^2\"")];
    write(
        folder.path(),
        Case { robot, rules, motor: &[("viscous_friction", ""), ("coulomb_friction", "")], ..Case::default() },
    );
    let output = run(folder.path(), &["check", "design.toml"]);
    let (status, stdout, stderr) = said(&output);
    assert_eq!(status, Some(1), "{stderr}");
    assert!(stderr.is_empty());
    insta::with_settings!({ snapshot_path => "../../snapshots/check", prepend_module_to_snapshot => false }, { insta::assert_snapshot!("failing_design", stdout) });
    let (status, stdout, _) = said(&run(folder.path(), &["check", "design.toml", "--github"]));
    assert_eq!(status, Some(1));
    insta::with_settings!({ snapshot_path => "../../snapshots/check", prepend_module_to_snapshot => false }, { insta::assert_snapshot!("failing_design_github", stdout) });
}

#[test]
fn warnings_alone_fail_only_where_strict() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), breaking("GW107"));
    assert_eq!(run(folder.path(), &["check", "design.toml"]).status.code(), Some(0));
    assert_eq!(run(folder.path(), &["check", "design.toml", "--strict"]).status.code(), Some(1));
}

/// Reports of every mistake, each with file, line and column.
#[test]
fn wrong_files_are_refused_with_their_place() {
    let own = "[[rule]]\nname = \"mine\"\nmeasure = \"loss\"\nmax = \"1 W\"\nreason = \"because\"\n";
    let cases: Vec<(&str, Changes, String)> = vec![
        ("unknown motor", &[("\"alpha-1\"", "\"alpa-1\"")], String::new()),
        ("joint missing", &[("[[joint]]\nname = \"hip\"\nmotor = \"alpha-1\"\nratio = 9\n", "")], String::new()),
        ("joint twice", &[("name = \"hip\"", "name = \"knee\"")], String::new()),
        ("joint unknown", &[("name = \"hip\"", "name = \"hips\"")], String::new()),
        ("gear and ratio", &[("ratio = 9", "ratio = 9\ngear = \"planetary-9\"")], String::new()),
        ("neither gear nor ratio", &[("ratio = 9\n", "")], String::new()),
        ("ratio outside", &[("ratio = 9", "ratio = 12")], String::new()),
        ("unknown gear", &[("ratio = 9", "gear = \"planetry-9\"")], String::new()),
        ("gear outside", &[("ratio = 9", "gear = \"planetary-40\"")], String::new()),
        ("motor and actuator", &[("ratio = 9", "ratio = 9\nactuator = \"fitted.toml\"")], String::new()),
        ("missing actuator", &[("motor = \"alpha-1\"", "actuator = \"fitted.toml\"")], String::new()),
        ("missing requirement", &[("\"robot.toml\"", "\"robt.toml\"")], String::new()),
        ("missing catalogue", &[("\"gears.csv\"", "\"gear.csv\"")], String::new()),
        ("broken toml", &[("ratio = 9", "ratio = = 9")], String::new()),
        ("unknown key", &[("ratio = 9", "ratoi = 9")], String::new()),
        (
            "spring without position",
            &[(
                "ratio = 9\n\n[[joint]]\nname = \"hip\"",
                "ratio = 9\n\n[[joint]]\nname = \"hip\"\nspring = { stiffness = \"1 N*m/rad\", rest_angle = \"0 rad\" }",
            )],
            String::new(),
        ),
        ("unknown rule", &[], "[[rule]]\nrule = \"voltage-hedroom\"\nmin = 0.2\nreason = \"x\"\n".into()),
        ("unknown rule of allow", &[], "[[allow]]\nrule = \"GW999\"\nreason = \"x\"\n".into()),
        ("unknown measure", &[], own.replace("\"loss\"", "\"losss\"")),
        ("min above max", &[], own.replace("max", "min = \"2 W\"\nmax")),
        ("bound without unit", &[], own.replace("\"1 W\"", "1")),
        ("bound of another unit", &[], own.replace("\"1 W\"", "\"1 A\"")),
        ("no bound", &[], own.replace("max = \"1 W\"\n", "")),
        ("no reason", &[], own.replace("reason = \"because\"\n", "")),
        ("name taken", &[], own.replace("\"mine\"", "\"voltage\"")),
        ("unknown severity", &[], own.replace("reason", "severity = \"eror\"\nreason")),
        ("unknown key of a rule", &[], own.replace("reason", "joint = [\"knee\"]\nreason")),
        ("limit switched off", &[], "[[rule]]\nrule = \"voltage\"\nseverity = \"off\"\nreason = \"x\"\n".into()),
        ("other bound", &[], "[[rule]]\nrule = \"inertia-ratio\"\nmin = 1\nreason = \"x\"\n".into()),
    ];
    for (name, design, rules) in cases {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), Case { design, rules: &rules, ..Case::default() });
        let (status, stdout, stderr) = said(&run(folder.path(), &["check", "design.toml"]));
        assert_eq!(status, Some(2), "{name}: {stdout}{stderr}");
        assert!(stdout.is_empty(), "{name}");
        let snapshot = name.replace(' ', "_");
        insta::with_settings!({ snapshot_path => "../../snapshots/check", prepend_module_to_snapshot => false, description => name, omit_expression => true }, {
            insta::assert_snapshot!(format!("mistake_{snapshot}"), stderr);
        });
    }
}

#[test]
fn a_design_without_the_spring_that_is_asked_for_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let row = |k: u32| {
        let angle = f64::from(k) / 20.0 * std::f64::consts::TAU;
        format!("{},{},{},{}\n", f64::from(k) / 20.0, angle.cos(), angle.sin(), angle.cos() * std::f64::consts::TAU)
    };
    let rows: String = (0..=20).map(row).collect();
    let head = "time [s],torque [N*m],position [rad],velocity [rad/s]\n";
    fs::write(folder.path().join("m.csv"), format!("{head}{rows}")).unwrap();
    let text = "name = \"x\"\n[bus]\nvoltage = \"48 V\"\n[[joint]]\nname = \"j\"\nratio = { min = 2, max = 20 }\nmotion = \"m.csv\"\nobjective = \"loss\"\n[joint.limits]\n";
    for (least, refused) in [(1, true), (0, false)] {
        let spring = format!(
            "spring = {{ stiffness = [\"{least} N*m/rad\", \"9 N*m/rad\"], rest_angle = [\"0 rad\", \"1 rad\"] }}\n"
        );
        fs::write(folder.path().join("robot.toml"), format!("{text}{spring}")).unwrap();
        let design = "requirement = \"robot.toml\"\n[[joint]]\nname = \"j\"\nmotor = \"t-motor-u8-lee\"\nratio = 9\n";
        fs::write(folder.path().join("design.toml"), design).unwrap();
        let (status, _, stderr) = said(&run(folder.path(), &["check", "design.toml"]));
        assert_eq!(status == Some(2), refused, "{stderr}");
        assert_eq!(
            stderr.contains("asks for a spring of 1 to 9 N*m/rad, and this design has none"),
            refused,
            "{stderr}"
        );
    }
}

#[test]
fn a_lock_catches_a_changed_row_and_says_what_changed() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), Case::default());
    let check = |more: &[&str]| said(&run(folder.path(), &[&["check", "design.toml"], more].concat()));
    assert_eq!(check(&[]).0, Some(0), "no lock is no mistake");
    assert!(!folder.path().join("design.lock").exists());
    let (status, _, stderr) = check(&["--lock"]);
    assert_eq!((status, stderr.as_str()), (Some(0), "wrote design.lock\n"));
    let first = fs::read_to_string(folder.path().join("design.lock")).unwrap();
    assert_eq!(check(&["--lock"]).0, Some(0));
    fs::write(folder.path().join("motors.csv"), motors(&[("torque_constant", "0.079")])).unwrap();
    let (status, stdout, _) = check(&["--lock"]);
    assert_eq!(status, Some(1));
    assert!(stdout.contains("torque_constant was 0.08 N*m/A, is 0.079 N*m/A"), "{stdout}");
    assert_eq!(fs::read_to_string(folder.path().join("design.lock")).unwrap(), first, "comparing writes nothing");
    assert_eq!(check(&["--update-lock"]).0, Some(0));
    assert_eq!(check(&[]).0, Some(0));
    // Changed by hand, and of another design.
    let spoilt = first.replace("0.08 N*m/A", "0.081 N*m/A");
    fs::write(folder.path().join("design.lock"), spoilt).unwrap();
    let (status, _, stderr) = check(&[]);
    assert!(status == Some(2) && stderr.contains("do not belong to this hash"), "{stderr}");
    fs::write(folder.path().join("design.lock"), first.replace("robot = \"leg\"", "robot = \"arm\"")).unwrap();
    let (status, _, stderr) = check(&[]);
    assert_eq!(status, Some(2));
    insta::with_settings!({ snapshot_path => "../../snapshots/check", prepend_module_to_snapshot => false }, { insta::assert_snapshot!("mistake_lock_of_another", stderr) });
}

/// Names that bite: in XML, in JSON, in workflow commands, in paths.
const BITING: &str = r#"a<b>&"c", 100%: é√"#;

fn biting(folder: &Path) {
    let name = format!("name = {}", toml_text(BITING));
    let robot = ROBOT.replace("name = \"knee\"", &name).replace("\"48 V\"", "\"5 V\"");
    let design = DESIGN.replace("name = \"knee\"", &name);
    write(
        folder,
        Case { motor: &[("source_kind", "secondary"), ("source", "two\nlines, <b>\"&\"")], ..Case::default() },
    );
    fs::write(folder.join("robot.toml"), robot).unwrap();
    fs::write(folder.join("design.toml"), design).unwrap();
    fs::write(
        folder.join("rules.toml"),
        "[[allow]]\nrule = \"torque-bandwidth-voltage\"\nreason = \"a <reason> & \\\"more\\\"\"\n",
    )
    .unwrap();
}

fn toml_text(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

#[test]
fn sarif_validates_and_points_at_the_place() {
    let schema = fs::read_to_string(common::repository("tests/fixtures/schemas/sarif-schema-2.1.0.json")).unwrap();
    // The published pattern of `language`, which no log of ours has, has a bracket too many and is no regular expression.
    let broken = "-[a-zA-Z]{2}]?$";
    assert!(schema.contains(broken));
    let schema: Value = serde_json::from_str(&schema.replace(broken, "-[a-zA-Z]{2}?$")).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("a folder");
    fs::create_dir(&inner).unwrap();
    biting(&inner);
    let sarif = |more: &[&str]| -> Value {
        run(folder.path(), &[&["check", "a folder/design.toml", "--sarif", "out.sarif"], more].concat());
        let text = fs::read_to_string(folder.path().join("out.sarif")).unwrap();
        let value: Value = serde_json::from_str(&text).unwrap();
        let errors: Vec<String> = validator.iter_errors(&value).map(|e| e.to_string()).collect();
        assert!(errors.is_empty(), "{errors:?}");
        value
    };
    let first = sarif(&[]);
    let results = first["runs"][0]["results"].as_array().unwrap();
    let voltage = results.iter().find(|r| r["ruleId"] == "GW008").expect("the voltage is exceeded");
    let place = &voltage["locations"][0]["physicalLocation"];
    assert_eq!(place["artifactLocation"]["uri"], "a%20folder/design.toml");
    // The ratio of the first joint: line 8, the nine behind `ratio = `.
    assert_eq!((&place["region"]["startLine"], &place["region"]["startColumn"]), (&Value::from(8), &Value::from(9)));
    let asked = &voltage["relatedLocations"][0]["physicalLocation"];
    assert_eq!(asked["artifactLocation"]["uri"], "a%20folder/robot.toml");
    assert_eq!(asked["region"]["startLine"], 4);
    assert!(voltage["message"]["text"].as_str().unwrap().starts_with(BITING));
    assert!(results.iter().any(|r| r["suppressions"][0]["status"] == "accepted"), "the exception is in the log");
    // Numbers and lines move, fingerprints do not.
    let prints = |value: &Value| -> BTreeMap<String, u32> {
        let mut prints = BTreeMap::new();
        for result in value["runs"][0]["results"].as_array().unwrap() {
            *prints.entry(result["partialFingerprints"]["gearwiseFinding/v1"].to_string()).or_default() += 1;
        }
        prints
    };
    let before = prints(&first);
    assert!(before.values().all(|n| *n == 1), "each finding has its own");
    let robot = fs::read_to_string(inner.join("robot.toml")).unwrap();
    fs::write(inner.join("robot.toml"), format!("# a line more\n{}", robot.replace("\"5 V\"", "\"4.9 V\""))).unwrap();
    let design = fs::read_to_string(inner.join("design.toml")).unwrap();
    fs::write(inner.join("design.toml"), format!("# a line more\n{design}")).unwrap();
    assert_eq!(prints(&sarif(&[])), before);
}

#[test]
fn junit_is_well_formed_and_complete() {
    let folder = tempfile::tempdir().unwrap();
    biting(folder.path());
    let (status, _, stderr) = said(&run(folder.path(), &["check", "design.toml", "--junit", "out.xml", "--strict"]));
    assert_eq!(status, Some(1), "{stderr}");
    let text = fs::read_to_string(folder.path().join("out.xml")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let root = document.root_element();
    assert_eq!(root.tag_name().name(), "testsuites");
    let elements = |node: roxmltree::Node, name: &str| node.descendants().filter(|n| n.has_tag_name(name)).count();
    let suites: Vec<_> = root.children().filter(|n| n.is_element()).collect();
    assert_eq!(suites.len(), 3, "two joints and the robot");
    assert_eq!(suites[0].attribute("name"), Some(format!("leg.{BITING}").as_str()));
    for suite in &suites {
        for (attribute, element) in [("tests", "testcase"), ("failures", "failure"), ("skipped", "skipped")] {
            assert_eq!(suite.attribute(attribute), Some(elements(*suite, element).to_string().as_str()), "{attribute}");
        }
        assert_eq!(suite.attribute("errors"), Some("0"));
        let cases = suite.children().filter(|n| n.is_element());
        cases.for_each(|case| assert!(case.attribute("name").is_some() && case.attribute("classname").is_some()));
    }
    let second_hand = root.descendants().filter_map(|n| n.text()).find(|t| t.contains("second hand")).unwrap();
    assert!(second_hand.contains("<b>\"&\""), "{second_hand}");
    assert!(elements(root, "failure") > 0);
}

#[test]
fn annotations_escape_what_commands_are_made_of() {
    let folder = tempfile::tempdir().unwrap();
    biting(folder.path());
    let (_, stdout, _) = said(&run(folder.path(), &["check", "design.toml", "--github"]));
    assert!(stdout.lines().all(|line| line.starts_with("::")), "{stdout}");
    assert!(stdout.contains("100%25: é√: `voltage` is exceeded"), "{stdout}");
    assert!(stdout.contains("::notice file=design.toml,line=7,"), "{stdout}");
    assert!(stdout.contains("two%0Alines"), "{stdout}");
}

#[test]
fn json_has_every_finding_with_its_numbers() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), breaking("GW008"));
    let (_, stdout, _) = said(&run(folder.path(), &["check", "design.toml", "--json"]));
    let value: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((&value["passes"], &value["robot"]["name"]), (&Value::from(false), &Value::from("leg")));
    let voltage = value["findings"].as_array().unwrap().iter().find(|f| f["code"] == "GW008").unwrap();
    assert!(voltage["value"].as_f64().unwrap() > voltage["bound"].as_f64().unwrap());
    approx::assert_relative_eq!(voltage["bound"].as_f64().unwrap(), 5.0 / 2.0_f64.sqrt(), max_relative = 1e-12);
    assert_eq!(voltage["unit"], "V");
}

/// The limits of `check` are those of `explain`: same numbers, not similar ones.
#[test]
fn margins_are_those_of_explain() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), Case::default());
    let (_, checked, _) = said(&run(folder.path(), &["check", "design.toml", "--json"]));
    let arguments = ["explain", "alpha-1@9", "robot.toml", "--joint", "knee", "--catalog", "motors.csv", "--json"];
    let (_, explained, stderr) = said(&run(folder.path(), &arguments));
    let (checked, explained): (Value, Value) = (
        serde_json::from_str(&checked).unwrap(),
        serde_json::from_str(&explained).unwrap_or_else(|e| panic!("{e}: {stderr}")),
    );
    let (checked, explained) = (&checked["joints"][0]["design"], &explained["joints"][0]["design"]);
    assert_eq!(checked["margins"], explained["margins"]);
    assert_eq!(checked["loss_w"], explained["loss_w"]);
    assert!(explained["margins"].as_object().unwrap().len() > 10);
}

#[test]
fn optimize_writes_a_design_that_passes_its_limits() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), Case::default());
    fs::create_dir(folder.path().join("designs")).unwrap();
    let arguments = ["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "designs/first.toml"];
    let (status, _, stderr) = said(&run(folder.path(), &arguments));
    assert_eq!(status, Some(0), "{stderr}");
    let (status, stdout, stderr) = said(&run(folder.path(), &["check", "designs/first.toml"]));
    assert_eq!(status, Some(0), "{stdout}{stderr}");
    // Where a joint has no motor nothing is written.
    fs::write(folder.path().join("robot.toml"), spoil(ROBOT, &[("\"0.6 kg\"", "\"0.1 kg\"")])).unwrap();
    let arguments = ["optimize", "robot.toml", "--catalog", "motors.csv", "--write-design", "designs/second.toml"];
    let (status, _, stderr) = said(&run(folder.path(), &arguments));
    assert_eq!(status, Some(1));
    assert_eq!(stderr, "no design written: no motor of the catalogue can do: knee\n");
    assert!(!folder.path().join("designs/second.toml").exists());
}

#[test]
fn rule_explains_and_finds_the_nearest() {
    let here = Path::new(".");
    let (status, stdout, _) = said(&run(here, &["rule", "gw106"]));
    assert_eq!(status, Some(0));
    insta::with_settings!({ snapshot_path => "../../snapshots/check", prepend_module_to_snapshot => false }, { insta::assert_snapshot!("rule", stdout) });
    let (_, list, _) = said(&run(here, &["rule"]));
    insta::with_settings!({ snapshot_path => "../../snapshots/check", prepend_module_to_snapshot => false }, { insta::assert_snapshot!("rule_list", list) });
    let (status, _, stderr) = said(&run(here, &["rule", "voltage-hedroom"]));
    assert_eq!(
        (status, stderr.as_str()),
        (Some(2), "error: there is no rule `voltage-hedroom`; did you mean `voltage-headroom`?\n")
    );
    assert!(said(&run(here, &["rule", "--measures"])).1.contains("robot_loss"));
}

#[test]
fn shipped_designs_pass() {
    for design in ["quadruped_mini_cheetah", "arm_six_axis_pick_and_place"] {
        let file = format!("requirements/designs/{design}/design.toml");
        let (status, stdout, stderr) = said(&run(&common::repository(""), &["check", &file, "--strict"]));
        assert_eq!(status, Some(0), "{stdout}{stderr}");
        // The line may be folded between its words.
        let words: Vec<&str> = stdout.split_whitespace().collect();
        assert!(words.join(" ").contains("rows as locked"), "{stdout}");
    }
}

#[test]
fn severity_words_read_back() {
    for (name, severity) in Severity::NAMES {
        assert_eq!(severity.name(), *name);
    }
}

/// A fitted actuator is the same machine whether a design names it by its file or among the catalogues: what it lacks is estimated.
#[test]
fn a_fitted_actuator_is_judged_alike_by_its_file_and_by_its_id() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "fitted.toml",
        "gearwise = \"0.1.0\"\n[motor]\nid = \"x-fitted\"\nconstruction = \"frameless\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\npole_pairs = 7\n\
         resistance = \"0.705 ohm\"\ntorque_constant = \"0.08 N*m/A\"\nrotor_inertia = \"9e-6 kg*m^2\"\nmass = \"0.193 kg\"\nouter_diameter = \"50 mm\"\n\
         length = \"16 mm\"\ncontinuous_current = \"6 A\"\nmax_winding_temperature = \"110 degC\"\n",
    );
    write(
        "robot.toml",
        "name = \"r\"\n[bus]\nvoltage = \"24 V\"\ndrive_current = \"20 A\"\n[[joint]]\nname = \"hip\"\nratio = { min = 4, max = 25 }\nobjective = \"mass\"\n\
         gear = { efficiency = 0.95, mass = \"150 g\", inertia = \"2e-6 kg*m^2\" }\npoints = [{ torque = \"3.5 N*m\", speed = \"4 rad/s\", duration = \"0.4 s\" }]\n",
    );
    let judged = |catalog: &str, named: &str| {
        let design = format!("requirement = \"robot.toml\"\n{catalog}[[joint]]\nname = \"hip\"\n{named} = 12\n");
        write("design.toml", &design);
        let output = run(folder.path(), &["check", "design.toml", "--json"]);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (report["joints"].clone(), report["errors"].clone(), report["warnings"].clone())
    };
    let by_file = judged("", "actuator = \"fitted.toml\"\nratio");
    assert!(by_file.0[0]["design"]["motor_drag_loss_w"].as_f64().unwrap() > 0.1, "{by_file:?}");
    assert_eq!(by_file, judged("catalog = [\"fitted.toml\"]\n", "motor = \"x-fitted\"\nratio"));
}

/// A finding on a value of `[set]` names the line of the design, not that of the requirement.
#[test]
fn a_finding_on_a_value_that_is_set_names_its_line_in_the_design() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), breaking("GW008"));
    let path = folder.path().join("design.toml");
    let asked = |design: &str| {
        fs::write(&path, design).unwrap();
        let output = run(folder.path(), &["check", "design.toml", "--json"]);
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let finding = report["findings"].as_array().unwrap().iter().find(|f| f["code"] == "GW017").cloned().unwrap();
        (finding["asked_for_at"]["file"].clone(), finding["asked_for_at"]["line"].clone())
    };
    let design = fs::read_to_string(&path).unwrap();
    let set = design.replacen("[[joint]]", "[set]\n\"bus.current\" = \"1 mA\"\n[[joint]]", 1);
    let line = set.lines().position(|line| line.contains("bus.current")).unwrap() + 1;
    assert_eq!(asked(&set), (Value::from("design.toml"), Value::from(line)));
}
