//! Gears of the catalogue near the best ratio: each is what `sweep` says of the pair, its parts are those of the equations on
//! paper and add up, none that is better by the rule is left out, and nothing is called kept that is not known.

use std::sync::Arc;

use gearwise::catalog::{Catalog, Gear, Motor};
use gearwise::design::answer::Design;
use gearwise::design::nearby::{NAMED, NEAR, NearGear, Nearby, Standing, nearby};
use gearwise::design::{Evaluation, optimize, sweep};
use gearwise::input::Source;
use gearwise::requirement::{EfficiencyCovers, Quantity, RatioChoice, Robot, read};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::common::repository;
use crate::raw::draw;

const HEADER: &str = "id,kind,ratio,efficiency,mass [kg],inertia [kg*m^2],continuous_torque [N*m],peak_torque [N*m],\
     max_input_speed [rad/s],source,source_kind\n";

/// A gear of which everything is known and nothing binds.
fn gear(id: &str, ratio: f64) -> Gear {
    let row = format!("{HEADER}{id},planetary,{ratio:?},0.9,0.1,1e-7,1e6,1e6,1e6,sheet,datasheet\n");
    Catalog::from_sources(vec![Arc::new(Source::new("gears.csv", row))]).unwrap().gears.remove(0)
}

/// The robot with gears of the catalogue at every joint.
fn geared(robot: &Robot, gears: &[Gear]) -> Robot {
    let patterns: Vec<String> = gears.iter().map(|gear| gear.id.clone()).collect();
    let mut robot = robot.clone();
    for joint in &mut robot.joints {
        joint.ratio = RatioChoice::gears(patterns.clone(), EfficiencyCovers::Load);
    }
    robot
}

/// The bits of all numbers of an evaluation that `sweep` gives, too.
fn bits(e: &Evaluation) -> Vec<u64> {
    let own = [e.ratio, e.loss, e.loss_low, e.copper_loss, e.peak_current, e.rms_current, e.reflected_inertia];
    let more = [e.mass.unwrap_or(-1.0), e.mean_power, f64::from(u8::from(e.feasible))];
    let margins = e.margins.iter().flat_map(|m| [m.demand, m.bound, m.margin]);
    own.into_iter().chain(more).chain(margins).map(f64::to_bits).collect()
}

/// The order in which gears are named, written anew: what `sweep` says of each pair.
fn by_hand(robot: &Robot, joint: usize, catalog: &Catalog, design: &Design) -> Vec<String> {
    let of = &robot.joints[joint];
    let best = design.optimum.ratio;
    let is_near =
        |n: f64| (n - best).abs() <= NEAR * best || design.optimum.windows.iter().any(|w| w.min <= n && n <= w.max);
    let may =
        |gear: &&Gear| gear.fits(&design.motor.id) != Some(false) && of.ratio.allows(gear.ratio) && is_near(gear.ratio);
    let gears: Vec<Gear> = catalog.gears.iter().filter(may).cloned().collect();
    let alone = Catalog::of(vec![design.motor.clone()], gears.clone());
    let asked = geared(robot, &gears);
    let swept = sweep(&asked, &alone, 2);
    let mut all: Vec<(u8, f64, f64, String)> = Vec::new();
    for one in &swept[joint].designs {
        let (e, away) = (&one.evaluation, (one.evaluation.ratio / best).ln().abs());
        let id = one.gear.unwrap().to_string();
        let objective = of.objective.terms.iter().map(|(quantity, weight)| match quantity {
            Quantity::Energy | Quantity::PeakPower => unreachable!("not drawn here"),
            quantity => Some(weight * e.quantity(*quantity)?),
        });
        let objective: Option<f64> = objective.sum();
        let worst = e.margins.iter().map(|m| m.margin).fold(f64::INFINITY, f64::min);
        let less = one.unchecked.iter().any(|remark| !design.unchecked.contains(remark));
        let class = match () {
            () if !e.feasible => 3,
            () if !one.unjudged.is_empty() => 2,
            () if less || objective.is_none() => 1,
            () => 0,
        };
        let value = if class == 3 { -worst } else { objective.unwrap_or(f64::INFINITY) };
        all.push((class, value, away, id));
    }
    for (_, id, _) in &swept[joint].unusable {
        let id = id.unwrap().to_string();
        let ratio = gears.iter().find(|gear| gear.id == id).unwrap().ratio;
        all.push((4, f64::INFINITY, (ratio / best).ln().abs(), id));
    }
    assert_eq!(all.len(), gears.len());
    all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2)).then(a.3.cmp(&b.3)));
    all.into_iter().map(|(.., id)| id).collect()
}

