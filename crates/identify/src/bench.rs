//! What a bench file says: which actuator was tested, how, and where its logs are. SI, canonical
//! frames: currents and voltages on the power-invariant q axis, torque at the output.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::PathBuf;

use gearwise_model::catalog::convention::{Commutation, Winding};
use gearwise_model::catalog::{Catalog, Motor, Sheet};
use gearwise_model::effects::{EFFECTS, Effect, FittedEffect, of_efficiency};
use gearwise_model::input::InputFile;
use gearwise_model::requirement::GearModel;

/// What kind of test a log records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum BenchKind {
    /// Torque sensor at the output; any motion.
    Dynamometer,
    /// A known inertia at the output, no torque sensor.
    Free,
    /// Terminal voltage, current and speed.
    Electrical,
    /// One row for each steady operating point, in any order.
    SteadyTable,
    /// The output is held; current in steps, torque sensor.
    Stall,
    /// Driven from outside, no current: voltage, or drag torque, against speed.
    Backdrive,
    /// Random torque command, torque and velocity.
    RandomTorque,
    /// Line-to-line readings of resistance and inductance.
    Terminals,
    /// Current (or torque) against speed without load.
    Drag,
    /// Winding and housing temperature after a step of current.
    ThermalStep,
    /// Mass and radii of the rotor.
    Rotor,
    /// Position servo: duty, position, goal and supply; no current, no torque.
    Servo,
    /// Linear axis: force, position in metres.
    Linear,
}

impl BenchKind {
    /// Every kind with its word.
    pub const NAMES: &[(&str, BenchKind)] = &[
        ("dynamometer", BenchKind::Dynamometer),
        ("free", BenchKind::Free),
        ("electrical", BenchKind::Electrical),
        ("steady_table", BenchKind::SteadyTable),
        ("stall", BenchKind::Stall),
        ("backdrive", BenchKind::Backdrive),
        ("random_torque", BenchKind::RandomTorque),
        ("terminals", BenchKind::Terminals),
        ("drag", BenchKind::Drag),
        ("thermal_step", BenchKind::ThermalStep),
        ("rotor", BenchKind::Rotor),
        ("servo", BenchKind::Servo),
        ("linear", BenchKind::Linear),
    ];

    /// Its word.
    pub fn name(self) -> &'static str {
        gearwise_model::catalog::convention::word(BenchKind::NAMES, &self)
    }
}

/// A quantity of a log in its canonical frame. On a linear axis angles are metres, torques newtons and
/// inertias kilograms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// Quadrature current, power invariant \[A\]; on a linear axis the drive force over the declared gain.
    Current,
    /// Quadrature voltage, power invariant \[V\].
    Voltage,
    /// Angle of the motor shaft \[rad\].
    MotorPosition,
    /// Speed of the motor shaft \[rad/s\].
    MotorVelocity,
    /// Angle of the output \[rad\].
    OutputPosition,
    /// Speed of the output \[rad/s\].
    OutputVelocity,
    /// Acceleration of the output \[rad/s²\].
    OutputAcceleration,
    /// Torque that the actuator delivers at the output, as the sensor has it \[N·m\].
    Torque,
    /// Duty cycle of the drive, −1 … 1.
    Duty,
    /// Supply voltage \[V\].
    Supply,
    /// Current drawn from the supply \[A\].
    BusCurrent,
    /// Goal of a position servo at the output \[rad\].
    Goal,
    /// What the driving machine was told, in whatever unit: only its course counts.
    Command,
    /// Temperature of the winding \[K\].
    WindingTemperature,
    /// Temperature of the housing (or magnets) \[K\].
    HousingTemperature,
    /// Torque that a robot asks of the joint \[N·m at the output\]: computed from its description and the motion of all joints, in
    /// no file.
    LoadTorque,
}

impl Channel {
    /// Its instrument in words.
    pub fn word(self) -> &'static str {
        match self {
            Channel::Current => "the current",
            Channel::Voltage => "the voltage",
            Channel::MotorPosition | Channel::OutputPosition => "the position",
            Channel::MotorVelocity | Channel::OutputVelocity => "the velocity",
            Channel::OutputAcceleration => "the acceleration",
            Channel::Torque => "the torque",
            Channel::Duty => "the duty",
            Channel::Supply => "the supply",
            Channel::BusCurrent => "the bus current",
            Channel::Goal => "the goal",
            Channel::Command => "the command",
            Channel::WindingTemperature => "the winding temperature",
            Channel::HousingTemperature => "the housing temperature",
            Channel::LoadTorque => "the torque of the load",
        }
    }
}

/// What a log is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// To fit and to choose effects.
    Fit,
    /// Only to judge.
    HeldOut,
}

/// What hangs at the output, known beforehand.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct KnownLoad {
    /// Inertia about the output \[kg·m²\] (mass \[kg\] on a linear axis).
    pub inertia: Option<f64>,
    /// Gravity torque amplitude `m g l` of a pendulum that hangs down at angle zero \[N·m\].
    pub gravity_torque: Option<f64>,
}

