use super::super::steady::{CONSTANT, add, bench, noise, work};
use super::*;
use crate::Bench;
use gearwise_model::effects::effect;

/// Takes out what can be spared, one after the other.
fn drop_superfluous(selection: &mut Selection, work: &mut Work) {
    while let Some(superfluous) = selection.superfluous(work) {
        selection.remove(work, superfluous);
    }
}

const RATIO: f64 = 6.0;

/// Three logs of 300 points; `drag(log, speed)` at the motor is undeclared.
fn plain(drag: impl Fn(usize, f64) -> f64) -> Bench {
    let logs: Vec<Vec<[f64; 3]>> = (0..3)
        .map(|log| {
            let point = |k: usize| {
                let place = 300 * log + k;
                let (w, i) = (100.0 * noise(place), 5.0 * noise(place + 5000));
                [w, i, RATIO * (CONSTANT * i - drag(log, w)) + 0.03 * noise(place + 9000)]
            };
            (0..300).map(point).collect()
        })
        .collect();
    bench(RATIO, &logs, 0)
}

/// Columns that are known to explain a share: the gain is that share, beside others what they leave of it.
#[test]
fn gains_are_shares_of_the_left_out_error() {
    let bench = plain(|_, w| 2e-3 * w + 0.05 * w.signum());
    let work = work(&bench);
    let fit = work.fit();
    let error = |extra: &[&Vec<f64>]| {
        let mut columns = work.columns();
        columns.extend(extra.iter().map(|c| c.as_slice()));
        work.fit_columns(&columns).left_out.iter().filter(|v| v.is_finite()).sum::<f64>()
    };
    let candidate = |name: &str| evaluate(&work, &fit, effect(name).unwrap(), 0.0).unwrap();
    let (viscous, coulomb) = (candidate("viscous_friction"), candidate("coulomb_friction"));
    let (v, c) = (&viscous.columns[0], &coulomb.columns[0]);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(viscous.gain, 1.0 - error(&[v]) / error(&[]));
    near(gain_of(&work, &fit, &viscous.columns), viscous.gain);
    near(gain_of(&work, &fit, &[v.clone(), c.clone()]), 1.0 - error(&[v, c]) / error(&[]));
    near(gain_beside(&work, &viscous, &coulomb.columns), (error(&[c]) - error(&[v, c])) / error(&[]));
    assert!(viscous.gain > 0.5 && gain_beside(&work, &viscous, &coulomb.columns) < 0.5 * viscous.gain);
    assert!(viscous.sure > 5.0 && viscous.scores.statistic() > 10.0);
    // A column that the model makes up already is no candidate, nor one that is nothing or no number.
    let mut twice = work_with(&bench, "viscous_friction");
    assert!(evaluate(&twice, &twice.fit(), effect("viscous_friction").unwrap(), 0.0).is_none());
    assert!(evaluate(&twice, &twice.fit(), effect("coulomb_friction").unwrap(), 0.0).is_some());
    assert!(evaluate(&twice, &twice.fit(), effect("cogging").unwrap(), 6.0).is_none());
    twice.terms.pop();
    assert!(evaluate(&twice, &twice.fit(), effect("viscous_friction").unwrap(), 0.0).is_some());
}

fn work_with<'a>(bench: &'a Bench, name: &str) -> Work<'a> {
    let mut work = work(bench);
    add(&mut work, name, 0.0);
    work
}

/// What share of a column others do not make up.
#[test]
fn shares_of_their_own() {
    let columns: [Vec<f64>; 3] = [0, 1, 2].map(|j| (0..50).map(|k| noise(100 * j + k)).collect());
    let target: Vec<f64> = (0..50).map(|k| noise(700 + k)).collect();
    let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).chain([target.as_slice()]).collect();
    let total = DMatrix::from_fn(4, 4, |i, j| all[i].iter().zip(all[j]).map(|(a, b)| a * b).sum());
    let shares = own_shares(&total, 1, 2);
    for j in 0..2 {
        let (own, cross) = (total[(1 + j, 1 + j)], total[(0, 1 + j)]);
        assert!((shares[j] - (1.0 - cross * cross / total[(0, 0)] / own)).abs() < 1e-9);
    }
}

