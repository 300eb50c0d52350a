use super::{Effect, Enters, Feature, Operating, Parameter, Scale, ShaftForm, Variable, positive};
use crate::units;

/// A constant torque.
#[derive(Debug)]
pub struct TorqueOffset;

impl Effect for TorqueOffset {
    fn name(&self) -> &'static str {
        "torque_offset"
    }

    fn equation(&self) -> &'static str {
        "τ_0"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "torque", symbol: "τ_0", kind: &units::TORQUE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Constant]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        let _ = at;
        [1.0, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), String> {
        positive("the offset", values[0].abs(), scale.torque, "the largest torque on the bench")
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn enters(&self) -> Enters {
        Enters::Laurent
    }

    fn shaft(&self, values: &[f64], form: &mut ShaftForm) {
        form[Feature::One] += values[0];
    }
}
