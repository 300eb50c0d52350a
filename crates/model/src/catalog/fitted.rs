//! Fitted actuators: a TOML file with a motor's row, the effects that were found in its logs, its gear and
//! where all that comes from. Use it wherever a catalogue file may be used.

use std::sync::{Arc, LazyLock};

pub use super::fit::{Fit, FittedGear, Provenance};

use super::gear::{GEAR_FIELDS, Gear};
use super::motor::Motor;
use super::row::{self, Cells, MotorRow, Row, TomlCells};
use super::sheet::{Printed, SourceKind};
use crate::effects::{EFFECTS, Effect, FittedEffect, Named, Shape};
use crate::input::kind::{self, FileKind};
use crate::input::{Description, Form, InputError, Key, Problem, Range, Section, Source, key};
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
/// use gearwise_model::catalog::fitted::settled;
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

/// `…_tolerance` of every parameter of every effect, in the order of the library.
static EFFECT_TOLERANCES: LazyLock<Vec<Vec<&'static str>>> = LazyLock::new(|| {
    let of =
        |effect: &&dyn Effect| effect.parameters().iter().map(|p| &*format!("{}_tolerance", p.name).leak()).collect();
    EFFECTS.iter().map(of).collect()
});

/// Whether a file is that of a fitted actuator: by its name.
pub(crate) fn is_fitted_file(source: &Source) -> bool {
    let toml = || {
        let kinds = [FileKind::Fitted, FileKind::Motors, FileKind::Gears, FileKind::Family];
        // A table has no such keys.
        kind::recognise(source).is_some_and(|(kind, shown)| kinds.contains(&kind) && shown.starts_with("keys"))
    };
    source.name().to_ascii_lowercase().ends_with(".toml") || source.is_stdin() && toml()
}

/// Reads a fitted actuator as a motor.
///
/// # Errors
/// Every mistake of the file, and a linear axis.
pub fn read_fitted(source: &Arc<Source>) -> Result<Motor, InputError> {
    super::read::check_version(source)?;
    Form::read(source, read_choice).map_err(|error| kind::instead(error, &[FileKind::Fitted]))
}

/// A fitted actuator as a motor that can be chosen.
pub(super) fn read_choice(root: &Section) -> Option<Motor> {
    match read_root(root)? {
        Fitted::Motor(motor) => Some(*motor),
        Fitted::Axis(_) => {
            root.note(
                Problem::at(root.span_of("axis"), "a linear axis cannot be chosen", "it has no row of a motor")
                    .help("a fitted file with a table [motor] is used in place of a row"),
            );
            None
        }
    }
}

/// Reads a fitted actuator, also that of a linear axis.
///
/// # Errors
/// Every mistake of the file.
pub fn read_actuator(source: &Arc<Source>) -> Result<Fitted, InputError> {
    Form::read(source, read_root)
}

const MOTOR: Key = key(
    "motor",
    "the columns of a motor catalogue, values with their units, `…_tolerance` too; `source` and `source_kind` may be left out",
)
.or("axis");

const AXIS: Key = key("axis", "a linear axis: it cannot be chosen").or("motor");

const EFFECTS_TABLE: Key =
    key("effects", "what was found, by name; `[[effects.cogging]]` for several orders").value("table of tables");

const SHA256: Key = key("sha256", "of the file");

const USE: Key = key("use", "what it was used for: `fit` or `held_out`");

/// What the reader asks for, but for the columns of a motor and the parameters of effects, which have lists of their own.
pub fn describe() -> [Description; 2] {
    ["gear = {}\ncovariance = {}\n[[provenance]]\nlog = 'a'\n", "axis = {}\n"]
        .map(|tables| Form::describe(tables, read_root))
}

