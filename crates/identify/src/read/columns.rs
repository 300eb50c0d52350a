//! What the columns of a log mean: each becomes one channel in SI and in its canonical frame, by a gain
//! and an offset.

use std::ops::Range as Span;

use super::actuator::{Drive, Frame};
use super::remark::Remark;
use crate::bench::Channel;
use gearwise_model::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, word};
use gearwise_model::input::{Key, Problem, Range, Section, key as about};
use gearwise_model::units::{self, Kind};

/// What a column becomes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Target {
    /// The time axis.
    Time,
    /// A channel.
    Channel(Channel),
}

/// A column of a log file: cell → `gain · cell + offset`.
#[derive(Debug, Clone)]
pub struct Column {
    /// What it becomes.
    pub target: Target,
    /// Its key in the bench file.
    pub key: &'static str,
    /// Its name in the header of the log.
    pub name: String,
    /// Where the bench file names it.
    pub span: Span<usize>,
    /// SI in the canonical frame per unit of the cell.
    pub gain: f64,
    /// SI value of a cell that is zero.
    pub offset: f64,
    /// Cells are signed words of so many bits that were logged as unsigned.
    pub bits: Option<u32>,
    /// What ampere means in it, for a current.
    pub convention: Option<CurrentConvention>,
    /// Over how long a velocity is a difference \[s\], where that is said.
    pub difference: Option<f64>,
    /// ± (95 %) of its gain as a share, where that is said.
    pub gain_tolerance: Option<f64>,
    /// Whether a row's value holds until the next row, of what drives the machine.
    pub held: bool,
    /// Whether it is the driver's own estimate, made of its current, and no instrument's.
    pub estimated: bool,
    /// Whether it was measured at the motor and is brought to the output by the ratio.
    pub from_motor: bool,
    /// What was assumed.
    pub remarks: Vec<Remark>,
}

impl Column {
    /// A current as it heats rather than as it makes torque: DC between two terminals differs.
    pub fn heating(mut self, frame: &Frame) -> Column {
        if let Some(convention) = self.convention {
            let factor = convention.heating_current(frame.commutation) / convention.torque_current(frame.commutation);
            self.gain *= factor;
            self.offset *= factor;
        }
        self
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Motor,
    Output,
}

const SIDES: &[(&str, Side)] = &[("motor", Side::Motor), ("output", Side::Output)];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Time,
    Current,
    Voltage,
    Position,
    Velocity,
    Acceleration,
    Torque,
    TorqueDemand,
    TorqueEstimate,
    Force,
    Duty,
    Supply,
    BusCurrent,
    Goal,
    Command,
    WindingTemperature,
    HousingTemperature,
}

/// Every key with its quantity, and the side that the key itself says.
const KEYS: &[(&str, Quantity, Option<Side>)] = &[
    ("time", Quantity::Time, None),
    ("current", Quantity::Current, None),
    ("voltage", Quantity::Voltage, None),
    ("position", Quantity::Position, None),
    ("motor_position", Quantity::Position, Some(Side::Motor)),
    ("output_position", Quantity::Position, Some(Side::Output)),
    ("velocity", Quantity::Velocity, None),
    ("motor_velocity", Quantity::Velocity, Some(Side::Motor)),
    ("output_velocity", Quantity::Velocity, Some(Side::Output)),
    ("acceleration", Quantity::Acceleration, None),
    ("torque", Quantity::Torque, None),
    ("torque_demand", Quantity::TorqueDemand, None),
    ("torque_estimate", Quantity::TorqueEstimate, None),
    ("force", Quantity::Force, None),
    ("duty", Quantity::Duty, None),
    ("supply", Quantity::Supply, None),
    ("bus_current", Quantity::BusCurrent, None),
    ("goal", Quantity::Goal, None),
    ("command", Quantity::Command, None),
    ("temperature", Quantity::WindingTemperature, None),
    ("winding_temperature", Quantity::WindingTemperature, None),
    ("motor_temperature", Quantity::WindingTemperature, None),
    ("housing_temperature", Quantity::HousingTemperature, None),
    ("magnet_temperature", Quantity::HousingTemperature, None),
];

