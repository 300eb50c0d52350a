//! Everything about a joint that does not depend on motor, gear or ratio, computed once.

mod piece;

use std::sync::{Arc, OnceLock};

use super::along_d::Needs;
use super::heat_course::HeatCourse;
use super::shaft::{Actuator, End, FEATURE_POWER, FEATURES, FLOWS, Feature, Flow, ShaftForm, sign};
use super::standing::{GRADES, Stood, Sweep, begin_of};
use super::stretch::Piece;
use super::supply::Drawn;
use super::thermal::winding_temperature;
use super::thermal_motion::{Course, Heat, Outcome, Temperature, TwoNode};
use super::waveform::{Functional, WavePoint, Waveform};
use super::weakening::{Step, Weakening};
use crate::numerics::laurent::Laurent;
use crate::numerics::work;
use crate::requirement::{Motion, Ripple, TorqueBandwidth};

/// A rise that is so many times its bound is cut off by its logarithm: a motion from cold may come to numbers whose
/// rounding is larger than any bound.
const FAR_BEYOND: f64 = 100.0;

/// A rise \[K\] that is too large a number for gradients.
const LARGEST: f64 = 1e100;

/// Samples of the first periods of a heat that runs away that are looked at, at most: what is not beyond the bound by then is no cut,
/// but still below.
const FIRST_SAMPLES: usize = 1 << 20;

/// Root mean square of the load torque \[N·m\].
fn rms_torque(motion: &Motion) -> f64 {
    let held = |k: usize| if motion.velocity[k] == 0.0 { motion.held } else { 1.0 };
    motion.mean(|k| (held(k) * motion.torque[k]).powi(2)).sqrt()
}

/// Mean of |ω||τ|³ over a motion.
fn mean_wear(motion: &Motion) -> f64 {
    motion.mean(|k| motion.velocity[k].abs() * motion.torque[k].abs().powi(3))
}

/// Means of |τ| \[N·m\] and |ω| \[rad/s\] over the time that is not at standstill.
fn running_load(motion: &Motion) -> (f64, f64) {
    let moving = |k: usize| motion.weight[k] - motion.dwell[k];
    let share: f64 = (0..motion.len()).map(moving).sum();
    let mean = |values: &[f64]| (0..motion.len()).map(|k| moving(k) * values[k].abs()).sum::<f64>() / share;
    if share > 1e-12 { (mean(&motion.torque), mean(&motion.velocity)) } else { (0.0, 0.0) }
}

/// More than a mean differs by from another order of its sum (relative).
const ROUNDING: f64 = 1e-9;

/// Phases of the torque that is superposed for the bandwidth limit: between two of them it is at most
/// 1 − cos(π/32) = 0.5 % larger.
pub const BANDWIDTH_PHASES: usize = 32;

/// Weighted second moments of the features, for each way that power flows.
type Moments = [[[f64; FEATURES]; FEATURES]; FLOWS];

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
    /// Mean of |τ| \[N·m\] and of |ω| \[rad/s\] over the time that is not at standstill; zero where nothing moves.
    pub running_load: (f64, f64),
    /// Root mean square of the load torque \[N·m\].
    pub rms_torque: f64,
    /// Mean of |ω| over all of the motion \[rad/s\].
    pub mean_speed: f64,
    /// Mean of |ω||τ|³ over all of the motion \[rad/s·(N·m)³\]: what wears a gear.
    pub mean_wear: f64,
    /// Share of the time at standstill.
    pub dwell: f64,
    /// Whether means over time mean anything.
    pub has_durations: bool,
    /// Period, or duration \[s\], where the motion has one.
    pub duration: Option<f64>,
    /// How long one period, duration or sequence of cases moves \[s\]; zero where nothing says so.
    moves: f64,
    /// Whether the samples are of many runs: there is no order in time.
    pub is_mixed: bool,
    /// Whether heat has a steady state: not that of a motion that happens once from cold.
    pub has_steady_heat: bool,
    /// The share of all time that the motion takes: less than one where rest follows it.
    pub share_of_time: f64,
    /// The course of heat in time; `None` for operating points.
    course: Option<Arc<HeatCourse>>,
    mean: Moments,
    standstill: Moments,
    /// The samples as they are in means: no friction and no loss of the gear at standstill.
    samples: Arc<[WavePoint]>,
    /// Currents along d of the samples, times the torque constant \[N·m\]; empty where there are none.
    direct: Vec<f64>,
    /// What they are for.
    needs: Option<Needs>,
    /// The load with the currents along d of each end of the motor's drag alone, which its voltage is computed with; empty where they are
    /// the same.
    of_ends: Vec<Load>,
    /// `bandwidth` with the currents along d that it needs, once they were asked for.
    rippled: OnceLock<Waveform>,
    weight: Arc<[f64]>,
    /// Share of all time that each sample has at standstill, and the degree to which it stands: 1 where it has some at rest.
    rest: Arc<[f64]>,
    still: Arc<[f64]>,
    /// Share of all time at standstill as the winding has it; with [`Load::standing`] that of samples that move slowly too.
    stands: f64,
    /// The angles that the motion sweeps; `None` where it has none between its samples.
    sweep: Option<Arc<Sweep>>,
    /// This load with slow samples at standstill.
    stood: Stood<Load>,
    /// κ and time constant \[s\] that it was made for, where slow samples count as standstill, and their degrees.
    stands_at: Option<(f64, f64, Arc<[u8]>)>,
    /// True if a spring bears a part of the torque: degrees of standstill are of the angles alone.
    sprung: bool,
    /// Which sample follows which.
    steps: Arc<[Step]>,
    /// Where the gear is one of a family: the same on each piece of it.
    pieces: Vec<Load>,
    /// Where two actuators of one design do this at the same time: what each of them does. What is a sum over time is one for each.
    actuators: Vec<Load>,
    /// On a piece of a family of gears: what its efficiency and its torque without load that falls with the ratio take \[W\].
    gear_loss: Option<Laurent>,
}

/// Largest rise of a winding's temperature over ambient.
#[derive(Debug, Clone, PartialEq)]
pub struct WindingPeak {
    /// The rise, or what bounds it from below \[K\].
    pub rise: f64,
    /// Derivative of the rise by the copper heat of every sample \[K/W\].
    pub gradient: Vec<f64>,
    /// The sample at which it is reached; `None` where the heat runs away.
    pub sample: Option<usize>,
}

/// Temperatures over a course of heat.
struct Settled<'c> {
    course: &'c HeatCourse,
    /// Heat of every entry \[W\], and three times that of the hottest phase.
    heat: Vec<f64>,
    phase: Vec<f64>,
    temperature: Temperature,
}

/// A direction of a load, and how means of an actuator move along it, with power flowing through the gear as it does: per unit.
#[derive(Debug, Clone)]
pub struct Along<'d> {
    /// Torque at each sample of the motion \[N·m\].
    pub torque: &'d [f64],
    /// Of the mean squared torque at the shaft, at each end of the motor's drag \[N²·m²\].
    pub squared: [Laurent; 2],
    /// The same at standstill.
    pub at_rest: [Laurent; 2],
    /// Of the mean power at the shaft \[W\].
    pub shaft: Laurent,
    /// Of what the gear takes in proportion to the load \[W\].
    pub gear: Laurent,
}

