//! `check-model --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::check::{Location, NotJudged, WrongInput};
use super::{document, finite};
use gearwise_model::mechanism::stated::Quantity;
use gearwise_rules::hardware;
use gearwise_rules::models::ModelJoint;
use gearwise_rules::{self, ModelReport, Severity, clean};

/// What `check-model` prints: what it found, or the mistakes of its input.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum Printed<'a> {
    /// What it found.
    Found(Answer<'a>),
    /// The input is wrong: nothing was checked.
    WrongInput(WrongInput<'a>),
}

/// What `check-model` found: the models, their joints with the hardware, and what the rules found.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// The models.
    pub models: Vec<Model<'a>>,
    /// The file of hardware.
    pub hardware: String,
    /// Whether they pass.
    pub passes: bool,
    /// Whether warnings fail them too, and limits that could not be judged.
    pub strict: bool,
    /// Whether anything was compared with hardware.
    pub judged: bool,
    /// Findings that are errors.
    pub errors: usize,
    /// Findings that are warnings.
    pub warnings: usize,
    /// Findings that are notes.
    pub notes: usize,
    /// What the rules found.
    pub findings: Vec<Finding<'a>>,
    /// Rules that could not be judged, and why.
    pub not_judged: Vec<NotJudged<'a>>,
}

/// A robot model.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Model<'a> {
    /// Name of the robot.
    pub name: &'a str,
    /// The file.
    pub file: String,
    /// `URDF`, `MJCF` or `limits (JSON)`.
    pub form: &'static str,
    /// Its joints that move.
    pub joints: Vec<Joint<'a>>,
    /// What was passed over and may hold something.
    pub notes: &'a [String],
}

/// A joint of a model: what the model states, and what its hardware can do.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Joint<'a> {
    /// Its name.
    pub joint: &'a str,
    /// Ids of the rows; `null` where no hardware is named.
    pub hardware: Option<&'a str>,
    /// Turns of the actuator for one of the joint.
    pub transmission: Option<f64>,
    /// Turns of the motor for one of the actuator.
    pub gear: Option<f64>,
    /// Largest torque that the model states.
    pub effort_nm: Option<f64>,
    /// Peak torque of the hardware at the joint.
    pub peak_torque_nm: Option<Fact<'a>>,
    /// Largest speed that the model states.
    pub velocity_rad_per_s: Option<f64>,
    /// No-load speed of the hardware at the joint.
    pub no_load_speed_rad_per_s: Option<Fact<'a>>,
    /// Largest speed of the hardware at the joint: the least of no-load speed, `max_speed` of the motor and `max_input_speed` of the gear.
    pub largest_speed_rad_per_s: Option<Fact<'a>>,
    /// Inertia of the actuator that the model states.
    pub armature_kgm2: Option<f64>,
    /// Inertia of the hardware at the joint.
    pub inertia_kgm2: Option<Fact<'a>>,
}

/// A number of the hardware at a joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Fact<'a> {
    /// The number.
    pub value: f64,
    /// Ids of the rows.
    pub row: &'a str,
    /// Where the rows have it from.
    pub source: &'a str,
    /// How it was taken to the joint.
    pub conversion: &'a str,
    /// Whether it is a lower bound, because a part of it is not known.
    pub at_least: bool,
}

impl<'a> From<&'a hardware::Fact> for Fact<'a> {
    fn from(of: &'a hardware::Fact) -> Fact<'a> {
        let at_least = of.holds == hardware::Holds::AtLeast;
        Fact { value: of.value, row: &of.row, source: &of.source, conversion: &of.how, at_least }
    }
}

