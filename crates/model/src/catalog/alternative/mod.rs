//! What other sources say of a number of a row: second editions of a sheet, measurements, secondary lists.
//!
//! The one idea: a row says one number of each kind, and what else was printed stands beside it in a long table. It is shown and
//! compared, and never computed with unless `--alternatives worst` asks for it.

pub mod spread;
pub mod written;

use super::convention::{BackEmfConvention, CurrentConvention, SpeedConstantConvention, Terminals, word};
use super::row::Side;
use super::sheet::{Printed, SourceKind};

/// A number that another source prints.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// Id of the row.
    pub id: String,
    /// Its column.
    pub column: &'static str,
    /// As printed, with its unit.
    pub text: String,
    /// The number, SI; `None` of a curve or a table.
    pub value: Option<Printed>,
    /// SI unit of it.
    pub unit: &'static str,
    /// At which side it is, where it is said.
    pub side: Option<Side>,
    /// The word of its convention; `None` where it needs none, or where it is not said.
    pub convention: Option<&'static str>,
    /// Where it is from.
    pub source: String,
    /// The day of the source.
    pub source_date: String,
    /// What kind of source that is.
    pub source_kind: SourceKind,
    /// What the reader should know.
    pub note: String,
}

/// The words that may stand as the convention of a column; none where it needs none.
pub(super) fn words(column: &str) -> &'static [&'static str] {
    match column {
        "torque_constant" | "rated_current" | "peak_current" | "no_load_current" | "continuous_current" => {
            CurrentConvention::WORDS
        }
        "back_emf_constant" => BackEmfConvention::WORDS,
        "speed_constant" => SpeedConstantConvention::WORDS,
        "resistance" | "inductance" => Terminals::WORDS,
        _ => &[],
    }
}

impl Alternative {
    /// What it is: the number with its ±, side and convention.
    pub fn said(&self) -> String {
        let tolerance = self.value.and_then(|v| v.relative_tolerance());
        let tolerance = tolerance.map_or_else(String::new, |share| format!(" ± {:.1} %", 100.0 * share));
        let side = match self.side {
            Some(side) => format!(" at the {}", side.word()),
            None if has_side(self.column) => ", side not said".into(),
            None => String::new(),
        };
        let convention = match self.convention {
            Some(word) => format!(", {word}"),
            None if words(self.column).is_empty() => String::new(),
            None => ", convention not said".into(),
        };
        format!("{}{tolerance}{side}{convention}", self.text)
    }

    /// The kind of its source, and the day.
    pub fn kind(&self) -> String {
        [word(SourceKind::NAMES, &self.source_kind), self.source_date.as_str()].join(" ").trim().to_string()
    }
}

/// Alternatives in a line for each column, without their sources.
pub fn lines(alternatives: &[Alternative]) -> Vec<String> {
    let of = |same: &[Alternative]| {
        let each: Vec<String> = same.iter().map(|a| format!("{} ({})", a.said(), a.kind())).collect();
        format!("{}: {}", same[0].column, each.join("; "))
    };
    alternatives.chunk_by(|a, b| a.column == b.column).map(of).collect()
}

/// Whether a number of a module says at which side of its gear it is.
fn has_side(column: &str) -> bool {
    let of_constant = ["torque_constant", "back_emf_constant", "speed_constant"];
    column == "armature" || column.ends_with("_friction") || of_constant.contains(&column)
}
