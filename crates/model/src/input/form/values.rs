//! Numbers and quantities of a form.

use std::ops::Range as Span;

use toml::Spanned;
use toml::de::{DeString, DeValue};

use super::super::describe::Asked;
use super::super::{Key, Problem, Range, Stated, Words};
use super::Section;
use crate::units::{self, Kind};

/// A temperature below this \[K\] that is given as a bare number was meant in another unit.
const LEAST_KELVIN: f64 = 200.0;

impl Section<'_> {
    /// A number without dimension in a range, if the key is there.
    pub fn number(&self, key: impl Into<Key>, range: Range) -> Option<f64> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Number(range))?;
        let key = key.name;
        self.read_number(value, key, range)
    }

    fn read_number(&self, value: &Spanned<DeValue>, key: &str, range: Range) -> Option<f64> {
        let number = match value.get_ref() {
            DeValue::Integer(i) if i.radix() == 10 => i.as_str().parse().ok(),
            DeValue::Float(x) => x.as_str().parse::<f64>().ok(),
            _ => {
                self.wrong_type(value, key, "a number");
                return None;
            }
        };
        self.in_range(number.unwrap_or(f64::NAN), value.span(), key, range)
    }

    /// Note a quantity outside the bounds of its kind.
    fn in_bounds(&self, number: f64, span: Span<usize>, key: &str, kind: &'static Kind) -> Option<f64> {
        if kind.holds(number) {
            return Some(number);
        }
        let message = format!("{} is out of range", self.name(key));
        self.form.note(Problem::at(span, message, format!("expected {}", kind.bounds_words())));
        None
    }

    fn in_range(&self, number: f64, span: Span<usize>, key: &str, range: Range) -> Option<f64> {
        if number.is_finite() && units::is_sane(number) && range.contains(number) {
            return Some(number);
        }
        let what = if number.is_finite() { "out of range" } else { "not a finite number" };
        let mut problem =
            Problem::at(span, format!("{} is {what}", self.name(key)), format!("expected {}", range.expected()));
        problem.help = range.help(number);
        self.form.note(problem);
        None
    }

    /// Note a number of a key that is larger than any real one, either way. Such a number sizes what is computed.
    pub fn at_most(&self, key: &'static str, number: Option<f64>, most: f64, unit: &str) -> Option<f64> {
        if number.is_none_or(|number| number.abs() <= most) {
            return number;
        }
        let (message, most) = (format!("{} is out of range", self.name(key)), crate::words::number(most));
        self.note(Problem::at(self.span_of(key), message, format!("expected at most {most}{unit}")));
        None
    }

    /// A quantity with its unit, in SI, if the key is there.
    pub fn quantity(&self, key: impl Into<Key>, kind: &'static Kind, range: Range) -> Option<f64> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Quantity(kind))?;
        let key = key.name;
        self.read_quantity(value, key, kind, range)
    }

    /// A quantity with its unit, behind which it may state what it refers to: `"1.48 N*m/A rms"`.
    pub fn stated_quantity(
        &self,
        key: impl Into<Key>,
        kind: &'static Kind,
        range: Range,
        words: Words,
    ) -> Option<(f64, Stated)> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Quantity(kind))?;
        let key = key.name;
        let Some(text) = value.get_ref().as_str() else {
            return self.read_quantity(value, key, kind, range).map(|number| (number, Stated::default()));
        };
        match words.split(text) {
            Ok((rest, stated)) => Some((self.read_words(value, rest, words, key, kind, range)?, stated)),
            Err(message) => {
                self.form.note(Problem::at(value.span(), format!("{}: {message}", self.name(key)), "expected one"));
                None
            }
        }
    }

    /// A tolerance in a unit of its kind, in SI, if the key is there.
    pub fn difference(&self, key: impl Into<Key>, kind: &'static Kind) -> Option<f64> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Quantity(kind))?;
        let key = key.name;
        // A difference of temperatures may be small.
        let text = value.get_ref().as_str().and_then(|text| units::difference(text, kind).ok());
        match text {
            Some(difference) => self.in_range(difference, value.span(), key, Range::NonNegative),
            None => self.read_quantity(value, key, kind, Range::NonNegative),
        }
    }

    /// Pairs of quantities, `[["7 N*m", "120 s"], ["10 N*m", "18 s"]]`, in SI, if the key is there.
    pub fn pairs(&self, key: impl Into<Key>, kinds: [(&'static Kind, Range); 2]) -> Option<Vec<[f64; 2]>> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Pairs([kinds[0].0, kinds[1].0]))?;
        let key = key.name;
        let example = || kinds.map(|(kind, _)| format!("\"{}\"", kind.example)).join(", ");
        let Some(items) = value.get_ref().as_array() else {
            self.wrong_type(value, key, &format!("a list of pairs, like [[{}]]", example()));
            return None;
        };
        let pair = |item: &Spanned<DeValue>| {
            let Some(ends) = item.get_ref().as_array().filter(|ends| ends.len() == 2) else {
                let message = format!("{} has something that is not a pair", self.name(key));
                self.form.note(Problem::at(item.span(), message, format!("expected [{}]", example())));
                return None;
            };
            let read = |k: usize| match kinds[k] {
                (kind, range) if kind.needs_unit() => self.read_quantity(&ends[k], key, kind, range),
                (_, range) => self.read_number(&ends[k], key, range),
            };
            let (first, second) = (read(0), read(1));
            Some([first?, second?])
        };
        // Each is looked at, so that all mistakes are noted.
        let read: Vec<Option<[f64; 2]>> = items.iter().map(pair).collect();
        read.into_iter().collect()
    }

    /// Two quantities of one kind, `[least, most]`, in SI, if the key is there. Equal ones are one value;
    /// the wrong way round is a mistake.
    pub fn quantity_range(&self, key: impl Into<Key>, kind: &'static Kind, range: Range) -> Option<[f64; 2]> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Least(kind))?;
        let key = key.name;
        let items = value.get_ref().as_array().filter(|a| a.len() == 2);
        let Some(items) = items else {
            self.form.note(
                Problem::at(
                    value.span(),
                    format!("{} is not a pair [least, most]", self.name(key)),
                    format!("expected the least and the most {}, each with its unit", kind.name),
                )
                .help(format!("for example {key} = [\"0 {}\", \"{}\"]", kind.si, kind.example)),
            );
            return None;
        };
        let mut ends = items.iter().map(|item| self.read_quantity(item, key, kind, range));
        let (least, most) = (ends.next().flatten(), ends.next().flatten());
        let (least, most) = (least?, most?);
        if least > most {
            self.form.note(
                Problem::at(
                    value.span(),
                    format!("{} is upside down", self.name(key)),
                    "the first is more than the second",
                )
                .help("swap the two"),
            );
            return None;
        }
        Some([least, most])
    }

    /// Three quantities of one kind, along x, y and z, in SI, if the key is there.
    pub fn vector(&self, key: impl Into<Key>, kind: &'static Kind) -> Option<[f64; 3]> {
        self.components(key.into(), kind, "x, y, z")?.try_into().ok()
    }

    /// Two quantities of one kind, along x and y of a plane, in SI, if the key is there.
    pub fn planar(&self, key: impl Into<Key>, kind: &'static Kind) -> Option<[f64; 2]> {
        self.components(key.into(), kind, "x, y")?.try_into().ok()
    }

    fn components(&self, key: Key, kind: &'static Kind, axes: &str) -> Option<Vec<f64>> {
        let value = self.ask(&key, &Asked::Vector(kind))?;
        let (key, count) = (key.name, axes.split(',').count());
        let Some(items) = value.get_ref().as_array().filter(|a| a.len() == count) else {
            let times = if count == 2 { "two times" } else { "three times" };
            let zeros = format!("\"0 {}\", ", kind.si).repeat(count - 1);
            self.form.note(
                Problem::at(
                    value.span(),
                    format!("{} is not a vector [{axes}]", self.name(key)),
                    format!("expected {times} {}, each with its unit", kind.with_article()),
                )
                .help(format!("for example {key} = [{zeros}\"{}\"]", kind.example)),
            );
            return None;
        };
        let read: Vec<Option<f64>> = items.iter().map(|item| self.read_quantity(item, key, kind, Range::Any)).collect();
        read.into_iter().collect()
    }

    /// A quantity that must be there.
    pub fn required_quantity(&self, key: impl Into<Key>, kind: &'static Kind, range: Range) -> Option<f64> {
        let key = key.into().required();
        self.ask(&key, &Asked::Quantity(kind));
        let key = key.name;
        if !self.has(key) {
            self.missing(key, &format!("\"{}\"", kind.example));
        }
        self.quantity(key, kind, range)
    }

    fn read_quantity(&self, value: &Spanned<DeValue>, key: &str, kind: &'static Kind, range: Range) -> Option<f64> {
        let text = match value.get_ref() {
            DeValue::String(text) => text,
            DeValue::Integer(_) | DeValue::Float(_) if self.form.is_of_values(&value.span()) => {
                let number = self.read_number(value, key, range)?;
                // The one number that is easily meant in another unit.
                if kind.si == "K" && number < LEAST_KELVIN {
                    let message = format!("{} is {number} K: a bare number is in kelvin", self.name(key));
                    let problem = Problem::at(value.span(), message, format!("expected {}", kind.with_article()));
                    self.form.note(problem.help(format!("did you mean \"{number} degC\"?")));
                    return None;
                }
                self.form.bare.borrow_mut().push((value.span(), kind.si));
                return self.in_bounds(number, value.span(), key, kind);
            }
            DeValue::Integer(_) | DeValue::Float(_) => {
                self.form.note(
                    Problem::at(
                        value.span(),
                        format!("{} has no unit", self.name(key)),
                        format!("expected {} with its unit", kind.with_article()),
                    )
                    .help(format!("write it in quotes with its unit, for example {key} = \"{}\"", kind.example)),
                );
                return None;
            }
            _ => {
                self.wrong_type(
                    value,
                    key,
                    &format!("{} with its unit, like \"{}\"", kind.with_article(), kind.example),
                );
                return None;
            }
        };
        self.read_words(value, text, Words::NONE, key, kind, range)
    }

    /// The quantity in a text; a unit that is not known may have been one of `words`.
    fn read_words(
        &self,
        value: &Spanned<DeValue>,
        text: &str,
        words: Words,
        key: &str,
        kind: &'static Kind,
        range: Range,
    ) -> Option<f64> {
        match units::quantity(text, kind) {
            Ok(number) => {
                let number = self.in_bounds(number, value.span(), key, kind)?;
                self.in_range(number, value.span(), key, range)
            }
            Err(error) => {
                let help = words.meant(text).map(|near| format!("did you mean `{near}`?"));
                self.form.note(
                    Problem::at(
                        value.span(),
                        format!("{}: {}", self.name(key), error.message(kind)),
                        format!("expected {}", kind.with_article()),
                    )
                    .help(help.unwrap_or_else(|| error.help(kind))),
                );
                None
            }
        }
    }

    /// Numbers without dimension in a list, if the key is there.
    pub fn number_list(&self, key: impl Into<Key>, range: Range) -> Option<Vec<f64>> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Numbers)?;
        let key = key.name;
        let Some(items) = value.get_ref().as_array() else {
            self.wrong_type(value, key, "a list of numbers");
            return None;
        };
        items.iter().map(|item| self.read_number(item, key, range)).collect()
    }

    /// Quantities of one kind under names of the user's own, in SI, with the place of each name.
    pub fn named_quantities(
        &self,
        key: impl Into<Key>,
        kind: &'static Kind,
        range: Range,
    ) -> Vec<(Spanned<String>, f64)> {
        let key = key.into();
        let Some(value) = self.ask(&key, &Asked::Named(kind)) else { return Vec::new() };
        let key = key.name;
        let Some(table) = value.get_ref().as_table() else {
            self.wrong_type(value, key, "a table of names and quantities");
            return Vec::new();
        };
        let mut named = Vec::new();
        for (name, item) in table.iter() {
            if let Some(number) = self.read_quantity(item, name.get_ref(), kind, range) {
                named.push((Spanned::new(name.span(), name.get_ref().to_string()), number));
            }
        }
        named.sort_by_key(|(name, _)| name.span().start);
        named
    }

    /// Numbers without dimension under names of the user's own, with the place of each name.
    pub fn named_numbers(&self, key: impl Into<Key>, range: Range) -> Vec<(Spanned<String>, f64)> {
        let key = key.into();
        let Some(value) = self.ask(&key, &Asked::NamedNumbers) else { return Vec::new() };
        let Some(table) = value.get_ref().as_table() else {
            self.wrong_type(value, key.name, "a table of names and numbers");
            return Vec::new();
        };
        let number = |(name, item): (&Spanned<DeString>, &Spanned<DeValue>)| {
            let number = self.read_number(item, name.get_ref(), range)?;
            Some((Spanned::new(name.span(), name.get_ref().to_string()), number))
        };
        let mut named: Vec<(Spanned<String>, f64)> = table.iter().filter_map(number).collect();
        named.sort_by_key(|(name, _)| name.span().start);
        named
    }

    /// A list of lists of numbers, if the key is there.
    pub fn matrix(&self, key: impl Into<Key>) -> Option<Vec<Vec<f64>>> {
        let key = key.into();
        let value = self.ask(&key, &Asked::Matrix)?;
        let key = key.name;
        let expected = "a list of lists of numbers";
        let Some(rows) = value.get_ref().as_array() else {
            self.wrong_type(value, key, expected);
            return None;
        };
        let row = |row: &Spanned<DeValue>| {
            let Some(cells) = row.get_ref().as_array() else {
                self.wrong_type(row, key, expected);
                return None;
            };
            cells.iter().map(|cell| self.read_number(cell, key, Range::Any)).collect()
        };
        rows.iter().map(row).collect()
    }
}
