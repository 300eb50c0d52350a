//! One motor over the box of its tolerances.

use super::RobustDesign;
use super::corners::{Corner, Place, Toleranced, reaching_zero, toleranced, with_numbers};
use super::derivative::Along;
use super::proof::{Directions, Margins, Region, Verified, verify};
use crate::answer::{Design, Reason, Unusable};
use crate::evaluate::{Evaluation, FEASIBILITY_TOLERANCE, Judged, Margin, Prepared};
use crate::judge::{self, Doubts};
use crate::mount::{Mount, Site};
use crate::program::{Certificate, Limited, Optimum, RatioProgram, Unsolved};
use crate::selection::{Key, Selection};
use crate::solved::{Tried, best_listed, one_gear, tried};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::Motor;
use gearwise_model::numerics::work;
use gearwise_model::requirement::Objective;

/// Most numbers of which both ends are combined with each other from the start; places that break a limit are added to these.
const MOST_FREE: usize = 9;

/// Largest number of rounds in which places that exceed a limit are added.
const ROUNDS: usize = 12;

/// The design of a motor that keeps all limits over its tolerances; with `only_checked`, one of which every limit could
/// be checked.
///
/// # Errors
/// Why no ratio does.
pub fn best_robust<'a>(
    site: Site<'a, '_>,
    nominal: &Design<'a>,
    only_checked: bool,
) -> Result<RobustDesign<'a>, Reason> {
    let motor = nominal.motor;
    let all = toleranced(motor);
    if all.is_empty() {
        return Ok(RobustDesign {
            nominal: nominal.clone(),
            toleranced: all,
            corners: 0,
            gear: nominal.gear,
            optimum: nominal.optimum.clone(),
            evaluation: nominal.evaluation.clone(),
            worst_objective: nominal.optimum.objective,
            tightest: nominal.evaluation.tightest().copied(),
            unchecked: nominal.unchecked.clone(),
            assumed: nominal.assumed.clone(),
            unproven: Vec::new(),
            is_ended: false,
        });
    }
    if let Some(wide) = reaching_zero(&all) {
        return Err(Reason::NotSolved(Unsolved::ToleranceReachesZero(wide.column.clone())));
    }
    let over = Over { site, nominal, all: &all, only_checked };
    if site.is_geared_with(nominal.motor) { over.gears() } else { over.ratios() }
}

/// A design whose tolerances are looked at.
struct Over<'a, 'o> {
    site: Site<'a, 'o>,
    nominal: &'o Design<'a>,
    all: &'o [Toleranced],
    only_checked: bool,
}

