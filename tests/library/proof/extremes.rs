//! Joints of any size and shape: a right answer or a clear refusal, never a wrong one.
//!
//! The laws of similarity are the reference where numbers are very large or small: torque times s, time
//! times θ and volts per speed times a, with a motor to match, leave the best ratio, the window and the
//! verdict as they are. Elsewhere it is the scan of the raw waveforms.

use std::sync::Arc;

use gearwise::catalog::{Motor, Printed};
use gearwise::design::answer::Reason;
use gearwise::design::program::{Certificate, Infeasible, Optimum};
use gearwise::requirement::*;
use rayon::prelude::*;

use crate::cases::{are_all, cases, few, quarter};
use crate::raw::{Case, Scan, draw};
use crate::solved;

/// The optimum of a case, or why there is none.
fn solve(motor: &Motor, robot: &Robot) -> Result<Optimum, Reason> {
    solved::solve(motor, robot).map(|found| found.optimum)
}

/// What a quantity is measured in is multiplied by.
#[derive(Debug, Clone, Copy)]
struct Scale {
    torque: f64,
    time: f64,
    /// Volts per speed, newton metres per ampere.
    constant: f64,
}

impl Scale {
    fn inertia(self) -> f64 {
        self.torque * self.time * self.time
    }

    fn current(self) -> f64 {
        self.torque / self.constant
    }

    fn voltage(self) -> f64 {
        self.constant / self.time
    }

    fn power(self) -> f64 {
        self.torque / self.time
    }

    fn quantity(self, quantity: Quantity) -> f64 {
        match quantity {
            Quantity::Loss | Quantity::CopperLoss | Quantity::PeakPower => self.power(),
            Quantity::ReflectedInertia => self.inertia(),
            Quantity::PeakCurrent => self.current(),
            Quantity::Mass => 1.0,
            Quantity::Energy => self.torque,
        }
    }

    fn motor(self, motor: &Motor) -> Motor {
        let mut m = motor.clone();
        let by = |x: &mut Option<f64>, factor: f64| *x = x.map(|x| x * factor);
        m.torque_constant *= self.constant;
        m.back_emf_constant *= self.constant;
        m.resistance *= self.voltage() / self.current();
        by(&mut m.inductance, self.time * self.voltage() / self.current());
        by(&mut m.rotor_inertia, self.inertia());
        by(&mut m.viscous_friction, self.torque * self.time);
        by(&mut m.coulomb_friction, self.torque);
        by(&mut m.peak_current, self.current());
        by(&mut m.continuous_current, self.current());
        by(&mut m.peak_torque, self.torque);
        by(&mut m.continuous_torque, self.torque);
        by(&mut m.max_speed, 1.0 / self.time);
        by(&mut m.thermal_resistance, 1.0 / self.power());
        let printed = |x: &mut Option<Printed>, factor: f64| {
            *x = x.map(|x| Printed { value: x.value * factor, tolerance: None });
        };
        printed(&mut m.sheet.thermal_resistance_winding_housing, 1.0 / self.power());
        printed(&mut m.sheet.thermal_resistance_housing_ambient, 1.0 / self.power());
        printed(&mut m.sheet.thermal_time_constant_winding, self.time);
        printed(&mut m.sheet.thermal_time_constant_housing, self.time);
        m
    }

