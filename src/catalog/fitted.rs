//! Fitted actuators: a TOML file with a motor's row, the effects that were found in its logs, its gear and
//! where all that comes from. It stands wherever a catalogue file may stand.

use std::sync::{Arc, LazyLock};

use super::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding,
};
use super::motor::{Identity, Incomplete, Motor};
use super::sheet::{Conventions, FIELDS, Printed, Sheet, SourceKind};
use crate::actuator::effects::{EFFECTS, Effect, Shape};
use crate::actuator::fitted::{FittedEffect, FittedGear};
use crate::input::{Form, InputError, Problem, Range, Section, Source};
use crate::units;

/// Where a fitted actuator comes from, and how sure its numbers are.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fit {
    /// Version of the program that fitted it.
    pub version: String,
    /// ± of effects' parameters by `effect.parameter`, in their SI unit; of several orders in their order.
    pub tolerances: Vec<(String, f64)>,
    /// Names of the fitted numbers, in the order of `covariance`.
    pub names: Vec<String>,
    /// Covariance of the fitted numbers, row by row, SI.
    pub covariance: Vec<Vec<f64>>,
    /// The logs.
    pub provenance: Vec<Provenance>,
}

/// A log that an actuator was fitted to, or judged on.
#[derive(Debug, Clone, PartialEq)]
pub struct Provenance {
    /// Its name.
    pub log: String,
    /// SHA-256 of the file, where it is known.
    pub sha256: Option<String>,
    /// What it was used for, where it is said.
    pub usage: Option<String>,
}

/// `…_tolerance` of every numeric column.
static TOLERANCES: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| FIELDS.iter().map(|f| &*format!("{}_tolerance", f.name).leak()).collect());

/// `…_tolerance` of every parameter of every effect, in the order of the library.
static EFFECT_TOLERANCES: LazyLock<Vec<Vec<&'static str>>> = LazyLock::new(|| {
    let of =
        |effect: &&dyn Effect| effect.parameters().iter().map(|p| &*format!("{}_tolerance", p.name).leak()).collect();
    EFFECTS.iter().map(of).collect()
});

/// Whether a file is that of a fitted actuator: by its name.
pub fn is_fitted_file(source: &Source) -> bool {
    source.name().to_ascii_lowercase().ends_with(".toml")
}

/// Reads a fitted actuator as a motor.
///
/// # Errors
/// Every mistake of the file.
pub fn read_fitted(source: &Arc<Source>) -> Result<Motor, InputError> {
    Form::read(source, |root| {
        if !root.has("motor") && (root.has("joint") || root.has("log") || root.has("bus")) {
            root.note(
                Problem::whole("this is no fitted actuator: it has no table [motor]")
                    .help("a requirement or a bench file stands alone, not in `--catalog`"),
            );
            return None;
        }
        let version =
            root.required_text("gearwise", "\"0.1.0\"  # the version that fitted it").map(|v| v.get_ref().clone());
        let mut fit = Fit { version: version.unwrap_or_default(), ..Fit::default() };
        if !root.has("motor") {
            root.missing("motor", "{ id = \"…\", resistance = \"0.7 ohm\", … }");
        }
        let motor = root.section("motor").and_then(|section| {
            let motor = read_motor(&section);
            section.finish();
            motor
        });
        let gear = root.section("gear").map(|section| {
            let gear = read_gear(&section);
            section.finish();
            gear
        });
        let effects = root.section("effects").map(|section| {
            let effects = read_effects(&section, motor.as_ref(), &mut fit);
            section.finish();
            effects
        });
        if let Some(section) = root.section("covariance") {
            read_covariance(&section, &mut fit);
            section.finish();
        }
        for section in root.sections("provenance") {
            if let Some(log) = section.required_text("log", "\"g1711.csv\"") {
                let text = |key| section.text(key).map(|t| t.get_ref().clone());
                let (sha256, usage) = (text("sha256"), text("use"));
                fit.provenance.push(Provenance { log: log.get_ref().clone(), sha256, usage });
            }
            section.finish();
        }
        Some(Motor { effects: effects.unwrap_or_default(), fitted_gear: gear, fit: Some(fit), ..motor? })
    })
}

