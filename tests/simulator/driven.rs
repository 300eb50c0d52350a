//! The motor without current, turned by a machine that is told a random torque.
//!
//! The driving machine is so strong that it moves as its own inertia and drag would have it, whatever the actuator does: so
//! an effect is felt at the sensor alone, and does not change the motion that it is seen by.

use super::world::{self, Drive, Nature, State, Trace};

/// Seconds in which the driving machine reaches its speed.
const RISE: f64 = 0.3;

/// The driving machine, at the output.
#[derive(Debug, Clone, Copy)]
pub struct Machine {
    /// Its inertia \[kg·m²\].
    pub inertia: f64,
    /// Its own drag \[N·m·s/rad\], without which a random torque would make it run away.
    pub damping: f64,
}

impl Machine {
    /// One that is fit for an actuator.
    pub fn of(actuator: &world::Machine) -> Self {
        let inertia = 20.0 * (actuator.inertia + actuator.gear_inertia) * actuator.ratio.powi(2);
        Machine { inertia, damping: inertia / RISE }
    }

    /// The torque that holds a speed of the output \[N·m\].
    pub fn torque_for(self, speed: f64) -> f64 {
        self.damping * speed
    }
}

/// Torque told in `drive.current` \[N·m at the output\]; the sensor is between the driving machine and the actuator, which
/// is rigid here.
pub fn random_torque(nature: &Nature, mut drive: Drive) -> Trace {
    let m = &nature.machine;
    let (n, h) = (m.ratio, drive.step);
    let driving = Machine::of(m);
    let inertia = m.inertia + m.gear_inertia;
    let mut state = State::new(drive.winding, drive.housing);
    let mut trace = Trace { step: h, ..Trace::default() };
    let (mut position, mut speed) = (0.0_f64, 0.0_f64);
    for k in 0..drive.steps() {
        let told = drive.current.value();
        let acceleration = (told - driving.damping * speed) / driving.inertia;
        state.slide(nature, n * speed, k as f64 * h, h);
        let drag = state.drag(nature, n * position, n * speed);
        let direction = if speed == 0.0 { 0.0 } else { speed.signum() };
        let gravity =
            if nature.gravity == 0.0 { 0.0 } else { nature.gravity * (position + nature.gravity_angle).sin() };
        let given = -(inertia * n * acceleration + drag);
        let through = n * given / (1.0 + nature.load_dependent * direction * given.signum());
        trace.push_motion(n, position, speed, acceleration);
        trace.current.push(0.0);
        trace.current_rate.push(0.0);
        trace.torque.push(through - gravity);
        trace.voltage.push(m.torque_constant * n * speed);
        trace.winding.push(state.winding);
        trace.housing.push(state.housing);
        trace.command.push(told);
        trace.friction_power.push((drag - nature.offset) * n * speed);
        speed += h * acceleration;
        position += h * speed;
        drive.current.advance();
    }
    trace
}
