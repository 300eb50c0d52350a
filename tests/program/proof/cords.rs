//! A peer's published problem (CORDS, `joule_rigid`): motor and gearbox of one arm joint by least copper
//! loss, on the public Motor-Gearbox Database. The data are not ours to ship: without them the test says
//! that it is skipped.

use std::collections::BTreeMap;

use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize;
use gearwise::design::sweep;
use gearwise::requirement::{
    Course, EfficiencyCovers, GearModel, Motion, Objective, Point, Quantity, RatioChoice, Regeneration, Samples, Spring,
};

use crate::common::robot;

/// The folder of the data, where it is named and has them.
fn shared() -> Option<std::path::PathBuf> {
    crate::common::shared().filter(|shared| shared.join("mgdb").is_dir() && shared.join("cases/cords").is_dir())
}

#[test]
fn every_feasible_pair_of_cords_with_its_loss() {
    let Some(shared) = shared() else {
        println!("not run: GEARWISE_SHARED names no folder with mgdb and cases/cords");
        return;
    };
    let (database, case) = (shared.join("mgdb"), shared.join("cases/cords"));
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
        // Nor does the resistance rise: the 100 °C that are assumed for the winding are its reference.
        motor.reference_temperature = 373.15;
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
    robot.joints[0].ratio = RatioChoice::gears(vec!["*".into()], EfficiencyCovers::LoadAndGear);
    let swept = sweep(&robot, &catalog, 1);
    let ours: BTreeMap<(String, String), f64> = swept[0]
        .designs
        .iter()
        .filter(|d| d.evaluation.feasible)
        .map(|d| ((d.motor.id.clone(), d.gear.unwrap_or("").to_string()), 101.0 * d.evaluation.copper_loss))
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

/// The imported database and the problem's motion, as points and in time; nothing is left out yet.
fn problem() -> Option<(Catalog, [Motion; 2])> {
    let shared = shared()?;
    let (database, case) = (shared.join("mgdb"), shared.join("cases/cords"));
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("catalog");
    let imported = std::process::Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["import", "mgdb", database.to_str().unwrap(), "--out", out.to_str().unwrap()])
        .output()
        .unwrap();
    assert!(imported.status.code().is_some_and(|c| c < 2));
    let catalog = Catalog::read(&[out]).unwrap_or_else(|e| panic!("{}", e[0]));
    let rows: Vec<Vec<f64>> = csv::Reader::from_path(case.join("arm_trajectory.csv"))
        .unwrap()
        .records()
        .map(|row| row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<f64>>();
    let (velocity, acceleration, torque) = (column(3), column(4), column(5));
    let point = |k: usize| Point {
        velocity: velocity[k],
        acceleration: acceleration[k],
        torque: torque[k],
        duration: Some(0.01),
        ..Point::default()
    };
    let points = Motion::from_points(&(0..rows.len()).map(point).collect::<Vec<_>>());
    let samples = Samples {
        time: column(0),
        torque: torque.clone(),
        velocity: Some(velocity.clone()),
        acceleration: Some(acceleration.clone()),
        ..Samples::default()
    };
    let duration = rows[rows.len() - 1][0] - rows[0][0];
    Some((catalog, [points, Motion::from_samples(samples, Course::Once(duration))]))
}

/// Its `min_power_consumption` on the same trajectory with a parallel spring: energy with 1/0.95 of what is drawn and 0.80 of
/// what comes back (`power_regen`), or nothing of it (`power_brake`). Published: 0.710171 J and 1.327845 J. All pairs are swept at
/// the spring of the best; spring and pair are solved together for the twelve that are best there.
#[test]
fn the_least_energy_of_cords_with_a_spring_and_regeneration() {
    let Some((mut catalog, _)) = problem() else {
        println!("not run: GEARWISE_SHARED names no folder with mgdb and cases/cords");
        return;
    };
    let later = ["tm-ak-60-6", "tm-ak-80-6", "tm-u8-kv100"];
    catalog.motors.retain(|motor| !later.contains(&motor.id.as_str()));
    for motor in &mut catalog.motors {
        motor.inductance = Some(0.0);
        (motor.continuous_current, motor.continuous_torque, motor.peak_torque) = (None, None, None);
        (motor.thermal_resistance, motor.max_winding_temperature) = (None, None);
        motor.reference_temperature = 373.15;
    }
    catalog.gears.iter_mut().for_each(|gear| gear.continuous_torque = None);
    let rows: Vec<Vec<f64>> =
        csv::Reader::from_path(shared().expect("a problem has its data").join("cases/cords/arm_trajectory.csv"))
            .unwrap()
            .records()
            .map(|row| row.unwrap().iter().map(|cell| cell.parse().unwrap()).collect())
            .collect();
    let column = |i: usize| rows.iter().map(|row| row[i]).collect::<Vec<f64>>();
    let samples = Samples {
        time: column(0),
        torque: column(5),
        position: Some(column(1)),
        velocity: Some(column(3)),
        acceleration: Some(column(4)),
        ..Samples::default()
    };
    let motion = Motion::from_samples(samples, Course::Once(1.0));
    let cases = [
        (Regeneration::Allowed, Some(0.8), 0.710_171, [5.468_958_6, 7.547_431_9]),
        (Regeneration::Dissipated, None, 1.327_845, [5.645_121_4, 7.730_148_3]),
    ];
    for (regeneration, efficiency, published, [stiffness, offset]) in cases {
        let mut robot = robot(motion.clone(), GearModel::IDEAL);
        (robot.bus.voltage, robot.bus.drive_current, robot.bus.drive_efficiency) = (48.0, Some(100.0), 0.95);
        (robot.bus.regeneration, robot.bus.regeneration_efficiency) = (regeneration, efficiency);
        let joint = &mut robot.joints[0];
        joint.objective = Objective::single(Quantity::Energy);
        joint.limits.actuator_mass = Some(4.0);
        joint.ratio = RatioChoice::gears(vec!["*".into()], EfficiencyCovers::LoadAndGear);
        let mut sprung = robot.clone();
        sprung.joints[0].motion = motion.with_spring(stiffness, offset / stiffness).unwrap().into();
        let swept = sweep(&sprung, &catalog, 1);
        let mut all: Vec<(f64, &str, &str)> = swept[0]
            .designs
            .iter()
            .filter(|d| d.evaluation.feasible)
            .map(|d| (d.evaluation.energy.unwrap(), d.motor.id.as_str(), d.gear.unwrap_or("")))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(b.1)));
        println!("{} pairs at the spring of the best; {:?}", all.len(), &all[..3]);
        assert!((all[0].0 / published - 1.0).abs() < 2e-6, "{:?}", all[0]);
        let mut few = catalog.clone();
        few.motors.retain(|motor| all[..12].iter().any(|pair| pair.1 == motor.id));
        few.gears.retain(|gear| all[..12].iter().any(|pair| pair.2 == gear.id));
        robot.joints[0].limits.spring =
            Some(Spring { stiffness: [0.0, 20.0], rest_angle: [-3.0, 3.0], ..crate::common::SPRING });
        let result = &optimize(&robot, &few).joints[0];
        let best = result.designs().next().unwrap();
        let spring = best.spring.as_ref().unwrap();
        println!("{} + {:?}: {} J, {spring:?}", best.motor.id, best.gear, best.optimum.objective);
        assert!((best.optimum.objective / published - 1.0).abs() < 2e-6, "{}", best.optimum.objective);
    }
}