/// All shipped gears and motors on the joints of a quadruped: the pair is that of `sweep`, bit for bit, and the order that of
/// a look at every gear.
#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn a_gear_near_by_is_the_pair_of_sweep_and_none_better_is_left_out() {
    let catalog = Catalog::builtin().unwrap();
    let mut robot = read(&repository("requirements/quadruped_mini_cheetah.toml")).unwrap();
    for joint in &mut robot.joints {
        joint.limits.actuator_mass = None;
        joint.ratio = RatioChoice::Continuous { min: 3.0, max: 60.0 };
        joint.limits.reflected_inertia = Some(0.2);
    }
    let result = optimize(&robot, &catalog);
    let mut seen = [0; 5];
    for (j, of) in result.joints.iter().enumerate() {
        for design in of.candidates.iter().step_by(2) {
            let found = nearby(&robot, of.joint, &catalog, design).unwrap();
            let order = by_hand(&robot, j, &catalog, design);
            let named: Vec<&str> = found.gears.iter().map(|near| near.gear.id.as_str()).collect();
            assert_eq!(named, order[..order.len().min(NAMED)], "{} at {}", design.motor.id, of.joint.name);
            assert_eq!((found.looked_at, found.gap.is_some()), (order.len(), order.is_empty()));
            for near in &found.gears {
                let kind = Standing::word(&near.standing);
                let k = ["keeps", "less_known", "unjudged", "exceeds", "unusable"].iter().position(|w| *w == kind);
                seen[k.unwrap()] += 1;
                let one = [near.gear.clone()];
                let asked = geared(&robot, &one);
                let alone = Catalog::of(vec![design.motor.clone()], one.to_vec());
                let swept = sweep(&asked, &alone, 2);
                match &near.evaluation {
                    Some(there) => assert_eq!(bits(there), bits(&swept[j].designs[0].evaluation), "{}", near.gear.id),
                    None => assert!(swept[j].designs.is_empty() && !swept[j].unusable.is_empty()),
                }
                assert_eq!(near.exceeded().is_empty(), near.evaluation.as_ref().is_none_or(|there| there.feasible));
                assert!(!near.keeps_all() || near.evaluation.as_ref().unwrap().feasible && near.unchecked.is_empty());
            }
        }
    }
    assert!(seen[1] + seen[2] > 5 && seen[3] > 5, "{seen:?}");
}

