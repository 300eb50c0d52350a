//! `[joint.gear] map`: the file of a family of gears, and what goes with it.

use std::sync::Arc;

use super::gear::{GearModel, RatioChoice, backdrive_efficiency};
use super::gear_map::{GearMap, MapRow};
use super::limits::Limits;
use super::motions::MotionReader;
use super::robot::{Budget, Joint};
use crate::input::csv::{Column, Content, Table};
use crate::input::kind::{self, FileKind};
use crate::input::{InputError, Problem, Range, Section, Source, key};
use crate::units::{self, Kind};

/// The columns of a map, each with the keys of `[joint.gear]` that say the same.
const COLUMNS: &[(&str, &Kind, Range, &[&str])] = &[
    ("ratio", &units::RATIO, Range::Positive, &[]),
    ("mass", &units::MASS, Range::NonNegative, &["mass", "mass_per_stage", "stage_ratio"]),
    ("inertia", &units::INERTIA, Range::NonNegative, &["inertia"]),
    ("efficiency", &units::RATIO, Range::Fraction, &["efficiency"]),
    ("backdrive_efficiency", &units::RATIO, Range::Any, &["backdrive_efficiency"]),
    (
        "no_load_torque",
        &units::TORQUE,
        Range::NonNegative,
        &["no_load_torque", "starting_torque", "no_load_torque_speed"],
    ),
    ("peak_torque", &units::TORQUE, Range::Positive, &["peak_torque"]),
    ("continuous_torque", &units::TORQUE, Range::Positive, &["continuous_torque"]),
    ("max_input_speed", &units::SPEED, Range::Positive, &["max_input_speed"]),
];

/// Columns of a family that nothing is computed with.
const NOT_MODELLED: &[&str] = &["outer_diameter", "length", "axial_length", "price"];
/// Two ratios that differ by less than this share are a slip, not a piece.
const APART: f64 = 1e-6;
/// Most rows of a map.
const MOST_ROWS: usize = 200;

/// A map with its place in the requirement.
pub(super) struct Read {
    /// The map.
    pub(super) map: Arc<GearMap>,
    /// Where the requirement names it.
    pub(super) span: std::ops::Range<usize>,
}

/// Reads `map` of a joint's gear; `None` where there is none, or one with mistakes, which are noted.
pub(super) fn read(section: &Section, motions: &mut MotionReader) -> Option<Read> {
    let about = "CSV file next to this one: the gear over the ratio, a row for each of a family; between two rows it is \
                 interpolated";
    let file = section.text(key("map", about).value("file").default("a gear that is the same at all ratios"))?;
    let source = match motions.open(&section.source().folder().join(file.get_ref())) {
        Ok(source) => source,
        Err(error) => {
            section.note(error.where_named("gear map", file.get_ref(), file.span()));
            return None;
        }
    };
    let (columns, rows) = match read_rows(&source) {
        Ok(read) => read,
        Err(error) => {
            motions.errors.push(kind::instead(error, &[FileKind::GearMap, FileKind::Table, FileKind::Empty]));
            return None;
        }
    };
    let said_twice = COLUMNS
        .iter()
        .filter(|(name, ..)| columns.contains(name))
        .flat_map(|(name, .., keys)| keys.iter().filter(|key| section.has(**key)).map(move |key| (*name, *key)));
    for (column, key) in said_twice.collect::<Vec<_>>() {
        let message = format!("`{key}` of [gear] and the column `{column}` of its `map` say one thing");
        let problem = Problem::at(section.span_of(key), message, "the map has it, too");
        section.note(problem.help("remove the key, or the column"));
    }
    let follows = columns.contains(&"efficiency") && !section.has("backdrive_efficiency");
    let rows: Vec<MapRow> = rows
        .into_iter()
        .map(|row| MapRow {
            braking: row.braking.or_else(|| row.driving.filter(|_| follows).map(|d| backdrive_efficiency(1.0 / d))),
            ..row
        })
        .collect();
    let map = GearMap::new(&rows)?;
    Some(Read { map: Arc::new(map), span: file.span() })
}

/// The rows of a map, and its columns.
fn read_rows(source: &Arc<Source>) -> Result<(Vec<&'static str>, Vec<MapRow>), InputError> {
    let mut problems = Vec::new();
    let read = read_table(source, &mut problems);
    InputError::unless_empty(source, problems)?;
    read.ok_or_else(|| InputError {
        source: source.clone(),
        problems: vec![Problem::whole("the map could not be read")],
    })
}

