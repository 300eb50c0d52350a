//! What `--json` prints is what `docs/schema.json` says, and its shape is one.

use std::process::Command;

use gearwise::design::figures::FIGURES;
use gearwise::rules::measure::measure;
use serde_json::Value;

use crate::common::repository;

const CHEETAH: &str = "requirements/quadruped_mini_cheetah.toml";

fn print(arguments: &[&str]) -> Value {
    let json: &[&str] = if arguments[0] == "export" { &["--to", "json"] } else { &["--json"] };
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(arguments)
        .args(json)
        .current_dir(repository(""))
        .output()
        .unwrap();
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{arguments:?}: {e}: {}", String::from_utf8_lossy(&output.stderr)))
}

pub(super) fn published() -> jsonschema::Validator {
    let schema: Value =
        serde_json::from_str(&std::fs::read_to_string(repository("docs/schema.json")).unwrap()).unwrap();
    jsonschema::validator_for(&schema).unwrap()
}

/// Commands with what their answer calls them.
fn commands() -> Vec<(Vec<&'static str>, &'static str)> {
    let design = "requirements/designs/arm_six_axis_pick_and_place/design.toml";
    vec![
        (vec!["optimize", CHEETAH], "optimize"),
        (vec!["optimize", "requirements/arm_from_its_description.toml", "--robot"], "optimize"),
        (vec!["optimize", "requirements/ankle_prosthesis_parallel_spring.toml", "--only-top", "2"], "optimize"),
        (vec!["optimize", "requirements/humanoid_hip_catalog_gears.toml"], "optimize"),
        (vec!["optimize", CHEETAH, "--pareto", "loss,mass", "--points", "3"], "optimize --pareto"),
        (vec!["optimize", CHEETAH, "--pareto", "loss,mass,peak_power", "--points", "3"], "optimize --pareto"),
        (vec!["optimize", "requirements/exoskeleton_hip.toml", "--robust"], "optimize --robust"),
        (vec!["sweep", CHEETAH, "--ratios", "3"], "sweep"),
        (vec!["explain", "t-motor-ri50", CHEETAH, "--joint", "knee"], "explain"),
        (vec!["explain", "maxon-ec-i-52-574741", CHEETAH, "--joint", "hip"], "explain"),
        (vec!["explain", "t-motor-ri50", "requirements/ankle_prosthesis_parallel_spring.toml"], "explain"),
        (vec!["check", design], "check"),
        (vec!["check", "requirements/exoskeleton_hip.toml"], "check"),
        (vec!["rank", "--tolerance", "5%"], "rank"),
        (vec!["compare", "t-motor-ri50", "t-motor-u8-lee"], "compare"),
        (vec!["audit"], "audit"),
        (vec!["audit", "catalogs/gears", "--against", "catalogs/gears"], "audit against"),
        (vec!["catalog", "list", "motors", "mass<0.5kg"], "catalog list"),
        (vec!["catalog", "list", "kind=belt"], "catalog list"),
        (vec!["catalog", "search", "maxon"], "catalog search"),
        (vec!["catalog", "show", "t-motor-u8"], "catalog show"),
        (vec!["catalog", "show", "planetary-maxon-gp52c-66-223091"], "catalog show"),
        (vec!["catalog", "diff", "builtin", "catalogs/motors/maxon.csv"], "catalog diff"),
        (vec!["catalog", "path"], "catalog path"),
        (vec!["torques", "requirements/robots/ur5e.urdf", "requirements/robots/ur5e_pick.csv"], "torques"),
        (vec!["identify", "requirements/bench/leg_actuator.toml"], "identify"),
        (vec!["identify", "requirements/bench/leg_actuator.toml", "--requirement", CHEETAH], "identify"),
        (vec!["identify", "tests/fixtures/benches/linear_axis.toml"], "identify"),
        (vec!["identify", "tests/fixtures/benches/xl330_excerpt.toml"], "identify"),
        (vec!["export", "t-motor-ri50@9", CHEETAH, "--joint", "knee"], "export"),
        (vec!["export", design], "export"),
        (vec!["rule"], "rule"),
        (vec!["rule", "GW106"], "rule"),
        (vec!["characterize", "requirements/bench/motor_on_bench.toml"], "characterize"),
    ]
}

#[test]
fn every_answer_keeps_the_published_schema_and_says_which_it_is() {
    let schema = published();
    for (arguments, command) in commands() {
        let printed = print(&arguments);
        assert_eq!((&printed["schema_version"], printed["command"].as_str()), (&Value::from(1), Some(command)));
        let wrong: Vec<String> = schema.iter_errors(&printed).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(wrong.is_empty(), "{arguments:?}: {}", wrong.join("\n").chars().take(2000).collect::<String>());
    }
}

/// The summary of a study is a file, and printed.
#[test]
fn the_summary_of_a_study_keeps_the_published_schema() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("study");
    let printed = print(&["study", "requirements/exoskeleton_hip.toml", "--out", out.to_str().unwrap(), "--top", "1"]);
    let written: Value = serde_json::from_slice(&std::fs::read(out.join("summary.json")).unwrap()).unwrap();
    assert_eq!((&printed, &printed["command"]), (&written, &Value::from("study")));
    assert!(published().is_valid(&printed));
}

