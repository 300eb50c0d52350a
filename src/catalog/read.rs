//! Catalogue files: CSV rows to motors and gears, every mistake with its place.

use std::collections::HashMap;
use std::sync::Arc;

use super::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding,
};
use super::gear::{GEAR_FIELDS, Gear, GearKind};
use super::motor::{Identity, Incomplete, Motor};
use super::sheet::{Conventions, FIELDS, Printed, Sheet, SourceKind};
use crate::input::csv::{Column, Content, Table};
use crate::input::{InputError, Problem, Source};

const MOTOR_TEXTS: &[&str] = &[
    "manufacturer",
    "model",
    "commutation",
    "winding",
    "back_emf_convention",
    "speed_constant_convention",
    "note",
    "audit_accept",
];
const MOTOR_REQUIRED: &[&str] = &["id", "terminals", "current", "source", "source_kind"];

const GEAR_TEXTS: &[&str] = &["manufacturer", "model", "fits", "note"];
const GEAR_REQUIRED: &[&str] = &["id", "kind", "source", "source_kind"];

fn text_columns(names: &[&str], required: bool) -> impl Iterator<Item = Column> {
    names
        .iter()
        .map(move |name| Column { name: (*name).to_string(), content: Content::Text, required })
        .collect::<Vec<_>>()
        .into_iter()
}

/// The columns that a motor catalogue may have, in the order of the documentation.
pub fn motor_columns() -> Vec<Column> {
    let mut columns: Vec<Column> = text_columns(MOTOR_REQUIRED, true).chain(text_columns(MOTOR_TEXTS, false)).collect();
    columns.push(Column { name: "pole_pairs".into(), content: Content::Count, required: false });
    for field in FIELDS {
        let required = field.name == "resistance";
        columns.push(Column { name: field.name.into(), content: Content::Quantity(field.kind, field.range), required });
        columns.push(Column {
            name: format!("{}_tolerance", field.name),
            content: Content::Tolerance(field.kind),
            required: false,
        });
    }
    columns
}

/// The columns that a gear catalogue may have.
pub fn gear_columns() -> Vec<Column> {
    let mut columns: Vec<Column> = text_columns(GEAR_REQUIRED, true).chain(text_columns(GEAR_TEXTS, false)).collect();
    columns.push(Column { name: "stages".into(), content: Content::Count, required: false });
    for field in GEAR_FIELDS {
        columns.push(Column {
            name: field.name.into(),
            content: Content::Quantity(field.kind, field.range),
            required: field.name == "ratio",
        });
    }
    columns
}

/// Whether the header of a catalogue file is that of motors, of gears, or of neither.
pub fn is_gear_file(source: &Source) -> bool {
    let header = source.text().lines().find(|l| !l.starts_with('#') && !l.trim().is_empty()).unwrap_or("");
    let names: Vec<&str> = header.split(',').map(|c| c.split('[').next().unwrap_or("").trim()).collect();
    names.contains(&"ratio") && !names.contains(&"torque_constant") && !names.contains(&"terminals")
}

/// Reads the motors of one file.
///
/// # Errors
/// Every mistake of the file.
pub fn read_motors(source: &Arc<Source>) -> Result<Vec<Motor>, InputError> {
    let mut problems = Vec::new();
    let mut motors = Vec::new();
    if let Some(table) = Table::read(source, motor_columns(), &mut problems) {
        let mut seen = HashMap::new();
        for row in 0..table.len() {
            if let Some(motor) = read_motor(&table, row, &mut problems) {
                note_duplicate(&table, row, &motor.id, &mut seen, &mut problems);
                motors.push(motor);
            }
        }
    }
    InputError::unless_empty(source, problems)?;
    Ok(motors)
}

/// Reads the gears of one file.
///
/// # Errors
/// Every mistake of the file.
pub fn read_gears(source: &Arc<Source>) -> Result<Vec<Gear>, InputError> {
    let mut problems = Vec::new();
    let mut gears = Vec::new();
    if let Some(table) = Table::read(source, gear_columns(), &mut problems) {
        let mut seen = HashMap::new();
        for row in 0..table.len() {
            if let Some(gear) = read_gear(&table, row, &mut problems) {
                note_duplicate(&table, row, &gear.id, &mut seen, &mut problems);
                gears.push(gear);
            }
        }
    }
    InputError::unless_empty(source, problems)?;
    Ok(gears)
}

