//! What a model leaves of the measured position.

use super::judges::Judges;
use crate::answer::{On, Unexplained};
use crate::signals;
use crate::simulate::track::Track;
use gearwise_model::effects::Variable;

/// Error over the noise of the sensor beyond which something is left.
const LEFT: f64 = 3.0;

/// Noise of the measured positions \[rad\], from what does not go on from sample to sample; not less than that of the steps
/// that they are read in, and zero where it is not known.
pub(super) fn noise(all: &[Track]) -> f64 {
    let levels: Vec<f64> = all
        .iter()
        .map(|t| {
            let known: Vec<f64> = t.position.iter().copied().filter(|p| p.is_finite()).collect();
            let squares: Vec<f64> = known.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).collect();
            let steps = known.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0);
            let step = steps.fold(f64::INFINITY, f64::min);
            (signals::quantile(squares.clone(), 0.5).unwrap_or(0.0) / 0.455 / 20.0)
                .max(0.25 * squares.iter().sum::<f64>() / 20.0 / squares.len().max(1) as f64)
                .max(if step.is_finite() { step * step / 12.0 } else { 0.0 })
                .sqrt()
        })
        .collect();
    signals::median(levels).unwrap_or(0.0)
}

/// What is left and what it goes with: means over classes of speed and position, and of each log.
pub(super) fn left(judges: &Judges, residuals: &[Vec<f64>], floor: f64) -> Vec<Unexplained> {
    let all: Vec<f64> = residuals.iter().flatten().copied().collect();
    let total: f64 = all.iter().map(|r| r * r).sum();
    let error = (total / all.len().max(1) as f64).sqrt();
    if error.is_nan() || floor <= 0.0 || error <= LEFT * floor {
        return Vec::new();
    }
    let speeds: Vec<f64> = judges.fit.iter().flat_map(|t| speed(t)).collect();
    let positions: Vec<f64> = judges.fit.iter().flat_map(|t| t.position.clone()).collect();
    let share = |variable: &[f64]| {
        const CLASSES: usize = 24;
        let mut sorted: Vec<f64> = variable.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let mut sums = [(0.0, 0.0); CLASSES];
        for (v, r) in variable.iter().zip(&all).filter(|(v, _)| v.is_finite()) {
            let rank = sorted.partition_point(|s| s < v) * CLASSES / sorted.len().max(1);
            let class = &mut sums[rank.min(CLASSES - 1)];
            *class = (class.0 + r, class.1 + 1.0);
        }
        sums.iter().filter(|s| s.1 > 0.0).map(|s| s.0 * s.0 / s.1).sum::<f64>() / total
    };
    let mut found: Vec<(On, f64)> =
        vec![(On::Variable(Variable::Speed), share(&speeds)), (On::Variable(Variable::OutputAngle), share(&positions))];
    found.retain(|f| f.1 > 0.1);
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let times = error / floor;
    let mut list: Vec<Unexplained> = found
        .into_iter()
        .map(|(on, share)| Unexplained {
            depends_on: on,
            detail: format!(
                "a free function of {} takes away {:.0} % of the squared error that is left",
                on.name(),
                100.0 * share
            ),
        })
        .collect();
    if list.is_empty() {
        list.push(Unexplained {
            depends_on: On::Time,
            detail: format!("the error of the simulated position is {times:.0} times the sensor's noise"),
        });
    }
    list
}

/// Speed at the output from the measured position, over some 20 ms.
pub(super) fn speed(track: &Track) -> Vec<f64> {
    let step = signals::median_step(&track.time).max(f64::MIN_POSITIVE);
    let over = signals::covering(0.01 / step);
    let (path, last) = (track.path(), track.len() - 1);
    if path.is_empty() {
        return vec![f64::NAN; track.len()];
    }
    (0..track.len())
        .map(|k| {
            let (a, b) = (k.saturating_sub(over), (k + over).min(last));
            (path[b] - path[a]) / (track.time[b] - track.time[a])
        })
        .collect()
}
