//! MuJoCo's `<dcmotor>` (3.12 and later): the motor with its voltage, so that torque falls with speed in all four quadrants.
//!
//! The command (`input="ff"`) is torque at the motor \[N·m\]; MuJoCo drives it with the voltage `(R/K) τ + K ω`, held within
//! ±V, and holds the torque within `saturation`. So it clips to a line through V/K without torque and K V/R at standstill. The
//! constants written are those of that line: K is K_T, V' = K N ω₀, R' = K V' N/s, which keeps stall, speed without load and
//! current right where K_T and K_B differ, of which MuJoCo would take the mean. Source: the documentation of `actuator/dcmotor`
//! and its technical note, "MuJoCo DC Motor Model".

use super::mjcf::{class, element};
use super::{
    Cell, Exported, Format, Origin, Wish, Wishes, comment, comment_lines, digits, escape, line_remarks, range,
};
use crate::number;
use gearwise_select::simulated::Fact;

/// The format.
pub const FORMAT: Format = Format {
    name: "dcmotor",
    about: "MuJoCo 3.12 and later: motors with voltage, so that torque falls with speed, to be included in a model",
    text,
    says,
    takes: &[Wish::WithEfficiency, Wish::LineBelow, Wish::Thermal, Wish::Electrical],
    checked: "MuJoCo 4.0",
    source: "https://mujoco.readthedocs.io/en/stable/XMLreference.html#actuator-dcmotor",
};

fn says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("dcmotor armature, at the motor: MuJoCo multiplies by gear²"),
        Fact::Damping => Cell::Said("dcmotor damping, at the motor: MuJoCo multiplies by gear²"),
        Fact::Friction => Cell::Said("joint frictionloss"),
        Fact::FrictionAtRest => {
            Cell::Not("frictionloss is the same at rest; `lugre` needs a stiffness of bristles that nobody measured")
        }
        Fact::PeakTorque => Cell::Said("saturation"),
        Fact::TorqueSpeed => {
            Cell::Said("motorconst, resistance, controller: a straight line; how far it is off is in the comment")
        }
        Fact::Braking => Cell::Approximately("as much as while it drives, at every speed"),
        Fact::ContinuousTorque => {
            Cell::Not("nothing ends a torque that lasts; the option `thermal` says how hot the winding is")
        }
        Fact::MechanicalSpeed => Cell::Not("MJCF has no velocity limit"),
        Fact::GearLoss => {
            Cell::Approximately("none, or with the option `with-efficiency` that of driving in the largest torque")
        }
        Fact::Compliance => {
            Cell::Not("only into a model, with the option `gear-joint`: a second joint with this stiffness")
        }
        Fact::Backlash => Cell::Not("only into a model, with the option `gear-joint`: a second joint with this range"),
        Fact::Cogging => Cell::Approximately("cogging: the largest order alone"),
        Fact::OtherEffects => Cell::Not("a joint has no such term"),
        Fact::ElectricalTime => Cell::Approximately("inductance, only with the option `electrical`"),
        Fact::Heating => Cell::Approximately(
            "thermal, only with the option `thermal`: one body, heated as if the winding were at its hottest",
        ),
        Fact::Transmission => Cell::Not("a model needs the links themselves"),
        Fact::Spring => Cell::Not("it belongs to the joint of the model: `stiffness` and `springref`"),
        Fact::Ranges => Cell::Approximately("in the comment"),
    }
}

/// Attributes of the joint: what the actuator says is none of it.
pub fn joint_attributes(e: &Exported) -> Vec<(&'static str, String)> {
    let mut attributes = vec![("armature", "0".to_string())];
    attributes.extend(e.simulated.damping.map(|_| ("damping", "0".to_string())));
    attributes.extend(e.simulated.friction_loss.map(|f| ("frictionloss", digits(f))));
    attributes
}

/// The same for a joint of a model, whose own limit of force would hold for the motor, too.
///
/// # Errors
/// In words, what is not known for it.
pub fn joint_attributes_in_model(e: &Exported, wishes: &Wishes) -> Result<Vec<(&'static str, String)>, String> {
    let mut attributes = joint_attributes(e);
    attributes.push(("actuatorfrclimited", "true".into()));
    attributes.push(("actuatorfrcrange", range(wishes.line(e, "dcmotor")?.effort)));
    Ok(attributes)
}

/// Attributes of a `dcmotor` that is there already: what it says otherwise would count, too.
///
/// # Errors
/// In words, what is not known for it.
pub fn all_motor_attributes(e: &Exported, wishes: &Wishes) -> Result<Vec<(&'static str, String)>, String> {
    let mut attributes = motor_attributes(e, wishes)?;
    let none = [
        ("nominal", "0 0 0"),
        ("inductance", "0 0"),
        ("cogging", "0 0 0"),
        ("thermal", "0 0 0 0 0 0"),
        ("lugre", "0 0 0 0 0"),
        ("ctrllimited", "false"),
    ];
    for (key, value) in none {
        if attributes.iter().all(|(k, _)| *k != key) {
            attributes.push((key, value.into()));
        }
    }
    Ok(attributes)
}

