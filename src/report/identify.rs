//! What the logs say of the declared model: the story as a table, and the same facts for programs.
//!
//! The one idea: the table reads from top to bottom as the error goes down, from the model as declared to
//! the model that the logs support, and ends in a sentence.

use serde_json::{Map, Value, json};

use super::handy::{handy, with_error};
use super::number;
use super::table::{Column, Table, paragraph, paragraph_at, width};
use crate::actuator::effects::Enters;
use crate::measured::identify::{Found, Parameter, Refused, Report, Stage, Target, Verdict};
use crate::measured::{Bench, Channel, Log, Use};

/// The unit of a parameter on this bench: effects speak of torques and angles, a linear axis of forces and
/// metres.
pub fn unit_on(bench: &Bench, unit: &'static str) -> &'static str {
    if bench.declared.motor.is_some() {
        return unit;
    }
    match unit {
        "N*m" => "N",
        "rad" => "m",
        "rad/s" => "m/s",
        "kg*m^2" => "kg",
        "N*m*s/rad" => "N*s/m",
        "N*m/A" => "N/A",
        "N*m/(A*K)" => "N/(A*K)",
        "rad/(N*m)" => "m/N",
        other => other,
    }
}

/// The verdict over all equations of a bench.
pub fn overall(reports: &[Report]) -> Verdict {
    if reports.iter().any(|r| r.verdict == Verdict::UnexplainedStructure) {
        Verdict::UnexplainedStructure
    } else if reports.iter().any(|r| !r.effects.is_empty()) {
        Verdict::Explained
    } else {
        Verdict::NothingMissing
    }
}

/// Why an effect was refused where another equation of the same bench speaks of it.
const ELSEWHERE: &str = "this bench does not measure its equation";

/// Refusals over all equations: of each effect the reason of the equation that it is a term of; nothing that
/// was found in any.
pub(super) fn refused(reports: &[Report]) -> Vec<(&Refused, Target)> {
    let Some((first, further)) = reports.split_first() else { return Vec::new() };
    let found = |name: &str| reports.iter().flat_map(|r| &r.effects).any(|e| e.name == name);
    first
        .refused
        .iter()
        .filter(|r| !found(&r.name))
        .map(|r| {
            let own = (r, first.target);
            if r.reason != ELSEWHERE {
                return own;
            }
            let better = further
                .iter()
                .find_map(|f| f.refused.iter().find(|o| o.name == r.name && o.reason != ELSEWHERE).map(|o| (o, f)));
            better.map_or(own, |(o, f)| (o, f.target))
        })
        .collect()
}

pub(super) fn equation_title(report: &Report) -> &'static str {
    match (report.target, report.unit) {
        (Target::Torque, "N") => "Force that the sensor sees",
        (Target::Torque, _) => "Torque that the sensor sees",
        (Target::Drive, "N") => "Force of the drive against the known mass",
        (Target::Drive, _) => "Torque of the drive against the known load",
        (Target::Voltage, _) => "Terminal voltage",
        (Target::Position, _) => "Position of the output, simulated",
        (Target::WindUp, _) => "Angle by which the motor leads the output",
    }
}

fn percent(part: f64) -> String {
    number((1e4 * part).round() / 100.0)
}

fn words(name: &str) -> String {
    name.replace('_', " ").replace("coulomb", "Coulomb").replace("stribeck", "Stribeck")
}

/// A list in words.
fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

/// An effect that the end of the story does not have any more is marked.
fn stage_label(report: &Report, stage: &Stage) -> String {
    let stays = || report.effects.iter().any(|e| stage.name.split(' ').next() == Some(e.name));
    match stage.name.as_str() {
        "declared" => "as declared".into(),
        "artefacts" => "artefacts taken out".into(),
        "refit" => "declared parameters refitted".into(),
        "final" => "in the end".into(),
        name if stays() => format!("+ {name}"),
        name => format!("+ {name} (taken back)"),
    }
}

