//! Rows of a catalogue as a table.

use super::shown;
use crate::table::{Column, Table, paragraph};
use crate::{counted, optional};
use gearwise_model::catalog::convention::word;
use gearwise_model::catalog::filter::{Filter, Found, Kinds, RowKind, like};
use gearwise_model::catalog::module::Drive;
use gearwise_model::catalog::row::{self, Field, MotorRow};
use gearwise_model::catalog::{Catalog, Construction, FIELDS, GEAR_FIELDS, Gear, GearKind, Module, Motor};
use gearwise_model::units::{Kind, in_unit};

/// What was asked of a catalogue, and what it has.
#[derive(Debug)]
pub struct Listing<'c> {
    /// The rows.
    pub found: Found<'c>,
    /// Which kinds were asked for.
    pub kinds: Kinds,
    /// The filters.
    pub filters: Vec<Filter>,
    /// Names that may have been meant, where nothing was found.
    pub near: Vec<&'c str>,
}

impl<'c> Listing<'c> {
    /// The rows that filters leave; a kind of row that a filter's column does not have is not asked for.
    pub fn new(catalog: &'c Catalog, kinds: Kinds, filters: Vec<Filter>) -> Listing<'c> {
        // A kind of row that a filter's column does not have is not asked for; one alone that has all is.
        let has = |kind: &RowKind| filters.iter().all(|filter| filter.is_of(*kind));
        let mut having = RowKind::NAMES.iter().map(|(_, kind)| *kind).filter(has);
        let kinds = kinds.or_else(|| having.next().filter(|_| having.next().is_none()));
        let found = gearwise_model::catalog::filter::select(catalog, kinds, &filters);
        let mut near = Vec::new();
        // A text that no row has may be a slip.
        for filter in filters.iter().filter(|f| f.is_text() && f.column == "manufacturer") {
            let alone = gearwise_model::catalog::filter::select(catalog, kinds, std::slice::from_ref(filter));
            let value = filter.text.split_once('=').map_or("", |(_, value)| value);
            if alone.motors.is_empty() && alone.gears.is_empty() && alone.modules.is_empty() {
                near.extend(like(catalog, value).into_iter().filter(|name| is_maker(catalog, name)));
                near.extend(makers_with(catalog, value).into_iter().filter(|m| !near.contains(m)).collect::<Vec<_>>());
            }
        }
        Listing { found, kinds, filters, near }
    }

    /// What a search found.
    pub fn search(catalog: &'c Catalog, text: &str) -> Listing<'c> {
        let found = gearwise_model::catalog::filter::search(catalog, text);
        let mut listing = Listing { found, kinds: None, filters: Vec::new(), near: Vec::new() };
        if listing.is_empty() {
            listing.near = like(catalog, text);
        }
        listing
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        let Found { motors, gears, modules, families, .. } = &self.found;
        motors.is_empty() && gears.is_empty() && modules.is_empty() && families.is_empty()
    }
}

fn makers(catalog: &Catalog) -> impl Iterator<Item = &str> {
    let motors = catalog.motors.iter().map(|m| m.manufacturer.as_str());
    let modules = catalog.modules.iter().map(|m| m.manufacturer.as_str());
    motors.chain(catalog.gears.iter().map(|g| g.manufacturer.as_str())).chain(modules).filter(|m| !m.is_empty())
}

fn is_maker(catalog: &Catalog, name: &str) -> bool {
    makers(catalog).any(|maker| maker == name)
}

fn makers_with<'c>(catalog: &'c Catalog, text: &str) -> Vec<&'c str> {
    let text = text.trim().to_lowercase();
    let mut found: Vec<&str> = makers(catalog).filter(|m| m.to_lowercase().contains(&text)).collect();
    found.sort_unstable();
    found.dedup();
    found.truncate(5);
    found
}

