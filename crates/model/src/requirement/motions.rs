//! Where the motion of a joint comes from: a file, or operating points.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::input::{InputError, Key, Problem, Range, Section, Source, key};
use crate::motion::{self, CarriedColumn, Motion, Point};
use crate::transmission::read::Files;
use crate::units;

/// Where motions come from: [`FromDisk`], or a store that has read them before.
pub trait Motions {
    /// The file.
    ///
    /// # Errors
    /// It cannot be read.
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        Source::read(path)
    }

    /// The motion in it, with its columns of torque per mass for actuators of `joints` that are carried.
    ///
    /// # Errors
    /// Every mistake of the file.
    fn motion(
        &mut self,
        source: &Arc<Source>,
        periodic: bool,
        period: Option<f64>,
        joints: &[String],
    ) -> Result<(Arc<Motion>, Vec<CarriedColumn>), InputError> {
        motion::read_carrying(source, periodic, period, joints).map(|(motion, carried)| (Arc::new(motion), carried))
    }

    /// A finished motion for the name that a joint gives as its `motion`, with the columns that a file would have: made by
    /// a program, and read from no file. Each of its columns has an entry for every sample. `None` where the name is a file's.
    fn given(&mut self, name: &str) -> Option<(Arc<Motion>, Vec<CarriedColumn>)> {
        let _ = name;
        None
    }
}

/// Each file is read once, whatever joints name it: all of them see the same motion.
#[derive(Debug, Default)]
pub struct FromDisk(HashMap<PathBuf, Arc<Source>>);

impl Motions for FromDisk {
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        if let Some(known) = self.0.get(path) {
            return Ok(known.clone());
        }
        let source = Source::read(path)?;
        self.0.insert(path.to_path_buf(), source.clone());
        Ok(source)
    }
}

/// Where a reading's motions come from, and what was wrong with them.
pub(super) struct MotionReader<'m> {
    pub(super) motions: &'m mut dyn Motions,
    pub(super) errors: Vec<InputError>,
    /// The files that were opened.
    pub(super) opened: Vec<Arc<Source>>,
    /// Speed factor on all motions once they are read.
    pub(super) speed: f64,
}

impl<'m> MotionReader<'m> {
    pub(super) fn new(motions: &'m mut dyn Motions, speed: f64) -> MotionReader<'m> {
        MotionReader { motions, errors: Vec::new(), opened: Vec::new(), speed }
    }

    pub(super) fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        open(self.motions, &mut self.opened, path)
    }

    /// What reads a transmission, with the files that it may name.
    pub(super) fn with_files<T>(&mut self, read: impl FnOnce(&mut Files) -> T) -> T {
        let MotionReader { motions, errors, opened, .. } = self;
        read(&mut Files { open: &mut |path| open(*motions, opened, path), errors })
    }
}

/// Opens a file and keeps it in mind.
fn open(motions: &mut dyn Motions, opened: &mut Vec<Arc<Source>>, path: &Path) -> Result<Arc<Source>, InputError> {
    let source = motions.open(path)?;
    if !opened.iter().any(|s| s.name() == source.name()) {
        opened.push(source.clone());
    }
    Ok(source)
}

/// From one start of a motion to the next.
pub(super) const REPEAT_EVERY: Key = key(
    "repeat_every",
    "of a motion that happens once (`periodic = false`): from one start to the next, with rest in between; without it heat starts cold",
);

