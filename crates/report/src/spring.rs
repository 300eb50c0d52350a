//! A parallel spring: what was chosen, and what it saves.

use super::number;
use gearwise_model::requirement::Spring;
use gearwise_select::answer::SpringChoice;

/// What the requirement leaves open.
pub fn asked(spring: &Spring) -> String {
    let [k0, k1] = spring.stiffness.map(number);
    let [q0, q1] = spring.rest_angle.map(|q| number(q.to_degrees()));
    format!(
        "A parallel spring is chosen with the ratio: {k0} to {k1} N*m/rad, at rest between {q0} and {q1} deg; where no ratio can do it, the reasons are those of the spring that comes nearest."
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
