//! The row of a module.

use super::{Column, Field, Holds, Need, Row, find, identity, listed};
use crate::catalog::convention::{
    BackEmfConvention, CurrentConvention, SpeedConstantConvention, Terminals, Winding, word,
};
use crate::catalog::gear::GearKind;
use crate::catalog::module::{Drive, MODULE_FIELDS, Module, ModuleSheet, NoLoadCurrent, RatedPower, TorqueLoss};
use crate::catalog::offer::Sold;
use crate::catalog::row::Side;
use crate::catalog::sheet::{Printed, SourceKind};
use crate::input::{Range, Stated};
use crate::units;

/// A column of text.
macro_rules! text {
    ($name:ident, $about:literal) => {
        Column {
            name: stringify!($name),
            about: $about,
            need: Need::May,
            holds: Holds::Text(|r: &Module| r.$name.clone(), |r, text| r.$name = text),
        }
    };
}

/// A column that says what others refer to.
macro_rules! refers {
    ($name:ident, $of:ident, $about:literal) => {
        Column {
            name: stringify!($name),
            about: $about,
            need: Need::May,
            holds: Holds::Choice(
                $of::WORDS,
                |r: &Module| r.refers.$name.map(|is| word($of::NAMES, &is)),
                |r, text| r.refers.$name = find($of::NAMES, text),
            ),
        }
    };
}

/// A column of pairs.
macro_rules! points {
    ($name:ident, [$first:ident, $second:ident, $range:ident], $about:literal) => {
        Column {
            name: stringify!($name),
            about: $about,
            need: Need::May,
            holds: Holds::Pairs(
                [(&units::$first, Range::NonNegative), (&units::$second, Range::$range)],
                |r: &Module| r.$name.clone(),
                |r, points| r.$name = points,
            ),
        }
    };
}

/// A column of a whole number.
macro_rules! count {
    ($name:ident, $about:literal) => {
        Column {
            name: stringify!($name),
            about: $about,
            need: Need::May,
            holds: Holds::Count(|r: &Module| r.$name, |r, count| r.$name = Some(count)),
        }
    };
}

impl Row for Module {
    type Numbers = ModuleSheet;

    const REQUIRED: &'static [&'static str] = &["ratio"];

    const BEFORE: &'static [Column<Module>] = &[
        identity!(id),
        identity!(manufacturer),
        identity!(model),
        text!(family, "name that rows of one maker share whose motor or gear is the same"),
        text!(version, "of the hardware or of the sheet"),
        Column {
            name: "kind",
            about: "how its gear reduces; blank where it is not said",
            need: Need::May,
            holds: Holds::Choice(
                GearKind::WORDS,
                |r| r.kind.map(|kind| word(GearKind::NAMES, &kind)),
                |r, text| r.kind = find(GearKind::NAMES, text),
            ),
        },
        Column {
            name: "drive",
            about: "where the drive is: its mass is the module's where it is built in",
            need: Need::Must("\"built_in\""),
            holds: Holds::Choice(
                Drive::WORDS,
                |r| Some(word(Drive::NAMES, &r.drive)),
                |r, text| r.drive = find(Drive::NAMES, text).unwrap_or(r.drive),
            ),
        },
        text!(motor, "id of the motor row inside: the numbers of this row are audited against it"),
        text!(gear, "id of the gear row inside"),
        refers!(rated_power_is, RatedPower, "what `rated_power` is; needed with it"),
        refers!(armature_side, Side, "at which side `armature` is: N² lies between; needed with it"),
        refers!(friction_side, Side, "at which side the friction columns are; needed with them"),
        refers!(torque_constant_current, CurrentConvention, "what ampere means in `torque_constant`; needed with it"),
        refers!(torque_constant_side, Side, "at which side `torque_constant` is; needed with it"),
        refers!(
            torque_constant_loss,
            TorqueLoss,
            "whether the gear's loss is in `torque_constant`; needed with one of the output"
        ),
        refers!(back_emf_convention, BackEmfConvention, "what `back_emf_constant` is measured between; needed with it"),
        refers!(back_emf_side, Side, "at which side `back_emf_constant` is; needed with it"),
        refers!(
            speed_constant_convention,
            SpeedConstantConvention,
            "what voltage `speed_constant` refers to; needed with it"
        ),
        refers!(speed_constant_side, Side, "at which side `speed_constant` is; needed with it"),
        refers!(terminals, Terminals, "between what resistance and inductance are; needed with them"),
        refers!(winding, Winding, "how its windings are connected; needed where `terminals` is `winding`"),
        refers!(
            current,
            CurrentConvention,
            "what ampere means in `rated_current` and `peak_current`; needed with them"
        ),
        refers!(
            no_load_current_is,
            NoLoadCurrent,
            "what `no_load_current` is: of the winding in a convention, or of the supply; needed with it"
        ),
        count!(pole_pairs, "number of pole pairs of the motor, p"),
        count!(encoder_bits_motor, "resolution of the encoder at the motor"),
        count!(encoder_bits_output, "resolution of the encoder at the output"),
        text!(bus, "how it is talked to: can, canfd, ethercat, rs485, ttl"),
        points!(
            driving_curve,
            [SPEED, TORQUE, NonNegative],
            "largest torque over speed while it drives, from standstill on, at `voltage`"
        ),
        points!(braking_curve, [SPEED, TORQUE, NonNegative], "the same while the torque is against the speed"),
        points!(overload, [TORQUE, TIME, Positive], "longest time of a constant torque, from ambient"),
        points!(overload_stall, [TORQUE, TIME, Positive], "the same at standstill"),
        text!(heat_sink, "the heat sink of the overload test"),
        identity!(price_currency),
        identity!(price_date),
    ];

    const AFTER: &'static [Column<Module>] = &[
        identity!(source),
        identity!(source_date),
        identity!(source_kind),
        Column {
            name: "audit_accept",
            about: "codes of audit findings that the note explains",
            need: Need::May,
            holds: Holds::Text(|r| r.accepted_findings.join(";"), |r, text| r.accepted_findings = listed(&text)),
        },
        identity!(note),
    ];

    fn fields() -> &'static [Field<ModuleSheet>] {
        MODULE_FIELDS
    }

    fn numbers(&self) -> &ModuleSheet {
        &self.sheet
    }

    fn numbers_mut(&mut self) -> &mut ModuleSheet {
        &mut self.sheet
    }

    fn source_date(&self) -> &str {
        &self.source_date
    }

    fn take(&mut self, _: &Field<ModuleSheet>, _: Stated, number: Printed) -> Result<Printed, (String, String)> {
        Ok(number)
    }

    fn states(&self, _: &Field<ModuleSheet>) -> Stated {
        Stated::default()
    }
}
