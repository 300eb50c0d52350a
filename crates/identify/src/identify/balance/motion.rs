//! How the shafts move.

use super::grid::Gridded;
use crate::Channel;
use crate::identify::origin::Signal;
use crate::signals::{self, LowPass};

/// Share of the sampling rate below which the direction of motion is read.
const DIRECTION_BAND: f64 = 0.2;

/// Shaft speeds of one stretch.
pub(super) struct Motion {
    pub motor: Signal,
    pub direction: Vec<f64>,
    pub motor_acceleration: Signal,
    pub output_acceleration: Signal,
}

impl Motion {
    /// Of a shaft that is held, or of which nothing is known.
    pub fn none(count: usize) -> Motion {
        let zero = Signal::constant(0.0, count);
        Motion {
            motor: zero.clone(),
            direction: zero.values.clone(),
            motor_acceleration: zero.clone(),
            output_acceleration: zero,
        }
    }
}

/// Of what the log has of either side of the gear; `None` where it has nothing of a shaft.
pub(super) fn motion(grid: &Gridded, ratio: f64, lag: f64) -> Option<Motion> {
    let get = |c| grid.shifted(c, lag);
    let smooth = |position: Signal| {
        let speed = position.through(|v| signals::derivative(v, grid.step.max(f64::MIN_POSITIVE)));
        speed.through(|v| LowPass::new(DIRECTION_BAND).apply(v))
    };
    let motor = get(Channel::MotorVelocity).or_else(|| get(Channel::MotorPosition).map(smooth));
    let output = get(Channel::OutputVelocity).or_else(|| get(Channel::OutputPosition).map(smooth));
    let (motor, output) = match (motor, output) {
        (Some(m), Some(o)) => (m, o),
        (Some(m), None) => (m.clone(), m.map(|w| w * (1.0 / ratio))),
        (None, Some(o)) => (o.map(|w| w * ratio), o),
        (None, None) => return None,
    };
    let output_acceleration = get(Channel::OutputAcceleration).unwrap_or_else(|| grid.derivative(&output));
    let speed = &motor.values;
    let calm = if grid.step > 0.0 { LowPass::new(DIRECTION_BAND).apply(speed) } else { speed.clone() };
    let largest = speed.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let noise = if grid.step > 0.0 { signals::noise_level(speed) } else { 0.0 };
    let threshold = (2.0 * (2.0 * DIRECTION_BAND).sqrt() * noise).max(2e-3 * largest).max(f64::MIN_POSITIVE);
    let direction = calm.iter().map(|w| (w / threshold).clamp(-1.0, 1.0)).collect();
    Some(Motion { motor_acceleration: grid.derivative(&motor), motor, direction, output_acceleration })
}
