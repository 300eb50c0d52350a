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

use super::thermal::{copper, resistance_factor};

/// Parts of an interval per winding time constant.
const PARTS_PER_TIME_CONSTANT: f64 = 16.0;

/// Most parts of one interval. Beyond 16 τ_w the parts grow: a winding that has forgotten follows its
/// heat.
const MOST_PARTS: f64 = 256.0;

/// Parts shorter than this share of the winding's time constant are held at one heat.
const SHORT: f64 = 1.0 / 1024.0;

/// Steps per winding time constant in which a part is gone through between its ends.
const STEPS_PER_TIME_CONSTANT: f64 = 4096.0;

/// Fewest and most of these steps.
const STEPS_WITHIN: (f64, f64) = (4.0, 256.0);

/// `1/(n+1)!`, the coefficients of `φ(z) = (e^z − 1)/z`.
const PHI: [f64; 12] = [
    1.0,
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5_040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
];

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
}

/// How a motion goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// It repeats for ever; heat goes from the last sample to the first within the period.
    Periodic,
    /// It happens once, from ambient; the last sample's heat is held to the end of the duration.
    FromCold,
}

/// Copper heat at the reference temperature over a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Heat<'a> {
    /// Sample times t_k \[s\], increasing.
    pub times: &'a [f64],
    /// Period, or duration, from the first sample on \[s\]: positive, not less than t_K − t_1.
    pub period_or_duration: f64,
    /// Heat at the samples \[W\], q_k = R_0 i_k² ≥ 0.
    pub heat: &'a [f64],
}

/// Temperatures over a motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Temperature {
    /// Largest winding temperature \[K\], at samples and between them, where it is a bound from above. Infinite where
    /// a motion from cold leaves all numbers.
    pub peak: f64,
    /// The sample at which, or in the interval after which, it is reached.
    pub peak_sample: usize,
    /// Winding temperature at each sample \[K\].
    pub winding: Vec<f64>,
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

/// Coefficients of the equations, and how the winding's depend on heat.
#[derive(Debug, Clone, Copy)]
struct Rates {
    /// `1/τ_w` \[1/s\], winding to housing, and back.
    winding: f64,
    /// `1/(R_wh C_h)` \[1/s\].
    housing: f64,
    /// `1/τ_h` \[1/s\].
    ambient: f64,
    /// `α/C_w` \[1/(s·W)\].
    growth: f64,
    /// `(1 + α (T_a − T_0))/C_w` \[K/(s·W)\].
    source: f64,
}

/// Rise of winding and of housing over ambient \[K\].
type Rise = [f64; 2];

/// The map `x ↦ x + change x + gain` of rises over a time, or its derivative.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// `Φ − I`, rows winding and housing.
    change: [[f64; 2]; 2],
    /// What heat adds to no rise \[K\].
    gain: Rise,
}

/// A time of constant heat: a part, or half of one.
#[derive(Debug, Clone, Copy)]
struct Part {
    /// The sample before it.
    sample: usize,
    /// The sample after it, whose heat counts as well.
    next: usize,
    /// Share of the next sample in the heat.
    share: f64,
    /// Whether it starts at the sample.
    first: bool,
    /// How long it is \[s\].
    duration: f64,
    /// Its heat \[W\].
    heat: f64,
    /// The whole part, where it starts with this: shares of the next sample at its ends, and how long it is \[s\].
    whole: Option<([f64; 2], f64)>,
}

/// Where the winding is hottest: in a part, after so many of the steps within it; none is its start.
#[derive(Debug, Clone, Copy)]
struct Within {
    rise: f64,
    steps: usize,
    /// Whether that is the sample after it.
    ends: bool,
}

/// The largest rise of the winding over a motion.
#[derive(Debug, Clone, Copy)]
struct Peak {
    rise: f64,
    /// The sample at which, or in the interval after which, it is reached.
    sample: usize,
    /// The part that it lies in or at the start of; one more than there are where it is the end.
    node: usize,
    /// After so many of the steps within the part.
    steps: usize,
}

/// A time of constant heat with its step, and what a watt in it adds.
#[derive(Debug, Clone, Copy)]
struct Watt {
    part: Part,
    /// The rises before it.
    before: Rise,
    step: Step,
    /// What a watt in it adds to the rises at its end \[K/W\].
    per_watt: Rise,
}

impl Watt {
    fn new(rates: &Rates, part: Part, before: Rise) -> Watt {
        let (step, slope) = rates.expand(part.duration, part.heat);
        let by_change = times(&slope.change, before);
        Watt { part, before, step, per_watt: [by_change[0] + slope.gain[0], by_change[1] + slope.gain[1]] }
    }
}

fn times(m: &[[f64; 2]; 2], x: Rise) -> Rise {
    [m[0][0] * x[0] + m[0][1] * x[1], m[1][0] * x[0] + m[1][1] * x[1]]
}

impl Step {
    const NOTHING: Step = Step { change: [[0.0; 2]; 2], gain: [0.0; 2] };

    /// Rises after the step.
    fn apply(&self, x: Rise) -> Rise {
        let change = times(&self.change, x);
        [x[0] + (change[0] + self.gain[0]), x[1] + (change[1] + self.gain[1])]
    }

    /// The row `row Φ`.
    fn pull(&self, row: Rise) -> Rise {
        let [winding, housing] = self.change;
        [0, 1].map(|node| row[node] + (row[0] * winding[node] + row[1] * housing[node]))
    }

    /// This step, then another: `(I + B)(I + A) − I = A + B + BA`.
    fn then(&self, next: &Step) -> Step {
        let (a, b) = (&self.change, &next.change);
        let entry = |i: usize, j: usize| a[i][j] + b[i][j] + (b[i][0] * a[0][j] + b[i][1] * a[1][j]);
        Step { change: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]], gain: next.apply(self.gain) }
    }

    /// Derivative of this step taken twice.
    fn twice_slope(&self, slope: &Step) -> Step {
        let (a, s) = (&self.change, &slope.change);
        let entry = |i: usize, j: usize| {
            2.0 * s[i][j] + (a[i][0] * s[0][j] + a[i][1] * s[1][j]) + (s[i][0] * a[0][j] + s[i][1] * a[1][j])
        };
        let (by_gain, by_change) = (times(a, slope.gain), times(s, self.gain));
        Step {
            change: [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]],
            gain: [2.0 * slope.gain[0] + by_gain[0] + by_change[0], 2.0 * slope.gain[1] + by_gain[1] + by_change[1]],
        }
    }

    /// `(I − Φ)⁻¹`, `None` where the spectral radius of Φ is not below one: for Φ ≥ 0 it is below one
    /// exactly where `I − Φ` has positive diagonal and determinant (a nonsingular M-matrix).
    fn sum_of_powers(&self) -> Option<[[f64; 2]; 2]> {
        let [[a, b], [c, d]] = self.change;
        let determinant = a * d - b * c;
        (a < 0.0 && d < 0.0 && determinant > 0.0)
            .then(|| [[-d / determinant, b / determinant], [c / determinant, -a / determinant]])
    }
}

