//! A search that is stopped has no answer, wherever it is asked, and asks soon; one that nobody stops is the same as without.

use std::sync::atomic::{AtomicUsize, Ordering};

use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize_with;
use gearwise::design::options::{Options, Stopped};
use gearwise::design::pareto::fronts;
use gearwise::design::robot::{self, NoChoice, choose};
use gearwise::design::robust::robust;
use gearwise::design::sweep::sweep_with;
use gearwise::requirement::{Quantity, Regeneration, Robot};

use crate::common;

fn shipped(name: &str) -> Robot {
    gearwise::requirement::read(&common::repository(&format!("requirements/{name}.toml"))).unwrap()
}

/// A few motors: what is asked is not how long all of them take.
fn few() -> Catalog {
    let mut catalog = Catalog::builtin().unwrap();
    catalog.motors.truncate(12);
    catalog
}

#[test]
fn every_search_ends_where_it_is_stopped() {
    let (robot, catalog) = (shipped("quadruped_mini_cheetah"), few());
    let stop = || true;
    let options = Options { stop: &stop, ..Options::default() };
    assert_eq!(optimize_with(&robot, &catalog, options).unwrap_err(), Stopped);
    assert_eq!(optimize_with(&robot, &catalog, Options { keep: Some(2), ..options }).unwrap_err(), Stopped);
    assert_eq!(sweep_with(&robot, &catalog, 5, options).unwrap_err(), Stopped);
    assert_eq!(fronts(&robot, &catalog, &[Quantity::CopperLoss, Quantity::Mass], 5, options).unwrap_err(), Stopped);
    assert_eq!(robust(&robot, &catalog, options).unwrap_err(), Stopped);
    let options = robot::Options { stop: &stop, ..robot::Options::default() };
    assert_eq!(choose(&robot, &catalog, options).unwrap_err(), NoChoice::Stopped);
}

/// How often a search asks, of one motor in one thread, and that it ends at each of these times.
fn asks(robot: &Robot, catalog: &Catalog) -> usize {
    let asked = AtomicUsize::new(0);
    let count = || {
        asked.fetch_add(1, Ordering::Relaxed);
        false
    };
    let free = optimize_with(robot, catalog, Options { stop: &count, ..Options::default() }).unwrap();
    assert_eq!(format!("{free:?}"), format!("{:?}", optimize_with(robot, catalog, Options::default()).unwrap()));
    let often = asked.load(Ordering::Relaxed);
    for last in (0..often).step_by((often / 5).max(1)) {
        let asked = AtomicUsize::new(0);
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= last;
        assert_eq!(optimize_with(robot, catalog, Options { stop: &stop, ..Options::default() }).unwrap_err(), Stopped);
        // It asks for the joint's motors again, and looks at no further node.
        assert!(
            asked.load(Ordering::Relaxed) <= last + 4,
            "asked {} times after {last}",
            asked.load(Ordering::Relaxed)
        );
    }
    often
}

#[test]
fn branch_and_bound_asks_at_each_node() {
    let mut robot = shipped("quadruped_mini_cheetah");
    robot.joints.truncate(1);
    robot.bus.regeneration = Regeneration::Limited(50.0);
    let mut catalog = Catalog::builtin().unwrap();
    let feasible = optimize_with(&robot, &catalog, Options::default()).unwrap();
    let Some(first) = feasible.joints[0].candidates.first().map(|d| d.motor.id.clone()) else { panic!("no motor") };
    catalog.motors.retain(|m| m.id == first);
    let often = asks(&robot, &catalog);
    assert!(often > 1, "{often}");
}

#[test]
fn the_search_for_a_spring_asks_at_each_region() {
    let mut robot = shipped("ankle_prosthesis_parallel_spring");
    robot.joints.truncate(1);
    let mut catalog = Catalog::builtin().unwrap();
    let feasible = optimize_with(&robot, &catalog, Options::default()).unwrap();
    let Some(first) = feasible.joints[0].candidates.first().map(|d| d.motor.id.clone()) else { panic!("no motor") };
    catalog.motors.retain(|m| m.id == first);
    let often = asks(&robot, &catalog);
    assert!(often > 1, "{often}");
}