/// For people.
pub fn text(listing: &Listing) -> String {
    let found = &listing.found;
    let mut out = String::new();
    if !found.motors.is_empty() {
        out.push_str(&motors(&found.motors, &listing.filters).text());
        out.push('\n');
        let frame = "K_T, K_M, R and I_cont on the power-invariant q axis; `–` is unknown, not zero.";
        out.push_str(&paragraph(frame, 0, 2));
    }
    if !found.gears.is_empty() {
        if !found.motors.is_empty() {
            out.push('\n');
        }
        out.push_str(&gears(&found.gears, &listing.filters).text());
        out.push('\n');
    }
    if !found.modules.is_empty() {
        if !found.motors.is_empty() || !found.gears.is_empty() {
            out.push('\n');
        }
        out.push_str(&modules(&found.modules).text());
        out.push('\n');
        let frame = "Torques and speeds at the output; `–` is unknown, not zero. What a row has constants for can be followed in currents, losses and voltages; of the others ratings alone.";
        out.push_str(&paragraph(frame, 0, 2));
    }
    if !found.families.is_empty() {
        if out.ends_with('\n') {
            out.push('\n');
        }
        out.push_str(&super::family::table(&found.families).text());
        out.push('\n');
        let frame = "Mass is that of the gear, without the motor. A family's points are gears that a joint takes with `family`, not with `gears`; `gearwise catalog show` lists them.";
        out.push_str(&paragraph(frame, 0, 2));
    }
    let counts = [("motor", found.motors.len()), ("gear", found.gears.len()), ("module", found.modules.len())];
    let asked = |(kind, _): &&(&str, usize)| listing.kinds.is_none_or(|asked| word(RowKind::NAMES, &asked) == *kind);
    let mut counts: Vec<String> = counts.iter().filter(asked).map(|(kind, count)| counted(*count, kind)).collect();
    match found.families.len() {
        0 if listing.kinds != Some(RowKind::Family) => {}
        1 => counts.push("1 gear family".into()),
        n => counts.push(format!("{n} gear families")),
    }
    let count = match counts.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} and {last}", before.join(", ")),
        _ => counts.concat(),
    };
    out.push_str(&paragraph(&format!("{count}."), 0, 2));
    if found.unknown > 0 {
        let by = found.unknown_by.iter().map(|(column, count)| format!("`{column}` of {}", counted(*count, "row")));
        let line = format!(
            "Not listed, because a number is not known: {} ({}).",
            counted(found.unknown, "row"),
            by.collect::<Vec<_>>().join(", ")
        );
        out.push_str(&paragraph(&line, 0, 2));
    }
    if !listing.near.is_empty() {
        let names: Vec<String> = listing.near.iter().map(|n| format!("`{n}`")).collect();
        out.push_str(&paragraph(&format!("Did you mean {}?", names.join(" or ")), 0, 2));
    }
    out
}

/// What is said of a motor beneath its row.
fn remarks(motor: &Motor) -> Vec<String> {
    let inside = &motor.about.only_inside;
    let same = &motor.about.same_as;
    let inside = (!inside.is_empty()).then(|| format!("only sold inside {inside}"));
    inside.into_iter().chain((!same.is_empty()).then(|| format!("the same motor as {same}"))).collect()
}

