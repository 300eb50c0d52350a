//! What is said about the best ratio: how far it may move, whether the requirement's own range decided, how it is typed
//! again; and ratios that are listed. Against the equations on paper of random joints, sample by sample.

use gearwise::actuator::Load;
use gearwise::catalog::Catalog;
use gearwise::design::answer::{Design, Reason};
use gearwise::design::flatness::{WITHIN, flatness, own_bound};
use gearwise::design::judge::unjudged;
use gearwise::design::nearby::nearby;
use gearwise::design::outlook::outlooks;
use gearwise::design::program::Certificate;
use gearwise::design::{Mount, Options, Prepared, grid, optimize};
use gearwise::report::{number, number_between};
use gearwise::requirement::{Quantity, RatioChoice, Robot, read};
use rayon::prelude::*;

use crate::common::repository;
use crate::raw::{Case, draw};
use crate::solved;

/// The worst limit of a ratio, but for the ends of the range.
fn excess(case: &Case, n: f64) -> f64 {
    let all = case.excess(n).filter(|(_, name)| !name.starts_with("ratio_"));
    all.map(|(over, _)| over).fold(f64::NEG_INFINITY, f64::max)
}

fn with_ratio(case: &Case, ratio: RatioChoice) -> Robot {
    let mut robot = case.robot.clone();
    robot.joints[0].ratio = ratio;
    robot
}

fn prepared<'a>(robot: &'a Robot, load: &'a Load, case: &'a Case) -> Prepared<'a> {
    Prepared::new(Mount::new(robot, &robot.joints[0], load, &case.motor).candidate().unwrap())
}

fn load(robot: &Robot) -> Load {
    Load::new(&robot.joints[0].motion, robot.joints[0].ripple())
}

/// Whether what the requirement states can be judged at a ratio: else the ratio is not said to be kept.
fn is_judged(prepared: &Prepared, robot: &Robot, n: f64) -> bool {
    unjudged(robot, &robot.joints[0], &prepared.judged(n).unchecked).is_empty()
}

/// Every ratio that is said to be nearly as good is, and at the ends it is over, or the feasible ratios are.
#[test]
fn the_flat_part_is_flat_and_feasible_and_ends_where_that_ends() {
    let look = |convex: bool, i: u64| {
        let case = draw(i, convex);
        let found = solved::solve(&case.motor, &case.robot).ok()?;
        let (joint, load) = (&case.robot.joints[0], load(&case.robot));
        let prepared = prepared(&case.robot, &load, &case);
        let flat = flatness(&prepared, joint, &found.optimum)?;
        let (best, most) = (found.optimum.ratio, found.optimum.objective * (1.0 + WITHIN));
        assert!(flat.from <= best && best <= flat.to, "{i}: {flat:?} about {best}");
        // Of a load that vanishes at one ratio a share means nothing.
        if found.optimum.objective < 1e-9 * case.look(1.1 * best).objective {
            return None;
        }
        // The mass steps at a full number of stages, but for rounding: not looked at there.
        let (first, last) = (flat.from * (1.0 + 1e-8), flat.to * (1.0 - 1e-8));
        for n in grid(first.min(last), last.max(first), if last > first { 200 } else { 1 }) {
            let (over, objective) = (excess(&case, n), case.look(n).objective);
            assert!(over <= 1e-7, "{i}: N = {n} of {flat:?} exceeds a limit by {over:e}");
            assert!(objective <= most * (1.0 + 1e-7), "{i}: N = {n} of {flat:?} has {objective}, not {most}");
        }
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let mut ends = 0;
        for (end, outside) in [(flat.from, flat.from * (1.0 - 1e-5)), (flat.to, flat.to * (1.0 + 1e-5))] {
            let is_over = !(min..=max).contains(&outside)
                || excess(&case, outside) > -1e-9
                || !is_judged(&prepared, &case.robot, outside)
                || case.look(outside).objective > most * (1.0 - 1e-9);
            assert!(is_over, "{i}: {flat:?} could go on beyond {end}");
            ends += usize::from((min..=max).contains(&outside) && excess(&case, outside) < -1e-3);
        }
        Some((flat.proved, ends, flat.to > flat.from * 1.001))
    };
    let convex: Vec<_> = (0..400).into_par_iter().filter_map(|i| look(true, i)).collect();
    let others: Vec<_> = (0..300).into_par_iter().filter_map(|i| look(false, i)).collect();
    // Both sorts of ends, wide parts, and what is not proved are among them.
    let by_objective: usize = convex.iter().map(|(_, ends, _)| ends).sum();
    assert!(convex.len() > 100 && by_objective > 50, "{} {by_objective}", convex.len());
    assert!(convex.iter().filter(|(_, _, wide)| *wide).count() > 50);
    assert!(convex.iter().any(|(proved, ..)| *proved));
    assert!(others.iter().any(|(proved, ..)| !proved), "{}", others.len());
}

