//! The first few motors of a joint without solving them all.
//!
//! The one idea: a lower bound per motor is cheap (`RatioProgram::lower_bound`). Motors are solved in the
//! order of their bounds, in blocks of fixed size; once the bound of the next one is above the k-th best
//! objective found, neither it nor any after it can be among the first k. What is found is what solving
//! all would have found, and does not depend on the number of threads: blocks do not. Where nobody asks why a
//! motor cannot, one that certainly cannot is not solved either.

use rayon::prelude::*;

use super::judge::Refused;
use super::optimize::{Design, Options, Sorted, best_design, is_impossible};
use super::program::RatioProgram;
use super::{JointDemand, Prepared, continuous_candidate, geared_candidate};
use crate::catalog::{Catalog, Motor};
use crate::requirement::{Joint, Quantity, RatioChoice, Robot};

/// Motors that are solved together.
const BLOCK: usize = 8;
/// Relative distance by which a bound must be above the k-th best: more than the accuracy of either.
const CLEAR: f64 = 1e-6;

/// What was not solved, because it cannot be among the first.
#[derive(Debug, Clone)]
pub struct Pruned<'a> {
    /// How many designs were to be kept, k.
    pub keep: usize,
    /// Motors that were solved and can do it, but stand behind the first k.
    pub behind: usize,
    /// Motors that certainly cannot do it, where no reason was asked for.
    pub impossible: Vec<&'a Motor>,
    /// Motors that were not solved, each with its lower bound of the objective, by bound.
    pub not_solved: Vec<(&'a Motor, f64)>,
}

/// What came of the motors of a joint that were solved, of the candidates the best `keep`, and the rest.
pub(super) fn first<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    catalog: &'a Catalog,
    keep: usize,
    options: &Options,
) -> (Sorted<'a>, Pruned<'a>) {
    let bounds: Vec<Option<f64>> =
        catalog.motors.par_iter().map(|motor| lower_bound(robot, joint, demand, motor)).collect();
    // A motor without a bound is solved: that gives the reason why it cannot.
    let (mut bounded, mut queue) = (Vec::new(), Vec::new());
    for (index, bound) in bounds.into_iter().enumerate() {
        match bound {
            Some(bound) => bounded.push((bound, index)),
            None => queue.push(index),
        }
    }
    bounded.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    // What was found, by motor; of it only candidates count among the first.
    let mut found: Vec<(usize, Result<Design, Refused>)> = Vec::new();
    let mut objectives: Vec<f64> = Vec::new();
    let mut impossible = Vec::new();
    let mut next = 0;
    loop {
        let kth = keep.checked_sub(1).and_then(|k| objectives.get(k)).copied();
        let may_enter = |bound: f64| kth.is_none_or(|kth| bound - CLEAR * bound.abs() <= kth) && keep > 0;
        let block: Vec<usize> =
            bounded[next..].iter().take(BLOCK).take_while(|(b, _)| may_enter(*b)).map(|b| b.1).collect();
        next += block.len();
        queue.extend(block);
        if queue.is_empty() {
            break;
        }
        let solve = |index: &usize| {
            let motor = &catalog.motors[*index];
            let certain = !options.reasons && is_impossible(robot, joint, demand, motor);
            let found = (!certain).then(|| best_design(robot, joint, demand, motor, options.only_checked));
            (options.tick)();
            found
        };
        let solved: Vec<_> = queue.par_iter().map(solve).collect();
        for (index, result) in queue.drain(..).zip(solved) {
            match result {
                Some(result) => {
                    objectives.extend(result.as_ref().ok().map(|design| design.optimum.objective));
                    found.push((index, result));
                }
                None => impossible.push(index),
            }
        }
        objectives.sort_by(f64::total_cmp);
    }
    if objectives.is_empty() {
        // What stands in the way of a joint without a design is told of every motor.
        let why = |index: &usize| best_design(robot, joint, demand, &catalog.motors[*index], options.only_checked);
        let solved: Vec<_> = impossible.par_iter().map(why).collect();
        found.extend(impossible.drain(..).zip(solved));
    }
    found.sort_by_key(|(index, _)| *index);
    let mut sorted = Sorted::of(found.into_iter().map(|(_, result)| result));
    let behind = sorted.candidates.len().saturating_sub(keep);
    sorted.candidates.truncate(keep);
    let not_solved = bounded[next..].iter().map(|(bound, index)| (&catalog.motors[*index], *bound)).collect();
    impossible.sort_unstable();
    let impossible = impossible.into_iter().map(|index| &catalog.motors[index]).collect();
    (sorted, Pruned { keep, behind, impossible, not_solved })
}

/// What the objective is nowhere below for a motor; `None` where it has to be solved to be told.
fn lower_bound(robot: &Robot, joint: &Joint, demand: &JointDemand, motor: &Motor) -> Option<f64> {
    // A spring takes load off: a bound without it is none.
    if joint.limits.spring.is_some() {
        return None;
    }
    let objective = &joint.objective;
    if objective.weight(Quantity::Mass) > 0.0 && motor.mass.is_none() {
        return None;
    }
    if objective.weight(Quantity::Energy) > 0.0 && !demand.load.has_durations {
        return None;
    }
    match &joint.ratio {
        RatioChoice::Continuous { min, max } => {
            let prepared = Prepared::new(continuous_candidate(robot, joint, &demand.load, motor).ok()?);
            RatioProgram::new(&prepared, objective, *min, *max).lower_bound()
        }
        RatioChoice::Catalog { .. } => {
            let bounds = demand.gears_for(motor).filter_map(|(gear, load)| {
                let prepared = Prepared::new(geared_candidate(robot, joint, load, motor, gear).ok()?);
                RatioProgram::new(&prepared, objective, gear.ratio, gear.ratio).lower_bound()
            });
            bounds.reduce(f64::min)
        }
    }
}
