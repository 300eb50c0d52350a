//! A family of gears: designs of one kind, by one rule, over the ratio; each of its points is a gear.
//!
//! The one idea: a point is read by the reader of gear rows, with what the family says once (name, kind, stages, motor,
//! source) in the place of the columns that it leaves out. Behind the reader a point is a [`Gear`] like any other; that it
//! is one of a family is known by where it stands ([`Catalog::families`]).

use std::ops::Range as Span;

use super::Catalog;
use super::gear::{Gear, GearKind, matches_pattern};
use super::offer::wrong_day;
use super::row::{self, TomlCells};
use super::sheet::SourceKind;
use crate::input::{Description, Form, Key, Problem, Range, Section, key};
use crate::units::{self, Kind};
use crate::words::number;

/// The folder that files of families stand in.
pub(super) const FOLDER: &str = "gear_families";

/// Whether a table of TOML is that of a family: it has points, or says what kind of gears they would be.
pub(super) fn is_family(root: &Section) -> bool {
    root.holds(POINTS) || root.holds("kind") && !root.is_table("motor")
}

/// The key of the list of points.
const POINTS: &str = "point";

/// Most points of a family.
const MOST_POINTS: usize = 200;

/// Two ratios that differ by less than this share of themselves are one.
const SAME: f64 = 1e-6;

/// The columns of a gear that the family says for its points.
const OF_FAMILY: &[&str] = &["id", "manufacturer", "model", "kind", "stages", "fits", "source", "source_kind"];

/// What a number of a point is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Covers {
    /// The gear alone.
    Gear,
    /// Gear and motor together.
    Actuator,
}

impl Covers {
    /// Both with the word that a file uses for them.
    pub const NAMES: &[(&str, Covers)] = &[("gear", Covers::Gear), ("actuator", Covers::Actuator)];
}

/// A family of gears. SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Family {
    /// Unique name; the ids of its points begin with it.
    pub name: String,
    /// What it is, as a gear without numbers: kind, stages, the motors that it is made for, source and note.
    pub gear: Gear,
    /// What its teeth are made of.
    pub material: String,
    /// The largest stress in a tooth that all points are made for \[Pa\].
    pub stress_limit: Option<f64>,
    /// What the length of its points is of, before that of the motor was taken off.
    pub length_covers: Covers,
    /// Its gears, by rising ratio.
    pub points: Vec<Gear>,
}

impl Family {
    /// The smallest and the largest ratio.
    pub fn range(&self) -> (f64, f64) {
        let end = |gear: Option<&Gear>| gear.map_or(f64::NAN, |gear| gear.ratio);
        (end(self.points.first()), end(self.points.last()))
    }

    /// Its stress limit in words.
    pub fn stress(&self) -> String {
        match self.stress_limit {
            Some(stress) => format!("{} MPa", number(stress / 1e6)),
            None => "no stress limit that is known".into(),
        }
    }
}

impl Catalog {
    /// The gear of an id: one that can be bought, or a point of a family.
    pub fn gear(&self, id: &str) -> Option<&Gear> {
        self.all_gears().find(|gear| gear.id == id)
    }

    /// The gears, then the points of families.
    pub fn all_gears(&self) -> impl Iterator<Item = &Gear> + Clone {
        self.gears.iter().chain(self.families.iter().flat_map(|family| &family.points))
    }

    /// The families whose name matches one of the patterns.
    pub fn families_of<'c, 'p>(&'c self, patterns: &'p [String]) -> impl Iterator<Item = &'c Family> + use<'c, 'p> {
        self.families.iter().filter(move |family| patterns.iter().any(|p| matches_pattern(p, &family.name)))
    }
}

/// A number of the points that may have the motor's in it.
struct Part {
    /// The column.
    column: &'static str,
    /// The key that says what it is of.
    covers_key: &'static str,
    /// What it is of.
    covers: Covers,
    /// The motor's, SI.
    motor: Option<f64>,
}

impl Part {
    const MASS: (&'static str, [Key; 2], &'static Kind) = (
        "mass",
        [
            key("mass_covers", "what the mass of the points is of").default("required with `mass`"),
            key("motor_mass", "of the motor in the points; with `mass_covers = \"actuator\"`"),
        ],
        &units::MASS,
    );
    const LENGTH: (&'static str, [Key; 2], &'static Kind) = (
        "length",
        [
            key("length_covers", "what the length of the points is of").default("required with `length`"),
            key("motor_length", "of the motor in the points; with `length_covers = \"actuator\"`"),
        ],
        &units::LENGTH,
    );

