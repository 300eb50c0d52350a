//! Which files were read: whoever writes down what a result rests on lets the readers tell.
//!
//! The one idea: the hash is of the bytes that were read, not of what stands in the file later.

use std::cell::RefCell;

use hmac_sha256::Hash as Sha256;

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct InputFile {
    /// The name it was opened by.
    pub name: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
}

thread_local! {
    static READ: RefCell<Option<Vec<InputFile>>> = const { RefCell::new(None) };
}

/// Notes the files that this thread reads, as long as it lives.
///
/// ```
/// use gearwise::input::Recording;
/// let recording = Recording::start();
/// gearwise::requirement::read("requirements/quadruped_mini_cheetah.toml".as_ref()).unwrap();
/// assert!(recording.files().iter().any(|f| f.name.ends_with("quadruped_mini_cheetah.toml")));
/// ```
#[derive(Debug)]
pub struct Recording(());

impl Recording {
    /// Begins; what an earlier one noted is forgotten.
    pub fn start() -> Recording {
        READ.set(Some(Vec::new()));
        Recording(())
    }

    /// The files read since, each once, by name.
    pub fn files(&self) -> Vec<InputFile> {
        let mut files = READ.with_borrow(|read| read.clone().unwrap_or_default());
        files.sort();
        files.dedup();
        files
    }
}

impl Drop for Recording {
    fn drop(&mut self) {
        READ.set(None);
    }
}

/// SHA-256 of several pieces, one after the other, hexadecimal.
pub fn sha256<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Sha256::new();
    pieces.into_iter().for_each(|piece| hash.update(piece));
    super::hex(&hash.finalize())
}

/// A reader tells what it has read; the hash is only asked for where someone listens.
pub(crate) fn was_read(name: &str, hash: impl FnOnce() -> String) {
    READ.with_borrow_mut(|read| {
        if let Some(files) = read {
            files.push(InputFile { name: name.into(), sha256: hash() });
        }
    });
}
