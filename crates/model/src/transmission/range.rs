//! A smallest and a largest value over samples.

/// A smallest and a largest value, each with the sample that has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The smallest.
    pub least: (f64, usize),
    /// The largest.
    pub most: (f64, usize),
}

impl Range {
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Range {
        let start = Range { least: (f64::INFINITY, 0), most: (f64::NEG_INFINITY, 0) };
        values.enumerate().fold(start, |range, (k, value)| Range {
            least: if value < range.least.0 { (value, k) } else { range.least },
            most: if value > range.most.0 { (value, k) } else { range.most },
        })
    }
}
