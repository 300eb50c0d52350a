//! Every motor at every ratio: feasible, or why not.

use rayon::prelude::*;

use super::judge::{Unknown, unjudged};
use super::{Evaluation, JointDemand, Prepared, Unusable, continuous_candidate, geared_candidate};
use crate::catalog::{Catalog, Motor};
use crate::requirement::{Joint, RatioChoice, Robot};

/// What was found at one joint.
#[derive(Debug)]
pub struct JointSweep<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// Every design that was evaluated, in the order of motor and ratio.
    pub designs: Vec<SweptDesign<'a>>,
    /// Motors, or motors with a gear, that are no candidates.
    pub unusable: Vec<(&'a str, Option<&'a str>, Unusable)>,
}

/// A motor at a ratio.
#[derive(Debug)]
pub struct SweptDesign<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// All about it.
    pub evaluation: Evaluation,
    /// Limits that could not be checked, and why.
    pub unchecked: std::sync::Arc<[Unknown]>,
    /// Of those, what the requirement itself states: with any of them the design is no choice.
    pub unjudged: std::sync::Arc<[Unknown]>,
}

impl SweptDesign<'_> {
    /// Whether it keeps every limit, and every limit that the requirement states could be judged.
    pub fn is_choice(&self) -> bool {
        self.evaluation.feasible && self.unjudged.is_empty()
    }

    /// Whether it keeps all that could be judged, but not all that the requirement states could be.
    pub fn is_unjudged(&self) -> bool {
        self.evaluation.feasible && !self.unjudged.is_empty()
    }
}

/// `count` ratios from `min` to `max`, evenly spaced in ln N.
pub fn grid(min: f64, max: f64, count: usize) -> Vec<f64> {
    match count {
        0 => Vec::new(),
        1 => vec![(min * max).sqrt()],
        _ => (0..count)
            .map(|i| if i + 1 == count { max } else { min * (max / min).powf(i as f64 / (count - 1) as f64) })
            .collect(),
    }
}

/// Evaluates every motor at every ratio of the grid (`ratios` of them), or with every gear of the
/// catalogue that the joint allows and that fits.
pub fn sweep<'a>(robot: &'a Robot, catalog: &'a Catalog, ratios: usize) -> Vec<JointSweep<'a>> {
    sweep_with_progress(robot, catalog, ratios, &|| {})
}

/// As [`sweep`]; `tick` is called once for each motor and joint that is done.
pub fn sweep_with_progress<'a>(
    robot: &'a Robot,
    catalog: &'a Catalog,
    ratios: usize,
    tick: &(dyn Fn() + Sync),
) -> Vec<JointSweep<'a>> {
    let demands: Vec<JointDemand> = robot.joints.par_iter().map(|j| JointDemand::new(j, catalog)).collect();
    robot
        .joints
        .iter()
        .zip(&demands)
        .map(|(joint, demand)| {
            let one = |motor| {
                let swept = sweep_motor(robot, joint, demand, motor, ratios);
                tick();
                swept
            };
            let per_motor: Vec<_> = catalog.motors.par_iter().map(one).collect();
            let mut result = JointSweep { joint, designs: Vec::new(), unusable: Vec::new() };
            for (designs, unusable) in per_motor {
                result.designs.extend(designs);
                result.unusable.extend(unusable);
            }
            result
        })
        .collect()
}

fn swept<'a>(prepared: &Prepared, motor: &'a Motor, gear: Option<&'a str>, ratio: f64) -> SweptDesign<'a> {
    let unchecked = prepared.unchecked_at(ratio);
    let unjudged = unjudged(prepared.candidate.robot, prepared.candidate.joint, &unchecked);
    let evaluation = prepared.at(ratio);
    SweptDesign { motor, gear, evaluation, unchecked: unchecked.into(), unjudged: unjudged.into() }
}

type MotorSweep<'a> = (Vec<SweptDesign<'a>>, Vec<(&'a str, Option<&'a str>, Unusable)>);

fn sweep_motor<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    motor: &'a Motor,
    ratios: usize,
) -> MotorSweep<'a> {
    let (mut designs, mut unusable) = (Vec::new(), Vec::new());
    match &joint.ratio {
        RatioChoice::Continuous { min, max } => match continuous_candidate(robot, joint, &demand.load, motor) {
            Ok(candidate) => {
                let prepared = Prepared::new(candidate);
                designs.extend(grid(*min, *max, ratios).into_iter().map(|ratio| swept(&prepared, motor, None, ratio)));
            }
            Err(why) => unusable.push((motor.id.as_str(), None, why)),
        },
        RatioChoice::Catalog { .. } => {
            for (gear, load) in demand.gears_for(motor) {
                match geared_candidate(robot, joint, load, motor, gear) {
                    Ok(candidate) => {
                        designs.push(swept(&Prepared::new(candidate), motor, Some(&gear.id), gear.ratio));
                    }
                    Err(why) => unusable.push((motor.id.as_str(), Some(gear.id.as_str()), why)),
                }
            }
            if designs.is_empty() && unusable.is_empty() {
                unusable.push((motor.id.as_str(), None, Unusable::NoGearFits));
            }
        }
    }
    (designs, unusable)
}
