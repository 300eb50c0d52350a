//! The best motors and ratios of each joint.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use self_cell::self_cell;
use serde_json::Value;

use super::rows::{Rows, wound};
pub use super::written::Names;
use super::written::{DesignText, Ruled};
use super::{Answer, Failure, Ground, Watch, balanced, settled};
use crate::catalog::Catalog;
use crate::design::answer::{Design, JointResult, Rejected, RobotResult};
use crate::design::many::{Looked, with_exceeded, with_samples};
use crate::design::mount::{JointDemand, Site};
use crate::design::optimize::optimize_with;
use crate::design::options::Options;
use crate::design::outlook::{Outlook, outlooks};
use crate::design::robot::{Choice, choose};
use crate::input::InputFile;
use crate::numerics::grid::grid;
use crate::report::design_file::{self, Written};
use crate::report::html::Page;
use crate::report::optimize::{self as report, Shown};
use crate::report::plot::{Figure, design as plot};
use crate::report::{html, json, number, robot as robot_report, table};
use crate::requirement::Robot;

/// Ratios at which a motor that cannot do it is looked at.
const LOOKS: usize = 40;

/// How many motors a joint's table shows where nobody says.
pub const TOP: usize = 5;

/// How the choice is made.
#[derive(Debug, Clone, Default)]
pub struct Asked {
    /// Reject designs with a limit that cannot be checked.
    pub only_checked: bool,
    /// Only so many designs of each joint.
    pub keep: Option<usize>,
    /// The best combination for the whole robot, even where nothing couples the joints.
    pub whole: bool,
    /// How many further combinations of the whole robot.
    pub runner_ups: usize,
    /// Designs between the lightest and the least loss too.
    pub with_front: bool,
    /// The rules that are kept.
    pub rules: Rules,
    /// The design file that is made, where one is.
    pub design: Option<PathBuf>,
    /// Whether it is also said what rules cost a whole robot.
    pub with_costs: bool,
    /// What ends the search over the whole robot.
    pub time_limit: Option<Duration>,
    /// One joint alone, by its place: neither the whole robot nor what lies around the choice is looked at, and of rules those
    /// that bound a limit are kept.
    pub joint: Option<usize>,
}

/// Which rules a choice has to keep.
#[derive(Debug, Clone, Default)]
pub enum Rules {
    /// Those that the requirement names.
    #[default]
    OfRequirement,
    /// Those of a file.
    File(PathBuf),
    /// None.
    None,
}

/// A robot and a catalogue that were made ready for each other.
#[derive(Debug)]
pub struct Ready {
    /// The robot without rules.
    plain: Robot,
    /// The robot with the limits that rules add.
    ruled: Ruled,
    /// The catalogue.
    catalog: Arc<Catalog>,
}

impl Ready {
    /// Makes a robot and the rows of a catalogue ready. `one_by_one`: what is asked for does not go with a range of turns.
    ///
    /// # Errors
    /// Mistakes in rules, patterns that name nothing, what does not go together.
    pub fn new(robot: Robot, rows: &Rows, asked: &Asked, one_by_one: bool, watch: &Watch) -> Result<Ready, Failure> {
        let catalog = rows.for_robot(&robot)?;
        Ready::of(robot, catalog, asked, one_by_one, watch)
    }

    /// The same with the catalogue that is chosen from.
    ///
    /// # Errors
    /// As [`Ready::new`].
    pub fn of(
        robot: Robot,
        catalog: Arc<Catalog>,
        asked: &Asked,
        one_by_one: bool,
        watch: &Watch,
    ) -> Result<Ready, Failure> {
        let plain = settled(robot, &catalog)?;
        let (file, none) = match &asked.rules {
            Rules::OfRequirement => (None, false),
            Rules::File(path) => (Some(path.as_path()), false),
            Rules::None => (None, true),
        };
        let mut ruled = Ruled::new(plain.clone(), file, asked.design.is_some(), none)?;
        let options = Options { tick: &|| (), joint: asked.joint, ..watch.options(asked.only_checked) };
        ruled.robot = balanced(&ruled.robot, &catalog, options)?;
        if ruled.robot.has_range_of_turns() && one_by_one {
            let message = "a range of `turns` is not combined with `--pareto`, `--robust` or `--robot` (a front, tolerances, the choice for a whole robot); give a list, as in turns = [1, 0.5]";
            return Err(Failure::Argument(message.into()));
        }
        let catalog = wound(&mut ruled.robot, catalog, asked.only_checked)?;
        Ok(Ready { plain, ruled, catalog })
    }

