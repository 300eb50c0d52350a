//! Every instant of a motion, not its samples alone.
//!
//! The one idea: where the rates of a motion are those of its spline, the spline is the motion, and it is known
//! between the samples too. It is cut where torque or speed changes its sign, with an instant on either side of
//! each cut, so that efficiency and friction flip there and not at the next sample. What is left is divided until
//! everything that limits and means are made of is a straight line from instant to instant, to `RESOLUTION` of its
//! largest value. All that is done once, at reading; whatever comes after sees samples.
//!
//! Where the rates are given, what lies between the samples is not declared. There the motion stays as it is, and
//! an estimate (`likely`) tells how much larger it is than at any sample.
//!
//! What stands at two neighbouring samples stands between them, whatever rates these have: they are those of the motion
//! beside the hold. So a hold gets an instant at either end that has none of them.

use super::{Course, Motion};
use crate::numerics::cubic::Cubic;
use crate::numerics::spline;

/// What a straight line between two instants may miss, as a share of the largest value.
pub(crate) const RESOLUTION: f64 = 1e-3;
/// Share by which a motion that gives its rates may be larger between its samples without a word: margins are read in
/// whole percent.
pub(crate) const WORTH_A_WORD: f64 = 5e-3;
/// Instants that are put in at most, beside those at changes of sign, for a number of samples: a motion of noise has no
/// finest part.
fn most(samples: usize) -> usize {
    (4 * samples).clamp(5_000, 20_000).max(samples / 2)
}

/// From a change of sign to the instants beside it \[s\], of `samples` over a duration: a millionth of the way from
/// sample to sample, but more than what makes two instants one (`robot/power.rs`) and what rounding leaves of times.
fn apart(duration: f64, samples: usize, latest: f64) -> f64 {
    (1e-6 * duration / samples as f64).max(2e-9 * duration).max(8.0 * f64::EPSILON * latest)
}

/// What the largest product of two quantities is at least taken for, as a share of the product of their largest.
const LEAST_PRODUCT: f64 = 0.1;

/// What is known of a motion between its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Between {
    /// Operating points: nothing lies between.
    Nothing,
    /// The spline, resolved: what a straight line between two samples misses, as a share of the largest value.
    Spline(f64),
    /// Rates are given, so that the spline is not declared. Estimate of the share by which torque, speed or
    /// acceleration are larger somewhere than at every sample.
    Given(f64),
}

impl Between {
    /// The share that is missed between the samples, where it is worth a word.
    pub fn unresolved(self) -> Option<f64> {
        match self {
            Between::Nothing => None,
            Between::Spline(share) => (share > RESOLUTION).then_some(share),
            Between::Given(share) => (share > WORTH_A_WORD).then_some(share),
        }
    }
}

/// From one sample to the next.
pub(super) struct Interval {
    start: f64,
    length: f64,
    torque: Cubic,
    velocity: Cubic,
    position: Option<Cubic>,
    /// At rest from end to end.
    stands: bool,
    /// Whether the speed is exactly zero at the ends.
    rests: [bool; 2],
}

/// Torque, torque rate, speed, acceleration, jerk and position of one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Instant {
    pub(crate) torque: f64,
    pub(crate) torque_rate: f64,
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) position: Option<f64>,
}

impl Interval {
    /// How long it is \[s\].
    pub(super) fn end(&self) -> f64 {
        self.length
    }

    pub(super) fn at(&self, s: f64) -> Instant {
        let moves = if self.stands { 0.0 } else { 1.0 };
        Instant {
            torque: self.torque.at(s),
            torque_rate: self.torque.slope(s),
            velocity: moves * self.velocity.at(s),
            acceleration: moves * self.velocity.slope(s),
            jerk: moves * self.velocity.bend(s),
            position: self.position.map(|q| q.at(s)),
        }
    }

