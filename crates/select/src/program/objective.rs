//! The objective as cuts: at any ratio, one polynomial that touches the objective there and lies
//! below it everywhere. A smooth objective is its own cut; a largest or a mean of positive parts has a
//! cut for each ratio. The conic program and the branch and bound both work on cuts alone.

use std::ops::{Add, Mul};

use super::RatioProgram;
use crate::evaluate::Prepared;
use gearwise_model::actuator::supply::Drawn;
use gearwise_model::actuator::waveform::{Functional, Largest, WavePoint};
use gearwise_model::actuator::{Actuator, Laurent};
use gearwise_model::requirement::{Objective, Quantity};

/// Why a quantity of an objective makes it bend the wrong way in N², where one does: its cuts have odd powers of N.
pub(super) fn why_not_convex(objective: &Objective) -> Option<&'static str> {
    let sole = objective.sole().is_some();
    let why = |quantity: Quantity| match quantity {
        // Alone it is minimised by its square.
        Quantity::PeakCurrent => (!sole).then_some("a weighted sum with the peak current is not convex in N²"),
        Quantity::Loss
        | Quantity::CopperLoss
        | Quantity::Energy
        | Quantity::PeakPower
        | Quantity::Mass
        | Quantity::ReflectedInertia => None,
    };
    objective.terms.iter().filter(|(_, weight)| *weight > 0.0).find_map(|(quantity, _)| why(*quantity))
}

/// Whether all losses are polynomials in the ratio: one end of the motor's drag, no saturation, nothing that makes them
/// depend on which samples draw.
fn has_plain_losses(prepared: &Prepared) -> bool {
    let candidate = &prepared.candidate;
    let saturates = candidate.actuator.shortfall.saturates();
    candidate.other.is_none() && !saturates && Drawn::new(&candidate.robot.bus).is_lossless()
}

/// What an objective counts of the sample that has the largest of it.
#[derive(Debug, Clone)]
pub(crate) struct Peak {
    pub quantity: Quantity,
    pub weight: f64,
    pub point: WavePoint,
    /// The equations of the end of the motor's drag that it is at.
    pub actuator: Actuator,
}

/// The objective of a program, without the mass that steps by stages.
#[derive(Debug)]
pub(super) struct Goal<'a> {
    program: &'a RatioProgram<'a>,
    smooth: Laurent,
    /// Whether the losses are polynomials, and in `smooth`.
    is_plain: bool,
    /// The sole objective is the peak current: minimised, and bounded, by its square.
    squared_peak: bool,
}

