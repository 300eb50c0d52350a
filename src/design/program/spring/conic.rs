//! A convex program over a region: clarabel proposes, a bound without the solver disposes.
//!
//! Every cut and row is a `Form`. For any weights λ ≥ 0 (of cuts, summing to one) and μ ≥ 0 (of rows)
//! the sum `Σ λ F + Σ μ (G − b)` is convex, its tangent plane at any point lies below it, and a plane is
//! least at a corner of the region: a lower bound on the objective whatever the solver did.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, SymmetricEigen};

use super::form::{Form, Point};
use super::region::Region;

/// Limits are kept with this much to spare (relative) by what the solver proposes, so that its own
/// accuracy does not break them. The bound is taken at the limits themselves.
const TIGHTER: f64 = 2e-8;

/// A row: `form ≤ bound`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    pub(super) form: Form,
    pub(super) bound: f64,
}

/// What the solver proposes.
#[derive(Debug, Clone)]
pub(super) struct Proposal {
    pub(super) z: Point,
    /// Lower bound of the largest of the cuts over the region, under the rows.
    pub(super) bound: f64,
    /// Whether each row has weight in the bound.
    pub(super) active: Vec<bool>,
}

/// The lower bound with weights, by the tangent plane at a point.
fn lower_bound(region: &Region, parts: &[(&Form, f64, f64)], z: Point) -> f64 {
    let (mut value, mut size, mut gradient) = (0.0, 0.0, [0.0; 3]);
    for (form, bound, weight) in parts.iter().filter(|p| p.2 > 0.0) {
        value += weight * (form.at(z) - bound);
        size += weight * (form.size(z) + bound.abs());
        for (sum, g) in gradient.iter_mut().zip(form.gradient(z)) {
            *sum += weight * g;
        }
    }
    let u = region.ratio.map(|n| n * n);
    let over_u = (gradient[0] * (u[0] - z[0])).min(gradient[0] * (u[1] - z[0]));
    let spring = region.corners.iter().map(|(k, s)| gradient[1] * (k - z[1]) + gradient[2] * (s - z[2]));
    // What rounding may have added is taken off again.
    value + over_u + spring.fold(f64::INFINITY, f64::min) - 8.0 * f64::EPSILON * size
}

/// One equation or inequality of the solver's program, in its scaled variables.
#[derive(Default)]
struct Lines {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
    right: Vec<f64>,
}

impl Lines {
    /// Adds the line `Σ value x ≤ right` (or its cone's).
    fn push(&mut self, entries: &[(usize, f64)], right: f64) {
        for (column, value) in entries.iter().filter(|e| e.1 != 0.0) {
            self.rows.push(self.right.len());
            self.columns.push(*column);
            self.values.push(*value);
        }
        self.right.push(right);
    }
}

/// Scaled variables: `k = k_c + k_r x`, `s = s_c + s_r y`, `u = u_0 v`.
struct Scale {
    u0: f64,
    /// Rows: 1, k, s, u; columns: 1, x, y, v.
    map: [[f64; 4]; 4],
}

impl Scale {
    fn new(region: &Region) -> Scale {
        let half = |a: f64, b: f64| if b > a { 0.5 * (b - a) } else { 1.0 };
        let [k0, k1] = region.stiffness();
        let (s0, s1) = region.corners.iter().fold((f64::MAX, f64::MIN), |(l, h), c| (l.min(c.1), h.max(c.1)));
        let u0 = region.ratio[0] * region.ratio[1];
        let map = [
            [1.0, 0.0, 0.0, 0.0],
            [0.5 * (k0 + k1), half(k0, k1), 0.0, 0.0],
            [0.5 * (s0 + s1), 0.0, half(s0, s1), 0.0],
            [0.0, 0.0, 0.0, u0],
        ];
        Scale { u0, map }
    }

