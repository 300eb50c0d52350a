//! What may not matter does not matter: the whole program, on files, with the same question asked in another way.
//!
//! No number here is right or wrong by itself. Units, the order of rows, joints, keys and columns, the winding of a
//! motor, the size of a robot: each is changed in the input, and the answer must be the one before, or follow by a law.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;
use toml::Value as Toml;

use crate::common::run::gearwise_in;

/// Motors of the shipped catalogue that differ in convention, in what is known of them, and in size.
const MOTORS: [&str; 14] = [
    "tq-robodrive-ilm-85x26",
    "maxon-ec-i-40-496661",
    "faulhaber-3890h048cr",
    "maxon-ec-60-flat-625858",
    "maxon-ec-i-52-606793",
    "t-motor-ri50",
    "t-motor-u8-lee",
    "t-motor-g40-kv210",
    "maxon-ec-frameless-ht-76-m-934928",
    "maxon-ec-i-40-496660",
    "allied-ht03000-a00",
    "tq-robodrive-ilm-25x08",
    "mjbots-mj5208",
    "faulhaber-3242g048bx4",
];

/// A CSV file: its header and its rows. Comments are left out.
#[derive(Debug, Clone, PartialEq)]
struct Sheet {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Sheet {
    fn parse(text: &str) -> Sheet {
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
        let row = |r: &csv::StringRecord| r.iter().map(String::from).collect::<Vec<_>>();
        let header = row(reader.headers().unwrap());
        Sheet { header, rows: reader.records().map(|r| row(&r.unwrap())).collect() }
    }

    fn text(&self) -> String {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.header).unwrap();
        self.rows.iter().for_each(|r| writer.write_record(r).unwrap());
        String::from_utf8(writer.into_inner().unwrap()).unwrap()
    }

    fn column(&self, name: &str) -> usize {
        let is = |h: &String| h.split(" [").next() == Some(name);
        self.header.iter().position(is).unwrap_or_else(|| panic!("{name} of {:?}", self.header))
    }

    /// Every number of a column as a function of what it was.
    fn map(&mut self, column: usize, change: impl Fn(f64) -> f64) {
        for cell in self.rows.iter_mut().map(|r| &mut r[column]).filter(|c| !c.is_empty()) {
            *cell = change(cell.parse().unwrap()).to_string();
        }
    }

    /// Columns by their names times a factor.
    fn times(&mut self, names: &[&str], factor: f64) {
        for name in names {
            self.map(self.column(name), |x| x * factor);
        }
    }

    fn numbers(&self, name: &str) -> Vec<f64> {
        let column = self.column(name);
        self.rows.iter().map(|r| r[column].parse().unwrap()).collect()
    }

    /// Columns in the reverse order.
    fn columns_reversed(&self) -> Sheet {
        let reverse = |v: &Vec<String>| v.iter().rev().cloned().collect();
        Sheet { header: reverse(&self.header), rows: self.rows.iter().map(reverse).collect() }
    }

    /// Adds the rows of a sheet, and its columns that this one does not have.
    fn add(&mut self, other: Sheet) {
        let new = other.header.iter().filter(|column| !self.header.contains(column));
        self.header.extend(new.cloned().collect::<Vec<String>>());
        self.rows.iter_mut().for_each(|row| row.resize(self.header.len(), String::new()));
        let place = |column: &String| other.header.iter().position(|own| own == column);
        let places: Vec<Option<usize>> = self.header.iter().map(place).collect();
        let cell = |row: &[String], k: &Option<usize>| k.map_or_else(String::new, |k| row[k].clone());
        self.rows.extend(other.rows.iter().map(|row| places.iter().map(|k| cell(row, k)).collect::<Vec<String>>()));
    }
}

/// A requirement with all that it names, in memory.
#[derive(Debug, Clone)]
struct World {
    robot: toml::Table,
    motions: BTreeMap<String, Sheet>,
    motors: Sheet,
    gears: Sheet,
}

