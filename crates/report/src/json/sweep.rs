//! `sweep --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{Rejected, Unjudged};
use super::joint::Joint;
use super::{Design, Named, OfRobot, document};
use crate::sweep::{Order, because, class, ordered};
use gearwise_model::requirement;
use gearwise_select::answer::{JointSweep, SweptDesign};

/// What `sweep` prints.
pub type Answer<'a> = OfRobot<'a, Named<'a>, OfJoint<'a>>;

/// A joint and every design that was tried, each list in the order that was asked for.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    #[serde(flatten)]
    joint: Joint<'a>,
    /// Designs that keep every limit, and of which every limit that the requirement states could be judged.
    pub candidates: Vec<Design<'a>>,
    /// Designs that keep all that can be judged; after them motors, or motors with a gear, of which nothing can be worked out.
    pub unjudged: Vec<Unjudged<'a>>,
    /// Designs that do not keep a limit; after them motors, or motors with a gear, that are no candidates at all.
    pub rejected: Vec<Rejected<'a>>,
}

impl<'a> OfJoint<'a> {
    fn new(sweep: &'a JointSweep<'a>, order: Order) -> OfJoint<'a> {
        let joint = sweep.joint;
        let (mut candidates, mut unjudged, mut rejected) = (Vec::new(), Vec::new(), Vec::new());
        for design in ordered(sweep, order) {
            let object = Design::new(design.facts(joint), joint);
            match (design.is_choice(), design.is_unjudged()) {
                (true, _) => candidates.push(object),
                (_, true) => {
                    unjudged.push(Unjudged::new(&design.motor.id, design.gear, &design.unjudged, Some(object)));
                }
                _ => rejected.push(exceeded(design, joint, object)),
            }
        }
        for (motor, gear, why) in &sweep.unusable {
            match why.unknown() {
                Some(what) => unjudged.push(Unjudged::new(&motor.id, *gear, &[what], None)),
                None => {
                    let reason = why.reason().to_string();
                    let (because, class) = (reason.clone(), reason);
                    rejected.push(Rejected {
                        motor: &motor.id,
                        gear: *gear,
                        because,
                        class,
                        turns: None,
                        design: None,
                    });
                }
            }
        }
        OfJoint { joint: Joint::new(joint), candidates, unjudged, rejected }
    }
}

/// A design that exceeds a limit.
fn exceeded<'a>(design: &'a SweptDesign<'a>, joint: &requirement::Joint, object: Design<'a>) -> Rejected<'a> {
    Rejected {
        motor: &design.motor.id,
        gear: design.gear,
        because: because(design, joint),
        class: class(design),
        turns: None,
        design: Some(object),
    }
}

/// Every design, in the order that was asked for.
pub fn json(robot: &requirement::Robot, sweeps: &[JointSweep], order: Order) -> Value {
    let answer = Answer {
        robot: Named::new(&*robot.name, &robot.set),
        joints: sweeps.iter().map(|sweep| OfJoint::new(sweep, order)).collect(),
        mechanism: None,
    };
    document("sweep", answer)
}
