//! Motors at given ratios, as arrays: for whoever searches by himself.

use std::sync::Arc;

use rayon::prelude::*;

use super::rows::{Rows, find_motor};
use super::{Failure, Watch, balanced, chosen, settled};
use crate::actuator::limits::{LIMITS, Remark};
use crate::catalog::{Catalog, Motor};
use crate::design::judge::unjudged;
use crate::design::{Evaluation, JointDemand, Mount, Prepared};
use crate::requirement::{Joint, RatioChoice, Robot};
use crate::words::nearest;

/// Which limits are looked at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Which {
    /// All.
    All,
    /// All but temperature over the motion, which takes the longest by far.
    Instant,
    /// Those of these names.
    Named(Vec<String>),
}

/// The limit that follows temperature over the motion, and what is said of heat beside it.
const OVER_TIME: [&str; 2] = ["winding_peak_temperature", "drag_heat"];

impl Which {
    fn has(&self, name: &str) -> bool {
        match self {
            Which::All => true,
            Which::Instant => !OVER_TIME.contains(&name),
            Which::Named(names) => names.iter().any(|n| n == name),
        }
    }

    /// That every name is one of a limit.
    fn check(&self) -> Result<(), Failure> {
        let Which::Named(names) = self else { return Ok(()) };
        let all = || LIMITS.iter().map(|limit| limit.name);
        match names.iter().find(|name| all().all(|limit| limit != **name)) {
            None => Ok(()),
            Some(wrong) => {
                let help = nearest(wrong, all().chain(["all", "instant"])).map_or_else(
                    || format!("there are: {}", all().collect::<Vec<_>>().join(", ")),
                    |near| format!("did you mean `{near}`?"),
                );
                Err(Failure::Argument(format!("`{wrong}` is not a limit; {help}")))
            }
        }
    }
}

/// Designs as arrays over (motor, ratio), the ratio fastest. What is not known is NaN.
#[derive(Debug, Clone, Default)]
pub struct Evaluated {
    /// Ids of the motors.
    pub motors: Vec<String>,
    /// Ratios, N.
    pub ratio: Vec<f64>,
    /// Motors that cannot be evaluated, with the reason; all their numbers are NaN.
    pub unusable: Vec<(String, String)>,
    /// What of its losses nobody knows, for each motor, in words: the loss has none of it.
    pub unknown_losses: Vec<Vec<&'static str>>,
    /// Whether the ratio is allowed and every limit that was looked at and could be checked is kept.
    pub feasible: Vec<bool>,
    /// Whether every limit that the requirement states, of those that were looked at, could be judged: a design is a choice
    /// where it is feasible and judged.
    pub judged: Vec<bool>,
    /// Mean of all losses \[W\].
    pub loss: Vec<f64>,
    /// Derivative of the loss by the ratio \[W\]; NaN where the motor has effects that have no derivative in closed form.
    pub loss_slope: Vec<f64>,
    /// Largest q-axis current \[A\].
    pub peak_current: Vec<f64>,
    /// Root mean square of the q-axis current \[A\].
    pub rms_current: Vec<f64>,
    /// Mean electrical power at the motor's terminals \[W\].
    pub mean_electrical_power: Vec<f64>,
    /// Inertia at the output \[kg·m²\].
    pub reflected_inertia: Vec<f64>,
    /// Mass of motor and gear \[kg\].
    pub mass: Vec<f64>,
    /// The joint's objective, in its own unit.
    pub objective: Vec<f64>,
    /// Names of the limits, the third axis of the next two.
    pub limits: Vec<&'static str>,
    /// `1 − demand/bound` over (motor, ratio, limit); NaN where a limit is not asked, or could not be checked.
    pub margin: Vec<f64>,
    /// The sample of the motion that asks most of the limit; −1 where none does.
    pub sample: Vec<i64>,
}

/// What is evaluated.
#[derive(Debug, Clone)]
pub struct Asked {
    /// Ids of motors; `None` for all that the joint allows.
    pub motors: Option<Vec<String>>,
    /// Ratios, N.
    pub ratios: Vec<f64>,
    /// The joint; may be left out where there is only one.
    pub joint: Option<String>,
    /// Limits that are looked at.
    pub limits: Which,
}

