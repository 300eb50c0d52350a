use super::{Effect, Feature, Form, Motor, Parameter, ShaftForm, SimulatorField, speed_feature};
use crate::units;

/// Coulomb friction of the motor: torque `c sgn ω`. Its sign is never differentiated; at standstill
/// limits see it opposing, heat does not see it (`sgn 0 = 0`).
#[derive(Debug)]
pub struct CoulombFriction;

impl Effect for CoulombFriction {
    fn name(&self) -> &'static str {
        "coulomb_friction"
    }

    fn equation(&self) -> &'static str {
        "c sgn ω"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "torque", symbol: "c", kind: &units::TORQUE, plausible: (0.0, 1.0) }]
    }

    fn form(&self) -> Form {
        Form::Laurent
    }

    fn declared(&self, motor: &Motor) -> Option<Vec<f64>> {
        motor.coulomb_friction.map(|c| vec![c])
    }

    fn shaft(&self, values: &[f64], form: &mut ShaftForm) {
        form[Feature::Sign] += values[0];
    }

    fn regressors(&self, motor_speed: f64) -> Vec<f64> {
        vec![speed_feature(Feature::Sign, motor_speed)]
    }

    fn export(&self, values: &[f64], ratio: f64) -> SimulatorField {
        SimulatorField::FrictionLoss(values[0] * ratio)
    }
}
