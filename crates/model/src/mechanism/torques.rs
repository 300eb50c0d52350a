//! The torques of a trajectory as what each joint asks of its actuator, and what the actuators' own masses
//! add to them.
//!
//! What is in: weight, inertia, Coriolis forces, outer forces, springs of the joints, and (unless left out)
//! the friction that the description gives a joint. What is not: the rotor. A description's `armature` is some
//! motor's rotor seen through some gear; the motor chosen here brings its own, `N²(J_m + J_g) q̈`. The rotors'
//! gyroscopic torque and their reaction on other joints are neglected: they are of the order 1/N of that.

use super::dynamics::{inverse_dynamics, kinematics, per_mass};
use super::trajectory::Trajectory;
use super::{Mechanism, Motion as Degree, Place};
use crate::motion::disagreement;
use crate::motion::{Motion, Samples};

/// What every joint asks over a trajectory.
#[derive(Debug, Clone)]
pub struct Torques {
    /// Per joint and sample: load torque \[N·m\] (force \[N\] where it slides), friction included.
    pub torque: Vec<Vec<f64>>,
    /// The same without the joints' Coulomb friction, which jumps and has no rate.
    pub smooth: Vec<Vec<f64>>,
    /// Whether the joints' own friction is part of it.
    pub joint_friction: bool,
}

/// Inverse dynamics over a trajectory.
pub fn torques(mechanism: &Mechanism, trajectory: &Trajectory, joint_friction: bool) -> Torques {
    let joints: Vec<_> = mechanism.joints().collect();
    let mut smooth = vec![Vec::with_capacity(trajectory.len()); joints.len()];
    let mut torque = smooth.clone();
    for k in 0..trajectory.len() {
        let sample = trajectory.sample(k);
        let load = inverse_dynamics(mechanism, sample.state(), &trajectory.wrenches(k));
        for (j, joint) in joints.iter().enumerate() {
            let (q, qd) = (sample.position[j], sample.velocity[j]);
            let mut steady = load[j] + joint.stiffness * (q - joint.spring_reference);
            let mut all = steady;
            if joint_friction {
                steady += joint.damping * qd;
                // At standstill friction may hold either way: nothing is counted on.
                all = steady + if qd == 0.0 { 0.0 } else { joint.friction * qd.signum() };
            }
            smooth[j].push(steady);
            torque[j].push(all);
        }
    }
    Torques { torque, smooth, joint_friction }
}

impl Torques {
    /// What one joint asks of its actuator, as from a motion file. Acceleration and position are the
    /// trajectory's, jerk and torque rate the spline's.
    pub fn motion(&self, trajectory: &Trajectory, joint: usize) -> Motion {
        let samples = |torque: &[f64]| Samples {
            time: trajectory.time.clone(),
            torque: torque.to_vec(),
            position: Some(trajectory.position[joint].clone()),
            velocity: Some(trajectory.velocity[joint].clone()),
            acceleration: Some(trajectory.acceleration[joint].clone()),
            ..Samples::default()
        };
        let mut motion = Motion::at_samples(samples(&self.smooth[joint]), trajectory.course);
        motion.torque = self.torque[joint].clone();
        motion
    }

    /// The same at every instant, where the trajectory leaves the accelerations to its spline; where it gives
    /// them, with an estimate of what may lie between.
    pub fn motion_at_every_instant(&self, trajectory: &Trajectory, joint: usize) -> Motion {
        let given = trajectory.gives_acceleration[joint];
        let samples = Samples {
            time: trajectory.time.clone(),
            torque: self.smooth[joint].clone(),
            position: Some(trajectory.position[joint].clone()),
            velocity: Some(trajectory.velocity[joint].clone()),
            acceleration: given.then(|| trajectory.acceleration[joint].clone()),
            ..Samples::default()
        };
        let mut motion = Motion::from_samples(samples, trajectory.course);
        // Friction has one size, and the sign of the speed at every instant.
        let rubs = self.torque[joint].iter().zip(&self.smooth[joint]).map(|(all, smooth)| (all - smooth).abs());
        let friction = rubs.fold(0.0, f64::max);
        for (torque, velocity) in motion.torque.iter_mut().zip(&motion.velocity) {
            *torque += if *velocity == 0.0 { 0.0 } else { friction * velocity.signum() };
        }
        for (i, k) in motion.given.iter().enumerate() {
            motion.torque[*k] = self.torque[joint][i];
        }
        motion
    }
}

/// How much the torque of a carrying joint rises per kilogram at a place, per sample \[N·m/kg\]:
/// `∂τ_i(t)/∂m`. `None` where the joint does not carry the place.
pub fn torque_per_mass(
    mechanism: &Mechanism,
    trajectory: &Trajectory,
    carrying: usize,
    place: Place,
) -> Option<Vec<f64>> {
    let all = torques_per_mass(mechanism, trajectory, &[Some(place)]);
    all.into_iter().find(|c| c.carrying == carrying).map(|c| c.coefficients)
}

/// How an actuator's mass loads a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Carried {
    /// Number of the joint that carries.
    pub carrying: usize,
    /// Number of the joint whose actuator is carried.
    pub actuator: usize,
    /// Torque of the carrying joint per kilogram of that actuator, per sample \[N·m/kg\].
    pub coefficients: Vec<f64>,
}

