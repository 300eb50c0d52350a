//! What a gear may carry, how fast and how long, and what a requirement wants of it.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::catalog::GearKind;
use crate::numerics::laurent::Laurent;

/// How long a gear lasts: its demand rises with the cube of the load.
pub const GEAR_LIFE: &str = "gear_life";

/// Seconds of an hour: lives are compared in hours.
const HOUR: f64 = 3600.0;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "gear_input_speed",
        unit: "rad/s",
        formula: "N max |ω| ≤ ω_gear",
        safety: false,
        of: Of::Gear,
        class: Class::UpperBound,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.max_input_speed),
        key: |_| Some(Key::Joint(&["gear", "max_input_speed"])),
        prepare: |c| match c.gear.max_input_speed {
            Some(bound) => {
                let (speed, sample) = c.load.peak_speed;
                plain(Demand::Polynomial(Laurent::monomial(speed, 1), Some(sample)), 1.0, bound, "gear")
            }
            None if c.gear_is_published() => Prepared::Unknown("the gear's maximum input speed is not known"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_peak_torque",
        unit: "N*m",
        formula: "safety · max |τ| ≤ τ_gear peak",
        safety: true,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.peak_torque),
        key: |_| Some(Key::Joint(&["gear", "peak_torque"])),
        prepare: |c| match c.gear.peak_torque {
            Some(bound) => {
                let (torque, sample) = c.load.peak_torque;
                plain(Demand::Fixed(torque, Some(sample)), c.joint.limits.safety, bound, "gear")
            }
            None if c.gear_is_published() => Prepared::Unknown("the gear's peak torque is not known"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_continuous_torque",
        unit: "N*m",
        formula: "√mean(τ²) ≤ τ_gear continuous",
        safety: false,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.continuous_torque),
        key: |_| Some(Key::Joint(&["gear", "continuous_torque"])),
        prepare: |c| match c.gear.continuous_torque {
            // Then the average torque is the limit, and this one the torque of the rated life.
            _ if c.gear.ratings.average_replaces_continuous() => Prepared::NotAsked,
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some(bound) => plain(Demand::Fixed(c.load.rms_torque, None), 1.0, bound, "gear"),
            None if c.gear_is_published() => Prepared::Unknown("the gear's continuous torque is not known"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_average_torque",
        unit: "N*m",
        formula: "∛(mean(|ω||τ|³)/mean|ω|) ≤ τ_gear average",
        safety: false,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.ratings.average_torque),
        key: |_| Some(Key::Joint(&["gear", "average_torque"])),
        prepare: |c| match c.gear.ratings.average_torque {
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some(bound) => plain(Demand::AverageTorque(c.load.average_torque()), 1.0, bound, "gear"),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_momentary_torque",
        unit: "N*m",
        formula: "safety · τ_shock ≤ τ_gear momentary peak, behind a transmission τ_shock/min |r|",
        safety: true,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.shock_torque.is_some(),
        key: |_| Some(Key::Joint(&["limits", "shock_torque"])),
        prepare: |c| match (shock(c), c.gear.ratings.momentary_peak_torque) {
            (None, _) => Prepared::NotAsked,
            (Some(shock), Some(bound)) => plain(Demand::Constant(shock), c.joint.limits.safety, bound, "gear"),
            (Some(_), None) => Prepared::Unknown("the gear's momentary peak torque is not known"),
        },
    },
    Limit {
        name: "gear_ratcheting_torque",
        unit: "N*m",
        formula: "safety · max(τ_shock, max |τ|) ≤ τ_gear ratcheting",
        safety: true,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| {
            joint.limits.shock_torque.is_some() || described(joint, joint.gear.ratings.ratcheting_torque)
        },
        key: |_| Some(Key::Joint(&["gear", "ratcheting_torque"])),
        prepare: |c| match (shock(c), c.gear.ratings.ratcheting_torque) {
            (shock, Some(bound)) => {
                let (torque, sample) = c.load.peak_torque;
                let demand = match shock {
                    Some(shock) if shock >= torque => Demand::Constant(shock),
                    _ => Demand::Fixed(torque, Some(sample)),
                };
                plain(demand, c.joint.limits.safety, bound, "gear")
            }
            // Teeth that skip are those of a flexible spline.
            (Some(_), None) if c.catalog_gear.is_some_and(|gear| gear.kind == GearKind::StrainWave) => {
                Prepared::Unknown("the gear's ratcheting torque is not known")
            }
            (_, None) => Prepared::NotAsked,
        },
    },
    Limit {
        name: "gear_average_speed",
        unit: "rad/s",
        formula: "N mean|ω| ≤ ω_gear average, the mean over the time that is not at standstill",
        safety: false,
        of: Of::Gear,
        class: Class::UpperBound,
        depends: Depends::Rating,
        stated: |_, joint| described(joint, joint.gear.ratings.average_input_speed),
        key: |_| Some(Key::Joint(&["gear", "average_input_speed"])),
        prepare: |c| match c.gear.ratings.average_input_speed {
            Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            Some(bound) => {
                plain(Demand::Polynomial(Laurent::monomial(c.load.running_speed(), 1), None), 1.0, bound, "gear")
            }
            // Without a maximum input speed either, that is reported once. A row without ratings of a duty cycle prints one limit for both.
            None if c.gear_is_published() && c.gear.max_input_speed.is_some() && is_rated_for_duty(c) => {
                Prepared::AtRatio(average_speed)
            }
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: GEAR_LIFE,
        unit: "h",
        formula: "L · N mean(|ω||τ|³)/(ω_rated τ_gear continuous³) ≤ L10 of the gear: as many hours at its rated point",
        safety: false,
        of: Of::Gear,
        class: Class::UpperBound,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.life.is_some(),
        key: |_| Some(Key::Joint(&["limits", "life"])),
        prepare: |c| match (c.joint.limits.life, c.gear.ratings.rated(c.gear.continuous_torque)) {
            (None, _) => Prepared::NotAsked,
            _ if c.joint.limits.spring.is_some() => {
                Prepared::Unknown("a life and a spring that is to be chosen are not judged together")
            }
            _ if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            (_, Err(why)) => Prepared::Unknown(why),
            (Some(life), Ok(rated)) => {
                let wear = life * c.load.mean_wear / (rated.speed * rated.torque.powi(3));
                let demand = Demand::Polynomial(Laurent::monomial(wear, 1), None);
                plain(demand, 1.0 / HOUR, rated.life / HOUR, "gear")
            }
        },
    },
    Limit {
        name: "gear_backlash",
        unit: "rad",
        formula: "backlash of the gear ≤ largest that is allowed, behind a transmission over min |r| and with its own",
        safety: false,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.max_backlash.is_some(),
        key: |_| Some(Key::Joint(&["limits", "max_backlash"])),
        prepare: |c| {
            let Some(bound) = c.joint.limits.max_backlash else { return Prepared::NotAsked };
            let transmission = c.joint.passed.as_deref();
            let own = transmission.map_or(Some(0.0), |passed| passed.numbers.backlash);
            let of_gear =
                c.gear.backlash.map(|backlash| backlash * transmission.map_or(1.0, |passed| passed.levers.angle));
            let known = own.unwrap_or(0.0) + of_gear.unwrap_or(0.0);
            match (of_gear, own) {
                (Some(_), Some(_)) => plain(Demand::Constant(known), 1.0, bound, "requirement"),
                // What is known is too much already.
                _ if known > bound => plain(Demand::Constant(known), 1.0, bound, "requirement"),
                (None, _) => Prepared::Unknown("the gear's backlash is not known"),
                (_, None) => Prepared::Unknown("the transmission's backlash is not known"),
            }
        },
    },
    Limit {
        name: "gear_stiffness",
        unit: "N*m/rad",
        formula: "smallest stiffness that is asked for ≤ stiffness of the gear, behind a transmission min r² times that, in series with its own",
        safety: false,
        of: Of::Gear,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: |_, joint| joint.limits.min_stiffness.is_some(),
        key: |_| Some(Key::Joint(&["limits", "min_stiffness"])),
        prepare: |c| {
            let Some(asked) = c.joint.limits.min_stiffness else { return Prepared::NotAsked };
            let transmission = c.joint.passed.as_deref();
            let own = transmission.map_or(Some(f64::INFINITY), |passed| passed.numbers.stiffness);
            let of_gear = c.gear.stiffness.map(|k| k * transmission.map_or(1.0, |passed| passed.levers.stiffness));
            let series = 1.0 / (of_gear.map_or(0.0, f64::recip) + own.map_or(0.0, f64::recip));
            let owner = if transmission.is_some() { "gear and transmission" } else { "gear" };
            match (of_gear, own) {
                (Some(_), Some(_)) => plain(Demand::Constant(asked), 1.0, series, owner),
                // What is known gives way too much already.
                _ if series < asked => plain(Demand::Constant(asked), 1.0, series, owner),
                (None, _) => Prepared::Unknown("the gear's stiffness is not known"),
                (_, None) => Prepared::Unknown("the transmission's stiffness is not known"),
            }
        },
    },
    Limit {
        name: "backdriving_torque",
        unit: "N*m",
        formula: "N (c + c_g)/η_b ≤ τ_backdriving, with the T_b of the gear for its part where it is printed; behind a transmission times max |r|/η_tb",
        safety: false,
        of: Of::Gear,
        class: Class::UpperBound,
        depends: Depends::Anyhow,
        stated: |_, joint| joint.limits.max_backdriving_torque.is_some(),
        key: |_| Some(Key::Joint(&["limits", "max_backdriving_torque"])),
        prepare: |c| match c.joint.limits.max_backdriving_torque {
            Some(bound) => match backdriving(c) {
                Ok(demand) => plain(demand, 1.0, bound, "requirement"),
                Err(why) => Prepared::Unknown(why),
            },
            None => Prepared::NotAsked,
        },
    },
];

/// True if the gear's row has ratings of a duty cycle, as sheets of strain wave gears do.
fn is_rated_for_duty(candidate: &Candidate) -> bool {
    let ratings = &candidate.gear.ratings;
    ratings.average_torque.is_some() || ratings.rated_speed.is_some()
}

/// Judge the average input speed of a gear without a limit on it: the speed that its rated life is stated at is known to be sustained.
fn average_speed(candidate: &Candidate, ratio: f64) -> Verdict {
    if candidate.is_evaluated() {
        return candidate.at_ratio(ratio, |here| average_speed(here, ratio));
    }
    let kept = candidate.joint.limits.left_of("gear_average_speed");
    let sustained = candidate.gear.ratings.rated_speed.unwrap_or(0.0) * kept;
    match candidate.load.has_durations && ratio * candidate.load.running_speed() <= sustained {
        true => Verdict::Kept,
        false => {
            Verdict::Unknown("the gear's average input speed limit is not known; its maximum input speed is checked")
        }
    }
}

/// The torque of a shock as it arrives at the gear \[N·m\].
fn shock(c: &Candidate) -> Option<f64> {
    let arrives = c.joint.passed.as_deref().map_or(1.0, |passed| passed.levers.torque);
    c.joint.limits.shock_torque.map(|shock| shock * arrives)
}

/// The torque at the output that sets motor and gear going without current, from rest \[N·m\] at a ratio; `None` where it is not
/// known, infinite where the gear locks.
pub fn backdriving_torque(c: &Candidate, ratio: f64) -> Option<f64> {
    match backdriving(c).ok()? {
        Demand::Polynomial(torque, _) => Some(torque.at(ratio)),
        Demand::Constant(torque) => Some(torque),
        _ => None,
    }
}

/// The torque at the output that sets motor and gear going without current, from rest.
///
/// # Errors
/// What of it is not known.
fn backdriving(c: &Candidate) -> Result<Demand, &'static str> {
    if c.drag_is_off() {
        return Err("`motor_drag` is off, and the motor's drag is part of it");
    }
    if c.drag_is_unknown() {
        return Err("the motor's drag is not known");
    }
    let motor = c.friction_at_rest();
    let efficiency = c.gear.backdrive_efficiency;
    let (per_ratio, of_gear) = match (c.gear.backdriving_torque, c.gear.friction_at_rest) {
        (Some(printed), _) => (motor, printed),
        (None, Some(gear)) => (motor + gear, 0.0),
        (None, None) => return Err("neither starting nor backdriving torque of the gear is known"),
    };
    let (most, passes) = c
        .joint
        .passed
        .as_deref()
        .map_or((1.0, 1.0), |passed| (passed.levers.backdriving, passed.numbers.backdrive_efficiency));
    match efficiency > 0.0 && passes > 0.0 {
        true => {
            let terms = Laurent::monomial(per_ratio / efficiency, 1) + Laurent::constant(of_gear);
            Ok(Demand::Polynomial(terms * (most / passes), None))
        }
        // Whatever the torque, a gear that locks does not move.
        false => Ok(Demand::Constant(f64::INFINITY)),
    }
}
