//! A motor with another number of turns.
//!
//! The one idea: with the copper of a winding drawn into `a` times the turns, the same torques, powers and temperatures
//! take `a` times the voltage and one `a`-th of the current. That is the same motor in another unit of current: every
//! number of a row goes with the power of the ampere in its unit, `a^(−power)`. So K_T, K_B and voltages go with a, R and L
//! with a², currents and Kv with 1/a; K_M, inertia, heat, torques and speeds stay.
//!
//! How far that holds was looked up in fifteen frames of one maker with two to five windings each: L/K_T² agrees to 1.8 %,
//! K_M to 7 % in the median and 23 % at worst, as wires do not fill every slot alike ([`FILL`]).

use std::collections::HashSet;

use super::{Catalog, FIELDS, Motor, Offer, Wound};
use crate::units;

/// What the resistance of a winding with another number of turns may differ from the law by, relative: what of the slot
/// is copper differs between windings of one frame.
pub const FILL: f64 = 0.1;

/// Why a motor has no other number of turns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoTurns {
    /// It is only sold inside a module.
    InsideModule,
    /// Its numbers were fitted to logs of one winding.
    Fitted,
    /// It is another winding of a row already.
    Wound,
    /// Drive and leads have a resistance, which does not go with the turns: voltage and loss then depend on them otherwise.
    DriveResistance,
    /// The field is weakened: the loss of that depends on the turns.
    FieldWeakening,
    /// The supply sags: what the drive can make of it depends on power and voltage together.
    SupplyResistance,
}

impl NoTurns {
    /// What of a requirement other turns are not computed with, in a few words; `None` where the motor has no other.
    pub fn goes_without(self) -> Option<&'static str> {
        match self {
            NoTurns::InsideModule | NoTurns::Fitted | NoTurns::Wound => None,
            NoTurns::DriveResistance => Some("a resistance of drive and leads"),
            NoTurns::SupplyResistance => Some("a resistance of the supply"),
            NoTurns::FieldWeakening => Some("a weakened field or flux braking"),
        }
    }

    /// In words.
    pub fn reason(self) -> &'static str {
        match self {
            NoTurns::InsideModule => "it is only sold inside a module",
            NoTurns::Fitted => "its numbers were fitted to logs of this winding",
            NoTurns::Wound => "it is another winding of its row already",
            NoTurns::FieldWeakening => "with a current along d other turns are not computed",
            NoTurns::SupplyResistance => "with a resistance of the supply other turns are not computed",
            NoTurns::DriveResistance => "with a resistance of drive and leads other turns are not computed",
        }
    }
}

/// The winding that an id names beside a row: `row:0.5`.
fn named(id: &str) -> Option<(&str, f64)> {
    let (row, turns) = id.rsplit_once(':')?;
    Some((row, turns.parse().ok()?))
}

impl Catalog {
    /// The same with every motor that may have it wound with these multiples of its turns, next to it.
    #[must_use]
    pub fn with_turns(self, turns: &[f64]) -> Catalog {
        if turns.is_empty() { self } else { self.with_windings(|_| turns.to_vec()) }
    }

    /// The same with the windings that ids name (`row:0.5`), where `allow` says so of their turns.
    #[must_use]
    pub fn with_named<'i>(self, ids: impl Iterator<Item = &'i str>, allow: impl Fn(f64) -> bool) -> Catalog {
        let windings: Vec<(&str, f64)> = ids.filter_map(named).filter(|(_, turns)| allow(*turns)).collect();
        self.with_windings(|motor| {
            windings.iter().filter(|(row, _)| *row == motor.id).map(|(_, turns)| *turns).collect()
        })
    }

    /// The same with windings of its rows, next to them: of each with multiples of its turns. What is there already is not added,
    /// and the row itself is its own winding.
    #[must_use]
    pub fn with_windings(mut self, turns_of: impl Fn(&Motor) -> Vec<f64>) -> Catalog {
        let mut there: HashSet<String> = self.motors.iter().map(|motor| motor.id.clone()).collect();
        let all = |motor: Motor| {
            let turns = turns_of(&motor).into_iter().filter(|turns| *turns != 1.0);
            let wound = turns.filter_map(|turns| motor.rewound(turns).ok());
            let new: Vec<Motor> = wound.filter(|wound| there.insert(wound.id.clone())).collect();
            std::iter::once(motor).chain(new)
        };
        self.motors = std::mem::take(&mut self.motors).into_iter().flat_map(all).collect();
        self
    }
}

