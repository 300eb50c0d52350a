//! Numbers that someone else published, or that follow on paper, against the model. Each names its
//! source; tolerances are the sources' own rounding.

use approx::assert_relative_eq;
use gearwise::actuator::metrics::{at_matched_inertia, metric};
use gearwise::actuator::step_response::simulate;
use gearwise::actuator::thermal;
use gearwise::catalog::Catalog;
use gearwise::catalog::convention::{BLOCK, Modulation};
use gearwise::design::optimize;
use gearwise::requirement::{Budget, GearModel, Motion, Objective, Point, Quantity, RatioChoice, backdrive_efficiency};

use crate::common::{self, demand, evaluate, gear, hold, motor, robot};

/// R 1 Ω, L 1 mH, k 0.1, J 1e-4, b 1e-5; 10 A, 10 K/W: course notes "10.5 Actuators & Drives" (github,
/// 04-robotics/actuators-drives.md).
const COURSE: &[(&str, &str)] = &[
    ("commutation", "brushed"),
    ("current", "dc"),
    ("resistance [ohm]", "1"),
    ("inductance [mH]", "1"),
    ("torque_constant [N*m/A]", "0.1"),
    ("rotor_inertia [kg*m^2]", "1e-4"),
    ("peak_current [A]", "10"),
    ("mass [kg]", "1"),
];

#[test]
fn static_hold_through_a_gearbox() {
    let motor = motor(COURSE);
    let load = 9.81 * 2.0;
    let robot = robot(hold(load, 0.0, 0.0), gear(0.8));
    let e = evaluate(&robot, &motor, 100.0);
    assert_relative_eq!(demand(&e, "peak_current"), 2.4525, max_relative = 1e-4);
    assert_relative_eq!(demand(&e, "voltage"), 2.4525, max_relative = 1e-4);
    // The notes count the gear's loss as heat of the hold: 6.0148 W. What stands loses nothing in the gear: η² of it.
    assert_relative_eq!(e.copper_loss, 6.0148 * 0.8 * 0.8, max_relative = 1e-3);
    let squared = demand(&e, "peak_current").powi(2);
    assert_relative_eq!(squared * 1.0 * 10.0, 60.1, max_relative = 2e-3);
    // r/(1 − α r) with r = 60.15 K and 0.00393 1/K at 20 °C, which is 0.003854 at 25 °C; with 0.0039 it would be 78.6 K.
    let hot = thermal::winding_temperature(squared, 1.0, 298.15, 10.0, 298.15).unwrap();
    assert_relative_eq!(hot - 298.15, 78.30, max_relative = 2e-4);
    // Without the rise of resistance 100 K allow √10 A; at N = 100 that holds 25.3 N·m.
    let continuous = (100.0_f64 / 10.0).sqrt();
    assert_relative_eq!(continuous, 3.162, max_relative = 1e-3);
    let at_continuous = evaluate(&common::robot(hold(25.3, 0.0, 0.0), gear(0.8)), &motor, 100.0);
    assert_relative_eq!(demand(&at_continuous, "peak_current"), continuous, max_relative = 2e-3);
    // The smallest ratio at which 19.62 N·m can be held.
    let smallest = evaluate(&robot, &motor, 77.6);
    assert_relative_eq!(demand(&smallest, "peak_current"), continuous, max_relative = 1e-3);
}

#[test]
fn inertia_matching_with_forward_efficiency() {
    // τ = J_load α through η 0.8: N* = √(J_load/(η J_m)) = 193.6; torque per acceleration 0.0387 there,
    // 0.0475 at N = 100, 0.0425 at N = 300 (same course notes, section 4).
    let motor = motor(COURSE);
    let mut robot = robot(hold(3.0, 1e-3, 1.0), gear(0.8));
    for (ratio, expected, tolerance) in [(193.6, 0.0387, 2e-3), (100.0, 0.0475, 1e-3), (300.0, 0.0425, 1e-3)] {
        let e = evaluate(&robot, &motor, ratio);
        assert_relative_eq!(demand(&e, "peak_current") * 0.1, expected, max_relative = tolerance);
    }
    robot.joints[0].objective = Objective::single(Quantity::PeakCurrent);
    let catalog = Catalog::of(vec![motor], Vec::new());
    let result = optimize(&robot, &catalog);
    let best = &result.joints[0].candidates[0];
    assert_relative_eq!(best.optimum.ratio, 193.649, max_relative = 1e-3);
    assert_relative_eq!(best.optimum.objective * 0.1, 0.0387298, max_relative = 1e-6);
}

