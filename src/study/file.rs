//! The study file: which requirements, which catalogue, which grid of parameters over them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::Spanned;
use toml::de::DeValue;

use super::grid::{Grid, Parameter};
use crate::catalog::place;
use crate::input::kind::{self, FileKind};
use crate::input::{Change, Description, Form, InputError, Key, Problem, Section, Source, key};
use crate::units;
use crate::words::nearest;

/// What a study file says.
#[derive(Debug, Clone)]
pub struct StudyFile {
    /// The file.
    pub source: Arc<Source>,
    /// Requirement files, folders and patterns, as written.
    pub requirements: Vec<String>,
    /// Catalogue files and folders; the built-in catalogue where there are none.
    pub catalog: Vec<PathBuf>,
    /// The parameters.
    pub grid: Grid,
}

/// Keys that only a study file has.
const OWN_KEYS: [&str; 3] = ["requirement", "requirements", "grid"];

/// Whether a TOML file is a study file: it has a key that no requirement has.
pub fn is_study_file(source: &Source) -> bool {
    let (table, _) = toml::de::DeTable::parse_recoverable(source.text());
    let own = |key: &str| OWN_KEYS.contains(&key);
    let stem = source.name().rsplit('/').next().unwrap_or_default();
    table.get_ref().iter().any(|(key, _)| own(key.get_ref()))
        || (stem == "study.toml" && !table.get_ref().contains_key("joint"))
}

/// Reads a study file.
///
/// # Errors
/// Every mistake of the file. Whether the grid's keys and values fit the requirements is seen only where
/// those are read.
pub fn read(source: &Arc<Source>) -> Result<StudyFile, InputError> {
    Form::read(source, read_root).map_err(|error| kind::instead(error, &[FileKind::Study]))
}

/// The grid of a program: the table `grid` of a study file, in which a bare number is SI; and what it is written in.
///
/// # Errors
/// As [`read`].
pub fn grid_of_values(text: String) -> Result<(Grid, Arc<Source>), InputError> {
    let source = Arc::new(Source::of_values("the grid", text));
    let grid = Form::read(&source, |root| root.section(GRID).and_then(|section| read_grid(&section)))?;
    Ok((grid, source))
}

const REQUIREMENT: Key = key("requirement", "the requirement, next to this file").value("file").or("requirements");
const REQUIREMENTS: Key = key("requirements", "requirement files, folders and patterns such as `robots/*.toml`")
    .value("list of paths")
    .or("requirement");
const CATALOG: Key =
    key("catalog", "files and folders, next to this file").value("list of paths").default("the built-in catalogue");
const GRID: Key =
    key("grid", "the values of each parameter; every combination is computed").default("the requirements as they are");

/// What the reader asks for; the keys of the grid are paths into the requirement.
pub fn describe() -> Description {
    Form::describe("", read_root)
}

fn read_root(root: &Section) -> Option<StudyFile> {
    let source = root.source();
    let one = root.text(REQUIREMENT).map(|t| vec![t.into_inner()]);
    let many = root.texts(REQUIREMENTS).map(|t| t.into_iter().map(Spanned::into_inner).collect());
    let requirements: Option<Vec<String>> = match (one, many) {
        (Some(_), Some(_)) => {
            let span = root.span_of("requirements");
            root.note(Problem::at(span, "a study has `requirement` or `requirements`, not both", "remove one"));
            None
        }
        (None, None) => {
            if !root.has("requirement") && !root.has("requirements") {
                root.missing("requirement", "\"base.toml\", or requirements = [\"robots/*.toml\"]");
            }
            None
        }
        (one, many) => one.or(many),
    };
    let catalog = root.texts(CATALOG).unwrap_or_default();
    let catalog = catalog.into_iter().map(|path| place(source.folder(), &path.into_inner())).collect();
    let grid = root.section(GRID).map_or_else(|| Some(Grid::default()), |section| read_grid(&section));
    Some(StudyFile { source: source.clone(), requirements: requirements?, catalog, grid: grid? })
}

fn read_grid(section: &Section) -> Option<Grid> {
    let mut parameters = Vec::new();
    for (key, value) in section.items() {
        gather(section, key.get_ref(), key.span(), value, &mut parameters);
    }
    match Grid::new(parameters) {
        Ok(grid) => Some(grid),
        Err(message) => {
            section.note(Problem::at(section.span(), message, "this grid"));
            None
        }
    }
}

