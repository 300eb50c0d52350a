//! `identify --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::design::Pairs;
pub use super::plan::Planned;
use super::remake::Remade;
use super::{document, finite};
use crate::identify::{finding_words, overall, refused, sentence, stuck, unit_on, used};
use gearwise_identify::identify::evidence::Gain as GainFact;
use gearwise_identify::identify::{self as fact, Found, Ground, Report, Stage as StageFact, Step, Target};
use gearwise_identify::simulate::{Errors as SimulationErrors, ForwardCheck};
use gearwise_identify::{Bench, Log as LogFact};
use gearwise_select::remake;

/// What `identify` prints: the first equation at the top, with the effects, the refusals and what is unexplained of all
/// equations; the others under `further`.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer<'a> {
    /// Name of the bench.
    pub bench: &'a str,
    /// The verdict over all equations, in a sentence.
    pub sentence: String,
    #[serde(flatten)]
    equation: Option<Equation<'a>>,
    /// The logs.
    pub logs: Vec<Log<'a>>,
    /// The other equations.
    pub further: Vec<Equation<'a>>,
    /// The position simulated with the model before and after, where the bench can be simulated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forward: Option<Forward<'a>>,
    /// The choice made again, where a requirement is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<Remade<'a>>,
    /// The next run, where a plan is asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<Planned<'a>>,
}

/// What one equation of the actuator says.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Equation<'a> {
    /// Which equation.
    pub target: &'static str,
    /// Unit of its errors.
    pub unit: &'static str,
    /// Noise of the instrument in the band, root mean square; `null` where it is not known.
    pub noise_floor: Option<f64>,
    /// What the verdict rests on.
    pub evidence: Evidence,
    /// The verdict: `nothing_missing`, `none_of_these`, `not_resolved`, `explained` or `unexplained_structure`.
    pub verdict: &'static str,
    /// Cut-off of the filter that everything went through.
    pub band_hz: Option<f64>,
    /// Samples that were read.
    pub samples: usize,
    /// Rows of the regression.
    pub rows: usize,
    /// Error of the model, from the declared one to the final one.
    pub errors: Errors,
    /// What was found in the logs before anything was asked.
    pub findings: Vec<Finding<'a>>,
    /// Artefacts of the measurement.
    pub artefacts: Vec<Artefact<'a>>,
    /// Numbers of the declared model, fitted.
    pub parameters: Vec<Parameter<'a>>,
    /// Effects that the declared model lacked.
    pub effects: Vec<Effect<'a>>,
    /// Effects that were not added.
    pub refused: Vec<Refused<'a>>,
    /// What is left and on what it depends.
    pub unexplained: Vec<Unexplained<'a>>,
    /// What to measure next.
    pub next_runs: &'a [String],
    /// What should be known.
    pub remarks: &'a [String],
    /// Covariance of all fitted numbers.
    pub covariance: Covariance<'a>,
}

/// What a verdict rests on.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Evidence {
    /// Error that the final model leaves, each part of the logs left out of the fit in turn, root mean square of all rows alike.
    pub left_out_error: Option<f64>,
    /// Share of the rows for fitting, in per cent, that are so far off that they weigh less in the fit and in the
    /// `errors`; `null` where that does not matter.
    pub far_off_percent: Option<f64>,
    /// The same in times of the instrument's noise.
    pub times_the_noise: Option<f64>,
    /// Why the noise is not known; `null` where it is.
    pub noise_cannot_be_told: Option<&'static str>,
    /// What each way to find the noise says.
    pub noise_estimates: Vec<NoiseEstimate>,
    /// Frequency of a line that stands out above the band.
    pub line_above_the_band_hz: Option<f64>,
    /// What each effect that was asked and refused would do, the strongest first.
    pub refused: Vec<Asked>,
    /// What all of them together would do; `null` where that was not tried.
    pub refused_together: Option<Gain>,
    /// What a model with effects whose values are not believed would leave, where that is surely less.
    pub better_left_out_error: Option<f64>,
    /// Whether less is left than the instrument's own noise.
    pub below_the_noise: bool,
    /// Whether fitting the declared numbers again made the left-out error worse.
    pub worse_by_refitting: bool,
    /// Whether nothing can be learnt: what is explained never moves, or does not follow the model.
    pub teaches_nothing: bool,
}

