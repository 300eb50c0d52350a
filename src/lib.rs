//! Gearwise chooses the motor and the gear ratio of a robot joint and proves the choice.
//!
//! Data goes one way through the house: a room imports from the rooms above it in this list and from no other, and can
//! be understood from its own files and theirs.
//!
//! * `words`: how numbers, counts, cells and markup are written; the name that somebody may have meant.
//! * [`units`]: quantities at the edges; inside everything is SI.
//! * `output`: a file appears whole or not at all.
//! * [`numerics`]: line search, spline, polynomials: what knows nothing of robots.
//! * [`input`]: files are read once, every mistake in them is collected with its place.
//! * [`effects`]: what an actuator may do beyond its data sheet, one file each.
//! * [`motion`]: what a joint is asked for, as arrays over samples, and at every instant between them.
//! * [`transmission`]: what is between actuator and joint, and what it makes of a motion.
//! * [`catalog`]: motors and gears in their declared conventions, converted to the power-invariant
//!   q-axis equivalent; the audit of redundant numbers.
//! * [`mechanism`]: the robot as a tree of rigid bodies (URDF, MJCF), and the joint torques of a trajectory.
//! * [`requirement`]: robot, joints, limits, objectives.
//! * [`actuator`]: the model: metrics, shaft torque and voltage as linear forms in the features of a
//!   sample, limits as Laurent polynomials in the ratio, heat.
//! * [`design`]: evaluation of one design, the sweep, the ratio program with its certificate, the
//!   ranking over a catalogue.
//! * [`measured`]: bench files and logs; which effect the declared model lacks; the catalogue row that they make.
//! * [`hardware`]: what is bought for the joints of a robot model, in numbers at the joint.
//! * [`rules`]: design rules as data, rules files, the lock of the rows a design uses.
//! * [`report`]: tables, JSON, CSV, pictures, fitted actuators.
//! * [`ask`]: one function for each question, and answers that own what they speak of.
//! * [`study`]: many robots in one go, with a journal of what is finished.
//! * [`explore`]: one requirement asked again and again, for a page with sliders.
//! * [`pages`]: the pages of docs/ that are made from the registries.
//! * [`cli`]: one file for each command.
//!
//! What is promised is what these pages show. `output` is the crate's own; `words`, `numerics`, `report`, `ask`, `study`,
//! `explore` and `pages` can be reached, because the program, its tests and examples need them, and may change with any version.
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

#[cfg(feature = "measured")]
pub use gearwise_identify as measured;
#[cfg_attr(not(feature = "cli"), allow(unused_imports, reason = "files are written by the program alone"))]
use gearwise_model::output;
pub use gearwise_model::{actuator, catalog, effects, input, mechanism, motion, requirement, transmission, units};
#[doc(hidden)]
pub use gearwise_model::{numerics, words};
#[cfg(feature = "report")]
#[doc(hidden)]
pub use gearwise_report as report;
pub use gearwise_rules as rules;
pub use gearwise_rules::hardware;
pub use gearwise_select as design;

#[cfg(feature = "report")]
#[doc(hidden)]
pub mod ask;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod explore;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod pages;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod study;
