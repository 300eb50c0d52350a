use super::features::sign;
use super::{Doubt, Effect, Enters, Equation, Operating, Parameter, Scale, Side, SimulatorField, Variable, positive};
use crate::units;

/// Backlash of the gear: the output lags the motor by half the play in the direction of the torque.
#[derive(Debug)]
pub struct Backlash;

impl Effect for Backlash {
    fn name(&self) -> &'static str {
        "backlash"
    }

    fn equation(&self) -> &'static str {
        "β/2 sgn τ"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[Parameter { name: "half_play", symbol: "β/2", kind: &units::ANGLE }]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Torque]
    }

    fn acts_on(&self) -> Equation {
        Equation::Angle
    }

    fn basis(&self, _shape: f64, at: &Operating) -> [f64; 2] {
        [sign(at.torque), 0.0]
    }

    fn plausible(&self, values: &[f64], _scale: &Scale) -> Result<(), Doubt> {
        positive("half the play", values[0], 0.2, "any gear")
    }

    fn enters(&self, _values: &[f64]) -> Enters {
        Enters::NotAtAll("the play changes where the output is, not what the motor must supply")
    }

    fn export(&self, values: &[f64], _ratio: f64) -> SimulatorField {
        SimulatorField::Play(2.0 * values[0])
    }

    fn side(&self) -> Side {
        Side::Gear
    }
}
