//! The fitted actuator as a file: what the logs say of the machine, to be read in place of a catalogue row.
//!
//! The one idea: the file stands alone. It is the declared row on the q axis with every fitted number in its
//! place and ± (two standard errors), the effects that were found, the covariance of all fitted numbers, and
//! which logs they come from.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::identify::unit_on;
use crate::actuator::effects::{EFFECTS, Effect, Shape};
use crate::catalog::convention::{Commutation, Winding, word};
use crate::catalog::{FIELDS, Motor};
use crate::measured::Bench;
use crate::measured::characterize::row::REDUNDANT;
use crate::measured::identify::{Parameter, Report};

/// A fitted number and its standard error, SI.
#[derive(Debug, Clone, Copy)]
struct Number {
    value: f64,
    error: Option<f64>,
}

/// Everything that was fitted, by its name in the reports.
struct Fit<'a> {
    bench: &'a Bench,
    numbers: BTreeMap<String, Number>,
    reports: &'a [Report],
}

impl<'a> Fit<'a> {
    fn new(bench: &'a Bench, reports: &'a [Report]) -> Fit<'a> {
        let mut numbers = BTreeMap::new();
        // The first equation that sees a number says it.
        let mut add = |name: String, p: &Parameter| {
            if p.standard_error.is_some_and(f64::is_finite) && p.fitted.is_finite() {
                numbers.entry(name).or_insert(Number { value: p.fitted, error: p.standard_error });
            }
        };
        for report in reports {
            report.parameters.iter().for_each(|p| add(p.name.clone(), p));
            for effect in &report.effects {
                effect.parameters.iter().for_each(|p| add(format!("{}.{}", effect.name, p.name), p));
            }
        }
        Fit { bench, numbers, reports }
    }

    fn get(&self, name: &str) -> Option<Number> {
        self.numbers.get(name).copied()
    }
}

/// Nine digits: more than any log says, few enough to read.
fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.8e}").parse().unwrap_or(value);
    let size = rounded.abs();
    if size == 0.0 || (1e-3..1e7).contains(&size) { rounded.to_string() } else { format!("{rounded:e}") }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}

fn line(out: &mut String, name: &str, value: f64, unit: &str) {
    // Writing to a string does not fail.
    let _ = match unit {
        "1" => writeln!(out, "{name} = {}", digits(value)),
        "K" => writeln!(out, "{name} = \"{} degC\"", digits(value - 273.15)),
        _ => writeln!(out, "{name} = \"{} {unit}\"", digits(value)),
    };
}

fn with_tolerance(out: &mut String, name: &str, number: Number, unit: &str) {
    line(out, name, number.value, unit);
    if let Some(error) = number.error.filter(|e| *e > 0.0) {
        line(out, &format!("{name}_tolerance"), 2.0 * error, unit);
    }
}

