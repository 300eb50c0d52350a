//! Whether a design can be judged.
//!
//! The one idea: what is not known is not kept. A limit that the requirement itself states has to be judged; a design
//! of which it cannot be is told apart and is no choice. What a data sheet states and what only makes a limit less sharp
//! is *not checked*, which is said beside the design. Whether the requirement states something is a fact of the limit
//! ([`is_stated`]), so that whoever adds an unknown adds nothing here.

use super::Prepared;
use super::answer::{Design, Reason, Refused, Rejected, Unjudged};
use super::program::{Bind, Certificate, GAP_TOLERANCE, Optimum, RatioProgram, Window};
use super::solved::{Tried, best_listed, tried};
use gearwise_model::actuator::limits::{Remark, is_stated};
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Robot};

/// Of what could not be checked of a design, that which the requirement itself states.
pub fn unjudged(robot: &Robot, joint: &Joint, unchecked: &[Remark]) -> Vec<Remark> {
    unchecked.iter().filter(|(name, _)| is_stated(name, robot, joint)).copied().collect()
}

/// What rules a design out before it is solved, where only designs with every limit checked are wanted: an unknown
/// that the requirement does not state. (One that it states is told apart, if the design keeps all else.)
pub fn left_out(robot: &Robot, joint: &Joint, unchecked: &[Remark], only_checked: bool) -> Option<Remark> {
    let plain = |(name, _): &&Remark| only_checked && !is_stated(name, robot, joint);
    unchecked.iter().find(plain).copied()
}

/// A design that keeps every limit that could be judged, if it is a choice; else why not.
///
/// # Errors
/// It is left out, or a limit that the requirement states cannot be judged.
pub fn judged<'a>(
    robot: &Robot,
    joint: &Joint,
    design: Design<'a>,
    only_checked: bool,
) -> Result<Design<'a>, Refused<'a>> {
    if let Some((limit, why)) = left_out(robot, joint, &design.unchecked, only_checked) {
        let reason = Reason::Unchecked(limit, why);
        return Err(Refused::rejected(Rejected { motor: design.motor, gear: design.gear, reason }));
    }
    match unjudged(robot, joint, &design.unchecked) {
        because if because.is_empty() => Ok(design),
        because => Err(Refused::Unjudged(Box::new(Unjudged::of(design, because)))),
    }
}

/// What keeps a candidate from being a choice, by what is not known of it at a ratio.
pub(super) fn doubt(prepared: &Prepared, ratio: f64, only_checked: bool) -> Option<Remark> {
    doubt_of(prepared, &prepared.unchecked_at(ratio), only_checked)
}

fn doubt_of(prepared: &Prepared, unchecked: &[Remark], only_checked: bool) -> Option<Remark> {
    let (robot, joint) = (prepared.candidate.robot, prepared.candidate.joint);
    let plain = left_out(robot, joint, unchecked, only_checked);
    plain.or_else(|| unjudged(robot, joint, unchecked).first().copied())
}

/// Fewest and most ratios of a window that are looked at for whether they can be judged: fewer of many samples and candidates.
const LOOKS: (usize, usize) = (8, 100);

/// The optimum among the ratios at which its design is a choice, where some limit can be judged at some ratios only: its
/// windows are cut where that ends, and the ratio is moved into them. It stays as it is where no ratio can be judged.
pub(super) fn judged_part(prepared: &Prepared, optimum: Optimum, only_checked: bool) -> Optimum {
    if !may_change(prepared, only_checked) || doubt_of(prepared, &prepared.unchecked, only_checked).is_some() {
        return optimum;
    }
    let doubt = |ratio: f64| doubt(prepared, ratio, only_checked);
    let joint = prepared.candidate.joint;
    let Some(values) = joint.ratio.listed().filter(|_| prepared.candidate.catalog_gear.is_none()) else {
        return within(prepared, optimum, Doubts { count: 1, of: &|_, ratio| doubt(ratio) });
    };
    let look = |ratio: f64| match (tried(prepared, &joint.objective, ratio), doubt(ratio)) {
        (Tried::Kept(..), Some(why)) => Tried::Doubt(why),
        (tried, _) => tried,
    };
    best_listed(values.iter().copied(), look).unwrap_or(optimum)
}

/// Whether a candidate may be a choice at some ratios only, by what is not known of it.
pub(super) fn may_change(prepared: &Prepared, only_checked: bool) -> bool {
    let (robot, joint) = (prepared.candidate.robot, prepared.candidate.joint);
    prepared.judged_at_ratio().any(|name| only_checked || is_stated(name, robot, joint))
}

