//! Does a row add up? Redundant numbers of a sheet are compared in the sheet's own convention, and
//! where another convention would explain a mismatch, it is named.
//!
//! A block-commutated sheet shows an S_M π²/9 higher, a stall torque 4.5 % lower and a no-load speed
//! 4.7 % higher than its q-axis equivalent; that is no error, and comparing in the sheet's own frame
//! does not take it for one. A new check is one line in [`CHECKS`].

use std::collections::HashMap;

use super::convention::{
    BackEmfConvention, Commutation, CurrentConvention, SpeedConstantConvention, Terminals, Winding, word,
};
use super::finding::{Audited, Beside, Outcome};
pub use super::finding::{Finding, Severity};
use super::module::audit::audit_module;
use super::outlier::{is_code, outliers};
use super::row::{MotorRow, Row};
use super::twins::{CODE as SAME_MOTOR, twins};
use super::{Catalog, Gear, GearKind, Motor, Printed};
use crate::words::number;

/// One comparison of redundant numbers.
pub struct MotorCheck {
    /// Code, also in the catalogue's `audit_accept` column.
    pub code: &'static str,
    /// What is compared.
    pub compares: &'static str,
    run: fn(&Motor) -> Option<Outcome>,
}

/// Every check of a motor row.
pub const CHECKS: &[MotorCheck] = &[
    MotorCheck { code: "motor-constant", compares: "K_M against √(K_T K_B/R)", run: motor_constant },
    MotorCheck { code: "speed-constant", compares: "K_T against the speed constant", run: speed_constant },
    MotorCheck {
        code: "back-emf",
        compares: "K_T against K_B: more torque than back-EMF would make energy",
        run: back_emf,
    },
    MotorCheck { code: "stall-torque", compares: "stall torque against K_T V/R", run: stall_torque },
    MotorCheck { code: "no-load-speed", compares: "no-load speed against (V − R I_0)/K_B", run: no_load_speed },
    MotorCheck {
        code: "mechanical-time-constant",
        compares: "mechanical time constant against J_m R/(K_T K_B)",
        run: mechanical_time_constant,
    },
    MotorCheck { code: "responsiveness", compares: "printed S_M against J_m R/(K_T K_B)", run: responsiveness },
    MotorCheck {
        code: "torque-specific-inertia",
        compares: "printed S_T against J_m/K_T²",
        run: torque_specific_inertia,
    },
    MotorCheck {
        code: "peak-torque",
        compares: "peak torque against K_T I_peak: 0.6 to 0.95 is iron saturation, above 1 an error",
        run: peak_torque,
    },
    MotorCheck {
        code: "continuous-torque",
        compares: "continuous torque against K_T I_continuous",
        run: continuous_torque,
    },
    MotorCheck {
        code: "inductance-unit",
        compares: "L/R against what motors have: 0.02 to 20 ms",
        run: electrical_time_constant,
    },
    MotorCheck {
        code: "rotor-inertia",
        compares: "rotor inertia against the rotor's mass at the gap radius",
        run: rotor_inertia,
    },
    MotorCheck {
        code: "thermal-time-constants",
        compares: "the winding must warm up faster than the housing",
        run: thermal,
    },
    MotorCheck {
        code: "out-of-range",
        compares: "temperatures, poles and speeds with what motors can have",
        run: out_of_range,
    },
    MotorCheck { code: SAME_MOTOR, compares: "names and numbers against those of other rows", run: beside_others },
];

