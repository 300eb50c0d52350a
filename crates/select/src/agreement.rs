//! How well a ranking by a metric agrees with the ranking by the task.

/// Kendall's rank correlation τ_b of two lists, ties corrected: 1 where they order alike, −1 where
/// they order opposite, 0 where they have nothing to do with each other. `None` with fewer than
/// three pairs, or where one list has no order at all (M. G. Kendall, *Biometrika* 33, 1945).
///
/// ```
/// use gearwise_select::agreement::kendall_tau;
/// assert_eq!(kendall_tau(&[1.0, 2.0, 3.0, 4.0], &[10.0, 20.0, 30.0, 40.0]), Some(1.0));
/// assert_eq!(kendall_tau(&[1.0, 2.0, 3.0], &[3.0, 2.0, 1.0]), Some(-1.0));
/// ```
pub fn kendall_tau(a: &[f64], b: &[f64]) -> Option<f64> {
    let n = a.len();
    if n < 3 || b.len() != n {
        return None;
    }
    let (mut concordance, mut pairs_a, mut pairs_b) = (0_i64, 0_i64, 0_i64);
    for i in 0..n {
        for j in 0..i {
            let (x, y) = (order(a[i], a[j]), order(b[i], b[j]));
            concordance += x * y;
            pairs_a += x.abs();
            pairs_b += y.abs();
        }
    }
    let size = ((pairs_a as f64) * (pairs_b as f64)).sqrt();
    (size > 0.0).then(|| concordance as f64 / size)
}

fn order(a: f64, b: f64) -> i64 {
    match a.total_cmp(&b) {
        std::cmp::Ordering::Less => -1,
        std::cmp::Ordering::Equal => 0,
        std::cmp::Ordering::Greater => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::kendall_tau;

    #[test]
    fn ties_are_corrected() {
        // By hand: pairs (1,2) (1,2) (2,2)tie … concordant 5, tied in a 1, of 6.
        let tau = kendall_tau(&[1.0, 2.0, 2.0, 3.0], &[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert!((tau - 5.0 / 30.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(kendall_tau(&[1.0, 1.0, 1.0], &[1.0, 2.0, 3.0]), None);
    }
}
