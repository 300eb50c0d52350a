//! Isaac Lab: `DCMotorCfg`, whose clip is the line of torque over speed. In 3.0 three of its keys have other names.
//!
//! `friction` and `dynamic_friction` are torques from Isaac Sim 5 on; before, they were coefficients. `stiffness` and
//! `damping` are gains of the controller: viscous friction is `viscous_friction`.

use super::python::{Call, expressions, module};
use super::{Cell, Exported, Format, Origin, Wish, Wishes, comment_lines, digits, line_remarks, table_remarks};
use gearwise_select::simulated::Fact;

/// Isaac Lab 2.
pub const LAB2: Format = Format {
    name: "isaaclab2",
    about: "Isaac Lab 2.x: `DCMotorCfg` in Python",
    text: |origin, joints, wishes| text(&TWO, origin, joints, wishes),
    says: says_two,
    takes: &[Wish::WithEfficiency, Wish::LineBelow, Wish::Draws, Wish::Map],
    checked: "names and clip of isaaclab 2.3.2",
    source: "https://isaac-sim.github.io/IsaacLab/v2.3.2/source/api/lab/isaaclab.actuators.html",
};

/// Isaac Lab 3.
pub const LAB3: Format = Format {
    name: "isaaclab3",
    about: "Isaac Lab 3.0: `DCMotorCfg` in Python with the names of that version",
    text: |origin, joints, wishes| text(&THREE, origin, joints, wishes),
    says: says_three,
    takes: &[Wish::WithEfficiency, Wish::LineBelow, Wish::Draws, Wish::Map],
    checked: "names of the sources of Isaac Lab 3.0",
    source: "https://isaac-sim.github.io/IsaacLab/main/source/api/lab/isaaclab.actuators.html",
};

/// Names that differ between versions.
struct Version {
    effort: &'static str,
    velocity: &'static str,
    solver_velocity: &'static str,
    needs: &'static str,
    says: fn(Fact) -> Cell,
}

const TWO: Version = Version {
    effort: "effort_limit",
    velocity: "velocity_limit",
    solver_velocity: "velocity_limit_sim",
    needs: "Isaac Lab 2.x with Isaac Sim 5 (before, friction was a coefficient: leave it out there)",
    says: says_two,
};

const THREE: Version = Version {
    effort: "actuator_effort_limit",
    velocity: "actuator_velocity_limit",
    solver_velocity: "joint_velocity_limit",
    needs: "Isaac Lab 3.0",
    says: says_three,
};

fn says_two(fact: Fact) -> Cell {
    match fact {
        Fact::PeakTorque => Cell::Said("effort_limit"),
        Fact::TorqueSpeed => {
            Cell::Said("saturation_effort, velocity_limit: a straight line; how far it is off is in the comment")
        }
        Fact::MechanicalSpeed => Cell::Said("velocity_limit_sim"),
        _ => says_both(fact),
    }
}

fn says_three(fact: Fact) -> Cell {
    match fact {
        Fact::PeakTorque => Cell::Said("actuator_effort_limit"),
        Fact::TorqueSpeed => Cell::Said(
            "saturation_effort, actuator_velocity_limit: a straight line; how far it is off is in the comment",
        ),
        Fact::MechanicalSpeed => Cell::Said("joint_velocity_limit"),
        _ => says_both(fact),
    }
}

fn says_both(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("armature"),
        Fact::Damping => Cell::Said("viscous_friction"),
        Fact::Friction => Cell::Said("dynamic_friction"),
        Fact::FrictionAtRest => Cell::Said("friction; where it is not known, that while it moves"),
        Fact::Braking => Cell::Approximately("as much as while it drives, at every speed"),
        Fact::ContinuousTorque | Fact::Heating => Cell::Not("nothing heats"),
        Fact::GearLoss => {
            Cell::Approximately("none, or with the option `with-efficiency` that of driving in the largest torque")
        }
        Fact::Compliance | Fact::Backlash => {
            Cell::Not("it needs a link for the rotor and a joint of its own, in the asset")
        }
        Fact::Cogging | Fact::OtherEffects => Cell::Not("an actuator has no such term"),
        Fact::ElectricalTime => Cell::Not("the torque follows its command at once; `DelayedPDActuatorCfg` has a delay"),
        Fact::Transmission => Cell::Approximately(
            "RemotizedPDActuatorCfg: torque over the angle, not over speed; inertia and friction go with the angle and are left out",
        ),
        Fact::Spring => Cell::Not("it belongs to the joint of the asset"),
        Fact::Ranges => Cell::Approximately(
            "armature for `randomize_joint_parameters`, others in the comment: its friction would set viscous friction, too",
        ),
        Fact::PeakTorque | Fact::TorqueSpeed | Fact::MechanicalSpeed => Cell::Not("it has no place"),
    }
}

