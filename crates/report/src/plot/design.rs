//! The pictures of one design, and of the best designs of each joint of a robot.

use super::{
    Axis, Dash, Figure, Group, Label, Mark, Panel, Series, Stripe, Tone, over_ratio, temperature, torque_speed,
};
use crate::number;
use gearwise_model::catalog::{Catalog, Gear, Motor};
use gearwise_model::numerics::grid::grid;
use gearwise_model::requirement::{Joint, Robot};
use gearwise_select::answer::{Design, JointResult, RobotResult};
use gearwise_select::explain::Explanation;
use gearwise_select::program::Optimum;
use gearwise_select::{Mount, Prepared, load_through};

/// Designs whose objective is drawn over the ratio.
const CURVES: usize = 6;

/// Prepares a motor at a joint and looks at it.
fn with_prepared<T>(
    robot: &Robot,
    joint: &Joint,
    motor: &Motor,
    gear: Option<&Gear>,
    look: impl FnOnce(&Prepared) -> T,
) -> Option<T> {
    let load = load_through(joint, gear);
    Mount::new(robot, joint, &load, motor).with_gear(gear).prepared().ok().map(|prepared| look(&prepared))
}

/// The joint with the spring that was chosen in its motion.
fn with_spring(joint: &Joint, spring: Option<(f64, f64)>) -> Joint {
    spring.and_then(|(stiffness, rest)| joint.with_spring(stiffness, rest)).unwrap_or_else(|| joint.clone())
}

fn name(motor: &Motor, gear: Option<&str>, ratio: f64) -> String {
    match gear {
        Some(gear) => format!("{} with {gear} (N = {})", motor.id, number(ratio)),
        None => format!("{} at N = {}", motor.id, number(ratio)),
    }
}

/// The pictures of an explanation: torque over speed, objective and limits over the ratio, temperature.
pub fn explained(robot: &Robot, story: &Explanation) -> Figure {
    let ratio = story.evaluation.ratio;
    let title = format!("{}: {}", story.joint.name, name(story.motor, story.gear.map(|g| g.id.as_str()), ratio));
    let state = match (story.evaluation.feasible, story.is_choice()) {
        (false, _) => "Some limit is exceeded. ",
        (true, true) => "All limits that can be checked are kept. ",
        (true, false) => "A limit that the requirement states cannot be judged; all that can be checked are kept. ",
    };
    let group = Group {
        title,
        caption: format!("{state}{}", torque_speed::CAPTION),
        own_legends: true,
        panels: panels_of(robot, story),
    };
    Figure { groups: vec![group], columns: 2, panel: (560.0, 400.0), ..Figure::default() }
}

/// The diagrams of one design, without a title, so that those of another one can take their place.
pub fn looked_at(robot: &Robot, story: &Explanation) -> Figure {
    let mut panels = panels_of(robot, story);
    // The temperature is not followed for every motor: it stands last.
    if panels.len() > 1 {
        let temperature = panels.remove(1);
        panels.push(temperature);
    }
    let group = Group { own_legends: true, panels, ..Group::default() };
    Figure { groups: vec![group], columns: 2, panel: (560.0, 400.0), ..Figure::default() }
}

/// Torque over speed of several designs, next to each other.
pub fn side_by_side(designs: &[(&Robot, &Explanation)]) -> Figure {
    let one = |(robot, story): &(&Robot, &Explanation)| {
        let ratio = story.evaluation.ratio;
        let title = format!("{}: {}", story.joint.name, name(story.motor, story.gear.map(|g| g.id.as_str()), ratio));
        with_story(robot, story, |prepared| torque_speed::panel(prepared, ratio, title))
    };
    let panels = designs.iter().filter_map(one).collect();
    let group = Group { own_legends: true, panels, ..Group::default() };
    Figure { groups: vec![group], columns: 2, panel: (560.0, 400.0), ..Figure::default() }
}

