//! What is found, as facts: designs, and why a motor is none.
//!
//! The one idea: every search of this room and every reader of what it found speaks of the same facts, which know of no
//! search. Words for them are made where they are printed.

use super::Evaluation;
use super::program::{Bind, Infeasible, Optimum, Refusal, Unsolved};
use gearwise_model::actuator::limits::Remark;
use gearwise_model::actuator::thermal::Winding;
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::requirement::{Joint, Robot};

/// What was found for a robot.
#[derive(Debug)]
pub struct RobotResult<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Each joint, in the order of the requirement.
    pub joints: Vec<JointResult<'a>>,
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

    /// The first choices against the budget of mass.
    pub fn mass_budget(&self) -> Budgeted<f64> {
        Budgeted::new(self.robot.budget.actuator_mass, self.actuator_mass())
    }

    /// The first choices against the budget of different motors.
    pub fn motors_budget(&self) -> Budgeted<usize> {
        let limit = self.robot.budget.max_distinct_motors.map(|limit| limit as usize);
        Budgeted::new(limit, Some(self.distinct_motors()))
    }

    /// Whether every joint has a design and the budget is kept by the first choices.
    pub fn satisfied(&self) -> bool {
        let chosen = self.joints.iter().all(|j| !j.candidates.is_empty());
        chosen && self.mass_budget().is_kept() && self.motors_budget().is_kept()
    }
}

/// An amount against a budget.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Budgeted<T> {
    /// There is no budget; the amount, where it is known.
    NotAsked(Option<T>),
    /// The amount, and the budget that it is within.
    Within(T, T),
    /// The amount, and the budget that it is over.
    Over(T, T),
    /// There is a budget, and the amount is not known.
    Unknown(T),
}

impl<T: PartialOrd> Budgeted<T> {
    fn new(limit: Option<T>, amount: Option<T>) -> Budgeted<T> {
        match (limit, amount) {
            (None, amount) => Budgeted::NotAsked(amount),
            (Some(limit), None) => Budgeted::Unknown(limit),
            (Some(limit), Some(amount)) if amount <= limit => Budgeted::Within(amount, limit),
            (Some(limit), Some(amount)) => Budgeted::Over(amount, limit),
        }
    }

    /// Whether it is kept: what is not known is not.
    pub fn is_kept(&self) -> bool {
        matches!(self, Budgeted::NotAsked(_) | Budgeted::Within(..))
    }
}

/// What was found for a joint.
#[derive(Debug, Clone)]
pub struct JointResult<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// Feasible designs of which every limit that the requirement states could be judged, best first: one for each motor.
    pub candidates: Vec<Design<'a>>,
    /// Motors that keep all that could be judged, and of which a limit that the requirement states could not: in the
    /// order that their designs would have; then those of which no design can be worked out. None of them is a choice.
    pub unjudged: Vec<Unjudged<'a>>,
    /// Motors that cannot do it, by id, with the reason.
    pub rejected: Vec<Rejected<'a>>,
    /// Rank correlation between each metric's ranking and the task's; empty where not all motors were solved.
    pub agreement: Vec<Agreement>,
    /// What was left out, where only the first designs were wanted.
    pub pruned: Option<Pruned<'a>>,
    /// Ids of gears that the joint allows and that no motor is evaluated with: their rows say no efficiency.
    pub gears_without_efficiency: Vec<&'a str>,
}

impl JointResult<'_> {
    /// The designs that keep all that could be judged: those that are a choice, then those that cannot be judged.
    pub fn designs(&self) -> impl Iterator<Item = &Design<'_>> {
        self.candidates.iter().chain(self.unjudged.iter().filter_map(|u| u.design.as_ref()))
    }

    /// Number of motors of the catalogue, solved or not.
    pub fn motors(&self) -> usize {
        let left_out = self.pruned.as_ref().map_or(0, |p| p.behind + p.impossible.len() + p.not_solved.len());
        self.candidates.len() + self.unjudged.len() + self.rejected.len() + left_out
    }
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
    /// Winding temperature.
    pub winding_temperature: Winding,
    /// Time the current needs at a reversal \[s\].
    pub reversal_time: Option<f64>,
    /// The parallel spring, where the joint asks for one.
    pub spring: Option<SpringChoice>,
}

impl Design<'_> {
    /// The same with a motor and a gear that outlive the joint or the catalogue it was found with.
    pub(crate) fn with_parts<'a>(self, motor: &'a Motor, gear: Option<&'a str>) -> Design<'a> {
        Design {
            motor,
            gear,
            optimum: self.optimum,
            evaluation: self.evaluation,
            unchecked: self.unchecked,
            assumed: self.assumed,
            winding_temperature: self.winding_temperature,
            reversal_time: self.reversal_time,
            spring: self.spring,
        }
    }

    /// The same with the motor and the gear of its names from the catalogue that it was found in.
    pub(crate) fn of_catalog(self, catalog: &Catalog) -> Design<'_> {
        let motor = catalog.motors.iter().find(|motor| motor.id == self.motor.id).expect("it is of this catalogue");
        let gear = self.gear.and_then(|id| catalog.gear_of(motor, id));
        self.with_parts(motor, gear.map(|gear| gear.id.as_str()))
    }
}

