//! What an effect can depend on.

use super::features::sign;

/// An operating point: what an effect can depend on. SI, motor side unless said; NaN where it is not
/// known.
#[derive(Debug, Clone, Copy)]
pub struct Operating {
    /// Speed of the motor shaft ω \[rad/s\].
    pub speed: f64,
    /// Sign of the speed, zero where the encoder cannot tell.
    pub direction: f64,
    /// Angle of the motor shaft θ \[rad\].
    pub angle: f64,
    /// Angle of the output \[rad\].
    pub output_angle: f64,
    /// Quadrature current i \[A\].
    pub current: f64,
    /// Torque transmitted by the gear, as seen at the motor τ/N \[N·m\].
    pub torque: f64,
    /// Second time derivative of the transmitted torque times the inertia it has to move, at the motor
    /// \[N·m·N·m/rad\]: what a spring in the gear multiplies with 1/k.
    pub torque_curvature: f64,
    /// Winding temperature over the reference \[K\].
    pub winding_rise: f64,
    /// Housing temperature over the reference \[K\].
    pub housing_rise: f64,
    /// Duty cycle, −1 … 1.
    pub duty: f64,
}

impl Operating {
    /// Nothing known.
    pub const UNKNOWN: Operating = Operating {
        speed: f64::NAN,
        direction: f64::NAN,
        angle: f64::NAN,
        output_angle: f64::NAN,
        current: f64::NAN,
        torque: f64::NAN,
        torque_curvature: f64::NAN,
        winding_rise: f64::NAN,
        housing_rise: f64::NAN,
        duty: f64::NAN,
    };

    /// At a speed of the motor \[rad/s\], nothing else known.
    pub fn at_speed(speed: f64) -> Operating {
        Operating { speed, direction: sign(speed), ..Operating::UNKNOWN }
    }
}

/// What an effect depends on: a log must have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Variable {
    /// Speed, also its sign.
    Speed,
    /// Angle of the motor.
    Angle,
    /// Angle of the output.
    OutputAngle,
    /// Current.
    Current,
    /// Transmitted torque.
    Torque,
    /// What a spring in the gear multiplies with 1/k: the torque through it, or its second derivative.
    TorqueCurvature,
    /// Winding temperature.
    WindingTemperature,
    /// Housing temperature.
    HousingTemperature,
    /// Duty cycle.
    Duty,
    /// Nothing.
    Constant,
}

impl Variable {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Variable::Speed => "speed",
            Variable::Angle => "motor position",
            Variable::OutputAngle => "output position",
            Variable::Current => "current",
            Variable::Torque => "transmitted torque",
            Variable::TorqueCurvature => "torque across the gear over the wind-up, or its second derivative",
            Variable::WindingTemperature => "winding temperature",
            Variable::HousingTemperature => "housing temperature",
            Variable::Duty => "duty",
            Variable::Constant => "nothing",
        }
    }

    /// Whether it is a temperature.
    pub fn is_temperature(self) -> bool {
        matches!(self, Variable::WindingTemperature | Variable::HousingTemperature)
    }

    /// What logs lack that do not show it.
    pub fn lack(self) -> &'static str {
        match self {
            Variable::WindingTemperature | Variable::HousingTemperature => "the logs have no temperature that varies",
            Variable::Angle | Variable::OutputAngle => "the logs have no position that turns, or not far enough",
            Variable::Torque => "the transmitted torque is not known",
            Variable::TorqueCurvature => "both sides of the gear would have to be measured",
            Variable::Current => "the logs have no current",
            Variable::Speed | Variable::Duty | Variable::Constant => "the logs lack a channel that it depends on",
        }
    }
}