fn text(version: &Version, origin: &Origin, joints: &[Exported], wishes: &Wishes) -> Result<String, String> {
    let remarks = |e: &Exported| {
        let mut lines = vec![version.needs.to_string()];
        match e.simulated.over_angle.is_empty() {
            true => lines.extend(line_remarks(e, wishes)),
            false => lines.extend(table_remarks(e)),
        }
        if wishes.has_range_of(e, "friction_loss") {
            lines.push(
                "friction has no range in the code: `randomize_joint_parameters` would set viscous friction to it, too"
                    .into(),
            );
        }
        lines
    };
    let comments = comment_lines(origin, joints, (version.says, wishes), remarks);
    let is_table = |e: &Exported| !e.simulated.over_angle.is_empty();
    let imports = match (joints.iter().any(is_table), joints.iter().all(is_table)) {
        (false, _) => "from isaaclab.actuators import DCMotorCfg",
        (true, true) => "from isaaclab.actuators import RemotizedPDActuatorCfg",
        (true, false) => "from isaaclab.actuators import DCMotorCfg, RemotizedPDActuatorCfg",
    };
    module((&comments, imports), origin, joints, |e| {
        if is_table(e) {
            return over_angle(e, wishes);
        }
        let s = &e.simulated;
        let line = wishes.line(e, "saturation_effort")?;
        let mut call = Call::new(
            "DCMotorCfg",
            "parameters of `randomize_joint_parameters`, with operation \"abs\" and distribution \"uniform\"",
        );
        call.with("joint_names_expr", format!("[{}]", expressions(e, wishes).join(", ")), "");
        call.number(version.effort, line.effort, format!("N*m, {}", wishes.side(e)));
        call.number("saturation_effort", line.stall, "N*m, of the line at standstill");
        call.number(version.velocity, line.no_load, "rad/s, where the voltage leaves no torque");
        call.optional(version.solver_velocity, s.mechanical_speed.map(|b| b.value), "rad/s, of motor and gear");
        call.optional("armature", s.armature, "kg*m^2");
        call.optional("viscous_friction", s.damping, "N*m*s/rad");
        let at_rest = s.friction_loss.map(|loss| loss + s.friction_at_rest.unwrap_or(0.0));
        let known = if s.friction_at_rest.is_some() {
            "N*m, at rest"
        } else {
            "N*m, at rest: not known apart, that while it moves"
        };
        call.optional("friction", at_rest, known);
        call.optional("dynamic_friction", s.friction_loss, "N*m, while it moves");
        call.with("stiffness", "stiffness", "");
        call.with("damping", "damping", "a gain, not friction");
        call.range("armature_distribution_params", e, "armature");
        Ok(call)
    })
}

/// An actuator whose ratio goes with the joint's angle: torque over the angle, and nothing over speed.
fn over_angle(e: &Exported, wishes: &Wishes) -> Result<Call, String> {
    let mut call = Call::new("RemotizedPDActuatorCfg", "");
    call.with("joint_names_expr", format!("[{}]", expressions(e, wishes).join(", ")), "");
    let factor = wishes.efficiency(e)?;
    let rows = e
        .simulated
        .over_angle
        .iter()
        .map(|[q, ratio, torque]| format!("[{}]", [*q, *ratio, torque * factor].map(digits).join(", ")));
    let rows = rows.collect::<Vec<_>>().join(",\n            ");
    call.with(
        "joint_parameter_lookup",
        format!("[\n            {rows},\n        ]"),
        format!("rad, N r, N*m, {}", wishes.side(e)),
    );
    call.with("stiffness", "stiffness", "");
    call.with("damping", "damping", "a gain, not friction");
    Ok(call)
}
