//! A weakened field: on paper, and what must not be said of it. Random joints are in brute_force.rs.

use gearwise::actuator::Load;
use gearwise::actuator::metrics::metric;
use gearwise::catalog::convention::Commutation;
use gearwise::catalog::estimate::{Estimate, Estimated};
use gearwise::catalog::rewound::NoTurns;
use gearwise::catalog::{Catalog, Construction, Motor};
use gearwise::design::turns::can_be_asked;
use gearwise::design::{Mount, Prepared};
use gearwise::requirement::*;

use crate::common;

/// A motor without resistance to speak of: ψ = 10 mV·s in the q frame per electrical radian, L = 1 mH, one pole pair.
fn motor() -> Motor {
    let catalog = Catalog::builtin().unwrap();
    let mut motor = catalog.motor("t-motor-ri50").unwrap().clone();
    (motor.resistance, motor.inductance, motor.pole_pairs) = (1e-9, Some(1e-3), Some(1));
    (motor.torque_constant, motor.back_emf_constant) = (0.01, 0.01);
    (motor.coulomb_friction, motor.viscous_friction, motor.no_load_torque) = (None, None, None);
    (motor.peak_current, motor.peak_torque, motor.max_speed) = (Some(1e3), None, None);
    (motor.continuous_current, motor.continuous_torque) = (Some(1e3), None);
    motor.estimates.clear();
    motor
}

/// A joint at a speed and torque of a motor without gear, with a circle of 10 V and so much current against the magnets.
fn joint(torque: f64, speed: f64, amplitude: Option<f64>) -> Robot {
    let mut robot = common::robot(common::hold(torque, speed, 0.0), GearModel::IDEAL);
    robot.bus.voltage = 10.0 * 2.0_f64.sqrt();
    robot.joints[0].ratio = RatioChoice::Listed { values: vec![1.0], step: None, teeth: None };
    robot.bus.drive.field_weakening_current = amplitude;
    robot
}

fn look<T>(robot: &Robot, motor: &Motor, look: impl FnOnce(&Prepared) -> T) -> T {
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    look(&Prepared::new(Mount::new(robot, joint, &load, motor).candidate().unwrap()))
}

fn margin(prepared: &Prepared, limit: &str) -> Option<f64> {
    prepared.at(1.0).margins.iter().find(|m| m.limit == limit).map(|m| m.margin)
}

/// Soong and Miller's ψ = L I: with I_ch = ψ/L = 10 A as the current's limit, the largest torque at speed ω keeps the power at
/// V I_ch towards high speeds, whatever the speed. i_d and i_q are on the circles of current and voltage.
#[test]
fn with_the_characteristic_current_power_stays_to_any_speed() {
    let motor = motor();
    assert!((metric("characteristic_current").unwrap().value(&motor).unwrap() - 10.0).abs() < 1e-12);
    for speed in [3000.0_f64, 10_000.0, 100_000.0] {
        // On the voltage's circle (V/ω)² = (ψ + L x)² + (L i)², and x² + i² = I_ch²: x = (V/ω)²/(2ψL) − ψ/L.
        let (psi, l, v) = (0.01, 1e-3, 10.0);
        let x: f64 = (v / speed).powi(2) / (2.0 * psi * l) - psi / l;
        let i = (100.0 - x * x).sqrt();
        let robot = |torque: f64| {
            let mut robot = joint(torque, speed, Some(1e3));
            robot.bus.drive_current = Some(10.0 / 1.5_f64.sqrt());
            robot
        };
        look(&robot(0.01 * i * (1.0 - 1e-6)), &motor, |prepared| {
            let at = prepared.at(1.0);
            assert!(at.feasible, "{speed}: {:?}", at.margins);
            assert!((at.weakening.unwrap().largest + x).abs() < 1e-3, "{speed}: {:?} {x}", at.weakening);
            assert!((at.peak_current - 10.0).abs() < 1e-4 && margin(prepared, "peak_current").unwrap() < 1e-5);
        });
        look(&robot(0.01 * i * (1.0 + 1e-4)), &motor, |prepared| assert!(!prepared.at(1.0).feasible));
        // Towards high speed the power is V I_ch.
        let power = 0.01 * i * speed;
        assert!(power <= 100.0 && power > 80.0, "{speed}: {power}");
    }
}

