use super::{
    Doubt, Effect, Enters, Equation, Operating, Parameter, Run, Scale, Search, Shape, Variable, positive, seen,
};
use crate::units;

/// Dead time of the inverter: voltage lost in the direction of the current, `V_d sgn i`, with the sign as
/// soft as the ripple of the current makes it: `V_d tanh(i/i_0)`.
#[derive(Debug)]
pub struct InverterDeadTime;

impl Effect for InverterDeadTime {
    fn name(&self) -> &'static str {
        "inverter_dead_time"
    }

    fn equation(&self) -> &'static str {
        "V_d tanh(i/i_0)"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "voltage", symbol: "V_d", kind: &units::VOLTAGE },
            Parameter { name: "current", symbol: "i_0", kind: &units::CURRENT },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Current]
    }

    fn acts_on(&self) -> Equation {
        Equation::Voltage
    }

    fn shape(&self) -> Shape {
        Shape::Current(Search { from: 0.003, to: 0.3, starts: &[0.05] })
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        [(at.current / shape).tanh(), 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the lost voltage", values[0], 0.3 * scale.voltage, "a third of the largest voltage")
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Voltage(values[0])
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::STEPS_AT_STANDSTILL)
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(90)
    }
}
