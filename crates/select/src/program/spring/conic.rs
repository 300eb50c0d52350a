//! A convex program over a region: a solver proposes, a bound without it disposes. The solver is our own small one
//! (`interior`); where that gives up it is clarabel.
//!
//! Every cut and row is a `Form`. For any weights λ ≥ 0 (of cuts, summing to one) and μ ≥ 0 (of rows)
//! the sum `Σ λ F + Σ μ (G − b)` is convex, its tangent plane at any point lies below it, and a plane is
//! least at a corner of the region: a lower bound on the objective whatever the solver did.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, SymmetricEigen};

use super::form::{Form, Point};
use super::interior::{self, Smooth};
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

impl Row {
    /// What its excess is measured by: its bound, or where nothing is allowed the size of its terms.
    pub(super) fn size(&self, region: &Region) -> f64 {
        if self.bound == 0.0 { self.form.size(region.middle()) } else { self.bound.abs() }
    }
}

/// A region on which every point exceeds some row by more than this (relative) holds nothing.
pub(super) const IMPOSSIBLE: f64 = 1e-9;

/// What came of a program.
#[derive(Debug, Clone)]
pub(super) enum Answer {
    /// A point and a bound.
    Found(Proposal),
    /// No point of the region keeps the rows, which the multipliers of the rows show.
    Impossible,
    /// Nothing that can be used.
    Unknown,
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