impl Rates {
    /// The step over a time at constant heat, and its derivative by heat.
    ///
    /// `φ(B) = (e^B − 1)/B = u I + v B` for `B = hA`, as `B² = tr(B) B − det(B) I` (Cayley and
    /// Hamilton); then `e^B − I = B φ(B)` and `∫₀ʰ e^{tA} dt = h φ(B)`.
    #[inline(always)]
    fn expand(&self, duration: f64, heat: f64) -> (Step, Step) {
        let stiffness = 2.0 * (self.winding + self.housing) + self.ambient + self.growth * heat;
        let size = duration * stiffness;
        if size <= 1.0 / 512.0 { self.series::<5>(duration, heat) } else { self.doubled(duration, heat, size) }
    }

    /// The same, of a long time: halved until the series is short, and doubled again.
    #[inline(always)]
    fn doubled(&self, duration: f64, heat: f64, size: f64) -> (Step, Step) {
        let (mut part, mut doublings) = (1.0, 0);
        // Heat beyond all numbers must not halve for ever.
        while size * part > 0.25 && doublings < 1000 {
            part *= 0.5;
            doublings += 1;
        }
        let (mut step, mut slope) = self.series::<12>(duration * part, heat);
        for _ in 0..doublings {
            slope = step.twice_slope(&slope);
            step = step.then(&step);
        }
        (step, slope)
    }

    /// The first terms of the series.
    #[inline(always)]
    fn series<const TERMS: usize>(&self, h: f64, heat: f64) -> (Step, Step) {
        let Rates { winding, housing, ambient, growth, source } = *self;
        // B, its trace and determinant; their derivatives by heat.
        let (b_ww, b_wh, b_hw, b_hh) =
            (h * (growth * heat - winding), h * winding, h * housing, -h * (housing + ambient));
        let trace = b_ww + b_hh;
        let determinant = h * h * (winding * ambient - growth * heat * (housing + ambient));
        let trace_slope = h * growth;
        let determinant_slope = trace_slope * b_hh;
        let (mut u, mut v) = (PHI[TERMS - 1], 0.0);
        let (mut u_slope, mut v_slope) = (0.0, 0.0);
        for n in (0..TERMS - 1).rev() {
            (u_slope, v_slope) =
                (-(v_slope * determinant + v * determinant_slope), u_slope + v_slope * trace + v * trace_slope);
            (u, v) = (PHI[n] - v * determinant, u + v * trace);
        }
        // B φ = (u + v tr) B − v det I.
        let (along, across) = (u + v * trace, v * determinant);
        let along_slope = u_slope + v_slope * trace + v * trace_slope;
        let across_slope = v_slope * determinant + v * determinant_slope;
        // b = (source q, 0): its first column of h φ.
        let column = [h * (u + v * b_ww), h * v * b_hw];
        let column_slope = [h * (u_slope + v_slope * b_ww + v * trace_slope), h * v_slope * b_hw];
        let gain = source * heat;
        (
            Step {
                change: [[along * b_ww - across, along * b_wh], [along * b_hw, along * b_hh - across]],
                gain: [gain * column[0], gain * column[1]],
            },
            Step {
                change: [
                    [along_slope * b_ww + along * trace_slope - across_slope, along_slope * b_wh],
                    [along_slope * b_hw, along_slope * b_hh - across_slope],
                ],
                gain: [source * column[0] + gain * column_slope[0], source * column[1] + gain * column_slope[1]],
            },
        )
    }

    /// The step over a time \[s\] at constant heat \[W\].
    #[inline(always)]
    fn step(&self, duration: f64, heat: f64) -> Step {
        self.expand(duration, heat).0
    }
}

impl<'a> Heat<'a> {
    /// The parts of constant heat, in the order of time.
    fn parts(self, course: Course, time_constant: f64) -> impl Iterator<Item = Part> + 'a {
        let Heat { times, period_or_duration, heat } = self;
        assert!(!times.is_empty() && times.len() == heat.len(), "one value of heat for each of at least one sample");
        debug_assert!(heat.iter().all(|q| *q >= 0.0), "copper heat is not negative");
        debug_assert!(times.is_sorted(), "times increase");
        let last = times.len() - 1;
        let end = times[0] + period_or_duration;
        (0..=last).flat_map(move |sample| {
            let next = match course {
                _ if sample < last => sample + 1,
                Course::Periodic => 0,
                Course::FromCold => last,
            };
            let until = if sample < last { times[sample + 1] } else { end };
            let interval = (until - times[sample]).max(0.0);
            let parts = interval * (PARTS_PER_TIME_CONSTANT / time_constant);
            let count = if parts <= 1.0 { 1 } else { parts.ceil().min(MOST_PARTS) as u32 };
            let one = if count == 1 { 1.0 } else { 1.0 / f64::from(count) };
            let duration = interval * one;
            let halves: u32 = if duration <= SHORT * time_constant { 1 } else { 2 };
            (0..count * halves).map(move |place| {
                let (part, second) = (f64::from(place / halves), place % halves == 1);
                // The first moment of a straight line: a third of its change on either side of the mean.
                let moved = match (halves, second) {
                    (1, _) => 0.0,
                    (_, false) => -1.0 / 3.0,
                    (_, true) => 1.0 / 3.0,
                };
                let share = (part + 0.5 + moved) * one;
                Part {
                    sample,
                    next,
                    share,
                    first: place == 0,
                    duration: duration / f64::from(halves),
                    heat: (1.0 - share) * heat[sample] + share * heat[next],
                    whole: (!second).then_some(([part * one, (part + 1.0) * one], duration)),
                }
            })
        })
    }

    /// Heat between two samples \[W\].
    fn between(&self, part: &Part, share: f64) -> f64 {
        (1.0 - share) * self.heat[part.sample] + share * self.heat[part.next]
    }

    /// The steps within a part that starts at `part`: shares of the next sample at both ends, and the share at
    /// which the heat is larger.
    fn steps_within(&self, part: &Part, [from, to]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
        let (falls, step) = (self.between(part, from) >= self.between(part, to), (to - from) / count as f64);
        (0..count).map(move |k| from + step * (k + usize::from(!falls)) as f64)
    }
}

impl Rates {
    /// In how many steps a part of a length \[s\] is gone through: depends on times only.
    fn steps_within(&self, duration: f64) -> usize {
        let (fewest, most) = STEPS_WITHIN;
        (STEPS_PER_TIME_CONSTANT * self.winding * duration).ceil().clamp(fewest, most) as usize
    }

