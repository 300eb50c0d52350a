//! Field weakening: a current along the d axis that takes voltage off where the bus does not give enough.
//!
//! The one idea: with x = i_d the squared voltage of a sample is `|v|² = |v₀|² + 2βx + αx²`, where R i_q drops out of β
//! (`α = R² + κ²N²`, `β = κN (L di_q/dt + K_B N ω)`, `κ = pLω`). The current x counts as x² in every other limit and in the
//! losses, so that the least |x| that keeps the voltage is best for all of them at once: nothing is left to choose but the
//! ratio. Morimoto et al., IEEE Trans. Ind. Appl. 26 (1990), is the case R = 0 at a constant current. The rate of i_d, an
//! inductance that differs between the axes and one that falls with current are left out.
//!
//! Currents along d are carried as `K_T x` \[N·m\], what the same current along q would make, so that squares add.

use super::shaft::{Actuator, FEATURES, Feature, Flow};
use crate::numerics::laurent::Laurent;
use crate::requirement::{Course, Motion};

/// `|v|²` of a sample at a ratio as a parabola in `d = K_T i_d` \[N·m\]: `squared + 2 slope d + bend d²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parabola {
    /// Without weakening \[V²\].
    pub squared: f64,
    /// Half of the slope at d = 0 \[V²/(N·m)\].
    pub slope: f64,
    /// \[V²/(N·m)²\].
    pub bend: f64,
}

impl Parabola {
    /// From the quadrature voltage \[V\] and torque \[N·m\] of a sample, what couples across \[V/(N·m)\], and resistance over torque
    /// constant \[V/(N·m)\].
    #[inline]
    pub fn new(quadrature: f64, torque: f64, across: f64, along: f64) -> Parabola {
        Parabola {
            squared: quadrature * quadrature + across * across * torque * torque,
            slope: across * (quadrature - along * torque),
            bend: along * along + across * across,
        }
    }

    /// At a current along d \[N·m\].
    pub fn at(&self, d: f64) -> f64 {
        self.squared + (2.0 * self.slope + self.bend * d) * d
    }

    /// Where it is least between none and `most` of a current against the magnets \[N·m\], ≤ 0.
    #[inline]
    pub fn lowest(&self, most: f64) -> f64 {
        if self.slope <= 0.0 { 0.0 } else { (-self.slope / self.bend).max(-most) }
    }

    /// The least current against the magnets with which it is at most `bound` \[V²\]; where none of at most `most` is, the
    /// one that comes nearest.
    pub fn least(&self, bound: f64, most: f64) -> f64 {
        let excess = self.squared - bound;
        if excess <= 0.0 || self.slope <= 0.0 {
            return 0.0;
        }
        let root = self.slope * self.slope - self.bend * excess;
        let needed = if root >= 0.0 { -excess / (self.slope + root.sqrt()) } else { f64::NEG_INFINITY };
        if needed >= -most { needed } else { self.lowest(most) }
    }
}

/// What a current along d is for. Currents are against the magnets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlongD {
    /// To keep the voltage, at most so much \[A, q axis\].
    Weakening(f64),
    /// To turn power that comes back into heat of the winding.
    Braking {
        /// Beyond this at the drive's output \[W\].
        beyond: f64,
        /// At most so much \[A, q axis\]; infinite where nobody says.
        most: f64,
    },
}

/// `d²` \[N²·m²\] with which a sample gives no more than `beyond` \[W\] back, as it changes with the ratio; none is needed where
/// it is below zero. With the coldest winding, as power returned is computed.
pub fn braking_square(actuator: &Actuator, sample: Sample, beyond: f64) -> Laurent {
    let loss = actuator.loss_returned();
    (actuator.power(loss, sample.0, sample.1) + Laurent::constant(beyond)) * (-1.0 / loss)
}

/// A sample: which way power flows, and its features.
pub(crate) type Sample<'a> = (Flow, &'a [f64; FEATURES]);

/// What a sample's voltage is at a ratio.
pub(crate) fn parabola(actuator: &Actuator, sample: Sample, ratio: f64) -> Parabola {
    let quadrature = actuator.voltage_form(sample.0).polynomial(sample.1).at(ratio);
    let torque = actuator.torque_form(sample.0).polynomial(sample.1).at(ratio);
    let across = actuator.cross_coupling * sample.1[Feature::Velocity as usize] * ratio;
    Parabola::new(quadrature, torque, across, actuator.resistance_per_torque())
}

/// A lower bound of a sample's `d²` \[N²·m²\] on the ratios `[a, b]`: a polynomial that touches it at `ratio` inside, up to the
/// width of the interval. Nothing where no weakening is needed there.
///
/// For any λ > 0 the least of `λ(|v|² − V²) + d²` over d is below the d² of every d that keeps the voltage. It is
/// `λ(|v₀|² − V²) − λ²β²/(λα + 1)`, and the fraction, an affine function of N² squared over another, is below its chord.
pub fn least_square(
    actuator: &Actuator,
    sample: Sample,
    bound: f64,
    ratio: f64,
    (a, b): (f64, f64),
) -> Option<Laurent> {
    let here = parabola(actuator, sample, ratio);
    let excess = here.squared - bound;
    let root = here.slope * here.slope - here.bend * excess;
    if excess <= 0.0 || here.slope <= 0.0 || root <= 1e-12 * here.slope * here.slope {
        return None;
    }
    let d = -excess / (here.slope + root.sqrt());
    let price = -d / root.sqrt();
    Some(relaxed(actuator, sample, price, 1.0, (a, b)) + Laurent::constant(-price * bound))
}

