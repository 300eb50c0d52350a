use super::coulomb::CoulombFriction;
use super::{
    Doubt, Effect, Enters, Operating, Parameter, Run, Scale, Search, Shape, Side, SimulatorField, Variable, positive,
    seen,
};
use crate::units;

/// Stribeck friction of the motor: what is added to Coulomb friction at low speed, `c_s exp(−(ω/ω_s)²) sgn ω`.
#[derive(Debug)]
pub struct StribeckFriction;

impl Effect for StribeckFriction {
    fn name(&self) -> &'static str {
        "stribeck_friction"
    }

    fn title(&self) -> String {
        "Stribeck friction".into()
    }

    fn equation(&self) -> &'static str {
        "c_s exp(−(ω/ω_s)²) sgn ω"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "torque", symbol: "c_s", kind: &units::TORQUE },
            Parameter { name: "speed", symbol: "ω_s", kind: &units::SPEED },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed]
    }

    fn shape(&self) -> Shape {
        Shape::Speed(Search { from: 0.008, to: 0.24, starts: &[0.03, 0.1] })
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        [(-(at.speed / shape).powi(2)).exp() * at.direction, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the friction torque", values[0], scale.torque, "the largest torque on the bench")?;
        positive("the Stribeck speed", values[1], 0.25 * scale.speed, "a quarter of the largest speed")
    }

    fn drifts_with_band(&self) -> bool {
        true
    }

    fn enters(&self, _values: &[f64]) -> Enters {
        Enters::Evaluated(|values, at| -2.0 * at.speed / values[1].powi(2) * StribeckFriction.value(values, at))
    }

    fn export(&self, values: &[f64], ratio: f64) -> SimulatorField {
        SimulatorField::FrictionAtRest(values[0] * ratio)
    }

    fn side(&self) -> Side {
        Side::Either
    }

    fn beyond(&self) -> Option<&'static dyn Effect> {
        Some(&CoulombFriction)
    }

    fn separated_by(&self) -> Option<Run> {
        Some(seen::SLOW_RUN)
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(30)
    }
}
