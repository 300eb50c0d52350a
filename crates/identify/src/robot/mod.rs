//! Logs of a whole robot: each joint with the load that its description says it carries.
//!
//! The one idea: a robot is as many benches as it has joints. What the description and the motion of all joints ask of a joint
//! is computed once, and is the known load of its bench; what all joints lack together is asked for first, because a mass that
//! is not in the description looks at every joint like something of that joint.

mod bench;
mod courses;
mod payload;
mod stacked;

use rayon::prelude::*;

pub use self::bench::{RobotBench, RobotJoint, Subject};
pub use self::payload::{Asked, Carrier, Felt, Named, PayloadAnswer, Witness};

use self::bench::Prepared;
use self::courses::Course;
use super::bench::{Bench, Channel};
use super::identify::{self, Identified, Options, Target, prepare};
use gearwise_model::mechanism::Mechanism;
use gearwise_model::words::number;

/// What identification says of a robot.
#[derive(Debug, Clone)]
pub struct RobotReport {
    /// Whether the masses of the description are enough.
    pub payload: PayloadAnswer,
    /// What it says of each joint that has an actuator.
    pub joints: Vec<JointReport>,
}

/// What identification says of one joint.
#[derive(Debug, Clone)]
pub struct JointReport {
    /// The joint, by its number among those of the bench file.
    pub joint: usize,
    /// Its bench, with the load that it was compared with.
    pub bench: Bench,
    /// Errors on the logs for fitting and on those held out, with everything as declared, payload included; `None` where there is
    /// no equation of a known load.
    pub declared: Option<(f64, Option<f64>)>,
    /// The reports; or why there is none.
    pub identified: Result<Vec<Identified>, String>,
}

/// Identifies the joints of a robot: all that have an actuator, or one of them.
///
/// # Errors
/// In words, where the logs do not say how the robot moved, or no joint has an actuator.
pub fn identify(robot: &RobotBench, options: &Options, only: Option<usize>) -> Result<RobotReport, String> {
    let mut prepared: Vec<Prepared> = (0..robot.joints.len())
        .into_par_iter()
        .filter_map(|joint| {
            let (bench, findings) = prepare::prepare(&robot.bench(joint)?);
            Some(Prepared { joint, bench, findings })
        })
        .collect();
    if prepared.is_empty() {
        return Err("no joint has an `actuator`: there is no model to be compared with the logs".into());
    }
    let courses = courses(robot, &prepared)?;
    let described: Vec<Mechanism> = (0..robot.carrying.len()).map(|log| robot.carrying(log)).collect();
    let loads: Vec<Vec<Vec<f64>>> = courses.par_iter().zip(&described).map(|(c, m)| c.torques(m)).collect();
    put_on(robot, &mut prepared, &courses, &loads);
    let declared: Vec<_> = prepared.iter().map(|p| declared_error(&p.bench, options)).collect();
    let payload = payload::ask(robot, &prepared, &courses, options);
    if let PayloadAnswer::Named(named) = &payload {
        let mut loads = loads;
        for (load, course) in loads.iter_mut().zip(&courses) {
            named.add_to(&robot.mechanism, course, load);
        }
        put_on(robot, &mut prepared, &courses, &loads);
    }
    let joints = prepared
        .into_par_iter()
        .zip(declared)
        .filter(|(p, _)| only.is_none_or(|only| only == p.joint))
        .map(|(Prepared { joint, bench, findings }, declared)| {
            let identified = identify::of_prepared(&bench, &findings, options).map_err(|why| with_band(&bench, &why));
            JointReport { joint, bench, declared, identified }
        })
        .collect();
    Ok(RobotReport { payload, joints })
}

/// Why nothing can be learnt, with what bounds the band.
fn with_band(bench: &Bench, why: &str) -> String {
    let band = bench.logs.iter().filter_map(|log| log.band).fold(f64::INFINITY, f64::min);
    match band.is_finite() {
        true => {
            format!("{why}; the load is known below {} Hz: faster motion, or `--band`, shows more", number_of(band))
        }
        false => why.into(),
    }
}

/// How the robot moved in each log.
fn courses(robot: &RobotBench, prepared: &[Prepared]) -> Result<Vec<Course>, String> {
    let of = |log: usize| {
        let log_of = |joint: usize| {
            let own = prepared.iter().find(|p| p.joint == joint).map(|p| &p.bench.logs[log]);
            own.unwrap_or(&robot.joints[joint].logs[log])
        };
        Course::new(robot, log_of)
    };
    (0..robot.carrying.len()).into_par_iter().map(of).collect()
}

/// Gives each joint's logs the load that was computed for it.
fn put_on(robot: &RobotBench, prepared: &mut [Prepared], courses: &[Course], loads: &[Vec<Vec<f64>>]) {
    for Prepared { joint, bench, .. } in prepared {
        let number = robot.joints[*joint].number;
        for ((log, course), load) in bench.logs.iter_mut().zip(courses).zip(loads) {
            let own = course.at(&load[number], &log.time);
            let first = log.channels.insert(Channel::LoadTorque, own).is_none();
            log.band = Some(course.band);
            if first {
                let said = "the load is computed from the description and the motion of all joints";
                log.remarks.push(format!("{said}, below {} Hz", number_of(course.band)));
            }
        }
    }
}

fn number_of(band: f64) -> String {
    number((10.0 * band).round() / 10.0)
}

/// The errors of a joint's balance with everything as declared.
fn declared_error(bench: &Bench, options: &Options) -> Option<(f64, Option<f64>)> {
    identify::as_declared(bench, Target::Drive, options).map(|stage| (stage.fit, stage.held_out))
}
