//! A file that is opened to be read: what is no file is refused, what has no end is not read without end, and a
//! file that changes while it is read is not taken for one that did not.
//!
//! The one idea: what was read is either what the file was, or what it is, or an error; never half of each.

use crate::output::inputs;
use crate::words::reason;
use std::fs::{File, Metadata};
use std::io::{self, Read, Seek};
use std::path::Path;
use std::time::{Duration, SystemTime};

use super::{Problem, limits};

/// The clock of file systems is this coarse, with room to spare: a younger file may change without its time
/// saying so.
const FRESH: Duration = Duration::from_millis(200);

/// An open file, and what the system said of it then.
#[derive(Debug)]
pub struct Opened {
    /// To be read from.
    pub file: File,
    before: Metadata,
}

impl Opened {
    /// Opens a file of at most `most` bytes.
    ///
    /// # Errors
    /// It is not there, is too large, or no file: a folder, a device, a named pipe (nobody may ever write to it).
    /// The pipe of a shell's `<(command)` is one.
    pub fn new(path: &Path, most: u64) -> Result<Opened, Problem> {
        let cannot = |e: &io::Error| Problem::whole(format!("cannot read the file: {}", reason(e)));
        // Looked at before it is opened: to open a named pipe waits for its writer.
        let meta = std::fs::metadata(path).map_err(|e| cannot(&e))?;
        if meta.is_dir() {
            return Err(Problem::whole("this is a folder, not a file"));
        }
        let of_shell = (path.starts_with("/dev") || path.starts_with("/proc")) && is_pipe(&meta);
        if !meta.is_file() && !of_shell {
            let what = if is_pipe(&meta) { "a named pipe" } else { "a device" };
            let problem = Problem::whole(format!("this is {what}, not a file"));
            return Err(problem.help("write the text to a file first, or hand it over with the shell's <(command)"));
        }
        let file = File::open(path).map_err(|e| cannot(&e))?;
        let before = file.metadata().map_err(|e| cannot(&e))?;
        match limits::bytes(before.len(), most) {
            Some(problem) => Err(problem),
            None => {
                inputs::read(path, &before);
                Ok(Opened { file, before })
            }
        }
    }

    /// Reads it to its end, at most `most` bytes.
    ///
    /// # Errors
    /// It cannot be read, has more, or changed meanwhile.
    pub fn read(mut self, most: u64) -> Result<Vec<u8>, Problem> {
        let cannot = |e: &io::Error| Problem::whole(format!("cannot read the file: {}", reason(e)));
        let mut bytes = Vec::with_capacity(usize::try_from(self.before.len()).unwrap_or(0));
        // A pipe tells its length only by ending.
        self.file.by_ref().take(most + 1).read_to_end(&mut bytes).map_err(|e| cannot(&e))?;
        if let Some(problem) = limits::bytes(bytes.len() as u64, most) {
            return Err(problem);
        }
        let mut again = Vec::new();
        self.unchanged(|file| {
            file.take(most + 1).read_to_end(&mut again)?;
            Ok(again == bytes)
        })?;
        Ok(bytes)
    }

    /// That the file is what it was when it was opened. The time of a change is told in steps of some milliseconds;
    /// a file that was written only just now is therefore read again by `same`, from its beginning.
    ///
    /// # Errors
    /// It is not.
    pub fn unchanged(mut self, same: impl FnOnce(&mut File) -> io::Result<bool>) -> Result<(), Problem> {
        if !self.before.is_file() {
            return Ok(());
        }
        let is = |after: io::Result<Metadata>| {
            after.is_ok_and(|m| m.len() == self.before.len() && m.modified().ok() == self.before.modified().ok())
        };
        let age = self.before.modified().ok().and_then(|then| SystemTime::now().duration_since(then).ok());
        let fresh = age.is_none_or(|age| age < FRESH);
        let twice = !fresh || self.file.rewind().and_then(|()| same(&mut self.file)).unwrap_or(false);
        if twice && is(self.file.metadata()) {
            return Ok(());
        }
        let problem = Problem::whole("the file was changed while it was read");
        Err(problem.help("run again when nobody writes to it"))
    }
}

