//! The conic program in (u, w, t): solved by clarabel with few rows, violated ones added.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::certificate::{balancing_multiplier, lower_bound};
use super::objective::Goal;
use super::window::minimise;
use super::{
    Certificate, End, GAP_TOLERANCE, Optimum, Outcome, ROW_TOLERANCE, RatioProgram, Refusal, Row, Unsolved, Window,
    prices, value,
};
use gearwise_model::numerics::line_search::{FULLY, golden_section, least_in_range};

/// Rounds of adding violated rows and cuts.
const MAX_ROUNDS: usize = 60;

/// What the solver proposes.
struct Proposal {
    u: f64,
    /// Multiplier of each row, and of each cut of the objective.
    rows: Vec<f64>,
    cuts: Vec<f64>,
}

pub(super) fn solve(program: &RatioProgram, window: &Window, mut rows: Vec<Row>, low: &End, high: &End) -> Outcome {
    dedup(&mut rows);
    let goal = Goal::new(program);
    let cut = |u: f64| goal.cut(u.sqrt()).in_square();
    let (start, end) = (window.min * window.min, window.max * window.max);
    let mut cuts: Vec<[f64; 4]> = Vec::new();
    for u in [start, (start * end).sqrt(), end] {
        add(&mut cuts, cut(u));
    }
    // A row that neither end of the range breaks cannot bind in between: left out, its slack cannot spoil
    // the solver's scaling.
    rows.retain(|row| row.excess(low.u()) > 0.0 || row.excess(high.u()) > 0.0);
    for _ in 0..MAX_ROUNDS {
        // A solver out of its depth is no verdict: the window is exact, and one ratio needs no solver.
        let Some(proposal) = propose(&cuts, &rows, low.u(), high.u()) else { break };
        let u = proposal.u.clamp(low.u(), high.u());
        let mut added = false;
        // A row that is known already cannot be added again: the solver's own accuracy.
        let new = |r: &Row| r.excess(u) > ROW_TOLERANCE && !contains(&rows, r);
        if let Some(row) = program.worst_row(u).filter(new) {
            rows.push(row);
            added = true;
        }
        let here = cut(u);
        let known = cuts.iter().map(|c| value(c, u)).fold(f64::NEG_INFINITY, f64::max);
        if value(&here, u) > known + 1e-12 * known.abs() {
            added |= add(&mut cuts, here);
        }
        if !added {
            if let Ok(optimum) = finish(program, window, &goal, &cuts, &rows, Some(&proposal), low, high) {
                return Ok(optimum);
            }
            break;
        }
    }
    match finish(program, window, &goal, &cuts, &rows, None, low, high) {
        Ok(optimum) => Ok(optimum),
        // The branch and bound needs no multipliers at all.
        Err(why) => match super::branch::solve(program, "the bounds did not meet") {
            Err(Refusal::NotSolved(_)) => Err(Refusal::NotSolved(why)),
            other => other,
        },
    }
}

