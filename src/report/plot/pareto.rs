//! The front of two quantities, a motor's name at each stretch of it.

use super::{Axis, Dash, Figure, Group, Label, Mark, Panel, Scale, Series, Shape, Tone, unit};
use crate::design::pareto::Front;
use crate::report::number;
use crate::requirement::Quantity;

/// Motors that get a look of their own.
const LOOKS: usize = 8;

/// One panel for each joint.
pub fn figure(fronts: &[Front]) -> Figure {
    let names = fronts.first().map_or(["", ""], |f| f.quantities.map(Quantity::name));
    Figure {
        groups: vec![Group {
            title: format!("Fronts of {} and {}", names[0], names[1]),
            caption: "Each point is a design that keeps all limits; none has less of one quantity without more of the other. \
                      A motor's points differ in the ratio N."
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
    let all = (0..front.points.len()).map(at).collect();
    panel.series.push(Series::new(Tone::Grey, Mark::Thin(Dash::Solid), all));
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
        let series = series.of(vec![motor.to_string()]).noted(of.iter().map(note).collect());
        panel.series.push(series);
        panel.labels.push(Label { at: at(of[of.len() / 2]), text: motor.to_string(), chosen: false });
    }
    panel
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
