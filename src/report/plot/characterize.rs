//! The tests of a motor as pictures: torque on current, gain and coherence, drag, temperature, each with its fit.

use super::{Figure, Group, Mark, Panel, Series, Tone, thinned};
use crate::measured::Bench;
use crate::measured::characterize::{Characterization, Chart, Role};

/// Dots of one curve.
const DOTS: usize = 600;

/// One group for each test that has something to show.
pub fn figure(bench: &Bench, result: &Characterization) -> Figure {
    let groups = result.outcomes.iter().filter(|o| !o.charts.is_empty()).map(|outcome| Group {
        title: format!("{}: {}", bench.name, outcome.test.replace('_', " ")),
        legend: vec![(Tone::Light, "measured".into()), (Tone::Dark, "fitted; thin: interval of 95 %".into())],
        panels: outcome.charts.iter().map(panel).collect(),
    });
    Figure { groups: groups.collect(), columns: 2 }
}

fn panel(chart: &Chart) -> Panel {
    let place = |value: f64, log: bool| if log { value.log10() } else { value };
    let series = chart.curves.iter().map(|(role, points)| Series {
        tone: if matches!(role, Role::Measured | Role::Curve) { Tone::Light } else { Tone::Dark },
        mark: if *role == Role::Measured { Mark::Dots } else { Mark::Line },
        points: thinned(points.len(), DOTS)
            .map(|k| (place(points[k].0, chart.log_x), place(points[k].1, chart.log_y)))
            .collect(),
    });
    Panel {
        x: chart.x.clone(),
        y: chart.y.clone(),
        lines: chart.marks.iter().map(|x| place(*x, chart.log_x)).collect(),
        series: series.collect(),
        empty: "nothing to draw".into(),
    }
}
