//! What a voltage step does to a free motor, by integrating the equations of motion.
//!
//! ```text
//! L di/dt = V − R i − K_B ω        J_m dω/dt = K_T i
//! ```
//! Without inductance the current follows at once and the speed rises with the time constant
//! `τ_ω = S_M` (Urs et al., eq. 13). With it the response is of second order, and overshoots where
//! `L/R > S_M/4`.

use nalgebra::Vector2;

use crate::catalog::Motor;

/// What is seen in the response of speed to a voltage step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepResponse {
    /// Time to 63.2 % (1 − 1/e) of the final speed \[s\].
    pub rise_time: f64,
    /// Largest speed over final speed, minus one.
    pub overshoot: f64,
}

/// Simulates a unit step of the q-axis voltage on the free motor, with the inductance given \[H\].
/// `None` where the rotor inertia is unknown.
pub fn simulate(motor: &Motor, inductance: f64) -> Option<StepResponse> {
    simulate_and_watch(motor, inductance, &mut |_, _| {})
}

/// As [`simulate`]; `watch` is told the time \[s\] and the speed as a share of the final speed, step by step.
pub fn simulate_and_watch(motor: &Motor, inductance: f64, watch: &mut dyn FnMut(f64, f64)) -> Option<StepResponse> {
    let rotor = motor.rotor_inertia?;
    let (r, k_t, k_b) = (motor.resistance, motor.torque_constant, motor.back_emf_constant);
    let mechanical = rotor * r / (k_t * k_b);
    let electrical = inductance / r;
    // Below a ten-thousandth of the mechanical time constant the current is quasi-static: stiff to
    // integrate, and without effect.
    let stiff = electrical < 1e-4 * mechanical;
    let final_speed = 1.0 / k_b;
    // State: current, speed.
    let rate = |x: &Vector2<f64>| {
        if stiff {
            Vector2::new(0.0, k_t * (1.0 - k_b * x[1]) / r / rotor)
        } else {
            Vector2::new((1.0 - r * x[0] - k_b * x[1]) / inductance, k_t * x[0] / rotor)
        }
    };
    let fastest = if stiff { mechanical } else { electrical.min(mechanical) };
    let step = fastest / 200.0;
    let end = 12.0 * mechanical.max(4.0 * electrical);
    let level = final_speed * (1.0 - (-1.0_f64).exp());
    let mut x = Vector2::new(0.0, 0.0);
    let (mut time, mut rise_time, mut peak) = (0.0, None, 0.0_f64);
    while time < end {
        let k1 = rate(&x);
        let k2 = rate(&(x + k1 * (0.5 * step)));
        let k3 = rate(&(x + k2 * (0.5 * step)));
        let k4 = rate(&(x + k3 * step));
        let next = x + (k1 + (k2 + k3) * 2.0 + k4) * (step / 6.0);
        if rise_time.is_none() && next[1] >= level {
            rise_time = Some(time + step * (level - x[1]) / (next[1] - x[1]));
        }
        peak = peak.max(next[1]);
        x = next;
        time += step;
        watch(time, x[1] / final_speed);
    }
    Some(StepResponse { rise_time: rise_time?, overshoot: (peak / final_speed - 1.0).max(0.0) })
}
