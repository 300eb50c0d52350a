//! What the logs say of the declared model: the story as a table.
//!
//! The one idea: the table reads from top to bottom as the error goes down, from the model as declared to
//! the model that the logs support, and ends in a sentence.

mod findings;
pub mod robot;
mod sentence;
mod story;

pub(super) use findings::{lines as finding_lines, words as finding_words};
pub use sentence::{is_learnt, sentence, short};
pub use story::story as six_lines;

use super::number;
use super::table::{Column, Table, paragraph, paragraph_at, width};
use gearwise_identify::identify::FAR;
use gearwise_identify::identify::evidence::{Asked, Gain};
use gearwise_identify::identify::{Found, Ground, Parameter, Refused, Report, Stage, Step, Target, Verdict};
use gearwise_identify::{Bench, Channel, Log, Use};
use gearwise_model::effects::Enters;
use gearwise_model::words::handy::{handy, with_error};

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
    Verdict::over(reports.iter().map(|r| r.verdict))
}

/// Refusals over all equations: of each effect the reason of the equation that it is a term of; nothing that
/// was found in any.
pub(super) fn refused(reports: &[Report]) -> Vec<(&Refused, Target)> {
    let Some((first, further)) = reports.split_first() else { return Vec::new() };
    let found = |name: &str| reports.iter().flat_map(|r| &r.effects).any(|e| e.name() == name);
    first
        .refused
        .iter()
        .filter(|r| !found(&r.name))
        .map(|r| {
            let own = (r, first.target);
            if r.ground != Ground::Elsewhere {
                return own;
            }
            let better = further.iter().find_map(|f| {
                f.refused.iter().find(|o| o.name == r.name && o.ground != Ground::Elsewhere).map(|o| (o, f))
            });
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

/// A list in words.
fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

/// What the end of the story does not have any more is marked.
fn stage_label(stage: &Stage) -> String {
    match stage.step {
        Step::Declared => "as declared".into(),
        Step::Artefacts => "artefacts taken out".into(),
        Step::Refit => "declared parameters refitted".into(),
        Step::Final => "final".into(),
        Step::Added(..) | Step::Lag if stage.taken_back => format!("+ {} (taken back)", stage.step.name()),
        Step::Added(..) | Step::Lag => format!("+ {}", stage.step.name()),
    }
}

/// For people. `written` names the files that were written.
pub fn text(bench: &Bench, reports: &[Report], written: &[String]) -> String {
    let mut out = heading(bench);
    let found = finding_lines(bench, reports);
    if !found.is_empty() {
        out.push_str("\nFound in the logs before anything was asked:\n");
        found.iter().for_each(|line| out.push_str(&paragraph(line, 2, 4)));
    }
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
    let what = match &bench.declared.motor {
        Some(motor) if bench.declared.ratio == 1.0 => format!("{}, direct drive", motor.id),
        Some(motor) => format!("{} at N = {}", motor.id, number(bench.declared.ratio)),
        None => format!("linear axis of {} kg", bench.declared.mass.map_or_else(|| "–".into(), number)),
    };
    heading_of_logs(&format!("{}: {what}", bench.name), &bench.logs)
}

/// What was tested, with its logs.
fn heading_of_logs(what: &str, all: &[Log]) -> String {
    let count = |usage: Use| all.iter().filter(|l| l.usage == usage).count();
    let heading = format!("{what}; {} to fit, {} held out", logs(count(Use::Fit)), logs(count(Use::HeldOut)));
    let mut out = paragraph(&heading, 0, 2);
    let row = |log: &Log| vec![log.name.clone(), log.kind.name().into(), used(log).into(), log.len().to_string()];
    let columns =
        vec![Column::name("log"), Column::name("kind"), Column::name("use"), Column::number("rows", "").dropped(1)];
    out.push_str(&Table::new(columns).indented(2).rows(all.iter().map(row)).text());
    for log in all {
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
        Channel::LoadTorque => "torque of the load",
    }
}

/// Channels of a log that have one value throughout.
pub(super) fn stuck(log: &Log) -> Vec<&'static str> {
    log.stuck().into_iter().map(channel_name).collect()
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
    for line in noise_lines(report) {
        out.push_str(&paragraph(&line, 2, 4));
    }
    for remark in &report.remarks {
        out.push_str(&paragraph(remark, 2, 4));
    }
    if !report.artefacts.is_empty() {
        out.push_str("\n  Artefacts of the measurement:\n");
        for artefact in &report.artefacts {
            let (value, unit) = handy(artefact.value, unit_on(bench, artefact.unit));
            let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
            let line = format!("{} of {}: {}{unit}", artefact.kind.name(), artefact.channel, number(value));
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
        let line = format!("Left unexplained, depends on {}: {}", left.depends_on.name(), left.detail);
        out.push_str(&format!("\n{}", paragraph(&line, 2, 4)));
    }
    out
}

fn story(report: &Report) -> String {
    let (columns, rows) = story_rows(report);
    Table::new(columns).indented(2).also_in("`--json`").rows(rows).text()
}

/// The instrument's noise, or why it is not known, in one line.
pub(super) fn noise_line(report: &Report) -> String {
    match report.evidence.noise.told() {
        Ok(floor) => format!("noise of the instrument {} {}", number(floor), report.unit),
        Err(why) => format!("the instrument's noise is not known: {why}"),
    }
}

/// What is left against the instrument's noise, what each way to find that says, and the strongest effect that was
/// refused.
pub(super) fn noise_lines(report: &Report) -> Vec<String> {
    let (evidence, unit) = (&report.evidence, report.unit);
    let left = format!(
        "{} {unit}{}",
        number(evidence.left),
        if evidence.far_off.is_some() { " of all rows alike" } else { "" }
    );
    let mut lines = vec![match evidence.times_the_noise() {
        Some(times) => format!("{}; left out {left}, {} times that", noise_line(report), number(round(times))),
        None => format!("left out {left}; {}", noise_line(report)),
    }];
    lines.extend(evidence.far_off.map(|share| {
        format!(
            "{} % of the rows for fitting are more than {FAR} times as far off as is usual, whatever the function of speed and \
             current; they weigh less, in the errors above too",
            percent(share)
        )
    }));
    let ways: Vec<String> = evidence
        .noise
        .estimates
        .iter()
        .map(|e| match e.value {
            Ok(value) => format!("{} {} {unit}", e.method.words(), number(value)),
            Err(why) => format!("{}: {why}", e.method.words()),
        })
        .collect();
    if !ways.is_empty() {
        lines.push(format!("noise by {}", ways.join("; ")));
    }
    if let Some(frequency) = evidence.noise.line {
        lines.push(format!("there is a line at {} Hz, above the band", number(round(frequency))));
    }
    lines.extend(
        evidence.strongest().map(|asked| format!("strongest of what was refused: {}", strength(report, asked))),
    );
    if let Some(together) = evidence.together.filter(|_| evidence.asked.len() > 1) {
        lines.push(format!(
            "all {} effects that were asked and refused, together: error {} %, at most −{} % (95 %)",
            evidence.asked.len(),
            change(together),
            percent(together.most())
        ));
    }
    lines
}

/// A refused effect with what it would do, and how sure that is.
fn strength(report: &Report, asked: &Asked) -> String {
    let gain = asked.gain;
    let found = report.effects.iter().any(|f| f.name() == asked.name);
    format!(
        "{}{}, error {} % ({} standard errors), at most −{} % (95 %)",
        if found { "another order of " } else { "" },
        asked.name,
        change(gain),
        number(round(gain.sure())),
        percent(gain.most())
    )
}

/// Change of the error \[%\], with its sign.
fn change(gain: Gain) -> String {
    let fall = percent(gain.fall().abs());
    if fall == "0" { fall } else { format!("{}{fall}", if gain.fall() > 0.0 { "−" } else { "+" }) }
}

/// To two digits behind the point.
fn round(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}

/// Columns and rows of the error as it goes down; against the noise where that is known.
pub(super) fn story_rows(report: &Report) -> (Vec<Column>, Vec<Vec<String>>) {
    let floor = report.evidence.noise.floor();
    let ratio = |value: f64| floor.map(|floor| number(value / floor));
    let held = |value: Option<f64>, f: &dyn Fn(f64) -> String| value.map_or_else(|| "–".into(), f);
    let vaf = |value: f64| Stage::vaf(value).map_or_else(|| "–".into(), |value| format!("{value:.2}"));
    let rows: Vec<Vec<String>> = report
        .stages
        .iter()
        .map(|stage| {
            let mut row = vec![
                stage_label(stage),
                number(stage.fit),
                held(stage.held_out, &number),
                vaf(stage.fit_vaf),
                held(stage.held_out_vaf, &vaf),
            ];
            row.extend(ratio(stage.fit));
            if floor.is_some() {
                row.push(held(stage.held_out, &|v| ratio(v).unwrap_or_default()));
            }
            row
        })
        .collect();
    let unit = report.unit;
    let mut columns = vec![
        Column::name("RMSE"),
        Column::number("fit", unit),
        Column::number("held out", unit),
        Column::number("VAF fit", "%").dropped(4),
        Column::number("held out", "%").dropped(3),
    ];
    if floor.is_some() {
        columns.extend([Column::number("x noise", "").dropped(1), Column::number("held out\nx noise", "").dropped(2)]);
    }
    (columns, rows)
}

/// The columns of [`parameter_rows`].
pub(super) fn parameter_columns() -> Vec<Column> {
    vec![
        Column::name("parameter"),
        Column::number("declared", ""),
        Column::number("fitted", ""),
        Column::number("± 95 %", ""),
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
                p.standard_error.map_or_else(|| "not identifiable, held".into(), |_| number(p.fitted * factor)),
                p.tolerance().map_or_else(String::new, |e| format!("± {}", number(e * factor))),
                unit.into(),
                if p.standard_error.is_some() { change } else { String::new() },
            ]
        })
        .collect()
}

/// An effect that was found, as text of a width.
pub(super) fn effect_text(bench: &Bench, report: &Report, effect: &Found, width: usize) -> String {
    let say = |line: &str| paragraph_at(line, 4, 4, width);
    let heading =
        format!("{}: {}; {} {} rms", effect.name(), effect.effect.equation(), number(effect.size), report.unit);
    let mut out = format!("\n{}", paragraph_at(&heading, 2, 4, width));
    let values: Vec<String> = effect
        .parameters
        .iter()
        .map(|p| format!("{} = {}", p.name, with_error(p.fitted, p.tolerance(), unit_on(bench, p.unit))))
        .collect();
    out.push_str(&say(&values.join(", ")));
    if let (Some(before), Some(after)) = (effect.held_out_before, effect.held_out_after) {
        let [before, after] = [before, after].map(number);
        out.push_str(&say(&format!("held-out error {before} {} without it, {after} with it", report.unit)));
    }
    if !effect.confounded_with.is_empty() {
        let names: Vec<String> = effect.confounded_with.iter().map(|e| e.name().to_string()).collect();
        let line = format!("these logs cannot separate it from {}", listed(&names));
        out.push_str(&say(&line));
    }
    let enters = match effect.effect.kind_of_entry() {
        enters @ Enters::NotAtAll(why) => format!("in the model it {}: {why}", enters.words()),
        other => format!("in the model it {}", other.words()),
    };
    out.push_str(&say(&enters));
    out
}

/// One row for each stage, artefact, parameter, effect, refusal and dependence that is left, and the verdicts; the last one is
/// that over all equations.
pub fn csv(bench: &Bench, reports: &[Report]) -> String {
    super::csv_text(&CSV, csv_rows(bench, reports))
}

/// The columns of [`csv`].
const CSV: [&str; 13] = [
    "equation",
    "part",
    "name",
    "declared",
    "value",
    "plus_minus_95",
    "standard_error",
    "fit_rmse",
    "held_out_rmse",
    "fit_vaf_percent",
    "held_out_vaf_percent",
    "unit",
    "detail",
];

fn csv_rows(bench: &Bench, reports: &[Report]) -> Vec<Vec<String>> {
    let number = super::csv_number;
    let mut rows: Vec<Vec<String>> = Vec::new();
    for report in reports {
        let row = |part: &str, name: &str, numbers: [Option<f64>; 8], unit: &str, detail: &str| -> Vec<String> {
            let mut row = vec![report.target.name().to_string(), part.into(), name.into()];
            row.extend(numbers.map(number));
            row.extend([unit.to_string(), detail.to_string()]);
            row
        };
        let none = [None; 8];
        for f in &report.findings {
            rows.push(row(
                "finding",
                &format!("{} of {}", f.about.name(), f.log),
                none,
                "",
                &findings::words(bench, &f.about),
            ));
        }
        for s in &report.stages {
            let errors = [None, None, None, None, Some(s.fit), s.held_out, Some(s.fit_vaf), s.held_out_vaf];
            rows.push(row("stage", &s.step.name(), errors, report.unit, ""));
        }
        for a in &report.artefacts {
            let numbers = [None, Some(a.value), None, None, None, None, None, None];
            rows.push(row(
                "artefact",
                &format!("{} of {}", a.kind.name(), a.channel),
                numbers,
                unit_on(bench, a.unit),
                "",
            ));
        }
        for e in &report.evidence.noise.estimates {
            let numbers = [None, e.value.ok(), None, None, None, None, None, None];
            rows.push(row("noise", e.method.name(), numbers, report.unit, e.value.err().unwrap_or("")));
        }
        let values =
            |p: &Parameter| [p.declared, Some(p.fitted), p.tolerance(), p.standard_error, None, None, None, None];
        for p in &report.parameters {
            rows.push(row("parameter", &p.name, values(p), unit_on(bench, p.unit), ""));
        }
        for e in &report.effects {
            for p in &e.parameters {
                let name = format!("{}.{}", e.name(), p.name);
                rows.push(row(
                    "effect",
                    &name,
                    values(p),
                    unit_on(bench, p.unit),
                    &e.confounded_with.iter().map(|e| e.name()).collect::<Vec<_>>().join(" "),
                ));
            }
        }
        for r in &report.refused {
            rows.push(row("refused", &r.name, none, "", &r.reason));
        }
        for u in &report.unexplained {
            rows.push(row("unexplained", u.depends_on.name(), none, "", &u.detail));
        }
        rows.push(row("verdict", report.verdict.word(), none, "", ""));
    }
    let mut over_all = vec![String::new(); 13];
    over_all[..3].clone_from_slice(&["all".into(), "verdict".into(), overall(reports).word().into()]);
    over_all[12] = sentence(bench, reports);
    rows.push(over_all);
    rows
}
