//! Motions of very many samples, such as those of a simulator's episodes.
//!
//! The one idea: a search looks at few samples, and its answer is looked at over all of them. Fewer samples are fewer
//! limits: what cannot be done with them cannot be done at all, and the best that can be done with them is the best of all
//! where it keeps the limits at all samples. Where it does not, the samples that are exceeded are added, until nothing is.
//! Means and heat are always of all samples.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;

use super::answer::{Design, JointResult};
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

/// A robot with the samples that a search has to look at, so that what it finds keeps the limits at all samples; and how
/// that was found out. A robot whose motions are short stays as it is.
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
        let found = optimize_with(&robot, catalog, Options { tick: &|| (), reasons: false, joint: None, ..options })?;
        let mut grew = false;
        for (k, place) in places.iter().enumerate() {
            let fresh = exceeded(&whole, &demands[k], &found.joints[*place], stop)?;
            let before = looked[k].len();
            looked[k].extend(fresh);
            if looked[k].len() > before {
                (grew, rounds[k]) = (true, round + 1);
            }
        }
        if !grew {
            break;
        }
    }
    let told = places.iter().zip(rounds).map(|(place, rounds)| {
        let joint = &robot.joints[*place];
        Looked { joint: joint.name.clone(), at: joint.motion.looked_at().len(), of: joint.motion.len(), rounds }
    });
    let told = told.collect();
    Ok((robot, told))
}

/// The samples at which designs of a joint exceed more than the samples that were looked at say, at their ratios and over
/// their windows.
fn exceeded(whole: &Robot, demand: &JointDemand, found: &JointResult, stop: Stop) -> Result<BTreeSet<usize>, Stopped> {
    let joint = whole.joints.iter().find(|joint| joint.name == found.joint.name).unwrap_or(found.joint);
    let designs: Vec<&Design> = found.designs().collect();
    let one = |design: &&Design| -> Result<Vec<usize>, Stopped> {
        let (load, gear) = (demand.load_with(design.gear), design.gear.and_then(|id| demand.gear(id)));
        let Ok(prepared) = Mount::new(whole, joint, load, design.motor).with_gear(gear).prepared() else {
            return Ok(Vec::new());
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
        Ok(fresh)
    };
    let all: Result<Vec<Vec<usize>>, Stopped> = designs.par_iter().map(one).collect();
    Ok(all?.into_iter().flatten().collect())
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
