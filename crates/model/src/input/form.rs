//! A TOML file read as a form: each reader asks for the keys it knows, with the kind and range of
//! their values; what it did not ask for is an unknown key.

mod values;

use std::cell::RefCell;
use std::ops::Range as Span;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::describe::Asked;
use super::{Change, Description, InputError, Key, Problem, Source, limits};
use crate::words::shorten;

/// At most this many mistakes of syntax are collected: they tend to follow from each other.
const MOST_SYNTAX: usize = 100;

/// A parsed TOML file together with the problems found in it so far.
#[derive(Debug)]
pub struct Form {
    source: Arc<Source>,
    problems: RefCell<Vec<Problem>>,
    // What is asked for, where that is written down.
    described: Option<RefCell<Description>>,
    // Values that were put in the place of the file's own.
    changes: Vec<Change>,
    // Bare numbers of a program that were read as quantities: where they are, and their unit.
    bare: RefCell<Vec<(Span<usize>, &'static str)>>,
}

impl Form {
    /// Parses the file and lets `read` take what it knows from the top-level table. Whatever
    /// `read` returns counts only when no problem was found.
    ///
    /// # Errors
    /// All syntax errors, and all problems that `read` or the sections noted.
    pub fn read<T>(source: &Arc<Source>, read: impl FnOnce(&Section) -> Option<T>) -> Result<T, InputError> {
        Form::read_changed(source, &[], read)
    }

    /// What `read` asks for, over a skeleton of a file: TOML that has every table which the reader looks into. What is
    /// missing or wrong in it does not matter.
    pub fn describe<T>(skeleton: &str, read: impl FnOnce(&Section) -> Option<T>) -> Description {
        let source = Arc::new(Source::new("skeleton.toml", skeleton));
        let form = Form { described: Some(RefCell::default()), ..Form::new(&source, &[]) };
        let (table, errors) = DeTable::parse_recoverable(source.text());
        debug_assert!(errors.is_empty(), "the skeleton is TOML: {errors:?}");
        read(&form.root(table.get_ref()));
        form.described.unwrap_or_default().into_inner()
    }

    fn new(source: &Arc<Source>, changes: &[Change]) -> Form {
        Form {
            source: source.clone(),
            problems: RefCell::default(),
            described: None,
            changes: changes.to_vec(),
            bare: RefCell::default(),
        }
    }

    /// Bare numbers of values of a program ([`Source::of_values`], [`Change::of_values`]) that `read` takes for quantities, each
    /// with its place and its SI unit: what a file has to say of them.
    pub fn bare_numbers<T>(
        source: &Arc<Source>,
        changes: &[Change],
        read: impl FnOnce(&Section) -> Option<T>,
    ) -> Vec<(Span<usize>, &'static str)> {
        let form = Form::new(source, changes);
        let (mut table, _) = DeTable::parse_recoverable(source.text());
        // What is wrong was said when it was read.
        changes.iter().for_each(|change| drop(change.apply(table.get_mut())));
        read(&form.root(table.get_ref()));
        form.bare.into_inner()
    }

