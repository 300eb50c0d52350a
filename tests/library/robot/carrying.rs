//! Actuators that load one another: the choice against all combinations, each joint solved for exactly the load that it has there,
//! for every objective; and what a larger catalogue may change.

use std::cell::RefCell;
use std::collections::HashMap;
use std::sync::Arc;

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::robot::{Choice, Options, carrying, choose};
use gearwise::design::{JointDemand, Site};
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::cases::cases;
use crate::common;

const SAMPLES: usize = 16;

/// What is minimised.
fn objectives() -> Vec<Objective> {
    let single = [
        Quantity::Loss,
        Quantity::CopperLoss,
        Quantity::Energy,
        Quantity::PeakCurrent,
        Quantity::PeakPower,
        Quantity::Mass,
        Quantity::ReflectedInertia,
    ];
    let sums = [
        vec![(Quantity::Loss, 1.0), (Quantity::Mass, 4.0)],
        vec![(Quantity::CopperLoss, 0.5), (Quantity::PeakCurrent, 0.2), (Quantity::ReflectedInertia, 2.0)],
    ];
    let sums = sums.into_iter().map(|terms| Objective { terms });
    single.into_iter().map(Objective::single).chain(sums).collect()
}

/// A chain of joints, each of which may carry those after it, with masses that pull down or balance.
fn draw(index: u64) -> Robot {
    let generator = RefCell::new(Pcg64::seed_from_u64(index));
    let within = |a: f64, b: f64| generator.borrow_mut().random_range(a..b);
    let joints = 2 + (index % 3) as usize;
    let objective = objectives()[(index / 3) as usize % objectives().len()].clone();
    let stages = within(0.0, 1.0) < 0.3;
    let mut robot = common::robot(common::hold(1.0, 1.0, 0.0), GearModel::IDEAL);
    robot.bus.voltage = within(24.0, 60.0);
    robot.bus.drive_efficiency = if within(0.0, 1.0) < 0.5 { 1.0 } else { within(0.85, 1.0) };
    let one = |j: usize| {
        let (lift, level, turn) = (within(1.0, 10.0), within(-8.0, 8.0), within(0.0, 6.0));
        let (speed, late) = (within(1.0, 5.0), within(0.0, 6.0));
        let time: Vec<f64> = (0..SAMPLES).map(|k| k as f64 / SAMPLES as f64).collect();
        let w = std::f64::consts::TAU;
        let samples = Samples {
            torque: time.iter().map(|t| lift * (w * t + turn).sin() + level).collect(),
            velocity: Some(time.iter().map(|t| speed * (w * t + late).sin() + 0.01).collect()),
            acceleration: Some(time.iter().map(|t| speed * w * (w * t + late).cos()).collect()),
            time,
            ..Samples::default()
        };
        let motion = Motion::from_samples(samples, Course::Periodic(1.0));
        let gear = GearModel { mass: Some(0.2), inertia: 3e-6, ..common::gear(within(0.6, 0.98)) };
        let mut joint = common::robot(motion, gear).joints.remove(0);
        joint.name = format!("j{j}");
        joint.count = 1 + u32::from(within(0.0, 1.0) < 0.3);
        joint.ratio = RatioChoice::Continuous { min: 3.0, max: within(20.0, 100.0) };
        joint.objective = objective.clone();
        if stages {
            joint.gear.mass = None;
            joint.gear.mass_per_stage = Some((0.15, 5.0));
        }
        joint
    };
    robot.joints = (0..joints).map(one).collect();
    for j in 0..joints - 1 {
        for k in j + 1..joints {
            let (size, constant) = (within(-5.0, 7.0), within(0.0, 1.0) < 0.4);
            let course = |i: usize| if constant { size } else { size * (0.4 * i as f64).cos() };
            let torque_per_mass: Vec<f64> = (0..SAMPLES).map(course).collect();
            robot.joints[j].carries.push(Carried { joint: k, torque_per_mass, rate: vec![0.0; SAMPLES], constant });
        }
    }
    robot
}

