//! `torques --json`, and what a requirement's own description of the robot gave.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::document;
use crate::torques;
use gearwise_model::mechanism::Motion as Degree;
use gearwise_model::requirement::{Driven, Robot};

/// What `torques` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// Name of the robot in its description.
    pub model: &'a str,
    /// Mass of all its bodies.
    pub mass_kg: f64,
    /// Samples of the trajectory.
    pub samples: usize,
    /// The joints.
    pub joints: Vec<OfJoint<'a>>,
    /// How much torques rise with the masses of actuators that joints carry.
    pub torque_per_mass: Vec<Carried<'a>>,
    /// Whether damping and friction of the description are in the torques.
    pub joint_friction_counted: bool,
    /// Whether the rotors' inertia is: it never is, it comes with the motor.
    pub rotor_inertia_counted: bool,
    /// What of the description was left aside, and where the trajectory leaves what it allows.
    pub notes: &'a [String],
}

/// A joint: one that turns has `…_nm` and `…_rad_per_s`, one that slides `…_n` and `…_m_per_s`.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// `turns` or `slides`.
    pub motion: &'static str,
    /// Largest torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_torque_nm: Option<f64>,
    /// Largest force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_force_n: Option<f64>,
    /// When that is.
    pub peak_time_s: f64,
    /// Root mean square of the torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_torque_nm: Option<f64>,
    /// Root mean square of the force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_force_n: Option<f64>,
    /// Largest speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_velocity_rad_per_s: Option<f64>,
    /// Largest speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_velocity_m_per_s: Option<f64>,
    /// Mean mechanical power.
    pub mean_power_w: f64,
    /// Largest mechanical power.
    pub peak_power_w: f64,
    /// Inertia of a rotor that the description states and that is not in the torques.
    pub armature_left_out_kgm2: f64,
}

/// How much the torque of one joint rises per kilogram of another's actuator.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Carried<'a> {
    /// The joint that carries.
    pub carrying_joint: &'a str,
    /// The joint whose actuator is carried.
    pub actuator_of: &'a str,
    /// Largest over the motion.
    pub largest_nm_per_kg: f64,
    /// When that is.
    pub time_s: Option<f64>,
}

/// What a requirement's own description of the robot gave.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Mechanism<'a> {
    /// The description's file.
    pub model: &'a str,
    /// Whether rotors' inertia is in the torques: it never is.
    pub rotor_inertia_counted: bool,
    /// Whether the description's masses contain the actuators: `included` or `separate`.
    pub actuators: &'static str,
    /// What of the description was left aside, and where the trajectory leaves what it allows.
    pub notes: &'a [String],
    /// How much torques rise with the masses of actuators that joints carry.
    pub torque_per_mass: Vec<Carried<'a>>,
}

impl<'a> Mechanism<'a> {
    /// Of a robot whose motions come from its description.
    pub fn new(driven: &'a Driven, robot: &'a Robot) -> Mechanism<'a> {
        let carried = driven.carried.iter().map(|c| {
            let motion = &robot.joints[c.carrying].motion;
            Carried {
                carrying_joint: &robot.joints[c.carrying].name,
                actuator_of: &robot.joints[c.actuator].name,
                largest_nm_per_kg: c.largest(),
                time_s: motion.given.get(c.worst()).map(|k| motion.time[*k]),
            }
        });
        Mechanism {
            model: &driven.model,
            rotor_inertia_counted: false,
            actuators: if driven.separate { "separate" } else { "included" },
            notes: &driven.notes,
            torque_per_mass: carried.collect(),
        }
    }
}

/// Torques along a trajectory.
pub fn json(answer: &torques::Answer) -> Value {
    let joints = answer.rows().into_iter().map(|row| {
        let slides = row.joint.motion == Degree::Slides;
        let (turning, sliding) = (|x: f64| (!slides).then_some(x), |x: f64| slides.then_some(x));
        OfJoint {
            joint: &row.joint.name,
            motion: if slides { "slides" } else { "turns" },
            peak_torque_nm: turning(row.peak),
            peak_force_n: sliding(row.peak),
            peak_time_s: answer.trajectory.time[row.peak_at],
            rms_torque_nm: turning(row.rms),
            rms_force_n: sliding(row.rms),
            peak_velocity_rad_per_s: turning(row.speed),
            peak_velocity_m_per_s: sliding(row.speed),
            mean_power_w: row.mean_power,
            peak_power_w: row.peak_power,
            armature_left_out_kgm2: row.joint.armature,
        }
    });
    let carried = answer.carried.iter().filter(|c| answer.shown.contains(&c.carrying)).map(|c| Carried {
        carrying_joint: answer.name(c.carrying),
        actuator_of: answer.name(c.actuator),
        largest_nm_per_kg: c.largest(),
        time_s: Some(answer.trajectory.time[c.worst()]),
    });
    let of = Answer {
        model: &answer.mechanism.name,
        mass_kg: answer.mechanism.mass(),
        samples: answer.trajectory.len(),
        joints: joints.collect(),
        torque_per_mass: carried.collect(),
        joint_friction_counted: answer.torques.joint_friction,
        rotor_inertia_counted: false,
        notes: &answer.notes,
    };
    document("torques", of)
}
