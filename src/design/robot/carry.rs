//! Actuators that carry actuators: the load of a joint depends on what its carried joints weigh.
//!
//! What is carried is chosen first; the carrying joint is then solved for exactly that load. Until then a
//! bound does: the load lies in a box of torques, at whose centre the loss is known; by the triangle
//! inequality the root of the loss is nowhere less than there by more than the root mean square of the box's
//! half diagonal. Actuators further out load a joint in nearly the same way: the boxes lie along the axes in
//! which their torques differ (orthonormal in the mean square), so that few long axes are cut finely.

use std::sync::Arc;

use rayon::prelude::*;

use super::convex::under;
use super::menu::Needs;
use crate::catalog::{Catalog, Motor};
use crate::design::mount::{JointDemand, Site};
use crate::design::program::{minimise, value};
use crate::design::{Candidate, Prepared};
use crate::numerics::grid::grid;
use crate::requirement::{Joint, Quantity, Robot};

/// How many boxes a joint's load is divided into at most.
const BOXES: f64 = 400.0;
/// Boxes times motors times samples at most: what the bounds take does not grow with the catalogue.
const BOX_WORK: f64 = 4e6;
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
    let motion = Arc::make_mut(&mut loaded.motion);
    for ((torque, rate), y) in directions(joint).iter().zip(coordinates) {
        for k in 0..torque.len() {
            motion.torque[k] += y * torque[k];
            motion.torque_rate[k] += y * rate[k];
        }
    }
    loaded
}

/// Orthonormal directions of a joint's load about the middle of what it can be, and what one unit of each
/// coordinate is along them.
#[derive(Debug)]
struct Axes {
    /// The middle of each coordinate.
    middle: Vec<f64>,
    /// Torque of each sample; the mean square of each axis is one, the mean product of two is nothing.
    torque: Vec<Vec<f64>>,
    /// For each axis the share of each coordinate.
    shares: Vec<Vec<f64>>,
    /// Root mean square of the load that no axis counts, at most \[N·m\].
    rest: f64,
}

impl Axes {
    /// Gram-Schmidt, first along what all coordinates do together, then along the largest that is left.
    fn new(joint: &Joint, directions: &[(Vec<f64>, Vec<f64>)], reach: &[(f64, f64)]) -> Axes {
        let mean = |a: &[f64], b: &[f64]| joint.motion.mean(|k| a[k] * b[k]);
        let width: Vec<f64> = reach.iter().map(|(low, high)| high - low).collect();
        let mut left: Vec<Vec<f64>> = directions.iter().map(|d| d.0.clone()).collect();
        let size = |left: &[Vec<f64>], i: usize| width[i] * mean(&left[i], &left[i]).sqrt();
        let whole: f64 = (0..left.len()).map(|i| size(&left, i)).sum();
        let middle = reach.iter().map(|(low, high)| 0.5 * (low + high)).collect();
        let mut axes = Axes { middle, torque: Vec::new(), shares: Vec::new(), rest: 0.0 };
        while axes.torque.len() < directions.len() {
            let largest = (0..left.len()).max_by(|a, b| size(&left, *a).total_cmp(&size(&left, *b)));
            let Some(largest) = largest.filter(|i| size(&left, *i) > 1e-9 * whole) else { break };
            let mut axis = left[largest].clone();
            if axes.torque.is_empty() {
                for (i, d) in left.iter().enumerate().filter(|(i, _)| *i != largest) {
                    let along = mean(d, &left[largest]).signum() * width[i] / width[largest];
                    axis.iter_mut().zip(d).for_each(|(a, d)| *a += along * d);
                }
            }
            let length = mean(&axis, &axis).sqrt();
            axis.iter_mut().for_each(|a| *a /= length);
            for d in &mut left {
                let along = mean(d, &axis);
                d.iter_mut().zip(&axis).for_each(|(d, a)| *d -= along * a);
            }
            axes.shares.push(directions.iter().map(|d| mean(&d.0, &axis)).collect());
            axes.torque.push(axis);
        }
        axes.rest = (0..left.len()).map(|i| size(&left, i)).sum();
        axes
    }

