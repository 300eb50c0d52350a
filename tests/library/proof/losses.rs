//! Losses: the balance of power, what of them is not negative, and what is said where nobody knows.

use gearwise::actuator::Load;
use gearwise::actuator::estimate;
use gearwise::catalog::convention::Commutation;
use gearwise::catalog::drag::{Drag, Friction};
use gearwise::catalog::estimate::Estimated;
use gearwise::catalog::{Catalog, Motor, Printed};
use gearwise::design::answer::JointResult;
use gearwise::design::optimize::optimize;
use gearwise::design::{Mount, Prepared};
use gearwise::requirement::{MotorDrag, Objective, Quantity, RatioChoice, Robot};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::cases::{cases, quarter};
use crate::common;
use crate::raw::{Case, draw};

/// What a random joint is evaluated as at a ratio.
fn with<T>(case: &Case, look: impl FnOnce(&Prepared) -> T) -> T {
    let joint = &case.robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    let candidate = Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap();
    look(&Prepared::new(candidate))
}

/// A motor whose back-EMF constant is its torque constant, with drag known to a number, in a gear that takes some without load,
/// on a drive with losses of every kind.
fn lossy(i: u64) -> Case {
    let mut case = draw(i, i.is_multiple_of(2));
    let mut random = Pcg64::seed_from_u64(i);
    let mut share = |most: f64| random.random_range(0.0..most);
    let torque = case.raw.iter().map(|p| p.torque.abs()).fold(1e-9, f64::max);
    let speed = case.raw.iter().map(|p| p.velocity.abs()).fold(1e-9, f64::max);
    case.motor.back_emf_constant = case.motor.torque_constant;
    (case.motor.coulomb_friction, case.motor.viscous_friction) =
        (Some(share(0.1) * torque), Some(share(0.1) * torque / speed));
    let joint = &mut case.robot.joints[0];
    joint.gear.no_load = Friction { coulomb: share(0.1) * torque, viscous: share(0.1) * torque / speed };
    joint.drive.phase_resistance = Some(share(0.3) * case.motor.resistance);
    joint.drive.standby_power = Some(share(1.0) * torque * speed);
    case
}

/// Mean bus power is mean output power, plus all losses, plus what the kinetic energy of the samples rises by. To rounding, for
/// every drawn joint and ratio; and no part is negative.
#[test]
fn what_is_drawn_is_given_to_the_load_or_lost() {
    let (mut looked, mut worst) = (0, 0.0_f64);
    for i in quarter(300_000, 400) {
        let case = lossy(i);
        let joint = &case.robot.joints[0];
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let Some(duration) = joint.motion.duration() else { continue };
        for n in [min, (min * max).sqrt(), max] {
            let (at, energy) = with(&case, |prepared| (prepared.at(n), prepared.energy(n).unwrap()));
            let mean =
                |f: &dyn Fn(usize) -> f64| -> f64 { (0..case.raw.len()).map(|k| case.shares[k][0] * f(k)).sum() };
            let output = mean(&|k| case.raw[k].torque * case.raw[k].velocity);
            let inertia = case.motor.rotor_inertia.unwrap() + joint.gear.inertia;
            let stored = mean(&|k| n * n * inertia * case.raw[k].acceleration * case.raw[k].velocity);
            let size = mean(&|k| (case.raw[k].torque * case.raw[k].velocity).abs())
                + mean(&|k| (n * n * inertia * case.raw[k].acceleration * case.raw[k].velocity).abs())
                + at.losses.total();
            let apart = (energy / duration - output - stored - at.losses.total()).abs() / size;
            worst = worst.max(apart);
            assert!(apart < 1e-12, "case {i} at {n}: {apart:e}");
            for (part, watts) in at.losses.parts() {
                assert!(watts >= -1e-13 * size, "case {i} at {n}: {part} is {watts} W");
            }
            assert!((at.losses.total() - at.loss).abs() <= 1e-14 * size && at.loss_low == at.loss);
            looked += 1;
        }
    }
    println!("{looked} designs, at most {worst:e} apart");
    assert!(looked > 200);
}

