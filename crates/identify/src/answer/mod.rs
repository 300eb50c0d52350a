//! What identification says: the facts of an answer, without how they are found.
//!
//! The one idea: whoever finds something, the balance of an equation or a simulation, says it in these types, and whoever
//! tells it reads nothing else. Reasons are kinds first and words last.

pub mod evidence;
pub mod findings;
pub mod noise;

pub use evidence::{Evidence, Verdict};
pub use findings::{About, Finding};

use super::bench::Channel;
use gearwise_model::effects::{Effect, Equation, Shape, Variable};

/// Which equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Torque at the output, as a sensor has it.
    Torque,
    /// Torque that the drive makes, at the output, where the load is known.
    Drive,
    /// Terminal voltage.
    Voltage,
    /// Angle by which the motor, over N, leads the output.
    WindUp,
    /// Position of the output, simulated: of servo logs that have only duty and position.
    Position,
}

impl Target {
    /// Name, also in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Target::Torque => "torque",
            Target::Drive => "drive_torque",
            Target::Voltage => "voltage",
            Target::WindUp => "wind_up",
            Target::Position => "position",
        }
    }

    /// The equation of effects that this target shows.
    pub fn equation(self) -> Equation {
        match self {
            Target::Torque | Target::Drive | Target::Position => Equation::Torque,
            Target::Voltage => Equation::Voltage,
            Target::WindUp => Equation::Angle,
        }
    }

    /// The channel that it explains, where that is one channel.
    pub fn channel(self) -> Option<Channel> {
        match self {
            Target::Torque => Some(Channel::Torque),
            Target::Voltage => Some(Channel::Voltage),
            Target::Drive => Some(Channel::Current),
            Target::WindUp | Target::Position => None,
        }
    }

    /// Whether its sensor has a zero that belongs to the log.
    pub fn has_zero(self) -> bool {
        matches!(self, Target::Torque | Target::WindUp)
    }
}

/// A parameter of the declared model, as the equations have it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Base {
    /// K_T.
    TorqueConstant,
    /// Of rotor and gear.
    Inertia,
    /// Of a linear axis.
    Mass,
    /// Torque over speed where a duty cycle drives, the back-EMF within it.
    Damping,
    /// What a known load is multiplied with.
    LoadScale,
    /// R.
    Resistance,
    /// L.
    Inductance,
    /// K_B.
    BackEmf,
}

impl Base {
    /// Its name, also in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Base::TorqueConstant => "torque_constant",
            Base::Inertia => "inertia",
            Base::Mass => "mass",
            Base::Damping => "damping",
            Base::LoadScale => "load_scale",
            Base::Resistance => "resistance",
            Base::Inductance => "inductance",
            Base::BackEmf => "back_emf_constant",
        }
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        match self {
            Base::TorqueConstant => "N*m/A",
            Base::Inertia => "kg*m^2",
            Base::Mass => "kg",
            Base::Damping => "N*m*s/rad",
            Base::LoadScale => "1",
            Base::Resistance => "ohm",
            Base::Inductance => "H",
            Base::BackEmf => "V*s/rad",
        }
    }
}

/// Kinds of artefacts of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ArtefactKind {
    /// A channel comes late.
    Lag,
    /// A channel has another gain.
    Gain,
    /// A channel has the other sign.
    Sign,
    /// A channel has a zero of its own in a log.
    Zero,
}

impl ArtefactKind {
    /// Its name, also in JSON.
    pub fn name(self) -> &'static str {
        match self {
            ArtefactKind::Lag => "lag",
            ArtefactKind::Gain => "gain",
            ArtefactKind::Sign => "sign",
            ArtefactKind::Zero => "zero",
        }
    }
}

/// An artefact of the measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Artefact {
    /// Of which kind.
    pub kind: ArtefactKind,
    /// The channel, and the log where it is one log's.
    pub channel: String,
    /// How much.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
}

/// Why an effect cannot be asked for in an equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hidden {
    /// It is a term of another equation.
    Elsewhere,
    /// What it depends on is not measured or does not vary.
    Lacks(Variable),
    /// Something hides it: why.
    Bench(&'static str),
    /// Its regressor is made of the response that it would explain; what measurement would show it.
    Response(&'static str),
    /// The bench file says that it is not asked for.
    LeftOut,
}

/// A point of the story.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// As declared.
    Declared,
    /// Artefacts of the measurement taken out.
    Artefacts,
    /// The declared parameters fitted.
    Refit,
    /// An effect added, with its shape.
    Added(&'static dyn Effect, f64),
    /// A lag of the input added.
    Lag,
    /// As it stands in the end.
    Final,
}

impl Step {
    /// Its name, also in JSON.
    pub fn name(self) -> String {
        match self {
            Step::Declared => "declared".into(),
            Step::Artefacts => "artefacts".into(),
            Step::Refit => "refit".into(),
            Step::Added(effect, shape) => match effect.shape() {
                Shape::Order => format!("{} order {shape}", effect.name()),
                _ => effect.name().to_string(),
            },
            Step::Lag => "lag".into(),
            Step::Final => "final".into(),
        }
    }
}

/// Error at one point of the story, root mean square in the unit of the target.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Which.
    pub step: Step,
    /// On the logs for fitting.
    pub fit: f64,
    /// Variance accounted for \[%\].
    pub fit_vaf: f64,
    /// On what was held out.
    pub held_out: Option<f64>,
    /// Variance accounted for \[%\].
    pub held_out_vaf: Option<f64>,
    /// Whether the final model does not have what was added here.
    pub taken_back: bool,
}

