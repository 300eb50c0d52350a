//! How warm the winding may get: in steady state, over the motion, and at standstill.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::actuator::thermal_motion::TwoNode;
use crate::actuator::{stretch, thermal};
use crate::catalog::convention::Commutation;

/// Holding at standstill, as a limit and as what is to be said of it beside.
pub(super) const STANDSTILL: &str = "standstill_holding";

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "winding_temperature",
        unit: "A",
        formula: "√mean(T²)/K_T ≤ √((T_max − T_ambient)/(R_th R(T_max))): steady state, hot copper",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        depends: Depends::Current,
        stated: a_temperature,
        key: by_temperature,
        prepare: |c| match (c.thermal_current(), c.winding_temperature()) {
            // Even from cold a winding is not cooler than its surroundings.
            (_, limit) if c.load.starts_cold() && limit.is_none_or(|(kelvin, _)| kelvin > c.robot.ambient) => {
                Prepared::NotAsked
            }
            (Some(_), _) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
            (Some((bound, owner)), _) => heating(c, 0.0, bound, owner),
            (None, Some(_)) => Prepared::Unknown("the motor's thermal resistances are not known"),
            (None, None) if c.motor.thermal_resistance.is_some() => {
                Prepared::Unknown("no highest winding temperature is known")
            }
            (None, None) => Prepared::NotAsked,
        },
    },
    Limit {
        name: "winding_peak_temperature",
        unit: "K",
        formula: "max T_winding − T_ambient ≤ T_max − T_ambient over the motion: two nodes, hot copper, periodic state or from cold",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Temperature,
        stated: a_temperature,
        key: by_temperature,
        prepare: |c| match (c.two_node(), c.winding_temperature()) {
            (Some(node), Some((limit, owner))) if c.load.has_course() => {
                plain(Demand::WindingPeak(node), 1.0, (limit - node.ambient).max(0.0), owner)
            }
            _ => Prepared::AtRatio(heat_over_the_motion),
        },
    },
    Limit {
        name: STANDSTILL,
        unit: "A",
        formula: "√(mean(T²) + R_wh/R_th · mean over standstill(T²))/K_T ≤ I_continuous, I_thermal: the worst phase carries 2/3 of the heat",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        depends: Depends::Current,
        stated: a_temperature,
        key: by_temperature,
        prepare: |c| {
            if c.load.dwell == 0.0 || c.load.starts_cold() {
                return Prepared::NotAsked;
            }
            if !c.load.has_durations {
                return Prepared::Unknown(NO_DURATIONS);
            }
            let rated = c.motor.continuous_current.map(|i| (i, "motor"));
            let current = [rated, c.thermal_current()].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            match (current, c.motor.conventions.commutation) {
                (_, Commutation::Brushed) => Prepared::NotAsked,
                (Some((bound, owner)), _) => heating(c, c.standing_share(), bound, owner),
                (None, _) => Prepared::Unknown("neither continuous current nor thermal resistances are known"),
            }
        },
    },
];

/// By how much the phase that carries two thirds of the heat at standstill can be hotter than the mean of the three
/// \[K\], where the winding stays below `hottest` \[K\]: from above, as if all the time at standstill were one.
///
/// Its own way to the housing has three times the winding's resistance and a third of its capacity, and twice the
/// mean phase's heat: what it has more is a first order with the winding's resistance and time constant.
fn rise_at_standstill(candidate: &Candidate, node: &TwoNode, hottest: f64, ratio: f64) -> f64 {
    if candidate.standing_share() == 0.0 {
        return 0.0;
    }
    let (heat, stands, cycle) = candidate.load.standing(&candidate.actuator, ratio);
    let answer = |time: f64| -(-time / node.time_constant_winding).exp_m1();
    let share = if stands == 0.0 { 0.0 } else { answer(stands) / answer(cycle) };
    heat * thermal::resistance_factor(hottest, node.reference) * node.resistance_winding_housing * share
}

/// A stretch above the steady limit shorter than this \[s\] is averaged by the winding: the least thermal time constant
/// of a winding in the catalogue is 5.1 s.
const SHORT_STRETCH: f64 = 1.0;

/// Least thermal time constant of a winding in the catalogue \[s\]. Heat that comes at once warms a winding by no more than
/// the steady limit's rise where it is no more than the steady limit's heat over that time.
const LEAST_TIME_CONSTANT: f64 = 5.1;

/// The same as a share of the winding's own time constant, where that is known.
const SHORT_SHARE: f64 = 0.2;

