//! The key that a place in a TOML text belongs to: for values of a program, which have no lines.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

/// The path of the deepest key whose value holds a span, as `joint "knee".ratio.max`; empty for the whole.
///
/// ```
/// use gearwise_model::input::key_path;
/// let text = "[[joint]]\nname = \"knee\"\nratio = { min = 3, max = -1 }\n";
/// let at = text.find("-1").unwrap();
/// assert_eq!(key_path(text, &(at..at + 2)), "joint \"knee\".ratio.max");
/// ```
pub fn key_path(text: &str, span: &Range<usize>) -> String {
    // What is wrong with the whole has no place.
    if span.is_empty() {
        return String::new();
    }
    let (table, _) = DeTable::parse_recoverable(text);
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
