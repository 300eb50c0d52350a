//! Result files: written whole or not at all.
//!
//! The one idea: a file is written beside its place, brought to the disk, and moved there in one step. Whoever looks
//! sees the old file or the new one; what a process that was killed leaves is a hidden `.part` file that nobody reads.
//!
//! A symbolic link is followed, as a shell's `>` follows it: the link stays, what it points to is replaced, or made
//! where it does not exist. A device or a pipe (`/dev/null`, the shell's `>(command)`) is written to as it is. Who may
//! read a file that is replaced stays as it was; one that is write-protected is not replaced.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::words::reason;

/// Most links that lead from one to the next.
const MAX_LINKS: usize = 40;
/// Most names that are tried for a file beside its place; another process may have taken the first ones.
const MAX_NAMES: usize = 1000;

/// Writes a file beside its place and moves it there, so that no one ever sees half of it, and what was
/// there stays where writing fails.
///
/// # Errors
/// In words, where it cannot be written.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let fail = |why: String| format!("cannot write `{}`: {why}", path.display());
    let place = Place::of(path).map_err(fail)?;
    if let Place::Stream = place {
        let written = OpenOptions::new().write(true).open(path).and_then(|mut file| file.write_all(bytes));
        return written.map_err(|e| fail(reason(&e)));
    }
    let mut beside = Beside::new(&place).map_err(fail)?;
    beside.write(bytes).and_then(|()| beside.place()).map_err(|e| fail(reason(&e)))
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
pub(crate) enum Place {
    /// Nothing, or a file with its permissions; the path is without links.
    File(PathBuf, Option<Permissions>),
    /// A device or a pipe.
    Stream,
}

impl Place {
    /// Looks at a path.
    ///
    /// # Errors
    /// Why no file can be written there, in words.
    pub(crate) fn of(path: &Path) -> Result<Place, String> {
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
pub(crate) struct Beside {
    temporary: PathBuf,
    target: PathBuf,
    file: File,
    placed: bool,
}

impl Beside {
    /// Makes it, with a name that nobody has. A name that a killed process left is passed over: process numbers
    /// come again.
    pub(crate) fn new(place: &Place) -> Result<Beside, String> {
        let Place::File(target, permissions) = place else { return Err("it is not a file".into()) };
        let name = target.file_name().ok_or("it has no name")?.to_string_lossy();
        for number in 0..MAX_NAMES {
            let temporary = target.with_file_name(format!(".{name}.{}-{number}.part", std::process::id()));
            match File::create_new(&temporary) {
                Ok(file) => {
                    let beside = Beside { temporary, target: target.clone(), file, placed: false };
                    // Where the file system has no permissions, there are none to keep.
                    let _ = permissions.as_ref().map(|p| fs::set_permissions(&beside.temporary, p.clone()));
                    return Ok(beside);
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    return Err(format!("there is no folder `{}`", folder_of(target).display()));
                }
                Err(error) => return Err(reason(&error)),
            }
        }
        Err("the folder is full of what killed processes have left; remove its hidden `.part` files".into())
    }

    /// Writes all of it, and waits until the disk has it.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        self.file.sync_all()
    }

    /// Its place.
    pub(crate) fn target(&self) -> &Path {
        &self.target
    }

    /// Moves it to its place.
    pub(crate) fn place(&mut self) -> io::Result<()> {
        fs::rename(&self.temporary, &self.target)?;
        self.placed = true;
        Ok(())
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        if !self.placed {
            let _ = fs::remove_file(&self.temporary);
        }
    }
}
