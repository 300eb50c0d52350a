//! The program as a user runs it.

use std::process::{Command, Stdio};

use serde_json::Value;

use crate::cases::few;
use crate::common::repository;
use crate::common::run::{gearwise, stdout};

fn json(arguments: &[&str]) -> Value {
    let output = gearwise(arguments);
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{arguments:?}: {e}: {}", String::from_utf8_lossy(&output.stderr)))
}

fn requirements() -> Vec<String> {
    let entries = std::fs::read_dir(repository("requirements")).unwrap();
    let mut files: Vec<String> = entries
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "toml"))
        .map(|p| format!("requirements/{}", p.file_name().unwrap().to_str().unwrap()))
        .collect();
    files.sort();
    files
}

/// Motors of the built-in catalogue, each once; with those that are sold inside modules alone or without.
fn motors_once(also_inside: bool) -> usize {
    gearwise::catalog::Catalog::builtin().unwrap().free(also_inside).motors.len()
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn every_shipped_requirement_has_a_choice_for_every_joint() {
    let files = requirements();
    assert!(files.len() >= 4);
    for file in files {
        let output = gearwise(&["optimize", &file, "--json"]);
        let result: Value = serde_json::from_slice(&output.stdout).unwrap();
        let of = |joint: &Value, list: &str| joint[list].as_array().unwrap().clone();
        let done = result["joints"].as_array().unwrap().iter().all(|j| !of(j, "candidates").is_empty());
        assert_eq!((output.status.code(), done), (Some(0), true), "{file}");
        for joint in result["joints"].as_array().unwrap() {
            let [candidates, unjudged, rejected] = ["candidates", "unjudged", "rejected"].map(|list| of(joint, list));
            assert!(!candidates.is_empty() || !unjudged.is_empty(), "{file} {}", joint["joint"]);
            assert_eq!(
                candidates.len() + unjudged.len() + rejected.len(),
                motors_once(false),
                "no motor is dropped silently"
            );
            assert!(unjudged.iter().all(|u| u["because"].as_str().unwrap().starts_with("cannot be judged: ")));
            for reject in &rejected {
                assert!(!reject["because"].as_str().unwrap().is_empty());
                assert!(!reject["because"].as_str().unwrap().contains("not solved"), "{file}: {reject}");
            }
            let mut last = f64::NEG_INFINITY;
            for candidate in &candidates {
                let objective = candidate["objective"].as_f64().unwrap();
                assert!(objective >= last, "best first");
                last = objective;
                let window: Vec<f64> =
                    candidate["window"].as_array().unwrap().iter().map(|w| w.as_f64().unwrap()).collect();
                let ratio = candidate["ratio"].as_f64().unwrap();
                assert!(window[0] <= ratio * (1.0 + 1e-9) && ratio <= window[1] * (1.0 + 1e-9));
                for (limit, margin) in candidate["margins"].as_object().unwrap() {
                    assert!(margin.as_f64().unwrap() >= -1e-9, "{file} {limit} {margin}");
                }
                let certificate = &candidate["certificate"];
                if certificate["certified"].as_bool().unwrap() {
                    assert!(certificate["gap"].as_f64().unwrap() <= 1e-6);
                    assert!(certificate["lower_bound"].as_f64().unwrap() <= objective);
                } else {
                    assert!(
                        certificate["because"].as_str().unwrap().contains("not") || certificate["because"].is_string()
                    );
                }
            }
        }
    }
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let commands = [
        vec!["optimize", "requirements/humanoid_hip_catalog_gears.toml", "--top", "50", "--rejected"],
        vec!["sweep", "requirements/exoskeleton_hip.toml", "--csv"],
        vec!["optimize", "requirements/quadruped_mini_cheetah.toml", "--json"],
    ];
    for command in few(2, commands) {
        let with = |threads: &str| {
            let mut arguments = command.clone();
            arguments.extend(["--threads", threads]);
            gearwise(&arguments).stdout
        };
        let one = with("1");
        assert!(!one.is_empty());
        assert!(few(1, ["3", "2", "8"]).all(|n| with(n) == one), "{command:?}");
    }
}

#[test]
fn sweep_gives_every_design_with_its_verdict() {
    let result = json(&["sweep", "requirements/quadruped_mini_cheetah.toml", "--ratios", "7", "--json"]);
    for joint in result["joints"].as_array().unwrap() {
        let list = |name: &str| joint[name].as_array().unwrap();
        let told = |of: &&Value| of["design"].is_object();
        // Of some motors nothing can be worked out: they are told once, by what is not known or why they are no candidates.
        let others = || list("unjudged").iter().chain(list("rejected"));
        let left_out = others().filter(|r| !told(r)).count();
        let designs = list("candidates").len() + others().filter(told).count();
        assert_eq!(designs + 7 * left_out, 7 * motors_once(false));
        let keeps = |design: &Value| {
            let margins = design["margins"].as_object().unwrap().values();
            let worst = margins.map(|m| m.as_f64().unwrap_or(f64::NEG_INFINITY)).fold(f64::MAX, f64::min);
            assert_eq!(design["feasible"], worst >= -1e-9, "{design}");
            worst >= -1e-9
        };
        assert!(list("candidates").iter().all(keeps));
        assert!(list("unjudged").iter().all(|u| !u["limits"].as_array().unwrap().is_empty()));
        assert!(list("unjudged").iter().filter(told).all(|u| keeps(&u["design"])));
        assert!(list("rejected").iter().filter(told).all(|r| !keeps(&r["design"]) && r["because"].is_string()));
    }
    let csv = stdout(&gearwise(&["sweep", "requirements/quadruped_mini_cheetah.toml", "--ratios", "7", "--csv"]));
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let rows = reader.records().filter(|r| r.as_ref().is_ok_and(|r| !r.is_empty())).count();
    let joints = result["joints"].as_array().unwrap().iter();
    let lists =
        joints.flat_map(|j| ["candidates", "unjudged", "rejected"].map(|list| j[list].as_array().unwrap().len()));
    let all: usize = lists.sum();
    assert_eq!(rows, all);
}

#[test]
fn a_sweep_can_be_ordered_by_the_metrics() {
    for by in few(3, ["mass_s_m", "reflected_inertia", "mass", "s_m", "s_t", "mass_s_t", "margin"]) {
        let result =
            json(&["sweep", "requirements/quadruped_mini_cheetah.toml", "--ratios", "5", "--sort", by, "--json"]);
        let feasible: Vec<&Value> = result["joints"][1]["candidates"].as_array().unwrap().iter().collect();
        assert!(feasible.len() > 5);
        let key = match by {
            "s_m" => "/metrics/s_m_s",
            "s_t" => "/metrics/s_t_kgm2a2_per_nm2",
            "mass_s_m" => "/metrics/mass_s_m_kgs",
            "mass_s_t" => "/metrics/mass_s_t_kg2m2a2_per_nm2",
            "reflected_inertia" => "/reflected_inertia_kgm2",
            "mass" => "/mass_kg",
            _ => continue,
        };
        let values: Vec<f64> =
            feasible.iter().map(|d| d.pointer(key).unwrap().as_f64().unwrap_or(f64::INFINITY)).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1]), "{by}");
    }
}

