//! Fronts: of two quantities a curve with a motor's name at each stretch of it; of more a matrix, a panel for each pair of them.

use super::{Axis, Dash, Figure, Group, Label, Mark, Panel, Scale, Series, Shape, Tone, thinned, unit};
use crate::number;
use crate::pareto::{first_motors, listed, motors};
use gearwise_model::requirement::Quantity;
use gearwise_select::pareto::{Front, FrontPoint};

/// Motors that get a look of their own.
const LOOKS: usize = 6;
/// Points of a motor behind the front of a pair that are drawn.
const BEHIND: usize = 100;
/// Points of all motors without a look of their own that are drawn in a panel of a matrix.
const OTHERS: usize = 400;
/// Small dots that are drawn in a matrix; its panels share them.
const IN_ALL: usize = 2400;
/// Width and height of a panel: of a front by itself, and in a matrix \[px\].
const PANEL: (f64, f64) = (560.0, 420.0);
const IN_MATRIX: (f64, f64) = (400.0, 300.0);

/// One panel for each joint; of more than two quantities one for each pair of them.
pub fn figure(fronts: &[Front]) -> Figure {
    let quantities = fronts.first().map_or(&[][..], |front| &front.quantities);
    match quantities {
        [a, b] => Figure {
            groups: vec![Group {
                title: format!("Fronts of {} and {}", a.name(), b.name()),
                caption: "Each point is a design that keeps all limits; none has less of one quantity without more of the other. \
                          A motor's points differ in the ratio N, which appears at them. Between two motors the front is a \
                          step: there is nothing between them."
                    .into(),
                own_legends: true,
                panels: fronts.iter().map(panel).collect(),
            }],
            columns: fronts.len().clamp(1, 2),
            panel: PANEL,
            ..Figure::default()
        },
        _ => Figure {
            title: format!("Fronts of {}", listed(quantities)),
            groups: fronts.iter().enumerate().flat_map(|(k, front)| matrix(front, k == 0)).collect(),
            columns: quantities.len().saturating_sub(1).max(1),
            panel: IN_MATRIX,
            ..Figure::default()
        },
    }
}

/// Of the [figure] of all fronts what is of the k-th of them.
pub fn of_joint(figure: &Figure, front: &Front, k: usize) -> Option<Figure> {
    let rows = front.quantities.len().saturating_sub(1);
    let groups = match rows {
        1 => {
            let mut group = figure.groups.first()?.clone();
            group.panels = vec![group.panels.get(k)?.clone()];
            vec![group]
        }
        _ => figure.groups.get(k * rows..(k + 1) * rows)?.to_vec(),
    };
    let columns = if rows == 1 { 1 } else { figure.columns };
    Some(Figure { groups, title: String::new(), columns, ..figure.clone() })
}

fn axis(quantity: Quantity, values: impl Iterator<Item = f64>) -> Axis {
    let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    let scale = if low > 0.0 && high > 20.0 * low { Scale::Log } else { Scale::Linear };
    Axis { scale, ..Axis::linear(format!("{} [{}]", quantity.name().replace('_', " "), unit(quantity.unit()))) }
}

/// The axis of a quantity over all points of a front.
fn axis_of(front: &Front, k: usize) -> Axis {
    axis(front.quantities[k], front.points.iter().map(|p| p.values[k]))
}

/// What is said of a point.
fn note(point: &FrontPoint) -> String {
    let gear = point.gear.map_or_else(String::new, |g| format!(" with {g}"));
    format!("{}{gear} at N = {}", point.motor.id, number(point.evaluation.ratio))
}

fn title(front: &Front) -> String {
    let on_front = motors(front).len();
    format!("{}: {on_front} of {} feasible motors are on the front", front.joint.name, front.motors)
}

fn empty(front: &Front) -> String {
    if front.points.is_empty() { "no design is feasible" } else { "one design is the best in both" }.into()
}

/// A range about a single value, which has no extent of its own.
fn about(value: f64) -> Option<(f64, f64)> {
    Some((0.0, 2.0 * value)).filter(|_| value > 0.0)
}

