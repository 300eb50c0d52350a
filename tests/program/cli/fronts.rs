//! Fronts of two and more quantities on the command line: what is wrong, what is shown and what is not, the same points everywhere.

use std::process::Command;

use serde_json::Value;

use super::folder::{folder, run};
use crate::common::repository;

const CHEETAH: &str = "requirements/quadruped_mini_cheetah.toml";

fn gearwise(arguments: &[&str], columns: &str) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .env("COLUMNS", columns)
        .args(arguments)
        .current_dir(repository(""))
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

fn json(quantities: &str, file: &str, more: &[&str]) -> Value {
    let (_, out, err) = gearwise(&[&["optimize", file, "--json", "--pareto", quantities], more].concat(), "120");
    serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {err}"))
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

#[test]
fn what_is_no_list_of_quantities_is_said_with_its_place() {
    for (quantities, expected) in [
        ("loss", "a front takes two or more quantities"),
        ("loss,mass,loss", "names 1 and 3 are both `loss`: give each quantity once"),
        ("mass, mass", "names 1 and 2 are both `mass`"),
        (
            "loss,mass,reflected_inertai",
            "name 3, `reflected_inertai`, is not a quantity; did you mean `reflected_inertia`?",
        ),
        ("loss,zzz", "name 2, `zzz`, is not a quantity; there are: loss, copper_loss, reflected_inertia"),
        ("loss,,mass", "name 2 is empty"),
        ("loss,mass,", "name 3 is empty"),
        ("", "name 1 is empty"),
    ] {
        let (status, out, err) = gearwise(&["optimize", CHEETAH, "--pareto", quantities], "120");
        assert!(status == 2 && out.is_empty(), "{quantities}: {out}");
        let flat = err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(flat.contains(&format!("`--pareto {quantities}`: {expected}")), "{quantities}: {err}");
    }
}

/// Every quantity that is asked for is a column of the CSV and a value of the JSON, the same in both; no point betters another.
#[test]
fn files_have_every_point_with_every_quantity() {
    let names = "loss,copper_loss,reflected_inertia,peak_current,mass,energy,peak_power";
    let keys = [
        "loss_w",
        "copper_loss_w",
        "reflected_inertia_kgm2",
        "peak_current_q_a",
        "mass_kg",
        "energy_per_cycle_j",
        "peak_electrical_power_w",
    ];
    let found = json(names, CHEETAH, &["--points", "5"]);
    let (_, csv, _) = gearwise(&["optimize", CHEETAH, "--csv", "--pareto", names, "--points", "5"], "120");
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    let header: Vec<String> = rows.headers().unwrap().iter().map(String::from).collect();
    let place = |key: &str| header.iter().position(|h| h == key).unwrap_or_else(|| panic!("no {key}"));
    let records: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    let candidates: Vec<&csv::StringRecord> = records.iter().filter(|r| &r[place("state")] == "candidate").collect();
    let points: Vec<(&Value, &Value)> =
        list(&found["joints"]).iter().flat_map(|j| list(&j["candidates"]).iter().map(move |p| (j, p))).collect();
    assert!(points.len() == candidates.len() && points.len() > 50, "{} {}", points.len(), candidates.len());
    for ((joint, point), row) in points.iter().zip(candidates) {
        assert_eq!(point["motor"].as_str().unwrap(), &row[place("motor")]);
        assert_eq!(list(&joint["quantities"]).len(), 7);
        for (k, key) in keys.iter().enumerate() {
            let value = point["values"][k].as_f64().unwrap();
            let cell: f64 = row[place(key)].parse().unwrap_or_else(|_| panic!("{key} is blank"));
            assert!(
                (cell - value).abs() <= 1e-9 * value.abs() && point[*key].as_f64() == Some(value),
                "{key} {cell} {value}"
            );
        }
    }
    for joint in list(&found["joints"]) {
        let all: Vec<Vec<f64>> = list(&joint["candidates"])
            .iter()
            .map(|p| list(&p["values"]).iter().map(|v| v.as_f64().unwrap()).collect())
            .collect();
        for (i, z) in all.iter().enumerate() {
            let better = |(j, y): (usize, &Vec<f64>)| i != j && y.iter().zip(z).all(|(y, z)| y <= z);
            assert!(!all.iter().enumerate().any(better), "{}", joint["joint"]);
        }
        assert!(all.windows(2).all(|w| w[0][0] <= w[1][0]), "the best in the first quantity first");
    }
}

/// The efficient ratios of a motor: those that are proved are those of its points, and one that no point is of is told too.
#[test]
fn efficient_ratios_are_told_of_every_motor() {
    let found = json("loss,mass,reflected_inertia", CHEETAH, &[]);
    // The loss of saturated iron is no polynomial, and is not proved: the motors of the knee are such.
    let proved = |joint: &Value| list(&joint["efficient"]).iter().any(|e| e["certified"] == true);
    assert!(list(&found["joints"]).iter().filter(|joint| proved(joint)).count() >= 2);
    for joint in list(&found["joints"]) {
        let efficient = list(&joint["efficient"]);
        for point in list(&joint["candidates"]) {
            let of = efficient.iter().find(|e| e["motor"] == point["motor"]).unwrap();
            assert_eq!(of["certified"], point["certified"]);
            let [min, max, ratio] = [&of["ratio_min"], &of["ratio_max"], &point["ratio"]].map(|v| v.as_f64().unwrap());
            assert!(of["certified"] == false || (min * (1.0 - 1e-12)..=max * (1.0 + 1e-12)).contains(&ratio));
        }
        let on_front = |motor: &Value| list(&joint["candidates"]).iter().any(|p| p["motor"] == *motor);
        assert!(efficient.iter().any(|e| !on_front(&e["motor"])));
    }
}

/// Of a front of three quantities the table shows some; how many not, and where they are, is said, at each width. `--top` and `--full`
/// show more or fewer motors.
#[test]
fn a_table_says_what_it_does_not_show() {
    let words = ["optimize", CHEETAH, "--pareto", "loss,mass,reflected_inertia"];
    let found = json("loss,mass,reflected_inertia", CHEETAH, &[]);
    for (more, most) in [(&[][..], 10), (&["--top", "3"], 3), (&["--full"], usize::MAX)] {
        for columns in ["80", "120"] {
            let (status, text, _) = gearwise(&[&words[..], more].concat(), columns);
            let wide: usize = columns.parse().unwrap();
            assert!(status == 0 && text.lines().all(|l| l.chars().count() <= wide), "{text}");
            let blocks: Vec<&str> = text.split("with a feasible design").collect();
            for (joint, block) in list(&found["joints"]).iter().zip(&blocks[1..]) {
                let points = list(&joint["candidates"]);
                let mut motors: Vec<&str> = points.iter().map(|p| p["motor"].as_str().unwrap()).collect();
                motors.sort_unstable();
                motors.dedup();
                let flat = block.split_whitespace().collect::<Vec<_>>().join(" ");
                let counts = format!("{} points of {} motors on the front", points.len(), motors.len());
                assert!(flat.contains(&counts), "{counts}: {flat}");
                let rows: Vec<&str> =
                    block.lines().filter(|l| motors.iter().any(|m| l.starts_with(&format!("{m} ")))).collect();
                let mut shown: Vec<&str> = rows.iter().map(|r| r.split(' ').next().unwrap()).collect();
                shown.dedup();
                assert_eq!(shown.len(), motors.len().min(most), "each motor's rows together: {block}");
                let not = match motors.len() - shown.len() {
                    0 => String::new(),
                    1 => "1 motor is not shown (`--full` shows all), ".into(),
                    more => format!("{more} motors are not shown (`--full` shows all), "),
                };
                let said = format!(
                    "{not}{} further points: `--csv` and `--json` have all {}.",
                    points.len() - rows.len(),
                    points.len()
                );
                assert!(flat.contains(&said), "{said}: {flat}");
                // The best in each quantity is there, however few motors are shown.
                for k in 0..3 {
                    let value = |p: &Value| p["values"][k].as_f64().unwrap();
                    let best = points.iter().min_by(|a, b| value(a).total_cmp(&value(b))).unwrap();
                    assert!(shown.contains(&best["motor"].as_str().unwrap()), "{block}");
                }
                let (exact, grid) =
                    (flat.contains("exact: the motor's own"), flat.contains("not certified: the motor's"));
                let any = |certified: bool| points.iter().any(|p| p["certified"] == certified);
                assert_eq!((exact, grid), (any(true), any(false)));
            }
        }
    }
}

/// What a front counts has to be known, whatever the objective is: a motor whose drag nobody knows is on no front of loss, and on one of
/// mass and inertia it is.
#[test]
fn what_a_front_counts_is_judged_as_an_objective_is() {
    let folder = folder();
    let pareto = |quantities: &str| {
        let set = ["--set", "joint.*.objective=mass", "--set", "joint.*.motor_drag=counted"];
        let words =
            ["optimize", "robot.toml", "--catalog", "motors.csv", "--no-estimates", "--json", "--pareto", quantities];
        let ran = run(&folder, &[&words[..], &set].concat());
        let found: Value = serde_json::from_str(&ran.out).unwrap_or_else(|_| panic!("{}", ran.err));
        (ran.status, list(&found["joints"][0]["candidates"]).len(), list(&found["joints"][0]["unjudged"]).len())
    };
    assert_eq!(pareto("loss,mass,reflected_inertia"), (1, 0, 2));
    let (status, points, unjudged) = pareto("mass,reflected_inertia");
    assert!(status == 0 && points > 0 && unjudged == 0);
}
