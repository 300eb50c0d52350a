//! A machine with unknowns: which of its numbers are looked for, in which bounds, and how well the
//! simulation then follows the logs.

use super::machine::{Machine, Term};
use super::track::{Input, Track};
use crate::answer::Base;
use crate::{Declared, signals};
use gearwise_model::effects::{Effect, Equation, Named, Operating, Scale, Shape};
use gearwise_model::numerics::least_squares::{Fitted, Unknown, derivatives, minimise, residuals};

/// The longest lag that is looked for \[s\].
pub(super) const LONGEST_LAG: f64 = 0.05;

/// A number of the machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Slot {
    /// K_T, the resistance held: K_T/R of a duty-driven machine.
    TorqueConstant,
    Damping,
    Inertia,
    Lag,
    /// A value of a term.
    Value(usize, usize),
}

/// A machine with unknowns.
#[derive(Debug, Clone)]
pub(super) struct Model {
    pub machine: Machine,
    pub slots: Vec<Slot>,
    pub scale: Scale,
}

/// The machine as declared.
pub(super) fn declared_machine(declared: &Declared, is_voltage: bool) -> Machine {
    let terms = declared
        .all_effects()
        .into_iter()
        .filter(|e| e.effect.acts_on() != Equation::Angle)
        .map(|e| Term::new(e.effect, e.values))
        .collect();
    let mut machine = Machine {
        ratio: declared.ratio,
        torque_constant: declared.force_gain,
        resistance: f64::NAN,
        back_emf: 0.0,
        damping: 0.0,
        inertia: declared.mass.unwrap_or(0.0),
        lag: 0.0,
        terms,
    };
    if let Some(motor) = &declared.motor {
        machine.torque_constant = motor.torque_constant;
        machine.resistance = motor.resistance;
        machine.back_emf = motor.back_emf_constant;
        machine.inertia = motor.rotor_inertia.unwrap_or(0.0) + declared.gear.inertia;
        if is_voltage {
            machine.damping = motor.torque_constant * motor.back_emf_constant / motor.resistance;
        }
    }
    machine
}

/// Largest values on the bench, at the motor.
pub(super) fn scale(tracks: &[Track], machine: &Machine) -> Scale {
    let n = machine.ratio;
    let mut speeds = Vec::new();
    let (mut inputs, mut torques) = (Vec::new(), Vec::new());
    for t in tracks {
        let step = signals::median_step(&t.time).max(f64::MIN_POSITIVE);
        // Over some samples, so that the encoder's steps are no speed.
        let over = signals::covering(0.02 / step);
        let path = t.path();
        speeds
            .extend((over..path.len()).map(|k| n * (path[k] - path[k - over]).abs() / (t.time[k] - t.time[k - over])));
        match &t.input {
            Input::Current(i) => inputs.extend(i.iter().map(|i| i.abs())),
            Input::Duty(d) => inputs.extend(d.iter().zip(&t.supply).map(|(d, v)| (d * v).abs())),
            Input::Goal { goal, gain, limit, is_duty, .. } => {
                let per = |k: usize| if *is_duty { t.supply[k] } else { 1.0 };
                inputs.extend((0..path.len()).map(|k| (gain * (goal[k] - path[k])).abs().min(*limit) * per(k)))
            }
        }
        torques.push(t.load_gravity / n);
    }
    let is_voltage = Track::are_of_voltage(tracks);
    let input = signals::quantile(inputs, 0.995).unwrap_or(0.0);
    let current = if is_voltage { input / machine.resistance } else { input };
    let torque = torques.into_iter().fold(machine.torque_constant * current, f64::max);
    Scale {
        torque_constant: machine.torque_constant,
        resistance: machine.resistance,
        torque: torque.max(f64::MIN_POSITIVE),
        speed: signals::quantile(speeds, 0.995).unwrap_or(0.0).max(f64::MIN_POSITIVE),
        current,
        voltage: if is_voltage { input } else { f64::NAN },
    }
}

