//! The model simulated forward: against closed forms, against the suite's own simulator, and on real logs.

use std::f64::consts::TAU;

use gearwise::effects::effect;
use gearwise::measured::identify::{Found, Options, Report, Target, Verdict, identify};
use gearwise::measured::read::read;
use gearwise::measured::simulate::{Input, Machine, Sample, State, Term, Track, forward_check, identify_servo};
use gearwise::measured::{Bench, BenchKind};
use gearwise::numerics::least_squares::{Unknown, minimise};
use gearwise::report::forward;
use gearwise::report::json::identify::Forward;

use crate::common::real::on_each;
use crate::simulator;

/// A machine without a motor's own inertia, driven by nothing.
fn idle(terms: Vec<Term>) -> Machine {
    Machine {
        ratio: 1.0,
        torque_constant: 1.0,
        resistance: 1.0,
        back_emf: 0.0,
        damping: 0.0,
        inertia: 0.0,
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
        held: false,
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
        vec![term("stribeck_friction", &[0.02, 5.0])],
        vec![term("load_dependent_friction", &[0.1])],
        vec![term("eddy_drag", &[0.02, 2.0])],
        vec![
            term("coulomb_friction", &[0.01]),
            term("stribeck_friction", &[0.02, 0.5]),
            term("load_dependent_friction", &[0.1]),
        ],
    ];
    for terms in frictions {
        // A rotor: what only the load moves is not transmitted.
        let machine = Machine { inertia: 0.5 * INERTIA, ..idle(terms) };
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
        let energy = |s: State| 0.75 * INERTIA * s.speed * s.speed + GRAVITY * (1.0 - s.position.cos());
        let start = energy(state);
        let mut turn = start;
        for _ in 0..40_000 {
            let next = machine.step(state, &sample, 2.5e-4);
            // Over a half swing: within it the semi-implicit energy wavers by (ω h)²/8 = 4e-7.
            if next.speed * state.speed <= 0.0 {
                assert!(energy(next) <= turn * (1.0 + 1e-6), "{machine:?}");
                turn = energy(next);
            }
            assert!(energy(next) <= start * (1.0 + 1e-6), "{machine:?}");
            state = next;
        }
        assert!(energy(state) < 0.99 * start, "{machine:?} lost nothing");
    }
}

/// A bench of real data, where the data are there.
fn real(name: &str) -> Option<Bench> {
    on_each(&[name], |_, path| read(path).unwrap_or_else(|e| panic!("{e:?}"))).pop()
}

/// An effect as a report has it.
fn found(name: &str, values: &[f64]) -> Found {
    let effect = effect(name).unwrap();
    Found {
        effect,
        parameters: Vec::new(),
        instances: vec![values.to_vec()],
        size: 0.0,
        held_out_before: None,
        held_out_after: None,
        confounded_with: Vec::new(),
    }
}

/// A report with these effects, whatever the regression found.
fn report_with(bench: &Bench, mass: f64, effects: &[(&str, &[f64])]) -> Report {
    let mut report = identify(bench, &Options::default()).unwrap().remove(0);
    assert_eq!(report.target, Target::Drive);
    report.parameters.retain(|p| p.name == "mass");
    for p in &mut report.parameters {
        (p.fitted, p.standard_error) = (mass, Some(0.1));
    }
    assert_eq!(report.parameters.len(), 1);
    report.artefacts.clear();
    report.effects = effects.iter().map(|(name, values)| found(name, values)).collect();
    report
}

/// Root mean square error of a log, simulated from rest as the data's README does it.
fn from_rest(bench: &Bench, log: usize, machine: &Machine) -> f64 {
    let mut track = Track::new(&bench.logs[log], &bench.declared).unwrap();
    track.starts.iter_mut().for_each(|s| s.1.speed = 0.0);
    let squares: f64 = track.residual(machine).iter().map(|r| r * r).sum();
    (squares / track.count() as f64).sqrt()
}

fn axis(values: &[f64]) -> Machine {
    let terms = vec![
        term("viscous_friction", &[values[1]]),
        term("coulomb_friction", &[values[2]]),
        term("torque_offset", &[values[3]]),
    ];
    Machine { inertia: values[0], ..idle(terms) }
}

