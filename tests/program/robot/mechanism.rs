//! Inverse dynamics: identities of physics, numbers of an independent engine, and the readers of descriptions.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use approx::assert_relative_eq;
use gearwise::input::Source;
use gearwise::mechanism::dynamics::{
    State, Wrench, energy, inverse_dynamics, kinematics, mass_matrix, per_mass, point_mass, regressor,
};
use gearwise::mechanism::torques::{actuator_places, torque_per_mass, torques, torques_per_mass};
use gearwise::mechanism::{Mechanism, Payload, Place, trajectory};
use nalgebra::Vector3;

use crate::common::repository;

const MODELS: [&str; 3] =
    ["requirements/robots/ur5e.urdf", "tests/fixtures/robots/panda.urdf", "tests/fixtures/robots/mini_cheetah_leg.xml"];

fn models() -> impl Iterator<Item = Mechanism> {
    MODELS.iter().map(|path| Mechanism::read(&repository(path)).unwrap_or_else(|e| panic!("{e}")))
}

fn parse(text: &str) -> Mechanism {
    Mechanism::read_source(&Arc::new(Source::new("robot.xml", text))).unwrap_or_else(|e| panic!("{e}"))
}

fn table(text: &str) -> Arc<Source> {
    Arc::new(Source::new("trajectory.csv", text))
}

/// A state of n joints that no symmetry favours.
fn state(n: usize, seed: f64) -> [Vec<f64>; 3] {
    let column = |a: f64, size: f64| (0..n).map(|j| size * (a * (j as f64 + 1.3) + seed).sin()).collect();
    [column(1.1, 1.5), column(2.3, 3.0), column(0.7, 12.0)]
}

fn inverse(mechanism: &Mechanism, [q, v, a]: &[Vec<f64>; 3]) -> Vec<f64> {
    inverse_dynamics(mechanism, State { position: q, velocity: v, acceleration: a }, &[])
}

const PENDULUM: &str = r#"<robot name="pendulum"><link name="base"/><link name="bob"><inertial><origin xyz="0 0 -0.5"/>
<mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="hinge" type="revolute"><parent link="base"/><child link="bob"/><axis xyz="0 1 0"/></joint></robot>"#;

#[test]
fn a_pendulum_is_that_of_the_textbook() {
    // (m l² + I) q̈ + m g l sin q = 0.6 · 3 + 2 · 9.81 · 0.5 · sin 0.4
    let torque = inverse(&parse(PENDULUM), &[vec![0.4], vec![7.0], vec![3.0]]);
    assert_relative_eq!(torque[0], 0.6 * 3.0 + 9.81 * 0.4_f64.sin(), max_relative = 1e-14);
}

#[test]
fn joint_power_is_the_rate_of_energy() {
    for mechanism in models() {
        let n = mechanism.moving().len();
        for seed in [0.0, 1.0, 2.0, 3.0] {
            let [q, v, a] = state(n, seed);
            let power: f64 =
                inverse(&mechanism, &[q.clone(), v.clone(), a.clone()]).iter().zip(&v).map(|(t, v)| t * v).sum();
            let total = |h: f64| {
                let at: Vec<f64> = (0..n).map(|j| q[j] + h * v[j] + 0.5 * h * h * a[j]).collect();
                let speed: Vec<f64> = (0..n).map(|j| v[j] + h * a[j]).collect();
                let (kinetic, potential) = energy(&mechanism, &at, &speed);
                kinetic + potential
            };
            let h = 1e-4;
            let rate = (8.0 * (total(h) - total(-h)) - (total(2.0 * h) - total(-2.0 * h))) / (12.0 * h);
            assert_relative_eq!(power, rate, max_relative = 1e-7, epsilon = 1e-7);
        }
    }
}

#[test]
fn at_rest_the_torques_are_the_slope_of_the_potential() {
    for mechanism in models() {
        let n = mechanism.moving().len();
        let [q, ..] = state(n, 0.4);
        let zero = vec![0.0; n];
        let hold = inverse(&mechanism, &[q.clone(), zero.clone(), zero.clone()]);
        for j in 0..n {
            let height = |h: f64| {
                let mut at = q.clone();
                at[j] += h;
                energy(&mechanism, &at, &zero).1
            };
            let slope = (height(1e-5) - height(-1e-5)) / 2e-5;
            assert_relative_eq!(hold[j], slope, max_relative = 1e-7, epsilon = 1e-7);
        }
    }
}

