//! The form of Unitree's actuators for Isaac Lab (`UnitreeActuatorCfg` of `unitree_rl_lab`): the only one with a torque of its
//! own for each direction of power, so that the gear's loss can be said.
//!
//! Up to X1 the torque is Y1 where it has the direction of the speed and Y2 where it has the other; from there to X2 both fall
//! to nothing. Friction is `Fs tanh(ω/Va) + Fd ω`.

use super::python::{Call, expressions, module};
use super::{Cell, Exported, Format, Origin, Wish, Wishes, comment_lines, line_remarks};
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "unitree",
    about: "Unitree's X1, X2, Y1, Y2, Fs, Fd for Isaac Lab: `UnitreeActuatorCfg` in Python, with the gear's loss by direction",
    text,
    says,
    takes: &[Wish::LineBelow, Wish::Draws, Wish::Map],
    checked: "its formula, by hand",
    source: "https://github.com/unitreerobotics/unitree_rl_lab",
};

/// Speed \[rad/s\] at which friction has its full size: the default of the form.
const ACTIVATION: f64 = 0.01;

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("armature"),
        Fact::Damping => Cell::Said("Fd"),
        Fact::Friction => Cell::Said("Fs"),
        Fact::FrictionAtRest => Cell::Not("Fs is the same at rest"),
        Fact::PeakTorque => Cell::Said("Y1"),
        Fact::TorqueSpeed => Cell::Said("X1, X2: a straight line; how far it is off is in the comment"),
        Fact::Braking => Cell::Approximately("Y2, but beyond X1 it falls as Y1 does, which the motor's does not"),
        Fact::ContinuousTorque | Fact::Heating => Cell::Not("nothing heats"),
        Fact::MechanicalSpeed => Cell::Said("velocity_limit_sim"),
        Fact::GearLoss => Cell::Said("Y1 = η e, Y2 = e/η_b"),
        Fact::Compliance | Fact::Backlash => {
            Cell::Not("it needs a link for the rotor and a joint of its own, in the asset")
        }
        Fact::Cogging | Fact::OtherEffects => Cell::Not("an actuator has no such term"),
        Fact::ElectricalTime => Cell::Not("the torque follows its command at once; `max_delay` has whole steps"),
        Fact::Transmission => Cell::Not("an asset needs the links themselves"),
        Fact::Spring => Cell::Not("it belongs to the joint of the asset"),
        Fact::Ranges => Cell::Approximately("armature for `randomize_joint_parameters`, others in the comment"),
    }
}

fn text(origin: &Origin, joints: &[Exported], wishes: &Wishes) -> Result<String, String> {
    let comments = comment_lines(origin, joints, (says, wishes), |e| line_remarks(e, wishes));
    let import = "from unitree_rl_lab.assets.robots.unitree_actuators import UnitreeActuatorCfg";
    module((&comments, import), origin, joints, |e| {
        let s = &e.simulated;
        let line = wishes.line(e, "X1")?;
        let (driving, driven) = s.load_factors().unwrap_or((1.0, 1.0));
        // What a module's row rates has its loss in it, while it brakes where the row has a curve for that.
        let braking =
            if s.is_behind_loss { s.braking_effort().map_or(1.0, |b| b.value / line.effort).max(1.0) } else { 1.0 };
        let mut call = Call::new(
            "UnitreeActuatorCfg",
            "parameters of `randomize_joint_parameters`, with operation \"abs\" and distribution \"uniform\"",
        );
        call.with("joint_names_expr", format!("[{}]", expressions(e, wishes).join(", ")), "");
        call.number("X1", line.corner, "rad/s, up to which it has its largest torque");
        call.number("X2", line.no_load, "rad/s, where the voltage leaves no torque");
        call.number("Y1", line.effort * driving, "N*m, driving, behind the losses");
        // A gear that does not turn backwards holds whatever comes: then there is no number.
        let braking = line.effort * braking * driven;
        if braking.is_finite() && braking > 0.0 {
            let helps = if driven > 1.0 { "N*m, braking: the losses help" } else { "N*m, braking" };
            call.number("Y2", braking, helps);
        }
        call.optional("Fs", s.friction_loss, "N*m");
        call.optional("Fd", s.damping, "N*m*s/rad");
        call.with("Va", super::digits(ACTIVATION), "rad/s, at which friction has its full size: the form's default");
        call.optional("velocity_limit_sim", s.mechanical_speed.map(|b| b.value), "rad/s, of motor and gear");
        call.optional("armature", s.armature, "kg*m^2");
        call.with("stiffness", "stiffness", "");
        call.with("damping", "damping", "a gain, not friction");
        call.range("armature_distribution_params", e, "armature");
        Ok(call)
    })
}
