//! How two actuators and two joints go together: by a matrix, a table of it, or rods.
//!
//! θ̇ = J(q) q̇ with the rows of J those of the actuators. Of a rod from the crank of an actuator to a pin on the moved link:
//! F(θ, q) = |A + a e(θ) − P(q)|² − c² = 0, so that ∂θ/∂q_i = −F_i/F_θ.

use nalgebra::{Rotation3, Unit, Vector3};

use super::{Fault, LEAST_ARM};
use crate::numerics::spline;

/// How two actuators and two joints go together.
#[derive(Debug, Clone, PartialEq)]
pub enum Coupler {
    /// θ = M q: a differential, an actuator that drives past a joint.
    Matrix([[f64; 2]; 2]),
    /// J over both angles.
    Table(JacobianTable),
    /// A rod from each actuator's crank to the moved link.
    Rods(Box<[Rod; 2]>),
}

/// A coupling at a pair of angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AtBoth {
    /// J: row of the actuator, column of the joint.
    pub(super) jacobian: [[f64; 2]; 2],
    /// ∂J/∂q_1 and ∂J/∂q_2.
    pub(super) slopes: [[[f64; 2]; 2]; 2],
    /// Force of each rod per torque of its actuator \[1/m\].
    pub(super) forces: Option<[f64; 2]>,
}

impl AtBoth {
    /// J̇ where the joints have these speeds \[rad/s\].
    pub(super) fn turning(&self, speed: [f64; 2]) -> [[f64; 2]; 2] {
        let of = |a: usize, i: usize| self.slopes[0][a][i] * speed[0] + self.slopes[1][a][i] * speed[1];
        [[of(0, 0), of(0, 1)], [of(1, 0), of(1, 1)]]
    }
}

impl Coupler {
    /// The coupling at a pair of angles \[rad\].
    pub(super) fn at(&self, q: [f64; 2]) -> Result<AtBoth, Fault> {
        match self {
            Coupler::Matrix(jacobian) => Ok(AtBoth { jacobian: *jacobian, slopes: [[[0.0; 2]; 2]; 2], forces: None }),
            Coupler::Table(table) => table.at(q),
            Coupler::Rods(rods) => {
                let (first, second) = (rods[0].at(q, 1)?, rods[1].at(q, 2)?);
                let slope = |j: usize| [[first.1[0][j], first.1[1][j]], [second.1[0][j], second.1[1][j]]];
                Ok(AtBoth {
                    jacobian: [first.0, second.0],
                    slopes: [slope(0), slope(1)],
                    forces: Some([first.2, second.2]),
                })
            }
        }
    }

    /// What it is, in a word or two.
    pub fn word(&self) -> &'static str {
        match self {
            Coupler::Matrix(_) => "coupling by a matrix",
            Coupler::Table(_) => "coupling by a table",
            Coupler::Rods(_) => "coupling by two rods",
        }
    }
}

/// ∂θ/∂q_i, ∂²θ/∂q_i∂q_j, and a rod's force per torque of its actuator \[1/m\].
type OfRod = ([f64; 2], [[f64; 2]; 2], f64);

/// A rod from an actuator's crank to the link that two joints move, where both joints are at zero and the crank is at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rod {
    /// A point of the crank's axis \[m\], as seen from where both joints' axes meet.
    pub axis_at: [f64; 3],
    /// Direction of the crank's axis.
    pub axis: [f64; 3],
    /// The crank's pin \[m\].
    pub crank_pin: [f64; 3],
    /// The moved link's pin \[m\].
    pub link_pin: [f64; 3],
    /// Directions of the two joints' axes; the second moves with the first joint.
    pub joints: [[f64; 3]; 2],
}

