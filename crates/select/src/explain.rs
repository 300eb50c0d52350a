//! The whole story of one motor at one joint: the design that was asked for, the best one, what the
//! best one is sensitive to, and what would have to change where none is feasible.

use super::answer::{Reason, SpringChoice};
use super::evaluate::Judged;
use super::judge::{judged_part, unjudged};
use super::mount::{Mount, load_through};
use super::program::{Infeasible, Optimum, RatioProgram};
use super::solved::solve;
use super::spring::{choose, nearest};
use super::turns::{TurnsRange, can_be_asked};
use super::{Evaluation, Prepared, Unusable};
use gearwise_model::actuator::limits::{Asked, Candidate, Remark};
use gearwise_model::actuator::shaft::End;
use gearwise_model::actuator::thermal::Winding;
use gearwise_model::catalog::{Gear, Motor};
use gearwise_model::numerics::grid::grid;
use gearwise_model::numerics::line_search::{FULLY, golden_section};
use gearwise_model::requirement::{Joint, RatioChoice, Robot};

/// Everything about a motor at a joint.
#[derive(Debug)]
pub struct Explanation<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// The motor.
    pub motor: &'a Motor,
    /// The gear, where it is one of the catalogue.
    pub gear: Option<&'a Gear>,
    /// The design at the ratio that was asked for.
    pub evaluation: Evaluation,
    /// Winding temperature there.
    pub winding_temperature: Winding,
    /// Longest time that the current needs for its jumps at a reversal \[s\].
    pub reversal_time: Option<f64>,
    /// The best ratio, or why there is none; `None` where the gear fixes the ratio.
    pub best: Option<Result<Optimum, Reason>>,
    /// By how much the objective changes with a parameter of the motor.
    pub sensitivities: Vec<Sensitivity>,
    /// Single changes that would make the motor feasible.
    pub remedies: Vec<Remedy>,
    /// The numbers of turns with which voltage and the drive's current are kept there; `None` where it has no other number.
    pub turns: Option<TurnsRange>,
    /// Limits that could not be checked, and why.
    pub unchecked: Vec<Remark>,
    /// Of those, what the requirement itself states: with any of them the design is no choice.
    pub unjudged: Vec<Remark>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Remark>,
    /// The spring, where the joint asks for one: all else is with this spring. Or why no spring will do: all
    /// else is without one.
    pub spring: Option<Result<SpringChoice, Reason>>,
    /// Where no spring will do and one has to be there: stiffness \[N·m/rad\] and rest angle \[rad\] of the allowed spring
    /// that came nearest. All else is with it.
    pub nearest_spring: Option<(f64, f64)>,
}

/// Why a ratio or gear is not allowed, whatever the limits say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Forbidden {
    /// The requirement allows the ratios from one to another.
    Ratio(f64, f64),
    /// The requirement lists the ratios that it allows, and this is none of them.
    NotListed,
    /// It is none of the gears that the requirement names.
    Gear,
    /// The gear is not made for the motor.
    DoesNotFit,
}

/// Relative change of the best objective with a relative change of a parameter, the ratio re-chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// The parameter.
    pub parameter: &'static str,
    /// By how much it was changed (relative).
    pub change: f64,
    /// By how much the objective changed (relative); `None` where no ratio is feasible any more.
    pub objective: Option<f64>,
}

/// One limit that, widened alone, would make the motor feasible.
#[derive(Debug, Clone, PartialEq)]
pub struct Remedy {
    /// The limit.
    pub limit: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is now.
    pub bound: f64,
    /// What it would have to be.
    pub needed: f64,
    /// The ratio at which that is enough.
    pub ratio: f64,
    /// Whose limit it is.
    pub owner: &'static str,
    /// Whether a part of the actuator is not known that counts for it: then more may be needed.
    pub at_least: bool,
}