/// Its copper counts in losses, heat and the rms current: 2 Ω and the i_d of a voltage that would be half as much again.
#[test]
fn its_current_counts_as_any_other() {
    let mut motor = motor();
    motor.resistance = 1e-3;
    let robot = joint(0.01, 1500.0, Some(50.0));
    let (weak, strong) = (look(&robot, &motor, |p| p.at(1.0)), look(&joint(0.01, 1500.0, None), &motor, |p| p.at(1.0)));
    let weakening = weak.weakening.unwrap();
    let x = weakening.largest;
    assert!(weak.feasible && !strong.feasible && strong.weakening.is_none() && x > 3.0 && x < 4.0, "{x}");
    assert!((weakening.rms - x).abs() < 1e-12 && weakening.share == 1.0);
    assert!((weakening.loss - 1e-3 * x * x).abs() < 1e-12);
    assert!((weak.copper_loss - strong.copper_loss - 1e-3 * x * x).abs() < 1e-12);
    assert!((weak.loss - strong.loss - 1e-3 * x * x).abs() < 1e-9);
    assert!((weak.rms_current.powi(2) - strong.rms_current.powi(2) - x * x).abs() < 1e-9);
    // Where the voltage is enough nothing flows.
    let slow = look(&joint(0.01, 500.0, Some(50.0)), &motor, |p| p.at(1.0));
    assert!(slow.feasible && slow.weakening.unwrap().largest == 0.0 && slow.weakening.unwrap().share == 0.0);
    // No more than is allowed, by the drive or by the magnets.
    assert!(!look(&joint(0.01, 1500.0, Some(0.9 * x / 1.5_f64.sqrt())), &motor, |p| p.at(1.0)).feasible);
    motor.demagnetization_current = Some(0.9 * x);
    assert!(!look(&robot, &motor, |p| p.at(1.0)).feasible);
    motor.demagnetization_current = Some(1.1 * x);
    assert!(look(&robot, &motor, |p| p.at(1.0)).feasible);
}

/// The objective is what the design is evaluated with, whatever it counts: the current against the magnets too.
#[test]
fn the_objective_has_the_current_against_the_magnets() {
    for objective in ["peak_current", "copper_loss", "loss", "energy", "peak_power"] {
        let quantity = Quantity::NAMES.iter().find(|(name, _)| *name == objective).unwrap().1;
        let mut motor = motor();
        motor.resistance = 1e-2;
        let points = [
            Point { torque: 0.3, velocity: 20.0, duration: Some(1.0), ..Point::default() },
            Point { torque: 0.05, velocity: 150.0, duration: Some(1.0), ..Point::default() },
        ];
        let mut robot = joint(0.01, 1500.0, Some(50.0));
        robot.joints[0].motion = Motion::from_points(&points).into();
        robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 40.0 };
        robot.joints[0].objective = Objective::single(quantity);
        let catalog = Catalog::of(vec![motor.clone()], Vec::new());
        let result = gearwise::design::optimize::optimize(&robot, &catalog);
        let design = result.joints[0].designs().next().unwrap();
        let own = design.evaluation.objective(&robot.joints[0].objective).unwrap();
        assert!((design.optimum.objective / own - 1.0).abs() < 1e-9, "{objective}: {} {own}", design.optimum.objective);
        // And no ratio of a scan is better.
        let best = look(&robot, &motor, |prepared| {
            let at = (0..=2000).map(|k| prepared.at_in_full(2.0 * 20.0_f64.powf(f64::from(k) / 2000.0)));
            let values = at.filter(|e| e.feasible).map(|e| e.objective(&robot.joints[0].objective).unwrap());
            values.fold(f64::INFINITY, f64::min)
        });
        assert!(own <= best * (1.0 + 1e-6), "{objective}: {own} {best}");
    }
}

