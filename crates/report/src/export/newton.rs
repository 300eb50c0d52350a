//! Newton's USD schemas: `NewtonJointAPI` at the joint, and a `NewtonActuator` whose clip is the line of torque over speed.
//!
//! At the joint angles are degrees: damping is N·m·s per degree, the limit of speed degrees per second; at the actuator they
//! are radians. Source: `newton_usd_schemas` 0.6, `generatedSchema.usda`.

use super::usd::{Joint, layer};
use super::{Cell, Exported, Format, Origin, Wish, Wishes, comment_lines, digits, line_remarks, table_remarks};
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "newton",
    about: "Newton's USD schemas: a layer with joints and actuators",
    text,
    says,
    takes: &[Wish::WithEfficiency, Wish::LineBelow, Wish::Map],
    checked: "usd-core 26.11 with newton_usd_schemas 0.6; Newton 1.8 by hand",
    source: "https://github.com/newton-physics/newton-usd-schemas",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("newton:armature"),
        Fact::Damping => Cell::Said("newton:damping, per degree"),
        Fact::Friction => Cell::Said("newton:friction"),
        Fact::FrictionAtRest => Cell::Not("newton:friction is the same at rest"),
        Fact::PeakTorque => Cell::Said("newton:maxMotorEffort"),
        Fact::TorqueSpeed => Cell::Said(
            "newton:saturationEffort, newton:velocityLimit of the actuator: a straight line; how far it is off is in the comment",
        ),
        Fact::Braking => Cell::Approximately("as much as while it drives, at every speed"),
        Fact::ContinuousTorque | Fact::Heating => Cell::Not("nothing heats"),
        Fact::MechanicalSpeed => Cell::Said("newton:velocityLimit of the joint, in degrees"),
        Fact::GearLoss => {
            Cell::Approximately("none, or with the option `with-efficiency` that of driving in the largest torque")
        }
        Fact::Compliance | Fact::Backlash => {
            Cell::Not("it needs a body for the rotor and a joint of its own, in the stage")
        }
        Fact::Cogging | Fact::OtherEffects => Cell::Not("an actuator has no such term"),
        Fact::ElectricalTime => {
            Cell::Not("the torque follows its command at once; `NewtonActuatorDelayAPI` has whole steps")
        }
        Fact::Transmission => Cell::Approximately(
            "newton:lookupPositions, newton:lookupEfforts: torque over the angle, not over speed; inertia and friction go with the angle and are left out",
        ),
        Fact::Spring => Cell::Not("it belongs to the joint of the stage"),
        Fact::Ranges => Cell::Approximately("in the comment"),
    }
}

fn text(origin: &Origin, joints: &[Exported], wishes: &Wishes) -> Result<String, String> {
    let remarks = |e: &Exported| {
        let mut lines = vec![
            "the gains newton:kp and newton:kd of the actuator are yours; without them it gives no torque".to_string(),
        ];
        match e.simulated.over_angle.is_empty() {
            true => lines.extend(line_remarks(e, wishes)),
            false => lines.extend(table_remarks(e)),
        }
        lines
    };
    let comments = comment_lines(origin, joints, (says, wishes), remarks);
    layer(&comments, origin, joints, wishes, |e| {
        let s = &e.simulated;
        if !s.over_angle.is_empty() {
            let list =
                |column: usize| s.over_angle.iter().map(|row| digits(row[column])).collect::<Vec<_>>().join(", ");
            let lines = vec![
                format!("float[] newton:lookupPositions = [{}]", list(0)),
                format!("float[] newton:lookupEfforts = [{}]", list(2)),
            ];
            let schemas = vec!["NewtonPDControlAPI", "NewtonPositionBasedClampingAPI"];
            return Ok(Joint { actuator: Some(("NewtonActuator", schemas, lines)), ..Joint::default() });
        }
        let line = wishes.line(e, "newton:saturationEffort")?;
        let float = |key: &str, value: f64| format!("float newton:{key} = {}", digits(value));
        let mut lines = Vec::new();
        lines.extend(s.armature.map(|armature| float("armature", armature)));
        lines.extend(s.damping.map(|damping| float("damping", damping.to_radians())));
        lines.extend(s.friction_loss.map(|friction| float("friction", friction)));
        lines.extend(s.mechanical_speed.map(|speed| float("velocityLimit", speed.value.to_degrees())));
        let clamp = vec![
            float("maxMotorEffort", line.effort),
            float("saturationEffort", line.stall),
            float("velocityLimit", line.no_load),
        ];
        let schemas = vec!["NewtonPDControlAPI", "NewtonDCMotorClampingAPI"];
        Ok(Joint { schemas: vec!["NewtonJointAPI"], lines, actuator: Some(("NewtonActuator", schemas, clamp)) })
    })
}
