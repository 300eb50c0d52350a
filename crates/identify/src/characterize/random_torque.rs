//! Inertia and damping at the output: random torque in, speed out, `Ω/T = 1/(J s + B)`.
//!
//! The one idea: noise on the torque sensor makes H1 too small (J too large, by 1 + 1/SNR), noise on the speed makes
//! H2 too large. The command of the driving machine knows neither noise: as instrument it gives J without bias.
//! Where the log has no command, H1 and H2 bracket the truth and the bracket is in the ±.
//!
//! A velocity that is a difference of encoder counts is a mean over that time: it reads low at high frequency, by
//! sin(x)/x with x = π f T, and J comes out too large (4 % at 150 Hz for 1 ms). Where the column says its `difference`,
//! that is taken out; where not, T is fitted too (with a command), or a bracket from nothing to one sample.
//!
//! Coulomb friction is no damping: a machine that it slows does not answer a random torque as a linear one does, and what
//! is left passes for inertia (1 % where friction is a sixth of the torque). It is fitted too, along the direction of
//! the speed.
//!
//! In order: lag between the channels, H1 by Welch's method with its coherence and the band that it allows, first
//! order fitted to the gain, refined on the variance accounted for in time (free zero and initial speed), and the
//! equation `T = J Ω̇ + B Ω + C sign Ω` over windows of time with instruments, which gives the number and its interval: windows
//! are the independent pieces.

mod in_time;
mod spectra;

use nalgebra::{DMatrix, DVector};

use self::in_time::{refine, vaf};
use self::spectra::{Record, Spectra, band, gain_fit, response};
use super::estimate::{Combination, Estimate, Pooled, bracket, combine, pool, rotor_inertia};
use super::stall::between_logs;
use super::{Chart, Curve, Finding, Outcome, PerLog, Quantity, Role, Test, Weight, calibrated, calibration, logs_of};
use crate::bench::{Bench, BenchKind, Channel, Log};
use gearwise_model::words::number;

pub use self::spectra::Band;

/// The test.
pub struct RandomTorque;

/// Lags that are looked for \[s\].
const LARGEST_LAG: f64 = 0.05;
/// Highest frequency times span of a difference that is used: there it still reads half.
const MOST_AVERAGED: f64 = 0.6;
/// Highest frequency of the velocity that tells its direction, over that of the band.
const DIRECTION: f64 = 2.0;
/// Coulomb friction over the torque (rms) from which on standing still counts: there friction is what the torque is.
const STICKS: f64 = 0.2;
/// Power of half-overlapping Hann windows is correlated by 1/36 from one to the next.
const OVERLAP: f64 = 1.0 + 2.0 / 36.0;

/// How the instruments' gains enter an inertia: torque over speed.
const GAINS: &[(&[Channel], f64)] =
    &[(&[Channel::Torque], 1.0), (&[Channel::MotorVelocity, Channel::OutputVelocity], 1.0)];

/// What stands for the noise-free signals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instrument {
    /// The command of the driving machine: no bias.
    Command,
    /// The measured torque, as H1: J is too large by the noise of the torque sensor.
    Torque,
    /// The measured speed, as H2: J is too small by the noise of the speed.
    Velocity,
}

/// Inertia, damping, friction and lag with one instrument.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstOrder {
    /// Inertia \[kg·m²\].
    pub inertia: Estimate,
    /// Viscous damping \[N·m·s/rad\].
    pub damping: Estimate,
    /// How late the velocity is behind the torque \[s\].
    pub lag: Estimate,
    /// Square of the time over which the velocity is a mean \[s²\].
    pub averaging: Estimate,
    /// Coulomb friction \[N·m\], where the speed turns often enough to tell it.
    pub friction: Option<Estimate>,
}

/// Where it is known from over how long the velocity is a mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Averaging {
    /// The bench file says it.
    Declared,
    /// Fitted beside inertia, damping and lag.
    Fitted,
    /// Between nothing and one sample: both are in the bracket.
    Bracketed,
}

