//! What a reader asks a form for: keys with what may stand there, what they mean and what holds without them.
//!
//! The one idea: a reader says what a key means where it asks for it ([`key`]), and the documentation is what was asked.
//! [`Form::describe`](super::Form::describe) lets the reader run over a skeleton of a file that has every table and
//! writes down each question. There is no second list of keys.

use super::Range;
use crate::units::Kind;

/// A key of a table, as a reader asks for it.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    pub(super) name: &'static str,
    about: &'static str,
    value: Option<&'static str>,
    default: Option<&'static str>,
    or: Option<&'static str>,
    required: bool,
}

/// A key and what it means, in a few words.
///
/// ```
/// use gearwise_model::input::{Form, Range, key};
/// use gearwise_model::units;
/// let asked = Form::describe("", |root| {
///     root.quantity(key("ambient", "around the robot").default("25 degC"), &units::TEMPERATURE, Range::Positive)
/// });
/// let ambient = &asked.tables[0].keys[0];
/// assert_eq!((ambient.name, ambient.value.as_str()), ("ambient", "temperature, as `\"110 degC\"`"));
/// assert_eq!(ambient.meaning(), "around the robot; 25 degC by default");
/// ```
pub const fn key(name: &'static str, about: &'static str) -> Key {
    Key { name, about, value: None, default: None, or: None, required: false }
}

impl Key {
    /// Its name.
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// What may stand there, where the type does not say it: a file, an id.
    #[must_use]
    pub const fn value(self, value: &'static str) -> Key {
        Key { value: Some(value), ..self }
    }

    /// What holds where the key is not there.
    #[must_use]
    pub const fn default(self, default: &'static str) -> Key {
        Key { default: Some(default), ..self }
    }

    /// This key or another.
    #[must_use]
    pub const fn or(self, or: &'static str) -> Key {
        Key { or: Some(or), ..self }
    }

    /// The key must be there; where the form is asked for something required, it knows by itself.
    #[must_use]
    pub const fn required(self) -> Key {
        Key { required: true, ..self }
    }
}

impl From<&'static str> for Key {
    fn from(name: &'static str) -> Key {
        key(name, "")
    }
}

impl From<&&'static str> for Key {
    fn from(name: &&'static str) -> Key {
        key(name, "")
    }
}

/// What a reader asked for, table by table.
#[derive(Debug, Clone, Default)]
pub struct Description {
    /// The tables, in the order in which they were reached first.
    pub tables: Vec<TableAsked>,
}

/// A table of a file.
#[derive(Debug, Clone)]
pub struct TableAsked {
    /// As messages name it: `[bus]`, `[[joint]]`; empty at the top.
    pub path: String,
    /// Its keys, in the order in which they were asked for first.
    pub keys: Vec<KeyAsked>,
}

/// A key of a table.
#[derive(Debug, Clone)]
pub struct KeyAsked {
    /// Its name.
    pub name: &'static str,
    /// What may stand there; empty where it was only looked whether it is there.
    pub value: String,
    /// What it means.
    pub about: &'static str,
    /// What holds where it is not there.
    pub default: Option<&'static str>,
    /// The key that may stand in its place.
    pub or: Option<&'static str>,
    /// Whether it must be there.
    pub required: bool,
}

impl KeyAsked {
    /// What it means, whether it must be there, and what holds where it is not.
    pub fn meaning(&self) -> String {
        let mut parts = vec![self.about.to_string()];
        match (self.or, self.required) {
            (Some(or), _) => parts.push(format!("this or `{or}`")),
            (None, true) => parts.push("required".into()),
            (None, false) => {}
        }
        parts.extend(self.default.map(|default| format!("{default} by default")));
        parts.retain(|part| !part.is_empty());
        parts.join("; ")
    }
}

impl Description {
    /// With what another skeleton of the same kind of file shows.
    #[must_use]
    pub fn and(mut self, other: Description) -> Description {
        for table in other.tables {
            self.reach(&table.path);
            let known = self.tables.iter_mut().find(|t| t.path == table.path).expect("it was reached");
            let new = table.keys.into_iter().filter(|key| !known.keys.iter().any(|k| k.name == key.name));
            let new: Vec<KeyAsked> = new.collect();
            known.keys.extend(new);
        }
        self
    }

    pub(super) fn reach(&mut self, path: &str) {
        if !self.tables.iter().any(|t| t.path == path) {
            self.tables.push(TableAsked { path: path.into(), keys: Vec::new() });
        }
    }

    /// Writes down a question. One that says more than an earlier one of the same key completes it.
    pub(super) fn ask(&mut self, path: &str, key: &Key, value: &Asked) {
        self.reach(path);
        let table = self.tables.iter_mut().find(|t| t.path == path).expect("it was reached");
        let place = table.keys.iter().position(|k| k.name == key.name).unwrap_or_else(|| {
            let blank =
                KeyAsked { name: key.name, value: String::new(), about: "", default: None, or: None, required: false };
            table.keys.push(blank);
            table.keys.len() - 1
        });
        let known = &mut table.keys[place];
        if known.about.is_empty() {
            known.about = key.about;
        }
        match key.value {
            Some(value) => known.value = value.into(),
            None if known.value.is_empty() => known.value = value.words(),
            None => {}
        }
        known.default = known.default.or(key.default);
        known.or = known.or.or(key.or);
        known.required |= key.required;
    }
}

/// What is asked for at a key.
pub(super) enum Asked<'a> {
    /// Whether it is there.
    Presence,
    Text,
    Texts,
    Entries,
    Boolean,
    Count,
    Number(Range),
    Quantity(&'a Kind),
    Least(&'a Kind),
    Vector(&'a Kind),
    Pairs([&'a Kind; 2]),
    Choice(Vec<&'static str>),
    Table,
    Tables,
    Numbers,
    Named(&'a Kind),
    NamedNumbers,
    Cells,
    Matrix,
}

impl Asked<'_> {
    fn words(&self) -> String {
        let example =
            |kind: &Kind| if kind.needs_unit() { format!("\"{}\"", kind.example) } else { kind.example.into() };
        match self {
            Asked::Presence => String::new(),
            Asked::Text => "text".into(),
            Asked::Texts => "list of texts".into(),
            Asked::Entries => "table of texts".into(),
            Asked::Boolean => "`true`, `false`".into(),
            Asked::Count => "whole number from 1".into(),
            Asked::Number(range) => match range {
                Range::Any => "number".into(),
                range => format!("number {}", range.words()),
            },
            Asked::Quantity(kind) => format!("{}, as `{}`", kind.name, example(kind)),
            Asked::Least(kind) => format!("[least, most] {}, as `[\"0 {}\", {}]`", kind.name, kind.si, example(kind)),
            Asked::Vector(kind) => format!("[x, y, z] {}, each as `{}`", kind.name, example(kind)),
            Asked::Pairs([a, b]) => {
                format!("pairs of {} and {}, as `[[{}, {}]]`", a.name, b.name, example(a), example(b))
            }
            Asked::Choice(words) => words.iter().map(|w| format!("`{w}`")).collect::<Vec<_>>().join(", "),
            Asked::Table => "table".into(),
            Asked::Tables => "list of tables".into(),
            Asked::Numbers => "list of numbers".into(),
            Asked::Named(kind) => format!("table of {} by name, each as `{}`", kind.name, example(kind)),
            Asked::NamedNumbers => "table of numbers by name".into(),
            Asked::Cells => "text, number or list of them".into(),
            Asked::Matrix => "list of lists of numbers".into(),
        }
    }
}
