//! The page of an identification.

use super::{Page, Part, Section, Table, Verdict, group_of};
use crate::identify::{
    effect_text, equation_title, finding_lines, noise_lines, parameter_columns, parameter_rows, refused, sentence,
    six_lines, story_rows, stuck, unit_on, used,
};
use crate::plot::{choice, residual as plot};
use crate::table::PLAIN_WIDTH;
use crate::{forward, number, remake};
use gearwise_identify::Bench;
use gearwise_identify::identify::Report;
use gearwise_identify::simulate::ForwardCheck;
use gearwise_model::words::handy::handy;
use gearwise_select::remake::Remade;

/// The page; `forward` and `remade` where they were made.
pub fn page(bench: &Bench, reports: &[Report], forward: Option<&ForwardCheck>, remade: Option<&[Remade]>) -> Page {
    let figure = plot::figure(bench, reports);
    // The story, then pictures, then numbers.
    let mut pictures: Vec<Part> = (0..reports.len()).filter_map(|k| group_of(&figure, k)).collect();
    pictures.extend(remade.and_then(choice::figure).map(Part::Figure));
    let mut sections = vec![Section::new("Before and after", pictures)];
    sections.extend(reports.iter().map(|report| equation(bench, report)));
    if let Some(check) = forward {
        sections.push(Section::new("Simulated forward", vec![Part::Plain(forward::text_at(check, PLAIN_WIDTH))]));
    }
    if let Some(remade) = remade {
        sections.push(Section::new("The choice made again", vec![Part::Plain(remake::text_at(remade, PLAIN_WIDTH))]));
    }
    let rows = refused(reports).into_iter().map(|(r, _)| vec![r.name.clone(), r.reason.clone()]);
    let table = Table::new("Effects that were not added", &["effect", "because"]).rows(rows);
    sections.extend(table.part().map(|part| Section::new("Not added, and why", vec![part])));
    let mut runs: Vec<String> = Vec::new();
    for run in reports.iter().flat_map(|r| &r.next_runs) {
        if !runs.contains(run) {
            runs.push(run.clone());
        }
    }
    let told = six_lines(bench, reports, remade);
    let mut summary = vec![Part::List(told.into_iter().map(|(about, line)| format!("{about}: {line}")).collect())];
    if !runs.is_empty() {
        summary.push(Part::Text("What to measure next:".into()));
        summary.push(Part::List(runs));
    }
    let what = match &bench.declared.motor {
        Some(motor) => format!("{} at N = {}", motor.id, number(bench.declared.ratio)),
        None => "linear axis".into(),
    };
    Page {
        command: "identify",
        title: format!("{}: {what}", bench.name),
        verdict: Verdict::Information,
        asked: vec![
            Part::Text(
                "What the model of this actuator lacks, by the bench's logs, each of which gives its part.".into(),
            ),
            Part::Table(logs(bench)),
        ],
        headline: sentence(bench, reports),
        summary,
        sections,
        warnings: warnings(bench, reports),
        ..Page::default()
    }
}

pub(super) fn warnings(bench: &Bench, reports: &[Report]) -> Vec<String> {
    let mut all = Vec::new();
    for left in reports.iter().flat_map(|r| &r.unexplained) {
        all.push(format!("left unexplained, depends on {}: {}", left.depends_on.name(), left.detail));
    }
    all.extend(finding_lines(bench, reports));
    for log in &bench.logs {
        all.extend(log.remarks.iter().map(|remark| format!("{}: {remark}", log.name)));
        all.extend(stuck(log).into_iter().map(|channel| format!("{}: {channel} has one value throughout", log.name)));
    }
    all
}

fn logs(bench: &Bench) -> Table {
    let mut table = Table::new("Logs", &["log", "kind", "use", ">rows"]);
    for log in &bench.logs {
        let cells = vec![log.name.clone(), log.kind.name().into(), used(log).into(), log.len().to_string()];
        table.push(&log.name, cells);
    }
    table
}

pub(super) fn equation(bench: &Bench, report: &Report) -> Section {
    let band = report.band.map_or_else(String::new, |b| format!("; band 0 to {} Hz", number(b)));
    let (samples, rows) = report.samples;
    let text = format!("{samples} samples, {rows} rows in the regression{band}.");
    let (header, rows) = story_rows(report);
    let story = Table::of("Error (RMSE) as it goes down", &header).rows(rows);
    let mut parts = vec![Part::Text(text), Part::Table(story), Part::List(noise_lines(report))];
    let rows = parameter_rows(bench, &report.parameters);
    parts.extend(Table::of("Numbers of the declared model", &parameter_columns()).rows(rows).part());
    let rows = report.artefacts.iter().map(|a| {
        let (value, unit) = handy(a.value, unit_on(bench, a.unit));
        vec![
            a.kind.name().into(),
            a.channel.clone(),
            number(value),
            if unit == "1" { String::new() } else { unit.into() },
        ]
    });
    let artefacts = Table::new("Artefacts of the measurement", &["artefact", "channel", ">value", "unit"]);
    parts.extend(artefacts.rows(rows).part());
    for effect in &report.effects {
        parts.push(Part::Plain(effect_text(bench, report, effect, PLAIN_WIDTH).trim().to_string()));
    }
    if !report.remarks.is_empty() {
        parts.push(Part::List(report.remarks.clone()));
    }
    Section::new(equation_title(report), parts)
}
