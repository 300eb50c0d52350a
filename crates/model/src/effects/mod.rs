//! Physical effects of an actuator, one file each.
//!
//! The one idea: an effect is a set of parameters and what they add to one equation of the actuator: to the torque that
//! the motor shaft must supply, to the terminal voltage, or to the angle between motor and output. It says what it does as
//! data, in its own file: its function of the operating point, linear in its parameters but for at most one shape
//! ([`Effect::basis`]), what it does to the limits of the model ([`Effect::enters`]), what hides it on a bench, what it is
//! mistaken for and which run separates it. Sweep, ratio program, identification and export read that data and never its name.
//! A new effect is one file here and its line in [`EFFECTS`].

mod backlash;
mod cogging;
mod coulomb;
mod direction_asymmetry;
mod doubt;
mod eddy_drag;
mod enters;
pub mod features;
mod found;
mod gear_compliance;
mod gear_ripple;
mod gravity;
mod inverter_dead_time;
mod load_dependent;
mod named;
mod operating;
mod seen;
mod stribeck;
mod supply_sag;
mod torque_constant_saturation;
mod torque_constant_temperature;
mod torque_offset;
mod torque_ripple;
mod viscous;
mod winding_temperature;

pub use doubt::{Doubt, positive};
pub use enters::{Enters, Proof};
pub use found::FittedEffect;
pub use named::Named;
pub use operating::{Operating, Variable};
pub use seen::{Mimic, Run, View, separating_run};

use crate::units::Kind;

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// None.
    None,
    /// A speed, as shares of the largest speed.
    Speed(Search),
    /// A current, as shares of the largest current.
    Current(Search),
    /// An order: a whole number of periods a revolution.
    Order,
}

/// Where a shape is looked for, as shares of the largest value in the logs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// The least.
    pub from: f64,
    /// The largest.
    pub to: f64,
    /// Where a simulation starts from.
    pub starts: &'static [f64],
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

/// Where in an actuator an effect is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// In the motor or its drive: it stays with the motor whatever the gear.
    Motor,
    /// In the gear: it belongs to the gear that was on the bench.
    Gear,
    /// Before or behind the gear: with one ratio the two look alike.
    Either,
}

/// Where a simulator keeps a parameter at the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SimulatorField {
    /// Viscous damping at the output \[N·m·s/rad\].
    Damping(f64),
    /// Friction loss at the output \[N·m\].
    FrictionLoss(f64),
    /// What friction has more at rest, at the output \[N·m\].
    FrictionAtRest(f64),
    /// Stiffness between motor and output \[N·m/rad\].
    Stiffness(f64),
    /// Play between motor and output, from stop to stop \[rad\].
    Play(f64),
    /// Torque that the motor must supply over its angle, `cosine cos(order θ) + sine sin(order θ)` \[N·m at the motor\].
    Cogging {
        /// Periods a revolution of the rotor.
        order: f64,
        /// Of the cosine.
        cosine: f64,
        /// Of the sine.
        sine: f64,
    },
    /// It is the gear's efficiency.
    Efficiency,
    /// No place for it.
    Nowhere,
}

/// A physical effect. Its values are those of its parameters in order: the linear ones, then the shape
/// parameter where there is one.
pub trait Effect: Sync {
    /// Name, also in files.
    fn name(&self) -> &'static str;

    /// Name in a sentence.
    fn title(&self) -> String {
        self.name().replace('_', " ")
    }

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
    fn plausible(&self, values: &[f64], scale: &Scale) -> Result<(), Doubt>;

    /// How it enters the limits, with its values.
    fn enters(&self, values: &[f64]) -> Enters;

