//! Physical effects of an actuator, one file each.
//!
//! The one idea: an effect is a set of parameters and what they add to one equation of the actuator:
//! to the torque that the motor shaft must supply, to the terminal voltage, or to the angle between
//! motor and output. It says so once, as a function of the operating point that is linear in its
//! parameters but for at most one shape parameter ([`Effect::basis`]), and how it enters the limits of
//! the model ([`Effect::enters`]). Sweep, ratio program, identification and export all read that. A
//! new effect is one file here and one line in [`EFFECTS`]; one that lowers a bound or an efficiency instead has its
//! equation in [`fitted`](crate::actuator::fitted), and a test that says so where it is missing.

mod backlash;
mod cogging;
mod coulomb;
mod direction_asymmetry;
mod eddy_drag;
pub mod features;
mod found;
mod gear_compliance;
mod gear_ripple;
mod gravity;
mod inverter_dead_time;
mod load_dependent;
mod stribeck;
mod supply_sag;
mod torque_constant_saturation;
mod torque_constant_temperature;
mod torque_offset;
mod torque_ripple;
mod viscous;
mod winding_temperature;

pub use backlash::Backlash;
pub use cogging::Cogging;
pub use coulomb::CoulombFriction;
pub use direction_asymmetry::DirectionAsymmetry;
pub use eddy_drag::EddyDrag;
pub use found::FittedEffect;
pub use gear_compliance::GearCompliance;
pub use gear_ripple::GearRipple;
pub use gravity::Gravity;
pub use inverter_dead_time::InverterDeadTime;
pub use load_dependent::LoadDependentFriction;
pub use stribeck::StribeckFriction;
pub use supply_sag::SupplySag;
pub use torque_constant_saturation::TorqueConstantSaturation;
pub use torque_constant_temperature::TorqueConstantTemperature;
pub use torque_offset::TorqueOffset;
pub use torque_ripple::TorqueRipple;
pub use viscous::ViscousFriction;
pub use winding_temperature::WindingTemperature;

use crate::units::Kind;
use features::{Feature, ShaftForm, sign};

/// A parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name, also in files.
    pub name: &'static str,
    /// Symbol in the model.
    pub symbol: &'static str,
    /// What it measures.
    pub kind: &'static Kind,
}

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
}

/// The equation that an effect adds a term to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Equation {
    /// Torque that the motor must supply beyond the load \[N·m at the motor\].
    Torque,
    /// Terminal voltage \[V, q axis\].
    Voltage,
    /// Angle by which the motor, over N, leads the output \[rad\].
    Angle,
}

/// The one parameter that an effect is not linear in, and where to look for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// None.
    None,
    /// A speed, searched between fractions of the largest speed.
    Speed,
    /// A current, searched around the largest current.
    Current,
    /// An order: a whole number of periods a revolution.
    Order,
}

/// What a parameter is compared with to be plausible. SI, motor side.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    /// Torque constant K_T \[N·m/A\].
    pub torque_constant: f64,
    /// Resistance R \[Ω\].
    pub resistance: f64,
    /// Largest motor torque on the bench \[N·m\].
    pub torque: f64,
    /// Largest speed of the motor on the bench \[rad/s\].
    pub speed: f64,
    /// Largest current on the bench \[A\].
    pub current: f64,
    /// Largest voltage on the bench \[V\].
    pub voltage: f64,
}

/// How an effect enters the limits of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Enters {
    /// Through features of a sample, with even powers of N in the squares: the program stays conic.
    Convex,
    /// As a Laurent polynomial with odd powers: certified by branch and bound.
    Laurent,
    /// Through the gear's efficiency: the program stays conic.
    Efficiency,
    /// As a constant that lowers what may be had or adds to the heat: the program stays conic.
    Bound,
    /// Evaluated at every ratio of a refined grid: not certified.
    Evaluated,
    /// Not at all: why.
    NotAtAll(&'static str),
}

impl Enters {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Enters::Convex => "enters torque and voltage at every instant; the optimum is certified",
            Enters::Laurent => "enters torque and voltage at every instant; certified by branch and bound",
            Enters::Efficiency => "enters as the gear's efficiency; the optimum is certified",
            Enters::Bound => "enters as a bound; the optimum is certified",
            Enters::Evaluated => "evaluated on a refined grid of ratios; the optimum is not certified",
            Enters::NotAtAll(_) => "does not enter the limits",
        }
    }
}

/// Where a simulator keeps a parameter at the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SimulatorField {
    /// Viscous damping at the output \[N·m·s/rad\].
    Damping(f64),
    /// Friction loss at the output \[N·m\].
    FrictionLoss(f64),
    /// Stiffness between motor and output \[N·m/rad\].
    Stiffness(f64),
    /// No place for it.
    Nowhere,
}

/// A physical effect. Its values are those of its parameters in order: the linear ones, then the shape
/// parameter where there is one.
pub trait Effect: Sync {
    /// Name, also in files.
    fn name(&self) -> &'static str;

    /// The equation.
    fn equation(&self) -> &'static str;

    /// The parameters: the linear ones, then the shape.
    fn parameters(&self) -> &'static [Parameter];

    /// What it needs of a log.
    fn needs(&self) -> &'static [Variable];

    /// The equation that it is a term of.
    fn acts_on(&self) -> Equation {
        Equation::Torque
    }

    /// The parameter it is not linear in.
    fn shape(&self) -> Shape {
        Shape::None
    }

