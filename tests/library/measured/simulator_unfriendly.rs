//! The simulator's benches without current, and what is unfriendly about a bench, judged by themselves.

use crate::simulator::{
    Bench, Channel, Colour, Effect, Kind, Nature, Stale, Truth, Unfriendly, Velocity, clean, driven::Machine,
    random::Random,
};

fn written(bench: &Bench) -> (tempfile::TempDir, Truth) {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = bench.write(folder.path());
    (folder, truth)
}

/// A short bench with instruments that are not late.
fn short(kind: Kind, change: impl FnOnce(&mut Unfriendly)) -> Bench {
    clean(kind, 41).sampled(8.0, 200.0).sensors(|s| {
        s.velocity = Velocity::Estimate { late: 0.0 };
        s.colored = 0.0;
        change(&mut s.unfriendly);
    })
}

/// A column of a log.
fn column(truth: &Truth, log: usize, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(&truth.logs[log].file).expect("the log");
    let at = reader.headers().expect("a header").iter().position(|h| h == name).unwrap_or_else(|| panic!("no {name}"));
    reader.records().map(|row| row.expect("a row")[at].parse().expect("a number")).collect()
}

/// Correlation of neighbours.
fn neighbours(values: &[f64]) -> f64 {
    let square: f64 = values.iter().map(|v| v * v).sum();
    values.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / square
}

#[test]
fn a_random_torque_turns_the_machine_and_the_sensor_has_the_actuator() {
    for effect in [Effect::CoulombFriction, Effect::LoadDependentFriction, Effect::EddyDrag] {
        let (_folder, truth) = written(&short(Kind::RandomTorque, |_| {}).with_noise(effect, 5.0));
        let (trace, machine) = (&truth.logs[0].trace, Machine::of(&truth.machine));
        let largest = trace.command.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let (m, ratio) = (&truth.machine, truth.machine.ratio);
        for k in (0..trace.command.len()).step_by(7) {
            let turned = machine.inertia * trace.output_acceleration[k] + machine.damping * trace.output_speed[k];
            let error = trace.command[k] - turned;
            assert!(error.abs() < 1e-9 * largest, "{effect:?} at {k}: {error} of {largest}");
            // The sensor has what the actuator takes: its inertia, and a drag that never drives.
            let drag = -trace.torque[k] / ratio - m.inertia * trace.motor_acceleration[k];
            let settled = trace.motor_speed[k].abs() > 0.05 * m.peak_speed;
            assert!(!settled || drag * trace.motor_speed[k] > 0.0, "{effect:?} at {k}: {drag}");
        }
        // The motion is the same without it.
        let plain =
            short(Kind::RandomTorque, |_| {}).simulate(&Nature::new(m.clone(), &[], &mut Random::new(1, "")), 0);
        assert_eq!(plain.motor_speed, trace.motor_speed);
        let fastest = trace.motor_speed.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        assert!((0.3..2.0).contains(&(fastest / truth.machine.peak_speed)), "{fastest}");
        assert!(trace.motor_speed.iter().any(|w| *w < 0.0) && trace.motor_speed.iter().any(|w| *w > 0.0));
    }
}

#[test]
fn benches_without_current_have_the_size_asked_for_and_can_be_read() {
    for kind in [Kind::Drag, Kind::RandomTorque] {
        for effect in [Effect::EddyDrag, Effect::Cogging { order: 12 }, Effect::CoulombFriction] {
            let (_folder, truth) = written(&short(kind, |_| {}).with_noise(effect, 5.0));
            let all: Vec<f64> = truth.logs.iter().flat_map(|l| l.contribution.clone()).collect();
            let rms = (all.iter().map(|c| c * c).sum::<f64>() / all.len() as f64).sqrt();
            assert!((rms / truth.noise_rms / 5.0 - 1.0).abs() < 0.15, "{kind:?} {effect:?}: {rms} {}", truth.noise_rms);
            let bench = gearwise::measured::read::read(&truth.bench).unwrap_or_else(|e| panic!("{e:?}"));
            assert_eq!(bench.logs[0].kind.name(), kind.name());
            assert!(bench.logs[0].channel(gearwise::measured::Channel::Current).is_none());
        }
    }
}