impl<'a> Over<'a, '_> {
    /// The best ratio that keeps all limits over the tolerances.
    fn ratios(self) -> Result<RobustDesign<'a>, Reason> {
        let Over { site, nominal, all, .. } = self;
        let mount = site.direct(nominal.motor);
        let Some(range) = mount.range() else { return Err(Reason::Unusable(Unusable::NoGearFits)) };
        let start = Start::new(mount, all, range, self.only_checked)?;
        let mut corners = start.corners.clone();
        for round in 0.. {
            let boxed = Boxed::new(mount, all, &start, &corners).map_err(Reason::Unusable)?;
            let mut optimum = self.solved(&boxed, range)?;
            let mut verified = boxed.verified(optimum.ratio, f64::INFINITY);
            let mut broken = boxed.broken(&mut verified, round);
            if broken.is_empty() {
                broken = boxed.broken_at_ends(&optimum, &mut verified, round);
            }
            if broken.is_empty() {
                told(&verified, &mut optimum);
                return Ok(boxed.design(nominal, None, optimum, verified));
            }
            drop(boxed);
            corners.extend(broken);
        }
        unreachable!("rounds end")
    }

    /// The best ratio at which all corners keep all limits.
    fn solved(&self, boxed: &Boxed, range: (f64, f64)) -> Result<Optimum, Reason> {
        let Over { site, only_checked, .. } = *self;
        let objective = &site.joint.objective;
        if let Some(values) = site.joint.ratio.listed() {
            return best_listed(values.iter().copied(), |ratio| boxed.tried(objective, ratio, only_checked));
        }
        let program = RatioProgram::under(&boxed.nominal, objective, range, boxed.limits());
        let mut optimum = program.solve()?;
        if judge::may_change(&boxed.nominal, only_checked) {
            let all: Vec<&Prepared> = boxed.all().collect();
            let of = |k: usize, ratio: f64| judge::doubt(all[k], ratio, only_checked);
            optimum = judge::within(&boxed.nominal, optimum, Doubts { count: all.len(), of: &of });
            if let Some(doubt) = boxed.doubt(optimum.ratio, only_checked) {
                return Err(Reason::Unjudged(vec![doubt]));
            }
        }
        Ok(optimum)
    }

    /// The best gear with which all limits are kept over the tolerances.
    fn gears(self) -> Result<RobustDesign<'a>, Reason> {
        let Over { site, nominal, all, only_checked } = self;
        let mut gears: Selection<(&'a str, RobustDesign<'a>)> = Selection::new(nominal.motor);
        // The objective of a gear is that of the printed numbers: from the best gear on, the first that keeps all limits is the best.
        let key = |mount: &Mount| {
            let (gear, prepared) = (mount.gear?, mount.prepared().ok()?);
            let here = prepared.at(gear.ratio);
            Some((here.objective(&site.joint.objective)?, here.loss))
        };
        let mut mounts: Vec<(Option<Key>, Mount)> =
            site.mounts(nominal.motor).map(|mount| (key(&mount), mount)).collect();
        let order = |key: Option<Key>| key.unwrap_or((f64::INFINITY, f64::INFINITY));
        mounts.sort_by(|(a, _), (b, _)| {
            let ((a, of_a), (b, of_b)) = (order(*a), order(*b));
            a.total_cmp(&b).then(of_a.total_cmp(&of_b))
        });
        for (key, mount) in mounts {
            if key.is_some_and(|key| gears.is_led_by_better(key)) {
                break;
            }
            let Some(gear) = mount.gear else { continue };
            let Ok(start) = Start::new(mount, all, (gear.ratio, gear.ratio), only_checked) else { continue };
            let mut corners = start.corners.clone();
            for round in 0.. {
                let Ok(boxed) = Boxed::new(mount, all, &start, &corners) else { break };
                // With another gear than the nominal one other limits may be unknown.
                if let Some(doubt) = boxed.doubt(gear.ratio, only_checked) {
                    gears.mention(&gear.id, Reason::Unjudged(vec![doubt]));
                    break;
                }
                let tightest = boxed.tightest(gear.ratio);
                if let Some(margin) = tightest.filter(|m| m.margin < -FEASIBILITY_TOLERANCE) {
                    gears.exceeds(&gear.id, Some(&margin));
                    break;
                }
                let Some((objective, loss)) = key else {
                    gears.passed();
                    break;
                };
                let mut verified = boxed.verified(gear.ratio, f64::INFINITY);
                let broken = boxed.broken(&mut verified, round);
                if !broken.is_empty() {
                    drop(boxed);
                    corners.extend(broken);
                    continue;
                }
                let mut optimum = one_gear(gear.ratio, objective, "all gears evaluated");
                told(&verified, &mut optimum);
                let design = boxed.design(nominal, Some(&gear.id), optimum, verified);
                gears.take(false, (objective, loss), (&gear.id, design));
                break;
            }
        }
        gears.best().map(|(_, design)| design)
    }
}

/// Withdraw the certificate of an optimum if a limit is not proven over the tolerances.
fn told(verified: &Verified, optimum: &mut Optimum) {
    if !verified.unproven.is_empty() {
        let limits = verified.unproven.join(", ");
        optimum.certificate = Certificate::NotCertified(format!("not proven over the tolerances: {limits}").into());
    }
}

