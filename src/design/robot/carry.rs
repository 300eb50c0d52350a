//! Actuators that carry actuators: the load of a joint depends on what its carried joints weigh.
//!
//! What is carried is chosen first; the carrying joint is then solved for exactly that load. Until then a
//! bound does: the load lies in a box of torques, at whose centre the loss is known; by the triangle
//! inequality the root of the loss is nowhere less than there by more than the root mean square of the box's
//! half width.

use rayon::prelude::*;

use super::convex::under;
use super::menu::Needs;
use crate::catalog::Catalog;
use crate::design::program::{minimise, value};
use crate::design::sweep::grid;
use crate::design::{JointDemand, Prepared, continuous_candidate, geared_candidate};
use crate::requirement::{Joint, Quantity, RatioChoice, Robot};

/// How many boxes a joint's load is divided into.
const BOXES: f64 = 200.0;
/// Pieces of the range of ratios.
const PIECES: usize = 16;

/// Joints in an order in which what is carried comes before what carries it.
pub(super) fn order(joints: &[Joint]) -> Vec<usize> {
    let mut order: Vec<usize> = Vec::new();
    while order.len() < joints.len() {
        let ready = |j: &usize| joints[*j].carries.iter().all(|c| order.contains(&c.joint));
        match (0..joints.len()).filter(|j| !order.contains(j)).find(ready) {
            Some(next) => order.push(next),
            // The reader lets no cycle through.
            None => break,
        }
    }
    order
}

/// The directions in which a joint's load moves: one for all constant torques per mass, one for each other.
pub(super) fn coordinates(joint: &Joint, mass: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut constant = None;
    let mut others = Vec::new();
    for carried in &joint.carries {
        let mass = mass(carried.joint);
        if carried.constant {
            let coefficient = carried.torque_per_mass.first().copied().unwrap_or(0.0);
            *constant.get_or_insert(0.0) += coefficient * mass;
        } else {
            others.push(mass);
        }
    }
    constant.into_iter().chain(others).collect()
}

/// Lowest and highest coordinates for masses in intervals.
pub(super) fn reach(joint: &Joint, mass: impl Fn(usize) -> (f64, f64)) -> Vec<(f64, f64)> {
    let mut constant: Option<(f64, f64)> = None;
    let mut others = Vec::new();
    for carried in &joint.carries {
        let (least, most) = mass(carried.joint);
        if carried.constant {
            let coefficient = carried.torque_per_mass.first().copied().unwrap_or(0.0);
            let (a, b) = (coefficient * least, coefficient * most);
            let sum = constant.get_or_insert((0.0, 0.0));
            *sum = (sum.0 + a.min(b), sum.1 + a.max(b));
        } else {
            others.push((least, most));
        }
    }
    constant.into_iter().chain(others).collect()
}

/// What one unit of each coordinate adds to torque and torque rate of a sample.
fn directions(joint: &Joint) -> Vec<(Vec<f64>, Vec<f64>)> {
    let samples = joint.motion.len();
    let constant = joint.carries.iter().any(|c| c.constant).then(|| (vec![1.0; samples], vec![0.0; samples]));
    let others = joint.carries.iter().filter(|c| !c.constant).map(|c| (c.torque_per_mass.clone(), c.rate.clone()));
    constant.into_iter().chain(others).collect()
}

/// The joint with the load that it has at some coordinates.
pub(super) fn loaded(joint: &Joint, coordinates: &[f64]) -> Joint {
    let mut loaded = joint.clone();
    for ((torque, rate), y) in directions(joint).iter().zip(coordinates) {
        for k in 0..torque.len() {
            loaded.motion.torque[k] += y * torque[k];
            loaded.motion.torque_rate[k] += y * rate[k];
        }
    }
    loaded
}

/// Lower bounds of a joint's objective over its load.
#[derive(Debug)]
pub(super) struct Boxes {
    reach: Vec<(f64, f64)>,
    count: usize,
    bounds: Vec<f64>,
}

