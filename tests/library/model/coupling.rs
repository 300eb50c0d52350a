//! Two joints that two equal actuators move together: kinematics, power, and what a design of both is held to.

use std::f64::consts::TAU;

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::robot::{Options, choose};
use gearwise::requirement::{Course, Motion, Objective, Quantity, RatioChoice, Robot, Samples};
use gearwise::transmission::{Coupler, Coupling, Fault, JacobianTable, Numbers, Passed, Rod};
use nalgebra::{Rotation3, Unit, Vector3};

use crate::common;
use crate::solved::solve;

fn near(a: f64, b: f64, within: f64, what: &str) {
    assert!((a - b).abs() <= within * (1.0 + b.abs()), "{what}: {a} and {b}");
}

/// A swing of a joint with a torque of its own.
fn swing(amplitude: f64, phase: f64, torque: f64) -> Motion {
    let (period, count) = (0.9, 120);
    let time: Vec<f64> = (0..count).map(|k| period * f64::from(k) / f64::from(count)).collect();
    let angle = |t: &f64| TAU * t / period + phase;
    let position = time.iter().map(|t| amplitude * (angle(t).sin() + 0.2 * (2.0 * angle(t)).cos())).collect();
    let load = time.iter().map(|t| torque * (1.0 + (angle(t) + 0.7).sin())).collect();
    Motion::from_samples(
        Samples { time, torque: load, position: Some(position), ..Samples::default() },
        Course::Periodic(period),
    )
}