    fn robot(self, robot: &Robot) -> Robot {
        let mut r = robot.clone();
        let by = |x: &mut Option<f64>, factor: f64| *x = x.map(|x| x * factor);
        r.bus.voltage *= self.voltage();
        by(&mut r.bus.drive_current, self.current());
        by(&mut r.bus.power, self.power());
        by(&mut r.bus.current, self.current());
        if let Regeneration::Limited(watt) = &mut r.bus.regeneration {
            *watt *= self.power();
        }
        let joint = &mut r.joints[0];
        by(&mut joint.drive_current, self.current());
        joint.gear.inertia *= self.inertia();
        by(&mut joint.gear.peak_torque, self.torque);
        by(&mut joint.gear.continuous_torque, self.torque);
        by(&mut joint.gear.max_input_speed, 1.0 / self.time);
        by(&mut joint.limits.reflected_inertia, self.inertia());
        if let Some(bandwidth) = &mut joint.limits.torque_bandwidth {
            bandwidth.amplitude *= self.torque;
            bandwidth.frequency /= self.time;
        }
        let sum = joint.objective.terms.len() > 1;
        for (quantity, weight) in joint.objective.terms.iter_mut().filter(|_| sum) {
            *weight /= self.quantity(*quantity);
        }
        let motion = Arc::make_mut(&mut joint.motion);
        let all = |x: &mut Vec<f64>, factor: f64| x.iter_mut().for_each(|x| *x *= factor);
        if !matches!(motion.course, Course::Points(_)) {
            all(&mut motion.time, self.time);
        }
        all(&mut motion.torque, self.torque);
        all(&mut motion.torque_rate, self.power());
        all(&mut motion.velocity, 1.0 / self.time);
        all(&mut motion.acceleration, self.time.powi(-2));
        all(&mut motion.jerk, self.time.powi(-3));
        motion.course = match motion.course {
            Course::Periodic(duration) => Course::Periodic(duration * self.time),
            Course::Once(duration) => Course::Once(duration * self.time),
            Course::Points(duration) => Course::Points(duration.map(|duration| duration * self.time)),
            Course::Cases => unreachable!("a drawn motion has no cases"),
        };
        r
    }
}

fn certified(optimum: &Optimum) -> bool {
    matches!(optimum.certificate, Certificate::Certified { .. })
}

/// How two optima differ, relative; the second's objective is that many times the first's.
fn apart(a: &Optimum, b: &Optimum, factor: f64, size: f64) -> Result<[f64; 3], String> {
    if a.windows.len() != b.windows.len() || certified(a) != certified(b) {
        return Err(format!("{a:?}\n{b:?}"));
    }
    let ends = a.windows.iter().zip(&b.windows).flat_map(|(a, b)| [a.min / b.min - 1.0, a.max / b.max - 1.0]);
    let ends = ends.fold(0.0, |most: f64, x| most.max(x.abs()));
    let objective = (b.objective / factor - a.objective).abs() / a.objective.abs().max(size);
    Ok([objective, ends, (a.ratio / b.ratio - 1.0).abs()])
}

fn similar(cases: impl IndexedParallelIterator<Item = (Case, Scale)>) {
    // What is slow against a time constant of so many seconds is no matter of scale.
    let is_slow = |case: &Case, scale: &Scale| {
        case.has_slow_motion()
            || Case::new(scale.motor(&case.motor), scale.robot(&case.robot), Vec::new()).has_slow_motion()
    };
    let found: Vec<_> = cases
        .enumerate()
        .filter(|(_, (case, scale))| !is_slow(case, scale))
        .map(|(i, (case, scale))| {
            let (motor, robot) = (scale.motor(&case.motor), scale.robot(&case.robot));
            let objective = &case.robot.joints[0].objective;
            let factor = objective.sole().map_or(1.0, |quantity| scale.quantity(quantity));
            let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
            let size = 1e-3 * case.look((min * max).sqrt()).objective.abs();
            match (solve(&case.motor, &case.robot), solve(&motor, &robot)) {
                (Ok(a), Ok(b)) => apart(&a, &b, factor, size.max(1e-300)).map(Some).map_err(|why| (i, scale, why)),
                (Err(a), Err(b)) if std::mem::discriminant(&a) == std::mem::discriminant(&b) => Ok(None),
                (a, b) => Err((i, scale, format!("{a:?}\n{b:?}"))),
            }
        })
        .collect();
    for (i, scale, why) in found.iter().filter_map(|f| f.as_ref().err()).take(5) {
        println!("case {i} at {scale:?}: {why}");
    }
    let feasible: Vec<[f64; 3]> = found.iter().filter_map(|f| *f.as_ref().ok()?).collect();
    let most = [0, 1, 2].map(|k| feasible.iter().map(|x| x[k]).fold(0.0, f64::max));
    println!("{} cases, {} feasible; objective, window, ratio most apart {most:?}", found.len(), feasible.len());
    assert!(found.iter().all(Result::is_ok) && feasible.len() * 5 > 2 * found.len());
    // A flat valley is as wide as the root of what rounding leaves of its bottom.
    assert!(most[0] < 1e-8 && most[1] < 1e-8 && most[2] < 1e-5, "{most:?}");
}

