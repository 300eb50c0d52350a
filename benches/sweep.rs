//! What the performance claims rest on: a motor-ratio pair of the sweep and a ratio program, at 100 to
//! 10 000 samples, each beside the plain loop over all samples in the same run.

mod common;

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use gearwise::actuator::Load;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::optimize::optimize_with;
use gearwise::design::options::Options;
use gearwise::design::program::{Certificate, RatioProgram};
use gearwise::design::{Mount, Prepared, optimize};
use gearwise::requirement::{Joint, Regeneration, Robot};

use common::robot;

/// Largest squared torque and voltage, and the mean squared torque, by one loop over all samples: what a
/// spreadsheet or script does for each pair.
fn plain_loop(joint: &Joint, motor: &Motor, ratio: f64) -> (f64, f64, f64) {
    let m = &joint.motion;
    let (r, k_t, k_b) = (motor.resistance, motor.torque_constant, motor.back_emf_constant);
    let (l, p) = motor.inductance_and_poles().unwrap_or((0.0, 0.0));
    let inertia = motor.rotor_inertia.unwrap_or(0.0) + joint.gear.inertia;
    let (mut torque, mut voltage, mut mean) = (0.0_f64, 0.0_f64, 0.0);
    for k in 0..m.len() {
        let phi = if m.torque[k] * m.velocity[k] < 0.0 {
            joint.gear.backdrive_efficiency
        } else {
            1.0 / joint.gear.efficiency
        };
        let t = phi * m.torque[k] / ratio + ratio * inertia * m.acceleration[k];
        let rate = phi * m.torque_rate[k] / ratio + ratio * inertia * m.jerk[k];
        let v_q = (r * t + l * rate) / k_t + k_b * ratio * m.velocity[k];
        let v_d = p * l * ratio * m.velocity[k] * t / k_t;
        torque = torque.max(t * t);
        voltage = voltage.max(v_q * v_q + v_d * v_d);
        mean += m.weight[k] * t * t;
    }
    (torque, voltage, mean)
}

const MOTOR: &str = "tq-robodrive-ilm-85x26";

fn pair(c: &mut Criterion) {
    let catalog = Catalog::builtin().expect("the shipped catalogue is sound");
    let motor = catalog.motor("t-motor-ri50").expect("a shipped motor");
    let thermal = catalog.motor(MOTOR).expect("a shipped motor");
    let mut group = c.benchmark_group("sweep, one pair");
    for samples in [100, 1000, 10_000] {
        let robot = robot(samples, 1);
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let prepared = Prepared::new(Mount::new(&robot, joint, &load, motor).candidate().expect("a candidate"));
        let ratios: Vec<f64> = gearwise::design::grid(3.0, 60.0, 64);
        let mut next = ratios.iter().cycle();
        group.bench_function(BenchmarkId::new("tree", samples), |b| {
            b.iter(|| prepared.at(black_box(*next.next().expect("a cycle"))));
        });
        let with_nodes = Prepared::new(Mount::new(&robot, joint, &load, thermal).candidate().expect("a candidate"));
        group.bench_function(BenchmarkId::new("tree and two thermal nodes", samples), |b| {
            b.iter(|| with_nodes.at(black_box(*next.next().expect("a cycle"))));
        });
        group.bench_function(BenchmarkId::new("plain loop", samples), |b| {
            b.iter(|| plain_loop(joint, motor, black_box(*next.next().expect("a cycle"))));
        });
    }
    group.finish();
}

fn program(c: &mut Criterion) {
    let catalog = Catalog::builtin().expect("the shipped catalogue is sound");
    let mut group = c.benchmark_group("ratio program, one motor");
    for samples in [100, 1000, 10_000] {
        let robot = robot(samples, 1);
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        for id in [MOTOR, "t-motor-ri50", "faulhaber-3274g024bp4"] {
            let motor = catalog.motor(id).expect("a shipped motor");
            let prepared = Prepared::new(Mount::new(&robot, joint, &load, motor).candidate().expect("a candidate"));
            group.bench_function(BenchmarkId::new(id, samples), |b| {
                b.iter(|| RatioProgram::new(&prepared, &joint.objective, 3.0, 60.0).solve());
            });
        }
    }
    group.finish();
}

fn whole(c: &mut Criterion) {
    let mut catalog = Catalog::builtin().expect("the shipped catalogue is sound");
    catalog.motors.truncate(100);
    let robot = robot(1000, 4);
    let mut group = c.benchmark_group("optimize");
    group.sample_size(10);
    group.bench_function("100 motors, 4 joints, 1000 samples", |b| b.iter(|| optimize(&robot, &catalog)));
    group.finish();
}

