//! Columns of the equation: one number for each row.

use super::equation::Balance;
use super::stretch::Stretch;
use crate::answer::Target;
use crate::identify::noise::{Unfiltered, pooled};
use crate::signals;
use gearwise_model::effects::{Effect, Equation, FittedEffect, Operating};

impl Balance {
    /// One number for each row: rows are in the order of the logs, and of time within a log.
    fn gather(&self, filtered: bool, column: impl Fn(&Stretch) -> Vec<f64>) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.rows.len());
        for index in 0..self.logs.len() {
            for s in self.stretches.iter().filter(|s| s.log == index) {
                let mut values = column(s);
                if let (true, Some(filter)) = (filtered && values.iter().all(|v| v.is_finite()), &s.filter) {
                    values = filter.apply(&values);
                }
                out.extend(s.keep.iter().map(|k| values[*k]));
            }
        }
        out
    }

    /// A term of the equation: filtered, and without the zero of its log where the target has one.
    fn term(&self, column: impl Fn(&Stretch) -> Vec<f64>) -> Vec<f64> {
        let mut out = self.gather(true, column);
        if self.target.has_zero() {
            self.rows.without_means(&mut out);
        }
        out
    }

    /// The target less what is known.
    pub fn target_column(&self) -> Vec<f64> {
        self.term(|s| s.target.iter().zip(&s.known).map(|(t, k)| t - k).collect())
    }

    /// The target less what is known, with the zero of each log still in it.
    pub fn target_with_zero(&self) -> Vec<f64> {
        self.gather(true, |s| s.target.iter().zip(&s.known).map(|(t, k)| t - k).collect())
    }

    /// The column of a parameter of the declared model.
    pub fn base_column(&self, index: usize) -> Vec<f64> {
        self.term(|s| s.base[index].clone())
    }

    /// The same, with the mean of each log still in it.
    pub fn base_column_with_zero(&self, index: usize) -> Vec<f64> {
        self.gather(true, |s| s.base[index].clone())
    }

    /// The columns of an effect at a shape: one for each linear parameter.
    pub fn effect_columns(&self, effect: &dyn Effect, shape: f64) -> Vec<Vec<f64>> {
        let factor = self.conversion(effect);
        (0..effect.linear()).map(|j| self.function(|at| factor * effect.basis(shape, at)[j])).collect()
    }

    /// What a term of an effect is multiplied with to be one of this balance: a voltage that a duty-driven
    /// machine loses is a torque that it lacks, by K_T/R.
    pub fn conversion(&self, effect: &dyn Effect) -> f64 {
        if effect.acts_on() == Equation::Voltage && self.target == Target::Drive {
            self.scale.torque_constant / self.scale.resistance
        } else {
            1.0
        }
    }

    /// What an effect adds to the target, with the mean of each log still in it.
    pub fn effect_with_zero(&self, effect: &dyn Effect, values: &[f64]) -> Vec<f64> {
        let factor = self.factor * self.conversion(effect);
        self.gather(true, |s| s.points.iter().map(|p| factor * effect.value(values, p)).collect())
    }

    /// The column of any function of the operating point: a torque at the motor, a voltage or an angle.
    pub fn function(&self, f: impl Fn(&Operating) -> f64) -> Vec<f64> {
        self.term(|s| s.points.iter().map(|p| self.factor * f(p)).collect())
    }

    /// The column of a torque at the output that is known over time: of a log (by its place among the bench's) at times from its
    /// first row \[s\].
    pub fn of_time(&self, value: impl Fn(usize, &[f64]) -> Vec<f64>) -> Vec<f64> {
        self.term(|s| {
            let times: Vec<f64> = (0..s.target.len()).map(|k| s.start + k as f64 * s.step).collect();
            value(self.logs[s.log], &times)
        })
    }

    /// A variable of the operating point at each row, as it is or through the filter.
    pub fn variable(&self, filtered: bool, f: impl Fn(&Operating) -> f64) -> Vec<f64> {
        self.gather(filtered, |s| s.points.iter().map(&f).collect())
    }

    /// White noise of a variable that was measured, in the band: from its second differences on the logs for fitting. Not a
    /// number for steady tables, whose rows are means.
    pub fn noise_of(&self, f: impl Fn(&Operating) -> f64) -> f64 {
        let one = |s: &Stretch| {
            let values: Vec<f64> = s.points.iter().map(&f).collect();
            Some((values.len(), signals::noise_level(&values) * s.filter?.noise_gain().sqrt()))
        };
        pooled(self.stretches.iter().filter(|s| s.fits).filter_map(one))
    }

    /// Acceleration of the motor at each row \[rad/s²\].
    pub fn acceleration(&self) -> Vec<f64> {
        self.gather(true, |s| s.acceleration.clone())
    }

    /// Sampling interval of the first stretch \[s\]; zero for steady tables.
    pub fn step(&self) -> f64 {
        self.stretches.first().map_or(0.0, |s| s.step)
    }

    /// Time between fresh values of the slowest log for fitting \[s\]; zero for steady tables.
    pub fn slowest_fresh_step(&self) -> f64 {
        let steps =
            self.stretches.iter().filter(|s| s.fits).map(|s| if s.step > 0.0 { s.fresh } else { f64::INFINITY });
        let slowest = steps.fold(0.0, f64::max);
        if slowest.is_finite() { slowest } else { 0.0 }
    }

    /// Number of rows that are for fitting.
    pub fn fitting(&self) -> usize {
        self.rows.block.iter().filter(|b| self.rows.block_fits[**b]).count()
    }

    /// Number of samples before rows were chosen.
    pub fn samples(&self) -> usize {
        self.stretches.iter().map(|s| s.target.len()).sum()
    }

    /// What a model leaves on the samples themselves, unfiltered, of the logs that are taken (by their place among the
    /// bench's): `base` has a value for each parameter of the declared model, `effects` their values.
    pub fn unfiltered(&self, take: impl Fn(usize) -> bool, base: &[f64], effects: &[FittedEffect]) -> Vec<Unfiltered> {
        let factors: Vec<f64> = effects.iter().map(|e| self.factor * self.conversion(e.effect)).collect();
        let one = |s: &Stretch| {
            let model = |k: usize| {
                let known: f64 = s.base.iter().zip(base).map(|(c, b)| if *b == 0.0 { 0.0 } else { b * c[k] }).sum();
                let effects = effects.iter().zip(&factors).map(|(e, f)| f * e.effect.value(&e.values, &s.points[k]));
                s.known[k] + known + effects.sum::<f64>()
            };
            Unfiltered {
                step: s.step,
                left: (0..s.target.len()).map(|k| s.target[k] - model(k)).collect(),
                columns: s.base.iter().filter(|c| c.iter().all(|v| v.is_finite())).cloned().collect(),
                stands: s.points.iter().map(|p| p.direction.abs() < 0.5).collect(),
                reading: s.reading,
            }
        };
        let taken = self.stretches.iter().filter(|s| take(self.logs[s.log]));
        taken.map(one).filter(|u| u.left.iter().all(|v| v.is_finite())).collect()
    }
}
