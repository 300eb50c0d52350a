//! What may be built into one joint, given what it carries: every motor with every gear or number of
//! stages that keeps the joint's own limits, each with its best ratio and the proof of it.

use std::sync::Arc;
use std::sync::atomic::AtomicU64;

use rayon::prelude::*;

use crate::answer::{Design, Reason, Refused};
use crate::best::best_design;
use crate::judge;
use crate::mount::{JointDemand, Mount, Site};
use crate::options::Stop;
use crate::program::{Certificate, NotProved};
use crate::solved::{design, one_gear};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::{Catalog, Gear};
use gearwise_model::requirement::{Joint, Quantity, RatioChoice, Robot};

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
    pub items: Vec<Arc<Item<'a>>>,
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
    let done = AtomicU64::new(0);
    let site = Site::new(robot, carrying, &demand).stopping(stop.adding(&done));
    let pieces = pieces(carrying, needs);
    let of = |site: Site, motor: usize| {
        let (row, mut made) = (&catalog.motors[motor], Made::default());
        match () {
            // What is found is no answer any more.
            () if stop.now() || carrying.motors.pass_over(row) => {}
            () if !site.is_geared_with(row) => {
                pieces.iter().for_each(|piece| made.continuous(site, piece, catalog, motor, needs));
            }
            () if carrying.limits.spring.is_some() => made.sprung(site, catalog, motor, needs),
            () => site.mounts(row).for_each(|mount| made.geared(&mount, catalog, motor, needs)),
        }
        made
    };
    let motors = catalog.motors.len();
    let mut found: Vec<Made> = (0..motors).into_par_iter().map(|motor| of(site, motor)).collect();
    // Motors whose search ended get the work that the others left over.
    let ended: Vec<usize> = (0..motors).filter(|motor| found[*motor].is_ended).collect();
    if let Some(longer) = site.stop.again(motors, ended.len()).filter(|_| !ended.is_empty()) {
        let again: Vec<Made> = ended.par_iter().map(|motor| of(Site { stop: longer, ..site }, *motor)).collect();
        ended.into_iter().zip(again).for_each(|(motor, again)| found[motor] = again);
    }
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

/// One way to build a joint, whatever its load.
#[derive(Debug, Clone, Copy)]
pub(super) struct Build<'a> {
    /// Index of the motor in the catalogue.
    pub motor: usize,
    /// The gear of the catalogue; `None` where the ratio is free, and with a spring, which is chosen for each gear.
    pub gear: Option<&'a Gear>,
    /// Which of the [`pieces`].
    pub piece: usize,
}

/// What comes of one way to build a joint under a load.
pub(super) fn made<'a>(site: Site, catalog: &'a Catalog, needs: Needs, build: Build) -> Made<'a> {
    let mut made = Made::default();
    match build.gear {
        Some(gear) => {
            let mut mounts = site.mounts(&catalog.motors[build.motor]);
            let mount = mounts.find(|mount| mount.gear_id() == Some(gear.id.as_str()));
            mount.into_iter().for_each(|mount| made.geared(&mount, catalog, build.motor, needs));
        }
        None if site.is_geared_with(&catalog.motors[build.motor]) => made.sprung(site, catalog, build.motor, needs),
        None => made.continuous(site, &pieces(site.joint, needs)[build.piece], catalog, build.motor, needs),
    }
    made
}

/// What came of one motor.
#[derive(Default)]
pub(super) struct Made<'a> {
    pub items: Vec<Arc<Item<'a>>>,
    /// What keeps some design of it from being judged.
    pub unjudged: Vec<Remark>,
    pub unproved: bool,
    /// True if a search ended after its share of the work.
    pub is_ended: bool,
}

/// The joint for each number of gear stages, where the mass decides; for each listed ratio, where it may leave its best;
/// else the joint as it is.
pub(super) fn pieces(joint: &Joint, needs: Needs) -> Vec<Joint> {
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

impl<'a> Made<'a> {
    /// A motor with a free ratio of one piece.
    fn continuous(&mut self, site: Site, piece: &Joint, catalog: &'a Catalog, motor: usize, needs: Needs) {
        match best_design(Site { joint: piece, ..site }, &catalog.motors[motor], needs.only_checked) {
            Ok(found) => {
                let window = found.optimum.window().clone();
                let site = Site { joint: piece, ..site };
                let heaviest = || {
                    let candidate = site.direct(&catalog.motors[motor]).candidate().ok()?;
                    candidate.mass_between((window.min, window.max)).map(|(_, most)| most)
                };
                // Nothing moves where the ratio stays; a spring stays with its ratio.
                let mass = if needs.moves { heaviest() } else { found.evaluation.mass };
                let stays = found.spring.is_some() || !needs.moves;
                let ratios =
                    if stays { (found.evaluation.ratio, found.evaluation.ratio) } else { (window.min, window.max) };
                self.unproved |= needs.moves && (found.optimum.windows.len() > 1 || found.spring.is_some());
                self.take(found, catalog, motor, mass, ratios, needs);
            }
            Err(why) => self.refuse(why),
        }
    }

    /// A motor with the best of the gears that it may have, each with a spring of its own: only the best of them is known.
    fn sprung(&mut self, site: Site, catalog: &'a Catalog, motor: usize, needs: Needs) {
        match best_design(site, &catalog.motors[motor], needs.only_checked) {
            Ok(found) => {
                let (mass, ratio) = (found.evaluation.mass, found.evaluation.ratio);
                self.take(found, catalog, motor, mass, (ratio, ratio), needs);
                self.unproved = true;
            }
            // That a gear's spring could not be solved for is told of the design alone.
            Err(Refused::Rejected(_)) => {}
            Err(why) => self.refuse(why),
        }
    }

    /// A motor with one gear of the catalogue.
    fn geared(&mut self, mount: &Mount, catalog: &'a Catalog, motor: usize, needs: Needs) {
        let Some(gear) = mount.gear else { return };
        let prepared = match mount.prepared() {
            Ok(prepared) => prepared,
            Err(why) => {
                self.doubt(why.unknown());
                return;
            }
        };
        let evaluation = prepared.at(gear.ratio);
        let objective = evaluation.objective(&mount.joint.objective).filter(|_| evaluation.feasible);
        let Some(objective) = objective else { return };
        let found = design(mount, &prepared, one_gear(gear.ratio, objective, "all gears evaluated"));
        match judge::judged(mount.robot, mount.joint, found, needs.only_checked) {
            Ok(found) => self.take(found, catalog, motor, evaluation.mass, (gear.ratio, gear.ratio), needs),
            Err(why) => self.refuse(why),
        }
    }

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
            // What is known of the best is a bound, even where the search for it ended; of ratios away from it nothing is known then.
            Certificate::NotCertified(NotProved::Ended { lower_bound: Some(bound), .. }) => {
                self.is_ended = true;
                self.unproved |= needs.moves;
                bound.min(found.optimum.objective)
            }
            Certificate::NotCertified(ref why) => {
                self.is_ended |= matches!(why, NotProved::Ended { .. });
                self.unproved = true;
                found.optimum.objective
            }
        };
        let design = found.of_catalog(catalog);
        self.items.push(Arc::new(Item { motor, design, mass: mass.unwrap_or(0.0), ratios, lower }));
    }

    /// Notes why there is no item.
    fn refuse(&mut self, why: Refused) {
        self.is_ended |= why.is_ended();
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
