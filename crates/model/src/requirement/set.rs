//! Values that a call puts in the place of a requirement's own: `--set bus.voltage="48 V"`, and `set` of a design file.
//!
//! The one idea: what is set is a [`Change`], as a grid of parameters makes it, with the same keys; it keeps the place
//! where it was written, so that each mistake is told there. What was set stays with the robot ([`Robot::set`]).

use std::sync::Arc;

use toml::de::DeValue;
use toml_edit::{DocumentMut, Item, TableLike, Value};

use super::motions::{FromDisk, Motions};
use super::read;
use super::robot::Robot;
use super::saved::multiply;
use crate::input::{Change, InputError, Key, Problem, Section, Source, key};

/// Keys that multiply every motion instead of replacing a value.
pub const SCALES: [&str; 2] = ["scale.torque", "scale.speed"];

/// The least and the largest factor of such a key.
const FACTORS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// The option that sets a value.
pub const OPTION: &str = "--set";

/// Values in the place of a requirement's own, in the order in which they are put there.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    homes: Vec<Arc<Source>>,
    changes: Vec<Change>,
}

impl Settings {
    /// Those of a command line, each `KEY=VALUE`: the value as TOML, or a bare text such as `48 V`.
    ///
    /// # Errors
    /// In words: what is no `KEY=VALUE`, a value that is no TOML, a key that is set twice.
    pub fn of_arguments(arguments: &[String]) -> Result<Settings, String> {
        let (mut text, mut changes) = (String::new(), Vec::<Change>::new());
        for argument in arguments {
            let fail = |what: &str| Err(format!("`{OPTION} {argument}`: {what}"));
            const EXAMPLE: &str = "write KEY=VALUE, as in bus.voltage=\"48 V\"";
            let Some((key, value)) = argument.split_once('=') else { return fail(EXAMPLE) };
            let (name, bare) = (key.trim(), value.trim());
            if name.is_empty() || name.split('.').any(|part| part.trim().is_empty()) {
                return fail(&format!("`{name}` is not a path; {EXAMPLE}"));
            }
            if bare.is_empty() {
                return fail(&format!("there is no value; {EXAMPLE}"));
            }
            if argument.contains(|c: char| c.is_control()) {
                return fail("a value is one line");
            }
            if changes.iter().any(|c| c.key() == name) {
                return fail(&format!("`{name}` is set twice"));
            }
            let start = |part: &str| text.len() + argument.len() - argument[argument.find(part).unwrap_or(0)..].len();
            let key_at = start(name)..start(name) + name.len();
            let from = text.len() + key.len() + 1 + (value.len() - value.trim_start().len());
            let value_at = from..from + bare.len();
            let written = match DeValue::parse(bare) {
                Ok(_) => bare.to_string(),
                Err(why) if bare.starts_with(['"', '\'', '[', '{']) => {
                    return fail(&format!(
                        "the value is not TOML: {}",
                        why.message().lines().next().unwrap_or_default()
                    ));
                }
                Err(_) => toml::Value::String(bare.into()).to_string(),
            };
            changes.push(Change::new(name, key_at, written, value_at));
            text.push_str(argument);
            text.push('\n');
        }
        if changes.is_empty() {
            return Ok(Settings::default());
        }
        Ok(Settings { homes: vec![Arc::new(Source::new(OPTION, text))], changes })
    }

