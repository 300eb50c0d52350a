use super::*;
use crate::program::certificate::lower_bound;
use crate::{Mount, Prepared};
use gearwise_model::actuator::Load;
use gearwise_model::catalog::Catalog;
use gearwise_model::requirement::{self, Objective, Quantity, RatioChoice};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// The largest of some convex functions at u.
fn largest(cuts: &[[f64; 4]], u: f64) -> f64 {
    cuts.iter().map(|c| value(c, u)).fold(f64::NEG_INFINITY, f64::max)
}

/// Best feasible u on a fine grid, refined between its neighbours: no slope is used.
fn scanned(cuts: &[[f64; 4]], rows: &[Row], low: f64, high: f64) -> Option<f64> {
    let feasible = |u: f64| rows.iter().all(|r| r.at(u) <= r.bound * (1.0 + 1e-12));
    let (mut a, mut b, mut best) = (low, high, None);
    for _ in 0..6 {
        let grid: Vec<f64> = (0..=2000).map(|k| a * (b / a).powf(f64::from(k) / 2000.0)).collect();
        let found = grid
            .iter()
            .copied()
            .filter(|u| feasible(*u))
            .min_by(|x, y| largest(cuts, *x).total_cmp(&largest(cuts, *y)))?;
        best = Some(found);
        let place = grid.iter().position(|u| *u == found)?;
        (a, b) = (grid[place.saturating_sub(1)], grid[(place + 1).min(2000)]);
    }
    best
}

/// Random programs of any size: the solver's proposal is the scan's optimum, and its multipliers prove it.
#[test]
fn a_proposal_is_the_optimum_with_multipliers_that_prove_it() {
    let mut random = Pcg64::seed_from_u64(11);
    let (mut solved, mut bound) = (0, 0);
    for _ in 0..150 {
        let (size, middle) =
            (10.0_f64.powf(random.random_range(-6.0..6.0)), 10.0_f64.powf(random.random_range(-2.0..4.0)));
        let (low, high) = (middle * random.random_range(0.01..0.5), middle * random.random_range(2.0..100.0));
        let mut function = |size: f64, concave: f64| {
            let mut c = |least: f64| random.random_range(least..1.0);
            [c(0.0) * size * middle, c(-1.0) * size, c(concave) * size / middle, c(0.0) * size / (middle * middle)]
        };
        let cuts: Vec<[f64; 4]> = (0..3).map(|_| function(size, -1.0)).collect();
        let cuts = &cuts[..1 + solved % 3];
        // Rows of another size, some of which cut the ends off.
        let rows: Vec<Row> = (0..3)
            .map(|k| {
                let coefficients = function(1.0, 0.0);
                let bound = value(&coefficients, middle) * (1.0 + 0.4 * f64::from(k));
                Row { asked: k as usize, sample: None, coefficients, bound }
            })
            .filter(|r| r.bound > 0.0)
            .collect();
        let Some(best) = scanned(cuts, &rows, low, high) else { continue };
        let proposal = propose(cuts, &rows, low, high).expect("the solver answers");
        solved += 1;
        let (truth, found) = (largest(cuts, best), largest(cuts, proposal.u));
        let scale = cuts.iter().map(|c| value(&c.map(f64::abs), best)).fold(0.0, f64::max);
        assert!((found - truth).abs() <= 1e-5 * scale, "{found} {truth} at {} {best}", proposal.u);
        assert!(rows.iter().all(|r| r.excess(proposal.u) < 1e-6));
        // Weak duality with exactly these multipliers meets the optimum.
        let total: f64 = proposal.cuts.iter().sum();
        assert!((total - 1.0).abs() < 1e-5, "{:?}", proposal.cuts);
        let mut combined = [0.0; 4];
        for (cut, m) in cuts.iter().zip(&proposal.cuts) {
            assert!(*m > -1e-6);
            combined.iter_mut().zip(cut).for_each(|(sum, c)| *sum += m.max(0.0) / total * c);
        }
        let multipliers: Vec<(Row, f64)> = rows.iter().copied().zip(proposal.rows.iter().copied()).collect();
        let proved = lower_bound(&combined, &multipliers, low, high);
        assert!(proved <= truth + 1e-9 * scale, "{proved} {truth}");
        assert!(proved >= truth - 1e-4 * scale, "{proved} {truth}");
        bound += usize::from(proposal.rows.iter().zip(&rows).any(|(m, r)| *m > 1e-3 * scale / r.bound));
    }
    assert!(solved > 100 && bound > 20, "{solved} {bound}");
    // What is no number has no proposal.
    assert!(propose(&[[f64::NAN, 0.0, 1.0, 0.0]], &[], 1.0, 2.0).is_none());
}

#[test]
fn known_rows_and_cuts_are_not_added_again() {
    let row = |asked: usize, c: f64| Row { asked, sample: None, coefficients: [c, 0.0, 1.0, 0.0], bound: 2.0 };
    let mut rows = vec![row(0, 1.0), row(1, 1.0), row(0, 1.0), row(0, 2.0)];
    assert!(contains(&rows, &row(0, 2.0)) && !contains(&rows, &row(1, 2.0)) && !contains(&rows, &row(2, 1.0)));
    dedup(&mut rows);
    assert_eq!(rows.iter().map(|r| (r.asked, r.coefficients[0])).collect::<Vec<_>>(), [(0, 1.0), (1, 1.0), (0, 2.0)]);
    let mut cuts = Vec::new();
    assert!(add(&mut cuts, [1.0; 4]) && !add(&mut cuts, [1.0; 4]) && add(&mut cuts, [2.0; 4]));
    assert_eq!(cuts.len(), 2);
}

