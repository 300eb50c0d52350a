//! Whole robots: identities that must hold whatever the numbers, and what a user sees.

use std::fs;
use std::process::{Command, Output};

use gearwise::catalog::Catalog;
use gearwise::design::optimize;
use gearwise::design::robot::{Choice, Options, choose};
use gearwise::requirement::{self, Carried, Objective, Quantity, Robot};
use serde_json::Value;

use crate::cases::are_all;
use crate::common;
use crate::common::run::gearwise_in;

fn quadruped() -> Robot {
    requirement::read(&common::repository("requirements/quadruped_mini_cheetah.toml")).unwrap()
}

/// Motors of all makers, so that combinations can be counted.
const FEW: [&str; 14] = [
    "allied-mf0127020-48v",
    "faulhaber-3272g024cr",
    "faulhaber-3274g024bp4",
    "maxon-dcx-35-l-dcx35l01gbkl511",
    "maxon-ec-4pole-30-305015",
    "maxon-ec-60-flat-625858",
    "maxon-ec-60-flat-642221",
    "maxon-ec-90-flat-580047",
    "maxon-ec-i-40-496655",
    "maxon-ec-i-40-496660",
    "robstride-rs03",
    "t-motor-g30-kv290",
    "t-motor-u8-lee",
    "tq-robodrive-ilm-e70x18-delta-serial",
];

fn few() -> Catalog {
    let mut catalog = Catalog::builtin().unwrap();
    catalog.motors.retain(|m| FEW.contains(&m.id.as_str()));
    assert_eq!(catalog.motors.len(), FEW.len());
    catalog
}

fn quick(runner_ups: usize) -> Options<'static> {
    Options { budgets: false, runner_ups, ..Options::default() }
}

/// Motors, ratios and totals of all combinations, to the last bit.
fn told(choice: &Choice) -> Vec<String> {
    let one = |c: &gearwise::design::robot::Combination| {
        let joints = c.joints.iter().map(|d| format!("{} {:?}", d.motor.id, d.evaluation.ratio)).collect::<Vec<_>>();
        format!("{:?} {:?} {:?} {:?}", c.objective, c.lower_bound, c.peak_power, joints)
    };
    choice.combinations.iter().map(one).collect()
}

#[test]
fn a_robot_of_one_joint_is_the_joint_and_without_budgets_joints_add_up() {
    let (robot, catalog) = (quadruped(), few());
    let alone = optimize(&robot, &catalog);
    let expected: f64 = alone.joints.iter().map(|j| f64::from(j.joint.count) * j.candidates[0].optimum.objective).sum();
    let mut ample = robot.clone();
    ample.budget.actuator_mass = Some(1e3);
    ample.budget.power = Some(1e7);
    ample.budget.max_distinct_motors = Some(3);
    for robot in [&robot, &ample] {
        let choice = choose(robot, &catalog, quick(0)).unwrap();
        let best = &choice.combinations[0];
        assert!((best.objective - expected).abs() <= 1e-12 * expected, "{} {expected}", best.objective);
        for (design, joint) in best.joints.iter().zip(&alone.joints) {
            assert_eq!(design.motor.id, joint.candidates[0].motor.id);
        }
        assert!(choice.proof.certified(), "{:?}", choice.proof);
    }
    let mut one = robot.clone();
    one.joints.truncate(1);
    one.joints[0].count = 1;
    let choice = choose(&one, &catalog, quick(3)).unwrap();
    for (combination, candidate) in choice.combinations.iter().zip(&alone.joints[0].candidates) {
        assert_eq!(combination.joints[0].motor.id, candidate.motor.id);
        assert!((combination.objective - candidate.optimum.objective).abs() <= 1e-12 * candidate.optimum.objective);
    }
}