#[test]
fn noise_has_the_colour_asked_for() {
    let correlation = |change: &dyn Fn(&mut Unfriendly)| {
        let (_folder, truth) = written(&short(Kind::Dynamometer, change));
        let noise: Vec<f64> = truth.logs.iter().flat_map(|l| l.noise.clone()).collect();
        let rms = (noise.iter().map(|n| n * n).sum::<f64>() / noise.len() as f64).sqrt();
        assert!((rms / truth.noise_rms - 1.0).abs() < 0.05, "{rms}");
        neighbours(&noise)
    };
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 0.06, "{found} {wanted}");
    near(correlation(&|_| {}), 0.0);
    near(correlation(&|u| u.colour = Some(Colour { share: 1.0, time: 0.05, blue: false })), (-0.005_f64 / 0.05).exp());
    near(correlation(&|u| u.colour = Some(Colour { share: 0.5, time: 0.05, blue: false })), 0.5 * (-0.1_f64).exp());
    near(correlation(&|u| u.colour = Some(Colour { share: 1.0, time: 0.0, blue: true })), -0.5);
    // Two lags of 30 Hz: the correlation of white noise behind them is (1 + x) e^−x with x = 2π f t.
    let x = std::f64::consts::TAU * 30.0 * 0.005;
    near(correlation(&|u| u.anti_alias = Some(30.0)), (1.0 + x) * (-x).exp());
}

#[test]
fn what_is_held_stale_or_scaled_is_so_in_the_log() {
    let (_a, plain) = written(&short(Kind::Dynamometer, |_| {}));
    let (_b, held) = written(&short(Kind::Dynamometer, |u| u.held_channel = Some((Channel::Current, 7))));
    let (_c, spoiled) = written(&short(Kind::Dynamometer, |u| {
        u.stale = Some(Stale { channel: Channel::Torque, log: 1, from: 0.5, length: 0.25 });
        u.velocity_scale = Some(0.1);
        u.ampere = Some(2.0);
    }));
    let current = column(&plain, 0, "iq_a");
    let repeated = column(&held, 0, "iq_a");
    assert!((0..current.len()).all(|k| repeated[k] == current[k - k % 7]));
    assert_eq!(column(&plain, 0, "tau_nm"), column(&held, 0, "tau_nm"));
    let torque = (column(&plain, 1, "tau_nm"), column(&spoiled, 1, "tau_nm"));
    let frozen = (0..torque.0.len()).filter(|k| torque.0[*k] != torque.1[*k]).count();
    assert!((45..=51).contains(&frozen), "{frozen} rows of a quarter of a second at 200 Hz");
    assert_eq!(column(&plain, 0, "tau_nm"), column(&spoiled, 0, "tau_nm"));
    for (a, b) in column(&plain, 0, "w_radps").iter().zip(column(&spoiled, 0, "w_radps")) {
        assert!((0.1 * a - b).abs() < 1e-4, "{a} {b}");
    }
    for (a, b) in current.iter().zip(column(&spoiled, 0, "iq_a")) {
        assert!((2.0 * a - b).abs() < 1e-4, "{a} {b}");
    }
}

#[test]
fn a_held_log_keeps_its_command_fresh_and_a_quantum_is_one() {
    let (_folder, truth) = written(&short(Kind::RandomTorque, |u| {
        u.held_log = Some(5);
        u.quantum = Some(2.0);
    }));
    let changes = |name: &str| column(&truth, 0, name).windows(2).filter(|w| w[0] != w[1]).count();
    let rows = truth.logs[0].times.len();
    assert!(changes("w_radps") <= rows / 5 && changes("q_rad") <= rows / 5 && changes("command_a") > rows / 2);
    let quantum = 2.0 * truth.noise_rms;
    for value in column(&truth, 0, "tau_nm") {
        let steps = value / quantum;
        assert!((steps - steps.round()).abs() < 1e-3, "{value} {quantum}");
    }
    let log = &truth.logs[0];
    assert!(log.rounding.iter().all(|r| r.abs() <= 0.5001 * quantum) && log.rounding.iter().any(|r| *r != 0.0));
}
