//! Gears that one can buy or make near the best ratio, and what they cost.
//!
//! The one idea: the best ratio is of the gear that the requirement describes; a gear of the catalogue has its own
//! efficiency, inertia and mass. Each that may be mounted near by is evaluated with these, exactly as where `gears` asks for
//! it. What it costs more is said in parts, by changing one thing after another: the ratio, what the gear loses, its inertia,
//! and its mass where that counts. A gear that keeps less, or of which less is known, comes behind and says so.

use rayon::prelude::*;

use super::Prepared;
use super::answer::{Design, Unusable};
use super::buildable::{Built, built};
use super::evaluate::{Evaluation, Margin};
use super::flatness::{above, sprung};
use super::judge::unjudged;
use super::mount::{Mount, load_through};
use gearwise_model::actuator::fitted::gear_with_fit;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::{Catalog, Gear, Motor};
use gearwise_model::requirement::{EfficiencyCovers, GearModel, Joint, Quantity, RatioChoice, Robot};

/// How many gears are named.
pub const NAMED: usize = 3;
/// A gear is near where its ratio is feasible with the described gear, or differs from N* by at most this share of it.
pub const NEAR: f64 = 0.3;

/// How a gear stands against the limits, the best first.
#[derive(Debug, Clone, PartialEq)]
pub enum Standing {
    /// It keeps every limit that can be judged of the best design.
    Keeps,
    /// It keeps what can be judged; something that can be judged of the best design cannot be with it.
    LessKnown,
    /// It keeps what can be judged, and something that the requirement states cannot be.
    Unjudged,
    /// It exceeds a limit.
    Exceeds,
    /// It cannot be evaluated.
    Unusable(Unusable),
}

impl Standing {
    fn order(&self) -> u8 {
        match self {
            Standing::Keeps => 0,
            Standing::LessKnown => 1,
            Standing::Unjudged => 2,
            Standing::Exceeds => 3,
            Standing::Unusable(_) => 4,
        }
    }

    /// The word for it in files.
    pub fn word(&self) -> &'static str {
        match self {
            Standing::Keeps => "keeps",
            Standing::LessKnown => "less_known",
            Standing::Unjudged => "unjudged",
            Standing::Exceeds => "exceeds",
            Standing::Unusable(_) => "unusable",
        }
    }
}

/// What of the objective is more than that of the best design, by what is changed one after the other, in the unit of the
/// objective. Where all is known the parts add up to the whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// The described gear at the other ratio.
    pub ratio: f64,
    /// With what the other gear loses: its efficiencies and its torque without load.
    pub efficiency: f64,
    /// With its inertia; `None` where that is not known, and is left out of the whole.
    pub inertia: Option<f64>,
    /// With its mass; `None` where the objective does not count it.
    pub mass: Option<f64>,
}

/// A gear of the catalogue at its own ratio, with the motor of a design.
#[derive(Debug, Clone)]
pub struct NearGear<'a> {
    /// The gear.
    pub gear: &'a Gear,
    /// How it stands against the limits.
    pub standing: Standing,
    /// The design with it; `None` where it cannot be evaluated.
    pub evaluation: Option<Evaluation>,
    /// Limits that cannot be checked with it, and why.
    pub unchecked: Vec<Remark>,
    /// The objective with it; `None` where a number of it is not known.
    pub objective: Option<f64>,
    /// What that is more than the best, in the unit of the objective.
    pub more: Option<f64>,
    /// The same as a share of the best; `None` where that is not above zero.
    pub above: Option<f64>,
    /// Where it comes from; `None` where nothing is to be told apart or the described gear is not known at the ratio.
    pub parts: Option<Parts>,
    /// Mass of motor and gear less that of the design \[kg\]; `None` where one of them is not known.
    pub mass: Option<f64>,
}

impl NearGear<'_> {
    /// Whether every limit was judged and is kept.
    pub fn keeps_all(&self) -> bool {
        self.standing == Standing::Keeps && self.unchecked.is_empty()
    }

    /// The limits that it exceeds, the worst first.
    pub fn exceeded(&self) -> Vec<&Margin> {
        let over = self.evaluation.iter().filter(|there| !there.feasible).flat_map(|there| &there.margins);
        let mut over: Vec<&Margin> = over.filter(|m| m.margin < -super::evaluate::FEASIBILITY_TOLERANCE).collect();
        over.sort_by(|a, b| a.margin.total_cmp(&b.margin));
        over
    }
}

