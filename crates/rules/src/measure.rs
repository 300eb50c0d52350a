//! What rules measure: every margin and reserve of the model's limits, every metric of the motor, and figures of
//! the design. A new measure is one line in [`measures`].

use std::sync::LazyLock;

use super::facts::{JointFacts, RobotFacts};
use super::place::Place;
use gearwise_model::actuator::limits::LIMITS;
use gearwise_model::actuator::metrics::METRICS;
use gearwise_model::units::{self, Kind};
use gearwise_select::evaluate::FEASIBILITY_TOLERANCE;
use gearwise_select::examine::Examined;
use gearwise_select::figures::{FIGURES, Figure};

/// Something about a design that has a number.
#[derive(Debug)]
pub struct Measure {
    /// Name.
    pub name: String,
    /// What it measures; `None` for a pure number, and for metrics whose unit has no kind.
    pub kind: Option<&'static Kind>,
    /// Unit in which it is shown, and in which a bare number of a rules file is.
    pub unit: &'static str,
    /// What it is.
    pub meaning: String,
    /// Where it is read.
    pub value: Value,
}

/// How a measure is read.
#[derive(Clone, Copy)]
pub enum Value {
    /// A figure of a joint's design.
    Figure(&'static Figure),
    /// Of a joint's evaluated design, SI.
    Design(fn(&JointFacts, &Examined) -> Option<f64>),
    /// Margin of a limit.
    Margin(&'static str),
    /// Reserve of a limit, without the safety factor.
    Reserve(&'static str),
    /// A metric of the motor, by its name.
    Metric(&'static str),
    /// Of the whole robot, SI.
    Robot(fn(&RobotFacts) -> Option<f64>),
}

impl std::fmt::Debug for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Value::Figure(_) => "Figure",
            Value::Design(_) => "Design",
            Value::Margin(_) => "Margin",
            Value::Reserve(_) => "Reserve",
            Value::Metric(_) => "Metric",
            Value::Robot(_) => "Robot",
        })
    }
}

impl Measure {
    /// Whether it is one of the whole robot.
    pub fn of_robot(&self) -> bool {
        matches!(self.value, Value::Robot(_))
    }

    /// Its value at a joint, SI; `None` where unknown.
    pub fn at(&self, facts: &JointFacts) -> Option<f64> {
        if let Value::Metric(name) = self.value {
            return gearwise_model::actuator::metrics::metric(name)?.value(facts.choice.motor);
        }
        let examined = facts.examined.as_ref().ok()?;
        match self.value {
            Value::Figure(figure) => figure.value(&examined.facts(&facts.choice)),
            Value::Design(read) => read(facts, examined),
            Value::Margin(limit) => examined.margin(limit),
            Value::Reserve(limit) => examined.reserve(facts.choice.joint, limit),
            Value::Metric(_) | Value::Robot(_) => None,
        }
    }

    /// Whether it is the reserve of a limit that is exceeded.
    pub fn is_exceeded(&self, facts: &JointFacts) -> bool {
        let Value::Reserve(limit) = self.value else { return false };
        let margin = facts.examined.as_ref().ok().and_then(|e| e.margin(limit));
        margin.is_some_and(|margin| margin < -FEASIBILITY_TOLERANCE)
    }

    /// Its value for the robot, SI; `None` where unknown.
    pub fn of(&self, facts: &RobotFacts) -> Option<f64> {
        match self.value {
            Value::Robot(read) => read(facts),
            _ => None,
        }
    }

    /// A value for people, with its unit.
    pub fn show(&self, value: f64) -> String {
        let text =
            gearwise_model::words::number(if self.unit == "1" { value } else { units::in_unit(value, self.unit) });
        match self.unit {
            "1" => text,
            unit => format!("{text} {unit}"),
        }
    }

    /// A number in the measure's unit, in SI.
    pub fn to_si(&self, value: f64) -> f64 {
        value / units::in_unit(1.0, self.unit)
    }

    /// Where it is decided in the design.
    pub fn place(&self) -> Place {
        match self.value {
            Value::Metric(_) => Place::Motor,
            Value::Robot(_) => Place::Design,
            _ => Place::Reduction,
        }
    }
}

type Own = (&'static str, Option<&'static Kind>, &'static str, &'static str, Value);