#[cfg(unix)]
fn is_pipe(meta: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&meta.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

/// The text of a file's bytes.
///
/// # Errors
/// It is no text in UTF-8; said apart where it is UTF-16.
pub(crate) fn text(bytes: Vec<u8>) -> Result<String, Problem> {
    if let Some(what) = of_bytes(&bytes) {
        return Err(Problem::whole(format!("this is {what}, not a text")));
    }
    if let Some(problem) = utf_16(&bytes) {
        return Err(problem);
    }
    if bytes.iter().take(512).any(|b| *b == 0) {
        return Err(Problem::whole("this is not a text file: it has bytes that are zero"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let before = &error.as_bytes()[..valid];
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        let column = valid - before.iter().rposition(|b| *b == b'\n').map_or(0, |p| p + 1) + 1;
        let message = format!("not a text file: byte {} (line {line}, column {column}) is not UTF-8", valid + 1);
        Problem::whole(message).help("save the file as UTF-8")
    })
}

/// What bytes that are no text are, by how they begin.
fn of_bytes(bytes: &[u8]) -> Option<&'static str> {
    const BEGINNINGS: [(&[u8], &str); 6] = [
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
        (b"%PDF", "a PDF document"),
        (b"PK\x03\x04", "a ZIP archive; spreadsheets are such, and can be saved as CSV"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"PAR1", "a Parquet table"),
    ];
    BEGINNINGS.iter().find(|(begins, _)| bytes.starts_with(begins)).map(|(_, what)| *what)
}

/// A text of two bytes per letter: by its mark, or because every other byte of its beginning is zero.
pub fn utf_16(bytes: &[u8]) -> Option<Problem> {
    let marked = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    let first = &bytes[..bytes.len().min(64) & !1];
    let zeros = |parity: usize| first.iter().skip(parity).step_by(2).filter(|b| **b == 0).count();
    let wide = first.len() >= 4 && zeros(0).max(zeros(1)) * 4 > first.len();
    (marked || wide).then(|| {
        Problem::whole("the text of this file is UTF-16, not UTF-8")
            .help("save it as UTF-8: `CSV UTF-8` in a spreadsheet, `Encoding: UTF-8` in an editor, `-Encoding utf8` in PowerShell")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utf_16_is_known_with_and_without_its_mark() {
        let wide = |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        assert!(utf_16(&wide("name = \"leg\"\n")).is_some());
        assert!(utf_16(&wide("\u{feff}name = \"Ö\"\n")).is_some());
        assert!(utf_16(&"name = \"leg\"\n".encode_utf16().flat_map(u16::to_be_bytes).collect::<Vec<u8>>()).is_some());
        assert!(utf_16("name = \"Größe\"\n".as_bytes()).is_none() && utf_16(b"").is_none() && utf_16(b"ab").is_none());
    }

    #[test]
    fn a_change_while_reading_is_seen() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let (old, new) = ("a".repeat(1000), "b".repeat(1000));
        for longer in [false, true] {
            std::fs::write(&path, &old).unwrap();
            let opened = Opened::new(&path, 1 << 20).unwrap();
            std::fs::write(&path, if longer { new.clone() + "b" } else { new.clone() }).unwrap();
            // What has been read before the change is the old text.
            let seen = opened.unchanged(|file| {
                let mut again = String::new();
                file.read_to_string(&mut again)?;
                Ok(again == old)
            });
            assert!(seen.unwrap_err().message.contains("changed while"), "longer: {longer}");
        }
        // What is moved into its place is another file: the old one is read to its end.
        let opened = Opened::new(&path, 1 << 20).unwrap();
        std::fs::write(folder.path().join("new"), &old).unwrap();
        std::fs::rename(folder.path().join("new"), &path).unwrap();
        assert_eq!(opened.read(1 << 20).unwrap(), (new + "b").into_bytes());
    }
}
