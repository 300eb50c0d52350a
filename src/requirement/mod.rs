//! What a robot asks of its joints: motions, limits, objectives.
//!
//! The one idea of this room: everything that a motion asks for stands in arrays over samples, and
//! what is not given (acceleration, jerk, torque rate) comes from one declared interpolant, the
//! cubic [`spline`]; what lies between the samples is its own as well ([`instants`]).

mod carried;
pub mod design_file;
pub mod instants;
pub mod mechanism;
pub mod motion;
mod read;
mod robot;
pub mod spline;

pub use design_file::{Choice, DesignFile, FixedSpring, JointDesign, MotorName, Reduction};
pub use instants::Between;
pub use mechanism::Driven;
pub use motion::{Course, Motion, Point, Samples};
pub use read::{FromDisk, Motions, read, read_changed, read_source, read_without_springs};
pub use robot::*;