/// Each refusal for its own reason.
#[test]
fn what_is_refused_is_refused_for_a_reason() {
    let next = |bench: &Bench, model: &[&str]| {
        let mut work = work(bench);
        for name in model {
            add(&mut work, name, 0.0);
        }
        let mut selection = Selection::new(&work);
        let found = name_of(selection.next(&work));
        (found, selection)
    };
    let reason = |selection: &Selection, name: &str| {
        selection.refused.iter().find(|r| r.name == name).map(|r| r.reason.clone()).unwrap_or_default()
    };
    // Negative friction explains, and is none.
    let (found, selection) = next(&plain(|_, w| -0.05 * w.signum()), &[]);
    assert_ne!(found, Some("coulomb_friction"));
    assert!(
        reason(&selection, "coulomb_friction").contains("cannot be negative"),
        "{}",
        reason(&selection, "coulomb_friction")
    );
    // One log that has none of it does not veto what the others are sure of; it is told.
    let (found, selection) = next(&plain(|log, w| if log == 1 { 0.0 } else { 0.05 } * w.signum()), &[]);
    assert_eq!(found, Some("coulomb_friction"));
    let objections: Vec<&str> = selection.objections.iter().map(|(_, o)| o.as_str()).collect();
    assert!(objections.contains(&"fitted on the other logs it makes `1.csv` worse"), "{objections:?}");
    // The best of what is left; the others explain less.
    let (found, selection) = next(&plain(|_, w| 2e-3 * w), &[]);
    assert_eq!(found, Some("viscous_friction"));
    assert!(selection.refused.iter().all(|r| r.name != "viscous_friction"));
    // What is in the model is not found again, and nothing is left.
    let (found, _) = next(&plain(|_, w| 2e-3 * w), &["viscous_friction"]);
    assert_eq!(found, None);
    // The sensor's own zero hides a constant; without a position there is no cogging.
    assert!(reason(&selection, "torque_offset").contains("the zero of the sensor hides it"));
    assert!(reason(&selection, "cogging").contains("no position that turns"));
    assert!(selection.open.iter().all(|e| !["torque_offset", "cogging"].contains(&e.name())));
}

/// What a later effect made superfluous goes, what is needed stays, and what became absurd goes with its reason.
#[test]
fn superfluous_effects_are_dropped() {
    let dropped = |bench: &Bench, model: &[(&str, f64)]| {
        let mut work = work(bench);
        for (name, shape) in model {
            add(&mut work, name, *shape);
        }
        let mut selection = Selection::default();
        drop_superfluous(&mut selection, &mut work);
        let left: Vec<&str> = work.terms.iter().filter_map(|t| t.effect().map(|(e, _)| e.name())).collect();
        (left, selection.refused)
    };
    let both = plain(|_, w| 1e-3 * w + 0.05 * w.signum());
    let (left, refused) = dropped(&both, &[("viscous_friction", 0.0), ("coulomb_friction", 0.0)]);
    assert_eq!((left, refused.len()), (vec!["viscous_friction", "coulomb_friction"], 0));
    let one = plain(|_, w| 0.05 * w.signum());
    let (left, refused) = dropped(&one, &[("viscous_friction", 0.0), ("coulomb_friction", 0.0)]);
    assert_eq!(left, ["coulomb_friction"]);
    assert_eq!(
        (refused[0].name.as_str(), refused[0].reason.as_str()),
        ("viscous_friction", "what was found later made it superfluous")
    );
    // What is declared stays, whatever it explains, and so does a parameter that the model does not give.
    let mut declared = work_with(&one, "viscous_friction");
    declared.terms[1].declared = Some(vec![1e-4]);
    declared.terms[0].declared = None;
    drop_superfluous(&mut Selection::default(), &mut declared);
    assert_eq!(declared.terms.len(), 2);
    let absurd = plain(|_, w| -2e-4 * w + 0.05 * w.signum());
    let (left, refused) = dropped(&absurd, &[("viscous_friction", 0.0), ("coulomb_friction", 0.0)]);
    assert_eq!(left, ["coulomb_friction"]);
    let reason = &refused[0].reason;
    assert!(reason.contains("with all that was found") && reason.contains("cannot be negative"), "{reason}");
    // Stribeck friction is defined beyond Coulomb's, which stays though it explains nothing.
    let slow = plain(|_, w| 0.08 * (-(w / 15.0).powi(2)).exp() * w.signum());
    let (left, _) = dropped(&slow, &[("coulomb_friction", 0.0), ("stribeck_friction", 15.0)]);
    assert!(left.contains(&"stribeck_friction") && left.contains(&"coulomb_friction"), "{left:?}");
    let (left, _) = dropped(&slow, &[("viscous_friction", 0.0), ("stribeck_friction", 15.0)]);
    assert_eq!(left, ["stribeck_friction"]);
}