/// The file's text.
pub fn text(bench: &Bench, reports: &[Report]) -> String {
    let fit = Fit::new(bench, reports);
    let mut out =
        String::from("# Fitted actuator, on the q axis. Tolerances are two standard errors; covariance in SI.\n");
    let _ = writeln!(out, "# Verdict: {}", super::identify::overall(reports).word());
    for report in reports {
        out.push_str(&error_comment(report));
    }
    let _ = writeln!(out, "gearwise = {}", quoted(env!("CARGO_PKG_VERSION")));
    match &bench.declared.motor {
        Some(motor) => out.push_str(&motor_table(&fit, motor)),
        None => out.push_str(&axis_table(&fit)),
    }
    out.push_str(&gear_table(&fit));
    out.push_str(&effect_tables(&fit));
    out.push_str(&covariance(&fit));
    for log in &bench.logs {
        let usage = match log.usage {
            crate::measured::Use::Fit => "fit",
            crate::measured::Use::HeldOut => "held_out",
        };
        let _ = writeln!(
            out,
            "\n[[provenance]]\nlog = {}\nsha256 = {}\nuse = {}",
            quoted(&log.name),
            quoted(&log.hash),
            quoted(usage)
        );
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

/// Friction in the columns of the row: fitted, declared, or found as an effect.
fn friction(fit: &Fit, name: &str, parameter: &str) -> Option<Number> {
    let declared = || fit.bench.declared.effects.iter().find(|(effect, _)| effect == name)?.1.first().copied();
    fit.get(&format!("{name}.{parameter}")).or_else(|| declared().map(|value| Number { value, error: None }))
}

fn motor_table(fit: &Fit, motor: &Motor) -> String {
    let mut out = String::from("\n[motor]\n");
    let mut say = |name: &str, value: &str| {
        if !value.is_empty() {
            let _ = writeln!(out, "{name} = {}", quoted(value));
        }
    };
    say("id", &format!("{}-fitted", motor.id));
    say("manufacturer", &motor.manufacturer);
    say("model", &motor.model);
    say("commutation", word(Commutation::NAMES, &motor.conventions.commutation));
    if let Some(winding) = motor.conventions.winding {
        say("winding", word(Winding::NAMES, &winding));
    }
    say("terminals", "q_axis");
    // A brushed motor's ampere is the q axis' already.
    let brushed = motor.conventions.commutation == Commutation::Brushed;
    say("current", if brushed { "dc" } else { "q_axis" });
    say("audit_accept", &motor.accepted_findings.join(";"));
    if let (Some(poles), Commutation::Brushless) = (motor.pole_pairs, motor.conventions.commutation) {
        let _ = writeln!(out, "pole_pairs = {poles}");
    }
    let mut notes = Vec::new();
    for field in FIELDS.iter().filter(|f| !REDUNDANT.contains(&f.name)) {
        let Some(number) = column(fit, motor, field.name, &mut notes) else { continue };
        with_tolerance(&mut out, field.name, number, field.kind.si);
        if field.name == "back_emf_constant" {
            let _ = writeln!(out, "back_emf_convention = \"q_axis\"");
        }
    }
    let logs = fit.bench.logs.len();
    let source = format!(
        "identified from {logs} {} of the bench `{}` ({}); what they do not show: {}",
        if logs == 1 { "log" } else { "logs" },
        fit.bench.name,
        fit.bench.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
        motor.source
    );
    notes.push(format!("fitted row of `{}`", motor.id));
    if fit.bench.declared.ratio != 1.0 {
        notes.push(format!(
            "measured behind a gear of {}: friction and inertia at the motor contain the gear's input side",
            super::number(fit.bench.declared.ratio)
        ));
    }
    let _ =
        writeln!(out, "source = {}\nsource_kind = \"measured\"\nnote = {}", quoted(&source), quoted(&notes.join("; ")));
    out
}

/// A column of the row on the q axis: fitted where the logs show it, else as declared with its own ±.
fn column(fit: &Fit, motor: &Motor, name: &str, notes: &mut Vec<String>) -> Option<Number> {
    let field = FIELDS.iter().find(|f| f.name == name)?;
    let printed = (field.get)(&motor.sheet);
    // A tolerance is twice a standard error.
    let declared = |value: Option<f64>, of: Option<crate::catalog::Printed>| {
        let error = of.and_then(|p| p.relative_tolerance()).zip(value).map(|(t, v)| 0.5 * t * v.abs());
        value.map(|value| Number { value, error })
    };
    match name {
        "resistance" => fit.get("resistance").or_else(|| declared(Some(motor.resistance), printed)),
        "inductance" => fit.get("inductance").or_else(|| declared(motor.inductance, printed)),
        "torque_constant" => fit.get("torque_constant").or_else(|| {
            // Where the sheet has only a back-EMF, the reader takes them equal again.
            printed.and_then(|p| declared(Some(motor.torque_constant), Some(p)))
        }),
        "back_emf_constant" => fit.get("back_emf_constant").or_else(|| {
            let of = printed.or(motor.sheet.speed_constant)?;
            declared(Some(motor.back_emf_constant), Some(of))
        }),
        "rotor_inertia" => {
            let gear = fit.bench.declared.gear.inertia;
            match fit.get("inertia") {
                Some(n) if n.value > gear => {
                    if gear > 0.0 {
                        notes.push("the gear's inertia is taken as declared".into());
                    }
                    Some(Number { value: n.value - gear, ..n })
                }
                _ => declared(motor.rotor_inertia, printed),
            }
        }
        "coulomb_friction" => {
            friction(fit, "coulomb_friction", "torque").or_else(|| declared(motor.coulomb_friction, printed))
        }
        "viscous_friction" => friction(fit, "viscous_friction", "coefficient")
            .or_else(|| {
                let damping = fit.get("damping")?;
                let back_emf = motor.torque_constant * motor.back_emf_constant / motor.resistance;
                (damping.value > back_emf).then(|| {
                    notes.push("viscous friction is the damping that was seen less K_T K_B/R as declared".into());
                    Number { value: damping.value - back_emf, ..damping }
                })
            })
            .or_else(|| declared(motor.viscous_friction, printed)),
        "continuous_current" => declared(motor.continuous_current, printed),
        "peak_current" => declared(motor.peak_current, printed),
        _ => declared(printed.map(|p| p.value), printed),
    }
}

/// A linear axis has no row: its mass, drive and friction.
fn axis_table(fit: &Fit) -> String {
    let declared = &fit.bench.declared;
    let mut out = format!("\n[axis]\nid = {}\n", quoted(&format!("{}-fitted", fit.bench.name)));
    let plain = |value: Option<f64>| value.map(|value| Number { value, error: None });
    for (name, number, unit) in [
        ("mass", fit.get("mass").or(plain(declared.mass)), "kg"),
        (
            "viscous_friction",
            friction(fit, "viscous_friction", "coefficient").or(plain(declared.viscous_friction)),
            "N*s/m",
        ),
        ("coulomb_friction", friction(fit, "coulomb_friction", "torque").or(plain(declared.coulomb_friction)), "N"),
    ] {
        if let Some(number) = number {
            with_tolerance(&mut out, name, number, unit);
        }
    }
    out
}

/// What load-dependent friction says of the gear: `η = 1/(1 + γ)` forwards, `1 − γ` backwards.
fn gear_table(fit: &Fit) -> String {
    let factor = fit.get("load_dependent_friction.factor").filter(|f| f.value > 0.0);
    let ratio = fit.bench.declared.ratio;
    if factor.is_none() && ratio == 1.0 {
        return String::new();
    }
    let mut out = String::from("\n[gear]\n");
    line(&mut out, "ratio", ratio, "1");
    let Some(factor) = factor else { return out };
    if let Some(error) = factor.error {
        let _ = writeln!(out, "# 1/(1 + γ) and 1 − γ of γ = {} ± {}", digits(factor.value), super::number(2.0 * error));
    }
    line(&mut out, "efficiency", 1.0 / (1.0 + factor.value), "1");
    line(&mut out, "backdrive_efficiency", 1.0 - factor.value, "1");
    out
}

/// Effects that stand in a column of the row or of the gear.
fn has_a_column(name: &str) -> bool {
    matches!(name, "viscous_friction" | "coulomb_friction" | "load_dependent_friction")
}

/// Effects that were found, and those that were declared beyond the row, with their fitted values.
fn effect_tables(fit: &Fit) -> String {
    let mut out = String::new();
    for effect in EFFECTS.iter().filter(|e| !has_a_column(e.name())) {
        let found = fit.reports.iter().flat_map(|r| &r.effects).filter(|e| e.name == effect.name());
        let mut instances: Vec<Vec<f64>> = found.flat_map(|e| e.instances.clone()).collect();
        let declared = fit.bench.declared.effects.iter().filter(|(name, _)| name == effect.name());
        instances.extend(declared.map(|(_, values)| values.clone()));
        for instance in &instances {
            out.push_str(&effect_table(fit, *effect, instance));
        }
    }
    out
}

fn effect_table(fit: &Fit, effect: &dyn Effect, instance: &[f64]) -> String {
    let orders = effect.shape() == Shape::Order;
    let header = if orders { format!("[[effects.{}]]", effect.name()) } else { format!("[effects.{}]", effect.name()) };
    let mut out = format!("\n{header}\n");
    for (parameter, value) in effect.parameters().iter().zip(instance) {
        let place = match instance.last() {
            Some(order) if orders => format!("{}.{order}.{}", effect.name(), parameter.name),
            _ => format!("{}.{}", effect.name(), parameter.name),
        };
        let number = fit.get(&place).unwrap_or(Number { value: *value, error: None });
        with_tolerance(&mut out, parameter.name, number, unit_on(fit.bench, parameter.kind.si));
    }
    out
}

/// The name of a fitted number as the file has it.
fn place(fit: &Fit, name: &str) -> String {
    let table = if fit.bench.declared.motor.is_some() { "motor" } else { "axis" };
    match name {
        "inertia" => "motor.rotor_inertia".into(),
        "load_scale" => format!("{table}.torque_constant"),
        "coulomb_friction.torque" => format!("{table}.coulomb_friction"),
        "viscous_friction.coefficient" => format!("{table}.viscous_friction"),
        _ if EFFECTS.iter().any(|e| name.starts_with(e.name())) => format!("effects.{name}"),
        _ => format!("{table}.{name}"),
    }
}

/// Derivative of a number of the file by the one that was fitted: a load that seems scaled by s is a torque
/// constant of K/s.
fn slope(fit: &Fit, name: &str) -> f64 {
    match (name, &fit.bench.declared.motor, fit.get("torque_constant")) {
        ("load_scale", Some(motor), Some(fitted)) => -fitted.value * fitted.value / motor.torque_constant,
        _ => 1.0,
    }
}

/// Covariance of all fitted numbers, one block for each equation. A number without a finite variance is left
/// out.
fn covariance(fit: &Fit) -> String {
    let all: Vec<(usize, usize)> = fit
        .reports
        .iter()
        .enumerate()
        .flat_map(|(r, report)| (0..report.fitted_names.len()).map(move |k| (r, k)))
        .filter(|(r, k)| fit.reports[*r].covariance[*k][*k].is_finite())
        .collect();
    if all.is_empty() {
        return String::new();
    }
    let names: Vec<String> = all.iter().map(|(r, k)| quoted(&place(fit, &fit.reports[*r].fitted_names[*k]))).collect();
    let mut out = format!("\n[covariance]\nnames = [{}]\nmatrix = [\n", names.join(", "));
    for (r, k) in &all {
        let cells = all.iter().map(|(other, j)| {
            let report = &fit.reports[*r];
            let scale = slope(fit, &report.fitted_names[*k]) * slope(fit, &fit.reports[*other].fitted_names[*j]);
            let value = if r == other { scale * report.covariance[*k][*j] } else { 0.0 };
            format!("{:.6e}", if value.is_finite() { value } else { 0.0 })
        });
        let _ = writeln!(out, "  [{}],", cells.collect::<Vec<_>>().join(", "));
    }
    out.push_str("]\n");
    out
}
