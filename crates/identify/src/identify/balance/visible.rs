//! Whether an effect can be seen in an equation of a bench.

use super::equation::Balance;
use super::targets::balanced;
use crate::Declared;
use crate::answer::{Base, Hidden, Target};
use crate::identify::origin::Channels;
use gearwise_model::effects::{Effect, Equation, Variable, View};

/// Two torques with at least this correlation (uncentred) have the same course.
const SAME_COURSE: f64 = 0.9;

impl Balance {
    /// Whether a variable is made of the response: then a function of it explains its own noise, and whatever is
    /// in the response, with nothing of the actuator in between. A second derivative amplifies noise so much that it must
    /// not share the noise of the known load either, which stands on the same side.
    pub fn is_response(&self, variable: Variable) -> bool {
        self.stretches.iter().any(|s| {
            let from = &s.origins;
            let (made_of, explained) = match variable {
                Variable::Speed => (from.speed, from.response),
                Variable::Angle => (from.angle, from.response),
                Variable::OutputAngle => (from.output_angle, from.response),
                Variable::Current => (from.current, from.response),
                Variable::Torque => (from.torque, from.response),
                Variable::TorqueCurvature => (from.curvature, from.response | from.load),
                Variable::WindingTemperature => (from.winding, from.response),
                Variable::HousingTemperature => (from.housing, from.response),
                Variable::Duty => (from.duty, from.response),
                Variable::Constant => (Channels::NONE, from.response),
            };
            made_of.meets(explained)
        })
    }

    /// What the bench means for an effect.
    fn view(&self, declared: &Declared) -> View {
        View {
            equation: self.target.equation(),
            has_free_zero: self.target.has_zero(),
            sees_load: self.target == Target::Drive,
            has_gear: declared.ratio != 1.0,
            measures_supply: self.has_measured_volts || self.has_measured_supply,
            fits_damping: self.base.iter().any(|b| b.which == Base::Damping),
        }
    }

    /// True if a weight has the course of the known load, whose scale is fitted: the two cannot be told apart.
    fn weighs(&self, weight: &dyn Effect) -> bool {
        let Some(scale) = self.base.iter().position(|base| base.which == Base::LoadScale) else { return false };
        let load = self.base_column(scale);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let alike = |own: &Vec<f64>| {
            product(own, &load).abs() > SAME_COURSE * (product(own, own) * product(&load, &load)).sqrt()
        };
        self.effect_columns(weight, 0.0).iter().any(alike)
    }

    /// What would have to be measured for a variable not to be made of the response.
    fn shown_by(&self, variable: Variable) -> &'static str {
        match balanced(self.target) {
            Some(balanced) => balanced.shown_by(variable, self.unit == "N"),
            None => "a torque sensor at the output",
        }
    }
}

/// Whether a declared effect is a part of a balance's model: where it is made of the response, with its declared
/// values.
pub fn applies(effect: &dyn Effect, balance: &Balance, declared: &Declared) -> bool {
    matches!(visible(effect, balance, declared), Ok(()) | Err(Hidden::Response(_)))
}

/// Whether an effect can be seen in a balance.
///
/// # Errors
/// Why not.
pub fn visible(effect: &dyn Effect, balance: &Balance, declared: &Declared) -> Result<(), Hidden> {
    // A duty-driven machine shows voltage effects as torque; what a temperature does to the current that nobody measured it
    // does not show.
    let volts = effect.acts_on() == Equation::Voltage && balance.is_duty_driven && !effect.needs_temperature();
    if declared.without.contains(&effect) {
        return Err(Hidden::LeftOut);
    }
    let winds = effect.winds_up() && balance.target == Target::WindUp;
    if effect.acts_on() != balance.target.equation() && !winds && !volts {
        return Err(Hidden::Elsewhere);
    }
    if let Some(missing) = effect.needs().iter().find(|v| !balance.variables.contains(v)) {
        return Err(Hidden::Lacks(*missing));
    }
    if let Some(why) = effect.hidden(&balance.view(declared)) {
        return Err(Hidden::Bench(why));
    }
    if effect.is_weight() && balance.weighs(effect) {
        return Err(Hidden::Bench("the known load has the same course, and its scale shows the torque constant"));
    }
    match effect.needs().iter().find(|v| balance.is_response(**v)) {
        Some(variable) => Err(Hidden::Response(balance.shown_by(*variable))),
        None => Ok(()),
    }
}
