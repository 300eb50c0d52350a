//! Fronts of two or more quantities: designs of which no other has less of one of them without more of another.
//!
//! Of one motor, where each quantity falls with the ratio to its least values and rises beyond them, its efficient ratios (those that no
//! other of its own betters) are exactly the interval between its best ratios: from the smallest of them to the largest. A ratio below
//! them all has more of every quantity than the smallest, one above them all more than the largest; and between them whoever goes up
//! leaves the least of one quantity further behind, and whoever goes down that of another. What is least on an interval has its nearer
//! end: a quantity that no ratio changes moves nothing. Mass that steps up with stages adds the last ratio of each stage below that
//! interval, because a larger one weighs more there. Where none of this is shown points lie on a grid.
//!
//! The front over all motors is what of these curves is not dominated. It is given at points of each curve, the ends included, and what
//! lies between the points of a motor whose curve is shown is looked at too.

mod between;
mod dominance;

pub use between::AS_GOOD;

use rayon::prelude::*;

use self::between::{Line, Valley};
use self::dominance::not_dominated;
use super::answer::Reason;
use super::best::lacking;
use super::evaluate::Judged;
use super::mount::{JointDemand, Mount, Site};
use super::options::{Options, Stop, Stopped};
use super::program::{Certificate, Optimum, RatioProgram, Unsolved, Window};
use super::selection::Selection;
use super::solved::solve;
use super::{Evaluation, Prepared, Unusable, judge};
use gearwise_model::actuator::limits::{Candidate, Remark};
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Objective, Quantity, Robot};

/// A design on the front.
#[derive(Debug, Clone)]
pub struct FrontPoint<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The quantities, SI, in the order in which they were asked for.
    pub values: Vec<f64>,
    /// The design.
    pub evaluation: Evaluation,
    /// Whether the motor's own efficient ratios are proved.
    pub certified: bool,
    /// Limits that could not be checked, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Remark>,
}

/// The efficient ratios of a motor whose ratio is free: those that no other of its own betters.
#[derive(Debug, Clone)]
pub struct Efficient<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// The smallest and the largest best ratio of a quantity: with all between them that keep the limits.
    pub from: f64,
    /// The largest.
    pub to: f64,
    /// Smaller ratios that are efficient too: the last ones of their stages, which weigh less.
    pub stages: Vec<f64>,
    /// Whether this is proved: each end is certified for its quantity, and each quantity is shown to fall and then to rise.
    pub certified: bool,
}

/// The front at one joint.
#[derive(Debug)]
pub struct Front<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// The quantities, two or more.
    pub quantities: Vec<Quantity>,
    /// Designs, the best in the first quantity first.
    pub points: Vec<FrontPoint<'a>>,
    /// The efficient ratios of each motor that has a feasible design and whose ratio is free.
    pub efficient: Vec<Efficient<'a>>,
    /// Number of motors that have a feasible design of which every stated limit could be judged.
    pub motors: usize,
    /// Motors that keep all that could be judged, and of which a limit that the requirement states could not.
    pub unjudged: Vec<(&'a Motor, Vec<Remark>)>,
    /// Motors without a point, and why.
    pub rejected: Vec<(&'a Motor, Reason)>,
}

/// What a motor has of a front by itself.
struct Curve<'a, 'p> {
    points: Vec<FrontPoint<'a>>,
    efficient: Option<Efficient<'a>>,
    /// Where its efficient ratios are shown to be more than one.
    line: Option<Line<'a, 'p>>,
}

impl<'a> Curve<'a, '_> {
    /// Points of which each was looked at by itself.
    fn of(points: Vec<FrontPoint<'a>>) -> Self {
        Curve { points, efficient: None, line: None }
    }
}