/// Along the segment between its ends a drag makes no more loss than is said, and no less than the least that is said; and every
/// demand in between is kept where the limits are said to be.
#[test]
fn any_drag_between_the_ends_is_between_what_is_said() {
    let (mut looked, mut inside) = (0, 0);
    for i in cases(310_000, 300) {
        let mut case = draw(i, true);
        let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
        let n = (min * max).sqrt();
        let torque = case.raw.iter().map(|p| p.torque.abs()).fold(0.0, f64::max) / n;
        let speed = n * case.raw.iter().map(|p| p.velocity.abs()).fold(0.0, f64::max);
        if torque == 0.0 || speed == 0.0 || case.motor.conventions.commutation == Commutation::Brushed {
            continue;
        }
        let (t_0, at_speed) = (0.3 * torque, [0.2, 0.6, 1.0, 3.0][(i % 4) as usize] * speed);
        (case.motor.coulomb_friction, case.motor.viscous_friction) = (None, None);
        (case.motor.no_load_torque, case.motor.sheet.no_load_speed) =
            (Some(t_0), Some(Printed { value: at_speed, tolerance: None }));
        case.robot.joints[0].motor_drag = MotorDrag::Counted;
        assert_eq!(case.motor.drag(), Drag::NoLoad { torque: t_0, speed: Some(at_speed) });
        let said = with(&case, |prepared| prepared.at(n));
        let mut least = f64::INFINITY;
        for k in 0..=20 {
            let share = f64::from(k) / 20.0;
            let mut known = Case::new(case.motor.clone(), case.robot.clone(), case.raw.clone());
            known.motor.no_load_torque = None;
            known.motor.coulomb_friction = Some((1.0 - share) * t_0);
            known.motor.viscous_friction = Some(share * t_0 / at_speed);
            let at = with(&known, |prepared| prepared.at(n));
            least = least.min(at.loss);
            assert!(
                at.loss <= said.loss * (1.0 + 1e-12) && at.loss >= said.loss_low * (1.0 - 1e-12),
                "case {i}, {share}"
            );
            for (one, of) in at.margins.iter().zip(&said.margins) {
                assert_eq!(one.limit, of.limit);
                // Power that comes back is not convex along the segment (docs/model.md).
                let kept = one.limit == "regeneration" || one.margin >= of.margin - 1e-9 * (1.0 + of.margin.abs());
                assert!(kept, "case {i}, {share}: {} {} {}", one.limit, one.margin, of.margin);
            }
        }
        // The least that is said is met to what the steps of this look leave.
        let by_drive = case.robot.bus.drive_efficiency < 1.0;
        assert!(by_drive || least <= said.loss_low * 1.01 + 1e-12, "case {i}: {least} {}", said.loss_low);
        inside += usize::from(said.loss_low < 0.999 * said.loss.min(least * 1.001));
        looked += 1;
    }
    println!("{looked} joints, {inside} with a range");
    assert!(looked > 40);
}

/// An arm's joint with two motors.
fn choice(motors: Vec<Motor>, change: impl Fn(&mut Robot)) -> (Robot, Catalog) {
    let path = common::repository("requirements/arm_six_axis_pick_and_place.toml");
    let mut robot = gearwise::requirement::read(&path).unwrap();
    robot.joints.truncate(2);
    robot.joints.remove(0);
    robot.joints[0].objective = Objective::single(Quantity::Loss);
    robot.joints[0].balancing = gearwise::requirement::Balancing::No;
    change(&mut robot);
    (robot, Catalog::of(motors, Vec::new()))
}

fn shipped(id: &str) -> Motor {
    Catalog::builtin().unwrap().motor(id).unwrap().clone()
}

