//! A design, and what became of a motor that is none: the objects that all answers about joints are made of.

use std::borrow::Cow;
#[cfg(feature = "schema")]
use std::collections::BTreeMap;

#[cfg(feature = "schema")]
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::finite;
#[cfg(feature = "schema")]
use super::number_or_null;
use super::turns::OtherTurns;
use crate::columns::metric_key;
use crate::{optimize, unjudged};
use gearwise_model::actuator::fitted::Note;
use gearwise_model::actuator::limits::Remark;
use gearwise_model::actuator::losses;
use gearwise_model::actuator::metrics::METRICS;
use gearwise_model::actuator::parts::PartKind;
use gearwise_model::catalog::convention::word;
use gearwise_model::catalog::estimate::Estimate;
use gearwise_model::catalog::{Construction, Motor};
use gearwise_model::requirement::{FamilyPlace, Joint};
use gearwise_select::answer::SpringChoice;
use gearwise_select::evaluate;
use gearwise_select::figures::{FIGURES, Facts};
use gearwise_select::program;

/// A motor with its ratio or gear at a joint.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Design<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// Ratio N.
    pub ratio: f64,
    /// Teeth of a gear of this ratio, where the requirement lists the stages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub teeth: Option<Teeth>,
    /// Where the ratio lies among the points of its gear family, where it may lie between them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub family: Option<Family<'a>>,
    /// Whether every limit that could be checked is kept.
    pub feasible: bool,
    /// Objective; `null` where a number that it needs is not known.
    pub objective: Option<f64>,
    /// Unit of the objective; `1` for a weighted sum.
    pub objective_unit: &'static str,
    /// Where the loss is, by its parts: they sum to `loss_w`.
    pub losses_w: Losses,
    /// Parts of the loss of which nothing is known.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unknown_losses: Vec<&'static str>,
    #[serde(flatten)]
    figures: Figures<'a>,
    /// Currency of `price` and `price_at_least`, where the requirement has `[prices]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub price_currency: Option<&'static str>,
    /// Price of the parts of which it is known, where the requirement has `[prices]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub price_at_least: Option<f64>,
    /// Whether the winding has no steady temperature: the copper's resistance rises faster than heat flows off.
    pub thermal_runaway: bool,
    /// Margin of each limit, `1 − demand/limit`, by its name.
    pub margins: Pairs<'a>,
    /// Each limit in full.
    pub limits: Vec<Limit<'a>>,
    /// Limits that could not be checked, and why.
    pub not_checked: Vec<NotChecked<'a>>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Assumed<'a>>,
    /// Numbers of the motor that its row lacks and that are estimated.
    pub estimated: Vec<Estimated>,
    /// What the audit calls an error in the motor's row.
    pub audit_errors: Vec<String>,
    /// How what was fitted to this motor enters the limits.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fitted: Vec<Fitted>,
    #[serde(flatten)]
    pub(super) solution: Option<Solution<'a>>,
    /// Metrics of the bare motor, SI.
    metrics: Metrics<'a>,
    /// The parallel spring, where the joint asks for one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spring: Option<Spring>,
}

/// Mean losses over the motion in W, at the end of what is known of the motor's drag where they are larger.
#[derive(Debug, Clone, Copy, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Losses {
    /// In the motor's copper.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub copper: f64,
    /// Bearings, hysteresis and eddy currents of the motor.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub motor_drag: f64,
    /// What the gear's efficiency takes.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub gear_load: f64,
    /// What the gear takes without load.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub gear_no_load: f64,
    /// In drive and leads.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub drive: f64,
    /// Of what comes back to the bus, what is not kept: in a braking resistor, or in the supply.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub braking: f64,
}

impl From<losses::Losses> for Losses {
    fn from(of: losses::Losses) -> Losses {
        let losses::Losses { copper, motor_drag, gear_load, gear_no_load, drive, braking } = of;
        Losses { copper, motor_drag, gear_load, gear_no_load, drive, braking }
    }
}

