use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::*;
use crate::best::best_design;
use crate::mount::{JointDemand, Site};
use crate::robot::carry;
use crate::robot::power::Profile;
use gearwise_model::catalog::{Catalog, Motor};
use gearwise_model::input::Source;
use gearwise_model::requirement::{Robot, read_source};

/// Two joints of which the first carries the second: its load may flip its sign with the mass.
fn robot(random: &mut Pcg64, objective: &str) -> Robot {
    let mut within = |a: f64, b: f64| random.random_range(a..b);
    let samples = 24;
    let (lift, turn, level) = (within(1.0, 12.0), within(0.0, 6.0), within(-8.0, 8.0));
    let (speed, late) = (within(1.0, 5.0), within(0.0, 6.0));
    let (constant, course) = (within(-6.0, 8.0), within(-5.0, 5.0));
    let mut rows =
        "time [s],torque [N*m],velocity [rad/s],acceleration [rad/s^2],torque_per_mass_wrist [N*m/kg]\n".to_string();
    for k in 0..samples {
        let t = k as f64 / samples as f64;
        let w = std::f64::consts::TAU;
        rows += &format!(
            "{t},{},{},{},{}\n",
            lift * (w * t + turn).sin() + level,
            speed * (w * t + late).sin(),
            speed * w * (w * t + late).cos(),
            constant + course * (w * t).cos()
        );
    }
    rows += &rows.lines().nth(1).unwrap().replacen('0', "1", 1);
    let limits = match within(0.0, 1.0) {
        share if share < 0.5 => "",
        _ => "\n[joint.limits]\nwinding_temperature = \"100 degC\"",
    };
    let text = format!(
        r#"name = "two"
[bus]
voltage = "{} V"
drive_efficiency = {}
regeneration = "allowed"
[[joint]]
name = "shoulder"
ratio = {{ min = 3, max = {} }}
gear = {{ efficiency = {}, mass = "300 g", inertia = "1e-5 kg*m^2" }}
motion = "m.csv"
objective = {objective}{limits}
[[joint]]
name = "wrist"
ratio = {{ min = 3, max = 30 }}
gear = {{ efficiency = 0.8, mass = "300 g" }}
objective = {objective}
points = [{{ torque = "2 N*m", speed = "1 rad/s", duration = "1 s" }}]
"#,
        within(18.0, 60.0),
        within(0.85, 1.0),
        within(20.0, 120.0),
        within(0.55, 0.95),
    );
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.csv"), rows).unwrap();
    let path = folder.path().join("r.toml");
    read_source(&Arc::new(Source::new(path.to_str().unwrap(), text))).unwrap_or_else(|e| panic!("{e:?}"))
}

/// At any masses in the box the best that there is costs no less than the bound says.
#[test]
fn a_tangent_is_below_the_best_at_every_load_of_its_box() {
    let catalog = Catalog::builtin().unwrap();
    let mut random = Pcg64::seed_from_u64(7);
    let objectives = [
        "\"loss\"",
        "\"copper_loss\"",
        "\"energy\"",
        "\"peak_current\"",
        "\"peak_power\"",
        "{ copper_loss = 0.3, reflected_inertia = 2.0 }\nreference = { copper_loss = \"1 W\", reflected_inertia = \"1 kg*m^2\" }",
        "{ loss = 0.3, peak_current = 1.0, mass = 2.0 }\nreference = { loss = \"1 W\", peak_current = \"1 A\", mass = \"1 kg\" }",
    ];
    let motors: Vec<&Motor> = catalog.motors.iter().collect();
    let saturating: Vec<&Motor> = motors.iter().copied().filter(|m| m.saturation_current().is_some()).collect();
    let (mut looked, mut near, mut flips, mut priced, mut none, mut bent) = (0, 0, 0, 0, 0, 0);
    for case in 0..760 {
        let robot = robot(&mut random, objectives[case % objectives.len()]);
        let joint = &robot.joints[0];
        let directions = carry::directions_of(joint);
        let from = random.random_range(0.2..2.0);
        let masses = (-random.random_range(0.0..0.2), random.random_range(0.0..1.5));
        let price = random.random_range(-3.0..6.0);
        let at = |mass: f64| carry::loaded(joint, &carry::coordinates(joint, |_| mass));
        let center = at(from);
        let demand = JointDemand::new(&center, &catalog);
        let all = if case % 4 == 3 { &saturating } else { &motors };
        let motor = all[random.random_range(0..all.len())];
        let site = Site::new(&robot, &center, &demand);
        let range = center.ratio.range().unwrap();
        let Some(tangent) = Tangent::new(site.direct(motor), &directions, &center.objective, range) else {
            continue;
        };
        let (masses, prices) = ([masses], [price]);
        let over = Over { masses: &masses, prices: &prices, enough: f64::INFINITY, divisions: 200 };
        let plain = tangent.least(over);
        let optimum = best_design(site, motor, false).ok().map(|design| design.optimum);
        let at_end = optimum.as_ref().filter(|o| (o.ratio / o.window().max - 1.0).abs() < 1e-6);
        let limit = at_end.map(|o| (o.ratio, o.window().high.limit));
        let bound = match limit {
            Some((ratio, limit)) => {
                let tangent = tangent.with_price(ratio, limit);
                priced += usize::from(tangent.priced.is_some());
                plain.max(tangent.least(over))
            }
            None => plain,
        };
        for step in 0..=10 {
            let moved = masses[0].0 + (masses[0].1 - masses[0].0) * f64::from(step) / 10.0;
            let loaded = at(from + moved);
            flips +=
                usize::from((0..loaded.motion.len()).any(|k| loaded.motion.torque[k] * center.motion.torque[k] < 0.0));
            let demand = JointDemand::new(&loaded, &catalog);
            let Ok(design) = best_design(Site::new(&robot, &loaded, &demand), motor, false) else {
                none += 1;
                continue;
            };
            let least = design.optimum.objective - price * moved;
            let size = design.optimum.objective.abs().max((price * moved).abs());
            assert!(bound <= least + 1e-8 * size, "case {case}, {}: {bound} at +{moved}: {least}", motor.id);
            looked += 1;
            near += usize::from(least - bound < 0.02 * size);
            bent += usize::from(least - bound < 0.02 * size && motor.saturation_current().is_some());
        }
    }
    println!(
        "{looked} loads, {none} infeasible; {near} within 2 % of the bound, {bent} of them saturated, {flips} with a flip, {priced} bounds with a price"
    );
    assert!(looked > 500 && near > 100 && bent > 20 && flips > 100 && priced > 5 && none > 100);
}

