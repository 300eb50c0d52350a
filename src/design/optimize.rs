//! All motors of a catalogue for all joints of a robot: the best ratio of each, ranked.

use rayon::prelude::*;

use super::agreement::kendall_tau;
use super::evaluate::Judged;
use super::judge::{self, Refused, Unjudged};
use super::program::{Bind, Certificate, Infeasible, Optimum, Outcome, RatioProgram, Window};
use super::prune::{self, Pruned};
use super::spring::SpringChoice;
use super::{Evaluation, JointDemand, Prepared, Unusable, continuous_candidate, geared_candidate};
use crate::actuator::limits::Remark;
use crate::actuator::metrics::{METRICS, Shown};
use crate::catalog::{Catalog, Gear, Motor};
use crate::requirement::{Joint, Quantity, RatioChoice, Robot};

/// What was found for a robot.
#[derive(Debug)]
pub struct RobotResult<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Each joint, in the order of the requirement.
    pub joints: Vec<JointResult<'a>>,
}

/// What was found for a joint.
#[derive(Debug, Clone)]
pub struct JointResult<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// Feasible designs of which every limit that the requirement states could be judged, best first: one for each motor.
    pub candidates: Vec<Design<'a>>,
    /// Designs that keep all that could be judged, and of which a limit that the requirement states could not: in the
    /// order that they would have. None of them is a choice.
    pub unjudged: Vec<Unjudged<'a>>,
    /// Motors that cannot do it, by id, with the reason.
    pub rejected: Vec<Rejected<'a>>,
    /// Rank correlation between each metric's ranking and the task's; empty where not all motors were solved.
    pub agreement: Vec<Agreement>,
    /// What was left out, where only the first designs were wanted.
    pub pruned: Option<Pruned<'a>>,
}

/// A feasible design.
#[derive(Debug, Clone)]
pub struct Design<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// The best ratio and its proof.
    pub optimum: Optimum,
    /// The design at that ratio.
    pub evaluation: Evaluation,
    /// Limits that could not be checked, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Remark>,
    /// Winding temperature \[K\], where it can be told (`Some(None)`: it runs away).
    pub winding_temperature: Option<Option<f64>>,
    /// Time the current needs at a reversal \[s\].
    pub reversal_time: Option<f64>,
    /// The parallel spring, where the joint asks for one.
    pub spring: Option<SpringChoice>,
}

/// A motor that cannot do it.
#[derive(Debug, Clone)]
pub struct Rejected<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// The gear that came nearest, where gears are of the catalogue.
    pub gear: Option<&'a str>,
    /// Why.
    pub reason: Reason,
}

/// Why a motor was rejected.
#[derive(Debug, Clone, PartialEq)]
pub enum Reason {
    /// It is no candidate.
    Unusable(Unusable),
    /// No ratio keeps all limits.
    Infeasible(Infeasible),
    /// A limit cannot be checked, and only designs with all limits checked were wanted.
    Unchecked(&'static str, &'static str),
    /// It keeps all that could be judged, but limits that the requirement states cannot be: which, and why.
    Unjudged(Vec<Remark>),
    /// No gear of the catalogue keeps all limits; at the nearest one this is exceeded.
    Gears {
        /// The limit, with its sample.
        bind: Bind,
        /// Demand over limit.
        over: f64,
        /// The limit, in its natural unit; of one of zero there are no multiples.
        allowed: f64,
        /// How many gears were tried.
        tried: usize,
    },
    /// The objective has no lower bound.
    Unbounded,
    /// The program could not be solved.
    NotSolved(String),
}

/// How well a metric's ranking of the feasible motors agrees with the task's.
#[derive(Debug, Clone, PartialEq)]
pub struct Agreement {
    /// The metric.
    pub metric: &'static str,
    /// Kendall's τ_b; `None` where there are too few motors.
    pub tau: Option<f64>,
    /// Number of motors that have the metric.
    pub motors: usize,
}

/// How an optimisation is run.
#[derive(Clone, Copy)]
pub struct Options<'p> {
    /// Reject designs with a limit that cannot be checked, because a number is not known.
    pub only_checked: bool,
    /// Only so many designs of each joint are wanted: motors whose lower bound shows that they are not
    /// among them are not solved.
    pub keep: Option<usize>,
    /// Whether it is told of every motor why it cannot do it. Else, where only the first designs are wanted, it is
    /// told of joints without a design alone: that a motor cannot is often quickly seen, and why it comes nowhere
    /// takes long.
    pub reasons: bool,
    /// Called once for each motor and joint that is done.
    pub tick: &'p (dyn Fn() + Sync),
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options { only_checked: false, keep: None, reasons: true, tick: &|| {} }
    }
}

