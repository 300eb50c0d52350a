//! A check as JUnit XML, for the test view of any CI system: a suite for each joint and one for the robot, a
//! case for each rule. The form is that of the schema that Jenkins' xunit plugin publishes.

use super::{Checked, message};
use gearwise_model::words::xml::escape;
use gearwise_rules::{Finding, Judged, Severity};

/// Whether a finding fails its case.
fn fails(finding: &Finding, strict: bool) -> bool {
    let least = if strict { Severity::Warning } else { Severity::Error };
    finding.allowed.is_none() && finding.severity >= least
}

fn line(finding: &Finding) -> String {
    let at = &finding.location;
    let allowed = finding.allowed.as_ref().map_or_else(String::new, |why| format!(" (allowed: {why})"));
    format!("{}:{}:{}: {}: {}{allowed}", at.file, at.line, at.column, finding.severity.name(), message(finding))
}

/// The document.
pub fn text(report: &Checked, strict: bool) -> String {
    let name = &report.name;
    let mut suites: Vec<(Option<&str>, Vec<&Judged>)> =
        report.joints.iter().map(|name| (Some(*name), Vec::new())).collect();
    suites.push((None, Vec::new()));
    for judged in report.judged {
        if let Some((_, cases)) = suites.iter_mut().find(|(joint, _)| *joint == judged.joint.as_deref()) {
            cases.push(judged);
        }
    }
    let failing = |judged: &Judged| judged.findings.iter().any(|k| fails(&report.findings[*k], strict));
    let failures = report.judged.iter().filter(|j| failing(j)).count();
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"{}\" tests=\"{}\" failures=\"{failures}\" errors=\"0\">\n",
        escape(&format!("gearwise {} {name}", report.command)),
        report.judged.len()
    );
    for (joint, cases) in &suites {
        let suite = joint.map_or_else(|| name.clone(), |joint| format!("{name}.{joint}"));
        out.push_str(&format!(
            "  <testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"0\" skipped=\"{}\">\n",
            escape(&suite),
            cases.len(),
            cases.iter().filter(|j| failing(j)).count(),
            cases.iter().filter(|j| j.skipped.is_some()).count()
        ));
        for judged in cases {
            out.push_str(&case(report, judged, &suite, strict));
        }
        out.push_str("  </testsuite>\n");
    }
    out.push_str("</testsuites>\n");
    out
}

fn case(report: &Checked, judged: &Judged, suite: &str, strict: bool) -> String {
    let rule = &report.rules[judged.rule];
    let title = if rule.code == rule.name { rule.name.clone() } else { format!("{} {}", rule.code, rule.name) };
    let head = format!("    <testcase name=\"{}\" classname=\"{}\"", escape(&title), escape(suite));
    let mut body = String::new();
    if let Some(why) = judged.skipped {
        body.push_str(&format!("      <skipped message=\"{}\"/>\n", escape(why)));
    }
    let found: Vec<&Finding> = judged.findings.iter().map(|k| &report.findings[*k]).collect();
    let (failed, told): (Vec<&Finding>, Vec<&Finding>) = found.into_iter().partition(|f| fails(f, strict));
    if let Some(first) = failed.first() {
        let lines: Vec<String> = failed.iter().map(|f| line(f)).collect();
        body.push_str(&format!(
            "      <failure message=\"{}\" type=\"{}\">{}\n\n{}</failure>\n",
            escape(&message(first)),
            escape(&rule.code),
            escape(&lines.join("\n")).replace("&#10;", "\n"),
            escape(&rule.help).replace("&#10;", "\n")
        ));
    }
    if !told.is_empty() {
        let lines: Vec<String> = told.iter().map(|f| line(f)).collect();
        body.push_str(&format!(
            "      <system-out>{}</system-out>\n",
            escape(&lines.join("\n")).replace("&#10;", "\n")
        ));
    }
    if body.is_empty() { format!("{head}/>\n") } else { format!("{head}>\n{body}    </testcase>\n") }
}