impl Carried {
    /// The sample at which the coefficient is largest in size.
    pub fn worst(&self) -> usize {
        let mut worst = 0;
        for (k, c) in self.coefficients.iter().enumerate() {
            if c.abs() > self.coefficients[worst].abs() {
                worst = k;
            }
        }
        worst
    }

    /// The largest coefficient with its sign \[N·m/kg\].
    pub fn largest(&self) -> f64 {
        self.coefficients[self.worst()]
    }
}

/// Where each joint's actuator sits unless told otherwise.
pub fn actuator_places(mechanism: &Mechanism) -> Vec<Option<Place>> {
    (0..mechanism.moving().len()).map(|joint| mechanism.actuator_place(joint)).collect()
}

/// [`torque_per_mass`] of every pair of a carrying joint and an actuator at its place, ordered by carrying
/// joint and then by actuator. Actuators without a place stand in the world.
pub fn torques_per_mass(mechanism: &Mechanism, trajectory: &Trajectory, places: &[Option<Place>]) -> Vec<Carried> {
    let mut pairs: std::collections::BTreeMap<(usize, usize), Vec<f64>> = Default::default();
    for k in 0..trajectory.len() {
        let sample = trajectory.sample(k);
        let moving = kinematics(mechanism, sample.state());
        for (actuator, place) in places.iter().enumerate() {
            let Some(place) = place else { continue };
            for (carrying, coefficient) in per_mass(mechanism, &moving, *place) {
                pairs.entry((carrying, actuator)).or_default().push(coefficient);
            }
        }
    }
    pairs.into_iter().map(|((carrying, actuator), coefficients)| Carried { carrying, actuator, coefficients }).collect()
}

/// What was done with everything of the description that is not a rigid body, and where the trajectory leaves
/// what the description allows. For people.
pub fn notes(mechanism: &Mechanism, trajectory: &Trajectory, torques: &Torques) -> Vec<String> {
    let mut notes = mechanism.notes.clone();
    let list = |chosen: &dyn Fn(&super::Joint) -> f64, turning: &str, sliding: &str| {
        let found: Vec<String> = mechanism
            .joints()
            .filter(|j| chosen(j) != 0.0)
            .map(|j| {
                let unit = if j.motion == Degree::Turns { turning } else { sliding };
                format!("{} {} {unit}", j.name, crate::words::number(chosen(j)))
            })
            .collect();
        (!found.is_empty()).then(|| found.join(", "))
    };
    let friction = if torques.joint_friction { "counted as load" } else { "left out, as asked" };
    if let Some(list) = list(&|j| j.damping, "N*m*s/rad", "N*s/m") {
        notes.push(format!("damping of the joints is {friction}: {list}"));
    }
    if let Some(list) = list(&|j| j.friction, "N*m", "N") {
        notes.push(format!("Coulomb friction of the joints is {friction}: {list}"));
    }
    if let Some(list) = list(&|j| j.stiffness, "N*m/rad", "N/m") {
        notes.push(format!("springs of the joints are counted: {list}"));
    }
    if let Some(list) = list(&|j| j.armature, "kg*m^2", "kg") {
        notes.push(format!("armature is left out, the actuator brings its own rotor: {list}"));
    }
    for (j, joint) in mechanism.joints().enumerate() {
        let far = |values: &[f64]| values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let (speed, torque) = (far(&trajectory.velocity[j]), far(&torques.torque[j]));
        let unit = joint.position_unit();
        // States that were drawn at random are a trajectory too: said, not refused.
        if let Some(k) = disagreement(&trajectory.time, &trajectory.position[j], &trajectory.velocity[j]) {
            let at = crate::words::number(trajectory.time[k]);
            notes.push(format!(
                "the velocity given for {} is not the rate of its position (most at t = {at} s): a wrong unit or sign?",
                joint.name
            ));
        }
        if let Some([low, high]) = joint.range {
            let beyond = |q: &&f64| **q < low - 1e-6 || **q > high + 1e-6;
            if let Some(q) = trajectory.position[j].iter().find(beyond) {
                let shown = [*q, low, high].map(crate::words::number);
                notes.push(format!(
                    "{} goes to {} {unit}, but the description allows {} to {}",
                    joint.name, shown[0], shown[1], shown[2]
                ));
            }
        }
        let pairs = [(speed, joint.speed, format!("{unit}/s")), (torque, joint.effort, joint.effort_unit().into())];
        for (most, allowed, unit) in pairs {
            if let Some(allowed) = allowed.filter(|a| most > a * (1.0 + 1e-6)) {
                let (most, allowed) = (crate::words::number(most), crate::words::number(allowed));
                notes.push(format!("{} needs {most} {unit}, but the description allows {allowed}", joint.name));
            }
        }
    }
    notes
}

/// Whether a joint turns; only then it is one that a motor and a gear drive directly.
pub fn turns(mechanism: &Mechanism, joint: usize) -> bool {
    mechanism.joints().nth(joint).is_some_and(|j| j.motion == Degree::Turns)
}