/// The ratios about N* at which the catalogue has no gear that may be mounted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap<'a> {
    /// The next gear of a smaller ratio that fits and whose ratio the requirement allows.
    pub below: Option<&'a Gear>,
    /// The next one of a larger ratio.
    pub above: Option<&'a Gear>,
}

/// What can be bought or made near a design.
#[derive(Debug, Clone, Default)]
pub struct Nearby<'a> {
    /// The first gears of the catalogue: by how they stand, then by the objective with them; of those that exceed a limit by how
    /// far; then the nearest.
    pub gears: Vec<NearGear<'a>>,
    /// How many gears of the catalogue are near, fit the motor or do not say what they fit, and have a ratio that the
    /// requirement allows.
    pub looked_at: usize,
    /// Where there is none.
    pub gap: Option<Gap<'a>>,
    /// A simple planetary gear: its teeth, and the design at its ratio.
    pub planetary: Option<Built<'a>>,
}

impl Nearby<'_> {
    /// By how much the objective with the planetary gear is above the best of a design (relative).
    pub fn planetary_above(&self, design: &Design) -> Option<f64> {
        above(self.planetary.as_ref()?.design.optimum.objective, design.optimum.objective)
    }
}

/// Whether a gear's ratio is near that of a design: in one of its windows, or within [`NEAR`] of its ratio.
pub fn is_near(design: &Design, ratio: f64) -> bool {
    let windows = &design.optimum.windows;
    (ratio / design.optimum.ratio - 1.0).abs() <= NEAR || windows.iter().any(|w| w.min <= ratio && ratio <= w.max)
}

/// What can be bought or made near a design of a free ratio; `None` where its gear is one of the catalogue, or the requirement
/// lists the stages of a gear that is made.
pub fn nearby<'a>(robot: &Robot, joint: &Joint, catalog: &'a Catalog, design: &Design<'a>) -> Option<Nearby<'a>> {
    if design.gear.is_some() || joint.ratio.is_catalog() || joint.ratio.teeth().is_some() {
        return None;
    }
    let motor = design.motor;
    // Where a family is asked for, its points are what is near.
    let family = joint.family_map().map_or("", |map| map.family());
    let may_be = |gear: &&'a Gear| {
        gear.family == family && gear.fits(motor.machine_id()) != Some(false) && joint.ratio.allows(gear.ratio)
    };
    let all: Vec<&'a Gear> = catalog.all_gears().filter(may_be).collect();
    let near: Vec<&'a Gear> = all.iter().copied().filter(|gear| is_near(design, gear.ratio)).collect();
    let with_spring = sprung(joint, design)?;
    let look = Look::new(robot, &with_spring, motor, design);
    let mut gears: Vec<NearGear> = near.par_iter().map(|gear| look.at(gear)).collect();
    sort(&mut gears, design.optimum.ratio);
    gears.truncate(NAMED);
    for found in &mut gears {
        found.parts = look.parts(found);
    }
    let best = design.optimum.ratio;
    let gap = near.is_empty().then(|| Gap {
        below: all.iter().copied().filter(|gear| gear.ratio < best).max_by(|a, b| a.ratio.total_cmp(&b.ratio)),
        above: all.iter().copied().filter(|gear| gear.ratio > best).min_by(|a, b| a.ratio.total_cmp(&b.ratio)),
    });
    // With a spring every tooth would ask for another spring.
    let planetary = joint.limits.spring.is_none().then(|| built(robot, joint, catalog, design)).flatten();
    let planetary = planetary.filter(|built| built.train.is_some());
    Some(Nearby { gears, looked_at: near.len(), gap, planetary })
}

/// Puts gears in the order in which they are named.
fn sort(gears: &mut [NearGear], best: f64) {
    let away = |near: &NearGear| (near.gear.ratio / best).ln().abs();
    let value = |near: &NearGear| match near.standing {
        Standing::Exceeds => near.exceeded().first().map_or(0.0, |worst| -worst.margin),
        _ => near.objective.filter(|value| !value.is_nan()).unwrap_or(f64::INFINITY),
    };
    gears.sort_by(|a, b| {
        let by_value = || value(a).total_cmp(&value(b)).then(away(a).total_cmp(&away(b)));
        a.standing.order().cmp(&b.standing.order()).then_with(by_value).then(a.gear.id.cmp(&b.gear.id))
    });
}

