//! Load cases: the joint answer against a scan that looks at each case by itself, and identities.

use std::sync::Arc;

use gearwise::catalog::Motor;
use gearwise::design::answer::Reason;
use gearwise::design::program::Certificate;
use gearwise::design::robot::peak_power;
use gearwise::motion::{Lasting, Often};
use gearwise::requirement::*;

use crate::cases::{are_all, cases, quarter};
use crate::common;
use crate::raw::{Case, draw, golden};
use crate::solved;

/// A motor at a joint with two load cases, and each case as a joint of its own for the raw equations.
struct Both {
    parts: [Case; 2],
    cycles: [f64; 2],
    robot: Robot,
}

/// Demands that are roots of means over time.
const MEANS: &[&str] =
    &["continuous_current", "continuous_torque", "winding_temperature", "standstill_holding", "gear_continuous_torque"];

impl Both {
    /// Draws one: the motor, the limits and the first case of one random joint, and the motion of another with peaks alike.
    fn draw(index: u64, convex: bool) -> Option<Both> {
        let (mut first, other) = (draw(2 * index, convex), draw(2 * index + 1, convex));
        let timed = |case: &Case| {
            let motion = &case.robot.joints[0].motion;
            motion.has_durations() && motion.has_steady_heat()
        };
        if !timed(&first) || !timed(&other) {
            return None;
        }
        // Heat in time has tests of its own.
        first.motor.sheet.thermal_resistance_winding_housing = None;
        let joint = &first.robot.joints[0];
        let most = |of: &[Point], f: fn(&Point) -> f64| of.iter().map(|p| f(p).abs()).fold(0.0, f64::max);
        let torque = 0.9 * most(&first.raw, |p| p.torque) / most(&other.raw, |p| p.torque);
        let speed = 0.9 * most(&first.raw, |p| p.velocity) / most(&other.raw, |p| p.velocity);
        if !torque.is_finite() || !speed.is_finite() {
            return None;
        }
        let motion = other.robot.joints[0].motion.as_ref().clone().scaled(torque, speed);
        let faster = |p: &Point| Point {
            torque: torque * p.torque,
            velocity: speed * p.velocity,
            acceleration: speed * speed * p.acceleration,
            torque_rate: torque * speed * p.torque_rate,
            jerk: speed.powi(3) * p.jerk,
            duration: p.duration.map(|d| d / speed),
        };
        let raw: Vec<Point> = other.raw.iter().map(faster).collect();
        let cycles = [1.0 + (index % 5) as f64, 1.0 + (index % 3) as f64];
        let named = vec![("first".into(), joint.motion.as_ref().clone()), ("second".into(), motion.clone())];
        let mut robot = first.robot.clone();
        robot.joints[0].motion = Motion::from_cases(named, Often::Cycles(cycles.to_vec()), false).into();
        let mut second = first.robot.clone();
        second.joints[0].motion = motion.into();
        let parts = [Case::new(first.motor.clone(), first.robot, first.raw), Case::new(first.motor, second, raw)];
        Some(Both { parts, cycles, robot })
    }

    /// How the time is shared.
    fn shares(&self) -> [f64; 2] {
        let time = [0, 1].map(|i| self.cycles[i] * self.parts[i].robot.joints[0].motion.duration().unwrap());
        time.map(|t| t / (time[0] + time[1]))
    }

    /// By how much the worst limit is exceeded, and the objective.
    fn look(&self, n: f64) -> (f64, f64) {
        let looks = self.parts.each_ref().map(|part| part.look(n));
        let shares = self.shares();
        let over = |demand: f64, bound: f64| if bound > 0.0 { demand / bound - 1.0 } else { demand };
        let mut worst = f64::NEG_INFINITY;
        for (a, b) in looks[0].limits.iter().zip(&looks[1].limits) {
            let Some(bound) = a.2.or(b.2) else { continue };
            let demand = match a.0 {
                "ratio_min" | "ratio_max" => a.1,
                name if MEANS.contains(&name) => (shares[0] * a.1 * a.1 + shares[1] * b.1 * b.1).sqrt(),
                _ => a.1.max(b.1),
            };
            worst = worst.max(over(demand, bound));
        }
        let value = |(quantity, weight): &(Quantity, f64)| {
            let [a, b] = looks.each_ref().map(|look| look.quantities[*quantity as usize]);
            weight
                * match quantity {
                    Quantity::CopperLoss => shares[0] * a + shares[1] * b,
                    Quantity::Energy => self.cycles[0] * a + self.cycles[1] * b,
                    _ => a.max(b),
                }
        };
        (worst, self.robot.joints[0].objective.terms.iter().map(value).sum())
    }

