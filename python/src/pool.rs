//! Where work is done: on threads of this process's own, while the calling thread listens for signals and tells of progress.
//!
//! The one idea: a call hands over what it needs and waits for the answer. When Python wants to stop (Ctrl-C, an exception of
//! the progress callback) the call returns at once; the work hears of it and ends by itself. A pool belongs to a process id: a
//! child of `fork` makes its own and leaves the parent's alone, whose threads it does not have.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

use arc_swap::ArcSwap;
use gearwise::ask::{Failure, Watch};
use pyo3::prelude::*;

use crate::failure;

/// The pools of a process, by their number of threads; 0 is as many as the machine has.
#[derive(Default)]
struct Pools {
    process: u32,
    pools: Vec<(usize, Arc<rayon::ThreadPool>)>,
}

static POOLS: std::sync::LazyLock<ArcSwap<Pools>> =
    std::sync::LazyLock::new(|| ArcSwap::from_pointee(Pools::default()));

/// How often the calling thread looks for signals.
const PACE: Duration = Duration::from_millis(50);

/// The pool with so many threads.
fn pool(threads: usize) -> Result<Arc<rayon::ThreadPool>, Failure> {
    let process = std::process::id();
    let known = POOLS.load();
    if known.process == process
        && let Some((_, pool)) = known.pools.iter().find(|(of, _)| *of == threads)
    {
        return Ok(pool.clone());
    }
    let made = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|k| format!("gearwise-{k}")).build();
    let made = Arc::new(made.map_err(|why| Failure::Argument(format!("cannot start {threads} threads: {why}")))?);
    // Two threads that ask at once may make two pools: one of them is used once.
    POOLS.rcu(|known| {
        let mut pools = if known.process == process { known.pools.clone() } else { forget(known) };
        pools.push((threads, made.clone()));
        Pools { process, pools }
    });
    Ok(made)
}

/// The parent's pools cannot be ended in the child: their threads are not here.
fn forget(known: &Pools) -> Vec<(usize, Arc<rayon::ThreadPool>)> {
    known.pools.iter().cloned().for_each(std::mem::forget);
    Vec::new()
}

/// Who looks on, seen from both sides.
#[derive(Clone, Default)]
pub struct Looking {
    stop: Arc<AtomicBool>,
    done: Arc<AtomicUsize>,
    of: Arc<AtomicUsize>,
}

impl Looking {
    /// How many steps there are, and how many were done before.
    pub fn begin_after(&self, done: usize, of: usize) {
        self.done.store(done, Ordering::Relaxed);
        self.begin(of);
    }

    /// That one more step is done.
    pub fn tick(&self) {
        self.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Set once the work is to stop.
    pub fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// How many steps there are.
    pub fn begin(&self, of: usize) {
        self.of.store(of, Ordering::Relaxed);
    }

    /// What the work calls and asks.
    pub fn watch(&self) -> Watch {
        let (looking, stop) = (self.clone(), self.stop.clone());
        Watch {
            tick: Box::new(move || looking.tick()),
            stop: Box::new(move || stop.load(Ordering::Relaxed)),
            ..Watch::default()
        }
    }
}

/// How a call is made.
pub struct How<'py> {
    /// Number of threads; 0 for all of the machine.
    pub threads: usize,
    /// Called with steps done and steps there are; `None` for nobody.
    pub progress: Option<Bound<'py, PyAny>>,
    /// Whether what is stopped is waited for: it leaves files that the next call goes on with.
    pub to_its_end: bool,
}

impl<'py> How<'py> {
    /// Of the arguments `threads` and `progress` of a call.
    pub fn new(py: Python<'py>, threads: Option<i64>, progress: Option<Bound<'py, PyAny>>) -> PyResult<How<'py>> {
        let threads = match threads {
            None => 0,
            Some(threads @ 1..=1024) => threads as usize,
            Some(other) => {
                let why = format!("`threads` is {other}: expected a number from 1 to 1024");
                return Err(failure::raised(py, Failure::Argument(why)));
            }
        };
        Ok(How { threads, progress, to_its_end: false })
    }

    /// Does the work.
    pub fn run<T: Send + 'static>(
        self,
        py: Python<'py>,
        work: impl FnOnce(&Looking) -> Result<T, Failure> + Send + 'static,
    ) -> PyResult<T> {
        let pool = pool(self.threads).map_err(|why| failure::raised(py, why))?;
        let (send, receive) = sync_channel(1);
        let looking = Looking::default();
        let inside = looking.clone();
        pool.spawn(move || {
            let found = catch_unwind(AssertUnwindSafe(|| work(&inside)));
            // Nobody waits any more where the call was stopped.
            let _ = send.send(found);
        });
        let receive = std::sync::Mutex::new(receive);
        let wait = || receive.lock().map_or(Err(RecvTimeoutError::Disconnected), |receive| receive.recv_timeout(PACE));
        let mut told = usize::MAX;
        let ended = loop {
            match py.detach(wait) {
                Ok(found) => break found,
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(failure::internal(py, "the work ended without an answer"));
                }
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(raised) = py.check_signals().and_then(|()| self.tell(&looking, &mut told)) {
                        looking.stop.store(true, Ordering::Relaxed);
                        if self.to_its_end {
                            py.detach(|| receive.lock().is_ok_and(|receive| receive.recv().is_ok()));
                        }
                        return Err(raised);
                    }
                }
            }
        };
        match ended {
            Ok(Ok(found)) => {
                self.tell(&looking, &mut told)?;
                Ok(found)
            }
            Ok(Err(why)) => Err(failure::raised(py, why)),
            Err(panic) => Err(failure::internal(py, &said(&*panic))),
        }
    }

    /// Calls the callback, where something was done since.
    fn tell(&self, looking: &Looking, told: &mut usize) -> PyResult<()> {
        let (done, of) = (looking.done.load(Ordering::Relaxed), looking.of.load(Ordering::Relaxed));
        match &self.progress {
            Some(progress) if of > 0 && done != *told => {
                *told = done;
                progress.call1((done.min(of), of)).map(|_| ())
            }
            _ => Ok(()),
        }
    }
}

/// Does work that is short where it is called, without the interpreter.
pub fn here<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T, Failure> + Send) -> PyResult<T> {
    match py.detach(|| catch_unwind(AssertUnwindSafe(work))) {
        Ok(found) => found.map_err(|why| failure::raised(py, why)),
        Err(panic) => Err(failure::internal(py, &said(&*panic))),
    }
}

fn said(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
    text.unwrap_or("it does not say why").to_string()
}
