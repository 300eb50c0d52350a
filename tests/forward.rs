//! The model simulated forward: against closed forms, against the suite's own simulator, and on real logs.

mod common;
mod simulator;

use std::f64::consts::TAU;
use std::path::PathBuf;

use common::repository;
use gearwise::actuator::effects::effect;
use gearwise::measured::identify::{Options, identify};
use gearwise::measured::read::read;
use gearwise::measured::simulate::{Input, Machine, Sample, State, Term, Track, forward_check, identify_servo};
use gearwise::measured::{Bench, BenchKind};

/// A machine without a motor's own inertia, driven by nothing.
fn idle(terms: Vec<Term>) -> Machine {
    Machine {
        ratio: 1.0,
        torque_constant: 1.0,
        resistance: 1.0,
        back_emf: 0.0,
        damping: 0.0,
        inertia: 0.0,
        load_scale: 1.0,
        lag: 0.0,
        terms,
    }
}

fn term(name: &str, values: &[f64]) -> Term {
    Term::new(effect(name).unwrap(), values.to_vec())
}

/// A pendulum let go at an angle: mass 0.5 kg at 0.2 m.
const INERTIA: f64 = 0.5 * 0.2 * 0.2;
const GRAVITY: f64 = 0.5 * 9.806_65 * 0.2;

fn pendulum(angle: f64, duration: f64) -> Track {
    let time: Vec<f64> = (0..(duration * 200.0) as usize).map(|k| k as f64 / 200.0).collect();
    Track {
        name: "pendulum".into(),
        fits: true,
        position: vec![0.0; time.len()],
        input: Input::Current(vec![0.0; time.len()]),
        supply: Vec::new(),
        volts_per_duty: 1.0,
        off: Vec::new(),
        load_inertia: INERTIA,
        load_gravity: GRAVITY,
        winding: Vec::new(),
        housing: Vec::new(),
        starts: vec![(0, State { position: angle, speed: 0.0 })],
        time,
    }
}

/// Extremes of a curve, by a parabola through three samples.
fn extremes(values: &[f64]) -> Vec<f64> {
    (1..values.len() - 1)
        .filter(|k| (values[*k] - values[k - 1]) * (values[k + 1] - values[*k]) < 0.0)
        .map(|k| {
            let (a, b, c) = (values[k - 1], values[k], values[k + 1]);
            b - (c - a).powi(2) / (8.0 * (a - 2.0 * b + c))
        })
        .collect()
}

#[test]
fn a_pendulum_swings_with_the_period_of_small_oscillations() {
    let track = pendulum(0.01, 20.0);
    let q = track.simulate(&idle(Vec::new()));
    let crossings: Vec<f64> = (1..q.len())
        .filter(|k| q[k - 1] > 0.0 && q[*k] <= 0.0)
        .map(|k| track.time[k - 1] + (track.time[k] - track.time[k - 1]) * q[k - 1] / (q[k - 1] - q[k]))
        .collect();
    let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    approx::assert_relative_eq!(period, TAU * (INERTIA / GRAVITY).sqrt(), max_relative = 1e-4);
}

#[test]
fn coulomb_friction_takes_the_same_angle_each_half_swing_and_then_holds() {
    let coulomb = 0.004;
    let start = 0.05;
    let track = pendulum(start, 20.0);
    let q = track.simulate(&idle(vec![term("coulomb_friction", &[coulomb])]));
    // Small oscillations lose 2 c/(m g l) each half swing.
    let lost = 2.0 * coulomb / GRAVITY;
    let swings = extremes(&q);
    for (k, extreme) in swings.iter().take(4).enumerate() {
        approx::assert_relative_eq!(extreme.abs(), start - lost * (k + 1) as f64, max_relative = 5e-3);
    }
    let last = *q.last().unwrap();
    assert!(last.abs() <= 0.5 * lost * 1.001, "it holds where gravity does not overcome friction: {last}");
    assert!(q[q.len() - 400..].iter().all(|v| *v == last), "it stands still");
}

