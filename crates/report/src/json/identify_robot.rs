//! `identify --json` of a whole robot.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::identify::Answer as JointAnswer;
use super::{document, finite};
use crate::identify::robot::{self as words, Said};
use gearwise_identify::robot::{self as fact, PayloadAnswer, RobotBench};

/// What `identify` prints of the logs of a whole robot.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// Name of the bench.
    pub bench: &'a str,
    /// The description, as the bench file names it.
    pub model: &'a str,
    /// Whether the masses of the description are enough.
    pub payload: Payload<'a>,
    /// The joints that have an actuator.
    pub joints: Vec<Joint<'a>>,
}

/// Whether the masses of the description are enough.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Payload<'a> {
    /// In a sentence.
    pub sentence: String,
    /// `not_asked`, `enough`, `open` (a mass would lower the error, and something else may be it) or `named`.
    pub verdict: &'static str,
    /// Why it is open: `scales`, `one_joint`, `disagree`, `scatters` or `leaves_much`.
    pub open_because: Option<&'static str>,
    /// Links that it may be at; the first suits best.
    pub links: Vec<&'a str>,
    /// Whether a declared payload hangs at the first of them.
    pub at_declared_payload: Option<bool>,
    /// The mass beyond the description.
    pub mass_kg: Option<f64>,
    /// Its ± (95 %).
    pub mass_tolerance_kg: Option<f64>,
    /// Where on the first link it is.
    pub at_m: Option<[f64; 3]>,
    /// Whether that place was fitted.
    pub is_place_fitted: Option<bool>,
    /// Share of the squared error of all joints that it takes away.
    pub gain: Option<f64>,
    /// What joints alone ask for.
    pub joints: Vec<Witness<'a>>,
}

/// What one joint alone asks for.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Witness<'a> {
    /// The joint.
    pub joint: &'a str,
    /// The mass.
    pub mass_kg: Option<f64>,
    /// Its ± (95 %).
    pub mass_tolerance_kg: Option<f64>,
}

/// One joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Joint<'a> {
    /// The joint.
    pub joint: &'a str,
    /// Error with everything as declared, payloads included, on the logs for fitting.
    pub error_as_declared: Option<f64>,
    /// The same on what was held out.
    pub error_as_declared_held_out: Option<f64>,
    /// Why there is no answer.
    pub nothing_because: Option<&'a str>,
    /// The answer, as of one actuator.
    pub answer: Option<JointAnswer<'a>>,
}

/// What the logs of a robot say.
pub fn json(robot: &RobotBench, said: &Said) -> Value {
    let joints = said.joints().map(|(joint, reports)| Joint {
        joint: &robot.joints[joint.joint].name,
        error_as_declared: joint.declared.and_then(|(fit, _)| finite(fit)),
        error_as_declared_held_out: joint.declared.and_then(|(_, held)| held).and_then(finite),
        nothing_because: reports.as_ref().err().map(String::as_str),
        answer: reports.as_ref().ok().map(|reports| JointAnswer::new(&joint.bench, reports, None, None, None)),
    });
    document(
        "identify",
        Answer {
            bench: &robot.name,
            model: &robot.model,
            payload: Payload::new(robot, said.payload),
            joints: joints.collect(),
        },
    )
}

impl<'a> Payload<'a> {
    fn new(robot: &'a RobotBench, answer: &'a PayloadAnswer) -> Payload<'a> {
        let named = match answer {
            PayloadAnswer::Open(named, _) | PayloadAnswer::Named(named) => Some(named),
            PayloadAnswer::NotAsked | PayloadAnswer::Enough(_) => None,
        };
        let felt = match answer {
            PayloadAnswer::Enough(felt) => Some(felt),
            _ => None,
        };
        let carriers = named.iter().flat_map(|n| &n.carriers).chain(felt.map(|f| &f.carrier));
        let witnesses = named.iter().flat_map(|n| &n.witnesses);
        Payload {
            sentence: words::payload(robot, answer),
            verdict: match answer {
                PayloadAnswer::NotAsked => "not_asked",
                PayloadAnswer::Enough(_) => "enough",
                PayloadAnswer::Open(..) => "open",
                PayloadAnswer::Named(_) => "named",
            },
            open_because: match answer {
                PayloadAnswer::Open(_, why) => Some(match why {
                    fact::Asked::Scales => "scales",
                    fact::Asked::OneJoint => "one_joint",
                    fact::Asked::Disagree => "disagree",
                    fact::Asked::Scatters => "scatters",
                    fact::Asked::LeavesMuch => "leaves_much",
                }),
                _ => None,
            },
            links: carriers.clone().map(|c| c.link.as_str()).collect(),
            at_declared_payload: carriers.map(|c| c.has_payload).next(),
            mass_kg: named.map(|n| n.mass).or(felt.map(|f| f.mass)).and_then(finite),
            mass_tolerance_kg: named.map(|n| n.error).or(felt.map(|f| f.error)).and_then(finite),
            at_m: named.map(|n| n.at),
            is_place_fitted: named.map(|n| n.is_place_fitted),
            gain: named.map(|n| n.gain).and_then(finite),
            joints: witnesses
                .map(|w| Witness {
                    joint: &robot.joints[w.joint].name,
                    mass_kg: finite(w.mass),
                    mass_tolerance_kg: finite(w.error),
                })
                .collect(),
        }
    }
}
