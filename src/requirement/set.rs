//! Values that a call puts in the place of a requirement's own: `--set bus.voltage="48 V"`, and `set` of a design file.
//!
//! The one idea: what is set is a [`Change`], as a grid of parameters makes it, with the same keys; it keeps the place
//! where it was written, so that each mistake is told there. What was set stays with the robot ([`Robot::set`]).

use std::sync::Arc;

use toml::de::DeValue;

use super::motions::{FromDisk, Motions};
use super::read;
use super::robot::Robot;
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
        let robot = read::read_as(source, &changes, no_springs, motions);
        let wrong = |problem: Problem| InputError { source: source.clone(), problems: vec![problem] };
        let mut robot = match (robot, factors.is_empty()) {
            (Ok(robot), true) => robot,
            (read, _) => {
                let own = factors.into_iter().map(wrong);
                let errors = own.chain(read.err().into_iter().flatten()).collect();
                return Err(Change::send_home(errors, &self.homes));
            }
        };
        scale(&mut robot, torque, speed);
        robot.set = self.changes.iter().map(Change::said).collect();
        Ok(robot)
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

/// Multiplies the motions of all joints: torques by the one factor; the same positions at another speed by the other.
pub fn scale(robot: &mut Robot, torque: f64, speed: f64) {
    // As it is, it is shared.
    if (torque, speed) == (1.0, 1.0) {
        return;
    }
    let joints = std::mem::take(&mut robot.joints);
    robot.joints = joints.into_iter().map(|joint| joint.scaled(torque, speed)).collect();
}

/// The key of a design file.
pub(super) const SET: Key =
    key("set", "values in the place of the requirement's, as `--set` gives them: keys are paths in quotes");