/// Adds a cut that is not known yet; whether it was new.
fn add(cuts: &mut Vec<[f64; 4]>, cut: [f64; 4]) -> bool {
    let new = !cuts.contains(&cut);
    if new {
        cuts.push(cut);
    }
    new
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

/// Solves the program with the given rows and cuts. Variables are `u/u0`, `w u0`, `t/u0²` and the
/// objective over a reference; rows have unit norm.
fn propose(cuts: &[[f64; 4]], rows: &[Row], low: f64, high: f64) -> Option<Proposal> {
    let u0 = (low * high).sqrt();
    let scale = [1.0 / u0, 1.0, u0, u0 * u0];
    let scaled = |c: &[f64; 4]| -> [f64; 4] { std::array::from_fn(|i| c[i] * scale[i]) };
    let mut a: Vec<[f64; 4]> = Vec::new();
    let mut b: Vec<f64> = Vec::new();
    let mut norms: Vec<f64> = Vec::new();
    let mut push_row = |coefficients: [f64; 4], objective: f64, bound: f64| {
        let line = [coefficients[2], coefficients[0], coefficients[3], -objective];
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
    let size = cuts.iter().map(|c| value(&scaled(c).map(f64::abs), 1.0)).fold(0.0, f64::max);
    let reference = if size > 0.0 { size } else { 1.0 };
    for cut in cuts {
        push_row(scaled(cut), reference, 0.0);
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
    let q = [0.0, 0.0, 0.0, 1.0];
    if a.iter().flatten().chain(&b).any(|x| !x.is_finite()) {
        return None;
    }
    let cones = [
        SupportedConeT::NonnegativeConeT(linear),
        SupportedConeT::SecondOrderConeT(3),
        SupportedConeT::SecondOrderConeT(3),
    ];
    let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
    let p = CscMatrix::zeros((4, 4));
    let matrix = CscMatrix::from(a.as_slice());
    let mut solver = DefaultSolver::new(&p, &q, &matrix, &b, &cones, settings).ok()?;
    solver.solve();
    let solution = &solver.solution;
    if !matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
        return None;
    }
    let multiplier = |i: usize| solution.z[i] * reference / norms[i];
    Some(Proposal {
        u: solution.x[0] * u0,
        rows: (0..rows.len()).map(multiplier).collect(),
        cuts: (0..cuts.len()).map(|i| multiplier(rows.len() + i)).collect(),
    })
}

/// Verifies the proposal without the solver, and makes the certificate and the shadow prices. Without a
/// proposal the multipliers that balance the slopes at the best ratio are taken.
///
/// # Errors
/// What could not be verified.
#[expect(clippy::too_many_arguments, reason = "the parts of one solution")]
fn finish(
    program: &RatioProgram,
    window: &Window,
    goal: &Goal,
    cuts: &[[f64; 4]],
    rows: &[Row],
    proposal: Option<&Proposal>,
    low: &End,
    high: &End,
) -> Result<Optimum, Unsolved> {
    let (start, end) = (window.min * window.min, window.max * window.max);
    // The window is exact and the objective convex: the proposal is sharpened within it.
    let u = match (cuts, proposal) {
        ([only], _) => minimise(only, start, end),
        (_, Some(proposal)) => sharpen(goal, proposal.u.clamp(start, end), start, end),
        (_, None) => lowest(goal, start, end),
    };
    let best = goal.value(u.sqrt());
    let mut bound = f64::NEG_INFINITY;
    let mut combinations = vec![balanced_cuts(goal, u)];
    if let Some(proposal) = proposal {
        // A convex combination of cuts, plus multipliers of rows.
        let total: f64 = proposal.cuts.iter().map(|m| m.max(0.0)).sum();
        let single = cuts.len() == 1;
        let mut combined = [0.0; 4];
        for (cut, multiplier) in cuts.iter().zip(&proposal.cuts) {
            let share = if single { 1.0 } else { multiplier.max(0.0) / total };
            for (sum, c) in combined.iter_mut().zip(cut) {
                *sum += share * c;
            }
        }
        let share = if single { 1.0 } else { 1.0 / total };
        let multipliers: Vec<(Row, f64)> = rows.iter().copied().zip(proposal.rows.iter().map(|m| m * share)).collect();
        bound = bound.max(lower_bound(&combined, &multipliers, low.u(), high.u()));
        combinations.push(combined);
    }
    for combination in combinations {
        bound = bound.max(balanced_bound(&combination, rows, u, low.u(), high.u()));
    }
    if !(u.is_finite() && best.is_finite() && bound.is_finite()) {
        return Err(Unsolved::NotFinite);
    }
    if program.worst_row(u).is_some_and(|row| row.excess(u) > 1e-8) {
        return Err(Unsolved::BreaksLimit);
    }
    // An objective that vanishes because its terms cancel has no relative gap: it is measured against
    // its terms.
    let size = cuts.iter().map(|c| value(&c.map(f64::abs), u)).fold(0.0, f64::max);
    let reference = best.abs().max(1e-6 * size).max(f64::MIN_POSITIVE);
    let gap = if best <= bound { 0.0 } else { (best - bound) / reference };
    if gap > GAP_TOLERANCE {
        return Err(Unsolved::Gap(gap));
    }
    let windows = vec![window.clone()];
    Ok(Optimum {
        ratio: u.sqrt(),
        objective: goal.natural(best),
        certificate: Certificate::Certified {
            lower_bound: goal.natural(bound.min(best)),
            gap,
            method: "conic duality",
        },
        shadow_prices: prices::at(program, goal, &windows, u.sqrt(), low, high),
        windows,
    })
}

/// The least value in the window, without a proposal: the valley of a convex objective.
fn lowest(goal: &Goal, start: f64, end: f64) -> f64 {
    least_in_range(&|u: f64| goal.value(u.sqrt()), start, end)
}

/// The least value near the proposal: a convex objective has one valley. Where it goes on falling at the edge of what
/// is near, more is.
fn sharpen(goal: &Goal, u: f64, start: f64, end: f64) -> f64 {
    let at = |u: f64| goal.value(u.sqrt());
    for near in [1e-3, 1e-2, 1e-1] {
        let (a, b) = ((u * (1.0 - near)).max(start), (u * (1.0 + near)).min(end));
        let found = golden_section(&at, a, b, FULLY);
        let edge = 1e-3 * (b - a);
        let falls_on = (found - a < edge && a > start) || (b - found < edge && b < end);
        if !falls_on {
            return if at(found) < at(u) { found } else { u };
        }
    }
    let found = lowest(goal, start, end);
    if at(found) < at(u) { found } else { u }
}

/// The combination of the cuts on either side of u whose slopes cancel there; where they do not, the cut
/// at u itself.
fn balanced_cuts(goal: &Goal, u: f64) -> [f64; 4] {
    let cut = |u: f64| goal.cut(u.sqrt()).in_square();
    let (left, right) = (cut(u * (1.0 - 1e-9)), cut(u * (1.0 + 1e-9)));
    let (falling, rising) = (super::slope(&left, u), super::slope(&right, u));
    if falling < 0.0 && rising > 0.0 {
        let share = rising / (rising - falling);
        return std::array::from_fn(|i| share * left[i] + (1.0 - share) * right[i]);
    }
    cut(u)
}

/// Lower bound with the one multiplier that balances the objective at u, over the rows that bind.
fn balanced_bound(f: &[f64; 4], rows: &[Row], u: f64, low: f64, high: f64) -> f64 {
    let free = lower_bound(f, &[], low, high);
    let binding = rows.iter().filter(|r| r.excess(u).abs() < 1e-7);
    binding.map(|r| lower_bound(f, &[(*r, balancing_multiplier(f, r, u))], low, high)).fold(free, f64::max)
}

#[cfg(test)]
mod tests;
