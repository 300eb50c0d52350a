//! `optimize --search --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::document;
use crate::over::Asked;
use crate::said::proof;
use gearwise_select::over::{Looked, best};

/// What `optimize --search` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// The key of the requirement that was searched over.
    pub key: &'a str,
    /// The unit of its values; empty for a bare number.
    pub unit: &'a str,
    /// What is minimised: the sum over all actuators.
    pub objective: &'a str,
    /// The best value that was looked at; `null` where at none every joint has a choice.
    pub best: Option<f64>,
    /// Whether every ratio at the best value is certified. Between the values nothing is.
    pub proved_at_best: bool,
    /// Every value that was looked at, rising.
    pub values: Vec<At<'a>>,
}

/// One value.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct At<'a> {
    /// The value.
    pub value: f64,
    /// The objective summed over all actuators, of a loss with what the transmissions lose; `null` where a joint has no choice.
    pub objective: Option<f64>,
    /// Why the requirement cannot be at this value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cannot_be: Option<&'a str>,
    /// What was chosen for each joint.
    pub joints: Vec<OfJoint<'a>>,
}

/// The first choice of a joint at a value.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    /// The joint.
    pub joint: &'a str,
    /// How many of it there are.
    pub count: u32,
    /// Id of the motor or module; `null` where there is no choice.
    pub motor: Option<&'a str>,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// N.
    pub ratio: Option<f64>,
    /// The objective of one actuator.
    pub objective: Option<f64>,
    /// How the ratio is proved.
    pub proof: Option<String>,
}

/// Every value.
pub fn json(asked: &Asked, all: &[Looked]) -> Value {
    let found = best(all);
    let values = all.iter().map(|looked| At {
        value: looked.value,
        objective: looked.total(),
        cannot_be: looked.found.as_ref().err().map(String::as_str),
        joints: looked.found.as_ref().map_or_else(
            |_| Vec::new(),
            |found| {
                let of = found.iter().map(|f| {
                    let chosen = f.choice.as_ref();
                    OfJoint {
                        joint: &f.joint,
                        count: f.count,
                        motor: chosen.map(|c| c.motor.as_str()),
                        gear: chosen.and_then(|c| c.gear.as_deref()),
                        ratio: chosen.map(|c| c.ratio),
                        objective: chosen.map(|c| c.objective),
                        proof: chosen.map(|c| proof(&c.certificate)),
                    }
                });
                of.collect()
            },
        ),
    });
    let answer = Answer {
        key: &asked.key,
        unit: &asked.unit,
        objective: &asked.objective.0,
        best: found.map(|looked| looked.value),
        proved_at_best: found.is_some_and(Looked::is_proved),
        values: values.collect(),
    };
    document("optimize --search", answer)
}
