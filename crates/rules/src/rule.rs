//! A rule as data: its code, its texts, and what it looks at.

use super::facts::{JointFacts, RobotFacts};
use super::models::ModelFacts;
use super::place::Place;
use gearwise_model::mechanism::stated::Quantity;
use std::ops::Range as Span;

/// How much a finding weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Not looked at.
    Off,
    /// Worth knowing.
    Note,
    /// Against good practice.
    Warning,
    /// The design may not be built like this.
    Error,
}

impl Severity {
    /// Every severity with the word that a rules file uses for it.
    pub const NAMES: &[(&str, Severity)] =
        &[("error", Severity::Error), ("warning", Severity::Warning), ("note", Severity::Note), ("off", Severity::Off)];

    /// Its word.
    pub fn name(self) -> &'static str {
        Severity::NAMES.iter().find(|(_, s)| *s == self).map_or("", |(name, _)| name)
    }
}

/// A design rule. Its texts are what `gearwise rule` prints, and what SARIF carries as help.
pub struct Rule {
    /// Code, never used for another rule again.
    pub code: &'static str,
    /// Name, in lower case with hyphens.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// How much it weighs unless a rules file says otherwise.
    pub severity: Severity,
    /// What it does.
    pub what: &'static str,
    /// Why breaking it is bad, with source or reasoning for its bounds.
    pub why: &'static str,
    /// A design that breaks it.
    pub example: &'static str,
    /// How to fix that.
    pub fix: &'static str,
    /// What it looks at.
    pub test: Test,
}

/// What a rule looks at.
pub enum Test {
    /// A limit of the model, by its name: the same that sweep and ratio program keep.
    Limit(&'static str),
    /// Measures (by name) of a joint that must lie between bounds, which a rules file may move. Those that are
    /// unknown are not judged.
    Bounds {
        /// Names of the measures.
        measures: &'static [&'static str],
        /// Least value.
        min: Option<f64>,
        /// Largest value.
        max: Option<f64>,
    },
    /// Anything else about a joint.
    Joint(fn(&JointFacts) -> Vec<Remark>),
    /// Anything about the robot as a whole.
    Robot(fn(&RobotFacts) -> Vec<Remark>),
    /// The rules file itself: raised by the check while it applies the file.
    RulesFile,
    /// A joint of a robot model, by its index, against the hardware that drives it.
    ModelJoint(fn(&ModelFacts, usize) -> Judgement),
    /// Anything about robot models as a whole.
    Models(fn(&ModelFacts) -> Vec<ModelRemark>),
}

/// How a rule goes at a joint of a robot model.
#[derive(Debug, Clone, PartialEq)]
pub enum Judgement {
    /// It was judged; what it found.
    Judged(Vec<ModelRemark>),
    /// What it needs is not known, and why: it is no pass.
    NotJudged(&'static str),
    /// It asks nothing of this joint.
    NotAsked,
}

/// The row that a finding about a robot model rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Backing {
    /// What the hardware allows, in words with its number.
    pub allows: String,
    /// Ids of the rows.
    pub row: String,
    /// Where the rows have it from.
    pub source: String,
    /// How the row's number was taken to the joint, in one line.
    pub conversion: String,
}

/// A number that is right in the place of one that is not.
#[derive(Debug, Clone, PartialEq)]
pub struct Instead {
    /// The joint, by its index.
    pub joint: usize,
    /// What of it.
    pub quantity: Quantity,
    /// At the joint, SI.
    pub value: f64,
}

/// What a rule has to say about robot models.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelRemark {
    /// What is wrong, with numbers.
    pub message: String,
    /// What of the joint or model it is about.
    pub subject: &'static str,
    /// The joint that it is about, by its index.
    pub joint: Option<usize>,
    /// Where it is: the model, by its index, or the file of hardware; and its bytes.
    pub at: (Option<usize>, Span<usize>),
    /// Where that is with which it disagrees.
    pub against: Option<(Option<usize>, Span<usize>)>,
    /// How much it weighs, where that is less than the rule's own.
    pub severity: Option<Severity>,
    /// What to write.
    pub help: Option<String>,
    /// The value that was compared, SI.
    pub value: Option<f64>,
    /// What it was compared with, SI.
    pub bound: Option<f64>,
    /// SI unit of both.
    pub unit: &'static str,
    /// The row that it rests on.
    pub backing: Option<Backing>,
    /// What a fix writes.
    pub instead: Vec<Instead>,
}

impl ModelRemark {
    /// A remark without numbers.
    pub fn new(message: impl Into<String>, subject: &'static str, at: (Option<usize>, Span<usize>)) -> ModelRemark {
        ModelRemark {
            message: message.into(),
            subject,
            joint: None,
            at,
            against: None,
            severity: None,
            help: None,
            value: None,
            bound: None,
            unit: "1",
            backing: None,
            instead: Vec::new(),
        }
    }
}

impl std::fmt::Debug for Rule {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.code, self.name)
    }
}

/// What a rule has to say.
#[derive(Debug, Clone, PartialEq)]
pub struct Remark {
    /// What is wrong, with numbers.
    pub message: String,
    /// What of the joint or robot it is about, so that the same finding is known again: a limit, a measure, a
    /// motor's id, a check's code.
    pub subject: String,
    /// Where it stands.
    pub place: Place,
    /// Of a remark about the robot: the joint whose place it is, where it is one.
    pub at_joint: Option<String>,
    /// Where what it breaks is asked for.
    pub asked: Option<Place>,
    /// What to do about it, where more can be said than in the rule's own text.
    pub help: Option<String>,
    /// The value that was compared, SI.
    pub value: Option<f64>,
    /// What it was compared with, SI.
    pub bound: Option<f64>,
    /// Unit of both, where it is not that of the subject: the currency of a price.
    pub unit: Option<&'static str>,
}

impl Remark {
    /// A remark without numbers.
    pub fn new(message: impl Into<String>, subject: impl Into<String>, place: Place) -> Remark {
        let (message, subject) = (message.into(), subject.into());
        Remark {
            message,
            subject,
            place,
            at_joint: None,
            asked: None,
            help: None,
            value: None,
            bound: None,
            unit: None,
        }
    }
}