/// Runs every check over a catalogue, in the order of its rows.
pub fn audit(catalog: &Catalog) -> Vec<Finding> {
    let beside = [outliers(catalog), twins(&catalog.motors)].concat();
    let mut by_id: HashMap<&str, Vec<&Beside>> = HashMap::new();
    beside.iter().for_each(|of| by_id.entry(&of.id).or_default().push(of));
    let remarks = |id: &str, accepts: &[String]| {
        let remark = |of: &&Beside| Finding {
            id: of.id.clone(),
            code: of.code,
            severity: Severity::Note,
            message: of.message.clone(),
            explanation: Some(of.explanation.into()),
            accepted: accepts.iter().any(|code| code == of.code),
        };
        by_id.get(id).into_iter().flatten().map(remark).collect::<Vec<_>>()
    };
    let motors = catalog.motors.iter().flat_map(|motor| {
        let beside = if motor.inside.is_some() { Vec::new() } else { remarks(&motor.id, &motor.accepted_findings) };
        audit_motor(motor).into_iter().chain(beside)
    });
    let gears = catalog.all_gears().flat_map(|gear| audit_gear(gear).into_iter().chain(remarks(&gear.id, &[])));
    let of_module = |module| audit_module(module, &catalog.modules, &catalog.motors, &catalog.alternatives);
    let modules = catalog.modules.iter().flat_map(of_module);
    motors.chain(gears).chain(modules).collect()
}

/// Runs every check over one motor.
pub fn audit_motor(motor: &Motor) -> Vec<Finding> {
    // Of a module its own row is audited.
    if let Some(inside) = &motor.inside {
        return inside.findings.clone();
    }
    let outcomes = CHECKS.iter().filter_map(|check| Some((check.code, (check.run)(motor)?)));
    // What is looked at beside other rows is not known here.
    let accepts = motor
        .accepted_findings
        .iter()
        .map(String::as_str)
        .filter(|code| *code != SAME_MOTOR && !is_code(code))
        .collect();
    let row = Audited { id: &motor.id, accepts, note: &motor.note };
    row.findings(outcomes, |code| CHECKS.iter().any(|check| check.code == code))
}

/// What `N T_s/T_b` may be above one by rounding of the two torques, which sheets print with two digits.
const TWO_DIGITS: f64 = 0.05;

/// Checks of a gear: a stage of a planetary gear reduces by 2.5 to 13, no way through it makes energy, and what it may bear for
/// longer is not more than what it may bear for a moment.
fn audit_gear(gear: &Gear) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut add = |code, severity, message, explanation: Option<&str>| {
        findings.push(Finding {
            id: gear.id.clone(),
            code,
            severity,
            message,
            explanation: explanation.map(str::to_string),
            accepted: false,
        });
    };
    if let (GearKind::Planetary, Some(stages)) = (gear.kind, gear.stages) {
        let per_stage = gear.ratio.powf(1.0 / f64::from(stages));
        if !(2.4..=13.0).contains(&per_stage) {
            let message = format!(
                "{stages} planetary stages for a ratio of {}: {} per stage",
                number(gear.ratio),
                number(per_stage)
            );
            add("gear-stages", Severity::Error, message, None);
        }
    }
    if let (Some(forward), Some(backward)) = (gear.load_efficiency(), gear.load_backdrive_efficiency())
        && backward > forward + 0.1
    {
        let message = format!("the gear is {} efficient backwards, {} forwards", number(backward), number(forward));
        add("gear-efficiency", Severity::Error, message, None);
    }
    if let Some(ratio) = gear.backdriving_ratio().filter(|ratio| *ratio > 1.0 + TWO_DIGITS) {
        let message = format!(
            "N times the starting torque is {} of the backdriving torque: the gear would be more than lossless backwards",
            number(ratio)
        );
        let why = "one of the two may be a bound and not a measurement, or at the other side of the gear";
        add("gear-backdriving", Severity::Error, message, Some(why));
    }
    if gear.loss_is_in_efficiency() {
        let message = "the row says a torque without load, and not at which load its efficiency holds".into();
        let why = "the efficiency counts for all of the loss, and that torque for backdriving alone";
        add("gear-efficiency-point", Severity::Note, message, Some(why));
    }
    let ratings = gear.ratings.contradictions(gear.continuous_torque, gear.peak_torque, gear.max_input_speed);
    for ([(lower, least), (upper, most)], unit) in ratings {
        let show = |si: f64| number(crate::units::in_unit(si, unit));
        let message = format!("{lower} ({} {unit}) is more than {upper} ({} {unit})", show(least), show(most));
        add("gear-ratings", Severity::Error, message, None);
    }
    findings
}

