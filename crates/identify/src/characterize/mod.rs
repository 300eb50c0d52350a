//! From raw bench logs to a catalogue row: R, L, K_T, K_B, J, friction and heat of a motor, each with its
//! uncertainty (design: Urs et al., section IV).
//!
//! The one idea: every test of a motor is one entry of `TESTS`. It takes its logs, says by which method it came to
//! which [`Quantity`] with which uncertainty, judges itself ([`Finding`]) and shows itself ([`Chart`]). What only
//! several tests together can say is an entry of [`checks::CHECKS`]; the row is made of all of it by [`row`].

pub mod backdrive;
pub mod checks;
pub mod drag;
pub mod estimate;
pub mod line;
pub mod random_torque;
pub mod rotor;
pub mod row;
pub mod stall;
pub mod terminals;
pub mod thermal_step;

use self::estimate::Estimate;
use crate::bench::{Bench, BenchKind, Channel, Log, Use};

/// A way to learn something of a motor.
pub trait Test: Sync {
    /// Its name in a bench file.
    fn name(&self) -> &'static str;
    /// What it makes of the bench; `None` where the bench has nothing for it.
    fn run(&self, bench: &Bench, before: &[Outcome]) -> Option<Outcome>;
}

/// Every test; a later one may use what earlier ones found.
pub(crate) const TESTS: &[&dyn Test] = &[
    &terminals::Terminals,
    &stall::Stall,
    &backdrive::Backdrive,
    &random_torque::RandomTorque,
    &rotor::Rotor,
    &drag::Drag,
    &thermal_step::ThermalStep,
];

/// A number that a test found.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its name: the column of a catalogue row, where there is one.
    pub name: &'static str,
    /// With its uncertainty; SI, at the motor and on the q axis unless the name says otherwise.
    pub estimate: Estimate,
    /// Unit.
    pub unit: &'static str,
    /// What a reader should know of it, short.
    pub remark: String,
}

/// How much a finding weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Weight {
    /// As it should be.
    Good,
    /// To be known.
    Note,
    /// A number may be wrong.
    Warning,
}

impl Weight {
    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Weight::Good => "good",
            Weight::Note => "note",
            Weight::Warning => "warning",
        }
    }
}

/// What a check has to say.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The check.
    pub check: &'static str,
    /// How much it weighs.
    pub weight: Weight,
    /// In words.
    pub text: String,
}

impl Finding {
    /// A finding of a check.
    pub fn new(check: &'static str, weight: Weight, text: impl Into<String>) -> Finding {
        Finding { check, weight, text: text.into() }
    }
}

/// How a curve is to be drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Measured points.
    Measured,
    /// A measured curve.
    Curve,
    /// What was fitted.
    Fit,
    /// What stands for the fit where it has no room: the row's line.
    Stand,
}

/// Points that belong together.
#[derive(Debug, Clone)]
pub struct Curve {
    /// How it is to be drawn.
    pub role: Role,
    /// What it is.
    pub name: String,
    /// The points.
    pub points: Vec<(f64, f64)>,
}

impl Curve {
    /// A curve with its name.
    pub fn new(role: Role, name: impl Into<String>, points: Vec<(f64, f64)>) -> Curve {
        Curve { role, name: name.into(), points }
    }
}

/// A picture as data.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    /// Which test it belongs to.
    pub test: &'static str,
    /// Abscissa with its unit.
    pub x: String,
    /// Ordinate with its unit.
    pub y: String,
    /// Abscissa in decades.
    pub log_x: bool,
    /// Ordinate in decades.
    pub log_y: bool,
    /// The curves, the lowest first.
    pub curves: Vec<Curve>,
    /// Interval of 95 % of the fit: abscissa, lower and upper end.
    pub band: Vec<(f64, f64, f64)>,
    /// Abscissae of the ends of the band that was used.
    pub marks: Vec<f64>,
}

/// What one log gave.
#[derive(Debug, Clone, PartialEq)]
pub struct PerLog {
    /// The log.
    pub log: String,
    /// Whether it counts.
    pub used: bool,
    /// Its numbers: name, with uncertainty, unit.
    pub values: Vec<(&'static str, Estimate, &'static str)>,
    /// What is said of it.
    pub remarks: Vec<String>,
}

