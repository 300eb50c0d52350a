//! The program evaluated on a refined grid: the best ratio and the windows that were seen. A start for
//! the branch and bound, which alone proves.

use super::objective::Goal;
use super::{Bind, Class, End, Infeasible, Limited, RatioProgram, Window};
use crate::evaluate::{FEASIBILITY_TOLERANCE, violation};
use gearwise_model::actuator::limits::{Asked, Demand};
use gearwise_model::numerics::line_search::{FULLY, crossing, golden_section, least_in_few_looks};
use gearwise_model::numerics::work;

/// What exceeds a limit by this (relative) exceeds it for everyone: more than any tolerance with which limits
/// are looked at.
pub(super) const CLEARLY: f64 = 1e-7;

/// Points of the first grid, evenly spaced in ln N.
const POINTS: usize = 1000;
/// Range of ln N from which the grid has all of them.
const WIDE: f64 = 2.0;
/// The same where effects have to be evaluated at each of them.
const EVALUATED_POINTS: usize = 300;
/// The same where a weakened field is evaluated at each of them: the branch and bound sees what lies between.
const WEAKENED_POINTS: usize = 100;
/// Narrowings of a valley there.
const WEAKENED_STEPS: usize = 40;
/// Points of the first grid if the iron saturates: each mean is a sum over all samples.
const SATURATED_POINTS: usize = 200;
/// Points of the objective if the iron saturates: the branch and bound refines them.
const SATURATED_VALUES: usize = 50;
/// Points of a grid that are looked at first, and narrowings of a valley, once the program's share of the work is done.
const SPENT_POINTS: usize = 25;
const SPENT_STEPS: usize = 8;
/// A limit that is kept by a current along d is met with equality: what differs by no more than this is rounding.
const EQUALITY: f64 = 1e-10;
/// Share by which a demand may be below another's for rounding.
const FLOOR: f64 = 1e-12;
/// How near the end of a window is found where ratios are evaluated (relative).
const END: f64 = 1e-13;

/// What the grid shows.
pub(super) struct Found {
    /// The best feasible ratio that was seen; else the limit that was nearest to be kept.
    pub(super) best: Result<f64, Infeasible>,
    /// The windows that were seen.
    pub(super) windows: Vec<Window>,
}

/// A valley of the excess between two points of the grid (sign 1), or a hill (sign −1).
struct Turn {
    ends: (f64, f64),
    sign: f64,
    /// Whether it is certain, without a look, that nothing between the ends is feasible.
    certain: bool,
}

/// A window of a single ratio.
pub(super) fn point(program: &RatioProgram, ratio: f64) -> Window {
    let bind = worst(program, ratio).1.unwrap_or(Bind::of("ratio_min", None));
    Window { min: ratio, max: ratio, low: bind.clone(), high: bind }
}

/// What is known of the limits that take a walk, at a point of the grid where the others are kept.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Walk {
    /// They have to be looked at.
    Open,
    /// They are kept here, and from here to the next point.
    Kept,
    /// One is exceeded here, and from here to the next point.
    Exceeded,
}

/// Intervals of no more points than this are not divided further.
const FEW: usize = 4;

/// What a few walks say of many points: an interval of the grid on which a limit is certainly kept or certainly exceeded is
/// not looked at point by point.
fn walks(program: &RatioProgram, grid: &[f64], cheap: &[f64]) -> Vec<Walk> {
    let dear: Vec<&Limited> = program.limits.iter().filter(|l| l.asked.demand.takes_a_walk()).collect();
    let mut known = vec![Walk::Open; grid.len()];
    let over = |first: usize, last: usize| (grid[first], grid[(last + 1).min(grid.len() - 1)]);
    let says = |l: &Limited, (a, b): (f64, f64)| match l.asked.demand {
        Demand::WindingPeak(node) if l.asked.bound > 0.0 => {
            let (load, actuator, bound) = (l.asked.load(l.candidate), l.candidate.end(l.asked.end), l.asked.bound);
            if load.winding_peak_stays_within(actuator, &node, (a, b), bound) {
                Walk::Kept
            } else if load.winding_peak_is_beyond(actuator, &node, (a, b), bound * (1.0 + CLEARLY)) {
                Walk::Exceeded
            } else {
                Walk::Open
            }
        }
        _ => Walk::Open,
    };
    let mut open = Vec::new();
    let mut first = 0;
    while first < grid.len() {
        let same = |k: &usize| (cheap[*k] <= FEASIBILITY_TOLERANCE) == (cheap[first] <= FEASIBILITY_TOLERANCE);
        let last = (first..grid.len()).take_while(same).last().unwrap_or(first);
        if cheap[first] <= FEASIBILITY_TOLERANCE {
            open.push((first, last));
        }
        first = last + 1;
    }
    while let Some((first, last)) = open.pop().filter(|_| !work::is_spent()) {
        let said: Vec<Walk> = dear.iter().map(|l| says(l, over(first, last))).collect();
        let all = if said.contains(&Walk::Exceeded) {
            Walk::Exceeded
        } else if said.iter().all(|walk| *walk == Walk::Kept) {
            Walk::Kept
        } else {
            if last - first >= FEW {
                let middle = first + (last - first) / 2;
                open.extend([(first, middle), (middle + 1, last)]);
            }
            continue;
        };
        known[first..=last].fill(all);
    }
    known
}