impl Quantity {
    fn kind(self, linear: bool) -> &'static Kind {
        match self {
            Quantity::Time => &units::TIME,
            Quantity::Current | Quantity::BusCurrent | Quantity::Command => &units::CURRENT,
            Quantity::Voltage | Quantity::Supply => &units::VOLTAGE,
            Quantity::Position | Quantity::Goal if linear => &units::LENGTH,
            Quantity::Position | Quantity::Goal => &units::ANGLE,
            Quantity::Velocity if linear => &units::LINEAR_SPEED,
            Quantity::Velocity => &units::SPEED,
            Quantity::Acceleration if linear => &units::LINEAR_ACCELERATION,
            Quantity::Acceleration => &units::ACCELERATION,
            Quantity::Torque | Quantity::TorqueDemand | Quantity::TorqueEstimate if linear => &units::FORCE,
            Quantity::Torque | Quantity::TorqueDemand | Quantity::TorqueEstimate => &units::TORQUE,
            Quantity::Force => &units::FORCE,
            Quantity::Duty => &units::RATIO,
            Quantity::WindingTemperature | Quantity::HousingTemperature => &units::TEMPERATURE,
        }
    }

    /// What its column is, in a few words.
    fn about(self) -> &'static str {
        match self {
            Quantity::Time => "time",
            Quantity::Current => "current of the motor; with `convention`",
            Quantity::Voltage => "voltage of the motor; with `convention`",
            Quantity::Position => "angle; its `side` is in the key, or said",
            Quantity::Velocity => "speed; its `side` is in the key, or said",
            Quantity::Acceleration => "acceleration; with `side`",
            Quantity::Torque => "torque sensor; with `side`",
            Quantity::TorqueDemand => {
                "torque that was demanded of the drive; taken as its current by the declared torque constant; with `side`"
            }
            Quantity::TorqueEstimate => {
                "torque that the drive says it makes, likewise: `effort` of a robot without torque sensors"
            }
            Quantity::Force => "force sensor of a linear axis",
            Quantity::Duty => "duty cycle, −1 to 1",
            Quantity::Supply => "bus voltage",
            Quantity::BusCurrent => "current drawn from the bus",
            Quantity::Goal => "goal of a servo",
            Quantity::Command => "what was asked of the driving machine, of kind `random_torque`",
            Quantity::WindingTemperature => "temperature of the winding",
            Quantity::HousingTemperature => "temperature of housing or magnets",
        }
    }

    fn has_side(self) -> bool {
        matches!(
            self,
            Quantity::Position
                | Quantity::Velocity
                | Quantity::Acceleration
                | Quantity::Torque
                | Quantity::TorqueDemand
                | Quantity::TorqueEstimate
                | Quantity::Goal
        )
    }
}

/// Reads a table of columns, and says whether all of them could be read. Two columns for one channel
/// are noted.
pub fn read(section: Section, frame: &Frame) -> (Vec<Column>, bool) {
    let mut columns: Vec<Column> = Vec::new();
    let mut complete = true;
    for (key, quantity, side) in KEYS {
        let asked = about(key, quantity.about()).value("column");
        let asked = if *quantity == Quantity::Time { asked.required() } else { asked };
        let entries =
            if section.is_list(key) { section.sections(asked) } else { section.section(asked).into_iter().collect() };
        for entry in entries {
            let span = entry.span();
            let Some(column) = read_column(entry, key, *quantity, *side, frame) else {
                complete = false;
                continue;
            };
            if let Some(first) = columns.iter().find(|c| c.target == column.target) {
                let what = if first.key == *key { format!("`{key}`") } else { format!("`{}` and `{key}`", first.key) };
                section.note(
                    Problem::at(span, format!("two columns for one channel: {what}"), "second time")
                        .help("a quantity may be given once for each side: side = \"motor\", side = \"output\""),
                );
                continue;
            }
            columns.push(column);
        }
    }
    section.finish();
    (columns, complete)
}