/// Friction under a load that never changes may be either kind: they are named together.
#[test]
fn look_alikes_are_named() {
    let bench = plain(|_, w| 0.05 * w.signum());
    let mut work = work(&bench);
    add(&mut work, "coulomb_friction", 0.0);
    let selection = Selection::new(&work);
    // Over these speeds a Stribeck curve or a saturating drag comes close, but not close enough; none recovers it.
    assert!(!selection.look_alikes(&work, 1).contains(&effect("coulomb_friction").unwrap()));
    assert!(!selection.look_alikes(&work, 1).contains(&effect("viscous_friction").unwrap()));
    assert!(selection.look_alikes(&work, 0).is_empty());
    // Two speeds only, one each way: viscous and Coulomb friction are the same.
    let logs: Vec<Vec<[f64; 3]>> = (0..3)
        .map(|log| {
            let point = |k: usize| {
                let place = 300 * log + k;
                let (w, i) = (50.0 * noise(place).signum() + 0.01 * noise(place + 77), 5.0 * noise(place + 5000));
                [w, i, RATIO * (CONSTANT * i - 0.05 * w.signum()) + 0.03 * noise(place + 9000)]
            };
            (0..300).map(point).collect()
        })
        .collect();
    let bench = super::super::steady::bench(RATIO, &logs, 0);
    let mut work = super::super::steady::work(&bench);
    add(&mut work, "coulomb_friction", 0.0);
    let alike = Selection::new(&work).look_alikes(&work, 1);
    assert!(alike.contains(&effect("viscous_friction").unwrap()), "{alike:?}");
}

/// A plausible shape is preferred where it does nearly as well, which is four fifths; else the larger gain, and of
/// equals the first.
#[test]
fn of_two_shapes_the_plausible_one_is_preferred() {
    for (one, other, preferred) in [
        ((true, 0.81), (false, 1.0), true),
        ((true, 0.79), (false, 1.0), false),
        ((false, 1.0), (true, 0.79), true),
        ((false, 1.0), (true, 0.81), false),
        ((true, 0.41), (false, 0.5), true),
        ((true, 0.39), (false, 0.5), false),
        ((true, 0.5), (true, 0.4), true),
        ((true, 0.4), (true, 0.5), false),
        ((false, 0.5), (false, 0.4), true),
        ((false, 0.45), (false, 0.5), false),
        ((true, 0.5), (true, 0.5), false),
        ((false, 0.5), (false, 0.5), false),
    ] {
        assert_eq!(is_preferred(one, other), preferred, "{one:?} {other:?}");
    }
}

/// Of every effect the shape that nothing is preferred to, one entry for each.
#[test]
fn every_effect_is_tried_at_its_best_shape() {
    let bench = plain(|_, w| 0.1 * (w / 45.0) / (1.0 + (w / 45.0).powi(2)));
    let work = work(&bench);
    let fit = work.fit();
    let selection = Selection::new(&work);
    let all = evaluate_all(&work, &fit, &selection.open);
    let mut names: Vec<&str> = all.iter().map(|c| c.effect.name()).collect();
    assert!(names.contains(&"eddy_drag") && names.contains(&"stribeck_friction") && names.len() > 4, "{names:?}");
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), all.len());
    for best in &all {
        let judged = |c: &Candidate| (c.effect.plausible(&c.values, &work.balance.scale).is_ok(), c.gain);
        for shape in shapes(&work, &fit, best.effect) {
            let Some(other) = evaluate(&work, &fit, best.effect, shape) else { continue };
            assert!(!is_preferred(judged(&other), judged(best)), "{} {shape}", best.effect.name());
        }
    }
    let eddy = all.iter().find(|c| c.effect.name() == "eddy_drag").unwrap();
    assert!((eddy.shape / 45.0).ln().abs() < 0.2, "{}", eddy.shape);
}

