use super::{Effect, Enters, Operating, Parameter, Scale, Shape, Variable, positive};
use crate::units;

/// Stribeck friction of the motor: what is added to Coulomb friction at low speed, `c_s exp(−(ω/ω_s)²) sgn ω`.
#[derive(Debug)]
pub struct StribeckFriction;

impl Effect for StribeckFriction {
    fn name(&self) -> &'static str {
        "stribeck_friction"
    }

    fn equation(&self) -> &'static str {
        "c_s exp(−(ω/ω_s)²) sgn ω"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "torque", symbol: "c_s", kind: &units::TORQUE },
            Parameter { name: "speed", symbol: "ω_s", kind: &units::SPEED },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed]
    }

    fn shape(&self) -> Shape {
        Shape::Speed
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        [(-(at.speed / shape).powi(2)).exp() * at.direction, 0.0]
    }

    fn speed_slope(&self, values: &[f64], at: &Operating) -> f64 {
        -2.0 * at.speed / values[1].powi(2) * self.value(values, at)
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), String> {
        positive("the friction torque", values[0], scale.torque, "the largest torque on the bench")?;
        positive("the Stribeck speed", values[1], 0.25 * scale.speed, "a quarter of the largest speed")
    }

    fn enters(&self) -> Enters {
        Enters::Evaluated
    }
}
