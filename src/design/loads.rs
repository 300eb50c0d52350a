//! Loads that were made ready before, for joints that ask the same.
//!
//! The one idea: a load depends on the motion and on the bandwidth torque alone, and making it ready arranges all samples. Robots of a
//! grid that differ in the bus or the gear have the same loads.

use std::sync::{Arc, Mutex};

use crate::actuator::Load;
use crate::requirement::{Joint, Motion, TorqueBandwidth};
use crate::transmission::Passed;

/// Most loads that are kept; the oldest goes first.
const KEPT: usize = 32;
/// Most samples of a motion whose load is kept: memory stays flat.
const SAMPLES: usize = 20_000;

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
        if joint.gear_map.is_some() || motion.len() > SAMPLES {
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
