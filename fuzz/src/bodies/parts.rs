//! One input that stands for several files: `== name ==` on a line of its own begins the next of them.

use std::path::Path;
use std::sync::Arc;

use gearwise::input::{InputError, Problem, Source};
use gearwise::requirement::Motions;

/// The files of an input, the first without a name.
pub struct Parts<'a> {
    /// The text before the first name.
    pub main: &'a str,
    /// Name and text of the others.
    pub others: Vec<(String, &'a str)>,
}

impl<'a> Parts<'a> {
    /// `None` where the bytes are not text: no reader but that of logs sees such, and [`Source::read`] refuses it.
    pub fn new(bytes: &'a [u8]) -> Option<Parts<'a>> {
        let text = std::str::from_utf8(bytes).ok()?;
        let (mut names, mut starts, mut ends, mut at) = (Vec::new(), vec![0], Vec::new(), 0);
        for line in text.split_inclusive('\n') {
            let name = line.trim_end().strip_prefix("== ").and_then(|rest| rest.strip_suffix(" =="));
            if let Some(name) = name.filter(|_| names.len() < 8) {
                names.push(plain(name));
                ends.push(at);
                starts.push(at + line.len());
            }
            at += line.len();
        }
        ends.push(text.len());
        let mut texts = starts.iter().zip(&ends).map(|(start, end)| &text[*start..*end]);
        let main = texts.next().unwrap_or_default();
        Some(Parts { main, others: names.into_iter().zip(texts).collect() })
    }

    /// The text of a file.
    pub fn text(&self, name: &str) -> Option<&'a str> {
        self.others.iter().find(|(n, _)| n == name).map(|(_, text)| *text)
    }
}

/// A name that leads nowhere else.
fn plain(name: &str) -> String {
    let name: String =
        name.chars().take(40).map(|c| if c.is_ascii_alphanumeric() || ".-_".contains(c) { c } else { '_' }).collect();
    name.trim_start_matches('.').to_string()
}

/// The files that a requirement names are those of the input, whatever folder it thinks they are in.
impl Motions for Parts<'_> {
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        match self.text(&name) {
            Some(text) => Ok(Arc::new(Source::new(name, text))),
            None => Err(InputError {
                source: Arc::new(Source::new(name, "")),
                problems: vec![Problem::whole("cannot read the file: there is no such file")],
            }),
        }
    }
}
