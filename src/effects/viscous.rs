use super::{Effect, Enters, Feature, Operating, Parameter, Scale, ShaftForm, SimulatorField, Variable, positive};
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
        &[Parameter { name: "coefficient", symbol: "b", kind: &units::VISCOUS_FRICTION }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.speed, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), String> {
        positive(
            "the coefficient",
            values[0],
            2.0 * scale.torque / scale.speed,
            "the largest torque over the largest speed",
        )
    }

    fn enters(&self) -> Enters {
        Enters::Convex
    }

    fn column(&self) -> Option<&'static str> {
        Some("viscous_friction")
    }

    fn shaft(&self, values: &[f64], form: &mut ShaftForm) {
        form[Feature::Velocity] += values[0];
    }

    fn export(&self, values: &[f64], ratio: f64) -> SimulatorField {
        SimulatorField::Damping(values[0] * ratio * ratio)
    }
}
