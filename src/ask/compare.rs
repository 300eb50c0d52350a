//! Two motors side by side.

use std::sync::Arc;

use self_cell::self_cell;
use serde_json::Value;

use super::rows::{Rows, find_motor};
use super::{Answer, Failure};
use crate::catalog::Catalog;
use crate::input::InputFile;
use crate::report::compare::{self as report, Comparison};
use crate::report::html::{self, Page};
use crate::report::json;
use crate::report::plot::{Figure, step as plot};

type Owned = Arc<Catalog>;

self_cell!(
    struct Cell {
        owner: Owned,
        #[covariant]
        dependent: Comparison,
    }
    impl {Debug}
);

/// Two motors side by side.
#[derive(Debug)]
pub struct Compared {
    cell: Cell,
}

/// Compares two motors at an actuator inertia \[kg·m²\]; without one, at the larger rotor inertia of the two.
///
/// # Errors
/// A motor that is not there; an inertia that is not greater than zero.
pub fn compare(rows: &Rows, a: &str, b: &str, inertia: Option<f64>) -> Result<Compared, Failure> {
    if let Some(inertia) = inertia.filter(|inertia| !(*inertia > 0.0 && inertia.is_finite())) {
        return Err(Failure::Argument(format!("an actuator inertia of {inertia} kg*m^2 is not greater than zero")));
    }
    let catalog = rows.with_modules(&[a.to_string(), b.to_string()]);
    let cell = Cell::try_new(catalog, |catalog| {
        Ok::<_, Failure>(Comparison::new(find_motor(catalog, a)?, find_motor(catalog, b)?, inertia))
    })?;
    Ok(Compared { cell })
}

impl Answer for Compared {
    fn is_satisfied(&self) -> bool {
        true
    }

    fn json(&self) -> Value {
        json::motors::compared(self.cell.borrow_dependent())
    }

    fn csv(&self) -> String {
        String::new()
    }

    fn text(&self) -> String {
        report::text(self.cell.borrow_dependent())
    }

    fn page(&self) -> Page {
        html::compare::page(self.cell.borrow_dependent())
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::figure(self.cell.borrow_dependent()))
    }

    fn files(&self) -> Vec<InputFile> {
        self.cell.borrow_owner().files()
    }
}