/// An ankle: two cranks behind the shank that turn about the pitch axis, rods down to the heel.
fn ankle() -> [Rod; 2] {
    let rod = |side: f64| Rod {
        axis_at: [0.0, side * 0.03, 0.25],
        axis: [0.0, 1.0, 0.0],
        crank_pin: [-0.045, side * 0.032, 0.25],
        link_pin: [-0.05, side * 0.035, 0.01],
        joints: [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    };
    [rod(1.0), rod(-1.0)]
}

/// The crank's angle by bisection of the rod's length, knowing nothing of derivatives.
fn angle(rod: &Rod, q: [f64; 2]) -> f64 {
    let v = Vector3::from;
    let turn = |e: [f64; 3], q: f64| Rotation3::from_axis_angle(&Unit::new_normalize(v(e)), q);
    let pin = turn(rod.joints[0], q[0]) * (turn(rod.joints[1], q[1]) * v(rod.link_pin));
    let length = (v(rod.crank_pin) - v(rod.link_pin)).norm();
    let off = |theta: f64| {
        let tip = v(rod.axis_at) + turn(rod.axis, theta) * (v(rod.crank_pin) - v(rod.axis_at));
        (tip - pin).norm() - length
    };
    // From where the crank is at zero outwards.
    let (mut a, mut b) = (0.0, 0.0);
    while off(a) * off(b) >= 0.0 {
        (a, b) = (a - 0.01, b + 0.01);
        assert!(b < 1.5, "no angle closes the loop at {q:?}");
    }
    for _ in 0..80 {
        let middle = 0.5 * (a + b);
        if off(middle) * off(a) > 0.0 { a = middle } else { b = middle }
    }
    0.5 * (a + b)
}

fn coupling(coupler: Coupler) -> Coupling {
    Coupling { coupler, numbers: Numbers::IDEAL }
}

fn table_of(rods: &[Rod; 2]) -> JacobianTable {
    let axis =
        |most: f64, n: i32| (0..n).map(|k| most * (2.0 * f64::from(k) / f64::from(n - 1) - 1.0)).collect::<Vec<f64>>();
    let (first, second) = (axis(0.45, 25), axis(0.3, 19));
    let h = 1e-4;
    let entry = |a: usize, i: usize| {
        let pairs = first.iter().flat_map(|x| second.iter().map(move |y| [*x, *y]));
        pairs
            .map(|q| {
                let moved = |by: f64| {
                    angle(&rods[a], [q[0] + if i == 0 { by } else { 0.0 }, q[1] + if i == 1 { by } else { 0.0 }])
                };
                (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h)
            })
            .collect::<Vec<f64>>()
    };
    JacobianTable::new(first.clone(), second.clone(), [entry(0, 0), entry(0, 1), entry(1, 0), entry(1, 1)])
}

/// Each actuator's part of the motion.
fn parts(motion: &Motion) -> Vec<Motion> {
    motion.parts().into_iter().map(|(_, part)| part).collect()
}

#[test]
fn speeds_are_the_rates_of_the_cranks_angles_and_power_is_passed_on() {
    let (pitch, roll) = (swing(0.3, 0.0, 20.0), swing(0.15, 1.0, 8.0));
    let rods = ankle();
    for (coupler, within) in [
        (Coupler::Rods(rods.into()), 1e-7_f64),
        (Coupler::Table(table_of(&rods)), 2e-4),
        (Coupler::Matrix([[1.0, 1.0], [1.0, -1.0]]), 0.0),
    ] {
        let of_rods = !matches!(coupler, Coupler::Matrix(_));
        let (both, passed) = Passed::coupled(&coupling(coupler), [("pitch", &pitch), ("roll", &roll)]).unwrap();
        let each = parts(&both);
        let joints: Vec<&Motion> = passed.joints.iter().map(|(_, motion)| motion.as_ref()).collect();
        let at = |j: usize, k: usize| joints[j].position.as_ref().unwrap()[k];
        for k in 0..joints[0].len() {
            let at_joints: f64 = joints.iter().map(|m| m.torque[k] * m.velocity[k]).sum();
            let at_actuators: f64 = each.iter().map(|m| m.torque[k] * m.velocity[k]).sum();
            near(at_actuators, at_joints, 1e-11, "power");
            if !of_rods || k % 7 != 0 {
                continue;
            }
            // Along the motion, by the cranks' own angles.
            let h = 1e-4;
            for (a, rod) in rods.iter().enumerate() {
                let moved = |s: f64| {
                    let of = |j: usize| {
                        at(j, k)
                            + s * joints[j].velocity[k]
                            + 0.5 * s * s * joints[j].acceleration[k]
                            + s * s * s / 6.0 * joints[j].jerk[k]
                    };
                    angle(rod, [of(0), of(1)])
                };
                let all: Vec<f64> = (-2..=2).map(|i| moved(f64::from(i) * h)).collect();
                let speed = (8.0 * (all[3] - all[1]) - (all[4] - all[0])) / (12.0 * h);
                let fast = each[a].velocity.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                near(each[a].velocity[k] / fast, speed / fast, within.max(1e-9), "speed");
                let h = 2e-3;
                let all: Vec<f64> = (-2..=2).map(|i| moved(f64::from(i) * h)).collect();
                let turned = (16.0 * (all[3] + all[1]) - (all[4] + all[0]) - 30.0 * all[2]) / (12.0 * h * h);
                let most = each[a].acceleration.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                near(each[a].acceleration[k] / most, turned / most, 20.0 * within.max(1e-7), "acceleration");
                let jerk = ((all[4] - all[0]) - 2.0 * (all[3] - all[1])) / (2.0 * h * h * h);
                let sharp = each[a].jerk.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                near(each[a].jerk[k] / sharp, jerk / sharp, 100.0 * within.max(1e-4), "jerk");
            }
        }
    }
}

/// The published ankle of two equal actuators: twice the torque of one in pitch, and twice its inertia.
#[test]
fn a_differential_has_twice_the_torque_and_twice_the_inertia() {
    let matrix = Coupler::Matrix([[1.0, 1.0], [1.0, -1.0]]);
    let pitch = Motion::from_points(&[gearwise::requirement::Point {
        torque: 50.0,
        velocity: 1.0,
        duration: Some(1.0),
        ..Default::default()
    }]);
    let still = Motion::from_points(&[gearwise::requirement::Point { duration: Some(1.0), ..Default::default() }]);
    let (both, passed) = Passed::coupled(&coupling(matrix), [("pitch", &pitch), ("roll", &still)]).unwrap();
    assert_eq!(both.torque, [25.0, 25.0]);
    assert_eq!(both.velocity, [1.0, 1.0]);
    near(passed.levers.inertia, 2.0, 1e-12, "armatures");
    near(passed.levers.stiffness, 2.0, 1e-12, "stiffness");
    // A motor that drives past another joint: (J⁻ᵀ by hand).
    let past = Coupler::Matrix([[1.0, 0.0], [1.0, 1.0]]);
    let knee = Motion::from_points(&[gearwise::requirement::Point {
        torque: 10.0,
        velocity: 2.0,
        duration: Some(1.0),
        ..Default::default()
    }]);
    let (both, _) = Passed::coupled(&coupling(past), [("hip", &pitch), ("knee", &knee)]).unwrap();
    assert_eq!(both.torque, [40.0, 10.0]);
    assert_eq!(both.velocity, [1.0, 3.0]);
}

fn motor() -> Motor {
    common::motor(&[
        ("resistance [ohm]", "0.2"),
        ("torque_constant [N*m/A]", "0.08"),
        ("rotor_inertia [g*cm^2]", "300"),
        ("mass [g]", "200"),
    ])
}

/// A robot whose one joint is a coupling.
fn robot(coupling: &Coupling, joints: [&Motion; 2]) -> Robot {
    let (motion, passed) = Passed::coupled(coupling, [("pitch", joints[0]), ("roll", joints[1])]).unwrap();
    let mut robot = common::robot(motion, common::gear(1.0));
    robot.joints[0].count = 2;
    robot.joints[0].passed = Some(passed.into());
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 60.0 };
    robot.joints[0].objective = Objective::single(Quantity::CopperLoss);
    robot
}

