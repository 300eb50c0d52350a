//! Standstill of the rotor, by the electrical angle that it sweeps.
//!
//! The heat of a phase of a brushless winding with the current `i` is `i² (1 + cos(2 θ_e − φ))` for some φ. Behind the winding's
//! lag τ the hottest phase exceeds the mean by `|z|`, with `τ dz/dt = i² e^{j 2 θ_e} − z`. Hence `τ d|z|/dt + |z| = i² cos(2 θ_e − arg z)`:
//! the *degree* of standstill is that cosine, 1 for a rotor at rest, `1/√(1 + (2 ω_e τ)²)` in a steady crawl, `J_0(κ A)` on average
//! for a quick sway of the amplitude A with constant torque (`κ = 2 p N`). The square of the load torque stands for `i²`.
//!
//! Passages in which the rotor sweeps a large angle at an even speed and torque average out. The intervals between them are *stays*.
//! A large angle that is swept unevenly ends a stay as well. The excesses of stays are added as if every stay heated the same phase:
//! which phase it heats depends on the last digit of the ratio.
//!
//! Small excesses are neglected, so that ordinary motion has no degree. A stay counts if its mean excess is at least half of that at
//! standstill, and in full from three quarters. All stays count if the moving samples together have at least a fifth of it, and in
//! full from 0.45. `docs/model.md` gives the error in numbers.
//!
//! Degrees are evaluated at four values of κ to an octave, made not to rise with κ, and rounded up to 1/64.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::Complex;

use crate::numerics::work;
use crate::requirement::{Course, Motion};

/// Degrees are multiples of one over this.
pub(super) const GRADES: f64 = 64.0;
/// Excess of all moving samples, as a share of that at standstill, from which it counts and from which it counts in full.
const OF_MOTION: [f64; 2] = [0.2, 0.45];
/// Mean excess of one stay, as a share of that at standstill, from which it counts and from which it counts in full.
const OF_STAY: [f64; 2] = [0.5, 0.75];
/// Excess of the stays that count by themselves, as a share of the motion's heat, from which they do, and in full.
const SHARE: [f64; 2] = [0.01, 0.03];
/// Twice the electrical angle \[rad\] swept without pause, and within a time constant, from which it averages out.
const SWEPT: f64 = 16.0;
/// Largest relative change of speed and squared torque within 1 rad of twice the electrical angle of a passage that averages out.
const STEADY: f64 = 0.1;
/// Twice the electrical angle \[rad\] that an uneven stay sweeps at most.
const WIDEST: f64 = 2.0 * std::f64::consts::TAU;
/// Twice the electrical angle \[rad\] of a step of the integration.
const STEP: f64 = 0.7;
/// Twice the electrical angle \[rad\] swept in one interval from which it averages out, even if the rotor turns back in it.
const LARGE: f64 = 150.0;
/// Durations \[s\] of an operating point up to which it counts as if it went on at its speed, and from which as if it ended there.
const SHORT: [f64; 2] = [0.1, 0.2];
/// Share of the whole path by which a period that closes may miss its start.
const CLOSES: f64 = 1e-3;
/// The first step of κ of a table; below it everything stands.
const FIRST: i32 = -20;
/// The last step of κ that is looked at.
const LAST: i32 = 400;
/// Steps of κ without any degree after which there is none.
const IDLE: i32 = 48;

/// One course of a motion: positions in time, or operating points.
#[derive(Debug, Clone)]
struct Run {
    /// Sample range within the motion.
    samples: Range<usize>,
    course: Course,
    /// Time of each sample from the first \[s\]; duration of each operating point, infinite where it is not known.
    time: Vec<f64>,
    /// Position \[rad\] of each sample from the first, and that at the end of a period.
    position: Vec<f64>,
    /// Speed \[rad/s\] and torque \[N·m\] of each sample, and of the first again at the end of a period.
    velocity: Vec<f64>,
    torque: Vec<f64>,
    /// True for each interval at rest: the speed is zero at both ends.
    rests: Vec<bool>,
}

/// Intervals that follow one another, with heat in units of squared torque times time.
#[derive(Debug, Clone, Copy)]
struct Part {
    /// The first interval and their number; at the end of a period they go on at its start.
    first: usize,
    count: usize,
    /// Number of the stay; `None` where the angle swept averages out.
    stay: Option<usize>,
    lasts: f64,
    heat: f64,
    /// Heat while at rest.
    resting: f64,
    /// Excess of the hottest phase.
    excess: f64,
}

impl Part {
    /// Heat and excess of what is not at rest.
    fn moving(&self) -> (f64, f64) {
        let heat = (self.heat - self.resting).max(0.0);
        (heat, (self.excess - self.resting).clamp(0.0, heat))
    }
}

/// The degrees of one time constant, by the step of κ from [`FIRST`], as far as there are any.
type Table = Vec<Arc<[u8]>>;

/// The angles that a motion sweeps.
#[derive(Debug)]
pub(super) struct Sweep {
    runs: Vec<Run>,
    samples: usize,
    /// By the bits of the time constant.
    tables: Mutex<BTreeMap<u64, Arc<OnceLock<Table>>>>,
}

/// Linear ramp from zero at the first number to one at the second.
fn ramp(x: f64, [from, to]: [f64; 2]) -> f64 {
    ((x - from) / (to - from)).clamp(0.0, 1.0)
}

/// Complex number of a size and an angle \[rad\].
fn of_angle(size: f64, angle: f64) -> Complex<f64> {
    let (sin, cos) = angle.sin_cos();
    Complex::new(size * cos, size * sin)
}

/// Excess at the end of a turn at a steady speed from rest, relative to that at standstill, with `2 ω_e τ` and the duration over τ.
fn turned(angle: f64, lasts: f64) -> f64 {
    if angle.is_infinite() {
        return 0.0;
    }
    let decay = (-lasts).exp();
    // Infinite times zero where it goes on.
    let (sin, cos) = if decay > 0.0 { (angle * lasts).sin_cos() } else { (0.0, 1.0) };
    let rises = (1.0 - decay * cos).hypot(decay * sin) / -(-lasts).exp_m1();
    rises / angle.hypot(1.0)
}

