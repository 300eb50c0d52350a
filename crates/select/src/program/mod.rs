//! The ratio program: the best ratio N of one motor at one joint, proved.
//!
//! The one idea of this room: in `u = N²` every limit is a row `c_w/u + c_0 + c_u u + c_t u² ≤ b`
//! with `c_w, c_t ≥ 0`, hence convex; with `w ≥ 1/u` and `t ≥ u²` the program is conic and exact.
//! It is solved with few rows, the violated ones are added (`conic`); the window of feasible
//! ratios comes from the rows themselves (`window`); the certificate is a Lagrangian bound computed
//! without the solver (`certificate`). Where convexity ends, interval branch and bound in N goes on until
//! its bounds meet (`branch`), from the best ratio of a refined grid (`scan`).

mod answer;
mod bind;
mod bound;
mod branch;
mod certificate;
mod conic;
mod evaluated;
mod line;
mod mapped;
mod objective;
mod prices;
mod refusal;
mod scan;
pub mod spring;
mod underestimate;
mod weakened;
mod window;

use gearwise_model::actuator::Laurent;
use gearwise_model::actuator::limits::{Asked, Candidate, Class, Demand};
use gearwise_model::actuator::waveform::Functional;
use gearwise_model::numerics::line_search::least_in_few_looks;
use gearwise_model::numerics::work;
use gearwise_model::requirement::{Objective, Quantity};

use super::evaluate::{Prepared, violation};

pub use answer::{Certificate, NotProved, Optimum, Outcome, ShadowPrice, Window};
pub use bind::Bind;
pub use bound::Bound;
pub(crate) use objective::Peak;
pub use refusal::{Infeasible, Refusal, Unsolved};
pub(crate) use window::minimise;

/// Rows are met to this relative accuracy in the functional.
const ROW_TOLERANCE: f64 = 1e-10;
/// A certificate with a larger relative gap is no proof.
pub const GAP_TOLERANCE: f64 = 1e-6;

/// One row of the program: `polynomial(N) ≤ bound`.
#[derive(Debug, Clone, Copy)]
struct Row {
    /// Index into the limits that apply.
    asked: usize,
    sample: Option<usize>,
    /// Coefficients of 1/u, 1, u, u².
    coefficients: [f64; 4],
    bound: f64,
}

impl Row {
    fn at(&self, u: f64) -> f64 {
        value(&self.coefficients, u)
    }

    fn excess(&self, u: f64) -> f64 {
        relative_excess(self.at(u), self.bound, || value(&self.coefficients.map(f64::abs), u))
    }
}

/// Excess over a bound, relative to it; where nothing is allowed, relative to the terms whose sum the value
/// is: what is negligible for one motor is not for one a million times smaller.
fn relative_excess(raw: f64, bound: f64, size: impl FnOnce() -> f64) -> f64 {
    let excess = violation(raw, bound);
    if bound > 0.0 || excess <= 0.0 {
        return excess;
    }
    let size = size();
    if size > 0.0 { excess / size } else { excess }
}

/// `c_w/u + c_0 + c_u u + c_t u²`.
pub(crate) fn value(c: &[f64; 4], u: f64) -> f64 {
    c[0] / u + c[1] + u * (c[2] + u * c[3])
}

/// Its derivative.
fn slope(c: &[f64; 4], u: f64) -> f64 {
    -c[0] / (u * u) + c[2] + 2.0 * u * c[3]
}

/// A limit, and the candidate whose demand it bounds.
#[derive(Debug, Clone, Copy)]
pub struct Limited<'a> {
    /// The candidate: that of the objective, or the same with other numbers.
    pub candidate: &'a Candidate<'a>,
    /// Its limit.
    pub asked: &'a Asked,
}

/// The program of one candidate over the ratios `[min, max]`.
#[derive(Debug)]
pub struct RatioProgram<'a> {
    prepared: &'a Prepared<'a>,
    objective: &'a Objective,
    range: (f64, f64),
    limits: Vec<Limited<'a>>,
}

