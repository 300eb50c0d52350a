//! A coupling at each sample of a motion.

use std::sync::Arc;

use super::Numbers;
use super::coupler::AtBoth;
use super::range::Range;
use crate::motion::Motion;

/// A coupling at each sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Both {
    pub(super) at: Vec<AtBoth>,
    /// Torques of each actuator that come from the joints \[N·m\].
    pub(super) torques: [Vec<f64>; 2],
    /// Smallest and largest |det J|.
    pub determinant: Range,
}

impl Both {
    pub(super) fn with_more(
        &self,
        joints: &[(String, Arc<Motion>)],
        numbers: &Numbers,
        k: usize,
        torque: f64,
        rate: f64,
    ) -> (f64, f64) {
        let (actuator, k) = (k / self.at.len(), k % self.at.len());
        let inverse = inverse(&self.at[k].jacobian);
        // τ_θ = J⁻ᵀ τ: the actuator's column of J⁻¹.
        let per = [inverse[0][actuator], inverse[1][actuator]];
        let at = usize::from(per[1].abs() > per[0].abs());
        let joints = [0, 1].map(|j| joints[j].1.instant(k));
        let turning = self.at[k].turning(joints.map(|joint| joint.velocity));
        // d(J⁻ᵀ)/dt = −J⁻ᵀ J̇ᵀ J⁻ᵀ.
        let pulled: f64 = (0..2).map(|i| per[i] * (0..2).map(|a| turning[a][i] * inverse[at][a]).sum::<f64>()).sum();
        let per = per[at];
        let speed: f64 = (0..2).map(|j| self.at[k].jacobian[actuator][j] * joints[j].velocity).sum();
        let load = self.torques[actuator][k] + per * torque;
        let factor = numbers.factor(load, speed);
        // What does not come from the joints is the same with and without.
        (factor * load, factor * (per * rate - pulled * torque))
    }

    /// Force of each rod at each sample of the motion \[N\]; `None` where no rod says it.
    pub(super) fn forces(&self) -> Option<Vec<f64>> {
        let of = |a: usize| {
            let force = |(k, at): (usize, &AtBoth)| Some(self.torques[a][k].abs() * at.forces?[a]);
            self.at.iter().enumerate().map(force).collect::<Option<Vec<f64>>>()
        };
        Some([of(0)?, of(1)?].concat())
    }
}

pub(super) fn determinant(j: &[[f64; 2]; 2]) -> f64 {
    j[0][0] * j[1][1] - j[0][1] * j[1][0]
}

pub(super) fn inverse(j: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let d = determinant(j);
    [[j[1][1] / d, -j[0][1] / d], [-j[1][0] / d, j[0][0] / d]]
}
