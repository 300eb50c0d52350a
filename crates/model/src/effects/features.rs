//! What torque and voltage at the motor shaft are linear in: the features of a sample, each with its power of the ratio.

use std::ops::{Index, IndexMut};

use crate::numerics::laurent::Laurent;

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
    /// Rate of the speed's magnitude, sgn ω · α \[rad/s²\].
    SpeedRate,
}

/// Number of features.
pub const FEATURES: usize = 9;

/// Power of N that each feature comes with.
pub const FEATURE_POWER: [i32; FEATURES] = [-1, -1, 1, 1, 1, 0, 1, 0, 1];

/// The first features are all that a motor needs whose effects are viscous and Coulomb friction.
pub const USUAL_FEATURES: usize = 6;

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
    /// One feature with its coefficient.
    pub fn of(feature: Feature, coefficient: f64) -> ShaftForm {
        let mut form = ShaftForm::default();
        form[feature] = coefficient;
        form
    }

    /// Coefficients times their powers of N.
    pub fn weights(&self, ratio: f64) -> [f64; FEATURES] {
        let (up, down) = (ratio, 1.0 / ratio);
        let c = &self.0;
        [c[0] * down, c[1] * down, c[2] * up, c[3] * up, c[4] * up, c[5], c[6] * up, c[7], c[8] * up]
    }

    /// The form at a sample, as a polynomial in N.
    pub fn polynomial(&self, features: &[f64; FEATURES]) -> Laurent {
        let [inverse, constant, linear] = self.terms(features);
        Laurent::of_terms(inverse, constant, linear)
    }

    /// The form at a sample as coefficients of N⁻¹, 1 and N.
    #[inline]
    pub fn terms(&self, features: &[f64; FEATURES]) -> [f64; 3] {
        // Written out, as it is needed for every sample at every ratio; a property test holds it to `FEATURE_POWER`.
        let (c, x) = (&self.0, features);
        [
            c[0] * x[0] + c[1] * x[1],
            c[5] * x[5] + c[7] * x[7],
            c[2] * x[2] + c[3] * x[3] + c[4] * x[4] + c[6] * x[6] + c[8] * x[8],
        ]
    }

    /// The time derivative of the form: τ → τ̇, α → j, ω → α, |ω| → sgn ω · α; a sign and a constant have none.
    pub fn rate(&self) -> ShaftForm {
        let mut rate = ShaftForm::default();
        rate[Feature::LoadRate] = self[Feature::Load];
        rate[Feature::Jerk] = self[Feature::Acceleration];
        rate[Feature::Acceleration] = self[Feature::Velocity];
        rate[Feature::SpeedRate] = self[Feature::Speed];
        rate
    }

    /// The form with so much of another.
    #[must_use]
    pub fn plus(mut self, factor: f64, other: &ShaftForm) -> ShaftForm {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a += factor * b;
        }
        self
    }
}

/// Sign of a speed, zero at zero.
pub fn sign(velocity: f64) -> f64 {
    if velocity == 0.0 { 0.0 } else { velocity.signum() }
}
