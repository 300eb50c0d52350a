use super::{Doubt, Effect, Enters, Operating, Parameter, Scale, Variable, View, positive};
use crate::units;

/// Gravity of what hangs at the output, as seen at the motor: `m g l/N sin(θ_out + φ)`.
#[derive(Debug)]
pub struct Gravity;

impl Effect for Gravity {
    fn name(&self) -> &'static str {
        "gravity"
    }

    fn equation(&self) -> &'static str {
        "a sin θ_out + b cos θ_out"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "sine", symbol: "a", kind: &units::TORQUE },
            Parameter { name: "cosine", symbol: "b", kind: &units::TORQUE },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::OutputAngle]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        let (sine, cosine) = at.output_angle.sin_cos();
        [sine, cosine]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the amplitude", values[0].hypot(values[1]), scale.torque, "the largest torque on the bench")
    }

    fn is_weight(&self) -> bool {
        true
    }

    fn once_a_turn(&self) -> bool {
        true
    }

    fn enters(&self, _values: &[f64]) -> Enters {
        Enters::NotAtAll("gravity belongs to the load, not to the actuator")
    }

    fn hidden(&self, view: &View) -> Option<&'static str> {
        (!view.sees_load).then_some("the sensor sees what hangs at the output")
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(50)
    }
}