/// Attributes of the `dcmotor`.
///
/// # Errors
/// In words, what is not known for it.
pub fn motor_attributes(e: &Exported, wishes: &Wishes) -> Result<Vec<(&'static str, String)>, String> {
    let s = &e.simulated;
    let line = wishes.line(e, "dcmotor")?;
    // A module that says ratings alone has no ampere: then one is a newton metre.
    let constant = s.torque_constant.unwrap_or(1.0);
    let voltage = constant * s.ratio * line.no_load;
    let resistance = constant * voltage * s.ratio / line.stall;
    let mut attributes = vec![
        ("gear", digits(s.ratio)),
        ("motorconst", format!("{} 0", digits(constant))),
        ("resistance", digits(resistance)),
    ];
    attributes.extend(s.inertias.map(|(rotor, gear)| ("armature", digits(rotor + gear))));
    attributes.extend(s.damping.map(|damping| ("damping", digits(damping / (s.ratio * s.ratio)))));
    attributes.push(("saturation", format!("{} 0 0", digits(line.effort / s.ratio))));
    attributes.push(("controller", format!("0 0 0 0 0 {}", digits(voltage))));
    if let Some(cog) = s.cogging.first() {
        attributes.push(("cogging", format!("{} {} {}", digits(cog.amplitude), digits(cog.order), digits(cog.phase))));
    }
    let joint = e.joint;
    if wishes.electrical {
        let time = s.winding.and_then(|w| w.time_constant);
        let time = time
            .ok_or_else(|| format!("joint `{joint}`: `--electrical`: the inductance of {} is not known", e.motor.id))?;
        attributes.push(("inductance", format!("0 {}", digits(time))));
    }
    if wishes.thermal {
        let lacks = |what: &str| format!("joint `{joint}`: `--thermal`: {what} of {} is not known", e.motor.id);
        let (winding, heat) = s.winding.zip(s.heat).ok_or_else(|| lacks("the thermal resistance"))?;
        let time = heat.time_constant.ok_or_else(|| lacks("the thermal time constant of the housing"))?;
        // MuJoCo heats with R' i²; the winding, at its hottest, with R i². No temperature coefficient: MuJoCo's drive takes the
        // resistance at its reference for granted, so that with one the torque would not be the command, but R/R(T) of it.
        let hot = winding.resistance
            * gearwise_model::actuator::thermal::resistance_factor(winding.hottest, winding.reference);
        let celsius = |kelvin: f64| digits(kelvin - 273.15);
        attributes.push((
            "thermal",
            format!(
                "{} 0 {} 0 {} {}",
                digits(heat.resistance * hot / resistance),
                digits(time),
                celsius(winding.hottest),
                celsius(heat.ambient)
            ),
        ));
    }
    attributes.push(("input", "ff".into()));
    Ok(attributes)
}

fn remarks(e: &Exported, wishes: &Wishes) -> Vec<String> {
    let s = &e.simulated;
    let mut lines = vec!["MuJoCo 3.12 or later; `ctrl` is torque at the motor [N*m]".to_string()];
    lines.push(match s.torque_constant {
        Some(k) => format!(
            "motorconst is K_T = {} N*m/A (q axis); resistance and voltage are those of the line, not of the winding",
            number(k)
        ),
        None => "no torque constant is known: MuJoCo's ampere is a N*m here, and resistance and voltage are those of the line".into(),
    });
    if wishes.thermal {
        lines.push("the winding's temperature is the last state, above ambient; it heats as if it were at its hottest: right at its limit, too much below".into());
    }
    if wishes.electrical {
        lines.push("the current follows with L/R".into());
    }
    lines.push("armature and damping add to the joint's own, which are 0 here".into());
    lines.extend(line_remarks(e, wishes));
    let others: Vec<String> =
        s.cogging.iter().skip(1).map(|c| format!("{} N*m of order {}", number(c.amplitude), c.order)).collect();
    if !others.is_empty() {
        lines.push(format!("left out: cogging of other orders: {}: dcmotor has one", others.join(", ")));
    }
    lines
}

/// The comment with provenance and what is left out.
pub fn header(origin: &Origin, joints: &[Exported], wishes: &Wishes) -> String {
    comment(&comment_lines(origin, joints, (says, wishes), |e| remarks(e, wishes)))
}

fn text(origin: &Origin, joints: &[Exported], wishes: &Wishes) -> Result<String, String> {
    let mut out = header(origin, joints, wishes);
    out.push_str("\n<!-- include this file, and give each joint its class, as in <joint name=\"knee\" class=\"knee_actuator\"/> -->\n");
    out.push_str("<mujoco>\n  <default>\n");
    for e in joints {
        out.push_str(&format!("    <default class=\"{}\">\n", escape(&class(e.joint))));
        out.push_str(&format!("      {}\n", element("joint", &joint_attributes(e))));
        out.push_str(&format!("      {}\n", element("dcmotor", &motor_attributes(e, wishes)?)));
        out.push_str("    </default>\n");
    }
    out.push_str("  </default>\n  <actuator>\n");
    for e in joints {
        let attributes = [("name", e.joint.to_string()), ("class", class(e.joint)), ("joint", e.joint.to_string())];
        out.push_str(&format!("    {}\n", element("dcmotor", &attributes)));
    }
    out.push_str("  </actuator>\n</mujoco>\n");
    Ok(out)
}