#[test]
fn torque_speed_envelope_at_the_joint() {
    // η N k/R (V − k N ω) at N = 100, 24 V: 192 N·m at stall, slope 80, 2.4 rad/s without load; the
    // current limit of 10 A is 80 N·m, its corner at 140 rad/s of the motor (same notes, section 3).
    let motor = motor(COURSE);
    let voltage = |torque: f64, speed: f64| {
        let robot = robot(hold(torque, speed, 0.0), gear(0.8));
        demand(&evaluate(&robot, &motor, 100.0), "voltage")
    };
    assert_relative_eq!(voltage(192.0, 0.0), 24.0, max_relative = 1e-6);
    assert_relative_eq!(voltage(192.0 - 80.0 * 1.1, 1.1), 24.0, max_relative = 1e-6);
    assert_relative_eq!(voltage(0.0, 2.4), 24.0, max_relative = 1e-6);
    assert_relative_eq!(voltage(80.0, 1.4), 24.0, max_relative = 1e-6);
    let at_limit = evaluate(&robot(hold(80.0, 0.5, 0.0), gear(0.8)), &motor, 100.0);
    assert_relative_eq!(demand(&at_limit, "peak_current"), 10.0, max_relative = 1e-6);
}

#[test]
fn gear_efficiency_flips_with_the_direction_of_power() {
    // Two stages of 0.97, N = 50, 100 N·m: 2.125624 N·m raising, 1.874376 N·m lowering (tests of
    // github aneeshkaravadi/actuator-sizer, DERIVATIONS.md section 4).
    let motor = motor(COURSE);
    let efficiency = 0.97_f64.powi(2);
    assert_relative_eq!(backdrive_efficiency(efficiency), 0.937188, max_relative = 1e-6);
    assert!(backdrive_efficiency(0.5).abs() < 1e-12);
    let torque = |speed| {
        demand(&evaluate(&robot(hold(100.0, speed, 0.0), gear(efficiency)), &motor, 50.0), "peak_current") * 0.1
    };
    assert_relative_eq!(torque(0.1), 2.125624, max_relative = 1e-6);
    assert_relative_eq!(torque(-0.1), 1.874376, max_relative = 1e-6);
    // Shaft power is joint power and the gear's heat, both ways.
    for speed in [0.1, -0.1] {
        let shaft = torque(speed) * 50.0 * speed;
        let heat = (torque(speed) * 50.0 - 100.0) * speed;
        assert!(heat > 0.0);
        assert_relative_eq!(shaft, 100.0 * speed + heat, max_relative = 1e-12);
    }
}

#[test]
fn responsiveness_does_not_depend_on_the_transmission() {
    // N² J = S_M T²/P exactly: U8 with K_M 0.265, HT90M, HT60M (DC frame) at 20 N·m and 50 W.
    for (inertia, k_m, ratio, reflected) in [
        (1.2e-4, 0.265049, 10.67, 0.01367),
        (1.2e-4, 0.474087, 5.966, 0.0042713),
        (1.77e-5, 0.139291, 20.31, 0.0072982),
    ] {
        let motor = motor(&[
            ("resistance [ohm]", "1"),
            ("torque_constant [N*m/A]", &k_m.to_string()),
            ("rotor_inertia [kg*m^2]", &inertia.to_string()),
        ]);
        let s_m = metric("s_m").unwrap().value(&motor).unwrap();
        let n = 20.0 / (50.0_f64.sqrt() * k_m);
        assert_relative_eq!(n, ratio, max_relative = 2e-3);
        let e = evaluate(&robot(hold(20.0, 0.0, 0.0), GearModel::IDEAL), &motor, n);
        assert_relative_eq!(e.copper_loss, 50.0, max_relative = 1e-9);
        assert_relative_eq!(e.reflected_inertia, reflected, max_relative = 1e-3);
        assert_relative_eq!(e.reflected_inertia, s_m * 20.0_f64.powi(2) / e.copper_loss, max_relative = 1e-9);
    }
}

#[test]
fn reflected_inertia_of_an_arm() {
    // KUKA iiwa 14, RobotLocomotion/models iiwa_description/README.md.
    for (rotor, ratio, expected) in
        [("1.321e-4", 160.0, 3.38176), ("1.321e-4", 100.0, 1.321), ("4.54e-5", 160.0, 1.16224)]
    {
        let motor =
            motor(&[("resistance [ohm]", "1"), ("torque_constant [N*m/A]", "0.1"), ("rotor_inertia [kg*m^2]", rotor)]);
        let e = evaluate(&robot(hold(1.0, 0.0, 0.0), GearModel::IDEAL), &motor, ratio);
        assert_relative_eq!(e.reflected_inertia, expected, max_relative = 1e-6);
    }
}