impl<'a> Goal<'a> {
    pub(super) fn new(program: &'a RatioProgram<'a>) -> Goal<'a> {
        let (objective, prepared) = (program.objective, program.prepared);
        let inertia = prepared.candidate.reflected_inertia() * objective.weight(Quantity::ReflectedInertia);
        let is_plain = has_plain_losses(prepared);
        let [copper, loss] = match is_plain {
            true => [prepared.copper_cut(1.0), prepared.loss_cut(1.0)],
            false => [Laurent::default(); 2],
        };
        let losses = copper * objective.weight(Quantity::CopperLoss) + loss * objective.weight(Quantity::Loss);
        let mut smooth = losses + inertia;
        let mass = objective.weight(Quantity::Mass);
        if mass > 0.0 && prepared.candidate.gear.mass_per_stage.is_none() {
            let slope = prepared.candidate.mass_slope();
            let fixed = prepared.candidate.mass_at(1.0).map_or(f64::NAN, |at_one| at_one - slope);
            smooth = smooth + Laurent::constant(mass * fixed) + Laurent::monomial(mass * slope, 2);
        }
        Goal { program, smooth, is_plain, squared_peak: objective.sole() == Some(Quantity::PeakCurrent) }
    }

    /// As [`Goal::new`], in the objective's own unit even where that is the peak current: for sums over joints.
    pub(super) fn summed(program: &'a RatioProgram<'a>) -> Goal<'a> {
        Goal { squared_peak: false, ..Goal::new(program) }
    }

    /// The polynomial that touches the objective at a ratio and is nowhere above it.
    pub(super) fn cut(&self, ratio: f64) -> Laurent {
        let prepared = self.program.prepared;
        self.with_losses(self.without_losses(ratio), |quantity| match quantity {
            Quantity::Loss => prepared.loss_cut(ratio),
            _ => prepared.copper_cut(ratio),
        })
    }

    /// Value of the cut at its ratio.
    fn touched(&self, ratio: f64) -> f64 {
        let prepared = self.program.prepared;
        self.with_losses(self.without_losses(ratio).at(ratio), |quantity| match quantity {
            Quantity::Loss => prepared.loss_at(ratio),
            _ => prepared.copper_loss_at(ratio),
        })
    }

    /// Adds loss and copper loss by their weights, where they are not polynomials in the ratio.
    fn with_losses<T: Add<Output = T> + Mul<f64, Output = T>>(&self, sum: T, of: impl Fn(Quantity) -> T) -> T {
        let weight = |quantity| self.program.objective.weight(quantity);
        let counted = [Quantity::Loss, Quantity::CopperLoss].into_iter().filter(|q| !self.is_plain && weight(*q) > 0.0);
        counted.fold(sum, |sum, quantity| sum + of(quantity) * weight(quantity))
    }

    /// The cut without losses that are not polynomials in the ratio.
    fn without_losses(&self, ratio: f64) -> Laurent {
        let weight = |quantity| self.program.objective.weight(quantity);
        let mut cut = self.smooth;
        if weight(Quantity::PeakCurrent) > 0.0 {
            cut = cut + self.peak_current(ratio, weight(Quantity::PeakCurrent));
        }
        if weight(Quantity::Energy) > 0.0 {
            cut = cut + self.energy(ratio) * weight(Quantity::Energy);
        }
        if weight(Quantity::PeakPower) > 0.0 {
            cut = cut + self.peak_power(ratio) * weight(Quantity::PeakPower);
        }
        cut
    }

    fn peak_current(&self, ratio: f64, weight: f64) -> Laurent {
        let candidate = &self.program.prepared.candidate;
        let functional = candidate.load.waveform.of_current();
        let (largest, actuator) = self.largest(functional, ratio);
        let point = candidate.load.waveform.point(largest.index);
        if self.squared_peak {
            return functional.polynomial(actuator, &point, ratio);
        }
        if functional != Functional::TorqueSquared {
            // At the one ratio that the weakened field is of.
            return Laurent::constant(weight * actuator.shortfall.peak_current(largest.value.sqrt()));
        }
        let torque = actuator.torque_form(point.flow).polynomial(&point.features);
        // |T| is at least T and at least −T.
        let shortfall = &actuator.shortfall;
        if shortfall.is_nothing() {
            return torque * (weight * torque.at(ratio).signum() / actuator.torque_constant);
        }
        // The current is convex in |T|: its tangent.
        let (here, slope) = (torque.at(ratio), shortfall.peak_current_slope(torque.at(ratio).abs()));
        let tangent = torque * (here.signum() * slope);
        (tangent + Laurent::constant(shortfall.peak_current(here.abs()) - slope * here.abs())) * weight
    }

    fn energy(&self, ratio: f64) -> Laurent {
        self.program.prepared.energy_cut(ratio).unwrap_or(Laurent::constant(f64::NAN))
    }

    fn peak_power(&self, ratio: f64) -> Laurent {
        let candidate = &self.program.prepared.candidate;
        let standby = Laurent::constant(candidate.standby_power());
        let (largest, actuator) = self.largest(Functional::Power, ratio);
        // Where nothing is drawn at any instant the peak is that of standby.
        if largest.value <= 0.0 {
            return standby;
        }
        let point = candidate.load.waveform.point(largest.index);
        let power = Functional::Power.polynomial(actuator, &point, ratio);
        power * (1.0 / candidate.robot.bus.drive_efficiency) + standby
    }

    /// The points of the samples whose largest the cut at a ratio takes, each with what it counts.
    pub(super) fn peaks(&self, ratio: f64) -> Vec<Peak> {
        let candidate = &self.program.prepared.candidate;
        let waveform = &candidate.load.waveform;
        let one = |quantity: Quantity, functional: Functional| {
            let weight = self.program.objective.weight(quantity);
            let (largest, actuator) = self.largest(functional, ratio);
            let counts = weight > 0.0 && (quantity == Quantity::PeakCurrent || largest.value > 0.0);
            counts.then(|| Peak { quantity, weight, point: waveform.point(largest.index), actuator: *actuator })
        };
        let current = one(Quantity::PeakCurrent, waveform.of_current());
        current.into_iter().chain(one(Quantity::PeakPower, Functional::Power)).collect()
    }

    /// The largest of a functional over all samples and both ends of the motor's drag, and the equations of that end.
    fn largest(&self, functional: Functional, ratio: f64) -> (Largest, &Actuator) {
        let candidate = &self.program.prepared.candidate;
        let of_end = |actuator| candidate.load.waveform.largest(functional, actuator, ratio);
        let first = (of_end(&candidate.actuator), &candidate.actuator);
        match &candidate.other {
            Some(other) if of_end(other).value > first.0.value => (of_end(other), other),
            _ => first,
        }
    }

    /// What steps with the ratio: the weighted mass, where it is by stages.
    pub(super) fn steps(&self, ratio: f64) -> f64 {
        let candidate = &self.program.prepared.candidate;
        let weight = self.program.objective.weight(Quantity::Mass);
        if weight == 0.0 || candidate.gear.mass_per_stage.is_none() {
            return 0.0;
        }
        weight * candidate.mass_at(ratio).unwrap_or(f64::NAN)
    }

    /// The value at a ratio, in the unit of the cuts.
    pub(super) fn value(&self, ratio: f64) -> f64 {
        let RatioProgram { prepared, objective, range, .. } = *self.program;
        if prepared.candidate.is_evaluated() {
            return prepared.at_ratio(ratio, |here| {
                let program = RatioProgram { prepared: here, objective, range, limits: Vec::new() };
                Goal { squared_peak: self.squared_peak, ..Goal::new(&program) }.value(ratio)
            });
        }
        self.touched(ratio) + self.steps(ratio)
    }

    /// What a gap is measured by: the value, or where its terms cancel, a millionth of their size.
    pub(super) fn reference(&self, ratio: f64, value: f64) -> f64 {
        value.abs().max(1e-6 * self.cut(ratio).size(ratio)).max(f64::MIN_POSITIVE)
    }

    /// Derivative of the objective in its own unit by the value in the unit of the cuts.
    pub(super) fn natural_slope(&self, value: f64) -> f64 {
        if !self.squared_peak {
            return 1.0;
        }
        let actuator = &self.program.prepared.candidate.actuator;
        if actuator.shortfall.is_nothing() {
            return self.natural(1.0).powi(2) / (2.0 * self.natural(value));
        }
        actuator.shortfall.peak_current_slope(value.sqrt()) / (2.0 * value.sqrt())
    }

    /// From the unit of the cuts to the objective's own.
    pub(super) fn natural(&self, value: f64) -> f64 {
        if self.squared_peak {
            self.program.prepared.candidate.actuator.shortfall.peak_current(value.max(0.0).sqrt())
        } else {
            value
        }
    }
}

#[cfg(test)]
mod tests;
