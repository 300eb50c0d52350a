//! Every limit of the model, once: what is demanded, what may be had, and what kind of set of
//! ratios that leaves. Sweep, ratio program and design rules all read [`LIMITS`].
//!
//! The one idea: a limit is an item of one of the lists below, by what it is about; all that is said of it stands there.

mod asked;
mod bus;
mod gear;
mod heat;
mod joint;
mod limit;
mod mass;
mod module;
mod motor;
mod needs;
mod remarks;
mod size;
mod speed;
mod transmission;

pub use super::candidate::{ASSUMED, Candidate, hottest};
pub use asked::UNBOUNDED;
pub use gear::{GEAR_LIFE, backdriving_torque};
pub use limit::{Asked, Check, Class, Demand, Depends, Judge, Key, Limit, MONEY, Of, Remark, Verdict};
pub use module::allows_spring;
pub use motor::DRIVE_CONTINUOUS_CURRENT;
pub use needs::{ELECTRICAL, NEEDS, Need};
pub use remarks::LOW_SAFETY;

use crate::actuator::shaft::End;
use crate::actuator::supply::Drawn;
use crate::actuator::waveform::Functional;
use crate::requirement::{Joint, Robot};
use limit::Prepared;

/// The limits by what they are about, in the order in which they are reported.
const KINDS: &[&[Limit]] = &[
    motor::LIMITS,
    heat::LIMITS,
    module::LIMITS,
    speed::LIMITS,
    gear::LIMITS,
    transmission::LIMITS,
    joint::LIMITS,
    bus::LIMITS,
    mass::LIMITS,
    size::LIMITS,
];

const COUNT: usize = {
    let (mut count, mut kind) = (0, 0);
    while kind < KINDS.len() {
        count += KINDS[kind].len();
        kind += 1;
    }
    count
};

static ALL: [Limit; COUNT] = {
    let mut all = [KINDS[0][0]; COUNT];
    let (mut place, mut kind) = (0, 0);
    while kind < KINDS.len() {
        let mut item = 0;
        while item < KINDS[kind].len() {
            all[place] = KINDS[kind][item];
            place += 1;
            item += 1;
        }
        kind += 1;
    }
    all
};

/// Every limit.
pub static LIMITS: &[Limit] = &ALL;

impl Limit {
    /// Whether the limit applies to a candidate, and how.
    pub fn check(&'static self, candidate: &Candidate) -> Check {
        let kept = candidate.joint.limits.left_of(self.name);
        match module::of_module(self, candidate).unwrap_or_else(|| (self.prepare)(candidate)) {
            Prepared::NotAsked => Check::NotAsked,
            Prepared::Unknown(what) => Check::Unknown(what),
            Prepared::Asked { demand, squared, factor, bound, owner, standing } => {
                let bound = bound * kept;
                let (end, actuator) = (End::First, None);
                let above_zero = match demand {
                    Demand::Samples(Functional::Power) if bound < 0.0 => {
                        let drawn = Drawn::new(&candidate.robot.bus);
                        factor * drawn.per_power(1.0) / drawn.arrives()
                    }
                    _ => factor,
                };
                let of =
                    Asked { limit: self, demand, squared, factor, above_zero, bound, owner, standing, end, actuator };
                Check::Asked(of)
            }
            Prepared::AtRatio(judge) => Check::AtRatio(judge),
        }
    }
}

impl Candidate<'_> {
    /// What is needed beside the limits and not known: name and why.
    pub fn lacking(&self) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        NEEDS.iter().filter_map(|need| Some((need.name, (need.missing)(self)?)))
    }

    /// What is needed beside the limits and can be said only at a ratio.
    pub fn told_at_a_ratio(&self) -> impl Iterator<Item = (&'static str, Judge)> + '_ {
        NEEDS.iter().filter_map(|need| Some((need.name, (need.at_ratio)(self)?)))
    }

    /// All limits with what they say of this candidate. Where two actuators do different things at the same time, what is kept at every
    /// instant is one limit, and what is a sum over time one for each of them.
    pub fn checks(&self) -> impl Iterator<Item = (&'static Limit, Check)> + '_ {
        LIMITS.iter().flat_map(move |limit| {
            let check = limit.check(self);
            let of_both = match &check {
                Check::NotAsked => true,
                Check::Asked(asked) => matches!(asked.demand, Demand::Samples(_) | Demand::Bandwidth(_)),
                Check::Unknown(_) | Check::AtRatio(_) => false,
            };
            let apart = if of_both { 0 } else { self.load.actuators().len() };
            let each = (0..apart).map(|k| limit.check(&self.of_actuator(Some(k))));
            // What is the same for all of them (mass, inertia, a rating that nobody knows) is one limit.
            let is_one = each.map(|check| what_is_asked(&check)).collect::<Vec<_>>().windows(2).all(|w| w[0] == w[1]);
            let check = if is_one && apart > 0 { limit.check(&self.of_actuator(Some(0))) } else { check };
            let apart = if is_one { 0 } else { apart };
            let whole = (apart == 0).then_some((limit, check));
            whole.into_iter().chain((0..apart).map(move |k| (limit, self.check_of(limit, k))))
        })
    }

    /// What a limit says of one of two actuators.
    fn check_of(&self, limit: &'static Limit, actuator: usize) -> Check {
        match limit.check(&self.of_actuator(Some(actuator))) {
            Check::Asked(asked) => {
                let demand = asked.demand.later(self.first_sample(Some(actuator)));
                Check::Asked(Asked { demand, actuator: Some(actuator), ..asked })
            }
            other => other,
        }
    }
}

/// What a check compares, where it does; else why it does not.
fn what_is_asked(check: &Check) -> Result<(Demand, f64), &'static str> {
    match check {
        Check::Asked(asked) => Ok((asked.demand, asked.bound)),
        Check::Unknown(why) => Err(why),
        Check::NotAsked => Err(""),
        // Whoever asks it asks each actuator.
        Check::AtRatio(_) => Err("at a ratio"),
    }
}

/// Whether a limit or a need is about the gear, by its name.
pub fn is_of_gear(name: &str) -> bool {
    LIMITS.iter().any(|limit| limit.name == name && limit.of == Of::Gear)
        || NEEDS.iter().any(|need| need.name == name && need.of == Of::Gear)
}

/// Whether the requirement itself asks for something, by the name of the limit or of the need.
pub fn is_stated(name: &str, robot: &Robot, joint: &Joint) -> bool {
    LIMITS.iter().any(|limit| limit.name == name && (limit.stated)(robot, joint))
        || NEEDS.iter().any(|need| need.name == name && (need.stated)(robot, joint))
}

/// Where a requirement asks for a limit or a need, by its name and whose it is; `None` where a data sheet does.
pub fn asked_by(name: &str, owner: &str) -> Option<Key> {
    let limit = LIMITS.iter().filter(|limit| limit.name == name).find_map(|limit| (limit.key)(owner));
    limit.or_else(|| NEEDS.iter().filter(|need| need.name == name).find_map(|need| (need.key)(owner)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn limits_have_unique_names_and_say_what_they_compare() {
        let mut names = HashSet::new();
        for limit in LIMITS {
            assert!(names.insert(limit.name), "{} stands twice", limit.name);
            assert!(limit.formula.contains('≤'), "{}", limit.name);
        }
        // A requirement names them in `reserve`.
        let named: Vec<&str> = LIMITS.iter().map(|limit| limit.name).collect();
        assert_eq!(named, crate::requirement::LIMIT_NAMES);
    }
}