    /// The largest rise of the winding, from the rises at the start of each part and that at the end. Ends of parts come
    /// first: within most parts nothing can be above the highest of them.
    fn peak(&self, heat: &Heat, course: Course, nodes: impl Iterator<Item = (Part, Rise)> + Clone, end: Rise) -> Peak {
        // What left all numbers is hotter than any.
        let number = |rise: f64| if rise.is_finite() { rise } else { f64::INFINITY };
        let mut peak = Peak { rise: f64::NEG_INFINITY, sample: 0, node: 0, steps: 0 };
        let mut count = 0;
        for (node, (part, rise)) in nodes.clone().enumerate() {
            count += 1;
            if part.whole.is_some() && number(rise[0]) > peak.rise {
                peak = Peak { rise: number(rise[0]), sample: part.sample, node, steps: 0 };
            }
        }
        // The end of a period is its start.
        if course == Course::FromCold && number(end[0]) > peak.rise {
            peak = Peak { rise: number(end[0]), sample: heat.times.len() - 1, node: count, steps: 0 };
        }
        for (node, (part, rise)) in nodes.enumerate() {
            if let Some(Within { rise, steps, ends }) = self.highest_within(heat, &part, rise, peak.rise) {
                peak = Peak { rise, sample: if ends { part.next } else { part.sample }, node, steps };
            }
        }
        peak
    }

    /// The largest rise within a part, and where, if it is above another; a bound from above.
    fn highest_within(&self, heat: &Heat, part: &Part, start: Rise, above: f64) -> Option<Within> {
        let (shares, duration) = part.whole.filter(|_| above < f64::INFINITY)?;
        let ends = shares.map(|share| heat.between(part, share));
        // Constant heat is hottest at one of its ends.
        if ends[0] == ends[1] || duration == 0.0 {
            return None;
        }
        // What it cannot exceed: all heat stays in the winding, and the housing gives what it has more.
        let most = ends[0].max(ends[1]);
        let own = duration * self.growth * most;
        let given = duration * (self.source * most + self.winding * (start[1] - start[0]).max(0.0));
        if own < 0.5 && (start[0] + given) / (1.0 - own) <= above {
            return None;
        }
        let (mut rise, mut highest) = (start, None);
        let mut above = above;
        let count = self.steps_within(duration);
        for (k, share) in heat.steps_within(part, shares, count).enumerate() {
            rise = self.step(duration / count as f64, heat.between(part, share)).apply(rise);
            if rise[0] > above {
                above = rise[0];
                highest = Some(Within { rise: above, steps: k + 1, ends: k + 1 == count && shares[1] == 1.0 });
            }
        }
        highest
    }
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
    /// use gearwise::actuator::thermal_motion::{Heat, Outcome, TwoNode};
    ///
    /// let motor = TwoNode {
    ///     resistance_winding_housing: 0.508,
    ///     resistance_housing_ambient: 0.418,
    ///     time_constant_winding: 50.8,
    ///     time_constant_housing: 600.0,
    ///     ambient: 298.15,
    ///     reference: 295.15,
    /// };
    /// let heat = Heat { times: &[0.0, 0.5], period_or_duration: 1.0, heat: &[0.0, 100.0] };
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
                Outcome::Settles(self.march(heat, Course::Periodic, start, next))
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
        self.march(heat, Course::FromCold, [0.0; 2], |part| rates.step(part.duration, part.heat))
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

    fn march(&self, heat: &Heat, course: Course, start: Rise, mut step: impl FnMut(&Part) -> Step) -> Temperature {
        let kelvin = |rise: f64| if rise.is_finite() { self.ambient + rise } else { f64::INFINITY };
        let mut nodes: Vec<(Part, Rise)> = Vec::with_capacity(heat.times.len());
        let mut rise = start;
        heat.parts(course, self.time_constant_winding).for_each(|part| {
            nodes.push((part, rise));
            rise = step(&part).apply(rise);
        });
        let peak = self.rates(copper(self.reference)).peak(heat, course, nodes.iter().copied(), rise);
        let at_samples = || nodes.iter().filter(|(part, _)| part.first);
        Temperature {
            peak: kelvin(peak.rise),
            peak_sample: peak.sample,
            winding: at_samples().map(|(_, rise)| kelvin(rise[0])).collect(),
            housing: at_samples().map(|(_, rise)| kelvin(rise[1])).collect(),
        }
    }