#[test]
fn emps_from_rest_as_its_readme_has_it() {
    let Some(bench) = real("emps") else { return };
    let published = [95.1089, 203.5034, 20.3935, -3.1648];
    let machine = axis(&published);
    // 6.81 and 9.17 mm with another integrator.
    approx::assert_relative_eq!(from_rest(&bench, 0, &machine), 6.81e-3, max_relative = 0.02);
    approx::assert_relative_eq!(from_rest(&bench, 1, &machine), 9.17e-3, max_relative = 0.02);
    let mut track = Track::new(&bench.logs[0], &bench.declared).unwrap();
    track.starts[0].1.speed = 0.0;
    let of = |_: usize, values: &[f64]| track.residual(&axis(values));
    let unknowns: Vec<Unknown> = published
        .iter()
        .map(|v| Unknown { start: *v, scale: v.abs(), lower: f64::NEG_INFINITY, upper: f64::INFINITY })
        .collect();
    let fitted = minimise(1, &of, &unknowns, 40, 1e-6);
    let machine = axis(&fitted.values);
    let errors = [from_rest(&bench, 0, &machine), from_rest(&bench, 1, &machine)];
    println!("{:?} {errors:?}", fitted.values);
    // 2.72 and 4.75 mm there; in this flat valley 2.58 and 5.06 mm here.
    assert!(errors[0] <= 2.72e-3, "{errors:?}");
    assert!(errors[1] < from_rest(&bench, 1, &axis(&published)), "{errors:?}");
}

#[test]
fn emps_simulated_from_its_force() {
    let Some(bench) = real("emps") else { return };
    assert!(bench.logs.iter().all(|l| l.kind == BenchKind::Linear));
    let published: [(&str, &[f64]); 3] =
        [("viscous_friction", &[203.5034]), ("coulomb_friction", &[20.3935]), ("torque_offset", &[-3.1648])];
    let check = forward_check(&bench, &report_with(&bench, 95.1089, &published)).unwrap();
    let json = serde_json::to_value(Forward::new(&check)).unwrap();
    println!("{}{json}", forward::text(&check));
    // It starts at 7 mm/s, not from rest: better than the 6.81 and 9.17 mm of the data's README.
    assert!(check.after.fit < 6.81e-3 && check.after.held_out.unwrap() < 9.17e-3, "{check:?}");
    assert!(check.without.is_empty(), "{check:?}");
    let refitted = check.refitted.unwrap();
    assert!(refitted.fit < 0.7 * check.after.fit && refitted.held_out < check.after.held_out, "{check:?}");
    assert_eq!(json["unit"], "m");
    assert_eq!(json["fitted_for_simulation"]["fit"], refitted.fit);
}

#[test]
fn emps_as_identified() {
    let Some(bench) = real("emps") else { return };
    let report = identify(&bench, &Options::default()).unwrap().remove(0);
    for e in &report.effects {
        println!("{} {:?}", e.name(), e.instances);
    }
    println!("{:?} {:?}", report.parameters, report.artefacts);
    let check = forward_check(&bench, &report).unwrap();
    println!("{check:?}");
    assert!(check.after.fit < 0.1 * check.before.fit);
}

#[test]
fn xl330_through_its_controller() {
    let Some(bench) = real("xl330") else { return };
    let report = identify_servo(&bench).unwrap();
    for s in &report.stages {
        println!("{:28} {:.4} {:?}", s.step.name(), s.fit, s.held_out);
    }
    println!(
        "{:#?}\n{:#?}\n{:#?}\n{:?}\n{:?}",
        report.parameters, report.effects, report.refused, report.unexplained, report.artefacts
    );
    let names: Vec<&str> = report.effects.iter().map(|e| e.name()).collect();
    assert!(names.contains(&"load_dependent_friction"), "{names:?}");
    assert!(!names.contains(&"stribeck_friction"), "{names:?}");
    // The README's load-dependent model has 0.051 rad on the held-out logs, its best without that 0.073.
    let last = report.stages.last().unwrap();
    assert!(last.held_out.unwrap() < 0.06, "{last:?}");
    assert_eq!(report.stages[1].step.name(), "refit");
    assert!(last.held_out.unwrap() < 0.7 * report.stages[1].held_out.unwrap());
    let check = forward_check(&bench, &report).unwrap();
    assert!(check.closed_loop && check.after.held_out < check.before.held_out, "{check:?}");
}

/// Runs a simulated bench.
fn simulated(bench: &simulator::Bench) -> (simulator::Truth, Bench, Report) {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = bench.write(folder.path());
    let bench = read(&truth.bench).unwrap_or_else(|e| panic!("{e:?}"));
    let report = identify_servo(&bench).unwrap();
    (truth, bench, report)
}