pub(super) fn scan(program: &RatioProgram, goal: &Goal, low: &End, high: &End) -> Found {
    let (min, max) = (low.ratio, high.ratio);
    let excess = |n: f64| worst(program, n).0;
    let apart = Apart::new(program);
    let count = count(program, (min, max));
    let grid = if max / min - 1.0 < 1e-12 { vec![min] } else { gearwise_model::numerics::grid::grid(min, max, count) };
    let without_walks = program.without_walks().filter(|_| !program.is_evaluated());
    let cheap: Option<Vec<f64>> = without_walks.map(|cheap| {
        let cheap = Apart::new(&cheap);
        grid.iter().map(|n| cheap.excess(*n)).collect()
    });
    let known = cheap.as_ref().map_or_else(|| vec![Walk::Kept; grid.len()], |cheap| walks(program, &grid, cheap));
    let value = |k: usize| match (&cheap, known[k]) {
        (None, _) => apart.excess(grid[k]),
        (Some(cheap), Walk::Open) if cheap[k] <= FEASIBILITY_TOLERANCE => excess(grid[k]),
        (Some(cheap), Walk::Exceeded) => cheap[k].max(CLEARLY),
        (Some(cheap), _) => cheap[k],
    };
    // A few points of all first, and the others while the work lasts.
    let every = (grid.len() / SPENT_POINTS).max(1);
    let (few, rest): (Vec<usize>, Vec<usize>) = (0..grid.len()).partition(|k| k % every == 0 || k + 1 == grid.len());
    let looked = few.into_iter().map(Some).chain(rest.into_iter().map(|k| (!work::is_spent()).then_some(k))).flatten();
    let mut seen_at: Vec<(usize, f64)> = looked.map(|k| (k, value(k))).collect();
    seen_at.sort_by_key(|(k, _)| *k);
    let known: Vec<Walk> = seen_at.iter().map(|(k, _)| known[*k]).collect();
    let mut points: Vec<(f64, f64)> = seen_at.into_iter().map(|(k, excess)| (grid[k], excess)).collect();
    // A window, or a gap in one, that is narrower than the grid shows as a valley, or a hill, of the
    // excess: look at its bottom, or its top.
    let mut turns: Vec<Turn> = Vec::new();
    for i in 0..points.len() {
        let (left, right) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
        let here = points[i];
        // Where the winding's temperature runs away there is no slope to follow; nor where it is exceeded all over.
        let plain = known[i] == Walk::Exceeded && (i == 0 || known[i - 1] == Walk::Exceeded);
        if left.0 >= right.0 || here.1 == f64::INFINITY || plain {
            continue;
        }
        if here.1 == left.1 && here.1 == right.1 {
            continue;
        }
        if here.1 > 0.0 && here.1 <= left.1 && here.1 <= right.1 {
            // Some valleys lie where every ratio is out of the question.
            let certain = !program.is_evaluated() && program.is_broken_between(left.0, right.0);
            turns.push(Turn { ends: (left.0, right.0), sign: 1.0, certain });
        } else if here.1 <= 0.0 && here.1 >= left.1 && here.1 >= right.1 {
            turns.push(Turn { ends: (left.0, right.0), sign: -1.0, certain: false });
        }
    }
    let feasible = |e: f64| e <= FEASIBILITY_TOLERANCE;
    let mut seen: Vec<Option<(f64, f64)>> =
        turns.iter().map(|t| (!t.certain && !work::is_spent()).then(|| apart.turn(t))).collect();
    if !points.iter().chain(seen.iter().flatten()).any(|p| feasible(p.1)) {
        // Nothing is feasible: which ratio came nearest is told, and may be the bottom of any valley.
        seen = turns
            .iter()
            .zip(seen)
            .map(|(t, seen)| seen.or_else(|| (!work::is_spent()).then(|| apart.turn(t))))
            .collect();
    }
    points.extend(seen.into_iter().flatten());
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut windows: Vec<Window> = Vec::new();
    let mut open: Option<(f64, Bind)> = None;
    for i in 0..points.len() {
        let (n, e) = points[i];
        if feasible(e) && open.is_none() {
            open = Some(match i {
                0 => (n, low.bind.clone()),
                _ => boundary(program, points[i - 1].0, n),
            });
        }
        if !feasible(e)
            && let Some((start, bind)) = open.take()
        {
            let (end, high) = boundary(program, n, points[i - 1].0);
            windows.push(Window { min: start, max: end, low: bind, high });
        }
    }
    if let Some((start, bind)) = open.take() {
        windows.push(Window { min: start, max, low: bind, high: high.bind.clone() });
    }
    let best = best_of(program, goal, &windows).map(|(n, _)| n).ok_or_else(|| nowhere(program, &points));
    Found { best, windows }
}

