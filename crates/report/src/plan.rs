//! The next run, for people and as set-points to play.
//!
//! The one idea: the table says of each pair how far apart it is now and after the run; the lines below say which limits were
//! kept, where they come from, and which of them bounds the run.

use std::path::Path;

use super::identify::unit_on;
use super::number;
use super::table::{Column, Table, paragraph};
use gearwise_identify::identify::plan::{
    APART, Driven, Limit, NoPlan, Pair, Plan, Quantity, Separation, SetPoint, Source, Unplanned,
};
use gearwise_identify::{Bench, BenchKind};
use gearwise_model::words::handy::handy;

/// A value with three significant digits.
pub(crate) fn round(value: f64) -> String {
    number(format!("{value:.2e}").parse().unwrap_or(value))
}

/// A value in a handy unit of this bench.
fn with_unit(bench: &Bench, value: f64, unit: &'static str) -> String {
    let (value, unit) = handy(value, unit_on(bench, unit));
    format!("{} {unit}", round(value))
}

/// A pair in words.
pub fn pair(pair: &Pair) -> String {
    format!("`{}` or `{}`", pair.effect.name(), pair.rival.name())
}

/// Why a pair has no part in a plan.
pub fn unplanned(why: Unplanned) -> String {
    match why {
        Unplanned::Simulated => "its equation is simulated from duty and position: no run is planned for it".into(),
        Unplanned::AboveTheBand => "its order lies above the band: no run is planned for it".into(),
        Unplanned::MoreTurns => {
            "the two orders, of the motor and of the output, are nearly one: only more turns separate them".into()
        }
        Unplanned::Implausible => "no plausible values of both: no run is planned for it".into(),
        Unplanned::OtherBench(kind) => format!("a bench of kind `{}` does not show it", kind.name()),
        Unplanned::Kind(kind) => format!("for a bench of kind `{}` no run is planned", kind.name()),
    }
}

/// Where a limit comes from.
pub fn source(limit: &Limit) -> String {
    match limit.source {
        Source::Declared(column) => format!("`{column}`"),
        Source::Asked => "as asked".into(),
        Source::Assumed => "assumed: the largest speed in 0.5 s".into(),
        Source::Reached => "as far as the logs went; no rating is declared".into(),
    }
}

/// What becomes of a pair.
fn outcome(s: &Separation, duration: f64) -> String {
    match s.until {
        Some(0.0) => "already".into(),
        Some(time) if time <= duration => format!("{} s", round(time)),
        Some(time) => format!("{} s: play it {} times", round(time), (time / duration).ceil()),
        None => "not within these limits".into(),
    }
}

fn table(separations: &[Separation], duration: f64) -> String {
    let columns = vec![
        Column::name("not separated"),
        Column::number("δ now", ""),
        Column::number("δ after", ""),
        Column::name("δ ≥ 6 after"),
    ];
    let row = |s: &Separation| vec![pair(&s.pair).replace('`', ""), round(s.now), round(s.after), outcome(s, duration)];
    Table::new(columns).indented(2).rows(separations.iter().map(row)).text()
}

fn limits(bench: &Bench, limits: &[Limit]) -> String {
    let row = |l: &Limit| {
        let bounds = if l.bounds() { "bounds the run" } else { "" };
        let unit = l.of.unit();
        vec![
            name(l.of).to_string(),
            with_unit(bench, l.used, unit),
            with_unit(bench, l.most, unit),
            source(l).replace('`', ""),
            bounds.to_string(),
        ]
    };
    let columns = vec![
        Column::name("limit"),
        Column::name("used"),
        Column::name("allowed"),
        Column::name("from"),
        Column::name(""),
    ];
    Table::new(columns).indented(2).rows(limits.iter().map(row)).text()
}

fn name(of: Quantity) -> &'static str {
    match of {
        Quantity::Speed => "speed of the motor",
        Quantity::Acceleration => "acceleration of the motor",
        Quantity::Torque => "torque of the motor",
        Quantity::Angle => "travel of the output",
        Quantity::Heat => "heat (rms current)",
        Quantity::Voltage => "voltage",
    }
}

fn left_alone(list: &[(Pair, Unplanned)]) -> String {
    list.iter().map(|(p, why)| paragraph(&format!("{}: {}", pair(p), unplanned(*why)), 2, 4)).collect()
}