impl Run {
    fn new(motion: &Motion, samples: Range<usize>, course: Course) -> Run {
        let mut velocity = motion.velocity[samples.clone()].to_vec();
        let mut torque = motion.torque[samples.clone()].to_vec();
        if motion.sprung {
            torque.fill(1.0);
        }
        let n = velocity.len();
        let own = &motion.time[samples.clone()];
        let ordered = own.windows(2).all(|pair| pair[1] >= pair[0]);
        let lasts = match course {
            Course::Periodic(period) if ordered => period,
            Course::Once(_) if ordered && n > 1 => own[n - 1] - own[0],
            _ => {
                let whole: f64 = motion.weight[samples.clone()].iter().sum();
                let duration = match course {
                    Course::Points(duration) => duration,
                    _ => None,
                };
                let time = |weight: &f64| duration.map_or(f64::INFINITY, |d| d * weight / whole);
                return Run {
                    time: motion.weight[samples.clone()].iter().map(time).collect(),
                    position: Vec::new(),
                    velocity,
                    torque,
                    rests: Vec::new(),
                    course: Course::Points(duration),
                    samples,
                };
            }
        };
        let mut acceleration = motion.acceleration[samples.clone()].to_vec();
        let mut time: Vec<f64> = own.iter().map(|t| t - own[0]).collect();
        if matches!(course, Course::Periodic(_)) {
            time.push(lasts.max(time[n - 1]));
            for values in [&mut velocity, &mut torque, &mut acceleration] {
                values.push(values[0]);
            }
        }
        let (mut position, mut rests) = (vec![0.0], Vec::new());
        for i in 0..time.len() - 1 {
            let h = time[i + 1] - time[i];
            let way =
                0.5 * h * (velocity[i] + velocity[i + 1]) + h * h / 12.0 * (acceleration[i] - acceleration[i + 1]);
            position.push(position[i] + way);
            rests.push(velocity[i] == 0.0 && velocity[i + 1] == 0.0);
        }
        // What sampling leaves open at the end of a period.
        let (left, end) = (position[position.len() - 1], time[time.len() - 1]);
        let path: f64 = position.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum();
        if matches!(course, Course::Periodic(_)) && left.abs() <= CLOSES * path && end > 0.0 {
            position.iter_mut().zip(&time).for_each(|(q, t)| *q -= left * t / end);
        }
        Run { samples, course, time, position, velocity, torque, rests }
    }

    fn is_periodic(&self) -> bool {
        matches!(self.course, Course::Periodic(_))
    }

    /// Number of intervals.
    fn count(&self) -> usize {
        self.rests.len()
    }

    /// Duration \[s\].
    fn lasts(&self) -> f64 {
        self.time.last().copied().unwrap_or(0.0)
    }

    /// Duration of an interval \[s\].
    fn duration(&self, i: usize) -> f64 {
        self.time[i + 1] - self.time[i]
    }

    /// Mean square \[N²·m²\] of the torque over an interval, in which it is linear.
    fn square(&self, i: usize) -> f64 {
        let (a, b) = (self.torque[i], self.torque[i + 1]);
        (a * a + a * b + b * b) / 3.0
    }

    /// Twice the electrical angle \[rad\] swept in an interval, at most.
    fn swept(&self, i: usize, kappa: f64) -> f64 {
        let way = (self.position[i + 1] - self.position[i]).abs();
        kappa * way.max(self.duration(i) * self.velocity[i].abs().max(self.velocity[i + 1].abs()))
    }

    /// For each interval, true if speed and torque change little within 1 rad.
    fn is_even(&self, kappa: f64) -> Vec<bool> {
        let lasts = self.lasts();
        let mean = (0..self.count()).map(|i| self.square(i) * self.duration(i)).sum::<f64>() / lasts;
        let is_even = |i: usize| {
            let (a, b) = (self.velocity[i], self.velocity[i + 1]);
            let [before, after] = [i, i + 1].map(|k| self.torque[k] * self.torque[k]);
            let (least, h) = (kappa * a.abs().min(b.abs()), self.duration(i));
            a * b > 0.0
                && kappa * (b - a).abs() <= STEADY * least * least * h
                && (after - before).abs() <= STEADY * least * h * before.max(after).max(mean)
        };
        (0..self.count()).map(is_even).collect()
    }

    /// For each interval, true if a run of the fastest intervals begins there.
    fn begins_fastest(&self) -> Vec<bool> {
        let swept: Vec<f64> = (0..self.count()).map(|i| self.swept(i, 1.0)).collect();
        let most = swept.iter().fold(0.0, |most: f64, swept| most.max(*swept));
        let is_fastest = |i: usize| swept[i] >= (1.0 - 1e-6) * most;
        let before = |i: usize| (i + swept.len() - 1) % swept.len();
        (0..swept.len()).map(|i| is_fastest(i) && !is_fastest(before(i))).collect()
    }

    /// For each interval, true if the angle that is swept in it and about it averages out.
    fn averages_out(&self, even: &[bool], kappa: f64, tau: f64) -> Vec<bool> {
        let count = self.count();
        let is_even =
            |i: usize| even[i] && kappa * self.velocity[i].abs().min(self.velocity[i + 1].abs()) * tau >= SWEPT;
        let mut out: Vec<bool> = (0..count).map(|i| self.swept(i, kappa) > LARGE).collect();
        // A passage may go on beyond the end of a period.
        let first = if self.is_periodic() { (0..count).find(|i| !is_even(*i)) } else { Some(0) };
        let Some(first) = first else { return vec![true; count] };
        let at = |k: usize| (first + k) % count;
        let mut from = 0;
        while from < count {
            let to = (from..count).find(|k| !is_even(at(*k))).unwrap_or(count);
            let swept: f64 = (from..to).map(|k| (self.position[at(k) + 1] - self.position[at(k)]).abs() * kappa).sum();
            if swept >= SWEPT {
                (from..to).for_each(|k| out[at(k)] = true);
            }
            from = to + 1;
        }
        out
    }

