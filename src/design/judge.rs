//! Whether a design can be judged.
//!
//! The one idea: what is not known is not kept. A limit that the requirement itself states has to be judged; a design
//! of which it cannot be is told apart and is no choice. What a data sheet states and what only makes a limit less sharp
//! is *not checked*, which is said beside the design. Whether the requirement states something is a fact of the limit
//! ([`is_stated`]), so that whoever adds an unknown adds nothing here.

use super::optimize::{Design, Reason, Rejected};
use crate::actuator::limits::{Remark, is_stated};
use crate::requirement::{Joint, Robot};

/// A design that keeps every limit that could be judged, and of which a stated one could not.
#[derive(Debug, Clone)]
pub struct Unjudged<'a> {
    /// The best design as far as it can be told.
    pub design: Design<'a>,
    /// What the requirement states and cannot be judged, and why; never empty.
    pub because: Vec<Remark>,
}

/// Why a motor is no candidate for the choice.
#[derive(Debug, Clone)]
pub enum Refused<'a> {
    /// It cannot do it.
    Rejected(Rejected<'a>),
    /// Whether it can is not known.
    Unjudged(Box<Unjudged<'a>>),
}

impl Refused<'_> {
    /// Why.
    pub fn reason(&self) -> Reason {
        match self {
            Refused::Rejected(rejected) => rejected.reason.clone(),
            Refused::Unjudged(unjudged) => Reason::Unjudged(unjudged.because.clone()),
        }
    }
}

/// Of what could not be checked of a design, that which the requirement itself states.
pub fn unjudged(robot: &Robot, joint: &Joint, unchecked: &[Remark]) -> Vec<Remark> {
    unchecked.iter().filter(|(name, _)| is_stated(name, robot, joint)).copied().collect()
}

/// What rules a design out before it is solved, where only designs with every limit checked are wanted: an unknown
/// that the requirement does not state. (One that it states is told apart, if the design keeps all else.)
pub fn left_out(robot: &Robot, joint: &Joint, unchecked: &[Remark], only_checked: bool) -> Option<Remark> {
    let plain = |(name, _): &&Remark| only_checked && !is_stated(name, robot, joint);
    unchecked.iter().find(plain).copied()
}

/// A design that keeps every limit that could be judged, if it is a choice; else why not.
///
/// # Errors
/// It is left out, or a limit that the requirement states cannot be judged.
pub fn judged<'a>(
    robot: &Robot,
    joint: &Joint,
    design: Design<'a>,
    only_checked: bool,
) -> Result<Design<'a>, Refused<'a>> {
    if let Some((limit, why)) = left_out(robot, joint, &design.unchecked, only_checked) {
        let reason = Reason::Unchecked(limit, why);
        return Err(Refused::Rejected(Rejected { motor: design.motor, gear: design.gear, reason }));
    }
    match unjudged(robot, joint, &design.unchecked) {
        because if because.is_empty() => Ok(design),
        because => Err(Refused::Unjudged(Box::new(Unjudged { design, because }))),
    }
}
