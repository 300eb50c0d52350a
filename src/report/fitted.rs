//! The fitted actuator as a file: what the logs say of the machine, to be read in place of a catalogue row.
//!
//! The one idea: the file is the actuator that was made ([`fitted_actuator`](crate::measured::fitted::fitted_actuator)), number
//! by number, and nothing is worked out here. Reading it gives that actuator back.

use std::fmt::Write;

use crate::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Terminals, Winding, word};
use crate::catalog::fitted::{Axis, Fit, Fitted, on_axis, parameter_name, settled_difference};
use crate::catalog::{FIELDS, Motor, Printed, SourceKind};
use crate::effects::FittedEffect;
use crate::effects::Shape;
use crate::measured::identify::Report;

/// The file's text. The reports give the comments at its top.
pub fn text(actuator: &Fitted, reports: &[Report]) -> String {
    let mut out =
        String::from("# Fitted actuator, on the q axis. Tolerances are two standard errors; covariance in SI.\n");
    let _ = writeln!(out, "# Verdict: {}", super::identify::overall(reports).word());
    for report in reports {
        out.push_str(&error_comment(report));
    }
    let (fit, effects) = match actuator {
        Fitted::Motor(motor) => (motor.fit.clone().unwrap_or_default(), &motor.effects),
        Fitted::Axis(axis) => (axis.fit.clone(), &axis.effects),
    };
    let _ = writeln!(out, "gearwise = {}", quoted(&fit.version));
    match actuator {
        Fitted::Motor(motor) => {
            out.push_str(&motor_table(motor));
            out.push_str(&gear_table(motor));
        }
        Fitted::Axis(axis) => out.push_str(&axis_table(axis)),
    }
    for effect in effects {
        out.push_str(&effect_table(effect, matches!(actuator, Fitted::Axis(_)), &fit));
    }
    out.push_str(&covariance(&fit));
    for log in &fit.provenance {
        let _ = writeln!(out, "\n[[provenance]]\nlog = {}", quoted(&log.log));
        for (key, text) in [("sha256", &log.sha256), ("use", &log.usage)] {
            if let Some(text) = text {
                let _ = writeln!(out, "{key} = {}", quoted(text));
            }
        }
    }
    out
}

/// What the fit made of the error.
fn error_comment(report: &Report) -> String {
    let (Some(from), Some(to)) = (report.stages.first(), report.stages.last()) else { return String::new() };
    let (judge, before, after) = match (from.held_out, to.held_out) {
        (Some(before), Some(after)) => ("held out", before, after),
        _ => ("fit", from.fit, to.fit),
    };
    format!(
        "# Error of {}, {judge}: {} {unit} as declared, {} {unit} fitted; {}\n",
        report.target.name(),
        super::number(before),
        super::number(after),
        super::identify::noise_line(report),
        unit = report.unit
    )
}

/// A number as it is, in the form that is shorter to read.
fn digits(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e7).contains(&size) { value.to_string() } else { format!("{value:e}") }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

/// Writing to a string does not fail.
fn line(out: &mut String, name: &str, value: f64, unit: &str) {
    let _ = match unit {
        "1" => writeln!(out, "{name} = {}", digits(value)),
        _ => writeln!(out, "{name} = \"{} {unit}\"", digits(value)),
    };
}

fn with_tolerance(out: &mut String, name: &str, number: Printed, unit: &str) {
    match unit {
        "K" => line(out, name, settled_difference(number.value - 273.15), "degC"),
        _ => line(out, name, number.value, unit),
    }
    if let Some(tolerance) = number.tolerance {
        line(out, &format!("{name}_tolerance"), tolerance, unit);
    }
}

fn say(out: &mut String, name: &str, value: &str) {
    if !value.is_empty() {
        let _ = writeln!(out, "{name} = {}", quoted(value));
    }
}