/// A motor of whose drag nobody knows is no choice by loss, however little it would lose without any; by copper loss and with
/// the drag turned off it is one; an estimate judges it, and is worse than without.
#[test]
fn silence_about_drag_is_no_advantage() {
    let mut silent = shipped("maxon-ec-i-52-634043");
    silent.id = "silent".into();
    (silent.no_load_torque, silent.sheet.no_load_current, silent.about.construction) = (None, None, None);
    let known = shipped("maxon-ec-i-52-634043");
    let first = |result: &JointResult| result.candidates.first().map(|d| d.motor.id.clone());
    let apart = |result: &JointResult| {
        let named = |u: &gearwise::design::answer::Unjudged| u.because.iter().any(|(what, _)| *what == "motor_drag");
        result.unjudged.iter().filter(|u| named(u)).map(|u| u.motor.id.clone()).collect::<Vec<_>>()
    };
    let (robot, catalog) = choice(vec![silent.clone(), known.clone()], |_| {});
    let found = optimize(&robot, &catalog);
    assert_eq!(
        (first(&found.joints[0]).as_deref(), apart(&found.joints[0])),
        (Some("maxon-ec-i-52-634043"), vec!["silent".to_string()])
    );
    for change in [
        |robot: &mut Robot| robot.joints[0].objective = Objective::single(Quantity::CopperLoss),
        |robot: &mut Robot| robot.joints[0].motor_drag = MotorDrag::Off,
    ] {
        let (robot, catalog) = choice(vec![silent.clone(), known.clone()], change);
        let found = optimize(&robot, &catalog);
        assert!(apart(&found.joints[0]).is_empty() && found.joints[0].candidates.len() == 2);
    }
    // With its construction the same motor is estimated, and loses more than it would without drag.
    let mut told = silent.clone();
    told.about.construction = known.about.construction;
    let told = estimate::completed(told);
    assert!(told.is_estimated(Estimated::Drag));
    let (robot, catalog) = choice(vec![told, known.clone()], |_| {});
    let found = optimize(&robot, &catalog);
    let loss = |id: &str| found.joints[0].candidates.iter().find(|d| d.motor.id == id).unwrap().evaluation.clone();
    let (estimated, printed) = (loss("silent"), loss("maxon-ec-i-52-634043"));
    assert!(estimated.losses.motor_drag > 0.0 && estimated.loss_low < estimated.loss);
    // The interval's end is above what its sheet says, which is in the law.
    assert!(estimated.loss > printed.loss, "{} {}", estimated.loss, printed.loss);
}

/// Without drag data, and with the drag turned off, the least copper loss has the ratio that it has without any of this.
#[test]
fn copper_loss_is_what_loss_was() {
    let off = |robot: &mut Robot| {
        robot.joints[0].objective = Objective::single(Quantity::CopperLoss);
        robot.joints[0].motor_drag = MotorDrag::Off;
    };
    for mut motor in Catalog::builtin().unwrap().motors {
        let Some(_) = motor.rotor_inertia else { continue };
        let (robot, catalog) = choice(vec![motor.clone()], off);
        let with = optimize(&robot, &catalog);
        (motor.no_load_torque, motor.sheet.no_load_current, motor.sheet.no_load_speed) = (None, None, None);
        let (mut robot, catalog) = choice(vec![motor], off);
        robot.joints[0].motor_drag = MotorDrag::Counted;
        let without = optimize(&robot, &catalog);
        let ratio = |of: &gearwise::design::answer::RobotResult| {
            of.joints[0].designs().next().map(|d| d.optimum.ratio.to_bits())
        };
        assert_eq!(ratio(&with), ratio(&without), "{}", catalog.motors[0].id);
    }
}