/// For people. `written` names the files that were written.
pub fn text(bench: &Bench, reports: &[Report], written: &[String]) -> String {
    let mut out = heading(bench);
    for report in reports {
        out.push_str(&equation(bench, report));
    }
    let refusals = refused(reports);
    if !refusals.is_empty() {
        out.push_str("\nNot added, and why:\n");
        // One line for all effects with the same reason.
        let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
        for (refusal, _) in &refusals {
            match reasons.iter_mut().find(|(reason, _)| *reason == refusal.reason) {
                Some((_, names)) => names.push(&refusal.name),
                None => reasons.push((&refusal.reason, vec![&refusal.name])),
            }
        }
        for (reason, names) in reasons {
            out.push_str(&paragraph(&format!("{}: {reason}", names.join(", ")), 2, 4));
        }
    }
    let mut runs: Vec<&String> = Vec::new();
    for run in reports.iter().flat_map(|r| &r.next_runs) {
        if !runs.contains(&run) {
            runs.push(run);
        }
    }
    if !runs.is_empty() {
        out.push_str("\nWhat to measure next:\n");
        for run in runs {
            out.push_str(&paragraph(run, 2, 4));
        }
    }
    out.push_str(&format!("\n{}", paragraph(&sentence(bench, reports), 0, 0)));
    for file in written {
        out.push_str(&paragraph(file, 0, 2));
    }
    out
}

fn heading(bench: &Bench) -> String {
    let count = |usage: Use| bench.logs.iter().filter(|l| l.usage == usage).count();
    let what = match &bench.declared.motor {
        Some(motor) if bench.declared.ratio == 1.0 => format!("{}, direct drive", motor.id),
        Some(motor) => format!("{} at N = {}", motor.id, number(bench.declared.ratio)),
        None => format!("linear axis of {} kg", bench.declared.mass.map_or_else(|| "–".into(), number)),
    };
    let heading =
        format!("{}: {what}; {} to fit, {} held out", bench.name, logs(count(Use::Fit)), logs(count(Use::HeldOut)));
    let mut out = paragraph(&heading, 0, 2);
    let row = |log: &Log| vec![log.name.clone(), log.kind.name().into(), used(log).into(), log.len().to_string()];
    let columns =
        vec![Column::name("log"), Column::name("kind"), Column::name("use"), Column::number("rows", "").dropped(1)];
    out.push_str(&Table::new(columns).indented(2).rows(bench.logs.iter().map(row)).text());
    for log in &bench.logs {
        for remark in &log.remarks {
            out.push_str(&paragraph(&format!("{}: {remark}", log.name), 2, 4));
        }
        for channel in stuck(log) {
            out.push_str(&paragraph(&format!("{}: {channel} has one value throughout", log.name), 2, 4));
        }
    }
    out
}

/// A channel in words.
fn channel_name(channel: Channel) -> &'static str {
    match channel {
        Channel::Current => "current",
        Channel::Voltage => "voltage",
        Channel::MotorPosition => "motor position",
        Channel::MotorVelocity => "motor velocity",
        Channel::OutputPosition => "output position",
        Channel::OutputVelocity => "output velocity",
        Channel::OutputAcceleration => "output acceleration",
        Channel::Torque => "torque",
        Channel::Duty => "duty",
        Channel::Supply => "supply",
        Channel::BusCurrent => "bus current",
        Channel::Goal => "goal",
        Channel::WindingTemperature => "winding temperature",
        Channel::HousingTemperature => "housing temperature",
        Channel::Command => "command",
    }
}

fn is_constant(values: &[f64]) -> bool {
    let mut finite = values.iter().filter(|v| v.is_finite());
    let first = finite.next();
    finite.all(|v| Some(v) == first)
}

/// Channels of a log that have one value throughout. A supply may.
pub(super) fn stuck(log: &Log) -> Vec<&'static str> {
    let suspicious = |channel: Channel| !matches!(channel, Channel::Supply);
    log.channels
        .iter()
        .filter(|(channel, values)| suspicious(**channel) && is_constant(values))
        .map(|(channel, _)| channel_name(*channel))
        .collect()
}

/// The channel that an equation explains, where no log has it moving.
fn dead_target(bench: &Bench, report: &Report) -> Option<&'static str> {
    let channel = match report.target {
        Target::Torque => Channel::Torque,
        Target::Voltage => Channel::Voltage,
        Target::Drive => Channel::Current,
        Target::WindUp | Target::Position => return None,
    };
    let mut values = bench.logs.iter().filter_map(|l| l.channel(channel)).peekable();
    values.peek()?;
    values.all(is_constant).then(|| channel_name(channel))
}

fn logs(count: usize) -> String {
    format!("{count} {}", if count == 1 { "log" } else { "logs" })
}