/// What solving for the ratio gave: where the ratio may be, what ends that, and how sure the best one is.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Solution<'a> {
    /// Feasible ratios about the best one.
    pub window: [f64; 2],
    /// What ends the window: a limit that is exceeded beyond it, or where `binds_at` has `unjudged`, one that cannot be judged there.
    pub binds: Binds<&'static str>,
    /// The same with the instant at which they do.
    pub binds_at: Binds<Bind<'a>>,
    /// Every interval of feasible ratios.
    pub windows: Vec<Window>,
    /// Change of the objective per unit of each limit that binds at the best ratio, SI.
    pub shadow_prices: Pairs<'a>,
    /// The same relative to both: per cent of the objective per per cent of the limit.
    pub sensitivity: Pairs<'a>,
    /// How sure it is that no ratio is better.
    pub certificate: Certificate,
}

/// What is at the lower and at the upper end.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Binds<T> {
    /// At the lower end.
    pub low: T,
    /// At the upper end.
    pub high: T,
}

/// A limit that ends a window.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Bind<'a> {
    /// Name of the limit; `ratio_min` and `ratio_max` are the requirement's own.
    pub limit: &'static str,
    /// The load case that it binds in, where the joint has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<&'a str>,
    /// Line of the motion (of the case) that it binds at, from 0.
    pub sample: Option<usize>,
    /// When that is.
    pub time_s: Option<f64>,
    /// Its name for people.
    pub at: Option<String>,
    /// Why what lies beyond cannot be judged; `null` where it exceeds the limit.
    pub unjudged: Option<&'a str>,
}

/// Where a ratio lies among the points of a gear family.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Family<'a> {
    /// Name of the family.
    pub name: &'a str,
    /// The point that the ratio is at, or the two that it lies between: nobody published that gear.
    pub points: Vec<&'a str>,
}

impl<'a> Family<'a> {
    /// Of a ratio at a joint; `None` where its gear is of no family, or a row of the catalogue.
    pub fn new(joint: &'a Joint, ratio: f64) -> Option<Family<'a>> {
        let map = joint.family_map()?;
        let points = match map.place(ratio)? {
            FamilyPlace::At(point) => vec![point.id.as_str()],
            FamilyPlace::Between(below, above) => vec![below.id.as_str(), above.id.as_str()],
        };
        Some(Family { name: map.family(), points })
    }
}

/// The planetary gear with the fewest teeth that has a ratio.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Teeth {
    /// Teeth of sun and ring of each stage, the motor's first.
    pub stages: Vec<[u32; 2]>,
    /// Planets of each stage.
    pub planets: u32,
    /// How many other sets of teeth have the ratio.
    pub others: u64,
}

impl Teeth {
    /// Of a ratio at a joint; `None` where the requirement does not list stages.
    pub fn new(joint: &Joint, ratio: f64) -> Option<Teeth> {
        let (teeth, gear) = (joint.ratio.teeth()?, joint.ratio.toothed(ratio)?);
        let stages = gear.train.stages.iter().map(|stage| [stage.sun, stage.ring]).collect();
        Some(Teeth { stages, planets: teeth.planets, others: gear.others })
    }
}

/// An interval of feasible ratios.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Window {
    /// Smallest ratio.
    pub min: f64,
    /// Largest ratio.
    pub max: f64,
    /// Limit that forbids a smaller one.
    pub low: &'static str,
    /// Limit that forbids a larger one.
    pub high: &'static str,
}

/// How sure the best ratio is.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Certificate {
    /// Whether it is proved.
    pub certified: bool,
    /// No ratio has an objective below this.
    pub lower_bound: Option<f64>,
    /// `(objective − lower bound)/|objective|`. Where the search ended after its share of the work, an upper bound of it, if one is known.
    pub gap: Option<f64>,
    /// How the bound was found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<&'static str>,
    /// Why it is not proved.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub because: Option<String>,
}

impl From<&program::Certificate> for Certificate {
    fn from(certificate: &program::Certificate) -> Certificate {
        match certificate {
            program::Certificate::Certified { lower_bound, gap, method } => Certificate {
                certified: true,
                lower_bound: Some(*lower_bound),
                gap: Some(*gap),
                method: Some(method),
                because: None,
            },
            program::Certificate::NotCertified(why) => {
                let (gap, because) = (certificate.gap(), Some(why.to_string()));
                Certificate { certified: false, lower_bound: None, gap, method: None, because }
            }
        }
    }
}

