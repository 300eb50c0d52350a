//! Winding temperature over a motion: two nodes, with the resistance of copper rising with
//! temperature.
//!
//! ```text
//! C_w dT_w/dt = q(t) (1 + α (T_w − T_0)) − (T_w − T_h)/R_wh        C_w = τ_w/R_wh,   q = R_0 i² ≥ 0
//! C_h dT_h/dt = (T_w − T_h)/R_wh − (T_h − T_a)/R_ha                C_h = τ_h/R_ha
//! ```
//! The one idea: in `θ = T − T_0 + 1/α` these equations are linear and homogeneous in (θ_w, θ_h, θ_a),
//! with couplings that are never negative, and heat stands only on the diagonal, as `α q/C_w`. Every
//! entry of the solution is therefore a sum of products of constants ≥ 0 and exponentials of
//! `∫ q dt` over pieces of time: it rises with q and is **log-convex** in the whole course of q. Sums
//! and products of log-convex functions are log-convex (products of functions that are only convex
//! need not be convex), so every temperature, the periodic state `Σ Φⁿ d`, the largest temperature
//! and the spectral radius of Φ are jointly convex in all samples of heat. Where ambient is above
//! `T_0 − 1/α` (39 K, whatever the reference), that is.
//!
//! **Discretisation.** Heat is piecewise linear between samples. Each interval is split into parts of at
//! most τ_w/16 (256 parts at most). A part whose heat goes from q_a to q_b is held in two halves at `(5 q_a + q_b)/6` and
//! `(q_a + 5 q_b)/6`, which have the mean and the first moment of that heat (one of less than τ_w/1024 at its mean), and the
//! constant-coefficient equations of each are solved exactly: `x ← e^{hA(q)} x + ∫e^{tA(q)} dt b(q)`. So
//!
//! * the log-convexity above holds for the discrete solution, too, as all weights are positive. It does not for the
//!   trapezoid rule or the implicit midpoint, whose factor `(1 + z/2)/(1 − z/2)` is log-concave where z < 0, and
//!   which is negative below z = −2: their temperatures are not convex in q;
//! * heat in is heat out plus heat stored in every half, to rounding, as it is the exact solution;
//! * no interval is too long, and constant heat has no error at all. Else the error at the ends of parts is of fourth
//!   order (Magnus): below 1e-5 of the rise;
//! * the split depends on times only, never on heat. The heat of a cycle is the trapezoid rule's, as everywhere in the model.
//!
//! **Between the ends of parts** the winding may be hotter. There its temperature is bounded from above: a part is gone
//! through once more in n steps (4096 h/τ_w, from 4 to 256), each at the larger of the heats at its ends. The larger of two numbers is convex in both
//! and rises with them, so log-convexity stays, and the bound converges from above: it gives away at most
//! `h |q_b − q_a|/(2 n C_w)`, no more than 1/8192 of `R_wh |q_b − q_a|` in parts of up to τ_w/16. It is looked at only where
//! it might be the peak.
//!
//! The exponential comes from its Taylor series, doubled where the part is long, not from eigenvalues:
//! nothing is divided by, so double eigenvalues, a clamped housing (`R_ha = 0`: one node) and the
//! threshold of runaway are no special cases. `e^{hA} − I` is what is kept, so that slow housings keep
//! their digits. State is the rise over ambient \[K\].

mod heat;
mod peak;
mod phase;
mod step;
#[cfg(test)]
mod tests;

pub use heat::{Course, Heat};

use super::thermal::{copper, resistance_factor};
use crate::numerics::work;
use heat::Part;
use peak::{Peak, Watt};
use step::{Rates, Rise, Step, times};

