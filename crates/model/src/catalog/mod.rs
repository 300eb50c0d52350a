//! Motors and gears: what their data sheets say, in which convention, and whether it adds up.
//!
//! The one idea of this room: a row *says* what its numbers mean, and the reader converts them once
//! to the power-invariant q-axis equivalent (see [`convention`]); everything behind computes with
//! that alone, and [`audit`] goes back to the printed numbers.

mod about;
pub mod add;
pub mod against;
pub mod alternative;
pub mod audit;
pub mod convention;
pub mod difference;
pub mod drag;
pub mod estimate;
pub mod family;
pub mod filter;
mod finding;
mod fit;
pub mod fitted;
mod free;
mod gear;
pub mod import;
pub mod module;
mod motor;
pub mod offer;
pub mod outlier;
mod read;
pub mod rewound;
pub mod row;
mod said;
mod sheet;
mod twins;
mod wrong;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use about::{About, Construction, PeakTorqueOf};
pub use alternative::Alternative;
pub use family::Family;
pub use fitted::{Fit, Provenance, read_fitted};
pub use gear::{
    ContinuousTorque, GEAR_FIELDS, Gear, GearField, GearKind, GearRatings, LifeQuantile, Rated, is_named,
    matches_pattern, no_load_friction,
};
pub use module::Module;
pub use motor::{Identity, Incomplete, Motor, REFERENCE_TEMPERATURE, Wound};
pub use offer::{Currency, Date, Offer, Price, Sold};
pub use read::{VERSION, gear_columns, module_columns, motor_columns, read_gears, read_modules, read_motors};
pub use row::Field;
pub use sheet::{Conventions, FIELDS, OwnConventions, Printed, Sheet, SourceKind, across};

use gearwise_catalogs::FILES as BUILTIN;

use crate::input::{InputError, InputFile, Problem, Source, limits, sha256};

/// Motors and gears to choose from, each sorted by id.
#[derive(Debug, Clone, Default)]
pub struct Catalog {
    /// The motors.
    pub motors: Vec<Motor>,
    /// The gears.
    pub gears: Vec<Gear>,
    /// Families of gears, whose points are no gears that one can buy: a joint names the families that it may have.
    pub families: Vec<Family>,
    /// The modules.
    pub modules: Vec<Module>,
    /// What other sources say of numbers of rows, by id and column.
    pub alternatives: Vec<Alternative>,
    /// Rows that are no free choice and can be named: see [`Catalog::free`].
    pub aside: Vec<Motor>,
    origin: Origin,
}

/// Where the rows of a catalogue come from.
#[derive(Debug, Clone, Default)]
enum Origin {
    /// Made by a program.
    #[default]
    Made,
    /// Built into this program.
    Builtin,
    /// Files.
    Files(Vec<Arc<Source>>),
}

impl Catalog {
    /// A catalogue of rows at hand.
    pub fn of(motors: Vec<Motor>, gears: Vec<Gear>) -> Catalog {
        Catalog { motors, gears, ..Catalog::default() }
    }

    /// The catalogue that is built into the program.
    ///
    /// # Errors
    /// If a shipped file has a mistake; a test makes sure that none has.
    pub fn builtin() -> Result<Catalog, Vec<InputError>> {
        let catalog = Catalog::from_sources(Catalog::builtin_sources())?;
        Ok(Catalog { origin: Origin::Builtin, ..catalog })
    }

    /// The files that it was read from, each with its hash; nothing where a program made it.
    pub fn files(&self) -> Vec<InputFile> {
        match &self.origin {
            Origin::Made => Vec::new(),
            Origin::Builtin => {
                let pieces = BUILTIN.iter().flat_map(|(name, text)| [name.as_bytes(), text.as_bytes()]);
                vec![InputFile { name: "the built-in catalogue".into(), sha256: sha256(pieces) }]
            }
            Origin::Files(sources) => sources.iter().map(|source| source.file()).collect(),
        }
    }

    /// The files that are built into the program.
    pub fn builtin_sources() -> Vec<Arc<Source>> {
        BUILTIN.iter().map(|(name, text)| Arc::new(Source::new(*name, *text))).collect()
    }