/// The features of a sample with a torque, its rate and a direction.
fn features(motion: &Motion, k: usize, torque: f64, rate: f64, sign: f64) -> [f64; FEATURES] {
    let mut x = [0.0; FEATURES];
    x[Feature::Load as usize] = torque;
    x[Feature::LoadRate as usize] = rate;
    x[Feature::Acceleration as usize] = motion.acceleration[k];
    x[Feature::Jerk as usize] = motion.jerk[k];
    x[Feature::Velocity as usize] = motion.velocity[k];
    x[Feature::Sign as usize] = sign;
    x[Feature::Speed as usize] = motion.velocity[k].abs();
    x[Feature::One as usize] = 1.0;
    x[Feature::SpeedRate as usize] = sign * motion.acceleration[k];
    x
}

/// A sample as limits see it. At standstill friction may oppose either way: both signs are among the points.
fn points(motion: &Motion, k: usize, torque: f64, rate: f64) -> impl Iterator<Item = WavePoint> + use<> {
    let signs: &[f64] = match sign(motion.velocity[k]) {
        0.0 => &[1.0, -1.0],
        s if s > 0.0 => &[1.0],
        _ => &[-1.0],
    };
    let flow = Flow::of(torque, motion.velocity[k]);
    let point = |s: &f64| WavePoint { features: features(motion, k, torque, rate, *s), flow, origin: k, direct: 0.0 };
    signs.iter().map(point).collect::<Vec<_>>().into_iter()
}

/// The samples of a motion at these places.
fn plain(motion: &Motion, looked: &[usize]) -> Waveform {
    let at = |k: &usize| points(motion, *k, motion.torque[*k], motion.torque_rate[*k]);
    Waveform::new(&looked.iter().flat_map(at).collect::<Vec<_>>())
}

impl Load {
    /// Prepares a motion.
    pub fn new(motion: &Motion, ripple: Option<Ripple>) -> Load {
        let looked = motion.looked_at();
        let bandwidth = ripple.map(|ripple| {
            let TorqueBandwidth { frequency, amplitude } = ripple.bandwidth;
            let omega = std::f64::consts::TAU * frequency;
            let superposed = looked.iter().copied().flat_map(|k| {
                (0..BANDWIDTH_PHASES).flat_map(move |phase| {
                    let angle = std::f64::consts::TAU * phase as f64 / BANDWIDTH_PHASES as f64;
                    let (more, faster) = (amplitude * angle.cos(), -amplitude * omega * angle.sin());
                    let (torque, rate) = ripple.superposed(motion, k, more, faster);
                    points(motion, k, torque, rate)
                })
            });
            Waveform::new(&superposed.collect::<Vec<_>>())
        });
        // At standstill friction of a transmission may hold for the actuator.
        let in_means = |k: usize| motion.torque[k] * if motion.velocity[k] == 0.0 { motion.held } else { 1.0 };
        let in_means: Vec<WavePoint> = (0..motion.len())
            .map(|k| WavePoint {
                features: features(motion, k, in_means(k), motion.torque_rate[k], sign(motion.velocity[k])),
                flow: Flow::in_means(motion.torque[k], motion.velocity[k]),
                origin: k,
                direct: 0.0,
            })
            .collect();
        let (mean, standstill) = (moments(&in_means, &motion.weight), moments(&in_means, &motion.dwell));
        let actuators: Vec<Load> = motion.actuators().iter().map(|each| Load::new(each, None)).collect();
        Load {
            waveform: plain(motion, &looked),
            bandwidth,
            peak_speed: largest(&motion.velocity),
            peak_torque: largest(&motion.torque),
            running_load: running_load(motion),
            rms_torque: rms_torque(motion),
            mean_speed: motion.mean(|k| motion.velocity[k].abs()),
            mean_wear: mean_wear(motion),
            dwell: motion.dwell.iter().sum(),
            has_durations: motion.has_durations(),
            duration: motion.duration(),
            moves: match &motion.cases {
                Some(cases) => cases.sequence_lasts().0,
                None => motion.duration().unwrap_or(0.0),
            },
            is_mixed: motion.mixed,
            has_steady_heat: motion.has_steady_heat(),
            share_of_time: motion.share_of_time(),
            course: if actuators.is_empty() { HeatCourse::new(motion).map(Arc::new) } else { None },
            mean,
            standstill,
            samples: in_means.into(),
            direct: Vec::new(),
            needs: None,
            of_ends: Vec::new(),
            rippled: OnceLock::new(),
            weight: motion.weight.as_slice().into(),
            rest: motion.dwell.as_slice().into(),
            still: motion.dwell.iter().map(|dwell| f64::from(*dwell > 0.0)).collect(),
            stands: motion.dwell.iter().sum(),
            sweep: Some(Arc::new(Sweep::new(motion))),
            stood: Stood::default(),
            stands_at: None,
            sprung: motion.sprung,
            steps: Step::all(motion).into(),
            pieces: Vec::new(),
            actuators,
            gear_loss: None,
        }
    }

    /// The same with limits at other samples of its motion; without a bandwidth torque.
    pub fn looked_at(&self, motion: &Motion) -> Load {
        Load { waveform: plain(motion, &motion.looked_at()), ..self.clone() }
    }

    /// What each of two actuators does that do this at the same time; empty where it is one.
    pub fn actuators(&self) -> &[Load] {
        &self.actuators
    }

    /// What one actuator does: a part of it, or all.
    pub(crate) fn of_actuator(&self, which: Option<usize>) -> &Load {
        which.and_then(|k| self.actuators.get(k)).unwrap_or(self)
    }

    /// The same with an inertia at the output \[kg·m²\] that the gear's efficiency covers as it covers the
    /// load torque; zero where it covers none. The gear's own limits stay on the torque at its output.
    pub fn with_inertia(motion: &Motion, ripple: Option<Ripple>, inertia: f64) -> Load {
        if inertia == 0.0 {
            return Load::new(motion, ripple);
        }
        let mut moved = motion.clone();
        for k in 0..motion.len() {
            moved.torque[k] += inertia * motion.acceleration[k];
            moved.torque_rate[k] += inertia * motion.jerk[k];
        }
        let mut load = Load::new(&moved, ripple);
        load.peak_torque = largest(&motion.torque);
        load.running_load = running_load(motion);
        load.rms_torque = rms_torque(motion);
        load.mean_wear = mean_wear(motion);
        load.actuators = motion.actuators().iter().map(|each| Load::with_inertia(each, None, inertia)).collect();
        load
    }

    /// The same for one ratio, with what a motor's effects add at the shaft folded into the samples:
    /// `extra(velocity, towards, acceleration)` gives torque \[N·m\] and rate \[N·m/s per N\]. It goes with
    /// [`Actuator::folded`].
    pub fn folded(&self, extra: impl Fn(f64, f64, f64) -> (f64, f64)) -> Load {
        let change = |x: &mut [f64; FEATURES]| {
            let of = |feature: Feature| x[feature as usize];
            let (torque, rate) = extra(of(Feature::Velocity), of(Feature::Sign), of(Feature::Acceleration));
            x[Feature::One as usize] = torque;
            x[Feature::SpeedRate as usize] = rate;
        };
        let folded = |load: &Load| {
            work::count(20 * load.samples.len());
            let mut samples = load.samples.to_vec();
            samples.iter_mut().for_each(|sample| change(&mut sample.features));
            load.with_points(samples, |wave| wave.changed(change))
        };
        Load { actuators: self.actuators.iter().map(folded).collect(), ..folded(self) }
    }

