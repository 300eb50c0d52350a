//! The electrical supply that all joints share: `[bus]`.

use super::drive::{self, Drive};
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
    /// Share of the power at a motor's terminals that is kept where it comes back; η_d unless given.
    pub regeneration_efficiency: Option<f64>,
    /// Power that a brake takes of one joint's where the supply does not take it \[W\].
    pub brake_power: Option<f64>,
    /// Whether what comes back beyond that is turned into heat of the winding by a current along d.
    pub flux_braking: bool,
    /// Resistance of the supply and its main leads; `voltage` is then that without current \[Ω\].
    pub internal_resistance: Option<f64>,
    /// Voltage that the bus may rise to where power comes back \[V\].
    pub max_voltage: Option<f64>,
    /// Efficiency of the drive, η_d.
    pub drive_efficiency: f64,
    /// What each drive loses beside.
    pub drive: Drive,
    /// Whether anything is said of what the drives lose.
    pub says_drive_loss: bool,
}

impl Bus {
    /// Whether a brake takes power that the supply does not.
    pub fn is_braked(&self) -> bool {
        self.brake_power.is_some() || self.regeneration == Regeneration::Dissipated
    }

    /// Most power that one joint may give back, with what a brake takes \[W\]; `None` where all of it is taken.
    pub fn takes_back(&self) -> Option<f64> {
        match self.regeneration {
            Regeneration::Allowed => None,
            Regeneration::Dissipated => self.brake_power,
            Regeneration::Limited(watts) => Some(watts + self.brake_power.unwrap_or(0.0)),
        }
    }

    /// Most power of one joint that goes back into the supply itself \[W\]; infinite where it takes all.
    pub fn goes_back(&self) -> f64 {
        match self.regeneration {
            Regeneration::Allowed => f64::INFINITY,
            Regeneration::Dissipated => 0.0,
            Regeneration::Limited(watts) => watts,
        }
    }
}

/// What the bus does with power that comes back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Regeneration {
    /// It takes all of it.
    Allowed,
    /// All of it goes into a brake: nothing is kept.
    Dissipated,
    /// It takes at most this much at any instant \[W\]; zero is "none".
    Limited(f64),
}

const REGENERATION: Key = key("regeneration", "what the bus takes back at any instant")
    .value("`allowed`, `none`, `dissipated`, or a power, as `\"200 W\"`")
    .default("all");

/// Reads `[bus]`.
pub(super) fn read(section: Section) -> Option<Bus> {
    let voltage = section.required_quantity(key("voltage", "of the bus"), &units::VOLTAGE, Range::Positive);
    // A bare number is a power, which in a file lacks its unit.
    let power = section
        .is_number("regeneration")
        .then(|| section.quantity(REGENERATION, &units::POWER, Range::NonNegative).map(Regeneration::Limited));
    let word = || {
        section.text(REGENERATION).map(|text| match text.get_ref().as_str() {
            "allowed" => Some(Regeneration::Allowed),
            "none" => Some(Regeneration::Limited(0.0)),
            "dissipated" => Some(Regeneration::Dissipated),
            other => match units::quantity(other, &units::POWER) {
                Ok(power) if power >= 0.0 => Some(Regeneration::Limited(power)),
                _ => {
                    section.note(
                        Problem::at(
                            text.span(),
                            format!("`regeneration` of [bus] cannot be `{other}`"),
                            "expected allowed, none, dissipated, or a power",
                        )
                        .help("for example regeneration = \"none\" or regeneration = \"200 W\""),
                    );
                    None
                }
            },
        })
    };
    let regeneration = power.or_else(word);
    let drive = drive::read(&section, ["drive_phase_resistance", "drive_standby_power", "drive_continuous_current"]);
    let drive_current = section.quantity(
        key("drive_current", "largest drive current, phase amplitude (DC ampere of a brushed motor)"),
        &units::CURRENT,
        Range::Positive,
    );
    drive.check(&section, ["drive_current", "drive_continuous_current"], drive_current);
    let regeneration = regeneration.flatten().unwrap_or(Regeneration::Allowed);
    let regeneration_efficiency = section.number(
        key("regeneration_efficiency", "share of what a motor gives back that is kept, drive and supply together")
            .default("`drive_efficiency`"),
        Range::Fraction,
    );
    let brake_power = section.quantity(
        key("brake_power", "that a braking resistor takes of one joint's where the supply does not take it"),
        &units::POWER,
        Range::Positive,
    );
    let internal_resistance = section.quantity(
        key("internal_resistance", "of the supply and its main leads; `voltage` is then that without current")
            .default("none"),
        &units::RESISTANCE,
        Range::NonNegative,
    );
    let max_voltage = section.quantity(
        key(
            "max_voltage",
            "that drives and capacitors bear: of the motor at its top speed when the drive lets go, and of a bus with a resistance where power comes back",
        ),
        &units::VOLTAGE,
        Range::Positive,
    );
    let contradicts = |key: &'static str, message: String, help: &str| {
        section.note(Problem::at(section.span_of(key), message, "nothing to act on").help(help));
    };
    let drive_efficiency =
        section.number(key("drive_efficiency", "efficiency of the drive, η_d").default("1"), Range::Fraction);
    let passed = drive_efficiency.unwrap_or(1.0);
    if let Some(kept) = regeneration_efficiency.filter(|kept| *kept > passed) {
        let message =
            format!("`regeneration_efficiency` of [bus] is {kept}, more than the `drive_efficiency` of {passed}");
        let problem = Problem::at(section.span_of("regeneration_efficiency"), message, "more than reaches the bus");
        section.note(problem.help("it is that of drive and supply together: at most the drive's own"));
    }
    let keeps_nothing = matches!(regeneration, Regeneration::Dissipated | Regeneration::Limited(0.0));
    if regeneration_efficiency.is_some() && keeps_nothing {
        let message = "`regeneration_efficiency` of [bus] has nothing to act on: no power that comes back is kept";
        contradicts(
            "regeneration_efficiency",
            message.into(),
            "remove it, or say regeneration = \"allowed\" or a power",
        );
    }
    if let (Some(most), Some(open)) = (max_voltage, voltage)
        && most <= open
    {
        // Nothing could ever come back.
        let message = format!("`max_voltage` of [bus] is {most} V, no more than its `voltage` of {open} V");
        contradicts(
            "max_voltage",
            message,
            "give the voltage that drives and capacitors bear, above that of a full supply",
        );
    }
    let flux_braking = section
        .boolean(
            key("flux_braking", "whether power that would come back beyond `regeneration` is turned into heat of the winding, by a current along d")
                .default("false"),
        )
        .unwrap_or(false);
    let takes_all =
        regeneration == Regeneration::Allowed || (regeneration == Regeneration::Dissipated && brake_power.is_none());
    if flux_braking && takes_all {
        let message = "`flux_braking` of [bus] has nothing to do: all power that comes back is taken";
        contradicts("flux_braking", message.into(), "say regeneration = \"none\" or a power, or give a `brake_power`");
    }
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
        drive_current,
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
        regeneration,
        regeneration_efficiency,
        brake_power,
        flux_braking,
        internal_resistance,
        max_voltage,
        drive_efficiency: passed,
        drive,
        says_drive_loss: section.has("drive_efficiency") || !drive.says_nothing(),
    };
    section.finish();
    voltage.map(|_| bus)
}
