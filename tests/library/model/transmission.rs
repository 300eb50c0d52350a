//! What is between an actuator and its joint: kinematics against differences, power balance, numbers by hand, and an independent
//! evaluation of raw samples.

use std::f64::consts::{FRAC_PI_2, TAU};

use gearwise::catalog::Motor;
use gearwise::design::optimize;
use gearwise::requirement::{
    Course, Motion, Objective, Point, Quantity, RatioChoice, Robot, Samples, Spring, TorqueBandwidth,
};
use gearwise::transmission::{At, Branch, Fault, FourBar, Lever, Numbers, Passed, SpringAt, Table, Transmission, Way};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::common;
use crate::solved::solve;

fn near(a: f64, b: f64, within: f64, what: &str) {
    assert!((a - b).abs() <= within * (1.0 + b.abs()), "{what}: {a} and {b}");
}

/// A linkage of levers that are all of a size, which reaches all angles of half a radian about zero.
fn four_bar(rng: &mut Pcg64) -> FourBar {
    let mut within = |a: f64, b: f64| rng.random_range(a..b);
    let linkage = FourBar {
        ground: [within(-0.05, 0.05), within(0.15, 0.3)],
        crank: within(0.03, 0.07),
        coupler: 0.0,
        rocker: within(0.03, 0.07),
        rocker_zero: within(-0.5, 0.5),
        branch: Branch::Open,
        side: f64::NAN,
    };
    // A coupler that fits where the crank is about across the ground as well.
    let angle = within(-0.4, 0.4);
    let (pin, tip) = (
        [linkage.rocker * linkage.rocker_zero.cos(), linkage.rocker * linkage.rocker_zero.sin()],
        [linkage.ground[0] + linkage.crank * angle.cos(), linkage.ground[1] + linkage.crank * angle.sin()],
    );
    FourBar { coupler: (pin[0] - tip[0]).hypot(pin[1] - tip[1]), ..linkage }.on(0.0)
}

/// A parallelogram along its ground.
const PARALLELOGRAM: FourBar = FourBar {
    ground: [0.0, 0.25],
    crank: 0.05,
    coupler: 0.25,
    rocker: 0.05,
    rocker_zero: 0.0,
    branch: Branch::Open,
    side: f64::NAN,
};

fn lever(rng: &mut Pcg64) -> Lever {
    let mut within = |a: f64, b: f64| rng.random_range(a..b);
    Lever {
        pivot: [within(-0.05, 0.05), within(0.15, 0.3)],
        arm: within(0.03, 0.07),
        arm_zero: within(-0.4, 0.4),
        lead: within(0.002, 0.01),
    }
}

fn table() -> Table {
    let position: Vec<f64> = (0..60).map(|k| -1.5 + 3.0 * f64::from(k) / 59.0).collect();
    let ratio = position.iter().map(|q| 1.9 + 0.5 * q.sin()).collect();
    Table::new(position, ratio, 0.3)
}

#[test]
fn ratio_and_its_derivatives_are_those_of_the_angle() {
    let mut rng = Pcg64::seed_from_u64(22);
    let mut ways: Vec<Way> = (0..300).map(|_| Way::FourBar(four_bar(&mut rng))).collect();
    ways.extend((0..300).map(|_| Way::Lever(lever(&mut rng))));
    ways.push(Way::Table(table()));
    let mut compared = 0;
    for way in &ways {
        for q in [-0.3, -0.05, 0.02, 0.28] {
            let h = 1e-4;
            let all: Result<Vec<At>, Fault> = [-2.0, -1.0, 0.0, 1.0, 2.0].iter().map(|k| way.at(q + k * h)).collect();
            let Ok(at) = all else { continue };
            // Fourth order.
            let slope =
                |of: fn(&At) -> f64| (of(&at[0]) - 8.0 * of(&at[1]) + 8.0 * of(&at[3]) - of(&at[4])) / (12.0 * h);
            let here = at[2];
            let size = here.ratio.abs().max(here.slope.abs()).max(here.bend.abs());
            // Near a dead point all of them grow without end.
            if size > 1e4 * here.ratio.abs().max(1.0) {
                continue;
            }
            compared += 1;
            near(slope(|a| a.angle) / size, here.ratio / size, 1e-8, "r");
            near(slope(|a| a.ratio) / size, here.slope / size, 1e-7, "r'");
            // That of a spline jumps in its own derivative at a row.
            if !matches!(way, Way::Table(_)) {
                near(slope(|a| a.slope) / size, here.bend / size, 1e-6, "r''");
            }
        }
    }
    assert!(compared > 1500, "{compared}");
}

