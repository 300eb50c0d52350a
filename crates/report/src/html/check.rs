//! The page of a check: what was asked, what each rule found with its numbers and how to mend it, and every margin.

use super::{Page, Part, Row, Section, Table, Verdict, asked, estimated, folded};
use crate::check::text::{assumed, not_judged, place, summary};
use crate::check::unit_of;
use crate::explain::{limit_columns, limit_rows};
use crate::{counted, number, optional};
use gearwise_model::input::printable;
use gearwise_rules::facts::JointFacts;
use gearwise_rules::{Finding, Report, Severity, rule};

/// The page.
pub fn page(report: &Report, strict: bool) -> Page {
    let design = report.facts.design;
    let mut of_check = asked::of_robot(&design.robot);
    let rules = report.rules.iter().filter(|r| r.severity != Severity::Off).count();
    let how = if strict { "; warnings count" } else { "" };
    of_check.push(Part::Text(format!("Whether the design may be built: {}{how}.", counted(rules, "rule"))));
    let headline = match (report.passes(strict), report.passes(false)) {
        (true, _) => match report.count(Severity::Warning) {
            0 => "The design passes.".to_string(),
            n => format!("The design passes, with {}.", counted(n, "warning")),
        },
        (false, true) => {
            format!(
                "The design does not pass: {}, and they count.",
                counted(report.count(Severity::Warning), "warning")
            )
        }
        (false, false) => format!("The design does not pass: {}.", counted(report.count(Severity::Error), "error")),
    };
    let mut sections: Vec<Section> = report.facts.joints.iter().map(|facts| of_joint(report, facts)).collect();
    if let Some(part) = findings(report, "The robot as a whole", |f| f.joint.is_none()).part() {
        sections.push(Section::new("The robot as a whole", vec![part]));
    }
    let skipped = not_judged(report);
    if !skipped.is_empty() {
        let why = "What they measure is not known, not asked for, or beyond its limit already.".to_string();
        sections.push(Section::new("Rules that were not judged", vec![Part::Text(why), Part::List(skipped)]));
    }
    let warnings = assumed(report).into_iter().map(|(what, joints)| format!("{}: assumed: {what}", joints.join(", ")));
    Page {
        command: "check",
        title: printable(&design.robot.name),
        verdict: Verdict::from(report.passes(strict)),
        asked: of_check,
        headline,
        summary: vec![Part::Table(joints(report)), Part::Text(summary(report, strict))],
        sections,
        warnings: warnings.collect(),
        ..Page::default()
    }
}

/// How many findings of a joint are of a severity, and no exception lets them pass.
fn count(report: &Report, joint: &str, severity: Severity) -> String {
    let here = |f: &&Finding| f.joint.as_deref() == Some(joint) && f.severity == severity && f.allowed.is_none();
    report.findings.iter().filter(here).count().to_string()
}

/// What is to be built at each joint, and what was found there.
fn joints(report: &Report) -> Table {
    let header = [
        "joint",
        ">×",
        "motor",
        "gear",
        ">N",
        ">loss [W]",
        ">mass [kg]",
        "tightest",
        ">margin [%]",
        "estimated",
        ">errors",
        ">warnings",
        ">notes",
    ];
    let mut table = Table::new("The design", &header);
    for facts in &report.facts.joints {
        let (choice, name) = (&facts.choice, &facts.choice.joint.name);
        let mut cells = vec![name.clone(), choice.joint.count.to_string(), choice.motor.id.clone()];
        cells.extend([choice.gear.map_or_else(String::new, |g| g.id.clone()), number(choice.ratio)]);
        match &facts.examined {
            Ok(examined) => {
                let e = &examined.evaluation;
                let tightest = e.tightest();
                let percent = |margin: f64| number((1000.0 * margin).round() / 10.0);
                cells.extend([number(e.loss), optional(e.mass)]);
                cells.push(tightest.map_or_else(|| "–".into(), |m| m.limit.to_string()));
                cells.push(tightest.map_or_else(|| "–".into(), |m| percent(m.margin)));
            }
            Err(why) => cells.extend(["–".into(), "–".into(), why.reason().to_string(), "–".into()]),
        }
        cells.push(estimated(choice.motor));
        cells.extend([Severity::Error, Severity::Warning, Severity::Note].map(|s| count(report, name, s)));
        table.push(&choice.motor.id, cells);
    }
    table
}

/// What the rules found here, the gravest first.
fn findings(report: &Report, caption: &str, here: impl Fn(&Finding) -> bool) -> Table {
    let header = [
        "severity",
        "rule",
        "finding",
        ">measured",
        ">bound",
        "unit",
        "how to fix",
        "asked for in",
        "in the design",
        "allowed",
    ];
    let mut table = Table::new(caption, &header);
    let mut of: Vec<&Finding> = report.findings.iter().filter(|f| here(f)).collect();
    of.sort_by_key(|f| (f.allowed.is_some(), std::cmp::Reverse(f.severity)));
    for finding in of {
        let applied = report.rule_of(finding);
        let code = match applied.code == applied.name {
            true => applied.name.clone(),
            false => format!("{} {}", applied.code, applied.name),
        };
        let fix = finding.help.clone().or_else(|| rule(&applied.code).map(|r| r.fix.to_string()));
        let reason = finding.reason.as_ref().map_or_else(String::new, |why| format!(" (the rules file: {why})"));
        let value = |of: Option<f64>| of.filter(|v| v.is_finite()).map_or_else(String::new, number);
        let unit =
            finding.value.or(finding.bound).map_or("", |_| finding.unit.unwrap_or_else(|| unit_of(&finding.subject)));
        table.rows.push(Row {
            cells: vec![
                finding.severity.name().into(),
                code,
                format!("{}{reason}", finding.message),
                value(finding.value),
                value(finding.bound),
                if unit == "1" { String::new() } else { crate::plot::unit(unit) },
                fix.unwrap_or_default(),
                finding.asked.as_ref().map_or_else(String::new, place),
                place(&finding.location),
                finding.allowed.as_ref().map_or_else(String::new, |why| format!("because {why}")),
            ],
            faint: finding.allowed.is_some(),
            ..Row::default()
        });
    }
    table
}

fn of_joint(report: &Report, facts: &JointFacts) -> Section {
    let (choice, joint) = (&facts.choice, facts.choice.joint);
    let caption = format!("{}: findings", joint.name);
    let found = findings(report, &caption, |f| f.joint.as_deref() == Some(joint.name.as_str())).part();
    let mut parts = vec![found.unwrap_or_else(|| Part::Text("No rule found anything.".into()))];
    match &facts.examined {
        Ok(examined) => {
            let name = format!("{}: every limit of {} at N = {}", joint.name, choice.motor.id, number(choice.ratio));
            let limits = Table::of(name, &limit_columns()).rows(limit_rows(&examined.evaluation.margins, joint));
            parts.extend(folded("Every limit (on currents: q-axis amperes)", limits.part()));
            let rows = examined.unchecked.iter().map(|(limit, why)| vec![(*limit).to_string(), (*why).to_string()]);
            let unchecked = Table::new(format!("{}: not checked", joint.name), &["limit", "because"]).rows(rows);
            let count = unchecked.rows.len();
            parts.extend(folded(&format!("Not checked ({count})"), unchecked.part()));
        }
        Err(why) => parts.push(Part::Text(format!("It is not evaluated: {}.", why.reason()))),
    }
    Section::new(joint.name.clone(), parts)
}
