//! The catalogue in the user's hands: words among paths, rows next to the built-in ones, filters, twin rows.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

const MINE: &str = "id,manufacturer,construction,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],source,source_kind\n\
mine-1,My Lab,outrunner,line_to_line,phase_amplitude,0.2,0.1,800,300,bench,measured\n";

fn robot(more: &str) -> String {
    format!(
        "name = \"leg\"\n[bus]\nvoltage = \"48 V\"\n[[joint]]\nname = \"knee\"\nratio = {{ min = 3, max = 30 }}\n\
         gear = {{ efficiency = 0.9, mass = \"200 g\" }}\nobjective = \"loss\"\n{more}\n\
         points = [ {{ torque = \"3 N*m\", speed = \"6 rad/s\", duration = \"0.3 s\" }}, {{ torque = \"0 N*m\", speed = \"-3 rad/s\", duration = \"0.6 s\" }} ]\n"
    )
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
    command.env("GEARWISE_CATALOG", "mine.csv").args(arguments).current_dir(folder).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Ids of all motors of the joint, whatever became of them.
fn motors(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let output = run(folder, &[&["optimize", "robot.toml", "--json"], arguments].concat());
    let found: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {}", said(&output)));
    let joint = &found["joints"][0];
    let list = |name: &str| joint[name].as_array().unwrap().clone();
    let all = [list("candidates"), list("unjudged"), list("rejected")].concat();
    all.iter().map(|m| m["motor"].as_str().unwrap().to_string()).collect()
}

#[test]
fn builtin_and_user_are_words_and_also_adds() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("mine.csv"), MINE).unwrap();
    fs::write(at.join("robot.toml"), robot("")).unwrap();
    let builtin = motors(at, &[]).len();
    assert_eq!(motors(at, &["--catalog", "mine.csv"]), ["mine-1"]);
    assert_eq!(motors(at, &["--catalog", "user"]), ["mine-1"]);
    for both in [&["--catalog", "builtin", "mine.csv"][..], &["--also", "mine.csv"], &["--catalog", "builtin", "user"]]
    {
        let all = motors(at, both);
        assert!(all.len() == builtin + 1 && all.contains(&"mine-1".to_string()), "{both:?}");
    }
    // A file of that name is ./builtin.
    fs::write(at.join("builtin"), MINE).unwrap();
    assert_eq!(motors(at, &["--catalog", "./builtin"]), ["mine-1"]);
    assert_eq!(motors(at, &["--catalog", "builtin"]).len(), builtin);
    // A design keeps the words.
    let output = run(at, &["optimize", "robot.toml", "--also", "mine.csv", "--write-design", "design.toml"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert!(fs::read_to_string(at.join("design.toml")).unwrap().contains("catalog = [\"builtin\", \"mine.csv\"]"));
    assert_eq!(run(at, &["check", "design.toml"]).status.code(), Some(0));
    let output = run(at, &["optimize", "robot.toml", "--also", "nothing.csv"]);
    assert!(output.status.code() == Some(2) && said(&output).contains("no such file"), "{}", said(&output));
}

#[test]
fn a_requirement_filters_by_id_and_maker() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("mine.csv"), MINE).unwrap();
    fs::write(at.join("robot.toml"), robot("motors = [\"maxon-ec-*\", \"my lab\"]\nexclude = [\"*-flat-*\"]")).unwrap();
    let output = run(at, &["optimize", "robot.toml", "--json", "--also", "mine.csv"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let joint = &found["joints"][0];
    let allowed = |id: &str| id == "mine-1" || id.starts_with("maxon-ec-") && !id.contains("-flat-");
    let (mut left_out, mut others) = (0, 0);
    for (list, chosen) in [("candidates", true), ("unjudged", true), ("rejected", false)] {
        for motor in joint[list].as_array().unwrap() {
            let id = motor["motor"].as_str().unwrap();
            let because = motor["because"].as_str().unwrap_or_default();
            let refused = because.contains("the requirement does not allow it");
            assert_eq!(refused, !allowed(id), "{list}: {id}: {because}");
            assert!(!chosen || allowed(id), "{list}: {id}");
            left_out += usize::from(refused);
            others += usize::from(!refused);
        }
    }
    assert!(left_out > 60 && others > 20, "{left_out} {others}");
    // One that is not allowed is none in any command, and a pattern that matches nothing is a mistake.
    let output = run(at, &["explain", "t-motor-u8-lee", "robot.toml", "--also", "mine.csv"]);
    assert!(output.status.code() == Some(2) && said(&output).contains("does not allow"), "{}", said(&output));
    fs::write(at.join("robot.toml"), robot("motors = [\"u8\"]")).unwrap();
    let output = run(at, &["optimize", "robot.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        said(&output).contains("no motor of the catalogue matches `u8`; there are t-motor-u8"),
        "{}",
        said(&output)
    );
    let output = run(at, &["explain", "ec-i-52", "robot.toml"]);
    fs::write(at.join("robot.toml"), robot("")).unwrap();
    assert_eq!(output.status.code(), Some(2));
    let output = run(at, &["explain", "ec-i-52", "robot.toml"]);
    assert!(said(&output).contains("`maxon-ec-i-52-574741`"), "{}", said(&output));
}

#[test]
fn of_twin_rows_one_counts_and_circles_are_mistakes() {
    let folder = tempfile::tempdir().unwrap();
    let rows = |pairs: &[(&str, &str)]| {
        let row = |(id, twin): &(&str, &str)| format!("{id},{twin},q_axis,q_axis,1,1,s,derived\n");
        let header = "id,same_as,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind\n";
        fs::write(folder.path().join("rows.csv"), header.to_string() + &pairs.iter().map(row).collect::<String>())
            .unwrap();
        run(folder.path(), &["rank", "rows.csv", "--json"])
    };
    for wrong in [&[("a", "a")][..], &[("a", "b"), ("b", "a")], &[("a", "b"), ("b", "c"), ("c", "")]] {
        let output = rows(wrong);
        assert!(output.status.code() == Some(2) && said(&output).contains("same_as"), "{wrong:?}: {}", said(&output));
    }
    let output = rows(&[("a", "b"), ("b", ""), ("c", "elsewhere")]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    let list = |name: &str| found[name].as_array().unwrap().len();
    assert_eq!(list("motors") + list("not_ranked"), 2);
}
