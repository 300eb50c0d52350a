//! Against closed forms, published numbers and identities.

mod runaway;

use super::super::thermal;
use super::*;
use approx::assert_relative_eq;
use nalgebra::{Matrix2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// ILM115x25 (WE18 of the worked examples); the housing's time constant is not published.
const MOTOR: TwoNode = TwoNode {
    resistance_winding_housing: 0.507863,
    resistance_housing_ambient: 0.418284,
    time_constant_winding: 50.8,
    time_constant_housing: 700.0,
    ambient: 298.15,
    reference: 295.143,
    phases: true,
};

/// One node of the hold of WE01.
const HOLD: TwoNode = TwoNode {
    resistance_winding_housing: 10.0,
    resistance_housing_ambient: 0.0,
    time_constant_winding: 60.0,
    time_constant_housing: 60.0,
    ambient: 298.15,
    reference: 298.15,
    phases: true,
};

fn settled(motor: &TwoNode, heat: &Heat) -> Temperature {
    match motor.periodic_state(heat) {
        Outcome::Settles(temperature) => temperature,
        Outcome::Runaway => panic!("runs away"),
    }
}

fn peak(motor: &TwoNode, heat: &Heat, course: Course) -> f64 {
    match course {
        Course::Periodic => match motor.periodic_state(heat) {
            Outcome::Settles(temperature) => temperature.peak,
            Outcome::Runaway => f64::INFINITY,
        },
        Course::FromCold => motor.from_cold(heat).peak,
    }
}

fn grid(samples: usize, period: f64) -> Vec<f64> {
    (0..samples).map(|k| period * k as f64 / samples as f64).collect()
}

/// Uneven times within a period, and heats.
fn random_course(rng: &mut Pcg64, samples: usize, period: f64, most: f64) -> (Vec<f64>, Vec<f64>) {
    let mut times: Vec<f64> = (0..samples).map(|_| rng.random_range(0.0..period)).collect();
    times.sort_by(f64::total_cmp);
    times[0] = 0.0;
    (times, random_heat(rng, samples, most))
}

fn random_heat(rng: &mut Pcg64, samples: usize, most: f64) -> Vec<f64> {
    (0..samples).map(|_| if rng.random::<f64>() < 0.3 { 0.0 } else { rng.random_range(0.0..most) }).collect()
}

/// Anything from a drone's motor to a wall of iron, slow and fast housings.
fn random_motor(rng: &mut Pcg64) -> TwoNode {
    let mut log = |low: f64, high: f64| (rng.random_range(low.ln()..high.ln())).exp();
    TwoNode {
        resistance_winding_housing: log(0.1, 5.0),
        resistance_housing_ambient: log(0.1, 5.0),
        time_constant_winding: log(3.0, 100.0),
        time_constant_housing: log(30.0, 3000.0),
        ambient: 293.15 + 5.0 * log(0.1, 10.0),
        reference: 293.15,
        phases: true,
    }
}

/// Mean heat where constant heat runs away \[W\].
fn threshold(motor: &TwoNode) -> f64 {
    1.0 / (copper(motor.reference) * (motor.resistance_winding_housing + motor.resistance_housing_ambient))
}

/// Largest eigenvalue of a matrix with entries ≥ 0.
fn spectral_radius(m: &Matrix2<f64>) -> f64 {
    let (half, off) = (0.5 * (m[(0, 0)] - m[(1, 1)]), m[(0, 1)] * m[(1, 0)]);
    0.5 * m.trace() + (half * half + off).sqrt()
}

/// The coefficients, written down a second time with capacities.
fn equations(motor: &TwoNode, heat: f64) -> (Matrix2<f64>, Vector2<f64>) {
    let (r_wh, r_ha) = (motor.resistance_winding_housing, motor.resistance_housing_ambient);
    let (c_w, c_h) = (motor.time_constant_winding / r_wh, motor.time_constant_housing / r_ha);
    let matrix = Matrix2::new(
        (copper(motor.reference) * heat - 1.0 / r_wh) / c_w,
        1.0 / (r_wh * c_w),
        1.0 / (r_wh * c_h),
        -(1.0 / r_wh + 1.0 / r_ha) / c_h,
    );
    // In kelvin, not in rises.
    (matrix, Vector2::new(heat * (1.0 - copper(motor.reference) * motor.reference) / c_w, motor.ambient / (r_ha * c_h)))
}

#[test]
fn constant_heat_settles_where_the_steady_state_says() {
    let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
    for heat in [0.0, 1e-3, 30.0, 150.0, 0.999 * threshold(&MOTOR)] {
        let expected = thermal::winding_temperature(heat, 1.0, MOTOR.reference, r_th, MOTOR.ambient).unwrap();
        for (times, period) in [
            (vec![0.0], 1.0),
            (vec![3.0], 1e6),
            (grid(1000, 2.0), 2.0),
            (grid(7, 1e4), 1e4),
            (vec![0.0, 1e-9, 30.0], 1e3),
            (vec![0.0, 1.0, 1.0], 1.0),
        ] {
            let q = vec![heat; times.len()];
            let temperature = settled(
                &MOTOR,
                &Heat { times: &times, period_or_duration: period, heat: &q, settling: &[], phase: &[] },
            );
            assert_relative_eq!(temperature.peak, expected, max_relative = 1e-9);
            for (winding, housing) in temperature.winding.iter().zip(&temperature.housing) {
                assert_relative_eq!(*winding, expected, max_relative = 1e-9);
                let out = (housing - MOTOR.ambient) / MOTOR.resistance_housing_ambient;
                let copper = heat * (1.0 + copper(MOTOR.reference) * (expected - MOTOR.reference));
                assert_relative_eq!(out, copper, max_relative = 1e-6, epsilon = 1e-9);
            }
        }
    }
}

/// Sums of two exponentials, from the eigenvalues.
#[test]
fn a_step_of_heat_is_answered_by_two_exponentials() {
    for heat in [0.0, 40.0, 250.0, 600.0] {
        let (matrix, forcing) = equations(&MOTOR, heat);
        let steady = -matrix.try_inverse().unwrap() * forcing;
        let start = Vector2::repeat(MOTOR.ambient) - steady;
        let root = (0.25 * matrix.trace().powi(2) - matrix.determinant()).sqrt();
        let (fast, slow) = (0.5 * matrix.trace() - root, 0.5 * matrix.trace() + root);
        let identity = Matrix2::identity();
        let along_slow = (matrix - identity * fast) * start / (slow - fast);
        let along_fast = (matrix - identity * slow) * start / (fast - slow);
        let times = grid(40, 200.0);
        let q = vec![heat; times.len()];
        let temperature =
            MOTOR.from_cold(&Heat { times: &times, period_or_duration: 200.0, heat: &q, settling: &[], phase: &[] });
        for (k, time) in times.iter().enumerate() {
            let expected = steady + along_slow * (slow * time).exp() + along_fast * (fast * time).exp();
            assert_relative_eq!(temperature.winding[k], expected[0], max_relative = 1e-11);
            assert_relative_eq!(temperature.housing[k], expected[1], max_relative = 1e-11);
        }
        let end = steady + along_slow * (slow * 200.0).exp() + along_fast * (fast * 200.0).exp();
        assert_relative_eq!(temperature.peak, end[0], max_relative = 1e-11);
        assert_eq!(temperature.peak_sample, if heat > 0.0 { 39 } else { 0 });
    }
}

#[test]
fn a_hold_may_last_as_long_as_published() {
    // WE01: 10 A, and the hold with a ratio of 50, in 1 Ω. The published times are at constant resistance.
    assert_relative_eq!(HOLD.time_to_reach(398.15, 100.0, 0.0).unwrap(), 6.3, max_relative = 0.01);
    assert_relative_eq!(HOLD.time_to_reach(398.15, 100.0, 0.0).unwrap(), 6.3216, max_relative = 1e-5);
    let hold = 4.905_f64.powi(2);
    assert_relative_eq!(HOLD.time_to_reach(398.15, hold, 0.0).unwrap(), 32.2, max_relative = 0.002);
    assert_relative_eq!(HOLD.time_to_reach(398.15, hold, 0.0).unwrap(), 32.2347, max_relative = 1e-5);
    // A hardly resisting housing is a clamped one.
    let tiny = TwoNode { resistance_housing_ambient: 1e-9, ..HOLD };
    assert_relative_eq!(tiny.time_to_reach(398.15, hold, 0.0).unwrap(), 32.2347, max_relative = 1e-5);
}

#[test]
fn one_node_has_a_closed_form_with_warm_copper() {
    let node = TwoNode { ambient: 310.0, ..HOLD };
    let source = 1.0 + copper(node.reference) * (node.ambient - node.reference);
    for heat in [20.0, 30.0, 1e3_f64.recip() / copper(298.15) * 100.0, 100.0, 1e5] {
        let a = copper(node.reference) * 10.0 * heat;
        let expected = if a == 1.0 {
            60.0 * 80.0 / (10.0 * heat * source)
        } else {
            -60.0 / (1.0 - a) * (-(1.0 - a) * 80.0 / (10.0 * heat * source)).ln_1p()
        };
        assert_relative_eq!(
            node.time_to_reach(390.0, heat, copper(node.reference)).unwrap(),
            expected,
            max_relative = 1e-12
        );
    }
}

#[test]
fn two_nodes_reach_the_limit_at_the_time_given() {
    let mut rng = Pcg64::seed_from_u64(1);
    for _ in 0..200 {
        let motor = random_motor(&mut rng);
        let heat = rng.random_range(0.01..3.0) * threshold(&motor);
        let limit = motor.ambient + rng.random_range(1.0..150.0);
        let r_th = motor.resistance_winding_housing + motor.resistance_housing_ambient;
        let steady = thermal::winding_temperature(heat, 1.0, motor.reference, r_th, motor.ambient);
        let time = motor.time_to_reach(limit, heat, copper(motor.reference));
        assert_eq!(time.is_none(), steady.is_some_and(|steady| steady <= limit));
        if let Some(time) = time {
            let hold = Heat { times: &[0.0], period_or_duration: time, heat: &[heat], settling: &[], phase: &[] };
            assert_relative_eq!(motor.from_cold(&hold).peak, limit, max_relative = 1e-11);
        }
    }
    assert_eq!(MOTOR.time_to_reach(MOTOR.ambient - 1.0, 0.0, copper(MOTOR.reference)), Some(0.0));
    assert_eq!(MOTOR.time_to_reach(MOTOR.ambient + 1.0, 0.0, copper(MOTOR.reference)), None);
}

#[test]
fn continuous_currents_of_measured_motors_lead_to_their_limit() {
    // WE18, with 0.00393 for copper: R_0, T_0 in °C, R_wh, R_ha, current.
    for (resistance, reference, r_wh, r_ha, current) in [
        (0.07, 21.993, 0.507863, 0.418284, 33.14_f64),
        (0.16, 22.492, 0.26492, 0.91028, 19.47),
        (0.2895, 28.596, 1.018737, 1.19668, 10.63),
        (0.3254982, 30.465, 0.364306, 1.53477, 10.86),
    ] {
        let motor = TwoNode {
            resistance_winding_housing: r_wh,
            resistance_housing_ambient: r_ha,
            reference: 273.15 + reference,
            phases: true,
            ..MOTOR
        };
        // Theirs takes 0.00393 for the coefficient at each motor's own reference: the heat at 125 °C is what it gives.
        let theirs = 1.0 + 0.003_93 * (125.0 - reference);
        let heat = resistance * current * current * theirs / resistance_factor(398.15, motor.reference);
        let hold = Heat { times: &[0.0], period_or_duration: 1.0, heat: &[heat], settling: &[], phase: &[] };
        assert_relative_eq!(settled(&motor, &hold).peak, 398.15, epsilon = 0.8);
    }
}

/// Copper heat, heat to ambient \[J\] and change of what is stored \[J\] over the parts of a course, the
/// integrals by Gauss' rule within each part: one quadrature for both.
fn balance(motor: &TwoNode, heat: &Heat, course: Course, start: Rise) -> (f64, f64, f64) {
    let (outer, inner) = (
        (5.0_f64 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0,
        (5.0_f64 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0,
    );
    let root = 13.0 * 70.0_f64.sqrt();
    let rule = [
        (0.0, 128.0 / 225.0),
        (inner, (322.0 + root) / 900.0),
        (-inner, (322.0 + root) / 900.0),
        (outer, (322.0 - root) / 900.0),
        (-outer, (322.0 - root) / 900.0),
    ];
    let rates = motor.rates(copper(motor.reference));
    let (mut rise, mut heat_in, mut heat_out) = (start, 0.0, 0.0);
    for part in heat.parts(course, motor.time_constant_winding) {
        for (at, weight) in rule {
            let x = rates.step(0.5 * (1.0 + at) * part.duration, part.heat).apply(rise);
            let weight = 0.5 * weight * part.duration;
            heat_in += weight * part.heat * (1.0 + copper(motor.reference) * (motor.ambient + x[0] - motor.reference));
            heat_out += weight * x[1] / motor.resistance_housing_ambient;
        }
        rise = rates.step(part.duration, part.heat).apply(rise);
    }
    let c_w = motor.time_constant_winding / motor.resistance_winding_housing;
    let c_h = motor.time_constant_housing / motor.resistance_housing_ambient;
    (heat_in, heat_out, c_w * (rise[0] - start[0]) + c_h * (rise[1] - start[1]))
}

#[test]
fn heat_in_is_heat_out_and_heat_stored() {
    let mut rng = Pcg64::seed_from_u64(2);
    for round in 0..150 {
        let motor = random_motor(&mut rng);
        let samples = rng.random_range(1..60);
        let period = [0.5, 20.0, 700.0][round % 3];
        let (times, q) = random_course(&mut rng, samples, period, threshold(&motor));
        let heat = Heat { times: &times, period_or_duration: period, heat: &q, settling: &[], phase: &[] };
        let (heat_in, heat_out, stored) = balance(&motor, &heat, Course::FromCold, [0.0; 2]);
        assert_relative_eq!(heat_in, heat_out + stored, max_relative = 1e-11, epsilon = 1e-11);
        let Outcome::Settles(temperature) = motor.periodic_state(&heat) else { continue };
        let start = [temperature.winding[0] - motor.ambient, temperature.housing[0] - motor.ambient];
        let (heat_in, heat_out, stored) = balance(&motor, &heat, Course::Periodic, start);
        assert_relative_eq!(heat_in, heat_out, max_relative = 1e-9);
        assert!(stored.abs() <= 1e-9 * heat_in);
    }
}

#[test]
fn the_periodic_state_repeats_and_is_where_the_cold_start_ends_up() {
    let mut rng = Pcg64::seed_from_u64(3);
    for _ in 0..50 {
        let motor = random_motor(&mut rng);
        let (times, q) = random_course(&mut rng, 20, 30.0, threshold(&motor));
        let heat = Heat { times: &times, period_or_duration: 30.0, heat: &q, settling: &[], phase: &[] };
        let Outcome::Settles(temperature) = motor.periodic_state(&heat) else { continue };
        let rates = motor.rates(copper(motor.reference));
        let start = [temperature.winding[0] - motor.ambient, temperature.housing[0] - motor.ambient];
        let mut rise = start;
        let mut period = Step::NOTHING;
        for part in heat.parts(Course::Periodic, motor.time_constant_winding) {
            let step = rates.step(part.duration, part.heat);
            rise = step.apply(rise);
            period = period.then(&step);
        }
        assert_relative_eq!(rise[0], start[0], max_relative = 1e-12, epsilon = 1e-11);
        assert_relative_eq!(rise[1], start[1], max_relative = 1e-12, epsilon = 1e-11);
        // 2⁴⁰ periods from cold.
        for _ in 0..40 {
            period = period.then(&period);
        }
        assert_relative_eq!(period.gain[0], start[0], max_relative = 1e-9, epsilon = 1e-9);
        assert_relative_eq!(period.gain[1], start[1], max_relative = 1e-9, epsilon = 1e-9);
    }
}

/// The map of a part is not negative, rises with heat and is log-convex in it, entry by entry; its
/// derivative is the derivative.
#[test]
fn maps_are_positive_and_log_convex_in_heat() {
    let mut rng = Pcg64::seed_from_u64(4);
    let flat = |s: &Step| [s.change[0][0], s.change[0][1], s.change[1][0], s.change[1][1], s.gain[0], s.gain[1]];
    let entries = |s: &Step| {
        let [a, b, c, d, winding, housing] = flat(s);
        [1.0 + a, b, c, 1.0 + d, winding, housing]
    };
    for _ in 0..2000 {
        let motor = random_motor(&mut rng);
        let rates = motor.rates(copper(motor.reference));
        let duration = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-5.0..2.0));
        let most = threshold(&motor) * (1.0 + motor.time_constant_winding / duration).min(100.0);
        let (low, high) = (rng.random_range(0.0..most), rng.random_range(0.0..most));
        let (low, high) = (low.min(high), low.max(high));
        let middle = 0.5 * (low + high);
        let (at, slope) = rates.expand(duration, middle);
        let size = flat(&at);
        let (before, at, after) =
            (entries(&rates.step(duration, low)), entries(&at), entries(&rates.step(duration, high)));
        let slope = flat(&slope);
        let step = 1e-3 * middle / (1.0 + motor.rates(copper(motor.reference)).growth * middle * duration);
        let (less, more) = (flat(&rates.step(duration, middle - step)), flat(&rates.step(duration, middle + step)));
        for e in 0..6 {
            assert!(before[e] >= -1e-16 && before[e] <= at[e] * (1.0 + 1e-12) && at[e] <= after[e] * (1.0 + 1e-12));
            assert!(slope[e] >= -1e-14 * duration, "{slope:?}");
            if e < 4 {
                assert!(at[e] * at[e] <= before[e] * after[e] * (1.0 + 1e-10) + 1e-30);
            } else {
                assert!(at[e] <= 0.5 * (before[e] + after[e]) * (1.0 + 1e-12));
            }
            let difference = (more[e] - less[e]) / (2.0 * step);
            assert_relative_eq!(slope[e], difference, max_relative = 1e-5, epsilon = 1e-15 * size[e].abs() / step);
        }
    }
}

/// Against nalgebra's exponential of the equations in kelvin.
#[test]
fn maps_are_the_exponential() {
    let mut rng = Pcg64::seed_from_u64(5);
    for _ in 0..300 {
        let motor = random_motor(&mut rng);
        let duration = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-4.0..0.5));
        let heat = rng.random_range(0.0..2.0) * threshold(&motor);
        let (matrix, forcing) = equations(&motor, heat);
        let mut whole = nalgebra::Matrix3::zeros();
        whole.fixed_view_mut::<2, 2>(0, 0).copy_from(&matrix);
        whole.fixed_view_mut::<2, 1>(0, 2).copy_from(&forcing);
        let expected = (whole * duration).exp();
        let start = nalgebra::Vector3::new(350.0, 320.0, 1.0);
        let end = expected * start;
        let rise = motor
            .rates(copper(motor.reference))
            .step(duration, heat)
            .apply([350.0 - motor.ambient, 320.0 - motor.ambient]);
        assert_relative_eq!(rise[0] + motor.ambient, end[0], max_relative = 1e-12);
        assert_relative_eq!(rise[1] + motor.ambient, end[1], max_relative = 1e-12);
    }
}