/// Prepares the motor of a story, with its spring, and looks at it.
fn with_story<T>(robot: &Robot, story: &Explanation, look: impl FnOnce(&Prepared) -> T) -> Option<T> {
    let spring = story.spring.as_ref().and_then(|s| s.as_ref().ok());
    let joint = with_spring(story.joint, spring.map(|s| (s.stiffness, s.rest_angle.unwrap_or(0.0))));
    with_prepared(robot, &joint, story.motor, story.gear, look)
}

fn panels_of(robot: &Robot, story: &Explanation) -> Vec<Panel> {
    let ratio = story.evaluation.ratio;
    let optimum = story.best.as_ref().and_then(|b| b.as_ref().ok());
    let panels = with_story(robot, story, |prepared| {
        let title = "torque over speed".into();
        let mut panels = vec![torque_speed::panel(prepared, ratio, title), temperature::panel(prepared, ratio)];
        panels.extend(of_ratios(prepared, optimum, ratio));
        panels
    });
    panels.unwrap_or_default()
}

/// Objective and limits over the ratio, where it is free.
fn of_ratios(prepared: &Prepared, optimum: Option<&Optimum>, ratio: f64) -> Vec<Panel> {
    let range = prepared.candidate.joint.ratio.range().filter(|_| prepared.candidate.catalog_gear.is_none());
    let Some(range) = range else { return Vec::new() };
    let all = over_ratio::evaluations(prepared, over_ratio::range(optimum, ratio, range));
    vec![over_ratio::objective(prepared, &all, optimum, ratio), over_ratio::limits(&all, optimum, ratio)]
}

/// The pictures of an optimisation: per joint the objective of the first designs over the ratio, and the
/// first choice's torque over speed. Joints that ask the same share theirs.
pub fn optimized(result: &RobotResult, catalog: &Catalog) -> Figure {
    let mut groups: Vec<Group> = Vec::new();
    for (k, joint) in result.joints.iter().enumerate() {
        let same = |j: &&JointResult| j.joint.asks_the_same(joint.joint);
        if result.joints[..k].iter().any(|j| same(&j)) {
            continue;
        }
        let names: Vec<&str> = result.joints[k..].iter().filter(same).map(|j| j.joint.name.as_str()).collect();
        groups.push(group(result.robot, joint, catalog, &names.join(", ")));
    }
    if let Some(first) = groups.first_mut() {
        first.caption = torque_speed::CAPTION.into();
    }
    Figure { groups, columns: 2, panel: (560.0, 380.0), ..Figure::default() }
}

fn group(robot: &Robot, result: &JointResult, catalog: &Catalog, names: &str) -> Group {
    let Some(first) = result.candidates.first() else {
        let which = if result.unjudged.is_empty() { "of the catalogue" } else { "that can be judged" };
        let empty = Panel { x: "".into(), empty: format!("no motor {which} is feasible"), ..Panel::default() };
        return Group { title: names.into(), panels: vec![empty], ..Group::default() };
    };
    let gear = first.gear.and_then(|id| catalog.gear(id));
    let ratio = first.optimum.ratio;
    let diagram = with_prepared(robot, &own_joint(result.joint, first), first.motor, gear, |prepared| {
        torque_speed::panel(prepared, ratio, format!("first choice: {}", name(first.motor, first.gear, ratio)))
    });
    let title = format!("{names}: the first of {} feasible motors is {}", result.candidates.len(), first.motor.id);
    let panels = std::iter::once(candidates(robot, result)).chain(diagram).collect();
    Group { title, caption: String::new(), own_legends: true, panels }
}

fn own_joint(joint: &Joint, design: &Design) -> Joint {
    with_spring(joint, design.spring.as_ref().map(|s| (s.stiffness, s.rest_angle.unwrap_or(0.0))))
}