    /// Reads files and the `*.csv` files in folders (one level, and `motors`, `gears`… below; of `gear_families` the `*.toml`). The words `builtin` and `user`
    /// are the built-in catalogue and the user's own ([`user_catalog`]); a file of such a name is `./builtin`.
    ///
    /// # Errors
    /// All mistakes of all files.
    pub fn read(paths: &[PathBuf]) -> Result<Catalog, Vec<InputError>> {
        let (sources, mut errors) = match Catalog::sources(paths) {
            Ok(sources) => (sources, Vec::new()),
            Err((sources, errors)) => (sources, errors),
        };
        match Catalog::from_sources(sources) {
            Ok(catalog) if errors.is_empty() => Ok(catalog),
            Ok(_) => Err(errors),
            Err(more) => {
                errors.extend(more);
                Err(errors)
            }
        }
    }

    /// The files that [`Catalog::read`] reads.
    ///
    /// # Errors
    /// What could not be read, beside what could.
    #[expect(clippy::type_complexity, reason = "what was read, and what was not")]
    pub fn sources(paths: &[PathBuf]) -> Result<Vec<Arc<Source>>, (Vec<Arc<Source>>, Vec<InputError>)> {
        let mut files = Vec::new();
        let mut errors = Vec::new();
        let mut sources = Vec::new();
        for path in paths {
            if path.as_os_str() == BUILTIN_WORD {
                sources.extend(Catalog::builtin_sources());
                continue;
            }
            let path = &if path.as_os_str() == USER_WORD { user_catalog() } else { path.clone() };
            if path.is_dir() {
                let found = catalog_files(path);
                if found.is_empty() {
                    let source = Arc::new(Source::new(path.display().to_string(), ""));
                    errors.push(InputError {
                        source,
                        problems: vec![Problem::whole(
                            "there is no .csv file in this folder, nor a gear family in its folder `gear_families`",
                        )],
                    });
                }
                files.extend(found);
            } else {
                files.push(path.clone());
            }
        }
        for file in files {
            match Source::argument(&file) {
                Ok(source) => sources.push(source),
                Err(error) => errors.push(error),
            }
        }
        if errors.is_empty() { Ok(sources) } else { Err((sources, errors)) }
    }

    /// Reads catalogue texts; whether a table holds motors or gears is seen from its header. A name that ends in `.toml` is
    /// a fitted actuator, or a catalogue with lists of tables `[[motor]]`, `[[gear]]`.
    ///
    /// # Errors
    /// All mistakes of all files, and ids that stand in two files.
    pub fn from_sources(sources: Vec<Arc<Source>>) -> Result<Catalog, Vec<InputError>> {
        let mut catalog = Catalog::default();
        let mut errors = Vec::new();
        let mut written = Vec::new();
        let mut motor_homes: HashMap<String, String> = HashMap::new();
        let mut gear_homes: HashMap<String, String> = HashMap::new();
        for source in &sources {
            let mut twice = |homes: &mut HashMap<String, String>, id: &str| {
                if let Some(first) = homes.insert(id.to_string(), source.name().to_string()) {
                    let at = source.text().find(id).unwrap_or(0);
                    let problem = Problem::at(
                        at..at + id.len(),
                        format!("the id `{id}` is in two files"),
                        format!("first in {first}"),
                    );
                    errors.push(InputError { source: source.clone(), problems: vec![problem] });
                }
            };
            match read::read_rows(source) {
                Ok(rows) => {
                    rows.motors.iter().for_each(|m| twice(&mut motor_homes, &m.id));
                    rows.gears.iter().for_each(|g| twice(&mut gear_homes, &g.id));
                    let points = rows.families.iter().flat_map(|family| &family.points);
                    points.for_each(|point| twice(&mut gear_homes, &point.id));
                    rows.families.iter().for_each(|family| twice(&mut gear_homes, &family.name));
                    // A module stands beside motors in answers.
                    rows.modules.iter().for_each(|m| twice(&mut motor_homes, &m.id));
                    catalog.motors.extend(rows.motors);
                    catalog.gears.extend(rows.gears);
                    catalog.families.extend(rows.families);
                    catalog.modules.extend(rows.modules);
                    written.push((source.clone(), rows.alternatives));
                }
                Err(error) => errors.push(error),
            }
        }
        errors.extend(sources.iter().flat_map(|source| wrong_twins(source, &catalog.motors)));
        errors.extend(sources.iter().flat_map(|source| wrong_insides(source, &catalog)));
        // Without all rows, an alternative may seem to be of none.
        if errors.is_empty() {
            match alternative::written::resolve(written, &catalog) {
                Ok(alternatives) => catalog.alternatives = alternatives,
                Err(more) => errors.extend(more),
            }
        }
        if !errors.is_empty() {
            return Err(errors);
        }
        catalog.motors.sort_by(|a, b| a.id.cmp(&b.id));
        catalog.gears.sort_by(|a, b| a.id.cmp(&b.id));
        catalog.families.sort_by(|a, b| a.name.cmp(&b.name));
        catalog.modules.sort_by(|a, b| a.id.cmp(&b.id));
        catalog.origin = Origin::Files(sources);
        Ok(catalog)
    }

