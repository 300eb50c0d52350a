//! Work of a search, counted in steps that take about as long each, so that a search ends after the same work on every machine and
//! for any number of threads.

use std::sync::atomic::{AtomicU64, Ordering};

/// Steps done, and steps after which searches end.
#[derive(Debug)]
pub(super) struct Work {
    done: AtomicU64,
    most: AtomicU64,
}

impl Work {
    /// Without an end.
    pub(super) fn endless() -> Work {
        Work { done: AtomicU64::new(0), most: AtomicU64::new(u64::MAX) }
    }

    /// Counts steps. Sums do not depend on their order, so that parallel work may count too.
    pub(super) fn count(&self, steps: usize) {
        self.done.fetch_add(steps as u64, Ordering::Relaxed);
    }

    /// Allows so many steps from here on.
    pub(super) fn allow(&self, more: u64) {
        self.most.store(self.done().saturating_add(more), Ordering::Relaxed);
    }

    /// Steps done so far.
    pub(super) fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Steps that are left. Asked between parallel sections only: within one the answer would depend on the threads.
    pub(super) fn left(&self) -> u64 {
        self.most.load(Ordering::Relaxed).saturating_sub(self.done())
    }
}
