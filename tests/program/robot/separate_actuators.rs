//! Actuators that the robot's description leaves out (`actuators = "separate"`) load the joints that carry them:
//! a planar arm whose best pair of motors is found by hand, and what a requirement may and may not say.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use gearwise::catalog::Catalog;
use gearwise::design::robot::{Options, choose};
use gearwise::requirement::{self, Robot};

const SAMPLES: usize = 40;
const PERIOD: f64 = 1.2;
/// Length of the upper arm, and where the masses of both links are \[m\].
const REACH: [f64; 3] = [0.4, 0.25, 0.3];
/// Masses of both links \[kg\].
const MASSES: [f64; 2] = [1.5, 0.8];
const GRAVITY: f64 = 9.81;
const EFFICIENCY: f64 = 0.9;
const GEAR_INERTIA: f64 = 2e-6;
const GEAR_MASS: f64 = 0.1;
const RATIOS: [f64; 2] = [3.0, 60.0];
/// Resistance, torque constant, rotor inertia, mass.
const MOTORS: [[f64; 4]; 4] =
    [[0.9, 0.05, 6e-6, 0.12], [0.45, 0.06, 2e-5, 0.27], [0.3, 0.08, 4e-5, 0.42], [0.15, 0.11, 1.6e-4, 0.95]];

/// Angle, speed and acceleration of a joint.
fn course(joint: usize, t: f64) -> [f64; 3] {
    let (size, w, late) = ([0.7, 0.9][joint], TAU / PERIOD, [0.3, 1.4][joint]);
    let (s, c) = (w * t + late).sin_cos();
    [size * s - 0.2, size * w * c, -size * w * w * s]
}

/// Torques of shoulder and elbow by hand, and what a kilogram at the elbow adds to the shoulder's. The arm lies
/// along x at zero and turns about y, so that a positive angle lowers it.
fn by_hand(t: f64) -> [f64; 3] {
    let ([q1, v1, a1], [q2, v2, a2]) = (course(0, t), course(1, t));
    let (p, w, a) = (q1 + q2, v1 + v2, a1 + a2);
    let ([l, c1, c2], [m1, m2]) = (REACH, MASSES);
    let (cos, sin) = ((q1 - p).cos(), (q1 - p).sin());
    let upper = (m1 * c1 * c1 + m2 * l * l) * a1 + m2 * l * c2 * (cos * a + sin * w * w)
        - GRAVITY * (m1 * c1 + m2 * l) * q1.cos();
    let fore = m2 * c2 * c2 * a + m2 * l * c2 * (cos * a1 - sin * v1 * v1) - GRAVITY * m2 * c2 * p.cos();
    [upper + fore, fore, l * l * a1 - GRAVITY * l * q1.cos()]
}

/// The least loss of a motor at a joint over its ratios, the elbow's actuator weighing so much.
fn least_loss(joint: usize, [resistance, constant, inertia, _]: [f64; 4], carried: f64) -> f64 {
    let loss = |n: f64| {
        let one = |k: usize| {
            let t = PERIOD * k as f64 / SAMPLES as f64;
            let [shoulder, elbow, per_mass] = by_hand(t);
            let torque = if joint == 0 { shoulder + carried * per_mass } else { elbow };
            let [_, speed, acceleration] = course(joint, t);
            let flow = if torque * speed < 0.0 { 2.0 - 1.0 / EFFICIENCY } else { 1.0 / EFFICIENCY };
            let motor = flow * torque / n + n * (inertia + GEAR_INERTIA) * acceleration;
            resistance * (motor / constant).powi(2)
        };
        (0..SAMPLES).map(one).sum::<f64>() / SAMPLES as f64
    };
    let at = |i: usize| RATIOS[0] * (RATIOS[1] / RATIOS[0]).powf(i as f64 / 40_000.0);
    (0..=40_000).map(|i| loss(at(i))).fold(f64::INFINITY, f64::min)
}

fn urdf() -> String {
    let link = |name: &str, mass: f64, at: f64| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"{at} 0 0\"/><mass value=\"{mass}\"/>\
             <inertia ixx=\"1e-10\" ixy=\"0\" ixz=\"0\" iyy=\"1e-10\" iyz=\"0\" izz=\"1e-10\"/></inertial></link>\n"
        )
    };
    let joint = |name: &str, parent: &str, child: &str, at: f64| {
        format!(
            "<joint name=\"{name}\" type=\"continuous\"><origin xyz=\"{at} 0 0\"/><parent link=\"{parent}\"/>\
             <child link=\"{child}\"/><axis xyz=\"0 1 0\"/></joint>\n"
        )
    };
    let other = link("other", 1.0, 0.2) + &joint("other_joint", "base", "other", 0.1);
    format!(
        "<robot name=\"planar\"><link name=\"base\"/>\n{}{}{}{}{other}</robot>\n",
        link("upper", MASSES[0], REACH[1]),
        link("fore", MASSES[1], REACH[2]),
        joint("shoulder_joint", "base", "upper", 0.0),
        joint("elbow_joint", "upper", "fore", REACH[0]),
    )
}

