//! The declared model: `actuator = { motor, ratio, … }`, or a linear axis.

use toml::Spanned;

use crate::bench::Declared;
use gearwise_model::catalog::convention::{Commutation, CurrentConvention};
use gearwise_model::catalog::{Catalog, Gear, Motor};
use gearwise_model::effects::{EFFECTS, Effect, FittedEffect};
use gearwise_model::input::{Key, Problem, Range, Section, key, limits};
use gearwise_model::requirement::{GearModel, backdrive_efficiency};
use gearwise_model::units::{self, Kind};

/// Which column drives a linear axis, by the unit of its `force_gain`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// The force itself.
    Force,
    /// The voltage of the demand; `force_gain` in N/V.
    Voltage,
    /// The current; `force_gain` in N/A.
    Current,
    /// The duty cycle; `force_gain` in N.
    Duty,
}

/// What the columns of a log need to know of the actuator.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// The drive of a linear axis; `None` where things turn.
    pub linear: Option<Drive>,
    /// Drive force per unit of the driving column.
    pub force_gain: f64,
    /// Ratio, N.
    pub ratio: f64,
    /// Whether the motor has brushes.
    pub commutation: Commutation,
    /// The convention of the motor's row; `None` where there is no row, and the columns must say theirs.
    pub current: Option<CurrentConvention>,
    /// The declared torque constant, power invariant on the q axis \[N·m/A\]; `None` without a row.
    pub torque_constant: Option<f64>,
    /// The row is looked for: a convention that is not said is not assumed, and a table needs no time.
    pub characterize: bool,
}

impl Frame {
    /// To go on reading where the actuator could not be read.
    pub fn unknown(linear: bool) -> Frame {
        Frame {
            linear: linear.then_some(Drive::Force),
            force_gain: 1.0,
            ratio: 1.0,
            commutation: Commutation::Brushed,
            current: Some(CurrentConvention::QAxis),
            torque_constant: None,
            characterize: false,
        }
    }
}

/// For what a bench file is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// The declared model is compared with the logs: it must be there.
    Identify,
    /// A row is made from the logs: there may be none yet. How a motor without a row commutates.
    Characterize(Commutation),
}

const MASS: Key = key("mass", "of a linear axis, with which it is one");
const FORCE_GAIN: Key = key(
    "force_gain",
    "of a linear axis: drive force per unit of the column that drives it; without it the column is the force",
)
.value("force per voltage, per current or per duty, as `\"35.15 N/V\"`");
const MOTOR: Key = key("motor", "of the catalogue; not of a linear axis").value("id");
const GEAR: Key = key("gear", "of the catalogue; or its numbers").value("id or table");
const BACKDRIVE: Key =
    key("backdrive_efficiency", "when the load drives; at most 1").default("that of the gear, or 2 − 1/η");
const EFFECTS_KEY: Key =
    key("effects", "what is declared beyond the row; see [effects](effects.md)").value("table, or list of names");

/// Reads the table `actuator`.
pub fn read(section: Section, catalog: Option<&Catalog>, linear: bool, purpose: Purpose) -> Option<(Declared, Frame)> {
    let linear = linear || section.has(MASS.value("mass, as `\"95 kg\"`")) || section.has(FORCE_GAIN);
    let read = if linear { read_linear(&section) } else { read_rotary(&section, catalog, purpose) };
    section.finish();
    read
}

fn read_linear(section: &Section) -> Option<(Declared, Frame)> {
    if section.has("motor") {
        section.note(
            Problem::at(section.span_of("motor"), "a linear axis has no motor of the catalogue", "remove it")
                .help("its drive is `force_gain`, newtons per unit of the column that drives it"),
        );
    }
    let mass = section.required_quantity(MASS, &units::MASS, Range::Positive);
    let (drive, gain) = read_force_gain(section)?;
    let declared = Declared {
        motor: None,
        ratio: 1.0,
        gear: GearModel::IDEAL,
        mass,
        force_gain: gain,
        viscous_friction: section.quantity(
            key("viscous_friction", "of a linear axis"),
            &units::LINEAR_VISCOUS_FRICTION,
            Range::NonNegative,
        ),
        coulomb_friction: section.quantity(
            key("coulomb_friction", "of a linear axis"),
            &units::FORCE,
            Range::NonNegative,
        ),
        fixture_inertia: 0.0,
        effects: Vec::new(),
        without: Vec::new(),
    };
    mass?;
    Some((declared, Frame { linear: Some(drive), force_gain: gain, ..Frame::unknown(true) }))
}

