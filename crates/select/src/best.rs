//! The best design of one motor at one joint: of all ratios or of the gears of the catalogue, with a spring or without.

use super::answer::{Design, Reason, Refused, Rejected, Unjudged, Unusable};
use super::mount::{Mount, Site};
use super::program::{Certificate, Optimum, RatioProgram};
use super::selection::Selection;
use super::solved::{design, one_gear, solve};
use super::{Prepared, judge, spring};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::Motor;
use gearwise_model::catalog::convention::Commutation;
use gearwise_model::requirement::{Joint, Quantity};

/// The best design of one motor at one joint.
///
/// # Errors
/// Why the motor is no choice: it cannot do it, or that it can is not known.
pub fn best_design<'a>(site: Site<'a, '_>, motor: &'a Motor, only_checked: bool) -> Result<Design<'a>, Refused<'a>> {
    best_known(site, motor, only_checked).map_err(|why| match why {
        Refused::Rejected(why) if why.reason == Reason::Unusable(Unusable::Mass) => {
            without_mass(site, motor, only_checked)
        }
        Refused::Rejected(why) => match left_out_along_d(site, motor) {
            Some(because) => Refused::Unjudged(Box::new(Unjudged { motor, gear: None, because, design: None })),
            None => Refused::Rejected(why).told_apart(),
        },
        why => why,
    })
}

/// Of a motor that is rejected: the current along d that the requirement allows and that is not computed here, where the motor would do
/// if what that is for were no limit. Whether it does it with the current is not known.
fn left_out_along_d(site: Site, motor: &Motor) -> Option<Vec<Remark>> {
    const VOLTAGE: [&str; 2] = ["voltage", "torque_bandwidth_voltage"];
    const BACK: [&str; 2] = ["regeneration", "bus_overvoltage"];
    let drive = site.joint.drive.or(site.robot.bus.drive);
    if drive.field_weakening_current.is_none() && !site.robot.bus.flux_braking {
        return None;
    }
    let of_mount = |mount: Mount| {
        let prepared = mount.prepared().ok()?;
        let candidate = &prepared.candidate;
        if candidate.motor.conventions.commutation == Commutation::Brushed {
            return None;
        }
        let weakening = candidate.why_not_weakened().map(|why| (("field_weakening", why), VOLTAGE));
        let braking = candidate.why_not_braked().map(|why| (("flux_braking", why), BACK));
        let left_out: Vec<(Remark, [&str; 2])> = weakening.into_iter().chain(braking).collect();
        let mut free = prepared.clone();
        for limit in left_out.iter().flat_map(|(_, limits)| limits) {
            free = free.without(limit);
        }
        let would_do = || match (mount.gear, mount.range()) {
            (Some(gear), _) => free.at(gear.ratio).feasible,
            (None, Some(_)) if mount.joint.limits.spring.is_some() => true,
            (None, Some(range)) => solve(&free, mount.joint, range).is_ok(),
            (None, None) => false,
        };
        (!left_out.is_empty() && would_do()).then(|| left_out.into_iter().map(|(remark, _)| remark).collect())
    };
    site.mounts(motor).find_map(of_mount)
}

/// What the objective is of a design whose mass is not known.
const OBJECTIVE: Remark = ("objective", "it counts the mass, and the mass of motor or gear is not known");

/// What becomes of a motor whose mass the objective counts and nobody knows: it cannot be ranked, but may do the task. Its
/// design is the best without the mass in the objective.
fn without_mass<'a>(site: Site<'a, '_>, motor: &'a Motor, only_checked: bool) -> Refused<'a> {
    let joint = Joint { objective: site.joint.objective.without_mass(), ..site.joint.clone() };
    let lighter = Site { joint: &joint, ..site };
    let gear = |id: Option<&str>| {
        let mut mounts = site.mounts(motor);
        id.and_then(|id| mounts.find(|m| m.gear_id() == Some(id))).and_then(|m| m.gear_id())
    };
    let because = |known: Vec<Remark>| [vec![OBJECTIVE], known].concat();
    let (design, known) = match best_known(lighter, motor, only_checked) {
        Ok(design) => (design, Vec::new()),
        Err(Refused::Unjudged(apart)) => match *apart {
            Unjudged { design: Some(design), because, .. } => (design, because),
            Unjudged { gear: id, because, .. } => {
                return Refused::Unjudged(Box::new(Unjudged { motor, gear: gear(id), because, design: None }));
            }
        },
        Err(Refused::Rejected(why)) => {
            let rejected = Rejected { motor, gear: gear(why.gear), reason: why.reason };
            return Refused::rejected(rejected).told_apart();
        }
    };
    let certificate = Certificate::NotCertified("the objective is not known without the mass".into());
    let optimum = Optimum { objective: f64::NAN, certificate, shadow_prices: Vec::new(), ..design.optimum };
    let design = Design { motor, gear: gear(design.gear), optimum, ..design };
    Refused::Unjudged(Box::new(Unjudged::of(design, because(known))))
}

