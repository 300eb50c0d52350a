//! The front of two quantities, a motor's name at each stretch of it.

use super::{Axis, Dash, Figure, Group, Label, Mark, Panel, Scale, Series, Shape, Tone, unit};
use crate::design::pareto::Front;
use crate::report::number;
use crate::requirement::Quantity;

/// Motors that get a look of their own.
const LOOKS: usize = 6;

/// One panel for each joint.
pub fn figure(fronts: &[Front]) -> Figure {
    let names = fronts.first().map_or(["", ""], |f| f.quantities.map(Quantity::name));
    Figure {
        groups: vec![Group {
            title: format!("Fronts of {} and {}", names[0], names[1]),
            caption: "Each point is a design that keeps all limits; none has less of one quantity without more of the other. \
                      A motor's points differ in the ratio N, which appears at them. Between two motors the front is a \
                      step: there is nothing between them."
                .into(),
            own_legends: true,
            panels: fronts.iter().map(panel).collect(),
        }],
        columns: fronts.len().clamp(1, 2),
        panel: (560.0, 420.0),
        ..Figure::default()
    }
}

fn axis(quantity: Quantity, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    let scale = if low > 0.0 && high > 20.0 * low { Scale::Log } else { Scale::Linear };
    Axis { scale, ..Axis::linear(format!("{} [{}]", quantity.name().replace('_', " "), unit(quantity.unit()))) }
}

fn panel(front: &Front) -> Panel {
    let [a, b] = front.quantities;
    let at = |k: usize| (front.points[k].values[0], front.points[k].values[1]);
    let mut panel = Panel {
        title: format!(
            "{}: {} of {} feasible motors are on the front",
            front.joint.name,
            distinct(front).len(),
            front.motors
        ),
        x: axis(a, front.points.iter().map(|p| p.values[0])),
        y: axis(b, front.points.iter().map(|p| p.values[1])),
        empty: if front.points.is_empty() { "no design is feasible" } else { "one design is the best in both" }.into(),
        ..Panel::default()
    };
    panel.series.push(Series::new(Tone::Grey, Mark::Thin(Dash::Solid), staircase(front)));
    if front.points.iter().all(|p| p.values == front.points[0].values) {
        // One point has no extent of its own.
        let about = |value: f64| Some((0.0, 2.0 * value)).filter(|_| value > 0.0);
        let single = front.points.first().map(|p| p.values.map(about));
        (panel.x.range, panel.y.range) = single.map_or((None, None), |[x, y]| (x, y));
    }
    let mut ends = Vec::new();
    for (rank, motor) in distinct(front).into_iter().enumerate() {
        let of: Vec<usize> = (0..front.points.len()).filter(|k| front.points[*k].motor.id == motor).collect();
        let note = |k: &usize| {
            let p = &front.points[*k];
            let gear = p.gear.map_or_else(String::new, |g| format!(" with {g}"));
            format!("{motor}{gear} at N = {}", number(p.evaluation.ratio))
        };
        let (tone, shape) =
            if rank < LOOKS { (Tone::nth(rank), Shape::nth(rank)) } else { (Tone::Grey, Shape::Circle) };
        let series = Series::new(tone, Mark::Points(shape), of.iter().map(|k| at(*k)).collect());
        let estimated = !front.points[of[0]].motor.estimates.is_empty();
        let series = series.of(vec![motor.to_string()]).noted(of.iter().map(note).collect());
        panel.series.push(series.hollow(estimated));
        let ratio = |k: usize| number(front.points[k].evaluation.ratio);
        let (first, last) = (of[0], of[of.len() - 1]);
        panel.labels.push(Label { at: at(first), text: format!("{motor}, N = {}", ratio(first)), chosen: false });
        if at(first) != at(last) {
            ends.push(Label { at: at(last), text: format!("N = {}", ratio(last)), chosen: false });
        }
    }
    // Names first, the other ends where there is room.
    panel.labels.append(&mut ends);
    panel.explain_hollow();
    panel
}

/// The front as a line: a motor's own stretch runs from ratio to ratio, from one motor (or gear) to the next it is a
/// step, as there is no design between them.
fn staircase(front: &Front) -> Vec<(f64, f64)> {
    let at = |k: usize| (front.points[k].values[0], front.points[k].values[1]);
    let mut line = Vec::new();
    for (k, point) in front.points.iter().enumerate() {
        let before = k.checked_sub(1).map(|before| &front.points[before]);
        let step = before.filter(|b| b.motor.id != point.motor.id || b.gear.is_some());
        line.extend(step.map(|b| (point.values[0], b.values[1])));
        line.push(at(k));
    }
    line
}

/// Motors in the order in which they come on the front.
fn distinct<'a>(front: &'a Front) -> Vec<&'a str> {
    let mut ids: Vec<&str> = Vec::new();
    for point in &front.points {
        if !ids.contains(&point.motor.id.as_str()) {
            ids.push(&point.motor.id);
        }
    }
    ids
}
