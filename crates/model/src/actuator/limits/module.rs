//! What a module's row says that it may give: at the flange, with its own losses in it.
//!
//! What it has to give at a sample is `T_k = τ_k + J_o α_k`; friction and gear loss are in the ratings already.

use super::heat::{Above, SHORT_STRETCH, above};
use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::actuator::shaft::Feature;
use crate::actuator::stretch;
use crate::actuator::thermal::LEAST_TIME_CONSTANT;
use crate::catalog::module::overload::Piece;
use crate::catalog::module::{BUILT_IN, Inside, Module, on_curve};
use crate::requirement::Spring;

/// Limits, in the order in which they are reported.
pub(super) const LIMITS: &[Limit] = &[
    Limit {
        name: "torque_speed",
        unit: "1",
        formula: "max safety · |τ + J_o α|/T(|ω|) ≤ 1: the module's curve while it drives and while it is driven, at the bus's voltage",
        safety: true,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        // Whether a torque is there at a speed is asked of everything that turns.
        stated: always,
        key: by_nobody,
        prepare: |c| match inside(c).map(|inside| (torque_speed(c, inside), inside)) {
            None => Prepared::NotAsked,
            // The voltage of its winding and its largest current answer it too, where the gear's loss is in them.
            Some((Prepared::Unknown(_), inside)) if inside.says_whole_power() => Prepared::NotAsked,
            Some((prepared, _)) => prepared,
        },
    },
    Limit {
        name: "rated_torque",
        unit: "N*m",
        formula: "√mean((τ + J_o α)²) ≤ T_rated of the module, standstill counted twice; asked where its overload table does not say more",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: always,
        key: by_nobody,
        prepare: |c| {
            let Some(inside) = inside(c) else { return Prepared::NotAsked };
            match inside.module.sheet.rated_torque {
                _ if c.joint.limits.winding_temperature.is_some() => Prepared::NotAsked,
                _ if has_overload(c, inside) => Prepared::NotAsked,
                Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
                // Then the mean says nothing; what is known of heat over the motion does.
                Some(_) if c.load.starts_cold() => Prepared::NotAsked,
                Some(rated) => plain(Demand::Fixed(rms(c, inside), None), 1.0, rated.value * c.derating(), "module"),
                None => Prepared::NotAsked,
            }
        },
    },
    Limit {
        name: "overload",
        unit: "1",
        formula: "max y ≤ 1 over the motion, with y the normalised temperature by the module's overload tables, turning and at standstill; above 40 °C ambient the share of the rise that is left",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: always,
        key: by_nobody,
        prepare: |c| {
            let found = inside(c).filter(|_| c.joint.limits.winding_temperature.is_none());
            match found.and_then(|inside| overload(c, inside)) {
                // The tables start at the ambient temperature of ratings.
                Some(peak) => plain(Demand::Fixed(peak, None), 1.0, c.derating().powi(2), "module"),
                None => Prepared::NotAsked,
            }
        },
    },
    Limit {
        name: "supply_range",
        unit: "V",
        formula: "V_min ≤ V_bus ≤ V_max of the module",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: by_data_sheets,
        key: |_| Some(Key::Robot(&["bus", "voltage"])),
        prepare: |c| {
            let Some(inside) = inside(c) else { return Prepared::NotAsked };
            let (low, high, volt) =
                (inside.module.sheet.min_voltage, inside.module.sheet.max_voltage, c.robot.bus.voltage);
            let kept = c.joint.limits.left_of("supply_range");
            match (low, high) {
                (Some(low), _) if volt * kept < low.value => plain(Demand::Constant(low.value), 1.0, volt, "module"),
                // The voltage that its ratings refer to is within the range.
                (None, Some(high))
                    if volt <= high.value * kept && inside.module.sheet.voltage.is_none_or(|v| volt < v.value) =>
                {
                    Prepared::Unknown("the module's smallest supply voltage is not known")
                }
                // Inside the range there is nothing more to have.
                (_, Some(high)) if volt <= high.value * kept => Prepared::NotAsked,
                (_, Some(high)) => plain(Demand::Constant(volt), 1.0, high.value, "module"),
                (Some(_), None) => Prepared::Unknown("the module's largest supply voltage is not known"),
                (None, None) => Prepared::Unknown("the module's row does not say its range of supply voltages"),
            }
        },
    },
];

