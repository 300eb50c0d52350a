//! Thermal resistances and time constants from a step of current: two nodes, winding and housing.
//!
//! `C_w Ṫ_w = R(T_w) i² − (T_w − T_h)/R_wh`, `C_h Ṫ_h = (T_w − T_h)/R_wh − (T_h − T_a)/R_ha`, with `τ_w = R_wh C_w` and
//! `τ_h = R_ha C_h`, as the limits have it; copper's resistance rises with its temperature.

use nalgebra::{DMatrix, DVector};

use super::estimate::Estimate;
use super::{
    Chart, Curve, Finding, Outcome, PerLog, Quantity, Role, Test, Weight, calibrated, calibration, find, logs_of,
};
use crate::bench::{Bench, BenchKind, Channel, Log};
use crate::signals;
use gearwise_model::actuator::thermal::resistance_factor;
use gearwise_model::catalog::REFERENCE_TEMPERATURE;
use gearwise_model::numerics::least_squares::{Unknown, minimise};
use gearwise_model::words::number;

/// The test.
pub struct ThermalStep;

/// At most so many samples are fitted.
const SAMPLES: usize = 1500;
/// Share of the largest heat from which a change from one row to the next is a switch, at an instant between the two.
const SWITCHED: f64 = 0.2;
/// Most switches whose instants are fitted.
const SWITCHES: usize = 4;
/// Number of the unknowns before the instants of the switches.
const PLAIN: usize = 6;
/// Temperatures that are less apart at the start count as alike \[K\].
const APART: f64 = 0.5;
/// Columns of the row, in the order of the unknowns.
const NAMES: [(&str, &str); 4] = [
    ("thermal_resistance_winding_housing", "K/W"),
    ("thermal_resistance_housing_ambient", "K/W"),
    ("thermal_time_constant_winding", "s"),
    ("thermal_time_constant_housing", "s"),
];

/// A log as the fit sees it.
struct Heating {
    time: Vec<f64>,
    current: Vec<f64>,
    winding: Option<Vec<f64>>,
    housing: Option<Vec<f64>>,
    switches: Vec<Switch>,
}

/// A change of the current at an instant that lies between two rows of the log.
struct Switch {
    /// Place of the sample before which it is.
    sample: usize,
    /// Currents before and after it \[A\].
    currents: [f64; 2],
    /// First and last share of the time between the two samples at which it may be.
    within: [f64; 2],
}

/// Copper's resistance: value and temperature that it refers to.
#[derive(Debug, Clone, Copy)]
struct Copper {
    resistance: Estimate,
    reference: f64,
}

impl Heating {
    fn of(log: &Log) -> Option<Heating> {
        let every = log.len().div_ceil(SAMPLES).max(1);
        let thin = |values: &[f64]| values.iter().step_by(every).copied().collect::<Vec<f64>>();
        // Heat between two kept samples is that of all samples there: the mean of the squares.
        let current = log.channel(Channel::Current)?;
        let heating = current.chunks(every).map(|c| super::line::mean(&c.iter().map(|i| i * i).collect::<Vec<_>>()));
        // A missing current is the last that was seen: one cell that is not there must not stop the heat.
        let first = current.iter().copied().find(|i| i.is_finite())?;
        let heating: Vec<f64> = heating
            .scan(first * first, |last, square| {
                *last = square.unwrap_or(*last);
                Some(last.sqrt())
            })
            .collect();
        let largest = current.iter().filter(|i| i.is_finite()).map(|i| i * i).fold(0.0, f64::max);
        let is_switch = |k: &usize| (current[*k].powi(2) - current[k - 1].powi(2)).abs() > SWITCHED * largest;
        let switch = |k: usize| {
            let sample = (k - 1) / every + 1;
            let [from, to] = [sample - 1, sample].map(|s| log.time.get(s * every).copied());
            let share = |t: f64| Some(((t - from?) / (to? - from?)).clamp(0.0, 1.0));
            let within = [share(log.time[k - 1])?, share(log.time[k])?];
            Some(Switch { sample, currents: [current[k - 1], current[k]], within })
        };
        let switches: Vec<Switch> = (1..current.len()).filter(is_switch).filter_map(switch).collect();
        Some(Heating {
            switches: if switches.len() > SWITCHES { Vec::new() } else { switches },
            time: thin(&log.time),
            current: heating,
            winding: log.channel(Channel::WindingTemperature).map(thin),
            housing: log.channel(Channel::HousingTemperature).map(thin),
        })
    }