    /// The intervals along the axes that coordinates in intervals reach.
    fn intervals(&self, coordinates: &[(f64, f64)]) -> Vec<(f64, f64)> {
        let of = |shares: &Vec<f64>| {
            shares.iter().zip(coordinates).zip(&self.middle).fold((0.0, 0.0), |sum, ((share, (low, high)), middle)| {
                let (a, b) = (share * (low - middle), share * (high - middle));
                (sum.0 + a.min(b), sum.1 + a.max(b))
            })
        };
        self.shares.iter().map(of).collect()
    }
}

/// Lower bounds of a joint's objective over its load.
#[derive(Debug)]
pub(super) struct Boxes {
    axes: Axes,
    reach: Vec<(f64, f64)>,
    counts: Vec<usize>,
    bounds: Vec<f64>,
}

impl Boxes {
    /// Over all loads that a joint can have.
    pub(super) fn new(robot: &Robot, joint: &Joint, catalog: &Catalog, reach: Vec<(f64, f64)>, needs: Needs) -> Boxes {
        let directions = directions(joint);
        let axes = Axes::new(joint, &directions, &reach);
        let reach = axes.intervals(&reach);
        let work = (catalog.motors.len() * joint.motion.len()).max(1) as f64;
        let counts = counts(&reach, (BOX_WORK / work).clamp(20.0, BOXES));
        let total = counts.iter().product();
        let bound = |index: usize| {
            let (mut rest, mut center, mut radius) = (index, loaded(joint, &axes.middle), 0.0);
            let motion = Arc::make_mut(&mut center.motion);
            for ((axis, count), (low, high)) in axes.torque.iter().zip(&counts).zip(&reach) {
                let width = (high - low) / *count as f64;
                let here = low + width * ((rest % count) as f64 + 0.5);
                motion.torque.iter_mut().zip(axis).for_each(|(torque, a)| *torque += here * a);
                radius += (0.5 * width).powi(2);
                rest /= count;
            }
            bound(robot, joint, &center, catalog, f64::sqrt(radius) + axes.rest, needs)
        };
        Boxes { bounds: (0..total).into_par_iter().map(bound).collect(), axes, reach, counts }
    }

    /// The least bound over a part of the loads.
    pub(super) fn least(&self, part: &[(f64, f64)]) -> f64 {
        let places: Vec<(usize, usize)> = self
            .axes
            .intervals(part)
            .iter()
            .zip(&self.reach)
            .zip(&self.counts)
            .map(|(((a, b), (low, high)), count)| {
                let place = |y: f64| {
                    let share = if high > low { (y - low) / (high - low) } else { 0.0 };
                    (share * *count as f64).floor().clamp(0.0, (count - 1) as f64) as usize
                };
                // An end on the edge of a box belongs to both sides of it.
                let slack = 1e-9 * (high - low);
                (place(a - slack), place(b + slack))
            })
            .collect();
        let inside = |index: &usize| {
            let mut rest = *index;
            places.iter().zip(&self.counts).all(|((a, b), count)| {
                let here = rest % count;
                rest /= count;
                (*a..=*b).contains(&here)
            })
        };
        (0..self.bounds.len()).filter(inside).map(|i| self.bounds[i]).fold(f64::INFINITY, f64::min)
    }
}

/// Into how many boxes each axis is cut: boxes as even as they can be, and no more than there may be.
fn counts(reach: &[(f64, f64)], boxes: f64) -> Vec<usize> {
    let longest = reach.iter().map(|(low, high)| high - low).fold(0.0, f64::max);
    let cut = |pieces: f64| -> Vec<usize> {
        let of = |(low, high): &(f64, f64)| {
            let share = if longest > 0.0 { (high - low) / longest } else { 0.0 };
            (share * pieces).round().max(1.0) as usize
        };
        reach.iter().map(of).collect()
    };
    let fits = |pieces: &f64| cut(*pieces).iter().product::<usize>() as f64 <= boxes;
    let most = (1..=boxes as usize).map(|pieces| pieces as f64).take_while(fits).last();
    cut(most.unwrap_or(1.0))
}

