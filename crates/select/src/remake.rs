//! The choice made again with what was measured.
//!
//! The one idea: the fitted motor takes the place of its declared row, and everything else stays. What
//! changes for a joint (ratio, window, margins, rank, the first choice) is the difference between the two,
//! and the regret is what the choice made before costs under the fitted model. Friction that was found behind a
//! gear looks the same on either side of it, but another ratio tells them apart: the choice is given
//! for both readings.

mod shares;

use std::sync::Arc;

pub use shares::{Part, Share};

use super::answer::{Design, Reason, Refused, order};
use super::best::best_design;
use super::mount::{JointDemand, Site};
use super::optimize::optimize;
use super::{Evaluation, Margin};
use crate::program::{Bind, Certificate};
use gearwise_model::actuator::estimate::{complete, completed};
use gearwise_model::actuator::fitted::{Note, notes};
use gearwise_model::actuator::limits::hottest;
use gearwise_model::actuator::shaft::sign;
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::effects::{FittedEffect, Side};
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Robot};

/// What the measurement changes at one joint.
#[derive(Debug, Clone)]
pub struct Remade<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// Id of the motor.
    pub motor: String,
    /// Number of motors of the catalogue.
    pub motors: usize,
    /// The motor by its declared row; `None` where the catalogue does not have it.
    pub before: Option<Choice>,
    /// The motor as fitted.
    pub after: Choice,
    /// The same with the friction that was found at the output instead, where both readings fit the logs.
    pub output_side: Option<Choice>,
    /// The first choice of the catalogue before, if any motor can do it.
    pub first_before: Option<Chosen>,
    /// The first choice with the fitted motor in place of its row.
    pub first_after: Option<Chosen>,
    /// What the first choice before costs under the fitted model.
    pub regret: Option<Regret>,
    /// What the ratio of the declared row costs for the fitted motor.
    pub own_regret: Option<Regret>,
    /// What each part of what was fitted moves.
    pub shares: Vec<Share>,
    /// The objective over the ratios of the joint, by the declared row and as fitted: where all limits are kept.
    pub curves: [Vec<(f64, f64)>; 2],
    /// How what was fitted enters the limits.
    pub notes: Vec<Note>,
}

/// What came of a motor at a joint.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The best design, or why there is none.
    pub outcome: Result<Chosen, Reason>,
    /// Its place among the motors that can do it, the first is 1.
    pub rank: Option<usize>,
}

/// A design that was chosen.
#[derive(Debug, Clone)]
pub struct Chosen {
    /// Id of the motor.
    pub motor: String,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<String>,
    /// N*.
    pub ratio: f64,
    /// The window that it lies in.
    pub window: (f64, f64),
    /// What ends the window.
    pub binds: (Bind, Bind),
    /// Every margin.
    pub margins: Vec<Margin>,
    /// The objective.
    pub objective: f64,
    /// Mean loss \[W\].
    pub loss: f64,
    /// The proof.
    pub certificate: Certificate,
}

/// What a choice made before comes to under the fitted model.
#[derive(Debug, Clone)]
pub struct Regret {
    /// Its objective there; `None` where it needs a number that is not known.
    pub objective: Option<f64>,
    /// What it breaks there, if anything.
    pub broken: Option<Margin>,
    /// `(objective − best)/|best|`, best being the choice made again; `None` where it breaks a limit.
    pub relative: Option<f64>,
}

impl Chosen {
    pub(super) fn new(design: &Design) -> Chosen {
        let window = design.optimum.window();
        Chosen {
            motor: design.motor.id.clone(),
            gear: design.gear.map(str::to_string),
            ratio: design.optimum.ratio,
            window: (window.min, window.max),
            binds: (window.low.clone(), window.high.clone()),
            margins: design.evaluation.margins.clone(),
            objective: design.optimum.objective,
            loss: design.evaluation.loss,
            certificate: design.optimum.certificate.clone(),
        }
    }

    /// The smallest margin.
    pub fn tightest(&self) -> Option<&Margin> {
        self.margins.iter().min_by(|a, b| a.margin.total_cmp(&b.margin))
    }
}

