//! The conic program in (u, w, t): solved by clarabel with few rows, violated ones added.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::certificate::{balancing_multiplier, lower_bound};
use super::window::minimise;
use super::{
    Certificate, End, GAP_TOLERANCE, Optimum, Outcome, ROW_TOLERANCE, RatioProgram, Row, ShadowPrice, Window, value,
};
use crate::actuator::waveform::Functional;
use crate::requirement::Quantity;

/// Rounds of adding violated rows.
const MAX_ROUNDS: usize = 40;

/// What is minimised, in coefficients of 1/u, 1, u, u²; or the largest of rows.
enum Goal {
    Sum([f64; 4]),
    /// The peak of T² over samples; the rows so far.
    Peak(Vec<Row>),
}

/// What the solver proposes.
struct Proposal {
    u: f64,
    /// Multiplier of each row of the call, then of each peak row.
    rows: Vec<f64>,
    peaks: Vec<f64>,
    status: SolverStatus,
}

pub(super) fn solve(program: &RatioProgram, window: &Window, mut rows: Vec<Row>, low: &End, high: &End) -> Outcome {
    dedup(&mut rows);
    let (start, end) = (window.min * window.min, window.max * window.max);
    let mut goal = goal(program, start, end);
    for _ in 0..MAX_ROUNDS {
        let proposal = match propose(&goal, &rows, low.u, high.u) {
            Ok(proposal) => proposal,
            Err(why) => return Outcome::NotSolved(why),
        };
        match proposal.status {
            SolverStatus::Solved | SolverStatus::AlmostSolved => {}
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => return Outcome::Unbounded,
            // The window has shown that ratios are feasible: the solver is wrong or out of its depth.
            status => return Outcome::NotSolved(format!("the conic solver ended with {status:?}")),
        }
        let u = proposal.u.clamp(low.u, high.u);
        let mut added = false;
        if let Some(row) = program.worst_row(u) {
            // A row that is known already cannot be added again: the solver's own accuracy.
            if row.excess(u) > ROW_TOLERANCE && !contains(&rows, &row) {
                rows.push(row);
                added = true;
            }
        }
        if let Goal::Peak(peaks) = &mut goal {
            let row = peak_row(program, u);
            let known = peaks.iter().map(|r| r.at(u)).fold(0.0, f64::max);
            if row.at(u) > known * (1.0 + 1e-12) && !contains(peaks, &row) {
                peaks.push(row);
                added = true;
            }
        }
        if !added {
            return finish(program, window, &goal, &rows, &proposal, low, high);
        }
    }
    Outcome::NotSolved(format!("violated rows were still found after {MAX_ROUNDS} rounds"))
}

fn contains(rows: &[Row], row: &Row) -> bool {
    rows.iter().any(|r| r.asked == row.asked && r.coefficients == row.coefficients)
}

fn dedup(rows: &mut Vec<Row>) {
    let mut unique: Vec<Row> = Vec::with_capacity(rows.len());
    for row in rows.iter() {
        if !contains(&unique, row) {
            unique.push(*row);
        }
    }
    *rows = unique;
}

fn goal(program: &RatioProgram, start: f64, end: f64) -> Goal {
    let objective = program.objective;
    if objective.sole() == Some(Quantity::PeakCurrent) {
        let mut peaks: Vec<Row> = [start, (start * end).sqrt(), end].iter().map(|u| peak_row(program, *u)).collect();
        dedup(&mut peaks);
        return Goal::Peak(peaks);
    }
    let loss = program.prepared.loss().in_square();
    let mut sum = loss.map(|c| c * objective.weight(Quantity::Loss));
    sum[2] += objective.weight(Quantity::ReflectedInertia) * program.prepared.candidate.actuator.inertia;
    // A mass that does not depend on the ratio is a constant.
    let mass = objective.weight(Quantity::Mass);
    if mass > 0.0 {
        sum[1] += mass * program.prepared.candidate.mass_at(start.sqrt()).unwrap_or(f64::NAN);
    }
    Goal::Sum(sum)
}

