//! What `benches/instructions.sh` counts: `instructions CASE TIMES` prepares a case and does its work so many times.
//! With 0 it only prepares, so that the difference of two runs is the work alone. Preparing costs some 40 million
//! instructions and varies by some 0.2 million (the hashes of the standard library are seeded at random): each case is done so
//! often that this is less than a percent.

mod common;

use std::hint::black_box;
use std::path::Path;

use gearwise::actuator::Load;
use gearwise::catalog::Catalog;
use gearwise::design::program::RatioProgram;
use gearwise::design::{Mount, Prepared, grid, optimize};
use gearwise::measured::{identify, read};
use gearwise::requirement::Robot;

/// One case: its name, how often it is done for one count, and what prepares and does it.
type Case = (&'static str, u64, fn(u64));

const CASES: [Case; 8] = [
    ("load", 20, load),
    ("sweep-kernel", 100, |times| kernel("t-motor-ri50", times)),
    ("sweep-kernel-thermal", 4, |times| kernel("tq-robodrive-ilm-85x26", times)),
    ("ratio-program-convex", 100, |times| program("t-motor-ri50", 0.0, times)),
    ("ratio-program-thermal", 20, |times| program("tq-robodrive-ilm-85x26", 0.0, times)),
    ("ratio-program-branch-and-bound", 10, |times| program("t-motor-ri50", 0.05, times)),
    ("optimize-catalogue", 1, catalogue),
    ("identify", 1, identification),
];

const SAMPLES: usize = 1000;

/// The tree of bounding boxes of one joint, once for all motors and ratios.
fn load(times: u64) {
    let robot = common::robot(SAMPLES, 1);
    for _ in 0..times {
        black_box(Load::new(black_box(&robot.joints[0].motion), None));
    }
}

fn prepared<T>(robot: &Robot, id: &str, friction: f64, work: impl FnOnce(&Prepared) -> T) -> T {
    let catalog = Catalog::builtin().expect("the shipped catalogue is sound");
    let mut motor = catalog.motor(id).expect("a shipped motor").clone();
    motor.coulomb_friction = (friction > 0.0).then_some(friction);
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    work(&Prepared::new(Mount::new(robot, joint, &load, &motor).candidate().expect("a candidate")))
}

/// A motor at 64 ratios.
fn kernel(id: &str, times: u64) {
    let ratios = grid(3.0, 60.0, 64);
    prepared(&common::robot(SAMPLES, 1), id, 0.0, |prepared| {
        for _ in 0..times {
            for ratio in &ratios {
                black_box(prepared.at(black_box(*ratio)));
            }
        }
    });
}

/// The best ratio of one motor, with its certificate.
fn program(id: &str, friction: f64, times: u64) {
    let robot = common::robot(SAMPLES, 1);
    prepared(&robot, id, friction, |prepared| {
        for _ in 0..times {
            let _ = black_box(RatioProgram::new(prepared, &robot.joints[0].objective, 3.0, 60.0).solve());
        }
    });
}

/// Twenty shipped motors on two joints, as `optimize` does it.
fn catalogue(times: u64) {
    let mut catalog = Catalog::builtin().expect("the shipped catalogue is sound");
    catalog.motors.truncate(20);
    let robot = common::robot(SAMPLES, 2);
    for _ in 0..times {
        black_box(optimize(&robot, &catalog));
    }
}

/// The shipped example of a bench: three logs with an effect that the model lacks.
fn identification(times: u64) {
    let bench = read::read(Path::new("requirements/bench/leg_actuator.toml")).expect("the shipped bench is sound");
    for _ in 0..times {
        black_box(identify::identify(&bench, &identify::Options::default()).expect("the shipped bench is enough"));
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, times] = arguments.as_slice() else {
        CASES.iter().for_each(|(name, times, _)| println!("{name} {times}"));
        return;
    };
    let (.., work) = CASES.iter().find(|(n, ..)| n == name).expect("a case of the list");
    work(times.parse().expect("how many times"));
}