/// Finds the best ratio of every motor at every joint.
pub fn optimize<'a>(robot: &'a Robot, catalog: &'a Catalog) -> RobotResult<'a> {
    optimize_with(robot, catalog, Options::default())
}

/// As [`optimize`], with options.
pub fn optimize_with<'a>(robot: &'a Robot, catalog: &'a Catalog, options: Options) -> RobotResult<'a> {
    // Joints that ask the same have the same answer: it is found once.
    let first: Vec<usize> = (0..robot.joints.len())
        .map(|j| (0..j).find(|i| robot.joints[*i].asks_the_same(&robot.joints[j])).unwrap_or(j))
        .collect();
    let distinct: Vec<usize> = (0..first.len()).filter(|j| first[*j] == *j).collect();
    let alike = |j: usize| first.iter().filter(|f| **f == j).count();
    let solved: Vec<JointResult> = distinct
        .par_iter()
        .map(|j| {
            let times = alike(*j);
            let tick = || (0..times).for_each(|_| (options.tick)());
            solve_joint(robot, &robot.joints[*j], catalog, Options { tick: &tick, ..options })
        })
        .collect();
    let joints = robot.joints.iter().zip(&first).map(|(joint, first)| {
        let answer = &solved[distinct.binary_search(first).expect("the first of its kind was solved")];
        JointResult { joint, ..answer.clone() }
    });
    RobotResult { robot, joints: joints.collect() }
}

/// All motors at one joint.
fn solve_joint<'a>(robot: &'a Robot, joint: &'a Joint, catalog: &'a Catalog, options: Options) -> JointResult<'a> {
    let demand = JointDemand::new(joint, catalog);
    if let Some(keep) = options.keep {
        let (found, pruned) = prune::first(robot, joint, &demand, catalog, keep, &options);
        let Sorted { candidates, unjudged, rejected } = found;
        return JointResult { joint, candidates, unjudged, rejected, agreement: Vec::new(), pruned: Some(pruned) };
    }
    let found: Vec<Result<Design, Refused>> = catalog
        .motors
        .par_iter()
        .map(|motor| {
            let found = best_design(robot, joint, &demand, motor, options.only_checked);
            (options.tick)();
            found
        })
        .collect();
    let Sorted { candidates, unjudged, rejected } = Sorted::of(found);
    JointResult { joint, agreement: agreement(&candidates), candidates, unjudged, rejected, pruned: None }
}

/// What came of motors, told apart: candidates and unjudged designs best first, what was rejected as it came.
#[derive(Default)]
pub(super) struct Sorted<'a> {
    pub candidates: Vec<Design<'a>>,
    pub unjudged: Vec<Unjudged<'a>>,
    pub rejected: Vec<Rejected<'a>>,
}

impl<'a> Sorted<'a> {
    pub(super) fn of(found: impl IntoIterator<Item = Result<Design<'a>, Refused<'a>>>) -> Sorted<'a> {
        let mut sorted = Sorted::default();
        for result in found {
            match result {
                Ok(design) => sorted.candidates.push(design),
                Err(Refused::Unjudged(unjudged)) => sorted.unjudged.push(*unjudged),
                Err(Refused::Rejected(why)) => sorted.rejected.push(*why),
            }
        }
        sorted.candidates.sort_by(order);
        sorted.unjudged.sort_by(|a, b| order(&a.design, &b.design));
        sorted
    }
}

/// Best first: by objective, then loss, then id.
pub(super) fn order(a: &Design, b: &Design) -> std::cmp::Ordering {
    a.optimum
        .objective
        .total_cmp(&b.optimum.objective)
        .then(a.evaluation.loss.total_cmp(&b.evaluation.loss))
        .then(a.motor.id.cmp(&b.motor.id))
}