/// The limit that is most exceeded at a ratio: its relative excess, and itself. A limit that takes a walk over all samples
/// counts only where the others are kept: whether a ratio is feasible is the same, and by how much it is not is no more.
pub(super) fn worst(program: &RatioProgram, ratio: f64) -> (f64, Option<Bind>) {
    worst_by(program, ratio, None, FEASIBILITY_TOLERANCE)
}

/// A program whose sums over all samples are apart from its other limits.
struct Apart<'p, 'a> {
    whole: &'p RatioProgram<'a>,
    sums: Vec<Limited<'a>>,
    others: RatioProgram<'a>,
}

impl<'p, 'a> Apart<'p, 'a> {
    fn new(whole: &'p RatioProgram<'a>) -> Apart<'p, 'a> {
        let is_sum = |l: &Limited| is_convex(l.asked) && matches!(l.asked.demand, Demand::MeanCurrentSquared(_));
        let (sums, limits) = whole.limits.iter().copied().partition(|l| is_sum(l) && !whole.is_evaluated());
        Apart { whole, sums, others: RatioProgram { limits, ..*whole } }
    }

    /// Bounds of the excess of [`worst`]; without sums it is both.
    fn bounds(&self, ratio: f64) -> [f64; 2] {
        let of_sum = |l: &Limited| {
            let bounds = l.asked.raw_between(l.candidate, ratio).unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            bounds.map(|raw| violation(raw, l.asked.raw_bound()))
        };
        let others = worst(&self.others, ratio).0;
        self.sums.iter().map(of_sum).fold([others; 2], |[a, b], [least, most]| [a.max(least), b.max(most)])
    }

    /// The excess of [`worst`], or a bound of it that shows as well whether the limits are kept: from above where they are,
    /// from below where they are not.
    fn excess(&self, ratio: f64) -> f64 {
        let [least, most] = self.bounds(ratio);
        match () {
            () if most <= 0.0 => most,
            () if least > CLEARLY || least == most => least,
            () => worst(self.whole, ratio).0,
        }
    }

    /// The bottom of a valley, or the top of a hill, and the excess there, or a bound of it that shows as well that nothing is
    /// hidden there.
    fn turn(&self, turn: &Turn) -> (f64, f64) {
        let of = |excess: &dyn Fn(f64) -> f64| {
            let n = bottom(self.whole, &|n| turn.sign * excess(n), turn.ends.0, turn.ends.1);
            (n, excess(n))
        };
        if !self.sums.is_empty() {
            let is_valley = turn.sign > 0.0;
            let (n, bound) = of(&|n| self.bounds(n)[usize::from(!is_valley)]);
            if (is_valley && bound > CLEARLY) || (!is_valley && bound <= 0.0) {
                return (n, bound);
            }
        }
        of(&|n| worst(self.whole, n).0)
    }
}

fn is_convex(asked: &Asked) -> bool {
    matches!(asked.limit.class, Class::Convex | Class::ReverseConvex)
}