/// No command prints what the schema leaves open: where an object of it names its keys, a key with another type or
/// one that is gone is refused, for every command.
#[test]
fn a_spoiled_answer_of_any_command_does_not_keep_the_schema() {
    let schema = published();
    let mut seen = Vec::new();
    for (arguments, command) in commands() {
        if seen.contains(&command) {
            continue;
        }
        seen.push(command);
        let good = print(&arguments);
        for key in good.as_object().unwrap().keys().filter(|key| *key != "mechanism") {
            let mut bad = good.clone();
            bad[key] = if good[key].is_boolean() { "x".into() } else { true.into() };
            assert!(!schema.is_valid(&bad), "{command}: {key}");
        }
    }
    assert!(seen.len() >= 14, "{seen:?}");
}

/// A key that is gone, or holds something else, is seen: the schema says no to answers that are spoiled.
#[test]
fn a_spoiled_answer_does_not_keep_the_schema() {
    let schema = published();
    let good = print(&["optimize", CHEETAH]);
    let spoil = |path: &str, by: Value| {
        let mut bad = good.clone();
        *bad.pointer_mut(path).unwrap_or_else(|| panic!("{path}")) = by;
        schema.is_valid(&bad)
    };
    assert!(schema.is_valid(&good));
    for (path, by) in [
        ("/command", "sweep --all".into()),
        ("/joints/0/candidates/0/loss_w", "much".into()),
        ("/joints/0/candidates/0/certificate", Value::Null),
        ("/joints/0/rejected/0/because", 7.into()),
        ("/robot/name", Value::Null),
    ] {
        assert!(!spoil(path, by), "{path}");
    }
    for key in ["loss_w", "not_checked", "margins", "mass_kg"] {
        let mut bad = good.clone();
        bad.pointer_mut("/joints/0/candidates/0").unwrap().as_object_mut().unwrap().remove(key);
        assert!(!schema.is_valid(&bad), "{key}");
    }
}

/// What searches the designs of joints has one shape: robot, joints, and in each what became of the motors.
#[test]
fn answers_about_joints_have_the_same_lists_with_the_same_keys_of_a_design() {
    let first = |arguments: &[&str]| {
        let printed = print(arguments);
        assert!(printed["robot"]["name"].is_string(), "{arguments:?}");
        let joint = printed["joints"][0].clone();
        for list in ["candidates", "unjudged", "rejected"] {
            assert!(joint[list].is_array(), "{arguments:?}: {list}");
        }
        joint["candidates"][0].clone()
    };
    let designs = [
        first(&["optimize", CHEETAH]),
        first(&["optimize", CHEETAH, "--pareto", "loss,mass", "--points", "3"]),
        first(&["optimize", CHEETAH, "--robust"]),
        first(&["sweep", CHEETAH, "--ratios", "3"]),
        print(&["explain", "t-motor-ri50", CHEETAH, "--joint", "knee"])["joints"][0]["design"].clone(),
        print(&["check", "requirements/designs/quadruped_mini_cheetah/design.toml"])["joints"][0]["design"].clone(),
    ];
    // Keys that only solving for the ratio, a spring or a tolerance brings are beside those of a sweep.
    let keys: Vec<String> = designs[3].as_object().unwrap().keys().cloned().collect();
    for design in &designs {
        let missing: Vec<&String> = keys.iter().filter(|key| design.get(key.as_str()).is_none()).collect();
        assert!(missing.is_empty(), "{missing:?} in {design}");
    }
}

/// A figure that is declared is in every command's answer, file and page, and can be measured by a rule.
#[test]
fn every_figure_of_a_design_is_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let out = |arguments: &[&str]| {
        let run = Command::new(env!("CARGO_BIN_EXE_gearwise")).args(arguments).current_dir(repository("")).output();
        String::from_utf8(run.unwrap().stdout).unwrap()
    };
    let header =
        |text: String| text.lines().next().unwrap_or_default().split(',').map(String::from).collect::<Vec<_>>();
    let study = folder.path().join("study");
    let hip = "requirements/exoskeleton_hip.toml";
    out(&["study", hip, "--out", study.to_str().unwrap(), "--top", "1"]);
    let headers = [
        header(out(&["optimize", hip, "--csv"])),
        header(out(&["optimize", hip, "--csv", "--pareto", "loss,mass", "--points", "3"])),
        header(out(&["optimize", hip, "--csv", "--robust"])),
        header(out(&["sweep", hip, "--csv", "--ratios", "2"])),
        header(std::fs::read_to_string(study.join("results.csv")).unwrap()),
    ];
    let page = folder.path().join("page.html");
    out(&["optimize", hip, "--html", page.to_str().unwrap()]);
    let page = std::fs::read_to_string(page).unwrap();
    let explained = out(&["explain", "t-motor-ri50", hip]);
    let chosen = print(&["optimize", hip])["joints"][0]["candidates"].clone();
    let answers = [
        chosen[0].clone(),
        print(&["sweep", hip, "--ratios", "2"])["joints"][0]["rejected"][0]["design"].clone(),
        print(&["explain", "t-motor-ri50", hip])["joints"][0]["design"].clone(),
    ];
    for figure in FIGURES {
        assert!(headers.iter().all(|h| h.iter().any(|key| key == figure.key)), "{}: {headers:?}", figure.key);
        assert!(answers.iter().all(|a| a.get(figure.key).is_some()), "{}", figure.key);
        assert!(measure(figure.name).is_some(), "{}", figure.name);
        assert!(!figure.is_of_every_design() || explained.contains(figure.words), "{}", figure.words);
        // A page leaves out what it knows of no design.
        let known = chosen.as_array().unwrap().iter().any(|c| !c[figure.key].is_null());
        assert!(!known || page.contains(&format!(">{}", figure.heading)), "{}", figure.heading);
    }
}
