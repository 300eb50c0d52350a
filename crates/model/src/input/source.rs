//! A file's text, the problems found in it, and how they are shown.

use std::borrow::Cow;
use std::collections::HashSet;
use std::fmt;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use codespan_reporting::diagnostic::{Diagnostic, Label};
use codespan_reporting::files::{self, Files, SimpleFile};
use codespan_reporting::term;
use hmac_sha256::Hash as Sha256;

use super::file::{self, Opened};
use super::key_path::key_path;
use super::limits;
use crate::output::inputs;
use crate::words::{cut, is_bidirectional_control};

/// At most this many problems of one file are printed; the rest are counted.
const MAX_SHOWN: usize = 50;

/// The text of one input file and the name it was opened by.
#[derive(Debug, Clone)]
pub struct Source {
    name: String,
    path: PathBuf,
    text: String,
    // Whether the file began with a byte order mark, which the text does not have.
    marked: bool,
    // Of an excerpt: the number in the file of each of its lines. Empty where the text is the whole file.
    lines: Vec<usize>,
    // Whether it is no file: values of a program, written down as TOML to be read like one.
    of_values: bool,
    // Files that take the place of others, each with the name that it is meant by.
    files: Vec<(String, PathBuf)>,
}

/// A file that a result rests on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct InputFile {
    /// The name it was opened by.
    pub name: String,
    /// SHA-256 of the bytes that were read, hexadecimal.
    pub sha256: String,
}

/// SHA-256 of several pieces, one after the other, hexadecimal.
pub fn sha256<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Sha256::new();
    pieces.into_iter().for_each(|piece| hash.update(piece));
    hex(&hash.finalize())
}

/// The name of standard input in messages.
const STDIN_NAME: &str = "<stdin>";

impl Source {
    /// What standard input is called on the command line.
    pub const STDIN: &str = "-";

    /// Reads a file.
    ///
    /// # Errors
    /// The file is missing, no file, too large (see [`limits`]), changed while it was read, or not UTF-8; the message
    /// names the nearest file of the same folder where one is missing.
    pub fn read(path: &Path) -> Result<Arc<Source>, InputError> {
        let name = path.display().to_string();
        let fail = |problem: Problem| InputError {
            source: Arc::new(Source::new(name.clone(), String::new())),
            problems: vec![problem],
        };
        let table = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
        let most = if table { limits::TABLE_BYTES } else { limits::TEXT_BYTES };
        let opened = Opened::new(path, most).map_err(|problem| {
            let missing = !path.exists();
            let near = neighbour(path).filter(|_| missing).map(|n| format!("there is `{n}` in that folder"));
            fail(Problem { help: problem.help.clone().or(near), ..problem })
        })?;
        let bytes = opened.read(most).map_err(fail)?;
        let text = file::text(bytes).map_err(fail)?;
        Ok(Arc::new(Source { path: path.to_path_buf(), ..Source::new(name, text) }))
    }

    /// Reads a file that is named on the command line: `-` is standard input, whose relative paths start from the
    /// working directory.
    ///
    /// # Errors
    /// As [`Source::read`]; that nothing came.
    pub fn argument(path: &Path) -> Result<Arc<Source>, InputError> {
        if path.as_os_str() != Source::STDIN {
            return Source::read(path);
        }
        let fail = |problem: Problem| InputError {
            source: Arc::new(Source::new(STDIN_NAME, String::new())),
            problems: vec![problem],
        };
        inputs::read_stdin();
        let mut bytes = Vec::new();
        let most = limits::TABLE_BYTES;
        let cannot = |e: std::io::Error| Problem::whole(format!("cannot read it: {}", crate::words::reason(&e)));
        std::io::stdin().lock().take(most + 1).read_to_end(&mut bytes).map_err(|e| fail(cannot(e)))?;
        if let Some(problem) = limits::bytes(bytes.len() as u64, most) {
            return Err(fail(problem));
        }
        if bytes.is_empty() {
            return Err(fail(Problem::whole("nothing came on standard input")));
        }
        let text = file::text(bytes).map_err(fail)?;
        Ok(Arc::new(Source::new(STDIN_NAME, text)))
    }

    /// Whether it came from standard input.
    pub fn is_stdin(&self) -> bool {
        self.name == STDIN_NAME
    }

