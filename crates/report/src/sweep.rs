//! Every motor at every ratio, feasible or why not.

use std::collections::{BTreeMap, BTreeSet};

use super::columns::{self, Entry, State};
use super::optimize::fitted_notes;
use super::table::{Column, Table, paragraph};
use super::{number, unjudged};
use gearwise_model::actuator::metrics::{Metric, metric};
use gearwise_model::requirement::{Quantity, Robot};
use gearwise_select::answer::{JointSweep, SweptDesign};

/// What a sweep is ordered by.
#[derive(Debug, Clone, Copy)]
pub enum Order {
    /// The joint's objective.
    Objective,
    /// One quantity of the design.
    Quantity(Quantity),
    /// A metric of the motor, then the objective.
    Metric(&'static Metric),
    /// The smallest margin, largest first.
    Margin,
}

/// The key that sorts a design: less is better; designs that cannot be judged after those that can, infeasible ones
/// last by their worst margin.
fn key(design: &SweptDesign, joint: &gearwise_model::requirement::Joint, order: Order) -> (u8, f64, f64) {
    let e = &design.evaluation;
    let objective = e.objective(&joint.objective).unwrap_or(f64::INFINITY);
    let margin = e.tightest().map_or(0.0, |m| -m.margin);
    let first = match order {
        _ if !e.feasible => margin,
        Order::Objective => objective,
        Order::Quantity(quantity) => e.quantity(quantity).unwrap_or(f64::INFINITY),
        Order::Metric(metric) => {
            metric.value(design.motor).map_or(f64::INFINITY, |v| if metric.lower_is_better { v } else { -v })
        }
        Order::Margin => margin,
    };
    (2 * u8::from(!e.feasible) + u8::from(design.is_unjudged()), first, objective)
}

/// Designs in order: first those that are a choice, then those that cannot be judged, then those that are not feasible.
pub fn ordered<'r, 'a>(sweep: &'r JointSweep<'a>, order: Order) -> Vec<&'r SweptDesign<'a>> {
    let mut designs: Vec<(&SweptDesign, (u8, f64, f64))> =
        sweep.designs.iter().map(|d| (d, key(d, sweep.joint, order))).collect();
    designs.sort_unstable_by(|(a, x), (b, y)| {
        x.0.cmp(&y.0)
            .then(x.1.total_cmp(&y.1))
            .then(x.2.total_cmp(&y.2))
            .then_with(|| a.motor.id.cmp(&b.motor.id))
            .then_with(|| a.gear.cmp(&b.gear))
            .then(a.evaluation.ratio.total_cmp(&b.evaluation.ratio))
    });
    designs.into_iter().map(|(d, _)| d).collect()
}

/// Keeps the first `most` gears of each motor in an order; how many designs that leaves out.
pub fn first_gears(sweep: &mut JointSweep, order: Order, most: usize) -> usize {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let mut kept: BTreeSet<(String, Option<String>)> = BTreeSet::new();
    for design in ordered(sweep, order) {
        let count = seen.entry(design.motor.id.clone()).or_default();
        *count += 1;
        if *count <= most {
            kept.insert((design.motor.id.clone(), design.gear.map(String::from)));
        }
    }
    let before = sweep.designs.len();
    sweep.designs.retain(|d| kept.contains(&(d.motor.id.clone(), d.gear.map(String::from))));
    before - sweep.designs.len()
}

/// Why a design is no choice: the worst limit, by how much, and when; or what cannot be judged. Empty for a choice.
pub(super) fn because(design: &SweptDesign, joint: &gearwise_model::requirement::Joint) -> String {
    match (design.is_choice(), design.is_unjudged()) {
        (true, _) => return String::new(),
        (_, true) => return unjudged::sentence(&design.unjudged),
        _ => {}
    }
    let Some(worst) = design.evaluation.tightest() else { return String::new() };
    let at = worst.sample.map_or_else(String::new, |k| format!(" at {}", joint.motion.name_sample(k)));
    format!("{}: {}{at}", worst.limit, super::demand_of(worst))
}

/// The same in short: the text of all designs that fail alike.
pub(super) fn class(design: &SweptDesign) -> String {
    let worst = design.evaluation.tightest().filter(|_| !design.evaluation.feasible);
    worst.map_or_else(String::new, |worst| format!("{} is exceeded", worst.limit))
}

/// For people.
pub fn text(robot: &Robot, sweeps: &[JointSweep], order: Order, top: usize, infeasible: bool) -> String {
    let mut out = paragraph(&format!("{}: {}", robot.name, super::counted(robot.joints.len(), "joint")), 0, 2);
    for sweep in sweeps {
        let feasible = sweep.designs.iter().filter(|d| d.is_choice()).count();
        let apart = unjudged::counted(sweep.designs.iter().filter(|d| d.is_unjudged()).count());
        let all = sweep.designs.len();
        let heading = format!(
            "{}: {}, {feasible} feasible{apart}",
            sweep.joint.name,
            gearwise_model::words::counted(all, "design")
        );
        out.push_str(&format!("\n{}\n", paragraph(&heading, 0, 2)));
        let designs = ordered(sweep, order);
        let mut table = Table::new(headings(order)).indented(2).also_in("`--csv`, `--json`");
        for d in designs.iter().filter(|d| d.is_choice() || infeasible && !d.is_unjudged()).take(top) {
            let facts = d.facts(sweep.joint);
            let mut row = vec![d.motor.id.clone(), number(d.evaluation.ratio)];
            row.extend(columns::in_tables().map(|figure| columns::cell(figure, &facts)));
            row.extend(shown_metrics().map(|metric| columns::metric_cell(metric, d.motor)));
            table.push(row, vec![verdict(d, sweep.joint)]);
        }
        if !table.is_empty() {
            out.push_str(&table.text());
        }
        out.push_str(&unjudged::sweep_text(sweep));
        out.push_str(&counts(sweep));
    }
    out
}

/// The columns of the designs; what orders them is never dropped.
fn headings(order: Order) -> Vec<Column> {
    let kept = match order {
        Order::Quantity(Quantity::PeakCurrent) => "peak_current_phase",
        Order::Quantity(quantity) => quantity.name(),
        Order::Metric(metric) => metric.name,
        Order::Objective | Order::Margin => "",
    };
    let figures = columns::in_tables().map(|figure| columns::heading(figure, kept));
    let metrics = shown_metrics().zip([3, 2, 1]).map(|(metric, drop)| columns::metric_heading(metric, kept, drop));
    [Column::name("motor"), Column::number("N", "")].into_iter().chain(figures).chain(metrics).collect()
}

/// The metrics of the motors that the table shows.
fn shown_metrics() -> impl Iterator<Item = &'static Metric> {
    ["s_m", "mass_s_m", "s_t"].into_iter().filter_map(metric)
}

