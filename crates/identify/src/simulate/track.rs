//! A log made ready for simulation: what goes in, what position comes out, where it starts.

use std::ops::Range;

use super::machine::{Machine, Sample, State};
use crate::bench::{Controller, Law, volts_per_duty};
use crate::{Channel, Declared, Log, Use, signals};

/// Longest internal step \[s\].
const STEP: f64 = 5e-4;
/// Most internal steps between two samples.
const MOST_STEPS: usize = 400;
/// Share of the fastest time constant that a step may be.
const SHARE: f64 = 0.2;
/// A drive is off where its duty is zero this many samples in a row although its controller asks for more
/// than [`ASKED`].
const OFF_SAMPLES: usize = 20;
/// Duty that a controller asks for and a drive that is on would show.
const ASKED: f64 = 0.02;

/// What drives the machine.
#[derive(Debug, Clone)]
pub enum Input {
    /// Current \[A\] at each sample (force over the declared gain on a linear axis).
    Current(Vec<f64>),
    /// Duty cycle at each sample.
    Duty(Vec<f64>),
    /// Goal at each sample \[rad\], through `gain · (goal − position) − damping · speed` within ±limit.
    Goal {
        /// Goal \[rad\].
        goal: Vec<f64>,
        /// Duty per angle \[1/rad\], or current \[A/rad\].
        gain: f64,
        /// Duty per speed \[s/rad\], or current \[A·s/rad\].
        damping: f64,
        /// Largest duty, or current \[A\].
        limit: f64,
        /// Whether it is a duty cycle; else a current.
        is_duty: bool,
    },
}

impl Input {
    /// Whether it is a voltage at the terminals; else a current.
    pub fn is_voltage(&self) -> bool {
        match self {
            Input::Current(_) => false,
            Input::Duty(_) => true,
            Input::Goal { is_duty, .. } => *is_duty,
        }
    }
}

/// A log ready for simulation.
#[derive(Debug, Clone)]
pub struct Track {
    /// Its name.
    pub name: String,
    /// Whether it is for fitting.
    pub fits: bool,
    /// Time \[s\].
    pub time: Vec<f64>,
    /// Measured position at the output \[rad\]; missing samples are NaN and don't count.
    pub position: Vec<f64>,
    /// What drives it.
    pub input: Input,
    /// Whether that holds each sample's value until the next (a digital drive's command), or lies on a line between
    /// them (what an instrument read).
    pub held: bool,
    /// Supply voltage at each sample \[V\], and its part that reaches the q axis is `volts_per_duty` of it.
    pub supply: Vec<f64>,
    /// Quadrature voltage per volt of duty times supply.
    pub volts_per_duty: f64,
    /// Whether the drive is off at each sample; empty where it never is.
    pub off: Vec<bool>,
    /// Inertia of the load \[kg·m²\].
    pub load_inertia: f64,
    /// Gravity torque amplitude \[N·m\].
    pub load_gravity: f64,
    /// Winding and housing temperature over the reference at each sample \[K\]; empty where unknown.
    pub winding: Vec<f64>,
    /// Housing.
    pub housing: Vec<f64>,
    /// First samples of stretches between gaps and after what is left out, and the state there.
    pub starts: Vec<(usize, State)>,
}

/// Missing samples bridged: by the last value where it is held, else linearly, and held at the ends. `None` where fewer
/// than two are there.
fn bridged(time: &[f64], values: &[f64], held: bool) -> Option<Vec<f64>> {
    let known: Vec<usize> = (0..values.len()).filter(|k| values[*k].is_finite()).collect();
    if known.len() < 2 {
        return None;
    }
    let mut next = 0;
    Some(
        (0..values.len())
            .map(|k| {
                while next + 1 < known.len() && known[next + 1] <= k {
                    next += 1;
                }
                let (a, b) = (known[next], known[(next + 1).min(known.len() - 1)]);
                if k <= a || a == b || (held && k < b) {
                    return values[a];
                }
                values[a] + (values[b] - values[a]) * (time[k] - time[a]) / (time[b] - time[a])
            })
            .collect(),
    )
}

/// Windows for the speed at the start \[s\]: the shortest that tells it.
const WINDOWS: [f64; 3] = [0.01, 0.02, 0.05];

/// Position and speed at the start of a stretch: a parabola through the first samples; a speed within three
/// of its standard errors is zero.
fn start(time: &[f64], position: &[f64], speed: Option<f64>) -> State {
    let first = position.iter().copied().find(|p| p.is_finite()).unwrap_or(0.0);
    if let Some(speed) = speed.filter(|v| v.is_finite()) {
        return State { position: first, speed };
    }
    let mut best = 0.0;
    for window in WINDOWS {
        match parabola(time, position, window) {
            Some((speed, error)) if error < 0.02 * speed.abs() => return State { position: first, speed },
            Some((speed, error)) => best = if speed.abs() > 3.0 * error { speed } else { 0.0 },
            None => {}
        }
    }
    State { position: first, speed: best }
}