/// A row that every ratio of `[a, b]` keeps at which a current of at most `most` \[N·m\] brings the voltage to `bound` \[V²\]; it
/// touches the least voltage at `ratio` inside, up to the width of the interval.
pub fn voltage_row(actuator: &Actuator, sample: Sample, most: f64, ratio: f64, (a, b): (f64, f64)) -> Laurent {
    let here = parabola(actuator, sample, ratio);
    if here.slope <= 0.0 {
        // Not even at this ratio does it help; that it does not elsewhere is not known.
        return relaxed(actuator, sample, 1.0, 0.0, (a, b));
    }
    // The price of current with which the end is the lowest point.
    let weight = if most > 0.0 { (here.slope / most - here.bend).max(0.0) } else { f64::INFINITY };
    if !weight.is_finite() {
        return actuator.voltage_squared(sample.0, sample.1);
    }
    relaxed(actuator, sample, 1.0, weight, (a, b)) + Laurent::constant(-weight * most * most)
}

/// Below the least of `price |v|² + weight d²` over all d, on an interval of ratios; it is met at its ends.
fn relaxed(actuator: &Actuator, sample: Sample, price: f64, weight: f64, (a, b): (f64, f64)) -> Laurent {
    let along = actuator.resistance_per_torque();
    let across = actuator.cross_coupling * sample.1[Feature::Velocity as usize];
    // β is κN times a voltage without its resistive part: powers 0 and 2 of N.
    let free = actuator.voltage_form(sample.0).polynomial(sample.1)
        + actuator.torque_form(sample.0).polynomial(sample.1) * -along;
    let slope = free * Laurent::monomial(across, 1);
    let fraction = |u: f64| {
        let beta = slope[0] + slope[2] * u;
        let below = price * (along * along + across * across * u) + weight;
        if below > 0.0 { price * price * beta * beta / below } else { 0.0 }
    };
    let (low, high) = (a * a, b * b);
    let (at_low, at_high) = (fraction(low), fraction(high));
    let rise = if high > low { (at_high - at_low) / (high - low) } else { 0.0 };
    let chord = Laurent::constant(at_low - rise * low) + Laurent::monomial(rise, 2);
    actuator.voltage_squared(sample.0, sample.1) * price + chord * -1.0
}

/// What weakening takes at a ratio.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Weakening {
    /// Largest current against the magnets \[A, q axis\].
    pub largest: f64,
    /// Its root mean square over the motion \[A, q axis\].
    pub rms: f64,
    /// Share of the time with such a current.
    pub share: f64,
    /// Copper loss of it \[W\].
    pub loss: f64,
    /// Whether it burns power that comes back; else it keeps the voltage.
    pub burns: bool,
    /// Largest |L di_d/dt|, which the voltage leaves out, as a share of the voltage that there is: by the change from one sample
    /// to the next. `None` of operating points, which have no order.
    pub rate: Option<f64>,
}

impl Weakening {
    /// From this share of the voltage on it is worth a word that L di_d/dt is left out.
    pub const RATE_WORTH_A_WORD: f64 = 0.01;
}

/// Two samples of which one follows the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The earlier sample.
    pub from: usize,
    /// The later one.
    pub to: usize,
    /// The time between them \[s\], > 0.
    pub lasts: f64,
}

impl Step {
    /// All of a motion, in each case by itself; none of operating points.
    pub fn all(motion: &Motion) -> Vec<Step> {
        let mut steps = Vec::new();
        for (samples, course) in motion.courses() {
            if matches!(course, Course::Points(_)) || samples.is_empty() {
                continue;
            }
            let (first, last, time) = (samples.start, samples.end - 1, &motion.time);
            steps.extend((first..last).map(|k| Step { from: k, to: k + 1, lasts: time[k + 1] - time[k] }));
            if let Course::Periodic(period) = course {
                steps.push(Step { from: last, to: first, lasts: period - (time[last] - time[first]) });
            }
        }
        steps.retain(|step| step.lasts > 0.0);
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without resistance and at a constant current: i_d = −ψ/L + √((V/Ω)² − (L i_q)²)/L, as Morimoto et al. have it.
    #[test]
    fn without_resistance_it_is_the_textbook_s() {
        let (psi, l, speed, i_q, k_t) = (0.01, 1e-4, 3000.0, 20.0, 0.07);
        let across = speed * l / k_t;
        let here = Parabola::new(speed * psi, k_t * i_q, across, 0.0);
        for voltage in [20.0_f64, 25.0, 29.0] {
            let textbook = (-psi + ((voltage / speed).powi(2) - (l * i_q).powi(2)).sqrt()) / l;
            let found = here.least(voltage * voltage, 1e9) / k_t;
            assert!((found - textbook).abs() < 1e-9 * textbook.abs(), "{found} {textbook}");
            assert!((here.at(found * k_t) - voltage * voltage).abs() < 1e-9 * voltage * voltage);
        }
        // Enough without: none. Not to be had: as near as it gets, at −ψ/L.
        assert_eq!(here.least((speed * psi).powi(2) * 2.0, 1e9), 0.0);
        assert!((here.least(1.0, 1e9) / k_t + psi / l).abs() < 1e-9 * psi / l);
        // No more than may flow; none where it would raise the voltage.
        assert_eq!(here.least(20.0 * 20.0, 1e-3), -1e-3);
        assert_eq!(Parabola { slope: -1.0, ..here }.least(1.0, 1e9), 0.0);
    }
}
