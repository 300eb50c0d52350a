use super::{Doubt, Effect, Enters, Equation, Operating, Parameter, Run, Scale, Variable, seen};
use crate::units;

/// Copper resistance rises with temperature: voltage `r (T − T_0) i`; r over the resistance is 0.39 % per
/// kelvin.
#[derive(Debug)]
pub struct WindingTemperature;

impl Effect for WindingTemperature {
    fn name(&self) -> &'static str {
        "winding_temperature"
    }

    fn equation(&self) -> &'static str {
        "r (T − T_0) i"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "slope", symbol: "r", kind: &units::RESISTANCE_SLOPE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::WindingTemperature, Variable::Current]
    }

    fn acts_on(&self) -> Equation {
        Equation::Voltage
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.winding_rise * at.current, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        let relative = values[0] / scale.resistance;
        if !(0.0025..=0.0055).contains(&relative) {
            return Err(Doubt::Unnatural(format!(
                "the resistance would change by {:+.3} %/K; copper has +0.39 %/K",
                100.0 * relative
            )));
        }
        Ok(())
    }

    fn enters(&self, _values: &[f64]) -> Enters {
        Enters::NotAtAll("the model has the resistance of hot copper already")
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::COLD_AND_HOT)
    }
}
