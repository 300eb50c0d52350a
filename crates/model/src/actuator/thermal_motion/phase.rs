//! Temperature of the hottest phase.
//!
//! At standstill one phase carries two thirds of the heat instead of a third. With three times the winding's resistance to the housing and a
//! third of its capacity each phase is a node of its own,
//!
//! ```text
//! C_w dT_p/dt = q_p(t) (1 + α (T_p − T_0)) − (T_p − T_h)/R_wh        q_p = (1 + s) q
//! ```
//!
//! with s from 0 (turning) to 1 (standing) and the housing's temperature that of the two nodes, as all three phases together heat it. Both
//! heats are on the diagonal and no coupling is negative, so that T_p is log-convex in the course of q and q_p. Parts, halves and the
//! bound between the ends of a part are those of the winding; each step is exact.

use super::heat::{Course, Heat, Part};
use super::peak::Watt;
use super::step::{PHI, Rates, Rise, Step, times};

/// The map `z ↦ z + change·(winding, housing, z) + gain` of the phase's rise over a time, or its derivative.
#[derive(Debug, Clone, Copy)]
struct PhaseStep {
    change: [f64; 3],
    /// Rise that heat adds to no rise \[K\].
    gain: f64,
}

/// Interval of constant heats: shares of the next sample in the winding's and in the phase's heat, and duration \[s\].
#[derive(Debug, Clone, Copy)]
struct Hold {
    shares: [f64; 2],
    duration: f64,
}

/// Interval of constant heat with its steps, and the rise per watt.
struct PhaseWatt {
    part: Part,
    shares: [f64; 2],
    winding: Step,
    phase: PhaseStep,
    /// Rise of winding and housing at its end per watt of mean heat \[K/W\].
    per_watt: Rise,
    /// Rise of the phase at its end per watt of mean heat and of the phase's own \[K/W\].
    phase_per_watt: [f64; 2],
}

/// Rise of the hottest phase over a motion.
#[derive(Debug, Clone)]
pub(super) struct PhaseRise {
    /// At the start of each part, and at the end \[K\].
    pub(super) rises: Vec<f64>,
    /// Largest rise that counts \[K\].
    pub(super) peak: f64,
    /// The part at whose start or within which it is; one more than there are at the end.
    pub(super) node: usize,
    /// Number of steps within the part before it.
    steps: usize,
    /// The sample that it belongs to.
    pub(super) sample: usize,
}

impl PhaseStep {
    const NOTHING: PhaseStep = PhaseStep { change: [0.0; 3], gain: 0.0 };

    fn apply(&self, rise: Rise, own: f64) -> f64 {
        own + self.added(rise, own)
    }

    fn added(&self, [winding, housing]: Rise, own: f64) -> f64 {
        let [by_winding, by_housing, by_own] = self.change;
        by_winding * winding + by_housing * housing + by_own * own + self.gain
    }

    /// Rise at the end of no rise of its own \[K\].
    fn fed(&self, rise: Rise) -> f64 {
        self.apply(rise, 0.0)
    }

    fn decay(&self) -> f64 {
        1.0 + self.change[2]
    }

    /// This step taken twice, with a step of winding and housing beside it.
    fn twice(&self, two: &Step) -> PhaseStep {
        let [w, h, own] = self.change;
        let [[ww, wh], [hw, hh]] = two.change;
        PhaseStep {
            change: [2.0 * w + w * ww + h * hw + own * w, 2.0 * h + w * wh + h * hh + own * h, (2.0 + own) * own],
            gain: 2.0 * self.gain + w * two.gain[0] + h * two.gain[1] + own * self.gain,
        }
    }

    /// Derivative of this step taken twice.
    fn twice_slope(&self, slope: &PhaseStep, two: &Step, two_slope: &Step) -> PhaseStep {
        let ([w, h, own], [dw, dh, down]) = (self.change, slope.change);
        let ([[ww, wh], [hw, hh]], [[dww, dwh], [dhw, dhh]]) = (two.change, two_slope.change);
        PhaseStep {
            change: [
                2.0 * dw + (dw * ww + w * dww) + (dh * hw + h * dhw) + (down * w + own * dw),
                2.0 * dh + (dw * wh + w * dwh) + (dh * hh + h * dhh) + (down * h + own * dh),
                2.0 * (1.0 + own) * down,
            ],
            gain: 2.0 * slope.gain
                + (dw * two.gain[0] + w * two_slope.gain[0])
                + (dh * two.gain[1] + h * two_slope.gain[1])
                + (down * self.gain + own * slope.gain),
        }
    }
}