/// A thousand motors: those of the catalogue, and the same wound and built a little differently. All that a
/// limit can ask of a motor is known.
fn thousand_motors(friction: bool) -> Catalog {
    let catalog = Catalog::builtin().expect("the shipped catalogue is sound");
    let known: Vec<&Motor> = catalog.motors.iter().filter(|m| m.rotor_inertia.is_some()).collect();
    let motors = (0..1000).map(|i| {
        let (mut motor, copy) = (known[i % known.len()].clone(), (i / known.len()) as f64);
        motor.id = format!("{} {copy}", motor.id);
        motor.torque_constant *= 1.0 + 0.07 * copy;
        motor.back_emf_constant *= 1.0 + 0.07 * copy;
        motor.resistance *= 1.0 + 0.11 * copy;
        motor.rotor_inertia = motor.rotor_inertia.map(|j| j * (1.0 + 0.05 * copy));
        let stall = 20.0 / motor.resistance;
        motor.inductance = motor.inductance.or(Some(motor.resistance * 5e-4));
        motor.pole_pairs = motor.pole_pairs.or(Some(7));
        motor.peak_current = motor.peak_current.or(Some(stall));
        motor.continuous_current = motor.continuous_current.or(Some(0.2 * stall));
        motor.peak_torque = motor.peak_torque.or(Some(stall * motor.torque_constant));
        motor.continuous_torque = motor.continuous_torque.or(Some(0.3 * stall * motor.torque_constant));
        motor.thermal_resistance = motor.thermal_resistance.or(Some(2.0));
        motor.max_winding_temperature = motor.max_winding_temperature.or(Some(398.15));
        motor.max_speed = motor.max_speed.or(Some(1000.0));
        motor.mass = motor.mass.or(Some(0.5));
        motor.coulomb_friction = friction.then_some(0.02 * 0.2 * stall * motor.torque_constant);
        motor
    });
    Catalog::of(motors.collect(), Vec::new())
}

/// One joint with every limit that leaves the program convex.
fn all_limits(samples: usize) -> Robot {
    let mut robot = robot(samples, 1);
    (robot.bus.power, robot.bus.current, robot.bus.drive_efficiency) = (Some(400.0), Some(12.0), 0.95);
    let joint = &mut robot.joints[0];
    joint.gear.mass = Some(0.2);
    (joint.gear.peak_torque, joint.gear.continuous_torque) = (Some(40.0), Some(20.0));
    joint.gear.max_input_speed = Some(800.0);
    joint.limits.actuator_mass = Some(2.0);
    joint.limits.torque_bandwidth = Some(gearwise::requirement::TorqueBandwidth { frequency: 30.0, amplitude: 2.0 });
    robot
}

/// A thousand motors with all limits, beside one of them solved by a plain loop over 200 ratios; and how long a
/// single program takes where Coulomb friction and a regeneration limit make it non-convex.
fn thousand(c: &mut Criterion) {
    let (catalog, robot) = (thousand_motors(false), all_limits(1000));
    let joint = &robot.joints[0];
    let mut group = c.benchmark_group("a thousand motors");
    group.sample_size(10);
    group.bench_function("all limits, 1000 samples", |b| b.iter(|| optimize(&robot, &catalog)));
    let ratios = gearwise::design::grid(3.0, 60.0, 200);
    let mut next = catalog.motors.iter().cycle();
    group.bench_function("one of them by a plain loop over 200 ratios, three limits", |b| {
        b.iter(|| {
            let motor = next.next().expect("a cycle");
            ratios.iter().map(|n| plain_loop(joint, motor, black_box(*n)).2).fold(f64::INFINITY, f64::min)
        });
    });
    group.finish();
    let (rubbing, mut robot) = (thousand_motors(true), all_limits(1000));
    robot.bus.regeneration = Regeneration::Limited(40.0);
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    let (mut times, mut certified, mut feasible) = (Vec::new(), 0, 0);
    for motor in rubbing.motors.iter().step_by(10) {
        let prepared = Prepared::new(Mount::new(&robot, joint, &load, motor).candidate().expect("a candidate"));
        let start = std::time::Instant::now();
        let outcome = RatioProgram::new(&prepared, &joint.objective, 3.0, 60.0).solve();
        times.push(start.elapsed().as_secs_f64() * 1e3);
        if let Ok(optimum) = outcome {
            feasible += 1;
            certified += usize::from(matches!(optimum.certificate, Certificate::Certified { .. }));
        }
    }
    times.sort_by(f64::total_cmp);
    println!(
        "non-convex, 100 motors one after the other, ms each: median {:.2}, 95 % {:.2}, most {:.2}; {feasible} \
         feasible, {certified} certified",
        times[50], times[95], times[99]
    );
}

fn first_few(c: &mut Criterion) {
    let catalog = thousand_motors(false);
    let robot = robot(1000, 1);
    let mut group = c.benchmark_group("optimize, 1000 motors, 1000 samples");
    group.sample_size(10);
    for keep in [None, Some(5)] {
        let options = Options { keep, ..Options::default() };
        let result = optimize_with(&robot, &catalog, options).unwrap();
        let left_out = result.joints[0].pruned.as_ref().map_or(0, |p| p.not_solved.len());
        println!("{keep:?}: {left_out} of {} motors not solved", catalog.motors.len());
        let name = keep.map_or("all".to_string(), |k| format!("the first {k}"));
        group.bench_function(name, |b| b.iter(|| optimize_with(&robot, &catalog, options).unwrap()));
    }
    let mut alike = common::robot(1000, 1);
    alike.joints = vec![alike.joints[0].clone(); 100];
    let shipped = Catalog::builtin().expect("the shipped catalogue is sound");
    group.bench_function("shipped motors, 100 joints alike", |b| b.iter(|| optimize(&alike, &shipped)));
    group.finish();
}

criterion_group!(benches, pair, program, whole, thousand, first_few);
criterion_main!(benches);
