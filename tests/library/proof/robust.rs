//! Robust designs against brute force: motors drawn anywhere in their tolerances never break a limit at the
//! robust ratio, and just outside of the robust window some motor does. Probabilities against paper.

use gearwise::actuator::Load;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::answer::Reason;
use gearwise::design::optimize::optimize;
use gearwise::design::options::Options;
use gearwise::design::program::Certificate;
use gearwise::design::robust::{RobustJoint, SAMPLES, Taken, robust, standard_error};
use gearwise::design::{Evaluation, Mount, Prepared};
use gearwise::report;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::cases::{are_all, cases};
use crate::common;

/// A column with its unit in the header, its number and its ±.
type Number = (&'static str, &'static str, f64, f64);

/// A motor from numbers; `with` says whether the ± are written down.
fn motor(numbers: &[Number], with: bool, other: &[(&str, &str)]) -> Motor {
    let mut cells: Vec<(String, String)> = other.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect();
    for (name, unit, value, tolerance) in numbers {
        cells.push((format!("{name} [{unit}]"), format!("{value:e}")));
        if with && *tolerance > 0.0 {
            cells.push((format!("{name}_tolerance [{unit}]"), format!("{tolerance:e}")));
        }
    }
    let cells: Vec<(&str, &str)> = cells.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    common::motor(&cells)
}

struct Case {
    robot: Robot,
    numbers: Vec<Number>,
    other: Vec<(&'static str, &'static str)>,
}

impl Case {
    fn motor(&self, with: bool) -> Motor {
        motor(&self.numbers, with, &self.other)
    }

    /// The motor with each number moved by a share of its ±, −1 to 1.
    fn moved(&self, mut share: impl FnMut(usize) -> f64) -> Motor {
        let moved = self.numbers.iter().enumerate();
        let numbers: Vec<Number> = moved.map(|(i, n)| (n.0, n.1, (n.2 + share(i) * n.3).max(0.0), 0.0)).collect();
        motor(&numbers, false, &self.other)
    }
}

fn evaluate(robot: &Robot, load: &Load, motor: &Motor, ratio: f64) -> Evaluation {
    Prepared::new(Mount::new(robot, &robot.joints[0], load, motor).candidate().unwrap()).at(ratio)
}