/// Winding and housing between heat and ambient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoNode {
    /// Thermal resistance from winding to housing \[K/W\], R_wh > 0.
    pub resistance_winding_housing: f64,
    /// Thermal resistance from housing to ambient \[K/W\], R_ha ≥ 0. Zero keeps the housing at ambient:
    /// one node.
    pub resistance_housing_ambient: f64,
    /// Time constant of the winding \[s\], τ_w = R_wh C_w.
    pub time_constant_winding: f64,
    /// Time constant of the housing \[s\], τ_h = R_ha C_h.
    pub time_constant_housing: f64,
    /// Ambient \[K\], T_a; above T_0 − 1/α.
    pub ambient: f64,
    /// Temperature of the resistance in `q = R_0 i²` \[K\], T_0.
    pub reference: f64,
    /// True for a brushless winding, of which one phase is hotter than the others at standstill.
    pub phases: bool,
}

/// Temperatures over a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Temperature {
    /// Largest temperature of the winding or of its hottest phase \[K\]; that of the winding at samples and between them, where it is a bound
    /// from above. Infinite where a motion from cold leaves all numbers.
    pub peak: f64,
    /// The sample at which, or in the interval after which, it is reached.
    pub peak_sample: usize,
    /// Winding temperature at each sample, the mean of the phases \[K\].
    pub winding: Vec<f64>,
    /// Temperature of the hottest phase at each sample \[K\]; empty where the phases share the heat alike.
    pub phase: Vec<f64>,
    /// Housing temperature at each sample \[K\].
    pub housing: Vec<f64>,
}

/// What becomes of a motion that repeats for ever.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// Temperature becomes periodic.
    Settles(Temperature),
    /// Each period is hotter than the last: the spectral radius of Φ is not below one.
    Runaway,
}

impl TwoNode {
    fn rates(&self, coefficient: f64) -> Rates {
        let by_capacity = self.resistance_winding_housing / self.time_constant_winding;
        Rates {
            winding: 1.0 / self.time_constant_winding,
            housing: self.resistance_housing_ambient / (self.resistance_winding_housing * self.time_constant_housing),
            ambient: 1.0 / self.time_constant_housing,
            growth: coefficient * by_capacity,
            source: (1.0 + coefficient * (self.ambient - self.reference)) * by_capacity,
        }
    }

    /// Temperatures of a motion that repeats for ever: `x_0 = (I − Φ)⁻¹ d` with the map `x ↦ Φ x + d` of
    /// one period. It exists exactly where the spectral radius of Φ is below one. The mean heat may pass
    /// (`α q̄ (R_wh + R_ha) < 1`) where this fails: pulses run away before constant heat does.
    ///
    /// # Panics
    /// Without a sample, or with unequal numbers of times and of heats.
    ///
    /// ```
    /// use gearwise_model::actuator::thermal_motion::{Heat, Outcome, TwoNode};
    ///
    /// let motor = TwoNode {
    ///     resistance_winding_housing: 0.508,
    ///     resistance_housing_ambient: 0.418,
    ///     time_constant_winding: 50.8,
    ///     time_constant_housing: 600.0,
    ///     ambient: 298.15,
    ///     reference: 295.15,
    ///     phases: true,
    /// };
    /// let heat = Heat { times: &[0.0, 0.5], period_or_duration: 1.0, heat: &[0.0, 100.0], settling: &[], phase: &[] };
    /// let Outcome::Settles(temperature) = motor.periodic_state(&heat) else { panic!() };
    /// // Mean heat 50 W over 0.926 K/W: 46.3 K at constant resistance.
    /// assert!(temperature.peak - 298.15 > 46.3 && temperature.peak - 298.15 < 60.0);
    /// ```
    pub fn periodic_state(&self, heat: &Heat) -> Outcome {
        let rates = self.rates(copper(self.reference));
        let mut steps = Vec::with_capacity(heat.times.len());
        let mut period = Step::NOTHING;
        heat.parts(Course::Periodic, self.time_constant_winding).for_each(|part| {
            let step = rates.step(part.duration, part.heat);
            period = period.then(&step);
            steps.push(step);
        });
        match period.sum_of_powers() {
            Some(inverse) => {
                let (start, mut steps) = (times(&inverse, period.gain), steps.into_iter());
                let next = |_: &Part| steps.next().expect("the parts do not change");
                self.march(heat, Course::Periodic, start, next).map_or(Outcome::Runaway, Outcome::Settles)
            }
            None => Outcome::Runaway,
        }
    }