impl Explanation<'_> {
    /// Whether the design keeps every limit, every limit that the requirement states could be judged, and nothing
    /// forbids its ratio or gear.
    pub fn is_choice(&self) -> bool {
        self.evaluation.feasible && self.unjudged.is_empty() && self.forbidden().is_none()
    }

    /// Why the design's ratio or gear is not allowed, where it is not.
    pub fn forbidden(&self) -> Option<Forbidden> {
        let ratio = self.evaluation.ratio;
        match (&self.joint.ratio, self.gear) {
            // A module is allowed as a whole, or it is no candidate.
            _ if self.motor.inside.is_some() => None,
            (_, Some(gear)) if gear.fits(self.motor.machine_id()) == Some(false) => Some(Forbidden::DoesNotFit),
            (_, Some(gear)) if self.joint.family_map().is_some_and(|map| map.family() != gear.family) => {
                Some(Forbidden::Gear)
            }
            (RatioChoice::Catalog { patterns, from, .. }, Some(gear)) => {
                (!from.has(patterns, gear)).then_some(Forbidden::Gear)
            }
            (RatioChoice::Continuous { min, max }, None) => {
                (!self.joint.ratio.allows(ratio)).then_some(Forbidden::Ratio(*min, *max))
            }
            (RatioChoice::Listed { .. }, None) => (!self.joint.ratio.allows(ratio)).then_some(Forbidden::NotListed),
            _ => None,
        }
    }
}

/// Explains a motor at a ratio, or with a gear of the catalogue, at a joint. Without a ratio it is the
/// best one, or where none is feasible the one that comes nearest.
///
/// # Errors
/// Why the motor is no candidate.
pub fn explain<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    motor: &'a Motor,
    gear: Option<&'a Gear>,
    ratio: Option<f64>,
) -> Result<Explanation<'a>, Unusable> {
    if joint.limits.spring.is_none() {
        return explain_as_it_is(robot, joint, motor, gear, ratio);
    }
    let load = load_through(joint, gear);
    let mount = Mount::new(robot, joint, &load, motor).with_gear(gear);
    let range = match ratio.or(gear.map(|g| g.ratio)) {
        Some(ratio) => (ratio, ratio),
        None => joint.ratio.range().unwrap_or((1.0, 1.0)),
    };
    let prepared = mount.prepared()?;
    let chosen = choose(&mount, &prepared, range);
    // Without any spring all else would be about a joint that nobody asks for, where there has to be one.
    let nearest_spring = match &chosen {
        Err(_) if joint.limits.spring.is_some_and(|s| s.stiffness[0] > 0.0) => nearest(&mount, &prepared, range),
        _ => None,
    };
    let found = chosen.as_ref().ok().map(|(spring, _)| (spring.stiffness, spring.rest_angle.unwrap_or(0.0)));
    let moved = found.or(nearest_spring).and_then(|(stiffness, rest)| joint.with_spring(stiffness, rest));
    let story = explain_as_it_is(robot, moved.as_ref().unwrap_or(joint), motor, gear, ratio)?;
    let Explanation {
        evaluation,
        winding_temperature,
        turns,
        reversal_time,
        mut best,
        sensitivities,
        remedies,
        unchecked,
        assumed,
        ..
    } = story;
    let unjudged = unjudged(robot, joint, &unchecked);
    // The proof of ratio and spring together stands in place of that of the ratio alone.
    if let (Ok((_, optimum)), Some(Ok(best)), None) = (&chosen, &mut best, ratio) {
        *best = optimum.clone();
    }
    let spring = Some(chosen.map(|(spring, _)| spring));
    Ok(Explanation {
        joint,
        motor,
        gear,
        evaluation,
        winding_temperature,
        turns,
        reversal_time,
        best,
        sensitivities,
        remedies,
        unchecked,
        unjudged,
        assumed,
        spring,
        nearest_spring,
    })
}

/// The explanation with the motion as it is.
fn explain_as_it_is<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    motor: &'a Motor,
    gear: Option<&'a Gear>,
    ratio: Option<f64>,
) -> Result<Explanation<'a>, Unusable> {
    let load = load_through(joint, gear);
    let mount = Mount::new(robot, joint, &load, motor).with_gear(gear);
    let prepared = mount.prepared()?;
    if ratio.is_some_and(|ratio| !prepared.says_gear_at(ratio)) {
        return Err(Unusable::OutsideMap);
    }
    let range = joint.ratio.range().filter(|_| gear.is_none());
    let solved = |range| solve(&prepared, joint, range).map(|optimum| judged_part(&prepared, optimum, false));
    let best = range.map(solved);
    let here = ratio.or(gear.map(|g| g.ratio)).unwrap_or_else(|| match &best {
        Some(Ok(optimum)) => optimum.ratio,
        Some(Err(Reason::Infeasible(Infeasible::Never { ratio, .. } | Infeasible::Nowhere { ratio, .. }))) => *ratio,
        Some(Err(Reason::Infeasible(Infeasible::Contradiction { at_least, at_most, .. }))) => {
            (at_least * at_most).sqrt()
        }
        _ => range.map_or(1.0, |(min, max)| (min * max).sqrt()),
    });
    let sensitivities = match (&best, range) {
        (Some(Ok(optimum)), Some(range)) => sensitivities(&mount, range, optimum.objective),
        _ => Vec::new(),
    };
    let remedies = match (&best, range) {
        (Some(Err(_)), Some(range)) => remedies(&prepared, joint, range),
        (None, _) => remedies_at(&prepared, here),
        _ => Vec::new(),
    };
    let turns = can_be_asked(robot, joint, motor).is_ok().then(|| TurnsRange::at(&prepared, here));
    Ok(Explanation { sensitivities, remedies, turns, ..at(&prepared, (joint, motor, gear), here, best) })
}

