//! A peer's published problem (CORDS, `joule_rigid`): motor and gearbox of one arm joint by least copper
//! loss, on the public Motor-Gearbox Database. The data are not ours to ship: without them the test says
//! that it is skipped.

mod common;

use std::collections::BTreeMap;

use common::{repository, robot};
use gearwise::catalog::Catalog;
use gearwise::design::sweep;
use gearwise::requirement::{EfficiencyCovers, GearModel, Motion, Point, RatioChoice};

#[test]
fn every_feasible_pair_of_cords_with_its_loss() {
    let shared = repository("../shared");
    let (database, case) = (shared.join("mgdb"), shared.join("cases/cords"));
    if !database.is_dir() || !case.is_dir() {
        println!("skipped: ../shared/mgdb and ../shared/cases/cords are not there");
        return;
    }
    // The catalogue, by the program's own importer.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("catalog");
    let imported = std::process::Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["import", "mgdb", database.to_str().unwrap(), "--out", out.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(imported.status.code().is_some_and(|c| c < 2), "{}", String::from_utf8_lossy(&imported.stderr));
    let mut catalog = Catalog::read(&[out]).unwrap_or_else(|e| panic!("{}", e[0]));
    for motor in &mut catalog.motors {
        // The problem knows neither inductance nor rated current nor heat.
        motor.inductance = Some(0.0);
        (motor.continuous_current, motor.continuous_torque, motor.peak_torque) = (None, None, None);
        (motor.thermal_resistance, motor.max_winding_temperature) = (None, None);
    }
    for gear in &mut catalog.gears {
        // Its filter of the continuous torque is a number of its own.
        if gear.continuous_torque.is_some_and(|t| t < 0.77386) {
            gear.peak_torque = Some(1e-9);
        }
        gear.continuous_torque = None;
    }
    let mut points = Vec::new();
    for row in csv::Reader::from_path(case.join("arm_trajectory.csv")).unwrap().records() {
        let cell = |i: usize, row: &csv::StringRecord| row[i].parse::<f64>().unwrap();
        let row = row.unwrap();
        points.push(Point {
            velocity: cell(3, &row),
            acceleration: cell(4, &row),
            torque: cell(5, &row),
            duration: Some(0.01),
            ..Point::default()
        });
    }
    assert_eq!(points.len(), 101);
    let mut robot = robot(Motion::from_points(&points), GearModel::IDEAL);
    robot.bus.voltage = 24.0;
    robot.bus.drive_current = Some(80.0);
    robot.joints[0].ratio =
        RatioChoice::Catalog { patterns: vec!["*".into()], efficiency_covers: EfficiencyCovers::LoadAndGear };
    let swept = sweep(&robot, &catalog, 1);
    let ours: BTreeMap<(String, String), f64> = swept[0]
        .designs
        .iter()
        .filter(|d| d.evaluation.feasible)
        .map(|d| ((d.motor.id.clone(), d.gear.unwrap_or("").to_string()), 101.0 * d.evaluation.loss))
        .collect();
    let id = |key: &str| match key {
        "DD" => "direct".to_string(),
        key => key.to_lowercase().replace(['_', ':'], "-"),
    };
    let (mut same, mut missing, mut apart, mut theirs) = (0, Vec::new(), Vec::new(), std::collections::BTreeSet::new());
    for row in csv::Reader::from_path(case.join("joule_rigid_exact.csv")).unwrap().records() {
        let row = row.unwrap();
        if &row[2] != "1" || &row[3] != "1" {
            continue;
        }
        let pair = (id(&row[0]), id(&row[1]));
        let cost: f64 = row[4].parse().unwrap();
        match ours.get(&pair) {
            Some(loss) if (loss / cost - 1.0).abs() <= 1e-6 => same += 1,
            Some(loss) => apart.push((pair.clone(), *loss, cost)),
            None => missing.push(pair.clone()),
        }
        theirs.insert(pair);
    }
    // Three motors of T-Motor came to the database after the problem was published.
    let later = ["tm-ak-60-6", "tm-ak-80-6", "tm-u8-kv100"];
    let extra: Vec<_> = ours.keys().filter(|p| !theirs.contains(*p) && !later.contains(&p.0.as_str())).collect();
    println!("{same} pairs agree, {} missing, {} apart, {} extra", missing.len(), apart.len(), extra.len());
    println!(
        "missing {:?}\napart {:?}\nextra {:?}",
        &missing[..missing.len().min(5)],
        &apart[..apart.len().min(5)],
        &extra[..extra.len().min(8)]
    );
    assert!(apart.is_empty() && missing.is_empty() && extra.is_empty());
    assert_eq!(same, 1312);
}
