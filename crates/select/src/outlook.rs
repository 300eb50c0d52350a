//! What an engineer asks next of a joint's first choice: how near to its ratio a gear has to be, which gears there are, what
//! a little more mass or loss would buy, and whether the requirement's own numbers decided.
//!
//! The one idea: none of this decides the choice; it is found after it, for the first design alone.

use rayon::prelude::*;

use super::answer::{Design, JointResult, RobotResult};
use super::best::best_design;
use super::break_even::{BreakEven, OpenOrder, break_even, open_order};
use super::flatness::{Flatness, OwnBound, at_design, flatness, own_bound};
use super::mount::{JointDemand, Site};
use super::nearby::{Nearby, nearby};
use super::optimize::optimize_with;
use super::options::{Options, Stopped};
use super::turns::{Rewinding, first_rewound, rewindings};
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::requirement::{Balancing, Joint, Objective, Quantity, Robot};

/// What is said of the first choice of a joint beside the choice itself.
#[derive(Debug, Clone, Default)]
pub struct Outlook<'a> {
    /// Ratios that are nearly as good.
    pub flatness: Option<Flatness>,
    /// The requirement's own range of ratios decided.
    pub own_bound: Option<OwnBound>,
    /// What can be built near the best ratio.
    pub nearby: Option<Nearby<'a>>,
    /// Designs between the lightest and the least loss, by mass; empty unless it was asked for and the objective is balanced.
    pub front: Vec<FrontDesign<'a>>,
    /// What another number of turns would do for the motors that cannot do it, in their order.
    pub rewindings: Vec<(&'a Motor, Rewinding<'a>)>,
    /// Up to what drag motors lead whose drag nobody says, or is estimated: the first choice the next one, the others the
    /// first choice.
    pub break_evens: Vec<(&'a Motor, BreakEven)>,
    /// What share of a no-load torque the order of the first choice and the next depends on.
    pub open_order: Option<OpenOrder>,
    /// What another number of turns would do for the first choice, where voltage or the drive's current holds its ratio back.
    pub rewound: Option<Rewinding<'a>>,
}

impl<'a> Outlook<'a> {
    /// Up to what drag a motor leads; `None` where that is known or was not asked.
    pub fn break_even(&self, motor: &Motor) -> Option<&BreakEven> {
        self.break_evens.iter().find(|(of, _)| of.id == motor.id).map(|(_, found)| found)
    }

    /// What another number of turns would do for a motor that cannot do it; `None` where it was not asked.
    pub fn rewinding(&self, motor: &Motor) -> Option<&Rewinding<'a>> {
        self.rewindings.iter().find(|(of, _)| of.id == motor.id).map(|(_, how)| how)
    }
}

/// Up to what drag motors of a joint lead of which it is not known.
fn break_evens<'a>(site: Site<'a, '_>, of: &JointResult<'a>) -> Vec<(&'a Motor, BreakEven)> {
    let Some(first) = of.candidates.first() else { return Vec::new() };
    let next = of.candidates.get(1).map(|next| (first.motor, next));
    let apart = of.unjudged.iter().map(|apart| (apart.motor, first));
    let all = next.into_iter().chain(apart);
    let ahead = |(motor, other): (&'a Motor, &Design<'a>)| {
        let found = break_even(site, motor, other.motor, other.optimum.objective)?;
        Some((motor, found))
    };
    all.filter_map(ahead).collect()
}

/// A design that is the best for a weight between mass and loss.
#[derive(Debug, Clone)]
pub struct FrontDesign<'a> {
    /// The share of the loss in the weighted sum: 0 is the lightest, 0.5 balanced, 1 the least loss.
    pub share: f64,
    /// The design; objective and proof are those of its own weighted sum.
    pub design: Design<'a>,
}

/// Shares of the loss between the ends.
const SHARES: [f64; 4] = [0.1, 0.25, 0.75, 0.9];

