//! Identities that hold for every motor and motion: scaling laws, invariances, monotonicity, and the
//! agreement of sweep and ratio program.

use std::sync::Arc;

use gearwise::actuator::Actuator;
use gearwise::actuator::metrics::metric;
use gearwise::actuator::shaft::Flow;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::answer::Design;
use gearwise::design::{optimize, sweep};
use gearwise::requirement::{Course, Motion, Objective, Quantity, RatioChoice, Robot, Samples};
use proptest::prelude::*;

use crate::common::{gear, motor, robot};

/// The terms of the torque, written out, are the coefficients of the linear form with its powers of the ratio.
#[test]
fn torque_terms_have_the_powers_of_their_features() {
    let catalog = Catalog::builtin().unwrap();
    let gear = gear(0.8);
    for motor in &catalog.motors {
        let mut actuator = Actuator::new(motor, 1e-5, &gear);
        for folded in [false, true] {
            if folded {
                actuator = actuator.folded();
            }
            for flow in Flow::ALL {
                let features = std::array::from_fn(|f| 0.7 * f as f64 - 2.3);
                let terms = actuator.torque_terms(flow, &features);
                let polynomial = actuator.torque_form(flow).polynomial(&features);
                assert_eq!(terms, [polynomial[-1], polynomial[0], polynomial[1]], "{}", motor.id);
            }
        }
    }
}

/// A motor by its q-axis numbers.
#[derive(Debug, Clone, Copy)]
struct Numbers {
    resistance: f64,
    time_constant: f64,
    torque_constant: f64,
    back_emf_share: f64,
    inertia: f64,
    poles: u32,
    viscous: f64,
    peak_current: f64,
    continuous_current: f64,
}

impl Numbers {
    /// The motor with `turns` times the turns of wire in the same copper: K × a, R × a², L × a², I ÷ a.
    fn motor(&self, turns: f64) -> Motor {
        let k = self.torque_constant * turns;
        let cells = [
            ("resistance [ohm]", self.resistance * turns * turns),
            ("inductance [H]", self.resistance * self.time_constant * turns * turns),
            ("torque_constant [N*m/A]", k),
            ("back_emf_constant [V*s/rad]", k * self.back_emf_share),
            ("rotor_inertia [kg*m^2]", self.inertia),
            ("viscous_friction [N*m*s/rad]", self.viscous),
            ("peak_current [A]", self.peak_current / turns),
            ("continuous_current [A]", self.continuous_current / turns),
        ];
        let cells: Vec<(&str, String)> = cells.iter().map(|(name, value)| (*name, value.to_string())).collect();
        let poles = self.poles.to_string();
        let mut row: Vec<(&str, &str)> = cells.iter().map(|(n, c)| (*n, c.as_str())).collect();
        row.extend([("back_emf_convention", "q_axis"), ("pole_pairs", poles.as_str()), ("mass [kg]", "0.4")]);
        motor(&row)
    }
}

fn numbers() -> impl Strategy<Value = Numbers> {
    (0.05..2.0, 0.0..3e-3, 0.03..0.3, 0.9..1.0, -6.0..-4.0, 1_u32..20, 0.0..2e-4, 41.0..80.0, 3.0..20.0).prop_map(
        |(
            resistance,
            time_constant,
            torque_constant,
            back_emf_share,
            inertia,
            poles,
            viscous,
            peak_current,
            continuous_current,
        )| Numbers {
            resistance,
            time_constant,
            torque_constant,
            back_emf_share,
            inertia: 10.0_f64.powf(inertia),
            poles,
            viscous,
            peak_current,
            continuous_current,
        },
    )
}

/// A periodic motion of three harmonics with a given number of samples.
fn motion(amplitudes: [f64; 6], phases: [f64; 6], samples: usize, period: f64) -> Motion {
    let at = |k: usize| std::f64::consts::TAU * k as f64 / samples as f64;
    let sum = |k: usize, from: usize| {
        (0..3)
            .map(|h| amplitudes[from + h] / (h + 1) as f64 * ((h + 1) as f64 * at(k) + phases[from + h]).sin())
            .sum::<f64>()
    };
    let series = |from: usize| (0..samples).map(|k| sum(k, from)).collect::<Vec<_>>();
    let time = (0..samples).map(|k| period * k as f64 / samples as f64).collect();
    Motion::from_samples(
        Samples { time, torque: series(0), velocity: Some(series(3)), ..Samples::default() },
        Course::Periodic(period),
    )
}

fn motions() -> impl Strategy<Value = Motion> {
    (prop::array::uniform6(1.0..8.0), prop::array::uniform6(0.0..6.0), 16_usize..120, 0.3..2.0)
        .prop_map(|(amplitudes, phases, samples, period)| motion(amplitudes, phases, samples, period))
}

