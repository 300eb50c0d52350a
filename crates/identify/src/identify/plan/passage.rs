//! Passages that a run is made of.
//!
//! The one idea: each passage begins and ends at rest, at the same place and without current. So passages may follow each
//! other in any order, what they say adds up, and limits that each of them keeps the whole run keeps.

use std::f64::consts::{PI, TAU};

/// How the shaft moves in a passage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Not at all.
    Rest,
    /// There and back, so many times, at a speed of the motor \[rad/s\]; ramps take this share of each stroke, twice.
    Strokes { speed: f64, times: u32, ramp: f64 },
    /// The speed is a sine of so many periods.
    Sine { speed: f64, times: u32 },
}

/// The current of a passage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// None.
    None,
    /// The same all the time \[A\].
    Constant(f64),
    /// One sign in the first half, the other in the second \[A\].
    Opposed(f64),
    /// So many pulses \[A\], together this share of the passage; in turn of the one sign and the other, or two of each.
    Pulses { current: f64, share: f64, count: u32, in_turn: bool },
    /// A sine of seven half periods \[A\].
    Sine(f64),
}

/// A passage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// How the shaft moves.
    pub motion: Motion,
    /// The current.
    pub load: Load,
}

/// An instant of a passage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Speed of the motor \[rad/s\].
    pub speed: f64,
    /// Its acceleration \[rad/s²\].
    pub acceleration: f64,
    /// Current \[A\].
    pub current: f64,
}

/// Share of a passage over which a current rises or falls.
const EDGE: f64 = 0.015;
/// A pulse is at least so many edges long, or it says little.
const PULSE: f64 = 3.0;

/// A cosine's half wave from zero to one, and its slope.
fn rise(x: f64) -> (f64, f64) {
    let x = x.clamp(0.0, 1.0);
    (0.5 - 0.5 * (PI * x).cos(), 0.5 * PI * (PI * x).sin())
}

/// One between two places, with edges of a width; zero outside.
fn plateau(x: f64, from: f64, to: f64, edge: f64) -> f64 {
    rise((x - from) / edge).0.min(rise((to - x) / edge).0)
}

impl Passage {
    /// At a share of its duration \[s\].
    pub fn at(&self, share: f64, duration: f64) -> Instant {
        let (speed, acceleration) = match self.motion {
            Motion::Rest => (0.0, 0.0),
            Motion::Strokes { speed, times, ramp } => {
                let at = (share * 2.0 * f64::from(times)).clamp(0.0, 2.0 * f64::from(times) - 1e-12);
                let (stroke, within) = (at.floor(), at.fract());
                let sign = if stroke % 2.0 == 0.0 { speed } else { -speed };
                let length = duration / (2.0 * f64::from(times));
                let (up, down) = (rise(within / ramp), rise((1.0 - within) / ramp));
                let slope = if within < ramp {
                    up.1
                } else if 1.0 - within < ramp {
                    -down.1
                } else {
                    0.0
                };
                (sign * up.0.min(down.0), sign * slope / (ramp * length))
            }
            Motion::Sine { speed, times } => {
                let turn = TAU * f64::from(times);
                (speed * (turn * share).sin(), speed * turn / duration * (turn * share).cos())
            }
        };
        let current = match self.load {
            Load::None => 0.0,
            Load::Constant(current) => current * plateau(share, 0.0, 1.0, EDGE),
            Load::Opposed(current) => current * (plateau(share, 0.0, 0.5, EDGE) - plateau(share, 0.5, 1.0, EDGE)),
            Load::Pulses { current, share: width, count, in_turn } => {
                let count = f64::from(count);
                let at = (share * count).clamp(0.0, count - 1e-12);
                // Two strokes with pulses in turn, and two without, have both signs in either direction.
                let signs = if in_turn { [1.0, -1.0, -1.0, 1.0] } else { [1.0, 1.0, -1.0, -1.0] };
                let (sign, half) = (signs[at.floor() as usize % 4], 0.5 * width);
                sign * current * plateau(at.fract(), 0.5 - half, 0.5 + half, count * EDGE)
            }
            Load::Sine(current) => current * (7.0 * PI * share).sin(),
        };
        Instant { speed, acceleration, current }
    }

    /// How far the motor goes from where it began, both ways together \[rad\].
    pub fn travel(&self, duration: f64) -> f64 {
        match self.motion {
            Motion::Rest => 0.0,
            Motion::Strokes { speed, times, ramp } => speed.abs() * (1.0 - ramp) * duration / (2.0 * f64::from(times)),
            Motion::Sine { speed, times } => speed.abs() * duration / (PI * f64::from(times)),
        }
    }

    /// The largest acceleration of the motor \[rad/s²\].
    pub fn acceleration(&self, duration: f64) -> f64 {
        match self.motion {
            Motion::Rest => 0.0,
            Motion::Strokes { speed, times, ramp } => {
                0.5 * PI * speed.abs() * 2.0 * f64::from(times) / (ramp * duration)
            }
            Motion::Sine { speed, times } => speed.abs() * TAU * f64::from(times) / duration,
        }
    }
}

/// The largest values that passages may have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Speed of the motor \[rad/s\].
    pub speed: f64,
    /// Slowest speed that the bench can tell from rest \[rad/s\].
    pub slowest: f64,
    /// Acceleration of the motor \[rad/s²\].
    pub acceleration: f64,
    /// Travel of the motor \[rad\].
    pub travel: f64,
    /// Current \[A\]; zero where none is commanded.
    pub current: f64,
    /// Its root mean square over a passage \[A\].
    pub heating: f64,
}