/// The columns of numbers that filters ask for and that are not shown anyway.
fn asked_beyond<S>(fields: &'static [Field<S>], listed: &[&str], filters: &[Filter]) -> Vec<&'static Field<S>> {
    let is_asked = |field: &&Field<S>| filters.iter().any(|filter| filter.column == field.name);
    fields.iter().filter(|field| !listed.contains(&field.name)).filter(is_asked).collect()
}

fn head(name: &str) -> Column {
    Column::number(name.replacen('_', "\n", 1).replace('_', " "), "")
}

fn cell(kind: &Kind, value: Option<f64>) -> String {
    value.map_or_else(|| "–".into(), |value| shown(kind, value))
}

fn motors(motors: &[&Motor], filters: &[Filter]) -> Table {
    let mut columns = vec![
        Column::name("motor"),
        Column::name("maker").dropped(2),
        Column::name("built").dropped(3),
        Column::number("mass", "g"),
        Column::number("diameter", "mm").dropped(7),
        Column::number("length", "mm").dropped(1),
        Column::number("K_T", "N*m/A"),
        Column::number("K_M", "N*m/W^0.5").dropped(8),
        Column::number("R", "ohm").dropped(4),
        Column::number("J_m", "g*cm^2").dropped(5),
        Column::number("I_cont", "A").dropped(6),
    ];
    // What was asked for is shown.
    let listed = [
        "mass",
        "outer_diameter",
        "length",
        "torque_constant",
        "motor_constant",
        "resistance",
        "rotor_inertia",
        "continuous_current",
    ];
    let asked = asked_beyond(FIELDS, &listed, filters);
    columns.extend(asked.iter().map(|field| head(field.name)));
    let mut table = Table::new(columns).also_in("`--csv`, `--json`");
    let unit = |value: Option<f64>, unit: &str| optional(value.map(|v| in_unit(v, unit)));
    for motor in motors {
        let sheet = &motor.sheet;
        let cells = vec![
            motor.id.clone(),
            motor.manufacturer.clone(),
            motor.about.construction.map_or("–", |c| word(Construction::NAMES, &c)).to_string(),
            unit(motor.mass, "g"),
            unit(sheet.outer_diameter.map(|p| p.value), "mm"),
            unit(sheet.length.map(|p| p.value), "mm"),
            optional(Some(motor.torque_constant)),
            optional(Some(motor.motor_constant())),
            optional(Some(motor.resistance)),
            unit(motor.rotor_inertia, "g*cm^2"),
            optional(motor.continuous_current),
        ];
        let more = asked.iter().map(|field| cell(field.kind, motor.comparable(field)));
        table.push(cells.into_iter().chain(more).collect(), remarks(motor));
    }
    table
}

fn gears(gears: &[&Gear], filters: &[Filter]) -> Table {
    let mut columns = vec![
        Column::name("gear"),
        Column::name("maker").dropped(2),
        Column::name("kind"),
        Column::number("ratio", ""),
        Column::number("stages", "").dropped(1),
        Column::number("efficiency", "").dropped(5),
        Column::number("mass", "g"),
        Column::number("T_cont", "N*m").dropped(4),
        Column::number("T_peak", "N*m"),
        Column::number("largest\ninput", "rpm").dropped(3),
    ];
    let listed = ["ratio", "efficiency", "mass", "continuous_torque", "peak_torque", "max_input_speed"];
    let asked = asked_beyond(GEAR_FIELDS, &listed, filters);
    columns.extend(asked.iter().map(|field| head(field.name)));
    let rows = gears.iter().map(|gear| {
        let unit = |value: Option<f64>, unit: &str| optional(value.map(|v| in_unit(v, unit)));
        vec![
            gear.id.clone(),
            gear.manufacturer.clone(),
            word(GearKind::NAMES, &gear.kind).to_string(),
            optional(Some(gear.ratio)),
            gear.stages.map_or_else(|| "–".into(), |s| s.to_string()),
            optional(gear.efficiency),
            unit(gear.mass, "g"),
            optional(gear.continuous_torque),
            optional(gear.peak_torque),
            unit(gear.max_input_speed, "rpm"),
        ]
        .into_iter()
        .chain(asked.iter().map(|field| cell(field.kind, (field.get)(gear).map(|p| p.value))))
        .collect()
    });
    Table::new(columns).also_in("`--csv`, `--json`").rows(rows)
}

fn modules(modules: &[&Module]) -> Table {
    let columns = vec![
        Column::name("module"),
        Column::name("maker").dropped(2),
        Column::number("ratio", "").dropped(6),
        Column::number("T_rated", "N*m"),
        Column::number("T_peak", "N*m"),
        Column::number("no-load", "rpm").dropped(7),
        Column::number("at", "V").dropped(5),
        Column::number("mass", "g"),
        Column::number("J", "kg*m^2").dropped(4),
        Column::name("drive").dropped(1),
        Column::name("says").dropped(3),
    ];
    let rows = modules.iter().map(|module| {
        let sheet = &module.sheet;
        let unit =
            |p: Option<gearwise_model::catalog::Printed>, unit: &str| optional(p.map(|p| in_unit(p.value, unit)));
        vec![
            module.id.clone(),
            module.manufacturer.clone(),
            optional(Some(module.ratio())),
            unit(sheet.rated_torque, "N*m"),
            unit(sheet.peak_torque, "N*m"),
            unit(sheet.no_load_speed, "rpm"),
            unit(sheet.voltage, "V"),
            unit(sheet.mass, "g"),
            optional(module.constants().inertia),
            word(Drive::NAMES, &module.drive).replace('_', " "),
            says(module).into(),
        ]
    });
    Table::new(columns).also_in("`--csv`, `--json`").rows(rows)
}

/// How much a module's row says, in a word.
pub(crate) fn says(module: &Module) -> &'static str {
    match module.depth() {
        gearwise_model::catalog::module::Depth::Ratings => "ratings",
        gearwise_model::catalog::module::Depth::Constants => "constants",
        gearwise_model::catalog::module::Depth::Inside => "motor and gear",
    }
}

/// As a catalogue file, which is read again as the same rows.
///
/// # Errors
/// In words, where there are rows of several kinds: a file has rows of one.
pub fn csv(listing: &Listing) -> Result<String, String> {
    let found = &listing.found;
    if listing.kinds == Some(RowKind::Family) {
        return Err("a gear family is no table: its file is TOML, and `--json` has all of it".into());
    }
    let kinds = [found.motors.is_empty(), found.gears.is_empty(), found.modules.is_empty()];
    if kinds.iter().filter(|none| !**none).count() > 1 {
        let why = "a catalogue file has rows of one kind: add `motors`, `gears` or `modules` before the filters";
        return Err(why.into());
    }
    if !found.modules.is_empty() || listing.kinds == Some(RowKind::Module) {
        let rows: Vec<Module> = found.modules.iter().map(|m| (*m).clone()).collect();
        return Ok(row::csv_text(&rows, &[]));
    }
    if found.gears.is_empty() && listing.kinds != Some(RowKind::Gear) {
        let rows: Vec<MotorRow> = found.motors.iter().map(|m| MotorRow::of(m)).collect();
        return Ok(row::csv_text(&rows, &[]));
    }
    let rows: Vec<Gear> = found.gears.iter().map(|g| (*g).clone()).collect();
    Ok(row::csv_text(&rows, &[]))
}
