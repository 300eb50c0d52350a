//! Designs that keep their limits for every motor within its tolerances.
//!
//! The one idea: the robust program is the nominal objective under the limits of the worst motors within the box of tolerances. Which motors
//! these are is not listed by hand: the equations, in interval arithmetic with derivatives, tell for each limit and each tolerance
//! whether the limit's excess is monotone (then one end is the worst) or convex (then one of both), and what they do not tell is divided
//! further. The best ratio under the first corners is looked at over the whole box; a motor that breaks a limit there joins the
//! corners, and the program is solved again. A limit for which neither a corner nor a bound decides is *not proven*, and its design
//! is not called robust. Efficiency of a gear that the requirement describes, load and bus have no tolerances here.

mod boxed;
mod chance;
mod corners;
mod derivative;
mod equations;
mod proof;

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::answer::{Design, JointResult, Reason, RobotResult};
use super::evaluate::{Evaluation, Margin};
use super::mount::{JointDemand, Site};
use super::optimize::optimize_with;
use super::options::{Options, Stop, Stopped};
use super::program::Optimum;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::Catalog;
use gearwise_model::requirement::Robot;

pub use boxed::best_robust;
pub use chance::{CONTENDERS, Contender, SAMPLES, standard_error};
/// What is taken for ± beside those of the rows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Taken {
    /// The ± of numbers whose rows state none, as a share.
    pub tolerance: Option<f64>,
    /// Whether the ends of what all sources print are.
    pub alternatives: bool,
}

pub use corners::{Corner, Toleranced, assume_tolerance, take_alternatives, toleranced};

/// A design that keeps its limits over the whole box of tolerances.
#[derive(Debug, Clone)]
pub struct RobustDesign<'a> {
    /// The design for the printed numbers.
    pub nominal: Design<'a>,
    /// The numbers that have a tolerance; none: the design is the nominal one.
    pub toleranced: Vec<Toleranced>,
    /// Number of motors of the box that the program was solved for.
    pub corners: usize,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The best ratio that keeps all limits at all corners: least objective for the printed numbers.
    pub optimum: Optimum,
    /// The printed numbers at that ratio.
    pub evaluation: Evaluation,
    /// The largest objective at a corner, at that ratio.
    pub worst_objective: f64,
    /// The smallest margin at a corner, or at another motor that was tried, at that ratio.
    pub tightest: Option<Margin>,
    /// Limits that neither a corner nor a bound proves over the tolerances: the design keeps them at every motor that was tried.
    pub unproven: Vec<&'static str>,
    /// True if the search for it, or its proof, ended after its share of the work.
    pub is_ended: bool,
    /// Limits that could not be checked at that ratio, of the printed numbers or at a corner, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept there, and as far as what holds.
    pub assumed: Vec<Remark>,
}

/// A motor that can do it by its printed numbers, but not over its tolerances.
#[derive(Debug, Clone)]
pub struct Lost<'a> {
    /// The nominal design.
    pub nominal: Design<'a>,
    /// Why no ratio keeps the limits at all corners.
    pub reason: Reason,
}

/// What was found for a joint.
#[derive(Debug)]
pub struct RobustJoint<'a> {
    /// The nominal result.
    pub nominal: JointResult<'a>,
    /// Designs that keep their limits at every motor that was tried: those that are proven first, least nominal objective at their ratio
    /// first.
    pub designs: Vec<RobustDesign<'a>>,
    /// Motors that are lost to their tolerances, in the nominal order.
    pub lost: Vec<Lost<'a>>,
    /// The first motors of the nominal order among each other.
    pub contenders: Vec<Contender<'a>>,
}

/// Robust designs for every joint of a robot.
///
/// # Errors
/// It was stopped.
pub fn robust<'a>(robot: &'a Robot, catalog: &'a Catalog, options: Options) -> Result<Vec<RobustJoint<'a>>, Stopped> {
    let stop = Stop::when(options.stop);
    let RobotResult { joints, .. } = optimize_with(robot, catalog, options)?;
    let solve = |nominal: JointResult<'a>| {
        let joint = nominal.joint;
        let demand = JointDemand::new(joint, catalog);
        let site = Site::new(robot, joint, &demand);
        let found = found(site, &nominal.candidates, stop, options.only_checked)?;
        let (mut designs, mut lost) = (Vec::new(), Vec::new());
        for (design, result) in nominal.candidates.iter().zip(found) {
            match result {
                Ok(design) => designs.push(design),
                Err(reason) => lost.push(Lost { nominal: design.clone(), reason }),
            }
        }
        designs.sort_by(|a: &RobustDesign, b| {
            a.unproven
                .is_empty()
                .cmp(&b.unproven.is_empty())
                .reverse()
                .then(a.optimum.objective.total_cmp(&b.optimum.objective))
                .then(a.evaluation.loss.total_cmp(&b.evaluation.loss))
                .then(a.nominal.motor.id.cmp(&b.nominal.motor.id))
        });
        let contenders = chance::contenders(site, &nominal.candidates, &designs, options.only_checked);
        stop.unless(RobustJoint { nominal, designs, lost, contenders })
    };
    joints.into_iter().map(solve).collect()
}

/// Steps of [`work`](gearwise_model::numerics::work) for the proofs of a robot: about 40 s of one core.
const PROOF_STEPS: u64 = 4_500_000_000;

/// Number of designs that share the remaining steps equally. Designs come least nominal objective first, which bounds the objective over
/// the tolerances from below, so that those that may be the first choice are proven first.
const BATCH: usize = 16;

/// The design over its tolerances for each nominal design, in their order.
fn found<'a>(
    site: Site<'a, '_>,
    nominal: &[Design<'a>],
    stop: Stop,
    only_checked: bool,
) -> Result<Vec<Result<RobustDesign<'a>, Reason>>, Stopped> {
    let all = PROOF_STEPS / site.robot.joints.len() as u64;
    let done = AtomicU64::new(0);
    let best = |design: &Design<'a>, steps: u64| {
        let stop = stop.adding(&done).with_steps(steps);
        let (mut found, is_ended) = stop.within_share(|| best_robust(Site { stop, ..site }, design, only_checked));
        if let Ok(found) = &mut found {
            found.is_ended = is_ended;
        }
        stop.unless((found, is_ended))
    };
    let left = || all.saturating_sub(done.load(Ordering::Relaxed));
    let mut found = Vec::with_capacity(nominal.len());
    for batch in nominal.chunks(BATCH) {
        let steps = left() / batch.len() as u64;
        found.extend(batch.par_iter().map(|design| best(design, steps)).collect::<Result<Vec<_>, _>>()?);
    }
    // Designs whose search ended get the steps that the others left over, where these are more than their first share.
    let ended: Vec<usize> = (0..nominal.len()).filter(|k| found[*k].1).collect();
    let steps = left() / ended.len().max(1) as u64;
    if !ended.is_empty() && steps > all / BATCH as u64 {
        let again = ended.par_iter().map(|k| best(&nominal[*k], steps)).collect::<Result<Vec<_>, _>>()?;
        ended.into_iter().zip(again).for_each(|(k, again)| found[k] = again);
    }
    Ok(found.into_iter().map(|(found, _)| found).collect())
}
