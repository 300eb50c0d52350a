//! What each part of a fitted motor moves: against the choice for a motor that was made without it.

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::optimize;
use gearwise::design::remake::{Part, remake};
use gearwise::effects::FittedEffect;
use gearwise::requirement;

#[test]
fn a_share_is_the_choice_for_the_motor_without_that_part() {
    let robot = requirement::read("requirements/bench/leg_joint.toml".as_ref()).unwrap();
    let catalog = Catalog::builtin().unwrap();
    let declared = catalog.motor("t-motor-ri50").unwrap().clone();
    let cogging = FittedEffect::new("cogging", vec![0.03, 0.02, 12.0]).unwrap();
    let constant = 0.95 * declared.torque_constant;
    let fitted = Motor {
        coulomb_friction: Some(0.02),
        viscous_friction: Some(0.0),
        effects: vec![cogging.clone()],
        torque_constant: constant,
        ..declared.clone()
    };
    let remade = &remake(&robot, &catalog, &declared.id, &fitted)[0];
    let parts: Vec<&Part> = remade.shares.iter().map(|share| &share.part).collect();
    assert_eq!(parts, [&Part::Effect(cogging), &Part::Friction, &Part::Numbers]);
    // Each by a catalogue of that motor alone.
    let alone = |motor: Motor| {
        let only = Catalog::of(vec![motor], Vec::new());
        let found = optimize(&robot, &only);
        let design = &found.joints[0].candidates[0];
        (design.optimum.ratio, design.optimum.objective, design.evaluation.loss)
    };
    let completed = |motor: Motor| gearwise::actuator::estimate::completed(motor);
    let drag = completed(declared.clone()).no_load_torque;
    let without = [
        Motor { effects: Vec::new(), ..fitted.clone() },
        Motor { coulomb_friction: drag, viscous_friction: None, ..fitted.clone() },
        Motor { torque_constant: declared.torque_constant, ..fitted.clone() },
    ];
    for (share, motor) in remade.shares.iter().zip(without) {
        let chosen = share.without.as_ref().unwrap();
        let (ratio, objective, loss) = alone(completed(motor));
        assert!((chosen.ratio / ratio - 1.0).abs() < 1e-6, "{:?}: {} {ratio}", share.part, chosen.ratio);
        assert!((chosen.objective / objective - 1.0).abs() < 1e-9, "{:?}", share.part);
        assert!((chosen.loss / loss - 1.0).abs() < 1e-6, "{:?}", share.part);
    }
    // The curves are those of the objective where all limits are kept, and no point of them is below the best.
    for (curve, choice) in remade.curves.iter().zip([remade.before.as_ref(), Some(&remade.after)]) {
        let best = choice.unwrap().outcome.as_ref().unwrap();
        assert!(curve.len() > 20 && curve.iter().all(|p| p.1 >= best.objective * (1.0 - 1e-9)));
    }
    // A motor that is as its row says has no part that moves anything.
    let same = &remake(&robot, &catalog, &declared.id, &declared)[0];
    assert!(same.shares.is_empty());
}
