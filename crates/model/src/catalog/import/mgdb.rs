//! The Motor-Gearbox Database (github.com/ekrimsk/MGDB, collected for CORDS): a folder for each maker
//! with `*_motors.csv`, `*_gearboxes.csv` and `*_compatibility.csv`, all in SI.
//!
//! Motors are taken as CORDS takes them, as equivalent DC machines; how is in `ASSUMPTIONS`, and
//! what is particular to a row is a remark of it.

mod cells;
mod fits;
mod gear;
mod motor;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use motor::{Friction, Machine, friction, no_load_current};

use super::{FileRead, Holds, Import, Lines, Remark, RemarkKind, Row, folder_error};
use crate::input::csv::{Column, Content, Table};
use crate::input::{InputError, Problem, Source};
use crate::words::{nearest, reason};
use cells::Cells;

/// What is assumed of every row of MGDB.
pub(crate) const ASSUMPTIONS: &[&str] = &[
    "A motor is its equivalent DC machine: torque k_t I, copper loss R I^2, voltage R I + k_t w (k_e w where k_e is \
     given) up to the bus voltage itself. Brushless motors are taken so too (commutation = brushed, terminals = \
     line_to_line, current = dc), so no convention is converted.",
    "I_nom is the continuous current, max_int_torque the peak torque, max_cont_torque the continuous torque, \
     max_int_speed the largest speed, V the voltage of the no-load numbers, Rth1 the thermal resistance from winding to \
     housing, Rth2 from housing to ambient. The winding temperature of R is not said.",
    "An empty cell, NaN and inf are unknown: what is unknown is not checked.",
    "A gear is as efficient when the load drives as when the motor drives.",
    "A gear fits the motors that list it and no other. Direct drive is added as the gear `direct`: ratio 1, no loss, no \
     mass, no inertia; it fits every motor.",
    "The numbers are quoted at second hand (source_kind = secondary); ids are the keys in lower case, with `-` for any \
     character but letters, digits and `.`.",
];

const MOTOR_COLUMNS: &[&str] = &[
    "key",
    "manufacturer",
    "ID",
    "type",
    "V",
    "k_t",
    "k_e",
    "R",
    "L",
    "mass",
    "inertia",
    "diameter",
    "length",
    "omega_nl",
    "I_nl",
    "I_nom",
    "max_int_torque",
    "max_int_speed",
    "max_cont_speed",
    "max_cont_power",
    "coulomb_friction",
    "viscous_friction",
    "Rth1",
    "Rth2",
];
const MOTOR_REQUIRED: &[&str] = &["key", "type", "k_t", "R"];

const GEAR_COLUMNS: &[&str] = &[
    "key",
    "manufacturer",
    "ID",
    "type",
    "stages",
    "ratio",
    "mass",
    "inertia",
    "efficiency",
    "direction",
    "max_int_torque",
    "max_cont_torque",
];
const GEAR_REQUIRED: &[&str] = &["key", "type", "ratio"];

/// How the name of a file ends, and what it then holds.
const ENDINGS: &[(&str, Holds)] =
    &[("motors.csv", Holds::Motors), ("gearboxes.csv", Holds::Gears), ("compatibility.csv", Holds::Compatibility)];