    /// Its ends, and between them both sides of every change of sign.
    pub(super) fn cuts(&self, largest: &Largest, apart: f64) -> Vec<f64> {
        let mut zeros = Vec::new();
        if !self.stands {
            zeros.extend([(self.rests[0], 0.0), (self.rests[1], self.length)].iter().filter(|e| e.0).map(|e| e.1));
            zeros.extend(self.velocity.zeros(self.length));
        }
        // A torque that is nothing has a sign by rounding only.
        if self.torque.largest(self.length) > RESOLUTION * largest.torque {
            zeros.extend(self.torque.zeros(self.length));
        }
        zeros.sort_by(f64::total_cmp);
        let mut sides: Vec<f64> = zeros.into_iter().flat_map(|zero| [zero - apart, zero + apart]).collect();
        if self.holds_beside_a_motion() {
            sides.extend([apart, self.length - apart]);
            sides.sort_by(f64::total_cmp);
        }
        let mut cuts = vec![0.0];
        for side in sides {
            if side - cuts[cuts.len() - 1] >= 0.5 * apart && self.length - side >= 0.5 * apart {
                cuts.push(side);
            }
        }
        cuts.push(self.length);
        cuts
    }

    /// Whether nothing moves, but one of the ends has the acceleration of what it does beyond.
    fn holds_beside_a_motion(&self) -> bool {
        self.stands && [0.0, self.length].iter().any(|s| self.velocity.slope(*s) != 0.0)
    }

    /// The largest second derivative of what limits and means are made of, each as a share of its largest value
    /// \[1/s²\]. A straight line over a time w misses at most w²/8 of it.
    pub(super) fn bend(&self, largest: &Largest) -> f64 {
        let h = self.length;
        let ends = |cubic: &Cubic| cubic.bend(0.0).abs().max(cubic.bend(h).abs());
        let [t, t1, t2] = [self.torque.largest(h), self.torque.derivative().largest(h), ends(&self.torque)];
        let t3 = self.torque.third().abs();
        let moves = if self.stands { 0.0 } else { 1.0 };
        let [v, a] = [&self.velocity, &self.velocity.derivative()].map(|cubic| moves * cubic.largest(h));
        let (j, k) = (moves * ends(&self.velocity), moves * self.velocity.third().abs());
        let position = if self.position.is_some() { largest.position } else { 0.0 };
        let bends = [
            (t2, largest.torque),
            (t3, largest.torque_rate),
            (j, largest.velocity),
            (k, largest.acceleration),
            (a, position),
            (t2 * v + 2.0 * t1 * a + t * j, largest.power),
            (3.0 * j * a + v * k, largest.inertial),
            (2.0 * (t1 * t1 + t * t2), largest.torque * largest.torque),
            (t2 * a + 2.0 * t1 * j + t * k, largest.torque * largest.acceleration),
            (2.0 * (j * j + a * k), largest.acceleration * largest.acceleration),
        ];
        bends.into_iter().filter(|(_, whole)| *whole > 0.0).map(|(bend, whole)| bend / whole).fold(0.0, f64::max)
    }
}

/// The largest values over the samples.
pub(super) struct Largest {
    pub(super) torque: f64,
    pub(super) torque_rate: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// Half of the range.
    position: f64,
    /// τ ω.
    pub(super) power: f64,
    /// α ω.
    pub(super) inertial: f64,
}

impl Largest {
    pub(super) fn new(motion: &Motion) -> Largest {
        let of = |values: &[f64]| values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let (torque, velocity, acceleration) = (of(&motion.torque), of(&motion.velocity), of(&motion.acceleration));
        let product = |a: &[f64], b: &[f64], least: f64| {
            a.iter().zip(b).map(|(a, b)| (a * b).abs()).fold(LEAST_PRODUCT * least, f64::max)
        };
        let range = |q: &Vec<f64>| {
            let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
            0.5 * (high - low)
        };
        Largest {
            torque,
            torque_rate: of(&motion.torque_rate),
            velocity,
            acceleration,
            position: motion.position.as_ref().map_or(0.0, range),
            power: product(&motion.torque, &motion.velocity, torque * velocity),
            inertial: product(&motion.acceleration, &motion.velocity, acceleration * velocity),
        }
    }
}

