//! The floors of the house: a room imports from rooms above it only, and lib.rs, ARCHITECTURE.md and the code name
//! the same rooms in the same order.

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use common::repository;

/// Every room, from the top: each may import from those before it.
const ROOMS: [&str; 18] = [
    "words",
    "units",
    "output",
    "numerics",
    "input",
    "effects",
    "motion",
    "catalog",
    "mechanism",
    "requirement",
    "actuator",
    "design",
    "measured",
    "rules",
    "report",
    "study",
    "pages",
    "cli",
];

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The code of a file: comments (with the examples in them) and texts taken away.
fn code(text: &str) -> String {
    let mut out = String::new();
    for line in text.lines() {
        // No text of the sources holds two slashes but addresses, and these hold no path of the crate.
        let line = line.find("//").map_or(line, |start| &line[..start]);
        out.push_str(line);
        out.push('\n');
    }
    out
}

/// Names that follow `crate::` in a text: of `use`, of re-exports, of paths and of macros, in groups too.
fn named(code: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        let word = |s: &str| s.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
        match rest.strip_prefix('{') {
            None => drop(found.insert(word(rest))),
            Some(group) => {
                // The first name of each item of the group, at its own depth.
                let (mut depth, mut start) = (0, true);
                for (k, c) in group.char_indices() {
                    match c {
                        '{' => depth += 1,
                        '}' if depth == 0 => break,
                        '}' => depth -= 1,
                        ',' if depth == 0 => start = true,
                        c if start && (c.is_alphanumeric() || c == '_') => {
                            found.insert(word(&group[k..]));
                            start = false;
                        }
                        _ => {}
                    }
                }
            }
        }
    }
    found
}

fn room_of(path: &Path, src: &Path) -> String {
    let inside = path.strip_prefix(src).unwrap();
    inside.components().next().unwrap().as_os_str().to_str().unwrap().trim_end_matches(".rs").to_string()
}

/// For each room those that it imports from, each with a file that does.
fn imports() -> BTreeMap<String, BTreeMap<String, String>> {
    let src = repository("src");
    let mut all = Vec::new();
    files(&src, &mut all);
    let mut edges: BTreeMap<String, BTreeMap<String, String>> = BTreeMap::new();
    for path in all {
        let room = room_of(&path, &src);
        if ["lib", "main"].contains(&room.as_str()) {
            continue;
        }
        let from = edges.entry(room.clone()).or_default();
        for name in named(&code(&fs::read_to_string(&path).unwrap())) {
            if name != room && ROOMS.contains(&name.as_str()) {
                from.entry(name).or_insert_with(|| path.strip_prefix(&src).unwrap().display().to_string());
            }
        }
    }
    edges
}

#[test]
fn a_room_imports_only_from_rooms_above_it() {
    let place = |room: &str| ROOMS.iter().position(|r| *r == room);
    let mut wrong = Vec::new();
    let mut arrows = 0;
    for (room, from) in imports() {
        let own = place(&room).unwrap_or_else(|| panic!("the room `{room}` has no floor in this test"));
        for (other, file) in from {
            arrows += 1;
            if place(&other).is_none_or(|p| p > own) {
                wrong.push(format!("{file} imports {other}, which is below {room}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(arrows > 60, "imports are not read right: {arrows}");
}

/// The test above can fail: every way in which a room is named is seen.
#[test]
fn every_way_to_import_is_seen() {
    let seen = |text: &str| named(&code(text)).into_iter().collect::<Vec<_>>();
    assert_eq!(seen("use crate::design::Prepared;"), ["design"]);
    assert_eq!(seen("pub(crate) use crate::report;"), ["report"]);
    assert_eq!(seen("use crate::{cli::{run, Done}, units};"), ["cli", "units"]);
    assert_eq!(seen("let x = crate::study::work(a, crate::rules::CODE);"), ["rules", "study"]);
    assert_eq!(seen("tell!(\"{}\", $crate::report::number(1.0))"), ["report"]);
    assert_eq!(seen("// see crate::report\n/// [`crate::cli`]\nuse crate::units;"), ["units"]);
    assert!(seen("use gearwise_crate::design;").is_empty());
}

/// `lib.rs` declares these rooms and no others; it and ARCHITECTURE.md tell of them in their order.
#[test]
fn the_picture_is_drawn_once() {
    let library = fs::read_to_string(repository("src/lib.rs")).unwrap();
    let mut declared: Vec<&str> =
        library.lines().filter_map(|l| l.strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    declared.sort_unstable();
    let mut rooms = ROOMS.to_vec();
    rooms.sort_unstable();
    assert_eq!(declared, rooms);
    let told: Vec<&str> =
        library.lines().filter_map(|l| l.strip_prefix("//! * [`")?.split_once("`]:")).map(|l| l.0).collect();
    assert_eq!(told, ROOMS, "lib.rs");
    let architecture = fs::read_to_string(repository("ARCHITECTURE.md")).unwrap();
    let told: Vec<&str> = architecture
        .lines()
        .filter_map(|l| l.strip_prefix("| `")?.split_once("` |"))
        .map(|l| l.0)
        .filter(|name| ROOMS.contains(name))
        .collect();
    assert_eq!(told, ROOMS, "ARCHITECTURE.md");
}
