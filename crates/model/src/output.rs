//! Result files: written whole or not at all.
//!
//! The one idea: a file is written beside its place, brought to the disk, and moved there in one step. Whoever looks
//! sees the old file or the new one; what a process that was killed leaves is a hidden `.part` file that nobody reads.
//!
//! A symbolic link is followed, as a shell's `>` follows it: the link stays, what it points to is replaced, or made
//! where it does not exist. A device or a pipe (`/dev/null`, the shell's `>(command)`) is written to as it is. Who may
//! read a file that is replaced stays as it was; one that is write-protected is not replaced. A file that the same run of
//! the program has read or written is not replaced either, by whatever name it goes ([`inputs`]).

pub mod inputs;
mod lock;

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

pub use self::lock::Locks;
use crate::words::reason;

/// Most links that lead from one to the next.
const MAX_LINKS: usize = 40;
/// Most names that are tried for a file beside its place; another process may have taken the first ones.
const MAX_NAMES: usize = 1000;

/// Writes a file beside its place and moves it there, so that no one ever sees half of it, and what was
/// there stays where writing fails.
///
/// # Errors
/// In words, where it cannot be written, or was read by the same run.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), String> {
    write(path, bytes, Place::of)
}

/// Writes a file like [`write_whole`], also in place of one that the same run has read.
///
/// # Errors
/// In words, where it cannot be written.
pub fn write_over(path: &Path, bytes: &[u8]) -> Result<(), String> {
    write(path, bytes, Place::over)
}

/// Writes a file like [`write_whole`] where there is none yet.
///
/// # Errors
/// In words, where it cannot be written, or is there.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if path.symlink_metadata().is_ok() {
        return Err(format!("`{}` is there already, and is not replaced; name another file", path.display()));
    }
    write(path, bytes, |path| Ok(Place::New(path.to_path_buf())))
}

fn write(path: &Path, bytes: &[u8], place: impl Fn(&Path) -> Result<Place, String>) -> Result<(), String> {
    let fail = |why: String| format!("cannot write `{}`: {why}", path.display());
    let place = place(path).map_err(fail)?;
    if let Place::Stream = place {
        let written = OpenOptions::new().write(true).open(path).and_then(|mut file| file.write_all(bytes));
        return written.map_err(|e| fail(reason(&e)));
    }
    let mut beside = Beside::new(&place).map_err(fail)?;
    let written = beside.write_all(bytes).and_then(|()| beside.sync()).and_then(|()| beside.place());
    written.map_err(|e| fail(reason(&e)))
}

/// Check that a file can be written, before the work whose result it is to hold.
///
/// # Errors
/// As [`write_whole`], but for what is only seen when it is written.
pub fn check(path: &Path) -> Result<(), String> {
    Place::of(path).map(drop).map_err(|why| format!("cannot write `{}`: {why}", path.display()))
}

/// Brings the names of a folder to the disk: after a power failure a file that was moved there is there.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    // Where a folder cannot be opened as a file (Windows), its names are brought there by the system.
    let Ok(folder) = File::open(folder) else { return Ok(()) };
    match folder.sync_all() {
        // Some file systems of networks have no such thing.
        Err(error) if matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => Ok(()),
        done => done,
    }
}

/// Makes a folder, and those that it is in, where they do not exist.
///
/// # Errors
/// In words, where it cannot be made.
pub fn make_folder(path: &Path) -> Result<(), String> {
    fs::create_dir_all(path).map_err(|error| {
        let why = if path.exists() { "there is a file of this name".into() } else { reason(&error) };
        format!("cannot make the folder `{}`: {why}", path.display())
    })
}

/// What stands where a file is to be written.
#[derive(Debug)]
pub enum Place {
    /// Nothing, or a file with its permissions; the path is without links.
    File(PathBuf, Option<Permissions>),
    /// Nothing, and nothing that is made there meanwhile is replaced.
    New(PathBuf),
    /// A device or a pipe.
    Stream,
}

impl Place {
    /// Looks at a path.
    ///
    /// # Errors
    /// Why no file can be written there, in words; it may be that the same run has read or written it.
    pub fn of(path: &Path) -> Result<Place, String> {
        match fs::metadata(path).ok().and_then(|meta| inputs::keeps(path, &meta)) {
            Some(why) => Err(why.into()),
            None => Place::over(path),
        }
    }

    /// Looks at a path that the same run may have read.
    ///
    /// # Errors
    /// Why no file can be written there, in words.
    fn over(path: &Path) -> Result<Place, String> {
        let path = followed(path)?;
        match fs::metadata(&path) {
            Ok(meta) if meta.is_dir() => Err("it is a folder".into()),
            Ok(meta) if meta.is_file() && meta.permissions().readonly() => Err("it is write-protected".into()),
            Ok(meta) if meta.is_file() => Ok(Place::File(path, Some(meta.permissions()))),
            Ok(_) => Ok(Place::Stream),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                let folder = folder_of(&path);
                match fs::metadata(folder) {
                    Ok(meta) if meta.is_dir() => Ok(Place::File(path, None)),
                    Ok(_) => Err(format!("`{}` is not a folder", folder.display())),
                    Err(e) if e.kind() == io::ErrorKind::NotFound => {
                        Err(format!("there is no folder `{}`", folder.display()))
                    }
                    Err(e) => Err(reason(&e)),
                }
            }
            Err(error) => Err(reason(&error)),
        }
    }
}

