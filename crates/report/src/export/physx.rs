//! PhysX in USD: the drive with its performance envelope, and the friction of the joint's axis.
//!
//! `|ω| ≤ maxActuatorVelocity − speedEffortGradient |τ|`, in degrees; symmetric, so that braking is too weak. PhysX 5.6 and
//! later (Isaac Sim 5). Written from its documentation alone: no engine that reads it runs in this project's checks.

use super::usd::{Joint, layer};
use super::{Cell, Exported, Format, Origin, Wish, Wishes, comment_lines, digits, line_remarks};
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "physx",
    about: "PhysX 5.6 in USD (Isaac Sim 5): a layer with drive envelope and friction",
    text,
    says,
    takes: &[Wish::WithEfficiency, Wish::LineBelow, Wish::Map],
    checked: "usd-core 26.11 as text; no engine",
    source: "https://docs.omniverse.nvidia.com/kit/docs/omni_physics/latest/dev_guide/joints/drives.html",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("physxJointAxis:angular:armature"),
        Fact::Damping => Cell::Said("physxJointAxis:angular:viscousFrictionCoefficient, per degree"),
        Fact::Friction => Cell::Said("physxJointAxis:angular:dynamicFrictionEffort"),
        Fact::FrictionAtRest => {
            Cell::Said("physxJointAxis:angular:staticFrictionEffort; where it is not known, that while it moves")
        }
        Fact::PeakTorque => Cell::Said("drive:angular:physics:maxForce"),
        Fact::TorqueSpeed => {
            Cell::Said("maxActuatorVelocity, speedEffortGradient: a straight line; how far it is off is in the comment")
        }
        Fact::Braking => Cell::Not("the envelope is the same while it brakes: too weak"),
        Fact::ContinuousTorque | Fact::Heating => Cell::Not("nothing heats"),
        Fact::MechanicalSpeed => Cell::Said("physxJointAxis:angular:maxJointVelocity, in degrees"),
        Fact::GearLoss => {
            Cell::Approximately("none, or with the option `with-efficiency` that of driving in the largest torque")
        }
        Fact::Compliance | Fact::Backlash => {
            Cell::Not("it needs a body for the rotor and a joint of its own, in the stage")
        }
        Fact::Cogging | Fact::OtherEffects => Cell::Not("a joint has no such term"),
        Fact::ElectricalTime => Cell::Not("the torque follows its command at once"),
        Fact::Transmission => Cell::Not("a stage needs the links themselves"),
        Fact::Spring => Cell::Not("it belongs to the joint of the stage"),
        Fact::Ranges => Cell::Approximately("in the comment"),
    }
}

fn text(origin: &Origin, joints: &[Exported], wishes: &Wishes) -> Result<String, String> {
    let remarks = |e: &Exported| {
        let mut lines = vec![
            "written from the documentation of PhysX: no engine has read it; the gains of the drive are yours"
                .to_string(),
        ];
        lines.extend(line_remarks(e, wishes));
        lines
    };
    let comments = comment_lines(origin, joints, (says, wishes), remarks);
    layer(&comments, origin, joints, wishes, |e| {
        let s = &e.simulated;
        let line = wishes.line(e, "speedEffortGradient")?;
        let float = |key: &str, value: f64| format!("float {key} = {}", digits(value));
        let axis = |key: &str, value: f64| float(&format!("physxJointAxis:angular:{key}"), value);
        let envelope = |key: &str, value: f64| float(&format!("physxDrivePerformanceEnvelope:angular:{key}"), value);
        let mut lines = vec![
            float("drive:angular:physics:maxForce", line.effort),
            envelope("maxActuatorVelocity", line.no_load.to_degrees()),
            envelope("speedEffortGradient", (line.no_load / line.stall).to_degrees()),
        ];
        lines.extend(s.armature.map(|armature| axis("armature", armature)));
        lines.extend(s.damping.map(|damping| axis("viscousFrictionCoefficient", damping.to_radians())));
        if let Some(loss) = s.friction_loss {
            lines.push(axis("dynamicFrictionEffort", loss));
            lines.push(axis("staticFrictionEffort", loss + s.friction_at_rest.unwrap_or(0.0)));
        }
        lines.extend(s.mechanical_speed.map(|speed| axis("maxJointVelocity", speed.value.to_degrees())));
        let schemas =
            vec!["PhysicsDriveAPI:angular", "PhysxDrivePerformanceEnvelopeAPI:angular", "PhysxJointAxisAPI:angular"];
        Ok(Joint { schemas, lines, actuator: None })
    })
}