/// Heat over the motion, of a motor or motion whose winding's temperature cannot be followed. Without a heat capacity
/// nothing can be rejected.
fn heat_over_the_motion(candidate: &Candidate, ratio: f64) -> Verdict {
    if candidate.is_evaluated() {
        return candidate.at_ratio(ratio, |here| heat_over_the_motion(here, ratio));
    }
    let (load, actuator) = (candidate.load, &candidate.actuator);
    let Some(limit) = candidate.steady_current() else {
        return Verdict::Unknown(match (candidate.motor.thermal_resistance, candidate.winding_temperature()) {
            (Some(_), None) => "neither a highest winding temperature nor the motor's continuous current is known",
            _ => "neither the motor's thermal resistances nor its continuous current is known",
        });
    };
    // A continuous current says nothing of the temperature that a requirement states.
    if candidate.joint.limits.winding_temperature.is_some() && candidate.thermal_current().is_none() {
        return Verdict::Unknown("the motor's thermal resistances are not known");
    }
    let limit = limit * limit;
    // Even the largest heat, held for ever, would be carried.
    let largest = load.largest_squared_current(actuator, candidate.standing_share(), ratio);
    if stretch::is_within(largest, limit) {
        return Verdict::Kept;
    }
    let (course, repeats) = load.squared_current_course(actuator, candidate.standing_share(), ratio);
    let nodes = candidate.two_node();
    match (nodes, candidate.winding_temperature()) {
        _ if !load.has_durations => {
            return Verdict::Unknown("the operating points have no durations, and the hottest could not be continuous");
        }
        (Some(node), Some((hottest, _))) => {
            // The phase that is worst off at standstill is told apart: its own way to the housing answers at once.
            let (course, _) = load.squared_current_course(actuator, 0.0, ratio);
            let standing = rise_at_standstill(candidate, &node, hottest, ratio);
            let holds = course.iter().map(|piece| (piece.duration, actuator.resistance * piece.from));
            return match node.rise_at_the_end(holds, hottest) + standing <= hottest - node.ambient {
                true => Verdict::Kept,
                false => Verdict::Unknown(
                    "the order of the operating points is not known, and the hottest last may be too hot",
                ),
            };
        }
        _ => {}
    }
    let own = candidate.motor.sheet.thermal_time_constant_winding.map(|t| SHORT_SHARE * t.value);
    let short = own.map_or(SHORT_STRETCH, |own| own.min(SHORT_STRETCH));
    let longest = stretch::longest(&course, limit, repeats);
    let least = candidate.motor.sheet.thermal_time_constant_winding.map_or(LEAST_TIME_CONSTANT, |t| t.value);
    if longest < short && largest * longest > least * limit {
        return Verdict::Unknown(match nodes {
            None => {
                "the thermal time constants are not known, and a short stretch is so far above the steady limit that it may warm the winding beyond it at once"
            }
            Some(_) => {
                "no highest winding temperature is known, and a short stretch is so far above the steady limit that it may warm the winding beyond it at once"
            }
        });
    }
    match (longest < short, nodes.is_some(), load.starts_cold()) {
        (true, false, false) => Verdict::Assumed(
            "judged by its mean heat: the thermal time constants are not known, and heat stays above its steady limit for less than 1 s at a time",
        ),
        (true, true, false) => Verdict::Assumed(
            "judged by its mean heat: no highest winding temperature is known, and heat stays above its steady limit for less than 1 s at a time",
        ),
        (true, _, true) => {
            Verdict::Assumed("taken as kept: from cold heat stays above its steady limit for less than 1 s at a time")
        }
        (false, false, _) => Verdict::Unknown(match short < SHORT_STRETCH {
            false => {
                "the thermal time constants are not known, and heat stays above its steady limit for 1 s or longer"
            }
            true => {
                "not all thermal time constants are known, and heat stays above its steady limit for a fifth of the winding's or longer"
            }
        }),
        (false, true, _) => {
            Verdict::Unknown("no highest winding temperature is known, and heat stays above its steady limit for long")
        }
    }
}

/// Heat at standstill of a motor whose winding is followed over the motion: what is followed is the mean of the three
/// phases, and one of them carries two thirds of the heat.
pub(super) fn heat_at_standstill(candidate: &Candidate, ratio: f64) -> Verdict {
    if candidate.is_evaluated() {
        return candidate.at_ratio(ratio, |here| heat_at_standstill(here, ratio));
    }
    let load = candidate.load;
    let (Some(node), Some((hottest, _)), true) =
        (candidate.two_node(), candidate.winding_temperature(), load.has_course())
    else {
        return Verdict::Kept;
    };
    let more = rise_at_standstill(candidate, &node, hottest, ratio);
    match more == 0.0 || load.winding_peak(&candidate.actuator, &node, ratio).0 + more <= hottest - node.ambient {
        true => Verdict::Kept,
        false => Verdict::Unknown(
            "at standstill one phase carries two thirds of the heat and may be hotter than the mean of the three, which is followed over the motion",
        ),
    }
}
