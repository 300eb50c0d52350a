//! The whole story of one motor at a joint.

use serde_json::{Value, json};

use super::optimize::{bind_text, fitted_json, fitted_notes, margins_json, proof, reason_text};
use super::table::{Column, Table, paragraph};
use super::{number, optional};
use crate::actuator::metrics::METRICS;
use crate::catalog::audit::{audit_motor, conventions_line};
use crate::design::evaluate::Margin;
use crate::design::explain::{Explanation, Remedy};
use crate::design::program::{Certificate, Optimum};
use crate::requirement::Joint;

pub(super) fn percent(fraction: f64) -> String {
    format!("{}{} %", if fraction > 0.0 { "+" } else { "" }, number((1e4 * fraction).round() / 100.0))
}

/// For people.
pub fn text(story: &Explanation) -> String {
    let e = &story.evaluation;
    let joint = story.joint;
    let gear = story.gear.map_or_else(String::new, |g| format!(" with {}", g.id));
    let verdict = if e.feasible { "keeps every limit that could be checked" } else { "is not feasible" };
    let heading = format!("{}: {} at N = {}{gear} {verdict}", joint.name, story.motor.id, number(e.ratio));
    let mut out = format!("{}\n", paragraph(&heading, 0, 2));
    out.push_str(&limits(story));
    out.push('\n');
    for (what, value, unit) in quantities(story) {
        out.push_str(&format!("  {what:<24}{} {unit}\n", optional(value)));
        if what == WINDING && story.winding_temperature == Some(None) {
            out.push_str(&paragraph(RUNAWAY, 2, 4));
        }
    }
    match &story.spring {
        Some(Ok(spring)) => {
            let line = format!("With a {}", super::spring::text(spring, e.loss));
            let line = if spring.rest_angle.is_some() { line } else { super::spring::text(spring, e.loss) };
            out.push_str(&format!("\n{}", paragraph(&line, 0, 0)));
            let line = "shadow prices, sensitivities and what would have to change are those at this spring";
            out.push_str(&paragraph(line, 2, 4));
        }
        Some(Err(why)) => {
            let line = format!("No spring will do: {}. All else is without a spring.", reason_text(why, joint).1);
            out.push_str(&format!("\n{}", paragraph(&line, 0, 0)));
        }
        None => {}
    }
    match &story.best {
        Some(Ok(optimum)) => out.push_str(&best(story, optimum)),
        Some(Err(reason)) => {
            let line = format!("No ratio of this motor will do: {}.", reason_text(reason, joint).1);
            out.push_str(&format!("\n{}", paragraph(&line, 0, 0)));
        }
        None => {}
    }
    if !story.remedies.is_empty() {
        let heading = if story.best.is_some() { "Any one of these would make it feasible" } else { "What is exceeded" };
        out.push_str(&format!("\n{heading}:\n"));
        for remedy in &story.remedies {
            out.push_str(&paragraph(&remedy_text(remedy), 2, 4));
        }
    } else if matches!(story.best, Some(Err(_))) {
        let line = "No single limit, widened alone, would make it feasible.";
        out.push_str(&format!("\n{}", paragraph(line, 0, 2)));
    }
    let fitted = fitted_notes(story.motor, joint);
    if !fitted.is_empty() {
        out.push_str("\nFitted to this actuator:\n");
        for note in fitted {
            out.push_str(&paragraph(&format!("{}: {}", note.effect, note.how), 2, 4));
        }
    }
    if !story.unchecked.is_empty() {
        out.push_str("\nNot checked:\n");
        for (limit, why) in &story.unchecked {
            out.push_str(&paragraph(&format!("{limit}: {why}"), 2, 4));
        }
    }
    let line = format!("The row: {}; {}", conventions_line(story.motor), story.motor.source);
    out.push_str(&format!("\n{}", paragraph(&line, 0, 2)));
    if !story.motor.note.is_empty() {
        out.push_str(&paragraph(&story.motor.note, 2, 2));
    }
    for assumption in &story.motor.assumptions {
        out.push_str(&paragraph(&format!("assumed: {assumption}"), 2, 4));
    }
    for finding in audit_motor(story.motor) {
        out.push_str(&paragraph(&format!("audit [{}]: {}", finding.code, finding.message), 2, 4));
    }
    out
}

const WINDING: &str = "winding, steady state";
/// What is said where the winding has no steady temperature.
pub(super) const RUNAWAY: &str = "thermal runaway: the copper's resistance rises faster than heat flows off";

/// What the design needs and weighs: name, value, unit.
pub(super) fn quantities(story: &Explanation) -> Vec<(&'static str, Option<f64>, &'static str)> {
    let e = &story.evaluation;
    let mut all = vec![
        ("copper loss", Some(e.loss), "W"),
        ("energy per cycle", e.energy, "J"),
        ("peak electrical power", e.peak_power, "W"),
        ("current, rms", Some(e.rms_current), "A (q axis)"),
        ("current, peak", Some(e.peak_current), "A (q axis)"),
        ("reflected inertia", Some(e.reflected_inertia), "kg*m^2"),
        ("mass", e.mass, "kg"),
        (WINDING, story.winding_temperature.flatten().map(|t| t - 273.15), "degC"),
    ];
    all.extend(METRICS.iter().take(4).map(|metric| {
        (metric.symbol, metric.value(story.motor).map(|v| crate::units::in_unit(v, metric.unit)), metric.unit)
    }));
    all
}

pub(super) fn remedy_text(remedy: &Remedy) -> String {
    format!(
        "{} of at least {} {} instead of {} ({}, {}'s), at N = {}",
        remedy.limit,
        number(remedy.needed),
        remedy.unit,
        number(remedy.bound),
        percent(remedy.needed / remedy.bound - 1.0),
        remedy.owner,
        number(remedy.ratio)
    )
}