/// Random joints and gears: the parts are the differences of a plain look at the raw waveforms, one number of the gear changed after the
/// other, and add up to the whole.
#[test]
fn parts_are_those_on_paper_and_add_up() {
    let look = |i: u64| {
        let mut case = draw(i, i.is_multiple_of(2));
        case.robot.joints[0].limits.spring = None;
        let mut random = Pcg64::seed_from_u64(i);
        let mut within = |a: f64, b: f64| random.random_range(a..b);
        let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
        let result = optimize(&case.robot, &catalog);
        let design = result.joints[0].candidates.first()?;
        let mut gears: Vec<Gear> =
            (0..4).map(|k| gear(&format!("g{k}"), design.optimum.ratio * within(0.72, 1.28))).collect();
        for gear in &mut gears {
            gear.efficiency = Some(within(0.6, 1.0));
            gear.inertia = Some(case.motor.rotor_inertia.unwrap_or(1e-6) * within(0.0, 1.0));
            gear.mass = Some(within(0.01, 1.0));
        }
        let with = Catalog::of(vec![case.motor.clone()], gears);
        let found = nearby(&case.robot, &case.robot.joints[0], &with, design).unwrap();
        let mut count = [0; 2];
        for near in &found.gears {
            let objective = &case.robot.joints[0].objective;
            let Some(parts) = near.parts else {
                assert!(objective.sole() == Some(Quantity::Mass) || near.objective.is_none());
                continue;
            };
            let (n, own) = (near.gear.ratio, near.gear);
            let mut other = draw(i, i.is_multiple_of(2));
            other.robot.joints[0].limits.spring = None;
            let mut steps = vec![design.optimum.objective, other.look(n).objective];
            let it = &mut other.robot.joints[0].gear;
            it.efficiency = own.efficiency.unwrap();
            it.backdrive_efficiency = 2.0 - 1.0 / it.efficiency;
            (it.no_load.coulomb, it.no_load.viscous) = (0.0, 0.0);
            steps.push(other.look(n).objective);
            other.robot.joints[0].gear.inertia = own.inertia.unwrap();
            steps.push(other.look(n).objective);
            (other.robot.joints[0].gear.mass, other.robot.joints[0].gear.mass_per_stage) = (own.mass, None);
            steps.push(other.look(n).objective);
            let said = [parts.ratio, parts.efficiency, parts.inertia.unwrap(), parts.mass.unwrap_or(0.0)];
            let scale = steps.iter().fold(0.0_f64, |most, step| most.max(step.abs()));
            for (k, said) in said.iter().enumerate() {
                let paper = steps[k + 1] - steps[k];
                assert!((said - paper).abs() <= 1e-6 * scale, "{i} {k}: {said} and {paper} of {scale}");
            }
            let more = near.more.unwrap();
            assert!((said.iter().sum::<f64>() - more).abs() <= 1e-12 * scale, "{i}: {said:?} {more}");
            count[0] += 1;
            count[1] += usize::from(parts.mass.is_some());
        }
        Some(count)
    };
    let all: Vec<[usize; 2]> = (0..160).into_par_iter().filter_map(look).collect();
    let sum = |k: usize| all.iter().map(|count| count[k]).sum::<usize>();
    assert!(sum(0) > 60 && sum(1) > 5, "{} {}", sum(0), sum(1));
}

/// A joint of which every limit can be judged, and its motor.
fn plain() -> (Robot, Motor) {
    let catalog = Catalog::builtin().unwrap();
    let robot = read(&repository("requirements/quadruped_mini_cheetah.toml")).unwrap();
    let mut robot = Robot { joints: vec![robot.joints[2].clone()], ..robot };
    robot.joints[0].ratio = RatioChoice::Continuous { min: 3.0, max: 60.0 };
    let motor = catalog.motors.iter().find(|motor| motor.id == "t-motor-u8-lee").unwrap().clone();
    (robot, motor)
}

/// Looks at gears near the best ratio of the plain joint; they are made with that ratio.
fn look<T>(gears: impl FnOnce(f64) -> Vec<Gear>, seen: impl FnOnce(&Nearby, &Design, &Robot) -> T) -> T {
    let (robot, motor) = plain();
    let catalog = Catalog::of(vec![motor.clone()], Vec::new());
    let result = optimize(&robot, &catalog);
    let design = &result.joints[0].candidates[0];
    let with = Catalog::of(vec![motor], gears(design.optimum.ratio));
    seen(&nearby(&robot, &robot.joints[0], &with, design).unwrap(), design, &robot)
}

fn only<'n, 'a>(found: &'n Nearby<'a>) -> &'n NearGear<'a> {
    assert_eq!(found.gears.len(), 1);
    &found.gears[0]
}

