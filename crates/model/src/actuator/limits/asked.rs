//! How a candidate stands against a limit that applies to it.

use super::heat::STANDSTILL;
use super::limit::{Asked, Check, Demand};
use crate::actuator::Load;
use crate::actuator::candidate::Candidate;
use crate::actuator::parts::Whole;
use crate::actuator::shaft::End;
use crate::actuator::waveform::{Functional, WavePoint, Waveform};
use crate::actuator::weakening::AlongD;
use crate::numerics::laurent::Laurent;

/// Margin of an infinite demand: a finite number, which programs can read.
pub const UNBOUNDED: f64 = -1e6;

/// What a demand may be of the terms whose sum it is and still count as nothing.
const ROUNDING: f64 = 1e-9;

/// The samples with the bandwidth torque on top, with their currents along d where a functional has a part of them that the
/// voltage does not ask for by itself.
fn bandwidth<'a>(candidate: &Candidate<'a>, functional: Functional, end: End) -> Option<&'a Waveform> {
    match functional {
        Functional::LeastVoltage(_) => candidate.load.bandwidth.as_ref(),
        Functional::VoltageSquared => candidate.load.for_voltage(end).rippled(),
        _ => candidate.load.rippled(),
    }
}

/// The samples at an end of the motor's drag.
fn samples<'a>(candidate: &Candidate<'a>, functional: Functional, end: End) -> &'a Waveform {
    match functional {
        Functional::VoltageSquared => &candidate.load.for_voltage(end).waveform,
        _ => &candidate.load.waveform,
    }
}

impl Asked {
    /// The functional's value that the bound corresponds to.
    pub fn raw_bound(&self) -> f64 {
        let raw = self.bound / self.factor;
        if self.squared { raw.powi(2).copysign(raw) } else { raw }
    }

    /// The parts of the actuator that it is a limit on.
    pub fn parts(&self) -> Option<Whole> {
        match self.demand {
            Demand::Parts(whole) => Some(whole),
            _ => None,
        }
    }

    /// The demand in its natural unit for a value of the functional.
    pub fn natural(&self, raw: f64) -> f64 {
        match self.squared {
            true => self.factor * raw.max(0.0).sqrt(),
            false => raw * if raw > 0.0 { self.above_zero } else { self.factor },
        }
    }

