//! A gearbox of the catalogue.

use super::sheet::SourceKind;
use crate::input::Range;
use crate::units::{self, Kind};

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

/// A gearbox: SI, torques at the output, inertia and speed at the input.
#[derive(Debug, Clone)]
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
#[derive(Debug)]
pub struct GearField {
    /// Column name.
    pub name: &'static str,
    /// What it measures.
    pub kind: &'static Kind,
    /// What values it may have.
    pub range: Range,
    /// Reads it from a gear, SI.
    pub get: fn(&Gear) -> Option<f64>,
    /// Writes it to a gear, SI.
    pub set: fn(&mut Gear, f64),
}

/// The numeric columns of a gear catalogue: what is read, written by importers and kept by locks.
pub const GEAR_FIELDS: &[GearField] = &[
    GearField {
        name: "ratio",
        kind: &units::RATIO,
        range: Range::Positive,
        get: |g| Some(g.ratio),
        set: |g, v| g.ratio = v,
    },
    GearField {
        name: "efficiency",
        kind: &units::RATIO,
        range: Range::Fraction,
        get: |g| g.efficiency,
        set: |g, v| g.efficiency = Some(v),
    },
    GearField {
        name: "backdrive_efficiency",
        kind: &units::RATIO,
        range: Range::Any,
        get: |g| g.backdrive_efficiency,
        set: |g, v| g.backdrive_efficiency = Some(v),
    },
    GearField {
        name: "mass",
        kind: &units::MASS,
        range: Range::NonNegative,
        get: |g| g.mass,
        set: |g, v| g.mass = Some(v),
    },
    GearField {
        name: "inertia",
        kind: &units::INERTIA,
        range: Range::NonNegative,
        get: |g| g.inertia,
        set: |g, v| g.inertia = Some(v),
    },
    GearField {
        name: "continuous_torque",
        kind: &units::TORQUE,
        range: Range::Positive,
        get: |g| g.continuous_torque,
        set: |g, v| g.continuous_torque = Some(v),
    },
    GearField {
        name: "peak_torque",
        kind: &units::TORQUE,
        range: Range::Positive,
        get: |g| g.peak_torque,
        set: |g, v| g.peak_torque = Some(v),
    },
    GearField {
        name: "max_input_speed",
        kind: &units::SPEED,
        range: Range::Positive,
        get: |g| g.max_input_speed,
        set: |g, v| g.max_input_speed = Some(v),
    },
    GearField {
        name: "backlash",
        kind: &units::ANGLE,
        range: Range::NonNegative,
        get: |g| g.backlash,
        set: |g, v| g.backlash = Some(v),
    },
    GearField {
        name: "stiffness",
        kind: &units::STIFFNESS,
        range: Range::Positive,
        get: |g| g.stiffness,
        set: |g, v| g.stiffness = Some(v),
    },
];
