//! Numbers of the declared model.

use crate::Declared;

/// Numbers of the declared model that the balances use; the inductance is seen only with a time axis.
pub(super) struct Model {
    pub torque_constant: f64,
    pub resistance: f64,
    pub inductance: Option<f64>,
    pub back_emf: f64,
    pub inertia: Option<f64>,
    pub reference: f64,
}

impl Model {
    pub fn new(declared: &Declared) -> Model {
        match &declared.motor {
            Some(motor) => Model {
                torque_constant: motor.torque_constant,
                resistance: motor.resistance,
                inductance: motor.inductance,
                back_emf: motor.back_emf_constant,
                inertia: motor.rotor_inertia.map(|j| j + declared.gear.inertia),
                reference: motor.reference_temperature,
            },
            None => Model {
                torque_constant: declared.force_gain,
                resistance: f64::NAN,
                inductance: None,
                back_emf: 0.0,
                inertia: declared.mass,
                reference: gearwise_model::catalog::REFERENCE_TEMPERATURE,
            },
        }
    }
}

/// A load that nobody declared, as it was fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    /// Sine over the angle of the output \[N·m at the motor\].
    pub sine: f64,
    /// Cosine.
    pub cosine: f64,
    /// Its inertia \[kg·m² at the motor\]: what is there beyond that of rotor and gear.
    pub inertia: f64,
}
