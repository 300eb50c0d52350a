use super::super::noise::{Estimate, Method};
use super::*;

/// Instruments that say so much.
fn noise(values: &[f64]) -> Noise {
    let methods = [Method::Standstill, Method::AboveTheBand, Method::SecondDifferences];
    let estimate = |(v, m): (&f64, &Method)| Estimate { method: *m, value: Ok(*v) };
    Noise { estimates: values.iter().zip(&methods).map(estimate).collect(), line: None }
}

fn gain(share: f64, error: f64) -> Gain {
    Gain { share, error }
}

/// Everything that is needed for nothing to be missing.
fn clean() -> Evidence {
    Evidence {
        found: 0,
        unexplained: 0,
        left: 1.1,
        far_off: None,
        held_out: Some(1.12),
        noise: noise(&[1.0, 1.2]),
        asked: vec![
            Asked { name: "cogging", gain: gain(0.01, 0.005) },
            Asked { name: "gravity", gain: gain(-0.01, 0.01) },
        ],
        together: Some(gain(0.02, 0.005)),
        worse_by_refitting: false,
        better: None,
        contradicted: false,
        owned: false,
        left_out: 0,
        worse_held_out: false,
        dead: None,
        unrelated: false,
        still: false,
    }
}

#[test]
fn nothing_is_missing_only_where_everything_shows_it() {
    assert_eq!(verdict(&clean()), Verdict::NothingMissing);
    let with = |change: fn(&mut Evidence)| {
        let mut evidence = clean();
        change(&mut evidence);
        verdict(&evidence)
    };
    // Of a channel that never moves nothing is known.
    assert_eq!(with(|e| e.dead = Some(Channel::Torque)), Verdict::NotResolved);
    // Nor where it does not follow the model, as noise does not: whatever else fits.
    assert_eq!(with(|e| e.unrelated = true), Verdict::NotResolved);
    let chance = gain(0.001, 0.002);
    assert!(Evidence::does_not_follow(0.1, Some(-0.1), chance) && Evidence::does_not_follow(0.1, None, chance));
    // A little that is sure is something, and so is much that comes in a few blocks.
    assert!(!Evidence::does_not_follow(0.1, Some(0.1), gain(0.001, 0.0002)));
    assert!(
        !Evidence::does_not_follow(98.0, Some(98.0), gain(0.98, 0.9))
            && !Evidence::does_not_follow(1.0, Some(98.0), chance)
    );
    // More is left than noise, on either part.
    assert_eq!(with(|e| e.left = 1.16), Verdict::NoneOfThese);
    assert_eq!(with(|e| e.held_out = Some(1.16)), Verdict::NoneOfThese);
    assert_eq!(with(|e| e.held_out = None), Verdict::NothingMissing);
    // The noise is not known: one way, none, or two that contradict each other.
    assert_eq!(with(|e| e.noise = noise(&[1.0])), Verdict::NoneOfThese);
    assert_eq!(with(|e| e.noise = Noise::default()), Verdict::NoneOfThese);
    assert_eq!(with(|e| e.noise = noise(&[1.0, 2.1])), Verdict::NoneOfThese);
    assert_eq!(with(|e| e.noise = noise(&[1.0, 2.0])), Verdict::NothingMissing);
    // Something stands above the band; refitting did harm.
    assert_eq!(with(|e| e.noise.line = Some(50.0)), Verdict::NoneOfThese);
    assert_eq!(with(|e| e.worse_by_refitting = true), Verdict::NoneOfThese);
    // What is ruled out beforehand is not asked, and a model that judges worse than the declared one says nothing.
    assert_eq!(with(|e| e.left_out = 1), Verdict::NoneOfThese);
    assert_eq!(with(|e| (e.found, e.worse_held_out) = (1, true)), Verdict::NotResolved);
    // What owned the error and was left out is not explained.
    assert_eq!(with(|e| e.owned = true), Verdict::NotResolved);
    // An effect alone, or all together, could still take away more than 3 %; or that was not tried.
    assert_eq!(with(|e| e.asked[0].gain = gain(0.05, 0.02)), Verdict::NotResolved);
    assert_eq!(with(|e| e.together = Some(gain(0.05, 0.02))), Verdict::NotResolved);
    assert_eq!(with(|e| e.together = Some(gain(0.0, f64::INFINITY))), Verdict::NotResolved);
    assert_eq!(with(|e| e.together = None), Verdict::NotResolved);
    // What was found, or is left, is told whatever the noise is.
    assert_eq!(with(|e| e.found = 1), Verdict::Explained);
    assert_eq!(with(|e| (e.found, e.together) = (1, None)), Verdict::Explained);
    assert_eq!(with(|e| (e.found, e.unexplained) = (1, 1)), Verdict::UnexplainedStructure);
    assert_eq!(with(|e| e.unexplained = 1), Verdict::UnexplainedStructure);
    assert_eq!(verdict(&Evidence::unbounded(0, 0, 1.0)), Verdict::NotResolved);
    assert_eq!(verdict(&Evidence::unbounded(2, 0, 1.0)), Verdict::Explained);
}

