//! Designs that keep their limits over all tolerances, and how likely the first choice stays ahead.

use serde_json::{Value, json};

use super::optimize::{bind_text, proof, reason_text};
use super::table::{table, wrap};
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
    let mut out = format!("{}: designs that keep all limits over the tolerances of the motors\n", robot.name);
    for joint in joints {
        out.push('\n');
        out.push_str(&joint_text(joint, top));
    }
    out
}

fn joint_text(result: &RobustJoint, top: usize) -> String {
    let JointResult { joint, candidates, .. } = &result.nominal;
    let with = result.designs.iter().filter(|d| !d.toleranced.is_empty()).count();
    let mut out = format!(
        "{} (×{}), least {}: {} motors can do it by their printed numbers{}; of those with tolerances {with} also at worst, {} not\n",
        joint.name,
        joint.count,
        joint.objective.name(),
        candidates.len(),
        super::unjudged::counted(result.nominal.unjudged.len()),
        result.lost.len()
    );
    let unit = match joint.objective.unit() {
        "1" => String::new(),
        unit => format!(" [{unit}]"),
    };
    let objective = format!(">{}{unit}", joint.objective.name());
    let header = [">#", "motor", ">N* nominal", ">N robust", &objective, ">at worst", "proof"];
    let shown = &result.designs[..top.min(result.designs.len())];
    let rows: Vec<Vec<String>> = shown
        .iter()
        .enumerate()
        .map(|(place, d)| {
            let mut row = vec![(place + 1).to_string(), d.nominal.motor.id.clone()];
            row.extend([d.nominal.optimum.ratio, d.optimum.ratio, d.optimum.objective, d.worst_objective].map(number));
            row.push(proof(&d.optimum.certificate));
            row
        })
        .collect();
    if !rows.is_empty() {
        let mut lines = table(&header, &rows).lines().map(|l| format!("  {l}\n")).collect::<Vec<_>>().into_iter();
        out.push('\n');
        out.push_str(&lines.next().unwrap_or_default());
        for (design, line) in shown.iter().zip(lines) {
            out.push_str(&line);
            out.push_str(&format!("     {}\n", wrap(&details(design, result), 7)));
        }
        let hidden = result.designs.len() - shown.len();
        if hidden > 0 {
            out.push_str(&format!("  … and {hidden} more; `--top {}` shows all\n", result.designs.len()));
        }
    }
    for lost in &result.lost {
        let sentence = format!(
            "lost to its tolerances: {} (N* = {} by its printed numbers): {}",
            lost.nominal.motor.id,
            number(lost.nominal.optimum.ratio),
            reason_text(&lost.reason, joint).1
        );
        out.push_str(&format!("  {}\n", wrap(&sentence, 4)));
    }
    out.push_str(&super::unjudged::text(&result.nominal, false).replace(" (`--rejected` lists each)", ""));
    if !result.contenders.is_empty() {
        out.push_str(&format!(
            "\n  {}\n",
            wrap(
                &format!(
                    "The first {} of the nominal order with their numbers drawn at random, {SAMPLES} times (each ± is \
                     two standard deviations; what has no ± stays):",
                    result.contenders.len()
                ),
                4
            )
        ));
        let rows: Vec<Vec<String>> = result
            .contenders
            .iter()
            .map(|c| {
                vec![
                    c.motor.id.clone(),
                    percent(c.feasible_nominal),
                    percent(c.first_nominal),
                    c.feasible_robust.map_or_else(|| "–".into(), percent),
                    percent(c.first_robust),
                ]
            })
            .collect();
        let header = ["motor", ">keeps limits at N*", ">is first", ">keeps limits at N robust", ">is first then"];
        for line in table(&header, &rows).lines() {
            out.push_str(&format!("  {line}\n"));
        }
    }
    out
}

fn details(design: &RobustDesign, result: &RobustJoint) -> String {
    let joint = result.nominal.joint;
    let mut out = tolerances_text(&design.toleranced);
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