    /// Up to three motors whose id or model has a text in it, or are near it, for whoever wrote another id.
    pub fn near(&self, text: &str) -> Vec<&str> {
        let plain = |text: &str| text.to_lowercase().replace(|c: char| !c.is_alphanumeric(), "");
        let wanted = plain(text);
        let has =
            |m: &&Motor| !wanted.is_empty() && (plain(&m.id).contains(&wanted) || plain(&m.model).contains(&wanted));
        let all = || self.motors.iter().chain(&self.aside);
        let found: Vec<&str> = all().filter(has).take(3).map(|m| m.id.as_str()).collect();
        match found.is_empty() {
            true => crate::words::nearest(text, all().map(|m| m.id.as_str())).into_iter().collect(),
            false => found,
        }
    }

    /// The gear of a name that is on a motor; that of a module is its own.
    pub fn gear_of<'c>(&'c self, motor: &'c Motor, id: &str) -> Option<&'c Gear> {
        match motor.inside.as_deref() {
            Some(inside) => Some(&inside.gear),
            None => self.gear(id),
        }
    }

    /// The motor with this id, or the nearest id that exists.
    ///
    /// # Errors
    /// The nearest id, if one is near.
    pub fn motor(&self, id: &str) -> Result<&Motor, Option<&str>> {
        self.motors
            .iter()
            .chain(&self.aside)
            .find(|m| m.id == id)
            .ok_or_else(|| crate::words::nearest(id, self.motors.iter().map(|m| m.id.as_str())))
    }
}

/// The word for the built-in catalogue among paths.
pub const BUILTIN_WORD: &str = "builtin";

/// The word for the user's own catalogue among paths.
pub const USER_WORD: &str = "user";

/// Whether a path is one of these words.
pub fn is_word(path: &str) -> bool {
    [BUILTIN_WORD, USER_WORD].contains(&path)
}

/// Where a file or folder of a catalogue is that a file names which stands in a folder; a word stays one.
pub fn place(folder: &Path, named: &str) -> PathBuf {
    if is_word(named) { named.into() } else { folder.join(named) }
}

/// Where the user's own catalogue is: `$GEARWISE_CATALOG`, else the folder `gearwise` in the system's configuration directory.
/// It is never read unless it is named.
pub fn user_catalog() -> PathBuf {
    let of = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let home = |below: &str| of("HOME").map(|home| home.join(below));
    let configuration = match std::env::consts::OS {
        "windows" => of("APPDATA"),
        "macos" => home("Library/Application Support"),
        _ => of("XDG_CONFIG_HOME").or_else(|| home(".config")),
    };
    of("GEARWISE_CATALOG").or(configuration.map(|c| c.join("gearwise"))).unwrap_or_else(|| "gearwise".into())
}

/// Rows of a file that are said to be the same motor as one that is itself the same as another: neither would count.
fn wrong_twins(source: &Arc<Source>, motors: &[Motor]) -> Option<InputError> {
    let mut same_as: HashMap<&str, &str> = HashMap::new();
    for motor in motors.iter().filter(|m| !m.id.is_empty()) {
        same_as.entry(&motor.id).or_insert(&motor.about.same_as);
    }
    let is_wrong = |m: &&Motor| same_as.get(m.about.same_as.as_str()).is_some_and(|other| !other.is_empty());
    let wrong: Vec<&Motor> = motors.iter().filter(is_wrong).take(limits::PROBLEMS).collect();
    let places = places(source, wrong.iter().map(|m| m.id.as_str()));
    let problem = |motor: &&Motor| {
        // Each is reported where its own row is.
        let at = *places.get(motor.id.as_str())?;
        let message =
            format!("`{}` is `same_as` `{}`, which is itself `same_as` another row", motor.id, motor.about.same_as);
        let problem = Problem::at(at..at + motor.id.len(), message, "this row");
        Some(problem.help("name the one row that counts; that row has no `same_as`"))
    };
    let problems: Vec<Problem> = wrong.iter().filter_map(problem).collect();
    (!problems.is_empty()).then(|| InputError { source: source.clone(), problems })
}

