//! Loads that were made ready before, for joints that ask the same.
//!
//! The one idea: a load depends on the motion and on the bandwidth torque alone, and making it ready arranges all samples. Robots of a
//! grid that differ in the bus or the gear have the same loads.

use std::sync::{Arc, Mutex, Weak};

use gearwise_model::actuator::Load;
use gearwise_model::requirement::{Joint, Motion, TorqueBandwidth};
use gearwise_model::transmission::Passed;

/// Most loads that are kept; the oldest goes first.
const KEPT: usize = 32;
/// Motions of more samples are very many samples: they are looked at in part, and a list of loads does not keep theirs, so that
/// memory stays flat.
pub(super) const MANY: usize = 20_000;

/// A motion with a bandwidth torque, and its load.
#[derive(Debug)]
struct Ready {
    motion: Arc<Motion>,
    bandwidth: Option<TorqueBandwidth>,
    passed: Option<Arc<Passed>>,
    load: Load,
}

/// Loads that were made ready before.
#[derive(Debug, Default)]
pub struct Loads(Mutex<Vec<Arc<Ready>>>);

impl Loads {
    /// The load of a joint whose gear covers no inertia, from `make` where it is not there.
    pub(super) fn of(&self, joint: &Joint, make: impl FnOnce() -> Load) -> Load {
        let (motion, bandwidth) = (&joint.motion, joint.limits.torque_bandwidth);
        if joint.gear_map.is_some() || motion.len() > MANY {
            return make();
        }
        let same = |ready: &&Arc<Ready>| {
            ready.bandwidth == bandwidth
                && (bandwidth.is_none() || ready.passed == joint.passed)
                && (Arc::ptr_eq(&ready.motion, motion) || ready.motion == *motion)
        };
        let known = self.0.lock().expect("no thread panicked").iter().find(same).cloned();
        if let Some(ready) = known {
            return ready.load.clone();
        }
        let load = make();
        let ready =
            Arc::new(Ready { motion: motion.clone(), bandwidth, passed: joint.passed.clone(), load: load.clone() });
        let mut all = self.0.lock().expect("no thread panicked");
        if all.len() >= KEPT {
            all.remove(0);
        }
        all.push(ready);
        load
    }
}

/// Loads of motions of very many samples, as long as somebody holds the motion: making one ready takes seconds, and one answer
/// asks for it many times.
static LARGE: Mutex<Vec<(Weak<Motion>, Load)>> = Mutex::new(Vec::new());

/// Most of them.
const MOST_LARGE: usize = 4;

/// The load of a motion of very many samples, from `make` where it is not known.
pub(super) fn of_large(motion: &Arc<Motion>, make: impl FnOnce() -> Load) -> Load {
    let same = |held: &Weak<Motion>| held.upgrade().is_some_and(|held| Arc::ptr_eq(&held, motion));
    // Who cannot look now makes it himself: a child of a fork may find it taken for ever.
    let known =
        LARGE.try_lock().ok().and_then(|all| all.iter().find(|(held, _)| same(held)).map(|(_, load)| load.clone()));
    known.unwrap_or_else(|| {
        let load = make();
        remember(motion, &load);
        load
    })
}

/// Keeps the load of a motion of very many samples; those of motions that nobody holds any more go.
pub(super) fn remember(motion: &Arc<Motion>, load: &Load) {
    let Ok(mut all) = LARGE.try_lock() else { return };
    all.retain(|(held, _)| held.strong_count() > 0);
    if all.len() >= MOST_LARGE {
        all.remove(0);
    }
    all.push((Arc::downgrade(motion), load.clone()));
}
