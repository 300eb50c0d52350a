//! A parallel spring: what was chosen, and what it saves.

use serde_json::{Value, json};

use super::{csv_number, number};
use crate::design::spring::SpringChoice;
use crate::requirement::Spring;

/// What the requirement leaves open.
pub fn asked(spring: &Spring) -> String {
    let [k0, k1] = spring.stiffness.map(number);
    let [q0, q1] = spring.rest_angle.map(|q| number(q.to_degrees()));
    format!(
        "A parallel spring is chosen with the ratio: {k0} to {k1} N*m/rad, at rest between {q0} and {q1} deg; what no ratio can do is said of the spring that comes nearest."
    )
}

/// What was chosen and what it is worth, for people.
pub fn text(spring: &SpringChoice, loss: f64) -> String {
    let worth = match (&spring.without, spring.saving(loss)) {
        (None, _) => "without a spring no ratio is feasible".to_string(),
        (Some(_), None) => "without a spring there is no loss either".to_string(),
        (Some(without), Some(saving)) => format!(
            "loss {} W without it at N = {} ({} %)",
            number(without.loss),
            number(without.ratio),
            number((-1000.0 * saving).round() / 10.0)
        ),
    };
    let chosen = match spring.rest_angle {
        Some(rest) => {
            format!("spring {} N*m/rad at rest at {} deg", number(spring.stiffness), number(rest.to_degrees()))
        }
        None => "no spring is best".into(),
    };
    let least = if spring.least_stiffness { ", the least stiffness of several that are as good" } else { "" };
    format!("{chosen}{least}; {worth}")
}

/// For programs.
pub fn json(spring: &SpringChoice, loss: f64) -> Value {
    json!({
        "stiffness_nm_per_rad": spring.stiffness,
        "rest_angle_rad": spring.rest_angle,
        "least_stiffness": spring.least_stiffness,
        "lower_bound": spring.lower_bound,
        "gap": spring.gap,
        "feasible_without": spring.without.is_some(),
        "ratio_without": spring.without.map(|w| w.ratio),
        "objective_without": spring.without.map(|w| w.objective),
        "loss_without_w": spring.without.map(|w| w.loss),
        "loss_saved": spring.saving(loss),
    })
}

/// Columns of [`csv()`].
pub const COLUMNS: [&str; 5] = [
    "stiffness_nm_per_rad",
    "rest_angle_rad",
    "loss_without_spring_w",
    "objective_without_spring",
    "loss_saved_by_spring",
];

/// Cells of a row; blank without a spring.
pub fn csv(spring: Option<&SpringChoice>, loss: f64) -> [String; 5] {
    let without = spring.and_then(|s| s.without);
    [
        csv_number(spring.map(|s| s.stiffness)),
        csv_number(spring.and_then(|s| s.rest_angle)),
        csv_number(without.map(|w| w.loss)),
        csv_number(without.map(|w| w.objective)),
        csv_number(spring.and_then(|s| s.saving(loss))),
    ]
}