/// How long from sample `i` to the next, around the end of a period too.
fn length(motion: &Motion, i: usize) -> f64 {
    let (n, time) = (motion.len(), &motion.time);
    match motion.course {
        Course::Periodic(period) if i + 1 == n => period - (time[n - 1] - time[0]),
        _ => time[i + 1] - time[i],
    }
}

pub(super) fn intervals(motion: &Motion) -> Vec<Interval> {
    let n = motion.len();
    let count = if matches!(motion.course, Course::Periodic(_)) { n } else { n - 1 };
    let interval = |i: usize| {
        let (next, h) = ((i + 1) % n, length(motion, i));
        let of =
            |values: &[f64], slopes: &[f64]| Cubic::between(h, [values[i], slopes[i]], [values[next], slopes[next]]);
        let velocity = of(&motion.velocity, &motion.acceleration);
        let rests = [i, next].map(|k| motion.velocity[k] == 0.0);
        let position = motion.position.as_ref().map(|q| {
            // Around the end of a period a wheel goes on.
            let way = h
                * (0.5 * (motion.velocity[i] + motion.velocity[next])
                    + h / 12.0 * (motion.acceleration[i] - motion.acceleration[next]));
            let goes_on = next == 0 && (q[0] - q[i] - way).abs() > 0.1 * way.abs();
            let end = if goes_on { q[i] + way } else { q[next] };
            Cubic::between(h, [q[i], motion.velocity[i]], [end, motion.velocity[next]])
        });
        Interval {
            start: motion.time[i],
            length: h,
            torque: of(&motion.torque, &motion.torque_rate),
            velocity,
            position,
            stands: rests == [true; 2],
            rests,
        }
    };
    (0..count).map(interval).collect()
}

/// The largest of increasing times, by magnitude \[s\].
fn latest(time: &[f64]) -> f64 {
    [time[0], time[time.len() - 1]].into_iter().fold(0.0, |a, t| t.abs().max(a))
}

/// A part of an interval without a change of sign.
pub(super) struct Piece {
    pub(super) interval: usize,
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) bend: f64,
}

impl Piece {
    /// Into how many equal parts it is divided: one, or an even number, as Simpson's rule asks.
    fn parts(&self, resolution: f64) -> usize {
        let parts = ((self.to - self.from) * (self.bend / (8.0 * resolution)).sqrt()).ceil() as usize;
        if parts <= 1 { 1 } else { parts + parts % 2 }
    }
}

/// A motion whose rates are given, with the instants that part its holds from what it does beside them.
pub(super) fn with_holds(motion: Motion) -> Motion {
    let intervals = intervals(&motion);
    if !intervals.iter().any(Interval::holds_beside_a_motion) {
        return motion;
    }
    let apart = apart_of(&motion);
    let mut pieces = Vec::new();
    for (i, interval) in intervals.iter().enumerate() {
        let mut cuts = vec![0.0, interval.length];
        if interval.holds_beside_a_motion() && interval.length > 3.0 * apart {
            cuts.splice(1..1, [apart, interval.length - apart]);
        }
        pieces.extend(cuts.windows(2).map(|w| Piece { interval: i, from: w[0], to: w[1], bend: 0.0 }));
    }
    built(&motion, &intervals, &pieces, RESOLUTION, motion.between)
}

/// The same motion with the instants between its samples that it takes.
pub(super) fn resolve(motion: Motion) -> Motion {
    let largest = Largest::new(&motion);
    let intervals = intervals(&motion);
    let apart = apart_of(&motion);
    let mut pieces = Vec::with_capacity(intervals.len());
    for (i, interval) in intervals.iter().enumerate() {
        let bend = interval.bend(&largest);
        let cuts = interval.cuts(&largest, apart);
        pieces.extend(cuts.windows(2).map(|w| Piece { interval: i, from: w[0], to: w[1], bend }));
    }
    resolve_pieces(&motion, &intervals, &pieces)
}

