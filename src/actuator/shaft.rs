//! What the motor shaft must supply, and what that takes electrically: the equations of one sample.
//!
//! Torque and quadrature voltage are *linear* in a few features of a sample, each with its own power
//! of the ratio N:
//!
//! ```text
//! T   = φ τ/N + N (J α + b ω) + c sgn ω            J = J_m + J_g
//! Ṫ   = φ τ̇/N + N (J j + b α)                      jumps of φ and of c sgn ω are not differentiated
//! i   = T/K_T
//! v_q = R i + L di/dt + K_B N ω
//! v_d = −p N ω L i
//! P   = R i² + K_B N ω i                           without d(½ L i²)/dt, which is zero over a cycle
//! ```
//!
//! The coefficients are made here, once; the sweep weighs features with them at a ratio, the ratio
//! program takes the same coefficients as Laurent polynomials.

use std::ops::{Index, IndexMut};

use super::effects;
use super::laurent::Laurent;
use crate::catalog::Motor;
use crate::requirement::GearModel;

/// A quantity of a sample that torque or voltage is linear in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    /// Load torque τ \[N·m\].
    Load,
    /// Rate of the load torque τ̇ \[N·m/s\].
    LoadRate,
    /// Output acceleration α \[rad/s²\].
    Acceleration,
    /// Output jerk j \[rad/s³\].
    Jerk,
    /// Output speed ω \[rad/s\].
    Velocity,
    /// Sign of the speed; at standstill ±1 in limits, 0 in means.
    Sign,
    /// Magnitude of the speed \[rad/s\].
    Speed,
    /// One.
    One,
}

/// Number of features.
pub const FEATURES: usize = 8;

/// Power of N that each feature comes with.
pub const FEATURE_POWER: [i32; FEATURES] = [-1, -1, 1, 1, 1, 0, 1, 0];

/// Coefficient of each feature in a linear form.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ShaftForm(pub [f64; FEATURES]);

impl Index<Feature> for ShaftForm {
    type Output = f64;

    fn index(&self, feature: Feature) -> &f64 {
        &self.0[feature as usize]
    }
}

impl IndexMut<Feature> for ShaftForm {
    fn index_mut(&mut self, feature: Feature) -> &mut f64 {
        &mut self.0[feature as usize]
    }
}

impl ShaftForm {
    /// Coefficients times their powers of N.
    pub fn weights(&self, ratio: f64) -> [f64; FEATURES] {
        let (up, down) = (ratio, 1.0 / ratio);
        let c = &self.0;
        [c[0] * down, c[1] * down, c[2] * up, c[3] * up, c[4] * up, c[5], c[6] * up, c[7]]
    }

    /// The form at a sample, as a polynomial in N.
    pub fn polynomial(&self, features: &[f64; FEATURES]) -> Laurent {
        let mut sum = Laurent::default();
        for ((coefficient, feature), power) in self.0.iter().zip(features).zip(FEATURE_POWER) {
            sum = sum + Laurent::monomial(coefficient * feature, power);
        }
        sum
    }

    /// The time derivative of the form: τ → τ̇, α → j, ω → α; a sign has none.
    fn rate(&self) -> ShaftForm {
        let mut rate = ShaftForm::default();
        rate[Feature::LoadRate] = self[Feature::Load];
        rate[Feature::Jerk] = self[Feature::Acceleration];
        rate[Feature::Acceleration] = self[Feature::Velocity];
        rate
    }

    fn plus(mut self, factor: f64, other: &ShaftForm) -> ShaftForm {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += factor * b;
        }
        self
    }
}

/// Which way power flows through the gear at a sample: does not depend on N.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// The motor drives the load (or holds it): `φ = 1/η`.
    Driving = 0,
    /// The load drives the motor: `φ = η_b`.
    Braking = 1,
}

impl Flow {
    /// Both.
    pub const BOTH: [Flow; 2] = [Flow::Driving, Flow::Braking];

    /// Of a load torque \[N·m\] and a speed \[rad/s\].
    pub fn of(torque: f64, velocity: f64) -> Flow {
        if torque * velocity < 0.0 { Flow::Braking } else { Flow::Driving }
    }
}

/// Sign of a speed, zero at zero.
pub fn sign(velocity: f64) -> f64 {
    if velocity == 0.0 { 0.0 } else { velocity.signum() }
}