/// What a limit says of a module where that is not what it says of a motor: what its ratings stand for is not asked, and what its
/// row has no constants for is not known.
pub(super) fn of_module(limit: &Limit, candidate: &Candidate) -> Option<Prepared> {
    let inside = candidate.motor.inside.as_deref()?;
    let of_heat = super::heat::LIMITS.iter().any(|of| of.name == limit.name);
    let by_ratings = match limit.name {
        "voltage" => !inside.says_back_emf && says_torque_speed(candidate),
        // A drive inside gives what the ratings say.
        "peak_current" => candidate.has_drive_inside() && candidate.motor.peak_current.is_none(),
        "gear_peak_torque" | "gear_continuous_torque" | "gear_input_speed" => inside.gear.id == BUILT_IN,
        _ => of_heat && says_heat(candidate),
    };
    let is_electrical = match limit.depends {
        Depends::Current | Depends::Temperature | Depends::Voltage | Depends::Power => true,
        Depends::BackEmf | Depends::PowerBack | Depends::Anyhow => true,
        Depends::Torque => candidate.motor.peak_torque.is_some(),
        Depends::Inertia | Depends::Rating => false,
    };
    let needs_emf = matches!(limit.depends, Depends::Voltage | Depends::BackEmf | Depends::PowerBack);
    match () {
        () if by_ratings => Some(Prepared::NotAsked),
        () if limit.depends == Depends::Inertia && !inside.says_inertia => {
            Some(unless_not_asked((limit.prepare)(candidate), "the module's own inertia is not known"))
        }
        () if is_electrical && !inside.says_currents() => Some(unless_not_asked(
            (limit.prepare)(candidate),
            "the module's row does not say what its currents are: no resistance, or no torque constant",
        )),
        () if needs_emf && !inside.says_back_emf => {
            Some(unless_not_asked((limit.prepare)(candidate), "the module's back-EMF constant is not known"))
        }
        () => None,
    }
}

/// A limit that is asked and cannot be judged.
fn unless_not_asked(prepared: Prepared, why: &'static str) -> Prepared {
    if matches!(prepared, Prepared::NotAsked) { Prepared::NotAsked } else { Prepared::Unknown(why) }
}

fn inside<'c>(candidate: &Candidate<'c>) -> Option<&'c Inside> {
    candidate.motor.inside.as_deref()
}

/// Whether the winding's temperature is followed by thermal resistances of the row.
fn has_nodes(candidate: &Candidate) -> bool {
    candidate.motor.thermal_resistance.is_some()
}

/// Whether a module's own ratings say how much heat it bears.
fn says_heat(candidate: &Candidate) -> bool {
    let Some(inside) = inside(candidate) else { return false };
    let rated = inside.module.sheet.rated_torque.is_some();
    rated && candidate.joint.limits.winding_temperature.is_none() && !has_nodes(candidate)
}

/// Whether the row says which torque it gives at the speeds that are asked for.
fn says_torque_speed(candidate: &Candidate) -> bool {
    inside(candidate).is_some_and(|inside| !matches!(torque_speed(candidate, inside), Prepared::Unknown(_)))
}

/// Why a module's torque is not compared with a curve, where its constants answer instead.
pub(super) fn why_no_curve(candidate: &Candidate) -> Option<&'static str> {
    let inside = inside(candidate).filter(|inside| inside.says_whole_power())?;
    match torque_speed(candidate, inside) {
        Prepared::Unknown(why) => Some(why),
        _ => None,
    }
}

/// What it has to give at the flange at each sample: torque \[N·m\], speed \[rad/s\], and the sample.
fn flange<'c>(candidate: &'c Candidate, inside: &'c Inside) -> impl Iterator<Item = (f64, f64, usize)> + 'c {
    let waveform = &candidate.load.waveform;
    let inertia = inertia(candidate, inside);
    (0..waveform.len()).map(move |k| {
        let point = waveform.point(k);
        (point.flange_torque(inertia), point.features[Feature::Velocity as usize], point.origin)
    })
}

/// Inertia of the module at its flange \[kg·m²\].
fn inertia(candidate: &Candidate, inside: &Inside) -> f64 {
    candidate.actuator.inertia * inside.gear.ratio * inside.gear.ratio
}

