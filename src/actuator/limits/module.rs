//! What a module's row says that it may give: at the flange, with its own losses in it.
//!
//! What it has to give at a sample is `T_k = τ_k + J_o α_k`; friction and gear loss are in the ratings already.

use super::limit::*;
use crate::actuator::candidate::Candidate;
use crate::actuator::shaft::Feature;
use crate::catalog::module::overload::Piece;
use crate::catalog::module::{BUILT_IN, Inside, Module, on_curve};

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
            // The voltage of its winding and its largest current answer it too.
            Some((Prepared::Unknown(_), inside)) if inside.says_power() => Prepared::NotAsked,
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
                _ if c.joint.limits.winding_temperature.is_some() || has_nodes(c) => Prepared::NotAsked,
                _ if has_overload(c, inside) => Prepared::NotAsked,
                Some(_) if !c.load.has_durations => Prepared::Unknown(NO_DURATIONS),
                Some(_) if c.load.starts_cold() => Prepared::Unknown(
                    "the motion does not repeat, and how long the module bears more than its rated torque is not known",
                ),
                Some(rated) => plain(Demand::Fixed(rms(c, inside), None), 1.0, rated.value, "module"),
                None => Prepared::NotAsked,
            }
        },
    },
    Limit {
        name: "overload",
        unit: "1",
        formula: "max y ≤ 1: the normalised temperature that the module's overload table says, over the motion",
        safety: false,
        of: Of::Other,
        class: Class::Fixed,
        depends: Depends::Rating,
        stated: always,
        key: by_nobody,
        prepare: |c| {
            let found = inside(c).filter(|_| c.joint.limits.winding_temperature.is_none() && !has_nodes(c));
            match found.and_then(|inside| overload(c, inside)) {
                Some(peak) => plain(Demand::Fixed(peak, None), 1.0, 1.0, "module"),
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
            match (low, high) {
                (Some(low), _) if volt < low.value => plain(Demand::Constant(low.value), 1.0, volt, "module"),
                // Inside the range there is nothing more to have.
                (_, Some(high)) if volt <= high.value => Prepared::NotAsked,
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
    let inside = inside(candidate).filter(|inside| inside.says_power())?;
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

/// The largest normalised temperature over the motion, where the overload table and the motion say it.
fn overload(candidate: &Candidate, inside: &Inside) -> Option<f64> {
    let response = inside.response.as_ref()?;
    let inertia = inertia(candidate, inside);
    let (course, repeats) = candidate.load.flange_course(inertia)?;
    let pieces: Vec<Piece> = course.iter().map(|piece| (piece.duration, piece.from, piece.to)).collect();
    Some(response.peak(&pieces, repeats))
}

/// What of the torque that a module gives at a speed is asked for, at the worst sample.
fn torque_speed(candidate: &Candidate, inside: &Inside) -> Prepared {
    let (safety, volt) = (candidate.joint.limits.safety, candidate.robot.bus.voltage);
    let (mut worst, mut sample, mut undecided) = (0.0_f64, None, None);
    for (torque, speed, k) in flange(candidate, inside) {
        let asked = safety * torque.abs();
        match most_torque(&inside.module, speed.abs(), torque * speed >= 0.0, volt) {
            Most::Known(most) => {
                let share =
                    if asked == 0.0 { if most < 0.0 { f64::INFINITY } else { 0.0 } } else { asked / most.max(0.0) };
                if share > worst {
                    (worst, sample) = (share, Some(k));
                }
            }
            Most::Between(sure, most) => {
                if asked > most {
                    let share = if most > 0.0 { asked / most } else { f64::INFINITY };
                    if share > worst {
                        (worst, sample) = (share, Some(k));
                    }
                } else if asked > sure {
                    undecided = Some(
                        "not decided: the module's row has no torque–speed curve, and a point lies between the line from peak torque to no-load speed and the box of both",
                    );
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

/// What is known of the torque that a module gives at a speed \[N·m\].
#[derive(Debug, Clone, Copy, PartialEq)]
enum Most {
    Known(f64),
    /// So much certainly, and certainly no more than this.
    Between(f64, f64),
    Unknown(&'static str),
}

/// The largest torque of a module at a speed \[rad/s\] and a bus voltage. At less voltage than the curve's it is that of the
/// curve moved by what the speed without load loses; at more that of the curve.
fn most_torque(module: &Module, speed: f64, driving: bool, volt: f64) -> Most {
    let sheet = &module.sheet;
    let curve = match (driving, module.braking_curve.is_empty()) {
        (false, false) => &module.braking_curve,
        _ => &module.driving_curve,
    };
    let of_curve = sheet.voltage.map(|p| p.value);
    let no_load = module.no_load_speed();
    // With less voltage there is less speed.
    let missing = match (of_curve, no_load) {
        (Some(of_curve), Some(no_load)) if volt < of_curve => no_load * (1.0 - volt / of_curve),
        (Some(of_curve), None) if volt < of_curve => {
            return Most::Unknown(
                "the module's speed without load is not known, and the bus has less voltage than its curve",
            );
        }
        _ => 0.0,
    };
    if !curve.is_empty() {
        // While it is driven without a curve of its own, what it gives at standstill.
        let speed = if !driving && module.braking_curve.is_empty() { 0.0 } else { speed + missing };
        return Most::Known(on_curve(curve, speed).min(sheet.peak_torque.map_or(f64::INFINITY, |p| p.value)));
    }
    if driving && no_load.is_some_and(|no_load| speed + missing > no_load) {
        return Most::Known(0.0);
    }
    let most = sheet.peak_torque.or(sheet.stall_torque).map(|p| p.value);
    match (most, no_load) {
        (Some(most), Some(no_load)) if driving => Most::Between(most * (1.0 - (speed + missing) / no_load), most),
        // Against the speed it has at least what it has at standstill.
        (Some(most), _) if !driving => Most::Known(most),
        (Some(most), None) if speed == 0.0 => Most::Known(most),
        (Some(_), None) => Most::Unknown("the module's row says neither a torque–speed curve nor a speed without load"),
        _ => Most::Unknown("the module's row says neither a torque–speed curve nor a peak torque"),
    }
}
