use super::{Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Shape, SimulatorField, Variable, positive, seen};
use crate::units;

/// Cogging of the motor: a torque that depends on the rotor's angle and not on current.
#[derive(Debug)]
pub struct Cogging;

impl Effect for Cogging {
    fn name(&self) -> &'static str {
        "cogging"
    }

    fn equation(&self) -> &'static str {
        "a_h cos(hθ) + b_h sin(hθ)"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "cosine", symbol: "a_h", kind: &units::TORQUE },
            Parameter { name: "sine", symbol: "b_h", kind: &units::TORQUE },
            Parameter { name: "order", symbol: "h", kind: &units::RATIO },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Angle]
    }

    fn shape(&self) -> Shape {
        Shape::Order
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        let (sine, cosine) = (shape * at.angle).sin_cos();
        [cosine, sine]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the amplitude", values[0].hypot(values[1]), scale.torque, "the largest torque on the bench")
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Ripple(values[0].hypot(values[1]))
    }

    fn export(&self, values: &[f64], _ratio: f64) -> SimulatorField {
        SimulatorField::Cogging { order: values[2], cosine: values[0], sine: values[1] }
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::SLOW_TURNS)
    }
}