/// What must not be said: that a field is weakened where nobody knows by how much a current would.
#[test]
fn no_field_is_weakened_on_a_guess() {
    let why = |change: &dyn Fn(&mut Motor, &mut Robot)| {
        let (mut motor, mut robot) = (motor(), joint(0.01, 1500.0, Some(50.0)));
        change(&mut motor, &mut robot);
        look(&robot, &motor, |prepared| {
            let at = prepared.at(1.0);
            let why = prepared.unchecked.iter().find(|(name, _)| *name == "field_weakening").map(|(_, why)| *why);
            (at.feasible, at.weakening.is_some(), why)
        })
    };
    assert_eq!(why(&|_, _| {}), (true, true, None));
    let unknown = |found: (bool, bool, Option<&str>), word: &str| {
        assert!(!found.0 && !found.1 && found.2.is_some_and(|why| why.contains(word)), "{found:?} {word}");
    };
    unknown(why(&|motor, _| motor.pole_pairs = None), "pole pairs");
    // Without an inductance the voltage is that of the speed alone, and still too much.
    unknown(why(&|motor, _| motor.inductance = None), "inductance");
    unknown(
        why(&|motor, _| {
            let construction = Construction::Housed;
            let of = Estimated::Inductance;
            motor.estimates.push(Estimate { of, value: 1e-3, middle: 5e-4, rows: 9, construction });
        }),
        "estimated",
    );
    unknown(why(&|_, robot| robot.bus.internal_resistance = Some(1e-6)), "supply");
    unknown(why(&|motor, _| motor.conventions.commutation = Commutation::Brushed), "brushed");
    // What the magnets bear is not known: it is said.
    let of_magnets =
        |speed: f64, motor: &Motor| look(&joint(0.01, speed, Some(50.0)), motor, |prepared| prepared.unchecked_at(1.0));
    let not_checked = of_magnets(1500.0, &motor());
    assert!(not_checked.iter().any(|(name, why)| *name == "demagnetisation" && why.contains("magnets")));
    let mut known = motor();
    known.demagnetization_current = Some(100.0);
    // Nor is it a question where no current goes against them.
    for checked in [of_magnets(1500.0, &known), of_magnets(100.0, &motor())] {
        assert!(checked.iter().all(|(name, _)| *name != "demagnetisation"), "{checked:?}");
    }
    let robot = joint(0.01, 1500.0, Some(50.0));
    assert_eq!(can_be_asked(&robot, &robot.joints[0], &motor()), Err(NoTurns::FieldWeakening));
}

/// At 1500 rad/s the motor puts √2 · 15 V between two phases: more than drives of 20 V bear, less than of 22 V.
#[test]
fn the_motor_s_own_voltage_is_a_limit_where_one_is_said() {
    let of = |most: Option<f64>| {
        let mut robot = joint(0.01, 1500.0, Some(50.0));
        robot.bus.max_voltage = most;
        look(&robot, &motor(), |prepared| (margin(prepared, "open_circuit_voltage"), prepared.at(1.0).feasible))
    };
    assert_eq!(of(None).0, None);
    let demand = 2.0_f64.sqrt() * 15.0;
    assert!((of(Some(22.0)).0.unwrap() - (1.0 - demand / 22.0)).abs() < 1e-12 && of(Some(22.0)).1);
    assert!(of(Some(20.0)).0.unwrap() < 0.0 && !of(Some(20.0)).1);
}

/// A motor of 2 Ω and 0.5 N·m/A braked at 1 N·m and 30 rad/s: 2 A of q current, 15 V of back-EMF, −30 + 8 = −22 W. A bus that
/// takes 4 W leaves 18 W to burn: 3 A along d. That costs 18 W of heat, keeps the limit, and is said.
#[test]
fn flux_braking_burns_what_the_bus_does_not_take() {
    let mut motor = motor();
    (motor.resistance, motor.torque_constant, motor.back_emf_constant) = (2.0, 0.5, 0.5);
    motor.max_winding_temperature = None;
    motor.inductance = Some(1e-3);
    let mut robot = joint(-1.0, 30.0, None);
    robot.bus.voltage = 60.0;
    robot.bus.regeneration = Regeneration::Limited(4.0);
    let at = |robot: &Robot, motor: &Motor| look(robot, motor, |prepared| prepared.at(1.0));
    let margin =
        |at: &gearwise::design::Evaluation| at.margins.iter().find(|m| m.limit == "regeneration").unwrap().margin;
    let plain = at(&robot, &motor);
    assert!(!plain.feasible && margin(&plain) < -1.0 && plain.weakening.is_none(), "{plain:?}");
    robot.bus.flux_braking = true;
    let burned = at(&robot, &motor);
    let weakening = burned.weakening.unwrap();
    assert!(burned.feasible && margin(&burned).abs() < 1e-9, "{burned:?}");
    assert!((weakening.largest - 3.0).abs() < 1e-9 && (weakening.loss - 18.0).abs() < 1e-6, "{weakening:?}");
    assert!((burned.copper_loss - plain.copper_loss - 18.0).abs() < 1e-6);
    assert!((burned.peak_current - 13.0_f64.sqrt()).abs() < 1e-9, "{}", burned.peak_current);
    // None at all may come back: 22 W are burned.
    robot.bus.regeneration = Regeneration::Limited(0.0);
    let none = at(&robot, &motor);
    assert!(none.feasible && (none.weakening.unwrap().loss - 22.0).abs() < 1e-6, "{none:?}");
    // Magnets that bear 2 A: the rest comes back, and that is too much.
    robot.bus.regeneration = Regeneration::Limited(4.0);
    motor.demagnetization_current = Some(2.0);
    let weak = at(&robot, &motor);
    assert!(!weak.feasible && (margin(&weak) + 10.0 / 4.0).abs() < 1e-6, "{weak:?}");
    // Where nobody knows what the current does, none flows, and that is said.
    let mut unknown = motor.clone();
    unknown.pole_pairs = None;
    let (feasible, said) = look(&robot, &unknown, |prepared| {
        (
            prepared.at(1.0).feasible,
            prepared.unchecked.iter().any(|(name, why)| *name == "flux_braking" && why.contains("pole pairs")),
        )
    });
    assert!(!feasible && said);
    assert_eq!(can_be_asked(&robot, &robot.joints[0], &motor), Err(NoTurns::FieldWeakening));
}

