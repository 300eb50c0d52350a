//! Which motor is feasible at which ratio, and what that costs.

use super::{Axis, Dash, Figure, Group, Label, Mark, Panel, Scale, Series, Shape, Tone};
use crate::{number, unjudged};
use gearwise_select::answer::{JointSweep, SweptDesign};

/// Motors in the map.
const MAPPED: usize = 24;
/// Motors with a curve of their own.
const CURVES: usize = 6;
/// Near the best: within this share of it.
const NEAR: f64 = 0.1;

/// For each joint the map, and the objective over the ratio.
pub fn figure(sweeps: &[JointSweep]) -> Figure {
    let group = |s: &JointSweep| {
        let motors = ordered(s);
        Group {
            title: format!(
                "{}: {} motors are feasible at some ratio",
                s.joint.name,
                motors.iter().filter(|m| m.best.is_finite()).count()
            ),
            caption: format!(
                "The first {} motors, the best on top. A cross: some limit is exceeded.{}",
                motors.len().min(MAPPED),
                if motors.iter().take(MAPPED).any(|m| m.estimated) {
                    " Hollow: something of the motor is estimated."
                } else {
                    ""
                }
            ),
            own_legends: true,
            panels: vec![map(s, &motors), curves(s, &motors)],
        }
    };
    Figure { groups: sweeps.iter().map(group).collect(), columns: 2, panel: (560.0, 480.0), ..Figure::default() }
}

/// A motor with its designs.
struct Swept<'a> {
    id: &'a str,
    estimated: bool,
    best: f64,
    designs: Vec<(&'a SweptDesign<'a>, f64)>,
}

/// Motors, the least objective of a feasible design first; then those without, by how near they come.
fn ordered<'a>(sweep: &'a JointSweep) -> Vec<Swept<'a>> {
    let mut motors: Vec<Swept> = Vec::new();
    for design in &sweep.designs {
        let value = design.evaluation.objective(&sweep.joint.objective).unwrap_or(f64::NAN);
        let id = design.motor.id.as_str();
        if motors.last().is_none_or(|m| m.id != id) {
            let estimated = !design.motor.estimates.is_empty();
            motors.push(Swept { id, estimated, best: f64::INFINITY, designs: Vec::new() });
        }
        let Some(motor) = motors.last_mut() else { continue };
        if design.is_choice() {
            motor.best = motor.best.min(value);
        }
        motor.designs.push((design, value));
    }
    let margin = |m: &Swept| {
        let margins = m.designs.iter().filter_map(|(d, _)| d.evaluation.tightest()).map(|t| t.margin);
        margins.fold(f64::NEG_INFINITY, f64::max)
    };
    motors.sort_by(|a, b| {
        a.best.total_cmp(&b.best).then_with(|| margin(b).total_cmp(&margin(a))).then_with(|| a.id.cmp(b.id))
    });
    motors
}

fn note(design: &SweptDesign, value: f64) -> String {
    let gear = design.gear.map_or_else(String::new, |g| format!(" with {g}"));
    let how = match (design.evaluation.feasible, design.evaluation.tightest()) {
        (false, Some(t)) => format!("{} exceeded", t.limit),
        _ if design.is_unjudged() => format!("{}, {}", number(value), unjudged::class(&design.unjudged)),
        _ => number(value),
    };
    format!("{}{gear} at N = {}: {how}", design.motor.id, number(design.evaluation.ratio))
}