#[test]
fn linkages_that_follow_on_paper() {
    // A parallelogram turns as its joint does.
    let parallelogram = PARALLELOGRAM.on(0.0);
    for q in [-1.0, 0.0, 0.4, 1.2_f64] {
        let at = Way::FourBar(parallelogram).at(q).unwrap();
        near(at.angle, q, 1e-12, "angle");
        near(at.ratio, 1.0, 1e-12, "ratio");
        near(at.slope, 0.0, 1e-10, "slope");
        // The rod is along the ground: its arm about the joint is the rocker's width.
        near(at.arm.unwrap(), 0.05 * q.cos(), 1e-12, "arm");
    }
    // Its crossed branch goes the other way round.
    let crossed = FourBar { branch: Branch::Crossed, ..parallelogram }.on(0.0);
    assert!(Way::FourBar(crossed).at(0.1).unwrap().ratio < 0.0);
    // A screw at a right angle to its lever pulls with all of the lever.
    let lever = Lever { pivot: [0.05, 0.2], arm: 0.05, arm_zero: 0.0, lead: 0.005 };
    let at = Way::Lever(lever).at(0.0).unwrap();
    near(at.arm.unwrap(), 0.05, 1e-12, "arm");
    near(at.ratio, -TAU / 0.005 * 0.05, 1e-12, "ratio");
    near(at.angle, TAU / 0.005 * 0.2, 1e-12, "angle");
}

#[test]
fn each_dead_point_is_named_with_its_angle() {
    let number = |fault: &Fault| match fault {
        Fault::Open(q) | Fault::CrankInLine(q) | Fault::NoArm(q) | Fault::Reverses(q) | Fault::Outside(q, _) => *q,
        of_two => panic!("{of_two}"),
    };
    let checked = |way: Way, low: f64, high: f64| way.ratios(low, high).unwrap_err();
    let linkage = PARALLELOGRAM;
    // A parallelogram is in line with its ground at a right angle.
    let fault = checked(Way::FourBar(linkage.on(0.0)), 0.0, 2.0);
    assert!(matches!(fault, Fault::CrankInLine(_)), "{fault:?}");
    near(number(&fault), FRAC_PI_2, 0.02, "dead point");
    // A longer rocker than the crank can follow: the rod is in line with the crank first.
    let fault = checked(Way::FourBar(FourBar { rocker: 0.08, ..linkage }.on(0.0)), 0.0, 1.5);
    assert!(matches!(fault, Fault::CrankInLine(_) | Fault::Open(_)), "{fault:?}");
    assert!(number(&fault) > 0.3 && number(&fault) < 1.0, "{fault}");
    // A shorter one: the rod is in line with the joint's axis at about a right angle.
    let fault = checked(Way::FourBar(FourBar { rocker: 0.03, ..linkage }.on(0.0)), 0.0, 2.0);
    assert!(matches!(fault, Fault::NoArm(_)), "{fault:?}");
    near(number(&fault), FRAC_PI_2, 0.15, "no arm");
    // Links that never reach.
    let fault = checked(Way::FourBar(FourBar { coupler: 0.1, ..linkage }.on(0.0)), -0.2, 0.2);
    assert_eq!(fault, Fault::Open(-0.2));
    let lever = Lever { pivot: [0.0, 0.2], arm: 0.05, arm_zero: 0.0, lead: 0.005 };
    let fault = checked(Way::Lever(lever), 0.0, 2.0);
    assert!(matches!(fault, Fault::NoArm(_)), "{fault:?}");
    near(number(&fault), FRAC_PI_2, 0.02, "no arm");
    let positions: Vec<f64> = (0..9).map(|k| f64::from(k) * 0.25).collect();
    let falls = Table::new(positions.clone(), positions.iter().map(|q| 1.1 - q).collect(), 0.0);
    let fault = checked(Way::Table(falls.clone()), 0.0, 2.0);
    near(number(&fault), 1.1, 1e-3, "sign change");
    assert!(matches!(checked(Way::Table(falls), 0.5, 2.5), Fault::Reverses(_)));
    let short = Table::new(positions.clone(), vec![2.0; 9], 0.0);
    assert!(matches!(checked(Way::Table(short), 0.5, 2.5), Fault::Outside(q, [0.0, 2.0]) if q > 2.0 && q < 2.01));
}