/// With prices on the power of some samples, too: at any masses in the box and any ratio that keeps the limits.
#[test]
fn with_priced_power_a_tangent_is_below_all_ratios_at_every_load_of_its_box() {
    let catalog = Catalog::builtin().unwrap();
    let mut random = Pcg64::seed_from_u64(11);
    let motors: Vec<&Motor> = catalog.motors.iter().collect();
    let saturating: Vec<&Motor> = motors.iter().copied().filter(|m| m.saturation_current().is_some()).collect();
    let (mut looked, mut near, mut flips) = (0, 0, 0);
    for case in 0..300 {
        let robot = robot(&mut random, ["\"loss\"", "\"copper_loss\"", "\"mass\""][case % 3]);
        let joint = &robot.joints[0];
        let directions = carry::directions_of(joint);
        let from = random.random_range(0.2..2.0);
        let masses = (-random.random_range(0.0..0.2), random.random_range(0.0..1.5));
        let price = random.random_range(-3.0..6.0);
        let samples = joint.motion.len();
        let power = [(); 2].map(|()| (random.random_range(0..samples), random.random_range(0.0..0.5)));
        let at = |mass: f64| carry::loaded(joint, &carry::coordinates(joint, |_| mass));
        let center = at(from);
        let demand = JointDemand::new(&center, &catalog);
        let all = if case % 5 == 4 { &saturating } else { &motors };
        let motor = all[random.random_range(0..all.len())];
        let range = center.ratio.range().unwrap();
        let site = Site::new(&robot, &center, &demand);
        let Some(tangent) = Tangent::new(site.direct(motor), &directions, &center.objective, range) else { continue };
        let (masses, prices) = ([masses], [price]);
        let over = Over { masses: &masses, prices: &prices, enough: f64::INFINITY, divisions: 200 };
        let bound = tangent.with_power(&power).least(over);
        for step in 0..=8 {
            let moved = masses[0].0 + (masses[0].1 - masses[0].0) * f64::from(step) / 8.0;
            let loaded = at(from + moved);
            flips += usize::from((0..samples).any(|k| loaded.motion.torque[k] * center.motion.torque[k] < 0.0));
            let demand = JointDemand::new(&loaded, &catalog);
            let site = Site::new(&robot, &loaded, &demand);
            let Ok(design) = best_design(site, motor, false) else { continue };
            let prepared = site.direct(motor).prepared().unwrap();
            let mut least = (f64::INFINITY, 0.0);
            for window in &design.optimum.windows {
                for k in 0..=80 {
                    let n = window.min * (window.max / window.min).powf(f64::from(k) / 80.0);
                    let objective = prepared.at(n).objective(&loaded.objective).unwrap();
                    let profile = Profile::of(&prepared, n);
                    let drawn: Vec<f64> = power.iter().map(|(k, price)| price * profile.at(*k, n).0).collect();
                    let size = objective.abs() + drawn.iter().map(|w| w.abs()).sum::<f64>() + (price * moved).abs();
                    let value = objective + drawn.iter().sum::<f64>() - price * moved;
                    least = if value < least.0 { (value, size) } else { least };
                }
            }
            assert!(bound <= least.0 + 1e-8 * least.1, "case {case}, {}: {bound} at +{moved}: {least:?}", motor.id);
            looked += 1;
            near += usize::from(least.0 - bound < 0.02 * least.1);
        }
    }
    println!("{looked} loads; {near} within 2 % of the bound, {flips} with a flip");
    assert!(looked > 200 && near > 50 && flips > 100);
}