#[test]
fn a_count_is_so_many_joints_alike() {
    let catalog = few();
    let mut together = quadruped();
    together.joints = vec![together.joints[2].clone()];
    together.joints[0].count = 2;
    let free = choose(&together, &catalog, quick(0)).unwrap().combinations[0].peak_power;
    let mut compared = 0;
    for phases in [Vec::new(), vec![0.0, 0.5]] {
        together.joints[0].phases = phases.clone();
        let mut apart = together.clone();
        apart.joints = vec![together.joints[0].clone(), together.joints[0].clone()];
        for (j, joint) in apart.joints.iter_mut().enumerate() {
            joint.count = 1;
            joint.name = format!("{}_{j}", joint.name);
            joint.phases = phases.get(j).map(|p| vec![*p]).unwrap_or_default();
        }
        for share in [0.999, 2.0] {
            let power = Some(share * free);
            (together.budget.power, apart.budget.power) = (power, power);
            // Alike joints have one and the same motor, with or without being told.
            (together.budget.max_distinct_motors, apart.budget.max_distinct_motors) = (Some(1), Some(1));
            let [a, b] = [&together, &apart].map(|r| choose(r, &catalog, quick(0)).unwrap());
            let best = |c: &Choice| c.combinations.first().map(|c| c.objective);
            assert_eq!(best(&a).is_some(), best(&b).is_some());
            let (Some(a), Some(b)) = (best(&a), best(&b)) else { continue };
            compared += 1;
            assert!((a - b).abs() <= 1e-6 * a, "{phases:?} {share}: {a} {b}");
        }
    }
    assert!(compared >= 2, "{compared}");
}

#[test]
fn legs_out_of_phase_draw_less_at_once() {
    let catalog = few();
    let mut robot = quadruped();
    robot.joints = vec![robot.joints[2].clone()];
    robot.joints[0].count = 4;
    let peak = |robot: &Robot| choose(robot, &catalog, quick(0)).unwrap().combinations[0].peak_power;
    let in_phase = peak(&robot);
    robot.joints[0].phases = vec![0.0; 4];
    assert!((peak(&robot) / in_phase - 1.0).abs() < 1e-12);
    robot.joints[0].phases = vec![0.0, 0.5, 0.5, 0.0];
    assert!(peak(&robot) < in_phase);
}

#[test]
fn the_answer_does_not_depend_on_the_number_of_threads() {
    let catalog = few();
    let mut robot = quadruped();
    let (watt, mass) = {
        let free = choose(&robot, &catalog, quick(0)).unwrap();
        (free.combinations[0].peak_power, free.combinations[0].mass.unwrap())
    };
    robot.budget.power = Some(0.9 * watt);
    robot.budget.actuator_mass = Some(0.95 * mass);
    robot.budget.max_distinct_motors = Some(2);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| told(&choose(&robot, &catalog, quick(3)).unwrap()))
    };
    let one = with(1);
    let others: &[usize] = if are_all() { &[2, 8] } else { &[8] };
    others.iter().for_each(|threads| assert_eq!(one, with(*threads)));
}

#[test]
fn a_weightless_carried_actuator_is_none() {
    let catalog = few();
    let mut robot = quadruped();
    let free = choose(&robot, &catalog, quick(0)).unwrap().combinations[0].objective;
    let samples = robot.joints[0].motion.len();
    robot.joints[0].carries.push(Carried {
        joint: 1,
        torque_per_mass: vec![0.0; samples],
        rate: vec![0.0; samples],
        constant: true,
    });
    let choice = choose(&robot, &catalog, quick(0)).unwrap();
    assert!((choice.combinations[0].objective / free - 1.0).abs() < 1e-12);
    assert!(choice.proof.lower_bound.unwrap() <= free * (1.0 + 1e-12));
}

#[test]
fn joints_that_minimise_different_things_are_measured_by_their_own_best() {
    let catalog = few();
    let mut robot = quadruped();
    robot.joints[1].objective = Objective::single(Quantity::ReflectedInertia);
    let choice = choose(&robot, &catalog, quick(0)).unwrap();
    let count: f64 = robot.joints.iter().map(|j| f64::from(j.count)).sum();
    assert!(choice.total.relative);
    assert!((choice.combinations[0].objective - count).abs() < 1e-9 * count, "without budgets each has its best");
}

const MOTION: &str =
    "time [s], torque [N*m], velocity [rad/s]\n0, 1, 1\n0.1, 4, 3\n0.2, 2, 1\n0.3, -1, -3\n0.4, 1, 1\n";
const MOTORS: &str = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],peak_current [A],continuous_torque [N*m],source,source_kind
small,q_axis,q_axis,0.9,0.05,60,120,25,9,a sheet,datasheet
large,q_axis,q_axis,0.3,0.08,400,420,40,9,a sheet,datasheet
";