    /// Winding and housing \[K\] at every sample. `p` has resistances, time constants, both temperatures at the start, and of each switch
    /// the share of the time between two samples that the current before it lasts.
    fn simulate(&self, p: &[f64], copper: Copper, ambient: f64) -> Vec<(f64, f64)> {
        let [r_wh, r_ha, tau_w, tau_h] = [p[0], p[1], p[2], p[3]];
        let (c_w, c_h) = (tau_w / r_wh, tau_h / r_ha);
        let slope = |(w, h): (f64, f64), i: f64| {
            let heat = copper.resistance.value * resistance_factor(w, copper.reference) * i * i;
            let through = (w - h) / r_wh;
            ((heat - through) / c_w, (through - (h - ambient) / r_ha) / c_h)
        };
        let mut at = (p[4], p[5]);
        let mut out = vec![at];
        // Fast enough for either node, the housing's capacity coupled through the winding's resistance too.
        let fastest = 0.2 * tau_w.min(tau_h).min(c_h * r_wh);
        let mut hold = |span: f64, i: f64| {
            let parts = ((span / fastest).ceil()).clamp(1.0, 200.0);
            let h = span / parts;
            for _ in 0..parts as usize {
                let a = slope(at, i);
                let b = slope((at.0 + 0.5 * h * a.0, at.1 + 0.5 * h * a.1), i);
                let c = slope((at.0 + 0.5 * h * b.0, at.1 + 0.5 * h * b.1), i);
                let d = slope((at.0 + h * c.0, at.1 + h * c.1), i);
                at.0 += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
                at.1 += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
            }
            at
        };
        for k in 1..self.time.len() {
            let span = self.time[k] - self.time[k - 1];
            let switch = self.switches.iter().position(|switch| switch.sample == k);
            out.push(match switch.map(|of| (p[PLAIN + of], self.switches[of].currents)) {
                Some((lasts, [before, after])) => {
                    hold(lasts * span, before);
                    hold((1.0 - lasts) * span, after)
                }
                None => hold(span, self.current[k - 1]),
            });
        }
        out
    }

    /// What the model leaves of the temperatures that were measured.
    fn left(&self, p: &[f64], copper: Copper, ambient: f64) -> Vec<f64> {
        let model = self.simulate(p, copper, ambient);
        let part = |measured: &Option<Vec<f64>>, of: fn(&(f64, f64)) -> f64| -> Vec<f64> {
            let Some(measured) = measured else { return Vec::new() };
            measured.iter().zip(&model).map(|(t, m)| if t.is_finite() { of(m) - t } else { 0.0 }).collect()
        };
        let mut left = part(&self.winding, |m| m.0);
        left.extend(part(&self.housing, |m| m.1));
        left
    }

    fn fit(&self, copper: Copper, ambient: f64) -> Option<(Vec<f64>, [Estimate; 4], f64)> {
        let winding = self.winding.as_ref()?;
        let first = |values: &[f64]| values.iter().copied().find(|v| v.is_finite());
        let last = |values: &[f64]| values.iter().rev().copied().find(|v| v.is_finite());
        let (w0, w1) = (first(winding)?, last(winding)?);
        let h0 = self.housing.as_ref().and_then(|h| first(h)).unwrap_or(w0);
        let h1 = self.housing.as_ref().and_then(|h| last(h)).unwrap_or(0.5 * (w1 + ambient));
        let mean_square = self.current.iter().map(|i| i * i).sum::<f64>() / self.current.len() as f64;
        let heat = copper.resistance.value * resistance_factor(w1, copper.reference) * mean_square;
        let duration = self.time.last()? - self.time.first()?;
        if heat <= 0.0 || w1 - w0 < 2.0 {
            return None;
        }
        let (r_wh, r_ha) = ((w1 - h1).max(0.5) / heat, (h1 - ambient).max(0.5) / heat);
        let unknown = |start: f64| Unknown { start, scale: start, lower: 0.01 * start, upper: 100.0 * start };
        let temperature = |start: f64| Unknown { start, scale: 1.0, lower: start - 20.0, upper: start + 20.0 };
        let of = |_: usize, p: &[f64]| self.left(p, copper, ambient);
        // Two starts for the time constants: the better end counts.
        let best = [0.02, 0.1]
            .iter()
            .map(|share| {
                let mut unknowns = vec![
                    unknown(r_wh),
                    unknown(r_ha),
                    unknown(share * duration),
                    unknown(0.5 * duration),
                    temperature(w0),
                    temperature(h0),
                ];
                unknowns.extend(self.switches.iter().map(|Switch { within: [lower, upper], .. }| Unknown {
                    start: 0.5 * (lower + upper),
                    scale: 0.5,
                    lower: *lower,
                    upper: *upper,
                }));
                minimise(1, &of, &unknowns, 60, 1e-9)
            })
            .min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let values = best.values;
        let left = of(0, &values);
        let count = values.len();
        let columns: Vec<Vec<f64>> = (0..count)
            .map(|j| {
                let step = match j {
                    0..4 => 1e-4 * values[j],
                    4..PLAIN => 1e-4,
                    _ if values[j] > 0.5 => -1e-4,
                    _ => 1e-4,
                };
                let mut moved = values.clone();
                moved[j] += step;
                of(0, &moved).iter().zip(&left).map(|(a, b)| (a - b) / step).collect()
            })
            .collect();
        let n = left.len();
        let scale: Vec<f64> = columns.iter().map(|c| c.iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-300)).collect();
        let x = DMatrix::from_fn(n, count, |r, c| columns[c][r] / scale[c]);
        let inverse = (x.transpose() * &x).cholesky()?.inverse();
        let residual = DVector::from_column_slice(&left);
        let squares = residual.norm_squared();
        // Neighbours that are alike count less, by the channel where they are most alike.
        let alike = left.chunks(self.time.len()).map(alike).fold(1.0, f64::max);
        let effective = (n as f64 / alike).max(count as f64 + 2.0);
        let variance = squares / n as f64 * (n as f64 / effective) * effective / (effective - count as f64);
        let of = |j: usize| Estimate {
            value: values[j],
            standard_uncertainty: (variance * inverse[(j, j)]).sqrt() / scale[j],
            freedom: effective - count as f64,
        };
        let rmse = (squares / n as f64).sqrt();
        Some((values.clone(), [of(0), of(1), of(2), of(3)], rmse))
    }
}

