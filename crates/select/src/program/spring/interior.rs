//! A convex program of three variables, by a primal-dual interior point method with slacks.
//!
//! The programs of springs have a ratio, a stiffness and a rest angle, a handful of smooth rows and thousands of siblings:
//! a dense Newton step of four numbers takes a fraction of what a sparse cone solver needs to set up. What comes out is
//! a proposal with multipliers; the bound that is told is computed from them elsewhere.
#![allow(clippy::needless_range_loop, reason = "matrices are read by their indices")]

use super::form::Form;

/// Steps after which it is given up.
const MOST_STEPS: usize = 60;
/// Residuals and products of slacks and multipliers below this are none: the program is scaled to one.
const SOLVED: f64 = 1e-11;
/// What is accepted where no further step makes progress.
const NEARLY: f64 = 1e-7;
/// How far a step goes towards the boundary.
const NEAR_BOUNDARY: f64 = 0.99;

/// A row `form(x) − weight t ≤ right` in scaled variables `x = (x, y, v)`, v above zero.
#[derive(Debug, Clone)]
pub(super) struct Smooth {
    pub(super) form: Form,
    /// Of the objective t.
    pub(super) weight: f64,
    pub(super) right: f64,
}

/// What was found: the variables, and the multipliers of rows and planes. Where it `solved` nothing the multipliers may
/// still show that there is nothing.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    pub(super) x: [f64; 3],
    pub(super) multipliers: Vec<f64>,
    pub(super) solved: bool,
}

/// Value, gradient and second derivatives of a form by (x, y, v); it takes (v, x, y) as its point (u, k, s).
fn expand(form: &Form, [x, y, v]: [f64; 3]) -> (f64, [f64; 3], [[f64; 3]; 3]) {
    let a = [1.0, x, y];
    let b = [1.0, x, y, v];
    let of_a: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| form.over_u[i][j] * a[j]).sum());
    let of_b: [f64; 4] = std::array::from_fn(|i| (0..4).map(|j| form.square[i][j] * b[j]).sum());
    let over = (0..3).map(|i| a[i] * of_a[i]).sum::<f64>() / v;
    let value = over + (0..4).map(|i| b[i] * (of_b[i] + form.linear[i])).sum::<f64>();
    let mut gradient: [f64; 3] = std::array::from_fn(|i| 2.0 * of_b[i + 1] + form.linear[i + 1]);
    let mut second: [[f64; 3]; 3] = std::array::from_fn(|i| std::array::from_fn(|j| 2.0 * form.square[i + 1][j + 1]));
    for i in 0..2 {
        gradient[i] += 2.0 * of_a[i + 1] / v;
        for j in 0..2 {
            second[i][j] += 2.0 * form.over_u[i + 1][j + 1] / v;
        }
        second[i][2] -= 2.0 * of_a[i + 1] / (v * v);
        second[2][i] -= 2.0 * of_a[i + 1] / (v * v);
    }
    gradient[2] -= over / v;
    second[2][2] += 2.0 * over / (v * v);
    (value, gradient, second)
}

/// A row at a point: its value minus its right side, its gradient by (x, y, v, t) and second derivatives by (x, y, v).
struct Here {
    value: f64,
    gradient: [f64; 4],
    second: [[f64; 3]; 3],
}

/// The Cholesky factor of a positive definite matrix, with what is missing of it added to its diagonal.
fn factor(mut m: [[f64; 4]; 4]) -> [[f64; 4]; 4] {
    for i in 0..4 {
        let size = m[i][i].abs();
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| m[i][k] * m[j][k]).sum();
            m[i][j] = (m[i][j] - sum) / m[j][j];
        }
        let rest = m[i][i] - (0..i).map(|k| m[i][k] * m[i][k]).sum::<f64>();
        m[i][i] = rest.max(1e-15 * size).max(1e-100).sqrt();
    }
    m
}

