//! What a robot asks of its joints: motions, limits, objectives.
//!
//! The one idea of this room: a requirement is data with the place it was read from; what a motion asks for is in
//! [`crate::motion`].

mod bus;
mod carried;
mod cases;
mod coupling;
pub mod design_file;
mod drive;
mod driven;
mod gear;
mod gear_map;
mod joint;
mod limits;
mod map_file;
pub mod mechanism;
mod motions;
mod objective;
mod prices;
mod read;
mod robot;
pub mod saved;
pub mod set;
mod teeth;
mod transmission;
mod turns;

pub use crate::motion::{Between, Course, Motion, Point, Samples};
pub use bus::{Bus, Regeneration};
pub use design_file::{Choice, DesignFile, FixedSpring, JointDesign, MotorName, Reduction};
pub use drive::{Drive, MotorDrag};
pub use driven::Driven;
pub use gear::{EfficiencyCovers, GearModel, GearsFrom, RatioChoice, backdrive_efficiency, stages};
pub use gear_map::{FamilyPlace, FamilyPoint, GearMap, GearPiece, Line, MapRow};
pub use limits::{Arrangement, LIMIT_NAMES, Limits, Ripple, Spring, TorqueBandwidth};
pub use motions::{FromDisk, Motions};
pub use objective::{Balance, Balancing, Extreme, Objective, Quantity};
pub use prices::{MOST_YEARS, NoPrice, Prices};
pub use read::{describe, read, read_changed, read_scaled, read_source, read_without_springs};
pub use robot::{Budget, Carried, Filter, Joint, Peaks, Robot, RobotCase};
pub use set::Settings;
pub use teeth::{LEAST_TEETH, NoTeeth, Stage, Teeth, Toothed, Train, trains};
pub use turns::{Turns, Windings};
