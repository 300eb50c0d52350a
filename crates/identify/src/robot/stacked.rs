//! The equations of all joints side by side: what each has of its own, and what they have in common.

use super::bench::Prepared;
use super::courses::Course;
use crate::answer::Base;
use crate::identify::balance::visible;
use crate::identify::regression::{Blocks, Rows, covariance, solve};
use crate::identify::{Balance, FEWEST, Options, Setting, Target};
use gearwise_model::effects::{EFFECTS, of_efficiency};
use gearwise_model::numerics::sums::finite_sum;

/// Most rows of each joint.
const ROWS: usize = 6_000;
/// Folds of what is left out.
const FOLDS: usize = 8;

/// The equation of one joint.
pub(super) struct Part {
    /// The joint, by its number among those of the bench file.
    pub joint: usize,
    /// The joint, by its number in the description.
    pub number: usize,
    balance: Balance,
    /// Inertia and friction of the joint itself.
    own: Vec<Vec<f64>>,
    /// The load that the description says.
    load: Vec<f64>,
    /// What the drive makes less that load.
    target: Vec<f64>,
    /// One over the squared error that the most that is asked leaves.
    weight: f64,
}

/// Columns that all joints have in common: of each parameter what it is at each joint.
pub(super) type Shared<'a> = [Vec<&'a [f64]>];

/// A fit of all joints.
pub(super) struct Fit {
    /// Squared errors of the blocks, left out.
    pub left_out: Vec<f64>,
    /// The common parameters.
    pub shared: Vec<f64>,
    /// Their ± (95 %).
    pub error: Vec<f64>,
}

impl Fit {
    /// Of all blocks together.
    pub fn left(&self) -> f64 {
        finite_sum(&self.left_out)
    }
}

/// Normal, 95 %.
const INTERVAL: f64 = 1.96;

impl Part {
    /// `None` where the joint's logs have no drive against a load, or it moves too little.
    pub fn new(prepared: &Prepared, number: usize, options: &Options) -> Option<Part> {
        let bench = &prepared.bench;
        let setting = Setting { rows: ROWS, ..Setting::uncorrected(bench, options.band) };
        let balance = Balance::new(bench, Target::Drive, &setting)?;
        if balance.fitting() < FEWEST {
            return None;
        }
        let scale = balance.base.iter().position(|b| b.which == Base::LoadScale)?;
        let load = balance.base_column(scale);
        let mut own: Vec<Vec<f64>> =
            (0..balance.base.len()).filter(|b| *b != scale).map(|b| balance.base_column(b)).collect();
        let plain = EFFECTS.iter().copied().filter(|e| e.is_basic()).chain(of_efficiency());
        for effect in plain.filter(|e| visible(*e, &balance, &bench.declared).is_ok()) {
            own.extend(balance.effect_columns(effect, 0.0));
        }
        own.retain(|column| column.iter().any(|v| *v != 0.0) && column.iter().all(|v| v.is_finite()));
        let target = balance.target_column().iter().zip(&load).map(|(t, l)| t - l).collect();
        Some(Part { joint: prepared.joint, number, balance, own, load, target, weight: 1.0 })
    }

    /// A torque at the joint as a column: of each log at the times of its course.
    pub fn column(&self, courses: &[Course], torque: &[Vec<f64>], first: &[f64]) -> Vec<f64> {
        self.balance.of_time(|log, times| {
            let times: Vec<f64> = times.iter().map(|t| first[log] + t).collect();
            courses[log].at(&torque[log], &times)
        })
    }

    /// Weighs the joint by what is left where everything that is asked may differ at it, of columns of its own.
    pub fn weigh(&mut self, asked: &[&[f64]]) {
        let mut columns: Vec<&[f64]> = self.own.iter().map(Vec::as_slice).collect();
        columns.push(&self.load);
        columns.extend(asked);
        let blocks = Blocks::new(&self.balance.rows, &columns, &self.target);
        let folds = self.folds();
        let count = blocks.count(|b| folds[b].is_some());
        let left = finite_sum(&blocks.left_out(&folds)) / count.max(1) as f64;
        self.weight = if left > 0.0 { 1.0 / left } else { 1.0 };
    }

    /// Mean squared torque that a column is of \[N²·m²\], in times what is left.
    pub fn size(&self, column: &[f64]) -> f64 {
        self.weight * column.iter().map(|v| v * v).sum::<f64>() / column.len().max(1) as f64
    }

    fn folds(&self) -> Vec<Option<usize>> {
        let mut next = 0;
        let fold = |fits: &bool| {
            fits.then(|| {
                next += 1;
                (next - 1) % FOLDS
            })
        };
        self.balance.rows.block_fits.iter().map(fold).collect()
    }
}

/// Fits parts with what they have in common; where `scales`, with a scale of each one's load.
pub(super) fn fit(parts: &[&Part], shared: &Shared, scales: bool) -> Fit {
    let own = |part: &Part| part.own.len() + usize::from(scales);
    let total: usize = parts.iter().map(|p| own(p)).sum();
    let mut rows = Rows::default();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); total + shared.len()];
    let (mut target, mut folds) = (Vec::new(), Vec::new());
    let mut first = 0;
    for (index, part) in parts.iter().enumerate() {
        let of = &part.balance.rows;
        let (logs, blocks) = (rows.logs(), rows.block_log.len());
        rows.log.extend(of.log.iter().map(|l| logs + l));
        rows.block.extend(of.block.iter().map(|b| blocks + b));
        rows.time.extend(&of.time);
        rows.weight.extend((0..of.len()).map(|k| part.weight * of.weight(k)));
        rows.block_log.extend(of.block_log.iter().map(|l| logs + l));
        rows.block_fits.extend(&of.block_fits);
        target.extend(&part.target);
        folds.extend(part.folds());
        let mine = part.own.iter().map(Vec::as_slice).chain(scales.then_some(&part.load[..]));
        for (k, column) in mine.enumerate() {
            columns[first + k].resize(target.len() - of.len(), 0.0);
            columns[first + k].extend(column);
        }
        first += own(part);
        for (k, parameter) in shared.iter().enumerate() {
            columns[total + k].extend(parameter[index]);
        }
    }
    columns.iter_mut().for_each(|c| c.resize(target.len(), 0.0));
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let blocks = Blocks::new(&rows, &columns, &target);
    let fits = |b: usize| folds[b].is_some();
    let solution = solve(&blocks.total(fits));
    let covariance = covariance(&blocks, &solution, fits);
    let of_shared = total..total + shared.len();
    Fit {
        left_out: blocks.left_out(&folds),
        shared: of_shared.clone().map(|k| solution.coefficients[k]).collect(),
        error: of_shared.map(|k| INTERVAL * covariance[(k, k)].max(0.0).sqrt()).collect(),
    }
}