fn read_force_gain(section: &Section) -> Option<(Drive, f64)> {
    const KINDS: [(Drive, &Kind); 3] = [
        (Drive::Voltage, &units::FORCE_PER_VOLTAGE),
        (Drive::Current, &units::FORCE_PER_CURRENT),
        (Drive::Duty, &units::FORCE),
    ];
    if !section.has("force_gain") {
        return Some((Drive::Force, 1.0));
    }
    let text = section.text(FORCE_GAIN)?;
    for (drive, kind) in KINDS {
        match units::quantity(text.get_ref(), kind) {
            Ok(gain) if gain > 0.0 => return Some((drive, gain)),
            Ok(_) => {
                section.note(
                    Problem::at(text.span(), "`force_gain` must be greater than zero", "expected a positive gain")
                        .help("a drive that pushes the other way is `sign = -1` of its column"),
                );
                return None;
            }
            Err(_) => {}
        }
    }
    section.note(
        Problem::at(
            text.span(),
            format!("`force_gain` cannot be `{}`", text.get_ref()),
            "expected newtons per volt, per ampere, or per full duty cycle",
        )
        .help("for example force_gain = \"35.15 N/V\", \"12 N/A\" or \"400 N\""),
    );
    None
}

/// A motor that has no row yet, alone on the bench.
pub(crate) fn without_row(commutation: Commutation) -> (Declared, Frame) {
    let declared = Declared {
        motor: None,
        ratio: 1.0,
        gear: GearModel::IDEAL,
        mass: None,
        force_gain: 1.0,
        viscous_friction: None,
        coulomb_friction: None,
        fixture_inertia: 0.0,
        effects: Vec::new(),
        without: Vec::new(),
    };
    (declared, Frame { commutation, current: None, characterize: true, ..Frame::unknown(false) })
}

fn read_rotary(section: &Section, catalog: Option<&Catalog>, purpose: Purpose) -> Option<(Declared, Frame)> {
    let nameless = matches!(purpose, Purpose::Characterize(_)) && !section.has("motor");
    let motor = if nameless {
        None
    } else {
        section.required_text(MOTOR, "\"t-motor-ri50\"").and_then(|id| find_motor(section, &id, catalog))
    };
    // `gear` is the id of a gear of the catalogue, or a table of its numbers.
    let table = if section.is_table("gear") { section.section(GEAR) } else { None };
    let gear = if table.is_none() { section.text(GEAR).map(|id| find_gear(section, &id, catalog)) } else { None };
    let listed = gear.flatten();
    let ratio = section
        .number(key("ratio", "of the gear; that of the `gear` of the catalogue, else required"), Range::Positive)
        .or(listed.map(|g| g.ratio));
    let ratio = match ratio {
        // It is the catalogue's where the bench has none.
        Some(_) => section.at_most(if section.has("ratio") { "ratio" } else { "gear" }, ratio, limits::RATIO, ""),
        None => None,
    };
    if !section.has("ratio") && (!section.has("gear") || table.is_some()) {
        section.missing("ratio", "7.5  # 1 for direct drive");
    }
    let of_table = |key, range| table.as_ref().and_then(|t| t.number(key, range));
    let efficiency = section
        .number(key("efficiency", "when the motor drives").default("that of the gear, or 1"), Range::Fraction)
        .or(of_table("efficiency", Range::Fraction))
        .or(listed.and_then(|g| g.efficiency))
        .unwrap_or(1.0);
    let backdrive = section.number(BACKDRIVE, Range::Any).or(of_table("backdrive_efficiency", Range::Any));
    if backdrive.is_some_and(|b| b > 1.0) {
        section.note(Problem::at(
            section.span_of("backdrive_efficiency"),
            "`backdrive_efficiency` is out of range",
            "expected at most 1",
        ));
    }
    let given = section.has("efficiency") || table.as_ref().is_some_and(|t| t.has("efficiency"));
    let gear = GearModel {
        efficiency,
        backdrive_efficiency: backdrive
            .or(listed.and_then(|g| g.backdrive_efficiency).filter(|_| !given))
            .unwrap_or_else(|| backdrive_efficiency(efficiency)),
        mass: listed.map_or(GearModel::IDEAL.mass, |g| g.mass),
        mass_per_stage: None,
        inertia: section
            .quantity(key("gear_inertia", "of the gear, at the input"), &units::INERTIA, Range::NonNegative)
            .or(table.as_ref().and_then(|t| t.quantity("inertia", &units::INERTIA, Range::NonNegative)))
            .or(listed.and_then(|g| g.inertia))
            .unwrap_or(0.0),
        peak_torque: listed.and_then(|g| g.peak_torque),
        continuous_torque: listed.and_then(|g| g.continuous_torque),
        max_input_speed: listed.and_then(|g| g.max_input_speed),
        says_loss: true,
        ..GearModel::IDEAL
    };
    if let Some(table) = table {
        table.finish();
    }
    let fixture_inertia = section
        .quantity(
            key("fixture_inertia", "of what is between gear and torque sensor, at the output").default("none"),
            &units::INERTIA,
            Range::NonNegative,
        )
        .unwrap_or(0.0);
    let mut effects = read_effects(section, motor);
    // A fitted actuator brings its effects along.
    let given: Vec<&'static dyn Effect> = effects.iter().map(|e| e.effect).collect();
    let own = motor.iter().flat_map(|m| &m.effects).filter(|e| !given.contains(&e.effect));
    effects.extend(own.cloned());
    let ratio = ratio?;
    if motor.is_none() && !nameless {
        return None;
    }
    let (declared, frame) = without_row(match purpose {
        Purpose::Characterize(commutation) => commutation,
        Purpose::Identify => Commutation::Brushless,
    });
    let frame = Frame {
        ratio,
        commutation: motor.map_or(frame.commutation, |m| m.conventions.commutation),
        current: motor.map(|m| m.conventions.current),
        torque_constant: motor.map(|m| m.torque_constant),
        characterize: matches!(purpose, Purpose::Characterize(_)),
        ..frame
    };
    let declared = Declared { motor: motor.cloned(), ratio, gear, fixture_inertia, effects, ..declared };
    Some((declared, frame))
}