    /// Reads what a number is of. That the motor's is known where the number has it in it, and is not said where it has not, is looked at.
    fn read(root: &Section, (column, [covers_key, motor_key], kind): (&'static str, [Key; 2], &'static Kind)) -> Part {
        let covers = root.choice(covers_key, Covers::NAMES).unwrap_or(Covers::Gear);
        let motor = root.quantity(motor_key, kind, Range::Positive);
        let (covers_key, motor_key) = (covers_key.name(), motor_key.name());
        match covers {
            Covers::Actuator if !root.has(motor_key) => root.missing(motor_key, &format!("\"{}\"", kind.example)),
            Covers::Gear if motor.is_some() => {
                let message = format!(
                    "`{motor_key}` is that of a motor in the points, and `{covers_key}` does not say that one is in it"
                );
                let problem = Problem::at(root.span_of(motor_key), message, "taken off nothing");
                root.note(problem.help(format!("write {covers_key} = \"actuator\", or remove `{motor_key}`")));
            }
            _ => {}
        }
        Part { column, covers_key, covers, motor }
    }

    /// The gear's share of a number of a point.
    fn without_motor(&self, value: Option<f64>, section: &Section) -> Option<f64> {
        let (Covers::Actuator, Some(motor), Some(whole)) = (self.covers, self.motor, value) else { return value };
        if whole <= motor {
            let message = format!("the `{}` of the actuator is not more than that of its motor", self.column);
            section.note(Problem::at(section.span_of(self.column), message, "nothing is left for the gear"));
        }
        Some(whole - motor)
    }
}

/// What the reader asks for, but for the columns of a gear in the points, which have a list of their own.
pub fn describe() -> Description {
    Form::describe("", read)
}

/// Reads a family; `None` where it has mistakes, which are noted.
pub(super) fn read(root: &Section) -> Option<Family> {
    let before = root.noted();
    let text = |name: &'static str, about: &'static str| root.text(key(name, about)).map(toml::Spanned::into_inner);
    let name =
        root.required_text(key("name", "of the family; the ids of its points begin with it"), "\"compact-u8-sspg\"");
    let kind = root.choice(key("kind", "how its gears reduce").required(), GearKind::NAMES);
    let motor = root.text(
        key("motor", "the motor that it is made for: an id or a pattern, several by blanks").default("any motor"),
    );
    let stages = root.count(key("stages", "of its gears").default("not known"));
    let material = text("material", "of the teeth");
    let stress_limit =
        root.quantity(key("stress_limit", "in a tooth, that all points are made for"), &units::STRESS, Range::Positive);
    let parts = [Part::MASS, Part::LENGTH].map(|part| Part::read(root, part));
    let maker = text("manufacturer", "who makes it, or made the designs").unwrap_or_default();
    let source = root.required_text(key("source", "where the numbers come from"), "\"arXiv 2510.07197\"");
    let source_date = text("source_date", "day, month or year of the source").unwrap_or_default();
    if let Some(wrong) = wrong_day("source_date", &source_date) {
        root.note(Problem::at(root.span_of("source_date"), wrong.message, "a date").help(wrong.help));
    }
    let source_kind = root.choice(key("source_kind", "what kind of source that is").required(), SourceKind::NAMES);
    let note = text("note", "what its reader should know").unwrap_or_default();
    for (is, example) in [("kind", "\"planetary\""), ("source_kind", "\"derived\"")] {
        if !root.has(is) {
            root.missing(is, example);
        }
    }
    if let Some(name) = &name {
        check_name(root, name.get_ref(), name.span());
    }
    let shared = |kind, source: String, source_kind| Gear {
        manufacturer: maker.clone(),
        kind,
        stages,
        fits: motor.as_ref().map(|m| row::listed(m.get_ref())).unwrap_or_default(),
        source,
        source_date: source_date.clone(),
        source_kind,
        note: note.clone(),
        ..Gear::blank()
    };
    let known = name.as_ref().zip(kind).zip(source.as_ref().zip(source_kind));
    let gear = known.map(|((_, kind), (source, source_kind))| shared(kind, source.get_ref().clone(), source_kind));
    let name = name.map(toml::Spanned::into_inner).unwrap_or_default();
    let points = read_points(root, &name, gear.as_ref(), &parts);
    (root.noted() == before).then(|| Family {
        name,
        gear: gear.unwrap_or_else(Gear::blank),
        material: material.unwrap_or_default(),
        stress_limit,
        length_covers: parts[1].covers,
        points,
    })
}

