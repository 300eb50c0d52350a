//! `identify` as a user runs it: on the shipped example, and on logs that are broken in every way.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::common::repository;
use crate::common::run::{gearwise, json, stderr, stdout};
use crate::simulator;

const EXAMPLE: &str = "requirements/bench/leg_actuator.toml";

#[test]
fn the_example_tells_its_story() {
    let output = gearwise(&["identify", EXAMPLE]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    for part in [
        "t-motor-ri50 at N = 9; 2 logs to fit, 1 log held out",
        "leg_actuator_3.csv",
        "held_out",
        "as declared",
        "artefacts taken out",
        "declared parameters refitted",
        "+ coulomb_friction",
        "+ cogging order 12",
        "final",
        "noise of the instrument",
        "lag of velocity",
        "torque_constant",
        "Not added, and why:",
        "What to measure next:",
        "The declared model lacks Coulomb friction and cogging",
    ] {
        assert!(text.contains(part), "`{part}` is not in\n{text}");
    }
}

/// What `requirements/make/bench.py` put into the logs comes out of them.
#[test]
fn the_example_gives_back_what_was_put_in() {
    let result = json(&gearwise(&["identify", EXAMPLE, "--json"]));
    for key in [
        "target",
        "unit",
        "noise_floor",
        "verdict",
        "errors",
        "artefacts",
        "parameters",
        "effects",
        "refused",
        "unexplained",
        "further",
    ] {
        assert!(result.get(key).is_some(), "no `{key}`");
    }
    assert_eq!((result["target"].as_str(), result["unit"].as_str()), (Some("torque"), Some("N*m")));
    assert_eq!(result["verdict"], "explained");
    let error = |stage: &str, key: &str| result["errors"][stage][key].as_f64().unwrap();
    for stage in ["declared", "artefacts", "refit", "final"] {
        assert!(error(stage, "fit") > 0.0 && error(stage, "held_out") > 0.0);
        assert!(error(stage, "fit_vaf") <= 100.0 && error(stage, "held_out_vaf") <= 100.0);
    }
    assert!(error("declared", "held_out") > 10.0 * error("final", "held_out"));
    let names: Vec<&str> =
        result["errors"]["steps"].as_array().unwrap().iter().map(|s| s["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["cogging order 12", "coulomb_friction"]);
    let effects = result["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 2);
    let parameter = |effect: &Value, name: &str| -> (f64, f64) {
        let list = effect["parameters"].as_array().unwrap();
        let p = list.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("no {name} in {effect}"));
        (p["fitted"].as_f64().unwrap(), p["standard_error"].as_f64().unwrap())
    };
    assert_eq!(
        (effects[0]["name"].as_str(), effects[0]["equation"].as_str()),
        (Some("coulomb_friction"), Some("torque"))
    );
    let (torque, error) = parameter(&effects[0], "torque");
    assert!((torque / 0.055 - 1.0).abs() < 0.02 && error > 0.0 && error < 1e-3, "{torque} ± {error}");
    let (cosine, sine) = (parameter(&effects[1], "12.cosine").0, parameter(&effects[1], "12.sine").0);
    // COGGING cos(12 θ − 0.7)
    assert!((cosine / (0.03 * 0.7_f64.cos()) - 1.0).abs() < 0.05, "{cosine}");
    assert!((sine / (0.03 * 0.7_f64.sin()) - 1.0).abs() < 0.05, "{sine}");
    for effect in effects {
        assert!(effect["held_out_before"].as_f64() > effect["held_out_after"].as_f64());
        assert!(effect["confounded_with"].is_array());
    }
    let lag = result["artefacts"].as_array().unwrap().iter().find(|a| a["kind"] == "lag").expect("a lag");
    assert!((lag["value"].as_f64().unwrap() - 0.004).abs() < 5e-4 && lag["unit"] == "s");
    for refused in result["refused"].as_array().unwrap() {
        assert!(!refused["reason"].as_str().unwrap().is_empty());
        assert!(effects.iter().all(|e| e["name"] != refused["name"]), "found and refused: {refused}");
    }
    no_number_is_lost(&result, "");
}

/// JSON has no NaN: a number that is not known is null only where that is said.
fn no_number_is_lost(value: &Value, path: &str) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, v)| no_number_is_lost(v, &format!("{path}/{key}"))),
        Value::Array(list) => list.iter().for_each(|v| no_number_is_lost(v, path)),
        Value::Null => {
            let may = [
                "declared",
                "standard_error",
                "plus_minus",
                "undecided",
                "beside",
                "better_left_out_error",
                "far_off_percent",
                "held_out",
                "held_out_vaf",
                "held_out_before",
                "held_out_after",
                "band_hz",
                "noise_floor",
                "times_the_noise",
                "noise_cannot_be_told",
                "line_above_the_band_hz",
                "value",
                "why_not",
            ];
            assert!(may.iter().any(|m| path.ends_with(m)), "{path} is null");
        }
        _ => {}
    }
}

