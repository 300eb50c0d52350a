//! Where a key stands in a TOML file that was read before: for reports that point into it.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::Source;

/// One step down into a TOML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step<'a> {
    /// The value of a key.
    Key(&'a str),
    /// The table of a list of tables whose `name` is this.
    Named(&'a str),
}

/// The bytes of the deepest value on a path that is there: of the whole path, or of the last step that can
/// be made. `None` where not even the first step can.
///
/// ```
/// use gearwise::input::{Source, Step, locate};
/// let source = Source::new("robot.toml", "[[joint]]\nname = \"knee\"\n[joint.limits]\nsafety = 1.2\n");
/// let path = [Step::Key("joint"), Step::Named("knee"), Step::Key("limits"), Step::Key("safety")];
/// let span = locate(&source, &path).unwrap();
/// assert_eq!(&source.text()[span], "1.2");
/// ```
pub fn locate(source: &Source, path: &[Step]) -> Option<Range<usize>> {
    let (table, _) = DeTable::parse_recoverable(source.text());
    let mut found = None;
    let mut here: Option<&DeValue> = None;
    for step in path {
        let next = match (step, here) {
            (Step::Key(key), None) => table.get_ref().get(*key),
            (Step::Key(key), Some(value)) => value.as_table().and_then(|t| t.get(*key)),
            (Step::Named(name), Some(value)) => value.as_array().and_then(|list| {
                let called = |v: &DeValue| v.as_table().and_then(|t| t.get("name")?.get_ref().as_str()) == Some(*name);
                list.iter().find(|item| called(item.get_ref()))
            }),
            (Step::Named(_), None) => None,
        };
        let Some(next) = next else { break };
        found = Some(next.span());
        here = Some(next.get_ref());
    }
    let end = source.text().len();
    found.map(|s| s.start.min(end)..s.end.min(end))
}

/// The path of the deepest key whose value holds a span, as `joint "knee".ratio.max`; empty for the whole.
///
/// ```
/// use gearwise::input::{Source, key_path};
/// let source = Source::new("robot.toml", "[[joint]]\nname = \"knee\"\nratio = { min = 3, max = -1 }\n");
/// let at = source.text().find("-1").unwrap();
/// assert_eq!(key_path(&source, &(at..at + 2)), "joint \"knee\".ratio.max");
/// ```
pub fn key_path(source: &Source, span: &Range<usize>) -> String {
    // What is wrong with the whole has no place.
    if span.is_empty() {
        return String::new();
    }
    let (table, _) = DeTable::parse_recoverable(source.text());
    let mut path = String::new();
    in_table(table.get_ref(), span, &mut path);
    path
}

/// Whether one span is inside another.
fn holds(outer: &Range<usize>, inner: &Range<usize>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

/// Goes on into the entry of a table that holds a span: its key does, its value, or, of tables with a header, something in it.
fn in_table(table: &DeTable, span: &Range<usize>, path: &mut String) -> bool {
    for (key, value) in table.iter() {
        let before = path.len();
        if !path.is_empty() {
            path.push('.');
        }
        path.push_str(key.get_ref());
        if in_value(value.get_ref(), &value.span(), span, path) || holds(&key.span(), span) {
            return true;
        }
        path.truncate(before);
    }
    false
}

fn in_value(value: &DeValue, own: &Range<usize>, span: &Range<usize>, path: &mut String) -> bool {
    match value {
        DeValue::Table(table) => in_table(table, span, path) || holds(own, span),
        DeValue::Array(items) => {
            for (place, item) in items.iter().enumerate() {
                let before = path.len();
                let name = item.get_ref().as_table().and_then(|t| t.get("name")?.get_ref().as_str().map(String::from));
                match name {
                    Some(name) => path.push_str(&format!(" \"{name}\"")),
                    None => path.push_str(&format!("[{place}]")),
                }
                if in_value(item.get_ref(), &item.span(), span, path) {
                    return true;
                }
                path.truncate(before);
            }
            holds(own, span)
        }
        _ => holds(own, span),
    }
}
