//! Every motor at every ratio: feasible, or why not.

use rayon::prelude::*;

use super::Prepared;
use super::answer::{JointSweep, SweptDesign, Unusable};
use super::evaluate::Judged;
use super::judge::unjudged;
use super::mount::{JointDemand, Mount, Site};
use super::options::{Options, Stop, Stopped};
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Robot};

/// Evaluates every motor at every ratio of a grid (`ratios` of them), or at those that the requirement lists, or with every gear of the
/// catalogue that the joint allows and that fits.
pub fn sweep<'a>(robot: &'a Robot, catalog: &'a Catalog, ratios: usize) -> Vec<JointSweep<'a>> {
    sweep_with(robot, catalog, ratios, Options::default()).expect("nobody stops it")
}

/// As [`sweep`], with options: of these what is called for each motor, and what stops it.
///
/// # Errors
/// It was stopped.
pub fn sweep_with<'a>(
    robot: &'a Robot,
    catalog: &'a Catalog,
    ratios: usize,
    options: Options,
) -> Result<Vec<JointSweep<'a>>, Stopped> {
    let stop = Stop::when(options.stop);
    let demands: Vec<JointDemand> = robot.joints.par_iter().map(|j| JointDemand::new(j, catalog)).collect();
    robot
        .joints
        .iter()
        .zip(&demands)
        .map(|(joint, demand)| {
            let one = |motor| {
                let swept = sweep_motor(Site::new(robot, joint, demand), motor, ratios);
                (options.tick)();
                stop.unless(swept)
            };
            let own = |motor: &&Motor| !joint.motors.pass_over(motor);
            let per_motor: Vec<_> = catalog.motors.par_iter().filter(own).map(one).collect::<Result<_, _>>()?;
            let mut result = JointSweep { joint, designs: Vec::new(), unusable: Vec::new() };
            for (designs, unusable) in per_motor {
                result.designs.extend(designs);
                result.unusable.extend(unusable);
            }
            Ok(result)
        })
        .collect()
}

fn swept<'a>(mount: &Mount<'a, '_>, prepared: &Prepared, ratio: f64) -> SweptDesign<'a> {
    let evaluation = prepared.at(ratio);
    // Of a design that exceeds a limit it does not matter what else could not be judged at its ratio.
    let Judged { unchecked, assumed } =
        if evaluation.feasible { prepared.judged(ratio) } else { prepared.judged_anywhere() };
    let unjudged = unjudged(mount.robot, mount.joint, &unchecked).into();
    SweptDesign {
        motor: mount.motor,
        gear: mount.gear_id(),
        evaluation,
        unchecked: unchecked.into(),
        unjudged,
        assumed: assumed.into(),
    }
}

/// A grid over the ratios of a joint, with the points of its gear family where it has one.
fn over(joint: &Joint, (min, max): (f64, f64), ratios: usize) -> Vec<f64> {
    let points = joint.family_map().into_iter().flat_map(|map| map.points());
    let mut all = grid(min, max, ratios);
    all.extend(points.map(|point| point.ratio).filter(|n| min < *n && *n < max));
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// A motor, with a gear where it has one, that is no candidate.
type NoCandidate<'a> = (&'a Motor, Option<&'a str>, Unusable);

fn sweep_motor<'a>(
    site: Site<'a, '_>,
    motor: &'a Motor,
    ratios: usize,
) -> (Vec<SweptDesign<'a>>, Vec<NoCandidate<'a>>) {
    let (mut designs, mut unusable) = (Vec::new(), Vec::new());
    for mount in site.mounts(motor) {
        match mount.prepared() {
            Ok(prepared) => {
                let at = match (mount.gear, mount.joint.ratio.listed()) {
                    (Some(gear), _) => vec![gear.ratio],
                    (None, Some(values)) => values.to_vec(),
                    (None, None) => mount.range().map_or_else(Vec::new, |range| over(mount.joint, range, ratios)),
                };
                designs.extend(at.into_iter().map(|ratio| swept(&mount, &prepared, ratio)));
            }
            Err(why) => unusable.push((motor, mount.gear_id(), why)),
        }
    }
    if designs.is_empty() && unusable.is_empty() && site.is_geared() {
        let is_allowed = site.joint.motors.allows(motor);
        unusable.push((motor, None, if is_allowed { Unusable::NoGearFits } else { Unusable::NotAllowed }));
    }
    (designs, unusable)
}
