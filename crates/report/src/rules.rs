//! The registry of rules for people.

use super::table::{Column, Table, paragraph};
use gearwise_rules::measure::measures;
use gearwise_rules::{Rule, Test, every_rule};

/// Bounds of a rule in words, if it has any.
fn bounds(rule: &Rule) -> Option<String> {
    let Test::Bounds { measures: names, min, max } = &rule.test else { return None };
    let show = |value: f64| gearwise_rules::measure::measure(names[0]).map_or(String::new(), |m| m.show(value));
    let min = min.map(|v| format!("min = {}", show(v)));
    let max = max.map(|v| format!("max = {}", show(v)));
    let ends: Vec<String> = min.into_iter().chain(max).collect();
    Some(format!("{} on {}", ends.join(", "), names.join(", ")))
}

/// All rules.
pub fn list() -> String {
    let rows = every_rule().map(|r| vec![r.code.into(), r.name.into(), r.severity.name().into(), r.summary.into()]);
    let columns = vec![
        Column::name("code"),
        Column::name("name"),
        Column::name("severity").dropped(1),
        Column::prose("asks that"),
    ];
    let table = Table::new(columns).also_in("`--json`").rows(rows);
    let more = "`gearwise rule CODE` says more; `gearwise rule --measures` lists what rules of your own can measure.";
    format!("{}\n{}", table.text(), paragraph(more, 0, 0))
}

/// All measures.
pub fn measure_list() -> String {
    let rows = measures().iter().map(|m| vec![m.name.clone(), m.unit.into(), m.meaning.clone()]);
    let columns = vec![Column::name("measure"), Column::name("unit"), Column::prose("what it is")];
    Table::new(columns).rows(rows).text()
}

/// One rule.
pub fn text(rule: &Rule) -> String {
    let mut out = format!("{} {} ({})\n{}", rule.code, rule.name, rule.severity.name(), paragraph(rule.summary, 0, 0));
    for (what, text) in
        [("What it does", rule.what), ("Why", rule.why), ("Example", rule.example), ("How to fix it", rule.fix)]
    {
        out.push_str(&format!("\n{what}\n{}", paragraph(text, 2, 2)));
    }
    if let Some(bounds) = bounds(rule) {
        out.push_str(&format!("\nBounds\n{}", paragraph(&bounds, 2, 2)));
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
