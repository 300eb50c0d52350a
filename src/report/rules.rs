//! The registry of rules for people and programs.

use serde_json::{Value, json};

use super::table::{table, wrap};
use crate::rules::measure::measures;
use crate::rules::{RULES, Rule, Test};

/// Bounds of a rule in words, if it has any.
fn bounds(rule: &Rule) -> Option<String> {
    let Test::Bounds { measures: names, min, max } = &rule.test else { return None };
    let show = |value: f64| crate::rules::measure::measure(names[0]).map_or(String::new(), |m| m.show(value));
    let min = min.map(|v| format!("min = {}", show(v)));
    let max = max.map(|v| format!("max = {}", show(v)));
    let ends: Vec<String> = min.into_iter().chain(max).collect();
    Some(format!("{} on {}", ends.join(", "), names.join(", ")))
}

/// All rules.
pub fn list() -> String {
    let rows: Vec<Vec<String>> =
        RULES.iter().map(|r| vec![r.code.into(), r.name.into(), r.severity.name().into(), r.summary.into()]).collect();
    format!(
        "{}\n`gearwise rule CODE` says more; `gearwise rule --measures` lists what rules of your own can measure.\n",
        table(&["code", "name", "severity", "asks that"], &rows)
    )
}

/// All measures.
pub fn measure_list() -> String {
    let rows: Vec<Vec<String>> =
        measures().iter().map(|m| vec![m.name.clone(), m.unit.into(), m.meaning.clone()]).collect();
    table(&["measure", "unit", "what it is"], &rows)
}

/// One rule.
pub fn text(rule: &Rule) -> String {
    let mut out = format!("{} {} ({})\n{}\n", rule.code, rule.name, rule.severity.name(), wrap(rule.summary, 0));
    for (what, text) in
        [("What it does", rule.what), ("Why", rule.why), ("Example", rule.example), ("How to mend it", rule.mend)]
    {
        out.push_str(&format!("\n{what}\n  {}\n", wrap(text, 2)));
    }
    if let Some(bounds) = bounds(rule) {
        out.push_str(&format!("\nBounds\n  {}\n", wrap(&bounds, 2)));
    }
    let key = match rule.test {
        Test::Bounds { min: Some(_), .. } => "min = 0.05",
        Test::Bounds { .. } => "max = 5",
        _ => "severity = \"note\"",
    };
    let limit = matches!(rule.test, Test::Limit(_));
    let (table, key) = if limit { ("allow", String::new()) } else { ("rule", format!("{key}\n  ")) };
    out.push_str(&format!(
        "\nIn rules.toml\n  [[{table}]]\n  rule = \"{}\"\n  {key}joints = [\"knee*\"]\n  reason = \"…\"\n",
        rule.name
    ));
    out
}

/// One rule, for programs.
pub fn json(rule: &Rule) -> Value {
    let (measured, min, max) = match &rule.test {
        Test::Bounds { measures, min, max } => (Some(measures.to_vec()), *min, *max),
        _ => (None, None, None),
    };
    json!({
        "code": rule.code, "name": rule.name, "severity": rule.severity.name(), "summary": rule.summary, "what": rule.what,
        "why": rule.why, "example": rule.example, "mend": rule.mend, "measures": measured, "min": min, "max": max,
    })
}
