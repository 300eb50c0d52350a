//! A value put into a file's table before it is read: what a grid of parameters does to a requirement.
//!
//! The one idea: the value keeps its place in the file that it comes from. Its spans are moved beyond
//! every span of the file it is put into, so that the reader needs to know nothing of it, and each
//! mistake is shown where it was written.

use std::ops::Range as Span;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeString, DeTable, DeValue};

use super::{InputError, Problem, Source, limits};

/// One key of a table with another value than the file's.
#[derive(Debug, Clone)]
pub struct Change {
    key: String,
    key_at: Span<usize>,
    // The value as TOML, and where it was written.
    text: String,
    at: Span<usize>,
    // Which of the files with changes both were written in.
    home: usize,
    // Whether it is a value of a program, in which a bare number is SI.
    of_values: bool,
}

impl Change {
    /// Spans from here on are of a file that a value was written in.
    pub const ELSEWHERE: usize = usize::MAX / 2 + 1;
    /// Apart by this are the spans of two such files: more than a text may have.
    const APART: usize = 2 * limits::TEXT_BYTES as usize;

    /// A change of `key`, a path with points: `bus.voltage`, `joint.knee.gear.efficiency`, or
    /// `joint.*.gear.efficiency` for all of a list. `text` is the value as TOML; both places are those in
    /// the file that they were written in.
    pub fn new(key: impl Into<String>, key_at: Span<usize>, text: impl Into<String>, at: Span<usize>) -> Change {
        Change { key: key.into(), key_at, text: text.into(), at, home: 0, of_values: false }
    }

    /// The same change, written in one that is further down by `homes` in the list of files of [`Change::send_home`].
    #[must_use]
    pub fn written_after(self, homes: usize) -> Change {
        Change { home: self.home + homes, ..self }
    }

    /// The same, of values of a program ([`Source::of_values`]): a bare number is SI.
    #[must_use]
    pub fn of_values(self) -> Change {
        Change { of_values: true, ..self }
    }

    /// The place of its key and value in the file that it was written in, and the place of that file in the list of [`Change::send_home`].
    pub fn written(&self) -> (usize, Span<usize>) {
        (self.home, self.key_at.start.min(self.at.start)..self.at.end.max(self.key_at.end))
    }

    /// True if it changes the value at a path, or a table around it; `*` stands for all of a list.
    pub fn sets(&self, path: &[&str]) -> bool {
        let own: Vec<&str> = self.key.split('.').collect();
        own.len() <= path.len() && own.iter().zip(path).all(|(own, asked)| own == asked || *own == "*")
    }

    /// Whether a span of a reading with changes is in a value of a program.
    pub(super) fn is_of_values(span: &Span<usize>, changes: &[Change]) -> bool {
        let Some(from) = span.start.checked_sub(Change::ELSEWHERE) else { return false };
        changes.iter().any(|change| change.of_values && change.home == from / Change::APART)
    }

    /// Where in its value a span of a reading with changes is; `None` where it is elsewhere.
    pub fn within(&self, span: &Span<usize>) -> Option<Span<usize>> {
        let start = self.moved(self.at.clone()).start;
        let from = span.start.checked_sub(start)?;
        (from + span.len() <= self.text.len()).then_some(from..from + span.len())
    }

    /// A problem with the key, where it was written.
    pub fn problem_of_key(&self, message: impl Into<String>, label: impl Into<String>) -> Problem {
        Problem::at(self.moved(self.key_at.clone()), message, label)
    }

    /// A problem with the value, where it was written.
    pub fn problem_of_value(&self, message: impl Into<String>, label: impl Into<String>) -> Problem {
        Problem::at(self.moved(self.at.clone()), message, label)
    }

    /// The key, a path with points.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value as TOML.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// As it is written down: key, and value as TOML.
    pub fn said(&self) -> (String, String) {
        (self.key.clone(), self.text.clone())
    }