    /// Temperatures of a motion that happens once, winding and housing starting at ambient.
    ///
    /// # Panics
    /// Without a sample, or with unequal numbers of times and of heats.
    pub fn from_cold(&self, heat: &Heat) -> Temperature {
        let rates = self.rates(copper(self.reference));
        let step = |part: &Part| rates.step(part.duration, part.heat);
        self.march(heat, Course::FromCold, [0.0; 2], step).expect("from cold every phase has a temperature")
    }

    /// Rise of the winding over ambient \[K\] at the end of a cycle that repeats for ever, with the winding's resistance
    /// that of `limit` \[K\]. The cycle holds one heat after the other: its time \[s\] and its heat at the reference
    /// temperature \[W\].
    ///
    /// With the heats in rising order this bounds the rise of *every* order, at every time, where it does not exceed the
    /// limit. With a constant resistance the rise is `∫ k(s) q(t − s) ds` over all that was, and k is a sum of falling
    /// exponentials with weights that are not negative (the equations are those of a symmetric negative definite matrix
    /// but for a scale of the two nodes). What falls weighs most where most heat came last: the order that makes the
    /// integral largest, over each cycle, has the heats rise towards its end (the rearrangement inequality). And a winding
    /// that is nowhere hotter than the limit has nowhere more than its resistance there.
    pub fn rise_at_the_end(&self, holds: impl Iterator<Item = (f64, f64)>, limit: f64) -> f64 {
        let (constant, hot) = (self.rates(0.0), resistance_factor(limit, self.reference));
        let cycle =
            holds.fold(Step::NOTHING, |cycle, (duration, heat)| cycle.then(&constant.step(duration, hot * heat)));
        cycle.sum_of_powers().map_or(f64::INFINITY, |inverse| times(&inverse, cycle.gain)[0])
    }

    /// The temperatures from a start on; `None` where the hottest phase of a motion that repeats runs away.
    fn march(
        &self,
        heat: &Heat,
        course: Course,
        start: Rise,
        mut step: impl FnMut(&Part) -> Step,
    ) -> Option<Temperature> {
        let kelvin = |rise: f64| if rise.is_finite() { self.ambient + rise } else { f64::INFINITY };
        let mut nodes: Vec<(Part, Rise)> = Vec::with_capacity(heat.times.len());
        let mut rise = start;
        heat.parts(course, self.time_constant_winding).for_each(|part| {
            nodes.push((part, rise));
            rise = step(&part).apply(rise);
        });
        work::count((if heat.phase.is_empty() { 6 } else { 12 }) * nodes.len());
        let rates = self.rates(copper(self.reference));
        let peak = rates.peak(heat, course, nodes.iter().copied(), rise);
        let phase = match heat.phase.is_empty() {
            true => None,
            false => Some(rates.phase(heat, course, &nodes)?),
        };
        let hottest = phase.as_ref().filter(|phase| phase.peak > peak.rise);
        let at_samples = || nodes.iter().enumerate().filter(|(_, (part, _))| part.first);
        Some(Temperature {
            peak: kelvin(hottest.map_or(peak.rise, |phase| phase.peak)),
            peak_sample: hottest.map_or(peak.sample, |phase| phase.sample),
            winding: at_samples().map(|(_, (_, rise))| kelvin(rise[0])).collect(),
            phase: phase.map_or_else(Vec::new, |phase| at_samples().map(|(k, _)| kelvin(phase.rises[k])).collect()),
            housing: at_samples().map(|(_, (_, rise))| kelvin(rise[1])).collect(),
        })
    }

