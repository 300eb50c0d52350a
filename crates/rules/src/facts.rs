//! What rules look at: each joint's choice with its evaluation, and the robot as a whole.

use super::lock::LockState;
use gearwise_model::requirement::{Choice, DesignFile, Robot};
use gearwise_select::Unusable;
use gearwise_select::examine::Examined;

/// One joint's choice with what is known of it.
#[derive(Debug)]
pub struct JointFacts<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The choice.
    pub choice: Choice<'a>,
    /// Its evaluation, or why there is none.
    pub examined: Result<Examined, Unusable>,
}

/// The whole design.
#[derive(Debug)]
pub struct RobotFacts<'a> {
    /// The design file.
    pub design: &'a DesignFile,
    /// Every joint.
    pub joints: Vec<JointFacts<'a>>,
    /// How the lock compares with the catalogue.
    pub lock: LockState,
}

impl RobotFacts<'_> {
    /// A sum over all actuators, joints counted as often as the robot has them; `None` where one is unknown.
    pub fn total(&self, of: impl Fn(&Examined) -> Option<f64>) -> Option<f64> {
        let each = |facts: &JointFacts| {
            let value = of(facts.examined.as_ref().ok()?)?;
            Some(f64::from(facts.choice.joint.count) * value)
        };
        self.joints.iter().map(each).sum()
    }

    /// Ids of the motors, each once.
    pub fn motors(&self) -> Vec<&str> {
        let mut ids: Vec<&str> = self.joints.iter().map(|j| j.choice.motor.id.as_str()).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }
}
