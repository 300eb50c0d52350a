//! A family of gears: designs of one kind, by one rule, over the ratio; each of its points is a gear.
//!
//! The one idea: a point is read by the reader of gear rows, with what the family says once (name, kind, stages, motor,
//! source) in the place of the columns that it leaves out. Behind the reader a point is a [`Gear`] like any other; that it
//! is one of a family is known by where it stands ([`Catalog::families`]).

use std::ops::Range as Span;

use super::Catalog;
use super::gear::{Gear, GearKind, matches_pattern};
use super::row::{self, TomlCells};
use super::sheet::SourceKind;
use crate::input::{Description, Form, Problem, Range, Section, key};
use crate::units;
use crate::words::{counted, number};

/// The folder that files of families stand in.
pub(super) const FOLDER: &str = "gear_families";

/// The key of the list of points.
pub(super) const POINTS: &str = "point";

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

/// The numbers of the family itself.
struct Own {
    motor_mass: Option<f64>,
    motor_length: Option<f64>,
    mass_covers: Covers,
    length_covers: Covers,
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
    let quantity =
        |name: &'static str, about: &'static str, kind| root.quantity(key(name, about), kind, Range::Positive);
    let own = Own {
        mass_covers: root
            .choice(
                key("mass_covers", "what the mass of the points is of").default("required with `mass`"),
                Covers::NAMES,
            )
            .unwrap_or(Covers::Gear),
        motor_mass: quantity(
            "motor_mass",
            "of the motor in the points; with `mass_covers = \"actuator\"`",
            &units::MASS,
        ),
        length_covers: root
            .choice(
                key("length_covers", "what the length of the points is of").default("required with `length`"),
                Covers::NAMES,
            )
            .unwrap_or(Covers::Gear),
        motor_length: quantity(
            "motor_length",
            "of the motor in the points; with `length_covers = \"actuator\"`",
            &units::LENGTH,
        ),
    };
    check_covers(root, "mass_covers", own.mass_covers, ("motor_mass", "\"240 g\""), own.motor_mass);
    check_covers(root, "length_covers", own.length_covers, ("motor_length", "\"26.5 mm\""), own.motor_length);
    let maker = text("manufacturer", "who makes it, or made the designs").unwrap_or_default();
    let source = root.required_text(key("source", "where the numbers come from"), "\"arXiv 2510.07197\"");
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
        source_kind,
        note: note.clone(),
        ..Gear::blank()
    };
    let known = name.as_ref().zip(kind).zip(source.as_ref().zip(source_kind));
    let gear = known.map(|((_, kind), (source, source_kind))| shared(kind, source.get_ref().clone(), source_kind));
    let name = name.map(toml::Spanned::into_inner).unwrap_or_default();
    let points = read_points(root, &name, gear.as_ref(), &own);
    (root.noted() == before).then(|| Family {
        name,
        gear: gear.unwrap_or_else(Gear::blank),
        material: material.unwrap_or_default(),
        stress_limit,
        length_covers: own.length_covers,
        points,
    })
}

/// That the motor's part of a number is known where the number has it in it, and is not said where it has not.
fn check_covers(
    root: &Section,
    covers: &'static str,
    is: Covers,
    (part, example): (&'static str, &str),
    value: Option<f64>,
) {
    match (is, root.has(part)) {
        (Covers::Actuator, false) => root.missing(part, example),
        (Covers::Gear, true) if value.is_some() => {
            let message =
                format!("`{part}` is that of a motor in the points, and `{covers}` does not say that one is in it");
            let problem = Problem::at(root.span_of(part), message, "taken off nothing");
            root.note(problem.help(format!("write {covers} = \"actuator\", or remove `{part}`")));
        }
        _ => {}
    }
}

fn check_name(root: &Section, name: &str, span: Span<usize>) {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '.' | '_');
    if name.is_empty() || !name.chars().all(good) {
        let message = "the name of a family has lower-case letters, digits, `-`, `_` and `.` only";
        root.note(Problem::at(span, message, "other characters here").help("for example compact-u8-sspg"));
    }
}

/// Reads the points, by rising ratio, each with an id.
fn read_points(root: &Section, name: &str, gear: Option<&Gear>, own: &Own) -> Vec<Gear> {
    let before = root.noted();
    let sections = root.sections(key(POINTS, "one for each gear of the family").required());
    if sections.is_empty() && !root.has(POINTS) {
        root.missing(POINTS, "a table [[point]] for each gear");
    }
    let mut points: Vec<(Gear, Span<usize>)> = Vec::new();
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
        for (number, covers) in [("mass", "mass_covers"), ("length", "length_covers")] {
            if section.has(number) && !root.has(covers) {
                root.missing(covers, "\"gear\"  # or \"actuator\", where the motor is in it");
            }
        }
        if let Some(point) = read {
            points.push((without_motor(point, own, &section), section.span()));
        }
        section.finish();
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

/// A point without what of its mass and length is the motor's.
fn without_motor(point: Gear, own: &Own, section: &Section) -> Gear {
    let off = |name: &'static str, covers, motor: Option<f64>, value: Option<f64>| match (covers, motor, value) {
        (Covers::Actuator, Some(motor), Some(value)) => {
            if value <= motor {
                let message = format!("the `{name}` of the actuator is not more than that of its motor");
                section.note(Problem::at(section.span_of(name), message, "nothing is left for the gear"));
            }
            Some(value - motor)
        }
        (_, _, value) => value,
    };
    Gear {
        mass: off("mass", own.mass_covers, own.motor_mass, point.mass),
        length: off("length", own.length_covers, own.motor_length, point.length),
        ..point
    }
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

/// What is said of a family in one line.
pub fn summary(family: &Family) -> String {
    let (first, last) = family.range();
    format!("{} of ratio {} to {}", counted(family.points.len(), "gear"), number(first), number(last))
}