impl Rates {
    /// The step of the phase over a time \[s\] at constant heats of the winding and of the phase \[W\].
    fn phase_step(&self, duration: f64, heats: [f64; 2]) -> PhaseStep {
        self.expand_phase::<false>(duration, heats).0
    }

    /// The step of the phase over a time \[s\] at constant heats of the winding and of the phase \[W\], and with `SLOPES` its derivatives by
    /// both.
    fn expand_phase<const SLOPES: bool>(&self, duration: f64, [heat, own]: [f64; 2]) -> (PhaseStep, [PhaseStep; 2]) {
        let stiffness = 2.0 * (self.winding + self.housing) + self.ambient + self.growth * own.max(heat);
        let size = duration * stiffness;
        if size <= 1.0 / 512.0 {
            return self.phase_series::<5, SLOPES>(duration, [heat, own]);
        }
        let (mut part, mut doublings) = (1.0, 0);
        while size * part > 0.25 && doublings < 1000 {
            part *= 0.5;
            doublings += 1;
        }
        let (mut two, mut two_slope) = self.series::<12>(duration * part, heat);
        let (mut step, mut slopes) = self.phase_series::<12, SLOPES>(duration * part, [heat, own]);
        for _ in 0..doublings {
            if SLOPES {
                slopes = [
                    step.twice_slope(&slopes[0], &two, &two_slope),
                    step.twice_slope(&slopes[1], &two, &Step::NOTHING),
                ];
                two_slope = two.twice_slope(&two_slope);
            }
            step = step.twice(&two);
            two = two.then(&two);
        }
        (step, slopes)
    }

    /// The first terms of the series: the row of the phase of `e^B − I` and of `h φ(B) b`, with B of winding, housing and phase.
    #[inline(always)]
    fn phase_series<const TERMS: usize, const SLOPES: bool>(
        &self,
        h: f64,
        [heat, own]: [f64; 2],
    ) -> (PhaseStep, [PhaseStep; 2]) {
        let Rates { winding, housing, ambient, growth, source } = *self;
        let (ww, wh, hw, hh) = (h * (growth * heat - winding), h * winding, h * housing, -h * (housing + ambient));
        let (ph, pp, grows) = (h * winding, h * (growth * own - winding), h * growth);
        let next = |[w, h, p]: [f64; 3]| [w * ww + h * hw, w * wh + h * hh + p * ph, p * pp];
        let (mut row, mut by_heat, mut by_own) = ([0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]);
        let (mut step, mut slopes) = (PhaseStep::NOTHING, [PhaseStep::NOTHING; 2]);
        for inverse in &PHI[..TERMS] {
            // The row of Bⁿ; the coefficient is 1/(n + 1)!.
            let of_gain = h * source * inverse;
            step.gain += of_gain * (row[0] * heat + row[2] * own);
            if SLOPES {
                slopes[0].gain += of_gain * (row[0] + by_heat[0] * heat + by_heat[2] * own);
                slopes[1].gain += of_gain * (row[2] + by_own[0] * heat + by_own[2] * own);
                let (heats, owns) = (next(by_heat), next(by_own));
                by_heat = [heats[0] + row[0] * grows, heats[1], heats[2]];
                by_own = [owns[0], owns[1], owns[2] + row[2] * grows];
            }
            row = next(row);
            for i in 0..3 {
                step.change[i] += row[i] * inverse;
                if SLOPES {
                    slopes[0].change[i] += by_heat[i] * inverse;
                    slopes[1].change[i] += by_own[i] * inverse;
                }
            }
        }
        (step, slopes)
    }