impl Rod {
    /// Whether crank, rod and both levers have a length.
    pub fn is_sound(&self) -> bool {
        let v = Vector3::from;
        let (axis, arm) = (v(self.axis), v(self.crank_pin) - v(self.axis_at));
        let apart = (v(self.crank_pin) - v(self.link_pin)).norm();
        axis.norm() > 0.0
            && v(self.joints[0]).cross(&v(self.joints[1])).norm() > 1e-6
            && arm.cross(&axis.normalize()).norm() > 1e-9
            && apart > 1e-9
    }

    /// The crank's angle over those of the joints \[rad\].
    fn at(&self, q: [f64; 2], number: usize) -> Result<OfRod, Fault> {
        let v = Vector3::from;
        let axis = v(self.axis).normalize();
        let arm = v(self.crank_pin) - v(self.axis_at);
        // The crank turns about the foot of its pin on the axis.
        let foot = v(self.axis_at) + axis * arm.dot(&axis);
        let zero = v(self.crank_pin) - foot;
        let side = axis.cross(&zero);
        let length = (v(self.crank_pin) - v(self.link_pin)).norm();
        let [e1, e2] = self.joints.map(|e| v(e).normalize());
        let [turn1, turn2] =
            [(e1, q[0]), (e2, q[1])].map(|(e, q)| Rotation3::from_axis_angle(&Unit::new_unchecked(e), q));
        let inner = turn2 * v(self.link_pin);
        let pin = turn1 * inner;
        let first = [e1.cross(&pin), turn1 * e2.cross(&inner)];
        let mixed = e1.cross(&first[1]);
        let second = [[e1.cross(&first[0]), mixed], [mixed, turn1 * e2.cross(&e2.cross(&inner))]];
        let line = pin - foot;
        let (du, dv, crank) = (line.dot(&zero), line.dot(&side), zero.norm());
        // |foot + e(θ) − pin|² = c².
        let wanted = 0.5 * (crank * crank + line.norm_squared() - length * length);
        let reach = du.hypot(dv);
        let cosine = wanted / reach;
        if !(-1.0..=1.0).contains(&cosine) {
            return Err(Fault::OpenAt(q, number));
        }
        let theta = dv.atan2(du) + self.branch() * cosine.acos();
        let (tip, tip1) = (zero * theta.cos() + side * theta.sin(), side * theta.cos() - zero * theta.sin());
        let rod = foot + tip - pin;
        let f_t = rod.dot(&tip1);
        if f_t.abs() < LEAST_ARM * crank * length {
            return Err(Fault::InLineAt(q, number));
        }
        let f_tt = crank * crank - rod.dot(&tip);
        let j = first.map(|p| rod.dot(&p) / f_t);
        let of = |a: usize, b: usize| {
            let f_ab = first[a].dot(&first[b]) - rod.dot(&second[a][b]);
            let (f_at, f_bt) = (-tip1.dot(&first[a]), -tip1.dot(&first[b]));
            -(f_ab + f_at * j[b] + f_bt * j[a] + f_tt * j[a] * j[b]) / f_t
        };
        Ok((j, [[of(0, 0), of(0, 1)], [of(1, 0), of(1, 1)]], length / f_t.abs()))
    }

    /// On which side of the line to the link's pin the crank is: where everything is at zero it is at its own zero.
    fn branch(&self) -> f64 {
        let v = Vector3::from;
        let axis = v(self.axis).normalize();
        let arm = v(self.crank_pin) - v(self.axis_at);
        let foot = v(self.axis_at) + axis * arm.dot(&axis);
        let zero = v(self.crank_pin) - foot;
        let side = axis.cross(&zero);
        let line = v(self.link_pin) - foot;
        // θ = atan2(dv, du) ± acos(…) = 0: the sign is that which takes the angle of the line back.
        if line.dot(&side) > 0.0 { -1.0 } else { 1.0 }
    }
}

/// J over a grid of both angles.
#[derive(Debug, Clone, PartialEq)]
pub struct JacobianTable {
    first: Vec<f64>,
    second: Vec<f64>,
    /// Of each entry (by rows of J) and each node: value, ∂/∂q_1, ∂/∂q_2, ∂²/∂q_1∂q_2.
    nodes: [Vec<[f64; 4]>; 4],
}

