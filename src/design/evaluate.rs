//! One design, looked at closely: every limit with its margin, and the figures people choose by.

use super::options::Stop;
use crate::actuator::fitted;
use crate::actuator::limits::{Asked, Candidate, Check, Demand, Judge, Remark, Verdict};
use crate::actuator::shaft::{FEATURES, Feature, Flow};
use crate::actuator::thermal::{self, Winding};
use crate::actuator::waveform::Functional;
use crate::requirement::{Course, Objective, Quantity};

/// A margin below this is a violation: what rounding leaves of a limit that binds exactly.
pub const FEASIBILITY_TOLERANCE: f64 = 1e-9;

/// A candidate whose limits were gathered once, to be evaluated at many ratios.
#[derive(Debug, Clone)]
pub struct Prepared<'a> {
    /// Motor, gear, joint.
    pub candidate: Candidate<'a>,
    /// The limits that apply.
    pub asked: Vec<Asked>,
    /// The limits that cannot be checked at any ratio, and why.
    pub unchecked: Vec<Remark>,
    /// What the limits assume at every ratio.
    assumed: Vec<Remark>,
    /// The limits that no ratio is rejected by.
    at_ratio: Vec<(&'static str, Judge)>,
    mean_torque_squared: crate::actuator::Laurent,
    /// Whether a search over it is to stop.
    pub(super) stop: Stop<'a>,
}

/// What is to be said of a design beside its margins.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Judged {
    /// Limits that could not be checked, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Remark>,
}

/// How a design stands against one limit.
#[derive(Debug, Clone, Copy)]
pub struct Margin {
    /// Name of the limit.
    pub limit: &'static str,
    /// Unit of demand and bound.
    pub unit: &'static str,
    /// What the motion demands.
    pub demand: f64,
    /// What may be had.
    pub bound: f64,
    /// `1 − demand/bound`.
    pub margin: f64,
    /// The sample of the motion at which the demand is largest.
    pub sample: Option<usize>,
    /// Whose limit it is.
    pub owner: &'static str,
}

impl Margin {
    /// Of a limit that is asked of a candidate at a ratio, by its raw demand and the sample that makes it.
    pub(super) fn new(asked: &Asked, candidate: &Candidate, ratio: f64, (raw, sample): (f64, Option<usize>)) -> Margin {
        Margin {
            limit: asked.limit.name,
            unit: asked.limit.unit,
            demand: asked.natural(raw),
            bound: asked.bound,
            margin: asked.margin(candidate, ratio, raw),
            sample,
            owner: asked.owner,
        }
    }
}

/// A design with all that is known of it. SI.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Ratio, N.
    pub ratio: f64,
    /// Whether every limit that could be checked is kept.
    pub feasible: bool,
    /// Every limit that applies.
    pub margins: Vec<Margin>,
    /// Mean copper loss at the reference temperature \[W\].
    pub loss: f64,
    /// Largest q-axis current \[A\].
    pub peak_current: f64,
    /// Root mean square of the q-axis current \[A\].
    pub rms_current: f64,
    /// Inertia at the output \[kg·m²\].
    pub reflected_inertia: f64,
    /// Mass of motor and gear \[kg\].
    pub mass: Option<f64>,
    /// Mean electrical power at the motor's terminals \[W\].
    pub mean_power: f64,
    /// Energy drawn from the bus per cycle \[J\]: only where the objective counts it, and durations are
    /// known.
    pub energy: Option<f64>,
    /// Largest power drawn from the bus \[W\]: only where the objective counts it.
    pub peak_power: Option<f64>,
}

