//! Rows put into a catalogue file that somebody keeps: what stands in it stays as it is, byte for byte; rows come behind
//! it, columns that it lacks at the end of its header.
//!
//! The one idea: what is added is text. A cell goes under the column of the same name that states the same, in that column's
//! unit; the ordinary reader then says whether the file is still one.

use std::sync::Arc;

use super::module::Module;
use super::row::{MotorRow, Row, column_of};
use super::{Catalog, Gear, read};
use crate::input::csv::find_cell;
use crate::input::{InputError, Problem, Source, Words};
use crate::units::{self, Kind};
use crate::words::csv::csv_text;

/// Rows of one kind, as a table of texts.
#[derive(Debug, Clone, PartialEq)]
struct Sheet {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// A head of a column: its name as the program calls it, and what stands in brackets.
fn head(cell: &str) -> (String, String) {
    let (name, brackets) = cell.split_once('[').unwrap_or((cell, ""));
    let name = name.trim().trim_start_matches('\'');
    let name = column_of(name).unwrap_or(name);
    (name.to_string(), brackets.trim().trim_end_matches(']').trim().to_string())
}

/// What a column measures and which words it may state; `None` of one that holds no number with a unit.
fn measure<R: Row>(name: &str) -> Option<(&'static Kind, Words)> {
    let of = |field: &'static super::Field<R::Numbers>| {
        let own = field.name == name;
        let tolerance = field.tolerance == Some(name);
        (own || tolerance).then_some((field.kind, if own { field.states.words() } else { Words::NONE }))
    };
    R::fields().iter().find_map(of)
}

/// A number in another unit, in the digits that its own has.
fn converted(cell: &str, kind: &'static Kind, from: &str, to: &str, is_tolerance: bool) -> Option<String> {
    let value = units::number_value(cell).ok()?;
    let (from, to) = (units::unit_of(from, kind).ok()?, units::unit_of(to, kind).ok()?);
    let zero = to.to_si(0.0, kind);
    let converted = match is_tolerance {
        true => value * from.scale() / to.scale(),
        false => (from.to_si(value, kind) - zero) / (to.to_si(1.0, kind) - zero),
    };
    // What rounding left in the last digit goes.
    format!("{converted:.13e}").parse::<f64>().ok().map(|v| v.to_string())
}

impl Sheet {
    fn of(text: &str) -> Sheet {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .from_reader(text.as_bytes());
        let mut rows: Vec<Vec<String>> =
            reader.records().map_while(Result::ok).map(|r| r.iter().map(str::to_string).collect()).collect();
        let header = if rows.is_empty() { Vec::new() } else { rows.remove(0) };
        Sheet { header, rows }
    }

    /// The rows of another table in the columns of this one, and the columns that it lacks.
    fn taken<R: Row>(&self, other: &Sheet) -> Result<(Vec<String>, Vec<Vec<String>>), String> {
        let mut header = self.header.clone();
        let mut rows = vec![vec![String::new(); header.len()]; other.rows.len()];
        for (place, cell) in other.header.iter().enumerate() {
            let (name, brackets) = head(cell);
            let measured = measure::<R>(&name);
            let split = |brackets: &str| match measured {
                Some((_, words)) => words.split(brackets).map(|(unit, stated)| (unit.to_string(), stated)),
                None => Ok((brackets.to_string(), crate::input::Stated::default())),
            };
            let (unit, stated) = split(&brackets)?;
            let filled = |row: &Vec<String>| row.get(place).is_some_and(|c| !c.is_empty());
            if !other.rows.iter().any(filled) {
                continue;
            }
            let same = |there: &&(usize, String, String)| {
                there.1 == name && split(&there.2).is_ok_and(|(_, there)| there == stated)
            };
            let heads = header.iter().enumerate().map(|(k, cell)| {
                let (name, brackets) = head(cell);
                (k, name, brackets)
            });
            let heads: Vec<(usize, String, String)> = heads.collect();
            let (column, to) = match heads.iter().find(same) {
                Some((column, _, there)) => (*column, split(there)?.0),
                None => {
                    header.push(cell.clone());
                    rows.iter_mut().for_each(|row| row.push(String::new()));
                    (header.len() - 1, unit.clone())
                }
            };
            for (row, from) in rows.iter_mut().zip(&other.rows) {
                let Some(text) = from.get(place).filter(|c| !c.is_empty()) else { continue };
                row[column] = match measured {
                    Some((kind, _)) if unit != to => converted(text, kind, &unit, &to, name.ends_with("_tolerance"))
                        .ok_or_else(|| {
                            format!("`{name}` is in `{to}` in the file and in `{unit}` in the new row: use one of them")
                        })?,
                    _ => text.clone(),
                };
            }
        }
        Ok((header, rows))
    }
}

