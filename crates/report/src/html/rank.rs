//! The page of a ranking.

use super::{Page, Part, Section, Table};
use crate::number;
use crate::plot::rank as plot;
use crate::rank::{Ranking, with_tolerance};
use gearwise_model::actuator::metrics::METRICS;
use gearwise_model::catalog::Motor;
use gearwise_model::units::in_unit;

/// The page; `marked` are the motors named in the figure.
pub fn page(ranking: &Ranking, marked: &[&Motor]) -> Page {
    let metric = ranking.metric;
    let headline = match ranking.ranked.as_slice() {
        [] => format!("No motor can be ranked by {}: a number is missing in every row.", metric.symbol),
        [(first, estimate), ..] => format!(
            "{} has the best {} of {}: {} {}.",
            first.id,
            metric.symbol,
            gearwise_model::words::counted(ranking.ranked.len(), "motor"),
            number(in_unit(estimate.value, metric.unit)),
            metric.unit
        ),
    };
    let better = if metric.lower_is_better { "less" } else { "more" };
    let mut warnings = Vec::new();
    if !ranking.unranked.is_empty() {
        let ids: Vec<&str> = ranking.unranked.iter().map(|m| m.id.as_str()).collect();
        let count = ids.len();
        let list = ids.join(", ");
        warnings.push(format!("Not ranked, because a parameter of {} is not known ({count}): {list}", metric.symbol));
    }
    let assumed = ranking
        .default_tolerance
        .map_or_else(String::new, |t| format!(" Where a row has none, ±{} % was assumed.", number(100.0 * t)));
    let known = format!(
        "± is what the rows state, combined as independent; “ahead of next” reads it as a 95 % interval; ? where a ± is \
         missing.{assumed}"
    );
    let meanings = METRICS.iter().map(|m| format!("{} [{}]: {}", m.symbol, m.unit, m.meaning)).collect();
    let parts = vec![
        Part::Table(table(ranking)),
        Part::Text(known),
        Part::Folded("What the metrics mean".into(), Box::new(Part::List(meanings))),
    ];
    Page {
        command: "rank",
        title: format!("motors by {}", metric.symbol),
        asked: vec![Part::Text(format!(
            "{} by {}: {}; {better} is better.",
            gearwise_model::words::counted(ranking.ranked.len() + ranking.unranked.len(), "motor"),
            metric.symbol,
            metric.meaning
        ))],
        headline,
        sections: vec![
            Section::new("Rotor inertia against what it buys", vec![Part::Figure(plot::figure(ranking, marked))]),
            Section::new("Motors", parts),
        ],
        warnings,
        ..Page::default()
    }
}

fn table(ranking: &Ranking) -> Table {
    let first = ranking.metric;
    let columns = || std::iter::once(first).chain(METRICS.iter().filter(|m| m.name != first.name));
    let mut header = vec![">#".to_string(), "motor".into(), "manufacturer".into()];
    header.extend(columns().map(|m| format!(">{} [{}]", m.symbol, m.unit)));
    header.insert(4, ">ahead of next".into());
    // Place, motor, maker and the metric that was asked for, and as many others as can be read at once.
    let mut table = Table::new("Every motor with every metric", &header).mainly(10);
    let cells = |motor: &Motor| {
        columns().map(|m| with_tolerance(m, m.of_with_tolerance(motor, ranking.default_tolerance))).collect::<Vec<_>>()
    };
    for (place, (motor, _)) in ranking.ranked.iter().enumerate() {
        let mut row = vec![(place + 1).to_string(), motor.id.clone(), motor.manufacturer.clone()];
        row.extend(cells(motor));
        row.insert(4, ranking.sure(place).map_or_else(|| "?".into(), |p| format!("{:.0} %", 100.0 * p)));
        table.push(&motor.id, row);
    }
    for motor in &ranking.unranked {
        let mut row = vec!["–".into(), motor.id.clone(), motor.manufacturer.clone()];
        row.extend(cells(motor));
        row.insert(4, "–".into());
        table.push(&motor.id, row);
    }
    table
}
