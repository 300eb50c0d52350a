//! The page of a sweep.

use super::{Page, Part, Row, Section, Table, Verdict, group_of};
use crate::plot::sweep as plot;
use crate::sweep::{Order, because, ordered, remarks};
use crate::{columns, number, optional};
use gearwise_model::requirement::Robot;
use gearwise_select::answer::{JointSweep, SweptDesign};

/// The page.
pub fn page(robot: &Robot, sweeps: &[JointSweep], order: Order) -> Page {
    let feasible = |s: &JointSweep| s.designs.iter().filter(|d| d.is_choice()).count();
    let without: Vec<&str> = sweeps.iter().filter(|s| feasible(s) == 0).map(|s| s.joint.name.as_str()).collect();
    let total: usize = sweeps.iter().map(|s| s.designs.len()).sum();
    let can: usize = sweeps.iter().map(feasible).sum();
    let headline = match without.as_slice() {
        [] => format!("{can} of {total} designs are feasible; every joint has at least one."),
        names => {
            let unknown = sweeps.iter().any(|s| feasible(s) == 0 && s.designs.iter().any(|d| d.is_unjudged()));
            let which = if unknown { " that can be judged" } else { "" };
            format!("No design of these ratios{which} is feasible for: {}.", names.join(", "))
        }
    };
    let mut best = Table::new(
        "The first of each joint",
        &["joint", ">designs", ">feasible", "motor", "gear", ">N", ">loss [W]", ">J [kg*m^2]", ">mass [kg]"],
    );
    for sweep in sweeps {
        let first = ordered(sweep, order).into_iter().find(|d| d.is_choice());
        let mut cells = vec![sweep.joint.name.clone(), sweep.designs.len().to_string(), feasible(sweep).to_string()];
        cells.extend(first.map_or_else(
            || ["none", "", "", "", "", ""].map(String::from),
            |d| {
                let e = &d.evaluation;
                let gear = d.gear.unwrap_or("").to_string();
                [
                    d.motor.id.clone(),
                    gear,
                    number(e.ratio),
                    number(e.loss),
                    number(e.reflected_inertia),
                    optional(e.mass),
                ]
            },
        ));
        best.push(first.map_or("", |d| &d.motor.id), cells);
    }
    let figure = plot::figure(sweeps);
    let section = |(k, sweep): (usize, &JointSweep)| {
        let apart = sweep.designs.iter().filter(|d| d.is_unjudged());
        let mut apart: Vec<_> = apart.map(|d| (d.motor.id.as_str(), d.gear, &*d.unjudged)).collect();
        apart.dedup();
        let parts = group_of(&figure, k).into_iter().chain(designs(sweep, order).part());
        let parts = parts.chain(super::unjudged::folded(&sweep.joint.name, apart.into_iter()));
        Section::new(sweep.joint.name.clone(), parts.collect())
    };
    Page {
        command: "sweep",
        title: robot.name.clone(),
        verdict: Verdict::from(without.is_empty()),
        asked: super::asked::of_robot(robot),
        headline,
        summary: vec![Part::Table(best)],
        sections: sweeps.iter().enumerate().map(section).collect(),
        warnings: sweeps
            .iter()
            .flat_map(|s| remarks(s).into_iter().map(|line| format!("{}: {line}", s.joint.name)))
            .collect(),
        ..Page::default()
    }
}

fn state(design: &SweptDesign) -> &'static str {
    match (design.evaluation.feasible, design.is_choice()) {
        (false, _) => "no",
        (true, true) => "yes",
        (true, false) => "cannot be judged",
    }
}

fn designs(sweep: &JointSweep, order: Order) -> Table {
    let joint = sweep.joint;
    let geared = sweep.designs.iter().any(|d| d.gear.is_some());
    let goal = match joint.objective.unit() {
        "1" => format!(">{}", joint.goal()),
        unit => format!(">{} [{unit}]", joint.goal()),
    };
    // A single quantity is a figure like any other.
    let own_column = joint.objective.sole().is_none();
    let mut header = vec!["motor"];
    header.extend(geared.then_some("gear"));
    header.extend([">N", "feasible"]);
    header.extend(own_column.then_some(goal.as_str()));
    let currency = sweep.designs.first().and_then(|design| design.evaluation.price).map(|cost| cost.currency);
    let figures = [true, false].map(|at_once| columns::of_pages(at_once, currency));
    header.extend(figures[0].iter().map(String::as_str));
    header.extend(["tightest", ">margin [%]", "because"]);
    let main = header.len();
    header.extend(figures[1].iter().map(String::as_str));
    let mut table = Table::new(format!("{}: every design", joint.name), &header).mainly(main);
    for design in ordered(sweep, order) {
        let e = &design.evaluation;
        let mut cells = vec![design.motor.id.clone()];
        cells.extend(geared.then(|| design.gear.unwrap_or("").to_string()));
        cells.extend([number(e.ratio), state(design).into()]);
        cells.extend(own_column.then(|| optional(e.objective(&joint.objective))));
        cells.extend(columns::cells_of_pages(true, &design.facts(joint)));
        let tightest = e.tightest();
        cells.push(tightest.map_or_else(|| "–".into(), |m| m.limit.into()));
        cells.push(tightest.map_or_else(|| "–".into(), |m| number((1000.0 * m.margin).round() / 10.0)));
        cells.push(because(design, joint));
        cells.extend(columns::cells_of_pages(false, &design.facts(joint)));
        table.rows.push(Row { id: design.motor.id.clone(), cells, faint: !design.is_choice() });
    }
    table
}
