//! Numbers that a row lacks and that are estimated: what is kept of them.

use super::about::Construction;
use super::convention::{has_words, word};
use crate::units::{self, Kind};

/// What may be estimated of a motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Estimated {
    /// Thermal resistance from winding to ambient \[K/W\].
    ThermalResistance,
    /// Rotor inertia \[kg·m²\].
    RotorInertia,
    /// Inductance on the q axis \[H\].
    Inductance,
    /// Torque that the rotor's drag takes without load \[N·m\].
    Drag,
}

impl Estimated {
    /// Every quantity with its name.
    pub const NAMES: &[(&str, Estimated)] = &[
        ("thermal_resistance", Estimated::ThermalResistance),
        ("rotor_inertia", Estimated::RotorInertia),
        ("inductance", Estimated::Inductance),
        ("no_load_torque", Estimated::Drag),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        word(Estimated::NAMES, &self)
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Estimated::ThermalResistance => "thermal resistance",
            Estimated::RotorInertia => "rotor inertia",
            Estimated::Inductance => "inductance",
            Estimated::Drag => "drag",
        }
    }

    /// What it measures.
    pub fn kind(self) -> &'static Kind {
        match self {
            Estimated::ThermalResistance => &units::THERMAL_RESISTANCE,
            Estimated::RotorInertia => &units::INERTIA,
            Estimated::Inductance => &units::INDUCTANCE,
            Estimated::Drag => &units::TORQUE,
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        self.kind().si
    }
}

has_words!(Estimated);

/// An estimated number of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// What it is of.
    pub of: Estimated,
    /// The number that the model computes with, SI: the pessimistic end of the prediction interval (one-sided, 90 %).
    pub value: f64,
    /// The middle of the interval, SI.
    pub middle: f64,
    /// Rows that it is made from.
    pub rows: usize,
    /// How they are built.
    pub construction: Construction,
}