/// Makes the choice again for every joint: the fitted motor takes the place of the row `declared_id`, or
/// stands beside the others where the catalogue has no such row.
pub fn remake<'a>(robot: &'a Robot, catalog: &Catalog, declared_id: &str, fitted: &Motor) -> Vec<Remade<'a>> {
    let fitted = completed(Motor { id: declared_id.to_string(), ..fitted.clone() });
    let catalog = &with_declared(catalog, declared_id).with_turns(&robot.listed_turns());
    let declared = catalog.motors.iter().find(|m| m.id == declared_id);
    let result = optimize(robot, catalog);
    let pairs = robot.joints.iter().zip(&result.joints);
    let one = |(joint, before): (&'a Joint, &super::answer::JointResult)| {
        let demand = JointDemand::new(joint, catalog);
        let site = Site::new(robot, joint, &demand);
        let after = best_design(site, &fitted, false);
        let others: Vec<&Design> = before.candidates.iter().filter(|d| d.motor.id != declared_id).collect();
        let rank = |design: &Design| 1 + others.iter().filter(|d| order(d, design).is_lt()).count();
        let choice = |found: &Result<Design, Refused>| match found {
            Ok(design) => Choice { outcome: Ok(Chosen::new(design)), rank: Some(rank(design)) },
            Err(refused) => Choice { outcome: Err(refused.reason()), rank: None },
        };
        let own = before.candidates.iter().find(|d| d.motor.id == declared_id);
        let rejected = before.rejected.iter().find(|r| r.motor.id == declared_id).map(|r| r.reason.clone());
        let apart = before.unjudged.iter().find(|u| u.motor.id == declared_id);
        let refused = rejected.or(apart.map(|u| Reason::Unjudged(u.because.clone())));
        let own_before = match own {
            Some(design) => Some(Choice { outcome: Ok(Chosen::new(design)), rank: Some(rank(design)) }),
            None => refused.map(|reason| Choice { outcome: Err(reason), rank: None }),
        };
        let mut remade: Vec<&Design> = others.clone();
        remade.extend(after.as_ref().ok());
        remade.sort_by(|a, b| order(a, b));
        let (first, first_after) = (before.candidates.first(), remade.first());
        let at = |design: &Design| evaluate(site, &fitted, design);
        let regret = first.map(|first| {
            let evaluation = if first.motor.id == declared_id { at(first) } else { Some(first.evaluation.clone()) };
            regret_of(joint, evaluation, first_after.map(|d| d.optimum.objective))
        });
        let own_regret = own.map(|own| regret_of(joint, at(own), after.as_ref().ok().map(|d| d.optimum.objective)));
        Remade {
            joint,
            motor: declared_id.to_string(),
            motors: before.motors(),
            before: own_before,
            after: choice(&after),
            output_side: output_side(robot, joint, catalog, declared, &fitted, &rank),
            first_before: first.map(Chosen::new),
            first_after: first_after.map(|d| Chosen::new(d)),
            regret,
            own_regret,
            shares: shares::shares(site, declared, &fitted),
            curves: [declared.map_or_else(Vec::new, |declared| curve(site, declared)), curve(site, &fitted)],
            notes: notes(&fitted, joint, Some(hottest(&fitted, joint).0)),
        }
    };
    pairs.map(one).collect()
}

/// Ratios at which the objective is drawn.
const DRAWN: usize = 120;

/// The objective of a motor over the ratios that a joint may have: where all limits are kept, and it is free.
fn curve(site: Site, motor: &Motor) -> Vec<(f64, f64)> {
    let Some((min, max)) = site.joint.ratio.range().filter(|(min, max)| min < max) else { return Vec::new() };
    let Ok(prepared) = site.direct(motor).prepared() else { return Vec::new() };
    if site.joint.limits.spring.is_some() {
        return Vec::new();
    }
    let at = |ratio: f64| {
        let evaluation = Evaluation {
            energy: prepared.energy(ratio),
            peak_power: Some(prepared.peak_power(ratio)),
            ..prepared.at(ratio)
        };
        let objective = evaluation.objective(&site.joint.objective)?;
        evaluation.feasible.then_some((ratio, objective))
    };
    grid(min, max, DRAWN).into_iter().filter_map(at).collect()
}