/// Three times the heat of the hottest phase; nothing where no sample stands.
fn phase_of(heat: &[f64], still: &[f64]) -> Vec<f64> {
    match still.iter().all(|s| *s == 0.0) {
        true => Vec::new(),
        false => heat.iter().zip(still).map(|(q, s)| (1.0 + s) * q).collect(),
    }
}

/// Random shares at standstill, in two of three rounds.
fn random_still(rng: &mut Pcg64, samples: usize, round: usize) -> Vec<f64> {
    (0..samples).map(|_| if round.is_multiple_of(3) { 0.0 } else { rng.random_range(0.0..1.0_f64).round() }).collect()
}

/// The whole gradient by the heat of a sample.
fn whole([mean, phase]: [Vec<f64>; 2], still: &[f64]) -> Vec<f64> {
    mean.iter().zip(&phase).zip(still).map(|((mean, phase), still)| mean + (1.0 + still) * phase).collect()
}

#[test]
fn the_hottest_phase_is_a_node_of_its_own() {
    // By the classic Runge-Kutta rule over winding, housing and phase, for heat that is linear between samples.
    let mut rng = Pcg64::seed_from_u64(21);
    for round in 0..40 {
        let motor = random_motor(&mut rng);
        let course = if round % 2 == 0 { Course::Periodic } else { Course::FromCold };
        let samples = [1, 3, 9][round % 3];
        let period = motor.time_constant_winding * [0.2, 3.0, 20.0][round % 3];
        let (times, q) = random_course(&mut rng, samples, period, 0.3 * threshold(&motor));
        let still: Vec<f64> = (0..samples).map(|k| if round % 4 < 2 { 1.0 } else { (k % 2) as f64 }).collect();
        let phase = phase_of(&q, &still);
        let heat = Heat { times: &times, period_or_duration: period, heat: &q, settling: &[], phase: &phase };
        let found = peak(&motor, &heat, course);
        let alpha = copper(motor.reference);
        let capacity = [motor.time_constant_winding, motor.time_constant_housing];
        let [r_w, r_h] = [motor.resistance_winding_housing, motor.resistance_housing_ambient];
        let slope = |heat: f64, of_phase: f64, [w, h, p]: [f64; 3]| {
            let factor = |rise: f64| 1.0 + alpha * (motor.ambient + rise - motor.reference);
            [
                (r_w * heat * factor(w) - (w - h)) / capacity[0],
                (r_h * (w - h) / r_w - h) / capacity[1],
                (r_w * of_phase * factor(p) - (p - h)) / capacity[0],
            ]
        };
        let (mut start, mut most) = ([0.0; 3], 0.0_f64);
        for _ in 0..if course == Course::Periodic { 4000 } else { 1 } {
            let mut x = start;
            most = f64::max(x[0], x[2]);
            for k in 0..samples {
                let last = k + 1 == samples;
                let until = if last { times[0] + period } else { times[k + 1] };
                let next = match (last, course) {
                    (false, _) => k + 1,
                    (true, Course::Periodic) => 0,
                    (true, Course::FromCold) => k,
                };
                let count = (200.0 * (until - times[k]) / capacity[0]).ceil().max(8.0);
                let dt = (until - times[k]) / count;
                for step in 0..count as usize {
                    let share = |part: f64| (step as f64 + part) / count;
                    let at = |part: f64| q[k] + (q[next] - q[k]) * share(part);
                    let of = |k: usize| (1.0 + still[k]) * q[k];
                    let phase_at = |part: f64| of(k) + (of(next) - of(k)) * share(part);
                    let moved = |s: [f64; 3], by: f64| [0, 1, 2].map(|i| x[i] + by * dt * s[i]);
                    let a = slope(at(0.0), phase_at(0.0), x);
                    let b = slope(at(0.5), phase_at(0.5), moved(a, 0.5));
                    let c = slope(at(0.5), phase_at(0.5), moved(b, 0.5));
                    let d = slope(at(1.0), phase_at(1.0), moved(c, 1.0));
                    x = [0, 1, 2].map(|i| x[i] + dt / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
                    most = most.max(x[0]).max(x[2]);
                }
            }
            if (0..3).all(|i| (x[i] - start[i]).abs() < 1e-9) {
                break;
            }
            start = x;
        }
        let rise = found - motor.ambient;
        assert!(rise >= most * (1.0 - 1e-5) && rise <= most * (1.0 + 2e-4), "{round}: {rise} {most}");
    }
}

#[test]
fn the_gradient_is_the_difference_quotient() {
    let mut rng = Pcg64::seed_from_u64(6);
    for round in 0..60 {
        let motor = random_motor(&mut rng);
        let course = if round % 2 == 0 { Course::Periodic } else { Course::FromCold };
        let samples = [1, 2, 7, 25][round % 4];
        let period = motor.time_constant_winding * [0.05, 1.0, 30.0][round % 3];
        let (times, mut q) = random_course(&mut rng, samples, period, 0.8 * threshold(&motor));
        // Heat at which differences are not hidden by rounding.
        q.iter_mut().for_each(|q| *q += 0.01 * threshold(&motor));
        let still = random_still(&mut rng, samples, round);
        // A phase at standstill runs away at half of the heat.
        if still.contains(&1.0) {
            q.iter_mut().for_each(|q| *q *= 0.4);
        }
        let phase = phase_of(&q, &still);
        let heat = Heat { times: &times, period_or_duration: period, heat: &q, settling: &[], phase: &phase };
        let temperature = match course {
            Course::Periodic => settled(&motor, &heat),
            Course::FromCold => motor.from_cold(&heat),
        };
        let gradient = whole(motor.peak_gradient(&heat, course, &temperature), &still);
        let scale = gradient.iter().copied().fold(0.0, f64::max);
        for k in 0..samples {
            assert!(gradient[k] >= 0.0);
            let moved = |by: f64| {
                let mut moved = q.clone();
                moved[k] += by;
                peak(&motor, &Heat { heat: &moved, phase: &phase_of(&moved, &still), ..heat }, course)
            };
            let step = 1e-5 * threshold(&motor);
            // The peak may move from one step within its part to the next: a convex function's subgradient lies
            // between the differences to either side, which are close to each other.
            let here = moved(0.0);
            let (back, ahead) = ((here - moved(-step)) / step, (moved(step) - here) / step);
            let slack = 1e-5 * gradient[k] + 1e-6 * scale + 1e-11 / step * 200.0;
            assert!(gradient[k] >= back - slack && gradient[k] <= ahead + slack, "{back} {} {ahead}", gradient[k]);
            assert!(ahead - back <= 1e-2 * gradient[k] + slack, "{back} {ahead}");
        }
    }
}

#[test]
fn a_clamped_housing_with_the_windings_time_constant_has_a_gradient() {
    // Double eigenvalue, no way back from the housing.
    let heat = Heat {
        times: &[0.0, 20.0, 50.0],
        period_or_duration: 90.0,
        heat: &[0.0, 12.0, 3.0],
        settling: &[],
        phase: &[],
    };
    let temperature = settled(&HOLD, &heat);
    let [gradient, _] = HOLD.peak_gradient(&heat, Course::Periodic, &temperature);
    for k in 0..3 {
        let moved = |by: f64| {
            let mut q = heat.heat.to_vec();
            q[k] += by;
            peak(&HOLD, &Heat { heat: &q, ..heat }, Course::Periodic)
        };
        let forward = (-3.0 * moved(0.0) + 4.0 * moved(1e-4) - moved(2e-4)) / 2e-4;
        assert_relative_eq!(gradient[k], forward, max_relative = 1e-6);
    }
    assert!(temperature.housing.iter().all(|housing| *housing == HOLD.ambient));
}

#[test]
fn the_peak_is_convex_and_above_its_cuts() {
    let mut rng = Pcg64::seed_from_u64(7);
    let mut settling = 0;
    for round in 0..400 {
        let motor = random_motor(&mut rng);
        let course = if round % 2 == 0 { Course::Periodic } else { Course::FromCold };
        let samples = rng.random_range(1..12);
        let period = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-2.0..1.5));
        let most = rng.random_range(0.1..4.0) * threshold(&motor);
        let (times, here) = random_course(&mut rng, samples, period, most);
        let still = random_still(&mut rng, samples, round);
        let of = |heat: &[f64]| phase_of(heat, &still);
        let phase = of(&here);
        let heat = Heat { times: &times, period_or_duration: period, heat: &here, settling: &[], phase: &phase };
        let there = random_heat(&mut rng, samples, most);
        let middle: Vec<f64> = here.iter().zip(&there).map(|(a, b)| 0.5 * (a + b)).collect();
        let temperature = match course {
            Course::Periodic => match motor.periodic_state(&heat) {
                Outcome::Settles(temperature) => temperature,
                Outcome::Runaway => continue,
            },
            Course::FromCold => motor.from_cold(&heat),
        };
        let gradient = whole(motor.peak_gradient(&heat, course, &temperature), &still);
        let height = peak(&motor, &Heat { heat: &there, phase: &of(&there), ..heat }, course);
        let between = peak(&motor, &Heat { heat: &middle, phase: &of(&middle), ..heat }, course);
        assert!(between <= 0.5 * (temperature.peak + height) * (1.0 + 1e-12));
        let cut: f64 = gradient.iter().zip(&here).zip(&there).map(|((g, a), b)| g * (b - a)).sum();
        let size: f64 = gradient.iter().zip(&here).zip(&there).map(|((g, a), b)| g * (b - a).abs()).sum();
        assert!(height >= temperature.peak + cut - 1e-10 * (size + height), "{height} {} {cut}", temperature.peak);
        // More heat nowhere cools.
        let more: Vec<f64> = here.iter().zip(&there).map(|(a, b)| a.max(*b)).collect();
        assert!(
            peak(&motor, &Heat { heat: &more, phase: &of(&more), ..heat }, course) >= temperature.peak * (1.0 - 1e-12)
        );
        settling += usize::from(height.is_finite());
    }
    assert!(settling > 150);
}

