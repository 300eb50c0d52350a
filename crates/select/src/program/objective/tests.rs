use super::*;
use crate::{Mount, Prepared};
use gearwise_model::actuator::Load;
use gearwise_model::catalog::Catalog;
use gearwise_model::requirement::{self, Objective};

/// In sums over joints every objective is in its own unit, that of an evaluation; its cuts touch it and are nowhere above
/// it, up to the mass that steps by stages.
#[test]
fn cuts_for_sums_touch_the_objective_and_are_below_it() {
    let catalog = Catalog::builtin().unwrap();
    let mut robot = requirement::read(
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../requirements/quadruped_mini_cheetah.toml").as_ref(),
    )
    .unwrap();
    let weighted = Objective {
        terms: vec![
            (Quantity::Loss, 0.3),
            (Quantity::Mass, 2.0),
            (Quantity::PeakCurrent, 0.7),
            (Quantity::Energy, 1e-3),
            (Quantity::PeakPower, 0.02),
            (Quantity::ReflectedInertia, 5.0),
        ],
    };
    let ratios = [1.0, 2.9, 3.1, 6.0, 8.9, 9.1, 17.0, 40.0, 100.0];
    let (mut kinks, mut steps) = (0, 0);
    robot.joints[1].gear.mass_per_stage = Some((0.15, 3.0));
    for joint in &robot.joints {
        let load = Load::new(&joint.motion, joint.ripple());
        let motor = catalog.motor("t-motor-ri50").unwrap();
        let prepared = Prepared::new(Mount::new(&robot, joint, &load, motor).candidate().unwrap());
        for objective in [
            Objective::single(Quantity::Loss),
            Objective::single(Quantity::PeakCurrent),
            Objective::single(Quantity::Energy),
            Objective::single(Quantity::PeakPower),
            Objective::single(Quantity::Mass),
            Objective::single(Quantity::ReflectedInertia),
            weighted.clone(),
        ] {
            let program = RatioProgram::new(&prepared, &objective, 1.0, 100.0);
            let mut cuts = Vec::new();
            for at in ratios {
                let value = program.objective_at(at);
                let evaluated = prepared.at_in_full(at).objective(&objective);
                if let Some(evaluated) = evaluated {
                    assert!((value / evaluated - 1.0).abs() < 1e-9, "{} {objective:?} {at}", joint.name);
                }
                let (cut, step) = program.objective_cut(at);
                assert!((cut.at(at) + step - value).abs() < 1e-12 * value.abs().max(cut.size(at)));
                for other in ratios {
                    let (_, of_stages) = program.objective_cut(other);
                    let above = cut.at(other) + of_stages - program.objective_at(other);
                    assert!(above <= 1e-9 * cut.size(other), "{} {objective:?} {at} {other}: {above}", joint.name);
                }
                steps += usize::from(step > 0.0);
                cuts.push(cut);
            }
            kinks += usize::from(cuts.windows(2).any(|pair| pair[0] != pair[1]));
        }
    }
    assert!(kinks > 3 && steps > 9, "{kinks} {steps}");
}
