//! Designs handed over to simulators: MuJoCo, Isaac Lab, mjlab, Unitree, Newton, PhysX, Drake, ROS 2, and JSON.
//!
//! The one idea: all say the same facts of [`SimulatedJoint`], and each says of every [`Fact`] what it makes of it: what it has
//! no place for is in its comments. A format is one file here and its line in [`FORMATS`]. XML, Python and USD are written as
//! text, because their comments are for people; a model that is there already is changed attribute by attribute ([`patch`]) and
//! stays otherwise as its author wrote it.

pub mod dcmotor;
pub mod facts;
pub mod isaaclab;
pub mod mjcf;
pub mod mjlab;
pub mod newton;
pub mod patch;
pub mod physx;
mod python;
pub mod ros2_control;
pub mod sdf;
pub mod unitree;
pub mod urdf;
mod usd;

pub use facts::Cell;

use crate::json;
use crate::unjudged::sentence;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::catalog::{Gear, Motor, alternative};
use gearwise_model::words::xml::{escape, is_xml};
use gearwise_select::simulated::spread::Spread;
use gearwise_select::simulated::{Fact, Line, SimulatedJoint};

/// A design of one joint, with where it comes from.
#[derive(Debug)]
pub struct Exported<'a> {
    /// The joint's name.
    pub joint: &'a str,
    /// The motor.
    pub motor: &'a Motor,
    /// The gear of the catalogue, where it is one.
    pub gear: Option<&'a Gear>,
    /// What a simulator is told.
    pub simulated: SimulatedJoint,
    /// How sure that is, where it was asked for and something is known of it.
    pub spread: Option<Spread>,
    /// Limits that the design breaks; empty where it keeps all that could be checked.
    pub broken: Vec<&'static str>,
    /// Limits that could not be checked.
    pub unchecked: Vec<&'static str>,
    /// Of those, what the requirement itself states, and why it cannot be judged.
    pub unjudged: Vec<Remark>,
}

/// Where an export comes from: the same for all its joints.
#[derive(Debug)]
pub struct Origin {
    /// Name of the robot.
    pub robot: String,
    /// What was put in the place of the requirement's own values: path, and value as TOML.
    pub set: Vec<(String, String)>,
    /// The requirement.
    pub requirement: NamedFile,
    /// The design file, where there is one.
    pub design: Option<NamedFile>,
}

/// A file that an export was made from.
#[derive(Debug)]
pub struct NamedFile {
    /// Its name, without its folder.
    pub name: String,
    /// SHA-256 of its text.
    pub sha256: String,
}

/// What was asked of an export.
#[derive(Debug, Clone, Default)]
pub struct Wishes {
    /// Which joints of a model a joint of the design is: name and pattern, several for one.
    pub names: Vec<(String, String)>,
    /// Torques behind the gear's loss, as a load sees them that the motor drives.
    pub with_efficiency: bool,
    /// The highest line of torque over speed that promises nothing too much.
    pub line_below: bool,
    /// The winding heats.
    pub thermal: bool,
    /// The current takes its time.
    pub electrical: bool,
    /// Drake's elements alone, without the reduction of older transmissions, of which Drake warns.
    pub for_drake: bool,
    /// Into MJCF: `dcmotor` in place of `motor`.
    pub as_dcmotor: bool,
    /// The gear's elasticity or play as a joint of its own.
    pub gear_joint: bool,
}

/// A wish that not every format can grant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// `--with-efficiency`.
    WithEfficiency,
    /// `--line below`.
    LineBelow,
    /// `--thermal`.
    Thermal,
    /// `--electrical`.
    Electrical,
    /// `--drake`.
    Drake,
    /// `--draws`.
    Draws,
    /// `--map`.
    Map,
}

impl Wish {
    /// What it is called on the command line.
    pub fn option(self) -> &'static str {
        match self {
            Wish::WithEfficiency => "--with-efficiency",
            Wish::LineBelow => "--line below",
            Wish::Thermal => "--thermal",
            Wish::Electrical => "--electrical",
            Wish::Drake => "--drake",
            Wish::Draws => "--draws",
            Wish::Map => "--map",
        }
    }
}

