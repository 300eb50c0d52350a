//! What may be built into one joint, given what it carries: every motor with every gear or number of
//! stages that keeps the joint's own limits, each with its best ratio and the proof of it.

use rayon::prelude::*;

use crate::catalog::Catalog;
use crate::design::optimize::{Design, best_design, design};
use crate::design::program::{Bind, Certificate, Optimum, Window};
use crate::design::{JointDemand, Prepared, geared_candidate};
use crate::requirement::{Joint, Quantity, RatioChoice, Robot};

/// One way to build a joint.
#[derive(Debug, Clone)]
pub(super) struct Item<'a> {
    /// Index of the motor in the catalogue.
    pub motor: usize,
    /// The design at its own best ratio.
    pub design: Design<'a>,
    /// Mass of one actuator \[kg\].
    pub mass: f64,
    /// Ratios over which it may move.
    pub ratios: (f64, f64),
    /// The objective is nowhere below this.
    pub lower: f64,
}

/// Everything that may be built into a joint.
#[derive(Debug, Default)]
pub(super) struct Menu<'a> {
    pub items: Vec<Item<'a>>,
    /// Motors left out because a mass is not known that the robot's choice needs.
    pub without_mass: Vec<usize>,
    /// Motors that were not solved, or not proved.
    pub unproved: Vec<usize>,
}

/// What a choice needs to know of each joint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    /// The mass decides.
    pub mass: bool,
    /// The ratio may leave its own best.
    pub moves: bool,
    /// Only designs of which every limit could be checked.
    pub only_checked: bool,
}

/// The menu of a joint; `carrying` is the joint with the torque of what it carries.
pub(super) fn menu<'a>(robot: &'a Robot, carrying: &Joint, catalog: &'a Catalog, needs: Needs) -> Menu<'a> {
    let demand = JointDemand::new(carrying, catalog);
    let pieces = pieces(carrying, needs);
    let found: Vec<(Vec<Item>, bool, bool)> = (0..catalog.motors.len())
        .into_par_iter()
        .map(|motor| match &carrying.ratio {
            RatioChoice::Continuous { .. } => continuous(robot, &pieces, &demand, catalog, motor, needs),
            RatioChoice::Catalog { .. } => geared(robot, carrying, &demand, catalog, motor, needs),
        })
        .collect();
    let mut menu = Menu::default();
    for (motor, (items, without_mass, unproved)) in found.into_iter().enumerate() {
        menu.items.extend(items);
        menu.without_mass.extend(without_mass.then_some(motor));
        menu.unproved.extend(unproved.then_some(motor));
    }
    menu
}

/// The joint for each number of gear stages, where the mass decides; else the joint as it is.
fn pieces(joint: &Joint, needs: Needs) -> Vec<Joint> {
    let weighs = needs.mass || needs.moves && joint.objective.weight(Quantity::Mass) > 0.0;
    let (RatioChoice::Continuous { min, max }, Some((_, stage)), true) =
        (&joint.ratio, joint.gear.mass_per_stage, weighs)
    else {
        return vec![joint.clone()];
    };
    let powers = std::iter::successors(Some(1.0), |n| Some(n * stage));
    let mut ends = vec![*min];
    ends.extend(powers.take_while(|n| n < max).filter(|n| n > min));
    ends.push(*max);
    let piece = |w: &[f64]| Joint { ratio: RatioChoice::Continuous { min: w[0], max: w[1] }, ..joint.clone() };
    ends.windows(2).map(piece).collect()
}

fn continuous<'a>(
    robot: &Robot,
    pieces: &[Joint],
    demand: &JointDemand,
    catalog: &'a Catalog,
    motor: usize,
    needs: Needs,
) -> (Vec<Item<'a>>, bool, bool) {
    let (mut items, mut without_mass, mut unproved) = (Vec::new(), false, false);
    for piece in pieces {
        match best_design(robot, piece, demand, &catalog.motors[motor], needs.only_checked) {
            Ok(found) => {
                let RatioChoice::Continuous { max, .. } = piece.ratio else { continue };
                let window = found.optimum.window().clone();
                let mass = catalog.motors[motor].mass.zip(piece.gear.mass_at(max)).map(|(a, b)| a + b);
                // Nothing moves where the ratio stays; a spring stays with its ratio.
                let mass = if needs.moves { mass } else { found.evaluation.mass };
                let stays = found.spring.is_some() || !needs.moves;
                let ratios =
                    if stays { (found.evaluation.ratio, found.evaluation.ratio) } else { (window.min, window.max) };
                unproved |= needs.moves && (found.optimum.windows.len() > 1 || found.spring.is_some());
                take(&mut items, found, catalog, motor, mass, ratios, needs, &mut without_mass, &mut unproved);
            }
            Err(why) => unproved |= matches!(why.reason, crate::design::optimize::Reason::NotSolved(_)),
        }
    }
    (items, without_mass, unproved)
}

