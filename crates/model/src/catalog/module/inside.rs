//! What is inside a module, and how much its row says of it.

use super::Module;
use super::constants::EfficiencyFrom;
use super::overload::Response;
use crate::catalog::alternative::Alternative;
use crate::catalog::finding::Finding;
use crate::catalog::gear::Gear;

/// Id that the gear of a module has in answers, where it is no row of its own.
pub const BUILT_IN: &str = "its own gear";

/// How much a module's row says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Depth {
    /// Torques, speeds, masses: nothing of currents, voltages and losses.
    Ratings,
    /// Its constants too.
    Constants,
    /// Motor and gear are rows of the catalogue.
    Inside,
}

/// The ends of what sources say of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Published {
    /// Its column: of the motor's sheet, or of the module's.
    pub column: &'static str,
    /// Whether it is a rating of the module.
    pub is_rating: bool,
    /// The least and the largest, SI.
    pub ends: [f64; 2],
}

/// What is inside a module.
#[derive(Debug, Clone)]
pub struct Inside {
    /// Its row.
    pub module: Module,
    /// The gear.
    pub gear: Gear,
    /// How much the row says.
    pub depth: Depth,
    /// Whether its own inertia is known.
    pub says_inertia: bool,
    /// Whether its back-EMF constant is known.
    pub says_back_emf: bool,
    /// How the loss of its gear is known; `None` where it is not.
    pub gear_loss: Option<EfficiencyFrom>,
    /// Whether torque per ampere has the gear's loss in it.
    pub loss_in_constant: bool,
    /// How its winding answers to torque, from the overload table.
    pub response: Option<Response>,
    /// What the audit finds in its row.
    pub findings: Vec<Finding>,
    /// What other sources say of its numbers.
    pub alternatives: Vec<Alternative>,
    /// Ends of what all sources say, where they are asked for.
    pub published: Vec<Published>,
}

impl Inside {
    /// Whether currents, and what follows of them, are known.
    pub fn says_currents(&self) -> bool {
        self.depth != Depth::Ratings
    }

    /// Whether what it loses is known: currents, and what its gear takes.
    pub fn says_loss(&self) -> bool {
        self.says_currents() && (self.gear_loss.is_some() || self.loss_in_constant)
    }

    /// Whether power and voltage are known with all that is lost.
    pub fn says_whole_power(&self) -> bool {
        self.says_power() && self.says_loss()
    }

    /// Whether power and voltage are known too.
    pub fn says_power(&self) -> bool {
        self.says_currents() && self.says_back_emf
    }
}

impl Module {
    /// How much the row says.
    pub fn depth(&self) -> Depth {
        let constants = self.constants();
        match () {
            () if !self.motor.is_empty() && !self.gear.is_empty() => Depth::Inside,
            () if constants.resistance.is_some() && constants.torque_constant.is_some() => Depth::Constants,
            () => Depth::Ratings,
        }
    }
}
