use super::features::{Feature, ShaftForm};
use super::{Doubt, Effect, Enters, Operating, Parameter, Scale, Side, SimulatorField, Variable, positive};
use crate::units;

/// Coulomb friction of the motor: torque `c sgn ω`. Its sign is never differentiated; at standstill
/// limits see it opposing, heat does not see it (`sgn 0 = 0`).
#[derive(Debug)]
pub struct CoulombFriction;

impl Effect for CoulombFriction {
    fn name(&self) -> &'static str {
        "coulomb_friction"
    }

    fn title(&self) -> String {
        "Coulomb friction".into()
    }

    fn equation(&self) -> &'static str {
        "c sgn ω"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "torque", symbol: "c", kind: &units::TORQUE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.direction, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the friction torque", values[0], scale.torque, "the largest torque on the bench")
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Features(ShaftForm::of(Feature::Sign, values[0]))
    }

    fn column(&self) -> Option<&'static str> {
        Some("coulomb_friction")
    }

    fn export(&self, values: &[f64], ratio: f64) -> SimulatorField {
        SimulatorField::FrictionLoss(values[0] * ratio)
    }

    fn side(&self) -> Side {
        Side::Either
    }

    fn is_basic(&self) -> bool {
        true
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(10)
    }
}