/// The fronts of all joints in two or more different quantities, with `points` ratios along the curve of each motor. With `only_checked`
/// motors are left out of which a limit could not be checked; of the options it, what is called and what stops it count.
///
/// # Errors
/// It was stopped.
pub fn fronts<'a>(
    robot: &'a Robot,
    catalog: &'a Catalog,
    quantities: &[Quantity],
    points: usize,
    options: Options,
) -> Result<Vec<Front<'a>>, Stopped> {
    let (stop, only_checked) = (Stop::when(options.stop), options.only_checked);
    let one = |joint: &'a Joint| {
        let demand = JointDemand::new(joint, catalog);
        let site = Site::new(robot, joint, &demand).stopping(stop);
        let asked = Asked::new(site, quantities, points, only_checked);
        let curve = |motor: &'a Motor| {
            let curve = asked.curve(motor);
            (options.tick)();
            stop.unless(curve)
        };
        let motors: Vec<&Motor> = catalog.motors.iter().filter(|motor| !joint.motors.pass_over(motor)).collect();
        let curves: Vec<Result<Curve, Reason>> =
            motors.par_iter().map(|motor| curve(motor)).collect::<Result<_, _>>()?;
        let quantities = quantities.to_vec();
        let (unjudged, rejected, efficient, points) = Default::default();
        let mut front = Front { joint, quantities, points, efficient, motors: 0, unjudged, rejected };
        let mut lines = Vec::new();
        for (motor, curve) in motors.into_iter().zip(curves) {
            match curve {
                Ok(curve) => {
                    front.motors += 1;
                    front.points.extend(curve.points);
                    front.efficient.extend(curve.efficient);
                    lines.extend(curve.line);
                }
                Err(Reason::Unjudged(because)) => front.unjudged.push((motor, because)),
                Err(why) => match why.unknown() {
                    Some(remark) => front.unjudged.push((motor, vec![remark])),
                    None => front.rejected.push((motor, why)),
                },
            }
        }
        front.points = asked.between(&lines, front.points);
        stop.unless(front)
    };
    robot.joints.iter().map(one).collect()
}

/// What a front is asked for.
struct Asked<'a, 'd, 'q> {
    site: Site<'a, 'd>,
    /// The joint, whose objective counts the quantities too: what is not known of them cannot be judged.
    judged_by: Joint,
    quantities: &'q [Quantity],
    objectives: Vec<Objective>,
    points: usize,
    only_checked: bool,
}

impl<'a, 'd, 'q> Asked<'a, 'd, 'q> {
    fn new(site: Site<'a, 'd>, quantities: &'q [Quantity], points: usize, only_checked: bool) -> Asked<'a, 'd, 'q> {
        let mut judged_by = site.joint.clone();
        let terms = &mut judged_by.objective.terms;
        let more = quantities.iter().filter(|q| site.joint.objective.weight(**q) == 0.0);
        terms.extend(more.map(|quantity| (*quantity, 1.0)));
        let objectives = quantities.iter().map(|quantity| Objective::single(*quantity)).collect();
        Asked { site, judged_by, quantities, objectives, points, only_checked }
    }
}

impl<'a> Asked<'a, '_, '_> {
    /// The points of one motor.
    fn curve(&self, motor: &'a Motor) -> Result<Curve<'a, '_>, Reason> {
        let durations = self.site.demand.load.duration.is_some();
        if let Some(why) = lacking(motor, durations, |quantity| self.quantities.contains(&quantity)) {
            return Err(Reason::Unusable(why));
        }
        match self.site.is_geared_with(motor) {
            true => self.of_gears(motor).map(Curve::of),
            false => self.of_ratios(self.site.direct(motor)),
        }
    }

