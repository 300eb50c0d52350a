//! Every motor at every ratio, feasible or why not.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value, json};

use super::optimize::{fitted_json, fitted_notes, margins_json};
use super::table::{Column, Table, paragraph};
use super::{csv_number, currents, number, optional, unjudged};
use crate::actuator::metrics::{METRICS, Metric};
use crate::design::sweep::{JointSweep, SweptDesign};
use crate::requirement::{Quantity, Robot};

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
fn key(design: &SweptDesign, joint: &crate::requirement::Joint, order: Order) -> (u8, f64, f64) {
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
    designs.sort_by(|(a, x), (b, y)| {
        x.0.cmp(&y.0)
            .then(x.1.total_cmp(&y.1))
            .then(x.2.total_cmp(&y.2))
            .then_with(|| a.motor.id.cmp(&b.motor.id))
            .then_with(|| a.gear.cmp(&b.gear))
            .then(a.evaluation.ratio.total_cmp(&b.evaluation.ratio))
    });
    designs.into_iter().map(|(d, _)| d).collect()
}

/// Why a design is no choice: the worst limit, by how much, and when; or what cannot be judged. Empty for a choice.
pub(super) fn because(design: &SweptDesign, joint: &crate::requirement::Joint) -> String {
    match (design.is_choice(), design.is_unjudged()) {
        (true, _) => return String::new(),
        (_, true) => return unjudged::sentence(&design.unjudged),
        _ => {}
    }
    let Some(worst) = design.evaluation.tightest() else { return String::new() };
    let at = worst.sample.map_or_else(String::new, |k| format!(" at {}", joint.motion.name_sample(k)));
    format!("{}: {} of {} {}{at}", worst.limit, number(worst.demand), number(worst.bound), worst.unit)
}

