//! What the rotor's drag takes: bearings, hysteresis and eddy currents.
//!
//! The one idea: a sheet that prints a no-load current says one number of a torque that has two parts, one that stays
//! (Coulomb friction, hysteresis) and one that grows with speed (viscous friction, eddy currents). T_0 = K_T I_0 is their
//! sum at the no-load speed ω_0: the truth lies on the segment c + b ω_0 = T_0. Demands are convex along it, so the worst
//! of them is at one of its ends.

use super::Motor;
use super::convention::Commutation;
use super::estimate::Estimated;
use crate::effects::FittedEffect;

/// What is known of a motor's drag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drag {
    /// Coulomb friction is declared by the row or identified from logs, and enters the model by columns and effects. Friction that the logs cannot
    /// identify stays as printed.
    Declared,
    /// One torque without load, beyond viscous friction that the row declares.
    NoLoad {
        /// T_0 \[N·m\].
        torque: f64,
        /// The speed that it is told at \[rad/s\], where some of it may grow with speed: not of a brushed motor, whose
        /// brushes make the most of it (five rows that print all three numbers: c is 0.97 to 1.00 of T_0).
        speed: Option<f64>,
    },
    /// The same estimated from motors built alike, from above: it may be that or anything less.
    Estimated {
        /// T_0 \[N·m\].
        torque: f64,
    },
    /// Nothing is known of it.
    Unknown,
}

/// Friction at the shaft.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Friction {
    /// Coulomb friction \[N·m\], c.
    pub coulomb: f64,
    /// Viscous friction \[N·m·s/rad\], b.
    pub viscous: f64,
}

impl Drag {
    /// The ends between which the friction lies that the model does not have by columns and effects; one where they are the
    /// same, and none at all where nothing is known or nothing is to be added.
    pub fn ends(self) -> (Friction, Option<Friction>) {
        let none = Friction::default();
        match self {
            Drag::Declared | Drag::Unknown => (none, None),
            Drag::NoLoad { torque, speed } => {
                let viscous = speed.map(|speed| Friction { coulomb: 0.0, viscous: torque / speed });
                (Friction { coulomb: torque, viscous: 0.0 }, viscous)
            }
            Drag::Estimated { torque } => (Friction { coulomb: torque, viscous: 0.0 }, Some(none)),
        }
    }
}

impl Motor {
    /// Whether its row says a no-load current of which some may grow with speed, and not at which speed.
    pub fn lacks_speed_of_drag(&self) -> bool {
        let unsaid = self.viscous_friction.is_none() && self.conventions.commutation == Commutation::Brushless;
        unsaid && matches!(self.drag(), Drag::NoLoad { speed: None, torque } if torque > 0.0)
    }

    /// What is known of its drag.
    pub fn drag(&self) -> Drag {
        let speed = self.sheet.no_load_speed.map(|p| p.value).filter(|speed| *speed > 0.0);
        let is_brushless = self.conventions.commutation == Commutation::Brushless;
        match (self.no_load_torque, self.viscous_friction) {
            _ if self.coulomb_friction.is_some() || self.effects.iter().any(FittedEffect::is_friction) => {
                Drag::Declared
            }
            // The part that grows with speed alone says nothing of the other.
            (None, _) => Drag::Unknown,
            (Some(torque), _) if self.is_estimated(Estimated::Drag) => Drag::Estimated { torque },
            (Some(torque), Some(viscous)) => {
                let rest = torque - viscous * speed.unwrap_or(0.0);
                Drag::NoLoad { torque: rest.max(0.0), speed: None }
            }
            (Some(torque), None) => Drag::NoLoad { torque, speed: speed.filter(|_| is_brushless) },
        }
    }
}
