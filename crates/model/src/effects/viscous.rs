use super::features::{Feature, ShaftForm};
use super::{Doubt, Effect, Enters, Operating, Parameter, Scale, Side, SimulatorField, Variable, View, positive};
use crate::units;

/// Viscous friction of the motor: torque `b ω`.
#[derive(Debug)]
pub struct ViscousFriction;

impl Effect for ViscousFriction {
    fn name(&self) -> &'static str {
        "viscous_friction"
    }

    fn equation(&self) -> &'static str {
        "b ω"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "coefficient", symbol: "b", kind: &units::VISCOUS_FRICTION }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.speed, 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive(
            "the coefficient",
            values[0],
            2.0 * scale.torque / scale.speed,
            "the largest torque over the largest speed",
        )
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Features(ShaftForm::of(Feature::Velocity, values[0]))
    }

    fn column(&self) -> Option<&'static str> {
        Some("viscous_friction")
    }

    fn export(&self, values: &[f64], ratio: f64) -> SimulatorField {
        SimulatorField::Damping(values[0] * ratio * ratio)
    }

    fn side(&self) -> Side {
        Side::Either
    }

    fn is_basic(&self) -> bool {
        true
    }

    fn hidden(&self, view: &View) -> Option<&'static str> {
        view.fits_damping.then_some("with duty alone it cannot be separated from the back-EMF: both are in `damping`")
    }

    fn is_damping(&self) -> bool {
        true
    }
}