fn repository(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn read(path: impl AsRef<Path>) -> String {
    fs::read_to_string(path).unwrap()
}

/// The shipped rows of the motors above.
fn motors() -> Sheet {
    let mut all: Option<Sheet> = None;
    let mut files: Vec<_> = fs::read_dir(repository("catalogs/motors")).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    for file in files.iter().filter(|f| f.extension().is_some_and(|e| e == "csv")) {
        let sheet = Sheet::parse(&read(file));
        match &mut all {
            None => all = Some(sheet),
            Some(all) => all.add(sheet),
        }
    }
    let mut all = all.unwrap();
    all.rows.retain(|r| MOTORS.contains(&r[0].as_str()));
    assert_eq!(all.rows.len(), MOTORS.len());
    all
}

/// Some of the shipped gears of two kinds.
fn gears() -> Sheet {
    let of = |file: &str| Sheet::parse(&read(repository("catalogs/gears").join(file)));
    let (planetary, mut all) = (of("qdd.csv"), of("harmonic-drive.csv"));
    all.rows.truncate(8);
    all.add(Sheet { rows: planetary.rows.into_iter().take(8).collect(), ..planetary });
    all
}

impl World {
    fn shipped(name: &str) -> World {
        let robot: toml::Table = read(repository(&format!("requirements/{name}.toml"))).parse().unwrap();
        let mut motions = BTreeMap::new();
        for file in joints(&robot).iter().filter_map(|j| j.get("motion")?.as_str()) {
            motions.insert(file.to_string(), Sheet::parse(&read(repository("requirements").join(file))));
        }
        World { robot, motions, motors: motors(), gears: gears() }
    }

    fn write(&self) -> TempDir {
        let folder = tempfile::tempdir().unwrap();
        let at = folder.path();
        fs::create_dir(at.join("motions")).unwrap();
        fs::write(at.join("robot.toml"), toml::to_string(&self.robot).unwrap()).unwrap();
        fs::write(at.join("motors.csv"), self.motors.text()).unwrap();
        fs::write(at.join("gears.csv"), self.gears.text()).unwrap();
        for (file, motion) in &self.motions {
            fs::write(at.join(file), motion.text()).unwrap();
        }
        folder
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let folder = self.write();
        let mut all = arguments.to_vec();
        all.extend(["--catalog", "motors.csv", "gears.csv"]);
        gearwise_in(folder.path(), &all)
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.run(arguments);
        assert!(output.status.code() < Some(2), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    fn optimize(&self) -> Value {
        self.json(&["optimize", "robot.toml", "--no-estimates", "--json"])
    }

    /// A value of the requirement by its path, for every joint where the path begins with `joint`.
    fn change(&mut self, path: &str, change: &dyn Fn(&str) -> String) -> usize {
        fn at(value: &mut Toml, path: &[&str], change: &dyn Fn(&str) -> String) -> usize {
            match (value, path) {
                (Toml::String(text), []) => {
                    *text = change(text);
                    1
                }
                (Toml::Float(number), []) => {
                    *number = change(&number.to_string()).parse().unwrap();
                    1
                }
                (Toml::Integer(number), []) => {
                    *number = change(&number.to_string()).parse().unwrap();
                    1
                }
                (Toml::Table(table), [first, rest @ ..]) => {
                    table.get_mut(*first).map_or(0, |inner| at(inner, rest, change))
                }
                (Toml::Array(items), path) => items.iter_mut().map(|item| at(item, path, change)).sum(),
                _ => 0,
            }
        }
        let path: Vec<&str> = path.split('.').collect();
        self.robot.get_mut(path[0]).map_or(0, |value| at(value, &path[1..], change))
    }
}

fn joints(robot: &toml::Table) -> &Vec<Toml> {
    robot["joint"].as_array().unwrap()
}

/// `"24 V"` times a factor.
fn scaled(text: &str, factor: f64) -> String {
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    format!("{} {unit}", number.parse::<f64>().unwrap() * factor).trim().to_string()
}

/// Lists of things that have names, as maps, so that their order does not matter.
fn by_name(value: &Value) -> Value {
    let name = |v: &Value| {
        let part = |key: &str| v.get(key).and_then(Value::as_str).map(String::from);
        let named = part("joint").or_else(|| part("motor")).or_else(|| part("limit")).or_else(|| part("metric"));
        Some(format!("{} {}", named?, part("gear").unwrap_or_default()))
    };
    match value {
        Value::Array(items) => {
            let names: Option<Vec<String>> = items.iter().map(name).collect();
            let inner: Vec<Value> = items.iter().map(by_name).collect();
            match names {
                Some(names) if names.iter().collect::<BTreeSet<_>>().len() == items.len() => {
                    Value::Object(names.into_iter().zip(inner).collect())
                }
                _ => Value::Array(inner),
            }
        }
        Value::Object(map) => map.iter().map(|(k, v)| (k.clone(), by_name(v))).collect(),
        other => other.clone(),
    }
}

/// Numbers that are differences of larger ones, told in a unit of their own: what is one to them is not themselves.
const OF_ONE: [&str; 4] = ["gap", "standard_errors", "error_falls_percent", "at_most_percent"];

/// Where two results differ. Numbers may be apart by a relative `tolerance`; what is rounding of one (a gap, a price of
/// zero) by `tolerance` itself.
fn differences(a: &Value, b: &Value, tolerance: f64) -> Vec<String> {
    fn walk(path: &str, a: &Value, b: &Value, tolerance: f64, found: &mut Vec<String>) {
        match (a, b) {
            (Value::Object(x), Value::Object(y)) => {
                let keys: BTreeSet<&String> = x.keys().chain(y.keys()).collect();
                for key in keys {
                    let (x, y) = (x.get(key).unwrap_or(&Value::Null), y.get(key).unwrap_or(&Value::Null));
                    walk(&format!("{path}/{key}"), x, y, tolerance, found);
                }
            }
            (Value::Array(x), Value::Array(y)) if x.len() == y.len() => {
                for (k, (x, y)) in x.iter().zip(y).enumerate() {
                    walk(&format!("{path}/{k}"), x, y, tolerance, found);
                }
            }
            (Value::Number(x), Value::Number(y)) => {
                let (x, y) = (x.as_f64().unwrap(), y.as_f64().unwrap());
                let of_one = OF_ONE.iter().any(|name| path.ends_with(&format!("/{name}")));
                let size = x.abs().max(y.abs()).max(if of_one { 1.0 } else { 0.0 });
                if (x - y).abs() > tolerance * size + 1e-12 {
                    found.push(format!("{path}: {x:e} against {y:e}, {:e}", (x - y).abs() / size));
                }
            }
            _ if a == b => {}
            _ => found.push(format!("{path}: {a} against {b}")),
        }
    }
    let mut found = Vec::new();
    walk("", a, b, tolerance, &mut found);
    found
}

#[track_caller]
fn same(a: &Value, b: &Value, tolerance: f64, what: &str) {
    let found = differences(&by_name(a), &by_name(b), tolerance);
    assert!(found.is_empty(), "{what}: {} differences\n{}", found.len(), found[..found.len().min(12)].join("\n"));
}

/// Units that measure the same, with how many of each are one of the first. Typed from their definitions (inch
/// 25.4 mm, pound 0.45359237 kg, standard gravity 9.80665 m/s²), not taken from the program.
const GRAVITY: f64 = 9.806_65;
const POUND: f64 = 0.453_592_37;
const INCH: f64 = 0.0254;
const TAU: f64 = std::f64::consts::TAU;
#[rustfmt::skip]
const UNITS: &[(&str, &[(&str, f64)])] = &[
    ("N*m", &[("mN*m", 1e3), ("ozf*in", 16.0 / (POUND * GRAVITY * INCH)), ("kgf*cm", 100.0 / GRAVITY), ("lbf*ft", 1.0 / (POUND * GRAVITY * 0.3048))]),
    ("N*m/s", &[("mN*m/s", 1e3), ("N*m/min", 60.0)]),
    ("rad/s", &[("rpm", 60.0 / TAU), ("deg/s", 360.0 / TAU), ("rev/min", 60.0 / TAU), ("mrad/ms", 1.0)]),
    ("rad/s^2", &[("deg/s^2", 360.0 / TAU), ("rpm/s", 60.0 / TAU)]),
    ("rad", &[("deg", 360.0 / TAU), ("rev", 1.0 / TAU), ("arcmin", 21600.0 / TAU)]),
    ("rpm", &[("rad/s", TAU / 60.0), ("deg/s", 6.0)]),
    ("kg", &[("g", 1e3), ("lb", 1.0 / POUND), ("oz", 16.0 / POUND)]),
    ("g", &[("kg", 1e-3), ("oz", 0.016 / POUND), ("mg", 1e3)]),
    ("kg*m^2", &[("g*cm^2", 1e7), ("kg*mm^2", 1e6), ("lb*in^2", 1.0 / (POUND * INCH * INCH))]),
    ("g*cm^2", &[("kg*m^2", 1e-7), ("oz*in^2", 1.6e-6 / (POUND * INCH * INCH)), ("kg*cm^2", 1e-3)]),
    ("h", &[("min", 60.0), ("s", 3600.0)]),
    ("s", &[("ms", 1e3), ("min", 1.0 / 60.0), ("us", 1e6)]),
    ("ms", &[("s", 1e-3), ("us", 1e3)]),
    ("V", &[("mV", 1e3), ("kV", 1e-3), ("W/A", 1.0)]),
    ("A", &[("mA", 1e3), ("kA", 1e-3), ("W/V", 1.0)]),
    ("W", &[("mW", 1e3), ("kW", 1e-3), ("N*m/s", 1.0)]),
    ("Hz", &[("kHz", 1e-3), ("1/min", 60.0), ("rad/s", TAU)]),
    ("ohm", &[("mohm", 1e3), ("kΩ", 1e-3), ("V/A", 1.0)]),
    ("mH", &[("uH", 1e3), ("H", 1e-3), ("mV*s/A", 1.0)]),
    ("mm", &[("m", 1e-3), ("in", 1e-3 / INCH), ("cm", 0.1)]),
    ("K/W", &[("K/kW", 1e3), ("K/mW", 1e-3)]),
    ("N*m/A", &[("mN*m/A", 1e3), ("ozf*in/A", 16.0 / (POUND * GRAVITY * INCH)), ("mV*s/rad", 1e3)]),
    ("V*s/rad", &[("mV*s/rad", 1e3), ("V/rpm", TAU / 60.0), ("mV/rpm", 1e3 * TAU / 60.0)]),
    ("rpm/V", &[("rad/(V*s)", TAU / 60.0), ("rpm/mV", 1e-3)]),
    ("N*m/W^0.5", &[("mN*m/sqrt(W)", 1e3), ("N*m/kW^0.5", 31.622_776_601_683_793)]),
    ("N*m*s/rad", &[("mN*m*s/rad", 1e3), ("N*m/rpm", TAU / 60.0)]),
    ("N*m/rad", &[("mN*m/rad", 1e3), ("N*m/deg", TAU / 360.0)]),
    ("arcmin", &[("rad", TAU / 21600.0), ("deg", 1.0 / 60.0)]),
    ("N*m/kg", &[("N*m/g", 1e-3), ("mN*m/kg", 1e3)]),
    ("1", &[("%", 100.0)]),
];

/// A quantity in the unit number `pick` that measures the same.
fn another(number: f64, unit: &str, pick: usize) -> (f64, String) {
    if unit == "degC" {
        return (number + 273.15, "K".into());
    }
    let (_, others) = UNITS.iter().find(|(u, _)| *u == unit).unwrap_or_else(|| panic!("no other unit for {unit}"));
    let (other, factor) = others[pick % others.len()];
    (number * factor, other.into())
}

fn sheet_in_other_units(sheet: &mut Sheet, pick: usize) {
    for k in 0..sheet.header.len() {
        let head = sheet.header[k].clone();
        let Some((name, unit)) = head.split_once(" [") else { continue };
        let unit = unit.trim_end_matches(']');
        if unit == "%" {
            continue;
        }
        // A difference of temperatures is one in K as in degC, but no column of these is one.
        let new = another(0.0, unit, pick + k).1;
        sheet.map(k, |x| another(x, unit, pick + k).0);
        sheet.header[k] = format!("{name} [{new}]");
    }
}

fn toml_in_other_units(value: &mut Toml, pick: usize) {
    match value {
        Toml::String(text) => {
            let Some((number, unit)) = text.split_once(' ') else { return };
            let Ok(number) = number.parse::<f64>() else { return };
            let (number, unit) = another(number, unit, pick);
            *text = format!("{number} {unit}");
        }
        Toml::Array(items) => items.iter_mut().enumerate().for_each(|(k, v)| toml_in_other_units(v, pick + k)),
        Toml::Table(table) => table.iter_mut().enumerate().for_each(|(k, (_, v))| toml_in_other_units(v, pick + k)),
        _ => {}
    }
}

fn in_other_units(world: &World, pick: usize) -> World {
    let mut other = world.clone();
    for (_, value) in other.robot.iter_mut() {
        toml_in_other_units(value, pick);
    }
    other.motions.values_mut().for_each(|sheet| sheet_in_other_units(sheet, pick));
    sheet_in_other_units(&mut other.motors, pick);
    sheet_in_other_units(&mut other.gears, pick);
    other
}

/// What a ratio that lies in a valley decides is known to the root of rounding only; what a limit decides, and the
/// objective, to rounding. Both are compared, each with its own measure.
fn chosen(result: &Value) -> (Value, Value) {
    let mut exact = Vec::new();
    for joint in result["joints"].as_array().unwrap() {
        for c in joint["candidates"].as_array().unwrap() {
            let parts =
                ["motor", "gear", "objective", "window", "windows", "binds", "not_checked", "mass_kg", "metrics"];
            let mut kept: serde_json::Map<String, Value> =
                parts.iter().map(|p| (p.to_string(), c[*p].clone())).collect();
            kept.insert("joint".into(), format!("{} {} {}", joint["joint"], c["motor"], c["gear"]).into());
            kept.insert("certified".into(), c["certificate"]["certified"].clone());
            exact.push(Value::Object(kept));
        }
        let order: Vec<Value> = joint["candidates"].as_array().unwrap().iter().map(|c| c["motor"].clone()).collect();
        exact
            .push(serde_json::json!({"joint": joint["joint"], "order": order, "agreement": joint["metric_agreement"]}));
    }
    (Value::Array(exact), result.clone())
}

#[track_caller]
fn same_choice(a: &Value, b: &Value, what: &str) {
    let ((exact_a, all_a), (exact_b, all_b)) = (chosen(a), chosen(b));
    same(&exact_a, &exact_b, 1e-9, what);
    same(&all_a, &all_b, 1e-6, what);
}

#[test]
fn units_change_nothing() {
    for name in ["exoskeleton_hip", "leg_prosthesis_walking", "quadruped_mini_cheetah", "humanoid_hip_catalog_gears"] {
        let world = World::shipped(name);
        let before = world.optimize();
        for pick in 0..3 {
            let other = in_other_units(&world, pick);
            assert_ne!(toml::to_string(&other.robot), toml::to_string(&world.robot));
            same_choice(&before, &other.optimize(), &format!("{name}, units {pick}"));
        }
    }
    let world = World::shipped("exoskeleton_hip");
    for command in
        [["sweep", "robot.toml", "--json", "--ratios=7"], ["explain", "t-motor-ri50@20", "robot.toml", "--json"]]
    {
        let before = world.json(&command);
        same(&before, &in_other_units(&world, 1).json(&command), 1e-9, &format!("{command:?}"));
    }
}

#[test]
fn the_order_of_rows_joints_keys_and_columns_changes_nothing() {
    for name in ["quadruped_mini_cheetah", "leg_prosthesis_walking", "humanoid_hip_catalog_gears"] {
        let world = World::shipped(name);
        let before = world.optimize();
        let mut other = world.clone();
        other.motors = other.motors.columns_reversed();
        other.motors.rows.reverse();
        other.gears = other.gears.columns_reversed();
        other.gears.rows.rotate_left(3);
        other.motions.values_mut().for_each(|m| *m = m.columns_reversed());
        let Some(Toml::Array(joints)) = other.robot.get_mut("joint") else { panic!() };
        joints.reverse();
        let after = other.optimize();
        // Not one bit: nothing is computed in another order.
        same(&before, &after, 0.0, name);
        let order = |r: &Value| r["joints"].as_array().unwrap().iter().map(|j| j["joint"].clone()).collect::<Vec<_>>();
        assert_eq!(order(&before), order(&after).into_iter().rev().collect::<Vec<_>>(), "joints in the user's order");
        // Keys: the file as it is shipped against its tables written in the order of the alphabet.
        let folder = world.write();
        let shipped = read(repository(&format!("requirements/{name}.toml")));
        assert_ne!(shipped, read(folder.path().join("robot.toml")));
        fs::write(folder.path().join("robot.toml"), shipped).unwrap();
        let arguments = ["optimize", "robot.toml", "--json", "--no-estimates", "--catalog", "motors.csv", "gears.csv"];
        let output = gearwise_in(folder.path(), &arguments);
        let shipped: Value = serde_json::from_slice(&output.stdout).unwrap();
        same(&before, &shipped, 0.0, name);
    }
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let mut world = World::shipped("quadruped_mini_cheetah");
    let budget: toml::Table = "actuator_mass = \"6 kg\"\nmax_distinct_motors = 2\npower = \"900 W\"".parse().unwrap();
    world.robot.insert("budget".into(), Toml::Table(budget));
    let folder = world.write();
    let design = ["optimize", "robot.toml", "--catalog", "motors.csv", "gears.csv", "--write-design", "design.toml"];
    assert!(gearwise_in(folder.path(), &design).status.code() < Some(2));
    let catalog = ["--catalog", "motors.csv", "gears.csv"];
    let robot = repository("requirements/robots");
    let (ur5e, pick) = (robot.join("ur5e.urdf"), robot.join("ur5e_pick.csv"));
    let bench = repository("requirements/bench/motor_on_bench.toml");
    let with = |more: &[&str]| [more, &catalog].concat().iter().map(|a| a.to_string()).collect::<Vec<_>>();
    let commands = [
        with(&["optimize", "robot.toml", "--json"]),
        with(&["optimize", "robot.toml", "--robust", "--json"]),
        with(&["optimize", "robot.toml", "--only-top", "2", "--csv"]),
        with(&["optimize", "robot.toml", "--pareto", "loss,reflected_inertia", "--json"]),
        with(&["explain", "t-motor-u8-lee", "robot.toml", "--joint", "knee", "--json"]),
        vec!["rank", "motors.csv", "--tolerance", "5%", "--json"].into_iter().map(String::from).collect(),
        vec!["audit", "motors.csv", "--json"].into_iter().map(String::from).collect(),
        vec!["check", "design.toml", "--json"].into_iter().map(String::from).collect(),
        vec!["export", "design.toml", "--to", "mjcf"].into_iter().map(String::from).collect(),
        vec!["torques".into(), ur5e.display().to_string(), pick.display().to_string(), "--json".into()],
        vec!["characterize".into(), bench.display().to_string(), "--json".into()],
    ];
    for command in commands {
        let run = |threads: &str| {
            let mut arguments: Vec<&str> = command.iter().map(String::as_str).collect();
            arguments.extend(["--threads", threads]);
            let output = gearwise_in(folder.path(), &arguments);
            assert!(output.status.code() < Some(2), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
            output.stdout
        };
        let one = run("1");
        assert!(one.len() > 100, "{command:?}");
        for threads in ["2", "8"] {
            assert!(run(threads) == one, "{command:?} with {threads} threads");
        }
    }
}

/// A motion with its period written down twice is the same motion; the spline sees the same neighbours.
#[test]
fn a_period_written_down_twice_changes_nothing() {
    for name in ["exoskeleton_hip", "leg_prosthesis_walking"] {
        let world = World::shipped(name);
        let mut other = world.clone();
        for motion in other.motions.values_mut() {
            let time = motion.column("time");
            let times = motion.numbers("time");
            let period = times[times.len() - 1] - times[0];
            let mut again = motion.rows[1..].to_vec();
            for row in &mut again {
                row[time] = (row[time].parse::<f64>().unwrap() + period).to_string();
            }
            motion.rows.extend(again);
        }
        // Energy and the samples' names are of the whole motion as it is written.
        let described = |r: &Value| {
            let mut found = Vec::new();
            for joint in r["joints"].as_array().unwrap() {
                for c in joint["candidates"].as_array().unwrap() {
                    let keep =
                        ["loss_w", "window", "objective", "margins", "peak_current_q_a", "mean_electrical_power_w"];
                    let kept: serde_json::Map<_, _> = keep.iter().map(|k| (k.to_string(), c[*k].clone())).collect();
                    found.push(serde_json::json!([joint["joint"], c["motor"], c["binds"], kept]));
                }
            }
            Value::Array(found)
        };
        let (before, after) = (described(&world.optimize()), described(&other.optimize()));
        assert!(before.as_array().unwrap().len() > 2);
        same(&before, &after, 1e-6, name);
    }
}

/// The heat of a ramp: trapezoids see the mean of a square with an error that falls with the square of the step,
/// peaks with none. Four times as fine is sixteen times as near.
#[test]
fn refining_time_leaves_peaks_and_brings_means_to_their_limit() {
    let mut world = World::shipped("exoskeleton_hip");
    let ramp = |steps: u32| {
        let mut text =
            "time [s],torque [N*m],velocity [rad/s],acceleration [rad/s^2],torque_rate [N*m/s]\n".to_string();
        for k in 0..=steps {
            let t = f64::from(k) / f64::from(steps);
            text.push_str(&format!("{t},{},{},3,12\n", -2.0 + 12.0 * t, 1.0 + 3.0 * t));
        }
        Sheet::parse(&text)
    };
    let Some(Toml::Array(joints)) = world.robot.get_mut("joint") else { panic!() };
    joints[0].as_table_mut().unwrap().insert("periodic".into(), false.into());
    let file = world.motions.keys().next().unwrap().clone();
    let mut at = |steps: u32| {
        world.motions.insert(file.clone(), ramp(steps));
        let told = world.json(&["explain", "t-motor-ri50@20", "robot.toml", "--json"]);
        let first = world.optimize()["joints"][0]["candidates"][0]["motor"].clone();
        let text = told.to_string();
        let number = |key: &str| {
            let from = text.find(&format!("\"{key}\":")).unwrap_or_else(|| panic!("{key} of {text}")) + key.len() + 3;
            text[from..].split([',', '}']).next().unwrap().parse::<f64>().unwrap()
        };
        (number("loss_w"), number("peak_current_q_a"), first)
    };
    let (coarse, fine, finest) = (at(6), at(24), at(96));
    assert!((coarse.1 / finest.1 - 1.0).abs() < 1e-12 && coarse.2 == finest.2 && fine.2 == finest.2);
    let (first, second) = (coarse.0 - fine.0, fine.0 - finest.0);
    assert!(first > 0.0 && (first / second - 16.0).abs() < 0.2, "{first} {second}");
}

/// The same copper in `turns` times as many turns: K × a, R and L × a², currents ÷ a, on a bus of a times the voltage.
#[test]
fn rewinding_every_motor_changes_no_choice() {
    for (name, turns) in
        [("exoskeleton_hip", 2.0), ("leg_prosthesis_walking", 0.5), ("humanoid_hip_catalog_gears", 4.0)]
    {
        let world = World::shipped(name);
        let mut other = world.clone();
        let m = &mut other.motors;
        m.times(&["torque_constant", "torque_constant_tolerance", "back_emf_constant", "voltage"], turns);
        m.times(&["back_emf_constant_tolerance"], turns);
        m.times(&["resistance", "resistance_tolerance", "inductance", "inductance_tolerance"], turns * turns);
        m.times(&["speed_constant", "continuous_current", "peak_current", "no_load_current"], 1.0 / turns);
        assert!(other.change("bus.voltage", &|v| scaled(v, turns)) == 1);
        assert!(other.change("bus.drive_current", &|v| scaled(v, 1.0 / turns)) == 1);
        let described = |r: &Value, turns: f64| {
            let mut found = Vec::new();
            for joint in r["joints"].as_array().unwrap() {
                let rejected: Vec<_> =
                    joint["rejected"].as_array().unwrap().iter().map(|r| r["motor"].clone()).collect();
                found.push(serde_json::json!([joint["joint"], rejected]));
                for c in joint["candidates"].as_array().unwrap() {
                    let current = c["peak_current_q_a"].as_f64().unwrap() * turns;
                    let keep = ["loss_w", "window", "ratio", "margins", "binds", "mass_kg", "reflected_inertia_kgm2"];
                    let kept: serde_json::Map<_, _> = keep.iter().map(|k| (k.to_string(), c[*k].clone())).collect();
                    found.push(serde_json::json!([c["motor"], c["gear"], kept, current]));
                }
            }
            Value::Array(found)
        };
        let (before, after) = (described(&world.optimize(), 1.0), described(&other.optimize(), turns));
        assert!(before.as_array().unwrap().len() > 3);
        // Powers of two: no rounding but that of the solver.
        same(&before, &after, 1e-6, name);
    }
}

/// A robot whose every torque is s times as large, with motors of c times the constants: forces, inertias and powers
/// are s times as large, and nothing else.
#[test]
fn a_stronger_robot_with_stronger_motors_chooses_the_same() {
    let (s, c) = (4.0, 2.0);
    for name in ["exoskeleton_hip", "leg_prosthesis_walking"] {
        let world = World::shipped(name);
        let mut other = world.clone();
        let m = &mut other.motors;
        m.times(&["torque_constant", "back_emf_constant", "voltage"], c);
        m.times(&["torque_constant_tolerance", "back_emf_constant_tolerance"], c);
        m.times(&["resistance", "resistance_tolerance", "inductance", "inductance_tolerance"], c * c / s);
        m.times(&["speed_constant"], 1.0 / c);
        m.times(&["motor_constant"], s.sqrt());
        m.times(&["continuous_current", "peak_current", "no_load_current"], s / c);
        let torques = ["rotor_inertia", "rotor_inertia_tolerance", "continuous_torque", "peak_torque", "stall_torque"];
        m.times(&torques, s);
        m.times(&["coulomb_friction", "viscous_friction"], s);
        m.times(&["thermal_resistance_winding_housing", "thermal_resistance_housing_ambient"], 1.0 / s);
        other.motions.values_mut().for_each(|motion| motion.times(&["torque"], s));
        for (path, factor) in [
            ("bus.voltage", c),
            ("bus.drive_current", s / c),
            ("joint.gear.inertia", s),
            ("joint.gear.peak_torque", s),
            ("joint.limits.reflected_inertia", s),
            ("joint.limits.torque_bandwidth.amplitude", s),
            ("joint.reference.loss", s),
            ("joint.reference.reflected_inertia", s),
        ] {
            other.change(path, &|v| scaled(v, factor));
        }
        let described = |r: &Value, s: f64| {
            let mut found = Vec::new();
            for joint in r["joints"].as_array().unwrap() {
                for c in joint["candidates"].as_array().unwrap() {
                    let loss = c["loss_w"].as_f64().unwrap() / s;
                    let keep = ["window", "ratio", "margins", "binds", "mass_kg"];
                    let kept: serde_json::Map<_, _> = keep.iter().map(|k| (k.to_string(), c[*k].clone())).collect();
                    found.push(serde_json::json!([joint["joint"], c["motor"], kept, loss]));
                }
            }
            Value::Array(found)
        };
        let (before, after) = (described(&world.optimize(), 1.0), described(&other.optimize(), s));
        assert!(before.as_array().unwrap().len() > 2);
        same(&before, &after, 1e-6, name);
    }
}

/// The candidates of each joint, without how well metrics order them all.
fn candidates(result: &Value, without: &str) -> Value {
    let mut found = Vec::new();
    for joint in result["joints"].as_array().unwrap() {
        let list =
            |key: &str| joint[key].as_array().unwrap().iter().filter(|c| c["motor"] != without).cloned().collect();
        let order: Vec<Value> = list("candidates");
        let rejected: Vec<Value> = list("rejected");
        let names: Vec<&Value> = order.iter().map(|c| &c["motor"]).collect();
        found.push(
            serde_json::json!({"joint": joint["joint"], "names": names, "candidates": order, "rejected": rejected}),
        );
    }
    Value::Array(found)
}

#[test]
fn a_motor_that_is_worse_in_everything_changes_nothing() {
    for name in ["exoskeleton_hip", "quadruped_mini_cheetah", "leg_prosthesis_walking"] {
        let world = World::shipped(name);
        let before = world.optimize();
        let best = before["joints"][0]["candidates"][0]["motor"].as_str().unwrap().to_string();
        let mut other = world.clone();
        let mut only = Sheet { header: other.motors.header.clone(), rows: vec![] };
        only.rows.push(other.motors.rows.iter().find(|r| r[0] == best).unwrap().clone());
        only.times(&["resistance", "rotor_inertia", "mass"], 1.1);
        only.times(&["continuous_current", "peak_current", "continuous_torque", "peak_torque"], 0.9);
        only.rows[0][0] = "worse".into();
        other.motors.rows.push(only.rows.remove(0));
        let after = other.optimize();
        same(&candidates(&before, "worse"), &candidates(&after, "worse"), 0.0, name);
        for joint in after["joints"].as_array().unwrap() {
            let list = joint["candidates"].as_array().unwrap();
            let at = |motor: &str| list.iter().position(|c| c["motor"] == motor);
            assert!(at("worse").is_none_or(|worse| at(&best).is_some_and(|best| best < worse)), "{name}");
        }
    }
}

#[test]
fn a_motor_that_is_not_chosen_can_be_left_out() {
    for name in ["quadruped_mini_cheetah", "humanoid_hip_catalog_gears"] {
        let world = World::shipped(name);
        let before = world.optimize();
        let firsts: Vec<&Value> =
            before["joints"].as_array().unwrap().iter().map(|j| &j["candidates"][0]["motor"]).collect();
        let gone = MOTORS.iter().filter(|m| !firsts.iter().any(|f| *f == *m));
        let mut tried = 0;
        for motor in gone {
            let mut other = world.clone();
            other.motors.rows.retain(|r| r[0] != *motor);
            same(&candidates(&before, motor), &candidates(&other.optimize(), motor), 0.0, &format!("{name} {motor}"));
            tried += 1;
        }
        assert!(tried >= 5, "{tried}");
    }
}

/// A value of the requirement by its path, and how it is widened.
type Wider<'w> = (&'w str, &'w dyn Fn(&str) -> String);

#[test]
fn a_wider_limit_never_makes_anything_worse() {
    let paths: [Wider; 10] = [
        ("bus.voltage", &|v| scaled(v, 1.3)),
        ("bus.drive_current", &|v| scaled(v, 1.3)),
        ("bus.modulation_limit", &|_| "1.0".into()),
        ("joint.limits.actuator_mass", &|v| scaled(v, 1.3)),
        ("joint.limits.reflected_inertia", &|v| scaled(v, 1.3)),
        ("joint.limits.winding_temperature", &|v| scaled(v, 1.3)),
        ("joint.limits.safety", &|_| "1.0".into()),
        ("joint.limits.torque_bandwidth.amplitude", &|v| scaled(v, 0.7)),
        ("joint.ratio.max", &|v| (v.parse::<i64>().unwrap() + 10).to_string()),
        ("joint.gear.peak_torque", &|v| scaled(v, 1.3)),
    ];
    let mut better = 0;
    for name in ["exoskeleton_hip", "quadruped_mini_cheetah", "leg_prosthesis_walking"] {
        let mut shipped = World::shipped(name);
        // Without estimates most rows say nothing of their drag, and could not be judged.
        for joint in shipped.robot["joint"].as_array_mut().unwrap() {
            joint.as_table_mut().unwrap().insert("motor_drag".into(), Toml::String("off".into()));
        }
        // A winding that may be hotter has more resistance, at which voltage and power are judged: so both do not bind
        // where that limit is widened.
        let mut supplied = shipped.clone();
        supplied.change("bus.voltage", &|v| scaled(v, 10.0));
        supplied.change("bus.power", &|v| scaled(v, 10.0));
        let results = [shipped.optimize(), supplied.optimize()];
        for (path, change) in &paths {
            let (world, before) = match *path {
                "joint.limits.winding_temperature" => (&supplied, &results[1]),
                _ => (&shipped, &results[0]),
            };
            let mut other = world.clone();
            if other.change(path, *change) == 0 {
                continue;
            }
            let after = other.optimize();
            for (a, b) in before["joints"].as_array().unwrap().iter().zip(after["joints"].as_array().unwrap()) {
                for c in a["candidates"].as_array().unwrap() {
                    let what = format!("{name} {path} {} {}", a["joint"], c["motor"]);
                    let wide = b["candidates"].as_array().unwrap().iter().find(|d| d["motor"] == c["motor"]);
                    let wide = wide.unwrap_or_else(|| panic!("{what}: no longer feasible"));
                    let number = |v: &Value| v.as_f64().unwrap();
                    let (was, is) = (number(&c["objective"]), number(&wide["objective"]));
                    assert!(is <= was * (1.0 + 1e-9), "{what}: {was} to {is}");
                    better += usize::from(is < was * (1.0 - 1e-6));
                    assert!(number(&wide["window"][0]) <= number(&c["window"][0]) * (1.0 + 1e-9), "{what}");
                    assert!(number(&wide["window"][1]) >= number(&c["window"][1]) * (1.0 - 1e-9), "{what}");
                }
            }
        }
    }
    assert!(better > 20, "some limits did bind: {better}");
}

/// A bench with its logs, in memory.
struct Bench {
    file: toml::Table,
    logs: BTreeMap<String, Sheet>,
}

impl Bench {
    fn shipped(name: &str, every: usize) -> Bench {
        let file: toml::Table = read(repository(&format!("requirements/bench/{name}.toml"))).parse().unwrap();
        let mut logs = BTreeMap::new();
        for log in file["log"].as_array().unwrap() {
            let name = log["file"].as_str().unwrap();
            let mut sheet = Sheet::parse(&read(repository("requirements/bench").join(name)));
            let mut k = 0;
            sheet.rows.retain(|_| {
                k += 1;
                (k - 1) % every == 0
            });
            logs.insert(name.to_string(), sheet);
        }
        Bench { file, logs }
    }

    fn run(&self, command: &str) -> Value {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("bench.toml"), toml::to_string(&self.file).unwrap()).unwrap();
        for (name, log) in &self.logs {
            fs::write(folder.path().join(name), log.text()).unwrap();
        }
        let output = gearwise_in(folder.path(), &[command, "bench.toml", "--json"]);
        assert!(output.status.code() < Some(2), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    }

    /// The tables of columns: the common one and those of logs.
    fn columns(&mut self) -> Vec<&mut toml::Table> {
        let mut found = Vec::new();
        for (key, value) in self.file.iter_mut() {
            match value {
                Toml::Table(table) if key == "columns" => found.push(table),
                Toml::Array(logs) if key == "log" => {
                    for log in logs {
                        found.extend(log.get_mut("columns").and_then(Toml::as_table_mut));
                    }
                }
                _ => {}
            }
        }
        found
    }
}

/// A result without what tells of the files themselves: hashes and names of columns.
fn without(value: &Value, keys: &[&str]) -> Value {
    match value {
        Value::Object(map) => map
            .iter()
            .filter(|(k, _)| !keys.contains(&k.as_str()))
            .map(|(k, v)| (k.clone(), without(v, keys)))
            .collect(),
        Value::Array(items) => items.iter().map(|v| without(v, keys)).collect(),
        other => other.clone(),
    }
}

/// Columns renamed, in another order, time from another zero: the same log. Signs and units changed with the bench
/// file saying so: the same but for rounding.
#[test]
fn how_a_log_is_written_changes_nothing_that_is_learnt_from_it() {
    for (name, command, every) in [("leg_actuator", "identify", 2), ("motor_on_bench", "characterize", 1)] {
        let bench = || Bench::shipped(name, every);
        let files = ["sha256", "file", "files", "source", "note", "hash"];
        let before = without(&bench().run(command), &files);
        let mut renamed = bench();
        renamed.logs.values_mut().for_each(|log| {
            log.header.iter_mut().for_each(|h| *h = format!("Größe {h}"));
            *log = log.columns_reversed();
        });
        for table in renamed.columns() {
            for (_, column) in table.iter_mut() {
                let name = column.as_table_mut().unwrap().get_mut("name").unwrap();
                *name = format!("Größe {}", name.as_str().unwrap()).into();
            }
        }
        same(&before, &without(&renamed.run(command), &files), 0.0, &format!("{name}: renamed"));
        let mut signs = bench();
        let mut changed = Vec::new();
        for table in signs.columns() {
            for (quantity, column) in table.iter_mut() {
                let column = column.as_table_mut().unwrap();
                let heading = column["name"].as_str().unwrap().to_string();
                let unit = column["unit"].as_str().unwrap().to_string();
                if quantity.contains("temperature") {
                    continue;
                }
                let flipped = ["torque", "velocity"].contains(&quantity.as_str());
                let (factor, unit) = another(1.0, &unit, 0);
                column.insert("unit".into(), unit.into());
                if flipped {
                    let sign = column.get("sign").and_then(Toml::as_integer).unwrap_or(1);
                    column.insert("sign".into(), (-sign).into());
                }
                changed.push((heading, if flipped { -factor } else { factor }));
            }
        }
        changed.sort_by(|a, b| a.0.cmp(&b.0));
        changed.dedup_by(|a, b| a.0 == b.0);
        for log in signs.logs.values_mut() {
            for (heading, factor) in &changed {
                if let Some(column) = log.header.iter().position(|h| h == heading) {
                    log.map(column, |x| x * factor);
                }
            }
        }
        same(&before, &without(&signs.run(command), &files), 1e-6, &format!("{name}: signs and units"));
        let mut later = bench();
        for log in later.logs.values_mut().filter(|log| log.header.iter().any(|h| h == "t_s")) {
            log.map(log.column("t_s"), |t| t + 1024.0);
        }
        // A lag lies where the error is least, which rounding tells to its square root: times of 1024 s have 1.1e-13 s of
        // rounding, against a lag of 4 ms.
        let rounding = (1024.0 * f64::EPSILON / 2.0 / 4e-3).sqrt();
        same(&before, &without(&later.run(command), &files), rounding, &format!("{name}: later"));
    }
}

/// The tree of a robot is the same whatever comes first in its file.
#[test]
fn links_and_joints_in_another_order_ask_for_the_same_torques() {
    let robots = repository("requirements/robots");
    let text = read(robots.join("ur5e.urdf"));
    let from = text.find("<link").unwrap();
    let to = text.rfind("</robot>").unwrap();
    // Elements of the robot, each with its end: links and joints stand at the top alone.
    let mut elements = Vec::new();
    let mut rest = &text[from..to];
    while let Some(start) = rest.find('<') {
        rest = &rest[start..];
        let name: String = rest[1..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let tag = rest.find('>').unwrap();
        let end = if rest.starts_with("<!--") {
            rest.find("-->").unwrap() + 3
        } else if rest[..tag].ends_with('/') {
            tag + 1
        } else {
            let close = format!("</{name}>");
            rest.find(&close).unwrap() + close.len()
        };
        elements.push(&rest[..end]);
        rest = &rest[end..];
    }
    assert!(elements.len() > 12);
    elements.reverse();
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("other.urdf"), format!("{}{}</robot>", &text[..from], elements.join("\n"))).unwrap();
    let pick = Sheet::parse(&read(robots.join("ur5e_pick.csv")));
    fs::write(folder.path().join("pick.csv"), pick.columns_reversed().text()).unwrap();
    let run = |model: &str, trajectory: &str| -> Value {
        let output = gearwise_in(folder.path(), &["torques", model, trajectory, "--json"]);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (urdf, csv) = (robots.join("ur5e.urdf"), robots.join("ur5e_pick.csv"));
    let before = run(urdf.to_str().unwrap(), csv.to_str().unwrap());
    assert!(before["joints"].as_array().unwrap().len() == 6);
    same(&before, &run("other.urdf", "pick.csv"), 1e-12, "reversed");
}
