//! The simulator judged by itself: before it may judge the library, its own physics must hold.

use std::f64::consts::TAU;
use std::fs;

use crate::simulator::{
    self, Bench, Channel, Drive, Effect, Kind, Machine, Nature, Size, Trace, Truth, Velocity, clean, outside, pair,
    profile::{Profile, Segment, Shape},
    random::Random,
    scenario, shuffled,
    world::{self, State},
};

const KINDS: [Kind; 8] = [
    Kind::Dynamometer,
    Kind::Free,
    Kind::Electrical,
    Kind::SteadyTable,
    Kind::Stall,
    Kind::Backdrive,
    Kind::Servo,
    Kind::Linear,
];

fn written(bench: &Bench) -> (tempfile::TempDir, Truth) {
    let folder = tempfile::tempdir().unwrap();
    let truth = bench.write(folder.path());
    (folder, truth)
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Integral by trapezoids.
fn integral(step: f64, values: impl Iterator<Item = f64>) -> f64 {
    let values: Vec<f64> = values.collect();
    values.windows(2).map(|w| 0.5 * step * (w[0] + w[1])).sum()
}

fn machine() -> Machine {
    Machine::actuator(&mut Random::new(7, "machine"))
}

fn nature(effects: &[Effect]) -> Nature {
    Nature::new(machine(), effects, &mut Random::new(7, "nature"))
}

fn rich(step: f64, peak: f64, corner: f64, purpose: &str) -> Profile {
    let shape = Shape { peak, slow: 0.3, slow_level: 0.05, hold: (0.3, 1.0), band: (0.2, 6.0), sines: 0.15, corner };
    Profile::random(step, 10.0, &shape, &mut Random::new(7, purpose))
}

fn drive(step: f64, motion: Profile, current: Profile, duration: f64) -> Drive {
    Drive { step, duration, motion, current, winding: 25.0, housing: 25.0, seed: 1 }
}

fn pulse(step: f64, level: f64, from: f64, to: f64) -> Profile {
    let segment = |start, level| Segment { start, level, sines: 0.0 };
    Profile::new(step, 300.0, vec![segment(0.0, 0.0), segment(from, level), segment(to, 0.0)], &[])
}

#[test]
fn profile_agrees_with_its_slope_and_integral() {
    let step = 1e-3;
    let mut profile = rich(step, 20.0, 8.0, "speed");
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    let mut last = (profile.value(), profile.slope());
    for _ in 0..5000 {
        profile.advance();
        let now = (profile.value(), profile.slope());
        sum += 0.5 * step * (last.0 + now.0);
        worst = worst.max((now.0 - last.0 - 0.5 * step * (last.1 + now.1)).abs());
        last = now;
    }
    assert!((sum - profile.integral()).abs() < 1e-3, "{sum} {}", profile.integral());
    // Trapezoids err by h³/12 of the third derivative, at most (2π corner)³ times a step of the level.
    let bound = step.powi(3) / 12.0 * (TAU * 8.0).powi(3) * 2.5 * 20.0;
    assert!(worst < bound, "{worst} {bound}");
}

/// Work done against heat, mechanical work and stored energy, all of them of the order of the work.
fn energy_error(trace: &Trace, nature: &Nature) -> f64 {
    let m = &nature.machine;
    let step = trace.step;
    let count = trace.current.len();
    let resistance = |k: usize| m.resistance * (1.0 + nature.copper * (trace.winding[k] - 25.0));
    let in_ = integral(step, (0..count).map(|k| trace.voltage[k] * trace.current[k]));
    let gross = integral(step, (0..count).map(|k| (trace.voltage[k] * trace.current[k]).abs()));
    let copper = integral(step, (0..count).map(|k| resistance(k) * trace.current[k].powi(2)));
    let dead = integral(
        step,
        (0..count).map(|k| nature.dead_voltage * (trace.current[k] / nature.dead_current).tanh() * trace.current[k]),
    );
    let friction = integral(step, trace.friction_power.iter().copied());
    let out = integral(step, (0..count).map(|k| trace.torque[k] * trace.output_speed[k]));
    let stored =
        |k: usize| 0.5 * m.inductance * trace.current[k].powi(2) + 0.5 * m.inertia * trace.motor_speed[k].powi(2);
    (in_ - copper - dead - friction - out - (stored(count - 1) - stored(0))).abs() / gross
}

#[test]
fn energy_is_conserved_on_the_dynamometer() {
    let mut nature = nature(&[]);
    nature.set(Effect::StribeckFriction, 0.03);
    nature.set(Effect::LoadDependentFriction, 0.1);
    nature.set(Effect::EddyDrag, 0.03);
    nature.set(Effect::WindingTemperature, world::COPPER);
    nature.set(Effect::InverterDeadTime, 0.4);
    let m = &nature.machine;
    let step = 1.0 / 4000.0;
    let motion = rich(step, m.peak_speed / m.ratio, 8.0, "speed");
    let current = rich(step, 0.8 * m.peak_current, 40.0, "current");
    let trace = world::dynamometer(&nature, drive(step, motion, current, 10.0));
    let error = energy_error(&trace, &nature);
    assert!(error < 1e-3, "{error}");
}

#[test]
fn energy_is_conserved_with_a_free_load() {
    let mut nature = nature(&[]);
    nature.set(Effect::CoulombFriction, 0.02);
    nature.set(Effect::LoadDependentFriction, 0.1);
    let m = &nature.machine;
    let step = 1.0 / 4000.0;
    let motion = rich(step, m.peak_speed, 8.0, "speed");
    let trace = world::free(&nature, drive(step, motion, Profile::constant(step, 0.0), 10.0));
    let error = energy_error(&trace, &nature);
    assert!(error < 1e-3, "{error}");
    // All that went out is in the load.
    let out = integral(step, trace.torque.iter().zip(&trace.output_speed).map(|(t, w)| t * w));
    let last = trace.output_speed.len() - 1;
    let kinetic = 0.5 * m.load_inertia * (trace.output_speed[last].powi(2) - trace.output_speed[0].powi(2));
    let gross = integral(step, trace.torque.iter().zip(&trace.output_speed).map(|(t, w)| (t * w).abs()));
    assert!((out - kinetic).abs() < 1e-3 * gross, "{out} {kinetic}");
}

#[test]
fn energy_is_conserved_through_a_spring() {
    let mut nature = nature(&[]);
    let inertia = nature.machine.load_inertia;
    let stiffness = inertia * (TAU * 15.0).powi(2);
    nature.set(Effect::GearCompliance, 1.0 / stiffness);
    let n = nature.machine.ratio;
    let step = 1.0 / 8000.0;
    let motion = rich(step, nature.machine.peak_speed, 8.0, "speed");
    let trace = world::free(&nature, drive(step, motion, Profile::constant(step, 0.0), 10.0));
    let count = trace.torque.len();
    let twist = |k: usize| trace.motor_angle[k] / n - trace.output_angle[k];
    let rate = |k: usize| trace.motor_speed[k] / n - trace.output_speed[k];
    let damper = 2.0 * nature.compliance_damping * (stiffness * inertia).sqrt();
    let work = integral(step, (0..count).map(|k| trace.torque[k] * trace.motor_speed[k] / n));
    let gross = integral(step, (0..count).map(|k| (trace.torque[k] * trace.motor_speed[k] / n).abs()));
    let heat = integral(step, (0..count).map(|k| damper * rate(k).powi(2)));
    let stored = |k: usize| 0.5 * stiffness * twist(k).powi(2) + 0.5 * inertia * trace.output_speed[k].powi(2);
    let error = (work - heat - stored(count - 1) + stored(0)).abs() / gross;
    assert!(error < 1e-3, "{error}");
    assert!(heat > 1e-3 * gross, "the spring must have worked");
}

#[test]
fn servo_work_is_heat_and_height() {
    for gamma in [0.0, 0.15] {
        let mut random = Random::new(3, "servo");
        let mut nature = Nature::new(Machine::servo(&mut random), &[], &mut random);
        nature.set(Effect::LoadDependentFriction, gamma);
        nature.set(Effect::SupplySag, 0.5);
        let servo = simulator::Servo { gain: 3.0, mass: 0.3, length: 0.1 };
        let step = 1.0 / 8000.0;
        let motion = rich(step, 1.0, 3.0, "goal");
        let trace = world::servo(&nature, servo, drive(step, motion, Profile::constant(step, 0.0), 10.0));
        let m = &nature.machine;
        let count = trace.current.len();
        let power = |k: usize| trace.voltage[k] * trace.current[k];
        let in_ = integral(step, (0..count).map(power));
        let gross = integral(step, (0..count).map(|k| power(k).abs()));
        let copper = integral(step, trace.current.iter().map(|i| m.resistance * i * i));
        let friction = integral(step, trace.friction_power.iter().copied());
        let (q, w) = (trace.output_angle[count - 1], trace.output_speed[count - 1]);
        let inertia = servo.mass * servo.length.powi(2) + m.inertia * m.ratio.powi(2);
        let stored = 0.5 * inertia * w * w + servo.mass * 9.80665 * servo.length * (1.0 - q.cos());
        let error = (in_ - copper - friction - stored).abs() / gross;
        assert!(error < 1e-3, "{error} with {gamma}");
        // The supply falls by what the resistance takes, and the goal is followed.
        assert!(trace.supply.iter().all(|v| *v < m.bus + 1.0) && trace.supply.iter().any(|v| *v < m.bus - 0.05));
        let miss: Vec<f64> = (0..count).map(|k| trace.goal[k] - trace.output_angle[k]).collect();
        assert!(rms(&miss) < 0.7 * rms(&trace.goal), "{} {}", rms(&miss), rms(&trace.goal));
    }
}

#[test]
fn bristles_settle_at_the_stribeck_curve() {
    let mut nature = nature(&[]);
    nature.set(Effect::CoulombFriction, 0.02);
    nature.set(Effect::StribeckFriction, 0.03);
    nature.stribeck_speed = 5.0;
    for speed in [-80.0, -5.0, -0.3, 0.1, 2.0, 7.0, 150.0_f64] {
        let mut state = State::new(25.0, 25.0);
        for _ in 0..40_000 {
            state.slide(&nature, speed, 0.0, 1e-4);
        }
        let sliding = state.friction(&nature, speed) - nature.viscous * speed;
        let curve = (0.02 + 0.03 * (-(speed / 5.0_f64).powi(2)).exp()) * speed.signum();
        assert!((sliding / curve - 1.0).abs() < 1e-6, "{speed}: {sliding} {curve}");
    }
    // Before they slide they are a spring; a step of any length gives what many short ones give.
    let (mut one, mut many) = (State::new(25.0, 25.0), State::new(25.0, 25.0));
    let travel = 0.02 * nature.bristle;
    one.slide(&nature, travel, 0.0, 1.0);
    (0..1000).for_each(|_| many.slide(&nature, travel, 0.0, 1e-3));
    let (one, many) = (one.friction(&nature, 0.0), many.friction(&nature, 0.0));
    assert!((one / many - 1.0).abs() < 1e-9);
    assert!((one / (0.05 / nature.bristle * travel) - 1.0).abs() < 0.03, "{one}");
}

/// Frequency \[Hz\] of what swings about its mean, from its upward crossings.
fn frequency(values: &[f64], step: f64) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let crossings: Vec<f64> = values
        .windows(2)
        .enumerate()
        .filter(|(_, w)| w[0] < mean && w[1] >= mean)
        .map(|(k, w)| k as f64 + (mean - w[0]) / (w[1] - w[0]))
        .collect();
    (crossings.len() - 1) as f64 / (step * (crossings[crossings.len() - 1] - crossings[0]))
}