    /// The robot and the catalogue, for searches that know no rules beyond the limits that they add.
    pub(super) fn ground(self, watch: Watch) -> Ground {
        Ground { robot: self.ruled.robot, catalog: self.catalog, watch }
    }

    /// How many steps the search has: motors at joints.
    pub fn steps(&self) -> usize {
        self.ruled.robot.joints.len() * self.motors()
    }

    /// How many motors are looked at for each joint.
    pub fn motors(&self) -> usize {
        self.catalog.motors.len()
    }

    /// The robot with the limits that rules add.
    pub fn robot(&self) -> &Robot {
        &self.ruled.robot
    }
}

/// What was found.
#[derive(Debug)]
pub struct Found<'a> {
    /// Each joint.
    pub result: RobotResult<'a>,
    /// What is said of each joint's first choice.
    pub outlooks: Vec<Outlook<'a>>,
    /// The whole robot, where joints are coupled or it was asked for.
    pub choice: Option<Choice<'a>>,
    /// The design file that keeps the rules; `None` where none was asked for, or a joint has no design.
    pub design: Result<Option<DesignText>, String>,
    /// What the rules cost each joint.
    costs: Vec<String>,
    /// What they cost the whole robot.
    costs_of_robot: Option<String>,
    /// How long the whole robot took, where that was limited.
    took: Option<Duration>,
}

self_cell!(
    struct Cell {
        owner: Ground,
        #[covariant]
        dependent: Found,
    }
    impl {Debug}
);

/// The choice for each joint of a robot.
#[derive(Debug)]
pub struct Optimized {
    cell: Cell,
    /// Joints with so many samples that the search looked at some of them.
    looked: Vec<Looked>,
    /// How many motors the text shows of a joint.
    top: usize,
}

/// Chooses.
///
/// # Errors
/// It was stopped, or the joints' objectives cannot be summed up.
pub fn optimize(ready: Ready, asked: &Asked, names: Names, watch: Watch) -> Result<Optimized, Failure> {
    let Ready { plain, ruled, catalog } = ready;
    let options = Options { keep: asked.keep, joint: asked.joint, ..watch.options(asked.only_checked) };
    let (robot, mut looked) = with_samples(ruled.robot.clone(), &catalog, options)?;
    let mut ground = Ground { robot, catalog, watch };
    let cell = loop {
        let found = Cell::try_new_or_recover(ground, |ground| find(ground, &mut looked, &plain, &ruled, asked, names));
        match found {
            Ok(cell) => break cell,
            Err((before, Unfound::Exceeds(robot))) => ground = Ground { robot: *robot, ..before },
            Err((_, Unfound::Failed(why))) => return Err(why),
        }
    };
    Ok(Optimized { cell, looked, top: asked.keep.unwrap_or(TOP) })
}

/// Reasons for a search without an answer.
enum Unfound {
    Failed(Failure),
    /// The robot with further samples, at which designs of this search exceed a limit.
    Exceeds(Box<Robot>),
}

impl<E: Into<Failure>> From<E> for Unfound {
    fn from(why: E) -> Unfound {
        Unfound::Failed(why.into())
    }
}