    /// Integrate `z` over an interval from a position \[rad\]: `z` at its end, and the integral of `|z|` over time.
    fn integrate(&self, i: usize, from: f64, mut z: Complex<f64>, (kappa, tau): (f64, f64)) -> (Complex<f64>, f64) {
        let (h, v) = (self.duration(i), [self.velocity[i], self.velocity[i + 1]]);
        if h <= 0.0 {
            return (z, 0.0);
        }
        let way = self.position[i + 1] - self.position[i];
        let steps = (self.swept(i, kappa) / STEP).max(4.0 * h / tau).ceil().clamp(1.0, LARGE / STEP);
        let part = h / steps;
        let share = -(-part / tau).exp_m1();
        let (mut size, mut integral) = (z.norm(), 0.0);
        for step in 0..steps as usize {
            let s = (step as f64 + 0.5) / steps;
            let torque = self.torque[i] + s * (self.torque[i + 1] - self.torque[i]);
            // Cubic through positions and speeds.
            let (v0, v1) = (v[0] * h, v[1] * h);
            let cubic = s * v0 + s * s * (3.0 * way - 2.0 * v0 - v1) + s * s * s * (v0 + v1 - 2.0 * way);
            z += (of_angle(torque * torque, kappa * (from + cubic)) - z) * share;
            let before = std::mem::replace(&mut size, z.norm());
            integral += 0.5 * part * (before + size);
        }
        (z, integral)
    }

    /// Contribution to `z` of the end of a passage that averages out, at a sample: the first term of the integral by parts. A
    /// passage that begins there takes it away. Zero where the rotor is slow.
    fn edge(&self, i: usize, position: f64, (kappa, tau): (f64, f64)) -> Complex<f64> {
        let (torque, turns) = (self.torque[i], kappa * self.velocity[i]);
        if turns.abs() * tau < SWEPT {
            return Complex::ZERO;
        }
        // Divided by j.
        of_angle(torque * torque / (turns * tau), kappa * position) * -Complex::I
    }

    /// The parts of a run, of a winding with a time constant \[s\], in order.
    fn parts(&self, kappa: f64, tau: f64) -> Vec<Part> {
        let (count, at) = (self.count(), (kappa, tau));
        let (is_periodic, way) = (self.is_periodic(), self.position[count]);
        let even = self.is_even(kappa);
        let passes = self.averages_out(&even, kappa, tau);
        let ends = |(low, high): (f64, f64), q: &f64| (low.min(*q), high.max(*q));
        let (low, high) = self.position.iter().fold((0.0, 0.0), ends);
        // One stay of everything that begins again with the period.
        let first_pass = passes.iter().position(|passes| *passes);
        let is_one = first_pass.is_none() && (kappa * (high - low) <= WIDEST || !even.contains(&false));
        let fastest = self.begins_fastest();
        let first = match first_pass {
            _ if !is_periodic => 0,
            Some(pass) => pass,
            None => fastest.iter().position(|begins| *begins).unwrap_or(0),
        };
        // A new stay and a new part begin here, so that a period written several times has the stays of one.
        let is_anew = |i: usize| is_periodic && fastest[i] && first_pass.is_none();
        let place = |k: usize| ((first + k) % count, if first + k < count { 0.0 } else { way });
        let mut z = Complex::ZERO;
        if is_periodic && is_one {
            // The state that repeats, turned by the way of a period.
            for k in 0..count {
                let (i, turns) = place(k);
                z = self.integrate(i, self.position[i] + turns, z, at).0;
            }
            let decay = (-self.lasts() / tau).exp();
            let (sin, cos) = (kappa * way).sin_cos();
            z /= Complex::new(cos - decay, sin);
        }
        let mut parts: Vec<Part> = Vec::new();
        let (mut begins, mut stay, mut was_passing) = (true, 0, false);
        // The least and the largest position of the stay, and whether it is even so far.
        let (mut range, mut is_uneven) = ((f64::INFINITY, f64::NEG_INFINITY), false);
        for k in 0..count {
            let (i, turns) = place(k);
            let lasts = self.duration(i);
            let heat = self.square(i) * lasts;
            let mut part = Part { first: i, count: 1, stay: None, lasts, heat, resting: 0.0, excess: 0.0 };
            if passes[i] {
                was_passing = true;
            } else {
                if was_passing {
                    // At a jump of the position the passage ends elsewhere.
                    z = self.edge(i, self.position[i] + turns, at);
                    (stay, begins, was_passing) = (stay + 1, true, false);
                    (range, is_uneven) = ((f64::INFINITY, f64::NEG_INFINITY), false);
                }
                is_uneven |= !even[i];
                range = [i, i + 1].map(|k| self.position[k] + turns).iter().fold(range, ends);
                let is_wide = is_uneven && kappa * (range.1 - range.0) > WIDEST;
                if (is_wide || is_anew(i)) && !is_one && !begins {
                    z = Complex::ZERO;
                    (stay, begins, is_uneven) = (stay + 1, true, !even[i]);
                    range = (self.position[i] + turns, self.position[i + 1] + turns);
                    range = (range.0.min(range.1), range.0.max(range.1));
                }
                let before = if begins && !is_one { 0.0 } else { z.norm() };
                begins = false;
                let (end, integral) = self.integrate(i, self.position[i] + turns, z, at);
                z = end;
                let next = place(k + 1).0;
                let is_last = (k + 1 < count || is_periodic) && passes[next];
                let edge = match is_last {
                    true => self.edge(i + 1, self.position[i + 1] + turns, at),
                    false => Complex::ZERO,
                };
                let left = (z - edge).norm();
                part.stay = Some(stay);
                part.excess = tau * (left - before) + integral;
                part.resting = if self.rests[i] { heat } else { 0.0 };
            }
            let goes_on = |last: &&mut Part| last.stay == part.stay && last.lasts + lasts <= 0.25 * tau && !fastest[i];
            match parts.last_mut().filter(goes_on) {
                Some(last) => {
                    last.count += 1;
                    last.lasts += lasts;
                    last.heat += heat;
                    last.resting += part.resting;
                    last.excess += part.excess;
                }
                None => parts.push(part),
            }
        }
        parts
    }

