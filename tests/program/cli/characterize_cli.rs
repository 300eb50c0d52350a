//! `characterize` as a user runs it: the shipped example, its row in the other commands, and every wrong input.

use std::fs;
use std::process::Output;

use serde_json::Value;

use crate::common::repository;
use crate::common::run::{gearwise, gearwise_in, stderr, stdout};

const EXAMPLE: &str = "requirements/bench/motor_on_bench.toml";

/// What `requirements/make/motor_bench.py` put in comes out, within the stated intervals.
#[test]
fn the_example_gives_back_what_was_put_in() {
    let output = gearwise(&["characterize", EXAMPLE, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    let quantities: Vec<&Value> =
        result["tests"].as_array().unwrap().iter().flat_map(|t| t["quantities"].as_array().unwrap()).collect();
    for (name, truth, tightest) in [
        ("resistance", 0.705, 0.01),
        ("torque_constant", 0.0857, 0.12),
        ("back_emf_constant", 0.0857, 0.01),
        ("output_inertia_with_rotor", 6.5425e-4, 0.02),
        ("output_inertia_without_rotor", 1.48e-4, 0.02),
        ("rotor_inertia", 9.0e-6, 0.03),
        ("coulomb_friction", 0.015, 0.1),
        ("viscous_friction", 1.2e-4, 0.1),
        ("thermal_resistance_winding_housing", 1.6, 0.05),
        ("thermal_resistance_housing_ambient", 2.4, 0.05),
        ("thermal_time_constant_winding", 28.0, 0.1),
        ("thermal_time_constant_housing", 420.0, 0.1),
    ] {
        let q = quantities.iter().find(|q| q["name"] == name).unwrap_or_else(|| panic!("no {name}"));
        let of = |key: &str| q[key].as_f64().unwrap();
        let (low, high) = (of("low_95"), of("high_95"));
        // Fixed logs: of twelve intervals of 95 % one may miss, none by more than half its width.
        let slack = 0.25 * (high - low);
        assert!(low - slack < truth && truth < high + slack, "{name}: {truth} not in {low} … {high}");
        assert!((high - low) / 2.0 < tightest * truth, "{name}: ± {}", (high - low) / 2.0);
    }
    let logs = result["logs"].as_array().unwrap();
    assert_eq!(logs.len(), 8);
    assert!(logs.iter().all(|l| l["sha256"].as_str().unwrap().len() == 64));
    let row = &result["row"];
    assert_eq!((row["id"].as_str(), row["complete"].as_bool()), (Some("example-bench-motor"), Some(true)));
    assert!(row["numbers"]["rotor_inertia_tolerance_kgm2"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_example_tells_its_story() {
    let text = stdout(&gearwise(&["characterize", EXAMPLE]));
    for part in [
        "torque_constant",
        "Hann windows",
        "motor_on_bench_stall_3.csv: torque falls with current",
        "the velocity is 4",
        "pooled with random effects",
        "(J_r − J_nr)/N²",
        "thin ring",
        "K_T is",
        "linear sum",
        "mass: not measured, given in the bench file",
        "complete: `audit`",
    ] {
        assert!(text.contains(part), "`{part}` is not in\n{text}");
    }
    assert_eq!(text, stdout(&gearwise(&["characterize", EXAMPLE, "--threads", "1"])));
}

/// The row goes on as it is: `audit`, `rank` and `optimize` accept it.
#[test]
fn the_row_is_a_catalogue() {
    let folder = tempfile::tempdir().unwrap();
    let row = folder.path().join("row.csv");
    let (row, picture) = (row.to_str().unwrap(), folder.path().join("bench.svg"));
    let output = gearwise(&["characterize", EXAMPLE, "--write", row, "--plot", picture.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(fs::metadata(&picture).unwrap().len() > 10_000);
    let text = fs::read_to_string(row).unwrap();
    assert_eq!(text.lines().count(), 2, "{text}");
    for part in [
        "torque_constant_tolerance [N*m/A]",
        "sha256",
        "motor_on_bench_rotor.csv",
        "measured",
        "random_torque: rotor_inertia",
    ] {
        assert!(text.contains(part), "`{part}` is not in {text}");
    }
    let audit = gearwise(&["audit", row]);
    assert_eq!(audit.status.code(), Some(0), "{}{}", stdout(&audit), stderr(&audit));
    let rank: Value = serde_json::from_slice(&gearwise(&["rank", row, "--json"]).stdout).unwrap();
    assert!(rank.to_string().contains("example-bench-motor"));
    let robot = "requirements/quadruped_mini_cheetah.toml";
    let optimize = gearwise(&["optimize", robot, "--catalog", row, "--json"]);
    assert!(matches!(optimize.status.code(), Some(0 | 1)), "{}", stderr(&optimize));
    assert!(stdout(&optimize).contains("example-bench-motor"));
}

const BENCH: &str = r#"actuator = { ratio = 1 }
[motor]
id = "m"
[terminals]
winding = "wye"
resistance = ["1.41 ohm", "1.42 ohm", "1.40 ohm"]
resistance_tolerance = "4 mohm"
temperature = "22 degC"
[columns]
time = { name = "t", unit = "s" }
current = { name = "i", unit = "A", convention = "phase_amplitude" }
torque = { name = "tau", unit = "N*m" }
[[log]]
file = "stall.csv"
kind = "stall"
"#;

fn stall_csv() -> String {
    let mut text = String::from("t,i,tau\n");
    for k in 0..400 {
        let i = k / 50 - 4;
        text.push_str(&format!(
            "{:.2},{}.0{},{:.4}\n",
            f64::from(k) * 0.04,
            i,
            k % 7,
            0.1 * f64::from(i) + 0.001 * f64::from(k % 5)
        ));
    }
    text
}

fn run(bench: &str, log: &str, more: &[&str]) -> (Output, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bench.toml"), bench).unwrap();
    fs::write(folder.path().join("stall.csv"), log).unwrap();
    let arguments: Vec<&str> = ["characterize", "bench.toml"].iter().chain(more).copied().collect();
    (gearwise_in(folder.path(), &arguments), folder)
}

#[test]
fn the_good_files_are_good() {
    let (output, folder) = run(BENCH, &stall_csv(), &["--write", "row.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(folder.path().join("row.csv").exists());
}

#[test]
fn wrong_inputs_are_named() {
    let good = stall_csv();
    let lines: Vec<&str> = good.lines().collect();
    let nan = good.replacen("0.08,-4.02", "0.08,abc", 1);
    let unsorted = [&lines[..3], &[lines[10]], &lines[3..]].concat().join("\n");
    type Case<'a> = (&'a str, &'a [(&'a str, &'a str)], &'a str);
    let cases: &[Case] = &[
        ("typo in a key", &[("resistance_tolerance", "resistance_tolerence")], &good),
        ("typo in a table", &[("[terminals]", "[terminal]")], &good),
        ("missing unit", &[("\"4 mohm\"", "\"4\"")], &good),
        ("unit of something else", &[("\"1.42 ohm\"", "\"1.42 mH\"")], &good),
        ("two readings of three", &[(", \"1.40 ohm\"]", "]")], &good),
        ("negative reading", &[("\"1.40 ohm\"", "\"-1.40 ohm\"")], &good),
        ("no convention", &[(", convention = \"phase_amplitude\"", "")], &good),
        ("missing log", &[("\"stall.csv\"", "\"stal.csv\"")], &good),
        ("unknown kind", &[("kind = \"stall\"", "kind = \"stal\"")], &good),
        ("a reading as a log", &[("kind = \"stall\"", "kind = \"terminals\"")], &good),
        ("missing column", &[("name = \"tau\"", "name = \"torque\"")], &good),
        ("bad id", &[("id = \"m\"", "id = \"My Motor\"")], &good),
        (
            "rotor without radius",
            &[("[columns]", "[rotor]\nmass = \"34 g\"\nmass_tolerance = \"1 g\"\n[columns]")],
            &good,
        ),
        ("current without convention", &[("id = \"m\"", "id = \"m\"\npeak_current = \"20 A\"")], &good),
        ("text in a log", &[], &nan),
        ("unsorted time", &[], &unsorted),
        ("empty log", &[], ""),
        ("log without rows", &[], "t,i,tau\n"),
    ];
    insta::with_settings!({ snapshot_path => "../../snapshots/characterize", prepend_module_to_snapshot => false }, {
        for (name, changes, log) in cases {
            let mut bench = BENCH.to_string();
            for (from, to) in *changes {
                assert!(bench.contains(from), "`{from}` is not in the good file");
                bench = bench.replacen(from, to, 1);
            }
            let (output, folder) = run(&bench, log, &["--write", "row.csv"]);
            assert_eq!(output.status.code(), Some(2), "{name}: {}{}", stdout(&output), stderr(&output));
            assert!(output.stdout.is_empty(), "{name}: nothing may be printed beside the report");
            assert!(!folder.path().join("row.csv").exists(), "{name}: a row was written");
            insta::assert_snapshot!(name.replace(' ', "_"), stderr(&output));
        }
    });
}

/// What is read but says too little is said, and no row is written: exit status 1.
#[test]
fn a_row_that_is_not_complete_is_not_written() {
    let flat = stall_csv().lines().map(|l| format!("{l}\n")).take(40).collect::<String>();
    let (output, folder) = run(BENCH, &flat, &["--write", "row.csv"]);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    assert!(
        stderr(&output).contains("torque_constant (stall) or back_emf_constant (backdrive)"),
        "{}",
        stderr(&output)
    );
    assert!(stdout(&output).contains("at least 4 are needed"), "{}", stdout(&output));
    assert!(!folder.path().join("row.csv").exists());
}

/// A rotor whose inertia is measured far from what its mass and radius allow, and a K_T far from K_B: both were measured,
/// so that the row says what the audit will find, and why, and the audit takes it for explained.
#[test]
fn what_two_tests_disagree_on_is_accepted_by_name() {
    let backdrive = "[[log]]\nfile = \"backdrive.csv\"\nkind = \"backdrive\"\ncolumns.velocity = { name = \"w\", unit = \
                     \"rad/s\" }\ncolumns.voltage = { name = \"v\", unit = \"V\", convention = \"q_axis\" }\n";
    let folder = tempfile::tempdir().unwrap();
    let mut voltages = String::from("t,i,tau,w,v\n");
    for k in 1..=8 {
        // K_B = 0.05 against a K_T of 0.082 on the q axis.
        voltages.push_str(&format!("{k},0,0,{},{:.3}\n", 20 * k, f64::from(k) + 0.002 * f64::from(k % 3)));
    }
    fs::write(folder.path().join("backdrive.csv"), voltages).unwrap();
    fs::write(folder.path().join("stall.csv"), stall_csv()).unwrap();
    fs::write(folder.path().join("bench.toml"), format!("{BENCH}{backdrive}")).unwrap();
    let output = gearwise_in(folder.path(), &["characterize", "bench.toml", "--write", "row.csv"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("beyond their ±"), "{}", stdout(&output));
    let text = fs::read_to_string(folder.path().join("row.csv")).unwrap();
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let header = reader.headers().unwrap().clone();
    let row = reader.records().next().unwrap().unwrap();
    let of = |name: &str| &row[header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no {name} in {text}"))];
    assert_eq!(of("audit_accept"), "back-emf");
    assert!(of("note").contains("both measured: "), "{}", of("note"));
    let audit = gearwise_in(folder.path(), &["audit", "row.csv"]);
    assert_eq!(audit.status.code(), Some(0), "{}", stdout(&audit));
    assert!(stdout(&audit).contains("0 errors, 1 explained"), "{}", stdout(&audit));
    // A row that agrees with itself accepts nothing.
    let (_, folder) = run(BENCH, &stall_csv(), &["--write", "row.csv"]);
    assert!(!fs::read_to_string(folder.path().join("row.csv")).unwrap().contains("audit_accept,"));
}

/// A missing cell of a current neither stops the heat nor the program.
#[test]
fn a_missing_current_does_not_stop_the_heat() {
    let file = fs::read_to_string(repository("requirements/bench/motor_on_bench_thermal.csv")).unwrap();
    let lines = file.lines().enumerate().map(|(k, line)| {
        let (time, rest) = line.split_once(',').unwrap();
        // Every tenth current is not there: its cell is the second.
        if k % 10 == 5 { format!("{time},,{}\n", rest.split_once(',').unwrap().1) } else { format!("{line}\n") }
    });
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("thermal.csv"), lines.collect::<String>()).unwrap();
    let head = BENCH.split("[columns]").next().unwrap();
    let log = "[[log]]\nfile = \"thermal.csv\"\nkind = \"thermal_step\"\ncolumns.time = { name = \"t_s\", unit = \"s\" \
               }\ncolumns.current = { name = \"dc_a\", unit = \"A\", convention = \"dc\" }\ncolumns.winding_temperature = { \
               name = \"winding_degc\", unit = \"degC\" }\ncolumns.housing_temperature = { name = \"housing_degc\", unit = \
               \"degC\" }\n";
    fs::write(folder.path().join("bench.toml"), format!("ambient = \"22 degC\"\n{head}{log}")).unwrap();
    let output = gearwise_in(folder.path(), &["characterize", "bench.toml", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result: Value = serde_json::from_slice(&output.stdout).unwrap();
    let r = &result["row"]["numbers"]["thermal_resistance_winding_housing_k_per_w"];
    assert!((r.as_f64().unwrap_or_else(|| panic!("{result:#}")) / 1.6 - 1.0).abs() < 0.03, "{r}");
}

/// Wrong arguments are mistakes too.
#[test]
fn wrong_arguments() {
    for (arguments, part) in
        [(["--write", "row.toml"], "a catalogue's name ends in .csv"), (["--plot", "row.pdf"], "ends in .svg or .png")]
    {
        let (output, _folder) = run(BENCH, &stall_csv(), &arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains(part), "{}", stderr(&output));
    }
}

/// A bench for `identify` alone has nothing to characterise, and that is said.
#[test]
fn other_benches_are_refused() {
    let output = gearwise(&["characterize", "requirements/bench/leg_actuator.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("nothing here characterises a motor"), "{}", stderr(&output));
}
