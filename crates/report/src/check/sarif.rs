//! A check as SARIF 2.1.0, for code scanning: every rule with its help, every finding with its place, and a
//! fingerprint that stays the same while lines and numbers move.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::{Checked, message, relative};
use gearwise_model::input::sha256;
use gearwise_rules::{Applied, Finding, Location, Severity};

/// Where the form is described.
const SCHEMA: &str = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

/// SARIF's word for a severity.
fn level(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
        Severity::Off => "none",
    }
}

/// A file as a URI: relative to the root where it lies below, percent-encoded.
fn uri(file: &str, root: &Path) -> (String, bool) {
    let file = relative(file, root);
    let mut encoded = String::new();
    for byte in file.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                encoded.push(char::from(byte))
            }
            _ => encoded.push_str(&format!("%{byte:02X}")),
        }
    }
    let drive = file.as_bytes().get(1) == Some(&b':');
    match (file.starts_with('/'), drive) {
        (true, _) => (format!("file://{encoded}"), false),
        (_, true) => (format!("file:///{encoded}"), false),
        _ => (encoded, true),
    }
}

/// Where a file is.
pub(super) fn artifact(file: &str, root: &Path) -> Value {
    let (uri, below) = uri(file, root);
    let mut artifact = Map::new();
    artifact.insert("uri".into(), uri.into());
    if below {
        artifact.insert("uriBaseId".into(), "%SRCROOT%".into());
    }
    Value::Object(artifact)
}

pub(super) fn physical(place: &Location, root: &Path) -> Value {
    json!({
        "artifactLocation": artifact(&place.file, root),
        "region": { "startLine": place.line, "startColumn": place.column, "endLine": place.end_line, "endColumn": place.end_column },
    })
}

fn rule(rule: &Applied) -> Value {
    json!({
        "id": rule.code, "name": rule.name,
        "shortDescription": { "text": rule.summary }, "fullDescription": { "text": rule.help },
        "help": { "text": rule.help },
        "defaultConfiguration": { "level": level(rule.severity), "enabled": rule.severity != Severity::Off },
    })
}

fn result(report: &Checked, finding: &Finding, root: &Path) -> Value {
    let rule = report.rule_of(finding);
    let joint = finding.joint.as_ref().map_or_else(String::new, |j| format!("{j}: "));
    let help = finding.help.as_ref().map_or_else(String::new, |h| format!(". {h}"));
    let reason = finding.reason.as_ref().map_or_else(String::new, |r| format!(" (rules file: {r})"));
    let (design, _) = uri(report.file.unwrap_or(&finding.location.file), root);
    let fingerprint = sha256([format!("{design}\n{}", finding.identity(rule)).as_bytes()]);
    let mut result = json!({
        "ruleId": rule.code, "ruleIndex": finding.rule, "level": level(finding.severity),
        "message": { "text": format!("{joint}{}{reason}{help}", message(finding)) },
        "locations": [{ "physicalLocation": physical(&finding.location, root) }],
        "partialFingerprints": { "gearwiseFinding/v1": fingerprint },
        "properties": { "joint": finding.joint, "subject": finding.subject, "value": finding.value, "bound": finding.bound },
    });
    let Value::Object(object) = &mut result else { return result };
    if let Some(asked) = &finding.asked {
        let related = json!([{ "id": 1, "message": { "text": if report.file.is_some() { "asked for here" } else { "compared with this" } }, "physicalLocation": physical(asked, root) }]);
        object.insert("relatedLocations".into(), related);
    }
    if let Some(why) = &finding.allowed {
        let suppressions = json!([{ "kind": "external", "status": "accepted", "justification": why }]);
        object.insert("suppressions".into(), suppressions);
    }
    result
}

/// The log with one run. `root` is the folder that relative places start from: that of the repository.
pub fn json(report: &Checked, root: &Path) -> Value {
    let results = report.findings.iter().map(|f| result(report, f, root)).collect();
    log(report.rules.iter().map(rule).collect(), results, None)
}

/// A log of rules and results; `came_to_its_end` where that is told.
pub(super) fn log(rules: Value, results: Vec<Value>, came_to_its_end: Option<bool>) -> Value {
    let mut run = json!({
        "tool": { "driver": {
            "name": "gearwise", "semanticVersion": env!("CARGO_PKG_VERSION"), "version": env!("CARGO_PKG_VERSION"),
            "rules": rules,
        } },
        "columnKind": "unicodeCodePoints",
        "originalUriBaseIds": { "%SRCROOT%": { "description": { "text": "the folder in which gearwise ran: the root of the repository" } } },
        "results": results,
    });
    if let Some(successful) = came_to_its_end {
        run["invocations"] = json!([{ "executionSuccessful": successful }]);
    }
    json!({ "$schema": SCHEMA, "version": "2.1.0", "runs": [run] })
}
