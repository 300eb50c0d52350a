//! What is finished, on disk, whatever happens to the process.
//!
//! The one idea: a finished robot is one line with a checksum, appended to the file of its block in a single
//! write. A process that is killed leaves at worst a torn last line, which the checksum shows and the next
//! run takes away. Nothing is ever known of a study but what its journal says.

use std::collections::HashMap;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use hmac_sha256::Hash as Sha256;

use super::plan::{BLOCK, Plan, Shard};
use super::worker::Record;
use super::{StudyError, work};
use crate::input::{Source, hex, sha256};
use crate::output::{make_folder, sync_folder, write_whole};

/// Name of the journal's folder.
const FOLDER: &str = "journal";
/// Name of the file that says that a study has made the journal's folder: made first, removed last.
const MARK: &str = ".study";
/// Names of the journal's files, beside those of blocks.
const NAMES: [&str; 3] = ["plan.json", "shard", "list.txt"];
/// Name of the lock.
const LOCK: &str = ".study.lock";
/// Content of the lock of a folder that a study has written results into.
const MARKED: &str = "The results in this folder were written by `gearwise study`, which may replace them.\n";
/// Digits of a line's checksum.
const DIGITS: usize = 16;
/// Most files whose hash is remembered while a journal is checked.
const KEPT: usize = 4096;

/// An open journal; no other process has it open.
#[derive(Debug)]
pub struct Journal {
    folder: PathBuf,
    /// What is studied.
    pub plan: Plan,
    /// Which part of it.
    pub shard: Shard,
    _lock: Lock,
}

/// The file of a block, open for appending.
#[derive(Debug)]
pub struct Block {
    path: PathBuf,
    // The file, and its length up to the last whole line.
    file: Mutex<(File, u64)>,
}

/// That no other process works in a folder. The system lets go of it when the process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    file: Option<File>,
}

impl Journal {
    /// Whether a folder has a journal.
    pub fn is_in(out: &Path) -> bool {
        let folder = out.join(FOLDER);
        folder.join("plan.json").is_file() && is_own(&folder)
    }

    /// Begins a journal, in place of any that is there.
    ///
    /// # Errors
    /// It cannot be written; there is a folder of its name that no study has made.
    pub fn begin(out: &Path, lock: Lock, plan: Plan, shard: Shard, list: &Path) -> Result<Journal, StudyError> {
        let folder = out.join(FOLDER);
        Journal::remove(out)?;
        make_folder(&folder).map_err(StudyError::Argument)?;
        let write =
            |name: &str, text: String| write_whole(&folder.join(name), text.as_bytes()).map_err(StudyError::Argument);
        // The mark has nothing in it and needs no file beside it: a folder with anything in it is marked.
        let mark = folder.join(MARK);
        File::create(&mark).map_err(|e| StudyError::file("write", &mark, &e))?;
        lock.mark(out)?;
        let target = folder.join("list.txt");
        fs::rename(list, &target).map_err(|e| StudyError::file("write", &target, &e))?;
        write("shard", format!("{shard}\n"))?;
        // The plan is written last: a folder without it has no journal.
        write("plan.json", json(&plan)?)?;
        sync_folder(out).map_err(|e| StudyError::file("write", out, &e))?;
        Ok(Journal { folder, plan, shard, _lock: lock })
    }

