//! Fronts of two quantities.

use serde_json::{Value, json};

use super::table::{Column, Table, paragraph};
use super::{csv_number, number, optional};
use crate::design::pareto::{Front, FrontPoint};
use crate::requirement::Quantity;

/// The columns of a front, with a gear and the mass where they say something; the front's own are never dropped.
fn columns(front: &Front, geared: bool, with_mass: bool) -> Vec<Column> {
    let mut columns = vec![Column::name("motor")];
    columns.extend(geared.then(|| Column::name("gear")));
    columns.push(Column::number("N", ""));
    columns.extend(front.quantities.map(|q| Column::number(q.name(), q.unit())));
    columns.extend(with_mass.then(|| Column::number("mass", "kg").dropped(1)));
    columns.push(Column::name("proof").dropped(2));
    columns
}

/// For people: each run of ratios of one motor as its first and last point.
pub fn text(fronts: &[Front]) -> String {
    let mut out = String::new();
    for front in fronts {
        let [a, b] = front.quantities;
        let heading = format!(
            "{}: {} against {}; {} motors have a feasible design, {} points on the front",
            front.joint.name,
            a.name(),
            b.name(),
            front.motors,
            front.points.len()
        );
        out.push_str(&format!("{}\n", paragraph(&heading, 0, 2)));
        let geared = front.points.iter().any(|p| p.gear.is_some());
        let with_mass = !front.quantities.contains(&Quantity::Mass);
        let rows = front
            .points
            .iter()
            .enumerate()
            .filter(|(i, p)| {
                let same =
                    |other: Option<&FrontPoint>| other.is_some_and(|o| o.motor.id == p.motor.id && o.gear == p.gear);
                // Inside a run of one motor only the ends are shown.
                !(same(i.checked_sub(1).and_then(|j| front.points.get(j))) && same(front.points.get(i + 1)))
            })
            .map(|(_, p)| {
                let mut row = vec![p.motor.id.clone()];
                if geared {
                    row.push(p.gear.unwrap_or("").into());
                }
                row.extend([number(p.evaluation.ratio), number(p.values[0]), number(p.values[1])]);
                row.extend(with_mass.then(|| optional(p.evaluation.mass)));
                row.push(if p.certified { "exact".into() } else { "not certified".into() });
                row
            });
        let table = Table::new(columns(front, geared, with_mass)).also_in("`--csv`, `--json`").rows(rows);
        if table.is_empty() {
            out.push_str("  no motor of the catalogue can do it\n\n");
        } else {
            let note = "Two lines of one motor are the ends of a run: every ratio between them is on its front.";
            out.push_str(&format!("{}\n{}\n", table.text(), paragraph(note, 0, 0)));
        }
    }
    out
}

/// For programs: every point.
pub fn json(fronts: &[Front]) -> Value {
    let joints = fronts.iter().map(|front| {
        let [a, b] = front.quantities;
        json!({
            "joint": front.joint.name,
            "quantities": [{ "name": a.name(), "unit": a.unit() }, { "name": b.name(), "unit": b.unit() }],
            "points": front.points.iter().map(|p| json!({
                "motor": p.motor.id, "gear": p.gear, "ratio": p.evaluation.ratio, a.name(): p.values[0], b.name(): p.values[1],
                "loss_w": p.evaluation.loss, "reflected_inertia_kgm2": p.evaluation.reflected_inertia, "mass_kg": p.evaluation.mass,
                "certified": p.certified,
            })).collect::<Vec<_>>(),
        })
    });
    json!({ "joints": joints.collect::<Vec<_>>() })
}

/// As rows: every point.
pub fn csv(fronts: &[Front]) -> String {
    let columns = fronts
        .first()
        .map_or([String::new(), String::new()], |f| f.quantities.map(|q| format!("{} [{}]", q.name(), q.unit())));
    let rows = fronts.iter().flat_map(|front| {
        front.points.iter().map(|p| {
            let mut row = vec![front.joint.name.clone(), p.motor.id.clone(), p.gear.unwrap_or("").into()];
            row.extend(
                [Some(p.evaluation.ratio), Some(p.values[0]), Some(p.values[1]), p.evaluation.mass].map(csv_number),
            );
            row.push(p.certified.to_string());
            row
        })
    });
    super::csv_text(&["joint", "motor", "gear", "ratio", &columns[0], &columns[1], "mass [kg]", "certified"], rows)
}
