//! One equation of the actuator, made of logs: target, the terms that the declared model has, and the
//! operating points that further effects are functions of.
//!
//! The one idea: whatever the bench, the equation reads `target = Σ known parameter · column + Σ effect`,
//! each term through the same filter. What differs between benches is only which channel is the target
//! and which sign an effect has: a torque sensor sees friction as missing, a drive that moves a known load
//! as needed.

use std::ops::Range;

use super::noise::{Reading, Unfiltered};
use super::origin::{Channels, Origins, Signal};
use super::regression::Rows;
use crate::effects::{Effect, Equation, Operating, Scale, Variable};
use crate::measured::signals::{self, LowPass};
use crate::measured::{Bench, BenchKind, Channel, Declared, Log, Use};

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

    /// Whether its sensor has a zero that belongs to the log.
    pub fn has_zero(self) -> bool {
        matches!(self, Target::Torque | Target::WindUp)
    }
}

/// A parameter of the declared model.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseTerm {
    /// Name.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Declared value; `None` where the model does not say.
    pub declared: Option<f64>,
}

/// Corrections of the measurement that are applied before anything is compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrections {
    /// How late the target is \[s\].
    pub target_lag: f64,
    /// How late position and velocity are \[s\].
    pub motion_lag: f64,
    /// What each log's target is multiplied with.
    pub gains: Vec<f64>,
    /// Load-dependent loss of the gear as far as it is known: what the transmitted torque follows with from
    /// the motor's.
    pub gear_loss: f64,
}

impl Corrections {
    /// None.
    pub fn none(logs: usize) -> Corrections {
        Corrections { target_lag: 0.0, motion_lag: 0.0, gains: vec![1.0; logs], gear_loss: 0.0 }
    }
}

/// One stretch of a log on an even grid, before the filter.
#[derive(Debug, Clone)]
struct Stretch {
    log: usize,
    step: f64,
    target: Vec<f64>,
    base: Vec<Vec<f64>>,
    /// A part of the target that is known and has no parameter.
    known: Vec<f64>,
    points: Vec<Operating>,
    origins: Origins,
    reading: Reading,
    acceleration: Vec<f64>,
    filter: Option<LowPass>,
    keep: Vec<usize>,
}

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
    has_measured_volts: bool,
    /// Whether the supply voltage is a channel.
    has_measured_supply: bool,
    /// Whether the drive torque follows from duty and supply, and not from a current.
    is_duty_driven: bool,
    stretches: Vec<Stretch>,
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

/// Which targets a bench has, the most telling first.
pub fn targets(bench: &Bench) -> Vec<Target> {
    [Target::Torque, Target::Drive, Target::Voltage, Target::WindUp]
        .into_iter()
        .filter(|t| bench.logs.iter().any(|log| serves(log, bench, *t) && log.usage == Use::Fit))
        .collect()
}

/// Whether a log takes part in a target's balance.
fn serves(log: &Log, bench: &Bench, target: Target) -> bool {
    let has = |c: Channel| log.channels.contains_key(&c);
    let moves = has(Channel::MotorVelocity)
        || has(Channel::OutputVelocity)
        || has(Channel::MotorPosition)
        || has(Channel::OutputPosition);
    match target {
        Target::Torque => match log.kind {
            BenchKind::Dynamometer | BenchKind::SteadyTable | BenchKind::RandomTorque => {
                has(Channel::Torque) && (has(Channel::Current) || moves)
            }
            BenchKind::Stall => has(Channel::Torque) && has(Channel::Current),
            BenchKind::Backdrive | BenchKind::Drag => has(Channel::Torque) && moves,
            _ => false,
        },
        Target::Drive => match log.kind {
            BenchKind::Free | BenchKind::Linear => has(Channel::Current) && moves,
            // Duty alone makes the current a function of the target: such logs are simulated instead.
            BenchKind::Servo => has(Channel::Current) && moves,
            BenchKind::Drag => !has(Channel::Torque) && has(Channel::Current) && moves,
            _ => false,
        },
        Target::Voltage => {
            let volts = has(Channel::Voltage) || (has(Channel::Duty) && has(Channel::Supply));
            let wanted = log.kind == BenchKind::Electrical || log.kind == BenchKind::Backdrive || has(Channel::Voltage);
            wanted && log.kind != BenchKind::Linear && volts && (has(Channel::Current) || moves)
        }
        // Simulated, not regressed.
        Target::Position => false,
        Target::WindUp => bench.declared.motor.is_some() && has(Channel::MotorPosition) && has(Channel::OutputPosition),
    }
}

/// The channels of one stretch on its grid.
struct Gridded<'a> {
    log: &'a Log,
    range: Range<usize>,
    start: f64,
    step: f64,
    count: usize,
    linear: bool,
}