#[test]
fn parts_converge_in_second_order() {
    let motor = TwoNode { time_constant_housing: 200.0, ..MOTOR };
    let period = motor.time_constant_winding;
    let first = |samples: usize| {
        let times = grid(samples, period);
        let phase = |t: &f64| (std::f64::consts::TAU * t / period).sin();
        let q: Vec<f64> = times.iter().map(|t| 150.0 * phase(t).powi(2) * (1.0 + 0.5 * phase(t))).collect();
        settled(&motor, &Heat { times: &times, period_or_duration: period, heat: &q, settling: &[], phase: &[] })
            .winding[0]
    };
    let exact = first(65536);
    let errors: Vec<f64> = [32, 64, 128, 256].iter().map(|samples| (first(*samples) - exact).abs()).collect();
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1]).log2() > 1.9, "{errors:?}");
    }
}

#[test]
fn long_intervals_are_close_to_the_course_they_stand_for() {
    // Piecewise linear heat in intervals of up to 6 τ_w, and the same course in 60000 samples.
    let (times, q) = ([0.0, 30.0, 330.0, 500.0], [20.0, 200.0, 100.0, 0.0]);
    let coarse =
        settled(&MOTOR, &Heat { times: &times, period_or_duration: 600.0, heat: &q, settling: &[], phase: &[] });
    let fine_times = grid(60000, 600.0);
    let fine_heat: Vec<f64> = fine_times
        .iter()
        .map(|t| {
            let k = times.iter().rposition(|s| s <= t).unwrap();
            let until = times.get(k + 1).copied().unwrap_or(600.0);
            q[k] + (q[(k + 1) % 4] - q[k]) * (t - times[k]) / (until - times[k])
        })
        .collect();
    let fine = settled(
        &MOTOR,
        &Heat { times: &fine_times, period_or_duration: 600.0, heat: &fine_heat, settling: &[], phase: &[] },
    );
    assert!((coarse.winding[0] - fine.winding[0]).abs() < 0.02);
    assert!((coarse.winding[2] - fine.winding[3 * 11000]).abs() < 0.02);
    // The peak lies between samples and is seen.
    assert!((coarse.peak - fine.peak).abs() < 0.05 && coarse.peak > coarse.winding[1] + 5.0);
    assert_eq!(coarse.peak_sample, 1);
}

