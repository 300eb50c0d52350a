//! A gearbox of MGDB as the catalogue's, and direct drive.

use super::super::Row;
use super::cells::Cells;
use crate::catalog::{Gear, GearKind, SourceKind};
use crate::input::{Range, Source};
use crate::words::number;

/// Id of the gear that stands for direct drive.
pub(crate) const DIRECT: &str = "direct";

/// Direct drive: nothing between motor and output; fits every motor.
pub fn direct() -> Row<Gear> {
    let gear = Gear {
        id: DIRECT.into(),
        manufacturer: String::new(),
        model: "direct drive".into(),
        kind: GearKind::Direct,
        efficiency: Some(1.0),
        backdrive_efficiency: Some(1.0),
        mass: Some(0.0),
        inertia: Some(0.0),
        fits: vec!["*".into()],
        source: "no gear: added with the import of MGDB".into(),
        source_kind: SourceKind::Derived,
        ratio: 1.0,
        ..Gear::blank()
    };
    Row { key: DIRECT.into(), place: None, item: gear }
}

/// Reads a row; `None` where it is refused. Id and `fits` are left to the caller.
pub fn read(cells: &mut Cells, key: &str, source: &Source) -> Option<Gear> {
    let kind = kind(cells);
    let ratio = cells.required("ratio", "missing-ratio");
    let mut note = format!("{key} of MGDB.");
    let mut gear = Gear {
        stages: stages(cells),
        efficiency: cells.number("efficiency", Range::Fraction),
        mass: cells.number("mass", Range::NonNegative),
        inertia: cells.number("inertia", Range::NonNegative),
        continuous_torque: cells.number("max_cont_torque", Range::Positive),
        peak_torque: cells.number("max_int_torque", Range::Positive),
        kind: GearKind::Planetary,
        ratio: ratio.unwrap_or(f64::NAN),
        source_kind: SourceKind::Secondary,
        ..Gear::blank()
    };
    if gear.efficiency.is_none() {
        gear.efficiency = Some(1.0);
        cells.assume("gear-lossless", "efficiency is not said: taken as 1, as CORDS does");
        note.push_str(" Efficiency is not said there and taken as 1.");
    }
    gear.backdrive_efficiency = gear.efficiency;
    for (what, zero) in [("mass", gear.mass == Some(0.0)), ("inertia", gear.inertia == Some(0.0))] {
        if zero {
            cells.assume("gear-zero", format!("{what} is 0 and taken so; it may mean that it is not known"));
        }
    }
    if let (Some(continuous), Some(peak)) = (gear.continuous_torque, gear.peak_torque)
        && continuous > peak
    {
        gear.continuous_torque = Some(peak);
        let message = format!(
            "continuous torque taken as {} N*m, the intermittent one: {} N*m is printed, which is more",
            number(peak),
            number(continuous)
        );
        cells.assume("continuous-torque-lowered", message);
        note.push_str(" Its continuous torque exceeds its intermittent torque there; the lower is taken for both.");
    }
    match cells.text("direction").parse::<f64>() {
        Ok(1.0) => {}
        Ok(-1.0) => {
            cells.assume("direction-reversed", "direction is -1, output against motor; the ratio is taken as positive");
            note.push_str(" The output turns against the motor.");
        }
        Err(_) if cells.text("direction").is_empty() => {}
        _ => {
            let message = format!("direction is `{}`: expected 1 or -1", cells.text("direction"));
            cells.refuse("direction", "unknown-direction", message);
        }
    }
    let (manufacturer, model) = cells.maker_and_model(key, source.folder());
    ratio?;
    Some(Gear {
        kind: kind?,
        source: format!("{manufacturer} {model}, as collected in MGDB"),
        manufacturer,
        model,
        note,
        ..gear
    })
}

fn kind(cells: &mut Cells) -> Option<GearKind> {
    let text = cells.text("type");
    let plain = text.to_ascii_lowercase().replace([' ', '-'], "_");
    if plain == "koaxdrive" {
        cells.assume("koaxdrive-planetary", "a Koaxdrive (its first stage is driven by a worm) is taken as planetary");
        return Some(GearKind::Planetary);
    }
    let found = GearKind::NAMES.iter().find(|(word, _)| *word == plain).map(|(_, kind)| *kind);
    if found.is_none() {
        let names: Vec<&str> = GearKind::NAMES.iter().map(|(word, _)| *word).collect();
        let text: String = text.chars().take(60).collect();
        cells.refuse("type", "unknown-type", format!("type is `{text}`: expected one of {}", names.join(", ")));
    }
    found
}

fn stages(cells: &mut Cells) -> Option<u32> {
    let stages = cells.number("stages", Range::AtLeastOne)?;
    if stages.fract() != 0.0 || stages > 100.0 {
        cells.refuse("stages", "value-out-of-range", format!("stages is {stages}: expected a whole number"));
        return None;
    }
    Some(stages as u32)
}