    /// A mount with its limits gathered, where the quantities count.
    fn prepared<'p>(&'p self, mount: &Mount<'a, 'p>) -> Result<Prepared<'p>, Unusable> {
        let candidate = mount.candidate()?;
        Ok(Prepared::new(Candidate { joint: &self.judged_by, ..candidate }).stopping(mount.stop))
    }

    /// The gate: why a design is not on a front, from what is not known of it.
    fn judge(&self, unchecked: &[Remark]) -> Result<(), Reason> {
        if let Some(why) = self.left_out(unchecked) {
            return Err(why);
        }
        match judge::unjudged(self.site.robot, &self.judged_by, unchecked) {
            because if because.is_empty() => Ok(()),
            because => Err(Reason::Unjudged(because)),
        }
    }

    /// Why something with these unknowns is not looked at.
    fn left_out(&self, unchecked: &[Remark]) -> Option<Reason> {
        let what = judge::left_out(self.site.robot, &self.judged_by, unchecked, self.only_checked);
        what.map(|(limit, why)| Reason::Unchecked(limit, why))
    }

    fn at(&self, mount: &Mount<'a, '_>, prepared: &Prepared, ratio: f64, certified: bool) -> Option<FrontPoint<'a>> {
        let evaluation = prepared.at(ratio);
        let values: Option<Vec<f64>> = self.quantities.iter().map(|q| evaluation.quantity(*q)).collect();
        let values = values.filter(|_| evaluation.feasible)?;
        let Judged { unchecked, assumed } = prepared.judged(ratio);
        let (motor, gear) = (mount.motor, mount.gear_id());
        Some(FrontPoint { motor, gear, values, evaluation, certified, unchecked, assumed })
    }

    fn of_ratios<'p>(&'p self, mount: Mount<'a, 'p>) -> Result<Curve<'a, 'p>, Reason> {
        let prepared = self.prepared(&mount).map_err(Reason::Unusable)?;
        let Some(range) = mount.range() else { return Err(Reason::Unusable(Unusable::NoGearFits)) };
        if let Some(why) = self.left_out(&prepared.unchecked) {
            return Err(why);
        }
        let best = |objective: &Objective| {
            let joint = Joint { objective: objective.clone(), ..mount.joint.clone() };
            let own = Prepared::new(Candidate { joint: &joint, ..prepared.candidate }).stopping(mount.stop);
            solve(&own, &joint, range).map(|optimum| judge::judged_part(&own, optimum, self.only_checked))
        };
        let best: Vec<Optimum> = self.objectives.iter().map(best).collect::<Result<_, _>>()?;
        let is_certified = best.iter().all(|o| matches!(o.certificate, Certificate::Certified { .. }));
        let look = |ratios: Vec<f64>, certified: bool| {
            let at = |ratio: f64| self.at(&mount, &prepared, ratio, certified);
            let points: Vec<FrontPoint> = ratios.into_iter().filter_map(at).collect();
            if points.is_empty() {
                let unknown =
                    prepared.candidate.mass_at(range.0).is_none() && self.quantities.contains(&Quantity::Mass);
                let not = || Reason::NotSolved(Unsolved::NoneBetween);
                return Err(if unknown { Reason::Unusable(Unusable::Mass) } else { not() });
            }
            self.judged(points)
        };
        if let Some(values) = mount.joint.ratio.listed() {
            // All of them: what is dominated is left out, and that all are evaluated is the proof.
            return look(values.to_vec(), is_certified).map(Curve::of);
        }
        let windows = &best[0].windows;
        let ends = best.iter().map(|o| o.ratio).fold((f64::INFINITY, 0.0_f64), |(a, b), n| (a.min(n), b.max(n)));
        let valleys = self.valleys(&prepared, &best).filter(|_| is_certified);
        let Some(valleys) = valleys else {
            let mut stages = self.ends_of_stages(&prepared, windows);
            // The points of a family are gears: none of them is missed by the grid.
            let points_of_family = mount.joint.family_map().into_iter().flat_map(|map| map.points());
            stages.extend(points_of_family.map(|point| point.ratio).filter(|n| ends.0 < *n && *n < ends.1));
            stages.sort_by(f64::total_cmp);
            let points = look(on_windows(windows, ends, self.points, stages), false)?;
            // With a gear map quantities may jump: that all ratios between two best ones are efficient is not so.
            let efficient = mount.joint.gear_map.is_none().then_some(Efficient {
                motor: mount.motor,
                from: ends.0,
                to: ends.1,
                stages: vec![],
                certified: false,
            });
            return Ok(Curve { points, efficient, line: None });
        };
        let stages = self.ends_of_stages(&prepared, windows);
        let ends = efficient_ends(&valleys, &stages, best[0].ratio);
        let mut ratios = vec![ends.0];
        if ends.1 > ends.0 * (1.0 + 1e-12) {
            ratios = grid(ends.0, ends.1, self.points.max(2));
            ratios.extend(stages.iter().filter(|n| ends.0 < **n && **n < ends.1));
            ratios.sort_by(f64::total_cmp);
        }
        let stages: Vec<f64> = stages.into_iter().filter(|n| *n < ends.0).collect();
        let points = look(stages.iter().copied().chain(ratios).collect(), true)?;
        let nodes = points.iter().map(|p| (p.evaluation.ratio, p.values.clone()));
        let nodes: Vec<_> = nodes.filter(|(ratio, _)| *ratio >= ends.0).collect();
        let line = (nodes.len() > 1).then(|| Line::new(mount, prepared, nodes, valleys));
        let efficient = Efficient { motor: mount.motor, from: ends.0, to: ends.1, stages, certified: true };
        Ok(Curve { points, efficient: Some(efficient), line })
    }

    /// Each quantity along the ratios of a motor, from its best one; `None` where the ratios that keep the limits are not one interval, or
    /// it is not shown that each quantity falls and then rises on it.
    fn valleys(&self, prepared: &Prepared, best: &[Optimum]) -> Option<Vec<Valley>> {
        let of = |(objective, optimum): (&Objective, &Optimum)| {
            let [Window { min, max, .. }] = optimum.windows[..] else { return None };
            let program = RatioProgram::new(prepared, objective, min, max);
            if !program.is_valley(min, max) {
                return None;
            }
            let steps = objective.sole() == Some(Quantity::Mass) && steps(prepared);
            let value = |ratio| program.objective_at(ratio);
            let lower_bound = match optimum.certificate {
                Certificate::Certified { lower_bound, .. } => lower_bound,
                Certificate::NotCertified(_) => return None,
            };
            let least = [min, max].map(|end| as_good(&value, optimum.ratio, end));
            Some(Valley { least: least.into(), bound: lower_bound.min(optimum.objective), steps })
        };
        self.objectives.iter().zip(best).map(of).collect()
    }

    /// Where mass counts and steps up with stages: the last ratio of each stage.
    fn ends_of_stages(&self, prepared: &Prepared, windows: &[Window]) -> Vec<f64> {
        if !self.quantities.contains(&Quantity::Mass) || !steps(prepared) {
            return Vec::new();
        }
        let objective = Objective::single(Quantity::Mass);
        let of = |w: &Window| RatioProgram::new(prepared, &objective, w.min, w.max).stage_ratios(w.min, w.max);
        windows.iter().flat_map(of).collect()
    }

    fn of_gears(&self, motor: &'a Motor) -> Result<Vec<FrontPoint<'a>>, Reason> {
        let mut gears: Selection<()> = Selection::new(motor);
        let mut points = Vec::new();
        for mount in self.site.mounts(motor) {
            let Some(gear) = mount.gear else { continue };
            let prepared = match self.prepared(&mount) {
                Ok(prepared) => prepared,
                Err(why) => {
                    gears.unusable(why);
                    continue;
                }
            };
            if let Some(what) = judge::left_out(mount.robot, &self.judged_by, &prepared.unchecked, self.only_checked) {
                gears.unchecked(&gear.id, what);
                continue;
            }
            let evaluation = prepared.at(gear.ratio);
            match self.at(&mount, &prepared, gear.ratio, true) {
                Some(point) => {
                    gears.take(false, (0.0, 0.0), ());
                    points.push(point);
                }
                None if evaluation.feasible => gears.unusable(Unusable::Mass),
                None => gears.exceeds(&gear.id, evaluation.tightest()),
            }
        }
        gears.best()?;
        self.judged(points)
    }

    /// The points that can be judged; where there are none, why.
    fn judged(&self, points: Vec<FrontPoint<'a>>) -> Result<Vec<FrontPoint<'a>>, Reason> {
        let mut refused = None;
        let mut judged = Vec::with_capacity(points.len());
        for point in points {
            match self.judge(&point.unchecked) {
                Ok(()) => judged.push(point),
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        match refused {
            Some(why) if judged.is_empty() => Err(why),
            _ => Ok(judged),
        }
    }

    /// The front of all points, and of what lies between those of the lines: no point is left that a ratio of a line betters by more than
    /// rounding, and no piece of a line is missing that halving shows.
    fn between(&self, lines: &[Line<'a, '_>], points: Vec<FrontPoint<'a>>) -> Vec<FrontPoint<'a>> {
        let mut front = self.bettered_by(lines, front_of(points));
        let on_front: Vec<&[f64]> = front.iter().map(|p| p.values.as_slice()).collect();
        let missing: Vec<FrontPoint> = lines
            .par_iter()
            .flat_map_iter(|line| {
                let is_own = |p: &&FrontPoint| p.motor.id == line.mount.motor.id;
                let mut own: Vec<f64> = front.iter().filter(is_own).map(|p| p.evaluation.ratio).collect();
                own.sort_by(f64::total_cmp);
                let ratios = line.missing(&on_front, &own, &self.objectives);
                ratios.into_iter().filter_map(|ratio| self.on(line, ratio))
            })
            .collect();
        if !missing.is_empty() {
            front.extend(missing);
            front = self.bettered_by(lines, front_of(front));
        }
        front
    }

    /// A front without what ratios of the lines better, and with those ratios. Each ratio that takes a place is of another motor than what
    /// it betters, and what is better than it of still another one, so that this comes to an end.
    fn bettered_by(&self, lines: &[Line<'a, '_>], front: Vec<FrontPoint<'a>>) -> Vec<FrontPoint<'a>> {
        let mut settled: Vec<FrontPoint> = Vec::new();
        let mut open = front;
        while !open.is_empty() && !self.site.stop.now() {
            let better = |point: &FrontPoint| {
                let others = lines.iter().filter(|line| line.mount.motor.id != point.motor.id);
                others
                    .filter_map(|line| self.on(line, line.better_than(&point.values, &self.objectives)?))
                    .find(|found| dominance::is_nowhere_above(&found.values, &point.values))
            };
            let found: Vec<Option<FrontPoint>> = open.par_iter().map(better).collect();
            let (kept, better): (Vec<_>, Vec<_>) = open.into_iter().zip(found).partition(|(_, found)| found.is_none());
            settled.extend(kept.into_iter().map(|(point, _)| point));
            // What is new may be bettered itself.
            let new = front_of(better.into_iter().filter_map(|(_, found)| found).collect());
            let both: Vec<(FrontPoint, bool)> =
                settled.into_iter().map(|p| (p, false)).chain(new.into_iter().map(|p| (p, true))).collect();
            let (old, new): (Vec<_>, Vec<_>) = front_by(both, |p| &p.0).into_iter().partition(|(_, is_new)| !is_new);
            settled = old.into_iter().map(|(point, _)| point).collect();
            open = new.into_iter().map(|(point, _)| point).collect();
        }
        settled.extend(open);
        front_of(settled)
    }

    /// The design at a ratio of a line, where it can be judged.
    fn on(&self, line: &Line<'a, '_>, ratio: f64) -> Option<FrontPoint<'a>> {
        let point = self.at(&line.mount, &line.prepared, ratio, true)?;
        self.judge(&point.unchecked).is_ok().then_some(point)
    }
}

/// Whether the mass steps up with stages.
fn steps(prepared: &Prepared) -> bool {
    prepared.candidate.gear.mass_per_stage.is_some_and(|(mass, _)| mass > 0.0)
}

/// How far from the best ratio, towards an end, a quantity that falls and then rises stays as good: up to the best ratio itself but
/// where it does not change at all.
fn as_good(value: &impl Fn(f64) -> f64, best: f64, end: f64) -> f64 {
    let least = value(best);
    let same = |ratio: f64| value(ratio) <= least + 1e-12 * least.abs();
    let near = best * if end < best { 1.0 - 1e-3 } else { 1.0 + 1e-3 };
    let near = if end < best { near.max(end) } else { near.min(end) };
    if best == end || !same(near) {
        return best;
    }
    if same(end) {
        return end;
    }
    let (mut good, mut bad) = (near, end);
    for _ in 0..60 {
        let middle = 0.5 * (good + bad);
        if same(middle) { good = middle } else { bad = middle }
    }
    good
}

/// The ends of the efficient ratios: from the first ratio beyond which some quantity rises to the last up to which one falls. Where one
/// ratio is the best in all, that nearest to `first`, the best one of the first quantity, of those in the lowest stage.
fn efficient_ends(valleys: &[Valley], stages: &[f64], first: f64) -> (f64, f64) {
    // What goes up in steps falls nowhere, and rises only to a stage.
    let free = || valleys.iter().filter(|valley| !valley.steps);
    let rises = free().map(|valley| valley.least.1).fold(f64::INFINITY, f64::min);
    let falls = free().map(|valley| valley.least.0).fold(0.0, f64::max);
    if rises < falls {
        return (rises, falls);
    }
    let stage = stages.iter().copied().find(|end| *end >= falls);
    let best = first.min(rises).min(stage.unwrap_or(f64::INFINITY)).max(falls);
    (best, best)
}

/// Ratios on a grid over the windows: `count` between two, and as many more as lie beyond them at that distance, at most `count`; the ends
/// of windows and stages too.
fn on_windows(windows: &[Window], (from, to): (f64, f64), count: usize, stages: Vec<f64>) -> Vec<f64> {
    let is_wide = to > from * (1.0 + 1e-12);
    let mut ratios = if is_wide { grid(from, to, count.max(2)) } else { vec![from] };
    let beyond = windows.iter().flat_map(|w| [(w.min, w.max.min(from)), (w.min.max(to), w.max)]);
    let beyond: Vec<(f64, f64)> = beyond.filter(|(a, b)| a < b).collect();
    let length = |(a, b): &(f64, f64)| (b / a).ln();
    let all: f64 = beyond.iter().map(length).sum();
    let step = if is_wide { (to / from).ln() / (count.max(2) - 1) as f64 } else { all / count as f64 };
    let step = step.max(all / count as f64);
    for piece in &beyond {
        ratios.extend(grid(piece.0, piece.1, (length(piece) / step).ceil() as usize + 1));
    }
    ratios.extend(windows.iter().flat_map(|w| [w.min, w.max]).filter(|n| from < *n && *n < to));
    ratios.extend(stages);
    ratios.sort_by(f64::total_cmp);
    ratios.dedup();
    ratios
}

/// Keeps the points that no other betters, the best in the first quantity first.
fn front_of(points: Vec<FrontPoint>) -> Vec<FrontPoint> {
    front_by(points, |point| point)
}

fn front_by<'a, T>(all: Vec<T>, point: impl for<'t> Fn(&'t T) -> &'t FrontPoint<'a>) -> Vec<T> {
    let all: Vec<T> = all.into_iter().filter(|t| point(t).values.iter().all(|v| v.is_finite())).collect();
    let views: Vec<&[f64]> = all.iter().map(|t| point(t).values.as_slice()).collect();
    let order = |a: usize, b: usize| {
        let (a, b) = (point(&all[a]), point(&all[b]));
        a.motor.id.cmp(&b.motor.id).then(a.evaluation.ratio.total_cmp(&b.evaluation.ratio))
    };
    let kept = not_dominated(&views, order);
    let mut all: Vec<Option<T>> = all.into_iter().map(Some).collect();
    kept.into_iter().filter_map(|place| all[place].take()).collect()
}
