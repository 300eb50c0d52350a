//! The smaller parts of the model against numbers that follow on paper: closed forms, identities and limits at
//! boundaries.

use std::f64::consts::PI;
use std::sync::Arc;

use approx::assert_relative_eq;
use gearwise::actuator::envelope::Steady;
use gearwise::actuator::fitted::{self, Shortfall};
use gearwise::actuator::limits::{Asked, Candidate, Check, Class, Demand, LIMITS};
use gearwise::actuator::metrics::{Estimate, METRICS, at_matched_inertia, metric};
use gearwise::actuator::shaft::Flow;
use gearwise::actuator::step_response::{simulate, simulate_and_watch};
use gearwise::actuator::supply::Drawn;
use gearwise::actuator::thermal_motion::{Heat, TwoNode};
use gearwise::actuator::waveform::Functional;
use gearwise::actuator::{Actuator, Laurent, Load};
use gearwise::catalog::convention::*;
use gearwise::catalog::fitted::FittedGear;
use gearwise::catalog::{Catalog, Motor, Printed};
use gearwise::design::Mount;
use gearwise::effects::FittedEffect;
use gearwise::input::Source;
use gearwise::requirement::*;

use crate::raw::{self, draw};

/// A motor on the q axis, with further columns.
fn motor(columns: &str, row: &str) -> Motor {
    let text = format!(
        "id,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A]{columns}\n\
         m,-,derived,q_axis,q_axis,0.5,0.1{row}\n"
    );
    Catalog::from_sources(vec![Arc::new(Source::new("motor.csv", text.as_str()))]).unwrap().motors.remove(0)
}

fn printed(value: f64, tolerance: Option<f64>) -> Option<Printed> {
    Some(Printed { value, tolerance })
}