fn peak_row(program: &RatioProgram, u: f64) -> Row {
    let candidate = &program.prepared.candidate;
    let waveform = &candidate.load.waveform;
    let point = waveform.point(waveform.largest(Functional::TorqueSquared, &candidate.actuator, u.sqrt()).index);
    let polynomial = candidate.actuator.torque_squared(point.flow, &point.features);
    Row { asked: usize::MAX, sample: Some(point.origin), coefficients: polynomial.in_square(), bound: 0.0 }
}

/// Solves the program with the given rows. Variables are `u/u0`, `w u0`, `t/u0²` and, for a peak,
/// its value over a reference; rows have unit norm.
fn propose(goal: &Goal, rows: &[Row], low: f64, high: f64) -> Result<Proposal, String> {
    let u0 = (low * high).sqrt();
    let scale = [1.0 / u0, 1.0, u0, u0 * u0];
    let scaled = |c: &[f64; 4]| -> [f64; 4] { std::array::from_fn(|i| c[i] * scale[i]) };
    let peaks: &[Row] = match goal {
        Goal::Sum(_) => &[],
        Goal::Peak(peaks) => peaks,
    };
    // Columns: u, w, t, peak.
    let columns = 4;
    let mut a: Vec<[f64; 4]> = Vec::new();
    let mut b: Vec<f64> = Vec::new();
    let mut norms: Vec<f64> = Vec::new();
    let mut push_row = |coefficients: [f64; 4], peak: f64, bound: f64| {
        let line = [coefficients[2], coefficients[0], coefficients[3], -peak];
        let right = bound - coefficients[1];
        let norm = line.iter().map(|x| x * x).sum::<f64>().sqrt();
        let norm = if norm > 0.0 { norm } else { 1.0 };
        a.push(line.map(|x| x / norm));
        b.push(right / norm);
        norms.push(norm);
    };
    for row in rows {
        push_row(scaled(&row.coefficients), 0.0, row.bound);
    }
    let reference = peaks.iter().map(|r| r.at(u0)).fold(f64::MIN_POSITIVE, f64::max);
    for row in peaks {
        push_row(scaled(&row.coefficients), reference, 0.0);
    }
    a.push([1.0, 0.0, 0.0, 0.0]);
    b.push(high / u0);
    a.push([-1.0, 0.0, 0.0, 0.0]);
    b.push(-low / u0);
    let linear = a.len();
    // u w ≥ 1: (u + w, u − w, 2) in the second-order cone.
    a.extend([[-1.0, -1.0, 0.0, 0.0], [-1.0, 1.0, 0.0, 0.0], [0.0; 4]]);
    b.extend([0.0, 0.0, 2.0]);
    // t ≥ u²: (t + 1, t − 1, 2 u).
    a.extend([[0.0, 0.0, -1.0, 0.0], [0.0, 0.0, -1.0, 0.0], [-2.0, 0.0, 0.0, 0.0]]);
    b.extend([1.0, -1.0, 0.0]);
    let (mut q, offset_free_size) = match goal {
        Goal::Sum(c) => {
            let c = scaled(c);
            ([c[2], c[0], c[3], 0.0], value(&c, 1.0).abs().max(c[0].abs() + c[2].abs() + c[3].abs()))
        }
        Goal::Peak(_) => ([0.0, 0.0, 0.0, 1.0], 1.0),
    };
    let size = if offset_free_size > 0.0 { offset_free_size } else { 1.0 };
    q = q.map(|x| x / size);
    if a.iter().flatten().chain(&b).chain(&q).any(|x| !x.is_finite()) {
        return Err("the program has coefficients that are not finite numbers".into());
    }
    // A variable that occurs in no row and no objective is pinned by its cone alone; the peak has no
    // cone, so it is held at zero where it is not used.
    let mut cones = vec![
        SupportedConeT::NonnegativeConeT(linear),
        SupportedConeT::SecondOrderConeT(3),
        SupportedConeT::SecondOrderConeT(3),
    ];
    if peaks.is_empty() {
        a.push([0.0, 0.0, 0.0, 1.0]);
        b.push(0.0);
        cones.push(SupportedConeT::ZeroConeT(1));
    }
    let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    let p = CscMatrix::zeros((columns, columns));
    let matrix = CscMatrix::from(a.as_slice());
    let mut solver = DefaultSolver::new(&p, &q, &matrix, &b, &cones, settings)
        .map_err(|e| format!("the conic solver refused the program: {e:?}"))?;
    solver.solve();
    let solution = &solver.solution;
    let multiplier = |i: usize, objective: f64| solution.z[i] * objective / norms[i];
    Ok(Proposal {
        u: solution.x[0] * u0,
        rows: (0..rows.len()).map(|i| multiplier(i, if peaks.is_empty() { size } else { reference })).collect(),
        peaks: (0..peaks.len()).map(|i| multiplier(rows.len() + i, reference)).collect(),
        status: solution.status,
    })
}

