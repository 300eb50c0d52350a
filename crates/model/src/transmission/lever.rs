//! A screw or linear actuator between a point of the frame and a lever on the joint.
//!
//! The joint's axis is the origin. The screw's length s is that from its foot to the end of the lever; the actuator turns by
//! θ = 2π s/lead, and ds/dq is the moment arm of the screw's force.

use nalgebra::Vector2;

use super::{At, Fault, LEAST_ARM};

/// A lever with a screw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lever {
    /// The screw's foot \[m\], as seen from the joint's axis.
    pub pivot: [f64; 2],
    /// Length of the lever \[m\].
    pub arm: f64,
    /// Angle of the lever where the joint is at zero \[rad\].
    pub arm_zero: f64,
    /// Travel of the screw per turn of the actuator \[m\].
    pub lead: f64,
}

impl Lever {
    /// The lever at an angle of the joint \[rad\].
    pub(super) fn at(&self, q: f64) -> Result<At, Fault> {
        let angle = q + self.arm_zero;
        let foot = Vector2::from(self.pivot);
        let (e, across) = (Vector2::new(angle.cos(), angle.sin()), Vector2::new(-angle.sin(), angle.cos()));
        let length = (self.arm * e - foot).norm();
        if length <= LEAST_ARM * self.arm {
            return Err(Fault::Open(q));
        }
        // s² = a² + f² − 2 a f·e, and its derivatives.
        let (g1, g2, g3) =
            (-2.0 * self.arm * foot.dot(&across), 2.0 * self.arm * foot.dot(&e), 2.0 * self.arm * foot.dot(&across));
        let s1 = g1 / (2.0 * length);
        let s2 = (0.5 * g2 - s1 * s1) / length;
        let s3 = (0.5 * g3 - 3.0 * s1 * s2) / length;
        if s1.abs() < LEAST_ARM * self.arm {
            return Err(Fault::NoArm(q));
        }
        let turns = std::f64::consts::TAU / self.lead;
        Ok(At { angle: turns * length, ratio: turns * s1, slope: turns * s2, bend: turns * s3, arm: Some(s1.abs()) })
    }
}
