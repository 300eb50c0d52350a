use super::{MADE, table};
use crate::rules::measure::{measure, measures};
use crate::rules::{Test, every_rule};

/// The page of design rules.
pub fn text() -> String {
    let mut out = format!(
        "{MADE}# Design rules\n\nWhat `gearwise check` asks of a design file, and (GW4…) `gearwise check-model` of robot models. Severities and bounds can be moved, rules of your own added \
         and findings allowed with a reason in a rules file; `gearwise rule CODE` prints one of these.\n\n"
    );
    let rows = every_rule().map(|r| {
        vec![
            format!("[{}](#{})", r.code, r.code.to_lowercase()),
            r.name.into(),
            r.severity.name().into(),
            r.summary.into(),
        ]
    });
    out.push_str(&table(&["code", "name", "severity", "asks that"], rows));
    for rule in every_rule() {
        out.push_str(&format!(
            "\n## {}\n\n**{}** ({}): {}\n\n{}\n",
            rule.code,
            rule.name,
            rule.severity.name(),
            rule.summary,
            rule.what
        ));
        if let Test::Bounds { measures: names, min, max } = &rule.test {
            let show = |value: f64| measure(names[0]).map_or_else(|| value.to_string(), |m| m.show(value));
            let ends = [min.map(|v| format!("min = {}", show(v))), max.map(|v| format!("max = {}", show(v)))];
            let ends: Vec<String> = ends.into_iter().flatten().collect();
            out.push_str(&format!("\nBounds: {} on `{}`.\n", ends.join(", "), names.join("`, `")));
        }
        out.push_str(&format!("\n*Why.* {}\n\n*Example.* {}\n\n*To fix it.* {}\n", rule.why, rule.example, rule.fix));
    }
    out.push_str("\n# Measures\n\nWhat rules of your own can bound, per joint.\n\n");
    let rows = measures().iter().map(|m| vec![format!("`{}`", m.name), m.unit.into(), m.meaning.clone()]);
    out.push_str(&table(&["measure", "unit", "what it is"], rows));
    out
}