fn robots() -> impl Strategy<Value = Robot> {
    (motions(), 0.6..1.0, 20.0..80.0).prop_map(|(motion, efficiency, voltage)| {
        let mut robot = robot(motion, gear(efficiency));
        robot.bus.voltage = voltage;
        robot.joints[0].ratio = RatioChoice::Continuous { min: 1.0, max: 200.0 };
        robot
    })
}

/// What `optimize` says of one motor: its design, if there is one.
fn solve<T>(robot: &Robot, motor: &Motor, look: impl FnOnce(Option<&Design>) -> T) -> T {
    let catalog = Catalog::of(vec![motor.clone()], Vec::new());
    let result = optimize(robot, &catalog);
    look(result.joints[0].designs().next())
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * a.abs().max(b.abs())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rewinding_a_motor_changes_neither_choice_nor_loss(numbers in numbers(), robot in robots(), turns in 0.2..5.0) {
        let mut scaled = robot.clone();
        scaled.bus.voltage *= turns;
        let describe = |d: Option<&Design>| d.map(|d| (d.evaluation.ratio, d.evaluation.copper_loss, d.optimum.window().min, d.optimum.window().max));
        let (a, b) = (solve(&robot, &numbers.motor(1.0), describe), solve(&scaled, &numbers.motor(turns), describe));
        prop_assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            prop_assert!(close(a.0, b.0, 1e-6) && close(a.1, b.1, 1e-6) && close(a.2, b.2, 1e-6) && close(a.3, b.3, 1e-6), "{:?} {:?}", a, b);
        }
    }

    #[test]
    fn rewinding_leaves_responsiveness_and_scales_torque_specific_inertia(numbers in numbers(), turns in 0.2..5.0) {
        let value = |name: &str, motor: &Motor| metric(name).unwrap().value(motor).unwrap();
        let (a, b) = (numbers.motor(1.0), numbers.motor(turns));
        prop_assert!(close(value("s_m", &a), value("s_m", &b), 1e-12));
        prop_assert!(close(value("s_t", &a), value("s_t", &b) * turns * turns, 1e-12));
    }

    #[test]
    fn metrics_of_an_actuator_do_not_change_with_the_ratio(numbers in numbers(), ratio in 1.0..200.0) {
        // J_a/K_Ma² and J_a/K_Ta² of the geared motor are S_M and S_T of the motor.
        let motor = numbers.motor(1.0);
        let matched = gearwise::actuator::metrics::at_matched_inertia(&motor, ratio * ratio * motor.rotor_inertia.unwrap()).unwrap();
        let inertia = ratio * ratio * motor.rotor_inertia.unwrap();
        let value = |name: &str| metric(name).unwrap().value(&motor).unwrap();
        prop_assert!(close(matched.ratio, ratio, 1e-12));
        prop_assert!(close(inertia / matched.motor_constant.powi(2), value("s_m"), 1e-12));
        prop_assert!(close(inertia / matched.torque_constant.powi(2), value("s_t"), 1e-12));
    }

    #[test]
    fn a_wider_limit_never_makes_a_design_infeasible_or_worse(numbers in numbers(), robot in robots(), wider in 1.0..2.0) {
        let motor = numbers.motor(1.0);
        let loss = |d: Option<&Design>| d.map(|d| d.evaluation.copper_loss);
        let before = solve(&robot, &motor, loss);
        let more_voltage = { let mut r = robot.clone(); r.bus.voltage *= wider; r };
        let more_current = Numbers { peak_current: numbers.peak_current * wider, ..numbers }.motor(1.0);
        let more_heat = Numbers { continuous_current: numbers.continuous_current * wider, ..numbers }.motor(1.0);
        for after in [solve(&more_voltage, &motor, loss), solve(&robot, &more_current, loss), solve(&robot, &more_heat, loss)] {
            if let Some(before) = before {
                prop_assert!(after.is_some_and(|a| a <= before * (1.0 + 1e-9)));
            }
        }
    }

    #[test]
    fn sweep_and_program_agree_and_feasible_ratios_are_one_interval(numbers in numbers(), robot in robots()) {
        let motor = numbers.motor(1.0);
        let catalog = Catalog::of(vec![motor.clone()], Vec::new());
        let swept = sweep(&robot, &catalog, 101);
        let designs = &swept[0].designs;
        let feasible: Vec<usize> = (0..designs.len()).filter(|i| designs[*i].evaluation.feasible).collect();
        if let (Some(first), Some(last)) = (feasible.first(), feasible.last()) {
            prop_assert_eq!(feasible.len(), last - first + 1, "the feasible ratios are not one interval");
        }
        let found = solve(&robot, &motor, |d| d.map(|d| (d.optimum.window().min, d.optimum.window().max, d.evaluation.copper_loss, d.evaluation.feasible)));
        match found {
            None => prop_assert!(designs.iter().all(|d| !d.is_choice())),
            Some((min, max, loss, ok)) => {
                prop_assert!(ok);
                for design in designs {
                    let n = design.evaluation.ratio;
                    let inside = n >= min * (1.0 - 1e-9) && n <= max * (1.0 + 1e-9);
                    // What lies beyond the window exceeds a limit, or its heat cannot be judged.
                    prop_assert_eq!(design.is_choice(), inside, "N = {} in [{}, {}]", n, min, max);
                    if inside {
                        prop_assert!(design.evaluation.copper_loss >= loss * (1.0 - 1e-9));
                    }
                }
            }
        }
    }

    #[test]
    fn every_objective_beats_the_others_at_its_own(numbers in numbers(), robot in robots()) {
        let motor = numbers.motor(1.0);
        let at = |quantity| {
            let mut robot = robot.clone();
            robot.joints[0].objective = Objective::single(quantity);
            solve(&robot, &motor, |d| d.map(|d| (d.evaluation.copper_loss, d.evaluation.reflected_inertia, d.evaluation.peak_current)))
        };
        if let (Some(loss), Some(inertia), Some(current)) = (at(Quantity::CopperLoss), at(Quantity::ReflectedInertia), at(Quantity::PeakCurrent)) {
            prop_assert!(loss.0 <= inertia.0.min(current.0) * (1.0 + 1e-6));
            prop_assert!(inertia.1 <= loss.1.min(current.1) * (1.0 + 1e-6));
            prop_assert!(current.2 <= loss.2.min(inertia.2) * (1.0 + 1e-6));
        }
    }

    #[test]
    fn repeating_the_period_changes_nothing(numbers in numbers(), amplitudes in prop::array::uniform6(1.0..8.0), phases in prop::array::uniform6(0.0..6.0)) {
        let once = motion(amplitudes, phases, 40, 0.8);
        let twice = {
            let double = |v: &[f64]| {
                let given: Vec<f64> = once.given.iter().map(|k| v[*k]).collect();
                given.repeat(2)
            };
            let first: Vec<f64> = once.given.iter().map(|k| once.time[*k]).collect();
            let time = first.iter().copied().chain(first.iter().map(|t| t + 0.8)).collect();
            Motion::from_samples(
                Samples {
                    time,
                    torque: double(&once.torque),
                    velocity: Some(double(&once.velocity)),
                    ..Samples::default()
                },
                Course::Periodic(1.6),
            )
        };
        let motor = numbers.motor(1.0);
        let describe = |d: Option<&Design>| d.map(|d| (d.evaluation.ratio, d.evaluation.copper_loss));
        let robots = [once, twice].map(|m| { let mut r = robot(m, gear(0.9)); r.bus.voltage = 48.0; r });
        let (a, b) = (solve(&robots[0], &motor, describe), solve(&robots[1], &motor, describe));
        prop_assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            prop_assert!(close(a.0, b.0, 1e-7) && close(a.1, b.1, 1e-9), "{:?} {:?}", a, b);
        }
    }

    #[test]
    fn shadow_prices_are_what_finite_differences_say(numbers in numbers(), robot in robots(), objective in 0..3_usize) {
        let mut robot = robot;
        robot.bus.drive_current = Some(30.0);
        robot.joints[0].limits.reflected_inertia = Some(0.3 * 200.0 * 200.0 * numbers.inertia);
        robot.joints[0].objective = Objective::single([Quantity::CopperLoss, Quantity::PeakCurrent, Quantity::Energy][objective]);
        let motor = numbers.motor(1.0);
        let value = |robot: &Robot, motor: &Motor| solve(robot, motor, |d| d.map(|d| d.optimum.objective));
        let prices = solve(&robot, &motor, |d| d.map(|d| d.optimum.shadow_prices.clone())).unwrap_or_default();
        for price in prices {
            let step = 1e-5;
            let changed = |factor: f64| {
                let (mut robot, mut motor) = (robot.clone(), motor.clone());
                match price.limit {
                    "voltage" => robot.bus.voltage *= factor,
                    "peak_current" => {
                        robot.bus.drive_current = robot.bus.drive_current.map(|i| i * factor);
                        motor.peak_current = motor.peak_current.map(|i| i * factor);
                    }
                    "continuous_current" => motor.continuous_current = motor.continuous_current.map(|i| i * factor),
                    "reflected_inertia" => robot.joints[0].limits.reflected_inertia = robot.joints[0].limits.reflected_inertia.map(|j| j * factor),
                    "ratio_min" => robot.joints[0].ratio = RatioChoice::Continuous { min: factor, max: 200.0 },
                    "ratio_max" => robot.joints[0].ratio = RatioChoice::Continuous { min: 1.0, max: 200.0 * factor },
                    other => panic!("{other}"),
                }
                value(&robot, &motor)
            };
            // Two limits may bind at once: then the price holds to one side only.
            if let (Some(wider), Some(tighter), Some(here)) = (changed(1.0 + step), changed(1.0 - step), value(&robot, &motor)) {
                let (up, down) = ((wider - here) / (here * step), (here - tighter) / (here * step));
                let near = |difference: f64| (difference - price.elasticity).abs() <= 0.01 * price.elasticity.abs() + 1e-5;
                // Where nothing changes sides, the middle of both has no error of the curvature.
                prop_assert!(near(up) || near(down) || near(0.5 * (up + down)), "{:?}: {} {}", price, up, down);
            }
        }
    }

    #[test]
    fn with_coulomb_friction_no_ratio_of_a_fine_grid_is_better_than_the_certified_one(numbers in numbers(), robot in robots(), friction in 0.001..0.2) {
        let mut motor = numbers.motor(1.0);
        motor.coulomb_friction = Some(friction);
        let catalog = Catalog::of(vec![motor.clone()], Vec::new());
        let swept = sweep(&robot, &catalog, 400);
        let feasible: Vec<&gearwise::design::Evaluation> = swept[0].designs.iter().map(|d| &d.evaluation).filter(|e| e.feasible).collect();
        let found = solve(&robot, &motor, |d| d.map(|d| (d.evaluation.copper_loss, d.evaluation.feasible, d.optimum.certificate.clone())));
        match found {
            None => prop_assert!(feasible.is_empty()),
            Some((loss, ok, certificate)) => {
                prop_assert!(ok);
                let gearwise::design::program::Certificate::Certified { lower_bound, gap, .. } = certificate else {
                    return Err(TestCaseError::fail("not certified"));
                };
                prop_assert!(gap <= 1e-6 && lower_bound <= loss);
                for e in feasible {
                    prop_assert!(e.copper_loss >= lower_bound && e.copper_loss >= loss * (1.0 - 1e-6), "N = {} has {} W, N* {} W", e.ratio, e.copper_loss, loss);
                }
            }
        }
    }

    #[test]
    fn the_winding_over_the_motion_leaves_the_same_ratios_in_sweep_and_program(
        numbers in numbers(),
        robot in robots(),
        objective in 0..3_usize,
        thermal in (0.3..3.0, 0.5..4.0, 0.3..40.0, 100.0..900.0),
        rise in 20.0..120.0,
        once in any::<bool>(),
    ) {
        let mut robot = robot;
        let joint = &mut robot.joints[0];
        joint.objective = Objective::single([Quantity::CopperLoss, Quantity::Energy, Quantity::PeakPower][objective]);
        joint.limits.winding_temperature = Some(298.15 + rise);
        if once {
            let motion = Arc::make_mut(&mut joint.motion);
            motion.course = Course::Once(motion.duration().unwrap());
        }
        let mut motor = numbers.motor(1.0);
        let printed = |value| Some(gearwise::catalog::Printed { value, tolerance: None });
        motor.sheet.thermal_resistance_winding_housing = printed(thermal.0);
        motor.sheet.thermal_resistance_housing_ambient = printed(thermal.1);
        motor.sheet.thermal_time_constant_winding = printed(thermal.2);
        motor.sheet.thermal_time_constant_housing = printed(thermal.3);
        motor.thermal_resistance = Some(thermal.0 + thermal.1);
        let catalog = Catalog::of(vec![motor.clone()], Vec::new());
        let swept = sweep(&robot, &catalog, 61);
        let objective = robot.joints[0].objective.clone();
        let found = solve(&robot, &motor, |d| d.map(|d| (d.optimum.window().min, d.optimum.window().max, d.optimum.objective, d.evaluation.feasible)));
        let apart = solve(&robot, &motor, |d| d.is_some_and(|d| d.unchecked.iter().any(|(name, _)| *name == "drag_heat")));
        for design in &swept[0].designs {
            let e = &design.evaluation;
            prop_assert!(e.margins.iter().any(|m| m.limit == "winding_peak_temperature"));
            let inside = found.is_some_and(|(min, max, ..)| e.ratio >= min * (1.0 - 1e-8) && e.ratio <= max * (1.0 + 1e-8));
            // Where drag's heat comes on top it may be too hot: such a ratio is no choice, unless none is.
            let is_choice = e.feasible && (apart || design.unjudged.is_empty());
            prop_assert_eq!(is_choice, inside, "N = {} of {:?}", e.ratio, found);
            if let (true, Some((_, _, best, ok))) = (inside, found) {
                prop_assert!(ok, "the optimum breaks a limit");
                // Energy can be negative: what comes back counts.
                let here = e.objective(&objective).unwrap();
                prop_assert!(here >= best - 1e-6 * best.abs(), "N = {}: {} against {}", e.ratio, here, best);
            }
        }
    }
}