impl<'a> Prepared<'a> {
    /// Gathers the limits of a candidate.
    pub fn new(candidate: Candidate<'a>) -> Prepared<'a> {
        let (mut asked, mut unchecked, mut at_ratio) = (Vec::new(), Vec::new(), Vec::new());
        for (limit, check) in candidate.checks() {
            match check {
                Check::Asked(limit) => asked.push(limit),
                Check::Unknown(why) => unchecked.push((limit.name, why)),
                Check::AtRatio(judge) => at_ratio.push((limit.name, judge)),
                Check::NotAsked => {}
            }
        }
        unchecked.extend(candidate.lacking());
        at_ratio.extend(candidate.told_at_a_ratio());
        let assumed = candidate.assumptions(&asked);
        let mean_torque_squared = candidate.load.mean_torque_squared(&candidate.actuator);
        Prepared { candidate, asked, unchecked, assumed, at_ratio, mean_torque_squared, stop: Stop::NEVER }
    }

    /// The same for searches that may be stopped.
    pub fn stopping(self, stop: Stop<'a>) -> Prepared<'a> {
        Prepared { stop, ..self }
    }

    /// What could not be checked at a ratio, and what was assumed there.
    pub fn judged(&self, ratio: f64) -> Judged {
        let mut judged = Judged { unchecked: self.unchecked.clone(), assumed: self.assumed.clone() };
        for (limit, judge) in &self.at_ratio {
            match judge(&self.candidate, ratio) {
                Verdict::Kept => {}
                Verdict::Assumed(what) => judged.assumed.push((limit, what)),
                Verdict::Unknown(why) => judged.unchecked.push((limit, why)),
            }
        }
        judged
    }

    /// The limits of which it depends on the ratio whether they can be checked.
    pub fn judged_at_ratio(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.at_ratio.iter().map(|(name, _)| *name)
    }

    /// What could not be checked of the design at a ratio, and why.
    pub fn unchecked_at(&self, ratio: f64) -> Vec<Remark> {
        self.judged(ratio).unchecked
    }

    /// The same without one limit.
    pub fn without(&self, limit: &str) -> Prepared<'a> {
        let mut other = self.clone();
        other.asked.retain(|a| a.limit.name != limit);
        other
    }

    /// The same limits for another load of the same motor and gear. A limit that was left out stays out.
    pub fn with_candidate<'b>(&self, candidate: Candidate<'b>) -> Prepared<'b>
    where
        'a: 'b,
    {
        let mut other = Prepared::new(candidate).stopping(self.stop);
        other.asked.retain(|a| self.asked.iter().any(|b| b.limit.name == a.limit.name));
        other
    }

    /// Evaluates the design at a ratio, the costlier figures too.
    pub fn at_in_full(&self, ratio: f64) -> Evaluation {
        Evaluation { energy: self.energy(ratio), peak_power: Some(self.peak_power(ratio)), ..self.at(ratio) }
    }

    /// Mean copper loss as a polynomial in N \[W\]; where the iron saturates, as if it did not.
    pub fn loss(&self) -> crate::actuator::Laurent {
        self.mean_torque_squared * self.candidate.actuator.heating()
    }

    /// Looks at the candidate with its evaluated effects at one ratio, and the same limits.
    pub(super) fn at_ratio<T>(&self, ratio: f64, look: impl FnOnce(&Prepared) -> T) -> T {
        self.candidate.at_ratio(ratio, |here| {
            let mut prepared = Prepared::new(*here);
            prepared.asked.retain(|a| self.asked.iter().any(|b| b.limit.name == a.limit.name));
            look(&prepared)
        })
    }

    /// Mean copper loss at a ratio \[W\].
    fn loss_at(&self, ratio: f64) -> f64 {
        let actuator = &self.candidate.actuator;
        if actuator.shortfall.saturates() {
            return actuator.resistance * self.candidate.load.mean_current_squared(actuator, 0.0, ratio);
        }
        self.mean_torque_squared.at(ratio).max(0.0) * actuator.heating()
    }

    /// Root mean square current at a ratio \[A\].
    fn rms_current(&self, ratio: f64) -> f64 {
        let actuator = &self.candidate.actuator;
        if actuator.shortfall.is_nothing() {
            return self.mean_torque_squared.at(ratio).max(0.0).sqrt() / actuator.torque_constant;
        }
        (self.loss_at(ratio) / actuator.resistance).sqrt()
    }