/// From a change of sign to the instants beside it \[s\].
pub(super) fn apart_of(motion: &Motion) -> f64 {
    apart(motion.duration().unwrap_or(1.0), motion.len(), latest(&motion.time))
}

/// A motion of given samples with the instants that its pieces take, as fine as that many may be.
pub(super) fn resolve_pieces(motion: &Motion, intervals: &[Interval], pieces: &[Piece]) -> Motion {
    let most = most(motion.len()) + pieces.len();
    let mut resolution = RESOLUTION;
    while pieces.iter().map(|p| p.parts(resolution)).sum::<usize>() > most {
        resolution *= 2.0;
    }
    built(motion, intervals, pieces, resolution, Between::Spline(resolution))
}

/// A motion of the parts of its pieces.
fn built(motion: &Motion, intervals: &[Interval], pieces: &[Piece], resolution: f64, between: Between) -> Motion {
    let mut built = Motion { between, ..emptied(motion) };
    for piece in pieces {
        built.add_piece(motion, &intervals[piece.interval], piece, piece.parts(resolution));
    }
    if !matches!(motion.course, Course::Periodic(_)) {
        built.add_given(motion, motion.len() - 1);
    }
    built.weigh(pieces, intervals, resolution);
    built
}

/// A motion without samples, otherwise the same.
fn emptied(motion: &Motion) -> Motion {
    Motion {
        course: motion.course,
        repeat_every: motion.repeat_every,
        time: Vec::new(),
        torque: Vec::new(),
        velocity: Vec::new(),
        acceleration: Vec::new(),
        torque_rate: Vec::new(),
        jerk: Vec::new(),
        weight: Vec::new(),
        dwell: Vec::new(),
        position: motion.position.as_ref().map(|_| Vec::new()),
        placed: motion.placed,
        derived: motion.derived.clone(),
        given: Vec::new(),
        between: motion.between,
        held: motion.held,
        cases: None,
        sprung: motion.sprung,
        looked: None,
        mixed: false,
    }
}

impl Motion {
    fn add_given(&mut self, motion: &Motion, k: usize) {
        self.given.push(self.time.len());
        let instant = Instant {
            torque: motion.torque[k],
            torque_rate: motion.torque_rate[k],
            velocity: motion.velocity[k],
            acceleration: motion.acceleration[k],
            jerk: motion.jerk[k],
            position: motion.position.as_ref().map(|q| q[k]),
        };
        self.add(motion.time[k], &instant);
    }

    fn add(&mut self, time: f64, instant: &Instant) {
        self.time.push(time);
        self.torque.push(instant.torque);
        self.torque_rate.push(instant.torque_rate);
        self.velocity.push(instant.velocity);
        self.acceleration.push(instant.acceleration);
        self.jerk.push(instant.jerk);
        if let (Some(all), Some(q)) = (&mut self.position, instant.position) {
            all.push(q);
        }
    }

    /// A piece without its end.
    fn add_piece(&mut self, motion: &Motion, interval: &Interval, piece: &Piece, parts: usize) {
        for part in 0..parts {
            if part == 0 && piece.from == 0.0 {
                self.add_given(motion, piece.interval);
                continue;
            }
            let s = piece.from + (piece.to - piece.from) * part as f64 / parts as f64;
            self.add(interval.start + s, &interval.at(s));
        }
    }

    /// Shares of the time: Simpson's rule over a piece that is divided, the trapezoid rule over one that is not.
    fn weigh(&mut self, pieces: &[Piece], intervals: &[Interval], resolution: f64) {
        let n = self.time.len();
        (self.weight, self.dwell) = (vec![0.0; n], vec![0.0; n]);
        let total = self.duration().unwrap_or(1.0);
        let mut first = 0;
        for piece in pieces {
            let parts = piece.parts(resolution);
            let step = (piece.to - piece.from) / parts as f64 / total;
            for part in 0..=parts {
                let share = match part {
                    _ if parts == 1 => 0.5 * step,
                    _ if part == 0 || part == parts => step / 3.0,
                    _ if part % 2 == 1 => 4.0 * step / 3.0,
                    _ => 2.0 * step / 3.0,
                };
                let k = (first + part) % n;
                self.weight[k] += share;
                if intervals[piece.interval].stands {
                    self.dwell[k] += share;
                }
            }
            first += parts;
        }
    }