/// The sheet's own frame: torque constant, back-EMF constant, resistance and voltage such that
/// stall torque is K V/R and no-load speed V/K_B. DC sheets live in the DC frame, all others in the
/// q-axis equivalent.
struct Frame {
    torque_constant: f64,
    back_emf_constant: f64,
    resistance: f64,
    voltage: Option<f64>,
    name: &'static str,
}

fn frame(motor: &Motor) -> Frame {
    let commutation = motor.conventions.commutation;
    let block = 1.0 / CurrentConvention::Dc.torque_constant(commutation);
    let voltage = motor.sheet.voltage.map(|v| v.value);
    match (motor.conventions.of_torque_constant(), commutation) {
        (_, Commutation::Brushed) => Frame {
            torque_constant: motor.torque_constant,
            back_emf_constant: motor.back_emf_constant,
            resistance: motor.resistance,
            voltage,
            name: "brushed",
        },
        (CurrentConvention::Dc, _) => Frame {
            torque_constant: motor.torque_constant * block,
            back_emf_constant: motor.back_emf_constant * block,
            resistance: motor.resistance * 2.0,
            voltage,
            name: "DC",
        },
        _ => Frame {
            torque_constant: motor.torque_constant,
            back_emf_constant: motor.back_emf_constant,
            resistance: motor.resistance,
            voltage: voltage.map(|v| v / 2.0_f64.sqrt()),
            name: "q-axis",
        },
    }
}

/// `Some` with "printed is x % above/below y" where the two differ by more than `allowed`.
fn mismatch(what: &str, printed: f64, expected: f64, allowed: f64, unit: &str, from: &str) -> Option<String> {
    let deviation = printed / expected - 1.0;
    if deviation.abs() <= allowed {
        return None;
    }
    let show = |si: f64| format!("{} {unit}", number(crate::units::in_unit(si, unit)));
    let percent = number(100.0 * deviation.abs());
    let side = if deviation > 0.0 { "above" } else { "below" };
    Some(format!(
        "{what} is printed as {}, {percent} % {side} the {} that follows from {from}",
        show(printed),
        show(expected)
    ))
}

fn error(message: String, explanation: Option<String>) -> Option<Outcome> {
    Some(Outcome { severity: Severity::Error, message, explanation })
}

fn motor_constant(motor: &Motor) -> Option<Outcome> {
    let printed = motor.sheet.motor_constant?.value;
    // As printed: a sheet computes K_M from its own K_T, K_B and R, whatever they refer to. One that
    // means torque per root of heat, on the q axis or in the sheet's frame, is right as well.
    let k_t = motor.sheet.torque_constant?.value;
    let k_b = motor.sheet.back_emf_constant.map_or(k_t, |k| k.value);
    let r = motor.sheet.resistance?.value;
    let expected = (k_t * k_b / r).sqrt();
    let message = mismatch("K_M", printed, expected, 0.03, "N*m/W^0.5", "K_T, K_B and R as printed")?;
    let frame = frame(motor);
    let of = |k_t: f64, k_b: f64, r: f64| (k_t * k_b / r).sqrt();
    let right = [
        of(motor.torque_constant, motor.back_emf_constant, motor.resistance),
        of(frame.torque_constant, frame.back_emf_constant, frame.resistance),
    ];
    if right.iter().any(|k_m| (printed / k_m - 1.0).abs() <= 0.03) {
        return None;
    }
    let factor = (expected / printed).powi(2);
    let readings = [
        (2.0, "it follows with twice the resistance (line-to-line taken for phase)"),
        (0.5, "it follows with half the resistance (phase taken for line-to-line)"),
        (1.5, "it follows with 3/2 of the resistance (amplitude convention, 1.5 R i²)"),
        (4.0 / 3.0, "it follows with 4/3 of the resistance: 2 R_ll where 1.5 R_ll is printed, two frames mixed"),
        (2.0 / 3.0, "it follows with 2/3 of the resistance (delta: line-to-line taken for winding)"),
        (3.0, "it follows with three times the resistance (delta winding taken for its wye equivalent)"),
        (1.0 / 3.0, "it follows with a third of the resistance (wye equivalent of a delta winding)"),
    ];
    let explanation = readings.iter().find(|(f, _)| (factor / f - 1.0).abs() < 0.03).map(|(_, why)| (*why).to_string());
    error(message, explanation)
}