/// A motor of 0.1 N·m/A and 1 Ω without rotor to speak of, with a no-load torque at a no-load speed.
fn with_no_load(id: &str, torque: f64, speed: f64) -> Motor {
    let mut motor = common::motor(&[
        ("resistance [ohm]", "1"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [kg*m^2]", "1e-12"),
    ]);
    motor.id = id.into();
    motor.no_load_torque = Some(torque);
    motor.sheet.no_load_speed = Some(Printed::exact(speed));
    motor
}

/// Turning at 100 rad/s with 0.2 N·m, a drag d loses 100 d + (0.2 + d)²/0.01 W; a no-load torque T_0 at ω_0 with a share s of Coulomb
/// friction drags d = T_0 (s + (1 − s) 100/ω_0).
#[test]
fn the_order_of_two_open_drags_turns_at_the_share_on_paper() {
    use gearwise::design::break_even::{OpenOrder, open_order};
    use gearwise::design::{JointDemand, Site};
    let loss = |drag: f64| 100.0 * drag + (0.2 + drag).powi(2) / 0.01;
    let drag = |torque: f64, speed: f64, share: f64| torque * (share + (1.0 - share) * 100.0 / speed);
    let found = |first: &Motor, other: &Motor, change: &dyn Fn(&mut Robot)| -> Option<OpenOrder> {
        let mut robot = common::robot(common::hold(0.2, 100.0, 0.0), common::gear(1.0));
        robot.joints[0].ratio = RatioChoice::Listed { values: vec![1.0], step: None, teeth: None };
        robot.joints[0].objective = Objective::single(Quantity::Loss);
        robot.joints[0].motor_drag = MotorDrag::Counted;
        change(&mut robot);
        let catalog = Catalog::of(vec![first.clone(), other.clone()], Vec::new());
        let result = optimize(&robot, &catalog);
        let order: Vec<&str> = result.joints[0].designs().map(|d| d.motor.id.as_str()).collect();
        assert_eq!(order, [first.id.as_str(), other.id.as_str()]);
        let joint = &robot.joints[0];
        let demand = JointDemand::new(joint, &catalog);
        open_order(
            Site::new(&robot, joint, &demand),
            first,
            other,
            result.joints[0].designs().next().unwrap().optimum.objective,
        )
    };
    let same = |_: &mut Robot| {};
    // Slower than without load: the loss rises with the share. The first is at 0.01 … 0.04, the other at 0.025 … 0.05 N·m.
    let (first, other) = (with_no_load("a", 0.04, 400.0), with_no_load("b", 0.05, 200.0));
    let order = found(&first, &other, &same).unwrap();
    assert!(order.of_first && order.at_most && order.other == "b" && order.torque == 0.04);
    let at = |share: f64| loss(drag(0.04, 400.0, share));
    assert!(at(order.share) < loss(0.025) && at(order.share + 0.002) > loss(0.025), "{order:?}");
    assert!((order.share - 0.5).abs() < 0.002);
    // Faster than without load it falls: the first is at 0.04 … 0.02, the other at 0.05 … 0.025 N·m.
    let (first, other) = (with_no_load("a", 0.02, 50.0), with_no_load("b", 0.025, 50.0));
    let order = found(&first, &other, &same).unwrap();
    // 0.025 = 0.02 (2 − s).
    assert!(order.of_first && !order.at_most && (order.share - 0.75).abs() < 0.002, "{order:?}");
    // Where even the best end of the first is behind the best of the other, it is the other's share: 0.03 = 0.05 (s + (1 − s)/4).
    let mut known = with_no_load("a", 0.03, 400.0);
    (known.coulomb_friction, known.viscous_friction) = (Some(0.03), Some(0.0));
    let order = found(&known, &with_no_load("b", 0.05, 400.0), &same).unwrap();
    let share = (0.03 / 0.05 - 0.25) / 0.75;
    assert!(!order.of_first && !order.at_most && (order.share - share).abs() < 0.002, "{order:?} {share}");
    assert!(loss(drag(0.05, 400.0, order.share)) > loss(0.03));
    // And the same where the other's falls with the share: 0.03 = 0.025 (2 − s).
    let order = found(&known, &with_no_load("b", 0.025, 50.0), &same).unwrap();
    assert!(!order.of_first && order.at_most && (order.share - 0.8).abs() < 0.002, "{order:?}");

    // What must not be said. The other's drag is known, or its best end is behind the first's worst: the order is what it is.
    let mut settled = with_no_load("b", 0.05, 200.0);
    (settled.coulomb_friction, settled.viscous_friction) = (Some(0.05), Some(0.0));
    assert_eq!(found(&with_no_load("a", 0.04, 400.0), &settled, &same), None);
    assert_eq!(found(&with_no_load("a", 0.02, 400.0), &with_no_load("b", 0.05, 200.0), &same), None);
    // Brushes make the most of it.
    let mut brushed = with_no_load("b", 0.05, 200.0);
    brushed.conventions.commutation = Commutation::Brushed;
    assert_eq!(found(&with_no_load("a", 0.04, 400.0), &brushed, &same), None);
    // The objective does not count it.
    let copper = |robot: &mut Robot| robot.joints[0].objective = Objective::single(Quantity::CopperLoss);
    let (a, b) = (with_no_load("a", 0.04, 400.0), with_no_load("b", 0.05, 200.0));
    assert_eq!(found(&a, &b, &copper), None);
    let mut worse = b.clone();
    worse.resistance = 1.1;
    assert_eq!(found(&a, &worse, &|robot| robot.joints[0].motor_drag = MotorDrag::Off), None);
}

/// What a limit that no ratio keeps comes to at best is what it comes to at the worse end of the drag; and a no-load current without a
/// speed of it is not silently all Coulomb friction.
#[test]
fn the_nearest_demand_is_that_of_the_worse_end() {
    use gearwise::design::answer::Reason;
    use gearwise::design::program::Infeasible;
    let mut robot = common::robot(common::hold(0.2, 100.0, 0.0), common::gear(1.0));
    robot.joints[0].ratio = RatioChoice::Continuous { min: 1.0, max: 2.0 };
    robot.joints[0].objective = Objective::single(Quantity::Loss);
    robot.joints[0].motor_drag = MotorDrag::Counted;
    // Twice as fast as without load: all viscous is the worse end.
    let motor = with_no_load("a", 0.1, 50.0);
    let free = Catalog::of(vec![motor.clone()], Vec::new());
    let design =
        |robot: &Robot| optimize(robot, &free).joints[0].designs().next().map(|design| design.evaluation.clone());
    assert!(design(&robot).is_some_and(|found| found.losses.motor_drag > 100.0 * 0.1 * 1.5));
    robot.bus.power = Some(1.0);
    let result = optimize(&robot, &free);
    let Reason::Infeasible(Infeasible::Never { bind, least, ratio, .. }) = &result.joints[0].rejected[0].reason else {
        panic!("{:?}", result.joints[0].rejected[0].reason);
    };
    let load = Load::new(&robot.joints[0].motion, None);
    let candidate = Mount::new(&robot, &robot.joints[0], &load, &free.motors[0]).candidate().unwrap();
    let there = Prepared::new(candidate).at(*ratio);
    let asked = there.margins.iter().find(|margin| margin.limit == "bus_power").unwrap();
    assert!(
        bind.limit == "bus_power" && (least - asked.demand / asked.bound).abs() < 1e-9 * least,
        "{least} {asked:?}"
    );
    let said = |motor: &Motor| {
        robot_of(motor, |design| {
            design.assumed.iter().any(|(name, why)| *name == "motor_drag" && why.contains("no speed"))
        })
    };
    let mut silent = motor.clone();
    silent.sheet.no_load_speed = None;
    assert!(said(&silent) && !said(&motor));
}

/// Looks at the design of a motor that turns at 20 rad/s with 0.2 N·m.
fn robot_of<T>(motor: &Motor, look: impl FnOnce(&gearwise::design::Design) -> T) -> T {
    let mut robot = common::robot(common::hold(0.2, 20.0, 0.0), common::gear(1.0));
    robot.joints[0].ratio = RatioChoice::Listed { values: vec![1.0], step: None, teeth: None };
    robot.joints[0].objective = Objective::single(Quantity::Loss);
    robot.joints[0].motor_drag = MotorDrag::Counted;
    let catalog = Catalog::of(vec![motor.clone()], Vec::new());
    let result = optimize(&robot, &catalog);
    let found = result.joints[0].designs().next().unwrap();
    look(found)
}
