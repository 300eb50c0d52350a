//! Actuators that carry actuators: the load of a joint depends on what its carried joints weigh.
//!
//! What is carried is chosen first; the carrying joint is then solved for exactly that load.

use std::sync::Arc;

use super::tangent::Directions;
use gearwise_model::requirement::Joint;

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

/// The directions of a joint's load, and how its carried joints move it along them.
pub(super) fn directions_of(joint: &Joint) -> Directions {
    let first = usize::from(joint.carries.iter().any(|c| c.constant));
    let mut others = 0;
    let of_carried = joint.carries.iter().map(|carried| match carried.constant {
        true => (0, carried.torque_per_mass.first().copied().unwrap_or(0.0)),
        false => {
            others += 1;
            (first + others - 1, 1.0)
        }
    });
    Directions { of_carried: of_carried.collect(), courses: directions(joint) }
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
