//! Words for a choice that several of its readings share: what binds, how near a limit is, how sure it is.

use super::{design_ratio, estimated, number};
use gearwise_model::actuator::limits::LOW_SAFETY;
use gearwise_model::catalog::module::Drive;
use gearwise_model::requirement::{Course, Joint, Quantity};
use gearwise_model::words::range_inwards;
use gearwise_select::answer::{Design, JointResult};
use gearwise_select::evaluate::Margin;
use gearwise_select::program::{Bind, Certificate, Optimum};

/// What is said of a joint before its designs, each a sentence. `short` leaves out what is only told to whoever asks for
/// more.
pub(super) fn joint_notes(joint: &Joint, short: bool) -> Vec<String> {
    let mut notes: Vec<String> = Vec::new();
    if joint.motion.course == Course::Points(None) {
        notes.push("The operating points have no durations: they weigh alike, and heat is that of the hottest, held continuously.".into());
    }
    if !joint.ratio.is_catalog() && joint.gear.takes_nothing() {
        notes.push("No gear is described: it is taken as free of loss, inertia and mass.".into());
    }
    notes.extend(super::teeth::note(joint));
    notes.extend(super::family::note(joint).map(|note| format!("{note}.")));
    let motion = if short { super::motion::warnings(joint) } else { super::motion::notes(joint) };
    notes.extend(motion.into_iter().map(|note| format!("{note}.")));
    if joint.objective.weight(Quantity::PeakCurrent) > 0.0 {
        notes.push(
            "The objective's current is on the q axis: √(3/2) times the phase amplitude that tables show.".into(),
        );
    }
    if joint.limits.safety < 1.0 {
        notes.push(format!("`safety`: {LOW_SAFETY}."));
    }
    if joint.motion.torque.iter().chain(&joint.motion.acceleration).all(|x| *x == 0.0) {
        notes.push("The motion asks for no torque and no acceleration: the order says nothing.".into());
    }
    notes
}

/// How many gears are named that are not evaluated.
const NAMED_GEARS: usize = 3;

/// What is said of gears that the joint allows and that no motor was evaluated with.
pub(super) fn gears_note(result: &JointResult) -> Option<String> {
    let left_out = &result.gears_without_efficiency;
    let (named, more) = left_out.split_at(left_out.len().min(NAMED_GEARS));
    let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
    let names = named.join(", ");
    (!named.is_empty()).then(|| format!("Not evaluated, because their rows say no efficiency: {names}{more}."))
}

/// The gear of a ratio, where the ratios of a joint are those of teeth or of a family.
pub(crate) fn gear_of_ratio(joint: &Joint, ratio: f64) -> Option<String> {
    super::teeth::of_ratio(joint, ratio).or_else(|| super::family::of_ratio(joint, ratio))
}

/// What is shown to people.
#[derive(Debug, Clone, Copy)]
pub struct Shown {
    /// How many candidates of each joint.
    pub top: usize,
    /// Whether every rejected motor gets its line.
    pub rejected: bool,
    /// Whether each first choice is explained: what binds, how its number comes about, what is near.
    pub why: bool,
    /// Whether every joint has its tables, too.
    pub full: bool,
}

/// A limit with the instant at which it binds.
pub fn bind_text(bind: &Bind, joint: &Joint) -> String {
    match (bind.sample, bind.unjudged) {
        (_, Some(_)) => format!("{} cannot be judged beyond", bind.limit),
        (Some(k), None) => format!("{} ({})", bind.limit, joint.motion.name_sample(k)),
        (None, None) => bind.limit.to_string(),
    }
}

/// How an optimum is proved, in a word.
pub fn proof(certificate: &Certificate) -> String {
    match certificate {
        Certificate::Certified { gap, .. } if *gap < 1e-12 => "exact".into(),
        Certificate::Certified { gap, .. } => format!("gap {gap:.0e}"),
        Certificate::NotCertified(_) => "not certified".into(),
    }
}

pub(super) fn margin_text(margin: &Margin) -> String {
    format!("{} {:.0} %", margin.limit, (100.0 * margin.margin).max(0.0))
}

/// The feasible ratios and what ends them, rounded inwards, so that they are feasible when they are typed again; `None`
/// where only the best of a list is known to be feasible.
pub(super) fn windows_text(optimum: &Optimum, joint: &Joint) -> Option<String> {
    let is_one = matches!(optimum.windows.as_slice(), [only] if only.min == only.max);
    if joint.ratio.listed().is_some() && is_one {
        return None;
    }
    Some(window_texts(optimum, joint).join(" and from "))
}

/// Each interval of feasible ratios and what ends it, rounded inwards.
pub(super) fn window_texts(optimum: &Optimum, joint: &Joint) -> Vec<String> {
    let told = optimum.windows.iter().map(|w| {
        let [low, high] = range_inwards(w.min, w.max);
        format!("{low} ({}) to {high} ({})", bind_text(&w.low, joint), bind_text(&w.high, joint))
    });
    told.collect()
}

/// A share in per cent.
pub(super) fn per_cent(share: f64) -> String {
    let rounded = (1000.0 * share).round() / 10.0;
    if rounded == 0.0 && share != 0.0 { "less than 0.1 %".into() } else { format!("{} %", number(rounded)) }
}

/// That a margin is beyond a reserve that is kept; nothing where none is.
pub(super) fn beyond_reserve(margin: &Margin, joint: &Joint) -> String {
    match joint.limits.reserve(margin.limit) {
        share if share > 0.0 => format!(" beyond its reserve of {}", per_cent(share)),
        _ => String::new(),
    }
}

/// The same with the load case that it is in, where the joint has several.
pub(super) fn margin_at(margin: &Margin, joint: &Joint) -> String {
    let case = margin.case(joint);
    margin_text(margin)
        + &beyond_reserve(margin, joint)
        + &case.map_or_else(String::new, |case| format!(" ({})", case.name))
}

/// With what gear a design is; a module has its own.
pub(super) fn with_gear(design: &Design) -> Option<String> {
    let drive = design.motor.inside.as_deref().map(|inside| inside.module.drive);
    match drive {
        Some(Drive::BuiltIn) => Some("a module, drive inside".into()),
        Some(Drive::External) => Some("a module without drive".into()),
        None => design.gear.map(|gear| format!("with {gear}")),
    }
}

pub(super) fn choice_text(design: &Design) -> String {
    let gear = design.gear.filter(|_| design.motor.inside.is_none());
    let gear = gear.map_or_else(String::new, |g| format!(" with {g}"));
    let unchecked = match design.unchecked.len() {
        0 => String::new(),
        1 => ", 1 thing not checked".into(),
        n => format!(", {n} things not checked"),
    };
    let estimated = estimated::text(design.motor);
    format!("{}{gear} at N = {}{unchecked}{estimated}", design.motor.id, design_ratio(design))
}