impl Gridded<'_> {
    fn get(&self, channel: Channel) -> Option<Signal> {
        let values = self.log.channel(channel)?;
        let wraps = matches!(channel, Channel::MotorPosition | Channel::OutputPosition | Channel::Goal) && !self.linear;
        let opened;
        let values = if wraps {
            opened = signals::unwrapped(values);
            &opened
        } else {
            values
        };
        if self.step == 0.0 {
            return Some(Signal::of(channel, values[self.range.clone()].to_vec()));
        }
        signals::on_grid(
            &self.log.time[self.range.clone()],
            &values[self.range.clone()],
            self.start,
            self.step,
            self.count,
        )
        .map(|values| Signal::of(channel, values))
    }

    fn shifted(&self, channel: Channel, lag: f64) -> Option<Signal> {
        self.get(channel).map(|signal| self.late(&signal, lag))
    }

    /// A signal put right by its lag \[s\].
    fn late(&self, signal: &Signal, lag: f64) -> Signal {
        if self.step > 0.0 { signal.through(|v| signals::shifted(v, lag / self.step)) } else { signal.clone() }
    }

    /// The derivative; zero where there is no time axis.
    fn derivative(&self, signal: &Signal) -> Signal {
        if self.step > 0.0 { signal.through(|v| signals::derivative(v, self.step)) } else { signal.map(|_| 0.0) }
    }

    fn second_derivative(&self, signal: &Signal) -> Signal {
        signal.through(|v| second_derivative(v, self.step))
    }
}

/// The inductance is seen only with a time axis; numbers of the declared model that the balances use.
struct Model {
    torque_constant: f64,
    resistance: f64,
    inductance: Option<f64>,
    back_emf: f64,
    inertia: Option<f64>,
    reference: f64,
    viscous: Option<f64>,
    coulomb: Option<f64>,
}

impl Model {
    fn new(declared: &Declared) -> Model {
        match &declared.motor {
            Some(motor) => Model {
                torque_constant: motor.torque_constant,
                resistance: motor.resistance,
                inductance: motor.inductance,
                back_emf: motor.back_emf_constant,
                inertia: motor.rotor_inertia.map(|j| j + declared.gear.inertia),
                reference: motor.reference_temperature,
                viscous: motor.viscous_friction,
                coulomb: motor.coulomb_friction,
            },
            None => Model {
                torque_constant: declared.force_gain,
                resistance: f64::NAN,
                inductance: None,
                back_emf: 0.0,
                inertia: declared.mass,
                reference: crate::catalog::REFERENCE_TEMPERATURE,
                viscous: declared.viscous_friction,
                coulomb: declared.coulomb_friction,
            },
        }
    }
}