#[test]
fn the_metrics_stand_beside_every_candidate_and_are_judged() {
    let result = json(&["optimize", "requirements/arm_six_axis_pick_and_place.toml", "--json"]);
    let joint = &result["joints"][0];
    for key in ["s_m_s", "s_t_kgm2a2_per_nm2", "mass_s_m_kgs", "mass_s_t_kg2m2a2_per_nm2"] {
        assert!(joint["candidates"][0]["metrics"][key].is_number(), "{key}");
    }
    let agreement = joint["metric_agreement"].as_array().unwrap();
    assert!(
        agreement.iter().any(|a| a["metric"] == "s_m" && (-1.0..=1.0).contains(&a["kendall_tau"].as_f64().unwrap()))
    );
}

#[test]
fn rank_says_how_sure_the_order_is() {
    let result = json(&["rank", "--tolerance", "5%", "--json"]);
    let motors = result["motors"].as_array().unwrap();
    let not_ranked = result["not_ranked"].as_array().unwrap();
    assert_eq!(motors.len() + not_ranked.len(), motors_once(true));
    let mut last = 0.0;
    for motor in &motors[..motors.len() - 1] {
        let s_m = motor["s_m_s"].as_f64().unwrap();
        assert!(s_m >= last);
        last = s_m;
        let sure = motor["probability_ahead_of_next"].as_f64().unwrap();
        assert!((0.5..=1.0).contains(&sure));
    }
    // Without an assumption nothing is claimed of rows that state no tolerance.
    let plain = json(&["rank", "--json"]);
    assert!(plain["motors"][0]["probability_ahead_of_next"].is_null());
}

