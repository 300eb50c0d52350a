//! What another number of turns would do for a motor: whether voltage and the drive's current can be kept, and with how
//! many times the turns of its row.
//!
//! The one idea: with `a` times the turns (see [`gearwise_model::catalog::rewound`]) voltages go with a and currents with 1/a, and
//! nothing else changes. At a ratio, the drive's current asks for `a ≥ a_min` and the voltage for `a ≤ a_max`, both in closed form; the best
//! ratio over all windings is that of the program without these limits, wherever `a_min ≤ a_max` there. The
//! program's certificate is then that of both. Elsewhere the ratios that it leaves are searched, which proves nothing.

use rayon::prelude::*;

use super::answer::{Design, JointResult, Reason, Refused, Rejected};
use super::best::best_design;
use super::flatness::{at_design, sprung};
use super::mount::{Mount, Site, load_through};
use super::program::{Certificate, Infeasible};
use super::{Prepared, judge};
use gearwise_model::actuator::limits::{Asked, DRIVE_CONTINUOUS_CURRENT, Depends, Remark};
use gearwise_model::catalog::rewound::NoTurns;
use gearwise_model::catalog::{Catalog, Gear, Motor};
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Quantity, Robot, Turns};

/// Numbers of turns with which a design keeps voltage and the drive's current, as multiples of those of the row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnsRange {
    /// The least, by the drive's current; zero where nothing says one.
    pub min: f64,
    /// The most, by the voltage; infinite where no voltage is needed.
    pub max: f64,
    /// The limit that makes the least, where there is one.
    pub min_by: Option<&'static str>,
    /// The limit that makes the most, where there is one.
    pub max_by: Option<&'static str>,
}

impl TurnsRange {
    /// Of a candidate at a ratio. Its limits are those of the motor as it is wound.
    pub fn at(prepared: &Prepared, ratio: f64) -> TurnsRange {
        let mut range = TurnsRange { min: 0.0, max: f64::INFINITY, min_by: None, max_by: None };
        let candidate = &prepared.candidate;
        let demand = |asked: &Asked| asked.natural(asked.raw_demand(candidate, ratio).0);
        for asked in &prepared.asked {
            let (name, reserve) = (asked.limit.name, candidate.joint.limits.reserve(asked.limit.name));
            match asked.limit.depends {
                Depends::Voltage | Depends::BackEmf => {
                    let most = asked.bound / demand(asked);
                    if most < range.max {
                        (range.max, range.max_by) = (most, Some(name));
                    }
                }
                Depends::Current if name == DRIVE_CONTINUOUS_CURRENT => {
                    let least = demand(asked) / asked.bound;
                    if least > range.min {
                        (range.min, range.min_by) = (least, Some(name));
                    }
                }
                Depends::Current if asked.limit.is_of_drive() => {
                    let Some(drive) = candidate.drive_current() else { continue };
                    let least = demand(asked) / (drive * (1.0 - reserve));
                    if least > range.min {
                        (range.min, range.min_by) = (least, Some(name));
                    }
                }
                _ => {}
            }
        }
        range
    }

    /// Whether some number of turns is in it.
    pub fn is_possible(&self) -> bool {
        self.min <= self.max
    }

    /// The part of it between two numbers of turns.
    #[must_use]
    pub fn between(self, (min, max): (f64, f64)) -> TurnsRange {
        TurnsRange { min: self.min.max(min), max: self.max.min(max), ..self }
    }

    /// Whether a number of turns is in it.
    pub fn holds(&self, turns: f64) -> bool {
        self.min <= turns && turns <= self.max
    }
}

/// The best that a motor does with another number of turns.
#[derive(Debug, Clone)]
pub struct OtherTurns<'a> {
    /// The ratio.
    pub ratio: f64,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The objective there, which does not depend on the turns; `None` where it counts a current, which does.
    pub objective: Option<f64>,
    /// Copper loss there \[W\].
    pub loss: f64,
    /// The numbers of turns that keep every limit there.
    pub turns: TurnsRange,
    /// Whether it is proved that no ratio and no winding is better: else it was found.
    pub proved: bool,
    /// Limits that could not be checked with the motor as it is wound, and why.
    pub unchecked: Vec<Remark>,
    /// Rows of the catalogue that are the same motor with such a number of turns, as far as their numbers say.
    pub rows: Vec<&'a Motor>,
}