#[test]
fn all_limits_are_said_to_be_kept_only_where_all_are_known_and_kept() {
    // Everything is known and kept.
    let one = |change: fn(&mut Gear)| {
        move |best: f64| {
            let mut one = gear("one", best * 0.9);
            change(&mut one);
            vec![one]
        }
    };
    look(one(|_| {}), |found, _, _| {
        assert!(only(found).keeps_all() && found.gap.is_none());
        assert!(only(found).parts.unwrap().inertia.is_some() && only(found).mass.is_some());
    });
    // A torque that nobody says, an inertia, a mass, an efficiency: each is said, and none is kept.
    look(one(|gear| gear.continuous_torque = None), |found, _, _| {
        assert_eq!((only(found).keeps_all(), &only(found).standing), (false, &Standing::LessKnown));
        assert!(only(found).unchecked.iter().any(|(name, _)| *name == "gear_continuous_torque"));
    });
    look(one(|gear| gear.inertia = None), |found, _, _| {
        let near = only(found);
        assert!(!near.keeps_all() && near.parts.unwrap().inertia.is_none());
        // The joint limits the inertia at its output.
        assert_eq!(near.standing, Standing::Unjudged);
    });
    look(one(|gear| gear.mass = None), |found, _, _| {
        assert!(!only(found).keeps_all() && only(found).mass.is_none() && only(found).parts.is_some());
    });
    look(one(|gear| gear.efficiency = None), |found, _, _| {
        let near = only(found);
        assert!(!near.keeps_all() && near.evaluation.is_none() && near.parts.is_none() && near.more.is_none());
        assert!(matches!(near.standing, Standing::Unusable(_)) && found.gap.is_none());
    });
    // A limit that is exceeded is named, and how far.
    look(one(|gear| gear.peak_torque = Some(0.5)), |found, _, _| {
        let near = only(found);
        assert_eq!((near.keeps_all(), &near.standing), (false, &Standing::Exceeds));
        assert_eq!(near.exceeded()[0].limit, "gear_peak_torque");
        assert!(near.exceeded()[0].demand > 0.5 && near.exceeded()[0].bound == 0.5);
    });
}

#[test]
fn no_gear_is_said_only_where_none_is_near() {
    // Nothing at all; only far ones; a near one of another motor; one that the requirement does not allow.
    let mut names: Vec<(Option<String>, Option<String>)> = Vec::new();
    let mut gap = |gears: fn(f64) -> Vec<Gear>| {
        look(gears, |found, _, _| {
            assert!(found.gears.is_empty() && found.looked_at == 0);
            let gap = found.gap.unwrap();
            names.push((gap.below.map(|gear| gear.id.clone()), gap.above.map(|gear| gear.id.clone())));
        });
    };
    gap(|_| Vec::new());
    gap(|_| vec![gear("a", 3.0), gear("b", 3.5), gear("c", 40.0), gear("d", 50.0), gear("too-large", 61.0)]);
    gap(|best| vec![Gear { fits: vec!["another".into()], ..gear("near", best) }, gear("far", 55.0)]);
    assert_eq!(names[0], (None, None));
    assert_eq!(names[1], (Some("b".into()), Some("c".into())));
    assert_eq!(names[2], (None, Some("far".into())));
    // A near one that will not do is a gear all the same, and so is one that is feasible and further away than 30 %.
    let bad = |best: f64| vec![Gear { peak_torque: Some(0.1), ..gear("bad", best) }];
    look(bad, |found, _, _| assert!(found.gap.is_none() && found.looked_at == 1));
    look(
        |best| vec![gear("low", best * 0.72), gear("high", best * 1.29)],
        |found, design, _| {
            let near = |id: &str| found.gears.iter().any(|near| near.gear.id == id);
            assert!(near("high") && near("low"));
            assert!(design.optimum.window().max < design.optimum.ratio * 1.29, "it is near and not feasible");
        },
    );
}
