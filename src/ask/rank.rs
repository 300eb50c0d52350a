//! Motors by a metric.

use std::sync::Arc;

use self_cell::self_cell;
use serde_json::Value;

use super::rows::find_motor;
use super::sweep::unknown_order;
use super::{Answer, Failure};
use crate::actuator::metrics::{METRICS, Metric, metric};
use crate::catalog::{Catalog, Motor};
use crate::input::InputFile;
use crate::report::html::{self, Page};
use crate::report::json;
use crate::report::plot::{Figure, rank as plot};
use crate::report::rank::{self as report, Ranking};

/// How many motors the text shows where nobody says.
pub const TOP: usize = 20;

type Owned = Arc<Catalog>;

self_cell!(
    struct Cell {
        owner: Owned,
        #[covariant]
        dependent: Ranking,
    }
    impl {Debug}
);

/// Motors in the order of a metric.
#[derive(Debug)]
pub struct Ranked {
    cell: Cell,
    marked: Vec<String>,
}

/// A metric by its name.
///
/// # Errors
/// The nearest that there is, in words.
pub fn by(name: &str) -> Result<&'static Metric, String> {
    metric(name).ok_or_else(|| unknown_order(name, METRICS.iter().map(|m| m.name)))
}

/// Ranks the motors of a catalogue as it was read, with modules that are asked for by name where their rows have constants.
/// `tolerance` is the ± of every number whose row states none, as a share. The motors of `mark` are marked in the picture.
///
/// # Errors
/// There is no motor; a marked one is not there.
pub fn rank(
    catalog: Catalog,
    by: &'static Metric,
    modules: &[String],
    tolerance: Option<f64>,
    mark: &[String],
) -> Result<Ranked, Failure> {
    if catalog.motors.is_empty() {
        return Err(Failure::Argument("the catalogue has no motors".into()));
    }
    let mut catalog = catalog.free(true).with_modules(modules.iter(), |m| m);
    // A module without constants has no metric.
    catalog.motors.retain(|motor| motor.torque_constant.is_finite());
    mark.iter().try_for_each(|id| find_motor(&catalog, id).map(|_| ()))?;
    let cell = Cell::new(Arc::new(catalog), |catalog| Ranking::new(&catalog.motors, by, tolerance));
    Ok(Ranked { cell, marked: mark.to_vec() })
}

impl Ranked {
    /// The ranking.
    pub fn ranking(&self) -> &Ranking<'_> {
        self.cell.borrow_dependent()
    }

    /// The text with so many motors.
    pub fn text_of(&self, top: usize) -> String {
        report::text(self.ranking(), top)
    }

    fn marked(&self) -> Vec<&Motor> {
        self.marked.iter().filter_map(|id| self.cell.borrow_owner().motor(id).ok()).collect()
    }
}

impl Answer for Ranked {
    fn is_satisfied(&self) -> bool {
        true
    }

    fn json(&self) -> Value {
        json::motors::ranked(self.ranking())
    }

    fn csv(&self) -> String {
        report::csv(self.ranking())
    }

    fn text(&self) -> String {
        self.text_of(TOP)
    }

    fn page(&self) -> Page {
        html::rank::page(self.ranking(), &self.marked())
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::figure(self.ranking(), &self.marked()))
    }

    fn files(&self) -> Vec<InputFile> {
        self.cell.borrow_owner().files()
    }
}
