//! The table of what cannot be judged, the same on every page.

use super::{Part, Table};
use crate::unjudged::{class, sentence};
use gearwise_model::actuator::limits::Remark;
use gearwise_select::answer::JointResult;

/// The motors of a joint that cannot be judged, folded.
pub(super) fn of_joint(names: &str, result: &JointResult) -> Option<Part> {
    folded(names, result.unjudged.iter().map(|u| (u.motor.id.as_str(), u.gear, u.because.as_slice())))
}

/// Motors (with their gears) that cannot be judged, folded; nothing where there are none.
pub(super) fn folded<'m>(
    names: &str,
    all: impl Iterator<Item = (&'m str, Option<&'m str>, &'m [Remark])>,
) -> Option<Part> {
    let name = format!("{names}: what the requirement asks for cannot be judged, so none of these is a choice");
    let mut table = Table::new(name, &["motor", "gear", "because", "in short"]);
    for (motor, gear, because) in all {
        table.push(motor, vec![motor.into(), gear.unwrap_or("").into(), sentence(because), class(because)]);
    }
    let count = table.rows.len();
    table.part().map(|part| Part::Folded(format!("Cannot be judged ({count})"), Box::new(part)))
}
