//! Ratio and parallel spring chosen together, proved.
//!
//! The one idea of this room: with the spring's torque `k (q − q_0)` added to the load, and `s = k q_0`,
//! every limit and the objective are jointly convex in `(u = N², k, s)`: terms like `(τ + k q − s)²/u` are
//! perspectives of quadratics (`form`). One conic program gives all three (`conic`), a tangent plane
//! with the solver's multipliers a bound that does not rest on the solver. Where convexity ends — gear
//! efficiency flips with a spring that is free, motor Coulomb friction, a limit on regeneration — the same
//! forms bound the model on regions (`region`, `model`), and regions are halved until the bounds meet
//! (`search`). The best ratio at the spring that was found is the ratio program's own.

mod conic;
mod form;
mod interior;
mod model;
mod problem;
mod region;
mod search;

use super::Bind;
use super::{
    Certificate, GAP_TOLERANCE, Infeasible, Optimum, RatioProgram, Refusal, Unsolved, Window, with_constant_mass,
};
use crate::Candidate;
use crate::evaluate::Prepared;
use gearwise_model::actuator::Load;
use gearwise_model::requirement::{Joint, Objective, Quantity, Spring};
use problem::Problem;
use search::search;

/// The best ratio and spring.
#[derive(Debug, Clone)]
pub struct SpringOptimum {
    /// Stiffness \[N·m/rad\].
    pub stiffness: f64,
    /// Rest angle \[rad\]; `None` without stiffness.
    pub rest_angle: Option<f64>,
    /// The best ratio at that spring; its certificate is of ratio and spring together.
    pub optimum: Optimum,
    /// No ratio and spring are better than this, in the objective's unit; `None` where no bound was found.
    pub lower_bound: Option<f64>,
    /// Relative gap between the objective and its bound.
    pub gap: Option<f64>,
    /// Whether the objective leaves the spring free, so that the least stiffness was taken.
    pub least_stiffness: bool,
}

/// A joint with the torque of a certain spring in its motion, and its load.
#[derive(Debug)]
pub(crate) struct Sprung {
    /// The joint.
    pub joint: Joint,
    /// Its load.
    pub load: Load,
}

impl Sprung {
    /// A joint with a spring; `covered` is the inertia at the output that the gear's efficiency covers
    /// \[kg·m²\]. `None` where the motion says no position.
    pub fn new(joint: &Joint, stiffness: f64, rest_angle: f64, covered: f64) -> Option<Sprung> {
        let joint = joint.with_spring(stiffness, rest_angle)?;
        let load = Load::with_inertia(&joint.motion, joint.ripple(), covered);
        Some(Sprung { joint, load })
    }

    /// The candidate with this spring.
    pub fn candidate<'s>(&'s self, candidate: &Candidate<'s>) -> Candidate<'s> {
        let by_ratio = candidate.by_ratio.map(|_| &self.load);
        Candidate { load: self.load.standing_as(candidate.load), joint: &self.joint, by_ratio, ..*candidate }
    }
}

/// Finds the best ratio in a range and the best spring of a candidate, given without spring.
///
/// # Errors
/// The outcome, where it is not an optimum.
pub fn solve(
    prepared: &Prepared,
    objective: &Objective,
    spring: &Spring,
    (min, max): (f64, f64),
    covered: f64,
) -> Result<SpringOptimum, Refusal> {
    prepared.stop.within(|| solve_within(prepared, objective, spring, (min, max), covered))
}