    /// A source from text at hand, under a name for messages.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Source {
        let name = name.into();
        let mut text = text.into();
        let marked = text.starts_with('\u{feff}');
        if marked {
            text.drain(..3);
        }
        Source {
            path: PathBuf::from(&name),
            name,
            text,
            marked,
            lines: Vec::new(),
            of_values: false,
            files: Vec::new(),
        }
    }

    /// Values of a program, written down as TOML to be read by the readers of files. A bare number is SI, and a mistake
    /// has the path of its key in place of a line.
    pub fn of_values(name: impl Into<String>, text: impl Into<String>) -> Source {
        Source { path: PathBuf::new(), of_values: true, ..Source::new(name, text) }
    }

    /// The same with files that take the place of those that it names, each with the name that it has there.
    #[must_use]
    pub fn with_files(self, files: Vec<(String, PathBuf)>) -> Source {
        Source { files, ..self }
    }

    /// Where a file is that this one names: next to it, unless another takes its place.
    pub fn file_for(&self, name: &str) -> PathBuf {
        let given = self.files.iter().find(|(known, _)| known == name);
        given.map_or_else(|| self.folder().join(name), |(_, path)| path.clone())
    }

    /// Whether it is values of a program, and no file.
    pub fn is_of_values(&self) -> bool {
        self.of_values
    }

    /// Some lines of a file that is too large to be kept, each with its number (from 1) and without line end.
    pub fn excerpt(name: impl Into<String>, lines: &[(usize, String)]) -> Source {
        let mut source = Source::new(name, "");
        for (number, line) in lines {
            source.lines.push(*number);
            source.text.push_str(line);
            source.text.push('\n');
        }
        source
    }

    /// The name it was opened by.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text, without a byte order mark.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// SHA-256 of the file as it was read, in hexadecimal digits.
    pub fn sha256(&self) -> String {
        let mark: &[u8] = if self.marked { &[0xef, 0xbb, 0xbf] } else { &[] };
        sha256([mark, self.text.as_bytes()])
    }

    /// Its name with its hash: what a result that rests on it writes down.
    pub fn file(&self) -> InputFile {
        InputFile { name: self.name.clone(), sha256: self.sha256() }
    }

    /// The folder that relative paths in this file start from.
    pub fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new(""))
    }

    /// Line and column (both from 1, columns in characters) of a byte position.
    pub fn position(&self, byte: usize) -> (usize, usize) {
        let before = &self.text[..byte.min(self.text.len())];
        let start = before.rfind('\n').map_or(0, |p| p + 1);
        (self.line_number(before.matches('\n').count()), before[start..].chars().count() + 1)
    }

    /// Where a problem is: line and column, or the path of its key in values of a program; empty for the whole.
    pub fn place(&self, problem: &Problem) -> String {
        let Some(span) = &problem.span else { return String::new() };
        if self.of_values {
            let path = key_path(&self.text, span);
            return if path.is_empty() { path } else { format!(" {path}") };
        }
        let (line, column) = self.position(span.start);
        format!("{line}:{column}")
    }

    /// The number in the file of a line of the text (counted from 0).
    fn line_number(&self, index: usize) -> usize {
        self.lines.get(index).copied().unwrap_or(index + 1)
    }
}

/// The text for the terminal, with the line numbers of the file that an excerpt is of.
struct Numbered<'a> {
    source: &'a Source,
    file: SimpleFile<String, &'a str>,
}

impl<'a> Files<'a> for Numbered<'a> {
    type FileId = ();
    type Name = String;
    type Source = &'a str;

    fn name(&'a self, (): ()) -> Result<String, files::Error> {
        Ok(self.file.name().clone())
    }

    fn source(&'a self, (): ()) -> Result<&'a str, files::Error> {
        Ok(self.file.source())
    }

    fn line_index(&'a self, (): (), byte: usize) -> Result<usize, files::Error> {
        Files::line_index(&self.file, (), byte)
    }

    fn line_number(&'a self, (): (), index: usize) -> Result<usize, files::Error> {
        Ok(self.source.line_number(index))
    }

    fn line_range(&'a self, (): (), index: usize) -> Result<Range<usize>, files::Error> {
        Files::line_range(&self.file, (), index)
    }
}

/// Bytes in hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

fn neighbour(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .ok()?
        .take(10_000)
        .flatten()
        .filter_map(|e| e.file_name().into_string().ok())
        .collect();
    names.sort();
    crate::words::nearest(path.file_name()?.to_str()?, names.iter().map(String::as_str)).map(String::from)
}

/// A part of a message that may quote a file, cut to a length that can be read.
fn bounded(text: String) -> String {
    match cut(&text, limits::REPORT_CHARACTERS) {
        Cow::Owned(cut) => cut,
        Cow::Borrowed(_) => text,
    }
}

