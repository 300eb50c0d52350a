//! Works through a study, block by block.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use super::journal::{Block, Journal, Lock, write_list};
use super::plan::{BLOCK, Hashed, Inputs, Plan, Settings, Shard, path_name};
use super::worker::{Broken, Record, Store, Worker};
use super::{StudyError, output};
use crate::catalog::Catalog;
use crate::design::options::Stopped;
use crate::input::{InputError, Source, limits};

/// Everything that a study needs.
#[derive(Debug)]
pub struct Study<'a> {
    /// Which requirements, and the grid over them.
    pub inputs: &'a Inputs,
    /// The study file.
    pub file: Option<&'a Arc<Source>>,
    /// Where the grid is written: the study file, the command line.
    pub homes: &'a [Arc<Source>],
    /// The catalogue.
    pub catalog: &'a Catalog,
    /// The catalogue's files.
    pub catalog_files: Vec<Hashed>,
    /// Settings.
    pub settings: Settings,
    /// Which part of it is run.
    pub shard: Shard,
}

/// What is done where the folder has a study already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Refuse.
    Refuse,
    /// Go on with it; begin where there is none.
    Resume,
    /// Begin anew.
    Replace,
}

/// What a run is told, and what it tells.
pub struct Watch<'w> {
    /// Set when the run is to stop; the robots at hand are done again when it goes on.
    pub stop: &'w AtomicBool,
    /// Called once with the robots done before and all robots.
    pub begin: &'w (dyn Fn(u64, u64) + Sync),
    /// Called for each robot that is finished.
    pub tick: &'w (dyn Fn() + Sync),
    /// Called for each robot that is broken: number, requirement, point of the grid, and why.
    pub broken: &'w (dyn Fn(u64, &str, &str, &Broken) + Sync),
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch").finish_non_exhaustive()
    }
}

/// Opens the journal of a study in a folder, or begins it. `Ok(None)` where the folder has the finished results of this study.
///
/// # Errors
/// The folder has another study, or one that may not be touched; inputs that are wrong or have changed.
pub fn prepare(study: &Study, out: &Path, existing: Existing) -> Result<Option<Journal>, StudyError> {
    let new = !out.exists();
    let prepared = begin(study, out, existing);
    if new && prepared.is_err() {
        Lock::forget(out);
    }
    prepared
}

fn begin(study: &Study, out: &Path, existing: Existing) -> Result<Option<Journal>, StudyError> {
    Journal::check_own(out)?;
    if existing == Existing::Replace {
        output::check_own(out)?;
    }
    let lock = Lock::take(out)?;
    let list = ListFile(out.join(".list.part"));
    let there = Journal::is_in(out);
    if existing == Existing::Refuse {
        if there {
            let finished =
                Journal::open(out, lock).and_then(|j| Ok((j.recorded()? == j.plan.robots_in(j.shard), j.shard)));
            let what = match finished {
                Ok((true, shard)) if shard != Shard::WHOLE => {
                    format!("`{}` has shard {shard}, finished: `gearwise merge` takes it", out.display())
                }
                _ => format!("`{}` has a study that is not finished: `--resume` goes on with it", out.display()),
            };
            return Err(StudyError::Argument(format!("{what}, `--force` starts again")));
        }
        if let Some(file) = output::there(out) {
            return Err(StudyError::Argument(format!(
                "`{}` has results already (`{file}`): `--force` replaces them",
                out.display()
            )));
        }
    }
    let (requirements, list_sha256) = write_list(&study.inputs.base, &study.inputs.paths, &list.0)?;
    let plan = Plan {
        gearwise: env!("CARGO_PKG_VERSION").into(),
        settings: study.settings,
        study: study.file.map(|f| Hashed { file: path_name(Path::new(f.name())), sha256: f.sha256() }),
        grid: Plan::planned(&study.inputs.grid),
        catalog: study.catalog_files.clone(),
        motors: study.catalog.motors.iter().map(|m| m.id.clone()).collect(),
        modules: study.catalog.modules.iter().map(|m| m.id.clone()).collect(),
        requirements,
        list_sha256,
        robots: requirements.checked_mul(study.inputs.grid.points()).filter(|n| *n <= limits::ROBOTS).ok_or_else(
            || {
                StudyError::Argument(format!(
                    "the study has more than {} robots; split it into several studies, or take fewer values",
                    limits::ROBOTS
                ))
            },
        )?,
    };
    let other = |why: String| {
        StudyError::Argument(format!("the study in `{}` is another: {why}; `--force` starts again", out.display()))
    };
    if existing == Existing::Resume {
        if there {
            let journal = Journal::open(out, lock)?;
            if let Some(why) = journal.plan.difference(&plan) {
                return Err(other(why));
            }
            if journal.shard != study.shard {
                return Err(other(format!("it is shard {}, not {}", journal.shard, study.shard)));
            }
            return Ok(Some(journal));
        }
        if let Some(was) = output::manifest_of(out)? {
            return match was.difference(&plan) {
                Some(why) => Err(other(why)),
                None if study.shard != Shard::WHOLE => Err(other("it is the whole study, not a shard".into())),
                None => output::inputs_unchanged(out, &study.inputs.base).map(|()| None),
            };
        }
    }
    check_grid(study, &list.0, &plan)?;
    let journal = Journal::begin(out, lock, plan, study.shard, &list.0)?;
    output::remove(out)?;
    Ok(Some(journal))
}