/// The columns of a log: its own, and those of the whole file where it has none for the channel.
pub fn merge(common: &[Column], own: Vec<Column>) -> Vec<Column> {
    let mut columns: Vec<Column> =
        common.iter().filter(|c| own.iter().all(|o| o.target != c.target)).cloned().collect();
    columns.extend(own);
    columns.sort_by_key(|c| c.target);
    columns
}

fn read_column(
    section: Section,
    key: &'static str,
    quantity: Quantity,
    side: Option<Side>,
    frame: &Frame,
) -> Option<Column> {
    let linear = frame.linear.is_some();
    let kind = quantity.kind(linear);
    let name = section.required_text(about("name", "in the header of the log"), &format!("\"{key}\""));
    let unit =
        if quantity == Quantity::Command { read_command_unit(&section, key) } else { read_unit(&section, key, kind) };
    let sign = section.number(about("sign", "of the column").value("1, -1").default("1"), Range::Any).unwrap_or(1.0);
    if sign.abs() != 1.0 {
        section.note(
            Problem::at(section.span_of("sign"), format!("`sign` of `{key}` cannot be {sign}"), "expected 1 or -1")
                .help("what a cell has to be multiplied with is `scale`"),
        );
    }
    let scale = section.number(about("scale", "factor on the column").default("1"), Range::Any).unwrap_or(1.0);
    if scale == 0.0 {
        section.note(Problem::at(
            section.span_of("scale"),
            format!("`scale` of `{key}` is zero"),
            "expected a number other than 0",
        ));
    }
    let shift = if matches!(quantity, Quantity::Position | Quantity::Goal) {
        section.quantity(about("offset", OFFSET).default("none"), kind, Range::Any).unwrap_or(0.0)
    } else {
        0.0
    };
    let bits = section.count(about("bits", "width of a counter that wraps"));
    if bits.is_some_and(|b| !(2..=32).contains(&b)) {
        section.note(Problem::at(
            section.span_of("bits"),
            format!("`bits` of `{key}` is out of range"),
            "expected the width of a word, 2 to 32",
        ));
    }
    let difference = if quantity == Quantity::Velocity {
        section.quantity(
            about("difference", "over how long it is a difference of positions, or a mean; 0 s: that of an instant"),
            &units::TIME,
            Range::NonNegative,
        )
    } else {
        None
    };
    let gain_tolerance = if quantity == Quantity::Time {
        None
    } else {
        section.quantity(
            about("gain_tolerance", "± (95 %) of the instrument's gain, for `characterize`")
                .value("share, as `\"1 %\"`"),
            &units::RATIO,
            Range::NonNegative,
        )
    };
    let mut remarks = Vec::new();
    let mut from_motor = false;
    let placed = place(&section, key, quantity, side, frame, &mut from_motor, &mut remarks);
    if from_motor {
        remarks.push(Remark::FromMotor(key));
    }
    let said = if quantity == Quantity::Current && section.has("convention") {
        section.text("convention").and_then(|t| {
            CurrentConvention::NAMES.iter().find(|(name, _)| name == t.get_ref()).map(|(_, convention)| *convention)
        })
    } else {
        None
    };
    let estimated = matches!(quantity, Quantity::Torque | Quantity::Force)
        && section.boolean(about("estimated", ESTIMATED).default("false")) == Some(true);
    let held = read_held(&section, quantity, placed.map(|(target, _)| target));
    section.finish();
    let (target, factor) = placed?;
    let (name, unit) = (name?, unit?);
    let zero = unit.to_si(0.0, kind);
    let gain = unit.scale() * scale * sign * factor;
    let span = name.span();
    let name = name.into_inner().trim().to_string();
    let convention = (quantity == Quantity::Current).then(|| said.or(frame.current)).flatten();
    Some(Column {
        target,
        key,
        name,
        span,
        gain,
        offset: (zero * sign + shift) * factor,
        bits,
        convention,
        difference,
        gain_tolerance,
        held,
        estimated,
        from_motor,
        remarks,
    })
}

