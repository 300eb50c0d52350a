//! What may be built into one joint, given what it carries: every motor with every gear or number of
//! stages that keeps the joint's own limits, each with its best ratio and the proof of it.

use rayon::prelude::*;

use crate::actuator::limits::Remark;
use crate::catalog::Catalog;
use crate::design::answer::{Design, Reason, Refused};
use crate::design::best::best_design;
use crate::design::judge;
use crate::design::mount::{JointDemand, Site};
use crate::design::options::Stop;
use crate::design::program::Certificate;
use crate::design::solved::{design, one_gear};
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
    /// Motors left out because they cannot be judged, each with what and why.
    pub unjudged: Vec<(usize, Vec<Remark>)>,
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
pub(super) fn menu<'a>(robot: &'a Robot, carrying: &Joint, catalog: &'a Catalog, needs: Needs, stop: Stop) -> Menu<'a> {
    let demand = JointDemand::new(carrying, catalog);
    let site = Site::new(robot, carrying, &demand).stopping(stop);
    let pieces = pieces(carrying, needs);
    let found: Vec<Made> = (0..catalog.motors.len())
        .into_par_iter()
        .map(|motor| match &carrying.ratio {
            // What is found is no answer any more.
            _ if stop.now() => Made::default(),
            RatioChoice::Continuous { .. } | RatioChoice::Listed { .. } => {
                continuous(site, &pieces, catalog, motor, needs)
            }
            RatioChoice::Catalog { .. } => geared(site, catalog, motor, needs),
        })
        .collect();
    let mut menu = Menu::default();
    for (motor, made) in found.into_iter().enumerate() {
        // A motor with a gear or number of stages that can be judged is a choice.
        if made.items.is_empty() && !made.unjudged.is_empty() {
            menu.unjudged.push((motor, made.unjudged));
        }
        menu.items.extend(made.items);
        menu.unproved.extend(made.unproved.then_some(motor));
    }
    menu
}

/// What came of one motor.
#[derive(Default)]
struct Made<'a> {
    items: Vec<Item<'a>>,
    /// What keeps some design of it from being judged.
    unjudged: Vec<Remark>,
    unproved: bool,
}

/// The joint for each number of gear stages, where the mass decides; for each listed ratio, where it may leave its best;
/// else the joint as it is.
fn pieces(joint: &Joint, needs: Needs) -> Vec<Joint> {
    let weighs = needs.mass || needs.moves && joint.objective.weight(Quantity::Mass) > 0.0;
    let between = |min: f64, max: f64| Joint { ratio: RatioChoice::Continuous { min, max }, ..joint.clone() };
    if let Some(values) = joint.ratio.listed()
        && (needs.moves || weighs && joint.gear.mass_per_stage.is_some())
    {
        return values.iter().map(|n| between(*n, *n)).collect();
    }
    let (RatioChoice::Continuous { min, max }, Some((_, stage)), true) =
        (&joint.ratio, joint.gear.mass_per_stage, weighs)
    else {
        return vec![joint.clone()];
    };
    let powers = std::iter::successors(Some(1.0), |n| Some(n * stage));
    let mut ends = vec![*min];
    ends.extend(powers.take_while(|n| n < max).filter(|n| n > min));
    ends.push(*max);
    ends.windows(2).map(|w| between(w[0], w[1])).collect()
}

fn continuous<'a>(site: Site, pieces: &[Joint], catalog: &'a Catalog, motor: usize, needs: Needs) -> Made<'a> {
    let mut made = Made::default();
    for piece in pieces {
        match best_design(Site { joint: piece, ..site }, &catalog.motors[motor], needs.only_checked) {
            Ok(found) => {
                let Some((_, max)) = piece.ratio.range() else { continue };
                let window = found.optimum.window().clone();
                let mass = catalog.motors[motor].mass.zip(piece.gear.mass_at(max)).map(|(a, b)| a + b);
                // Nothing moves where the ratio stays; a spring stays with its ratio.
                let mass = if needs.moves { mass } else { found.evaluation.mass };
                let stays = found.spring.is_some() || !needs.moves;
                let ratios =
                    if stays { (found.evaluation.ratio, found.evaluation.ratio) } else { (window.min, window.max) };
                made.unproved |= needs.moves && (found.optimum.windows.len() > 1 || found.spring.is_some());
                made.take(found, catalog, motor, mass, ratios, needs);
            }
            Err(why) => made.refuse(why),
        }
    }
    made
}

fn geared<'a>(site: Site, catalog: &'a Catalog, motor: usize, needs: Needs) -> Made<'a> {
    let Site { robot, joint, .. } = site;
    let mut made = Made::default();
    if joint.limits.spring.is_some() {
        // The spring is chosen for each gear: only the best of them is known.
        match best_design(site, &catalog.motors[motor], needs.only_checked) {
            Ok(found) => {
                let (mass, ratio) = (found.evaluation.mass, found.evaluation.ratio);
                made.take(found, catalog, motor, mass, (ratio, ratio), needs);
                made.unproved = true;
            }
            // That a gear's spring could not be solved for is told of the design alone.
            Err(Refused::Rejected(_)) => {}
            Err(why) => made.refuse(why),
        }
        return made;
    }
    for mount in site.mounts(&catalog.motors[motor]) {
        let Some(gear) = mount.gear else { continue };
        let prepared = match mount.prepared() {
            Ok(prepared) => prepared,
            Err(why) => {
                made.doubt(why.unknown());
                continue;
            }
        };
        let evaluation = prepared.at(gear.ratio);
        let Some(objective) = evaluation.objective(&joint.objective).filter(|_| evaluation.feasible) else { continue };
        let found = design(&mount, &prepared, one_gear(gear.ratio, objective));
        match judge::judged(robot, joint, found, needs.only_checked) {
            Ok(found) => made.take(found, catalog, motor, evaluation.mass, (gear.ratio, gear.ratio), needs),
            Err(why) => made.refuse(why),
        }
    }
    made
}

impl<'a> Made<'a> {
    /// Takes a design in.
    fn take(
        &mut self,
        found: Design,
        catalog: &'a Catalog,
        motor: usize,
        mass: Option<f64>,
        ratios: (f64, f64),
        needs: Needs,
    ) {
        if needs.mass && mass.is_none() {
            self.unjudged.push(("mass_budget", "the mass of motor or gear is not known"));
            return;
        }
        let lower = match found.optimum.certificate {
            Certificate::Certified { lower_bound, .. } => lower_bound.min(found.optimum.objective),
            Certificate::NotCertified(_) => {
                self.unproved = true;
                found.optimum.objective
            }
        };
        let design = found.of_catalog(catalog);
        self.items.push(Item { motor, design, mass: mass.unwrap_or(0.0), ratios, lower });
    }

    /// Notes why there is no item.
    fn refuse(&mut self, why: Refused) {
        match why {
            Refused::Rejected(why) => self.unproved |= matches!(why.reason, Reason::NotSolved(_)),
            Refused::Unjudged(why) => self.doubt(why.because),
        }
    }

    /// Notes what is not known, each once.
    fn doubt(&mut self, because: impl IntoIterator<Item = Remark>) {
        for what in because {
            if !self.unjudged.contains(&what) {
                self.unjudged.push(what);
            }
        }
    }
}