/// A motor with a gear: all coefficients that the equations of a sample need, SI, q axis.
#[derive(Debug, Clone, Copy)]
pub struct Actuator {
    /// Winding resistance \[Ω\].
    pub resistance: f64,
    /// Torque constant \[N·m/A\].
    pub torque_constant: f64,
    /// Back-EMF constant \[V·s/rad\].
    pub back_emf_constant: f64,
    /// Inertia at the motor shaft \[kg·m²\], J_m + J_g.
    pub inertia: f64,
    /// `p L / K_T` \[V·s²/(rad·N·m)\]: d-axis voltage per torque and output speed; zero where unknown.
    pub cross_coupling: f64,
    torque: [ShaftForm; 2],
    voltage: [ShaftForm; 2],
}

impl Actuator {
    /// The actuator of a motor and a gear, with the effects that the motor's row declares. An
    /// unknown inductance, or unknown pole pairs, leave the inductance out altogether.
    pub fn new(motor: &Motor, rotor_inertia: f64, gear: &GearModel) -> Actuator {
        let inertia = rotor_inertia + gear.inertia;
        let (inductance, pole_pairs) = motor.inductance_and_poles().unwrap_or((0.0, 0.0));
        let form = |load: f64| {
            let mut torque = ShaftForm::default();
            torque[Feature::Load] = load;
            torque[Feature::Acceleration] = inertia;
            effects::add_declared(motor, &mut torque);
            let current = 1.0 / motor.torque_constant;
            let mut voltage = ShaftForm::default()
                .plus(motor.resistance * current, &torque)
                .plus(inductance * current, &torque.rate());
            voltage[Feature::Velocity] += motor.back_emf_constant;
            (torque, voltage)
        };
        let (driving, braking) = (form(1.0 / gear.efficiency), form(gear.backdrive_efficiency));
        Actuator {
            resistance: motor.resistance,
            torque_constant: motor.torque_constant,
            back_emf_constant: motor.back_emf_constant,
            inertia,
            cross_coupling: pole_pairs * inductance / motor.torque_constant,
            torque: [driving.0, braking.0],
            voltage: [driving.1, braking.1],
        }
    }

    /// Torque at the motor shaft as a linear form.
    pub fn torque_form(&self, flow: Flow) -> &ShaftForm {
        &self.torque[flow as usize]
    }

    /// Quadrature voltage as a linear form.
    pub fn voltage_form(&self, flow: Flow) -> &ShaftForm {
        &self.voltage[flow as usize]
    }

    /// Coulomb friction at the shaft \[N·m\]: what makes odd powers of N.
    pub fn has_odd_powers(&self) -> bool {
        self.torque[0][Feature::Sign] != 0.0 || self.torque[0][Feature::One] != 0.0
    }

    /// `T²` of a sample \[N²·m²\].
    pub fn torque_squared(&self, flow: Flow, features: &[f64; FEATURES]) -> Laurent {
        self.torque_form(flow).polynomial(features).squared()
    }

    /// `v_q² + v_d²` of a sample \[V²\].
    pub fn voltage_squared(&self, flow: Flow, features: &[f64; FEATURES]) -> Laurent {
        let direct = Laurent::monomial(self.cross_coupling * features[Feature::Velocity as usize], 1);
        let direct = direct * self.torque_form(flow).polynomial(features);
        self.voltage_form(flow).polynomial(features).squared() + direct.squared()
    }

    /// Terminal power of a sample \[W\].
    pub fn power(&self, flow: Flow, features: &[f64; FEATURES]) -> Laurent {
        let torque = self.torque_form(flow).polynomial(features);
        let speed = Laurent::monomial(features[Feature::Velocity as usize], 1);
        torque.squared() * self.copper() + speed * torque * (self.back_emf_constant / self.torque_constant)
    }

    /// `T` of a sample as coefficients of N⁻¹, 1 and N \[N·m\].
    pub fn torque_terms(&self, flow: Flow, features: &[f64; FEATURES]) -> [f64; 3] {
        let mut terms = [0.0; 3];
        for ((coefficient, feature), power) in self.torque[flow as usize].0.iter().zip(features).zip(FEATURE_POWER) {
            terms[(power + 1) as usize] += coefficient * feature;
        }
        terms
    }

    /// Copper loss per squared torque \[W/(N·m)²\], `R/K_T²`.
    pub fn copper(&self) -> f64 {
        self.resistance / (self.torque_constant * self.torque_constant)
    }
}