    /// Those of a program: keys, and values as TOML in which a bare number is SI. `name` is for messages.
    ///
    /// # Errors
    /// In words: what is no path.
    pub fn of_values<'v>(name: &str, values: impl IntoIterator<Item = (&'v str, String)>) -> Result<Settings, String> {
        let (mut text, mut changes) = (String::new(), Vec::<Change>::new());
        for (key, value) in values {
            let odd = |c: char| c.is_control() || "\"\\".contains(c);
            if key.split('.').any(|part| part.trim().is_empty() || part.contains(odd)) {
                return Err(format!("{name}: `{key}` is not a path, as in bus.voltage"));
            }
            text.push('"');
            let key_at = text.len()..text.len() + key.len();
            text.push_str(key);
            text.push_str("\" = ");
            let value_at = text.len()..text.len() + value.len();
            text.push_str(&value);
            text.push('\n');
            changes.push(Change::new(key, key_at, value, value_at).of_values());
        }
        if changes.is_empty() {
            return Ok(Settings::default());
        }
        Ok(Settings { homes: vec![Arc::new(Source::of_values(name, text))], changes })
    }

    /// Those of the table `set` of a design file; its keys are paths in quotes.
    pub(super) fn of_section(section: &Section) -> Settings {
        let text = section.source().text();
        let mut changes = Vec::new();
        for (key, value) in section.items() {
            if !key.get_ref().contains('.') && value.get_ref().is_table() {
                let message = format!("`{}` of [set] is a table", key.get_ref());
                let problem = Problem::at(key.span(), message, "expected a path in quotes");
                section.note(problem.help("for example \"bus.voltage\" = \"48 V\""));
                continue;
            }
            changes.push(Change::new(key.get_ref(), key.span(), &text[value.span()], value.span()));
        }
        Settings { homes: vec![section.source().clone()], changes }
    }

    /// These, and then others: those win where both set one value.
    #[must_use]
    pub fn then(&self, later: &Settings) -> Settings {
        let kept = self.changes.iter().filter(|c| later.changes.iter().all(|l| l.key() != c.key())).cloned();
        let moved = later.changes.iter().map(|c| c.clone().written_after(self.homes.len()));
        Settings { changes: kept.chain(moved).collect(), homes: [self.homes.clone(), later.homes.clone()].concat() }
    }

    /// Whether nothing is set.
    pub fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }

    /// The changes, and the files that they were written in.
    pub fn parts(&self) -> (&[Change], &[Arc<Source>]) {
        (&self.changes, &self.homes)
    }

    /// The file and the place in which the value at a path was set; `None` where it is the requirement's own, or was set in no file.
    pub fn written(&self, path: &[&str]) -> Option<(&Arc<Source>, std::ops::Range<usize>)> {
        let (home, span) = self.changes.iter().rfind(|change| change.sets(path))?.written();
        Some((self.homes.get(home).filter(|source| source.name() != OPTION)?, span))
    }

    /// Reads a requirement with them; `no_springs` as for [`super::read_without_springs`].
    ///
    /// # Errors
    /// As [`super::read`]; mistakes of what is set stand where it was written.
    pub fn read(&self, source: &Arc<Source>, no_springs: Option<&str>) -> Result<Robot, Vec<InputError>> {
        self.read_with(source, no_springs, &mut FromDisk::default())
    }

    /// As [`Settings::read`], with motions from a store.
    ///
    /// # Errors
    /// As [`Settings::read`].
    pub fn read_with(
        &self,
        source: &Arc<Source>,
        no_springs: Option<&str>,
        motions: &mut dyn Motions,
    ) -> Result<Robot, Vec<InputError>> {
        let ([torque, speed], factors) = self.factors();
        let changes: Vec<Change> = self.changes.iter().filter(|c| !is_scale(c.key())).cloned().collect();
        let robot = read::read_as(source, &changes, no_springs, motions, [torque, speed]);
        let wrong = |problem: Problem| InputError { source: source.clone(), problems: vec![problem] };
        let mut robot = match (robot, factors.is_empty()) {
            (Ok(robot), true) => robot,
            (read, _) => {
                let own = factors.into_iter().map(wrong);
                let errors = own.chain(read.err().into_iter().flatten()).collect();
                return Err(Change::send_home(errors, &self.homes));
            }
        };
        robot.set = self.changes.iter().map(Change::said).collect();
        Ok(robot)
    }

    /// The text of a requirement's file with them in it: comments stay, bare numbers of a program get their units, and factors on
    /// all motions become those of each joint. Motions that were handed over keep the names that stand for them.
    pub fn to_toml(&self, source: &Arc<Source>, motions: &mut dyn Motions) -> String {
        let changes: Vec<Change> = self.changes.iter().filter(|c| !is_scale(c.key())).cloned().collect();
        let bare = read::bare_numbers(source, &changes, motions);
        let text = with_units(source.text(), bare.iter().filter(|(span, _)| span.start < Change::ELSEWHERE).cloned());
        let Ok(mut document) = text.parse::<DocumentMut>() else { return text };
        for change in &changes {
            let units = bare.iter().filter_map(|(span, unit)| Some((change.within(span)?, *unit)));
            let value = with_units(change.text(), units.filter(|(span, _)| !span.is_empty()));
            if let Ok(value) = value.parse::<Value>() {
                put(document.as_table_mut(), change.key(), &value);
            }
        }
        let ([torque, speed], _) = self.factors();
        for (name, factor) in [("torque", torque), ("speed", speed)].into_iter().filter(|(_, factor)| *factor != 1.0) {
            scale_all(&mut document, name, factor);
        }
        document.to_string()
    }

    /// That factors on motions are numbers that can be such.
    ///
    /// # Errors
    /// Those that are not.
    pub fn check_factors(&self) -> Result<(), Vec<InputError>> {
        let (_, problems) = self.factors();
        match (problems.is_empty(), self.homes.first()) {
            (false, Some(home)) => {
                let error = InputError { source: home.clone(), problems };
                Err(Change::send_home(vec![error], &self.homes))
            }
            _ => Ok(()),
        }
    }

    /// The factors on torque and speed, and what is wrong with them.
    fn factors(&self) -> ([f64; 2], Vec<Problem>) {
        let (mut factors, mut problems) = ([1.0; 2], Vec::new());
        for change in self.changes.iter().filter(|c| is_scale(c.key())) {
            let value = change.text().parse::<f64>().ok().filter(|v| v.is_finite() && FACTORS.contains(v));
            match (SCALES.iter().position(|name| *name == change.key()), value) {
                (Some(which), Some(value)) => factors[which] = value,
                (Some(_), None) => problems.push(change.problem_of_value(
                    format!("`{}` is a factor", change.key()),
                    "expected a bare number between 1e-6 and 1e6",
                )),
                (None, _) => {
                    let message = format!("`{}` is not something to scale", change.key());
                    problems.push(change.problem_of_key(message, "not known").suggest(change.key(), SCALES));
                }
            }
        }
        (factors, problems)
    }
}

