//! What a bench file of a whole robot says.

use std::path::PathBuf;

use crate::answer::findings::Finding;
use crate::bench::{Bench, Declared, Log, Readings};
use gearwise_model::catalog::Catalog;
use gearwise_model::input::InputFile;
use gearwise_model::mechanism::{Mechanism, Payload};

/// What a bench file is of.
#[derive(Debug, Clone)]
pub enum Subject {
    /// One actuator.
    Actuator(Box<Bench>),
    /// The joints of a robot.
    Robot(Box<RobotBench>),
}

/// A bench file of a whole robot, with its logs.
#[derive(Debug, Clone)]
pub struct RobotBench {
    /// Name, by default the file's.
    pub name: String,
    /// The bench file.
    pub path: PathBuf,
    /// The catalogue that the declared motors come from.
    pub catalog: Catalog,
    /// The description, as the bench file names it.
    pub model: String,
    /// What it describes, without payloads.
    pub mechanism: Mechanism,
    /// Joints of the description that did not move, by their number, and where they were \[rad, m\].
    pub fixed: Vec<(usize, f64)>,
    /// The joints that are in the logs.
    pub joints: Vec<RobotJoint>,
    /// What the robot carried in each log.
    pub carrying: Vec<Vec<Payload>>,
    /// The files that it was read from, each with its hash.
    pub files: Vec<InputFile>,
}

/// A joint of a robot with its part of the logs.
#[derive(Debug, Clone)]
pub struct RobotJoint {
    /// What it is called.
    pub name: String,
    /// Its number in the description.
    pub number: usize,
    /// Its declared actuator; `None` of one that says only how it moves.
    pub declared: Option<Declared>,
    /// The logs, in the order of the file.
    pub logs: Vec<Log>,
}

/// A joint's bench as it is asked, and what was found in its logs.
pub(super) struct Prepared {
    pub joint: usize,
    pub bench: Bench,
    pub findings: Vec<Finding>,
}

impl RobotBench {
    /// The robot as it is described, with what it carried in a log.
    pub(super) fn carrying(&self, log: usize) -> Mechanism {
        let mut mechanism = self.mechanism.clone();
        for payload in &self.carrying[log] {
            let known = mechanism.carry(payload);
            debug_assert!(known, "the reader has asked for `{}`", payload.link);
        }
        mechanism
    }

    /// The bench of a joint, as if it were alone; `None` without an actuator.
    pub(super) fn bench(&self, joint: usize) -> Option<Bench> {
        let RobotJoint { name, declared, logs, .. } = &self.joints[joint];
        Some(Bench {
            name: format!("{}, {name}", self.name),
            path: self.path.clone(),
            catalog: self.catalog.clone(),
            declared: declared.clone()?,
            logs: logs.clone(),
            readings: Readings::default(),
            files: self.files.clone(),
        })
    }
}