/// What a controller makes of an error of position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// A duty cycle: of a servo.
    Duty,
    /// A torque at the output, by the declared torque constant: of a drive with control of current (impedance control).
    Torque,
}

/// The controller of a servo: `duty = gain · (goal − position) − damping · speed`, within ±limit; or a torque at the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// What it makes.
    pub law: Law,
    /// Duty per angle at the output \[1/rad\], or torque per angle \[N·m/rad\].
    pub gain: f64,
    /// Duty per speed at the output \[s/rad\], or torque per speed \[N·m·s/rad\].
    pub damping: f64,
    /// Largest duty, or torque \[N·m\].
    pub limit: f64,
    /// Supply voltage where the log does not have it \[V\].
    pub supply: Option<f64>,
}

/// One log, in SI and canonical frames. Every channel has as many entries as `time`; NaN is missing.
#[derive(Debug, Clone)]
pub struct Log {
    /// File, and what was selected of it: for people, and unique in the bench.
    pub name: String,
    /// The file, as the bench file names it.
    pub file: String,
    /// SHA-256 of the file.
    pub hash: String,
    /// What it records.
    pub kind: BenchKind,
    /// What it is used for.
    pub usage: Use,
    /// What hangs at the output.
    pub load: KnownLoad,
    /// The servo's controller, where it is declared.
    pub controller: Option<Controller>,
    /// Whether the rotor was in its place; tests of inertia are also done without it.
    pub rotor: bool,
    /// Over how long its velocity is a difference of positions, or a mean \[s\]; zero for that of an instant. `None`
    /// where the bench file does not say.
    pub difference: Option<f64>,
    /// ± (95 %) of the gain of a channel's instrument, as a share, where the bench file says it.
    pub gains: BTreeMap<Channel, f64>,
    /// Channels that drive the machine and hold a row's value until the next row, as a digital drive does.
    pub held: BTreeSet<Channel>,
    /// Channels that are the driver's own estimate, not an instrument's.
    pub estimated: BTreeSet<Channel>,
    /// Stretches of time that are left out \[s\]: by the bench file, and what was found to be no data.
    pub excluded: Vec<Range<f64>>,
    /// Rows from one fresh value to the next, of channels whose driver repeats them; found, not declared.
    pub fresh: BTreeMap<Channel, f64>,
    /// Channels that were measured at the motor and brought to the output by the ratio.
    pub from_motor: BTreeSet<Channel>,
    /// Up to which frequency \[Hz\] what was computed of the motion is that of the motion; `None` where nothing was.
    pub band: Option<f64>,
    /// Time \[s\], increasing; row number for a steady table without time.
    pub time: Vec<f64>,
    /// The channels that the log has.
    pub channels: BTreeMap<Channel, Vec<f64>>,
    /// What was left out or assumed while reading, counted: "12 rows with a repeated time were left out".
    pub remarks: Vec<String>,
}

/// Whether what is known of a channel is one value; of nothing it is.
fn is_constant(values: &[f64]) -> bool {
    let mut finite = values.iter().filter(|v| v.is_finite());
    let first = finite.next();
    finite.all(|v| Some(v) == first)
}

impl Bench {
    /// Whether a channel is there and no log has it moving: an equation that explains it says nothing.
    pub fn is_dead(&self, channel: Channel) -> bool {
        let mut values = self.logs.iter().filter_map(|l| l.channel(channel)).peekable();
        values.peek().is_some() && values.all(is_constant)
    }
}

impl Log {
    /// A channel.
    pub fn channel(&self, channel: Channel) -> Option<&[f64]> {
        self.channels.get(&channel).map(Vec::as_slice)
    }

    /// Channels that have one value throughout. A supply may.
    pub fn stuck(&self) -> Vec<Channel> {
        let suspicious = |channel: Channel| !matches!(channel, Channel::Supply | Channel::LoadTorque);
        let stuck = self.channels.iter().filter(|(channel, values)| suspicious(**channel) && is_constant(values));
        stuck.map(|(channel, _)| *channel).collect()
    }

    /// Rows of each stretch that is excluded.
    pub(crate) fn excluded_rows(&self) -> impl Iterator<Item = Range<usize>> + '_ {
        let at = |time: f64| self.time.partition_point(|t| *t < time);
        self.excluded.iter().map(move |stretch| at(stretch.start)..at(stretch.end))
    }

    /// Keeps some rows only.
    pub(crate) fn keep_rows(&mut self, keep: &[bool]) {
        let chosen = |values: &[f64]| values.iter().zip(keep).filter(|(_, k)| **k).map(|(v, _)| *v).collect();
        self.time = chosen(&self.time);
        for values in self.channels.values_mut() {
            *values = chosen(values);
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }
}

