//! A check for people.

use std::collections::BTreeMap;

use crate::table::{Column, Table, paragraph};
use crate::tint::Tint;
use crate::{counted, number, optional};
use gearwise_model::input::printable;
use gearwise_rules::lock::LockState;
use gearwise_rules::{Finding, Location, Report, Severity, Test, rule};

/// A place as editors open it.
pub(crate) fn place(location: &Location) -> String {
    let file = printable(&location.file);
    match &location.key {
        None => format!("{file}:{}:{}", location.line, location.column),
        Some(key) if key.is_empty() => file,
        Some(key) => format!("{file} {}", printable(key)),
    }
}

/// The report.
pub fn text(report: &Report, strict: bool) -> String {
    let design = report.facts.design;
    let actuators: u32 = design.robot.joints.iter().map(|j| j.count).sum();
    let heading = format!(
        "{}: {}, {}, {}",
        printable(&design.robot.name),
        counted(design.joints.len(), "joint"),
        counted(actuators as usize, "actuator"),
        counted(report.rules.iter().filter(|r| r.severity != Severity::Off).count(), "rule")
    );
    let mut out = format!("{}\n", paragraph(&heading, 0, 2));
    out.push_str(&joints(report));
    let (allowed, open): (Vec<&Finding>, Vec<&Finding>) = report.findings.iter().partition(|f| f.allowed.is_some());
    for severity in [Severity::Error, Severity::Warning, Severity::Note] {
        let mut told: Vec<&Finding> = Vec::new();
        for finding in open.iter().filter(|f| f.severity == severity) {
            if told.iter().any(|other| is_same(other, finding)) {
                continue;
            }
            told.push(finding);
            let joints = open.iter().filter(|f| is_same(f, finding)).filter_map(|f| f.joint.as_deref());
            let joints: Vec<String> = joints.map(printable).collect();
            out.push_str(&format!("\n{}", story(report, finding, &joints.join(", "))));
        }
    }
    if !allowed.is_empty() {
        out.push_str("\nAllowed by the rules file:\n");
        for finding in &allowed {
            let rule = report.rule_of(finding);
            let line = format!("{}{} {}: {}", of(finding), rule.code, rule.name, printable(&finding.message));
            out.push_str(&paragraph(&line, 2, 4));
            out.push_str(&paragraph(&format!("because {}", finding.allowed.as_deref().unwrap_or("")), 4, 6));
        }
    }
    for (assumption, joints) in assumed(report) {
        out.push_str(&format!("\n{}", paragraph(&format!("{}: assumed: {assumption}", joints.join(", ")), 0, 2)));
    }
    let skipped = not_judged(report);
    if !skipped.is_empty() {
        let line = format!(
            "Not judged, because what they measure is not known, not asked for, or beyond its limit already: {}",
            skipped.join("; ")
        );
        out.push_str(&format!("\n{}", paragraph(&Tint::Doubtful.on(&line), 0, 2)));
    }
    out.push_str(&format!("\n{}", paragraph(&verdict(report, strict), 0, 2)));
    out
}

/// The summary with the colour of what it says.
fn verdict(report: &Report, strict: bool) -> String {
    let tint = if report.passes(strict) { Tint::Kept } else { Tint::Exceeded };
    tint.on(&summary(report, strict))
}

/// Whether two findings say the same of two joints: of the row of a motor that both have.
pub(crate) fn is_same(a: &Finding, b: &Finding) -> bool {
    a.rule == b.rule && a.message == b.message && a.severity == b.severity && a.reason == b.reason && a.help == b.help
}

fn of(finding: &Finding) -> String {
    finding.joint.as_ref().map_or_else(String::new, |joint| format!("{}: ", printable(joint)))
}