/// A random motor at a random joint, with limits around what a middling ratio needs.
fn draw(seed: u64) -> Case {
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut within = |a: f64, b: f64| generator.random_range(a..b);
    let count = 16;
    let (period, torque, speed) = (within(0.3, 2.0), within(2.0, 40.0), within(1.0, 8.0));
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
    let matched = within(5.0, 30.0);
    let inertia = torque / (speed * std::f64::consts::TAU / period) / (matched * matched) * within(0.3, 2.0);
    let resistance = within(0.05, 1.0);
    let constant = (resistance * torque / speed * within(1.0, 10.0)).sqrt() / matched;
    let mut numbers: Vec<Number> = Vec::new();
    let mut add = |name, unit, value: f64, chance: f64, size: f64| {
        let tolerance = if chance < 0.6 { value * size } else { 0.0 };
        numbers.push((name, unit, value, tolerance));
    };
    add("resistance", "ohm", resistance, within(0.0, 1.0), within(0.01, 0.15));
    add("torque_constant", "N*m/A", constant, within(0.0, 1.0), within(0.01, 0.12));
    add("rotor_inertia", "kg*m^2", inertia, within(0.0, 0.7), within(0.01, 0.2));
    let mut other = vec![("pole_pairs", "7")];
    match within(0.0, 3.0) as usize {
        0 => {}
        1 => {
            add("back_emf_constant", "V*s/rad", constant * 1.05, within(0.0, 1.0), within(0.01, 0.1));
            other.push(("back_emf_convention", "q_axis"));
        }
        _ => {
            add("speed_constant", "rad/(V*s)", 1.0 / constant, within(0.0, 1.0), within(0.01, 0.1));
            other.push(("speed_constant_convention", "dc"));
        }
    }
    if within(0.0, 1.0) < 0.6 {
        add("inductance", "H", resistance * within(1e-5, 3e-3), within(0.0, 0.8), within(0.05, 0.3));
    }
    if within(0.0, 1.0) < 0.5 {
        add("viscous_friction", "N*m*s/rad", inertia * within(0.5, 5.0), within(0.0, 0.8), within(0.1, 0.9));
    }
    if within(0.0, 1.0) < 0.25 {
        add("coulomb_friction", "N*m", torque / matched * within(0.01, 0.2), within(0.0, 0.8), within(0.1, 1.2));
    }
    let (low, high) = (matched * within(0.1, 0.4), matched * within(2.0, 5.0));
    robot.joints[0].ratio = RatioChoice::Continuous { min: low, max: high };
    robot.joints[0].limits.safety = within(0.9, 1.4).max(1.0);
    if within(0.0, 1.0) < 0.3 {
        robot.joints[0].limits.torque_bandwidth =
            Some(TorqueBandwidth { frequency: within(2.0, 30.0), amplitude: torque * within(0.05, 0.4) });
    }
    robot.bus.power = Some(1e9);
    robot.joints[0].limits.reflected_inertia = Some(1e9);
    let mut case = Case { robot, numbers, other };
    // Ratings above what the nominal motor needs at the middle ratio.
    let (joint, needs) = (&case.robot.joints[0], case.motor(false));
    let load = Load::new(&joint.motion, joint.ripple());
    let at = evaluate(&case.robot, &load, &needs, matched);
    let need = |name: &str| at.margins.iter().find(|m| m.limit == name).map_or(1.0, |m| m.demand);
    let slack = |x: f64| 1.02 + 0.6 * x;
    let (volts, watts, reflected) = (need("voltage"), need("bus_power"), need("reflected_inertia"));
    case.robot.bus.voltage = volts * slack(within(0.0, 1.0)) * 2.0_f64.sqrt();
    case.robot.bus.power = (within(0.0, 1.0) < 0.3).then(|| watts.max(1e-3) * slack(within(0.0, 1.0)));
    case.robot.joints[0].limits.reflected_inertia =
        (within(0.0, 1.0) < 0.4).then(|| reflected * slack(within(0.0, 1.0)));
    let mut rate = |name, unit, value: f64, chance: f64, slack: f64, size: f64| {
        if chance < 0.5 {
            case.numbers.push((name, unit, value * slack, if chance < 0.3 { value * size } else { 0.0 }));
        }
    };
    rate("peak_current", "A", at.peak_current * 1.4, within(0.0, 1.0), slack(within(0.0, 1.0)), within(0.01, 0.1));
    rate("continuous_current", "A", at.rms_current, within(0.0, 1.0), slack(within(0.0, 1.0)), within(0.01, 0.1));
    let hot = at.rms_current.powi(2) * needs.resistance;
    let (a, b) = (within(10.0, 30.0) / hot, within(10.0, 30.0) / hot);
    if within(0.0, 1.0) < 0.4 {
        case.numbers.push(("thermal_resistance_winding_housing", "K/W", a, 0.1 * a));
        case.numbers.push(("thermal_resistance_housing_ambient", "K/W", b, 0.1 * b));
        case.robot.joints[0].limits.winding_temperature = Some(383.15);
    }
    case
}

