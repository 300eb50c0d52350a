//! Fitted actuators: a TOML file with a motor's row, the effects that were found in its logs, its gear and
//! where all that comes from. It stands wherever a catalogue file may stand.

use std::sync::{Arc, LazyLock};

use super::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding,
};
pub use super::fit::{Fit, FittedGear, Provenance};

use super::motor::{Identity, Incomplete, Motor};
use super::sheet::{Conventions, FIELDS, Printed, Sheet, SourceKind};
use crate::effects::{EFFECTS, Effect, FittedEffect, Shape};
use crate::input::{Form, InputError, Problem, Range, Section, Source};
use crate::units;

/// A fitted actuator.
#[derive(Debug, Clone)]
pub enum Fitted {
    /// One that turns: it stands in place of a catalogue row.
    Motor(Box<Motor>),
    /// A linear axis: it has no row.
    Axis(Box<Axis>),
}

/// A fitted linear axis: force, metre and kilogram in place of torque, radian and inertia.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Its name.
    pub id: String,
    /// What the reader should know.
    pub note: String,
    /// Moving mass \[kg\].
    pub mass: Option<Printed>,
    /// Viscous friction \[N·s/m\].
    pub viscous_friction: Option<Printed>,
    /// Coulomb friction \[N\].
    pub coulomb_friction: Option<Printed>,
    /// Effects that were found.
    pub effects: Vec<FittedEffect>,
    /// Where it comes from.
    pub fit: Fit,
}

/// A number of an SI unit as a fitted file has it: nine digits, more than any log says and few enough to read. A
/// temperature \[K\] has them in degrees Celsius. Whatever passes through here is written and read back unchanged.
///
/// ```
/// use gearwise::catalog::fitted::settled;
/// assert_eq!(settled(0.123_456_789_44, "N*m"), 0.123_456_789);
/// assert_eq!(settled(298.15, "K"), 298.15);
/// ```
pub fn settled(value: f64, si: &str) -> f64 {
    if si == "K" { settled_difference(value - 273.15) + 273.15 } else { settled_difference(value) }
}

/// The same of a difference, a tolerance or a variance, which has no zero of its own.
pub fn settled_difference(value: f64) -> f64 {
    // Adding zero takes the sign off a negative one.
    format!("{value:.8e}").parse::<f64>().unwrap_or(value) + 0.0
}