#[test]
fn csv_has_every_part() {
    let output = gearwise(&["identify", EXAMPLE, "--csv"]);
    let text = stdout(&output);
    assert!(text.starts_with("equation,part,name,declared,value,plus_minus_95,standard_error,fit_rmse"));
    for part in [
        "torque,stage,declared",
        "torque,artefact,lag of velocity",
        "torque,parameter,torque_constant",
        "torque,effect,coulomb_friction.torque",
        "torque,refused,",
    ] {
        assert!(text.contains(part), "{part}");
    }
}

#[test]
fn output_and_files_are_the_same_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let run = |threads: &str| {
        let at = |name: &str| folder.path().join(format!("{threads}{name}")).to_str().unwrap().to_string();
        let (svg, fitted) = (at("r.svg"), at("f.toml"));
        let first =
            gearwise(&["identify", EXAMPLE, "--json", "--threads", threads, "--plot", &svg, "--write", &fitted]);
        assert_eq!(first.status.code(), Some(0), "{}", stderr(&first));
        (first.stdout, fs::read(svg).unwrap(), fs::read(fitted).unwrap())
    };
    assert!(run("1") == run("4"), "one and four threads differ");
}

#[test]
fn pictures_are_whole_or_not_there() {
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("residual.svg");
    let output = gearwise(&["identify", EXAMPLE, "--plot", svg.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0));
    assert!(stdout(&output).contains("residual.svg"));
    let text = fs::read_to_string(&svg).unwrap();
    assert!(text.starts_with("<svg") && text.trim_end().ends_with("</svg>"));
    for label in [
        "motor speed [rad/s]",
        "motor position in its turn [rad]",
        "current, q axis [A]",
        "winding over its reference [K]",
        "residual [N*m]",
        "order: periods",
    ] {
        assert!(text.contains(label), "{label}");
    }
    let drawn = text.matches("<circle").count();
    assert!((1000..=4200).contains(&drawn), "{drawn} dots");
    // What cannot be written leaves nothing.
    let output = gearwise(&["identify", EXAMPLE, "--plot", folder.path().join("none/x.svg").to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("cannot write"), "{}", stderr(&output));
    let output = gearwise(&["identify", EXAMPLE, "--plot", "x.pdf"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains(".svg or .png"));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no half file is left");
}

#[test]
fn the_fitted_actuator_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fitted.toml");
    let output = gearwise(&["identify", EXAMPLE, "--write", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = fs::read_to_string(&path).unwrap();
    let file: toml::Table = toml::from_str(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(file["gearwise"].as_str(), Some(env!("CARGO_PKG_VERSION")));
    let motor = file["motor"].as_table().unwrap();
    for (key, value) in [
        ("id", "t-motor-ri50-fitted"),
        ("terminals", "q_axis"),
        ("current", "q_axis"),
        ("back_emf_convention", "q_axis"),
        ("source_kind", "measured"),
        ("resistance", "0.705 ohm"),
        ("mass", "0.193 kg"),
    ] {
        assert_eq!(motor[key].as_str(), Some(value), "{key}");
    }
    assert_eq!(motor["pole_pairs"].as_integer(), Some(7));
    let quantity = |key: &str, kind| gearwise::units::quantity(motor[key].as_str().unwrap(), kind).unwrap();
    assert!((quantity("coulomb_friction", &gearwise::units::TORQUE) - 0.055).abs() < 1e-3);
    assert!(quantity("coulomb_friction_tolerance", &gearwise::units::TORQUE) > 0.0);
    assert!(!motor.contains_key("motor_constant"), "a column that the fit contradicts");
    let cogging = file["effects"]["cogging"].as_array().unwrap();
    assert_eq!(
        (cogging.len(), cogging[0]["order"].as_float().or(cogging[0]["order"].as_integer().map(|i| i as f64))),
        (1, Some(12.0))
    );
    assert!(file["effects"].get("coulomb_friction").is_none(), "it stands in the row");
    let names = file["covariance"]["names"].as_array().unwrap();
    let matrix = file["covariance"]["matrix"].as_array().unwrap();
    assert!(names.len() == matrix.len() && matrix.iter().all(|row| row.as_array().unwrap().len() == names.len()));
    assert!(names.iter().any(|n| n.as_str() == Some("motor.coulomb_friction")));
    let logs = file["provenance"].as_array().unwrap();
    assert_eq!(logs.len(), 3);
    assert_eq!(logs[2]["use"].as_str(), Some("held_out"));
    assert!(logs.iter().all(|l| l["sha256"].as_str().is_some_and(|h| h.len() == 64)));
}

/// Copies the example with its logs changed, and runs it.
fn spoilt(bench: impl Fn(String) -> String, log: impl Fn(usize, Vec<Vec<String>>) -> Vec<Vec<String>>) -> Output {
    spoilt_with(bench, log, &[])
}

fn spoilt_with(
    bench: impl Fn(String) -> String,
    log: impl Fn(usize, Vec<Vec<String>>) -> Vec<Vec<String>>,
    further: &[&str],
) -> Output {
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(repository(EXAMPLE)).unwrap();
    fs::write(folder.path().join("bench.toml"), bench(text)).unwrap();
    for k in 1..=3 {
        let name = format!("leg_actuator_{k}.csv");
        let text = fs::read_to_string(repository(&format!("requirements/bench/{name}"))).unwrap();
        let rows: Vec<Vec<String>> = text.lines().map(|l| l.split(',').map(str::to_string).collect()).collect();
        let text: String = log(k, rows).iter().map(|r| r.join(",") + "\n").collect();
        fs::write(folder.path().join(name), text).unwrap();
    }
    let path: &Path = &folder.path().join("bench.toml");
    gearwise(&[&["identify", path.to_str().unwrap(), "--json"], further].concat())
}

fn same(text: String) -> String {
    text
}

/// Names of the effects that were found.
fn effects(output: &Output) -> Vec<String> {
    assert_eq!(output.status.code(), Some(0), "{}", stderr(output));
    let result = json(output);
    no_number_is_lost(&result, "");
    result["effects"].as_array().unwrap().iter().map(|e| e["name"].as_str().unwrap().to_string()).collect()
}

fn refused(output: &Output, parts: &[&str]) {
    assert_eq!(output.status.code(), Some(2), "{}", stdout(output));
    assert!(output.stdout.is_empty());
    for part in parts {
        assert!(stderr(output).contains(part), "`{part}` is not in\n{}", stderr(output));
    }
}

#[test]
fn runs_of_missing_values_and_repeated_times_do_no_harm() {
    let output = spoilt(same, |_, mut rows| {
        for row in &mut rows[700..900] {
            row[4] = "nan".into();
        }
        for row in &mut rows[1500..1520] {
            row[1] = String::new();
        }
        let twice = rows[2000].clone();
        rows.insert(2000, twice);
        rows
    });
    assert_eq!(effects(&output), ["coulomb_friction", "cogging"]);
    let logs = json(&output)["logs"].as_array().unwrap().clone();
    assert!(!logs[0]["remarks"].as_array().unwrap().is_empty(), "what was left out is said");
}

#[test]
fn three_rows_teach_nothing() {
    refused(&spoilt(same, |_, rows| rows[..4].to_vec()), &["nothing can be learnt"]);
}

#[test]
fn constant_channels_teach_nothing_wrong() {
    // A torque sensor that is stuck.
    let stuck = |_: usize, mut rows: Vec<Vec<String>>| {
        rows.iter_mut().skip(1).for_each(|r| r[4] = "1.000".into());
        rows
    };
    refused(
        &spoilt_with(same, stuck, &["--write", "fitted.toml"]),
        &["`--write`: there are no fitted numbers to write. Nothing can be learnt"],
    );
    let output = spoilt(same, stuck);
    let result = json(&output);
    assert_eq!(result["effects"], serde_json::json!([]), "a stuck sensor shows no effect");
    assert_eq!(result["sentence"], "Nothing can be learnt: the torque has one value throughout.");
    assert_eq!(result["verdict"], "not_resolved");
    assert!(result["errors"]["declared"]["fit_vaf"].is_null(), "{}", result["errors"]);
    assert_eq!(result["logs"][0]["stuck_channels"], serde_json::json!(["torque"]));
    // A torque that is noise, whatever current and motion do: no model is complete or off because of it.
    let noise = |k: usize, mut rows: Vec<Vec<String>>| {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64 ^ k as u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        rows.iter_mut().skip(1).for_each(|r| r[4] = format!("{}", 0.3 + (0..12).map(|_| uniform()).sum::<f64>()));
        rows
    };
    refused(
        &spoilt_with(same, noise, &["--write", "fitted.toml"]),
        &["`--write`: there are no fitted numbers to write. Nothing can be learnt"],
    );
    let result = json(&spoilt(same, noise));
    let sentence = result["sentence"].as_str().unwrap();
    assert!(sentence.starts_with("Nothing can be learnt: the torque does not follow the model"), "{sentence}");
    assert_eq!((&result["verdict"], &result["effects"]), (&"not_resolved".into(), &serde_json::json!([])));
    // A shaft that never turns.
    let output = spoilt(same, |_, mut rows| {
        rows.iter_mut().skip(1).for_each(|r| {
            r[2] = "0".into();
            r[3] = "0".into();
        });
        rows
    });
    let found = effects(&output);
    let moving = ["coulomb_friction", "viscous_friction", "stribeck_friction", "eddy_drag", "cogging"];
    assert!(found.iter().all(|f| !moving.contains(&f.as_str())), "{found:?}");
    assert_eq!(json(&output)["logs"][0]["stuck_channels"], serde_json::json!(["motor position", "motor velocity"]));
}

#[test]
fn text_in_the_middle_is_shown_with_its_place() {
    let output = spoilt(same, |k, mut rows| {
        if k == 2 {
            rows[1234][2] = "overflow".into();
        }
        rows
    });
    refused(&output, &["leg_actuator_2.csv:1235", "overflow"]);
}

#[test]
fn swapped_columns_do_not_get_a_name() {
    // Torque and current exchanged: nothing of the library makes that.
    let output = spoilt(same, |_, mut rows| {
        rows.iter_mut().skip(1).for_each(|r| r.swap(1, 4));
        rows
    });
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result = json(&output);
    let constant = result["parameters"].as_array().unwrap().iter().find(|p| p["name"] == "torque_constant").cloned();
    let off =
        constant.is_some_and(|c| (c["fitted"].as_f64().unwrap() / c["declared"].as_f64().unwrap() - 1.0).abs() > 0.2);
    let gain = result["artefacts"].as_array().unwrap().iter().any(|a| a["kind"] == "gain");
    assert!(off || gain || result["verdict"] == "unexplained_structure", "{result}");
}

#[test]
fn wrong_arguments_are_mistakes() {
    refused(&gearwise(&["identify", "requirements/bench/leg_actuator.tom"]), &["leg_actuator.toml"]);
    refused(&gearwise(&["identify", EXAMPLE, "--band", "30"]), &["--band 30", "needs its unit"]);
    refused(&gearwise(&["identify", EXAMPLE, "--band", "0 Hz"]), &["greater than zero"]);
    let output = gearwise(&["identify", EXAMPLE, "--band", "30 Hz", "--json"]);
    assert_eq!(json(&output)["band_hz"].as_f64(), Some(30.0));
}

/// A bench with two equations: the first stands at the top, the other below `further`, and the top knows of
/// the effects of both.
#[test]
fn every_equation_of_a_bench_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let truth = simulator::scenario("backlash", 5.0, 7).write(folder.path());
    let (svg, bench) = (folder.path().join("r.svg"), truth.bench.to_str().unwrap());
    let output = gearwise(&["identify", bench, "--json", "--plot", svg.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let result = json(&output);
    no_number_is_lost(&result, "");
    let further = result["further"].as_array().unwrap();
    assert_eq!(
        (result["target"].as_str(), further.len(), further[0]["target"].as_str()),
        (Some("drive_torque"), 1, Some("wind_up"))
    );
    assert_eq!(further[0]["unit"], "rad");
    for key in ["noise_floor", "verdict", "errors", "artefacts", "parameters", "effects", "refused", "unexplained"] {
        assert!(further[0].get(key).is_some(), "no `{key}`");
    }
    let names = |list: &Value| -> Vec<String> {
        list.as_array().unwrap().iter().map(|e| e["name"].as_str().unwrap().to_string()).collect()
    };
    let (top, below) = (names(&result["effects"]), names(&further[0]["effects"]));
    assert!(!below.is_empty() && below.iter().all(|b| top.contains(b)), "{top:?} {below:?}");
    for effect in result["effects"].as_array().unwrap() {
        let of_angle = below.iter().any(|b| effect["name"] == b.as_str());
        assert_eq!(effect["equation"], if of_angle { "wind_up" } else { "drive_torque" });
    }
    assert!(names(&result["refused"]).iter().all(|r| !top.contains(r)));
    let text = fs::read_to_string(svg).unwrap();
    assert!(text.contains("angle between motor and output") && text.contains("residual [rad]"));
}

/// The six lines of a page, each with its subject, in their order.
fn six_lines(arguments: &[&str]) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("loop.html");
    let output = gearwise(&[&["identify"], arguments, &["--html", page.to_str().unwrap()]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = std::fs::read_to_string(&page).unwrap();
    let subjects = ["Measured", "Missing", "Error", "Choice", "Moved by", "Next"];
    let at = |subject: &str| text.find(&format!("<li>{subject}: ")).unwrap_or_else(|| panic!("no line `{subject}`"));
    assert!(subjects.windows(2).all(|pair| at(pair[0]) < at(pair[1])));
    let line = |subject: &str| text[at(subject)..].split("</li>").next().unwrap().replace("<li>", "");
    // The story, then pictures, then numbers.
    let after = &text[at("Next")..];
    let (picture, numbers) = (after.find("<figure").unwrap(), after.find("declared parameters refitted").unwrap());
    assert!(picture < numbers);
    subjects.map(line).to_vec()
}

#[test]
fn the_page_tells_the_loop_in_six_lines() {
    let [measured, missing, error, choice, moved, next] =
        &six_lines(&[EXAMPLE, "--requirement", "requirements/bench/leg_joint.toml"])[..]
    else {
        panic!("six")
    };
    assert!(measured.contains("t-motor-ri50 at N = 9, 3 logs, 1 of them held out"), "{measured}");
    assert!(missing.contains("Coulomb friction and cogging"), "{missing}");
    assert!(error.contains("0.5374 N·m before, 0.0274 N·m after, on logs that were held out"), "{error}");
    assert!(
        choice.contains("at hip, t-motor-ri50 goes from N* = 11.38") && choice.contains("stays the first choice"),
        "{choice}"
    );
    assert!(moved.contains("most by the measured friction: N* = "), "{moved}");
    assert!(next.contains("one ratio cannot separate friction"), "{next}");
    // Without a requirement nothing is said of a choice.
    let lines = six_lines(&[EXAMPLE]);
    assert!(lines[3].contains("not made again") && lines[4].contains("not known"), "{lines:?}");
}

/// Nothing is confounded in the example: no run is planned, no file is written, and that is no failure.
#[test]
fn no_run_is_planned_where_nothing_is_confounded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("next.csv");
    let file = path.to_str().unwrap();
    let output = gearwise(&["identify", EXAMPLE, "--plan", file]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stdout(&output).contains("no run is planned: nothing is confounded"), "{}", stdout(&output));
    assert!(!path.exists());
    let result = json(&gearwise(&["identify", EXAMPLE, "--plan", file, "--json"]));
    assert_eq!((result["plan"]["outcome"].as_str(), result["plan"]["file"].is_null()), (Some("nothing_open"), true));
    // Without `--plan` nothing is said of it.
    assert!(json(&gearwise(&["identify", EXAMPLE, "--json"])).get("plan").is_none());
    for wrong in [
        vec!["--plan-time", "30 s"],
        vec!["--plan", file, "--plan-time", "30 kg"],
        vec!["--plan", file, "--plan-time", "2 h"],
        vec!["--plan", file, "--plan-travel=-3 deg"],
    ] {
        let output = gearwise(&[&["identify", EXAMPLE], wrong.as_slice()].concat());
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
        assert!(stderr(&output).contains("--plan"), "{}", stderr(&output));
    }
}

/// At one speed and one current a friction may be of several laws: the run that separates them is written as set-points, and it is
/// said within which limits.
#[test]
fn a_confounded_name_gets_a_run_to_play() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("next.csv");
    let file = path.to_str().unwrap();
    let planned = |seed: u64| {
        let mut bench = simulator::Bench::dynamometer(seed)
            .sampled(6.0, 200.0)
            .with_noise(simulator::Effect::CoulombFriction, 2.0)
            .excitation(|e| (e.steady_speed, e.steady_current) = (true, true))
            .declared(|d| (d.viscous, d.coulomb) = (None, None));
        (bench.machine.viscous, bench.machine.coulomb) = (1e-3 * bench.machine.viscous, 1e-3 * bench.machine.coulomb);
        let truth = bench.write(folder.path());
        let input = truth.bench.to_str().unwrap().to_string();
        let result = json(&gearwise(&["identify", &input, "--plan", file, "--plan-time", "12 s", "--json"]));
        (result["plan"]["outcome"] == "planned").then_some((input, result, truth))
    };
    let (input, result, truth) = (1..=6).find_map(planned).expect("a name that is confounded");
    let output = gearwise(&["identify", &input, "--plan", file, "--plan-time", "12 s"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = stdout(&output);
    for part in
        ["The next run:", "δ now", "_friction or ", "speed of the motor", "no rating is declared", "continuous_current"]
    {
        assert!(text.contains(part), "`{part}` is not in\n{text}");
    }
    let written = fs::read_to_string(&path).unwrap();
    let mut lines = written.lines();
    let header = "time [s],output_position [rad],output_velocity [rad/s],current [A],motor_torque [N*m],\
                  expected_output_torque [N*m]";
    assert_eq!(lines.next(), Some(header));
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 1201);
    let plan = &result["plan"];
    assert_eq!((plan["file"].as_str(), plan["duration_s"].as_f64()), (Some(file), Some(12.0)));
    let pair = &plan["pairs"][0];
    assert!(pair["delta_now"].as_f64() < pair["delta_after"].as_f64(), "{pair}");
    let limit = |of: &str| plan["limits"].as_array().unwrap().iter().find(|l| l["of"] == of).unwrap().clone();
    let (speed, heat) = (limit("speed"), limit("heat"));
    assert_eq!((speed["source"].as_str(), speed["column"].is_null()), (Some("reached"), true));
    assert_eq!((heat["source"].as_str(), heat["column"].as_str()), (Some("declared"), Some("continuous_current")));
    let largest = rows.iter().map(|r| r[2].abs()).fold(0.0, f64::max) * truth.machine.ratio;
    assert!(largest <= speed["allowed"].as_f64().unwrap() * 1.0001, "{largest} {speed}");
}
