//! The number of turns as a variable: the best ratio and winding of a motor together, with a bound over both.
//!
//! The one idea: between `a1` and `a2` times the turns no winding asks for less voltage than `a1`, nor for less current of the
//! drive than `a2`, and nothing else depends on the turns (see [`super::turns`]). So the program of the winding `a1` with
//! `a2/a1` times the drive's current bounds all of them from below. Where some winding does at its best ratio, that is the
//! best of the interval; else the interval is halved, and the bound of what is left is that of the whole.

use std::borrow::Cow;

use rayon::prelude::*;

use super::answer::{Design, Reason, Refused, Unjudged};
use super::best::best_design;
use super::mount::{JointDemand, Mount, Site};
use super::program::{Certificate, GAP_TOLERANCE};
use super::turns::{Found, TurnsRange, at_best, can_be_asked, obstacles, search};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::rewound::NoTurns;
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::requirement::{Filter, Joint, Quantity, Robot, Turns, Windings};

/// Most intervals of turns that are looked at.
const MOST: usize = 400;
/// An interval of turns narrower than this (relative) is not halved.
const NARROWEST: f64 = 1e-12;
/// What a range of turns at a ratio is wide at least (relative), so that the winding in it does without rounding.
const ROOM: f64 = 1e-7;
/// How a proof over ratios and turns is called.
const METHOD: &str = "over ratio and turns";

/// The best ratio and number of turns of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Best {
    /// The ratio.
    pub ratio: f64,
    /// Turns as a multiple of the motor's.
    pub turns: f64,
    /// The objective there.
    pub objective: f64,
    /// No ratio with any number of turns in the range is better than this; `None` where that is not proved.
    pub lower_bound: Option<f64>,
}

/// The best of a motor over all ratios and all numbers of turns in a range of multiples of its own; `None` where none was found.
pub fn best(site: Site, motor: &Motor, range: (f64, f64), only_checked: bool) -> Option<Best> {
    let motor = Motor { wound: None, ..motor.clone() };
    let joint = Joint { motors: Filter::default(), turns: Turns::AsWound, ..site.joint.clone() };
    let any = Joint { turns: Turns::Any, ..joint.clone() };
    let (site, open) = (Site { joint: &joint, ..site }, Site { joint: &any, ..site });
    let relaxed = best_design(open, &motor, only_checked).ok()?;
    let allowed = |turns: TurnsRange| Some(turns.between(range)).filter(has_room);
    let first = at_best(site, &motor, &relaxed).and_then(|at| Some((allowed(at.turns)?, at)));
    if let Some((turns, at)) = first {
        return Some(Best::of(&at, turns, lower_bound(&relaxed)));
    }
    if joint.limits.spring.is_some() {
        return None;
    }
    let found = search(site, open, &motor, &relaxed, allowed);
    if site.is_geared_with(&motor) || joint.ratio.listed().is_some() {
        // All of them were looked at.
        return found.map(|at| Best::of(&at, at.turns, Some(at.objective)));
    }
    let mut best = found.map(|at| better_ratio(site, &motor, Best::of(&at, at.turns, None), only_checked));
    let lower_bound = bound(site, &motor, range, only_checked, &mut best);
    best.map(|best| Best { lower_bound: lower_bound.map(|bound| bound.min(best.objective)), ..best })
}

impl Best {
    fn of(at: &Found, turns: TurnsRange, lower_bound: Option<f64>) -> Best {
        Best { ratio: at.ratio, turns: chosen(turns), objective: at.objective, lower_bound }
    }
}

/// The best ratio with a number of turns that was found, where that is better.
fn better_ratio(site: Site, motor: &Motor, found: Best, only_checked: bool) -> Best {
    let wound = motor.with_times_turns(found.turns);
    match best_design(site, &wound, only_checked) {
        Ok(design) if design.optimum.objective < found.objective => {
            Best { ratio: design.evaluation.ratio, objective: design.optimum.objective, ..found }
        }
        _ => found,
    }
}

/// Whether a range is wider than rounding.
fn has_room(turns: &TurnsRange) -> bool {
    turns.min * (1.0 + ROOM) <= turns.max || (turns.min == turns.max && turns.min > 0.0)
}

/// The number of turns that is taken of several that do: the motor's own where that is one of them, else the middle, with as
/// few digits as stay inside.
fn chosen(TurnsRange { min, max, .. }: TurnsRange) -> f64 {
    if min <= 1.0 && 1.0 <= max {
        return 1.0;
    }
    let middle = (min * max).sqrt();
    let rounded = (1..16).filter_map(|digits| format!("{middle:.digits$e}").parse::<f64>().ok());
    rounded.into_iter().find(|turns| min <= *turns && *turns <= max).unwrap_or(middle)
}

