use super::super::steady::{CONSTANT, add, bench, noise, work};
use super::*;
use crate::actuator::effects::effect;
use crate::measured::Bench;

const RATIO: f64 = 6.0;

fn scores(values: &[&[f64]]) -> Vec<DVector<f64>> {
    values.iter().map(|v| DVector::from_column_slice(v)).collect()
}

/// `sᵀ (Σ s_b s_bᵀ)⁻¹ s / d` with the sum s of the scores.
#[test]
fn the_statistic_is_that_on_paper() {
    let one = scores(&[&[1.0], &[2.0], &[3.0]]);
    assert!((statistic(&one) - 36.0 / 14.0).abs() < 1e-8);
    // With signs +, −, +: 2² / 14.
    assert!((signed_statistic(&one, |b| if b == 1 { -1.0 } else { 1.0 }) - 4.0 / 14.0).abs() < 1e-8);
    // Two numbers: sum (3, 1), scatter [[5, −1], [−1, 3]], inverse [[3, 1], [1, 5]]/14: (27 + 6 + 5)/14/2.
    let two = scores(&[&[1.0, 1.0], &[2.0, -1.0], &[0.0, 1.0]]);
    assert!((statistic(&two) - 38.0 / 28.0).abs() < 1e-8, "{}", statistic(&two));
    assert_eq!(statistic(&[]), 0.0);
    assert_eq!(statistic(&scores(&[&[0.0], &[0.0]])), 0.0);
}

/// Scores of one size in every block: chance is a walk of n steps, whose square over n is beyond 6.6 in 1 % of all.
#[test]
fn chance_is_a_random_walk() {
    let bench = plain(|_, _| 0.0);
    let work = work(&bench);
    let blocks = work.folds.iter().flatten().count();
    let candidate = |scores: Vec<DVector<f64>>| Candidate {
        effect: effect("coulomb_friction").unwrap(),
        shape: 0.0,
        values: Vec::new(),
        left_out: Vec::new(),
        gain: 0.0,
        sure: 0.0,
        scores,
        columns: Vec::new(),
    };
    let same = candidate((0..blocks).map(|_| DVector::from_element(1, 1.0)).collect());
    let threshold = chance_threshold(&work, std::slice::from_ref(&same));
    assert!(threshold > 4.5 && threshold < 9.0, "{threshold} of {blocks} blocks");
    // (Σ ±1)²/n: n less an even number, squared.
    let steps = (threshold * blocks as f64).sqrt();
    assert!((steps - steps.round()).abs() < 1e-5 && (steps.round() as usize + blocks).is_multiple_of(2), "{steps}");
    // The best of many walks goes farther than one, and nothing goes nowhere.
    let many: Vec<Candidate> = (0..20)
        .map(|c| candidate((0..blocks).map(|b| DVector::from_element(1, noise(1000 * c + b))).collect()))
        .collect();
    let of_many = chance_threshold(&work, &many);
    assert!(of_many > 1.15 * chance_threshold(&work, &many[..1]) && of_many < 20.0, "{of_many}");
    assert_eq!(chance_threshold(&work, &[]), 0.0);
}

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