    /// The rise of the hottest phase over a motion whose parts start with these rises of winding and housing; `None` where a motion that
    /// repeats runs away.
    pub(super) fn phase(&self, heat: &Heat, course: Course, nodes: &[(Part, Rise)]) -> Option<PhaseRise> {
        let over = |(part, rise): &(Part, Rise)| {
            let step = self.phase_step(part.duration, [part.heat, heat.phase_between(part, part.share)]);
            (step.decay(), step.fed(*rise))
        };
        let steps: Vec<(f64, f64)> = nodes.iter().map(over).collect();
        let start = match course {
            Course::FromCold => 0.0,
            Course::Periodic => {
                let (decay, gain) =
                    steps.iter().fold((1.0, 0.0), |(d, g), (decay, gain)| (d * decay, decay * g + gain));
                if decay >= 1.0 {
                    return None;
                }
                gain / (1.0 - decay)
            }
        };
        let mut rises = vec![start];
        for (decay, gain) in &steps {
            rises.push(decay * rises[rises.len() - 1] + gain);
        }
        let number = |rise: f64| if rise.is_finite() { rise } else { f64::INFINITY };
        let mut all = PhaseRise { peak: f64::NEG_INFINITY, node: 0, steps: 0, sample: 0, rises };
        // The moment between the halves of a part is not one of the motion.
        let counts = |part: &Part| part.whole.is_some() && heat.counts(part);
        for (node, (part, _)) in nodes.iter().enumerate().filter(|(_, (part, _))| counts(part)) {
            if number(all.rises[node]) > all.peak {
                (all.peak, all.node, all.sample) = (number(all.rises[node]), node, part.sample);
            }
        }
        if course == Course::FromCold && number(all.rises[nodes.len()]) > all.peak {
            let (node, sample) = (nodes.len(), heat.times.len() - 1);
            (all.peak, all.node, all.sample) = (number(all.rises[node]), node, sample);
        }
        for (node, (part, rise)) in nodes.iter().enumerate().filter(|(_, (part, _))| counts(part)) {
            self.phase_within(heat, node, part, *rise, &mut all);
        }
        Some(all)
    }

    /// Steps within a part that starts at `part`, each at the larger of the heats at its ends.
    fn holds_within(
        &self,
        heat: &Heat,
        part: &Part,
        [from, to]: [f64; 2],
        duration: f64,
    ) -> impl Iterator<Item = Hold> {
        let count = self.steps_within(duration);
        let step = (to - from) / count as f64;
        let falls = [heat.between(part, from) >= heat.between(part, to), {
            heat.phase_between(part, from) >= heat.phase_between(part, to)
        }];
        let share = move |k: usize, falls: bool| from + step * (k + usize::from(!falls)) as f64;
        let duration = duration / count as f64;
        (0..count).map(move |k| Hold { shares: falls.map(|falls| share(k, falls)), duration })
    }

    /// Raise the peak to the largest rise of the phase within a part (an upper bound), if that is larger.
    fn phase_within(&self, heat: &Heat, node: usize, part: &Part, start: Rise, all: &mut PhaseRise) {
        let Some((shares, duration)) = part.whole.filter(|_| all.peak < f64::INFINITY) else { return };
        let ends = shares.map(|share| [heat.between(part, share), heat.phase_between(part, share)]);
        if ends[0] == ends[1] || duration == 0.0 {
            return;
        }
        // The hottest node is warmed by no more than the largest heat.
        let most = ends.iter().flatten().copied().fold(0.0, f64::max);
        let (hottest, own) = (start[0].max(start[1]).max(all.rises[node]), duration * self.growth * most);
        if own < 0.5 && (hottest + duration * self.source * most) / (1.0 - own) <= all.peak {
            return;
        }
        let (mut rise, mut phase) = (start, all.rises[node]);
        for (k, hold) in self.holds_within(heat, part, shares, duration).enumerate() {
            let heats = hold.heats(heat, part);
            phase = self.phase_step(hold.duration, heats).apply(rise, phase);
            rise = self.step(hold.duration, heats[0]).apply(rise);
            if phase > all.peak {
                (all.peak, all.node, all.steps, all.sample) = (phase, node, k + 1, part.sample);
            }
        }
    }

