//! Joints with a parallel spring: motor, gear, ratio and spring chosen together, and what the spring is
//! worth: the same joint with the same motor and no spring stands beside every choice.

use super::judge::{self, Refused};
use super::optimize::{Design, Reason, Rejected, design};
use super::program::spring::{self, SpringOptimum, Sprung};
use super::program::{Certificate, Optimum, Outcome, RatioProgram};
use super::{JointDemand, Prepared, Unusable, covers_gear, geared_candidate};
use crate::catalog::{Gear, Motor};
use crate::requirement::{Joint, Robot};

/// A spring that was chosen, and the same joint without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringChoice {
    /// Stiffness \[N·m/rad\].
    pub stiffness: f64,
    /// Rest angle \[rad\]; `None` without stiffness.
    pub rest_angle: Option<f64>,
    /// No ratio and spring are better than this, in the objective's unit; `None` where no bound was found.
    pub lower_bound: Option<f64>,
    /// Relative gap between objective and bound.
    pub gap: Option<f64>,
    /// Whether the objective leaves the spring free, so that the least stiffness was taken.
    pub least_stiffness: bool,
    /// The same motor (and gear) without a spring; `None` where no ratio keeps the limits then.
    pub without: Option<WithoutSpring>,
}

/// The best a motor does without a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithoutSpring {
    /// Ratio, N.
    pub ratio: f64,
    /// Objective.
    pub objective: f64,
    /// Mean copper loss \[W\].
    pub loss: f64,
}

impl SpringChoice {
    /// Share of the loss without spring that the spring saves; `None` where there is nothing to compare
    /// with.
    pub fn saving(&self, loss: f64) -> Option<f64> {
        self.without.filter(|w| w.loss > 0.0).map(|w| 1.0 - loss / w.loss)
    }
}

/// Inertia at the output \[kg·m²\] that a gear's efficiency covers at a joint.
pub fn covered_inertia(joint: &Joint, gear: &Gear) -> f64 {
    gear.inertia.filter(|_| covers_gear(joint)).map_or(0.0, |inertia| inertia * gear.ratio * gear.ratio)
}

/// The best that a motor does without the spring in a range of ratios.
fn without_spring(prepared: &Prepared, joint: &Joint, min: f64, max: f64) -> Option<WithoutSpring> {
    let (ratio, objective) = if min == max && prepared.candidate.catalog_gear.is_some() {
        let evaluation = prepared.at_in_full(min);
        (min, evaluation.objective(&joint.objective).filter(|_| evaluation.feasible)?)
    } else {
        match RatioProgram::new(prepared, &joint.objective, min, max).solve() {
            Outcome::Optimal(optimum) => (optimum.ratio, optimum.objective),
            _ => return None,
        }
    };
    Some(WithoutSpring { ratio, objective, loss: prepared.at(ratio).loss })
}

/// The best ratio and spring of a candidate given without spring.
///
/// # Errors
/// Why there is none.
pub(super) fn choose(
    prepared: &Prepared,
    joint: &Joint,
    gear: Option<&Gear>,
    (min, max): (f64, f64),
) -> Result<(SpringChoice, Optimum), Reason> {
    let Some(asked) = joint.limits.spring else {
        return Err(Reason::NotSolved("the joint asks for no spring".into()));
    };
    // Effects that are evaluated, or that bend torque over current, have no place in the spring's forms.
    if prepared.candidate.is_evaluated() || !prepared.candidate.actuator.shortfall.is_nothing() {
        return Err(Reason::NotSolved("a spring is not chosen for a motor with these fitted effects".into()));
    }
    let covered = gear.map_or(0.0, |g| covered_inertia(joint, g));
    let found = spring::solve(prepared, &joint.objective, &asked, (min, max), covered).map_err(reason)?;
    let without = without_spring(prepared, joint, min, max);
    let SpringOptimum { stiffness, rest_angle, optimum, lower_bound, gap, least_stiffness } = found;
    Ok((SpringChoice { stiffness, rest_angle, lower_bound, gap, least_stiffness, without }, optimum))
}

/// The allowed spring that comes nearest to keeping the limits, where none does: stiffness \[N·m/rad\] and rest angle
/// \[rad\]. `None` where no spring is chosen for the candidate at all.
pub(super) fn nearest(
    prepared: &Prepared,
    joint: &Joint,
    gear: Option<&Gear>,
    range: (f64, f64),
) -> Option<(f64, f64)> {
    let asked = joint.limits.spring?;
    let covered = gear.map_or(0.0, |g| covered_inertia(joint, g));
    spring::nearest(prepared, &joint.objective, &asked, range, covered)
}