#[test]
fn mini_cheetah_actuator() {
    // Katz, MSc thesis 2018, and his firmware: 6:1, 0.075 N·m per ampere of phase amplitude, 40 A: 18 N·m
    // with a straight torque constant; p λ = 0.05 and sine PWM at 24 V: 40 rad/s at the output.
    let catalog = Catalog::builtin().unwrap();
    let motor = catalog.motor("mit-mini-cheetah").unwrap();
    assert_relative_eq!(6.0 * motor.torque_constant * motor.peak_current.unwrap(), 18.0, max_relative = 1e-6);
    assert_relative_eq!(motor.rotor_inertia.unwrap() * 36.0, 0.0023, max_relative = 0.02);
    let mut robot = robot(hold(0.0, 40.0, 0.0), GearModel::IDEAL);
    robot.bus.voltage = 24.0;
    robot.bus.modulation = Modulation::Sine;
    let sine = evaluate(&robot, motor, 6.0);
    assert_relative_eq!(sine.margins.iter().find(|m| m.limit == "voltage").unwrap().margin, 0.0, epsilon = 1e-3);
    robot.bus.modulation = Modulation::SpaceVector;
    let space_vector = evaluate(&robot, motor, 6.0);
    let margin = space_vector.margins.iter().find(|m| m.limit == "voltage").unwrap();
    assert_relative_eq!(40.0 / (1.0 - margin.margin), 46.2, max_relative = 2e-3);
}

#[test]
fn continuous_current_of_motors_with_known_thermal_resistances() {
    // Lab-identified two-node parameters, github ihmcrobotics/ihmc-common-hardware: 125 °C in 25 °C, P = R I².
    for (r, reference, housing, ambient, expected) in [
        (0.07, 21.993, 0.507863, 0.418284, 33.14),
        (0.16, 22.492, 0.26492, 0.91028, 19.47),
        (0.2895, 28.596, 1.018737, 1.19668, 10.63),
        (0.3254982, 30.465, 0.364306, 1.53477, 10.86),
    ] {
        let squared = thermal::allowed_current_squared(398.15, r, reference + 273.15, housing + ambient, 298.15);
        // Theirs takes 0.00393 for the coefficient at each motor's own reference; it is that of 20 °C.
        let hot = |coefficient: f64| 1.0 + coefficient * (125.0 - reference);
        let own = 0.003_93 / (1.0 + 0.003_93 * (reference - 20.0));
        let squared = squared * hot(own) / hot(0.003_93);
        assert_relative_eq!(squared.sqrt(), expected, max_relative = 2e-3);
    }
}

#[test]
fn frameless_motors_in_their_own_frame() {
    // maxon EC frameless HT: K_M = k_M/√R_ll, S_M in the DC frame; on the q axis S_M is 9/π² of … π²/9 lower.
    let catalog = Catalog::builtin().unwrap();
    let frames = std::f64::consts::PI.powi(2) / 9.0;
    for (id, k_m, s_m, s_t) in [
        ("maxon-ec-frameless-ht-60-m-936176", 0.13929, 0.00091228, 0.00184298),
        ("maxon-ec-frameless-ht-76-m-934928", 0.26311, 0.00066592, 0.00309729),
        ("maxon-ec-frameless-ht-90-m-937612", 0.47409, 0.00053391, 0.00358327),
    ] {
        let motor = catalog.motor(id).unwrap();
        let value = |name: &str| metric(name).unwrap().value(motor).unwrap();
        assert_relative_eq!(value("s_m") * frames, s_m, max_relative = 1e-4);
        assert_relative_eq!(value("k_m") / frames.sqrt(), k_m, max_relative = 1e-4);
        assert_relative_eq!(value("s_t") * BLOCK.powi(2), s_t, max_relative = 1e-4);
    }
}

