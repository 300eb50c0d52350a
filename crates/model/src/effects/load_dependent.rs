use super::coulomb::CoulombFriction;
use super::{Doubt, Effect, Enters, Mimic, Operating, Parameter, Scale, Side, SimulatorField, Variable, positive};
use crate::units;

/// Friction of the gear that grows with the transmitted torque: `γ |τ/N| sgn ω` at the motor. It *is* the
/// gear's loss: `η = 1/(1 + γ)`.
#[derive(Debug)]
pub struct LoadDependentFriction;

impl Effect for LoadDependentFriction {
    fn name(&self) -> &'static str {
        "load_dependent_friction"
    }

    fn equation(&self) -> &'static str {
        "γ |τ/N| sgn ω"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "factor", symbol: "γ", kind: &units::RATIO }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed, Variable::Torque]
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [at.torque.abs() * at.direction, 0.0]
    }

    fn plausible(&self, values: &[f64], _scale: &Scale) -> Result<(), Doubt> {
        positive("the factor", values[0], 1.0, "a gear that still drives")
    }

    fn enters(&self, values: &[f64]) -> Enters {
        Enters::Efficiency { loss: values[0] }
    }

    fn side(&self) -> Side {
        Side::Gear
    }

    fn export(&self, _values: &[f64], _ratio: f64) -> SimulatorField {
        SimulatorField::Efficiency
    }

    fn mimics(&self) -> Option<Mimic> {
        Some(Mimic { of: &CoulombFriction, run: "the load hardly changed; a run at another load would separate them" })
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(20)
    }
}
