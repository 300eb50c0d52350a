//! URDF: limits, friction and a transmission for each joint.
//!
//! URDF has no armature. Drake reads rotor inertia and gear ratio in its own elements of the transmission's
//! actuator (`drake:rotor_inertia`, at the motor, times `drake:gear_ratio`²); for others it stands in a comment.

use super::{Exported, Origin, comment, comment_lines, digits, escape};

/// Namespace of Drake's extensions.
pub const DRAKE: &str = "http://drake.mit.edu";

/// Attributes of `<limit>`: effort \[N·m\] where one is known, velocity \[rad/s\].
pub fn limit_attributes(e: &Exported) -> Vec<(&'static str, String)> {
    let mut attributes = Vec::new();
    attributes.extend(e.simulated.effort().map(|b| ("effort", digits(b.value))));
    attributes.push(("velocity", digits(e.simulated.speed.value)));
    attributes
}

/// Attributes of `<dynamics>`; what is not known is left to the reader's default.
pub fn dynamics_attributes(e: &Exported) -> Vec<(&'static str, String)> {
    let mut attributes = Vec::new();
    attributes.extend(e.simulated.damping.map(|d| ("damping", digits(d))));
    attributes.extend(e.simulated.friction_loss.map(|f| ("friction", digits(f))));
    attributes
}

fn remarks(e: &Exported) -> Vec<String> {
    let s = &e.simulated;
    let number = crate::report::number;
    let armature = |armature| {
        format!(
            "left out: armature {} kg*m^2 = N^2 (J_m + J_g): URDF has none; Drake reads J_m + J_g and N from the transmission",
            digits(armature)
        )
    };
    let mut lines: Vec<String> = s.armature.map(armature).into_iter().collect();
    lines.extend(s.effort().map(|b| format!("effort by the {}, {} N*m", b.owner, number(b.value))));
    lines.push(format!("velocity by the {}, {} rad/s", s.speed.owner, number(s.speed.value)));
    if s.effort().is_none() {
        lines.push("effort: URDF demands one, but none is known; write your own".into());
    }
    lines
}

/// The comment with provenance and what is left out.
pub fn header(origin: &Origin, joints: &[Exported]) -> String {
    comment(&comment_lines(origin, joints, remarks))
}

/// Rotor and gear in a transmission, for a joint of the model's name; lines are indented by `indent`.
pub fn transmission(e: &Exported, joint: &str, indent: &str) -> String {
    let s = &e.simulated;
    let joint = escape(joint);
    let rotor =
        s.inertias.map(|(rotor, gear)| format!("    <drake:rotor_inertia value=\"{}\"/>", digits(rotor + gear)));
    let lines = [
        format!("<transmission name=\"{joint}_transmission\">"),
        "  <type>transmission_interface/SimpleTransmission</type>".into(),
        format!("  <joint name=\"{joint}\">"),
        "    <hardwareInterface>hardware_interface/EffortJointInterface</hardwareInterface>".into(),
        "  </joint>".into(),
        format!("  <actuator name=\"{joint}_motor\">"),
        format!("    <mechanicalReduction>{}</mechanicalReduction>", digits(s.ratio)),
        rotor.unwrap_or_default(),
        format!("    <drake:gear_ratio value=\"{}\"/>", digits(s.ratio)),
        "  </actuator>".into(),
        "</transmission>".into(),
    ];
    lines.iter().filter(|line| !line.is_empty()).map(|line| format!("{indent}{line}\n")).collect()
}

/// What goes into the joints of a robot. It is no robot by itself: links, axes and ranges are the model's.
pub fn text(origin: &Origin, joints: &[Exported]) -> String {
    let mut out = header(origin, joints);
    out.push_str("\n<!-- copy limit and dynamics into the joint of the same name, or let `gearwise export` write\n");
    out.push_str("     into the model, with its option `into`; links, axes and ranges of angle are the model's -->\n");
    out.push_str(&format!("<robot name=\"{}\" xmlns:drake=\"{DRAKE}\">\n", escape(&origin.robot)));
    for e in joints {
        out.push_str(&format!("  <joint name=\"{}\" type=\"revolute\">\n", escape(e.joint)));
        out.push_str(&format!("    {}\n", super::mjcf::element("limit", &limit_attributes(e))));
        let dynamics = dynamics_attributes(e);
        if !dynamics.is_empty() {
            out.push_str(&format!("    {}\n", super::mjcf::element("dynamics", &dynamics)));
        }
        out.push_str("  </joint>\n");
        out.push_str(&transmission(e, e.joint, "  "));
    }
    out.push_str("</robot>\n");
    out
}