#[test]
fn the_mass_matrix_is_symmetric_positive_definite_and_torques_are_linear_in_acceleration() {
    for mechanism in models() {
        let n = mechanism.moving().len();
        let [q, v, a] = state(n, 0.9);
        let matrix = mass_matrix(&mechanism, &q);
        assert!((&matrix - matrix.transpose()).amax() < 1e-13 * matrix.amax());
        assert!(matrix.clone().cholesky().is_some());
        let still = inverse(&mechanism, &[q.clone(), v.clone(), vec![0.0; n]]);
        let moved = inverse(&mechanism, &[q, v, a.clone()]);
        let inertial = matrix * nalgebra::DVector::from_vec(a);
        for j in 0..n {
            assert_relative_eq!(moved[j], still[j] + inertial[j], max_relative = 1e-11, epsilon = 1e-11);
        }
    }
}

#[test]
fn torques_agree_with_mujoco() {
    let text = fs::read_to_string(repository("tests/fixtures/robots/mujoco.json")).unwrap();
    let table: serde_json::Value = serde_json::from_str(&text).unwrap();
    let robots = table["robots"].as_array().unwrap();
    assert_eq!(robots.len(), 3);
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    for robot in robots {
        let mechanism = Mechanism::read(&repository(robot["model"].as_str().unwrap())).unwrap();
        let names: Vec<&str> = robot["joints"].as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
        let order: Vec<usize> = mechanism.joints().map(|j| names.iter().position(|n| *n == j.name).unwrap()).collect();
        let states = robot["states"].as_array().unwrap();
        assert_eq!(states.len(), 8);
        for row in states {
            let [q, v, a, theirs] = [0, 1, 2, 3].map(|i| {
                let given = numbers(&row[i]);
                order.iter().map(|j| given[*j]).collect::<Vec<f64>>()
            });
            let size = theirs.iter().fold(0.0_f64, |a, t| a.max(t.abs()));
            for (ours, theirs) in inverse(&mechanism, &[q, v, a]).iter().zip(&theirs) {
                assert!((ours - theirs).abs() <= 1e-11 * size, "{ours} {theirs}");
            }
        }
    }
}

#[test]
fn a_force_on_a_foot_does_its_work_at_the_joints() {
    let mechanism = Mechanism::read(&repository(MODELS[2])).unwrap();
    let foot = mechanism.body("foot").unwrap();
    let force = Vector3::new(12.0, -7.0, 80.0);
    let [q, v, a] = state(3, 0.2);
    let state = State { position: &q, velocity: &v, acceleration: &a };
    let free = inverse_dynamics(&mechanism, state, &[]);
    let pushed = inverse_dynamics(&mechanism, state, &[Wrench { body: foot, force, moment: Vector3::zeros() }]);
    let speed = gearwise::mechanism::dynamics::kinematics(&mechanism, state)[foot].velocity;
    let less: f64 = (0..3).map(|j| (free[j] - pushed[j]) * v[j]).sum();
    assert_relative_eq!(less, force.dot(&speed), max_relative = 1e-12);
}

/// Positions of a periodic motion of all joints of a mechanism.
fn sway(mechanism: &Mechanism) -> String {
    let mut text = String::from("time [s]");
    for joint in mechanism.joints() {
        text += &format!(",{} [{}]", joint.name, joint.position_unit());
    }
    for k in 0..=40 {
        text += &format!("\n{}", f64::from(k) * 0.025);
        for (j, _) in mechanism.joints().enumerate() {
            text += &format!(",{}", 0.3 * (TAU * f64::from(k % 40) / 40.0 + j as f64).sin());
        }
    }
    text + "\n"
}