impl JacobianTable {
    /// Fewest angles along each joint.
    pub const LEAST: usize = 4;

    /// From the angles of a grid \[rad\], rising, and the entries of J by rows at each node, the second angle running fastest.
    ///
    /// # Panics
    /// With fewer angles than [`JacobianTable::LEAST`], or lists of other lengths.
    pub fn new(first: Vec<f64>, second: Vec<f64>, entries: [Vec<f64>; 4]) -> JacobianTable {
        let (n, m) = (first.len(), second.len());
        assert!(n >= Self::LEAST && m >= Self::LEAST && entries.iter().all(|e| e.len() == n * m), "a whole grid");
        let along_first = |values: &[f64]| {
            let mut slopes = vec![0.0; n * m];
            for j in 0..m {
                let column: Vec<f64> = (0..n).map(|i| values[i * m + j]).collect();
                let each = spline::open(&first, &column).first;
                each.iter().enumerate().for_each(|(i, slope)| slopes[i * m + j] = *slope);
            }
            slopes
        };
        let along_second =
            |values: &[f64]| values.chunks(m).flat_map(|row| spline::open(&second, row).first).collect::<Vec<f64>>();
        let nodes = entries.map(|values| {
            let (a, b) = (along_first(&values), along_second(&values));
            let mixed = along_second(&a);
            (0..n * m).map(|k| [values[k], a[k], b[k], mixed[k]]).collect()
        });
        JacobianTable { first, second, nodes }
    }

    fn at(&self, q: [f64; 2]) -> Result<AtBoth, Fault> {
        let place = |axis: &[f64], q: f64| {
            let last = axis.len() - 1;
            let slack = 1e-9 * (axis[last] - axis[0]);
            let inside = q >= axis[0] - slack && q <= axis[last] + slack;
            let k = axis.partition_point(|x| *x <= q).saturating_sub(1).min(last - 1);
            inside.then(|| (k, axis[k + 1] - axis[k], (q - axis[k]) / (axis[k + 1] - axis[k])))
        };
        let ((i, h, x), (j, l, y)) =
            place(&self.first, q[0]).zip(place(&self.second, q[1])).ok_or(Fault::OutsideAt(q))?;
        let m = self.second.len();
        let (ax, bx, ay, by) = (hermite(x), hermite_slope(x), hermite(y), hermite_slope(y));
        let mut found = [[0.0; 3]; 4];
        for (entry, nodes) in self.nodes.iter().enumerate() {
            for (di, dj) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let [value, a, b, ab] = nodes[(i + di) * m + j + dj];
                // Values and slopes, each along both.
                let terms = [(0, 0, value), (1, 0, a * h), (0, 1, b * l), (1, 1, ab * h * l)];
                for (sx, sy, c) in terms {
                    let (kx, ky) = (2 * sx + di, 2 * sy + dj);
                    found[entry][0] += c * ax[kx] * ay[ky];
                    found[entry][1] += c * bx[kx] * ay[ky] / h;
                    found[entry][2] += c * ax[kx] * by[ky] / l;
                }
            }
        }
        let of = |k: usize| [[found[0][k], found[1][k]], [found[2][k], found[3][k]]];
        Ok(AtBoth { jacobian: of(0), slopes: [of(1), of(2)], forces: None })
    }
}

/// The cubics that are one at either end, and those of slope one there.
fn hermite(x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    [(1.0 + 2.0 * x) * y * y, x * x * (3.0 - 2.0 * x), x * y * y, -x * x * y]
}

fn hermite_slope(x: f64) -> [f64; 4] {
    let y = 1.0 - x;
    [-6.0 * x * y, 6.0 * x * y, y * (1.0 - 3.0 * x), x * (3.0 * x - 2.0)]
}
