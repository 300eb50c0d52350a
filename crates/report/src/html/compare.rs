//! The page of a comparison.

use super::{Page, Part, Section, Table};
use crate::catalog::card::estimate_line;
use crate::compare::{Comparison, faster, tables};
use crate::plot::step as plot;
use gearwise_model::catalog::audit::{audit_motor, conventions_line};

/// The page.
pub fn page(comparison: &Comparison) -> Page {
    let [a, b] = comparison.motors;
    let mut sections: Vec<Section> = tables(comparison)
        .into_iter()
        .map(|(title, header, rows)| {
            Section::new(title.clone(), vec![Part::Table(Table::of(title, &header).rows(rows))])
        })
        .collect();
    // Behind the step response there are modules' ratings.
    if let Some(step) = sections.get_mut(3) {
        step.parts.insert(0, Part::Figure(plot::figure(comparison)));
    }
    let mut warnings = Vec::new();
    let mut sources = Table::new("The rows", &["motor", "its numbers are", "source", "note"]);
    for motor in comparison.motors {
        sources
            .push(&motor.id, vec![motor.id.clone(), conventions_line(motor), motor.source.clone(), motor.note.clone()]);
        warnings.extend(motor.assumptions.iter().map(|what| format!("{}: assumed: {what}", motor.id)));
        warnings.extend(motor.estimates.iter().map(|e| format!("{}: {}", motor.id, estimate_line(e))));
        warnings.extend(audit_motor(motor).into_iter().map(|finding| {
            let why = finding.explanation.map_or_else(String::new, |w| format!(" ({w})"));
            format!("{}: audit [{}]: {}{why}", motor.id, finding.code, finding.message)
        }));
    }
    sections.push(Section::new("Where the numbers come from", vec![Part::Table(sources)]));
    let unknown = || format!("S_M of {} or {} is not known, so which is more responsive cannot be said.", a.id, b.id);
    Page {
        command: "compare",
        title: format!("{} and {}", a.id, b.id),
        asked: vec![Part::Text(format!(
            "What no ratio changes of {} and {}, both at the same inertia at the output, and how fast each answers.",
            a.id, b.id
        ))],
        headline: faster(comparison).unwrap_or_else(unknown),
        sections,
        warnings,
        ..Page::default()
    }
}