impl Motor {
    /// Id of its row, whatever its turns.
    pub fn row_id(&self) -> &str {
        self.wound.as_ref().map_or(&self.id, |wound| &wound.of)
    }

    /// Id of the machine: of the entry that was fitted or rewound. Gears that fit the one fit the other.
    pub fn machine_id(&self) -> &str {
        let fitted = self.fit.as_ref().map(|fit| match fit.entry.as_str() {
            // Files of earlier versions say it in the id alone.
            "" => self.row_id().strip_suffix("-fitted").unwrap_or(self.row_id()),
            entry => entry,
        });
        fitted.unwrap_or(self.row_id())
    }

    /// Its turns as a multiple of its row's.
    pub fn turns(&self) -> f64 {
        self.wound.as_ref().map_or(1.0, |wound| wound.turns)
    }

    /// Whether its maker may be asked for another number of turns.
    ///
    /// # Errors
    /// Why not.
    pub fn can_be_rewound(&self) -> Result<(), NoTurns> {
        match self {
            _ if !self.about.only_inside.is_empty() || self.inside.is_some() => Err(NoTurns::InsideModule),
            _ if self.wound.is_some() => Err(NoTurns::Wound),
            _ if self.fit.is_some() || !self.effects.is_empty() => Err(NoTurns::Fitted),
            _ => Ok(()),
        }
    }

    /// The motor with `turns` times its turns, by the law of this module. Its id says how many: `name:0.5`. Its resistance
    /// has a ± of [`FILL`] more than the sheet's.
    ///
    /// # Errors
    /// Why it has no other number of turns.
    pub fn rewound(&self, turns: f64) -> Result<Motor, NoTurns> {
        self.can_be_rewound()?;
        let mut motor = self.with_times_turns(turns);
        motor.id = format!("{}:{turns}", self.id);
        // The price of another winding is asked for with it.
        motor.sheet.offer = Offer::default();
        motor.wound = Some(Wound { of: self.id.clone(), turns });
        motor
            .assumptions
            .push("another number of turns than its row: R within 10 % of the law, to be asked of the maker");
        Ok(motor)
    }

    /// The numbers of the motor with so many times its turns, under its own name.
    pub fn with_times_turns(&self, turns: f64) -> Motor {
        let of = |kind: &units::Kind| turns.powf(-kind.powers_of_ampere());
        let (current, constant) = (of(&units::CURRENT), of(&units::TORQUE_CONSTANT));
        let mut motor = self.clone();
        for field in FIELDS {
            let Some(mut printed) = (field.get)(&self.sheet) else { continue };
            let factor = of(field.kind);
            printed.value *= factor;
            printed.tolerance = printed.tolerance.map(|t| t * factor);
            (field.set)(&mut motor.sheet, printed);
        }
        if let Some(resistance) = &mut motor.sheet.resistance {
            resistance.tolerance = Some(resistance.tolerance.unwrap_or(0.0) + FILL * resistance.value);
        }
        motor.resistance *= of(&units::RESISTANCE);
        motor.inductance = self.inductance.map(|l| l * of(&units::INDUCTANCE));
        motor.torque_constant *= constant;
        motor.back_emf_constant *= constant;
        motor.continuous_current = self.continuous_current.map(|i| i * current);
        motor.peak_current = self.peak_current.map(|i| i * current);
        motor.demagnetization_current = self.demagnetization_current.map(|i| i * current);
        for estimate in &mut motor.estimates {
            let factor = of(estimate.of.kind());
            estimate.value *= factor;
            estimate.middle *= factor;
        }
        motor
    }
}
