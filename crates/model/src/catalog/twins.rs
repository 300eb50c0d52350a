//! Rows that look like one motor under two names.

use std::collections::HashMap;

use super::finding::Beside;
use super::motor::Motor;
use super::row::States;
use super::sheet::FIELDS;

/// Code of the finding.
pub const CODE: &str = "same-motor";

/// What two rows of one motor may differ by where both print a number: rounding of sheets.
const ROUNDING: f64 = 0.01;

/// Fewest numbers beyond R and K_T that two rows have to share.
const FEWEST: usize = 1;

/// Rows of which an earlier one has the same name or the same numbers, and no `same_as` says how the two belong together; and rows
/// that say `same_as` of a motor that is plainly another.
pub fn twins(motors: &[Motor]) -> Vec<Beside> {
    let rows: Vec<(&Motor, Option<String>)> =
        motors.iter().filter(|m| m.inside.is_none()).map(|m| (m, named(m))).collect();
    let of = |(k, row): (usize, &(&Motor, Option<String>))| {
        let alike =
            |other: &&(&Motor, Option<String>)| looks_like(row, other).filter(|_| !are_said(row.0, other.0)).is_some();
        let other = rows[..k].iter().find(alike)?;
        Some(Beside {
            id: row.0.id.clone(),
            code: CODE,
            message: format!("{}: it looks like `{}`", looks_like(row, other)?, other.0.id),
            explanation: "one motor: name the row that counts in `same_as`, so that it counts once in a choice; variants: say in `note` what differs",
        })
    };
    let by_id: HashMap<&str, &Motor> = motors.iter().rev().map(|m| (m.id.as_str(), m)).collect();
    let wrong = rows.iter().filter_map(|(row, _)| {
        let other = by_id.get(row.about.same_as.as_str()).filter(|_| !row.about.same_as.is_empty())?;
        Some(Beside {
            id: row.id.clone(),
            code: CODE,
            message: format!("`same_as` names `{}`, but {}", other.id, differs(row, other)?),
            explanation: "the row fills what the other lacks: if it is another motor, leave `same_as` blank",
        })
    });
    rows.iter().enumerate().filter_map(of).chain(wrong).collect()
}

/// What no two readings of one motor differ by.
fn differs(a: &Motor, b: &Motor) -> Option<String> {
    if a.conventions.commutation != b.conventions.commutation {
        return Some("one is brushed and the other is not".into());
    }
    let share = |a: f64, b: f64| (a / b).max(b / a);
    let numbers = [
        ("mass", a.mass, b.mass, 1.2),
        ("outer diameter", a.sheet.outer_diameter.map(|p| p.value), b.sheet.outer_diameter.map(|p| p.value), 1.1),
        ("K_M", Some(a.motor_constant()), Some(b.motor_constant()), 1.5),
    ];
    numbers.iter().find_map(|(what, a, b, most)| {
        let share = share((*a)?, (*b)?);
        (share > *most).then(|| format!("their {what} differs by a factor {}", crate::words::number(share)))
    })
}

/// Whether rows say of each other that they are one motor.
fn are_said(a: &Motor, b: &Motor) -> bool {
    let (of_a, of_b) = (&a.about.same_as, &b.about.same_as);
    *of_a == b.id || *of_b == a.id || (!of_a.is_empty() && of_a == of_b)
}

/// What two rows share, where it is more than chance.
fn looks_like((a, name): &(&Motor, Option<String>), (b, other): &(&Motor, Option<String>)) -> Option<String> {
    if name.is_some() && name == other {
        return Some(format!("maker and model are those of another row, {} {}", b.manufacturer, b.model));
    }
    let near = |a: f64, b: f64| (a - b).abs() <= ROUNDING * a.abs().max(b.abs());
    if !near(a.resistance, b.resistance) || !near(a.torque_constant, b.torque_constant) {
        return None;
    }
    let mut shared = 0;
    // What states a convention is compared on the q axis, above; the rest says the same in any row.
    for field in FIELDS.iter().filter(|f| f.states == States::Nothing) {
        let (Some(of_a), Some(of_b)) = ((field.get)(&a.sheet), (field.get)(&b.sheet)) else { continue };
        if !near(of_a.value, of_b.value) {
            return None;
        }
        shared += 1;
    }
    (shared >= FEWEST)
        .then(|| format!("R, K_T and all that both rows give ({shared} more numbers) are those of another row"))
}

/// Maker and model without signs, spaces and what stands in parentheses; nothing of rows without a model.
fn named(motor: &Motor) -> Option<String> {
    let plain = |text: &str| {
        let before = text.split('(').next().unwrap_or_default();
        before.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect::<String>()
    };
    let model = plain(&motor.model);
    (!model.is_empty()).then(|| format!("{} {model}", plain(&motor.manufacturer)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;

    #[test]
    fn one_motor_under_two_names_is_named_and_variants_are_not() {
        let shipped = Catalog::builtin().unwrap();
        let row = shipped.motor("maxon-ec-i-40-496660").unwrap();
        let with = |id: &str, change: &dyn Fn(&mut Motor)| {
            let mut motor = Motor { id: id.into(), model: format!("another {id}"), ..row.clone() };
            change(&mut motor);
            motor
        };
        let found = |rows: Vec<Motor>| twins(&rows).iter().map(|b| b.id.clone()).collect::<Vec<_>>();
        let mass = |share: f64| {
            move |m: &mut Motor| {
                m.sheet.mass = m.sheet.mass.map(|p| crate::catalog::Printed { value: share * p.value, ..p })
            }
        };
        // The same numbers under another name; and after the digits that sheets round to.
        assert_eq!(found(vec![row.clone(), with("b", &|_| ()), with("c", &mass(1.004))]), ["b", "c"]);
        // A variant with another mass, another winding; a row that says what it is.
        assert!(found(vec![row.clone(), with("b", &mass(1.05))]).is_empty());
        assert!(found(vec![row.clone(), with("b", &|m| m.torque_constant *= 2.0)]).is_empty());
        assert!(found(vec![row.clone(), with("b", &|m| m.about.same_as = row.id.clone())]).is_empty());
        // Another reading of the same type.
        let read =
            |m: &mut Motor| (m.resistance, m.model) = (1.5 * row.resistance, format!("{} (read again)", row.model));
        assert_eq!(found(vec![row.clone(), with("b", &read)]), ["b"]);
        // A row that names another motor as its own.
        let else_where = |m: &mut Motor| (m.about.same_as, m.mass) = (row.id.clone(), m.mass.map(|mass| 2.0 * mass));
        assert_eq!(found(vec![row.clone(), with("b", &else_where)]), ["b"]);
        // What is shipped has none that is not said.
        assert!(twins(&shipped.motors).is_empty(), "{:?}", twins(&shipped.motors));
    }
}