fn map(sweep: &JointSweep, motors: &[Swept]) -> Panel {
    let shown: Vec<&Swept> = motors.iter().take(MAPPED).collect();
    let best = motors.first().map_or(f64::INFINITY, |m| m.best);
    // The best on top: names run upwards.
    let names = shown.iter().rev().map(|m| m.id.to_string()).collect();
    let mut panel = Panel {
        title: "what is feasible".into(),
        x: Axis::log("ratio N"),
        y: Axis::named("", names),
        empty: "no motor can be evaluated".into(),
        ..Panel::default()
    };
    let goal = sweep.joint.goal();
    let near = format!("feasible, {goal} within {:.0} % of the best", 100.0 * NEAR);
    let kinds: [(&str, Tone, Shape); 4] = [
        ("a limit is exceeded", Tone::Grey, Shape::Cross),
        ("feasible", Tone::Sky, Shape::Square),
        (&near, Tone::Blue, Shape::Circle),
        ("cannot be judged", Tone::Grey, Shape::Circle),
    ];
    for (kind, (name, tone, shape), hollow) in
        kinds.into_iter().enumerate().flat_map(|(k, look)| [false, true].map(|hollow| (k, look, hollow)))
    {
        let (mut points, mut ids, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for (row, motor) in shown.iter().rev().enumerate().filter(|(_, m)| m.estimated == hollow) {
            for (design, value) in &motor.designs {
                let of = match (design.evaluation.feasible, *value <= (1.0 + NEAR) * best) {
                    (false, _) => 0,
                    _ if design.is_unjudged() => 3,
                    (true, false) => 1,
                    (true, true) => 2,
                };
                if of == kind {
                    points.push((design.evaluation.ratio, row as f64));
                    ids.push(motor.id.to_string());
                    notes.push(note(design, *value));
                }
            }
        }
        if !points.is_empty() {
            // A cross has no inside.
            let series = Series::new(tone, Mark::Points(shape), points).named(name).of(ids).noted(notes);
            panel.series.push(series.hollow(hollow && shape != Shape::Cross));
        }
    }
    panel
}

fn curves(sweep: &JointSweep, motors: &[Swept]) -> Panel {
    let goal = &sweep.joint.objective;
    let mut panel = Panel {
        title: format!("{} of the feasible designs", goal.name()),
        x: Axis::log("ratio N"),
        y: Axis { scale: Scale::Log, ..super::objective_axis(goal) },
        empty: "no design is feasible".into(),
        ..Panel::default()
    };
    let feasible: Vec<&Swept> = motors.iter().filter(|m| m.best.is_finite()).collect();
    let geared = feasible.iter().any(|m| m.designs.iter().any(|(d, _)| d.gear.is_some()));
    let points = |m: &Swept| -> Vec<(f64, f64)> {
        let all = m.designs.iter();
        all.map(|(d, v)| (d.evaluation.ratio, if d.is_choice() { *v } else { f64::NAN })).collect()
    };
    // What is only background lies lowest.
    let ranks = (CURVES..feasible.len().min(60)).chain(0..feasible.len().min(CURVES));
    for (rank, motor) in ranks.map(|rank| (rank, feasible[rank])) {
        let notes = || motor.designs.iter().map(|(d, v)| note(d, *v)).collect();
        let own = rank < CURVES;
        let tone = if own { Tone::nth(rank) } else { Tone::Grey };
        if !geared {
            let mark = if own { Mark::Line(Dash::nth(rank)) } else { Mark::Thin(Dash::Solid) };
            let line = Series::new(tone, mark, points(motor)).of(vec![motor.id.into()]).noted(vec![motor.id.into()]);
            panel.series.push(line);
        }
        if own || geared {
            let shape = if own { Shape::nth(rank) } else { Shape::Circle };
            let dots = Series::new(tone, Mark::Points(shape), points(motor)).of(vec![motor.id.into()]).noted(notes());
            let dots = dots.hollow(motor.estimated);
            panel.series.push(if own { dots.named(motor.id) } else { dots });
        }
    }
    if let Some(best) = feasible.first()
        && let Some((ratio, value)) =
            points(best).into_iter().filter(|p| p.1.is_finite()).min_by(|a, b| a.1.total_cmp(&b.1))
    {
        panel.labels.push(Label {
            at: (ratio, value),
            text: format!("{} at N = {}", best.id, number(ratio)),
            chosen: true,
        });
    }
    panel
}
