//! A planar linkage of four bars.
//!
//! The joint's axis is the origin. A crank of length a on the actuator's axis at A, a rocker of length b on the joint, a coupler of length c
//! between their pins: F(θ, q) = |A + a e(θ) − b e(q + ζ)|² − c² = 0, and r = −F_q/F_θ.

use nalgebra::Vector2;

use super::{At, Fault, LEAST_ARM};

/// Which of its two positions a linkage has at an angle of the joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Branch {
    /// The crank's pin and the joint's axis are on opposite sides of the line from the crank's axis to the rocker's pin.
    Open,
    /// They are on the same side.
    Crossed,
}

impl Branch {
    /// Names, as a requirement has them.
    pub const NAMES: &[(&str, Branch)] = &[("open", Branch::Open), ("crossed", Branch::Crossed)];
}

/// A four-bar linkage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourBar {
    /// The actuator's axis \[m\], as seen from the joint's.
    pub ground: [f64; 2],
    /// Length of the crank, which is on the actuator \[m\].
    pub crank: f64,
    /// Length of the coupler \[m\].
    pub coupler: f64,
    /// Length of the rocker, which is on the joint \[m\].
    pub rocker: f64,
    /// Angle of the rocker where the joint is at zero \[rad\].
    pub rocker_zero: f64,
    /// Which of its positions it has.
    pub branch: Branch,
    /// On which side of the line from the crank's axis to the rocker's pin the crank's pin is: +1 on the left. See [`FourBar::on`].
    pub side: f64,
}

fn direction(angle: f64) -> Vector2<f64> {
    Vector2::new(angle.cos(), angle.sin())
}

/// `e(angle)` turned by a quarter.
fn across(angle: f64) -> Vector2<f64> {
    Vector2::new(-angle.sin(), angle.cos())
}

impl FourBar {
    /// The same on its branch, which is looked at where the joint is at `q` \[rad\]: from there on the crank's pin stays on its side.
    #[must_use]
    pub fn on(self, q: f64) -> FourBar {
        let axis = Vector2::from(self.ground);
        let line = self.rocker * direction(q + self.rocker_zero) - axis;
        // The joint's axis, seen from the crank's.
        let joint = line.perp(&-axis);
        let away = if joint > 0.0 { -1.0 } else { 1.0 };
        let side = if self.branch == Branch::Open { away } else { -away };
        FourBar { side, ..self }
    }

    /// The linkage at an angle of the joint \[rad\].
    pub(super) fn at(&self, q: f64) -> Result<At, Fault> {
        let FourBar { crank: a, coupler: c, rocker: b, .. } = *self;
        let axis = Vector2::from(self.ground);
        let angle = q + self.rocker_zero;
        let [pin, pin1] = [b * direction(angle), b * across(angle)];
        let (pin2, pin3) = (-pin, -pin1);
        let line = pin - axis;
        let reach = line.norm();
        let cosine = (a * a + reach * reach - c * c) / (2.0 * a * reach);
        if !(-1.0..=1.0).contains(&cosine) {
            return Err(Fault::Open(q));
        }
        let theta = line.y.atan2(line.x) + self.side * cosine.acos();
        let (tip, tip1) = (a * direction(theta), a * across(theta));
        let rod = axis + tip - pin;
        // Half of the derivatives of F.
        let (f_t, f_q) = (rod.dot(&tip1), -rod.dot(&pin1));
        if f_t.abs() < LEAST_ARM * a * c {
            return Err(Fault::CrankInLine(q));
        }
        if f_q.abs() < LEAST_ARM * b * c {
            return Err(Fault::NoArm(q));
        }
        let (f_tt, f_tq, f_qq) = (a * a - rod.dot(&tip), -tip1.dot(&pin1), b * b - rod.dot(&pin2));
        let f_ttt = -rod.dot(&tip1);
        let (f_ttq, f_tqq, f_qqq) = (pin1.dot(&tip), -tip1.dot(&pin2), 3.0 * pin1.dot(&pin2) - rod.dot(&pin3));
        let r = -f_q / f_t;
        let slope = -(f_qq + 2.0 * r * f_tq + r * r * f_tt) / f_t;
        let third = f_qqq + 3.0 * r * f_tqq + 3.0 * r * r * f_ttq + r.powi(3) * f_ttt;
        let bend = -(third + 3.0 * slope * (f_tq + r * f_tt)) / f_t;
        Ok(At { angle: theta, ratio: r, slope, bend, arm: Some(f_q.abs() / c) })
    }
}
