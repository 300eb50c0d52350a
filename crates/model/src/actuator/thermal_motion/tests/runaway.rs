//! Where each period is hotter than the last.

use super::*;

/// Scale of heat at which a motion begins to run away.
fn begins_to_run_away(motor: &TwoNode, heat: &Heat) -> f64 {
    let (mut low, mut high) = (0.0, 100.0 * threshold(motor));
    while high - low > 1e-15 * high {
        let scale = 0.5 * (low + high);
        let q: Vec<f64> = heat.heat.iter().map(|q| scale * q).collect();
        match motor.periodic_state(&Heat { heat: &q, ..*heat }) {
            Outcome::Settles(_) if scale > low => low = scale,
            Outcome::Runaway if scale < high => high = scale,
            _ => break,
        }
    }
    0.5 * (low + high)
}

#[test]
fn runaway_begins_where_the_spectral_radius_is_one() {
    let mut rng = Pcg64::seed_from_u64(8);
    for _ in 0..30 {
        let motor = random_motor(&mut rng);
        let period = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-2.0..1.0));
        let (times, mut q) = random_course(&mut rng, 9, period, 1.0);
        q[4] += 0.1;
        let heat = Heat { times: &times, period_or_duration: period, heat: &q, settling: &[], phase: &[] };
        let scale = begins_to_run_away(&motor, &heat);
        // The same parts, with another exponential.
        let radius = |scale: f64| {
            let map =
                heat.parts(Course::Periodic, motor.time_constant_winding).fold(Matrix2::identity(), |map, part| {
                    (equations(&motor, scale * part.heat).0 * part.duration).exp() * map
                });
            spectral_radius(&map)
        };
        assert_relative_eq!(radius(scale), 1.0, max_relative = 1e-11);
        assert!(radius(0.999 * scale) < 1.0 && radius(1.001 * scale) > 1.0);
        let mean = mean_heat(&heat);
        assert!(scale * mean <= threshold(&motor) * (1.0 + 1e-9), "the test on averages is necessary");
    }
}

fn mean_heat(heat: &Heat) -> f64 {
    let parts = heat.parts(Course::Periodic, 1.0);
    parts.map(|part| part.duration * part.heat).sum::<f64>() / heat.period_or_duration
}

#[test]
fn constant_heat_runs_away_exactly_at_the_threshold() {
    for samples in [1, 2, 100] {
        let (times, q) = (grid(samples, 10.0), vec![1.0; samples]);
        let heat = Heat { times: &times, period_or_duration: 10.0, heat: &q, settling: &[], phase: &[] };
        assert_relative_eq!(begins_to_run_away(&MOTOR, &heat), threshold(&MOTOR), max_relative = 1e-11);
    }
}

#[test]
fn pulses_run_away_though_their_mean_would_not() {
    // Ten seconds out of 200 at 17 times the heat of the threshold: 85 % of it on average.
    let pulse = 17.0 * threshold(&MOTOR);
    let times = [0.0, 0.01, 10.0, 10.01];
    let heat =
        Heat { times: &times, period_or_duration: 200.0, heat: &[0.0, pulse, pulse, 0.0], settling: &[], phase: &[] };
    let mean = mean_heat(&heat);
    assert_relative_eq!(mean, 0.85 * threshold(&MOTOR), max_relative = 2e-3);
    let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
    let averaged = thermal::winding_temperature(mean, 1.0, MOTOR.reference, r_th, MOTOR.ambient);
    assert!(averaged.is_some(), "the mean settles");
    assert_eq!(MOTOR.periodic_state(&heat), Outcome::Runaway);
    // As an independent integration sees: each period is hotter than the last by a growing amount.
    let mut x = Vector2::new(0.0, 0.0);
    let mut ends = vec![0.0];
    for _ in 0..8 {
        for (from, until, q) in [(0.0, 10.005, pulse), (10.005, 200.0, 0.0)] {
            let steps = 4000;
            let h = (until - from) / f64::from(steps);
            let (matrix, forcing) = equations(&MOTOR, q);
            let forcing = forcing + matrix * Vector2::repeat(MOTOR.ambient);
            for _ in 0..steps {
                let k1 = matrix * x + forcing;
                let k2 = matrix * (x + k1 * (0.5 * h)) + forcing;
                let k3 = matrix * (x + k2 * (0.5 * h)) + forcing;
                let k4 = matrix * (x + k3 * h) + forcing;
                x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
            }
        }
        ends.push(x[0]);
    }
    let rises: Vec<f64> = ends.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(rises[1..].windows(2).all(|pair| pair[1] > 1.01 * pair[0]), "{rises:?}");
}