/// A case with its largest torque brought to a size; times and constants besides.
fn sized(i: u64, convex: bool, torque: f64, time: f64, constant: f64) -> (Case, Scale) {
    let case = draw(i, convex);
    let largest = case.raw.iter().map(|p| p.torque.abs()).fold(0.0, f64::max);
    (case, Scale { torque: torque / largest, time, constant })
}

/// What scales 240 cases are drawn at: the corners and the middle.
fn at_all_sizes(convex: bool, first: u64) {
    let cases = (0..quarter(0, 240).end as usize).into_par_iter().map(|i| {
        let torque = [1e-6, 1e-3, 1.0, 1e3, 1e6][i % 5];
        let (time, constant) = ([0.03, 1.0, 30.0][i / 5 % 3], [1e-3, 1.0, 1e3][i / 15 % 3]);
        sized(first + i as u64, convex, torque, time, constant)
    });
    similar(cases);
}

#[test]
fn convex_joints_of_any_size_are_similar() {
    at_all_sizes(true, 20_000);
}

#[test]
fn other_joints_of_any_size_are_similar() {
    at_all_sizes(false, 120_000);
}

#[test]
fn rotors_from_a_nanogram_to_a_machine_are_similar() {
    let scales: Vec<(Case, Scale)> = (0..120_u64)
        .map(|i| {
            let case = draw(30_000 + i, true);
            let inertia = [1e-9, 1e-6, 1e-3, 1.0][i as usize % 4];
            let torque = inertia / case.motor.rotor_inertia.unwrap();
            (case, Scale { torque, time: 1.0, constant: torque.sqrt() })
        })
        .collect();
    similar(scales.into_par_iter());
}

/// Whether the program and the scan of the raw waveforms agree; an error says how not.
fn agrees(case: &Case) -> Result<bool, String> {
    let scan = Scan::new(case);
    let found = solve(&case.motor, &case.robot);
    let tell = |what: &str| Err(format!("{what}: {found:?}\nscan {:?} {:?}", scan.windows, scan.least));
    match &found {
        Ok(optimum) => {
            if scan.windows.is_empty() && scan.least.0 > 1e-7 {
                return tell("feasible");
            }
            let best = scan.least_of(|n| case.look(n).objective);
            let (first, last) = (scan.grid[0], scan.grid[scan.grid.len() - 1]);
            let size = best.abs().max(1e-6 * case.look((first * last).sqrt()).objective.abs()).max(1e-300);
            if !scan.windows.is_empty() && (optimum.objective - best).abs() > 1e-6 * size {
                return tell("objective");
            }
            let ends = scan.windows.iter().zip(&optimum.windows);
            let wide = |[a, b]: &[f64; 2]| b / a > 1.0 + 1e-6;
            let worst = ends.map(|(a, b)| (a[0] / b.min - 1.0).abs().max((a[1] / b.max - 1.0).abs()));
            if scan.windows.iter().all(wide)
                && (scan.windows.len() != optimum.windows.len() || worst.fold(0.0, f64::max) > 1e-6)
            {
                return tell("window");
            }
            if let Certificate::Certified { lower_bound, .. } = optimum.certificate
                && lower_bound > best + 1e-9 * size
            {
                return tell("lower bound");
            }
            Ok(true)
        }
        Err(Reason::Infeasible(_)) if scan.windows.is_empty() || scan.least.0 > -1e-7 => Ok(false),
        // Nothing found, nothing ruled out, and said so: no wrong answer where there is none.
        Err(Reason::NotSolved(_)) if scan.windows.is_empty() => Ok(false),
        _ => tell("refused"),
    }
}

/// Changes cases and looks at each; says how many are feasible.
fn all_agree(cases: std::ops::Range<u64>, convex: bool, change: impl Fn(&mut Case) + Sync) -> usize {
    let look = |i| {
        let mut case = draw(i, convex);
        change(&mut case);
        // What follows from the motion is made again.
        let case = Case::new(case.motor, case.robot, case.raw);
        (i, agrees(&case))
    };
    let found: Vec<_> = cases.into_par_iter().map(look).collect();
    for (i, why) in found.iter().filter_map(|(i, f)| Some((i, f.as_ref().err()?))).take(5) {
        println!("case {i}: {why}");
    }
    assert!(found.iter().all(|(_, f)| f.is_ok()));
    found.iter().filter(|(_, f)| *f == Ok(true)).count()
}

