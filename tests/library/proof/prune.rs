//! The first designs found without solving all motors are those found by solving all: for random
//! requirements and the shipped ones, byte for byte.

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::answer::JointResult;
use gearwise::design::optimize::optimize_with;
use gearwise::design::options::Options;
use gearwise::report;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::cases::cases;
use crate::common;

/// Compares the first `keep` designs of every joint; gives how many programs were left out, of how many.
fn compare(robot: &Robot, catalog: &Catalog, keep: usize) -> (usize, usize) {
    let all = optimize_with(robot, catalog, Options::default()).unwrap();
    let first = optimize_with(robot, catalog, Options { keep: Some(keep), ..Options::default() }).unwrap();
    let (mut left_out, mut of) = (0, 0);
    for (all, first) in all.joints.iter().zip(&first.joints) {
        let designs = |joint: &JointResult| -> Vec<String> {
            joint.candidates.iter().take(keep).map(|design| format!("{design:?}")).collect()
        };
        assert_eq!(designs(all), designs(first), "{} of {}", all.joint.name, robot.name);
        let pruned = first.pruned.as_ref().expect("a pruned result says so");
        // Every motor is accounted for, and the bounds are below what is found by solving.
        assert_eq!(first.motors(), catalog.motors.len());
        assert!(first.agreement.is_empty() && first.candidates.len() <= keep);
        for (motor, bound) in &pruned.not_solved {
            if let Some(design) = all.candidates.iter().find(|d| d.motor.id == motor.id) {
                let objective = design.optimum.objective;
                assert!(*bound <= objective + 1e-9 * objective.abs(), "{}: {bound} {objective}", motor.id);
                assert!(design.optimum.objective > first.candidates[keep - 1].optimum.objective);
            }
        }
        // What is rejected is rejected with the same reason.
        for rejected in &first.rejected {
            let same = all.rejected.iter().find(|r| r.motor.id == rejected.motor.id).expect("rejected there too");
            assert_eq!(format!("{:?}", same.reason), format!("{:?}", rejected.reason));
        }
        left_out += pruned.not_solved.len();
        of += catalog.motors.len();
    }
    (left_out, of)
}

#[test]
fn the_shipped_requirements_have_the_same_first_designs() {
    let catalog = Catalog::builtin().unwrap();
    let (mut left_out, mut of) = (0, 0);
    for file in std::fs::read_dir(common::repository("requirements")).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let robot = read(&path).unwrap();
        for keep in [1, 5] {
            let (a, b) = compare(&robot, &catalog, keep);
            (left_out, of) = (left_out + a, of + b);
        }
    }
    println!("{left_out} of {of} programs left out");
    assert!(left_out > 0);
}

/// What is found where reasons are not asked for, against all motors solved: the same first designs, and nothing is
/// ruled out that can. Gives how many motors were ruled out without a reason.
fn compare_without_reasons(robot: &Robot, catalog: &Catalog, keep: usize) -> usize {
    let all = optimize_with(robot, catalog, Options::default()).unwrap();
    let quick =
        optimize_with(robot, catalog, Options { keep: Some(keep), reasons: false, ..Options::default() }).unwrap();
    let mut ruled_out = 0;
    for (all, quick) in all.joints.iter().zip(&quick.joints) {
        let context = format!("{} of {}", all.joint.name, robot.name);
        let first: Vec<_> = all.candidates.iter().take(keep).collect();
        assert_eq!(format!("{first:?}"), format!("{:?}", quick.candidates), "{context}");
        let rejected = |joint: &JointResult| -> Vec<String> {
            joint.rejected.iter().map(|r| format!("{} {:?}", r.motor.id, r.reason)).collect()
        };
        // Each reason that is given is the same; a joint without a design has them all.
        let (every, given) = (rejected(all), rejected(quick));
        assert!(given.iter().all(|r| every.contains(r)), "{context}");
        let pruned = quick.pruned.as_ref().unwrap();
        assert!(!all.candidates.is_empty() || every == given, "{context}");
        // What is ruled out cannot; what is not solved cannot, or is worse than all that are shown.
        let can = |motor: &Motor| all.candidates.iter().find(|design| design.motor.id == motor.id);
        assert!(pruned.impossible.iter().all(|motor| can(motor).is_none()), "{context}");
        for (motor, bound) in &pruned.not_solved {
            if let Some(design) = can(motor) {
                let objective = design.optimum.objective;
                assert!(*bound <= objective + 1e-9 * objective.abs(), "{context}: {}", motor.id);
                assert!(objective > first[keep - 1].optimum.objective, "{context}: {}", motor.id);
            }
        }
        // Every motor is accounted for.
        assert_eq!(quick.motors(), catalog.motors.len(), "{context}");
        ruled_out += pruned.impossible.len();
    }
    ruled_out
}

#[test]
fn motors_ruled_out_without_a_reason_are_those_that_cannot() {
    let catalog = Catalog::builtin().unwrap();
    let mut ruled_out = 0;
    for file in std::fs::read_dir(common::repository("requirements")).unwrap() {
        let path = file.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        ruled_out += compare_without_reasons(&read(&path).unwrap(), &catalog, 3);
    }
    for seed in cases(0, 60) {
        ruled_out += compare_without_reasons(&draw(seed), &catalog, 1 + (seed % 5) as usize);
    }
    assert!(ruled_out > 0, "nothing is ruled out without being solved");
}

