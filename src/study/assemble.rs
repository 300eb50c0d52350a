//! From the journal, or the journals of all shards, to the results: block by block, robot by robot, in the
//! order of their numbers.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

use super::StudyError;
use super::columns;
use super::effects::Effects;
use super::journal::{Journal, Lock};
use super::output::{FILES, MANIFEST, Manifest, Part, place, seal, unsettle};
use super::plan::{Plan, Shard};
use super::summary::{Gatherer, Summary};
use super::worker::Record;
use crate::output::make_folder;
use crate::study::text as report;

/// Journals of all shards of one study, in order.
#[derive(Debug)]
pub struct Shards {
    journals: Vec<Journal>,
}

impl Shards {
    /// The journal of a whole study.
    pub fn whole(journal: Journal) -> Shards {
        Shards { journals: vec![journal] }
    }

    /// Opens the shards in these folders.
    ///
    /// # Errors
    /// A folder that has none, or one of another study; a shard that is not finished, missing or there
    /// twice.
    pub fn open(folders: &[std::path::PathBuf]) -> Result<Shards, StudyError> {
        let mut found: Vec<(Journal, &Path)> = Vec::new();
        for folder in folders {
            let name = folder.display();
            // The same folder twice would wait for itself.
            if let Some((journal, _)) = found.iter().find(|(_, f)| *f == folder) {
                return Err(StudyError::Argument(format!("duplicate shard {}: `{name}` and `{name}`", journal.shard)));
            }
            if !Journal::is_in(folder) {
                let finished = folder.join(MANIFEST).is_file();
                let what = if finished { "has a whole study, not a shard" } else { "has no study" };
                return Err(StudyError::Argument(format!("`{name}` {what}")));
            }
            // A shard that is still being worked on is refused here.
            let journal = Journal::open(folder, Lock::take(folder)?)?;
            if let Some((first, other)) = found.first() {
                if let Some(why) = first.plan.difference(&journal.plan) {
                    let other = other.display();
                    return Err(StudyError::Argument(format!(
                        "`{name}` is a shard of another study than `{other}`: {why}"
                    )));
                }
                if first.shard.of != journal.shard.of {
                    return Err(StudyError::Argument(format!(
                        "`{name}` is shard {}, but `{}` is shard {}",
                        journal.shard,
                        other.display(),
                        first.shard
                    )));
                }
            }
            if let Some((_, twin)) = found.iter().find(|(j, _)| j.shard == journal.shard) {
                return Err(StudyError::Argument(format!(
                    "duplicate shard {}: `{}` and `{name}`",
                    journal.shard,
                    twin.display()
                )));
            }
            found.push((journal, folder));
        }
        found.sort_by_key(|(journal, _)| journal.shard.number);
        let of = found.first().map_or(0, |(j, _)| j.shard.of);
        let missing: Vec<String> = (1..=of)
            .filter(|n| !found.iter().any(|(j, _)| j.shard.number == *n))
            .map(|number| Shard { number, of }.to_string())
            .collect();
        if !missing.is_empty() {
            let shards = if missing.len() == 1 { "a shard is" } else { "shards are" };
            return Err(StudyError::Argument(format!("{shards} missing: {}", missing.join(", "))));
        }
        for (journal, folder) in &found {
            let (done, of) = (journal.recorded()?, journal.plan.robots_in(journal.shard));
            if done < of {
                return Err(StudyError::Argument(format!(
                    "shard {} in `{}` is not finished: {done} of {of} robots; run it again with `--resume`",
                    journal.shard,
                    folder.display()
                )));
            }
        }
        Ok(Shards { journals: found.into_iter().map(|(journal, _)| journal).collect() })
    }

    /// What is studied.
    pub fn plan(&self) -> &Plan {
        &self.journals[0].plan
    }

    fn read(&self, block: u64) -> Result<Vec<Record>, StudyError> {
        let journal = &self.journals[(block % self.journals.len() as u64) as usize];
        let records = journal.read(block)?;
        let robots = self.plan().robots_of(block);
        if records.len() as u64 != robots.end - robots.start {
            let message = format!("the journal of shard {} is damaged: block {block} is not whole", journal.shard);
            return Err(StudyError::Argument(message));
        }
        Ok(records)
    }
}

/// The files that are written row by row.
struct Tables {
    results: csv::Writer<Part>,
    #[cfg(feature = "parquet")]
    typed: super::parquet::Table<Part>,
    errors: csv::Writer<Part>,
    inputs: csv::Writer<Part>,
}