/// Feasible with how much left, or why not; with which gear.
fn verdict(design: &SweptDesign, joint: &gearwise_model::requirement::Joint) -> String {
    let e = &design.evaluation;
    let gear = design.gear.map_or_else(String::new, |g| format!("with {g}; "));
    match e.tightest() {
        None => format!("{gear}nothing could be checked"),
        Some(m) if e.feasible => {
            format!("{gear}feasible, tightest margin {} {:.0} %", m.limit, (100.0 * m.margin).max(0.0))
        }
        Some(_) => format!("{gear}not feasible: {}", because(design, joint)),
    }
}

/// How many designs each limit rejects, and what could not be checked, as paragraphs.
fn counts(sweep: &JointSweep) -> String {
    let lines = remarks(sweep);
    let lines = lines.iter().enumerate().map(|(k, line)| {
        // A blank line sets the designs apart.
        let gap = if k == 0 && line.starts_with(INFEASIBLE) { "\n" } else { "" };
        format!("{gap}{}", paragraph(line, 0, 2))
    });
    lines.collect()
}

const INFEASIBLE: &str = "Infeasible designs by the limit they exceed most";

/// How many designs each limit rejects, what could not be checked, and what was left out.
pub(super) fn remarks(sweep: &JointSweep) -> Vec<String> {
    let mut worst: BTreeMap<&str, usize> = BTreeMap::new();
    let mut unchecked: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let mut assumed: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for design in &sweep.designs {
        if !design.evaluation.feasible {
            design.evaluation.tightest().into_iter().for_each(|margin| *worst.entry(margin.limit).or_default() += 1);
            continue;
        }
        for what in design.unchecked.iter() {
            *unchecked.entry(*what).or_default() += 1;
        }
        for what in design.assumed.iter() {
            *assumed.entry(*what).or_default() += 1;
        }
    }
    let kept = sweep.designs.iter().filter(|design| design.evaluation.feasible).count();
    let mut out = Vec::new();
    if !worst.is_empty() {
        let mut worst: Vec<_> = worst.into_iter().collect();
        worst.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
        let list: Vec<String> = worst.iter().map(|(limit, n)| format!("{limit} {n}")).collect();
        out.push(format!("{INFEASIBLE}: {}", list.join(", ")));
    }
    let mut fitted: BTreeSet<String> = BTreeSet::new();
    for design in &sweep.designs {
        if !design.motor.effects.is_empty() || design.motor.fitted_gear.is_some() {
            for note in fitted_notes(design.motor, sweep.joint) {
                fitted.insert(format!("{}: {} {}", design.motor.id, note.effect, note.how));
            }
        }
    }
    for line in fitted {
        out.push(format!("Fitted, {line}"));
    }
    for ((limit, why), n) in unchecked {
        out.push(format!(
            "Not checked in {n} of the {} that keep all else: {limit}, because {why}",
            gearwise_model::words::counted(kept, "design")
        ));
    }
    for ((limit, what), n) in assumed {
        out.push(format!(
            "Assumed in {n} of the {} that keep all else: {limit}: {what}",
            gearwise_model::words::counted(kept, "design")
        ));
    }
    out.extend(super::family::note(sweep.joint));
    out.extend(super::motion::notes(sweep.joint));
    let mut reasons: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (motor, gear, why) in &sweep.unusable {
        reasons
            .entry(why.reason())
            .or_default()
            .push(gear.map_or_else(|| motor.id.clone(), |g| format!("{} with {g}", motor.id)));
    }
    for (why, who) in reasons {
        let shown = who.len().min(6);
        let more = if who.len() > shown { format!(", and {} more", who.len() - shown) } else { String::new() };
        out.push(format!("Left out ({}) because {why}: {}{more}", who.len(), who[..shown].join(", ")));
    }
    out
}

/// As rows: every design, then what was left out.
pub fn csv(sweeps: &[JointSweep], order: Order) -> String {
    let rows = sweeps.iter().flat_map(|sweep| {
        let joint = sweep.joint;
        let designs = ordered(sweep, order).into_iter().map(move |design| {
            let state = match (design.is_choice(), design.is_unjudged()) {
                (true, _) => State::Candidate,
                (_, true) => State::Unjudged,
                _ => State::Rejected,
            };
            Entry::design(joint, state, None, design.facts(joint)).because(because(design, joint))
        });
        let left_out = sweep.unusable.iter().map(move |(motor, gear, why)| match why.unknown() {
            Some(what) => Entry::without(joint, State::Unjudged, motor, *gear, unjudged::sentence(&[what])),
            None => Entry::without(joint, State::Rejected, motor, *gear, why.reason().into()),
        });
        designs.chain(left_out).collect::<Vec<_>>()
    });
    columns::csv(rows, false)
}
