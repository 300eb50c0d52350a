//! mjlab 1.6: `DcMotorActuatorCfg`, whose clip is the line of torque over speed.
//!
//! Its native `<dcmotor>` is not used: mjlab 1.6 holds MuJoCo at 3.11, where gains and inputs of that actuator are others.

use super::python::{Call, expressions, module};
use super::{Cell, Exported, Format, Origin, Wish, Wishes, comment_lines, line_remarks};
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "mjlab",
    about: "mjlab 1.6: `DcMotorActuatorCfg` in Python",
    text,
    says,
    takes: &[Wish::WithEfficiency, Wish::LineBelow, Wish::Draws, Wish::Map],
    checked: "names and clip of mjlab 1.6.0",
    source: "https://mujocolab.github.io/mjlab/v1.6.0/source/api/actuator.html",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("armature"),
        Fact::Damping => Cell::Said("viscous_damping"),
        Fact::Friction => Cell::Said("frictionloss"),
        Fact::FrictionAtRest => Cell::Not("frictionloss is the same at rest"),
        Fact::PeakTorque => Cell::Said("effort_limit"),
        Fact::TorqueSpeed => {
            Cell::Said("saturation_effort, velocity_limit: a straight line; how far it is off is in the comment")
        }
        Fact::Braking => Cell::Approximately("as much as while it drives, at every speed"),
        Fact::ContinuousTorque | Fact::Heating => Cell::Not("nothing heats"),
        Fact::MechanicalSpeed => Cell::Not("MuJoCo has no velocity limit"),
        Fact::GearLoss => {
            Cell::Approximately("none, or with the option `with-efficiency` that of driving in the largest torque")
        }
        Fact::Compliance | Fact::Backlash => Cell::Not("it needs a joint of its own, in the model"),
        Fact::Cogging | Fact::OtherEffects => Cell::Not("an actuator has no such term"),
        Fact::ElectricalTime => Cell::Not("the torque follows its command at once; `delay_min_lag` has whole steps"),
        Fact::Transmission => Cell::Not("a model needs the links themselves"),
        Fact::Spring => Cell::Not("it belongs to the joint of the model: `stiffness` and `springref`"),
        Fact::Ranges => Cell::Approximately(
            "for `dr.joint_armature`, `dr.joint_damping`, `dr.joint_friction`, `dr.effort_limits`; others in the comment",
        ),
    }
}

fn text(origin: &Origin, joints: &[Exported], wishes: &Wishes) -> Result<String, String> {
    let comments = comment_lines(origin, joints, (says, wishes), |e| line_remarks(e, wishes));
    module((&comments, "from mjlab.actuator import DcMotorActuatorCfg"), origin, joints, |e| {
        let s = &e.simulated;
        let line = wishes.line(e, "saturation_effort")?;
        let mut call = Call::new(
            "DcMotorActuatorCfg",
            "of the functions of `mjlab.envs.mdp.dr` of these names, with operation \"abs\"",
        );
        // One name is a tuple with its comma.
        call.with("target_names_expr", format!("({},)", expressions(e, wishes).join(", ")), "");
        call.number("effort_limit", line.effort, format!("N*m, {}", wishes.side(e)));
        call.number("saturation_effort", line.stall, "N*m, of the line at standstill");
        call.number("velocity_limit", line.no_load, "rad/s, where the voltage leaves no torque");
        call.optional("armature", s.armature, "kg*m^2");
        call.optional("frictionloss", s.friction_loss, "N*m");
        call.optional("viscous_damping", s.damping, "N*m*s/rad");
        call.with("stiffness", "stiffness", "");
        call.with("damping", "damping", "a gain, not friction");
        call.range("joint_armature", e, "armature");
        call.range("joint_damping", e, "damping");
        call.range("joint_friction", e, "friction_loss");
        call.range("effort_limits", e, "effort");
        Ok(call)
    })
}
