//! Physical effects of an actuator, one file each.
//!
//! The one idea: an effect is a set of parameters and what they add to the torque that the motor
//! shaft must supply. In the model that torque is linear in the [`Feature`]s of a sample; an effect
//! of that form says so once, in [`Effect::shaft`], and thereby serves the sweep, the ratio program
//! and the identification alike. A new effect is one file here and one line in [`EFFECTS`].

mod coulomb;
mod viscous;

pub use coulomb::CoulombFriction;
pub use viscous::ViscousFriction;

use super::shaft::{Feature, ShaftForm};
use crate::catalog::Motor;
use crate::units::Kind;

/// A parameter of an effect.
#[derive(Debug)]
pub struct Parameter {
    /// Name, also in files.
    pub name: &'static str,
    /// Symbol in the model.
    pub symbol: &'static str,
    /// What it measures.
    pub kind: &'static Kind,
    /// Smallest and largest value that is physically plausible for a robot's motor \[SI\].
    pub plausible: (f64, f64),
}

/// How an effect enters the limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Through features with even powers of N in the squares: the program stays conic.
    Convex,
    /// As a Laurent polynomial with odd powers: evaluated, certified only by branch and bound.
    Laurent,
}

/// Where a simulator keeps a parameter at the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SimulatorField {
    /// Viscous damping at the output \[N·m·s/rad\].
    Damping(f64),
    /// Friction loss at the output \[N·m\].
    FrictionLoss(f64),
}

/// A physical effect.
pub trait Effect: Sync {
    /// Name, also in files.
    fn name(&self) -> &'static str;

    /// The equation, torque at the motor.
    fn equation(&self) -> &'static str;

    /// The parameters.
    fn parameters(&self) -> &'static [Parameter];

    /// How it enters the limits.
    fn form(&self) -> Form;

    /// The values that a catalogue row declares, where it does.
    fn declared(&self, motor: &Motor) -> Option<Vec<f64>>;

    /// Adds the effect to the torque that the shaft must supply.
    fn shaft(&self, values: &[f64], form: &mut ShaftForm);

    /// `∂T/∂parameter` at a motor speed \[rad/s\], one for each parameter.
    fn regressors(&self, motor_speed: f64) -> Vec<f64>;

    /// What a simulator should be told at a ratio.
    fn export(&self, values: &[f64], ratio: f64) -> SimulatorField;
}

/// Every effect.
pub const EFFECTS: &[&dyn Effect] = &[&ViscousFriction, &CoulombFriction];

/// Adds all effects that the motor's row declares.
pub fn add_declared(motor: &Motor, form: &mut ShaftForm) {
    for effect in EFFECTS {
        if let Some(values) = effect.declared(motor) {
            effect.shaft(&values, form);
        }
    }
}

/// The value of a feature at a motor speed, for effects that depend on speed alone \[per rad/s, or 1\].
fn speed_feature(feature: Feature, motor_speed: f64) -> f64 {
    match feature {
        Feature::Velocity => motor_speed,
        Feature::Sign => super::shaft::sign(motor_speed),
        _ => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::collections::HashSet;

    #[test]
    fn the_list_is_sound() {
        let mut names = HashSet::new();
        for effect in EFFECTS {
            assert!(names.insert(effect.name()), "{} stands twice", effect.name());
            assert!(!effect.equation().is_empty() && !effect.parameters().is_empty());
            for parameter in effect.parameters() {
                assert!(parameter.plausible.0 < parameter.plausible.1, "{}", parameter.name);
            }
        }
    }

    #[test]
    fn regressors_are_the_derivatives_of_the_shaft_torque() {
        for effect in EFFECTS {
            let values: Vec<f64> = effect.parameters().iter().map(|p| (p.plausible.0 + p.plausible.1) / 2.0).collect();
            for speed in [-30.0, 12.0] {
                let torque = |values: &[f64]| {
                    let mut form = ShaftForm::default();
                    effect.shaft(values, &mut form);
                    [Feature::Velocity, Feature::Sign].iter().map(|f| form[*f] * speed_feature(*f, speed)).sum::<f64>()
                };
                for (i, regressor) in effect.regressors(speed).iter().enumerate() {
                    let (mut up, mut down) = (values.clone(), values.clone());
                    let h = 1e-3 * values[i].abs().max(1e-9);
                    up[i] += h;
                    down[i] -= h;
                    assert_relative_eq!((torque(&up) - torque(&down)) / (2.0 * h), *regressor, max_relative = 1e-6);
                }
            }
        }
    }

    #[test]
    fn friction_dissipates() {
        for effect in EFFECTS {
            let values: Vec<f64> = effect.parameters().iter().map(|p| p.plausible.1).collect();
            for speed in [-30.0, 12.0] {
                let torque: f64 = effect.regressors(speed).iter().zip(&values).map(|(r, v)| r * v).sum();
                assert!(torque * speed > 0.0, "{} makes energy", effect.name());
            }
        }
    }
}