/// The folder that a file is in.
fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Removes a file, where there is one; a symbolic link stays, what it points to goes.
///
/// # Errors
/// In words, where it cannot be removed, or was read by the same run.
pub fn remove(path: &Path) -> Result<(), String> {
    let fail = |why: String| format!("cannot remove `{}`: {why}", path.display());
    if let Some(why) = fs::metadata(path).ok().and_then(|meta| inputs::keeps(path, &meta)) {
        return Err(fail(why.into()));
    }
    match fs::remove_file(followed(path).map_err(fail)?) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(fail(reason(&error))),
        _ => Ok(()),
    }
}

/// Where a path leads when its last part is a symbolic link, whether or not something is there.
fn followed(path: &Path) -> Result<PathBuf, String> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        match fs::symlink_metadata(&path) {
            // A pipe of the shell is a link to a name that no folder has: it is what the system says it is.
            Ok(meta) if meta.is_symlink() && !fs::metadata(&path).is_ok_and(|m| !m.is_file() && !m.is_dir()) => {
                let target = fs::read_link(&path).map_err(|e| reason(&e))?;
                path = folder_of(&path).join(target);
            }
            _ => return Ok(path),
        }
    }
    Err("its symbolic links lead in a circle".into())
}

/// A file beside its place. Unless it is placed, it goes.
#[derive(Debug)]
pub struct Beside {
    temporary: PathBuf,
    target: PathBuf,
    file: File,
    replaces: bool,
    placed: bool,
}

impl Beside {
    /// Makes it, with a name that nobody has. A name that a killed process left is passed over: process numbers
    /// come again.
    pub(crate) fn new(place: &Place) -> Result<Beside, String> {
        let process = std::process::id();
        for number in 0..MAX_NAMES {
            if let Some(beside) = Beside::named(place, &format!(".{process}-{number}"))? {
                return Ok(beside);
            }
        }
        Err("the folder is full of what killed processes have left; remove its hidden `.part` files".into())
    }

    /// Makes it where a lock keeps other processes away: what a killed one has left of it goes.
    pub fn alone(place: &Place) -> Result<Beside, String> {
        if let Some(temporary) = temporary(place, "")
            && let Err(error) = fs::remove_file(temporary)
            && error.kind() != io::ErrorKind::NotFound
        {
            return Err(reason(&error));
        }
        Beside::named(place, "")?.ok_or_else(|| "another process writes it".into())
    }

    /// Makes it under a name; `None` where that is taken.
    fn named(place: &Place, own: &str) -> Result<Option<Beside>, String> {
        let (target, permissions) = match place {
            Place::File(target, permissions) => (target.clone(), permissions.clone()),
            Place::New(target) => (target.clone(), None),
            Place::Stream => return Err("it is not a file".into()),
        };
        let temporary = temporary(place, own).ok_or("it has no name")?;
        let replaces = !matches!(place, Place::New(_));
        match File::create_new(&temporary) {
            Ok(file) => {
                let beside = Beside { temporary, target, file, replaces, placed: false };
                // Where the file system has no permissions, there are none to keep.
                let _ = permissions.map(|p| fs::set_permissions(&beside.temporary, p));
                Ok(Some(beside))
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(None),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(format!("there is no folder `{}`", folder_of(&target).display()))
            }
            Err(error) => Err(reason(&error)),
        }
    }

    /// Waits until the disk has what was written.
    pub fn sync(&mut self) -> io::Result<()> {
        self.file.sync_all()
    }

    /// Its place.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Moves it to its place, and waits until the disk has that.
    pub fn place(&mut self) -> io::Result<()> {
        if self.replaces {
            fs::rename(&self.temporary, &self.target)?;
            self.placed = true;
        } else if let Err(error) = fs::hard_link(&self.temporary, &self.target) {
            // Where the file system has no hard links, another process may come between.
            if error.kind() == io::ErrorKind::AlreadyExists || self.target.symlink_metadata().is_ok() {
                return Err(io::ErrorKind::AlreadyExists.into());
            }
            fs::rename(&self.temporary, &self.target)?;
            self.placed = true;
        }
        inputs::written(&self.target);
        sync_folder(folder_of(&self.target))
    }
}

impl Write for Beside {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The hidden name beside a place.
fn temporary(place: &Place, own: &str) -> Option<PathBuf> {
    let (Place::File(target, _) | Place::New(target)) = place else { return None };
    let name = target.file_name()?.to_string_lossy();
    Some(target.with_file_name(format!(".{name}{own}.part")))
}

impl Drop for Beside {
    fn drop(&mut self) {
        if !self.placed {
            let _ = fs::remove_file(&self.temporary);
        }
    }
}