/// An objective that counts a mass that no ratio changes: the rest of it, and what the mass adds.
fn with_constant_mass(prepared: &Prepared, objective: &Objective) -> Option<(Objective, f64)> {
    let (rest, weight) = objective.apart_from_mass()?;
    let candidate = &prepared.candidate;
    let is_fixed = candidate.gear.mass_per_stage.is_none() && candidate.mass_slope() == 0.0;
    let mass = candidate.mass_at(1.0).filter(|_| is_fixed)?;
    Some((rest, weight * mass))
}

/// An end of the range of ratios with the limit that sets it.
#[derive(Debug, Clone)]
struct End {
    ratio: f64,
    bind: Bind,
    /// `dN/d(bound)` of the limit, for its shadow price.
    ratio_per_bound: f64,
    bound: f64,
}

impl End {
    fn u(&self) -> f64 {
        self.ratio * self.ratio
    }
}

impl<'a> RatioProgram<'a> {
    /// Sets up the program.
    pub fn new(prepared: &'a Prepared<'a>, objective: &'a Objective, min: f64, max: f64) -> RatioProgram<'a> {
        let limits = prepared.asked.iter().map(|asked| Limited { candidate: &prepared.candidate, asked }).collect();
        RatioProgram { prepared, objective, range: (min, max), limits }
    }

    /// The program that minimises the objective of one candidate under other limits than its own: those of
    /// the same motor with its numbers at the ends of their tolerances.
    pub fn under(
        prepared: &'a Prepared<'a>,
        objective: &'a Objective,
        (min, max): (f64, f64),
        limits: Vec<Limited<'a>>,
    ) -> RatioProgram<'a> {
        RatioProgram { prepared, objective, range: (min, max), limits }
    }

    /// Solve it. A program that does more work than its share ends with the best ratio found so far, which is not certified.
    pub fn solve(&self) -> Outcome {
        self.prepared.stop.within(|| self.solve_within())
    }

    fn solve_within(&self) -> Outcome {
        // Where effects are evaluated at each ratio, so is standstill.
        let is_evaluated = self.has_evaluated_effects() && self.prepared.candidate.whole_map().is_none();
        if self.stands_by_ratio() && !is_evaluated {
            return mapped::solve_standing(self);
        }
        if let Some(map) = self.prepared.candidate.whole_map() {
            return mapped::solve(self, map);
        }
        if let Some((quantity, weight)) = self.objective.weighed() {
            let single = Objective::single(quantity);
            let program = RatioProgram { objective: &single, limits: self.limits.clone(), ..*self };
            return match program.solve() {
                Ok(optimum) => Ok(optimum.times(weight)),
                other => other,
            };
        }
        if let Some((rest, constant)) = with_constant_mass(self.prepared, self.objective) {
            let program = RatioProgram { objective: &rest, limits: self.limits.clone(), ..*self };
            return program.solve().map(|optimum| optimum.plus(constant));
        }
        if let Some(infeasible) = self.fixed_limits() {
            return Err(Refusal::Infeasible(infeasible));
        }
        if self.objective.sole() == Some(Quantity::Mass) && self.prepared.candidate.mass_slope() == 0.0 {
            return self.least_mass();
        }
        if self.has_evaluated_effects() {
            return evaluated::solve(self);
        }
        if self.is_evaluated() {
            return branch::solve(self, "the bounds with currents along d did not meet");
        }
        match self.why_not_convex() {
            None => self.solve_convex(),
            Some(why) => line::solve(self).unwrap_or_else(|| branch::solve(self, why)),
        }
    }

    /// The objective at a ratio, in its own unit.
    pub(crate) fn objective_at(&self, ratio: f64) -> f64 {
        objective::Goal::summed(self).value(ratio)
    }

    /// The least value over some intervals of ratios, and where: a grid on each, and every valley refined.
    pub(crate) fn least_over(value: &impl Fn(f64) -> f64, intervals: &[(f64, f64)]) -> Option<(f64, f64)> {
        scan::least(value, intervals, 100)
    }

    /// A polynomial that touches the objective at a ratio and is nowhere above it, up to the mass that steps
    /// by stages, which is the second number.
    pub(crate) fn objective_cut(&self, ratio: f64) -> (Laurent, f64) {
        let goal = objective::Goal::summed(self);
        (goal.cut(ratio), goal.steps(ratio))
    }

