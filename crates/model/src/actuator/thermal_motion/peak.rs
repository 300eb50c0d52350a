//! Where the winding is hottest, at the ends of parts and between them.

use super::heat::{Course, Heat, Part};
use super::step::{Rates, Rise, Step, times};

/// Steps per winding time constant in which a part is gone through between its ends.
pub(super) const STEPS_PER_TIME_CONSTANT: f64 = 4096.0;

/// Fewest and most of these steps.
pub(super) const STEPS_WITHIN: (f64, f64) = (4.0, 256.0);

/// Where the winding is hottest: in a part, after so many of the steps within it; none is its start.
#[derive(Debug, Clone, Copy)]
pub(super) struct Within {
    pub(super) rise: f64,
    pub(super) steps: usize,
    /// Whether that is the sample after it.
    pub(super) ends: bool,
}

/// The largest rise of the winding over a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peak {
    pub(super) rise: f64,
    /// The sample at which, or in the interval after which, it is reached.
    pub(super) sample: usize,
    /// The part that it lies in or at the start of; one more than there are where it is the end.
    pub(super) node: usize,
    /// After so many of the steps within the part.
    pub(super) steps: usize,
}

impl Rates {
    /// In how many steps a part of a length \[s\] is gone through: depends on times only.
    pub(super) fn steps_within(&self, duration: f64) -> usize {
        let (fewest, most) = STEPS_WITHIN;
        (STEPS_PER_TIME_CONSTANT * self.winding * duration).ceil().clamp(fewest, most) as usize
    }

    /// The largest rise of the winding, from the rises at the start of each part and that at the end. Ends of parts come
    /// first: within most parts nothing can be above the highest of them.
    pub(super) fn peak(
        &self,
        heat: &Heat,
        course: Course,
        nodes: impl Iterator<Item = (Part, Rise)> + Clone,
        end: Rise,
    ) -> Peak {
        // What left all numbers is hotter than any.
        let number = |rise: f64| if rise.is_finite() { rise } else { f64::INFINITY };
        let mut peak = Peak { rise: f64::NEG_INFINITY, sample: 0, node: 0, steps: 0 };
        let mut count = 0;
        for (node, (part, rise)) in nodes.clone().enumerate() {
            count += 1;
            if part.whole.is_some() && heat.counts(&part) && number(rise[0]) > peak.rise {
                peak = Peak { rise: number(rise[0]), sample: part.sample, node, steps: 0 };
            }
        }
        // The end of a period is its start.
        if course == Course::FromCold && number(end[0]) > peak.rise {
            peak = Peak { rise: number(end[0]), sample: heat.times.len() - 1, node: count, steps: 0 };
        }
        for (node, (part, rise)) in nodes.enumerate().filter(|(_, (part, _))| heat.counts(part)) {
            if let Some(Within { rise, steps, ends }) = self.highest_within(heat, &part, rise, peak.rise) {
                peak = Peak { rise, sample: if ends { part.next } else { part.sample }, node, steps };
            }
        }
        peak
    }

    /// The largest rise within a part, and where, if it is above another; a bound from above.
    pub(super) fn highest_within(&self, heat: &Heat, part: &Part, start: Rise, above: f64) -> Option<Within> {
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

/// A time of constant heat with its step, and what a watt in it adds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watt {
    pub(super) part: Part,
    /// The rises before it.
    pub(super) before: Rise,
    pub(super) step: Step,
    /// What a watt in it adds to the rises at its end \[K/W\].
    pub(super) per_watt: Rise,
}

impl Watt {
    pub(super) fn new(rates: &Rates, part: Part, before: Rise) -> Watt {
        let (step, slope) = rates.expand(part.duration, part.heat);
        let by_change = times(&slope.change, before);
        Watt { part, before, step, per_watt: [by_change[0] + slope.gain[0], by_change[1] + slope.gain[1]] }
    }
}