    /// Largest values behind the winding's lag of heat and excesses, which `of_part` gives for each part.
    fn peaks<const N: usize>(&self, parts: &[Part], tau: f64, of_part: impl Fn(&Part) -> [f64; N]) -> [f64; N] {
        let lag = |start: [f64; N], peak: &mut [f64; N]| {
            parts.iter().fold(start, |now, part| {
                let share = -(-part.lasts / tau).exp_m1();
                let mut next = now;
                for (k, heat) in of_part(part).into_iter().enumerate() {
                    let mean = if part.lasts > 0.0 { heat / part.lasts } else { 0.0 };
                    next[k] += share * (mean - now[k]);
                    peak[k] = peak[k].max(next[k]);
                }
                next
            })
        };
        let mut peaks = [0.0; N];
        let end = lag([0.0; N], &mut peaks);
        if self.is_periodic() {
            let left = -(-self.lasts() / tau).exp_m1();
            lag(end.map(|end| end / left), &mut peaks);
        }
        peaks
    }

    /// Degree of every moving sample at a κ, of a winding with a time constant \[s\].
    fn degrees(&self, kappa: f64, tau: f64) -> Vec<f64> {
        if let Course::Points(_) = self.course {
            let of_point = |(speed, lasts): (&f64, &f64)| {
                // A short one as if it went on: where it goes next is not known.
                let of = |lasts: f64| turned(kappa * speed.abs() * tau, lasts / tau);
                let ends = ramp(*lasts, SHORT);
                let degree = ends * of(*lasts) + (1.0 - ends) * of(f64::INFINITY);
                degree * ramp(degree, OF_MOTION)
            };
            return self.velocity.iter().zip(&self.time).map(of_point).collect();
        }
        let (count, lasts) = (self.count(), self.lasts());
        if count == 0 || lasts <= 0.0 {
            return vec![0.0; self.samples.len()];
        }
        let parts = self.parts(kappa, tau);
        let stays = parts.iter().filter_map(|part| part.stay).max().map_or(0, |last| last + 1);
        let mut of_stays = vec![(0.0, 0.0); stays];
        for (part, stay) in parts.iter().filter_map(|part| Some((part, part.stay?))) {
            let (heat, excess) = part.moving();
            of_stays[stay].0 += heat;
            of_stays[stay].1 += excess;
        }
        // Share to which each stay counts by itself.
        let own: Vec<f64> =
            of_stays.iter().map(|(heat, excess)| ramp(excess / heat.max(f64::MIN_POSITIVE), OF_STAY)).collect();
        let [mean, excess, by_themselves] = self.peaks(&parts, tau, |part| {
            let excess = part.moving().1;
            [part.heat, excess, part.stay.map_or(0.0, |stay| own[stay] * excess)]
        });
        let share = |excess: f64, limits| if mean > 0.0 { ramp(excess / mean, limits) } else { 0.0 };
        let (of_motion, of_own) = (share(excess, OF_MOTION), share(by_themselves, SHARE));
        let of_stays: Vec<f64> = own.iter().map(|own| (own * of_own).max(of_motion)).collect();
        let mut of_intervals = vec![0.0_f64; count];
        for (part, stay) in parts.iter().filter_map(|part| Some((part, part.stay?))) {
            let (heat, excess) = part.moving();
            let degree = if heat > 0.0 { of_stays[stay] * excess / heat } else { 0.0 };
            (0..part.count).for_each(|k| of_intervals[(part.first + k) % count] = degree);
        }
        let of_sample = |k: usize| {
            let before = if k > 0 { Some(k - 1) } else { self.is_periodic().then(|| count - 1) };
            let beside = [before, (k < count).then_some(k)].into_iter().flatten().filter(|i| !self.rests[*i]);
            let (mut sum, mut length) = (0.0, 0.0);
            for i in beside {
                (sum, length) = (sum + self.duration(i) * of_intervals[i], length + self.duration(i));
            }
            if length > 0.0 { sum / length } else { 0.0 }
        };
        (0..self.samples.len()).map(of_sample).collect()
    }
}

impl Sweep {
    /// Build the sweep of a motion.
    pub(super) fn new(motion: &Motion) -> Sweep {
        let runs = motion.courses().into_iter().map(|(samples, course)| Run::new(motion, samples, course));
        Sweep { runs: runs.collect(), samples: motion.len(), tables: Mutex::default() }
    }

    /// The `κ = 2 p N` from which no sample that moves is at standstill to any degree, of a winding with a time constant \[s\].
    pub(super) fn counts_below(&self, tau: f64) -> f64 {
        self.with_table(tau, |table| begin_of(FIRST + table.len() as i32 * self.stride()))
    }

    /// Degree of standstill of every sample that moves, in 64ths, at a step of κ.
    pub(super) fn degrees(&self, step: i32, tau: f64) -> Arc<[u8]> {
        self.with_table(tau, |table| match (step - FIRST) / self.stride() {
            place if step >= FIRST => {
                table.get(place as usize).cloned().unwrap_or_else(|| vec![0; self.samples].into())
            }
            _ => vec![GRADES as u8; self.samples].into(),
        })
    }

    fn with_table<T>(&self, tau: f64, of: impl FnOnce(&Table) -> T) -> T {
        let table = {
            let mut tables = self.tables.lock().unwrap_or_else(PoisonError::into_inner);
            tables.entry(tau.to_bits()).or_default().clone()
        };
        of(table.get_or_init(|| work::uncounted(|| self.table(tau))))
    }

    /// Compute the degrees of every step of κ, which do not rise with κ.
    fn table(&self, tau: f64) -> Table {
        let mut table: Vec<Vec<u8>> = Vec::new();
        let mut idle = 0;
        for step in FIRST..LAST {
            let own = self.degrees_at(begin_of(step), tau);
            idle = if own.iter().any(|degree| *degree > 0) { 0 } else { idle + 1 };
            table.push(own);
            if idle >= IDLE {
                break;
            }
        }
        for k in (1..table.len()).rev() {
            let (lower, upper) = table.split_at_mut(k);
            lower[k - 1].iter_mut().zip(&upper[0]).for_each(|(here, above)| *here = (*here).max(*above));
        }
        table.truncate(table.iter().position(|own| own.iter().all(|degree| *degree == 0)).unwrap_or(table.len()));
        table.into_iter().step_by(self.stride() as usize).map(Arc::from).collect()
    }