/// A swing of a joint about `middle` with a torque of weight, inertia and a little of everything, by its samples.
fn swing(middle: f64, amplitude: f64) -> Motion {
    let (period, count) = (0.8, 160);
    let time: Vec<f64> = (0..count).map(|k| period * f64::from(k) / f64::from(count)).collect();
    let w = TAU / period;
    let position: Vec<f64> =
        time.iter().map(|t| middle + amplitude * (0.8 * (w * t).sin() + 0.2 * (2.0 * w * t + 1.0).sin())).collect();
    let acceleration = |t: &f64| amplitude * w * w * (-0.8 * (w * t).sin() - 0.8 * (2.0 * w * t + 1.0).sin());
    let torque = time.iter().zip(&position).map(|(t, q)| 12.0 * q.sin() + 3.0 + 0.05 * acceleration(t)).collect();
    let samples = Samples { time, torque, position: Some(position), ..Samples::default() };
    Motion::from_samples(samples, Course::Periodic(period))
}

fn ideal(way: Way) -> Transmission {
    Transmission::ideal(way)
}

fn with(way: Way, numbers: Numbers) -> Transmission {
    Transmission { way, numbers }
}

/// The robot whose joint has a transmission.
fn behind(robot: &Robot, transmission: &Transmission, motion: &Motion) -> Robot {
    let mut robot = robot.clone();
    let (motion, passed) = Passed::new(transmission, motion).unwrap();
    robot.joints[0].motion = motion.into();
    robot.joints[0].passed = Some(passed.into());
    robot
}

fn motor() -> Motor {
    common::motor(&[
        ("resistance [ohm]", "0.2"),
        ("torque_constant [N*m/A]", "0.08"),
        ("rotor_inertia [g*cm^2]", "300"),
        ("mass [g]", "200"),
    ])
}

#[test]
fn power_is_passed_on_at_every_sample() {
    let mut rng = Pcg64::seed_from_u64(3);
    let mut looked = 0;
    for case in 0..200 {
        let way = match case % 3 {
            0 => Way::FourBar(four_bar(&mut rng)),
            1 => Way::Lever(lever(&mut rng)),
            _ => Way::Table(table()),
        };
        let motion = swing(0.0, 0.3);
        let Ok((actuator, passed)) = Passed::new(&ideal(way.clone()), &motion) else { continue };
        for k in 0..actuator.len() {
            let (at, joint) =
                (actuator.torque[k] * actuator.velocity[k], passed.motion().torque[k] * passed.motion().velocity[k]);
            near(at, joint, 1e-12, "power");
        }
        // With loss and inertias: Lagrange's equation of ½ J_t θ̇² and ½ J_j q̇².
        let lossy = with(
            way,
            Numbers {
                efficiency: 0.8,
                backdrive_efficiency: 0.75,
                inertia: 2e-3,
                joint_inertia: 0.01,
                ..Numbers::IDEAL
            },
        );
        let (actuator, passed) = Passed::new(&lossy, &motion).unwrap();
        let mut lost = 0.0;
        for k in 0..actuator.len() {
            let joint = passed.motion();
            let load = joint.torque[k] + 0.01 * joint.acceleration[k];
            let power = load * joint.velocity[k];
            let kinetic = 2e-3 * actuator.acceleration[k] * actuator.velocity[k];
            let given = actuator.torque[k] * actuator.velocity[k] - kinetic;
            let expected = if power >= 0.0 { power / 0.8 } else { power * 0.75 };
            near(given, expected, 1e-11, "power with loss");
            lost += joint.weight[k] * (given - power);
        }
        near(passed.loss, lost, 1e-9, "loss");
        assert!(passed.loss > 0.0);
        looked += 1;
    }
    assert!(looked > 150, "{looked}");
}

#[test]
fn the_actuators_motion_is_the_rate_of_its_angle() {
    let (actuator, passed) = Passed::new(&ideal(Way::Table(table())), &swing(0.2, 0.8)).unwrap();
    let angle = actuator.position.as_ref().unwrap();
    let n = actuator.len();
    let mut looked = 0;
    for k in 2..n - 2 {
        let (before, after) = (actuator.time[k] - actuator.time[k - 1], actuator.time[k + 1] - actuator.time[k]);
        if before < 1e-5 || after < 1e-5 {
            continue;
        }
        let slope = |y: &[f64]| {
            let (a, b) = ((y[k] - y[k - 1]) / before, (y[k + 1] - y[k]) / after);
            (a * after + b * before) / (before + after)
        };
        let most = |y: &[f64]| y.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        near(slope(angle) / most(&actuator.velocity), actuator.velocity[k] / most(&actuator.velocity), 1e-3, "speed");
        near(
            slope(&actuator.velocity) / most(&actuator.acceleration),
            actuator.acceleration[k] / most(&actuator.acceleration),
            3e-3,
            "acceleration",
        );
        looked += 1;
    }
    assert!(looked > 150, "{looked}");
    // A mean ratio is no substitute: the torque is largest where the ratio is small.
    let most = actuator.torque.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
    let of_joint = passed.motion().torque.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
    assert!((most - of_joint / 1.9).abs() > 0.05 * most);
}

