//! ros2_control: interfaces with their limits, and the reduction of a `SimpleTransmission`.
//!
//! The transmission turns actuator into joint: effort × N, velocity / N. Hardware plugins are the user's.

use super::urdf::not;
use super::{Cell, Exported, Format, Origin, Wishes, comment, comment_lines, digits, escape};
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "ros2_control",
    about: "ROS 2: limits of the interfaces and SimpleTransmission, for the URDF of a robot",
    text: |origin, joints, _| Ok(text(origin, joints)),
    says,
    takes: &[],
    checked: "XML alone: there is no reader to run",
    source: "https://control.ros.org/rolling/doc/ros2_control/transmission_interface/doc/transmission_interface_userdoc.html",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::PeakTorque => Cell::Said("min, max of the command interface `effort`"),
        Fact::Armature | Fact::Damping | Fact::Friction => {
            Cell::Not("hardware has it; a simulator reads it in its own model")
        }
        Fact::MechanicalSpeed => Cell::Approximately(
            "min, max of the command interface `velocity` are the least of it and the speed without load",
        ),
        _ => not(fact),
    }
}

fn remarks(e: &Exported) -> Vec<String> {
    let s = &e.simulated;
    let number = crate::number;
    let mut lines =
        vec!["written from the documentation: nothing here reads it; the hardware's plugin is yours".to_string()];
    lines.extend(s.effort().map(|b| format!("effort by the {}, {} N*m", b.owner, number(b.value))));
    lines.push(format!("velocity by the {}, {} rad/s", s.speed.owner, number(s.speed.value)));
    lines
}

fn text(origin: &Origin, joints: &[Exported]) -> String {
    let mut out = comment(&comment_lines(origin, joints, (says, &Wishes::default()), remarks));
    let robot = escape(&origin.robot);
    out.push_str(&format!("\n<robot name=\"{robot}\">\n  <ros2_control name=\"{robot}\" type=\"system\">\n"));
    out.push_str("    <hardware>\n      <!-- your plugin -->\n    </hardware>\n");
    for e in joints {
        let s = &e.simulated;
        let name = escape(e.joint);
        out.push_str(&format!("    <joint name=\"{name}\">\n"));
        let effort = s.effort().map(|b| ("effort", b.value));
        for (interface, most) in effort.into_iter().chain([("velocity", s.speed.value)]) {
            let most = digits(most);
            out.push_str(&format!(
                "      <command_interface name=\"{interface}\">\n        <param name=\"min\">-{most}</param>\n        <param name=\"max\">{most}</param>\n      </command_interface>\n"
            ));
        }
        for interface in ["position", "velocity", "effort"] {
            out.push_str(&format!("      <state_interface name=\"{interface}\"/>\n"));
        }
        out.push_str("    </joint>\n");
    }
    for e in joints {
        let name = escape(e.joint);
        out.push_str(&format!(
            "    <transmission name=\"{name}_transmission\">\n      <plugin>transmission_interface/SimpleTransmission</plugin>\n      <actuator name=\"{name}_motor\" role=\"actuator1\"/>\n      <joint name=\"{name}\" role=\"joint1\">\n        <mechanical_reduction>{}</mechanical_reduction>\n      </joint>\n    </transmission>\n",
            // A reduction below zero turns the joint against the actuator.
            digits(if e.simulated.is_reversed { -e.simulated.ratio } else { e.simulated.ratio })
        ));
    }
    out.push_str("  </ros2_control>\n</robot>\n");
    out
}
