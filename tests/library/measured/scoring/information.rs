//! What the logs say of the effects that were put in: from the truth alone.
//!
//! The noncentrality of an effect is that of the least-squares estimate of its size: δ = ‖c‖²/√(cᵀ Σ c), with c its
//! contribution to the target at the rows of the fit logs, less what the declared parameters, the zero of each log and
//! other effects make of it, and Σ the autocovariance of the noise as it was drawn. For white noise it is ‖c‖/σ, for a
//! slow contribution ‖c‖ over the long-run deviation. The separation from a twin that correlates with c by ρ is
//! δ √((1 − ρ)/2).

use std::f64::consts::TAU;

use super::draw::Case;
use super::visible::visible;
use crate::simulator::{Bench, Effect, Kind, LogTruth, Nature, Trace, Truth, random::Random, sense, world};

/// Least noncentrality and separation at which a name can be told.
const TELLS: f64 = 6.0;
const SEPARATES: f64 = 4.0;
/// Longest lag over which the noise is taken to be correlated \[s\].
const MEMORY: f64 = 0.3;

/// What one effect leaves in the logs.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Noncentrality, zero where it is not visible.
    pub noncentrality: f64,
    /// Separation from the nearest twin.
    pub separation: f64,
    /// The nearest twin.
    pub twin: Option<&'static str>,
}

/// What all of them leave.
#[derive(Debug, Clone)]
pub struct Information {
    pub seen: Vec<Seen>,
    /// Whether every effect is visible.
    pub is_visible: bool,
}

impl Information {
    /// Of a case as it was written.
    pub fn of(case: &Case, truth: &Truth) -> Information {
        let visible = case.visible();
        let seen: Vec<Seen> = (0..case.effects.len())
            .map(|k| match visible[k] {
                Ok(()) => seen(case, truth, k),
                Err(_) => Seen { noncentrality: 0.0, separation: 0.0, twin: None },
            })
            .collect();
        Information { is_visible: visible.iter().all(Result::is_ok), seen }
    }

    /// Whether every effect can be told by its name.
    pub fn is_answerable(&self) -> bool {
        !self.seen.is_empty() && self.seen.iter().all(|s| s.noncentrality >= TELLS && s.separation >= SEPARATES)
    }

    /// Whether something is there that cannot be overlooked.
    pub fn is_there(&self) -> bool {
        self.seen.iter().any(|s| s.noncentrality >= TELLS)
    }

    /// The least of all effects.
    pub fn noncentrality(&self) -> f64 {
        self.seen.iter().map(|s| s.noncentrality).fold(f64::INFINITY, f64::min)
    }

    /// The least of all effects.
    pub fn separation(&self) -> f64 {
        self.seen.iter().map(|s| s.separation).fold(f64::INFINITY, f64::min)
    }
}

/// The equation that an effect is told by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Equation {
    /// That of the bench's target.
    Target,
    /// The angle by which the motor leads the output.
    WindUp,
}

fn equation(effect: Effect) -> Equation {
    match effect {
        Effect::GearCompliance | Effect::Backlash => Equation::WindUp,
        _ => Equation::Target,
    }
}

/// Columns over all fit logs, one after the other.
type Column = Vec<f64>;

/// The fit logs of one equation.
struct Logs<'a> {
    case: &'a Case,
    truth: &'a Truth,
    equation: Equation,
    /// Number of each fit log, with its truth.
    logs: Vec<(usize, &'a LogTruth)>,
}

fn seen(case: &Case, truth: &Truth, k: usize) -> Seen {
    let effect = case.effects[k];
    let logs = Logs {
        case,
        truth,
        equation: equation(effect),
        logs: truth.logs.iter().enumerate().filter(|(_, l)| !l.held_out).collect(),
    };
    let basis = logs.known(k);
    let contribution = basis.beyond(logs.contribution(k));
    let noncentrality = logs.noncentrality(&contribution);
    let (mut nearest, mut twin) = (0.0, None);
    for other in logs.twins() {
        for columns in logs.shapes(other) {
            let span = Basis::of(columns.into_iter().map(|c| basis.beyond(c)).collect());
            let correlation = norm(&span.within(&contribution)) / norm(&contribution).max(f64::MIN_POSITIVE);
            if correlation > nearest {
                (nearest, twin) = (correlation, Some(other.name()));
            }
        }
    }
    let separation = noncentrality * (0.5 * (1.0 - nearest.min(1.0))).sqrt();
    Seen { noncentrality, separation, twin }
}