/// What one log says, at the output.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The answer.
    pub result: FirstOrder,
    /// First order fitted to the gain of H1: J and B.
    pub gain: (f64, f64),
    /// Refined on the variance accounted for: J and B.
    pub refined: (f64, f64),
    /// With torque and with velocity as instrument: the bracket.
    pub bracket: [FirstOrder; 2],
    /// Lowest and highest inertia of what it may be; alike where an instrument gives it without bias.
    pub ends: [Estimate; 2],
    /// Torque \[N·m\], rms.
    pub torque: f64,
    /// Whether the command was the instrument.
    pub instrument: Instrument,
    /// Where the velocity's averaging is known from.
    pub averaging: Averaging,
    /// Variance accounted for by the refined fit, and by the answer \[%\].
    pub vaf: (f64, f64),
    /// The band.
    pub band: Band,
    /// Mean coherence in the band.
    pub coherence: f64,
    /// Frequency \[Hz\], gain of H1 \[rad/s per N·m\], coherence.
    pub response: Vec<(f64, f64, f64)>,
    /// Sampling rate \[Hz\], length of a window \[s\], number of windows.
    pub welch: (f64, f64, usize),
    /// The torque had to be turned.
    pub turned: bool,
}

/// Inertia and damping of one log. `ratio` brings a velocity of the motor to the output.
///
/// # Errors
/// In words, why the log says nothing.
pub fn identify(log: &Log, ratio: f64) -> Result<Identified, String> {
    let mut record = Record::of(log, ratio)?;
    let turned = record.align();
    let mut spectra = Spectra::new(&record);
    let h = response(&spectra);
    let mut band = band(&h, record.command.is_some())?;
    if let Some(span) = log.difference.filter(|t| t * band.high > MOST_AVERAGED) {
        band.high = MOST_AVERAGED / span;
        band.why.push_str(&format!(", and a difference over {} ms keeps too little above", number(1e3 * span)));
        if band.high < 2.0 * band.low {
            return Err(format!("a difference over {} ms leaves no band to fit", number(1e3 * span)));
        }
    }
    record.direct(DIRECTION * band.high, spectra.count());
    let gain = gain_fit(&h, &band);
    let (mut j, mut b) = gain;
    let mut lag = 0.0;
    let start = if record.command.is_some() { Instrument::Command } else { Instrument::Torque };
    let averaging = match log.difference {
        Some(_) => Averaging::Declared,
        None if record.command.is_some() => Averaging::Fitted,
        None => Averaging::Bracketed,
    };
    let free = averaging == Averaging::Fitted;
    let mut square = log.difference.unwrap_or(0.0).powi(2);
    let most = (0.5_f64 / band.high).powi(2);
    spectra = Spectra::corrected(&record, 0.0, square);
    // The lag first, then the averaging with it: rounds until they stay. Both at once from a lag that is far off run away.
    let mut settled = false;
    for _ in 0..16 {
        let solved = solve(&spectra, &band, start, j, b, free && settled)?;
        (j, b) = (solved.inertia.value.abs(), solved.damping.value);
        let wider = if free { (square + solved.averaging.value).clamp(-most, most) - square } else { 0.0 };
        square += wider;
        let step = solved.lag.value.clamp(-0.2 / band.high, 0.2 / band.high);
        lag += step;
        if lag.abs() > LARGEST_LAG {
            return Err(format!("no lag within {} ms makes it first order", number(1e3 * LARGEST_LAG)));
        }
        spectra = Spectra::corrected(&record, lag, square);
        if step.abs() < 1e-3 * record.step && wider.abs() < 1e-3 * most {
            if settled || !free {
                break;
            }
            settled = true;
        }
    }
    let with_lag = |mut f: FirstOrder| {
        f.lag.value += lag;
        f.averaging.value += square;
        f
    };
    let upper = with_lag(solve(&spectra, &band, Instrument::Torque, j, b, false)?);
    let lower = with_lag(solve(&spectra, &band, Instrument::Velocity, j, b, false)?);
    let (result, ends, instrument) = if record.command.is_some() {
        let result = with_lag(solve(&spectra, &band, Instrument::Command, j, b, free)?);
        (result, [result.inertia; 2], Instrument::Command)
    } else {
        let mut ends = vec![upper, lower];
        if averaging == Averaging::Bracketed {
            let sample = Spectra::corrected(&record, lag, record.step.powi(2));
            for instrument in [Instrument::Torque, Instrument::Velocity] {
                ends.push(with_lag(solve(&sample, &band, instrument, j, b, false)?));
            }
        }
        let of = |pick: fn(&FirstOrder) -> Estimate| bracket(&ends.iter().map(pick).collect::<Vec<_>>());
        let middle = FirstOrder {
            inertia: of(|f| f.inertia),
            damping: of(|f| f.damping),
            lag: of(|f| f.lag),
            averaging: upper.averaging,
            friction: upper.friction,
        };
        let inertias = || ends.iter().map(|f| f.inertia);
        let by_value = |a: &Estimate, b: &Estimate| a.value.total_cmp(&b.value);
        let (lowest, highest) = (inertias().min_by(by_value), inertias().max_by(by_value));
        (middle, [lowest.unwrap_or(middle.inertia), highest.unwrap_or(middle.inertia)], Instrument::Torque)
    };
    if !(result.inertia.value > 0.0 && result.inertia.value.is_finite() && result.damping.value.is_finite()) {
        return Err("the inertia does not come out positive: torque and speed are not those of one machine".into());
    }
    let shifted = record.with_lag(lag).without_friction(result.friction.map_or(0.0, |f| f.value));
    // From the fit with the instrument: of a noisy gain the damping may come out as nothing, and a machine without
    // damping drifts away.
    let (refined, vaf_refined) = refine(&shifted, (result.inertia.value, result.damping.value.max(gain.1)));
    let vaf_result = vaf(&shifted, result.inertia.value, result.damping.value);
    let h = response(&spectra);
    let inside: Vec<f64> = h.iter().filter(|p| band.holds(p.0)).map(|p| p.2).collect();
    Ok(Identified {
        result,
        gain,
        refined,
        bracket: [upper, lower],
        ends,
        torque: (record.torque.iter().map(|t| t * t).sum::<f64>() / record.torque.len() as f64).sqrt(),
        instrument,
        averaging,
        vaf: (vaf_refined, vaf_result),
        coherence: inside.iter().sum::<f64>() / inside.len().max(1) as f64,
        response: h,
        welch: (1.0 / record.step, spectra.length as f64 * record.step, spectra.count()),
        band,
        turned,
    })
}

