//! Designs that keep their limits over all tolerances, and how likely the first choice stays ahead.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use super::optimize::{bind_text, proof, reason_text};
use super::table::{Column, Table, paragraph};
use super::{csv_number, number};
use crate::design::optimize::JointResult;
use crate::design::program::Certificate;
use crate::design::robust::{RobustDesign, RobustJoint, SAMPLES, Toleranced, standard_error};
use crate::requirement::Robot;

/// What stands beside a motor whose row has no tolerance.
const NOMINAL: &str = "no tolerances in the catalogue: nominal";

fn percent(share: f64) -> String {
    match share {
        0.0 => "0 %".into(),
        1.0 => "100 %".into(),
        _ => format!("{:.1} % ± {:.1}", 100.0 * share, 100.0 * standard_error(share)),
    }
}

fn tolerances_text(all: &[Toleranced]) -> String {
    if all.is_empty() {
        return NOMINAL.into();
    }
    let one = |t: &Toleranced| match t.value {
        0.0 => format!("{} ± {}", t.column, number(t.tolerance)),
        value => format!("{} ± {:.1} %", t.column, 100.0 * t.tolerance / value),
    };
    all.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// For people.
pub fn text(robot: &Robot, joints: &[RobustJoint], top: usize) -> String {
    let heading = format!("{}: designs that keep all limits over the tolerances of the motors", robot.name);
    let mut out = paragraph(&heading, 0, 2);
    for joint in joints {
        out.push('\n');
        out.push_str(&joint_text(joint, top));
    }
    out
}

fn joint_text(result: &RobustJoint, top: usize) -> String {
    let JointResult { joint, candidates, .. } = &result.nominal;
    let with = result.designs.iter().filter(|d| !d.toleranced.is_empty()).count();
    let heading = format!(
        "{} (×{}), least {}: {} motors can do it by their printed numbers{}; of those with tolerances {with} also at worst, {} not",
        joint.name,
        joint.count,
        joint.objective.name(),
        candidates.len(),
        super::unjudged::counted(result.nominal.unjudged.len()),
        result.lost.len()
    );
    let mut out = paragraph(&heading, 0, 2);
    let columns = vec![
        Column::number("#", ""),
        Column::name("motor"),
        Column::number("N*\nnominal", ""),
        Column::number("N\nrobust", ""),
        Column::number(joint.objective.name().replace(" + ", "\n+ "), joint.objective.unit()),
        Column::number("at worst", joint.objective.unit()),
        Column::name("proof").dropped(1),
    ];
    let mut table = Table::new(columns).indented(2).also_in("`--csv`, `--json`");
    for (place, d) in result.designs.iter().take(top).enumerate() {
        let mut row = vec![(place + 1).to_string(), d.nominal.motor.id.clone()];
        row.extend([d.nominal.optimum.ratio, d.optimum.ratio, d.optimum.objective].map(number));
        row.push(if d.toleranced.is_empty() { "–".into() } else { number(d.worst_objective) });
        row.push(proof(&d.optimum.certificate));
        table.push(row, vec![details(d, result)]);
    }
    if !table.is_empty() {
        out.push_str(&format!("\n{}", table.text()));
        for (note, places) in notes(result, top) {
            out.push_str(&paragraph(&format!("{}: {note}", places.join(" ")), 2, 4));
        }
        let hidden = result.designs.len().saturating_sub(top);
        if hidden > 0 {
            let line = format!("… and {hidden} more; `--top {}` shows all", result.designs.len());
            out.push_str(&paragraph(&line, 2, 4));
        }
    }
    for lost in &result.lost {
        let sentence = format!(
            "lost to its tolerances: {} (N* = {} by its printed numbers): {}",
            lost.nominal.motor.id,
            number(lost.nominal.optimum.ratio),
            reason_text(&lost.reason, joint).1
        );
        out.push_str(&paragraph(&sentence, 2, 4));
    }
    out.push_str(&super::unjudged::reasons(&result.nominal, ""));
    if !result.contenders.is_empty() {
        let heading = format!(
            "The first {} of the nominal order with their numbers drawn at random, {SAMPLES} times (each ± is two \
             standard deviations; what has no ± stays):",
            result.contenders.len()
        );
        out.push_str(&format!("\n{}", paragraph(&heading, 2, 4)));
        out.push_str(&contenders(result));
    }
    out
}

/// What could not be checked and what was assumed of the first designs, each with the places that it is true of.
fn notes(result: &RobustJoint, top: usize) -> BTreeMap<String, Vec<String>> {
    let mut notes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (place, design) in result.designs.iter().take(top).enumerate() {
        for note in super::unjudged::sentences(&design.unchecked, &design.assumed) {
            notes.entry(note).or_default().push(format!("#{}", place + 1));
        }
    }
    notes
}

/// How likely each of the first keeps its limits and is first.
fn contenders(result: &RobustJoint) -> String {
    let columns = vec![
        Column::name("motor"),
        Column::number("keeps limits\nat N*", ""),
        Column::number("is first", ""),
        Column::number("keeps limits\nat N robust", ""),
        Column::number("is first\nthen", ""),
    ];
    let rows = result.contenders.iter().map(|c| {
        vec![
            c.motor.id.clone(),
            percent(c.feasible_nominal),
            percent(c.first_nominal),
            c.feasible_robust.map_or_else(|| "–".into(), percent),
            percent(c.first_robust),
        ]
    });
    Table::new(columns).indented(2).rows(rows).text()
}

fn details(design: &RobustDesign, result: &RobustJoint) -> String {
    let joint = result.nominal.joint;
    let mut out = tolerances_text(&design.toleranced);
    match design.unchecked.len() {
        0 => {}
        1 => out.push_str("; 1 thing not checked"),
        n => out.push_str(&format!("; {n} things not checked")),
    }
    if design.toleranced.is_empty() {
        return out;
    }
    match design.gear {
        Some(gear) => out.push_str(&format!("; with {gear}")),
        None => {
            let windows = design.optimum.windows.iter().map(|w| {
                let (low, high) = (bind_text(&w.low, joint), bind_text(&w.high, joint));
                format!("{} ({low}) to {} ({high})", number(w.min), number(w.max))
            });
            out.push_str(&format!("; feasible at worst from {}", windows.collect::<Vec<_>>().join(" and from ")));
        }
    }
    if let Some(m) = &design.tightest {
        out.push_str(&format!("; tightest margin at worst {} {:.0} %", m.limit, (100.0 * m.margin).max(0.0)));
    }
    if let Certificate::NotCertified(why) = &design.optimum.certificate {
        out.push_str(&format!("; not certified: {why}"));
    }
    out
}

/// For programs.
pub fn json(robot: &Robot, joints: &[RobustJoint]) -> Value {
    let joints: Vec<Value> = joints
        .iter()
        .map(|j| {
            let joint = j.nominal.joint;
            let design = |d: &RobustDesign| {
                let window = d.optimum.window();
                let certificate = match &d.optimum.certificate {
                    Certificate::Certified { lower_bound, gap, method } => {
                        json!({ "certified": true, "lower_bound": lower_bound, "gap": gap, "method": method })
                    }
                    Certificate::NotCertified(why) => {
                        json!({ "certified": false, "lower_bound": null, "gap": null, "because": why })
                    }
                };
                json!({
                    "motor": d.nominal.motor.id,
                    "gear": d.gear,
                    "tolerances": d.toleranced.iter().map(|t| json!({
                        "column": t.column, "value": t.value, "tolerance": t.tolerance,
                    })).collect::<Vec<_>>(),
                    "nominal_only": d.toleranced.is_empty(),
                    "corners": d.corners,
                    "ratio": d.optimum.ratio,
                    "window": [window.min, window.max],
                    "binds": { "low": window.low.limit, "high": window.high.limit },
                    "objective": d.optimum.objective,
                    "worst_objective": d.worst_objective,
                    "not_checked": super::unjudged::list(&d.unchecked),
                    "assumed": super::unjudged::assumed(&d.assumed),
                    "objective_unit": joint.objective.unit(),
                    "loss_w": d.evaluation.loss,
                    "tightest_margin": d.tightest.map(|m| json!({ "limit": m.limit, "margin": m.margin })),
                    "nominal_gear": d.nominal.gear,
                    "nominal_ratio": d.nominal.optimum.ratio,
                    "nominal_objective": d.nominal.optimum.objective,
                    "certificate": certificate,
                })
            };
            let lost = j.lost.iter().map(|l| {
                json!({
                    "motor": l.nominal.motor.id,
                    "nominal_ratio": l.nominal.optimum.ratio,
                    "because": reason_text(&l.reason, joint).1,
                })
            });
            let contenders = j.contenders.iter().map(|c| {
                let share = |p: f64| json!({ "share": p, "standard_error": standard_error(p) });
                json!({
                    "motor": c.motor.id,
                    "feasible_at_nominal_ratio": share(c.feasible_nominal),
                    "first_at_nominal_ratios": share(c.first_nominal),
                    "feasible_at_robust_ratio": c.feasible_robust.map(share),
                    "first_at_robust_ratios": share(c.first_robust),
                })
            });
            json!({
                "joint": joint.name,
                "count": joint.count,
                "objective": joint.objective.name(),
                "designs": j.designs.iter().map(design).collect::<Vec<_>>(),
                "unjudged": super::unjudged::json(&j.nominal.unjudged, joint),
                "lost": lost.collect::<Vec<_>>(),
                "samples": SAMPLES,
                "contenders": contenders.collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({ "robot": { "name": robot.name }, "joints": joints })
}

/// As rows: every motor that can do it by its printed numbers.
pub fn csv(joints: &[RobustJoint]) -> String {
    let header = [
        "joint",
        "rank",
        "motor",
        "gear",
        "nominal_only",
        "nominal_ratio",
        "ratio",
        "ratio_min",
        "ratio_max",
        "bound_low",
        "bound_high",
        "nominal_objective",
        "objective",
        "worst_objective",
        "gap",
        "lost_because",
    ];
    let rows = joints.iter().flat_map(|j| {
        let name = &j.nominal.joint.name;
        let designs = j.designs.iter().enumerate().map(|(place, d)| {
            let window = d.optimum.window();
            let mut row = vec![name.clone(), (place + 1).to_string(), d.nominal.motor.id.clone()];
            row.extend([d.gear.unwrap_or("").to_string(), d.toleranced.is_empty().to_string()]);
            let ratios = [d.nominal.optimum.ratio, d.optimum.ratio, window.min, window.max];
            row.extend(ratios.map(|x| csv_number(Some(x))));
            row.extend([window.low.limit.to_string(), window.high.limit.to_string()]);
            let objectives = [d.nominal.optimum.objective, d.optimum.objective, d.worst_objective];
            row.extend(objectives.map(|x| csv_number(Some(x))));
            row.push(match d.optimum.certificate {
                Certificate::Certified { gap, .. } => csv_number(Some(gap)),
                Certificate::NotCertified(_) => String::new(),
            });
            row.push(String::new());
            row
        });
        let lost = j.lost.iter().map(|l| {
            let mut row = vec![String::new(); header.len()];
            (row[0], row[2], row[4]) = (name.clone(), l.nominal.motor.id.clone(), "false".into());
            row[5] = csv_number(Some(l.nominal.optimum.ratio));
            row[11] = csv_number(Some(l.nominal.optimum.objective));
            row[header.len() - 1] = reason_text(&l.reason, j.nominal.joint).1;
            row
        });
        designs.chain(lost).collect::<Vec<_>>()
    });
    super::csv_text(&header, rows)
}