/// Mean and largest squared torque at the shaft of each actuator, from the samples.
fn squares(both: &Motion, n: f64) -> Vec<(f64, f64)> {
    let of = |part: &Motion| {
        let torque = |k: usize| part.torque[k] / n + n * 300e-7 * part.acceleration[k];
        (part.mean(|k| torque(k).powi(2)), (0..part.len()).map(|k| torque(k).powi(2)).fold(0.0, f64::max))
    };
    parts(both).iter().map(of).collect()
}

#[test]
fn a_design_of_both_is_held_to_the_worse_and_counts_the_mean() {
    let (pitch, roll) = (swing(0.3, 0.0, 20.0), swing(0.15, 1.0, 8.0));
    let coupling = coupling(Coupler::Rods(ankle().into()));
    let robot = robot(&coupling, [&pitch, &roll]);
    let both = robot.joints[0].motion.clone();
    for n in [4.0, 10.0, 25.0] {
        let found = common::evaluate(&robot, &motor(), n);
        let by_hand = squares(&both, n);
        let copper = 0.2 / 0.08_f64.powi(2);
        near(found.copper_loss, copper * 0.5 * (by_hand[0].0 + by_hand[1].0), 1e-9, "mean loss of one actuator");
        near(found.rms_current, by_hand[0].0.max(by_hand[1].0).sqrt() / 0.08, 1e-9, "rms of the worse");
        near(found.peak_current, by_hand[0].1.max(by_hand[1].1).sqrt() / 0.08, 1e-9, "largest of both");
    }
    // The best ratio without limits, then with a current, then with heat: a dense scan each.
    let copper = |n: f64| squares(&both, n).iter().map(|(mean, _)| 0.5 * 0.2 / 0.08_f64.powi(2) * mean).sum::<f64>();
    let scan = |keeps: &dyn Fn(f64) -> bool| {
        let ratios = (0..4000).map(|k| 2.0 * (30.0_f64).powf(f64::from(k) / 3999.0));
        ratios
            .filter(|n| keeps(*n))
            .map(|n| (copper(n), n))
            .fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a })
    };
    let free = solve(&motor(), &robot).unwrap();
    near(free.optimum.objective, scan(&|_| true).0, 1e-6, "free");
    let peak = |n: f64| squares(&both, n).iter().map(|(_, peak)| *peak).fold(0.0, f64::max).sqrt() / 0.08;
    let rms = |n: f64| squares(&both, n).iter().map(|(mean, _)| *mean).fold(0.0, f64::max).sqrt() / 0.08;
    let at = free.optimum.ratio;
    for (name, of) in [("peak_current [A]", &peak as &dyn Fn(f64) -> f64), ("continuous_current [A]", &rms)] {
        // What the best free ratio needs, and a little less than that.
        for share in [1.01, 0.99] {
            let limit = share * of(at);
            let text = limit.to_string();
            let motor = common::motor(&[
                ("resistance [ohm]", "0.2"),
                ("torque_constant [N*m/A]", "0.08"),
                ("rotor_inertia [g*cm^2]", "300"),
                ("mass [g]", "200"),
                (name, &text),
            ]);
            let least = scan(&|n| of(n) <= limit);
            match solve(&motor, &robot) {
                Ok(found) => {
                    near(found.optimum.objective, least.0, 1e-3, name);
                    assert!(of(found.optimum.ratio) <= limit * (1.0 + 1e-6), "{name}");
                }
                Err(why) => {
                    assert!(least.0.is_infinite(), "{name} at {share}: {why:?}, but {} at {}", least.0, least.1)
                }
            }
        }
    }
}