/// The columns of [`limit_rows`].
pub(super) fn limit_columns() -> Vec<Column> {
    vec![
        Column::name("limit"),
        Column::number("demand", ""),
        Column::number("limit", ""),
        Column::name("unit"),
        Column::number("margin", ""),
        Column::name("whose").dropped(1),
        Column::name("at").dropped(2),
    ]
}

fn limits(story: &Explanation) -> String {
    let rows = limit_rows(&story.evaluation.margins, story.joint);
    Table::new(limit_columns()).also_in("`--json`").rows(rows).text()
}

/// The limits of a design, tightest first.
pub(super) fn limit_rows(margins: &[Margin], joint: &Joint) -> Vec<Vec<String>> {
    let mut margins: Vec<_> = margins.iter().collect();
    margins.sort_by(|a, b| a.margin.total_cmp(&b.margin).then(a.limit.cmp(b.limit)));
    margins
        .iter()
        .map(|m| {
            let at = m.sample.map_or_else(String::new, |k| joint.motion.name_sample(k));
            vec![
                m.limit.into(),
                number(m.demand),
                number(m.bound),
                m.unit.into(),
                percent(m.margin),
                m.owner.into(),
                at,
            ]
        })
        .collect()
}

/// The best ratio in a sentence.
pub(super) fn best_line(story: &Explanation, optimum: &Optimum) -> String {
    let joint = story.joint;
    let windows = optimum.windows.iter().map(|w| {
        format!("{} ({}) to {} ({})", number(w.min), bind_text(&w.low, joint), number(w.max), bind_text(&w.high, joint))
    });
    format!(
        "Best ratio for least {}: N* = {} with {} {} ({}); feasible from {}.",
        joint.objective.name(),
        number(optimum.ratio),
        number(optimum.objective),
        joint.objective.unit(),
        proof(&optimum.certificate),
        windows.collect::<Vec<_>>().join(" and from ")
    )
}

fn best(story: &Explanation, optimum: &Optimum) -> String {
    let joint = story.joint;
    let line = best_line(story, optimum);
    let mut out = format!("\n{}", paragraph(&line, 0, 0));
    if let Certificate::Certified { lower_bound, method, .. } = &optimum.certificate {
        let line = format!("no ratio is better than {lower_bound:.9e} {} ({method})", joint.objective.unit());
        out.push_str(&paragraph(&line, 2, 4));
    }
    if optimum.shadow_prices.is_empty() {
        out.push_str("  no limit binds at N*: every shadow price is zero\n");
    }
    for price in &optimum.shadow_prices {
        let change = percent(price.elasticity / 100.0);
        out.push_str(&paragraph(&format!("{} +1 %: {} {change}", price.limit, joint.objective.name()), 2, 4));
    }
    out.push_str("\nIf the motor were better, the ratio chosen anew:\n");
    for s in &story.sensitivities {
        let change = s.objective.map_or_else(
            || "no ratio is feasible".to_string(),
            |o| format!("{} {}", joint.objective.name(), percent(o)),
        );
        out.push_str(&paragraph(&format!("{} {}: {change}", s.parameter, percent(s.change)), 2, 4));
    }
    out
}

/// For programs.
pub fn json(story: &Explanation) -> Value {
    let e = &story.evaluation;
    let (margins, limits) = margins_json(&e.margins, story.joint);
    let best = story.best.as_ref().map(|b| match b {
        Ok(o) => json!({
            "ratio": o.ratio, "objective": o.objective, "window": [o.window().min, o.window().max],
            "binds": { "low": o.window().low.limit, "high": o.window().high.limit },
            "certificate": match &o.certificate {
                Certificate::Certified { lower_bound, gap, method } => json!({ "certified": true, "lower_bound": lower_bound, "gap": gap, "method": method }),
                Certificate::NotCertified(why) => json!({ "certified": false, "because": why }),
            },
            "shadow_prices": o.shadow_prices.iter().map(|p| json!({ "limit": p.limit, "price": p.price, "elasticity": p.elasticity })).collect::<Vec<_>>(),
        }),
        Err(reason) => json!({ "because": reason_text(reason, story.joint).1 }),
    });
    let mut value = json!({
        "joint": story.joint.name, "motor": story.motor.id, "gear": story.gear.map(|g| &g.id), "ratio": e.ratio, "feasible": e.feasible,
        "loss_w": e.loss, "energy_per_cycle_j": e.energy, "peak_electrical_power_w": e.peak_power, "peak_current_a": e.peak_current,
        "rms_current_a": e.rms_current, "reflected_inertia_kgm2": e.reflected_inertia, "mass_kg": e.mass,
        "winding_temperature_k": story.winding_temperature.flatten(), "thermal_runaway": story.winding_temperature == Some(None),
        "margins": margins, "limits": limits, "best": best,
        "sensitivities": story.sensitivities.iter().map(|s| json!({ "parameter": s.parameter, "change": s.change, "objective_change": s.objective })).collect::<Vec<_>>(),
        "remedies": story.remedies.iter().map(|r| json!({ "limit": r.limit, "bound": r.bound, "needed": r.needed, "unit": r.unit, "ratio": r.ratio, "of": r.owner })).collect::<Vec<_>>(),
        "not_checked": story.unchecked.iter().map(|(limit, why)| json!({ "limit": limit, "because": why })).collect::<Vec<_>>(),
        "spring": story.spring.as_ref().map(|s| match s {
            Ok(spring) => super::spring::json(spring, e.loss),
            Err(why) => json!({ "because": reason_text(why, story.joint).1 }),
        }),
    });
    if let (Some(list), Value::Object(object)) = (fitted_json(story.motor, story.joint), &mut value) {
        object.insert("fitted".into(), list);
    }
    value
}
