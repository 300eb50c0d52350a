//! What a row says of its motor beyond its numbers: how it is built, and how the row belongs with others.

use super::convention::has_words;

/// How a motor is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Construction {
    /// Stator and rotor without shaft, bearings or housing.
    Frameless,
    /// An inner rotor in a housing of its own.
    Housed,
    /// An outer rotor on bearings of its own.
    Outrunner,
}

impl Construction {
    /// Every construction with the word a catalogue uses for it.
    pub const NAMES: &[(&str, Construction)] = &[
        ("frameless", Construction::Frameless),
        ("housed", Construction::Housed),
        ("outrunner", Construction::Outrunner),
    ];
}

/// What a row's peak torque is the torque of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeakTorqueOf {
    /// Of the motor by itself: what it is less than K_T I_peak is saturation of its iron.
    Motor,
    /// Of a module, with the losses of its gear in it.
    Module,
}

impl PeakTorqueOf {
    /// Both with the word that a catalogue uses for them.
    pub const NAMES: &[(&str, PeakTorqueOf)] = &[("motor", PeakTorqueOf::Motor), ("module", PeakTorqueOf::Module)];
}

has_words!(Construction, PeakTorqueOf);

/// What a row says of its motor beyond its numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct About {
    /// How it is built; `None` where the row does not say.
    pub construction: Option<Construction>,
    /// What its peak torque is the torque of; `None` where the row does not say.
    pub peak_torque_of: Option<PeakTorqueOf>,
    /// The module that it is only sold in; empty where it can be bought alone.
    pub only_inside: String,
    /// The id of another row of the same motor, which counts where both have a value; empty where there is none.
    pub same_as: String,
}
