//! What a design can do at its output: the largest torque at every speed that each limit leaves.
//!
//! The one idea: a speed with a torque is a sample like any other, at steady speed (α = 0) and steady torque
//! (τ̇ = 0); squared torque, squared voltage and power of such a sample are at most quadratic in the load
//! torque, so that three samples give the whole parabola and the boundary is its root. The equations are
//! those of [`super::shaft`], none is written twice. The voltage of a supply that sags, and that with a weakened
//! field, are no parabolas: their boundary is found by halving.
//!
//! Torque counts positive where it drives and negative where it brakes, speed is never negative.

use super::fitted;
use super::limits::Candidate;
use super::shaft::{Actuator, FEATURES, Feature, Flow};
use super::waveform::{Functional, WavePoint};

/// A design at one ratio.
#[derive(Debug, Clone, Copy)]
pub struct Steady<'a> {
    candidate: &'a Candidate<'a>,
    actuator: Actuator,
    ratio: f64,
}

/// Whether torque drives or brakes.
fn direction(flow: Flow) -> f64 {
    match flow {
        Flow::Driving | Flow::Holding => 1.0,
        Flow::Braking => -1.0,
    }
}

impl<'a> Steady<'a> {
    /// A candidate at a ratio.
    pub fn new(candidate: &'a Candidate<'a>, ratio: f64) -> Steady<'a> {
        let actuator = if candidate.is_evaluated() { candidate.actuator.folded() } else { candidate.actuator };
        Steady { candidate, actuator, ratio }
    }

    /// The same as if the motor had no inductance: no direct-axis voltage (the rate of the current is zero here).
    #[must_use]
    pub fn without_inductance(mut self) -> Steady<'a> {
        self.actuator.cross_coupling = 0.0;
        self
    }

    /// The sample of a load torque \[N·m\] at a speed ≥ 0 \[rad/s\], as the samples of a motion are made.
    fn sample(&self, torque: f64, speed: f64) -> [f64; FEATURES] {
        let mut x = [0.0; FEATURES];
        x[Feature::Load as usize] = torque;
        x[Feature::Velocity as usize] = speed;
        x[Feature::Sign as usize] = 1.0;
        x[Feature::Speed as usize] = speed;
        x[Feature::One as usize] = 1.0;
        if self.candidate.is_evaluated() {
            let form = self.candidate.actuator.torque_form(Flow::Driving);
            x[Feature::One as usize] = fitted::folded(self.candidate.motor, form, self.ratio, speed, 1.0, 0.0).0;
        }
        x
    }

    /// A functional of a load torque \[N·m\] at a speed \[rad/s\].
    pub fn at(&self, functional: Functional, flow: Flow, torque: f64, speed: f64) -> f64 {
        let point = WavePoint { features: self.sample(torque, speed), flow, origin: 0, direct: 0.0 };
        functional.polynomial(&self.actuator, &point, self.ratio).at(self.ratio)
    }

    /// Torque at the motor shaft \[N·m\].
    fn shaft_torque(&self, flow: Flow, torque: f64, speed: f64) -> f64 {
        self.actuator.torque_form(flow).polynomial(&self.sample(torque, speed)).at(self.ratio)
    }

    /// The load torque \[N·m\] that asks a shaft torque \[N·m\] of the motor at a speed \[rad/s\]; the direction of
    /// power is that which goes with its sign. `None` where a gear that locks passes nothing back.
    pub fn load_torque(&self, shaft: f64, speed: f64) -> Option<f64> {
        Flow::MOVING.into_iter().find_map(|flow| {
            let none = self.shaft_torque(flow, 0.0, speed);
            let slope = self.shaft_torque(flow, 1.0, speed) - none;
            let torque = (shaft - none) / slope;
            (slope > 0.0 && torque * direction(flow) >= 0.0).then_some(torque)
        })
    }

    /// The largest torque \[N·m\] at a speed \[rad/s\] that keeps `functional ≤ bound`, with its sign. `None` where
    /// not even no torque keeps it; infinite where nothing bounds it.
    pub fn largest_torque(&self, functional: Functional, bound: f64, flow: Flow, speed: f64) -> Option<f64> {
        let sign = direction(flow);
        let value = |torque: f64| self.at(functional, flow, sign * torque, speed);
        let largest = match functional {
            Functional::LeastVoltage(_) => largest_by_halving(&value, bound),
            functional if functional.touches(&self.actuator) => largest_by_halving(&value, bound),
            // The larger of two parabolas: both windings have to keep it.
            Functional::VoltageSquared => {
                let [hot, cold] = self.actuator.windings().map(|winding| {
                    let squared = |x| winding.voltage_squared(flow, &self.sample(sign * x, speed)).at(self.ratio);
                    largest_of_parabola(&squared, bound)
                });
                let far = hot?.min(cold?);
                Some(far).filter(|far| far.is_infinite() || value(*far) <= bound + 1e-9 * bound.abs())
            }
            _ => largest_of_parabola(&value, bound),
        };
        largest.map(|torque| sign * torque)
    }
}

/// The end of the interval of torques from zero on in which a parabola is at most a bound, as [`largest_root`].
fn largest_of_parabola(value: &dyn Fn(f64) -> f64, bound: f64) -> Option<f64> {
    // Three samples at a torque of the root's own size lose no digits; it is found in a few rounds.
    let mut scale = 1.0;
    for _ in 0..4 {
        let (zero, one, two) = (value(0.0), value(scale), value(2.0 * scale));
        let square = 0.5 * (two - 2.0 * one + zero);
        let root = scale * largest_root(square, one - zero - square, zero - bound)?;
        if !root.is_finite() || root == 0.0 {
            return Some(root);
        }
        scale = root;
    }
    Some(scale)
}

/// The end of the interval from zero on in which a value that is no parabola is at most a bound; `None` where it is not so at
/// zero, infinite where it does not end.
fn largest_by_halving(value: &dyn Fn(f64) -> f64, bound: f64) -> Option<f64> {
    if value(0.0) > bound {
        return None;
    }
    let mut high = 1e-3;
    while value(high) <= bound {
        high *= 2.0;
        if high > 1e9 {
            return Some(f64::INFINITY);
        }
    }
    let mut low = if high > 1e-3 { 0.5 * high } else { 0.0 };
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if value(middle) <= bound { low = middle } else { high = middle }
    }
    Some(low)
}

/// The end of the interval of `x ≥ 0` from zero on in which `a x² + b x + c ≤ 0`, a ≥ 0 but for rounding. Where it
/// does not hold at zero, but farther on, it is the far end that is given.
fn largest_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let size = (b.abs() + c.abs()).max(f64::MIN_POSITIVE);
    if a <= 1e-14 * size {
        return match () {
            () if b > 0.0 => Some(-c / b).filter(|x| *x >= 0.0),
            () => (c <= 0.0).then_some(f64::INFINITY),
        };
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    // Without cancellation.
    let far = if b > 0.0 { -2.0 * c / (b + root) } else { (root - b) / (2.0 * a) };
    (far >= 0.0).then_some(far)
}