/// What a parameter of an effect measures on a linear axis.
pub fn on_axis(kind: &'static units::Kind) -> &'static units::Kind {
    const PAIRS: &[(&units::Kind, &units::Kind)] = &[
        (&units::TORQUE, &units::FORCE),
        (&units::ANGLE, &units::LENGTH),
        (&units::SPEED, &units::LINEAR_SPEED),
        (&units::INERTIA, &units::MASS),
        (&units::VISCOUS_FRICTION, &units::LINEAR_VISCOUS_FRICTION),
        (&units::TORQUE_CONSTANT, &units::FORCE_PER_CURRENT),
        (&units::TORQUE_CONSTANT_SLOPE, &units::FORCE_PER_CURRENT_SLOPE),
        (&units::COMPLIANCE, &units::LINEAR_COMPLIANCE),
    ];
    PAIRS.iter().find(|(turning, _)| *turning == kind).map_or(kind, |(_, straight)| straight)
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
/// Every mistake of the file, and a linear axis.
pub fn read_fitted(source: &Arc<Source>) -> Result<Motor, InputError> {
    Form::read(source, |root| match read_root(root)? {
        Fitted::Motor(motor) => Some(*motor),
        Fitted::Axis(_) => {
            root.note(
                Problem::at(root.span_of("axis"), "a linear axis cannot be chosen", "it has no row of a motor")
                    .help("a fitted file with a table [motor] stands in place of a row"),
            );
            None
        }
    })
}

/// Reads a fitted actuator, also that of a linear axis.
///
/// # Errors
/// Every mistake of the file.
pub fn read_actuator(source: &Arc<Source>) -> Result<Fitted, InputError> {
    Form::read(source, read_root)
}

fn read_root(root: &Section) -> Option<Fitted> {
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
    let of_axis = root.has("axis") && !root.has("motor");
    let axis = if of_axis { root.section("axis").and_then(read_axis) } else { None };
    if !of_axis && !root.has("motor") {
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
        let effects = read_effects(&section, motor.as_ref(), of_axis, &mut fit);
        section.finish();
        effects
    });
    let effects = effects.unwrap_or_default();
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
    if of_axis {
        return Some(Fitted::Axis(Box::new(Axis { effects, fit, ..axis? })));
    }
    Some(Fitted::Motor(Box::new(Motor { effects, fitted_gear: gear, fit: Some(fit), ..motor? })))
}

fn read_axis(section: Section) -> Option<Axis> {
    let number = |key, tolerance, kind, range| {
        let value = section.quantity(key, kind, range);
        let tolerance = read_tolerance(&section, tolerance, kind, value);
        value.map(|value| Printed { value, tolerance })
    };
    let text = |key| section.text(key).map(|t| t.get_ref().clone());
    let axis = Axis {
        id: text("id").unwrap_or_default(),
        note: text("note").unwrap_or_default(),
        mass: number("mass", "mass_tolerance", &units::MASS, Range::Positive),
        viscous_friction: number(
            "viscous_friction",
            "viscous_friction_tolerance",
            &units::LINEAR_VISCOUS_FRICTION,
            Range::NonNegative,
        ),
        coulomb_friction: number("coulomb_friction", "coulomb_friction_tolerance", &units::FORCE, Range::NonNegative),
        effects: Vec::new(),
        fit: Fit::default(),
    };
    section.finish();
    Some(axis)
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

fn read_effects(section: &Section, motor: Option<&Motor>, of_axis: bool, fit: &mut Fit) -> Vec<FittedEffect> {
    let mut effects = Vec::new();
    for (effect, tolerances) in EFFECTS.iter().zip(EFFECT_TOLERANCES.iter()) {
        let name = effect.name();
        if !section.has(name) {
            continue;
        }
        let instances =
            if section.is_list(name) { section.sections(name) } else { section.section(name).into_iter().collect() };
        if motor.is_some_and(|m| m.declared(*effect).is_some()) {
            section.note(
                Problem::at(section.span_of(name), format!("`{name}` stands twice"), "it is a column of [motor] too")
                    .help("leave one of the two out"),
            );
        }
        for instance in instances {
            let values = read_values(&instance, *effect, tolerances, of_axis, fit);
            instance.finish();
            effects.extend(values.map(|values| FittedEffect { effect: *effect, values }));
        }
    }
    effects
}

/// The values of one instance of an effect.
fn read_values(
    section: &Section,
    effect: &dyn Effect,
    tolerances: &[&'static str],
    of_axis: bool,
    fit: &mut Fit,
) -> Option<Vec<f64>> {
    // Friction and drops have no sign.
    let signed = effect.is_signed();
    let (mut values, mut found) = (Vec::new(), Vec::new());
    for (index, (parameter, tolerance)) in effect.parameters().iter().zip(tolerances).enumerate() {
        let range = match () {
            () if index >= effect.linear() && effect.shape() != Shape::None => Range::Positive,
            () if signed => Range::Any,
            () => Range::NonNegative,
        };
        let kind = if of_axis { on_axis(parameter.kind) } else { parameter.kind };
        let value = if kind.needs_unit() {
            section.required_quantity(parameter.name, kind, range)
        } else {
            if !section.has(parameter.name) {
                section.missing(parameter.name, "0.05");
            }
            section.number(parameter.name, range)
        };
        found.extend(read_tolerance(section, tolerance, kind, value).map(|tolerance| (parameter.name, tolerance)));
        values.push(value);
    }
    let values: Vec<f64> = values.into_iter().collect::<Option<_>>()?;
    let name = |parameter: &str| parameter_name(effect, &values, parameter);
    fit.tolerances.extend(found.into_iter().map(|(parameter, tolerance)| (name(parameter), tolerance)));
    Some(values)
}

/// The name of a parameter of an instance of an effect: `effect.parameter`, of an order `effect.order.parameter`.
pub fn parameter_name(effect: &dyn Effect, values: &[f64], parameter: &str) -> String {
    match (effect.shape(), values.last()) {
        (Shape::Order, Some(order)) => format!("{}.{order}.{parameter}", effect.name()),
        _ => format!("{}.{parameter}", effect.name()),
    }
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