impl Stage {
    /// Variance accounted for \[%\], where it says anything: of a target that does not vary none can be accounted for.
    pub fn vaf(percent: f64) -> Option<f64> {
        (percent > -1e5).then_some(percent)
    }

    /// From error and variance accounted for \[%\] on either part; without data to fit they are not numbers.
    pub fn new(step: Step, fit: Option<(f64, f64)>, held_out: Option<(f64, f64)>) -> Stage {
        Stage {
            step,
            fit: fit.map_or(f64::NAN, |e| e.0),
            fit_vaf: fit.map_or(f64::NAN, |e| e.1),
            held_out: held_out.map(|e| e.0),
            held_out_vaf: held_out.map(|e| e.1),
            taken_back: false,
        }
    }
}

/// A parameter of the declared model, refitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Declared value.
    pub declared: Option<f64>,
    /// Fitted value; the declared one where the data do not show it.
    pub fitted: f64,
    /// Standard error of the model that is named; `None` where it was held.
    pub standard_error: Option<f64>,
    /// What these logs leave undecided beyond that.
    pub undecided: Option<Undecided>,
    /// SI unit.
    pub unit: &'static str,
}

/// An effect that was asked and is neither shown nor ruled out, or two, and what they would make of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Undecided {
    /// Which.
    pub effect: &'static dyn Effect,
    /// A second one that hides it.
    pub beside: Option<&'static dyn Effect>,
    /// By how much the number would differ with them, times how likely it is that they lower the error of other data.
    pub by: f64,
}

/// By how much a fitted number must differ from the declared one to be called off: in standard errors, and as a share.
const OFF: (f64, f64) = (3.0, 0.02);

/// Standard errors of a 95 % interval.
pub const INTERVAL: f64 = 1.96;

impl Parameter {
    /// Its ± (95 %), with what is undecided; `None` where it was held.
    pub fn tolerance(&self) -> Option<f64> {
        self.error().map(|error| INTERVAL * error)
    }

    /// Its standard error, with what is undecided.
    fn error(&self) -> Option<f64> {
        self.standard_error.map(|error| error.hypot(self.undecided.map_or(0.0, |u| u.by)))
    }

    /// By what share the logs want it changed, where that is sure and enough to matter.
    pub fn shift(&self) -> Option<f64> {
        let (declared, error) = (self.declared.filter(|d| *d != 0.0)?, self.error()?);
        let change = self.fitted / declared - 1.0;
        ((self.fitted - declared).abs() > OFF.0 * error && change.abs() > OFF.1).then_some(change)
    }
}

/// An effect that the model lacked.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Which.
    pub effect: &'static dyn Effect,
    /// Its parameters, over all orders.
    pub parameters: Vec<Parameter>,
    /// Values of each instance (several orders), in the order of the effect's parameters.
    pub instances: Vec<Vec<f64>>,
    /// Root mean square of what it adds to the target.
    pub size: f64,
    /// Held-out error without it.
    pub held_out_before: Option<f64>,
    /// Held-out error with it.
    pub held_out_after: Option<f64>,
    /// Effects that the data cannot tell from it.
    pub confounded_with: Vec<&'static dyn Effect>,
}

impl Found {
    /// Its name.
    pub fn name(&self) -> &'static str {
        self.effect.name()
    }
}

/// An effect that was not added.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused {
    /// Name.
    pub name: String,
    /// Why.
    pub reason: String,
    /// What kind of reason that is.
    pub ground: Ground,
}

/// On what ground an effect was not added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ground {
    /// It was asked and did not earn its name.
    Judged,
    /// It was asked, and a drift in time explains as much.
    Drift,
    /// Another equation of the actuator has it.
    Elsewhere,
    /// The bench does not measure this, or it does not vary.
    Lacks(Variable),
    /// The bench hides it.
    Bench,
    /// Its regressor is made of the response; this measurement would show it.
    Response(&'static str),
    /// The bench file says that it is not asked for.
    LeftOut,
}

impl Refused {
    /// Of an effect that was asked.
    pub fn new(name: &str, reason: String) -> Refused {
        Refused { name: name.into(), reason, ground: Ground::Judged }
    }

