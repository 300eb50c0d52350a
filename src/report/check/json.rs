//! A check for programs.

use serde_json::{Value, json};

use super::unit_of;
use crate::actuator::limits::Remark;
use crate::design::judge;
use crate::report::currents;
use crate::report::optimize::margins_json;
use crate::report::unjudged::list;
use crate::rules::facts::JointFacts;
use crate::rules::lock::LockState;
use crate::rules::{Finding, Location, Report, Severity};

fn location(place: &Location) -> Value {
    json!({ "file": place.file, "line": place.line, "column": place.column, "end_line": place.end_line, "end_column": place.end_column })
}

fn finding(report: &Report, finding: &Finding) -> Value {
    let rule = report.rule_of(finding);
    json!({
        "code": rule.code, "name": rule.name, "severity": finding.severity.name(), "joint": finding.joint, "subject": finding.subject,
        "message": finding.message, "help": finding.help, "reason": finding.reason,
        "value": finding.value, "bound": finding.bound, "unit": finding.value.or(finding.bound).map(|_| unit_of(&finding.subject)),
        "at": location(&finding.location), "asked_for_at": finding.asked.as_ref().map(location),
        "allowed": finding.allowed.is_some(), "allowed_because": finding.allowed,
    })
}

/// What the requirement states and cannot be judged of a joint's design.
fn unjudged(facts: &JointFacts) -> Vec<Remark> {
    let unchecked = facts.examined.as_ref().map_or(&[][..], |examined| &examined.unchecked);
    judge::unjudged(facts.robot, facts.choice.joint, unchecked)
}

/// Everything that was checked and found.
pub fn json(report: &Report, strict: bool) -> Value {
    let design = report.facts.design;
    let joints = report.facts.joints.iter().map(|facts| {
        let choice = &facts.choice;
        let mut joint = json!({
            "joint": choice.joint.name, "count": choice.joint.count, "motor": choice.motor.id, "gear": choice.gear.map(|g| &g.id), "ratio": choice.ratio,
        });
        let more = match &facts.examined {
            Ok(examined) => {
                let e = &examined.evaluation;
                let (margins, limits) = margins_json(&e.margins, choice.joint);
                let mut value = json!({
                    "feasible": e.feasible, "loss_w": e.loss, "energy_per_cycle_j": e.energy, "peak_electrical_power_w": e.peak_power,
                    "reflected_inertia_kgm2": e.reflected_inertia, "mass_kg": e.mass,
                    "winding_temperature_k": examined.winding_temperature.flatten(), "load_inertia_kgm2": examined.load_inertia,
                    "load_inertia_estimated": examined.load_inertia.map(|_| examined.load_inertia_estimated), "best_ratio": examined.best.map(|b| b.0),
                    "margins": margins, "limits": limits, "between_samples": crate::report::between::json(choice.joint),
                    "judged": unjudged(facts).is_empty(), "unjudged": list(&unjudged(facts)),
                    "assumed": crate::report::unjudged::assumed(&examined.assumed),
                    "not_checked": list(&examined.unchecked),
                });
                currents::add(&mut value, choice.motor, e);
                value
            }
            Err(why) => json!({ "feasible": false, "because": why.reason() }),
        };
        if let (Value::Object(joint), Value::Object(more)) = (&mut joint, more) {
            joint.extend(more);
        }
        joint
    });
    let judged = report.judged.iter().filter_map(|j| {
        let because = j.skipped?;
        Some(json!({ "code": report.rules[j.rule].code, "joint": j.joint, "because": because }))
    });
    let lock = match &report.facts.lock {
        LockState::Missing(_) => json!({ "state": "missing" }),
        LockState::Compared { differences, .. } => json!({
            "state": if differences.is_empty() { "same" } else { "different" }, "differences": differences.iter().map(|d| &d.message).collect::<Vec<_>>(),
        }),
    };
    json!({
        "robot": design.robot.name, "design": crate::rules::clean(design.source.name()), "requirement": crate::rules::clean(design.requirement.name()),
        "passes": report.passes(strict), "strict": strict,
        "errors": report.count(Severity::Error), "warnings": report.count(Severity::Warning), "notes": report.count(Severity::Note),
        "joints": joints.collect::<Vec<_>>(), "findings": report.findings.iter().map(|f| finding(report, f)).collect::<Vec<_>>(),
        "not_judged": judged.collect::<Vec<_>>(), "lock": lock,
    })
}