/// Speed at the first sample and its standard error, by a parabola through the samples of a window \[s\];
/// `None` where they are fewer than eight.
fn parabola(time: &[f64], position: &[f64], window: f64) -> Option<(f64, f64)> {
    let points: Vec<(f64, f64)> = time
        .iter()
        .zip(position)
        .take_while(|(t, _)| **t - time[0] <= window)
        .filter(|(_, p)| p.is_finite())
        .map(|(t, p)| ((t - time[0]) / window, *p))
        .collect();
    if points.len() < 8 {
        return None;
    }
    let design = nalgebra::DMatrix::from_fn(points.len(), 3, |r, c| points[r].0.powi(c as i32));
    let values = nalgebra::DVector::from_iterator(points.len(), points.iter().map(|p| p.1));
    let inverse = (design.transpose() * &design).try_inverse()?;
    let fit = &inverse * design.transpose() * &values;
    let left = (&values - &design * &fit).norm_squared() / (points.len() - 3) as f64;
    Some((fit[1] / window, (left * inverse[(1, 1)]).sqrt() / window))
}

/// A stretch in parts that begin after what is left out of it.
fn parts(stretch: Range<usize>, left_out: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut begins = vec![stretch.start];
    for end in left_out.iter().map(|r| r.end) {
        let is_covered = left_out.iter().any(|r| r.contains(&end));
        if stretch.contains(&end) && end > stretch.start && !is_covered {
            begins.push(end);
        }
    }
    begins.sort_unstable();
    begins.dedup();
    let ends = begins.iter().skip(1).copied().chain([stretch.end]);
    begins.iter().zip(ends).map(|(from, to)| *from..to).collect()
}

impl Track {
    /// A log as a track; `None` where it lacks a position or what drives it. A closed loop is simulated as
    /// one where controller and goal are there, otherwise the logged duty cycle or current goes in.
    pub fn new(log: &Log, declared: &Declared) -> Option<Track> {
        let linear = declared.motor.is_none();
        let time = log.time.clone();
        // The load of a joint of a robot follows from how all of them moved: it is not simulated alone.
        if time.len() < 3 || log.channel(Channel::LoadTorque).is_some() {
            return None;
        }
        let opened = |c: Channel| log.channel(c).map(|v| if linear { v.to_vec() } else { signals::unwrapped(v) });
        let ratio = declared.ratio;
        let mut position: Vec<f64> = opened(Channel::OutputPosition)
            .or_else(|| opened(Channel::MotorPosition).map(|p| p.iter().map(|v| v / ratio).collect()))?;
        let speed = log
            .channel(Channel::OutputVelocity)
            .map(<[f64]>::to_vec)
            .or_else(|| log.channel(Channel::MotorVelocity).map(|w| w.iter().map(|v| v / ratio).collect()));
        let is_held = |c: Channel| log.held.contains(&c);
        let get = |c: Channel| log.channel(c).and_then(|v| bridged(&time, v, is_held(c)));
        let declared_supply = log.controller.and_then(|c| c.supply);
        let supply = get(Channel::Supply).or_else(|| declared_supply.map(|v| vec![v; time.len()]));
        let duty = get(Channel::Duty);
        let goal = opened(Channel::Goal).and_then(|g| bridged(&time, &g, is_held(Channel::Goal)));
        let mut off = Vec::new();
        let (driven_by, input, supply) = if let Some(current) = get(Channel::Current) {
            (Channel::Current, Input::Current(current), Vec::new())
        } else if let (Some(c), Some(goal), true) = (log.controller.filter(|c| c.law == Law::Torque), &goal, !linear) {
            // The drive makes its torque by the declared constant, whatever the true one is.
            let per_torque = 1.0 / (ratio * declared.motor.as_ref()?.torque_constant);
            let [gain, damping, limit] = [c.gain, c.damping, c.limit].map(|v| per_torque * v);
            (Channel::Goal, Input::Goal { goal: goal.clone(), gain, damping, limit, is_duty: false }, Vec::new())
        } else if let (Some(c), Some(goal), Some(supply)) = (log.controller, &goal, &supply) {
            if let Some(duty) = log.channel(Channel::Duty) {
                let asked = |k: usize| (c.gain * (goal[k] - position[k])).abs() > ASKED;
                off = is_off(duty, asked);
            }
            let Controller { gain, damping, limit, .. } = c;
            let input = Input::Goal { goal: goal.clone(), gain, damping, limit, is_duty: true };
            (Channel::Goal, input, supply.clone())
        } else {
            (Channel::Duty, Input::Duty(duty?), supply?)
        };
        let reference =
            declared.motor.as_ref().map_or(gearwise_model::catalog::REFERENCE_TEMPERATURE, |m| m.reference_temperature);
        let rise = |c| get(c).map_or_else(Vec::new, |t| t.into_iter().map(|t| t - reference).collect::<Vec<f64>>());
        let winding = rise(Channel::WindingTemperature);
        let housing = Some(rise(Channel::HousingTemperature)).filter(|h| !h.is_empty()).unwrap_or(winding.clone());
        // What is left out judges nothing; after it the machine is where it was measured.
        let left_out: Vec<Range<usize>> = log.excluded_rows().filter(|r| !r.is_empty()).collect();
        left_out.iter().for_each(|r| position[r.clone()].fill(f64::NAN));
        let starts = signals::stretches(&time)
            .into_iter()
            .flat_map(|r| parts(r, &left_out))
            .map(|r| {
                let v = speed.as_ref().map(|v| v[r.start]);
                (r.start, start(&time[r.clone()], &position[r], v))
            })
            .collect();
        Some(Track {
            name: log.name.clone(),
            fits: log.usage == Use::Fit,
            time,
            position,
            input,
            held: is_held(driven_by),
            supply,
            volts_per_duty: declared.motor.as_ref().map_or(1.0, volts_per_duty),
            off,
            load_inertia: log.load.inertia.unwrap_or(0.0),
            load_gravity: log.load.gravity_torque.unwrap_or(0.0),
            winding,
            housing,
            starts,
        })
    }

