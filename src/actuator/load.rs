//! Everything about a joint that does not depend on motor, gear or ratio, computed once.

use super::laurent::Laurent;
use super::shaft::{Actuator, FEATURE_POWER, FEATURES, Feature, Flow, ShaftForm, sign};
use super::waveform::{WavePoint, Waveform};
use crate::requirement::{Motion, TorqueBandwidth};

/// Phases of the torque that is superposed for the bandwidth limit.
pub const BANDWIDTH_PHASES: usize = 32;

/// Weighted second moments of the features, for each direction of power.
type Moments = [[[f64; FEATURES]; FEATURES]; 2];

/// A joint's demand, made ready.
#[derive(Debug, Clone)]
pub struct Load {
    /// The samples, for limits at every instant.
    pub waveform: Waveform,
    /// The samples with the bandwidth torque on top, at every phase.
    pub bandwidth: Option<Waveform>,
    /// Largest speed \[rad/s\] and its sample.
    pub peak_speed: (f64, usize),
    /// Largest load torque \[N·m\] and its sample.
    pub peak_torque: (f64, usize),
    /// Root mean square of the load torque \[N·m\].
    pub rms_torque: f64,
    /// Share of the time at standstill.
    pub dwell: f64,
    /// Whether means over time mean anything.
    pub has_durations: bool,
    /// Period, or duration \[s\], where the motion has one.
    pub duration: Option<f64>,
    mean: Moments,
    standstill: Moments,
    /// The samples as they are in means: no friction at standstill.
    samples: Vec<WavePoint>,
    weight: Vec<f64>,
}

impl Load {
    /// Prepares a motion.
    pub fn new(motion: &Motion, bandwidth: Option<TorqueBandwidth>) -> Load {
        let features = |k: usize, torque: f64, rate: f64, sign: f64| {
            let mut x = [0.0; FEATURES];
            x[Feature::Load as usize] = torque;
            x[Feature::LoadRate as usize] = rate;
            x[Feature::Acceleration as usize] = motion.acceleration[k];
            x[Feature::Jerk as usize] = motion.jerk[k];
            x[Feature::Velocity as usize] = motion.velocity[k];
            x[Feature::Sign as usize] = sign;
            x
        };
        // At standstill friction may oppose either way: both signs are among the points.
        let points = |k: usize, torque: f64, rate: f64| {
            let signs: &[f64] = match sign(motion.velocity[k]) {
                0.0 => &[1.0, -1.0],
                s if s > 0.0 => &[1.0],
                _ => &[-1.0],
            };
            let flow = Flow::of(torque, motion.velocity[k]);
            signs
                .iter()
                .map(move |s| WavePoint { features: features(k, torque, rate, *s), flow, origin: k })
                .collect::<Vec<_>>()
        };
        let samples = 0..motion.len();
        let plain: Vec<WavePoint> =
            samples.clone().flat_map(|k| points(k, motion.torque[k], motion.torque_rate[k])).collect();
        let bandwidth = bandwidth.map(|TorqueBandwidth { frequency, amplitude }| {
            let omega = std::f64::consts::TAU * frequency;
            let superposed = samples.clone().flat_map(|k| {
                (0..BANDWIDTH_PHASES).flat_map(move |phase| {
                    let angle = std::f64::consts::TAU * phase as f64 / BANDWIDTH_PHASES as f64;
                    let torque = motion.torque[k] + amplitude * angle.cos();
                    let rate = motion.torque_rate[k] - amplitude * omega * angle.sin();
                    points(k, torque, rate)
                })
            });
            Waveform::new(&superposed.collect::<Vec<_>>())
        });
        let in_means: Vec<WavePoint> = samples
            .clone()
            .map(|k| WavePoint {
                features: features(k, motion.torque[k], motion.torque_rate[k], sign(motion.velocity[k])),
                flow: Flow::of(motion.torque[k], motion.velocity[k]),
                origin: k,
            })
            .collect();
        let (mut mean, mut standstill): (Moments, Moments) = Default::default();
        for k in samples.clone() {
            let (x, flow) = (&in_means[k].features, in_means[k].flow as usize);
            for f in 0..FEATURES {
                for g in 0..FEATURES {
                    mean[flow][f][g] += motion.weight[k] * x[f] * x[g];
                    standstill[flow][f][g] += motion.dwell[k] * x[f] * x[g];
                }
            }
        }
        Load {
            waveform: Waveform::new(&plain),
            bandwidth,
            peak_speed: largest(&motion.velocity),
            peak_torque: largest(&motion.torque),
            rms_torque: motion.mean(|k| motion.torque[k].powi(2)).sqrt(),
            dwell: motion.dwell.iter().sum(),
            has_durations: motion.has_durations(),
            duration: motion.duration(),
            mean,
            standstill,
            samples: in_means,
            weight: motion.weight.clone(),
        }
    }