    /// The load whose sums over time it is of.
    pub fn load<'c>(&self, candidate: &Candidate<'c>) -> &'c Load {
        candidate.load.of_actuator(self.actuator)
    }

    /// The limit as it is for the candidate at one ratio, and that candidate at the limit's end of the motor's drag.
    pub fn there<'c>(&self, here: &Candidate<'c>) -> Option<(Asked, Candidate<'c>)> {
        let other = here.at_other_end().filter(|_| self.end == End::Other);
        let here = other.unwrap_or(*here).of_actuator(self.actuator);
        match self.limit.check(&here) {
            Check::Asked(asked) => Some((Asked { end: self.end, ..asked }, here)),
            _ => None,
        }
    }

    /// The functional's value at a ratio, and the sample of the motion that has it.
    pub fn raw_demand(&self, candidate: &Candidate, ratio: f64) -> (f64, Option<usize>) {
        self.raw_demand_above(candidate, ratio, f64::NEG_INFINITY)
    }

    /// The functional's value at a ratio and its sample, if the value exceeds a floor; else some value up to the floor and any sample.
    pub fn raw_demand_above(&self, candidate: &Candidate, ratio: f64, floor: f64) -> (f64, Option<usize>) {
        if candidate.is_evaluated() {
            let later = candidate.first_sample(self.actuator);
            return candidate.at_ratio(ratio, |here| match self.there(here) {
                Some((asked, here)) => {
                    let (value, sample) = asked.raw_demand_above(&here, ratio, floor);
                    (value, sample.map(|k| k + later))
                }
                None => (0.0, None),
            });
        }
        let actuator = candidate.end(self.end);
        let over = |waveform: &Waveform, functional| {
            let largest = waveform.largest_above(functional, actuator, ratio, floor);
            (largest.value, Some(waveform.origin(largest.index)))
        };
        match self.demand {
            Demand::Fixed(value, sample) => (value, sample),
            Demand::Constant(value) | Demand::AverageTorque(value) => (value, None),
            Demand::Parts(whole) => (whole.known, None),
            Demand::Polynomial(polynomial, sample) => (polynomial.at(ratio), sample),
            Demand::Samples(functional) => over(samples(candidate, functional, self.end), functional),
            Demand::Bandwidth(functional) => match bandwidth(candidate, functional, self.end) {
                Some(waveform) => over(waveform, functional),
                None => (0.0, None),
            },
            Demand::Mass => (candidate.known_mass_at(ratio), None),
            Demand::WindingPeak(node) => {
                let (peak, sample) = self.load(candidate).winding_peak(actuator, &node, ratio);
                (peak, sample.map(|k| k + candidate.first_sample(self.actuator)))
            }
            Demand::MeanCurrentSquared(standing) => {
                let load = self.load(candidate);
                (load.share_of_time * load.mean_current_squared(actuator, standing, ratio), None)
            }
        }
    }

    /// The limit as it is at a ratio: with a family of gears its bound goes with the ratio.
    pub fn at(&self, candidate: &Candidate, ratio: f64) -> Asked {
        if candidate.whole_map().is_none() {
            return *self;
        }
        candidate.at_ratio(ratio, |here| match self.limit.check(here) {
            Check::Asked(there) => Asked { end: self.end, actuator: self.actuator, ..there },
            _ => *self,
        })
    }

    /// Whether the limit is certainly kept at a ratio, where that is seen without computing the demand.
    pub fn is_certainly_kept(&self, candidate: &Candidate, ratio: f64) -> bool {
        match self.demand {
            Demand::WindingPeak(node) if !candidate.is_evaluated() => {
                self.load(candidate).winding_peak_is_within(candidate.end(self.end), &node, ratio, self.bound)
            }
            _ => false,
        }
    }

    /// Whether it takes a walk over all samples at the ratio that a candidate is of: see [`Demand::takes_a_walk`].
    pub fn takes_a_walk(&self, candidate: &Candidate) -> bool {
        let ripples = matches!(self.demand, Demand::Bandwidth(_)) && candidate.load.ripples_along_d();
        self.demand.takes_a_walk() || ripples
    }

    /// True if the demand depends on standstill.
    pub fn depends_on_standing(&self) -> bool {
        self.limit.name == STANDSTILL || matches!(self.demand, Demand::WindingPeak(_))
    }

    /// Whether it is what the currents along d of a candidate at one ratio are for.
    pub fn is_kept_along_d(&self, candidate: &Candidate) -> bool {
        matches!(
            (candidate.along_d(), self.demand),
            (Some(AlongD::Braking { .. }), Demand::Samples(Functional::PowerBack))
                | (Some(AlongD::Weakening(_)), Demand::Bandwidth(Functional::VoltageSquared))
        )
    }

    /// A number that the functional's value is certainly not above, where one costs less than the value.
    pub fn raw_at_most(&self, candidate: &Candidate, ratio: f64) -> Option<f64> {
        match self.demand {
            Demand::Bandwidth(Functional::CurrentSquared) => {
                candidate.load.rippled_at_most(candidate.end(self.end), ratio)
            }
            _ => None,
        }
    }

    /// Bounds of the functional's value where it is a sum over all samples, at a ratio that needs no evaluation.
    pub fn raw_between(&self, candidate: &Candidate, ratio: f64) -> Option<[f64; 2]> {
        let Demand::MeanCurrentSquared(standing) = self.demand else { return None };
        let load = self.load(candidate);
        let bounds = load.mean_current_squared_between(candidate.end(self.end), standing, ratio);
        Some(bounds.map(|mean| load.share_of_time * mean))
    }

    /// The polynomial of the ratio that is the demand's functional at a ratio (of a limit over samples: that of the
    /// sample that has it), and its sample. It is nowhere above the functional. `None` for limits that are no
    /// polynomial, or certainly kept.
    pub fn polynomial_at(&self, candidate: &Candidate, ratio: f64) -> Option<(Laurent, Option<usize>)> {
        let actuator = candidate.end(self.end);
        match self.demand {
            Demand::Polynomial(polynomial, sample) => Some((polynomial, sample)),
            Demand::Samples(functional) | Demand::Bandwidth(functional) => {
                let waveform = match self.demand {
                    Demand::Bandwidth(_) => bandwidth(candidate, functional, self.end)?,
                    _ => samples(candidate, functional, self.end),
                };
                let point = waveform.point(waveform.largest(functional, actuator, ratio).index);
                Some((functional.polynomial(actuator, &point, ratio), Some(point.origin)))
            }
            Demand::WindingPeak(_) if self.is_certainly_kept(candidate, ratio) => None,
            Demand::WindingPeak(node) => {
                let (cut, sample) = self.load(candidate).winding_peak_cut(actuator, &node, ratio, self.raw_bound());
                Some((cut, sample.map(|k| k + candidate.first_sample(self.actuator))))
            }
            Demand::MeanCurrentSquared(standing) => {
                let load = self.load(candidate);
                Some((load.mean_current_squared_cut(actuator, standing, ratio) * load.share_of_time, None))
            }
            Demand::Fixed(..) | Demand::Constant(_) | Demand::Parts(_) | Demand::AverageTorque(_) | Demand::Mass => {
                None
            }
        }
    }

    /// Of a limit over samples: its functional, and the point that has the largest of it at a ratio.
    pub fn point_at(&self, candidate: &Candidate, ratio: f64) -> Option<(Functional, WavePoint)> {
        let (functional, waveform) = match self.demand {
            Demand::Samples(functional) => (functional, samples(candidate, functional, self.end)),
            Demand::Bandwidth(functional) => (functional, bandwidth(candidate, functional, self.end)?),
            _ => return None,
        };
        let largest = waveform.largest(functional, candidate.end(self.end), ratio);
        Some((functional, waveform.point(largest.index)))
    }

    /// Distance of the demand from the bound over the size of the bound, (limit − demand)/|limit|, at a ratio for the functional's value
    /// there: not negative exactly where the limit is satisfied. With a positive limit a negative demand counts as zero. A limit of zero has
    /// margin 0 where it is satisfied, up to the rounding of terms that cancel, and −1 elsewhere. An infinite demand has −10⁶.
    pub fn margin(&self, candidate: &Candidate, ratio: f64, raw: f64) -> f64 {
        let demand = self.natural(raw);
        // Thermal runaway is beyond any limit.
        if demand == f64::INFINITY {
            return UNBOUNDED;
        }
        if self.bound == 0.0 {
            let rounding =
                || self.polynomial_at(candidate, ratio).is_some_and(|(terms, _)| raw <= ROUNDING * terms.size(ratio));
            return if demand <= 0.0 || rounding() { 0.0 } else { -1.0 };
        }
        match self.bound > 0.0 {
            true => 1.0 - demand.max(0.0) / self.bound,
            false => (self.bound - demand) / self.bound.abs(),
        }
    }
}
