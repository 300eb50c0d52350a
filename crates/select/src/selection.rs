//! The best of several mounts of one motor, and where there is none, why.
//!
//! The one idea: whoever goes through the gears of a motor says of each what it came to; which of them is the best,
//! which came nearest and which reason is told is decided here, once.

use super::Margin;
use super::answer::{Reason, Refused, Rejected, Unjudged, Unusable};
use super::program::Bind;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::Motor;

/// What mounts are ordered by: objective, then loss \[W\].
pub(super) type Key = (f64, f64);

/// Why a mount was not looked at, or came to nothing.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
enum Weight {
    Mentioned,
    Unusable,
    Unchecked,
    Refused,
}

#[derive(Debug)]
struct Why<'a> {
    weight: Weight,
    gear: Option<&'a str>,
    reason: Reason,
}

/// The gear that came nearest to keeping all limits, by its smallest margin.
#[derive(Debug)]
struct Nearest<'a> {
    gear: &'a str,
    margin: Margin,
}

/// The mounts of one motor, gone through.
#[derive(Debug)]
pub(super) struct Selection<'a, T> {
    /// The best that can be judged, and the best of those that cannot.
    best: [Option<(Key, T)>; 2],
    nearest: Option<Nearest<'a>>,
    why: Option<Why<'a>>,
    /// What is not known of a gear that might have done.
    unknown: Option<Remark>,
    tried: usize,
    /// A module has one gear, its own: there is nothing to choose.
    is_module: bool,
}

impl<'a, T> Selection<'a, T> {
    /// Nothing was looked at yet of a motor.
    pub(super) fn new(motor: &Motor) -> Selection<'a, T> {
        let is_module = motor.inside.is_some();
        Selection { best: [None, None], nearest: None, why: None, unknown: None, tried: 0, is_module }
    }

    /// A mount that keeps its limits; `apart` where a limit that the requirement states cannot be judged of it.
    pub(super) fn take(&mut self, apart: bool, key: Key, made: T) {
        self.tried += 1;
        let place = &mut self.best[usize::from(apart)];
        if place.as_ref().is_none_or(|(least, _)| key < *least) {
            *place = Some((key, made));
        }
    }

    /// True if the best that can be judged is no worse than a mount of this key would be.
    pub(super) fn is_led_by_better(&self, key: Key) -> bool {
        self.best[0].as_ref().is_some_and(|(least, _)| *least <= key)
    }

    /// A gear that exceeds limits, by its smallest margin.
    pub(super) fn exceeds(&mut self, gear: &'a str, margin: Option<&Margin>) {
        self.tried += 1;
        if let Some(margin) = margin
            && self.nearest.as_ref().is_none_or(|nearest| margin.margin > nearest.margin.margin)
        {
            self.nearest = Some(Nearest { gear, margin: *margin });
        }
    }

    /// A gear that was looked at and is left out without a word.
    pub(super) fn passed(&mut self) {
        self.tried += 1;
    }

    /// A mount that is no candidate: told where no gear was looked at.
    pub(super) fn unusable(&mut self, why: Unusable) {
        self.unknown = self.unknown.or(why.unknown());
        self.say(Weight::Unusable, None, Reason::Unusable(why));
    }

    /// A gear that is left out because a limit cannot be checked.
    pub(super) fn unchecked(&mut self, gear: &'a str, (limit, why): Remark) {
        self.say(Weight::Unchecked, Some(gear), Reason::Unchecked(limit, why));
    }

    /// A gear with which no design was found, after a search.
    pub(super) fn refused(&mut self, gear: &'a str, reason: Reason) {
        self.say(Weight::Refused, Some(gear), reason);
    }

    /// Why a gear was not looked at: told where it is the first, and nothing weightier is.
    pub(super) fn mention(&mut self, gear: &'a str, reason: Reason) {
        if self.why.is_none() {
            self.say(Weight::Mentioned, Some(gear), reason);
        }
    }

    /// The last of the weightiest reasons is told.
    fn say(&mut self, weight: Weight, gear: Option<&'a str>, reason: Reason) {
        if self.why.as_ref().is_none_or(|told| weight >= told.weight) {
            self.why = Some(Why { weight, gear, reason });
        }
    }

    /// The best: of those that can be judged, if there is any. Else what the nearest gear exceeds, else what was said.
    fn settled(self) -> (Option<T>, Option<(Option<&'a str>, Reason)>) {
        let Selection { best: [judged, apart], nearest, why, tried, is_module, unknown: _ } = self;
        let nearest = nearest.map(|Nearest { gear, margin }| {
            let bind = Bind::of(margin.limit, margin.sample);
            let (over, allowed) = (margin.demand / margin.bound, margin.bound);
            match is_module {
                true => (None, Reason::Module { bind, over, allowed }),
                false => (Some(gear), Reason::Gears { bind, over, allowed, tried }),
            }
        });
        (judged.or(apart).map(|(_, made)| made), nearest.or(why.map(|told| (told.gear, told.reason))))
    }

    /// The best of all.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn best(self) -> Result<T, Reason> {
        let (best, why) = self.settled();
        best.ok_or_else(|| why.map_or(Reason::Unusable(Unusable::NoGearFits), |(_, reason)| reason))
    }

    /// The best of the gears of a motor.
    ///
    /// # Errors
    /// The motor is rejected.
    pub(super) fn best_of(self, motor: &'a Motor) -> Result<T, Refused<'a>> {
        let unknown = self.unknown;
        let (best, why) = self.settled();
        best.ok_or_else(|| {
            // A gear of which it is not known whether it would do may do.
            if let (Some(remark), Some((_, Reason::Gears { .. }))) = (unknown, &why) {
                return Refused::Unjudged(Box::new(Unjudged {
                    motor,
                    gear: None,
                    because: vec![remark],
                    design: None,
                }));
            }
            let (gear, reason) = why.unwrap_or((None, Reason::Unusable(Unusable::NoGearFits)));
            Refused::rejected(Rejected { motor, gear, reason })
        })
    }
}
