//! The rooms of the model: each imports from rooms above it only; lib.rs and the README name the same rooms in the same
//! order. Between crates cargo sees to it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Every room, from the top: each may import from those before it.
const ROOMS: [&str; 12] = [
    "words",
    "units",
    "output",
    "numerics",
    "input",
    "effects",
    "motion",
    "transmission",
    "catalog",
    "mechanism",
    "requirement",
    "actuator",
];

fn source(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

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
    let src = source("src");
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
    assert!(arrows > 25, "imports are not read right: {arrows}");
}

/// The test above can fail: every way in which a room is named is seen.
#[test]
fn every_way_to_import_is_seen() {
    let seen = |text: &str| named(&code(text)).into_iter().collect::<Vec<_>>();
    assert_eq!(seen("use crate::catalog::Motor;"), ["catalog"]);
    assert_eq!(seen("pub(crate) use crate::report;"), ["report"]);
    assert_eq!(seen("use crate::{cli::{run, Done}, units};"), ["cli", "units"]);
    assert_eq!(seen("let x = crate::study::work(a, crate::rules::CODE);"), ["rules", "study"]);
    assert_eq!(seen("tell!(\"{}\", $crate::report::number(1.0))"), ["report"]);
    assert_eq!(seen("// see crate::report\n/// [`crate::cli`]\nuse crate::units;"), ["units"]);
    assert!(seen("use gearwise_crate::design;").is_empty());
}

/// `lib.rs` declares these rooms and no others; the README tells of them in their order.
#[test]
fn the_rooms_are_named_once_and_in_order() {
    let library = fs::read_to_string(source("src/lib.rs")).unwrap();
    let mut declared: Vec<&str> =
        library.lines().filter_map(|l| l.trim_start_matches("pub ").strip_prefix("mod ")?.strip_suffix(';')).collect();
    declared.sort_unstable();
    let mut rooms = ROOMS.to_vec();
    rooms.sort_unstable();
    assert_eq!(declared, rooms);
    let readme = fs::read_to_string(source("README.md")).unwrap();
    let told: Vec<&str> =
        readme.lines().filter_map(|l| l.strip_prefix("| `")?.split_once("` |")).map(|l| l.0).collect();
    assert_eq!(told, ROOMS, "README.md");
}

/// Circles of files that are still there, each by its files in order; none may be added, and one that is gone is taken
/// off the list.
const CIRCLES: &[&[&str]] = &[
    &["catalog/fitted.rs", "catalog/read.rs"],
    &["catalog/import/mgdb.rs", "catalog/import/mgdb/cells.rs"],
    // A motor may be a module, whose gear is a row too.
    &[
        "catalog/alternative/mod.rs",
        "catalog/drag.rs",
        "catalog/gear.rs",
        "catalog/module/constants.rs",
        "catalog/module/inside.rs",
        "catalog/module/mod.rs",
        "catalog/motor.rs",
        "catalog/row/mod.rs",
        "catalog/row/motor.rs",
        "catalog/sheet.rs",
    ],
    &["input/file.rs", "input/limits.rs", "input/source.rs"],
];

/// A module of the sources: its path below `src`, and where names in it lead.
#[derive(Default)]
struct Module {
    file: String,
    children: BTreeSet<String>,
    /// Names that it hands on, with the path that each has from here.
    handed_on: BTreeMap<String, Vec<String>>,
    /// Every path that its code names.
    named: BTreeSet<Vec<String>>,
}

/// Paths of the module tree, from `crate` on.
type Tree = BTreeMap<Vec<String>, Module>;

/// The names of a `use`, groups taken apart: path and the name that it has here.
fn items(text: &str) -> Vec<(Vec<String>, String)> {
    fn walk(prefix: &[String], text: &str, found: &mut Vec<(Vec<String>, String)>) {
        let (mut depth, mut start) = (0, 0);
        let mut parts = Vec::new();
        for (k, c) in text.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    parts.push(&text[start..k]);
                    start = k + 1;
                }
                _ => {}
            }
        }
        parts.push(&text[start..]);
        for part in parts.into_iter().map(str::trim).filter(|part| !part.is_empty()) {
            let (path, group) = match part.split_once('{') {
                Some((path, group)) => (path.trim_end_matches("::"), Some(group.trim_end().trim_end_matches('}'))),
                None => (part, None),
            };
            let (path, name) = path.split_once(" as ").map_or((path, None), |(path, name)| (path, Some(name.trim())));
            let mut whole = prefix.to_vec();
            whole.extend(path.split("::").map(|s| s.trim().to_string()).filter(|s| !s.is_empty()));
            match group {
                Some(_) => {
                    let inside = &part[part.find('{').unwrap() + 1..part.rfind('}').unwrap()];
                    walk(&whole, inside, found);
                }
                None => {
                    if whole.last().is_some_and(|last| last == "self") {
                        whole.pop();
                    }
                    let name = name.map_or_else(|| whole.last().cloned().unwrap_or_default(), str::to_string);
                    found.push((whole, name));
                }
            }
        }
    }
    let mut found = Vec::new();
    walk(&[], text, &mut found);
    found
}