    /// The matrix in scaled variables.
    fn quadratic<const D: usize>(&self, matrix: &[[f64; D]; D]) -> [[f64; D]; D] {
        let m = &self.map;
        std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                (0..D).flat_map(|a| (0..D).map(move |b| (a, b))).map(|(a, b)| m[a][i] * matrix[a][b] * m[b][j]).sum()
            })
        })
    }

    fn linear(&self, l: &[f64; 4]) -> [f64; 4] {
        std::array::from_fn(|j| (0..4).map(|i| l[i] * self.map[i][j]).sum())
    }

    fn point(&self, x: &[f64]) -> Point {
        let m = &self.map;
        [m[3][3] * x[2], m[1][0] + m[1][1] * x[0], m[2][0] + m[2][2] * x[1]]
    }
}

/// Rows C with `CᵀC` the matrix, as far as it counts.
fn factor<const D: usize>(matrix: &[[f64; D]; D]) -> Vec<[f64; D]> {
    let size = matrix.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
    if size == 0.0 {
        return Vec::new();
    }
    let eigen = SymmetricEigen::new(DMatrix::from_fn(D, D, |i, j| matrix[i][j] / size));
    let kept = (0..D).filter(|i| eigen.eigenvalues[*i] > 1e-15);
    let row = |i: usize| {
        let root = (eigen.eigenvalues[i] * size).sqrt();
        std::array::from_fn(|j| root * eigen.eigenvectors[(j, i)])
    };
    kept.map(row).collect()
}

/// Columns of the solver's variables: k, s, u, objective; each form's own follow.
const X: usize = 0;
const V: usize = 2;
const GOAL: usize = 3;