/// Verifies the proposal without the solver, and makes the certificate and the shadow prices.
fn finish(
    program: &RatioProgram,
    window: &Window,
    goal: &Goal,
    rows: &[Row],
    proposal: &Proposal,
    low: &End,
    high: &End,
) -> Outcome {
    let (start, end) = (window.min * window.min, window.max * window.max);
    let torque_constant = program.prepared.candidate.actuator.torque_constant;
    let multipliers: Vec<(Row, f64)> = rows.iter().copied().zip(proposal.rows.iter().copied()).collect();
    // A peak is bounded, and its gap measured, by its square: the objective's own scale of convexity.
    let (u, best, bound, size) = match goal {
        Goal::Sum(f) => {
            // The window is exact, and the objective is convex: the proposal is sharpened within it.
            let u = minimise(f, start, end);
            let proposed = lower_bound(f, &multipliers, low.u, high.u);
            let balanced = balanced_bound(f, rows, u, low.u, high.u);
            (u, value(f, u), proposed.max(balanced), value(&f.map(f64::abs), u))
        }
        Goal::Peak(peaks) => {
            let u = sharpen_peak(program, proposal.u.clamp(start, end), start, end);
            let total: f64 = proposal.peaks.iter().map(|m| m.max(0.0)).sum();
            let weighted = peaks.iter().copied().zip(proposal.peaks.iter().map(|m| m.max(0.0) / total));
            let limits = multipliers.iter().map(|(row, m)| (*row, m / total));
            let all: Vec<(Row, f64)> = weighted.chain(limits).collect();
            let size = peaks.iter().map(|r| value(&r.coefficients.map(f64::abs), u)).fold(0.0, f64::max);
            (u, peak_row(program, u).at(u).max(0.0), lower_bound(&[0.0; 4], &all, low.u, high.u).max(0.0), size)
        }
    };
    if !(u.is_finite() && best.is_finite() && bound.is_finite()) {
        return Outcome::NotSolved("the solution is not a finite number".into());
    }
    if program.worst_row(u).is_some_and(|row| row.excess(u) > 1e-8) {
        return Outcome::NotSolved("the solution breaks a limit".into());
    }
    // An objective that vanishes because its terms cancel has no relative gap: it is measured against
    // its terms.
    let reference = best.abs().max(1e-6 * size).max(f64::MIN_POSITIVE);
    let gap = if best <= bound { 0.0 } else { (best - bound) / reference };
    if gap > GAP_TOLERANCE {
        return Outcome::NotSolved(format!("the duality gap is {gap:.1e}"));
    }
    let natural = |x: f64| if matches!(goal, Goal::Peak(_)) { x.sqrt() / torque_constant } else { x };
    let (best, bound) = (natural(best), natural(bound));
    Outcome::Optimal(Optimum {
        ratio: u.sqrt(),
        objective: best,
        windows: vec![window.clone()],
        certificate: Certificate::Certified { lower_bound: bound.min(best), gap, method: "conic duality" },
        shadow_prices: shadow_prices(program, goal, window, rows, u, best, low, high),
    })
}

