//! The one shape of JSON: what every command prints for programs is made of the objects of this folder, and the published
//! schema (`pages::schema`) is made of the same declarations.
//!
//! The one idea: an object is a struct; its fields are its keys in order, their comments are what the schema says of them.
//! Nothing is added to a value after it was made. SI units, the unit in the key; what is not known is `null`.

pub mod catalog;
pub mod characterize;
pub mod check;
pub mod check_model;
pub mod design;
pub mod explain;
pub mod export;
pub mod identify;
pub mod identify_robot;
pub mod import;
pub mod joint;
pub mod motors;
pub mod optimize;
pub mod outlook;
pub mod over;
pub mod pareto;
mod plan;
pub mod remake;
pub mod robot;
pub mod robust;
pub mod rule;
pub mod sweep;
pub mod torques;
mod turns;

use std::borrow::Cow;

#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema};
use serde::Serialize;
use serde_json::Value;

pub use design::Design;

/// Version of the shape: raised when a key is renamed, goes, or means something else.
pub const SCHEMA_VERSION: u32 = 1;

/// What a command prints: which shape it has, which command it was, and the answer.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Envelope<T> {
    /// Version of the shape; raised when a key is renamed, goes, or means something else.
    pub schema_version: u32,
    /// The command.
    pub command: &'static str,
    /// Its answer.
    #[serde(flatten)]
    pub answer: T,
}

/// The answer of a command as a JSON value, in the envelope.
pub fn document(command: &'static str, answer: impl Serialize) -> Value {
    value(Envelope { schema_version: SCHEMA_VERSION, command, answer })
}

/// An object as a JSON value.
///
/// # Panics
/// Never: keys are text, and a number that is not finite is `null`.
pub fn value(of: impl Serialize) -> Value {
    serde_json::to_value(of).expect("keys are text")
}

/// The answer about a robot: the robot, and each joint with what became of the motors.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfRobot<'a, R, J> {
    /// The robot.
    pub robot: R,
    /// Its joints, in the order of the requirement.
    pub joints: Vec<J>,
    /// Where the motions come from a description of the robot: what was made of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mechanism: Option<torques::Mechanism<'a>>,
}

/// A robot by its name.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Named<'a> {
    /// Name of the robot.
    pub name: Cow<'a, str>,
    /// What was put in the place of the requirement's own values; left out where nothing was.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<Setting<'a>>,
}

/// A value in the place of the requirement's own.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Setting<'a> {
    /// Its path.
    pub key: &'a str,
    /// The value, as TOML.
    pub value: &'a str,
}

impl<'a> Setting<'a> {
    /// All of them.
    pub fn all(set: &'a [(String, String)]) -> Vec<Setting<'a>> {
        set.iter().map(|(key, value)| Setting { key, value }).collect()
    }
}

impl<'a> Named<'a> {
    /// A robot of this name, with what was set.
    pub fn new(name: impl Into<Cow<'a, str>>, set: &'a [(String, String)]) -> Named<'a> {
        Named { name: name.into(), set: Setting::all(set) }
    }
}

/// A number that JSON can have.
pub(crate) fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// A number that may be unknown.
#[cfg(feature = "schema")]
pub(crate) fn number_or_null(description: &str) -> Schema {
    schemars::json_schema!({ "type": ["number", "null"], "description": description })
}