    /// The load as the winding of a motor with the time constant `tau` \[s\] has it at `kappa = 2 p N`: samples at which the rotor
    /// moves so slowly that one phase is hotter than the others count as standstill to a degree. Within a quarter of an octave of
    /// κ, degrees are those of its lower end, where they are larger; an octave of κ and of `tau` for motions of many samples.
    pub fn standing(&self, kappa: f64, tau: f64) -> &Load {
        let Some(sweep) = self.sweep.as_deref() else { return self };
        let Some((step, tau)) = sweep.place(kappa, tau) else { return self };
        let make = |degrees: &[u8]| self.with_degrees(degrees, (begin_of(step), tau));
        self.stood.of(self, (step, tau), || sweep.degrees(step, tau), make)
    }

    /// This load with samples at standstill as in another load of the same motion.
    pub fn standing_as(&self, other: &Load) -> &Load {
        let Some((kappa, tau, degrees)) = &other.stands_at else { return self };
        match self.sweep.as_deref() {
            Some(sweep) if self.sprung && other.sprung => {
                let make = |degrees: &[u8]| self.with_degrees(degrees, (*kappa, *tau));
                self.stood.of(self, sweep.step_at(*kappa, *tau), || degrees.clone(), make)
            }
            _ => self.standing(*kappa, *tau),
        }
    }

    /// True if degrees of standstill of samples that move were counted.
    pub fn counts_slow_motion(&self) -> bool {
        self.stands_at.is_some()
    }

    /// The κ from `low` to `high` at which the degrees of standstill change, in rising order.
    pub(super) fn changes_between(&self, (low, high): (f64, f64), tau: f64) -> Vec<f64> {
        let Some(sweep) = self.sweep.as_deref() else { return Vec::new() };
        let mut changes = sweep.steps_between((low, high), tau);
        let mut before = self.standing(low, tau);
        changes.retain(|kappa| {
            let here = self.standing(*kappa, tau);
            let changes = !std::ptr::eq(before, here);
            before = here;
            changes
        });
        changes
    }

    /// Load with these degrees of standstill of slow samples, computed for κ and a winding time constant \[s\].
    fn with_degrees(&self, degrees: &[u8], at: (f64, f64)) -> Load {
        let degree = |k: usize| f64::from(degrees[k]) / GRADES;
        let rest = |k: usize| self.rest[k] + (self.weight[k] - self.rest[k]).max(0.0) * degree(k);
        let rest: Arc<[f64]> = (0..degrees.len()).map(rest).collect();
        Load {
            standstill: moments(&self.samples, &rest),
            still: self.still.iter().enumerate().map(|(k, still)| still.max(degree(k))).collect(),
            stands: rest.iter().sum(),
            rest,
            sweep: None,
            stands_at: Some((at.0, at.1, degrees.into())),
            pieces: self.pieces.iter().map(|piece| piece.with_degrees(degrees, at)).collect(),
            actuators: self.actuators.iter().map(|each| each.standing(at.0, at.1).clone()).collect(),
            ..self.clone()
        }
    }

    /// Share of all time at standstill, as the winding has it.
    pub fn stands_for(&self) -> f64 {
        self.stands
    }

    /// The same with other samples in means, and what a change makes of those of limits.
    fn with_points(&self, samples: Vec<WavePoint>, changed: impl Fn(&Waveform) -> Waveform) -> Load {
        Load {
            waveform: changed(&self.waveform),
            bandwidth: self.bandwidth.as_ref().map(changed),
            mean: moments(&samples, &self.weight),
            standstill: moments(&samples, &self.rest),
            samples: samples.into(),
            pieces: Vec::new(),
            ..self.clone()
        }
    }

    /// The largest load torque \[N·m\], and |ω| at its sample \[rad/s\].
    pub fn at_peak_torque(&self) -> (f64, f64) {
        let (torque, sample) = self.peak_torque;
        (torque, self.samples[sample].features[Feature::Velocity as usize].abs())
    }

    /// The same for one ratio with currents along d. `None` where no sample needs any, nor with the bandwidth torque on top.
    pub(crate) fn weakened(&self, needs: Needs) -> Option<Load> {
        let points = needs.currents(&self.waveform, false);
        let rippled = || self.bandwidth.as_ref().is_some_and(|wave| needs.any(wave, true));
        if points.is_empty() && !rippled() {
            return None;
        }
        work::count(20 * self.samples.len());
        // A sample at standstill, whose two points are not the sample of means, needs none.
        let mut direct = vec![0.0_f64; self.samples.len()];
        let mut of_points = vec![0.0_f64; self.waveform.len()];
        for (k, d) in points {
            of_points[k] = d.min(of_points[k]);
            let sample = &mut direct[self.waveform.origin(k)];
            *sample = sample.min(d);
        }
        let waveform = self.waveform.weakened(of_points);
        let each = |load: &Load| load.weakened(needs).unwrap_or_else(|| load.clone());
        let actuators = self.actuators.iter().map(each).collect();
        let of_ends =
            needs.of_each_end().into_iter().map(|own| self.weakened(own).unwrap_or_else(|| self.clone())).collect();
        Some(Load {
            waveform,
            direct,
            needs: Some(needs),
            of_ends,
            rippled: OnceLock::new(),
            actuators,
            ..self.clone()
        })
    }

    /// The samples with the bandwidth torque on top, and with the currents along d that they need: all points of a sample have the
    /// largest of theirs. Made where it is asked for: it is many points.
    pub(crate) fn rippled(&self) -> Option<&Waveform> {
        let wave = self.bandwidth.as_ref()?;
        let Some(needs) = &self.needs else { return Some(wave) };
        let make = || {
            let mut of_points = vec![0.0_f64; wave.len()];
            for (k, d) in needs.currents(wave, true) {
                for other in wave.of_sample(wave.origin(k)) {
                    of_points[*other] = of_points[*other].min(d);
                }
            }
            wave.weakened(of_points)
        };
        Some(self.rippled.get_or_init(|| work::uncounted(make)))
    }

    /// The load that the voltage at an end of the motor's drag is computed with.
    pub(crate) fn for_voltage(&self, end: End) -> &Load {
        self.of_ends.get(end as usize).unwrap_or(self)
    }

    /// Whether the samples with the bandwidth torque on top have currents along d that were not asked for yet.
    pub(crate) fn ripples_along_d(&self) -> bool {
        self.needs.is_some()
    }

    /// More than any squared current with the bandwidth torque on top, times K_T² \[N²·m²\].
    pub(crate) fn rippled_at_most(&self, actuator: &Actuator, ratio: f64) -> Option<f64> {
        let along_q = self.bandwidth.as_ref()?.largest(Functional::TorqueSquared, actuator, ratio).value;
        let along_d = self.needs.map_or(0.0, |needs| needs.most());
        Some(along_q + along_d * along_d)
    }

    /// Current along d of a sample in means, times the torque constant \[N·m\].
    fn direct(&self, k: usize) -> f64 {
        self.direct.get(k).copied().unwrap_or(0.0)
    }