/// The lowest peak near the proposal: the largest of convex rows has one valley.
fn sharpen_peak(program: &RatioProgram, u: f64, start: f64, end: f64) -> f64 {
    let peak = |u: f64| peak_row(program, u).at(u);
    let found = super::scan::golden(&peak, (u * 0.999).max(start), (u * 1.001).min(end));
    if peak(found) < peak(u) { found } else { u }
}

/// Lower bound with the one multiplier that balances the objective at u, over the rows that bind.
fn balanced_bound(f: &[f64; 4], rows: &[Row], u: f64, low: f64, high: f64) -> f64 {
    let free = lower_bound(f, &[], low, high);
    let binding = rows.iter().filter(|r| r.excess(u).abs() < 1e-7);
    binding.map(|r| lower_bound(f, &[(*r, balancing_multiplier(f, r, u))], low, high)).fold(free, f64::max)
}

/// Prices of what binds at N*: `∂f*/∂limit = f'(u) du_end/d(limit)` where N* is the window's end
/// that the limit sets. Inside the window nothing binds, and every price is zero.
#[expect(clippy::too_many_arguments, reason = "the parts of one solution")]
fn shadow_prices(
    program: &RatioProgram,
    goal: &Goal,
    window: &Window,
    rows: &[Row],
    u: f64,
    best: f64,
    low: &End,
    high: &End,
) -> Vec<ShadowPrice> {
    let (start, end) = (window.min * window.min, window.max * window.max);
    let at_start = (u - start).abs() <= 1e-9 * u;
    let at_end = (u - end).abs() <= 1e-9 * u;
    if !at_start && !at_end {
        return Vec::new();
    }
    let slope_at = |side: f64| match goal {
        Goal::Sum(f) => super::slope(f, u),
        Goal::Peak(_) => {
            // One-sided, towards the inside of the window.
            let row = peak_row(program, u * (1.0 + side * 1e-9));
            super::slope(&row.coefficients, u)
                / (2.0 * best * program.prepared.candidate.actuator.torque_constant.powi(2))
        }
    };
    let mut prices: Vec<ShadowPrice> = Vec::new();
    let mut add = |limit: &'static str, price: f64, bound: f64| {
        if price != 0.0 && price.is_finite() && !prices.iter().any(|p| p.limit == limit) {
            prices.push(ShadowPrice { limit, price, elasticity: if best == 0.0 { 0.0 } else { price * bound / best } });
        }
    };
    for (here, side, slope, bind, range_end) in
        [(at_start, 1.0, slope_at(1.0), &window.low, low), (at_end, -1.0, slope_at(-1.0), &window.high, high)]
    {
        // The end matters only where the objective would go on beyond it.
        if !here || slope * side <= 0.0 {
            continue;
        }
        if bind.limit == range_end.bind.limit {
            add(bind.limit, slope * range_end.du_dbound, range_end.bound);
            continue;
        }
        let binding = rows.iter().find(|r| {
            program.prepared.asked[r.asked].limit.name == bind.limit
                && r.sample == bind.sample
                && r.excess(u).abs() < 1e-7
        });
        if let Some(row) = binding {
            let asked = &program.prepared.asked[row.asked];
            let raw_per_bound =
                if asked.squared { 2.0 * asked.bound / asked.factor.powi(2) } else { 1.0 / asked.factor };
            add(bind.limit, slope * raw_per_bound / super::slope(&row.coefficients, u), asked.bound);
        }
    }
    prices
}