/// The worst ends of the tolerances of a motor with a gear, and the corners that the search begins with.
struct Start {
    directions: Directions,
    free: Vec<bool>,
    corners: Vec<Corner>,
    /// Limits judged at a ratio of which more tolerances count than are combined.
    open: Vec<&'static str>,
}

impl Start {
    fn new(mount: Mount, all: &[Toleranced], range: (f64, f64), only_checked: bool) -> Result<Start, Reason> {
        let nominal = mount.prepared().map_err(Reason::Unusable)?;
        let ratio = (range.0 * range.1).sqrt();
        let at = |place: &[f64]| {
            prepared_at(mount, all, place, |prepared| margins(prepared, ratio, None)).unwrap_or_default()
        };
        let directions = Directions::new(&standing_at(&nominal, ratio), all, range, &at);
        let objective = &nominal.candidate.joint.objective;
        let printed: Vec<f64> = all.iter().map(Toleranced::nominal).collect();
        let mut base = printed.clone();
        let mut free = vec![false; all.len()];
        for i in 0..all.len() {
            let of_objective = |share: f64| {
                let mut place = printed.clone();
                place[i] = share;
                prepared_at(mount, all, &place, |prepared| prepared.objective_at(objective, ratio)).flatten()
            };
            match directions.of_all(i) {
                Along::Convex | Along::Unknown => free[i] = true,
                _ if of_objective(0.0) != of_objective(1.0) => free[i] = true,
                Along::Constant => {}
                Along::Rising => base[i] = 1.0,
                Along::Falling => base[i] = 0.0,
            }
        }
        let chosen: Vec<usize> = (0..all.len()).filter(|i| free[*i]).collect();
        chosen.iter().skip(MOST_FREE).for_each(|i| free[*i] = false);
        let mut corners = combined(mount.motor, all, &base, &chosen, None);
        let mut open = Vec::new();
        if judge::may_change(&nominal, only_checked) {
            let heats: Vec<Heat> = all.iter().map(|of| Heat::along(of, mount.motor)).collect();
            let hottest = heats.iter().zip(&printed).map(|(heat, printed)| match heat {
                Heat::At(end) => *end,
                Heat::Not | Heat::Either => *printed,
            });
            let chosen: Vec<usize> = (0..all.len()).filter(|i| heats[*i] == Heat::Either).collect();
            let hottest = combined(mount.motor, all, &hottest.collect::<Vec<_>>(), &chosen, Some(HEAT));
            let is_new = |hot: &Corner| corners.iter().flatten().all(|corner: &Corner| corner.at != hot.at);
            let new: Vec<_> = hottest.into_iter().filter(|hot| hot.as_ref().is_none_or(is_new)).collect();
            corners.extend(new);
            if chosen.len() > MOST_FREE {
                open.extend(nominal.judged_at_ratio());
            }
        }
        let corners = corners.into_iter().collect::<Option<Vec<_>>>();
        let corners = corners.ok_or(Reason::NotSolved(Unsolved::ToleranceReachesZero("the sheet".into())))?;
        Ok(Start { directions, free, corners, open })
    }
}

/// The corners at both ends of each chosen tolerance, of the first [`MOST_FREE`] of them, with the others at their place in `base`:
/// `None` for those whose numbers make no motor.
fn combined(
    motor: &Motor,
    all: &[Toleranced],
    base: &[f64],
    chosen: &[usize],
    found_for: Option<&'static str>,
) -> Vec<Option<Corner>> {
    let chosen = &chosen[..chosen.len().min(MOST_FREE)];
    let corner = |bits: usize| {
        let mut place = base.to_vec();
        chosen.iter().enumerate().for_each(|(k, i)| place[*i] = f64::from((bits >> k & 1) as u32));
        Corner::new(motor, all, place, found_for)
    };
    (0..1_usize << chosen.len()).map(corner).collect()
}