/// Evaluates motors at ratios.
///
/// # Errors
/// Motors, joints and limits that are not there; ratios that are none; a joint that takes gears of the catalogue.
pub fn evaluate(robot: &Robot, rows: &Rows, asked: &Asked, watch: &Watch) -> Result<Evaluated, Failure> {
    asked.limits.check()?;
    check_ratios(&asked.ratios)?;
    let (robot, catalog) = ready(robot, rows, asked)?;
    let joint = chosen::joint(&robot, asked.joint.as_deref())?;
    if matches!(joint.ratio, RatioChoice::Catalog { .. }) {
        let why = format!(
            "joint `{}` takes gears of the catalogue, so that its ratios are theirs: `sweep` has each of them",
            joint.name
        );
        return Err(Failure::Argument(why));
    }
    let motors = motors(&catalog, asked.motors.as_deref(), joint)?;
    let demand = JointDemand::new(joint, &catalog);
    let of_motor = |motor: &&Motor| -> Result<Row, Failure> {
        if (watch.stop)() {
            return Err(crate::design::options::Stopped.into());
        }
        let prepared = Mount::new(&robot, joint, &demand.load, motor).prepared();
        let row = Row::new(prepared.map_err(|why| why.reason().to_string()), &robot, joint, asked);
        (watch.tick)();
        Ok(row)
    };
    let rows: Vec<Row> = match motors.len() {
        1 => motors.iter().map(of_motor).collect::<Result<_, _>>()?,
        _ => motors.par_iter().map(of_motor).collect::<Result<_, _>>()?,
    };
    Ok(gather(&motors, rows, asked))
}

/// That ratios are numbers above zero, and that there are some.
pub(super) fn check_ratios(ratios: &[f64]) -> Result<(), Failure> {
    if ratios.is_empty() {
        return Err(Failure::Argument("there is no ratio to look at".into()));
    }
    match ratios.iter().find(|n| !(1e-6..=1e6).contains(*n)) {
        Some(wrong) => Err(Failure::Argument(format!("{wrong} is not a ratio: expected numbers from 1e-6 to 1e6"))),
        None => Ok(()),
    }
}

/// The robot and the catalogue made ready for each other.
fn ready(robot: &Robot, rows: &Rows, asked: &Asked) -> Result<(Robot, Arc<Catalog>), Failure> {
    let catalog = rows.for_motors(robot, asked.motors.as_deref())?;
    let robot = settled(robot.clone(), &catalog)?;
    let robot = balanced(&robot, &catalog, crate::design::Options::default())?;
    Ok((robot, catalog))
}

/// The motors that are asked for.
pub(super) fn motors<'c>(
    catalog: &'c Catalog,
    ids: Option<&[String]>,
    joint: &Joint,
) -> Result<Vec<&'c Motor>, Failure> {
    let found: Vec<&Motor> = match ids {
        Some(ids) => ids.iter().map(|id| find_motor(catalog, id)).collect::<Result<_, _>>()?,
        None => catalog.motors.iter().filter(|motor| joint.motors.allows(motor)).collect(),
    };
    match found.is_empty() {
        true => Err(Failure::Argument("there is no motor to look at".into())),
        false => Ok(found),
    }
}

/// A motor at all ratios.
struct Row {
    unusable: Option<String>,
    unknown_losses: Vec<&'static str>,
    /// The limits that its margins are of, in the order of [`LIMITS`].
    limits: Vec<&'static str>,
    at: Vec<At>,
    /// Margin and sample of each limit at each ratio, the limit fastest.
    margins: Vec<(f64, i64)>,
}

/// A motor at a ratio.
struct At {
    feasible: bool,
    judged: bool,
    figures: [f64; FIGURES],
}

/// Numbers of a design.
const FIGURES: usize = 8;

/// A margin that is not known, of no sample.
const NO_MARGIN: (f64, i64) = (f64::NAN, -1);

impl Row {
    fn unusable(why: String) -> Row {
        Row { unusable: Some(why), unknown_losses: Vec::new(), limits: Vec::new(), at: Vec::new(), margins: Vec::new() }
    }

