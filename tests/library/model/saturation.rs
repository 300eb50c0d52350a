//! Saturation that a row's own peak torque shows: on paper, and where it must not be taken for it.

use approx::assert_relative_eq;
use gearwise::actuator::Load;
use gearwise::catalog::drag::Drag;
use gearwise::catalog::{Motor, PeakTorqueOf, Printed};
use gearwise::design::{Mount, Prepared};
use gearwise::effects::{EFFECTS, FittedEffect};
use gearwise::requirement::{GearModel, RatioChoice, Regeneration};

use crate::common;
use crate::raw;

/// K_T = 0.1 N·m/A and 60 A, where a published curve (mj5208) has 76 % of K_T I: 4.56 N·m.
fn motor(of: &str, torque: &str) -> Motor {
    common::motor(&[
        ("resistance [ohm]", "0.05"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [kg*m^2]", "1e-12"),
        ("peak_current [A]", "60"),
        ("peak_torque [N*m]", torque),
        ("peak_torque_of", of),
    ])
}

/// x of tanh x = 0.76 x by Newton from above.
fn argument(share: f64) -> f64 {
    let mut x: f64 = 1.0 / share;
    for _ in 0..50 {
        let slope = 1.0 / x.cosh().powi(2) - share;
        x -= (x.tanh() - share * x) / slope;
    }
    x
}

fn look<T>(motor: &Motor, torque: f64, look: impl FnOnce(&Prepared) -> T) -> T {
    let mut robot = common::robot(common::hold(torque, 1.0, 0.0), GearModel::IDEAL);
    robot.joints[0].ratio = RatioChoice::Listed { values: vec![1.0], step: None, teeth: None };
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    look(&Prepared::new(Mount::new(&robot, joint, &load, motor).candidate().unwrap()))
}

/// At the peak torque flows the peak current, at others i = i_s artanh(T/(K_T i_s)); heat is R i².
#[test]
fn the_curve_goes_through_the_one_point_of_the_row() {
    let motor = motor("motor", "4.56");
    let i_s = 60.0 / argument(0.76);
    assert_relative_eq!(motor.saturation_current().unwrap(), i_s, max_relative = 1e-12);
    for torque in [4.56_f64, 3.5, 2.0, 0.5] {
        let current = i_s * (torque / (0.1 * i_s)).atanh();
        look(&motor, torque, |prepared| {
            let at = prepared.at(1.0);
            assert_relative_eq!(at.peak_current, current, max_relative = 1e-9);
            assert_relative_eq!(at.copper_loss, 0.05 * current * current, max_relative = 1e-9);
            let said = prepared.judged(1.0).assumed.iter().any(|(_, what)| what.contains("tanh"));
            assert!(said && at.feasible == (torque < 4.57), "{torque}: {:?}", at.margins);
        });
    }
    assert_relative_eq!(i_s * (4.56 / (0.1 * i_s)).atanh(), 60.0, max_relative = 1e-12);
    look(&motor, 4.58, |prepared| assert!(!prepared.at(1.0).feasible));
    // Small torques know nothing of it: i = T/K_T (1 + (T/(K_T i_s))²/3).
    look(&motor, 0.1, |prepared| assert_relative_eq!(prepared.at(1.0).peak_current, 1.0, max_relative = 1e-3));
    // Other turns leave the share as it is.
    let wound = motor.rewound(0.5).unwrap();
    assert_relative_eq!(wound.saturation_current().unwrap(), 2.0 * i_s, max_relative = 1e-9);
}

/// Loss and ohmic drop take the true current at 4 N·m and 200 rad/s; regenerative power while braking takes T/K_T.
#[test]
fn voltage_and_power_have_the_true_current() {
    let motor = motor("motor", "4.56");
    let i_s = 60.0 / argument(0.76);
    let current = i_s * (4.0 / (0.1 * i_s)).atanh();
    let mut robot = common::robot(common::hold(4.0, 200.0, 0.0), GearModel::IDEAL);
    robot.joints[0].ratio = RatioChoice::Listed { values: vec![1.0], step: None, teeth: None };
    robot.bus.power = Some(1e4);
    robot.bus.regeneration = Regeneration::Limited(1e4);
    let at = |torque: f64| {
        let mut robot = robot.clone();
        robot.joints[0].motion = common::hold(torque, 200.0, 0.0).into();
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let at = Prepared::new(Mount::new(&robot, joint, &load, &motor).candidate().unwrap()).at(1.0);
        move |limit: &str| at.margins.iter().find(|m| m.limit == limit).unwrap().demand
    };
    let hot = 0.05 * raw::hottest_factor(&motor, None);
    let driving = at(4.0);
    assert_relative_eq!(driving("bus_power"), hot * current * current + 4.0 * 200.0, max_relative = 1e-9);
    assert_relative_eq!(driving("voltage"), hot * current + 0.1 * 200.0, max_relative = 1e-9);
    let braking = at(-4.0);
    let cold = 0.05 * raw::ambient_factor(&motor, robot.ambient);
    assert_relative_eq!(braking("regeneration"), 4.0 * 200.0 - cold * 40.0 * 40.0, max_relative = 1e-9);
}

/// A sheet that prints its peak torque at a deviation from linearity gives the point by itself: 4.56 N·m at 20 % are 57 A.
#[test]
fn the_printed_linearity_is_the_point() {
    let motor = common::motor(&[
        ("resistance [ohm]", "0.05"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [kg*m^2]", "1e-12"),
        ("peak_torque [N*m]", "4.56"),
        ("peak_torque_linearity [1]", "0.8"),
    ]);
    let i_s = 57.0 / argument(0.8);
    for torque in [4.55_f64, 2.0] {
        let current = i_s * (torque / (0.1 * i_s)).atanh();
        look(&motor, torque, |prepared| {
            assert_relative_eq!(prepared.at(1.0).peak_current, current, max_relative = 1e-9);
        });
    }
    look(&motor, 4.56 * 0.999_999, |prepared| {
        assert_relative_eq!(prepared.at(1.0).peak_current, 57.0, max_relative = 1e-4)
    });
    let catalog = gearwise::catalog::Catalog::builtin().unwrap();
    assert_eq!(catalog.motors.iter().filter(|m| m.saturation_current().is_some()).count(), 25);
}

/// A peak torque without a current or a linearity leaves an interval: said near that torque, and not decided where a drive's current is in it.
#[test]
fn a_peak_torque_without_its_current_is_an_interval() {
    let row = [
        ("resistance [ohm]", "0.05"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [kg*m^2]", "1e-12"),
        ("peak_torque [N*m]", "4.56"),
    ];
    let found = |cells: &[(&str, &str)], torque: f64, drive: Option<f64>| {
        let motor = common::motor(cells);
        let mut robot = common::robot(common::hold(torque, 1.0, 0.0), GearModel::IDEAL);
        robot.joints[0].ratio = RatioChoice::Listed { values: vec![1.0], step: None, teeth: None };
        // An amplitude; currents of the model are power-invariant q-axis currents.
        robot.joints[0].drive_current = drive.map(|current| current / 1.5_f64.sqrt());
        let joint = &robot.joints[0];
        let load = Load::new(&joint.motion, None);
        let prepared = Prepared::new(Mount::new(&robot, joint, &load, &motor).candidate().unwrap());
        let judged = prepared.judged(1.0);
        let names = |of: &[(&str, &str)]| of.iter().any(|(name, _)| *name == "torque_linearity");
        (names(&judged.assumed), names(&judged.unchecked))
    };
    // At 4 N·m: 40 A in a straight line, i_s artanh(T/(K_T i_s)) = 46.5 A of a curve through 57 A at 4.56 N·m.
    let i_s = 57.0 / argument(0.8);
    let bent = i_s * (4.0 / (0.1 * i_s)).atanh();
    assert_eq!(found(&row, 4.0, None), (true, false));
    assert_eq!(found(&row, 4.0, Some(bent * 1.001)), (true, false));
    assert_eq!(found(&row, 4.0, Some(bent * 0.999)), (false, true));
    // Exceeded in a straight line as well.
    assert_eq!(found(&row, 4.0, Some(39.0)), (true, false));
    // A third of the peak torque is linear to 2 %, and a row with either number needs no interval.
    assert_eq!(found(&row, 1.5, Some(15.1)), (false, false));
    for more in [("peak_torque_linearity [1]", "0.8"), ("peak_current [A]", "57")] {
        assert_eq!(found(&[&row[..], &[more]].concat(), 4.0, None), (false, false), "{more:?}");
    }
}

/// A peak torque of a module has the gear's loss in it, an empty cell says nothing, half a per cent is rounding, and what logs
/// say of the iron counts alone: no saturation there, and none under *assumed*.
#[test]
fn no_other_peak_torque_is_taken_for_saturation() {
    let straight = |motor: &Motor| {
        assert_eq!(motor.saturation_current(), None);
        look(motor, 3.5, |prepared| {
            let at = prepared.at(1.0);
            assert_relative_eq!(at.peak_current, 35.0, max_relative = 1e-12);
            assert!(prepared.judged(1.0).assumed.iter().all(|(_, what)| !what.contains("tanh")));
        });
    };
    straight(&motor("module", "4.56"));
    straight(&motor("", "4.56"));
    straight(&motor("motor", "5.98"));
    straight(&motor("motor", "6.1"));
    straight(&motor("motor", ""));
    assert!(motor("motor", "5.96").saturation_current().is_some());
    // A peak current that the row does not say itself is no point of its curve.
    let mut other = motor("motor", "4.56");
    other.sheet.peak_current = None;
    straight(&other);
    let mut fitted = motor("motor", "4.56");
    let effect = *EFFECTS.iter().find(|e| e.name() == "torque_constant_saturation").unwrap();
    fitted.effects.push(FittedEffect { effect, values: vec![0.1, 1e4] });
    assert_eq!(fitted.saturation_current(), None);
    look(&fitted, 3.5, |prepared| assert_relative_eq!(prepared.at(1.0).peak_current, 35.0, max_relative = 1e-4));
}

/// It leaves what is known of the drag as it is, and no shipped row says it.
#[test]
fn it_declares_no_friction() {
    let mut motor = motor("motor", "4.56");
    (motor.no_load_torque, motor.sheet.no_load_speed) = (Some(0.05), Some(Printed::exact(300.0)));
    assert_eq!(motor.drag(), Drag::NoLoad { torque: 0.05, speed: Some(300.0) });
    let catalog = gearwise::catalog::Catalog::builtin().unwrap();
    assert!(catalog.motors.iter().all(|m| m.about.peak_torque_of != Some(PeakTorqueOf::Motor)));
}