/// A spring that was chosen, and the same joint without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringChoice {
    /// Stiffness \[N·m/rad\].
    pub stiffness: f64,
    /// Rest angle \[rad\]; `None` without stiffness.
    pub rest_angle: Option<f64>,
    /// No ratio and spring are better than this, in the objective's unit; `None` where no bound was found.
    pub lower_bound: Option<f64>,
    /// Relative gap between objective and bound.
    pub gap: Option<f64>,
    /// Whether the objective leaves the spring free, so that the least stiffness was taken.
    pub least_stiffness: bool,
    /// The same motor (and gear) without a spring; `None` where no ratio keeps the limits then.
    pub without: Option<WithoutSpring>,
}

/// The best a motor does without a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WithoutSpring {
    /// Ratio, N.
    pub ratio: f64,
    /// Objective.
    pub objective: f64,
    /// Mean loss \[W\].
    pub loss: f64,
}

impl SpringChoice {
    /// Share of the loss without spring that the spring saves; `None` where there is nothing to compare
    /// with.
    pub fn saving(&self, loss: f64) -> Option<f64> {
        self.without.filter(|w| w.loss > 0.0).map(|w| 1.0 - loss / w.loss)
    }
}

/// A motor of which is not known whether it can do it.
#[derive(Debug, Clone)]
pub struct Unjudged<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// What the requirement states or the model needs and is not known, and why; never empty.
    pub because: Vec<Remark>,
    /// The best design as far as is known: it keeps every limit that could be judged. `None` where none can be worked out.
    pub design: Option<Design<'a>>,
}

impl<'a> Unjudged<'a> {
    /// Of a design.
    pub fn of(design: Design<'a>, because: Vec<Remark>) -> Unjudged<'a> {
        Unjudged { motor: design.motor, gear: design.gear, because, design: Some(design) }
    }
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

/// Why a motor is no candidate for the choice.
#[derive(Debug, Clone)]
pub enum Refused<'a> {
    /// It cannot do it.
    Rejected(Box<Rejected<'a>>),
    /// Whether it can is not known.
    Unjudged(Box<Unjudged<'a>>),
}

impl Refused<'_> {
    /// True if the search for a ratio ended after its share of the work, before each was ruled out.
    pub(super) fn is_ended(&self) -> bool {
        matches!(self, Refused::Rejected(why) if matches!(
            why.reason,
            Reason::NotSolved(Unsolved::NothingRuledOut | Unsolved::Nearly { .. })
        ))
    }
}

impl<'a> Refused<'a> {
    /// A motor that cannot do it.
    pub fn rejected(rejected: Rejected<'a>) -> Refused<'a> {
        Refused::Rejected(Box::new(rejected))
    }

    /// The same, where a number that is missing is no reason to say that the motor cannot.
    #[must_use]
    pub fn told_apart(self) -> Refused<'a> {
        match self {
            Refused::Rejected(why) if let Some(what) = why.reason.unknown() => {
                let Rejected { motor, gear, .. } = *why;
                Refused::Unjudged(Box::new(Unjudged { motor, gear, because: vec![what], design: None }))
            }
            other => other,
        }
    }

    /// Why.
    pub fn reason(&self) -> Reason {
        match self {
            Refused::Rejected(rejected) => rejected.reason.clone(),
            Refused::Unjudged(unjudged) => Reason::Unjudged(unjudged.because.clone()),
        }
    }
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
    /// It keeps every limit, and breaks a design rule that is looked at on the result: which, in words.
    Rule(String),
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
    /// A module, whose ratio is what it is, exceeds a limit.
    Module {
        /// The limit, with its sample.
        bind: Bind,
        /// Demand over limit.
        over: f64,
        /// The limit, in its natural unit.
        allowed: f64,
    },
    /// The objective has no lower bound.
    Unbounded,
    /// The program could not be solved.
    NotSolved(Unsolved),
}

/// What a reason says of a motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Says {
    /// That it cannot do it.
    Cannot,
    /// That it was not asked: the requirement does not allow it.
    NotAllowed,
    /// That it cannot be checked in full, or not be judged.
    NotKnown,
}

impl Reason {
    /// What it says of a motor: one that could not be checked may well do it.
    pub fn says(&self) -> Says {
        match self {
            Reason::Unusable(Unusable::NotAllowed) => Says::NotAllowed,
            Reason::Unchecked(..) | Reason::Unjudged(_) => Says::NotKnown,
            reason if reason.unknown().is_some() => Says::NotKnown,
            _ => Says::Cannot,
        }
    }

