//! An effect with its values.

use super::features::Feature;
use super::{Effect, Enters, Operating, effect};

/// An effect of an actuator with its values.
#[derive(Clone)]
pub struct FittedEffect {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Its values in the order of its parameters, SI.
    pub values: Vec<f64>,
}

impl FittedEffect {
    /// The effect of a name with its values; `None` where the library has none of that name, or it has another
    /// number of parameters.
    pub fn new(name: &str, values: Vec<f64>) -> Option<FittedEffect> {
        effect(name).filter(|e| e.parameters().len() == values.len()).map(|effect| FittedEffect { effect, values })
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.effect.name()
    }

    /// Whether another is the same effect: of several orders, the same order.
    pub fn is_same(&self, other: &FittedEffect) -> bool {
        self.effect == other.effect && self.effect.is_same_instance(&self.values, &other.values)
    }

    /// How it enters the limits.
    pub fn enters(&self) -> Enters {
        self.effect.enters(&self.values)
    }

    /// True if it is friction that opposes motion whatever the load is: a Coulomb part, or a torque evaluated over speed.
    pub fn is_friction(&self) -> bool {
        match self.enters() {
            Enters::Features(form) => form[Feature::Sign] != 0.0,
            Enters::Evaluated(_) => true,
            _ => false,
        }
    }

    /// Derivative of its torque by the speed of the motor \[N·m·s/rad\]; the jump of a sign is left out.
    pub fn speed_slope(&self, at: &Operating) -> f64 {
        match self.enters() {
            Enters::Features(form) => form[Feature::Velocity] + form[Feature::Speed] * at.direction,
            Enters::Evaluated(slope) => slope(&self.values, at),
            _ => 0.0,
        }
    }
}

impl std::fmt::Debug for FittedEffect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {:?}", self.name(), self.values)
    }
}

impl PartialEq for FittedEffect {
    fn eq(&self, other: &FittedEffect) -> bool {
        self.name() == other.name() && self.values == other.values
    }
}