/// What a rule found in a model.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Finding<'a> {
    /// Code of the rule.
    pub code: &'a str,
    /// Name of the rule.
    pub name: &'a str,
    /// `error`, `warning` or `note`.
    pub severity: &'static str,
    /// The joint; `null` for what is no joint's.
    pub joint: Option<&'a str>,
    /// What of it: `effort`, `velocity`, `armature`, `mass` …
    pub subject: &'a str,
    /// What is wrong, with numbers.
    pub message: &'a str,
    /// What to write.
    pub help: Option<&'a str>,
    /// Why the severity is as it is, where the rules file says so.
    pub reason: Option<&'a str>,
    /// The value that was compared, SI.
    pub value: Option<f64>,
    /// What it was compared with, SI.
    pub bound: Option<f64>,
    /// SI unit of both; `1` for a pure number.
    pub unit: Option<&'static str>,
    /// What the hardware allows, and its row; `null` where the finding rests on none.
    pub hardware: Option<Backing<'a>>,
    /// Where it is.
    pub at: Location<'a>,
    /// Where that is with which it disagrees.
    pub compared_with_at: Option<Location<'a>>,
    /// Whether an exception lets it pass.
    pub allowed: bool,
    /// The reason of that exception.
    pub allowed_because: Option<&'a str>,
}

/// What the hardware allows, and its row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Backing<'a> {
    /// What it allows, with its number.
    pub allows: &'a str,
    /// Ids of the rows.
    pub row: &'a str,
    /// Where the rows have it from.
    pub source: &'a str,
    /// How it was taken to the joint.
    pub conversion: &'a str,
}

impl<'a> From<&'a gearwise_rules::Backing> for Backing<'a> {
    fn from(of: &'a gearwise_rules::Backing) -> Backing<'a> {
        Backing { allows: &of.allows, row: &of.row, source: &of.source, conversion: &of.conversion }
    }
}

/// Everything that was checked and found.
pub fn json(report: &ModelReport, strict: bool) -> Value {
    let models = report.facts.models.iter().enumerate();
    let answer = Answer {
        models: models
            .map(|(k, model)| Model {
                name: &model.name,
                file: clean(model.source.name()),
                form: model.form.name(),
                joints: report.facts.of_model(k).map(|(_, of)| joint(of)).collect(),
                notes: &model.notes,
            })
            .collect(),
        hardware: clean(report.facts.file.source.name()),
        passes: report.passes(strict),
        strict,
        judged: report.is_judged(),
        errors: report.count(Severity::Error),
        warnings: report.count(Severity::Warning),
        notes: report.count(Severity::Note),
        findings: report.findings.iter().map(|found| finding(report, found)).collect(),
        not_judged: report
            .not_judged()
            .map(|(rule, joint, because)| NotJudged { code: &rule.code, joint: Some(joint), because })
            .collect(),
    };
    document("check-model", answer)
}

fn joint<'a>(of: &'a ModelJoint<'a>) -> Joint<'a> {
    let stated = |quantity| of.get(quantity).map(|stated| stated.value);
    let hardware = of.hardware;
    Joint {
        joint: &of.joint.name,
        hardware: hardware.map(|h| h.label.as_str()),
        transmission: hardware.map(|h| h.transmission),
        gear: hardware.and_then(|h| h.gear),
        effort_nm: stated(Quantity::Effort),
        peak_torque_nm: hardware.and_then(|h| h.peak.as_ref()).map(Fact::from),
        velocity_rad_per_s: stated(Quantity::Velocity),
        no_load_speed_rad_per_s: hardware.and_then(|h| h.no_load.as_ref()).map(Fact::from),
        largest_speed_rad_per_s: hardware.and_then(|h| h.largest_speed.as_ref()).map(Fact::from),
        armature_kgm2: stated(Quantity::Armature),
        inertia_kgm2: of.reflected.armature.as_ref().map(Fact::from),
    }
}

fn finding<'a>(report: &'a ModelReport, of: &'a gearwise_rules::Finding) -> Finding<'a> {
    let rule = report.rule_of(of);
    Finding {
        code: &rule.code,
        name: &rule.name,
        severity: of.severity.name(),
        joint: of.joint.as_deref(),
        subject: &of.subject,
        message: &of.message,
        help: of.help.as_deref(),
        reason: of.reason.as_deref(),
        value: of.value.and_then(finite),
        bound: of.bound.and_then(finite),
        unit: of.unit.filter(|_| of.value.or(of.bound).is_some()),
        hardware: of.backing.as_ref().map(Backing::from),
        at: (&of.location).into(),
        compared_with_at: of.asked.as_ref().map(Location::from),
        allowed: of.allowed.is_some(),
        allowed_because: of.allowed.as_deref(),
    }
}
