//! Many robots: which motors win, and what each parameter does.

use std::collections::BTreeMap;

use crate::report::plot::{Axis, Dash, Figure, Group, Mark, Panel, Series, Shape, Tone};
use crate::study::effects::Effect;
use crate::study::summary::Summary;
use crate::words::number;

/// Motors in the picture of winners.
const WINNERS: usize = 20;

/// Who wins, and a row of panels for each parameter.
pub fn figure(summary: &Summary) -> Figure {
    let mut groups = vec![winners(summary)];
    let mut parameters: Vec<&str> = summary.effects.iter().map(|e| e.parameter.as_str()).collect();
    parameters.dedup();
    groups.extend(parameters.into_iter().map(|p| parameter(p, &summary.effects)));
    Figure { groups, columns: 2, panel: (520.0, 380.0), ..Figure::default() }
}

/// The share of joints that each motor wins, the most frequent on top, and the sum of the shares down to it.
fn winners(summary: &Summary) -> Group {
    let mut wins: BTreeMap<&str, u64> = BTreeMap::new();
    for motor in summary.joints.iter().flat_map(|j| &j.motors).filter(|m| m.first > 0) {
        *wins.entry(&motor.motor).or_default() += motor.first;
    }
    let mut wins: Vec<(&str, u64)> = wins.into_iter().collect();
    wins.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    let all: u64 = wins.iter().map(|w| w.1).sum();
    let share = |n: u64| 100.0 * n as f64 / all as f64;
    let leader = wins.first().map_or_else(String::new, |(motor, n)| {
        format!(": {motor} leads with {} %", number((10.0 * share(*n)).round() / 10.0))
    });
    let shown = &wins[..wins.len().min(WINNERS)];
    // Names run upwards, so the first is the last of the axis.
    let place = |k: usize| (shown.len() - 1 - k) as f64;
    let ids: Vec<String> = shown.iter().map(|w| w.0.to_string()).collect();
    let mut sum = 0;
    let (mut own, mut running) = (Vec::new(), Vec::new());
    for (k, w) in shown.iter().enumerate() {
        sum += w.1;
        own.push((share(w.1), place(k)));
        running.push((share(sum), place(k)));
    }
    let panel = |x: &str, points: Vec<(f64, f64)>, line: bool| {
        let mut series = vec![Series::new(Tone::Blue, Mark::Points(Shape::Circle), points.clone()).of(ids.clone())];
        if line {
            series.insert(0, Series::new(Tone::Blue, Mark::Line(Dash::Solid), points));
        }
        Panel {
            x: Axis { range: Some((0.0, 105.0)), ..Axis::linear(x) },
            y: Axis::named("", ids.iter().rev().cloned().collect()),
            series,
            empty: "no joint has a design".into(),
            ..Panel::default()
        }
    };
    Group {
        title: format!("First choices of {} robots, {} motors{leader}", summary.robots, wins.len()),
        panels: vec![
            panel("joints it wins [%]", own, false),
            panel("joints won by it and those above [%]", running, true),
        ],
        ..Group::default()
    }
}

/// All joints together: the loss at each value against the first, and who else wins.
fn parameter(name: &str, effects: &[Effect]) -> Group {
    let of: Vec<&Effect> = effects.iter().filter(|e| e.parameter == name).collect();
    let mut values: Vec<&str> = of.iter().map(|e| e.value.as_str()).collect();
    values.dedup();
    let reference = of.first().map_or("", |e| e.reference.as_str());
    let leading = |text: &str| text.split_whitespace().next().and_then(|t| t.parse::<f64>().ok());
    let unit = reference.split_once(' ').map_or("", |(_, unit)| unit.trim());
    // Numbers where all are in one unit; else the place in the list.
    let same_unit = values.iter().all(|v| v.split_once(' ').map_or("", |(_, u)| u.trim()) == unit);
    let numbers: Option<Vec<f64>> = std::iter::once(reference)
        .chain(values.iter().copied())
        .map(leading)
        .collect::<Option<_>>()
        .filter(|_| same_unit);
    let x = |k: usize| numbers.as_ref().map_or(k as f64 + 1.0, |n| n[k]);
    let (mut loss, mut other, mut lost) = (vec![(x(0), 1.0)], vec![(x(0), 0.0)], vec![(x(0), 0.0)]);
    for (k, value) in values.iter().enumerate() {
        let here = || of.iter().filter(|e| e.value == *value);
        let pairs: u64 = here().map(|e| e.pairs).sum();
        let logs: f64 = here().filter_map(|e| Some(e.pairs as f64 * e.loss_ratio?.ln())).sum();
        let share = |n: u64, of: u64| 100.0 * n as f64 / of as f64;
        loss.push((x(k + 1), (logs / pairs as f64).exp()));
        other.push((x(k + 1), share(here().map(|e| e.other_first_choice).sum(), pairs)));
        let gone: u64 = here().map(|e| e.lost).sum();
        lost.push((x(k + 1), share(gone, pairs + gone)));
    }
    let label = match (&numbers, unit) {
        (None, _) => format!("{name}, place in the list"),
        (Some(_), "") => name.to_string(),
        (Some(_), unit) => format!("{name} [{unit}]"),
    };
    let panel = |y: String, series| Panel {
        x: Axis::linear(label.clone()),
        y: Axis::linear(y),
        series,
        empty: "no difference between the values".into(),
        ..Panel::default()
    };
    let course = |tone: Tone, dash: Dash, shape: Shape, mut points: Vec<(f64, f64)>, name: &str| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let line = Series::new(tone, Mark::Line(dash), points.clone()).named(name);
        [line, Series::new(tone, Mark::Points(shape), points).named(name)]
    };
    let mut shares = Vec::from(course(Tone::Blue, Dash::Solid, Shape::Circle, other, "another first choice"));
    shares.extend(course(Tone::Orange, Dash::Dashed, Shape::Square, lost, "no design any more"));
    Group {
        title: format!("{name}, against {reference}, all else equal"),
        own_legends: true,
        panels: vec![
            panel(
                format!("loss over loss at {reference}"),
                Vec::from(course(Tone::Blue, Dash::Solid, Shape::Circle, loss, "")),
            ),
            panel("share of joints [%]".into(), shares),
        ],
        ..Group::default()
    }
}