/// Limits that makers and users published at joints are those of the actuator behind the transmission: of the Go2's calf (IsaacLab
/// #7479) with r = 1.917, of the Go1's with 1.5, and of Spot's knee (IsaacLab, `spot.py`, measured by the Boston Dynamics AI Institute),
/// whose table gives r and the largest torque by angle: that of one motor, 1.5 N·m, at every angle.
#[test]
fn published_limits_at_joints_are_those_of_one_actuator() {
    for (r, joint, actuator) in [(1.917, (45.43, 15.70), (23.7, 30.1)), (1.5, (35.55, 20.06), (23.7, 30.1))] {
        let point = Point { torque: joint.0, velocity: joint.1, duration: Some(1.0), ..Default::default() };
        let (there, _) = Passed::new(&ideal(Way::Ratio(r)), &Motion::from_points(&[point])).unwrap();
        near(there.torque[0] / actuator.0, 1.0, 1e-3, "torque");
        near(there.velocity[0] / actuator.1, 1.0, 1e-3, "speed");
    }
    const SPOT: [[f64; 3]; 21] = [
        [-2.792_900, -24.776_718, 37.165_077],
        [-2.767_442, -26.290_108, 39.435_162],
        [-2.741_984, -27.793_369, 41.690_054],
        [-2.716_526, -29.285_997, 43.928_996],
        [-2.691_068, -30.767_536, 46.151_304],
        [-2.665_610, -32.237_423, 48.356_134],
        [-2.640_152, -33.695_168, 50.542_751],
        [-2.614_694, -35.140_221, 52.710_331],
        [-2.589_236, -36.572_052, 54.858_078],
        [-2.563_778, -37.990_086, 56.985_128],
        [-2.538_320, -39.393_730, 59.090_595],
        [-2.512_862, -40.782_406, 61.173_609],
        [-2.487_404, -42.155_487, 63.233_231],
        [-2.461_946, -43.512_371, 65.268_557],
        [-2.436_488, -44.852_371, 67.278_557],
        [-2.411_030, -46.174_873, 69.262_310],
        [-2.385_572, -47.479_156, 71.218_735],
        [-2.360_114, -48.764_549, 73.146_824],
        [-2.334_656, -50.030_334, 75.045_502],
        [-2.309_198, -51.275_761, 76.913_641],
        [-2.283_740, -52.500_103, 78.750_154],
    ];
    // Every second row makes the table; those between are what it has to say.
    let rows: Vec<&[f64; 3]> = SPOT.iter().step_by(2).collect();
    let table = Table::new(rows.iter().map(|row| row[0]).collect(), rows.iter().map(|row| row[1]).collect(), 0.0);
    let knee = Way::Table(table);
    for [q, ratio, most] in SPOT {
        let at = knee.at(q).unwrap();
        near(at.ratio / ratio, 1.0, 1e-5, "ratio");
        near(most / at.ratio, -1.5, 1e-5, "the motor's torque");
    }
}

/// A constant ratio without loss and inertia divides the best gear ratio, and what it costs stays.
#[test]
fn the_best_ratio_behind_a_constant_one() {
    let motion = swing(0.2, 0.8);
    let robot = common::robot(motion.clone(), common::gear(1.0));
    let plain = solve(&motor(), &robot).unwrap();
    for r in [0.5, 1.5, 1.9169, -2.0] {
        let there = solve(&motor(), &behind(&robot, &ideal(Way::Ratio(r)), &motion)).unwrap();
        near(there.optimum.ratio * r.abs(), plain.optimum.ratio, 1e-9, "N r");
        near(there.optimum.objective, plain.optimum.objective, 1e-9, "loss");
        assert_eq!(there.optimum.windows.len(), plain.optimum.windows.len());
    }
}

