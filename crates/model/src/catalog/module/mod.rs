//! Modules: motor, gear and mostly a drive, bought as one.
//!
//! The one idea: a module is *a motor whose shaft is the output flange*. Every number of it keeps the side and the convention
//! that its own column declares; [`constants`] takes them to the flange and the q axis once.

mod actuator;
pub mod audit;
pub mod check;
pub mod constants;
pub mod inside;
pub mod overload;
mod sheet;

pub use inside::{BUILT_IN, Depth, Inside, Published};
pub use sheet::{MODULE_FIELDS, ModuleSheet};

use super::convention::{BackEmfConvention, CurrentConvention, SpeedConstantConvention, Terminals, Winding, has_words};
use super::gear::GearKind;
use super::row::Side;
use super::sheet::SourceKind;

/// Where the drive of a module is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// In it: its mass and losses are the module's.
    BuiltIn,
    /// Beside it.
    External,
}

impl Drive {
    /// Both with the word that a catalogue uses for them.
    pub const NAMES: &[(&str, Drive)] = &[("built_in", Drive::BuiltIn), ("external", Drive::External)];
}

/// What a torque constant is that the gear stands in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TorqueLoss {
    /// N K_T: without the gear's loss.
    Nominal,
    /// What arrives at the flange per ampere.
    Measured,
}

impl TorqueLoss {
    /// Both with the word that a catalogue uses for them.
    pub const NAMES: &[(&str, TorqueLoss)] = &[("nominal", TorqueLoss::Nominal), ("measured", TorqueLoss::Measured)];
}

/// What a rated power is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RatedPower {
    /// At the flange.
    Mechanical,
    /// From the supply.
    Electrical,
}

impl RatedPower {
    /// Both with the word that a catalogue uses for them.
    pub const NAMES: &[(&str, RatedPower)] =
        &[("mechanical", RatedPower::Mechanical), ("electrical", RatedPower::Electrical)];
}

/// What a current without load is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoLoadCurrent {
    /// Of the winding, in a convention.
    Winding(CurrentConvention),
    /// From the supply, with what the drive itself takes.
    Supply,
}

impl NoLoadCurrent {
    /// All with the word that a catalogue uses for them.
    pub const NAMES: &[(&str, NoLoadCurrent)] = &[
        ("rms", NoLoadCurrent::Winding(CurrentConvention::Rms)),
        ("phase_amplitude", NoLoadCurrent::Winding(CurrentConvention::PhaseAmplitude)),
        ("dc", NoLoadCurrent::Winding(CurrentConvention::Dc)),
        ("q_axis", NoLoadCurrent::Winding(CurrentConvention::QAxis)),
        ("supply", NoLoadCurrent::Supply),
    ];
}

impl Side {
    /// Both with their words.
    pub const NAMES: &[(&str, Side)] = &[("motor", Side::Motor), ("output", Side::Output)];
}

has_words!(Drive, TorqueLoss, RatedPower, NoLoadCurrent);

/// What the numbers of a module refer to: each column says it of itself.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Refers {
    /// Side of `armature`.
    pub armature_side: Option<Side>,
    /// Side of the friction columns.
    pub friction_side: Option<Side>,
    /// Ampere of the torque constant.
    pub torque_constant_current: Option<CurrentConvention>,
    /// Side of the torque constant.
    pub torque_constant_side: Option<Side>,
    /// Whether the gear's loss is in it.
    pub torque_constant_loss: Option<TorqueLoss>,
    /// What the back-EMF constant is measured between.
    pub back_emf_convention: Option<BackEmfConvention>,
    /// Side of the back-EMF constant.
    pub back_emf_side: Option<Side>,
    /// What voltage the speed constant refers to.
    pub speed_constant_convention: Option<SpeedConstantConvention>,
    /// Side of the speed constant.
    pub speed_constant_side: Option<Side>,
    /// Between what resistance and inductance are.
    pub terminals: Option<Terminals>,
    /// How the windings are connected.
    pub winding: Option<Winding>,
    /// Ampere of the rated and the peak current.
    pub current: Option<CurrentConvention>,
    /// What the rated power is.
    pub rated_power_is: Option<RatedPower>,
    /// What the current without load is.
    pub no_load_current_is: Option<NoLoadCurrent>,
}

/// Points of a curve or of a table: SI.
pub type Points = Vec<[f64; 2]>;