/// What is known of a prepared motor at a ratio; `best` is what a search found.
fn at<'a>(
    prepared: &Prepared,
    (joint, motor, gear): (&'a Joint, &'a Motor, Option<&'a Gear>),
    ratio: f64,
    best: Option<Result<Optimum, Reason>>,
) -> Explanation<'a> {
    let Judged { unchecked, assumed } = prepared.judged(ratio);
    Explanation {
        joint,
        motor,
        gear,
        evaluation: prepared.at_in_full(ratio),
        winding_temperature: prepared.winding_temperature(ratio),
        reversal_time: prepared.reversal_time(ratio),
        best,
        sensitivities: Vec::new(),
        remedies: Vec::new(),
        turns: None,
        unjudged: unjudged(prepared.candidate.robot, joint, &unchecked),
        unchecked,
        assumed,
        spring: None,
        nearest_spring: None,
    }
}

/// Ratios at which a motor that cannot do it is looked at.
const LOOKS: usize = 40;

/// A motor of which a search has been made at a joint, at a ratio: what takes a search of its own (sensitivities, what would have to
/// change at other ratios) is left out. Without a ratio it is the best one, or where there is none that which comes nearest.
///
/// # Errors
/// Why the motor is no candidate.
pub fn look<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    (motor, gear): (&'a Motor, Option<&'a Gear>),
    ratio: Option<f64>,
    best: Result<(&Optimum, Option<SpringChoice>), &Reason>,
) -> Result<Explanation<'a>, Unusable> {
    let spring = best.ok().and_then(|(_, spring)| spring);
    let chosen = spring.map(|spring| (spring.stiffness, spring.rest_angle.unwrap_or(0.0)));
    // Where there has to be a spring, a motor that cannot do it is looked at with the one that comes nearest.
    let nearest_spring = match (best, &joint.limits.spring) {
        (Err(_), Some(asked)) if asked.stiffness[0] > 0.0 => {
            let load = load_through(joint, gear);
            let mount = Mount::new(robot, joint, &load, motor).with_gear(gear);
            let fixed = ratio.or(mount.gear.map(|gear| gear.ratio)).map(|ratio| (ratio, ratio));
            let range = fixed.or(joint.ratio.range()).unwrap_or((1.0, 1.0));
            nearest(&mount, &mount.prepared()?, range)
        }
        _ => None,
    };
    let moved = chosen.or(nearest_spring).and_then(|(stiffness, rest)| joint.with_spring(stiffness, rest));
    let own = moved.as_ref().unwrap_or(joint);
    let load = load_through(own, gear);
    let mount = Mount::new(robot, own, &load, motor).with_gear(gear);
    let prepared = mount.prepared()?;
    if ratio.is_some_and(|ratio| !prepared.says_gear_at(ratio)) {
        return Err(Unusable::OutsideMap);
    }
    let free = joint.ratio.range().filter(|_| mount.gear.is_none());
    let ratio = ratio.or(mount.gear.map(|gear| gear.ratio)).or(best.ok().map(|(optimum, _)| optimum.ratio));
    let here = ratio.unwrap_or_else(|| free.map_or(1.0, |range| nearest_ratio(&prepared, range)));
    let best_reason = best.err().cloned();
    let best = free.map(|_| best.map(|(optimum, _)| optimum.clone()).map_err(Clone::clone));
    let mut story = at(&prepared, (joint, motor, gear), here, best);
    story.spring = match (spring, best_reason) {
        (Some(spring), _) => Some(Ok(spring)),
        (None, Some(reason)) if joint.limits.spring.is_some() => Some(Err(reason)),
        _ => None,
    };
    story.nearest_spring = nearest_spring;
    story.remedies = remedies_at(&prepared, here);
    Ok(story)
}

