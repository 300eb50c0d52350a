//! One mount, solved: its best ratio, and the design there.

use super::answer::{Design, Reason};
use super::evaluate::Judged;
use super::mount::Mount;
use super::program::{Bind, Certificate, Optimum, RatioProgram, Window};
use super::{Evaluation, Prepared};
use crate::requirement::Joint;

/// The best ratio, or why there is none.
pub(super) fn solve(prepared: &Prepared, joint: &Joint, (min, max): (f64, f64)) -> Result<Optimum, Reason> {
    Ok(RatioProgram::new(prepared, &joint.objective, min, max).solve()?)
}

/// The design of a mount at its optimum.
pub(super) fn design<'a>(mount: &Mount<'a, '_>, prepared: &Prepared, optimum: Optimum) -> Design<'a> {
    let ratio = optimum.ratio;
    // For one design the costlier figures are worth their time.
    let evaluation = Evaluation {
        energy: prepared.energy(ratio),
        peak_power: Some(prepared.peak_power(ratio)),
        ..prepared.at(ratio)
    };
    let Judged { unchecked, assumed } = prepared.judged(ratio);
    Design {
        motor: mount.motor,
        gear: mount.gear_id(),
        evaluation,
        unchecked,
        assumed,
        winding_temperature: prepared.winding_temperature(ratio),
        reversal_time: prepared.reversal_time(ratio),
        spring: None,
        optimum,
    }
}

/// The only ratio of a gear as an optimum: that all gears are evaluated is the proof.
pub(super) fn one_gear(ratio: f64, objective: f64) -> Optimum {
    let bind = Bind::of("gear", None);
    Optimum {
        ratio,
        objective,
        windows: vec![Window { min: ratio, max: ratio, low: bind.clone(), high: bind }],
        certificate: Certificate::Certified { lower_bound: objective, gap: 0.0, method: "all gears evaluated" },
        shadow_prices: Vec::new(),
    }
}
