use super::{Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Shape, Side, Variable, View, positive, seen};
use crate::units;

/// Ripple of the gear: a torque, as seen at the motor, that depends on the output's angle.
#[derive(Debug)]
pub struct GearRipple;

impl Effect for GearRipple {
    fn name(&self) -> &'static str {
        "gear_ripple"
    }

    fn equation(&self) -> &'static str {
        "a_h cos(hθ_out) + b_h sin(hθ_out)"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "cosine", symbol: "a_h", kind: &units::TORQUE },
            Parameter { name: "sine", symbol: "b_h", kind: &units::TORQUE },
            Parameter { name: "order", symbol: "h", kind: &units::RATIO },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::OutputAngle]
    }

    fn shape(&self) -> Shape {
        Shape::Order
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        let (sine, cosine) = (shape * at.output_angle).sin_cos();
        [cosine, sine]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the amplitude", values[0].hypot(values[1]), scale.torque, "the largest torque on the bench")
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Ripple(values[0].hypot(values[1]))
    }

    fn side(&self) -> Side {
        Side::Gear
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::SLOW_TURNS)
    }

    fn hidden(&self, view: &View) -> Option<&'static str> {
        (!view.has_gear).then_some("without a gear it is cogging")
    }
}