pub(super) fn used(log: &Log) -> &'static str {
    match log.usage {
        Use::Fit => "fit",
        Use::HeldOut => "held_out",
    }
}

/// One equation from top to bottom.
fn equation(bench: &Bench, report: &Report) -> String {
    let band = report.band.map_or_else(String::new, |b| format!("; band 0 to {} Hz", number(b)));
    let heading = format!(
        "{}{band}; {} samples, {} rows in the regression",
        equation_title(report),
        report.samples.0,
        report.samples.1
    );
    let mut out = format!("\n{}", paragraph(&heading, 0, 2));
    out.push_str(&story(report));
    out.push_str(&format!("  noise floor {} {}\n", number(report.noise_floor), report.unit));
    for remark in &report.remarks {
        out.push_str(&paragraph(remark, 2, 4));
    }
    if !report.artefacts.is_empty() {
        out.push_str("\n  Artefacts of the measurement:\n");
        for artefact in &report.artefacts {
            let (value, unit) = handy(artefact.value, unit_on(bench, artefact.unit));
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            let line = format!("{} of {}: {}{unit}", artefact.kind, artefact.channel, number(value));
            out.push_str(&paragraph(&line, 4, 6));
        }
    }
    if !report.parameters.is_empty() {
        out.push('\n');
        out.push_str(&parameters(bench, &report.parameters));
    }
    for effect in &report.effects {
        out.push_str(&effect_text(bench, report, effect, width()));
    }
    for left in &report.unexplained {
        let line = format!("Left unexplained, depends on {}: {}", left.depends_on, left.detail);
        out.push_str(&format!("\n{}", paragraph(&line, 2, 4)));
    }
    out
}

fn story(report: &Report) -> String {
    let (columns, rows) = story_rows(report);
    Table::new(columns).indented(2).also_in("`--json`").rows(rows).text()
}

/// Columns and rows of the error as it goes down.
pub(super) fn story_rows(report: &Report) -> (Vec<Column>, Vec<Vec<String>>) {
    let ratio = |value: f64| if report.noise_floor > 0.0 { number(value / report.noise_floor) } else { "–".into() };
    let held = |value: Option<f64>, f: &dyn Fn(f64) -> String| value.map_or_else(|| "–".into(), f);
    // Of a target that does not vary no variance can be accounted for.
    let vaf = |value: f64| if value > -1e5 { format!("{value:.2}") } else { "–".into() };
    let rows: Vec<Vec<String>> = report
        .stages
        .iter()
        .map(|stage| {
            vec![
                stage_label(report, stage),
                number(stage.fit),
                held(stage.held_out, &number),
                vaf(stage.fit_vaf),
                held(stage.held_out_vaf, &vaf),
                ratio(stage.fit),
                held(stage.held_out, &ratio),
            ]
        })
        .collect();
    let unit = report.unit;
    let columns = vec![
        Column::name("RMSE"),
        Column::number("fit", unit),
        Column::number("held out", unit),
        Column::number("VAF fit", "%").dropped(4),
        Column::number("held out", "%").dropped(3),
        Column::number("x noise", "").dropped(1),
        Column::number("held out\nx noise", "").dropped(2),
    ];
    (columns, rows)
}

/// The columns of [`parameter_rows`].
pub(super) fn parameter_columns() -> Vec<Column> {
    vec![
        Column::name("parameter"),
        Column::number("declared", ""),
        Column::number("fitted", ""),
        Column::number("± 1 s.e.", ""),
        Column::name("unit"),
        Column::number("change", "").dropped(1),
    ]
}

fn parameters(bench: &Bench, parameters: &[Parameter]) -> String {
    let rows = parameter_rows(bench, parameters);
    Table::new(parameter_columns()).indented(2).also_in("`--json`").rows(rows).text()
}