/// One mistake in an input file.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// What is wrong, in one line.
    pub message: String,
    /// The bytes of the text that it is about; `None` for the file as a whole.
    pub span: Option<Range<usize>>,
    /// What stands under the marked text: what was expected.
    pub label: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Problem {
    /// A problem at a place.
    pub fn at(span: Range<usize>, message: impl Into<String>, label: impl Into<String>) -> Problem {
        let (message, label) = (bounded(message.into()), bounded(label.into()));
        Problem { message, span: Some(span), label, help: None }
    }

    /// A problem of the whole file.
    pub fn whole(message: impl Into<String>) -> Problem {
        Problem { message: bounded(message.into()), span: None, label: String::new(), help: None }
    }

    /// Adds what to do about it.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Problem {
        self.help = Some(bounded(help.into()));
        self
    }

    /// Put another help in the place of one.
    pub(super) fn replace_help(&mut self, old: &str, new: &str) {
        if self.help.as_deref() == Some(old) {
            self.help = Some(bounded(new.into()));
        }
    }

    /// Adds the nearest valid name, where there is one, else the list of valid names.
    #[must_use]
    pub fn suggest<'a>(self, text: &str, names: impl IntoIterator<Item = &'a str> + Clone) -> Problem {
        match crate::words::nearest(text, names.clone()) {
            Some(near) => self.help(format!("did you mean `{near}`?")),
            None => {
                let names: Vec<&str> = names.into_iter().collect();
                // A list that is a little longer is shown whole.
                let shown = if names.len() <= 50 { names.len() } else { 40 };
                let more =
                    if names.len() > shown { format!(", and {} more", names.len() - shown) } else { String::new() };
                self.help(format!("valid here: {}{more}", names[..shown].join(", ")))
            }
        }
    }
}

/// All mistakes of one input file, with its text. Displays as the error report a person reads.
#[derive(Debug, Clone)]
pub struct InputError {
    /// The file.
    pub source: Arc<Source>,
    /// What is wrong in it; never empty.
    pub problems: Vec<Problem>,
}

impl InputError {
    /// What is wrong with a file, told where another one names it.
    pub fn where_named(self, what: &str, name: &str, span: Range<usize>) -> Problem {
        let first = self.problems.into_iter().next();
        let (message, help) = first.map_or((String::new(), None), |p| (p.message, p.help));
        Problem { help, ..Problem::at(span, format!("{what} `{name}`: {message}"), "named here") }
    }

    /// `Err` with the problems if there are any, ordered by their place.
    ///
    /// # Errors
    /// When `problems` is not empty.
    pub fn unless_empty(source: &Arc<Source>, mut problems: Vec<Problem>) -> Result<(), InputError> {
        if problems.is_empty() {
            return Ok(());
        }
        problems.sort_by_key(|p| p.span.as_ref().map_or(0, |s| s.start));
        // A table that is read for several things is wrong once.
        let mut said: HashSet<(Option<Range<usize>>, String)> = HashSet::new();
        problems.retain(|p| said.insert((p.span.clone(), p.message.clone())));
        Err(InputError { source: source.clone(), problems })
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Nothing of the file drives the terminal, and long lines are cut, so that a file of noise does not print itself.
        let (name, shown) = (printable(&self.source.name), in_place(&self.source.text));
        let file = Numbered { source: &self.source, file: SimpleFile::new(name.clone(), &*shown) };
        let config = term::Config::default();
        for problem in self.problems.iter().take(MAX_SHOWN) {
            // A tab in what is said of a file would only tear its line apart.
            let told = |text: &str| tame(&cut(text, limits::REPORT_CHARACTERS)).replace('\t', " ");
            let (message, label) = (told(&problem.message), told(&problem.label));
            let help = problem.help.as_deref().map(told);
            let long = problem.span.as_ref().is_some_and(|s| {
                let text = &self.source.text;
                let start = text[..s.start.min(text.len())].rfind('\n').map_or(0, |p| p + 1);
                let end = text[s.end.min(text.len())..].find('\n').map_or(text.len(), |p| s.end.min(text.len()) + p);
                end - start > 600
            });
            if long || problem.span.is_none() || self.source.of_values {
                let place = told(&self.source.place(problem));
                let place = if place.is_empty() { place } else { format!(":{place}") };
                writeln!(f, "error: {message}")?;
                writeln!(f, "  ┌─ {name}{place}")?;
                if !label.is_empty() {
                    writeln!(f, "  = {label}")?;
                }
                if let Some(help) = &help {
                    writeln!(f, "  = {help}")?;
                }
                writeln!(f)?;
                continue;
            }
            let span = problem.span.clone().unwrap_or(0..0);
            let diagnostic = Diagnostic::error()
                .with_message(message)
                .with_label(Label::primary((), span).with_message(label))
                .with_notes(help.into_iter().collect());
            let text = term::emit_into_string(&config, &file, &diagnostic).map_err(|_| fmt::Error)?;
            // Those left belong to line ends, which a label over several lines shows.
            f.write_str(&text.replace('\r', ""))?;
        }
        let hidden = self.problems.len().saturating_sub(MAX_SHOWN);
        if hidden > 0 {
            writeln!(f, "and {hidden} more mistakes in {name}")?;
        }
        Ok(())
    }
}