/// The motion, and the columns of torque per mass in its file.
pub(super) fn read_motion(
    section: &Section,
    joints: &[String],
    name: Option<&String>,
    scale: Option<Scale>,
    motions: &mut MotionReader,
) -> Option<(Arc<Motion>, Vec<CarriedColumn>)> {
    let periodic = section.boolean(key("periodic", "whether the motion repeats").default("true")).unwrap_or(true);
    let period = section.quantity(
        key("period", "of a motion whose last row does not repeat the first"),
        &units::TIME,
        Range::Positive,
    );
    let every = section.quantity(REPEAT_EVERY, &units::TIME, Range::Positive);
    let read = match (section.has("motion"), section.has("points")) {
        (true, true) => {
            section.note(Problem::at(
                section.span_of("points"),
                "a joint has `motion` or `points`, not both",
                "remove one of the two",
            ));
            None
        }
        (false, false) => {
            section.missing(
                "motion",
                "\"motions/knee.csv\", or points = [ { torque = \"18 N*m\", speed = \"0 rad/s\" } ], or mechanism_joint = \"knee_joint\"",
            );
            None
        }
        (false, true) => {
            for key in ["periodic", "period"].into_iter().filter(|key| section.has(key)) {
                let problem = Problem::at(
                    section.span_of(key),
                    format!("`{key}` says nothing of operating points"),
                    "points have durations and no order",
                );
                section.note(problem.help("remove it, or give a `motion`"));
            }
            Some((Arc::new(read_points(section)?), Vec::new()))
        }
        (true, false) => {
            let file = section.text(key("motion", "CSV file next to this one").value("file").or("points"))?;
            if let Some(given) = motions.motions.given(file.get_ref()) {
                return finished(section, given, scale, every);
            }
            let path = section.source().folder().join(file.get_ref());
            match motions.open(&path) {
                Ok(source) => {
                    // Many joints have many motions: the names of all others are for the few that ask for them.
                    let others: Vec<String> = match motion::may_carry(&source) {
                        true => joints.iter().filter(|j| name != Some(*j)).cloned().collect(),
                        false => Vec::new(),
                    };
                    motions.motions.motion(&source, periodic, period, &others).map_err(|e| motions.errors.push(e)).ok()
                }
                Err(error) => {
                    section.note(error.where_named("motion", file.get_ref(), file.span()));
                    None
                }
            }
        }
    };
    let (motion, carried) = read?;
    Some(scaled(section, motion, carried, scale, every))
}

/// The motion as the joint scales it and makes it again.
fn scaled(
    section: &Section,
    mut motion: Arc<Motion>,
    mut carried: Vec<CarriedColumn>,
    scale: Option<Scale>,
    every: Option<f64>,
) -> (Arc<Motion>, Vec<CarriedColumn>) {
    if let Some(Scale { torque, speed }) = scale {
        motion = Arc::new(Arc::unwrap_or_clone(motion).scaled(torque, speed));
        // What is carried weighs the same; only its course runs faster.
        carried.iter_mut().flat_map(|(.., rates)| rates).for_each(|rate| *rate *= speed);
    }
    if every.is_some() {
        let every = repeat_every(section, every, motion.course);
        Arc::make_mut(&mut motion).repeat_every = every;
    }
    (motion, carried)
}

/// A motion that was handed over finished: what only a file needs to be told is a mistake here.
fn finished(
    section: &Section,
    (motion, carried): (Arc<Motion>, Vec<CarriedColumn>),
    scale: Option<Scale>,
    every: Option<f64>,
) -> Option<(Arc<Motion>, Vec<CarriedColumn>)> {
    for key in ["periodic", "period"].into_iter().filter(|key| section.has(*key)) {
        let message = format!("`{key}` says nothing of a motion that is handed over");
        section.note(Problem::at(section.span_of(key), message, "the motion says it itself").help("remove it"));
    }
    if let Some((name, ..)) =
        carried.iter().find(|(_, values, rates)| values.len() != motion.len() || rates.len() != motion.len())
    {
        let message =
            format!("the torque per mass of `{name}` does not have as many entries as the motion has samples");
        section.note(Problem::at(section.span_of("motion"), message, "handed over with this motion"));
        return None;
    }
    Some(scaled(section, motion, carried, scale, every))
}

/// Factors on a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    /// On all torques.
    pub(super) torque: f64,
    /// On the speed: the same positions in less time.
    pub(super) speed: f64,
}

impl Scale {
    /// The least and the largest factor.
    const FACTORS: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
}