#[test]
fn two_masses_ring_at_their_own_frequency() {
    let step = 1.0 / 8000.0;
    for hertz in [9.0, 22.0] {
        let mut nature = nature(&[]);
        (nature.viscous, nature.coulomb) = (0.0, 0.0);
        nature.compliance_damping = 0.01;
        let n = nature.machine.ratio;
        // The motor jerks and stands: the load swings against the spring.
        let load = nature.machine.load_inertia;
        nature.set(Effect::GearCompliance, 1.0 / (load * (TAU * hertz).powi(2)));
        let motion = pulse(step, 20.0, 0.05, 0.1);
        let trace = world::free(&nature, drive(step, motion, Profile::constant(step, 0.0), 2.5));
        let found = frequency(&trace.output_angle[4000..], step);
        assert!((found / hertz - 1.0).abs() < 0.005, "{found} {hertz}");
        // The output stands and the current kicks: the rotor swings.
        let reflected = nature.machine.inertia * n * n;
        nature.set(Effect::GearCompliance, 1.0 / (reflected * (TAU * hertz).powi(2)));
        let current = pulse(step, 2.0, 0.05, 0.1);
        let trace = world::dynamometer(&nature, drive(step, Profile::constant(step, 0.0), current, 2.5));
        let found = frequency(&trace.motor_angle[4000..], step);
        assert!((found / hertz - 1.0).abs() < 0.005, "{found} {hertz}");
    }
}