/// By how much a mean of residuals scatters more than if they were independent: the sum of their autocorrelation up to
/// where it is lost in chance. A first-order process would miss what noise on top of a slow wander hides.
fn alike(left: &[f64]) -> f64 {
    let squares = left.iter().map(|r| r * r).sum::<f64>().max(f64::MIN_POSITIVE);
    let lost = 2.0 / (left.len() as f64).sqrt();
    let at = |lag: usize| left.iter().zip(&left[lag..]).map(|(a, b)| a * b).sum::<f64>() / squares;
    1.0 + 2.0 * (1..left.len() / 4).map(at).take_while(|r| *r > lost).sum::<f64>()
}

impl Test for ThermalStep {
    fn name(&self) -> &'static str {
        "thermal_step"
    }

    fn run(&self, bench: &Bench, before: &[Outcome]) -> Option<Outcome> {
        let logs = logs_of(bench, BenchKind::ThermalStep);
        let log = *logs.first()?;
        let mut outcome = Outcome {
            method: vec![
                "two nodes (winding, housing) simulated with copper's rising resistance, fitted to the temperatures; \
                 intervals widened for residuals that hang together"
                    .into(),
            ],
            ..Outcome::default()
        };
        let terminals = bench.readings.terminals.as_ref();
        let measured = find(before, "resistance").map(|resistance| Copper {
            resistance,
            reference: terminals.and_then(|t| t.temperature).unwrap_or(REFERENCE_TEMPERATURE),
        });
        let declared = bench
            .declared
            .motor
            .as_ref()
            .map(|m| Copper { resistance: Estimate::exact(m.resistance), reference: m.reference_temperature });
        let Some(copper) = measured.or(declared) else {
            let text = "the heat needs a resistance: read the terminals, or declare a motor";
            outcome.findings.push(Finding::new("resistance", Weight::Warning, text));
            return Some(outcome);
        };
        if logs.len() > 1 {
            outcome.findings.push(Finding::new(
                "one_log",
                Weight::Note,
                format!("the first of {} logs is used; another cooling is another R_th", logs.len()),
            ));
        }
        let Some(heating) = Heating::of(log) else { return Some(outcome) };
        let housing = heating.housing.as_ref().or(heating.winding.as_ref());
        let start = housing.and_then(|h| h.iter().copied().find(|v| v.is_finite()));
        let Some(ambient) = bench.readings.ambient.or(start) else { return Some(outcome) };
        if bench.readings.ambient.is_none() {
            outcome.findings.push(Finding::new(
                "ambient",
                Weight::Note,
                format!("no `ambient`: taken as the first temperature, {} degC", number(ambient - 273.15)),
            ));
        }
        let mut entry = PerLog { log: log.name.clone(), used: true, values: Vec::new(), remarks: Vec::new() };
        let Some((values, estimates, rmse)) = heating.fit(copper, ambient) else {
            entry.used = false;
            let why = if heating.winding.is_none() {
                "no winding temperature: the two nodes cannot be separated"
            } else {
                "the winding warms by less than 2 K: nothing can be fitted"
            };
            outcome.findings.push(Finding::new("warming", Weight::Warning, format!("{}: left out: {why}", log.name)));
            entry.remarks.push(format!("left out: {why}"));
            outcome.logs.push(entry);
            return Some(outcome);
        };
        for (k, ((name, unit), estimate)) in NAMES.iter().zip(estimates).enumerate() {
            // Heat is R i²: its error is the resistances' too.
            let r = copper.resistance;
            let estimate = if k < 2 {
                let with = Estimate::combined(estimate.value, &[(1.0, estimate), (estimate.value / r.value, r)]);
                calibrated(with, &logs[..1], &[(&[Channel::Current], 2.0)])
            } else {
                estimate
            };
            outcome.quantities.push(Quantity { name, estimate, unit, remark: String::new() });
        }
        outcome.findings.extend(calibration(&logs[..1], &[Channel::Current]));
        checks(&mut outcome, &heating, &values, ambient, rmse);
        entry.remarks.push(format!("residual {} K rms", number(rmse)));
        outcome.logs.push(entry);
        let model = heating.simulate(&values, copper, ambient);
        let celsius = |t: f64| t - 273.15;
        let measured = |of: &Option<Vec<f64>>| -> Vec<(f64, f64)> {
            of.iter().flat_map(|v| heating.time.iter().zip(v).map(|(t, v)| (*t, celsius(*v)))).collect()
        };
        outcome.charts.push(Chart {
            x: "time [s]".into(),
            y: "winding and housing [degC]".into(),
            curves: vec![
                Curve::new(Role::Measured, "winding", measured(&heating.winding)),
                Curve::new(Role::Measured, "housing", measured(&heating.housing)),
                Curve::new(
                    Role::Fit,
                    "two nodes",
                    heating.time.iter().zip(&model).map(|(t, m)| (*t, celsius(m.0))).collect(),
                ),
                Curve::new(
                    Role::Fit,
                    "two nodes",
                    heating.time.iter().zip(&model).map(|(t, m)| (*t, celsius(m.1))).collect(),
                ),
            ],
            ..Chart::default()
        });
        Some(outcome)
    }
}

