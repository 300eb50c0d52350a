//! What only several tests together can say. Each check is one entry of [`CHECKS`].

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use super::estimate::{Combination, combine, discrepancy, motor_constant, motor_constant_slopes};
use super::{Finding, Outcome, Weight, find};
use crate::bench::{Bench, Use};
use gearwise_model::words::number;

/// Weight and words of what a check finds.
pub(crate) type Examine = fn(&Bench, &[Outcome]) -> Option<(Weight, String)>;

/// A check: its code, what it compares, and what it finds; nothing where the bench has not what it needs.
pub struct Check {
    /// Its name.
    pub code: &'static str,
    /// What it compares.
    pub compares: &'static str,
    /// Examines.
    pub run: Examine,
}

/// Every check.
pub const CHECKS: &[Check] = &[
    Check { code: "torque_against_back_emf", compares: "K_T against K_B", run: torque_against_back_emf },
    Check { code: "motor_constant", compares: "electrical against mechanical K_M", run: motor_constants },
    Check { code: "declared", compares: "what was measured against the declared motor", run: declared },
    Check { code: "held_out", compares: "logs that were left alone", run: held_out },
];

/// Runs every check.
pub fn run(bench: &Bench, outcomes: &[Outcome]) -> Vec<Finding> {
    CHECKS
        .iter()
        .filter_map(|check| (check.run)(bench, outcomes).map(|(weight, text)| Finding::new(check.code, weight, text)))
        .collect()
}

/// What a wrong convention of current or voltage makes of K_T/K_B.
const CONVENTIONS: &[(f64, &str)] = &[
    (1.224_745, "√(3/2): a current of phase amplitude, or a voltage of the phase's peak, may be taken for q axis"),
    (0.816_497, "√(2/3): a q-axis current may be taken for phase amplitude"),
    (1.732_051, "√3: an rms current, or the phase's rms voltage, may be taken for q axis"),
    (0.577_350, "1/√3: a q-axis current may be taken for rms"),
    (SQRT_2, "√2: an rms current may be taken for amplitude, or an rms voltage for peak"),
    (FRAC_1_SQRT_2, "1/√2: an amplitude of current may be taken for rms, or a peak voltage for rms"),
    (1.350_475, "1.35: the DC ampere of block commutation may be taken for q axis"),
    (0.740_480, "0.74: a q-axis current may be taken for the DC ampere of block commutation"),
];

fn torque_against_back_emf(_: &Bench, outcomes: &[Outcome]) -> Option<(Weight, String)> {
    let (torque, back_emf) = match (find(outcomes, "torque_constant"), find(outcomes, "back_emf_constant")) {
        (Some(torque), Some(back_emf)) => (torque, back_emf),
        (None, None) => return None,
        (only, _) => {
            let (here, other, what) = if only.is_some() {
                (
                    "K_T",
                    "backdrive",
                    "convention and gain of the current, gain of the torque sensor, columns that are swapped",
                )
            } else {
                ("K_B", "stall", "convention of the voltage, columns that are swapped")
            };
            let text = format!("nothing checks {here} ({what}): a `{other}` test of the same motor would");
            return Some((Weight::Note, text));
        }
    };
    let off = discrepancy(torque, back_emf);
    let percent = |x: f64| number((1000.0 * x).round() / 10.0);
    let text = format!("K_T is {} ± {} % off K_B (95 %)", percent(off.value), percent(off.half_width()));
    if off.value.abs() <= off.half_width() {
        return Some((Weight::Good, format!("{text}: alike within their ±, as of an ideal machine")));
    }
    let ratio = 1.0 + off.value;
    let near = CONVENTIONS.iter().find(|(f, _)| (ratio / f - 1.0).abs() < off.half_width().clamp(0.01, 0.05));
    let why = match near {
        Some((_, why)) => format!("their ratio is near {why}"),
        None if off.value > 0.0 => {
            "a machine with K_T > K_B would make energy: torque sensor, current, or a back-EMF that is no sine"
                .to_string()
        }
        None => "saturation, warm magnets at the stall test, or friction in the torque".to_string(),
    };
    Some((Weight::Warning, format!("{text}, beyond their ±; {why}")))
}

fn motor_constants(_: &Bench, outcomes: &[Outcome]) -> Option<(Weight, String)> {
    let (torque, back_emf, resistance) =
        (find(outcomes, "torque_constant")?, find(outcomes, "back_emf_constant")?, find(outcomes, "resistance")?);
    let both = motor_constant(torque, back_emf, resistance);
    let mechanical = motor_constant(torque, torque, resistance).value;
    let electrical = motor_constant(back_emf, back_emf, resistance).value;
    let slopes = motor_constant_slopes(torque.value, back_emf.value, resistance.value);
    let parts: Vec<(f64, f64)> =
        slopes.into_iter().zip([torque.half_width(), back_emf.half_width(), resistance.half_width()]).collect();
    let apart = mechanical / electrical - 1.0;
    let weight = if apart.abs() > 0.1 { Weight::Warning } else { Weight::Good };
    Some((
        weight,
        format!(
            "√(K_T K_B/R) = {} N*m/W^0.5 (± {} by root sum square, {} by linear sum); mechanical, K_T/√R, {}; electrical, \
             K_B/√R, {}; {} % apart",
            number(both.value),
            format_args!("{:.1e}", combine(Combination::RootSumSquare, &parts)),
            format_args!("{:.1e}", combine(Combination::Linear, &parts)),
            number(mechanical),
            number(electrical),
            number((1000.0 * apart).round() / 10.0)
        ),
    ))
}

fn declared(bench: &Bench, outcomes: &[Outcome]) -> Option<(Weight, String)> {
    let motor = bench.declared.motor.as_ref()?;
    let known = [
        ("resistance", Some(motor.resistance)),
        ("inductance", motor.inductance),
        ("torque_constant", Some(motor.torque_constant)),
        ("back_emf_constant", Some(motor.back_emf_constant)),
        ("rotor_inertia", motor.rotor_inertia),
    ];
    let mut said = Vec::new();
    let mut beyond = false;
    for (name, declared) in known {
        let (Some(declared), Some(measured)) = (declared, find(outcomes, name)) else { continue };
        let off = measured.value / declared - 1.0;
        let far = (measured.value - declared).abs() > measured.half_width() && off.abs() > 0.02;
        beyond |= off.abs() > 0.1 && far;
        let mark = if far { ", beyond its ±" } else { "" };
        said.push(format!("{name} {} %{mark}", number((1000.0 * off).round() / 10.0)));
    }
    (!said.is_empty()).then(|| {
        let weight = if beyond { Weight::Warning } else { Weight::Note };
        (weight, format!("measured against the row of `{}`: {}", motor.id, said.join("; ")))
    })
}

fn held_out(bench: &Bench, _: &[Outcome]) -> Option<(Weight, String)> {
    let names: Vec<&str> = bench.logs.iter().filter(|l| l.usage == Use::HeldOut).map(|l| l.name.as_str()).collect();
    (!names.is_empty()).then(|| (Weight::Note, format!("held out, and left alone here: {}", names.join(", "))))
}