#[test]
fn no_motor_within_the_tolerances_breaks_a_limit_and_outside_the_window_one_does() {
    let (mut feasible, mut lost, mut ends, mut narrower) = (0, 0, 0, 0);
    for seed in cases(0, 340) {
        let case = draw(seed);
        let catalog = Catalog::of(vec![case.motor(true)], Vec::new());
        let joint = &case.robot.joints[0];
        let load = Load::new(&joint.motion, joint.ripple());
        let result = &robust(&case.robot, &catalog, Options::default()).unwrap()[0];
        let free: Vec<usize> = (0..case.numbers.len()).filter(|i| case.numbers[*i].3 > 0.0).collect();
        let corner = |bits: usize| {
            case.moved(|i| match free.iter().position(|f| *f == i) {
                Some(place) => [-1.0, 1.0][bits >> place & 1],
                None => 0.0,
            })
        };
        // At most 512 corners, spread over all.
        let count = 1_usize << free.len();
        let corners: Vec<Motor> = (0..count).step_by((count / 512).max(1)).map(corner).collect();
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let grid: Vec<f64> = (0..=40).map(|i| min * (max / min).powf(f64::from(i) / 40.0)).collect();
        let kept = |n: f64| corners.iter().all(|m| evaluate(&case.robot, &load, m, n).feasible);
        let Some(design) = result.designs.first() else {
            if result.nominal.candidates.is_empty() {
                continue;
            }
            lost += 1;
            // What cannot be judged is another matter: tests/program/proof/unjudged.rs.
            if count <= 512 && !matches!(result.lost[0].reason, Reason::Unjudged(_)) {
                assert!(!grid.iter().any(|n| kept(*n)), "case {seed}: a ratio will do: {:?}", result.lost[0].reason);
            }
            continue;
        };
        feasible += 1;
        // A ratio that was moved to where it can be judged is no proved one.
        let judged = design.optimum.windows.iter().all(|w| w.low.unjudged.is_none() && w.high.unjudged.is_none());
        assert!(!judged || matches!(design.optimum.certificate, Certificate::Certified { .. }), "case {seed}");
        let n = design.optimum.ratio;
        // Motors at corners, at random places of the box and of its faces.
        let mut generator = Pcg64::seed_from_u64(seed ^ 0xabcd);
        let mut within = |a: f64, b: f64| generator.random_range(a..b);
        let inside: Vec<Motor> =
            (0..150).map(|k| case.moved(|_| (within(-1.0, 1.0) * f64::from(1 + k % 4)).clamp(-1.0, 1.0))).collect();
        let mut worst = f64::NEG_INFINITY;
        for motor in corners.iter().chain(&inside) {
            let at = evaluate(&case.robot, &load, motor, n);
            let margin = at.tightest().map_or(1.0, |m| m.margin);
            assert!(margin > -1e-8, "case {seed}: {margin} of {:?} at N = {n}", at.tightest());
            worst = worst.max(at.copper_loss);
        }
        assert!(worst <= design.worst_objective * (1.0 + 1e-9), "case {seed}: {worst} {}", design.worst_objective);
        // Nothing better keeps the limits at all corners. (Where a window ends at what cannot be judged, that is another
        // matter: tests/program/proof/unjudged.rs.)
        if count <= 512 && judged {
            let nominal = case.motor(false);
            for n in grid.iter().filter(|n| kept(**n)) {
                let objective = evaluate(&case.robot, &load, &nominal, *n).copper_loss;
                assert!(objective >= design.optimum.objective * (1.0 - 1e-6), "case {seed}: better at {n}");
            }
            // A hair outside of the window some corner breaks the limit that is named.
            let window = design.optimum.window();
            for (bind, beyond) in [(&window.low, window.min * (1.0 - 1e-5)), (&window.high, window.max * (1.0 + 1e-5))]
            {
                if !bind.limit.starts_with("ratio_") {
                    let breaks = corners.iter().any(|m| {
                        let at = evaluate(&case.robot, &load, m, beyond);
                        at.margins.iter().any(|m| m.limit == bind.limit && m.margin < 0.0)
                    });
                    assert!(breaks, "case {seed}: nothing breaks {} at {beyond}", bind.limit);
                    ends += 1;
                }
            }
        }
        let nominal = design.nominal.optimum.window();
        let window = design.optimum.window();
        narrower += usize::from(window.min > nominal.min * 1.0001 || window.max < nominal.max * 0.9999);
        assert!(design.optimum.objective >= design.nominal.optimum.objective * (1.0 - 1e-6));
    }
    println!("{feasible} robust, {lost} lost to their tolerances, {narrower} windows narrower, {ends} ends tried");
    assert!(!are_all() || feasible >= 200 && lost >= 10 && narrower >= 100 && ends >= 150);
}

/// A joint that holds a torque at a fixed ratio.
fn holding(torque: f64, ratio: f64) -> Robot {
    let mut robot = common::robot(common::hold(torque, 0.0, 0.0), GearModel::IDEAL);
    robot.joints[0].ratio = RatioChoice::Continuous { min: ratio, max: ratio };
    robot
}

fn named(mut motor: Motor, id: &str) -> Motor {
    motor.id = id.into();
    motor
}

fn only(robot: &Robot, motors: Vec<Motor>, look: impl Fn(&RobustJoint)) {
    let catalog = Catalog::of(motors, Vec::new());
    look(&robust(robot, &catalog, Options::default()).unwrap()[0]);
}

/// Standard normal distribution, by its series.
fn phi(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for k in 1..200 {
        term *= -x * x / 2.0 / f64::from(k);
        sum += term / f64::from(2 * k + 1);
    }
    0.5 + sum / std::f64::consts::TAU.sqrt()
}