/// A limit with its demand.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Limit<'a> {
    /// Name of the limit.
    pub limit: &'static str,
    /// What the motion demands; `null` where it grows without end.
    pub demand: Option<f64>,
    /// What may be had.
    pub bound: Option<f64>,
    /// Unit of both.
    pub unit: &'static str,
    /// `1 − demand/bound`.
    pub margin: Option<f64>,
    /// Whose limit it is.
    pub of: &'static str,
    /// Of a limit on the parts of the actuator: the part whose number the demand is, where it is that of one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<&'static str>,
    /// Of a limit on the parts of the actuator: whether a part is not known, so that the demand is at least this.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<bool>,
    /// The load case that has the largest demand, where the joint has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<&'a str>,
    /// Line of the motion (of the case) with the largest demand, from 0.
    pub sample: Option<usize>,
    /// When that is.
    pub time_s: Option<f64>,
    /// Its name for people.
    pub at: Option<Cow<'a, str>>,
}

/// A limit that could not be checked or judged.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct NotChecked<'a> {
    /// Name of the limit.
    pub limit: &'a str,
    /// What is not known.
    pub because: &'a str,
}

/// A limit that counts as kept.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Assumed<'a> {
    /// Name of the limit.
    pub limit: &'a str,
    /// As far as what holds.
    #[serde(rename = "as")]
    pub holds: &'a str,
}

/// A number of the motor that is estimated from rows built alike.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Estimated {
    /// What it is.
    pub quantity: &'static str,
    /// What the model computes with, SI: the pessimistic end of the prediction interval (one-sided, 90 %).
    pub value: f64,
    /// The middle of the interval, SI.
    pub middle: f64,
    /// SI unit of both.
    pub unit: &'static str,
    /// How many rows it is made from.
    pub rows: usize,
    /// How they are built.
    pub construction: &'static str,
}

/// What is estimated of a motor.
pub fn estimated(motor: &Motor) -> Vec<Estimated> {
    let one = |estimate: &Estimate| Estimated {
        quantity: estimate.of.name(),
        value: estimate.value,
        middle: estimate.middle,
        unit: estimate.of.unit(),
        rows: estimate.rows,
        construction: word(Construction::NAMES, &estimate.construction),
    };
    motor.estimates.iter().map(one).collect()
}

/// How an effect that was fitted enters.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Fitted {
    /// Name of the effect.
    pub name: String,
    /// How it enters the limits.
    pub enters: String,
}

impl From<Note> for Fitted {
    fn from(note: Note) -> Fitted {
        Fitted { name: note.effect.to_string(), enters: note.how.to_string() }
    }
}

/// A parallel spring and what it is worth.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Spring {
    /// Stiffness.
    pub stiffness_nm_per_rad: f64,
    /// Rest angle; `null` without stiffness.
    pub rest_angle_rad: Option<f64>,
    /// Whether the objective leaves the spring free, so that the least stiffness was taken.
    pub least_stiffness: bool,
    /// No ratio and spring are better than this; `null` where no bound was found.
    pub lower_bound: Option<f64>,
    /// Relative gap between objective and bound.
    pub gap: Option<f64>,
    /// Whether the same motor can do it without a spring.
    pub feasible_without: bool,
    /// Best ratio without a spring.
    pub ratio_without: Option<f64>,
    /// Objective without a spring.
    pub objective_without: Option<f64>,
    /// Loss without a spring.
    pub loss_without_w: Option<f64>,
    /// Share of that loss that the spring saves.
    pub loss_saved: Option<f64>,
}

impl Spring {
    /// A spring that was chosen, with the loss of its design \[W\].
    pub fn new(spring: &SpringChoice, loss: f64) -> Spring {
        Spring {
            stiffness_nm_per_rad: spring.stiffness,
            rest_angle_rad: spring.rest_angle,
            least_stiffness: spring.least_stiffness,
            lower_bound: spring.lower_bound,
            gap: spring.gap,
            feasible_without: spring.without.is_some(),
            ratio_without: spring.without.map(|w| w.ratio),
            objective_without: spring.without.map(|w| w.objective),
            loss_without_w: spring.without.map(|w| w.loss),
            loss_saved: spring.saving(loss),
        }
    }
}