fn read_table(source: &Arc<Source>, problems: &mut Vec<Problem>) -> Option<(Vec<&'static str>, Vec<MapRow>)> {
    let own = COLUMNS.iter().map(|(name, kind, range, _)| Column {
        name: (*name).into(),
        content: Content::Quantity(kind, *range),
        required: *name == "ratio",
    });
    let aside =
        NOT_MODELLED.iter().map(|name| Column { name: (*name).into(), content: Content::Text, required: false });
    let header_alone = |name: &str| name.split('[').next().unwrap_or("").trim().to_string();
    let first = source.text().lines().find(|line| !line.starts_with('#') && !line.trim().is_empty());
    if let Some(name) =
        first.and_then(|line| line.split(',').map(header_alone).find(|name| NOT_MODELLED.contains(&name.as_str())))
    {
        let message = format!("column `{name}`: nothing is computed with it in a gear map");
        let line = first.unwrap_or("");
        let at = (line.as_ptr() as usize - source.text().as_ptr() as usize) + line.find(&name).unwrap_or(0);
        let problem = Problem::at(at..at + name.len(), message, "not used");
        problems.push(problem.help("remove the column"));
        return None;
    }
    let table = Table::read(source, own.chain(aside).collect(), problems)?;
    let columns: Vec<&'static str> = COLUMNS.iter().map(|(name, ..)| *name).filter(|name| table.has(name)).collect();
    if columns.len() < 2 {
        let all: Vec<&str> = COLUMNS.iter().map(|(name, ..)| *name).skip(1).collect();
        let problem = Problem::at(table.header_span(), "the map says nothing but the ratio", "no other column");
        problems.push(problem.help(format!("add any of {}", all.join(", "))));
    }
    if table.len() > MOST_ROWS {
        let message = format!("the map has {} rows", table.len());
        problems.push(Problem::at(table.row_span(MOST_ROWS), message, format!("at most {MOST_ROWS}")));
        return None;
    }
    let before = problems.len();
    let mut rows = Vec::with_capacity(table.len());
    for row in 0..table.len() {
        let mut cell = |name: &str| {
            if !columns.contains(&name) {
                return None;
            }
            if table.text(row, name).is_none() {
                let message = format!("`{name}` is missing in row {}", row + 1);
                let problem = Problem::at(table.row_span(row), message, "a blank cell");
                problems.push(
                    problem.help("a map says each of its columns in every row: fill the cell, or remove the column"),
                );
                return None;
            }
            table.number(row, name, problems).map(|number| number.value)
        };
        let read = MapRow {
            ratio: cell("ratio").unwrap_or(f64::NAN),
            mass: cell("mass"),
            inertia: cell("inertia"),
            driving: cell("efficiency").map(|efficiency| 1.0 / efficiency),
            braking: cell("backdrive_efficiency"),
            no_load_torque: cell("no_load_torque"),
            peak_torque: cell("peak_torque"),
            continuous_torque: cell("continuous_torque"),
            max_input_speed: cell("max_input_speed"),
        };
        if let Some(above) = read.braking.filter(|braking| *braking > 1.0) {
            let message =
                format!("`backdrive_efficiency` of {} is out of range in row {}", crate::words::number(above), row + 1);
            problems.push(Problem::at(table.cell_span(row, "backdrive_efficiency"), message, "expected at most 1"));
        }
        if let (Some(held), Some(most)) = (read.continuous_torque, read.peak_torque)
            && held > most
        {
            let message = format!(
                "`continuous_torque` of {} N*m is more than `peak_torque` of {} N*m in row {}",
                crate::words::number(held),
                crate::words::number(most),
                row + 1
            );
            let span = table.cell_span(row, "continuous_torque");
            problems.push(Problem::at(span, message, "more than the gear may bear at all"));
        }
        rows.push(read);
    }
    if problems.len() > before {
        return None;
    }
    check_order(&table, &rows, problems);
    Some((columns, rows))
}

/// Ratios that do not make a map: too few, not rising, or a jump without a row on both sides.
fn check_order(table: &Table, rows: &[MapRow], problems: &mut Vec<Problem>) {
    let mut wrong = |row: usize, message: String, label: &str, help: &str| {
        problems.push(Problem::at(table.cell_span(row, "ratio"), message, label).help(help.to_string()));
    };
    if rows.len() < 2 {
        if let Some(only) = rows.first() {
            let message = format!("the map has one row, of ratio {}", crate::words::number(only.ratio));
            wrong(
                0,
                message,
                "expected at least two rows",
                "a gear that is the same at all ratios has no `map`: give its numbers as keys of [joint.gear]",
            );
        }
        return;
    }
    for k in 1..rows.len() {
        let (before, here) = (rows[k - 1].ratio, rows[k].ratio);
        let (said, after) = (crate::words::number(here), crate::words::number(before));
        let to = format!("row {}", k + 1);
        if here < before {
            wrong(
                k,
                format!("the ratios do not rise: {said} in {to} after {after}"),
                "less than the row above",
                "sort the rows by ratio",
            );
        } else if here != before && here - before < APART * here {
            wrong(
                k,
                format!("the ratio {said} in {to} is nearly that of the row above"),
                "neither a jump nor a piece",
                "give both rows the same ratio for a jump, or leave one out",
            );
        } else if here == before && (k == 1 || k + 1 == rows.len()) {
            let end = if k == 1 { "begins" } else { "ends" };
            wrong(
                k,
                format!("the map {end} with a jump: the ratio {said} twice"),
                "a jump needs a piece on both sides",
                "leave one of the two rows out",
            );
        } else if here == before && rows[k - 2].ratio == here {
            wrong(
                k,
                format!("the ratio {said} is there three times"),
                "a jump has two rows",
                "leave the row between out",
            );
        }
    }
}

