//! Every input that fuzzing has kept, run again: those that reach new code (`fuzz/corpus`) and those that once
//! broke something (`fuzz/found`). The targets' bodies are the fuzzer's own.

#[path = "../fuzz/src/bodies/mod.rs"]
mod bodies;
mod raw;

use std::fs;
use std::path::{Path, PathBuf};

use bodies::TARGETS;
use rayon::prelude::*;

fn inputs(folder: &str, target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz").join(folder).join(target);
    let mut files: Vec<PathBuf> = fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
    files.sort();
    files
}

fn replay(folder: &str) -> usize {
    let of = |(name, _): &(&'static str, _)| inputs(folder, name).into_iter().map(|f| (*name, f)).collect::<Vec<_>>();
    let all: Vec<(&str, PathBuf)> = TARGETS.iter().flat_map(of).collect();
    let failed: Vec<&PathBuf> = all
        .par_iter()
        .filter(|(target, file)| {
            let bytes = fs::read(file).unwrap();
            std::panic::catch_unwind(|| bodies::run(target, &bytes)).is_err()
        })
        .map(|(_, file)| file)
        .collect();
    assert!(failed.is_empty(), "broken by {failed:#?}");
    all.len()
}

#[test]
fn what_the_fuzzer_has_found_stays_mended() {
    replay("found");
}

#[test]
fn the_corpus_breaks_nothing() {
    for (target, _) in TARGETS {
        assert!(!inputs("corpus", target).is_empty(), "there is no corpus for {target}");
    }
    assert!(replay("corpus") > 100);
}
