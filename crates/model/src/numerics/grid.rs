//! Numbers spaced over a range.

/// `count` numbers from `min` to `max`, evenly spaced in their logarithm.
pub fn grid(min: f64, max: f64, count: usize) -> Vec<f64> {
    match count {
        0 => Vec::new(),
        1 => vec![(min * max).sqrt()],
        _ => (0..count)
            .map(|i| if i + 1 == count { max } else { min * (max / min).powf(i as f64 / (count - 1) as f64) })
            .collect(),
    }
}
