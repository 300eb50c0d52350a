//! What is said of a motion that may be larger between its samples than at any of them.

use crate::requirement::{Between, Joint};

/// For people, as a sentence without its full stop; `None` where there is nothing to say.
pub(super) fn words(joint: &Joint) -> Option<String> {
    let share = joint.motion.between.unresolved()?;
    let percent = format!("{:.1} %", 100.0 * share);
    Some(match joint.motion.between {
        Between::Given(_) => format!(
            "Not resolved between samples: the motion gives its own rates, so that limits are kept at its samples \
             alone; by estimate torque, speed or acceleration are up to {percent} larger between two of them"
        ),
        _ => format!(
            "Resolved between samples to {percent} of the largest values only: the motion changes too much from \
             sample to sample"
        ),
    })
}
