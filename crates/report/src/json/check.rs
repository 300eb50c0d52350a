//! `check --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::{NotChecked, not_checked};
use super::joint::Joint;
use super::{Design, Setting, document};
use crate::check::unit_of;
use gearwise_model::actuator::limits::Remark;
use gearwise_rules::facts::JointFacts;
use gearwise_rules::lock::LockState;
use gearwise_rules::{self, Report, Severity, clean};
use gearwise_select::judge;

/// What `check` prints: what it found, or the mistakes of its input.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged)]
pub enum Printed<'a> {
    /// What it found.
    Found(Answer<'a>),
    /// The input is wrong: nothing was checked.
    WrongInput(WrongInput<'a>),
}

/// The input is wrong: nothing was checked.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct WrongInput<'a> {
    /// False.
    pub passes: bool,
    /// Every mistake.
    pub input_errors: Vec<Mistake<'a>>,
}

/// A mistake of an input file.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Mistake<'a> {
    /// The file.
    pub file: String,
    /// The line, from 1; `null` where it has no place.
    pub line: Option<usize>,
    /// The column, from 1.
    pub column: Option<usize>,
    /// What is wrong.
    pub message: &'a str,
    /// What was expected there.
    pub expected: &'a str,
    /// What to do about it.
    pub help: Option<&'a str>,
}

/// What `check` found: the robot, its joints with the chosen designs, and what the rules found.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// The robot, and the files that were checked.
    pub robot: Robot<'a>,
    /// Whether it passes.
    pub passes: bool,
    /// Whether warnings fail it too.
    pub strict: bool,
    /// Findings that are errors.
    pub errors: usize,
    /// Findings that are warnings.
    pub warnings: usize,
    /// Findings that are notes.
    pub notes: usize,
    /// The joints of the design.
    pub joints: Vec<OfJoint<'a>>,
    /// What the rules found.
    pub findings: Vec<Finding<'a>>,
    /// Rules that could not be judged, and why.
    pub not_judged: Vec<NotJudged<'a>>,
    /// How the lock of the catalogue rows compares.
    pub lock: Lock<'a>,
}

/// The robot and the files that were checked.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Robot<'a> {
    /// Name of the robot.
    pub name: &'a str,
    /// What the design or the call puts in the place of the requirement's own values; left out where nothing is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<Setting<'a>>,
    /// The design file.
    pub design: String,
    /// The requirement file.
    pub requirement: String,
}

/// A joint with its chosen design.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OfJoint<'a> {
    #[serde(flatten)]
    joint: Joint<'a>,
    /// The design; `null` where motor and gear are no candidate.
    pub design: Option<Design<'a>>,
    /// Why motor and gear are no candidate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub because: Option<&'static str>,
    /// Id of the motor that the design file names.
    pub motor: &'a str,
    /// Id of the gear that it names.
    pub gear: Option<&'a str>,
    /// Whether every limit that the requirement states could be judged.
    pub judged: bool,
    /// What the requirement states and cannot be judged.
    pub unjudged: Vec<NotChecked<'a>>,
    /// Inertia of the load about the joint.
    pub load_inertia_kgm2: Option<f64>,
    /// Whether that is an estimate from the motion.
    pub load_inertia_estimated: Option<bool>,
    /// The best ratio of the same motor; `null` where the gear fixes it, or no ratio keeps the limits.
    pub best_ratio: Option<f64>,
}

/// What a rule found.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Finding<'a> {
    /// Code of the rule; its name where it is one of a rules file.
    pub code: &'a str,
    /// Name of the rule.
    pub name: &'a str,
    /// `error`, `warning` or `note`.
    pub severity: &'static str,
    /// The joint; `null` for the robot and the rules file.
    pub joint: Option<&'a str>,
    /// What of it: a limit, a measure, a row.
    pub subject: &'a str,
    /// What is wrong, with numbers.
    pub message: &'a str,
    /// What to do about it.
    pub help: Option<&'a str>,
    /// Why the bound is as it is, where the rules file says so.
    pub reason: Option<&'a str>,
    /// The value that was compared, SI; `null` where it is not finite.
    pub value: Option<f64>,
    /// What it was compared with, SI.
    pub bound: Option<f64>,
    /// SI unit of both; `1` for a pure number.
    pub unit: Option<&'static str>,
    /// Where it is.
    pub at: Location<'a>,
    /// Where what it breaks is asked for.
    pub asked_for_at: Option<Location<'a>>,
    /// Whether an exception lets it pass.
    pub allowed: bool,
    /// The reason of that exception.
    pub allowed_because: Option<&'a str>,
}

