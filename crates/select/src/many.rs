//! Motions of very many samples, such as those of a simulator's episodes.
//!
//! The one idea: a search looks at few samples, and its answer is looked at over all of them. Fewer samples are fewer
//! limits: what cannot be done with them cannot be done at all, and the best that can be done with them is the best of all
//! where it keeps the limits at all samples. Where it does not, the samples that are exceeded are added, until nothing is.
//! Means and heat are always of all samples.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::answer::{Design, JointResult, RobotResult};
use super::evaluate::{Evaluation, FEASIBILITY_TOLERANCE, Margin, Prepared};
use super::loads::{MANY, remember};
use super::mount::{JointDemand, Mount};
use super::optimize::optimize_with;
use super::options::{Options, Stop, Stopped};
use gearwise_model::catalog::Catalog;
use gearwise_model::motion::Motion;
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Quantity, Robot};

/// Rounds after which all samples are looked at.
const ROUNDS: usize = 30;
/// Ratios of a window that are looked at over all samples, its ends among them.
const LOOKS: usize = 9;
/// A margin that is smaller by more is another.
const SAME: f64 = 1e-9;

/// How a joint's samples were looked at.
#[derive(Debug, Clone, PartialEq)]
pub struct Looked {
    /// Name of the joint.
    pub joint: String,
    /// Samples that the search looked at.
    pub at: usize,
    /// Samples of the motion.
    pub of: usize,
    /// How often samples were added.
    pub rounds: usize,
}

/// Whether a joint's motion is looked at in part: not where what is minimised is itself the largest over samples, or where
/// a spring is still to be chosen.
fn is_many(joint: &Joint) -> bool {
    let peak = |quantity: Quantity| joint.objective.weight(quantity) > 0.0;
    let motion = &joint.motion;
    motion.len() > MANY
        && motion.cases.is_none()
        && motion.looked.is_none()
        && joint.passed.is_none()
        && joint.gear_map.is_none()
        && joint.limits.spring.is_none()
        && !peak(Quantity::PeakCurrent)
        && !peak(Quantity::PeakPower)
}

/// A robot with the samples that a search should look at, so that what it finds keeps the limits at all samples, which
/// [`with_exceeded`] makes sure of; and how they were found. A robot whose motions are short stays as it is.
///
/// # Errors
/// It was stopped.
pub fn with_samples(robot: Robot, catalog: &Catalog, options: Options) -> Result<(Robot, Vec<Looked>), Stopped> {
    let wanted = |place: &usize| options.joint.is_none_or(|only| only == *place);
    let places: Vec<usize> = (0..robot.joints.len()).filter(wanted).filter(|j| is_many(&robot.joints[*j])).collect();
    if places.is_empty() || robot.is_coupled() {
        return Ok((robot, Vec::new()));
    }
    let stop = Stop::when(options.stop);
    let whole = robot.clone();
    let demands: Vec<JointDemand> = places.iter().map(|j| JointDemand::new(&whole.joints[*j], catalog)).collect();
    let mut looked: Vec<BTreeSet<usize>> = places.iter().map(|j| extremes(&whole.joints[*j].motion)).collect();
    let mut rounds = vec![0; places.len()];
    let mut robot = robot;
    // A design that keeps the limits at all samples stays the best of its motor when more of them are looked at.
    let mut left = catalog.clone();
    for round in 0.. {
        for (k, (place, looked)) in places.iter().zip(&looked).enumerate() {
            let joint = &mut robot.joints[*place];
            let motion = Motion::clone(&whole.joints[*place].motion);
            let some: Arc<[usize]> = looked.iter().copied().collect();
            joint.motion = Arc::new(Motion { looked: Some(some).filter(|_| round < ROUNDS), ..motion });
            if joint.ripple().is_none() {
                // Means are those of all samples: they are not made again.
                remember(&joint.motion, &demands[k].load.looked_at(&joint.motion));
            }
        }
        if round == ROUNDS {
            break;
        }
        let options = Options { tick: &|| (), reasons: false, leftover: false, joint: None, ..options };
        let found = optimize_with(&robot, &left, options)?;
        let mut motors = BTreeSet::new();
        for (k, place) in places.iter().enumerate() {
            // Motors may exceed a limit at the same sample.
            let known = looked[k].clone();
            for (motor, fresh) in exceeded((&whole, &whole.joints[*place]), &demands[k], &found.joints[*place], stop)? {
                if fresh.iter().any(|sample| !known.contains(sample)) {
                    motors.insert(motor);
                    rounds[k] = round + 1;
                }
                looked[k].extend(fresh);
            }
        }
        if motors.is_empty() {
            break;
        }
        let motors: BTreeSet<String> = motors.into_iter().map(String::from).collect();
        drop(found);
        left.motors.retain(|motor| motors.contains(&motor.id));
    }
    let told = places.iter().zip(rounds).map(|(place, rounds)| {
        let joint = &robot.joints[*place];
        Looked { joint: joint.name.clone(), at: joint.motion.looked_at().len(), of: joint.motion.len(), rounds }
    });
    let told = told.collect();
    Ok((robot, told))
}

