//! The catalogue as one chooses from it.

use std::borrow::Cow;
use std::sync::Arc;

use super::Failure;
use crate::actuator::estimate::{complete, completed, completed_module};
use crate::catalog::{Catalog, Motor};
use crate::design::windings;
use crate::requirement::{DesignFile, Robot};

/// A catalogue made ready to choose from: each motor once, what its rows lack estimated.
#[derive(Debug, Clone)]
pub struct Rows {
    catalog: Arc<Catalog>,
    estimates: bool,
}

impl Rows {
    /// The rows of a catalogue. `estimates`: what a row lacks is estimated from rows built alike. `inside_modules`: motors that
    /// are only sold inside a module are a free choice too.
    pub fn new(catalog: Catalog, estimates: bool, inside_modules: bool) -> Rows {
        let free = catalog.free(inside_modules);
        Rows { catalog: Arc::new(if estimates { complete(free) } else { free }), estimates }
    }

    /// The catalogue.
    pub fn catalog(&self) -> &Arc<Catalog> {
        &self.catalog
    }

    /// The catalogue, for itself.
    pub fn into_catalog(self) -> Catalog {
        Arc::unwrap_or_clone(self.catalog)
    }

    /// What fills what a module's row lacks.
    fn completing(&self) -> fn(Motor) -> Motor {
        if self.estimates { completed_module } else { |module| module }
    }

    /// The same, where there is at least one motor or one module.
    ///
    /// # Errors
    /// There is none.
    pub fn some(self) -> Result<Rows, Failure> {
        let Catalog { modules, motors, aside, .. } = &*self.catalog;
        match modules.is_empty() && motors.is_empty() && aside.is_empty() {
            true => Err(Failure::Argument("the catalogue has no motors and no modules".into())),
            false => Ok(self),
        }
    }

    /// With the windings and the modules that a robot asks for.
    ///
    /// # Errors
    /// There is nothing to choose from.
    pub fn for_robot(&self, robot: &Robot) -> Result<Arc<Catalog>, Failure> {
        let turns = robot.listed_turns();
        let catalog = match turns.is_empty() && robot.modules().next().is_none() {
            true => self.catalog.clone(),
            false => {
                let wound = Arc::unwrap_or_clone(self.catalog.clone()).with_turns(&turns);
                Arc::new(wound.with_modules(robot.modules(), self.completing()))
            }
        };
        if !catalog.motors.is_empty() {
            return Ok(catalog);
        }
        Err(Failure::Argument(match catalog.aside.is_empty() {
            true => "the catalogue has no motors".into(),
            false => "all motors of the catalogue are only sold inside modules; `--also-inside-modules` takes them"
                .to_string(),
        }))
    }

    /// For a design: with the windings that its joints list, and the windings and modules that it names. Of fitted actuators that it names
    /// by their files, what they lack is estimated as of rows.
    pub fn for_design(&self, design: &mut DesignFile) -> Arc<Catalog> {
        if self.estimates {
            design.change_fitted(completed);
        }
        self.with_named(&design.robot, design.motor_ids())
    }

    /// With the windings that joints list, and the windings and modules that designs name.
    pub fn with_named<'i>(&self, robot: &Robot, ids: impl Iterator<Item = &'i str>) -> Arc<Catalog> {
        let ids: Vec<String> = ids.map(str::to_string).collect();
        let catalog = Arc::unwrap_or_clone(self.catalog.clone());
        let catalog = catalog.with_modules(robot.modules().chain(&ids), self.completing());
        let ids = ids.iter().map(String::as_str);
        let within = |turns: f64, (min, max): (f64, f64)| min <= turns && turns <= max;
        let allow =
            |turns: f64| robot.joints.iter().filter_map(|j| j.motors.turns.range()).any(|range| within(turns, range));
        Arc::new(catalog.with_turns(&robot.listed_turns()).with_named(ids, allow))
    }

    /// For motors of these ids at a robot's joints; `None` for all that may be chosen. What is a row already is not made again.
    ///
    /// # Errors
    /// There is nothing to choose from.
    pub fn for_motors(&self, robot: &Robot, ids: Option<&[String]>) -> Result<Arc<Catalog>, Failure> {
        let is_row = |id: &String| self.catalog.motors.iter().any(|motor| motor.id == *id);
        match ids.filter(|ids| !ids.iter().all(is_row)) {
            Some(ids) => Ok(self.with_named(robot, ids.iter().map(String::as_str))),
            None => self.for_robot(robot),
        }
    }

    /// With the modules of these ids.
    pub fn with_modules(&self, ids: &[String]) -> Arc<Catalog> {
        Arc::new(Arc::unwrap_or_clone(self.catalog.clone()).with_modules(ids.iter(), self.completing()))
    }
}

/// The catalogue with the windings that are best where a joint has a range of turns.
pub(crate) fn wound(robot: &mut Robot, catalog: Arc<Catalog>, only_checked: bool) -> Result<Arc<Catalog>, Failure> {
    let made = match windings::wind(robot, &catalog, only_checked).map_err(Failure::Argument)? {
        Cow::Borrowed(_) => None,
        Cow::Owned(made) => Some(made),
    };
    Ok(made.map_or(catalog, Arc::new))
}

/// The motor of the catalogue with this id.
///
/// # Errors
/// There is none; which was meant.
pub fn find_motor<'c>(catalog: &'c Catalog, id: &str) -> Result<&'c Motor, Failure> {
    catalog.motor(id).map_err(|near| {
        let help = match (catalog.near(id).as_slice(), near) {
            ([], None) => "`gearwise catalog list` lists them, and `--also` adds a catalogue of your own".to_string(),
            ([], Some(near)) => format!("did you mean `{near}`?"),
            (some, _) => {
                format!("did you mean {}?", some.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(" or "))
            }
        };
        Failure::Argument(format!("there is no motor `{id}` in the catalogue; {help}"))
    })
}
