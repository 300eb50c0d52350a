//! What the bench is told to do: levels that change at random, with sines on top, through a smooth
//! filter whose value, slope and integral are exact.
//!
//! The filter is three equal lags in series. For an input held over a step its answer is a
//! polynomial times an exponential, so a speed, its acceleration and its angle agree to rounding.

use super::random::Random;
use std::f64::consts::TAU;

/// From `start` on: a level, and how much of the sines is on top.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    pub start: f64,
    pub level: f64,
    pub sines: f64,
}

/// How a profile is drawn.
#[derive(Debug, Clone)]
pub struct Shape {
    /// Largest level.
    pub peak: f64,
    /// Share of the segments in which everything is slow.
    pub slow: f64,
    /// Level of the slow segments relative to the peak.
    pub slow_level: f64,
    /// Shortest and longest segment \[s\].
    pub hold: (f64, f64),
    /// Lowest and highest sine \[Hz\].
    pub band: (f64, f64),
    /// Sum of the sines' rms relative to the peak.
    pub sines: f64,
    /// Corner of each of the three lags \[Hz\].
    pub corner: f64,
}

/// A generator of value, slope and integral, one step after the other.
pub struct Profile {
    step: f64,
    rate: f64,
    decay: f64,
    lags: [f64; 3],
    integral: f64,
    segments: Vec<Segment>,
    at: usize,
    sines: Vec<[f64; 4]>,
    count: usize,
}

impl Profile {
    /// A profile of the given segments and sines (`[amplitude, hertz, phase]`).
    pub fn new(step: f64, corner: f64, segments: Vec<Segment>, sines: &[[f64; 3]]) -> Self {
        let rate = TAU * corner;
        let sines = sines
            .iter()
            .map(|[amplitude, hertz, phase]| {
                let turn = TAU * hertz * step;
                [amplitude * phase.cos(), amplitude * phase.sin(), turn.cos(), turn.sin()]
            })
            .collect();
        Profile {
            step,
            rate,
            decay: (-rate * step).exp(),
            lags: [0.0; 3],
            integral: 0.0,
            segments,
            at: 0,
            sines,
            count: 0,
        }
    }

    /// A random one.
    pub fn random(step: f64, duration: f64, shape: &Shape, random: &mut Random) -> Self {
        let mut segments = vec![Segment { start: 0.0, level: 0.0, sines: 0.0 }];
        let mut start = 0.3;
        while start < duration {
            let slow = random.chance(shape.slow);
            let peak = if slow { shape.slow_level } else { 1.0 } * shape.peak;
            // Half of the levels near the ends: a lab visits the corners on purpose.
            let level = if random.chance(0.5) { random.within(0.6, 1.0) } else { random.within(0.0, 0.6) };
            segments.push(Segment {
                start,
                level: random.sign() * level * peak,
                sines: if slow { shape.slow_level } else { 1.0 },
            });
            start += random.within(shape.hold.0, shape.hold.1);
        }
        let count = 8;
        let sines: Vec<[f64; 3]> = (0..count)
            .map(|k| {
                let (low, high) = (shape.band.0.ln(), shape.band.1.ln());
                let center = low + (high - low) * (f64::from(k) + random.within(0.0, 1.0)) / f64::from(count);
                let amplitude = shape.peak * shape.sines * (2.0 / f64::from(count)).sqrt();
                [amplitude, center.exp(), random.within(0.0, TAU)]
            })
            .collect();
        Profile::new(step, shape.corner, segments, &sines)
    }

    /// The same value for ever, from the start.
    pub fn constant(step: f64, value: f64) -> Self {
        let mut profile = Profile::new(step, 10.0, vec![Segment { start: 0.0, level: value, sines: 0.0 }], &[]);
        profile.lags = [value; 3];
        profile
    }

    /// Value now.
    pub fn value(&self) -> f64 {
        self.lags[2]
    }

    /// Slope now.
    pub fn slope(&self) -> f64 {
        self.rate * (self.lags[1] - self.lags[2])
    }

    /// Integral since the start.
    pub fn integral(&self) -> f64 {
        self.integral
    }

    /// One step on.
    pub fn advance(&mut self) {
        let time = self.count as f64 * self.step;
        while self.at + 1 < self.segments.len() && self.segments[self.at + 1].start <= time {
            self.at += 1;
        }
        let segment = self.segments[self.at];
        let mut sum = 0.0;
        for [c, s, cos, sin] in &mut self.sines {
            sum += *s;
            (*c, *s) = (*c * *cos - *s * *sin, *s * *cos + *c * *sin);
        }
        let input = segment.level + segment.sines * sum;
        let x = self.rate * self.step;
        let [a, b, c] = self.lags.map(|lag| lag - input);
        let next = [a, b + x * a, c + x * b + 0.5 * x * x * a].map(|d| input + d * self.decay);
        let change: f64 = next.iter().zip(&self.lags).map(|(n, o)| n - o).sum();
        self.integral += input * self.step - change / self.rate;
        self.lags = next;
        self.count += 1;
    }
}