#[test]
fn every_convention_is_read_by_the_word_that_it_is_written_with() {
    fn all<T: PartialEq>(names: &[(&'static str, T)]) {
        for (name, value) in names {
            assert_eq!(word(names, value), *name);
        }
    }
    all(CurrentConvention::NAMES);
    all(BackEmfConvention::NAMES);
    all(SpeedConstantConvention::NAMES);
    all(Terminals::NAMES);
    all(Winding::NAMES);
    all(Commutation::NAMES);
    all(Modulation::NAMES);
    assert_eq!(word(&Terminals::NAMES[..1], &Terminals::QAxis), "");
}

#[test]
fn a_tolerance_is_relative_to_the_size_of_its_number() {
    let relative = |value, tolerance| printed(value, tolerance).unwrap().relative_tolerance();
    assert_eq!(relative(4.0, Some(0.5)), Some(0.125));
    assert_eq!(relative(-4.0, Some(0.5)), Some(0.125));
    assert_eq!(relative(4.0, None), None);
    assert_eq!(relative(0.0, Some(0.5)), None);
}

/// `L i' = V − R i − K_B ω`, `J ω' = K_T i`: with `τ_e = L/R` and `τ_m = J R/(K_T K_B)` the speed over its final
/// value is `1 − e^(−t/2τ_e)(cos βt + sin βt/(2 τ_e β))`, `β² = 1/(τ_e τ_m) − 1/(2 τ_e)²`, with hyperbolic functions
/// where that is negative.
#[test]
fn a_voltage_step_is_answered_as_the_closed_form_says() {
    let mut motor = motor(",rotor_inertia [kg*m^2]", ",2e-5");
    motor.back_emf_constant = 0.08;
    let mechanical = 2e-5 * 0.5 / (0.1 * 0.08);
    for share in [0.0, 5e-5, 1e-3, 0.05, 0.2, 0.3, 1.0, 4.0, 20.0] {
        let electrical = share * mechanical;
        let speed = |t: f64| {
            if share < 1e-4 {
                return 1.0 - (-t / mechanical).exp();
            }
            let decay = 0.5 / electrical;
            let square = 1.0 / (electrical * mechanical) - decay * decay;
            let b = square.abs().sqrt();
            if square > 0.0 {
                1.0 - (-decay * t).exp() * ((b * t).cos() + decay / b * (b * t).sin())
            } else {
                // Two decaying exponentials, written without overflow.
                let (fast, slow) = (decay + b, decay - b);
                1.0 - (fast * (-slow * t).exp() - slow * (-fast * t).exp()) / (2.0 * b)
            }
        };
        let (mut worst, mut last, mut steps) = (0.0_f64, 0.0, 0);
        let response = simulate_and_watch(&motor, electrical * 0.5, &mut |t, w| {
            worst = worst.max((w - speed(t)).abs());
            assert!(t > last);
            (last, steps) = (t, steps + 1);
        })
        .unwrap();
        assert_eq!(simulate(&motor, electrical * 0.5), Some(response));
        assert!(worst < 2e-7, "{share}: {worst}");
        // Watched until all has died away, in steps that are fine against the faster of the two.
        let end = 12.0 * mechanical.max(4.0 * electrical);
        let fastest = if share < 1e-4 { mechanical } else { electrical.min(mechanical) };
        assert!(last >= end * (1.0 - 1e-9) && last < end + fastest / 100.0, "{share}: {last} {end}");
        assert_relative_eq!(last / f64::from(steps), fastest / 200.0, max_relative = 1e-9);
        let level = 1.0 - (-1.0_f64).exp();
        let mut bracket = (0.0, 3.0 * (mechanical + electrical));
        // Rises without a turn up to the level.
        for _ in 0..80 {
            let middle = 0.5 * (bracket.0 + bracket.1);
            if (0..=200).any(|k| speed(middle * f64::from(k) / 200.0) >= level) {
                bracket.1 = middle;
            } else {
                bracket.0 = middle;
            }
        }
        assert_relative_eq!(response.rise_time, bracket.1, max_relative = 1e-4);
        let zeta = 0.5 / share.sqrt();
        let overshoot = if zeta < 1.0 { (-PI * zeta / (1.0 - zeta * zeta).sqrt()).exp() } else { 0.0 };
        assert!((response.overshoot - overshoot).abs() < 2e-5, "{share}: {} {overshoot}", response.overshoot);
    }
    motor.rotor_inertia = None;
    assert_eq!(simulate(&motor, 0.0), None);
}

/// Tolerances: worst case the sum of `|exponent| · ±`, independent the root of the sum of squares.
#[test]
fn metrics_inherit_the_tolerances_of_their_parameters() {
    let mut motor = motor(",rotor_inertia [kg*m^2],mass [kg]", ",2e-5,0.4");
    motor.sheet.resistance = printed(0.5, Some(0.025));
    motor.sheet.torque_constant = printed(0.1, Some(0.002));
    motor.sheet.rotor_inertia = printed(2e-5, Some(2e-6));
    let of = |motor: &Motor, name: &str| metric(name).unwrap().of(motor).unwrap();
    // K_B was taken from K_T: S_M = J R/K_T².
    let s_m = of(&motor, "s_m");
    assert_relative_eq!(s_m.value, 2e-5 * 0.5 / 0.01, max_relative = 1e-12);
    assert_relative_eq!(s_m.worst_case.unwrap(), 0.1 + 0.05 + 2.0 * 0.02, max_relative = 1e-12);
    assert_relative_eq!(s_m.independent.unwrap(), (0.01_f64 + 0.0025 + 0.0016).sqrt(), max_relative = 1e-12);
    assert!(s_m.complete);
    // K_M = √(K_T K_B/R) = K_T/√R: its K_T counts once.
    let k_m = of(&motor, "k_m");
    assert_relative_eq!(k_m.worst_case.unwrap(), 0.02 + 0.025, max_relative = 1e-12);
    // A back-EMF constant of its own has an error of its own.
    motor.back_emf_constant = 0.08;
    motor.sheet.back_emf_constant = printed(0.08, Some(0.0024));
    let s_m = of(&motor, "s_m");
    assert_relative_eq!(s_m.value, 2e-5 * 0.5 / 0.008, max_relative = 1e-12);
    assert_relative_eq!(s_m.worst_case.unwrap(), 0.1 + 0.05 + 0.02 + 0.03, max_relative = 1e-12);
    assert_relative_eq!(s_m.independent.unwrap(), (0.01_f64 + 0.0025 + 0.0004 + 0.0009).sqrt(), max_relative = 1e-12);
    // Without a ± for the mass, m·S_M is not complete; a default fills the gap.
    let weighted = of(&motor, "mass_s_m");
    assert!(!weighted.complete);
    assert_relative_eq!(weighted.value, 0.4 * s_m.value, max_relative = 1e-12);
    assert_eq!((weighted.worst_case, weighted.independent), (s_m.worst_case, s_m.independent));
    let filled = metric("mass_s_m").unwrap().of_with_tolerance(&motor, Some(0.2)).unwrap();
    assert!(filled.complete);
    assert_relative_eq!(filled.worst_case.unwrap(), 0.4, max_relative = 1e-12);
    // Nothing known of any: no tolerance at all, and not complete.
    let gap = motor_with_gap();
    let radius = of(&gap, "gap_radius");
    assert_eq!((radius.value, radius.worst_case, radius.independent, radius.complete), (0.03, None, None, false));
    assert!(metric("k_ts").unwrap().of(&motor).is_none() && metric("gap_radius").unwrap().of(&motor).is_none());
    // K_ts = K_T/m √(1/((R_wh + R_ha) R)): the two resistances add, so do their squared ±.
    motor.sheet.mass = printed(0.4, Some(0.004));
    motor.sheet.thermal_resistance_winding_housing = printed(1.0, Some(0.3));
    motor.sheet.thermal_resistance_housing_ambient = printed(4.0, Some(0.4));
    let k_ts = of(&motor, "k_ts");
    assert_relative_eq!(k_ts.value, 0.1 / 0.4 / (5.0_f64 * 0.5).sqrt(), max_relative = 1e-12);
    assert_relative_eq!(k_ts.worst_case.unwrap(), 0.02 + 0.01 + 0.5 * 0.1 + 0.5 * 0.05, max_relative = 1e-12);
    assert!(k_ts.complete);
    motor.sheet.thermal_resistance_housing_ambient = printed(4.0, None);
    assert!(!of(&motor, "k_ts").complete);
}

fn motor_with_gap() -> Motor {
    motor(",gap_radius [mm]", ",30")
}

#[test]
fn metrics_are_written_as_they_are_computed() {
    let formula = |name: &str| metric(name).unwrap().formula();
    assert_eq!(formula("s_m"), "J_m R/(K_T K_B)");
    assert_eq!(formula("s_t"), "J_m/K_T²");
    assert_eq!(formula("mass_s_m"), "m J_m R/(K_T K_B)");
    assert_eq!(formula("k_m"), "√(K_T K_B/R)");
    assert_eq!(formula("k_t"), "K_T");
    assert_eq!(formula("k_t_per_mass"), "K_T/m");
    assert_eq!(formula("k_ts"), "K_T/(m √R_th √R)");
    assert_eq!(formula("electrical_time_constant"), "L/R");
    assert!(metric("s_mm").is_none() && METRICS.iter().all(|m| metric(m.name).unwrap().meaning == m.meaning));
}

/// `Φ(1) = 0.841345`: a lead of one standard deviation; ± are two of them.
#[test]
fn how_sure_it_is_that_one_motor_is_ahead() {
    let estimate = |value: f64, independent: f64| Estimate {
        value,
        worst_case: Some(independent),
        independent: Some(independent),
        complete: true,
    };
    let (lower, higher) = (metric("s_m").unwrap(), metric("k_m").unwrap());
    // 0.06/2 and 0.08/2 make 0.05.
    let (a, b) = (estimate(1.0, 0.06), estimate(0.05_f64.exp(), 0.08));
    assert_relative_eq!(lower.probability_ahead(&a, &b).unwrap(), 0.841_344_746, max_relative = 1e-8);
    assert_relative_eq!(lower.probability_ahead(&b, &a).unwrap(), 0.158_655_254, max_relative = 1e-8);
    assert_relative_eq!(higher.probability_ahead(&a, &b).unwrap(), 0.158_655_254, max_relative = 1e-8);
    assert_relative_eq!(lower.probability_ahead(&a, &a).unwrap(), 0.5, max_relative = 1e-12);
    // Without any ± the better one is ahead, and equal ones are even.
    let (exact, worse) = (estimate(1.0, 0.0), estimate(2.0, 0.0));
    assert_eq!(lower.probability_ahead(&exact, &worse), Some(1.0));
    assert_eq!(lower.probability_ahead(&worse, &exact), Some(0.0));
    assert_eq!(higher.probability_ahead(&worse, &exact), Some(1.0));
    assert_eq!(lower.probability_ahead(&exact, &exact), Some(0.5));
    // Nothing is said where a ± is missing or a value is no size.
    for unknown in
        [Estimate { complete: false, ..a }, Estimate { value: 0.0, ..a }, Estimate { independent: None, ..a }]
    {
        assert_eq!(lower.probability_ahead(&unknown, &b), None);
        assert_eq!(lower.probability_ahead(&b, &unknown), None);
    }
}

#[test]
fn motors_at_matched_inertia() {
    let mut motor = motor(",rotor_inertia [kg*m^2]", ",2e-5");
    motor.back_emf_constant = 0.08;
    let matched = at_matched_inertia(&motor, 1.8e-3).unwrap();
    // N² J = 1.8e-3 kg·m²: N = √90; K_M = √(0.1 · 0.08/0.5).
    assert_relative_eq!(matched.ratio, 90.0_f64.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(matched.torque_constant, 0.1 * 90.0_f64.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(matched.motor_constant, (90.0_f64 * 0.016).sqrt(), max_relative = 1e-12);
    motor.rotor_inertia = None;
    assert_eq!(at_matched_inertia(&motor, 1.8e-3), None);
}

/// Sums, products, squares, slopes and the form in N² against plain powers.
#[test]
fn laurent_polynomials_are_what_they_say() {
    let c = [0.7, -1.3, 0.4, 2.1, -0.6, 0.9, 0.2];
    let make =
        |c: &[f64]| c.iter().zip(-2..).map(|(c, p)| Laurent::monomial(*c, p)).fold(Laurent::default(), |a, b| a + b);
    let p = make(&c);
    for n in [0.3_f64, 1.0, 2.5] {
        let plain: f64 = c.iter().zip(-2..).map(|(c, p)| c * n.powi(p)).sum();
        let slope: f64 = c.iter().zip(-2..).map(|(c, p)| f64::from(p) * c * n.powi(p - 1)).sum();
        let size: f64 = c.iter().zip(-2..).map(|(c, p)| c.abs() * n.powi(p)).sum();
        assert_relative_eq!(p.at(n), plain, max_relative = 1e-13);
        assert_relative_eq!(p.slope(n), slope, max_relative = 1e-13);
        assert_relative_eq!(p.size(n), size, max_relative = 1e-13);
        assert_relative_eq!((p * -3.0).at(n), -3.0 * plain, max_relative = 1e-13);
        let (small, other) = (make(&[0.0, -1.3, 0.4, 2.1]), make(&[0.0, 0.8, -0.2, 0.0, 0.5]));
        assert_relative_eq!((small * other).at(n), small.at(n) * other.at(n), max_relative = 1e-12);
        assert_relative_eq!(small.squared().at(n), small.at(n).powi(2), max_relative = 1e-12);
        assert_relative_eq!(Laurent::constant(4.0).at(n), 4.0);
    }
    for (k, power) in (-2..=4).enumerate() {
        assert_eq!(p[power], c[k]);
    }
    // Convex in u = N²: even powers only, with the first and the last not negative.
    let even = [2.0, 0.0, -3.0, 0.0, -1.0, 0.0, 4.0];
    assert!(make(&even).is_convex_in_square());
    assert_eq!(make(&even).in_square(), [2.0, -3.0, -1.0, 4.0]);
    for (place, value) in [(0, -1e-9), (1, 1e-9), (3, -1e-9), (5, 1e-9), (6, -1e-9)] {
        let mut spoilt = even;
        spoilt[place] = value;
        assert!(!make(&spoilt).is_convex_in_square(), "{place}");
        if place % 2 == 1 {
            assert!(std::panic::catch_unwind(|| make(&spoilt).in_square()).is_err(), "{place}");
        }
    }
    for place in [0, 6] {
        let mut zero = even;
        zero[place] = 0.0;
        assert!(make(&zero).is_convex_in_square());
    }
}

fn with(motor: &Motor, effects: &[(&str, &[f64])]) -> Motor {
    let effects = effects.iter().map(|(name, v)| FittedEffect::new(name, v.to_vec()).unwrap()).collect();
    Motor { effects, ..motor.clone() }
}

#[test]
fn fitted_effects_need_their_own_number_of_values() {
    assert!(FittedEffect::new("coulomb_friction", vec![1.0]).is_some());
    assert!(FittedEffect::new("coulomb_friction", vec![1.0, 2.0]).is_none());
    assert!(FittedEffect::new("coulomb_frictions", vec![1.0]).is_none());
    let new = |name: &str, value: f64| FittedEffect::new(name, vec![value]).unwrap();
    assert_eq!(new("coulomb_friction", 1.0), new("coulomb_friction", 1.0));
    assert_ne!(new("coulomb_friction", 1.0), new("coulomb_friction", 2.0));
    assert_ne!(new("coulomb_friction", 1.0), new("viscous_friction", 1.0));
    assert_eq!(format!("{:?}", new("coulomb_friction", 1.5)), "coulomb_friction [1.5]");
}

/// `T = K_T i − k (i − i_s tanh(i/i_s))`, ripple that adds to what is asked, ripple that takes a share.
#[test]
fn torque_current_and_heat_of_a_fitted_motor_agree_with_each_other() {
    let k_t = 0.1;
    let motor = motor(",peak_current [A]", ",40");
    let curve = |i: f64, k: f64, at: f64| k_t * i - k * (i - at * (i / at).tanh());
    // Amplitudes √(0.003² + 0.004²) = 0.005 and 0.013 N·m; 0.005 of 0.1 N·m/A.
    let ripple: (&str, &[f64]) = ("cogging", &[0.003, -0.004, 12.0]);
    let gear: (&str, &[f64]) = ("gear_ripple", &[0.005, 0.012, 3.0]);
    let share: (&str, &[f64]) = ("torque_ripple", &[0.003, 0.004, 6.0]);
    let iron: (&str, &[f64]) = ("torque_constant_saturation", &[0.08, 15.0]);
    let none = Shortfall::new(&motor, k_t, true);
    assert!(none.is_nothing() && none == Shortfall::none(k_t));
    assert_eq!((none.left_of_torque(3.0, 1.5), none.left_of_current(7.0, 1.5), none.voltage), (3.0, 7.0, 0.0));
    assert_relative_eq!(none.peak_current(0.6), 6.0, max_relative = 1e-14);
    assert_relative_eq!(none.peak_current_slope(0.6), 10.0, max_relative = 1e-14);
    assert_eq!((none.mean_square(), none.heat_factor(), none.saturates()), (0.0, 1.0, false));
    let heat = (1.0_f64 - 0.0025).powf(-1.5);
    for (effects, amplitude, square, r, factor, saturated) in [
        (vec![ripple], 0.005, 12.5e-6, 0.0, 1.0, false),
        (vec![ripple, gear], 0.018, 12.5e-6 + 84.5e-6, 0.0, 1.0, false),
        (vec![share], 0.0, 0.0, 0.05, heat, false),
        (vec![ripple, share], 0.005, 12.5e-6, 0.05, heat, false),
        (vec![share, share], 0.0, 0.0, 0.1, (1.0_f64 - 0.005).powf(-1.5), false),
        (vec![iron], 0.0, 0.0, 0.0, 1.0, true),
        (vec![ripple, gear, share, iron], 0.018, 12.5e-6 + 84.5e-6, 0.05, heat, true),
    ] {
        let shortfall = Shortfall::new(&with(&motor, &effects), k_t, true);
        assert!(!shortfall.is_nothing());
        assert_eq!(shortfall.saturates(), saturated);
        assert_relative_eq!(shortfall.mean_square(), square, max_relative = 1e-12);
        assert_relative_eq!(shortfall.heat_factor(), factor, max_relative = 1e-12);
        let torque_of = |i: f64| if saturated { curve(i, 0.08, 15.0) } else { k_t * i };
        for safety in [1.0, 1.3] {
            // What remains of a torque or a current for the motion, and never less than nothing.
            let left = |torque: f64| (torque * (1.0 - r) - safety * amplitude).max(0.0);
            for torque in [0.001, 0.02, 1.5] {
                assert_relative_eq!(shortfall.left_of_torque(torque, safety), left(torque), max_relative = 1e-12);
            }
            for i in [0.01, 3.0, 20.0, 39.0] {
                let expected = left(torque_of(i)) / k_t;
                assert_relative_eq!(shortfall.left_of_current(i, safety), expected, max_relative = 1e-12);
            }
        }
        for i in [0.7, 5.0, 20.0, 38.0] {
            // A current makes its torque, less the share that ripples, less the ripple.
            let torque = torque_of(i) * (1.0 - r) - amplitude;
            assert_relative_eq!(shortfall.peak_current(torque), i, max_relative = 1e-10);
            let h = 1e-5 * torque;
            let slope = (shortfall.peak_current(torque + h) - shortfall.peak_current(torque - h)) / (2.0 * h);
            assert_relative_eq!(shortfall.peak_current_slope(torque), slope, max_relative = 1e-7);
            // Heat: the current of the root of the mean square.
            let squared = torque_of(i).powi(2) / factor - square;
            let (current_squared, slope) = shortfall.current_squared(squared);
            assert_relative_eq!(current_squared, i * i, max_relative = 1e-10);
            let h = 1e-5 * squared;
            let by = (shortfall.current_squared(squared + h).0 - shortfall.current_squared(squared - h).0) / (2.0 * h);
            assert_relative_eq!(slope, by, max_relative = 1e-7);
        }
        let (_, slope) = shortfall.current_squared(-square);
        assert_relative_eq!(slope, factor / (k_t * k_t), max_relative = 1e-12);
    }
    // Ripple of the gear counts only where the gear is the one that was fitted.
    assert!(Shortfall::new(&with(&motor, &[gear]), k_t, false).is_nothing());
    // Dead time takes voltage, and no current.
    let dead = Shortfall::new(
        &with(&motor, &[("inverter_dead_time", &[0.7, 0.1]), ("inverter_dead_time", &[0.2, 0.1])]),
        k_t,
        true,
    );
    assert_relative_eq!(dead.voltage, 0.9, max_relative = 1e-12);
    assert_eq!((dead.left_of_current(7.0, 2.0), dead.is_nothing()), (7.0, false));
    // Iron that does not saturate is no saturation.
    assert!(Shortfall::new(&with(&motor, &[("torque_constant_saturation", &[0.0, 15.0])]), k_t, true).is_nothing());
    // Ripple as large as the torque itself leaves none, and heats without end.
    let all = Shortfall::new(&with(&motor, &[("torque_ripple", &[0.0, 0.1, 6.0])]), k_t, true);
    assert_eq!(
        (all.left_of_torque(1.0, 1.0), all.heat_factor(), all.peak_current(1.0)),
        (0.0, f64::INFINITY, f64::INFINITY)
    );
}

/// Beyond the largest torque of iron that gives no more, the squared current goes on as its tangent in T².
#[test]
fn beyond_saturation_heat_goes_on_straight() {
    let (k_t, k, at) = (0.1, 0.1, 2.0);
    let motor = motor("", "");
    let shortfall = Shortfall::new(&with(&motor, &[("torque_constant_saturation", &[k, at])]), k_t, true);
    // dT/di = K_T − k tanh²(i/i_s) falls to a hundredth of K_T here.
    let last = at * 0.99_f64.sqrt().atanh();
    let end = k_t * last - k * (last - at * (last / at).tanh());
    assert_relative_eq!(shortfall.current_squared(end * end).0, last * last, max_relative = 1e-9);
    assert_relative_eq!(shortfall.left_of_current(100.0, 1.0), end / k_t, max_relative = 1e-12);
    assert_relative_eq!(shortfall.left_of_current(last, 1.0), end / k_t, max_relative = 1e-12);
    // d(i²)/d(T²) = i/(T dT/di) at the end.
    let slope = last / (end * 0.01 * k_t);
    for factor in [1.01, 2.0, 30.0] {
        let squared = factor * end * end;
        let (heat, rate) = shortfall.current_squared(squared);
        assert_relative_eq!(heat, last * last + slope * (squared - end * end), max_relative = 1e-8);
        assert_relative_eq!(rate, slope, max_relative = 1e-8);
        assert_relative_eq!(shortfall.peak_current(squared.sqrt()), heat.sqrt(), max_relative = 1e-12);
    }
}

#[test]
fn hot_magnets_and_fitted_gears() {
    let mut motor = motor("", "");
    motor.reference_temperature = 300.0;
    assert_eq!(fitted::hot_torque_constant(&motor, Some(400.0)), 0.1);
    let weak = with(&motor, &[("torque_constant_temperature", &[2e-4]), ("torque_constant_temperature", &[1e-4])]);
    assert_relative_eq!(fitted::hot_torque_constant(&weak, Some(400.0)), 0.1 - 0.03, max_relative = 1e-12);
    assert_eq!(fitted::hot_torque_constant(&weak, None), 0.1);
    assert_eq!(fitted::hot_torque_constant(&weak, Some(280.0)), 0.1);
    // A hundredth is left of a magnet that would be gone.
    assert_relative_eq!(fitted::hot_torque_constant(&weak, Some(1000.0)), 0.001, max_relative = 1e-12);
    let gear = GearModel { efficiency: 0.8, backdrive_efficiency: 0.7, inertia: 1e-6, ..GearModel::IDEAL };
    assert_eq!(fitted::gear_with_fit(&motor, &gear), gear);
    // 1/η = 1 + γ, η_b = 1 − γ for a gear of which nothing else is known.
    let rubs = with(&motor, &[("load_dependent_friction", &[0.2]), ("load_dependent_friction", &[0.05])]);
    let found = fitted::gear_with_fit(&rubs, &gear);
    assert_relative_eq!(found.efficiency, 0.8, max_relative = 1e-12);
    assert_relative_eq!(found.backdrive_efficiency, 0.75, max_relative = 1e-12);
    assert_eq!(found.inertia, 1e-6);
    // Fitted numbers replace the requirement's, and γ comes on top.
    let own = FittedGear { efficiency: Some(0.9), backdrive_efficiency: Some(0.85), inertia: Some(3e-6), ratio: None };
    let found = fitted::gear_with_fit(&Motor { fitted_gear: Some(own), ..rubs.clone() }, &gear);
    assert_relative_eq!(found.efficiency, 1.0 / (1.0 / 0.9 + 0.25), max_relative = 1e-12);
    assert_relative_eq!(found.backdrive_efficiency, 0.6, max_relative = 1e-12);
    assert_eq!(found.inertia, 3e-6);
    // η_b = 2 − 1/η where it is not said.
    let half = FittedGear { backdrive_efficiency: None, inertia: None, ..own };
    let found = fitted::gear_with_fit(&Motor { fitted_gear: Some(half), ..motor.clone() }, &gear);
    assert_relative_eq!(found.backdrive_efficiency, 2.0 - 1.0 / 0.9, max_relative = 1e-12);
    assert_relative_eq!(found.efficiency, 0.9, max_relative = 1e-12);
    assert_eq!(found.inertia, 1e-6);
    let back = FittedGear { efficiency: None, inertia: None, ..own };
    let found = fitted::gear_with_fit(&Motor { fitted_gear: Some(back), ..motor.clone() }, &gear);
    assert_eq!((found.efficiency, found.backdrive_efficiency), (0.8, 0.85));
}

#[test]
fn what_was_fitted_is_said_with_how_it_enters() {
    let case = draw(0, true);
    let mut joint = case.robot.joints[0].clone();
    let plain = motor("", "");
    assert!(fitted::notes(&plain, &joint, None).is_empty());
    let every = with(
        &plain,
        &[
            ("load_dependent_friction", &[0.2]),
            ("gear_ripple", &[0.01, 0.0, 3.0]),
            ("torque_constant_temperature", &[1e-4]),
            ("torque_constant_saturation", &[0.05, 15.0]),
            ("cogging", &[0.01, 0.0, 12.0]),
            ("cogging", &[0.02, 0.0, 6.0]),
            ("inverter_dead_time", &[0.5, 0.1]),
            ("stribeck_friction", &[0.01, 5.0]),
            ("eddy_drag", &[0.01, 50.0]),
            ("supply_sag", &[0.1]),
            ("coulomb_friction", &[0.01]),
        ],
    );
    let said = |joint: &Joint, hottest: Option<f64>| -> Vec<(&'static str, String)> {
        fitted::notes(&every, joint, hottest).into_iter().map(|n| (n.effect, n.how)).collect()
    };
    let all = said(&joint, Some(400.0));
    let names: Vec<&str> = all.iter().map(|n| n.0).collect();
    assert_eq!(names.iter().filter(|n| **n == "cogging").count(), 1, "{names:?}");
    let how = |list: &[(&str, String)], name: &str| list.iter().find(|n| n.0 == name).unwrap().1.clone();
    for (name, words) in [
        ("load_dependent_friction", "efficiency"),
        ("gear_ripple", "by its amplitude"),
        ("torque_constant_temperature", "at the highest allowed winding temperature"),
        ("torque_constant_saturation", "at every instant"),
        ("cogging", "by its amplitude"),
        ("inverter_dead_time", "lowers the available voltage"),
        ("stribeck_friction", "is evaluated"),
        ("supply_sag", "does not enter the limits:"),
        ("coulomb_friction", "enters torque and voltage at every instant"),
        ("gear", "is the fitted one: efficiency"),
    ] {
        assert!(how(&all, name).contains(words), "{name}: {}", how(&all, name));
    }
    assert!(!how(&all, "coulomb_friction").contains(';'));
    assert!(how(&said(&joint, None), "torque_constant_temperature").contains("no highest temperature is known"));
    // Gears of the catalogue are other gears than that of the bench.
    joint.ratio = RatioChoice::gears(vec!["*".into()], EfficiencyCovers::Load);
    let listed = said(&joint, Some(400.0));
    for name in ["load_dependent_friction", "gear_ripple"] {
        assert!(how(&listed, name).contains("belongs to the gear that was on the bench"));
    }
    assert!(listed.iter().all(|n| n.0 != "gear"));
    let with_gear =
        Motor { fitted_gear: Some(FittedGear { efficiency: Some(0.9), ..FittedGear::default() }), ..every.clone() };
    assert!(
        fitted::notes(&with_gear, &joint, None).iter().any(|n| n.effect == "gear" && n.how.contains("is not used"))
    );
    for (effects, why) in [
        (vec![("stribeck_friction", [0.01, 5.0].as_slice())], "stribeck_friction is evaluated on a grid of ratios"),
        (vec![("eddy_drag", [0.01, 5.0].as_slice())], "eddy_drag is evaluated on a grid of ratios"),
        (
            vec![("eddy_drag", [0.01, 5.0].as_slice()), ("stribeck_friction", [0.01, 5.0].as_slice())],
            "eddy_drag and stribeck_friction are evaluated on a grid of ratios",
        ),
        (vec![("coulomb_friction", [0.01].as_slice())], ""),
    ] {
        assert_eq!(fitted::why_evaluated(&with(&plain, &effects)), why);
    }
}

/// Which ratios a limit leaves, whose it is, and what a margin is.
#[test]
fn limits_say_whose_they_are_and_what_is_left() {
    let mut case = draw(3, true);
    let at = |case: &raw::Case, name: &str| -> Option<Asked> {
        let joint = &case.robot.joints[0];
        let load = Load::new(&joint.motion, joint.ripple());
        let candidate = Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap();
        let limit = LIMITS.iter().find(|l| l.name == name).unwrap();
        match limit.check(&candidate) {
            Check::Asked(asked) => Some(asked),
            _ => None,
        }
    };
    case.motor.conventions.commutation = Commutation::Brushless;
    for (motor, bus, own, bound, owner) in [
        (Some(5.0), None, None, 5.0, "motor"),
        (None, Some(4.0), None, 4.0 * 1.5_f64.sqrt(), "drive"),
        // The joint's own drive comes before the bus's.
        (None, Some(4.0), Some(2.0), 2.0 * 1.5_f64.sqrt(), "drive"),
        (Some(4.8), Some(4.0), None, 4.8, "motor"),
        (Some(5.0), Some(4.0), None, 4.0 * 1.5_f64.sqrt(), "drive"),
    ] {
        case.motor.peak_current = motor;
        (case.robot.bus.drive_current, case.robot.joints[0].drive_current) = (bus, own);
        let asked = at(&case, "peak_current").unwrap();
        assert_relative_eq!(asked.bound, bound, max_relative = 1e-12);
        assert_eq!(asked.owner, owner);
    }
    case.motor.conventions.commutation = Commutation::Brushed;
    assert_relative_eq!(at(&case, "peak_current").unwrap().bound, 4.0, max_relative = 1e-12);
    // Of two that are equal it is the motor's.
    case.motor.peak_current = Some(at(&case, "peak_current").unwrap().bound);
    assert_eq!(at(&case, "peak_current").unwrap().owner, "motor");
    case.motor.peak_current = Some(5.0);
    case.motor.conventions.commutation = Commutation::Brushless;
    // The lower of two temperatures.
    case.motor.thermal_resistance = Some(2.0);
    for (motor, asked, hottest, owner) in [
        (Some(400.0), None, 400.0, "motor"),
        (None, Some(390.0), 390.0, "requirement"),
        (Some(400.0), Some(390.0), 390.0, "requirement"),
        (Some(380.0), Some(390.0), 380.0, "motor"),
        (Some(390.0), Some(390.0), 390.0, "motor"),
    ] {
        case.motor.max_winding_temperature = motor;
        case.robot.joints[0].limits.winding_temperature = asked;
        case.motor.continuous_current = None;
        let Some(found) = at(&case, "winding_temperature") else { panic!("not asked") };
        // i² R_th R (1 + α (T − T_0)) = T − T_a.
        let a = raw::copper(case.motor.reference_temperature);
        let r = case.motor.resistance * (1.0 + a * (hottest - case.motor.reference_temperature));
        let current = ((hottest - case.robot.ambient) / (2.0 * r)).sqrt();
        assert_relative_eq!(found.bound, current, max_relative = 1e-12);
        assert_eq!(found.owner, owner);
    }
    // A surrounding that is too hot leaves no current at all.
    case.robot.ambient = 500.0;
    assert_eq!(at(&case, "winding_temperature").unwrap().bound, 0.0);
    let asked = at(&case, "peak_current").unwrap();
    let joint = &case.robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    let candidate = Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap();
    let margin = |bound: f64, demand: f64| {
        Asked { bound, squared: false, factor: 1.0, above_zero: 1.0, ..asked }.margin(&candidate, 3.0, demand)
    };
    assert_eq!((margin(8.0, 2.0), margin(8.0, -2.0), margin(8.0, 10.0)), (0.75, 1.0, -0.25));
    assert_eq!(margin(8.0, f64::INFINITY), -1e6);
    // Of a limit of zero, what rounding leaves of the terms that cancel is nothing.
    let size = asked.polynomial_at(&candidate, 3.0).unwrap().0.size(3.0);
    assert_eq!((margin(0.0, 0.0), margin(0.0, -1.0)), (0.0, 0.0));
    assert_eq!((margin(0.0, 0.5e-9 * size), margin(0.0, 2e-9 * size)), (0.0, -1.0));
    // The functional is the square of the demand, with the sign kept; and back.
    let square = Asked { squared: true, factor: 2.0, ..asked };
    let straight = Asked { squared: false, factor: 2.0, above_zero: 2.0, ..asked };
    assert_eq!((Asked { bound: 6.0, ..square }.raw_bound(), Asked { bound: -6.0, ..square }.raw_bound()), (9.0, -9.0));
    assert_eq!(Asked { bound: 6.0, ..straight }.raw_bound(), 3.0);
    assert_eq!(
        (square.natural(9.0), square.natural(-1.0), straight.natural(9.0), straight.natural(-1.0)),
        (6.0, 0.0, 18.0, -2.0)
    );
    let class = |name: &str| LIMITS.iter().find(|l| l.name == name).unwrap();
    assert_eq!(class("regeneration").class, Class::ReverseConvex);
    assert_eq!(class("gear_peak_torque").class.words(), "all ratios or none");
    assert_eq!(class("max_speed").class.words(), "all ratios up to one");
    assert_eq!(class("voltage").class.words(), "one interval of ratios, convex in N²");
    assert!(class("regeneration").class.words().starts_with("up to two intervals"));
    assert!(class("peak_current").safety && !class("voltage").safety);
    assert_eq!(format!("{:?}", class("voltage")), "voltage");
    assert!(matches!(asked.demand, Demand::Samples(_)));
}

/// Two quick looks at the winding's temperature never contradict the long one, and are no weaker than they say.
#[test]
fn quick_looks_at_the_windings_temperature_are_true_and_sharp() {
    let (mut within, mut beyond) = (0, 0);
    for i in 0..60 {
        let case = draw(i, true);
        let joint = &case.robot.joints[0];
        let load = Load::new(&joint.motion, None);
        if !load.has_course() {
            continue;
        }
        let actuator = Actuator::new(&case.motor, case.motor.rotor_inertia.unwrap(), &joint.gear);
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let n = (min * max).sqrt();
        // A housing so small that the winding ends up 40 K above ambient at the largest heat.
        let most = case.raw.iter().map(|p| load_square(&case, p, n)).fold(0.0, f64::max) * actuator.copper();
        let node = TwoNode {
            resistance_winding_housing: 0.4 * 40.0 / most,
            resistance_housing_ambient: 0.6 * 40.0 / most,
            time_constant_winding: 5.0,
            time_constant_housing: 60.0,
            ambient: case.robot.ambient,
            reference: case.motor.reference_temperature,
            phases: false,
        };
        let (peak, sample) = load.winding_peak(&actuator, &node, n);
        assert!(sample.is_some_and(|s| s < joint.motion.len()));
        // Held for ever: T = T_a + r (1 + α (T_a − T_0))/(1 − α r).
        let a = raw::copper(node.reference);
        let warm = 1.0 + a * (node.ambient - node.reference);
        let held = 40.0 * warm / (1.0 - a * 40.0);
        assert!(peak <= held * (1.0 + 1e-9), "{i}: {peak} {held}");
        assert!(load.winding_peak_is_within(&actuator, &node, n, held * (1.0 + 1e-9)), "{i}");
        assert!(!load.winding_peak_is_within(&actuator, &node, n, held * (1.0 - 1e-9)), "{i}");
        within += 1;
        // Over a narrow interval the least heat is nearly the heat: sharp up to what the interval moves.
        let narrow = (n * (1.0 - 1e-9), n * (1.0 + 1e-9));
        assert!(load.winding_peak_is_beyond(&actuator, &node, narrow, peak * (1.0 - 1e-5)), "{i}");
        assert!(!load.winding_peak_is_beyond(&actuator, &node, narrow, peak * (1.0 + 1e-5)), "{i}");
        for (low, high) in [(0.9 * n, 1.1 * n), (0.5 * n, 2.0 * n), (0.99 * n, 1.0 * n), (n, 1.03 * n)] {
            let ratios = (0..=40).map(|k| low * (high / low).powf(f64::from(k) / 40.0));
            let least = ratios.map(|n| load.winding_peak(&actuator, &node, n).0).fold(f64::INFINITY, f64::min);
            assert!(!load.winding_peak_is_beyond(&actuator, &node, (low, high), least * (1.0 + 1e-9)), "{i}");
            beyond += usize::from(load.winding_peak_is_beyond(&actuator, &node, (low, high), 0.8 * least));
        }
        let (times, course) = load.winding_course(&actuator, &node, n).unwrap();
        assert_eq!((times, times.len()), (joint.motion.time.as_slice(), course.winding.len()));
        assert_relative_eq!(course.peak - node.ambient, peak, max_relative = 1e-12);
    }
    assert!(within > 30 && beyond > 40, "{within} {beyond}");
}

/// Squared shaft torque of a sample in limits, friction opposing; the random joints here have none.
fn load_square(case: &raw::Case, p: &Point, n: f64) -> f64 {
    let gear = &case.robot.joints[0].gear;
    let phi = if p.torque * p.velocity < 0.0 { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
    let j = case.motor.rotor_inertia.unwrap() + gear.inertia;
    let b = case.motor.viscous_friction.unwrap_or(0.0);
    (phi * p.torque / n + n * (j * p.acceleration + b * p.velocity)).powi(2)
}

/// Mean terminal power over time, from the samples.
#[test]
fn mean_power_is_heat_and_work() {
    for i in 0..40 {
        let case = draw(i, i % 2 == 0);
        let joint = &case.robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let actuator = Actuator::new(&case.motor, case.motor.rotor_inertia.unwrap(), &joint.gear);
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        for n in [min, (min * max).sqrt()] {
            let (mut power, mut size) = (0.0, 0.0);
            for (p, share) in case.raw.iter().zip(&case.shares) {
                let gear = &joint.gear;
                let phi = match p.torque * p.velocity {
                    _ if p.velocity == 0.0 => 1.0,
                    power if power < 0.0 => gear.backdrive_efficiency,
                    _ => 1.0 / gear.efficiency,
                };
                let j = case.motor.rotor_inertia.unwrap() + gear.inertia;
                let b = case.motor.viscous_friction.unwrap_or(0.0);
                let c = case.motor.coulomb_friction.unwrap_or(0.0);
                let rubs = if p.velocity == 0.0 { 0.0 } else { c * p.velocity.signum() };
                let torque = phi * p.torque / n + n * (j * p.acceleration + b * p.velocity) + rubs;
                let current = torque / case.motor.torque_constant;
                let heat = case.motor.resistance * current * current;
                let work = case.motor.emf_constant() * n * p.velocity * current;
                power += share[0] * (heat + work);
                size += share[0] * (heat + work.abs());
            }
            assert!((load.mean_power(&actuator).at(n) - power).abs() < 1e-9 * size, "{i}");
        }
    }
}

/// A joint with a motor whose ripple and iron matter at its middle ratio.
fn with_iron(i: u64, convex: bool) -> (raw::Case, f64) {
    let mut case = draw(i, convex);
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    let n = (min * max).sqrt();
    let k_t = case.motor.torque_constant;
    let current = (case.look(n).quantities[1] / case.motor.resistance).sqrt().max(1e-9);
    let ripple = [0.2 * k_t * current, -0.1 * k_t * current, 12.0];
    let share = [0.1 * k_t, 0.05 * k_t, 6.0];
    let iron = [0.6 * k_t, 1.5 * current];
    let all: [(&str, &[f64]); 3] =
        [("cogging", &ripple), ("torque_ripple", &share), ("torque_constant_saturation", &iron)];
    case.motor = match i % 4 {
        0 => case.motor,
        1 => with(&case.motor, &all[..2]),
        2 => with(&case.motor, &all[2..]),
        _ => with(&case.motor, &all),
    };
    (case, n)
}

/// What a cut must be: equal to the function where it was made, with its slope, and nowhere above it.
fn is_a_cut(what: &str, cut: &Laurent, n: f64, value: &dyn Fn(f64) -> f64, smooth: bool) {
    let size = value(n).abs().max(1e-9 * cut.size(n)).max(1e-300);
    assert!((cut.at(n) - value(n)).abs() <= 1e-9 * size.max(1e-6 * cut.size(n)), "{what}: {} {}", cut.at(n), value(n));
    for factor in [0.3, 0.6, 0.9, 0.99, 1.01, 1.1, 1.7, 3.0] {
        let other = factor * n;
        let rounding = 1e-9 * cut.size(other).max(value(other).abs());
        assert!(cut.at(other) <= value(other) + rounding, "{what} at {factor}: {} {}", cut.at(other), value(other));
    }
    if smooth {
        let h = 1e-4 * n;
        let slope = (value(n + h) - value(n - h)) / (2.0 * h);
        let scale = slope.abs().max(value(n).abs() / n).max(1e-9 * cut.size(n) / n);
        assert!((cut.slope(n) - slope).abs() <= 1e-4 * scale, "{what}: slope {} {slope}", cut.slope(n));
    }
}

/// Means of squared current and energy, sample by sample, and their cuts.
#[test]
fn cuts_of_heat_and_energy_touch_and_stay_below() {
    for i in 0..80 {
        let (case, n) = with_iron(i, i % 3 != 0);
        let (joint, motor) = (&case.robot.joints[0], &case.motor);
        let load = Load::new(&joint.motion, None);
        let actuator = Actuator::new(motor, motor.rotor_inertia.unwrap(), &joint.gear);
        let torque = |p: &Point, n: f64| {
            let phi = match p.torque * p.velocity {
                _ if p.velocity == 0.0 => 1.0,
                power if power < 0.0 => joint.gear.backdrive_efficiency,
                _ => 1.0 / joint.gear.efficiency,
            };
            let j = motor.rotor_inertia.unwrap() + joint.gear.inertia;
            let rubs =
                if p.velocity == 0.0 { 0.0 } else { motor.coulomb_friction.unwrap_or(0.0) * p.velocity.signum() };
            phi * p.torque / n + n * (j * p.acceleration + motor.viscous_friction.unwrap_or(0.0) * p.velocity) + rubs
        };
        let squared = |p: &Point, n: f64| actuator.shortfall.current_squared(torque(p, n).powi(2)).0;
        for worst in [0.0, 0.3, 1.0] {
            let mean = |n: f64| {
                let share = |s: &[f64; 2]| s[0] + worst * s[1];
                case.raw.iter().zip(&case.shares).map(|(p, s)| share(s) * squared(p, n)).sum::<f64>()
            };
            for n in [n, 0.4 * n, 2.0 * n] {
                assert_relative_eq!(load.mean_current_squared(&actuator, worst, n), mean(n), max_relative = 1e-9);
            }
            let cut = load.mean_current_squared_cut(&actuator, worst, n);
            is_a_cut(&format!("{i} mean current"), &cut, n, &mean, true);
        }
        let Some(duration) = load.duration else { continue };
        let (drive, kept) = (0.87, 0.6);
        let bus = Bus { drive_efficiency: drive, regeneration_efficiency: Some(kept), ..case.robot.bus };
        let bus = Bus { regeneration: Regeneration::Allowed, ..bus };
        let energy = |n: f64| {
            let of = |p: &Point| {
                let heat = motor.resistance * squared(p, n);
                let power = heat + motor.emf_constant() * n * p.velocity * torque(p, n) / motor.torque_constant;
                if power > 0.0 { power / drive } else { power * kept }
            };
            duration * case.raw.iter().zip(&case.shares).map(|(p, s)| s[0] * of(p)).sum::<f64>()
        };
        for n in [0.5 * n, n, 1.8 * n] {
            is_a_cut(
                &format!("{i} energy"),
                &(load.drawn_cut(&actuator, Drawn::new(&bus), n) * duration),
                n,
                &energy,
                false,
            );
        }
    }
}

/// The cut of the winding's largest rise; where the heat runs away it is above the bound, and still below what
/// settles.
#[test]
fn cuts_of_the_windings_temperature_touch_and_stay_below() {
    let (mut settled, mut away) = (0, 0);
    for i in 0..60 {
        let (case, n) = with_iron(i, true);
        let joint = &case.robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let Some(duration) = load.duration.filter(|_| load.has_course()) else { continue };
        let actuator = Actuator::new(&case.motor, case.motor.rotor_inertia.unwrap(), &joint.gear);
        let mean = load.mean_current_squared(&actuator, 0.0, n) * case.motor.resistance;
        for (rise, bound) in [(30.0, 50.0), (600.0, 300.0)] {
            let node = TwoNode {
                resistance_winding_housing: 0.4 * rise / mean,
                resistance_housing_ambient: 0.6 * rise / mean,
                time_constant_winding: 3.0 * duration,
                time_constant_housing: 20.0 * duration,
                ambient: case.robot.ambient,
                reference: case.motor.reference_temperature,
                // Its heat over periods is followed below without the phases.
                phases: false,
            };
            let peak = |n: f64| load.winding_peak(&actuator, &node, n).0;
            let (cut, _) = load.winding_peak_cut(&actuator, &node, n, bound);
            if peak(n).is_finite() {
                is_a_cut(&format!("{i} winding"), &cut, n, &peak, false);
                settled += 1;
                continue;
            }
            away += 1;
            let here = cut.at(n);
            assert!(here > bound && here.is_finite(), "{i}: {here}");
            for factor in [0.1, 0.3, 0.5, 0.8, 1.3, 2.0, 5.0, 20.0] {
                let other = peak(factor * n);
                assert!(
                    cut.at(factor * n) <= other * (1.0 + 1e-9) + 1e-9 * cut.size(factor * n).min(1e9),
                    "{i} {factor}"
                );
            }
            // The number is that of whole periods from cold: doubled until it is beyond the bound, and no further.
            let heat: Vec<f64> = {
                let sample = |p: &Point| {
                    let j = case.motor.rotor_inertia.unwrap() + joint.gear.inertia;
                    let phi = match p.torque * p.velocity {
                        _ if p.velocity == 0.0 => 1.0,
                        power if power < 0.0 => joint.gear.backdrive_efficiency,
                        _ => 1.0 / joint.gear.efficiency,
                    };
                    let torque = phi * p.torque / n
                        + n * (j * p.acceleration + case.motor.viscous_friction.unwrap_or(0.0) * p.velocity);
                    case.motor.resistance * actuator.shortfall.current_squared(torque * torque).0
                };
                case.raw.iter().map(sample).collect()
            };
            let after = |periods: usize| {
                let times: Vec<f64> =
                    (0..periods).flat_map(|k| joint.motion.time.iter().map(move |t| t + k as f64 * duration)).collect();
                let heat: Vec<f64> = (0..periods).flat_map(|_| heat.iter().copied()).collect();
                let course = Heat {
                    times: &times,
                    period_or_duration: periods as f64 * duration,
                    heat: &heat,
                    settling: &[],
                    phase: &[],
                };
                node.from_cold(&course).peak - node.ambient
            };
            let mut periods = 1;
            while after(periods) <= bound {
                periods *= 2;
            }
            assert_relative_eq!(here, after(periods), max_relative = 1e-9);
        }
    }
    assert!(settled > 20 && away > 20, "{settled} {away}");
}

/// The boundary of every functional: at the torque that was found the functional is at its bound, and nowhere
/// before; where nothing bounds it, it is infinite, and where not even no torque is allowed, there is none.
#[test]
fn the_envelope_is_where_its_functional_meets_the_bound() {
    let (mut met, mut none, mut endless) = (0, 0, 0);
    for i in 0..80 {
        let mut case = draw(i, i % 2 == 0);
        if i % 5 == 0 {
            // A gear that locks passes nothing of a braking torque on.
            case.robot.joints[0].gear.backdrive_efficiency = 0.0;
        }
        let joint = &case.robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let candidate = Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap();
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let n = (min * max).sqrt();
        let steady = Steady::new(&candidate, n);
        let (motor, gear) = (&case.motor, &joint.gear);
        let fastest = case.raw.iter().map(|p| p.velocity.abs()).fold(0.0, f64::max);
        for (flow, functional, share) in [Flow::Driving, Flow::Braking]
            .into_iter()
            .flat_map(|f| {
                [Functional::TorqueSquared, Functional::VoltageSquared, Functional::Power, Functional::PowerBack]
                    .map(|q| (f, q))
            })
            .flat_map(|(f, q)| [0.0, 0.3, 1.0].map(|s| (f, q, s)))
        {
            let (speed, sign) = (share * fastest, if flow == Flow::Driving { 1.0 } else { -1.0 });
            let phi = if flow == Flow::Driving { 1.0 / gear.efficiency } else { gear.backdrive_efficiency };
            // From the plain equations of a steady sample.
            let value = |load: f64| {
                let rubs = motor.coulomb_friction.unwrap_or(0.0) + motor.viscous_friction.unwrap_or(0.0) * n * speed;
                let current = (phi * sign * load / n + rubs) / motor.torque_constant;
                let poles = motor.inductance_and_poles().map_or(0.0, |(l, p)| l * p);
                let asked = joint.limits.winding_temperature;
                let hot = motor.resistance * raw::hottest_factor(motor, asked);
                let cold = motor.resistance * raw::ambient_factor(motor, case.robot.ambient);
                let v_q = |r: f64| r * current + motor.emf_constant() * n * speed;
                let v_d = poles * n * speed * current;
                let most = v_q(hot).abs().max(v_q(cold.min(hot)).abs());
                let work = motor.emf_constant() * n * speed * current;
                match functional {
                    Functional::TorqueSquared | Functional::CurrentSquared => (current * motor.torque_constant).powi(2),
                    Functional::VoltageSquared => most * most + v_d * v_d,
                    Functional::Power => hot * current * current + work,
                    Functional::PowerBack => -(cold * current * current + work),
                    Functional::OpenVoltage(_) | Functional::LeastVoltage(_) => {
                        unreachable!("no parabola of the torque")
                    }
                }
            };
            let usual = case.raw.iter().map(|p| p.torque.abs()).fold(0.0, f64::max);
            let (here, size) = (steady.at(functional, flow, sign * usual, speed), value(2.0 * usual).abs());
            assert!((here - value(usual)).abs() <= 1e-9 * value(usual).abs().max(1e-12 * size), "{i} {functional:?}");
            // Power that comes back is no convex function of torque: it has no such boundary.
            if functional == Functional::PowerBack {
                continue;
            }
            let bounds =
                [value(0.7 * usual), value(0.0) - 0.1 * value(usual).abs() - 1e-12, 2.0 * value(3.0 * usual).abs()];
            for bound in bounds {
                let size = value(usual).abs().max(bound.abs()).max(value(0.0).abs());
                match steady.largest_torque(functional, bound, flow, speed) {
                    Some(torque) if torque.is_finite() => {
                        assert!(torque * sign >= 0.0);
                        let found = torque.abs();
                        let size = size.max(value(found).abs());
                        assert!(
                            (value(found) - bound).abs() <= 1e-7 * size,
                            "{i} {functional:?}: {} {bound}",
                            value(found)
                        );
                        // Just beyond it the bound is broken, for good or at a minimum of the functional.
                        assert!(
                            value(found * 1.01 + 1e-9 * usual) >= bound - 1e-7 * size,
                            "{i} {functional:?} {flow:?}"
                        );
                        met += 1;
                    }
                    Some(_) => {
                        // Never exceeded, however large.
                        for far in [1.0, 1e3, 1e6] {
                            assert!(
                                value(far * usual) <= bound + 1e-7 * size.max(value(far * usual).abs()),
                                "{i} {functional:?}"
                            );
                        }
                        endless += 1;
                    }
                    None => {
                        // Exceeded without torque, and with any.
                        for far in [0.0, 0.01, 0.1, 1.0, 10.0, 1e3] {
                            assert!(value(far * usual) > bound - 1e-7 * size, "{i} {functional:?}: {far}");
                        }
                        none += 1;
                    }
                }
            }
        }
    }
    assert!(met > 300 && none > 50 && endless > 20, "{met} {none} {endless}");
}

/// A waveform with changed features has the same points but for these, in both directions of power.
#[test]
fn changed_waveforms_have_the_same_points() {
    let mut flows = [0, 0];
    for i in 0..20 {
        let case = draw(i, false);
        let joint = &case.robot.joints[0];
        let wave = Load::new(&joint.motion, None).waveform;
        let changed = wave.changed(|x| x[0] *= 3.0);
        let actuator = Actuator::new(&case.motor, case.motor.rotor_inertia.unwrap(), &joint.gear);
        assert_eq!(changed.len(), wave.len());
        for i in 0..wave.len() {
            let mut expected = wave.point(i);
            expected.features[0] *= 3.0;
            assert_eq!(changed.point(i), expected);
            flows[expected.flow as usize] += 1;
        }
        for n in [2.0, 20.0, 200.0] {
            for functional in [Functional::TorqueSquared, Functional::VoltageSquared, Functional::Power] {
                let found = changed.largest(functional, &actuator, n);
                let at = |i: usize| {
                    let p = changed.point(i);
                    functional.polynomial(&actuator, &p, n).at(n)
                };
                let most = (0..changed.len()).map(at).fold(f64::NEG_INFINITY, f64::max);
                let size = (0..changed.len()).map(|i| at(i).abs()).fold(0.0, f64::max);
                assert!((found.value - most).abs() <= 1e-9 * size && (at(found.index) - most).abs() <= 1e-9 * size);
            }
        }
    }
    assert!(flows[0] > 100 && flows[1] > 100, "{flows:?}");
}

/// What a gear of the catalogue does not say cannot be checked; a requirement that says nothing asks for nothing.
#[test]
fn a_gear_of_the_catalogue_that_is_silent_is_unknown() {
    let mut case = draw(3, true);
    let gear = &mut case.robot.joints[0].gear;
    (gear.peak_torque, gear.continuous_torque) = (None, None);
    let joint = &case.robot.joints[0];
    let load = Load::new(&joint.motion, None);
    let asked = Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap();
    let catalog = Catalog::builtin().unwrap();
    let listed = Candidate { catalog_gear: catalog.gears.first(), ..asked };
    for name in ["gear_peak_torque", "gear_continuous_torque"] {
        let limit = LIMITS.iter().find(|l| l.name == name).unwrap();
        assert!(matches!(limit.check(&asked), Check::NotAsked), "{name}");
        assert!(matches!(limit.check(&listed), Check::Unknown(why) if why.ends_with("torque is not known")), "{name}");
    }
}

/// With a ratio of one the actuator's motor constant is the motor's, whatever says its back-EMF constant; and
/// S_M = J_m/K_M², S_T = J_m/K_T² of the numbers that the model computes with.
#[test]
fn metrics_use_the_back_emf_constant_of_the_model() {
    let (mut compared, mut apart) = (0, 0);
    for motor in &Catalog::builtin().unwrap().motors {
        let Some(rotor) = motor.rotor_inertia else { continue };
        let of = |name: &str| metric(name).unwrap().value(motor).unwrap();
        let alone = at_matched_inertia(motor, rotor).unwrap();
        assert_relative_eq!(of("k_m"), alone.motor_constant, max_relative = 1e-12);
        assert_relative_eq!(of("s_m"), rotor / alone.motor_constant.powi(2), max_relative = 1e-12);
        assert_relative_eq!(of("s_t"), rotor / motor.torque_constant.powi(2), max_relative = 1e-12);
        compared += 1;
        apart += usize::from((motor.back_emf_constant / motor.torque_constant - 1.0).abs() > 1e-3);
    }
    assert!(compared > 100 && apart > 1, "{compared} {apart}");
    // Line to line at the peak, 52.5 rpm/V are a back-EMF constant of √(3/2)/√3/5.498 = 0.1286 V·s/rad.
    let made = motor(",speed_constant [rpm/V],speed_constant_convention", ",52.5,line_to_line_peak");
    let k_b = 0.5_f64.sqrt() / (52.5 * 2.0 * PI / 60.0);
    assert_relative_eq!(made.back_emf_constant, k_b, max_relative = 1e-12);
    let m = metric("k_m").unwrap().value(&made).unwrap();
    assert_relative_eq!(m * m, 0.1 * k_b / 0.5, max_relative = 1e-12);
}
