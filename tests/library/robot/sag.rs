//! A supply that sags under all joints together, on paper.

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::robot::{Choice, Options, Wanting, choose};
use gearwise::requirement::*;

use crate::common;

/// A motor without resistance or inertia to speak of: 0.1 V·s/rad.
fn motor() -> Motor {
    let catalog = Catalog::builtin().unwrap();
    let mut motor = catalog.motor("t-motor-ri50").unwrap().clone();
    (motor.resistance, motor.inductance, motor.rotor_inertia) = (1e-13, None, Some(1e-12));
    (motor.torque_constant, motor.back_emf_constant) = (0.1, 0.1);
    (motor.coulomb_friction, motor.viscous_friction, motor.no_load_torque) = (None, None, None);
    (motor.peak_current, motor.peak_torque, motor.max_speed) = (Some(1e4), None, None);
    (motor.continuous_current, motor.continuous_torque) = (Some(1e4), None);
    motor.estimates.clear();
    motor
}

/// So many actuators of one joint, at a point of speed alone and at one of 40 W, on 10 V.
fn robot(count: u32, resistance: f64) -> Robot {
    let points = [
        Point { torque: 0.0, velocity: 60.0, duration: Some(1.0), ..Point::default() },
        Point { torque: 4.0, velocity: 10.0, duration: Some(1.0), ..Point::default() },
    ];
    let mut robot = common::robot(Motion::from_points(&points), GearModel::IDEAL);
    robot.bus.voltage = 10.0;
    robot.bus.internal_resistance = Some(resistance);
    robot.joints[0].count = count;
    robot.joints[0].ratio = RatioChoice::Listed { values: vec![1.0], step: None, teeth: None };
    robot.joints[0].objective = Objective::single(Quantity::CopperLoss);
    robot
}

fn chosen<T>(robot: &Robot, look: impl FnOnce(&Choice) -> T) -> T {
    let catalog = Catalog::of(vec![motor()], Vec::new());
    look(&choose(robot, &catalog, Options { budgets: false, ..Options::default() }).unwrap())
}

/// The drive at 60 rad/s needs 6 V on the circle, 8.485 V of the bus, while the others draw their 40 W each: it is left
/// 10 − 8.485 − R P/8.485.
#[test]
fn a_drive_gets_what_the_others_leave() {
    let held = 6.0 * 2.0_f64.sqrt();
    for (count, resistance) in [(2, 0.01), (2, 0.2), (4, 0.05)] {
        let others = 40.0 * f64::from(count - 1);
        let left = 1.0 - (held + resistance * others / held) / 10.0;
        chosen(&robot(count, resistance), |choice| {
            let sag = choice.combinations[0].sag.unwrap();
            assert!((sag.left - left).abs() < 1e-9, "{count} {resistance}: {sag:?} {left}");
            // All of them at 40 W.
            let all = 40.0 * f64::from(count);
            let lowest = 5.0 + (25.0 - resistance * all).sqrt();
            assert!((sag.lowest.unwrap() - lowest).abs() < 1e-6 && choice.proof.certified(), "{sag:?} {lowest}");
        });
    }
    // 1.515 V · 8.485 V are 12.85 W per ohm: with 120 W of three others 0.107 Ω.
    let most = (10.0 - held) * held / 120.0;
    assert!(chosen(&robot(4, most * 0.999), |choice| !choice.combinations.is_empty()));
    chosen(&robot(4, most * 1.001), |choice| {
        assert!(choice.combinations.is_empty() && choice.proof.certified());
        assert_eq!(choice.wanting, [Wanting::Supply]);
    });
}

/// One actuator alone, and a supply without resistance, bind nothing together.
#[test]
fn what_binds_nothing_is_not_spoken_of() {
    assert!(!robot(1, 0.2).is_coupled() && !robot(3, 0.0).is_coupled() && robot(2, 0.2).is_coupled());
    for robot in [robot(1, 0.05), robot(2, 0.0)] {
        chosen(&robot, |choice| assert!(choice.combinations[0].sag.is_none()));
    }
}
