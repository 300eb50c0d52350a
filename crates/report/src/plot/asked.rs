//! What a requirement asks of each joint: load torque and speed over time, operating points as torque over speed.

use super::{Dash, Figure, Group, Mark, Panel, Series, Shape, Tone, thinned};
use gearwise_model::requirement::{Course, Joint, Motion};

/// Most samples of a motion that are drawn.
const SAMPLES: usize = 800;
/// Joints that get a look of their own.
const LOOKS: usize = 7;

/// The motions of all joints over each other; joints that do the same are drawn once.
pub fn figure(joints: &[&Joint]) -> Figure {
    let mut kinds: Vec<(Vec<&str>, &Motion)> = Vec::new();
    for (joint, (name, motion)) in
        joints.iter().flat_map(|joint| joint.own_motions().into_iter().map(move |m| (joint, m)))
    {
        let name = if name.is_empty() { &joint.name } else { name };
        match kinds.iter_mut().find(|(_, first)| *first == motion) {
            Some((names, _)) => names.push(name),
            None => kinds.push((vec![name], motion)),
        }
    }
    let axes =
        [("time [s]", "load torque [N·m]"), ("time [s]", "speed [rad/s]"), ("speed [rad/s]", "load torque [N·m]")];
    let mut panels =
        axes.map(|(x, y)| Panel { x: x.into(), y: y.into(), empty: "nothing is asked".into(), ..Panel::default() });
    for (rank, (names, m)) in kinds.iter().enumerate() {
        let name = names.join(", ");
        let own = rank < LOOKS;
        let tone = if own { Tone::nth(rank) } else { Tone::Grey };
        let series = |mark: Mark, points: Vec<(f64, f64)>| {
            let series = Series::new(tone, mark, points);
            if own { series.named(name.as_str()) } else { series.named("further joints") }
        };
        if matches!(m.course, Course::Points(_)) {
            let points = (0..m.len()).map(|k| (m.velocity[k], m.torque[k])).collect();
            let notes = (0..m.len()).map(|k| format!("{name}: {}", m.name_sample(k))).collect();
            let shape = if own { Shape::nth(rank) } else { Shape::Circle };
            panels[2].series.push(series(Mark::Points(shape), points).noted(notes));
            continue;
        }
        let mark = Mark::Line(if own { Dash::nth(rank) } else { Dash::Solid });
        for (panel, of) in panels.iter_mut().zip([&m.torque, &m.velocity]) {
            let mut points: Vec<(f64, f64)> = thinned(m.len(), SAMPLES).map(|k| (m.time[k], of[k])).collect();
            // A motion that repeats comes back to where it began.
            if let (Course::Periodic(period), Some(first)) = (m.course, points.first().copied()) {
                points.push((first.0 + period, first.1));
            }
            panel.series.push(series(mark, points));
        }
    }
    for panel in &mut panels {
        // One operating point, or points on a line, have no extent of their own.
        let shown =
            |of: fn(&(f64, f64)) -> f64| panel.series.iter().flat_map(|s| &s.points).map(of).collect::<Vec<_>>();
        (panel.x.range, panel.y.range) = (extent(&shown(|p| p.0)), extent(&shown(|p| p.1)));
    }
    let panels: Vec<Panel> = panels.into_iter().filter(|p| !p.series.is_empty()).collect();
    let group = Group { panels, ..Group::default() };
    Figure {
        title: "What is asked".into(),
        groups: vec![group],
        columns: 2,
        panel: (560.0, 260.0),
        ..Figure::default()
    }
}

/// A range for values that are all the same; else `None`, and the axis takes that of its data.
fn extent(values: &[f64]) -> Option<(f64, f64)> {
    let first = *values.first()?;
    let room = if first == 0.0 { 1.0 } else { 0.5 * first.abs() };
    values.iter().all(|v| *v == first).then_some((first - room, first + room))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_are_all_the_same_have_room_and_others_their_own() {
        assert_eq!(extent(&[2.0, 2.0]), Some((1.0, 3.0)));
        assert_eq!(extent(&[0.0]), Some((-1.0, 1.0)));
        assert_eq!(extent(&[1.0, 2.0]), None);
        assert_eq!(extent(&[]), None);
    }
}