/// The same as a design.
pub(super) fn solve<'a>(
    prepared: &Prepared,
    joint: &Joint,
    motor: &'a Motor,
    gear: Option<&'a Gear>,
    range: (f64, f64),
) -> Result<Design<'a>, Reason> {
    let (choice, optimum) = choose(prepared, joint, gear, range)?;
    let covered = gear.map_or(0.0, |g| covered_inertia(joint, g));
    let sprung = Sprung::new(joint, choice.stiffness, choice.rest_angle.unwrap_or(0.0), covered)
        .ok_or_else(|| Reason::NotSolved("a spring needs a motion with a position".into()))?;
    let sprung = prepared.with_candidate(sprung.candidate(&prepared.candidate));
    let mut design = design(&sprung, motor, gear.map(|g| g.id.as_str()), optimum);
    design.spring = Some(choice);
    Ok(design)
}

fn reason(outcome: Outcome) -> Reason {
    match outcome {
        Outcome::Optimal(_) => Reason::NotSolved("an optimum is no reason".into()),
        Outcome::Infeasible(infeasible) => Reason::Infeasible(infeasible),
        Outcome::Unbounded => Reason::Unbounded,
        Outcome::NotSolved(why) => Reason::NotSolved(why),
    }
}

/// Designs with gears of the catalogue, the best of them, and the least bound over them all.
struct Best<'a> {
    design: Option<Design<'a>>,
    /// `None` once a gear has none.
    bound: Option<f64>,
}

/// The best gear: the spring is solved for with each that fits. Gears with which the design cannot be judged are
/// looked at apart.
///
/// # Errors
/// Why the motor is no choice.
pub(super) fn best_gear<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    motor: &'a Motor,
    only_checked: bool,
) -> Result<Design<'a>, Refused<'a>> {
    let mut best = [true, false].map(|_| Best { design: None, bound: Some(f64::INFINITY) });
    let mut refused: Option<(Option<&'a str>, Reason)> = None;
    for (gear, load) in demand.gears_for(motor) {
        let candidate = match geared_candidate(robot, joint, load, motor, gear) {
            Ok(candidate) => candidate,
            Err(why) => {
                refused = refused.or(Some((Some(&gear.id), Reason::Unusable(why))));
                continue;
            }
        };
        let prepared = Prepared::new(candidate);
        if let Some((limit, why)) = judge::left_out(robot, joint, &prepared.unchecked, only_checked) {
            refused = refused.or(Some((Some(&gear.id), Reason::Unchecked(limit, why))));
            continue;
        }
        match solve(&prepared, joint, motor, Some(gear), (gear.ratio, gear.ratio)) {
            // What can be said of heat depends on the spring: it is asked of the design.
            Ok(design) => match judge::left_out(robot, joint, &design.unchecked, only_checked) {
                Some((limit, why)) => refused = refused.or(Some((Some(&gear.id), Reason::Unchecked(limit, why)))),
                None => {
                    let apart = usize::from(!judge::unjudged(robot, joint, &design.unchecked).is_empty());
                    best[apart].take(design);
                }
            },
            Err(why) => {
                if matches!(why, Reason::NotSolved(_)) {
                    best.iter_mut().for_each(|best| best.bound = None);
                }
                refused = Some((Some(&gear.id), why));
            }
        }
    }
    let found = best.into_iter().find_map(Best::settled);
    let Some(design) = found else {
        let unusable = if motor.rotor_inertia.is_none() { Unusable::RotorInertia } else { Unusable::NoGearFits };
        let (gear, reason) = refused.unwrap_or((None, Reason::Unusable(unusable)));
        return Err(Refused::rejected(Rejected { motor, gear, reason }));
    };
    judge::judged(robot, joint, design, only_checked)
}

impl<'a> Best<'a> {
    /// Takes another gear's design in.
    fn take(&mut self, design: Design<'a>) {
        self.bound = self.bound.zip(design.spring.and_then(|s| s.lower_bound)).map(|(a, b)| a.min(b));
        let key = |d: &Design| (d.optimum.objective, d.evaluation.loss);
        if self.design.as_ref().is_none_or(|b| key(&design) < key(b)) {
            self.design = Some(design);
        }
    }

    /// The best of all, with the proof that no gear has a better one.
    fn settled(self) -> Option<Design<'a>> {
        let Best { design, bound } = self;
        let mut design = design?;
        let objective = design.optimum.objective;
        let gap = bound.map(|b| if objective == 0.0 { 0.0 } else { ((objective - b) / objective.abs()).max(0.0) });
        if let (Certificate::Certified { .. }, Some(lower_bound)) = (&design.optimum.certificate, bound) {
            design.optimum.certificate = match gap {
                Some(gap) if gap <= super::program::GAP_TOLERANCE => {
                    let method = "all gears, each with its best spring";
                    Certificate::Certified { lower_bound: lower_bound.min(objective), gap, method }
                }
                _ => Certificate::NotCertified("another gear's spring could not be bounded closely enough".into()),
            };
        } else if bound.is_none() {
            design.optimum.certificate =
                Certificate::NotCertified("another gear's spring could not be solved for".into());
        }
        if let Some(spring) = &mut design.spring {
            (spring.lower_bound, spring.gap) = (bound, gap);
        }
        Some(design)
    }
}