    /// `g_k = ∂T_peak/∂q_k ≥ 0` \[K/W\] for every sample, by the winding's mean heat and by that of its hottest phase (zero where the phases
    /// share the heat alike), at the temperatures that
    /// [`periodic_state`](Self::periodic_state) or [`from_cold`](Self::from_cold) gave for this heat
    /// (`peak` finite).
    ///
    /// As the largest temperature is convex in heat, `T_peak(q') ≥ T_peak(q) + Σ g_k (q'_k − q_k)` for all
    /// q' ≥ 0 that settle; where several times share the peak, it is a subgradient. By the adjoint: the
    /// row `λ = e_w` goes backwards from the peak j to the start, `λ ← λ Φ_k`; in a motion that repeats, all
    /// earlier periods follow as `λ (I − Φ)⁻¹`, once more backwards through a period.
    ///
    /// Beyond runaway there is no peak. The peak of a few periods from cold lies below the peak of the
    /// periodic state, and its gradient, added up over periods, cuts such a heat off.
    ///
    /// # Panics
    /// Where the heat of a motion that repeats runs away, and as
    /// [`periodic_state`](Self::periodic_state).
    pub fn peak_gradient(&self, heat: &Heat, course: Course, temperature: &Temperature) -> [Vec<f64>; 2] {
        let rates = self.rates(copper(self.reference));
        let mut gradient = vec![0.0; heat.times.len()];
        let mut nodes = Vec::with_capacity(heat.times.len());
        let mut rise = [temperature.winding[0] - self.ambient, temperature.housing[0] - self.ambient];
        heat.parts(course, self.time_constant_winding).for_each(|part| {
            let node = Watt::new(&rates, part, rise);
            rise = node.step.apply(rise);
            nodes.push(node);
        });
        work::count((if heat.phase.is_empty() { 10 } else { 30 }) * nodes.len());
        let places = nodes.iter().map(|node| (node.part, node.before));
        let Peak { node: hottest, steps, rise: largest, .. } = rates.peak(heat, course, places.clone(), rise);
        if !heat.phase.is_empty() {
            let places: Vec<(Part, Rise)> = places.collect();
            let phase = rates.phase(heat, course, &places).expect("this heat settles");
            if phase.peak > largest {
                return rates.phase_gradient(heat, course, &nodes, &phase);
            }
        }
        // The steps within the part in which the peak lies.
        let mut within = Vec::new();
        if let (true, Some(Watt { part, before, .. })) = (steps > 0, nodes.get(hottest))
            && let Some((shares, duration)) = part.whole
        {
            let mut rise = *before;
            let count = rates.steps_within(duration);
            for share in heat.steps_within(part, shares, count).take(steps) {
                let duration = duration / count as f64;
                let step = Part { share, duration, heat: heat.between(part, share), ..*part };
                let node = Watt::new(&rates, step, rise);
                rise = node.step.apply(rise);
                within.push(node);
            }
        }
        // Backwards through time; the row is the derivative of the peak by the rises at a node.
        let mut back = |mut row: Rise, nodes: &[Watt], counts: bool| {
            for Watt { part, step, per_watt, .. } in nodes.iter().rev() {
                if counts {
                    let slope = row[0] * per_watt[0] + row[1] * per_watt[1];
                    gradient[part.sample] += (1.0 - part.share) * slope;
                    gradient[part.next] += part.share * slope;
                }
                row = step.pull(row);
            }
            row
        };
        let (before, after) = nodes.split_at(hottest);
        let mut row = back([1.0, 0.0], &within, true);
        if course == Course::Periodic {
            let period = nodes.iter().fold(Step::NOTHING, |period, node| period.then(&node.step));
            let [to_winding, to_housing] = period.sum_of_powers().expect("this heat settles");
            let once = back(row, before, false);
            let all = [0, 1].map(|node| once[0] * to_winding[node] + once[1] * to_housing[node]);
            let later = back(all, after, true);
            row = [later[0] + row[0], later[1] + row[1]];
        }
        back(row, before, true);
        let none = vec![0.0; gradient.len()];
        [gradient, none]
    }

