use super::{Effect, Enters, Equation, Operating, Parameter, Scale, Variable, positive, sign};
use crate::units;

/// Dead time of the inverter: voltage lost in the direction of the current, `V_d sgn i`.
#[derive(Debug)]
pub struct InverterDeadTime;

impl Effect for InverterDeadTime {
    fn name(&self) -> &'static str {
        "inverter_dead_time"
    }

    fn equation(&self) -> &'static str {
        "V_d sgn i"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "voltage", symbol: "V_d", kind: &units::VOLTAGE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Current]
    }

    fn acts_on(&self) -> Equation {
        Equation::Voltage
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [sign(at.current), 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), String> {
        positive("the lost voltage", values[0], 0.3 * scale.voltage, "a third of the largest voltage")
    }

    fn enters(&self) -> Enters {
        Enters::Bound
    }
}
