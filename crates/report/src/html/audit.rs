//! The page of an audit.

use super::{Page, Part, Section, Table, Verdict};
use crate::audit::{broken, word};
use gearwise_model::catalog::Catalog;
use gearwise_model::catalog::audit::{CHECKS, Finding, Severity};
use gearwise_model::catalog::outlier::comparisons;

/// The page.
pub fn page(catalog: &Catalog, findings: &[Finding]) -> Page {
    let errors = broken(findings);
    let accepted = findings.iter().filter(|f| f.accepted && f.severity == Severity::Error).count();
    let notes = findings.iter().filter(|f| f.severity == Severity::Note).count();
    let headline = match errors {
        0 => "No row contradicts itself without saying why.".to_string(),
        1 => "1 finding is an error: the row contradicts itself and its note does not say why.".into(),
        n => format!("{n} findings are errors: rows contradict themselves and their notes do not say why."),
    };
    let mut table = Table::new("Findings", &["motor", "severity", "code", "finding", "what would explain it"]);
    for finding in findings {
        let motor = catalog.motors.iter().find(|m| m.id == finding.id);
        let note =
            motor.filter(|m| finding.accepted && !m.note.is_empty()).map(|m| format!("the row says: {}", m.note));
        let why = finding.explanation.clone().into_iter().chain(note).collect::<Vec<_>>().join("; ");
        let cells = [&finding.id, word(finding), finding.code, &finding.message, &why];
        table.push(&finding.id, cells.map(String::from).to_vec());
    }
    let parts = table.part().map_or_else(|| vec![Part::Text("Nothing was found.".into())], |part| vec![part]);
    let checks = CHECKS.iter().map(|c| vec![c.code.to_string(), c.compares.to_string()]);
    let checks = checks.chain(comparisons().map(|(code, compares)| vec![code.to_string(), compares]));
    Page {
        command: "audit",
        title: format!(
            "{}, {}",
            gearwise_model::words::counted(catalog.motors.len(), "motor"),
            gearwise_model::words::counted(catalog.gears.len(), "gear")
        ),
        verdict: Verdict::from(errors == 0),
        asked: vec![Part::Text(
            "Whether the numbers of each row agree with each other, by the conventions that the row states.".into(),
        )],
        headline,
        summary: vec![Part::Text(format!(
            "{}, {accepted} explained by the row's note, {}.",
            gearwise_model::words::counted(errors, "error"),
            gearwise_model::words::counted(notes, "note")
        ))],
        sections: vec![
            Section::new("Findings", parts),
            Section::new(
                "What was checked",
                vec![Part::Table(Table::new("Checks", &["code", "compares"]).rows(checks))],
            ),
        ],
        ..Page::default()
    }
}