/// What a module's ratio may differ from that of the gear that it names.
const SAME_RATIO: f64 = 0.01;

/// Positions of the cells that hold these ids, found in one pass over the file; the first cell of a row takes precedence.
fn places<'i>(source: &Source, ids: impl Iterator<Item = &'i str>) -> HashMap<&'i str, usize> {
    let ids: HashSet<&str> = ids.collect();
    let (mut first, mut others, mut at, mut is_first) = (HashMap::new(), HashMap::new(), 0, true);
    if ids.is_empty() {
        return first;
    }
    for cell in source.text().split_inclusive([',', '\n']) {
        let id = cell.trim_end_matches(',').trim().trim_matches('"');
        if let Some(id) = ids.get(id) {
            let places = if is_first { &mut first } else { &mut others };
            places.entry(*id).or_insert(at + cell.find(*id).unwrap_or(0));
        }
        is_first = cell.ends_with('\n');
        at += cell.len();
    }
    others.extend(first);
    others
}

/// Modules that name a motor or a gear that is none, or a gear of another ratio.
fn wrong_insides(source: &Arc<Source>, catalog: &Catalog) -> Option<InputError> {
    let mut problems = Vec::new();
    let places = places(source, catalog.modules.iter().map(|m| m.id.as_str()));
    let motors: HashSet<&str> = catalog.motors.iter().map(|m| m.id.as_str()).collect();
    let gears: HashMap<&str, &Gear> = catalog.gears.iter().rev().map(|g| (g.id.as_str(), g)).collect();
    for module in &catalog.modules {
        // Each is reported where its own row is.
        let Some(&at) = places.get(module.id.as_str()) else { continue };
        let mut wrong = |message: String, help: String| {
            problems.push(Problem::at(at..at + module.id.len(), message, "this row").help(help));
        };
        let help = "name a row of the same catalogue: with `--catalog builtin mine.csv` the shipped rows are there too";
        if !module.motor.is_empty() && !motors.contains(module.motor.as_str()) {
            wrong(format!("`{}` names the motor `{}`, which is none", module.id, module.motor), help.into());
        }
        match gears.get(module.gear.as_str()) {
            None if !module.gear.is_empty() => {
                wrong(format!("`{}` names the gear `{}`, which is none", module.id, module.gear), help.into());
            }
            Some(gear) if (gear.ratio / module.ratio() - 1.0).abs() > SAME_RATIO => {
                let (own, other) = (crate::words::number(module.ratio()), crate::words::number(gear.ratio));
                let message = format!("`{}` has the ratio {own}, its gear `{}` has {other}", module.id, gear.id);
                wrong(message, "the two are one gear: look at the source".into());
            }
            _ => {}
        }
    }
    (!problems.is_empty()).then(|| InputError { source: source.clone(), problems })
}

fn catalog_files(folder: &Path) -> Vec<PathBuf> {
    let list = |folder: &Path, extension: &str| -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries
            .map(|e| e.path())
            .filter(|p| p.is_file() && p.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension)))
            .collect()
    };
    let mut files = list(folder, "csv");
    files.extend(read::KINDS.iter().flat_map(|kind| list(&folder.join(kind.folder), "csv")));
    files.extend(list(&folder.join(family::FOLDER), "toml"));
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_a_chain_is_reported_at_its_own_place() {
        let head = "id,manufacturer,model,construction,same_as,terminals,current,resistance [ohm],torque_constant [N*m/A],\
                    rotor_inertia [g*cm^2],mass [g],source,source_date,source_kind\n";
        let row = |id: &str, same_as: &str| {
            format!(
                "{id},x,{id},frameless,{same_as},line_to_line,phase_amplitude,0.2,0.1,100,300,a,2026-01-01,secondary\n"
            )
        };
        // An id that ends as another does, and one that is named before its own row.
        let text = [head, &row("xm1", "m2"), &row("m2", "m1"), &row("m1", "m0"), &row("m0", "")].concat();
        let errors = Catalog::from_sources(vec![Arc::new(Source::new("chain.csv", text.clone()))]).unwrap_err();
        let mut marked: Vec<(usize, &str)> = Vec::new();
        for span in errors.iter().flat_map(|e| &e.problems).filter_map(|p| p.span.clone()) {
            marked.push((text[..span.start].matches('\n').count(), &text[span]));
        }
        assert_eq!(marked, [(1, "xm1"), (2, "m2")]);
    }
}