/// What one way to find the noise says.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct NoiseEstimate {
    /// The way.
    pub method: &'static str,
    /// Noise in the band, root mean square.
    pub value: Option<f64>,
    /// Why it says nothing.
    pub why_not: Option<&'static str>,
}

/// What an effect that was refused would do.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Asked {
    /// Name of the effect.
    pub name: &'static str,
    #[serde(flatten)]
    gain: Gain,
}

/// What something that was refused would do to the error.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Gain {
    /// By how many per cent the error falls; negative where it rises.
    pub error_falls_percent: Option<f64>,
    /// How many standard errors that is from nothing.
    pub standard_errors: Option<f64>,
    /// The most that it may be (95 %).
    pub at_most_percent: Option<f64>,
}

impl From<GainFact> for Gain {
    fn from(gain: GainFact) -> Gain {
        Gain {
            error_falls_percent: finite(100.0 * gain.fall()),
            standard_errors: finite(gain.sure()),
            at_most_percent: finite(100.0 * gain.most()),
        }
    }
}

/// Error of the model, from the declared one to the final one.
#[derive(Debug, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Errors {
    /// As declared.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub declared: Option<Error>,
    /// With the artefacts of the measurement taken out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub artefacts: Option<Error>,
    /// With the declared numbers fitted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refit: Option<Error>,
    /// The final model.
    #[serde(rename = "final", skip_serializing_if = "Option::is_none")]
    pub last: Option<Error>,
    /// What was added, in order; an effect that the final model does not have was taken back.
    pub steps: Vec<Added>,
}

/// Error at one point of the story.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Error {
    /// On the logs for fitting, root mean square.
    pub fit: Option<f64>,
    /// On what was held out.
    pub held_out: Option<f64>,
    /// Variance accounted for on the logs for fitting, in per cent.
    pub fit_vaf: Option<f64>,
    /// Variance accounted for on what was held out, in per cent.
    pub held_out_vaf: Option<f64>,
    /// `fit` in times of the instrument's noise; `null` where that is not known.
    pub fit_times_the_noise: Option<f64>,
    /// `held_out` in times of the instrument's noise.
    pub held_out_times_the_noise: Option<f64>,
}

impl Error {
    fn new(stage: &StageFact, floor: Option<f64>) -> Error {
        let times = |error: f64| floor.and_then(|floor| finite(error / floor));
        Error {
            fit_times_the_noise: times(stage.fit),
            held_out_times_the_noise: stage.held_out.and_then(times),
            fit: finite(stage.fit),
            held_out: stage.held_out.and_then(finite),
            fit_vaf: StageFact::vaf(stage.fit_vaf),
            held_out_vaf: stage.held_out_vaf.and_then(StageFact::vaf),
        }
    }
}

/// Error after something was added.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Added {
    /// What was added.
    pub name: String,
    /// Whether the final model does not have it.
    pub taken_back: bool,
    #[serde(flatten)]
    error: Error,
}

/// Something that was found in a log.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Finding<'a> {
    /// Its kind: `scale`, `sign`, `unrelated`, `controller`, `late`, `held`, `stale`, `clipped`, `spikes`, `irregular`,
    /// `owns_the_error`, `excluded`, `zero` or `estimated`.
    pub kind: &'static str,
    /// The log.
    pub log: &'a str,
    /// In words.
    pub detail: String,
    /// Whether channels contradict each other, so that nothing can be learnt.
    pub contradicts: bool,
}

/// An artefact of the measurement.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Artefact<'a> {
    /// `lag`, `gain`, `sign` or `zero`.
    pub kind: &'static str,
    /// The channel.
    pub channel: &'a str,
    /// How much.
    pub value: Option<f64>,
    /// Unit of the value.
    pub unit: &'static str,
}

