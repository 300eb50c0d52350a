//! The objective as cuts: at any ratio, one polynomial that touches the objective there and lies
//! below it everywhere. A smooth objective is its own cut; a largest or a mean of positive parts has a
//! cut for each ratio. The conic program and the branch and bound both work on cuts alone.

use super::RatioProgram;
use crate::actuator::Laurent;
use crate::actuator::waveform::Functional;
use crate::requirement::{Objective, Quantity};

/// Why a quantity of an objective makes it bend the wrong way in N², where one does: its cuts have odd powers of N.
pub(super) fn why_not_convex(objective: &Objective) -> Option<&'static str> {
    let sole = objective.sole().is_some();
    let why = |quantity: Quantity| match quantity {
        // Alone it is minimised by its square.
        Quantity::PeakCurrent => (!sole).then_some("a weighted sum with the peak current is not convex in N²"),
        Quantity::Loss | Quantity::Energy | Quantity::PeakPower | Quantity::Mass | Quantity::ReflectedInertia => None,
    };
    objective.terms.iter().filter(|(_, weight)| *weight > 0.0).find_map(|(quantity, _)| why(*quantity))
}

/// The objective of a program, without the mass that steps by stages.
#[derive(Debug)]
pub(super) struct Goal<'a> {
    program: &'a RatioProgram<'a>,
    smooth: Laurent,
    /// The sole objective is the peak current: minimised, and bounded, by its square.
    squared_peak: bool,
}

impl<'a> Goal<'a> {
    pub(super) fn new(program: &'a RatioProgram<'a>) -> Goal<'a> {
        let (objective, prepared) = (program.objective, program.prepared);
        let inertia = objective.weight(Quantity::ReflectedInertia) * prepared.candidate.actuator.inertia;
        let saturated = prepared.candidate.actuator.shortfall.saturates();
        let loss = if saturated { Laurent::default() } else { prepared.loss() };
        let mut smooth = loss * objective.weight(Quantity::Loss) + Laurent::monomial(inertia, 2);
        let mass = objective.weight(Quantity::Mass);
        if mass > 0.0 && prepared.candidate.gear.mass_per_stage.is_none() {
            smooth = smooth + Laurent::constant(mass * prepared.candidate.mass_at(1.0).unwrap_or(f64::NAN));
        }
        Goal { program, smooth, squared_peak: objective.sole() == Some(Quantity::PeakCurrent) }
    }

    /// As [`Goal::new`], in the objective's own unit even where that is the peak current: for sums over joints.
    pub(super) fn summed(program: &'a RatioProgram<'a>) -> Goal<'a> {
        Goal { squared_peak: false, ..Goal::new(program) }
    }

    /// The polynomial that touches the objective at a ratio and is nowhere above it.
    pub(super) fn cut(&self, ratio: f64) -> Laurent {
        let weight = |quantity| self.program.objective.weight(quantity);
        let mut cut = self.smooth;
        let actuator = &self.program.prepared.candidate.actuator;
        if weight(Quantity::Loss) > 0.0 && actuator.shortfall.saturates() {
            let mean = self.program.prepared.candidate.load.mean_current_squared_cut(actuator, 0.0, ratio);
            cut = cut + mean * (weight(Quantity::Loss) * actuator.resistance);
        }
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
        let waveform = &candidate.load.waveform;
        let point = waveform.point(waveform.largest(Functional::TorqueSquared, &candidate.actuator, ratio).index);
        let torque = candidate.actuator.torque_form(point.flow).polynomial(&point.features);
        if self.squared_peak {
            return torque.squared();
        }
        // |T| is at least T and at least −T.
        let shortfall = &candidate.actuator.shortfall;
        if shortfall.is_nothing() {
            return torque * (weight * torque.at(ratio).signum() / candidate.actuator.torque_constant);
        }
        // The current is convex in |T|: its tangent.
        let (here, slope) = (torque.at(ratio), shortfall.peak_current_slope(torque.at(ratio).abs()));
        let tangent = torque * (here.signum() * slope);
        (tangent + Laurent::constant(shortfall.peak_current(here.abs()) - slope * here.abs())) * weight
    }

    fn energy(&self, ratio: f64) -> Laurent {
        let candidate = &self.program.prepared.candidate;
        let cut = candidate.load.energy_cut(&candidate.actuator, candidate.robot.bus.drive_efficiency, ratio);
        cut.unwrap_or(Laurent::constant(f64::NAN))
    }

    fn peak_power(&self, ratio: f64) -> Laurent {
        let candidate = &self.program.prepared.candidate;
        let waveform = &candidate.load.waveform;
        let largest = waveform.largest(Functional::Power, &candidate.actuator, ratio);
        // Where nothing is drawn at any instant the peak is zero.
        if largest.value <= 0.0 {
            return Laurent::default();
        }
        let point = waveform.point(largest.index);
        candidate.actuator.power(candidate.actuator.hot_copper(), point.flow, &point.features)
            * (1.0 / candidate.robot.bus.drive_efficiency)
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
                Goal::new(&RatioProgram { prepared: here, objective, range, limits: Vec::new() }).value(ratio)
            });
        }
        self.cut(ratio).at(ratio) + self.steps(ratio)
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