/// The bound over one box, whose loads are all within `radius` \[N·m\] of its centre in the root mean square:
/// over all motors and ratios, whether or not they keep limits that depend on the load.
fn bound(robot: &Robot, joint: &Joint, center: &Joint, catalog: &Catalog, radius: f64, needs: Needs) -> f64 {
    // Energy may be less than nothing; all else is not.
    if joint.objective.weight(Quantity::Energy) > 0.0 {
        return f64::NEG_INFINITY;
    }
    // Of all losses that in the copper is a part, and no other is negative.
    let weight = joint.objective.weight(Quantity::Loss) + joint.objective.weight(Quantity::CopperLoss);
    if weight == 0.0 || joint.limits.spring.is_some() || needs.only_checked {
        return 0.0;
    }
    let demand = JointDemand::new(center, catalog);
    let of = |prepared: &Prepared, ratios: &[f64], gear_loss: f64| -> f64 {
        let actuator = &prepared.candidate.actuator;
        if actuator.shortfall.saturates() || prepared.candidate.is_evaluated() {
            return 0.0;
        }
        let loss = prepared.copper_loss();
        let reach = actuator.heating().sqrt() * gear_loss * radius;
        let piece = |w: &[f64]| {
            let convex = under(&loss, (w[0], w[1]), (w[0] * w[1]).sqrt());
            let least = value(&convex, minimise(&convex, w[0] * w[0], w[1] * w[1])).max(0.0);
            (least.sqrt() - reach / w[0]).max(0.0).powi(2)
        };
        ratios.windows(2).map(piece).fold(f64::INFINITY, f64::min) * (1.0 - 1e-9)
    };
    let steepest = |efficiency: f64, back: f64| (1.0 / efficiency).max(back.abs());
    let speed = joint.motion.velocity.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    let site = Site::new(robot, center, &demand);
    let of_mount = |motor: &Motor, candidate: Candidate| {
        let steepest = steepest(candidate.gear.efficiency, candidate.gear.backdrive_efficiency);
        let ratios = match (candidate.catalog_gear, joint.ratio.range()) {
            (Some(gear), _) => vec![gear.ratio, gear.ratio],
            // Of listed ratios all between them, too: a bound below is one.
            (None, Some((min, max))) => {
                let max = max.min(highest(&candidate, speed) * (1.0 + 1e-6));
                if max < min || too_heavy(joint, motor, min, needs) {
                    return f64::INFINITY;
                }
                if max > min { grid(min, max, PIECES + 1) } else { vec![min, min] }
            }
            (None, None) => return f64::INFINITY,
        };
        of(&Prepared::new(candidate), &ratios, steepest)
    };
    let of_motor = |motor: &Motor| {
        let candidates = site.mounts(motor).filter_map(|mount| mount.candidate().ok());
        candidates.map(|candidate| of_mount(motor, candidate)).fold(f64::INFINITY, f64::min)
    };
    weight * catalog.motors.iter().map(of_motor).fold(f64::INFINITY, f64::min)
}

/// The highest ratio that limits allow which do not depend on the load.
fn highest(candidate: &Candidate, speed: f64) -> f64 {
    let fastest = [candidate.motor.max_speed, candidate.gear.max_input_speed].into_iter().flatten();
    let by_speed = fastest.map(|most| if speed > 0.0 { most / speed } else { f64::INFINITY });
    let limit = candidate.joint.limits.reflected_inertia;
    let inertia = candidate.motor.rotor_inertia.map(|j| j + candidate.gear.inertia).filter(|j| *j > 0.0);
    let by_inertia = limit.zip(inertia).map(|(limit, inertia)| (limit / inertia).sqrt());
    by_speed.chain(by_inertia).fold(f64::INFINITY, f64::min)
}

/// Whether a motor is no item of the joint's menu because of its mass.
fn too_heavy(joint: &Joint, motor: &Motor, least_ratio: f64, needs: Needs) -> bool {
    match motor.mass {
        None => needs.mass,
        Some(mass) => {
            let gear = joint.gear.mass_at(least_ratio).unwrap_or(0.0);
            joint.limits.actuator_mass.is_some_and(|limit| mass + gear > limit * (1.0 + 1e-6))
        }
    }
}
