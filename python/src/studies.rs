//! Studies: many robots in one go.

use std::path::PathBuf;

use gearwise::ask::{Failure, Rows};
use gearwise::catalog;
use gearwise::requirement;
use gearwise::study::answer::{Finished, Part};
use gearwise::study::asked::{Asked, hashed, some};
use gearwise::study::file::grid_of_values;
use gearwise::study::run::{Existing, Study, Watch, prepare, run};
use gearwise::study::{Settings, Shard};
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use crate::answer::Answer;
use crate::catalog::Catalog;
use crate::failure::wrong;
use crate::pool::{How, here};
use crate::values::Writer;

/// The whole of a study, or a part of it.
enum Done {
    Whole(Box<Finished>),
    Part(Part),
}

#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "as Python calls it")]
pub fn study<'py>(
    py: Python<'py>,
    paths: Vec<PathBuf>,
    changes: Vec<(String, String)>,
    grid: Option<Bound<'py, PyAny>>,
    out: PathBuf,
    top: Option<i64>,
    only_checked: bool,
    shard: (i64, i64),
    existing: &str,
    catalog: Option<Bound<'py, Catalog>>,
    threads: Option<i64>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Answer> {
    let shard =
        Shard::parse(&format!("{}/{}", shard.0, shard.1)).map_err(|why| wrong(py, format!("`shard`: {why}")))?;
    let top = match top.map(|top| u32::try_from(top).ok().filter(|top| *top > 0).ok_or(top)) {
        Some(Err(top)) => {
            return Err(wrong(py, format!("`top` is {top}: expected a number from 1 on, or None for all")));
        }
        Some(Ok(top)) => Some(top),
        None => None,
    };
    let values = changes.iter().map(|(key, value)| (key.as_str(), value.clone()));
    let changes = requirement::Settings::of_values("the changes", values).map_err(|why| wrong(py, why))?;
    let existing = match existing {
        "resume" => Existing::Resume,
        "force" => Existing::Replace,
        _ => Existing::Refuse,
    };
    let grid = grid.map(|grid| written(py, &grid)).transpose()?;
    let given = catalog.map(|catalog| {
        let catalog = catalog.get();
        let ((sources, filtered), estimates) = (catalog.sources(), catalog.estimates());
        catalog.rows().map(|rows| (rows, sources, filtered, estimates))
    });
    let given = given.transpose().map_err(|why| crate::failure::raised(py, why))?;
    if given.as_ref().is_some_and(|(_, _, filtered, _)| *filtered) {
        let why = "a study notes the files of its catalogue, and this one is a part of them: give its motors in the requirement's `motors`";
        return Err(wrong(py, why));
    }
    let how = How { to_its_end: true, ..How::new(py, threads, progress)? };
    let done = how.run(py, move |looking| {
        let mut asked = Asked::of(&paths)?;
        if let Some(text) = grid {
            asked = asked.with_grid(grid_of_values(text).map_err(|error| vec![error])?)?;
        }
        asked = asked.set(&changes)?;
        let named = asked.catalog(Vec::new())?;
        if given.is_some() && !named.is_empty() {
            return Err(Failure::Argument("the study file names its catalogue: leave `catalog` out".into()));
        }
        let (rows, sources, _, estimates) = match given {
            Some(given) => given,
            None => {
                let sources = match named.as_slice() {
                    [] => catalog::Catalog::builtin_sources(),
                    paths => catalog::Catalog::sources(paths).map_err(|(_, errors)| errors)?,
                };
                (Rows::new(catalog::Catalog::from_sources(sources.clone())?, true, false), sources, false, true)
            }
        };
        let catalog = some(rows)?;
        let study = Study {
            inputs: &asked.inputs,
            file: asked.file.as_ref().map(|file| &file.source),
            homes: &asked.homes,
            catalog: &catalog,
            catalog_files: hashed(&sources),
            settings: Settings { top, only_checked, estimates },
            shard,
        };
        let Some(journal) = prepare(&study, &out, existing)? else {
            return Ok(Done::Whole(Box::new(Finished::there(&out)?)));
        };
        let count = |robots: u64| usize::try_from(robots).unwrap_or(usize::MAX);
        let watch = Watch {
            stop: looking.stop(),
            begin: &|done, of| looking.begin_after(count(done), count(of)),
            tick: &|| looking.tick(),
            broken: &|_, _, _, _| (),
        };
        let robots = run(&study, &journal, &watch)?;
        Ok(match shard == Shard::WHOLE {
            true => Done::Whole(Box::new(Finished::of(journal, &out)?)),
            false => Done::Part(Part::of(&journal, robots)?),
        })
    })?;
    Ok(match done {
        Done::Whole(finished) => Answer::new(*finished),
        Done::Part(part) => Answer::new(part),
    })
}

/// A grid as the table of a study file, its keys in their order: the last changes fastest.
fn written(py: Python<'_>, grid: &Bound<'_, PyAny>) -> PyResult<String> {
    let items = grid.cast::<PyMapping>().map_err(|_| wrong(py, "`grid` is no mapping of keys to their values"))?;
    let mut text = String::from("[grid]\n");
    for item in items.items()?.iter() {
        let (key, values): (Bound<PyAny>, Bound<PyAny>) = item.extract()?;
        let key: String = key.extract().map_err(|_| wrong(py, "a key of `grid` is no text"))?;
        let mut writer = Writer::new(py);
        let Some(values) = writer.value(&values, &key, 0)? else {
            return Err(wrong(py, format!("`grid`: `{key}` is None: expected a list of values")));
        };
        if !writer.motions.is_empty() {
            let why = format!(
                "`grid`: `{key}` has motions, which a study takes from files: save a requirement with each, and give the paths"
            );
            return Err(wrong(py, why));
        }
        text.push_str(&format!("{} = {values}\n", toml::Value::String(key)));
    }
    Ok(text)
}

#[pyfunction]
pub fn merge(py: Python<'_>, out: PathBuf, shards: Vec<PathBuf>, force: bool) -> PyResult<Answer> {
    Ok(Answer::new(here(py, || Ok(Finished::merged(&out, &shards, force)?))?))
}