/// The best design of one motor at one joint.
///
/// # Errors
/// Why the motor is no choice: it cannot do it, or that it can is not known.
pub fn best_design<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    motor: &'a Motor,
    only_checked: bool,
) -> Result<Design<'a>, Refused<'a>> {
    let reject = |(gear, reason)| Refused::rejected(Rejected { motor, gear, reason });
    let unusable = |why| reject((None, Reason::Unusable(why)));
    if joint.objective.weight(Quantity::Mass) > 0.0 && motor.mass.is_none() {
        return Err(unusable(Unusable::Mass));
    }
    if joint.objective.weight(Quantity::Energy) > 0.0 && !demand.load.has_durations {
        return Err(unusable(Unusable::Durations));
    }
    let candidate = match &joint.ratio {
        RatioChoice::Continuous { .. } => continuous_candidate(robot, joint, &demand.load, motor).map_err(unusable)?,
        RatioChoice::Catalog { .. } if joint.limits.spring.is_some() => {
            return super::spring::best_gear(robot, joint, demand, motor, only_checked);
        }
        RatioChoice::Catalog { .. } => return best_gear(robot, joint, demand, motor, only_checked),
    };
    let prepared = Prepared::new(candidate);
    if let Some((limit, why)) = judge::left_out(robot, joint, &prepared.unchecked, only_checked) {
        return Err(reject((None, Reason::Unchecked(limit, why))));
    }
    let RatioChoice::Continuous { min, max } = joint.ratio else {
        unreachable!("gears of the catalogue were taken above")
    };
    let found = match joint.limits.spring {
        Some(_) => super::spring::solve(&prepared, joint, motor, None, (min, max)),
        None => solve(&prepared, joint, (min, max))
            .map(|optimum| design(&prepared, motor, None, judge::judged_part(&prepared, optimum, only_checked))),
    };
    judge::judged(robot, joint, found.map_err(|reason| reject((None, reason)))?, only_checked)
}

/// The best ratio, or why there is none.
pub(super) fn solve(prepared: &Prepared, joint: &Joint, (min, max): (f64, f64)) -> Result<Optimum, Reason> {
    match RatioProgram::new(prepared, &joint.objective, min, max).solve() {
        Outcome::Optimal(optimum) => Ok(optimum),
        Outcome::Infeasible(infeasible) => Err(Reason::Infeasible(infeasible)),
        Outcome::Unbounded => Err(Reason::Unbounded),
        Outcome::NotSolved(why) => Err(Reason::NotSolved(why)),
    }
}

pub(super) fn design<'a>(prepared: &Prepared, motor: &'a Motor, gear: Option<&'a str>, optimum: Optimum) -> Design<'a> {
    let ratio = optimum.ratio;
    // For one design the costlier figures are worth their time.
    let evaluation = Evaluation {
        energy: prepared.energy(ratio),
        peak_power: Some(prepared.peak_power(ratio)),
        ..prepared.at(ratio)
    };
    let Judged { unchecked, assumed } = prepared.judged(ratio);
    Design {
        motor,
        gear,
        evaluation,
        unchecked,
        assumed,
        winding_temperature: prepared.winding_temperature(ratio),
        reversal_time: prepared.reversal_time(ratio),
        spring: None,
        optimum,
    }
}

/// Whether it is certain, without solving, that [`best_design`] rejects a motor. `false` says nothing.
pub(super) fn is_impossible(robot: &Robot, joint: &Joint, demand: &JointDemand, motor: &Motor) -> bool {
    let RatioChoice::Continuous { min, max } = joint.ratio else { return false };
    if joint.limits.spring.is_some() {
        return false;
    }
    continuous_candidate(robot, joint, &demand.load, motor)
        .is_ok_and(|c| RatioProgram::new(&Prepared::new(c), &joint.objective, min, max).is_impossible())
}