#[test]
fn torque_per_mass_is_what_a_kilogram_more_costs() {
    for mechanism in models() {
        let motion = trajectory::read(&table(&sway(&mechanism)), &mechanism, true, None).unwrap();
        let places = actuator_places(&mechanism);
        let plain = torques(&mechanism, &motion, true);
        let pairs = torques_per_mass(&mechanism, &motion, &places);
        assert!(!pairs.is_empty());
        for (actuator, place) in places.iter().enumerate() {
            let Some(place) = place else { continue };
            let mut heavier = mechanism.clone();
            let name = heavier.bodies[place.body].name.clone().unwrap();
            assert!(heavier.carry(&Payload { link: name, mass: 1.7, at: place.at.into() }));
            let loaded = torques(&heavier, &motion, true);
            for carrying in 0..mechanism.moving().len() {
                let found = torque_per_mass(&mechanism, &motion, carrying, *place);
                let pair = pairs.iter().find(|p| p.carrying == carrying && p.actuator == actuator);
                assert_eq!(found.as_ref(), pair.map(|p| &p.coefficients));
                for k in 0..motion.len() {
                    let more = (loaded.torque[carrying][k] - plain.torque[carrying][k]) / 1.7;
                    let coefficient = found.as_ref().map_or(0.0, |c| c[k]);
                    assert!((more - coefficient).abs() < 1e-10, "{more} {coefficient}");
                }
            }
        }
    }
}

/// Torques are linear in the inertial parameters of the bodies: their sum is what inverse dynamics says, and that of one point
/// mass what a kilogram at it asks.
#[test]
fn the_regressor_sums_to_the_torques() {
    let slider = PENDULUM.replace("revolute", "prismatic");
    for mechanism in models().chain([parse(&slider)]) {
        let n = mechanism.moving().len();
        for seed in [0.2, 1.4] {
            let [q, v, a] = state(n, seed);
            let moving = kinematics(&mechanism, State { position: &q, velocity: &v, acceleration: &a });
            let mut sum = vec![0.0; n];
            for (number, body) in mechanism.bodies.iter().enumerate() {
                let (mass, c) = (body.inertia.mass, body.inertia.centre);
                let shifted = nalgebra::Matrix3::from_diagonal_element(c.norm_squared()) - c * c.transpose();
                let about = body.inertia.about_centre + mass * shifted;
                let parts = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|at| about[at]);
                let amounts: Vec<f64> = [mass, mass * c.x, mass * c.y, mass * c.z].into_iter().chain(parts).collect();
                for (joint, ten) in regressor(&mechanism, &moving, number) {
                    sum[joint] += ten.iter().zip(&amounts).map(|(t, a)| t * a).sum::<f64>();
                }
                let at = Vector3::new(0.1, -0.3, 0.2);
                let point = per_mass(&mechanism, &moving, Place { body: number, at });
                let amounts = point_mass(&at);
                for ((joint, ten), (same, torque)) in regressor(&mechanism, &moving, number).iter().zip(point) {
                    assert_eq!(*joint, same);
                    let of_ten: f64 = ten.iter().zip(&amounts).map(|(t, a)| t * a).sum();
                    assert_relative_eq!(of_ten, torque, max_relative = 1e-11, epsilon = 1e-11);
                }
            }
            for (sum, torque) in sum.iter().zip(inverse(&mechanism, &[q, v, a])) {
                assert_relative_eq!(*sum, torque, max_relative = 1e-11, epsilon = 1e-11);
            }
        }
    }
}

#[test]
fn a_wheel_may_gain_whole_turns() {
    let mechanism = parse(&PENDULUM.replace("revolute", "continuous"));
    let mut text = String::from("time [s],hinge [rad]\n");
    for k in 0..=20 {
        text += &format!("{},{}\n", f64::from(k) * 0.1, TAU * f64::from(k) / 20.0);
    }
    let motion = trajectory::read(&table(&text), &mechanism, true, None).unwrap();
    assert!(motion.velocity[0].iter().all(|v| (v - TAU / 2.0).abs() < 1e-9));
    assert!(motion.acceleration[0].iter().all(|a| a.abs() < 1e-9));
}