fn rms(candidate: &Candidate, inside: &Inside) -> f64 {
    let mean = candidate.load.flange_mean_square(inertia(candidate, inside));
    (mean * candidate.load.share_of_time).sqrt()
}

/// Whether the overload table and the motion say how warm it gets.
fn has_overload(candidate: &Candidate, inside: &Inside) -> bool {
    inside.response.is_some() && candidate.load.has_flange_course()
}

/// A share by which what is computed of an overload table may exceed it.
const OF_TABLE: f64 = 1e-3;

/// The largest normalised temperature over the motion, where the overload table and the motion say it.
fn overload(candidate: &Candidate, inside: &Inside) -> Option<f64> {
    let response = inside.response.as_ref()?;
    let inertia = inertia(candidate, inside);
    let (course, repeats) = candidate.load.flange_course(inertia)?;
    let piece = |[turning, standing]: &[stretch::Piece; 2]| Piece {
        lasts: turning.duration,
        turning: [turning.from, turning.to],
        standing: [standing.from, standing.to],
    };
    let pieces: Vec<Piece> = course.iter().map(piece).collect();
    // Times of tables are rounded by more than this: a point of its own is kept.
    Some(response.peak(&pieces, repeats) / (1.0 + OF_TABLE))
}

/// What of the torque that a module gives at a speed is asked for, at the worst sample.
fn torque_speed(candidate: &Candidate, inside: &Inside) -> Prepared {
    let (safety, volt) = (candidate.joint.limits.safety, candidate.robot.bus.voltage);
    let (mut worst, mut sample, mut undecided) = (0.0_f64, None, None);
    for (torque, speed, k) in flange(candidate, inside) {
        let asked = safety * torque.abs();
        match beyond_no_load(&inside.module, speed.abs(), torque * speed < 0.0, volt) {
            Beyond::Within => {}
            Beyond::Maybe => undecided = Some(MORE_VOLTAGE),
            Beyond::By(share) => {
                if share > worst {
                    (worst, sample) = (share, Some(k));
                }
                continue;
            }
        }
        match most_torque(&inside.module, speed.abs(), torque * speed >= 0.0, volt) {
            Most::Known(most) => {
                let share = if asked == 0.0 { 0.0 } else { asked / most.max(0.0) };
                if share > worst {
                    (worst, sample) = (share, Some(k));
                }
            }
            Most::Between(sure, most, why) => {
                if asked > most {
                    let share = if most > 0.0 { asked / most } else { f64::INFINITY };
                    if share > worst {
                        (worst, sample) = (share, Some(k));
                    }
                } else if asked > sure {
                    undecided = Some(why);
                } else if asked / sure.max(f64::MIN_POSITIVE) > worst && worst <= 1.0 {
                    (worst, sample) = (asked / sure, Some(k));
                }
            }
            Most::Unknown(why) => undecided = Some(why),
        }
    }
    match undecided {
        Some(why) if worst <= 1.0 => Prepared::Unknown(why),
        _ => plain(Demand::Fixed(worst, sample), 1.0, 1.0, "module"),
    }
}

/// Whether some spring of a range may leave to a module, at each sample, no more than what its row lets it give; `false` is certain. With
/// stiffness k and s = k q_0 each sample asks −b ≤ τ + J_o α + k q − s ≤ a, two half-planes, and the range is a convex piece of the
/// plane: it is cut by one after another.
pub fn allows_spring(candidate: &Candidate, spring: &Spring) -> bool {
    let (Some(inside), Some(pull)) = (inside(candidate), candidate.joint.pull()) else { return true };
    let (motion, inertia) = (&candidate.joint.motion, inertia(candidate, inside));
    let (safety, volt) = (candidate.joint.limits.safety, candidate.robot.bus.voltage);
    let most = |speed: f64, driving: bool| match most_torque(&inside.module, speed, driving, volt) {
        Most::Known(most) | Most::Between(_, most, _) => most / safety,
        Most::Unknown(_) => f64::INFINITY,
    };
    let ([k0, k1], [q0, q1]) = (spring.stiffness, spring.rest_angle);
    let mut piece = vec![[k0, k0 * q0], [k0, k0 * q1], [k1, k1 * q1], [k1, k1 * q0]];
    for j in 0..motion.len() {
        let [q, per] = pull.torque(j);
        let (load, speed) = (motion.torque[j] + inertia * motion.acceleration[j], motion.velocity[j]);
        let beyond = [false, true].map(|braking| beyond_no_load(&inside.module, speed.abs(), braking, volt));
        if beyond.iter().all(|beyond| matches!(beyond, Beyond::By(_))) {
            return false;
        }
        for sign in [1.0, -1.0] {
            let most = most(speed.abs(), sign * speed >= 0.0);
            let over = |[k, s]: [f64; 2]| sign * (load + k * q - s * per) - most - 1e-9 * (most + load.abs());
            piece = clipped(&piece, over);
        }
    }
    !piece.is_empty()
}