#[test]
fn compare_tells_the_case_study() {
    let result = json(&["compare", "t-motor-ri50", "t-motor-u8", "--json"]);
    assert!((result["responsiveness_ratio"].as_f64().unwrap() - 2.654).abs() < 1e-3);
    assert!((result["motors"][0]["matched"]["ratio"].as_f64().unwrap() - (1200.0_f64 / 90.1).sqrt()).abs() < 1e-9);
    let text = stdout(&gearwise(&["compare", "t-motor-ri50", "t-motor-u8"]));
    for expected in ["2.654 times as responsive", "3.4 times", "K_T exceeds K_B", "overshoot"] {
        assert!(text.contains(expected), "{expected}:\n{text}");
    }
    let inertia = json(&["compare", "t-motor-ri50", "t-motor-u8", "--inertia", "0.02 kg*m^2", "--json"]);
    assert_eq!(inertia["matched_inertia_kgm2"].as_f64(), Some(0.02));
}

#[test]
fn exit_status_and_messages_of_wrong_arguments() {
    for (arguments, expected) in [
        (vec!["compare", "t-motor-ri5", "t-motor-u8"], "did you mean `t-motor-ri50`?"),
        (vec!["compare", "t-motor-ri50", "t-motor-u8", "--inertia", "3"], "needs its unit"),
        (vec!["compare", "t-motor-ri50", "t-motor-u8", "--inertia", "-3 kg*m^2"], "not greater than zero"),
        (vec!["rank", "--sort", "s_n"], "did you mean `s_m`?"),
        (vec!["rank", "--tolerance", "lots"], "write it like 5%"),
        (vec!["rank", "--sort", "k_m", "--mass-weight"], "goes with `--sort s_m`"),
        (vec!["explain", "t-motor-ri50@1e300", "requirements/exoskeleton_hip.toml"], "is not a ratio"),
        (vec!["explain", "t-motor-ri50", "requirements/quadruped_jump.toml"], "which joint?"),
        (vec!["optimize", "requirements/exoskeleton_hip.toml", "--pareto", "loss,los"], "did you mean `loss`?"),
        (vec!["sweep", "requirements/exoskeleton_hip.toml", "--sort", "weight"], "is not an order"),
        (vec!["sweep", "requirements/exoskeleton_hip.toml", "--ratios", "0"], "0 is not in 1..="),
        (vec!["optimize", "requirements/exoskeleton_hp.toml"], "there is `exoskeleton_hip.toml` in that folder"),
        (vec!["optimize", "requirements"], "this is a folder"),
        (
            vec!["optimize", "requirements/exoskeleton_hip.toml", "--catalog", "requirements"],
            "no .csv file in this folder",
        ),
        (
            vec!["optimize", "requirements/exoskeleton_hip.toml", "--catalog", "catalogs/gears"],
            "the catalogue has no motors",
        ),
        (vec!["rank", "no/such/file.csv"], "there is no such file"),
        (vec!["optimise", "x"], "similar subcommand"),
        (vec!["optimize", "requirements/exoskeleton_hip.toml", "--json", "--csv"], "cannot be used with"),
    ] {
        let output = gearwise(&arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(stderr.contains(expected), "{arguments:?}: {stderr}");
    }
}

#[test]
fn explain_tells_what_binds_and_what_would_have_to_change() {
    let file = "requirements/quadruped_mini_cheetah.toml";
    let explained = |arguments: &[&str]| json(arguments)["joints"][0].clone();
    let feasible = explained(&["explain", "t-motor-ri50", file, "--joint", "knee", "--no-estimates", "--json"]);
    assert_eq!(feasible["design"]["feasible"], true);
    assert!(feasible["best"]["certificate"]["gap"].as_f64().unwrap() <= 1e-6);
    assert!(!feasible["sensitivities"].as_array().unwrap().is_empty());
    // At a ratio of 30 the voltage does not suffice, and the exit status says so.
    let output = gearwise(&["explain", "t-motor-ri50@30", file, "--joint", "knee"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(stdout(&output).contains("is not feasible"));
    // A rejected motor: the remedy, carried out, makes it feasible.
    let rejected = explained(&["explain", "maxon-ec-i-52-574741", file, "--joint", "hip", "--json"]);
    let remedies = rejected["remedies"].as_array().unwrap();
    let mass = remedies.iter().find(|r| r["limit"] == "actuator_mass").unwrap();
    let wider = format!("actuator_mass = \"{} kg\"", mass["needed"].as_f64().unwrap() * (1.0 + 1e-9));
    let motions = format!("{}/", repository("requirements/motions").display());
    let text = std::fs::read_to_string(repository(file)).unwrap();
    let text = text.replace("actuator_mass = \"0.55 kg\"", &wider).replace("motions/", &motions);
    let folder = tempfile::tempdir().unwrap();
    let changed = folder.path().join("wider.toml");
    std::fs::write(&changed, text).unwrap();
    let changed = changed.to_str().unwrap();
    let after = explained(&["explain", "maxon-ec-i-52-574741", changed, "--joint", "hip", "--json"]);
    assert_eq!(after["design"]["feasible"], true, "{remedies:?}");
}

#[test]
fn a_front_is_not_dominated_and_its_ends_are_the_best_of_each() {
    let file = "requirements/quadruped_mini_cheetah.toml";
    let front = json(&["optimize", file, "--pareto", "loss,reflected_inertia", "--json"]);
    let best = json(&["optimize", file, "--json"]);
    for (joint, best) in front["joints"].as_array().unwrap().iter().zip(best["joints"].as_array().unwrap()) {
        let value = |p: &Value, name: &str| p["values"][usize::from(name == "reflected_inertia")].as_f64().unwrap();
        let points = joint["candidates"].as_array().unwrap();
        assert!(points.windows(2).all(|w| value(&w[0], "loss") < value(&w[1], "loss")));
        assert!(points.windows(2).all(|w| value(&w[0], "reflected_inertia") > value(&w[1], "reflected_inertia")));
        let least = best["candidates"][0]["loss_w"].as_f64().unwrap();
        assert!((value(&points[0], "loss") - least).abs() <= 1e-9 * least);
    }
}

#[test]
fn a_joint_that_no_motor_can_do_is_status_one() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("impossible.toml");
    let text = "name = \"x\"\nbus = { voltage = \"1 V\" }\n[[joint]]\nname = \"j\"\nratio = { min = 3, max = 30 }\n\
                points = [ { torque = \"500 N*m\", speed = \"50 rad/s\", duration = \"1 s\" } ]\n";
    std::fs::write(&file, text).unwrap();
    let output = gearwise(&["optimize", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    // Of some nothing can be said: no rotor inertia.
    assert!(stdout(&output).contains("NO motor that can be judged can do: j"));
    let output = gearwise(&["optimize", file.to_str().unwrap(), "--catalog", "catalogs/motors/faulhaber.csv"]);
    assert!(stdout(&output).contains("NO motor of the catalogue can do: j"));
    assert_eq!(gearwise(&["sweep", file.to_str().unwrap()]).status.code(), Some(1));
    assert_eq!(gearwise(&["audit", "tests/fixtures/paper_motors.csv"]).status.code(), Some(1));
    assert_eq!(gearwise(&["audit"]).status.code(), Some(0));
}

#[test]
fn a_closed_pipe_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["sweep", "requirements/arm_six_axis_pick_and_place.toml", "--csv"])
        .current_dir(repository(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn help_has_an_example() {
    for command in ["optimize", "sweep", "rank", "compare", "audit", "completions"] {
        let help = gearwise(&[command, "--help"]);
        assert_eq!(help.status.code(), Some(0));
        assert!(stdout(&help).contains("gearwise "), "{command} has an example");
    }
}

#[test]
fn tables_fit_where_there_is_no_terminal() {
    for command in [
        vec!["optimize", "requirements/quadruped_mini_cheetah.toml"],
        vec!["optimize", "requirements/humanoid_hip_catalog_gears.toml", "--rejected"],
        vec!["sweep", "requirements/humanoid_hip_catalog_gears.toml"],
        vec!["rank"],
        vec!["compare", "t-motor-ri50", "t-motor-u8"],
        vec!["audit"],
    ] {
        for line in stdout(&gearwise(&command)).lines() {
            assert!(line.chars().count() <= 122, "{command:?}: {} columns: {line}", line.chars().count());
        }
    }
}

#[test]
fn a_sweep_too_large_for_memory_is_refused_at_once() {
    let output = gearwise(&["sweep", "requirements/quadruped_mini_cheetah.toml", "--ratios", "1000000"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(output.stdout.is_empty());
    assert!(String::from_utf8_lossy(&output.stderr).contains("`--ratios`"));
}
