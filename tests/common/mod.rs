//! What several tests need.
#![allow(dead_code, reason = "each test file uses its part")]

pub mod real;
pub mod run;

use std::path::Path;
use std::sync::Arc;

use gearwise::actuator::Load;
use gearwise::catalog::convention::Modulation;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::{Evaluation, Mount, Prepared};
use gearwise::input::Source;
use gearwise::requirement::{
    Budget, Bus, GearModel, Joint, Limits, Motion, Objective, Point, Quantity, RatioChoice, Regeneration, Robot,
    Spring, backdrive_efficiency,
};
use gearwise::transmission::SpringAt;

/// A whole number of the environment, for scores on other seeds.
pub fn given(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |n| n.parse().expect("a number"))
}

/// The folder with data of others that are no part of the repository, named by `GEARWISE_SHARED`.
pub fn shared() -> Option<std::path::PathBuf> {
    std::env::var_os("GEARWISE_SHARED").map(Into::into)
}

/// The path of a file of the repository.
pub fn repository(path: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// A motor from the cells of one catalogue row: `(column, cell)`; the rest is filled in. Where nothing is said of
/// temperatures its resistance is that at 100 °C, which is assumed for the winding then: it is the same in heat and voltage.
/// Where nothing is said of heat at all, it may give a continuous torque that no test comes near.
pub fn motor(cells: &[(&str, &str)]) -> Motor {
    let mut columns = vec![("id", "test"), ("source", "test"), ("source_kind", "derived")];
    let says = |words: &[&str]| cells.iter().any(|(name, _)| words.iter().any(|word| name.starts_with(word)));
    if !says(&["thermal", "max_winding", "reference_temperature"]) {
        columns.push(("reference_temperature [degC]", "100"));
    }
    if !says(&["thermal", "continuous_current", "continuous_torque"]) {
        columns.push(("continuous_torque [N*m]", "1e9"));
    }
    for (name, cell) in [("terminals", "q_axis"), ("current", "q_axis")] {
        if !cells.iter().any(|(n, _)| *n == name) {
            columns.push((name, cell));
        }
    }
    columns.extend(cells);
    let header: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let row: Vec<&str> = columns.iter().map(|(_, cell)| *cell).collect();
    let text = format!("{}\n{}\n", header.join(","), row.join(","));
    let catalog = Catalog::from_sources(vec![Arc::new(Source::new("test.csv", text))]);
    catalog.unwrap_or_else(|e| panic!("{}", e[0])).motors.remove(0)
}

/// A robot with one joint on an ample bus: no limit but those that are set later.
pub fn robot(motion: Motion, gear: GearModel) -> Robot {
    let joint = Joint {
        name: "joint".into(),
        count: 1,
        ratio: RatioChoice::Continuous { min: 1.0, max: 1000.0 },
        gear,
        gear_map: None,
        motors: gearwise::requirement::Filter::default(),
        motion: motion.into(),
        objective: Objective::single(Quantity::CopperLoss),
        balancing: gearwise::requirement::Balancing::No,
        limits: Limits::default(),
        drive_current: None,
        drive: gearwise::requirement::Drive::default(),
        motor_drag: gearwise::requirement::MotorDrag::Off,
        turns: gearwise::requirement::Turns::AsWound,
        phases: Vec::new(),
        carries: Vec::new(),
        passed: None,
    };
    Robot {
        name: "test".into(),
        bus: Bus {
            voltage: 1e6,
            modulation: Modulation::SpaceVector,
            modulation_limit: 1.0,
            drive_current: None,
            power: None,
            current: None,
            regeneration: Regeneration::Allowed,
            regeneration_efficiency: None,
            brake_power: None,
            flux_braking: false,
            internal_resistance: None,
            max_voltage: None,
            drive_efficiency: 1.0,
            drive: gearwise::requirement::Drive::default(),
            says_drive_loss: false,
        },
        ambient: 298.15,
        budget: Budget::default(),
        prices: None,
        joints: vec![joint],
        cases: Vec::new(),
        driven: None,
        rules: None,
        sources: Vec::new(),
        set: Vec::new(),
    }
}

/// A spring at the joint, to be completed.
pub const SPRING: Spring = Spring { stiffness: [0.0, 1.0], rest_angle: [0.0, 1.0], at: SpringAt::Joint };

/// One operating point that lasts.
pub fn hold(torque: f64, velocity: f64, acceleration: f64) -> Motion {
    Motion::from_points(&[Point { torque, velocity, acceleration, duration: Some(1.0), ..Point::default() }])
}

/// A gear with an efficiency and nothing else.
pub fn gear(efficiency: f64) -> GearModel {
    GearModel { efficiency, backdrive_efficiency: backdrive_efficiency(efficiency), ..GearModel::IDEAL }
}

/// One design of the robot's first joint.
pub fn evaluate(robot: &Robot, motor: &Motor, ratio: f64) -> Evaluation {
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    Prepared::new(Mount::new(robot, joint, &load, motor).candidate().expect("a candidate")).at(ratio)
}

/// The demand of one limit.
pub fn demand(evaluation: &Evaluation, limit: &str) -> f64 {
    let found = evaluation.margins.iter().find(|m| m.limit == limit);
    found.unwrap_or_else(|| panic!("{limit} was not checked")).demand
}
