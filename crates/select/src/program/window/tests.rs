use super::*;
use crate::program::certificate::{balancing_multiplier, lower_bound};
use crate::program::{relative_excess, value};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// `c_w/u + c_0 + c_u u + c_t u²` at a random place and of a random size.
fn function(random: &mut Pcg64, middle: f64, size: f64) -> [f64; 4] {
    let mut c = |least: f64| random.random_range(least..1.0);
    [c(0.0) * size * middle, c(-1.0) * size, c(-1.0) * size / middle, c(0.0) * size / (middle * middle)]
}

fn least_of_grid(c: &[f64; 4], low: f64, high: f64) -> f64 {
    (0..=4000).map(|k| value(c, low * (high / low).powf(f64::from(k) / 4000.0))).fold(f64::INFINITY, f64::min)
}

/// Least value and interval of random rows, against a grid and their own values; nothing is assumed of slopes.
#[test]
fn rows_are_least_and_end_where_a_scan_says() {
    let mut random = Pcg64::seed_from_u64(3);
    let (mut inner, mut cut, mut never) = (0, 0, 0);
    for _ in 0..400 {
        let middle = 10.0_f64.powf(random.random_range(-3.0..5.0));
        let size = 10.0_f64.powf(random.random_range(-5.0..5.0));
        let c = function(&mut random, middle, size);
        let (low, high) = (middle * random.random_range(0.01..0.9), middle * random.random_range(1.1..100.0));
        let u = minimise(&c, low, high);
        let scale = value(&c.map(f64::abs), u);
        assert!(u >= low && u <= high);
        assert!(value(&c, u) <= least_of_grid(&c, low, high) + 1e-14 * scale);
        if u > low && u < high {
            inner += 1;
            // Flat to rounding: a tenth of a millionth aside it is no lower.
            for other in [u * (1.0 - 1e-7), u * (1.0 + 1e-7)] {
                assert!(value(&c, other) >= value(&c, u) - 1e-15 * scale);
            }
            let slope = -c[0] / (u * u) + c[2] + 2.0 * c[3] * u;
            assert!((slope * u).abs() < 1e-12 * scale, "{slope}");
        }
        let share: f64 = random.random_range(-0.3..1.5);
        let above = if share < 0.0 { value(&c, u).abs() } else { value(&c, low).max(value(&c, high)) - value(&c, u) };
        let bound = value(&c, u) + share * above;
        if bound <= 1e-3 * scale {
            continue;
        }
        let row = Row { asked: 0, sample: None, coefficients: c, bound };
        match interval(&row, low, high) {
            None => {
                assert!(share < 0.0);
                never += 1;
            }
            Some((start, end)) => {
                assert!(share >= -1e-9 && start >= low && end <= high && start <= end);
                for (end, range, inwards) in [(start, low, 1.0), (end, high, -1.0)] {
                    if end == range {
                        assert!(row.excess(range) <= 0.0);
                        continue;
                    }
                    cut += 1;
                    assert!((row.at(end) - bound).abs() <= 1e-9 * scale.max(bound), "{} {bound}", row.at(end));
                    assert!(row.excess(end) <= ROW_TOLERANCE);
                    let outside = end * (1.0 - inwards * 1e-4);
                    assert!(outside < low || outside > high || row.at(outside) > bound);
                }
            }
        }
        // Weak duality: with any multipliers the bound is below the objective wherever the rows are kept.
        let f = function(&mut random, middle, 1.0);
        let rows = [(row, random.random_range(0.0..2.0)), (row, random.random_range(-1.0..0.0))];
        let proved = lower_bound(&f, &rows, low, high);
        let by_hand = (0..=2000)
            .map(|k| low * (high / low).powf(f64::from(k) / 2000.0))
            .map(|u| value(&f, u) + rows[0].1 * (row.at(u) - bound))
            .fold(f64::INFINITY, f64::min);
        let size = value(&f.map(f64::abs), middle) + rows[0].1 * (scale + bound.abs());
        assert!(proved <= by_hand && proved >= by_hand - 1e-4 * size.max(by_hand.abs()), "{proved} {by_hand}");
        // The balancing multiplier makes the sum flat, or is zero where it would be negative.
        let multiplier = balancing_multiplier(&f, &row, u * 1.1);
        let at = 1.1 * u;
        let [of_f, of_row] = [f, c].map(|c| -c[0] / (at * at) + c[2] + 2.0 * c[3] * at);
        assert!(multiplier >= 0.0);
        if multiplier > 0.0 {
            assert!((of_f + multiplier * of_row).abs() <= 1e-12 * of_f.abs());
        } else {
            assert!(-of_f / of_row <= 0.0);
        }
    }
    assert!(inner > 100 && cut > 100 && never > 20, "{inner} {cut} {never}");
}

/// Excess is relative to the bound, and where nothing is allowed to the terms whose sum the value is.
#[test]
fn excess_is_relative_to_what_there_is() {
    assert_eq!(relative_excess(3.0, 2.0, || unreachable!()), 0.5);
    assert_eq!(relative_excess(1.0, 2.0, || unreachable!()), -0.5);
    assert!(relative_excess(-1.0, 0.0, || unreachable!()) <= 0.0);
    assert_eq!(relative_excess(3.0, 0.0, || 12.0), 0.25);
    assert_eq!(relative_excess(3.0, 0.0, || 0.0), 3.0);
    let flat = Row { asked: 0, sample: None, coefficients: [0.0, 0.0, 1.0, 0.0], bound: 5.0 };
    let multiplier = balancing_multiplier(&[1.0, 0.0, 0.0, 0.0], &Row { coefficients: [0.0; 4], ..flat }, 1.0);
    assert_eq!(multiplier, 0.0);
}