/// Some motors of the shipped catalogue, in its order.
fn some(index: u64, count: usize) -> Catalog {
    let catalog = Catalog::builtin().unwrap();
    let known = |motor: &&Motor| motor.mass.is_some() && motor.rotor_inertia.is_some();
    let mut motors: Vec<Motor> = catalog.motors.iter().filter(known).cloned().collect();
    motors.shuffle(&mut Pcg64::seed_from_u64(1000 + index));
    motors.truncate(count);
    Catalog::of(motors, Vec::new())
}

fn decide<'a>(robot: &'a Robot, catalog: &'a Catalog, runner_ups: usize) -> Choice<'a> {
    choose(robot, catalog, Options { budgets: false, runner_ups, ..Options::default() }).unwrap()
}

/// What a joint comes to with a motor under a load: objective of one actuator and its mass, for each number of stages.
type Known = HashMap<(usize, usize, Vec<u64>), Vec<(f64, f64)>>;

fn pieces(joint: &Joint) -> Vec<Joint> {
    let (RatioChoice::Continuous { min, max }, Some((_, stage))) = (&joint.ratio, joint.gear.mass_per_stage) else {
        return vec![joint.clone()];
    };
    let mut ends = vec![*min];
    ends.extend((1..9).map(|k| stage.powi(k)).filter(|n| min < n && n < max));
    ends.push(*max);
    let piece = |w: &[f64]| Joint { ratio: RatioChoice::Continuous { min: w[0], max: w[1] }, ..joint.clone() };
    ends.windows(2).map(piece).collect()
}

/// The least total over all combinations, the joints from the last to the first: what is carried comes first.
fn least(robot: &Robot, catalog: &Catalog, known: &mut Known, masses: &mut Vec<f64>) -> f64 {
    let j = robot.joints.len() - 1 - masses.len();
    let of = |k: usize, masses: &[f64]| masses[robot.joints.len() - 1 - k];
    let joint = &robot.joints[j];
    let key: Vec<u64> = joint.carries.iter().map(|c| of(c.joint, masses).to_bits()).collect();
    let mut best = f64::INFINITY;
    for m in 0..catalog.motors.len() {
        let all = known.entry((j, m, key.clone())).or_insert_with(|| {
            let loaded = carrying(joint, |k| of(k, masses));
            let solve = |piece: &Joint| {
                let demand = JointDemand::new(piece, catalog);
                let site = Site::new(robot, piece, &demand);
                let design = gearwise::design::best::best_design(site, &catalog.motors[m], false).ok()?;
                Some((design.optimum.objective, design.evaluation.mass?))
            };
            pieces(&loaded).iter().filter_map(solve).collect()
        });
        for (objective, mass) in all.clone() {
            masses.push(mass);
            let rest = if masses.len() == robot.joints.len() { 0.0 } else { least(robot, catalog, known, masses) };
            masses.pop();
            best = best.min(f64::from(joint.count) * objective + rest);
        }
    }
    best
}

#[test]
fn no_combination_is_better_for_any_objective() {
    /// What is wrong, whether there is a combination, and whether it is proved.
    type Came = (Option<String>, bool, bool);
    let came: Vec<Came> = cases(0, 216)
        .into_par_iter()
        .map(|index| {
            let robot = draw(index);
            let catalog = some(index, if robot.joints.len() > 3 { 4 } else { 6 });
            let choice = decide(&robot, &catalog, 2);
            let best = least(&robot, &catalog, &mut Known::new(), &mut Vec::new());
            let name = robot.joints[0].objective.name();
            let Some(first) = choice.combinations.first() else {
                return (
                    best.is_finite().then(|| format!("{index} ({name}): none, but there is {best}")),
                    false,
                    false,
                );
            };
            let near = |a: f64, b: f64| (a - b).abs() <= 2e-6 * b.abs();
            let bound = choice.proof.lower_bound.unwrap_or(f64::NEG_INFINITY);
            let wrong = if !near(first.objective, best) {
                Some(format!("{index} ({name}): {} found, {best} is there", first.objective))
            } else if bound > best + 1e-9 * best.abs() {
                Some(format!("{index} ({name}): bound {bound} above {best}"))
            } else if choice.combinations.windows(2).any(|w| w[1].objective < w[0].objective) {
                Some(format!("{index} ({name}): the next is better"))
            } else {
                None
            };
            (wrong, true, choice.proof.certified())
        })
        .collect();
    let wrong: Vec<&String> = came.iter().filter_map(|c| c.0.as_ref()).collect();
    let count = |of: &dyn Fn(&Came) -> bool| came.iter().filter(|c| of(c)).count();
    let (with, proved) = (count(&|c| c.1), count(&|c| c.2));
    println!("{} robots: {with} with a combination, {proved} of them proved", came.len());
    assert!(wrong.is_empty(), "{} wrong: {:#?}", wrong.len(), &wrong[..wrong.len().min(12)]);
    assert!(with * 2 > came.len() && proved * 10 >= with * 9, "{with} {proved} of {}", came.len());
}