/// Readings of torque constant and back-EMF that would make them agree on the q axis.
fn explain_constants(motor: &Motor, back_emf: f64, speed: bool) -> Option<String> {
    let commutation = motor.conventions.commutation;
    if commutation == Commutation::Brushed {
        return None;
    }
    let k_t = motor.sheet.torque_constant?.value;
    let agree = |k_t_factor: f64, k_b: f64| (k_t * k_t_factor / k_b - 1.0).abs() < 0.03;
    let mut readings = Vec::new();
    for (name, convention) in CurrentConvention::NAMES {
        if *convention != motor.conventions.of_torque_constant()
            && agree(convention.torque_constant(commutation), back_emf)
        {
            readings.push(format!("`current = {name}`"));
        }
    }
    let k_t_q = motor.conventions.of_torque_constant().torque_constant(commutation);
    if speed {
        let kv = motor.sheet.speed_constant?.value;
        for (name, convention) in SpeedConstantConvention::NAMES {
            if Some(*convention) != motor.conventions.speed_constant
                && agree(k_t_q, convention.back_emf_constant(commutation) / kv)
            {
                readings.push(format!("`speed_constant_convention = {name}`"));
            }
        }
    } else {
        let printed = motor.sheet.back_emf_constant?.value;
        for (name, convention) in BackEmfConvention::NAMES {
            if Some(*convention) != motor.conventions.back_emf
                && agree(k_t_q, printed * convention.back_emf_constant(commutation))
            {
                readings.push(format!("`back_emf_convention = {name}`"));
            }
        }
    }
    (!readings.is_empty()).then(|| format!("{} would make them agree", readings.join(" or ")))
}

fn speed_constant(motor: &Motor) -> Option<Outcome> {
    let (kv, convention) = (motor.sheet.speed_constant?.value, motor.conventions.speed_constant?);
    motor.sheet.torque_constant?;
    let k_b = convention.back_emf_constant(motor.conventions.commutation) / kv;
    let allowed = if convention == SpeedConstantConvention::Dc { 0.05 } else { 0.06 };
    let message = mismatch("K_T (on the q axis)", motor.torque_constant, k_b, allowed, "N*m/A", "the speed constant")?;
    error(message, explain_constants(motor, k_b, true))
}

fn back_emf(motor: &Motor) -> Option<Outcome> {
    let (k_t, k_b) = (motor.sheet.torque_constant?, motor.sheet.back_emf_constant?);
    let excess = motor.torque_constant / motor.back_emf_constant - 1.0;
    let uncertainty = match (k_t.relative_tolerance(), k_b.relative_tolerance()) {
        (Some(a), Some(b)) => Some((1.0 + excess) * a.hypot(b)),
        _ => None,
    };
    let percent = |x: f64| format!("{:.1}", 100.0 * x);
    let by = uncertainty.map_or_else(
        || format!("{} %", percent(excess.abs())),
        |u| format!("{} ± {} %", percent(excess.abs()), percent(u)),
    );
    if excess > 0.03 {
        return error(
            format!("K_T exceeds K_B by {by}: more torque per ampere than back-EMF would make energy"),
            explain_constants(motor, motor.back_emf_constant, false).or_else(|| {
                Some("a back-EMF that is not sinusoidal, or a gain error of the torque or current measurement".into())
            }),
        );
    }
    if excess < -0.15 {
        return error(
            format!("K_T is {by} below K_B: more than saturation and iron loss explain"),
            explain_constants(motor, motor.back_emf_constant, false),
        );
    }
    None
}