/// A motion of so many long intervals that each has fewer parts is followed as with four times as many.
#[test]
fn fewer_parts_of_many_intervals_hardly_change_the_peak() {
    let mut rng = Pcg64::seed_from_u64(41);
    let mut most = 0.0_f64;
    for round in 0..24 {
        let motor = random_motor(&mut rng);
        let (count, fine) = (600, 4);
        let interval = motor.time_constant_winding * [2.0, 4.0, 8.0][round % 3];
        let heat = random_heat(&mut rng, count, 0.5 * threshold(&motor));
        let of = |count: usize, heat: &[f64]| {
            let (times, period) = (grid(count, 600.0 * interval), 600.0 * interval);
            peak(
                &motor,
                &Heat { times: &times, period_or_duration: period, heat, settling: &[], phase: &[] },
                Course::Periodic,
            )
        };
        let between = |k: usize| {
            let (at, share) = (k / fine, (k % fine) as f64 / fine as f64);
            (1.0 - share) * heat[at] + share * heat[(at + 1) % count]
        };
        let finer: Vec<f64> = (0..count * fine).map(between).collect();
        let (coarse, exact) = (of(count, &heat), of(count * fine, &finer));
        if exact.is_finite() {
            most = most.max((coarse - exact).abs() / (exact - motor.ambient));
        }
    }
    println!("apart by {most:e} of the rise");
    assert!(most > 0.0 && most < 2e-5, "{most}");
}