/// The closed form: N* = (mean τ'²/mean m²)^¼ with τ' the torque at the actuator and m = J θ̈, and a dense scan of it.
#[test]
fn the_best_ratio_behind_a_table_is_that_of_raw_samples() {
    let motion = swing(0.2, 0.8);
    let robot = common::robot(motion.clone(), common::gear(1.0));
    let there = solve(&motor(), &behind(&robot, &ideal(Way::Table(table())), &motion)).unwrap();
    // From the functions themselves, on a grid of its own.
    let (period, count, w) = (0.8, 20_000, TAU / 0.8);
    let (mut square, mut inertia) = (0.0, 0.0);
    for k in 0..count {
        let t = period * f64::from(k) / f64::from(count);
        let (a, b) = (w * t, 2.0 * w * t + 1.0);
        let q = 0.2 + 0.8 * (0.8 * a.sin() + 0.2 * b.sin());
        let velocity = 0.8 * w * (0.8 * a.cos() + 0.4 * b.cos());
        let acceleration = 0.8 * w * w * (-0.8 * a.sin() - 0.8 * b.sin());
        let torque = 12.0 * q.sin() + 3.0 + 0.05 * acceleration;
        let (r, slope) = (1.9 + 0.5 * q.sin(), 0.5 * q.cos());
        square += (torque / r).powi(2);
        inertia += (300e-7 * (r * acceleration + slope * velocity * velocity)).powi(2);
    }
    // The spline through the samples and the table are near the functions, not the functions.
    let best = (square / inertia).powf(0.25);
    near(there.optimum.ratio / best, 1.0, 2e-4, "N*");
}

/// A lossy transmission of one ratio in front of an ideal gear is a gear of the product of both ratios with its efficiency: with
/// holds, too.
#[test]
fn a_transmission_of_one_ratio_is_part_of_the_gear() {
    let mut time: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.01).collect();
    let velocity: Vec<f64> = time.iter().map(|t| if *t < 0.5 { 3.0 * (TAU * t / 0.5).sin() } else { 0.0 }).collect();
    let torque = time.iter().map(|t| 4.0 + 3.0 * (TAU * t).sin()).collect();
    let motion = Motion::from_samples(
        Samples { time: std::mem::take(&mut time), torque, velocity: Some(velocity), ..Samples::default() },
        Course::Periodic(1.0),
    );
    let of_gear = common::robot(motion.clone(), common::gear(0.8));
    let ideal_gear = common::robot(motion.clone(), common::gear(1.0));
    let transmission = with(Way::Ratio(2.0), Numbers { efficiency: 0.8, backdrive_efficiency: 0.75, ..Numbers::IDEAL });
    let there = behind(&ideal_gear, &transmission, &motion);
    for ratio in [3.0, 8.0, 20.0] {
        let (a, b) = (common::evaluate(&of_gear, &motor(), 2.0 * ratio), common::evaluate(&there, &motor(), ratio));
        near(b.copper_loss, a.copper_loss, 1e-9, "copper loss");
        near(b.peak_current, a.peak_current, 1e-9, "peak current");
        near(b.rms_current, a.rms_current, 1e-9, "rms current");
        near(b.reflected_inertia, a.reflected_inertia, 1e-9, "inertia at the joint");
        near(b.mean_power, a.mean_power, 1e-9, "mean power");
        assert!(there.joints[0].motion.dwell.iter().sum::<f64>() > 0.3, "it holds half of the time");
    }
}

