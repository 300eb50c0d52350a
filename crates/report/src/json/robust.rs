//! `optimize --robust --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{Rejected, Unjudged};
use super::joint::Joint;
use super::optimize::{rejected, unjudged};
use super::{Design, Named, OfRobot, document};
use gearwise_model::requirement;
use gearwise_select::robust::{self, RobustDesign, RobustJoint, SAMPLES, Taken, standard_error};

/// What `optimize --robust` prints.
pub type Answer<'a> = OfRobot<'a, Named<'a>, OfJoint<'a>>;

/// A joint and the designs that keep all limits over the motors' tolerances.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    #[serde(flatten)]
    joint: Joint<'a>,
    /// Designs that keep all limits over all tolerances, the best first.
    pub candidates: Vec<Robust<'a>>,
    /// Motors that cannot be judged by their printed numbers.
    pub unjudged: Vec<Unjudged<'a>>,
    /// Motors that can do it by their printed numbers, but not over their tolerances.
    pub rejected: Vec<Lost<'a>>,
    /// The tolerance, a share, that was assumed of every number whose row states none, temperatures apart; left out where none was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub assumed_tolerance: Option<f64>,
    /// `worst` where the ends of what several sources print were taken as ±; left out where they were not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alternatives: Option<&'static str>,
    /// How many samples of all tolerances were drawn for `contenders`.
    pub samples: usize,
    /// How the first motors fare among each other when all vary within their tolerances.
    pub contenders: Vec<Contender<'a>>,
}

/// A design over its tolerances: its figures are those of the printed numbers at the robust ratio.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Robust<'a> {
    #[serde(flatten)]
    design: Design<'a>,
    /// The numbers that have a tolerance.
    pub tolerances: Vec<Tolerance>,
    /// Whether no number has one: the design is the nominal one.
    pub nominal_only: bool,
    /// Motors within the tolerances that the ratio was solved under.
    pub corners: usize,
    /// True if all limits are proven over the tolerances; false if no number has one.
    pub robust: bool,
    /// Limits that are kept at every motor that was tried within the tolerances, and not proven.
    pub unproven: Vec<&'static str>,
    /// Largest objective at a corner; `null` where no number has a tolerance.
    pub worst_objective: Option<f64>,
    /// Smallest margin at a motor within the tolerances that was looked at.
    pub worst_margin: Option<Tightest>,
    /// The best design for the printed numbers.
    pub nominal: Nominal<'a>,
}

/// A number with its tolerance, in the sheet's convention, SI.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Tolerance {
    /// Column of the catalogue; of a fitted actuator also `effects.NAME.PARAMETER` and `gear.NAME`.
    pub column: String,
    /// The printed number.
    pub value: f64,
    /// Its ±.
    pub tolerance: f64,
    /// The least and the largest number that sources print, where these were taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub published: Option<[f64; 2]>,
}

/// The limit with the smallest margin.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Tightest {
    /// Name of the limit.
    pub limit: &'static str,
    /// `1 − demand/limit`.
    pub margin: f64,
}

/// The best design for the printed numbers.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Nominal<'a> {
    /// Id of the gear.
    pub gear: Option<&'a str>,
    /// Ratio N.
    pub ratio: f64,
    /// Objective.
    pub objective: f64,
}

/// A motor that is lost to its tolerances.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Lost<'a> {
    #[serde(flatten)]
    motor: Rejected<'a>,
    /// The best design for the printed numbers.
    pub nominal: Nominal<'a>,
}

/// A motor among the first ones.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Contender<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Share of the samples in which it keeps all limits at its nominal ratio.
    pub feasible_at_nominal_ratio: Share,
    /// Share in which it is the best, all at their nominal ratios.
    pub first_at_nominal_ratios: Share,
    /// Share in which it keeps all limits at its robust ratio, where it has one.
    pub feasible_at_robust_ratio: Option<Share>,
    /// Share in which it is the best, all at their robust ratios.
    pub first_at_robust_ratios: Share,
}

/// A share of the samples.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Share {
    /// The share.
    pub share: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl From<f64> for Share {
    fn from(share: f64) -> Share {
        Share { share, standard_error: standard_error(share) }
    }
}

impl<'a> Nominal<'a> {
    fn new(design: &'a gearwise_select::answer::Design<'a>) -> Nominal<'a> {
        Nominal { gear: design.gear, ratio: design.optimum.ratio, objective: design.optimum.objective }
    }
}

impl<'a> Robust<'a> {
    fn new(of: &'a RobustDesign<'a>, joint: &'a requirement::Joint) -> Robust<'a> {
        let tolerances = of.toleranced.iter();
        Robust {
            design: Design::new(of.facts(), joint),
            tolerances: tolerances
                .map(|t| Tolerance {
                    column: t.column.to_string(),
                    value: t.value,
                    tolerance: t.tolerance,
                    published: t.published,
                })
                .collect(),
            nominal_only: of.toleranced.is_empty(),
            corners: of.corners,
            robust: of.unproven.is_empty() && !of.toleranced.is_empty(),
            unproven: of.unproven.clone(),
            worst_objective: Some(of.worst_objective).filter(|worst| worst.is_finite() && !of.toleranced.is_empty()),
            worst_margin: of.tightest.map(|m| Tightest { limit: m.limit, margin: m.margin }),
            nominal: Nominal::new(&of.nominal),
        }
    }
}

impl<'a> Contender<'a> {
    fn new(of: &'a robust::Contender<'a>) -> Contender<'a> {
        Contender {
            motor: &of.motor.id,
            feasible_at_nominal_ratio: of.feasible_nominal.into(),
            first_at_nominal_ratios: of.first_nominal.into(),
            feasible_at_robust_ratio: of.feasible_robust.map(Share::from),
            first_at_robust_ratios: of.first_robust.into(),
        }
    }
}

/// Robust designs, and how the first fare.
pub fn json(robot: &requirement::Robot, joints: &[RobustJoint], taken: &Taken) -> Value {
    let joints = joints.iter().map(|of| {
        let joint = of.nominal.joint;
        let lost = of.lost.iter().map(|l| Lost {
            motor: rejected(l.nominal.motor, l.nominal.gear, &l.reason, joint),
            nominal: Nominal::new(&l.nominal),
        });
        OfJoint {
            joint: Joint::new(joint),
            candidates: of.designs.iter().map(|design| Robust::new(design, joint)).collect(),
            unjudged: unjudged(&of.nominal),
            rejected: lost.collect(),
            samples: SAMPLES,
            assumed_tolerance: taken.tolerance,
            alternatives: taken.alternatives.then_some("worst"),
            contenders: of.contenders.iter().map(Contender::new).collect(),
        }
    });
    let answer = Answer { robot: Named::new(&*robot.name, &robot.set), joints: joints.collect(), mechanism: None };
    document("optimize --robust", answer)
}
