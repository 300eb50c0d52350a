//! The tests of a motor as pictures: torque on current with the interval of its slope, gain and coherence with the
//! fit (Urs et al., figure 5), drag on speed, temperature in time.

use super::{Along, Axis, Dash, Figure, Group, Mark, Panel, Rule, Series, Shape, Tone, thinned, unit};
use gearwise_identify::Bench;
use gearwise_identify::characterize::{Characterization, Chart, Role};

/// Points of one curve.
const POINTS: usize = 600;

/// One panel for each thing that a test has to show.
pub fn figure(bench: &Bench, result: &Characterization) -> Figure {
    let panels = result
        .outcomes
        .iter()
        .flat_map(|o| o.charts.iter().map(|chart| Panel { title: o.test.replace('_', " "), ..panel(chart) }));
    let title = format!("{}: characterised", bench.name);
    let group = Group { title: title.clone(), own_legends: true, panels: panels.collect(), ..Group::default() };
    Figure { title, groups: vec![group], columns: 2, panel: (520.0, 340.0), ..Figure::default() }
}

fn panel(chart: &Chart) -> Panel {
    let axis = |label: &str, log: bool| if log { Axis::log(unit(label)) } else { Axis::linear(unit(label)) };
    let mut series = Vec::new();
    if !chart.band.is_empty() {
        series.push(Series::band(Tone::Sky, chart.band.iter().copied()).named("interval of 95 %"));
    }
    let mut measured = 0;
    let over_curve = chart.curves.iter().any(|c| c.role == Role::Curve);
    for curve in &chart.curves {
        let points = thinned(curve.points.len(), POINTS).map(|k| curve.points[k]).collect();
        // What was measured differs by colour and by shape or dash; what was fitted is black: solid among points, thin
        // and dashed over a measured curve, which it would hide.
        let (tone, mark) = match curve.role {
            Role::Measured => {
                ([Tone::Orange, Tone::Blue, Tone::Green][measured % 3], Mark::Points(Shape::nth(measured)))
            }
            Role::Curve => (Tone::SERIES[(measured + 1) % 6], Mark::Line(Dash::nth(2 * measured))),
            Role::Fit if over_curve => (Tone::Black, Mark::Thin(Dash::Dashed)),
            Role::Fit => (Tone::Black, Mark::Line(Dash::Solid)),
            Role::Stand => (Tone::Grey, Mark::Line(Dash::Dashed)),
        };
        measured += usize::from(matches!(curve.role, Role::Measured | Role::Curve));
        series.push(Series::new(tone, mark, points).named(unit(&curve.name)));
    }
    let rule = |at: &f64| Rule {
        along: Along::X,
        at: *at,
        tone: Tone::Grey,
        dash: Dash::Dotted,
        text: "band of the fit".into(),
    };
    Panel {
        x: axis(&chart.x, chart.log_x),
        y: axis(&chart.y, chart.log_y),
        rules: chart.marks.iter().map(rule).collect(),
        series,
        empty: "nothing to draw".into(),
        ..Panel::default()
    }
}