fn geared<'a>(
    robot: &Robot,
    joint: &Joint,
    demand: &JointDemand<'a>,
    catalog: &'a Catalog,
    motor: usize,
    needs: Needs,
) -> (Vec<Item<'a>>, bool, bool) {
    let (mut items, mut without_mass, mut unproved) = (Vec::new(), false, false);
    if joint.limits.spring.is_some() {
        // The spring is chosen for each gear: only the best of them is known.
        if let Ok(found) = best_design(robot, joint, demand, &catalog.motors[motor], needs.only_checked) {
            let (mass, ratio) = (found.evaluation.mass, found.evaluation.ratio);
            take(&mut items, found, catalog, motor, mass, (ratio, ratio), needs, &mut without_mass, &mut unproved);
            unproved = true;
        }
        return (items, without_mass, unproved);
    }
    for (gear, load) in demand.gears_for(&catalog.motors[motor]) {
        let Ok(candidate) = geared_candidate(robot, joint, load, &catalog.motors[motor], gear) else { continue };
        let prepared = Prepared::new(candidate);
        if needs.only_checked && !prepared.judged(gear.ratio).unchecked.is_empty() {
            continue;
        }
        let evaluation = prepared.at(gear.ratio);
        let Some(objective) = evaluation.objective(&joint.objective).filter(|_| evaluation.feasible) else { continue };
        let bind = Bind { limit: "gear", sample: None };
        let optimum = Optimum {
            ratio: gear.ratio,
            objective,
            windows: vec![Window { min: gear.ratio, max: gear.ratio, low: bind.clone(), high: bind }],
            certificate: Certificate::Certified { lower_bound: objective, gap: 0.0, method: "all gears evaluated" },
            shadow_prices: Vec::new(),
        };
        let found = design(&prepared, &catalog.motors[motor], Some(&gear.id), optimum);
        let ratios = (gear.ratio, gear.ratio);
        take(&mut items, found, catalog, motor, evaluation.mass, ratios, needs, &mut without_mass, &mut unproved);
    }
    (items, without_mass, unproved)
}

#[expect(clippy::too_many_arguments, reason = "the parts of one item")]
fn take<'a>(
    items: &mut Vec<Item<'a>>,
    found: Design,
    catalog: &'a Catalog,
    motor: usize,
    mass: Option<f64>,
    ratios: (f64, f64),
    needs: Needs,
    without_mass: &mut bool,
    unproved: &mut bool,
) {
    if needs.mass && mass.is_none() {
        *without_mass = true;
        return;
    }
    let lower = match found.optimum.certificate {
        Certificate::Certified { lower_bound, .. } => lower_bound.min(found.optimum.objective),
        Certificate::NotCertified(_) => {
            *unproved = true;
            found.optimum.objective
        }
    };
    items.push(Item { motor, design: own(found, catalog, motor), mass: mass.unwrap_or(0.0), ratios, lower });
}

/// The design with the names that the catalogue has, so that it outlives the joint it was found for.
pub(super) fn own<'a>(design: Design, catalog: &'a Catalog, motor: usize) -> Design<'a> {
    let gear = design.gear.and_then(|id| catalog.gears.iter().find(|g| g.id == id)).map(|g| g.id.as_str());
    Design {
        motor: &catalog.motors[motor],
        gear,
        optimum: design.optimum,
        evaluation: design.evaluation,
        unchecked: design.unchecked,
        assumed: design.assumed,
        winding_temperature: design.winding_temperature,
        reversal_time: design.reversal_time,
        spring: design.spring,
    }
}