fn solve_within(
    prepared: &Prepared,
    objective: &Objective,
    spring: &Spring,
    (min, max): (f64, f64),
    covered: f64,
) -> Result<SpringOptimum, Refusal> {
    if prepared.candidate.by_ratio.is_some() {
        return solve_standing(prepared, objective, spring, (min, max), covered);
    }
    if let Some((quantity, weight)) = objective.weighed() {
        let found = solve(prepared, &Objective::single(quantity), spring, (min, max), covered)?;
        return Ok(SpringOptimum {
            optimum: found.optimum.times(weight),
            lower_bound: found.lower_bound.map(|bound| weight * bound),
            ..found
        });
    }
    if let Some((rest, constant)) = with_constant_mass(prepared, objective) {
        let found = solve(prepared, &rest, spring, (min, max), covered)?;
        let gap = |gap: f64| gap * (found.optimum.objective / (found.optimum.objective + constant)).abs();
        return Ok(SpringOptimum {
            lower_bound: found.lower_bound.map(|bound| bound + constant),
            gap: found.gap.map(gap),
            optimum: found.optimum.clone().plus(constant),
            ..found
        });
    }
    let solver = Solver { prepared, objective, spring, covered };
    if objective.sole() == Some(Quantity::Mass) && min < max {
        return solver.least_mass(min, max);
    }
    let [k0, k1] = spring.stiffness;
    let [q0, q1] = spring.rest_angle;
    if k1 == 0.0 || (k0 == k1 && q0 == q1) {
        let optimum = solver.at(k0, q0, min, max)?;
        let (lower_bound, gap) = match optimum.certificate {
            Certificate::Certified { lower_bound, gap, .. } => (Some(lower_bound), Some(gap)),
            Certificate::NotCertified(_) => (None, None),
        };
        let rest_angle = (k0 > 0.0).then_some(q0);
        return Ok(SpringOptimum { stiffness: k0, rest_angle, optimum, lower_bound, gap, least_stiffness: false });
    }
    solver.free(min, max)
}

/// Solve for ratio and spring piece by piece where the degree of standstill depends on the ratio. A spring does not change the motion, so
/// each piece keeps its degrees.
fn solve_standing(
    prepared: &Prepared,
    objective: &Objective,
    spring: &Spring,
    (min, max): (f64, f64),
    covered: f64,
) -> Result<SpringOptimum, Refusal> {
    let candidate = &prepared.candidate;
    let mut ends = vec![min];
    ends.extend(candidate.standing_changes((min, max)).into_iter().filter(|n| min < *n && *n < max));
    ends.push(max);
    let (mut best, mut refused): (Option<SpringOptimum>, Option<Refusal>) = (None, None);
    let mut bound = Some(f64::INFINITY);
    for piece in ends.windows(2) {
        let own = prepared.with_candidate(candidate.standing_at(piece[0]));
        match solve(&own, objective, spring, (piece[0], piece[1]), covered) {
            Ok(found) => {
                bound = bound.zip(found.lower_bound).map(|(least, own)| least.min(own));
                if best.as_ref().is_none_or(|best| found.optimum.objective < best.optimum.objective) {
                    best = Some(found);
                }
            }
            Err(Refusal::Infeasible(why)) => refused = refused.or(Some(Refusal::Infeasible(why))),
            Err(other) => (bound, refused) = (None, Some(other)),
        }
    }
    let nothing = || refused.unwrap_or(Refusal::NotSolved(Unsolved::NothingRuledOutWithSpring));
    let mut best = best.ok_or_else(nothing)?;
    // All ratios that the spring keeps, beyond its piece.
    let solver = Solver { prepared, objective, spring, covered };
    if let Ok(whole) = solver.at(best.stiffness, best.rest_angle.unwrap_or(0.0), min, max) {
        best.optimum.windows = whole.windows;
    }
    let value = best.optimum.objective;
    let gap = bound.map(|bound| (value - bound.min(value)) / value.abs().max(f64::MIN_POSITIVE));
    (best.lower_bound, best.gap) = (bound, gap);
    if gap.is_none_or(|gap| gap > GAP_TOLERANCE) {
        best.optimum.certificate = Certificate::NotCertified("the bounds of ratio and spring did not meet".into());
    }
    Ok(best)
}

/// The allowed spring at which the limits are exceeded least, as far as the search for the best one goes.
pub fn nearest(
    prepared: &Prepared,
    objective: &Objective,
    spring: &Spring,
    (min, max): (f64, f64),
    covered: f64,
) -> Option<(f64, f64)> {
    let [k0, k1] = spring.stiffness;
    let [q0, q1] = spring.rest_angle;
    if k0 == k1 && q0 == q1 {
        return Some((k0, q0));
    }
    // Mass does not depend on the spring: what counts for the search is how far the limits are.
    let loss = Objective::single(Quantity::Loss);
    let objective = if objective.weight(Quantity::Mass) > 0.0 { &loss } else { objective };
    let problem = Problem::new(prepared, objective, covered)?;
    let whole = problem.whole([min, max], spring);
    let verdict = search(&problem, spring, whole, &[]);
    Some(problem.spring(spring, verdict.best.map_or(verdict.nearest, |(_, z)| z)))
}

struct Solver<'a> {
    prepared: &'a Prepared<'a>,
    objective: &'a Objective,
    spring: &'a Spring,
    covered: f64,
}

