//! A ratio over the joint's angle, from a table.
//!
//! The ratio is the cubic spline through its rows; the actuator's angle is its integral.

use super::{At, Fault};
use crate::numerics::spline;

/// A ratio over the joint's angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Angles of the joint \[rad\], rising.
    position: Vec<f64>,
    ratio: Vec<f64>,
    slope: Vec<f64>,
    /// Angles of the actuator \[rad\].
    angle: Vec<f64>,
}

/// How far an angle may be outside of the table: what rounding leaves.
const ROUNDING: f64 = 1e-9;

impl Table {
    /// Fewest rows.
    pub const LEAST: usize = 4;

    /// From angles of the joint \[rad\], rising, with the ratio at each; `first` is the actuator's angle at the first \[rad\].
    ///
    /// # Panics
    /// With fewer rows than [`Table::LEAST`], or lists of other lengths.
    pub fn new(position: Vec<f64>, ratio: Vec<f64>, first: f64) -> Table {
        assert!(position.len() >= Table::LEAST && position.len() == ratio.len(), "rows of one length");
        let slope = spline::open(&position, &ratio).first;
        let mut angle = vec![first];
        for k in 1..position.len() {
            let h = position[k] - position[k - 1];
            let way = h * (0.5 * (ratio[k - 1] + ratio[k]) + h / 12.0 * (slope[k - 1] - slope[k]));
            angle.push(angle[k - 1] + way);
        }
        Table { position, ratio, slope, angle }
    }

    /// From angles of the joint and of the actuator \[rad\].
    pub fn of_angles(position: Vec<f64>, angle: &[f64]) -> Table {
        let ratio = spline::open(&position, angle).first;
        Table::new(position, ratio, angle[0])
    }

    /// The smallest and the largest angle of the joint \[rad\].
    pub fn range(&self) -> [f64; 2] {
        [self.position[0], self.position[self.position.len() - 1]]
    }

    /// The actuator's angles at the rows \[rad\].
    pub(super) fn angles(&self) -> &[f64] {
        &self.angle
    }

    pub(super) fn at(&self, q: f64) -> Result<At, Fault> {
        let [low, high] = self.range();
        let slack = ROUNDING * (high - low);
        if !(q >= low - slack && q <= high + slack) {
            return Err(Fault::Outside(q, [low, high]));
        }
        let last = self.position.len() - 2;
        let k = self.position.partition_point(|p| *p <= q).saturating_sub(1).min(last);
        let (h, s) = (self.position[k + 1] - self.position[k], q - self.position[k]);
        let (y0, y1, d0, d1) = (self.ratio[k], self.ratio[k + 1], self.slope[k], self.slope[k + 1]);
        let secant = (y1 - y0) / h;
        let (c2, c3) = ((3.0 * secant - 2.0 * d0 - d1) / h, (d0 + d1 - 2.0 * secant) / (h * h));
        Ok(At {
            angle: self.angle[k] + s * (y0 + s * (d0 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0))),
            ratio: y0 + s * (d0 + s * (c2 + s * c3)),
            slope: d0 + s * (2.0 * c2 + s * 3.0 * c3),
            bend: 2.0 * c2 + 6.0 * c3 * s,
            arm: None,
        })
    }
}
