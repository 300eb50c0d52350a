//! What a new entry of a list has to be known to beyond its list: these tests fail where one was forgotten.
//! (Rules of limits are in `check.rs`, effects in their own room, keys and pages in `docs.rs`.)

use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize;
use gearwise::requirement::{self, Objective, Quantity};

use crate::common::repository;

/// A quantity that an objective is made of is minimised by the ratio program (with a spring, by its program) and
/// evaluated for a design: one that the program does not know would be certified at any ratio.
#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn every_quantity_of_an_objective_is_minimised_as_it_is_evaluated() {
    let mut catalog = Catalog::builtin().unwrap();
    catalog.motors.retain(|m| ["t-motor-u8-lee", "mit-mini-cheetah"].contains(&m.id.as_str()));
    for (file, joint) in [("quadruped_mini_cheetah", 2), ("ankle_prosthesis_parallel_spring", 0)] {
        let mut robot = requirement::read(&repository(&format!("requirements/{file}.toml"))).unwrap();
        robot.joints = vec![robot.joints.remove(joint)];
        for (name, quantity) in Quantity::NAMES {
            let mut weighted = vec![(Quantity::CopperLoss, 0.01), (Quantity::ReflectedInertia, 0.1), (*quantity, 0.01)];
            weighted.sort_unstable_by_key(|(quantity, _)| *quantity);
            weighted.dedup_by_key(|(quantity, _)| *quantity);
            for objective in [Objective::single(*quantity), Objective { terms: weighted }] {
                robot.joints[0].objective = objective;
                let result = optimize(&robot, &catalog);
                let designs = &result.joints[0].candidates;
                assert!(!designs.is_empty(), "{file}, {name}: no design");
                for design in designs {
                    let minimised = design.optimum.objective;
                    let evaluated = design.evaluation.objective(&robot.joints[0].objective).unwrap();
                    let off = (minimised - evaluated).abs() / evaluated.abs();
                    assert!(off < 1e-6, "{file}, {name}, {}: {minimised} but {evaluated}", design.motor.id);
                }
            }
        }
    }
}
