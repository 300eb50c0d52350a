//! Answers about the motors of a catalogue alone: `rank --json`, `compare --json`, `audit --json`.

#[cfg(feature = "schema")]
use std::borrow::Cow;

#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::Value;

use super::design::Metrics;
use super::document;
use super::finite;
#[cfg(feature = "schema")]
use super::number_or_null;
use crate::audit::{broken, word};
use crate::catalog::lacks::counts;
use crate::columns::metric_key;
use crate::compare::Comparison;
use crate::rank::Ranking;
use gearwise_model::actuator::metrics::{METRICS, metric};
use gearwise_model::actuator::step_response;
use gearwise_model::catalog::audit::{self, audit_motor};
use gearwise_model::catalog::{self, Catalog, Motor};

/// What `rank` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Ranked<'a> {
    /// The metric that orders.
    pub sorted_by: &'static str,
    /// The motors, the best first.
    pub motors: Vec<Place<'a>>,
    /// Motors of which a number that the metric needs is not known.
    pub not_ranked: Vec<&'a str>,
}

/// A motor in its place.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Place<'a> {
    /// Its place, from 1.
    pub rank: usize,
    /// Id of the motor.
    pub motor: &'a str,
    /// Manufacturer.
    pub manufacturer: &'a str,
    /// Where the row comes from.
    pub source: &'a str,
    /// How sure it is that it is ahead of the next; `null` where a ± is missing.
    pub probability_ahead_of_next: Option<f64>,
    #[serde(flatten)]
    metrics: Estimates<'a>,
}

/// Every metric of a motor, with its ± where the row states one: combined as independent, and at worst.
#[derive(Debug)]
struct Estimates<'a> {
    motor: &'a Motor,
    default_tolerance: Option<f64>,
}

/// Keys of a metric's tolerances.
fn tolerance_keys(name: &str) -> [String; 2] {
    [format!("{name}_relative_tolerance"), format!("{name}_relative_worst_case")]
}

impl Serialize for Estimates<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for metric in METRICS {
            let estimate = metric.of_with_tolerance(self.motor, self.default_tolerance);
            map.serialize_entry(&metric_key(metric), &estimate.map(|e| e.value))?;
            if let Some(e) = estimate.filter(|e| e.independent.is_some()) {
                let [independent, worst] = tolerance_keys(metric.name);
                map.serialize_entry(&independent, &e.independent)?;
                map.serialize_entry(&worst, &e.worst_case)?;
            }
        }
        map.end()
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Estimates<'_> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Estimates".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let mut properties = serde_json::Map::new();
        for metric in METRICS {
            properties.insert(metric_key(metric), number_or_null(metric.meaning).to_value());
            let [independent, worst] = tolerance_keys(metric.name);
            let about = [(independent, "its ±, combined as independent"), (worst, "its ± at worst")];
            properties.extend(about.map(|(key, about)| (key, number_or_null(about).to_value())));
        }
        let required: Vec<String> = METRICS.iter().map(metric_key).collect();
        json_schema!({ "type": "object", "required": required, "properties": properties })
    }
}

/// Motors in the order of a metric.
pub fn ranked(ranking: &Ranking) -> Value {
    let default_tolerance = ranking.default_tolerance;
    let motors = ranking.ranked.iter().enumerate().map(|(place, (motor, _))| Place {
        rank: place + 1,
        motor: &motor.id,
        manufacturer: &motor.manufacturer,
        source: &motor.source,
        probability_ahead_of_next: ranking.sure(place),
        metrics: Estimates { motor, default_tolerance },
    });
    let not_ranked = ranking.unranked.iter().map(|motor| motor.id.as_str()).collect();
    document("rank", Ranked { sorted_by: ranking.metric.name, motors: motors.collect(), not_ranked })
}

/// What `compare` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Compared<'a> {
    /// Actuator inertia that both are matched to.
    pub matched_inertia_kgm2: Option<f64>,
    /// S_M of the second over S_M of the first.
    pub responsiveness_ratio: Option<f64>,
    /// The two motors.
    pub motors: Vec<Side<'a>>,
}

/// One of two motors, as the program computes with it: power-invariant q axis.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Side<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Resistance.
    pub resistance_ohm: Option<f64>,
    /// Inductance.
    pub inductance_h: Option<f64>,
    /// Torque constant.
    pub torque_constant_nm_per_a: Option<f64>,
    /// Back-EMF constant.
    pub back_emf_constant_vs_per_rad: Option<f64>,
    /// Rotor inertia.
    pub rotor_inertia_kgm2: Option<f64>,
    /// Mass.
    pub mass_kg: Option<f64>,
    /// Outer diameter; of a module that is a box the diagonal across its axis.
    pub outer_diameter_m: Option<f64>,
    /// Axial length.
    pub length_m: Option<f64>,
    /// Price as its row says it.
    pub price: Option<Price>,
    /// Time until it is delivered.
    pub lead_time_s: Option<f64>,
    /// Metrics, SI.
    metrics: Metrics<'a>,
    /// What a massless gear without loss makes of it at the matched inertia.
    pub matched: Option<Matched>,
    /// Its response to a voltage step, without its inductance.
    pub step_without_inductance: Option<Step>,
    /// The same with its inductance.
    pub step_with_inductance: Option<Step>,
    /// Where the row comes from.
    pub source: &'a str,
    /// Note of the row.
    pub note: &'a str,
    /// Which of its numbers no row says: estimated from rows built alike, and what is made from them with it.
    pub estimated: Vec<super::design::Estimated>,
    /// What was assumed of the row.
    pub assumptions: &'a [&'static str],
    /// What the audit found.
    pub audit: Vec<AuditRemark>,
}

