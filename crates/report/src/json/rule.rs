//! `rule --json`.

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::document;

/// What `rule` prints.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Answer {
    /// The rules, or the one that was asked for.
    pub rules: Vec<Rule>,
}

/// A design rule.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
pub struct Rule {
    /// Its code.
    pub code: &'static str,
    /// Its name.
    pub name: &'static str,
    /// `error`, `warning` or `note`.
    pub severity: &'static str,
    /// What it asks, in one line.
    pub summary: &'static str,
    /// What it does.
    pub what: &'static str,
    /// Why it exists.
    pub why: &'static str,
    /// An example.
    pub example: &'static str,
    /// How to fix what it finds.
    pub fix: &'static str,
    /// The figures that it holds to bounds; `null` where it asks something else.
    pub measures: Option<&'static [&'static str]>,
    /// Its lower bound.
    pub min: Option<f64>,
    /// Its upper bound.
    pub max: Option<f64>,
}

/// Rules, for programs.
pub fn json<'a>(rules: impl IntoIterator<Item = &'a gearwise_rules::Rule>) -> Value {
    document("rule", Answer { rules: rules.into_iter().map(Rule::from).collect() })
}

impl From<&gearwise_rules::Rule> for Rule {
    fn from(rule: &gearwise_rules::Rule) -> Rule {
        let (measures, min, max) = match &rule.test {
            gearwise_rules::Test::Bounds { measures, min, max } => (Some(*measures), *min, *max),
            _ => (None, None, None),
        };
        Rule {
            code: rule.code,
            name: rule.name,
            severity: rule.severity.name(),
            summary: rule.summary,
            what: rule.what,
            why: rule.why,
            example: rule.example,
            fix: rule.fix,
            measures,
            min,
            max,
        }
    }
}