/// Differences 1, 2, 3, 4 of 20: a share of 0.5, with √(n · variance) = √(4 · 5/3) over 20.
#[test]
fn a_gain_is_a_share_with_its_error() {
    let (before, after) = ([4.0, 5.0, 5.0, 6.0, f64::NAN], [3.0, 3.0, 2.0, 2.0, 1.0]);
    let gain = Gain::new(&before, &after);
    approx::assert_relative_eq!(gain.share, 0.5, max_relative = 1e-12);
    approx::assert_relative_eq!(gain.error, (20.0_f64 / 3.0).sqrt() / 20.0, max_relative = 1e-12);
    approx::assert_relative_eq!(gain.fall(), 1.0 - 0.5_f64.sqrt(), max_relative = 1e-12);
    approx::assert_relative_eq!(gain.sure(), 0.5 / gain.error, max_relative = 1e-12);
    let most = 1.0 - (1.0 - 0.5 - 1.746 * gain.error).sqrt();
    approx::assert_relative_eq!(gain.most(), most, max_relative = 1e-12);
    // Where nothing is left, or too few blocks judge, nothing is bounded.
    assert_eq!(Gain::new(&[0.0; 9], &[0.0; 9]).most(), 1.0);
    assert_eq!(Gain::new(&before[..3], &after[..3]).most(), 1.0);
    assert_eq!(Gain::new(&[0.0; 9], &[0.0; 9]).sure(), 0.0);
    // What does harm explains nothing; a rise of less than 1 %, or within its scatter, is no harm.
    assert_eq!(self::gain(-0.5, 0.01).most(), 0.0);
    let harm = [(-0.5, 0.01), (-0.05, 0.02), (-0.05, 0.04), (-0.015, 1e-4), (0.5, 0.01)]
        .map(|(s, e)| self::gain(s, e).is_harm());
    assert_eq!(harm, [true, true, false, false, false]);
}

#[test]
fn verdicts_have_their_words_and_the_weakest_claim_stands() {
    use Verdict::*;
    let all = [NothingMissing, NoneOfThese, NotResolved, Explained, UnexplainedStructure];
    let words = ["nothing_missing", "none_of_these", "not_resolved", "explained", "unexplained_structure"];
    assert_eq!(all.map(Verdict::word), words);
    for (i, a) in all.iter().enumerate() {
        for (j, b) in all.iter().enumerate() {
            assert_eq!(Verdict::over([*a, *b]), all[i.max(j)]);
        }
    }
    assert_eq!(Verdict::over([]), NotResolved);
}

#[test]
fn the_most_is_that_of_all_and_of_each() {
    let mut evidence = clean();
    let alone = evidence.asked[0].gain.most();
    let together = evidence.together.unwrap().most();
    assert_eq!(evidence.most(), Some(alone.max(together)));
    assert_eq!(evidence.strongest().unwrap().name, "cogging");
    approx::assert_relative_eq!(evidence.times_the_noise().unwrap(), 1.1, max_relative = 1e-12);
    // A held-out log that is far beyond the noise is told; one that is at it is not.
    let held = |times: f64| Evidence {
        held_out: Some(times * evidence.left / 1.1),
        left: evidence.left,
        noise: evidence.noise.clone(),
        ..Evidence::default()
    };
    approx::assert_relative_eq!(held(9.0).held_out_times_the_noise().unwrap(), 9.0, max_relative = 1e-12);
    assert_eq!(held(1.12).held_out_times_the_noise(), None);
    evidence.together = None;
    assert_eq!(evidence.most(), None);
}

/// No name is certain where channels contradict each other, where less than the instrument's noise is left, or where a model
/// that is not believed does better: also where an effect was found.
#[test]
fn what_explains_noise_or_contradictions_has_no_name() {
    let with = |change: fn(&mut Evidence)| {
        let mut evidence = Evidence { found: 1, ..clean() };
        change(&mut evidence);
        verdict(&evidence)
    };
    assert_eq!(with(|_| ()), Verdict::Explained);
    assert_eq!(with(|e| e.contradicted = true), Verdict::NotResolved);
    assert_eq!(with(|e| (e.contradicted, e.found) = (true, 0)), Verdict::NotResolved);
    // The noise is 1.0: a fifth below it is an alarm, a tenth is chance.
    assert_eq!(with(|e| e.left = 0.7), Verdict::NotResolved);
    assert_eq!(with(|e| (e.left, e.unexplained) = (0.7, 1)), Verdict::NotResolved);
    assert_eq!(with(|e| e.left = 0.9), Verdict::Explained);
    // Where the noise is not known nothing is below it.
    assert_eq!(with(|e| (e.left, e.noise) = (0.1, Noise::default())), Verdict::Explained);
    assert_eq!(with(|e| e.better = Some(0.9)), Verdict::NotResolved);
    assert_eq!(with(|e| (e.better, e.unexplained) = (Some(0.9), 1)), Verdict::UnexplainedStructure);
}