/// Solves `T = J Ω̇ + B Ω + C sign Ω`, with a late Ω and (`free`) an averaged one, over the bins of the band and all windows with
/// an instrument. `j` and `b` are from the round before. The interval is the sandwich with windows as what is
/// independent.
fn solve(s: &Spectra, band: &Band, instrument: Instrument, j: f64, b: f64, free: bool) -> Result<FirstOrder, String> {
    let directed = s.direction.iter().all(|d| !d.is_empty());
    // Inertia, damping, lag; averaging; friction.
    let used: Vec<usize> = (0..5).filter(|u| (*u != 3 || free) && (*u != 4 || directed)).collect();
    let unknowns = used.len();
    let bins: Vec<usize> = (2..s.frequencies.len()).filter(|k| band.holds(s.frequencies[*k])).collect();
    let (mut slope, mut right) = (DMatrix::<f64>::zeros(unknowns, unknowns), DVector::<f64>::zeros(unknowns));
    let mut parts: Vec<(DMatrix<f64>, DVector<f64>)> = Vec::new();
    for w in 0..s.count() {
        let (mut a, mut y) = (DMatrix::<f64>::zeros(unknowns, unknowns), DVector::<f64>::zeros(unknowns));
        for &k in &bins {
            let omega = std::f64::consts::TAU * s.frequencies[k];
            let i_omega = num(0.0, omega);
            let (t, v, d) = (s.torque[w][k], s.velocity[w][k], s.derivative[w][k]);
            let model = d * j + v * b;
            // A mean over T lowers Ω by (ω T)²/24, to first order in the square.
            let falling = omega * omega / 24.0;
            let direction = s.direction[w].get(k).copied().unwrap_or_default();
            let regressors = [d, v, i_omega * model, model * falling, direction];
            let source = match instrument {
                Instrument::Command => s.command[w].get(k).copied(),
                Instrument::Torque => Some(t),
                Instrument::Velocity => None,
            };
            let instruments = match source {
                Some(r) => {
                    let speed = r / num(b, omega * j);
                    [i_omega * speed, speed, i_omega * r, r * falling, direction]
                }
                None => regressors,
            };
            for (row, z) in used.iter().map(|u| instruments[*u].conj()).enumerate() {
                y[row] += (z * t).re;
                for (column, x) in used.iter().map(|u| regressors[*u]).enumerate() {
                    a[(row, column)] += (z * x).re;
                }
            }
        }
        slope += &a;
        right += &y;
        parts.push((a, y));
    }
    // Rows and columns of very different size: scaled, or the inverse is of noise.
    let inverse = inverse(slope).ok_or("inertia, damping and lag cannot be separated in this band")?;
    let x = &inverse * right;
    let mut scatter = DMatrix::<f64>::zeros(unknowns, unknowns);
    for (a, y) in &parts {
        let score = y - a * &x;
        scatter += &score * score.transpose();
    }
    let count = parts.len() as f64;
    let freedom = count - unknowns as f64;
    if count < 6.0 {
        return Err("it is too short: fewer than six windows".into());
    }
    let covariance = &inverse * scatter * inverse.transpose() * (OVERLAP * count / freedom);
    let of = |k: usize| Estimate { value: x[k], standard_uncertainty: covariance[(k, k)].max(0.0).sqrt(), freedom };
    let averaging = if free { of(3) } else { Estimate::exact(0.0) };
    let friction = directed.then(|| of(unknowns - 1));
    Ok(FirstOrder { inertia: of(0), damping: of(1), lag: of(2), averaging, friction })
}