    /// What currents along d take at the ratio that it was made for, of the voltage that there is \[V\]; `burns` says what for.
    pub fn weakening(&self, actuator: &Actuator, voltage: f64, burns: bool) -> Weakening {
        let of_samples = |f: &dyn Fn(f64) -> f64| -> f64 {
            self.weight.iter().enumerate().map(|(k, w)| w * f(self.direct(k))).sum()
        };
        let squared = of_samples(&|d| d * d);
        let points = (0..self.waveform.len()).map(|k| self.waveform.point(k).direct);
        Weakening {
            largest: points.fold(0.0, |most, d| d.abs().max(most)) / actuator.torque_constant,
            rms: squared.sqrt() / actuator.torque_constant,
            share: of_samples(&|d| f64::from(d != 0.0)),
            loss: squared * actuator.copper(),
            burns,
            rate: self.fastest_direct().map(|fastest| fastest * actuator.rate() / voltage),
        }
    }

    /// The fastest change of the currents along d from sample to sample, times the torque constant \[N·m/s\]; `None` of operating
    /// points. Where power changes its direction through the gear the rate of the torque jumps: jumps are not differentiated.
    fn fastest_direct(&self) -> Option<f64> {
        let turns = |from: Flow, to: Flow| from != to && from != Flow::Holding && to != Flow::Holding;
        let rate = |step: &Step| {
            let (from, to) = (&self.samples[step.from], &self.samples[step.to]);
            if turns(from.flow, to.flow) {
                0.0
            } else {
                (self.direct(step.to) - self.direct(step.from)).abs() / step.lasts
            }
        };
        self.steps.iter().map(rate).reduce(f64::max)
    }

    /// Samples in means with their share of the time.
    pub fn means(&self) -> impl ExactSizeIterator<Item = (&WavePoint, f64)> {
        self.samples.iter().zip(self.weight.iter().copied())
    }

    /// Mean of the square of the currents along d, times the torque constant \[N²·m²\], with these shares of the time.
    fn mean_direct_squared(&self, shares: &[f64]) -> f64 {
        self.direct.iter().zip(shares).map(|(d, share)| share * d * d).sum()
    }

    /// Mean of `T²` over time \[N²·m²\]; with a weakened field of what heats as much.
    pub fn mean_torque_squared(&self, actuator: &Actuator) -> Laurent {
        let mean = quadratic(&self.mean, |flow| (actuator.torque_form(flow), actuator.torque_form(flow)));
        match actuator.shortfall.mean_square() + self.mean_direct_squared(&self.weight) {
            0.0 => mean,
            more => mean + Laurent::constant(more),
        }
    }

    /// Mean of the squared current over time \[A²\] at a ratio, with the share `standing` of that at standstill counted
    /// once more; for motors whose current is not proportional to the torque.
    pub fn mean_current_squared(&self, actuator: &Actuator, standing: f64, ratio: f64) -> f64 {
        if actuator.shortfall.saturates() {
            work::count(4 * self.samples.len());
        }
        self.currents_squared(actuator, standing, ratio).map(|(share, [squared, _])| share * squared).sum()
    }

    /// The share of every sample with its squared current at a ratio \[A²\] and the derivative by the squared torque.
    fn currents_squared(
        &self,
        actuator: &Actuator,
        standing: f64,
        ratio: f64,
    ) -> impl Iterator<Item = (f64, [f64; 2])> {
        let weights = Flow::ALL.map(|flow| actuator.torque_form(flow).weights(ratio));
        self.samples.iter().enumerate().map(move |(k, sample)| {
            let torque: f64 = weights[sample.flow as usize].iter().zip(&sample.features).map(|(w, x)| w * x).sum();
            let (squared, slope) = actuator.shortfall.current_squared(torque * torque);
            let along_d = (self.direct(k) / actuator.torque_constant).powi(2);
            (self.share(k, standing), [squared + along_d, slope])
        })
    }

    /// Bounds of [`Self::mean_current_squared`] without a walk over the samples \[A²\]: the current per torque rises with
    /// the torque, from 1/K_T to that of the largest torque.
    pub(crate) fn mean_current_squared_between(&self, actuator: &Actuator, standing: f64, ratio: f64) -> [f64; 2] {
        let shortfall = &actuator.shortfall;
        let mean = self.mean_torque_squared_standing(actuator, standing).at(ratio);
        let least = mean / (actuator.torque_constant * actuator.torque_constant);
        let largest = self.waveform.largest(Functional::CurrentSquared, actuator, ratio).value;
        let most = mean * shortfall.current_squared(largest).0 / (largest + shortfall.mean_square());
        [least * (1.0 - ROUNDING), if most.is_finite() { most * (1.0 + ROUNDING) } else { f64::INFINITY }]
    }

    /// The same as a cut: the polynomial that equals it at `ratio` and is nowhere above it. The squared current
    /// of a sample is convex and rising in its squared torque.
    pub fn mean_current_squared_cut(&self, actuator: &Actuator, standing: f64, ratio: f64) -> Laurent {
        work::count(5 * self.samples.len());
        let mut mean = 0.0;
        let slopes = self.currents_squared(actuator, standing, ratio).map(|(share, [squared, slope])| {
            mean += share * squared;
            share * slope
        });
        let slopes: Vec<f64> = slopes.collect();
        let squares = self.weighted_torque_squared(actuator, &slopes);
        squares + Laurent::constant(mean - squares.at(ratio))
    }

    /// The share of the time that a sample has, with the share `standing` of that at standstill once more.
    pub fn share(&self, k: usize, standing: f64) -> f64 {
        self.weight[k] + standing * self.rest[k]
    }

    /// Mean of `T²` with the share `standing` of that at standstill counted once more \[N²·m²\]: where the rotor
    /// stands, the worst phase carries 2/3 of the heat instead of 1/3.
    pub fn mean_torque_squared_standing(&self, actuator: &Actuator, standing: f64) -> Laurent {
        let mean = self.mean_torque_squared(actuator);
        if standing == 0.0 || self.stands == 0.0 {
            return mean;
        }
        let at_rest = quadratic(&self.standstill, |flow| (actuator.torque_form(flow), actuator.torque_form(flow)));
        let more = actuator.shortfall.mean_square() * self.stands + self.mean_direct_squared(&self.rest);
        mean + (at_rest + Laurent::constant(more)) * standing
    }

    /// Average torque of a gear's maker at the output \[N·m\], ∛(mean(|ω||τ|³)/mean|ω|); zero where nothing moves.
    pub fn average_torque(&self) -> f64 {
        if self.mean_speed > 0.0 { (self.mean_wear / self.mean_speed).cbrt() } else { 0.0 }
    }

    /// Mean of |ω| over the time that is not at standstill \[rad/s\].
    pub fn running_speed(&self) -> f64 {
        if self.mean_speed > 0.0 { self.mean_speed / (1.0 - self.dwell) } else { 0.0 }
    }

    /// Whether the motion happens once, from cold: heat has no steady state.
    pub fn starts_cold(&self) -> bool {
        self.has_durations && !self.has_steady_heat
    }

    /// How long the motion lasts \[s\]; zero where nothing says so.
    pub fn lasts(&self) -> f64 {
        self.moves
    }

    /// Mean power drawn from the bus \[W\], without the drive's standby power, as a cut: the polynomial that equals it at
    /// `ratio` and is nowhere above it. Power that is drawn costs `P/η_d`, power that comes back yields `η_r P`, or the most
    /// that is kept; which samples do what is taken at `ratio`, and any other choice costs more.
    pub fn drawn_cut(&self, actuator: &Actuator, drawn: Drawn, ratio: f64) -> Laurent {
        let mut sum = [0.0; 5];
        self.each_drawn(actuator, drawn, ratio, |_, weight, power, factor, kept| {
            for (s, p) in sum.iter_mut().zip(power) {
                *s += weight * factor * p;
            }
            sum[2] += weight * kept;
        });
        let terms = sum.iter().zip(-2..).map(|(c, power)| Laurent::monomial(*c, power));
        terms.fold(Laurent::default(), |a, b| a + b)
    }

