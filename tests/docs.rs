//! Pages of docs/ that are made from the program: the committed ones are those that it makes, and what they say
//! of files is what the readers know.

mod common;

use std::collections::BTreeSet;
use std::process::Command;

use common::repository;
use gearwise::pages::formats::{BENCH, BENCH_MORE, DESIGN, FITTED, FITTED_AXIS, REQUIREMENT, RULES, Table};

#[test]
fn the_committed_pages_are_what_the_program_makes() {
    let pages = gearwise::cli::pages();
    assert!(pages.len() >= 6);
    for (name, text) in pages {
        let committed = std::fs::read_to_string(repository("docs").join(name)).unwrap_or_default();
        assert!(committed == text, "docs/{name} is not what `cargo run -- docs --out docs` writes");
        assert!(!text.contains("\\["), "{name}: a documentation comment's brackets");
        for line in text.lines().filter(|l| l.starts_with("| ")) {
            assert!(!line.contains("|  |  |  |"), "{name}: an empty row: {line}");
        }
    }
}

#[test]
fn links_between_pages_lead_somewhere() {
    let read = |name: &str| std::fs::read_to_string(repository("docs").join(name)).ok();
    for entry in std::fs::read_dir(repository("docs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "md") {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for link in text.split("](").skip(1).map(|rest| rest.split(')').next().unwrap()) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            if file.starts_with("http") || (!file.is_empty() && !file.ends_with(".md")) {
                continue;
            }
            let target = if file.is_empty() { Some(text.clone()) } else { read(file) };
            let target = target.unwrap_or_else(|| panic!("{}: {link}", path.display()));
            let slug = |h: &str| {
                let kept = h.trim_start_matches('#').trim().to_lowercase();
                kept.chars()
                    .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
                    .collect::<String>()
                    .replace(' ', "-")
            };
            let found = anchor.is_empty() || target.lines().filter(|l| l.starts_with('#')).any(|l| slug(l) == anchor);
            assert!(found, "{}: {link}", path.display());
        }
    }
}

/// Keys that the reader says are valid, by table: asked with a key that nobody knows.
fn known(text: &str, arguments: &[&str]) -> Vec<(String, BTreeSet<String>)> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file.toml"), text).unwrap();
    std::fs::write(folder.path().join("x.csv"), "t,a\n0,1\n").unwrap();
    std::fs::copy(repository("requirements/exoskeleton_hip.toml"), folder.path().join("robot.toml")).unwrap();
    std::fs::create_dir(folder.path().join("motions")).unwrap();
    for entry in std::fs::read_dir(repository("requirements/motions")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join("motions").join(path.file_name().unwrap())).unwrap();
    }
    let output =
        Command::new(env!("CARGO_BIN_EXE_gearwise")).args(arguments).current_dir(folder.path()).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    let mut found = Vec::new();
    for part in message.split("error: ").filter(|p| p.starts_with("unknown key")) {
        let line = part.lines().next().unwrap();
        let path = line.split(" in ").nth(1).unwrap_or("").to_string();
        let valid = part.split("valid here: ").nth(1).unwrap_or_else(|| panic!("{part}"));
        let keys = valid.lines().next().unwrap().split(", ").map(str::to_string).collect();
        found.push((path, keys));
    }
    assert!(!found.is_empty(), "{message}");
    found
}

fn compare(tables: &[Table], known: &[(String, BTreeSet<String>)]) {
    for table in tables {
        let documented: BTreeSet<String> = table.keys.iter().map(|(key, ..)| (*key).to_string()).collect();
        let (_, read) =
            known.iter().find(|(path, _)| path == table.path).unwrap_or_else(|| panic!("{} {known:?}", table.path));
        assert_eq!(&documented, read, "{}: documented on the left, read on the right", table.path);
    }
    for (path, keys) in known {
        assert!(tables.iter().any(|t| t.path == path), "{path} is not documented: {keys:?}");
    }
}

