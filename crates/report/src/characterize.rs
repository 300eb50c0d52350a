//! What a bench says of a motor: the story for people, and the catalogue row.

use std::sync::Arc;

use super::number;
use super::table::{Column, Table, paragraph, wrap};
use gearwise_identify::Bench;
use gearwise_identify::characterize::estimate::Estimate;
use gearwise_identify::characterize::row::Row;
use gearwise_identify::characterize::{Characterization, Finding, Outcome, Weight};
use gearwise_model::catalog::audit::{Finding as AuditFinding, audit_motor};
use gearwise_model::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Terminals};
use gearwise_model::catalog::import::safe;
use gearwise_model::catalog::row::MotorRow;
use gearwise_model::catalog::{
    About, Conventions, FIELDS, Motor, OwnConventions, Printed, Sheet, SourceKind, read_motors,
};
use gearwise_model::input::Source;
use gearwise_model::words::handy::handy;

pub(super) fn share(relative: f64) -> String {
    let percent = 100.0 * relative;
    match percent {
        p if !p.is_finite() => "–".into(),
        // A ± is not nothing because it is small.
        p if p < 0.095 => format!("{} %", number(rounded(p, 1))),
        p => format!("{} %", number((10.0 * p).round() / 10.0)),
    }
}

/// A number with its ± of 95 %: as many digits as two of the ± need.
pub(super) fn value(e: &Estimate, unit: &'static str) -> String {
    let half = e.half_width();
    let (scaled, unit) = handy(e.value, unit);
    let half = if e.value == 0.0 { half } else { half * scaled / e.value };
    if !(half.is_finite() && half > 0.0) {
        return format!("{} {unit}", number(scaled));
    }
    let digits = (1.0 - half.log10().floor()).clamp(0.0, 9.0) as usize;
    // What rounds to zero has no sign.
    let scaled = if scaled.abs() < 0.5 * 10.0_f64.powi(-(digits as i32)) { 0.0 } else { scaled };
    format!("{scaled:.digits$} ± {half:.digits$} {unit}")
}

/// For people.
pub fn text(bench: &Bench, result: &Characterization, written: &[String]) -> String {
    let logs = bench.logs.len();
    let heading = format!(
        "{}: {}, N = {}; ± are 95 %, motor side, q axis",
        bench.name,
        super::counted(logs, "log"),
        number(bench.declared.ratio)
    );
    let mut out = format!("{}\n", paragraph(&heading, 0, 2));
    for log in bench.logs.iter().filter(|l| !l.remarks.is_empty()) {
        out.push_str(&paragraph(&format!("{}: {}", log.name, log.remarks.join("; ")), 0, 2));
    }
    if bench.logs.iter().any(|l| !l.remarks.is_empty()) {
        out.push('\n');
    }
    let rows = result.outcomes.iter().flat_map(|o| o.quantities.iter().map(move |q| (o, q))).map(|(o, q)| {
        let e = &q.estimate;
        vec![q.name.into(), value(e, q.unit), share(e.relative()), o.test.into()]
    });
    let columns = vec![
        Column::name("quantity"),
        Column::number("value", ""),
        Column::number("±", "").dropped(2),
        Column::name("test").dropped(1),
    ];
    out.push_str(&Table::new(columns).also_in("`--csv`, `--json`").rows(rows).text());
    for outcome in &result.outcomes {
        out.push_str(&section(outcome));
    }
    if !result.findings.is_empty() {
        out.push_str("\nAll tests together\n");
        out.push_str(&findings(&result.findings));
    }
    out.push_str(&row_text(&result.row));
    for line in written {
        out.push_str(&paragraph(line, 0, 2));
    }
    out
}

fn section(outcome: &Outcome) -> String {
    let mut out = format!("\n{}\n", outcome.test);
    for method in &outcome.method {
        out.push_str(&paragraph(method, 2, 2));
    }
    for q in outcome.quantities.iter().filter(|q| !q.remark.is_empty()) {
        out.push_str(&paragraph(&format!("{}: {}", q.name, q.remark), 2, 4));
    }
    for log in &outcome.logs {
        let values: Vec<String> =
            log.values.iter().map(|(name, e, unit)| format!("{name} {}", value(e, unit))).collect();
        let mut parts = values;
        parts.extend(log.remarks.iter().cloned());
        let mark = if log.used { "" } else { " (not used)" };
        out.push_str(&paragraph(&format!("{}{mark}: {}", log.log, parts.join("; ")), 2, 4));
    }
    out.push_str(&findings(&outcome.findings));
    out
}

