use super::{Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Shape, Variable, positive, seen};
use crate::units;

/// Ripple of the motor's torque: depends on the rotor's angle, proportional to current.
#[derive(Debug)]
pub struct TorqueRipple;

impl Effect for TorqueRipple {
    fn name(&self) -> &'static str {
        "torque_ripple"
    }

    fn equation(&self) -> &'static str {
        "i (a_h cos(hθ) + b_h sin(hθ))"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "cosine", symbol: "a_h", kind: &units::TORQUE_CONSTANT },
            Parameter { name: "sine", symbol: "b_h", kind: &units::TORQUE_CONSTANT },
            Parameter { name: "order", symbol: "h", kind: &units::RATIO },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Angle, Variable::Current]
    }

    fn shape(&self) -> Shape {
        Shape::Order
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        let (sine, cosine) = (shape * at.angle).sin_cos();
        [at.current * cosine, at.current * sine]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive(
            "the amplitude",
            values[0].hypot(values[1]),
            0.5 * scale.torque_constant,
            "half of the torque constant",
        )
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::RippleOfCurrent(values[0].hypot(values[1]))
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::SLOW_TURNS)
    }
}
