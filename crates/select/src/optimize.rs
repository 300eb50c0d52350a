//! All motors of a catalogue for all joints of a robot: the best ratio of each, ranked.

use std::sync::atomic::AtomicU64;

use rayon::prelude::*;

use super::agreement::kendall_tau;
use super::answer::{Agreement, Design, JointResult, Refused, RobotResult, Sorted};
use super::mount::{JointDemand, Site};
use super::options::{Options, Stop, Stopped};
use super::prune;
use super::windings::best_wound;
use gearwise_model::actuator::metrics::{METRICS, Shown};
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::requirement::{Joint, Robot};

/// Finds the best ratio of every motor at every joint.
pub fn optimize<'a>(robot: &'a Robot, catalog: &'a Catalog) -> RobotResult<'a> {
    optimize_with(robot, catalog, Options::default()).expect("nobody stops it")
}

/// As [`optimize`], with options.
///
/// # Errors
/// It was stopped.
pub fn optimize_with<'a>(robot: &'a Robot, catalog: &'a Catalog, options: Options) -> Result<RobotResult<'a>, Stopped> {
    if let Some(joint) = options.joint {
        let joints = vec![solve_joint(robot, &robot.joints[joint], catalog, options)?];
        return Ok(RobotResult { robot, joints });
    }
    // Joints that ask the same have the same answer: it is found once.
    let first: Vec<usize> = (0..robot.joints.len())
        .map(|j| (0..j).find(|i| robot.joints[*i].asks_the_same(&robot.joints[j])).unwrap_or(j))
        .collect();
    let distinct: Vec<usize> = (0..first.len()).filter(|j| first[*j] == *j).collect();
    let alike = |j: usize| first.iter().filter(|f| **f == j).count();
    let solved: Result<Vec<JointResult>, Stopped> = distinct
        .par_iter()
        .map(|j| {
            let times = alike(*j);
            let tick = || (0..times).for_each(|_| (options.tick)());
            solve_joint(robot, &robot.joints[*j], catalog, Options { tick: &tick, ..options })
        })
        .collect();
    let solved = solved?;
    let joints = robot.joints.iter().zip(&first).map(|(joint, first)| {
        let answer = &solved[distinct.binary_search(first).expect("the first of its kind was solved")];
        JointResult { joint, ..answer.clone() }
    });
    Ok(RobotResult { robot, joints: joints.collect() })
}

/// All motors at one joint.
fn solve_joint<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    catalog: &'a Catalog,
    options: Options,
) -> Result<JointResult<'a>, Stopped> {
    let demand = JointDemand::among(joint, catalog, options.loads);
    let gears_without_efficiency = demand.without_efficiency();
    let stop = Stop::when(options.stop);
    let done = AtomicU64::new(0);
    let site = Site::new(robot, joint, &demand).stopping(stop.adding(&done));
    if let Some(keep) = options.keep {
        let (found, pruned) = prune::first(site, catalog, keep, &options)?;
        let Sorted { candidates, unjudged, rejected } = found;
        let pruned = Some(pruned);
        return Ok(JointResult {
            joint,
            candidates,
            unjudged,
            rejected,
            agreement: Vec::new(),
            pruned,
            gears_without_efficiency,
        });
    }
    let motors: Vec<&Motor> = catalog.motors.iter().filter(|motor| !joint.motors.pass_over(motor)).collect();
    let solve = |motor: &&'a Motor| {
        let found = best_wound(site, motor, options.only_checked);
        (options.tick)();
        stop.unless(found)
    };
    let mut found = motors.par_iter().map(solve).collect::<Result<Vec<Result<Design, Refused>>, Stopped>>()?;
    // Motors whose search ended get the work that the others left over.
    let ended: Vec<usize> = (0..motors.len()).filter(|k| options.leftover && has_ended(&found[*k])).collect();
    if let Some(longer) = site.stop.again(motors.len(), ended.len()).filter(|_| !ended.is_empty()) {
        let site = Site { stop: longer, ..site };
        let solve = |k: &usize| stop.unless(best_wound(site, motors[*k], options.only_checked));
        let again = ended.par_iter().map(solve).collect::<Result<Vec<_>, Stopped>>()?;
        ended.into_iter().zip(again).for_each(|(k, again)| found[k] = again);
    }
    let Sorted { candidates, unjudged, rejected } = Sorted::of(found);
    let agreement = agreement(&candidates);
    Ok(JointResult { joint, agreement, candidates, unjudged, rejected, pruned: None, gears_without_efficiency })
}

/// True if a motor's search ended after its share of the work.
fn has_ended(found: &Result<Design, Refused>) -> bool {
    match found {
        Ok(design) => design.optimum.certificate.is_ended(),
        Err(why) => why.is_ended(),
    }
}

/// Kendall's τ of each metric against the objective, over the feasible motors.
fn agreement(candidates: &[Design]) -> Vec<Agreement> {
    METRICS
        .iter()
        .filter(|m| m.shown == Shown::AsOrder)
        .map(|metric| {
            let sign = if metric.lower_is_better { 1.0 } else { -1.0 };
            let pairs: Vec<(f64, f64)> =
                candidates.iter().filter_map(|d| Some((sign * metric.value(d.motor)?, d.optimum.objective))).collect();
            let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
            Agreement { metric: metric.name, tau: kendall_tau(&a, &b), motors: a.len() }
        })
        .collect()
}
