//! Commands as they stand in help and documentation, run in a folder of their own.
#![allow(dead_code, reason = "each test file uses its part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// A copy of what the repository ships, with the two files that examples call their reader's own.
pub struct Workspace {
    folder: TempDir,
}

impl Workspace {
    pub fn new() -> Workspace {
        let folder = tempfile::tempdir().unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for shipped in ["requirements", "catalogs", "tests/fixtures"] {
            copy(&root.join(shipped), &folder.path().join(shipped));
        }
        // `robot.toml` and `my_motors.csv` are the reader's.
        copy(&root.join("requirements/motions"), &folder.path().join("motions"));
        std::fs::copy(root.join("requirements/exoskeleton_hip.toml"), folder.path().join("robot.toml")).unwrap();
        std::fs::copy(root.join("catalogs/motors/maxon.csv"), folder.path().join("my_motors.csv")).unwrap();
        Workspace { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs the program with the words after its name.
    pub fn run(&self, words: &[String]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_gearwise"))
            .env_remove("COLUMNS")
            // One's own catalogue is the reader's, not that of whoever runs the tests.
            .env_remove("GEARWISE_CATALOG")
            .env("HOME", self.folder.path())
            .env("XDG_CONFIG_HOME", self.folder.path().join(".config"))
            .args(words)
            .current_dir(self.folder.path())
            .output()
            .unwrap()
    }
}

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap() {
            let path = entry.unwrap().path();
            copy(&path, &to.join(path.file_name().unwrap()));
        }
    } else {
        std::fs::copy(from, to).unwrap();
    }
}

/// The words of a command line up to a pipe, a redirection or a comment, quotes taken away as a shell does.
pub fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quote, mut open) = (Vec::new(), String::new(), None, false);
    for c in line.chars() {
        match (quote, c) {
            (Some(q), c) if c == q => quote = None,
            (Some(_), c) => word.push(c),
            (None, '"' | '\'') => (quote, open) = (Some(c), true),
            (None, '|' | '>') => break,
            (None, '#') if !open && word.is_empty() => break,
            (None, c) if c.is_whitespace() => {
                if open || !word.is_empty() {
                    words.push(std::mem::take(&mut word));
                }
                open = false;
            }
            (None, c) => word.push(c),
        }
    }
    if open || !word.is_empty() {
        words.push(word);
    }
    words
}
