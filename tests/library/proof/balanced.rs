//! The balanced objective against a plain search over motors and ratios.

use gearwise::actuator::estimate::complete;
use gearwise::catalog::Catalog;
use gearwise::design::balance::balanced;
use gearwise::design::options::Options;
use gearwise::design::{JointDemand, Site, grid, optimize};
use gearwise::requirement::{self, Balancing, RatioChoice};

use crate::common::repository;

#[test]
fn the_balanced_choice_is_that_of_a_plain_search() {
    let catalog = complete(Catalog::builtin().unwrap().free(false));
    let robot = requirement::read(&repository("tests/golden/quadruped_knee.toml")).unwrap();
    let made = balanced(&robot, &catalog, Options::default()).unwrap();
    let Balancing::Made(balance) = &made.joints[0].balancing else { panic!("it is balanced") };
    // Loss and mass of every feasible design of a grid, and of the end of the first stage.
    let joint = &robot.joints[0];
    let demand = JointDemand::new(joint, &catalog);
    let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
    let mut all: Vec<(f64, f64)> = Vec::new();
    for motor in &catalog.motors {
        let Ok(prepared) = Site::new(&robot, joint, &demand).direct(motor).prepared() else { continue };
        for ratio in grid(min, max, 2000).into_iter().chain([10.0]) {
            let here = prepared.at(ratio);
            let judged = prepared.judged(ratio).unchecked.iter().all(|(name, _)| !name.contains("temperature"));
            if let (true, true, Some(mass)) = (here.feasible, judged, here.mass) {
                all.push((here.loss, mass));
            }
        }
    }
    let lightest = all.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.total_cmp(&b.0))).unwrap();
    let least = all.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 5e-3;
    assert!(near(balance.lightest.mass, lightest.1) && near(balance.lightest.loss, lightest.0), "{lightest:?}");
    assert!(near(balance.least_loss.loss, least.0) && near(balance.least_loss.mass, least.1), "{least:?}");
    assert!((balance.loss.powi(2) / (balance.lightest.loss * balance.least_loss.loss) - 1.0).abs() < 1e-12);
    assert!((balance.mass.powi(2) / (balance.lightest.mass * balance.least_loss.mass) - 1.0).abs() < 1e-12);
    let value = |(loss, mass): (f64, f64)| loss / balance.loss + mass / balance.mass;
    let best = all.iter().copied().map(value).fold(f64::INFINITY, f64::min);
    let result = optimize(&made, &catalog);
    let found = &result.joints[0].candidates[0];
    assert!(
        (value((found.evaluation.loss, found.evaluation.mass.unwrap())) / found.optimum.objective - 1.0).abs() < 1e-9
    );
    assert!(found.optimum.objective <= best * (1.0 + 1e-9) && near(found.optimum.objective, best), "{best}");
}

/// Where the mass of the best is not known there is nothing to balance, and that is said: the least loss counts.
#[test]
fn without_masses_the_least_loss_counts_and_that_is_said() {
    let mut catalog = complete(Catalog::builtin().unwrap().free(false));
    catalog.motors.retain(|m| m.id == "tq-robodrive-ilm-85x26");
    catalog.motors[0].mass = None;
    let mut robot = requirement::read(&repository("tests/golden/quadruped_knee.toml")).unwrap();
    robot.joints[0].limits.actuator_mass = None;
    let made = balanced(&robot, &catalog, Options::default()).unwrap();
    assert!(
        matches!(made.joints[0].balancing, Balancing::Cannot(why) if why.contains("mass")),
        "{:?}",
        made.joints[0].balancing
    );
    assert_eq!(optimize(&made, &catalog).joints[0].candidates.len(), 1);
}