fn note_duplicate(table: &Table, row: usize, id: &str, seen: &mut HashMap<String, usize>, problems: &mut Vec<Problem>) {
    if let Some(first) = seen.insert(id.to_string(), row) {
        problems.push(Problem::at(
            table.cell_span(row, "id"),
            format!("the id `{id}` stands twice"),
            format!("first in row {} below the header", first + 1),
        ));
    }
}

/// The text of a cell that must not be blank.
fn required(table: &Table, row: usize, name: &str, problems: &mut Vec<Problem>) -> Option<String> {
    let text = table.text(row, name).map(str::to_string);
    if text.is_none() && table.has(name) {
        problems.push(Problem::at(
            table.row_span(row),
            format!("`{name}` is blank"),
            format!("this row needs its {name}"),
        ));
    }
    text
}

fn read_identity(table: &Table, row: usize, problems: &mut Vec<Problem>) -> Option<Identity> {
    let id = required(table, row, "id", problems);
    if let Some(id) = &id {
        let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '.' | '_');
        if !id.chars().all(good) {
            problems.push(
                Problem::at(
                    table.cell_span(row, "id"),
                    "an id has lower-case letters, digits, `-`, `_` and `.` only",
                    "other characters here",
                )
                .help(format!("for example `{}`", id.to_lowercase().replace(|c| !good(c), "-"))),
            );
        }
    }
    let source = required(table, row, "source", problems);
    let source_kind = match table.text(row, "source_kind") {
        Some(_) => table.choice(row, "source_kind", SourceKind::NAMES, problems),
        None => {
            required(table, row, "source_kind", problems);
            None
        }
    };
    let text = |name: &str| table.text(row, name).unwrap_or("").to_string();
    Some(Identity {
        id: id?,
        manufacturer: text("manufacturer"),
        model: text("model"),
        source: source?,
        source_kind: source_kind?,
        note: text("note"),
        accepted_findings: text("audit_accept")
            .split([';', ' '])
            .filter(|s| !s.is_empty())
            .map(str::to_string)
            .collect(),
    })
}

fn read_motor(table: &Table, row: usize, problems: &mut Vec<Problem>) -> Option<Motor> {
    let before = problems.len();
    let identity = read_identity(table, row, problems);
    let convention = |name: &str, problems: &mut Vec<Problem>, names: &str| {
        if table.text(row, name).is_none() && table.has(name) {
            problems.push(
                Problem::at(
                    table.row_span(row),
                    format!("`{name}` is blank: no convention given"),
                    "the numbers of this row cannot be read without it",
                )
                .help(format!("one of {names}; `audit` can suggest which fits")),
            );
        }
    };
    convention("terminals", problems, "line_to_line, winding, q_axis");
    convention("current", problems, "q_axis, phase_amplitude, rms, dc");
    let commutation = table.choice(row, "commutation", Commutation::NAMES, problems).unwrap_or(Commutation::Brushless);
    let terminals = table.choice(row, "terminals", Terminals::NAMES, problems);
    let current = table.choice(row, "current", CurrentConvention::NAMES, problems);
    let winding = table.choice(row, "winding", Winding::NAMES, problems);
    let back_emf = table.choice(row, "back_emf_convention", BackEmfConvention::NAMES, problems);
    let speed_constant = table.choice(row, "speed_constant_convention", SpeedConstantConvention::NAMES, problems);
    if commutation == Commutation::Brushed && current.is_some_and(|c| c != CurrentConvention::Dc) {
        problems.push(Problem::at(table.cell_span(row, "current"), "a brushed motor has DC amperes", "expected `dc`"));
    }
    let pole_pairs = table.number(row, "pole_pairs", problems).map(|n| n.value as u32);
    let mut sheet = Sheet::default();
    for field in FIELDS {
        let tolerance_name = format!("{}_tolerance", field.name);
        let tolerance = table.number(row, &tolerance_name, problems);
        let Some(number) = table.number(row, field.name, problems) else {
            if tolerance.is_some() && table.text(row, field.name).is_none() {
                problems.push(Problem::at(
                    table.cell_span(row, &tolerance_name),
                    format!("`{tolerance_name}` stands without `{}`", field.name),
                    "a tolerance of nothing",
                ));
            }
            continue;
        };
        let tolerance = tolerance.map(|t| if t.relative { t.value * number.value.abs() } else { t.value });
        (field.set)(&mut sheet, Printed { value: number.value, tolerance });
    }
    if let (Some(continuous), Some(peak)) = (sheet.continuous_current, sheet.peak_current)
        && continuous.value > peak.value
    {
        problems.push(Problem::at(
            table.cell_span(row, "peak_current"),
            "`peak_current` is less than `continuous_current`",
            "the two may be swapped",
        ));
    }
    if problems.len() > before {
        return None;
    }
    let conventions =
        Conventions { commutation, terminals: terminals?, winding, current: current?, back_emf, speed_constant };
    match Motor::new(identity?, conventions, sheet, pole_pairs) {
        Ok(motor) => Some(motor),
        Err(incomplete) => {
            problems.push(incomplete_problem(table, row, incomplete));
            None
        }
    }
}

