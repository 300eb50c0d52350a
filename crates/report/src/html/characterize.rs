//! The page of a motor on a bench: each number with its ±, how it was found, the tests drawn, the row.

use super::{Page, Part, Row, Section, Table, Verdict, panel_of};
use crate::characterize::{share, value};
use crate::plot::{Figure, characterize as plot};
use crate::{counted, number};
use gearwise_identify::Bench;
use gearwise_identify::characterize::{Characterization, Finding, Outcome, Weight};

/// The page.
pub fn page(bench: &Bench, result: &Characterization) -> Page {
    let row = &result.row;
    let warned = all_findings(result).filter(|f| f.weight == Weight::Warning).count();
    let doubt = match warned {
        0 => String::new(),
        1 => "; 1 check warns".into(),
        n => format!("; {n} checks warn"),
    };
    let headline = match row.missing.as_slice() {
        [] => format!("The bench gives a catalogue row of `{}`{doubt}.", row.id),
        missing => {
            format!("The row of `{}` is not complete: a catalogue row needs {}{doubt}.", row.id, missing.join(", "))
        }
    };
    let figure = plot::figure(bench, result);
    let mut sections = Vec::new();
    let mut drawn = 0;
    for outcome in &result.outcomes {
        sections.push(test(outcome, &figure, drawn));
        drawn += outcome.charts.len();
    }
    if let Some(part) = findings(&result.findings, "All tests together").part() {
        sections.push(Section::new("All tests together", vec![part]));
    }
    let from = row.taken.iter().map(|(name, from)| vec![(*name).to_string(), from.clone()]);
    let mut parts: Vec<Part> =
        Table::new("Not measured here", &["column", "from"]).rows(from).part().into_iter().collect();
    parts.push(Part::Text(format!("Measured here: {}.", row.measured.join(", "))));
    sections.push(Section::new("The catalogue row", parts));
    let mut logs = Table::new("Logs", &["log", "kind", ">rows"]);
    for log in &bench.logs {
        logs.push(&log.name, vec![log.name.clone(), log.kind.name().into(), log.len().to_string()]);
    }
    let remarks = bench.logs.iter().flat_map(|l| l.remarks.iter().map(move |r| format!("{}: {r}", l.name)));
    let warns = all_findings(result).filter(|f| f.weight == Weight::Warning).map(|f| f.text.clone());
    Page {
        command: "characterize",
        title: bench.name.clone(),
        verdict: Verdict::from(row.missing.is_empty()),
        asked: vec![
            Part::Text(format!(
                "The numbers of `{}` by {}, N = {}; on the motor's side and the q axis.",
                row.id,
                counted(bench.logs.len(), "log"),
                number(bench.declared.ratio)
            )),
            Part::Table(logs),
        ],
        headline,
        summary: vec![
            Part::Table(quantities(result)),
            Part::Text("Each ± holds the number in 95 of 100 cases.".into()),
        ],
        sections,
        warnings: warns.chain(remarks).collect(),
        ..Page::default()
    }
}

fn all_findings(result: &Characterization) -> impl Iterator<Item = &Finding> {
    result.outcomes.iter().flat_map(|o| &o.findings).chain(&result.findings)
}

fn quantities(result: &Characterization) -> Table {
    let rows = result.outcomes.iter().flat_map(|o| o.quantities.iter().map(move |q| (o, q))).map(|(o, q)| {
        let e = &q.estimate;
        vec![q.name.into(), value(e, q.unit), share(e.relative()), o.test.into(), q.remark.clone()]
    });
    Table::new("What was found", &["quantity", ">value ± 95 %", ">±", "test", "remark"]).rows(rows)
}

fn findings(of: &[Finding], caption: &str) -> Table {
    let rows = of.iter().map(|f| vec![f.weight.word().into(), f.check.into(), f.text.clone()]);
    Table::new(caption, &["weight", "check", "finding"]).rows(rows)
}

/// A test: how, what each log gave, what its checks say, and its pictures, which begin at this panel.
fn test(outcome: &Outcome, figure: &Figure, first: usize) -> Section {
    let name = outcome.test.replace('_', " ");
    let mut parts = vec![Part::List(outcome.method.clone())];
    parts.extend((first..first + outcome.charts.len()).filter_map(|k| panel_of(figure, 0, k)));
    let mut logs = Table::new(format!("{name}: each log"), &["log", "used", "values", "remarks"]);
    for log in &outcome.logs {
        let values: Vec<String> =
            log.values.iter().map(|(name, e, unit)| format!("{name} {}", value(e, unit))).collect();
        let used = if log.used { "yes" } else { "no" };
        let cells = vec![log.log.clone(), used.into(), values.join("; "), log.remarks.join("; ")];
        logs.rows.push(Row { id: log.log.clone(), cells, faint: !log.used });
    }
    parts.extend(logs.part());
    parts.extend(findings(&outcome.findings, &format!("{name}: checks")).part());
    Section::new(name, parts)
}
