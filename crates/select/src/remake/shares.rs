//! What each part of what was fitted does to the choice: the fitted motor without it, chosen again.
//!
//! The one idea: a part is taken away from the fitted motor alone, all others stay. What then changes is that part's share;
//! shares of parts that act together need not add up, and are not said to.

use super::Chosen;
use crate::answer::Reason;
use crate::best::best_design;
use crate::mount::Site;
use gearwise_model::actuator::estimate::completed;
use gearwise_model::catalog::{Motor, fitted::FittedGear};
use gearwise_model::effects::FittedEffect;

/// A part of what was fitted.
#[derive(Debug, Clone, PartialEq)]
pub enum Part {
    /// An effect; of several orders one.
    Effect(FittedEffect),
    /// Friction as it was measured; without it the drag of the declared row counts, all of it as Coulomb friction.
    Friction,
    /// What was found of the gear.
    Gear,
    /// Numbers of the row that were fitted again.
    Numbers,
}

/// What a part moves.
#[derive(Debug, Clone)]
pub struct Share {
    /// The part.
    pub part: Part,
    /// The fitted motor without it: the best design, or why there is none.
    pub without: Result<Chosen, Reason>,
}

/// What each part of a fitted motor moves at a site; numbers, and friction beside effects, are told apart from those of the declared
/// row where the catalogue has it.
pub(super) fn shares(site: Site, declared: Option<&Motor>, fitted: &Motor) -> Vec<Share> {
    let share = |(part, motor): (Part, Motor)| {
        let motor = completed(motor);
        let found = best_design(site, &motor, false);
        Share { part, without: found.map(|design| Chosen::new(&design)).map_err(|refused| refused.reason()) }
    };
    parts(declared, fitted).into_iter().map(share).collect()
}

/// Each part with the motor without it.
fn parts(declared: Option<&Motor>, fitted: &Motor) -> Vec<(Part, Motor)> {
    let without = |k: usize| {
        let others = fitted.effects.iter().enumerate().filter(|(other, _)| *other != k);
        Motor { effects: others.map(|(_, effect)| effect.clone()).collect(), ..fitted.clone() }
    };
    let mut parts: Vec<(Part, Motor)> =
        (0..fitted.effects.len()).map(|k| (Part::Effect(fitted.effects[k].clone()), without(k))).collect();
    if let Some(declared) = declared {
        let friction = |motor: &Motor| (motor.coulomb_friction, motor.viscous_friction);
        if friction(fitted) != friction(declared) {
            // Beside effects no drag by a no-load current counts: it is put in as what it may be at most.
            let by_no_load = declared.no_load_torque.filter(|_| friction(declared) == (None, None));
            let (coulomb_friction, viscous_friction) =
                (declared.coulomb_friction.or(by_no_load), declared.viscous_friction);
            parts.push((Part::Friction, Motor { coulomb_friction, viscous_friction, ..fitted.clone() }));
        }
    }
    let says = |gear: &FittedGear| gear.efficiency.or(gear.backdrive_efficiency).or(gear.inertia).is_some();
    if fitted.fitted_gear.as_ref().is_some_and(says) {
        let bare = |gear: &FittedGear| FittedGear { ratio: gear.ratio, ..FittedGear::default() };
        let fitted_gear = fitted.fitted_gear.as_ref().map(bare);
        parts.push((Part::Gear, Motor { fitted_gear, ..fitted.clone() }));
    }
    if let Some(declared) = declared
        && numbers(declared) != numbers(fitted)
    {
        let row = Motor {
            coulomb_friction: fitted.coulomb_friction,
            viscous_friction: fitted.viscous_friction,
            effects: fitted.effects.clone(),
            fitted_gear: fitted.fitted_gear,
            ..declared.clone()
        };
        parts.push((Part::Numbers, row));
    }
    parts
}

/// The numbers of a row that logs fit again.
fn numbers(motor: &Motor) -> [Option<f64>; 5] {
    let Motor { resistance, torque_constant, back_emf_constant, .. } = *motor;
    [Some(resistance), Some(torque_constant), Some(back_emf_constant), motor.inductance, motor.rotor_inertia]
}
