//! Every command of README.md and docs/*.md runs and prints what is shown there.
//!
//! A line `$ gearwise …` of a console block is a command; what follows it in the block, or in the text block right
//! after it, is what it prints; a line `…` stands for any number of lines. `# exit status 1` says a status that is
//! not 0. Commands of one page run one after the other in one folder, so that later ones find earlier ones' files.

mod common;
mod shell;

use common::repository;
use shell::{Workspace, words};

#[derive(Debug)]
struct Shown {
    command: String,
    output: Vec<String>,
}

/// Commands of a page with the lines that it shows of their output.
fn commands(page: &str) -> Vec<Shown> {
    let (mut found, mut block): (Vec<Shown>, Option<&str>) = (Vec::new(), None);
    let mut follows = false;
    for line in page.lines() {
        match (block, line.strip_prefix("```")) {
            (None, Some(kind)) => {
                // Text says what the command right before it printed; another block ends that.
                follows &= kind == "text" && found.last().is_some_and(|s| s.output.is_empty());
                block = Some(if kind == "text" && !follows { "other" } else { kind });
            }
            (Some(kind), Some(_)) => {
                follows = kind == "console";
                block = None;
            }
            (Some("console"), None) => match line.strip_prefix("$ ") {
                Some(command) => found.push(Shown { command: command.into(), output: Vec::new() }),
                None => found
                    .last_mut()
                    .unwrap_or_else(|| panic!("output before a command: {line}"))
                    .output
                    .push(line.trim_end().into()),
            },
            (Some("text"), None) => found.last_mut().unwrap().output.push(line.trim_end().into()),
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
    let (mut ran, mut compared, mut wrong) = (0, 0, Vec::new());
    for page in pages {
        let workspace = Workspace::new();
        for shown in commands(&std::fs::read_to_string(repository(&page)).unwrap()) {
            let all = words(&shown.command);
            let arguments = match all.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
                ["gearwise", ..] => &all[1..],
                ["cargo", "run", ..] => {
                    &all[all.iter().position(|w| w == "--").expect("cargo run … -- arguments") + 1..]
                }
                _ => continue,
            };
            let expected = shown.command.split("# exit status ").nth(1).map_or(0, |s| s.trim().parse().unwrap());
            let output = workspace.run(arguments);
            let said = String::from_utf8_lossy(&output.stderr);
            if output.status.code() != Some(expected) {
                wrong.push(format!(
                    "{page}: $ {}\nexit status {:?}, {expected} expected\n{said}",
                    shown.command,
                    output.status.code()
                ));
                continue;
            }
            ran += 1;
            if !shown.output.is_empty() {
                let printed = if expected == 2 { said.into_owned() } else { String::from_utf8(output.stdout).unwrap() };
                if let Err(why) = compare(&shown.output, &printed) {
                    wrong.push(format!("{page}: $ {}\n{why}", shown.command));
                }
                compared += 1;
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n----\n\n"));
    assert!(ran >= 10 && compared >= 6, "{ran} commands, {compared} with output: the pages are not read right");
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
    let found = commands(page);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].output, ["…", "x"]);
    assert_eq!(words("gearwise export a@9 'b c' --x # why"), ["gearwise", "export", "a@9", "b c", "--x"]);
}