/// A row of the catalogue of modules, as printed: numbers in SI, in the conventions and at the sides that it declares.
#[derive(Debug, Clone, PartialEq)]
pub struct Module {
    /// Unique name.
    pub id: String,
    /// Who makes it.
    pub manufacturer: String,
    /// What its maker calls it.
    pub model: String,
    /// Rows of one maker that share a motor or a gear.
    pub family: String,
    /// Version of the hardware or of the sheet.
    pub version: String,
    /// How its gear reduces; `None` where the source does not say.
    pub kind: Option<GearKind>,
    /// Where its drive is.
    pub drive: Drive,
    /// Id of the motor row inside; empty where there is none.
    pub motor: String,
    /// Id of the gear row inside; empty where there is none.
    pub gear: String,
    /// What its numbers refer to.
    pub refers: Refers,
    /// Pole pairs of the motor.
    pub pole_pairs: Option<u32>,
    /// Bits of the encoder at the motor.
    pub encoder_bits_motor: Option<u32>,
    /// Bits of the encoder at the output.
    pub encoder_bits_output: Option<u32>,
    /// How it is talked to.
    pub bus: String,
    /// The heat sink of the overload test.
    pub heat_sink: String,
    /// Largest torque over speed while it drives \[rad/s, N·m\].
    pub driving_curve: Points,
    /// The same against the speed.
    pub braking_curve: Points,
    /// Longest time of a constant torque from ambient \[N·m, s\].
    pub overload: Points,
    /// The same at standstill.
    pub overload_stall: Points,
    /// The numbers.
    pub sheet: ModuleSheet,
    /// Where the numbers come from.
    pub source: String,
    /// Its day, or that on which it was opened.
    pub source_date: String,
    /// What kind of source that is.
    pub source_kind: SourceKind,
    /// Audit findings that the note explains, by code.
    pub accepted_findings: Vec<String>,
    /// What the reader of the row should know.
    pub note: String,
}

impl Default for Module {
    /// A blank row.
    fn default() -> Module {
        Module {
            id: String::new(),
            manufacturer: String::new(),
            model: String::new(),
            family: String::new(),
            version: String::new(),
            kind: None,
            drive: Drive::BuiltIn,
            motor: String::new(),
            gear: String::new(),
            refers: Refers::default(),
            pole_pairs: None,
            encoder_bits_motor: None,
            encoder_bits_output: None,
            bus: String::new(),
            heat_sink: String::new(),
            driving_curve: Points::new(),
            braking_curve: Points::new(),
            overload: Points::new(),
            overload_stall: Points::new(),
            sheet: ModuleSheet::default(),
            source: String::new(),
            source_date: String::new(),
            source_kind: SourceKind::Datasheet,
            accepted_findings: Vec::new(),
            note: String::new(),
        }
    }
}

/// A curve at a speed \[rad/s\]: straight between its points, nothing behind the last.
pub fn on_curve(curve: &[[f64; 2]], speed: f64) -> f64 {
    let behind = curve.iter().position(|point| point[0] >= speed);
    match behind {
        Some(0) => curve[0][1],
        Some(k) => {
            let ([a, low], [b, high]) = (curve[k - 1], curve[k]);
            low + (high - low) * (speed - a) / (b - a)
        }
        None => 0.0,
    }
}

impl Module {
    /// The speed at which its driving curve ends without torque \[rad/s\]; `None` where it does not.
    pub fn end_of_curve(&self) -> Option<f64> {
        self.driving_curve.last().filter(|point| point[1] == 0.0).map(|point| point[0])
    }

    /// Its speed without load at the voltage of its row \[rad/s\]: printed, or where its curve ends.
    pub fn no_load_speed(&self) -> Option<f64> {
        self.sheet.no_load_speed.map(|p| p.value).or_else(|| self.end_of_curve())
    }

    /// Its speed without load at a bus voltage \[rad/s\]: less voltage has less speed, more has no more than is printed.
    pub fn no_load_speed_at(&self, volt: f64) -> Option<f64> {
        Some(self.no_load_speed()? - self.speed_lost(volt)?)
    }

    /// What a bus voltage takes from the speed without load of its row \[rad/s\]: nothing where it is not less than the row's; `None` where
    /// it is and nobody knows that speed.
    pub fn speed_lost(&self, volt: f64) -> Option<f64> {
        match self.sheet.voltage {
            Some(printed) if volt < printed.value => Some(self.no_load_speed()? * (1.0 - volt / printed.value)),
            _ => Some(0.0),
        }
    }

    /// The largest torque of its driving curve \[N·m\].
    pub fn largest_of_curve(&self) -> Option<f64> {
        self.driving_curve.iter().map(|point| point[1]).reduce(f64::max)
    }

    /// The largest torque that its row lets it give \[N·m\]: of its peak and its curve the smaller, else that at standstill.
    pub fn largest_torque(&self) -> Option<f64> {
        let value = |p: Option<crate::catalog::Printed>| p.map(|p| p.value);
        let both = value(self.sheet.peak_torque).into_iter().chain(self.largest_of_curve());
        both.reduce(f64::min).or(value(self.sheet.stall_torque))
    }

    /// The speed up to which its driving curve gives a torque at a bus voltage \[rad/s\], zero where it nowhere does; `None`
    /// where it has no curve, or where nobody knows what less voltage leaves of it.
    pub fn speed_at_torque(&self, torque: f64, volt: f64) -> Option<f64> {
        let lost = self.speed_lost(volt)?;
        let last = self.driving_curve.iter().rposition(|point| point[1] >= torque);
        let speed = match last {
            None if self.driving_curve.is_empty() => return None,
            None => 0.0,
            Some(k) => {
                let [speed, above] = self.driving_curve[k];
                let behind = self.driving_curve.get(k + 1);
                speed + behind.map_or(0.0, |[next, below]| (next - speed) * (above - torque) / (above - below))
            }
        };
        Some((speed - lost).max(0.0))
    }

    /// Reduction of its gear, N.
    pub fn ratio(&self) -> f64 {
        self.sheet.ratio.map_or(f64::NAN, |printed| printed.value)
    }
}
