//! Up to what drag a motor whose drag nobody says is ahead of another design.
//!
//! The one idea: more drag is more loss, so where a design leads at no drag there is one at which it no longer does; it is
//! found by bisection, the ratio chosen anew each time.

use super::best::best_design;
use super::mount::Site;
use crate::catalog::Motor;
use crate::catalog::drag::Drag;
use crate::catalog::estimate::Estimated;
use crate::requirement::Quantity;

/// The drag at which a motor falls behind.
#[derive(Debug, Clone, PartialEq)]
pub struct BreakEven {
    /// Whom it falls behind.
    pub other: String,
    /// Whether the other's own drag is estimated, and counted at the end of its estimate.
    pub other_is_estimated: bool,
    /// The drag \[N·m\], all of it Coulomb friction.
    pub torque: f64,
    /// The no-load current that this is, in the convention of the motor's sheet \[A\].
    pub current: Option<f64>,
}

/// Halvings of the drag that is looked for: to a thousandth.
const HALVINGS: usize = 10;
/// A drag beyond this many times that of motors built alike is not looked for.
const MOST: f64 = 64.0;
/// Drag of most brushless motors over their motor constant \[√W\]: where the search begins.
const USUAL: f64 = 0.1;

/// Up to what drag a motor is ahead of an objective that another reaches; `None` where its drag is known, where it is behind
/// without any, or ahead with any.
pub fn break_even(site: Site, motor: &Motor, other: &Motor, objective: f64) -> Option<BreakEven> {
    let counts = [Quantity::Loss, Quantity::Energy].iter().any(|q| site.joint.objective.weight(*q) > 0.0);
    if !counts || !matches!(motor.drag(), Drag::Unknown | Drag::Estimated { .. }) || site.joint.limits.spring.is_some()
    {
        return None;
    }
    let with = |torque: f64| {
        let mut known = Motor { no_load_torque: Some(torque), ..motor.clone() };
        known.sheet.no_load_speed = None;
        known.estimates.retain(|estimate| estimate.of != Estimated::Drag);
        best_design(site, &known, false).is_ok_and(|design| design.optimum.objective < objective)
    };
    let start = USUAL * motor.torque_constant / motor.resistance.sqrt();
    let mut low = start * 1e-3;
    if !with(low) {
        return None;
    }
    let mut high = start;
    while with(high) {
        low = high;
        high *= 2.0;
        if high > MOST * start {
            return None;
        }
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if with(middle) { low = middle } else { high = middle }
    }
    let other_is_estimated = other.is_estimated(Estimated::Drag);
    let conventions = &motor.conventions;
    let per_ampere = motor.torque_constant * conventions.current.torque_current(conventions.commutation);
    Some(BreakEven { other: other.id.clone(), other_is_estimated, torque: low, current: Some(low / per_ampere) })
}
