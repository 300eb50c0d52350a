use super::{Effect, Enters, Feature, Operating, Parameter, Scale, ShaftForm, Variable, positive};
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

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), String> {
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

    fn enters(&self) -> Enters {
        Enters::Convex
    }

    fn shaft(&self, values: &[f64], form: &mut ShaftForm) {
        form[Feature::Speed] += values[0];
    }
}
