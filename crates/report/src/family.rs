//! Words for a ratio among the points of a gear family.

use gearwise_model::requirement::{FamilyPlace, Joint};

/// The point of its family that a ratio of a joint is at, or the two that it lies between; `None` where its gear is of none.
pub(super) fn of_ratio(joint: &Joint, ratio: f64) -> Option<String> {
    Some(match joint.family_map()?.place(ratio)? {
        FamilyPlace::At(point) => format!("at a point of its family: {}", point.id),
        FamilyPlace::Between(below, above) => format!(
            "between the points {} and {}: nobody published this gear; it has the efficiency of the worse of the two, and the rest is \
             interpolated",
            below.id, above.id
        ),
    })
}

/// That ratios of a joint may lie between the points of its family.
pub(super) fn note(joint: &Joint) -> Option<String> {
    let map = joint.family_map()?;
    Some(format!("Ratios are at the points of {} and between them: between two nobody published a gear", map.family()))
}

/// The gear of a ratio as a cell of a table: the point that it is at, or both that it lies between.
pub(super) fn cell(joint: &Joint, ratio: f64) -> Option<String> {
    Some(match joint.family_map()?.place(ratio)? {
        FamilyPlace::At(point) => point.id.clone(),
        FamilyPlace::Between(below, above) => format!("between {} and {}", below.id, above.id),
    })
}

/// The point that a ratio is at, where it is at one.
pub(super) fn point(joint: &Joint, ratio: f64) -> Option<&str> {
    match joint.family_map()?.place(ratio)? {
        FamilyPlace::At(point) => Some(&point.id),
        FamilyPlace::Between(..) => None,
    }
}