fn joints(report: &Report) -> String {
    let rows = report.facts.joints.iter().map(|facts| {
        let choice = &facts.choice;
        let mut row = vec![
            printable(&choice.joint.name),
            choice.joint.count.to_string(),
            printable(&choice.motor.id),
            choice.gear.map_or_else(|| "–".into(), |g| printable(&g.id)),
            number(choice.ratio),
        ];
        match &facts.examined {
            Ok(examined) => {
                let e = &examined.evaluation;
                let tightest = e.tightest();
                row.extend([
                    tightest.map_or_else(|| "–".into(), |m| m.limit.to_string()),
                    tightest.map_or_else(
                        || "–".into(),
                        |m| Tint::of(m).on(&format!("{} %", number((1000.0 * m.margin).round() / 10.0))),
                    ),
                    number(e.loss),
                    optional(e.mass),
                ]);
            }
            Err(_) => row.extend(["not evaluated".into(), "–".into(), "–".into(), "–".into()]),
        }
        row
    });
    let columns = vec![
        Column::name("joint"),
        Column::number("count", "").dropped(1),
        Column::name("motor"),
        Column::name("gear").dropped(2),
        Column::number("N", ""),
        Column::name("tightest"),
        Column::number("margin", ""),
        Column::number("loss", "W").dropped(4),
        Column::number("mass", "kg").dropped(3),
    ];
    Table::new(columns).also_in("`--json`").rows(rows).text()
}

/// `joints` are all of which this is found; the place is the first one's.
fn story(report: &Report, finding: &Finding, joints: &str) -> String {
    let rule = report.rule_of(finding);
    let head = format!("{} {} {}", finding.severity.name(), rule.code, rule.name);
    let head = if rule.code == rule.name { format!("{} {}", finding.severity.name(), rule.name) } else { head };
    let head = match Tint::of_severity(finding.severity) {
        Some(tint) => tint.on(&head),
        None => head,
    };
    let mut out = paragraph(&format!("{}: {head}", place(&finding.location)), 0, 2);
    let of = if joints.is_empty() { String::new() } else { format!("{joints}: ") };
    out.push_str(&paragraph(&format!("{of}{}", printable(&finding.message)), 2, 2));
    if let Some(asked) = &finding.asked {
        out.push_str(&paragraph(&format!("asked for in {}", place(asked)), 2, 4));
    }
    if let Some(reason) = &finding.reason {
        out.push_str(&paragraph(&format!("reason of the rules file: {}", printable(reason)), 2, 2));
    }
    let fix = finding.help.clone().or_else(|| gearwise_rules::rule(&rule.code).map(|r| r.fix.to_string()));
    if let Some(fix) = fix {
        out.push_str(&paragraph(&format!("→ {}", printable(&fix)), 2, 4));
    }
    out
}

/// What counts as kept as far as something holds, each with the joints that it is true of.
pub(crate) fn assumed(report: &Report) -> BTreeMap<String, Vec<String>> {
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for facts in &report.facts.joints {
        let Ok(examined) = &facts.examined else { continue };
        for (limit, what) in &examined.assumed {
            all.entry(format!("{limit}: {what}")).or_default().push(printable(&facts.choice.joint.name));
        }
    }
    all
}

/// Rules with bounds that could be judged nowhere or not at some joints.
pub(crate) fn not_judged(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    for (index, applied) in report.rules.iter().enumerate() {
        let bounds = rule(&applied.code).is_none_or(|r| matches!(r.test, Test::Bounds { .. }));
        let of_rule = || report.judged.iter().filter(move |j| j.rule == index);
        let skipped: Vec<&str> =
            of_rule().filter(|j| j.skipped.is_some()).map(|j| j.joint.as_deref().unwrap_or("robot")).collect();
        if bounds && !skipped.is_empty() {
            let all = skipped.len() == of_rule().count();
            let joints = if all { "all joints".to_string() } else { skipped.join(", ") };
            lines.push(format!("{} {} ({joints})", applied.code, applied.name));
        }
    }
    lines
}

pub(crate) fn summary(report: &Report, strict: bool) -> String {
    let count = |severity, word: &str| {
        let n = report.count(severity);
        format!("{n} {word}{}", if n == 1 { "" } else { "s" })
    };
    let allowed = report.findings.iter().filter(|f| f.allowed.is_some()).count();
    let verdict = match (report.passes(strict), report.passes(false)) {
        (true, _) => "passes",
        (false, true) => "does not pass (--strict: warnings count)",
        (false, false) => "does not pass",
    };
    let lock = match &report.facts.lock {
        LockState::Missing(_) => "no lock".to_string(),
        LockState::Compared { differences, .. } if differences.is_empty() => "rows as locked".to_string(),
        LockState::Compared { .. } => "rows differ from the lock".to_string(),
    };
    format!(
        "{}: {verdict}; {}, {}, {}, {allowed} allowed; {lock}",
        printable(&gearwise_rules::clean(report.facts.design.source.name())),
        count(Severity::Error, "error"),
        count(Severity::Warning, "warning"),
        count(Severity::Note, "note"),
    )
}