fn stall_torque(motor: &Motor) -> Option<Outcome> {
    let frame = frame(motor);
    let printed = motor.sheet.stall_torque?.value;
    let expected = frame.torque_constant * frame.voltage? / frame.resistance;
    let ratio = printed / expected;
    let from = format!("K_T V/R in the {} frame", frame.name);
    if (0.47..0.53).contains(&ratio) || (1.9..2.1).contains(&ratio) {
        let why = "a factor of two: resistance of a phase taken for line-to-line, or the other way round";
        return error(mismatch("stall torque", printed, expected, 0.05, "N*m", &from)?, Some(why.into()));
    }
    if (0.05..0.9).contains(&ratio) {
        // A printed stall torque well below is a saturated one.
        return Some(Outcome {
            severity: Severity::Note,
            message: mismatch("stall torque", printed, expected, 0.05, "N*m", &from)?,
            explanation: Some("iron saturation, if the sheet measures stall torque".into()),
        });
    }
    error(mismatch("stall torque", printed, expected, 0.05, "N*m", &from)?, None)
}

fn no_load_speed(motor: &Motor) -> Option<Outcome> {
    let frame = frame(motor);
    let printed = motor.sheet.no_load_speed?.value;
    let drop = if frame.name == "q-axis" {
        0.0
    } else {
        motor.sheet.no_load_current.map_or(0.0, |i| i.value) * frame.resistance
    };
    let expected = (frame.voltage? - drop) / frame.back_emf_constant;
    let message = mismatch(
        "no-load speed",
        printed,
        expected,
        0.06,
        "rpm",
        &match frame.name {
            "q-axis" => "V/K_B in the q-axis frame".to_string(),
            name => format!("(V − R I_0)/K_B in the {name} frame"),
        },
    )?;
    let commutation = motor.conventions.commutation;
    let explanation = CurrentConvention::NAMES
        .iter()
        .filter(|(_, c)| {
            *c != motor.conventions.of_torque_constant()
                && commutation == Commutation::Brushless
                && motor.sheet.back_emf_constant.is_none()
        })
        .find_map(|(name, convention)| {
            let k_t = motor.sheet.torque_constant?.value;
            let (k, v) = match convention {
                CurrentConvention::Dc => (k_t, motor.sheet.voltage?.value),
                _ => (k_t * convention.torque_constant(commutation), motor.sheet.voltage?.value / 2.0_f64.sqrt()),
            };
            ((printed / (v / k) - 1.0).abs() < 0.06).then(|| format!("`current = {name}` would make them agree"))
        });
    error(message, explanation)
}

fn mechanical_time_constant(motor: &Motor) -> Option<Outcome> {
    let frame = frame(motor);
    let printed = motor.sheet.mechanical_time_constant?.value;
    let expected = motor.rotor_inertia? * frame.resistance / (frame.torque_constant * frame.back_emf_constant);
    let from = format!("J_m R/(K_T K_B) in the {} frame", frame.name);
    let message = mismatch("mechanical time constant", printed, expected, 0.05, "ms", &from)?;
    let readings = [(2.0, "twice"), (0.5, "half"), (1.5, "3/2 of"), (2.0 / 3.0, "2/3 of")];
    let ratio = printed / expected;
    let explanation = readings
        .iter()
        .find(|(f, _)| (ratio / f - 1.0).abs() < 0.05)
        .map(|(_, name)| format!("it follows with {name} the resistance"));
    error(message, explanation)
}

