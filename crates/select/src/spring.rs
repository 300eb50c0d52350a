//! Joints with a parallel spring: motor, gear, ratio and spring chosen together, and what the spring is
//! worth: the same joint with the same motor and no spring stands beside every choice.

use super::answer::{Design, Reason, Refused, SpringChoice, WithoutSpring};
use super::evaluate::{FEASIBILITY_TOLERANCE, Margin};
use super::mount::{Mount, Site, covered_inertia};
use super::program::spring::{self, SpringOptimum, Sprung};
use super::program::{Bind, Certificate, Optimum, RatioProgram, Unsolved};
use super::selection::Selection;
use super::solved::{design, one_gear};
use super::{Prepared, judge};
use gearwise_model::actuator::limits::allows_spring;
use gearwise_model::catalog::Motor;
use gearwise_model::requirement::{Joint, Spring};

/// Inertia at the output \[kg·m²\] that the gear's efficiency covers.
fn covered(mount: &Mount) -> f64 {
    mount.gear.and_then(|gear| covered_inertia(mount.joint, gear)).unwrap_or(0.0)
}

/// The best that a motor does without the spring in a range of ratios.
fn without_spring(prepared: &Prepared, joint: &Joint, min: f64, max: f64) -> Option<WithoutSpring> {
    let (ratio, objective) = if min == max && prepared.candidate.catalog_gear.is_some() {
        let evaluation = prepared.at_in_full(min);
        (min, evaluation.objective(&joint.objective).filter(|_| evaluation.feasible)?)
    } else {
        match RatioProgram::new(prepared, &joint.objective, min, max).solve() {
            Ok(optimum) => (optimum.ratio, optimum.objective),
            _ => return None,
        }
    };
    Some(WithoutSpring { ratio, objective, loss: prepared.at(ratio).loss })
}

/// The best ratio and spring of a candidate given without spring.
///
/// # Errors
/// Why there is none.
pub(super) fn choose(
    mount: &Mount,
    prepared: &Prepared,
    (min, max): (f64, f64),
) -> Result<(SpringChoice, Optimum), Reason> {
    let joint = mount.joint;
    if let Some(values) = joint.ratio.listed().filter(|_| min < max) {
        return choose_listed(mount, prepared, values);
    }
    let Some(asked) = joint.limits.spring else {
        return Err(Reason::NotSolved(Unsolved::NoSpringAsked));
    };
    if mount.motor.inside.is_some() && min == max {
        return choose_of_module(mount, prepared, &asked, min);
    }
    // Effects that are evaluated, or that bend torque over current, have no place in the spring's forms.
    let settled = prepared.candidate.standing_at(min);
    if settled.is_evaluated() || !prepared.candidate.actuator.shortfall.is_nothing() {
        return Err(Reason::NotSolved(Unsolved::SpringWithEffects));
    }
    let found = spring::solve(prepared, &joint.objective, &asked, (min, max), covered(mount)).map_err(Reason::from)?;
    let without = without_spring(prepared, joint, min, max);
    let SpringOptimum { stiffness, rest_angle, mut optimum, lower_bound, gap, least_stiffness } = found;
    // Where it cannot be judged at the best ratio, the same spring at one where it can.
    if let Some(sprung) = Sprung::new(joint, stiffness, rest_angle.unwrap_or(0.0), covered(mount)) {
        let there = prepared.with_candidate(sprung.candidate(&prepared.candidate));
        optimum = judge::judged_part(&there, optimum, false);
    }
    Ok((SpringChoice { stiffness, rest_angle, lower_bound, gap, least_stiffness, without }, optimum))
}

/// A spring that was looked at: how far the limits are exceeded, how many of them are not decided, the objective; stiffness and
/// rest angle.
type Looked = ((f64, usize, f64), f64, f64);

/// Limits that no spring changes.
const WITHOUT_SPRING: [&str; 7] =
    ["actuator_mass", "outer_diameter", "axial_length", "price", "lead_time", "reflected_inertia", "supply_range"];

/// Springs of a module that are looked at along stiffness and rest angle, before the best are moved.
const GRID: usize = 9;
/// How often the steps by which the best is moved are halved.
const HALVINGS: usize = 14;

