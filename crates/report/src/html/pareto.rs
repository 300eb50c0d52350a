//! The page of the fronts of quantities.

use super::{Page, Part, Section, Table, Verdict};
use crate::pareto::{best_of, listed, motors, proofs};
use crate::plot::{Figure, pareto as plot};
use crate::{number, optional, point_ratio, unjudged};
use gearwise_model::requirement::Robot;
use gearwise_select::pareto::Front;

/// The page.
pub fn page(robot: &Robot, fronts: &[Front]) -> Page {
    let without: Vec<&str> = fronts.iter().filter(|f| f.points.is_empty()).map(|f| f.joint.name.as_str()).collect();
    let quantities = fronts.first().map_or_else(String::new, |f| match f.quantities.as_slice() {
        [a, b] => format!("{} against {}", a.name(), b.name()),
        all => listed(all),
    });
    let another = if fronts.first().is_some_and(|f| f.quantities.len() > 2) { "another" } else { "the other" };
    let headline = match without.as_slice() {
        [] => format!(
            "Every joint has a front of {quantities}: no point on it can be better in one without being worse in {another}."
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

/// The ends of each front: the best point in each quantity.
fn ends(fronts: &[Front]) -> Table {
    let mut headings: Vec<String> = ["joint", "best in", "motor", ">N"].map(String::from).into();
    let quantities = fronts.first().map_or(&[][..], |front| &front.quantities);
    headings.extend(quantities.iter().map(|q| format!(">{} [{}]", q.name(), q.unit())));
    headings.push(">motors on the front".into());
    let mut table = Table::new("The ends of each front", &headings);
    for front in fronts {
        let on_front = motors(front).len();
        for (k, quantity) in front.quantities.iter().enumerate() {
            let Some(point) = best_of(front.points.iter(), k) else { continue };
            let mut cells = vec![front.joint.name.clone(), quantity.name().into(), point.motor.id.clone()];
            cells.push(point_ratio(point, front));
            cells.extend(point.values.iter().map(|value| number(*value)));
            cells.push(on_front.to_string());
            table.push(&point.motor.id, cells);
        }
    }
    table
}

fn section(front: &Front, figure: &Figure, k: usize) -> Section {
    let apart = unjudged::counted(front.unjudged.len());
    let points = front.points.len();
    let (motors, points) =
        (gearwise_model::words::counted(front.motors, "motor"), gearwise_model::words::counted(points, "point"));
    let text = format!("{motors} with a feasible design{apart}, {points} on the front.");
    let mut parts = vec![Part::Text(text)];
    parts.extend(plot::of_joint(figure, front, k).map(Part::Figure));
    parts.extend(proofs(front).into_iter().map(Part::Text));
    let mut header: Vec<String> = ["motor", "gear", ">N"].map(String::from).into();
    header.extend(front.quantities.iter().map(|q| format!(">{} [{}]", q.name(), q.unit())));
    header.extend([">mass [kg]", "proof", ">not checked"].map(String::from));
    let mut table = Table::new(format!("{}: points on the front", front.joint.name), &header);
    for p in &front.points {
        let proof = if p.certified { "exact" } else { "not certified" };
        let mut cells = vec![p.motor.id.clone(), p.gear.unwrap_or("").into()];
        cells.push(point_ratio(p, front));
        cells.extend(p.values.iter().map(|value| number(*value)));
        cells.extend([optional(p.evaluation.mass), proof.into(), p.unchecked.len().to_string()]);
        table.push(&p.motor.id, cells);
    }
    parts.extend(table.part());
    let apart = front.unjudged.iter().map(|(motor, because)| (motor.id.as_str(), None, because.as_slice()));
    parts.extend(super::unjudged::folded(&front.joint.name, apart));
    Section::new(front.joint.name.clone(), parts)
}