#[test]
fn how_likely_the_winner_stays_ahead_is_that_on_paper() {
    // Loss R T²/(K_T² N²) differs by R alone: 1 Ω ± 6 % against 1.04 Ω ± 8 %. Ahead where
    // ln 1.04 > z √(0.03² + 0.04²): Φ(0.7844) = 0.7836.
    let with = |r: f64, tolerance: f64| {
        motor(
            &[
                ("resistance", "ohm", r, tolerance),
                ("torque_constant", "N*m/A", 0.1, 0.0),
                ("rotor_inertia", "kg*m^2", 1e-5, 0.0),
            ],
            true,
            &[],
        )
    };
    let expected = phi(1.04_f64.ln() / 0.05);
    assert!((expected - 0.7836).abs() < 1e-3);
    only(&holding(2.0, 10.0), vec![named(with(1.0, 0.06), "a"), named(with(1.04, 0.0832), "b")], |joint| {
        let winner = &joint.contenders[0];
        assert_eq!(winner.motor.id, "a");
        assert_eq!((winner.feasible_nominal, winner.feasible_robust), (1.0, Some(1.0)));
        for share in [winner.first_nominal, winner.first_robust] {
            assert!((share - expected).abs() < 3.0 * standard_error(expected), "{share} {expected}");
        }
        assert_eq!(joint.contenders.iter().map(|c| c.first_nominal).sum::<f64>(), 1.0);
        assert!((joint.designs[0].worst_objective - joint.designs[0].optimum.objective * 1.06).abs() < 1e-12);
    });
    assert!((standard_error(0.5) - 0.5 / (SAMPLES as f64).sqrt()).abs() < 1e-15);
}

#[test]
fn how_likely_a_limit_is_kept_is_that_on_paper() {
    // 0.2 N·m at the motor, 0.1 N·m/A ± 4 %, at most 2.03 A: kept where ln(K/0.1) > −ln 1.015,
    // Φ(ln 1.015/0.02) = 0.7717. At worst 0.2/0.096 = 2.083 A: no robust design.
    let current = |limit: f64| {
        motor(
            &[
                ("resistance", "ohm", 1.0, 0.0),
                ("torque_constant", "N*m/A", 0.1, 0.004),
                ("rotor_inertia", "kg*m^2", 1e-5, 0.0),
                ("peak_current", "A", limit, 0.0),
            ],
            true,
            &[],
        )
    };
    let expected = phi(1.015_f64.ln() / 0.02);
    only(&holding(2.0, 10.0), vec![current(2.03)], |joint| {
        let share = joint.contenders[0].feasible_nominal;
        assert!((share - expected).abs() < 3.0 * standard_error(expected), "{share} {expected}");
        assert!(joint.designs.is_empty() && joint.contenders[0].feasible_robust.is_none());
        assert!(matches!(joint.lost[0].reason, Reason::Infeasible(_)), "{:?}", joint.lost[0].reason);
    });
    only(&holding(2.0, 10.0), vec![current(2.09)], |joint| assert_eq!(joint.designs.len(), 1));
    // With the ratio free, it grows until the weakest motor keeps to its current: N = 2/(0.096 · 2.03).
    let mut free = holding(2.0, 10.0);
    free.joints[0].ratio = RatioChoice::Continuous { min: 1.0, max: 100.0 };
    free.joints[0].objective = Objective::single(Quantity::ReflectedInertia);
    only(&free, vec![current(2.03)], |joint| {
        let design = &joint.designs[0];
        assert!((design.optimum.ratio - 2.0 / (0.096 * 2.03)).abs() < 1e-6, "{}", design.optimum.ratio);
        assert_eq!(design.optimum.window().low.limit, "peak_current");
        assert_eq!(design.corners, 2);
    });
}