#[test]
fn friction_and_springs_of_a_joint_are_loads_and_the_rotor_is_not() {
    let text = r#"<mujoco><worldbody><body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="a" damping="0.5"
      frictionloss="2" stiffness="3" springref="90" armature="10"/></body></worldbody></mujoco>"#;
    let mechanism = parse(text);
    let mut rows = String::from("time [s],a [rad],a.velocity [rad/s],a.acceleration [rad/s^2]\n");
    for k in 0..5 {
        rows += &format!("{k},1,4,5\n");
    }
    let motion = trajectory::read(&table(&rows), &mechanism, false, None).unwrap();
    let all = torques(&mechanism, &motion, true);
    assert_relative_eq!(all.torque[0][2], 5.0 + 0.5 * 4.0 + 2.0 + 3.0 * (1.0 - FRAC_PI_2), max_relative = 1e-13);
    assert_relative_eq!(
        torques(&mechanism, &motion, false).torque[0][2],
        5.0 + 3.0 * (1.0 - FRAC_PI_2),
        max_relative = 1e-13
    );
    assert_eq!(all.motion(&motion, 0).torque_rate[2], 0.0);
}

fn gearwise(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .env_remove("COLUMNS")
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

#[test]
fn motion_files_say_the_same_as_the_description() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("robot.urdf", PENDULUM);
    write("sway.csv", &sway(&parse(PENDULUM)));
    let (code, _, errors) = gearwise(
        folder.path(),
        &["torques", "robot.urdf", "sway.csv", "--payload", "bob=1 kg@0,0,-500 mm", "--out", "out"],
    );
    assert_eq!(code, Some(0), "{errors}");
    let joint = "name = \"p\"\n[bus]\nvoltage = \"48 V\"\n[[joint]]\nname = \"hinge\"\nratio = { min = 3, max = 30 }\n";
    write("files.toml", &format!("{joint}motion = \"out/hinge.csv\"\n"));
    let payload = "[mechanism]\nmodel = \"robot.urdf\"\ntrajectory = \"sway.csv\"\npayload = { link = \"bob\", mass = \"1 kg\", at = [\"0 m\", \"0 m\", \"-0.5 m\"] }\n";
    write("model.toml", &format!("{joint}mechanism_joint = \"hinge\"\n{payload}"));
    let read =
        |name: &str| gearwise::requirement::read(&folder.path().join(name)).unwrap_or_else(|e| panic!("{}", e[0]));
    let (from_file, from_model) = (read("files.toml"), read("model.toml"));
    let (file, model) = (&from_file.joints[0].motion, &from_model.joints[0].motion);
    for (a, b) in
        [(&file.torque, &model.torque), (&file.velocity, &model.velocity), (&file.torque_rate, &model.torque_rate)]
    {
        for (a, b) in a.iter().zip(b) {
            assert_relative_eq!(*a, *b, max_relative = 1e-9, epsilon = 1e-9);
        }
    }
    assert!(from_model.driven.unwrap().carried.is_empty(), "the base carries the only actuator");
}

/// The report on a spoilt description or trajectory.
fn mistake(model: &str, rows: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("robot.xml"), model).unwrap();
    fs::write(folder.path().join("t.csv"), rows).unwrap();
    let (code, out, errors) = gearwise(folder.path(), &["torques", "robot.xml", "t.csv"]);
    assert_eq!(code, Some(2), "{out}{errors}");
    assert!(out.is_empty());
    errors
}

const ROWS: &str = "time [s],hinge [rad]\n0,0\n0.1,0.3\n0.2,-0.2\n0.3,0.1\n0.4,0\n";
const LEG: &str = r#"<mujoco>
  <worldbody>
    <body name="bob">
      <joint name="hinge" axis="0 1 0"/>
      <geom type="sphere" size="0.1"/>
    </body>
  </worldbody>
</mujoco>"#;

macro_rules! mistakes {
    ($($name:ident: $model:expr, $rows:expr;)*) => {$(
        #[test]
        fn $name() {
            insta::with_settings!({ snapshot_path => "../../snapshots/mechanism", prepend_module_to_snapshot => false, omit_expression => true }, {
                insta::assert_snapshot!(stringify!($name), mistake(&$model, &$rows));
            });
        }
    )*};
}