/// A fitted number.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Parameter<'a> {
    /// Its name.
    pub name: &'a str,
    /// As declared.
    pub declared: Option<f64>,
    /// As fitted; the declared one where the logs do not show it.
    pub fitted: Option<f64>,
    /// ± of 95 %, with what is undecided; `null` where it was held.
    pub plus_minus: Option<f64>,
    /// Standard error of the model that is named; `null` where it was held.
    pub standard_error: Option<f64>,
    /// The effect that these logs neither show nor rule out and that would move it most, and how far that counts; `null` where
    /// there is none.
    pub undecided: Option<Undecided>,
    /// Unit of all three.
    pub unit: &'static str,
}

/// What an effect that is not decided would make of a number.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Undecided {
    /// Which effect.
    pub effect: &'static str,
    /// A second one that hides it, where there is one.
    pub beside: Option<&'static str>,
    /// By how much the number would differ, times how likely the effects lower the error on other data; in the number's unit,
    /// added to the standard error as the root of squares.
    pub by: f64,
}

/// An effect that the declared model lacked.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Effect<'a> {
    /// Its name.
    pub name: &'static str,
    /// The equation that shows it.
    pub equation: &'static str,
    /// What it adds, as a formula.
    pub formula: &'static str,
    /// Its numbers.
    pub parameters: Vec<Parameter<'a>>,
    /// What it adds to the target, root mean square.
    pub size_rms: Option<f64>,
    /// Unit of that and of the errors.
    pub unit: &'static str,
    /// Held-out error without it.
    pub held_out_before: Option<f64>,
    /// Held-out error with it.
    pub held_out_after: Option<f64>,
    /// Effects that these logs cannot separate from it.
    pub confounded_with: Vec<&'static str>,
    /// How it enters the model of the choice.
    pub enters: &'static str,
}

/// An effect that was not added.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Refused<'a> {
    /// Its name.
    pub name: &'a str,
    /// Why, in words.
    pub reason: &'a str,
    /// The equation that was asked.
    pub equation: &'static str,
    /// There and true where its regressor is made of the response that it would explain.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub made_of_the_response: bool,
    /// Where it is: what would show the effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shown_by: Option<&'static str>,
}

/// What is left and on what it depends.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Unexplained<'a> {
    /// On what.
    pub depends_on: &'static str,
    /// In words.
    pub detail: &'a str,
    /// The equation that leaves it.
    pub equation: &'static str,
}

/// Covariance of all fitted numbers.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Covariance<'a> {
    /// Names of the numbers.
    pub names: &'a [String],
    /// Row by row, in their order.
    pub matrix: Vec<Vec<Option<f64>>>,
}

/// A log.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Log<'a> {
    /// Its name.
    pub name: &'a str,
    /// How it was taken.
    pub kind: &'static str,
    /// `fit` or `held_out`.
    #[serde(rename = "use")]
    pub usage: &'static str,
    /// Lines.
    pub rows: usize,
    /// SHA-256 of the file.
    pub sha256: &'a str,
    /// What was noticed in reading it.
    pub remarks: &'a [String],
    /// Channels that have one value throughout.
    pub stuck_channels: Vec<&'static str>,
}

/// The position simulated forward.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Forward<'a> {
    /// Error of the declared model, root mean square.
    pub declared: FitAndHeld,
    /// Error of the fitted model.
    pub fitted: FitAndHeld,
    /// Error of the model fitted for simulation, where one was.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fitted_for_simulation: Option<FitAndHeld>,
    /// Unit of the errors.
    pub unit: &'static str,
    /// Whether the goal went through the declared controller.
    pub closed_loop: bool,
    /// Numbers of the model fitted for simulation.
    pub parameters_for_simulation: Pairs<'a>,
    /// Effects without which the simulation is better on parts of the logs that were left out.
    pub without: Vec<&'a str>,
    /// What is not simulated.
    pub not_simulated: Vec<&'a str>,
}

/// An error on both parts of the logs.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct FitAndHeld {
    /// On the logs for fitting.
    pub fit: Option<f64>,
    /// On what was held out.
    pub held_out: Option<f64>,
}

