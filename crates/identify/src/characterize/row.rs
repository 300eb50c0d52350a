//! The catalogue row that the tests make.
//!
//! Measured numbers go before those that the bench file gives, those before the declared motor's; where a number
//! comes from is in the row's source and note. The row is on the q axis throughout.

use super::{Outcome, find};
use crate::bench::Bench;
use gearwise_model::catalog::convention::{Commutation, Winding};
use gearwise_model::catalog::{FIELDS, Printed, Sheet};
use gearwise_model::effects::of_column;
use gearwise_model::words::number;

/// Columns that only repeat others: what was measured would contradict them.
pub(crate) const REDUNDANT: &[&str] = &[
    "speed_constant",
    "motor_constant",
    "responsiveness_metric",
    "torque_specific_inertia",
    "stall_torque",
    "no_load_speed",
    "no_load_current",
    "mechanical_time_constant",
];

/// Columns whose printed number stands in a convention.
const CONVENTIONAL: &[&str] =
    &["resistance", "inductance", "torque_constant", "back_emf_constant", "continuous_current", "peak_current"];

/// A row of a motor catalogue, on the q axis.
#[derive(Debug, Clone)]
pub struct Row {
    /// Id.
    pub id: String,
    /// Who makes the motor.
    pub manufacturer: String,
    /// What its maker calls it.
    pub model: String,
    /// Brushless or brushed.
    pub commutation: Commutation,
    /// How the windings are connected, where it was seen.
    pub winding: Option<Winding>,
    /// Pole pairs.
    pub pole_pairs: Option<u32>,
    /// The numbers with their ± (95 %).
    pub sheet: Sheet,
    /// Columns that were measured here.
    pub measured: Vec<&'static str>,
    /// Columns that were not measured, and where they are from.
    pub taken: Vec<(&'static str, String)>,
    /// What a catalogue needs and this row does not have.
    pub missing: Vec<&'static str>,
    /// Where the numbers come from.
    pub source: String,
    /// By which methods.
    pub note: String,
}

/// Brushless or brushed: as the bench says, or the declared motor, or brushless.
pub fn commutation(bench: &Bench) -> Commutation {
    let declared = bench.declared.motor.as_ref().map(|m| m.conventions.commutation);
    declared.or(bench.readings.motor.commutation).unwrap_or(Commutation::Brushless)
}

/// A number of the declared motor on the q axis, with its ±.
fn of_declared(bench: &Bench, name: &str) -> Option<Printed> {
    let motor = bench.declared.motor.as_ref()?;
    let field = FIELDS.iter().find(|f| f.name == name)?;
    let printed = (field.get)(&motor.sheet);
    let value = match name {
        "resistance" => Some(motor.resistance),
        "inductance" => motor.inductance,
        "torque_constant" => printed.map(|_| motor.torque_constant),
        "back_emf_constant" => printed.or(motor.sheet.speed_constant).map(|_| motor.back_emf_constant),
        "continuous_current" => motor.continuous_current,
        "peak_current" => motor.peak_current,
        _ => printed.map(|p| p.value),
    }?;
    let of = printed.or(motor.sheet.speed_constant.filter(|_| name == "back_emf_constant"));
    let tolerance = of.and_then(|p| p.relative_tolerance()).map(|t| t * value.abs());
    debug_assert!(CONVENTIONAL.contains(&name) || printed.is_some());
    Some(Printed { value, tolerance })
}

/// The row of a bench.
pub fn row(bench: &Bench, outcomes: &[Outcome]) -> Row {
    let known = &bench.readings.motor;
    let declared = bench.declared.motor.as_ref();
    let mut sheet = Sheet::default();
    let (mut measured, mut taken) = (Vec::new(), Vec::new());
    let friction = outcomes.iter().any(|o| o.test == "drag" && !o.quantities.is_empty());
    for field in FIELDS.iter().filter(|f| !REDUNDANT.contains(&f.name)) {
        if let Some(estimate) = find(outcomes, field.name).filter(|e| e.value > 0.0) {
            let tolerance = Some(estimate.half_width()).filter(|t| t.is_finite() && *t > 0.0);
            (field.set)(&mut sheet, Printed { value: estimate.value, tolerance });
            measured.push(field.name);
        } else if field.name == "reference_temperature" {
            let read = bench.readings.terminals.as_ref().and_then(|t| t.temperature);
            let own = measured.contains(&"resistance");
            let value = if own { read } else { declared.map(|m| m.reference_temperature) };
            if let Some(value) = value {
                (field.set)(&mut sheet, Printed { value, tolerance: None });
            }
        } else if let Some(printed) = (field.get)(&known.sheet) {
            (field.set)(&mut sheet, printed);
            taken.push((field.name, "given in the bench file".to_string()));
        } else if let Some(printed) = of_declared(bench, field.name) {
            // Half of what a drag test found is not to be mixed with half of another's.
            if friction && of_column(field.name).is_some() {
                continue;
            }
            (field.set)(&mut sheet, printed);
            taken.push((field.name, format!("row of {}", declared.map_or("", |m| m.id.as_str()))));
        }
    }
    sheet.offer = declared.map(|motor| motor.sheet.offer.clone()).unwrap_or_default();
    let pole_pairs = known.pole_pairs.or(declared.and_then(|m| m.pole_pairs)).filter(|p| *p > 0);
    if pole_pairs.is_some() {
        let from = if known.pole_pairs.is_some() {
            "given in the bench file".to_string()
        } else {
            format!("row of {}", declared.map_or("", |m| m.id.as_str()))
        };
        taken.push(("pole_pairs", from));
    }
    let mut missing = Vec::new();
    if sheet.resistance.is_none() {
        missing.push("resistance (terminals)");
    }
    if sheet.torque_constant.is_none() && sheet.back_emf_constant.is_none() {
        missing.push("torque_constant (stall) or back_emf_constant (backdrive)");
    }
    let id = known.id.clone().unwrap_or_else(|| match declared {
        Some(motor) => format!("{}-measured", motor.id),
        None => plain(&bench.name),
    });
    Row {
        id,
        manufacturer: known.manufacturer.clone().or(declared.map(|m| m.manufacturer.clone())).unwrap_or_default(),
        model: known.model.clone().or(declared.map(|m| m.model.clone())).unwrap_or_default(),
        commutation: commutation(bench),
        winding: bench
            .readings
            .terminals
            .as_ref()
            .and_then(|t| t.winding)
            .or(declared.and_then(|m| m.conventions.winding)),
        pole_pairs,
        source: source(bench),
        note: note(outcomes, &taken),
        sheet,
        measured,
        taken,
        missing,
    }
}

/// A name with the letters that an id may have.
fn plain(name: &str) -> String {
    let good = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
    let text: String = name.chars().map(good).collect();
    let text = text.trim_matches('-');
    if text.is_empty() { "measured-motor".into() } else { text.into() }
}

fn source(bench: &Bench) -> String {
    let file = bench.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let mut files: Vec<(&str, &str)> = Vec::new();
    for log in bench.logs.iter().filter(|l| l.usage == crate::bench::Use::Fit) {
        // One file may hold several logs: it is named once.
        if !files.iter().any(|(_, hash)| *hash == log.hash) {
            files.push((&log.file, &log.hash));
        }
    }
    let logs: Vec<String> = files.iter().map(|(name, hash)| format!("{name} sha256 {hash}")).collect();
    let logs = if logs.is_empty() { "readings only".to_string() } else { format!("logs: {}", logs.join("; ")) };
    format!("characterised by gearwise {} from {file}; {logs}", env!("CARGO_PKG_VERSION"))
}

fn note(outcomes: &[Outcome], taken: &[(&'static str, String)]) -> String {
    let mut parts = vec!["± are 95 %".to_string()];
    for outcome in outcomes {
        let names: Vec<String> = outcome
            .quantities
            .iter()
            .filter(|q| FIELDS.iter().any(|f| f.name == q.name))
            .map(|q| format!("{} ± {} %", q.name, number((1000.0 * q.estimate.relative()).round() / 10.0)))
            .collect();
        if !names.is_empty() {
            parts.push(format!("{}: {}", outcome.test, names.join(", ")));
        }
    }
    let mut sources: Vec<&str> = taken.iter().map(|(_, from)| from.as_str()).collect();
    sources.sort_unstable();
    sources.dedup();
    for from in sources {
        let names: Vec<&str> = taken.iter().filter(|(_, f)| f == from).map(|(name, _)| *name).collect();
        parts.push(format!("not measured, {from}: {}", names.join(", ")));
    }
    parts.join("; ")
}
