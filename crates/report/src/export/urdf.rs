//! URDF: limits, friction and a transmission for each joint.
//!
//! URDF has no armature. Drake reads rotor inertia and gear ratio in its own elements of the transmission's
//! actuator (`drake:rotor_inertia`, at the motor, times `drake:gear_ratio`²); for others it stands in a comment.

use super::{Cell, Exported, Format, Origin, Wish, Wishes, comment, comment_lines, digits, escape};
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "urdf",
    about: "Limits, friction and transmissions, with Drake's rotor inertia",
    text: |origin, joints, wishes| Ok(text(origin, joints, wishes)),
    says,
    takes: &[Wish::Drake],
    checked: "Drake 1.51, MuJoCo 4.0",
    source: "https://wiki.ros.org/urdf/XML/joint, https://drake.mit.edu/doxygen_cxx/group__multibody__parsing.html",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => {
            Cell::Approximately("Drake reads it in the transmission, as rotor_inertia × gear_ratio²; others read none")
        }
        Fact::Damping => Cell::Said("dynamics damping"),
        Fact::Friction => Cell::Said("dynamics friction"),
        Fact::FrictionAtRest => Cell::Not("friction is the same at rest"),
        Fact::PeakTorque => Cell::Said("limit effort"),
        _ => not(fact),
    }
}

/// What neither URDF nor SDF has a place for.
pub(super) fn not(fact: Fact) -> Cell {
    match fact {
        Fact::MechanicalSpeed => {
            Cell::Approximately("the limit of velocity is the least of it and the speed without load")
        }
        Fact::TorqueSpeed => Cell::Not("it has a box of torque and speed"),
        Fact::Braking => Cell::Approximately("as much as while it drives"),
        Fact::ContinuousTorque | Fact::Heating => Cell::Not("nothing heats"),
        Fact::GearLoss => Cell::Not("a joint has no loss in proportion to the load"),
        Fact::Compliance | Fact::Backlash => Cell::Not("it needs a link for the rotor and a joint of its own"),
        Fact::Cogging | Fact::OtherEffects | Fact::FrictionAtRest => Cell::Not("a joint has no such term"),
        Fact::ElectricalTime => Cell::Not("the torque follows its command at once"),
        Fact::Transmission => Cell::Not("a model needs the links themselves"),
        Fact::Spring => Cell::Not("a joint has no such term"),
        Fact::Ranges => Cell::Approximately("in the comment"),
        Fact::Armature | Fact::Damping | Fact::Friction | Fact::PeakTorque => Cell::Not("it has no place"),
    }
}

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
    let number = crate::number;
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
    comment(&comment_lines(origin, joints, (says, &Wishes::default()), remarks))
}

/// Rotor and gear in a transmission, for a joint of the model's name; lines are indented by `indent`.
pub fn transmission(e: &Exported, joint: &str, indent: &str, wishes: &Wishes) -> String {
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
        match wishes.for_drake {
            true => String::new(),
            false => format!("    <mechanicalReduction>{}</mechanicalReduction>", digits(s.ratio)),
        },
        rotor.unwrap_or_default(),
        format!("    <drake:gear_ratio value=\"{}\"/>", digits(s.ratio)),
        "  </actuator>".into(),
        "</transmission>".into(),
    ];
    lines.iter().filter(|line| !line.is_empty()).map(|line| format!("{indent}{line}\n")).collect()
}

/// What goes into the joints of a robot. It is no robot by itself: links, axes and ranges are the model's.
fn text(origin: &Origin, joints: &[Exported], wishes: &Wishes) -> String {
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
        out.push_str(&transmission(e, e.joint, "  ", wishes));
    }
    out.push_str("</robot>\n");
    out
}
