//! A check as annotations of GitHub Actions: workflow commands on stdout, one line for each finding.

use std::path::Path;

use super::{Checked, message, relative};
use gearwise_rules::Severity;

/// The data of a command: percent and line ends are escaped.
pub(super) fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// A property of a command: colon and comma too.
pub(super) fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

/// The annotations; findings that are allowed have none.
pub fn text(report: &Checked, root: &Path) -> String {
    let mut out = String::new();
    for finding in report.findings.iter().filter(|f| f.allowed.is_none()) {
        let command = match finding.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            _ => "notice",
        };
        let (rule, at) = (report.rule_of(finding), &finding.location);
        let joint = finding.joint.as_ref().map_or_else(String::new, |j| format!("{j}: "));
        let help = finding.help.as_ref().map_or_else(String::new, |h| format!("\n{h}"));
        let title = if rule.code == rule.name { rule.name.clone() } else { format!("{} {}", rule.code, rule.name) };
        out.push_str(&format!(
            "::{command} file={},line={},col={},endLine={},endColumn={},title={}::{}\n",
            property(&relative(&at.file, root)),
            at.line,
            at.column,
            at.end_line,
            at.end_column,
            property(&title),
            data(&format!("{joint}{}{help}", message(finding)))
        ));
    }
    out
}