    /// Degree of every moving sample at one κ, in 64ths.
    fn degrees_at(&self, kappa: f64, tau: f64) -> Vec<u8> {
        let mut all = vec![0; self.samples];
        for run in &self.runs {
            for (degree, of) in all[run.samples.clone()].iter_mut().zip(run.degrees(kappa, tau)) {
                // A value that exceeds a grade by rounding keeps that grade.
                *degree = (of * GRADES - 1e-9).ceil().max(0.0) as u8;
            }
        }
        all
    }

    /// Steps of κ between those of the table: motions of many samples have one to an octave.
    fn stride(&self) -> i32 {
        if self.samples > MANY { 4 } else { 1 }
    }

    /// Step of κ and time constant \[s\] for which the degrees of a winding are computed; `None` where there are none.
    pub(super) fn place(&self, kappa: f64, tau: f64) -> Option<(i32, f64)> {
        let (step, tau) = self.step_at(kappa, tau);
        (kappa < self.counts_below(tau)).then_some((step, tau))
    }

    /// Step of κ and time constant \[s\] by which degrees are kept, whether or not any is above zero.
    pub(super) fn step_at(&self, kappa: f64, tau: f64) -> (i32, f64) {
        (self.step_of(kappa), self.rounded(tau))
    }

    /// The κ from `low` to `high` at which degrees may change, in rising order.
    pub(super) fn steps_between(&self, (low, high): (f64, f64), tau: f64) -> Vec<f64> {
        let beyond = self.counts_below(self.rounded(tau));
        if low.is_nan() || low >= beyond {
            return Vec::new();
        }
        let first = self.step_of(low).max(FIRST - self.stride());
        let ends = (first + self.stride()..=LAST).step_by(self.stride() as usize).map(begin_of);
        ends.take_while(|kappa| *kappa <= high.min(beyond)).collect()
    }

    /// Time constant \[s\] for which degrees are computed, rounded down to a step as wide as those of κ: a shorter one has larger degrees.
    fn rounded(&self, tau: f64) -> f64 {
        let steps = 4.0 / f64::from(self.stride());
        ((steps * tau.log2() + 1e-9).floor() / steps).exp2()
    }

    /// Number of the step of κ, counted from [`FIRST`] by the stride.
    fn step_of(&self, kappa: f64) -> i32 {
        let fine = (4.0 * kappa.log2() + 1e-9).floor() as i32;
        fine.saturating_sub(FIRST).div_euclid(self.stride()).saturating_mul(self.stride()).saturating_add(FIRST)
    }
}

/// Motions of more samples have one step to an octave, of κ and of the time constant: each step holds numbers of all samples.
const MANY: usize = 2000;

/// The κ at which a step begins, and for which degrees are computed over all of it.
pub(super) fn begin_of(step: i32) -> f64 {
    if step < FIRST { 0.0 } else { (f64::from(step) / 4.0).exp2() }
}

/// Loads that differ in the degrees of standstill alone, made where they are asked for.
#[derive(Debug)]
pub(super) struct Stood<L>(OnceLock<Box<Node<L>>>);

#[derive(Debug)]
struct Node<L> {
    step: i32,
    tau: u64,
    degrees: Arc<[u8]>,
    /// `None` where no degree is above zero, or an earlier node has the same.
    load: Option<L>,
    next: Stood<L>,
}

impl<L> Default for Stood<L> {
    fn default() -> Stood<L> {
        Stood(OnceLock::new())
    }
}

/// A copy makes its own.
impl<L> Clone for Stood<L> {
    fn clone(&self) -> Stood<L> {
        Stood::default()
    }
}

impl<L> Stood<L> {
    fn nodes(&self) -> impl Iterator<Item = &Node<L>> {
        std::iter::successors(self.0.get(), |node| node.next.0.get()).map(|node| &**node)
    }

