//! Up to what drag a motor is ahead of another design: where nobody says its drag, or where a sheet leaves open what of its
//! no-load torque is Coulomb friction.
//!
//! The one idea: more drag is more loss, so where a design leads at no drag there is one at which it no longer does; it is
//! found by bisection, the ratio chosen again each time. Along a no-load torque that may be Coulomb or viscous friction the loss
//! need not rise; there it is looked at first, and nothing is said where it turns.

use rayon::prelude::*;

use super::best::best_design;
use super::mount::Site;
use gearwise_model::catalog::Motor;
use gearwise_model::catalog::drag::Drag;
use gearwise_model::catalog::estimate::Estimated;
use gearwise_model::requirement::{MotorDrag, Quantity};

/// The drag at which a motor falls behind.
#[derive(Debug, Clone, PartialEq)]
pub struct BreakEven {
    /// Whom it falls behind.
    pub other: String,
    /// Whether the other's own drag is estimated, and counted at the end of its estimate.
    pub other_is_estimated: bool,
    /// Whether only two ends are known of the other's drag, and it is counted at the worse one.
    pub other_is_open: bool,
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
    if !drag_counts(site) || !matches!(motor.drag(), Drag::Unknown | Drag::Estimated { .. }) {
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
    Some(BreakEven {
        other: other.id.clone(),
        other_is_estimated,
        other_is_open: no_load(other).is_some(),
        torque: low,
        current: Some(low / per_ampere),
    })
}

/// Whether the objective has the motor's drag in it, and no spring is chosen.
fn drag_counts(site: Site) -> bool {
    let counts = [Quantity::Loss, Quantity::Energy].iter().any(|q| site.joint.objective.weight(*q) > 0.0);
    counts && site.joint.limits.spring.is_none()
}

/// What of a no-load torque the order of two designs depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct OpenOrder {
    /// Whom the first is ahead of.
    pub other: String,
    /// Whether the no-load torque is the first's own; else it is the other's.
    pub of_first: bool,
    /// The no-load torque \[N·m\].
    pub torque: f64,
    /// Up to this share of it, or from this share on, may be Coulomb friction: the rest is viscous.
    pub share: f64,
    /// Whether the share is the most with which the first is ahead; else it is the least.
    pub at_most: bool,
}

/// Shares of a no-load torque at which it is looked whether the objective turns.
const LOOKS: u32 = 8;
/// Objectives that differ by less than this are one (relative): what a solution for the ratio leaves.
const SAME: f64 = 1e-6;

/// No-load torque \[N·m\] and speed \[rad/s\] of a motor of which nobody says what part of the torque is Coulomb friction.
fn no_load(motor: &Motor) -> Option<(f64, f64)> {
    match motor.drag() {
        Drag::NoLoad { torque, speed: Some(speed) } if torque > 0.0 => Some((torque, speed)),
        _ => None,
    }
}

/// The objective of a motor over the share of its no-load torque that is Coulomb friction.
struct Along<'s, 'a, 'd> {
    site: Site<'a, 'd>,
    motor: &'s Motor,
    torque: f64,
    speed: f64,
}

impl<'s, 'a, 'd> Along<'s, 'a, 'd> {
    fn new(site: Site<'a, 'd>, motor: &'s Motor) -> Option<Along<'s, 'a, 'd>> {
        let (torque, speed) = no_load(motor)?;
        Some(Along { site, motor, torque, speed })
    }

    /// The best objective with a share; `None` where the motor is no choice then.
    fn at(&self, share: f64) -> Option<f64> {
        let known = Motor {
            coulomb_friction: Some(share * self.torque),
            viscous_friction: Some((1.0 - share) * self.torque / self.speed),
            ..self.motor.clone()
        };
        best_design(self.site, &known, false).ok().map(|design| design.optimum.objective)
    }

    /// Its least, which is at an end, and whether it rises with the share; `None` where it turns on the way or is not known
    /// everywhere.
    fn least(&self) -> Option<(f64, bool)> {
        let share = |k: u32| f64::from(k) / f64::from(LOOKS);
        let values: Option<Vec<f64>> = (0..=LOOKS).into_par_iter().map(|k| self.at(share(k))).collect();
        let values = values?;
        let (first, last) = (values[0], values[values.len() - 1]);
        let slack = SAME * first.abs().max(last.abs());
        let rises = |w: &[f64]| w[1] >= w[0] - slack;
        let falls = |w: &[f64]| w[1] <= w[0] + slack;
        match last >= first {
            true => values.windows(2).all(rises).then_some((first, true)),
            false => values.windows(2).all(falls).then_some((last, false)),
        }
    }

    /// The shares between which the objective comes to a value that lies between those of both ends.
    fn share_at(&self, value: f64, rises: bool) -> Option<[f64; 2]> {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if (self.at(middle)? < value) == rises { low = middle } else { high = middle }
        }
        Some([low, high])
    }
}

/// What the order of the first two designs depends on where their sheets leave open what of a no-load torque is Coulomb friction;
/// `objective` is what the first reaches at the worse end. It is the share of the first's own no-load torque with which it is ahead
/// wherever the other's lies, and where there is none that of the other's with the first at its worse end. `None` where the
/// order does not depend on it, and where an objective turns between the ends.
pub fn open_order(site: Site, first: &Motor, other: &Motor, objective: f64) -> Option<OpenOrder> {
    if !drag_counts(site) || site.joint.motor_drag == MotorDrag::Off {
        return None;
    }
    // Of one whose drag is estimated or not known, that is said.
    let known = |motor: &Motor| !matches!(motor.drag(), Drag::Unknown | Drag::Estimated { .. });
    // The first leads with each at its worse end: only what is open of the other may change that.
    let others = Along::new(site, other).filter(|_| known(first))?;
    let behind = |value: f64| value < objective * (1.0 - SAME);
    if ![0.0, 1.0].into_iter().filter_map(|share| others.at(share)).any(behind) {
        return None;
    }
    let (least, others_rises) = others.least()?;
    let order = |along: &Along, of_first: bool, share: f64, at_most: bool| OpenOrder {
        other: other.id.clone(),
        of_first,
        torque: along.torque,
        share,
        at_most,
    };
    if let Some(own) = Along::new(site, first) {
        let (own_least, rises) = own.least()?;
        if own.at(if rises { 1.0 } else { 0.0 })? < least * (1.0 - SAME) {
            return None;
        }
        if own_least < least * (1.0 - SAME) {
            let [below, above] = own.share_at(least, rises)?;
            return Some(order(&own, true, if rises { below } else { above }, rises));
        }
    }
    // Where the other's loss rises with the share, the first is ahead from a share on.
    let [below, above] = others.share_at(objective, others_rises)?;
    Some(order(&others, false, if others_rises { above } else { below }, !others_rises))
}