/// The best spring that is found of a module, whose ratio is its own. What its row lets it give is no form of the conic
/// program, so that all is evaluated: nothing is proved of it but that there is none.
fn choose_of_module(
    mount: &Mount,
    prepared: &Prepared,
    asked: &Spring,
    ratio: f64,
) -> Result<(SpringChoice, Optimum), Reason> {
    let joint = mount.joint;
    let covered = covered(mount);
    let evaluated = |k: f64, q: f64| {
        let sprung = Sprung::new(joint, k, q, covered)?;
        let there = prepared.with_candidate(sprung.candidate(&prepared.candidate));
        let open = judge::unjudged(mount.robot, joint, &there.unchecked_at(ratio)).len();
        Some((there.at_in_full(ratio), open))
    };
    if evaluated(0.0, 0.0).is_none() {
        return Err(Reason::NotSolved(Unsolved::NoPosition));
    }
    let look = |k: f64, q: f64| -> Looked {
        let Some((there, open)) = evaluated(k, q) else { return ((f64::INFINITY, 0, 0.0), k, q) };
        let margin = there.tightest().map_or(1.0, |m| m.margin);
        // By ratings alone there is no loss: what is left of them counts.
        let objective = there.objective(&joint.objective).filter(|o| o.is_finite()).unwrap_or(-margin);
        (if there.feasible { (0.0, open, objective) } else { (-margin, 0, 0.0) }, k, q)
    };
    let ([k0, k1], [q0, q1]) = (asked.stiffness, asked.rest_angle);
    let better = |a: &Looked, b: &Looked| {
        let (first, second) = (a.0, b.0);
        let of_limits = first.0.total_cmp(&second.0).then(first.1.cmp(&second.1));
        of_limits.then(first.2.total_cmp(&second.2)).then(a.1.total_cmp(&b.1))
    };
    let places = |low: f64, high: f64| {
        let count = if low == high { 1 } else { GRID };
        (0..count).map(move |j| low + (high - low) * j as f64 / (GRID - 1) as f64)
    };
    let all = places(k0, k1).flat_map(|k| places(q0, q1).take(if k == 0.0 { 1 } else { GRID }).map(move |q| (k, q)));
    let mut best = all.map(|(k, q)| look(k, q)).min_by(better).unwrap_or_else(|| look(k0, q0));
    let mut step = [(k1 - k0) / (GRID - 1) as f64, (q1 - q0) / (GRID - 1) as f64];
    for _ in 0..HALVINGS {
        step = step.map(|length| 0.5 * length);
        let around =
            [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
        // A step is taken again while it helps.
        for _ in 0..4 {
            let moved = around
                .iter()
                .map(|(a, b)| look((best.1 + a * step[0]).clamp(k0, k1), (best.2 + b * step[1]).clamp(q0, q1)));
            match moved.min_by(better).filter(|found| better(found, &best).is_lt()) {
                Some(found) => best = found,
                None => break,
            }
        }
    }
    let (_, stiffness, rest) = best;
    let (there, _) = evaluated(stiffness, rest).ok_or(Reason::NotSolved(Unsolved::NoPosition))?;
    if !there.feasible {
        let exceeded = |m: &&Margin| m.margin < -FEASIBILITY_TOLERANCE && WITHOUT_SPRING.contains(&m.limit);
        let always = there.margins.iter().find(exceeded);
        let certain = || there.tightest().filter(|_| !allows_spring(&prepared.candidate, asked));
        let Some(margin) = always.or_else(certain) else {
            return Err(Reason::NotSolved(Unsolved::NothingRuledOutWithSpring));
        };
        let bind = Bind::of(margin.limit, margin.sample);
        return Err(Reason::Module { bind, over: margin.demand / margin.bound, allowed: margin.bound });
    }
    let objective = there.objective(&joint.objective).unwrap_or(f64::NAN);
    let certificate =
        Certificate::NotCertified("the spring of a module is searched for, and nothing is proved of it".into());
    let optimum = Optimum { certificate, ..one_gear(ratio, objective, "") };
    let without = without_spring(prepared, joint, ratio, ratio);
    let rest_angle = (stiffness > 0.0).then_some(rest);
    let spring = SpringChoice { stiffness, rest_angle, lower_bound: None, gap: None, least_stiffness: false, without };
    Ok((spring, optimum))
}

/// The best of listed ratios, each with its best spring.
fn choose_listed(mount: &Mount, prepared: &Prepared, values: &[f64]) -> Result<(SpringChoice, Optimum), Reason> {
    let found: Vec<_> = values.iter().map(|n| (*n, choose(mount, prepared, (*n, *n)))).collect();
    let unsolved = found.iter().any(|(_, found)| matches!(found, Err(Reason::NotSolved(_))));
    let made = || found.iter().filter_map(|(_, found)| found.as_ref().ok());
    let Some((spring, optimum)) = made().min_by(|a, b| a.1.objective.total_cmp(&b.1.objective)) else {
        // What the middle one comes to is as good a reason as any.
        return found
            .into_iter()
            .nth(values.len() / 2)
            .map_or(Err(Reason::NotSolved(Unsolved::NoSpringAsked)), |f| f.1);
    };
    let objective = optimum.objective;
    let bounds = made().map(|(spring, _)| spring.lower_bound);
    let lower_bound = bounds.reduce(|a, b| a.zip(b).map(|(a, b)| a.min(b))).flatten().filter(|_| !unsolved);
    let gap = lower_bound.map(|b| if objective == 0.0 { 0.0 } else { ((objective - b) / objective.abs()).max(0.0) });
    let certificate = match (lower_bound, gap) {
        (Some(bound), Some(gap)) if gap <= super::program::GAP_TOLERANCE => {
            let method = "all listed ratios, each with its best spring";
            Certificate::Certified { lower_bound: bound.min(objective), gap, method }
        }
        _ => Certificate::NotCertified("the spring of another listed ratio could not be bounded closely enough".into()),
    };
    let without = solve_without(prepared, mount.joint);
    let spring = SpringChoice { lower_bound, gap, without, ..*spring };
    Ok((spring, Optimum { certificate, ..optimum.clone() }))
}

/// The best of the listed ratios without the spring.
fn solve_without(prepared: &Prepared, joint: &Joint) -> Option<WithoutSpring> {
    let optimum = super::solved::solve(prepared, joint, joint.ratio.range()?).ok()?;
    let (ratio, objective) = (optimum.ratio, optimum.objective);
    Some(WithoutSpring { ratio, objective, loss: prepared.at(ratio).loss })
}

/// The allowed spring that comes nearest to keeping the limits, where none does: stiffness \[N·m/rad\] and rest angle
/// \[rad\]. `None` where no spring is chosen for the candidate at all.
pub(super) fn nearest(mount: &Mount, prepared: &Prepared, range: (f64, f64)) -> Option<(f64, f64)> {
    let asked = mount.joint.limits.spring?;
    spring::nearest(prepared, &mount.joint.objective, &asked, range, covered(mount))
}

/// The best design with a spring over a range of ratios.
///
/// # Errors
/// Why there is none.
pub(super) fn solve<'a>(mount: &Mount<'a, '_>, prepared: &Prepared, range: (f64, f64)) -> Result<Design<'a>, Reason> {
    let (choice, optimum) = choose(mount, prepared, range)?;
    let sprung = Sprung::new(mount.joint, choice.stiffness, choice.rest_angle.unwrap_or(0.0), covered(mount))
        .ok_or(Reason::NotSolved(Unsolved::NoPosition))?;
    let sprung = prepared.with_candidate(sprung.candidate(&prepared.candidate));
    let mut design = design(mount, &sprung, optimum);
    design.spring = Some(choice);
    Ok(design)
}

/// The least objective that any gear of a class can have with its best spring.
#[derive(Debug, Clone, Copy)]
struct Bound(
    /// `None` once a gear has none.
    Option<f64>,
);

impl Bound {
    /// Takes another gear in.
    fn take(&mut self, design: &Design) {
        self.0 = self.0.zip(design.spring.and_then(|s| s.lower_bound)).map(|(a, b)| a.min(b));
    }
}

/// The best gear: the spring is solved for with each that fits. Gears with which the design cannot be judged are
/// looked at apart.
///
/// # Errors
/// Why the motor is no choice.
pub(super) fn best_gear<'a>(
    site: Site<'a, '_>,
    motor: &'a Motor,
    only_checked: bool,
) -> Result<Design<'a>, Refused<'a>> {
    let Site { robot, joint, .. } = site;
    let mut gears: Selection<(Design, bool)> = Selection::new(motor);
    let mut bounds = [Bound(Some(f64::INFINITY)); 2];
    for mount in site.mounts(motor) {
        let (Some(gear), Some(range)) = (mount.gear_id(), mount.range()) else { continue };
        let prepared = match mount.prepared() {
            Ok(prepared) => prepared,
            Err(why) => {
                gears.mention(gear, Reason::Unusable(why));
                continue;
            }
        };
        if let Some((limit, why)) = judge::left_out(robot, joint, &prepared.unchecked, only_checked) {
            gears.mention(gear, Reason::Unchecked(limit, why));
            continue;
        }
        match solve(&mount, &prepared, range) {
            // What can be said of heat depends on the spring: it is asked of the design.
            Ok(design) => match judge::left_out(robot, joint, &design.unchecked, only_checked) {
                Some((limit, why)) => gears.mention(gear, Reason::Unchecked(limit, why)),
                None => {
                    let apart = !judge::unjudged(robot, joint, &design.unchecked).is_empty();
                    bounds[usize::from(apart)].take(&design);
                    gears.take(apart, (design.optimum.objective, design.evaluation.loss), (design, apart));
                }
            },
            Err(why) => {
                if matches!(why, Reason::NotSolved(_)) {
                    bounds = [Bound(None); 2];
                }
                gears.refused(gear, why);
            }
        }
    }
    let (design, apart) = gears.best_of(motor)?;
    Ok(settled(design, bounds[usize::from(apart)].0))
}

/// The best of all gears, with the proof that no gear has a better one.
fn settled(mut design: Design, bound: Option<f64>) -> Design {
    let objective = design.optimum.objective;
    let gap = bound.map(|b| if objective == 0.0 { 0.0 } else { ((objective - b) / objective.abs()).max(0.0) });
    if let (Certificate::Certified { .. }, Some(lower_bound)) = (&design.optimum.certificate, bound) {
        design.optimum.certificate = match gap {
            Some(gap) if gap <= super::program::GAP_TOLERANCE => {
                let method = "all gears, each with its best spring";
                Certificate::Certified { lower_bound: lower_bound.min(objective), gap, method }
            }
            _ => Certificate::NotCertified("another gear's spring could not be bounded closely enough".into()),
        };
    } else if bound.is_none() && matches!(design.optimum.certificate, Certificate::Certified { .. }) {
        design.optimum.certificate = Certificate::NotCertified("another gear's spring could not be solved for".into());
    }
    if let Some(spring) = &mut design.spring {
        (spring.lower_bound, spring.gap) = (bound, gap);
    }
    design
}