impl Wishes {
    /// Patterns of a joint; its own name where none are given.
    pub fn patterns<'w>(&'w self, joint: &'w str) -> Vec<&'w str> {
        let own: Vec<&str> = self.names.iter().filter(|(j, _)| j == joint).map(|(_, p)| p.as_str()).collect();
        if own.is_empty() { vec![joint] } else { own }
    }

    /// The line of torque over speed of a joint, as it was asked for.
    ///
    /// # Errors
    /// In words, what is not known for it.
    pub fn line(&self, e: &Exported, key: &str) -> Result<Line, String> {
        let s = &e.simulated;
        let line = if self.line_below { s.line_below } else { s.line };
        let lacks = || {
            let why = match s.motor_torque {
                None => {
                    "neither motor nor drive nor gear says a largest torque: give the bus a `drive_current`, or the row a `peak_current` or `peak_torque`"
                }
                Some(_) if s.line_below.is_some() => {
                    "up to which speed it has its largest torque is not known: give the row a voltage or a driving curve, or take the option `line below`, which falls from standstill on"
                }
                Some(_) => {
                    "up to which speed it has its largest torque is not known: give the row a voltage, a speed without load or a driving curve"
                }
            };
            format!("joint `{}`: `{key}` is needed there, and cannot be written for {}: {why}", e.joint, e.motor.id)
        };
        let line = line.ok_or_else(lacks)?;
        let factor = self.efficiency(e)?;
        Ok(Line { effort: line.effort * factor, stall: line.stall * factor, ..line })
    }

    /// Whether a range of a number of a joint is known and wished.
    pub fn has_range_of(&self, e: &Exported, name: &str) -> bool {
        e.spread.as_ref().is_some_and(|spread| spread.range(name).is_some())
    }

    /// What torques are multiplied with.
    ///
    /// # Errors
    /// In words, that it is not known.
    pub fn efficiency(&self, e: &Exported) -> Result<f64, String> {
        match (self.with_efficiency, e.simulated.load_factors()) {
            (false, _) => Ok(1.0),
            (true, Some((driving, _))) => Ok(driving),
            (true, None) => Err(format!(
                "joint `{}`: `--with-efficiency`: the row of {} does not say what its gear loses",
                e.joint, e.motor.id
            )),
        }
    }

    /// On which side of the losses torques are written, in words.
    pub fn side(&self, e: &Exported) -> &'static str {
        let s = &e.simulated;
        match (self.with_efficiency, s.is_behind_loss) {
            (true, _) => "behind the loss of gear and transmission",
            (false, true) => "a module's rating: its gear's loss is in it",
            (false, false) => "before the gear's loss",
        }
    }

    /// Facts that are said because it was wished, with remarks of their own.
    fn granted(&self, fact: Fact) -> bool {
        match fact {
            Fact::GearLoss => self.with_efficiency,
            Fact::ElectricalTime => self.electrical,
            Fact::Heating | Fact::ContinuousTorque => self.thermal,
            _ => false,
        }
    }
}

/// A format of an export.
pub struct Format {
    /// The word of `--to`.
    pub name: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Its text.
    pub text: fn(&Origin, &[Exported], &Wishes) -> Result<String, String>,
    /// What it makes of a fact.
    pub says: fn(Fact) -> Cell,
    /// Which wishes it can grant.
    pub takes: &'static [Wish],
    /// Against what it is checked.
    pub checked: &'static str,
    /// Where its names and units are documented.
    pub source: &'static str,
}

/// Every format.
pub const FORMATS: &[Format] = &[
    mjcf::FORMAT,
    dcmotor::FORMAT,
    isaaclab::LAB2,
    isaaclab::LAB3,
    mjlab::FORMAT,
    unitree::FORMAT,
    newton::FORMAT,
    physx::FORMAT,
    urdf::FORMAT,
    sdf::FORMAT,
    ros2_control::FORMAT,
    Format {
        name: "json",
        about: "All facts in SI, the unit in the key",
        text: |origin, joints, _| Ok(super::json_text(&json::export::json(origin, joints))),
        says: json_says,
        takes: &[Wish::Draws],
        checked: "its schema",
        source: "docs/schema.json",
    },
];