/// Margin at the corners up to which a limit is proven at the ends of windows too.
const NEAR: f64 = 0.25;

/// Stands for heat that is judged at a ratio among the limits that corners are found for: it is none of the program's.
const HEAT: &str = "heat at a ratio";

/// The end of a tolerance at which heat that is judged at a ratio comes nearest to its limit. The mean of a squared current, and the
/// largest one, are convex in what friction and inertia add to the torque, and in the inverse of the torque constant.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Heat {
    /// It does not count.
    Not,
    /// The lower (0) or the upper end (1).
    At(f64),
    /// One of both.
    Either,
}

impl Heat {
    fn along(of: &Toleranced, motor: &Motor) -> Heat {
        match of.place {
            Place::Effect { .. } | Place::Gear(_) => Heat::Either,
            Place::Sheet(
                "resistance" | "thermal_resistance_winding_housing" | "thermal_resistance_housing_ambient",
            ) => Heat::At(1.0),
            Place::Sheet(
                "max_winding_temperature"
                | "reference_temperature"
                | "continuous_current"
                | "continuous_torque"
                | "thermal_time_constant_winding"
                | "thermal_time_constant_housing",
            )
            | Place::Rating("rated_torque") => Heat::At(0.0),
            Place::Sheet(
                "torque_constant" | "rotor_inertia" | "viscous_friction" | "coulomb_friction" | "no_load_current"
                | "no_load_speed",
            )
            | Place::Rating("torque_constant" | "efficiency") => Heat::Either,
            // Where it is what the torque constant comes from.
            Place::Sheet("back_emf_constant" | "speed_constant") if motor.sheet.torque_constant.is_none() => {
                Heat::Either
            }
            Place::Sheet(_) | Place::Rating(_) => Heat::Not,
        }
    }
}

/// Evaluate a motor of the box in the mount of the nominal one; `None` if its numbers form no motor.
fn prepared_at<T>(mount: Mount, all: &[Toleranced], at: &[f64], of: impl FnOnce(&Prepared) -> T) -> Option<T> {
    let motor = with_numbers(mount.motor, all.iter().zip(at).map(|(of, share)| (of, of.at(*share))))?;
    let there = Mount { motor: &motor, ..mount }.with_gear(mount.gear);
    Some(of(&there.prepared().ok()?))
}

/// Candidate and limits with the degree of standstill at a ratio.
fn standing_at<'p>(prepared: &Prepared<'p>, ratio: f64) -> Prepared<'p> {
    match prepared.candidate.by_ratio {
        Some(_) => prepared.with_candidate(prepared.candidate.standing_at(ratio)),
        None => prepared.clone(),
    }
}

/// The smallest margin of each limit at a ratio, or of some limits alone.
fn margins(prepared: &Prepared, ratio: f64, some: Option<&[&str]>) -> Margins {
    let mut all = Margins::new();
    for asked in prepared.asked.iter().filter(|asked| some.is_none_or(|some| some.contains(&asked.limit.name))) {
        let new = margin(Limited { candidate: &prepared.candidate, asked }, ratio);
        let least = all.entry(asked.limit.name).or_insert(new);
        if new.margin < least.margin {
            *least = new;
        }
    }
    all
}

fn margin(Limited { candidate, asked }: Limited, ratio: f64) -> Margin {
    Margin::new(&asked.at(candidate, ratio), candidate, ratio, asked.raw_demand(candidate, ratio))
}

/// A motor with a gear, at its printed numbers and at all corners.
struct Boxed<'p> {
    mount: Mount<'p, 'p>,
    all: &'p [Toleranced],
    start: &'p Start,
    nominal: Prepared<'p>,
    corners: Vec<(Prepared<'p>, &'p Corner)>,
}

