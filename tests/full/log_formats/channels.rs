//! Channels of robots without instruments: torques that a drive was told or says, angles with another zero.

use approx::assert_relative_eq;
use gearwise::measured::{Bench, Channel};

use super::{few, outcome, refused};

/// An arm's joint: position, velocity, and the effort that its drive says.
const BENCH: &str = r#"actuator = { motor = "t-motor-ri50", ratio = 9 }
kind = "free"
load = { inertia = "0.1 kg*m^2" }
[columns]
time = { name = "t", unit = "s" }
torque_estimate = { name = "tau", unit = "N*m", side = "output" }
velocity = { name = "w", unit = "rad/s", side = "output" }
position = { name = "i", unit = "deg", side = "output" }
[[log]]
file = "log.csv"
"#;

fn log() -> String {
    let mut text = String::from("t,i,w,tau\n");
    for row in 0..4 {
        let cells: Vec<String> = few().iter().map(|(_, values)| values[row].to_string()).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}

fn good(bench: &str) -> Bench {
    outcome(bench, "log.csv", log().as_bytes()).unwrap_or_else(|e| panic!("{e}"))
}

fn bad(bench: &str, parts: &[&str]) {
    refused(bench, "log.csv", log().as_bytes(), parts);
}

#[test]
fn a_torque_of_the_drive_is_the_current_that_makes_it() {
    let bench = good(BENCH);
    let torque_constant = bench.declared.motor.as_ref().unwrap().torque_constant;
    let current = |bench: &Bench| bench.logs[0].channel(Channel::Current).unwrap().to_vec();
    for (current, torque) in current(&bench).iter().zip([5.0, 6.0, 7.0, 8.0]) {
        assert_relative_eq!(current * torque_constant * 9.0, torque, max_relative = 1e-12);
    }
    let remark = "`torque_estimate` is taken as the current that makes it by the declared torque constant";
    assert_eq!(bench.logs[0].remarks, [remark]);
    assert!(bench.logs[0].held.is_empty());
    // At the motor there is no ratio; a drive holds what it is told.
    let told = good(
        &BENCH
            .replace("torque_estimate", "torque_demand")
            .replace("\"N*m\", side = \"output\"", "\"N*m\", side = \"motor\""),
    );
    assert_relative_eq!(current(&told)[3] * torque_constant, 8.0, max_relative = 1e-12);
    assert!(told.logs[0].held.contains(&Channel::Current));
    // A side that is not said is the output's, and said to be assumed.
    let unsaid = good(&BENCH.replace("\"N*m\", side = \"output\"", "\"N*m\""));
    assert_eq!(current(&unsaid), current(&bench));
    assert!(unsaid.logs[0].remarks.iter().any(|r| r.contains("names no side")), "{:?}", unsaid.logs[0].remarks);
    let both = BENCH.replace("velocity =", "current = { name = \"i\", unit = \"A\" }\nvelocity =");
    bad(&both, &["two columns for one channel: `current` and `torque_estimate`"]);
    bad(&BENCH.replace("torque_estimate", "torque_estimates"), &["did you mean `torque_estimate`?"]);
    let linear = BENCH
        .replace("motor = \"t-motor-ri50\", ratio = 9", "mass = \"3 kg\"")
        .replace("\"free\"", "\"linear\"")
        .replace("load = { inertia = \"0.1 kg*m^2\" }\n", "");
    bad(
        &linear.replace("N*m", "N").replace("deg", "m").replace("rad/s", "m/s"),
        &["a linear axis has no `torque_estimate`", "`force_gain`"],
    );
    // A current is no torque, and nothing is said of it.
    let plain = good(&BENCH.replace(
        "torque_estimate = { name = \"tau\", unit = \"N*m\", side = \"output\" }",
        "current = { name = \"tau\", unit = \"A\", convention = \"q_axis\" }",
    ));
    assert!(plain.logs[0].remarks.is_empty());
}

#[test]
fn an_angle_may_have_another_zero() {
    let position = |more: &str| {
        let bench = good(&BENCH.replace("unit = \"deg\"", &format!("unit = \"deg\"{more}")));
        bench.logs[0].channel(Channel::OutputPosition).unwrap().to_vec()
    };
    let degrees = f64::to_radians;
    assert_relative_eq!(position("")[1], degrees(2.0), max_relative = 1e-12);
    assert_relative_eq!(position(", offset = \"90 deg\"")[1], degrees(92.0), max_relative = 1e-12);
    assert_relative_eq!(position(", offset = \"90 deg\", sign = -1")[1], degrees(88.0), max_relative = 1e-12);
    assert_relative_eq!(position(", offset = \"-0.5 rad\", scale = 2")[1], degrees(4.0) - 0.5, max_relative = 1e-12);
    bad(&BENCH.replace("unit = \"deg\"", "unit = \"deg\", offset = 90"), &["offset"]);
    bad(&BENCH.replace("unit = \"rad/s\"", "unit = \"rad/s\", offset = \"1 rad/s\""), &["unknown key `offset`"]);
}
