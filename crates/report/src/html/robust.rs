//! The page of designs that keep their limits over all tolerances.

use super::{Page, Part, Section, Table, Verdict, asked, folded, unjudged as apart};
use crate::optimize::{proof, ratio_text};
use crate::reason::reason_text;
use crate::robust::{
    counted_at_worst, keeps_over_tolerances, notes, percent, tolerances_text, unproven_text, without_tolerances,
};
use crate::said::window_texts;
use crate::{counted, design_ratio, number, optimum_ratio, unjudged};
use gearwise_model::requirement::Robot;
use gearwise_select::robust::{RobustDesign, RobustJoint, SAMPLES};

/// The page.
pub fn page(robot: &Robot, joints: &[RobustJoint]) -> Page {
    let without: Vec<&str> =
        joints.iter().filter(|j| j.designs.is_empty()).map(|j| j.nominal.joint.name.as_str()).collect();
    let untold: Vec<&str> = without_tolerances(joints).map(|j| j.nominal.joint.name.as_str()).collect();
    let open: Vec<&str> = joints
        .iter()
        .filter(|j| j.designs.first().is_some_and(|first| !first.unproven.is_empty()))
        .map(|j| j.nominal.joint.name.as_str())
        .collect();
    // A row without tolerances is kept by its printed numbers alone: that is not the same.
    let headline = match (without.as_slice(), untold.as_slice()) {
        ([], _) if !open.is_empty() => format!(
            "Every joint has a design that keeps its limits at every motor that was tried; at {} they are not proven over the \
             tolerances.",
            open.join(", ")
        ),
        ([], []) => "Every joint has a design that keeps all limits over the tolerances of its motor.".into(),
        ([], names) => format!(
            "Every joint has a design, but the first of {} has no tolerances in the catalogue: it keeps its limits by its \
             printed numbers alone.",
            names.join(", ")
        ),
        (names, _) => format!("No design keeps all limits over its tolerances at: {}.", names.join(", ")),
    };
    let mut warnings = Vec::new();
    for joint in joints {
        let said = notes(joint, joint.designs.len()).into_iter();
        warnings.extend(said.map(|(note, places)| {
            let more = if places.len() > 4 { format!(" … ({} designs)", places.len()) } else { String::new() };
            format!("{}: {}{more}: {note}", joint.nominal.joint.name, places[..places.len().min(4)].join(" "))
        }));
    }
    let mut of_robot = asked::of_robot(robot);
    of_robot.push(Part::Text(
        "All limits are to be kept over the tolerances of the motors: by every motor whose numbers are within them."
            .into(),
    ));
    Page {
        command: "optimize --robust",
        title: robot.name.clone(),
        verdict: Verdict::from(keeps_over_tolerances(joints)),
        asked: of_robot,
        headline,
        summary: vec![Part::Table(choices(joints))],
        sections: joints.iter().map(section).collect(),
        warnings,
        ..Page::default()
    }
}

/// The first of each joint, by the printed numbers and over the tolerances.
fn choices(joints: &[RobustJoint]) -> Table {
    let header =
        ["joint", ">×", "first by printed numbers", ">N*", "first over tolerances", ">N", "its tolerances", ">lost"];
    let mut table = Table::new("First choices", &header);
    for joint in joints {
        let nominal = joint.nominal.candidates.first();
        let first = joint.designs.first();
        let mut cells = vec![joint.nominal.joint.name.clone(), joint.nominal.joint.count.to_string()];
        cells.push(nominal.map_or_else(|| "none".into(), |d| d.motor.id.clone()));
        cells.push(nominal.map_or_else(String::new, design_ratio));
        cells.push(first.map_or_else(|| "none".into(), |d| d.nominal.motor.id.clone()));
        cells.push(first.map_or_else(String::new, |d| optimum_ratio(&d.optimum, d.gear)));
        cells.push(first.map_or_else(String::new, tolerances));
        cells.push(joint.lost.len().to_string());
        table.push(first.map_or("", |d| d.nominal.motor.id.as_str()), cells);
    }
    table
}