/// What of a convex polygon has no positive value of a linear function.
fn clipped(polygon: &[[f64; 2]], over: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut left = Vec::new();
    for (j, here) in polygon.iter().enumerate() {
        let next = polygon[(j + 1) % polygon.len()];
        let (a, b) = (over(*here), over(next));
        if a <= 0.0 {
            left.push(*here);
        }
        if (a > 0.0) != (b > 0.0) && a.is_finite() && b.is_finite() {
            let share = a / (a - b);
            left.push([here[0] + share * (next[0] - here[0]), here[1] + share * (next[1] - here[1])]);
        }
    }
    left
}

/// Position of a speed against the no-load speed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Beyond {
    Within,
    /// More voltage than that of the row may reach it.
    Maybe,
    /// Ratio of the speed to the no-load speed.
    By(f64),
}

/// Compare a speed \[rad/s\] with the no-load speed at a bus voltage. Beyond that speed the back-EMF exceeds the bus: neither zero nor a small
/// braking torque can be controlled, unless a braking curve covers the speed.
fn beyond_no_load(module: &Module, speed: f64, braking: bool, volt: f64) -> Beyond {
    let Some(most) = module.no_load_speed_at(volt) else { return Beyond::Within };
    let more = module.sheet.voltage.map_or(1.0, |printed| (volt / printed.value).max(1.0));
    let covered = braking && module.braking_curve.last().is_some_and(|[last, _]| speed <= *last);
    let share = speed / most.max(f64::MIN_POSITIVE);
    match () {
        () if covered || share <= 1.0 + OF_TABLE => Beyond::Within,
        () if share <= more => Beyond::Maybe,
        () => Beyond::By(share),
    }
}