/// What another number of turns does for a motor.
#[derive(Debug, Clone)]
pub enum Rewinding<'a> {
    /// It can do it with some.
    Found(Box<OtherTurns<'a>>),
    /// It is proved that it cannot with any: why, with voltage and drive left out.
    Useless(Reason),
    /// With voltage and drive left out, something cannot be judged of it: what, and why.
    Unjudged(Vec<Remark>),
    /// None was found, and none was ruled out.
    NoneFound,
    /// It has no other number of turns.
    NotAsked(NoTurns),
}

/// Ratios of a window that are looked at where the best of them has no winding.
const LOOKS: usize = 512;
/// Halvings between a ratio that has a winding and one that has none.
const HALVINGS: usize = 40;

/// Whether what other turns would do for a motor at a joint can be said.
///
/// # Errors
/// Why not.
pub fn can_be_asked(robot: &Robot, joint: &Joint, motor: &Motor) -> Result<(), NoTurns> {
    can_be_computed(robot, joint)?;
    motor.can_be_rewound()
}

/// Whether what other turns would do at a joint can be computed, whichever its motor.
///
/// # Errors
/// Why not.
pub(super) fn can_be_computed(robot: &Robot, joint: &Joint) -> Result<(), NoTurns> {
    obstacles(robot, joint).into_iter().next().map_or(Ok(()), Err)
}

/// All that other turns are not computed with at a joint.
pub(super) fn obstacles(robot: &Robot, joint: &Joint) -> Vec<NoTurns> {
    let drive = joint.drive.or(robot.bus.drive);
    let of_supply = [robot.bus.internal_resistance, drive.supply_lead_resistance];
    let counts = |resistance: Option<f64>| resistance.is_some_and(|ohms| ohms > 0.0);
    let along_d = drive.field_weakening_current.is_some() || robot.bus.flux_braking;
    let all = [
        (NoTurns::DriveResistance, counts(drive.phase_resistance)),
        (NoTurns::FieldWeakening, along_d),
        (NoTurns::SupplyResistance, of_supply.into_iter().any(counts)),
    ];
    all.into_iter().filter(|(_, is_there)| *is_there).map(|(why, _)| why).collect()
}

/// What another number of turns would do for a motor at a joint.
pub fn rewinding<'a>(site: Site<'a, '_>, motor: &'a Motor, catalog: &'a Catalog, only_checked: bool) -> Rewinding<'a> {
    if let Err(why) = can_be_asked(site.robot, site.joint, motor) {
        return Rewinding::NotAsked(why);
    }
    let joint = Joint { turns: Turns::Any, ..site.joint.clone() };
    let open = Site { joint: &joint, ..site };
    let best = match best_design(open, motor, only_checked) {
        Ok(design) => design,
        Err(Refused::Unjudged(apart)) => return Rewinding::Unjudged(apart.because),
        Err(Refused::Rejected(why)) => return refused(why.reason),
    };
    let counts_current = joint.objective.weight(Quantity::PeakCurrent) > 0.0;
    let found = |at: Found<'a>, proved: bool| {
        let apart = judge::unjudged(site.robot, site.joint, &at.unchecked);
        let apart = if only_checked { at.unchecked.clone() } else { apart };
        if !apart.is_empty() {
            return Rewinding::Unjudged(apart);
        }
        let rows = same_frame(catalog, motor).filter(|(_, a)| at.turns.holds(*a)).map(|(row, _)| row).collect();
        Rewinding::Found(Box::new(OtherTurns {
            ratio: at.ratio,
            gear: at.gear.map(|g| g.id.as_str()),
            objective: (!counts_current).then_some(at.objective),
            loss: at.loss,
            turns: at.turns,
            proved: proved && !counts_current,
            unchecked: at.unchecked,
            rows,
        }))
    };
    let first = at_best(site, motor, &best);
    if let Some(at) = first.filter(|at| at.turns.is_possible()) {
        let proved = matches!(best.optimum.certificate, Certificate::Certified { .. });
        return found(at, proved);
    }
    if joint.limits.spring.is_some() {
        return Rewinding::NoneFound;
    }
    search(site, open, motor, &best, |turns| Some(turns).filter(TurnsRange::is_possible))
        .map_or(Rewinding::NoneFound, |at| found(at, false))
}

