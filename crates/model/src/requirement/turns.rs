//! How many turns the windings of a joint's motors may have: `turns`.

use crate::catalog::Motor;
use crate::input::{Key, Problem, Range, Section, key};

/// How a joint's motor is looked at: as it is wound, or with limits that depend on its turns let go.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Turns {
    /// As it is wound.
    #[default]
    AsWound,
    /// Any number: what depends on it (voltage, the drive's current) is no limit.
    Any,
    /// Of some number up to this many times as many: what voltage asks is that of the fewest, what the drive's current asks
    /// that of the most.
    UpTo(f64),
}

impl Turns {
    /// How many times its own the drive's current may be, in ampere of the motor as it is looked at; `None` where it is no
    /// limit.
    pub fn of_current(self) -> Option<f64> {
        match self {
            Turns::AsWound => Some(1.0),
            Turns::Any => None,
            Turns::UpTo(times) => Some(times),
        }
    }
}

/// Which windings may be chosen, in turns as multiples of those of a row.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Windings {
    /// That of the row.
    #[default]
    AsWound,
    /// These.
    Listed(Vec<f64>),
    /// Any between two.
    Between {
        /// The fewest.
        min: f64,
        /// The most.
        max: f64,
        /// Of each row the one that was found to be the best; empty before it was looked for.
        found: Vec<(String, f64)>,
    },
}

impl Windings {
    /// Whether a motor's winding may be chosen.
    pub fn allow(&self, motor: &Motor) -> bool {
        match self {
            Windings::AsWound => motor.wound.is_none(),
            Windings::Listed(turns) => turns.contains(&motor.turns()),
            Windings::Between { min, max, found } => match found.iter().find(|(row, _)| row == motor.row_id()) {
                Some((_, turns)) => *turns == motor.turns(),
                None => (*min..=*max).contains(&motor.turns()),
            },
        }
    }

    /// Whether a winding is none of a joint: another one of its row is, or it was made for another joint.
    pub fn pass_over(&self, motor: &Motor) -> bool {
        let replaced =
            || matches!(self, Windings::Between { found, .. } if found.iter().any(|(row, _)| row == motor.row_id()));
        !self.allow(motor) && (motor.wound.is_some() || replaced())
    }

    /// Those that are listed.
    pub fn listed(&self) -> &[f64] {
        match self {
            Windings::Listed(turns) => turns,
            Windings::AsWound | Windings::Between { .. } => &[],
        }
    }

    /// The fewest and the most of a range.
    pub fn range(&self) -> Option<(f64, f64)> {
        match self {
            Windings::Between { min, max, .. } => Some((*min, *max)),
            Windings::AsWound | Windings::Listed(_) => None,
        }
    }
}

/// Numbers of turns that make sense of one frame.
const SENSIBLE: std::ops::RangeInclusive<f64> = 0.05..=20.0;

const TURNS: Key = key(
    "turns",
    "turns of the winding as multiples of the row's: any between two, as `{ min = 0.5, max = 2 }`, or of a list, where 0.577 is a star connected in delta and 0.5 two halves in parallel; the row's own where it is not given",
);

/// Reads `turns`: what other numbers of turns may be chosen.
pub(super) fn read(section: &Section) -> Windings {
    if section.is_table("turns") {
        return read_range(section).unwrap_or_default();
    }
    let listed = section.number_list(TURNS, Range::Positive);
    if !section.has("turns") {
        return Windings::AsWound;
    }
    // What is wrong with a number was said.
    let Some(turns) = listed else { return Windings::AsWound };
    let wrong = |message: String, label: &str| {
        let problem = Problem::at(section.span_of("turns"), message, label);
        section.note(problem.help("for example turns = [1, 0.577], or turns = { min = 0.5, max = 2 }"));
        Windings::AsWound
    };
    if let Some(a) = turns.iter().find(|a| !SENSIBLE.contains(*a)) {
        return wrong(format!("{a} times the turns is no winding of one frame"), "expected 0.05 to 20");
    }
    match (1..turns.len()).find(|k| turns[..*k].contains(&turns[*k])) {
        Some(k) => wrong(format!("{} times the turns is listed twice", turns[k]), "expected each once"),
        None if turns.is_empty() => wrong("`turns` lists nothing".into(), "expected at least one number"),
        None => Windings::Listed(turns),
    }
}

/// Reads `{ min, max }`.
fn read_range(section: &Section) -> Option<Windings> {
    let table = section.section(TURNS)?;
    let ends = [("min", "the fewest", "0.5"), ("max", "the most", "2")].map(|(name, about, example)| {
        let read = table.number(key(name, about).value("number"), Range::Positive);
        if read.is_none() && !table.has(name) {
            table.missing(name, example);
        }
        let outside = read.filter(|turns| !SENSIBLE.contains(turns));
        if let Some(turns) = outside {
            let message = format!("{turns} times the turns is no winding of one frame");
            table.note(Problem::at(table.span_of(name), message, "expected 0.05 to 20"));
        }
        read.filter(|_| outside.is_none())
    });
    let span = table.span_of("max");
    table.finish();
    let [Some(min), Some(max)] = ends else { return None };
    if min > max {
        let message = format!("the range of turns is upside down: max = {max} is less than min = {min}");
        section.note(Problem::at(span, message, "less than min").help("swap min and max"));
        return None;
    }
    Some(Windings::Between { min, max, found: Vec::new() })
}