    /// The table at the top.
    fn root<'a>(&'a self, table: &'a DeTable<'a>) -> Section<'a> {
        self.reach("");
        Section { form: self, table, span: 0..0, path: String::new(), asked: RefCell::default() }
    }

    fn reach(&self, path: &str) {
        if let Some(described) = &self.described {
            described.borrow_mut().reach(path);
        }
    }

    /// What was read of a file together with the mistakes of the files that it names: its own come first, and
    /// it says nothing of its own where it failed only because of them.
    ///
    /// # Errors
    /// All of them.
    pub fn with_others<T>(read: Result<T, InputError>, others: Vec<InputError>) -> Result<T, Vec<InputError>> {
        match read {
            Ok(read) if others.is_empty() => Ok(read),
            Ok(_) => Err(others),
            Err(error) => {
                let own = others.is_empty() || error.problems.iter().any(|p| p.span.is_some());
                Err(own.then_some(error).into_iter().chain(others).collect())
            }
        }
    }

    /// As [`Form::read`], with values put in the place of the file's own first.
    ///
    /// # Errors
    /// As [`Form::read`]. The span of a problem with a value that was put in lies beyond
    /// [`Change::ELSEWHERE`](super::Change::ELSEWHERE).
    pub fn read_changed<T>(
        source: &Arc<Source>,
        changes: &[Change],
        read: impl FnOnce(&Section) -> Option<T>,
    ) -> Result<T, InputError> {
        let form = Form::new(source, changes);
        let (mut table, errors) = DeTable::parse_recoverable(source.text());
        if errors.is_empty() {
            for change in changes {
                if let Err(problem) = change.apply(table.get_mut()) {
                    form.note(problem);
                }
            }
        }
        for error in errors.iter().take(MOST_SYNTAX) {
            let message = error.message().lines().next().unwrap_or("not valid TOML").to_string();
            let end = source.text().len();
            let span = error.span().map_or(0..0, |s| s.start.min(end)..s.end.min(end));
            let comma = decimal_comma(source.text(), span.start);
            let problem = Problem::at(span, format!("not valid TOML: {message}"), "here");
            let problem = if comma { problem.help("numbers have a decimal point, not a comma") } else { problem };
            // The parser may say one thing twice while it finds its way.
            if !form.problems.borrow().contains(&problem) {
                form.note(problem);
            }
        }
        // After a syntax error the rest of the table is a guess: report the syntax alone.
        let result = if errors.is_empty() {
            let root = form.root(table.get_ref());
            let value = read(&root);
            root.finish();
            value
        } else {
            None
        };
        InputError::unless_empty(source, form.problems.into_inner())?;
        result.ok_or_else(|| InputError {
            source: source.clone(),
            problems: vec![Problem::whole("the file could not be read")],
        })
    }

    /// Whether what stands there is a value of a program, in which a bare number is SI.
    fn is_of_values(&self, span: &Span<usize>) -> bool {
        match span.start < Change::ELSEWHERE {
            true => self.source.is_of_values(),
            false => Change::is_of_values(span, &self.changes),
        }
    }

    fn note(&self, problem: Problem) {
        let mut problems = self.problems.borrow_mut();
        if problems.len() < limits::PROBLEMS {
            problems.push(problem);
        }
    }
}

/// One table of the form. Dropping keys silently is impossible: call [`Section::finish`].
#[derive(Debug)]
pub struct Section<'a> {
    form: &'a Form,
    table: &'a DeTable<'a>,
    span: Span<usize>,
    path: String,
    asked: RefCell<Vec<&'static str>>,
}

impl<'a> Section<'a> {
    /// Where the table stands: its header, or its braces.
    pub fn span(&self) -> Span<usize> {
        self.span.clone()
    }