fn find<'a>(
    ground: &'a Ground,
    looked: &mut [Looked],
    plain: &Robot,
    ruled: &Ruled,
    asked: &Asked,
    names: Names,
) -> Result<Found<'a>, Unfound> {
    let Ground { robot, catalog, watch } = ground;
    let catalog: &Catalog = catalog;
    let search = Options { joint: asked.joint, ..watch.options(asked.only_checked) };
    let mut result = optimize_with(robot, catalog, Options { keep: asked.keep, ..search })?;
    let search = Options { tick: &|| (), ..search };
    if let Some(more) = with_exceeded(&result, looked, catalog, search)? {
        return Err(Unfound::Exceeds(Box::new(more)));
    }
    let target = asked.design.as_deref();
    let whole = asked.joint.is_none() && (robot.is_coupled() || asked.whole);
    let ground = (plain, catalog);
    // Rules that are no limit of the program are looked at on the first designs, and the next are tried.
    let looked_at = !whole && asked.joint.is_none();
    let design = match looked_at && (ruled.keeps() || target.is_some()) {
        true => ruled.keep(&mut result, names, ground, target),
        false => Ok(None),
    };
    let outlooks = match asked.joint {
        None => outlooks(&result, catalog, asked.with_front, search)?,
        Some(_) => Vec::new(),
    };
    let begun = Instant::now();
    let options = watch.of_robot(asked.only_checked, asked.runner_ups);
    let choice = whole.then(|| choose(robot, catalog, options)).transpose()?;
    let took = asked.time_limit.map(|_| begun.elapsed());
    let told = choice.as_ref().filter(|_| asked.with_costs);
    let costs_of_robot = told.map(|whole| ruled.cost_of_robot(plain, catalog, whole, options)).transpose()?.flatten();
    let design = match (&choice, target) {
        (Some(whole), Some(path)) => ruled.whole(&result, whole, names, ground, path).map(Some),
        _ => design,
    };
    let by_default = matches!(asked.rules, Rules::OfRequirement) && !ruled.keeps() && asked.joint.is_none();
    let costs = match (asked.with_costs, &choice) {
        (true, Some(whole)) if by_default => {
            Ruled::other_combination(&result, whole, names, ground, (search, options))?
        }
        (true, _) if by_default => Ruled::other_designs(&result, names, ground, search)?,
        (true, _) => ruled.costs(plain, catalog, &result, search)?,
        (false, _) => Vec::new(),
    };
    Ok(Found { result, outlooks, choice, design, costs, costs_of_robot, took })
}