/// What is known of the torque that a module gives at a speed \[N·m\].
#[derive(Debug, Clone, Copy, PartialEq)]
enum Most {
    Known(f64),
    /// So much certainly, and certainly no more than this; why not more is known.
    Between(f64, f64, &'static str),
    Unknown(&'static str),
}

const NO_CURVE: &str = "not decided: the module's row has no torque–speed curve, and a point lies between the line from peak torque to no-load speed and the box of both";
const NO_FREE_SPEED: &str = "the module's speed without load is not known, and the bus has less voltage than its curve";
const MORE_VOLTAGE: &str = "not decided: the bus has more voltage than the module's row refers to, and what it gives there beyond its printed torque and speed is not known";

/// The largest torque of a module at a speed \[rad/s\] and a bus voltage. At less voltage than the curve's it is that of the
/// curve moved by what the speed without load loses. At more it is at least that of the curve, and what more there is nobody says.
fn most_torque(module: &Module, speed: f64, driving: bool, volt: f64) -> Most {
    let sheet = &module.sheet;
    let curve = match (driving, module.braking_curve.is_empty()) {
        (false, false) => &module.braking_curve,
        _ => &module.driving_curve,
    };
    let of_curve = sheet.voltage.map(|p| p.value);
    let no_load = module.no_load_speed();
    // With less voltage there is less speed.
    let lost = module.speed_lost(volt);
    let missing = lost.unwrap_or(0.0);
    // With more there may be more, up to as much more speed as there is voltage.
    let more = of_curve.map_or(1.0, |of_curve| (volt / of_curve).max(1.0));
    let peak = sheet.peak_torque.or(sheet.stall_torque).map(|p| p.value);
    let sure = |sure: f64| match (more > 1.0 && driving, no_load) {
        (false, _) => Most::Known(sure),
        (true, Some(no_load)) if speed > more * no_load => Most::Known(0.0),
        (true, _) => match peak.or(module.largest_torque()) {
            // Where it gives its peak torque it gives no more.
            Some(peak) if sure < peak => Most::Between(sure, peak, MORE_VOLTAGE),
            _ => Most::Known(sure),
        },
    };
    if !curve.is_empty() {
        // While it is driven without a curve of its own, what it gives at standstill.
        let by_driving = driving || module.braking_curve.is_empty();
        let speed = if !driving && by_driving { 0.0 } else { speed + missing };
        // A braking curve is more than the peak torque while it drives: the gear's loss helps.
        let most = sheet.peak_torque.filter(|_| by_driving).map_or(f64::INFINITY, |p| p.value);
        let at_speed = on_curve(curve, speed).min(most);
        return match lost.is_none() && speed > 0.0 {
            true => Most::Between(0.0, at_speed, NO_FREE_SPEED),
            false => sure(at_speed),
        };
    }
    if driving && no_load.is_some_and(|no_load| speed + missing > no_load) {
        return sure(0.0);
    }
    match (peak, no_load) {
        (Some(most), Some(no_load)) if driving => {
            let why = if more > 1.0 { MORE_VOLTAGE } else { NO_CURVE };
            Most::Between(most * (1.0 - (speed + missing) / no_load), most, why)
        }
        // Against the speed it has at least what it has at standstill.
        (Some(most), _) if !driving => Most::Known(most),
        (Some(most), None) if speed == 0.0 => Most::Known(most),
        (Some(most), None) => {
            Most::Between(0.0, most, "the module's row says neither a torque–speed curve nor a speed without load")
        }
        _ => Most::Unknown("the module's row says neither a torque–speed curve nor a peak torque"),
    }
}

/// Whether a curve is taken at the bus's voltage though its row does not say at which it holds.
pub(super) fn why_no_voltage(candidate: &Candidate) -> Option<&'static str> {
    let module = &inside(candidate)?.module;
    let rates = !module.driving_curve.is_empty() || module.sheet.no_load_speed.is_some();
    (rates && module.sheet.voltage.is_none()).then_some(
        "the module's row does not say at which voltage its torques and speeds hold: they are taken as those of this bus",
    )
}

/// Whether heat over the motion is judged by the rated torque alone.
pub(super) fn is_judged_by_rating(candidate: &Candidate) -> bool {
    inside(candidate).is_some_and(|inside| says_heat(candidate) && !has_overload(candidate, inside))
}

/// What is known of heat over the motion of a module whose row has a rated torque and no overload table: as of a motor without
/// thermal time constants.
pub(super) fn heat_by_rating(candidate: &Candidate, _: f64) -> Verdict {
    let Some(inside) = inside(candidate) else { return Verdict::Kept };
    let rated = inside.module.sheet.rated_torque.map_or(f64::INFINITY, |p| p.value) * candidate.derating();
    let rated = rated * candidate.joint.limits.left_of("rated_torque");
    let Some((course, repeats)) = candidate.load.flange_course(inertia(candidate, inside)) else {
        return Verdict::Kept;
    };
    let both = |[a, b]: &[stretch::Piece; 2]| stretch::Piece { from: a.from + b.from, to: a.to + b.to, ..*a };
    let course: Vec<stretch::Piece> = course.iter().map(both).collect();
    let largest = course.iter().map(|piece| piece.from.max(piece.to)).fold(0.0, f64::max);
    match above(&course, repeats, (largest, rated * rated), (SHORT_STRETCH, LEAST_TIME_CONSTANT)) {
        Above::Never => Verdict::Kept,
        Above::Briefly => Verdict::Assumed(match candidate.load.starts_cold() {
            true => "taken as kept: from cold it gives more than its rated torque for less than 1 s at a time",
            false => {
                "judged by its mean: it gives more than its rated torque for less than 1 s at a time, and its row has no overload table"
            }
        }),
        Above::Bounded => Verdict::Assumed(
            "judged as if a winding with a time constant of 5.1 s, the least of the catalogue, bore its rated torque: its row has no overload table",
        ),
        Above::Open => Verdict::Unknown(
            "it gives more than its rated torque for so long that a winding which warms quickly may become too hot, and its row has no overload table",
        ),
    }
}
