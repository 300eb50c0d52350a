//! The choice made again with what was measured, as an object of `identify --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;

use super::design::{Binds, Certificate, Fitted, Pairs, margins};
use super::finite;
use crate::reason::reason_text;
use gearwise_model::effects::Shape;
use gearwise_model::requirement::Joint;
use gearwise_select::remake::{self, Chosen as ChosenFact, Regret as RegretFact};

/// The choice made again.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Remade<'a> {
    /// The first choice of each joint before.
    pub before: Vec<First<'a>>,
    /// The first choice of each joint now.
    pub after: Vec<First<'a>>,
    /// What changes at each joint.
    pub joints: Vec<OfJoint<'a>>,
}

/// The first choice of a joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct First<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    #[serde(flatten)]
    choice: Any<'a>,
}

/// A choice, if there is one.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
enum Any<'a> {
    Chosen(Box<Chosen<'a>>),
    None {
        /// No motor can do it.
        motor: (),
    },
}

/// What the measurement changes at one joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    /// Name of the joint.
    pub joint: &'a str,
    /// Id of the measured motor.
    pub motor: &'a str,
    /// Motors of the catalogue.
    pub motors: usize,
    /// Name of the objective.
    pub objective: String,
    /// Unit of the objective.
    pub objective_unit: &'static str,
    /// The motor by its declared row; `null` where the catalogue does not have it.
    pub before: Option<Choice<'a>>,
    /// The motor as fitted.
    pub after: Choice<'a>,
    /// The same with the friction at the output, where both readings fit the logs.
    pub output_side: Option<Choice<'a>>,
    /// The first choice before.
    pub first_before: Option<Chosen<'a>>,
    /// The first choice now.
    pub first_after: Option<Chosen<'a>>,
    /// What the first choice before costs under the fitted model.
    pub regret: Option<Regret>,
    /// What the ratio of the declared row costs for the fitted motor.
    pub own_regret: Option<Regret>,
    /// What each part of what was fitted moves: the fitted motor without it, chosen again. They need not add up.
    pub parts: Vec<WithoutPart<'a>>,
    /// How what was fitted enters the limits.
    pub effects: Vec<Fitted>,
}

/// The fitted motor without a part of what was fitted.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct WithoutPart<'a> {
    /// The part: the name of an effect, `friction`, `gear` or `numbers` (of the row).
    pub part: &'static str,
    /// The order of an effect that has one.
    pub order: Option<f64>,
    /// The best design without it; `null` where there is none.
    pub without: Option<Chosen<'a>>,
    /// Why there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub because: Option<String>,
}

impl<'a> WithoutPart<'a> {
    fn new(share: &'a remake::Share, joint: &Joint) -> WithoutPart<'a> {
        let (part, order) = match &share.part {
            remake::Part::Effect(fitted) if fitted.effect.shape() == Shape::Order => {
                (fitted.name(), fitted.values.last().copied())
            }
            remake::Part::Effect(fitted) => (fitted.name(), None),
            remake::Part::Friction => ("friction", None),
            remake::Part::Gear => ("gear", None),
            remake::Part::Numbers => ("numbers", None),
        };
        let because = share.without.as_ref().err().map(|reason| reason_text(reason, joint).1);
        WithoutPart { part, order, without: share.without.as_ref().ok().map(Chosen::new), because }
    }
}

/// What became of a motor.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Choice<'a> {
    #[serde(flatten)]
    chosen: Option<Chosen<'a>>,
    /// Why it cannot do it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub because: Option<String>,
    /// Its place among the motors that can; the first is 1.
    pub rank: Option<usize>,
}

/// A design that was chosen.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Chosen<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// Ratio N.
    pub ratio: f64,
    /// Feasible ratios about it.
    pub window: [f64; 2],
    /// What ends the window: limits that are exceeded beyond it, or cannot be judged there.
    pub binds: Binds<&'static str>,
    /// The objective.
    pub objective: Option<f64>,
    /// Mean loss.
    pub loss_w: Option<f64>,
    /// Margin of each limit, by its name.
    pub margins: Pairs<'a>,
    /// How sure it is that no ratio is better.
    pub certificate: Certificate,
}

/// What a choice made before comes to under the fitted model.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Regret {
    /// Its objective there.
    pub objective: Option<f64>,
    /// Whether it keeps every limit there.
    pub feasible: bool,
    /// The limit that it breaks there.
    pub broken: Option<&'static str>,
    /// `(objective − best)/|best|`, best being the choice made again.
    pub relative: Option<f64>,
}

impl<'a> Remade<'a> {
    /// Of every joint.
    pub fn new(remade: &'a [remake::Remade]) -> Remade<'a> {
        let first = |joint: &'a Joint, chosen: &'a Option<ChosenFact>| First {
            joint: &joint.name,
            choice: chosen.as_ref().map_or(Any::None { motor: () }, |c| Any::Chosen(Chosen::new(c).into())),
        };
        Remade {
            before: remade.iter().map(|one| first(one.joint, &one.first_before)).collect(),
            after: remade.iter().map(|one| first(one.joint, &one.first_after)).collect(),
            joints: remade.iter().map(OfJoint::new).collect(),
        }
    }
}

impl<'a> OfJoint<'a> {
    fn new(one: &'a remake::Remade) -> OfJoint<'a> {
        let choice = |choice: &'a remake::Choice| Choice::new(choice, one.joint);
        OfJoint {
            joint: &one.joint.name,
            motor: &one.motor,
            motors: one.motors,
            objective: one.joint.goal(),
            objective_unit: one.joint.objective.unit(),
            before: one.before.as_ref().map(choice),
            after: choice(&one.after),
            output_side: one.output_side.as_ref().map(choice),
            first_before: one.first_before.as_ref().map(Chosen::new),
            first_after: one.first_after.as_ref().map(Chosen::new),
            regret: one.regret.as_ref().map(Regret::new),
            own_regret: one.own_regret.as_ref().map(Regret::new),
            parts: one.shares.iter().map(|share| WithoutPart::new(share, one.joint)).collect(),
            effects: one.notes.iter().cloned().map(Fitted::from).collect(),
        }
    }
}

impl<'a> Choice<'a> {
    fn new(choice: &'a remake::Choice, joint: &Joint) -> Choice<'a> {
        let because = choice.outcome.as_ref().err().map(|reason| reason_text(reason, joint).1);
        Choice { chosen: choice.outcome.as_ref().ok().map(Chosen::new), because, rank: choice.rank }
    }
}

impl<'a> Chosen<'a> {
    fn new(chosen: &'a ChosenFact) -> Chosen<'a> {
        Chosen {
            motor: &chosen.motor,
            gear: chosen.gear.as_deref(),
            ratio: chosen.ratio,
            window: [chosen.window.0, chosen.window.1],
            binds: Binds { low: chosen.binds.0.limit, high: chosen.binds.1.limit },
            objective: finite(chosen.objective),
            loss_w: finite(chosen.loss),
            margins: margins(&chosen.margins),
            certificate: (&chosen.certificate).into(),
        }
    }
}

impl Regret {
    fn new(regret: &RegretFact) -> Regret {
        Regret {
            objective: regret.objective.and_then(finite),
            feasible: regret.broken.is_none(),
            broken: regret.broken.map(|m| m.limit),
            relative: regret.relative.and_then(finite),
        }
    }
}
