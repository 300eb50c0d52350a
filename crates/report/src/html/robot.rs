//! The choice for a whole robot, as tables.

use super::{Chain, Part, Row, Table, estimated, folded, tightest};
use crate::robot::{
    aim, change_lines, differences, kept, name, no_combination, open, per_mass, proof, sag_text, sums, unit,
    wanting_lines,
};
use crate::{columns, number, optional, unjudged};
use gearwise_select::robot::{Choice, Combination};

/// What is minimised and kept, the best combination joint by joint, the next best, and what other budgets would give.
pub(super) fn parts(choice: &Choice) -> Vec<Part> {
    let mut parts = vec![Part::Text(format!("The whole robot: {}. It keeps: {}.", aim(choice), kept(choice)))];
    let Some(best) = choice.combinations.first() else {
        parts.push(Part::Text(no_combination(choice).into()));
        parts.push(Part::List(wanting_lines(choice)));
        parts.extend(apart(choice));
        return parts;
    };
    parts.push(Part::Chain(Chain::of(choice, best)));
    parts.push(Part::Table(designs(choice, best)));
    parts.push(Part::Text(format!("Together: {}. {}.", sums(choice, best), capital(&proof(choice)))));
    parts.extend(open(choice, None).iter().map(|line| Part::Text(format!("{}.", capital(line)))));
    parts.extend(best.sag.iter().map(|sag| Part::Text(format!("{}.", capital(&sag_text(choice.robot, sag))))));
    if let Some(price) = best.power_price.filter(|p| *p < 0.0) {
        let worth = format!("{} {}", number(-price), unit(choice));
        parts.push(Part::Text(format!("The bus binds: one watt more is worth {}.", worth.trim_end())));
    }
    parts.extend(per_mass(choice, best).map(|line| Part::Text(format!("{}.", capital(&line)))));
    parts.extend(next_best(choice, best).part());
    if !choice.changes.is_empty() {
        parts.push(Part::Text("What the budgets cost:".into()));
        parts.push(Part::List(change_lines(choice, best)));
    }
    if choice.others_left_out {
        parts.push(Part::Text("Not all other budgets were looked at: that would take long.".into()));
    }
    parts.extend(folded("Less mass costs", front(choice, best).part()));
    parts.extend(apart(choice));
    parts
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().into_iter().flat_map(char::to_uppercase).chain(letters).collect()
}

fn designs(choice: &Choice, best: &Combination) -> Table {
    let figures: Vec<String> = columns::of_pages(true, None);
    let mut header = vec!["joint", ">×", "motor", "gear", ">N"];
    header.extend(figures.iter().map(String::as_str));
    header.extend(["tightest", ">margin [%]", "estimated", ">not checked"]);
    let mut table = Table::new("The best combination", &header);
    for (joint, design) in choice.robot.joints.iter().zip(&best.joints) {
        let facts = design.facts();
        let mut cells = vec![joint.name.clone(), joint.count.to_string(), design.motor.id.clone()];
        cells.extend([design.gear.unwrap_or("").into(), number(facts.evaluation.ratio)]);
        cells.extend(columns::cells_of_pages(true, &facts));
        cells.extend(tightest(facts.evaluation));
        cells.extend([estimated(design.motor), design.unchecked.len().to_string()]);
        table.push(&design.motor.id, cells);
    }
    table
}

/// Further combinations, each with another motor somewhere.
fn next_best(choice: &Choice, best: &Combination) -> Table {
    let total = format!(">{} [{}]", choice.total.name, choice.total.unit);
    let power = if choice.instant_by_instant { ">power at the worst instant [W]" } else { ">sum of peak powers [W]" };
    let header = [">#", total.as_str(), ">mass [kg]", ">different motors", power, "against the best"];
    let mut table = Table::new("The best, and the next best with another motor somewhere", &header);
    for (place, of) in choice.combinations.iter().enumerate() {
        let mut cells = vec![(place + 1).to_string(), number(of.objective), optional(of.mass)];
        cells.extend([of.distinct_motors.to_string(), number(of.peak_power)]);
        cells.push(if place == 0 { "–".into() } else { differences(choice.robot, best, of) });
        table.rows.push(Row { cells, ..Row::default() });
    }
    if choice.combinations.len() > 1 { table } else { Table::default() }
}

/// The best for each mass, other budgets kept.
fn front(choice: &Choice, best: &Combination) -> Table {
    let total = format!(">{} [{}]", choice.total.name, choice.total.unit);
    let header = [">mass [kg]", total.as_str(), ">joints that differ", "against the choice"];
    let rows = choice.front.iter().map(|of| {
        let differ = best.joints.iter().zip(&of.joints).filter(|(a, b)| name(a) != name(b)).count();
        let against = differences(choice.robot, best, of);
        vec![optional(of.mass), number(of.objective), differ.to_string(), against]
    });
    let table = Table::new("The best for each mass, other budgets kept", &header).rows(rows);
    if choice.front.len() > 1 { table } else { Table::default() }
}

/// What cannot be judged at which joint.
fn apart(choice: &Choice) -> Option<Part> {
    let mut table = Table::new("Cannot be judged, so no choice there", &["joint", "motor", "because"]);
    for of in &choice.unjudged {
        table.push(&of.motor.id, vec![of.joint.name.clone(), of.motor.id.clone(), unjudged::sentence(&of.because)]);
    }
    let count = table.rows.len();
    folded(&format!("Cannot be judged in the search over the whole robot ({count})"), table.part())
}
