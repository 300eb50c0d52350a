//! Motors ranked by a metric.

use super::columns::metric_key;
use super::table::{Column, Table, paragraph};
use super::{csv_number, number};
use gearwise_model::actuator::metrics::{Estimate, METRICS, Metric, Shown};
use gearwise_model::catalog::Motor;
use gearwise_model::units::in_unit;

/// Motors in the order of a metric, best first; those that lack it apart.
#[derive(Debug)]
pub struct Ranking<'a> {
    /// The metric that orders.
    pub metric: &'static Metric,
    /// The ranked motors with the metric's value.
    pub ranked: Vec<(&'a Motor, Estimate)>,
    /// Motors whose value is not known.
    pub unranked: Vec<&'a Motor>,
    /// Tolerance assumed where a row has none, relative.
    pub default_tolerance: Option<f64>,
}

impl<'a> Ranking<'a> {
    /// Ranks.
    pub fn new(motors: &'a [Motor], metric: &'static Metric, default_tolerance: Option<f64>) -> Ranking<'a> {
        let (mut ranked, mut unranked) = (Vec::new(), Vec::new());
        for motor in motors {
            match metric.of_with_tolerance(motor, default_tolerance) {
                Some(estimate) => ranked.push((motor, estimate)),
                None => unranked.push(motor),
            }
        }
        ranked.sort_by(|a, b| {
            let order = a.1.value.total_cmp(&b.1.value);
            (if metric.lower_is_better { order } else { order.reverse() }).then(a.0.id.cmp(&b.0.id))
        });
        Ranking { metric, ranked, unranked, default_tolerance }
    }

    /// How sure it is that place i is ahead of the next.
    pub(super) fn sure(&self, place: usize) -> Option<f64> {
        let next = self.ranked.get(place + 1)?;
        self.metric.probability_ahead(&self.ranked[place].1, &next.1)
    }
}

/// A metric's value with its tolerance (independent ±) in the metric's own unit.
pub fn with_tolerance(metric: &Metric, estimate: Option<Estimate>) -> String {
    let Some(estimate) = estimate else { return "–".into() };
    let value = number(in_unit(estimate.value, metric.unit));
    match estimate.independent {
        Some(tolerance) if tolerance > 0.0 => {
            format!("{value} ±{}%", number((100.0 * tolerance * 10.0).round() / 10.0))
        }
        _ => value,
    }
}

/// For people.
pub fn text(ranking: &Ranking, top: usize) -> String {
    let metric = ranking.metric;
    let mut metrics: Vec<&Metric> = vec![metric];
    metrics.extend(METRICS.iter().filter(|m| m.shown >= Shown::InRank && m.name != metric.name));
    let rows = ranking.ranked.iter().take(top).enumerate().map(|(place, (motor, _))| {
        let mut row = vec![(place + 1).to_string(), motor.id.clone()];
        row.extend(metrics.iter().map(|m| with_tolerance(m, m.of_with_tolerance(motor, ranking.default_tolerance))));
        row.insert(3, ranking.sure(place).map_or_else(|| "?".into(), |p| format!("{:.0} %", 100.0 * p)));
        row
    });
    let better = if metric.lower_is_better { "less" } else { "more" };
    let mut out = paragraph(&format!("{}: {}; {better} is better", metric.symbol, metric.meaning), 0, 2);
    out.push('\n');
    out.push_str(&Table::new(columns(&metrics)).also_in("`--csv`, `--json`").rows(rows).text());
    let hidden = ranking.ranked.len().saturating_sub(top);
    out.push('\n');
    if hidden > 0 {
        let line = format!("{hidden} more are ranked; `--top {}` shows all.", ranking.ranked.len());
        out.push_str(&paragraph(&line, 0, 2));
    }
    if !ranking.unranked.is_empty() {
        let ids: Vec<&str> = ranking.unranked.iter().map(|m| m.id.as_str()).collect();
        let list = format!(
            "Not ranked, because a parameter of {} is not known ({}): {}",
            metric.symbol,
            ids.len(),
            ids.join(", ")
        );
        out.push_str(&paragraph(&list, 0, 2));
    }
    let known = "`±` is what the rows state, combined as independent; `ahead of next` reads it as a 95 % interval. `?`: a ± is missing";
    let assumed = ranking.default_tolerance.map_or_else(
        || " (`--tolerance 5%` assumes one).".to_string(),
        |t| format!("; where a row has none, ±{} % was assumed.", number(100.0 * t)),
    );
    out.push_str(&paragraph(&format!("{known}{assumed}"), 0, 0));
    out
}

/// The columns: place, motor, the metric that orders and how sure its order is; the other metrics where there is room.
fn columns(metrics: &[&Metric]) -> Vec<Column> {
    let mut columns = vec![Column::number("#", ""), Column::name("motor")];
    let last = metrics.len() as u8;
    columns.extend(metrics.iter().zip(0..).map(|(metric, place)| {
        let column = Column::number(metric.symbol, metric.unit);
        // The last first.
        if place == 0 { column } else { column.dropped(last - place) }
    }));
    columns.insert(3, Column::number("ahead\nof next", ""));
    columns
}

/// As rows.
pub fn csv(ranking: &Ranking) -> String {
    let names: Vec<String> = METRICS.iter().map(metric_key).collect();
    let mut header = vec!["rank", "motor", "manufacturer", "probability_ahead_of_next"];
    header.extend(names.iter().map(String::as_str));
    let ranked = ranking.ranked.iter().enumerate().map(|(place, (motor, _))| (Some(place), *motor));
    let all = ranked.chain(ranking.unranked.iter().map(|m| (None, *m)));
    super::csv_text(
        &header,
        all.map(|(place, motor)| {
            let mut row = vec![
                place.map_or_else(String::new, |p| (p + 1).to_string()),
                motor.id.clone(),
                motor.manufacturer.clone(),
                csv_number(place.and_then(|p| ranking.sure(p))),
            ];
            row.extend(METRICS.iter().map(|m| csv_number(m.value(motor))));
            row
        }),
    )
}