/// The inverse of a matrix whose rows and columns are of very different size.
fn inverse(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let size = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
    let columns = DVector::from_iterator(
        matrix.ncols(),
        matrix.column_iter().map(|c| size(&mut c.iter().copied()).max(f64::MIN_POSITIVE)),
    );
    let mut scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |r, c| matrix[(r, c)] / columns[c]);
    let rows = DVector::from_iterator(
        scaled.nrows(),
        scaled.row_iter().map(|r| size(&mut r.iter().copied()).max(f64::MIN_POSITIVE)),
    );
    scaled = DMatrix::from_fn(scaled.nrows(), scaled.ncols(), |r, c| scaled[(r, c)] / rows[r]);
    let inverse = scaled.try_inverse()?;
    Some(DMatrix::from_fn(inverse.nrows(), inverse.ncols(), |r, c| inverse[(r, c)] / columns[r] / rows[c]))
}

fn num(re: f64, im: f64) -> spectra::Complex {
    spectra::Complex::new(re, im)
}

impl Test for RandomTorque {
    fn name(&self) -> &'static str {
        "random_torque"
    }

    fn run(&self, bench: &Bench, _: &[Outcome]) -> Option<Outcome> {
        let logs = logs_of(bench, BenchKind::RandomTorque);
        if logs.is_empty() {
            return None;
        }
        let ratio = bench.declared.ratio;
        let mut outcome = Outcome::default();
        let mut found: Vec<(&Log, Identified)> = Vec::new();
        for log in logs.iter().copied() {
            match identify(log, ratio) {
                Ok(identified) => {
                    outcome.logs.push(entry(log, &identified));
                    judge(&mut outcome, log, &identified);
                    found.push((log, identified));
                }
                Err(why) => {
                    outcome.findings.push(Finding::new(
                        "excitation",
                        Weight::Warning,
                        format!("{}: left out: {why}", log.name),
                    ));
                    let remarks = vec![format!("left out: {why}")];
                    outcome.logs.push(PerLog { log: log.name.clone(), used: false, values: Vec::new(), remarks });
                }
            }
        }
        if let Some((_, first)) = found.first() {
            outcome.method.push(format!(
                "H1 by Welch's method: Hann windows of {} s, half overlapping ({} windows at {} Hz), after the lag between \
                 the channels; first order fitted to its gain in the band, refined on the variance accounted for",
                number(first.welch.1),
                first.welch.2,
                number(first.welch.0)
            ));
            outcome.method.push(match first.instrument {
                Instrument::Command => "the row's number: T = J dΩ/dt + B Ω + C sign Ω over the same windows with the command as \
                                        instrument, so that noise of torque sensor and encoder does not bias it"
                    .into(),
                _ => "no command in the log: the row's number is the middle of H1 (J too large by the noise of the torque \
                      sensor) and H2 (too small by that of the speed), and the bracket is in the ±"
                    .to_string(),
            });
        }
        let of = |rotor: bool| {
            let end = |k: usize| {
                pool(&found.iter().filter(|(l, _)| l.rotor == rotor).map(|(_, i)| i.ends[k]).collect::<Vec<_>>())
            };
            Some([end(0)?, end(1)?])
        };
        let (with, without) = (of(true), of(false));
        for (pooled, name, remark) in [
            (with, "output_inertia_with_rotor", "J_r, at the output"),
            (without, "output_inertia_without_rotor", "J_nr, at the output"),
        ] {
            let Some(pooled) = pooled else { continue };
            let estimate = bracket(&pooled.map(|p| p.estimate));
            let between = pooled[0].between.max(pooled[1].between);
            let mut finding = between_logs(pooled[0].count, between, estimate.value);
            finding.text = format!("{}: {}", &remark[..remark.find(',').unwrap_or(0)], finding.text);
            outcome.findings.push(finding);
            outcome.quantities.push(Quantity {
                name,
                estimate: calibrated(estimate, &logs, GAINS),
                unit: "kg*m^2",
                remark: remark.into(),
            });
        }
        if let Some(with) = with {
            let ends = |pooled: [Pooled; 2]| pooled.map(|p| p.estimate);
            rotor(&mut outcome, bench, ends(with), without.map(ends), &logs);
            outcome.findings.extend(calibration(&logs, &[Channel::Torque]));
        }
        charts(&mut outcome, &found);
        Some(outcome)
    }
}