/// By how much a demand exceeds its limit as people read both: squares of torque and voltage count by their roots.
fn told_excess(asked: &Asked, raw: f64, excess: f64) -> f64 {
    if asked.bound > 0.0 { asked.natural(raw) / asked.bound - 1.0 } else { excess }
}

/// The limit with the largest relative excess, or measure of what it asks, the value of its functional and that excess. Limits that
/// take a walk are left out where the others come to more than `enough`.
fn worst_by(
    program: &RatioProgram,
    ratio: f64,
    by: Option<fn(&Asked, f64, f64) -> f64>,
    enough: f64,
) -> (f64, Option<Bind>) {
    let measure = |asked: &Asked, raw: f64, excess: f64| by.map_or(excess, |measure| measure(asked, raw, excess));
    // A demand below it has no larger excess than the worst so far.
    let floor = |asked: &Asked, worst: f64| match (by, asked.raw_bound()) {
        (None, bound) if bound > 0.0 && worst > -1.0 => bound * (1.0 + worst) * (1.0 - FLOOR),
        _ => f64::NEG_INFINITY,
    };
    let mut worst = (f64::NEG_INFINITY, None);
    fn offer(worst: &mut (f64, Option<Bind>), asked: &Asked, sample: Option<usize>, measured: f64) {
        if measured > worst.0 {
            *worst = (measured, Some(Bind::of(asked.limit.name, sample)));
        }
    }
    if !program.is_evaluated() {
        for walks in [false, true] {
            if walks && worst.0 > enough {
                break;
            }
            for (index, Limited { candidate, asked }) in program.limits.iter().enumerate() {
                let counts = is_convex(asked) && asked.demand.takes_a_walk() == walks;
                if counts && !asked.is_certainly_kept(candidate, ratio) {
                    let (raw, sample) = asked.raw_demand_above(candidate, ratio, floor(asked, worst.0));
                    let measured = measure(asked, raw, program.excess(index, raw, ratio));
                    offer(&mut worst, asked, sample, measured);
                }
            }
        }
        return worst;
    }
    // Where effects have to be evaluated at the ratio: once for each candidate.
    let mut rest = program.limits.as_slice();
    while let Some(first) = rest.first() {
        let same = rest.iter().take_while(|l| std::ptr::eq(l.candidate, first.candidate)).count();
        first.candidate.at_ratio(ratio, |here| {
            for walks in [false, true] {
                if walks && worst.0 > enough {
                    break;
                }
                for Limited { asked, .. } in rest[..same].iter().filter(|l| is_convex(l.asked)) {
                    let Some((asked, here)) = asked.there(here) else { continue };
                    if asked.takes_a_walk(&here) != walks || asked.is_certainly_kept(&here, ratio) {
                        continue;
                    }
                    let measured = |raw| {
                        let excess = violation(raw, asked.raw_bound());
                        // What a current along d keeps it keeps with equality, up to rounding: nothing is near to be broken.
                        let is_met = excess.abs() <= EQUALITY && asked.is_kept_along_d(&here);
                        if is_met { -1.0 } else { measure(&asked, raw, excess) }
                    };
                    if asked.raw_at_most(&here, ratio).is_none_or(|raw| measured(raw) > worst.0) {
                        let (raw, sample) = asked.raw_demand_above(&here, ratio, floor(&asked, worst.0));
                        offer(&mut worst, &asked, sample, measured(raw));
                    }
                }
            }
        });
        rest = &rest[same..];
    }
    worst
}

/// Whether ratios are evaluated for their currents along d alone: the branch and bound proves then what the grid shows.
fn is_proved_after(program: &RatioProgram) -> bool {
    program.is_evaluated() && !program.has_evaluated_effects()
}

/// How many points the grid from one ratio to another has: evaluating effects at each takes its time. A narrow range needs fewer.
fn count(program: &RatioProgram, (min, max): (f64, f64)) -> usize {
    let of_wide = |points: usize| {
        let share = (max / min).ln() / WIDE;
        if share < 1.0 { ((points as f64 * share).ceil() as usize).max(SPENT_POINTS) } else { points }
    };
    match program.is_evaluated() {
        _ if work::is_spent() => SPENT_POINTS,
        true if is_proved_after(program) => WEAKENED_POINTS,
        true => EVALUATED_POINTS,
        false if program.saturates() => of_wide(SATURATED_POINTS),
        false => of_wide(POINTS),
    }
}