impl Tables {
    fn new(out: &Path, plan: &Plan) -> Result<Tables, StudyError> {
        let [results, _typed, errors, inputs, ..] = FILES;
        let columns = columns::all(plan);
        let begin = |name: &'static str, header: &[&str]| -> Result<csv::Writer<Part>, StudyError> {
            let mut writer = csv::Writer::from_writer(Part::new(out, name)?);
            crate::words::csv::csv_row(&mut writer, header.iter().copied()).map_err(|e| cannot(name, &e))?;
            Ok(writer)
        };
        let header: Vec<&str> = columns.iter().map(|c| c.name.as_str()).collect();
        let grid: Vec<String> = columns::of_grid(plan).map(|c| c.name).collect();
        let mut of_errors = vec!["robot", "requirement", "name"];
        of_errors.extend(grid.iter().map(String::as_str));
        of_errors.extend(["mistakes", "first", "report"]);
        Ok(Tables {
            results: begin(results, &header)?,
            errors: begin(errors, &of_errors)?,
            inputs: begin(inputs, &["requirement", "file", "sha256"])?,
            #[cfg(feature = "parquet")]
            typed: super::parquet::Table::new(Part::new(out, _typed)?, columns).map_err(|e| cannot(_typed, &e))?,
        })
    }

    fn robot(&mut self, plan: &Plan, requirement: &str, record: &Record) -> Result<(), StudyError> {
        let number = record.robot.to_string();
        let of_robot = [number.as_str(), requirement, record.name.as_str()];
        let point = record.robot % plan.points();
        let robot = || of_robot.into_iter().chain(columns::grid_cells(plan, point));
        for row in record.joints.iter().flat_map(|j| &j.rows) {
            let cells = || robot().chain(row.iter().map(String::as_str));
            crate::words::csv::csv_row(&mut self.results, cells()).map_err(|e| cannot(FILES[0], &e))?;
            #[cfg(feature = "parquet")]
            self.typed.row(cells()).map_err(|e| cannot(FILES[1], &e))?;
        }
        if let Some(broken) = &record.broken {
            let mistakes = broken.mistakes.to_string();
            let cells = [mistakes.as_str(), broken.first.as_str(), broken.report.as_str()];
            crate::words::csv::csv_row(&mut self.errors, robot().chain(cells)).map_err(|e| cannot(FILES[2], &e))?;
        }
        Ok(())
    }

    fn parts(self) -> Result<Vec<Part>, StudyError> {
        let whole = |writer: csv::Writer<Part>, name| writer.into_inner().map_err(|e| cannot(name, e.error()));
        Ok(vec![
            whole(self.results, FILES[0])?,
            #[cfg(feature = "parquet")]
            self.typed.finish().map_err(|e| cannot(FILES[1], &e))?,
            whole(self.errors, FILES[2])?,
            whole(self.inputs, FILES[3])?,
        ])
    }
}

fn cannot(name: &str, error: &dyn std::fmt::Display) -> StudyError {
    StudyError::Argument(format!("cannot write `{name}`: {error}"))
}

/// Writes the results of a finished study into a folder. Nothing is there before all of it is.
///
/// # Errors
/// A journal that is damaged, an input that changed while the study ran, and results that cannot be
/// written.
pub fn assemble(shards: &Shards, out: &Path) -> Result<Summary, StudyError> {
    let plan = shards.plan();
    make_folder(out).map_err(StudyError::Argument)?;
    let mut tables = Tables::new(out, plan)?;
    let mut gatherer = Gatherer::default();
    let mut effects = Effects::new(out, plan)?;
    let mut requirements = shards.journals[0].requirements(0)?;
    let mut inputs = InputsOf::default();
    for block in 0..plan.blocks() {
        for record in shards.read(block)? {
            let requirement = requirements.get(record.robot / plan.points())?;
            inputs.note(&mut tables.inputs, requirement, &record)?;
            tables.robot(plan, requirement, &record)?;
            let choices = gatherer.robot(plan, &record);
            effects.point(plan, &choices)?;
        }
    }
    let rows = gatherer.rows();
    let summary = gatherer.finish(plan, effects.finish(plan));
    let mut parts = tables.parts()?;
    let picture = crate::report::plot::svg(&crate::study::plot::figure(&summary));
    for (name, text) in [(FILES[4], report::json_text(&summary)), (FILES[5], picture)] {
        let mut part = Part::new(out, name)?;
        part.write_all(text.as_bytes()).map_err(|e| part.fail(e))?;
        parts.push(part);
    }
    let outputs = seal(&mut parts)?;
    let manifest = Manifest { plan: plan.clone(), broken: summary.broken, rows, outputs };
    let mut part = Part::new(out, MANIFEST)?;
    let text = serde_json::to_string_pretty(&manifest).map_err(|e| part.fail(e))?;
    part.write_all(text.as_bytes()).and_then(|()| part.write_all(b"\n")).map_err(|e| part.fail(e))?;
    let mut manifest = [part];
    seal(&mut manifest)?;
    unsettle(out)?;
    place(&mut parts)?;
    place(&mut manifest)?;
    Ok(summary)
}

/// The files of the requirement at hand that are noted already.
#[derive(Debug, Default)]
struct InputsOf {
    requirement: String,
    noted: BTreeSet<(String, String)>,
}

impl InputsOf {
    /// Notes the files of a robot, each once for its requirement.
    fn note(&mut self, table: &mut csv::Writer<Part>, requirement: &str, record: &Record) -> Result<(), StudyError> {
        if self.requirement != requirement {
            self.requirement = requirement.into();
            self.noted.clear();
        }
        for (file, hash) in &record.inputs {
            if !self.noted.insert((file.clone(), hash.clone())) {
                continue;
            }
            if self.noted.iter().any(|(f, h)| f == file && h != hash) {
                return Err(StudyError::Argument(format!(
                    "`{file}` was changed while the study ran; start again with `--force`"
                )));
            }
            crate::words::csv::csv_row(table, [requirement, file.as_str(), hash.as_str()])
                .map_err(|e| cannot(FILES[3], &e))?;
        }
        Ok(())
    }
}
