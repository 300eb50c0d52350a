//! The objective and every limit over the ratio: the window, N*, and what binds at each end.

use super::{Along, Axis, Dash, Label, Mark, Panel, Rule, Series, Stripe, Tone};
use crate::number;
use gearwise_model::numerics::grid::grid;
use gearwise_select::program::Optimum;
use gearwise_select::{Evaluation, Prepared};

/// Ratios along the axis.
const POINTS: usize = 161;
/// Demand over limit is drawn up to this.
const HIGHEST: f64 = 1.6;
/// Most limits that are drawn.
const LIMITS: usize = 8;

/// Ratios worth looking at: the windows with room on both sides, within what the joint allows.
pub fn range(optimum: Option<&Optimum>, here: f64, (min, max): (f64, f64)) -> (f64, f64) {
    let windows = optimum.map_or(&[][..], |o| &o.windows);
    let low = windows.iter().map(|w| w.min).fold(here, f64::min);
    let high = windows.iter().map(|w| w.max).fold(here, f64::max);
    let room = (high / low).powf(0.35).max(1.8);
    let (low, high) = ((low / room).max(min), (high * room).min(max));
    if high > low * 1.01 { (low, high) } else { (low / 1.5, high * 1.5) }
}

/// The evaluations over a range.
pub fn evaluations(prepared: &Prepared, (low, high): (f64, f64)) -> Vec<Evaluation> {
    grid(low, high, POINTS).into_iter().map(|n| prepared.at(n)).collect()
}

fn ratio_axis((low, high): (f64, f64)) -> Axis {
    Axis::log("ratio N").within(low, high)
}

/// Window, N* and the ratio that is looked at.
fn furnish(panel: &mut Panel, optimum: Option<&Optimum>, here: f64) {
    for window in optimum.iter().flat_map(|o| &o.windows) {
        panel.stripes.push(Stripe {
            along: Along::X,
            from: window.min,
            to: window.max,
            tone: Tone::Blue,
            name: "feasible".into(),
        });
    }
    let rule = |at, dash, text| Rule { along: Along::X, at, tone: Tone::Black, dash, text };
    if let Some(o) = optimum {
        panel.rules.push(rule(o.ratio, Dash::Dashed, format!("N* = {}", number(o.ratio))));
    }
    if optimum.is_none_or(|o| (o.ratio / here - 1.0).abs() > 1e-6) {
        panel.rules.push(rule(here, Dash::Dotted, format!("N = {}", number(here))));
    }
}

/// The objective over the ratio.
pub fn objective(prepared: &Prepared, evaluations: &[Evaluation], optimum: Option<&Optimum>, here: f64) -> Panel {
    let goal = &prepared.candidate.joint.objective;
    let curve: Vec<(f64, f64)> = evaluations.iter().map(|e| (e.ratio, e.objective(goal).unwrap_or(f64::NAN))).collect();
    let feasible =
        evaluations.iter().map(|e| (e.ratio, e.objective(goal).filter(|_| e.feasible).unwrap_or(f64::NAN))).collect();
    let range = (evaluations[0].ratio, evaluations[evaluations.len() - 1].ratio);
    let mut panel = Panel {
        title: format!("{} over N", goal.name()),
        x: ratio_axis(range),
        y: super::objective_axis(goal),
        empty: "the objective is not known".into(),
        ..Panel::default()
    };
    // Far from the best, the curve may rise without end.
    let values = || curve.iter().map(|p| p.1).filter(|v| v.is_finite());
    let (least, most) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if least > 0.0 && most > least {
        panel.y.range = Some((0.0, (1.06 * most).min(5.0 * optimum.map_or(least, |o| o.objective))));
    }
    panel.series.push(Series::new(Tone::Grey, Mark::Line(Dash::Dashed), curve).named("some limit is exceeded"));
    panel.series.push(Series::new(Tone::Blue, Mark::Line(Dash::Solid), feasible).named("all limits kept"));
    furnish(&mut panel, optimum, here);
    if let Some(o) = optimum {
        let joint = prepared.candidate.joint;
        panel.labels.push(Label {
            at: (o.ratio, o.objective),
            text: format!("{} {}", number(o.objective), super::unit(joint.objective.unit().trim_matches('1')))
                .trim()
                .into(),
            chosen: true,
        });
    }
    panel
}

/// Demand over limit, for the limits that come nearest, over the ratio.
pub fn limits(evaluations: &[Evaluation], optimum: Option<&Optimum>, here: f64) -> Panel {
    let range = (evaluations[0].ratio, evaluations[evaluations.len() - 1].ratio);
    let mut panel = Panel {
        title: "limits over N: demand over what may be had".into(),
        x: ratio_axis(range),
        y: Axis::linear("demand / limit").within(0.0, HIGHEST),
        empty: "no limit applies".into(),
        ..Panel::default()
    };
    // Those that bind first: nearest to their limit within the window, or at the ratio looked at.
    let within = |n: f64| match optimum {
        Some(o) => o.windows.iter().any(|w| n >= w.min && n <= w.max),
        None => (n / here).ln().abs() < 0.2,
    };
    // Slow samples count at standstill at small ratios alone.
    let mut asked: Vec<(&'static str, Option<usize>)> = Vec::new();
    for margin in evaluations.iter().flat_map(|e| &e.margins) {
        let key = (margin.limit, margin.actuator);
        if !asked.contains(&key) {
            asked.push(key);
        }
    }
    let margin = |e: &Evaluation, key: (&str, Option<usize>)| {
        e.margins.iter().find(|margin| (margin.limit, margin.actuator) == key).map(|margin| margin.margin)
    };
    let use_of = |key: (&str, Option<usize>)| {
        let near = evaluations.iter().filter(|e| within(e.ratio)).filter_map(|e| margin(e, key));
        near.fold(0.0, |most: f64, margin| most.max(1.0 - margin))
    };
    let mut order: Vec<((&'static str, Option<usize>), f64)> =
        asked.into_iter().map(|key| (key, use_of(key))).collect();
    order.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut nearest = Vec::new();
    for (key, _) in order.iter().take(LIMITS) {
        let share =
            |e: &Evaluation| margin(e, *key).filter(|margin| *margin > -1e5).map_or(f64::NAN, |margin| 1.0 - margin);
        let points = evaluations.iter().map(|e| (e.ratio, share(e))).collect();
        nearest.push(Series::new(Tone::Black, Mark::Line(Dash::Solid), points).named(key.0));
    }
    for (rank, series) in super::merge_coincident(nearest, HIGHEST).into_iter().enumerate() {
        panel.series.push(Series { tone: Tone::nth(rank), mark: Mark::Line(Dash::nth(rank)), ..series });
    }
    if order.len() > LIMITS {
        panel.title.push_str(&format!("; the {LIMITS} nearest of {}", order.len()));
    }
    let text = String::new();
    panel.rules.push(Rule { along: Along::Y, at: 1.0, tone: Tone::Black, dash: Dash::Solid, text });
    furnish(&mut panel, optimum, here);
    for window in optimum.iter().flat_map(|o| &o.windows) {
        for (end, at, bind) in [("from", window.min, &window.low), ("to", window.max, &window.high)] {
            let text = format!("{end} {}: {}", number(at), bind.limit);
            panel.labels.push(Label { at: (at, 1.0), text, chosen: false });
        }
    }
    panel
}
