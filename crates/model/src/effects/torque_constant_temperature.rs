use super::{Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Variable, seen};
use crate::units;

/// Magnets lose flux with temperature: torque falls by `k (T − T_0) i`; k over the torque constant lies
/// between 0.02 and 0.25 % per kelvin.
#[derive(Debug)]
pub struct TorqueConstantTemperature;

impl Effect for TorqueConstantTemperature {
    fn name(&self) -> &'static str {
        "torque_constant_temperature"
    }

    fn equation(&self) -> &'static str {
        "k (T − T_0) i"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "slope", symbol: "k", kind: &units::TORQUE_CONSTANT_SLOPE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::HousingTemperature, Variable::Current]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.housing_rise * at.current, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        let relative = values[0] / scale.torque_constant;
        if !(0.0002..=0.0025).contains(&relative) {
            return Err(Doubt::Unnatural(format!(
                "the torque constant would change by {:+.3} %/K; magnets lose 0.02 to 0.25 %/K",
                -100.0 * relative
            )));
        }
        Ok(())
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::TorqueConstant { per_kelvin: values[0] }
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::COLD_AND_HOT)
    }
}
