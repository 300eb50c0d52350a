//! The electrical supply that all joints share: `[bus]`.

use super::drive::{self, DriveLosses};
use crate::catalog::convention::Modulation;
use crate::input::{Key, Problem, Range, Section, key};
use crate::units;

/// The electrical supply that all joints share.
#[derive(Debug, Clone, Copy)]
pub struct Bus {
    /// Bus voltage \[V\].
    pub voltage: f64,
    /// How the drives make phase voltages of it.
    pub modulation: Modulation,
    /// Share of the ideal voltage that the drive can use.
    pub modulation_limit: f64,
    /// Largest current of the drive, phase amplitude (DC ampere for a brushed motor) \[A\].
    pub drive_current: Option<f64>,
    /// Largest power that the bus delivers to one joint; `power` of the budget is that of all together \[W\].
    pub power: Option<f64>,
    /// Largest current that the bus delivers to one joint \[A\].
    pub current: Option<f64>,
    /// What the bus takes back.
    pub regeneration: Regeneration,
    /// Efficiency of the drive, η_d.
    pub drive_efficiency: f64,
    /// What each drive loses beside.
    pub drive: DriveLosses,
    /// Whether anything is said of what the drives lose.
    pub says_drive_loss: bool,
}

/// What the bus does with power that comes back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Regeneration {
    /// It takes all of it.
    Allowed,
    /// It takes at most this much at any instant \[W\]; zero is "none".
    Limited(f64),
}

const REGENERATION: Key = key("regeneration", "what the bus takes back at any instant")
    .value("`allowed`, `none`, or a power, as `\"200 W\"`")
    .default("all");

/// Reads `[bus]`.
pub(super) fn read(section: Section) -> Option<Bus> {
    let voltage = section.required_quantity(key("voltage", "of the bus"), &units::VOLTAGE, Range::Positive);
    let regeneration = section.text(REGENERATION).map(|text| match text.get_ref().as_str() {
        "allowed" => Some(Regeneration::Allowed),
        "none" => Some(Regeneration::Limited(0.0)),
        other => match units::quantity(other, &units::POWER) {
            Ok(power) if power >= 0.0 => Some(Regeneration::Limited(power)),
            _ => {
                section.note(
                    Problem::at(
                        text.span(),
                        format!("`regeneration` of [bus] cannot be `{other}`"),
                        "expected allowed, none, or a power",
                    )
                    .help("for example regeneration = \"none\" or regeneration = \"200 W\""),
                );
                None
            }
        },
    });
    let drive = drive::read(&section, ["drive_phase_resistance", "drive_standby_power"]);
    let bus = Bus {
        voltage: voltage.unwrap_or(f64::NAN),
        modulation: section
            .choice(
                key("modulation", "how the drive makes phase voltages").default("`space_vector`"),
                Modulation::NAMES,
            )
            .unwrap_or(Modulation::SpaceVector),
        modulation_limit: section
            .number(
                key("modulation_limit", "share of the ideal voltage that may be used; a reserve goes here")
                    .default("1"),
                Range::Fraction,
            )
            .unwrap_or(1.0),
        drive_current: section.quantity(
            key("drive_current", "largest drive current, phase amplitude (DC ampere of a brushed motor)"),
            &units::CURRENT,
            Range::Positive,
        ),
        power: section.quantity(
            key("power", "largest power that the bus gives one joint"),
            &units::POWER,
            Range::Positive,
        ),
        current: section.quantity(
            key("current", "largest current that the bus gives one joint"),
            &units::CURRENT,
            Range::Positive,
        ),
        regeneration: regeneration.flatten().unwrap_or(Regeneration::Allowed),
        drive_efficiency: section
            .number(key("drive_efficiency", "efficiency of the drive, η_d").default("1"), Range::Fraction)
            .unwrap_or(1.0),
        drive,
        says_drive_loss: section.has("drive_efficiency") || !drive.says_nothing(),
    };
    section.finish();
    voltage.map(|_| bus)
}