impl From<SimulationErrors> for FitAndHeld {
    fn from(errors: SimulationErrors) -> FitAndHeld {
        FitAndHeld { fit: finite(errors.fit), held_out: errors.held_out.and_then(finite) }
    }
}

/// What the logs of a bench say.
pub fn json(
    bench: &Bench,
    reports: &[Report],
    forward: Option<&ForwardCheck>,
    remade: Option<&[remake::Remade]>,
    plan: Option<Planned>,
) -> Value {
    document("identify", Answer::new(bench, reports, forward, remade, plan))
}

impl<'a> Answer<'a> {
    /// What the logs of a bench say.
    pub(super) fn new(
        bench: &'a Bench,
        reports: &'a [Report],
        forward: Option<&'a ForwardCheck>,
        remade: Option<&'a [remake::Remade]>,
        plan: Option<Planned<'a>>,
    ) -> Answer<'a> {
        let (first, further) = reports.split_first().map_or((None, reports), |(first, further)| (Some(first), further));
        let of_all = |first| {
            let mut top = Equation::new(bench, first);
            top.verdict = overall(reports).word();
            top.effects = reports.iter().flat_map(|r| r.effects.iter().map(|e| Effect::new(bench, r, e))).collect();
            top.refused = refused(reports).into_iter().map(|(r, target)| Refused::new(r, target)).collect();
            top.unexplained = reports.iter().flat_map(unexplained).collect();
            top
        };
        Answer {
            bench: &bench.name,
            sentence: sentence(bench, reports),
            equation: first.map(of_all),
            logs: bench.logs.iter().map(Log::new).collect(),
            further: further.iter().map(|r| Equation::new(bench, r)).collect(),
            forward: forward.map(Forward::new),
            design: remade.map(Remade::new),
            plan,
        }
    }
}

impl<'a> Equation<'a> {
    fn new(bench: &Bench, report: &'a Report) -> Equation<'a> {
        let artefact = |a: &'a fact::Artefact| Artefact {
            kind: a.kind.name(),
            channel: &a.channel,
            value: finite(a.value),
            unit: unit_on(bench, a.unit),
        };
        Equation {
            target: report.target.name(),
            unit: report.unit,
            noise_floor: report.evidence.noise.floor().and_then(finite),
            evidence: Evidence::new(&report.evidence),
            verdict: report.verdict.word(),
            band_hz: report.band.and_then(finite),
            samples: report.samples.0,
            rows: report.samples.1,
            errors: Errors::new(&report.stages, report.evidence.noise.floor()),
            findings: report.findings.iter().map(|f| Finding::new(bench, f)).collect(),
            artefacts: report.artefacts.iter().map(artefact).collect(),
            parameters: report.parameters.iter().map(|p| Parameter::new(bench, p)).collect(),
            effects: report.effects.iter().map(|e| Effect::new(bench, report, e)).collect(),
            refused: report.refused.iter().map(|r| Refused::new(r, report.target)).collect(),
            unexplained: unexplained(report).collect(),
            next_runs: &report.next_runs,
            remarks: &report.remarks,
            covariance: Covariance {
                names: &report.fitted_names,
                matrix: report.covariance.iter().map(|row| row.iter().map(|v| finite(*v)).collect()).collect(),
            },
        }
    }
}

