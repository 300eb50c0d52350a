//! The page of the fronts of two quantities.

use super::{Page, Part, Section, Table, Verdict};
use crate::design::pareto::Front;
use crate::report::plot::{Figure, pareto as plot};
use crate::report::{number, optional, point_ratio, unjudged};
use crate::requirement::{Quantity, Robot};

/// The page.
pub fn page(robot: &Robot, fronts: &[Front]) -> Page {
    let without: Vec<&str> = fronts.iter().filter(|f| f.points.is_empty()).map(|f| f.joint.name.as_str()).collect();
    let quantities = fronts.first().map_or_else(String::new, |f| f.quantities.map(Quantity::name).join(" against "));
    let headline = match without.as_slice() {
        [] => format!(
            "Every joint has a front of {quantities}: no point on it can be better in one without being worse in the other."
        ),
        _ => {
            let without = fronts.iter().filter(|f| f.points.is_empty());
            let told = without.map(|f| unjudged::Without {
                joint: &f.joint.name,
                unjudged: f.unjudged.len(),
                unchecked: unjudged::left_out(f.rejected.iter().map(|(_, why)| why)),
            });
            unjudged::without_choice(told, "No").join(". ") + "."
        }
    };
    let warnings = fronts
        .iter()
        .flat_map(|f| unjudged::front_remarks(f).into_iter().map(|line| format!("{}: {line}", f.joint.name)));
    let figure = plot::figure(fronts);
    Page {
        command: "optimize --pareto",
        title: format!("{}: {quantities}", robot.name),
        verdict: Verdict::from(without.is_empty()),
        asked: super::asked::of_robot(robot),
        headline,
        summary: vec![Part::Table(ends(fronts))],
        sections: fronts.iter().enumerate().map(|(k, front)| section(front, &figure, k)).collect(),
        warnings: warnings.collect(),
        ..Page::default()
    }
}

/// The two ends of each front.
fn ends(fronts: &[Front]) -> Table {
    let mut table = Table::new(
        "The ends of each front",
        &["joint", "best in", "motor", ">N", ">first quantity", ">second quantity", ">motors on the front"],
    );
    for front in fronts {
        let mut motors: Vec<&str> = front.points.iter().map(|p| p.motor.id.as_str()).collect();
        motors.sort_unstable();
        motors.dedup();
        let units = front.quantities.map(Quantity::unit);
        let both = [(front.points.first(), 0), (front.points.last(), 1)];
        for (point, which) in both.into_iter().filter_map(|(p, which)| Some((p?, which))) {
            let shown = |k: usize| format!("{} {}", number(point.values[k]), units[k]);
            let cells = vec![
                front.joint.name.clone(),
                front.quantities[which].name().into(),
                point.motor.id.clone(),
                point_ratio(point, front),
                shown(0),
                shown(1),
                motors.len().to_string(),
            ];
            table.push(&point.motor.id, cells);
        }
    }
    table
}

fn section(front: &Front, figure: &Figure, k: usize) -> Section {
    let [a, b] = front.quantities;
    let apart = unjudged::counted(front.unjudged.len());
    let points = front.points.len();
    let (motors, points) = (crate::words::counted(front.motors, "motor"), crate::words::counted(points, "point"));
    let text = format!("{motors} with a feasible design{apart}, {points} on the front.");
    let mut parts = vec![Part::Text(text)];
    parts.extend(super::panel_of(figure, 0, k));
    let header = [
        "motor",
        "gear",
        ">N",
        &format!(">{} [{}]", a.name(), a.unit()),
        &format!(">{} [{}]", b.name(), b.unit()),
        ">mass [kg]",
        "proof",
        ">not checked",
    ];
    let mut table = Table::new(format!("{}: points on the front", front.joint.name), &header);
    for p in &front.points {
        let proof = if p.certified { "exact" } else { "not certified" };
        let mut cells = vec![p.motor.id.clone(), p.gear.unwrap_or("").into()];
        cells.push(point_ratio(p, front));
        cells.extend(p.values.map(number));
        cells.extend([optional(p.evaluation.mass), proof.into(), p.unchecked.len().to_string()]);
        table.push(&p.motor.id, cells);
    }
    parts.extend(table.part());
    let apart = front.unjudged.iter().map(|(motor, because)| (motor.id.as_str(), None, because.as_slice()));
    parts.extend(super::unjudged::folded(&front.joint.name, apart));
    Section::new(front.joint.name.clone(), parts)
}