fn read_motor(section: &Section) -> Option<Motor> {
    let id = section.required_text("id", "\"t-motor-ri50-fitted\"");
    if let Some(id) = &id {
        let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '.' | '_');
        if id.get_ref().is_empty() || !id.get_ref().chars().all(good) {
            section.note(Problem::at(
                id.span(),
                "an id has lower-case letters, digits, `-`, `_` and `.` only",
                "other characters here",
            ));
        }
    }
    let text = |key| section.text(key).map(|t| t.get_ref().clone());
    let identity = Identity {
        id: id.map_or_else(String::new, |id| id.get_ref().clone()),
        manufacturer: text("manufacturer").unwrap_or_default(),
        model: text("model").unwrap_or_default(),
        source: text("source").unwrap_or_else(|| "fitted to bench logs".into()),
        source_kind: section.choice("source_kind", SourceKind::NAMES).unwrap_or(SourceKind::Measured),
        note: text("note").unwrap_or_default(),
        accepted_findings: text("audit_accept")
            .map_or_else(Vec::new, |t| t.split([';', ' ']).filter(|s| !s.is_empty()).map(str::to_string).collect()),
    };
    for key in ["terminals", "current"] {
        if !section.has(key) {
            section.missing(key, "\"q_axis\"");
        }
    }
    let commutation = section.choice("commutation", Commutation::NAMES).unwrap_or(Commutation::Brushless);
    let terminals = section.choice("terminals", Terminals::NAMES);
    let current = section.choice("current", CurrentConvention::NAMES);
    let winding = section.choice("winding", Winding::NAMES);
    let back_emf = section.choice("back_emf_convention", BackEmfConvention::NAMES);
    let speed_constant = section.choice("speed_constant_convention", SpeedConstantConvention::NAMES);
    if commutation == Commutation::Brushed && current.is_some_and(|c| c != CurrentConvention::Dc) {
        section.note(Problem::at(section.span_of("current"), "a brushed motor has DC amperes", "expected `dc`"));
    }
    let pole_pairs = section.count("pole_pairs");
    let mut sheet = Sheet::default();
    for (field, tolerance_name) in FIELDS.iter().zip(TOLERANCES.iter()) {
        let value = section.quantity(field.name, field.kind, field.range);
        let tolerance = read_tolerance(section, tolerance_name, field.kind, value);
        match value {
            Some(value) => (field.set)(&mut sheet, Printed { value, tolerance }),
            None if section.has(tolerance_name) && !section.has(field.name) => section.note(Problem::at(
                section.span_of(tolerance_name),
                format!("`{tolerance_name}` stands without `{}`", field.name),
                "a tolerance of nothing",
            )),
            None => {}
        }
    }
    let conventions =
        Conventions { commutation, terminals: terminals?, winding, current: current?, back_emf, speed_constant };
    match Motor::new(identity, conventions, sheet, pole_pairs) {
        Ok(motor) => Some(motor),
        Err(incomplete) => {
            let (key, example) = match incomplete {
                Incomplete::Resistance => ("resistance", "\"0.7 ohm\""),
                Incomplete::TorqueConstant => ("torque_constant", "\"0.1 N*m/A\""),
                Incomplete::Winding => ("winding", "\"wye\"  # or \"delta\""),
                Incomplete::BackEmfConvention => ("back_emf_convention", "\"q_axis\""),
                Incomplete::SpeedConstantConvention => ("speed_constant_convention", "\"line_to_line_peak\""),
            };
            // What is there but wrong was said already.
            if !section.has(key) {
                section.missing(key, example);
            }
            None
        }
    }
}