/// The list while it is being written; what is left of it goes.
struct ListFile(PathBuf);

impl Drop for ListFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Tries every value of the grid once on the first requirement, so that a mistake in the study file is told
/// at once and not once for each robot.
fn check_grid(study: &Study, list: &Path, plan: &Plan) -> Result<(), StudyError> {
    if plan.grid.is_empty() {
        return Ok(());
    }
    let first = std::fs::read_to_string(list).map_err(|e| StudyError::file("read", list, &e))?;
    let Some(first) = first.lines().next() else { return Ok(()) };
    let worker = worker(study);
    let mut errors: Vec<InputError> = Vec::new();
    for parameter in 0..plan.grid.len() {
        for value in 0..plan.grid[parameter].values.len() as u64 {
            let (read, _) = worker.read(first, value * plan.stride(parameter));
            let of_grid = |e: &InputError| study.homes.iter().any(|home| Arc::ptr_eq(&e.source, home));
            for error in read.err().into_iter().flatten().filter(of_grid) {
                let known = errors.iter_mut().find(|known| Arc::ptr_eq(&known.source, &error.source));
                match known {
                    Some(known) => {
                        let new =
                            error.problems.into_iter().filter(|p| !known.problems.contains(p)).collect::<Vec<_>>();
                        known.problems.extend(new);
                    }
                    None => errors.push(error),
                }
            }
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(StudyError::Input(errors)) }
}

fn worker<'a>(study: &'a Study) -> Worker<'a> {
    Worker {
        catalog: study.catalog,
        settings: study.settings,
        grid: &study.inputs.grid,
        homes: study.homes,
        base: &study.inputs.base,
        store: Store::default(),
    }
}

/// Does what is left to do of a journal's shard. Gives the number of its robots.
///
/// # Errors
/// An input that has changed, a journal that cannot be written, and [`StudyError::Stopped`].
pub fn run(study: &Study, journal: &Journal, watch: &Watch) -> Result<u64, StudyError> {
    let plan = &journal.plan;
    let of = plan.robots_in(journal.shard);
    let before = journal.check(&study.inputs.base)?;
    (watch.begin)(before, of);
    let done = AtomicU64::new(before);
    let worker = worker(study);
    let points = plan.points();
    let mut requirements = journal.requirements(0)?;
    let mut blocks = (0..plan.blocks()).filter(|b| journal.shard.has(*b)).peekable();
    while blocks.peek().is_some() {
        // Small blocks are worked on together.
        let (mut files, mut left) = (Vec::new(), Vec::new());
        while (left.len() as u64) < BLOCK
            && let Some(block) = blocks.next()
        {
            let mut finished = journal.read(block)?;
            finished.retain(|r| r.broken.is_none());
            let before = left.len();
            for robot in plan.robots_of(block) {
                if finished.binary_search_by_key(&robot, |r| r.robot).is_err() {
                    left.push((robot, requirements.get(robot / points)?.to_string(), files.len()));
                }
            }
            if left.len() > before {
                files.push(journal.append(block, &finished)?);
            }
        }
        left.par_iter().try_for_each(|(robot, requirement, file)| {
            if watch.stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            // A robot that was stopped is done again when the study goes on.
            let stop = || watch.stop.load(Ordering::Relaxed);
            let Ok(record) = unharmed(&worker, *robot, requirement, robot % points, &stop) else { return Ok(()) };
            files[*file].add(&record)?;
            done.fetch_add(1, Ordering::Relaxed);
            if let Some(why) = &record.broken {
                (watch.broken)(*robot, requirement, &study.inputs.grid.name(robot % points), why);
            }
            (watch.tick)();
            Ok::<(), StudyError>(())
        })?;
        if watch.stop.load(Ordering::Relaxed) {
            break;
        }
        files.iter().try_for_each(Block::finish)?;
    }
    let done = done.into_inner();
    if done < of { Err(StudyError::Stopped { done, of }) } else { Ok(of) }
}

/// Does the work of one robot. A fault of the program is told like a mistake of the robot's: it must not
/// take the others with it, now or at every attempt to go on.
fn unharmed(
    worker: &Worker,
    robot: u64,
    requirement: &str,
    point: u64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Record, Stopped> {
    catch_unwind(AssertUnwindSafe(|| worker.work(robot, requirement, point, stop))).unwrap_or_else(|panic| {
        let said = panic.downcast_ref::<String>().map(String::as_str);
        let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown");
        let first = format!("{requirement}: a fault of the program, please report it: {said}");
        let broken = Broken { report: format!("error: {first}\n"), first, mistakes: 1 };
        Ok(Record {
            robot,
            name: String::new(),
            inputs: Vec::new(),
            joints: Vec::new(),
            combined: None,
            broken: Some(broken),
        })
    })
}