/// The best gear of the catalogue for one motor: all that fit are evaluated, which is the proof.
fn best_gear<'a>(
    robot: &'a Robot,
    joint: &'a Joint,
    demand: &JointDemand<'a>,
    motor: &'a Motor,
    only_checked: bool,
) -> Result<Design<'a>, Refused<'a>> {
    // The best of the designs that can be judged, and of those that cannot.
    let mut best: [Option<(f64, f64, &'a Gear, Prepared)>; 2] = [None, None];
    let mut nearest: Option<(f64, &'a str, Bind, f64, f64)> = None;
    let mut unusable = Unusable::NoGearFits;
    let mut unchecked: Option<(&'a str, Remark)> = None;
    let mut tried = 0;
    for (gear, load) in demand.gears_for(motor) {
        let candidate = match geared_candidate(robot, joint, load, motor, gear) {
            Ok(candidate) => candidate,
            Err(why) => {
                unusable = why;
                continue;
            }
        };
        let prepared = Prepared::new(candidate);
        let here = prepared.unchecked_at(gear.ratio);
        if let Some(what) = judge::left_out(robot, joint, &here, only_checked) {
            unchecked = Some((&gear.id, what));
            continue;
        }
        tried += 1;
        let evaluation = prepared.at(gear.ratio);
        if evaluation.feasible {
            let Some(objective) = evaluation.objective(&joint.objective) else {
                unusable = Unusable::Mass;
                tried -= 1;
                continue;
            };
            let place = usize::from(!judge::unjudged(robot, joint, &here).is_empty());
            if best[place].as_ref().is_none_or(|(o, l, ..)| (objective, evaluation.loss) < (*o, *l)) {
                best[place] = Some((objective, evaluation.loss, gear, prepared));
            }
        } else if let Some(margin) = evaluation.tightest()
            && nearest.as_ref().is_none_or(|(m, ..)| margin.margin > *m)
        {
            let bind = Bind::of(margin.limit, margin.sample);
            nearest = Some((margin.margin, &gear.id, bind, margin.demand / margin.bound, margin.bound));
        }
    }
    let [first, apart] = best;
    if let Some((objective, _, gear, prepared)) = first.or(apart) {
        let found = design(&prepared, motor, Some(&gear.id), one_gear(gear.ratio, objective));
        return judge::judged(robot, joint, found, only_checked);
    }
    let (gear, reason) = match (nearest, unchecked) {
        (Some((_, gear, bind, over, allowed)), _) => (Some(gear), Reason::Gears { bind, over, allowed, tried }),
        (None, Some((gear, (limit, why)))) => (Some(gear), Reason::Unchecked(limit, why)),
        (None, None) => {
            let why = if motor.rotor_inertia.is_none() { Unusable::RotorInertia } else { unusable };
            (None, Reason::Unusable(why))
        }
    };
    Err(Refused::rejected(Rejected { motor, gear, reason }))
}

/// The only ratio of a gear as an optimum: that all gears are evaluated is the proof.
pub(super) fn one_gear(ratio: f64, objective: f64) -> Optimum {
    let bind = Bind::of("gear", None);
    Optimum {
        ratio,
        objective,
        windows: vec![Window { min: ratio, max: ratio, low: bind.clone(), high: bind }],
        certificate: Certificate::Certified { lower_bound: objective, gap: 0.0, method: "all gears evaluated" },
        shadow_prices: Vec::new(),
    }
}

/// Kendall's τ of each metric against the objective, over the feasible motors.
fn agreement(candidates: &[Design]) -> Vec<Agreement> {
    METRICS
        .iter()
        .filter(|m| m.shown == Shown::AsOrder)
        .map(|metric| {
            let sign = if metric.lower_is_better { 1.0 } else { -1.0 };
            let pairs: Vec<(f64, f64)> =
                candidates.iter().filter_map(|d| Some((sign * metric.value(d.motor)?, d.optimum.objective))).collect();
            let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
            Agreement { metric: metric.name, tau: kendall_tau(&a, &b), motors: a.len() }
        })
        .collect()
}

impl JointResult<'_> {
    /// The designs that keep all that could be judged: those that are a choice, then those that cannot be judged.
    pub fn designs(&self) -> impl Iterator<Item = &Design<'_>> {
        self.candidates.iter().chain(self.unjudged.iter().map(|u| &u.design))
    }

    /// Number of motors of the catalogue, solved or not.
    pub fn motors(&self) -> usize {
        let left_out = self.pruned.as_ref().map_or(0, |p| p.behind + p.impossible.len() + p.not_solved.len());
        self.candidates.len() + self.unjudged.len() + self.rejected.len() + left_out
    }
}

impl RobotResult<'_> {
    /// Mass of all actuators of the first choices \[kg\]; `None` where one has no choice or no mass.
    pub fn actuator_mass(&self) -> Option<f64> {
        self.joints.iter().map(|j| Some(j.candidates.first()?.evaluation.mass? * f64::from(j.joint.count))).sum()
    }

    /// Number of different motors among the first choices.
    pub fn distinct_motors(&self) -> usize {
        let mut ids: Vec<&str> =
            self.joints.iter().filter_map(|j| j.candidates.first().map(|d| d.motor.id.as_str())).collect();
        ids.sort_unstable();
        ids.dedup();
        ids.len()
    }

    /// Whether every joint has a design and the budget is kept by the first choices.
    pub fn satisfied(&self) -> bool {
        let budget = &self.robot.budget;
        let mass_kept = match (budget.actuator_mass, self.actuator_mass()) {
            (Some(limit), Some(mass)) => mass <= limit,
            (Some(_), None) => false,
            (None, _) => true,
        };
        let motors_kept = budget.max_distinct_motors.is_none_or(|limit| self.distinct_motors() <= limit as usize);
        self.joints.iter().all(|j| !j.candidates.is_empty()) && mass_kept && motors_kept
    }
}