#[test]
fn limits_at_the_joint_by_hand() {
    let motion = swing(0.2, 0.8);
    let mut robot = common::robot(motion.clone(), common::gear(1.0));
    let joint = &mut robot.joints[0];
    joint.gear.inertia = 1e-6;
    (joint.gear.backlash, joint.gear.stiffness) = (Some(2e-3), Some(4000.0));
    joint.gear.ratings.momentary_peak_torque = Some(100.0);
    joint.gear.friction_at_rest = Some(0.01);
    joint.motor_drag = gearwise::requirement::MotorDrag::Counted;
    (joint.limits.max_backlash, joint.limits.min_stiffness) = (Some(1.0), Some(1.0));
    (joint.limits.shock_torque, joint.limits.reflected_inertia) = (Some(50.0), Some(10.0));
    joint.limits.max_backdriving_torque = Some(100.0);
    joint.limits.actuator_mass = Some(9.0);
    joint.limits.safety = 1.5;
    let transmission = with(
        Way::Table(table()),
        Numbers {
            inertia: 1e-3,
            joint_inertia: 0.02,
            mass: Some(0.4),
            backlash: Some(1e-3),
            stiffness: Some(3000.0),
            peak_torque: Some(40.0),
            max_input_speed: Some(50.0),
            efficiency: 0.9,
            backdrive_efficiency: 0.85,
            ..Numbers::IDEAL
        },
    );
    let robot = behind(&robot, &transmission, &motion);
    let passed = robot.joints[0].passed.clone().unwrap();
    let q = passed.motion().position.clone().unwrap();
    let [low, high] = [f64::min, f64::max].map(|f| q.iter().copied().reduce(f).unwrap());
    let (least, most) = (1.9 + 0.5 * low.sin(), 1.9 + 0.5 * high.sin());
    near(passed.ratio().unwrap().least.0, least, 1e-5, "least ratio");
    near(passed.ratio().unwrap().most.0, most, 1e-5, "largest ratio");
    let motor = common::motor(&[
        ("resistance [ohm]", "0.2"),
        ("torque_constant [N*m/A]", "0.08"),
        ("rotor_inertia [g*cm^2]", "300"),
        ("mass [g]", "200"),
        ("coulomb_friction [N*m]", "0.02"),
    ]);
    let n = 7.0;
    let found = common::evaluate(&robot, &motor, n);
    let demand = |limit| common::demand(&found, limit);
    near(demand("reflected_inertia"), most * most * (n * n * 31e-6 + 1e-3) + 0.02, 1e-5, "inertia");
    near(found.reflected_inertia, demand("reflected_inertia"), 1e-12, "figure");
    near(demand("gear_backlash"), 2e-3 / least + 1e-3, 1e-5, "backlash");
    let stiffness = found.margins.iter().find(|m| m.limit == "gear_stiffness").unwrap().bound;
    near(stiffness, 1.0 / (1.0 / (least * least * 4000.0) + 1.0 / 3000.0), 1e-4, "stiffness");
    near(demand("gear_momentary_torque"), 1.5 * 50.0 / least, 1e-5, "shock");
    near(demand("backdriving_torque"), most * n * 0.03 / 0.85, 1e-5, "backdriving");
    near(demand("actuator_mass"), 0.6, 1e-12, "mass");
    let at_joint = |k: usize| passed.motion().torque[k] + 0.02 * passed.motion().acceleration[k];
    let largest = (0..q.len()).map(|k| at_joint(k).abs()).fold(0.0, f64::max);
    near(demand("transmission_torque"), 1.5 * largest, 1e-9, "torque of the transmission");
    let fastest =
        (0..q.len()).map(|k| (passed.motion().velocity[k] * (1.9 + 0.5 * q[k].sin())).abs()).fold(0.0, f64::max);
    near(demand("transmission_speed"), fastest, 1e-5, "speed of its input");
}

/// The inertia that no ratio changes counts in the largest ratio that the limit leaves, and may be too much by itself.
#[test]
fn a_limit_on_inertia_counts_what_no_ratio_changes() {
    let motion = swing(0.2, 0.8);
    let numbers = Numbers { inertia: 2e-3, joint_inertia: 3e-3, ..Numbers::IDEAL };
    let of = |limit: f64| {
        let mut robot = common::robot(motion.clone(), common::gear(1.0));
        robot.joints[0].limits.reflected_inertia = Some(limit);
        behind(&robot, &with(Way::Ratio(1.5), numbers), &motion)
    };
    let fixed = 1.5 * 1.5 * 2e-3 + 3e-3;
    let free = solve(&motor(), &of(100.0)).unwrap().optimum.ratio;
    // Half of the best ratio's own inertia beside what is fixed.
    let own = 1.5 * 1.5 * free * free * 300e-7;
    let bound = solve(&motor(), &of(fixed + 0.5 * own)).unwrap();
    near(bound.optimum.ratio, free * 0.5_f64.sqrt(), 1e-9, "the largest ratio");
    let text = format!("{:?}", solve(&motor(), &of(0.9 * fixed)).err().expect("no ratio does"));
    assert!(text.contains("Never") && text.contains("reflected_inertia"), "{text}");
}

#[test]
fn the_force_of_a_rod_is_the_torque_over_its_arm() {
    let lever = Lever { pivot: [0.0, 0.2], arm: 0.05, arm_zero: 0.0, lead: 0.005 };
    let transmission = with(Way::Lever(lever), Numbers { max_force: Some(1e4), ..Numbers::IDEAL });
    let motion = swing(0.0, 0.7);
    let robot = behind(&common::robot(motion.clone(), common::gear(1.0)), &transmission, &motion);
    let found = common::evaluate(&robot, &motor(), 1.0);
    let passed = robot.joints[0].passed.clone().unwrap();
    let force = |k: usize| {
        let q = passed.motion().position.as_ref().unwrap()[k];
        // Distance of the screw's line from the joint's axis.
        let end = [0.05 * q.cos(), 0.05 * q.sin()];
        let along = [end[0], end[1] - 0.2];
        let arm = (end[0] * along[1] - end[1] * along[0]).abs() / along[0].hypot(along[1]);
        passed.motion().torque[k].abs() / arm
    };
    let largest = (0..passed.motion().len()).map(force).fold(0.0, f64::max);
    near(common::demand(&found, "transmission_force"), largest, 1e-9, "force");
}