/// For people.
pub fn text(robot: &Robot, sweeps: &[JointSweep], order: Order, top: usize, infeasible: bool) -> String {
    let mut out = paragraph(&format!("{}: {}", robot.name, super::counted(robot.joints.len(), "joint")), 0, 2);
    for sweep in sweeps {
        let feasible = sweep.designs.iter().filter(|d| d.is_choice()).count();
        let apart = unjudged::counted(sweep.designs.iter().filter(|d| d.is_unjudged()).count());
        let all = sweep.designs.len();
        let heading = format!("{}: {all} designs, {feasible} feasible{apart}", sweep.joint.name);
        out.push_str(&format!("\n{}\n", paragraph(&heading, 0, 2)));
        let designs = ordered(sweep, order);
        let mut table = Table::new(columns(order)).indented(2).also_in("`--csv`, `--json`");
        for d in designs.iter().filter(|d| d.is_choice() || infeasible && !d.is_unjudged()).take(top) {
            let e = &d.evaluation;
            let metric =
                |i: usize| optional(METRICS[i].value(d.motor).map(|v| crate::units::in_unit(v, METRICS[i].unit)));
            let mut row = vec![
                d.motor.id.clone(),
                number(e.ratio),
                number(e.loss),
                number(e.reflected_inertia),
                optional(e.mass),
            ];
            row.extend([metric(0), metric(2), metric(1)]);
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
fn columns(order: Order) -> Vec<Column> {
    let first = match order {
        Order::Quantity(Quantity::Loss) => "loss",
        Order::Quantity(Quantity::ReflectedInertia) => "J",
        Order::Quantity(Quantity::Mass) => "mass",
        Order::Metric(metric) => metric.symbol,
        _ => "",
    };
    let number = |heading: &str, unit: &str, drop: u8| {
        let column = Column::number(heading, unit);
        if heading == first { column } else { column.dropped(drop) }
    };
    let metric = |i: usize, drop: u8| number(METRICS[i].symbol, METRICS[i].unit, drop);
    vec![
        Column::name("motor"),
        Column::number("N", ""),
        number("loss", "W", 6),
        number("J", "kg*m^2", 4),
        number("mass", "kg", 5),
        metric(0, 3),
        metric(2, 2),
        metric(1, 1),
    ]
}

/// Feasible with how much left, or why not; with which gear.
fn verdict(design: &SweptDesign, joint: &crate::requirement::Joint) -> String {
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
        if !design.evaluation.feasible
            && let Some(margin) = design.evaluation.tightest()
        {
            *worst.entry(margin.limit).or_default() += 1;
        }
        for what in design.unchecked.iter() {
            *unchecked.entry(*what).or_default() += 1;
        }
        for what in design.assumed.iter() {
            *assumed.entry(*what).or_default() += 1;
        }
    }
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
        out.push(format!("Not checked in {n} designs: {limit}, because {why}"));
    }
    for ((limit, what), n) in assumed {
        out.push(format!("Assumed in {n} designs: {limit}: {what}"));
    }
    out.extend(super::between::words(sweep.joint));
    let mut reasons: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (motor, gear, why) in &sweep.unusable {
        reasons
            .entry(why.reason())
            .or_default()
            .push(gear.map_or_else(|| (*motor).to_string(), |g| format!("{motor} with {g}")));
    }
    for (why, who) in reasons {
        let shown = who.len().min(6);
        let more = if who.len() > shown { format!(", and {} more", who.len() - shown) } else { String::new() };
        out.push(format!("Left out ({}) because {why}: {}{more}", who.len(), who[..shown].join(", ")));
    }
    out
}

/// For programs.
pub fn json(robot: &Robot, sweeps: &[JointSweep], order: Order) -> Value {
    let joints = sweeps.iter().map(|sweep| {
        let designs = ordered(sweep, order).into_iter().map(|d| {
            let e = &d.evaluation;
            let (margins, limits) = margins_json(&e.margins, sweep.joint);
            let mut object = Map::new();
            let mut put = |key: &str, value: Value| object.insert(key.into(), value);
            put("motor", json!(d.motor.id));
            put("gear", json!(d.gear));
            put("ratio", json!(e.ratio));
            put("feasible", json!(e.feasible));
            put("judged", json!(d.unjudged.is_empty()));
            put("because", if d.is_choice() { Value::Null } else { json!(because(d, sweep.joint)) });
            put("objective", json!(e.objective(&sweep.joint.objective)));
            if let Some(list) = fitted_json(d.motor, sweep.joint) {
                put("fitted", list);
            }
            put("loss_w", json!(e.loss));
            put("mean_electrical_power_w", json!(e.mean_power));
            put("reflected_inertia_kgm2", json!(e.reflected_inertia));
            put("mass_kg", json!(e.mass));
            put("margins", margins);
            put("limits", limits);
            put("assumed", super::unjudged::assumed(&d.assumed));
            put("not_checked", unjudged::list(&d.unchecked));
            for metric in METRICS.iter().take(4) {
                put(&format!("{}_{}", metric.name, metric.si_suffix), json!(metric.value(d.motor)));
            }
            currents::put(&mut object, d.motor, e);
            Value::Object(object)
        });
        let unusable = sweep
            .unusable
            .iter()
            .map(|(motor, gear, why)| json!({ "motor": motor, "gear": gear, "because": why.reason() }));
        json!({
            "joint": sweep.joint.name, "between_samples": super::between::json(sweep.joint),
            "designs": designs.collect::<Vec<_>>(), "unjudged": unjudged::sweep_json(sweep),
            "left_out": unusable.collect::<Vec<_>>()
        })
    });
    json!({ "robot": robot.name, "joints": joints.collect::<Vec<_>>() })
}

/// As rows: every design, then what was left out.
pub fn csv(sweeps: &[JointSweep], order: Order) -> String {
    let header = [
        "joint",
        "motor",
        "gear",
        "ratio",
        "feasible",
        "judged",
        "because",
        "objective",
        "loss_w",
        currents::NAMES[0],
        currents::NAMES[1],
        currents::NAMES[2],
        currents::NAMES[3],
        "reflected_inertia_kgm2",
        "mass_kg",
        "tightest_limit",
        "tightest_margin",
        "not_checked",
        "assumed",
        "s_m_s",
        "s_t_kgm2a2_per_nm2",
        "mass_s_m_kgs",
        "mass_s_t_kg2m2a2_per_nm2",
    ];
    let rows = sweeps.iter().flat_map(|sweep| {
        let designs = ordered(sweep, order).into_iter().map(|d| {
            let e = &d.evaluation;
            let mut row = vec![
                sweep.joint.name.clone(),
                d.motor.id.clone(),
                d.gear.unwrap_or("").into(),
                csv_number(Some(e.ratio)),
            ];
            row.push(e.feasible.to_string());
            row.push(d.unjudged.is_empty().to_string());
            row.push(because(d, sweep.joint));
            let objective = e.objective(&sweep.joint.objective);
            row.extend([objective, Some(e.loss)].map(csv_number));
            row.extend(currents::values(d.motor, e).map(|x| csv_number(Some(x))));
            row.extend([Some(e.reflected_inertia), e.mass].map(csv_number));
            let tightest = e.tightest();
            row.extend([tightest.map_or_else(String::new, |m| m.limit.into()), csv_number(tightest.map(|m| m.margin))]);
            row.extend([unjudged::names(&d.unchecked), unjudged::names(&d.assumed)]);
            row.extend(METRICS.iter().take(4).map(|m| csv_number(m.value(d.motor))));
            row
        });
        let left_out = sweep.unusable.iter().map(|(motor, gear, why)| {
            let mut row = vec![String::new(); header.len()];
            row[0] = sweep.joint.name.clone();
            row[1] = (*motor).to_string();
            row[2] = gear.unwrap_or("").to_string();
            row[4] = "false".into();
            row[6] = why.reason().into();
            row
        });
        designs.chain(left_out).collect::<Vec<_>>()
    });
    super::csv_text(&header, rows)
}