impl<'a> Finding<'a> {
    fn new(bench: &Bench, finding: &'a fact::Finding) -> Finding<'a> {
        Finding {
            kind: finding.about.name(),
            log: &finding.log,
            detail: finding_words(bench, &finding.about),
            contradicts: finding.about.contradicts(),
        }
    }
}

impl Evidence {
    fn new(evidence: &fact::Evidence) -> Evidence {
        let estimates = evidence.noise.estimates.iter().map(|e| NoiseEstimate {
            method: e.method.name(),
            value: e.value.ok().and_then(finite),
            why_not: e.value.err(),
        });
        Evidence {
            left_out_error: finite(evidence.left),
            far_off_percent: evidence.far_off.map(|share| 100.0 * share),
            times_the_noise: evidence.times_the_noise().and_then(finite),
            noise_cannot_be_told: evidence.noise.told().err(),
            noise_estimates: estimates.collect(),
            line_above_the_band_hz: evidence.noise.line.and_then(finite),
            refused: evidence.asked.iter().map(|a| Asked { name: a.name, gain: a.gain.into() }).collect(),
            refused_together: evidence.together.map(Gain::from),
            better_left_out_error: evidence.better.and_then(finite),
            below_the_noise: evidence.is_below_the_noise(),
            worse_by_refitting: evidence.worse_by_refitting,
            teaches_nothing: evidence.teaches_nothing(),
        }
    }
}

impl Errors {
    fn new(stages: &[StageFact], floor: Option<f64>) -> Errors {
        let mut errors = Errors::default();
        for stage in stages {
            let error = Error::new(stage, floor);
            match stage.step {
                Step::Declared => errors.declared = Some(error),
                Step::Artefacts => errors.artefacts = Some(error),
                Step::Refit => errors.refit = Some(error),
                Step::Final => errors.last = Some(error),
                Step::Added(..) | Step::Lag => {
                    errors.steps.push(Added { name: stage.step.name(), taken_back: stage.taken_back, error });
                }
            }
        }
        errors
    }
}

impl<'a> Parameter<'a> {
    fn new(bench: &Bench, p: &'a fact::Parameter) -> Parameter<'a> {
        Parameter {
            name: &p.name,
            declared: p.declared.and_then(finite),
            fitted: finite(p.fitted),
            plus_minus: p.tolerance().and_then(finite),
            standard_error: p.standard_error.and_then(finite),
            undecided: p.undecided.map(|u| Undecided {
                effect: u.effect.name(),
                beside: u.beside.map(|e| e.name()),
                by: u.by,
            }),
            unit: unit_on(bench, p.unit),
        }
    }
}

impl<'a> Effect<'a> {
    fn new(bench: &Bench, report: &Report, found: &'a Found) -> Effect<'a> {
        Effect {
            name: found.name(),
            equation: report.target.name(),
            formula: found.effect.equation(),
            parameters: found.parameters.iter().map(|p| Parameter::new(bench, p)).collect(),
            size_rms: finite(found.size),
            unit: report.unit,
            held_out_before: found.held_out_before.and_then(finite),
            held_out_after: found.held_out_after.and_then(finite),
            confounded_with: found.confounded_with.iter().map(|e| e.name()).collect(),
            enters: found.effect.kind_of_entry().words(),
        }
    }
}

impl<'a> Refused<'a> {
    fn new(refusal: &'a fact::Refused, target: Target) -> Refused<'a> {
        let shown_by = match refusal.ground {
            Ground::Response(by) => Some(by),
            _ => None,
        };
        Refused {
            name: &refusal.name,
            reason: &refusal.reason,
            equation: target.name(),
            made_of_the_response: shown_by.is_some(),
            shown_by,
        }
    }
}

fn unexplained(report: &Report) -> impl Iterator<Item = Unexplained<'_>> {
    report.unexplained.iter().map(|u| Unexplained {
        depends_on: u.depends_on.name(),
        detail: &u.detail,
        equation: report.target.name(),
    })
}

impl<'a> Log<'a> {
    fn new(log: &'a LogFact) -> Log<'a> {
        Log {
            name: &log.name,
            kind: log.kind.name(),
            usage: used(log),
            rows: log.len(),
            sha256: &log.hash,
            remarks: &log.remarks,
            stuck_channels: stuck(log),
        }
    }
}

impl<'a> Forward<'a> {
    /// Of a forward check.
    pub fn new(check: &'a ForwardCheck) -> Forward<'a> {
        Forward {
            declared: check.before.into(),
            fitted: check.after.into(),
            fitted_for_simulation: check.refitted.map(FitAndHeld::from),
            unit: check.unit,
            closed_loop: check.closed_loop,
            parameters_for_simulation: Pairs::of(check.refitted_parameters.iter().map(|(n, v)| (n.as_str(), *v))),
            without: check.without.iter().map(AsRef::as_ref).collect(),
            not_simulated: check.not_simulated.iter().map(AsRef::as_ref).collect(),
        }
    }
}