/// The parameters at a key: one, or those of a table (`bus.voltage` without quotes is one).
fn gather(
    section: &Section,
    key: &str,
    at: std::ops::Range<usize>,
    value: &Spanned<DeValue>,
    parameters: &mut Vec<Parameter>,
) {
    let values: Vec<(String, std::ops::Range<usize>)> = match value.get_ref() {
        DeValue::Array(items) => {
            if items.is_empty() {
                section.note(Problem::at(value.span(), format!("`{key}` of [grid] is empty"), "expected values"));
                return;
            }
            let text = section.source().text();
            items.iter().map(|item| (text[item.span()].to_string(), item.span())).collect()
        }
        DeValue::Table(table) if ["from", "to", "steps"].iter().any(|k| table.contains_key(*k)) => {
            match range(key, value) {
                Ok(values) => values.into_iter().map(|text| (text, value.span())).collect(),
                Err(problem) => return section.note(*problem),
            }
        }
        DeValue::Table(table) => {
            let mut entries: Vec<_> = table.iter().collect();
            entries.sort_by_key(|(key, _)| key.span().start);
            for (inner, value) in entries {
                gather(section, &format!("{key}.{}", inner.get_ref()), inner.span(), value, parameters);
            }
            return;
        }
        other => {
            let problem = Problem::at(
                value.span(),
                format!("`{key}` of [grid] is one {}, not a list of values", other.type_str()),
                "expected a list, or a range",
            );
            let example = "for example [\"24 V\", \"48 V\"], or { from = 0.8, to = 1.2, steps = 5 }";
            return section.note(problem.help(example));
        }
    };
    let scale = key == "scale" || key.starts_with("scale.");
    if scale && !Parameter::SCALES.contains(&key) {
        let problem = Problem::at(at, format!("`{key}` of [grid] is not something to scale"), "not known");
        return section.note(problem.suggest(key, Parameter::SCALES));
    }
    if !scale && !key.contains('.') && key != "name" {
        let what = match nearest(key, Parameter::SCALES.iter().copied().chain(["bus.voltage"])) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "a key is a path as in bus.voltage, joint.knee.gear.efficiency or scale.torque".into(),
        };
        let problem = Problem::at(at, format!("`{key}` of [grid] names no value of a requirement"), "not a path");
        return section.note(problem.help(what));
    }
    for (k, (text, span)) in values.iter().enumerate() {
        if values[..k].iter().any(|(t, _)| t == text) {
            section.note(Problem::at(span.clone(), format!("duplicate `{text}` in `{key}` of [grid]"), "again"));
            return;
        }
        if scale && !text.parse::<f64>().is_ok_and(|v| v.is_finite() && (1e-6..=1e6).contains(&v)) {
            let message = format!("`{key}` of [grid] is a factor");
            section.note(Problem::at(span.clone(), message, "expected a bare number between 1e-6 and 1e6"));
            return;
        }
    }
    let of_values = section.source().is_of_values();
    let change = |(text, span)| {
        let change = Change::new(key, at.clone(), text, span);
        if of_values { change.of_values() } else { change }
    };
    let changes = values.into_iter().map(change).collect();
    parameters.push(Parameter::new(key.to_string(), changes));
}

/// The values of `{ from = …, to = …, steps = n }`, evenly spaced; from and to in the same unit.
fn range(key: &str, value: &Spanned<DeValue>) -> Result<Vec<String>, Box<Problem>> {
    let table = value.get_ref().as_table().expect("a table");
    let fail = |what: &str| {
        Box::new(
            Problem::at(value.span(), format!("`{key}` of [grid]: {what}"), "this range")
                .help("for example { from = \"24 V\", to = \"48 V\", steps = 5 }"),
        )
    };
    for (inner, _) in table.iter() {
        if !["from", "to", "steps"].contains(&inner.get_ref().as_ref()) {
            let problem = Problem::at(inner.span(), format!("unknown key `{}` in a range", inner.get_ref()), "here");
            return Err(Box::new(problem.suggest(inner.get_ref(), ["from", "to", "steps"])));
        }
    }
    let steps = table.get("steps").and_then(|s| s.get_ref().as_integer()?.as_str().parse::<u32>().ok());
    let steps = steps.filter(|s| (2..=100_000).contains(s));
    let steps = steps.ok_or_else(|| fail("`steps` is a whole number from 2 to 100 000"))?;
    let end = |name: &str| -> Option<(f64, String)> {
        match table.get(name)?.get_ref() {
            DeValue::Integer(number) => Some((number.as_str().parse().ok()?, String::new())),
            DeValue::Float(number) => Some((number.as_str().parse().ok()?, String::new())),
            DeValue::String(text) => {
                let (number, unit) = units::apart(text);
                Some((units::number_value(number).ok()?, unit.to_string()))
            }
            _ => None,
        }
    };
    let (from, unit) = end("from").ok_or_else(|| fail("`from` is a number, or a number and a unit"))?;
    let (to, unit_to) = end("to").ok_or_else(|| fail("`to` is a number, or a number and a unit"))?;
    if unit != unit_to {
        return Err(fail("`from` and `to` have different units"));
    }
    if !(from.is_finite() && to.is_finite()) || from == to {
        return Err(fail("`from` and `to` are the same, or not finite"));
    }
    let at = |k: u32| {
        let exact = from + (to - from) * f64::from(k) / f64::from(steps - 1);
        // Twelve digits: 0.9, not 0.8999999999999999.
        let value: f64 = format!("{exact:.11e}").parse().unwrap_or(exact);
        if unit.is_empty() { format!("{value:?}") } else { format!("\"{value} {unit}\"") }
    };
    Ok((0..steps).map(at).collect())
}

/// The path of a file, from where the study file stands.
pub fn beside(source: &Source, path: &str) -> PathBuf {
    source.folder().join(Path::new(path))
}