/// Which of our defaults are on.
#[derive(Clone, Copy, Default)]
struct Defaults {
    rated: bool,
    gear_inertia_apart: bool,
    in_time: bool,
    inductance: bool,
    heat: bool,
    gear_continuous: bool,
}

/// Feasible pairs of motor and gear with their loss \[W\], best first, and what the others fail.
type Ranking = (Vec<(String, f64)>, BTreeMap<&'static str, usize>);

fn ranking(catalog: &Catalog, motions: &[Motion; 2], on: Defaults) -> Ranking {
    let catalog_rated = |id: &str| catalog.motors.iter().find(|m| m.id == id)?.continuous_current;
    let mut catalog = catalog.clone();
    for motor in &mut catalog.motors {
        if !on.inductance {
            motor.inductance = Some(0.0);
        }
        if !on.rated {
            (motor.continuous_current, motor.continuous_torque, motor.peak_torque) = (None, None, None);
        }
        if !on.heat {
            (motor.thermal_resistance, motor.max_winding_temperature) = (None, None);
            motor.sheet.thermal_time_constant_winding = None;
        }
    }
    for gear in &mut catalog.gears {
        if gear.continuous_torque.is_some_and(|t| t < 0.77386) {
            gear.peak_torque = Some(1e-9);
        }
        if !on.gear_continuous {
            gear.continuous_torque = None;
        }
    }
    let mut robot = robot(motions[usize::from(on.in_time)].clone(), GearModel::IDEAL);
    robot.bus.voltage = 24.0;
    robot.bus.drive_current = Some(80.0);
    // The database says no highest temperature: 125 degC, a usual class of insulation.
    robot.joints[0].limits.winding_temperature = on.heat.then_some(398.15);
    let covers = if on.gear_inertia_apart { EfficiencyCovers::Load } else { EfficiencyCovers::LoadAndGear };
    robot.joints[0].ratio = RatioChoice::gears(vec!["*".into()], covers);
    let later = ["tm-ak-60-6", "tm-ak-80-6", "tm-u8-kv100"];
    let swept = sweep(&robot, &catalog, 1);
    let (mut feasible, mut fails) = (Vec::new(), BTreeMap::new());
    for design in swept[0].designs.iter().filter(|d| !later.contains(&d.motor.id.as_str())) {
        if design.evaluation.feasible {
            feasible
                .push((format!("{} + {}", design.motor.id, design.gear.unwrap_or("")), design.evaluation.copper_loss));
        }
        for margin in design.evaluation.margins.iter().filter(|m| m.margin < -1e-9) {
            *fails.entry(margin.limit).or_insert(0) += 1;
        }
    }
    let published = swept[0].designs.iter().filter(|d| !later.contains(&d.motor.id.as_str()));
    let lightest = published.filter(|d| d.evaluation.feasible && d.evaluation.mass.is_some());
    let lightest = lightest.min_by(|a, b| a.evaluation.mass.unwrap().total_cmp(&b.evaluation.mass.unwrap())).unwrap();
    let rated = catalog_rated(&lightest.motor.id).map(|i| lightest.evaluation.rms_current / i);
    println!(
        "\nlightest: {} + {}, {:.3} kg, {:.3} W, rms current over rated {rated:.3?}",
        lightest.motor.id,
        lightest.gear.unwrap_or(""),
        lightest.evaluation.mass.unwrap(),
        lightest.evaluation.copper_loss
    );
    feasible.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    (feasible, fails)
}

/// The figures of docs/cords.md: `cargo test --release --test program cords -- --ignored --nocapture`.
#[test]
#[ignore = "prints figures; needs the database"]
fn what_our_defaults_change() {
    let Some((catalog, motions)) = problem() else {
        println!("not run: GEARWISE_SHARED names no folder with mgdb and cases/cords");
        return;
    };
    let known = |f: fn(&gearwise::catalog::Motor) -> bool| catalog.motors.iter().filter(|m| f(m)).count();
    println!(
        "{} motors: rated current {}, rated torque {}, inductance {}, with pole pairs {}, thermal resistance {}, highest winding \
         temperature {}, both nodes with time constants {}",
        catalog.motors.len(),
        known(|m| m.continuous_current.is_some()),
        known(|m| m.continuous_torque.is_some()),
        known(|m| m.inductance.is_some()),
        known(|m| m.inductance_and_poles().is_some()),
        known(|m| m.thermal_resistance.is_some()),
        known(|m| m.max_winding_temperature.is_some()),
        known(|m| m.sheet.thermal_time_constant_winding.is_some() && m.thermal_resistance.is_some()),
    );
    let none = Defaults::default();
    let stages = [
        ("as published", none),
        ("a: rated current and torque", Defaults { rated: true, ..none }),
        ("b: gear inertia outside the efficiency", Defaults { gear_inertia_apart: true, ..none }),
        ("means by the trapezoid rule", Defaults { in_time: true, ..none }),
        ("c: inductance", Defaults { in_time: true, inductance: true, ..none }),
        ("d: heat", Defaults { heat: true, ..none }),
        ("e: gear's continuous torque", Defaults { gear_continuous: true, ..none }),
        (
            "all",
            Defaults {
                rated: true,
                gear_inertia_apart: true,
                in_time: true,
                inductance: true,
                heat: true,
                gear_continuous: true,
            },
        ),
    ];
    let (base, _) = ranking(&catalog, &motions, none);
    assert_eq!(base.len(), 1312);
    for (name, on) in stages {
        let (found, fails) = ranking(&catalog, &motions, on);
        let place = |pair: &str, list: &[(String, f64)]| list.iter().position(|x| x.0 == pair).map(|i| i + 1);
        let common: Vec<(f64, f64)> =
            base.iter().filter_map(|(pair, loss)| Some((*loss, found[place(pair, &found)? - 1].1))).collect();
        let (a, b): (Vec<f64>, Vec<f64>) = common.iter().copied().unzip();
        let change = common.iter().map(|(a, b)| b / a - 1.0);
        let most = change.clone().fold(f64::NEG_INFINITY, f64::max);
        let least = change.fold(f64::INFINITY, f64::min);
        let left = base.iter().filter(|(pair, _)| place(pair, &found).is_none()).count();
        println!(
            "{name}: {} feasible ({left} of the published left out), Kendall's tau over the {} in both {:?}, loss changes by {:.2} \
             to {:.2} %\n  fails {fails:?}",
            found.len(),
            common.len(),
            gearwise::design::agreement::kendall_tau(&a, &b),
            100.0 * least,
            100.0 * most,
        );
        let moved: Vec<_> = base.iter().take(10).map(|(pair, _)| place(pair, &found)).collect();
        println!("  the published top ten are now at {moved:?}");
        for (i, (pair, loss)) in found.iter().take(10).enumerate() {
            println!("  {:2} {pair}  {loss:.4} W, was {:?}", i + 1, place(pair, &base));
        }
    }
}