/// Doubts about a ratio, of each of several candidates. On the way from a ratio without doubt each has it from some ratio on.
#[derive(Clone, Copy)]
pub(super) struct Doubts<'d> {
    pub(super) count: usize,
    /// By the number of the candidate and the ratio.
    pub(super) of: &'d dyn Fn(usize, f64) -> Option<Remark>,
}

impl Doubts<'_> {
    fn at(self, ratio: f64) -> Option<Remark> {
        (0..self.count).find_map(|k| (self.of)(k, ratio))
    }

    /// The last ratio without doubt on the way from one without to one with, and the doubt beyond it.
    fn edge(self, good: f64, bad: f64, mut why: Remark) -> (f64, Remark) {
        let mut reach = bad;
        for k in 0..self.count {
            // One without doubt as far as the others reach has none nearer.
            let Some(own) = (self.of)(k, reach) else { continue };
            let (mut low, mut high) = (good, reach);
            why = own;
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                match (self.of)(k, middle) {
                    None => low = middle,
                    Some(other) => (high, why) = (middle, other),
                }
            }
            reach = low;
        }
        (reach, why)
    }
}

/// The optimum among the ratios without doubt, as [`judged_part`] says.
pub(super) fn within(prepared: &Prepared, optimum: Optimum, doubts: Doubts) -> Optimum {
    let windows: Vec<Window> = optimum.windows.iter().flat_map(|w| parts(prepared, w, optimum.ratio, doubts)).collect();
    if windows.is_empty() || windows == optimum.windows {
        return optimum;
    }
    if windows.iter().any(|w| w.min <= optimum.ratio && optimum.ratio <= w.max) {
        return Optimum { windows, ..optimum };
    }
    let objective = &prepared.candidate.joint.objective;
    let value = |n: f64| prepared.at_in_full(n).objective(objective).unwrap_or(f64::INFINITY);
    let intervals: Vec<(f64, f64)> = windows.iter().map(|w| (w.min, w.max)).collect();
    let valley = RatioProgram::least_over(&value, &intervals).filter(|(n, _)| doubts.at(*n).is_none());
    let ends = intervals.iter().flat_map(|(a, b)| [*a, *b]).map(|n| (n, value(n)));
    let Some((ratio, objective)) = valley.into_iter().chain(ends).min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return optimum;
    };
    let certificate = match optimum.certificate {
        Certificate::Certified { lower_bound, method, .. }
            if objective - lower_bound <= GAP_TOLERANCE * objective.abs() =>
        {
            Certificate::Certified { lower_bound, gap: (objective - lower_bound).max(0.0) / objective.abs(), method }
        }
        _ => Certificate::NotCertified("a better ratio cannot be judged".into()),
    };
    Optimum { ratio, objective, windows, certificate, shadow_prices: Vec::new() }
}

/// The parts of a window without doubt.
fn parts(prepared: &Prepared, window: &Window, ratio: f64, doubts: Doubts) -> Vec<Window> {
    let samples = prepared.candidate.joint.motion.len().max(1) * doubts.count.max(1);
    let looks = (200_000 / samples).clamp(LOOKS.0, LOOKS.1);
    let mut ratios = if window.max > window.min { grid(window.min, window.max, looks) } else { vec![window.min] };
    ratios.extend((window.min < ratio && ratio < window.max).then_some(ratio));
    ratios.sort_by(f64::total_cmp);
    let seen: Vec<(f64, Option<Remark>)> = ratios.into_iter().map(|n| (n, doubts.at(n))).collect();
    let edge = |good: f64, bad: f64, why: Remark| {
        let (reach, why) = doubts.edge(good, bad, why);
        (reach, Bind { limit: why.0, sample: None, unjudged: Some(why.1) })
    };
    let mut parts: Vec<Window> = Vec::new();
    let mut open: Option<(f64, Bind)> = None;
    for (k, (n, why)) in seen.iter().enumerate() {
        let before = k.checked_sub(1).map(|before| seen[before]);
        match (why, before, &open) {
            (None, None, _) => open = Some((window.min, window.low.clone())),
            (None, Some((bad, Some(why))), None) => open = Some(edge(*n, bad, why)),
            (Some(why), Some((good, _)), Some(_)) => {
                let (max, high) = edge(good, *n, *why);
                parts.extend(open.take().map(|(min, low)| Window { min, max, low, high }));
            }
            _ => {}
        }
    }
    parts.extend(open.map(|(min, low)| Window { min, max: window.max, low, high: window.high.clone() }));
    parts
}
