//! `-` is standard input: the same answer as of the file, relative paths from the working directory, and once only.

use std::fs;

use super::folder::{DESIGN, MOTORS, REQUIREMENT, RULES, folder, run, run_with};

#[test]
fn a_file_on_standard_input_is_read_as_one_on_disk() {
    let folder = folder();
    for (command, dashed, text) in [
        (&["optimize", "robot.toml", "--catalog", "motors.csv"][..], "robot.toml", REQUIREMENT),
        (&["optimize", "robot.toml", "--catalog", "motors.csv", "--json"], "motors.csv", MOTORS),
        (&["sweep", "robot.toml", "--catalog", "motors.csv", "--csv"], "robot.toml", REQUIREMENT),
        (&["explain", "alpha-1@9", "robot.toml", "--catalog", "motors.csv"], "robot.toml", REQUIREMENT),
        (&["export", "alpha-1@9", "robot.toml", "--catalog", "motors.csv", "--to", "urdf"], "robot.toml", REQUIREMENT),
        (&["check", "design.toml", "--rules", "rules.toml"], "rules.toml", RULES),
        (&["rank", "motors.csv"], "motors.csv", MOTORS),
        (&["audit", "motors.csv"], "motors.csv", MOTORS),
    ] {
        let file = run(&folder, command);
        let dashes: Vec<&str> = command.iter().map(|a| if *a == dashed { "-" } else { *a }).collect();
        let stdin = run_with(&folder, &dashes, text.as_bytes());
        assert_eq!(stdin.status, file.status, "{command:?}: {}", stdin.err);
        assert!(file.status < 2, "{command:?}: {}", file.err);
        assert_eq!(stdin.out.replace("<stdin>", dashed).replace("&lt;stdin&gt;", dashed), file.out, "{command:?}");
    }
    // A design is checked without a lock.
    let file = run(&folder, &["check", "design.toml", "--json"]);
    let stdin = run_with(&folder, &["check", "-", "--json"], DESIGN.as_bytes());
    assert_eq!(stdin.status, file.status, "{}", stdin.err);
    assert_eq!(stdin.out.matches("\"code\"").count(), file.out.matches("\"code\"").count());
}

#[test]
fn a_study_file_may_come_on_standard_input() {
    let folder = folder();
    let study =
        "requirement = \"robot.toml\"\ncatalog = [\"motors.csv\"]\n[grid]\n\"bus.voltage\" = [\"24 V\", \"48 V\"]\n";
    let ran = run_with(&folder, &["study", "-", "--out", "a"], study.as_bytes());
    assert_eq!(ran.status, 0, "{}", ran.err);
    fs::write(folder.path().join("study.toml"), study).unwrap();
    assert_eq!(run(&folder, &["study", "study.toml", "--out", "b"]).status, 0);
    let results = |name: &str| fs::read_to_string(folder.path().join(name).join("results.csv")).unwrap();
    assert_eq!(results("a"), results("b"));
    let ran = run_with(&folder, &["study", "-", "--out", "c"], REQUIREMENT.as_bytes());
    assert!(ran.status == 2 && ran.err.contains("a study file only"), "{}", ran.err);
}

#[test]
fn what_standard_input_cannot_do_is_refused() {
    let folder = folder();
    let with = |arguments: &[&str], text: &str| run_with(&folder, arguments, text.as_bytes());
    let catalog = ["--catalog", "motors.csv"];
    for (arguments, text, said) in [
        (vec!["optimize", "-", "--catalog", "-"], REQUIREMENT, "only once"),
        (vec!["optimize", "-", "--catalog=-"], REQUIREMENT, "only once"),
        (vec!["optimize", "-"], "", "nothing came on standard input"),
        (
            [&["optimize", "-"], &catalog[..], &["--write-design", "d.toml"]].concat(),
            REQUIREMENT,
            "names the requirement",
        ),
        ([&["optimize", "-"], &catalog[..], &["--rules", "rules.toml"]].concat(), REQUIREMENT, "in place of `-`"),
        (vec!["optimize", "robot.toml", "--catalog", "-", "--write-design", "d.toml"], MOTORS, "names the catalogue"),
        (vec!["check", "-", "--lock"], DESIGN, "a lock is a file next to the design"),
        (vec!["optimize", "-"], "\u{0}\u{0}", "bytes that are zero"),
        // Mistakes have their line.
        (vec!["optimize", "-"], "name = \"leg\"\n[bus]\nvoltag = 1\n", "<stdin>:3:1"),
    ] {
        let ran = with(&arguments, text);
        assert_eq!(ran.status, 2, "{arguments:?}: {}", ran.out);
        assert!(ran.err.contains(said), "{arguments:?}: {}", ran.err);
        assert!(!folder.path().join("d.toml").exists());
    }
}