    /// Whether voltages drive the machine of these tracks; where a torque is asked of its drive, currents do.
    pub fn are_of_voltage(all: &[Track]) -> bool {
        all.iter().any(|t| t.input.is_voltage())
    }

    /// The measured position with its missing samples bridged; nothing where there are fewer than two.
    pub fn path(&self) -> Vec<f64> {
        bridged(&self.time, &self.position, false).unwrap_or_default()
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// The simulated position at every sample \[rad\], from the measured state at the start and, after a
    /// gap, at its end.
    pub fn simulate(&self, machine: &Machine) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.len());
        let longest = STEP.min(SHARE / machine.fastest(self.load_inertia).max(1.0));
        for (index, (first, state)) in self.starts.iter().enumerate() {
            let end = self.starts.get(index + 1).map_or(self.len(), |s| s.0);
            self.stretch(machine, *first..end, *state, longest, &mut out);
        }
        out
    }

    fn stretch(&self, machine: &Machine, range: Range<usize>, start: State, longest: f64, out: &mut Vec<f64>) {
        let mut state = start;
        let mut delay = Delay::new(machine.lag);
        let last = |values: &Vec<f64>, k: usize| values.get(k).copied().unwrap_or(f64::NAN);
        let mut sample = Sample {
            input: 0.0,
            is_voltage: self.input.is_voltage(),
            is_open: false,
            duty: 0.0,
            load_inertia: self.load_inertia,
            load_gravity: self.load_gravity,
            winding_rise: 0.0,
            housing_rise: 0.0,
        };
        for k in range.clone() {
            out.push(state.position);
            if k + 1 == range.end {
                break;
            }
            let span = self.time[k + 1] - self.time[k];
            let steps = signals::covering(span / longest).clamp(1, MOST_STEPS);
            let h = span / steps as f64;
            sample.is_open = self.off.get(k).copied().unwrap_or(false);
            (sample.winding_rise, sample.housing_rise) = (last(&self.winding, k), last(&self.housing, k));
            for j in 0..steps {
                // Inputs at the middle of the step: as they are held, or linear between samples.
                let share = (j as f64 + 0.5) / steps as f64;
                let between = |values: &[f64]| values[k] + share * (values[k + 1] - values[k]);
                let told = |values: &[f64]| if self.held { values[k] } else { between(values) };
                let now = match &self.input {
                    Input::Current(values) | Input::Duty(values) => told(values),
                    Input::Goal { goal, gain, damping, limit, .. } => {
                        let position = state.position + 0.5 * h * state.speed;
                        (gain * (told(goal) - position) - damping * state.speed).clamp(-limit, *limit)
                    }
                };
                let delayed = delay.at(self.time[k] + share * span, now);
                if sample.is_voltage {
                    sample.duty = delayed;
                    sample.input = delayed * between(&self.supply) * self.volts_per_duty;
                } else {
                    sample.input = delayed;
                }
                state = machine.step(state, &sample, h);
            }
        }
    }

    /// Simulated less measured position; zero where none was measured.
    pub fn residual(&self, machine: &Machine) -> Vec<f64> {
        let mut simulated = self.simulate(machine);
        for (s, m) in simulated.iter_mut().zip(&self.position) {
            *s = if m.is_finite() { *s - m } else { 0.0 };
            // What diverges is wrong, but must stay a number.
            *s = if s.is_finite() { s.clamp(-1e6, 1e6) } else { 1e6 };
        }
        simulated
    }

    /// The track cut into equal parts, each of which starts from its measured state.
    pub fn parts(&self, count: usize) -> Vec<Track> {
        let cut = |range: std::ops::Range<usize>| {
            let of = |v: &Vec<f64>| if v.is_empty() { Vec::new() } else { v[range.clone()].to_vec() };
            let input = match &self.input {
                Input::Current(v) => Input::Current(of(v)),
                Input::Duty(v) => Input::Duty(of(v)),
                Input::Goal { goal, gain, damping, limit, is_duty } => {
                    Input::Goal { goal: of(goal), gain: *gain, damping: *damping, limit: *limit, is_duty: *is_duty }
                }
            };
            let (time, position) = (of(&self.time), of(&self.position));
            // Where the track began anew it still does; the part itself begins from what was measured there.
            let own = self.starts.iter().filter(|s| range.contains(&s.0));
            let mut starts: Vec<(usize, State)> = own.map(|(at, state)| (at - range.start, *state)).collect();
            let first = starts.first().map_or(time.len(), |s| s.0);
            if first > 0 {
                starts.insert(0, (0, start(&time[..first], &position[..first], None)));
            }
            Track {
                name: self.name.clone(),
                fits: self.fits,
                input,
                held: self.held,
                supply: of(&self.supply),
                volts_per_duty: self.volts_per_duty,
                off: if self.off.is_empty() { Vec::new() } else { self.off[range.clone()].to_vec() },
                load_inertia: self.load_inertia,
                load_gravity: self.load_gravity,
                winding: of(&self.winding),
                housing: of(&self.housing),
                starts,
                time,
                position,
            }
        };
        let each = self.len().div_ceil(count.max(1)).max(3);
        (0..self.len()).step_by(each).map(|k| cut(k..(k + each).min(self.len()))).filter(|t| t.len() >= 3).collect()
    }

    /// How many samples count.
    pub fn count(&self) -> usize {
        self.position.iter().filter(|p| p.is_finite()).count()
    }
}

