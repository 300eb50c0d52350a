//! What the formats in Python share: literals, names, and the function of a joint.

use super::{Exported, Origin, Wishes, digits, hashes};
use crate::number;

/// A text as a literal of Python.
pub fn literal(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') => {
                out.push_str(&format!("\\U{:08x}", u32::from(c)));
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// Words that no function of Python may be called.
const KEYWORDS: &[&str] = &[
    "and", "as", "assert", "async", "await", "break", "class", "continue", "def", "del", "elif", "else", "except",
    "finally", "for", "from", "global", "if", "import", "in", "is", "lambda", "nonlocal", "not", "or", "pass", "raise",
    "return", "try", "while", "with", "yield", "none", "true", "false", "match", "case", "type",
];

/// Names of joints as identifiers, each of its own.
pub fn identifiers(joints: &[Exported]) -> Vec<String> {
    let mut taken: Vec<String> = Vec::new();
    for e in joints {
        let mut name: String =
            e.joint.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' }).collect();
        if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit() || c == '_') || KEYWORDS.contains(&&*name) {
            name = format!("joint_{name}");
        }
        let mut unique = name.clone();
        for k in 2.. {
            if !taken.contains(&unique) {
                break;
            }
            unique = format!("{name}_{k}");
        }
        taken.push(unique);
    }
    taken
}

/// A pattern with `*` as a regular expression that is matched as a whole.
pub fn expression(pattern: &str) -> String {
    let mut out = String::new();
    for c in pattern.chars() {
        match c {
            '*' => out.push_str(".*"),
            c if c.is_ascii_alphanumeric() || c == '_' || !c.is_ascii() => out.push(c),
            c => out.extend(['\\', c]),
        }
    }
    out
}

/// Expressions of the joints that a joint is in a model, as literals.
pub fn expressions(e: &Exported, wishes: &Wishes) -> Vec<String> {
    wishes.patterns(e.joint).iter().map(|pattern| literal(&expression(pattern))).collect()
}

/// A class of a format with its arguments.
pub struct Call {
    /// Name of the class.
    pub class: &'static str,
    /// Arguments: key, value as Python, and a remark behind it.
    pub arguments: Vec<(&'static str, String, String)>,
    /// Ranges by the words of the format: key, low, high.
    pub ranges: Vec<(&'static str, f64, f64)>,
    /// What these ranges are for.
    pub for_ranges: &'static str,
}

impl Call {
    /// The call of a class.
    pub fn new(class: &'static str, for_ranges: &'static str) -> Call {
        Call { class, arguments: Vec::new(), ranges: Vec::new(), for_ranges }
    }

    /// With an argument.
    pub fn with(&mut self, key: &'static str, value: impl Into<String>, remark: impl Into<String>) {
        self.arguments.push((key, value.into(), remark.into()));
    }

    /// With a number.
    pub fn number(&mut self, key: &'static str, value: f64, remark: impl Into<String>) {
        self.with(key, digits(value), remark);
    }

    /// With a number, where it is known.
    pub fn optional(&mut self, key: &'static str, value: Option<f64>, remark: &str) {
        if let Some(value) = value {
            self.number(key, value, remark);
        }
    }

    /// With the range of a number of the joint, where one is known and was asked for.
    pub fn range(&mut self, key: &'static str, e: &Exported, name: &str) {
        let range = e.spread.as_ref().and_then(|spread| spread.range(name));
        self.ranges.extend(range.map(|r| (key, r.low, r.high)));
    }
}

/// A module of Python: a function of stiffness and damping for each joint, and its ranges.
pub fn module(
    (comments, imports): (&[String], &str),
    origin: &Origin,
    joints: &[Exported],
    mut call: impl FnMut(&Exported) -> Result<Call, String>,
) -> Result<String, String> {
    let mut out = hashes(comments);
    out.push_str(&format!("{}\n\n", literal(&format!("Actuators of {}.", origin.robot))));
    out.push_str(&format!("{imports}\n"));
    for (e, name) in joints.iter().zip(identifiers(joints)) {
        let call = call(e)?;
        let about = format!("{} at N = {}. The gains are yours.", e.motor.id, number(e.simulated.ratio));
        out.push_str(&format!("\n\ndef {name}(stiffness, damping):\n    {}\n", literal(&about)));
        out.push_str(&format!("    return {}(\n", call.class));
        for (key, value, remark) in &call.arguments {
            let remark = if remark.is_empty() { String::new() } else { format!("  # {remark}") };
            out.push_str(&format!("        {key}={value},{remark}\n"));
        }
        out.push_str("    )\n");
        if !call.ranges.is_empty() {
            out.push_str(&format!("\n\n# 95 %: {}\n{}_RANGES = {{\n", call.for_ranges, name.to_uppercase()));
            for (key, low, high) in &call.ranges {
                out.push_str(&format!("    {}: ({}, {}),\n", literal(key), digits(*low), digits(*high)));
            }
            out.push_str("}\n");
        }
        let draws = e.spread.as_ref().map_or(&[][..], |spread| &spread.draws);
        if !draws.is_empty() {
            out.push_str(&format!("\n\n# Draws that keep what belongs together.\n{}_DRAWS = [\n", name.to_uppercase()));
            for draw in draws {
                let numbers = draw.iter().map(|(n, value)| format!("{}: {}", literal(n), digits(*value)));
                out.push_str(&format!("    {{{}}},\n", numbers.collect::<Vec<_>>().join(", ")));
            }
            out.push_str("]\n");
        }
    }
    Ok(out)
}