    /// Evaluates the design at a ratio.
    pub fn at(&self, ratio: f64) -> Evaluation {
        if self.candidate.is_evaluated() {
            return self.at_ratio(ratio, |here| here.at(ratio));
        }
        let candidate = &self.candidate;
        let actuator = &candidate.actuator;
        let peak = candidate.load.waveform.largest(Functional::TorqueSquared, actuator, ratio);
        let mut margins = Vec::with_capacity(self.asked.len());
        let mut feasible = true;
        for asked in &self.asked {
            let (raw, sample) = match asked.demand {
                // Current and torque limits share the search that has been made already.
                Demand::Samples(Functional::TorqueSquared) => {
                    (peak.value, Some(candidate.load.waveform.origin(peak.index)))
                }
                _ => asked.raw_demand(candidate, ratio),
            };
            let margin = Margin::new(asked, candidate, ratio, (raw, sample));
            feasible &= margin.margin >= -FEASIBILITY_TOLERANCE;
            margins.push(margin);
        }
        let loss = self.loss_at(ratio);
        // The polynomial of the mean power has the heat as if the iron did not saturate.
        let saturated = if actuator.shortfall.saturates() { loss - self.loss().at(ratio) } else { 0.0 };
        Evaluation {
            ratio,
            feasible,
            margins,
            loss,
            peak_current: actuator.shortfall.peak_current(peak.value.max(0.0).sqrt()),
            rms_current: self.rms_current(ratio),
            reflected_inertia: ratio * ratio * actuator.inertia,
            mass: candidate.mass_at(ratio),
            mean_power: candidate.load.mean_power(actuator).at(ratio) + saturated,
            energy: self.counts(Quantity::Energy).then(|| self.energy(ratio)).flatten(),
            peak_power: self.counts(Quantity::PeakPower).then(|| self.peak_power(ratio)),
        }
    }

    fn counts(&self, quantity: Quantity) -> bool {
        self.candidate.joint.objective.weight(quantity) > 0.0
    }

    /// Energy drawn from the bus per cycle at a ratio \[J\]; `None` without durations.
    pub fn energy(&self, ratio: f64) -> Option<f64> {
        if self.candidate.is_evaluated() {
            return self.at_ratio(ratio, |here| here.energy(ratio));
        }
        let candidate = &self.candidate;
        let cut = candidate.load.energy_cut(&candidate.actuator, candidate.robot.bus.drive_efficiency, ratio);
        cut.map(|cut| cut.at(ratio))
    }

    /// Largest power drawn from the bus at a ratio \[W\].
    pub fn peak_power(&self, ratio: f64) -> f64 {
        if self.candidate.is_evaluated() {
            return self.at_ratio(ratio, |here| here.peak_power(ratio));
        }
        let candidate = &self.candidate;
        let peak = candidate.load.waveform.largest(Functional::Power, &candidate.actuator, ratio).value;
        peak.max(0.0) / candidate.robot.bus.drive_efficiency
    }

    /// Winding temperature in steady state at a ratio.
    pub fn winding_temperature(&self, ratio: f64) -> Winding {
        let motor = self.candidate.motor;
        let Some(r_th) = self.candidate.thermal_resistance().filter(|_| self.candidate.load.has_steady_heat) else {
            return Winding::NotAsked;
        };
        if self.candidate.is_evaluated() {
            return self.at_ratio(ratio, |here| here.winding_temperature(ratio));
        }
        let actuator = &self.candidate.actuator;
        let mean = match actuator.shortfall.is_nothing() {
            true => self.mean_torque_squared.at(ratio).max(0.0) / actuator.torque_constant.powi(2),
            false => self.rms_current(ratio).powi(2),
        };
        let settles = thermal::winding_temperature(
            mean * self.candidate.load.share_of_time,
            motor.resistance,
            motor.reference_temperature,
            r_th,
            self.candidate.robot.ambient,
        );
        settles.map_or(Winding::Runaway, Winding::At)
    }

