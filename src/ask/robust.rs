//! Designs that keep all limits over the tolerances of the motors.

use std::sync::Arc;

use self_cell::self_cell;
use serde_json::Value;

use super::optimize::{Ready, TOP};
use super::{Answer, Failure, Ground, Watch};
use crate::catalog::Catalog;
use crate::design::robust::{RobustJoint, Taken, assume_tolerance, robust as search, take_alternatives};
use crate::input::InputFile;
use crate::report::html::Page;
use crate::report::plot::Figure;
use crate::report::{html, json, robust as report};

type Joints<'a> = Vec<RobustJoint<'a>>;

self_cell!(
    struct Cell {
        owner: Ground,
        #[covariant]
        dependent: Joints,
    }
    impl {Debug}
);

/// Robust designs of each joint.
#[derive(Debug)]
pub struct Robust {
    cell: Cell,
    taken: Taken,
}

/// A catalogue with the tolerances that are taken for those that its rows do not state.
pub fn with_tolerances(catalog: Arc<Catalog>, taken: &Taken) -> Arc<Catalog> {
    if *taken == Taken::default() {
        return catalog;
    }
    let mut catalog = Arc::unwrap_or_clone(catalog);
    if let Some(share) = taken.tolerance {
        assume_tolerance(&mut catalog.motors, share);
    }
    if taken.alternatives {
        take_alternatives(&mut catalog);
    }
    Arc::new(catalog)
}

/// Chooses.
///
/// # Errors
/// It was stopped.
pub fn robust(ready: Ready, taken: Taken, only_checked: bool, watch: Watch) -> Result<Robust, Failure> {
    let cell = Cell::try_new(ready.ground(watch), |ground| {
        let options = ground.watch.options(only_checked);
        search(&ground.robot, &ground.catalog, options)
    })?;
    Ok(Robust { cell, taken })
}

impl Robust {
    /// Each joint.
    pub fn joints(&self) -> &[RobustJoint<'_>] {
        self.cell.borrow_dependent()
    }

    /// The text with at most so many motors of each joint.
    pub fn text_of(&self, top: usize) -> String {
        let ground = self.cell.borrow_owner();
        ground.told_set() + &report::text(&ground.robot, self.joints(), top, &self.taken)
    }
}

impl Answer for Robust {
    fn is_satisfied(&self) -> bool {
        report::keeps_over_tolerances(self.joints())
    }

    fn json(&self) -> Value {
        json::robust::json(&self.cell.borrow_owner().robot, self.joints(), &self.taken)
    }

    fn csv(&self) -> String {
        report::csv(self.joints())
    }

    fn text(&self) -> String {
        self.text_of(TOP)
    }

    fn page(&self) -> Page {
        html::robust::page(&self.cell.borrow_owner().robot, self.joints())
    }

    fn figure(&self) -> Option<Figure> {
        None
    }

    fn files(&self) -> Vec<InputFile> {
        self.cell.borrow_owner().files()
    }

    fn remarks(&self) -> Vec<String> {
        let untold = report::without_tolerances(self.joints()).map(|joint| {
            format!(
                "{}: the row of the first choice states no tolerance: it keeps its limits by its printed numbers alone, and \
                 nothing is known beyond them; `--tolerance 5%` takes one for every number without",
                joint.nominal.joint.name
            )
        });
        super::alone(&self.cell.borrow_owner().robot).into_iter().chain(untold).collect()
    }
}
