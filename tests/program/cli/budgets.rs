//! Where no combination keeps the budgets, the true cause is told: each cause has a case, and in that case no other is told.

use std::fs;

use super::folder::{Ran, folder, run};

/// Two joints under a budget; `hip` and `knee` are the lines of each joint.
fn robot(budget: &str, torque: &str, of_joints: [&str; 2]) -> String {
    let [knee, hip] = of_joints;
    format!(
        r#"name = "leg"
[bus]
voltage = "48 V"
drive_current = "40 A"
[budget]
{budget}
[[joint]]
name = "knee"
count = 2
ratio = {{ min = 3, max = 30 }}
motor_drag = "off"
gear = {{ efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2" }}
motion = "knee.csv"
objective = "copper_loss"
{knee}
[[joint]]
name = "hip"
ratio = {{ min = 3, max = 30 }}
motor_drag = "off"
gear = {{ efficiency = 0.95, mass = "150 g", inertia = "2e-6 kg*m^2" }}
points = [ {{ torque = "{torque}", speed = "3 rad/s", duration = "1 s" }} ]
objective = "copper_loss"
{hip}
"#
    )
}

fn optimize(text: &str) -> Ran {
    let folder = folder();
    fs::write(folder.path().join("robot.toml"), text).unwrap();
    run(&folder, &["optimize", "robot.toml", "--catalog", "motors.csv"])
}

const ALONE: &str = "no motor of the catalogue can do: hip";
const HEAVY: &str = "kg of actuators, not with less (budget";
const MOTORS: &str = "it can be done with 2 different motors, not with fewer";
const POWER: &str = "without the limit on power there is one, which draws";
const SEVERAL: &str = "with any one of the budgets given up none was found either";

#[test]
fn a_budget_that_cannot_be_kept_names_its_cause_and_no_other() {
    let all = [ALONE, HEAVY, MOTORS, POWER, SEVERAL];
    let apart = ["motors = [\"alpha-1\"]", "motors = [\"alpha-2\"]"];
    for (budget, torque, joints, cause) in [
        // The sum is too heavy: three actuators of 350 g.
        ("actuator_mass = \"1.04 kg\"", "1 N*m", ["", ""], HEAVY),
        // One joint alone has no motor, whatever the budget.
        ("actuator_mass = \"1.04 kg\"", "500 N*m", ["", ""], ALONE),
        ("actuator_mass = \"9 kg\"", "500 N*m", ["", ""], ALONE),
        // One motor is not enough for joints that take different ones.
        ("max_distinct_motors = 1", "1 N*m", apart, MOTORS),
        ("power = \"0.5 W\"", "1 N*m", ["", ""], POWER),
        // Neither alone is the cause.
        ("actuator_mass = \"1.04 kg\"\npower = \"0.5 W\"", "1 N*m", ["", ""], SEVERAL),
    ] {
        let ran = optimize(&robot(budget, torque, joints));
        assert_eq!(ran.status, 1, "{budget}: {}{}", ran.out, ran.err);
        let flat = ran.out.split_whitespace().collect::<Vec<_>>().join(" ");
        for told in all {
            assert_eq!(flat.contains(told), told == cause, "{budget}, {torque}: `{told}`: {}", ran.out);
        }
    }
    // What is enough is no failure.
    let ran = optimize(&robot("actuator_mass = \"1.06 kg\"", "1 N*m", ["", ""]));
    assert_eq!(ran.status, 0, "{}", ran.out);
    assert!(all.iter().all(|told| !ran.out.contains(told)));
}

#[test]
fn two_joints_are_not_one_joint_of_the_description() {
    let arm = concat!(env!("CARGO_MANIFEST_DIR"), "/requirements/arm_from_its_description.toml");
    let ran = run(&folder(), &["optimize", arm, "--set", "joint.wrist_2.mechanism_joint=wrist_1"]);
    assert_eq!(ran.status, 2, "{}", ran.out);
    assert!(ran.err.contains("`wrist_1` and `wrist_2` have one `mechanism_joint`"), "{}", ran.err);
}
