//! SDFormat: limits and dynamics of a joint's axis, and Drake's rotor inertia and gear ratio as text.

use super::mjcf::element_of;
use super::urdf::{DRAKE, not};
use super::{Cell, Exported, Format, Origin, Wishes, comment, comment_lines, digits, escape};
use crate::number;
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "sdf",
    about: "SDFormat (Gazebo, Drake): limits, friction and Drake's rotor inertia",
    text: |origin, joints, _| Ok(text(origin, joints)),
    says,
    takes: &[],
    checked: "Drake 1.51",
    source: "http://sdformat.org/spec?elem=joint, https://drake.mit.edu/doxygen_cxx/group__multibody__parsing.html",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Approximately("Drake reads it as rotor_inertia × gear_ratio²; others read none"),
        Fact::Damping => Cell::Said("axis/dynamics/damping"),
        Fact::Friction => Cell::Said("axis/dynamics/friction"),
        Fact::PeakTorque => Cell::Said("axis/limit/effort"),
        _ => not(fact),
    }
}

/// Elements of `axis/limit` with their texts.
pub fn limits(e: &Exported) -> Vec<(&'static str, String)> {
    let mut limits: Vec<_> = e.simulated.effort().map(|b| ("effort", digits(b.value))).into_iter().collect();
    limits.push(("velocity", digits(e.simulated.speed.value)));
    limits
}

/// Elements of `axis/dynamics`.
pub fn dynamics(e: &Exported) -> Vec<(&'static str, String)> {
    super::urdf::dynamics_attributes(e)
}

/// Drake's elements of a joint.
pub fn of_drake(e: &Exported) -> Vec<(&'static str, String)> {
    let s = &e.simulated;
    let mut elements: Vec<_> =
        s.inertias.map(|(rotor, gear)| ("drake:rotor_inertia", digits(rotor + gear))).into_iter().collect();
    elements.push(("drake:gear_ratio", digits(s.ratio)));
    elements
}

fn remarks(e: &Exported) -> Vec<String> {
    let s = &e.simulated;
    let mut lines: Vec<String> =
        s.effort().map(|b| format!("effort by the {}, {} N*m", b.owner, number(b.value))).into_iter().collect();
    lines.push(format!("velocity by the {}, {} rad/s", s.speed.owner, number(s.speed.value)));
    lines
}

/// The comment with provenance and what is left out.
pub fn header(origin: &Origin, joints: &[Exported]) -> String {
    comment(&comment_lines(origin, joints, (says, &Wishes::default()), remarks))
}

/// A section of an axis, on lines of its own; nothing where nothing is known.
pub fn section(tag: &str, elements: &[(&'static str, String)], indent: &str) -> String {
    if elements.is_empty() {
        return String::new();
    }
    let inner = elements.iter().map(|(name, value)| format!("{indent}  {}\n", element_of(name, value)));
    format!("{indent}<{tag}>\n{}{indent}</{tag}>\n", inner.collect::<String>())
}

fn text(origin: &Origin, joints: &[Exported]) -> String {
    let mut out = header(origin, joints);
    out.push_str(
        "\n<!-- copy limit, dynamics and Drake's elements into the joint of the same name, or let `gearwise export`\n",
    );
    out.push_str(
        "     write into the model, with its option `into`; links, axes and ranges of angle are the model's -->\n",
    );
    out.push_str(&format!(
        "<sdf version=\"1.9\" xmlns:drake=\"{DRAKE}\">\n  <model name=\"{}\">\n",
        escape(&origin.robot)
    ));
    for e in joints {
        out.push_str(&format!("    <joint name=\"{}\" type=\"revolute\">\n      <axis>\n", escape(e.joint)));
        out.push_str(&section("limit", &limits(e), "        "));
        out.push_str(&section("dynamics", &dynamics(e), "        "));
        out.push_str("      </axis>\n");
        of_drake(e).iter().for_each(|(name, value)| out.push_str(&format!("      {}\n", element_of(name, value))));
        out.push_str("    </joint>\n");
    }
    out.push_str("  </model>\n</sdf>\n");
    out
}
