//! How warm the winding may get: in steady state, over the motion, and at standstill.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::actuator::stretch;
use crate::actuator::thermal::{self, LEAST_TIME_CONSTANT};
use crate::actuator::thermal_motion::TwoNode;
use crate::catalog::convention::Commutation;

/// Nothing says how much heat the motor can carry.
const NO_HEAT: &str =
    "none of continuous current, continuous torque and thermal resistances is known, and they are not estimated";

/// A temperature is stated, and nothing leads to it.
const NO_RESISTANCES: &str = "the motor's thermal resistances are not known";

/// Holding at standstill.
pub(super) const STANDSTILL: &str = "standstill_holding";

/// Temperature over the motion.
const PEAK: &str = "winding_peak_temperature";

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
        stated: always,
        key: by_temperature,
        prepare: |c| match c.thermal_current() {
            // Even from cold a winding is not cooler than its surroundings.
            _ if c.load.starts_cold() && c.winding_temperature().0 > c.robot.ambient => Prepared::NotAsked,
            // Heat without durations is looked at over the motion, as of the hottest point for ever.
            Some(_) if !c.load.has_durations => Prepared::NotAsked,
            Some((bound, owner)) => {
                // A winding that is not followed over the motion has its reserve of temperature here.
                let not_followed = c.two_node().is_none() || !c.load.has_course();
                let reserved = c.current_for(c.joint.limits.left_of(PEAK)).filter(|_| not_followed);
                let left = c.joint.limits.left_of("winding_temperature");
                heating(c, 0.0, reserved.map_or(bound, |(current, _)| bound.min(current / left)), owner)
            }
            None if c.joint.limits.winding_temperature.is_some() => Prepared::Unknown(NO_RESISTANCES),
            None => Prepared::NotAsked,
        },
    },
    Limit {
        name: PEAK,
        unit: "K",
        formula: "max T − T_ambient ≤ T_max − T_ambient over the motion, of the hottest phase: two nodes, at standstill one for a phase with two thirds of the heat, hot copper, periodic state or from cold",
        safety: false,
        of: Of::Other,
        class: Class::Convex,
        depends: Depends::Temperature,
        stated: always,
        key: by_temperature,
        prepare: |c| match (c.two_node(), c.winding_temperature()) {
            _ if c.steady_current().is_none() => Prepared::Unknown(NO_HEAT),
            (Some(node), (limit, owner)) if c.load.has_course() => {
                plain(Demand::WindingPeak(node), 1.0, (limit - node.ambient).max(0.0), owner)
            }
            _ => Prepared::AtRatio(heat_over_the_motion),
        },
    },
    Limit {
        name: STANDSTILL,
        unit: "A",
        formula: "√(mean(T²) + R_wh/R_th · mean over standstill(T²))/K_T ≤ I_continuous, I_thermal: the worst phase carries 2/3 of the heat; asked where the motion is standing for a share of its time",
        safety: false,
        of: Of::QAxis,
        class: Class::Convex,
        depends: Depends::Current,
        stated: always,
        key: by_temperature,
        prepare: |c| {
            if c.load.stands_for() == 0.0 || c.load.starts_cold() {
                return Prepared::NotAsked;
            }
            // Heat without durations is looked at over the motion, as of the hottest point for ever.
            if !c.load.has_durations || c.motor.conventions.commutation == Commutation::Brushed {
                return Prepared::NotAsked;
            }
            let rated = c.continuous_current().map(|i| (i, "motor"));
            let current = [rated, c.thermal_current()].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
            // Of a motor that gives a continuous torque alone, that.
            match current.or_else(|| c.steady_current().map(|i| (i, "motor"))) {
                Some((bound, owner)) => heating(c, c.standing_share(), bound, owner),
                None => Prepared::NotAsked,
            }
        },
    },
];

/// Rise of the phase that carries two thirds of the heat at standstill over the mean of the three \[K\], of operating points in any order, where
/// the winding stays below `hottest` \[K\]: from above, as if all the time at standstill were one hold.
///
/// The phase has three times the winding's thermal resistance to the housing, a third of its capacity, and twice the mean heat of a phase,
/// which adds a first-order lag with the winding's resistance and time constant.
fn rise_at_standstill(candidate: &Candidate, node: &TwoNode, hottest: f64, ratio: f64) -> f64 {
    if !node.phases || candidate.load.stands_for() == 0.0 {
        return 0.0;
    }
    let (heat, stands, cycle) = candidate.load.heat_at_standstill(&candidate.actuator, ratio);
    let answer = |time: f64| -(-time / node.time_constant_winding).exp_m1();
    let share = if stands == 0.0 { 0.0 } else { answer(stands) / answer(cycle) };
    heat * share * thermal::resistance_factor(hottest, node.reference) * node.resistance_winding_housing
}