/// Reads `scale` of a joint; `None` where there is none.
pub(super) fn read_scale(section: &Section) -> Option<Scale> {
    let table = section.section(key("scale", "factors on the motion; they hold before `repeat_every` is looked at"))?;
    let factor = |name: &'static str, about| {
        let factor = table.number(key(name, about).default("1"), Range::Positive)?;
        if !Scale::FACTORS.contains(&factor) {
            let message = format!("`{name}` of [scale] is out of range");
            table.note(Problem::at(table.span_of(name), message, "expected a factor between 1e-6 and 1e6"));
        }
        Some(factor)
    };
    let torque = factor("torque", "on all torques of the load");
    let speed = factor("speed", "how many times as fast: accelerations go with its square, jerks with its cube");
    table.finish();
    Some(Scale { torque: torque.unwrap_or(1.0), speed: speed.unwrap_or(1.0) })
}

/// After what time a motion that happens once is made again \[s\], as asked; `None` where it is not, or where that is a
/// mistake, which is noted.
pub(super) fn repeat_every(section: &Section, every: Option<f64>, course: motion::Course) -> Option<f64> {
    let every = every?;
    let span = section.span_of("repeat_every");
    let needs = "`repeat_every` needs a motion that happens once";
    section.note(match course {
        motion::Course::Once(lasts) if every >= lasts => return Some(every),
        motion::Course::Once(lasts) => {
            let message = format!("the motion lasts {lasts} s, but is to be made again after {every} s");
            Problem::at(span, message, "before it ends").help("give the time from one start to the next, rest included")
        }
        motion::Course::Periodic(_) => Problem::at(span, needs, "this one repeats without rest")
            .help("set `periodic = false`, or remove `repeat_every`"),
        motion::Course::Points(_) | motion::Course::Cases => Problem::at(span, needs, "not with operating points")
            .help("give a `motion` and `periodic = false`; or add a point at rest without torque, with its duration"),
    });
    None
}

fn read_points(section: &Section) -> Option<Motion> {
    let mut points = Vec::new();
    let mut complete = true;
    let (mut timed, mut untimed) = (0, 0);
    let sections = section.sections(key("points", "operating points, each for itself").or("motion"));
    if sections.is_empty() {
        section.note(
            Problem::at(section.span_of("points"), "`points` is empty", "expected at least one operating point")
                .help("for example points = [ { torque = \"18 N*m\", speed = \"0 rad/s\", duration = \"0.5 s\" } ]"),
        );
        return None;
    }
    for point in sections {
        let torque = point.required_quantity(key("torque", "at the output"), &units::TORQUE, Range::Any);
        let speed = point.required_quantity(key("speed", "at the output"), &units::SPEED, Range::Any);
        let optional =
            |name, about, kind| point.quantity(key(name, about).default("zero"), kind, Range::Any).unwrap_or(0.0);
        let acceleration = optional("acceleration", "at the output", &units::ACCELERATION);
        let torque_rate = optional("torque_rate", "how fast the torque rises", &units::TORQUE_RATE);
        let jerk = optional("jerk", "how fast the acceleration rises", &units::JERK);
        let duration = point.quantity(
            key("duration", "of all points or of none; heat is checked only with it"),
            &units::TIME,
            Range::Positive,
        );
        if duration.is_some() {
            timed += 1
        } else {
            untimed += 1
        }
        point.finish();
        match (torque, speed) {
            (Some(torque), Some(velocity)) => {
                points.push(Point { torque, velocity, acceleration, torque_rate, jerk, duration })
            }
            _ => complete = false,
        }
    }
    if timed > 0 && untimed > 0 {
        section.note(Problem::at(
            section.span_of("points"),
            format!("{timed} points have a `duration` and {untimed} have none"),
            "give all of them a duration, or none",
        ));
        return None;
    }
    complete.then(|| Motion::from_points(&points))
}

#[cfg(test)]
mod tests;