const OFFSET: &str = "of an angle: added to it after `sign` and `scale`, on its own side of the gear; at angle zero a pendulum hangs down";

const ESTIMATED: &str = "whether it is the driver's own estimate, made of its current, and no sensor's";

const HELD: &str = "whether a row's value holds until the next row, as a digital drive holds a command: a current or force that was \
                    commanded has `true`, a duty of a loop much faster than the log `false`";

const UNIT: Key = about("unit", "of the cells").value("unit");

/// Whether a row's value holds until the next, of what drives the machine. A digital drive holds what it is told: a duty
/// cycle, a torque and a goal. A current or force is what an instrument read of something that goes on between the rows; where it
/// is a command, the file has to say so.
fn read_held(section: &Section, quantity: Quantity, target: Option<Target>) -> bool {
    let drives = |t| matches!(t, Target::Channel(Channel::Duty | Channel::Goal | Channel::Current));
    let told = matches!(quantity, Quantity::Duty | Quantity::Goal | Quantity::TorqueDemand);
    let said = if target.is_none_or(drives) {
        section.boolean(about("held", HELD).default(if told { "true" } else { "false" }))
    } else {
        None
    };
    said.unwrap_or(told)
}

/// What drives the other machine may be a current, a torque, a voltage or a duty cycle: only its course counts.
fn read_command_unit(section: &Section, key: &str) -> Option<units::Unit> {
    if !section.has("unit") {
        return units::unit_of("1", &units::RATIO).ok();
    }
    let text = section.text("unit")?;
    let kinds = [&units::CURRENT, &units::TORQUE, &units::VOLTAGE, &units::RATIO];
    let unit = kinds.iter().find_map(|kind| units::unit_of(text.get_ref(), kind).ok());
    if unit.is_none() {
        section.note(
            Problem::at(
                text.span(),
                format!(
                    "`unit` of `{key}`: `{}` is neither a current, a torque, a voltage nor a number",
                    text.get_ref()
                ),
                "expected the unit of what was commanded",
            )
            .help("for example unit = \"A\""),
        );
    }
    unit
}

fn read_unit(section: &Section, key: &str, kind: &'static Kind) -> Option<units::Unit> {
    let example = kind.example.split_once(' ').map_or("1", |(_, unit)| unit);
    if !section.has(if kind.needs_unit() { UNIT.required() } else { UNIT.default("a pure number") }) {
        if kind.needs_unit() {
            section.note(
                Problem::at(section.span(), format!("the column of `{key}` has no unit"), "`unit` is missing")
                    .help(format!("for example unit = \"{example}\"")),
            );
            return None;
        }
        return units::unit_of("1", kind).ok();
    }
    let text = section.text(UNIT)?;
    match units::unit_of(text.get_ref(), kind) {
        Ok(unit) => Some(unit),
        Err(error) => {
            section.note(
                Problem::at(
                    text.span(),
                    format!("`unit` of `{key}`: {}", error.message(kind)),
                    format!("expected a unit of {}", kind.name),
                )
                .help(format!("for example unit = \"{example}\"")),
            );
            None
        }
    }
}