    /// What the cut at a ratio takes of single samples: current and power at the largest of them.
    pub(crate) fn peaks(&self, ratio: f64) -> Vec<Peak> {
        objective::Goal::summed(self).peaks(ratio)
    }

    /// Whether the objective falls to one valley and rises beyond it, and the feasible ratios are one interval.
    pub(crate) fn has_one_valley(&self) -> bool {
        if self.stands_by_ratio() {
            let depends = self.limits.iter().any(|limited| limited.asked.depends_on_standing());
            return !depends && mapped::with_least_standing(self, |program| program.has_one_valley());
        }
        match with_constant_mass(self.prepared, self.objective) {
            Some((rest, _)) => RatioProgram { objective: &rest, limits: self.limits.clone(), ..*self }.has_one_valley(),
            None => !self.is_evaluated() && self.why_not_convex().is_none(),
        }
    }

    /// Whether it is shown that the objective, a single quantity, falls to its least values and rises beyond them between two ratios, or
    /// is one step after the other up: it is convex in N², or a mean that friction makes convex in 1/N alone. Whatever the limits are.
    pub(crate) fn is_valley(&self, from: f64, to: f64) -> bool {
        if self.stands_by_ratio() {
            // Only limits count standstill.
            return mapped::with_least_standing(self, |program| program.is_valley(from, to));
        }
        let (prepared, Some(quantity)) = (self.prepared, self.objective.sole()) else { return false };
        let has_odd_powers = prepared.candidate.has_odd_powers();
        match quantity {
            _ if self.is_evaluated() => false,
            Quantity::Mass | Quantity::ReflectedInertia => true,
            Quantity::Loss | Quantity::CopperLoss if has_odd_powers => {
                let ends = prepared.losses_at_ends(quantity);
                ends.is_some_and(|ends| ends.iter().all(|mean| line::is_convex_in_inverse(mean, from, to)))
            }
            Quantity::Loss | Quantity::CopperLoss | Quantity::PeakCurrent | Quantity::Energy | Quantity::PeakPower => {
                !has_odd_powers
            }
        }
    }

    /// True if the degree of standstill depends on the ratio.
    fn stands_by_ratio(&self) -> bool {
        self.limits.iter().map(|l| l.candidate).chain([&self.prepared.candidate]).any(|c| c.by_ratio.is_some())
    }

    /// Whether ratios have to be evaluated one by one.
    fn is_evaluated(&self) -> bool {
        self.prepared.candidate.is_evaluated()
    }

    /// Whether some effect of a motor has to be evaluated at each ratio.
    fn has_evaluated_effects(&self) -> bool {
        let mut candidates = self.limits.iter().map(|l| l.candidate).chain([&self.prepared.candidate]);
        candidates.any(|c| !c.folded && c.has_evaluated_effects())
    }

    /// True if the iron of some motor saturates.
    fn saturates(&self) -> bool {
        let mut candidates = self.limits.iter().map(|l| l.candidate).chain([&self.prepared.candidate]);
        candidates.any(|c| c.ends().any(|end| end.shortfall.saturates()))
    }