    /// Puts the value in its place.
    ///
    /// # Errors
    /// The key leads through something that is no table, or names none of a list.
    pub fn apply<'t>(&'t self, table: &mut DeTable<'t>) -> Result<(), Problem> {
        self.put(table, &self.key, "")
    }

    /// The value with its spans moved. Inside a value that was made (a range) they are those of the whole.
    fn value(&self) -> Spanned<DeValue<'_>> {
        let made = self.at.len() != self.text.len();
        let place = |span: Span<usize>| {
            self.moved(if made { self.at.clone() } else { self.at.start + span.start..self.at.start + span.end })
        };
        match DeValue::parse(&self.text) {
            Ok(value) => relocated(value, &place),
            Err(_) => Spanned::new(self.moved(self.at.clone()), DeValue::Boolean(false)),
        }
    }

    fn put<'t>(&'t self, table: &mut DeTable<'t>, rest: &str, before: &str) -> Result<(), Problem> {
        let (first, rest) = match rest.split_once('.') {
            Some((first, rest)) => (first, rest),
            None => {
                table.remove(rest);
                table.insert(self.spanned_key(rest), self.value());
                return Ok(());
            }
        };
        let path = if before.is_empty() { first.to_string() } else { format!("{before}.{first}") };
        if !table.contains_key(first) {
            let empty = Spanned::new(self.moved(self.key_at.clone()), DeValue::Table(DeTable::new()));
            table.insert(self.spanned_key(first), empty);
        }
        let value = table.get_mut(first).expect("it is there").get_mut();
        match value {
            DeValue::Table(inner) => self.put(inner, rest, &path),
            DeValue::Array(items) => {
                let mut names = Vec::new();
                let mut found = false;
                for item in items.iter_mut() {
                    let DeValue::Table(inner) = item.get_mut() else { continue };
                    let name = inner.get("name").and_then(|n| n.get_ref().as_str()).unwrap_or_default().to_string();
                    let of_all = rest.strip_prefix("*.");
                    let of_this = rest.strip_prefix(name.as_str()).and_then(|r| r.strip_prefix('.'));
                    if let Some(rest) = of_all.or(of_this) {
                        found = true;
                        self.put(inner, rest, &format!("{path}.{name}"))?;
                    }
                    names.push(name);
                }
                if found {
                    return Ok(());
                }
                let asked = rest.split('.').next().unwrap_or(rest);
                let problem = Problem::at(
                    self.moved(self.key_at.clone()),
                    format!("the key `{}` names no `{first}` of the requirement", self.key),
                    format!("there is no `{asked}`, or nothing of it is named"),
                );
                Err(problem.suggest(asked, names.iter().map(String::as_str)))
            }
            _ => Err(Problem::at(
                self.moved(self.key_at.clone()),
                format!("the key `{}` leads through `{path}`, which is not a table", self.key),
                "names something inside a value",
            )),
        }
    }

    fn spanned_key<'t>(&self, key: &str) -> Spanned<DeString<'t>> {
        Spanned::new(self.moved(self.key_at.clone()), DeString::Owned(key.to_string()))
    }

    fn moved(&self, span: Span<usize>) -> Span<usize> {
        let start = Change::ELSEWHERE + self.home * Change::APART;
        start + span.start..start + span.end
    }

    /// Sorts the problems of a reading with changes by the file that they were written in; `homes` are those
    /// of the changes, in the order of [`Change::written_after`]. A mistake that a change makes in many places is told once.
    pub fn send_home(errors: Vec<InputError>, homes: &[Arc<Source>]) -> Vec<InputError> {
        let mut sorted: Vec<InputError> = Vec::new();
        for InputError { source, problems } in errors {
            let home = |p: &Problem| {
                let start = p.span.as_ref().map_or(0, |s| s.start);
                start.checked_sub(Change::ELSEWHERE).map(|from| from / Change::APART)
            };
            let mut here = Vec::new();
            let mut away: Vec<Vec<Problem>> = homes.iter().map(|_| Vec::new()).collect();
            for mut problem in problems {
                let Some((k, list)) = home(&problem).and_then(|k| Some((k, away.get_mut(k)?))) else {
                    here.push(problem);
                    continue;
                };
                let start = Change::ELSEWHERE + k * Change::APART;
                problem.span = problem.span.map(|s| s.start - start..s.end - start);
                if !list.contains(&problem) {
                    list.push(problem);
                }
            }
            for (source, problems) in homes.iter().zip(away).chain([(&source, here)]) {
                if !problems.is_empty() {
                    sorted.push(InputError { source: source.clone(), problems });
                }
            }
        }
        sorted
    }
}

/// A value with its spans where `place` says.
fn relocated<'v>(value: Spanned<DeValue<'v>>, place: &dyn Fn(Span<usize>) -> Span<usize>) -> Spanned<DeValue<'v>> {
    let span = place(value.span());
    let inner = match value.into_inner() {
        DeValue::Array(items) => DeValue::Array(items.into_iter().map(|item| relocated(item, place)).collect()),
        DeValue::Table(entries) => {
            let entry = |(key, value): (Spanned<DeString<'v>>, _)| {
                (Spanned::new(place(key.span()), key.into_inner()), relocated(value, place))
            };
            DeValue::Table(entries.into_iter().map(entry).collect())
        }
        other => other,
    };
    Spanned::new(span, inner)
}
