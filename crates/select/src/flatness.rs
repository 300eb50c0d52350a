//! How much a free ratio may leave its best one, and whether the requirement's own range of ratios decided it.
//!
//! The one idea: near its best ratio an objective is flat, and a gear that is near is as good. The ratios about N* at which
//! every limit is kept and the objective is at most a little above its least are walked to from N* outwards, and never
//! further than they were found: what lies behind a hole is not among them.

use super::Prepared;
use super::answer::Design;
use super::judge;
use super::mount::{Mount, load_through};
use super::program::{Optimum, RatioProgram, Window};
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Robot};

/// By how much (relative) the objective may be above its least within the flat part.
pub const WITHIN: f64 = 0.03;
/// Steps of the walk from N* to each end of its window, where the program is not convex.
const STEPS: usize = 48;
/// Halvings of the bracket at an end of the flat part.
const HALVINGS: usize = 48;

/// The ratios about N* that are nearly as good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flatness {
    /// Smallest of them.
    pub from: f64,
    /// Largest of them.
    pub to: f64,
    /// The objective is at most so much above its least (relative).
    pub within: f64,
    /// Whether that is proved of every ratio between: the objective has one valley, and the window is proved. Else the
    /// ratios on the way were evaluated.
    pub proved: bool,
}

/// An end of the requirement's range at which the best ratio stands, with better ones behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OwnBound {
    /// The end of the range.
    pub ratio: f64,
    /// Whether it is the largest ratio that is allowed; else the smallest.
    pub is_largest: bool,
    /// A ratio beyond it that keeps every limit.
    pub beyond: f64,
    /// How much less the objective is there (relative, above zero).
    pub saves: f64,
}

/// Looks at a design's candidate with its limits, and with its spring where it has one. `None` where a gear of the
/// catalogue fixes the ratio.
pub fn at_design<T>(robot: &Robot, joint: &Joint, design: &Design, look: impl FnOnce(&Prepared) -> T) -> Option<T> {
    if design.gear.is_some() || joint.ratio.is_catalog() {
        return None;
    }
    let sprung = sprung(joint, design)?;
    let load = load_through(&sprung, None);
    let prepared = Mount::new(robot, &sprung, &load, design.motor).prepared().ok()?;
    Some(look(&prepared))
}

/// The joint with the spring of a design taking its part of the load.
pub(super) fn sprung(joint: &Joint, design: &Design) -> Option<Joint> {
    let Some(spring) = &design.spring else { return Some(joint.clone()) };
    joint.with_spring(spring.stiffness, spring.rest_angle.unwrap_or(0.0))
}

/// Whether a share of an objective means something.
fn is_measure(objective: f64) -> bool {
    objective > 0.0 && objective.is_finite()
}

fn objective_at(prepared: &Prepared, joint: &Joint, ratio: f64) -> f64 {
    prepared.at_in_full(ratio).objective(&joint.objective).unwrap_or(f64::INFINITY)
}

/// Whether a ratio keeps every limit, and what the requirement states can be judged there.
fn is_kept(prepared: &Prepared, ratio: f64) -> bool {
    prepared.at(ratio).feasible && judge::doubt(prepared, ratio, false).is_none()
}

/// The ratios about the best one that are nearly as good, with a spring held. `None` where only certain ratios may be
/// chosen, or a share of the objective means nothing because it is not above zero.
pub fn flatness(prepared: &Prepared, joint: &Joint, optimum: &Optimum) -> Option<Flatness> {
    let window = optimum.window();
    if joint.ratio.listed().is_some() || window.max <= window.min || !is_measure(optimum.objective) {
        return None;
    }
    let most = optimum.objective * (1.0 + WITHIN);
    let best = optimum.ratio.clamp(window.min, window.max);
    let (min, max) = joint.ratio.range()?;
    let has_one_valley = RatioProgram::new(prepared, &joint.objective, min, max).has_one_valley();
    let proved = has_one_valley && !judge::may_change(prepared, false);
    let is_near = |ratio: f64| objective_at(prepared, joint, ratio) <= most && (proved || is_kept(prepared, ratio));
    let end = |outer: f64| {
        let stops = if proved { vec![outer] } else { stops(joint, window, best, outer) };
        let mut good = best;
        for stop in stops {
            if !is_near(stop) {
                return last_near(&is_near, good, stop);
            }
            good = stop;
        }
        good
    };
    let (from, to) = (end(window.min), end(window.max));
    Some(Flatness { from, to, within: WITHIN, proved })
}

/// Ratios on the way from the best one to an end of its window; where the mass steps, the ratios about the step too.
fn stops(joint: &Joint, window: &Window, best: f64, outer: f64) -> Vec<f64> {
    if best == outer {
        return Vec::new();
    }
    let mut stops = grid(best.min(outer), best.max(outer), STEPS + 1);
    if let Some((_, stage)) = joint.gear.mass_per_stage {
        let powers = std::iter::successors(Some(1.0), |n| Some(n * stage)).take_while(|n| *n < window.max);
        let edges = powers.flat_map(|n| [n, n * (1.0 + 1e-8)]);
        stops.extend(edges.filter(|n| best.min(outer) < *n && *n < best.max(outer)));
    }
    stops.sort_by(f64::total_cmp);
    if outer < best {
        stops.reverse();
    }
    stops.retain(|n| *n != best);
    stops
}

/// The last near ratio on the way from a near one to one that is not.
fn last_near(is_near: &dyn Fn(f64) -> bool, mut good: f64, mut bad: f64) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (good + bad);
        if is_near(middle) { good = middle } else { bad = middle }
    }
    good
}

/// How far beyond an end of the range it is looked: the first of them that keeps every limit is told.
const BEYOND: [f64; 3] = [0.1, 0.02, 0.001];
/// A smaller saving is none.
const LEAST_SAVING: f64 = 1e-6;

/// Whether the requirement's own range of ratios decided the best one: it stands at an end of the range, and behind
/// that end a ratio keeps every limit and has a smaller objective.
pub fn own_bound(prepared: &Prepared, joint: &Joint, optimum: &Optimum) -> Option<OwnBound> {
    let (min, max) = joint.ratio.range()?;
    if max <= min || !is_measure(optimum.objective) {
        return None;
    }
    let stands_at = |end: f64| (optimum.ratio - end).abs() <= 1e-9 * end;
    let (ratio, is_largest) = match (stands_at(min), stands_at(max)) {
        (true, _) => (min, false),
        (_, true) => (max, true),
        _ => return None,
    };
    let beyond = |far: f64| if is_largest { ratio * (1.0 + far) } else { ratio / (1.0 + far) };
    BEYOND.into_iter().map(beyond).filter(|beyond| prepared.says_gear_at(*beyond)).find_map(|beyond| {
        let saves = 1.0 - objective_at(prepared, joint, beyond) / optimum.objective;
        let is_better = saves > LEAST_SAVING && is_kept(prepared, beyond);
        is_better.then_some(OwnBound { ratio, is_largest, beyond, saves })
    })
}

/// The share by which a value is above the best objective, where that has a meaning.
pub(super) fn above(value: f64, best: f64) -> Option<f64> {
    (best > 0.0).then(|| value / best - 1.0)
}
