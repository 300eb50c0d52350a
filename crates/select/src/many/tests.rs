use std::sync::Arc;

use super::*;
use gearwise_model::input::Source;
use gearwise_model::motion::Point;
use gearwise_model::requirement::{Objective, read_source};

/// A robot whose one joint does something random at so many samples.
fn robot(samples: usize, seed: u64) -> Robot {
    let text = "name = \"random\"\n[bus]\nvoltage = \"24 V\"\ndrive_current = \"30 A\"\n[[joint]]\nname = \"knee\"\n\
                ratio = { min = 2, max = 40 }\ngear = { efficiency = 0.9, inertia = \"1e-6 kg*m^2\" }\nobjective = \"loss\"\n\
                points = [{ torque = \"1 N*m\", speed = \"1 rad/s\" }]\n[joint.limits]\nreflected_inertia = \"0.1 kg*m^2\"\n";
    let mut robot = read_source(&Arc::new(Source::new("random.toml", text))).unwrap();
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut normal = || {
        let mut sum = 0.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum - 6.0
    };
    let point = |_| Point {
        torque: 2.0 * normal(),
        velocity: 3.0 * normal(),
        acceleration: 30.0 * normal(),
        torque_rate: 60.0 * normal(),
        jerk: 500.0 * normal(),
        duration: Some(0.002),
    };
    let points: Vec<Point> = (0..samples).map(point).collect();
    robot.joints[0].motion = Arc::new(Motion::from_points(&points));
    robot
}

#[test]
fn the_answer_is_that_of_all_samples() {
    let builtin = Catalog::builtin().unwrap();
    for seed in 1..=3 {
        // A part of the motors for each seed: every sample of each of them is computed.
        let counts = |index: usize| crate::cases::are_all() || index % 12 == 4 * (seed as usize - 1);
        let mut catalog = builtin.clone();
        catalog.motors =
            builtin.motors.iter().enumerate().filter(|(k, _)| counts(*k)).map(|(_, m)| m.clone()).collect();
        let whole = robot(MANY + 5_000, seed);
        let (some, told) = with_samples(whole.clone(), &catalog, Options::default()).unwrap();
        assert!(told[0].at < 5_000 && told[0].of == MANY + 5_000, "{told:?}");
        let (all, part) = (crate::optimize(&whole, &catalog), crate::optimize(&some, &catalog));
        let (all, part) = (&all.joints[0], &part.joints[0]);
        let least = if crate::cases::are_all() { 6 } else { 2 };
        assert!(all.candidates.len() >= least, "{}", all.candidates.len());
        let ids = |of: &JointResult| of.candidates.iter().map(|d| d.motor.id.clone()).collect::<Vec<_>>();
        assert_eq!(ids(all), ids(part));
        for (a, b) in all.candidates.iter().zip(&part.candidates) {
            let near = |x: f64, y: f64, by: f64| assert!((x - y).abs() <= by * x.abs(), "{}: {x} {y}", a.motor.id);
            near(a.optimum.objective, b.optimum.objective, 1e-9);
            near(a.optimum.ratio, b.optimum.ratio, 1e-4);
            near(a.optimum.window().min, b.optimum.window().min, 1e-6);
            near(a.optimum.window().max, b.optimum.window().max, 1e-6);
            for (x, y) in a.evaluation.margins.iter().zip(&b.evaluation.margins) {
                assert!((x.margin - y.margin).abs() < 1e-6 * (1.0 + x.margin.abs()), "{}: {}", a.motor.id, x.limit);
            }
        }
        assert_eq!(all.rejected.len(), part.rejected.len());
    }
}

#[test]
fn a_short_motion_and_one_whose_peak_is_minimised_are_looked_at_whole() {
    let catalog = Catalog::builtin().unwrap();
    let (short, told) = with_samples(robot(300, 5), &catalog, Options::default()).unwrap();
    assert!(told.is_empty() && short.joints[0].motion.looked.is_none());
    let mut peak = robot(MANY + 10, 5);
    peak.joints[0].objective = Objective { terms: vec![(Quantity::PeakCurrent, 1.0)] };
    let (peak, told) = with_samples(peak, &catalog, Options::default()).unwrap();
    assert!(told.is_empty() && peak.joints[0].motion.looked.is_none());
}

#[test]
fn an_answer_that_exceeds_limits_between_its_samples_says_which() {
    let mut catalog = Catalog::builtin().unwrap();
    catalog.motors = catalog.motors.iter().step_by(40).cloned().collect();
    let whole = robot(MANY + 5_000, 7);
    let (all, options) = (crate::optimize(&whole, &catalog), Options::default());
    let mut some = whole.clone();
    some.joints[0].motion =
        Arc::new(Motion { looked: Some((0..10).collect()), ..Motion::clone(&whole.joints[0].motion) });
    let mut looked = [Looked { joint: "knee".into(), at: 10, of: MANY + 5_000, rounds: 0 }];
    loop {
        let part = crate::optimize(&some, &catalog);
        let Some(more) = with_exceeded(&part, &mut looked, &catalog, options).unwrap() else { break };
        assert_eq!(more.joints[0].motion.looked_at().len(), looked[0].at);
        assert!(looked[0].at > some.joints[0].motion.looked_at().len());
        some = more;
    }
    let part = crate::optimize(&some, &catalog);
    assert!(looked[0].rounds > 0 && looked[0].at < 5_000, "{looked:?}");
    assert!(!all.joints[0].candidates.is_empty());
    assert_eq!(all.joints[0].candidates.len(), part.joints[0].candidates.len());
    for (a, b) in all.joints[0].candidates.iter().zip(&part.joints[0].candidates) {
        assert_eq!(a.motor.id, b.motor.id);
        assert!((a.optimum.objective - b.optimum.objective).abs() <= 1e-9 * a.optimum.objective);
    }
    // All samples are looked at once too many rounds have gone.
    some.joints[0].motion =
        Arc::new(Motion { looked: Some((0..10).collect()), ..Motion::clone(&whole.joints[0].motion) });
    looked[0].rounds = ROUNDS - 1;
    let more = with_exceeded(&crate::optimize(&some, &catalog), &mut looked, &catalog, options).unwrap().unwrap();
    assert!(more.joints[0].motion.looked.is_none() && looked[0].at == MANY + 5_000);
}