fn name_of(found: Vec<(&'static dyn Effect, f64)>) -> Option<&'static str> {
    assert!(found.len() < 2);
    found.first().map(|(effect, _)| effect.name())
}

/// Of two that the data cannot tell apart the simpler one is named, whichever comes first in gain.
#[test]
fn of_a_tie_the_simpler_effect_is_named() {
    for (viscous, coulomb) in [(0.0, 0.05), (0.001, 0.0)] {
        // One speed each way, and a little scatter: viscous and Coulomb friction are the same.
        let logs: Vec<Vec<[f64; 3]>> = (0..3)
            .map(|log| {
                let point = |k: usize| {
                    let place = 300 * log + k;
                    let (w, i) = (50.0 * noise(place).signum() + 0.5 * noise(place + 77), 5.0 * noise(place + 5000));
                    let drag = viscous * w + coulomb * w.signum();
                    [w, i, RATIO * (CONSTANT * i - drag) + 0.03 * noise(place + 9000)]
                };
                (0..300).map(point).collect()
            })
            .collect();
        let bench = bench(RATIO, &logs, 0);
        let work = work(&bench);
        let mut selection = Selection::new(&work);
        assert_eq!(name_of(selection.next(&work)), Some("viscous_friction"), "{:?}", selection.refused);
    }
    // Told apart: each has its own name, and the other is refused for it.
    for (name, other, bench) in [
        ("viscous_friction", "coulomb_friction", plain(|_, w| 1e-3 * w)),
        ("coulomb_friction", "viscous_friction", plain(|_, w| 0.05 * w.signum())),
    ] {
        let work = work(&bench);
        let mut selection = Selection::new(&work);
        assert_eq!(name_of(selection.next(&work)), Some(name));
        let refused = selection.refused.iter().find(|r| r.name == other).unwrap();
        assert_eq!(refused.reason, format!("`{name}` explains more"));
    }
}

/// Points of a log in which the speed rises.
const RISE: usize = 1200;

/// Speeds that rise in the course of each log, with scatter, and what is undeclared as a function of log, place
/// in it from 0 to 1 and speed; the rows get their places as times.
fn rising(scatter: f64, drag: impl Fn(f64, f64) -> f64) -> Bench {
    let logs: Vec<Vec<[f64; 3]>> = (0..3)
        .map(|log| {
            let point = |k: usize| {
                let (place, part) = (RISE * log + k, k as f64 / RISE as f64);
                let (w, i) = (20.0 + 80.0 * part + scatter * noise(place), 5.0 * noise(place + 5000));
                [w, i, RATIO * (CONSTANT * i - drag(part, w)) + 0.03 * noise(place + 9000)]
            };
            (0..RISE).map(point).collect()
        })
        .collect();
    bench(RATIO, &logs, 0)
}

fn over_time(bench: &Bench) -> Work<'_> {
    let mut work = work(bench);
    for (k, time) in std::sync::Arc::make_mut(&mut work.balance).rows.time.iter_mut().enumerate() {
        *time = (k % RISE) as f64;
    }
    work
}

/// What a free drift explains clearly better, and what is nearly gone beside it, is no effect.
#[test]
fn a_drift_is_not_given_a_name() {
    let outcome = |bench: &Bench| {
        let work = over_time(bench);
        let mut selection = Selection::new(&work);
        let found = name_of(selection.next(&work));
        let reason = selection.refused.iter().find(|r| r.name == "viscous_friction").map(|r| r.reason.clone());
        (found, reason.unwrap_or_default())
    };
    // Friction and nothing else: the drift does not do better.
    assert_eq!(outcome(&rising(1.0, |_, w| 1e-3 * w)).0, Some("viscous_friction"));
    // A drift that is no line: speed follows it in part, and drift explains the rest too.
    let (found, reason) = outcome(&rising(1.0, |part, w| 1e-3 * w + 0.2 * part.powi(5)));
    assert_ne!(found, Some("viscous_friction"));
    assert_eq!(reason, "a drift in time explains it as well");
    // The same drift, but friction shows in the scatter of the speed too: beside the drift much of it is left.
    let both = rising(60.0, |part, w| 2e-3 * w + 0.3 * part.powi(5));
    assert_eq!(outcome(&both).0, Some("viscous_friction"));
}

/// Each time what decides is just on either side: how much better the drift does, and how much is left beside it.
#[test]
fn a_drift_has_to_do_clearly_better() {
    let mut decisions = [[0; 2]; 2];
    for case in crate::cases::cases(0, 64) {
        let (step, scatter) = ((5 * case + case / 16) as usize % 16, [1.0, 20.0, 34.0, 60.0][case as usize % 4]);
        // A drift that rises late, or one that goes down and up and has nothing of the speed's rise.
        let (size, kind) = ([0.1, 0.14, 0.2, 0.3][step / 4], step as i32 % 4);
        let drift = |part: f64| match kind {
            0 => (2.0 * part - 1.0).abs(),
            _ => part.powi(1 + 2 * kind),
        };
        let bench = rising(scatter, |part, w| 1.5e-3 * w + size * drift(part));
        let work = over_time(&bench);
        let fit = work.fit();
        let drift = super::drift(&work);
        let viscous = evaluate(&work, &fit, effect("viscous_friction").unwrap(), 0.0).unwrap();
        let better = gain_of(&work, &fit, &drift) > 1.15 * viscous.gain;
        let little = gain_beside(&work, &viscous, &drift) < BESIDE_DRIFT * viscous.gain;
        let mut selection = Selection::new(&work);
        selection.next(&work);
        let refused = selection.refused.iter().find(|r| r.name == "viscous_friction");
        let by_drift = refused.is_some_and(|r| r.reason.contains("drift in time"));
        // Other reasons come first where it is not worth a name at all, or another one does better.
        if refused.is_none() || by_drift {
            assert_eq!(by_drift, better && little, "{size} {kind} {scatter} {refused:?}");
            decisions[usize::from(better)][usize::from(little)] += 1;
        }
    }
    assert!(!crate::cases::are_all() || decisions.iter().flatten().all(|n| *n > 0), "{decisions:?}");
}

/// Plain friction comes first where it does as well as the best curve with a shape; not where there is none of it to
/// add, where it explains nothing, or where the curve does better.
#[test]
fn plain_friction_comes_first_where_it_suffices() {
    let suffices = |bench: &Bench, model: &[&str], only: Option<&str>| {
        let mut work = work(bench);
        for name in model {
            add(&mut work, name, 0.0);
        }
        let fit = work.fit();
        let selection = Selection::new(&work);
        let mut candidates = evaluate_all(&work, &fit, &selection.open);
        candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        candidates.retain(|c| only.is_none_or(|name| c.effect.name() == name));
        selection.basics_suffice(&work, &fit, &candidates)
    };
    let friction = plain(|_, w| 1e-3 * w + 0.05 * w.signum());
    assert!(suffices(&friction, &[], None));
    assert!(suffices(&friction, &["viscous_friction"], None));
    // There is no other candidate, or none that is plausible: nothing to come before.
    assert!(!suffices(&friction, &[], Some("viscous_friction")));
    assert!(!suffices(&friction, &[], Some("nothing")));
    // Both are there already: what is left is noise, and nothing of them is left to add.
    assert!(!suffices(&friction, &["viscous_friction", "coulomb_friction"], None));
    assert!(!suffices(&plain(|_, _| 0.0), &[], None));
    // A curve that they cannot follow.
    assert!(!suffices(&plain(|_, w| 0.1 * (w / 20.0) / (1.0 + (w / 20.0).powi(2))), &[], None));
}

/// An effect goes where it takes away less than half of what is worth a name, and stays where it takes more.
#[test]
fn how_little_makes_an_effect_superfluous() {
    let mut near = [0; 2];
    for step in 0..30 {
        let size = 1e-6 * (8.0 + 0.8 * f64::from(step));
        let bench = plain(|_, w| size * w + 0.05 * w.signum());
        let mut work = work(&bench);
        add(&mut work, "coulomb_friction", 0.0);
        add(&mut work, "viscous_friction", 0.0);
        let fit = work.fit();
        let without = work.left_out_without(2);
        let gain = 1.0 - finite_sum(&fit.left_out) / finite_sum(&without);
        let scores = scores_of(&work, 2);
        let sure = informed(&without, &fit.left_out, &scores.expected_falls(), scores.variance());
        let holds = believed(&work, 2).is_ok();
        let mut selection = Selection::default();
        drop_superfluous(&mut selection, &mut work);
        let stays = work.terms.len() == 3;
        assert_eq!(stays, gain >= 0.5 * WORTH && sure >= SURE - 0.5 && holds, "{size}: {gain} {sure}");
        // Steps from one to the next are small: both sides of the threshold are looked at.
        if (gain / (0.5 * WORTH)).ln().abs() < 0.3 && sure >= SURE - 0.5 {
            near[usize::from(stays)] += 1;
        }
        if !stays {
            let reason = &selection.refused[0].reason;
            assert_eq!(reason.contains("superfluous"), gain < 0.5 * WORTH, "{reason} {gain}");
        }
    }
    assert!(near.iter().all(|n| *n > 0), "{near:?}");
}

/// An effect is told instead of a better one where it is simpler, has nearly its gain, and the data cannot tell them apart.
#[test]
fn the_simpler_one_is_told_where_nothing_speaks_against_it() {
    let candidate = |name: &str, gain: f64, left_out: &dyn Fn(usize) -> f64| Candidate {
        effect: effect(name).unwrap(),
        shape: 0.0,
        values: Vec::new(),
        left_out: (0..40).map(left_out).collect(),
        gain,
        sure: 9.0,
        scores: Scores::of_nothing(),
        columns: Vec::new(),
        shifts: Vec::new(),
    };
    let best = candidate("stribeck_friction", 0.5, &|k| 1.0 + 0.1 * noise(k));
    let alike = |k: usize| 1.0 + 0.1 * noise(k + 50);
    let worse = |k: usize| 1.2 + 0.1 * noise(k + 50);
    assert!(paired(&candidate("viscous_friction", 0.5, &worse).left_out, &best.left_out) > 4.0);
    assert!(is_told_instead(&candidate("viscous_friction", 0.43, &alike), &best));
    // What leaves nearly the same error is its twin, whatever its gain is said to be.
    assert!(is_told_instead(&candidate("viscous_friction", 0.42, &alike), &best));
    let wild = |k: usize| 1.3 + 3.0 * noise(k + 50);
    assert!(paired(&candidate("viscous_friction", 0.5, &wild).left_out, &best.left_out) < 2.0);
    assert!(is_told_instead(&candidate("viscous_friction", 0.43, &wild), &best));
    assert!(!is_told_instead(&candidate("viscous_friction", 0.42, &wild), &best));
    assert!(!is_told_instead(&candidate("viscous_friction", 0.43, &worse), &best));
    assert!(!is_told_instead(&candidate("viscous_friction", 0.42, &worse), &best));
    assert!(!is_told_instead(&candidate("direction_asymmetry", 0.5, &alike), &best));
    assert!(!is_told_instead(&best, &best));
}

/// What is defined beyond another effect waits for it, where that is open, worth it and not there yet.
#[test]
fn what_is_beyond_another_comes_after_it() {
    let after = |bench: &Bench, model: &[&str], open: &[&str]| {
        let mut work = work(bench);
        for name in model {
            add(&mut work, name, 0.0);
        }
        let open = open.iter().map(|name| effect(name).unwrap()).collect();
        let selection = Selection { open, ..Selection::default() };
        let fit = work.fit();
        selection.comes_after(&work, &fit, effect("stribeck_friction").unwrap())
    };
    let coulomb = plain(|_, w| 0.05 * w.signum());
    let all = ["viscous_friction", "coulomb_friction", "stribeck_friction"];
    assert_eq!(after(&coulomb, &[], &all), Some("coulomb_friction"));
    assert_eq!(after(&coulomb, &["viscous_friction"], &all), Some("coulomb_friction"));
    assert_eq!(after(&coulomb, &["coulomb_friction"], &all), None);
    assert_eq!(after(&coulomb, &[], &["viscous_friction", "stribeck_friction"]), None);
    assert_eq!(after(&plain(|_, _| 0.0), &[], &all), None);
    let work = work(&coulomb);
    let selection = Selection::new(&work);
    assert_eq!(selection.comes_after(&work, &work.fit(), effect("viscous_friction").unwrap()), None);
}

/// What is missing is told in this order: worth, sureness, more than chance.
#[test]
fn what_lacks_is_told_in_numbers() {
    // 1 − √(1 − 0.039) = 1.97 %, 1 − √(1 − 0.19) = 10 %.
    assert_eq!(lacks(-0.1, 9.0, 99.0, 9.0).unwrap(), "it would not lower the left-out error");
    assert_eq!(lacks(0.0009, 9.0, 99.0, 9.0).unwrap(), "it would not lower the left-out error");
    assert_eq!(lacks(0.0011, 9.0, 99.0, 9.0).unwrap(), "it would lower the left-out error by 0.1 %, less than 2 %");
    assert_eq!(lacks(0.039, 9.0, 99.0, 9.0).unwrap(), "it would lower the left-out error by 2.0 %, less than 2 %");
    assert_eq!(
        lacks(0.19, 2.4, 99.0, 9.0).unwrap(),
        "the left-out error falls by 10.0 %, but not beyond its scatter between blocks (2.4 standard errors)"
    );
    assert_eq!(
        lacks(0.19, 2.6, 8.9, 9.0).unwrap(),
        "the best of all candidates does as well by chance in more than 1 % of trials"
    );
    assert_eq!(lacks(0.061, 2.6, 9.1, 9.0), None);
    assert_eq!(lacks(1.2, 2.6, 9.1, 9.0), None);
}

/// Two logs' worth of points, few and noisy, with Coulomb friction of a size.
fn few(seed: usize, size: f64) -> Bench {
    let point = |k: usize| {
        let place = k + 1000 * seed;
        let (w, i) = (100.0 * noise(place), 5.0 * noise(place + 5000));
        [w, i, RATIO * (CONSTANT * i - size * w.signum()) + 0.15 * noise(place + 9000)]
    };
    bench(RATIO, &[(0..90).map(point).collect()], 0)
}

/// Weak effects are refused for what they lack, each told by its own numbers.
#[test]
fn weak_effects_are_refused_for_what_they_lack() {
    let (mut refusals, mut found) = (0, 0);
    for seed in 0..60 {
        let bench = few(seed, 0.004 + 0.0004 * seed as f64);
        let work = work(&bench);
        let fit = work.fit();
        let mut selection = Selection::new(&work);
        let all = evaluate_all(&work, &fit, &selection.open);
        let threshold = chance_threshold(&work, &all);
        let basics = selection.basics_suffice(&work, &fit, &all);
        selection.next(&work);
        for candidate in &all {
            let name = candidate.effect.name();
            let refused = selection.refused.iter().find(|r| r.name == name).map(|r| r.reason.as_str());
            let waits = refused.is_some_and(|r| r.contains("comes first"));
            if waits || basics && !candidate.effect.is_basic() {
                continue;
            }
            match lacks(candidate.gain, candidate.sure, candidate.scores.statistic(), threshold) {
                Some(reason) => {
                    assert_eq!(refused, Some(reason.as_str()), "{seed} {name}");
                    refusals += 1;
                }
                None => {
                    let why = refused.unwrap_or_default();
                    assert!(!["less than", "lower the", "scatter", "chance"].iter().any(|w| why.contains(w)), "{why}");
                    found += 1;
                }
            }
        }
    }
    assert!(refusals > 20 && found > 20, "{refusals} {found}");
}

/// What is in the model goes where its gain is no surer than scatter, whatever the gain.
#[test]
fn what_is_not_sure_is_dropped() {
    let (mut outcomes, mut near) = ([0; 2], 0);
    for seed in 0..90 {
        let bench = few(seed, 0.005 + 0.0002 * seed as f64);
        let mut work = work(&bench);
        add(&mut work, "coulomb_friction", 0.0);
        let fit = work.fit();
        let without = work.left_out_without(1);
        let gain = 1.0 - finite_sum(&fit.left_out) / finite_sum(&without);
        let scores = scores_of(&work, 1);
        let sure = informed(&without, &fit.left_out, &scores.expected_falls(), scores.variance());
        if gain < 0.5 * WORTH || believed(&work, 1).is_err() {
            continue;
        }
        let mut selection = Selection::default();
        drop_superfluous(&mut selection, &mut work);
        assert_eq!(work.terms.len() == 2, sure >= SURE - 0.5, "{seed}: {gain} {sure}");
        outcomes[usize::from(work.terms.len() == 2)] += 1;
        near += usize::from((sure - SURE).abs() < 0.5);
    }
    assert!(outcomes.iter().all(|n| *n > 5) && near > 5, "{outcomes:?} {near}");
}

/// Where the current follows the speed, another torque constant and a friction are one; where it does not, they are two.
#[test]
fn a_held_parameter_that_looks_like_an_effect_is_told() {
    let alike = |own: f64| {
        let point = |k: usize| {
            let w = 100.0 * noise(k);
            let i = 0.05 * w + own * noise(k + 4000);
            [w, i, 6.0 * (CONSTANT * i - 2e-3 * w) + 0.02 * noise(k + 9000)]
        };
        let bench = bench(6.0, &[(0..800).map(point).collect()], 0);
        let mut work = work(&bench);
        let none = Work { terms: Vec::new(), ..work.clone() };
        work.hold_as(&none);
        add(&mut work, "viscous_friction", 0.0);
        held_look_alike(&work, 0, &[Base::TorqueConstant])
    };
    assert_eq!(alike(1e-3), Some(Base::TorqueConstant));
    assert_eq!(alike(4.0), None);
}

/// Eddy drag that was found alone stands for viscous friction too: beside that it is found again, with its own knee. Where there
/// is no viscous friction, none is found.
#[test]
fn a_shape_that_stands_for_two_is_found_again_beside_the_other() {
    let eddy = effect("eddy_drag").unwrap();
    let found = |viscous: f64| {
        let bench = plain(move |_, w| viscous * w + 0.05 * w.signum() + 0.06 * 2.0 * 15.0 * w / (15.0 * 15.0 + w * w));
        let mut work = work(&bench);
        add(&mut work, "coulomb_friction", 0.0);
        // As it would be found first.
        add(&mut work, "eddy_drag", 60.0);
        (0..6).for_each(|_| work.refine_shapes());
        let mut selection = Selection::new(&work);
        for _ in 0..4 {
            for (effect, shape) in selection.next(&work) {
                work.terms.retain(|t| !is(t, effect));
                add(&mut work, effect.name(), shape);
                work.refine_shapes();
            }
        }
        let shape = work.terms.iter().filter_map(Term::effect).find(|(e, _)| *e == eddy).map(|(_, shape)| shape);
        let mut names: Vec<&str> = work.terms.iter().filter_map(Term::effect).map(|(e, _)| e.name()).collect();
        names.sort_unstable();
        (names, shape)
    };
    for (viscous, wanted) in [
        (1.5e-3, vec!["coulomb_friction", "eddy_drag", "viscous_friction"]),
        (0.0, vec!["coulomb_friction", "eddy_drag"]),
    ] {
        let (names, shape) = found(viscous);
        assert_eq!(names, wanted);
        assert!(shape.is_some_and(|s| (13.0..17.0).contains(&s)), "{viscous}: {shape:?}");
    }
}