#[test]
fn intervals_of_thousands_of_time_constants_follow_their_heat() {
    let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
    let (times, q) = ([0.0, 1e7, 2e7, 3e7], [10.0, 100.0, 100.0, 40.0]);
    let heat = Heat { times: &times, period_or_duration: 4e7, heat: &q, settling: &[], phase: &[] };
    let temperature = settled(&MOTOR, &heat);
    for (winding, q) in temperature.winding.iter().zip(q) {
        let steady = thermal::winding_temperature(q, 1.0, MOTOR.reference, r_th, MOTOR.ambient).unwrap();
        assert_relative_eq!(*winding, steady, epsilon = 0.5);
    }
    let steady = thermal::winding_temperature(100.0, 1.0, MOTOR.reference, r_th, MOTOR.ambient).unwrap();
    assert_relative_eq!(temperature.peak, steady, max_relative = 1e-9);
}

#[test]
fn no_heat_is_ambient() {
    for (times, period) in [(vec![0.0], 1.0), (grid(10, 5.0), 5.0), (grid(3, 1e5), 1e5)] {
        let q = vec![0.0; times.len()];
        let heat = Heat { times: &times, period_or_duration: period, heat: &q, settling: &[], phase: &[] };
        for temperature in [settled(&MOTOR, &heat), MOTOR.from_cold(&heat)] {
            assert!(temperature.winding.iter().chain(&temperature.housing).all(|t| *t == MOTOR.ambient));
            assert_eq!((temperature.peak, temperature.peak_sample), (MOTOR.ambient, 0));
        }
        // The first watt heats as much as the thermal resistance, on average over the period.
        let temperature = settled(&MOTOR, &heat);
        let [gradient, _] = MOTOR.peak_gradient(&heat, Course::Periodic, &temperature);
        let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
        let expected = r_th * (1.0 + copper(MOTOR.reference) * (MOTOR.ambient - MOTOR.reference));
        assert_relative_eq!(gradient.iter().sum::<f64>(), expected, max_relative = 1e-9);
    }
}