/// The channel of a quantity and the factor to its canonical frame; `from_motor` where the ratio brings it to the output.
fn place(
    section: &Section,
    key: &'static str,
    quantity: Quantity,
    side: Option<Side>,
    frame: &Frame,
    from_motor: &mut bool,
    remarks: &mut Vec<Remark>,
) -> Option<(Target, f64)> {
    let side = read_side(section, key, quantity, side, frame, remarks)?;
    let motor = side == Side::Motor;
    let channel = |channel| Some((Target::Channel(channel), 1.0));
    // Torque grows by the ratio on its way to the output, motion shrinks.
    let mut moved = |channel, factor: f64| {
        *from_motor = motor && frame.ratio != 1.0;
        Some((Target::Channel(channel), if motor { factor } else { 1.0 }))
    };
    if let Some(drive) = frame.linear {
        return place_linear(section, key, quantity, drive, frame.force_gain);
    }
    match quantity {
        Quantity::Time => Some((Target::Time, 1.0)),
        Quantity::Current => Some((Target::Channel(Channel::Current), current_factor(section, frame, remarks)?)),
        Quantity::Voltage => Some((Target::Channel(Channel::Voltage), voltage_factor(section, frame, remarks)?)),
        Quantity::Command => channel(Channel::Command),
        Quantity::Position if motor => channel(Channel::MotorPosition),
        Quantity::Position => channel(Channel::OutputPosition),
        Quantity::Velocity if motor => channel(Channel::MotorVelocity),
        Quantity::Velocity => channel(Channel::OutputVelocity),
        Quantity::Acceleration => moved(Channel::OutputAcceleration, 1.0 / frame.ratio),
        Quantity::Goal => moved(Channel::Goal, 1.0 / frame.ratio),
        Quantity::Torque => moved(Channel::Torque, frame.ratio),
        Quantity::TorqueDemand | Quantity::TorqueEstimate => {
            let Some(torque_constant) = frame.torque_constant else {
                section.note(
                    Problem::at(
                        section.span(),
                        format!("`{key}` needs the torque constant of the motor's row"),
                        "this motor has no row",
                    )
                    .help("log its `current`"),
                );
                return None;
            };
            remarks.push(Remark::OfTorque(key));
            // What drives do: no loss of the gear is in it.
            let per_ampere = if motor { torque_constant } else { torque_constant * frame.ratio };
            Some((Target::Channel(Channel::Current), 1.0 / per_ampere))
        }
        Quantity::Force => {
            section.note(
                Problem::at(section.span(), "only a linear axis has a column `force`", "this actuator turns")
                    .help("the sensor of an actuator that turns is `torque`"),
            );
            None
        }
        Quantity::Duty => channel(Channel::Duty),
        Quantity::Supply => channel(Channel::Supply),
        Quantity::BusCurrent => channel(Channel::BusCurrent),
        Quantity::WindingTemperature => channel(Channel::WindingTemperature),
        Quantity::HousingTemperature => channel(Channel::HousingTemperature),
    }
}

/// On a linear axis the drive, whatever its unit, is the current channel; `force_gain` newtons each.
fn place_linear(
    section: &Section,
    key: &'static str,
    quantity: Quantity,
    drive: Drive,
    force_gain: f64,
) -> Option<(Target, f64)> {
    let driving = match drive {
        Drive::Force => Quantity::Force,
        Drive::Voltage => Quantity::Voltage,
        Drive::Current => Quantity::Current,
        Drive::Duty => Quantity::Duty,
    };
    let channel = match quantity {
        Quantity::Time => return Some((Target::Time, 1.0)),
        Quantity::Force => return Some((Target::Channel(Channel::Current), 1.0 / force_gain)),
        _ if quantity == driving => Channel::Current,
        Quantity::Current => {
            section.note(
                Problem::at(
                    section.span(),
                    format!("`{key}` does not drive this axis"),
                    "its force per ampere is not known",
                )
                .help("for example actuator = { mass = \"95 kg\", force_gain = \"12 N/A\" }"),
            );
            return None;
        }
        Quantity::TorqueDemand | Quantity::TorqueEstimate => {
            section.note(
                Problem::at(section.span(), format!("a linear axis has no `{key}`"), "its drive makes a force")
                    .help("what drives it is the column `force`, or the one that `force_gain` is for"),
            );
            return None;
        }
        Quantity::Voltage => Channel::Voltage,
        Quantity::Duty => Channel::Duty,
        Quantity::Position => Channel::OutputPosition,
        Quantity::Velocity => Channel::OutputVelocity,
        Quantity::Acceleration => Channel::OutputAcceleration,
        Quantity::Torque => Channel::Torque,
        Quantity::Supply => Channel::Supply,
        Quantity::BusCurrent => Channel::BusCurrent,
        Quantity::Goal => Channel::Goal,
        Quantity::Command => Channel::Command,
        Quantity::WindingTemperature => Channel::WindingTemperature,
        Quantity::HousingTemperature => Channel::HousingTemperature,
    };
    Some((Target::Channel(channel), 1.0))
}

