//! How large a motor may be. Gears of the catalogue say no size: these are limits of the motor alone.

use super::limit::*;
use crate::catalog::Printed;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "outer_diameter",
        unit: "m",
        formula: "D_motor ≤ D",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.outer_diameter.is_some(),
        key: |_| Some(Key::Joint(&["limits", "outer_diameter"])),
        prepare: |c| {
            let why = "the motor's outer diameter is not known";
            size(c.joint.limits.outer_diameter, c.motor.sheet.outer_diameter, why)
        },
    },
    Limit {
        name: "axial_length",
        unit: "m",
        formula: "l_motor ≤ l",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.axial_length.is_some(),
        key: |_| Some(Key::Joint(&["limits", "axial_length"])),
        prepare: |c| size(c.joint.limits.axial_length, c.motor.sheet.length, "the motor's axial length is not known"),
    },
];

fn size(bound: Option<f64>, size: Option<Printed>, unknown: &'static str) -> Prepared {
    match (bound, size) {
        (None, _) => Prepared::NotAsked,
        (Some(bound), Some(size)) => plain(Demand::Constant(size.value), 1.0, bound, "requirement"),
        (Some(_), None) => Prepared::Unknown(unknown),
    }
}