fn check_name(root: &Section, name: &str, span: Span<usize>) {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '.' | '_');
    if name.is_empty() || !name.chars().all(good) {
        let message = "the name of a family has lower-case letters, digits, `-`, `_` and `.` only";
        root.note(Problem::at(span, message, "other characters here").help("for example compact-u8-sspg"));
    }
}

/// Reads the points, by rising ratio, each with an id.
fn read_points(root: &Section, name: &str, gear: Option<&Gear>, parts: &[Part; 2]) -> Vec<Gear> {
    let before = root.noted();
    let about = "one for each gear of the family";
    let sections = root.some_sections(key(POINTS, about).required(), "a table [[point]] for each gear");
    let mut points: Vec<(Gear, Span<usize>)> = Vec::new();
    if let Some(extra) = sections.get(MOST_POINTS) {
        let message = format!("the family has {} points", sections.len());
        root.note(Problem::at(extra.span(), message, format!("at most {MOST_POINTS}")));
        return Vec::new();
    }
    let mut missing = [false; 2];
    for section in sections {
        let stress = section.quantity(
            key("stress_limit", "of this point; refused where it is not that of the family")
                .default("that of the family"),
            &units::STRESS,
            Range::Positive,
        );
        check_stress(&section, root, stress);
        for column in OF_FAMILY.iter().filter(|column| section.holds(column)) {
            let problem =
                Problem::at(section.span_of(column), format!("a point has no `{column}`"), "the family has it");
            section.note(problem.help(format!("write `{column}` above the points, or make another family")));
        }
        let read = row::point(&TomlCells(&section), gear.cloned().unwrap_or_else(Gear::blank), OF_FAMILY);
        for (part, is_missing) in parts.iter().zip(&mut missing) {
            *is_missing |= section.has(part.column) && !root.has(part.covers_key);
        }
        if let Some(point) = read {
            let [mass, length] = parts;
            let (mass, length) =
                (mass.without_motor(point.mass, &section), length.without_motor(point.length, &section));
            let motor_length = parts[1].motor;
            points.push((Gear { mass, length, motor_length, ..point }, section.span()));
        }
        section.finish();
    }
    for (part, _) in parts.iter().zip(missing).filter(|(_, is)| *is) {
        root.missing(part.covers_key, "\"gear\"  # or \"actuator\", where the motor is in it");
    }
    if root.noted() > before {
        return Vec::new();
    }
    points.sort_by(|(a, _), (b, _)| a.ratio.total_cmp(&b.ratio));
    for pair in points.windows(2) {
        let [(before, _), (after, span)] = pair else { continue };
        if after.ratio - before.ratio <= SAME * after.ratio {
            let message = format!("the ratio {} is there twice", number(after.ratio));
            root.note(Problem::at(span.clone(), message, "second time").help("leave the worse of the two out"));
        }
    }
    let mut points: Vec<Gear> = points.into_iter().map(|(point, _)| point).collect();
    let texts = distinct(&points.iter().map(|p| p.ratio).collect::<Vec<_>>());
    for (point, text) in points.iter_mut().zip(texts) {
        point.id = format!("{name}-{text}");
        point.model = point.id.clone();
        point.family = name.to_string();
    }
    points
}

/// A tooth of another stress is a gear of another rule: the two make no family.
fn check_stress(section: &Section, root: &Section, stress: Option<f64>) {
    let Some(stress) = stress else { return };
    let of_family = root.quantity("stress_limit", &units::STRESS, Range::Positive);
    if of_family.is_some_and(|of_family| (stress / of_family - 1.0).abs() <= SAME) {
        return;
    }
    let of_family = of_family.map_or("none".to_string(), |s| format!("{} MPa", number(s / 1e6)));
    let message = format!("this point is made for {} MPa, the family for {of_family}", number(stress / 1e6));
    let problem = Problem::at(section.span_of("stress_limit"), message, "another rule");
    section.note(problem.help("gears of two stress limits are two families: one file for each"));
}

/// Ratios in as few digits as tell them apart, four at least.
fn distinct(ratios: &[f64]) -> Vec<String> {
    let with = |digits: usize| -> Vec<String> {
        let text = |ratio: &f64| {
            let decimals = (digits as i32 - 1 - ratio.abs().log10().floor() as i32).max(0) as usize;
            let text = format!("{ratio:.decimals$}");
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
                false => text,
            }
        };
        ratios.iter().map(text).collect()
    };
    let all = (4..=15).map(with);
    let apart = |texts: &Vec<String>| texts.windows(2).all(|pair| pair[0] != pair[1]);
    all.clone().find(apart).unwrap_or_else(|| with(15))
}
