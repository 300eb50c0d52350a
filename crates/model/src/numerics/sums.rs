//! Sums over lists in which some numbers are missing.

/// How much smaller the second list of squared errors is than the first, in standard errors of the mean
/// difference between blocks; zero where too few blocks are there.
pub fn paired(before: &[f64], after: &[f64]) -> f64 {
    let differences: Vec<f64> = before.iter().zip(after).map(|(a, b)| a - b).filter(|d| d.is_finite()).collect();
    let n = differences.len() as f64;
    if n < 4.0 {
        return 0.0;
    }
    let mean = differences.iter().sum::<f64>() / n;
    let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0);
    if variance > 0.0 { mean / (variance / n).sqrt() } else { 0.0 }
}

/// The sum of the finite entries.
pub fn finite_sum(values: &[f64]) -> f64 {
    values.iter().filter(|v| v.is_finite()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// `t = mean / √(variance/n)` of the differences between blocks.
    #[test]
    fn a_paired_comparison_is_in_standard_errors() {
        // Differences 1, 2, 3, 4: mean 2.5, variance 5/3.
        let (before, after) = ([3.0, 4.0, 5.0, 6.0, f64::NAN], [2.0, 2.0, 2.0, 2.0, 1.0]);
        assert_relative_eq!(paired(&before, &after), 2.5 / (5.0_f64 / 3.0 / 4.0).sqrt(), max_relative = 1e-12);
        assert_relative_eq!(paired(&after, &before), -paired(&before, &after));
        // Three blocks say nothing, nor do differences that are all the same.
        assert_eq!(paired(&before[..3], &after[..3]), 0.0);
        assert_eq!(paired(&[2.0; 6], &[1.0; 6]), 0.0);
        assert_eq!(finite_sum(&[1.0, f64::NAN, 2.0, f64::INFINITY]), 3.0);
    }
}