/// A ratio or gear at which some number of turns keeps every limit.
#[derive(Debug, Clone)]
pub(super) struct Found<'a> {
    pub(super) ratio: f64,
    gear: Option<&'a Gear>,
    pub(super) objective: f64,
    loss: f64,
    pub(super) turns: TurnsRange,
    unchecked: Vec<Remark>,
}

/// What a motor's refusal without voltage and drive says of its windings.
fn refused<'a>(reason: Reason) -> Rewinding<'a> {
    match reason {
        Reason::Infeasible(Infeasible::Never { .. } | Infeasible::Contradiction { .. }) | Reason::Gears { .. } => {
            Rewinding::Useless(reason)
        }
        Reason::Unchecked(limit, why) => Rewinding::Unjudged(vec![(limit, why)]),
        _ => Rewinding::NoneFound,
    }
}

/// The numbers of turns at the best design of a motor, with its gear and its spring.
pub(super) fn at_best<'a>(site: Site<'a, '_>, motor: &'a Motor, design: &Design) -> Option<Found<'a>> {
    let joint = sprung(site.joint, design)?;
    let gear = site.mounts(motor).filter_map(|m| m.gear).find(|gear| design.gear == Some(gear.id.as_str()));
    let load = load_through(&joint, gear);
    let prepared = Mount::new(site.robot, &joint, &load, motor).with_gear(gear).prepared().ok()?;
    let ratio = design.evaluation.ratio;
    Some(Found {
        ratio,
        gear,
        objective: design.optimum.objective,
        loss: design.evaluation.loss,
        turns: TurnsRange::at(&prepared, ratio),
        unchecked: prepared.unchecked_at(ratio),
    })
}

/// The best of some ratios at which a winding exists, where the best over all of them has none; `allowed` narrows what would do, to nothing
/// where none is left.
pub(super) fn search<'a>(
    site: Site<'a, '_>,
    open: Site,
    motor: &'a Motor,
    best: &Design,
    allowed: impl Fn(TurnsRange) -> Option<TurnsRange>,
) -> Option<Found<'a>> {
    let mut kept: Option<Found> = None;
    for (mount, free) in site.mounts(motor).zip(open.mounts(motor)) {
        let (Ok(wound), Ok(free)) = (mount.prepared(), free.prepared()) else { continue };
        let look = |ratio: f64| {
            let turns = allowed(TurnsRange::at(&wound, ratio))?;
            let there = free.at(ratio);
            let objective = free.at_in_full(ratio).objective(&site.joint.objective).filter(|_| there.feasible)?;
            let unchecked = wound.unchecked_at(ratio);
            Some(Found { ratio, gear: mount.gear, objective, loss: there.loss, turns, unchecked })
        };
        let windows = &best.optimum.windows;
        let ratios: Vec<f64> = match (mount.gear, site.joint.ratio.listed()) {
            (Some(gear), _) => vec![gear.ratio],
            (None, Some(values)) => values.to_vec(),
            (None, None) => windows.iter().flat_map(|w| grid(w.min, w.max, LOOKS)).collect(),
        };
        let found: Vec<Option<Found>> = ratios.iter().map(|n| look(*n)).collect();
        let objective = |k: usize| found[k].as_ref().map_or(f64::INFINITY, |f| f.objective);
        let Some(least) = (0..found.len()).min_by(|a, b| objective(*a).total_cmp(&objective(*b))) else { continue };
        let Some(mut at) = found[least].clone() else { continue };
        if mount.gear.is_none() && site.joint.ratio.listed().is_none() {
            // Beside the best that has a winding may be better ones that have.
            for other in [least.checked_sub(1), Some(least + 1)].into_iter().flatten() {
                let Some(beyond) = ratios.get(other) else { continue };
                let (mut inside, mut outside) = (ratios[least], *beyond);
                for _ in 0..HALVINGS {
                    let middle = (inside * outside).sqrt();
                    match look(middle) {
                        Some(better) if better.objective <= at.objective => (inside, at) = (middle, better),
                        _ => outside = middle,
                    }
                }
            }
        }
        if kept.as_ref().is_none_or(|k| at.objective < k.objective) {
            kept = Some(at);
        }
    }
    kept
}

/// What two rows of one frame may differ by (relative): sheets round, and copper fills slots unlike.
const SAME_SIZE: f64 = 0.02;
const SAME_COPPER: f64 = 0.3;

