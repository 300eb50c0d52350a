//! Gears that one can buy or make near the best ratio, and what they cost.
//!
//! The one idea: the best ratio is of the gear that the requirement describes; a gear of the catalogue has its own
//! efficiency, inertia and mass. The nearest ones are evaluated with these, as they would be where `gears` asks for them; one that
//! exceeds a limit, or of which it is not known what torque it carries, is not offered.

use super::answer::Design;
use super::buildable::{Built, built};
use super::evaluate::{Evaluation, Margin};
use super::flatness::{above, sprung};
use super::judge;
use super::mount::{Mount, load_through};
use crate::catalog::{Catalog, Gear};
use crate::requirement::{Joint, Robot};

/// How many gears are offered.
const OFFERED: usize = 3;
/// A gear whose ratio is further away than this factor is not near.
const NEAR: f64 = 1.5;

/// A gear of the catalogue at its own ratio, with the motor of a design.
#[derive(Debug, Clone)]
pub struct NearGear<'a> {
    /// The gear.
    pub gear: &'a Gear,
    /// The design with it.
    pub evaluation: Evaluation,
    /// The objective with it.
    pub objective: f64,
    /// By how much that is above the best (relative); `None` where that is not above zero.
    pub above: Option<f64>,
}

/// What can be built near a design.
#[derive(Debug, Clone, Default)]
pub struct Nearby<'a> {
    /// Gears of the catalogue, the nearest ratio first.
    pub gears: Vec<NearGear<'a>>,
    /// How many gears of the catalogue have a ratio near by, fit the motor and state what torque they carry.
    pub looked_at: usize,
    /// Where none of them is offered: the nearest, and the limit that it exceeds most. `None` where it lacks something else.
    pub exceeded: Option<(&'a Gear, Margin)>,
    /// A simple planetary gear: its teeth, and the design at its ratio.
    pub planetary: Option<Built<'a>>,
}

impl Nearby<'_> {
    /// By how much the objective with the planetary gear is above the best of a design (relative).
    pub fn planetary_above(&self, design: &Design) -> Option<f64> {
        above(self.planetary.as_ref()?.design.optimum.objective, design.optimum.objective)
    }
}

/// What can be built near a design of a free ratio; `None` where its gear is one of the catalogue.
pub fn nearby<'a>(robot: &Robot, joint: &Joint, catalog: &'a Catalog, design: &Design<'a>) -> Option<Nearby<'a>> {
    if design.gear.is_some() || joint.ratio.is_catalog() {
        return None;
    }
    let best = design.optimum.ratio;
    let away = |gear: &Gear| (gear.ratio / best).ln().abs();
    let mut gears: Vec<&'a Gear> = catalog.gears.iter().filter(|gear| away(gear) <= NEAR.ln()).collect();
    gears.retain(|gear| gear.fits(design.motor.row_id()) != Some(false) && joint.ratio.allows(gear.ratio));
    gears.retain(|gear| gear.peak_torque.is_some());
    gears.sort_by(|a, b| away(a).total_cmp(&away(b)).then(a.id.cmp(&b.id)));
    let mut found = Nearby { looked_at: gears.len(), ..Nearby::default() };
    let with_spring = sprung(joint, design)?;
    let load = load_through(&with_spring, None);
    for gear in gears {
        let mount = Mount::new(robot, &with_spring, &load, design.motor).with_gear(Some(gear));
        let Ok(prepared) = mount.prepared() else { continue };
        let evaluation = prepared.at_in_full(gear.ratio);
        if !evaluation.feasible {
            let margin = evaluation.tightest().copied();
            found.exceeded = found.exceeded.or(margin.map(|margin| (gear, margin)));
            continue;
        }
        let objective = evaluation.objective(&joint.objective);
        if let (Some(objective), None) = (objective, judge::doubt(&prepared, gear.ratio, false)) {
            let above = above(objective, design.optimum.objective);
            found.gears.push(NearGear { gear, evaluation, objective, above });
        }
        if found.gears.len() == OFFERED {
            break;
        }
    }
    if !found.gears.is_empty() {
        found.exceeded = None;
    }
    // With a spring every tooth would ask for another spring.
    if joint.limits.spring.is_none() {
        found.planetary = built(robot, joint, catalog, design).filter(|built| built.train.is_some());
    }
    Some(found)
}