fn solve(l: &[[f64; 4]; 4], mut b: [f64; 4]) -> [f64; 4] {
    for i in 0..4 {
        let sum: f64 = (0..i).map(|k| l[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i][i];
    }
    for i in (0..4).rev() {
        let sum: f64 = (i + 1..4).map(|k| l[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / l[i][i];
    }
    b
}

/// Minimises t under the rows and the planes `p·(1, x, y, v) ≥ 0`, from a point that lies within the planes. `fixed` are
/// directions (unit vectors of (x, y, v), at right angles) that it does not move in.
pub(super) fn minimise(rows: &[Smooth], planes: &[[f64; 4]], fixed: &[[f64; 3]], start: [f64; 3]) -> Solution {
    let count = rows.len() + planes.len();
    let look = |x: [f64; 3], t: f64| -> Vec<Here> {
        let curved = rows.iter().map(|row| {
            let (value, g, second) = expand(&row.form, x);
            Here { value: value - row.weight * t - row.right, gradient: [g[0], g[1], g[2], -row.weight], second }
        });
        let flat = planes.iter().map(|p| Here {
            value: -(p[0] + p[1] * x[0] + p[2] * x[1] + p[3] * x[2]),
            gradient: [-p[1], -p[2], -p[3], 0.0],
            second: [[0.0; 3]; 3],
        });
        let mut all: Vec<Here> = curved.chain(flat).collect();
        for here in &mut all {
            for f in fixed {
                let along: f64 = (0..3).map(|i| f[i] * here.gradient[i]).sum();
                (0..3).for_each(|i| here.gradient[i] -= along * f[i]);
            }
        }
        all
    };
    let mut x = start;
    let above = rows.iter().filter(|r| r.weight > 0.0).map(|r| (expand(&r.form, x).0 - r.right) / r.weight);
    let mut t = above.fold(f64::NEG_INFINITY, f64::max) + 1.0;
    let mut here = look(x, t);
    let mut slack: Vec<f64> = here.iter().map(|h| (-h.value).max(0.05)).collect();
    let mut multiplier: Vec<f64> = slack.iter().map(|s| (0.1 / s).clamp(1e-3, 1e3)).collect();
    let mut solved = false;
    let mut nearly = false;
    for _ in 0..MOST_STEPS {
        let mut dual = [0.0, 0.0, 0.0, 1.0];
        let mut matrix = [[0.0; 4]; 4];
        for (h, m) in here.iter().zip(&multiplier) {
            for i in 0..4 {
                dual[i] += m * h.gradient[i];
            }
            for i in 0..3 {
                for j in 0..3 {
                    matrix[i][j] += m * h.second[i][j];
                }
            }
        }
        for f in fixed {
            // Projected, with one in the directions that are fixed.
            let across: [f64; 3] = std::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * f[j]).sum());
            let twice: f64 = (0..3).map(|i| f[i] * across[i]).sum();
            for i in 0..3 {
                for j in 0..3 {
                    matrix[i][j] += (twice + 1.0) * f[i] * f[j] - across[i] * f[j] - f[i] * across[j];
                }
            }
        }
        for ((h, m), s) in here.iter().zip(&multiplier).zip(&slack) {
            let ratio = m / s;
            for i in 0..4 {
                for j in 0..4 {
                    matrix[i][j] += ratio * h.gradient[i] * h.gradient[j];
                }
            }
        }
        let primal: Vec<f64> = here.iter().zip(&slack).map(|(h, s)| h.value + s).collect();
        let products: f64 = slack.iter().zip(&multiplier).map(|(s, m)| s * m).sum::<f64>() / count as f64;
        let off = primal.iter().map(|r| r.abs()).fold(0.0, f64::max);
        let slope = dual.iter().map(|d| d.abs()).fold(0.0, f64::max);
        if !(products.is_finite() && off.is_finite() && slope.is_finite()) {
            break;
        }
        let residual = products.max(off).max(slope);
        nearly = residual < NEARLY;
        if residual < SOLVED {
            solved = true;
            break;
        }
        let factored = factor(matrix);
        // The Newton step with products of slacks and multipliers as wanted.
        let step = |wanted: &dyn Fn(usize) -> f64| {
            let mut right = dual.map(|d| -d);
            for (i, h) in here.iter().enumerate() {
                let push = (wanted(i) - slack[i] * multiplier[i] + multiplier[i] * primal[i]) / slack[i];
                for j in 0..4 {
                    right[j] -= h.gradient[j] * push;
                }
            }
            let dx = solve(&factored, right);
            let mut ds = Vec::with_capacity(count);
            let mut dm = Vec::with_capacity(count);
            for (i, h) in here.iter().enumerate() {
                let change: f64 = (0..4).map(|j| h.gradient[j] * dx[j]).sum();
                let s = -primal[i] - change;
                ds.push(s);
                dm.push((wanted(i) - slack[i] * multiplier[i] - multiplier[i] * s) / slack[i]);
            }
            (dx, ds, dm)
        };
        let longest = |values: &[f64], changes: &[f64]| {
            let each = values.iter().zip(changes).filter(|(_, d)| **d < 0.0).map(|(v, d)| -v / d);
            each.fold(1.0 / NEAR_BOUNDARY, f64::min)
        };
        let (_, ds, dm) = step(&|_| 0.0);
        let (a, b) = (longest(&slack, &ds).min(1.0), longest(&multiplier, &dm).min(1.0));
        let after: f64 = (0..count).map(|i| (slack[i] + a * ds[i]) * (multiplier[i] + b * dm[i])).sum::<f64>();
        let centring = (after / count as f64 / products).clamp(0.0, 1.0).powi(3);
        let wanted = |i: usize| centring * products - ds[i] * dm[i];
        let (dx, ds, dm) = step(&wanted);
        let one = (NEAR_BOUNDARY * longest(&slack, &ds)).min(1.0);
        let other = (NEAR_BOUNDARY * longest(&multiplier, &dm)).min(1.0);
        // v stays above zero whatever the planes say.
        let back = if dx[2] < 0.0 { (0.9 * x[2] / -dx[2]).min(1.0) } else { 1.0 };
        let one = one.min(back);
        if !(one > 1e-12 || other > 1e-12) {
            break;
        }
        (0..3).for_each(|i| x[i] += one * dx[i]);
        t += one * dx[3];
        here = look(x, t);
        for i in 0..count {
            slack[i] = (slack[i] + one * ds[i]).max(-here[i].value).max(1e-300);
            multiplier[i] = (multiplier[i] + other * dm[i]).max(1e-300);
        }
    }
    Solution { x, multipliers: multiplier, solved: solved || nearly }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn row(form: Form, weight: f64, right: f64) -> Smooth {
        Smooth { form, weight, right }
    }

    /// −1 ≤ x, y ≤ 1 and 0.1 ≤ v ≤ 10.
    const BOX: [[f64; 4]; 6] = [
        [1.0, 1.0, 0.0, 0.0],
        [1.0, -1.0, 0.0, 0.0],
        [1.0, 0.0, 1.0, 0.0],
        [1.0, 0.0, -1.0, 0.0],
        [-0.1, 0.0, 0.0, 1.0],
        [10.0, 0.0, 0.0, -1.0],
    ];

    /// `(2 + x)²/v + v + (y − 0.3)²`, the least of which is 2 (2 + x) at v = 2 + x.
    fn valley() -> Form {
        let mut form = Form::default();
        form.add_over_u(1.0, &[2.0, 1.0, 0.0]);
        form.add_u(1.0);
        form.add_square(1.0, &[-0.3, 0.0, 1.0, 0.0]);
        form
    }

    #[test]
    fn a_valley_on_paper_with_a_plane_a_row_and_a_direction_that_is_fixed() {
        let free = minimise(&[row(valley(), 1.0, 0.0)], &BOX, &[], [0.0, 0.0, 1.0]);
        assert!(free.solved);
        // x goes to its end, −1; there the least is 2, and a unit of x more costs 2.
        for (found, wanted) in free.x.iter().zip([-1.0, 0.3, 1.0]) {
            assert_relative_eq!(*found, wanted, epsilon = 1e-6);
        }
        assert_relative_eq!(free.multipliers[0], 1.0, epsilon = 1e-7);
        assert_relative_eq!(free.multipliers[1], 2.0, epsilon = 1e-5);
        // v ≥ 4 as a row: (1/16 of (2 + x)² less per unit of v) 1 − 1/16 is its price.
        let mut most = Form::default();
        most.add_u(-1.0);
        let bound = minimise(&[row(valley(), 1.0, 0.0), row(most, 0.0, -4.0)], &BOX, &[], [0.0, 0.0, 1.0]);
        assert!(bound.solved && (bound.x[2] - 4.0).abs() < 1e-6);
        assert_relative_eq!(bound.multipliers[1], 1.0 - 1.0 / 16.0, epsilon = 1e-5);
        // With x fixed at 0.5.
        let fixed = minimise(&[row(valley(), 1.0, 0.0)], &BOX, &[[1.0, 0.0, 0.0]], [0.5, 0.0, 1.0]);
        assert!(fixed.solved && fixed.x[0] == 0.5 && (fixed.x[2] - 2.5).abs() < 1e-6);
    }

    #[test]
    fn the_largest_of_two_is_shared_and_rows_that_contradict_each_other_are_not_solved() {
        // |x − 0.2| as two cuts: both weigh a half.
        let line = |slope: f64| {
            let mut form = Form::default();
            form.add_affine(&[-0.2 * slope, slope, 0.0]);
            form
        };
        let cuts = [row(line(1.0), 1.0, 0.0), row(line(-1.0), 1.0, 0.0)];
        let both = minimise(&cuts, &BOX, &[], [0.7, 0.0, 1.0]);
        assert!(both.solved && (both.x[0] - 0.2).abs() < 1e-6);
        assert_relative_eq!(both.multipliers[0], 0.5, epsilon = 1e-6);
        assert_relative_eq!(both.multipliers[1], 0.5, epsilon = 1e-6);
        // x ≤ 0.1 and x ≥ 0.4: by any multipliers that are equal, 0.3 too much.
        let rows = [row(valley(), 1.0, 0.0), row(line(1.0), 0.0, -0.1), row(line(-1.0), 0.0, -0.2)];
        let none = minimise(&rows, &BOX, &[], [0.0, 0.0, 1.0]);
        assert!(!none.solved);
        assert_relative_eq!(none.multipliers[1] / none.multipliers[2], 1.0, epsilon = 1e-3);
    }
}