fn panel(front: &Front) -> Panel {
    let at = |k: usize| (front.points[k].values[0], front.points[k].values[1]);
    let [x, y] = [0, 1].map(|k| axis_of(front, k));
    let mut panel = Panel { title: title(front), x, y, empty: empty(front), ..Panel::default() };
    let all: Vec<&FrontPoint> = front.points.iter().collect();
    panel.series.push(Series::new(Tone::Grey, Mark::Thin(Dash::Solid), staircase(&all, [0, 1])));
    if front.points.iter().all(|p| p.values == front.points[0].values) {
        let single = front.points.first().map(|p| [about(p.values[0]), about(p.values[1])]);
        (panel.x.range, panel.y.range) = single.map_or((None, None), |[x, y]| (x, y));
    }
    let mut ends = Vec::new();
    for (rank, motor) in motors(front).into_iter().enumerate() {
        let of: Vec<usize> = (0..front.points.len()).filter(|k| front.points[*k].motor.id == motor).collect();
        let (tone, shape) =
            if rank < LOOKS { (Tone::nth(rank), Shape::nth(rank)) } else { (Tone::Grey, Shape::Circle) };
        let series = Series::new(tone, Mark::Points(shape), of.iter().map(|k| at(*k)).collect());
        let estimated = !front.points[of[0]].motor.estimates.is_empty();
        let notes = of.iter().map(|k| note(&front.points[*k])).collect();
        let series = series.of(vec![motor.to_string()]).noted(notes);
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
fn staircase(points: &[&FrontPoint], [a, b]: [usize; 2]) -> Vec<(f64, f64)> {
    let mut line = Vec::new();
    for (k, point) in points.iter().enumerate() {
        let before = k.checked_sub(1).map(|before| points[before]);
        let step = before.filter(|b| b.motor.id != point.motor.id || b.gear.is_some());
        line.extend(step.map(|before| (point.values[a], before.values[b])));
        line.push((point.values[a], point.values[b]));
    }
    line
}

/// The rows of a matrix of pairs, the second quantity over the first, the third over the first two, and so on; its first panel names the
/// motors, and the first matrix of all says how it is read.
fn matrix(front: &Front, explained: bool) -> Vec<Group> {
    let count = front.quantities.len();
    let looks = first_motors(front, LOOKS.max(count));
    let panels = count * (count - 1) / 2;
    let share = |most: usize| (most * IN_ALL / (panels * (OTHERS + looks.len() * BEHIND)).max(IN_ALL)).max(1);
    let most = [BEHIND, OTHERS].map(share);
    let row = |y: usize| {
        let panels = (0..y).map(|x| pair(front, [x, y], &looks, most, y == 1)).collect();
        let group = Group { panels, ..Group::default() };
        if y > 1 {
            return group;
        }
        let caption = match explained {
            true => {
                "Each panel is a pair of the quantities, with the same points in all and the same axis along each row and column. Each point \
                 is a design that keeps all limits; none has less of one quantity without more of another. Line and large marks are the \
                 front of that pair alone; a small dot is better in a quantity that is not in the panel."
            }
            false => "",
        };
        Group { title: title(front), caption: caption.into(), ..group }
    };
    (1..count).map(row).collect()
}

/// A panel of a matrix.
fn pair(
    front: &Front,
    [a, b]: [usize; 2],
    looks: &[&str],
    [behind_most, others_most]: [usize; 2],
    named: bool,
) -> Panel {
    let mut sorted: Vec<&FrontPoint> = front.points.iter().collect();
    sorted.sort_by(|p, q| p.values[a].total_cmp(&q.values[a]).then(p.values[b].total_cmp(&q.values[b])));
    let mut least = f64::INFINITY;
    let (of_pair, behind): (Vec<&FrontPoint>, Vec<&FrontPoint>) = sorted.into_iter().partition(|p| {
        let is_on = p.values[b] < least;
        least = least.min(p.values[b]);
        is_on
    });
    let mut panel = Panel { x: axis_of(front, a), y: axis_of(front, b), empty: empty(front), ..Panel::default() };
    for (axis, k) in [(&mut panel.x, a), (&mut panel.y, b)] {
        let values = || front.points.iter().map(|p| p.values[k]);
        if values().all(|value| value == front.points[0].values[k]) {
            axis.range = values().next().and_then(about);
        }
    }
    let at = |p: &FrontPoint| (p.values[a], p.values[b]);
    let marked = |tone: Tone, mark: Mark, points: Vec<&FrontPoint>| {
        let series = Series::new(tone, mark, points.iter().map(|p| at(p)).collect());
        series.of(points.iter().map(|p| p.motor.id.clone()).collect()).noted(points.iter().map(|p| note(p)).collect())
    };
    let of = |points: &[&'_ FrontPoint], motor: Option<&str>| -> Vec<usize> {
        let is_of = |p: &FrontPoint| match motor {
            Some(motor) => p.motor.id == motor,
            None => !looks.contains(&p.motor.id.as_str()),
        };
        (0..points.len()).filter(|k| is_of(points[*k])).collect()
    };
    panel.series.push(Series::new(Tone::Grey, Mark::Thin(Dash::Solid), staircase(&of_pair, [a, b])));
    let mut add = |motor: Option<&str>, rank: usize, most: usize| {
        let (tone, shape) = match motor {
            Some(_) => (Tone::nth(rank), Shape::nth(rank)),
            None => (Tone::Grey, Shape::Circle),
        };
        let far = of(&behind, motor);
        let drawn = thinned(far.len(), most).map(|k| behind[far[k]]).collect();
        panel.series.push(marked(tone, Mark::Dots, drawn));
        let near: Vec<&FrontPoint> = of(&of_pair, motor).into_iter().map(|k| of_pair[k]).collect();
        // A motor is named in the first panel, wherever it has points.
        let is_any = near.len() + far.len() > 0;
        let name = motor.unwrap_or(if is_any { "other motors" } else { "" });
        let estimated = motor
            .is_some_and(|motor| front.points.iter().any(|p| p.motor.id == motor && !p.motor.estimates.is_empty()));
        let series = marked(tone, Mark::Points(shape), near).hollow(estimated);
        panel.series.push(if named { series.named(name) } else { series });
    };
    add(None, usize::MAX, others_most);
    looks.iter().enumerate().for_each(|(rank, motor)| add(Some(motor), rank, behind_most));
    if named {
        panel.explain_hollow();
    }
    panel
}
