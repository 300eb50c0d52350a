//! Manual pages and completions.

use clap::Command;

use crate::shell::Workspace;

fn commands() -> Vec<Command> {
    let mut top = gearwise::cli::command();
    top.build();
    top.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()).cloned().collect()
}

#[test]
fn completions_for_every_shell_know_every_command() {
    let workspace = Workspace::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = workspace.run(&["completions".into(), shell.into()]);
        assert_eq!(output.status.code(), Some(0));
        let text = String::from_utf8(output.stdout).unwrap();
        for command in commands() {
            assert!(text.contains(command.get_name()), "{shell}: {}", command.get_name());
        }
        assert!(text.contains("reflected_inertia") || text.contains("pareto"), "{shell} knows options");
    }
}

#[test]
fn manual_pages_of_all_commands() {
    let workspace = Workspace::new();
    let run = || workspace.run(&["man".into(), "--out".into(), "share/man1".into()]);
    let output = run();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let read = |name: &str| std::fs::read_to_string(workspace.path("share/man1").join(name)).unwrap();
    for command in commands() {
        let page = read(&format!("gearwise-{}.1", command.get_name()));
        let (examples, options) = (page.find(".SH EXAMPLES").unwrap(), page.find(".SH OPTIONS").unwrap());
        assert!(examples < options, "{page}");
        let name = command.get_name().replace('-', "\\-");
        assert!(page.contains(&format!("gearwise\\-{name}")), "{page}");
        // No line of text is taken for a request.
        let requests = page.lines().filter(|l| l.starts_with('.') || l.starts_with('\''));
        for line in requests {
            assert!(
                [".TH", ".SH", ".TP", ".nf", ".fi", ".ie", ".el", ".RS", ".RE", ".br", ".SS", ".PP", ".IP"]
                    .iter()
                    .any(|r| line.starts_with(r)),
                "{line}"
            );
        }
    }
    assert!(read("gearwise.1").contains("optimize"));
    let first = read("gearwise-optimize.1");
    run();
    assert_eq!(read("gearwise-optimize.1"), first);
    // A folder that cannot be.
    let output = workspace.run(&["man".into(), "--out".into(), "robot.toml/x".into()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cannot make the folder"));
}