fn read_side(
    section: &Section,
    key: &'static str,
    quantity: Quantity,
    side: Option<Side>,
    frame: &Frame,
    remarks: &mut Vec<Remark>,
) -> Option<Side> {
    let said = match side {
        Some(own) => {
            // The key says it already; saying it once more is no mistake, saying the other is.
            let again = if section.has("side") { section.choice("side", SIDES) } else { None };
            if again.is_some_and(|side| side != own) {
                section.note(
                    Problem::at(
                        section.span_of("side"),
                        format!("`{key}` is on the other side"),
                        "the key says which side",
                    )
                    .help("leave `side` out"),
                );
                return None;
            }
            Some(own)
        }
        None if quantity.has_side() => {
            let said = section.choice(about("side", "where it was measured").default("the output"), SIDES);
            if said.is_none() && section.has("side") {
                return None;
            }
            said
        }
        None => return Some(Side::Output),
    };
    if frame.linear.is_some() && said == Some(Side::Motor) {
        section.note(Problem::at(
            section.span(),
            format!("`{key}` is at the motor, but a linear axis is measured where it moves"),
            "expected side = \"output\"",
        ));
        return None;
    }
    if said.is_none() && frame.linear.is_none() && frame.ratio != 1.0 {
        remarks.push(Remark::NoSide(key));
    }
    Some(said.unwrap_or(Side::Output))
}

fn current_factor(section: &Section, frame: &Frame, remarks: &mut Vec<Remark>) -> Option<f64> {
    let said = section
        .choice(about("convention", "what ampere means").default("that of the motor's row"), CurrentConvention::NAMES);
    if frame.commutation == Commutation::Brushed {
        return Some(1.0);
    }
    let Some(convention) = said.or(frame.current) else {
        unsaid(section, "current", CurrentConvention::NAMES.iter().map(|(name, _)| *name));
        return None;
    };
    if said.is_none() {
        let word = word(CurrentConvention::NAMES, &convention);
        remarks.push(Remark::CurrentConvention(word));
    }
    Some(convention.torque_current(frame.commutation))
}

fn voltage_factor(section: &Section, frame: &Frame, remarks: &mut Vec<Remark>) -> Option<f64> {
    let said = section.choice(
        about("convention", "what the voltage is measured between").default("the q axis"),
        BackEmfConvention::NAMES,
    );
    if said.is_none() && frame.commutation == Commutation::Brushless {
        if frame.characterize {
            unsaid(section, "voltage", BackEmfConvention::NAMES.iter().map(|(name, _)| *name));
            return None;
        }
        remarks.push(Remark::VoltageConvention);
    }
    Some(said.unwrap_or(BackEmfConvention::QAxis).back_emf_constant(frame.commutation))
}

/// A row depends on the convention: it is not guessed.
fn unsaid(section: &Section, key: &str, names: impl Iterator<Item = &'static str>) {
    if section.has("convention") {
        // What stands there is noted already.
        return;
    }
    let names: Vec<&str> = names.collect();
    section.note(
        Problem::at(section.span(), format!("the column of `{key}` has no convention"), "`convention` is missing")
            .help(format!("one of {}: the row's constants depend on it", names.join(", "))),
    );
}