/// The bottom of a valley.
fn bottom(program: &RatioProgram, value: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let steps = match () {
        () if work::is_spent() => SPENT_STEPS,
        () if is_proved_after(program) => WEAKENED_STEPS,
        // Each value is a sum over all samples, and smooth.
        () if program.saturates() && !program.is_evaluated() => return least_in_few_looks(value, a, b),
        () => FULLY,
    };
    golden_section(value, a, b, steps)
}

/// The feasible end of the bracket between an infeasible and a feasible ratio, and what binds there.
fn boundary(program: &RatioProgram, outside: f64, inside: f64) -> (f64, Bind) {
    if work::is_spent() {
        return (inside, worst(program, outside).1.unwrap_or(Bind::of("ratio_min", None)));
    }
    if program.is_evaluated() {
        let (bad, good) = crossing(&|n| worst(program, n).0, outside, inside, END);
        return (good, worst(program, bad).1.unwrap_or(Bind::of("ratio_min", None)));
    }
    let apart = Apart::new(program);
    let (mut bad, mut good) = (outside, inside);
    for _ in 0..100 {
        let middle = 0.5 * (bad + good);
        if middle == bad || middle == good || work::is_spent() {
            break;
        }
        if apart.excess(middle) <= 0.0 { good = middle } else { bad = middle }
    }
    let bind = worst(program, bad).1.unwrap_or(Bind::of("ratio_min", None));
    (good, bind)
}

/// The best ratio over all windows.
fn best_of(program: &RatioProgram, goal: &Goal, windows: &[Window]) -> Option<(f64, f64)> {
    let range = windows.iter().fold((f64::INFINITY, 0.0_f64), |(min, max), w| (min.min(w.min), max.max(w.max)));
    let count = match count(program, range) {
        points if program.saturates() && !program.is_evaluated() => points.min(SATURATED_VALUES),
        points => points,
    };
    least_by(&|n| goal.value(n), &pieces(program, windows), count, &|value, a, b| bottom(program, value, a, b))
}

/// The windows, cut where the mass steps.
fn pieces(program: &RatioProgram, windows: &[Window]) -> Vec<(f64, f64)> {
    let mut pieces = Vec::new();
    for window in windows {
        let mut start = window.min;
        for step in program.stage_ratios(window.min, window.max) {
            pieces.push((start, step));
            start = step;
        }
        pieces.push((start, window.max));
    }
    pieces
}

/// The least value over some intervals: a grid on each, then every valley refined.
pub(super) fn least(value: &impl Fn(f64) -> f64, intervals: &[(f64, f64)], count: usize) -> Option<(f64, f64)> {
    least_by(value, intervals, count, &|value, a, b| golden_section(value, a, b, FULLY))
}

/// The least value over some intervals, with a search for the bottom of a valley.
fn least_by<F: Fn(f64) -> f64>(
    value: &F,
    intervals: &[(f64, f64)],
    count: usize,
    bottom: &impl Fn(&F, f64, f64) -> f64,
) -> Option<(f64, f64)> {
    let mut best: Option<(f64, f64)> = None;
    let mut offer = |n: f64, f: f64| {
        if best.is_none_or(|(_, b)| f < b) {
            best = Some((n, f));
        }
    };
    for (min, max) in intervals {
        let grid = gearwise_model::numerics::grid::grid(*min, *max, if max > min { count } else { 1 });
        let values: Vec<f64> = grid.iter().map(|n| value(*n)).collect();
        for i in 0..grid.len() {
            offer(grid[i], values[i]);
            let (left, right) = (i.saturating_sub(1), (i + 1).min(grid.len() - 1));
            if left < right && values[i] <= values[left] && values[i] <= values[right] {
                let n = bottom(value, grid[left], grid[right]);
                offer(n, value(n));
            }
        }
    }
    best.filter(|(_, f)| f.is_finite())
}