    /// The file that the table belongs to.
    pub fn source(&self) -> &'a Arc<Source> {
        &self.form.source
    }

    /// Notes a problem that the reader found itself.
    pub fn note(&self, problem: Problem) {
        self.form.note(problem);
    }

    /// Whether the key is present (it counts as asked for).
    pub fn has(&self, key: impl Into<Key>) -> bool {
        self.ask(&key.into(), &Asked::Presence).is_some()
    }

    /// Whether the key is present, without asking for it: of a table that belongs to another kind of file.
    pub fn holds(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// The span of a key's value, or of the table where it is missing.
    pub fn span_of(&self, key: &'static str) -> Span<usize> {
        self.value(key).map_or_else(|| self.span(), Spanned::span)
    }

    /// The value at a key, which counts as asked for.
    fn value(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.ask(&key.into(), &Asked::Presence)
    }

    fn ask(&self, key: &Key, asked: &Asked) -> Option<&'a Spanned<DeValue<'a>>> {
        if let Some(described) = &self.form.described {
            described.borrow_mut().ask(&self.path, key, asked);
        }
        let key = key.name;
        if !self.asked.borrow().contains(&key) {
            self.asked.borrow_mut().push(key);
        }
        self.table.get(key)
    }

    fn name(&self, key: &str) -> String {
        if self.path.is_empty() { format!("`{key}`") } else { format!("`{key}` of {}", self.path) }
    }

    /// Notes that a required key is missing.
    pub fn missing(&self, key: &'static str, example: &str) {
        self.form.note(
            Problem::at(self.span(), format!("{} is missing", self.name(key)), "in this table")
                .help(format!("for example: {key} = {example}")),
        );
    }

    fn wrong_type(&self, value: &Spanned<DeValue>, key: &str, expected: &str) {
        self.form.note(Problem::at(
            value.span(),
            format!("{} is {} {}", self.name(key), article(value.get_ref().type_str()), value.get_ref().type_str()),
            format!("expected {expected}"),
        ));
    }

    /// A string, if the key is there.
    pub fn text(&self, key: impl Into<Key>) -> Option<Spanned<String>> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Text)?;
        let key = key.name;
        let Some(text) = value.get_ref().as_str() else {
            self.wrong_type(value, key, "a string in quotes");
            return None;
        };
        Some(Spanned::new(value.span(), text.to_string()))
    }

    /// A string that must be there.
    pub fn required_text(&self, key: impl Into<Key>, example: &str) -> Option<Spanned<String>> {
        let key = key.into().required();
        self.ask(&key, &Asked::Text);
        let key = key.name;
        if !self.has(key) {
            self.missing(key, example);
            return None;
        }
        let text = self.text(key)?;
        if text.get_ref().trim().is_empty() {
            self.form.note(Problem::at(
                text.span(),
                format!("{} is empty", self.name(key)),
                format!("for example {example}"),
            ));
            return None;
        }
        let odd = |c: char| c.is_control();
        if text.get_ref().contains(odd) || text.get_ref().chars().count() > 200 {
            let message = format!("{} has control characters, or more than 200", self.name(key));
            self.form.note(Problem::at(text.span(), message, "expected a short printable name"));
            return None;
        }
        Some(text)
    }

    /// A short printable string, or what stands for it where the key is not there.
    pub fn name_or(&self, key: impl Into<Key>, default: impl FnOnce() -> String) -> Option<String> {
        let key = key.into();
        self.ask(&key, &Asked::Text);
        let key = key.name;
        if !self.has(key) {
            return Some(default());
        }
        self.required_text(key, "\"a name\"").map(Spanned::into_inner)
    }

    /// A list of strings, if the key is there.
    pub fn texts(&self, key: impl Into<Key>) -> Option<Vec<Spanned<String>>> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Texts)?;
        let key = key.name;
        let Some(array) = value.get_ref().as_array() else {
            self.wrong_type(value, key, "a list of strings");
            return None;
        };
        let mut texts = Vec::new();
        for item in array.iter() {
            match item.get_ref().as_str() {
                Some(text) => texts.push(Spanned::new(item.span(), text.to_string())),
                None => self.wrong_type(item, key, "a string in quotes"),
            }
        }
        if array.is_empty() {
            self.form.note(Problem::at(
                value.span(),
                format!("{} is empty", self.name(key)),
                "expected at least one string",
            ));
        }
        Some(texts)
    }

    /// Every key of a table of texts with its text, in the order of their names; empty if the key is not there.
    pub fn entries(&self, key: impl Into<Key>) -> Vec<(Spanned<String>, Spanned<String>)> {
        let key = key.into();
        let Some(value) = self.ask(&key, &Asked::Entries) else { return Vec::new() };
        let key = key.name;
        let Some(table) = value.get_ref().as_table() else {
            self.wrong_type(value, key, "a table");
            return Vec::new();
        };
        let mut entries = Vec::new();
        for (name, item) in table.iter() {
            match item.get_ref().as_str() {
                Some(text) => entries.push((
                    Spanned::new(name.span(), name.get_ref().to_string()),
                    Spanned::new(item.span(), text.to_string()),
                )),
                None => self.wrong_type(item, &shorten(name.get_ref()), "a string in quotes"),
            }
        }
        entries
    }

    /// `true` or `false`, if the key is there.
    pub fn boolean(&self, key: impl Into<Key>) -> Option<bool> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Boolean)?;
        let key = key.name;
        let found = value.get_ref().as_bool();
        if found.is_none() {
            self.wrong_type(value, key, "true or false");
        }
        found
    }

    /// A whole number from 1 on, if the key is there.
    pub fn count(&self, key: impl Into<Key>) -> Option<u32> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Count)?;
        let key = key.name;
        let number = value.get_ref().as_integer().and_then(|i| u32::from_str_radix(i.as_str(), i.radix()).ok());
        match number {
            Some(number) if number > 0 => Some(number),
            _ if value.get_ref().is_integer() => {
                let message = format!("{} is out of range", self.name(key));
                self.form.note(Problem::at(value.span(), message, "expected a whole number, at least 1"));
                None
            }
            _ => {
                self.wrong_type(value, key, "a whole number, at least 1");
                None
            }
        }
    }

    /// How many mistakes of the file were noted so far.
    pub fn noted(&self) -> usize {
        self.form.problems.borrow().len()
    }

    /// One of several words, if the key is there.
    pub fn choice<T: Copy>(&self, key: impl Into<Key>, choices: &[(&'static str, T)]) -> Option<T> {
        let key = key.into();
        self.ask(&key, &Asked::Choice(choices.iter().map(|(name, _)| *name).collect()));
        let key = key.name;
        let text = self.text(key)?;
        let found = choices.iter().find(|(name, _)| name == text.get_ref());
        if found.is_none() {
            let names = choices.iter().map(|(name, _)| *name);
            self.form.note(
                Problem::at(
                    text.span(),
                    format!("{} cannot be `{}`", self.name(key), shorten(text.get_ref())),
                    "not one of the choices",
                )
                .suggest(text.get_ref(), names),
            );
        }
        found.map(|(_, value)| *value)
    }

    /// A table, if the key is there.
    pub fn section(&self, key: impl Into<Key>) -> Option<Section<'a>> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Table)?;
        let key = key.name;
        let Some(table) = value.get_ref().as_table() else {
            self.wrong_type(value, key, "a table");
            return None;
        };
        Some(self.child(table, value.span(), format!("[{key}]")))
    }

    fn child(&self, table: &'a DeTable<'a>, span: Span<usize>, path: String) -> Section<'a> {
        self.form.reach(&path);
        Section { form: self.form, table, span, path, asked: RefCell::default() }
    }

    /// A list of tables (`[[joint]]`, or `points = [{…}]`), empty if the key is not there.
    pub fn sections(&self, key: impl Into<Key>) -> Vec<Section<'a>> {
        let key = key.into();
        let path = format!("[[{}]]", key.name);
        self.sections_at(key, &path)
    }

    /// A list of tables that has one at least, as [`Section::sections`]; that there is none is noted.
    pub fn some_sections(&self, key: impl Into<Key>, example: &str) -> Vec<Section<'a>> {
        let key = key.into();
        let name = key.name;
        let sections = self.sections(key);
        match self.value(name) {
            None => self.missing(name, example),
            Some(value) if value.get_ref().as_array().is_some_and(|list| list.is_empty()) => self.form.note(
                Problem::at(value.span(), format!("{} is empty", self.name(name)), "expected one table at least")
                    .help(format!("give {example}")),
            ),
            Some(_) => {}
        }
        sections
    }

    /// As [`Section::sections`], under another name than the key's: of a key that tables of two kinds have.
    pub fn sections_at(&self, key: impl Into<Key>, path: &str) -> Vec<Section<'a>> {
        let key = key.into();
        let Some(value) = self.ask(&key, &Asked::Tables) else { return Vec::new() };
        let key = key.name;
        let Some(array) = value.get_ref().as_array() else {
            self.wrong_type(value, key, "a list of tables");
            return Vec::new();
        };
        let mut sections = Vec::new();
        for item in array.iter() {
            match item.get_ref().as_table() {
                Some(table) => sections.push(self.child(table, item.span(), path.to_string())),
                None => self.wrong_type(item, key, "a table"),
            }
        }
        sections
    }

    /// Whether the value at `key` is a table (for keys that are a word or a table).
    pub fn is_table(&self, key: &'static str) -> bool {
        self.value(key).is_some_and(|v| v.get_ref().is_table())
    }

    /// Whether the value at `key` is a string (for keys that are a bare number or a quantity).
    pub fn is_text(&self, key: &'static str) -> bool {
        self.value(key).is_some_and(|v| v.get_ref().is_str())
    }

    /// Whether the value at `key` is a list.
    pub fn is_list(&self, key: &'static str) -> bool {
        self.value(key).is_some_and(|v| v.get_ref().is_array())
    }

    /// Whether the value at `key` is a number without quotes.
    pub fn is_number(&self, key: &'static str) -> bool {
        self.value(key).is_some_and(|v| v.get_ref().is_float() || v.get_ref().is_integer())
    }

    /// Every entry in the order of the file, for a table whose keys are not known beforehand (do not
    /// [`finish`](Section::finish) it).
    pub fn items(&self) -> Vec<(Spanned<String>, &'a Spanned<DeValue<'a>>)> {
        let entry = |(key, value): (&Spanned<DeString>, &'a Spanned<DeValue<'a>>)| {
            (Spanned::new(key.span(), key.get_ref().to_string()), value)
        };
        let mut entries: Vec<_> = self.table.iter().map(entry).collect();
        entries.sort_by_key(|(key, _)| key.span().start);
        entries
    }

    /// Texts, numbers or truth values as they would stand in a cell: one, or a list of them.
    pub fn cells(&self, key: impl Into<Key>) -> Vec<Spanned<String>> {
        let key = key.into();
        let Some(value) = self.ask(&key, &Asked::Cells) else { return Vec::new() };
        let key = key.name;
        let items = value.get_ref().as_array().map_or(std::slice::from_ref(value), |array| array.as_ref());
        let mut cells = Vec::new();
        for item in items {
            let text = match item.get_ref() {
                DeValue::String(text) => text.to_string(),
                DeValue::Integer(number) if number.radix() == 10 => number.as_str().to_string(),
                DeValue::Float(number) => number.as_str().to_string(),
                DeValue::Boolean(truth) => truth.to_string(),
                _ => {
                    self.wrong_type(item, key, "a text or a number");
                    continue;
                }
            };
            cells.push(Spanned::new(item.span(), text));
        }
        cells
    }

    /// Notes every key that nobody asked for, with the nearest that exists.
    pub fn finish(self) {
        let asked = self.asked.borrow();
        for (key, _) in self.table.iter() {
            if asked.iter().any(|a| *a == key.get_ref().as_ref()) {
                continue;
            }
            let place = if self.path.is_empty() { "at the top level" } else { &self.path };
            let mut known: Vec<&str> = asked.clone();
            known.sort_unstable();
            self.form.note(
                Problem::at(
                    key.span(),
                    format!(
                        "unknown key `{}` {}",
                        shorten(key.get_ref()),
                        if self.path.is_empty() { place.to_string() } else { format!("in {place}") }
                    ),
                    "not a key of this table",
                )
                .suggest(key.get_ref(), known),
            );
        }
    }
}