/// A design at whose motor other gears are looked at.
struct Look<'l> {
    robot: &'l Robot,
    /// The joint with the gear that it describes.
    joint: &'l Joint,
    /// The same as where gears of the catalogue are asked for.
    geared: Joint,
    motor: &'l Motor,
    design: &'l Design<'l>,
}

impl<'l> Look<'l> {
    fn new(robot: &'l Robot, joint: &'l Joint, motor: &'l Motor, design: &'l Design<'l>) -> Look<'l> {
        let ratio = RatioChoice::gears(Vec::new(), EfficiencyCovers::Load);
        let geared = Joint { ratio, gear: GearModel::IDEAL, gear_map: None, ..joint.clone() };
        Look { robot, joint, geared, motor, design }
    }

    fn objective(&self, there: &Evaluation) -> Option<f64> {
        there.objective(&self.joint.objective)
    }

    /// The motor with a gear, without [parts](NearGear::parts).
    fn at<'g>(&self, gear: &'g Gear) -> NearGear<'g> {
        let load = load_through(&self.geared, None);
        let mount = Mount::new(self.robot, &self.geared, &load, self.motor).with_gear(Some(gear));
        let unknown = |why| NearGear {
            gear,
            standing: Standing::Unusable(why),
            evaluation: None,
            unchecked: Vec::new(),
            objective: None,
            more: None,
            above: None,
            parts: None,
            mass: None,
        };
        let prepared = match mount.prepared() {
            Ok(prepared) => prepared,
            Err(why) => return unknown(why),
        };
        let evaluation = prepared.at_in_full(gear.ratio);
        let unchecked = prepared.unchecked_at(gear.ratio);
        let objective = self.objective(&evaluation);
        let is_new = |remark: &Remark| !self.design.unchecked.contains(remark);
        let standing = match () {
            () if !evaluation.feasible => Standing::Exceeds,
            () if !unjudged(self.robot, &self.geared, &unchecked).is_empty() => Standing::Unjudged,
            () if objective.is_none() || unchecked.iter().any(is_new) => Standing::LessKnown,
            () => Standing::Keeps,
        };
        let best = self.design.optimum.objective;
        NearGear {
            gear,
            standing,
            unchecked,
            objective,
            more: objective.map(|value| value - best),
            above: objective.and_then(|value| above(value, best)),
            parts: None,
            mass: evaluation.mass.zip(self.design.evaluation.mass).map(|(there, here)| there - here),
            evaluation: Some(evaluation),
        }
    }

    /// Where what a gear costs more comes from.
    fn parts(&self, near: &NearGear) -> Option<Parts> {
        let (whole, gear) = (near.objective?, near.gear);
        let objective = &self.joint.objective;
        // Of a mass alone there is nothing to tell apart.
        if objective.terms.iter().all(|(quantity, _)| *quantity == Quantity::Mass) {
            return None;
        }
        let ratio = gear.ratio;
        let described = match &self.joint.gear_map {
            Some(map) if !map.covers(ratio) => return None,
            Some(map) => map.gear(&self.joint.gear, ratio),
            None => gear_with_fit(self.motor, &self.joint.gear),
        };
        let load = load_through(self.joint, None);
        let here = Mount::new(self.robot, self.joint, &load, self.motor).prepared().ok()?;
        let at_ratio = self.objective(&here.at_in_full(ratio))?;
        // The same motor with a gear of some numbers of both.
        let plain = Joint { gear_map: None, ..self.joint.clone() };
        let load = load_through(&plain, None);
        let base = Mount::new(self.robot, &plain, &load, self.motor).candidate().ok()?;
        let with = |gear: GearModel| self.objective(&Prepared::new(base.with_gear(gear, None)).at_in_full(ratio));
        let own = super::mount::gear_model(gear)?;
        let losing = GearModel {
            efficiency: own.efficiency,
            backdrive_efficiency: own.backdrive_efficiency,
            no_load: own.no_load,
            friction_at_rest: own.friction_at_rest,
            ..described
        };
        let by_loss = with(losing)?;
        let counts_mass = objective.weight(Quantity::Mass) != 0.0;
        let heavy = GearModel { inertia: own.inertia, ..losing };
        // The last step leads to the gear of the catalogue itself.
        let by_inertia = if counts_mass { with(heavy)? } else { whole };
        Some(Parts {
            ratio: at_ratio - self.design.optimum.objective,
            efficiency: by_loss - at_ratio,
            inertia: gear.inertia.map(|_| by_inertia - by_loss),
            mass: counts_mass.then_some(whole - by_inertia),
        })
    }
}