fn checks(outcome: &mut Outcome, heating: &Heating, values: &[f64], ambient: f64, rmse: f64) {
    let (winding, housing) = (values[4], values[5]);
    let apart = (winding - housing).abs().max((housing - ambient).abs());
    outcome.findings.push(if heating.housing.is_some() && apart > APART {
        Finding::new(
            "start",
            Weight::Warning,
            format!(
                "at the start the winding reads {} degC and the housing {} degC in an ambient of {} degC: if the motor was \
                 cold, sensors differ by that much, and each R_th is off by that over its own difference of temperature, \
                 which is not in the ±; start cold and take the offset out",
                number((10.0 * (winding - 273.15)).round() / 10.0),
                number((10.0 * (housing - 273.15)).round() / 10.0),
                number((10.0 * (ambient - 273.15)).round() / 10.0)
            ),
        )
    } else {
        Finding::new("start", Weight::Good, "at the start all temperatures are alike")
    });
    let duration = heating.time[heating.time.len() - 1] - heating.time[0];
    outcome.findings.push(if duration < 2.0 * values[3] {
        Finding::new(
            "duration",
            Weight::Warning,
            format!(
                "the log lasts {} s, the housing's time constant is {} s: the end temperature is extrapolated; record two \
                 of them at least",
                number(duration.round()),
                number(values[3].round())
            ),
        )
    } else {
        Finding::new("duration", Weight::Good, "it lasts more than two time constants of the housing")
    });
    if heating.housing.is_none() {
        outcome.findings.push(Finding::new(
            "housing",
            Weight::Warning,
            "no housing temperature: how the resistance divides rests on the shape of one curve alone",
        ));
    }
    let rise = heating.winding.as_ref().map_or(0.0, |w| {
        signals::quantile(w.clone(), 1.0).unwrap_or(0.0) - signals::quantile(w.clone(), 0.0).unwrap_or(0.0)
    });
    let text = format!("two nodes leave {} K of {} K", number(rmse), number(rise.round()));
    outcome.findings.push(if rmse > 0.05 * rise {
        Finding::new("two_nodes", Weight::Warning, format!("{text}: more happens than two nodes explain"))
    } else {
        Finding::new("two_nodes", Weight::Good, text)
    });
}
