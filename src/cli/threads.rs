//! The threads that a command's work is shared among. Where the system gives none, the calling thread does all of it: the
//! result is the same.

use std::sync::OnceLock;

use rayon::ThreadPoolBuilder;

use super::{Done, Failure};

/// Does a command's work with this many threads, or as many as the machine has.
pub fn shared_out(threads: Option<u16>, work: impl FnOnce() -> Result<Done, Failure> + Send) -> Result<Done, Failure> {
    match threads {
        None if are_there() => work(),
        None => {
            tell!("warning: the system starts no threads; all is done by one");
            alone(work)
        }
        Some(threads) => match ThreadPoolBuilder::new().num_threads(usize::from(threads)).build() {
            Ok(pool) => pool.install(work),
            Err(_) if threads == 1 => alone(work),
            Err(error) => Err(Failure::Argument(format!(
                "cannot start {threads} threads: {error}; without `--threads`, or with `--threads 1`, one does all"
            ))),
        },
    }
}

/// Start the threads that all commands of a process share, once; true if they are there.
fn are_there() -> bool {
    static THERE: OnceLock<bool> = OnceLock::new();
    *THERE.get_or_init(|| match ThreadPoolBuilder::new().build_global() {
        Ok(()) => true,
        // A user of the library may have started them.
        Err(error) => format!("{error:?}").contains("GlobalPoolAlreadyInitialized"),
    })
}

/// Does work on the calling thread.
fn alone(work: impl FnOnce() -> Result<Done, Failure> + Send) -> Result<Done, Failure> {
    match ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        Ok(pool) => pool.install(work),
        // The thread is one of a pool already.
        Err(_) => work(),
    }
}
