use super::{Effect, Enters, Equation, Operating, Parameter, Scale, Variable, positive};
use crate::units;

/// The supply sags with the current drawn from it: voltage `R_s d² i` at the motor for duty d.
#[derive(Debug)]
pub struct SupplySag;

impl Effect for SupplySag {
    fn name(&self) -> &'static str {
        "supply_sag"
    }

    fn equation(&self) -> &'static str {
        "R_s d² i"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "resistance", symbol: "R_s", kind: &units::RESISTANCE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Duty, Variable::Current]
    }

    fn acts_on(&self) -> Equation {
        Equation::Voltage
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.duty * at.duty * at.current, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), String> {
        positive("the supply's resistance", values[0], 5.0 * scale.resistance, "five times the winding's resistance")
    }

    fn enters(&self) -> Enters {
        Enters::NotAtAll("the requirement says what the bus delivers")
    }
}