fn incomplete_problem(table: &Table, row: usize, incomplete: Incomplete) -> Problem {
    let (column, message, help) = match incomplete {
        Incomplete::Resistance => (
            "resistance",
            "`resistance` is blank",
            "without a resistance nothing can be said of a motor; leave the row out",
        ),
        Incomplete::TorqueConstant => (
            "torque_constant",
            "no torque constant, and nothing to derive it from",
            "give torque_constant, back_emf_constant or speed_constant",
        ),
        Incomplete::Winding => (
            "terminals",
            "`terminals` is `winding`, but `winding` does not say wye or delta",
            "give winding as wye or delta",
        ),
        Incomplete::BackEmfConvention => (
            "back_emf_constant",
            "`back_emf_constant` stands without `back_emf_convention`",
            "one of q_axis, line_to_line_peak, line_to_line_rms, phase_peak, phase_rms, dc",
        ),
        Incomplete::SpeedConstantConvention => (
            "speed_constant",
            "`speed_constant` stands without `speed_constant_convention`",
            "line_to_line_peak (outrunners) or dc (maxon, FAULHABER, brushed)",
        ),
    };
    Problem::at(table.cell_span(row, column), message, "in this row").help(help)
}

fn read_gear(table: &Table, row: usize, problems: &mut Vec<Problem>) -> Option<Gear> {
    let before = problems.len();
    let identity = read_identity(table, row, problems);
    if table.text(row, "kind").is_none() {
        required(table, row, "kind", problems);
    }
    let kind = table.choice(row, "kind", GearKind::NAMES, problems);
    let stages = table.number(row, "stages", problems).map(|n| n.value as u32);
    let mut gear = Gear {
        id: String::new(),
        manufacturer: String::new(),
        model: String::new(),
        kind: kind.unwrap_or(GearKind::Direct),
        ratio: f64::NAN,
        stages,
        efficiency: None,
        backdrive_efficiency: None,
        mass: None,
        inertia: None,
        continuous_torque: None,
        peak_torque: None,
        max_input_speed: None,
        backlash: None,
        stiffness: None,
        fits: Vec::new(),
        source: String::new(),
        source_kind: SourceKind::Datasheet,
        note: String::new(),
    };
    for field in GEAR_FIELDS {
        if let Some(number) = table.number(row, field.name, problems) {
            (field.set)(&mut gear, number.value);
        }
    }
    if table.text(row, "ratio").is_none() {
        required(table, row, "ratio", problems);
    }
    if gear.backdrive_efficiency.is_some_and(|b| b > 1.0) {
        problems.push(Problem::at(
            table.cell_span(row, "backdrive_efficiency"),
            "`backdrive_efficiency` is out of range",
            "expected at most 1",
        ));
    }
    if let (Some(continuous), Some(peak)) = (gear.continuous_torque, gear.peak_torque)
        && continuous > peak
    {
        problems.push(Problem::at(
            table.cell_span(row, "peak_torque"),
            "`peak_torque` is less than `continuous_torque`",
            "the two may be swapped",
        ));
    }
    gear.fits =
        table.text(row, "fits").unwrap_or("").split([';', ' ']).filter(|p| !p.is_empty()).map(str::to_string).collect();
    if problems.len() > before || kind.is_none() {
        return None;
    }
    let identity = identity?;
    Some(Gear {
        id: identity.id,
        manufacturer: identity.manufacturer,
        model: identity.model,
        source: identity.source,
        source_kind: identity.source_kind,
        note: identity.note,
        ..gear
    })
}