fn trajectory() -> String {
    let names = ["shoulder_joint", "elbow_joint"];
    let heads = names.map(|n| format!("{n} [rad],{n}.velocity [rad/s],{n}.acceleration [rad/s^2]"));
    let mut text = format!("time [s],{},other_joint [rad]\n", heads.join(","));
    for k in 0..=SAMPLES {
        let t = PERIOD * k as f64 / SAMPLES as f64;
        let values = [course(0, t), course(1, t)].concat().iter().map(|v| format!("{v:e}")).collect::<Vec<_>>();
        text.push_str(&format!("{t:e},{},{:e}\n", values.join(","), 0.1 * (TAU * t / PERIOD).sin()));
    }
    text
}

/// A folder with the arm; `mechanism`, `shoulder` and `elbow` are further lines of those tables.
fn arm(budget: &str, mechanism: &str, shoulder: &str, elbow: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("arm.urdf", &urdf());
    write("move.csv", &trajectory());
    let joint = |name: &str, more: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nratio = {{ min = {}, max = {} }}\ngear = {{ efficiency = {EFFICIENCY}, \
             mass = \"{GEAR_MASS} kg\", inertia = \"{GEAR_INERTIA} kg*m^2\" }}\nmechanism_joint = \"{name}_joint\"\nmotor_drag = \"off\"\nobjective = \"copper_loss\"\n{more}\n",
            RATIOS[0], RATIOS[1]
        )
    };
    let text = format!(
        "name = \"planar\"\n[bus]\nvoltage = \"400 V\"\n{budget}\n[mechanism]\nmodel = \"arm.urdf\"\n\
         trajectory = \"move.csv\"\n{mechanism}\n{}{}",
        joint("shoulder", shoulder),
        joint("elbow", elbow)
    );
    write("arm.toml", &text);
    let row = |(i, [r, k, j, m]): (usize, &[f64; 4])| {
        format!("m{i},q_axis,q_axis,{r},{k},{},{},500,1e6,100,test,derived\n", j * 1e7, m * 1e3)
    };
    let header = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],peak_current [A],continuous_torque [N*m],reference_temperature [degC],source,source_kind\n";
    write("motors.csv", &(header.to_string() + &MOTORS.iter().enumerate().map(row).collect::<String>()));
    folder
}

fn read(folder: &Path) -> Robot {
    requirement::read(&folder.join("arm.toml")).unwrap_or_else(|e| panic!("{}", e[0]))
}

#[test]
fn the_best_pair_of_motors_of_a_planar_arm_is_that_of_all_pairs_by_hand() {
    let mut chosen = Vec::new();
    let elbow: Vec<f64> = MOTORS.iter().map(|m| least_loss(1, *m, 0.0)).collect();
    for budget in [0.5, 0.75, 0.9, 1.1, 1.6, 2.2] {
        let mut best = (f64::INFINITY, [0, 0]);
        for (e, outer) in MOTORS.iter().enumerate() {
            for (s, inner) in MOTORS.iter().enumerate() {
                let mass = inner[3] + outer[3] + 2.0 * GEAR_MASS;
                if mass > budget {
                    continue;
                }
                let total = least_loss(0, *inner, outer[3] + GEAR_MASS) + elbow[e];
                if total < best.0 {
                    best = (total, [s, e]);
                }
            }
        }
        let limit = format!("[budget]\nactuator_mass = \"{budget} kg\"");
        let folder = arm(&limit, "actuators = \"separate\"", "", "");
        let robot = read(folder.path());
        let catalog = Catalog::read(&[folder.path().join("motors.csv")]).unwrap();
        let options = Options { budgets: false, runner_ups: 0, ..Options::default() };
        let choice = choose(&robot, &catalog, options).unwrap();
        let found = &choice.combinations[0];
        let motors: Vec<String> = found.joints.iter().map(|d| d.motor.id.clone()).collect();
        assert_eq!(motors, best.1.map(|m| format!("m{m}")), "{budget} kg");
        assert!((found.objective / best.0 - 1.0).abs() < 1e-6, "{budget} kg: {} by hand {}", found.objective, best.0);
        assert!(choice.proof.certified(), "{:?}", choice.proof);
        chosen.push(best.1);
    }
    chosen.dedup();
    assert!(chosen.len() >= 4, "the budgets decide little: {chosen:?}");
    // Where the description contained the actuators, none would load another: the heaviest elbow would be the best.
    let without: Vec<f64> = MOTORS.iter().map(|m| least_loss(0, *m, 0.0)).collect();
    let alone = |of: &[f64]| (0..of.len()).min_by(|a, b| of[*a].total_cmp(&of[*b])).unwrap();
    assert_ne!([alone(&without), alone(&elbow)], chosen[chosen.len() - 1]);
}