fn responsiveness(motor: &Motor) -> Option<Outcome> {
    let printed = motor.sheet.responsiveness_metric?.value;
    let expected = motor.rotor_inertia? * motor.resistance / (motor.torque_constant * motor.back_emf_constant);
    let message = mismatch("S_M", printed, expected, 0.03, "ms", "J_m R/(K_T K_B)")?;
    let by_printed = motor.sheet.motor_constant.and_then(|k| Some(motor.rotor_inertia? / k.value.powi(2)));
    let explanation = by_printed.map(|s| {
        let s_ms = number(s * 1e3);
        if (printed / s - 1.0).abs() <= 0.03 {
            format!("it follows from the printed K_M ({s_ms} ms)")
        } else {
            format!("it does not follow from the printed K_M either ({s_ms} ms)")
        }
    });
    error(message, explanation)
}

fn torque_specific_inertia(motor: &Motor) -> Option<Outcome> {
    let printed = motor.sheet.torque_specific_inertia?.value;
    let expected = motor.rotor_inertia? / motor.torque_constant.powi(2);
    error(mismatch("S_T", printed, expected, 0.03, "g*(A/N)^2", "J_m/K_T²")?, None)
}

/// The printed torque constant times a printed current, brought to the constant's convention where it has another.
fn torque_of(motor: &Motor, current: Printed, convention: CurrentConvention) -> Option<f64> {
    let (own, commutation) = (motor.conventions.of_torque_constant(), motor.conventions.commutation);
    let factor =
        if own == convention { 1.0 } else { convention.torque_current(commutation) / own.torque_current(commutation) };
    Some(motor.sheet.torque_constant?.value * current.value * factor)
}

fn peak_torque(motor: &Motor) -> Option<Outcome> {
    let ratio = motor.sheet.peak_torque?.value
        / torque_of(motor, motor.sheet.peak_current?, motor.conventions.of_peak_current())?;
    let share = number(ratio);
    if ratio > 1.03 {
        return error(format!("peak torque is {share} of K_T I_peak: more than the torque constant gives"), None);
    }
    if ratio < 0.55 {
        return error(
            format!("peak torque is {share} of K_T I_peak: less than iron saturation explains"),
            Some("the two may belong to different conventions or durations".into()),
        );
    }
    (ratio < 0.95).then(|| Outcome {
        severity: Severity::Note,
        message: format!("peak torque is {share} of K_T I_peak"),
        explanation: Some("iron saturation".into()),
    })
}

fn continuous_torque(motor: &Motor) -> Option<Outcome> {
    let convention = motor.conventions.of_continuous_current();
    let ratio = motor.sheet.continuous_torque?.value / torque_of(motor, motor.sheet.continuous_current?, convention)?;
    let share = number(ratio);
    let message = format!("continuous torque is {share} of K_T I_continuous");
    if ratio > 1.05 {
        return error(
            message,
            Some(
                "more than the torque constant gives: another current convention, or torque at a gear's output".into(),
            ),
        );
    }
    (ratio < 0.7).then(|| Outcome {
        severity: Severity::Error,
        message,
        explanation: Some("losses at speed explain at most some 30 %".into()),
    })
}

fn electrical_time_constant(motor: &Motor) -> Option<Outcome> {
    let usual = |seconds: f64| (0.02e-3..=20e-3).contains(&seconds);
    let seconds = motor.inductance? / motor.resistance;
    if usual(seconds) || motor.inductance == Some(0.0) {
        return None;
    }
    // L/R cannot say which of the two is wrong.
    let readings = [
        (1e3, "a thousand times more: the inductance may be headed µH for mH, or the resistance ohm for mohm"),
        (1e-3, "a thousandth: the inductance may be headed mH for µH, or the resistance mohm for ohm"),
    ];
    let explanation = readings
        .iter()
        .find(|(factor, _)| usual(seconds * factor))
        .map(|(factor, why)| format!("{why} (L/R would be {} ms)", number(seconds * factor * 1e3)));
    // Terminals are a factor of 2 or 3 at most.
    let of_terminals = || {
        let near = [3.0, 2.0, 0.5, 1.0 / 3.0].iter().any(|factor| usual(seconds * factor));
        near.then(|| "resistance and inductance may be between different terminals (line-to-line, winding)".to_string())
    };
    error(format!("L/R is {} ms: no motor is like that", number(seconds * 1e3)), of_terminals().or(explanation))
}