    /// The load at a step, from `make` where it is not there; `base` where nothing that moves stands.
    pub(super) fn of<'l>(
        &'l self,
        base: &'l L,
        (step, tau): (i32, f64),
        degrees: impl FnOnce() -> Arc<[u8]>,
        make: impl FnOnce(&[u8]) -> L,
    ) -> &'l L {
        let is_same = |node: &&Node<L>| node.step == step && node.tau == tau.to_bits();
        // Threads may add equal nodes at the same time: the first one counts, so that equal degrees share one load.
        let with = |degrees: &[u8]| {
            let alike = self.nodes().find(|node| *node.degrees == *degrees && node.load.is_some());
            alike.and_then(|node| node.load.as_ref()).unwrap_or(base)
        };
        if let Some(node) = self.nodes().find(is_same) {
            return with(&node.degrees);
        }
        let degrees = degrees();
        let is_new = degrees.iter().any(|d| *d > 0) && std::ptr::eq(with(&degrees), base);
        let load = is_new.then(|| work::uncounted(|| make(&degrees)));
        let mut node = Box::new(Node { step, tau: tau.to_bits(), degrees, load, next: Stood::default() });
        let mut at = self;
        // Another thread may add one meanwhile: then this comes after that.
        loop {
            match at.0.set(node) {
                Ok(()) => break,
                Err(mine) => node = mine,
            }
            at = match at.0.get() {
                Some(taken) => &taken.next,
                None => return base,
            };
        }
        let own = self.nodes().find(is_same).unwrap_or_else(|| unreachable!("it was added"));
        with(&own.degrees)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::requirement::{Point, Samples};

    #[test]
    fn loads_of_like_degrees_are_one_though_threads_make_them_at_once() {
        let (base, stood) = (0, Stood::default());
        let degrees = || Arc::from([1_u8, 2]);
        // Another thread adds its load while this one makes its own.
        let first = stood.of(&base, (1, 1.0), degrees, |_| *stood.of(&base, (2, 1.0), degrees, |_| 20) / 2);
        assert_eq!(*first, 20);
        for step in [1, 2, 3] {
            assert!(std::ptr::eq(stood.of(&base, (step, 1.0), degrees, |_| unreachable!("it is there")), first));
        }
        assert!(std::ptr::eq(stood.of(&base, (4, 1.0), || Arc::from([0, 0]), |_| 40), &base));
    }

    /// Peaks of the excess of the worst phase and of the mean heat behind a lag of `tau`: by integration over the electrical angle,
    /// and by degrees of standstill. The heat of every sample is the square of `torque`.
    fn excess(motion: &Motion, kappa: f64, tau: f64) -> (f64, f64, f64) {
        let run = Run::new(motion, 0..motion.len(), motion.course);
        let (count, n) = (run.count(), motion.len());
        let degrees = Sweep::new(motion).degrees_at(kappa, tau);
        let degree = |k: usize| {
            let rest = if motion.weight[k] > 0.0 { motion.dwell[k] / motion.weight[k] } else { 0.0 };
            rest + (1.0 - rest) * f64::from(degrees[k]) / GRADES
        };
        let periodic = matches!(motion.course, Course::Periodic(_));
        // From cold, or until the state repeats.
        let rounds = if periodic { (12.0 * tau / run.lasts()).ceil() as usize + 2 } else { 1 };
        let (mut truth, mut told, mut mean) = ([0.0_f64; 2], 0.0_f64, 0.0_f64);
        let mut peaks = (0.0_f64, 0.0_f64, 0.0_f64);
        for round in 0..rounds {
            for i in 0..count {
                let (next, h) = ((i + 1) % n, run.time[i + 1] - run.time[i]);
                let way = run.position[i + 1] - run.position[i];
                let turned = kappa * (way.abs() + h * motion.velocity[i].abs().max(motion.velocity[next].abs()));
                let parts = (4.0 + 8.0 * turned).ceil();
                for part in 0..parts as usize {
                    let s = (part as f64 + 0.5) / parts;
                    let between = |a: f64, b: f64| a + s * (b - a);
                    let heat = between(motion.torque[i], motion.torque[next]).powi(2);
                    // Cubic through positions and speeds.
                    let (v0, v1) = (motion.velocity[i] * h, motion.velocity[next] * h);
                    let cubic = s * v0 + s * s * (3.0 * way - 2.0 * v0 - v1) + s * s * s * (v0 + v1 - 2.0 * way);
                    let turns = round as f64 * run.position[count];
                    let angle = kappa * (turns + run.position[i] + cubic);
                    let decay = (-h / parts / tau).exp();
                    let lag = |y: f64, x: f64| x + (y - x) * decay;
                    truth = [lag(truth[0], heat * angle.cos()), lag(truth[1], heat * angle.sin())];
                    told = lag(told, heat * between(degree(i), degree(next)));
                    mean = lag(mean, heat);
                    if round + 2 >= rounds {
                        let here = (truth[0].hypot(truth[1]), told, mean);
                        peaks = (peaks.0.max(here.0), peaks.1.max(here.1), peaks.2.max(here.2));
                    }
                }
            }
        }
        peaks
    }

    /// A motion of samples at equal distances with a torque of one, from its positions.
    fn motion(period: f64, count: usize, position: impl Fn(f64) -> f64, course: Course) -> Motion {
        driven(period, count, position, |_| 1.0, course)
    }

    /// A motion of samples at equal distances with a torque, from its positions.
    fn driven(
        period: f64,
        count: usize,
        position: impl Fn(f64) -> f64,
        torque: impl Fn(f64) -> f64,
        course: Course,
    ) -> Motion {
        let time: Vec<f64> = (0..count).map(|k| period * k as f64 / count as f64).collect();
        let position = time.iter().map(|t| position(*t)).collect();
        Motion::from_samples(
            Samples {
                torque: time.iter().map(|t| torque(*t)).collect(),
                time,
                position: Some(position),
                velocity: None,
                acceleration: None,
                torque_rate: None,
                jerk: None,
            },
            course,
        )
    }

    #[test]
    fn a_steady_crawl_has_the_degree_of_a_first_order_lag() {
        // 2 ω_e τ = κ v τ; whole turns of a joint, so that positions do not close.
        for (turned, lasts) in [(0.01, 100.0), (0.3, 100.0), (1.0, 100.0), (3.0, 1000.0), (8.0, 1000.0)] {
            let (kappa, tau) = (140.0, 20.0);
            let speed = turned / kappa / tau;
            let creep = motion(lasts, 400, |t| speed * t, Course::Once(lasts));
            let degrees = Sweep::new(&creep).degrees_at(kappa, tau);
            let lag = 1.0 / turned.hypot(1.0);
            // From cold the angle has to be swept first.
            for degree in &degrees[if turned > 0.2 { degrees.len() * 3 / 4 } else { 0 }..] {
                let degree = f64::from(*degree) / GRADES;
                let least = lag * ramp(lag, OF_MOTION) - 0.03;
                assert!((least..lag + 0.03).contains(&degree), "{turned}: {degree}, not {lag}");
            }
        }
    }

    #[test]
    fn a_hold_with_noise_heats_the_worst_phase_as_an_integration_shows() {
        let mut generator = Pcg64::seed_from_u64(21);
        let mut apart = [0.0_f64; 2];
        for _ in 0..12 {
            // A hold of 30 to 80 % of the period between quick moves, with noise of up to 0.8 rad of twice the electrical angle.
            let (period, kappa) = (generator.random_range(2.0..60.0), generator.random_range(40.0..600.0));
            let tau = generator.random_range(3.0..60.0);
            let (hold, noise) = (period * generator.random_range(0.3..0.8), generator.random_range(0.0..0.4) / kappa);
            let waves: Vec<[f64; 2]> =
                (0..5).map(|_| [generator.random_range(3.0..30.0), generator.random_range(0.0..6.0)]).collect();
            let shake = |t: f64| waves.iter().map(|[w, x]| noise / 5.0 * (w * t / hold + x).sin()).sum::<f64>();
            let way = |t: f64| {
                let s = ((t - hold) / (period - hold)).clamp(0.0, 1.0);
                shake(t) + 0.5 * (2.0 - 2.0 * (std::f64::consts::TAU * s).cos()) * (1.0 - 0.3 * s)
            };
            let held = motion(period, 1500, way, Course::Periodic(period));
            let (truth, told, mean) = excess(&held, kappa, tau);
            apart = [apart[0].max((truth - told) / mean), apart[1].max((told - truth) / mean)];
        }
        // Parts of the moves into and out of the hold stay near it and heat the same phase.
        assert!(apart[0] < 0.12 && apart[1] < 0.08, "{apart:?}");
    }

    #[test]
    fn dwells_with_a_shake_of_a_tenth_of_the_way_between_them_heat_as_an_integration_shows() {
        // Two dwells a turn of twice the electrical angle apart, so that the same phase is hot in both.
        let (kappa, tau, period) = (140.0, 20.0, 4.1);
        for shake in [0.1, 0.4, 0.8] {
            let way = |t: f64| {
                let s = ((t - 2.0) / 0.05).clamp(0.0, 1.0) - ((t - 4.05) / 0.05).clamp(0.0, 1.0);
                let blend = s * s * (3.0 - 2.0 * s);
                (std::f64::consts::TAU * blend + 0.5 * shake * (std::f64::consts::TAU * 30.0 * t / period).sin())
                    / kappa
            };
            let held = motion(period, 1640, way, Course::Periodic(period));
            let (truth, told, mean) = excess(&held, kappa, tau);
            assert!((told - truth).abs() < 0.05 * mean, "{shake}: {} not {}", told / mean, truth / mean);
        }
    }

    /// Random motions of holds, drifts, sways and moves, with torque that peaks anywhere, against the integration over the angle. The
    /// excess is too large where stays heat different phases.
    #[test]
    fn at_most_a_quarter_of_the_excess_at_standstill_is_left_out() {
        let mut generator = Pcg64::seed_from_u64(77);
        let (mut least, mut most, mut sum) = (0.0_f64, 0.0_f64, 0.0);
        let cases = 400;
        for _ in 0..cases {
            let period = 10.0_f64.powf(generator.random_range(-0.3..2.0));
            let (kappa, tau) = (generator.random_range(20.0..600.0), generator.random_range(3.0..60.0));
            let size = 10.0_f64.powf(generator.random_range(-0.5..2.5)) / kappa;
            let waves: Vec<[f64; 3]> = (1..5)
                .map(|k| [size * generator.random_range(0.0..1.0), f64::from(k), generator.random_range(0.0..6.0)])
                .collect();
            let flat = generator.random_range(-1.0..1.5_f64).max(0.0);
            let drift = size * generator.random_range(0.0..0.1);
            let way = |t: f64| {
                let turn = std::f64::consts::TAU * t / period;
                let all: f64 = waves.iter().map(|[a, w, x]| a * (w * turn + x).sin()).sum();
                all.signum() * (all.abs() - flat * size).max(0.0) + drift * turn.sin()
            };
            let sharp = generator.random_range(0..4);
            let shift = generator.random_range(0.0..6.0);
            let torque = |t: f64| 0.1 + (std::f64::consts::TAU * t / period + shift).cos().abs().powi(2 * sharp);
            let moved = driven(period, 1500, way, torque, Course::Periodic(period));
            let (truth, told, mean) = excess(&moved, kappa, tau);
            let apart = (told - truth) / mean;
            (least, most, sum) = (least.min(apart), most.max(apart), sum + apart);
        }
        let mean = sum / f64::from(cases);
        println!("{least} to {most}, on average {mean}");
        assert!(least > -0.25 && most < 0.6 && mean.abs() < 0.02, "{least} to {most}, on average {mean}");
    }

    /// Steps of an index table, forth and back, whose holds drift a little: the holds count whatever κ is.
    #[test]
    fn holds_of_an_index_table_count_as_they_do_at_rest() {
        for (steps, angle) in [(8, 0.785), (16, 0.785), (24, 0.785), (16, 0.0314)] {
            let period = 0.5 * 2.0 * f64::from(steps);
            let way = |t: f64| {
                let (k, s) = ((t / 0.5).floor(), (t / 0.5).fract());
                let hop = ((s - 0.8) / 0.2).clamp(0.0, 1.0);
                let up = k + hop * hop * (3.0 - 2.0 * hop);
                let turn = f64::from(steps) - (up - f64::from(steps)).abs();
                angle * turn + 1e-6 * (std::f64::consts::TAU * t / period).sin()
            };
            let moved = motion(period, 1600, way, Course::Periodic(period));
            for kappa in [100.0, 200.0, 777.0] {
                let sweep = Sweep::new(&moved);
                let step = (4.0 * f64::log2(kappa)).floor() as i32;
                let degrees = sweep.degrees(step, 20.0);
                let held: f64 = degrees.iter().zip(&moved.weight).map(|(d, w)| w * f64::from(*d) / GRADES).sum();
                assert!(held > 0.7, "{steps} steps of {angle} rad, κ {kappa}: {held}");
            }
        }
    }

    /// Torque or speed that goes with the angle of a wheel heats one phase at every turn of the field.
    #[test]
    fn torque_and_speed_in_step_with_the_field_heat_one_phase() {
        let (kappa, tau, turns, speed) = (200.0, 20.0, 3.0, 0.5);
        let period = std::f64::consts::TAU * turns / speed;
        let in_step = driven(period, 1900, |t| speed * t, |t| 1.0 + (kappa * speed * t).cos(), Course::Once(period));
        let (truth, told, mean) = excess(&in_step, kappa, tau);
        assert!(truth > 0.6 * mean && (told - truth).abs() < 0.2 * mean, "{} not {}", told / mean, truth / mean);
        // Position of v = v_0 (1 + 0.9 cos κ q): slow at the same angle of every turn.
        let mut way = vec![0.0_f64];
        for k in 0..40_000 {
            let q = way[k];
            way.push(q + 1e-3 * 0.3 * (1.0 + 0.9 * (kappa * q).cos()));
        }
        let at = |t: f64| way[((t * 1e3) as usize).min(way.len() - 1)] + (t * 1e3).fract() * 1e-9;
        let rippled = motion(20.0, 2500, at, Course::Once(20.0));
        let (truth, told, mean) = excess(&rippled, kappa, tau);
        assert!(truth > 0.4 * mean && told > truth - 0.2 * mean, "{} not {}", told / mean, truth / mean);
    }

    #[test]
    fn a_period_that_is_written_twice_has_the_degrees_of_one() {
        let mut generator = Pcg64::seed_from_u64(12);
        let mut counted = 0;
        for _ in 0..60 {
            let period = 10.0_f64.powf(generator.random_range(-0.3..1.5));
            let (kappa, tau) = (generator.random_range(20.0..600.0), generator.random_range(3.0..60.0));
            let size = 10.0_f64.powf(generator.random_range(0.0..1.7)) / kappa;
            let waves: Vec<[f64; 3]> = (1..5)
                .map(|k| [size * generator.random_range(0.0..1.0), f64::from(k), generator.random_range(0.0..6.0)])
                .collect();
            let turn = |t: f64| std::f64::consts::TAU * t / period;
            let way = |t: f64| waves.iter().map(|[a, w, x]| a * (w * turn(t) + x).sin()).sum::<f64>();
            let torque = |t: f64| 0.1 + turn(t).cos().abs().powi(2);
            let degrees = |times: usize| {
                let all = period * times as f64;
                Sweep::new(&driven(all, 200 * times, way, torque, Course::Periodic(all))).degrees_at(kappa, tau)
            };
            let (once, twice) = (degrees(1), degrees(2));
            assert_eq!(twice.len(), 2 * once.len());
            counted += usize::from(once.iter().any(|degree| *degree > 0));
            for (k, degree) in twice.iter().enumerate() {
                let expected = once[k % once.len()];
                assert!(degree.abs_diff(expected) <= 1, "{k}: {degree}, not {expected}");
            }
        }
        assert!(counted > 20, "{counted}");
    }

    #[test]
    fn turning_points_are_no_standstill_and_a_small_shake_is() {
        for (amplitude, stands) in [(0.5, false), (0.05, false), (1e-4, true)] {
            let swing = motion(1.0, 400, |t| amplitude * (std::f64::consts::TAU * t).sin(), Course::Periodic(1.0));
            let degrees = Sweep::new(&swing).degrees_at(280.0, 10.0);
            assert!(degrees.iter().all(|d| (*d > 60) == stands && (*d > 3) == stands), "{amplitude}: {degrees:?}");
        }
    }

    #[test]
    fn from_rest_to_motion_the_degree_falls_without_a_jump() {
        let mut before = GRADES;
        for k in 0..800 {
            let speed = 1e-9 * 1.03_f64.powi(k);
            let point = |duration| Point { torque: 1.0, velocity: speed, duration, ..Point::default() };
            let held = Sweep::new(&Motion::from_points(&[point(Some(3600.0))])).degrees_at(140.0, 20.0)[0];
            let untimed = Sweep::new(&Motion::from_points(&[point(None)])).degrees_at(140.0, 20.0)[0];
            assert_eq!(held, untimed, "at {speed} rad/s");
            let here = f64::from(held);
            assert!(here <= before && before - here <= 0.05 * GRADES, "at {speed} rad/s: {before} to {here}");
            before = here;
        }
        assert_eq!(before, 0.0);
    }

    /// Short operating points count by their speed: the degree falls from that at rest to zero.
    #[test]
    fn a_short_operating_point_counts_by_its_speed() {
        let degree = |speed: f64| {
            let point = Point { torque: 1.0, velocity: speed, duration: Some(0.09), ..Point::default() };
            let sweep = Sweep::new(&Motion::from_points(&[point]));
            let degree = sweep.degrees_at(140.0, 20.0)[0];
            assert!(degree == 0 || sweep.counts_below(20.0) >= 140.0, "at {speed} rad/s");
            degree
        };
        assert_eq!([1e-9, 1e-6, 1.0].map(degree), [64, 64, 0]);
        assert!((1..64).contains(&degree(1e-3)));
    }

    #[test]
    fn no_degree_rises_with_the_ratio_and_none_is_left_beyond_the_threshold() {
        let mut generator = Pcg64::seed_from_u64(5);
        for _ in 0..40 {
            let (period, tau) = (generator.random_range(0.3..90.0), generator.random_range(2.0..60.0));
            let size = 10.0_f64.powf(generator.random_range(-4.0..0.0));
            let waves: Vec<[f64; 3]> = (1..6)
                .map(|k| [size * generator.random_range(0.0..1.0), f64::from(k), generator.random_range(0.0..6.0)])
                .collect();
            let flat = generator.random_range(0.0..1.5);
            let way = |t: f64| {
                let all: f64 =
                    waves.iter().map(|[a, w, x]| a * (w * std::f64::consts::TAU * t / period + x).sin()).sum();
                all.signum() * (all.abs() - flat * size).max(0.0)
            };
            let sweep = Sweep::new(&motion(period, 150, way, Course::Periodic(period)));
            let mut before: Arc<[u8]> = vec![u8::MAX; 150].into();
            for step in -8..60 {
                let kappa = begin_of(step);
                let here = sweep.degrees(step, tau);
                assert!(here.iter().zip(&*before).all(|(here, before)| here <= before), "period {period}, κ {kappa}");
                let missed =
                    here.iter().zip(sweep.degrees_at(kappa, tau)).map(|(here, own)| own.saturating_sub(*here)).max();
                assert_eq!(missed, Some(0), "κ {kappa}");
                let any = here.iter().any(|d| *d > 0);
                assert!(!any || kappa < sweep.counts_below(tau), "κ {kappa} beyond {}", sweep.counts_below(tau));
                before = here;
            }
        }
    }
}
