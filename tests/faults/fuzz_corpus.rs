//! Every input that fuzzing has kept, run again: those that reach new code (`fuzz/corpus`) and those that once
//! broke something (`fuzz/found`). The targets' bodies are the fuzzer's own.

use std::fs;
use std::path::{Path, PathBuf};

use gearwise::design::answer::{Design, Reason};
use gearwise::design::optimize::optimize;
use gearwise::design::program::{Bind, Infeasible};
use rayon::prelude::*;

use crate::bodies::{self, TARGETS, joint};
use crate::cases::share;

fn inputs(folder: &str, target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz").join(folder).join(target);
    let mut files: Vec<PathBuf> = fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
    files.sort();
    files
}

/// Runs the inputs of a folder, or every so many of each target.
fn replay(folder: &str, every: usize) -> usize {
    let of = |(name, _): &(&'static str, _)| {
        inputs(folder, name).into_iter().step_by(every).map(|f| (*name, f)).collect::<Vec<_>>()
    };
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
    replay("found", 1);
}

#[test]
fn the_corpus_breaks_nothing() {
    for (target, _) in TARGETS {
        assert!(!inputs("corpus", target).is_empty(), "there is no corpus for {target}");
    }
    let every = (1.0 / share()).ceil().max(1.0) as usize;
    assert!(replay("corpus", every) * every > 100);
}

/// Whether the scan of the target `optimize` says no to an answer.
fn is_caught(input: &Path, spoil: impl Fn(&mut Design) -> Option<Reason>) -> Option<bool> {
    let (robot, catalog) = joint::draw(&fs::read(input).unwrap())?;
    // What a list of gears or a spring is asked for is judged by other bounds.
    robot.joints[0].limits.spring.is_none().then_some(())?;
    let found = optimize(&robot, &catalog);
    let mut design = found.joints[0].designs().next()?.clone();
    let reason = spoil(&mut design);
    let judged = || joint::judge(&robot, &catalog, reason.as_ref().map_or(Ok(&design), Err));
    Some(std::panic::catch_unwind(std::panic::AssertUnwindSafe(judged)).is_err())
}

#[test]
fn a_wrong_answer_is_caught() {
    fn nowhere() -> Reason {
        let bind = Bind::of("voltage", None);
        Reason::Infeasible(Infeasible::Nowhere { bind, least: 2.0, allowed: 1.0, ratio: 1.0 })
    }
    type Spoil = dyn Fn(&mut Design) -> Option<Reason> + Sync;
    // Where a limit binds at every ratio that is left, the scan has nothing to say against "impossible".
    let spoils: [(&str, usize, &Spoil); 4] = [
        ("an objective that is not that of the design", 80, &|d| {
            d.optimum.objective *= 1.01;
            None
        }),
        ("a loss that is not that of the design", 80, &|d| {
            d.evaluation.loss *= 1.001;
            None
        }),
        ("a ratio outside its window", 80, &|d| {
            d.optimum.ratio = d.optimum.window().max * 1.1;
            None
        }),
        ("a design said to be impossible", 40, &|_| Some(nowhere())),
    ];
    let inputs = inputs("corpus", "optimize");
    for (what, least, spoil) in spoils {
        let judged: Vec<bool> = inputs.par_iter().filter_map(|input| is_caught(input, spoil)).collect();
        let caught = judged.iter().filter(|caught| **caught).count();
        println!("{what}: {caught} of {} caught", judged.len());
        assert!(judged.len() > 5 && caught * 100 >= judged.len() * least, "{what}: {caught} of {}", judged.len());
    }
}
