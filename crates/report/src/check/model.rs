//! A check of robot models for people.

use std::collections::BTreeMap;

use super::text::{is_same, place};
use crate::table::{Column, Table, paragraph};
use crate::tint::Tint;
use crate::{counted, optional};
use gearwise_model::input::printable;
use gearwise_model::mechanism::stated::Quantity;
use gearwise_rules::{Finding, ModelReport, Severity, clean, rule};

/// The report.
pub fn text(report: &ModelReport, strict: bool) -> String {
    let mut out = String::new();
    for (k, model) in report.facts.models.iter().enumerate() {
        let joints: Vec<_> = report.facts.of_model(k).collect();
        let with = joints.iter().filter(|(_, joint)| joint.hardware.is_some()).count();
        let heading = format!(
            "{}: {}, {}, {with} with hardware",
            printable(&clean(model.source.name())),
            model.form.name(),
            counted(joints.len(), "joint"),
        );
        out.push_str(&paragraph(&heading, 0, 2));
        out.push_str(&table(report, k));
        for note in &model.notes {
            out.push_str(&paragraph(&Tint::Doubtful.on(note), 0, 2));
        }
        out.push('\n');
    }
    let (allowed, open): (Vec<&Finding>, Vec<&Finding>) = report.findings.iter().partition(|f| f.allowed.is_some());
    for severity in [Severity::Error, Severity::Warning, Severity::Note] {
        let mut said: Vec<&Finding> = Vec::new();
        for finding in open.iter().filter(|f| f.severity == severity) {
            if said.iter().any(|other| is_same(other, finding)) {
                continue;
            }
            said.push(finding);
            let joints: Vec<String> =
                open.iter().filter(|f| is_same(f, finding)).filter_map(|f| f.joint.as_deref()).map(printable).collect();
            out.push_str(&format!("{}\n", story(report, finding, &joints)));
        }
    }
    if !allowed.is_empty() {
        out.push_str("Allowed by the rules file:\n");
        for finding in &allowed {
            let rule = report.rule_of(finding);
            let of = finding.joint.as_ref().map_or_else(String::new, |joint| format!("{}: ", printable(joint)));
            let line = format!("{of}{} {}: {}", rule.code, rule.name, printable(&finding.message));
            out.push_str(&paragraph(&line, 2, 4));
            out.push_str(&paragraph(&format!("because {}", finding.allowed.as_deref().unwrap_or("")), 4, 6));
        }
        out.push('\n');
    }
    out.push_str(&not_judged(report));
    let tint = if report.passes(strict) { Tint::Kept } else { Tint::Exceeded };
    out.push_str(&paragraph(&tint.on(&verdict(report, strict)), 0, 2));
    out
}

/// What each joint states, and what its hardware can do.
fn table(report: &ModelReport, model: usize) -> String {
    let rows = report.facts.of_model(model).map(|(_, joint)| {
        let hardware = joint.hardware;
        let stated = |quantity| optional(joint.get(quantity).map(|s| s.value));
        let fact = |fact: Option<&gearwise_rules::hardware::Fact>| optional(fact.map(|f| f.value));
        vec![
            printable(&joint.joint.name),
            hardware.map_or_else(|| "–".into(), |h| printable(&h.label)),
            hardware.map_or_else(|| "–".into(), |h| crate::number(h.transmission)),
            stated(Quantity::Effort),
            fact(hardware.and_then(|h| h.peak.as_ref())),
            stated(Quantity::Velocity),
            fact(hardware.and_then(|h| h.largest_speed.as_ref())),
            stated(Quantity::Armature),
            fact(joint.reflected.armature.as_ref()),
        ]
    });
    let columns = vec![
        Column::name("joint"),
        Column::name("hardware").dropped(2),
        Column::number("r", "").dropped(1),
        Column::number("effort", "N*m"),
        Column::number("peak", "N*m"),
        Column::number("velocity", "rad/s"),
        Column::number("max speed", "rad/s"),
        Column::number("armature", "kg*m^2").dropped(3),
        Column::number("inertia", "kg*m^2").dropped(4),
    ];
    Table::new(columns).also_in("`--json`").rows(rows).text()
}

/// A finding; `joints` are all of which it is found, the place is that of the first.
fn story(report: &ModelReport, finding: &Finding, joints: &[String]) -> String {
    let applied = report.rule_of(finding);
    let head = format!("{} {} {}", finding.severity.name(), applied.code, applied.name);
    let head = Tint::of_severity(finding.severity).map_or_else(|| head.clone(), |tint| tint.on(&head));
    let mut out = paragraph(&format!("{}: {head}", place(&finding.location)), 0, 2);
    let of = if joints.is_empty() { String::new() } else { format!("{}: ", joints.join(", ")) };
    out.push_str(&paragraph(&format!("{of}{}", printable(&finding.message)), 2, 2));
    if let Some(backing) = &finding.backing {
        let line = format!("hardware: {} = {}", printable(&backing.allows), printable(&backing.conversion));
        out.push_str(&paragraph(&line, 2, 4));
        let source =
            if backing.source.is_empty() { String::new() } else { format!(", from {}", printable(&backing.source)) };
        out.push_str(&paragraph(&format!("row: {}{source}", printable(&backing.row)), 2, 4));
    }
    if let Some(other) = &finding.asked {
        out.push_str(&paragraph(&format!("compared with {}", place(other)), 2, 4));
    }
    if let Some(reason) = &finding.reason {
        out.push_str(&paragraph(&format!("reason of the rules file: {}", printable(reason)), 2, 2));
    }
    let fix = finding.help.clone().or_else(|| rule(&applied.code).map(|r| r.fix.to_string()));
    if let Some(fix) = fix {
        out.push_str(&paragraph(&format!("→ {}", printable(&fix)), 2, 4));
    }
    out
}

/// Rules that could not be judged: why, and at which joints.
fn not_judged(report: &ModelReport) -> String {
    let mut all: BTreeMap<(&str, &str, &str), Vec<String>> = BTreeMap::new();
    for (rule, joint, why) in report.not_judged() {
        all.entry((&rule.code, &rule.name, why)).or_default().push(printable(joint));
    }
    let mut out = String::new();
    for ((code, name, why), joints) in &all {
        let count = report.facts.joints.iter().filter(|joint| joint.hardware.is_some()).count();
        let joints = if joints.len() == count { "all joints".to_string() } else { joints.join(", ") };
        let line = format!("not judged: {code} {name}: {why} ({joints})");
        out.push_str(&paragraph(&Tint::Doubtful.on(&line), 0, 2));
    }
    if !out.is_empty() {
        out.push('\n');
    }
    out
}

fn verdict(report: &ModelReport, strict: bool) -> String {
    let count = |severity, word: &str| counted(report.count(severity), word);
    let names: Vec<String> = report.facts.models.iter().map(|m| printable(&clean(m.source.name()))).collect();
    let verdict = match (report.is_judged(), report.passes(strict), report.passes(false)) {
        (false, ..) => "nothing could be judged",
        (true, true, _) => "no error",
        (true, false, true) => "does not pass (--strict: warnings count, and limits that could not be judged)",
        (true, false, false) => "does not pass",
    };
    let allowed = report.findings.iter().filter(|f| f.allowed.is_some()).count();
    format!(
        "{}: {verdict}; {}, {}, {}, {allowed} allowed; {} not judged",
        names.join(", "),
        count(Severity::Error, "error"),
        count(Severity::Warning, "warning"),
        count(Severity::Note, "note"),
        counted(report.not_judged().count(), "question")
    )
}
