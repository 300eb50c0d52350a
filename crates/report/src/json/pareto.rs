//! `optimize --pareto --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{Rejected, Unjudged};
use super::joint::Joint;
use super::optimize::rejected;
use super::{Design, Named, OfRobot, document};
use gearwise_model::requirement;
use gearwise_select::pareto::Front;

/// What `optimize --pareto` prints.
pub type Answer<'a> = OfRobot<'a, Named<'a>, OfJoint<'a>>;

/// A joint and the front of two or more quantities.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    #[serde(flatten)]
    joint: Joint<'a>,
    /// The quantities, in the order in which they were asked for.
    pub quantities: Vec<Axis>,
    /// Designs on the front, the best in the first quantity first.
    pub candidates: Vec<Point<'a>>,
    /// Of each motor with a feasible design whose ratio is free: the ratios that no other of its own betters in all quantities.
    pub efficient: Vec<Efficient<'a>>,
    /// Motors that cannot be judged.
    pub unjudged: Vec<Unjudged<'a>>,
    /// Motors that cannot do it.
    pub rejected: Vec<Rejected<'a>>,
}

/// A quantity of a front.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Axis {
    /// Its name.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
}

/// A design on the front.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Point<'a> {
    #[serde(flatten)]
    design: Design<'a>,
    /// The quantities, SI, in the order of `quantities`.
    pub values: &'a [f64],
    /// Whether the motor's own front is proved: which of its ratios no other of its own betters. With the point itself every ratio of
    /// all other such motors was compared.
    pub certified: bool,
}

/// The ratios of a motor that no other of its own betters in all quantities.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Efficient<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// The smallest best ratio of a quantity: with all ratios between that keep the limits.
    pub ratio_min: f64,
    /// The largest best ratio of a quantity.
    pub ratio_max: f64,
    /// Smaller ratios that belong to them, because the mass steps up with stages and they are the last of theirs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<f64>,
    /// Whether this is proved. Else the best ratios are what was found, and points beyond them may be on the front too.
    pub certified: bool,
}

/// Every point.
pub fn json(robot: &requirement::Robot, fronts: &[Front]) -> Value {
    let answer = Answer {
        robot: Named::new(&*robot.name, &robot.set),
        joints: fronts.iter().map(OfJoint::new).collect(),
        mechanism: None,
    };
    document("optimize --pareto", answer)
}

impl<'a> OfJoint<'a> {
    fn new(front: &'a Front<'a>) -> OfJoint<'a> {
        let joint = front.joint;
        let points = front.points.iter().map(|point| Point {
            design: Design::new(point.facts(joint), joint),
            values: &point.values,
            certified: point.certified,
        });
        let efficient = front.efficient.iter().map(|of| Efficient {
            motor: &of.motor.id,
            ratio_min: of.from,
            ratio_max: of.to,
            stages: of.stages.clone(),
            certified: of.certified,
        });
        let unjudged = front.unjudged.iter().map(|(motor, why)| Unjudged::new(&motor.id, None, why, None));
        OfJoint {
            joint: Joint::new(joint),
            quantities: front.quantities.iter().map(|q| Axis { name: q.name(), unit: q.unit() }).collect(),
            candidates: points.collect(),
            efficient: efficient.collect(),
            unjudged: unjudged.collect(),
            rejected: front.rejected.iter().map(|(motor, why)| rejected(motor, None, why, joint)).collect(),
        }
    }
}
