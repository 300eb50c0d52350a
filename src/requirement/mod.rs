//! What a robot asks of its joints: motions, limits, objectives.
//!
//! The one idea of this room: a requirement is data with the place it was read from; what a motion asks for is in
//! [`crate::motion`].

mod carried;
pub mod design_file;
pub mod mechanism;
mod read;
mod robot;

pub use crate::motion::{Between, Course, Motion, Point, Samples};
pub use design_file::{Choice, DesignFile, FixedSpring, JointDesign, MotorName, Reduction};
pub use mechanism::Driven;
pub use read::{FromDisk, Motions, read, read_changed, read_source, read_without_springs};
pub use robot::*;
