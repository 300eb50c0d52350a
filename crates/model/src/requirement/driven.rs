//! What a description of the robot says of its joints.

use crate::mechanism::torques::Carried;

/// What the description says of the robot's joints.
#[derive(Debug, Clone)]
pub struct Driven {
    /// The model's file as the requirement names it.
    pub model: String,
    /// What of the description was left aside, and where the trajectory leaves what it allows.
    pub notes: Vec<String>,
    /// How much the torque of one of the robot's joints rises per kilogram of another's actuator, over the
    /// samples of their motions; joints by their place in the requirement. In a joint with `count`, of each.
    pub carried: Vec<Carried>,
    /// The joint next before each one in the tree of the description, by its place in the requirement; `None` where there is none.
    pub hangs_on: Vec<Option<usize>>,
    /// Whether the masses of the description leave the actuators out (`actuators = "separate"`), so that
    /// the actuator that is chosen loads the joints that carry it.
    pub separate: bool,
}