    /// Opens a journal that is there.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn open(out: &Path, lock: Lock) -> Result<Journal, StudyError> {
        let folder = out.join(FOLDER);
        let read = |name: &str| {
            let path = folder.join(name);
            fs::read_to_string(&path).map_err(|e| StudyError::file("read", &path, &e))
        };
        let damaged =
            |what: &str| StudyError::Argument(format!("the journal in `{}` is damaged: {what}", out.display()));
        let shard = Shard::parse(read("shard")?.trim()).map_err(|_| damaged("its shard cannot be read"))?;
        let plan: Plan = serde_json::from_str(&read("plan.json")?).map_err(|_| damaged("its plan cannot be read"))?;
        Ok(Journal { folder, plan, shard, _lock: lock })
    }

    /// Takes the journal away, the plan first: what is left of a removal that was interrupted is no journal. Of the
    /// folder its own files go; one with anything else in it stays.
    ///
    /// # Errors
    /// It cannot be removed, or no study has made it.
    pub fn remove(out: &Path) -> Result<(), StudyError> {
        let folder = out.join(FOLDER);
        Journal::check_own(out)?;
        let fail = |e: std::io::Error| StudyError::file("remove", &folder, &e);
        let entries = match fs::read_dir(&folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(fail(error)),
        };
        let plan = folder.join("plan.json");
        if plan.exists() {
            fs::remove_file(&plan).map_err(fail)?;
        }
        for entry in entries {
            let entry = entry.map_err(fail)?;
            let own = entry.file_name().to_str().is_some_and(is_own_name);
            if own && entry.path() != plan && entry.file_type().is_ok_and(|kind| kind.is_file()) {
                fs::remove_file(entry.path()).map_err(fail)?;
            }
        }
        let mark = folder.join(MARK);
        if mark.exists() {
            fs::remove_file(&mark).map_err(fail)?;
        }
        match fs::remove_dir(&folder) {
            Err(error) if error.kind() != std::io::ErrorKind::DirectoryNotEmpty => Err(fail(error)),
            _ => Ok(()),
        }
    }

    /// That the place of a journal is free: nothing is there, or what a study has made.
    ///
    /// # Errors
    /// It is not.
    pub fn check_own(out: &Path) -> Result<(), StudyError> {
        let folder = out.join(FOLDER);
        let is_empty = fs::read_dir(&folder).is_ok_and(|mut entries| entries.next().is_none());
        if is_empty || is_own(&folder) || folder.symlink_metadata().is_err() {
            return Ok(());
        }
        Err(StudyError::Argument(format!(
            "`{}` was not made by a study and is left as it is: a study keeps its journal under this name; \
             name another folder for the results, or move it away",
            folder.display()
        )))
    }

    /// Where the list of requirements is.
    pub fn list(&self) -> PathBuf {
        self.folder.join("list.txt")
    }

    /// The requirements from one on, each with its number.
    ///
    /// # Errors
    /// The list cannot be read.
    pub fn requirements(&self, from: u64) -> Result<Requirements, StudyError> {
        let path = self.list();
        let file = File::open(&path).map_err(|e| StudyError::file("read", &path, &e))?;
        let mut requirements = Requirements { path, lines: BufReader::new(file), next: 0, current: None };
        while requirements.next < from {
            requirements.advance()?;
        }
        Ok(requirements)
    }

    fn path_of(&self, block: u64) -> PathBuf {
        self.folder.join(format!("block-{block:08}.jsonl"))
    }

    /// What is finished of a block, in the order of the robots. Lines that were not written to their end
    /// are left out.
    ///
    /// # Errors
    /// The file is there but cannot be read.
    pub fn read(&self, block: u64) -> Result<Vec<Record>, StudyError> {
        let path = self.path_of(block);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(error) => return Err(StudyError::file("read", &path, &error)),
        };
        let mut records: Vec<Record> = bytes.split_inclusive(|b| *b == b'\n').filter_map(record_of).collect();
        let robots = self.plan.robots_of(block);
        records.retain(|r| robots.contains(&r.robot));
        records.sort_by_key(|r| r.robot);
        records.dedup_by_key(|r| r.robot);
        Ok(records)
    }

    /// Opens a block for appending after the records that are kept of it; the rest of the file goes.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn append(&self, block: u64, kept: &[Record]) -> Result<Block, StudyError> {
        let path = self.path_of(block);
        if path.exists() {
            let mut bytes = Vec::new();
            for record in kept {
                bytes.extend(line_of(record)?);
            }
            write_whole(&path, &bytes).map_err(StudyError::Argument)?;
        }
        let file = OpenOptions::new().create(true).append(true).open(&path);
        let file = file.and_then(|file| sync_folder(&self.folder).map(|()| file));
        let file = file.and_then(|file| file.metadata().map(|m| (file, m.len())));
        let file = file.map_err(|e| StudyError::file("write", &path, &e))?;
        Ok(Block { path, file: Mutex::new(file) })
    }

    /// How many robots are finished, where the files that they were made of are what they were. Broken robots count as not finished: they are tried again.
    ///
    /// # Errors
    /// A file has changed since its robot was finished, or the journal cannot be read.
    pub fn check(&self, base: &Path) -> Result<u64, StudyError> {
        let mut hashes: HashMap<String, Option<String>> = HashMap::new();
        let mut done = 0;
        for block in (0..self.plan.blocks()).filter(|b| self.shard.has(*b)) {
            for record in self.read(block)?.iter().filter(|r| r.broken.is_none()) {
                done += 1;
                for (file, hash) in &record.inputs {
                    if hashes.len() >= KEPT {
                        hashes.clear();
                    }
                    let now = hashes
                        .entry(file.clone())
                        .or_insert_with(|| Source::read(&base.join(file)).ok().map(|s| s.sha256()));
                    if now.as_deref() != Some(hash) {
                        let what = if now.is_some() { "has changed" } else { "cannot be read any more" };
                        return Err(StudyError::Argument(format!(
                            "`{file}` {what} since robot {} was finished with it; put it back, or start again with `--force`",
                            record.robot
                        )));
                    }
                }
            }
        }
        Ok(done)
    }

    /// How many robots of its shard are recorded, broken ones too.
    ///
    /// # Errors
    /// The journal cannot be read.
    pub fn recorded(&self) -> Result<u64, StudyError> {
        let blocks = (0..self.plan.blocks()).filter(|b| self.shard.has(*b));
        blocks.map(|b| self.read(b).map(|r| r.len() as u64)).sum()
    }
}

