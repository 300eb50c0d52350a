//! What an actuator may weigh.

use super::limit::*;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[Limit {
    name: "actuator_mass",
    unit: "kg",
    formula: "m_motor + m_gear ≤ m",
    safety: false,
    of: Of::Other,
    class: Class::UpperBound,
    depends: Depends::Rating,
    stated: |_, joint| joint.limits.actuator_mass.is_some(),
    key: |_| Some(Key::Joint(&["limits", "actuator_mass"])),
    prepare: |c| match (c.joint.limits.actuator_mass, c.mass_at(1.0)) {
        (None, _) => Prepared::NotAsked,
        (Some(bound), Some(_)) => plain(Demand::Mass, 1.0, bound, "requirement"),
        // What is known is too heavy already.
        (Some(bound), None) if c.known_mass_at(1.0) > bound => plain(Demand::Mass, 1.0, bound, "requirement"),
        (Some(_), None) => Prepared::Unknown(NO_MASS),
    },
}];
