//! Every command of README.md and docs/*.md runs and prints what is shown there.
//!
//! A line `$ gearwise …` of a console block is a command; what follows it in the block, or in the text block right
//! after it, is what it prints; a line `…` stands for any number of lines. `# exit status 1` says a status that is
//! not 0. A TOML block whose first line is `# NAME.toml` is a file that the reader writes. Files and commands of one page
//! are made and run one after the other in one folder, so that later ones find earlier ones' files.

use crate::common::repository;
use crate::shell::{Workspace, words};

/// What a reader of a page does, and what the page shows of it.
#[derive(Debug, PartialEq)]
enum Step {
    /// Types a command; the lines that the page shows of its output.
    Run(String, Vec<String>),
    /// Writes a file: name, and its lines.
    Write(String, Vec<String>),
}

impl Step {
    fn lines(&mut self) -> &mut Vec<String> {
        match self {
            Step::Run(_, lines) | Step::Write(_, lines) => lines,
        }
    }
}

/// The name in `# NAME.toml`, the first line of a file that the reader writes.
fn file_name(line: &str) -> Option<&str> {
    line.strip_prefix("# ").filter(|name| name.ends_with(".toml") && !name.contains([' ', '/']))
}

/// Files and commands of a page in their order.
fn steps(page: &str) -> Vec<Step> {
    let (mut found, mut block): (Vec<Step>, Option<&str>) = (Vec::new(), None);
    let mut follows = false;
    for line in page.lines() {
        match (block, line.strip_prefix("```")) {
            (None, Some(kind)) => {
                // Text says what the command right before it printed; another block ends that.
                follows &= kind == "text" && matches!(found.last(), Some(Step::Run(_, shown)) if shown.is_empty());
                block = Some(match kind {
                    "text" if !follows => "other",
                    "toml" => "first line of a file",
                    _ => kind,
                });
            }
            (Some(kind), Some(_)) => {
                follows = kind == "console";
                block = None;
            }
            (Some("first line of a file"), None) => {
                block = Some(if let Some(name) = file_name(line) {
                    found.push(Step::Write(name.into(), Vec::new()));
                    "file"
                } else {
                    "other"
                });
            }
            (Some("console"), None) => match line.strip_prefix("$ ") {
                Some(command) => found.push(Step::Run(command.into(), Vec::new())),
                None => found
                    .last_mut()
                    .unwrap_or_else(|| panic!("output before a command: {line}"))
                    .lines()
                    .push(line.trim_end().into()),
            },
            (Some("text" | "file"), None) => found.last_mut().unwrap().lines().push(line.trim_end().into()),
            (Some(_), None) => {}
            (None, None) => follows &= line.trim().is_empty(),
        }
    }
    found
}

/// Whether the lines are shown in their order, `…` for any number of them; the first place where not.
fn compare(shown: &[String], printed: &str) -> Result<(), String> {
    let printed: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let mut at = 0;
    for (index, part) in shown.split(|l| l == "…").enumerate() {
        if part.is_empty() {
            continue;
        }
        let here = |start: usize| {
            printed[start..].iter().zip(part).all(|(p, s)| p == s) && start + part.len() <= printed.len()
        };
        let start = if index == 0 { Some(0).filter(|s| here(*s)) } else { (at..printed.len()).find(|s| here(*s)) };
        let start =
            start.ok_or_else(|| format!("not printed:\n{}\n\nprinted:\n{}", part.join("\n"), printed.join("\n")))?;
        at = start + part.len();
    }
    Ok(())
}

#[test]
fn every_command_of_the_documentation_prints_what_is_shown() {
    let mut pages = vec!["README.md".to_string()];
    let mut docs: Vec<String> = std::fs::read_dir(repository("docs"))
        .unwrap()
        .map(|e| format!("docs/{}", e.unwrap().file_name().to_str().unwrap()))
        .filter(|p| p.ends_with(".md"))
        .collect();
    docs.sort();
    pages.extend(docs);
    let (mut wrote, mut ran, mut compared, mut wrong) = (0, 0, 0, Vec::new());
    for page in pages {
        let workspace = Workspace::new();
        for step in steps(&std::fs::read_to_string(repository(&page)).unwrap()) {
            let (command, shown) = match step {
                Step::Run(command, shown) => (command, shown),
                Step::Write(name, lines) => {
                    std::fs::write(workspace.path(&name), lines.join("\n")).unwrap();
                    wrote += 1;
                    continue;
                }
            };
            let all = words(&command);
            let arguments = match all.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
                ["gearwise", ..] => &all[1..],
                ["cargo", "run", ..] => {
                    &all[all.iter().position(|w| w == "--").expect("cargo run … -- arguments") + 1..]
                }
                _ => continue,
            };
            let expected = command.split("# exit status ").nth(1).map_or(0, |s| s.trim().parse().unwrap());
            let output = workspace.run(arguments);
            let said = String::from_utf8_lossy(&output.stderr);
            if output.status.code() != Some(expected) {
                let status = output.status.code();
                wrong.push(format!("{page}: $ {command}\nexit status {status:?}, {expected} expected\n{said}"));
                continue;
            }
            ran += 1;
            if !shown.is_empty() {
                let printed = if expected == 2 { said.into_owned() } else { String::from_utf8(output.stdout).unwrap() };
                if let Err(why) = compare(&shown, &printed) {
                    wrong.push(format!("{page}: $ {command}\n{why}"));
                }
                compared += 1;
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n----\n\n"));
    let read = wrote >= 2 && ran >= 25 && compared >= 18;
    assert!(read, "{wrote} files, {ran} commands, {compared} with output: the pages are not read right");
}

/// The first page is read in a minute; what is longer has a page of its own in docs/.
#[test]
fn the_first_page_stays_short() {
    let lines = std::fs::read_to_string(repository("README.md")).unwrap().lines().count();
    assert!(lines <= 150, "README.md has {lines} lines");
}

#[test]
fn the_comparison_sees_a_wrong_line() {
    let shown = |text: &str| text.lines().map(str::to_string).collect::<Vec<_>>();
    assert!(compare(&shown("a\nb"), "a\nb\nc").is_ok());
    assert!(compare(&shown("b"), "a\nb").is_err(), "the first line is the first");
    assert!(compare(&shown("…\nb\n…\nd"), "a\nb\nc\nd").is_ok());
    assert!(compare(&shown("…\nb\nd"), "a\nb\nc\nd").is_err(), "nothing is left out unsaid");
    assert!(compare(&shown("a\n…\ne"), "a\nb").is_err());
    let page = "```console\n$ gearwise rank  # exit status 1\n```\n\n```text\n…\nx\n```\nand\n```text\ny\n```\n";
    assert_eq!(steps(page), [Step::Run("gearwise rank  # exit status 1".into(), vec!["…".into(), "x".into()])]);
    let page = "```toml\n# a.toml\nb = 1\n```\n```toml\n# a.toml, in part\n```\n```toml\nc = 1\n```\n";
    assert_eq!(steps(page), [Step::Write("a.toml".into(), vec!["b = 1".into()])]);
    assert_eq!(words("gearwise export a@9 'b c' --x # why"), ["gearwise", "export", "a@9", "b c", "--x"]);
}