/// True if a study has made a journal's folder: it is marked, or, of an earlier version, has the plan of one.
fn is_own(folder: &Path) -> bool {
    let planned = || fs::read(folder.join("plan.json")).ok().and_then(|text| serde_json::from_slice(&text).ok());
    folder.join(MARK).is_file() || planned().is_some_and(|plan: serde_json::Value| plan.get("gearwise").is_some())
}

/// True if a file of a journal's folder is the journal's by its name, or a remnant of one from a killed process.
fn is_own_name(name: &str) -> bool {
    let is_block = |name: &str| {
        let number = name.strip_prefix("block-").and_then(|rest| rest.strip_suffix(".jsonl"));
        number.is_some_and(|number| number.len() >= 8 && number.bytes().all(|b| b.is_ascii_digit()))
    };
    let is = |name: &str| NAMES.contains(&name) || name == MARK || is_block(name);
    let of_part = |name: &str| {
        let part = name.strip_prefix('.').and_then(|rest| rest.strip_suffix(".part"));
        part.and_then(|rest| rest.rsplit_once('.')).is_some_and(|(name, _)| is(name))
    };
    name != MARK && (is(name) || of_part(name))
}

impl Block {
    /// Adds a finished robot: when this returns, it outlives the process.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&self, record: &Record) -> Result<(), StudyError> {
        let line = line_of(record)?;
        let mut guard = self.file.lock().expect("no thread panicked");
        let (file, length) = &mut *guard;
        if let Err(error) = file.write_all(&line) {
            // Half a line would spoil the next one.
            let _ = file.set_len(*length);
            return Err(StudyError::file("write", &self.path, &error));
        }
        *length += line.len() as u64;
        Ok(())
    }

    /// Makes sure that a power failure does not take the block either.
    ///
    /// # Errors
    /// The disk fails.
    pub fn finish(&self) -> Result<(), StudyError> {
        let file = self.file.lock().expect("no thread panicked");
        file.0.sync_data().map_err(|e| StudyError::file("write", &self.path, &e))
    }
}

fn json(value: &impl serde::Serialize) -> Result<String, StudyError> {
    serde_json::to_string(value).map_err(|e| StudyError::Argument(format!("cannot write a record: {e}")))
}

fn checksum(text: &[u8]) -> String {
    sha256([text])[..DIGITS].to_string()
}

fn line_of(record: &Record) -> Result<Vec<u8>, StudyError> {
    let text = json(record)?;
    Ok(format!("{} {text}\n", checksum(text.as_bytes())).into_bytes())
}