/// Reads the folder and the folders in it.
///
/// # Errors
/// There is no such folder, it holds no file of the database, a file cannot be read or its header
/// lacks a column, or no row of it can be taken.
pub fn read(folder: &Path) -> Result<Import, Vec<InputError>> {
    let (files, others) = find(folder).map_err(|problem| vec![folder_error(folder, problem)])?;
    let mut reader = Reader::default();
    let mut errors = Vec::new();
    let mut compatibility = Vec::new();
    for (path, holds) in files {
        let source = match Source::read(&path) {
            Ok(source) => source,
            Err(error) => {
                errors.push(error);
                continue;
            }
        };
        match holds {
            // Read last: it speaks of motors and gears of every file.
            Holds::Compatibility => compatibility.push(source),
            Holds::Motors | Holds::Gears => errors.extend(reader.table(&source, holds).err()),
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let mut import = reader.import;
    if import.motors.is_empty() && import.gears.is_empty() {
        let first = import.remarks_of(RemarkKind::Refused).next();
        let first = first.map_or_else(String::new, |r| format!("{}:{}: {}", r.place.file, r.place.line, r.message));
        let problem = Problem::whole("no row of this database can be taken");
        return Err(vec![folder_error(folder, if first.is_empty() { problem } else { problem.help(first) })]);
    }
    fits::apply(&mut import, &reader.refused, &compatibility);
    if !import.motors.is_empty() {
        import.gears.push(gear::direct());
    }
    for path in others {
        let place = super::Place { file: path.display().to_string(), line: 1, column: 1 };
        let message = "not read: its name ends in none of motors.csv, gearboxes.csv, compatibility.csv".into();
        import.remarks.push(Remark {
            kind: RemarkKind::LeftOut,
            code: "file-not-read",
            place,
            key: String::new(),
            message,
        });
    }
    import.remarks.sort_by(|a, b| (&a.place.file, a.place.line).cmp(&(&b.place.file, b.place.line)));
    Ok(import)
}

type Found = (Vec<(PathBuf, Holds)>, Vec<PathBuf>);

/// The database's files in the folder and one level below, sorted, and other CSV files.
fn find(folder: &Path) -> Result<Found, Problem> {
    let list = |folder: &Path| -> Result<Vec<PathBuf>, Problem> {
        let cannot = |e: std::io::Error| match e.kind() {
            std::io::ErrorKind::NotFound => Problem::whole("there is no such folder"),
            std::io::ErrorKind::NotADirectory => Problem::whole("this is a file, not a folder"),
            _ => Problem::whole(format!("cannot read the folder `{}`: {}", folder.display(), reason(&e))),
        };
        let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(cannot)?.collect();
        let mut paths: Vec<PathBuf> = entries.map_err(cannot)?.into_iter().map(|e| e.path()).collect();
        paths.sort();
        Ok(paths)
    };
    let mut paths = Vec::new();
    for path in list(folder)? {
        if path.is_dir() { paths.extend(list(&path)?) } else { paths.push(path) }
    }
    let (mut files, mut others) = (Vec::new(), Vec::new());
    for path in paths.into_iter().filter(|p| p.is_file()) {
        let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().to_lowercase());
        match ENDINGS.iter().find(|(ending, _)| name.ends_with(ending)) {
            Some((_, holds)) => files.push((path, *holds)),
            None if name.ends_with(".csv") => others.push(path),
            None => {}
        }
    }
    if !files.iter().any(|(_, holds)| *holds != Holds::Compatibility) {
        return Err(Problem::whole("there is no file of the Motor-Gearbox Database in this folder").help(
            "expected *_motors.csv and *_gearboxes.csv here or one level below, as in a clone of \
             github.com/ekrimsk/MGDB",
        ));
    }
    Ok((files, others))
}

/// What has been read so far.
struct Reader {
    import: Import,
    motor_ids: Ids,
    gear_ids: Ids,
    refused: Refused,
}

/// Keys of rows that were refused: a compatibility entry may still name them.
#[derive(Debug, Default)]
struct Refused {
    motors: HashSet<String>,
    gears: HashSet<String>,
}

impl Default for Reader {
    fn default() -> Reader {
        let import = Import {
            database: "MGDB",
            licence: "The database carries no licence: for your own use.",
            files: Vec::new(),
            motors: Vec::new(),
            gears: Vec::new(),
            compatible_pairs: 0,
            assumptions: ASSUMPTIONS.to_vec(),
            remarks: Vec::new(),
        };
        let refused = Refused::default();
        Reader { import, motor_ids: Ids::new(fits::NONE), gear_ids: Ids::new(gear::DIRECT), refused }
    }
}

impl Reader {
    /// Reads a file of motors or gears: every row is taken or refused.
    fn table(&mut self, source: &Arc<Source>, holds: Holds) -> Result<(), InputError> {
        let lines = Lines::new(source);
        let (known, required) = match holds {
            Holds::Motors => (MOTOR_COLUMNS, MOTOR_REQUIRED),
            _ => (GEAR_COLUMNS, GEAR_REQUIRED),
        };
        let column =
            |name: &str| Column { name: name.to_string(), content: Content::Text, required: required.contains(&name) };
        let mut columns: Vec<Column> = known.iter().map(|name| column(name)).collect();
        for name in header(source).into_iter().filter(|name| !known.contains(&name.as_str())) {
            let help = nearest(&name, known.iter().copied().filter(|_| !name.is_empty()))
                .map_or_else(String::new, |n| format!("; is it `{n}`?"));
            self.import.remarks.push(Remark {
                kind: RemarkKind::LeftOut,
                code: "unknown-column",
                place: lines.place(source.text().find(&name).unwrap_or(0)),
                key: String::new(),
                message: format!("column `{name}` is not one of the database's and was left out{help}"),
            });
            columns.push(column(&name));
        }
        let mut problems = Vec::new();
        let Some(table) = Table::read(source, columns, &mut problems) else {
            return InputError::unless_empty(source, problems);
        };
        // What is left are rows with too many cells or too few, and a file without rows, at no text.
        let ragged = problems.iter().filter(|p| p.span.as_ref().is_some_and(|s| !s.is_empty())).count();
        for problem in problems {
            self.import.remarks.push(lines.refused("unreadable-row", "", &[problem]));
        }
        let mut file = FileRead { file: source.name().to_string(), holds, rows: table.len() + ragged, taken: 0 };
        for row in 0..table.len() {
            let cells = Cells::new(&table, row, &lines);
            let taken = match holds {
                Holds::Motors => self.motor(cells, source),
                _ => self.gear(cells, source),
            };
            file.taken += usize::from(taken);
        }
        self.import.files.push(file);
        Ok(())
    }

    fn motor(&mut self, mut cells: Cells, source: &Source) -> bool {
        let key = cells.key(&self.motor_ids);
        let sheet = motor::read(&mut cells, &key, source);
        match (sheet, cells.finish(&mut self.import.remarks, &key)) {
            (Some(mut item), true) => {
                let place = cells.place();
                item.id = self.motor_ids.give(&key, &place, &mut self.import.remarks);
                self.import.motors.push(Row { key, place: Some(place), item });
                true
            }
            _ => {
                self.refused.motors.insert(key);
                false
            }
        }
    }

    fn gear(&mut self, mut cells: Cells, source: &Source) -> bool {
        let key = cells.key(&self.gear_ids);
        let gear = gear::read(&mut cells, &key, source);
        match (gear, cells.finish(&mut self.import.remarks, &key)) {
            (Some(mut item), true) => {
                let place = cells.place();
                item.id = self.gear_ids.give(&key, &place, &mut self.import.remarks);
                self.import.gears.push(Row { key, place: Some(place), item });
                true
            }
            _ => {
                self.refused.gears.insert(key);
                false
            }
        }
    }
}

/// The names in the header of a file, without blank ones.
fn header(source: &Source) -> Vec<String> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(source.text().as_bytes());
    let first = reader.records().next().and_then(Result::ok);
    let name = |cell: &str| cell.split('[').next().unwrap_or("").trim().to_string();
    first.map_or_else(Vec::new, |record| record.iter().map(name).collect())
}

/// Keys of one kind of row and the ids they were given.
#[derive(Debug)]
struct Ids {
    by_key: HashMap<String, super::Place>,
    given: HashSet<String>,
}

impl Ids {
    fn new(reserved: &str) -> Ids {
        Ids { by_key: HashMap::new(), given: HashSet::from([reserved.to_string()]) }
    }

    /// An id for a key: `mm-574741` for `MM_574741`; numbered where two keys would share one.
    fn give(&mut self, key: &str, place: &super::Place, remarks: &mut Vec<Remark>) -> String {
        let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '.';
        let plain = key.to_lowercase().replace(|c| !good(c), "-");
        let plain = match plain.trim_matches('-') {
            "" => "row",
            id => id,
        };
        let mut id = plain.to_string();
        let mut number = 2;
        while !self.given.insert(id.clone()) {
            id = format!("{plain}-{number}");
            number += 1;
        }
        if id != plain {
            remarks.push(Remark {
                kind: RemarkKind::Assumed,
                code: "id-numbered",
                place: place.clone(),
                key: key.to_string(),
                message: format!("the id is `{id}`: `{plain}` is that of another row"),
            });
        }
        self.by_key.insert(key.to_string(), place.clone());
        id
    }
}