/// A tolerance in the unit of its number, or in per cent of it.
fn read_tolerance(section: &Section, key: &'static str, kind: &'static units::Kind, value: Option<f64>) -> Option<f64> {
    let text = section.is_text(key).then(|| section.text(key)).flatten();
    if kind.needs_unit()
        && let Some(text) = &text
        && text.get_ref().contains('%')
    {
        let share = units::quantity(text.get_ref(), &units::RATIO).ok().filter(|s| *s >= 0.0);
        if share.is_none() {
            section.note(Problem::at(text.span(), format!("`{key}` is no percentage"), "expected like \"2 %\""));
        }
        return Some(share? * value?.abs());
    }
    if !kind.needs_unit() {
        return section.number(key, Range::NonNegative);
    }
    section.quantity(key, kind, Range::NonNegative)
}

fn read_gear(section: &Section) -> FittedGear {
    let backdrive_efficiency = section.number("backdrive_efficiency", Range::Any);
    if backdrive_efficiency.is_some_and(|b| b > 1.0) {
        section.note(Problem::at(
            section.span_of("backdrive_efficiency"),
            "`backdrive_efficiency` is out of range",
            "expected at most 1",
        ));
    }
    FittedGear {
        efficiency: section.number("efficiency", Range::Fraction),
        backdrive_efficiency,
        inertia: section.quantity("inertia", &units::INERTIA, Range::NonNegative),
        ratio: section.number("ratio", Range::Positive),
    }
}

fn read_effects(section: &Section, motor: Option<&Motor>, fit: &mut Fit) -> Vec<FittedEffect> {
    let mut effects = Vec::new();
    for (effect, tolerances) in EFFECTS.iter().zip(EFFECT_TOLERANCES.iter()) {
        let name = effect.name();
        if !section.has(name) {
            continue;
        }
        let instances =
            if section.is_list(name) { section.sections(name) } else { section.section(name).into_iter().collect() };
        if motor.is_some_and(|m| effect.declared(m).is_some()) {
            section.note(
                Problem::at(section.span_of(name), format!("`{name}` stands twice"), "it is a column of [motor] too")
                    .help("leave one of the two out"),
            );
        }
        for instance in instances {
            let values = read_values(&instance, *effect, tolerances, fit);
            instance.finish();
            effects.extend(values.map(|values| FittedEffect { effect: *effect, values }));
        }
    }
    effects
}

/// The values of one instance of an effect.
fn read_values(section: &Section, effect: &dyn Effect, tolerances: &[&'static str], fit: &mut Fit) -> Option<Vec<f64>> {
    // Friction and drops have no sign.
    let signed = effect.is_signed();
    let mut values = Vec::new();
    for (index, (parameter, tolerance)) in effect.parameters().iter().zip(tolerances).enumerate() {
        let range = match () {
            () if index >= effect.linear() && effect.shape() != Shape::None => Range::Positive,
            () if signed => Range::Any,
            () => Range::NonNegative,
        };
        let value = if parameter.kind.needs_unit() {
            section.required_quantity(parameter.name, parameter.kind, range)
        } else {
            if !section.has(parameter.name) {
                section.missing(parameter.name, "0.05");
            }
            section.number(parameter.name, range)
        };
        if let Some(deviation) = read_tolerance(section, tolerance, parameter.kind, value) {
            fit.tolerances.push((format!("{}.{}", effect.name(), parameter.name), deviation));
        }
        values.push(value);
    }
    values.into_iter().collect()
}

fn read_covariance(section: &Section, fit: &mut Fit) {
    let names = section.texts("names").unwrap_or_default();
    let matrix = section.matrix("matrix").unwrap_or_default();
    if matrix.len() != names.len() || matrix.iter().any(|row| row.len() != names.len()) {
        section.note(Problem::at(
            section.span_of("matrix"),
            "the covariance does not fit its names",
            format!("expected {} rows of {} numbers", names.len(), names.len()),
        ));
    }
    fit.names = names.iter().map(|n| n.get_ref().clone()).collect();
    fit.covariance = matrix;
}
