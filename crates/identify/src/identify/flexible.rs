//! Functions without a name: of time, of speed, and harmonics of an angle.

use rayon::prelude::*;

use super::hats::{hats, hats_over};
use super::work::{Fit, Work};
use gearwise_model::effects::{Effect, Operating, Variable};

/// Share of its information that an order must have within the band to be searched there.
const IN_BAND: f64 = 0.2;
/// Highest order that is searched.
const ORDERS: usize = 120;
/// Columns of a free drift: a piecewise linear function of time in each log.
pub fn drift(work: &Work) -> Vec<Vec<f64>> {
    let rows = &work.balance.rows;
    let mut columns = Vec::new();
    for log in 0..rows.logs() {
        let times: Vec<f64> = (0..rows.len()).filter(|k| rows.log[*k] == log).map(|k| rows.time[k]).collect();
        for hat in hats_over(times).into_iter().skip(1) {
            let mut column: Vec<f64> =
                (0..rows.len()).map(|k| if rows.log[k] == log { hat(rows.time[k]) } else { 0.0 }).collect();
            rows.without_means(&mut column);
            columns.push(column);
        }
    }
    columns
}

/// Columns of any function of speed.
pub fn of_speed(work: &Work) -> Vec<Vec<f64>> {
    if !work.balance.variables.contains(&Variable::Speed) {
        return Vec::new();
    }
    let values = work.balance.variable(false, |at| at.speed);
    let mut columns: Vec<Vec<f64>> =
        hats(&work.balance.rows, &values).iter().map(|hat| work.balance.function(|at| hat(at.speed))).collect();
    columns.push(work.balance.function(|at| at.direction));
    columns
}

/// Share of the residual that each order explains, roughly: without the filter, where it is slow enough to
/// pass it.
pub(crate) fn order_scores(work: &Work, fit: &Fit, effect: &dyn Effect) -> Vec<(f64, f64)> {
    let residual = work.weighed(work.residual(fit));
    let balance = &work.balance;
    let probes = [0.0_f64, 1.0].map(|shape| {
        // At order zero the cosine is one: what the harmonics are multiplied with.
        balance.variable(false, |at: &Operating| if shape == 0.0 { effect.basis(0.0, at)[0] } else { 0.0 })
    });
    let output = effect.needs().contains(&Variable::OutputAngle);
    let angle = balance.variable(false, |at| if output { at.output_angle } else { at.angle });
    let ratio = if output { 1.0 / work.bench.declared.ratio } else { 1.0 };
    let speed = balance.variable(false, |at| at.speed * ratio);
    let band = balance.band.unwrap_or(f64::INFINITY) * std::f64::consts::TAU;
    let fits: Vec<bool> = balance.rows.block.iter().map(|b| work.fits(*b)).collect();
    (1..=ORDERS)
        .into_par_iter()
        .map(|order| {
            let h = order as f64;
            let (mut a, mut b, mut norm, mut all) = (0.0, 0.0, 0.0, 0.0);
            for k in 0..residual.len() {
                if !fits[k] {
                    continue;
                }
                all += probes[0][k] * probes[0][k];
                if (h * speed[k]).abs() > 0.8 * band {
                    continue;
                }
                let (sine, cosine) = (h * angle[k]).sin_cos();
                a += residual[k] * probes[0][k] * cosine;
                b += residual[k] * probes[0][k] * sine;
                norm += probes[0][k] * probes[0][k];
            }
            // Seen in few slow moments only, it is for the search at full bandwidth.
            (h, if norm > IN_BAND * all { (a * a + b * b) / norm } else { 0.0 })
        })
        .collect()
}