/// The outlook of every joint of a result, in its order; of a joint without a choice that of its motors' windings alone.
///
/// # Errors
/// It was stopped.
pub fn outlooks<'a>(
    result: &RobotResult<'a>,
    catalog: &'a Catalog,
    with_front: bool,
    options: Options,
) -> Result<Vec<Outlook<'a>>, Stopped> {
    let robot = result.robot;
    let one = |(place, of): (usize, &JointResult<'a>)| {
        let joint = of.joint;
        let demand = JointDemand::new(joint, catalog);
        let site = Site::new(robot, joint, &demand);
        let rewindings = rewindings(site, of, catalog, options.only_checked);
        let rewound = first_rewound(site, of, catalog, options.only_checked);
        let Some(design) = of.candidates.first() else {
            return Ok((place, Outlook { rewindings, ..Outlook::default() }));
        };
        let optimum = &design.optimum;
        let seen = at_design(robot, joint, design, |prepared| {
            (flatness(prepared, joint, optimum), own_bound(prepared, joint, optimum))
        });
        let (flatness, own_bound) = seen.unwrap_or_default();
        let front = if with_front { front(robot, of, catalog, options)? } else { Vec::new() };
        let break_evens = break_evens(site, of);
        let next = of.candidates.get(1);
        let open_order = next.and_then(|next| open_order(site, design.motor, next.motor, design.optimum.objective));
        let nearby = nearby(robot, joint, catalog, design);
        Ok((place, Outlook { flatness, own_bound, nearby, front, rewindings, rewound, break_evens, open_order }))
    };
    // Joints that ask the same have the same answer: it is found once.
    let alike = |j: usize| (0..j).find(|i| robot.joints[*i].asks_the_same(&robot.joints[j]));
    let first: Vec<usize> = (0..result.joints.len()).map(|j| alike(j).unwrap_or(j)).collect();
    let distinct: Vec<_> = result.joints.iter().enumerate().filter(|(j, _)| first[*j] == *j).collect();
    let found: Vec<(usize, Outlook)> = distinct.into_par_iter().map(one).collect::<Result<_, Stopped>>()?;
    let of = |j: &usize| found.iter().find(|(place, _)| place == j).map(|(_, outlook)| outlook.clone());
    Ok(first.iter().map(|j| of(j).unwrap_or_default()).collect())
}

/// Designs between the lightest and that with the least loss, each the best of all motors for its weights.
fn front<'a>(
    robot: &Robot,
    of: &JointResult<'a>,
    catalog: &'a Catalog,
    options: Options,
) -> Result<Vec<FrontDesign<'a>>, Stopped> {
    let Balancing::Made(balance) = &of.joint.balancing else { return Ok(Vec::new()) };
    let Some(balanced) = of.candidates.first() else { return Ok(Vec::new()) };
    let alone = |objective: Objective| Joint { objective, carries: Vec::new(), phases: Vec::new(), ..of.joint.clone() };
    let options = Options { reasons: false, keep: Some(1), tick: &|| {}, ..options };
    let mut found = vec![FrontDesign { share: 0.5, design: balanced.clone() }];
    // The ends are known: their motors are solved again, for the proof.
    for (share, quantity, end) in [(0.0, Quantity::Mass, &balance.lightest), (1.0, Quantity::Loss, &balance.least_loss)]
    {
        let joint = alone(Objective::single(quantity));
        let demand = JointDemand::new(&joint, catalog);
        let site = Site::new(robot, &joint, &demand);
        let solved = catalog.motors.iter().find(|motor| motor.id == end.motor).and_then(|motor| {
            let design = best_design(site, motor, options.only_checked).ok()?;
            Some(design.of_catalog(catalog))
        });
        found.extend(solved.map(|design| FrontDesign { share, design }));
    }
    for share in SHARES {
        let (loss, mass) = (2.0 * share / balance.loss, 2.0 * (1.0 - share) / balance.mass);
        let joint = alone(Objective { terms: vec![(Quantity::Loss, loss), (Quantity::Mass, mass)] });
        let robot = Robot { joints: vec![joint], ..robot.clone() };
        let result = optimize_with(&robot, catalog, options)?;
        let first = result.joints.into_iter().next().and_then(|joint| joint.candidates.into_iter().next());
        found.extend(first.map(|design| FrontDesign { share, design: design.of_catalog(catalog) }));
    }
    found.sort_by(|a, b| a.share.total_cmp(&b.share));
    let same = |a: &Design, b: &Design| {
        let (a_at, b_at) = (a.evaluation.ratio, b.evaluation.ratio);
        a.motor.id == b.motor.id && a.gear == b.gear && (a_at - b_at).abs() <= 1e-6 * a_at
    };
    // The three choices stay, also where they are one design; between them each design once.
    let is_named = |share: f64| matches!(share, 0.0 | 0.5 | 1.0);
    let named: Vec<Design> = found.iter().filter(|f| is_named(f.share)).map(|f| f.design.clone()).collect();
    found.retain(|f| is_named(f.share) || !named.iter().any(|design| same(design, &f.design)));
    found.dedup_by(|next, before| !is_named(next.share) && same(&next.design, &before.design));
    Ok(found)
}