mistakes! {
    xml_not_closed: PENDULUM.replace("</robot>", ""), ROWS;
    xml_of_something_else: "<svg/>", ROWS;
    noise: (0..1_000_000u32).map(|i| char::from(33 + (i.wrapping_mul(2_654_435_761) >> 24) as u8 % 90)).collect::<String>(), ROWS;
    unknown_joint_in_trajectory: PENDULUM, ROWS.replace("hinge", "hing");
    joint_missing_in_trajectory: PENDULUM, "time [s]\n0\n0.1\n0.2\n0.3\n0.4\n";
    time_not_sorted: PENDULUM, ROWS.replace("0.2,", "0.05,");
    does_not_close: PENDULUM, ROWS.replace("0.4,0\n", "0.4,0.1\n");
    inertia_not_positive: PENDULUM.replace("ixx=\"0.1\"", "ixx=\"-0.1\""), ROWS;
    inertia_of_no_body: PENDULUM.replace("izz=\"0.1\"", "izz=\"0.5\""), ROWS;
    mass_negative: PENDULUM.replace("value=\"2\"", "value=\"-2\""), ROWS;
    link_unknown: PENDULUM.replace("<child link=\"bob\"", "<child link=\"bobb\""), ROWS;
    loop_of_links: PENDULUM.replace("</robot>", "<joint name=\"again\" type=\"fixed\"><parent link=\"base\"/><child link=\"bob\"/></joint></robot>"), ROWS;
    element_misspelt: PENDULUM.replace("inertial>", "intertial>"), ROWS;
    joint_type_unknown: PENDULUM.replace("\"revolute\"", "\"revolut\""), ROWS;
    joint_floating: PENDULUM.replace("\"revolute\"", "\"floating\""), ROWS;
    mimic: PENDULUM.replace("<axis", "<mimic joint=\"x\"/><axis"), ROWS;
    xacro: "<robot xmlns:xacro=\"x\"><xacro:arm/></robot>", ROWS;
    axis_zero: PENDULUM.replace("0 1 0", "0 0 0"), ROWS;
    number_with_comma: PENDULUM.replace("0 0 -0.5", "0, 0, -0.5"), ROWS;
    free_joint: LEG.replace("<joint name=\"hinge\" axis=\"0 1 0\"/>", "<freejoint/>"), ROWS;
    ball_joint: LEG.replace("axis=\"0 1 0\"", "type=\"ball\""), ROWS;
    equality: LEG.replace("</mujoco>", "<equality><weld body1=\"bob\"/></equality></mujoco>"), ROWS;
    tendon: LEG.replace("</mujoco>", "<tendon><fixed><joint joint=\"hinge\" coef=\"1\"/></fixed></tendon></mujoco>"), ROWS;
    mesh_mass: LEG.replace("type=\"sphere\"", "type=\"mesh\" mesh=\"m\""), ROWS;
    attribute_misspelt: LEG.replace("axis=", "axes="), ROWS;
    class_unknown: LEG.replace("axis=", "class=\"leg\" axis="), ROWS;
    included: LEG.replace("<worldbody>", "<include file=\"x.xml\"/><worldbody>"), ROWS;
}

#[test]
fn nesting_without_end_is_refused() {
    let text =
        format!("<mujoco><worldbody>{}{}</worldbody></mujoco>", "<body>".repeat(50_000), "</body>".repeat(50_000));
    let report = mistake(&text, ROWS);
    assert!(report.contains("at most 200"), "{}", &report[..report.len().min(300)]);
}

#[test]
fn the_shipped_arm_takes_its_torques_from_its_description() {
    let robot = gearwise::requirement::read(&repository("requirements/arm_from_its_description.toml")).unwrap();
    let driven = robot.driven.as_ref().unwrap();
    // The shoulder carries the actuators from the elbow on; the base turns about the vertical, so that they weigh nothing there.
    let shoulder: Vec<usize> = driven.carried.iter().filter(|c| c.carrying == 1).map(|c| c.actuator).collect();
    assert_eq!(shoulder, [2, 3, 4, 5]);
    // By hand: at the pick the upper arm leans 44 degrees back from level, and the elbow's actuator hangs at its end:
    // g 0.425 cos(-46 deg) = 2.896 N*m/kg, standing still.
    let elbow = driven.carried.iter().find(|c| c.carrying == 1 && c.actuator == 2).unwrap();
    assert_relative_eq!(elbow.coefficients[0].abs(), 9.81 * 0.425 * 46.0_f64.to_radians().cos(), max_relative = 1e-6);
}
