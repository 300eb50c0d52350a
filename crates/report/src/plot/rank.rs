//! Rotor inertia over motor constant with isolines of S_M: the figure of Urs et al. for any catalogue; beside it
//! rotor inertia over torque constant with isolines of S_T.

use super::{Axis, Dash, Figure, Group, Label, Mark, Panel, Series, Shape, Tone, unit};
use crate::number;
use crate::rank::Ranking;
use gearwise_model::actuator::metrics::{Metric, metric};
use gearwise_model::catalog::Motor;
use gearwise_model::units::in_unit;

/// Manufacturers that get a look of their own; the others share one.
const MANUFACTURERS: usize = 8;
/// Motors named because they are the best.
const NAMED: usize = 5;

/// The figure; `marked` are the motors that were chosen, first the most important.
pub fn figure(ranking: &Ranking, marked: &[&Motor]) -> Figure {
    let motors: Vec<&Motor> = ranking.ranked.iter().map(|r| r.0).chain(ranking.unranked.iter().copied()).collect();
    let panels = vec![
        panel(&motors, marked, "s_m", "k_m", "motor constant K_M [N·m/√W]"),
        panel(&motors, marked, "s_t", "k_t", "torque constant K_T, q axis [N·m/A]"),
    ];
    Figure {
        title: "Rotor inertia over motor constant and over torque constant".into(),
        groups: vec![Group {
            title: format!("{} motors: rotor inertia against what it buys", motors.len()),
            caption: "Lines of equal S_M = J_m/K_M² and S_T = J_m/K_T², a power of ten apart: below right is better. No gear \
                      moves a motor to another line. Named: the best of each diagram, and those that are marked (ring)."
                .into(),
            own_legends: false,
            panels,
        }],
        columns: 2,
        panel: (600.0, 520.0),
        ..Figure::default()
    }
}

/// Manufacturers, those with the most motors first.
fn manufacturers<'a>(motors: &[&'a Motor]) -> Vec<&'a str> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for motor in motors {
        match counts.iter_mut().find(|c| c.0 == motor.manufacturer) {
            Some(count) => count.1 += 1,
            None => counts.push((&motor.manufacturer, 1)),
        }
    }
    counts.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    counts.into_iter().map(|c| c.0).collect()
}

fn panel(motors: &[&Motor], marked: &[&Motor], name: &str, abscissa: &str, x: &str) -> Panel {
    let (Some(s), Some(k), Some(j)) = (metric(name), metric(abscissa), metric("rotor_inertia")) else {
        return Panel::default();
    };
    let at = |m: &Motor| Some((k.value(m)?, j.value(m)?)).filter(|p| p.0 > 0.0 && p.1 > 0.0);
    let known: Vec<(&Motor, (f64, f64))> = motors.iter().filter_map(|m| Some((*m, at(m)?))).collect();
    let mut panel = Panel {
        title: format!("{} = J_m/{}²", s.symbol, k.symbol),
        x: Axis::log(x),
        y: Axis::log("rotor inertia J_m [kg·m²]"),
        empty: "no motor has both numbers".into(),
        ..Panel::default()
    };
    let range = |of: fn(&(f64, f64)) -> f64| {
        let (low, high) =
            known.iter().map(|(_, p)| of(p)).fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        let room = (high / low).powf(0.05).max(1.4);
        (low < f64::INFINITY).then_some((low / room, high * room))
    };
    (panel.x.range, panel.y.range) = (range(|p| p.0), range(|p| p.1));
    if let (Some(xs), Some(ys)) = (panel.x.range, panel.y.range) {
        panel.series.extend(isolines(s, xs, ys));
    }
    let makers = manufacturers(motors);
    for (rank, maker) in makers.iter().enumerate().take(MANUFACTURERS + 1) {
        let last = rank == MANUFACTURERS;
        let own =
            |m: &Motor| if last { makers[rank..].contains(&m.manufacturer.as_str()) } else { m.manufacturer == *maker };
        let of: Vec<&(&Motor, (f64, f64))> = known.iter().filter(|(m, _)| own(m)).collect();
        let (tone, shape) = if last { (Tone::Grey, Shape::Circle) } else { (Tone::nth(rank), Shape::nth(rank)) };
        let note = |m: &Motor| {
            let value = s.value(m).map_or_else(String::new, |v| {
                format!(": {} {} {}", s.symbol, number(in_unit(v, s.unit)), unit(s.unit))
            });
            format!("{}{value}", m.id)
        };
        let series = Series::new(tone, Mark::Points(shape), of.iter().map(|(_, p)| *p).collect());
        let name = if last { format!("{} others", makers.len() - MANUFACTURERS) } else { (*maker).to_string() };
        let (ids, notes) = of.iter().map(|(m, _)| (m.id.clone(), note(m))).unzip();
        panel.series.push(series.named(name).of(ids).noted(notes));
    }
    for motor in marked {
        panel.labels.extend(at(motor).map(|at| Label { at, text: motor.id.clone(), chosen: true }));
    }
    let mut best: Vec<(f64, &Motor)> = known.iter().filter_map(|(m, _)| Some((s.value(m)?, *m))).collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.id.cmp(&b.1.id)));
    // One winding of a motor stands for all: they have the same rotor, and the same metric but for rounding.
    let mut rotors: Vec<(f64, f64)> = Vec::new();
    best.retain(|(value, motor)| {
        let inertia = motor.rotor_inertia.unwrap_or(f64::NAN);
        let is_new = !rotors.iter().any(|(v, j)| near(*v, *value) && *j == inertia);
        rotors.push((*value, inertia));
        is_new
    });
    for (_, motor) in best.into_iter().filter(|(_, m)| !marked.iter().any(|o| o.id == m.id)).take(NAMED) {
        panel.labels.extend(at(motor).map(|at| Label { at, text: motor.id.clone(), chosen: false }));
    }
    panel
}

/// Whether two values of a metric are those of two windings of one motor.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 0.03 * a.abs().max(b.abs())
}

/// `J = S K²` for S a power of ten apart, as far as it can be seen.
fn isolines(s: &Metric, (left, right): (f64, f64), (low, high): (f64, f64)) -> Vec<Series> {
    let exponents = (low / (right * right)).log10().floor() as i32..=(high / (left * left)).log10().ceil() as i32;
    let line = |exponent: i32| {
        let value = 10_f64.powi(exponent);
        // The part of the line within the panel.
        let (from, to) = (left.max((low / value).sqrt()), right.min((high / value).sqrt()));
        let text = format!("{} = {} {}", s.symbol, number(in_unit(value, s.unit)), unit(s.unit));
        let points = [from, to].map(|k| (k, value * k * k)).to_vec();
        (to > 1.05 * from).then(|| Series::new(Tone::Grey, Mark::Thin(Dash::Dashed), points).along(text))
    };
    exponents.filter_map(line).collect()
}