/// The rotor's inertia from those at the output, lowest and highest of each: a bracket is no scatter, so that neither
/// more logs nor the difference make it narrower.
fn rotor(outcome: &mut Outcome, bench: &Bench, with: [Estimate; 2], without: Option<[Estimate; 2]>, logs: &[&Log]) {
    let ratio = bench.declared.ratio;
    let k = 1.0 / (ratio * ratio);
    let (estimate, remark) = match without {
        Some(without) => {
            let parts = [(k, bracket(&with).half_width()), (k, bracket(&without).half_width())];
            let linear = combine(Combination::Linear, &parts);
            outcome.method.push(format!(
                "J_m = (J_r − J_nr)/N² with N = {}; ± by root sum square (in the row), by linear sum {} kg*m^2",
                number(ratio),
                number(linear)
            ));
            let ends = [0, 1].map(|e| rotor_inertia(with[e], without[1 - e], ratio));
            (bracket(&ends), "(J_r − J_nr)/N²")
        }
        None => {
            let (fixture, gear) = (bench.declared.fixture_inertia, bench.declared.gear.inertia);
            if fixture == 0.0 {
                outcome.findings.push(Finding::new(
                    "without_rotor",
                    Weight::Warning,
                    "no log without the rotor (rotor = \"removed\") and no fixture_inertia: couplings, bearings and gear \
                     count as rotor, J_m is an upper bound",
                ));
            }
            let ends = with.map(|w| Estimate::combined(k * (w.value - fixture) - gear, &[(k, w)]));
            (bracket(&ends), "J_r/N² less what is declared of fixture and gear")
        }
    };
    // The sensor's gain is that of both: it scales the difference.
    let estimate = calibrated(estimate, logs, GAINS);
    if estimate.value <= estimate.half_width() {
        outcome.findings.push(Finding::new(
            "rotor_inertia",
            Weight::Warning,
            "the rotor's inertia cannot be separated from zero: a lighter fixture, or a gear, would show it; it is not in the row",
        ));
        return;
    }
    outcome.quantities.push(Quantity { name: "rotor_inertia", estimate, unit: "kg*m^2", remark: remark.into() });
}