/// Sets the motion of a case to operating points.
fn set_points(case: &mut Case, points: Vec<Point>) {
    case.robot.joints[0].motion = Motion::from_points(&points).into();
    case.raw = points;
}

#[test]
fn a_range_of_one_ratio_is_that_ratio_or_nothing() {
    for convex in [true, false] {
        let first = if convex { 40_000 } else { 140_000 };
        let one = |case: &mut Case| {
            let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
            let n = (min * max).sqrt();
            case.robot.joints[0].ratio = RatioChoice::Continuous { min: n, max: n };
        };
        let feasible = (first..first + 100)
            .filter(|i| {
                let mut case = draw(*i, convex);
                one(&mut case);
                let RatioChoice::Continuous { min, .. } = case.robot.joints[0].ratio else { unreachable!() };
                let excess = case.worst(min).0;
                let found = solve(&case.motor, &case.robot);
                match &found {
                    Ok(optimum) => {
                        assert!(excess < 1e-7 && (optimum.ratio / min - 1.0).abs() < 1e-9, "{i}: {excess} {optimum:?}");
                        let here = case.look(min).objective;
                        assert!(
                            (optimum.objective - here).abs() <= 1e-8 * here.abs() + 1e-30,
                            "{i}: {optimum:?} {here}"
                        );
                        assert!(certified(optimum), "{i}");
                    }
                    Err(why) => {
                        assert!(matches!(why, Reason::Infeasible(_)) && excess > -1e-7, "{i}: {excess} {why:?}")
                    }
                }
                found.is_ok()
            })
            .count();
        println!("{feasible} of 100 feasible");
        assert!(feasible > 5);
    }
}

#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn nine_decades_of_ratios_are_searched() {
    for (cases, convex) in [(quarter(50_000, 120), true), (quarter(150_000, 60), false)] {
        let feasible = all_agree(cases, convex, |case| {
            case.robot.joints[0].ratio = RatioChoice::Continuous { min: 1e-3, max: 1e6 };
        });
        println!("{feasible} feasible");
        assert!(!are_all() || feasible > 20);
    }
}

#[test]
fn two_samples_are_a_motion() {
    for (cases, convex) in [(quarter(60_000, 100), true), (quarter(160_000, 100), false)] {
        let feasible = all_agree(cases, convex, |case| {
            let duration = Some(0.25);
            let mut ends = [case.raw[0], case.raw[case.raw.len() / 2]].map(|p| Point { duration, ..p });
            if ends.iter().all(|p| p.velocity == 0.0) {
                ends.iter_mut().for_each(|p| (p.acceleration, p.jerk) = (0.0, 0.0));
            }
            let column = |f: fn(&Point) -> f64| ends.iter().map(f).collect::<Vec<f64>>();
            let samples = Samples {
                time: vec![0.0, 0.25],
                torque: column(|p| p.torque),
                position: None,
                velocity: Some(column(|p| p.velocity)),
                acceleration: Some(column(|p| p.acceleration)),
                torque_rate: Some(column(|p| p.torque_rate)),
                jerk: Some(column(|p| p.jerk)),
            };
            case.robot.joints[0].motion = Motion::from_samples(samples, Course::Once(0.25)).into();
            case.raw = ends.to_vec();
        });
        println!("{feasible} feasible");
        assert!(!are_all() || feasible > 20);
    }
}