    fn motor(&self) -> &Motor {
        &self.parts[0].motor
    }
}

/// The least objective of a scan, and the least excess of any ratio.
fn scan(both: &Both) -> (f64, f64) {
    let RatioChoice::Continuous { min, max } = both.robot.joints[0].ratio else { unreachable!() };
    let grid: Vec<f64> = (0..=1500).map(|i| min * (max / min).powf(f64::from(i) / 1500.0)).collect();
    let seen: Vec<(f64, f64, f64)> = grid.iter().map(|n| (*n, both.look(*n).0, both.look(*n).1)).collect();
    let value = |n: f64| match both.look(n) {
        (over, value) if over <= 0.0 => value,
        _ => f64::INFINITY,
    };
    let mut best = f64::INFINITY;
    let mut least = f64::INFINITY;
    for (i, (n, over, _)) in seen.iter().enumerate() {
        let around = [seen[i.saturating_sub(1)].0, seen[(i + 1).min(seen.len() - 1)].0];
        least = least.min(*over);
        best = best.min(value(*n));
        let lowest =
            |f: &dyn Fn(usize) -> f64| f(i) <= f(i.saturating_sub(1)) && f(i) <= f((i + 1).min(seen.len() - 1));
        if lowest(&|k| seen[k].1) {
            let deepest = golden(|n| both.look(n).0, around);
            least = least.min(both.look(deepest).0);
            best = best.min(value(deepest));
        }
        if lowest(&|k| if seen[k].1 <= 0.0 { seen[k].2 } else { f64::INFINITY }) && *over <= 0.0 {
            best = best.min(value(golden(value, around)));
            // The end of a window, to the last ratio that keeps everything.
            for beyond in around.into_iter().filter(|n| both.look(*n).0 > 0.0) {
                let (mut good, mut bad) = (*n, beyond);
                for _ in 0..50 {
                    let middle = 0.5 * (good + bad);
                    if both.look(middle).0 > 0.0 { bad = middle } else { good = middle }
                }
                best = best.min(value(good));
            }
        }
    }
    (best, least)
}

#[test]
fn the_best_ratio_over_all_cases_is_that_of_a_scan() {
    let (mut solved_alike, mut refused_alike) = (0, 0);
    for index in cases(0, 240) {
        let Some(both) = Both::draw(index, index % 2 == 0) else { continue };
        let (best, least) = scan(&both);
        match solved::solve(both.motor(), &both.robot) {
            Ok(found) => {
                let n = found.optimum.ratio;
                let (over, value) = both.look(n);
                assert!(over <= 1e-7, "{index}: N* = {n} exceeds a limit of a case by {over}");
                let scale = value.abs().max(1e-12);
                assert!(
                    (value - found.optimum.objective).abs() <= 1e-8 * scale,
                    "{index}: {value} {:?}",
                    found.optimum
                );
                assert!(value <= best + 1e-6 * scale, "{index}: {value} at {n}, and the scan has {best}");
                if let Certificate::Certified { lower_bound, .. } = found.optimum.certificate {
                    assert!(
                        lower_bound <= best + 1e-8 * scale,
                        "{index}: bound {lower_bound}, and the scan has {best}"
                    );
                }
                // Each case alone keeps what is asked at every instant.
                for part in &both.parts {
                    let exceeded = part.look(n).limits.into_iter().find(|(name, demand, bound)| {
                        let fixed = MEANS.contains(name) || name.starts_with("ratio");
                        !fixed && bound.is_some_and(|bound| *demand > bound * (1.0 + 1e-7) + 1e-9)
                    });
                    assert_eq!(exceeded.map(|limit| limit.0), None, "{index}");
                }
                solved_alike += 1;
            }
            Err(Reason::Infeasible(_)) => {
                assert!(least > -1e-6, "{index}: refused, and a ratio keeps all with {least}");
                refused_alike += 1;
            }
            Err(other) => panic!("{index}: {other:?}"),
        }
    }
    println!("{solved_alike} solved, {refused_alike} refused");
    assert!(!are_all() || solved_alike > 10 && refused_alike > 3);
}