/// Rows of the catalogue that look like a motor with another number of turns, with that number: same maker, pole pairs,
/// mass, rotor inertia and diameter, and nearly the same R/K_T².
fn same_frame<'a>(catalog: &'a Catalog, motor: &'a Motor) -> impl Iterator<Item = (&'a Motor, f64)> {
    let near = |a: f64, b: f64, within: f64| (a - b).abs() <= within * a.abs().max(b.abs());
    let same = move |a: Option<f64>, b: Option<f64>| a.zip(b).is_some_and(|(a, b)| near(a, b, SAME_SIZE));
    let diameter = |m: &Motor| m.sheet.outer_diameter.map(|p| p.value);
    let copper = |m: &Motor| m.resistance / m.torque_constant.powi(2);
    catalog.motors.iter().filter_map(move |row| {
        let turns = row.torque_constant / motor.torque_constant;
        let is_same = row.id != motor.id
            && row.wound.is_none()
            && row.manufacturer == motor.manufacturer
            && row.pole_pairs == motor.pole_pairs
            && same(row.mass, motor.mass)
            && same(row.rotor_inertia, motor.rotor_inertia)
            && diameter(row).zip(diameter(motor)).is_none_or(|(a, b)| near(a, b, SAME_SIZE))
            && near(copper(row), copper(motor), SAME_COPPER)
            && !near(turns, 1.0, SAME_SIZE);
        is_same.then_some((row, turns))
    })
}

/// Whether a limit of a motor depends on its turns: a voltage, or a current that the drive ends.
fn is_of_turns(prepared: &Prepared, limit: &str) -> bool {
    let decides = |asked: &&Asked| match asked.limit.depends {
        Depends::Voltage | Depends::BackEmf => true,
        Depends::Current if asked.limit.name == DRIVE_CONTINUOUS_CURRENT => true,
        Depends::Current => asked.limit.is_of_drive() && asked.owner == "drive",
        _ => false,
    };
    prepared.asked.iter().filter(decides).any(|asked| asked.limit.name == limit)
}

/// Whether it is proved that other turns leave a refusal as it is: nothing in it depends on them.
fn stands_anyway(site: Site, motor: &Motor, reason: &Reason) -> bool {
    let Ok(prepared) = site.direct(motor).prepared() else { return false };
    match reason {
        Reason::Infeasible(Infeasible::Never { bind, .. }) => !is_of_turns(&prepared, bind.limit),
        Reason::Infeasible(Infeasible::Contradiction { low, high, .. }) => {
            !is_of_turns(&prepared, low.limit) && !is_of_turns(&prepared, high.limit)
        }
        _ => false,
    }
}

/// What another number of turns would do for the motors of a joint that were found unable, in their order.
pub fn rewindings<'a>(
    site: Site<'a, '_>,
    result: &JointResult<'a>,
    catalog: &'a Catalog,
    only_checked: bool,
) -> Vec<(&'a Motor, Rewinding<'a>)> {
    let is_asked =
        |reason: &Reason| matches!(reason, Reason::Infeasible(_) | Reason::Gears { .. } | Reason::NotSolved(_));
    let asked: Vec<_> = result.rejected.iter().filter(|r| is_asked(&r.reason)).collect();
    let one = |r: &&Rejected<'a>| {
        let rewound = match can_be_asked(site.robot, site.joint, r.motor) {
            Err(why) => Rewinding::NotAsked(why),
            Ok(()) if stands_anyway(site, r.motor, &r.reason) => Rewinding::Useless(r.reason.clone()),
            Ok(()) => rewinding(site, r.motor, catalog, only_checked),
        };
        (r.motor, rewound)
    };
    asked.par_iter().map(one).collect()
}

/// What another number of turns would do for the first choice, where voltage or the drive's current holds its ratio back.
pub fn first_rewound<'a>(
    site: Site<'a, '_>,
    result: &JointResult<'a>,
    catalog: &'a Catalog,
    only_checked: bool,
) -> Option<Rewinding<'a>> {
    let design = result.candidates.first()?;
    let held =
        |prepared: &Prepared| design.optimum.shadow_prices.iter().any(|price| is_of_turns(prepared, price.limit));
    let is_held = at_design(site.robot, site.joint, design, held).unwrap_or(false);
    is_held.then(|| rewinding(site, design.motor, catalog, only_checked))
}