fn arm(budget: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("motion.csv", MOTION);
    write("motors.csv", MOTORS);
    let joint = |name: &str, more: &str| {
        format!(
            "[[joint]]\nname = \"{name}\"\nratio = {{ min = 3, max = 30 }}\nmotor_drag = \"off\"\nmotion = \"motion.csv\"\n{more}\n"
        )
    };
    let robot = format!(
        "name = \"arm\"\n[bus]\nvoltage = \"48 V\"\n{budget}\n{}{}",
        joint("shoulder", "torque_per_mass = { elbow = \"2.1 N*m/kg\" }"),
        joint("elbow", "count = 1")
    );
    write("arm.toml", &robot);
    (folder, robot)
}

#[test]
fn a_user_is_told_what_the_budget_costs_and_what_comes_next() {
    let (folder, _) = arm("[budget]\nactuator_mass = \"600 g\"");
    let output = gearwise_in(folder.path(), &["optimize", "arm.toml", "--catalog", "motors.csv"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{text}{}", String::from_utf8_lossy(&output.stderr));
    for part in
        ["The whole robot", "proved: no combination is better", "Next best", "What the budgets cost", "Less mass costs"]
    {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let output = gearwise_in(folder.path(), &["optimize", "arm.toml", "--catalog", "motors.csv", "--json"]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let choice = &json["robot"]["choice"];
    assert_eq!(choice["certificate"]["certified"], true);
    let best = &choice["best"];
    assert!(best["actuator_mass_kg"].as_f64().unwrap() <= 0.6);
    let elbow = best["joints"][1]["mass_kg"].as_f64().unwrap();
    let carried = best["joints"][0]["carried_torque_nm"].as_f64().unwrap();
    assert!((carried - 2.1 * elbow).abs() < 1e-12, "{carried} {elbow}");
}

#[test]
fn a_budget_that_nothing_keeps_is_answered_with_the_least() {
    let (folder, _) = arm("[budget]\nactuator_mass = \"200 g\"");
    let output = gearwise_in(folder.path(), &["optimize", "arm.toml", "--catalog", "motors.csv"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("NO combination keeps all of this"), "{text}");
    assert!(text.contains("it can be done with 0.24 kg of actuators, not with less (budget 0.2 kg)"), "{text}");
}

#[test]
fn a_column_of_torque_per_mass_is_read_with_the_motion() {
    let (folder, robot) = arm("");
    let rows = MOTION.lines().enumerate().map(|(i, row)| {
        let cell = if i == 0 { "torque_per_mass_elbow [N*m/kg]".to_string() } else { "2.1".into() };
        format!("{row}, {cell}\n")
    });
    fs::write(folder.path().join("shoulder.csv"), rows.collect::<String>()).unwrap();
    let with_column = robot
        .replacen("motion = \"motion.csv\"\n", "motion = \"shoulder.csv\"\n", 1)
        .replace("torque_per_mass = { elbow = \"2.1 N*m/kg\" }\n", "");
    fs::write(folder.path().join("column.toml"), with_column).unwrap();
    let objective = |name: &str| {
        let output = gearwise_in(folder.path(), &["optimize", name, "--catalog", "motors.csv", "--json"]);
        let json: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)));
        json["robot"]["choice"]["best"]["objective"].as_f64().unwrap()
    };
    let (scalar, column) = (objective("arm.toml"), objective("column.toml"));
    assert!((scalar / column - 1.0).abs() < 1e-12, "{scalar} {column}");
    // A periodic column repeats its first row as all others do.
    let path = folder.path().join("shoulder.csv");
    let text = fs::read_to_string(&path).unwrap();
    let end = text.rfind("2.1").unwrap();
    fs::write(&path, format!("{}2.2\n", &text[..end])).unwrap();
    let output = gearwise_in(folder.path(), &["optimize", "column.toml", "--catalog", "motors.csv"]);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("but `torque_per_mass_elbow` does not") && errors.contains("shoulder.csv:6"), "{errors}");
}

#[test]
fn two_joints_in_opposite_phase_need_the_power_of_one() {
    // By hand: the power of one joint is up in half of the period and down in the other, and what comes back is
    // not used here. In phase both peaks meet, half a period apart never.
    let rows = "time [s], torque [N*m], velocity [rad/s]\n0,6,3\n0.1,6,3\n0.2,6,3\n0.3,0.1,0.1\n0.4,0.1,0.1\n0.5,0.1,0.1\n0.6,6,3\n";
    let peak = |phases: &str| {
        let (folder, _) = arm("[budget]\npower = \"100 kW\"");
        fs::write(folder.path().join("steps.csv"), rows).unwrap();
        let joint = format!(
            "[[joint]]\nname = \"knee\"\ncount = 2\n{phases}\nratio = {{ min = 8, max = 8 }}\nmotor_drag = \"off\"\nmotion = \"steps.csv\"\n"
        );
        fs::write(
            folder.path().join("legs.toml"),
            format!("name = \"legs\"\n[bus]\nvoltage = \"48 V\"\n[budget]\npower = \"100 kW\"\n{joint}"),
        )
        .unwrap();
        let output = gearwise_in(folder.path(), &["optimize", "legs.toml", "--catalog", "motors.csv", "--json"]);
        let json: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)));
        json["robot"]["choice"]["best"]["peak_power_w"].as_f64().unwrap()
    };
    let (together, apart) = (peak(""), peak("phases = [0, 0.5]"));
    // What the other draws while it hardly moves is far below a tenth of the peak.
    assert!(apart > 0.5 * together && apart < 0.55 * together, "{together} {apart}");
}

