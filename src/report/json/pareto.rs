//! `optimize --pareto --json`.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{Rejected, Unjudged};
use super::joint::Joint;
use super::optimize::rejected;
use super::{Design, Named, OfRobot, document};
use crate::design::pareto::Front;
use crate::requirement;

/// What `optimize --pareto` prints.
pub type Answer<'a> = OfRobot<'a, Named<'a>, OfJoint<'a>>;

/// A joint and the front of two quantities.
#[derive(Debug, Serialize, JsonSchema)]
pub struct OfJoint<'a> {
    #[serde(flatten)]
    joint: Joint<'a>,
    /// The two quantities.
    pub quantities: Vec<Axis>,
    /// Designs on the front, the best in the first quantity first.
    pub candidates: Vec<Point<'a>>,
    /// Motors that cannot be judged.
    pub unjudged: Vec<Unjudged<'a>>,
    /// Motors that cannot do it.
    pub rejected: Vec<Rejected<'a>>,
}

/// A quantity of a front.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Axis {
    /// Its name.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
}

/// A design on the front.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Point<'a> {
    #[serde(flatten)]
    design: Design<'a>,
    /// The two quantities, SI.
    pub values: [f64; 2],
    /// Whether the motor's own front is proved.
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
            values: point.values,
            certified: point.certified,
        });
        let unjudged = front.unjudged.iter().map(|(motor, why)| Unjudged::new(&motor.id, None, why, None));
        OfJoint {
            joint: Joint::new(joint),
            quantities: front.quantities.iter().map(|q| Axis { name: q.name(), unit: q.unit() }).collect(),
            candidates: points.collect(),
            unjudged: unjudged.collect(),
            rejected: front.rejected.iter().map(|(motor, why)| rejected(motor, None, why, joint)).collect(),
        }
    }
}
