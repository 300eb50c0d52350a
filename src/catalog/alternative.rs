//! What other sources say of a number of a row: second editions of a sheet, measurements, secondary lists.
//!
//! The one idea: a row says one number of each kind, and what else was printed stands beside it in a long table. It is shown and
//! compared, and never computed with unless `--alternatives worst` asks for it.

use std::ops::Range as Span;
use std::sync::Arc;

use super::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding, word,
};
use super::module::{MODULE_FIELDS, Module, ModuleSheet, NoLoadCurrent};
use super::row::{Cells, Holds, MotorRow, Need, Row, Side, find};
use super::sheet::{Printed, SourceKind};
use super::{Catalog, Field, Gear};
use crate::input::csv::{Column, Content};
use crate::input::{InputError, Problem, Source};
use crate::units::{self, Kind};
use crate::words::nearest;

/// What stands where a source does not say the convention.
pub const NOT_SAID: &str = "not said";

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

/// A line of a file, before its row is known.
#[derive(Debug, Clone)]
pub(super) struct Written {
    /// Texts of the columns, in the order of [`COLUMNS`], each with its place.
    cells: Vec<(String, Span<usize>)>,
}

/// The columns, and whether a line must have them.
const COLUMNS: &[(&str, bool)] = &[
    ("id", true),
    ("column", true),
    ("value", true),
    ("unit", false),
    ("side", false),
    ("convention", false),
    ("tolerance", false),
    ("source", true),
    ("source_kind", true),
    ("source_date", false),
    ("note", false),
];

/// The columns of a table of alternatives.
pub(super) fn columns() -> Vec<Column> {
    let column =
        |(name, required): &(&str, bool)| Column { name: (*name).into(), content: Content::Text, required: *required };
    COLUMNS.iter().map(column).collect()
}

/// Reads a line.
pub(super) fn read(cells: &dyn Cells) -> Option<Written> {
    let before = cells.noted();
    let mut of = |(name, required): &(&'static str, bool)| {
        let text = cells.text((*name).into()).unwrap_or_default();
        if text.is_empty() && *required {
            cells.blank(name, Need::Must("…"), &[]);
        }
        (text, cells.span(name))
    };
    let written = Written { cells: COLUMNS.iter().map(&mut of).collect() };
    (cells.noted() == before).then_some(written)
}

/// A column of some kind of row.
#[derive(Debug, Clone, Copy)]
enum Meant {
    Number(&'static Kind),
    Other,
}

/// The columns of a kind of row that an alternative may be of, each with its content.
fn meant<R: Row>() -> impl Iterator<Item = (&'static str, Meant)> {
    let others = R::BEFORE.iter().chain(R::AFTER);
    let others =
        others.filter(|c| matches!(c.holds, Holds::Pairs(..) | Holds::Count(..))).map(|c| (c.name, Meant::Other));
    R::fields().iter().map(|field| (field.name, Meant::Number(field.kind))).chain(others)
}

impl Written {
    fn get(&self, name: &str) -> (&str, Span<usize>) {
        let at = COLUMNS.iter().position(|(column, _)| *column == name).expect("a column");
        let (text, span) = &self.cells[at];
        (text.as_str(), span.clone())
    }