/// Where a record ends: before its line end, quotes respected.
fn end_of_record(text: &str, start: usize) -> usize {
    let mut quoted = false;
    for (at, byte) in text.bytes().enumerate().skip(start) {
        match byte {
            b'"' => quoted = !quoted,
            b'\n' | b'\r' if !quoted => return at,
            _ => {}
        }
    }
    text.len()
}

/// Where the records of a table begin: comments and blank lines are none.
fn records(text: &str) -> Vec<usize> {
    let (mut at, mut found) = (0, Vec::new());
    while at < text.len() {
        let end = match text.as_bytes()[at] {
            b'\n' | b'\r' => {
                at += 1;
                continue;
            }
            b'#' => text[at..].find('\n').map_or(text.len(), |p| at + p),
            _ => {
                found.push(at);
                end_of_record(text, at)
            }
        };
        at = end;
    }
    found
}

/// The text of a catalogue file with rows behind it; `None` where there is no file yet.
fn text_with<R: Row>(there: Option<&str>, new: &Sheet) -> Result<String, String> {
    let lines = |rows: Vec<Vec<String>>, end: &str| {
        let mut rows = rows.into_iter();
        let first = rows.next().unwrap_or_default();
        let first: Vec<&str> = first.iter().map(String::as_str).collect();
        csv_text(&first, rows).replace('\n', end)
    };
    let Some(text) = there.filter(|text| !records(text).is_empty()) else {
        let blank = Sheet { header: Vec::new(), rows: Vec::new() };
        let (header, rows) = blank.taken::<R>(new)?;
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        return Ok(format!("# gearwise catalogue {}\n{}", read::VERSION, csv_text(&header, rows)));
    };
    let sheet = Sheet::of(text);
    let (header, rows) = sheet.taken::<R>(new)?;
    let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    let more = &header[sheet.header.len()..];
    let mut out = String::with_capacity(text.len() + 256);
    let mut from = 0;
    for (place, start) in records(text).into_iter().enumerate() {
        let stop = end_of_record(text, start);
        out.push_str(&text[from..stop]);
        let blank = vec![String::new(); more.len()];
        let cells = if place == 0 { more } else { &blank };
        cells.iter().for_each(|cell| out.push_str(&format!(",{cell}")));
        from = stop;
    }
    out.push_str(&text[from..]);
    if !out.ends_with('\n') {
        out.push_str(end);
    }
    Ok(out + &lines(rows, end))
}

/// Whether the rows of a file can be put into another one.
///
/// # Errors
/// Mistakes of the file, and rows that cannot.
pub fn can_be_added(source: &Arc<Source>) -> Result<(), InputError> {
    tables(source).map(drop)
}

/// A file with rows, as the tables of its motors and of its gears.
fn tables(source: &Arc<Source>) -> Result<[Option<Sheet>; 3], InputError> {
    let rows = read::read_rows(source)?;
    let is_toml = super::fitted::is_fitted_file(source);
    let made = rows.motors.iter().find(|motor| motor.fit.is_some());
    if let Some(motor) = made {
        let message = format!("`{}` is a fitted actuator, which a table of CSV cannot hold", motor.id);
        let problem = Problem::whole(message).help("keep its file, and name it with `--also`");
        return Err(InputError { source: source.clone(), problems: vec![problem] });
    }
    if !rows.alternatives.is_empty() {
        let problem = Problem::whole("these are alternatives, which say something of rows and are none");
        let help = "name the file with `--also`, or put it into the folder `alternatives` of your catalogue";
        return Err(InputError { source: source.clone(), problems: vec![problem.help(help)] });
    }
    if let Some(family) = rows.families.first() {
        let problem = Problem::whole(format!("`{}` is a gear family, which is no row of a table", family.name));
        let help = "name the file with `--also`, or put it into the folder `gear_families` of your catalogue";
        return Err(InputError { source: source.clone(), problems: vec![problem.help(help)] });
    }
    let motors: Vec<MotorRow> = rows.motors.iter().map(MotorRow::of).collect();
    let some = [!rows.motors.is_empty(), !rows.gears.is_empty(), !rows.modules.is_empty()];
    if is_toml {
        let texts = [
            super::row::csv_text(&motors, &[]),
            super::row::csv_text(&rows.gears, &[]),
            super::row::csv_text(&rows.modules, &[]),
        ];
        let mut texts = texts.iter().zip(some).map(|(text, some)| some.then(|| Sheet::of(text)));
        return Ok(std::array::from_fn(|_| texts.next().flatten()));
    }
    // A table of CSV holds one kind of rows; one without rows is of motors or of gears.
    let first = some.iter().position(|some| *some).unwrap_or(1);
    Ok(std::array::from_fn(|k| (k == first).then(|| Sheet::of(source.text()))))
}