    fn new(prepared: Result<Prepared, String>, robot: &Robot, joint: &Joint, asked: &Asked) -> Row {
        let mut prepared = match prepared {
            Ok(prepared) => prepared,
            Err(why) => return Row::unusable(why),
        };
        prepared.asked.retain(|limit| asked.limits.has(limit.limit.name));
        let is_asked = |name: &&str| prepared.asked.iter().any(|limit| limit.limit.name == *name);
        let limits: Vec<&'static str> = LIMITS.iter().map(|limit| limit.name).filter(is_asked).collect();
        let fixed = prepared.candidate.catalog_gear.map(|gear| gear.ratio);
        let judged = |unchecked: Vec<Remark>| {
            let looked: Vec<Remark> = unchecked.into_iter().filter(|(name, _)| asked.limits.has(name)).collect();
            unjudged(robot, joint, &looked).is_empty()
        };
        // What can be judged at some ratios only takes long to judge: not where nobody looks at it.
        let goes_with_ratio = prepared.judged_at_ratio().any(|name| asked.limits.has(name));
        let anywhere = judged(prepared.judged_anywhere().unchecked);
        let mut unknown_losses = Vec::new();
        let mut margins = Vec::with_capacity(limits.len() * asked.ratios.len());
        let mut at = Vec::with_capacity(asked.ratios.len());
        for (k, &ratio) in asked.ratios.iter().enumerate() {
            // A module has the ratio of its gear alone.
            let allowed = match fixed {
                Some(own) => (ratio / own - 1.0).abs() < 1e-9,
                None => joint.ratio.allows(ratio),
            };
            let judged = if goes_with_ratio { judged(prepared.unchecked_at(ratio)) } else { anywhere };
            let evaluation = prepared.at(ratio);
            if k == 0 {
                unknown_losses = evaluation.unknown_losses.iter().map(|part| part.words()).collect();
            }
            let slope = prepared.loss_slope(ratio).unwrap_or(f64::NAN);
            let figures = figures(&evaluation, joint, slope);
            at.push(At { feasible: evaluation.feasible && allowed, judged, figures });
            margins.extend(limits.iter().map(|name| least(&evaluation, name)));
        }
        Row { unusable: None, unknown_losses, limits, at, margins }
    }
}

/// The numbers of a design, in the order of [`Evaluated::figures`].
fn figures(e: &Evaluation, joint: &Joint, slope: f64) -> [f64; FIGURES] {
    [
        e.loss,
        slope,
        e.peak_current,
        e.rms_current,
        e.mean_power,
        e.reflected_inertia,
        e.mass.unwrap_or(f64::NAN),
        e.objective(&joint.objective).unwrap_or(f64::NAN),
    ]
}

/// Margin and sample of a limit.
fn least(evaluation: &Evaluation, name: &str) -> (f64, i64) {
    let least = evaluation.least(name);
    least.map_or(NO_MARGIN, |least| (least.margin, least.sample.map_or(-1, |k| k as i64)))
}

fn gather(motors: &[&Motor], rows: Vec<Row>, asked: &Asked) -> Evaluated {
    let is_of = |name: &&str| rows.iter().any(|row| row.limits.contains(name));
    let limits: Vec<&'static str> = LIMITS.iter().map(|limit| limit.name).filter(is_of).collect();
    let mut all = Evaluated { ratio: asked.ratios.clone(), limits, ..Evaluated::default() };
    let designs = motors.len() * asked.ratios.len();
    all.figures().into_iter().for_each(|figure| figure.reserve_exact(designs));
    all.margin.reserve_exact(designs * all.limits.len());
    all.sample.reserve_exact(designs * all.limits.len());
    for (motor, row) in motors.iter().zip(rows) {
        all.motors.push(motor.id.clone());
        all.push(&row, asked.ratios.len());
        all.unknown_losses.push(row.unknown_losses);
        all.unusable.extend(row.unusable.map(|why| (motor.id.clone(), why)));
    }
    all
}

impl Evaluated {
    fn figures(&mut self) -> [&mut Vec<f64>; FIGURES] {
        [
            &mut self.loss,
            &mut self.loss_slope,
            &mut self.peak_current,
            &mut self.rms_current,
            &mut self.mean_electrical_power,
            &mut self.reflected_inertia,
            &mut self.mass,
            &mut self.objective,
        ]
    }

    /// Adds a motor at so many ratios.
    fn push(&mut self, row: &Row, ratios: usize) {
        // Where the row's own limits are; none of a motor that cannot be used.
        let own = |name: &&'static str| row.limits.iter().position(|limit| limit == name);
        let places: Vec<Option<usize>> = self.limits.iter().map(own).collect();
        for k in 0..ratios {
            let at = row.at.get(k);
            self.feasible.push(at.is_some_and(|at| at.feasible));
            self.judged.push(at.is_some_and(|at| at.judged));
            let values = at.map_or([f64::NAN; FIGURES], |at| at.figures);
            self.figures().into_iter().zip(values).for_each(|(figure, value)| figure.push(value));
            for place in &places {
                let (margin, sample) = place.map_or(NO_MARGIN, |place| row.margins[k * row.limits.len() + place]);
                self.margin.push(margin);
                self.sample.push(sample);
            }
        }
    }
}