/// Declared and fitted numbers, in units that are handy.
pub(super) fn parameter_rows(bench: &Bench, parameters: &[Parameter]) -> Vec<Vec<String>> {
    parameters
        .iter()
        .map(|p| {
            let largest = p.declared.unwrap_or(0.0).abs().max(p.fitted.abs());
            let (scaled, unit) = handy(largest, unit_on(bench, p.unit));
            let factor = if largest > 0.0 { scaled / largest } else { 1.0 };
            let change = p.declared.filter(|d| *d != 0.0).map_or_else(String::new, |d| {
                let change = p.fitted / d - 1.0;
                format!("{}{} %", if change > 0.0 { "+" } else { "" }, percent(change))
            });
            vec![
                p.name.clone(),
                p.declared.map_or_else(|| "–".into(), |d| number(d * factor)),
                p.standard_error.map_or_else(|| "not seen, held".into(), |_| number(p.fitted * factor)),
                p.standard_error.map_or_else(String::new, |e| format!("± {}", number(e * factor))),
                unit.into(),
                if p.standard_error.is_some() { change } else { String::new() },
            ]
        })
        .collect()
}

/// An effect that was found, as text of a width.
pub(super) fn effect_text(bench: &Bench, report: &Report, effect: &Found, width: usize) -> String {
    let say = |line: &str| paragraph_at(line, 4, 4, width);
    let heading = format!("{}: {}; {} {} rms", effect.name, effect.equation, number(effect.size), report.unit);
    let mut out = format!("\n{}", paragraph_at(&heading, 2, 4, width));
    let values: Vec<String> = effect
        .parameters
        .iter()
        .map(|p| format!("{} = {}", p.name, with_error(p.fitted, p.standard_error, unit_on(bench, p.unit))))
        .collect();
    out.push_str(&say(&values.join(", ")));
    if let (Some(before), Some(after)) = (effect.held_out_before, effect.held_out_after) {
        let [before, after] = [before, after].map(number);
        out.push_str(&say(&format!("held-out error {before} {} without it, {after} with it", report.unit)));
    }
    if !effect.confounded_with.is_empty() {
        let names: Vec<String> = effect.confounded_with.iter().map(|n| n.to_string()).collect();
        let line = format!("these logs cannot tell it from {}", listed(&names));
        out.push_str(&say(&line));
    }
    let enters = match effect.enters {
        Enters::NotAtAll(why) => format!("in the model it {}: {why}", effect.enters.words()),
        other => format!("in the model it {}", other.words()),
    };
    out.push_str(&say(&enters));
    out
}

/// The verdict in a sentence that anyone understands.
pub fn sentence(bench: &Bench, reports: &[Report]) -> String {
    let Some(first) = reports.first() else { return "Nothing can be learnt from these logs.".into() };
    if let Some(channel) = reports.iter().find_map(|r| dead_target(bench, r)) {
        return format!("Nothing can be learnt: the {channel} has one value throughout.");
    }
    let mut parts = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for effect in reports.iter().flat_map(|r| &r.effects) {
        let name = words(effect.name);
        let alike: Vec<String> = effect.confounded_with.iter().map(|n| words(n)).collect();
        let text = if alike.is_empty() {
            name
        } else {
            format!("{name} (or {}, which looks the same here)", alike.join(" or "))
        };
        if !names.contains(&text) {
            names.push(text);
        }
    }
    let shifted: Vec<String> = reports
        .iter()
        .flat_map(|r| &r.parameters)
        .filter_map(|p| {
            let (declared, error) = (p.declared.filter(|d| *d != 0.0)?, p.standard_error?);
            let change = p.fitted / declared - 1.0;
            ((p.fitted - declared).abs() > 3.0 * error && change.abs() > 0.02).then(|| {
                let more = if change > 0.0 { "larger" } else { "smaller" };
                format!("{} {} % {more}", words(&p.name), number((1e3 * change.abs()).round() / 10.0))
            })
        })
        .collect();
    let errors = |report: &Report| -> Option<String> {
        let (from, to) = (report.stages.first()?, report.stages.last()?);
        let (judge, a, b) = match (from.held_out, to.held_out) {
            (Some(a), Some(b)) => ("on what was held out", a, b),
            _ => ("on the logs for fitting", from.fit, to.fit),
        };
        Some(format!("{judge} the error goes from {} to {} {}", number(a), number(b), report.unit))
    };
    match overall(reports) {
        Verdict::NothingMissing if shifted.is_empty() => {
            parts.push("Nothing is missing: the declared model explains these logs down to their noise".to_string());
        }
        Verdict::NothingMissing => {
            parts.push(format!(
                "No effect is missing, but the declared numbers are off: the logs want {}",
                listed(&shifted)
            ));
        }
        Verdict::Explained => parts.push(format!("The declared model lacks {}", listed(&names))),
        Verdict::UnexplainedStructure => {
            let mut on: Vec<String> = Vec::new();
            for left in reports.iter().flat_map(|r| &r.unexplained) {
                if !on.contains(&left.depends_on) {
                    on.push(left.depends_on.clone());
                }
            }
            let lacks = if names.is_empty() {
                String::new()
            } else {
                format!("The declared model lacks {}, and ", listed(&names))
            };
            let start = if lacks.is_empty() { "Something" } else { "something" };
            parts.push(format!(
                "{lacks}{start} is left that none of the known effects explains: it depends on {}",
                listed(&on)
            ));
        }
    }
    if overall(reports) != Verdict::NothingMissing && !shifted.is_empty() {
        parts.push(format!("the logs want {}", listed(&shifted)));
    }
    let told = reports.iter().find(|r| !r.effects.is_empty()).unwrap_or(first);
    parts.extend(errors(told));
    let noise = told.stages.last().map(|s| s.held_out.unwrap_or(s.fit) / told.noise_floor).filter(|r| r.is_finite());
    if let Some(ratio) = noise {
        parts.push(format!("{} times the noise floor", number((100.0 * ratio).round() / 100.0)));
    }
    let missing = bench.logs.iter().all(|l| l.usage == Use::Fit);
    let note = if missing { " No log was held out, so parts of the same logs judged." } else { "" };
    format!("{}.{note}", parts.join("; "))
}

