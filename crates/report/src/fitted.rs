//! The fitted actuator as a file: what the logs say of the machine, to be read in place of a catalogue row.
//!
//! The one idea: the file is the actuator that was made ([`fitted_actuator`](gearwise_identify::fitted::fitted_actuator)), number
//! by number, and nothing is worked out here. Reading it gives that actuator back.

use std::fmt::Write;

use gearwise_identify::identify::Report;
use gearwise_model::catalog::fitted::{Axis, Fit, Fitted, gear_text, on_axis};
use gearwise_model::catalog::row::{MotorRow, number_line, quoted, say, toml_text};
use gearwise_model::catalog::{Motor, Printed};
use gearwise_model::effects::{FittedEffect, Named, Shape};
use gearwise_model::input::Stated;
use gearwise_model::units::{self, Kind};

/// The file's text. The reports give the comments at its top.
pub fn text(actuator: &Fitted, reports: &[Report]) -> String {
    let mut out = String::from(
        "# Fitted actuator, on the q axis. Tolerances are ± 95 % (1.96 standard errors); covariance in SI.\n",
    );
    let _ = writeln!(out, "# Verdict: {}", super::identify::overall(reports).word());
    for report in reports {
        out.push_str(&error_comment(report));
    }
    let (fit, effects) = match actuator {
        Fitted::Motor(motor) => (motor.fit.clone().unwrap_or_default(), &motor.effects),
        Fitted::Axis(axis) => (axis.fit.clone(), &axis.effects),
    };
    let _ = writeln!(out, "gearwise = {}", quoted(&fit.version));
    if !fit.entry.is_empty() {
        let _ = writeln!(out, "entry = {}", quoted(&fit.entry));
    }
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

fn with_tolerance(out: &mut String, name: &str, number: Printed, kind: &Kind) {
    number_line(out, name, Some(&format!("{name}_tolerance")), number, kind, Stated::default());
}

fn motor_table(motor: &Motor) -> String {
    format!("\n[motor]\n{}", toml_text(&MotorRow::of(motor)))
}

fn axis_table(axis: &Axis) -> String {
    let mut out = String::from("\n[axis]\n");
    say(&mut out, "id", &axis.id);
    for (name, number, kind) in [
        ("mass", axis.mass, &units::MASS),
        ("viscous_friction", axis.viscous_friction, &units::LINEAR_VISCOUS_FRICTION),
        ("coulomb_friction", axis.coulomb_friction, &units::FORCE),
    ] {
        if let Some(number) = number {
            with_tolerance(&mut out, name, number, kind);
        }
    }
    say(&mut out, "note", &axis.note);
    out
}

fn gear_table(motor: &Motor) -> String {
    let (Some(gear), Some(fit)) = (&motor.fitted_gear, &motor.fit) else { return String::new() };
    format!("\n[gear]\n{}", gear_text(gear, fit))
}

fn effect_table(fitted: &FittedEffect, of_axis: bool, fit: &Fit) -> String {
    let effect = fitted.effect;
    let header = match effect.shape() {
        Shape::Order => format!("[[effects.{}]]", effect.name()),
        _ => format!("[effects.{}]", effect.name()),
    };
    let mut out = format!("\n{header}\n");
    for (parameter, value) in effect.parameters().iter().zip(&fitted.values) {
        let name = Named::new(effect, fitted.values.last().copied(), parameter.name).to_string();
        let tolerance = fit.tolerance(&name);
        let kind = if of_axis { on_axis(parameter.kind) } else { parameter.kind };
        with_tolerance(&mut out, parameter.name, Printed { value: *value, tolerance }, kind);
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
