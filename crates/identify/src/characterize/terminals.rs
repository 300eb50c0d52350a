//! Resistance and inductance from line-to-line readings.
//!
//! The mean of the three pairs is brought to the q axis (half of it, wye or delta alike). The instrument's ± is
//! common to the three; how they scatter is a second part, and the two combine by the GUM.

use super::estimate::Estimate;
use super::{Finding, Outcome, Quantity, Test, Weight};
use crate::bench::Bench;
use gearwise_model::catalog::convention::{Commutation, Terminals as Between, Winding, word};
use gearwise_model::words::number;

/// The test.
pub struct Terminals;

/// Readings of the pairs that differ by more than this share are spoken of.
const UNEQUAL: f64 = 0.03;

/// Mean of readings with the instrument's ± (95 %, common to all) and their scatter; `None` where there is no
/// reading, or a single one without ±.
pub fn mean(readings: &[f64], instrument: Option<f64>) -> Option<Estimate> {
    let count = readings.len() as f64;
    if readings.is_empty() {
        return None;
    }
    let value = readings.iter().sum::<f64>() / count;
    let mut parts: Vec<(f64, Estimate)> = instrument.map(|i| (1.0, Estimate::stated(0.0, i))).into_iter().collect();
    if readings.len() > 1 {
        let variance = readings.iter().map(|r| (r - value).powi(2)).sum::<f64>() / (count - 1.0);
        let scatter = Estimate { value: 0.0, standard_uncertainty: (variance / count).sqrt(), freedom: count - 1.0 };
        parts.push((1.0, scatter));
    }
    (!parts.is_empty()).then(|| Estimate::combined(value, &parts))
}

impl Test for Terminals {
    fn name(&self) -> &'static str {
        "terminals"
    }

    fn run(&self, bench: &Bench, _: &[Outcome]) -> Option<Outcome> {
        let readings = bench.readings.terminals.as_ref()?;
        let commutation = super::row::commutation(bench);
        let factor = Between::LineToLine.resistance(readings.winding, commutation)?;
        let mut outcome = Outcome::default();
        let brushed = commutation == Commutation::Brushed;
        outcome.method.push(if brushed {
            "reading between the two terminals".into()
        } else {
            let winding = readings.winding.map_or("not said", |w| word(Winding::NAMES, &w));
            format!(
                "mean of the readings line to line, halved for the q axis (wye and delta alike); winding style: \
                 {winding}; instrument's ± and scatter of the pairs combined"
            )
        });
        for (name, unit, values, instrument) in [
            ("resistance", "ohm", &readings.resistance, readings.resistance_tolerance),
            ("inductance", "H", &readings.inductance, readings.inductance_tolerance),
        ] {
            if values.is_empty() {
                continue;
            }
            if instrument.is_none() {
                outcome.findings.push(Finding::new(
                    "instrument",
                    Weight::Warning,
                    format!(
                        "{name}: no `{name}_tolerance`: the instrument's own error, common to all readings, is not in \
                         the ±"
                    ),
                ));
            }
            let Some(estimate) = mean(values, instrument) else {
                outcome.findings.push(Finding::new(
                    "instrument",
                    Weight::Warning,
                    format!("{name}: one reading without ± has no uncertainty and is left out"),
                ));
                continue;
            };
            let (low, high) = values.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(*v), h.max(*v)));
            let spread = (high - low) / estimate.value;
            if values.len() == 3 {
                let (weight, text) = if spread > UNEQUAL {
                    let why = if name == "inductance" {
                        "a salient rotor, or a rotor that moved between readings"
                    } else {
                        "a poor contact, or a damaged winding"
                    };
                    (
                        Weight::Warning,
                        format!("the three pairs differ by {} %: {why}", number((1e3 * spread).round() / 10.0)),
                    )
                } else {
                    (Weight::Good, format!("the three pairs agree within {} %", number((1e3 * spread).round() / 10.0)))
                };
                outcome.findings.push(Finding::new("phases_alike", weight, format!("{name}: {text}")));
            }
            outcome.quantities.push(Quantity {
                name,
                estimate: estimate.scaled(factor),
                unit,
                remark: format!(
                    "{} line to line",
                    gearwise_model::words::handy::with_error(estimate.value, None, unit)
                ),
            });
        }
        if readings.temperature.is_none() && !readings.resistance.is_empty() {
            outcome.findings.push(Finding::new(
                "reading_temperature",
                Weight::Note,
                "no `temperature` of the winding: the resistance is taken at 25 degC (copper: 0.39 % per kelvin)",
            ));
        }
        Some(outcome)
    }
}
