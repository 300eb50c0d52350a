//! Help: every command begins with examples, and the examples are true.

use clap::Command;

use crate::shell::{Workspace, words};

fn commands() -> Vec<Command> {
    let mut top = gearwise::cli::command();
    top.build();
    let subs: Vec<Command> = top.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect();
    assert!(subs.len() >= 12);
    std::iter::once(top).chain(subs).collect()
}

fn examples(help: &str) -> Vec<String> {
    let lines = help.lines().skip_while(|l| *l != "Examples:").skip(1).take_while(|l| l.starts_with("  "));
    lines.map(|l| l.trim().to_string()).collect()
}

#[test]
fn every_help_starts_with_examples_that_the_program_understands() {
    for mut command in commands() {
        let name = command.get_name().to_string();
        let help = command.render_long_help().to_string();
        let own = if name == "gearwise" { String::new() } else { format!("{name} ") };
        let alone = help.starts_with(&format!("Examples:\n  gearwise {name}\n"));
        assert!(alone || help.starts_with(&format!("Examples:\n  gearwise {own}")), "{name}:\n{help}");
        let examples = examples(&help);
        assert!(!examples.is_empty(), "{name}");
        for example in examples {
            assert!(example.starts_with("gearwise "), "{name}: {example}");
            let parsed = gearwise::cli::command().try_get_matches_from(words(&example));
            assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
        }
    }
}

#[test]
fn examples_with_shipped_files_run() {
    let workspace = Workspace::new();
    let mut ran = 0;
    for mut command in commands() {
        let name = command.get_name().to_string();
        // What `merge` puts together is what studies leave.
        if matches!(name.as_str(), "docs" | "import" | "merge")
            || matches!(name.as_str(), "man" | "completions") && !cfg!(feature = "packaging")
        {
            continue;
        }
        for example in examples(&command.render_long_help().to_string()) {
            let words = words(&example);
            // A shell would know the home folder; files of the reader that nobody ships are left out.
            let is_file =
                |w: &&String| [".toml", ".csv", ".xml", ".urdf"].iter().any(|e| w.ends_with(e)) || w.contains('/');
            let mut after_out = false;
            let inputs = words.iter().filter(|word| {
                let output = std::mem::replace(
                    &mut after_out,
                    ["--out", "--plot", "--write", "--html", "--sarif", "--junit", "--csv", "--write-design"]
                        .contains(&word.as_str()),
                );
                !output && is_file(word)
            });
            if words.iter().any(|w| w.contains('~')) || !inputs.into_iter().all(|w| workspace.path(w).exists()) {
                continue;
            }
            // A page is served until somebody ends it.
            if name == "explore" && !words.iter().any(|word| word == "--static") {
                continue;
            }
            let output = workspace.run(&words[1..]);
            let status = output.status.code();
            assert!(matches!(status, Some(0 | 1)), "{example}: {status:?} {}", String::from_utf8_lossy(&output.stderr));
            assert!(!output.stdout.is_empty(), "{example}");
            ran += 1;
        }
    }
    assert!(ran >= 20, "only {ran} examples have files that are shipped");
}

#[test]
#[cfg(not(feature = "packaging"))]
fn what_a_build_lacks_is_one_line_with_the_command_that_adds_it() {
    let workspace = Workspace::new();
    for (line, what) in [("completions bash", "completions for bash"), ("man --out share", "manual pages")] {
        let arguments: Vec<String> = line.split(' ').map(str::to_string).collect();
        let output = workspace.run(&arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(what) && said.contains("`cargo install --path . --features full`"), "{said}");
        assert_eq!(said.trim().lines().count(), 1, "{said}");
    }
}
