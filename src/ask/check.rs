//! Whether a chosen design keeps its rules.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use self_cell::self_cell;
use serde_json::Value;

use super::rows::Rows;
use super::{Answer, Failure, balanced, told_set};
use crate::catalog::Catalog;
use crate::design::families::settle;
use crate::design::options::Options;
use crate::input::{InputFile, Source};
use crate::report::check::text;
use crate::report::html::{self, Page};
use crate::report::json;
use crate::report::plot::Figure;
use crate::requirement::DesignFile;
use crate::rules::file::{RulesFile, read};
use crate::rules::lock::Lock;
use crate::rules::{Report, check as judge};

/// A design, and what it is judged by.
#[derive(Debug)]
pub struct Inputs {
    /// The design.
    pub design: DesignFile,
    /// The catalogue that it takes its rows from.
    pub catalog: Arc<Catalog>,
    /// The rules.
    pub rules: RulesFile,
    /// Where the lock is, or would be.
    pub lock_path: PathBuf,
    /// The lock of the catalogue rows, where there is one.
    pub lock: Option<Arc<Source>>,
}

self_cell!(
    struct Cell {
        owner: Inputs,
        #[covariant]
        dependent: Report,
    }
    impl {Debug}
);

/// What was found in a design.
#[derive(Debug)]
pub struct Checked {
    cell: Cell,
    strict: bool,
}

impl Inputs {
    /// A design made ready with its rows: its rules are those of `rules`, else those that it or its requirement names, else the
    /// default ones.
    ///
    /// # Errors
    /// Mistakes of rules, and rows that are not there.
    pub fn new(
        mut design: DesignFile,
        rows: &Rows,
        rules: Option<&Path>,
        lock_path: PathBuf,
    ) -> Result<Inputs, Failure> {
        let catalog = rows.for_design(&mut design);
        design.robot = settle(design.robot, &catalog).map_err(Failure::Argument)?;
        design.robot = balanced(&design.robot, &catalog, Options::default())?;
        let named = design.rules.as_deref().or(design.robot.rules.as_deref());
        let rules = match rules.or(named) {
            Some(path) => read(path).map_err(|e| vec![e])?,
            None => RulesFile::default(),
        };
        Ok(Inputs { design, catalog, rules, lock_path, lock: None })
    }

    /// The text of the lock as the catalogue is now.
    ///
    /// # Errors
    /// Motors and gears that the catalogue does not have.
    pub fn new_lock(&self) -> Result<String, Failure> {
        let choices = self.design.choices(&self.catalog).map_err(|e| vec![e])?;
        Ok(Lock::of(&self.design, &choices, &self.catalog).to_toml())
    }
}

/// Checks; with `strict` warnings fail too.
///
/// # Errors
/// Motors and gears that the catalogue does not have, a lock that cannot be read.
pub fn check(inputs: Inputs, strict: bool) -> Result<Checked, Failure> {
    let cell = Cell::try_new(inputs, |inputs| {
        let Inputs { design, catalog, rules, lock_path, lock } = inputs;
        judge(design, catalog, rules, lock.as_ref(), lock_path)
    })?;
    Ok(Checked { cell, strict })
}

impl Checked {
    /// What was found.
    pub fn report(&self) -> &Report<'_> {
        self.cell.borrow_dependent()
    }
}

impl Answer for Checked {
    fn is_satisfied(&self) -> bool {
        self.report().passes(self.strict)
    }

    fn json(&self) -> Value {
        json::check::json(self.report(), self.strict)
    }

    fn csv(&self) -> String {
        String::new()
    }

    fn text(&self) -> String {
        told_set(&self.cell.borrow_owner().design.robot) + &text::text(self.report(), self.strict)
    }

    fn page(&self) -> Page {
        html::check::page(self.report(), self.strict)
    }

    fn figure(&self) -> Option<Figure> {
        None
    }

    fn files(&self) -> Vec<InputFile> {
        let Inputs { design, catalog, rules, lock, .. } = self.cell.borrow_owner();
        let files = [Some(&design.source), Some(&design.requirement), rules.source.as_ref(), lock.as_ref()];
        let files = files.into_iter().flatten().map(|source| source.file());
        files.chain(design.robot.files()).chain(catalog.files()).collect()
    }
}