/// What a linear value of an effect is measured in: a tenth of the largest torque, or voltage.
fn size(effect: &dyn Effect, index: usize, shape: f64, scale: &Scale) -> f64 {
    // What depends on a speed is largest about there.
    let speed = if matches!(effect.shape(), Shape::Speed(_)) { shape } else { 0.5 * scale.speed };
    let at = Operating {
        speed,
        direction: 1.0,
        angle: 0.7,
        output_angle: 0.8,
        current: 0.5 * scale.current,
        torque: 0.5 * scale.torque,
        torque_curvature: 0.0,
        winding_rise: 20.0,
        housing_rise: 20.0,
        duty: 0.5,
    };
    let whole = if effect.acts_on() == Equation::Voltage { scale.voltage } else { scale.torque };
    0.1 * whole / effect.basis(shape, &at)[index].abs().max(1e-3)
}

/// Bounds of a linear value: on one side of zero where the other is not plausible.
fn bounds(effect: &dyn Effect, values: &[f64], index: usize, size: f64, scale: &Scale) -> (f64, f64) {
    let mut probe = values.to_vec();
    let mut fails = |v: f64| {
        probe[index] = v;
        for (j, p) in probe.iter_mut().enumerate().take(effect.linear()) {
            if j != index {
                *p = 0.0;
            }
        }
        effect.plausible(&probe, scale).is_err()
    };
    match (fails(-1e-3 * size), fails(1e-3 * size)) {
        (true, false) => (0.0, f64::INFINITY),
        (false, true) => (f64::NEG_INFINITY, 0.0),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// Which samples count: one flag for each sample of each track; empty counts all.
pub(super) type Counted = Vec<Vec<bool>>;

impl Model {
    /// The name of an unknown, also in JSON.
    pub fn name(&self, slot: Slot) -> String {
        match slot {
            Slot::TorqueConstant => Base::TorqueConstant.name().into(),
            Slot::Damping => Base::Damping.name().into(),
            Slot::Inertia => Base::Inertia.name().into(),
            Slot::Lag => "lag".into(),
            Slot::Value(term, index) => {
                let Term { effect, values, .. } = &self.machine.terms[term];
                Named::new(*effect, values.last().copied(), effect.parameters()[index].name).to_string()
            }
        }
    }

    pub fn get(&self, slot: Slot) -> f64 {
        match slot {
            Slot::TorqueConstant => self.machine.torque_constant,
            Slot::Damping => self.machine.damping,
            Slot::Inertia => self.machine.inertia,
            Slot::Lag => self.machine.lag,
            Slot::Value(term, index) => self.machine.terms[term].values[index],
        }
    }

    pub fn values(&self) -> Vec<f64> {
        self.slots.iter().map(|s| self.get(*s)).collect()
    }

    /// The machine with other values.
    pub fn with(&self, values: &[f64]) -> Machine {
        let mut machine = self.machine.clone();
        for (slot, value) in self.slots.iter().zip(values) {
            match slot {
                Slot::TorqueConstant => machine.torque_constant = *value,
                Slot::Damping => machine.damping = *value,
                Slot::Inertia => machine.inertia = *value,
                Slot::Lag => machine.lag = *value,
                Slot::Value(term, index) => machine.terms[*term].values[*index] = *value,
            }
        }
        machine
    }

    /// Adds an effect with all its values unknown (an order is given).
    pub fn add(&mut self, effect: &'static dyn Effect, values: Vec<f64>) {
        let term = self.machine.terms.len();
        let count = if effect.shape() == Shape::Order { effect.linear() } else { values.len() };
        self.machine.terms.push(Term::new(effect, values));
        self.slots.extend((0..count).map(|index| Slot::Value(term, index)));
    }

    /// Takes a term out.
    pub fn remove(&mut self, term: usize) {
        self.machine.terms.remove(term);
        self.slots.retain(|s| !matches!(s, Slot::Value(t, _) if *t == term));
        for slot in &mut self.slots {
            if let Slot::Value(t, _) = slot
                && *t > term
            {
                *t -= 1;
            }
        }
    }

    pub fn unknowns(&self, tracks: &[Track]) -> Vec<Unknown> {
        let n = self.machine.ratio;
        let load = tracks.iter().map(|t| t.load_inertia).fold(0.0, f64::max) / (n * n);
        let within = |start: f64, scale: f64, lower: f64, upper: f64| Unknown { start, scale, lower, upper };
        self.slots
            .iter()
            .map(|slot| {
                let value = self.get(*slot);
                match *slot {
                    Slot::TorqueConstant => within(value, value.abs(), 0.05 * value.abs(), 20.0 * value.abs()),
                    Slot::Damping => within(value, self.scale.torque / self.scale.speed, 0.0, f64::INFINITY),
                    Slot::Inertia => {
                        // Without a load there must be some.
                        let size = value.max(load).max(f64::MIN_POSITIVE);
                        within(value, size, if load > 0.0 { 0.0 } else { 0.02 * size }, f64::INFINITY)
                    }
                    Slot::Lag => within(value, 0.005, 0.0, LONGEST_LAG),
                    Slot::Value(term, index) => {
                        let Term { effect, values, .. } = &self.machine.terms[term];
                        let linear = effect.linear();
                        let shape = values.get(linear).copied().unwrap_or(1.0);
                        if index < linear {
                            let size = size(*effect, index, shape, &self.scale);
                            let (lower, upper) = bounds(*effect, values, index, size, &self.scale);
                            within(value, size.max(value.abs()), lower, upper)
                        } else {
                            let whole = if matches!(effect.shape(), Shape::Current(_)) {
                                self.scale.current
                            } else {
                                self.scale.speed
                            };
                            within(value, value.abs(), 5e-3 * whole, 1.3 * whole)
                        }
                    }
                }
            })
            .collect()
    }

    /// Fits the unknowns to the samples that count.
    pub fn fit(&mut self, tracks: &[&Track], counted: &Counted, rounds: usize, enough: f64) -> f64 {
        let owned: Vec<Track> = Vec::new();
        let unknowns = if tracks.is_empty() { self.unknowns(&owned) } else { self.unknowns_of(tracks) };
        let of = |part: usize, values: &[f64]| masked(tracks[part].residual(&self.with(values)), counted.get(part));
        let Fitted { values, cost } = minimise(tracks.len(), &of, &unknowns, rounds, enough);
        self.machine = self.with(&values);
        cost
    }

    fn unknowns_of(&self, tracks: &[&Track]) -> Vec<Unknown> {
        // The load alone matters: the track with the largest.
        let heaviest = tracks.iter().max_by(|a, b| a.load_inertia.total_cmp(&b.load_inertia));
        heaviest.map_or_else(Vec::new, |t| self.unknowns(std::slice::from_ref(t)))
    }

    /// Residuals of each track.
    pub fn residuals(&self, tracks: &[&Track]) -> Vec<Vec<f64>> {
        let of = |part: usize, _: &[f64]| tracks[part].residual(&self.machine);
        residuals(tracks.len(), &of, &[])
    }

    /// Residuals of each track and their derivatives with respect to each unknown.
    pub fn derivatives(&self, tracks: &[&Track]) -> (Vec<Vec<f64>>, Vec<Vec<Vec<f64>>>) {
        let of = |part: usize, values: &[f64]| tracks[part].residual(&self.with(values));
        let values = self.values();
        let at = residuals(tracks.len(), &of, &values);
        let columns = derivatives(tracks.len(), &of, &self.unknowns_of(tracks), &values, &at);
        (at, columns)
    }
}

fn masked(mut residual: Vec<f64>, counted: Option<&Vec<bool>>) -> Vec<f64> {
    if let Some(counted) = counted {
        for (r, c) in residual.iter_mut().zip(counted) {
            if !c {
                *r = 0.0;
            }
        }
    }
    residual
}

/// Root mean square of the residuals of some tracks; `None` without a sample.
pub(super) fn error(tracks: &[&Track], residuals: &[Vec<f64>], fits: bool) -> Option<(f64, f64)> {
    let (mut squares, mut total, mut count) = (0.0, 0.0, 0);
    for (track, residual) in tracks.iter().zip(residuals).filter(|(t, _)| t.fits == fits) {
        squares += residual.iter().map(|r| r * r).sum::<f64>();
        let known: Vec<f64> = track.position.iter().copied().filter(|p| p.is_finite()).collect();
        let mean = known.iter().sum::<f64>() / known.len().max(1) as f64;
        total += known.iter().map(|p| (p - mean).powi(2)).sum::<f64>();
        count += known.len();
    }
    let vaf = if total > 0.0 { 100.0 * (1.0 - squares / total) } else { 0.0 };
    (count > 0).then(|| ((squares / count as f64).sqrt(), vaf))
}