/// Whether a number with a comma stands where TOML did not understand: before the place, or around it.
fn decimal_comma(text: &str, at: usize) -> bool {
    let Some((before, after)) = text.split_at_checked(at) else { return false };
    let digit = |c: char| c.is_ascii_digit();
    let around = before.ends_with(digit) && after.strip_prefix(',').is_some_and(|rest| rest.starts_with(digit));
    let behind = before.trim_end().trim_end_matches(digit);
    let passed = behind.len() < before.trim_end().len();
    around || passed && behind.strip_suffix(',').is_some_and(|rest| rest.ends_with(digit))
}

fn article(word: &str) -> &'static str {
    if word.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::{Range, key};

    #[test]
    fn a_long_key_is_cut_in_messages() {
        let long = "k".repeat(1 << 20);
        let text = format!("{long} = 1\nword = \"{long}\"\n");
        let source = Arc::new(Source::new("r.toml", text));
        let read = |root: &Section| root.choice(key("word", "a word"), &[("one", 1), ("two", 2)]);
        let error = Form::read(&source, read).unwrap_err();
        assert_eq!(error.problems.iter().filter_map(|p| Some(p.span.as_ref()?.start)).min(), Some(0));
        assert_eq!(error.problems.len(), 2);
        for problem in error.problems {
            assert!(problem.message.len() < 200 && problem.help.is_none_or(|help| help.len() < 200));
        }
    }

    #[test]
    fn a_number_that_sizes_things_is_bounded_either_way() {
        let read = |text: &str| {
            let source = Arc::new(Source::new("r.toml", text));
            let number = |root: &Section| root.at_most("n", root.number(key("n", "a number"), Range::Any), 10.0, "");
            Form::read(&source, number).map_err(|error| error.problems[0].span.clone())
        };
        assert_eq!((read("n = -10").unwrap(), read("n = 10").unwrap()), (-10.0, 10.0));
        assert_eq!((read("n = 10.1"), read("n = -1e9")), (Err(Some(4..8)), Err(Some(4..8))));
    }
}