/// The declared model of the actuator on the bench.
#[derive(Debug, Clone)]
pub struct Declared {
    /// The motor's row; `None` on a linear axis.
    pub motor: Option<Motor>,
    /// Ratio, N.
    pub ratio: f64,
    /// The gear: efficiency, inertia. [`GearModel::IDEAL`] where the file says nothing.
    pub gear: GearModel,
    /// Moving mass of a linear axis \[kg\].
    pub mass: Option<f64>,
    /// Drive force per unit of the current channel \[N per unit\] of a linear axis.
    pub force_gain: f64,
    /// Viscous friction of a linear axis \[N·s/m\].
    pub viscous_friction: Option<f64>,
    /// Coulomb friction of a linear axis \[N\].
    pub coulomb_friction: Option<f64>,
    /// Inertia of the bench at the output, between gear and torque sensor \[kg·m²\].
    pub fixture_inertia: f64,
    /// Further effects that the model has already.
    pub effects: Vec<FittedEffect>,
    /// Effects that are not to be asked for.
    pub without: Vec<&'static dyn Effect>,
}

impl Declared {
    /// Everything that the declared model has beyond its constants, as one list, each effect (of several orders, each order)
    /// once: what the file declares,
    /// then what columns of the motor's row or of the axis declare, then the loss of the gear.
    pub fn all_effects(&self) -> Vec<FittedEffect> {
        let own = self.effects.iter().cloned();
        let columns = EFFECTS.iter().filter_map(|e| Some(FittedEffect { effect: *e, values: self.column(*e)? }));
        let loss = of_efficiency().filter(|_| self.gear.efficiency < 1.0);
        let gear = loss.map(|effect| FittedEffect { effect, values: vec![1.0 / self.gear.efficiency - 1.0] });
        let mut found: Vec<FittedEffect> = Vec::new();
        for fitted in own.chain(columns).chain(gear) {
            if !found.iter().any(|f| f.is_same(&fitted)) {
                found.push(fitted);
            }
        }
        found
    }

    /// The values of an effect that a column declares.
    fn column(&self, effect: &dyn Effect) -> Option<Vec<f64>> {
        if let Some(motor) = &self.motor {
            return motor.declared(effect);
        }
        let value = match effect.column()? {
            "viscous_friction" => self.viscous_friction,
            "coulomb_friction" => self.coulomb_friction,
            _ => None,
        };
        value.map(|value| vec![value])
    }
}

/// Quadrature voltage per volt of duty times supply: a brushed motor, and a row that is on the q axis
/// already, take all of it.
pub(crate) fn volts_per_duty(motor: &Motor) -> f64 {
    use gearwise_model::catalog::convention::{BLOCK, CurrentConvention, Modulation};
    match (motor.conventions.commutation, motor.conventions.current) {
        (Commutation::Brushed, _) | (_, CurrentConvention::QAxis) => 1.0,
        (_, CurrentConvention::Dc) => BLOCK,
        (commutation, _) => Modulation::SpaceVector.voltage(commutation),
    }
}

/// A bench file with its logs.
#[derive(Debug, Clone)]
pub struct Bench {
    /// Name, by default the file's.
    pub name: String,
    /// The bench file.
    pub path: PathBuf,
    /// The catalogue that the declared motor comes from, for making the choice again.
    pub catalog: Catalog,
    /// The declared model.
    pub declared: Declared,
    /// The logs, in the order of the file.
    pub logs: Vec<Log>,
    /// What was read off instruments rather than recorded, and what is known of the motor beside it.
    pub readings: Readings,
    /// The files that it was read from, each with its hash: the bench file, its logs and its catalogue.
    pub files: Vec<InputFile>,
}

/// Readings of a motor that need no log.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Readings {
    /// What is known beforehand of the motor whose row is made.
    pub motor: KnownMotor,
    /// Between the terminals.
    pub terminals: Option<TerminalReadings>,
    /// Of the rotor alone.
    pub rotor: Option<RotorReadings>,
    /// Ambient temperature of the tests \[K\].
    pub ambient: Option<f64>,
}

/// What the bench file says of the motor: identity, and numbers that the tests do not give.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct KnownMotor {
    /// Id of the row.
    pub id: Option<String>,
    /// Who makes it.
    pub manufacturer: Option<String>,
    /// What its maker calls it.
    pub model: Option<String>,
    /// Brushless or brushed, where said.
    pub commutation: Option<Commutation>,
    /// Pole pairs.
    pub pole_pairs: Option<u32>,
    /// Numbers of the sheet; currents on the q axis.
    pub sheet: Sheet,
}

/// Readings between the terminals, with their ± (95 %).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TerminalReadings {
    /// How the windings are connected, where it was seen.
    pub winding: Option<Winding>,
    /// Resistance of each pair of terminals \[Ω\].
    pub resistance: Vec<f64>,
    /// The instrument's ± of a resistance \[Ω\].
    pub resistance_tolerance: Option<f64>,
    /// Inductance of each pair of terminals \[H\].
    pub inductance: Vec<f64>,
    /// The instrument's ± of an inductance \[H\].
    pub inductance_tolerance: Option<f64>,
    /// Temperature of the winding then \[K\].
    pub temperature: Option<f64>,
}

/// Mass and radii of the rotor, with their ± (95 %).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotorReadings {
    /// Mass \[kg\].
    pub mass: f64,
    /// Its ± \[kg\].
    pub mass_tolerance: f64,
    /// Radius of the thin ring \[m\].
    pub radius: f64,
    /// Its ± \[m\].
    pub radius_tolerance: f64,
}