/// A number for JSON: `null` where it is not finite.
fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

fn maybe(value: Option<f64>) -> Value {
    value.map_or(Value::Null, finite)
}

fn stage_json(stage: &Stage) -> Value {
    json!({
        "fit": finite(stage.fit), "held_out": maybe(stage.held_out),
        "fit_vaf": finite(stage.fit_vaf), "held_out_vaf": maybe(stage.held_out_vaf),
    })
}

fn parameter_json(bench: &Bench, p: &Parameter) -> Value {
    json!({
        "name": p.name, "declared": maybe(p.declared), "fitted": finite(p.fitted),
        "standard_error": maybe(p.standard_error), "unit": unit_on(bench, p.unit),
    })
}

fn effect_json(bench: &Bench, report: &Report, effect: &Found) -> Value {
    json!({
        "name": effect.name,
        "equation": report.target.name(),
        "formula": effect.equation,
        "parameters": effect.parameters.iter().map(|p| parameter_json(bench, p)).collect::<Vec<_>>(),
        "size_rms": finite(effect.size),
        "unit": report.unit,
        "held_out_before": maybe(effect.held_out_before),
        "held_out_after": maybe(effect.held_out_after),
        "confounded_with": effect.confounded_with,
        "enters": effect.enters.words(),
    })
}

fn refusal_json(refusal: &Refused, target: Target) -> Value {
    json!({ "name": refusal.name, "reason": refusal.reason, "equation": target.name() })
}

fn unexplained_json(report: &Report) -> Vec<Value> {
    report
        .unexplained
        .iter()
        .map(|u| json!({ "depends_on": u.depends_on, "detail": u.detail, "equation": report.target.name() }))
        .collect()
}