/// A price of a row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Price {
    /// Of one.
    pub value: f64,
    /// Its currency.
    pub currency: &'static str,
    /// Its day.
    pub date: String,
    /// So many have to be bought at once for it.
    pub quantity: f64,
}

impl From<catalog::Price> for Price {
    fn from(price: catalog::Price) -> Price {
        let catalog::Price { value, currency, date, quantity } = price;
        Price { value, currency: currency.code(), date: date.to_string(), quantity }
    }
}

/// An actuator of the matched inertia.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Matched {
    /// Ratio N.
    pub ratio: f64,
    /// Torque constant at the output.
    pub actuator_torque_constant_nm_per_a: f64,
    /// Motor constant at the output.
    pub actuator_motor_constant_nm_per_sqrt_w: f64,
}

/// A response to a voltage step.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Step {
    /// Time to 63 % of the final speed.
    pub rise_time_s: f64,
    /// Largest speed over the final one, less one.
    pub overshoot: f64,
}

impl From<step_response::StepResponse> for Step {
    fn from(of: step_response::StepResponse) -> Step {
        Step { rise_time_s: of.rise_time, overshoot: of.overshoot }
    }
}

/// What the audit found in a row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct AuditRemark {
    /// The check.
    pub code: &'static str,
    /// What it found.
    pub message: String,
    /// What would explain it.
    pub explanation: Option<String>,
}

impl From<audit::Finding> for AuditRemark {
    fn from(of: audit::Finding) -> AuditRemark {
        AuditRemark { code: of.code, message: of.message, explanation: of.explanation }
    }
}

/// Two motors next to each other.
pub fn compared(comparison: &Comparison) -> Value {
    let side = |i: usize| {
        let m = comparison.motors[i];
        Side {
            motor: &m.id,
            resistance_ohm: finite(m.resistance),
            inductance_h: m.inductance,
            torque_constant_nm_per_a: finite(m.torque_constant),
            back_emf_constant_vs_per_rad: finite(m.back_emf_constant),
            rotor_inertia_kgm2: m.rotor_inertia,
            mass_kg: m.mass,
            outer_diameter_m: m.sheet.outer_diameter.map(|p| p.value),
            length_m: m.sheet.length.map(|p| p.value),
            price: m.sheet.offer.price().map(Price::from),
            lead_time_s: m.sheet.offer.lead_time,
            metrics: Metrics(m),
            matched: comparison.matched[i].as_ref().map(|x| Matched {
                ratio: x.ratio,
                actuator_torque_constant_nm_per_a: x.torque_constant,
                actuator_motor_constant_nm_per_sqrt_w: x.motor_constant,
            }),
            step_without_inductance: comparison.without_inductance[i].map(Step::from),
            step_with_inductance: comparison.with_inductance[i].map(Step::from),
            source: &m.source,
            note: &m.note,
            estimated: super::design::estimated(m),
            assumptions: &m.assumptions,
            audit: audit_motor(m).into_iter().map(AuditRemark::from).collect(),
        }
    };
    let s_m = metric("s_m").map(|s| comparison.motors.map(|m| s.value(m)));
    let responsiveness_ratio = match s_m {
        Some([Some(a), Some(b)]) => Some(b / a),
        _ => None,
    };
    let motors = vec![side(0), side(1)];
    document(
        "compare",
        Compared {
            matched_inertia_kgm2: Some(comparison.inertia).filter(|inertia| *inertia > 0.0),
            responsiveness_ratio,
            motors,
        },
    )
}

/// What `audit` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Audited<'a> {
    /// Number of motors.
    pub motors: usize,
    /// Number of gears.
    pub gears: usize,
    /// Number of findings that are errors and that no note of a row explains.
    pub errors: usize,
    /// What was found.
    pub findings: Vec<AuditFinding<'a>>,
    /// What rows of motors lack, most rows first.
    pub lacks: Vec<LackedBy>,
}

/// Something that rows lack.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct LackedBy {
    /// What.
    pub lacks: &'static str,
    /// In how many rows of motors.
    pub rows: usize,
    /// Of these, rows for which rows built alike say it.
    pub estimated: usize,
    /// What that prevents where it is not estimated.
    pub prevents: &'static str,
}

/// What the audit found, and in which row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct AuditFinding<'a> {
    /// Id of the row.
    pub id: &'a str,
    /// The check.
    pub code: &'static str,
    /// `error`, `accepted` (an error that the row's note explains) or `note`.
    pub severity: &'static str,
    /// What it found.
    pub message: &'a str,
    /// What would explain it.
    pub explanation: Option<&'a str>,
}

impl<'a> AuditFinding<'a> {
    fn new(of: &'a audit::Finding) -> AuditFinding<'a> {
        let audit::Finding { id, code, message, explanation, .. } = of;
        AuditFinding { id, code, severity: word(of), message, explanation: explanation.as_deref() }
    }
}

/// What an audit found.
pub fn audited(catalog: &Catalog, findings: &[audit::Finding]) -> Value {
    let answer = Audited {
        motors: catalog.motors.len(),
        gears: catalog.gears.len(),
        errors: broken(findings),
        findings: findings.iter().map(AuditFinding::new).collect(),
        lacks: counts(catalog)
            .into_iter()
            .map(|c| LackedBy { lacks: c.lack.name, rows: c.rows, estimated: c.estimated, prevents: c.lack.prevents })
            .collect(),
    };
    document("audit", answer)
}