    /// `g_k = ∂T_peak/∂q_k ≥ 0` \[K/W\] for every sample, at the temperatures that
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
    pub fn peak_gradient(&self, heat: &Heat, course: Course, temperature: &Temperature) -> Vec<f64> {
        let rates = self.rates(copper(self.reference));
        let mut gradient = vec![0.0; heat.times.len()];
        let mut nodes = Vec::with_capacity(heat.times.len());
        let mut rise = [temperature.winding[0] - self.ambient, temperature.housing[0] - self.ambient];
        heat.parts(course, self.time_constant_winding).for_each(|part| {
            let node = Watt::new(&rates, part, rise);
            rise = node.step.apply(rise);
            nodes.push(node);
        });
        let places = nodes.iter().map(|node| (node.part, node.before));
        let Peak { node: hottest, steps, .. } = rates.peak(heat, course, places, rise);
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
        gradient
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
    /// use gearwise::actuator::thermal_motion::TwoNode;
    ///
    /// // 10 A in 1 Ω over 10 K/W with 60 s, to 100 K: 6.3 s; copper that warms leaves 5.3 s.
    /// let motor = TwoNode {
    ///     resistance_winding_housing: 10.0,
    ///     resistance_housing_ambient: 0.0,
    ///     time_constant_winding: 60.0,
    ///     time_constant_housing: 60.0,
    ///     ambient: 298.15,
    ///     reference: 298.15,
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

#[cfg(test)]
mod tests {
    use super::super::thermal;
    use super::*;
    use approx::assert_relative_eq;
    use nalgebra::{Matrix2, Vector2};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// ILM115x25 (WE18 of the worked examples); the housing's time constant is not published.
    const MOTOR: TwoNode = TwoNode {
        resistance_winding_housing: 0.507863,
        resistance_housing_ambient: 0.418284,
        time_constant_winding: 50.8,
        time_constant_housing: 700.0,
        ambient: 298.15,
        reference: 295.143,
    };

    /// One node of the hold of WE01.
    const HOLD: TwoNode = TwoNode {
        resistance_winding_housing: 10.0,
        resistance_housing_ambient: 0.0,
        time_constant_winding: 60.0,
        time_constant_housing: 60.0,
        ambient: 298.15,
        reference: 298.15,
    };

    fn settled(motor: &TwoNode, heat: &Heat) -> Temperature {
        match motor.periodic_state(heat) {
            Outcome::Settles(temperature) => temperature,
            Outcome::Runaway => panic!("runs away"),
        }
    }

    fn peak(motor: &TwoNode, heat: &Heat, course: Course) -> f64 {
        match course {
            Course::Periodic => match motor.periodic_state(heat) {
                Outcome::Settles(temperature) => temperature.peak,
                Outcome::Runaway => f64::INFINITY,
            },
            Course::FromCold => motor.from_cold(heat).peak,
        }
    }

    fn grid(samples: usize, period: f64) -> Vec<f64> {
        (0..samples).map(|k| period * k as f64 / samples as f64).collect()
    }

    /// Uneven times within a period, and heats.
    fn random_course(rng: &mut Pcg64, samples: usize, period: f64, most: f64) -> (Vec<f64>, Vec<f64>) {
        let mut times: Vec<f64> = (0..samples).map(|_| rng.random_range(0.0..period)).collect();
        times.sort_by(f64::total_cmp);
        times[0] = 0.0;
        (times, random_heat(rng, samples, most))
    }

    fn random_heat(rng: &mut Pcg64, samples: usize, most: f64) -> Vec<f64> {
        (0..samples).map(|_| if rng.random::<f64>() < 0.3 { 0.0 } else { rng.random_range(0.0..most) }).collect()
    }

    /// Anything from a drone's motor to a wall of iron, slow and fast housings.
    fn random_motor(rng: &mut Pcg64) -> TwoNode {
        let mut log = |low: f64, high: f64| (rng.random_range(low.ln()..high.ln())).exp();
        TwoNode {
            resistance_winding_housing: log(0.1, 5.0),
            resistance_housing_ambient: log(0.1, 5.0),
            time_constant_winding: log(3.0, 100.0),
            time_constant_housing: log(30.0, 3000.0),
            ambient: 293.15 + 5.0 * log(0.1, 10.0),
            reference: 293.15,
        }
    }

    /// Mean heat where constant heat runs away \[W\].
    fn threshold(motor: &TwoNode) -> f64 {
        1.0 / (copper(motor.reference) * (motor.resistance_winding_housing + motor.resistance_housing_ambient))
    }

    /// Largest eigenvalue of a matrix with entries ≥ 0.
    fn spectral_radius(m: &Matrix2<f64>) -> f64 {
        let (half, off) = (0.5 * (m[(0, 0)] - m[(1, 1)]), m[(0, 1)] * m[(1, 0)]);
        0.5 * m.trace() + (half * half + off).sqrt()
    }

    /// The coefficients, written down a second time with capacities.
    fn equations(motor: &TwoNode, heat: f64) -> (Matrix2<f64>, Vector2<f64>) {
        let (r_wh, r_ha) = (motor.resistance_winding_housing, motor.resistance_housing_ambient);
        let (c_w, c_h) = (motor.time_constant_winding / r_wh, motor.time_constant_housing / r_ha);
        let matrix = Matrix2::new(
            (copper(motor.reference) * heat - 1.0 / r_wh) / c_w,
            1.0 / (r_wh * c_w),
            1.0 / (r_wh * c_h),
            -(1.0 / r_wh + 1.0 / r_ha) / c_h,
        );
        // In kelvin, not in rises.
        (
            matrix,
            Vector2::new(heat * (1.0 - copper(motor.reference) * motor.reference) / c_w, motor.ambient / (r_ha * c_h)),
        )
    }

    #[test]
    fn constant_heat_settles_where_the_steady_state_says() {
        let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
        for heat in [0.0, 1e-3, 30.0, 150.0, 0.999 * threshold(&MOTOR)] {
            let expected = thermal::winding_temperature(heat, 1.0, MOTOR.reference, r_th, MOTOR.ambient).unwrap();
            for (times, period) in [
                (vec![0.0], 1.0),
                (vec![3.0], 1e6),
                (grid(1000, 2.0), 2.0),
                (grid(7, 1e4), 1e4),
                (vec![0.0, 1e-9, 30.0], 1e3),
                (vec![0.0, 1.0, 1.0], 1.0),
            ] {
                let q = vec![heat; times.len()];
                let temperature = settled(&MOTOR, &Heat { times: &times, period_or_duration: period, heat: &q });
                assert_relative_eq!(temperature.peak, expected, max_relative = 1e-9);
                for (winding, housing) in temperature.winding.iter().zip(&temperature.housing) {
                    assert_relative_eq!(*winding, expected, max_relative = 1e-9);
                    let out = (housing - MOTOR.ambient) / MOTOR.resistance_housing_ambient;
                    let copper = heat * (1.0 + copper(MOTOR.reference) * (expected - MOTOR.reference));
                    assert_relative_eq!(out, copper, max_relative = 1e-6, epsilon = 1e-9);
                }
            }
        }
    }

    /// Sums of two exponentials, from the eigenvalues.
    #[test]
    fn a_step_of_heat_is_answered_by_two_exponentials() {
        for heat in [0.0, 40.0, 250.0, 600.0] {
            let (matrix, forcing) = equations(&MOTOR, heat);
            let steady = -matrix.try_inverse().unwrap() * forcing;
            let start = Vector2::repeat(MOTOR.ambient) - steady;
            let root = (0.25 * matrix.trace().powi(2) - matrix.determinant()).sqrt();
            let (fast, slow) = (0.5 * matrix.trace() - root, 0.5 * matrix.trace() + root);
            let identity = Matrix2::identity();
            let along_slow = (matrix - identity * fast) * start / (slow - fast);
            let along_fast = (matrix - identity * slow) * start / (fast - slow);
            let times = grid(40, 200.0);
            let q = vec![heat; times.len()];
            let temperature = MOTOR.from_cold(&Heat { times: &times, period_or_duration: 200.0, heat: &q });
            for (k, time) in times.iter().enumerate() {
                let expected = steady + along_slow * (slow * time).exp() + along_fast * (fast * time).exp();
                assert_relative_eq!(temperature.winding[k], expected[0], max_relative = 1e-11);
                assert_relative_eq!(temperature.housing[k], expected[1], max_relative = 1e-11);
            }
            let end = steady + along_slow * (slow * 200.0).exp() + along_fast * (fast * 200.0).exp();
            assert_relative_eq!(temperature.peak, end[0], max_relative = 1e-11);
            assert_eq!(temperature.peak_sample, if heat > 0.0 { 39 } else { 0 });
        }
    }

    #[test]
    fn a_hold_may_last_as_long_as_published() {
        // WE01: 10 A, and the hold with a ratio of 50, in 1 Ω. The published times are at constant resistance.
        assert_relative_eq!(HOLD.time_to_reach(398.15, 100.0, 0.0).unwrap(), 6.3, max_relative = 0.01);
        assert_relative_eq!(HOLD.time_to_reach(398.15, 100.0, 0.0).unwrap(), 6.3216, max_relative = 1e-5);
        let hold = 4.905_f64.powi(2);
        assert_relative_eq!(HOLD.time_to_reach(398.15, hold, 0.0).unwrap(), 32.2, max_relative = 0.002);
        assert_relative_eq!(HOLD.time_to_reach(398.15, hold, 0.0).unwrap(), 32.2347, max_relative = 1e-5);
        // A hardly resisting housing is a clamped one.
        let tiny = TwoNode { resistance_housing_ambient: 1e-9, ..HOLD };
        assert_relative_eq!(tiny.time_to_reach(398.15, hold, 0.0).unwrap(), 32.2347, max_relative = 1e-5);
    }

    #[test]
    fn one_node_has_a_closed_form_with_warm_copper() {
        let node = TwoNode { ambient: 310.0, ..HOLD };
        let source = 1.0 + copper(node.reference) * (node.ambient - node.reference);
        for heat in [20.0, 30.0, 1e3_f64.recip() / copper(298.15) * 100.0, 100.0, 1e5] {
            let a = copper(node.reference) * 10.0 * heat;
            let expected = if a == 1.0 {
                60.0 * 80.0 / (10.0 * heat * source)
            } else {
                -60.0 / (1.0 - a) * (-(1.0 - a) * 80.0 / (10.0 * heat * source)).ln_1p()
            };
            assert_relative_eq!(
                node.time_to_reach(390.0, heat, copper(node.reference)).unwrap(),
                expected,
                max_relative = 1e-12
            );
        }
    }

    #[test]
    fn two_nodes_reach_the_limit_at_the_time_given() {
        let mut rng = Pcg64::seed_from_u64(1);
        for _ in 0..200 {
            let motor = random_motor(&mut rng);
            let heat = rng.random_range(0.01..3.0) * threshold(&motor);
            let limit = motor.ambient + rng.random_range(1.0..150.0);
            let r_th = motor.resistance_winding_housing + motor.resistance_housing_ambient;
            let steady = thermal::winding_temperature(heat, 1.0, motor.reference, r_th, motor.ambient);
            let time = motor.time_to_reach(limit, heat, copper(motor.reference));
            assert_eq!(time.is_none(), steady.is_some_and(|steady| steady <= limit));
            if let Some(time) = time {
                let hold = Heat { times: &[0.0], period_or_duration: time, heat: &[heat] };
                assert_relative_eq!(motor.from_cold(&hold).peak, limit, max_relative = 1e-11);
            }
        }
        assert_eq!(MOTOR.time_to_reach(MOTOR.ambient - 1.0, 0.0, copper(MOTOR.reference)), Some(0.0));
        assert_eq!(MOTOR.time_to_reach(MOTOR.ambient + 1.0, 0.0, copper(MOTOR.reference)), None);
    }

    #[test]
    fn continuous_currents_of_measured_motors_lead_to_their_limit() {
        // WE18, with 0.00393 for copper: R_0, T_0 in °C, R_wh, R_ha, current.
        for (resistance, reference, r_wh, r_ha, current) in [
            (0.07, 21.993, 0.507863, 0.418284, 33.14_f64),
            (0.16, 22.492, 0.26492, 0.91028, 19.47),
            (0.2895, 28.596, 1.018737, 1.19668, 10.63),
            (0.3254982, 30.465, 0.364306, 1.53477, 10.86),
        ] {
            let motor = TwoNode {
                resistance_winding_housing: r_wh,
                resistance_housing_ambient: r_ha,
                reference: 273.15 + reference,
                ..MOTOR
            };
            // Theirs takes 0.00393 for the coefficient at each motor's own reference: the heat at 125 °C is what it gives.
            let theirs = 1.0 + 0.003_93 * (125.0 - reference);
            let heat = resistance * current * current * theirs / resistance_factor(398.15, motor.reference);
            let hold = Heat { times: &[0.0], period_or_duration: 1.0, heat: &[heat] };
            assert_relative_eq!(settled(&motor, &hold).peak, 398.15, epsilon = 0.8);
        }
    }

    /// Copper heat, heat to ambient \[J\] and change of what is stored \[J\] over the parts of a course, the
    /// integrals by Gauss' rule within each part: one quadrature for both.
    fn balance(motor: &TwoNode, heat: &Heat, course: Course, start: Rise) -> (f64, f64, f64) {
        let (outer, inner) = (
            (5.0_f64 + 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0,
            (5.0_f64 - 2.0 * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0,
        );
        let root = 13.0 * 70.0_f64.sqrt();
        let rule = [
            (0.0, 128.0 / 225.0),
            (inner, (322.0 + root) / 900.0),
            (-inner, (322.0 + root) / 900.0),
            (outer, (322.0 - root) / 900.0),
            (-outer, (322.0 - root) / 900.0),
        ];
        let rates = motor.rates(copper(motor.reference));
        let (mut rise, mut heat_in, mut heat_out) = (start, 0.0, 0.0);
        for part in heat.parts(course, motor.time_constant_winding) {
            for (at, weight) in rule {
                let x = rates.step(0.5 * (1.0 + at) * part.duration, part.heat).apply(rise);
                let weight = 0.5 * weight * part.duration;
                heat_in +=
                    weight * part.heat * (1.0 + copper(motor.reference) * (motor.ambient + x[0] - motor.reference));
                heat_out += weight * x[1] / motor.resistance_housing_ambient;
            }
            rise = rates.step(part.duration, part.heat).apply(rise);
        }
        let c_w = motor.time_constant_winding / motor.resistance_winding_housing;
        let c_h = motor.time_constant_housing / motor.resistance_housing_ambient;
        (heat_in, heat_out, c_w * (rise[0] - start[0]) + c_h * (rise[1] - start[1]))
    }

    #[test]
    fn heat_in_is_heat_out_and_heat_stored() {
        let mut rng = Pcg64::seed_from_u64(2);
        for round in 0..150 {
            let motor = random_motor(&mut rng);
            let samples = rng.random_range(1..60);
            let period = [0.5, 20.0, 700.0][round % 3];
            let (times, q) = random_course(&mut rng, samples, period, threshold(&motor));
            let heat = Heat { times: &times, period_or_duration: period, heat: &q };
            let (heat_in, heat_out, stored) = balance(&motor, &heat, Course::FromCold, [0.0; 2]);
            assert_relative_eq!(heat_in, heat_out + stored, max_relative = 1e-11, epsilon = 1e-11);
            let Outcome::Settles(temperature) = motor.periodic_state(&heat) else { continue };
            let start = [temperature.winding[0] - motor.ambient, temperature.housing[0] - motor.ambient];
            let (heat_in, heat_out, stored) = balance(&motor, &heat, Course::Periodic, start);
            assert_relative_eq!(heat_in, heat_out, max_relative = 1e-9);
            assert!(stored.abs() <= 1e-9 * heat_in);
        }
    }

    #[test]
    fn the_periodic_state_repeats_and_is_where_the_cold_start_ends_up() {
        let mut rng = Pcg64::seed_from_u64(3);
        for _ in 0..50 {
            let motor = random_motor(&mut rng);
            let (times, q) = random_course(&mut rng, 20, 30.0, threshold(&motor));
            let heat = Heat { times: &times, period_or_duration: 30.0, heat: &q };
            let Outcome::Settles(temperature) = motor.periodic_state(&heat) else { continue };
            let rates = motor.rates(copper(motor.reference));
            let start = [temperature.winding[0] - motor.ambient, temperature.housing[0] - motor.ambient];
            let mut rise = start;
            let mut period = Step::NOTHING;
            for part in heat.parts(Course::Periodic, motor.time_constant_winding) {
                let step = rates.step(part.duration, part.heat);
                rise = step.apply(rise);
                period = period.then(&step);
            }
            assert_relative_eq!(rise[0], start[0], max_relative = 1e-12, epsilon = 1e-11);
            assert_relative_eq!(rise[1], start[1], max_relative = 1e-12, epsilon = 1e-11);
            // 2⁴⁰ periods from cold.
            for _ in 0..40 {
                period = period.then(&period);
            }
            assert_relative_eq!(period.gain[0], start[0], max_relative = 1e-9, epsilon = 1e-9);
            assert_relative_eq!(period.gain[1], start[1], max_relative = 1e-9, epsilon = 1e-9);
        }
    }

    /// The map of a part is not negative, rises with heat and is log-convex in it, entry by entry; its
    /// derivative is the derivative.
    #[test]
    fn maps_are_positive_and_log_convex_in_heat() {
        let mut rng = Pcg64::seed_from_u64(4);
        let flat = |s: &Step| [s.change[0][0], s.change[0][1], s.change[1][0], s.change[1][1], s.gain[0], s.gain[1]];
        let entries = |s: &Step| {
            let [a, b, c, d, winding, housing] = flat(s);
            [1.0 + a, b, c, 1.0 + d, winding, housing]
        };
        for _ in 0..2000 {
            let motor = random_motor(&mut rng);
            let rates = motor.rates(copper(motor.reference));
            let duration = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-5.0..2.0));
            let most = threshold(&motor) * (1.0 + motor.time_constant_winding / duration).min(100.0);
            let (low, high) = (rng.random_range(0.0..most), rng.random_range(0.0..most));
            let (low, high) = (low.min(high), low.max(high));
            let middle = 0.5 * (low + high);
            let (at, slope) = rates.expand(duration, middle);
            let size = flat(&at);
            let (before, at, after) =
                (entries(&rates.step(duration, low)), entries(&at), entries(&rates.step(duration, high)));
            let slope = flat(&slope);
            let step = 1e-3 * middle / (1.0 + motor.rates(copper(motor.reference)).growth * middle * duration);
            let (less, more) = (flat(&rates.step(duration, middle - step)), flat(&rates.step(duration, middle + step)));
            for e in 0..6 {
                assert!(before[e] >= -1e-16 && before[e] <= at[e] * (1.0 + 1e-12) && at[e] <= after[e] * (1.0 + 1e-12));
                assert!(slope[e] >= -1e-14 * duration, "{slope:?}");
                if e < 4 {
                    assert!(at[e] * at[e] <= before[e] * after[e] * (1.0 + 1e-10) + 1e-30);
                } else {
                    assert!(at[e] <= 0.5 * (before[e] + after[e]) * (1.0 + 1e-12));
                }
                let difference = (more[e] - less[e]) / (2.0 * step);
                assert_relative_eq!(slope[e], difference, max_relative = 1e-5, epsilon = 1e-15 * size[e].abs() / step);
            }
        }
    }

    /// Against nalgebra's exponential of the equations in kelvin.
    #[test]
    fn maps_are_the_exponential() {
        let mut rng = Pcg64::seed_from_u64(5);
        for _ in 0..300 {
            let motor = random_motor(&mut rng);
            let duration = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-4.0..0.5));
            let heat = rng.random_range(0.0..2.0) * threshold(&motor);
            let (matrix, forcing) = equations(&motor, heat);
            let mut whole = nalgebra::Matrix3::zeros();
            whole.fixed_view_mut::<2, 2>(0, 0).copy_from(&matrix);
            whole.fixed_view_mut::<2, 1>(0, 2).copy_from(&forcing);
            let expected = (whole * duration).exp();
            let start = nalgebra::Vector3::new(350.0, 320.0, 1.0);
            let end = expected * start;
            let rise = motor
                .rates(copper(motor.reference))
                .step(duration, heat)
                .apply([350.0 - motor.ambient, 320.0 - motor.ambient]);
            assert_relative_eq!(rise[0] + motor.ambient, end[0], max_relative = 1e-12);
            assert_relative_eq!(rise[1] + motor.ambient, end[1], max_relative = 1e-12);
        }
    }