/// Declared friction: it is a parameter of the model, not a candidate.
pub fn declared_effects(declared: &Declared) -> Vec<(&'static dyn Effect, Vec<f64>)> {
    let model = Model::new(declared);
    let mut found: Vec<(&'static dyn Effect, Vec<f64>)> = Vec::new();
    let mut add = |name: &str, values: Vec<f64>| {
        if let Some(effect) = crate::effects::effect(name)
            && !found.iter().any(|(e, _)| e.name() == name)
        {
            found.push((effect, values));
        }
    };
    for (name, values) in &declared.effects {
        add(name, values.clone());
    }
    if let Some(b) = model.viscous {
        add("viscous_friction", vec![b]);
    }
    if let Some(c) = model.coulomb {
        add("coulomb_friction", vec![c]);
    }
    if declared.gear.efficiency < 1.0 {
        add("load_dependent_friction", vec![1.0 / declared.gear.efficiency - 1.0]);
    }
    found
}

impl Balance {
    /// Builds the equation of a target from a bench. `None` where nothing usable is left.
    pub fn new(bench: &Bench, target: Target, setting: &Setting) -> Option<Balance> {
        let declared = &bench.declared;
        let model = Model::new(declared);
        let linear = declared.motor.is_none();
        let logs: Vec<usize> = (0..bench.logs.len()).filter(|l| serves(&bench.logs[*l], bench, target)).collect();
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
                let grid = Gridded { log, range, start, step, count, linear };
                let gain = setting.corrections.gains.get(index).copied().unwrap_or(1.0);
                match stretch(&grid, index, target, declared, &model, &setting.corrections, gain) {
                    Some(s) => stretches.push(s),
                    None => remarks.push(format!("{}: a stretch lacks a channel and was left out", log.name)),
                }
            }
            if short > 0 {
                remarks.push(format!("{}: {short} samples between gaps were left out", log.name));
            }
        }
        if stretches.is_empty() {
            return None;
        }
        let variables = variables(&stretches, target, declared);
        let base = base_terms(target, &model, declared, &bench.logs[logs[0]]);
        let factor = match target {
            Target::Torque => -declared.ratio,
            Target::Drive => declared.ratio,
            Target::Voltage | Target::WindUp | Target::Position => 1.0,
        };
        let mut balance = Balance {
            target,
            unit: match (target, linear) {
                (Target::Torque | Target::Drive, false) => "N*m",
                (Target::Torque | Target::Drive, true) => "N",
                (Target::Voltage, _) => "V",
                (Target::WindUp | Target::Position, _) => "rad",
            },
            base,
            names: logs.iter().map(|l| bench.logs[*l].name.clone()).collect(),
            rows: Rows::default(),
            band: None,
            scale: scale(&stretches, &model, target),
            variables,
            factor,
            split_log: false,
            remarks,
            has_measured_volts: logs.iter().any(|l| bench.logs[*l].channel(Channel::Voltage).is_some()),
            has_measured_supply: logs.iter().any(|l| bench.logs[*l].channel(Channel::Supply).is_some()),
            is_duty_driven: target == Target::Drive
                && logs.iter().all(|l| bench.logs[*l].channel(Channel::Current).is_none()),
            logs,
            stretches,
        };
        balance.choose_band(setting.band, &model);
        balance.lay_out(bench, setting.rows);
        (balance.rows.len() >= 8).then_some(balance)
    }

    /// The band: as wide as the sampling allows, but no wider than where the differentiated noise of the
    /// speed stays below the noise of the target.
    fn choose_band(&mut self, wanted: Option<f64>, model: &Model) {
        if self.stretches.iter().any(|s| s.step == 0.0) {
            return;
        }
        let slowest = self.stretches.iter().map(|s| 1.0 / s.step).fold(f64::INFINITY, f64::min);
        let inertia = model.inertia.unwrap_or(0.0) * self.factor.abs();
        let mut band = 0.2 * slowest;
        if self.target.equation() == Equation::Torque && inertia > 0.0 {
            for s in &self.stretches {
                let speed: Vec<f64> = s.points.iter().map(|p| p.speed).collect();
                let (of_speed, of_target) = (signals::noise_level(&speed), signals::noise_level(&s.target));
                let target = of_target.max(1e-6 * self.scale.torque * self.factor.abs());
                if of_speed > 0.0 {
                    // In a band f of white noise: J σ_ω 2π f/√3 against σ_target.
                    band = band.min(
                        (target * 3.0_f64.sqrt() / (inertia * of_speed * std::f64::consts::TAU)).max(0.02 / s.step),
                    );
                }
            }
        }
        let band = wanted.unwrap_or(band).min(0.45 * slowest);
        self.band = Some(band);
        for s in &mut self.stretches {
            s.filter = Some(LowPass::new(band * s.step));
        }
    }

    /// Chooses rows and blocks.
    fn lay_out(&mut self, bench: &Bench, most: usize) {
        let total: usize = self.stretches.iter().map(|s| s.target.len()).sum();
        let thin = total.div_ceil(most.max(1));
        let masks: Vec<Vec<bool>> = self.stretches.iter().map(|s| self.usable(s)).collect();
        for (s, mask) in self.stretches.iter_mut().zip(masks) {
            let n = s.target.len();
            let (guard, every) = match (&s.filter, self.band) {
                (Some(filter), Some(band)) => {
                    (filter.guard().min(n / 4), signals::whole(1.0 / (3.0 * band * s.step)).max(1))
                }
                _ => (0, 1),
            };
            s.keep = (guard..n - guard).step_by(every.max(thin)).filter(|k| mask[*k]).collect();
        }
        let rows: usize = self.stretches.iter().map(|s| s.keep.len()).sum();
        // Blocks of equal numbers of rows within a log: at least 20, at most 60 in all.
        let wanted = (rows / 40).clamp(20, 60);
        let length = rows.div_ceil(wanted).max(1);
        let mut layout = Rows::default();
        let mut logs_fit = 0;
        for index in 0..self.logs.len() {
            let fits = bench.logs[self.logs[index]].usage == Use::Fit;
            logs_fit += usize::from(fits);
            let in_log: usize = self.stretches.iter().filter(|s| s.log == index).map(|s| s.keep.len()).sum();
            let blocks = in_log.div_ceil(length).max(1);
            let each = in_log.div_ceil(blocks).max(1);
            let first = layout.block_log.len();
            let mut at = 0;
            for s in self.stretches.iter().filter(|s| s.log == index) {
                for k in &s.keep {
                    layout.log.push(index);
                    layout.block.push(first + at / each);
                    layout.time.push(*k as f64 * s.step);
                    at += 1;
                }
            }
            if in_log > 0 {
                layout.block_log.extend(std::iter::repeat_n(index, blocks));
                layout.block_fits.extend(std::iter::repeat_n(fits, blocks));
            }
        }
        let held = layout.block_fits.iter().any(|f| !f);
        if !held && logs_fit > 0 {
            // Nothing was held out: every fifth block judges.
            self.split_log = true;
            for (b, fits) in layout.block_fits.iter_mut().enumerate() {
                *fits = b % 5 != 3;
            }
        }
        self.rows = layout;
    }

    /// Samples that say something: the shaft moves, as far as the encoder can tell, and nothing is missing.
    fn usable(&self, s: &Stretch) -> Vec<bool> {
        let n = s.target.len();
        let mut mask: Vec<bool> =
            (0..n).map(|k| s.target[k].is_finite() && s.base.iter().all(|c| c[k].is_finite())).collect();
        if self.target.equation() != Equation::Torque || s.step == 0.0 {
            return mask;
        }
        let still = s.points.iter().filter(|p| p.direction.abs() < 0.999).count();
        // A stalled log stands on purpose.
        if 10 * still > 7 * n {
            return mask;
        }
        for (m, p) in mask.iter_mut().zip(&s.points) {
            *m &= p.direction.abs() > 0.5;
        }
        mask
    }

    /// One number for each row: rows are in the order of the logs, and of time within a log.
    fn gather(&self, filtered: bool, column: impl Fn(&Stretch) -> Vec<f64>) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.rows.len());
        for index in 0..self.logs.len() {
            for s in self.stretches.iter().filter(|s| s.log == index) {
                let mut values = column(s);
                if let (true, Some(filter)) = (filtered && values.iter().all(|v| v.is_finite()), &s.filter) {
                    values = filter.apply(&values);
                }
                out.extend(s.keep.iter().map(|k| values[*k]));
            }
        }
        out
    }

    /// A term of the equation: filtered, and without the zero of its log where the target has one.
    fn term(&self, column: impl Fn(&Stretch) -> Vec<f64>) -> Vec<f64> {
        let mut out = self.gather(true, column);
        if self.target.has_zero() {
            self.rows.without_means(&mut out);
        }
        out
    }

    /// The target less what is known.
    pub fn target_column(&self) -> Vec<f64> {
        self.term(|s| s.target.iter().zip(&s.known).map(|(t, k)| t - k).collect())
    }

    /// The target less what is known, with the zero of each log still in it.
    pub fn target_with_zero(&self) -> Vec<f64> {
        self.gather(true, |s| s.target.iter().zip(&s.known).map(|(t, k)| t - k).collect())
    }

    /// The column of a parameter of the declared model.
    pub fn base_column(&self, index: usize) -> Vec<f64> {
        self.term(|s| s.base[index].clone())
    }

    /// The same, with the mean of each log still in it.
    pub fn base_column_with_zero(&self, index: usize) -> Vec<f64> {
        self.gather(true, |s| s.base[index].clone())
    }

    /// The columns of an effect at a shape: one for each linear parameter.
    pub fn effect_columns(&self, effect: &dyn Effect, shape: f64) -> Vec<Vec<f64>> {
        let factor = self.conversion(effect);
        (0..effect.linear()).map(|j| self.function(|at| factor * effect.basis(shape, at)[j])).collect()
    }

    /// What a term of an effect is multiplied with to be one of this balance: a voltage that a duty-driven
    /// machine loses is a torque that it lacks, by K_T/R.
    pub fn conversion(&self, effect: &dyn Effect) -> f64 {
        if effect.acts_on() == Equation::Voltage && self.target == Target::Drive {
            self.scale.torque_constant / self.scale.resistance
        } else {
            1.0
        }
    }

    /// What an effect adds to the target, with the mean of each log still in it.
    pub fn effect_with_zero(&self, effect: &dyn Effect, values: &[f64]) -> Vec<f64> {
        let factor = self.factor * self.conversion(effect);
        self.gather(true, |s| s.points.iter().map(|p| factor * effect.value(values, p)).collect())
    }

    /// The column of any function of the operating point: a torque at the motor, a voltage or an angle.
    pub fn function(&self, f: impl Fn(&Operating) -> f64) -> Vec<f64> {
        self.term(|s| s.points.iter().map(|p| self.factor * f(p)).collect())
    }

    /// A variable of the operating point at each row, as it is or through the filter.
    pub fn variable(&self, filtered: bool, f: impl Fn(&Operating) -> f64) -> Vec<f64> {
        self.gather(filtered, |s| s.points.iter().map(&f).collect())
    }

    /// Acceleration of the motor at each row \[rad/s²\].
    pub fn acceleration(&self) -> Vec<f64> {
        self.gather(true, |s| s.acceleration.clone())
    }

    /// Whether a variable is made of the response: then a function of it explains its own noise, and whatever is
    /// in the response, with nothing of the actuator in between. A second derivative amplifies noise so much that it must
    /// not share the noise of the known load either, which stands on the same side.
    pub fn is_response(&self, variable: Variable) -> bool {
        self.stretches.iter().any(|s| {
            let from = &s.origins;
            let (made_of, explained) = match variable {
                Variable::Speed => (from.speed, from.response),
                Variable::Angle => (from.angle, from.response),
                Variable::OutputAngle => (from.output_angle, from.response),
                Variable::Current => (from.current, from.response),
                Variable::Torque => (from.torque, from.response),
                Variable::TorqueCurvature => (from.curvature, from.response | from.load),
                Variable::WindingTemperature => (from.winding, from.response),
                Variable::HousingTemperature => (from.housing, from.response),
                Variable::Duty => (from.duty, from.response),
                Variable::Constant => (Channels::NONE, from.response),
            };
            made_of.meets(explained)
        })
    }

    /// What would have to be measured for a variable not to be made of the response.
    fn shown_by(&self, variable: Variable) -> &'static str {
        match (self.target, variable) {
            (Target::Torque, _) | (Target::Drive, Variable::TorqueCurvature) => "positions on both sides of the gear",
            (Target::Drive, _) if self.unit == "N" => "a force sensor at the output",
            (Target::Drive | Target::WindUp | Target::Position, _) => "a torque sensor at the output",
            (Target::Voltage, Variable::Current) => "a measured current",
            (Target::Voltage, _) => "a measured supply voltage",
        }
    }

    /// Sampling interval of the first stretch \[s\]; zero for steady tables.
    pub fn step(&self) -> f64 {
        self.stretches.first().map_or(0.0, |s| s.step)
    }

    /// Number of samples before rows were chosen.
    pub fn samples(&self) -> usize {
        self.stretches.iter().map(|s| s.target.len()).sum()
    }

    /// What a model leaves on the samples themselves, unfiltered, of the logs that are taken (by their place among the
    /// bench's): `base` has a value for each parameter of the declared model, `effects` their values.
    pub fn unfiltered(
        &self,
        take: impl Fn(usize) -> bool,
        base: &[f64],
        effects: &[(&'static dyn Effect, Vec<f64>)],
    ) -> Vec<Unfiltered> {
        let factors: Vec<f64> = effects.iter().map(|(e, _)| self.factor * self.conversion(*e)).collect();
        let one = |s: &Stretch| {
            let model = |k: usize| {
                let known: f64 = s.base.iter().zip(base).map(|(c, b)| if *b == 0.0 { 0.0 } else { b * c[k] }).sum();
                let effects = effects.iter().zip(&factors).map(|((e, values), f)| f * e.value(values, &s.points[k]));
                s.known[k] + known + effects.sum::<f64>()
            };
            Unfiltered {
                step: s.step,
                left: (0..s.target.len()).map(|k| s.target[k] - model(k)).collect(),
                columns: s.base.iter().filter(|c| c.iter().all(|v| v.is_finite())).cloned().collect(),
                stands: s.points.iter().map(|p| p.direction.abs() < 0.5).collect(),
                reading: s.reading,
            }
        };
        let taken = self.stretches.iter().filter(|s| take(self.logs[s.log]));
        taken.map(one).filter(|u| u.left.iter().all(|v| v.is_finite())).collect()
    }
}

/// Share of the sampling rate below which the direction of motion is read.
const DIRECTION_BAND: f64 = 0.2;

/// Shaft speeds of one stretch.
struct Motion {
    motor: Signal,
    direction: Vec<f64>,
    motor_acceleration: Signal,
    output_acceleration: Signal,
}

impl Motion {
    /// Of a shaft that is held, or of which nothing is known.
    fn none(count: usize) -> Motion {
        let zero = Signal::constant(0.0, count);
        Motion {
            motor: zero.clone(),
            direction: zero.values.clone(),
            motor_acceleration: zero.clone(),
            output_acceleration: zero,
        }
    }
}

fn motion(grid: &Gridded, ratio: f64, lag: f64) -> Option<Motion> {
    let get = |c| grid.shifted(c, lag);
    let smooth = |position: Signal| {
        let speed = position.through(|v| signals::derivative(v, grid.step.max(f64::MIN_POSITIVE)));
        speed.through(|v| LowPass::new(DIRECTION_BAND).apply(v))
    };
    let motor = get(Channel::MotorVelocity).or_else(|| get(Channel::MotorPosition).map(smooth));
    let output = get(Channel::OutputVelocity).or_else(|| get(Channel::OutputPosition).map(smooth));
    let (motor, output) = match (motor, output) {
        (Some(m), Some(o)) => (m, o),
        (Some(m), None) => (m.clone(), m.map(|w| w * (1.0 / ratio))),
        (None, Some(o)) => (o.map(|w| w * ratio), o),
        (None, None) => return None,
    };
    let output_acceleration = get(Channel::OutputAcceleration).unwrap_or_else(|| grid.derivative(&output));
    let speed = &motor.values;
    let calm = if grid.step > 0.0 { LowPass::new(DIRECTION_BAND).apply(speed) } else { speed.clone() };
    let largest = speed.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let noise = if grid.step > 0.0 { signals::noise_level(speed) } else { 0.0 };
    let threshold = (2.0 * (2.0 * DIRECTION_BAND).sqrt() * noise).max(2e-3 * largest).max(f64::MIN_POSITIVE);
    let direction = calm.iter().map(|w| (w / threshold).clamp(-1.0, 1.0)).collect();
    Some(Motion { motor_acceleration: grid.derivative(&motor), motor, direction, output_acceleration })
}

fn stretch(
    grid: &Gridded,
    index: usize,
    target: Target,
    declared: &Declared,
    model: &Model,
    corrections: &Corrections,
    gain: f64,
) -> Option<Stretch> {
    let n = grid.count;
    let ratio = declared.ratio;
    let lag = corrections.motion_lag;
    let zeros = || vec![0.0; n];
    let log = grid.log;
    let moved = motion(grid, ratio, lag);
    if moved.is_none() && log.kind != BenchKind::Stall {
        return None;
    }
    let moved = moved.unwrap_or_else(|| Motion::none(n));
    let (has_motor, has_output) = (
        log.channel(Channel::MotorVelocity).or(log.channel(Channel::MotorPosition)).is_some(),
        log.channel(Channel::OutputVelocity).or(log.channel(Channel::OutputPosition)).is_some(),
    );
    let motor_angle = grid.shifted(Channel::MotorPosition, lag);
    let output_angle = grid.shifted(Channel::OutputPosition, lag);
    let angle = motor_angle.clone().or_else(|| output_angle.as_ref().map(|o| o.map(|q| q * ratio)));
    let out_angle = output_angle.clone().or_else(|| motor_angle.as_ref().map(|m| m.map(|q| q / ratio)));
    let declared_supply = || log.controller.and_then(|c| c.supply).map(|v| Signal::constant(v, n));
    let supply = grid.get(Channel::Supply).or_else(declared_supply);
    let duty = grid.get(Channel::Duty);
    let per_volt = declared.motor.as_ref().map_or(1.0, volts_per_duty);
    let applied: Option<Signal> = grid.get(Channel::Voltage).or_else(|| {
        let (d, v) = (duty.as_ref()?, supply.as_ref()?);
        Some(d.with(v, |d, v| d * v * per_volt))
    });
    let measured_current = grid.get(Channel::Current);
    let of_voltage = || {
        let v = applied.as_ref()?;
        Some(v.with(&moved.motor, |v, w| (v - model.back_emf * w) / model.resistance))
    };
    let current: Option<Signal> = measured_current.clone().or_else(|| match (log.kind, target) {
        // Driven from outside with open terminals: what voltage and speed differ by is no current.
        (BenchKind::Backdrive, Target::Voltage) => Some(Signal::constant(0.0, n)),
        (BenchKind::Backdrive, _) => None,
        _ => of_voltage(),
    });
    let rise = |c| grid.get(c).map(|t| t.map(|t| t - model.reference));
    let winding = rise(Channel::WindingTemperature);
    let housing = rise(Channel::HousingTemperature).or_else(|| winding.clone());
    let sensor = grid.shifted(Channel::Torque, corrections.target_lag);
    let load = log.load;
    let inertia = model.inertia.unwrap_or(0.0);
    // Torque of the motor at its shaft, less what its own inertia takes.
    let motor_torque = |i: &Signal| i.with(&moved.motor_acceleration, |i, a| model.torque_constant * i - inertia * a);
    let read = |channel: Channel, scale: f64| {
        let values = log.channel(channel).map_or(&[] as &[f64], |v| &v[grid.range.clone()]);
        Reading::new(values, scale)
    };
    let reading = match target {
        Target::Torque => read(Channel::Torque, gain),
        Target::Drive if measured_current.is_some() => read(Channel::Current, ratio * model.torque_constant),
        Target::WindUp => read(Channel::MotorPosition, 1.0 / ratio).and(read(Channel::OutputPosition, 1.0)),
        _ if log.channel(Channel::Voltage).is_some() => read(Channel::Voltage, 1.0),
        _ => {
            let volts = supply.as_ref().and_then(|v| signals::median(v.values.clone())).unwrap_or(0.0);
            read(Channel::Duty, volts * per_volt)
        }
    };
    let (mut base, mut known) = (Vec::new(), zeros());
    let mut load_channels = Channels::NONE;
    let (response, transmitted, curvature): (Signal, Option<Signal>, Option<Signal>) = match target {
        Target::Torque => {
            let sensor = sensor?.map(|t| t * gain);
            base.push(current.as_ref().map_or_else(zeros, |i| i.map(|i| ratio * i).values));
            base.push(moved.motor_acceleration.map(|a| -ratio * a).values);
            for (k, a) in known.iter_mut().zip(&moved.output_acceleration.values) {
                *k = -declared.fixture_inertia * a;
            }
            let curvature =
                (has_output && !has_motor).then(|| grid.second_derivative(&sensor).map(|s| inertia * ratio * s));
            // What the gear transmits, from the current: the sensor is the target itself and would explain its own
            // noise.
            let transmitted = measured_current.as_ref().map(|i| {
                let mut torque = motor_torque(i);
                for (t, direction) in torque.values.iter_mut().zip(&moved.direction) {
                    *t /= 1.0 + corrections.gear_loss * (*t * direction).signum();
                }
                torque
            });
            (sensor, transmitted, curvature)
        }
        Target::Drive => {
            let drive = match &measured_current {
                Some(i) => i.map(|i| ratio * model.torque_constant * i),
                None => {
                    let per_volt = ratio * model.torque_constant / model.resistance;
                    applied.as_ref()?.map(|v| per_volt * v)
                }
            };
            base.push(moved.motor_acceleration.map(|a| ratio * a).values);
            if measured_current.is_none() {
                base.push(moved.motor.map(|w| ratio * w).values);
            }
            let transmitted = known_load(log, &moved, out_angle.as_ref());
            if load.gravity_torque.is_some() {
                base.push(transmitted.clone()?.values);
            } else if let Some(load) = &transmitted {
                known.clone_from(&load.values);
            }
            load_channels = transmitted.as_ref().map_or(Channels::NONE, |t| t.made_of);
            let curvature = match (&transmitted, has_motor, has_output) {
                (Some(t), true, false) => {
                    Some(grid.second_derivative(t).map(|s| -load.inertia.unwrap_or(0.0) * s / ratio))
                }
                (Some(t), false, true) => Some(grid.second_derivative(t).map(|s| inertia * ratio * s)),
                _ => None,
            };
            (drive, transmitted.map(|t| t.map(|t| t / ratio)), curvature)
        }
        Target::Voltage => {
            base.push(measured_current.as_ref().map_or_else(zeros, |i| i.values.clone()));
            base.push(measured_current.as_ref().map_or_else(zeros, |i| grid.derivative(i).values));
            base.push(moved.motor.values.clone());
            (grid.late(applied.as_ref()?, corrections.target_lag), None, None)
        }
        Target::Position => return None,
        Target::WindUp => {
            let (m, o) = (motor_angle.as_ref()?, output_angle.as_ref()?);
            let angle = m.with(o, |m, o| m / ratio - o);
            let known_load = known_load(log, &moved, out_angle.as_ref());
            let torque = match (&sensor, &known_load, &current) {
                (Some(t), ..) => t.clone(),
                (None, Some(t), _) => t.clone(),
                (None, None, Some(i)) => motor_torque(i).map(|t| ratio * t),
                _ => return None,
            };
            (angle, Some(torque.map(|t| t / ratio)), Some(torque))
        }
    };
    let made_of = |s: &Option<Signal>| s.as_ref().map_or(Channels::NONE, |s| s.made_of);
    let origins = Origins {
        response: response.made_of,
        load: load_channels,
        speed: moved.motor.made_of,
        angle: made_of(&angle),
        output_angle: made_of(&out_angle),
        current: made_of(&current),
        torque: made_of(&transmitted),
        curvature: made_of(&curvature),
        winding: made_of(&winding),
        housing: made_of(&housing),
        duty: made_of(&duty),
    };
    let pick = |s: Option<Signal>| s.map_or_else(|| vec![f64::NAN; n], |s| s.values);
    let (angle, out_angle, current) = (pick(angle), pick(out_angle), pick(current));
    let (transmitted, curvature) = (pick(transmitted), pick(curvature));
    let (winding, housing, duty) = (pick(winding), pick(housing), pick(duty));
    let points = (0..n)
        .map(|k| Operating {
            speed: moved.motor.values[k],
            direction: moved.direction[k],
            angle: angle[k],
            output_angle: out_angle[k],
            current: current[k],
            torque: transmitted[k],
            torque_curvature: curvature[k],
            winding_rise: winding[k],
            housing_rise: housing[k],
            duty: duty[k],
        })
        .collect();
    Some(Stretch {
        log: index,
        step: grid.step,
        target: response.values,
        base,
        known,
        points,
        origins,
        reading,
        acceleration: moved.motor_acceleration.values,
        filter: None,
        keep: Vec::new(),
    })
}

/// What hangs at the output and is known: inertia and gravity \[N·m at the output\].
fn known_load(log: &Log, moved: &Motion, angle: Option<&Signal>) -> Option<Signal> {
    let load = log.load;
    if load.inertia.is_none() && load.gravity_torque.is_none() {
        return None;
    }
    let inertia = load.inertia.map(|j| moved.output_acceleration.map(|a| j * a));
    let gravity = load.gravity_torque.map(|m| match angle {
        Some(q) => q.map(|q| m * q.sin()),
        None => Signal::constant(f64::NAN, moved.motor.values.len()),
    });
    match (inertia, gravity) {
        (Some(a), Some(b)) => Some(a.with(&b, |a, b| a + b)),
        (a, b) => a.or(b),
    }
}

/// Quadrature voltage per volt of duty times supply: a brushed motor, and a row that is on the q axis
/// already, take all of it.
pub(crate) fn volts_per_duty(motor: &crate::catalog::Motor) -> f64 {
    use crate::catalog::convention::{BLOCK, Commutation, CurrentConvention, Modulation};
    match (motor.conventions.commutation, motor.conventions.current) {
        (Commutation::Brushed, _) | (_, CurrentConvention::QAxis) => 1.0,
        (_, CurrentConvention::Dc) => BLOCK,
        (commutation, _) => Modulation::SpaceVector.voltage(commutation),
    }
}

fn second_derivative(values: &[f64], step: f64) -> Vec<f64> {
    let n = values.len();
    if step <= 0.0 || n < 3 {
        return vec![0.0; n];
    }
    (0..n)
        .map(|k| {
            let k = k.clamp(1, n - 2);
            (values[k - 1] - 2.0 * values[k] + values[k + 1]) / (step * step)
        })
        .collect()
}

fn base_terms(target: Target, model: &Model, declared: &Declared, log: &Log) -> Vec<BaseTerm> {
    let term = |name, unit, declared| BaseTerm { name, unit, declared };
    let linear = declared.motor.is_none();
    let inertia = if linear { term("mass", "kg", model.inertia) } else { term("inertia", "kg*m^2", model.inertia) };
    match target {
        Target::Torque => vec![term("torque_constant", "N*m/A", Some(model.torque_constant)), inertia],
        Target::Drive => {
            let mut terms = vec![inertia];
            if log.channel(Channel::Current).is_none() {
                let damping = model.torque_constant * model.back_emf / model.resistance;
                terms.push(term("damping", "N*m*s/rad", Some(damping)));
            }
            if log.load.gravity_torque.is_some() {
                terms.push(term("load_scale", "1", Some(1.0)));
            }
            terms
        }
        Target::Voltage => vec![
            term("resistance", "ohm", Some(model.resistance)),
            term("inductance", "H", model.inductance),
            term("back_emf_constant", "V*s/rad", Some(model.back_emf)),
        ],
        Target::WindUp | Target::Position => Vec::new(),
    }
}

/// Which variables vary enough to say something.
fn variables(stretches: &[Stretch], target: Target, declared: &Declared) -> Vec<Variable> {
    let spread = |f: &dyn Fn(&Operating) -> f64| {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for p in stretches.iter().flat_map(|s| &s.points) {
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

fn scale(stretches: &[Stretch], model: &Model, target: Target) -> Scale {
    let largest = |f: &dyn Fn(&Operating) -> f64| {
        let values = stretches.iter().flat_map(|s| &s.points).map(|p| f(p).abs()).collect();
        signals::quantile(values, 0.995).unwrap_or(f64::NAN)
    };
    let current = largest(&|p| p.current);
    let torque = (model.torque_constant * current).max(largest(&|p| p.torque));
    let volts = stretches.iter().flat_map(|s| &s.target).map(|v| v.abs()).collect();
    Scale {
        torque_constant: model.torque_constant,
        resistance: model.resistance,
        torque,
        speed: largest(&|p| p.speed).max(f64::MIN_POSITIVE),
        current,
        voltage: if target == Target::Voltage { signals::quantile(volts, 0.995).unwrap_or(f64::NAN) } else { f64::NAN },
    }
}

/// Why an effect cannot be asked for in an equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Hidden {
    /// It is a term of another equation.
    Elsewhere,
    /// What it depends on is not measured or does not vary, or something hides it: why.
    Bench(&'static str),
    /// Its regressor is made of the response that it would explain; what measurement would show it.
    Response(&'static str),
}

/// Whether a declared effect is a part of a balance's model: where it is made of the response, with its declared
/// values.
pub fn applies(effect: &dyn Effect, balance: &Balance, declared: &Declared) -> bool {
    matches!(visible(effect, balance, declared), Ok(()) | Err(Hidden::Response(_)))
}

/// Whether an effect can be seen in a balance.
///
/// # Errors
/// Why not.
pub fn visible(effect: &dyn Effect, balance: &Balance, declared: &Declared) -> Result<(), Hidden> {
    // A duty-driven machine shows voltage effects as torque.
    let volts =
        effect.acts_on() == Equation::Voltage && balance.is_duty_driven && effect.name() != "winding_temperature";
    let winds = effect.name() == "gear_compliance" && balance.target == Target::WindUp;
    if effect.acts_on() != balance.target.equation() && !winds && !volts {
        return Err(Hidden::Elsewhere);
    }
    if let Some(missing) = effect.needs().iter().find(|v| !balance.variables.contains(v)) {
        return Err(Hidden::Bench(match missing {
            Variable::WindingTemperature | Variable::HousingTemperature => "the logs have no temperature that varies",
            Variable::Angle | Variable::OutputAngle => "the logs have no position that turns, or not far enough",
            Variable::Torque => "the transmitted torque is not known",
            Variable::TorqueCurvature => "both sides of the gear would have to be measured",
            Variable::Current => "the logs have no current",
            _ => "the logs lack a channel that it depends on",
        }));
    }
    let hidden = match effect.name() {
        "torque_offset" if balance.target.has_zero() => Some("the zero of the sensor hides it"),
        "gravity" if balance.target != Target::Drive => Some("the sensor sees what hangs at the output"),
        "gear_ripple" if declared.ratio == 1.0 => Some("without a gear it is cogging"),
        "gear_compliance" if declared.ratio == 1.0 && balance.target != Target::WindUp => {
            Some("without a gear nothing winds up")
        }
        "supply_sag" if balance.has_measured_volts || balance.has_measured_supply => {
            Some("the voltage is measured, sag and all")
        }
        "viscous_friction" if balance.base.iter().any(|b| b.name == "damping") => {
            Some("with duty alone it cannot be told from the back-EMF: both are in `damping`")
        }
        _ => None,
    };
    if let Some(why) = hidden {
        return Err(Hidden::Bench(why));
    }
    match effect.needs().iter().find(|v| balance.is_response(**v)) {
        Some(variable) => Err(Hidden::Response(balance.shown_by(*variable))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
