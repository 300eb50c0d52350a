//! What a balanced objective is balanced from: three designs next to each other.

use super::table::{Column, Table, paragraph};
use super::{design_ratio, number, number_between, optional};
use gearwise_model::requirement::{Balance, Balancing, Extreme, Joint, Quantity};
use gearwise_select::answer::JointResult;

/// How the objective came about, in a sentence.
pub fn sentence(balance: &Balance) -> String {
    format!(
        "Balanced: the least loss/{} W + mass/{} kg, the geometric means of the lightest design and of that with the least loss.",
        number(balance.loss),
        number(balance.mass)
    )
}

/// That the objective could not be balanced, and why.
pub(super) fn cannot(why: &str) -> String {
    format!("No objective is stated, and it cannot be balanced: {why}. The least loss counts.")
}

/// The three designs of a joint: their cells (name, motor, N, loss, mass), and the gear where there is one.
pub fn rows(result: &JointResult, balance: &Balance) -> Vec<(Vec<String>, Option<String>)> {
    let row = |name: &str, motor: &str, gear: Option<&str>, ratio: String, numbers: [Option<f64>; 2]| {
        let cells = numbers.map(optional);
        let first = vec![name.to_string(), motor.to_string(), ratio];
        ([first, cells.to_vec()].concat(), gear.map(|gear| format!("with {gear}")))
    };
    let end = |name: &str, of: &Extreme| {
        let (min, max) = of.window;
        let ratio = if of.gear.is_some() { number(of.ratio) } else { number_between(of.ratio, min, max) };
        row(name, &of.motor, of.gear.as_deref(), ratio, [Some(of.loss), Some(of.mass)])
    };
    let first = result.candidates.first().map(|d| {
        let e = &d.evaluation;
        row("balanced", &d.motor.id, d.gear, design_ratio(d), [Some(e.loss), e.mass])
    });
    let ends = (end("lightest", &balance.lightest), end("least loss", &balance.least_loss));
    [Some(ends.0), first, Some(ends.1)].into_iter().flatten().collect()
}

/// The same as sentences, for a page.
pub fn sentences(result: &JointResult) -> Vec<String> {
    match &result.joint.balancing {
        Balancing::Made(balance) => {
            let line = |(row, gear): (Vec<String>, Option<String>)| {
                let gear = gear.map_or_else(String::new, |gear| format!(" {gear}"));
                format!("{}: {}{gear} at N = {}, {} W, {} kg", row[0], row[1], row[2], row[3], row[4])
            };
            std::iter::once(sentence(balance)).chain(rows(result, balance).into_iter().map(line)).collect()
        }
        Balancing::Cannot(why) => {
            vec![cannot(why)]
        }
        Balancing::No | Balancing::Asked => Vec::new(),
    }
}

/// Headings of [`rows`].
pub fn columns() -> Vec<Column> {
    vec![
        Column::name("choice"),
        Column::name("motor"),
        Column::number("N", ""),
        Column::number("loss", "W"),
        Column::number("mass", "kg"),
    ]
}

/// The three designs of a joint, or why there are none.
pub fn text(result: &JointResult) -> String {
    match &result.joint.balancing {
        Balancing::Made(balance) => {
            let mut table = Table::new(columns()).indented(2);
            for (row, gear) in rows(result, balance) {
                table.push(row, gear.into_iter().collect());
            }
            let mut out = paragraph(&sentence(balance), 2, 4);
            out.push_str(&no_limit(result));
            out + "\n" + &table.text()
        }
        Balancing::Cannot(why) => paragraph(&cannot(why), 2, 4),
        Balancing::No | Balancing::Asked => String::new(),
    }
}

/// That nothing holds the least loss back, where nothing does.
pub(super) fn no_limit(result: &JointResult) -> String {
    if is_unlimited(result.joint) { paragraph(NO_LIMIT, 2, 4) } else { String::new() }
}

/// Whether the least loss is asked for, and no limit on mass or inertia holds it back.
pub(super) fn is_unlimited(joint: &Joint) -> bool {
    let limits = &joint.limits;
    let is_held = limits.actuator_mass.is_some() || limits.reflected_inertia.is_some();
    !is_held && joint.objective.weight(Quantity::Loss) > 0.0
}

/// What is said where nothing holds the least loss back.
pub(super) const NO_LIMIT: &str =
    "No limit on mass or inertia is stated: nothing keeps the least loss from a large motor.";