#[test]
fn a_motion_from_cold_counts_its_end() {
    // Samples up to the end, or the last held.
    let to_the_end = MOTOR.from_cold(&Heat {
        times: &[0.0, 5.0],
        period_or_duration: 5.0,
        heat: &[50.0, 50.0],
        settling: &[],
        phase: &[],
    });
    let held =
        MOTOR.from_cold(&Heat { times: &[0.0], period_or_duration: 5.0, heat: &[50.0], settling: &[], phase: &[] });
    assert_relative_eq!(to_the_end.peak, held.peak, max_relative = 1e-14);
    assert_eq!((to_the_end.peak, held.winding.len()), (to_the_end.winding[1], 1));
    assert!(held.peak > held.winding[0]);
}

#[test]
fn heat_beyond_numbers_is_infinitely_hot() {
    let heat = Heat { times: &[0.0, 500.0], period_or_duration: 1000.0, heat: &[1e9, 1e9], settling: &[], phase: &[] };
    assert_eq!(MOTOR.from_cold(&heat).peak, f64::INFINITY);
    assert_eq!(MOTOR.periodic_state(&heat), Outcome::Runaway);
}

#[test]
fn a_few_periods_from_cold_cut_off_what_runs_away() {
    let q = [1.3 * threshold(&MOTOR)];
    let heat = Heat { times: &[0.0], period_or_duration: 1500.0, heat: &q, settling: &[], phase: &[] };
    let limit = 398.15;
    let cold = MOTOR.from_cold(&heat);
    let [gradient, _] = MOTOR.peak_gradient(&heat, Course::FromCold, &cold);
    // T(q) + g (q' − q) ≤ limit admits every q' that settles below the limit, and not q.
    let cut = q[0] + (limit - cold.peak) / gradient[0];
    assert!(cold.peak > limit && cut < q[0]);
    let allowed = thermal::allowed_current_squared(limit, 1.0, MOTOR.reference, 0.507863 + 0.418284, MOTOR.ambient);
    assert!(cut >= allowed);
}
