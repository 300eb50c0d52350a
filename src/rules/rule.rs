//! A rule as data: its code, its texts, and what it looks at.

use super::facts::{JointFacts, RobotFacts};
use super::place::Place;

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
}

impl Remark {
    /// A remark without numbers.
    pub fn new(message: impl Into<String>, subject: impl Into<String>, place: Place) -> Remark {
        let (message, subject) = (message.into(), subject.into());
        Remark { message, subject, place, at_joint: None, asked: None, help: None, value: None, bound: None }
    }
}
