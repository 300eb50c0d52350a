//! What is told on stderr while something long is at work: a bar on a terminal, lines where they are asked for, else nothing.
//!
//! The one idea: how often a line comes is decided by what is done, not by a clock; only the bar reads one.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::Args;
use indicatif::ProgressBar;

/// Whether progress is reported.
#[derive(Debug, Clone, Copy, Args)]
pub struct Telling {
    /// Lines of progress on stderr, for logs, also where that is no terminal
    #[arg(long)]
    pub progress: bool,
    /// No progress on stderr
    #[arg(long, conflicts_with = "progress")]
    pub quiet: bool,
}

/// Lines that a work whose size is known has at most.
const LINES: u64 = 10;
/// A search is first reported after so many branches, then each time there are twice as many.
const FIRST: u64 = 1024;

impl Telling {
    /// Whether there is a bar.
    pub fn bar(self) -> bool {
        !self.progress && !self.quiet && std::io::stderr().is_terminal()
    }

    /// A work of so many steps.
    pub fn counted(self, of: usize, what: &'static str) -> Counted {
        let bar = if self.bar() { super::bar(of, what) } else { ProgressBar::hidden() };
        Counted { bar, lines: self.progress, of: of as u64, done: AtomicU64::new(0), what }
    }

    /// A search whose end nobody knows: there is no estimate.
    pub fn search(self, what: &'static str) -> Search {
        let bar = if self.bar() { super::spinner(what) } else { ProgressBar::hidden() };
        Search { bar, lines: self.progress, next: AtomicU64::new(FIRST), what }
    }
}

/// A work whose size is known.
#[derive(Debug)]
pub struct Counted {
    bar: ProgressBar,
    lines: bool,
    of: u64,
    done: AtomicU64,
    what: &'static str,
}

impl Counted {
    /// A step is done.
    pub fn step(&self) {
        self.bar.inc(1);
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if self.lines && is_told(done, self.of) {
            tell!("{}: {done} of {}", self.what, self.of);
        }
        if done == self.of {
            self.bar.finish_and_clear();
        }
    }

    /// What is called for each step that is done.
    pub fn ticking(self) -> Box<dyn Fn() + Send + Sync> {
        Box::new(move || self.step())
    }
}

impl Counted {
    /// It is over.
    pub fn end(&self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.end();
    }
}

/// Whether a step is one that is reported: one of ten, and the last.
fn is_told(done: u64, of: u64) -> bool {
    done == of || done.is_multiple_of(of.div_ceil(LINES).max(1))
}

/// A search by branch and bound.
#[derive(Debug)]
pub struct Search {
    bar: ProgressBar,
    lines: bool,
    next: AtomicU64,
    what: &'static str,
}

impl Search {
    /// So many branches were looked at, and so many complete combinations solved.
    pub fn at(&self, branches: usize, solved: usize) {
        let branches = branches as u64;
        if branches.is_multiple_of(64) {
            self.bar.set_message(format!("{}: {branches} branches, {solved} combinations solved", self.what));
            self.bar.tick();
        }
        if self.lines && branches >= self.next.load(Ordering::Relaxed) {
            self.next.store(2 * branches, Ordering::Relaxed);
            tell!("{}: {branches} branches, {solved} combinations solved", self.what);
        }
    }
}

impl Drop for Search {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn about_ten_steps_are_told_and_always_the_last() {
        for of in [1, 3, 9, 10, 11, 345, 100_003] {
            let told: Vec<u64> = (1..=of).filter(|done| is_told(*done, of)).collect();
            assert!(told.len() as u64 <= LINES + 1 && told.last() == Some(&of), "{of}: {told:?}");
        }
        assert!(!is_told(1, 345));
    }
}
