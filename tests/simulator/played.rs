//! A run that is played to a bench.

use super::profile::{Profile, Segment};

/// Set-points that a bench plays, at even times.
#[derive(Debug, Clone)]
pub struct Played {
    /// Time between them \[s\].
    pub step: f64,
    /// Speed: of the output on a dynamometer, of the motor elsewhere.
    pub motion: Vec<f64>,
    /// Current \[A\].
    pub current: Vec<f64>,
}

impl Played {
    /// As a drive follows it: behind three lags of 30 Hz.
    pub(super) fn profile(&self, values: &[f64], step: f64) -> Profile {
        let segment = |(k, level): (usize, &f64)| Segment { start: k as f64 * self.step, level: *level, sines: 0.0 };
        Profile::new(step, 30.0, values.iter().enumerate().map(segment).collect(), &[])
    }
}