/// A period that is written down many times over is the same motion.
#[test]
fn a_hundred_thousand_samples_are_as_good_as_their_one_period() {
    let (mut seen, wanted) = (0, if are_all() { 6 } else { 2 });
    for i in 0..200 {
        let convex = i % 2 == 0;
        let case = draw(70_000 + i, convex);
        // A walk over all samples for each ratio of branch and bound takes minutes.
        if !convex && case.nodes().is_some() {
            continue;
        }
        let motion = &case.robot.joints[0].motion;
        let Course::Periodic(period) = motion.course else { continue };
        // Of so many samples degrees of standstill are those of an octave of ratios.
        if seen >= wanted || case.rippled.len() > 400 || case.has_slow_motion() {
            continue;
        }
        seen += 1;
        let times = 100_000 / motion.len();
        let repeat = |x: &[f64]| x.repeat(times);
        let time = (0..times).flat_map(|n| motion.time.iter().map(move |t| t + n as f64 * period)).collect();
        let samples = Samples {
            time,
            torque: repeat(&motion.torque),
            position: None,
            velocity: Some(repeat(&motion.velocity)),
            acceleration: Some(repeat(&motion.acceleration)),
            torque_rate: Some(repeat(&motion.torque_rate)),
            jerk: Some(repeat(&motion.jerk)),
        };
        let mut robot = case.robot.clone();
        robot.joints[0].motion = Motion::from_samples(samples, Course::Periodic(period * times as f64)).into();
        let weight = |q: Quantity| if q == Quantity::Energy { times as f64 } else { 1.0 };
        let terms = &mut robot.joints[0].objective.terms;
        let sum = terms.len() > 1;
        terms.iter_mut().filter(|_| sum).for_each(|(q, w)| *w /= weight(*q));
        let factor = if sum { 1.0 } else { weight(terms[0].0) };
        match (solve(&case.motor, &case.robot), solve(&case.motor, &robot)) {
            (Ok(a), Ok(b)) => {
                let most = apart(&a, &b, factor, 1e-300).unwrap_or_else(|why| panic!("{i}: {why}"));
                println!("case {i}, {} samples: most apart {most:?}", times * motion.len());
                assert!(most[0] < 1e-7 && most[1] < 1e-7 && most[2] < 1e-5, "{i}: {most:?}");
            }
            (Err(a), Err(b)) => assert_eq!(std::mem::discriminant(&a), std::mem::discriminant(&b)),
            (a, b) => panic!("{i}: {a:?}\n{b:?}"),
        }
    }
    assert_eq!(seen, wanted);
}

/// Torque alone, at rest or at a steady speed; as a point and as a motion.
#[test]
fn constant_torque_has_its_best_ratio() {
    for steady in [false, true] {
        for as_motion in [false, true] {
            let feasible = all_agree(cases(80_000, 80), true, |case| {
                let p = case.raw[0];
                let velocity = if steady { p.velocity } else { 0.0 };
                let point = Point { torque: p.torque, velocity, duration: Some(1.0), ..Point::default() };
                if !as_motion {
                    return set_points(case, vec![point]);
                }
                let count = 5;
                let samples = Samples {
                    time: (0..count).map(|k| 0.25 * k as f64).collect(),
                    torque: vec![p.torque; count],
                    velocity: Some(vec![velocity; count]),
                    ..Samples::default()
                };
                case.robot.joints[0].motion = Motion::from_samples(samples, Course::Periodic(1.25)).into();
                case.raw = vec![Point { duration: None, ..point }; count];
            });
            println!("steady {steady}, as a motion {as_motion}: {feasible} feasible");
            assert!(!are_all() || feasible > 10);
        }
    }
}

#[test]
fn no_motion_at_all_costs_nothing() {
    let mut feasible = 0;
    for i in 0..200 {
        let mut case = draw(90_000 + i, i % 2 == 0);
        set_points(&mut case, vec![Point { duration: Some(1.0), ..Point::default() }; 3]);
        case.robot.joints[0].limits.torque_bandwidth = None;
        // Friction at standstill opposes in limits: without it nothing is asked at all.
        case.motor.coulomb_friction = None;
        let asks = case.robot.joints[0].objective.clone();
        match solve(&case.motor, &case.robot) {
            Ok(optimum) => {
                feasible += 1;
                let at = case.look(optimum.ratio);
                assert_eq!(at.quantities[1], 0.0);
                assert!(
                    (optimum.objective - at.objective).abs() <= 1e-9 * at.objective.abs(),
                    "{i}: {asks:?} {optimum:?}"
                );
                assert!(certified(&optimum), "{i}: {asks:?} {optimum:?}");
            }
            // What does not depend on the motion: mass, inertia.
            Err(Reason::Infeasible(Infeasible::Contradiction { high, .. })) => {
                assert!(["actuator_mass", "reflected_inertia"].contains(&high.limit), "{i}: {high:?}");
            }
            Err(Reason::Infeasible(Infeasible::Never { bind, .. })) => assert_eq!(bind.limit, "actuator_mass", "{i}"),
            Err(why) => panic!("{i}: {why:?}"),
        }
    }
    assert!(feasible > 150, "{feasible}");
}

