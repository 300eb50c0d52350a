//! Every motor at every ratio.

use self_cell::self_cell;
use serde_json::Value;

use super::rows::{Rows, wound};
use super::{Answer, Failure, Ground, Watch, balanced, settled};
use crate::actuator::metrics::METRICS;
use crate::catalog::Catalog;
use crate::design::answer::JointSweep;
use crate::design::options::Options;
use crate::design::sweep::sweep_with;
use crate::input::{InputFile, limits};
use crate::report::html::Page;
use crate::report::plot::{Figure, sweep as plot};
use crate::report::sweep::{self as report, Order};
use crate::report::{html, json, table};
use crate::requirement::{Joint, Quantity, RatioChoice, Robot};
use crate::words::nearest;

/// How many ratios are tried where nobody says.
pub const RATIOS: usize = 25;
/// How many designs of a joint the text shows where nobody says.
pub const TOP: usize = 10;

type Sweeps<'a> = Vec<JointSweep<'a>>;

self_cell!(
    struct Cell {
        owner: Ground,
        #[covariant]
        dependent: Sweeps,
    }
    impl {Debug}
);

/// What is swept.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// How many ratios, evenly spaced in ln N, where the ratio is continuous.
    pub ratios: usize,
    /// In which order designs are shown.
    pub order: Order,
    /// The first so many gears of each motor alone; `None` for all.
    pub gears_per_motor: Option<usize>,
}

/// Every motor at every ratio, at each joint.
#[derive(Debug)]
pub struct Swept {
    cell: Cell,
    asked: Asked,
    /// How many designs were left out.
    left_out: usize,
}

/// An order by its name.
///
/// # Errors
/// The nearest that there is, in words.
pub fn order(name: &str) -> Result<Order, String> {
    match name {
        "objective" => return Ok(Order::Objective),
        "margin" => return Ok(Order::Margin),
        _ => {}
    }
    // A motor's mass is a metric too; in a sweep the design's mass is meant.
    if let Some((_, quantity)) = Quantity::NAMES.iter().find(|(n, _)| *n == name) {
        return Ok(Order::Quantity(*quantity));
    }
    METRICS.iter().find(|m| m.name == name).map(Order::Metric).ok_or_else(|| {
        let names = ["objective", "margin"]
            .into_iter()
            .chain(Quantity::NAMES.iter().map(|(n, _)| *n))
            .chain(METRICS.iter().map(|m| m.name));
        unknown_order(name, names)
    })
}

/// That an order does not exist, with the nearest that does.
pub(super) fn unknown_order<'a>(name: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    let help = match nearest(name, names.clone()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("there are: {}", names.collect::<Vec<_>>().join(", ")),
    };
    format!("`{name}` is not an order; {help}")
}

/// Sweeps; `begin` hears of how many steps there are.
///
/// # Errors
/// Patterns that name nothing, what does not go together, that it was stopped.
pub fn sweep(robot: Robot, rows: &Rows, asked: Asked, watch: impl FnOnce(usize) -> Watch) -> Result<Swept, Failure> {
    let catalog = rows.for_robot(&robot)?;
    let robot = settled(robot, &catalog)?;
    let mut robot = balanced(&robot, &catalog, Options::default())?;
    let catalog = wound(&mut robot, catalog, false)?;
    let geared = |joint: &Joint| matches!(joint.ratio, RatioChoice::Catalog { .. });
    if asked.gears_per_motor.is_some() && !robot.joints.iter().any(geared) {
        let why = "`--gears-per-motor`: no joint of the requirement takes gears of the catalogue";
        return Err(Failure::Argument(why.into()));
    }
    check_size(&robot, &catalog, asked.ratios)?;
    let watch = watch(robot.joints.len() * catalog.motors.len());
    let ground = Ground { robot, catalog, watch };
    let mut left_out = 0;
    let cell = Cell::try_new(ground, |ground| {
        let options = ground.watch.options(false);
        let mut sweeps = sweep_with(&ground.robot, &ground.catalog, asked.ratios, options)?;
        if let Some(most) = asked.gears_per_motor {
            let geared = sweeps.iter_mut().filter(|s| geared(s.joint));
            left_out = geared.map(|s| report::first_gears(s, asked.order, most)).sum();
        }
        Ok::<_, Failure>(sweeps)
    })?;
    Ok(Swept { cell, asked, left_out })
}

/// Refuse a sweep whose designs would not fit into memory; only a continuous ratio is swept as finely as is asked for.
fn check_size(robot: &Robot, catalog: &Catalog, ratios: usize) -> Result<(), Failure> {
    let motors = |joint: &Joint| catalog.motors.iter().filter(|m| !joint.motors.pass_over(m)).count();
    let is_continuous = |joint: &&Joint| matches!(joint.ratio, RatioChoice::Continuous { .. });
    let pairs: usize = robot.joints.iter().filter(is_continuous).map(motors).sum();
    let designs = pairs.saturating_mul(ratios);
    if designs <= limits::SWEPT_DESIGNS {
        return Ok(());
    }
    let message = limits::too_many("designs of this sweep", designs, limits::SWEPT_DESIGNS);
    Err(Failure::Argument(format!(
        "`--ratios`: {message}; for these joints and motors at most {} ratios",
        limits::SWEPT_DESIGNS / pairs
    )))
}

impl Swept {
    /// Each joint.
    pub fn sweeps(&self) -> &[JointSweep<'_>] {
        self.cell.borrow_dependent()
    }

    /// The text with so many designs of each joint, those that cannot do it too where they are wanted.
    pub fn text_of(&self, top: usize, infeasible: bool) -> String {
        let ground = self.cell.borrow_owner();
        let fewer = match (self.left_out, self.asked.gears_per_motor) {
            (left_out @ 1.., Some(most)) => {
                let line = format!("Only the first {most} of each motor's gears: {left_out} designs are left out.");
                format!("\n{}", table::paragraph(&line, 0, 2))
            }
            _ => String::new(),
        };
        let text = report::text(&ground.robot, self.sweeps(), self.asked.order, top, infeasible);
        ground.told_set() + &text + &fewer
    }
}

impl Answer for Swept {
    fn is_satisfied(&self) -> bool {
        self.sweeps().iter().all(|s| s.designs.iter().any(|d| d.is_choice()))
    }

    fn json(&self) -> Value {
        json::sweep::json(&self.cell.borrow_owner().robot, self.sweeps(), self.asked.order)
    }

    fn csv(&self) -> String {
        report::csv(self.sweeps(), self.asked.order)
    }

    fn text(&self) -> String {
        self.text_of(TOP, false)
    }

    fn page(&self) -> Page {
        html::sweep::page(&self.cell.borrow_owner().robot, self.sweeps(), self.asked.order)
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::figure(self.sweeps()))
    }

    fn files(&self) -> Vec<InputFile> {
        self.cell.borrow_owner().files()
    }
}
