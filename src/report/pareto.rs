//! Fronts of two quantities.

use super::columns::{self, Entry, State};
use super::reason::reason_text;
use super::table::{Column, Table, paragraph, wrap};
use super::{number, optional, point_ratio, unjudged};
use crate::design::pareto::{Front, FrontPoint};
use crate::requirement::Quantity;

/// The columns of a front, with a gear and the mass where they say something; the front's own are never dropped.
fn headings(front: &Front, geared: bool, with_mass: bool) -> Vec<Column> {
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
            "{}: {} against {}; {} with a feasible design{}, {} on the front",
            front.joint.name,
            a.name(),
            b.name(),
            crate::words::counted(front.motors, "motor"),
            unjudged::counted(front.unjudged.len()),
            crate::words::counted(front.points.len(), "point")
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
                row.extend([point_ratio(p, front), number(p.values[0]), number(p.values[1])]);
                row.extend(with_mass.then(|| optional(p.evaluation.mass)));
                row.push(if p.certified { "exact".into() } else { "not certified".into() });
                row
            });
        let table = Table::new(headings(front, geared, with_mass)).also_in("`--csv`, `--json`").rows(rows);
        if table.is_empty() {
            let left_out = unjudged::left_out(front.rejected.iter().map(|(_, why)| why));
            let which = match (front.unjudged.len(), left_out) {
                (0, 0) => "of the catalogue",
                (0, _) => "that can be checked in full",
                _ => "that can be judged",
            };
            out.push_str(&format!("  no motor {which} can do it\n\n"));
        } else {
            let note = match geared {
                true => "With gears of the catalogue each line is a design of its own.",
                false => "Two lines of one motor are the ends of a run: every ratio between them is on its front.",
            };
            out.push_str(&format!("{}\n{}\n", table.text(), paragraph(note, 0, 0)));
        }
        out.push_str(&beside(front));
    }
    out
}

/// What could not be checked and what was assumed of the front, and who is not on it because it cannot be judged.
fn beside(front: &Front) -> String {
    let lines = unjudged::front_remarks(front).into_iter().map(|line| format!("  {}\n", wrap(&line, 4)));
    let text = lines.collect::<String>() + unjudged::front_text(front).trim_start_matches('\n');
    if text.is_empty() { text } else { text + "\n" }
}

/// As rows: every point, then the motors that cannot be judged and those that cannot do it.
pub fn csv(fronts: &[Front]) -> String {
    let rows = fronts.iter().flat_map(|front| {
        let joint = front.joint;
        let points = front.points.iter().map(|p| Entry::design(joint, State::Candidate, None, p.facts(joint)));
        let apart = front
            .unjudged
            .iter()
            .map(|(motor, why)| Entry::without(joint, State::Unjudged, motor, None, unjudged::sentence(why)));
        let cannot = front
            .rejected
            .iter()
            .map(|(motor, why)| Entry::without(joint, State::Rejected, motor, None, reason_text(why, joint).1));
        points.chain(apart).chain(cannot).collect::<Vec<_>>()
    });
    columns::csv(rows, false)
}
