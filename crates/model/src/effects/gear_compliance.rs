use super::{
    Doubt, Effect, Enters, Equation, Operating, Parameter, Scale, Side, SimulatorField, Variable, View, positive,
};
use crate::units;

/// Compliance of the gear: the output lags the motor by `τ/k`; where only one side is measured, the
/// inertia on the other side needs the torque's second derivative over k.
#[derive(Debug)]
pub struct GearCompliance;

impl Effect for GearCompliance {
    fn name(&self) -> &'static str {
        "gear_compliance"
    }

    fn equation(&self) -> &'static str {
        "τ/k"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "compliance", symbol: "1/k", kind: &units::COMPLIANCE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::TorqueCurvature, Variable::Torque]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.torque_curvature, 0.0]
    }

    fn plausible(&self, values: &[f64], _scale: &Scale) -> Result<(), Doubt> {
        positive("the compliance", values[0], 10.0, "any gear")
    }

    fn enters(&self, _values: &[f64]) -> Enters {
        Enters::NotAtAll(
            "the wind-up changes where the output is, not what the motor must supply at the motion's speed",
        )
    }

    fn export(&self, values: &[f64], _ratio: f64) -> SimulatorField {
        SimulatorField::Stiffness(1.0 / values[0])
    }

    fn side(&self) -> Side {
        Side::Gear
    }

    fn hidden(&self, view: &View) -> Option<&'static str> {
        (!view.has_gear && view.equation != Equation::Angle).then_some("without a gear nothing winds up")
    }

    /// It is a term of torque, where one side alone is measured, and of the angle.
    fn winds_up(&self) -> bool {
        true
    }
}
