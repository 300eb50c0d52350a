//! What a choice must keep: `limits` of a joint, with its `spring`.

use crate::input::{Problem, Range, Section, key};
use crate::units;

/// Limits that a requirement puts on a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Mass of motor and gear \[kg\].
    pub actuator_mass: Option<f64>,
    /// Inertia at the output \[kg·m²\].
    pub reflected_inertia: Option<f64>,
    /// Torque to be delivered on top of the motion.
    pub torque_bandwidth: Option<TorqueBandwidth>,
    /// Highest winding temperature \[K\].
    pub winding_temperature: Option<f64>,
    /// Factor on demanded torque and current in peak checks (not on heat).
    pub safety: f64,
    /// A spring parallel to the actuator, to be chosen.
    pub spring: Option<Spring>,
}

/// What a spring parallel to the actuator may be: it pulls the joint towards its rest angle with
/// `k (q_0 − q)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// Smallest and largest stiffness \[N·m/rad\], k.
    pub stiffness: [f64; 2],
    /// Smallest and largest rest angle \[rad\], q_0, on the scale of the motion's position.
    pub rest_angle: [f64; 2],
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            actuator_mass: None,
            reflected_inertia: None,
            torque_bandwidth: None,
            winding_temperature: None,
            safety: 1.0,
            spring: None,
        }
    }
}

/// A sinusoidal torque at the output on top of the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorqueBandwidth {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Amplitude \[N·m\].
    pub amplitude: f64,
}

/// Reads a `spring`.
pub(super) fn read_spring(section: Section) -> Option<Spring> {
    const STIFFNESS: &str = "[\"0 N*m/rad\", \"50 N*m/rad\"]";
    const REST_ANGLE: &str = "[\"-90 deg\", \"90 deg\"]";
    for (key, example) in [("stiffness", STIFFNESS), ("rest_angle", REST_ANGLE)] {
        if !section.has(key) {
            section.missing(key, example);
        }
    }
    let stiffness = section.quantity_range(key("stiffness", "k").required(), &units::STIFFNESS, Range::NonNegative);
    let rest_angle = section.quantity_range(
        key("rest_angle", "q_0 on the scale of the motion's position").required(),
        &units::ANGLE,
        Range::Any,
    );
    section.finish();
    Some(Spring { stiffness: stiffness?, rest_angle: rest_angle? })
}

/// Reads `limits` of a joint; its spring apart.
pub(super) fn read(section: Section, ambient: f64) -> Limits {
    let bandwidth =
        section.section(key("torque_bandwidth", "a sinusoidal torque on top of the motion")).and_then(|table| {
            let frequency =
                table.required_quantity(key("frequency", "of the torque"), &units::FREQUENCY, Range::Positive);
            let amplitude = table.required_quantity(
                key("amplitude", "of the torque, at the output"),
                &units::TORQUE,
                Range::NonNegative,
            );
            table.finish();
            Some(TorqueBandwidth { frequency: frequency?, amplitude: amplitude? })
        });
    let limits = Limits {
        actuator_mass: section.quantity(
            key(
                "actuator_mass",
                "of motor and gear; like every limit here it has to be judged, or the motor is no choice",
            ),
            &units::MASS,
            Range::Positive,
        ),
        reflected_inertia: section.quantity(
            key("reflected_inertia", "N² (J_m + J_g) at the output"),
            &units::INERTIA,
            Range::Positive,
        ),
        torque_bandwidth: bandwidth,
        winding_temperature: section.quantity(
            key("winding_temperature", "highest; the motor's own holds too"),
            &units::TEMPERATURE,
            Range::Positive,
        ),
        safety: section
            .number(key("safety", "factor on demanded torque and current, not on heat").default("1"), Range::Positive)
            .unwrap_or(1.0),
        spring: None,
    };
    if limits.winding_temperature.is_some_and(|t| t <= ambient) {
        section.note(Problem::at(
            section.span_of("winding_temperature"),
            "the winding may not even be as warm as its surroundings",
            format!("expected more than the ambient temperature, {} degC", crate::words::number(ambient - 273.15)),
        ));
    }
    section.finish();
    limits
}