/// A motor that keeps all that can be judged, and of which a limit that the requirement states cannot be.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Unjudged<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// Why it cannot be judged, in a sentence.
    pub because: String,
    /// The limits that cannot be judged, and what is not known.
    pub limits: Vec<NotChecked<'a>>,
    /// The design as far as is known, where one was worked out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<Design<'a>>,
}

impl<'a> Unjudged<'a> {
    /// A motor, and what cannot be judged of it.
    pub fn new(motor: &'a str, gear: Option<&'a str>, because: &[Remark], design: Option<Design<'a>>) -> Unjudged<'a> {
        Unjudged { motor, gear, because: unjudged::sentence(because), limits: not_checked(because), design }
    }
}

/// A motor that cannot do it.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Rejected<'a> {
    /// Id of the motor.
    pub motor: &'a str,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// Why, in a sentence.
    pub because: String,
    /// The same in short, the same text for all motors that fail alike.
    pub class: String,
    /// What another number of turns would do (`optimize`); left out where it was not asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turns: Option<OtherTurns<'a>>,
    /// The design, where one was worked out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub design: Option<Design<'a>>,
}

/// The figures of a design, from their one list.
#[derive(Debug, Clone, Copy)]
struct Figures<'a>(Facts<'a>);

impl Serialize for Figures<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(FIGURES.len()))?;
        for figure in FIGURES {
            map.serialize_entry(figure.key, &figure.finite(&self.0))?;
        }
        map.end()
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Figures<'_> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Figures".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        object(FIGURES.iter().map(|figure| (figure.key.to_string(), number_or_null(figure.meaning))))
    }
}

/// The metrics of a motor, from their one list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Metrics<'a>(pub(super) &'a Motor);

impl Serialize for Metrics<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(METRICS.iter().map(|metric| (metric_key(metric), metric.value(self.0))))
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Metrics<'_> {
    fn schema_name() -> Cow<'static, str> {
        "Metrics".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        object(METRICS.iter().map(|metric| (metric_key(metric), number_or_null(metric.meaning))))
    }
}

/// An object of which every key is there.
#[cfg(feature = "schema")]
fn object(properties: impl Iterator<Item = (String, Schema)>) -> Schema {
    let properties: serde_json::Map<_, _> = properties.map(|(key, schema)| (key, schema.to_value())).collect();
    let required: Vec<&String> = properties.keys().collect();
    json_schema!({ "type": "object", "required": required, "properties": properties })
}

/// Numbers by name, in their order.
#[derive(Debug)]
pub struct Pairs<'a>(Vec<(&'a str, Option<f64>)>);

impl<'a> Pairs<'a> {
    /// These, in their order.
    pub fn of(pairs: impl Iterator<Item = (&'a str, f64)>) -> Pairs<'a> {
        Pairs(pairs.map(|(name, value)| (name, finite(value))).collect())
    }
}

impl Serialize for Pairs<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().copied())
    }
}

#[cfg(feature = "schema")]
impl JsonSchema for Pairs<'_> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Pairs".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        <BTreeMap<String, Option<f64>>>::json_schema(generator)
    }
}

/// Margins by the name of the limit, the least of each.
pub fn margins(of: &[evaluate::Margin]) -> Pairs<'_> {
    // A limit may be asked for by several: the least margin counts.
    let mut least: Vec<(&str, f64)> = Vec::new();
    for margin in of {
        match least.iter_mut().find(|(limit, _)| *limit == margin.limit) {
            Some((_, known)) if margin.margin.total_cmp(known).is_lt() => *known = margin.margin,
            Some(_) => {}
            None => least.push((margin.limit, margin.margin)),
        }
    }
    Pairs::of(least.into_iter())
}

/// Limits in full.
pub fn limits<'a>(of: &[evaluate::Margin], joint: &'a Joint) -> Vec<Limit<'a>> {
    let one = |m: &evaluate::Margin| Limit {
        limit: m.limit,
        demand: finite(m.demand),
        bound: finite(m.bound),
        unit: m.unit,
        margin: finite(m.margin),
        of: m.owner,
        part: m.parts.and_then(|parts| parts.part).map(PartKind::word),
        at_least: m.parts.map(|parts| parts.missing.is_some()),
        case: m.case(joint).map(|case| case.name.as_str()),
        sample: m.sample.and_then(|k| joint.motion.given_sample(k)),
        time_s: m.sample.and_then(|k| time_of(joint, k)),
        at: m.sample.map(|k| joint.motion.name_sample(k).into()),
    };
    of.iter().map(one).collect()
}

