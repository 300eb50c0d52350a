use super::features::{Feature, ShaftForm};
use super::{Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Variable, View, positive, seen};
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

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the offset", values[0].abs(), scale.torque, "the largest torque on the bench")
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Features(ShaftForm::of(Feature::One, values[0]))
    }

    fn is_basic(&self) -> bool {
        true
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::BOTH_DIRECTIONS)
    }

    fn hidden(&self, view: &View) -> Option<&'static str> {
        view.has_free_zero.then_some("the zero of the sensor hides it")
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(60)
    }
}
