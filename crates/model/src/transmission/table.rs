//! A ratio over the joint's angle, from a table.
//!
//! The ratio is the cubic spline through its rows; the actuator's angle is its integral.

use super::{At, Fault};
use crate::numerics::cubic::Cubic;
use crate::numerics::spline;

/// A ratio over the joint's angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Angles of the joint \[rad\], rising.
    position: Vec<f64>,
    /// The ratio from each row to the next.
    pieces: Vec<Cubic>,
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
        let (mut angle, mut pieces) = (vec![first], Vec::new());
        for k in 1..position.len() {
            let h = position[k] - position[k - 1];
            let piece = Cubic::between(h, [ratio[k - 1], slope[k - 1]], [ratio[k], slope[k]]);
            angle.push(angle[k - 1] + piece.integral(h));
            pieces.push(piece);
        }
        Table { position, pieces, angle }
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
        let last = self.pieces.len() - 1;
        let k = self.position.partition_point(|p| *p <= q).saturating_sub(1).min(last);
        let (piece, s) = (&self.pieces[k], q - self.position[k]);
        Ok(At {
            angle: self.angle[k] + piece.integral(s),
            ratio: piece.at(s),
            slope: piece.slope(s),
            bend: piece.bend(s),
            arm: None,
        })
    }
}