/// What is not known of a transmission is not zero, and does not count as kept.
#[test]
fn what_a_transmission_does_not_say_is_not_judged() {
    let motion = swing(0.2, 0.8);
    let mut robot = common::robot(motion.clone(), common::gear(1.0));
    let joint = &mut robot.joints[0];
    (joint.gear.backlash, joint.gear.stiffness) = (Some(2e-3), Some(4000.0));
    (joint.limits.max_backlash, joint.limits.min_stiffness) = (Some(1.0), Some(1.0));
    let open = behind(&robot, &ideal(Way::Ratio(2.0)), &motion);
    let catalog = gearwise::catalog::Catalog::of(vec![motor()], Vec::new());
    let result = optimize(&open, &catalog);
    assert!(result.joints[0].candidates.is_empty(), "neither backlash nor stiffness of it is known");
    assert_eq!(result.joints[0].unjudged.len(), 1);
    // What is known exceeds the limit already: that is certain.
    let mut tight = robot.clone();
    tight.joints[0].limits.max_backlash = Some(0.9e-3);
    tight.joints[0].limits.min_stiffness = None;
    let tight = behind(&tight, &ideal(Way::Ratio(2.0)), &motion);
    let result = optimize(&tight, &catalog).joints.remove(0);
    assert!(result.candidates.is_empty() && result.unjudged.is_empty() && result.rejected.len() == 1);
    let said = with(Way::Ratio(2.0), Numbers { backlash: Some(0.0), stiffness: Some(1e9), ..Numbers::IDEAL });
    assert_eq!(optimize(&behind(&robot, &said, &motion), &catalog).joints[0].candidates.len(), 1);
}

/// What carried actuators add to the torque through a transmission is not looked at: its limit is not judged, and not kept.
#[test]
fn a_transmission_that_carries_actuators_is_not_said_to_bear_it() {
    let motion = swing(0.2, 0.8);
    let numbers = Numbers { peak_torque: Some(1000.0), ..Numbers::IDEAL };
    let mut robot = behind(&common::robot(motion.clone(), common::gear(1.0)), &with(Way::Ratio(2.0), numbers), &motion);
    let samples = robot.joints[0].motion.len();
    let found = |robot: &Robot| {
        let found = common::evaluate(robot, &motor(), 9.0);
        found.margins.iter().any(|m| m.limit == "transmission_torque")
    };
    assert!(found(&robot));
    robot.joints[0].carries = vec![gearwise::requirement::Carried {
        joint: 0,
        torque_per_mass: vec![1.0; samples],
        rate: vec![0.0; samples],
        constant: true,
    }];
    assert!(!found(&robot));
}

/// The torque of the bandwidth limit arrives over r, with the loss of its direction.
#[test]
fn a_superposed_torque_is_passed_on() {
    let motion = Motion::from_points(&[Point { torque: 6.0, velocity: 0.0, duration: Some(1.0), ..Point::default() }]);
    let mut robot = common::robot(motion.clone(), common::gear(1.0));
    robot.joints[0].limits.torque_bandwidth = Some(TorqueBandwidth { frequency: 10.0, amplitude: 4.0 });
    robot.bus.drive_current = Some(1e6);
    let lossy = with(Way::Ratio(2.0), Numbers { efficiency: 0.8, backdrive_efficiency: 0.75, ..Numbers::IDEAL });
    let found = common::evaluate(&behind(&robot, &lossy, &motion), &motor(), 5.0);
    let amplitude = (6.0 + 4.0) / 0.8 / 2.0 / 5.0 / 0.08;
    near(common::demand(&found, "torque_bandwidth_current"), amplitude, 1e-9, "current");
}