/// The code of a file without the modules of tests in it.
fn without_tests(code: &str) -> String {
    code.split("#[cfg(test)]\nmod ").next().unwrap_or_default().to_string()
}

fn tree() -> Tree {
    let src = source("src");
    let mut all = Vec::new();
    files(&src, &mut all);
    let mut tree = Tree::new();
    for path in all {
        let inside = path.strip_prefix(&src).unwrap();
        let file = inside.display().to_string().replace('\\', "/");
        if file.ends_with("tests.rs") || file.contains("/tests/") || file == "main.rs" {
            continue;
        }
        let mut module: Vec<String> =
            inside.with_extension("").components().map(|c| c.as_os_str().to_str().unwrap().to_string()).collect();
        if module.last().is_some_and(|last| last == "mod" || last == "lib") {
            module.pop();
        }
        let text = without_tests(&code(&fs::read_to_string(&path).unwrap()));
        let mut entry = Module { file, ..Module::default() };
        for statement in text.split(';') {
            let Some(at) = statement.rfind("use ").filter(|at| {
                let before = &statement[..*at];
                before.is_empty() || before.ends_with(['\n', ' ', ')'])
            }) else {
                continue;
            };
            let hands_on = statement[..at].trim_end().ends_with("pub") || statement[..at].trim_end().ends_with(')');
            for (path, name) in items(&statement[at + 4..]) {
                if hands_on {
                    entry.handed_on.insert(name, path);
                } else {
                    entry.named.insert(path);
                }
            }
        }
        // Paths in the code itself.
        for root in ["crate::", "super::"] {
            for (at, _) in text.match_indices(root) {
                if text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
                    continue;
                }
                let path: String =
                    text[at..].chars().take_while(|c| c.is_alphanumeric() || "_:".contains(*c)).collect();
                let path: Vec<String> = path.split("::").filter(|s| !s.is_empty()).map(str::to_string).collect();
                if path.len() > 1 && path.iter().any(|s| s != "super") {
                    entry.named.insert(path);
                }
            }
        }
        tree.insert(module, entry);
    }
    let modules: Vec<Vec<String>> = tree.keys().cloned().collect();
    for module in modules {
        if let Some((name, parent)) = module.split_last()
            && let Some(parent) = tree.get_mut(parent)
        {
            parent.children.insert(name.clone());
        }
    }
    tree
}

/// The module whose file has what a path in a module names; `None` where the path leaves the crate.
fn leads_to(tree: &Tree, from: &[String], path: &[String], depth: usize) -> Option<Vec<String>> {
    let (first, rest) = path.split_first()?;
    let (mut at, mut rest) = match first.as_str() {
        "crate" => (Vec::new(), rest),
        "self" => (from.to_vec(), rest),
        "super" => {
            let mut up = from.to_vec();
            up.pop();
            (up, rest)
        }
        child if tree.get(from)?.children.contains(child) => (from.to_vec(), path),
        _ => return None,
    };
    while let Some((next, after)) = rest.split_first() {
        if next == "super" {
            at.pop();
        } else if tree.get(&at)?.children.contains(next) {
            at.push(next.clone());
        } else if let Some(handed) = tree.get(&at)?.handed_on.get(next)
            && depth < 8
        {
            return leads_to(tree, &at.clone(), handed, depth + 1).or(Some(at));
        } else {
            break;
        }
        rest = after;
    }
    Some(at)
}