    /// The value of [`Load::drawn_cut`] at its ratio \[W\], of motors whose iron saturates.
    pub fn mean_drawn(&self, actuator: &Actuator, drawn: Drawn, ratio: f64) -> f64 {
        let of_power = |power: f64| {
            let (factor, kept) = drawn.line(power);
            Some(factor * power + kept)
        };
        self.mean_of_power(actuator, ratio, of_power).unwrap_or(f64::NAN)
    }

    /// How [`Load::drawn_cut`] moves with the load along some directions.
    pub fn drawn_slopes(&self, actuator: &Actuator, drawn: Drawn, ratio: f64, along: &[Along]) -> Vec<Laurent> {
        let emf = actuator.back_emf_constant / actuator.torque_constant;
        let mut sums = vec![[0.0; 3]; along.len()];
        self.each_drawn(actuator, drawn, ratio, |k, weight, _, factor, _| {
            let sample = &self.samples[k];
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            let heating = actuator.heat((a / ratio + c + b * ratio).powi(2)).1 * actuator.with_leads();
            let speed = emf * sample.features[Feature::Velocity as usize];
            let passed = actuator.torque_form(sample.flow)[Feature::Load] * weight * factor;
            for (sum, of) in sums.iter_mut().zip(along) {
                let torque = passed * of.torque[sample.origin];
                sum[0] += 2.0 * heating * a * torque;
                sum[1] += 2.0 * heating * c * torque;
                sum[2] += (2.0 * heating * b + speed) * torque;
            }
        });
        let polynomial =
            |[a, b, c]: [f64; 3]| Laurent::monomial(a, -2) + Laurent::monomial(b, -1) + Laurent::constant(c);
        sums.into_iter().map(polynomial).collect()
    }

    /// Each sample with its share of the time, its power at the terminals as coefficients of N⁻² to N² \[W\], and the straight line that
    /// says what is drawn for that at a ratio.
    fn each_drawn(
        &self,
        actuator: &Actuator,
        drawn: Drawn,
        ratio: f64,
        mut look: impl FnMut(usize, f64, [f64; 5], f64, f64),
    ) {
        work::count(10 * self.samples.len());
        let emf = actuator.back_emf_constant / actuator.torque_constant;
        let shortfall = &actuator.shortfall;
        let leads = actuator.with_leads();
        let heating = actuator.heating() * leads;
        // Of currents along d.
        let along_d = if shortfall.saturates() { actuator.copper() * leads } else { heating };
        let linear = (!shortfall.saturates()).then(|| (heating, heating * shortfall.mean_square()));
        let (up, down) = (ratio, 1.0 / ratio);
        for (k, (sample, weight)) in self.means().enumerate() {
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            let direct = self.direct(k);
            let speed = emf * sample.features[Feature::Velocity as usize];
            // Heat is a straight line in T², or is above its tangent at this ratio.
            let (copper, constant) = match linear {
                Some(line) => line,
                None => {
                    let squared = (a / ratio + c + b * ratio).powi(2);
                    let (heat, slope) = actuator.heat(squared);
                    (slope * leads, (heat - slope * squared) * leads)
                }
            };
            let power = [
                copper * a * a,
                2.0 * copper * a * c,
                copper * (c * c + 2.0 * a * b) + speed * a + constant + along_d * direct * direct,
                2.0 * copper * b * c + speed * c,
                copper * b * b + speed * b,
            ];
            let here = (power[0] * down + power[1]) * down + power[2] + (power[3] + power[4] * up) * up;
            let (factor, kept) = drawn.line(here);
            look(k, weight, power, factor, kept);
        }
    }

    /// How [`Load::mean_current_squared_cut`] moves with the load along some directions, without standstill counted once more.
    pub fn current_squared_slopes(&self, actuator: &Actuator, ratio: f64, along: &[Along]) -> Vec<Laurent> {
        let slopes: Vec<f64> =
            self.currents_squared(actuator, 0.0, ratio).map(|(share, [_, slope])| share * slope).collect();
        along.iter().map(|of| self.squared_along(actuator, &slopes, of.torque)).collect()
    }

    /// How the sum of the squared torques at the shaft, with weights, moves with the load along a direction.
    fn squared_along(&self, actuator: &Actuator, weights: &[f64], torque: &[f64]) -> Laurent {
        let mut sums = [0.0; 3];
        for (sample, weight) in self.samples.iter().zip(weights) {
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            let moved = 2.0 * weight * actuator.torque_form(sample.flow)[Feature::Load] * torque[sample.origin];
            for (sum, term) in sums.iter_mut().zip([a, c, b]) {
                *sum += moved * term;
            }
        }
        Laurent::monomial(sums[0], -2) + Laurent::monomial(sums[1], -1) + Laurent::constant(sums[2])
    }

    /// The largest derivative of the copper heat by the squared torque at a ratio, over that without saturation.
    pub fn steepest_heat(&self, actuator: &Actuator, ratio: f64) -> f64 {
        if !actuator.shortfall.saturates() {
            return 1.0;
        }
        let plain = actuator.heating();
        self.currents_squared(actuator, 0.0, ratio)
            .map(|(_, [_, slope])| actuator.resistance * slope / plain)
            .fold(1.0, f64::max)
    }