#[test]
fn the_case_study_of_the_paper() {
    // Urs et al., arXiv 2202.12365, table I and section V.
    let catalog = Catalog::builtin().unwrap();
    let (ri50, u8) = (catalog.motor("t-motor-ri50").unwrap(), catalog.motor("t-motor-u8").unwrap());
    let value = |name: &str, motor| metric(name).unwrap().value(motor).unwrap();
    assert_relative_eq!(value("k_m", ri50), 0.118, max_relative = 5e-3);
    assert_relative_eq!(value("s_t", ri50), 0.82e-3, max_relative = 5e-3);
    assert_relative_eq!(value("s_t", u8), 6.1e-3, max_relative = 5e-3);
    // The table prints S_M 0.67 ms; its own numbers give 0.644. The U8's K_M follows as 0.265, not 0.23.
    assert_relative_eq!(value("s_m", ri50), 0.644e-3, max_relative = 1e-3);
    assert_relative_eq!(value("k_m", u8), 0.26505, max_relative = 1e-4);
    assert_relative_eq!(value("s_m", u8), 1.7082e-3, max_relative = 1e-3);
    assert_relative_eq!(
        value("k_t_per_mass", ri50) / value("k_t_per_mass", u8),
        (0.105 / 0.193) / (0.14 / 0.242),
        max_relative = 1e-9
    );
    assert_relative_eq!(value("electrical_time_constant", ri50), 3.63e-3, max_relative = 1e-3);
    // At the U8's inertia the RI50 has √(S_T) and √(S_M) more torque per ampere and per root of heat.
    let a = at_matched_inertia(ri50, 1.2e-4).unwrap();
    let b = at_matched_inertia(u8, 1.2e-4).unwrap();
    assert_relative_eq!(b.ratio, 1.0, max_relative = 1e-12);
    assert_relative_eq!(a.torque_constant, (1.2e-4 / value("s_t", ri50)).sqrt(), max_relative = 1e-12);
    assert_relative_eq!(a.motor_constant, (1.2e-4 / value("s_m", ri50)).sqrt(), max_relative = 1e-12);
    assert!(a.torque_constant > 2.7 * b.torque_constant && a.motor_constant > 1.6 * b.motor_constant);
}

#[test]
fn speed_follows_a_voltage_step_with_s_m_unless_inductance_interferes() {
    let catalog = Catalog::builtin().unwrap();
    let ri50 = catalog.motor("t-motor-ri50").unwrap();
    let s_m = metric("s_m").unwrap().value(ri50).unwrap();
    let without = simulate(ri50, 0.0).unwrap();
    assert_relative_eq!(without.rise_time, s_m, max_relative = 1e-5);
    assert!(without.overshoot < 1e-4);
    // On paper: ζ = ½ √(S_M/(L/R)), overshoot exp(−π ζ/√(1 − ζ²)) = 51 %.
    let with = simulate(ri50, ri50.inductance.unwrap()).unwrap();
    let zeta = 0.5 * (s_m / (2.559e-3 / 0.705)).sqrt();
    assert_relative_eq!(
        with.overshoot,
        (-std::f64::consts::PI * zeta / (1.0 - zeta * zeta).sqrt()).exp(),
        max_relative = 1e-4
    );
    assert_relative_eq!(with.rise_time, 2.0e-3, max_relative = 0.02);
}

#[test]
fn power_balances_over_a_cycle() {
    // Electrical power is copper loss, mechanical power into the load, gear heat and motor friction.
    let motor = motor(&[
        ("resistance [ohm]", "0.3"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [g*cm^2]", "500"),
        ("viscous_friction [N*m*s/rad]", "1e-4"),
        ("coulomb_friction [N*m]", "0.02"),
    ]);
    let points = [(8.0, 3.0, 0.3), (-5.0, 6.0, 0.2), (2.0, -4.0, 0.4), (-3.0, -2.0, 0.1)];
    let motion: Vec<Point> = points
        .iter()
        .map(|(torque, velocity, duration)| Point {
            torque: *torque,
            velocity: *velocity,
            duration: Some(*duration),
            ..Point::default()
        })
        .collect();
    let (efficiency, ratio) = (0.85, 12.0);
    let robot = robot(Motion::from_points(&motion), gear(efficiency));
    let e = evaluate(&robot, &motor, ratio);
    let mut mechanical = 0.0;
    for (torque, velocity, duration) in points {
        let power: f64 = torque * velocity;
        let factor = if power >= 0.0 { 1.0 / efficiency } else { 2.0 - 1.0 / efficiency };
        let speed: f64 = velocity * ratio;
        mechanical += duration * (factor * power + 1e-4 * speed * speed + 0.02 * speed.abs());
    }
    assert_relative_eq!(e.mean_power, e.copper_loss + mechanical, max_relative = 1e-12);
}

#[test]
fn a_budget_is_checked_against_the_first_choices() {
    let catalog = Catalog::of(vec![motor(COURSE)], Vec::new());
    let mut robot = robot(hold(1.0, 1.0, 0.0), GearModel::IDEAL);
    robot.joints[0].ratio = RatioChoice::Continuous { min: 1.0, max: 50.0 };
    robot.joints[0].count = 3;
    robot.budget = Budget { actuator_mass: Some(3.1), max_distinct_motors: Some(1), ..Budget::default() };
    assert!(optimize(&robot, &catalog).satisfied());
    robot.budget.actuator_mass = Some(2.9);
    assert!(!optimize(&robot, &catalog).satisfied());
}