/// An effect that one log does not have is refused by that log; with one log there is nobody to object.
#[test]
fn a_log_that_gets_worse_objects() {
    let coulomb = effect("coulomb_friction").unwrap();
    let object = |drag: &dyn Fn(usize, f64) -> f64| {
        let bench = plain(drag);
        let work = work(&bench);
        let candidate = evaluate(&work, &work.fit(), coulomb, 0.0).unwrap();
        log_that_objects(&work, &candidate)
    };
    assert_eq!(object(&|_, w| 0.05 * w.signum()), None);
    assert_eq!(object(&|log, w| if log == 1 { -0.05 } else { 0.05 } * w.signum()), Some(1));
    assert_eq!(object(&|log, w| if log == 2 { 0.0 } else { 0.05 } * w.signum()), Some(2));
    // A log with half as much is better off with it than without.
    assert_eq!(object(&|log, w| if log == 2 { 0.035 } else { 0.05 } * w.signum()), None);
    // Two logs are enough to object.
    let pair = |log: usize| -> Vec<[f64; 3]> {
        let sign = if log == 0 { 1.0 } else { -1.0 };
        let point = |k: usize| {
            let (w, i) = (100.0 * noise(300 * log + k), 5.0 * noise(300 * log + k + 5000));
            [w, i, RATIO * (CONSTANT * i - sign * 0.05 * w.signum()) + 0.03 * noise(300 * log + k + 9000)]
        };
        (0..300).map(point).collect()
    };
    let two = super::super::steady::bench(RATIO, &[pair(0), pair(1)], 0);
    let of_two = super::super::steady::work(&two);
    let candidate = evaluate(&of_two, &of_two.fit(), coulomb, 0.0).unwrap();
    assert_eq!(log_that_objects(&of_two, &candidate), Some(0));
    let alone: Vec<[f64; 3]> = (0..300).map(|k| [100.0 * noise(k), noise(k + 500), noise(k + 900)]).collect();
    let bench = bench(RATIO, &[alone], 0);
    let work = work(&bench);
    let candidate = evaluate(&work, &work.fit(), coulomb, 0.0).unwrap();
    assert_eq!(log_that_objects(&work, &candidate), None);
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
    near(viscous.sure, paired(&fit.left_out, &viscous.left_out));
    assert!(viscous.sure > 5.0 && statistic(&viscous.scores) > 10.0);
    // The score of each block: the part of the column that the model does not make up, times its residual.
    let residual = work.residual(&fit);
    let of_model = &work.terms[0].columns[0];
    let over = |a: &[f64], b: &[f64]| {
        let rows = (0..a.len()).filter(|k| work.fits(work.balance.rows.block[*k]));
        rows.map(|k| a[k] * b[k]).sum::<f64>()
    };
    let share = over(v, of_model) / over(of_model, of_model);
    for (b, score) in viscous.scores.iter().enumerate() {
        let rows = (0..residual.len()).filter(|k| work.balance.rows.block[*k] == fitting(&work)[b]);
        let by_hand: f64 = rows.map(|k| (v[k] - share * of_model[k]) * residual[k]).sum();
        assert!((score[0] - by_hand).abs() < 1e-9 * score[0].abs().max(1e-3), "{b}: {} {by_hand}", score[0]);
    }
    // A column that the model makes up already is no candidate, nor one that is nothing or no number.
    let mut twice = work_with(&bench, "viscous_friction");
    assert!(evaluate(&twice, &twice.fit(), effect("viscous_friction").unwrap(), 0.0).is_none());
    assert!(evaluate(&twice, &twice.fit(), effect("coulomb_friction").unwrap(), 0.0).is_some());
    assert!(evaluate(&twice, &twice.fit(), effect("cogging").unwrap(), 6.0).is_none());
    twice.terms.pop();
    assert!(evaluate(&twice, &twice.fit(), effect("viscous_friction").unwrap(), 0.0).is_some());
}

fn fitting(work: &Work) -> Vec<usize> {
    (0..work.folds.len()).filter(|b| work.fits(*b)).collect()
}

fn work_with<'a>(bench: &'a Bench, name: &str) -> Work<'a> {
    let mut work = work(bench);
    add(&mut work, name, 0.0);
    work
}

/// With the last coefficients given, the others are fitted to what they leave.
#[test]
fn squares_with_given_coefficients() {
    let columns: [Vec<f64>; 3] = [0, 1, 2].map(|j| (0..50).map(|k| noise(100 * j + k)).collect());
    let target: Vec<f64> = (0..50).map(|k| noise(700 + k)).collect();
    let all: Vec<&[f64]> = columns.iter().map(Vec::as_slice).chain([target.as_slice()]).collect();
    let total = DMatrix::from_fn(4, 4, |i, j| all[i].iter().zip(all[j]).map(|(a, b)| a * b).sum());
    for given in [[0.0, 0.0], [0.4, -0.7]] {
        let rest: Vec<f64> = (0..50).map(|k| target[k] - given[0] * columns[1][k] - given[1] * columns[2][k]).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let beta = dot(&columns[0], &rest) / dot(&columns[0], &columns[0]);
        let left = dot(&rest, &rest) - beta * beta * dot(&columns[0], &columns[0]);
        assert!((squares_given(&total, 1, &given) - left).abs() < 1e-9);
    }
    let left = projected_norms(&total, 1, 2);
    for j in 0..2 {
        let (own, cross) = (total[(1 + j, 1 + j)], total[(0, 1 + j)]);
        assert!((left[j] - (own - cross * cross / total[(0, 0)])).abs() < 1e-9);
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
        let found = selection.next(&work).map(|(e, _)| e.name());
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
    // One log that has the opposite objects by its name.
    let (found, selection) = next(&plain(|log, w| if log == 1 { 0.0 } else { 0.05 } * w.signum()), &[]);
    assert_ne!(found, Some("coulomb_friction"));
    assert_eq!(reason(&selection, "coulomb_friction"), "fitted on the other logs it makes `1.csv` worse");
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
        let mut selection = Selection { refused: Vec::new(), open: Vec::new() };
        selection.drop_superfluous(&mut work);
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
    let absurd = plain(|_, w| -2e-4 * w + 0.05 * w.signum());
    let (left, refused) = dropped(&absurd, &[("viscous_friction", 0.0), ("coulomb_friction", 0.0)]);
    assert_eq!(left, ["coulomb_friction"]);
    assert_eq!(refused[0].reason, "with all that was found its value is not plausible");
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
    assert!(!selection.look_alikes(&work, 1).contains(&"coulomb_friction"));
    assert!(!selection.look_alikes(&work, 1).contains(&"viscous_friction"));
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
    assert!(alike.contains(&"viscous_friction"), "{alike:?}");
}