    /// A direction of the load: so much torque \[N·m\] at each sample of the motion for one unit, and what means of an actuator at both
    /// ends of its drag do along it.
    pub fn along<'d>(&self, [actuator, other]: [&Actuator; 2], torque: &'d [f64]) -> Along<'d> {
        let squared = |actuator: &Actuator, weights: &[f64]| self.squared_along(actuator, weights, torque);
        let passed = |sample: &WavePoint| actuator.torque_form(sample.flow)[Feature::Load];
        let power = |of: &dyn Fn(&WavePoint) -> f64| -> f64 {
            let speed = |sample: &WavePoint| sample.features[Feature::Velocity as usize];
            self.means().map(|(sample, weight)| weight * of(sample) * torque[sample.origin] * speed(sample)).sum()
        };
        Along {
            torque,
            squared: [squared(actuator, &self.weight), squared(other, &self.weight)],
            at_rest: [squared(actuator, &self.rest), squared(other, &self.rest)],
            shaft: Laurent::constant(power(&passed)),
            gear: Laurent::constant(power(&|sample| passed(sample) - 1.0)),
        }
    }

    /// Mean over time of what follows from the power at the terminals of every sample \[W\] at a ratio, with the winding at the reference
    /// temperature; `None` where it follows from none of one.
    pub fn mean_of_power(&self, actuator: &Actuator, ratio: f64, of: impl Fn(f64) -> Option<f64>) -> Option<f64> {
        let emf = actuator.back_emf_constant / actuator.torque_constant * ratio;
        let of_sample = |(k, (sample, weight)): (usize, (&WavePoint, f64))| {
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            let torque = a / ratio + c + b * ratio;
            let heat = actuator.heat(torque * torque).0 + actuator.copper() * self.direct(k).powi(2);
            let speed = sample.features[Feature::Velocity as usize];
            Some(weight * of(heat * actuator.with_leads() + emf * speed * torque)?)
        };
        self.means().enumerate().map(of_sample).sum()
    }

    /// Whether the winding's temperature can be followed over the motion.
    pub fn has_course(&self) -> bool {
        self.course.is_some()
    }

    /// Largest rise of the winding's temperature over ambient \[K\] and its sample, with periodic motions in
    /// their periodic state and others from cold. Infinite where it runs away.
    pub fn winding_peak(&self, actuator: &Actuator, node: &TwoNode, ratio: f64) -> (f64, Option<usize>) {
        let heat = self.copper_heat(actuator, ratio);
        match self.settle(node, heat) {
            Some(Settled { course, temperature, .. }) => {
                let sample = course.sample(temperature.peak_sample, self.samples.len());
                (temperature.peak - node.ambient, Some(sample))
            }
            None => (f64::INFINITY, None),
        }
    }

    /// Winding and housing temperature over the motion \[K\], in its periodic state or from cold, with the times of
    /// the samples \[s\]; `None` where it runs away.
    pub fn winding_course(&self, actuator: &Actuator, node: &TwoNode, ratio: f64) -> Option<(&[f64], Temperature)> {
        let heat = self.copper_heat(actuator, ratio);
        self.settle(node, heat).map(|settled| (settled.course.times.as_slice(), settled.temperature))
    }

    /// Whether the rise certainly stays within `bound` \[K\]: it does where even the largest heat, held for
    /// ever, keeps to it. Costs no walk over the samples.
    pub fn winding_peak_is_within(&self, actuator: &Actuator, node: &TwoNode, ratio: f64, bound: f64) -> bool {
        let largest = self.waveform.largest(Functional::CurrentSquared, actuator, ratio).value;
        let current_squared = match actuator.shortfall.is_nothing() {
            true => largest / (actuator.torque_constant * actuator.torque_constant),
            false => actuator.shortfall.current_squared(largest).0,
        };
        let stands = if self.has_phases(node) { 1.0 + self.still.iter().copied().fold(0.0, f64::max) } else { 1.0 };
        let thermal_resistance = stands * node.resistance_winding_housing + node.resistance_housing_ambient;
        let settled =
            winding_temperature(current_squared, actuator.resistance, node.reference, thermal_resistance, node.ambient);
        settled.is_some_and(|t| t - node.ambient <= bound)
    }

    /// A rise \[K\] that is certainly reached at every ratio of `[low, high]`: that of the least heat that each sample has
    /// between the two, as temperature rises with heat. One walk over the samples instead of one for each ratio; infinite where
    /// it runs away, zero where this shows nothing.
    pub fn winding_peak_at_least(&self, actuator: &Actuator, node: &TwoNode, between: (f64, f64)) -> f64 {
        let Some([least, _]) = self.heat_between(actuator, between) else { return 0.0 };
        self.settle(node, least).map_or(f64::INFINITY, |settled| settled.temperature.peak - node.ambient)
    }

    /// Whether the rise is certainly beyond `bound` \[K\] at every ratio of `[low, high]`; `false` where that is not shown.
    pub fn winding_peak_is_beyond(&self, actuator: &Actuator, node: &TwoNode, between: (f64, f64), bound: f64) -> bool {
        self.winding_peak_at_least(actuator, node, between) > bound
    }

    /// Whether the rise certainly stays within `bound` \[K\] at every ratio of `[low, high]`: it does where it would even if
    /// each sample had the most heat that it has between the two.
    pub fn winding_peak_stays_within(
        &self,
        actuator: &Actuator,
        node: &TwoNode,
        between: (f64, f64),
        bound: f64,
    ) -> bool {
        let Some([_, most]) = self.heat_between(actuator, between) else { return false };
        self.settle(node, most).is_some_and(|settled| settled.temperature.peak - node.ambient <= bound)
    }

    /// Less than the least and more than the most copper heat \[W\] that every sample has at the ratios of `[low, high]`;
    /// `None` without a course, and where heat is not proportional to the squared torque.
    fn heat_between(&self, actuator: &Actuator, (low, high): (f64, f64)) -> Option<[Vec<f64>; 2]> {
        if self.course.is_none() || !actuator.shortfall.is_nothing() {
            return None;
        }
        let middle = 0.5 * (low + high);
        // 1/N is convex: towards the lower end it moves furthest.
        let (down, up) = (1.0 / low - 1.0 / middle, high - middle);
        let ends = |(k, sample): (usize, &WavePoint)| {
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            let (load, inertia) = (a / middle, b * middle);
            let moves = a.abs() * down + b.abs() * up + 1e-14 * (load.abs() + c.abs() + inertia.abs());
            let here = (load + c + inertia).abs();
            let along_d = self.direct(k).powi(2);
            let squares = [(here - moves).max(0.0).powi(2), (here + moves).powi(2)].map(|square| square + along_d);
            (actuator.copper() * squares[0], actuator.copper() * squares[1])
        };
        let (least, most) = self.samples.iter().enumerate().map(ends).unzip();
        Some([least, most])
    }

    /// The rise as a cut, and its sample: the polynomial that equals it at `ratio` and is nowhere above it. Temperature is
    /// convex and rising in the heat of every sample, so its gradient there bounds it from below. Where the
    /// heat runs away the cut is that of the first periods from cold, as many as it takes to be beyond
    /// `bound` \[K\].
    pub fn winding_peak_cut(
        &self,
        actuator: &Actuator,
        node: &TwoNode,
        ratio: f64,
        bound: f64,
    ) -> (Laurent, Option<usize>) {
        let WindingPeak { rise, gradient, sample } = self.winding_peak_gradient(actuator, node, ratio, bound);
        let squares = if actuator.shortfall.saturates() {
            let weights: Vec<f64> = gradient
                .iter()
                .zip(self.samples.iter())
                .map(|(weight, sample)| {
                    let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
                    weight * actuator.heat((a / ratio + c + b * ratio).powi(2)).1
                })
                .collect();
            self.weighted_torque_squared(actuator, &weights)
        } else {
            self.weighted_torque_squared(actuator, &gradient) * actuator.heating()
        };
        (squares + Laurent::constant(rise - squares.at(ratio)), sample)
    }

    /// The largest rise at a ratio with its gradient; of the first periods where the heat runs away.
    pub fn winding_peak_gradient(&self, actuator: &Actuator, node: &TwoNode, ratio: f64, bound: f64) -> WindingPeak {
        let heat = self.copper_heat(actuator, ratio);
        let (sample, (rise, gradient)) = match self.settle(node, heat.clone()) {
            Some(Settled { course, heat, phase, temperature }) => {
                let gradient = node.peak_gradient(&course.heat(&heat, &phase), course.course, &temperature);
                let gradient = self.of_samples(course, gradient);
                let rise = temperature.peak - node.ambient;
                let of_bound = match rise {
                    _ if rise <= FAR_BEYOND * bound => (rise, gradient),
                    _ if rise < LARGEST => node.far_beyond(rise, gradient, bound),
                    _ => self.until_beyond(node, (course, &heat, &phase), bound),
                };
                (Some(course.sample(temperature.peak_sample, self.samples.len())), of_bound)
            }
            None => (None, self.first_periods(node, heat, bound)),
        };
        WindingPeak { rise, gradient, sample }
    }

    /// A gradient by the heat of every sample, from that by the mean heat and by the heat of the hottest phase of every entry.
    fn of_samples(&self, course: &HeatCourse, gradient: [Vec<f64>; 2]) -> Vec<f64> {
        let [mut mean, phase] = gradient.map(|each| course.gather(each, self.samples.len()));
        mean.iter_mut().zip(phase).enumerate().for_each(|(k, (g, phase))| *g += (1.0 + self.stands(k)) * phase);
        mean
    }

    /// Share of the time of a sample at which the rotor stands.
    fn stands(&self, k: usize) -> f64 {
        if self.weight[k] > 0.0 { self.rest[k] / self.weight[k] } else { self.still[k] }
    }

    /// True if the phases of the winding have temperatures of their own.
    fn has_phases(&self, node: &TwoNode) -> bool {
        node.phases && self.stands > 0.0
    }

    /// The heat of every entry of the course, and of its hottest phase, empty where the phases share the heat alike.
    fn spread(&self, course: &HeatCourse, node: &TwoNode, heat: Vec<f64>) -> [Vec<f64>; 2] {
        let phase = match self.has_phases(node) {
            true => course.spread(heat.iter().enumerate().map(|(k, heat)| (1.0 + self.stands(k)) * heat).collect()),
            false => Vec::new(),
        };
        [course.spread(heat), phase]
    }

    /// Rise and gradient after the first periods of a heat that runs away.
    fn first_periods(&self, node: &TwoNode, heat: Vec<f64>, bound: f64) -> (f64, Vec<f64>) {
        let Some(course) = &self.course else { return (f64::INFINITY, vec![0.0; heat.len()]) };
        let [heat, phase] = self.spread(course, node, heat);
        let mut periods = 1;
        loop {
            let mut times: Vec<f64> =
                (0..periods).flat_map(|n| course.times.iter().map(move |t| t + n as f64 * course.lasts)).collect();
            // The end of a period and the start of the next are one, but for rounding.
            (1..times.len()).for_each(|k| times[k] = times[k].max(times[k - 1]));
            let repeated = |of: &[f64]| (0..periods).flat_map(|_| of.iter().copied()).collect::<Vec<f64>>();
            let (all, of_phase) = (repeated(&heat), repeated(&phase));
            let long = Heat {
                times: &times,
                period_or_duration: periods as f64 * course.lasts,
                heat: &all,
                settling: &[],
                phase: &of_phase,
            };
            let temperature = node.from_cold(&long);
            let rise = temperature.peak - node.ambient;
            let last = periods >= 1 << 14 || 2 * all.len() > FIRST_SAMPLES;
            if periods == 1 && rise.is_nan() | (rise >= LARGEST) {
                return self.until_beyond(node, (course, &heat, &phase), bound);
            }
            if (rise > bound && rise.is_finite()) || last {
                let each = node.peak_gradient(&long, Course::FromCold, &temperature);
                let of_entry = |each: &[f64], k: usize| each.iter().skip(k).step_by(heat.len()).sum::<f64>();
                let summed = each.map(|each| (0..heat.len()).map(|k| of_entry(&each, k)).collect());
                return (rise, self.of_samples(course, summed));
            }
            periods *= 2;
        }
    }

    /// Rise and gradient of the beginning of a course from cold whose rise leaves all numbers: it ends where the rise is beyond the
    /// bound, so that the rise over all of the course is no less.
    fn until_beyond(
        &self,
        node: &TwoNode,
        (course, heat, phase): (&HeatCourse, &[f64], &[f64]),
        bound: f64,
    ) -> (f64, Vec<f64>) {
        let (begin, count) = (course.times[0], course.times.len());
        let (mut short, mut long) = (0.0, course.lasts);
        loop {
            let until = 0.5 * (short + long);
            // The entries before, and how far it is on the way to the one after.
            let before = course.times.partition_point(|t| t - begin < until).clamp(1, count);
            let next = before.min(count - 1);
            let way = course.times[next] - course.times[before - 1];
            let share = if way > 0.0 { (until - (course.times[before - 1] - begin)) / way } else { 0.0 };
            let cut = |of: &[f64]| -> Vec<f64> {
                let Some(last) = of.get(before - 1) else { return Vec::new() };
                of[..before].iter().copied().chain([last + share * (of[next] - last)]).collect()
            };
            let (times, all, of_phase) = (cut(&course.times), cut(heat), cut(phase));
            let part = Heat {
                times: &times,
                period_or_duration: times[before] - begin,
                heat: &all,
                settling: &[],
                phase: &of_phase,
            };
            let temperature = node.from_cold(&part);
            let rise = temperature.peak - node.ambient;
            match rise {
                _ if rise <= bound => short = until,
                _ if rise <= FAR_BEYOND * bound.max(1.0) || long - short <= f64::EPSILON * long => {
                    let mut each = node.peak_gradient(&part, Course::FromCold, &temperature);
                    for gradient in each.iter_mut().filter(|gradient| gradient.len() > before) {
                        let last = gradient.split_off(before)[0];
                        gradient.resize(count, 0.0);
                        gradient[before - 1] += (1.0 - share) * last;
                        gradient[next] += share * last;
                    }
                    return (rise, self.of_samples(course, each));
                }
                _ => long = until,
            }
            if long - short <= f64::EPSILON * long {
                return (f64::INFINITY, vec![0.0; self.samples.len()]);
            }
        }
    }

    /// The course, the heat over it with its rest, and the temperatures; `None` where they run away.
    fn settle(&self, node: &TwoNode, heat: Vec<f64>) -> Option<Settled<'_>> {
        let course = self.course.as_deref()?;
        let [heat, phase] = self.spread(course, node, heat);
        let temperature = match course.course {
            Course::Periodic => match node.periodic_state(&course.heat(&heat, &phase)) {
                Outcome::Settles(temperature) => temperature,
                Outcome::Runaway => return None,
            },
            Course::FromCold => node.from_cold(&course.heat(&heat, &phase)),
        };
        Some(Settled { course, heat, phase, temperature })
    }

    /// The squared current \[A²\] of every sample at a ratio, with that of samples at standstill increased by the share
    /// `standing` of itself.
    pub fn squared_currents(&self, actuator: &Actuator, standing: f64, ratio: f64) -> Vec<f64> {
        let mut squares = self.copper_heat(actuator, ratio);
        let per_heat = 1.0 / actuator.resistance;
        squares.iter_mut().enumerate().for_each(|(k, heat)| *heat *= self.held(k, standing) * per_heat);
        squares
    }

    /// The largest heat at standstill \[W\] at a ratio, at the reference temperature; how long the motion stands in all
    /// \[s\]; and after what time it is made again \[s\], infinite where it is made once.
    pub fn heat_at_standstill(&self, actuator: &Actuator, ratio: f64) -> (f64, f64, f64) {
        let duration = self.moves;
        let cycle = match self.course.as_deref() {
            None => duration,
            Some(HeatCourse { course: Course::Periodic, lasts, .. }) => *lasts,
            Some(_) => f64::INFINITY,
        };
        let heat = self.copper_heat(actuator, ratio).into_iter().zip(self.still.iter());
        let largest = heat.map(|(heat, still)| heat * still).fold(0.0, f64::max);
        let stands = self.still.iter().zip(self.weight.iter()).filter(|(still, _)| **still > 0.0);
        let partly: f64 = stands.map(|(_, weight)| weight).sum();
        // A sample with a degree of standstill lasts its whole time, with that share of its heat.
        let lasts = if self.stands_at.is_some() { partly } else { self.stands };
        (largest, lasts * duration, cycle)
    }

    /// What the heat of a sample counts as, for the phase that is worst off.
    fn held(&self, k: usize, standing: f64) -> f64 {
        1.0 + standing * self.still[k]
    }

    /// The squared torque over the motion at a flange that has an inertia of its own \[kg·m²\] to turn \[N²·m²\], as
    /// [`Load::course_of`]: that while it turns, and twice that at standstill, as the worst phase's heat is. `None` without durations.
    pub fn flange_course(&self, inertia: f64) -> Option<(Vec<[Piece; 2]>, bool)> {
        if !self.has_flange_course() {
            return None;
        }
        let squares = |(k, sample): (usize, &WavePoint)| {
            let (square, still) = (sample.flange_torque(inertia).powi(2), self.still[k]);
            [(1.0 - still) * square, 2.0 * still * square]
        };
        Some(self.courses_of(&self.samples.iter().enumerate().map(squares).collect::<Vec<_>>()))
    }

    /// Whether there is such a course.
    pub fn has_flange_course(&self) -> bool {
        self.duration.is_some() && self.has_durations
    }

    /// Mean square of the same torque \[N²·m²\], that at standstill twice.
    pub fn flange_mean_square(&self, inertia: f64) -> f64 {
        let square = |(k, sample): (usize, &WavePoint)| self.share(k, 1.0) * sample.flange_torque(inertia).powi(2);
        self.samples.iter().enumerate().map(square).sum()
    }

    /// Squared currents or torques of the samples over the motion, in the order of time, and whether they repeat. Operating
    /// points go from the coolest to the hottest: the order that is worst where they repeat. Without durations it is empty.
    pub fn course_of(&self, squares: Vec<f64>) -> (Vec<Piece>, bool) {
        let (pieces, repeats) = self.courses_of(&squares.into_iter().map(|square| [square]).collect::<Vec<_>>());
        (pieces.into_iter().flatten().collect(), repeats)
    }

    /// Pieces of several squares of each sample, side by side; operating points in the order of their sums.
    fn courses_of<const N: usize>(&self, squares: &[[f64; N]]) -> (Vec<[Piece; N]>, bool) {
        let Some(course) = &self.course else {
            let Some(lasts) = self.duration else { return (Vec::new(), true) };
            let hold = |(squares, share): (&[f64; N], &f64)| {
                squares.map(|square| Piece { duration: share * lasts, from: square, to: square })
            };
            let mut pieces: Vec<[Piece; N]> = squares.iter().zip(self.weight.iter()).map(hold).collect();
            let sum = |pieces: &[Piece; N]| pieces.iter().map(|piece| piece.from).sum::<f64>();
            pieces.sort_by(|a, b| sum(a).total_cmp(&sum(b)));
            return (pieces, true);
        };
        let each: [Vec<Piece>; N] = std::array::from_fn(|n| {
            course.pieces(&course.spread(squares.iter().map(|of_sample| of_sample[n]).collect()))
        });
        let count = each.first().map_or(0, Vec::len);
        let pieces = (0..count).map(|k| std::array::from_fn(|n| each[n][k])).collect();
        (pieces, course.course == Course::Periodic)
    }

    /// Copper heat of every sample at a ratio, at the reference temperature \[W\].
    fn copper_heat(&self, actuator: &Actuator, ratio: f64) -> Vec<f64> {
        work::count(self.samples.len());
        let (copper, down, linear) = (actuator.copper(), 1.0 / ratio, actuator.shortfall.is_nothing());
        let square = |(k, sample): (usize, &WavePoint)| {
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            let squared = (a * down + c + b * ratio).powi(2);
            let own = if linear { copper * squared } else { actuator.heat(squared).0 };
            own + copper * self.direct(k).powi(2)
        };
        self.samples.iter().enumerate().map(square).collect()
    }

    /// `Σ weight T²` over the samples \[N²·m²\].
    fn weighted_torque_squared(&self, actuator: &Actuator, weights: &[f64]) -> Laurent {
        work::count(self.samples.len());
        let mut sum = [0.0; 5];
        for (sample, weight) in self.samples.iter().zip(weights) {
            let [a, c, b] = actuator.torque_terms(sample.flow, &sample.features);
            for (s, t) in sum.iter_mut().zip([a * a, 2.0 * a * c, c * c + 2.0 * a * b, 2.0 * b * c, b * b]) {
                *s += weight * t;
            }
        }
        sum.iter().zip(-2..).map(|(c, power)| Laurent::monomial(*c, power)).fold(Laurent::default(), |a, b| a + b)
    }

    /// Mean terminal power over time \[W\], with heat as if the iron did not saturate.
    pub fn mean_power(&self, actuator: &Actuator) -> Laurent {
        let mut speed = ShaftForm::default();
        speed[Feature::Velocity] = 1.0;
        let mechanical = quadratic(&self.mean, |flow| (actuator.torque_form(flow), &speed));
        self.mean_torque_squared(actuator) * actuator.heating()
            + mechanical * (actuator.back_emf_constant / actuator.torque_constant)
    }

    /// Mean power of a torque at the motor's shaft \[W\], by which way power flows through the gear.
    pub fn mean_shaft_power(&self, form: impl Fn(Flow) -> ShaftForm) -> Laurent {
        let speed = Feature::Velocity as usize;
        let mut sum = Laurent::default();
        for flow in Flow::ALL {
            let form = form(flow);
            for f in (0..FEATURES).filter(|f| form.0[*f] != 0.0) {
                let coefficient = form.0[f] * self.mean[flow as usize][f][speed];
                sum = sum + Laurent::monomial(coefficient, FEATURE_POWER[f] + FEATURE_POWER[speed]);
            }
        }
        sum
    }

    /// Mean of the square of a torque at the motor's shaft \[N²·m²\], by which way power flows through the gear.
    pub fn mean_squared_difference(&self, form: impl Fn(Flow) -> ShaftForm) -> Laurent {
        let forms = Flow::ALL.map(form);
        quadratic(&self.mean, |flow| (&forms[flow as usize], &forms[flow as usize]))
    }

    /// Mean power at the output \[W\]: what the load, with all that the gear's efficiency covers, takes.
    pub fn mean_output(&self) -> f64 {
        let (torque, speed) = (Feature::Load as usize, Feature::Velocity as usize);
        Flow::ALL.iter().map(|flow| self.mean[*flow as usize][torque][speed]).sum()
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

/// Weighted sums of products of features.
fn moments(samples: &[WavePoint], weights: &[f64]) -> Moments {
    let mut sums: Moments = Default::default();
    for (sample, weight) in samples.iter().zip(weights) {
        let (x, sums) = (&sample.features, &mut sums[sample.flow as usize]);
        for f in 0..FEATURES {
            for g in 0..FEATURES {
                sums[f][g] += weight * x[f] * x[g];
            }
        }
    }
    sums
}

/// `Σ a_f b_g M_fg N^(p_f + p_g)` over all ways that power flows.
fn quadratic<'a>(moments: &Moments, forms: impl Fn(Flow) -> (&'a ShaftForm, &'a ShaftForm)) -> Laurent {
    let mut sum = Laurent::default();
    for flow in Flow::ALL {
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