fn is_scale(key: &str) -> bool {
    key == "scale" || key.starts_with("scale.")
}

/// A text in which some numbers get their units.
fn with_units(text: &str, units: impl Iterator<Item = (std::ops::Range<usize>, &'static str)>) -> String {
    let mut units: Vec<_> = units.filter(|(span, _)| span.end <= text.len()).collect();
    units.sort_by_key(|(span, _)| std::cmp::Reverse(span.start));
    // A value that a reader asks for twice is there twice.
    units.dedup();
    let mut text = text.to_string();
    for (span, unit) in units {
        let number = text[span.clone()].to_string();
        text.replace_range(span, &format!("\"{number} {unit}\""));
    }
    text
}

/// Puts a value at a path, as a change is applied to what is read.
fn put(table: &mut dyn TableLike, path: &str, value: &Value) {
    let Some((first, rest)) = path.split_once('.') else {
        table.insert(path, Item::Value(value.clone()));
        return;
    };
    if !table.contains_key(first) {
        table.insert(first, Item::Table(toml_edit::Table::new()));
    }
    let Some(item) = table.get_mut(first) else { return };
    if let Some(inner) = item.as_table_like_mut() {
        put(inner, rest, value);
        return;
    }
    let of = |inner: &mut dyn TableLike| {
        let name = inner.get("name").and_then(|name| name.as_str()).unwrap_or_default().to_string();
        let of_this = rest.strip_prefix(name.as_str()).and_then(|rest| rest.strip_prefix('.'));
        if let Some(rest) = rest.strip_prefix("*.").or(of_this) {
            put(inner, rest, value);
        }
    };
    each_table(item, of);
}

/// Goes through the tables of a list.
fn each_table(item: &mut Item, mut of: impl FnMut(&mut dyn TableLike)) {
    match item {
        Item::ArrayOfTables(tables) => tables.iter_mut().for_each(|table| of(table)),
        Item::Value(Value::Array(items)) => {
            items.iter_mut().filter_map(Value::as_inline_table_mut).for_each(|table| of(table));
        }
        _ => {}
    }
}

/// Multiplies a factor of every joint, or of each of its load cases.
fn scale_all(document: &mut DocumentMut, name: &str, factor: f64) {
    let one = |table: &mut dyn TableLike| multiply(table, name, factor);
    let Some(joints) = document.get_mut("joint") else { return };
    each_table(joints, |joint| match joint.get_mut("case") {
        Some(cases) => each_table(cases, one),
        None => one(joint),
    });
}

/// The key of a design file.
pub(super) const SET: Key =
    key("set", "values in the place of the requirement's, as `--set` gives them: keys are paths in quotes");