/// The best design by an objective whose numbers are known.
fn best_known<'a>(site: Site<'a, '_>, motor: &'a Motor, only_checked: bool) -> Result<Design<'a>, Refused<'a>> {
    let Site { robot, joint, demand, .. } = site;
    let refuse = |reason| Refused::rejected(Rejected { motor, gear: None, reason });
    if let Some(why) = lacking(motor, demand.load.duration.is_some(), |q| joint.objective.weight(q) > 0.0) {
        return Err(refuse(Reason::Unusable(why)));
    }
    let found = match joint.limits.spring {
        Some(_) if site.is_geared_with(motor) => spring::best_gear(site, motor, only_checked)?,
        None if site.is_geared_with(motor) => best_gear(site, motor, only_checked)?,
        _ => free_ratio(site.direct(motor), only_checked).map_err(refuse)?,
    };
    judge::judged(robot, joint, found, only_checked)
}

/// What a motor or a motion lacks for a quantity that is asked for.
pub(super) fn lacking(motor: &Motor, has_cycle: bool, counts: impl Fn(Quantity) -> bool) -> Option<Unusable> {
    let mass = counts(Quantity::Mass) && motor.mass.is_none();
    let durations = counts(Quantity::Energy) && !has_cycle;
    mass.then_some(Unusable::Mass).or(durations.then_some(Unusable::Durations))
}

/// The best design over the free ratio.
fn free_ratio<'a>(mount: Mount<'a, '_>, only_checked: bool) -> Result<Design<'a>, Reason> {
    let prepared = mount.prepared().map_err(Reason::Unusable)?;
    let Some(range) = mount.range() else { return Err(Reason::Unusable(Unusable::NoGearFits)) };
    if let Some((limit, why)) = judge::left_out(mount.robot, mount.joint, &prepared.unchecked, only_checked) {
        return Err(Reason::Unchecked(limit, why));
    }
    if mount.joint.limits.spring.is_some() {
        return spring::solve(&mount, &prepared, range);
    }
    let optimum = solve(&prepared, mount.joint, range)?;
    let stays = mount.whole_windows && judge::doubt(&prepared, optimum.ratio, only_checked).is_none();
    let optimum = if stays { optimum } else { judge::judged_part(&prepared, optimum, only_checked) };
    Ok(design(&mount, &prepared, optimum))
}

/// A design with its windows cut where it cannot be judged, if they were left [whole](Site::whole_windows).
pub(super) fn with_windows<'a>(site: Site<'a, '_>, design: Design<'a>, only_checked: bool) -> Design<'a> {
    if !site.whole_windows || design.gear.is_some() || design.spring.is_some() {
        return design;
    }
    let Ok(prepared) = site.direct(design.motor).prepared() else { return design };
    Design { optimum: judge::judged_part(&prepared, design.optimum, only_checked), ..design }
}

/// Whether a motor that exceeds a limit cannot: no current along d that may be asked for is left out.
pub(super) fn is_known(prepared: &Prepared) -> bool {
    prepared.candidate.why_not_weakened().is_none() && prepared.candidate.why_not_braked().is_none()
}

/// Whether it is certain, without solving, that [`best_design`] rejects a motor. `false` says nothing.
pub(super) fn is_impossible(site: Site, motor: &Motor) -> bool {
    let mount = site.direct(motor);
    let Some((min, max)) = mount.range() else { return false };
    if site.joint.limits.spring.is_some() || motor.inside.is_some() {
        return false;
    }
    mount
        .prepared()
        .is_ok_and(|p| is_known(&p) && RatioProgram::new(&p, &site.joint.objective, min, max).is_impossible())
}

/// The best gear of the catalogue for one motor: all that fit are evaluated, which is the proof.
fn best_gear<'a>(site: Site<'a, '_>, motor: &'a Motor, only_checked: bool) -> Result<Design<'a>, Refused<'a>> {
    let Site { robot, joint, .. } = site;
    let mut gears: Selection<(Mount, Prepared, Optimum)> = Selection::new(motor);
    if !joint.motors.allows(motor) {
        gears.unusable(Unusable::NotAllowed);
    }
    for mount in site.mounts(motor) {
        let Some(gear) = mount.gear else { continue };
        let prepared = match mount.prepared() {
            Ok(prepared) => prepared,
            Err(why) => {
                gears.unusable(why);
                continue;
            }
        };
        let here = prepared.unchecked_at(gear.ratio);
        if let Some(what) = judge::left_out(robot, joint, &here, only_checked) {
            gears.unchecked(&gear.id, what);
            continue;
        }
        let evaluation = prepared.at(gear.ratio);
        match evaluation.objective(&joint.objective) {
            _ if !evaluation.feasible => gears.exceeds(&gear.id, evaluation.tightest()),
            None => gears.unusable(Unusable::Mass),
            Some(objective) => {
                let apart = !judge::unjudged(robot, joint, &here).is_empty();
                let method = if motor.inside.is_some() { "nothing to choose" } else { "all gears evaluated" };
                let optimum = one_gear(gear.ratio, objective, method);
                gears.take(apart, (objective, evaluation.loss), (mount, prepared, optimum));
            }
        }
    }
    let (mount, prepared, optimum) = gears.best_of(motor)?;
    Ok(design(&mount, &prepared, optimum))
}
