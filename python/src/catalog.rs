//! Catalogues.

use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use gearwise::ask::{Failure, Rows};
use gearwise::catalog;
use gearwise::catalog::filter::{Filter, RowKind};
use gearwise::input::Source;
use gearwise::report::catalog::list;
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

use crate::failure::wrong;
use crate::pool::here;
use crate::requirement::same_version;

/// Rows of motors and gears, as they were read.
#[pyclass(frozen, module = "gearwise._native")]
pub struct Catalog {
    /// What it was read from; `None` for the built-in one alone.
    sources: Option<Vec<Arc<Source>>>,
    paths: Vec<PathBuf>,
    /// Motors that a filter leaves; `None` for all.
    only: Option<Vec<String>>,
    estimates: bool,
    inside_modules: bool,
    catalog: Arc<catalog::Catalog>,
    rows: OnceLock<Rows>,
}

impl Catalog {
    fn new(
        py: Python<'_>,
        sources: Option<Vec<Arc<Source>>>,
        paths: Vec<PathBuf>,
        only: Option<Vec<String>>,
        how: (bool, bool),
    ) -> PyResult<Catalog> {
        let read = sources.clone();
        let mut catalog = here(py, move || match read {
            None => catalog::Catalog::builtin().map_err(Failure::Input),
            Some(sources) => catalog::Catalog::from_sources(sources).map_err(Failure::Input),
        })?;
        if let Some(ids) = &only {
            catalog.motors.retain(|motor| ids.contains(&motor.id));
        }
        let (estimates, inside_modules) = how;
        let catalog = Arc::new(catalog);
        Ok(Catalog { sources, paths, only, estimates, inside_modules, catalog, rows: OnceLock::new() })
    }

    /// The rows as one chooses from them: made once.
    pub fn rows(&self) -> Result<Rows, Failure> {
        let make = || Rows::new(catalog::Catalog::clone(&self.catalog), self.estimates, self.inside_modules);
        self.rows.get_or_init(make).clone().some()
    }

    /// Whether rows that lack something are completed.
    pub fn estimates(&self) -> bool {
        self.estimates
    }

    /// What it was read from, and whether a filter left rows out of that.
    pub fn sources(&self) -> (Vec<Arc<Source>>, bool) {
        let sources = self.sources.clone().unwrap_or_else(catalog::Catalog::builtin_sources);
        (sources, self.only.is_some())
    }

    /// The rows as they were read.
    pub fn read(&self) -> Arc<catalog::Catalog> {
        self.catalog.clone()
    }

    /// The files that it was read from; none for the built-in one.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }
}

#[pymethods]
impl Catalog {
    #[new]
    #[pyo3(signature = (*sources, estimates=true, inside_modules=false))]
    fn of(py: Python<'_>, sources: &Bound<'_, PyTuple>, estimates: bool, inside_modules: bool) -> PyResult<Catalog> {
        let how = (estimates, inside_modules);
        if sources.is_empty() {
            return Catalog::new(py, None, Vec::new(), None, how);
        }
        let (mut all, mut paths) = (Vec::new(), Vec::new());
        for source in sources.iter() {
            if let Ok(other) = source.cast::<Catalog>() {
                let other = other.get();
                if other.only.is_some() {
                    return Err(wrong(
                        py,
                        "a catalogue that was filtered is not put together with others: filter the whole",
                    ));
                }
                all.extend(other.sources.clone().unwrap_or_else(catalog::Catalog::builtin_sources));
                paths.extend(if other.sources.is_none() { vec!["builtin".into()] } else { other.paths.clone() });
                continue;
            }
            if !source.is_instance_of::<PyString>() && !source.hasattr("__fspath__")? {
                let kind = source.get_type().name()?;
                return Err(wrong(py, format!("a {kind} is no catalogue: expected a path or a Catalog")));
            }
            let path: PathBuf = source.extract().map_err(|_| wrong(py, "a catalogue's path is no text"))?;
            let read = std::slice::from_ref(&path);
            all.extend(here(py, || catalog::Catalog::sources(read).map_err(|(_, errors)| Failure::Input(errors)))?);
            paths.push(path);
        }
        Catalog::new(py, Some(all), paths, None, how)
    }

    /// The rows of a text as a catalogue file has it.
    #[staticmethod]
    #[pyo3(name = "_of_text", signature = (texts, estimates=true, inside_modules=false))]
    fn of_text(
        py: Python<'_>,
        texts: Vec<(String, String)>,
        estimates: bool,
        inside_modules: bool,
    ) -> PyResult<Catalog> {
        let sources = texts.into_iter().map(|(name, text)| Arc::new(Source::new(name, text))).collect();
        Catalog::new(py, Some(sources), Vec::new(), None, (estimates, inside_modules))
    }

    /// The same with these motors alone.
    #[pyo3(name = "_only")]
    fn only(&self, py: Python<'_>, ids: Vec<String>) -> PyResult<Catalog> {
        let how = (self.estimates, self.inside_modules);
        Catalog::new(py, self.sources.clone(), self.paths.clone(), Some(ids), how)
    }

    /// The motors as a catalogue file has them, CSV.
    #[pyo3(name = "_csv")]
    fn csv(&self, py: Python<'_>, kind: &str, filters: Vec<String>) -> PyResult<String> {
        let kind = RowKind::NAMES.iter().find(|(name, _)| *name == kind).map(|(_, kind)| *kind);
        let filters: Result<Vec<Filter>, String> = filters.iter().map(|text| Filter::read(text)).collect();
        let filters = filters.map_err(|why| wrong(py, why))?;
        here(py, || list::csv(&list::Listing::new(&self.catalog, kind, filters)).map_err(Failure::Argument))
    }

    #[getter]
    #[pyo3(name = "_paths")]
    fn known_paths(&self) -> Vec<PathBuf> {
        self.paths.clone()
    }

    fn __len__(&self) -> usize {
        self.catalog.motors.len()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let again = py.get_type::<Catalog>().getattr("_again")?;
        let text = |source: &Arc<Source>| (source.name().to_string(), source.text().to_string());
        let texts: Option<Vec<(String, String)>> = self.sources.as_ref().map(|all| all.iter().map(text).collect());
        let how = (self.estimates, self.inside_modules);
        let state = (env!("CARGO_PKG_VERSION"), texts, self.paths.clone(), self.only.clone(), how);
        Ok((again, state.into_pyobject(py)?.into_any()))
    }

    /// Made again from what `__reduce__` gave.
    #[staticmethod]
    #[pyo3(name = "_again")]
    fn again(
        py: Python<'_>,
        version: &str,
        texts: Option<Vec<(String, String)>>,
        paths: Vec<PathBuf>,
        only: Option<Vec<String>>,
        how: (bool, bool),
    ) -> PyResult<Catalog> {
        same_version(py, "catalogue", version)?;
        let source = |(name, text): (String, String)| Arc::new(Source::new(name, text));
        let sources = texts.map(|texts| texts.into_iter().map(source).collect());
        Catalog::new(py, sources, paths, only, how)
    }
}
