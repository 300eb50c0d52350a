//! What a catalogue holds: its rows as a table, one row as a card, and what two catalogues do not have in common.

pub mod against;
pub mod card;
pub mod diff;
pub mod family;
pub mod lacks;
pub mod list;
pub mod module;
pub mod path;

use gearwise_model::units::{Kind, in_unit};
use gearwise_model::words::handy::handy;

/// Units that people use for what is not scaled by size.
const USUAL: &[(&str, &str)] =
    &[("rad/s", "rpm"), ("rad/(V*s)", "rpm/V"), ("K", "degC"), ("m", "mm"), ("rad", "arcmin")];

/// The unit in which a number of a catalogue is shown \[text\], by a number of it.
pub(crate) fn unit_for(kind: &Kind, value: f64) -> &'static str {
    match (USUAL.iter().find(|(si, _)| *si == kind.si), kind.si) {
        (Some((_, usual)), _) => usual,
        (None, "kg") if value.abs() < 1.0 => "g",
        (None, "kg*m^2*A^2/(N*m)^2") => "g*(A/N)^2",
        // A life.
        (None, "s") if value >= 1e5 => "h",
        (None, si) => handy(value, si).1,
    }
}

/// A number with its unit as it is shown.
pub(crate) fn shown(kind: &Kind, value: f64) -> String {
    let unit = unit_for(kind, value);
    gearwise_model::words::with_unit(in_unit(value, unit), unit)
}