    /// The column of a motor's row that declares it, where one does.
    fn column(&self) -> Option<&'static str> {
        None
    }

    /// Where in the actuator it is.
    fn side(&self) -> Side {
        Side::Motor
    }

    /// What a simulator should be told at a ratio.
    fn export(&self, _values: &[f64], _ratio: f64) -> SimulatorField {
        SimulatorField::Nowhere
    }

    /// Whether it is one of the plainest, which come first where they explain as much as one curve with a free shape.
    fn is_basic(&self) -> bool {
        false
    }

    /// The effect that it is defined beyond, which therefore comes first and stays.
    fn beyond(&self) -> Option<&'static dyn Effect> {
        None
    }

    /// The effect that it looks like unless a run is made for it, and that run.
    fn mimics(&self) -> Option<Mimic> {
        None
    }

    /// The run that separates it from whatever else looks like it; none where it takes one in which all varies.
    fn separated_by(&self) -> Option<Run> {
        None
    }

    /// Why the bench hides it although everything that it depends on is measured.
    fn hidden(&self, _view: &View) -> Option<&'static str> {
        None
    }

    /// Its place among the effects that a position alone shows, the simplest first; `None` where it does not show.
    fn rank_in_position(&self) -> Option<u32> {
        None
    }

    /// Whether it is a part of the angle by which the motor leads the output: both sides of the gear show it.
    fn winds_up(&self) -> bool {
        self.acts_on() == Equation::Angle
    }

    /// Whether it is the weight of a load that nobody declared, which the gear transmits.
    fn is_weight(&self) -> bool {
        false
    }

    /// Whether it is proportional to speed as the back-EMF is: where a duty cycle drives, both are one damping.
    fn is_damping(&self) -> bool {
        false
    }

    /// Whether its value may drift with the band that it is seen in, because its curve is only nearly that of nature: presliding,
    /// drag, warm-up.
    fn drifts_with_band(&self) -> bool {
        self.needs_temperature()
    }

    /// Whether it repeats once a turn of the output: an order of one may be it.
    fn once_a_turn(&self) -> bool {
        false
    }

    /// Whether, where it is weak, the data show only its coefficient over the square of its shape, and physics says that
    /// the coefficient is the torque constant.
    fn is_of_torque_constant(&self) -> bool {
        false
    }

    /// How many parameters it is linear in.
    fn linear(&self) -> usize {
        self.parameters().len() - usize::from(self.shape() != Shape::None)
    }

    /// Whether two sets of values are one instance of it: of an effect with orders, by their order.
    fn is_same_instance(&self, a: &[f64], b: &[f64]) -> bool {
        self.shape() != Shape::Order || a.last() == b.last()
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

    /// How it enters the limits whatever its values: with values of one.
    fn kind_of_entry(&self) -> Enters {
        self.enters(&vec![1.0; self.parameters().len()])
    }

    /// Whether it depends on a temperature.
    fn needs_temperature(&self) -> bool {
        self.needs().iter().any(|v| v.is_temperature())
    }
}

/// Two effects are the same where their names are.
impl<'a> PartialEq<dyn Effect + 'a> for dyn Effect + '_ {
    fn eq(&self, other: &(dyn Effect + 'a)) -> bool {
        self.name() == other.name()
    }
}

impl std::fmt::Debug for dyn Effect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Every effect, the simplest first: where the data cannot tell two apart, the earlier is named.
pub const EFFECTS: &[&dyn Effect] = &[
    &torque_offset::TorqueOffset,
    &gravity::Gravity,
    &viscous::ViscousFriction,
    &coulomb::CoulombFriction,
    &torque_constant_saturation::TorqueConstantSaturation,
    &cogging::Cogging,
    &torque_ripple::TorqueRipple,
    &gear_ripple::GearRipple,
    &eddy_drag::EddyDrag,
    &stribeck::StribeckFriction,
    &load_dependent::LoadDependentFriction,
    &direction_asymmetry::DirectionAsymmetry,
    &torque_constant_temperature::TorqueConstantTemperature,
    &winding_temperature::WindingTemperature,
    &inverter_dead_time::InverterDeadTime,
    &supply_sag::SupplySag,
    &gear_compliance::GearCompliance,
    &backlash::Backlash,
];

/// The effect of a name.
pub fn effect(name: &str) -> Option<&'static dyn Effect> {
    EFFECTS.iter().find(|e| e.name() == name).copied()
}

/// The effect that a column of a motor's row declares.
pub fn of_column(column: &str) -> Option<&'static dyn Effect> {
    EFFECTS.iter().find(|e| e.column() == Some(column)).copied()
}

/// The effect that is the efficiency of a gear.
pub fn of_efficiency() -> Option<&'static dyn Effect> {
    EFFECTS.iter().find(|e| matches!(e.kind_of_entry(), Enters::Efficiency { .. })).copied()
}

/// The effect that is the weight of a load that nobody declared.
pub fn of_weight() -> Option<&'static dyn Effect> {
    EFFECTS.iter().find(|e| e.is_weight()).copied()
}

/// The effect that is in one damping with the back-EMF.
pub fn of_damping() -> Option<&'static dyn Effect> {
    EFFECTS.iter().find(|e| e.is_damping()).copied()
}

/// A text with the names of effects as a sentence has them, and without underscores.
pub fn in_words(text: &str) -> String {
    EFFECTS.iter().fold(text.to_string(), |text, e| text.replace(e.name(), &e.title())).replace('_', " ")
}

#[cfg(test)]
mod tests;
