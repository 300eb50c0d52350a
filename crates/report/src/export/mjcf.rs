//! MuJoCo's XML: a default class with armature, damping, friction loss and limits, and a motor for each joint.
//!
//! The command of the motor is the electromagnetic torque at the motor's shaft \[N·m\], `K_T i`; `gear` is N.
//! `actuatorfrcrange` limits what reaches the joint whichever kind of actuator drives it.

use super::{Cell, Exported, Format, Origin, Wishes, comment, comment_lines, digits, escape, range};
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "mjcf",
    about: "MuJoCo's XML: default classes and motors, to be included in a model",
    text: |origin, joints, _| Ok(text(origin, joints)),
    says,
    takes: &[],
    checked: "MuJoCo 4.0",
    source: "https://mujoco.readthedocs.io/en/stable/XMLreference.html",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("joint armature"),
        Fact::Damping => Cell::Said("joint damping"),
        Fact::Friction => Cell::Said("joint frictionloss"),
        Fact::FrictionAtRest => Cell::Not("frictionloss is the same at rest"),
        Fact::PeakTorque => Cell::Said("motor forcerange, joint actuatorfrcrange"),
        Fact::TorqueSpeed => Cell::Not("a motor has its torque at every speed; `dcmotor` has the line"),
        Fact::Braking => Cell::Approximately("as much as while it drives"),
        Fact::ContinuousTorque => Cell::Not("nothing heats"),
        Fact::MechanicalSpeed => Cell::Not("MJCF has no velocity limit"),
        Fact::GearLoss => Cell::Not("a joint has no loss in proportion to the load"),
        Fact::Compliance => {
            Cell::Not("only into a model, with the option `gear-joint`: a second joint with this stiffness")
        }
        Fact::Backlash => Cell::Not("only into a model, with the option `gear-joint`: a second joint with this range"),
        Fact::Cogging => Cell::Not("a motor has none; `dcmotor` has one order"),
        Fact::OtherEffects => Cell::Not("a joint has no such term"),
        Fact::ElectricalTime => Cell::Not("the torque follows its command at once"),
        Fact::Heating => Cell::Not("nothing heats; `dcmotor` has it with its option `thermal`"),
        Fact::Transmission => Cell::Not("a model needs the links themselves"),
        Fact::Spring => Cell::Not("it belongs to the joint of the model: `stiffness` and `springref`"),
        Fact::Ranges => Cell::Approximately("in the comment"),
    }
}

/// The class that a joint's attributes stand in.
pub fn class(joint: &str) -> String {
    format!("{joint}_actuator")
}

/// Attributes of the joint with their values, in order.
pub fn joint_attributes(e: &Exported) -> Vec<(&'static str, String)> {
    let s = &e.simulated;
    let mut attributes: Vec<_> = s.armature.map(|armature| ("armature", digits(armature))).into_iter().collect();
    attributes.extend(s.damping.map(|d| ("damping", digits(d))));
    attributes.extend(s.friction_loss.map(|f| ("frictionloss", digits(f))));
    if let Some(effort) = s.effort() {
        attributes.push(("actuatorfrclimited", "true".into()));
        attributes.push(("actuatorfrcrange", range(effort.value)));
    }
    attributes
}

/// Attributes of the motor with their values, in order.
pub fn motor_attributes(e: &Exported) -> Vec<(&'static str, String)> {
    let mut attributes = vec![("gear", digits(e.simulated.ratio))];
    if let Some(torque) = e.simulated.motor_torque {
        attributes.push(("ctrllimited", "true".into()));
        attributes.push(("ctrlrange", range(torque.value)));
        attributes.push(("forcelimited", "true".into()));
        attributes.push(("forcerange", range(torque.value)));
    }
    attributes
}

/// What MJCF has no attribute for, and what its numbers mean.
fn remarks(e: &Exported) -> Vec<String> {
    let s = &e.simulated;
    let number = crate::number;
    let mut lines = Vec::new();
    if let (Some(torque), Some(effort)) = (s.motor_torque, s.effort()) {
        lines.push(format!(
            "ctrl is torque at the motor [N*m]{}; by the {} at most {} N*m, {} N*m at the output",
            s.torque_constant.map_or_else(String::new, |k| format!(", K_T i with K_T = {} N*m/A (q axis)", number(k))),
            torque.owner,
            number(torque.value),
            number(effort.value)
        ));
    }
    lines.push(format!(
        "left out: velocity limit {} rad/s (by the {}): MJCF has none",
        number(s.speed.value),
        s.speed.owner
    ));
    lines
}

/// The comment with provenance and what is left out.
pub fn header(origin: &Origin, joints: &[Exported]) -> String {
    comment(&comment_lines(origin, joints, (says, &Wishes::default()), remarks))
}

/// An element of a tag with attributes.
pub fn element(tag: &str, attributes: &[(&'static str, String)]) -> String {
    let attributes = attributes.iter().map(|(name, value)| format!(" {name}=\"{}\"", escape(value)));
    format!("<{tag}{}/>", attributes.collect::<String>())
}

/// An element with a text.
pub fn element_of(tag: &str, text: &str) -> String {
    format!("<{tag}>{}</{tag}>", escape(text))
}

/// A file to be included in a model: its joints take the class, `<joint name="knee" class="knee_actuator" …/>`.
fn text(origin: &Origin, joints: &[Exported]) -> String {
    let mut out = header(origin, joints);
    out.push_str("\n<!-- include this file, and give each joint its class, as in <joint name=\"knee\" class=\"knee_actuator\"/>;\n");
    out.push_str("     or let `gearwise export` write into the model, with its option `into` -->\n");
    out.push_str("<mujoco>\n  <default>\n");
    for e in joints {
        out.push_str(&format!("    <default class=\"{}\">\n", escape(&class(e.joint))));
        out.push_str(&format!("      {}\n", element("joint", &joint_attributes(e))));
        out.push_str(&format!("      {}\n", element("motor", &motor_attributes(e))));
        out.push_str("    </default>\n");
    }
    out.push_str("  </default>\n  <actuator>\n");
    for e in joints {
        let name = e.joint.to_string();
        let attributes = [("name", name.clone()), ("class", class(e.joint)), ("joint", name)];
        out.push_str(&format!("    {}\n", element("motor", &attributes)));
    }
    out.push_str("  </actuator>\n</mujoco>\n");
    out
}
