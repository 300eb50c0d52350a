use std::path::PathBuf;

use clap::Args;
use nalgebra::Vector3;

use super::{Done, Failure, Output};
use crate::input::Source;
use crate::mechanism::torques::{actuator_places, notes, torques, torques_per_mass};
use crate::mechanism::{Mechanism, Payload, trajectory};
use crate::output::{make_folder, write_whole};
use crate::report::torques::{self as report, Answer};
use crate::units::{self, Kind};

/// Arguments of the command.
#[derive(Debug, Args)]
#[command(
    before_help = "Examples:\n  gearwise torques requirements/robots/ur5e.urdf requirements/robots/ur5e_pick.csv\n  gearwise torques leg.xml trot.csv --out motions\n  gearwise torques arm.urdf pick.csv --payload \"tool0=2 kg\" --joint elbow --csv"
)]
pub struct Arguments {
    /// Description of the robot: URDF or MJCF
    model: PathBuf,
    /// Positions of all joints over time (CSV: `time [s]`, `<joint> [rad]`, …)
    trajectory: PathBuf,
    /// A point mass on a link, at its origin or at a point of its frame: "LINK=2 kg" or "LINK=2 kg@0,0,50 mm"
    #[arg(long, value_name = "LINK=MASS[@X,Y,Z UNIT]")]
    payload: Vec<String>,
    /// Only these joints
    #[arg(long, value_name = "JOINT")]
    joint: Vec<String>,
    /// Gravity along x, y, z in world axes, in place of the model's, e.g. "0,0,-1.62 m/s^2"
    #[arg(long, value_name = "X,Y,Z UNIT", allow_hyphen_values = true)]
    gravity: Option<String>,
    /// The trajectory happens once; otherwise its last row repeats the first
    #[arg(long)]
    once: bool,
    /// Period where the last row does not repeat the first, e.g. "1.2 s"
    #[arg(long, value_name = "TIME", conflicts_with = "once")]
    period: Option<String>,
    /// Leave out the friction that the description gives its joints
    #[arg(long)]
    without_joint_friction: bool,
    /// Write motion files for requirements, one per joint, and torque_per_mass.csv into this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    output: Output,
}

pub fn run(arguments: &Arguments) -> Result<Done, Failure> {
    let period = match &arguments.period {
        None => None,
        Some(text) => match units::quantity(text, &units::TIME) {
            Ok(value) if value > 0.0 => Some(value),
            _ => return Err(Failure::Argument(format!("`--period {text}` is not a time; write it like \"1.2 s\""))),
        },
    };
    let mut mechanism = Mechanism::read(&arguments.model).map_err(|e| vec![e])?;
    if let Some(text) = &arguments.gravity {
        mechanism.gravity = Vector3::from(vector(text, &units::LINEAR_ACCELERATION, "--gravity", "0,0,-9.81 m/s^2")?);
    }
    for text in &arguments.payload {
        let payload = payload(text)?;
        if !mechanism.carry(&payload) {
            return Err(unknown("--payload", "link", &payload.link, mechanism.frames()));
        }
    }
    let mut shown = Vec::new();
    for name in &arguments.joint {
        let names: Vec<&str> = mechanism.joints().map(|j| j.name.as_str()).collect();
        shown.push(mechanism.joint(name).ok_or_else(|| unknown("--joint", "joint", name, names.into_iter()))?);
    }
    if shown.is_empty() {
        shown = (0..mechanism.moving().len()).collect();
    }
    let source = Source::read(&arguments.trajectory).map_err(|e| vec![e])?;
    let trajectory = trajectory::read(&source, &mechanism, !arguments.once, period).map_err(|e| vec![e])?;
    let torques = torques(&mechanism, &trajectory, !arguments.without_joint_friction);
    let carried = torques_per_mass(&mechanism, &trajectory, &actuator_places(&mechanism));
    let notes = notes(&mechanism, &trajectory, &torques);
    let answer = Answer { mechanism: &mechanism, trajectory: &trajectory, torques: &torques, carried, notes, shown };
    let mut written = Vec::new();
    if let Some(folder) = &arguments.out {
        make_folder(folder).map_err(Failure::Argument)?;
        for (name, text) in report::files(&answer) {
            write_whole(&folder.join(&name), text.as_bytes()).map_err(Failure::Argument)?;
            written.push(folder.join(name).display().to_string());
        }
        tell!("written: {}", written.join(", "));
    }
    let text = arguments.output.choose(
        || report::text(&answer),
        || crate::report::json::torques::json(&answer),
        || report::csv(&answer),
    );
    Ok(Done { text, satisfied: true })
}

fn unknown<'a>(flag: &str, what: &str, name: &str, names: impl Iterator<Item = &'a str> + Clone) -> Failure {
    let help = match crate::words::nearest(name, names.clone()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("there are: {}", names.take(40).collect::<Vec<_>>().join(", ")),
    };
    Failure::Argument(format!("`{flag}`: the model has no {what} `{name}`; {help}"))
}

fn payload(text: &str) -> Result<Payload, Failure> {
    const EXAMPLE: &str = "\"tool0=2 kg\" or \"tool0=2 kg@0,0,50 mm\"";
    let wrong = || Failure::Argument(format!("`--payload {text}` is not a payload; write it like {EXAMPLE}"));
    let (link, rest) = text.split_once('=').ok_or_else(wrong)?;
    let (mass, at) = rest.split_once('@').map_or((rest, None), |(mass, at)| (mass, Some(at)));
    let mass = units::quantity(mass.trim(), &units::MASS).ok().filter(|m| *m > 0.0).ok_or_else(wrong)?;
    let at = at.map_or(Ok([0.0; 3]), |at| vector(at, &units::LENGTH, "--payload", EXAMPLE))?;
    Ok(Payload { link: link.trim().to_string(), mass, at })
}

/// `X,Y,Z UNIT`.
fn vector(text: &str, kind: &'static Kind, flag: &str, example: &str) -> Result<[f64; 3], Failure> {
    let wrong =
        || Failure::Argument(format!("`{flag}`: `{text}` is not a vector with its unit; write it like {example}"));
    let parts: Vec<&str> = text.split(',').collect();
    // The unit stands behind the last number, with a blank or without.
    let Some((last, before)) = parts.split_last() else { return Err(wrong()) };
    let (last, unit) = units::apart(last);
    let numbers = before.iter().copied().chain([last]);
    let parts: Vec<f64> = numbers
        .map(|n| units::quantity(&format!("{} {unit}", n.trim()), kind).map_err(|_| wrong()))
        .collect::<Result<_, _>>()?;
    <[f64; 3]>::try_from(parts).map_err(|_| wrong())
}