/// The catalogue as one chooses from it, with the row of the fitted motor among the choice in any case.
fn with_declared(catalog: &Catalog, declared: &str) -> Catalog {
    let mut free = catalog.clone().free(false);
    let own = |motor: &Motor| motor.id == declared;
    free.motors.extend(free.aside.iter().filter(|m| own(m)).cloned());
    free.aside.retain(|m| !own(m));
    free.motors.sort_by(|a, b| a.id.cmp(&b.id));
    complete(free)
}

/// The fitted motor in a design that was made for its row.
fn evaluate(site: Site, fitted: &Motor, design: &Design) -> Option<Evaluation> {
    let prepared = site.mount(fitted, design.gear).ok()?.prepared().ok()?;
    let ratio = design.optimum.ratio;
    Some(Evaluation {
        energy: prepared.energy(ratio),
        peak_power: Some(prepared.peak_power(ratio)),
        ..prepared.at(ratio)
    })
}

fn regret_of(joint: &Joint, evaluation: Option<Evaluation>, best: Option<f64>) -> Regret {
    let objective = evaluation.as_ref().and_then(|e| e.objective(&joint.objective));
    let broken = evaluation.filter(|e| !e.feasible).and_then(|e| e.tightest().copied());
    let relative = match (objective, best) {
        (Some(objective), Some(best)) if broken.is_none() && best != 0.0 => Some((objective - best) / best.abs()),
        _ => None,
    };
    Regret { objective, broken, relative }
}

/// The fitted motor with the friction that its row did not declare at the output of the gear on the bench,
/// where it stays the same whatever the ratio. `None` where none was found, or where no gear was between.
fn output_side(
    robot: &Robot,
    joint: &Joint,
    catalog: &Catalog,
    declared: Option<&Motor>,
    fitted: &Motor,
    rank: &dyn Fn(&Design) -> usize,
) -> Option<Choice> {
    let bench = fitted.fitted_gear.and_then(|g| g.ratio).filter(|ratio| *ratio != 1.0)?;
    let own = |of: fn(&Motor) -> Option<f64>| declared.and_then(of);
    let found = |of: fn(&Motor) -> Option<f64>| of(fitted).unwrap_or(0.0) - own(of).unwrap_or(0.0);
    let (viscous, coulomb) = (found(|m| m.viscous_friction), found(|m| m.coulomb_friction));
    let friction = |e: &&FittedEffect| e.effect.side() == Side::Either;
    let moved: Vec<&FittedEffect> = fitted.effects.iter().filter(friction).collect();
    if viscous == 0.0 && coulomb == 0.0 && moved.is_empty() {
        return None;
    }
    let motor = Motor {
        viscous_friction: own(|m| m.viscous_friction),
        // Without a declared one all friction that the logs show is at the output.
        coulomb_friction: Some(own(|m| m.coulomb_friction).unwrap_or(0.0)),
        effects: fitted.effects.iter().filter(|e| !friction(e)).cloned().collect(),
        ..fitted.clone()
    };
    let mut joint = joint.clone();
    let motion = Arc::make_mut(&mut joint.motion);
    for k in 0..motion.len() {
        let speed = bench * motion.velocity[k];
        let at = gearwise_model::effects::Operating::at_speed(speed);
        let (mut torque, mut slope) = (coulomb * sign(speed) + viscous * speed, viscous);
        for fitted in &moved {
            torque += fitted.effect.value(&fitted.values, &at);
            slope += fitted.speed_slope(&at);
        }
        // Torque at the output is N times that at the motor, and speed there 1/N.
        motion.torque[k] += bench * torque;
        motion.torque_rate[k] += bench * bench * slope * motion.acceleration[k];
    }
    let demand = JointDemand::new(&joint, catalog);
    let found = best_design(Site::new(robot, &joint, &demand), &motor, false);
    Some(match found {
        Ok(design) => Choice { outcome: Ok(Chosen::new(&design)), rank: Some(rank(&design)) },
        Err(refused) => Choice { outcome: Err(refused.reason()), rank: None },
    })
}