fn json_says(fact: Fact) -> Cell {
    match fact {
        Fact::Armature => Cell::Said("armature_kgm2"),
        Fact::Damping => Cell::Said("damping_nms_per_rad"),
        Fact::Friction => Cell::Said("friction_loss_nm"),
        Fact::FrictionAtRest => Cell::Said("friction_at_rest_nm"),
        Fact::PeakTorque => Cell::Said("effort_nm"),
        Fact::TorqueSpeed => Cell::Said("line"),
        Fact::Braking => Cell::Said("braking_effort_nm"),
        Fact::ContinuousTorque => Cell::Said("continuous_effort_nm"),
        Fact::MechanicalSpeed => Cell::Said("mechanical_velocity_rad_per_s"),
        Fact::GearLoss => Cell::Said("gear_efficiency, gear_backdrive_efficiency"),
        Fact::Compliance => Cell::Said("gear_stiffness_nm_per_rad"),
        Fact::Backlash => Cell::Said("backlash_rad"),
        Fact::Cogging => Cell::Said("cogging"),
        Fact::Transmission => Cell::Approximately("over_angle_rad_ratio_nm; of two joints in words, in left_out"),
        Fact::OtherEffects | Fact::Spring => Cell::Approximately("in words, in left_out"),
        Fact::ElectricalTime => Cell::Said("electrical_time_constant_s"),
        Fact::Heating => Cell::Said("heat"),
        Fact::Ranges => Cell::Said("ranges, draws"),
    }
}

/// First words of a comment that the program wrote: a patch replaces it.
pub const MARK: &str = " gearwise export";

/// The provenance and what is left out, as lines of a comment.
fn comment_lines(
    origin: &Origin,
    joints: &[Exported],
    (says, wishes): (fn(Fact) -> Cell, &Wishes),
    not_here: impl Fn(&Exported) -> Vec<String>,
) -> Vec<String> {
    let mut lines = vec![
        format!("{MARK}, gearwise {}", env!("CARGO_PKG_VERSION")),
        format!(
            "requirement {} (robot {}), SHA-256 {}",
            origin.requirement.name, origin.robot, origin.requirement.sha256
        ),
    ];
    if !origin.set.is_empty() {
        let set: Vec<String> = origin.set.iter().map(|(key, value)| format!("{key} = {value}")).collect();
        lines.push(format!("with {}", set.join(", ")));
    }
    lines.extend(origin.design.iter().map(|d| format!("design {}, SHA-256 {}", d.name, d.sha256)));
    for e in joints {
        let s = &e.simulated;
        let through = e.gear.map_or_else(String::new, |g| format!(" with {}", g.id));
        lines.push(format!("joint {}: {}{through} at N = {}", e.joint, e.motor.id, super::number(s.ratio)));
        lines.push(format!("  motor's numbers: {}", e.motor.source));
        for log in e.motor.fit.iter().flat_map(|fit| &fit.provenance) {
            let hash = log.sha256.as_deref().map_or_else(String::new, |h| format!(", SHA-256 {h}"));
            lines.push(format!("  fitted from {}{hash}", log.log));
        }
        let elsewhere =
            e.motor.inside.as_deref().map_or_else(Vec::new, |inside| alternative::lines(&inside.alternatives));
        lines.extend(elsewhere.into_iter().map(|line| format!("  other sources say of {line}")));
        if !e.broken.is_empty() {
            lines.push(format!("  NOT FEASIBLE: breaks {}", e.broken.join(", ")));
        }
        if !e.unjudged.is_empty() {
            lines.push(format!("  NO CHOICE: {}", sentence(&e.unjudged)));
        }
        if !e.unchecked.is_empty() {
            lines.push(format!("  not checked: {}", e.unchecked.join(", ")));
        }
        lines.extend(not_here(e).into_iter().map(|line| format!("  {line}")));
        lines.extend(range_lines(e).into_iter().map(|line| format!("  {line}")));
        lines.extend(facts::lines(e, says, |fact| wishes.granted(fact)).into_iter().map(|line| format!("  {line}")));
    }
    lines
}

/// Ranges in words, with what they come from.
fn range_lines(e: &Exported) -> Vec<String> {
    let Some(spread) = &e.spread else { return Vec::new() };
    let number = super::number;
    let one = |r: &gearwise_select::simulated::spread::Ranged| {
        format!("95 %: {} {} to {}, by the ± of {}", r.name, number(r.low), number(r.high), r.from.join(", "))
    };
    spread.ranges.iter().map(one).collect()
}