/// With more motors the bound is no higher than what was found with fewer, and what is proved is no worse.
#[test]
fn a_larger_catalogue_gives_no_worse_answer() {
    let wrong: Vec<String> = cases(50_000, 20)
        .into_par_iter()
        .flat_map(|index| {
            let robot = draw(index);
            let (small, large) = (some(index, 8), some(index, 24));
            let (of_small, of_large) = (decide(&robot, &small, 0), decide(&robot, &large, 0));
            let Some(before) = of_small.combinations.first().map(|c| c.objective) else { return Vec::new() };
            let mut wrong = Vec::new();
            match of_large.combinations.first() {
                None => wrong.push(format!("{index}: nothing with more motors")),
                Some(now) => {
                    let bound = of_large.proof.lower_bound.unwrap_or(f64::NEG_INFINITY);
                    if bound > before + 1e-9 * before.abs() {
                        wrong.push(format!("{index}: bound {bound}, {before} with fewer motors"));
                    }
                    if of_large.proof.certified() && now.objective > before + 1e-6 * before.abs() {
                        wrong.push(format!("{index}: {} proved, {before} with fewer motors", now.objective));
                    }
                }
            }
            wrong
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// What a kilogram more of an actuator is said to cost is what it costs: the same motors, each at its best ratio for a little more and
/// a little less.
#[test]
fn a_kilogram_costs_what_is_said() {
    let step = 1e-5;
    let (mut looked, mut bent) = (0, 0);
    for index in cases(0, 216).filter(|index| index % 3 == 1) {
        let robot = draw(index);
        let catalog = some(index, 6);
        let choice = decide(&robot, &catalog, 0);
        let Some(best) = choice.combinations.first() else { continue };
        let masses: Vec<f64> = best.joints.iter().map(|design| design.evaluation.mass.unwrap()).collect();
        for k in 1..robot.joints.len() {
            let total = |more: f64| -> Option<f64> {
                let of = |(j, joint): (usize, &Joint)| {
                    let loaded = carrying(joint, |i| masses[i] + if i == k { more } else { 0.0 });
                    let own = best.joints[j].evaluation.mass?;
                    // The same number of stages.
                    let piece = pieces(&loaded).into_iter().find(|piece| {
                        let heaviest = piece.gear.mass_at(piece.ratio.range().unwrap().1).unwrap();
                        (best.joints[j].motor.mass.unwrap() + heaviest - own).abs() < 1e-9
                    })?;
                    let demand = JointDemand::new(&piece, &catalog);
                    let site = Site::new(&robot, &piece, &demand);
                    let design = gearwise::design::best::best_design(site, best.joints[j].motor, false).ok()?;
                    Some(f64::from(joint.count) * design.optimum.objective)
                };
                robot.joints.iter().enumerate().map(of).sum()
            };
            let (Some(low), Some(here), Some(high)) = (total(-step), total(0.0), total(step)) else { continue };
            let slopes = [(here - low) / step, (high - here) / step];
            let size = 1e-4 * here.abs().max(1.0) + 1e-3 * slopes[0].abs();
            if (slopes[0] - slopes[1]).abs() > size {
                bent += 1;
                continue;
            }
            looked += 1;
            let said = best.per_mass[k];
            assert!(
                (said - slopes[0]).abs() <= size,
                "{index}, {}: {said} said of j{k}, {slopes:?}",
                robot.joints[0].objective.name()
            );
        }
    }
    println!("{looked} prices, {bent} where it bends");
    assert!(looked >= 10, "{looked} prices, {bent} where it bends");
}

/// The shipped arm with actuators that load one another, minimising copper loss without drag.
fn arm() -> Robot {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("requirements");
    let text = std::fs::read_to_string(root.join("arm_from_its_description.toml")).unwrap();
    let robots = format!("\"{}/robots/", root.display());
    let text = text
        .replace("[mechanism]", "[mechanism]\nactuators = \"separate\"")
        .replace("\"robots/", &robots)
        .replace("objective = \"loss\"", "objective = \"copper_loss\"\nmotor_drag = \"off\"");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.toml");
    std::fs::write(&path, text).unwrap();
    read(&path).unwrap_or_else(|problems| panic!("{problems:?}"))
}

/// Joints whose motors' iron saturates have bounds over what they carry, too: more motors give no worse arm, and a proved one.
#[test]
fn an_arm_is_proved_among_motors_whose_iron_saturates() {
    let robot = arm();
    let all = Catalog::builtin().unwrap();
    let (saturates, others): (Vec<Motor>, Vec<Motor>) =
        all.motors.iter().cloned().partition(|motor| motor.saturation_current().is_some());
    assert!(saturates.len() > 10);
    let few: Vec<Motor> = others.into_iter().step_by(4).collect();
    let best = |motors: Vec<Motor>| {
        let catalog = Catalog::of(motors, Vec::new());
        let choice = decide(&robot, &catalog, 0);
        assert!(choice.proof.certified(), "{:?}", choice.proof);
        choice.combinations[0].objective
    };
    let with = best(few.iter().cloned().chain(saturates).collect());
    assert!(with <= best(few) * (1.0 + 1e-9));
}

/// Changing one joint at a time, from several starts, each joint and all that carry it solved again: nothing better than what is proved.
#[test]
fn coordinate_descent_finds_nothing_better_on_the_arm() {
    let (robot, catalog) = (arm(), some(7, 60));
    let choice = decide(&robot, &catalog, 0);
    let best = &choice.combinations[0];
    assert!(choice.proof.certified(), "{:?}", choice.proof);
    let masses_of = |chosen: &[usize]| -> Vec<f64> {
        let gear = |j: usize| robot.joints[j].gear.mass.unwrap();
        chosen.iter().enumerate().map(|(j, m)| catalog.motors[*m].mass.unwrap() + gear(j)).collect()
    };
    let solve = |j: usize, m: usize, masses: &[f64]| -> f64 {
        let loaded = carrying(&robot.joints[j], |k| masses[k]);
        let demand = JointDemand::new(&loaded, &catalog);
        let design =
            gearwise::design::best::best_design(Site::new(&robot, &loaded, &demand), &catalog.motors[m], false);
        design.map_or(f64::INFINITY, |design| design.optimum.objective)
    };
    let found: Vec<f64> = cases(0, 20)
        .into_par_iter()
        .map(|start| {
            let mut random = Pcg64::seed_from_u64(start);
            let n = robot.joints.len();
            let mut chosen: Vec<usize> = (0..n).map(|_| random.random_range(0..catalog.motors.len())).collect();
            let all = |chosen: &[usize]| -> Vec<f64> {
                let masses = masses_of(chosen);
                (0..n).map(|j| solve(j, chosen[j], &masses)).collect()
            };
            let mut values = all(&chosen);
            // Joints that cannot do it count a great deal, so that the way leads out of there.
            let total = |values: &[f64]| values.iter().map(|v| if v.is_finite() { *v } else { 1e6 }).sum::<f64>();
            loop {
                let before = total(&values);
                for k in 0..n {
                    for m in 0..catalog.motors.len() {
                        let mut other = chosen.clone();
                        other[k] = m;
                        let masses = masses_of(&other);
                        let mut changed = values.clone();
                        changed[k] = solve(k, m, &masses);
                        for j in (0..n).filter(|j| robot.joints[*j].carries.iter().any(|c| c.joint == k)) {
                            if total(&changed) >= total(&values) {
                                break;
                            }
                            changed[j] = solve(j, other[j], &masses);
                        }
                        if total(&changed) < total(&values) {
                            (chosen, values) = (other, changed);
                        }
                    }
                }
                if total(&values) >= before {
                    return total(&values);
                }
            }
        })
        .collect();
    println!("{} proved; descents end at {found:?}", best.objective);
    assert!(found.iter().all(|value| *value >= best.objective * (1.0 - 1e-6)), "{} {found:?}", best.objective);
    assert!(found.iter().any(|value| *value < 1e5));
}

/// A joint that can do it only with a counterweight that it carries: alone it has no design. Where the joints minimise different things
/// there is nothing to measure it by; where they minimise the same, the robot has a choice.
#[test]
fn a_joint_without_a_design_of_its_own_is_no_measure() {
    let catalog = Catalog::builtin().unwrap();
    let motor = catalog.motor("t-motor-u8-lee").unwrap().clone();
    let mass = motor.mass.unwrap() + 0.1;
    let catalog = Catalog::of(vec![motor], Vec::new());
    let mut robot = common::robot(common::hold(200.0, 1.0, 0.0), GearModel { mass: Some(0.1), ..GearModel::IDEAL });
    robot.bus.voltage = 48.0;
    let of_wrist = common::robot(common::hold(1.0, 1.0, 0.0), GearModel { mass: Some(0.1), ..GearModel::IDEAL });
    let mut wrist = of_wrist.joints[0].clone();
    wrist.name = "wrist".into();
    robot.joints[0].carries.push(Carried {
        joint: 1,
        torque_per_mass: vec![-199.0 / mass],
        rate: vec![0.0],
        constant: true,
    });
    robot.joints.push(wrist);
    for joint in &mut robot.joints {
        joint.ratio = RatioChoice::Continuous { min: 5.0, max: 10.0 };
        joint.objective = Objective::single(Quantity::CopperLoss);
    }
    let choice = decide(&robot, &catalog, 0);
    assert!(choice.proof.certified() && choice.combinations.len() == 1, "{:?}", choice.wanting);
    robot.joints[1].objective = Objective::single(Quantity::ReflectedInertia);
    let refused = choose(&robot, &catalog, Options { budgets: false, ..Options::default() });
    let Err(gearwise::design::robot::NoChoice::Cannot(why)) = refused else { panic!("a choice without a measure") };
    assert!(why.contains("no design without what it carries"), "{why}");
}

/// Power that binds the ratios of all joints together is no reason to be without a proof; what the best keeps anyway changes nothing; and
/// that nothing can do with less is shown, not given up.
#[test]
fn an_arm_under_shared_power_is_proved() {
    let (mut robot, catalog) = (arm(), some(7, 25));
    robot.joints.iter_mut().for_each(|joint| joint.objective = Objective::single(Quantity::Loss));
    let free = decide(&robot, &catalog, 0);
    assert!(free.proof.certified(), "{:?}", free.proof);
    let (objective, power, returned) =
        (free.combinations[0].objective, free.combinations[0].peak_power, free.combinations[0].most_returned);
    let mut last = objective;
    for share in [1.001, 0.985, 0.965] {
        let mut limited = robot.clone();
        limited.budget.power = Some(share * power);
        let choice = decide(&limited, &catalog, 0);
        let best = &choice.combinations[0];
        assert!(choice.proof.certified(), "{share}: {:?}", choice.proof);
        assert!(best.peak_power <= share * power * (1.0 + 1e-8), "{share}: {} {power}", best.peak_power);
        // Less power costs more; more than is drawn costs nothing.
        assert!(best.objective >= last * (1.0 - 1e-9), "{share}: {} {last}", best.objective);
        assert!(share < 1.0 || (best.objective / objective - 1.0).abs() < 1e-9, "{} {objective}", best.objective);
        last = best.objective;
    }
    assert!(last > objective * (1.0 + 1e-5), "the power does not bind: {last} {objective}");
    robot.budget.power = Some(0.8 * power);
    let none = decide(&robot, &catalog, 0);
    assert!(none.combinations.is_empty() && none.proof.not_proved.is_empty(), "{:?}", none.proof);
    robot.budget.power = None;
    robot.budget.regeneration = Some(1.001 * returned.max(0.0));
    let same = decide(&robot, &catalog, 0);
    assert!(same.proof.certified(), "{:?}", same.proof);
    assert!((same.combinations[0].objective / objective - 1.0).abs() < 1e-9);
}

/// The motors of a robot's best combination with its mass, what its joints lose, and whether it is proved.
fn best_of(text: &str) -> (Vec<String>, f64, Vec<f64>, bool) {
    let robot = read_source(&Arc::new(Source::new("robot.toml", text))).unwrap_or_else(|e| panic!("{e:?}"));
    let motors = "id,terminals,current,source,source_kind,pole_pairs,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],peak_current [A],continuous_current [A],mass [kg],coulomb_friction [N*m]\n\
                  big,q_axis,q_axis,own,datasheet,7,0.2,0.1,2e-5,60,20,0.8,0.005\n\
                  small,q_axis,q_axis,own,datasheet,7,0.6,0.1,1e-5,60,15,0.4,0.005\n";
    let catalog = Catalog::from_sources(vec![Arc::new(Source::new("motors.csv", motors))]).unwrap();
    let choice = choose(&robot, &catalog, Options { budgets: false, ..Options::default() }).unwrap();
    let best = choice.combinations.first().unwrap_or_else(|| panic!("no combination of {text}"));
    let motors = best.joints.iter().map(|design| design.motor.id.clone()).collect();
    let losses = best.joints.iter().map(|design| design.evaluation.loss).collect();
    (motors, best.mass.unwrap(), losses, choice.proof.certified())
}

/// A transmission weighs the same whether power is shared or not: for a budget of mass, and for the joint that carries it.
#[test]
fn a_transmission_has_its_mass_beside_a_budget_of_power() {
    let robot = |budget: &str, more: &str| {
        format!(
            "name = \"r\"\n{budget}[bus]\nvoltage = \"48 V\"\ndrive_current = \"60 A\"\n\
             [[joint]]\nname = \"a\"\nratio = {{ min = 5, max = 20 }}\ngear = {{ mass = \"0 kg\" }}\nobjective = \"loss\"\n\
             points = [{{ torque = \"10 N*m\", speed = \"5 rad/s\", duration = \"1 s\" }}, {{ torque = \"10 N*m\", speed = \"-5 rad/s\", duration = \"1 s\" }}]\n\
             [joint.transmission]\nratio = 1.5\nmass = \"0.5 kg\"\n{more}"
        )
    };
    let own = "[budget]\nactuator_mass = \"1 kg\"\n";
    let with_power = format!("{own}power = \"500 W\"\n");
    for budget in [own, &with_power] {
        let (motors, mass, _, proved) = best_of(&robot(budget, ""));
        assert!(motors == ["small"] && (mass - 0.9).abs() < 1e-12 && proved, "{motors:?} {mass}");
    }
    let carrier = "[[joint]]\nname = \"b\"\nmotors = [\"big\"]\nratio = { values = [20] }\nobjective = \"loss\"\n\
                   points = [{ torque = \"1 N*m\", speed = \"5 rad/s\", duration = \"1 s\" }, { torque = \"1 N*m\", speed = \"-5 rad/s\", duration = \"1 s\" }]\n\
                   torque_per_mass = { a = \"10 N*m/kg\" }\n";
    let of = |budget: &str| best_of(&robot(budget, carrier)).2[1];
    let (alone, with_power) = (of(""), of("[budget]\npower = \"900 W\"\n"));
    assert!((alone - with_power).abs() < 1e-9 * alone && alone > 5.0, "{alone} {with_power}");
}

/// Stages of a gear beside a transmission leave of a limit on mass what both and the motor weigh.
#[test]
fn stages_have_the_mass_that_motor_and_transmission_leave() {
    let text = "name = \"r\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"60 A\"\n\
                [[joint]]\nname = \"a\"\nmotors = [\"small\"]\nratio = { min = 2, max = 100 }\nobjective = \"loss\"\n\
                gear = { mass_per_stage = \"0.2 kg\", stage_ratio = 5 }\n\
                points = [{ torque = \"10 N*m\", speed = \"1 rad/s\", duration = \"1 s\" }]\n\
                [joint.limits]\nactuator_mass = \"1.2 kg\"\n[joint.transmission]\nratio = 1.5\nmass = \"0.5 kg\"\n";
    let (_, mass, _, proved) = best_of(text);
    assert!((mass - 1.1).abs() < 1e-12 && proved, "{mass}");
}