/// For each file those that it takes something from. What a folder's `mod.rs` hands on counts for the file that has it.
fn edges(tree: &Tree) -> BTreeMap<&str, BTreeSet<&str>> {
    let mut edges: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (module, entry) in tree {
        let from = edges.entry(&entry.file).or_default();
        for path in &entry.named {
            if let Some(to) = leads_to(tree, module, path, 0).and_then(|to| tree.get(&to))
                && to.file != entry.file
                && to.file != "lib.rs"
            {
                from.insert(&to.file);
            }
        }
    }
    edges
}

/// Files that can each be reached from each other, in groups of two and more.
fn circles<'a>(edges: &BTreeMap<&'a str, BTreeSet<&'a str>>) -> Vec<Vec<&'a str>> {
    let reach = |start: &'a str| {
        let mut seen = BTreeSet::new();
        let mut open = vec![start];
        while let Some(at) = open.pop() {
            for next in edges.get(at).into_iter().flatten() {
                if seen.insert(*next) {
                    open.push(next);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&str, BTreeSet<&str>> = edges.keys().map(|file| (*file, reach(file))).collect();
    let mut found = Vec::new();
    let mut done = BTreeSet::new();
    for (file, from_it) in &reached {
        let group: Vec<&str> = from_it.iter().copied().filter(|other| reached[other].contains(file)).collect();
        if group.len() > 1 && done.insert(group.clone()) {
            found.push(group);
        }
    }
    found
}

#[test]
fn files_do_not_import_one_another_in_a_circle() {
    let tree = tree();
    let edges = edges(&tree);
    let arrows: usize = edges.values().map(BTreeSet::len).sum();
    assert!(tree.len() > 90 && arrows > 400, "imports are not read right: {} files, {arrows} arrows", tree.len());
    let found = circles(&edges);
    let within = |group: &[&str]| {
        let arrows = group.iter().flat_map(|from| edges[from].iter().map(move |to| (*from, *to)));
        arrows.filter(|(_, to)| group.contains(to)).map(|(from, to)| format!("{from} -> {to}")).collect::<Vec<_>>()
    };
    for group in &found {
        assert!(CIRCLES.contains(&group.as_slice()), "a new circle: {:#?}", within(group));
    }
    for known in CIRCLES {
        assert!(
            found.iter().any(|group| group == known),
            "this circle is gone or smaller, and still listed: {known:?}"
        );
    }
}

/// The test above can fail: paths are followed through groups, names that are handed on, and modules above.
#[test]
fn paths_are_followed_to_the_file_that_has_the_name() {
    let path = |text: &str| text.split("::").map(str::to_string).collect::<Vec<_>>();
    let seen = items("super::{a::{B, self}, c::D as E, f}");
    let seen: Vec<(String, &str)> = seen.iter().map(|(path, name)| (path.join("::"), name.as_str())).collect();
    let told = |path: &str, name: &'static str| (path.to_string(), name);
    assert_eq!(
        seen,
        [told("super::a::B", "B"), told("super::a", "a"), told("super::c::D", "E"), told("super::f", "f")]
    );
    let mut tree = Tree::new();
    let module = |file: &str, children: &[&str]| Module {
        file: file.into(),
        children: children.iter().map(|c| c.to_string()).collect(),
        ..Module::default()
    };
    tree.insert(vec![], module("lib.rs", &["a"]));
    tree.insert(path("a"), module("a/mod.rs", &["b", "c"]));
    tree.insert(path("a::b"), module("a/b.rs", &[]));
    tree.insert(path("a::c"), module("a/c.rs", &[]));
    tree.get_mut(&path("a")).unwrap().handed_on.insert("Thing".into(), path("c::Thing"));
    let to = |from: &str, what: &str| leads_to(&tree, &path(from), &path(what), 0).map(|m| m.join("::"));
    assert_eq!(to("a::b", "super::Thing").as_deref(), Some("a::c"));
    assert_eq!(to("a::b", "crate::a::c::other").as_deref(), Some("a::c"));
    assert_eq!(to("a::b", "super::own").as_deref(), Some("a"));
    assert_eq!(to("a", "b::x").as_deref(), Some("a::b"));
    assert_eq!(to("a::b", "std::fs"), None);
    tree.get_mut(&path("a::b")).unwrap().named.insert(path("super::Thing"));
    tree.get_mut(&path("a::c")).unwrap().named.insert(path("crate::a::b::x"));
    assert_eq!(circles(&edges(&tree)), [["a/b.rs", "a/c.rs"]]);
}