/// A place in a file: lines and columns from 1, columns in characters; the end is the first column that no longer belongs
/// to it.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Location<'a> {
    /// The file as it was named.
    pub file: &'a str,
    /// First line.
    pub line: usize,
    /// First column.
    pub column: usize,
    /// Last line.
    pub end_line: usize,
    /// Column after the last.
    pub end_column: usize,
}

impl<'a> From<&'a gearwise_rules::Location> for Location<'a> {
    fn from(of: &'a gearwise_rules::Location) -> Location<'a> {
        Location { file: &of.file, line: of.line, column: of.column, end_line: of.end_line, end_column: of.end_column }
    }
}

/// A rule that could not be judged.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct NotJudged<'a> {
    /// Code of the rule.
    pub code: &'a str,
    /// The joint; `null` for the robot.
    pub joint: Option<&'a str>,
    /// Why.
    pub because: &'static str,
}

/// How the lock compares with the catalogue.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Lock<'a> {
    /// `missing`, `same` or `different`.
    pub state: &'static str,
    /// What differs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub differences: Option<Vec<&'a str>>,
}

/// Everything that was checked and found.
pub fn json(report: &Report, strict: bool) -> Value {
    let design = report.facts.design;
    let unjudged: Vec<Vec<Remark>> = report.facts.joints.iter().map(unjudged).collect();
    let not_judged = report.judged.iter().filter_map(|judged| {
        let because = judged.skipped?;
        Some(NotJudged { code: &report.rules[judged.rule].code, joint: judged.joint.as_deref(), because })
    });
    let lock = match &report.facts.lock {
        LockState::Missing(_) => Lock { state: "missing", differences: None },
        LockState::Compared { differences, .. } => Lock {
            state: if differences.is_empty() { "same" } else { "different" },
            differences: Some(differences.iter().map(|d| d.message.as_str()).collect()),
        },
    };
    let answer = Answer {
        robot: Robot {
            name: &design.robot.name,
            set: Setting::all(&design.robot.set),
            design: clean(design.source.name()),
            requirement: clean(design.requirement.name()),
        },
        passes: report.passes(strict),
        strict,
        errors: report.count(Severity::Error),
        warnings: report.count(Severity::Warning),
        notes: report.count(Severity::Note),
        joints: report.facts.joints.iter().zip(&unjudged).map(|(facts, apart)| of_joint(facts, apart)).collect(),
        findings: report.findings.iter().map(|found| finding(report, found)).collect(),
        not_judged: not_judged.collect(),
        lock,
    };
    document("check", answer)
}

/// What the requirement states and cannot be judged of a joint's design.
fn unjudged(facts: &JointFacts) -> Vec<Remark> {
    let unchecked = facts.examined.as_ref().map_or(&[][..], |examined| &examined.unchecked);
    judge::unjudged(facts.robot, facts.choice.joint, unchecked)
}

fn of_joint<'a>(facts: &'a JointFacts<'a>, unjudged: &'a [Remark]) -> OfJoint<'a> {
    let choice = &facts.choice;
    let examined = facts.examined.as_ref().ok();
    OfJoint {
        joint: Joint::new(choice.joint),
        design: examined.map(|e| Design::new(e.facts(choice), choice.joint)),
        because: facts.examined.as_ref().err().map(|why| why.reason()),
        motor: &choice.motor.id,
        gear: choice.gear.map(|gear| gear.id.as_str()),
        judged: examined.is_some() && unjudged.is_empty(),
        unjudged: not_checked(unjudged),
        load_inertia_kgm2: examined.and_then(|e| e.load_inertia),
        load_inertia_estimated: examined.and_then(|e| e.load_inertia.map(|_| e.load_inertia_estimated)),
        best_ratio: examined.and_then(|e| e.best).map(|best| best.0),
    }
}

fn finding<'a>(report: &'a Report, of: &'a gearwise_rules::Finding) -> Finding<'a> {
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
        value: of.value.filter(|value| value.is_finite()),
        bound: of.bound.filter(|bound| bound.is_finite()),
        unit: of.value.or(of.bound).map(|_| of.unit.unwrap_or_else(|| unit_of(&of.subject))),
        at: (&of.location).into(),
        asked_for_at: of.asked.as_ref().map(Location::from),
        allowed: of.allowed.is_some(),
        allowed_because: of.allowed.as_deref(),
    }
}
