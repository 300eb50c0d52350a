//! A gearbox of the catalogue.

use super::convention::has_words;
use super::row::{Field, Side, States};
use super::sheet::{Printed, SourceKind};
use crate::input::Range;
use crate::units;

/// How a gear reduces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GearKind {
    /// Planetary.
    Planetary,
    /// Strain wave.
    StrainWave,
    /// Cycloidal.
    Cycloidal,
    /// Spur.
    Spur,
    /// Belt.
    Belt,
    /// No gear: the motor drives the output.
    Direct,
}

impl GearKind {
    /// Every kind with the word a catalogue uses for it.
    pub const NAMES: &[(&str, GearKind)] = &[
        ("planetary", GearKind::Planetary),
        ("strain_wave", GearKind::StrainWave),
        ("cycloidal", GearKind::Cycloidal),
        ("spur", GearKind::Spur),
        ("belt", GearKind::Belt),
        ("direct", GearKind::Direct),
    ];
}

has_words!(GearKind);

/// A gearbox: SI, torques at the output, inertia and speed at the input.
#[derive(Debug, Clone, PartialEq)]
pub struct Gear {
    /// Unique name.
    pub id: String,
    /// Who makes it.
    pub manufacturer: String,
    /// What its maker calls it.
    pub model: String,
    /// How it reduces.
    pub kind: GearKind,
    /// Reduction, N.
    pub ratio: f64,
    /// Number of stages.
    pub stages: Option<u32>,
    /// Efficiency when the motor drives, η.
    pub efficiency: Option<f64>,
    /// Efficiency when the load drives, η_b.
    pub backdrive_efficiency: Option<f64>,
    /// Mass \[kg\].
    pub mass: Option<f64>,
    /// Moment of inertia at the input \[kg·m²\], J_g.
    pub inertia: Option<f64>,
    /// Output torque that can be carried for ever \[N·m\].
    pub continuous_torque: Option<f64>,
    /// Largest output torque \[N·m\].
    pub peak_torque: Option<f64>,
    /// Largest speed at the input \[rad/s\].
    pub max_input_speed: Option<f64>,
    /// Backlash at the output \[rad\].
    pub backlash: Option<f64>,
    /// Torsional stiffness at the output \[N·m/rad\].
    pub stiffness: Option<f64>,
    /// Patterns of motor ids that it is made for; empty where nothing is said.
    pub fits: Vec<String>,
    /// Where the numbers come from.
    pub source: String,
    /// What kind of source that is.
    pub source_kind: SourceKind,
    /// What the reader of the row should know.
    pub note: String,
}

impl Gear {
    /// Whether the gear can be mounted on the motor: `None` where the catalogue does not say.
    pub fn fits(&self, motor_id: &str) -> Option<bool> {
        if self.fits.is_empty() { None } else { Some(self.fits.iter().any(|p| matches_pattern(p, motor_id))) }
    }
}

/// Whether `text` matches a pattern in which `*` stands for any run of characters.
///
/// ```
/// use gearwise::catalog::matches_pattern;
/// assert!(matches_pattern("maxon-*-574741", "maxon-ec-i-52-574741"));
/// assert!(!matches_pattern("maxon-*", "faulhaber-3274g024bp4"));
/// ```
pub fn matches_pattern(pattern: &str, text: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let mut last = None;
    for part in parts {
        if let Some(previous) = last.replace(part) {
            match rest.find(previous) {
                Some(at) => rest = &rest[at + previous.len()..],
                None => return false,
            }
        }
    }
    match last {
        None => rest.is_empty(),
        Some(last) => rest.ends_with(last),
    }
}

/// One numeric column of a gear catalogue; the number of stages, a whole one, stands beside them.
pub type GearField = Field<Gear>;

macro_rules! gear_fields {
    ($($name:ident, $about:literal, $kind:ident, $range:ident, $states:expr, $get:expr, $set:expr;)*) => {
        /// The numeric columns of a gear catalogue: what is read, written and kept by locks.
        pub const GEAR_FIELDS: &[GearField] = &[
            $(Field {
                name: stringify!($name),
                tolerance: None,
                about: $about,
                kind: &units::$kind,
                range: Range::$range,
                states: $states,
                get: |g| {
                    let get: fn(&Gear) -> Option<f64> = $get;
                    get(g).map(Printed::exact)
                },
                set: |g, printed| {
                    let set: fn(&mut Gear, f64) = $set;
                    set(g, printed.value);
                },
            },)*
        ];
    };
}

/// At the motor; at the output the same number times N to this power.
const fn at_motor(power: i32) -> States {
    States::Side { kept: Side::Motor, power: Some(power) }
}

/// At the output; at the motor the same number times N to this power.
const fn at_output(power: i32) -> States {
    States::Side { kept: Side::Output, power: Some(power) }
}

/// Of one side alone.
const fn only(kept: Side) -> States {
    States::Side { kept, power: None }
}

// `ratio` comes first: what is given at the other side is converted by it.
gear_fields! {
    ratio, "reduction, N", RATIO, Positive, States::Nothing, |g| Some(g.ratio), |g, v| g.ratio = v;
    efficiency, "when the motor drives, η", RATIO, Fraction, States::Nothing,
        |g| g.efficiency, |g, v| g.efficiency = Some(v);
    backdrive_efficiency, "when the load drives, η_b; 2 − 1/η by default; at most 1", RATIO, Any, States::Nothing,
        |g| g.backdrive_efficiency, |g, v| g.backdrive_efficiency = Some(v);
    mass, "of the gear", MASS, NonNegative, States::Nothing, |g| g.mass, |g, v| g.mass = Some(v);
    inertia, "at the input, J_g", INERTIA, NonNegative, at_motor(-2), |g| g.inertia, |g, v| g.inertia = Some(v);
    continuous_torque, "at the output, continuous", TORQUE, Positive, only(Side::Output),
        |g| g.continuous_torque, |g, v| g.continuous_torque = Some(v);
    peak_torque, "at the output, largest", TORQUE, Positive, only(Side::Output),
        |g| g.peak_torque, |g, v| g.peak_torque = Some(v);
    max_input_speed, "at the input", SPEED, Positive, only(Side::Motor),
        |g| g.max_input_speed, |g, v| g.max_input_speed = Some(v);
    backlash, "at the output", ANGLE, NonNegative, at_output(-1), |g| g.backlash, |g, v| g.backlash = Some(v);
    stiffness, "torsional, at the output", STIFFNESS, Positive, at_output(2),
        |g| g.stiffness, |g, v| g.stiffness = Some(v);
}