const NO: &str = "qqqqqqqqqqqqqqqqqq = 1";

#[test]
fn requirements_are_documented() {
    let text = format!(
        "{NO}\nname = \"x\"\nbus = {{ voltage = \"1 V\", {NO} }}\n[ambient]\n{NO}\n[budget]\n{NO}\n\
         [mechanism]\nmodel = \"a.urdf\"\ntrajectory = \"x.csv\"\npayload = {{ link = \"a\", mass = \"1 kg\", {NO} }}\n{NO}\n[[joint]]\n{NO}\nname = \"a\"\n\
         ratio = {{ min = 1, max = 2, {NO} }}\ngear = {{ {NO} }}\ndrive = {{ current = \"1 A\", {NO} }}\nobjective = {{ {NO} }}\n\
         reference = {{ {NO} }}\npoints = [ {{ torque = \"1 N*m\", speed = \"0 rad/s\", {NO} }} ]\n[joint.limits]\n{NO}\n\
         torque_bandwidth = {{ frequency = \"1 Hz\", amplitude = \"1 N*m\", {NO} }}\nspring = {{ {NO} }}\n"
    );
    compare(REQUIREMENT, &known(&text, &["optimize", "file.toml"]));
}

#[test]
fn fitted_actuators_are_documented() {
    let text = format!(
        "{NO}\ngearwise = \"0\"\n[motor]\nid = \"m\"\nterminals = \"q_axis\"\ncurrent = \"q_axis\"\nresistance = \"1 ohm\"\n\
         torque_constant = \"1 N*m/A\"\n[gear]\n{NO}\n[covariance]\n{NO}\n[[provenance]]\nlog = \"x\"\n{NO}\n"
    );
    compare(FITTED, &known(&text, &["rank", "file.toml"]));
    let text = format!("gearwise = \"0\"\n[axis]\n{NO}\n");
    compare(FITTED_AXIS, &known(&text, &["rank", "file.toml"]));
}

#[test]
fn designs_are_documented() {
    let text = format!(
        "{NO}\nrequirement = \"robot.toml\"\n[[joint]]\nname = \"hip\"\nmotor = \"t-motor-ri50\"\nratio = 9.0\n{NO}\n"
    );
    compare(DESIGN, &known(&text, &["check", "file.toml"]));
}

#[test]
fn rules_files_are_documented() {
    let text = format!(
        "{NO}\n[[rule]]\nname = \"own\"\nmeasure = \"loss\"\nmax = \"1 W\"\nreason = \"x\"\n{NO}\n\
         [[allow]]\nrule = \"voltage-headroom\"\nreason = \"x\"\n{NO}\n"
    );
    let design = repository("requirements/designs/quadruped_mini_cheetah/design.toml");
    compare(RULES, &known(&text, &["check", design.to_str().unwrap(), "--rules", "file.toml"]));
}

#[test]
fn benches_are_documented() {
    let log = |more: &str| format!("[[log]]\nfile = \"x.csv\"\n{more}\n");
    let text = format!(
        "{NO}\nkind = \"dynamometer\"\nactuator = {{ motor = \"t-motor-ri50\", ratio = 7.5, {NO} }}\n[columns]\n{NO}\n\
         time = {{ name = \"t\", unit = \"s\", {NO} }}\nvelocity = {{ name = \"w\", unit = \"rpm\", {NO} }}\nduty = {{ name = \"d\", {NO} }}\n[load]\n{NO}\n{}",
        log(NO)
    );
    compare(BENCH, &known(&text, &["identify", "file.toml"]));
    let text = format!(
        "kind = \"dynamometer\"\nactuator = {{ motor = \"t-motor-ri50\", ratio = 7.5 }}\n[pendulum]\nmass = \"1 kg\"\nlength = \"1 m\"\n{NO}\n{}",
        log(&format!("select = {{ column = \"t\", equals = \"0\", {NO} }}"))
    );
    compare(BENCH_MORE, &known(&text, &["identify", "file.toml"]));
}
