//! Joints with a parallel spring: motor, gear, ratio and spring chosen together, and what the spring is
//! worth: the same joint with the same motor and no spring stands beside every choice.

use super::optimize::{Design, Reason, design};
use super::program::spring::{self, SpringOptimum, Sprung};
use super::program::{Certificate, Optimum, Outcome, RatioProgram};
use super::{JointDemand, Prepared, Unusable, continuous_candidate, covers_gear, geared_candidate};
use crate::catalog::{Gear, Motor};
use crate::requirement::{Joint, RatioChoice, Robot};

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

/// The same as a design.
fn solve<'a>(
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

/// The best design with a spring of one motor at one joint, or the gear that came nearest and why.
///
/// # Errors
/// Why the motor cannot do it.
pub fn best_design<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    motor: &'a Motor,
    only_checked: bool,
) -> Result<Design<'a>, (Option<&'a str>, Reason)> {
    match &joint.ratio {
        RatioChoice::Continuous { min, max } => {
            let candidate = continuous_candidate(robot, joint, &demand.load, motor)
                .map_err(|unusable| (None, Reason::Unusable(unusable)))?;
            let prepared = Prepared::new(candidate);
            if let (true, Some((limit, why))) = (only_checked, prepared.unchecked.first()) {
                return Err((None, Reason::Unchecked(limit, why)));
            }
            let design = solve(&prepared, joint, motor, None, (*min, *max)).map_err(|reason| (None, reason))?;
            match design.unchecked.first() {
                Some((limit, why)) if only_checked => Err((None, Reason::Unchecked(limit, why))),
                _ => Ok(design),
            }
        }
        RatioChoice::Catalog { .. } => best_gear(robot, joint, demand, motor, only_checked),
    }
}

/// The best gear: the spring is solved for with each that fits.
fn best_gear<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    motor: &'a Motor,
    only_checked: bool,
) -> Result<Design<'a>, (Option<&'a str>, Reason)> {
    let mut best: Option<Design<'a>> = None;
    let mut refused: Option<(Option<&'a str>, Reason)> = None;
    // The least bound over all gears; `None` once one has none.
    let mut bound = Some(f64::INFINITY);
    for (gear, load) in demand.gears_for(motor) {
        let candidate = match geared_candidate(robot, joint, load, motor, gear) {
            Ok(candidate) => candidate,
            Err(why) => {
                refused = refused.or(Some((Some(&gear.id), Reason::Unusable(why))));
                continue;
            }
        };
        let prepared = Prepared::new(candidate);
        if let (true, Some((limit, why))) = (only_checked, prepared.unchecked.first()) {
            refused = refused.or(Some((Some(&gear.id), Reason::Unchecked(limit, why))));
            continue;
        }
        match solve(&prepared, joint, motor, Some(gear), (gear.ratio, gear.ratio)) {
            Ok(design) if only_checked && !design.unchecked.is_empty() => {
                let (limit, why) = design.unchecked[0];
                bound = None;
                refused = refused.or(Some((Some(&gear.id), Reason::Unchecked(limit, why))));
            }
            Ok(design) => {
                bound = bound.zip(design.spring.and_then(|s| s.lower_bound)).map(|(a, b)| a.min(b));
                let better = |b: &Design| {
                    (design.optimum.objective, design.evaluation.loss) < (b.optimum.objective, b.evaluation.loss)
                };
                if best.as_ref().is_none_or(better) {
                    best = Some(design);
                }
            }
            Err(why) => {
                if matches!(why, Reason::NotSolved(_)) {
                    bound = None;
                }
                refused = Some((Some(&gear.id), why));
            }
        }
    }
    let Some(mut design) = best else {
        let unusable = if motor.rotor_inertia.is_none() { Unusable::RotorInertia } else { Unusable::NoGearFits };
        return Err(refused.unwrap_or((None, Reason::Unusable(unusable))));
    };
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
        design.optimum.certificate = Certificate::NotCertified("another gear's spring could not be solved for".into());
    }
    if let Some(spring) = &mut design.spring {
        (spring.lower_bound, spring.gap) = (bound, gap);
    }
    Ok(design)
}
