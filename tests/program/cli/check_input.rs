//! `check` with a wrong input: every form that a machine reads holds the mistakes, with their places, whatever file is wrong.

use std::fs;

use serde_json::Value;

use super::folder::{DESIGN, MOTORS, REQUIREMENT, RULES, folder, run};

/// File, its text spoilt, and the line of the mistake; none for a mistake of the whole file.
fn spoilt() -> Vec<(&'static str, String, Option<u64>, &'static str)> {
    vec![
        ("robot.toml", REQUIREMENT.replace("voltage =", "voltag ="), Some(3), "unknown key `voltag`"),
        ("robot.toml", super::folder::MOTION.into(), None, "this is a motion"),
        ("knee.csv", super::folder::MOTION.replace("2.0,  1.5", "two,  1.5"), Some(3), "two"),
        ("design.toml", DESIGN.replace("ratio = 9", "ratoi = 9"), Some(7), "unknown key `ratoi`"),
        ("design.toml", DESIGN.replace("alpha-1", "alpha-9"), Some(6), "there is no motor `alpha-9`"),
        ("rules.toml", RULES.replace("min", "mni"), Some(3), "unknown key `mni`"),
        ("motors.csv", MOTORS.replace("0.5,0.2", "0.5,-0.2"), Some(2), "inductance"),
        ("motors.csv", MOTORS.lines().next().unwrap().to_string() + "\n", Some(1), "has a header but no rows"),
    ]
}

#[test]
fn every_form_of_a_wrong_input_has_the_mistake_and_its_place() {
    for (file, text, line, said) in spoilt() {
        let folder = folder();
        fs::write(folder.path().join(file), text).unwrap();
        let check = |more: &[&str]| {
            let ran = run(&folder, &[&["check", "design.toml", "--rules", "rules.toml"], more].concat());
            assert_eq!(ran.status, 2, "{file} {said}: {}{}", ran.out, ran.err);
            ran
        };
        let ran = check(&["--sarif", "a.sarif", "--junit", "a.xml", "--github"]);
        assert!(ran.err.contains(said), "{file}: {}", ran.err);
        let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();

        let annotation =
            ran.out.lines().find(|l| l.contains(said)).unwrap_or_else(|| panic!("{file} {said}: {}", ran.out));
        assert!(annotation.starts_with("::error file="), "{annotation}");
        let junit = read("a.xml");
        assert!(junit.contains("errors=\"1\"") && junit.contains(said), "{junit}");
        let sarif: Value = serde_json::from_str(&read("a.sarif")).unwrap();
        let results = sarif["runs"][0]["results"].as_array().unwrap();
        let of = |r: &&Value| r["message"]["text"].as_str().unwrap().contains(said);
        let result = results.iter().find(of).unwrap_or_else(|| panic!("{file} {said}: {sarif}"));
        assert_eq!(result["level"], "error");
        assert_eq!(sarif["runs"][0]["invocations"][0]["executionSuccessful"], false);
        let json: Value = serde_json::from_str(&check(&["--json"]).out).unwrap();
        assert_eq!(json["passes"], false);
        let errors = json["input_errors"].as_array().unwrap();
        let error = errors.iter().find(|e| e["message"].as_str().unwrap().contains(said) || said == "two");
        let error = error.unwrap_or_else(|| panic!("{file} {said}: {json}"));
        assert_eq!(error["line"].as_u64(), line, "{file} {said}: {error}");
        if let Some(line) = line {
            let physical = &result["locations"][0]["physicalLocation"];
            assert_eq!(physical["region"]["startLine"].as_u64(), Some(line), "{physical}");
            assert!(physical["artifactLocation"]["uri"].as_str().unwrap().ends_with(file), "{physical}");
            assert!(annotation.contains(&format!("line={line}")) && annotation.contains(file), "{annotation}");
            assert!(junit.contains(&format!("{file}:{line}:")), "{junit}");
        }
    }
}

/// A mistake that stands in no file is told at the design.
#[test]
fn a_wrong_option_is_told_in_every_form() {
    let folder = folder();
    let ran =
        run(&folder, &["check", "design.toml", "--set", "voltage", "--sarif", "a.sarif", "--junit", "a.xml", "--json"]);
    assert_eq!(ran.status, 2);
    for text in [ran.out, read_text(&folder, "a.sarif"), read_text(&folder, "a.xml")] {
        assert!(text.contains("write KEY=VALUE") && text.contains("design.toml"), "{text}");
    }
}

fn read_text(folder: &tempfile::TempDir, name: &str) -> String {
    fs::read_to_string(folder.path().join(name)).unwrap()
}

/// Yesterday's files are not left standing, and a good input leaves none of this.
#[test]
fn a_good_input_leaves_no_input_error() {
    let folder = folder();
    let ran = run(&folder, &["check", "design.toml", "--sarif", "a.sarif", "--junit", "a.xml", "--json"]);
    assert!(ran.status < 2, "{}", ran.err);
    for name in ["a.sarif", "a.xml"] {
        assert!(!fs::read_to_string(folder.path().join(name)).unwrap().contains("wrong-input"));
    }
    assert!(!ran.out.contains("input_errors"));
}