/// Where a drive is off: long runs of zero although the controller asks for more.
fn is_off(duty: &[f64], asked: impl Fn(usize) -> bool) -> Vec<bool> {
    let mut off = vec![false; duty.len()];
    let mut start = 0;
    let mut any = false;
    while start < duty.len() {
        let end = (start..duty.len()).find(|k| duty[*k] != 0.0).unwrap_or(duty.len());
        let asking = (start..end).filter(|k| asked(*k)).count();
        if end - start >= OFF_SAMPLES && asking >= OFF_SAMPLES && 2 * asking > end - start {
            off[start..end].fill(true);
            any = true;
        }
        start = end + 1;
    }
    if any { off } else { Vec::new() }
}

/// A signal handed on late.
struct Delay {
    lag: f64,
    history: Vec<(f64, f64)>,
    next: usize,
}

impl Delay {
    fn new(lag: f64) -> Delay {
        Delay { lag, history: Vec::new(), next: 0 }
    }

    /// The value that was there `lag` before a time, given the value of now; before the first it is the
    /// first.
    fn at(&mut self, time: f64, value: f64) -> f64 {
        if self.lag <= 0.0 {
            return value;
        }
        self.history.push((time, value));
        let wanted = time - self.lag;
        while self.next + 1 < self.history.len() && self.history[self.next + 1].0 <= wanted {
            self.next += 1;
        }
        let (t, v) = self.history[self.next];
        match self.history.get(self.next + 1) {
            Some((t1, v1)) if wanted > t => v + (v1 - v) * (wanted - t) / (t1 - t),
            _ => v,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_begin_again_after_what_is_left_out() {
        let begins = |stretch: Range<usize>, left_out: &[(usize, usize)]| {
            let left_out: Vec<Range<usize>> = left_out.iter().map(|(from, to)| *from..*to).collect();
            let parts = parts(stretch.clone(), &left_out);
            assert_eq!(parts.last().map(|p| p.end), Some(stretch.end));
            assert!(parts.windows(2).all(|p| p[0].end == p[1].start));
            parts.iter().map(|p| p.start).collect::<Vec<usize>>()
        };
        assert_eq!(begins(0..100, &[]), [0]);
        assert_eq!(begins(0..100, &[(20, 30), (50, 60)]), [0, 30, 60]);
        // At either end, over each other, and in another stretch.
        assert_eq!(begins(0..100, &[(0, 10), (90, 100)]), [0, 10]);
        assert_eq!(begins(0..100, &[(20, 40), (30, 60)]), [0, 60]);
        assert_eq!(begins(200..300, &[(20, 30)]), [200]);
    }
}