#[test]
fn backlash_lets_go_within_the_gap_and_no_further() {
    let mut nature = nature(&[]);
    nature.set(Effect::Backlash, 0.01);
    let n = nature.machine.ratio;
    let step = 1.0 / 8000.0;
    let motion = rich(step, nature.machine.peak_speed, 8.0, "speed");
    let trace = world::free(&nature, drive(step, motion, Profile::constant(step, 0.0), 10.0));
    let (mut inside, mut outside) = (0, 0);
    for k in 0..trace.torque.len() {
        let twist = trace.motor_angle[k] / n - trace.output_angle[k];
        if twist.abs() < 0.005 {
            assert_eq!(trace.torque[k], 0.0);
            inside += 1;
        } else {
            assert!(trace.torque[k] * twist >= 0.0, "flanks push, they never pull");
            outside += 1;
        }
        assert!(twist.abs() < 0.02, "{twist}");
    }
    assert!(inside > 500 && outside > 500, "{inside} {outside}");
}

#[test]
fn winding_and_housing_reach_their_steady_temperatures() {
    let mut nature = nature(&[]);
    nature.copper = 0.0;
    let m = &nature.machine;
    let (current, step) = (0.4 * m.peak_current, 0.02);
    let still = Profile::constant(step, 0.0);
    let trace = world::dynamometer(&nature, drive(step, still, Profile::constant(step, current), 1500.0));
    let power = m.resistance * current * current;
    let housing = 25.0 + power * m.thermal_resistance[1];
    let winding = housing + power * m.thermal_resistance[0];
    let last = trace.winding.len() - 1;
    assert!((trace.housing[last] - housing).abs() < 0.01 && (trace.winding[last] - winding).abs() < 0.01);
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn every_effect_has_the_size_asked_for() {
    for effect in Effect::LIBRARY.into_iter().chain(Effect::OUTSIDE) {
        for (size, seed) in [(1.5, 11), (5.0, 12)] {
            let (_folder, truth) = written(&scenario(effect.name(), size, seed));
            let contributions: Vec<f64> = truth
                .logs
                .iter()
                .flat_map(|log| {
                    let mean = match effect {
                        Effect::DirectionAsymmetry => {
                            log.contribution.iter().sum::<f64>() / log.contribution.len() as f64
                        }
                        _ => 0.0,
                    };
                    log.contribution.iter().map(move |c| c - mean)
                })
                .collect();
            let noise: Vec<f64> = truth.logs.iter().flat_map(|log| log.noise.iter().copied()).collect();
            let found = rms(&contributions) / rms(&noise);
            assert!((found / size - 1.0).abs() < 0.1, "{} {size}: {found}", effect.name());
            assert!((rms(&noise) / truth.noise_rms - 1.0).abs() < 0.05);
        }
    }
}

#[test]
fn other_benches_give_the_size_too() {
    for (kind, effect) in [
        (Kind::SteadyTable, Effect::TorqueConstantSaturation),
        (Kind::SteadyTable, Effect::LoadDependentFriction),
        (Kind::Linear, Effect::DirectionAsymmetry),
        (Kind::Linear, Effect::TorqueOffset),
        (Kind::Servo, Effect::LoadDependentFriction),
        (Kind::Free, Effect::TorqueConstantSaturation),
        (Kind::Free, Effect::StribeckFriction),
        (Kind::Electrical, Effect::InverterDeadTime),
    ] {
        let (_folder, truth) = written(&clean(kind, 15).with_noise(effect, 5.0));
        let found = truth.effects[0].rms / truth.noise_rms;
        assert!((found / 5.0 - 1.0).abs() < 0.1, "{kind:?} {effect:?}: {found}");
        assert_eq!(truth.effects[0].parameters, truth.nature.parameters(effect));
    }
}

#[test]
fn pairs_have_both_sizes() {
    let (_folder, truth) = written(&pair("cogging", "torque_constant_saturation", 5.0, 4));
    assert_eq!(truth.names(), ["cogging", "torque_constant_saturation"]);
    for effect in &truth.effects {
        assert!((effect.rms / truth.noise_rms / 5.0 - 1.0).abs() < 0.1, "{effect:?}");
    }
    let (_folder, fixed) = written(&pair("winding_temperature", "inverter_dead_time", 5.0, 4));
    for effect in &fixed.effects {
        assert!((effect.rms / fixed.noise_rms / 5.0 - 1.0).abs() < 0.1, "{effect:?}");
    }
}

#[test]
fn same_seed_same_bytes() {
    for bench in [scenario("gravity", 5.0, 5), scenario("backlash", 5.0, 5), outside("random_walk", 5)] {
        let ((a, _), (b, _)) = (written(&bench), written(&bench));
        let (c, _) = written(&Bench { seed: bench.seed + 1, ..bench.clone() });
        for name in ["bench.toml", "motors.csv", "log1.csv", "log2.csv", "log3.csv"] {
            let read = |folder: &tempfile::TempDir| fs::read(folder.path().join(name)).unwrap();
            assert_eq!(read(&a), read(&b), "{name}");
            if name.starts_with("log") {
                assert_ne!(read(&a), read(&c), "{name}");
            }
        }
    }
}

#[test]
fn files_have_the_rows_and_columns_promised() {
    for kind in KINDS {
        let bench = clean(kind, 6).sensors(|s| (s.gaps, s.dropouts, s.jitter) = (2, 0.01, 0.3));
        let bench = if kind == Kind::SteadyTable { clean(kind, 6) } else { bench };
        let (folder, truth) = written(&bench);
        let file: toml::Table = fs::read_to_string(&truth.bench).unwrap().parse().unwrap();
        assert_eq!(file["kind"].as_str(), Some(kind.name()));
        let listed = file["log"].as_array().unwrap();
        assert_eq!(listed.len(), 3);
        for (log, entry) in truth.logs.iter().zip(listed) {
            let path = folder.path().join(entry["file"].as_str().unwrap());
            assert_eq!(path, log.file);
            assert_eq!(entry["use"].as_str(), Some(if log.held_out { "held_out" } else { "fit" }));
            let mut reader = csv::Reader::from_path(&path).unwrap();
            let header = reader.headers().unwrap().clone();
            for (_, column) in file["columns"].as_table().unwrap() {
                let name = column["name"].as_str().unwrap();
                assert!(header.iter().any(|h| h == name), "{name} {header:?}");
            }
            let (mut rows, mut blank) = (0, 0);
            for row in reader.records() {
                for cell in &row.unwrap() {
                    if cell.is_empty() {
                        blank += 1;
                    } else {
                        assert!(cell.parse::<f64>().unwrap().is_finite());
                    }
                }
                rows += 1;
            }
            assert_eq!(rows, log.times.len());
            assert!(rows > 100 && log.times.is_sorted());
            assert_eq!(blank > 0, kind != Kind::SteadyTable);
        }
        if kind != Kind::Linear {
            let mut reader = csv::Reader::from_path(folder.path().join("motors.csv")).unwrap();
            assert_eq!(reader.records().filter(Result::is_ok).count(), 1);
        }
    }
}

#[test]
fn a_poor_bench_shows_one_state() {
    for kind in [Kind::Dynamometer, Kind::Free, Kind::Electrical] {
        let (_folder, truth) = written(&clean(kind, 16).poor());
        for log in &truth.logs {
            let speeds = &log.trace.motor_speed;
            assert!(speeds[0] > 0.0 && speeds.iter().all(|w| (w - speeds[0]).abs() < 1e-6 * speeds[0]));
        }
    }
}

#[test]
fn several_runs_go_into_one_file() {
    let bench = Bench { one_file: true, ..clean(Kind::Dynamometer, 8) };
    let (folder, truth) = written(&bench);
    let mut reader = csv::Reader::from_path(folder.path().join("logs.csv")).unwrap();
    assert_eq!(reader.headers().unwrap().get(0), Some("run"));
    let total: usize = truth.logs.iter().map(|l| l.times.len()).sum();
    assert_eq!(reader.records().filter(Result::is_ok).count(), total);
    assert!(fs::read_to_string(&truth.bench).unwrap().contains("equals = \"run3\""));
}

/// A column of a log.
fn column(truth: &Truth, log: usize, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(&truth.logs[log].file).unwrap();
    let at = reader.headers().unwrap().iter().position(|h| h == name).unwrap();
    reader.records().map(|row| row.unwrap()[at].parse().unwrap()).collect()
}

#[test]
fn artefacts_are_what_they_are_said_to_be() {
    let bench = clean(Kind::Dynamometer, 9).sensors(|s| {
        s.velocity = Velocity::Estimate { late: 0.004 };
        s.torque_corner = f64::INFINITY;
        s.lags = vec![(Channel::Torque, 0.010)];
        s.gain_error = Some((1, 0.69));
        s.wrong_sign = Some(Channel::Current);
    });
    let (_folder, truth) = written(&bench);
    for (k, log) in truth.logs.iter().enumerate() {
        let gain = if k == 1 { 0.69 } else { 1.0 };
        let torque = column(&truth, k, "tau_nm");
        let speed = column(&truth, k, "w_radps");
        let current = column(&truth, k, "iq_a");
        let stride = (0.002 / log.trace.step).round() as usize;
        for row in (100..log.times.len()).step_by(997) {
            let then = |late: f64| row * stride - (late / log.trace.step).round() as usize;
            let expected = gain * (log.trace.torque[then(0.010)] + log.zero + log.noise[row]);
            assert!((torque[row] - expected).abs() < 1e-5, "{} {expected}", torque[row]);
            assert!((speed[row] - log.trace.motor_speed[then(0.004)]).abs() < 0.1);
            assert!((current[row] + log.trace.current[row * stride]).abs() < 0.01);
        }
    }
}

/// Mean over a window of rows, every so many rows.
fn smooth(values: &[f64]) -> Vec<f64> {
    const WINDOW: usize = 15;
    values.windows(WINDOW).step_by(4).map(|w| w.iter().sum::<f64>() / WINDOW as f64).collect()
}

/// Least squares of the target on regressors and a constant per log, all smoothed alike.
fn regression(logs: &[(Vec<f64>, Vec<Vec<f64>>)]) -> Vec<f64> {
    let count = logs[0].1.len();
    let width = count + logs.len();
    let mut normal = nalgebra::DMatrix::<f64>::zeros(width, width);
    let mut right = nalgebra::DVector::<f64>::zeros(width);
    for (which, (target, regressors)) in logs.iter().enumerate() {
        let target = smooth(target);
        let columns: Vec<Vec<f64>> = regressors.iter().map(|r| smooth(r)).collect();
        for (k, y) in target.iter().enumerate() {
            let mut row = nalgebra::DVector::<f64>::zeros(width);
            (0..count).for_each(|c| row[c] = columns[c][k]);
            row[count + which] = 1.0;
            normal += &row * row.transpose();
            right += *y * row;
        }
    }
    normal.lu().solve(&right).unwrap().as_slice()[..count].to_vec()
}

/// Slope by central differences over some rows.
fn slope(values: &[f64], time: &[f64]) -> Vec<f64> {
    let last = values.len() - 1;
    (0..=last)
        .map(|k| {
            let (a, b) = (k.saturating_sub(4), (k + 4).min(last));
            (values[b] - values[a]) / (time[b] - time[a])
        })
        .collect()
}

#[test]
fn plain_regression_finds_the_machine_in_the_logs() {
    // Instruments without lag: what is asked is whether the logs excite, not whether lags are found.
    let prompt = |bench: Bench| {
        bench.sensors(|s| {
            s.velocity = Velocity::Estimate { late: 0.0 };
            s.torque_corner = f64::INFINITY;
        })
    };
    for seed in 20..23 {
        let (_folder, truth) = written(&prompt(scenario("viscous_friction", 5.0, seed)));
        let logs: Vec<(Vec<f64>, Vec<Vec<f64>>)> = (0..3)
            .map(|k| {
                let speed = column(&truth, k, "w_radps");
                let acceleration = slope(&speed, &column(&truth, k, "t_s"));
                let sign = speed.iter().map(|w| (w / 0.3).tanh()).collect();
                let current = column(&truth, k, "iq_a");
                (column(&truth, k, "tau_nm"), vec![current, acceleration, speed, sign])
            })
            .collect();
        let found = regression(&logs);
        let (m, n) = (&truth.machine, truth.machine.ratio);
        let viscous = truth.effects[0].parameter("b");
        for (found, true_) in found.iter().zip([m.torque_constant, -m.inertia, -viscous, -m.coulomb]) {
            assert!((found / n / true_ - 1.0).abs() < 0.1, "{} {true_}", found / n);
        }
        let (_folder, truth) = written(&prompt(scenario("gravity", 5.0, seed)));
        let logs: Vec<(Vec<f64>, Vec<Vec<f64>>)> = (0..3)
            .map(|k| {
                let speed = column(&truth, k, "w_radps");
                let acceleration = slope(&speed, &column(&truth, k, "t_s"));
                let sign = speed.iter().map(|w| (w / 0.3).tanh()).collect();
                let angle: Vec<f64> = column(&truth, k, "q_rad").iter().map(|q| q / truth.machine.ratio).collect();
                let sine = angle.iter().map(|q| q.sin()).collect();
                let cosine = angle.iter().map(|q| q.cos()).collect();
                (column(&truth, k, "iq_a"), vec![acceleration, speed, sign, sine, cosine])
            })
            .collect();
        let found = regression(&logs);
        let (m, n) = (&truth.machine, truth.machine.ratio);
        let per_ampere: Vec<f64> = found.iter().map(|f| f * m.torque_constant).collect();
        let inertia = m.inertia + m.load_inertia / (n * n);
        for (found, true_) in per_ampere.iter().zip([inertia, m.viscous, m.coulomb]) {
            assert!((found / true_ - 1.0).abs() < 0.1, "{found} {true_}");
        }
        let gravity = per_ampere[3].hypot(per_ampere[4]) * n;
        let asked = truth.effects[0].parameter("m_g_l");
        assert!((gravity / asked - 1.0).abs() < 0.1, "{gravity} {asked}");
        let (_folder, truth) = written(&prompt(scenario("winding_temperature", 5.0, seed)));
        let logs: Vec<(Vec<f64>, Vec<Vec<f64>>)> = (0..3)
            .map(|k| {
                let current = column(&truth, k, "iq_a");
                let hot = column(&truth, k, "t_winding_c");
                let rise = current.iter().zip(&hot).map(|(i, t)| i * (t - 25.0)).collect();
                (column(&truth, k, "vq_v"), vec![current, rise, column(&truth, k, "w_radps")])
            })
            .collect();
        let found = regression(&logs);
        let m = &truth.machine;
        for (found, true_) in found.iter().zip([m.resistance, m.resistance * world::COPPER, m.torque_constant]) {
            assert!((found / true_ - 1.0).abs() < 0.1, "{found} {true_}");
        }
    }
}

#[test]
fn what_is_declared_can_be_wrong_or_blank() {
    let bench = clean(Kind::Dynamometer, 10).declared(|d| {
        d.torque_constant = 1.06;
        d.viscous = None;
    });
    let (folder, truth) = written(&bench);
    let mut reader = csv::Reader::from_path(folder.path().join("motors.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let row = reader.records().next().unwrap().unwrap();
    let cell = |name: &str| row.get(header.iter().position(|h| h.starts_with(name)).unwrap()).unwrap();
    let printed: f64 = cell("torque_constant").parse().unwrap();
    assert!((printed / truth.machine.torque_constant / 1.06 - 1.0).abs() < 1e-6);
    assert_eq!(cell("viscous_friction"), "");
    assert_ne!(cell("coulomb_friction"), "");
}

#[test]
fn shuffled_pieces_keep_their_size_and_lose_their_cause() {
    let (_folder, truth) = written(&shuffled("viscous_friction", 5.0, 13));
    assert!(truth.effects.is_empty());
    let pieces: Vec<f64> = truth.logs.iter().flat_map(|l| l.contribution.iter().copied()).collect();
    assert!((rms(&pieces) / truth.noise_rms / 5.0 - 1.0).abs() < 0.1);
    let speed: Vec<f64> = truth
        .logs
        .iter()
        .flat_map(|l| l.times.iter().map(|t| simulator::sense::at(&l.trace.motor_speed, l.trace.step, *t)))
        .collect();
    let dot: f64 = speed.iter().zip(&pieces).map(|(w, p)| w * p).sum::<f64>() / speed.len() as f64;
    assert!(dot.abs() < 0.2 * rms(&speed) * rms(&pieces), "{dot}");
}

#[test]
fn a_value_in_si_is_taken_as_it_is() {
    let (_folder, truth) = written(&Bench::free(14).with(Effect::TorqueOffset, Size::Value(0.01)));
    assert_eq!(truth.effects[0].parameter("torque"), 0.01);
    assert!((truth.effects[0].rms - 0.01 * truth.machine.ratio).abs() < 1e-9);
}
