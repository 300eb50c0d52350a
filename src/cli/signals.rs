//! Ctrl-C and what `kill` sends: the work at hand is ended, and what is finished is kept.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{SigId, flag, low_level};

/// Watches for the wish of the user, or of the system, that the program ends; until it is dropped.
pub struct Signals {
    asked: Arc<AtomicBool>,
    handlers: Vec<SigId>,
}

impl Signals {
    /// Begins. The first signal is noted, the second ends the process at once.
    pub fn watch() -> Signals {
        let asked = Arc::new(AtomicBool::new(false));
        let mut handlers = Vec::new();
        for signal in [SIGINT, SIGTERM] {
            // In this order: the first signal has not been noted when it is asked whether it was.
            handlers.extend(flag::register_conditional_shutdown(signal, INTERRUPTED, asked.clone()));
            handlers.extend(flag::register(signal, asked.clone()));
        }
        Signals { asked, handlers }
    }

    /// Set once a signal has come.
    pub fn asked(&self) -> Arc<AtomicBool> {
        self.asked.clone()
    }

    /// True if a signal has arrived.
    pub fn have_come(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}

impl Drop for Signals {
    fn drop(&mut self) {
        for handler in self.handlers.drain(..) {
            low_level::unregister(handler);
        }
    }
}

/// Exit status of what was interrupted.
const INTERRUPTED: i32 = 130;
