//! What hangs at the output and is known.

use super::Seen;
use crate::Channel;
use crate::identify::origin::Signal;

/// Its torque: inertia and gravity \[N·m at the output\].
pub(super) fn known_load(seen: &Seen) -> Option<Signal> {
    let (load, moved, angle) = (seen.grid.log.load, seen.moved, seen.turned);
    if let Some(robot) = seen.grid.shifted(Channel::LoadTorque, seen.motion_lag) {
        return Some(robot);
    }
    if load.inertia.is_none() && load.gravity_torque.is_none() {
        return None;
    }
    let inertia = load.inertia.map(|j| moved.output_acceleration.map(|a| j * a));
    let gravity = load.gravity_torque.map(|m| match angle {
        Some(q) => q.map(|q| m * q.sin()),
        None => Signal::constant(f64::NAN, moved.motor.values.len()),
    });
    match (inertia, gravity) {
        (Some(a), Some(b)) => Some(a.with(&b, |a, b| a + b)),
        (a, b) => a.or(b),
    }
}
