//! The simulator judged by itself: before it may judge the library, its own physics must hold.

mod simulator;

use simulator::scenario;

/// Rms of values.
fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn dynamometer_cogging_has_the_size_asked_for() {
    for size in [1.5, 5.0] {
        let folder = tempfile::tempdir().unwrap();
        let truth = scenario("cogging", size, 1).write(folder.path());
        assert!((truth.effects[0].rms / truth.noise_rms / size - 1.0).abs() < 0.1);
        let all: Vec<f64> = truth.logs.iter().flat_map(|l| l.contribution.iter().copied()).collect();
        assert!((rms(&all) / truth.noise_rms / size - 1.0).abs() < 0.1, "{}", rms(&all) / truth.noise_rms);
    }
}