    /// A quantity that is known at the given samples, and its rate, at every sample: by its own spline.
    pub fn at_every_sample(&self, values: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let n = self.given.len();
        let time: Vec<f64> = self.given.iter().map(|k| self.time[*k]).collect();
        let rates = match self.course {
            Course::Periodic(period) => spline::periodic(&time, values, period).first,
            _ => spline::open(&time, values).first,
        };
        let at = |k: usize| {
            let i = self.given.partition_point(|g| *g <= k) - 1;
            if self.given[i] == k {
                return (values[i], rates[i]);
            }
            let next = (i + 1) % n;
            let h = match self.course {
                Course::Periodic(period) if next == 0 => period - (time[i] - time[0]),
                _ => time[next] - time[i],
            };
            let cubic = Cubic::between(h, [values[i], rates[i]], [values[next], rates[next]]);
            let s = self.time[k] - time[i];
            (cubic.at(s), cubic.slope(s))
        };
        (0..self.len()).map(at).unzip()
    }

    /// The given sample, counted from zero in its case, that sample k is; or is but for standing on one side of its change
    /// of sign. `None` for an instant between two of them.
    pub fn given_sample(&self, k: usize) -> Option<usize> {
        let (course, given, samples) = match self.case_of(k) {
            Some(case) => (case.course, &self.given[case.given.clone()], case.samples.clone()),
            None => (self.course, self.given.as_slice(), 0..self.len()),
        };
        let (Course::Periodic(duration) | Course::Once(duration)) = course else { return Some(k - samples.start) };
        let (i, time) = (given.partition_point(|g| *g <= k) - 1, &self.time);
        let latest = latest(&time[samples.clone()]);
        let near = |at: f64| (time[k] - at).abs() <= 2.0 * apart(duration, given.len(), latest);
        match given.get(i + 1) {
            _ if given[i] == k || near(time[given[i]]) => Some(i),
            Some(next) => near(time[*next]).then_some(i + 1),
            None => near(time[samples.start] + duration).then_some(0),
        }
    }
}

/// Estimate of the share by which torque, speed or acceleration are larger between the samples than at any of them,
/// by the cubics through values and given rates; and the torque that the motor drives at a change of direction.
pub(super) fn likely(motion: &Motion) -> f64 {
    let intervals = intervals(motion);
    let n = motion.len();
    let over = |values: &[f64], most: f64| {
        let seen = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        if seen > 0.0 { most / seen - 1.0 } else { 0.0 }
    };
    let most = |of: &dyn Fn(usize, &Interval) -> f64| {
        intervals.iter().enumerate().map(|(i, interval)| of(i, interval)).fold(0.0, f64::max)
    };
    let torque = most(&|_, x| x.torque.largest(x.length));
    let velocity = most(&|_, x| if x.stands { 0.0 } else { x.velocity.largest(x.length) });
    let acceleration = most(&|i, x| {
        let next = (i + 1) % n;
        let ends = [i, next].map(|k| [motion.acceleration[k], motion.jerk[k]]);
        if x.stands { 0.0 } else { Cubic::between(x.length, ends[0], ends[1]).largest(x.length) }
    });
    let driving: Vec<f64> =
        (0..n).filter(|k| motion.torque[*k] * motion.velocity[*k] >= 0.0).map(|k| motion.torque[k]).collect();
    let turning = most(&|_, x| {
        let zeros = if x.stands { Vec::new() } else { x.velocity.zeros(x.length) };
        zeros.into_iter().map(|s| x.torque.at(s).abs()).fold(0.0, f64::max)
    });
    let shares = [
        over(&motion.torque, torque),
        over(&motion.velocity, velocity),
        over(&motion.acceleration, acceleration),
        over(&driving, turning),
    ];
    shares.into_iter().fold(0.0, f64::max)
}
