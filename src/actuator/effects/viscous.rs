use super::{Effect, Feature, Form, Motor, Parameter, ShaftForm, SimulatorField, speed_feature};
use crate::units;

/// Viscous friction of the motor: torque `b ω`.
#[derive(Debug)]
pub struct ViscousFriction;

impl Effect for ViscousFriction {
    fn name(&self) -> &'static str {
        "viscous_friction"
    }

    fn equation(&self) -> &'static str {
        "b ω"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "coefficient", symbol: "b", kind: &units::VISCOUS_FRICTION, plausible: (0.0, 0.1) }]
    }

    fn form(&self) -> Form {
        Form::Convex
    }

    fn declared(&self, motor: &Motor) -> Option<Vec<f64>> {
        motor.viscous_friction.map(|b| vec![b])
    }

    fn shaft(&self, values: &[f64], form: &mut ShaftForm) {
        form[Feature::Velocity] += values[0];
    }

    fn regressors(&self, motor_speed: f64) -> Vec<f64> {
        vec![speed_feature(Feature::Velocity, motor_speed)]
    }

    fn export(&self, values: &[f64], ratio: f64) -> SimulatorField {
        SimulatorField::Damping(values[0] * ratio * ratio)
    }
}
