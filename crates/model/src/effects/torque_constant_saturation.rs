use super::{Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Search, Shape, Variable, positive, seen};
use crate::units;

/// Saturation of the iron: torque falls short at high current, `k (i − i_s tanh(i/i_s))` with k near the
/// torque constant.
#[derive(Debug)]
pub struct TorqueConstantSaturation;

impl Effect for TorqueConstantSaturation {
    fn name(&self) -> &'static str {
        "torque_constant_saturation"
    }

    fn equation(&self) -> &'static str {
        "k (i − i_s tanh(i/i_s))"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "slope", symbol: "k", kind: &units::TORQUE_CONSTANT },
            Parameter { name: "current", symbol: "i_s", kind: &units::CURRENT },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Current]
    }

    fn shape(&self) -> Shape {
        Shape::Current(Search { from: 0.25, to: 4.0, starts: &[0.5] })
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        [at.current - shape * (at.current / shape).tanh(), 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the slope", values[0], 1.5 * scale.torque_constant, "the torque constant")?;
        if values[0] < 0.3 * scale.torque_constant || values[1] < 0.25 * scale.current {
            return Err(Doubt::Unnatural(format!(
                "torque would fall short by {:.3e} N*m/A beyond {:.3e} A: no iron saturates like that",
                values[0], values[1]
            )));
        }
        positive("the saturation current", values[1], 10.0 * scale.current, "ten times the largest current")
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Saturation { slope: values[0], current: values[1] }
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::CURRENT_STEPS)
    }

    fn is_of_torque_constant(&self) -> bool {
        true
    }
}