    /// Of an effect that cannot be asked.
    pub fn hidden(name: &str, hidden: Hidden) -> Refused {
        let (reason, ground) = match hidden {
            Hidden::Elsewhere => ("this bench does not measure its equation".to_string(), Ground::Elsewhere),
            Hidden::Lacks(variable) => (variable.lack().to_string(), Ground::Lacks(variable)),
            Hidden::Bench(why) => (why.to_string(), Ground::Bench),
            Hidden::Response(shown_by) => (
                format!(
                    "not identifiable on this bench: its regressor is made of the response, which would explain itself; \
                     {shown_by} would show it"
                ),
                Ground::Response(shown_by),
            ),
            Hidden::LeftOut => ("not asked for: `without` of the bench file names it".to_string(), Ground::LeftOut),
        };
        Refused { name: name.into(), reason, ground }
    }
}

/// What something that is left depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum On {
    /// Time alone.
    Time,
    /// Time, with the direction of motion: friction that changes.
    TimeAndDirection,
    /// Acceleration.
    Acceleration,
    /// A variable of the operating point.
    Variable(Variable),
}

impl On {
    /// Its name, also in JSON.
    pub fn name(self) -> &'static str {
        match self {
            On::Time => "time",
            On::TimeAndDirection => "time and direction",
            On::Acceleration => "acceleration",
            On::Variable(variable) => variable.name(),
        }
    }

    /// Whether it changes with time.
    pub fn drifts(self) -> bool {
        matches!(self, On::Time | On::TimeAndDirection)
    }
}

/// What is left and on what it depends.
#[derive(Debug, Clone, PartialEq)]
pub struct Unexplained {
    /// On what.
    pub depends_on: On,
    /// In words.
    pub detail: String,
}

/// What identification says about one equation.
#[derive(Debug, Clone)]
pub struct Report {
    /// The equation.
    pub target: Target,
    /// Unit of errors.
    pub unit: &'static str,
    /// Cut-off of the filter \[Hz\].
    pub band: Option<f64>,
    /// Samples that were read, and rows that the regression saw.
    pub samples: (usize, usize),
    /// What the verdict rests on: what is left, the instrument's noise, what was asked.
    pub evidence: Evidence,
    /// The verdict.
    pub verdict: Verdict,
    /// The story, first as declared, last as it stands.
    pub stages: Vec<Stage>,
    /// What was found in the logs before any effect was asked for.
    pub findings: Vec<Finding>,
    /// Artefacts of the measurement.
    pub artefacts: Vec<Artefact>,
    /// Parameters of the declared model.
    pub parameters: Vec<Parameter>,
    /// Effects that the model lacked.
    pub effects: Vec<Found>,
    /// Effects that were not added.
    pub refused: Vec<Refused>,
    /// What is left.
    pub unexplained: Vec<Unexplained>,
    /// What to measure next.
    pub next_runs: Vec<String>,
    /// What should be known.
    pub remarks: Vec<String>,
    /// Names of all fitted numbers, in the order of `covariance`.
    pub fitted_names: Vec<String>,
    /// Their covariance, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Residual as declared (corrected) and in the end, for the pictures.
    pub pictures: Pictures,
}

impl Report {
    /// Marks the steps that the final model does not have: an effect, or of one with orders that order; a lag.
    pub(crate) fn mark_what_was_taken_back(&mut self) {
        let (effects, artefacts) = (&self.effects, &self.artefacts);
        for stage in &mut self.stages {
            stage.taken_back = match stage.step {
                Step::Added(effect, shape) => !effects.iter().any(|found| {
                    let orders = || found.instances.iter().any(|i| i.last() == Some(&shape));
                    found.effect == effect && (effect.shape() != Shape::Order || orders())
                }),
                Step::Lag => !artefacts.iter().any(|a| a.kind == ArtefactKind::Lag),
                _ => false,
            };
        }
    }

    /// A lag of a channel \[s\], as the list of artefacts has it.
    pub(crate) fn lag(channel: &str, value: f64) -> Artefact {
        Artefact { kind: ArtefactKind::Lag, channel: channel.into(), value, unit: "s" }
    }
}

/// Columns for the pictures: one entry for each row of the regression.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    /// Time in its log \[s\].
    pub time: Vec<f64>,
    /// Log of each row.
    pub log: Vec<usize>,
    /// Names of the logs.
    pub names: Vec<String>,
    /// Residual of the declared model after corrections \[unit\].
    pub before: Vec<f64>,
    /// Residual in the end \[unit\].
    pub after: Vec<f64>,
    /// Motor speed \[rad/s\].
    pub speed: Vec<f64>,
    /// Motor angle \[rad\].
    pub angle: Vec<f64>,
    /// Current \[A\].
    pub current: Vec<f64>,
    /// Winding temperature over the reference \[K\].
    pub temperature: Vec<f64>,
}
