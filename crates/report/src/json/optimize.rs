//! `optimize --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::joint::{Agreement, Choices, Joint, Pruned};
use super::outlook::Outlook;
use super::robot::Choice;
use super::torques::Mechanism;
use super::turns::OtherTurns;
use super::{Design, OfRobot, Setting, design, document};
use crate::reason::reason_text;
use gearwise_select::answer::{self, JointResult, RobotResult};
use gearwise_select::{outlook, robot};

/// What `optimize` prints.
pub type Answer<'a> = OfRobot<'a, Robot<'a>, OfJoint<'a>>;

/// The robot as a whole.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Robot<'a> {
    /// Name of the robot.
    pub name: &'a str,
    /// What was put in the place of the requirement's own values; left out where nothing was.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<Setting<'a>>,
    /// Whether every joint has a candidate, or, where the whole robot was chosen, whether there is a combination.
    pub satisfied: bool,
    /// Whether every limit of every first choice could be checked.
    pub first_choices_fully_checked: bool,
    /// Mass of all first choices; `null` where one is not known.
    pub actuator_mass_kg: Option<f64>,
    /// Number of different motors among the first choices.
    pub distinct_motors: usize,
    /// The choice for the whole robot, where joints are coupled or it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choice: Option<Choice<'a>>,
}

/// A joint and its motors.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    #[serde(flatten)]
    joint: Joint<'a>,
    /// Where the objective is balanced: the lightest design, the balanced one and that with the least loss.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choices: Option<Choices<'a>>,
    /// Designs of which every limit that the requirement states could be judged, the best first.
    pub candidates: Vec<Design<'a>>,
    /// Designs of which such a limit could not be judged: none of them is a choice; after them motors of which no design can be worked out.
    pub unjudged: Vec<design::Unjudged<'a>>,
    /// Motors that cannot do it.
    pub rejected: Vec<design::Rejected<'a>>,
    /// Of the first candidate: how near to its ratio a gear has to be, which gears there are, what decided.
    #[serde(flatten)]
    pub outlook: Outlook<'a>,
    /// How alike orders by metric and the order by the task are.
    pub metric_agreement: Vec<Agreement>,
    /// What was left out, where only the first designs were asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pruned: Option<Pruned<'a>>,
    /// Ids of gears that the joint allows and that no motor is evaluated with: their rows say no efficiency.
    #[serde(skip_serializing_if = "<[&str]>::is_empty")]
    pub gears_without_efficiency: &'a [&'a str],
}

impl<'a> OfJoint<'a> {
    fn new(result: &'a JointResult<'a>, outlook: Option<&'a outlook::Outlook<'a>>) -> OfJoint<'a> {
        let joint = result.joint;
        let ruled_out = |r: &'a answer::Rejected<'a>| {
            let how = outlook.and_then(|outlook| outlook.rewinding(r.motor));
            let turns = how.map(|how| OtherTurns::new(how, r.motor, Some(&r.reason), joint));
            design::Rejected { turns, ..rejected(r.motor, r.gear, &r.reason, joint) }
        };
        OfJoint {
            joint: Joint::new(joint),
            choices: Choices::new(result),
            candidates: result.candidates.iter().map(|d| Design::new(d.facts(), joint)).collect(),
            unjudged: unjudged(result),
            rejected: result.rejected.iter().map(ruled_out).collect(),
            outlook: Outlook::new(result, outlook),
            metric_agreement: result.agreement.iter().map(Agreement::from).collect(),
            pruned: result.pruned.as_ref().map(Pruned::from),
            gears_without_efficiency: &result.gears_without_efficiency,
        }
    }
}

/// Motors of a joint that cannot be judged.
pub(super) fn unjudged<'a>(result: &'a JointResult<'a>) -> Vec<design::Unjudged<'a>> {
    let one = |u: &'a answer::Unjudged<'a>| {
        let known = u.design.as_ref().map(|design| Design::new(design.facts(), result.joint));
        design::Unjudged::new(&u.motor.id, u.gear, &u.because, known)
    };
    result.unjudged.iter().map(one).collect()
}

/// A motor that a reason rules out.
pub(super) fn rejected<'a>(
    motor: &'a gearwise_model::catalog::Motor,
    gear: Option<&'a str>,
    reason: &gearwise_select::answer::Reason,
    joint: &gearwise_model::requirement::Joint,
) -> design::Rejected<'a> {
    let (class, because) = reason_text(reason, joint);
    design::Rejected { motor: &motor.id, gear, because, class, turns: None, design: None }
}

/// The result, with the choice for the whole robot where there is one, and with the outlooks of the joints, in their order.
pub fn json(result: &RobotResult, outlooks: &[outlook::Outlook], choice: Option<&robot::Choice>) -> Value {
    let robot = result.robot;
    let checked = |j: &JointResult| j.candidates.first().is_some_and(|d| d.unchecked.is_empty());
    let outlooks = outlooks.iter().map(Some).chain(std::iter::repeat(None));
    let joints = result.joints.iter().zip(outlooks).map(|(joint, outlook)| OfJoint::new(joint, outlook));
    let answer = Answer {
        robot: Robot {
            name: &robot.name,
            set: Setting::all(&robot.set),
            satisfied: choice.map_or_else(|| result.satisfied(), |c| !c.combinations.is_empty()),
            first_choices_fully_checked: result.joints.iter().all(checked),
            actuator_mass_kg: result.actuator_mass(),
            distinct_motors: result.distinct_motors(),
            choice: choice.map(Choice::new),
        },
        joints: joints.collect(),
        mechanism: robot.driven.as_ref().map(|driven| Mechanism::new(driven, robot)),
    };
    document("optimize", answer)
}