fn section(result: &RobustJoint) -> Section {
    let joint = result.nominal.joint;
    let mut parts = vec![Part::Text(format!(
        "{}, {}: {} can do it by the printed numbers{}; {}.",
        ratio_text(joint),
        joint.aim(),
        counted(result.nominal.candidates.len(), "motor"),
        unjudged::counted(result.nominal.unjudged.len()),
        counted_at_worst(result)
    ))];
    parts.extend(designs(result).part());
    let mut lost = Table::new(format!("{}: lost to their tolerances", joint.name), &["motor", ">N*", "because"]);
    for of in &result.lost {
        let motor = &of.nominal.motor.id;
        let cells = vec![motor.clone(), design_ratio(&of.nominal), reason_text(&of.reason, joint).1];
        lost.push(motor, cells);
    }
    let count = lost.rows.len();
    parts.extend(folded(&format!("Lost to their tolerances ({count})"), lost.part()));
    let mut chances = Table::new(
        format!(
            "{}: the first of the nominal order with their numbers drawn at random, {SAMPLES} times (each ± is two standard \
             deviations; what has no ± stays)",
            joint.name
        ),
        &["motor", ">keeps limits at N*", ">is first", ">keeps limits at N robust", ">is first then"],
    );
    for c in &result.contenders {
        let mut cells = vec![c.motor.id.clone(), percent(c.feasible_nominal), percent(c.first_nominal)];
        cells.push(c.feasible_robust.map_or_else(|| "–".into(), percent));
        cells.push(percent(c.first_robust));
        chances.push(&c.motor.id, cells);
    }
    parts.extend(chances.part());
    parts.extend(apart::of_joint(&joint.name, &result.nominal));
    Section::new(joint.name.clone(), parts)
}

/// The tolerances of a design, in a column that says that they are.
fn tolerances(design: &RobustDesign) -> String {
    if design.toleranced.is_empty() { "none in the catalogue".into() } else { tolerances_text(&design.toleranced) }
}

fn designs(result: &RobustJoint) -> Table {
    let joint = result.nominal.joint;
    let unit = match joint.objective.unit() {
        "1" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let (goal, worst) = (format!(">{}{unit}", joint.goal()), format!(">at worst{unit}"));
    let header = [
        ">#",
        "motor",
        "gear",
        ">N*",
        ">N robust",
        &goal,
        &worst,
        "tolerances",
        "tightest at worst",
        ">margin [%]",
        "estimated",
        ">not checked",
        "proof",
        "feasible at worst",
    ];
    let mut table = Table::new(format!("{}: designs, the best first", joint.name), &header);
    for (place, d) in result.designs.iter().enumerate() {
        let bare = d.toleranced.is_empty();
        let mut cells = vec![(place + 1).to_string(), d.nominal.motor.id.clone(), d.gear.unwrap_or("").into()];
        cells.extend([design_ratio(&d.nominal), optimum_ratio(&d.optimum, d.gear)]);
        cells.push(number(d.optimum.objective));
        cells.push(if bare { "–".into() } else { number(d.worst_objective) });
        cells.push(tolerances(d));
        let tightest = d.tightest.as_ref().filter(|_| !bare);
        cells.push(tightest.map_or_else(|| "–".into(), |m| m.limit.into()));
        cells.push(tightest.map_or_else(|| "–".into(), |m| number((1000.0 * m.margin.max(0.0)).round() / 10.0)));
        cells.extend([super::estimated(d.nominal.motor), d.unchecked.len().to_string()]);
        cells.push(unproven_text(d).unwrap_or_else(|| proof(&d.optimum.certificate)));
        let is_told = !bare && d.gear.is_none();
        cells.push(if is_told { window_texts(&d.optimum, joint).join("; ") } else { String::new() });
        table.push(&d.nominal.motor.id, cells);
    }
    table.mainly(13)
}