    /// Longest time that the current needs for its jumps where the motion reverses \[s\]:
    /// `L |Δi|/(V − R |i|)`. Efficiency and Coulomb friction jump there; voltage rows leave the jump
    /// out. `None` where the inductance is unknown; infinite where no voltage is left for it.
    pub fn reversal_time(&self, ratio: f64) -> Option<f64> {
        let candidate = &self.candidate;
        let inductance = candidate.motor.inductance?;
        let motion = &candidate.joint.motion;
        let actuator = &candidate.actuator;
        let torque = |flow, k: usize, sign: f64| {
            let mut features = [0.0; FEATURES];
            features[Feature::Load as usize] = motion.torque[k];
            features[Feature::Acceleration as usize] = motion.acceleration[k];
            features[Feature::Velocity as usize] = motion.velocity[k];
            features[Feature::Sign as usize] = sign;
            features[Feature::Speed as usize] = motion.velocity[k].abs();
            features[Feature::One as usize] = 1.0;
            let drag = fitted::drag(candidate.motor, ratio * motion.velocity[k], sign).0;
            actuator.torque_form(flow).polynomial(&features).at(ratio) + drag
        };
        // The sample before each change of direction, standstill in between included, in each case by itself.
        let in_time = motion.courses().into_iter().filter(|(_, course)| !matches!(course, Course::Points(_)));
        let pairs = in_time.flat_map(|(samples, course)| {
            let moving: Vec<usize> = samples.filter(|k| motion.velocity[*k] != 0.0).collect();
            let closing = moving.last().copied().zip(moving.first().copied());
            let closing = closing.filter(|_| matches!(course, Course::Periodic(_)));
            moving.windows(2).map(|w| (w[0], w[1])).chain(closing).collect::<Vec<_>>()
        });
        let mut longest = 0.0_f64;
        for (before, after) in pairs {
            let (was, is) = (motion.velocity[before].signum(), motion.velocity[after].signum());
            if was == is {
                continue;
            }
            for k in [before, after] {
                let sides =
                    [was, is].map(|sign| torque(Flow::of(motion.torque[k], sign), k, sign) / actuator.torque_constant);
                let jump = (sides[0] - sides[1]).abs();
                let left = candidate.voltage() - actuator.hot_resistance * sides[0].abs().max(sides[1].abs());
                longest = longest.max(match () {
                    () if jump == 0.0 => 0.0,
                    () if left > 0.0 => inductance * jump / left,
                    () => f64::INFINITY,
                });
            }
        }
        Some(longest)
    }
}

/// Relative excess of a functional over its bound; for a bound of zero or less, the excess itself.
pub fn violation(raw: f64, bound: f64) -> f64 {
    if bound > 0.0 { raw / bound - 1.0 } else { raw - bound }
}

impl Evaluation {
    /// The objective's value: in its own unit for a single quantity, a pure number for a weighted
    /// sum. `None` where it needs a mass that is not known.
    pub fn objective(&self, objective: &Objective) -> Option<f64> {
        objective.terms.iter().map(|(quantity, weight)| Some(weight * self.quantity(*quantity)?)).sum()
    }

    /// One quantity.
    pub fn quantity(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Loss => Some(self.loss),
            Quantity::ReflectedInertia => Some(self.reflected_inertia),
            Quantity::PeakCurrent => Some(self.peak_current),
            Quantity::Mass => self.mass,
            Quantity::Energy => self.energy,
            Quantity::PeakPower => self.peak_power,
        }
    }

    /// The limit with the smallest margin.
    pub fn tightest(&self) -> Option<&Margin> {
        self.margins.iter().min_by(|a, b| a.margin.total_cmp(&b.margin))
    }
}
