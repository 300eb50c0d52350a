//! One question while it is worked on: what was found so far, and whether a newer question made it stale.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::state::Ask;

/// How far a search is, and whether it is to stop. An answer that is kept holds no more of its question than this.
#[derive(Debug, Default)]
pub struct Course {
    stop: AtomicBool,
    done: AtomicUsize,
    of: AtomicUsize,
}

impl Course {
    /// Ends the work: a newer question came.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether it is to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// One more motor is done.
    pub fn step(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// So many motors are to be done.
    pub fn begin(&self, of: usize) {
        self.done.store(0, Ordering::Relaxed);
        self.of.store(of, Ordering::Relaxed);
    }

    /// Motors that are done, and of how many.
    pub fn far(&self) -> (usize, usize) {
        (self.done.load(Ordering::Relaxed), self.of.load(Ordering::Relaxed))
    }
}

/// What was said so far.
#[derive(Debug, Default)]
struct Said {
    replies: Vec<String>,
    is_done: bool,
    /// What broke, where something did.
    broken: Option<String>,
}

/// What comes next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Next {
    /// A reply.
    Reply(String),
    /// Nothing yet: so many motors of so many are done.
    Pending(usize, usize),
    /// Nothing more: all was said, or a newer question came.
    Nothing,
    /// The program broke: what it was asked.
    Broken(String),
}

/// One question.
pub struct Work {
    /// What is asked.
    pub ask: Ask,
    /// How far it is.
    pub course: Arc<Course>,
    said: Mutex<Said>,
    announce: Box<dyn Fn() + Send + Sync>,
}

impl std::fmt::Debug for Work {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Work").field("ask", &self.ask).finish_non_exhaustive()
    }
}

impl Work {
    /// A question; `announce` is called whenever there is something new.
    pub fn new(ask: Ask, announce: Box<dyn Fn() + Send + Sync>) -> Work {
        Work { ask, course: Arc::default(), said: Mutex::default(), announce }
    }

    fn with<T>(&self, change: impl FnOnce(&mut Said) -> T) -> T {
        let out = change(&mut self.said.lock().unwrap_or_else(PoisonError::into_inner));
        (self.announce)();
        out
    }

    /// One more reply.
    pub fn reply(&self, reply: String) {
        self.with(|said| said.replies.push(reply));
    }

    /// There is nothing more.
    pub fn end(&self) {
        self.with(|said| said.is_done = true);
    }

    /// It broke.
    pub fn broke(&self, what: String) {
        self.with(|said| (said.broken, said.is_done) = (Some(what), true));
    }

    /// What comes after so many replies.
    pub fn next(&self, have: usize) -> Next {
        let said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        match (said.replies.get(have), &said.broken) {
            (Some(reply), _) => Next::Reply(reply.clone()),
            (None, Some(what)) => Next::Broken(what.clone()),
            (None, None) if said.is_done || self.course.is_stopped() => Next::Nothing,
            (None, None) => {
                let (done, of) = self.course.far();
                Next::Pending(done, of)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_next_is_said_in_order() {
        let work = Work::new(Ask::default(), Box::new(|| ()));
        work.course.begin(7);
        work.course.step();
        assert_eq!(work.next(0), Next::Pending(1, 7));
        work.reply("a".into());
        assert_eq!((work.next(0), work.next(1)), (Next::Reply("a".into()), Next::Pending(1, 7)));
        work.end();
        assert_eq!(work.next(1), Next::Nothing);
    }

    #[test]
    fn what_is_stale_has_nothing_more() {
        let work = Work::new(Ask::default(), Box::new(|| ()));
        work.course.stop();
        assert_eq!(work.next(0), Next::Nothing);
        work.broke("bus.voltage".into());
        assert_eq!(work.next(0), Next::Broken("bus.voltage".into()));
    }
}
