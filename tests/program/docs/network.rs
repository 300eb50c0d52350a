//! No command needs a network. clippy.toml forbids sockets outside of `explore`, which listens on loopback.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::repository;

/// The Rust files below a folder, with their code: comments and tests are taken away.
fn sources(folder: &Path) -> Vec<(PathBuf, String)> {
    let mut all = Vec::new();
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            all.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && path.file_name().is_some_and(|name| name != "tests.rs")
        {
            let text = fs::read_to_string(&path).unwrap();
            let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default().to_string();
            let code = text.lines().map(|line| line.find("//").map_or(line, |at| &line[..at]));
            all.push((path, code.collect::<Vec<_>>().join("\n")));
        }
    }
    all
}

/// The explorer brings neither files nor sockets, clocks or threads: whoever asks it does.
#[test]
fn the_explorer_knows_no_system() {
    for (path, code) in sources(&repository("src/explore")) {
        for room in ["fs", "net", "time", "thread", "process", "env"] {
            assert!(!code.contains(&format!("std::{room}")), "{}: std::{room}", path.display());
        }
    }
}

/// Runs the program where there is no network at all; `None` where the system allows no such place.
fn without_network(arguments: &[&str]) -> Option<Output> {
    let run = |program: &[&str]| {
        let mut command = Command::new("unshare");
        command
            .args(["--map-root-user", "--net", "--"])
            .args(program)
            .current_dir(repository(""))
            .env_remove("COLUMNS");
        command.output().ok()
    };
    run(&["true"]).filter(|tried| tried.status.success())?;
    run(&[&[env!("CARGO_BIN_EXE_gearwise")], arguments].concat())
}

#[test]
fn every_other_command_runs_without_a_network() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let robot = "requirements/exoskeleton_hip.toml";
    let design = "requirements/designs/quadruped_mini_cheetah/design.toml";
    let (study, rest) = (out("study"), out("rest"));
    let commands: &[(&str, &[&str])] = &[
        ("optimize", &[robot]),
        ("explain", &["t-motor-ri50", robot]),
        ("sweep", &[robot, "--ratios", "3"]),
        ("study", &[robot, "--out", &study]),
        ("merge", &["--out", &rest, &study]),
        ("rank", &[]),
        ("compare", &["t-motor-ri50", "t-motor-u8"]),
        ("catalog", &["list"]),
        ("audit", &[]),
        ("check", &[design]),
        ("check-model", &["--help"]),
        ("rule", &["voltage-headroom"]),
        ("identify", &["requirements/bench/leg_actuator.toml"]),
        ("torques", &["--help"]),
        ("characterize", &["requirements/bench/motor_on_bench.toml"]),
        ("export", &[design, "--to", "mjcf"]),
        ("import", &["--help"]),
        ("man", &["--help"]),
        ("docs", &["--help"]),
        ("completions", &["--help"]),
    ];
    let clap = gearwise::cli::command();
    let named: Vec<&str> =
        clap.get_subcommands().map(|c| c.get_name()).filter(|name| !["explore", "help"].contains(name)).collect();
    for name in &named {
        assert!(commands.iter().any(|(other, _)| other == name), "`{name}` is not looked at");
    }
    for (name, arguments) in commands {
        let Some(output) = without_network(&[&[*name], *arguments].concat()) else {
            println!("not tried: this system allows no namespace without a network");
            return;
        };
        let said = String::from_utf8_lossy(&output.stderr).to_string();
        assert!(output.status.code().is_some_and(|code| code < 2) || *name == "merge", "{name}: {said}");
        assert!(!said.to_lowercase().contains("network") && !said.contains("panicked"), "{name}: {said}");
    }
}