/// Without current along q and resistance the circle is ω (ψ + L x) = V, so that L dx/dt = −V ω̇/ω²: of a speed W sin Ωt the share of
/// V is largest where weakening begins, at ω₀ = V/ψ: Ω √(W² − ω₀²)/ω₀².
#[test]
fn the_rate_of_the_current_is_that_on_paper() {
    let mut motor = motor();
    motor.rotor_inertia = Some(1e-15);
    let at = |frequency: f64, course: fn(f64) -> Course, amplitude: f64| {
        let omega = std::f64::consts::TAU * frequency;
        let samples = 2000;
        let time: Vec<f64> = (0..samples).map(|k| f64::from(k) / (f64::from(samples) * frequency)).collect();
        let velocity = time.iter().map(|t| amplitude * (omega * t).sin()).collect();
        let given = Samples { torque: vec![0.0; time.len()], time, velocity: Some(velocity), ..Samples::default() };
        let mut robot = joint(0.0, 1500.0, Some(50.0));
        robot.joints[0].motion = Motion::from_samples(given, course(1.0 / frequency)).into();
        look(&robot, &motor, |prepared| {
            let said = prepared
                .judged(1.0)
                .assumed
                .iter()
                .any(|(name, what)| *name == "field_weakening" && what.contains("L di_d/dt"));
            (prepared.at(1.0).weakening.unwrap().rate.unwrap(), said)
        })
    };
    for course in [Course::Periodic, Course::Once] {
        for (frequency, is_said) in [(0.5, false), (1.0, false), (2.0, true), (10.0, true)] {
            let paper = std::f64::consts::TAU * frequency * (1500.0_f64.powi(2) - 1e6).sqrt() / 1e6;
            let (found, said) = at(frequency, course, 1500.0);
            assert!(found <= paper * (1.0 + 1e-6) && found > 0.98 * paper, "{frequency}: {found} {paper}");
            assert_eq!(said, is_said, "{frequency}: {found}");
        }
        // Slow enough for the voltage nothing flows, and nothing changes.
        assert_eq!(at(10.0, course, 900.0), (0.0, false));
    }
}

/// Operating points have no order: how fast the current changes between them is not known, and not said, however far apart they are.
#[test]
fn of_operating_points_no_rate_is_said() {
    for duration in [None, Some(1e-6)] {
        let point = |velocity| Point { torque: 0.01, velocity, duration, ..Point::default() };
        let mut robot = joint(0.01, 1500.0, Some(50.0));
        robot.joints[0].motion = Motion::from_points(&[point(1500.0), point(100.0), point(1200.0)]).into();
        look(&robot, &motor(), |prepared| {
            let weakening = prepared.at(1.0).weakening.unwrap();
            assert!(weakening.largest > 3.0 && weakening.rate.is_none(), "{weakening:?}");
            assert!(prepared.judged(1.0).assumed.iter().all(|(name, _)| *name != "field_weakening"));
        });
    }
}
