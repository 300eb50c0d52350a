//! What is asked of a study: requirements, and a grid over them.

use std::path::PathBuf;
use std::sync::Arc;

use super::StudyError;
use super::file::{StudyFile, is_study_file, read};
use super::grid::{Grid, Parameter};
use super::plan::{Hashed, Inputs};
use crate::ask::Rows;
use crate::catalog::Catalog;
use crate::input::Source;
use crate::requirement::Settings;

/// Requirements and a grid over them, with what both are written in.
#[derive(Debug)]
pub struct Asked {
    /// Which requirements, and the grid.
    pub inputs: Inputs,
    /// The study file, where there is one.
    pub file: Option<StudyFile>,
    /// Where the grid is written.
    pub homes: Vec<Arc<Source>>,
}

impl Asked {
    /// Requirement files, folders and patterns; or one study file.
    ///
    /// # Errors
    /// Mistakes of the study file, paths that are not UTF-8.
    pub fn of(paths: &[PathBuf]) -> Result<Asked, StudyError> {
        if let Some(file) = study_file(paths)? {
            let base = file.source.folder().to_path_buf();
            let inputs = Inputs { base, paths: file.requirements.clone(), grid: file.grid.clone() };
            return Ok(Asked { inputs, homes: vec![file.source.clone()], file: Some(file) });
        }
        let text = |path: &PathBuf| {
            let text = path.to_str().map(String::from);
            text.ok_or_else(|| StudyError::Argument(format!("`{}` is not UTF-8", path.display())))
        };
        let paths = paths.iter().map(text).collect::<Result<_, _>>()?;
        let inputs = Inputs { base: PathBuf::new(), paths, grid: Grid::default() };
        Ok(Asked { inputs, file: None, homes: Vec::new() })
    }

    /// With what is set for every robot: parameters of the grid with one value each, so that plan and results have them.
    ///
    /// # Errors
    /// Factors that are none; what the grid has values for already.
    pub fn set(mut self, settings: &Settings) -> Result<Asked, StudyError> {
        settings.check_factors()?;
        let (changes, written) = settings.parts();
        let mut parameters = std::mem::take(&mut self.inputs.grid.parameters);
        for change in changes {
            let key = change.key();
            if parameters.iter().any(|p| p.key == key) {
                let why = format!("`--set {key}`: the grid of the study has values for it already");
                return Err(StudyError::Argument(why));
            }
            parameters.push(Parameter::new(key.to_string(), vec![change.clone().written_after(self.homes.len())]));
        }
        self.homes.extend(written.iter().cloned());
        self.inputs.grid = Grid::new(parameters).map_err(StudyError::Argument)?;
        Ok(self)
    }

    /// With the grid of a program, and what it is written in.
    ///
    /// # Errors
    /// The study file has one.
    pub fn with_grid(mut self, (grid, written): (Grid, Arc<Source>)) -> Result<Asked, StudyError> {
        if self.file.is_some() {
            return Err(StudyError::Argument(
                "the study file has its own grid: leave `grid` out, or change it there".into(),
            ));
        }
        self.inputs.grid = grid;
        self.homes.push(written);
        Ok(self)
    }

    /// The catalogue files that the study names: its own, or else the given ones.
    ///
    /// # Errors
    /// Both name some.
    pub fn catalog(&self, given: Vec<PathBuf>) -> Result<Vec<PathBuf>, StudyError> {
        match &self.file {
            Some(file) if !given.is_empty() && !file.catalog.is_empty() => {
                Err(StudyError::Argument("the study file names its catalogue; leave `--catalog` out".into()))
            }
            Some(file) if !file.catalog.is_empty() => Ok(file.catalog.clone()),
            _ => Ok(given),
        }
    }
}

/// Catalogue sources with the hashes that the plan has of them.
pub fn hashed(sources: &[Arc<Source>]) -> Vec<Hashed> {
    sources.iter().map(|s| Hashed { file: s.name().to_string(), sha256: s.sha256() }).collect()
}

/// The rows to choose from.
///
/// # Errors
/// There are none.
pub fn some(rows: Rows) -> Result<Catalog, StudyError> {
    let catalog = rows.into_catalog();
    match catalog.motors.is_empty() && catalog.modules.is_empty() {
        true => Err(StudyError::Argument("the catalogue has no motors and no modules".into())),
        false => Ok(catalog),
    }
}

/// The study file, where the one path is one.
fn study_file(paths: &[PathBuf]) -> Result<Option<StudyFile>, StudyError> {
    let [path] = paths else { return Ok(None) };
    // A pattern, or nothing. What is there and is no file is refused by the reader.
    let stdin = path.as_os_str() == Source::STDIN;
    if !stdin && (path.is_dir() || path.symlink_metadata().is_err()) {
        return Ok(None);
    }
    let source: Arc<Source> = Source::argument(path).map_err(|e| vec![e])?;
    if !is_study_file(&source) {
        if stdin {
            let why = "a study notes the names of its requirements: what comes from `-` can be a study file only";
            return Err(StudyError::Argument(why.into()));
        }
        return Ok(None);
    }
    Ok(Some(read(&source).map_err(|e| vec![e])?))
}