impl Logs<'_> {
    fn bench(&self) -> &Bench {
        &self.case.bench
    }

    /// A column of all logs, band-limited like the target.
    fn column(&self, of: impl Fn(usize, &LogTruth) -> Vec<f64>) -> Column {
        // A simulated position and an angle are compared as they are.
        let band = self.case.band.filter(|_| self.equation == Equation::Target && self.case.kind() != Kind::Servo);
        self.logs
            .iter()
            .flat_map(|(log, truth)| {
                let values = of(*log, truth);
                match band {
                    Some(band) => low_pass(&values, band / self.bench().rate),
                    None => values,
                }
            })
            .collect()
    }

    /// A function of the noise-free world at the rows.
    fn at_rows(&self, of: impl Fn(&Trace, usize) -> f64) -> Column {
        self.column(|_, log| {
            let fine: Vec<f64> = (0..log.trace.motor_angle.len()).map(|k| of(&log.trace, k)).collect();
            log.times.iter().map(|t| sense::at(&fine, log.trace.step, *t)).collect()
        })
    }

    /// The contribution of an effect.
    fn contribution(&self, k: usize) -> Column {
        match self.equation {
            Equation::Target => self.column(|_, log| log.apart[k].clone()),
            Equation::WindUp => {
                // Each part of the angle alone: both are there in a pair.
                let nature = &self.truth.nature;
                match self.case.effects[k] {
                    Effect::Backlash => self.at_rows(|t, k| 0.5 * nature.backlash * sign(t.torque[k])),
                    _ => self.at_rows(|t, k| nature.compliance * t.torque[k]),
                }
            }
        }
    }

    /// The noise of each log, as its rows have it.
    fn noise(&self) -> Column {
        match self.equation {
            Equation::Target => self.column(|_, log| log.noise.iter().zip(&log.rounding).map(|(n, r)| n + r).collect()),
            Equation::WindUp => {
                // Two encoders: their rounding, uniform over a quantum.
                let sensors = &self.truth.sensors;
                let motor = TAU / sensors.counts / self.truth.machine.ratio;
                let size = motor.hypot(TAU / sensors.output_counts) / 12.0_f64.sqrt();
                self.column(|number, log| {
                    let mut random = Random::new(self.truth.seed, &format!("rounding {number}"));
                    log.times.iter().map(|_| size * random.normal()).collect()
                })
            }
        }
    }

    /// δ of a contribution that nothing else makes up.
    fn noncentrality(&self, contribution: &[f64]) -> f64 {
        let noise = self.noise();
        let longest = (MEMORY * self.bench().rate).round() as usize;
        let mut starts = vec![0];
        for (_, log) in &self.logs {
            starts.push(starts[starts.len() - 1] + log.times.len());
        }
        // Sums over the pairs of rows of one log that are so many rows apart.
        let apart = |values: &[f64], lag: usize| -> f64 {
            starts
                .windows(2)
                .map(|w| {
                    let own = &values[w[0]..w[1]];
                    own.iter().zip(own.iter().skip(lag)).map(|(a, b)| a * b).sum::<f64>()
                })
                .sum()
        };
        let count = noise.len() as f64;
        let mut variance = 0.0;
        for lag in 0..=longest {
            let weight = 1.0 - lag as f64 / (longest + 1) as f64;
            let twice = if lag == 0 { 1.0 } else { 2.0 };
            variance += twice * weight * apart(&noise, lag) / count * apart(contribution, lag);
        }
        // Of blue noise next to nothing is left at low frequency: a hundredth of its power is.
        let square = contribution.iter().map(|c| c * c).sum::<f64>();
        let least = 0.01 * apart(&noise, 0) / count * square;
        square / variance.max(least).max(f64::MIN_POSITIVE).sqrt()
    }

    /// What the model has already: the declared parameters, the zero of each log, and the other effects of a pair.
    fn known(&self, k: usize) -> Basis {
        let mut columns = match (self.equation, self.case.kind()) {
            (Equation::WindUp, _) => Vec::new(),
            (_, Kind::Servo) => self.sensitivities(),
            _ => self.parameters(),
        };
        if self.equation == Equation::WindUp || self.case.kind().has_zero() {
            for (number, _) in &self.logs {
                let own = |log: usize| f64::from(u8::from(log == *number));
                columns.push(self.logs.iter().flat_map(|(n, log)| vec![own(*n); log.times.len()]).collect());
            }
        }
        match self.case.effects[k] {
            // Flanks bend.
            Effect::Backlash => columns.push(self.at_rows(|t, k| t.torque[k])),
            Effect::DirectionAsymmetry if !self.case.kind().has_zero() => {
                columns.extend(self.shapes(Effect::TorqueOffset).remove(0));
            }
            _ => {}
        }
        let others = (0..self.case.effects.len()).filter(|o| *o != k);
        columns
            .extend(others.filter(|o| equation(self.case.effects[*o]) == self.equation).map(|o| self.contribution(o)));
        Basis::of(columns)
    }

    /// Columns of the declared parameters, friction too where it is declared.
    fn parameters(&self) -> Vec<Column> {
        let mut columns = Vec::new();
        match self.case.kind() {
            Kind::Electrical => {
                columns.push(self.at_rows(|t, k| t.current[k]));
                columns.push(self.at_rows(|t, k| t.current_rate[k]));
                columns.push(self.at_rows(|t, k| t.motor_speed[k]));
                return columns;
            }
            Kind::Free => {}
            _ => columns.push(self.at_rows(|t, k| t.current[k])),
        }
        columns.push(self.at_rows(|t, k| t.motor_acceleration[k]));
        if self.bench().declared.viscous.is_some() {
            columns.push(self.at_rows(|t, k| t.motor_speed[k]));
        }
        if self.bench().declared.coulomb.is_some() {
            columns.push(self.at_rows(|t, k| sign(t.motor_speed[k])));
        }
        columns
    }

    /// How the position of a servo changes with each declared parameter.
    fn sensitivities(&self) -> Vec<Column> {
        const CHANGE: f64 = 0.01;
        let change: [fn(&mut Nature); 5] = [
            |n| n.machine.torque_constant *= 1.0 + CHANGE,
            |n| n.machine.resistance *= 1.0 + CHANGE,
            |n| n.machine.inertia *= 1.0 + CHANGE,
            |n| n.viscous += CHANGE * n.machine.peak_torque() / n.machine.peak_speed,
            |n| n.coulomb += CHANGE * n.machine.peak_torque(),
        ];
        change
            .into_iter()
            .enumerate()
            // What the row does not declare is no parameter.
            .filter(|(which, _)| match which {
                3 => self.bench().declared.viscous.is_some(),
                4 => self.bench().declared.coulomb.is_some(),
                _ => true,
            })
            .map(|(_, change)| {
                let mut nature = self.truth.nature.clone();
                change(&mut nature);
                self.change_of_position(&nature)
            })
            .collect()
    }

    /// The position with another nature less that of the truth.
    fn change_of_position(&self, nature: &Nature) -> Column {
        self.column(|number, log| {
            let other = self.bench().simulate(nature, number);
            let fine: Vec<f64> = other.output_angle.iter().zip(&log.trace.output_angle).map(|(a, b)| a - b).collect();
            log.times.iter().map(|t| sense::at(&fine, other.step, *t)).collect()
        })
    }

    /// Effects that this bench could show instead.
    fn twins(&self) -> Vec<Effect> {
        let declared = |e: Effect| match e {
            Effect::ViscousFriction => self.bench().declared.viscous.is_some(),
            Effect::CoulombFriction => self.bench().declared.coulomb.is_some(),
            _ => false,
        };
        let own = |e: Effect| {
            self.case.names().contains(&e.name()) || self.case.companions().any(|companion| companion == e.name())
        };
        Effect::LIBRARY
            .into_iter()
            .filter(|e| equation(*e) == self.equation && !own(*e) && !declared(*e))
            .filter(|e| visible(*e, self.case.kind(), self.case.has).is_ok())
            .collect()
    }

    /// The columns of a twin, for each shape that it may have.
    fn shapes(&self, twin: Effect) -> Vec<Vec<Column>> {
        if self.case.kind() == Kind::Servo {
            let mut nature = self.truth.nature.clone();
            let amplitude = *nature.amplitude_mut(twin) + 0.05 * nature.largest(twin);
            nature.set(twin, amplitude);
            return vec![vec![self.change_of_position(&nature)]];
        }
        let m = &self.truth.machine;
        let of_speed =
            |shares: &[f64]| shares.iter().map(|s| s * m.peak_speed * self.bench().excitation.speed).collect();
        let of_current = |shares: &[f64]| shares.iter().map(|s| s * m.peak_current).collect();
        let one = |of: &dyn Fn(&Trace, usize) -> f64| vec![vec![self.at_rows(of)]];
        let each = |shapes: Vec<f64>, of: fn(f64, &Trace, usize) -> f64| -> Vec<Vec<Column>> {
            shapes.into_iter().map(|s| vec![self.at_rows(|t, k| of(s, t, k))]).collect()
        };
        let waves = |side: f64, scale: fn(&Trace, usize) -> f64| -> Vec<Vec<Column>> {
            let wave = |order: f64, phase: f64| {
                self.at_rows(|t, k| scale(t, k) * (order * t.motor_angle[k] / side + phase).cos())
            };
            self.orders(side).into_iter().map(|order| vec![wave(order, 0.0), wave(order, 0.25 * TAU)]).collect()
        };
        match twin {
            Effect::ViscousFriction => one(&|t, k| t.motor_speed[k]),
            Effect::CoulombFriction => one(&|t, k| sign(t.motor_speed[k])),
            Effect::DirectionAsymmetry => one(&|t, k| t.motor_speed[k].abs()),
            Effect::TorqueOffset => one(&|_, _| 1.0),
            Effect::Gravity => {
                vec![vec![self.at_rows(|t, k| t.output_angle[k].sin()), self.at_rows(|t, k| t.output_angle[k].cos())]]
            }
            Effect::LoadDependentFriction => {
                let (load, kind) = (m.load_inertia / m.ratio, self.case.kind());
                let (constant, inertia) = (m.torque_constant, m.inertia + m.gear_inertia);
                one(&move |t, k| {
                    let through = match kind {
                        Kind::Free => load * t.output_acceleration[k],
                        _ => constant * t.current[k] - inertia * t.motor_acceleration[k],
                    };
                    through.abs() * sign(t.motor_speed[k])
                })
            }
            Effect::StribeckFriction => each(of_speed(&[0.01, 0.03, 0.06, 0.12, 0.24]), |s, t, k| {
                let speed = t.motor_speed[k];
                (-(speed / s).powi(2)).exp() * sign(speed)
            }),
            Effect::EddyDrag => each(of_speed(&[0.2, 0.4, 0.7, 1.2]), |s, t, k| {
                let x = t.motor_speed[k] / s;
                x / (1.0 + x * x)
            }),
            Effect::TorqueConstantSaturation => {
                each(of_current(&[0.25, 0.5, 1.0, 2.0]), |s, t, k| t.current[k] - s * (t.current[k] / s).tanh())
            }
            Effect::InverterDeadTime => {
                each(of_current(&[0.003, 0.01, 0.03, 0.1, 0.3]), |s, t, k| (t.current[k] / s).tanh())
            }
            Effect::TorqueConstantTemperature => one(&|t, k| t.current[k] * (t.housing[k] - world::REFERENCE)),
            Effect::WindingTemperature => one(&|t, k| t.current[k] * (t.winding[k] - world::REFERENCE)),
            Effect::Cogging { .. } => waves(1.0, |_, _| 1.0),
            Effect::TorqueRipple { .. } => waves(1.0, |t, k| t.current[k]),
            Effect::GearRipple { .. } => waves(m.ratio, |_, _| 1.0),
            Effect::GearCompliance => one(&|t, k| t.torque[k]),
            Effect::Backlash => one(&|t, k| sign(t.torque[k])),
            other => panic!("{} has no columns", other.name()),
        }
    }

    /// Orders that a twin may have, by turn of the motor over `side`: low ones, and those of the waves that were put in.
    fn orders(&self, side: f64) -> Vec<f64> {
        let mut orders: Vec<f64> = (1..=4).map(f64::from).collect();
        for effect in &self.case.effects {
            let per_motor_turn = match effect {
                Effect::Cogging { order } | Effect::TorqueRipple { order } => f64::from(*order),
                Effect::GearRipple { order } => f64::from(*order) / self.truth.machine.ratio,
                _ => continue,
            };
            // Only whole orders are asked.
            orders.extend([1.0, 2.0].map(|harmonic| (harmonic * per_motor_turn * side).round()));
        }
        orders
    }
}

fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

fn norm(values: &[f64]) -> f64 {
    values.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Orthonormal columns that span what is known.
struct Basis(Vec<Column>);

impl Basis {
    /// Gram and Schmidt, twice for the sake of rounding; what others make up is left out.
    fn of(columns: Vec<Column>) -> Basis {
        let mut basis = Basis(Vec::new());
        for column in columns {
            let size = norm(&column);
            let mut left = basis.beyond(column);
            left = basis.beyond(left);
            let rest = norm(&left);
            if rest > 1e-6 * size {
                left.iter_mut().for_each(|v| *v /= rest);
                basis.0.push(left);
            }
        }
        basis
    }

    /// What of a column it does not make up.
    fn beyond(&self, mut column: Column) -> Column {
        for own in &self.0 {
            let share: f64 = own.iter().zip(&column).map(|(a, b)| a * b).sum();
            column.iter_mut().zip(own).for_each(|(c, o)| *c -= share * o);
        }
        column
    }

    /// What of a column it makes up.
    fn within(&self, column: &[f64]) -> Column {
        let beyond = self.beyond(column.to_vec());
        column.iter().zip(beyond).map(|(c, b)| c - b).collect()
    }
}

/// Butterworth's filter of second order there and back: no phase. `corner` in cycles a row.
fn low_pass(values: &[f64], corner: f64) -> Vec<f64> {
    let k = (0.5 * TAU * corner.min(0.45)).tan();
    let scale = 1.0 / (1.0 + 2.0_f64.sqrt() * k + k * k);
    let (b, a1, a2) = (k * k * scale, 2.0 * (k * k - 1.0) * scale, (1.0 - 2.0_f64.sqrt() * k + k * k) * scale);
    let pass = |values: Vec<f64>| -> Vec<f64> {
        let start = values.first().copied().unwrap_or(0.0);
        let (mut x, mut y) = ([start; 2], [start; 2]);
        values
            .into_iter()
            .map(|v| {
                let out = b * (v + 2.0 * x[0] + x[1]) - a1 * y[0] - a2 * y[1];
                (x, y) = ([v, x[0]], [out, y[0]]);
                out
            })
            .collect()
    };
    let mut there = pass(values.to_vec());
    there.reverse();
    let mut back = pass(there);
    back.reverse();
    back
}

#[test]
fn white_noise_gives_the_plain_ratio() {
    use crate::simulator::clean;
    let folder = tempfile::tempdir().expect("a folder");
    let bench = clean(Kind::Dynamometer, 5).sampled(15.0, 400.0).sensors(|s| s.colored = 0.0);
    let bench = bench.with_noise(Effect::EddyDrag, 2.0);
    let truth = bench.write(folder.path());
    let mut case = super::draw::draw(1);
    (case.effects, case.bench, case.band) = (vec![Effect::EddyDrag], bench, None);
    let logs = Logs {
        case: &case,
        truth: &truth,
        equation: Equation::Target,
        logs: truth.logs.iter().enumerate().filter(|(_, l)| !l.held_out).collect(),
    };
    let contribution = logs.contribution(0);
    let plain = norm(&contribution) / truth.noise_rms;
    let found = logs.noncentrality(&contribution);
    assert!((found / plain - 1.0).abs() < 0.35, "{found} {plain}");
    // What the model has makes it smaller, and no twin may be further from it than it from nothing.
    let seen = seen(&case, &truth, 0);
    assert!(seen.noncentrality < 1.1 * found && seen.separation <= seen.noncentrality, "{seen:?}");
    assert!(seen.twin.is_some());
}

#[test]
fn the_filter_passes_low_and_stops_high() {
    let wave = |f: f64| (0..2000).map(|k| (TAU * f * f64::from(k)).sin()).collect::<Vec<f64>>();
    let gain = |f: f64| norm(&low_pass(&wave(f), 0.1)[500..1500]) / norm(&wave(f)[500..1500]);
    assert!((gain(0.01) - 1.0).abs() < 0.01 && (gain(0.1) - 0.5).abs() < 0.01 && gain(0.4) < 0.01);
}
