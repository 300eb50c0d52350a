//! The feasible ratios, from the rows themselves and without a solver.
//!
//! Every row leaves an interval of u. From the lower end of the range we jump to the start of the
//! interval of the most violated row, until no row is violated: the start of the window. The same
//! from above. Where a jump leads backwards, or a row leaves nothing, two rows (or one) prove that
//! no ratio is feasible.

use super::{Bind, End, Infeasible, ROW_TOLERANCE, RatioProgram, Refusal, Row, Unsolved, Window, slope};

/// More jumps than any set of rows has been seen to need.
const MAX_JUMPS: usize = 500;

/// Finds the window, and the rows met on the way.
pub(super) fn find(program: &RatioProgram, low: &End, high: &End) -> Result<(Window, Vec<Row>), Refusal> {
    let mut rows: Vec<Row> = Vec::new();
    let start = walk(program, low, high, true, &mut rows)?;
    let end = walk(program, low, high, false, &mut rows)?;
    let window = Window { min: start.0.sqrt(), max: end.0.max(start.0).sqrt(), low: start.1, high: end.1 };
    Ok((window, rows))
}

/// Walks inwards from one end of the range; gives the end of the window and what binds there.
fn walk(
    program: &RatioProgram,
    low: &End,
    high: &End,
    upwards: bool,
    rows: &mut Vec<Row>,
) -> Result<(f64, Bind), Refusal> {
    // What a row leaves is judged over the requirement's whole range, so that a row is blamed alone
    // only where no ratio at all would keep it.
    let (first, last) = (program.range.0.powi(2), program.range.1.powi(2));
    let contradiction = |low: Bind, at_least: f64, high: Bind, at_most: f64| {
        Refusal::Infeasible(Infeasible::Contradiction { low, at_least: at_least.sqrt(), high, at_most: at_most.sqrt() })
    };
    let from = if upwards { low } else { high };
    let (mut u, mut bind) = (from.u(), from.bind.clone());
    for _ in 0..MAX_JUMPS {
        let Some(row) = program.worst_row(u) else { break };
        rows.push(row);
        if row.excess(u) <= ROW_TOLERANCE {
            break;
        }
        let here = program.bind(&row);
        let Some((start, end)) = interval(&row, first, last) else {
            return Err(Refusal::Infeasible(program.never(row.asked)));
        };
        // A row that is violated here and lies behind us contradicts the one that brought us here.
        if upwards && end <= u {
            return Err(contradiction(bind, u, here, end));
        }
        if !upwards && start >= u {
            return Err(contradiction(here, start, bind, u));
        }
        u = if upwards { start } else { end };
        if u > high.u() * (1.0 + ROW_TOLERANCE) {
            return Err(contradiction(here, u, high.bind.clone(), high.u()));
        }
        if u < low.u() * (1.0 - ROW_TOLERANCE) {
            return Err(contradiction(low.bind.clone(), low.u(), here, u));
        }
        bind = here;
    }
    if program.worst_row(u).is_some_and(|row| row.excess(u) > 100.0 * ROW_TOLERANCE) {
        return Err(Refusal::NotSolved(Unsolved::NoWindow(MAX_JUMPS)));
    }
    Ok((u.clamp(low.u(), high.u()), bind))
}

/// Where `slope` of the row is zero, kept within the range: the row's least value there.
pub(super) fn minimum(row: &Row, low: f64, high: f64) -> f64 {
    minimise(&row.coefficients, low, high)
}

/// The u in the range at which a convex `c_w/u + c_0 + c_u u + c_t u²` is least.
pub(crate) fn minimise(c: &[f64; 4], low: f64, high: f64) -> f64 {
    if slope(c, low) >= 0.0 {
        return low;
    }
    if slope(c, high) <= 0.0 {
        return high;
    }
    // The slope increases: bisection in ln u, finished by Newton's steps kept in the bracket.
    let (mut a, mut b) = (low, high);
    let mut u = (a * b).sqrt();
    for _ in 0..200 {
        let g = slope(c, u);
        if g < 0.0 {
            a = u;
        } else {
            b = u;
        }
        let curvature = 2.0 * c[0] / u.powi(3) + 2.0 * c[3];
        let newton = u - g / curvature;
        let next = if newton > a && newton < b { newton } else { (a * b).sqrt() };
        if (next - u).abs() <= 1e-15 * u || (b - a) <= 1e-15 * b {
            return next;
        }
        u = next;
    }
    u
}

/// The interval of u within `[low, high]` on which the row holds.
fn interval(row: &Row, low: f64, high: f64) -> Option<(f64, f64)> {
    let least = minimum(row, low, high);
    if row.excess(least) > ROW_TOLERANCE {
        return None;
    }
    let end = |outside: f64| if row.excess(outside) <= 0.0 { outside } else { root(row, outside, least) };
    Some((end(low), end(high)))
}

/// The u between `outside` (row violated) and `inside` (row kept) at which the row is met with
/// equality, from the inside.
fn root(row: &Row, outside: f64, inside: f64) -> f64 {
    let (mut bad, mut good) = (outside, inside);
    let mut u = bad;
    for _ in 0..200 {
        // Newton from the violated side stays on it, for a convex row.
        let g = row.at(u) - row.bound;
        if g > 0.0 {
            bad = u;
        } else {
            good = u;
        }
        let newton = u - g / slope(&row.coefficients, u);
        let within = newton > bad.min(good) && newton < bad.max(good);
        let next = if within { newton } else { (bad * good).sqrt() };
        if (next - u).abs() <= 2e-16 * u || (bad - good).abs() <= 4e-16 * good {
            break;
        }
        u = next;
    }
    if row.excess(u) <= ROW_TOLERANCE { u } else { good }
}

#[cfg(test)]
mod tests;
