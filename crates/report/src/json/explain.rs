//! `explain --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{NotChecked, Solution, Spring, not_checked};
use super::joint::Joint;
use super::{Design, Named, OfRobot, document};
use crate::reason::reason_text;
use gearwise_model::requirement;
use gearwise_select::answer::Reason;
use gearwise_select::explain::{self, Explanation};

/// What `explain` prints: the robot with the one joint that was asked about.
pub type Answer<'a> = OfRobot<'a, Named<'a>, OfJoint<'a>>;

/// The joint, and the design that was asked about.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    #[serde(flatten)]
    joint: Joint<'a>,
    /// The design.
    pub design: Design<'a>,
    /// Whether the requirement allows its ratio or gear.
    pub allowed: bool,
    /// Whether every limit that the requirement states could be judged.
    pub judged: bool,
    /// What the requirement states and cannot be judged.
    pub unjudged: Vec<NotChecked<'a>>,
    /// The best ratio of the motor, or why there is none; `null` where the gear fixes the ratio.
    pub best: Option<Best<'a>>,
    /// By how much the objective changes with a parameter of the motor.
    pub sensitivities: Vec<Sensitivity>,
    /// Single changes that would make it feasible.
    pub remedies: Vec<Remedy>,
    /// The spring, where the joint asks for one.
    pub spring: Option<SpringOrNone>,
}

/// The best ratio, or why there is none.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum Best<'a> {
    /// The best ratio.
    Ratio(Box<BestRatio<'a>>),
    /// Why there is none.
    None(Because),
}

/// The best ratio.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct BestRatio<'a> {
    /// Ratio N.
    pub ratio: f64,
    /// Objective there.
    pub objective: f64,
    #[serde(flatten)]
    solution: Solution<'a>,
}

/// Why there is none.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Because {
    /// In a sentence.
    pub because: String,
}

/// How the objective changes with a parameter of the motor, the ratio chosen again.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Sensitivity {
    /// The parameter.
    pub parameter: &'static str,
    /// Its change, relative.
    pub change: f64,
    /// Change of the objective, relative; `null` where no ratio is feasible any more.
    pub objective_change: Option<f64>,
}

/// A limit that, widened alone, would make it feasible.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Remedy {
    /// Name of the limit.
    pub limit: &'static str,
    /// What it is now.
    pub bound: f64,
    /// What it would have to be.
    pub needed: Option<f64>,
    /// Unit of both.
    pub unit: &'static str,
    /// The ratio at which that is enough.
    pub ratio: f64,
    /// Whose limit it is.
    pub of: &'static str,
    /// Whether a part of the actuator is not known that counts for the limit: then more may be needed. Left out where all are known.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub at_least: bool,
}

impl From<&explain::Remedy> for Remedy {
    fn from(of: &explain::Remedy) -> Remedy {
        Remedy {
            limit: of.limit,
            bound: of.bound,
            needed: Some(of.needed).filter(|needed| needed.is_finite()),
            unit: of.unit,
            ratio: of.ratio,
            of: of.owner,
            at_least: of.at_least,
        }
    }
}

/// The spring, or why no spring will do.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum SpringOrNone {
    /// The spring.
    Chosen(Spring),
    /// Why no spring will do.
    None(NoSpring),
}

/// Why no spring will do.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct NoSpring {
    /// In a sentence.
    pub because: String,
    /// The allowed spring that came nearest: all else is with it; `null`: all else is without a spring.
    pub all_else_with: Option<Nearest>,
}

/// A spring.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Nearest {
    /// Stiffness.
    pub stiffness_nm_per_rad: f64,
    /// Rest angle.
    pub rest_angle_rad: f64,
}

/// The whole story.
pub fn json(robot: &requirement::Robot, story: &Explanation) -> Value {
    let joint = story.joint;
    let because = |reason: &Reason| reason_text(reason, joint).1;
    let best = story.best.as_ref().map(|best| match best {
        Ok(optimum) => Best::Ratio(Box::new(BestRatio {
            ratio: optimum.ratio,
            objective: optimum.objective,
            solution: Solution::new(optimum, joint),
        })),
        Err(reason) => Best::None(Because { because: because(reason) }),
    });
    let nearest =
        story.nearest_spring.map(|(stiffness, rest)| Nearest { stiffness_nm_per_rad: stiffness, rest_angle_rad: rest });
    let spring = story.spring.as_ref().map(|spring| match spring {
        Ok(spring) => SpringOrNone::Chosen(Spring::new(spring, story.evaluation.loss)),
        Err(why) => SpringOrNone::None(NoSpring { because: because(why), all_else_with: nearest }),
    });
    let sensitivities = story.sensitivities.iter().map(|s| Sensitivity {
        parameter: s.parameter,
        change: s.change,
        objective_change: s.objective,
    });
    let of_joint = OfJoint {
        joint: Joint::new(joint),
        design: Design::new(story.facts(), joint),
        allowed: story.forbidden().is_none(),
        judged: story.unjudged.is_empty(),
        unjudged: not_checked(&story.unjudged),
        best,
        sensitivities: sensitivities.collect(),
        remedies: story.remedies.iter().map(Remedy::from).collect(),
        spring,
    };
    let answer = Answer { robot: Named::new(&*robot.name, &robot.set), joints: vec![of_joint], mechanism: None };
    document("explain", answer)
}
