//! `identify --plan`: the part of `identify --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;

use super::finite;
use crate::identify::unit_on;
use crate::plan::{WANTED, unplanned};
use gearwise_identify::Bench;
use gearwise_identify::identify::plan::{
    Limit as LimitFact, NoPlan, Pair, Plan, Separation as SeparationFact, Source, Unplanned,
};

/// The next run, where one was asked for.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Planned<'a> {
    /// Where the set-points are; `null` where there are none.
    pub file: Option<String>,
    /// `planned`, `nothing_open`, `teaches_nothing`, `unplanned`, `nothing_separates` or `too_short`.
    pub outcome: &'static str,
    /// How long the run is.
    pub duration_s: Option<f64>,
    /// From which δ on two models are separated.
    pub delta_wanted: f64,
    /// What the run does for each pair that is not separated, the weakest first.
    pub pairs: Vec<Separation>,
    /// Limits that it keeps.
    pub limits: Vec<Limit<'a>>,
    /// Pairs that have no part in it.
    pub left_alone: Vec<LeftAlone>,
}

/// What a run does for two models.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Separation {
    /// The equation.
    pub equation: &'static str,
    /// The effect.
    pub effect: &'static str,
    /// What it is not separated from: another effect, a parameter that is held, or `nothing` where it is not resolved.
    pub rival: &'static str,
    /// Distance of what they predict in standard deviations of what is left, with the logs that are there.
    pub delta_now: Option<f64>,
    /// The same with the planned run next to them.
    pub delta_after: Option<f64>,
    /// Time of the run until δ is as wanted, of the run repeated where it is longer than one; `null` where no run within the limits
    /// gets there.
    pub time_s: Option<f64>,
    /// Whether the run separates the two.
    pub apart: bool,
}

/// A limit that is kept.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Limit<'a> {
    /// `speed`, `acceleration` and `torque` of the motor, `angle` (travel) of the output, `heat` (root mean square of the current over
    /// each passage) or `voltage`.
    pub of: &'a str,
    /// The most that is allowed.
    pub allowed: Option<f64>,
    /// The most that the run reaches.
    pub used: Option<f64>,
    /// Unit of both.
    pub unit: &'static str,
    /// `declared`, `reached` by the logs where no rating is declared, `asked`, or `assumed` where the logs do not show it either.
    pub source: &'static str,
    /// The column that declares it.
    pub column: Option<&'static str>,
    /// Whether it bounds the run.
    pub bounds: bool,
}

/// A pair that has no part in the run.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct LeftAlone {
    /// The equation.
    pub equation: &'static str,
    /// The effect.
    pub effect: &'static str,
    /// What it is not told from.
    pub rival: &'static str,
    /// Why, in words.
    pub reason: String,
}

impl<'a> Planned<'a> {
    /// Of a plan, or of why there is none.
    pub fn new(bench: &Bench, planned: &'a Result<Plan, NoPlan>, file: Option<String>) -> Planned<'a> {
        let none: (&[SeparationFact], &[LimitFact], &[(Pair, Unplanned)]) = (&[], &[], &[]);
        let (outcome, (separations, limits, left)) = match planned {
            Ok(p) => ("planned", (p.separations.as_slice(), p.limits.as_slice(), p.unplanned.as_slice())),
            Err(NoPlan::NothingOpen) => ("nothing_open", none),
            Err(NoPlan::TeachesNothing) => ("teaches_nothing", none),
            Err(NoPlan::TooShort(_)) => ("too_short", none),
            Err(NoPlan::Unplanned(list)) => ("unplanned", (none.0, none.1, list.as_slice())),
            Err(NoPlan::NothingSeparates { separations, limits, unplanned }) => {
                ("nothing_separates", (separations.as_slice(), limits.as_slice(), unplanned.as_slice()))
            }
        };
        Planned {
            file,
            outcome,
            duration_s: planned.as_ref().ok().and_then(|p| finite(p.duration)),
            delta_wanted: WANTED,
            pairs: separations.iter().map(Separation::new).collect(),
            limits: limits.iter().map(|l| Limit::new(bench, l)).collect(),
            left_alone: left.iter().map(LeftAlone::new).collect(),
        }
    }
}

impl Separation {
    fn new(s: &SeparationFact) -> Separation {
        Separation {
            equation: s.pair.target.name(),
            effect: s.pair.effect.name(),
            rival: s.pair.rival.name(),
            delta_now: finite(s.now),
            delta_after: finite(s.after),
            time_s: s.until.and_then(finite),
            apart: s.is_apart(),
        }
    }
}

impl Limit<'_> {
    fn new(bench: &Bench, limit: &LimitFact) -> Limit<'static> {
        let (source, column) = match limit.source {
            Source::Declared(column) => ("declared", Some(column)),
            Source::Reached => ("reached", None),
            Source::Asked => ("asked", None),
            Source::Assumed => ("assumed", None),
        };
        Limit {
            of: limit.of.name(),
            allowed: finite(limit.most),
            used: finite(limit.used),
            unit: unit_on(bench, limit.of.unit()),
            source,
            column,
            bounds: limit.bounds(),
        }
    }
}

impl LeftAlone {
    fn new((pair, why): &(Pair, Unplanned)) -> LeftAlone {
        LeftAlone {
            equation: pair.target.name(),
            effect: pair.effect.name(),
            rival: pair.rival.name(),
            reason: unplanned(*why),
        }
    }
}