/// What a test made of the bench.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// The test.
    pub test: &'static str,
    /// How it was done, with the numbers that were chosen on the way.
    pub method: Vec<String>,
    /// What it found.
    pub quantities: Vec<Quantity>,
    /// What each log gave.
    pub logs: Vec<PerLog>,
    /// What its own checks say.
    pub findings: Vec<Finding>,
    /// Its pictures.
    pub charts: Vec<Chart>,
}

/// All that the bench says.
#[derive(Debug, Clone)]
pub struct Characterization {
    /// One for each test that the bench has.
    pub outcomes: Vec<Outcome>,
    /// What only several tests together say.
    pub findings: Vec<Finding>,
    /// The row.
    pub row: row::Row,
}

/// A quantity among outcomes.
pub fn find(outcomes: &[Outcome], name: &str) -> Option<Estimate> {
    outcomes.iter().flat_map(|o| &o.quantities).find(|q| q.name == name).map(|q| q.estimate)
}

/// The logs of a kind that may be used to fit.
pub(crate) fn logs_of(bench: &Bench, kind: BenchKind) -> Vec<&Log> {
    bench.logs.iter().filter(|l| l.kind == kind && l.usage == Use::Fit).collect()
}

/// With what the calibration of the instruments leaves open: a gain is common to all logs of a test and does not
/// average out. Each quantity is measured by one of some channels, and enters with a power.
pub(crate) fn calibrated(estimate: Estimate, logs: &[&Log], by: &[(&[Channel], f64)]) -> Estimate {
    let mut parts = vec![estimate.half_width()];
    for (channels, power) in by {
        let of = |log: &&Log| channels.iter().filter_map(|c| log.gains.get(c)).copied().fold(0.0, f64::max);
        let gain = logs.iter().map(of).fold(0.0, f64::max);
        parts.push(power * estimate.value * gain);
    }
    // Half-widths, with the degrees of freedom of the logs: those of Welch and Satterthwaite would grow, and a gain that
    // is not exact would make the interval of few logs narrower.
    let half = parts.iter().map(|p| p * p).sum::<f64>().sqrt();
    let standard_uncertainty = half / estimate::quantile(0.975, estimate.freedom);
    Estimate { standard_uncertainty, ..estimate }
}

/// Says which instruments count as exact, because their columns do not say how well they are calibrated.
pub fn calibration(logs: &[&Log], channels: &[Channel]) -> Option<Finding> {
    let silent = |c: &&Channel| logs.iter().any(|l| l.channel(**c).is_some() && !l.gains.contains_key(*c));
    let exact: Vec<&str> = channels.iter().filter(silent).map(|c| c.word()).collect();
    (!exact.is_empty()).then(|| {
        let text = format!(
            "the gain of {} counts as exact: `gain_tolerance = \"0.5 %\"` in the column puts the calibration into the ±",
            exact.join(" and of ")
        );
        Finding::new("calibration", Weight::Note, text)
    })
}

/// Runs every test that the bench has.
///
/// # Errors
/// In words, where the bench has nothing that any test could use.
pub fn characterize(bench: &Bench) -> Result<Characterization, String> {
    if bench.declared.mass.is_some() {
        return Err("a linear axis has no motor of a catalogue: `identify` fits it".into());
    }
    let mut outcomes: Vec<Outcome> = Vec::new();
    for test in TESTS {
        if let Some(outcome) = test.run(bench, &outcomes) {
            outcomes.push(Outcome { test: test.name(), ..outcome });
        }
    }
    if outcomes.is_empty() {
        let names: Vec<&str> = TESTS.iter().map(|t| t.name()).collect();
        return Err(format!("nothing here characterises a motor: there are the tests {}", names.join(", ")));
    }
    let findings = checks::run(bench, &outcomes);
    let row = row::row(bench, &outcomes);
    Ok(Characterization { outcomes, findings, row })
}