/// Without the solver: the valley of the objective, found from anywhere in the window, and the bound that proves it.
#[test]
fn the_valley_of_an_objective_is_found_and_proved_without_the_solver() {
    let catalog = Catalog::builtin().unwrap();
    let robot = requirement::read(
        concat!(env!("CARGO_MANIFEST_DIR"), "/../../requirements/quadruped_mini_cheetah.toml").as_ref(),
    )
    .unwrap();
    let mut kinks = 0;
    for joint in &robot.joints {
        for id in ["t-motor-ri50", "t-motor-u8"] {
            let motor = catalog.motor(id).unwrap();
            let load = Load::new(&joint.motion, joint.ripple());
            let prepared = Prepared::new(Mount::new(&robot, joint, &load, motor).candidate().unwrap());
            let RatioChoice::Continuous { .. } = joint.ratio else { continue };
            for quantity in [Quantity::Loss, Quantity::PeakCurrent, Quantity::Energy, Quantity::PeakPower] {
                let objective = Objective::single(quantity);
                let program = RatioProgram::new(&prepared, &objective, 1.0, 100.0);
                let goal = Goal::new(&program);
                if program.why_not_convex().is_some() {
                    continue;
                }
                let at = |u: f64| goal.value(u.sqrt());
                let scan = |a: f64, b: f64| {
                    let (mut a, mut b) = (a, b);
                    for _ in 0..5 {
                        let grid: Vec<f64> = (0..=400).map(|k| a * (b / a).powf(f64::from(k) / 400.0)).collect();
                        let best = (0..=400).min_by(|x, y| at(grid[*x]).total_cmp(&at(grid[*y]))).unwrap();
                        (a, b) = (grid[best.saturating_sub(1)], grid[(best + 1).min(400)]);
                    }
                    0.5 * (a + b)
                };
                let valley = scan(1.0, 1e4);
                let same = |u: f64, expected: f64| {
                    assert!(at(u) <= at(expected) * (1.0 + 1e-9), "{id} {quantity:?}: {u} {expected}");
                };
                same(lowest(&goal, 1.0, 1e4), valley);
                // Windows beside the valley have their best ratio at an end.
                if valley > 20.0 && valley < 5000.0 {
                    assert_eq!(lowest(&goal, 1.0, 0.5 * valley), 0.5 * valley);
                    assert_eq!(lowest(&goal, 2.0 * valley, 1e4), 2.0 * valley);
                }
                if !(1.0001..=9000.0).contains(&valley) {
                    continue;
                }
                // From near the valley and from far, and no further than the window.
                for (from, start, end) in [
                    (valley * 1.0005, 1.0, 1e4),
                    (valley * 0.9995, 1.0, 1e4),
                    (valley * 1.3, 1.0, 1e4),
                    (valley * 40.0, 1.0, 1e4),
                    (valley * 0.7, 1.0, 1e4),
                    (valley * 1.0005, valley * 1.0002, 1e4),
                    (valley * 0.9995, 1.0, valley * 0.9998),
                ] {
                    let from = from.clamp(start, end);
                    let found = sharpen(&goal, from, start, end);
                    assert!(found >= start * (1.0 - 1e-12) && found <= end * (1.0 + 1e-12));
                    same(found, valley.clamp(start, end));
                }
                // The cuts on either side of the valley combine to one that is flat there, and below everywhere.
                let flat = balanced_cuts(&goal, valley);
                let scale = value(&flat.map(f64::abs), valley);
                assert!((value(&flat, valley) - at(valley)).abs() < 1e-6 * scale);
                for u in [0.2 * valley, 0.9 * valley, 1.1 * valley, 5.0 * valley] {
                    assert!(value(&flat, u) <= at(u) + 1e-6 * value(&flat.map(f64::abs), u));
                }
                let bound = balanced_bound(&flat, &[], valley, 1.0, 1e4);
                assert!(bound <= at(valley) + 1e-9 * scale && bound > at(valley) - 1e-5 * scale, "{id} {quantity:?}");
                let left = goal.cut((valley * (1.0 - 1e-6)).sqrt()).in_square();
                let right = goal.cut((valley * (1.0 + 1e-6)).sqrt()).in_square();
                kinks += usize::from(left != right);
                // A row that binds to the right of the valley: its multiplier lifts the bound to the value there.
                let u = 1.5 * valley;
                let row = Row {
                    asked: 0,
                    sample: None,
                    coefficients: [valley * valley, 0.0, 0.0, 0.0],
                    bound: valley * valley / u,
                };
                let slack = Row { bound: 2.0 * row.bound, ..row };
                let here = goal.cut(u.sqrt()).in_square();
                let proved = balanced_bound(&here, &[slack, row], u, 1.0, 1e4);
                assert!((proved - value(&here, u)).abs() < 1e-6 * value(&here.map(f64::abs), u));
                assert!(balanced_bound(&here, &[slack], u, 1.0, 1e4) < value(&here, u));
            }
        }
    }
    assert!(kinks > 0);
}