    /// The reason why the program is not the convex one, if there is one.
    fn why_not_convex(&self) -> Option<&'static str> {
        let candidates = self.limits.iter().map(|l| l.candidate).chain([&self.prepared.candidate]);
        if candidates.into_iter().any(Candidate::has_odd_powers) {
            return Some("motor Coulomb friction makes the limits non-convex in N²");
        }
        if self.limits.iter().any(|l| l.asked.limit.class == Class::ReverseConvex) {
            return Some("a regeneration limit is reverse-convex");
        }
        let is_bent = |l: &Limited| match l.asked.demand {
            Demand::Samples(Functional::VoltageSquared | Functional::OpenVoltage(_))
            | Demand::Bandwidth(Functional::VoltageSquared | Functional::OpenVoltage(_)) => {
                l.candidate.end(l.asked.end).shortfall.saturates()
            }
            _ => false,
        };
        if self.limits.iter().any(is_bent) {
            return Some("iron that saturates makes the voltage non-convex in N²");
        }
        if let Some(why) = objective::why_not_convex(self.objective) {
            return Some(why);
        }
        if self.objective.sole().is_none()
            && self.objective.weight(Quantity::Mass) > 0.0
            && self.prepared.candidate.gear.mass_per_stage.is_some()
        {
            return Some("a weighted sum with a mass that steps by stages is not convex in N²");
        }
        None
    }

    /// The violated limit whose demand no ratio changes, whatever the class of the limit is: a locked gear has no finite backdriving torque
    /// at any ratio.
    fn fixed_limits(&self) -> Option<Infeasible> {
        for Limited { candidate, asked } in &self.limits {
            if asked.limit.class != Class::Fixed && !asked.demand.is_constant() {
                continue;
            }
            let (raw, sample) = asked.raw_demand(candidate, 1.0);
            if violation(raw, asked.raw_bound()) > ROW_TOLERANCE {
                let bind = Bind::of(asked.limit.name, sample);
                let (least, allowed) = (asked.natural(raw) / asked.bound, asked.bound);
                return Some(Infeasible::Never { bind, least, allowed, ratio: self.range.0 });
            }
        }
        None
    }

    /// The range of u = N² that the requirement and the limits of class `UpperBound` leave.
    fn ends(&self) -> Result<(End, End), Infeasible> {
        let (min, max) = self.range;
        let low = End { ratio: min, bind: Bind::of("ratio_min", None), ratio_per_bound: 1.0, bound: min };
        let mut high = End { ratio: max, bind: Bind::of("ratio_max", None), ratio_per_bound: 1.0, bound: max };
        for Limited { candidate, asked } in self.limits.iter().filter(|l| l.asked.limit.class == Class::UpperBound) {
            let (ratio, sample, ratio_per_bound) = match asked.demand {
                Demand::Mass => {
                    let ratio = largest_ratio_by_mass(candidate, asked);
                    if ratio == 0.0 {
                        let least = candidate.known_mass_at(min) / asked.bound;
                        let bind = Bind::of(asked.limit.name, None);
                        return Err(Infeasible::Never { bind, least, allowed: asked.bound, ratio: min });
                    }
                    (ratio, None, 0.0)
                }
                Demand::Polynomial(polynomial, sample) => {
                    let ratio = largest_ratio_within(&polynomial, asked.raw_bound());
                    // What no ratio changes is too much by itself.
                    if ratio == 0.0 && polynomial[0] > 0.0 {
                        let least = asked.natural(polynomial.at(min)) / asked.bound;
                        let bind = Bind::of(asked.limit.name, sample);
                        return Err(Infeasible::Never { bind, least, allowed: asked.bound, ratio: min });
                    }
                    (ratio, sample, 1.0 / (asked.factor * polynomial.slope(ratio)))
                }
                _ => continue,
            };
            if ratio < high.ratio {
                high = End { ratio, bind: Bind::of(asked.limit.name, sample), ratio_per_bound, bound: asked.bound };
            }
        }
        if high.ratio < low.ratio * (1.0 - ROW_TOLERANCE) {
            return Err(Infeasible::Contradiction {
                low: low.bind,
                at_least: min,
                high: high.bind,
                at_most: high.ratio,
            });
        }
        high.ratio = high.ratio.max(low.ratio);
        Ok((low, high))
    }

    /// [`Asked::polynomial_at`] of a limit.
    fn polynomial_at(&self, index: usize, ratio: f64) -> Option<(Laurent, Option<usize>)> {
        let Limited { candidate, asked } = self.limits[index];
        asked.polynomial_at(candidate, ratio)
    }

    /// By how much the demand of a limit exceeds its bound at a ratio.
    fn excess(&self, index: usize, raw: f64, ratio: f64) -> f64 {
        let size = || self.polynomial_at(index, ratio).map_or(0.0, |(polynomial, _)| polynomial.size(ratio));
        relative_excess(raw, self.limits[index].asked.raw_bound(), size)
    }

    /// The most violated of the rows of all limits, where one is violated, and its bound; `row` gives that of a limit with its
    /// excess.
    fn most_violated(&self, row: impl Fn(usize, &Limited) -> Option<(Laurent, f64)>) -> Option<(Laurent, f64)> {
        let mut worst: Option<(f64, Laurent, f64)> = None;
        for (index, limited) in self.limits.iter().enumerate() {
            let Some((polynomial, excess)) = row(index, limited) else { continue };
            if excess > ROW_TOLERANCE && worst.as_ref().is_none_or(|(most, ..)| excess > *most) {
                worst = Some((excess, polynomial, limited.asked.raw_bound()));
            }
        }
        // A limit counts as kept within the tolerance everywhere.
        worst.map(|(_, polynomial, bound)| (polynomial, bound + ROW_TOLERANCE * bound.abs()))
    }

    /// The row of a convex limit that is most violated (or least slack) at a ratio.
    fn row_at(&self, index: usize, ratio: f64) -> Option<Row> {
        let asked = self.limits[index].asked;
        let (polynomial, sample) = self.polynomial_at(index, ratio)?;
        debug_assert!(polynomial.is_convex_in_square(), "{} is not convex", asked.limit.name);
        Some(Row { asked: index, sample, coefficients: polynomial.in_square(), bound: asked.raw_bound() })
    }

    /// The most violated row over all convex limits at u. A limit that takes a walk over all samples is
    /// looked at only where the others are kept: any violated row will do to go on.
    fn worst_row(&self, u: f64) -> Option<Row> {
        let worst = |costly: bool| {
            let convex = self.limits.iter().enumerate().filter(|(_, l)| l.asked.limit.class == Class::Convex);
            let rows = convex
                .filter(|(_, l)| l.asked.demand.takes_a_walk() == costly)
                .filter_map(|(index, _)| self.row_at(index, u.sqrt()));
            rows.max_by(|a, b| a.excess(u).total_cmp(&b.excess(u)))
        };
        let cheap = worst(false);
        if cheap.is_some_and(|row| row.excess(u) > ROW_TOLERANCE) {
            return cheap;
        }
        let both = cheap.into_iter().chain(worst(true));
        both.max_by(|a, b| a.excess(u).total_cmp(&b.excess(u)))
    }

    /// The report of a convex limit that no ratio of the requirement keeps: its least demand, of all candidates that it is asked of.
    /// The largest of convex rows has one valley.
    fn never(&self, index: usize) -> Infeasible {
        // Once the work is done, the least so far.
        let demand = |n: f64| if work::is_spent() { f64::INFINITY } else { self.worst_of(index, n).0 };
        let ratio = least_in_few_looks(&demand, self.range.0, self.range.1);
        let (asked, (raw, sample)) = (self.limits[index].asked, self.worst_of(index, ratio));
        Infeasible::Never {
            bind: Bind::of(asked.limit.name, sample),
            least: asked.natural(raw) / asked.bound,
            allowed: asked.bound,
            ratio,
        }
    }

    /// Largest demand of a limit at a ratio, of all candidates that it is asked of, and its sample.
    fn worst_of(&self, index: usize, ratio: f64) -> (f64, Option<usize>) {
        let name = self.limits[index].asked.limit.name;
        let same = self.limits.iter().filter(|limited| limited.asked.limit.name == name);
        let all = same.map(|Limited { candidate, asked }| asked.raw_demand(candidate, ratio));
        all.reduce(|a, b| if b.0 > a.0 { b } else { a }).unwrap_or((f64::NAN, None))
    }

    /// Place of a limit by its name, where its demand depends on standstill.
    fn standing_limit(&self, name: &str) -> Option<usize> {
        self.limits.iter().position(|l| l.asked.limit.name == name && l.asked.depends_on_standing())
    }

    /// The report of a limit that depends on standstill, and its least demand over the limit.
    fn never_of(&self, name: &str) -> Option<(f64, Infeasible)> {
        match self.never(self.standing_limit(name)?) {
            Infeasible::Never { least, bind, allowed, ratio } => {
                Some((least, Infeasible::Never { bind, least, allowed, ratio }))
            }
            _ => None,
        }
    }

    /// Demand of a limit that depends on standstill over the limit, at a ratio.
    fn demand_of(&self, name: &str, ratio: f64) -> Option<f64> {
        let index = self.standing_limit(name)?;
        let asked = self.limits[index].asked;
        Some(asked.natural(self.worst_of(index, ratio).0) / asked.bound)
    }

    fn bind(&self, row: &Row) -> Bind {
        Bind::of(self.limits[row.asked].asked.limit.name, row.sample)
    }

    fn solve_convex(&self) -> Outcome {
        let (low, high) = match self.ends() {
            Ok(ends) => ends,
            Err(infeasible) => return Err(Refusal::Infeasible(infeasible)),
        };
        let (window, rows) = window::find(self, &low, &high)?;
        conic::solve(self, &window, rows, &low, &high)
    }

    /// Ratios of the range at which a further gear stage begins: there the mass steps up.
    pub(crate) fn stage_ratios(&self, min: f64, max: f64) -> Vec<f64> {
        let Some((_, stage_ratio)) = self.prepared.candidate.gear.mass_per_stage else { return Vec::new() };
        let powers = std::iter::successors(Some(1.0), |n| Some(n * stage_ratio));
        powers.take_while(|n| *n < max).filter(|n| *n > min).collect()
    }

    /// Mass does not fall with the ratio: it is least at the smallest feasible one, and among the ratios
    /// of that mass the one of least loss is taken.
    fn least_mass(&self) -> Outcome {
        let candidate = &self.prepared.candidate;
        if let (None, Some(mass)) = (candidate.gear.mass_per_stage, candidate.mass_at(self.range.0)) {
            // No ratio changes it.
            let loss = Objective::single(Quantity::Loss);
            let program = RatioProgram { objective: &loss, limits: self.limits.clone(), ..*self };
            let found = program.solve()?;
            let certificate = found.certificate.clone().of_mass(mass);
            return Ok(Optimum { objective: mass, certificate, shadow_prices: Vec::new(), ..found });
        }
        let inertia = Objective::single(Quantity::ReflectedInertia);
        let smallest = RatioProgram { objective: &inertia, limits: self.limits.clone(), ..*self };
        let smallest = match smallest.solve() {
            Ok(optimum) => optimum,
            other => return other,
        };
        let Some(mass) = candidate.mass_at(smallest.ratio) else {
            return Err(Refusal::NotSolved(Unsolved::NoMass));
        };
        let same_mass = candidate.gear.mass_per_stage.map_or(f64::INFINITY, |(_, stage_ratio)| {
            stage_ratio.powi(gearwise_model::requirement::stages(smallest.ratio, stage_ratio) as i32).max(1.0)
        });
        let loss = Objective::single(Quantity::Loss);
        let range = (self.range.0, self.range.1.min(same_mass.max(smallest.ratio)));
        match (RatioProgram { objective: &loss, range, limits: self.limits.clone(), ..*self }.solve()) {
            Ok(optimum) => Ok(Optimum {
                objective: mass,
                windows: smallest.windows,
                certificate: smallest.certificate.of_mass(mass),
                shadow_prices: Vec::new(),
                ..optimum
            }),
            other => other,
        }
    }
}

/// The largest N whose stages keep a limit on mass; zero where none does.
fn largest_ratio_by_mass(candidate: &Candidate, asked: &Asked) -> f64 {
    // Asked with an unknown mass only where what is known is too much already.
    let without_stages = candidate.known_mass_at(1.0);
    match candidate.gear.mass_per_stage {
        Some((mass, stage_ratio)) if mass > 0.0 => {
            let stages = ((asked.bound - without_stages) / mass * (1.0 + 1e-12)).floor();
            if stages < 0.0 { 0.0 } else { stage_ratio.powf(stages) }
        }
        _ if candidate.known_mass_at(1.0) <= asked.bound * (1.0 + ROW_TOLERANCE) => f64::INFINITY,
        _ => 0.0,
    }
}

/// The largest N with `c + d N^p ≤ bound` for p of 1 to 4; zero where there is none.
pub(crate) fn largest_ratio_within(polynomial: &Laurent, bound: f64) -> f64 {
    let left = bound - polynomial[0];
    match (1..=4).find(|power| polynomial[*power] > 0.0) {
        _ if left < 0.0 => 0.0,
        None => f64::INFINITY,
        Some(power) => (left / polynomial[power]).powf(1.0 / f64::from(power)),
    }
}
