use super::features::{Feature, ShaftForm};
use super::torque_offset::TorqueOffset;
use super::{Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Variable, positive, seen};
use crate::units;

/// Friction that differs between the directions: the half difference `(b₊ − b₋)/2` times `|ω|` beyond
/// what a constant takes up.
#[derive(Debug)]
pub struct DirectionAsymmetry;

impl Effect for DirectionAsymmetry {
    fn name(&self) -> &'static str {
        "direction_asymmetry"
    }

    fn equation(&self) -> &'static str {
        "(b₊ − b₋)/2 |ω|"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "half_difference", symbol: "(b₊ − b₋)/2", kind: &units::VISCOUS_FRICTION }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.speed.abs(), 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive(
            "the half difference",
            values[0].abs(),
            scale.torque / scale.speed,
            "the largest torque over the largest speed",
        )
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Features(ShaftForm::of(Feature::Speed, values[0]))
    }

    /// Asymmetry is what differs between directions beyond a constant.
    fn beyond(&self) -> Option<&'static dyn Effect> {
        Some(&TorqueOffset)
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::BOTH_DIRECTIONS)
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(40)
    }
}