/// When a sample of a joint's motion is \[s\]; operating points have no time.
fn time_of(joint: &Joint, sample: usize) -> Option<f64> {
    (!joint.motion.is_point(sample)).then(|| joint.motion.moment(sample))
}

/// The load case that a sample is of.
fn case_of(joint: &Joint, sample: usize) -> Option<&str> {
    joint.motion.case_of(sample).map(|case| case.name.as_str())
}

/// Limits that could not be checked.
pub fn not_checked(of: &[Remark]) -> Vec<NotChecked<'static>> {
    of.iter().map(|&(limit, because)| NotChecked { limit, because }).collect()
}

/// Limits that count as kept.
pub fn assumed(of: &[Remark]) -> Vec<Assumed<'_>> {
    of.iter().map(|(limit, holds)| Assumed { limit, holds }).collect()
}

fn bind<'a>(of: &'a program::Bind, joint: &'a Joint) -> Bind<'a> {
    Bind {
        limit: of.limit,
        case: of.sample.and_then(|k| case_of(joint, k)),
        sample: of.sample.and_then(|k| joint.motion.given_sample(k)),
        time_s: of.sample.and_then(|k| time_of(joint, k)),
        at: of.sample.map(|k| joint.motion.name_sample(k)),
        unjudged: of.unjudged,
    }
}

impl<'a> Solution<'a> {
    /// What the ratio program found.
    pub fn new(optimum: &'a program::Optimum, joint: &'a Joint) -> Solution<'a> {
        let window = optimum.window();
        let prices = |of: fn(&program::ShadowPrice) -> f64| {
            Pairs::of(optimum.shadow_prices.iter().map(|price| (price.limit, of(price))))
        };
        let one = |w: &program::Window| Window { min: w.min, max: w.max, low: w.low.limit, high: w.high.limit };
        Solution {
            window: [window.min, window.max],
            binds: Binds { low: window.low.limit, high: window.high.limit },
            binds_at: Binds { low: bind(&window.low, joint), high: bind(&window.high, joint) },
            windows: optimum.windows.iter().map(one).collect(),
            shadow_prices: prices(|price| price.price),
            sensitivity: prices(|price| price.elasticity),
            certificate: (&optimum.certificate).into(),
        }
    }
}

impl<'a> Design<'a> {
    /// A design at a joint.
    pub fn new(facts: Facts<'a>, joint: &'a Joint) -> Design<'a> {
        let e = facts.evaluation;
        Design {
            motor: &facts.motor.id,
            gear: facts.gear,
            ratio: e.ratio,
            teeth: Teeth::new(joint, e.ratio).filter(|_| facts.gear.is_none()),
            family: Family::new(joint, e.ratio).filter(|_| facts.gear.is_none()),
            feasible: e.feasible,
            objective: facts.objective,
            objective_unit: joint.objective.unit(),
            losses_w: e.losses.into(),
            unknown_losses: e.unknown_losses.iter().map(|part| part.words()).collect(),
            figures: Figures(facts),
            price_currency: e.price.map(|cost| cost.currency.code()),
            price_at_least: e.price.map(|cost| cost.whole.known),
            thermal_runaway: facts.winding_temperature.runs_away(),
            margins: margins(&e.margins),
            limits: limits(&e.margins, joint),
            not_checked: not_checked(facts.unchecked),
            assumed: assumed(facts.assumed),
            estimated: estimated(facts.motor),
            audit_errors: optimize::contradictions(facts.motor),
            fitted: optimize::fitted_notes(facts.motor, joint).into_iter().map(Fitted::from).collect(),
            solution: facts.optimum.map(|optimum| Solution::new(optimum, joint)),
            metrics: Metrics(facts.motor),
            spring: facts.spring.map(|spring| Spring::new(spring, e.loss)),
        }
    }
}
