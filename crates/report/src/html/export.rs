//! The page of an export: of each joint what the format says, what it says nearly, and what it cannot say.

use super::{Page, Part, Section, Table, Verdict};
use crate::export::facts::value;
use crate::export::{Cell, Exported, Format, Origin};
use crate::number;
use gearwise_select::simulated::Fact;

/// The page.
pub fn page(format: &Format, origin: &Origin, joints: &[Exported]) -> Page {
    let mut warnings = Vec::new();
    let mut sections = Vec::new();
    let (mut nearly, mut not) = (0, 0);
    for e in joints {
        let mut table = Table::new("What is handed over", &["quantity", "value", "in the file", "how"]);
        for fact in Fact::ALL {
            let cell = (format.says)(*fact);
            let Some(value) = value(e, *fact) else { continue };
            let (word, how) = match cell {
                Cell::Said(key) => ("said", format!("as {key}")),
                Cell::Approximately(how) => ("nearly", how.to_string()),
                Cell::Not(why) => ("not", why.to_string()),
            };
            nearly += usize::from(matches!(cell, Cell::Approximately(_)));
            not += usize::from(matches!(cell, Cell::Not(_)));
            table.push(fact.title(), vec![fact.title().into(), value, word.into(), how]);
        }
        let mut parts = vec![Part::Table(table)];
        let unknown = e.simulated.left_out.iter().filter(|left| left.fact.is_none());
        let unknown: Vec<String> = unknown.map(|left| format!("{}: {}", left.what, left.why)).collect();
        if !unknown.is_empty() {
            parts.push(Part::Text("Not known, and left out:".into()));
            parts.push(Part::List(unknown));
        }
        if let Some(spread) = e.spread.as_ref().filter(|spread| !spread.ranges.is_empty()) {
            let mut table = Table::new("Ranges of 95 % (SI, at the joint)", &["number", "from", "to", "by the ± of"]);
            for range in &spread.ranges {
                let cells = vec![range.name.into(), number(range.low), number(range.high), range.from.join(", ")];
                table.push(range.name, cells);
            }
            parts.push(Part::Table(table));
        }
        parts.push(Part::Text(format!("Numbers of {}: {}", e.motor.id, e.motor.source)));
        if !e.broken.is_empty() {
            warnings.push(format!("{}: not feasible, it breaks {}", e.joint, e.broken.join(", ")));
        }
        if !e.unjudged.is_empty() {
            warnings.push(format!("{}: {}", e.joint, crate::unjudged::sentence(&e.unjudged)));
        }
        let title = format!("{}: {} at N = {}", e.joint, e.motor.id, number(e.simulated.ratio));
        sections.push(Section::new(title, parts));
    }
    let joined = |n: usize, one: &str, many: &str| if n == 1 { one.to_string() } else { format!("{n} {many}") };
    Page {
        command: "export",
        title: format!("{} for {}", origin.robot, format.name),
        verdict: Verdict::from(warnings.is_empty()),
        asked: vec![Part::Text(format!("The actuators of {} for a simulator: {}.", origin.robot, format.about))],
        headline: match (nearly, not) {
            (0, 0) => "The file says everything that is known of the actuators.".into(),
            _ => format!(
                "Of what is known of the actuators the file says {} only nearly, and {} not at all.",
                joined(nearly, "one quantity", "quantities"),
                joined(not, "one", "quantities")
            ),
        },
        summary: vec![Part::Text(format!(
            "Names and units are those of {}. Checked against: {}.",
            format.source, format.checked
        ))],
        sections,
        warnings,
        ..Page::default()
    }
}