impl Optimized {
    /// What was found.
    pub fn found(&self) -> &Found<'_> {
        self.cell.borrow_dependent()
    }

    /// The robot, made ready.
    pub fn robot(&self) -> &Robot {
        &self.cell.borrow_owner().robot
    }

    /// The catalogue that was chosen from.
    pub fn catalog(&self) -> &Catalog {
        &self.cell.borrow_owner().catalog
    }

    /// Of joints with very many samples, how they were looked at, in sentences.
    pub fn looked_at(&self) -> impl Iterator<Item = String> + '_ {
        self.looked.iter().map(|Looked { joint, at, of, rounds }| {
            let added = match rounds {
                0 => String::new(),
                1 => ", after others were added once".into(),
                more => format!(", after others were added {more} times"),
            };
            format!(
                "joint `{joint}`: the search looked at limits at {at} of {of} samples{added}; every design that is shown keeps them at all, and so do its windows where they were looked at; means and heat are of all"
            )
        })
    }

    /// The first choices, or the best combination where the whole robot was looked at, as the text of a design file: at the ratios that
    /// were found. The names are in it as they are.
    ///
    /// # Errors
    /// A joint without a design.
    pub fn design_text(&self, requirement: &Path) -> Result<String, Failure> {
        let result = &self.found().result;
        let each = result.joints.iter().enumerate().map(|(k, of)| match self.chosen(k) {
            Some(design) => Ok((design, None)),
            None => Err(Failure::Argument(format!("joint `{}` has no design", of.joint.name))),
        });
        let designs = each.collect::<Result<_, _>>()?;
        let what = "First choices";
        Ok(design_file::toml(&Written { result, what, designs, requirement, catalog: &[], rules: None }))
    }

    /// What was chosen for a joint, by its place: of the best combination where the whole robot was looked at, else the first.
    pub fn chosen(&self, joint: usize) -> Option<&Design<'_>> {
        let found = self.found();
        match &found.choice {
            Some(whole) => whole.combinations.first().and_then(|best| best.joints.get(joint)),
            None => found.result.joints.get(joint)?.candidates.first(),
        }
    }

    /// What the JSON says of one candidate of a joint, by their places; `None` where there is none.
    pub fn design_json(&self, joint: usize, place: usize) -> Option<Value> {
        let of = self.found().result.joints.get(joint)?;
        let design = of.candidates.get(place)?;
        Some(json::value(json::Design::new(design.facts(), of.joint)))
    }

    /// Of a joint without a design: that there is none, and which motor came nearest, with what it exceeds.
    pub fn without(&self, joint: usize) -> Option<String> {
        let of = self.found().result.joints.get(joint).filter(|of| of.candidates.is_empty())?;
        let alone = RobotResult { robot: self.robot(), joints: vec![of.clone()] };
        let said = report::without_choice(&alone, "no").join("; ");
        Some(self.nearest_miss(of).map_or(said.clone(), |near| format!("{said}; {near}")))
    }

    /// The motor that comes nearest to the limits of a joint, at the ratio where it does, in words.
    fn nearest_miss<'a>(&'a self, of: &'a JointResult<'a>) -> Option<String> {
        let demand = JointDemand::new(of.joint, self.catalog());
        let site = Site::new(self.robot(), of.joint, &demand);
        let miss = |rejected: &'a Rejected<'a>| {
            let mount = site.mount(rejected.motor, rejected.gear).ok()?;
            let (least, most) = mount.range()?;
            let prepared = mount.prepared().ok()?;
            let worst = |ratio: f64| {
                let margins = prepared.at(ratio).margins;
                let worst = margins.into_iter().min_by(|a, b| a.margin.total_cmp(&b.margin))?;
                Some((worst.margin, worst.limit, ratio))
            };
            let ratios = if least < most { grid(least, most, LOOKS) } else { vec![least] };
            let best = ratios.into_iter().filter_map(worst).max_by(|a, b| a.0.total_cmp(&b.0))?;
            Some((best, rejected.motor.id.as_str(), rejected.gear))
        };
        let all: Vec<_> = of.rejected.par_iter().filter_map(miss).collect();
        let nearest = all.into_iter().filter(|((margin, ..), ..)| *margin < 0.0);
        let ((margin, limit, ratio), motor, gear) = nearest.max_by(|a, b| a.0.0.total_cmp(&b.0.0))?;
        let with = gear.map_or_else(|| format!("at N = {}", number(ratio)), |gear| format!("with {gear}"));
        let over = match margin.is_finite() {
            true => format!("exceeds `{limit}` by {} %", number((-1e3 * margin).round() / 10.0)),
            false => format!("exceeds `{limit}`"),
        };
        Some(format!("the nearest, {motor} {with}, {over}"))
    }

    /// The text, with why the first designs are the best, why the others are not, or all columns.
    pub fn text_with(&self, why: bool, rejected: bool, full: bool) -> String {
        self.text_of(Shown { top: self.top, rejected, why, full: full || self.top != TOP })
    }

    /// The text, with as much of it as is wanted.
    pub fn text_of(&self, shown: Shown) -> String {
        let found = self.found();
        let mut whole =
            found.choice.as_ref().map_or_else(String::new, |c| format!("\n{}", robot_report::text(c, found.took)));
        if let Some(cost) = &found.costs_of_robot {
            whole.push_str(&format!("\n{}", table::paragraph(cost, 0, 2)));
        }
        let text = report::text(&found.result, &found.outlooks, &found.costs, shown);
        self.cell.borrow_owner().told_set() + &text + &whole
    }
}

impl Answer for Optimized {
    fn is_satisfied(&self) -> bool {
        let found = self.found();
        let kept = found.design.is_ok();
        kept && found.choice.as_ref().map_or_else(|| found.result.satisfied(), |c| !c.combinations.is_empty())
    }

    fn json(&self) -> Value {
        let found = self.found();
        json::optimize::json(&found.result, &found.outlooks, found.choice.as_ref())
    }

    fn csv(&self) -> String {
        report::csv(&self.found().result)
    }

    fn text(&self) -> String {
        self.text_with(false, false, false)
    }

    fn page(&self) -> Page {
        let found = self.found();
        html::optimize::page(&found.result, &found.outlooks, found.choice.as_ref(), self.catalog())
    }

    fn figure(&self) -> Option<Figure> {
        Some(plot::optimized(&self.found().result, self.catalog()))
    }

    fn files(&self) -> Vec<InputFile> {
        self.cell.borrow_owner().files()
    }

    fn remarks(&self) -> Vec<String> {
        let broken = self.found().design.as_ref().err();
        broken.into_iter().cloned().chain(self.looked_at()).collect()
    }
}
