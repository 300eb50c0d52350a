//! Searches over whole robots end after counted work, with a bound that holds, and the same for any number of threads.

use std::path::Path;
use std::sync::Arc;

use gearwise::catalog::Catalog;
use gearwise::design::robot::{Options, choose};
use gearwise::input::Source;
use gearwise::requirement::read;

use super::robot_enumeration::{Case, draw, draw_returning, draw_sagging};

/// What a search says after at most so many steps, on so many threads: best total, lower bound, branches, whether it is proved.
fn ended(case: &Case, steps: u64, threads: usize) -> (Option<f64>, Option<f64>, usize, bool) {
    let look = || {
        let options = Options { budgets: false, runner_ups: 0, steps, ..Options::default() };
        let choice = choose(&case.robot, &case.catalog, options).unwrap();
        assert_eq!(choice.proof.certified(), choice.proof.not_proved.is_empty());
        let best = choice.combinations.first().map(|found| found.objective);
        (best, choice.proof.lower_bound, choice.proof.branches, choice.proof.certified())
    };
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(look)
}

#[test]
fn a_search_that_ends_early_has_a_bound_that_holds_on_any_number_of_threads() {
    let (mut open, mut feasible) = (0, 0);
    let cases =
        [draw(2), draw(3), draw(5), draw(11), draw_sagging(20_003), draw_sagging(20_004), draw_returning(40_002)];
    for (k, case) in cases.iter().enumerate() {
        let (best, _, _, certified) = ended(case, Options::default().steps, 1);
        assert!(certified, "{k}");
        feasible += usize::from(best.is_some());
        for steps in [0, 3_000, 30_000, 300_000] {
            let early = ended(case, steps, 1);
            assert_eq!(early, ended(case, steps, 3), "{k}, {steps}");
            let (found, bound, _, certified) = early;
            // No bound is above what there is, and nothing is better than the best.
            assert!(
                bound.zip(best).is_none_or(|(bound, best)| bound <= best * (1.0 + 1e-9)),
                "{k}, {steps}: {early:?}"
            );
            assert!(found.is_none_or(|found| best.is_some_and(|best| found >= best * (1.0 - 1e-6))), "{k}, {steps}");
            assert!(!certified || found.is_some() == best.is_some(), "{k}, {steps}: {early:?} {best:?}");
            open += usize::from(!certified);
        }
    }
    assert!(open >= cases.len() && feasible >= cases.len() / 2, "{open} not proved, {feasible} feasible");
}

/// Four joints that carry one another, on a supply that sags, under budgets of power, mass and what comes back: nothing keeps them, which
/// bounds on the power show long before all combinations are looked at.
#[test]
fn an_arm_that_no_supply_can_feed_is_refused_with_proof() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/robots/sagging_arm");
    let robot = read(&folder.join("requirement.toml")).unwrap_or_else(|problems| panic!("{problems:?}"));
    let motors = std::fs::read_to_string(folder.join("motors.csv")).unwrap();
    let catalog = Catalog::from_sources(vec![Arc::new(Source::new("motors.csv", motors))]).unwrap();
    let choice = choose(&robot, &catalog, Options { budgets: false, ..Options::default() }).unwrap();
    assert!(choice.combinations.is_empty() && choice.proof.certified(), "{:?}", choice.proof);
    // Of 11 motors at each of four joints.
    assert!(choice.proof.branches < 11_usize.pow(4) / 2, "{}", choice.proof.branches);
}
