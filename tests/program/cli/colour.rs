//! Colours of a terminal: they add nothing but colour, say no more than the text, and reach no file.

use std::process::Command;

use crate::cases::few;

const ROBOT: &str = "requirements/quadruped_mini_cheetah.toml";

fn run(words: &[&str], colours: &[(&str, &str)]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gearwise"));
    command.args(words).current_dir(env!("CARGO_MANIFEST_DIR")).env("COLUMNS", "80");
    for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "TERM"] {
        command.env_remove(name);
    }
    let output = command.envs(colours.iter().copied()).output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// The text with the colour of each part: parts and codes.
fn parts(text: &str) -> Vec<(u8, String)> {
    let mut parts = Vec::new();
    for (k, part) in text.split("\u{1b}[").enumerate() {
        let (code, rest) = if k == 0 { ("39", part) } else { part.split_once('m').unwrap() };
        parts.push((code.parse().unwrap(), rest.to_string()));
    }
    parts
}

#[test]
fn colours_add_nothing_but_colour() {
    const DESIGN: &str = "requirements/designs/quadruped_mini_cheetah/design.toml";
    let all =
        [&["explain", "t-motor-ri50", ROBOT, "--joint", "knee"][..], &["check", DESIGN], &["optimize", ROBOT, "--why"]];
    for words in few(2, all) {
        let plain = run(words, &[]);
        assert!(!plain.contains('\u{1b}'), "a pipe has no colours");
        let coloured = run(words, &[("CLICOLOR_FORCE", "1")]);
        assert_ne!(coloured, plain);
        let without: String = parts(&coloured).into_iter().map(|(_, text)| text).collect();
        assert_eq!(without, plain, "{words:?}");
        assert_eq!(run(words, &[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]), plain);
        assert_eq!(run(words, &[("CLICOLOR_FORCE", "0")]), plain);
    }
    for form in few(1, ["--csv", "--json"]) {
        let words = ["optimize", ROBOT, form];
        assert_eq!(run(&words, &[("CLICOLOR_FORCE", "1")]), run(&words, &[]));
    }
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.html", "b.html"].map(|name| folder.path().join(name));
    run(&["optimize", ROBOT, "--html", a.to_str().unwrap()], &[("CLICOLOR_FORCE", "1")]);
    run(&["optimize", ROBOT, "--html", b.to_str().unwrap()], &[]);
    assert!(std::fs::read(a).unwrap() == std::fs::read(b).unwrap(), "pages do not depend on the terminal");
}

/// Green is a limit that is kept with a reserve: never one at which the design stands, and never what is not known.
#[test]
fn green_is_nothing_that_is_near_or_unknown() {
    // A limit on mass that is the mass of the first choice.
    let at_its_limit = ["optimize", ROBOT, "--set", "joint.hip.limits.actuator_mass=0.54 kg"];
    let answer = parts(&run(&at_its_limit, &[("CLICOLOR_FORCE", "1")]));
    let of = |code: u8| answer.iter().filter(move |(c, _)| *c == code).map(|(_, text)| text.as_str());
    assert!(of(33).any(|text| text.ends_with(" 0 %")), "at its limit");
    assert!(of(32).all(|text| text.contains('%') && !text.ends_with(" 0 %")), "{answer:?}");
    for code in [32, 39] {
        assert!(of(code).all(|text| !text.contains("not checked") && !text.contains("cannot be judged")));
    }
    let words = ["explain", "t-motor-ri50", ROBOT, "--joint", "knee"];
    let story = parts(&run(&words, &[("CLICOLOR_FORCE", "1")]));
    let exceeded: Vec<&str> = story.iter().filter(|(c, _)| *c == 31).map(|(_, text)| text.as_str()).collect();
    assert!(!exceeded.is_empty() && exceeded.iter().all(|text| text.starts_with('-')), "{exceeded:?}");
}