#[test]
fn the_same_motion_twice_is_the_motion_once() {
    let mut compared = 0;
    for index in quarter(0, 120) {
        let case = draw(index, true);
        let mut robot = case.robot.clone();
        let motion = robot.joints[0].motion.as_ref().clone();
        // From cold it has no steady heat, and in a case it is made again and again.
        if !motion.has_durations() || !motion.has_steady_heat() || case.nodes().is_some() {
            continue;
        }
        let named = vec![("a".to_string(), motion.clone()), ("b".to_string(), motion)];
        let energy = robot.joints[0].objective.weight(Quantity::Energy) > 0.0;
        let often = if energy { Often::Cycles(vec![0.3, 0.7]) } else { Often::Shares(vec![0.3, 0.7]) };
        robot.joints[0].motion = Motion::from_cases(named, often, false).into();
        match (solved::solve(&case.motor, &case.robot), solved::solve(&case.motor, &robot)) {
            (Ok(once), Ok(twice)) => {
                let (a, b) = (once.optimum.objective, twice.optimum.objective);
                assert!((a - b).abs() <= 1e-9 * a.abs().max(1e-9), "{index}: {a} {b}");
                compared += 1;
            }
            (Err(_), Err(_)) => {}
            (a, b) => panic!("{index}: {} {}", a.is_ok(), b.is_ok()),
        }
    }
    assert!(compared > 5, "{compared}");
}

fn wave(period: f64, torque: f64, swing: f64) -> Motion {
    let turn = std::f64::consts::TAU;
    let time: Vec<f64> = (0..24).map(|k| period * f64::from(k) / 24.0).collect();
    let position: Vec<f64> = time.iter().map(|t| 0.2 + swing * (turn * t / period).sin()).collect();
    let torques = time.iter().map(|t| torque * (0.3 + (turn * t / period).sin())).collect();
    Motion::from_samples(
        Samples { time, torque: torques, position: Some(position), ..Samples::default() },
        Course::Periodic(period),
    )
}

#[test]
fn a_spring_serves_all_cases() {
    let motor = common::motor(&[
        ("resistance [ohm]", "0.3"),
        ("torque_constant [N*m/A]", "0.1"),
        ("mass [kg]", "0.5"),
        ("rotor_inertia [kg*m^2]", "1e-5"),
    ]);
    let (walk, climb) = (wave(1.0, 20.0, 0.3), wave(1.6, 32.0, 0.4));
    let named = vec![("walk".to_string(), walk.clone()), ("climb".to_string(), climb.clone())];
    let both = Motion::from_cases(named, Often::Shares(vec![0.8, 0.2]), false);
    for (stiffness, rest) in [(0.0, 0.0), (20.0, 0.1), (60.0, -0.05)] {
        for ratio in [8.0, 20.0] {
            let loss = |motion: &Motion| {
                let robot = common::robot(motion.with_spring(stiffness, rest).unwrap(), common::gear(0.9));
                common::evaluate(&robot, &motor, ratio).copper_loss
            };
            let sum = 0.8 * loss(&walk) + 0.2 * loss(&climb);
            assert!((loss(&both) / sum - 1.0).abs() < 1e-9, "{stiffness} {ratio}");
        }
    }
}

/// Two joints with two cases each.
fn two_joints() -> Robot {
    // One works hardest when it climbs, the other when it walks.
    let joint = |torque: f64, harder: f64| {
        let climb = wave(1.6, harder * torque, 0.4);
        let named = vec![("walk".to_string(), wave(1.0, torque, 0.3)), ("climb".to_string(), climb)];
        Motion::from_cases(named, Often::Shares(vec![0.8, 0.2]), false)
    };
    let mut robot = common::robot(joint(5.0, 2.5), common::gear(0.9));
    let mut other = robot.joints[0].clone();
    other.name = "other".into();
    other.motion = joint(8.0, 0.5).into();
    other.count = 2;
    robot.joints.push(other);
    robot
}

