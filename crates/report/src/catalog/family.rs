//! Families of gears as a table, and one with its points.

use super::card::{line, sourced, titled};
use crate::table::{Column, Table};
use crate::{counted, number, optional};
use gearwise_model::catalog::convention::word;
use gearwise_model::catalog::{Family, Gear, GearKind};
use gearwise_model::units::in_unit;

/// One row for each family.
pub(super) fn table(families: &[&Family]) -> Table {
    let columns = vec![
        Column::name("family"),
        Column::name("kind").dropped(2),
        Column::number("stages", "").dropped(1),
        Column::number("points", ""),
        Column::number("ratio", ""),
        Column::number("mass", "g"),
        Column::number("efficiency", "").dropped(3),
        Column::number("stress\nlimit", "MPa").dropped(4),
        Column::name("made for").dropped(5),
    ];
    let rows = families.iter().map(|family| {
        let span = |of: fn(&Gear) -> Option<f64>, factor: f64| {
            let known = family.points.iter().filter_map(of).map(|value| value * factor);
            let ends = known.fold(None, |ends: Option<(f64, f64)>, v| match ends {
                None => Some((v, v)),
                Some((least, most)) => Some((least.min(v), most.max(v))),
            });
            ends.map_or_else(|| "–".into(), |(least, most)| format!("{} to {}", number(least), number(most)))
        };
        vec![
            family.name.clone(),
            word(GearKind::NAMES, &family.gear.kind).to_string(),
            family.gear.stages.map_or_else(|| "–".into(), |stages| stages.to_string()),
            family.points.len().to_string(),
            span(|gear| Some(gear.ratio), 1.0),
            span(|gear| gear.mass, 1e3),
            span(|gear| gear.efficiency, 1.0),
            optional(family.stress_limit.map(|stress| in_unit(stress, "MPa"))),
            made_for(family),
        ]
    });
    Table::new(columns).also_in("`--json`").rows(rows)
}

fn made_for(family: &Family) -> String {
    if family.gear.fits.is_empty() { "any motor".into() } else { family.gear.fits.join(", ") }
}

/// A family with its points, for people.
pub fn text(family: &Family) -> String {
    let mut out = format!("{}\n", family.name);
    let stages = family.gear.stages.map_or_else(String::new, |s| format!(", {}", counted(s as usize, "stage")));
    let kind = word(GearKind::NAMES, &family.gear.kind);
    let by = if family.gear.manufacturer.is_empty() { "" } else { " by " };
    let what = format!("{kind}{stages}, {}{by}{}", counted(family.points.len(), "point"), family.gear.manufacturer);
    line(&mut out, "gear family", &what);
    line(&mut out, "made for", &made_for(family));
    line(&mut out, "material", &family.material);
    line(&mut out, "stress limit of its teeth", &family.stress());
    line(&mut out, "source", &sourced(&family.gear.source, &family.gear.source_date, family.gear.source_kind));
    line(&mut out, "note", &family.gear.note);
    titled(&mut out, "Points (torque at the output; without the motor's part of mass and length):");
    let columns = vec![
        Column::name("gear"),
        Column::number("ratio", ""),
        Column::number("efficiency", ""),
        Column::number("mass", "g"),
        Column::number("length", "mm").dropped(1),
        Column::number("T_peak", "N*m"),
    ];
    let rows = family.points.iter().map(|gear| {
        let unit = |value: Option<f64>, unit: &str| optional(value.map(|v| in_unit(v, unit)));
        vec![
            gear.id.clone(),
            number(gear.ratio),
            optional(gear.efficiency),
            unit(gear.mass, "g"),
            unit(gear.length, "mm"),
            optional(gear.peak_torque),
        ]
    });
    out.push_str(&Table::new(columns).indented(2).also_in("`--json`").rows(rows).text());
    out.push('\n');
    let ask = format!(
        "A joint takes them with `family = [\"{}\"]`; `between = true` allows ratios between them.",
        family.name
    );
    out + &crate::table::paragraph(&ask, 0, 2)
}