    /// The same with an inertia at the output \[kg·m²\] that the gear's efficiency covers as it covers the
    /// load torque. The gear's own limits stay on the torque at its output.
    pub fn with_inertia(motion: &Motion, bandwidth: Option<TorqueBandwidth>, inertia: f64) -> Load {
        let mut moved = motion.clone();
        for k in 0..motion.len() {
            moved.torque[k] += inertia * motion.acceleration[k];
            moved.torque_rate[k] += inertia * motion.jerk[k];
        }
        let mut load = Load::new(&moved, bandwidth);
        load.peak_torque = largest(&motion.torque);
        load.rms_torque = motion.mean(|k| motion.torque[k].powi(2)).sqrt();
        load
    }

    /// Mean of `T²` over time \[N²·m²\].
    pub fn mean_torque_squared(&self, actuator: &Actuator) -> Laurent {
        quadratic(&self.mean, |flow| (actuator.torque_form(flow), actuator.torque_form(flow)))
    }

    /// Mean of `T²` with the share at standstill counted twice: where the rotor stands, the worst
    /// phase carries 2/3 of the heat instead of 1/3 \[N²·m²\].
    pub fn mean_torque_squared_worst_phase(&self, actuator: &Actuator) -> Laurent {
        self.mean_torque_squared(actuator)
            + quadratic(&self.standstill, |flow| (actuator.torque_form(flow), actuator.torque_form(flow)))
    }

    /// Energy drawn from the bus per cycle \[J\] as a cut: the polynomial that equals it at `ratio` and is
    /// nowhere above it. Power that is drawn costs `P/η_d`, power that comes back yields `η_d P`; which
    /// samples do what is taken at `ratio`, and any other choice costs more. `None` without durations.
    pub fn energy_cut(&self, actuator: &Actuator, drive_efficiency: f64, ratio: f64) -> Option<Laurent> {
        let duration = self.duration?;
        let (copper, emf) = (actuator.copper(), actuator.back_emf_constant / actuator.torque_constant);
        let (up, down) = (ratio, 1.0 / ratio);
        let mut sum = [0.0; 5];
        for (sample, weight) in self.samples.iter().zip(&self.weight) {
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            let speed = emf * sample.features[Feature::Velocity as usize];
            let power = [
                copper * a * a,
                2.0 * copper * a * c,
                copper * (c * c + 2.0 * a * b) + speed * a,
                2.0 * copper * b * c + speed * c,
                copper * b * b + speed * b,
            ];
            let here = (power[0] * down + power[1]) * down + power[2] + (power[3] + power[4] * up) * up;
            let factor = weight * if here > 0.0 { 1.0 / drive_efficiency } else { drive_efficiency };
            for (s, p) in sum.iter_mut().zip(power) {
                *s += factor * p;
            }
        }
        let terms = sum.iter().zip(-2..).map(|(c, power)| Laurent::monomial(c * duration, power));
        Some(terms.fold(Laurent::default(), |a, b| a + b))
    }

    /// Mean terminal power over time \[W\].
    pub fn mean_power(&self, actuator: &Actuator) -> Laurent {
        let mut speed = ShaftForm::default();
        speed[Feature::Velocity] = 1.0;
        let mechanical = quadratic(&self.mean, |flow| (actuator.torque_form(flow), &speed));
        self.mean_torque_squared(actuator) * actuator.copper()
            + mechanical * (actuator.back_emf_constant / actuator.torque_constant)
    }
}

/// The largest magnitude and its place.
fn largest(values: &[f64]) -> (f64, usize) {
    let mut best = (values[0].abs(), 0);
    for (k, v) in values.iter().enumerate() {
        if v.abs() > best.0 {
            best = (v.abs(), k);
        }
    }
    best
}

/// `Σ a_f b_g M_fg N^(p_f + p_g)` over both directions of power.
fn quadratic<'a>(moments: &Moments, forms: impl Fn(Flow) -> (&'a ShaftForm, &'a ShaftForm)) -> Laurent {
    let mut sum = Laurent::default();
    for flow in Flow::BOTH {
        let (a, b) = forms(flow);
        for f in 0..FEATURES {
            for g in 0..FEATURES {
                let coefficient = a.0[f] * b.0[g] * moments[flow as usize][f][g];
                if coefficient != 0.0 {
                    sum = sum + Laurent::monomial(coefficient, FEATURE_POWER[f] + FEATURE_POWER[g]);
                }
            }
        }
    }
    sum
}