/// A stretch above the steady limit shorter than this \[s\] is averaged by the winding: the least thermal time constant
/// of a winding in the catalogue is 5.1 s.
pub(super) const SHORT_STRETCH: f64 = 1.0;

/// The same as a share of the winding's own time constant, where that is known.
const SHORT_SHARE: f64 = 0.2;

/// Heat over the motion, of a motor or motion whose winding's temperature cannot be followed. Without a heat capacity
/// nothing can be rejected.
fn heat_over_the_motion(candidate: &Candidate, ratio: f64) -> Verdict {
    if candidate.is_evaluated() {
        return candidate.at_ratio(ratio, |here| heat_over_the_motion(here, ratio));
    }
    let (load, actuator) = (candidate.load, &candidate.actuator);
    let share = candidate.joint.limits.left_of(PEAK);
    let Some(limit) = candidate.steady_current_for(share) else { return Verdict::Unknown(NO_HEAT) };
    // A continuous current says nothing of the temperature that a requirement states.
    if candidate.joint.limits.winding_temperature.is_some() && candidate.thermal_current().is_none() {
        return Verdict::Unknown(NO_RESISTANCES);
    }
    if load.is_mixed {
        return Verdict::Assumed(
            "judged by its mean heat: the samples are of many episodes, and have no order in time",
        );
    }
    let limit = limit * limit;
    // Even the largest heat, held for ever, would be carried.
    let squares = load.squared_currents(actuator, candidate.standing_share(), ratio);
    let largest = squares.iter().copied().fold(0.0, f64::max);
    if stretch::is_within(largest, limit) {
        return Verdict::Kept;
    }
    let (course, repeats) = load.course_of(squares);
    let nodes = candidate.two_node();
    match (nodes, candidate.winding_temperature()) {
        _ if !load.has_durations => {
            return Verdict::Unknown("the operating points have no durations, and the hottest could not be continuous");
        }
        (Some(node), (hottest, _)) => {
            // The phase that is worst off at standstill is told apart: its own way to the housing answers at once.
            let (course, _) = load.course_of(load.squared_currents(actuator, 0.0, ratio));
            let standing = rise_at_standstill(candidate, &node, hottest, ratio);
            let holds = course.iter().map(|piece| (piece.duration, actuator.resistance * piece.from));
            return match node.rise_at_the_end(holds, hottest) + standing <= share * (hottest - node.ambient) {
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
    let least = candidate.motor.sheet.thermal_time_constant_winding.map_or(LEAST_TIME_CONSTANT, |t| t.value);
    match above(&course, repeats, (largest, limit), (short, least)) {
        Above::Never => Verdict::Kept,
        Above::Briefly => Verdict::Assumed(match load.starts_cold() {
            true => "taken as kept: from cold heat stays above its steady limit for less than 1 s at a time",
            false => {
                "judged by its mean heat: the thermal time constants are not known, and heat stays above its steady limit for less than 1 s at a time"
            }
        }),
        Above::Bounded => Verdict::Assumed(
            "judged as if all thermal resistance answered with the time constant of the winding (where it is not known, 5.1 s, the least of the catalogue): from above",
        ),
        Above::Open => Verdict::Unknown(
            "the thermal time constants are not known, and heat stays above its steady limit for so long that a winding which warms quickly may become too hot",
        ),
    }
}

/// How far a course of heat stays above what can be carried for ever.
pub(super) enum Above {
    /// Nowhere.
    Never,
    /// For so short at a time that the winding averages it.
    Briefly,
    /// Not with a winding whose thermal time constant is the least.
    Bounded,
    /// Maybe.
    Open,
}

/// Heat over the motion without a heat capacity: its squares, whether they repeat, the largest of them and their steady limit, and the
/// length of a short stretch and the least thermal time constant \[s\].
pub(super) fn above(
    course: &[stretch::Piece],
    repeats: bool,
    (largest, limit): (f64, f64),
    (short, least): (f64, f64),
) -> Above {
    if stretch::is_within(largest, limit) {
        return Above::Never;
    }
    // Most courses are judged by their mean and by how long they last, without following them.
    let (lasts, mean) = stretch::mean(course);
    let brief = |longest: f64| longest < short && largest * longest <= least * limit;
    match () {
        // What is never made up for lasts for ever, and a lag responds by its mean at least.
        () if repeats && !stretch::is_within(mean, limit) => Above::Open,
        // No stretch is longer than the period, or than what happens once.
        () if brief(lasts) || brief(stretch::longest(course, limit, repeats)) => Above::Briefly,
        // As if all of the thermal resistance were the winding's, with its time constant or the least of any: from above.
        () if stretch::lags_within(course, mean, least, repeats, limit) => Above::Bounded,
        () => Above::Open,
    }
}

/// A rise of the housing by the motor's drag below this \[K\] is not worth a word: thermal numbers are not known so well.
const DRAG_WORTH_A_WORD: f64 = 1.0;

/// Whether heat of the motor's drag is asked about: where a temperature is followed, and there is drag.
pub(super) fn has_heat_of_drag(c: &Candidate) -> bool {
    let drags = [&c.actuator].into_iter().chain(&c.other).any(|end| end.drag_form().0.iter().any(|part| *part != 0.0));
    let followed = c.two_node().is_some_and(|_| c.load.has_course());
    (drags || c.is_evaluated())
        && c.thermal_resistance().is_some()
        && c.load.has_durations
        && (followed || !c.load.starts_cold())
}

/// Whether a winding that copper's heat alone leaves below its limit stays below it with the heat of the motor's drag, which
/// warms its housing: as if all of it went there, all the time.
pub(super) fn heat_of_drag(candidate: &Candidate, ratio: f64) -> Verdict {
    if candidate.is_evaluated() {
        return candidate.at_ratio(ratio, |here| heat_of_drag(here, ratio));
    }
    let (load, actuator) = (candidate.load, &candidate.actuator);
    let Some(whole) = candidate.thermal_resistance() else { return Verdict::Kept };
    let followed = candidate.two_node().filter(|_| load.has_course());
    let drag = load.share_of_time * load.mean_shaft_power(|_| *actuator.drag_form()).at(ratio).max(0.0);
    // From cold a housing warms no further than in the time that there is.
    let share = match (load.starts_cold(), followed) {
        (true, Some(node)) => -(-load.lasts() / node.time_constant_housing).exp_m1(),
        _ => 1.0,
    };
    // What is not worth a word is not counted either: else a ratio with a little more drag would be another matter.
    let rise = drag * share * followed.map_or(whole, |node| node.resistance_housing_ambient) - DRAG_WORTH_A_WORD;
    if rise < 0.0 {
        return Verdict::Kept;
    }
    let (limit, _) = candidate.winding_temperature();
    let stays = match followed {
        Some(node) => {
            let warmed = TwoNode { ambient: node.ambient + rise, ..node };
            let left = candidate.joint.limits.left_of(PEAK) * (limit - node.ambient) - rise;
            load.winding_peak_is_within(actuator, &warmed, ratio, left)
                || load.winding_peak(actuator, &warmed, ratio).0 <= left
        }
        None => {
            let mean = match actuator.shortfall.is_nothing() {
                true => load.mean_torque_squared(actuator).at(ratio).max(0.0) / actuator.torque_constant.powi(2),
                false => load.mean_current_squared(actuator, 0.0, ratio),
            };
            let (motor, ambient) = (candidate.motor, candidate.robot.ambient + rise);
            let settled = thermal::winding_temperature(
                load.share_of_time * mean / candidate.joint.limits.left_of("winding_temperature").powi(2),
                motor.resistance,
                motor.reference_temperature,
                whole,
                ambient,
            );
            settled.is_some_and(|t| t <= limit)
        }
    };
    match stays {
        true => Verdict::Assumed(
            "temperatures are of copper's heat alone; with that of the motor's drag, all of it in the housing, the limit is kept too",
        ),
        false => Verdict::Unknown(
            "the heat of the motor's drag comes on top of copper's: with all of it in the housing the winding would be too hot",
        ),
    }
}