#[test]
fn what_the_requirement_says_goes_before_the_description() {
    let separate = "actuators = \"separate\"";
    let robot = read(arm("", separate, "", "").path());
    let carries = &robot.joints[0].carries;
    assert_eq!((carries.len(), carries[0].joint, carries[0].constant), (1, 1, false));
    for (k, torque) in carries[0].torque_per_mass.iter().enumerate() {
        let by_hand = by_hand(PERIOD * k as f64 / SAMPLES as f64)[2];
        assert!((torque - by_hand).abs() < 1e-9 * (1.0 + by_hand.abs()), "{k}: {torque} {by_hand}");
    }
    assert!(robot.joints[1].carries.is_empty());
    let robot = read(arm("", separate, "torque_per_mass = { elbow = \"1.5 N*m/kg\" }", "").path());
    let carries = &robot.joints[0].carries;
    assert_eq!((carries.len(), carries[0].constant, carries[0].torque_per_mass[3]), (1, true, 1.5));
    assert!(read(arm("", "", "", "").path()).joints[0].carries.is_empty(), "included unless said");
    // At the shoulder the elbow's actuator weighs nothing: then nothing carries.
    let at_base = "actuator_at = { link = \"base\", at = [\"0 m\", \"0 m\", \"0 m\"] }";
    assert!(read(arm("", separate, "", at_base).path()).joints[0].carries.is_empty());
}

/// The report on an arm in whose files something is spoilt: file, what stood there, what stands there now.
fn mistake(elbow: &str, spoilt: &[(&str, &str, &str)]) -> String {
    let folder = arm("", "actuators = \"separate\"", "", elbow);
    for (name, from, to) in spoilt {
        let path = folder.path().join(name);
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "`{from}` is not in {name}");
        fs::write(path, text.replace(from, to)).unwrap();
    }
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["optimize", "arm.toml", "--catalog", "motors.csv"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(output.stdout.is_empty());
    errors
}

const ARM: &str = "arm.toml";
/// A joint beside the arm, whose actuator sits on the forearm while the elbow's sits on it.
const CIRCLE: &str = "actuator_at = { link = \"other\", at = [\"0.2 m\", \"0 m\", \"0 m\"] }\n[[joint]]\nname = \"other\"\nratio = { min = 3, max = 9 }\nmechanism_joint = \"other_joint\"\nactuator_at = { link = \"fore\", at = [\"0.1 m\", \"0 m\", \"0 m\"] }";
const SEPARATE: &str = "actuators = \"separate\"";

macro_rules! mistakes {
    ($($name:ident: $elbow:expr, $spoilt:expr;)*) => {$(
        #[test]
        fn $name() {
            insta::with_settings!({ snapshot_path => "../../snapshots/mechanism", prepend_module_to_snapshot => false, omit_expression => true }, {
                insta::assert_snapshot!(stringify!($name), mistake($elbow, &$spoilt));
            });
        }
    )*};
}

mistakes! {
    actuator_on_what_it_moves: "actuator_at = { link = \"fore\" }", [];
    actuators_carry_each_other: CIRCLE, [];
    actuator_at_unknown_link: "actuator_at = { link = \"uper\" }", [];
    actuator_at_without_unit: "actuator_at = { link = \"upper\", at = [\"0.1\", \"0 m\", \"0 m\"] }", [];
    actuators_misspelt: "", [(ARM, "separate", "seperate")];
    lead_of_what_turns: "lead = \"10 mm\"", [];
    lead_missing: "", [("arm.urdf", "continuous", "prismatic"), ("move.csv", "rad", "m")];
    lead_upside_down: "lead = \"-10 mm\"", [("arm.urdf", "continuous", "prismatic"), ("move.csv", "rad", "m")];
    torque_per_mass_of_nobody: "torque_per_mass = { elbw = \"1 N*m/kg\" }", [];
    payload_on_unknown_link: "", [(ARM, SEPARATE, "payload = { link = \"for\", mass = \"1 kg\" }")];
    payload_of_less_than_nothing: "", [(ARM, SEPARATE, "payload = { link = \"fore\", mass = \"-1 kg\" }")];
    mechanism_joint_unknown: "", [(ARM, "\"elbow_joint\"", "\"elbow_jont\"")];
    mechanism_joint_and_motion: "motion = \"move.csv\"", [];
    mechanism_joint_without_mechanism: "", [(ARM, "[mechanism]\nmodel = \"arm.urdf\"\ntrajectory = \"move.csv\"\nactuators = \"separate\"\n", "")];
    model_of_mechanism_not_there: "", [(ARM, "arm.urdf", "am.urdf")];
}
