//! A design's currents under names that say what they are: by phase amplitude a drive is bought, q-axis amperes are
//! what the model, its limits and its objective compare.
//!
//! The q-axis current here is power invariant: √(3/2) of the phase amplitude. Of a brushed motor the phase amplitude
//! stands for the DC current, and both are the same.

use serde_json::{Map, Value, json};

use crate::catalog::Motor;
use crate::catalog::convention::{Commutation, CurrentConvention};
use crate::design::Evaluation;

/// Names in JSON, CSV and studies, in the order of [`values`].
pub const NAMES: [&str; 4] = ["peak_current_phase_a", "peak_current_q_a", "rms_current_phase_a", "rms_current_q_a"];

/// What is said once wherever limits on currents are shown.
pub const Q_AXIS: &str = "Limits on currents, and the objective `peak_current`, compare q-axis amperes (power invariant): √(3/2) times the \
                          phase amplitude, and the DC current of a brushed motor.";

/// What a q-axis current is on the drive: phase amplitude, or DC ampere of a brushed motor \[A\].
pub fn phase(motor: &Motor, q_axis: f64) -> f64 {
    let commutation = motor.conventions.commutation;
    let convention = match commutation {
        Commutation::Brushless => CurrentConvention::PhaseAmplitude,
        Commutation::Brushed => CurrentConvention::Dc,
    };
    q_axis / convention.torque_current(commutation)
}

/// What the phase's ampere is of a motor, in words.
pub fn phase_word(motor: &Motor) -> &'static str {
    match motor.conventions.commutation {
        Commutation::Brushless => "A (phase amplitude)",
        Commutation::Brushed => "A (DC)",
    }
}

/// Largest and root mean square current of a design, each as phase amplitude and on the q axis \[A\].
pub fn values(motor: &Motor, evaluation: &Evaluation) -> [f64; 4] {
    let (peak, rms) = (evaluation.peak_current, evaluation.rms_current);
    [phase(motor, peak), peak, phase(motor, rms), rms]
}

/// The same for programs, put into an object.
pub fn put(object: &mut Map<String, Value>, motor: &Motor, evaluation: &Evaluation) {
    for (name, value) in NAMES.into_iter().zip(values(motor, evaluation)) {
        object.insert(name.into(), json!(value));
    }
}

/// The same put into a JSON value that is an object.
pub fn add(value: &mut Value, motor: &Motor, evaluation: &Evaluation) {
    if let Value::Object(object) = value {
        put(object, motor, evaluation);
    }
}
