use super::viscous::ViscousFriction;
use super::{Doubt, Effect, Enters, Mimic, Operating, Parameter, Scale, Search, Shape, Variable, positive};
use crate::units;

/// Drag of eddy currents, which rises with speed and flattens: `2 T_max/(ω/ω_k + ω_k/ω)`.
#[derive(Debug)]
pub struct EddyDrag;

impl Effect for EddyDrag {
    fn name(&self) -> &'static str {
        "eddy_drag"
    }

    fn equation(&self) -> &'static str {
        "2 T_max/(ω/ω_k + ω_k/ω)"
    }

    fn parameters(&self) -> &'static [Parameter] {
        &[
            Parameter { name: "torque", symbol: "T_max", kind: &units::TORQUE },
            Parameter { name: "speed", symbol: "ω_k", kind: &units::SPEED },
        ]
    }

    fn needs(&self) -> &'static [Variable] {
        &[Variable::Speed]
    }

    fn shape(&self) -> Shape {
        Shape::Speed(Search { from: 0.05, to: 1.2, starts: &[0.3, 0.8] })
    }

    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2] {
        [2.0 * (at.speed / shape) / (1.0 + (at.speed / shape).powi(2)), 0.0]
    }

    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt> {
        positive("the drag torque", values[0], scale.torque, "the largest torque on the bench")?;
        if values[1] < 0.045 * scale.speed {
            return Err(Doubt::Unnatural(format!(
                "its knee at {:.3e} rad/s would make it Coulomb friction",
                values[1]
            )));
        }
        positive("the knee", values[1], 1.3 * scale.speed, "the largest speed: below its knee it is viscous friction")
    }

    fn drifts_with_band(&self) -> bool {
        true
    }

    fn enters(&self, _values: &[f64]) -> Enters {
        Enters::Evaluated(|values, at| {
            let x = at.speed / values[1];
            2.0 * values[0] / values[1] * (1.0 - x * x) / (1.0 + x * x).powi(2)
        })
    }

    fn mimics(&self) -> Option<Mimic> {
        Some(Mimic { of: &ViscousFriction, run: "a run to higher speeds, beyond the knee, would separate them" })
    }

    fn rank_in_position(&self) -> Option<u32> {
        Some(70)
    }
}
