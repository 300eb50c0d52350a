//! What a drive loses, and whether the motor's drag counts: keys of `[bus]`, `[joint.drive]` and `[[joint]]`.

use crate::input::{Range, Section, key};
use crate::units;

/// What a drive loses beside its efficiency.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveLosses {
    /// Resistance of switch and leads per phase \[Ω\].
    pub phase_resistance: Option<f64>,
    /// Power that it takes whatever the motor does \[W\].
    pub standby_power: Option<f64>,
}

impl DriveLosses {
    /// Whether it says nothing.
    pub fn says_nothing(&self) -> bool {
        *self == DriveLosses::default()
    }

    /// The same, and what another says where this does not.
    #[must_use]
    pub fn or(self, other: DriveLosses) -> DriveLosses {
        DriveLosses {
            phase_resistance: self.phase_resistance.or(other.phase_resistance),
            standby_power: self.standby_power.or(other.standby_power),
        }
    }
}

/// Reads the keys of a drive's losses; `before` stands before each name.
pub(super) fn read(section: &Section, names: [&'static str; 2]) -> DriveLosses {
    DriveLosses {
        phase_resistance: section.quantity(
            key(names[0], "of switch and leads per phase, in series with the winding; loses r i²"),
            &units::RESISTANCE,
            Range::NonNegative,
        ),
        standby_power: section.quantity(
            key(names[1], "that one drive takes whatever its motor does"),
            &units::POWER,
            Range::NonNegative,
        ),
    }
}

/// Whether a motor's drag counts that its row tells by a no-load current, or that is estimated. Friction that a row declares
/// always counts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MotorDrag {
    /// It counts in limits and losses.
    #[default]
    Counted,
    /// It is left out.
    Off,
}

impl MotorDrag {
    /// Both with the word a requirement uses for them.
    pub const NAMES: &[(&str, MotorDrag)] = &[("counted", MotorDrag::Counted), ("off", MotorDrag::Off)];
}