#[test]
fn power_adds_up_within_a_case_of_the_robot() {
    let robot = two_joints();
    let courses: Vec<Vec<f64>> = robot
        .joints
        .iter()
        .map(|j| (0..j.motion.len()).map(|k| j.motion.torque[k] * j.motion.velocity[k]).collect())
        .collect();
    // The same with each case alone.
    let alone = |case: usize| {
        let mut robot = robot.clone();
        let mut of_case = Vec::new();
        for (joint, course) in robot.joints.iter_mut().zip(&courses) {
            let (samples, motion) = joint.motion.parts().swap_remove(case);
            joint.motion = Arc::new(motion);
            of_case.push(course[samples].to_vec());
        }
        peak_power(&robot, &of_case)
    };
    let together = peak_power(&robot, &courses);
    assert_eq!(together, alone(0).max(alone(1)));
    // Where one walks while the other climbs, the sum of what was never together is a safe bound, and larger than either.
    let mut apart = robot.clone();
    apart.cases = vec![RobotCase { name: "both".into(), cases: vec![None, None] }];
    let peak = |course: &Vec<f64>| course.iter().copied().fold(0.0, f64::max);
    let bound = peak(&courses[0]) + 2.0 * peak(&courses[1]);
    assert!((peak_power(&apart, &courses) - bound).abs() < 1e-9 && bound > together);
    // One that is named otherwise goes with it where the requirement says so.
    let mut crossed = robot.clone();
    crossed.cases = vec![RobotCase { name: "mixed".into(), cases: vec![Some(0), Some(1)] }];
    let mixed = peak_power(&crossed, &courses);
    // What the robot's case leaves out still happens: both climb, and both walk, by name.
    assert!(mixed >= together && mixed <= bound);
    assert_eq!(crossed.scenarios().len(), 3);
    // Where it tells of all of them there is nothing else.
    let told = |name: &str, case: usize| RobotCase { name: name.into(), cases: vec![Some(case), Some(case)] };
    crossed.cases = vec![told("a", 0), told("b", 1)];
    assert_eq!(crossed.scenarios().len(), 2);
    assert_eq!(peak_power(&crossed, &courses), together);
}

#[test]
fn heat_of_an_order_is_between_its_cases_and_an_order_of_blocks_is_hotter() {
    let motor = common::motor(&[
        ("resistance [ohm]", "0.3"),
        ("torque_constant [N*m/A]", "0.1"),
        ("mass [kg]", "0.5"),
        ("rotor_inertia [kg*m^2]", "1e-5"),
        ("thermal_resistance_winding_housing [K/W]", "1.0"),
        ("thermal_resistance_housing_ambient [K/W]", "2.0"),
        ("thermal_time_constant_winding [s]", "15"),
        ("thermal_time_constant_housing [s]", "600"),
        ("max_winding_temperature [degC]", "155"),
    ]);
    let list = || vec![("walk".to_string(), wave(1.0, 6.0, 0.3)), ("climb".to_string(), wave(1.6, 14.0, 0.4))];
    let peak = |motion: Motion| {
        let robot = common::robot(motion, common::gear(0.9));
        common::demand(&common::evaluate(&robot, &motor, 15.0), "winding_peak_temperature")
    };
    let alone = |case: usize| peak(list().swap_remove(case).1);
    let (cool, hot) = (alone(0), alone(1));
    let order = |walk: f64, climb: f64| Often::Order(vec![(0, Lasting::Duration(walk)), (1, Lasting::Duration(climb))]);
    let (short, long) = (order(8.0, 2.0), order(40_000.0, 10_000.0));
    let (short, long) = (peak(Motion::from_cases(list(), short, false)), peak(Motion::from_cases(list(), long, false)));
    // Mixed quickly it is the mean of both; in blocks of hours it is all of the hotter one, or above it by what is left of
    // the mean that stands for most of its repetitions: less than 1 %, as the documentation says.
    assert!(cool < short && short < long && long <= hot * (1.0 + 1e-2), "{cool} {short} {long} {hot}");
    assert!(long > 0.99 * hot, "{long} {hot}");
    let shares = peak(Motion::from_cases(list(), Often::Shares(vec![0.8, 0.2]), false));
    assert!((shares / short - 1.0).abs() < 0.05, "{shares} {short}");
    // Once from cold it gets no hotter than again and again.
    let once = peak(Motion::from_cases(list(), order(8.0, 2.0), true));
    assert!(once < short);
}