/// The ratio of a range at which the limit that is exceeded most is exceeded least.
fn nearest_ratio(prepared: &Prepared, (least, most): (f64, f64)) -> f64 {
    let ratios = if least < most { grid(least, most, LOOKS) } else { vec![least] };
    let worst = |ratio: f64| {
        let margins = prepared.at(ratio).margins;
        margins.iter().map(|m| m.margin).fold(f64::INFINITY, f64::min)
    };
    ratios.into_iter().map(|ratio| (ratio, worst(ratio))).max_by(|a, b| a.1.total_cmp(&b.1)).map_or(least, |(n, _)| n)
}

/// Re-solves with each parameter of the motor changed for the better by a tenth.
fn sensitivities(mount: &Mount, range: (f64, f64), objective: f64) -> Vec<Sensitivity> {
    let Mount { joint, motor, .. } = *mount;
    type Change = (&'static str, f64, fn(&mut Motor, f64));
    let changes: [Change; 5] = [
        ("resistance", -0.1, |m, f| m.resistance *= f),
        ("inductance", -0.1, |m, f| m.inductance = m.inductance.map(|l| l * f)),
        ("torque and back-EMF constant", 0.1, |m, f| {
            m.torque_constant *= f;
            m.back_emf_constant *= f;
        }),
        ("rotor inertia", -0.1, |m, f| m.rotor_inertia = m.rotor_inertia.map(|j| j * f)),
        ("mass", -0.1, |m, f| m.mass = m.mass.map(|x| x * f)),
    ];
    let known = |name: &str| match name {
        "inductance" => motor.inductance.is_some(),
        "mass" => motor.mass.is_some(),
        _ => true,
    };
    let changed = changes.into_iter().filter(|(name, ..)| known(name)).map(|(parameter, change, apply)| {
        let mut other = motor.clone();
        apply(&mut other, 1.0 + change);
        let prepared = Mount { motor: &other, ..*mount }.prepared().ok();
        let solved = prepared.and_then(|p| solve(&p, joint, range).ok());
        Sensitivity { parameter, change, objective: solved.map(|o| o.objective / objective - 1.0) }
    });
    changed.collect()
}

impl Remedy {
    /// A limit that would have to be `needed` at a ratio.
    fn new(asked: &Asked, candidate: &Candidate, needed: f64, ratio: f64) -> Remedy {
        let (limit, unit) = (asked.limit.name, asked.limit.unit_for(candidate.robot));
        let at_least = asked.parts().is_some_and(|parts| parts.missing.is_some());
        Remedy { limit, unit, bound: asked.bound, needed, ratio, owner: asked.owner, at_least }
    }
}

/// For each limit: what it would have to be if it were widened alone.
fn remedies(prepared: &Prepared, joint: &Joint, (min, max): (f64, f64)) -> Vec<Remedy> {
    let mut found = Vec::new();
    for asked in prepared.asked.iter().filter(|asked| asked.end == End::First) {
        let without = prepared.without(asked.limit.name);
        let Ok(optimum) = RatioProgram::new(&without, &joint.objective, min, max).solve() else {
            continue;
        };
        let demand = |n: f64| prepared.raw_demand(asked, n);
        let mut least: Option<(f64, f64)> = None;
        for window in &optimum.windows {
            let inside = golden_section(&demand, window.min, window.max, FULLY);
            for n in [window.min, inside, window.max] {
                let value = demand(n);
                if least.is_none_or(|(_, l)| value < l) {
                    least = Some((n, value));
                }
            }
        }
        if let Some((ratio, raw)) = least {
            let there = asked.at(&prepared.candidate, ratio);
            found.push(Remedy::new(&there, &prepared.candidate, there.natural(raw), ratio));
        }
    }
    found.retain(|r| r.needed > r.bound);
    found.sort_by(|a, b| (a.needed / a.bound).total_cmp(&(b.needed / b.bound)).then(a.limit.cmp(b.limit)));
    found
}

/// The limits that a fixed ratio exceeds, each with what it would have to be.
fn remedies_at(prepared: &Prepared, ratio: f64) -> Vec<Remedy> {
    let firsts = prepared.asked.iter().filter(|asked| asked.end == End::First);
    let broken = firsts.filter_map(|asked| {
        let raw = prepared.raw_demand(asked, ratio);
        let needed = asked.natural(raw);
        let exceeded = asked.margin(&prepared.candidate, ratio, raw) < -super::evaluate::FEASIBILITY_TOLERANCE;
        exceeded.then_some(Remedy::new(asked, &prepared.candidate, needed, ratio))
    });
    broken.collect()
}
