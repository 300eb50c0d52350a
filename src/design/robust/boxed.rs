//! One motor over the box of its tolerances.

use super::RobustDesign;
use super::corners::{Corner, Toleranced, corners, limits_of, toleranced, unproved};
use crate::actuator::limits::Remark;
use crate::catalog::Motor;
use crate::design::answer::{Design, Reason, Unusable};
use crate::design::evaluate::{Evaluation, FEASIBILITY_TOLERANCE, Judged, Margin, Prepared};
use crate::design::judge;
use crate::design::mount::{Mount, Site};
use crate::design::program::{Certificate, Limited, Optimum, RatioProgram, Unsolved};
use crate::design::selection::Selection;
use crate::design::solved::{Tried, best_listed, one_gear, tried};
use crate::requirement::Objective;

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
        });
    }
    let corners = corners(motor).map_err(|column| Reason::NotSolved(Unsolved::ToleranceReachesZero(column)))?;
    let over = Over { site, nominal, toleranced: all, corners: &corners, only_checked };
    if site.is_geared_with(nominal.motor) { over.gears() } else { over.ratios() }
}

/// A design whose tolerances are looked at.
struct Over<'a, 'o> {
    site: Site<'a, 'o>,
    nominal: &'o Design<'a>,
    toleranced: Vec<Toleranced>,
    corners: &'o [Corner],
    only_checked: bool,
}

impl<'a> Over<'a, '_> {
    /// The best ratio that keeps all limits over the tolerances.
    fn ratios(self) -> Result<RobustDesign<'a>, Reason> {
        let Over { site, nominal, toleranced, corners, only_checked } = self;
        let mount = site.direct(nominal.motor);
        let Some(range) = mount.range() else { return Err(Reason::Unusable(Unusable::NoGearFits)) };
        let boxed = Boxed::new(mount, corners).map_err(Reason::Unusable)?;
        if let Some(values) = site.joint.ratio.listed() {
            let mut optimum =
                best_listed(values.iter().copied(), |ratio| boxed.tried(&site.joint.objective, ratio, only_checked))?;
            if let Some(why) = unproved(&boxed.nominal, &toleranced) {
                optimum.certificate = Certificate::NotCertified(why.into());
            }
            return Ok(boxed.design(nominal, toleranced, None, optimum));
        }
        let limits = limits_of(&boxed.nominal, &boxed.corners);
        let program = RatioProgram::under(&boxed.nominal, &site.joint.objective, range, limits);
        let mut optimum = program.solve()?;
        if let Some(why) = unproved(&boxed.nominal, &toleranced) {
            optimum.certificate = Certificate::NotCertified(why.into());
        }
        if judge::may_change(&boxed.nominal, only_checked) {
            optimum = judge::within(&boxed.nominal, optimum, &|ratio| boxed.doubt(ratio, only_checked));
            if let Some(doubt) = boxed.doubt(optimum.ratio, only_checked) {
                return Err(Reason::Unjudged(vec![doubt]));
            }
        }
        Ok(boxed.design(nominal, toleranced, None, optimum))
    }

    /// The best gear with which all limits are kept over the tolerances.
    fn gears(self) -> Result<RobustDesign<'a>, Reason> {
        let Over { site, nominal, toleranced, corners, only_checked } = self;
        let mut gears: Selection<(&'a str, Boxed, Optimum)> = Selection::new(nominal.motor);
        for mount in site.mounts(nominal.motor) {
            let (Some(gear), Ok(boxed)) = (mount.gear, Boxed::new(mount, corners)) else { continue };
            // With another gear than the nominal one other limits may be unknown.
            if let Some(doubt) = boxed.doubt(gear.ratio, only_checked) {
                gears.mention(&gear.id, Reason::Unjudged(vec![doubt]));
                continue;
            }
            let tightest = boxed.tightest(gear.ratio);
            if let Some(margin) = tightest.filter(|m| m.margin < -FEASIBILITY_TOLERANCE) {
                gears.exceeds(&gear.id, Some(&margin));
                continue;
            }
            let here = boxed.nominal.at(gear.ratio);
            let Some(objective) = here.objective(&site.joint.objective) else {
                gears.passed();
                continue;
            };
            let mut optimum = one_gear(gear.ratio, objective, "all gears evaluated");
            if let Some(why) = unproved(&boxed.nominal, &toleranced) {
                optimum.certificate = Certificate::NotCertified(why.into());
            }
            gears.take(false, (objective, here.loss), (&gear.id, boxed, optimum));
        }
        let (gear, boxed, optimum) = gears.best()?;
        Ok(boxed.design(nominal, toleranced, Some(gear), optimum))
    }
}

/// A motor with a gear, at its printed numbers and at all corners.
struct Boxed<'p> {
    nominal: Prepared<'p>,
    corners: Vec<(Prepared<'p>, Corner)>,
}

impl<'p> Boxed<'p> {
    fn new(mount: Mount<'p, 'p>, corners: &'p [Corner]) -> Result<Boxed<'p>, Unusable> {
        // A module's gear is its own at each corner.
        let prepare = |motor: &'p Motor| Mount { motor, ..mount }.with_gear(mount.gear).prepared();
        let corners = corners.iter().map(|c| Ok((prepare(&c.motor)?, c.clone())));
        Ok(Boxed { nominal: prepare(mount.motor)?, corners: corners.collect::<Result<_, _>>()? })
    }

    /// What keeps the printed numbers or a corner from being a choice at a ratio, by what is not known.
    fn doubt(&self, ratio: f64, only_checked: bool) -> Option<Remark> {
        self.all().find_map(|prepared| judge::doubt(prepared, ratio, only_checked))
    }

    /// What becomes of one of several ratios over the tolerances.
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

    /// What is to be said of the printed numbers or of a corner at a ratio, each once.
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
        let margin = |Limited { candidate, asked }: Limited| {
            Margin::new(&asked.at(candidate, ratio), candidate, ratio, asked.raw_demand(candidate, ratio))
        };
        limits_of(&self.nominal, &self.corners).into_iter().map(margin).min_by(|a, b| a.margin.total_cmp(&b.margin))
    }

    fn design<'a>(
        &self,
        nominal: &Design<'a>,
        toleranced: Vec<Toleranced>,
        gear: Option<&'a str>,
        optimum: Optimum,
    ) -> RobustDesign<'a> {
        let ratio = optimum.ratio;
        let objective = &self.nominal.candidate.joint.objective;
        let at_corners = self.corners.iter().filter_map(|(prepared, _)| prepared.at(ratio).objective(objective));
        let evaluation = Evaluation {
            energy: self.nominal.energy(ratio),
            peak_power: Some(self.nominal.peak_power(ratio)),
            ..self.nominal.at(ratio)
        };
        let Judged { unchecked, assumed } = self.judged(ratio);
        RobustDesign {
            nominal: nominal.clone(),
            toleranced,
            corners: self.corners.len(),
            gear,
            unchecked,
            assumed,
            worst_objective: at_corners.fold(optimum.objective, f64::max),
            tightest: self.tightest(ratio),
            evaluation,
            optimum,
        }
    }
}