/// A hot day, or a bus that takes nothing back, is as forbidding to a motor of micrograms as to any other.
#[test]
fn a_limit_of_zero_is_one_at_any_size() {
    for torque in few(1, [1e-6, 1e-9, 1e-3, 1.0, 1e6]) {
        for i in 0..40 {
            let (case, scale) = sized(95_000 + i, true, torque, 1.0, torque.sqrt());
            let (mut motor, mut robot) = (scale.motor(&case.motor), scale.robot(&case.robot));
            motor.thermal_resistance = Some(motor.thermal_resistance.unwrap_or(2.0 / torque));
            (motor.max_winding_temperature, robot.ambient) = (Some(400.0), 410.0);
            let means = robot.joints[0].motion.has_durations();
            let vanishes = robot.joints[0].motion.len() == 1;
            if !means || vanishes {
                continue;
            }
            let found = solve(&motor, &robot);
            assert!(matches!(found, Err(Reason::Infeasible(_))), "{torque} {i}: {found:?}");
        }
        let mut refused = 0;
        for i in 0..40 {
            let (case, scale) = sized(95_100 + i, true, torque, 1.0, torque.sqrt());
            let (motor, mut robot) = (scale.motor(&case.motor), scale.robot(&case.robot));
            robot.bus.regeneration = Regeneration::Limited(0.0);
            let mut same = case.robot.clone();
            same.bus.regeneration = Regeneration::Limited(0.0);
            let (a, b) = (solve(&case.motor, &same), solve(&motor, &robot));
            assert_eq!(a.is_ok(), b.is_ok(), "{torque} {i}: {a:?}\n{b:?}");
            refused += usize::from(a.is_err());
        }
        assert!(refused > 5 && refused < 40, "{refused}");
    }
}

#[test]
fn limits_that_contradict_each_other_are_named() {
    let mut named = 0;
    for i in 0..if are_all() { 100 } else { 20 } {
        let mut case = draw(96_000 + i, true);
        let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
        let (low, high) = ((min * min * max).cbrt(), (min * max * max).cbrt());
        // Speed allows only small ratios, the current only large ones.
        let [slow, strong] = [low, high].map(|n| case.look(n).limits);
        let demand = |list: &[(&str, f64, Option<f64>)], name: &str| list.iter().find(|l| l.0 == name).unwrap().1;
        let (speed, current) = (demand(&slow, "max_speed"), demand(&strong, "peak_current"));
        if speed == 0.0 {
            continue;
        }
        (case.motor.max_speed, case.motor.peak_current) = (Some(speed), Some(current));
        let scan = Scan::new(&case);
        match solve(&case.motor, &case.robot) {
            Ok(optimum) => assert!(!scan.windows.is_empty(), "{i}: {optimum:?}"),
            Err(Reason::Infeasible(Infeasible::Contradiction { at_least, at_most, .. })) => {
                assert!(scan.windows.is_empty() && at_least > at_most, "{i}");
                named += 1;
            }
            Err(Reason::Infeasible(_)) => assert!(scan.windows.is_empty(), "{i}"),
            Err(why) => panic!("{i}: {why:?}"),
        }
    }
    println!("{named} contradictions");
    assert!(named > if are_all() { 5 } else { 0 });
}

/// One operating point whose motor torque vanishes at a ratio: the loss there is zero, and that is proved, although
/// the range of ratios is nine decades wide and its bounds round accordingly.
#[test]
fn a_loss_of_zero_is_certified_over_nine_decades() {
    let mut case = draw(150_421, false);
    case.robot.joints[0].ratio = RatioChoice::Continuous { min: 1e-3, max: 1e6 };
    let optimum = solve(&case.motor, &case.robot).expect("a choice");
    assert!(optimum.objective < 1e-12 && certified(&optimum), "{optimum:?}");
}