impl<'p> Boxed<'p> {
    fn new(
        mount: Mount<'p, 'p>,
        all: &'p [Toleranced],
        start: &'p Start,
        corners: &'p [Corner],
    ) -> Result<Boxed<'p>, Unusable> {
        // A module's gear is its own at each corner.
        let prepare = |motor: &'p Motor| Mount { motor, ..mount }.with_gear(mount.gear).prepared();
        let corners = corners.iter().map(|c| Ok((prepare(&c.motor)?, c)));
        let corners = corners.collect::<Result<_, _>>()?;
        Ok(Boxed { mount, all, start, nominal: prepare(mount.motor)?, corners })
    }

    /// Proof over the box, at a ratio, of the limits that have at most this margin at the corners.
    fn verified(&self, ratio: f64, near: f64) -> Verified {
        let mut least = Margins::new();
        for limit in self.limits().into_iter().filter(|_| near.is_finite()) {
            let new = margin(limit, ratio);
            let kept = least.entry(new.limit).or_insert(new);
            kept.margin = kept.margin.min(new.margin);
        }
        let is_near = |limit: &str| least.get(limit).is_none_or(|margin| margin.margin <= near);
        let margins = |at: &[f64], ratio: f64, some: &[&str]| self.margins_at(at, ratio, some);
        let look = |nominal: &Prepared<'p>, corners: &[(Prepared<'p>, &'p Corner)]| {
            verify(&Region { nominal, corners, margins: &margins }, self.all, ratio, &is_near)
        };
        let mut verified = match self.nominal.candidate.by_ratio {
            None => look(&self.nominal, &self.corners),
            Some(_) => {
                let standing =
                    |(prepared, corner): &(Prepared<'p>, &'p Corner)| (standing_at(prepared, ratio), *corner);
                look(&standing_at(&self.nominal, ratio), &self.corners.iter().map(standing).collect::<Vec<_>>())
            }
        };
        self.start.open.iter().for_each(|limit| verified.leave_open(limit));
        verified
    }

    /// The motors that break a limit, where that is not looked at too often; else their limits are not proven.
    fn broken(&self, verified: &mut Verified, round: usize) -> Vec<Corner> {
        let mut broken = Vec::new();
        for (at, limit) in std::mem::take(&mut verified.exceeded) {
            let known = self.corners.iter().any(|(_, corner)| corner.at == at && corner.found_for == Some(limit));
            match Corner::new(self.mount.motor, self.all, at, Some(limit))
                .filter(|_| !known && round < ROUNDS && !work::is_spent())
            {
                Some(corner) => broken.push(corner),
                None => verified.leave_open(limit),
            }
        }
        broken
    }

    /// The motors that break a limit at an end of a window, which is to hold for the whole box.
    fn broken_at_ends(&self, optimum: &Optimum, verified: &mut Verified, round: usize) -> Vec<Corner> {
        let ends = optimum.windows.iter().flat_map(|window| [window.min, window.max]);
        let mut broken = Vec::new();
        for end in ends.filter(|end| *end != optimum.ratio) {
            let mut there = self.verified(end, NEAR);
            let known = there.unproven.len();
            broken.extend(self.broken(&mut there, round));
            there.unproven.drain(known..).for_each(|limit| verified.leave_open(limit));
        }
        broken
    }

    /// The limits of the printed numbers, and those of the corners that each needs.
    fn limits(&self) -> Vec<Limited<'_>> {
        let mut limits: Vec<Limited> =
            self.nominal.asked.iter().map(|asked| Limited { candidate: &self.nominal.candidate, asked }).collect();
        for (prepared, corner) in &self.corners {
            let needs = |name: &'static str| match corner.found_for {
                Some(limit) => limit == name,
                None => self.start.directions.needs(name, &corner.at, &self.start.free),
            };
            let wanted = prepared.asked.iter().filter(|asked| needs(asked.limit.name));
            limits.extend(wanted.map(|asked| Limited { candidate: &prepared.candidate, asked }));
        }
        limits
    }

    /// The smallest margin of each of some limits at a place of the box.
    fn margins_at(&self, at: &[f64], ratio: f64, some: &[&str]) -> Margins {
        prepared_at(self.mount, self.all, at, |prepared| margins(prepared, ratio, Some(some))).unwrap_or_default()
    }

    /// Unknown that prevents a choice at a ratio, of the printed numbers or of a corner.
    fn doubt(&self, ratio: f64, only_checked: bool) -> Option<Remark> {
        self.all().find_map(|prepared| judge::doubt(prepared, ratio, only_checked))
    }

    /// Result at one of several ratios over the tolerances.
    fn tried(&self, objective: &Objective, ratio: f64, only_checked: bool) -> Tried {
        let exceeded = self.tightest(ratio).filter(|m| m.margin < -FEASIBILITY_TOLERANCE);
        let doubt =
            || judge::may_change(&self.nominal, only_checked).then(|| self.doubt(ratio, only_checked)).flatten();
        match (exceeded, tried(&self.nominal, objective, ratio)) {
            (Some(margin), _) => Tried::Exceeds(margin),
            (None, kept @ Tried::Kept(..)) => doubt().map_or(kept, Tried::Doubt),
            (None, other) => other,
        }
    }

    /// The printed numbers, then the corners.
    fn all(&self) -> impl Iterator<Item = &Prepared<'p>> {
        std::iter::once(&self.nominal).chain(self.corners.iter().map(|(prepared, _)| prepared))
    }

    /// Unchecked limits and assumptions of the printed numbers and the corners at a ratio, without repetition.
    fn judged(&self, ratio: f64) -> Judged {
        let mut all = Judged::default();
        for Judged { unchecked, assumed } in self.all().map(|prepared| prepared.judged(ratio)) {
            for (told, new) in [(&mut all.unchecked, unchecked), (&mut all.assumed, assumed)] {
                let new: Vec<Remark> = new.into_iter().filter(|remark| !told.contains(remark)).collect();
                told.extend(new);
            }
        }
        let unchecked: Vec<&str> = all.unchecked.iter().map(|(limit, _)| *limit).collect();
        all.assumed.retain(|(limit, _)| !unchecked.contains(limit));
        all
    }

    /// The smallest margin over the limits of all corners at a ratio.
    fn tightest(&self, ratio: f64) -> Option<Margin> {
        self.limits().into_iter().map(|limit| margin(limit, ratio)).min_by(|a, b| a.margin.total_cmp(&b.margin))
    }

    fn design<'a>(
        &self,
        nominal: &Design<'a>,
        gear: Option<&'a str>,
        optimum: Optimum,
        verified: Verified,
    ) -> RobustDesign<'a> {
        let ratio = optimum.ratio;
        let objective = &self.nominal.candidate.joint.objective;
        let at_corners = self.corners.iter().filter_map(|(prepared, _)| prepared.objective_at(objective, ratio));
        let evaluation = Evaluation {
            energy: self.nominal.energy(ratio),
            peak_power: Some(self.nominal.peak_power(ratio)),
            ..self.nominal.at(ratio)
        };
        let Judged { unchecked, assumed } = self.judged(ratio);
        let tightest = self.tightest(ratio).into_iter().chain(verified.worst);
        RobustDesign {
            nominal: nominal.clone(),
            toleranced: self.all.to_vec(),
            corners: self.corners.iter().filter(|(_, corner)| corner.found_for != Some(HEAT)).count(),
            gear,
            unchecked,
            assumed,
            worst_objective: at_corners.fold(optimum.objective, f64::max),
            tightest: tightest.min_by(|a, b| a.margin.total_cmp(&b.margin)),
            unproven: verified.unproven,
            is_ended: false,
            evaluation,
            optimum,
        }
    }
}