fn rotor_inertia(motor: &Motor) -> Option<Outcome> {
    let ring = motor.sheet.rotor_mass?.value * motor.sheet.gap_radius?.value.powi(2);
    let ratio = motor.rotor_inertia? / ring;
    if (0.3..=2.0).contains(&ratio) {
        return None;
    }
    error(format!("rotor inertia is {} of the rotor's mass at the gap radius", number(ratio)), None)
}

/// What a motor cannot have: mostly a slip of unit or decimal point. Magnets and insulation bear some 60 to 250 °C; what a sheet calls
/// its largest speed is not far below the speed without load that it states.
fn out_of_range(motor: &Motor) -> Option<Outcome> {
    let celsius = |kelvin: f64| kelvin - 273.15;
    let outside = |value: Option<f64>, low: f64, high: f64| value.filter(|v| !(low..=high).contains(v));
    let winding = outside(motor.sheet.max_winding_temperature.map(|p| celsius(p.value)), 60.0, 250.0);
    if let Some(found) = winding {
        return error(format!("a winding that bears {} degC", number(found)), None);
    }
    if let Some(found) = outside(motor.sheet.reference_temperature.map(|p| celsius(p.value)), -20.0, 155.0) {
        return error(format!("a resistance at {} degC", number(found)), None);
    }
    if let Some(found) = motor.pole_pairs.filter(|pairs| *pairs > 80) {
        return error(format!("{found} pole pairs"), Some("pole pairs are half the number of poles".into()));
    }
    if let Some(found) = outside(motor.sheet.outer_diameter.map(|p| p.value), 2e-3, 1.0) {
        return error(format!("an outer diameter of {} mm", number(1e3 * found)), None);
    }
    let (largest, without_load) = (motor.sheet.max_speed?.value, motor.sheet.no_load_speed?.value);
    (without_load > 1.5 * largest).then(|| Outcome {
        severity: Severity::Error,
        message: format!(
            "the speed without load is {} times the largest speed: one of the two is in another unit or at another voltage",
            number(without_load / largest)
        ),
        explanation: None,
    })
}

/// What only other rows can tell: [`outliers`] and [`twins`] do, over a whole catalogue.
fn beside_others(_: &Motor) -> Option<Outcome> {
    None
}

fn thermal(motor: &Motor) -> Option<Outcome> {
    let (winding, housing) =
        (motor.sheet.thermal_time_constant_winding?.value, motor.sheet.thermal_time_constant_housing?.value);
    if winding <= housing {
        return None;
    }
    error(
        format!(
            "the winding's time constant ({} s) is longer than the housing's ({} s)",
            number(winding),
            number(housing)
        ),
        Some("the two may be swapped".into()),
    )
}

/// How a row declares its conventions, in one line for people.
pub fn conventions_line(motor: &Motor) -> String {
    if motor.inside.is_some() {
        let id = &motor.id;
        return format!(
            "a module, its constants taken to the q axis; `gearwise catalog show {id}` has them as printed"
        );
    }
    let c = &motor.conventions;
    let winding = c.winding.map_or(String::new(), |w| format!(", {}", word(Winding::NAMES, &w)));
    let row = MotorRow::of(motor);
    let own = super::FIELDS.iter().filter_map(|field| {
        let stated = row.states(field).convention?;
        Some(format!(", {} {stated}", field.name))
    });
    let (terminals, current) = (word(Terminals::NAMES, &c.terminals), word(CurrentConvention::NAMES, &c.current));
    format!("{terminals}{winding}, current {current}{}", own.collect::<String>())
}
