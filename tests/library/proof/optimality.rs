//! The conditions of optimality at N*, without the solver: from the raw waveforms of random convex joints,
//! the reported shadow prices and finite differences.
//!
//! With the price `p = ∂f*/∂b` of a limit `g(N) ≤ b` its multiplier is `λ = −p ≥ 0`. At N* the Lagrangian
//! `f + Σ λ (g − b)` neither falls to the left nor to the right; a limit with slack has no price; and the
//! least value of the Lagrangian over all ratios, which no feasible ratio can beat, is f* again.

use gearwise::design::program::Certificate;
use gearwise::requirement::*;
use rayon::prelude::*;

use crate::cases::{are_all, cases};
use crate::raw::{Case, draw, golden};
use crate::solved::{self, Solved};

/// Limits whose demand is the root of what is convex in N², or linear in N: squared, they are convex.
const SQUARED: [&str; 12] = [
    "peak_current",
    "peak_torque",
    "continuous_current",
    "continuous_torque",
    "winding_temperature",
    "standstill_holding",
    "voltage",
    "max_speed",
    "gear_input_speed",
    "torque_bandwidth_current",
    "torque_bandwidth_voltage",
    "ratio_max",
];

/// What is wrong by how much, relative: see [`check`].
#[derive(Debug, Clone, Copy, Default)]
struct Residual {
    /// Stationarity of the Lagrangian.
    stationarity: f64,
    /// Largest `λ (b − g)` over the objective.
    slackness: f64,
    /// How far the least value of the Lagrangian is from the objective.
    gap: f64,
    /// How far the reported lower bound is above the objective.
    bound: f64,
    /// The number of prices.
    prices: usize,
}

/// A limit with a price: demand, bound and multiplier of `g ≤ b`, in a form that is convex in N².
struct Priced {
    limit: &'static str,
    multiplier: f64,
    bound: f64,
}

impl Priced {
    fn value(&self, case: &Case, n: f64) -> f64 {
        let look = case.look(n);
        let (_, demand, _) = look.limits.into_iter().find(|limit| limit.0 == self.limit).unwrap();
        match self.limit {
            // The demand is the requirement's end: −N² ≤ −N_min².
            "ratio_min" => -n * n,
            limit if SQUARED.contains(&limit) => demand * demand,
            _ => demand,
        }
    }
}

fn check(case: &Case, design: &Solved) -> Option<Residual> {
    let (optimum, n) = (&design.optimum, design.optimum.ratio);
    let sole = case.robot.joints[0].objective.sole();
    // Mass steps: it has no slope. The end of a window that a mass sets has no price either.
    let window = optimum.window();
    let at_end = |end: f64| (n / end - 1.0).abs() < 1e-9;
    let by_mass = at_end(window.max) && window.high.limit == "actuator_mass";
    if case.robot.joints[0].objective.weight(Quantity::Mass) > 0.0 || by_mass {
        return None;
    }
    // The largest current is the root of what is convex: so is its square over twice itself, with the same slope.
    let best = optimum.objective;
    // Where the load vanishes for a single ratio, so does the objective: it is measured by what is usual.
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let usual = case.look((min * max).sqrt());
    let size = best.abs().max(1e-3 * usual.objective.abs()).max(f64::MIN_POSITIVE);
    let objective = |n: f64| match sole {
        Some(Quantity::PeakCurrent) => case.look(n).objective.powi(2) / (2.0 * size),
        _ => case.look(n).objective,
    };
    let mut residual = Residual { prices: optimum.shadow_prices.len(), ..Residual::default() };
    let mut priced = Vec::new();
    for price in &optimum.shadow_prices {
        let bound = match price.limit {
            "ratio_min" => min,
            "ratio_max" => max,
            limit => design.evaluation.margins.iter().find(|m| m.limit == limit).unwrap().bound,
        };
        let (multiplier, bound) = match price.limit {
            "ratio_min" => (price.price / (2.0 * bound), -bound * bound),
            limit if SQUARED.contains(&limit) => (-price.price / (2.0 * bound), bound * bound),
            _ => (-price.price, bound),
        };
        assert!(multiplier > 0.0, "the price {price:?} has the wrong sign");
        priced.push(Priced { limit: price.limit, multiplier, bound });
    }
    for p in &priced {
        residual.slackness = residual.slackness.max(p.multiplier * (p.bound - p.value(case, n)).abs() / size);
    }
    let lagrangian =
        |n: f64| objective(n) + priced.iter().map(|p| p.multiplier * (p.value(case, n) - p.bound)).sum::<f64>();
    // One-sided slopes in ln N: a difference of a convex function is not below the slope.
    let slope = |f: &dyn Fn(f64) -> f64, h: f64| (f(n * h.exp()) - f(n)) / h;
    let scale = slope(&objective, 1e-6).abs().max(size);
    residual.stationarity = (-slope(&lagrangian, 1e-6)).max(slope(&lagrangian, -1e-6)).max(0.0) / scale;
    // Weak duality on a grid over all ratios, refined around the least.
    let grid: Vec<f64> = (0..=400).map(|i| (min.ln() + (max / min).ln() * f64::from(i) / 400.0).exp()).collect();
    let least = (0..grid.len()).min_by(|a, b| lagrangian(grid[*a]).total_cmp(&lagrangian(grid[*b]))).unwrap();
    let around = [grid[least.saturating_sub(1)], grid[(least + 1).min(grid.len() - 1)]];
    let dual = lagrangian(golden(lagrangian, around)).min(lagrangian(grid[least]));
    residual.gap = (objective(n) - dual).abs() / scale;
    if let Certificate::Certified { lower_bound, .. } = optimum.certificate {
        residual.bound = (lower_bound - best).max(0.0) / size;
    } else {
        residual.bound = f64::NAN;
    }
    Some(residual)
}

#[test]
fn optima_are_stationary_points_of_their_lagrangian() {
    type Part = fn(&Residual) -> f64;
    let found: Vec<(u64, Residual)> = cases(0, 1000)
        .into_par_iter()
        .filter_map(|i| {
            // Where the degree of standstill steps the optimum is no stationary point.
            let case = Some(draw(i, true)).filter(|case| !case.has_slow_motion())?;
            Some((i, check(&case, &solved::solve(&case.motor, &case.robot).ok()?)?))
        })
        .collect();
    let most =
        |f: fn(&Residual) -> f64| found.iter().map(|(i, r)| (f(r), *i)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    let priced = found.iter().filter(|(_, r)| r.prices > 0).count();
    println!("{} optima, {priced} at a priced limit", found.len());
    let limits: [(&str, Part, f64); 4] = [
        ("stationarity", |r| r.stationarity, 1e-8),
        ("slackness", |r| r.slackness, 1e-8),
        ("gap", |r| r.gap, 1e-8),
        ("lower bound above the objective", |r| r.bound, 0.0),
    ];
    for (what, f, _) in limits {
        println!("{what}: most, and where {:?}", most(f));
    }
    for (what, f, allowed) in limits {
        let wrong: Vec<_> = found.iter().filter(|(_, r)| f(r).is_nan() || f(r) > allowed).collect();
        assert!(wrong.is_empty(), "{what}: {:?}", &wrong[..wrong.len().min(8)]);
    }
    assert!(!are_all() || found.len() > 400 && priced > 150);
}