/// The robot of an answer with the samples that its designs exceed and that were not looked at; `None` where there are none. `looked`
/// says how the joints' samples were looked at, and is kept up.
///
/// # Errors
/// It was stopped.
pub fn with_exceeded(
    found: &RobotResult,
    looked: &mut [Looked],
    catalog: &Catalog,
    options: Options,
) -> Result<Option<Robot>, Stopped> {
    let stop = Stop::when(options.stop);
    let with = |joint: &Joint, some: Option<Arc<[usize]>>| Motion { looked: some, ..Motion::clone(&joint.motion) };
    let mut more: Option<Robot> = None;
    for looked in looked {
        let Some(of) = found.joints.iter().find(|of| of.joint.name == looked.joint) else { continue };
        let Some(before) = &of.joint.motion.looked else { continue };
        let whole = Joint { motion: Arc::new(with(of.joint, None)), ..of.joint.clone() };
        let demand = JointDemand::new(&whole, catalog);
        let mut at: BTreeSet<usize> = before.iter().copied().collect();
        exceeded((found.robot, &whole), &demand, of, stop)?.into_iter().for_each(|(_, fresh)| at.extend(fresh));
        if at.len() == before.len() {
            continue;
        }
        looked.rounds += 1;
        let all = looked.rounds >= ROUNDS;
        looked.at = if all { looked.of } else { at.len() };
        let robot = more.get_or_insert_with(|| found.robot.clone());
        if let Some(joint) = robot.joints.iter_mut().find(|joint| joint.name == looked.joint) {
            joint.motion = Arc::new(with(joint, Some(at.into_iter().collect()).filter(|_| !all)));
        }
    }
    Ok(more)
}

/// The samples at which designs of a joint exceed more than the samples that were looked at say, at their ratios and over
/// their windows, by motor.
fn exceeded<'f>(
    (robot, whole): (&Robot, &Joint),
    demand: &JointDemand,
    found: &'f JointResult,
    stop: Stop,
) -> Result<Vec<(&'f str, Vec<usize>)>, Stopped> {
    let designs: Vec<&Design> = found.designs().collect();
    let one = |design: &&'f Design| -> Result<(&'f str, Vec<usize>), Stopped> {
        let id = design.motor.id.as_str();
        let (load, gear) = (demand.load_with(design.gear), design.gear.and_then(|id| demand.gear(id)));
        let Ok(prepared) = Mount::new(robot, whole, load, design.motor).with_gear(gear).prepared() else {
            return Ok((id, Vec::new()));
        };
        let mut fresh = farther(&prepared, &design.evaluation);
        for window in &design.optimum.windows {
            let inside = if window.min < window.max { grid(window.min, window.max, LOOKS) } else { vec![window.min] };
            for ratio in inside {
                stop.unless(())?;
                let there = prepared.at(ratio).margins;
                fresh.extend(there.into_iter().filter(|m| m.margin < -FEASIBILITY_TOLERANCE).filter_map(|m| m.sample));
            }
        }
        Ok((id, fresh))
    };
    designs.par_iter().map(one).collect()
}

/// The samples that make a figure of a design worse than that of the samples that were looked at.
fn farther(whole: &Prepared, part: &Evaluation) -> Vec<usize> {
    let all = whole.at_in_full(part.ratio);
    let known = |limit: &str| part.least(limit).map(|least| least.margin);
    let smaller = |margin: &&Margin| known(margin.limit).is_none_or(|known| margin.margin < known - SAME);
    let mut fresh: Vec<usize> = all.margins.iter().filter(smaller).filter_map(|margin| margin.sample).collect();
    let more = |all: f64, part: f64| all > part + SAME * part.abs();
    if more(all.peak_current, part.peak_current) || all.peak_power.zip(part.peak_power).is_some_and(|(a, b)| more(a, b))
    {
        fresh.extend(whole.peak_samples(part.ratio));
    }
    fresh
}

/// The samples that are farthest out: of each direction of power, along sums and differences of what limits are made of.
fn extremes(motion: &Motion) -> BTreeSet<usize> {
    let columns = [&motion.torque, &motion.velocity, &motion.acceleration, &motion.torque_rate, &motion.jerk];
    let sizes = columns.map(|values| {
        let squares: f64 = values.iter().map(|v| v * v).sum();
        (squares / values.len() as f64).sqrt().max(f64::MIN_POSITIVE)
    });
    let directions: Vec<[f64; 5]> = (0..243)
        .map(|code: usize| std::array::from_fn(|k| (code / 3_usize.pow(k as u32) % 3) as f64 - 1.0))
        .filter(|direction: &[f64; 5]| direction.iter().any(|d| *d != 0.0))
        .collect();
    let flows = |k: usize| usize::from(motion.torque[k] * motion.velocity[k] < 0.0);
    let farthest = |direction: &[f64; 5]| {
        let mut best = [(f64::NEG_INFINITY, usize::MAX); 2];
        for k in 0..motion.len() {
            let out: f64 = (0..5).map(|c| direction[c] * columns[c][k] / sizes[c]).sum();
            let of = &mut best[flows(k)];
            if out > of.0 {
                *of = (out, k);
            }
        }
        best.map(|(_, k)| k)
    };
    let found: Vec<[usize; 2]> = directions.par_iter().map(farthest).collect();
    found.into_iter().flatten().filter(|k| *k < motion.len()).collect()
}

#[cfg(test)]
mod tests;
