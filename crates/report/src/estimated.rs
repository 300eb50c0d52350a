//! What of a motor is estimated, in words.

use gearwise_model::catalog::Motor;

/// What of a motor is estimated, to go on a sentence.
pub(super) fn text(motor: &Motor) -> String {
    let each: Vec<String> = motor
        .estimates
        .iter()
        .map(|e| format!("{} at most {}", e.of.words(), super::with_unit(e.value, e.of.unit())))
        .collect();
    if each.is_empty() { String::new() } else { format!("; estimated: {}", each.join(", ")) }
}