/// What does not go with a map is a mistake of the joint: a range that the map does not cover, limits that are not known over
/// the ratio, springs.
pub(super) fn check(section: &Section, read: &Read, ratio: Option<&RatioChoice>, limits: &Limits) {
    let (first, last) = read.map.range();
    let number = crate::words::number;
    let wrong = |span: std::ops::Range<usize>, message: String, label: &str, help: String| {
        section.note(Problem::at(span, message, label).help(help));
    };
    if let Some((min, max)) = ratio.and_then(RatioChoice::range)
        && !(read.map.covers(min) && read.map.covers(max))
    {
        let message = format!(
            "the ratios go from {} to {}, the gear's `map` from {} to {}",
            number(min),
            number(max),
            number(first),
            number(last)
        );
        let help = "narrow `ratio`, or add rows to the map: nothing is known of the gear beyond its rows";
        wrong(section.span_of("ratio"), message, "reaches beyond the map", help.into());
    }
    if limits.spring.is_some() {
        let message = "a spring is not chosen together with a gear `map`";
        let help = "remove the spring, or give the gear's numbers as keys of [joint.gear]";
        wrong(read.span.clone(), message.into(), "and the joint has a spring", help.into());
    }
    if limits.life.is_some() && read.map.says(|row| row.continuous_torque) {
        let message = "`life` is not judged where the gear's `map` has a column `continuous_torque`";
        let help = "remove `life`, or give `continuous_torque` as a key of [joint.gear]";
        wrong(section.span_of("limits"), message.into(), "[joint.limits] has `life`", help.into());
    }
    let friction = read.map.says(|row| row.no_load_torque) || read.map.says(|row| row.braking);
    if limits.max_backdriving_torque.is_some() && friction {
        let message = "`max_backdriving_torque` is not judged where the gear's `map` has its efficiency or its torque without load";
        let help = "remove the limit, or give these numbers as keys of [joint.gear]";
        wrong(section.span_of("limits"), message.into(), "[joint.limits] has `max_backdriving_torque`", help.into());
    }
}

/// The same of ratios between the points of a family: what the points say is known with the catalogue, so that nothing goes with
/// them that would not go with all they may say.
pub(super) fn check_between(section: &Section, limits: &Limits) {
    let with = [
        ("spring", limits.spring.is_some()),
        ("life", limits.life.is_some()),
        ("max_backdriving_torque", limits.max_backdriving_torque.is_some()),
    ];
    for (name, _) in with.into_iter().filter(|(_, is)| *is) {
        let message = format!("`between` and `{name}` of [joint.limits] do not go together");
        let problem = Problem::at(section.span_of("between"), message, "ratios between the points of a family");
        section.note(
            problem
                .help(format!("leave `between` out: the points are gears, and `{name}` goes with them; or remove it")),
        );
    }
}

/// The gear of a joint with a map: that at the smallest ratio which may be chosen.
pub(super) fn gear(base: &GearModel, map: &GearMap, ratio: Option<&RatioChoice>) -> GearModel {
    let says_loss = base.says_loss || map.says(|row| row.driving) || map.says(|row| row.no_load_torque);
    let smallest = ratio.and_then(RatioChoice::range).map_or(map.range().0, |(min, _)| min);
    GearModel { says_loss, ..map.gear(base, smallest) }
}

/// What of a whole robot does not go with a map: joints whose choices depend on each other by power, by mass or by what they
/// carry. `places` are those of the joints.
pub(super) fn check_robot(root: &Section, joints: &[Joint], places: &[std::ops::Range<usize>], budget: Budget) {
    for (k, (joint, place)) in joints.iter().zip(places).enumerate() {
        let between = joint.ratio.is_between();
        let (word, has_mass) = match &joint.gear_map {
            Some(map) => ("a gear `map`", map.says(|row| row.mass)),
            None if between => ("ratios `between` the points of a family", true),
            None => continue,
        };
        let is_carried = joints.iter().any(|other| other.carries.iter().any(|carried| carried.joint == k));
        let what = match () {
            () if !joint.carries.is_empty() => "carries other actuators",
            () if is_carried => "is carried by another joint",
            () if budget.power.is_some() || budget.current.is_some() => "shares a budget of power or current",
            () if budget.regeneration.is_some() => "shares a budget of what comes back",
            () if budget.actuator_mass.is_some() && has_mass => "shares a budget of mass",
            () => continue,
        };
        let message = format!("joint `{}` has {word} and {what}: the two are not combined", joint.name);
        let help = match between {
            true => "leave `between` out, or choose this joint in a requirement of its own",
            false => {
                "give the gear's numbers as keys of [joint.gear], or choose this joint in a requirement of its own"
            }
        };
        root.note(Problem::at(place.clone(), message, "this joint").help(help));
    }
}