/// The lower bound that a design proves.
fn lower_bound(design: &Design) -> Option<f64> {
    match design.optimum.certificate {
        Certificate::Certified { lower_bound, .. } => Some(lower_bound),
        Certificate::NotCertified(_) => None,
    }
}

/// An interval of turns with the bound of its objective and where it is to be divided.
#[derive(Debug, Clone, Copy)]
struct Interval {
    ends: (f64, f64),
    bound: f64,
    split: f64,
}

/// A lower bound of the objective over all ratios and turns of a range, and the best that was met on the way; `None` where there
/// is none.
fn bound(site: Site, motor: &Motor, range: (f64, f64), only_checked: bool, best: &mut Option<Best>) -> Option<f64> {
    let target =
        |best: &Option<Best>| best.map_or(f64::INFINITY, |b| b.objective - 0.25 * GAP_TOLERANCE * b.objective.abs());
    let mut open = vec![look(site, motor, range, only_checked, best).ok()?];
    // The least bound of what is not divided further.
    let mut settled = f64::INFINITY;
    for _ in 0..MOST {
        let least = (0..open.len()).min_by(|a, b| open[*a].bound.total_cmp(&open[*b].bound));
        let Some(Interval { ends, bound, split }) = least.map(|k| open.swap_remove(k)) else { return Some(settled) };
        if bound >= target(best) {
            return Some(settled.min(bound));
        }
        if ends.1 <= ends.0 * (1.0 + NARROWEST) {
            settled = settled.min(bound);
            continue;
        }
        for half in [(ends.0, split), (split, ends.1)] {
            let part = look(site, motor, half, only_checked, best).ok()?;
            // What holds of the whole holds of its parts.
            open.push(Interval { bound: part.bound.max(bound), ..part });
        }
    }
    open.iter().map(|part| part.bound).reduce(f64::min).map(|left| left.min(settled))
}

/// Nothing is known of an interval.
struct Unknown;

/// Bounds an interval; where one of its windings does at the ratio of the bound, that is offered as the best.
fn look(
    site: Site,
    motor: &Motor,
    (fewest, most): (f64, f64),
    only_checked: bool,
    best: &mut Option<Best>,
) -> Result<Interval, Unknown> {
    let ends = (fewest, most);
    let joint = Joint { turns: Turns::UpTo(most / fewest), ..site.joint.clone() };
    let wound = motor.with_times_turns(fewest);
    let middle = (fewest * most).sqrt();
    let design = match best_design(Site { joint: &joint, ..site }, &wound, only_checked) {
        Ok(design) => design,
        Err(Refused::Rejected(why)) if matches!(why.reason, Reason::Infeasible(_)) => {
            return Ok(Interval { ends, bound: f64::INFINITY, split: middle });
        }
        Err(_) => return Err(Unknown),
    };
    let bound = lower_bound(&design).ok_or(Unknown)?;
    let mount = Mount::new(site.robot, site.joint, &site.demand.load, motor);
    let prepared = mount.prepared().map_err(|_| Unknown)?;
    let (ratio, objective) = (design.evaluation.ratio, design.optimum.objective);
    let at = TurnsRange::at(&prepared, ratio);
    let within = at.between(ends);
    if has_room(&within) && best.is_none_or(|best| objective < best.objective) {
        *best = Some(Best { ratio, turns: chosen(within), objective, lower_bound: None });
    }
    // Between what voltage and current ask there, which none of its windings gives.
    let crossing = (at.min.max(fewest) * at.max.min(most)).sqrt();
    let inner = (fewest.powf(0.95) * most.powf(0.05), fewest.powf(0.05) * most.powf(0.95));
    let split = if inner.0 < crossing && crossing < inner.1 { crossing } else { middle };
    Ok(Interval { ends, bound, split })
}

/// [`best_design`], with what is proved over all turns where the joint has a range of them.
///
/// # Errors
/// As of that.
pub(super) fn best_wound<'a>(
    site: Site<'a, '_>,
    motor: &'a Motor,
    only_checked: bool,
) -> Result<Design<'a>, Refused<'a>> {
    match best_design(site, motor, only_checked) {
        Ok(design) => Ok(over_all(site, design, only_checked)),
        Err(Refused::Rejected(why)) => Err(match doubt_with_any_turns(site, motor, only_checked) {
            Some(because) => Refused::Unjudged(Box::new(Unjudged { motor, gear: None, because, design: None })),
            None => Refused::Rejected(why),
        }),
        Err(why) => Err(why),
    }
}