/// A servo bench with an undeclared effect.
fn servo_with(name: &str, size: f64, seed: u64) -> simulator::Bench {
    let effect = simulator::Effect::named(name).unwrap();
    let mut bench = simulator::Bench::servo(seed).with_noise(effect, size);
    match name {
        "coulomb_friction" => bench.declared.coulomb = None,
        "supply_sag" => bench.sensors.hidden.push(simulator::Channel::Supply),
        _ => {}
    }
    bench
}

#[test]
fn a_servo_that_lacks_nothing_gets_no_name() {
    let (_, _, report) = simulated(&simulator::clean(simulator::Kind::Servo, 7));
    assert!(report.effects.is_empty() && report.artefacts.is_empty(), "{:?}", report.effects);
    // How much the refused ones could still explain is not bounded by simulation.
    assert_eq!(report.verdict, Verdict::NotResolved);
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn a_servo_tells_its_load_dependent_friction() {
    let (truth, bench, report) = simulated(&servo_with("load_dependent_friction", 5.0, 8));
    let names: Vec<&str> = report.effects.iter().map(|e| e.name()).collect();
    assert_eq!(names, ["load_dependent_friction"]);
    let wanted = truth.effects[0].parameter("gamma");
    approx::assert_relative_eq!(report.effects[0].instances[0][0], wanted, max_relative = 0.1);
    for (name, wanted) in [("torque_constant", truth.machine.torque_constant), ("inertia", truth.machine.inertia)] {
        let parameter = report.parameters.iter().find(|p| p.name == name).unwrap();
        approx::assert_relative_eq!(parameter.fitted, wanted, max_relative = 0.1);
    }
    let check = forward_check(&bench, &report).unwrap();
    assert!(check.closed_loop && check.unit == "rad");
    approx::assert_relative_eq!(check.after.fit, report.stages.last().unwrap().fit, max_relative = 1e-6);
    assert!(check.after.held_out.unwrap() < 0.5 * check.before.held_out.unwrap(), "{check:?}");
}

/// The score of servo benches. Slow: run with `--release -- --ignored --nocapture servo_confusion`.
#[test]
#[ignore = "slow: the score, not a check"]
fn servo_confusion() {
    let number = |name: &str, usual| std::env::var(name).ok().and_then(|s| s.parse().ok()).unwrap_or(usual);
    let (first, count) = (number("GEARWISE_FIRST_SEED", 1000), number("GEARWISE_SEEDS", 3));
    for (name, size) in [
        ("clean", 0.0),
        ("supply_sag", 5.0),
        ("load_dependent_friction", 5.0),
        ("coulomb_friction", 5.0),
        ("stribeck_friction", 5.0),
        ("load_dependent_friction", 1.5),
        ("coulomb_friction", 1.5),
    ] {
        if std::env::var("GEARWISE_ONLY").is_ok_and(|only| !name.contains(&only)) {
            continue;
        }
        let mut right = 0;
        for seed in first..first + count {
            let bench = if name == "clean" {
                simulator::clean(simulator::Kind::Servo, seed)
            } else {
                servo_with(name, size, seed)
            };
            let (truth, _, report) = simulated(&bench);
            let given: Vec<&str> = report.effects.iter().map(|e| e.name()).collect();
            right += usize::from(given == truth.names());
            println!(
                "   {name} {size} seed {seed}: {given:?} {:?} left {:.1e} lag {:?} {:?} {:?}",
                report.verdict,
                report.evidence.left,
                report.artefacts.iter().map(|a| a.value).collect::<Vec<_>>(),
                report
                    .stages
                    .iter()
                    .map(|s| format!("{} {:.2e}/{:.2e}", s.step.name(), s.fit, s.held_out.unwrap_or(f64::NAN)))
                    .collect::<Vec<_>>(),
                report.effects.iter().map(|e| (&e.instances, &e.confounded_with)).collect::<Vec<_>>(),
            );
            println!(
                "      {:?}",
                report
                    .parameters
                    .iter()
                    .map(|p| (p.name.clone(), p.declared, p.fitted, p.standard_error))
                    .collect::<Vec<_>>()
            );
            println!(
                "      true {:?}",
                truth.effects.iter().map(|e| (e.name, &e.parameters, e.rms)).collect::<Vec<_>>()
            );
            for r in report.refused.iter().filter(|r| truth.names().contains(&r.name.as_str())) {
                println!("      refused {}: {}", r.name, r.reason);
            }
        }
        println!("{name} at {size} x noise: {right} of {count} right");
    }
}
