//! What an audit found.

use super::catalog::lacks;
use super::table::paragraph;
use gearwise_model::catalog::Catalog;
use gearwise_model::catalog::audit::{CHECKS, Finding, Severity};
use gearwise_model::catalog::module::audit::MODULE_CHECKS;
use gearwise_model::catalog::outlier::comparisons;

/// Findings that break the audit: errors that no note accepts.
pub fn broken(findings: &[Finding]) -> usize {
    findings.iter().filter(|f| f.severity == Severity::Error && !f.accepted).count()
}

pub(super) fn word(finding: &Finding) -> &'static str {
    match (finding.severity, finding.accepted) {
        (Severity::Error, false) => "error",
        (Severity::Error, true) => "accepted",
        (Severity::Note, _) => "note",
    }
}

/// For people.
pub fn text(catalog: &Catalog, findings: &[Finding]) -> String {
    let mut out = String::new();
    let mut last = "";
    for finding in findings {
        if finding.id != last {
            out.push_str(&format!("{}\n", finding.id));
            last = &finding.id;
        }
        let line = format!("{} [{}] {}", word(finding), finding.code, finding.message);
        out.push_str(&paragraph(&line, 2, 6));
        if let Some(why) = &finding.explanation {
            out.push_str(&paragraph(&format!("→ {why}"), 6, 8));
        }
        if finding.accepted {
            let of_module = || catalog.modules.iter().find(|m| m.id == finding.id).map(|m| m.note.as_str());
            let of_motor = catalog.motors.iter().find(|m| m.id == finding.id).map(|m| m.note.as_str());
            let note = of_motor.or_else(of_module).unwrap_or("");
            out.push_str(&paragraph(&format!("note of the row: {note}"), 6, 8));
        }
    }
    if !findings.is_empty() {
        out.push('\n');
    }
    let accepted = findings.iter().filter(|f| f.accepted && f.severity == Severity::Error).count();
    let notes = findings.iter().filter(|f| f.severity == Severity::Note).count();
    let points: usize = catalog.families.iter().map(|family| family.points.len()).sum();
    let families = match points {
        0 => String::new(),
        _ => format!(", {} of gear families", gearwise_model::words::counted(points, "point")),
    };
    let line = format!(
        "{}, {} and {}{families}, {}: {}, {accepted} explained by the row's note, {}",
        gearwise_model::words::counted(catalog.motors.len(), "motor"),
        gearwise_model::words::counted(catalog.gears.len(), "gear"),
        gearwise_model::words::counted(catalog.modules.len(), "module"),
        gearwise_model::words::counted(CHECKS.len() + MODULE_CHECKS.len() + comparisons().count(), "check"),
        gearwise_model::words::counted(broken(findings), "error"),
        gearwise_model::words::counted(notes, "note"),
    );
    out + &paragraph(&line, 0, 2) + &lacking(catalog)
}

/// What rows lack, after a blank line.
fn lacking(catalog: &Catalog) -> String {
    match lacks::text(catalog) {
        text if text.is_empty() => text,
        text => format!("\n{text}"),
    }
}

/// As rows.
pub fn csv(findings: &[Finding]) -> String {
    super::csv_text(
        &["id", "code", "severity", "message", "explanation"],
        findings.iter().map(|f| {
            vec![
                f.id.clone(),
                f.code.into(),
                word(f).into(),
                f.message.clone(),
                f.explanation.clone().unwrap_or_default(),
            ]
        }),
    )
}