impl std::error::Error for InputError {}

/// A name on one line, without what could drive the terminal.
pub fn printable(name: &str) -> String {
    let odd = |c: char| c.is_control() || is_bidirectional_control(c);
    name.chars().map(|c| if odd(c) { '\u{fffd}' } else { c }).collect()
}

/// True if a character could drive a terminal, or change the order in which it shows text: control characters other
/// than line ends and tabs.
fn drives(c: char, next: Option<char>) -> bool {
    match c {
        '\n' | '\t' => false,
        '\r' => next != Some('\n'),
        _ => c.is_control() || is_bidirectional_control(c),
    }
}

/// Lines of text of which parts come from files, without what could drive a terminal.
pub fn tame(text: &str) -> Cow<'_, str> {
    if !text.contains(|c: char| c != '\n' && drives(c, None)) {
        return text.into();
    }
    let next = text.chars().skip(1).map(Some).chain([None]);
    text.chars().zip(next).map(|(c, next)| if drives(c, next) { '\u{fffd}' } else { c }).collect()
}

/// A text whose control characters, but for those of blanks and line ends, are replaced by signs as long, so that
/// every span stays where it is.
fn in_place(text: &str) -> Cow<'_, str> {
    let mut shown = Cow::Borrowed(text);
    let mut characters = text.char_indices().peekable();
    while let Some((at, c)) = characters.next() {
        if drives(c, characters.peek().map(|(_, next)| *next)) {
            let sign = match c.len_utf8() {
                1 => "?",
                2 => "¿",
                _ => "\u{fffd}",
            };
            shown.to_mut().replace_range(at..at + c.len_utf8(), sign);
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_does_not_drive_the_terminal() {
        let text = "a = \"\u{1b}[2J\u{9b}31m\rb\"\r\nc = 1";
        assert_eq!(in_place(text), "a = \"?[2J¿31m?b\"\r\nc = 1");
        let source = Arc::new(Source::new("\u{1b}.toml", text));
        let problem = Problem::at(5..9, "what \u{7}is\nwrong", "here\u{1b}").help("\u{0}");
        let report = InputError { source, problems: vec![problem, Problem::whole("\u{1b}]0;title\u{7}")] }.to_string();
        assert!(report.chars().all(|c| c == '\n' || !c.is_control()), "{report:?}");
        assert!(report.contains("1 │ a = \"?[2J¿31m?b\"\n") && report.contains("  ^^^^ here\u{fffd}"), "{report}");
    }

    #[test]
    fn no_text_changes_the_direction_of_reading() {
        let marks: Vec<char> =
            "\u{61c}\u{200e}\u{200f}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\u{2066}\u{2067}\u{2068}\u{2069}"
                .chars()
                .collect();
        for mark in marks {
            let text = format!("a = \"{mark}x\"\n");
            let clean = |text: &str| assert!(!text.contains(mark), "{text:?}");
            clean(&tame(&text));
            clean(&printable(&text));
            clean(&in_place(&text));
            assert_eq!(in_place(&text).len(), text.len(), "spans stay");
            let source = Arc::new(Source::new(format!("{mark}.toml"), text.clone()));
            let problem = Problem::at(4..5, format!("m{mark}"), format!("l{mark}")).help(format!("h{mark}"));
            clean(&InputError { source, problems: vec![problem] }.to_string());
        }
        // Letters of languages that are written from the right stay.
        assert_eq!(tame("שלום سلام\tx"), "שלום سلام\tx");
    }

    #[test]
    fn a_report_is_bounded_whatever_it_quotes() {
        let long = "x".repeat(1 << 20);
        let source = Arc::new(Source::new("a.toml", format!("{long} = 1\n")));
        let problem = || Problem {
            message: long.clone(),
            span: Some(0..long.len()),
            label: long.clone(),
            help: Some(long.clone()),
        };
        let error = InputError { source, problems: (0..1000).map(|_| problem()).collect() };
        assert!(error.to_string().len() < 1 << 20);
        let made = Problem::at(0..1, long.clone(), long.clone()).help(long.clone());
        let most = limits::REPORT_CHARACTERS + '…'.len_utf8();
        assert!([made.message, made.label, made.help.unwrap()].iter().all(|text| text.len() <= most));
        assert_eq!(Problem::whole("short").message, "short");
    }
}