impl Boxes {
    /// Over all loads that a joint can have.
    pub(super) fn new(robot: &Robot, joint: &Joint, catalog: &Catalog, reach: Vec<(f64, f64)>, needs: Needs) -> Boxes {
        let count = BOXES.powf(1.0 / reach.len().max(1) as f64).floor().max(1.0) as usize;
        let total = count.pow(reach.len() as u32);
        let directions = directions(joint);
        let bound = |index: usize| {
            let (mut rest, mut center, mut half) = (index, Vec::new(), Vec::new());
            for (low, high) in &reach {
                let width = (high - low) / count as f64;
                center.push(low + width * ((rest % count) as f64 + 0.5));
                half.push(0.5 * width);
                rest /= count;
            }
            bound(robot, joint, &loaded(joint, &center), catalog, &directions, &half, needs)
        };
        Boxes { bounds: (0..total).into_par_iter().map(bound).collect(), reach, count }
    }

    /// The least bound over a part of the loads.
    pub(super) fn least(&self, part: &[(f64, f64)]) -> f64 {
        let places: Vec<(usize, usize)> = part
            .iter()
            .zip(&self.reach)
            .map(|((a, b), (low, high))| {
                let place = |y: f64| {
                    let share = if high > low { (y - low) / (high - low) } else { 0.0 };
                    (share * self.count as f64).floor().clamp(0.0, (self.count - 1) as f64) as usize
                };
                // An end on the edge of a box belongs to both sides of it.
                let slack = 1e-9 * (high - low);
                (place(a - slack), place(b + slack))
            })
            .collect();
        let inside = |index: &usize| {
            let mut rest = *index;
            places.iter().all(|(a, b)| {
                let here = rest % self.count;
                rest /= self.count;
                (*a..=*b).contains(&here)
            })
        };
        (0..self.bounds.len()).filter(inside).map(|i| self.bounds[i]).fold(f64::INFINITY, f64::min)
    }
}

/// The bound over one box: over all motors, whether or not they keep their limits.
fn bound(
    robot: &Robot,
    joint: &Joint,
    center: &Joint,
    catalog: &Catalog,
    directions: &[(Vec<f64>, Vec<f64>)],
    half: &[f64],
    needs: Needs,
) -> f64 {
    // Energy may be less than nothing; all else is not.
    if joint.objective.weight(Quantity::Energy) > 0.0 {
        return f64::NEG_INFINITY;
    }
    let weight = joint.objective.weight(Quantity::Loss);
    if weight == 0.0 || joint.limits.spring.is_some() || needs.only_checked {
        return 0.0;
    }
    let width = |k: usize| directions.iter().zip(half).map(|((torque, _), h)| torque[k].abs() * h).sum::<f64>();
    let radius = joint.motion.mean(|k| width(k).powi(2)).sqrt();
    let demand = JointDemand::new(center, catalog);
    let of = |prepared: &Prepared, ratios: &[f64], gear_loss: f64| -> f64 {
        let actuator = &prepared.candidate.actuator;
        if actuator.shortfall.saturates() || prepared.candidate.is_evaluated() {
            return 0.0;
        }
        let loss = prepared.loss();
        let reach = actuator.heating().sqrt() * gear_loss * radius;
        let piece = |w: &[f64]| {
            let convex = under(&loss, (w[0], w[1]), (w[0] * w[1]).sqrt());
            let least = value(&convex, minimise(&convex, w[0] * w[0], w[1] * w[1])).max(0.0);
            (least.sqrt() - reach / w[0]).max(0.0).powi(2)
        };
        ratios.windows(2).map(piece).fold(f64::INFINITY, f64::min) * (1.0 - 1e-9)
    };
    let steepest = |efficiency: f64, back: f64| (1.0 / efficiency).max(back.abs());
    let of_motor = |motor| match &joint.ratio {
        RatioChoice::Continuous { min, max } => {
            let Ok(candidate) = continuous_candidate(robot, center, &demand.load, motor) else { return f64::INFINITY };
            let ratios = if max > min { grid(*min, *max, PIECES + 1) } else { vec![*min, *min] };
            let gear = candidate.gear;
            of(&Prepared::new(candidate), &ratios, steepest(gear.efficiency, gear.backdrive_efficiency))
        }
        RatioChoice::Catalog { .. } => demand
            .gears_for(motor)
            .filter_map(|(gear, load)| geared_candidate(robot, center, load, motor, gear).ok().map(|c| (gear.ratio, c)))
            .map(|(ratio, candidate)| {
                let gear = candidate.gear;
                of(&Prepared::new(candidate), &[ratio, ratio], steepest(gear.efficiency, gear.backdrive_efficiency))
            })
            .fold(f64::INFINITY, f64::min),
    };
    weight * catalog.motors.iter().map(of_motor).fold(f64::INFINITY, f64::min)
}