fn find_motor<'c>(section: &Section, id: &Spanned<String>, catalog: Option<&'c Catalog>) -> Option<&'c Motor> {
    match catalog?.motor(id.get_ref()) {
        Ok(motor) => Some(motor),
        Err(near) => {
            section.note(unknown_id("motor", id, near));
            None
        }
    }
}

fn find_gear<'c>(section: &Section, id: &Spanned<String>, catalog: Option<&'c Catalog>) -> Option<&'c Gear> {
    let gears = &catalog?.gears;
    let found = gears.iter().find(|g| g.id == *id.get_ref());
    if found.is_none() {
        let near = gearwise_model::words::nearest(id.get_ref(), gears.iter().map(|g| g.id.as_str()));
        section.note(unknown_id("gear", id, near));
    }
    found
}

fn unknown_id(what: &str, id: &Spanned<String>, near: Option<&str>) -> Problem {
    let message = format!("there is no {what} `{}` in the catalogue", id.get_ref());
    let problem = Problem::at(id.span(), message, "unknown id");
    match near {
        Some(near) => problem.help(format!("did you mean `{near}`?")),
        None => problem.help("`catalog = [\"motors.csv\"]` at the top of the file says where to look"),
    }
}

/// Effects that the model has already: a list of names, whose values the motor's row declares, or a
/// table of names with their parameters.
fn read_effects(section: &Section, motor: Option<&Motor>) -> Vec<FittedEffect> {
    let mut effects = Vec::new();
    if section.has(EFFECTS_KEY) && section.is_list("effects") {
        for name in section.texts("effects").unwrap_or_default() {
            match EFFECTS.iter().find(|e| e.name() == name.get_ref()) {
                None => section.note(
                    Problem::at(name.span(), format!("unknown effect `{}`", name.get_ref()), "not in the library")
                        .suggest(name.get_ref(), EFFECTS.iter().map(|e| e.name())),
                ),
                Some(effect) => effects.extend(declared_by_row(section, *effect, &name, motor)),
            }
        }
        return effects;
    }
    if let Some(table) = section.section("effects") {
        for effect in EFFECTS {
            let Some(parameters) = table.section(effect.name()) else { continue };
            let values: Vec<Option<f64>> = effect
                .parameters()
                .iter()
                .map(|p| {
                    if p.kind.needs_unit() {
                        return parameters.required_quantity(p.name, p.kind, Range::Any);
                    }
                    if !parameters.has(p.name) {
                        parameters.missing(p.name, p.kind.example);
                    }
                    parameters.number(p.name, Range::Any)
                })
                .collect();
            parameters.finish();
            if let Some(values) = values.into_iter().collect() {
                effects.push(FittedEffect { effect: *effect, values });
            }
        }
        table.finish();
    }
    effects
}

fn declared_by_row(
    section: &Section,
    effect: &'static dyn Effect,
    name: &Spanned<String>,
    motor: Option<&Motor>,
) -> Option<FittedEffect> {
    let motor = motor?;
    let values = motor.declared(effect);
    if values.is_none() {
        let example: Vec<String> =
            effect.parameters().iter().map(|p| format!("{} = \"{}\"", p.name, p.kind.example)).collect();
        section.note(
            Problem::at(
                name.span(),
                format!("the row of `{}` does not say how large its {} is", motor.id, name.get_ref()),
                "not in the catalogue row",
            )
            .help(format!(
                "give its values: effects = {{ {} = {{ {} }} }}",
                effect.name(),
                example.join(", ")
            )),
        );
    }
    Some(FittedEffect { effect, values: values? })
}