/// What one equation says, with its own effects and refusals.
fn report_json(bench: &Bench, report: &Report) -> Map<String, Value> {
    let mut errors = Map::new();
    let mut steps = Vec::new();
    for stage in &report.stages {
        match stage.name.as_str() {
            "declared" | "artefacts" | "refit" | "final" => {
                errors.insert(stage.name.clone(), stage_json(stage));
            }
            _ => {
                let mut step = stage_json(stage);
                step["name"] = json!(stage.name);
                steps.push(step);
            }
        }
    }
    errors.insert("steps".into(), Value::Array(steps));
    let artefacts: Vec<Value> = report
        .artefacts
        .iter()
        .map(|a| json!({ "kind": a.kind, "channel": a.channel, "value": finite(a.value), "unit": unit_on(bench, a.unit) }))
        .collect();
    let value = json!({
        "target": report.target.name(),
        "unit": report.unit,
        "noise_floor": finite(report.noise_floor),
        "verdict": report.verdict.word(),
        "band_hz": maybe(report.band),
        "samples": report.samples.0,
        "rows": report.samples.1,
        "errors": errors,
        "artefacts": artefacts,
        "parameters": report.parameters.iter().map(|p| parameter_json(bench, p)).collect::<Vec<_>>(),
        "effects": report.effects.iter().map(|e| effect_json(bench, report, e)).collect::<Vec<_>>(),
        "refused": report.refused.iter().map(|r| refusal_json(r, report.target)).collect::<Vec<_>>(),
        "unexplained": unexplained_json(report),
        "next_runs": report.next_runs,
        "remarks": report.remarks,
        "covariance": {
            "names": report.fitted_names,
            "matrix": report.covariance.iter().map(|r| r.iter().map(|v| finite(*v)).collect::<Vec<_>>()).collect::<Vec<_>>(),
        },
    });
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// For programs: the first equation at the top, with the effects, refusals and unexplained structure of all;
/// the others under `further`.
pub fn json(bench: &Bench, reports: &[Report]) -> Value {
    let Some((first, further)) = reports.split_first() else { return json!({}) };
    let mut top = report_json(bench, first);
    top.insert("verdict".into(), json!(overall(reports).word()));
    let effects: Vec<Value> =
        reports.iter().flat_map(|r| r.effects.iter().map(move |e| effect_json(bench, r, e))).collect();
    top.insert("effects".into(), Value::Array(effects));
    let refusals: Vec<Value> = refused(reports).into_iter().map(|(r, t)| refusal_json(r, t)).collect();
    top.insert("refused".into(), Value::Array(refusals));
    top.insert("unexplained".into(), Value::Array(reports.iter().flat_map(unexplained_json).collect()));
    top.insert("sentence".into(), json!(sentence(bench, reports)));
    top.insert("bench".into(), json!(bench.name));
    let logs: Vec<Value> = bench
        .logs
        .iter()
        .map(|l| {
            json!({
                "name": l.name, "kind": l.kind.name(), "use": used(l), "rows": l.len(), "sha256": l.hash, "remarks": l.remarks, "stuck_channels": stuck(l),
            })
        })
        .collect();
    top.insert("logs".into(), Value::Array(logs));
    let others: Vec<Value> = further.iter().map(|r| Value::Object(report_json(bench, r))).collect();
    top.insert("further".into(), Value::Array(others));
    Value::Object(top)
}

/// One row for each stage, artefact, parameter, effect, refusal and dependence that is left.
pub fn csv(bench: &Bench, reports: &[Report]) -> String {
    let number = super::csv_number;
    let mut rows: Vec<Vec<String>> = Vec::new();
    for report in reports {
        let row = |part: &str, name: &str, numbers: [Option<f64>; 7], unit: &str, detail: &str| -> Vec<String> {
            let mut row = vec![report.target.name().to_string(), part.into(), name.into()];
            row.extend(numbers.map(number));
            row.extend([unit.to_string(), detail.to_string()]);
            row
        };
        let none = [None; 7];
        for s in &report.stages {
            let errors = [None, None, None, Some(s.fit), s.held_out, Some(s.fit_vaf), s.held_out_vaf];
            rows.push(row("stage", &s.name, errors, report.unit, ""));
        }
        for a in &report.artefacts {
            let numbers = [None, Some(a.value), None, None, None, None, None];
            rows.push(row("artefact", &format!("{} of {}", a.kind, a.channel), numbers, unit_on(bench, a.unit), ""));
        }
        let values = |p: &Parameter| [p.declared, Some(p.fitted), p.standard_error, None, None, None, None];
        for p in &report.parameters {
            rows.push(row("parameter", &p.name, values(p), unit_on(bench, p.unit), ""));
        }
        for e in &report.effects {
            for p in &e.parameters {
                let name = format!("{}.{}", e.name, p.name);
                rows.push(row("effect", &name, values(p), unit_on(bench, p.unit), &e.confounded_with.join(" ")));
            }
        }
        for r in &report.refused {
            rows.push(row("refused", &r.name, none, "", &r.reason));
        }
        for u in &report.unexplained {
            rows.push(row("unexplained", &u.depends_on, none, "", &u.detail));
        }
    }
    super::csv_text(
        &[
            "equation",
            "part",
            "name",
            "declared",
            "value",
            "standard_error",
            "fit_rmse",
            "held_out_rmse",
            "fit_vaf_percent",
            "held_out_vaf_percent",
            "unit",
            "detail",
        ],
        rows,
    )
}
