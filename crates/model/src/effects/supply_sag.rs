use super::torque_constant_saturation::TorqueConstantSaturation;
use super::{Doubt, Effect, Enters, Equation, Mimic, Operating, Parameter, Run, Scale, Variable, View, positive, seen};
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

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the supply's resistance", values[0], 5.0 * scale.resistance, "five times the winding's resistance")
    }

    fn enters(&self, _values: &[f64]) -> Enters {
        Enters::NotAtAll("the requirement says what the bus delivers")
    }

    fn mimics(&self) -> Option<Mimic> {
        Some(Mimic { of: &TorqueConstantSaturation, run: "a log with the voltage of the supply would separate them" })
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::STEPS_AT_STANDSTILL)
    }

    fn hidden(&self, view: &View) -> Option<&'static str> {
        view.measures_supply.then_some("the voltage is measured, sag and all")
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(80)
    }
}
