//! Designs handed over to a simulator: MJCF, URDF, JSON.
//!
//! The one idea: all three say the same facts of [`SimulatedJoint`], and what a format has no place for stands
//! in its comments. XML is written as text, because its comments are for people; a model that is there already
//! is changed attribute by attribute ([`patch`]) and stays otherwise as its author wrote it.

pub mod mjcf;
pub mod patch;
pub mod urdf;

use crate::actuator::limits::Remark;
use crate::catalog::{Gear, Motor, alternative};
use crate::design::simulated::SimulatedJoint;
use crate::report::json;
use crate::report::unjudged::sentence;
use crate::words::xml::{escape, is_xml};

/// A design of one joint, with where it comes from.
#[derive(Debug)]
pub struct Exported<'a> {
    /// The joint's name.
    pub joint: &'a str,
    /// The motor.
    pub motor: &'a Motor,
    /// The gear of the catalogue, where it is one.
    pub gear: Option<&'a Gear>,
    /// What a simulator is told.
    pub simulated: SimulatedJoint,
    /// Limits that the design breaks; empty where it keeps all that could be checked.
    pub broken: Vec<&'static str>,
    /// Limits that could not be checked.
    pub unchecked: Vec<&'static str>,
    /// Of those, what the requirement itself states, and why it cannot be judged.
    pub unjudged: Vec<Remark>,
}

/// Where an export comes from: the same for all its joints.
#[derive(Debug)]
pub struct Origin {
    /// Name of the robot.
    pub robot: String,
    /// What was put in the place of the requirement's own values: path, and value as TOML.
    pub set: Vec<(String, String)>,
    /// The requirement.
    pub requirement: NamedFile,
    /// The design file, where there is one.
    pub design: Option<NamedFile>,
}

/// A file that an export was made from.
#[derive(Debug)]
pub struct NamedFile {
    /// Its name, without its folder.
    pub name: String,
    /// SHA-256 of its text.
    pub sha256: String,
}

/// A format of an export.
pub struct Format {
    /// The word of `--to`.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Its text.
    pub text: fn(&Origin, &[Exported]) -> String,
}

/// Every format.
pub const FORMATS: &[Format] = &[
    Format {
        name: "mjcf",
        about: "MuJoCo's XML: default classes and motors, to be included in a model",
        text: mjcf::text,
    },
    Format { name: "urdf", about: "Limits, friction and transmissions", text: urdf::text },
    Format {
        name: "json",
        about: "All facts in SI, the unit in the key",
        text: |origin, joints| super::json_text(&json::export::json(origin, joints)),
    },
];

/// First words of a comment that the program wrote: a patch replaces it.
pub const MARK: &str = " gearwise export";

/// The provenance and what is left out, as lines of a comment.
fn comment_lines(origin: &Origin, joints: &[Exported], not_here: impl Fn(&Exported) -> Vec<String>) -> Vec<String> {
    let mut lines = vec![
        format!("{MARK}, gearwise {}", env!("CARGO_PKG_VERSION")),
        format!(
            "requirement {} (robot {}), SHA-256 {}",
            origin.requirement.name, origin.robot, origin.requirement.sha256
        ),
    ];
    if !origin.set.is_empty() {
        let set: Vec<String> = origin.set.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        lines.push(format!("with {}", set.join(", ")));
    }
    lines.extend(origin.design.iter().map(|d| format!("design {}, SHA-256 {}", d.name, d.sha256)));
    for e in joints {
        let s = &e.simulated;
        let through = e.gear.map_or_else(String::new, |g| format!(" with {}", g.id));
        lines.push(format!("joint {}: {}{through} at N = {}", e.joint, e.motor.id, super::number(s.ratio)));
        lines.push(format!("  motor's numbers: {}", e.motor.source));
        for log in e.motor.fit.iter().flat_map(|fit| &fit.provenance) {
            let hash = log.sha256.as_deref().map_or_else(String::new, |h| format!(", SHA-256 {h}"));
            lines.push(format!("  fitted from {}{hash}", log.log));
        }
        let elsewhere =
            e.motor.inside.as_deref().map_or_else(Vec::new, |inside| alternative::lines(&inside.alternatives));
        lines.extend(elsewhere.into_iter().map(|line| format!("  other sources say of {line}")));
        if !e.broken.is_empty() {
            lines.push(format!("  NOT FEASIBLE: breaks {}", e.broken.join(", ")));
        }
        if !e.unjudged.is_empty() {
            lines.push(format!("  NO CHOICE: {}", sentence(&e.unjudged)));
        }
        if !e.unchecked.is_empty() {
            lines.push(format!("  not checked: {}", e.unchecked.join(", ")));
        }
        lines.extend(not_here(e).into_iter().map(|line| format!("  {line}")));
        for left in &s.left_out {
            lines.push(format!("  left out: {}: {}", left.what, left.why));
        }
    }
    lines
}

/// A comment of lines. Two hyphens end a comment, so they are set apart, and a control character is a blank.
fn comment(lines: &[String]) -> String {
    let body = lines.iter().map(|line| tame(line)).collect::<Vec<_>>().join("\n    ");
    format!("<!--{body}\n-->")
}

fn tame(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    for c in line.chars().map(|c| if is_xml(c) && !c.is_control() { c } else { ' ' }) {
        if c == '-' && out.ends_with('-') {
            out.push(' ');
        }
        out.push(c);
    }
    if out.ends_with('-') {
        out.push(' ');
    }
    out
}

/// Twelve digits: what rounding leaves of a product is not shown.
fn digits(value: f64) -> String {
    format!("{value:.11e}").parse::<f64>().unwrap_or(value).to_string()
}

/// `−x x` of a bound.
fn range(bound: f64) -> String {
    format!("-{0} {0}", digits(bound))
}