#[test]
fn what_corners_do_not_prove_is_not_certified() {
    let numbers = [
        ("resistance", "ohm", 0.3, 0.03),
        ("torque_constant", "N*m/A", 0.08, 0.004),
        ("rotor_inertia", "kg*m^2", 3e-5, 0.0),
        ("thermal_resistance_winding_housing", "K/W", 1.0, 0.0),
        ("thermal_resistance_housing_ambient", "K/W", 2.0, 0.2),
        ("thermal_time_constant_winding", "s", 10.0, 0.0),
        ("thermal_time_constant_housing", "s", 500.0, 0.0),
    ];
    let case = draw(1);
    let mut robot = case.robot;
    robot.bus.voltage = 1e4;
    robot.joints[0].limits = Limits { winding_temperature: Some(2000.0), ..Limits::default() };
    let certified = |robot: &Robot, numbers: &[Number]| {
        let catalog = Catalog::of(vec![motor(numbers, true, &[("pole_pairs", "7")])], Vec::new());
        let joint = &robust(robot, &catalog, Options::default()).unwrap()[0];
        let design = joint.designs.first().unwrap_or_else(|| panic!("{:?}", joint.lost.first().map(|l| &l.reason)));
        matches!(design.optimum.certificate, Certificate::Certified { .. })
    };
    // K_T, R and the resistance to ambient are monotone for the temperature; a time constant is not.
    assert!(certified(&robot, &numbers));
    let mut slow = numbers;
    slow[5].3 = 1.0;
    assert!(!certified(&robot, &slow));
    robot.bus.regeneration = Regeneration::Limited(1e6);
    assert!(!certified(&robot, &numbers));
    // A tolerance that reaches zero makes no motor.
    let mut wide = numbers;
    wide[1].3 = 0.08;
    let catalog = Catalog::of(vec![motor(&wide, true, &[("pole_pairs", "7")])], Vec::new());
    robot.bus.regeneration = Regeneration::Allowed;
    let joint = &robust(&robot, &catalog, Options::default()).unwrap()[0];
    assert_eq!(
        joint.lost[0].reason,
        Reason::NotSolved(gearwise::design::program::Unsolved::ToleranceReachesZero("torque_constant"))
    );
}

#[test]
fn motors_without_tolerances_stay_nominal_and_threads_change_nothing() {
    let catalog = Catalog::builtin().unwrap();
    let robot = read(&common::repository("requirements/leg_prosthesis_walking.toml")).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let joints = robust(&robot, &catalog, Options::default()).unwrap();
            for joint in &joints {
                for design in joint.designs.iter().filter(|d| d.toleranced.is_empty()) {
                    assert_eq!(design.optimum.ratio, design.nominal.optimum.ratio);
                }
                assert_eq!(joint.designs.len() + joint.lost.len(), joint.nominal.candidates.len());
            }
            let text = report::robust::text(&robot, &joints, 200, &Taken::default());
            assert!(text.contains("no tolerances in the catalogue: nominal"));
            text + &report::robust::csv(&joints)
                + &report::json_text(&report::json::robust::json(&robot, &joints, &Taken::default()))
        })
    };
    assert_eq!(run(1), run(4));
    assert_eq!(optimize(&robot, &catalog).joints.len(), robot.joints.len());
}

#[test]
fn a_gear_of_the_catalogue_is_chosen_for_the_worst_motor() {
    let gears = Catalog::builtin().unwrap().gears;
    let motor = motor(
        &[
            ("resistance", "ohm", 0.3, 0.03),
            ("torque_constant", "N*m/A", 0.08, 0.008),
            ("rotor_inertia", "kg*m^2", 3e-5, 3e-6),
            ("peak_current", "A", 18.0, 0.0),
        ],
        true,
        &[],
    );
    let mut robot = common::robot(common::hold(9.0, 2.0, 5.0), GearModel::IDEAL);
    robot.bus.voltage = 36.0;
    robot.joints[0].ratio = RatioChoice::gears(vec!["planetary-*".into()], EfficiencyCovers::Load);
    let catalog = Catalog::of(vec![motor], gears);
    let joint = &robust(&robot, &catalog, Options::default()).unwrap()[0];
    let design = &joint.designs[0];
    let gear = catalog.gears.iter().find(|g| Some(g.id.as_str()) == design.gear).unwrap();
    let load = Load::new(&robot.joints[0].motion, None);
    for bits in 0..8 {
        let mut motor = catalog.motors[0].clone();
        let end = |place: usize| [0.9, 1.1][bits >> place & 1];
        motor.resistance *= end(0);
        (motor.torque_constant, motor.back_emf_constant) =
            (motor.torque_constant * end(1), motor.back_emf_constant * end(1));
        motor.rotor_inertia = motor.rotor_inertia.map(|j| j * end(2));
        let at = Prepared::new(
            Mount::new(&robot, &robot.joints[0], &load, &motor).with_gear(Some(gear)).candidate().unwrap(),
        )
        .at(gear.ratio);
        assert!(at.feasible && at.copper_loss <= design.worst_objective * (1.0 + 1e-9));
    }
    assert_eq!(design.corners, 8);
}