/// A random joint: a few harmonics, or operating points, with a random objective and random limits.
fn draw(seed: u64) -> Robot {
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut within = |a: f64, b: f64| generator.random_range(a..b);
    let count = 24;
    let (period, torque, speed) = (within(0.3, 2.0), 10.0_f64.powf(within(-0.5, 1.6)), within(0.5, 8.0));
    let (phase, second) = (within(0.0, 6.0), within(0.0, 0.6));
    let angle = |k: usize| std::f64::consts::TAU * k as f64 / count as f64;
    let wave = |size: f64, phase: f64| -> Vec<f64> {
        (0..count).map(|k| size * ((angle(k) + phase).sin() + second * (2.0 * angle(k)).cos())).collect()
    };
    let samples = Samples {
        time: (0..count).map(|k| period * k as f64 / count as f64).collect(),
        torque: wave(torque, phase),
        velocity: Some(wave(speed, 0.0)),
        ..Samples::default()
    };
    let motion = Motion::from_samples(samples, Course::Periodic(period));
    let mut robot = common::robot(motion, common::gear(within(0.7, 1.0)));
    robot.name = format!("random {seed}");
    robot.bus.voltage = within(12.0, 60.0);
    robot.bus.drive_current = (within(0.0, 1.0) < 0.7).then(|| within(5.0, 60.0));
    if within(0.0, 1.0) < 0.2 {
        robot.bus.regeneration = Regeneration::Limited(within(0.0, 50.0));
    }
    let joint = &mut robot.joints[0];
    let low = within(1.0, 10.0);
    joint.ratio = RatioChoice::Continuous { min: low, max: low * within(2.0, 20.0) };
    if within(0.0, 1.0) < 0.2 {
        joint.ratio = RatioChoice::gears(vec!["planetary-*".into()], EfficiencyCovers::Load);
    }
    joint.gear.inertia = within(0.0, 1e-5);
    if within(0.0, 1.0) < 0.3 {
        (joint.gear.mass, joint.gear.mass_per_stage) = (None, Some((within(0.05, 0.5), within(3.0, 8.0))));
    }
    joint.limits.reflected_inertia = (within(0.0, 1.0) < 0.5).then(|| within(0.005, 0.2));
    joint.limits.winding_temperature = Some(383.15);
    use Quantity::*;
    let one = [Loss, Energy, ReflectedInertia, PeakCurrent, Mass, PeakPower][within(0.0, 6.0) as usize];
    joint.objective = match within(0.0, 1.0) < 0.25 {
        true => Objective { terms: vec![(Loss, 0.1), (Mass, within(0.1, 2.0)), (PeakCurrent, within(0.0, 0.1))] },
        false => Objective::single(one),
    };
    robot
}

#[test]
fn random_requirements_have_the_same_first_designs() {
    let catalog = Catalog::builtin().unwrap();
    let (mut left_out, mut of) = (0, 0);
    for seed in cases(0, 60) {
        let (a, b) = compare(&draw(seed), &catalog, 1 + (seed % 5) as usize);
        (left_out, of) = (left_out + a, of + b);
    }
    println!("{left_out} of {of} programs left out");
    assert!(left_out * 20 > of, "pruning does nothing");
}

#[test]
fn the_output_says_what_was_not_solved() {
    let catalog = Catalog::builtin().unwrap();
    let robot = read(&common::repository("requirements/quadruped_mini_cheetah.toml")).unwrap();
    let result = optimize_with(&robot, &catalog, Options { keep: Some(1), ..Options::default() }).unwrap();
    let left: Vec<usize> = result.joints.iter().map(|j| j.pruned.as_ref().unwrap().not_solved.len()).collect();
    assert!(left.iter().all(|n| *n > 0));
    let text = report::optimize::text(
        &result,
        &[],
        &[],
        report::optimize::Shown { top: 1, rejected: false, why: false, full: true },
    );
    assert!(text.contains(&format!("Not solved: {} motors", left[0])), "{text}");
    let json = report::json::optimize::json(&result, &[], None);
    assert_eq!(json["joints"][0]["pruned"]["not_solved"].as_array().unwrap().len(), left[0]);
    assert_eq!(
        report::optimize::csv(&result).matches("not solved: loss is at least").count(),
        left.iter().sum::<usize>()
    );
}

#[test]
fn joints_that_ask_the_same_have_the_same_answer() {
    let catalog = Catalog::builtin().unwrap();
    let mut robot = draw(3);
    let alone = optimize_with(&robot, &catalog, Options::default()).unwrap();
    let mut twin = robot.joints[0].clone();
    (twin.name, twin.count) = ("twin".into(), 7);
    let mut other = twin.clone();
    other.limits.safety = 1.3;
    assert!(twin.asks_the_same(&robot.joints[0]) && !other.asks_the_same(&twin));
    let before = format!("{:?}", alone.joints[0].candidates);
    drop(alone);
    robot.joints.extend([other, twin]);
    let together = optimize_with(&robot, &catalog, Options::default()).unwrap();
    assert_eq!(before, format!("{:?}", together.joints[0].candidates));
    assert_eq!(before, format!("{:?}", together.joints[2].candidates));
    assert_eq!((together.joints[2].joint.name.as_str(), together.joints[2].joint.count), ("twin", 7));
}
