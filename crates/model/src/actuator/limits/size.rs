//! How large an actuator may be, what it may cost and how long one may wait for it: limits on all of its parts.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::actuator::parts::Whole;

/// Seconds of a day: lead times are compared in days.
const DAY: f64 = 86_400.0;

/// By so much more than the limit (relative) the known part of a number has to be, for the whole to be certainly more.
const CERTAINLY: f64 = 1e-8;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "outer_diameter",
        unit: "m",
        formula: "max(D_motor, D_gear) ≤ D, or D_module",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.outer_diameter.is_some(),
        key: |_| Some(Key::Joint(&["limits", "outer_diameter"])),
        prepare: |c| on_parts(c, "outer_diameter", c.joint.limits.outer_diameter, Some(c.outer_diameter()), 1.0),
    },
    Limit {
        name: "axial_length",
        unit: "m",
        formula: "l_motor + l_gear ≤ l, side by side max(l_motor, l_gear); or l_module",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.axial_length.is_some(),
        key: |_| Some(Key::Joint(&["limits", "axial_length"])),
        prepare: |c| on_parts(c, "axial_length", c.joint.limits.axial_length, Some(c.axial_length()), 1.0),
    },
    Limit {
        name: "price",
        unit: MONEY,
        formula: "price of motor + price of gear ≤ price, or of the module; at the rates of [prices]",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.price.is_some(),
        key: |_| Some(Key::Joint(&["limits", "price"])),
        prepare: |c| on_parts(c, "price", c.joint.limits.price, c.price().map(|cost| cost.whole), 1.0),
    },
    Limit {
        name: "lead_time",
        unit: "d",
        formula: "longest lead time of motor and gear ≤ lead time, or that of the module",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.lead_time.is_some(),
        key: |_| Some(Key::Joint(&["limits", "lead_time"])),
        prepare: |c| on_parts(c, "lead_time", c.joint.limits.lead_time, Some(c.lead_time()), 1.0 / DAY),
    },
];

/// Names of the limits on parts.
pub(super) fn is_on_parts(name: &str) -> bool {
    LIMITS.iter().any(|limit| limit.name == name)
}

/// A limit on a number of all parts. Where a part is not known, what is known may already be too much; else it is not judged.
fn on_parts(c: &Candidate, name: &str, bound: Option<f64>, whole: Option<Whole>, factor: f64) -> Prepared {
    let (Some(bound), Some(whole)) = (bound, whole) else { return Prepared::NotAsked };
    let kept = bound * c.joint.limits.left_of(name);
    match whole.missing {
        Some(why) if whole.known <= kept * (1.0 + CERTAINLY) => Prepared::Unknown(why),
        _ => plain(Demand::Parts(whole), factor, bound * factor, "requirement"),
    }
}
