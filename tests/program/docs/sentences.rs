//! Messages and help are written in the words of the trade: the string literals of the sources are read.

use std::fs;
use std::path::Path;

/// Words that an engineer in a hurry stumbles over, and what is written instead. Keys of JSON and of files are single
/// words and are not asked.
const INSTEAD: &[(&str, &str)] = &[
    ("told", "reported"),
    ("tell", "report, show, separate"),
    ("tells", "reports, shows, separates"),
    ("mend", "fix"),
    ("mended", "fixed"),
    ("stand", "is, appears"),
    ("stands", "is, appears"),
    ("stood", "was, appeared"),
    ("for ever", "continuous"),
    ("unless said", "by default"),
    ("anew", "again"),
    ("beside", "next to"),
    ("not seen", "not identifiable"),
    ("in the end", "final"),
];

/// The string literals of a source, escapes resolved, each with its line; and, where `help` is wanted, the lines of
/// documentation comments, which clap prints as help. What follows `#[cfg(test)] mod … {` is left out.
fn texts(source: &str, help: bool) -> Vec<(usize, String)> {
    let tests = source.match_indices("#[cfg(test)]").find(|(at, mark)| {
        let module = source[at + mark.len()..].trim_start();
        module.starts_with("mod ") && module.split(';').next().is_some_and(|head| head.contains('{'))
    });
    let source = &source[..tests.map_or(source.len(), |(at, _)| at)];
    let (mut found, mut rest) = (Vec::new(), source);
    let line = |rest: &str| source[..source.len() - rest.len()].matches('\n').count() + 1;
    while let Some(c) = rest.chars().next() {
        let word = source[..source.len() - rest.len()].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let raw = rest.strip_prefix('r').filter(|_| !word).and_then(|r| {
            let hashes = r.len() - r.trim_start_matches('#').len();
            r[hashes..].starts_with('"').then(|| (&r[hashes + 1..], format!("\"{}", &r[..hashes])))
        });
        if rest.starts_with("//") {
            let end = rest.find('\n').unwrap_or(rest.len());
            if help && rest.starts_with("///") {
                found.push((line(rest), rest[3..end].trim().to_string()));
            }
            rest = &rest[end..];
        } else if let Some((text, close)) = raw {
            let end = text.find(&close).expect("a raw string ends");
            found.push((line(rest), text[..end].to_string()));
            rest = &text[end + close.len()..];
        } else if c == '"' {
            let (start, mut text, mut letters) = (line(rest), String::new(), rest[1..].char_indices());
            rest = loop {
                match letters.next().expect("a string ends") {
                    (at, '"') => break &rest[at + 2..],
                    (_, '\\') => match letters.next().expect("an escape ends").1 {
                        'n' => text.push('\n'),
                        't' => text.push('\t'),
                        // The line goes on after its break and the blanks that follow.
                        '\n' => {
                            let blanks = letters.as_str().len() - letters.as_str().trim_start().len();
                            for _ in 0..blanks {
                                letters.next();
                            }
                        }
                        other => text.push(other),
                    },
                    (_, other) => text.push(other),
                }
            };
            found.push((start, text));
        } else if c == '\'' && !rest.starts_with("'\\") {
            // A letter in quotes, which may be a quotation mark; or a lifetime.
            let letter = rest.chars().nth(1).map_or(0, char::len_utf8);
            rest = rest[1 + letter..].strip_prefix('\'').unwrap_or(&rest[1..]);
        } else {
            // An escaped letter in quotes is passed as a whole.
            let step = if rest.starts_with("'\\") { 3 } else { c.len_utf8() };
            rest = &rest[step..];
        }
    }
    found
}

/// Whether a text holds a word, or words, between other letters than their own.
fn holds(text: &str, word: &str) -> bool {
    let text = text.to_lowercase();
    let letter = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || c == '_');
    text.match_indices(word)
        .any(|(at, _)| !letter(text[..at].chars().next_back()) && !letter(text[at + word.len()..].chars().next()))
}

/// Two blanks before a letter, but at the beginning of a line.
fn holds_two_blanks(text: &str) -> bool {
    text.lines().any(|line| {
        let line = line.trim_start();
        line.match_indices("  ").any(|(at, _)| line[at + 2..].starts_with(|c: char| c.is_alphabetic() || c == '('))
    })
}

#[test]
fn messages_use_the_words_of_the_trade_and_single_blanks() {
    let (mut wrong, mut read) = (Vec::new(), 0);
    let mut folders = ["src", "crates"].map(|folder| Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).to_vec();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap().to_str().unwrap().replace('\\', "/");
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            if !name.ends_with(".rs") || name.ends_with("tests.rs") || name.contains("/tests/") {
                continue;
            }
            let source = fs::read_to_string(&path).unwrap();
            for (line, text) in texts(&source, name.starts_with("src/cli/")) {
                read += 1;
                // One word alone is a key or a name.
                if !text.contains(' ') {
                    continue;
                }
                for (word, instead) in INSTEAD.iter().filter(|(word, _)| holds(&text, word)) {
                    wrong.push(format!("{name}:{line}: `{word}` (instead: {instead}): {text}"));
                }
                if holds_two_blanks(&text) {
                    wrong.push(format!("{name}:{line}: two blanks: {text}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(read > 5000, "{read} texts: the sources are not read right");
}

#[test]
fn texts_of_a_source_are_found() {
    let source = "/// Help.\nf('\"', '\\'', \"a \\\"b\\\" \\\n     c\\n\", r#\"raw \"x\"\"#); // \"no\"\nlet x: &'a str = \"d\";\n\
                  #[cfg(test)]\nmod tests;\nlet y = \"e\";\n#[cfg(test)]\nmod tests {\n\"f\"\n}\n";
    let found = |help| texts(source, help).into_iter().map(|(_, text)| text).collect::<Vec<_>>();
    assert_eq!(found(false), ["a \"b\" c\n", "raw \"x\"", "d", "e"]);
    assert_eq!(found(true)[0], "Help.");
    assert!(holds("It Stands.", "stands") && !holds("`stands_by` understands", "stands"));
    assert!(holds_two_blanks("one  two") && !holds_two_blanks("  one\n  two  # three"));
}
