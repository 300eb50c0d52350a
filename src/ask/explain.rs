//! The whole story of one motor at a joint.

use self_cell::self_cell;
use serde_json::Value;

use super::chosen::{self, Chosen};
use super::rows::Rows;
use super::{Answer, Failure, Ground, Watch, balanced, settled};
use crate::design::explain::{Explanation, explain as story};
use crate::design::options::Options;
use crate::input::InputFile;
use crate::report::explain as report;
use crate::report::html::Page;
use crate::report::plot::{Figure, design as plot};
use crate::report::{html, json};
use crate::requirement::Robot;

self_cell!(
    struct Cell {
        owner: Ground,
        #[covariant]
        dependent: Explanation,
    }
    impl {Debug}
);

/// The story of a motor at a joint.
#[derive(Debug)]
pub struct Explained {
    cell: Cell,
}

/// Explains `design` (`MOTOR`, `MOTOR@RATIO`, `MOTOR@GEAR`) at a joint, which may be left out where there is only one.
///
/// # Errors
/// A motor, a gear or a joint that is not there; why the motor is no candidate.
pub fn explain(robot: Robot, rows: &Rows, design: &str, joint: Option<&str>) -> Result<Explained, Failure> {
    let catalog = rows.with_named(&robot, std::iter::once(chosen::id(design)));
    let robot = settled(robot, &catalog)?;
    let robot = balanced(&robot, &catalog, Options::default())?;
    let ground = Ground { robot, catalog, watch: Watch::default() };
    let cell = Cell::try_new(ground, |ground| {
        let joint = chosen::joint(&ground.robot, joint)?;
        let Chosen { motor, gear, ratio } = chosen::design(design, joint, &ground.catalog)?;
        story(&ground.robot, joint, motor, gear, ratio).map_err(|why| {
            Failure::Argument(format!("{} cannot be explained at this joint: {}", motor.id, why.reason()))
        })
    })?;
    Ok(Explained { cell })
}

impl Explained {
    /// The story.
    pub fn story(&self) -> &Explanation<'_> {
        self.cell.borrow_dependent()
    }

    fn robot(&self) -> &Robot {
        &self.cell.borrow_owner().robot
    }
}

impl Answer for Explained {
    fn is_satisfied(&self) -> bool {
        self.story().is_choice()
    }

    fn json(&self) -> Value {
        json::explain::json(self.robot(), self.story())
    }

    fn csv(&self) -> String {
        String::new()
    }

    fn text(&self) -> String {
        self.cell.borrow_owner().told_set() + &report::text(self.story())
    }

    fn page(&self) -> Page {
        html::explain::page(self.robot(), self.story())
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::explained(self.robot(), self.story()))
    }

    fn files(&self) -> Vec<InputFile> {
        self.cell.borrow_owner().files()
    }
}