/// Two joints that are not coupled at all, written as a coupling: each actuator is as it would be alone.
#[test]
fn the_identity_couples_nothing() {
    let (pitch, roll) = (swing(0.3, 0.0, 20.0), swing(0.15, 1.0, 8.0));
    let robot = robot(&coupling(Coupler::Matrix([[1.0, 0.0], [0.0, 1.0]])), [&pitch, &roll]);
    let found = common::evaluate(&robot, &motor(), 9.0);
    let alone = [&pitch, &roll]
        .map(|motion| common::evaluate(&common::robot(motion.clone(), common::gear(1.0)), &motor(), 9.0));
    near(found.copper_loss, 0.5 * (alone[0].copper_loss + alone[1].copper_loss), 1e-4, "loss");
    near(found.peak_current, alone[0].peak_current.max(alone[1].peak_current), 1e-9, "current");
    near(found.rms_current, alone[0].rms_current.max(alone[1].rms_current), 1e-4, "rms");
    near(found.reflected_inertia, alone[0].reflected_inertia, 1e-12, "inertia");
}

/// The power of a robot whose coupling couples nothing is that of its two joints at the same time.
#[test]
fn both_actuators_draw_power_at_the_same_time() {
    let (pitch, roll) = (swing(0.3, 0.0, 20.0), swing(0.15, 1.0, 8.0));
    let catalog = Catalog::of(vec![motor()], Vec::new());
    let at_ratio = |mut robot: Robot, power: f64| {
        for joint in &mut robot.joints {
            joint.ratio = RatioChoice::Listed { values: vec![9.0], step: None, teeth: None };
            joint.objective = Objective::single(Quantity::CopperLoss);
        }
        robot.budget.power = Some(power);
        !choose(&robot, &catalog, Options::default()).unwrap().combinations.is_empty()
    };
    let coupled = || robot(&coupling(Coupler::Matrix([[1.0, 0.0], [0.0, 1.0]])), [&pitch, &roll]);
    let apart = || {
        let mut robot = common::robot(pitch.clone(), common::gear(1.0));
        let mut other = common::robot(roll.clone(), common::gear(1.0)).joints.remove(0);
        other.name = "roll".into();
        robot.joints.push(other);
        robot
    };
    // The least power that does, of either.
    let least = |make: &dyn Fn() -> Robot| {
        let (mut low, mut high) = (1.0, 5000.0);
        while high - low > 1e-3 * high {
            let middle = 0.5 * (low + high);
            if at_ratio(make(), middle) { high = middle } else { low = middle }
        }
        high
    };
    near(least(&coupled), least(&apart), 5e-3, "power of both");
}

#[test]
fn what_cannot_be_is_named_with_its_angles() {
    let far = swing(1.4, 0.0, 20.0);
    let roll = swing(0.1, 1.0, 8.0);
    let fault = |coupler: Coupler, first: &Motion| {
        Passed::coupled(&coupling(coupler), [("pitch", first), ("roll", &roll)]).unwrap_err()
    };
    let found = fault(Coupler::Rods(ankle().into()), &far);
    assert!(matches!(found, Fault::OpenAt([q, _], _) | Fault::InLineAt([q, _], _) if q.abs() > 0.5), "{found:?}");
    let found = fault(Coupler::Table(table_of(&ankle())), &far);
    assert!(matches!(found, Fault::OutsideAt([q, _]) if q.abs() > 0.45), "{found:?}");
    // Both rods on one side: roll has no arm of its own.
    let one = ankle()[0];
    let found = fault(Coupler::Rods([one, one].into()), &swing(0.2, 0.0, 20.0));
    assert!(matches!(found, Fault::SingularAt(_)), "{found:?}");
    let said = found.to_string();
    assert!(said.contains("deg") && said.contains("same direction"), "{said}");
}
