//! What another number of turns would do for a motor.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;

use crate::turns::{Constant, refused};
use gearwise_model::catalog::Motor;
use gearwise_model::requirement::Joint;
use gearwise_select::answer::Reason;
use gearwise_select::turns::Rewinding;

/// What a motor would do with another number of turns than its row.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct OtherTurns<'a> {
    /// `possible`, `impossible` (proved), `none_found` (not proved), `not_judged`, or `none` where it has no other number of turns.
    pub verdict: &'static str,
    /// The same in a sentence.
    pub says: String,
    /// The best design with another number of turns, where it is possible.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub best: Option<Rewound<'a>>,
}

/// A design with another number of turns.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Rewound<'a> {
    /// Ratio N.
    pub ratio: f64,
    /// Id of the gear, where it is one of the catalogue.
    pub gear: Option<&'a str>,
    /// Mean loss, which does not depend on the turns.
    pub loss_w: f64,
    /// Objective; `null` where it counts a current, which depends on the turns.
    pub objective: Option<f64>,
    /// Whether no ratio and no number of turns is better, proved.
    pub proved: bool,
    /// Least number of turns, as a multiple of the row's; 0 where nothing asks for any.
    pub min: f64,
    /// The limit that it comes from.
    pub min_by: Option<&'static str>,
    /// Largest number of turns, as a multiple of the row's; `null` where there is none.
    pub max: Option<f64>,
    /// The limit that it comes from.
    pub max_by: Option<&'static str>,
    /// The constant to ask the maker for, in the convention of its sheet.
    pub constant: Option<Ask>,
    /// Limits that could not be checked.
    pub not_checked: Vec<&'static str>,
    /// Motors of the catalogue that look like the same motor with such a number of turns.
    pub rows: Vec<&'a str>,
}

/// A constant that goes with the turns.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Ask {
    /// Its symbol: `Kv`, `K_T` or `K_B`.
    pub symbol: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What the row says.
    pub row: f64,
    /// The least; `null` where there is none.
    pub min: Option<f64>,
    /// The largest; `null` where there is none.
    pub max: Option<f64>,
}

impl<'a> OtherTurns<'a> {
    /// Of a motor; `refusal` is why it cannot do it as it is wound.
    pub(super) fn new(
        how: &'a Rewinding<'a>,
        motor: &'a Motor,
        refusal: Option<&Reason>,
        joint: &Joint,
    ) -> OtherTurns<'a> {
        let (verdict, best) = match how {
            Rewinding::Found(other) => {
                let constant = Constant::of(motor).map(|k| {
                    let [min, max] = k.range(&other.turns);
                    Ask { symbol: k.symbol, unit: k.unit, row: k.value, min, max }
                });
                let best = Rewound {
                    ratio: other.ratio,
                    gear: other.gear,
                    loss_w: other.loss,
                    objective: other.objective,
                    proved: other.proved,
                    min: other.turns.min,
                    min_by: other.turns.min_by,
                    max: Some(other.turns.max).filter(|max| max.is_finite()),
                    max_by: other.turns.max_by,
                    constant,
                    not_checked: other.unchecked.iter().map(|(limit, _)| *limit).collect(),
                    rows: other.rows.iter().map(|row| row.id.as_str()).collect(),
                };
                ("possible", Some(best))
            }
            Rewinding::Useless(_) => ("impossible", None),
            Rewinding::NoneFound => ("none_found", None),
            Rewinding::Unjudged(_) => ("not_judged", None),
            Rewinding::NotAsked(_) => ("none", None),
        };
        OtherTurns { verdict, says: refused(how, refusal, motor, joint), best }
    }
}