    /// What each linear parameter is multiplied with at an operating point: one or two numbers (the
    /// second zero where there is one).
    fn basis(&self, shape: f64, at: &Operating) -> [f64; 2];

    /// Whether values are physically plausible in sign and size.
    ///
    /// # Errors
    /// Why not.
    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), String>;

    /// How it enters the limits.
    fn enters(&self) -> Enters;

    /// The column of a motor's row that declares it, where one does.
    fn column(&self) -> Option<&'static str> {
        None
    }

    /// Derivative of its torque by the speed of the motor \[N·m·s/rad\], where it is evaluated at each ratio;
    /// the jump of a sign is left out.
    fn speed_slope(&self, _values: &[f64], _at: &Operating) -> f64 {
        0.0
    }

    /// Adds the effect to the torque that the shaft must supply, where it has that form.
    fn shaft(&self, _values: &[f64], _form: &mut ShaftForm) {}

    /// What a simulator should be told at a ratio.
    fn export(&self, _values: &[f64], _ratio: f64) -> SimulatorField {
        SimulatorField::Nowhere
    }

    /// How many parameters it is linear in.
    fn linear(&self) -> usize {
        self.parameters().len() - usize::from(self.shape() != Shape::None)
    }

    /// Whether its linear parameters may be negative: amplitudes of a cosine and a sine, offsets, differences.
    fn is_signed(&self) -> bool {
        self.linear() == 2
    }

    /// What values add to the equation at an operating point.
    fn value(&self, values: &[f64], at: &Operating) -> f64 {
        let shape = if self.shape() == Shape::None { 0.0 } else { values[self.linear()] };
        self.basis(shape, at).iter().zip(&values[..self.linear()]).map(|(b, v)| b * v).sum()
    }
}

/// Every effect, the simplest first: where the data cannot tell two apart, the earlier is named.
pub const EFFECTS: &[&dyn Effect] = &[
    &TorqueOffset,
    &Gravity,
    &ViscousFriction,
    &CoulombFriction,
    &TorqueConstantSaturation,
    &Cogging,
    &TorqueRipple,
    &GearRipple,
    &EddyDrag,
    &StribeckFriction,
    &LoadDependentFriction,
    &DirectionAsymmetry,
    &TorqueConstantTemperature,
    &WindingTemperature,
    &InverterDeadTime,
    &SupplySag,
    &GearCompliance,
    &Backlash,
];

/// The effect of a name.
pub fn effect(name: &str) -> Option<&'static dyn Effect> {
    EFFECTS.iter().find(|e| e.name() == name).copied()
}

/// Plausible if positive and at most `largest`.
fn positive(name: &str, value: f64, largest: f64, of: &str) -> Result<(), String> {
    if value.is_nan() || value <= 0.0 {
        return Err(format!("{name} would be {value:.3e}, but it cannot be negative or zero"));
    }
    if value > largest {
        return Err(format!("{name} would be {value:.3e}, more than {of} ({largest:.3e}) lets one believe"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    const SCALE: Scale =
        Scale { torque_constant: 0.1, resistance: 0.5, torque: 2.0, speed: 200.0, current: 20.0, voltage: 48.0 };

    fn point() -> Operating {
        Operating {
            speed: 30.0,
            direction: 1.0,
            angle: 0.7,
            output_angle: 0.1,
            current: 7.0,
            torque: 0.6,
            torque_curvature: 3.0,
            winding_rise: 40.0,
            housing_rise: 20.0,
            duty: 0.4,
        }
    }

    #[test]
    fn the_list_is_sound() {
        let mut names = HashSet::new();
        for effect in EFFECTS {
            assert!(names.insert(effect.name()), "{} stands twice", effect.name());
            assert!(!effect.equation().is_empty() && !effect.parameters().is_empty() && !effect.needs().is_empty());
            assert!((1..=2).contains(&effect.linear()), "{}", effect.name());
            assert!(effect.basis(12.0, &point()).iter().all(|b| b.is_finite()), "{}", effect.name());
        }
    }

    #[test]
    fn friction_dissipates_and_a_negative_one_is_not_believed() {
        let friction =
            ["viscous_friction", "coulomb_friction", "eddy_drag", "stribeck_friction", "load_dependent_friction"];
        for name in friction {
            let effect = effect(name).unwrap();
            for (speed, torque) in [(30.0, 0.6), (-30.0, 0.6), (30.0, -0.6), (-5.0, -0.6)] {
                let at = Operating { speed, direction: sign(speed), torque, ..point() };
                assert!(effect.basis(25.0, &at)[0] * speed > 0.0, "{name} makes energy");
            }
            assert!(effect.plausible(&[-0.01, 25.0], &SCALE).is_err(), "{name}");
        }
    }

    #[test]
    fn effects_of_the_shaft_form_agree_with_their_basis() {
        for effect in EFFECTS.iter().filter(|e| matches!(e.enters(), Enters::Convex | Enters::Laurent)) {
            let values = vec![0.03; effect.parameters().len()];
            let mut form = ShaftForm::default();
            effect.shaft(&values, &mut form);
            for speed in [-30.0, 12.0] {
                let at = Operating { speed, direction: sign(speed), ..point() };
                let features: f64 = form[Feature::Velocity] * speed
                    + form[Feature::Sign] * sign(speed)
                    + form[Feature::Speed] * speed.abs()
                    + form[Feature::One];
                approx::assert_relative_eq!(features, effect.value(&values, &at), max_relative = 1e-12);
            }
        }
    }
}