fn motor_table(motor: &Motor) -> String {
    let mut out = String::from("\n[motor]\n");
    let conventions = &motor.conventions;
    say(&mut out, "id", &motor.id);
    say(&mut out, "manufacturer", &motor.manufacturer);
    say(&mut out, "model", &motor.model);
    say(&mut out, "commutation", word(Commutation::NAMES, &conventions.commutation));
    say(&mut out, "winding", conventions.winding.map_or("", |w| word(Winding::NAMES, &w)));
    say(&mut out, "terminals", word(Terminals::NAMES, &conventions.terminals));
    say(&mut out, "current", word(CurrentConvention::NAMES, &conventions.current));
    say(&mut out, "audit_accept", &motor.accepted_findings.join(";"));
    if let (Some(poles), Commutation::Brushless) = (motor.pole_pairs, conventions.commutation) {
        let _ = writeln!(out, "pole_pairs = {poles}");
    }
    for field in FIELDS {
        let Some(number) = (field.get)(&motor.sheet) else { continue };
        with_tolerance(&mut out, field.name, number, field.kind.si);
        if let ("back_emf_constant", Some(convention)) = (field.name, conventions.back_emf) {
            say(&mut out, "back_emf_convention", word(BackEmfConvention::NAMES, &convention));
        }
    }
    say(&mut out, "source", &motor.source);
    say(&mut out, "source_kind", word(SourceKind::NAMES, &motor.source_kind));
    say(&mut out, "note", &motor.note);
    out
}

fn axis_table(axis: &Axis) -> String {
    let mut out = String::from("\n[axis]\n");
    say(&mut out, "id", &axis.id);
    for (name, number, unit) in [
        ("mass", axis.mass, "kg"),
        ("viscous_friction", axis.viscous_friction, "N*s/m"),
        ("coulomb_friction", axis.coulomb_friction, "N"),
    ] {
        if let Some(number) = number {
            with_tolerance(&mut out, name, number, unit);
        }
    }
    say(&mut out, "note", &axis.note);
    out
}

fn gear_table(motor: &Motor) -> String {
    let Some(gear) = motor.fitted_gear else { return String::new() };
    let mut out = String::from("\n[gear]\n");
    for (name, value, unit) in [
        ("ratio", gear.ratio, "1"),
        ("efficiency", gear.efficiency, "1"),
        ("backdrive_efficiency", gear.backdrive_efficiency, "1"),
        ("inertia", gear.inertia, "kg*m^2"),
    ] {
        if let Some(value) = value {
            line(&mut out, name, value, unit);
        }
    }
    out
}

fn effect_table(fitted: &FittedEffect, of_axis: bool, fit: &Fit) -> String {
    let effect = fitted.effect;
    let header = match effect.shape() {
        Shape::Order => format!("[[effects.{}]]", effect.name()),
        _ => format!("[effects.{}]", effect.name()),
    };
    let mut out = format!("\n{header}\n");
    for (parameter, value) in effect.parameters().iter().zip(&fitted.values) {
        let name = parameter_name(effect, &fitted.values, parameter.name);
        let tolerance = fit.tolerances.iter().find(|(of, _)| *of == name).map(|(_, tolerance)| *tolerance);
        let kind = if of_axis { on_axis(parameter.kind) } else { parameter.kind };
        with_tolerance(&mut out, parameter.name, Printed { value: *value, tolerance }, kind.si);
    }
    out
}

fn covariance(fit: &Fit) -> String {
    if fit.names.is_empty() {
        return String::new();
    }
    let names: Vec<String> = fit.names.iter().map(|name| quoted(name)).collect();
    let mut out = format!("\n[covariance]\nnames = [{}]\nmatrix = [\n", names.join(", "));
    for row in &fit.covariance {
        let cells: Vec<String> = row.iter().map(|v| if *v == 0.0 { "0.0".into() } else { format!("{v:e}") }).collect();
        let _ = writeln!(out, "  [{}],", cells.join(", "));
    }
    out.push_str("]\n");
    out
}
