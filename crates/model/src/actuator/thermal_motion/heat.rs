//! Heat over a motion, and the parts of time in which it is held constant.

/// Parts of an interval per winding time constant.
pub(super) const PARTS_PER_TIME_CONSTANT: f64 = 16.0;

/// Most parts of one interval. Beyond 16 τ_w the parts grow: a winding that has forgotten follows its
/// heat.
pub(super) const MOST_PARTS: f64 = 256.0;

/// Most parts of a motion of many intervals: those of its intervals are fewer then, down to [`FEWEST_PARTS`]. The largest
/// rise then has an error of up to 2e-5.
pub(super) const ALL_PARTS: f64 = 16_384.0;

/// Most parts of an interval in a motion of very many.
pub(super) const FEWEST_PARTS: f64 = 16.0;

/// Parts shorter than this share of the winding's time constant are held at one heat.
pub(super) const SHORT: f64 = 1.0 / 1024.0;

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
    /// Samples from which on to the next the temperature only finds its way and no peak counts; empty for none.
    pub settling: &'a [bool],
    /// Three times the heat of the hottest phase at the samples \[W\], from q_k to 2 q_k; empty where the phases share the heat alike.
    pub phase: &'a [f64],
}

impl Heat<'_> {
    /// Whether the peak may lie in a part.
    pub(super) fn counts(&self, part: &Part) -> bool {
        !self.settling.get(part.sample).copied().unwrap_or(false)
    }
}

/// A time of constant heat: a part, or half of one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// The sample before it.
    pub(super) sample: usize,
    /// The sample after it, whose heat counts as well.
    pub(super) next: usize,
    /// Share of the next sample in the heat.
    pub(super) share: f64,
    /// Whether it starts at the sample.
    pub(super) first: bool,
    /// How long it is \[s\].
    pub(super) duration: f64,
    /// Its heat \[W\].
    pub(super) heat: f64,
    /// The whole part, where it starts with this: shares of the next sample at its ends, and how long it is \[s\].
    pub(super) whole: Option<([f64; 2], f64)>,
}

impl<'a> Heat<'a> {
    /// The parts of constant heat, in the order of time.
    pub(super) fn parts(self, course: Course, time_constant: f64) -> impl Iterator<Item = Part> + 'a {
        let Heat { times, period_or_duration, heat, .. } = self;
        assert!(!times.is_empty() && times.len() == heat.len(), "one value of heat for each of at least one sample");
        debug_assert!(heat.iter().all(|q| *q >= 0.0), "copper heat is not negative");
        debug_assert!(times.is_sorted(), "times increase");
        let last = times.len() - 1;
        let end = times[0] + period_or_duration;
        let most = (ALL_PARTS / times.len() as f64).clamp(FEWEST_PARTS, MOST_PARTS);
        (0..=last).flat_map(move |sample| {
            let next = match course {
                _ if sample < last => sample + 1,
                Course::Periodic => 0,
                Course::FromCold => last,
            };
            let until = if sample < last { times[sample + 1] } else { end };
            let interval = (until - times[sample]).max(0.0);
            let parts = interval * (PARTS_PER_TIME_CONSTANT / time_constant);
            let count = if parts <= 1.0 { 1 } else { parts.ceil().min(most) as u32 };
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
    pub(super) fn between(&self, part: &Part, share: f64) -> f64 {
        (1.0 - share) * self.heat[part.sample] + share * self.heat[part.next]
    }

    /// Heat of the hottest phase between two samples, times three \[W\].
    pub(super) fn phase_between(&self, part: &Part, share: f64) -> f64 {
        (1.0 - share) * self.phase[part.sample] + share * self.phase[part.next]
    }

    /// The steps within a part that starts at `part`: shares of the next sample at both ends, and the share at
    /// which the heat is larger.
    pub(super) fn steps_within(&self, part: &Part, [from, to]: [f64; 2], count: usize) -> impl Iterator<Item = f64> {
        let (falls, step) = (self.between(part, from) >= self.between(part, to), (to - from) / count as f64);
        (0..count).map(move |k| from + step * (k + usize::from(!falls)) as f64)
    }
}