/// A file that rows are put into.
#[derive(Debug)]
pub struct Target {
    /// What it is called in messages.
    pub name: String,
    /// What stands in it; `None` where it is made.
    pub there: Option<Arc<Source>>,
}

/// Which rows a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Of {
    /// Motors.
    Motors,
    /// Gears.
    Gears,
    /// Modules.
    Modules,
}

impl Of {
    /// All, in the order in which they are added.
    pub const ALL: [Of; 3] = [Of::Motors, Of::Gears, Of::Modules];

    /// Its word, which is its folder too.
    pub fn word(self) -> &'static str {
        match self {
            Of::Motors => "motors",
            Of::Gears => "gears",
            Of::Modules => "modules",
        }
    }
}

/// Whether a file has rows of a kind.
///
/// # Errors
/// Every mistake of the file.
pub fn has(source: &Arc<Source>, of: Of) -> Result<bool, InputError> {
    let rows = read::read_rows(source)?;
    Ok(match of {
        Of::Motors => !rows.motors.is_empty(),
        Of::Gears => !rows.gears.is_empty(),
        Of::Modules => !rows.modules.is_empty(),
    })
}

/// The text of a file with the rows of one kind of other files behind it, and their ids. What comes out has been read again:
/// every row that was there is there, and so is every new one.
///
/// # Errors
/// Mistakes of the files, rows of an id that is there already, rows that do not go into the file.
pub fn added(target: &Target, from: &[Arc<Source>], of: Of) -> Result<(String, Vec<String>), Vec<InputError>> {
    let before = match &target.there {
        Some(source) if !records(source.text()).is_empty() => read::read_rows(source).map_err(|e| vec![e])?,
        _ => read::Rows::default(),
    };
    let ids = |rows: &read::Rows| -> Vec<String> {
        match of {
            Of::Motors => rows.motors.iter().map(|m| m.id.clone()).collect(),
            Of::Gears => rows.gears.iter().map(|g| g.id.clone()).collect(),
            Of::Modules => rows.modules.iter().map(|m| m.id.clone()).collect(),
        }
    };
    let mut text = target.there.as_ref().map(|source| source.text().to_string());
    let (mut all, mut new, mut errors) = (ids(&before), Vec::new(), Vec::new());
    for source in from {
        let fail = |message: String| InputError { source: source.clone(), problems: vec![Problem::whole(message)] };
        let (rows, tables) = match (read::read_rows(source), tables(source)) {
            (Ok(rows), Ok(tables)) => (rows, tables),
            (Err(error), _) | (_, Err(error)) => {
                errors.push(error);
                continue;
            }
        };
        let twice: Vec<Problem> =
            ids(&rows).iter().filter(|id| all.contains(id)).map(|id| there_already(source, id, &target.name)).collect();
        if !twice.is_empty() {
            errors.push(InputError { source: source.clone(), problems: twice });
            continue;
        }
        let Some(sheet) = tables.into_iter().nth(of as usize).flatten() else { continue };
        let made = match of {
            Of::Motors => text_with::<MotorRow>(text.as_deref(), &sheet),
            Of::Gears => text_with::<Gear>(text.as_deref(), &sheet),
            Of::Modules => text_with::<Module>(text.as_deref(), &sheet),
        };
        match made {
            Ok(made) => text = Some(made),
            Err(why) => errors.push(fail(format!("its rows do not go into {}: {why}", target.name))),
        }
        all.extend(ids(&rows));
        new.extend(ids(&rows));
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let text = text.unwrap_or_default();
    let after = Arc::new(Source::new(target.name.clone(), text.clone()));
    let rows = read::read_rows(&after).map_err(|e| vec![e])?;
    if ids(&rows) != all {
        let problem = Problem::whole("the file would not be read back with every row; nothing was written");
        return Err(vec![InputError { source: after, problems: vec![problem] }]);
    }
    Ok((text, new))
}

fn there_already(source: &Source, id: &str, name: &str) -> Problem {
    let text = source.text();
    let cell = records(text).into_iter().map(|start| find_cell(text, start, 0)).find(|span| text[span.clone()] == *id);
    let message = format!("the id `{id}` is already in {name}");
    let problem = match cell {
        Some(span) => Problem::at(span, message, "this row"),
        None => Problem::whole(message),
    };
    problem.help("give the row another id; a row that is there is not replaced")
}

/// The rows of files alone, for the audit before they are added.
///
/// # Errors
/// All mistakes of all files.
pub fn rows(from: &[Arc<Source>]) -> Result<Catalog, Vec<InputError>> {
    Catalog::from_sources(from.to_vec())
}