    /// The scaled variables of a point.
    fn back(&self, [u, k, s]: Point) -> [f64; 3] {
        let m = &self.map;
        [(k - m[1][0]) / m[1][1], (s - m[2][0]) / m[2][2], u / m[3][3]]
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

/// The program in scaled variables, each cut and row to its own size.
struct Scaled {
    scale: Scale,
    /// What the objective is measured by.
    reference: f64,
    /// Of the cuts, then of the rows.
    forms: Vec<Form>,
    norms: Vec<f64>,
    rights: Vec<f64>,
    cuts: usize,
    /// Range of v.
    range: [f64; 2],
    /// `p·(1, x, y) ≥ 0`.
    planes: Vec<[f64; 3]>,
    /// `p·(1, x, y) = 0`.
    equations: Vec<[f64; 3]>,
}

impl Scaled {
    fn new(region: &Region, cuts: &[Form], rows: &[Row]) -> Scaled {
        let scale = Scale::new(region);
        let middle = region.middle();
        let size = cuts.iter().map(|c| c.at(middle).abs().max(1e-3 * c.size(middle))).fold(0.0, f64::max);
        let reference = if size > 0.0 { size } else { 1.0 };
        let (mut forms, mut norms, mut rights) = (Vec::new(), Vec::new(), Vec::new());
        let parts = cuts.iter().map(|c| (c, None)).chain(rows.iter().map(|r| (&r.form, Some(r.bound))));
        for (form, bound) in parts {
            let linear = scale.linear(&form.linear);
            let over_u = scale.quadratic(&form.over_u).map(|row| row.map(|x| x / scale.u0));
            let square = scale.quadratic(&form.square);
            let largest = linear.iter().chain(over_u.iter().flatten()).chain(square.iter().flatten());
            let norm = largest.fold(bound.map_or(reference, f64::abs), |a, x| a.max(x.abs()));
            let norm = if norm > 0.0 { norm } else { 1.0 };
            forms.push(Form {
                over_u: over_u.map(|row| row.map(|x| x / norm)),
                square: square.map(|row| row.map(|x| x / norm)),
                linear: linear.map(|x| x / norm),
            });
            rights.push(bound.map_or(0.0, |b| b - TIGHTER * b.abs()) / norm);
            norms.push(norm);
        }
        // `p·(1, k, s) ≥ 0`, each to its own size.
        let edge = |p: &[f64; 3]| {
            let [c, x, y, _] = scale.linear(&[p[0], p[1], p[2], 0.0]);
            let norm = [c, x, y].iter().fold(f64::MIN_POSITIVE, |a, x| a.max(x.abs()));
            [c / norm, x / norm, y / norm]
        };
        Scaled {
            reference,
            forms,
            norms,
            rights,
            cuts: cuts.len(),
            range: region.ratio.map(|n| n * n / scale.u0),
            planes: region.planes.iter().map(edge).collect(),
            equations: region.equations.iter().map(edge).collect(),
            scale,
        }
    }

    /// The variables and the multipliers of cuts and rows, by the small solver; whether it solved the program.
    fn interior(&self, region: &Region) -> (Point, Vec<f64>, bool) {
        let weight = |i: usize| if i < self.cuts { self.reference / self.norms[i] } else { 0.0 };
        let rows = self.forms.iter().zip(&self.rights).enumerate();
        let rows: Vec<Smooth> =
            rows.map(|(i, (form, right))| Smooth { form: *form, weight: weight(i), right: *right }).collect();
        let mut planes: Vec<[f64; 4]> = self.planes.iter().map(|p| [p[0], p[1], p[2], 0.0]).collect();
        let mut fixed: Vec<[f64; 3]> = Vec::new();
        for [_, x, y] in &self.equations {
            let mut way = [*x, *y, 0.0];
            for f in &fixed {
                let along: f64 = (0..3).map(|i| f[i] * way[i]).sum();
                (0..3).for_each(|i| way[i] -= along * f[i]);
            }
            let length = way.iter().map(|w| w * w).sum::<f64>().sqrt();
            if length > 1e-9 {
                fixed.push(way.map(|w| w / length));
            }
        }
        let [a, b] = self.range;
        if b > a {
            planes.extend([[b, 0.0, 0.0, -1.0], [-a, 0.0, 0.0, 1.0]]);
        } else {
            fixed.push([0.0, 0.0, 1.0]);
        }
        let start = self.scale.back(region.middle());
        let solution = interior::minimise(&rows, &planes, &fixed, start);
        let finite = solution.x.iter().chain(&solution.multipliers).all(|x| x.is_finite());
        (self.scale.point(&solution.x), solution.multipliers[..rows.len()].to_vec(), solution.solved && finite)
    }

    /// The same by clarabel; `None` where it has nothing that can be used.
    fn clarabel(&self) -> Option<(Point, Vec<f64>)> {
        let (mut inequalities, mut cone_lines, mut cones) = (Lines::default(), Lines::default(), Vec::new());
        let mut equalities = Lines::default();
        let mut variables = GOAL + 1;
        for (i, form) in self.forms.iter().enumerate() {
            let right = self.rights[i] - form.linear[0];
            let mut line: Vec<(usize, f64)> = (1..4).map(|i| (X + i - 1, form.linear[i])).collect();
            if i < self.cuts {
                line.push((GOAL, -self.reference / self.norms[i]));
            }
            let entries = |p: &[f64]| -> Vec<(usize, f64)> {
                p[1..].iter().enumerate().map(|(i, x)| (X + i, -2.0 * x)).collect()
            };
            let factors = factor(&form.over_u);
            if !factors.is_empty() {
                // ‖C x‖² ≤ α v.
                let alpha = variables;
                variables += 1;
                line.push((alpha, 1.0));
                cone_lines.push(&[(alpha, -1.0), (V, -1.0)], 0.0);
                cone_lines.push(&[(alpha, -1.0), (V, 1.0)], 0.0);
                for c in &factors {
                    cone_lines.push(&entries(c), 2.0 * c[0]);
                }
                cones.push(SupportedConeT::SecondOrderConeT(2 + factors.len()));
            }
            let factors = factor(&form.square);
            if !factors.is_empty() {
                // ‖E y‖² ≤ β.
                let beta = variables;
                variables += 1;
                line.push((beta, 1.0));
                cone_lines.push(&[(beta, -1.0)], 1.0);
                cone_lines.push(&[(beta, -1.0)], -1.0);
                for e in &factors {
                    cone_lines.push(&entries(e), 2.0 * e[0]);
                }
                cones.push(SupportedConeT::SecondOrderConeT(2 + factors.len()));
            }
            inequalities.push(&line, right);
        }
        // The region itself; what it leaves no room for is an equation.
        let [a, b] = self.range;
        if b > a {
            inequalities.push(&[(V, 1.0)], b);
            inequalities.push(&[(V, -1.0)], -a);
        } else {
            equalities.push(&[(V, 1.0)], a);
        }
        for [c, x, y] in &self.planes {
            inequalities.push(&[(X, -x), (X + 1, -y)], *c);
        }
        for [c, x, y] in &self.equations {
            equalities.push(&[(X, -x), (X + 1, -y)], *c);
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
        Some((self.scale.point(&solution.x), solution.z[first..first + self.forms.len()].to_vec()))
    }
}

/// Minimises the largest of the cuts over the region under the rows.
pub(super) fn propose(region: &Region, cuts: &[Form], rows: &[Row]) -> Answer {
    let scaled = Scaled::new(region, cuts, rows);
    let (z, multipliers, solved) = scaled.interior(region);
    if solved {
        return Answer::Found(proposal(region, cuts, rows, &scaled, z, &multipliers));
    }
    if is_impossible(region, rows, &scaled, z, &multipliers) {
        return Answer::Impossible;
    }
    match scaled.clarabel() {
        Some((z, multipliers)) => Answer::Found(proposal(region, cuts, rows, &scaled, z, &multipliers)),
        None => Answer::Unknown,
    }
}

/// Whether the rows, weighted by their multipliers, are exceeded at every point of the region.
fn is_impossible(region: &Region, rows: &[Row], scaled: &Scaled, [u, k, s]: Point, multipliers: &[f64]) -> bool {
    let cuts = scaled.cuts;
    let z = [u.clamp(region.ratio[0].powi(2), region.ratio[1].powi(2)), k, s];
    let weight = |i: usize| multipliers[cuts + i].max(0.0) / scaled.norms[cuts + i];
    let total: f64 = rows.iter().enumerate().map(|(i, row)| weight(i) * row.size(region)).sum();
    if rows.is_empty() || !(total > 0.0 && total.is_finite()) {
        return false;
    }
    let parts: Vec<(&Form, f64, f64)> =
        rows.iter().enumerate().map(|(i, row)| (&row.form, row.bound, weight(i) / total)).collect();
    lower_bound(region, &parts, z) > IMPOSSIBLE
}

/// The point with the bound that its multipliers give.
fn proposal(
    region: &Region,
    cuts: &[Form],
    rows: &[Row],
    scaled: &Scaled,
    [u, k, s]: Point,
    multipliers: &[f64],
) -> Proposal {
    let weight = |i: usize, scale: f64| multipliers[i].max(0.0) * scale / scaled.norms[i];
    let total: f64 = (0..cuts.len()).map(|i| weight(i, 1.0)).sum();
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
        active.push(mu * row.bound.abs() > 1e-7 * scaled.reference);
        parts.push((&row.form, row.bound, mu));
    }
    let mut bound = lower_bound(region, &parts, z);
    if !bound.is_finite() {
        bound = f64::NEG_INFINITY;
    }
    Proposal { z, bound, active }
}