/// Shares of the largest speed, each largest first.
const SPEEDS: [f64; 6] = [1.0, 0.6, 0.3, 0.15, 0.07, 0.03];
/// Strokes, with their ramps, and periods of a sine.
const STROKES: [(u32, f64); 3] = [(1, 0.12), (2, 0.5), (6, 0.4)];
const SINES: [u32; 2] = [1, 4];

/// All passages of a duration \[s\] within bounds. `moves` and `loads` say what the bench is told.
pub fn passages(bounds: &Bounds, duration: f64, moves: bool, loads: bool) -> Vec<Passage> {
    let mut motions = vec![Motion::Rest];
    if moves {
        motions.clear();
        let slowest = bounds.slowest;
        let fast = |share: &f64| share * bounds.speed;
        for speed in SPEEDS.iter().map(fast).filter(|speed| *speed >= slowest) {
            motions.extend(STROKES.iter().map(|(times, ramp)| Motion::Strokes { speed, times: *times, ramp: *ramp }));
            motions.extend(SINES.iter().map(|times| Motion::Sine { speed, times: *times }));
        }
        if loads {
            motions.push(Motion::Rest);
        }
    }
    let mut currents = vec![Load::None];
    if loads {
        let steady = bounds.heating.min(bounds.current);
        currents.extend([Load::Constant(0.97 * steady), Load::Opposed(0.97 * steady)]);
        currents.push(Load::Sine((2.0_f64.sqrt() * 0.97 * bounds.heating).min(bounds.current)));
        // Two pulses at least.
        let shortest = 2.0 * PULSE * EDGE;
        let largest = bounds.current.min(bounds.heating / shortest.sqrt());
        for current in [0.99 * largest, 0.6 * largest] {
            let share = (bounds.heating / current).powi(2).min(0.6);
            let count = [8, 4, 2].into_iter().find(|count| f64::from(*count) * PULSE * EDGE <= share * (1.0 + 1e-9));
            currents.extend(
                count
                    .into_iter()
                    .flat_map(|count| [true, false].map(|in_turn| Load::Pulses { current, share, count, in_turn })),
            );
        }
    }
    let within = |p: &Passage| {
        p.travel(duration) <= bounds.travel * (1.0 + 1e-9)
            && p.acceleration(duration) <= bounds.acceleration * (1.0 + 1e-9)
    };
    let both = motions.iter().flat_map(|motion| currents.iter().map(|load| Passage { motion: *motion, load: *load }));
    both.filter(|p| (p.motion != Motion::Rest || p.load != Load::None) && within(p)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const BOUNDS: Bounds =
        Bounds { speed: 100.0, slowest: 4.0, acceleration: 800.0, travel: 120.0, current: 12.0, heating: 5.0 };

    /// Each passage comes back to where it began, at rest, and its closed forms are those of its course.
    #[test]
    fn passages_return_and_keep_their_bounds() {
        let all = passages(&BOUNDS, 3.0, true, true);
        assert!(all.len() > 40);
        for passage in &all {
            let n = 6000;
            let step = 3.0 / f64::from(n);
            let (mut angle, mut low, mut high, mut heat) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0);
            let (mut fastest, mut steepest, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
            let mut last = passage.at(0.0, 3.0);
            assert!(last.speed.abs() < 1e-9 && last.current.abs() < 1e-9, "{passage:?} begins {last:?}");
            for k in 1..=n {
                let now = passage.at(f64::from(k) / f64::from(n), 3.0);
                angle += 0.5 * step * (last.speed + now.speed);
                assert!((now.speed - last.speed - 0.5 * step * (now.acceleration + last.acceleration)).abs() < 0.02);
                (low, high) = (low.min(angle), high.max(angle));
                heat += step * now.current * now.current / 3.0;
                fastest = fastest.max(now.speed.abs());
                steepest = steepest.max(now.acceleration.abs());
                largest = largest.max(now.current.abs());
                last = now;
            }
            assert!(
                last.speed.abs() < 1e-6 && last.current.abs() < 1e-6 && angle.abs() < 1e-3,
                "{passage:?} ends {last:?} {angle}"
            );
            assert!(fastest <= 100.0 && steepest <= 801.0 && high - low <= 120.1, "{passage:?}");
            assert!(largest <= 12.0 && heat.sqrt() <= 5.0, "{passage:?} {largest} {}", heat.sqrt());
            assert_relative_eq!(passage.travel(3.0), high - low, max_relative = 2e-3, epsilon = 1e-6);
            assert_relative_eq!(passage.acceleration(3.0), steepest, max_relative = 2e-3, epsilon = 1e-6);
        }
    }

    /// What the bench is not told is not planned, and what it cannot tell from rest neither.
    #[test]
    fn a_bench_is_told_what_drives_it() {
        assert!(passages(&BOUNDS, 3.0, true, false).iter().all(|p| p.load == Load::None && p.motion != Motion::Rest));
        assert!(passages(&BOUNDS, 3.0, false, true).iter().all(|p| p.motion == Motion::Rest && p.load != Load::None));
        let slow = Bounds { slowest: 30.0, ..BOUNDS };
        let speed = |p: &Passage| match p.motion {
            Motion::Rest => 100.0,
            Motion::Strokes { speed, .. } | Motion::Sine { speed, .. } => speed,
        };
        assert!(passages(&slow, 3.0, true, false).iter().all(|p| speed(p) >= 30.0));
    }
}