/// What rules measure beside the figures of a design.
const OWN: &[Own] = &[
    ("ratio", None, "1", "ratio N", Value::Design(|_, e| Some(e.evaluation.ratio))),
    (
        "temperature_reserve",
        None,
        "K",
        "what the winding stays below its highest temperature, in steady state and over the motion",
        Value::Design(temperature_reserve),
    ),
    (
        "inertia_ratio",
        None,
        "1",
        "inertia of the load (`load_inertia` of the design, else as the motion shows it) over the reflected inertia",
        Value::Design(|_, e| Some(e.load_inertia? / e.evaluation.reflected_inertia)),
    ),
    (
        "objective_excess",
        None,
        "1",
        "objective over that of the best ratio of the same motor under the limits and the rules, less one",
        Value::Design(|facts, e| {
            let (_, best) = e.best.filter(|(_, best)| *best > 0.0)?;
            Some(e.evaluation.objective(&facts.choice.joint.objective)? / best - 1.0)
        }),
    ),
    (
        "robot_mass",
        Some(&units::MASS),
        "kg",
        "mass of all actuators together",
        Value::Robot(|facts| facts.total(|e| e.evaluation.mass)),
    ),
    (
        "robot_price",
        None,
        "1",
        "price of all actuators together, in the currency of `[prices]`; where all of it is known",
        Value::Robot(|facts| facts.total(|e| e.evaluation.price?.whole.value())),
    ),
    (
        "robot_loss",
        Some(&units::POWER),
        "W",
        "mean loss of all actuators together",
        Value::Robot(|facts| facts.total(|e| Some(e.evaluation.loss))),
    ),
    (
        "distinct_motors",
        None,
        "1",
        "number of different motors",
        Value::Robot(|facts| Some(facts.motors().len() as f64)),
    ),
];

/// The steady state and the peak over the motion are both below the limit by this \[K\].
fn temperature_reserve(_: &JointFacts, examined: &Examined) -> Option<f64> {
    let steady = examined.hottest.zip(examined.winding_temperature.kelvin_or_infinite());
    let steady = steady.map(|(limit, steady)| limit - steady);
    let over_motion = examined.evaluation.least("winding_peak_temperature").map(|m| m.bound - m.demand);
    match (steady, over_motion) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

/// Every measure.
pub fn measures() -> &'static [Measure] {
    static ALL: LazyLock<Vec<Measure>> = LazyLock::new(|| {
        let own = OWN.iter().map(|(name, kind, unit, meaning, value)| Measure {
            name: (*name).into(),
            kind: *kind,
            unit,
            meaning: (*meaning).into(),
            value: *value,
        });
        let figures = FIGURES.iter().map(|figure| Measure {
            name: figure.name.into(),
            kind: Some(figure.kind),
            unit: figure.unit,
            meaning: figure.meaning.into(),
            value: Value::Figure(figure),
        });
        let margins = LIMITS.iter().map(|limit| Measure {
            name: format!("{}_margin", limit.name),
            kind: None,
            unit: "1",
            meaning: format!("1 − demand/limit of {}", limit.name),
            value: Value::Margin(limit.name),
        });
        // Where no safety factor acts, reserve and margin are the same.
        let reserves = LIMITS.iter().map(|limit| Measure {
            name: format!("{}_reserve", limit.name),
            kind: None,
            unit: "1",
            meaning: match limit.safety {
                true => format!("the same of {} without the requirement's safety factor", limit.name),
                false => format!("the same as {}_margin: no safety factor acts there", limit.name),
            },
            value: Value::Reserve(limit.name),
        });
        let metrics = METRICS.iter().map(|metric| Measure {
            // A figure of the whole design has the plain name; that of the bare motor says so.
            name: if FIGURES.iter().any(|figure| figure.name == metric.name) {
                format!("motor_{}", metric.name)
            } else {
                metric.name.into()
            },
            kind: units::KINDS.iter().copied().find(|kind| units::unit_of(metric.unit, kind).is_ok()),
            unit: metric.unit,
            meaning: format!("the motor's {}", metric.meaning),
            value: Value::Metric(metric.name),
        });
        figures.chain(own).chain(margins).chain(reserves).chain(metrics).collect()
    });
    &ALL
}

/// The measure of a name.
pub fn measure(name: &str) -> Option<&'static Measure> {
    measures().iter().find(|m| m.name == name)
}