    /// The number that is missing, where that alone is why: then whether the motor could do it is not known.
    pub fn unknown(&self) -> Option<Remark> {
        match self {
            Reason::Unusable(why) => why.unknown(),
            Reason::NotSolved(why) => why.unknown(),
            _ => None,
        }
    }
}

/// Why a motor, or a motor with a gear, is not a candidate at all.
#[derive(Debug, Clone, PartialEq)]
pub enum Unusable {
    /// The requirement does not allow it.
    NotAllowed,
    /// The rotor inertia is not known: neither metric nor acceleration torque can be computed.
    RotorInertia,
    /// No gear of the catalogue that the joint allows fits the motor.
    NoGearFits,
    /// The gear's efficiency is not known.
    GearEfficiency,
    /// Its row was fitted with its gear, and the requirement has a family of gears.
    GearMap,
    /// The requirement's family of gears says nothing of the ratio.
    OutsideMap,
    /// The objective needs a mass that is not known.
    Mass,
    /// Energy per cycle needs a cycle: durations of points, numbers of cycles of load cases.
    Durations,
}

impl Unusable {
    /// The number that is missing, where that is why.
    pub fn unknown(&self) -> Option<Remark> {
        let what = match self {
            Unusable::RotorInertia => "rotor_inertia",
            Unusable::GearEfficiency => "gear_efficiency",
            Unusable::Mass => "mass",
            Unusable::NotAllowed
            | Unusable::NoGearFits
            | Unusable::GearMap
            | Unusable::OutsideMap
            | Unusable::Durations => return None,
        };
        Some((what, self.reason()))
    }

    /// In words.
    pub fn reason(&self) -> &'static str {
        match self {
            Unusable::NotAllowed => "the requirement does not allow it",
            Unusable::RotorInertia => "its rotor inertia is not known",
            Unusable::NoGearFits => "no allowed gear of the catalogue fits it",
            Unusable::GearEfficiency => "the gear's efficiency is not known",
            Unusable::GearMap => {
                "it was fitted with its gear, and a gear `map` does not go with fitted effects: give the gear's numbers as \
                 keys of [joint.gear]"
            }
            Unusable::OutsideMap => "the gear's `map` or family says nothing of this ratio",
            Unusable::Mass => "the objective needs a mass that is not known",
            Unusable::Durations => {
                "energy is that of a cycle: points need durations, load cases `cycles` or an `order`"
            }
        }
    }
}

/// What was not solved, because it cannot be among the first.
#[derive(Debug, Clone)]
pub struct Pruned<'a> {
    /// How many designs were to be kept, k.
    pub keep: usize,
    /// Motors that were solved and can do it, but stand behind the first k.
    pub behind: usize,
    /// Motors that certainly cannot do it, where no reason was asked for.
    pub impossible: Vec<&'a Motor>,
    /// Motors that were not solved, each with its lower bound of the objective, by bound.
    pub not_solved: Vec<(&'a Motor, f64)>,
}

impl From<Refusal> for Reason {
    fn from(why: Refusal) -> Reason {
        match why {
            Refusal::Infeasible(why) => Reason::Infeasible(why),
            Refusal::Unbounded => Reason::Unbounded,
            Refusal::NotSolved(why) => Reason::NotSolved(why),
        }
    }
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

/// What was found at one joint.
#[derive(Debug)]
pub struct JointSweep<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// Every design that was evaluated, in the order of motor and ratio.
    pub designs: Vec<SweptDesign<'a>>,
    /// Motors, or motors with a gear, that are no candidates.
    pub unusable: Vec<(&'a Motor, Option<&'a str>, Unusable)>,
}

/// A motor at a ratio.
#[derive(Debug)]
pub struct SweptDesign<'a> {
    /// The motor.
    pub motor: &'a Motor,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// All about it.
    pub evaluation: Evaluation,
    /// Limits that could not be checked, and why.
    pub unchecked: std::sync::Arc<[Remark]>,
    /// Of those, what the requirement itself states: with any of them the design is no choice.
    pub unjudged: std::sync::Arc<[Remark]>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: std::sync::Arc<[Remark]>,
}

impl SweptDesign<'_> {
    /// Whether it keeps every limit, and every limit that the requirement states could be judged.
    pub fn is_choice(&self) -> bool {
        self.evaluation.feasible && self.unjudged.is_empty()
    }

    /// Whether it keeps all that could be judged, but not all that the requirement states could be.
    pub fn is_unjudged(&self) -> bool {
        self.evaluation.feasible && !self.unjudged.is_empty()
    }
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
        sorted.unjudged.sort_by(|a, b| match (&a.design, &b.design) {
            (Some(a), Some(b)) => order(a, b),
            (a, b) => a.is_none().cmp(&b.is_none()),
        });
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