/// The record of a line, if the line is whole.
fn record_of(line: &[u8]) -> Option<Record> {
    let line = line.strip_suffix(b"\n")?;
    let (sum, text) = line.split_at_checked(DIGITS)?;
    let text = text.strip_prefix(b" ")?;
    (sum == checksum(text).as_bytes()).then(|| serde_json::from_slice(text).ok()).flatten()
}

impl Lock {
    /// Keeps other processes away from a folder. Where the file system knows no locks, nothing does.
    ///
    /// # Errors
    /// Another process works there, or the folder cannot be written.
    pub fn take(out: &Path) -> Result<Lock, StudyError> {
        make_folder(out).map_err(StudyError::Argument)?;
        let path = out.join(LOCK);
        let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path);
        let file = file.map_err(|e| StudyError::file("write", &path, &e))?;
        match file.try_lock() {
            Ok(()) => Ok(Lock { file: Some(file) }),
            Err(TryLockError::WouldBlock) => {
                Err(StudyError::Argument(format!("another process works on the study in `{}`", out.display())))
            }
            Err(TryLockError::Error(_)) => Ok(Lock { file: None }),
        }
    }

    /// Marks the folder as one whose results a study has written.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn mark(&self, out: &Path) -> Result<(), StudyError> {
        let path = out.join(LOCK);
        let written = match &self.file {
            // Not as a file of its own that takes its place: the lock is of this one.
            Some(file) => {
                let mut file: &File = file;
                file.set_len(0).and_then(|()| file.write_all(MARKED.as_bytes())).and_then(|()| file.sync_all())
            }
            None => fs::write(&path, MARKED),
        };
        written.map_err(|e| StudyError::file("write", &path, &e))
    }

    /// True if a study has written the results in a folder.
    pub fn is_marked(out: &Path) -> bool {
        fs::read(out.join(LOCK)).is_ok_and(|text| text == MARKED.as_bytes())
    }

    /// Takes away a folder that was made for a study that did not begin; one with anything else in it stays.
    pub fn forget(out: &Path) {
        if Journal::is_in(out) {
            return;
        }
        let entries = fs::read_dir(out).map(|entries| entries.count());
        if matches!(entries, Ok(1)) && fs::remove_file(out.join(LOCK)).is_ok() {
            let _ = fs::remove_dir(out);
        }
    }
}

/// The requirements of a study, read from its list as they are needed.
#[derive(Debug)]
pub struct Requirements {
    path: PathBuf,
    lines: BufReader<File>,
    next: u64,
    current: Option<(u64, String)>,
}

impl Requirements {
    fn advance(&mut self) -> Result<(), StudyError> {
        let mut line = String::new();
        let read = self.lines.read_line(&mut line).map_err(|e| StudyError::file("read", &self.path, &e))?;
        if read == 0 {
            return Err(StudyError::Argument(format!("the list `{}` ends too early", self.path.display())));
        }
        self.current = Some((self.next, line.trim_end_matches('\n').to_string()));
        self.next += 1;
        Ok(())
    }

    /// The requirement with this number; numbers are asked for in order.
    ///
    /// # Errors
    /// The list cannot be read, or ends before it.
    pub fn get(&mut self, number: u64) -> Result<&str, StudyError> {
        while self.current.as_ref().is_none_or(|(n, _)| *n < number) {
            self.advance()?;
        }
        Ok(self.current.as_ref().map_or("", |(_, name)| name))
    }
}

/// Writes the list of requirements to a file; gives their number and the list's SHA-256.
///
/// # Errors
/// What [`work::walk`] says, and a file that cannot be written.
pub fn write_list(base: &Path, paths: &[String], to: &Path) -> Result<(u64, String), StudyError> {
    let fail = |e: std::io::Error| StudyError::file("write", to, &e);
    let mut file = BufWriter::new(File::create(to).map_err(fail)?);
    let (mut count, mut hash) = (0, Sha256::new());
    work::walk(base, paths, &mut |name| {
        count += 1;
        hash.update(name);
        hash.update(b"\n");
        writeln!(file, "{name}").map_err(fail)
    })?;
    file.flush().and_then(|()| file.get_ref().sync_all()).map_err(fail)?;
    Ok((count, hex(&hash.finalize())))
}

// A block is read and held as a whole.
const _: () = assert!(BLOCK <= 1024);
