//! Convex functions of (u, k, s): what limits and objective are on a region.
//!
//! With `x = (1, k, s)` and `y = (1, k, s, u)` a form is `xᵀAx/u + yᵀDy + l·y`, A and D positive
//! semidefinite: the first term is the perspective of a quadratic, hence jointly convex. Forms can be
//! added and scaled; their linearisations lie below them.

/// A linear function of (1, k, s).
pub(super) type Affine = [f64; 3];

/// A point (u, k, s).
pub(super) type Point = [f64; 3];

/// `xᵀAx/u + yᵀDy + l·y`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Form {
    pub(super) over_u: [[f64; 3]; 3],
    pub(super) square: [[f64; 4]; 4],
    pub(super) linear: [f64; 4],
}

/// The value of a linear function.
pub(super) fn at(p: &Affine, k: f64, s: f64) -> f64 {
    p[0] + p[1] * k + p[2] * s
}

/// The same times a factor.
pub(super) fn times(p: &Affine, factor: f64) -> Affine {
    p.map(|x| factor * x)
}

impl Form {
    /// Adds `weight (p·x)²/u`.
    pub(super) fn add_over_u(&mut self, weight: f64, p: &Affine) {
        for i in 0..3 {
            for j in 0..3 {
                self.over_u[i][j] += weight * p[i] * p[j];
            }
        }
    }

    /// Adds `weight (p·y)²`.
    pub(super) fn add_square(&mut self, weight: f64, p: &[f64; 4]) {
        for i in 0..4 {
            for j in 0..4 {
                self.square[i][j] += weight * p[i] * p[j];
            }
        }
    }

    /// Adds `p·x`.
    pub(super) fn add_affine(&mut self, p: &Affine) {
        for (l, x) in self.linear.iter_mut().zip(p) {
            *l += x;
        }
    }

    /// Adds a constant.
    pub(super) fn add_constant(&mut self, constant: f64) {
        self.linear[0] += constant;
    }

    /// Adds `slope u`.
    pub(super) fn add_u(&mut self, slope: f64) {
        self.linear[3] += slope;
    }

    /// Adds another form times a weight that is not negative.
    pub(super) fn add(&mut self, weight: f64, other: &Form) {
        for i in 0..3 {
            for j in 0..3 {
                self.over_u[i][j] += weight * other.over_u[i][j];
            }
        }
        for i in 0..4 {
            for j in 0..4 {
                self.square[i][j] += weight * other.square[i][j];
            }
            self.linear[i] += weight * other.linear[i];
        }
    }

    /// The value at a point.
    pub(super) fn at(&self, [u, k, s]: Point) -> f64 {
        self.evaluate([u, k, s], |x| x)
    }

    /// Sum of the magnitudes of all terms: what can cancel in the value.
    pub(super) fn size(&self, [u, k, s]: Point) -> f64 {
        self.evaluate([u, k.abs(), s.abs()], f64::abs)
    }

    fn evaluate(&self, [u, k, s]: Point, of: impl Fn(f64) -> f64) -> f64 {
        let y = [1.0, k, s, u];
        let mut sum = 0.0;
        for i in 0..3 {
            for j in 0..3 {
                sum += of(self.over_u[i][j]) * y[i] * y[j] / u;
            }
        }
        for i in 0..4 {
            for j in 0..4 {
                sum += of(self.square[i][j]) * y[i] * y[j];
            }
            sum += of(self.linear[i]) * y[i];
        }
        sum
    }

    /// The derivatives with respect to u, k and s.
    pub(super) fn gradient(&self, [u, k, s]: Point) -> Point {
        let y = [1.0, k, s, u];
        let mut d = self.linear;
        let mut perspective = 0.0;
        for i in 0..3 {
            let row: f64 = (0..3).map(|j| self.over_u[i][j] * y[j]).sum();
            d[i] += 2.0 * row / u;
            perspective += row * y[i];
        }
        for (i, d) in d.iter_mut().enumerate() {
            *d += 2.0 * (0..4).map(|j| self.square[i][j] * y[j]).sum::<f64>();
        }
        [d[3] - perspective / (u * u), d[1], d[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn gradient_and_value_agree_and_tangents_lie_below() {
        let mut form = Form::default();
        form.add_over_u(0.7, &[1.0, -2.0, 0.5]);
        form.add_over_u(0.2, &[-3.0, 0.1, 1.5]);
        form.add_square(1.3, &[0.4, 1.0, -1.0, 0.02]);
        form.add_affine(&[5.0, -1.0, 2.0]);
        form.add_u(0.03);
        let z = [40.0, 3.0, -2.0];
        let (value, gradient) = (form.at(z), form.gradient(z));
        for i in 0..3 {
            let (mut up, mut down) = (z, z);
            let h = 1e-5 * z[i].abs();
            up[i] += h;
            down[i] -= h;
            assert_relative_eq!((form.at(up) - form.at(down)) / (2.0 * h), gradient[i], max_relative = 1e-7);
        }
        for other in [[10.0, 0.0, 0.0], [90.0, 7.0, 4.0], [40.0, -3.0, 9.0]] {
            let tangent = value + (0..3).map(|i| gradient[i] * (other[i] - z[i])).sum::<f64>();
            assert!(form.at(other) >= tangent - 1e-12);
        }
    }
}