/// The objective of the first designs over the ratio, or at their gears.
fn candidates(robot: &Robot, result: &JointResult) -> Panel {
    let goal = &result.joint.objective;
    let mut panel = Panel {
        title: format!("{}, where all limits are kept", goal.name()),
        x: Axis::log("ratio N"),
        y: super::objective_axis(goal),
        empty: "one ratio only".into(),
        ..Panel::default()
    };
    if result.joint.ratio.is_catalog() {
        return geared(panel, result);
    }
    for (rank, design) in result.candidates.iter().take(CURVES).enumerate() {
        let best = (design.optimum.ratio, design.optimum.objective);
        let ids = vec![design.motor.id.clone()];
        {
            let joint = own_joint(result.joint, design);
            let curve = with_prepared(robot, &joint, design.motor, None, |prepared| curve(prepared, &design.optimum));
            let series = Series::new(Tone::nth(rank), Mark::Line(Dash::nth(rank)), curve.unwrap_or_default());
            panel.series.push(series.named(design.motor.id.as_str()).of(ids.clone()));
        }
        let note = name(design.motor, design.gear, design.optimum.ratio);
        let shape = super::Shape::nth(rank);
        let dot = Series::new(Tone::nth(rank), Mark::Points(shape), vec![best]).of(ids).noted(vec![note]);
        panel.series.push(dot.named(design.motor.id.as_str()).hollow(!design.motor.estimates.is_empty()));
        let text = format!("N* = {}", number(design.optimum.ratio));
        panel.labels.push(Label { at: best, text, chosen: rank == 0 });
    }
    if let Some(first) = result.candidates.first().filter(|d| d.gear.is_none()) {
        for window in &first.optimum.windows {
            panel.stripes.push(Stripe {
                along: super::Along::X,
                from: window.min,
                to: window.max,
                tone: Tone::Blue,
                name: format!("{} is feasible", first.motor.id),
            });
        }
    }
    let least = result.candidates.first().map_or(0.0, |d| d.optimum.objective);
    let values = panel.series.iter().flat_map(|s| &s.points).map(|p| p.1).filter(|v| v.is_finite());
    let most = values.fold(least, f64::max);
    // A curve that rises without end must not squash the others.
    let last = result.candidates.iter().take(CURVES).map(|d| d.optimum.objective).fold(least, f64::max);
    if least > 0.0 && most > 4.0 * last {
        panel.y.range = Some((0.0, 4.0 * last));
    }
    panel.explain_hollow();
    panel
}

/// Gears of a catalogue have ratios of their own and nothing between them: a bar for each of the first designs.
fn geared(mut panel: Panel, result: &JointResult) -> Panel {
    let goal = &result.joint.objective;
    let first: Vec<&Design> = result.candidates.iter().take(CURVES).collect();
    panel.x =
        Axis::named("N of the gear, the best design first", first.iter().map(|d| number(d.optimum.ratio)).collect());
    for (rank, design) in first.into_iter().enumerate() {
        let at = (rank as f64, design.optimum.objective);
        let gear = design.gear.map_or_else(String::new, |gear| format!(" + {gear}"));
        let bar = Series::new(Tone::nth(rank), Mark::Bars, vec![at]).of(vec![design.motor.id.clone()]);
        let bar = bar.noted(vec![name(design.motor, design.gear, design.optimum.ratio)]);
        panel.series.push(bar.named(format!("{}{gear}", design.motor.id)).hollow(!design.motor.estimates.is_empty()));
        let text = super::unit(&crate::with_unit(design.optimum.objective, goal.unit()));
        panel.labels.push(Label { at, text, chosen: rank == 0 });
    }
    let most = panel.labels.iter().map(|l| l.at.1).fold(0.0, f64::max);
    panel.y.range =
        Some((0.0, 1.15 * most)).filter(|(_, high)| *high > 0.0 && panel.labels.iter().all(|l| l.at.1 >= 0.0));
    panel.explain_hollow();
    panel
}

/// The objective over the design's own windows.
fn curve(prepared: &Prepared, optimum: &Optimum) -> Vec<(f64, f64)> {
    let goal = &prepared.candidate.joint.objective;
    let mut points = Vec::new();
    for window in &optimum.windows {
        let ratios =
            if window.max > window.min * (1.0 + 1e-9) { grid(window.min, window.max, 101) } else { vec![window.min] };
        points.extend(ratios.into_iter().map(|n| (n, prepared.at_in_full(n).objective(goal).unwrap_or(f64::NAN))));
        points.push((f64::NAN, f64::NAN));
    }
    points
}
