//! What a check found, for people and for machines: one file for each form, all from the same
//! [`Report`].

pub mod github;
pub mod input;
pub mod junit;
pub mod model;
pub mod sarif;
pub mod text;

use std::path::Path;

use gearwise_model::actuator::limits::LIMITS;
use gearwise_rules::measure::measure;
use gearwise_rules::{Applied, Finding, Judged, ModelReport, Report, clean};

/// What forms for machines need of a check, whatever was checked: a design, or robot models.
#[derive(Debug, Clone)]
pub struct Checked<'a> {
    /// The command.
    pub command: &'static str,
    /// Name of the robot, or of the models.
    pub name: String,
    /// The file that was checked; `None` where each finding's own file is.
    pub file: Option<&'a str>,
    /// Names of the joints.
    pub joints: Vec<&'a str>,
    /// The rules that were applied.
    pub rules: &'a [Applied],
    /// The findings.
    pub findings: &'a [Finding],
    /// How each rule went.
    pub judged: &'a [Judged],
}

impl Checked<'_> {
    /// The rule of a finding.
    fn rule_of(&self, finding: &Finding) -> &Applied {
        &self.rules[finding.rule]
    }
}

impl<'a> From<&'a Report<'a>> for Checked<'a> {
    fn from(report: &'a Report<'a>) -> Checked<'a> {
        let design = report.facts.design;
        Checked {
            command: "check",
            name: design.robot.name.clone(),
            file: Some(design.source.name()),
            joints: report.facts.joints.iter().map(|j| j.choice.joint.name.as_str()).collect(),
            rules: &report.rules,
            findings: &report.findings,
            judged: &report.judged,
        }
    }
}

impl<'a> From<&'a ModelReport<'a>> for Checked<'a> {
    fn from(report: &'a ModelReport<'a>) -> Checked<'a> {
        let mut joints: Vec<&str> = Vec::new();
        for joint in &report.facts.joints {
            if !joints.contains(&joint.joint.name.as_str()) {
                joints.push(&joint.joint.name);
            }
        }
        let names: Vec<&str> = report.facts.models.iter().map(|model| model.name.as_str()).collect();
        Checked {
            command: "check-model",
            name: names.join(", "),
            file: None,
            joints,
            rules: &report.rules,
            findings: &report.findings,
            judged: &report.judged,
        }
    }
}

/// What a finding says, with the row of the hardware that it rests on.
fn message(finding: &Finding) -> String {
    match &finding.backing {
        None => finding.message.clone(),
        Some(of) => format!("{}. Hardware: {} = {} ({})", finding.message, of.allows, of.conversion, row(of)),
    }
}

/// A row with its source, where it has one.
fn row(of: &gearwise_rules::Backing) -> String {
    if of.source.is_empty() { of.row.clone() } else { format!("{}; {}", of.row, of.source) }
}

/// A file as tools that know the repository call it: relative to `root` (the folder the program runs in) where it
/// lies below, with forward slashes; else as it is.
pub fn relative(file: &str, root: &Path) -> String {
    let file = clean(file);
    let root = clean(&root.display().to_string());
    match file.strip_prefix(&format!("{}/", root.trim_end_matches('/'))) {
        Some(rest) => rest.to_string(),
        None => file,
    }
}

/// The SI unit of a finding's numbers, by its subject; `1` for a pure number.
pub(crate) fn unit_of(subject: &str) -> &'static str {
    let limit = LIMITS.iter().find(|l| l.name == subject).map(|l| l.unit);
    let measured = || measure(subject).map(|m| m.kind.map_or(m.unit, |kind| kind.si));
    limit.or_else(measured).unwrap_or("1")
}
