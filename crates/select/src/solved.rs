//! One mount, solved: its best ratio, and the design there.

use super::answer::{Design, Reason, Unusable};
use super::evaluate::{Judged, Margin};
use super::mount::Mount;
use super::program::{Bind, Certificate, Infeasible, Optimum, RatioProgram, Window};
use super::{Evaluation, Prepared};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::requirement::{Joint, Objective, Quantity};

/// The best ratio, or why there is none: of all between two, or of those between them that the joint lists.
pub(super) fn solve(prepared: &Prepared, joint: &Joint, (min, max): (f64, f64)) -> Result<Optimum, Reason> {
    let Some(values) = joint.ratio.listed() else {
        return Ok(RatioProgram::new(prepared, &joint.objective, min, max).solve()?);
    };
    let between = values.iter().copied().filter(|n| min <= *n && *n <= max);
    best_listed(between, |ratio| tried(prepared, &joint.objective, ratio))
}

/// What became of one of several ratios.
pub(super) enum Tried {
    /// It keeps every limit: objective and loss \[W\].
    Kept(f64, f64),
    /// It exceeds limits; the smallest margin.
    Exceeds(Margin),
    /// It keeps what can be judged; what cannot be.
    Doubt(Remark),
    /// It has no objective.
    Without(Unusable),
}

/// A candidate at one of several ratios.
pub(super) fn tried(prepared: &Prepared, objective: &Objective, ratio: f64) -> Tried {
    let there = prepared.at(ratio);
    match there.tightest().filter(|_| !there.feasible) {
        Some(margin) => Tried::Exceeds(*margin),
        None => match prepared.at_in_full(ratio).objective(objective) {
            Some(value) => Tried::Kept(value, there.loss),
            None if objective.weight(Quantity::Mass) > 0.0 && there.mass.is_none() => Tried::Without(Unusable::Mass),
            None => Tried::Without(Unusable::Durations),
        },
    }
}

/// The best of several ratios: all are evaluated, which is the proof. Its windows go from the first to the last of listed
/// ratios, one behind another, that are kept.
///
/// # Errors
/// None is kept: what the one that comes nearest exceeds.
pub(super) fn best_listed(
    values: impl IntoIterator<Item = f64>,
    look: impl Fn(f64) -> Tried,
) -> Result<Optimum, Reason> {
    let all: Vec<(f64, Tried)> = values.into_iter().map(|n| (n, look(n))).collect();
    let kept = all.iter().filter_map(|(n, tried)| match tried {
        Tried::Kept(objective, loss) => Some((*objective, *loss, *n)),
        _ => None,
    });
    let Some((objective, _, ratio)) = kept.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))) else {
        return Err(why_none(&all));
    };
    Ok(Optimum {
        ratio,
        objective,
        windows: runs(&all),
        certificate: Certificate::Certified { lower_bound: objective, gap: 0.0, method: "all listed ratios evaluated" },
        shadow_prices: Vec::new(),
    })
}

/// Why none of several ratios will do: the one that comes nearest.
fn why_none(all: &[(f64, Tried)]) -> Reason {
    let exceeds = all.iter().filter_map(|(n, tried)| match tried {
        Tried::Exceeds(margin) => Some((n, margin)),
        _ => None,
    });
    let nearest = exceeds.max_by(|a, b| a.1.margin.total_cmp(&b.1.margin));
    let unknown = all.iter().find_map(|(_, tried)| match tried {
        Tried::Doubt(remark) => Some(Reason::Unjudged(vec![*remark])),
        Tried::Without(why) => Some(Reason::Unusable(why.clone())),
        _ => None,
    });
    let nearest = nearest.map(|(ratio, margin)| {
        let bind = Bind::of(margin.limit, margin.sample);
        let (least, allowed) = (margin.demand / margin.bound, margin.bound);
        Reason::Infeasible(Infeasible::Nowhere { bind, least, allowed, ratio: *ratio })
    });
    unknown.or(nearest).unwrap_or(Reason::Unusable(Unusable::NoGearFits))
}

/// The runs of listed ratios that are kept, each with what forbids its neighbours.
fn runs(all: &[(f64, Tried)]) -> Vec<Window> {
    let bind = |tried: &Tried| match tried {
        Tried::Exceeds(margin) => Bind::of(margin.limit, margin.sample),
        Tried::Doubt((limit, why)) => Bind { limit, sample: None, unjudged: Some(why) },
        Tried::Kept(..) | Tried::Without(_) => Bind::of("objective", None),
    };
    let is_kept = |tried: &Tried| matches!(tried, Tried::Kept(..));
    let mut windows: Vec<Window> = Vec::new();
    let mut before: Option<&Tried> = None;
    for (ratio, tried) in all {
        match (before.is_some_and(is_kept), is_kept(tried)) {
            (false, true) => {
                let low = before.map_or_else(|| Bind::of("ratio_min", None), bind);
                windows.push(Window { min: *ratio, max: *ratio, low, high: Bind::of("ratio_max", None) });
            }
            (true, true) => windows.last_mut().into_iter().for_each(|w| w.max = *ratio),
            (true, false) => windows.last_mut().into_iter().for_each(|w| w.high = bind(tried)),
            (false, false) => {}
        }
        before = Some(tried);
    }
    windows
}

/// The design of a mount at its optimum.
pub(super) fn design<'a>(mount: &Mount<'a, '_>, prepared: &Prepared, optimum: Optimum) -> Design<'a> {
    let ratio = optimum.ratio;
    // For one design the costlier figures are worth their time.
    let evaluation = Evaluation {
        energy: prepared.energy(ratio),
        peak_power: Some(prepared.peak_power(ratio)),
        ..prepared.at(ratio)
    };
    let Judged { unchecked, assumed } = prepared.judged(ratio);
    Design {
        motor: mount.motor,
        gear: mount.gear_id(),
        evaluation,
        unchecked,
        assumed,
        winding_temperature: prepared.winding_temperature(ratio),
        reversal_time: prepared.reversal_time(ratio),
        spring: None,
        optimum,
    }
}

/// The only ratio of a gear as an optimum, with what proves that there is no better.
pub(super) fn one_gear(ratio: f64, objective: f64, method: &'static str) -> Optimum {
    let bind = Bind::of("gear", None);
    Optimum {
        ratio,
        objective,
        windows: vec![Window { min: ratio, max: ratio, low: bind.clone(), high: bind }],
        certificate: Certificate::Certified { lower_bound: objective, gap: 0.0, method },
        shadow_prices: Vec::new(),
    }
}
