//! The equation, made of the stretches of all logs that take part.

use super::grid::{Gridded, Signs};
use super::layout::{choose_band, lay_out};
use super::model::Model;
use super::stretch::{Corrections, Stretch, stretch};
use super::targets::{BaseTerm, balanced};
use crate::answer::Target;
use crate::identify::regression::Rows;
use crate::{Bench, BenchKind, Channel, Declared, Use, signals};
use gearwise_model::effects::{Operating, Scale, Variable};

/// The equation, ready for regression.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Which.
    pub target: Target,
    /// Unit of the target.
    pub unit: &'static str,
    /// Parameters of the declared model.
    pub base: Vec<BaseTerm>,
    /// Indices of the bench's logs that take part.
    pub logs: Vec<usize>,
    /// Names of these logs.
    pub names: Vec<String>,
    /// Where the rows come from.
    pub rows: Rows,
    /// Cut-off of the filter \[Hz\]; `None` for steady tables.
    pub band: Option<f64>,
    /// What plausible parameters are compared with.
    pub scale: Scale,
    /// Which variables the logs have.
    pub variables: Vec<Variable>,
    /// Torque at the motor becomes the target by this factor (N, minus where the sensor sees it missing).
    pub factor: f64,
    /// Whether only one whole log was there, so that parts of it judge.
    pub split_log: bool,
    /// What should be known about the preparation.
    pub remarks: Vec<String>,
    /// Whether the terminal voltage is a channel, and not duty times supply.
    pub(super) has_measured_volts: bool,
    /// Whether the supply voltage is a channel.
    pub(super) has_measured_supply: bool,
    /// Whether the drive torque follows from duty and supply, and not from a current.
    pub(super) is_duty_driven: bool,
    pub(super) stretches: Vec<Stretch>,
}

/// What a balance is built with.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Corrections of the measurement.
    pub corrections: Corrections,
    /// Cut-off \[Hz\], or chosen from the data.
    pub band: Option<f64>,
    /// Most rows that the regression sees.
    pub rows: usize,
    /// Most samples of each stretch that are looked at at all, from its middle: a part is enough to find a lag.
    pub samples: usize,
}

/// Most rows that regressions see.
pub const ROWS: usize = 24_000;

impl Setting {
    /// Nothing corrected, and everything looked at.
    pub fn uncorrected(bench: &Bench, band: Option<f64>) -> Setting {
        Setting { corrections: Corrections::none(bench.logs.len()), band, rows: ROWS, samples: usize::MAX }
    }
}

impl Balance {
    /// Builds the equation of a target from a bench. `None` where nothing usable is left.
    pub fn new(bench: &Bench, target: Target, setting: &Setting) -> Option<Balance> {
        let balanced = balanced(target)?;
        let declared = &bench.declared;
        let model = Model::new(declared);
        let linear = declared.motor.is_none();
        let logs: Vec<usize> = (0..bench.logs.len()).filter(|l| balanced.serves(&bench.logs[*l], bench)).collect();
        let mut remarks = Vec::new();
        let mut stretches = Vec::new();
        for (index, l) in logs.iter().enumerate() {
            let log = &bench.logs[*l];
            let ranges = match log.kind {
                BenchKind::SteadyTable => vec![(0..log.len(), 0.0)],
                _ => {
                    let step = signals::median_step(&log.time);
                    signals::stretches(&log.time).into_iter().map(|r| (r, step)).collect()
                }
            };
            let mut short = 0;
            for (range, step) in ranges {
                let spare = range.len().saturating_sub(setting.samples) / 2;
                let range = range.start + spare..range.end - spare;
                if range.len() < 16 {
                    short += range.len();
                    continue;
                }
                let start = log.time[range.start];
                let count = if step > 0.0 {
                    ((log.time[range.end - 1] - start) / step).round() as usize + 1
                } else {
                    range.len()
                };
                let signs = setting.corrections.signs.get(index).copied().unwrap_or(Signs::DECLARED);
                let grid = Gridded { log, range, start, step, count, linear, signs };
                let gain = setting.corrections.gains.get(index).copied().unwrap_or(1.0);
                match stretch(&grid, index, balanced, declared, &model, &setting.corrections, gain) {
                    Some(s) => stretches.push(s),
                    None => remarks.push(format!("{}: a stretch lacks a channel and was left out", log.name)),
                }
            }
            if short > 0 {
                remarks.push(format!("{}: {short} samples between gaps were left out", log.name));
            }
        }
        if !stretches.iter().any(|s| s.fits) {
            return None;
        }
        let variables = variables(&stretches, target, declared);
        let first = logs.iter().find(|l| bench.logs[**l].usage == Use::Fit).unwrap_or(&logs[0]);
        let base = balanced.parameters(&model, declared, &bench.logs[*first]);
        let factor = balanced.factor(declared.ratio);
        let scale = scale(&stretches, &model, target, factor);
        let band = choose_band(&mut stretches, target, factor, &scale, setting.band, &model);
        let usage: Vec<Use> = logs.iter().map(|l| bench.logs[*l].usage).collect();
        let (rows, split_log) = lay_out(&mut stretches, target, band, &usage, setting.rows);
        let balance = Balance {
            target,
            unit: balanced.unit(linear),
            base,
            names: logs.iter().map(|l| bench.logs[*l].name.clone()).collect(),
            rows,
            band,
            scale,
            variables,
            factor,
            split_log,
            remarks,
            has_measured_volts: logs.iter().any(|l| bench.logs[*l].channel(Channel::Voltage).is_some()),
            has_measured_supply: logs.iter().any(|l| bench.logs[*l].channel(Channel::Supply).is_some()),
            is_duty_driven: target == Target::Drive
                && logs.iter().all(|l| bench.logs[*l].channel(Channel::Current).is_none()),
            logs,
            stretches,
        };
        (balance.rows.len() >= 8).then_some(balance)
    }
}