/// The quadruped whose legs share the mass of their actuators.
fn with_budget(folder: &std::path::Path) -> std::path::PathBuf {
    let motions = common::repository("requirements/motions");
    let text = fs::read_to_string(common::repository("requirements/quadruped_mini_cheetah.toml")).unwrap();
    let text = text.replace("motions/", &format!("{}/", motions.display()));
    let text = text.replace(
        "name = \"hip_abad\"\n",
        "name = \"hip_abad\"\ntorque_per_mass = { hip = \"0.6 N*m/kg\", knee = \"0.6 N*m/kg\" }\n",
    );
    let path = folder.join("robot.toml");
    fs::write(&path, text + "[budget]\nmax_distinct_motors = 2\n").unwrap();
    path
}

fn optimized(path: &std::path::Path, more: &[&str]) -> Output {
    let path = path.to_str().unwrap();
    let arguments = [&["optimize", path, "--no-estimates", "--quiet"], more].concat();
    Command::new(env!("CARGO_BIN_EXE_gearwise")).args(arguments).output().unwrap()
}

#[test]
fn a_search_that_time_ends_says_what_may_be_better_and_proves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = with_budget(folder.path());
    let said =
        |output: &Output| String::from_utf8_lossy(&output.stdout).split_whitespace().collect::<Vec<_>>().join(" ");
    let whole = said(&optimized(&path, &[]));
    assert!(whole.contains("proved: no combination is better"), "{whole}");
    // Time enough: the same answer.
    assert_eq!(said(&optimized(&path, &["--time-limit", "10 min"])), whole);
    // The search begins and ends.
    let short = said(&optimized(&path, &["--time-limit", "1 ms"]));
    assert!(!short.contains("proved: no combination") && !short.contains("NO combination keeps"), "{short}");
    assert!(short.contains("not ruled out: ") || short.contains("may be better: "), "{short}");
    assert!(
        short.contains("s more, if none of them") || short.contains("how long more it would take is not known"),
        "{short}"
    );
    let json: Value = serde_json::from_slice(&optimized(&path, &["--time-limit", "1 ms", "--json"]).stdout).unwrap();
    let proof = &json["robot"]["choice"]["certificate"];
    assert_eq!(proof["certified"], false);
    assert!(!proof["may_be_better"].as_array().unwrap().is_empty());
}

#[test]
fn a_time_that_is_none_and_a_robot_without_a_search_are_mistakes() {
    let folder = tempfile::tempdir().unwrap();
    let path = with_budget(folder.path());
    for (limit, says) in [("0 s", "no time"), ("-3 s", "--time-limit"), ("5", "unit"), ("soon", "--time-limit")] {
        let output = optimized(&path, &["--time-limit", limit]);
        let said = String::from_utf8_lossy(&output.stderr).to_string();
        assert_eq!(output.status.code(), Some(2), "{limit}: {said}");
        assert!(said.contains(says), "{limit}: {said}");
    }
    let plain = common::repository("requirements/quadruped_mini_cheetah.toml");
    let output = optimized(&plain, &["--time-limit", "5 s"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("--robot"));
}
