//! What a plan says: set-points, what they would separate, and within which limits. Facts; words are made elsewhere.

use crate::BenchKind;
use crate::answer::{Base, Target};
use gearwise_model::effects::Effect;

/// The separation from which two models are told apart: δ, the distance of what they predict in standard deviations of what
/// is left on this bench.
pub const APART: f64 = 6.0;

/// What is wanted of a plan.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Wanted {
    /// How long the run is \[s\]; by default as long as the longest log, between 20 s and 60 s.
    pub time: Option<f64>,
    /// The most that the output may travel \[rad, m on a linear axis\]; by default as far as in the logs.
    pub travel: Option<f64>,
}

/// What another model explains instead of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rival {
    /// Another effect explains as much.
    Effect(&'static dyn Effect),
    /// Another value of a parameter that is held as declared does.
    Parameter(Base),
    /// Nothing: whether the effect is there at all is not resolved.
    Nothing,
}

impl Rival {
    /// Its name, also in JSON and CSV.
    pub fn name(self) -> &'static str {
        match self {
            Rival::Effect(effect) => effect.name(),
            Rival::Parameter(base) => base.name(),
            Rival::Nothing => "nothing",
        }
    }
}

/// Two models that these logs do not tell apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// The equation.
    pub target: Target,
    /// The effect.
    pub effect: &'static dyn Effect,
    /// What it is not told from.
    pub rival: Rival,
}

/// What a run does for a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// The pair.
    pub pair: Pair,
    /// δ with the logs that are there.
    pub now: f64,
    /// δ with the planned run beside them.
    pub after: f64,
    /// Time of the planned run until δ ≥ 6 \[s\], in whole passages: within the run, or of the run repeated. `None` where no run within the limits
    /// gets there in ten times the length of the plan.
    pub until: Option<f64>,
}

impl Separation {
    /// Whether the planned run tells the two apart.
    pub fn is_apart(&self) -> bool {
        self.after >= APART
    }
}

/// Why a pair has no part in the plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unplanned {
    /// The equation is simulated, not balanced.
    Simulated,
    /// The order lies above the band.
    AboveTheBand,
    /// Its orders on both sides of the gear are nearly one: only more turns tell them apart.
    MoreTurns,
    /// No values of the two are plausible here.
    Implausible,
    /// Another bench, of this kind, is planned.
    OtherBench(BenchKind),
    /// The kind of bench has no run over time.
    Kind(BenchKind),
}

/// What a limit is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Speed of the motor \[rad/s\].
    Speed,
    /// Acceleration of the motor \[rad/s²\], where something else drives it.
    Acceleration,
    /// Torque of the motor, K_T·i \[N·m\].
    Torque,
    /// Travel of the output \[rad\].
    Angle,
    /// Current that heats, root mean square of each passage \[A\].
    Heat,
    /// Voltage at the terminals \[V\].
    Voltage,
}

impl Quantity {
    /// Its name, also in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Speed => "speed",
            Quantity::Acceleration => "acceleration",
            Quantity::Torque => "torque",
            Quantity::Angle => "angle",
            Quantity::Heat => "heat",
            Quantity::Voltage => "voltage",
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Speed => "rad/s",
            Quantity::Acceleration => "rad/s^2",
            Quantity::Torque => "N*m",
            Quantity::Angle => "rad",
            Quantity::Heat => "A",
            Quantity::Voltage => "V",
        }
    }
}

/// Where a limit comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The motor's row declares it, in this column.
    Declared(&'static str),
    /// The row does not: what the logs reached is not exceeded.
    Reached,
    /// It was asked for.
    Asked,
    /// The logs do not show it, and what is gentle is assumed.
    Assumed,
}

/// A limit that the plan keeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Of what.
    pub of: Quantity,
    /// The most that is allowed, SI.
    pub most: f64,
    /// Where that comes from.
    pub source: Source,
    /// The most that the plan reaches.
    pub used: f64,
}

/// Share of a limit from which it bounds the plan.
const BOUNDS: f64 = 0.95;

impl Limit {
    /// Whether it bounds the plan.
    pub fn bounds(&self) -> bool {
        self.used >= BOUNDS * self.most
    }
}

/// What the bench is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Driven {
    /// Motion alone: a driving machine, or the drive's own controller of position or speed.
    Motion,
    /// Current alone, the output held.
    Current,
    /// Motion by a driving machine, and current.
    Both,
}

/// A set-point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SetPoint {
    /// Time from the start of the run \[s\].
    pub time: f64,
    /// Speed of the motor \[rad/s\].
    pub speed: f64,
    /// Angle of the motor \[rad\].
    pub angle: f64,
    /// Quadrature current \[A\]: a set-point, or what the model expects.
    pub current: f64,
    /// Torque at the output that the model expects \[N·m\].
    pub torque: f64,
}

/// A planned run.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Kind of the bench.
    pub kind: BenchKind,
    /// What the bench is told.
    pub driven: Driven,
    /// How long the run is \[s\].
    pub duration: f64,
    /// What is to be played.
    pub points: Vec<SetPoint>,
    /// What it does for each pair, the weakest first.
    pub separations: Vec<Separation>,
    /// Within which limits.
    pub limits: Vec<Limit>,
    /// Pairs that it leaves alone, and why.
    pub unplanned: Vec<(Pair, Unplanned)>,
    /// Whether a temperature is taken as constant.
    pub is_at_one_temperature: bool,
}

/// Why there is no plan.
#[derive(Debug, Clone, PartialEq)]
pub enum NoPlan {
    /// Every name is told apart, and every refusal is resolved.
    NothingOpen,
    /// The logs teach nothing: there is no model to plan with.
    TeachesNothing,
    /// Something is open, but for none of it a run can be planned.
    Unplanned(Vec<(Pair, Unplanned)>),
    /// No run within the limits separates anything.
    NothingSeparates {
        /// What the best run would do.
        separations: Vec<Separation>,
        /// Within which limits.
        limits: Vec<Limit>,
        /// Pairs that were left alone, and why.
        unplanned: Vec<(Pair, Unplanned)>,
    },
    /// The run is too short to be planned; the shortest \[s\].
    TooShort(f64),
}