/// What cannot be judged of a motor that a joint rejects as it is wound, where it may have any winding of a range and would do with some.
fn doubt_with_any_turns(site: Site, motor: &Motor, only_checked: bool) -> Option<Vec<Remark>> {
    site.joint.motors.turns.range().filter(|_| site.joint.motors.allows(motor))?;
    if !matches!(can_be_asked(site.robot, site.joint, motor), Ok(()) | Err(NoTurns::Wound)) {
        return None;
    }
    let motor = Motor { wound: None, ..motor.clone() };
    let joint = Joint { motors: Filter::default(), turns: Turns::Any, ..site.joint.clone() };
    match best_design(Site { joint: &joint, ..site }, &motor, only_checked) {
        Err(Refused::Unjudged(apart)) => Some(apart.because),
        _ => None,
    }
}

/// A design of a motor with a range of turns, with what is proved over all of the range.
fn over_all<'a>(site: Site<'a, '_>, design: Design<'a>, only_checked: bool) -> Design<'a> {
    let Some((min, max)) = site.joint.motors.turns.range() else { return design };
    let motor = design.motor;
    let alone = !matches!(can_be_asked(site.robot, site.joint, motor), Ok(()) | Err(NoTurns::Wound));
    if alone {
        return design;
    }
    let own = motor.turns();
    let found = best(site, motor, (min / own, max / own), only_checked);
    let objective = design.optimum.objective;
    let certificate = match found.and_then(|best| best.lower_bound) {
        Some(bound) if objective - bound <= GAP_TOLERANCE * objective.abs() => {
            let lower_bound = bound.min(objective);
            let gap = if objective == lower_bound { 0.0 } else { (objective - lower_bound) / objective.abs() };
            Certificate::Certified { lower_bound, gap, method: METHOD }
        }
        _ => Certificate::NotCertified("another number of turns may be better".into()),
    };
    let optimum = super::program::Optimum { certificate, ..design.optimum };
    Design { optimum, ..design }
}

/// Makes the windings that joints with a range of turns are best with part of a catalogue, and lets those joints choose no others of
/// their rows. Where no joint has a range, all stays as it is.
///
/// # Errors
/// What a range of turns does not go with, in words.
pub fn wind<'c>(robot: &mut Robot, catalog: &'c Catalog, only_checked: bool) -> Result<Cow<'c, Catalog>, String> {
    if !robot.has_range_of_turns() {
        return Ok(Cow::Borrowed(catalog));
    }
    let found = found(robot, catalog, only_checked)?;
    let of_row = |motor: &Motor| {
        let windings = found.iter().flatten().filter(|(row, _)| *row == motor.id);
        let mut turns: Vec<f64> = windings.map(|(_, turns)| *turns).collect();
        turns.sort_by(f64::total_cmp);
        turns
    };
    let wound = catalog.clone().with_windings(of_row);
    for (joint, of_joint) in robot.joints.iter_mut().zip(found) {
        if let Windings::Between { found, .. } = &mut joint.motors.turns {
            *found = of_joint;
        }
    }
    Ok(Cow::Owned(wound))
}

/// For each joint the rows of a catalogue with the turns that are best there, where it has a range of them.
fn found(robot: &Robot, catalog: &Catalog, only_checked: bool) -> Result<Vec<Vec<(String, f64)>>, String> {
    let mut all: Vec<Vec<(String, f64)>> = Vec::new();
    for (k, joint) in robot.joints.iter().enumerate() {
        if let Some(same) = robot.joints[..k].iter().position(|other| other.asks_the_same(joint)) {
            all.push(all[same].clone());
            continue;
        }
        let Some(range) = joint.motors.turns.range() else {
            all.push(Vec::new());
            continue;
        };
        goes_with(robot, joint)?;
        let demand = JointDemand::new(joint, catalog);
        let site = Site::new(robot, joint, &demand);
        let patterns = Filter { turns: Windings::AsWound, ..joint.motors.clone() };
        let rows = catalog.motors.par_iter().filter(|motor| patterns.allows(motor) && motor.can_be_rewound().is_ok());
        let wound = rows.map(|motor| {
            let turns =
                best(site, motor, range, only_checked).map_or(1.0_f64.clamp(range.0, range.1), |best| best.turns);
            (motor.id.clone(), turns)
        });
        all.push(wound.collect());
    }
    Ok(all)
}

/// Whether a range of turns goes with what else is asked at a joint.
fn goes_with(robot: &Robot, joint: &Joint) -> Result<(), String> {
    let mut all: Vec<&str> = obstacles(robot, joint).into_iter().filter_map(NoTurns::goes_without).collect();
    // A resistance of the supply binds them, too.
    if all.is_empty() && robot.is_coupled() {
        all.push("what binds joints together");
    }
    if joint.objective.weight(Quantity::PeakCurrent) > 0.0 {
        all.push("an objective that counts a current");
    }
    if all.is_empty() {
        return Ok(());
    }
    let what = all.join(", nor with ");
    let name = &joint.name;
    Err(format!("joint `{name}`: a range of `turns` is not combined with {what}; give a list, as in turns = [1, 0.5]"))
}
