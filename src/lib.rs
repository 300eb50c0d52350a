//! Gearwise chooses the motor and the gear ratio of a robot joint and proves the choice.
//!
//! Data goes one way through the house, and each room can be understood from its own files and the
//! rooms below it:
//!
//! ```text
//! files ─► catalog, requirement ─► actuator (the model) ─► design ─► rules ─► report ◄─ cli
//! ```
//!
//! * [`units`]: quantities at the edges; inside everything is SI.
//! * [`input`]: files are read once, every mistake in them is collected with its place.
//! * [`catalog`]: motors and gears in their declared conventions, converted to the power-invariant
//!   q-axis equivalent; the audit of redundant numbers.
//! * [`requirement`]: robot, joints, motions as arrays over samples, limits, objectives.
//! * [`mechanism`]: the robot as a tree of rigid bodies (URDF, MJCF), and the joint torques of a trajectory.
//! * [`actuator`]: the model: metrics, shaft torque and voltage as linear forms in the features of a
//!   sample, effects, limits as Laurent polynomials in the ratio.
//! * [`design`]: evaluation of one design, the sweep, the ratio program with its certificate, the
//!   ranking over a catalogue.
//! * [`rules`]: design rules as data, rules files, the lock of the rows a design uses.
//! * [`measured`]: bench files and logs; which effect the declared model lacks; the catalogue row that they make.
//! * [`study`]: many robots in one go, with a journal of what is finished.
//! * [`report`]: tables, JSON, CSV, pictures, fitted actuators.
//! * [`cli`]: one file for each command.
//!
//! ```
//! use gearwise::{catalog::Catalog, design, requirement};
//!
//! let catalog = Catalog::builtin().unwrap();
//! let robot = requirement::read("requirements/quadruped_mini_cheetah.toml".as_ref()).unwrap();
//! let result = design::optimize(&robot, &catalog);
//! let knee = &result.joints[2].candidates[0];
//! assert!(knee.evaluation.feasible && knee.optimum.window().min <= knee.optimum.ratio);
//! ```

pub mod actuator;
pub mod catalog;
pub mod cli;
pub mod design;
pub mod input;
mod line_search;
pub mod measured;
pub mod mechanism;
pub mod report;
pub mod requirement;
pub mod rules;
pub mod study;
pub mod units;