/// A spring at the joint or at the actuator behind a table, against a scan that adds its torque to the joint's motion.
#[test]
fn springs_on_either_side_of_a_table() {
    let motion = swing(0.2, 0.8);
    let gear = common::gear(1.0);
    let mut robot = common::robot(motion.clone(), gear);
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 40.0 };
    robot.joints[0].objective = Objective::single(Quantity::CopperLoss);
    let catalog = gearwise::catalog::Catalog::of(vec![motor()], Vec::new());
    let way = ideal(Way::Table(table()));
    for at in [SpringAt::Joint, SpringAt::Actuator] {
        let mut robot = behind(&robot, &way, &motion);
        let spring = Spring { stiffness: [0.0, 25.0], rest_angle: [-1.5, 1.5], at };
        robot.joints[0].limits.spring = Some(spring);
        let result = optimize(&robot, &catalog);
        let design = &result.joints[0].candidates[0];
        let chosen = design.spring.as_ref().expect("a spring was chosen");
        let (k, rest) = (chosen.stiffness, chosen.rest_angle.unwrap_or(0.0));
        // By hand: the spring's torque at the joint, or at the actuator.
        let loss = |n: f64, k: f64, rest: f64| {
            let sprung = match at {
                SpringAt::Joint => motion.with_spring(k, rest).unwrap(),
                SpringAt::Actuator => motion.clone(),
            };
            let (mut actuator, _) = Passed::new(&way, &sprung).unwrap();
            if at == SpringAt::Actuator {
                actuator = actuator.with_spring(k, rest).unwrap();
            }
            let torque = |k: usize| actuator.torque[k] / n + n * 300e-7 * actuator.acceleration[k];
            0.2 / 0.08_f64.powi(2) * actuator.mean(|k| torque(k).powi(2))
        };
        let here = loss(design.optimum.ratio, k, rest);
        near(design.optimum.objective, here, 1e-3, "the loss of the spring that was chosen");
        let mut least = f64::INFINITY;
        for i in 0..=12 {
            for j in 0..=12 {
                let (k, rest) = (25.0 * f64::from(i) / 12.0, -1.5 + 3.0 * f64::from(j) / 12.0);
                let best = (0..60).map(|m| loss(2.0 * 1.05_f64.powi(m), k, rest)).fold(f64::INFINITY, f64::min);
                least = least.min(best);
            }
        }
        assert!(design.optimum.objective <= least * (1.0 + 2e-3), "{at:?}: {} and {least}", design.optimum.objective);
        assert!(least < 1.3 * design.optimum.objective, "the scan comes near: {least}");
    }
}

/// A linkage whose ratio grows fast between two samples: the instants between are seen.
#[test]
fn instants_between_the_samples_are_those_of_the_actuator() {
    let (period, count) = (1.0, 24);
    let time: Vec<f64> = (0..count).map(|k| period * f64::from(k) / f64::from(count)).collect();
    let position: Vec<f64> = time.iter().map(|t| 0.9 * (TAU * t + 0.3).sin()).collect();
    let torque = time.iter().map(|t| 5.0 + (TAU * t).cos()).collect();
    let motion = Motion::from_samples(
        Samples { time, torque, position: Some(position), ..Samples::default() },
        Course::Periodic(period),
    );
    let rows: Vec<f64> = (0..=80).map(|k| -1.0 + 2.0 * f64::from(k) / 80.0).collect();
    let ratio = rows.iter().map(|q| 0.6 + 2.0 * q.powi(2)).collect();
    let way = Way::Table(Table::new(rows, ratio, 0.0));
    let (actuator, passed) = Passed::new(&ideal(way.clone()), &motion).unwrap();
    assert!(actuator.len() > motion.given.len() * 4, "{} instants", actuator.len());
    // The largest torque, from the joint's own spline on a fine grid: between its instants it is a cubic.
    let dense = |k: usize| {
        let next = (k + 1) % passed.motion().len();
        let m = passed.motion();
        let h = if next == 0 { period - m.time[k] + m.time[0] } else { m.time[next] - m.time[k] };
        let hermite = |y: &[f64], d: &[f64], s: f64| {
            let x = s / h;
            let (a, b) = ((1.0 + 2.0 * x) * (1.0 - x).powi(2), x * (1.0 - x).powi(2) * h);
            let (c, e) = (x * x * (3.0 - 2.0 * x), x * x * (x - 1.0) * h);
            a * y[k] + b * d[k] + c * y[next] + e * d[next]
        };
        let q = m.position.as_ref().unwrap();
        (0..20)
            .map(|i| {
                let s = h * f64::from(i) / 20.0;
                (hermite(&m.torque, &m.torque_rate, s) / way.at(hermite(q, &m.velocity, s)).unwrap().ratio).abs()
            })
            .fold(0.0, f64::max)
    };
    let most = (0..passed.motion().len()).map(dense).fold(0.0, f64::max);
    let seen = actuator.torque.iter().fold(0.0_f64, |m, t| m.max(t.abs()));
    assert!(seen <= most * (1.0 + 1e-9) && seen >= most * (1.0 - 2e-3), "{seen} of {most}");
}
