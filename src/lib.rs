//! Gearwise chooses the motor and the gear ratio of a robot joint and proves the choice.
//!
//! The crate is a facade of five, each with one noun and its own README, and the command line:
//!
//! * `gearwise-model`: [`units`], [`input`], [`effects`], [`motion`], [`transmission`], [`catalog`], [`mechanism`],
//!   [`requirement`], [`actuator`]: what one motor, one gear and one joint can do.
//! * `gearwise-select` ([`design`]): evaluation of one design, the sweep, the ratio program with its certificate, the
//!   ranking over a catalogue.
//! * `gearwise-identify` ([`measured`]): bench files and logs; which effect the declared model lacks; the catalogue row
//!   that they make.
//! * `gearwise-rules` ([`rules`], [`hardware`]): design rules as data, rules files, the lock of the rows a design uses;
//!   rules of robot models.
//! * `gearwise-report` ([`report`]): tables, JSON, CSV, pictures, exports.
//!
//! In the crate itself: [`ask`] (one function for each question, and answers that own what they speak of), [`study`] (many
//! robots in one go, with a journal of what is finished), [`explore`] (one requirement asked again and again, for a page
//! with sliders), [`pages`] (the pages of docs/ that are made from the registries), [`cli`] (one file for each command).
//!
//! What is promised is what these pages show. `words`, `numerics`, `report`, `ask`, `study`, `explore` and `pages` can be
//! reached, because the program, its tests and examples need them, and may change with any version.
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