impl Solver<'_> {
    /// The best ratio at a spring.
    fn at(&self, stiffness: f64, rest_angle: f64, min: f64, max: f64) -> Result<Optimum, Refusal> {
        let candidate = &self.prepared.candidate;
        let no_position = || Refusal::NotSolved(Unsolved::NoPosition);
        let sprung = Sprung::new(candidate.joint, stiffness, rest_angle, self.covered).ok_or_else(no_position)?;
        let prepared = self.prepared.with_candidate(sprung.candidate(candidate));
        if candidate.catalog_gear.is_some() {
            return fixed_ratio(&prepared, self.objective, min).map_err(Refusal::Infeasible);
        }
        RatioProgram::new(&prepared, self.objective, min, max).solve()
    }

    fn free(&self, min: f64, max: f64) -> Result<SpringOptimum, Refusal> {
        let Some(problem) = Problem::new(self.prepared, self.objective, self.covered) else {
            return Err(Refusal::NotSolved(Unsolved::NoPosition));
        };
        let (low, high) = if min == max {
            (min, max)
        } else {
            let program = RatioProgram::new(self.prepared, self.objective, min, max);
            let (low, high) = program.ends().map_err(Refusal::Infeasible)?;
            (low.ratio, high.ratio)
        };
        let program = RatioProgram::new(self.prepared, self.objective, low, high);
        let whole = problem.whole([low, high], self.spring);
        // A piece of ratios has the mass of its end; the smallest ratio is a piece of its own.
        let mut pieces = Vec::new();
        if problem.has_steps() && low < high {
            pieces.push(low);
            pieces.extend(program.stage_ratios(low, high));
        }
        let verdict = search(&problem, self.spring, whole.clone(), &pieces);
        let Some((value, z)) = verdict.best else {
            let (k, q) = problem.spring(self.spring, verdict.nearest);
            return Err(match self.at(k, q, min, max) {
                Err(Refusal::Infeasible(why)) if verdict.impossible => Refusal::Infeasible(why),
                _ => Refusal::NotSolved(Unsolved::NothingRuledOutWithSpring),
            });
        };
        let (mut stiffness, mut rest_angle) = problem.spring(self.spring, z);
        let mut optimum = self.at(stiffness, rest_angle, min, max)?;
        let mut best = problem.raw(optimum.objective).min(value);
        let mut least_stiffness = false;
        // Where the objective leaves the spring free the least stiffness is taken.
        let other = self.softer(&problem, &whole, &optimum, stiffness, min, max);
        if let Some((k, q, softer)) = other {
            (stiffness, rest_angle, optimum, least_stiffness) = (k, q, softer, true);
            best = problem.raw(optimum.objective);
        }
        let reference = best.abs().max(1e-6 * verdict.size).max(f64::MIN_POSITIVE);
        let bound = verdict.bound.min(best);
        let gap = (best - bound) / reference;
        let lower_bound = bound.is_finite().then(|| problem.natural(bound));
        let why = problem.why_not_convex();
        optimum.certificate = match (lower_bound, why) {
            (Some(lower_bound), _) if gap <= GAP_TOLERANCE => Certificate::Certified {
                lower_bound,
                gap,
                method: if why.is_none() { "conic duality (with spring)" } else { "branch and bound (with spring)" },
            },
            (_, why) => Certificate::NotCertified(why.unwrap_or("the bounds of ratio and spring did not meet").into()),
        };
        Ok(SpringOptimum {
            stiffness,
            rest_angle: (stiffness > 0.0).then_some(rest_angle),
            optimum,
            lower_bound,
            gap: lower_bound.map(|_| gap),
            least_stiffness,
        })
    }

    /// Whether a spring may come to an objective, by what it is certainly not below: `false` without solving.
    fn may_reach(&self, objective: f64, stiffness: f64, rest_angle: f64, min: f64, max: f64) -> bool {
        let candidate = &self.prepared.candidate;
        if candidate.catalog_gear.is_some() {
            return true;
        }
        let Some(sprung) = Sprung::new(candidate.joint, stiffness, rest_angle, self.covered) else { return true };
        let prepared = self.prepared.with_candidate(sprung.candidate(candidate));
        let least = RatioProgram::new(&prepared, self.objective, min, max).lower_bound();
        least.is_none_or(|least| least <= objective + 1e-6 * objective.abs())
    }

    /// A softer spring with the same objective: the softest allowed, or where the objective does not look
    /// at the spring the softest that keeps the limits at its ratio.
    fn softer(
        &self,
        problem: &Problem,
        whole: &region::Region,
        optimum: &Optimum,
        stiffness: f64,
        min: f64,
        max: f64,
    ) -> Option<(f64, f64, Optimum)> {
        let softest = self.spring.stiffness[0];
        if stiffness <= softest {
            return None;
        }
        let same = |o: &Optimum| o.objective <= optimum.objective + 1e-9 * optimum.objective.abs();
        let rest = problem.spring(self.spring, whole.middle()).1;
        if self.may_reach(optimum.objective, softest, rest, min, max)
            && let Ok(other) = self.at(softest, rest, min, max)
            && same(&other)
        {
            return Some((softest, rest, other));
        }
        if self.objective.sole() != Some(Quantity::ReflectedInertia) {
            return None;
        }
        let least = Problem::new(self.prepared, self.objective, self.covered)?.for_least_stiffness();
        let highest = (optimum.ratio * (1.0 + 1e-10)).min(whole.ratio[1]);
        let narrower = region::Region { ratio: [whole.ratio[0], highest], ..whole.clone() };
        let verdict = search(&least, self.spring, narrower, &[]);
        let (k, q) = least.spring(self.spring, verdict.best?.1);
        let other = self.at(k, q, min, max).ok().filter(same)?;
        (k < stiffness).then_some((k, q, other))
    }

    /// Mass does not depend on the spring, and does not fall with the ratio: it is that of the fewest stages with which any
    /// ratio and spring keep the limits. Among these the ratio and spring of least loss are taken.
    fn least_mass(&self, min: f64, max: f64) -> Result<SpringOptimum, Refusal> {
        let loss = Objective::single(Quantity::Loss);
        let candidate = &self.prepared.candidate;
        let mut best = solve(self.prepared, &loss, self.spring, (min, max), self.covered)?;
        let mass = |found: &SpringOptimum| candidate.mass_at(found.optimum.ratio);
        let Some(mut least) = mass(&best) else { return Err(Refusal::NotSolved(Unsolved::NoMass)) };
        let mut open = None;
        let mut start = min;
        for end in RatioProgram::new(self.prepared, &loss, min, max).stage_ratios(min, max) {
            if candidate.mass_at(end).is_none_or(|fewer| fewer >= least) {
                break;
            }
            match solve(self.prepared, &loss, self.spring, (start, end), self.covered) {
                Ok(lighter) => {
                    least = mass(&lighter).unwrap_or(least);
                    best = lighter;
                    break;
                }
                Err(Refusal::Infeasible(_)) => start = end,
                Err(_) => {
                    open = Some("fewer stages could not be ruled out");
                    start = end;
                }
            }
        }
        best.optimum.objective = least;
        best.optimum.shadow_prices.clear();
        (best.lower_bound, best.gap) = (open.is_none().then_some(least), open.is_none().then_some(0.0));
        best.optimum.certificate = match open {
            None => {
                Certificate::Certified { lower_bound: least, gap: 0.0, method: "mass does not fall with the ratio" }
            }
            Some(why) => Certificate::NotCertified(why.into()),
        };
        Ok(best)
    }
}

/// One ratio, looked at.
fn fixed_ratio(prepared: &Prepared, objective: &Objective, ratio: f64) -> Result<Optimum, Infeasible> {
    let evaluation = prepared.at_in_full(ratio);
    if !evaluation.feasible {
        let tightest = evaluation.tightest();
        let bind = Bind::of(tightest.map_or("gear", |m| m.limit), tightest.and_then(|m| m.sample));
        let (least, allowed) = tightest.map_or((f64::INFINITY, f64::NAN), |m| (m.demand / m.bound, m.bound));
        return Err(Infeasible::Nowhere { bind, least, allowed, ratio });
    }
    let bind = Bind::of("gear", None);
    let objective = evaluation.objective(objective).unwrap_or(f64::NAN);
    Ok(Optimum {
        ratio,
        objective,
        windows: vec![Window { min: ratio, max: ratio, low: bind.clone(), high: bind }],
        certificate: Certificate::Certified { lower_bound: objective, gap: 0.0, method: "one ratio evaluated" },
        shadow_prices: Vec::new(),
    })
}