/// It is not said of a list, nor of one ratio.
#[test]
fn no_flat_part_is_told_of_ratios_that_are_no_choice() {
    let case = (0..100).map(|i| draw(i, true)).find(|c| solved::solve(&c.motor, &c.robot).is_ok()).unwrap();
    let optimum = solved::solve(&case.motor, &case.robot).unwrap().optimum;
    let n = optimum.ratio;
    for ratio in [
        RatioChoice::Listed { values: vec![n, 1.1 * n], step: None, teeth: None },
        RatioChoice::Continuous { min: n, max: n },
    ] {
        let robot = with_ratio(&case, ratio.clone());
        let load = load(&robot);
        let prepared = prepared(&robot, &load, &case);
        let optimum = match ratio.listed() {
            Some(_) => optimum.clone(),
            None => solved::solve(&case.motor, &robot).unwrap().optimum,
        };
        assert_eq!(flatness(&prepared, &robot.joints[0], &optimum), None);
    }
}

/// The requirement's own bound decides exactly where the ratio stands at it and a better one that keeps every limit is behind it.
#[test]
fn an_own_bound_is_told_where_it_decides_and_nowhere_else() {
    let mut told = [0; 4];
    for i in 0..600 {
        let case = draw(i, true);
        let Ok(found) = solved::solve(&case.motor, &case.robot) else { continue };
        let (joint, load) = (&case.robot.joints[0], load(&case.robot));
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let prepared = prepared(&case.robot, &load, &case);
        let (best, objective) = (found.optimum.ratio, found.optimum.objective);
        let at_end = [(min, false), (max, true)].into_iter().find(|(end, _)| (best / end - 1.0).abs() < 1e-9);
        match (own_bound(&prepared, joint, &found.optimum), at_end) {
            (Some(bound), Some((end, is_largest))) => {
                assert!(bound.ratio == end && bound.is_largest == is_largest, "{i}: {bound:?}");
                assert!(excess(&case, bound.beyond) <= 1e-7, "{i}: {bound:?}");
                let there = case.look(bound.beyond).objective;
                assert!(
                    there < objective && (1.0 - there / objective - bound.saves).abs() < 1e-6,
                    "{i}: {bound:?} {there}"
                );
                assert!(!(min..=max).contains(&bound.beyond));
                told[usize::from(is_largest)] += 1;
            }
            (None, Some((end, is_largest))) => {
                let beyond = if is_largest { end * 1.001 } else { end / 1.001 };
                let saves = 1.0 - case.look(beyond).objective / objective;
                // A limit keeps it there, or it gets no better.
                let is_judged = is_judged(&prepared, &case.robot, beyond);
                assert!(
                    !is_judged || excess(&case, beyond) > -1e-9 || saves < 2e-6 || objective <= 0.0,
                    "{i}: {saves:e}"
                );
                told[2] += 1;
            }
            (None, None) => told[3] += 1,
            (Some(bound), None) => panic!("{i}: {bound:?} of the best {best} inside of {min} to {max}"),
        }
    }
    assert!(told[0] + told[1] > 10 && told[2] > 10 && told[3] > 50, "{told:?}");
}

/// The best ratio as it is printed keeps every limit when it is typed again; four digits alone would not.
#[test]
fn a_printed_ratio_keeps_its_limits() {
    let (mut refused, mut longest, mut all) = (0, 0, 0);
    for i in 0..600 {
        let case = draw(i, true);
        let Ok(found) = solved::solve(&case.motor, &case.robot) else { continue };
        let load = load(&case.robot);
        let prepared = prepared(&case.robot, &load, &case);
        let window = found.optimum.window();
        let text = number_between(found.optimum.ratio, window.min, window.max);
        let typed: f64 = text.parse().unwrap();
        assert!(prepared.at(typed).feasible, "{i}: {text} of {window:?}");
        assert!((typed / found.optimum.ratio - 1.0).abs() < 2e-3, "{i}: {text} for {}", found.optimum.ratio);
        assert!(excess(&case, typed) < 1e-7, "{i}: {text}");
        refused += usize::from(!prepared.at(number(found.optimum.ratio).parse().unwrap()).feasible);
        (longest, all) = (longest.max(text.len()), all + 1);
    }
    assert!(refused > 20 && longest < 22, "{refused} of {all}, {longest} characters");
}

