//! `optimize --search`: the best design over one number of the requirement.

use std::path::Path;

use super::{CatalogChoice, Done, Failure, Output, Set};
use crate::ask::{settled, told_set};
use crate::design::optimize::optimize_with;
use crate::design::options::Options;
use crate::design::over::{Found, Looked, search};
use crate::input::Source;
use crate::report::json;
use crate::report::over::{self, Asked};
use crate::requirement::{Balancing, Settings};
use crate::units;

/// A range as it is written: `KEY=LOW:HIGH`.
struct Over {
    key: String,
    low: f64,
    high: f64,
    unit: String,
}

impl Over {
    fn parse(text: &str) -> Result<Over, Failure> {
        let wrong = |what: &str| {
            let example = "write KEY=LOW:HIGH, as in joint.knee.transmission.ratio=1:3, or =\"20 mm:60 mm\"";
            Failure::Argument(format!("`--search {text}`: {what}; {example}"))
        };
        let (key, range) = text.split_once('=').ok_or_else(|| wrong("there is no `=`"))?;
        let (low, high) = range.split_once(':').ok_or_else(|| wrong("there is no `:` between two values"))?;
        let number = |text: &str| {
            let (value, unit) = units::apart(text.trim().trim_matches('"'));
            Some((units::number_value(value).ok()?, unit.to_string()))
        };
        let ((low, of_low), (high, unit)) =
            number(low).zip(number(high)).ok_or_else(|| wrong("a value is not a number with a unit"))?;
        if of_low != unit && !of_low.is_empty() {
            return Err(wrong("both values need the same unit"));
        }
        if low >= high {
            return Err(wrong("the range is empty or upside down"));
        }
        Ok(Over { key: key.trim().to_string(), low, high, unit })
    }

    /// The value as a requirement has it.
    fn setting(&self, value: f64) -> String {
        match self.unit.as_str() {
            "" => format!("{}={value}", self.key),
            unit => format!("{}=\"{value} {unit}\"", self.key),
        }
    }
}

/// Searches and reports.
pub(super) fn run(
    text: &str,
    points: usize,
    requirement: &Path,
    set: &Set,
    catalog: &CatalogChoice,
    only_checked: bool,
    output: &Output,
) -> Result<Done, Failure> {
    let over = Over::parse(text)?;
    let source = Source::argument(requirement).map_err(|e| vec![e])?;
    let settings = set.settings()?;
    let plain = settings.read(&source, None)?;
    if plain.is_coupled() {
        let message = "`--search` looks at each joint by itself: a budget, a supply that sags or carried actuators do not go with it";
        return Err(Failure::Argument(message.into()));
    }
    let name = plain.joints[0].objective.name();
    let same = plain.joints.iter().all(|joint| joint.objective.name() == name);
    if !same || plain.joints.iter().any(|joint| joint.balancing != Balancing::No) {
        let message = "`--search` compares one objective of all joints: give all the same, and none that is balanced";
        return Err(Failure::Argument(message.into()));
    }
    let rows = catalog.rows()?.for_robot(&plain)?;
    let plain = settled(plain, &rows)?;
    let change = |value: f64| Settings::of_arguments(&[over.setting(value)]).map_err(Failure::Argument);
    let mut wrong = None;
    let look = |value: f64| -> Result<Looked, Failure> {
        let robot = match settings.then(&change(value)?).read(&source, None) {
            Ok(robot) => robot,
            Err(errors) => {
                let first = errors.first().and_then(|e| e.problems.first());
                let why = first.map_or_else(|| "the requirement is wrong there".into(), |p| p.message.clone());
                wrong.get_or_insert(errors);
                return Ok(Looked { value, found: Err(why) });
            }
        };
        let robot = settled(robot, &rows)?;
        let result = optimize_with(&robot, &rows, Options { only_checked, ..Options::default() })?;
        Ok(Looked { value, found: Ok(result.joints.iter().map(Found::new).collect()) })
    };
    let all = search((over.low, over.high), points, look)?;
    // What is wrong at every value is no matter of the value.
    if let Some(errors) = wrong.filter(|_| all.iter().all(|looked| looked.found.is_err())) {
        return Err(errors.into());
    }
    let unit = plain.joints[0].objective.unit();
    let asked = Asked { key: over.key, unit: over.unit, points, objective: (name, unit) };
    let satisfied = crate::design::over::best(&all).is_some();
    let text = output.choose(
        || told_set(&plain) + &over::text(&asked, &all),
        || json::over::json(&asked, &all),
        || over::csv(&asked, &all),
    );
    Ok(Done { text, satisfied })
}