/// What is said of a plan, or of why there is none; `path` is where its set-points are.
pub fn text(bench: &Bench, planned: &Result<Plan, NoPlan>, path: &Path) -> String {
    let mut out = String::from("The next run:\n");
    let mut say = |line: &str| out.push_str(&paragraph(line, 2, 4));
    match planned {
        Ok(plan) => {
            say(&format!(
                "{} s of set-points for {} are in {}",
                round(plan.duration),
                told(plan.driven, plan.kind),
                path.display()
            ));
            out.push_str(&table(&plan.separations, plan.duration));
            out.push_str(&limits(bench, &plan.limits));
            let mut say = |line: &str| out.push_str(&paragraph(line, 2, 4));
            say(
                "δ is the distance between what the two predict, in standard deviations of what is left on this bench; from 6 on \
                 they are separated",
            );
            if plan.is_at_one_temperature {
                say("the temperature is taken as it usually was in the logs");
            }
            out.push_str(&left_alone(&plan.unplanned));
        }
        Err(NoPlan::NothingOpen) => say("no run is planned: nothing is confounded"),
        Err(NoPlan::TeachesNothing) => {
            say("no run is planned: the logs teach nothing that a run could be planned with")
        }
        Err(NoPlan::TooShort(shortest)) => say(&format!("no run is planned: it takes {} s at least", round(*shortest))),
        Err(NoPlan::Unplanned(list)) => {
            say("no run is planned:");
            out.push_str(&left_alone(list));
        }
        Err(NoPlan::NothingSeparates { separations, limits: kept, unplanned }) => {
            if separations.is_empty() {
                say(
                    "no run is planned: a limit is neither declared nor reached by the logs, or nothing moves within them",
                );
            } else {
                say("no run is planned: none within the limits separates these");
                out.push_str(&table(separations, f64::INFINITY));
            }
            out.push_str(&limits(bench, kept));
            out.push_str(&left_alone(unplanned));
        }
    }
    out
}

/// What is driven by set-points.
fn told(driven: Driven, kind: BenchKind) -> &'static str {
    match (driven, kind) {
        (Driven::Current, _) => "the current, the output held",
        (Driven::Both, _) => "the driving machine (speed) and the current",
        (Driven::Motion, BenchKind::Free | BenchKind::Linear) => "the drive (position or speed)",
        (Driven::Motion, BenchKind::Servo) => "the drive (position)",
        (Driven::Motion, _) => "the driving machine (speed)",
    }
}

/// Whether a plan was made or was not needed.
pub fn is_satisfied(planned: &Result<Plan, NoPlan>) -> bool {
    matches!(planned, Ok(_) | Err(NoPlan::NothingOpen))
}

/// The set-points, one row for each: SI, the unit in the header.
pub fn csv(bench: &Bench, plan: &Plan) -> String {
    let (ratio, constant) =
        (bench.declared.ratio, bench.declared.motor.as_ref().map_or(bench.declared.force_gain, |m| m.torque_constant));
    let on = |unit| unit_on(bench, unit);
    let motion = plan.driven != Driven::Current;
    let expected = |name: &str, told: bool| if told { name.to_string() } else { format!("expected_{name}") };
    let commanded = plan.driven != Driven::Motion;
    let has_current = plan.points.iter().any(|p| p.current != 0.0);
    let mut header = vec!["time [s]".to_string()];
    if motion {
        header.push(format!("output_position [{}]", on("rad")));
        header.push(format!("output_velocity [{}]", on("rad/s")));
    }
    if has_current {
        header.push(format!("{} [A]", expected("current", commanded)));
        header.push(format!("{} [{}]", expected("motor_torque", commanded), on("N*m")));
    }
    header.push(format!("expected_output_torque [{}]", on("N*m")));
    let cell = |value: f64| super::csv_number(Some(format!("{value:.6e}").parse().unwrap_or(value)));
    let row = |p: &SetPoint| {
        let mut row = vec![cell(p.time)];
        if motion {
            row.extend([cell(p.angle / ratio), cell(p.speed / ratio)]);
        }
        if has_current {
            row.extend([cell(p.current), cell(constant * p.current)]);
        }
        row.push(cell(p.torque));
        row
    };
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    super::csv_text(&header, plan.points.iter().map(row).collect::<Vec<_>>())
}

/// δ from which two models are separated.
pub const WANTED: f64 = APART;