/// Of a list the best that keeps every limit, by a plain look at each; no other ratio, and none where none does.
#[test]
fn the_best_of_listed_ratios_is_that_of_a_plain_look_at_each() {
    let (mut solved, mut refused, mut between) = (0, 0, 0);
    for i in 0..400 {
        let case = draw(i, i % 2 == 0);
        let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
        let values = grid(min, max, 3 + (i % 9) as usize);
        let robot = with_ratio(&case, RatioChoice::Listed { values: values.clone(), step: None, teeth: None });
        let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
        let result = optimize(&robot, &catalog);
        let joint = &result.joints[0];
        let clear = |n: f64| excess(&case, n).abs() > 1e-7;
        if !values.iter().all(|n| clear(*n)) {
            continue;
        }
        let kept = values.iter().copied().filter(|n| excess(&case, *n) < 0.0);
        let best = kept.map(|n| (n, case.look(n).objective)).min_by(|a, b| a.1.total_cmp(&b.1));
        let design = joint.designs().next();
        match (best, design) {
            (Some((n, objective)), Some(design)) => {
                let optimum = &design.optimum;
                assert!(values.contains(&optimum.ratio), "{i}: {} is none of {values:?}", optimum.ratio);
                let same = (case.look(optimum.ratio).objective - objective).abs() <= 1e-7 * objective.abs();
                assert!(same, "{i}: {} and not {n}", optimum.ratio);
                assert!(matches!(optimum.certificate, Certificate::Certified { gap: 0.0, .. }));
                for window in &optimum.windows {
                    let inside = values.iter().filter(|n| window.min <= **n && **n <= window.max);
                    assert!(inside.clone().count() > 0 && inside.clone().all(|n| excess(&case, *n) < 0.0), "{i}");
                }
                let in_windows = |n: &f64| optimum.windows.iter().any(|w| w.min <= *n && *n <= w.max);
                assert!(
                    values.iter().all(|n| in_windows(n) == (excess(&case, *n) < 0.0)),
                    "{i}: {:?}",
                    optimum.windows
                );
                solved += 1;
            }
            (None, None) => {
                // Some ratio between them may do it, and is not offered.
                let free = solved::solve(&case.motor, &case.robot);
                between += usize::from(free.is_ok());
                if let Some(why) = joint.rejected.first() {
                    assert!(matches!(why.reason, Reason::Infeasible(_)), "{i}: {:?}", why.reason);
                }
                refused += 1;
            }
            (best, design) => {
                // Without a mass, or durations, there is no objective to rank by.
                let weighs = robot.joints[0].objective.weight(Quantity::Mass) > 0.0;
                let lacks = weighs || robot.joints[0].objective.weight(Quantity::Energy) > 0.0;
                assert!(lacks && design.is_none(), "{i}: {best:?} {:?}", design.map(|d| d.optimum.ratio));
            }
        }
    }
    assert!(solved > 80 && refused > 20 && between > 0, "{solved} {refused} {between}");
}

/// A planetary gear near by has the ratio of its teeth, and is no better than the best; a gear of the catalogue has none near by.
#[test]
fn a_planetary_gear_near_by_has_its_ratio_and_is_not_better_than_the_best() {
    let catalog = Catalog::builtin().unwrap();
    let robot = read(&repository("requirements/quadruped_mini_cheetah.toml")).unwrap();
    let result = optimize(&robot, &catalog);
    let mut seen = 0;
    for of in &result.joints {
        for design in &of.candidates {
            let found = nearby(&robot, of.joint, &catalog, design).unwrap();
            let Some(built) = &found.planetary else { continue };
            let train = built.train.as_ref().unwrap();
            assert!((train.ratio() - built.design.optimum.ratio).abs() < 1e-9);
            assert!(found.planetary_above(design).unwrap() > -1e-6, "nothing is better than the best");
            seen += 1;
        }
    }
    assert!(seen > 10, "{seen}");
    let geared = read(&repository("requirements/humanoid_hip_catalog_gears.toml")).unwrap();
    let result = optimize(&geared, &catalog);
    let first: &Design = &result.joints[0].candidates[0];
    assert!(nearby(&geared, result.joints[0].joint, &catalog, first).is_none());
    let outlook = outlooks(&result, &catalog, true, Options::default()).unwrap().remove(0);
    assert!(outlook.flatness.is_none() && outlook.own_bound.is_none() && outlook.front.is_empty());
}
