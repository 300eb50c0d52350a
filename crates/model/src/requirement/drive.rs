//! What a drive loses, and whether the motor's drag counts: keys of `[bus]`, `[joint.drive]` and `[[joint]]`.

use crate::input::{Problem, Range, Section, key};
use crate::units;

/// What is said of a drive beside its largest current and its efficiency.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Drive {
    /// Resistance of switch and leads per phase \[Ω\].
    pub phase_resistance: Option<f64>,
    /// Power that it takes whatever the motor does \[W\].
    pub standby_power: Option<f64>,
    /// Resistance of the leads between the supply and it \[Ω\].
    pub supply_lead_resistance: Option<f64>,
    /// Current that it gives for ever: amplitude of a phase (DC ampere of a brushed motor), rms over the motion \[A\].
    pub continuous_current: Option<f64>,
    /// Largest current against the magnets, amplitude of a phase \[A\]: the field is not weakened without it.
    pub field_weakening_current: Option<f64>,
}

impl Drive {
    /// Whether it says nothing of what the drive loses.
    pub fn says_nothing(&self) -> bool {
        self.phase_resistance.is_none() && self.standby_power.is_none()
    }

    /// The same, and what another says where this does not.
    #[must_use]
    pub fn or(self, other: Drive) -> Drive {
        Drive {
            phase_resistance: self.phase_resistance.or(other.phase_resistance),
            standby_power: self.standby_power.or(other.standby_power),
            supply_lead_resistance: self.supply_lead_resistance.or(other.supply_lead_resistance),
            continuous_current: self.continuous_current.or(other.continuous_current),
            field_weakening_current: self.field_weakening_current.or(other.field_weakening_current),
        }
    }

    /// Notes a continuous current that is more than the largest; `names` are those of the largest and of the continuous one.
    pub(super) fn check(&self, section: &Section, names: [&'static str; 2], largest: Option<f64>) {
        let (Some(most), Some(held)) = (largest, self.continuous_current) else { return };
        if held > most {
            let [of_most, of_held] = names;
            let message = format!("`{of_held}` is {held} A, more than the `{of_most}` of {most} A");
            let problem = Problem::at(section.span_of(of_held), message, "more than the drive gives at all");
            section.note(problem.help("both are amplitudes: a continuous current is at most the largest"));
        }
    }
}

/// Reads what bus and joint may say of a drive; `names` are those of its resistance, its standby power and its continuous
/// current there.
pub(super) fn read(section: &Section, names: [&'static str; 3]) -> Drive {
    Drive {
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
        continuous_current: section.quantity(
            key(
                names[2],
                "continuous, of a drive: amplitude of a phase at constant speed, root mean square over the motion",
            ),
            &units::CURRENT,
            Range::Positive,
        ),
        field_weakening_current: section.quantity(
            key(
                "field_weakening_current",
                "largest current against the magnets, amplitude of a phase: where voltage ends, this much of it is used",
            )
            .default("none: i_d = 0"),
            &units::CURRENT,
            Range::Positive,
        ),
        supply_lead_resistance: None,
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