    /// The alternative, of the row that it names.
    ///
    /// # Errors
    /// What is wrong with the line.
    fn resolve(&self, catalog: &Catalog) -> Result<Alternative, Problem> {
        let (id, at) = self.get("id");
        let columns: Vec<(&'static str, Meant)> = match () {
            () if catalog.modules.iter().any(|m| m.id == id) => meant::<Module>().collect(),
            () if catalog.motors.iter().any(|m| m.id == id) => meant::<MotorRow>().collect(),
            () if catalog.gears.iter().any(|g| g.id == id) => meant::<Gear>().collect(),
            () => {
                let motors = catalog.motors.iter().map(|m| m.id.as_str());
                let all = motors.chain(catalog.gears.iter().map(|g| g.id.as_str()));
                let near = nearest(id, all.chain(catalog.modules.iter().map(|m| m.id.as_str())));
                let help = near
                    .map_or_else(|| "an alternative stands beside a row".into(), |n| format!("did you mean `{n}`?"));
                return Err(
                    Problem::at(at, format!("there is no row `{id}` in the catalogue"), "no such id").help(help)
                );
            }
        };
        let (name, at) = self.get("column");
        let Some((column, meant)) = columns.iter().find(|(column, _)| *column == name).copied() else {
            let near = nearest(name, columns.iter().map(|(column, _)| *column));
            let help =
                near.map_or_else(|| "a column of numbers is expected".into(), |n| format!("did you mean `{n}`?"));
            return Err(Problem::at(at, format!("the row `{id}` has no number `{name}`"), "no such column").help(help));
        };
        let ((value, at), (unit, unit_at), (tolerance, tolerance_at)) =
            (self.get("value"), self.get("unit"), self.get("tolerance"));
        let wrong = |error: units::UnitError, kind: &Kind, at: Span<usize>| {
            Problem::at(at, error.message(kind), "in this line").help(error.help(kind))
        };
        let printed = match meant {
            Meant::Other => None,
            Meant::Number(kind) => {
                let with_unit = |text: &str| format!("{text} {unit}");
                let place = if unit.is_empty() || units::number_value(value).is_err() { at.clone() } else { unit_at };
                let value = units::quantity(&with_unit(value), kind).map_err(|error| wrong(error, kind, place))?;
                let tolerance = match tolerance {
                    "" => None,
                    text => {
                        Some(units::difference(&with_unit(text), kind).map_err(|e| wrong(e, kind, tolerance_at))?.abs())
                    }
                };
                Some(Printed { value, tolerance })
            }
        };
        let (side, at) = self.get("side");
        let side = match side {
            "" | NOT_SAID => None,
            word => Some(find(Side::NAMES, word).ok_or_else(|| {
                Problem::at(at, format!("`{word}` is no side of a gear"), "expected `motor`, `output` or blank")
            })?),
        };
        let (convention, at) = self.get("convention");
        let words = words(column);
        let convention = match convention {
            "" | NOT_SAID => None,
            word => Some(words.iter().find(|known| **known == word).copied().ok_or_else(|| {
                let expected = match words {
                    [] => "this column has no convention: leave it blank".to_string(),
                    words => format!("one of {}, or `{NOT_SAID}`", words.join(", ")),
                };
                Problem::at(at, format!("`{word}` is no convention of `{column}`"), "not known").help(expected)
            })?),
        };
        let (kind, at) = self.get("source_kind");
        let source_kind = find(SourceKind::NAMES, kind).ok_or_else(|| {
            let known: Vec<&str> = SourceKind::NAMES.iter().map(|(name, _)| *name).collect();
            Problem::at(at, format!("`{kind}` is no kind of source"), format!("expected one of {}", known.join(", ")))
        })?;
        Ok(Alternative {
            id: id.into(),
            column,
            text: [value, unit].join(" ").trim().to_string(),
            value: printed,
            unit: if let Meant::Number(kind) = meant { kind.si } else { "" },
            side,
            convention,
            source: self.get("source").0.into(),
            source_date: self.get("source_date").0.into(),
            source_kind,
            note: self.get("note").0.into(),
        })
    }
}

/// The words that may stand as the convention of a column; none where it needs none.
fn words(column: &str) -> &'static [&'static str] {
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

/// The alternatives of files, each of a row that is there.
///
/// # Errors
/// The wrong lines.
pub(super) fn resolve(
    written: Vec<(Arc<Source>, Vec<Written>)>,
    catalog: &Catalog,
) -> Result<Vec<Alternative>, Vec<InputError>> {
    let (mut all, mut errors) = (Vec::new(), Vec::new());
    for (source, lines) in written {
        let mut problems = Vec::new();
        for line in &lines {
            match line.resolve(catalog) {
                Ok(alternative) => all.push(alternative),
                Err(problem) => problems.push(problem),
            }
        }
        if !problems.is_empty() {
            errors.push(InputError { source, problems });
        }
    }
    // Stable: what stands in a file stays in its order.
    all.sort_by(|a, b| (&a.id, a.column).cmp(&(&b.id, b.column)));
    if errors.is_empty() { Ok(all) } else { Err(errors) }
}

/// What a module's number is at the flange and on the q axis: it, times this. `None` where its side or convention is not said.
fn factor(
    module: &Module,
    column: &str,
    side: Option<Side>,
    convention: Option<&str>,
    winding: Option<Winding>,
) -> Option<f64> {
    let brushless = Commutation::Brushless;
    let at_output = |power: i32| {
        Some(match side? {
            Side::Output => 1.0,
            Side::Motor => module.ratio().powi(power),
        })
    };
    let of_current = || find(CurrentConvention::NAMES, convention?);
    match column {
        "armature" | "viscous_friction" => at_output(2),
        "static_friction" | "dynamic_friction" => at_output(1),
        "torque_constant" => Some(at_output(1)? * of_current()?.torque_constant(brushless)),
        "rated_current" | "peak_current" | "no_load_current" => Some(of_current()?.torque_current(brushless)),
        "back_emf_constant" => {
            Some(at_output(1)? * find(BackEmfConvention::NAMES, convention?)?.back_emf_constant(brushless))
        }
        "speed_constant" => {
            Some(at_output(-1)? / find(SpeedConstantConvention::NAMES, convention?)?.back_emf_constant(brushless))
        }
        "resistance" | "inductance" => find(Terminals::NAMES, convention?)?.resistance(winding, brushless),
        _ => Some(1.0),
    }
}

fn scaled(printed: Printed, by: f64) -> Printed {
    Printed { value: printed.value * by, tolerance: printed.tolerance.map(|t| t * by.abs()) }
}

impl Alternative {
    /// Its number at the flange of its module and on the q axis; `None` where its source does not say side or convention, and of
    /// curves and tables.
    pub fn at_flange(&self, module: &Module) -> Option<Printed> {
        let winding = module.refers.winding;
        Some(scaled(self.value?, factor(module, self.column, self.side, self.convention, winding)?))
    }

    /// Its number as the module's row would print it; `None` where the two cannot be compared.
    pub fn as_in(&self, module: &Module) -> Option<Printed> {
        Some(scaled(self.at_flange(module)?, 1.0 / own_factor(module, self.column)?))
    }

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

fn own_factor(module: &Module, column: &str) -> Option<f64> {
    let refers = &module.refers;
    let convention = match column {
        "torque_constant" => refers.torque_constant_current.map(|is| word(CurrentConvention::NAMES, &is)),
        "back_emf_constant" => refers.back_emf_convention.map(|is| word(BackEmfConvention::NAMES, &is)),
        "speed_constant" => refers.speed_constant_convention.map(|is| word(SpeedConstantConvention::NAMES, &is)),
        "resistance" | "inductance" => refers.terminals.map(|is| word(Terminals::NAMES, &is)),
        "no_load_current" => refers.no_load_current_is.and_then(|is| match is {
            NoLoadCurrent::Winding(is) => Some(word(CurrentConvention::NAMES, &is)),
            NoLoadCurrent::Supply => None,
        }),
        _ => refers.current.map(|is| word(CurrentConvention::NAMES, &is)),
    };
    let side = match column {
        "armature" => refers.armature_side,
        "torque_constant" => refers.torque_constant_side,
        "back_emf_constant" => refers.back_emf_side,
        "speed_constant" => refers.speed_constant_side,
        _ => refers.friction_side,
    };
    factor(module, column, side, convention, refers.winding)
}

/// How far the published numbers of a column of a module are apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Spread {
    /// The column.
    pub column: &'static str,
    /// The least and the largest, at the flange and on the q axis, SI.
    pub ends: [f64; 2],
    /// Whether their ± leave a gap between them.
    pub disagree: bool,
    /// How many numbers are compared, the row's own one among them where it has one.
    pub compared: usize,
}

/// How far the published numbers of a module are apart, by column: those that say their side and convention.
pub fn spreads(module: &Module, alternatives: &[Alternative]) -> Vec<Spread> {
    let mine = |a: &&Alternative| a.id == module.id;
    let of_column = |field: &Field<ModuleSheet>| {
        let others = alternatives.iter().filter(mine).filter(|a| a.column == field.name);
        let mut all: Vec<Printed> = others.filter_map(|a| a.at_flange(module)).collect();
        if all.is_empty() {
            return None;
        }
        let own = (field.get)(&module.sheet).zip(own_factor(module, field.name));
        all.extend(own.map(|(printed, by)| scaled(printed, by)));
        let least = all.iter().map(|p| p.value).fold(f64::INFINITY, f64::min);
        let most = all.iter().map(|p| p.value).fold(f64::NEG_INFINITY, f64::max);
        let low = |p: &Printed| p.value - p.tolerance.unwrap_or(0.0);
        let high = |p: &Printed| p.value + p.tolerance.unwrap_or(0.0);
        let disagree =
            all.iter().map(low).fold(f64::NEG_INFINITY, f64::max) > all.iter().map(high).fold(f64::INFINITY, f64::min);
        (all.len() > 1).then_some(Spread { column: field.name, ends: [least, most], disagree, compared: all.len() })
    };
    MODULE_FIELDS.iter().filter_map(of_column).collect()
}

impl Catalog {
    /// What other sources say of a row.
    pub fn alternatives_of<'c>(&'c self, id: &'c str) -> impl Iterator<Item = &'c Alternative> {
        self.alternatives.iter().filter(move |a| a.id == id)
    }
}