/// Minimises the largest of the cuts over the region under the rows. `None` where the solver has nothing
/// that can be used (also where no point keeps the rows).
pub(super) fn propose(region: &Region, cuts: &[Form], rows: &[Row]) -> Option<Proposal> {
    let scale = Scale::new(region);
    let middle = region.middle();
    let size = cuts.iter().map(|c| c.at(middle).abs().max(1e-3 * c.size(middle))).fold(0.0, f64::max);
    let reference = if size > 0.0 { size } else { 1.0 };
    let (mut inequalities, mut cone_lines, mut cones) = (Lines::default(), Lines::default(), Vec::new());
    let mut equalities = Lines::default();
    let mut variables = GOAL + 1;
    let mut norms = Vec::new();
    let parts = cuts.iter().map(|c| (c, None)).chain(rows.iter().map(|r| (&r.form, Some(r.bound))));
    for (form, bound) in parts {
        let linear = scale.linear(&form.linear);
        let over_u = scale.quadratic(&form.over_u).map(|row| row.map(|x| x / scale.u0));
        let square = scale.quadratic(&form.square);
        let largest = linear.iter().chain(over_u.iter().flatten()).chain(square.iter().flatten());
        let norm = largest.fold(bound.map_or(reference, f64::abs), |a, x| a.max(x.abs()));
        let norm = if norm > 0.0 { norm } else { 1.0 };
        norms.push(norm);
        let right = bound.map_or(0.0, |b| b - TIGHTER * b.abs()) - linear[0];
        let mut line: Vec<(usize, f64)> = (1..4).map(|i| (X + i - 1, linear[i] / norm)).collect();
        if bound.is_none() {
            line.push((GOAL, -reference / norm));
        }
        let entries = |p: &[f64]| -> Vec<(usize, f64)> {
            p[1..].iter().enumerate().map(|(i, x)| (X + i, -2.0 * x / norm.sqrt())).collect()
        };
        let factors = factor(&over_u);
        if !factors.is_empty() {
            // ‖C x‖² ≤ α v.
            let alpha = variables;
            variables += 1;
            line.push((alpha, 1.0));
            cone_lines.push(&[(alpha, -1.0), (V, -1.0)], 0.0);
            cone_lines.push(&[(alpha, -1.0), (V, 1.0)], 0.0);
            for c in &factors {
                cone_lines.push(&entries(c), 2.0 * c[0] / norm.sqrt());
            }
            cones.push(SupportedConeT::SecondOrderConeT(2 + factors.len()));
        }
        let factors = factor(&square);
        if !factors.is_empty() {
            // ‖E y‖² ≤ β.
            let beta = variables;
            variables += 1;
            line.push((beta, 1.0));
            cone_lines.push(&[(beta, -1.0)], 1.0);
            cone_lines.push(&[(beta, -1.0)], -1.0);
            for e in &factors {
                cone_lines.push(&entries(e), 2.0 * e[0] / norm.sqrt());
            }
            cones.push(SupportedConeT::SecondOrderConeT(2 + factors.len()));
        }
        inequalities.push(&line, right / norm);
    }
    // The region itself; what it leaves no room for is an equation.
    let [a, b] = region.ratio.map(|n| n * n / scale.u0);
    if b > a {
        inequalities.push(&[(V, 1.0)], b);
        inequalities.push(&[(V, -1.0)], -a);
    } else {
        equalities.push(&[(V, 1.0)], a);
    }
    // `p·(1, k, s) ≥ 0`, each to its own size.
    let edge = |p: &[f64; 3]| {
        let l = scale.linear(&[p[0], p[1], p[2], 0.0]);
        let norm = l.iter().fold(f64::MIN_POSITIVE, |a, x| a.max(x.abs()));
        ([(X, -l[1] / norm), (X + 1, -l[2] / norm)], l[0] / norm)
    };
    for plane in &region.planes {
        let (entries, right) = edge(plane);
        inequalities.push(&entries, right);
    }
    for equation in &region.equations {
        let (entries, right) = edge(equation);
        equalities.push(&entries, right);
    }
    let (first, second) = (equalities.right.len(), inequalities.right.len());
    let mut all = equalities;
    for lines in [inequalities, cone_lines] {
        let offset = all.right.len();
        all.rows.extend(lines.rows.iter().map(|r| r + offset));
        all.columns.extend(lines.columns);
        all.values.extend(lines.values);
        all.right.extend(lines.right);
    }
    if all.values.iter().chain(&all.right).any(|x| !x.is_finite()) {
        return None;
    }
    let mut q = vec![0.0; variables];
    q[GOAL] = 1.0;
    cones.insert(0, SupportedConeT::NonnegativeConeT(second));
    if first > 0 {
        cones.insert(0, SupportedConeT::ZeroConeT(first));
    }
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-10,
        tol_gap_rel: 1e-10,
        tol_feas: 1e-10,
        max_iter: 60,
        ..DefaultSettings::default()
    };
    let p = CscMatrix::zeros((variables, variables));
    let matrix = CscMatrix::new_from_triplets(all.right.len(), variables, all.rows, all.columns, all.values);
    let mut solver = DefaultSolver::new(&p, &q, &matrix, &all.right, &cones, settings).ok()?;
    solver.solve();
    let solution = &solver.solution;
    let infeasible = matches!(
        solution.status,
        SolverStatus::PrimalInfeasible
            | SolverStatus::DualInfeasible
            | SolverStatus::AlmostPrimalInfeasible
            | SolverStatus::AlmostDualInfeasible
    );
    if infeasible || !solution.x.iter().chain(&solution.z).all(|x| x.is_finite()) {
        return None;
    }
    let weight = |i: usize, scale: f64| solution.z[first + i].max(0.0) * scale / norms[i];
    let total: f64 = (0..cuts.len()).map(|i| weight(i, 1.0)).sum();
    let [u, k, s] = scale.point(&solution.x);
    let z = [u.clamp(region.ratio[0].powi(2), region.ratio[1].powi(2)), k, s];
    // Without a usable weight every cut alone still bounds.
    let share = if total > 0.0 { 1.0 / total } else { 0.0 };
    let mut parts: Vec<(&Form, f64, f64)> = Vec::new();
    for (i, cut) in cuts.iter().enumerate() {
        parts.push((cut, 0.0, if total > 0.0 { weight(i, share) } else { f64::from(i == 0) }));
    }
    let mut active = Vec::new();
    for (i, row) in rows.iter().enumerate() {
        let mu = weight(cuts.len() + i, share);
        active.push(mu * row.bound.abs() > 1e-7 * reference);
        parts.push((&row.form, row.bound, mu));
    }
    let mut bound = lower_bound(region, &parts, z);
    if !bound.is_finite() {
        bound = f64::NEG_INFINITY;
    }
    Some(Proposal { z, bound, active })
}