/// Which variables vary enough to say something.
fn variables(stretches: &[Stretch], target: Target, declared: &Declared) -> Vec<Variable> {
    let spread = |f: &dyn Fn(&Operating) -> f64| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in stretches.iter().filter(|s| s.fits).flat_map(|s| &s.points) {
            let v = f(p);
            if v.is_nan() {
                return 0.0;
            }
            (low, high) = (low.min(v), high.max(v));
        }
        high - low
    };
    let mut found = vec![Variable::Constant];
    let mut add = |variable, enough: bool| {
        if enough {
            found.push(variable);
        }
    };
    add(Variable::Speed, spread(&|p| p.speed) > 0.0);
    add(Variable::Angle, spread(&|p| p.angle) > std::f64::consts::TAU);
    let turns = if target == Target::Drive { 0.2 } else { std::f64::consts::TAU };
    add(Variable::OutputAngle, declared.motor.is_some() && spread(&|p| p.output_angle) > turns);
    add(Variable::Current, spread(&|p| p.current) > 0.0);
    add(Variable::Torque, spread(&|p| p.torque) > 0.0);
    add(Variable::TorqueCurvature, spread(&|p| p.torque_curvature) > 0.0);
    add(Variable::WindingTemperature, spread(&|p| p.winding_rise) > 3.0);
    add(Variable::HousingTemperature, spread(&|p| p.housing_rise) > 3.0);
    add(Variable::Duty, spread(&|p| p.duty) > 0.0);
    found
}

fn scale(stretches: &[Stretch], model: &Model, target: Target, factor: f64) -> Scale {
    let largest = |f: &dyn Fn(&Operating) -> f64| {
        let values = stretches.iter().filter(|s| s.fits).flat_map(|s| &s.points).map(|p| f(p).abs()).collect();
        signals::quantile(values, 0.995).unwrap_or(f64::NAN)
    };
    let current = largest(&|p| p.current);
    // Where it is driven from outside and its current is next to none, the sensor says how large torques are, whatever its
    // zero; without any current nothing is known, and nothing is too large.
    let read: Vec<f64> = stretches.iter().filter(|s| s.fits).flat_map(|s| &s.target).copied().collect();
    let at = |share: f64| signals::quantile(read.clone(), share).unwrap_or(0.0);
    let sensed = if target == Target::Torque { 0.5 * (at(0.995) - at(0.005)) / factor.abs() } else { 0.0 };
    let driven = (model.torque_constant * current).max(largest(&|p| p.torque));
    let torque = if driven.is_nan() { driven } else { driven.max(sensed) };
    let volts = stretches.iter().filter(|s| s.fits).flat_map(|s| &s.target).map(|v| v.abs()).collect();
    Scale {
        torque_constant: model.torque_constant,
        resistance: model.resistance,
        torque,
        speed: largest(&|p| p.speed).max(f64::MIN_POSITIVE),
        current,
        voltage: if target == Target::Voltage { signals::quantile(volts, 0.995).unwrap_or(f64::NAN) } else { f64::NAN },
    }
}
