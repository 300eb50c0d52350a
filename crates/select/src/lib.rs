#![doc = include_str!("../README.md")]

pub mod agreement;
pub mod answer;
pub mod balance;
pub mod best;
pub mod break_even;
pub mod buildable;
#[cfg(test)]
#[path = "../../../tests/cases/mod.rs"]
pub(crate) mod cases;
pub mod evaluate;
pub mod examine;
pub mod explain;
pub mod families;
pub mod figures;
pub mod flatness;
pub mod judge;
pub mod loads;
pub mod many;
pub mod mount;
pub mod nearby;
pub mod optimize;
pub mod options;
pub mod outlook;
pub mod over;
pub mod pareto;
pub mod program;
pub mod prune;
pub mod remake;
pub mod robot;
pub mod robust;
mod selection;
pub mod simulated;
mod solved;
pub mod spring;
pub mod sweep;
pub mod turns;
pub mod windings;

pub use answer::{Design, JointResult, Reason, RobotResult, Unusable};
pub use evaluate::{Evaluation, Margin, Prepared};
pub use gearwise_model::actuator::limits::Candidate;
pub use gearwise_model::numerics::grid::grid;
pub use mount::{JointDemand, Mount, Site, load_through};
pub use optimize::optimize;
pub use options::Options;
pub use sweep::sweep;

use gearwise_model::catalog::{Catalog, matches_pattern};
use gearwise_model::requirement::{Filter, GearsFrom, RatioChoice, Robot};
use gearwise_model::words::shorten;

/// Every pattern of a robot must name a motor or a gear of the catalogue.
///
/// # Errors
/// The pattern that names none, in words.
pub fn check_patterns(robot: &Robot, catalog: &Catalog) -> Result<(), String> {
    for joint in &robot.joints {
        for pattern in joint.motors.patterns() {
            let named = |m: &&gearwise_model::catalog::Motor| Filter::matches(pattern, m);
            if catalog.motors.iter().chain(&catalog.aside).find(named).is_none() {
                let help = match catalog.near(pattern).as_slice() {
                    [] => "`gearwise rank` lists the motors".to_string(),
                    near => format!("there are {}", near.join(", ")),
                };
                return Err(format!(
                    "joint `{}`: no motor of the catalogue matches `{}`; {help}",
                    joint.name,
                    shorten(pattern)
                ));
            }
        }
        for pattern in &joint.motors.modules {
            if !catalog.modules.iter().any(|module| module.matches(pattern)) {
                let ids = catalog.modules.iter().map(|module| module.id.as_str());
                // Mostly the end of an id was forgotten.
                let begins = ids.clone().find(|id| !pattern.is_empty() && id.starts_with(pattern.as_str()));
                let help = match begins.or(gearwise_model::words::nearest(pattern, ids)) {
                    _ if catalog.modules.is_empty() => "it has no modules at all: `--also` adds a file".to_string(),
                    Some(near) => format!("did you mean `{near}`?"),
                    None => "`gearwise catalog list modules` lists them".to_string(),
                };
                return Err(format!(
                    "joint `{}`: no module of the catalogue matches `{}`; {help}",
                    joint.name,
                    shorten(pattern)
                ));
            }
        }
        let RatioChoice::Catalog { patterns, from, .. } = &joint.ratio else { continue };
        if *from != GearsFrom::Gears {
            families::check(joint, patterns, catalog)?;
            continue;
        }
        for pattern in patterns {
            if catalog.gears.iter().any(|g| matches_pattern(pattern, &g.id)) {
                continue;
            }
            let kinds = ["planetary-*", "strain-wave-*", "cycloidal-*", "belt-*"];
            let ids = catalog.gears.iter().map(|g| g.id.as_str()).chain(kinds);
            let help = match gearwise_model::words::nearest(pattern, ids) {
                _ if catalog.gears.is_empty() => "it has no gears at all; add a gear file to `--catalog`".to_string(),
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("ids begin with the kind, as in {}", kinds.join(", ")),
            };
            return Err(format!(
                "joint `{}`: no gear of the catalogue matches `{}`; {help}",
                joint.name,
                shorten(pattern)
            ));
        }
    }
    Ok(())
}