fn entry(log: &Log, i: &Identified) -> PerLog {
    let mut remarks = vec![
        format!("rotor {}", if log.rotor { "installed" } else { "removed" }),
        format!("band {} to {} Hz: {}", number(i.band.low), number(i.band.high), i.band.why),
        format!(
            "J by gain of H1 {}, refined on VAF {} ({} %), H1 {} and H2 {} kg*m^2",
            number(i.gain.0),
            number(i.refined.0),
            number((10.0 * i.vaf.0).round() / 10.0),
            number(i.bracket[0].inertia.value),
            number(i.bracket[1].inertia.value)
        ),
    ];
    if i.turned {
        remarks.push("torque and speed have opposite signs: turned".into());
    }
    PerLog {
        log: log.name.clone(),
        used: true,
        values: vec![
            ("output_inertia", i.result.inertia, "kg*m^2"),
            ("output_damping", i.result.damping, "N*m*s/rad"),
            ("lag", i.result.lag, "s"),
        ],
        remarks,
    }
}

type LogCheck = (&'static str, fn(&Identified) -> (Weight, String));

/// What is looked at in every log.
const LOG_CHECKS: &[LogCheck] = &[
    ("lag", |i| {
        let lag = i.result.lag;
        if lag.value.abs() > lag.half_width() && lag.value.abs() > 2e-4 {
            let late = if lag.value > 0.0 { "velocity" } else { "torque" };
            let ms = number(1e3 * lag.value.abs());
            (Weight::Note, format!("the {late} is {ms} ms late; it is taken out (left in, it passes for damping)"))
        } else {
            (Weight::Good, "torque and velocity come at the same time".into())
        }
    }),
    ("averaging", |i| {
        let (square, half) = (i.result.averaging.value, i.result.averaging.half_width());
        let ms = number(1e3 * square.abs().sqrt());
        match i.averaging {
            Averaging::Declared if square == 0.0 => {
                (Weight::Good, "the velocity is that of an instant, as its column says".into())
            }
            Averaging::Declared => {
                (Weight::Good, format!("the velocity is a difference over {ms} ms, as its column says: taken out"))
            }
            Averaging::Fitted if square > half => (
                Weight::Note,
                format!(
                    "the velocity reads low at high frequency, as a difference over {ms} ms does: taken out, and what that leaves is in the ±; `difference = \"…\"` in its column says it and narrows the ±"
                ),
            ),
            Averaging::Fitted if square < -half => (
                Weight::Note,
                "speed on torque falls slower than 1/f: a resonance above the band (compliance between sensor and rotor), or a torque that is filtered; it is taken out to second order, and what that leaves is in the ±"
                    .into(),
            ),
            Averaging::Fitted => (
                Weight::Good,
                "speed on torque falls as first order does; `difference = \"0 s\"` in the velocity's column (or over how long \
                 it is one) narrows the ±"
                    .into(),
            ),
            Averaging::Bracketed => (
                Weight::Note,
                "whether the velocity is a difference of positions is not said: anything up to one sample is in the ±; \
                 `difference = \"1 ms\"` in its column (\"0 s\" for none) narrows it"
                    .into(),
            ),
        }
    }),
    ("sticking", |i| {
        let Some(friction) = i.result.friction else {
            return (Weight::Good, "the speed turns too seldom for Coulomb friction to count".into());
        };
        let share = friction.value / i.torque;
        let text = format!("Coulomb friction is {} % of the torque (rms): fitted", number((100.0 * share).round()));
        if share > STICKS {
            let why = "but where the machine is at rest it is less, which passes for inertia; more torque helps";
            (Weight::Warning, format!("{text}, {why}"))
        } else {
            (Weight::Good, text)
        }
    }),
    ("coherence", |i| {
        let text = format!("mean coherence in the band {}", number((1e3 * i.coherence).round() / 1e3));
        if i.coherence < 0.8 {
            (Weight::Warning, format!("{text}: low; more torque, a stiffer coupling or a finer sensor would help"))
        } else {
            (Weight::Good, text)
        }
    }),
    ("excitation", |i| {
        let ratio = i.band.high / i.band.low;
        let text = format!("the band spans a factor of {} in frequency", number(ratio.round()));
        if ratio < 5.0 {
            (Weight::Warning, format!("{text}: too narrow to separate inertia from damping; excite over a decade"))
        } else {
            (Weight::Good, text)
        }
    }),
    ("corner", |i| {
        let corner = i.result.damping.value / (std::f64::consts::TAU * i.result.inertia.value);
        let text = format!("the corner B/(2π J) is at {} Hz", number(corner));
        if i.result.damping.value <= i.result.damping.half_width() {
            (Weight::Note, "the damping cannot be separated from zero here; a drag test shows friction better".into())
        } else if corner > i.band.high {
            (
                Weight::Warning,
                format!("{text}, above the band: damping rules, the inertia rests on the phase; excite higher"),
            )
        } else if corner < i.band.low {
            (Weight::Note, format!("{text}, below the band: inertia rules; the damping rests on the phase alone"))
        } else {
            (Weight::Good, format!("{text}, within the band"))
        }
    }),
    ("vaf", |i| {
        let text = format!("variance accounted for {} %", number((10.0 * i.vaf.1).round() / 10.0));
        let weight = if i.vaf.1 < 80.0 { Weight::Warning } else { Weight::Good };
        let why = if i.vaf.1 < 80.0 {
            ": first order does not explain it (friction, compliance, drift of the zero)"
        } else {
            ""
        };
        (weight, format!("{text}{why}"))
    }),
    ("noise_bias", |i| {
        let [h1, h2] = [i.bracket[0].inertia.value, i.bracket[1].inertia.value];
        let share = 100.0 * (h1 / h2 - 1.0);
        let text = format!("H1 and H2 differ by {} % in inertia", number((10.0 * share).round() / 10.0));
        if share.abs() > 5.0 && i.instrument != Instrument::Command {
            let text = format!("{text}: noise; log the command of the driving machine, which is free of it");
            (Weight::Warning, text)
        } else if share.abs() > 5.0 {
            (Weight::Note, format!("{text}: noise, which the command as instrument keeps out of the result"))
        } else {
            (Weight::Good, text)
        }
    }),
];

fn judge(outcome: &mut Outcome, log: &Log, identified: &Identified) {
    for (check, examine) in LOG_CHECKS {
        let (weight, text) = examine(identified);
        outcome.findings.push(Finding::new(check, weight, format!("{}: {text}", log.name)));
    }
}

fn charts(outcome: &mut Outcome, found: &[(&Log, Identified)]) {
    let (mut gain, mut coherence) = (Vec::new(), Vec::new());
    let mut marks = Vec::new();
    for (log, i) in found {
        let shown = |p: &&(f64, f64, f64)| p.0 > 0.0 && p.0 < 4.0 * i.band.high;
        let measured =
            |of: fn(&(f64, f64, f64)) -> (f64, f64)| i.response.iter().filter(shown).map(of).collect::<Vec<_>>();
        gain.push(Curve::new(Role::Curve, log.name.clone(), measured(|p| (p.0, p.1))));
        coherence.push(Curve::new(Role::Curve, log.name.clone(), measured(|p| (p.0, p.2))));
        let fit = |f: f64| {
            let omega = std::f64::consts::TAU * f;
            (i.result.inertia.value * omega).hypot(i.result.damping.value).recip()
        };
        let points = i.response.iter().filter(shown).map(|p| (p.0, fit(p.0))).collect();
        gain.push(Curve::new(
            Role::Fit,
            format!("1/(J s + B), VAF {} %", number((10.0 * i.vaf.1).round() / 10.0)),
            points,
        ));
        marks = vec![i.band.low, i.band.high];
    }
    if found.is_empty() {
        return;
    }
    let x = "frequency [Hz]".to_string();
    outcome.charts.push(Chart {
        x: x.clone(),
        y: "gain of speed on torque [rad/s per N*m]".into(),
        log_x: true,
        log_y: true,
        curves: gain,
        marks: marks.clone(),
        ..Chart::default()
    });
    outcome.charts.push(Chart {
        x,
        y: "coherence [1]".into(),
        log_x: true,
        curves: coherence,
        marks,
        ..Chart::default()
    });
}