    #[test]
    fn the_gradient_is_the_difference_quotient() {
        let mut rng = Pcg64::seed_from_u64(6);
        for round in 0..60 {
            let motor = random_motor(&mut rng);
            let course = if round % 2 == 0 { Course::Periodic } else { Course::FromCold };
            let samples = [1, 2, 7, 25][round % 4];
            let period = motor.time_constant_winding * [0.05, 1.0, 30.0][round % 3];
            let (times, mut q) = random_course(&mut rng, samples, period, 0.8 * threshold(&motor));
            // Heat at which differences are not hidden by rounding.
            q.iter_mut().for_each(|q| *q += 0.01 * threshold(&motor));
            let heat = Heat { times: &times, period_or_duration: period, heat: &q };
            let temperature = match course {
                Course::Periodic => settled(&motor, &heat),
                Course::FromCold => motor.from_cold(&heat),
            };
            let gradient = motor.peak_gradient(&heat, course, &temperature);
            let scale = gradient.iter().copied().fold(0.0, f64::max);
            for k in 0..samples {
                assert!(gradient[k] >= 0.0);
                let moved = |by: f64| {
                    let mut moved = q.clone();
                    moved[k] += by;
                    peak(&motor, &Heat { heat: &moved, ..heat }, course)
                };
                let step = 1e-5 * threshold(&motor);
                // The peak may move from one step within its part to the next: a convex function's subgradient lies
                // between the differences to either side, which are close to each other.
                let here = moved(0.0);
                let (back, ahead) = ((here - moved(-step)) / step, (moved(step) - here) / step);
                let slack = 1e-5 * gradient[k] + 1e-6 * scale + 1e-11 / step * 200.0;
                assert!(gradient[k] >= back - slack && gradient[k] <= ahead + slack, "{back} {} {ahead}", gradient[k]);
                assert!(ahead - back <= 1e-2 * gradient[k] + slack, "{back} {ahead}");
            }
        }
    }