    /// A cut of a rise that is far beyond its bound \[K\], from the rise and its gradient \[K/W\]: its value, still beyond the
    /// bound, and its gradient, with digits that matter near the bound.
    ///
    /// In `θ = T − T_0 + 1/α` the peak is log-convex in heat, and `e^x ≥ 1 + x`, so for all heats
    /// `θ' ≥ θ_b (1 + ln(θ/θ_b) + g·(q' − q)/θ)`, with θ_b that of the bound.
    pub fn far_beyond(&self, rise: f64, gradient: Vec<f64>, bound: f64) -> (f64, Vec<f64>) {
        let ambient = self.ambient - self.reference + 1.0 / copper(self.reference);
        let (here, at_bound) = (rise + ambient, bound + ambient);
        let scaled = gradient.into_iter().map(|g| g / here * at_bound).collect();
        (bound + at_bound * (here / at_bound).ln(), scaled)
    }

    /// How long constant heat `q = R_0 i²` \[W\] may last from ambient until the winding reaches `limit`
    /// \[K\]; `None` where it never does. `coefficient` is α \[1/K\]: [`copper`], or zero for a
    /// resistance that does not rise with temperature, as textbooks' first figures have it.
    ///
    /// With one node (`R_ha = 0`) this is `−τ/(1 − a) ln(1 − (1 − a) ΔT/(R q (1 + α (T_a − T_0))))`, with
    /// `a = α R q` and `R = R_wh`. Two nodes have no closed form: Newton, within a bracket.
    ///
    /// ```
    /// use gearwise_model::actuator::thermal_motion::TwoNode;
    ///
    /// // 10 A in 1 Ω over 10 K/W with 60 s, to 100 K: 6.3 s; copper that warms leaves 5.3 s.
    /// let motor = TwoNode {
    ///     resistance_winding_housing: 10.0,
    ///     resistance_housing_ambient: 0.0,
    ///     time_constant_winding: 60.0,
    ///     time_constant_housing: 60.0,
    ///     ambient: 298.15,
    ///     reference: 298.15,
    ///     phases: true,
    /// };
    /// assert!((motor.time_to_reach(398.15, 100.0, 0.0).unwrap() - 6.32).abs() < 0.01);
    /// assert!((motor.time_to_reach(398.15, 100.0, 0.0039).unwrap() - 5.27).abs() < 0.01);
    /// ```
    pub fn time_to_reach(&self, limit: f64, heat: f64, coefficient: f64) -> Option<f64> {
        let target = limit - self.ambient;
        if target <= 0.0 {
            return Some(0.0);
        }
        let rates = self.rates(coefficient);
        // The winding's rise grows all the time, to the steady state where there is one.
        let (growth, source) = (rates.growth * heat, rates.source * heat);
        let out = rates.housing + rates.ambient;
        let determinant = rates.winding * rates.ambient - growth * out;
        if source <= 0.0 || (determinant > 0.0 && source * out <= target * determinant) {
            return None;
        }
        // A bracket, then Newton within it.
        let (mut early, mut late) = (0.0, target / source);
        while rates.step(late, heat).gain[0] < target {
            (early, late) = (late, 2.0 * late);
            if !late.is_finite() {
                return None;
            }
        }
        let mut time = late;
        for _ in 0..100 {
            let rise = rates.step(time, heat).gain;
            if rise[0] < target {
                early = time;
            } else {
                late = time;
            }
            let rate = source + growth * rise[0] - rates.winding * (rise[0] - rise[1]);
            let newton = time - (rise[0] - target) / rate;
            let next = if newton >= early && newton <= late { newton } else { 0.5 * (early + late) };
            if (next - time).abs() <= 1e-15 * time {
                break;
            }
            time = next;
        }
        Some(time)
    }
}