    fn phase_watt(&self, heat: &Heat, part: Part, hold: Hold, before: (Rise, f64)) -> PhaseWatt {
        let heats = hold.heats(heat, &part);
        let (winding, slope) = self.expand(hold.duration, heats[0]);
        let (phase, slopes) = self.expand_phase::<true>(hold.duration, heats);
        let by_change = times(&slope.change, before.0);
        PhaseWatt {
            part,
            shares: hold.shares,
            winding,
            phase,
            per_watt: [by_change[0] + slope.gain[0], by_change[1] + slope.gain[1]],
            phase_per_watt: slopes.map(|slope| slope.added(before.0, before.1)),
        }
    }

    /// Derivative of a rise of the hottest phase by the heat of every entry, through the winding's mean heat and through the phase's own
    /// \[K/W\].
    pub(super) fn phase_gradient(
        &self,
        heat: &Heat,
        course: Course,
        nodes: &[Watt],
        phase: &PhaseRise,
    ) -> [Vec<f64>; 2] {
        let all: Vec<PhaseWatt> = nodes
            .iter()
            .zip(&phase.rises)
            .map(|(node, own)| {
                let hold = Hold { shares: [node.part.share; 2], duration: node.part.duration };
                self.phase_watt(heat, node.part, hold, (node.before, *own))
            })
            .collect();
        let mut within = Vec::new();
        if let (true, Some(Watt { part, before, .. })) = (phase.steps > 0, nodes.get(phase.node))
            && let Some((shares, duration)) = part.whole
        {
            let (mut rise, mut own) = (*before, phase.rises[phase.node]);
            for hold in self.holds_within(heat, part, shares, duration).take(phase.steps) {
                let watt = self.phase_watt(heat, *part, hold, (rise, own));
                (rise, own) = (watt.winding.apply(rise), watt.phase.apply(rise, own));
                within.push(watt);
            }
        }
        let mut gradient = [vec![0.0; heat.times.len()], vec![0.0; heat.times.len()]];
        // Backwards through time; the row is the derivative by the rises of phase, winding and housing at a node.
        let mut back = |(mut own, mut row): (f64, Rise), steps: &[PhaseWatt], counts: bool| {
            for PhaseWatt { part, shares, winding, phase, per_watt, phase_per_watt } in steps.iter().rev() {
                if counts {
                    let mean = row[0] * per_watt[0] + row[1] * per_watt[1] + own * phase_per_watt[0];
                    for ((gradient, slope), share) in
                        gradient.iter_mut().zip([mean, own * phase_per_watt[1]]).zip(shares)
                    {
                        gradient[part.sample] += (1.0 - share) * slope;
                        gradient[part.next] += share * slope;
                    }
                }
                row = winding.pull(row);
                row = [row[0] + own * phase.change[0], row[1] + own * phase.change[1]];
                own *= phase.decay();
            }
            (own, row)
        };
        let (before, after) = all.split_at(phase.node);
        let mut row = back((1.0, [0.0; 2]), &within, true);
        if course == Course::Periodic {
            let period = nodes.iter().fold(Step::NOTHING, |period, node| period.then(&node.step));
            let [to_winding, to_housing] = period.sum_of_powers().expect("this heat settles");
            let once = back(row, before, false);
            let (decay, through) = back((1.0, [0.0; 2]), &all, false);
            // The row of all earlier periods, λ (I − M)⁻¹ with the map M of a period on phase, winding and housing.
            let own = once.0 / (1.0 - decay);
            let rest = [once.1[0] + own * through[0], once.1[1] + own * through[1]];
            let every = [0, 1].map(|node| rest[0] * to_winding[node] + rest[1] * to_housing[node]);
            let later = back((own, every), after, true);
            row = (row.0 + later.0, [row.1[0] + later.1[0], row.1[1] + later.1[1]]);
        }
        back(row, before, true);
        gradient
    }
}

impl Hold {
    /// Heat of the winding and of its hottest phase \[W\].
    fn heats(&self, heat: &Heat, part: &Part) -> [f64; 2] {
        let [of_winding, of_phase] = self.shares;
        [heat.between(part, of_winding), heat.phase_between(part, of_phase)]
    }
}
