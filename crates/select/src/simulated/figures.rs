//! The numbers of an actuator at its joint, without words and lines: for maps over many ratios.

use super::{
    NoLoad, SimulatedJoint, braking_torque, continuous_torque, effects, held, inside, largest_speed, no_load_friction,
    no_load_speed, peak_torque, speed_at_torque, stall_torque,
};
use gearwise_model::actuator::limits::Candidate;
use gearwise_model::effects::SimulatorField;

/// Numbers of an actuator at its joint, SI. Torques are those there but for friction and the rotor's own acceleration; what is not known is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// Mass of motor and gear \[kg\].
    pub mass: f64,
    /// Inertia at the output \[kg·m²\].
    pub reflected_inertia: f64,
    /// Copper loss per square of the torque at the joint while the motor drives \[W/(N·m)²\], at the reference temperature.
    pub copper_loss_per_torque_squared: f64,
    /// Largest torque while the motor drives \[N·m\], at standstill and up to the speed of the corner.
    pub peak_torque: f64,
    /// Largest torque against a load that drives \[N·m\].
    pub peak_braking_torque: f64,
    /// Torque that can be held for ever while the motor drives \[N·m\].
    pub continuous_torque: f64,
    /// Torque that the voltage alone allows at standstill \[N·m\].
    pub stall_torque: f64,
    /// Speed up to which the largest torque can be had \[rad/s\].
    pub speed_at_peak: f64,
    /// Speed without load \[rad/s\].
    pub no_load_speed: f64,
    /// Largest speed that motor, gear and voltage allow \[rad/s\].
    pub max_speed: f64,
    /// Viscous friction at the output \[N·m·s/rad\].
    pub damping: f64,
    /// Coulomb friction at the output \[N·m\].
    pub friction_loss: f64,
}

impl SimulatedJoint {
    /// The numbers of a candidate at a ratio. Of a joint without a transmission.
    pub fn figures(candidate: &Candidate, ratio: f64) -> Figures {
        if candidate.whole_map().is_some() {
            return candidate.at_ratio(ratio, |here| SimulatedJoint::figures(here, ratio));
        }
        let actuator = &candidate.actuator;
        let inside = inside(candidate);
        let says_inertia = inside.is_none_or(|inside| inside.says_inertia);
        let known = |is_known: bool, value: f64| if is_known { value } else { f64::NAN };
        let peak = peak_torque(candidate, ratio);
        let (driving, braking) = factors(candidate, peak.is_some_and(|peak| peak.owner == super::MODULE));
        let at_joint = |torque: Option<f64>, factor: f64| torque.map_or(f64::NAN, |torque| torque * ratio * factor);
        let (damping, friction_loss) = frictions(candidate, ratio);
        let currents = inside.is_none_or(|inside| inside.says_currents());
        let per_torque = actuator.heating() / (ratio * driving).powi(2);
        Figures {
            mass: candidate.mass_at(ratio).unwrap_or(f64::NAN),
            reflected_inertia: known(says_inertia, ratio * ratio * actuator.inertia),
            copper_loss_per_torque_squared: known(currents, per_torque),
            peak_torque: at_joint(peak.map(|peak| peak.value), driving),
            peak_braking_torque: at_joint(braking_torque(candidate, ratio).map(|peak| peak.value), braking),
            continuous_torque: at_joint(continuous_torque(candidate, ratio).map(|bound| bound.value), driving),
            stall_torque: known(currents, at_joint(Some(stall_torque(candidate)), driving)),
            speed_at_peak: peak.and_then(|peak| speed_at_torque(candidate, peak.value, ratio)).unwrap_or(f64::NAN),
            no_load_speed: no_load_speed(candidate, ratio).unwrap_or(f64::NAN),
            max_speed: largest_speed(candidate, ratio).value,
            damping,
            friction_loss,
        }
    }

    /// Largest torques of a candidate at a ratio and a speed of the joint \[rad/s\]: while the motor drives and while the load
    /// does \[N·m\]. A speed below zero is the same turned around. Beyond the largest speed there is none: zero.
    pub fn torque_at(candidate: &Candidate, ratio: f64, speed: f64) -> (f64, f64) {
        if candidate.whole_map().is_some() {
            return candidate.at_ratio(ratio, |here| SimulatedJoint::torque_at(here, ratio, speed));
        }
        let speed = speed.abs();
        let figures = SimulatedJoint::figures(candidate, ratio);
        if speed > figures.max_speed {
            return (0.0, 0.0);
        }
        let Some(peak) = peak_torque(candidate, ratio) else { return (f64::NAN, figures.peak_braking_torque) };
        let factor = figures.peak_torque / peak.value;
        let is_had = |torque: f64| speed_at_torque(candidate, torque, ratio).map(|most| most >= speed);
        let driving = match is_had(peak.value) {
            None => f64::NAN,
            Some(true) => figures.peak_torque,
            Some(false) => {
                let (mut had, mut too_much) = (0.0, peak.value);
                for _ in 0..60 {
                    let middle = 0.5 * (had + too_much);
                    if is_had(middle) == Some(true) { had = middle } else { too_much = middle }
                }
                had * factor
            }
        };
        (driving, figures.peak_braking_torque)
    }
}

/// What arrives at a load that the motor drives, and what holds against a load that drives, per torque at the motor times N; NaN
/// where the gear's loss is not known.
fn factors(candidate: &Candidate, is_behind_loss: bool) -> (f64, f64) {
    let says = inside(candidate).is_none_or(|inside| inside.gear_loss.is_some());
    match (is_behind_loss, says) {
        (true, _) => (1.0, 1.0),
        (false, true) => (candidate.gear.efficiency, held(candidate.gear.backdrive_efficiency)),
        (false, false) => (f64::NAN, f64::NAN),
    }
}

/// Viscous and Coulomb friction of motor and gear at the output, as far as they are known; NaN where neither says any.
fn frictions(candidate: &Candidate, ratio: f64) -> (f64, f64) {
    let (mut damping, mut friction) = (None, None);
    for (effect, values) in effects(candidate) {
        match effect.export(&values, ratio) {
            SimulatorField::Damping(value) => *damping.get_or_insert(0.0) += value,
            SimulatorField::FrictionLoss(value) => *friction.get_or_insert(0.0) += value,
            _ => {}
        }
    }
    if let NoLoad::Coulomb(torque) = no_load_friction(candidate.motor) {
        *friction.get_or_insert(0.0) += torque * ratio;
    }
    let of_gear = candidate.gear.no_load;
    for (sum, own) in [(&mut damping, of_gear.viscous * ratio * ratio), (&mut friction, of_gear.coulomb * ratio)] {
        if own > 0.0 {
            *sum.get_or_insert(0.0) += own;
        }
    }
    (damping.unwrap_or(f64::NAN), friction.unwrap_or(f64::NAN))
}