    #[test]
    fn a_clamped_housing_with_the_windings_time_constant_has_a_gradient() {
        // Double eigenvalue, no way back from the housing.
        let heat = Heat { times: &[0.0, 20.0, 50.0], period_or_duration: 90.0, heat: &[0.0, 12.0, 3.0] };
        let temperature = settled(&HOLD, &heat);
        let gradient = HOLD.peak_gradient(&heat, Course::Periodic, &temperature);
        for k in 0..3 {
            let moved = |by: f64| {
                let mut q = heat.heat.to_vec();
                q[k] += by;
                peak(&HOLD, &Heat { heat: &q, ..heat }, Course::Periodic)
            };
            let forward = (-3.0 * moved(0.0) + 4.0 * moved(1e-4) - moved(2e-4)) / 2e-4;
            assert_relative_eq!(gradient[k], forward, max_relative = 1e-6);
        }
        assert!(temperature.housing.iter().all(|housing| *housing == HOLD.ambient));
    }

    #[test]
    fn the_peak_is_convex_and_above_its_cuts() {
        let mut rng = Pcg64::seed_from_u64(7);
        let mut settling = 0;
        for round in 0..400 {
            let motor = random_motor(&mut rng);
            let course = if round % 2 == 0 { Course::Periodic } else { Course::FromCold };
            let samples = rng.random_range(1..12);
            let period = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-2.0..1.5));
            let most = rng.random_range(0.1..4.0) * threshold(&motor);
            let (times, here) = random_course(&mut rng, samples, period, most);
            let heat = Heat { times: &times, period_or_duration: period, heat: &here };
            let there = random_heat(&mut rng, samples, most);
            let middle: Vec<f64> = here.iter().zip(&there).map(|(a, b)| 0.5 * (a + b)).collect();
            let temperature = match course {
                Course::Periodic => match motor.periodic_state(&heat) {
                    Outcome::Settles(temperature) => temperature,
                    Outcome::Runaway => continue,
                },
                Course::FromCold => motor.from_cold(&heat),
            };
            let gradient = motor.peak_gradient(&heat, course, &temperature);
            let height = peak(&motor, &Heat { heat: &there, ..heat }, course);
            let between = peak(&motor, &Heat { heat: &middle, ..heat }, course);
            assert!(between <= 0.5 * (temperature.peak + height) * (1.0 + 1e-12));
            let cut: f64 = gradient.iter().zip(&here).zip(&there).map(|((g, a), b)| g * (b - a)).sum();
            let size: f64 = gradient.iter().zip(&here).zip(&there).map(|((g, a), b)| g * (b - a).abs()).sum();
            assert!(height >= temperature.peak + cut - 1e-10 * (size + height), "{height} {} {cut}", temperature.peak);
            // More heat nowhere cools.
            let more: Vec<f64> = here.iter().zip(&there).map(|(a, b)| a.max(*b)).collect();
            assert!(peak(&motor, &Heat { heat: &more, ..heat }, course) >= temperature.peak * (1.0 - 1e-12));
            settling += usize::from(height.is_finite());
        }
        assert!(settling > 150);
    }

    /// Scale of heat at which a motion begins to run away.
    fn begins_to_run_away(motor: &TwoNode, heat: &Heat) -> f64 {
        let (mut low, mut high) = (0.0, 100.0 * threshold(motor));
        while high - low > 1e-15 * high {
            let scale = 0.5 * (low + high);
            let q: Vec<f64> = heat.heat.iter().map(|q| scale * q).collect();
            match motor.periodic_state(&Heat { heat: &q, ..*heat }) {
                Outcome::Settles(_) if scale > low => low = scale,
                Outcome::Runaway if scale < high => high = scale,
                _ => break,
            }
        }
        0.5 * (low + high)
    }

    #[test]
    fn runaway_begins_where_the_spectral_radius_is_one() {
        let mut rng = Pcg64::seed_from_u64(8);
        for _ in 0..30 {
            let motor = random_motor(&mut rng);
            let period = motor.time_constant_winding * 10.0_f64.powf(rng.random_range(-2.0..1.0));
            let (times, mut q) = random_course(&mut rng, 9, period, 1.0);
            q[4] += 0.1;
            let heat = Heat { times: &times, period_or_duration: period, heat: &q };
            let scale = begins_to_run_away(&motor, &heat);
            // The same parts, with another exponential.
            let radius = |scale: f64| {
                let map =
                    heat.parts(Course::Periodic, motor.time_constant_winding).fold(Matrix2::identity(), |map, part| {
                        (equations(&motor, scale * part.heat).0 * part.duration).exp() * map
                    });
                spectral_radius(&map)
            };
            assert_relative_eq!(radius(scale), 1.0, max_relative = 1e-11);
            assert!(radius(0.999 * scale) < 1.0 && radius(1.001 * scale) > 1.0);
            let mean = mean_heat(&heat);
            assert!(scale * mean <= threshold(&motor) * (1.0 + 1e-9), "the test on averages is necessary");
        }
    }

    fn mean_heat(heat: &Heat) -> f64 {
        let parts = heat.parts(Course::Periodic, 1.0);
        parts.map(|part| part.duration * part.heat).sum::<f64>() / heat.period_or_duration
    }

    #[test]
    fn constant_heat_runs_away_exactly_at_the_threshold() {
        for samples in [1, 2, 100] {
            let (times, q) = (grid(samples, 10.0), vec![1.0; samples]);
            let heat = Heat { times: &times, period_or_duration: 10.0, heat: &q };
            assert_relative_eq!(begins_to_run_away(&MOTOR, &heat), threshold(&MOTOR), max_relative = 1e-11);
        }
    }

    #[test]
    fn pulses_run_away_though_their_mean_would_not() {
        // Ten seconds out of 200 at 17 times the heat of the threshold: 85 % of it on average.
        let pulse = 17.0 * threshold(&MOTOR);
        let times = [0.0, 0.01, 10.0, 10.01];
        let heat = Heat { times: &times, period_or_duration: 200.0, heat: &[0.0, pulse, pulse, 0.0] };
        let mean = mean_heat(&heat);
        assert_relative_eq!(mean, 0.85 * threshold(&MOTOR), max_relative = 2e-3);
        let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
        let averaged = thermal::winding_temperature(mean, 1.0, MOTOR.reference, r_th, MOTOR.ambient);
        assert!(averaged.is_some(), "the mean settles");
        assert_eq!(MOTOR.periodic_state(&heat), Outcome::Runaway);
        // As an independent integration sees: each period is hotter than the last by a growing amount.
        let mut x = Vector2::new(0.0, 0.0);
        let mut ends = vec![0.0];
        for _ in 0..8 {
            for (from, until, q) in [(0.0, 10.005, pulse), (10.005, 200.0, 0.0)] {
                let steps = 4000;
                let h = (until - from) / f64::from(steps);
                let (matrix, forcing) = equations(&MOTOR, q);
                let forcing = forcing + matrix * Vector2::repeat(MOTOR.ambient);
                for _ in 0..steps {
                    let k1 = matrix * x + forcing;
                    let k2 = matrix * (x + k1 * (0.5 * h)) + forcing;
                    let k3 = matrix * (x + k2 * (0.5 * h)) + forcing;
                    let k4 = matrix * (x + k3 * h) + forcing;
                    x += (k1 + (k2 + k3) * 2.0 + k4) * (h / 6.0);
                }
            }
            ends.push(x[0]);
        }
        let rises: Vec<f64> = ends.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(rises[1..].windows(2).all(|pair| pair[1] > 1.01 * pair[0]), "{rises:?}");
    }

    #[test]
    fn parts_converge_in_second_order() {
        let motor = TwoNode { time_constant_housing: 200.0, ..MOTOR };
        let period = motor.time_constant_winding;
        let first = |samples: usize| {
            let times = grid(samples, period);
            let phase = |t: &f64| (std::f64::consts::TAU * t / period).sin();
            let q: Vec<f64> = times.iter().map(|t| 150.0 * phase(t).powi(2) * (1.0 + 0.5 * phase(t))).collect();
            settled(&motor, &Heat { times: &times, period_or_duration: period, heat: &q }).winding[0]
        };
        let exact = first(65536);
        let errors: Vec<f64> = [32, 64, 128, 256].iter().map(|samples| (first(*samples) - exact).abs()).collect();
        for pair in errors.windows(2) {
            assert!((pair[0] / pair[1]).log2() > 1.9, "{errors:?}");
        }
    }

    #[test]
    fn long_intervals_are_close_to_the_course_they_stand_for() {
        // Piecewise linear heat in intervals of up to 6 τ_w, and the same course in 60000 samples.
        let (times, q) = ([0.0, 30.0, 330.0, 500.0], [20.0, 200.0, 100.0, 0.0]);
        let coarse = settled(&MOTOR, &Heat { times: &times, period_or_duration: 600.0, heat: &q });
        let fine_times = grid(60000, 600.0);
        let fine_heat: Vec<f64> = fine_times
            .iter()
            .map(|t| {
                let k = times.iter().rposition(|s| s <= t).unwrap();
                let until = times.get(k + 1).copied().unwrap_or(600.0);
                q[k] + (q[(k + 1) % 4] - q[k]) * (t - times[k]) / (until - times[k])
            })
            .collect();
        let fine = settled(&MOTOR, &Heat { times: &fine_times, period_or_duration: 600.0, heat: &fine_heat });
        assert!((coarse.winding[0] - fine.winding[0]).abs() < 0.02);
        assert!((coarse.winding[2] - fine.winding[3 * 11000]).abs() < 0.02);
        // The peak lies between samples and is seen.
        assert!((coarse.peak - fine.peak).abs() < 0.05 && coarse.peak > coarse.winding[1] + 5.0);
        assert_eq!(coarse.peak_sample, 1);
    }

    #[test]
    fn intervals_of_thousands_of_time_constants_follow_their_heat() {
        let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
        let (times, q) = ([0.0, 1e7, 2e7, 3e7], [10.0, 100.0, 100.0, 40.0]);
        let heat = Heat { times: &times, period_or_duration: 4e7, heat: &q };
        let temperature = settled(&MOTOR, &heat);
        for (winding, q) in temperature.winding.iter().zip(q) {
            let steady = thermal::winding_temperature(q, 1.0, MOTOR.reference, r_th, MOTOR.ambient).unwrap();
            assert_relative_eq!(*winding, steady, epsilon = 0.5);
        }
        let steady = thermal::winding_temperature(100.0, 1.0, MOTOR.reference, r_th, MOTOR.ambient).unwrap();
        assert_relative_eq!(temperature.peak, steady, max_relative = 1e-9);
    }

    #[test]
    fn no_heat_is_ambient() {
        for (times, period) in [(vec![0.0], 1.0), (grid(10, 5.0), 5.0), (grid(3, 1e5), 1e5)] {
            let q = vec![0.0; times.len()];
            let heat = Heat { times: &times, period_or_duration: period, heat: &q };
            for temperature in [settled(&MOTOR, &heat), MOTOR.from_cold(&heat)] {
                assert!(temperature.winding.iter().chain(&temperature.housing).all(|t| *t == MOTOR.ambient));
                assert_eq!((temperature.peak, temperature.peak_sample), (MOTOR.ambient, 0));
            }
            // The first watt heats as much as the thermal resistance, on average over the period.
            let temperature = settled(&MOTOR, &heat);
            let gradient = MOTOR.peak_gradient(&heat, Course::Periodic, &temperature);
            let r_th = MOTOR.resistance_winding_housing + MOTOR.resistance_housing_ambient;
            let expected = r_th * (1.0 + copper(MOTOR.reference) * (MOTOR.ambient - MOTOR.reference));
            assert_relative_eq!(gradient.iter().sum::<f64>(), expected, max_relative = 1e-9);
        }
    }

    #[test]
    fn a_motion_from_cold_counts_its_end() {
        // Samples up to the end, or the last held.
        let to_the_end = MOTOR.from_cold(&Heat { times: &[0.0, 5.0], period_or_duration: 5.0, heat: &[50.0, 50.0] });
        let held = MOTOR.from_cold(&Heat { times: &[0.0], period_or_duration: 5.0, heat: &[50.0] });
        assert_relative_eq!(to_the_end.peak, held.peak, max_relative = 1e-14);
        assert_eq!((to_the_end.peak, held.winding.len()), (to_the_end.winding[1], 1));
        assert!(held.peak > held.winding[0]);
    }

    #[test]
    fn heat_beyond_numbers_is_infinitely_hot() {
        let heat = Heat { times: &[0.0, 500.0], period_or_duration: 1000.0, heat: &[1e9, 1e9] };
        assert_eq!(MOTOR.from_cold(&heat).peak, f64::INFINITY);
        assert_eq!(MOTOR.periodic_state(&heat), Outcome::Runaway);
    }

    #[test]
    fn a_few_periods_from_cold_cut_off_what_runs_away() {
        let q = [1.3 * threshold(&MOTOR)];
        let heat = Heat { times: &[0.0], period_or_duration: 1500.0, heat: &q };
        let limit = 398.15;
        let cold = MOTOR.from_cold(&heat);
        let gradient = MOTOR.peak_gradient(&heat, Course::FromCold, &cold);
        // T(q) + g (q' − q) ≤ limit admits every q' that settles below the limit, and not q.
        let cut = q[0] + (limit - cold.peak) / gradient[0];
        assert!(cold.peak > limit && cut < q[0]);
        let allowed = thermal::allowed_current_squared(limit, 1.0, MOTOR.reference, 0.507863 + 0.418284, MOTOR.ambient);
        assert!(cut >= allowed);
    }
}