/// What is said of a line of torque over speed.
fn line_remarks(e: &Exported, wishes: &Wishes) -> Vec<String> {
    let s = &e.simulated;
    let number = super::number;
    let Some(line) = (if wishes.line_below { s.line_below } else { s.line }) else { return Vec::new() };
    let hot = s.winding.map_or_else(String::new, |w| format!(", winding at {} °C", number(w.hottest - 273.15)));
    let owner = s.motor_torque.map_or("", |b| b.owner);
    let mut lines = vec![format!(
        "torque over speed: {} N*m (by the {owner}) up to {} rad/s, none at {} rad/s{hot}; {}",
        number(line.effort),
        number(line.corner),
        number(line.no_load),
        if s.is_behind_loss { "a module's rating: its gear's loss is in it" } else { "before the gear's loss" }
    )];
    if line.is_assumed {
        lines.push(
            "ASSUMED: up to which speed it has its largest torque is not known; the line falls from standstill on; a motor without inductance whose current is limited has no less".into(),
        );
    }
    for ((speed, torque), than) in [(line.excess, "more"), (line.shortfall, "less")] {
        // Less than a thousandth is not worth a line.
        if torque > 1e-3 * line.effort {
            let (speed, torque) = (number(speed), number(torque));
            lines.push(format!("the line is straight: at {speed} rad/s it has {torque} N*m {than} than the motor"));
        }
    }
    if line.stall < 0.9 * s.effort().map_or(0.0, |b| b.value) {
        let (stall, effort) = (number(line.stall), number(s.effort().map_or(0.0, |b| b.value)));
        lines.push(format!("the line has {stall} N*m at standstill, less than the {effort} N*m of the motor"));
    }
    if let Some((driving, _)) = s.load_factors().filter(|factors| factors.0 != 1.0) {
        let behind = number(line.effort * driving);
        lines.push(match wishes.with_efficiency {
            true => format!("torques are written behind the losses, {behind} N*m: right while the motor drives, too little while the load drives"),
            false => format!("of these at most {behind} N*m reach a load that the motor drives"),
        });
    } else if wishes.with_efficiency {
        lines.push("torques are behind the losses as they are: the option `with-efficiency` changes nothing".into());
    }
    lines
}

/// What is said of a table over the angle.
fn table_remarks(e: &Exported) -> Vec<String> {
    let angles: Vec<f64> = e.simulated.over_angle.iter().map(|row| row[0]).collect();
    let (Some(first), Some(last)) = (angles.first(), angles.last()) else { return Vec::new() };
    let number = super::number;
    vec![
        format!(
            "the table is torque at the joint over the angles of the motion, {} to {} rad; beyond them a reader may hold its ends",
            number(*first),
            number(*last)
        ),
        "left out: torque over speed, armature and friction: they go with the angle, and the numbers below are those before the transmission".into(),
    ]
}

/// A comment of lines. Two hyphens end a comment, so they are set apart, and a control character is a blank.
fn comment(lines: &[String]) -> String {
    let body = lines.iter().map(|line| tame(line)).collect::<Vec<_>>().join("\n    ");
    format!("<!--{body}\n-->")
}

/// A comment of lines in Python or USD: what would end a line is a blank.
fn hashes(lines: &[String]) -> String {
    let blank = |c: char| if c.is_control() || matches!(c, '\u{2028}' | '\u{2029}') { ' ' } else { c };
    let tamed = lines.iter().map(|line| line.chars().map(blank).collect::<String>());
    tamed.map(|line| format!("#{}{line}\n", if line.starts_with(' ') { "" } else { " " })).collect()
}

fn tame(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    for c in line.chars().map(|c| if is_xml(c) && !c.is_control() { c } else { ' ' }) {
        if c == '-' && out.ends_with('-') {
            out.push(' ');
        }
        out.push(c);
    }
    if out.ends_with('-') {
        out.push(' ');
    }
    out
}

/// Twelve digits: what rounding leaves of a product is not shown.
fn digits(value: f64) -> String {
    format!("{value:.11e}").parse::<f64>().unwrap_or(value).to_string()
}

/// `−x x` of a bound.
fn range(bound: f64) -> String {
    format!("-{0} {0}", digits(bound))
}