fn read_root(root: &Section) -> Option<Fitted> {
    if !root.holds("motor") && ["joint", "log", "bus"].iter().any(|key| root.holds(key)) {
        root.note(
            Problem::whole("this is no fitted actuator: it has no table [motor]")
                .help("a requirement or a bench file is an argument of its own, not one of `--catalog`"),
        );
        return None;
    }
    let version = root
        .required_text(
            key("gearwise", "version of the program that fitted it"),
            "\"0.1.0\"  # the version that fitted it",
        )
        .map(|v| v.get_ref().clone());
    let entry = root
        .text(key("entry", "id of the catalogue entry that was fitted: its gears fit this machine"))
        .map(|v| v.get_ref().clone());
    let mut fit = Fit { version: version.unwrap_or_default(), entry: entry.unwrap_or_default(), ..Fit::default() };
    let of_axis = root.has(AXIS.value("table")) && !root.has(MOTOR.value("table"));
    let axis = if of_axis { root.section(AXIS).and_then(read_axis) } else { None };
    if !of_axis && !root.has("motor") {
        root.missing("motor", "{ id = \"…\", resistance = \"0.7 ohm\", … }");
    }
    let motor = root.section(MOTOR).and_then(|section| {
        let motor = read_motor(&section);
        section.finish();
        motor
    });
    let gear = root.section(key("gear", "numbers of the gear on the bench")).map(|section| {
        let gear = read_gear(&section, &mut fit);
        section.finish();
        gear
    });
    let effects = root.section(EFFECTS_TABLE).map(|section| {
        let effects = read_effects(&section, motor.as_ref(), of_axis, &mut fit);
        section.finish();
        effects
    });
    let effects = effects.unwrap_or_default();
    if let Some(section) = root.section(key("covariance", "of the fitted numbers")) {
        read_covariance(&section, &mut fit);
        section.finish();
    }
    for section in root.sections(key("provenance", "the logs")) {
        if let Some(log) = section.required_text(key("log", "file name"), "\"g1711.csv\"") {
            let text = |key: Key| section.text(key).map(|t| t.get_ref().clone());
            let (sha256, usage) = (text(SHA256), text(USE));
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
    let number = |name, about, tolerance, kind, range| {
        let value = section.quantity(key(name, about), kind, range);
        let tolerance = read_tolerance(&section, tolerance, kind, value);
        value.map(|value| Printed { value, tolerance })
    };
    let text = |name, about| section.text(key(name, about)).map(|t| t.get_ref().clone());
    let axis = Axis {
        id: text("id", "its name").unwrap_or_default(),
        note: text("note", "what the reader should know").unwrap_or_default(),
        mass: number("mass", "that moves", "mass_tolerance", &units::MASS, Range::Positive),
        viscous_friction: number(
            "viscous_friction",
            "per speed",
            "viscous_friction_tolerance",
            &units::LINEAR_VISCOUS_FRICTION,
            Range::NonNegative,
        ),
        coulomb_friction: number(
            "coulomb_friction",
            "while it moves",
            "coulomb_friction_tolerance",
            &units::FORCE,
            Range::NonNegative,
        ),
        effects: Vec::new(),
        fit: Fit::default(),
    };
    section.finish();
    Some(axis)
}

/// The row of `[motor]`. What a file that the program wrote says of its source may be left out.
fn read_motor(section: &Section) -> Option<Motor> {
    let blank =
        MotorRow { source: "fitted to bench logs".into(), source_kind: SourceKind::Measured, ..MotorRow::default() };
    TomlCells(section).check_names();
    row::motor(&TomlCells(section), blank, &["source", "source_kind"])
}

/// A tolerance in the unit of its number, or in per cent of it.
fn read_tolerance(
    section: &Section,
    name: &'static str,
    kind: &'static units::Kind,
    value: Option<f64>,
) -> Option<f64> {
    let (tolerance, relative) = TomlCells(section).tolerance(key(name, "±"), kind)?;
    if relative { Some(tolerance * value?.abs()) } else { Some(tolerance) }
}

/// Columns of a gear that a fitted actuator has, with that of the ± where there is one.
const GEAR_COLUMNS: &[(&str, Option<&str>)] = &[
    ("ratio", None),
    ("efficiency", Some("efficiency_tolerance")),
    ("backdrive_efficiency", Some("backdrive_efficiency_tolerance")),
    ("inertia", Some("inertia_tolerance")),
];

/// The lines of `[gear]`, with the ± of its numbers.
pub fn gear_text(fitted: &FittedGear, fit: &Fit) -> String {
    let gear = Gear {
        ratio: fitted.ratio.unwrap_or(f64::NAN),
        efficiency: fitted.efficiency,
        backdrive_efficiency: fitted.backdrive_efficiency,
        inertia: fitted.inertia,
        ..Gear::blank()
    };
    let mut out = String::new();
    for field in GEAR_FIELDS {
        let Some((name, column)) = GEAR_COLUMNS.iter().find(|(name, _)| *name == field.name) else { continue };
        if let Some(number) = (field.get)(gear.numbers()).filter(|number| number.value.is_finite()) {
            let number = Printed { tolerance: fit.tolerance(&format!("gear.{name}")), ..number };
            row::number_line(&mut out, name, *column, number, field.kind, gear.states(field));
        }
    }
    out
}

fn read_gear(section: &Section, fit: &mut Fit) -> FittedGear {
    let (cells, mut gear) = (TomlCells(section), Gear::blank());
    let column = |name: &str| GEAR_COLUMNS.iter().find(|(column, _)| *column == name);
    row::numbers(&cells, &mut gear, GEAR_FIELDS.iter().filter(|field| column(field.name).is_some()));
    row::check_gear(&cells, &gear);
    for field in GEAR_FIELDS {
        let Some((name, Some(tolerance))) = column(field.name) else { continue };
        let value = (field.get)(gear.numbers()).map(|number| number.value);
        let tolerance = read_tolerance(section, tolerance, field.kind, value);
        fit.tolerances.extend(tolerance.map(|tolerance| (format!("gear.{name}"), tolerance)));
    }
    FittedGear {
        efficiency: gear.efficiency,
        backdrive_efficiency: gear.backdrive_efficiency,
        inertia: gear.inertia,
        ratio: Some(gear.ratio).filter(|ratio| ratio.is_finite()),
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
                Problem::at(section.span_of(name), format!("duplicate `{name}`"), "it is a column of [motor] too")
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
    effect: &'static dyn Effect,
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
    let name = |parameter| Named::new(effect, values.last().copied(), parameter).to_string();
    fit.tolerances.extend(found.into_iter().map(|(parameter, tolerance)| (name(parameter), tolerance)));
    Some(values)
}

fn read_covariance(section: &Section, fit: &mut Fit) {
    let names = section.texts(key("names", "numbers of this file, in order: `motor.resistance`, `effects.eddy_drag.torque`, of an order `effects.cogging.12.cosine`")).unwrap_or_default();
    let matrix =
        section.matrix(key("matrix", "in SI; a `…_tolerance` is two square roots of its diagonal")).unwrap_or_default();
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