fn findings(findings: &[Finding]) -> String {
    let mark = |weight: Weight| match weight {
        Weight::Good => "ok     ",
        Weight::Note => "note   ",
        Weight::Warning => "WARNING",
    };
    findings.iter().map(|f| format!("  {} {}\n", mark(f.weight), wrap(&f.text, 10))).collect()
}

fn row_text(row: &Row) -> String {
    let mut out = format!("\nCatalogue row `{}`\n", row.id);
    for (name, from) in &row.taken {
        out.push_str(&paragraph(&format!("{name}: not measured, {from}"), 2, 4));
    }
    if row.missing.is_empty() {
        let line = "complete: `audit`, `rank`, `compare`, `sweep` and `optimize --catalog` read it";
        out.push_str(&paragraph(line, 2, 4));
    } else {
        out.push_str(&paragraph(&format!("not complete: a catalogue row needs {}", row.missing.join(", ")), 2, 4));
    }
    let useful = ["rotor_inertia", "mass", "inductance", "peak_current", "continuous_current"];
    let unknown: Vec<&str> =
        FIELDS.iter().filter(|f| useful.contains(&f.name) && (f.get)(&row.sheet).is_none()).map(|f| f.name).collect();
    if !unknown.is_empty() {
        let text = format!("unknown, which limits what can be checked: {}", unknown.join(", "));
        out.push_str(&paragraph(&text, 2, 2));
    }
    out
}

/// The row as a catalogue file.
///
/// # Errors
/// In words, where the row is not complete or the catalogue's reader does not accept it.
pub fn row_csv(row: &Row) -> Result<String, String> {
    if !row.missing.is_empty() {
        return Err(format!("the row is not complete and was not written: it needs {}", row.missing.join(", ")));
    }
    let text = row_text_csv(row, &[]);
    // What is written is what every other command accepts.
    let unread = |why: String| format!("the row cannot be read back and was not written: {why}");
    let first = motor(&text).map_err(unread)?;
    let explained: Vec<AuditFinding> =
        audit_motor(&first).into_iter().filter(|f| BOTH_MEASURED.contains(&f.code)).collect();
    if explained.is_empty() {
        return Ok(text);
    }
    let text = row_text_csv(row, &explained);
    motor(&text).map_err(unread)?;
    Ok(text)
}

/// What the audit finds between two numbers that were both measured here: known, and said in the note.
const BOTH_MEASURED: &[&str] = &["back-emf", "rotor-inertia"];

/// The row's text; what the audit finds in it is accepted and its note says what.
fn row_text_csv(row: &Row, accepted: &[AuditFinding]) -> String {
    let brushed = row.commutation == Commutation::Brushed;
    let mut sheet = Sheet::default();
    for field in FIELDS {
        let Some(Printed { value, tolerance }) = (field.get)(&row.sheet) else { continue };
        let printed = Printed { value: rounded(value, 7), tolerance: tolerance.map(|t| rounded(t, 3)) };
        (field.set)(&mut sheet, printed);
    }
    sheet.offer = row.sheet.offer.clone();
    let found: Vec<String> = accepted.iter().map(|f| format!("both measured: {}", f.message)).collect();
    let note: Vec<&str> = [row.note.as_str()].into_iter().chain(found.iter().map(String::as_str)).collect();
    let written = MotorRow {
        id: row.id.clone(),
        manufacturer: safe(&row.manufacturer),
        model: safe(&row.model),
        source: safe(&row.source),
        source_date: String::new(),
        source_kind: SourceKind::Measured,
        note: safe(&note.join("; ")),
        accepted_findings: accepted.iter().map(|f| f.code.to_string()).collect(),
        about: About::default(),
        conventions: Conventions {
            commutation: row.commutation,
            terminals: Terminals::QAxis,
            winding: row.winding,
            current: if brushed { CurrentConvention::Dc } else { CurrentConvention::QAxis },
            back_emf: row.sheet.back_emf_constant.map(|_| BackEmfConvention::QAxis),
            speed_constant: None,
            own: OwnConventions::default(),
        },
        pole_pairs: row.pole_pairs.filter(|_| !brushed),
        sheet,
    };
    gearwise_model::catalog::row::csv_text(&[written], &[])
}

/// So many significant digits: more than a measurement says.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

/// The motor of a row's text.
fn motor(text: &str) -> Result<Motor, String> {
    let source = Arc::new(Source::new("row.csv", text));
    match read_motors(&source) {
        Ok(mut motors) if motors.len() == 1 => Ok(motors.remove(0)),
        Ok(_) => Err("it is not one row".into()),
        Err(error) => Err(error.problems.first().map_or_else(String::new, |p| p.message.clone())),
    }
}

/// The row as CSV for `--csv`: nothing where it is not complete.
pub fn csv(result: &Characterization) -> String {
    row_csv(&result.row).unwrap_or_default()
}
