//! The band of the filter, and which samples become rows and blocks.

use super::model::Model;
use super::stretch::Stretch;
use crate::Use;
use crate::answer::Target;
use crate::identify::regression::Rows;
use crate::signals::{self, LowPass};
use gearwise_model::effects::{Equation, Operating, Scale};

/// Samples beyond noise in one direction, one after the other, that noise does not make: twice its size, some six times that are
/// independent.
const RUN: usize = 16;

/// The band: as wide as the sampling allows, but no wider than where the differentiated noise of the
/// speed stays below the noise of the target.
pub(super) fn choose_band(
    stretches: &mut [Stretch],
    target: Target,
    factor: f64,
    scale: &Scale,
    wanted: Option<f64>,
    model: &Model,
) -> Option<f64> {
    if stretches.iter().any(|s| s.step == 0.0) {
        return None;
    }
    // Nothing is taken from what is held out.
    let fit: Vec<&Stretch> = stretches.iter().filter(|s| s.fits).collect();
    let slowest = fit.iter().map(|s| 1.0 / s.fresh).fold(f64::INFINITY, f64::min);
    let inertia = model.inertia.unwrap_or(0.0) * factor.abs();
    let mut band = fit.iter().map(|s| s.widest).fold(0.2 * slowest, f64::min);
    if target.equation() == Equation::Torque && inertia > 0.0 {
        for s in &fit {
            let speed: Vec<f64> = s.points.iter().map(|p| p.speed).collect();
            let (of_speed, of_target) = (signals::noise_level(&speed), signals::noise_level(&s.target));
            let target = of_target.max(1e-6 * scale.torque * factor.abs());
            if of_speed > 0.0 {
                // In a band f of white noise: J σ_ω 2π f/√3 against σ_target.
                band = band
                    .min((target * 3.0_f64.sqrt() / (inertia * of_speed * std::f64::consts::TAU)).max(0.02 / s.step));
            }
        }
    }
    // A log that is held out may be sampled more slowly: its filter ends where it can.
    let band = wanted.unwrap_or(band).min(0.45 * slowest);
    for s in stretches.iter_mut() {
        s.filter = Some(LowPass::new(band * s.step));
    }
    Some(band)
}

/// Chooses rows and blocks of logs that are for fitting or not: the rows, and whether only parts of logs judge.
pub(super) fn lay_out(
    stretches: &mut [Stretch],
    target: Target,
    band: Option<f64>,
    usage: &[Use],
    most: usize,
) -> (Rows, bool) {
    // How long a block is, and how many rows are enough, is for the logs to fit to say.
    let total: usize = stretches.iter().filter(|s| s.fits).map(|s| s.target.len()).sum();
    let thin = total.div_ceil(most.max(1));
    let masks: Vec<Vec<bool>> = stretches.iter().map(|s| usable(s, target)).collect();
    for (s, mask) in stretches.iter_mut().zip(masks) {
        let n = s.target.len();
        let (guard, every) = match (&s.filter, band) {
            (Some(filter), Some(band)) => {
                (filter.guard().min(n / 4), signals::whole(1.0 / (3.0 * band * s.step)).max(1))
            }
            _ => (0, 1),
        };
        let spoiled = near(&s.excluded, guard);
        s.keep = (guard..n - guard).step_by(every.max(thin)).filter(|k| mask[*k] && !spoiled[*k]).collect();
    }
    let rows: usize = stretches.iter().filter(|s| s.fits).map(|s| s.keep.len()).sum();
    // Blocks of equal numbers of rows within a log: at least 20, at most 60 in all.
    let wanted = (rows / 40).clamp(20, 60);
    let length = rows.div_ceil(wanted).max(1);
    let mut layout = Rows::default();
    let mut logs_fit = 0;
    for (index, usage) in usage.iter().enumerate() {
        let fits = *usage == Use::Fit;
        logs_fit += usize::from(fits);
        let in_log: usize = stretches.iter().filter(|s| s.log == index).map(|s| s.keep.len()).sum();
        let blocks = in_log.div_ceil(length).max(1);
        let each = in_log.div_ceil(blocks).max(1);
        let first = layout.block_log.len();
        let mut at = 0;
        for s in stretches.iter().filter(|s| s.log == index) {
            for k in &s.keep {
                layout.log.push(index);
                layout.block.push(first + at / each);
                layout.time.push(s.start + *k as f64 * s.step);
                at += 1;
            }
        }
        if in_log > 0 {
            layout.block_log.extend(std::iter::repeat_n(index, blocks));
            layout.block_fits.extend(std::iter::repeat_n(fits, blocks));
        }
    }
    let held = layout.block_fits.iter().any(|f| !f);
    let split = !held && logs_fit > 0;
    if split {
        // Nothing was held out: every fifth block judges.
        for (b, fits) in layout.block_fits.iter_mut().enumerate() {
            *fits = b % 5 != 3;
        }
    }
    (layout, split)
}

/// Samples that are marked, and those that the filter has brought something of them.
fn near(marked: &[bool], guard: usize) -> Vec<bool> {
    let mut out = vec![false; marked.len()];
    for k in (0..marked.len()).filter(|k| marked[*k]) {
        out[k.saturating_sub(guard)..(k + guard + 1).min(marked.len())].fill(true);
    }
    out
}

/// Samples that say something: the shaft moves, as far as the encoder can tell, and nothing is missing.
fn usable(s: &Stretch, target: Target) -> Vec<bool> {
    let n = s.target.len();
    let mut mask: Vec<bool> =
        (0..n).map(|k| s.target[k].is_finite() && s.base.iter().all(|c| c[k].is_finite())).collect();
    if target.equation() != Equation::Torque || s.step == 0.0 {
        return mask;
    }
    let still = s.points.iter().filter(|p| p.direction.abs() < 0.999).count();
    if 10 * still <= 7 * n {
        for (m, p) in mask.iter_mut().zip(&s.points) {
            *m &= p.direction.abs() > 0.5;
        }
    } else if target == Target::Drive && s.fits {
        // At rest friction holds whatever the load asks for: nothing is learnt of the drive but from what surely moves.
        for (m, moves) in mask.iter_mut().zip(surely_moves(&s.points)) {
            *m &= moves;
        }
    }
    // Before a sensor of torque a stalled log stands on purpose.
    mask
}

/// Samples in runs of one direction that noise does not make.
fn surely_moves(points: &[Operating]) -> Vec<bool> {
    let mut moves = Vec::with_capacity(points.len());
    for run in points.chunk_by(|a, b| a.direction == b.direction) {
        let is_one = run[0].direction.abs() >= 1.0 && run.len() >= RUN;
        moves.extend(std::iter::repeat_n(is_one, run.len()));
    }
    moves
}