#[test]
fn a_pendulum_that_friction_holds_does_not_creep() {
    let angle: f64 = 0.3;
    let hold = GRAVITY * angle.sin();
    let stays = pendulum(angle, 5.0).simulate(&idle(vec![term("coulomb_friction", &[1.001 * hold])]));
    assert!(stays.iter().all(|q| *q == angle));
    let falls = pendulum(angle, 5.0).simulate(&idle(vec![term("coulomb_friction", &[0.98 * hold])]));
    assert!(falls.iter().any(|q| *q < 0.99 * angle));
}

#[test]
fn friction_never_makes_energy() {
    let frictions = [
        vec![term("viscous_friction", &[0.002])],
        vec![term("coulomb_friction", &[0.01])],
        vec![term("stribeck_friction", &[0.02, 0.5])],
        vec![term("load_dependent_friction", &[0.1])],
        vec![term("eddy_drag", &[0.02, 2.0])],
        vec![term("coulomb_friction", &[0.01]), term("stribeck_friction", &[0.02, 0.5]), term("load_dependent_friction", &[0.1])],
    ];
    for terms in frictions {
        let machine = idle(terms);
        let mut state = State { position: 1.2, speed: 0.0 };
        let sample = Sample {
            input: 0.0,
            is_voltage: false,
            is_open: false,
            duty: 0.0,
            load_inertia: INERTIA,
            load_gravity: GRAVITY,
            winding_rise: 0.0,
            housing_rise: 0.0,
        };
        let energy = |s: State| 0.5 * INERTIA * s.speed * s.speed + GRAVITY * (1.0 - s.position.cos());
        let start = energy(state);
        let mut turn = start;
        for _ in 0..40_000 {
            let next = machine.step(state, &sample, 2.5e-4);
            // Over a half swing: within a step the semi-implicit energy wavers by the square of the step.
            if next.speed * state.speed <= 0.0 {
                assert!(energy(next) <= turn * (1.0 + 1e-9), "{machine:?}");
                turn = energy(next);
            }
            assert!(energy(next) <= start * (1.0 + 1e-9), "{machine:?}");
            state = next;
        }
        assert!(energy(state) < 0.9 * start, "{machine:?} lost nothing");
    }
}

/// A bench of real data, where the data are there: in `GEARWISE_SHARED`, or beside the repository.
fn real(name: &str) -> Option<Bench> {
    let shared = std::env::var_os("GEARWISE_SHARED").map_or_else(|| repository("../shared"), PathBuf::from);
    if !shared.join("data").is_dir() {
        println!("skipped: ../shared/data is not there");
        return None;
    }
    // The bench files name the data relative to their own place; a copy names them where they are.
    let folder = tempfile::tempdir().unwrap();
    let benches = repository("tests/fixtures/benches");
    for file in [name, "xl330_motor.csv"] {
        let text = std::fs::read_to_string(benches.join(file)).unwrap();
        let text = text.replace("../../../../shared", &shared.canonicalize().unwrap().to_string_lossy());
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    Some(read(&folder.path().join(name)).unwrap_or_else(|e| panic!("{e:?}")))
}

#[test]
fn emps_simulated_from_its_force() {
    let Some(bench) = real("emps.toml") else { return };
    assert!(bench.logs.iter().all(|l| l.kind == BenchKind::Linear));
    let reports = identify(&bench, &Options::default()).unwrap();
    let check = forward_check(&bench, &reports[0]).unwrap();
    println!("{check:#?}");
    let refitted = check.refitted.unwrap();
    assert!(check.after.fit < 0.1 * check.before.fit);
    assert!(refitted.held_out.unwrap() <= 5e-3);
}

#[test]
fn xl330_through_its_controller() {
    let Some(bench) = real("xl330.toml") else { return };
    let report = identify_servo(&bench).unwrap();
    for s in &report.stages {
        println!("{:28} {:.4} {:?}", s.name, s.fit, s.held_out);
    }
    println!("{:#?}\n{:#?}\n{:#?}\n{:?}\n{:?}", report.parameters, report.effects, report.refused, report.unexplained, report.artefacts);
    let names: Vec<&str> = report.effects.iter().map(|e| e.name).collect();
    assert!(names.contains(&"load_dependent_friction"), "{names:?}");
    assert!(!names.contains(&"stribeck_friction"), "{names:?}");
    println!("{:#?}", forward_check(&bench, &report));
}