/// The ratio at which the worst limit is exceeded least, as people read it, and that limit.
fn nowhere(program: &RatioProgram, points: &[(f64, f64)]) -> Infeasible {
    let told = |n: f64| worst_by(program, n, Some(told_excess), f64::INFINITY);
    // Of a square as much is told as its root has, of others all of it.
    let floor = |k: usize| (1.0 + points[k].1).sqrt() - 1.0;
    let mut nearest = (0, f64::INFINITY);
    let look = |nearest: &mut (usize, f64), k: usize| {
        // Most points are out of the question.
        if floor(k) < nearest.1 {
            let excess = told(points[k].0).0;
            if excess < nearest.1 {
                *nearest = (k, excess);
            }
        }
    };
    let least = (0..points.len()).min_by(|a, b| points[*a].1.total_cmp(&points[*b].1));
    least.into_iter().for_each(|k| look(&mut nearest, k));
    // What one walk over the samples says of many points, the most promising first.
    let bound = |first: usize, last: usize| {
        let plain = (first..=last).map(floor).fold(f64::INFINITY, f64::min);
        let walks = program.limits.iter().filter_map(|Limited { candidate, asked }| match asked.demand {
            Demand::WindingPeak(node) if asked.bound > 0.0 && !program.is_evaluated() => {
                let between = (points[first].0, points[last].0);
                let rise = asked.load(candidate).winding_peak_at_least(candidate.end(asked.end), &node, between);
                Some(rise / asked.bound * (1.0 - CLEARLY) - 1.0)
            }
            _ => None,
        });
        walks.fold(plain, f64::max)
    };
    let mut open = if points.is_empty() { Vec::new() } else { vec![(f64::NEG_INFINITY, 0, points.len() - 1)] };
    let divides = !program.is_evaluated() && program.without_walks().is_some();
    while let Some(next) = (0..open.len()).min_by(|a, b| open[*a].0.total_cmp(&open[*b].0)) {
        let (promise, first, last) = open.swap_remove(next);
        if promise >= nearest.1 || work::is_spent() {
            break;
        }
        if !divides || last - first < FEW {
            (first..=last).for_each(|k| look(&mut nearest, k));
            continue;
        }
        let middle = first + (last - first) / 2;
        open.extend([(first, middle), (middle + 1, last)].map(|(a, b)| (bound(a, b), a, b)));
    }
    let place = |k: usize| points.get(k).map_or(program.range.0, |p| p.0);
    let (left, right) = (place(nearest.0.saturating_sub(1)), place((nearest.0 + 1).min(points.len().max(1) - 1)));
    let inside = golden_section(&|n| told(n).0, left, right, if work::is_spent() { SPENT_STEPS } else { 40 });
    let ratio = if told(inside).0 < nearest.1 { inside } else { place(nearest.0) };
    let bind = told(ratio).1.unwrap_or(Bind::of("ratio_min", None));
    let named = program.limits.iter().filter(|l| l.asked.limit.name == bind.limit);
    let over = named
        .map(|Limited { candidate, asked }| {
            (asked.natural(asked.raw_demand(candidate, ratio).0) / asked.bound, asked.bound)
        })
        .reduce(|a, b| if b.0 > a.0 { b } else { a });
    let (least, allowed) = over.unwrap_or((f64::INFINITY, f64::NAN));
    Infeasible::Nowhere { bind, least, allowed, ratio }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_value_over_intervals_is_refined_in_every_valley() {
        // Two valleys, the lower one narrow and to the right.
        let f = |x: f64| ((x - 2.0).powi(2) + 0.1).min(50.0 * (x - 7.3).powi(2));
        let (n, v) = least(&f, &[(1.0, 10.0)], 200).unwrap();
        assert!((n - 7.3).abs() < 1e-6 && v < 1e-9);
        // Wherever it lies between points of the grid.
        for place in (0..200).map(|k| 1.2 + 0.041 * f64::from(k)) {
            let (n, _) = least(&|x: f64| (x - place).powi(2) + 0.1, &[(1.0, 10.0)], 60).unwrap();
            assert!((n - place).abs() < 1e-6, "{n} {place}");
        }
        // Cut off by the intervals: the first one's valley, the others' ends.
        let (n, v) = least(&f, &[(1.0, 5.0), (8.0, 9.0)], 200).unwrap();
        assert!((n - 2.0).abs() < 1e-6 && (v - 0.1).abs() < 1e-9);
        assert_eq!(least(&f, &[(3.0, 5.0)], 200).unwrap().0, 3.0);
        assert_eq!(least(&f, &[(4.0, 4.0)], 200), Some((4.0, f(4.0))));
        assert_eq!(least(&f, &[], 200), None);
        assert_eq!(least(&|_| f64::INFINITY, &[(1.0, 2.0)], 20), None);
        // Of equal values the first.
        assert_eq!(least(&|_| 1.0, &[(1.0, 2.0), (3.0, 4.0)], 20).unwrap().0, 1.0);
    }
}
