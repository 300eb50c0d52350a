//! What the model leaves, before and after, against everything that it may depend on.

use super::{Along, Axis, Dash, Figure, Group, Mark, Panel, Rule, Series, Tone, thinned};
use gearwise_identify::Bench;
use gearwise_identify::identify::{Report, Target};

/// Dots of one tone in one panel: with five panels and two tones at most 4000 in a group.
const DOTS: usize = 400;
/// Bins of the line of means.
const BINS: usize = 30;
/// Bins over a turn: several for each period of the orders that motors have.
const TURN_BINS: usize = 120;
/// Highest order of the position spectrum.
const ORDERS: usize = 100;

const BEFORE: &str = "before: as declared, artefacts taken out";
const AFTER: &str = "after: refitted, with the effects found";

/// One group of panels for each equation.
pub fn figure(bench: &Bench, reports: &[Report]) -> Figure {
    Figure { groups: reports.iter().map(|r| group(bench, r)).collect(), columns: 3, ..Figure::default() }
}

fn group(bench: &Bench, report: &Report) -> Group {
    let p = &report.pictures;
    let turns = bench.declared.motor.is_some();
    let unit = report.unit;
    let y = format!("residual [{unit}]");
    let tau = std::f64::consts::TAU;
    let angle = if turns { p.angle.iter().map(|a| a.rem_euclid(tau)).collect() } else { p.angle.clone() };
    let (time, lines) = one_after_the_other(report);
    // The current of a linear axis is its force over the declared gain.
    let (drive, gain) =
        if turns { ("current, q axis [A]", 1.0) } else { ("drive force [N]", bench.declared.force_gain) };
    let current: Vec<f64> = p.current.iter().map(|i| gain * i).collect();
    let panel = |x: &str, values: &[f64], bins: usize| Panel {
        x: x.into(),
        y: y.as_str().into(),
        series: series(report, values, bins),
        empty: "not in these logs, or constant".into(),
        ..Panel::default()
    };
    let (speed, position) = if turns {
        ("motor speed [rad/s]", "motor position in its turn [rad]")
    } else {
        ("speed [m/s]", "position [m]")
    };
    let mut in_time = panel("time, logs one after the other [s]", &time, BINS);
    let meet = |at: f64| Rule { along: Along::X, at, tone: Tone::Grey, dash: Dash::Solid, text: String::new() };
    in_time.rules = lines.into_iter().map(meet).collect();
    let panels = vec![
        panel(speed, &p.speed, BINS),
        panel(position, &angle, if turns { TURN_BINS } else { BINS }),
        panel(drive, &current, BINS),
        panel("winding over its reference [K]", &p.temperature, BINS),
        in_time,
        spectrum(report, turns),
    ];
    Group {
        title: format!("{}: what the model leaves of the {}", bench.name, quantity(report)),
        panels,
        ..Group::default()
    }
}

fn quantity(report: &Report) -> &'static str {
    match (report.target, report.unit) {
        (Target::Torque, "N") => "force",
        (Target::Torque, _) => "torque",
        (Target::Drive, "N") => "drive's force",
        (Target::Drive, _) => "drive's torque",
        (Target::Voltage, _) => "voltage",
        (Target::Position, _) => "position",
        (Target::WindUp, _) => "angle between motor and output",
    }
}

/// Times with each log after the one before it, and where logs meet.
fn one_after_the_other(report: &Report) -> (Vec<f64>, Vec<f64>) {
    let p = &report.pictures;
    let (mut start, mut last, mut lines) = (0.0, 0.0, Vec::new());
    let mut log = p.log.first().copied();
    let times = p
        .time
        .iter()
        .zip(&p.log)
        .map(|(t, l)| {
            if log != Some(*l) {
                start = last;
                log = Some(*l);
                lines.push(start);
            }
            last = start + t;
            last
        })
        .collect();
    (times, lines)
}

/// Dots before and after, and the lines of their means over bins.
fn series(report: &Report, x: &[f64], bins: usize) -> Vec<Series> {
    let p = &report.pictures;
    if x.len() != p.before.len() || x.iter().any(|v| !v.is_finite()) {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..x.len()).collect();
    order.sort_by(|a, b| x[*a].total_cmp(&x[*b]).then(a.cmp(b)));
    if order.first().zip(order.last()).is_none_or(|(a, b)| x[*a] == x[*b]) {
        return Vec::new();
    }
    let mut all = Vec::new();
    let looks = [(BEFORE, Tone::Orange, Dash::Dashed, &p.before), (AFTER, Tone::Blue, Dash::Solid, &p.after)];
    for (name, tone, _, y) in looks {
        let points = thinned(x.len(), DOTS).map(|k| (x[k], y[k])).collect();
        all.push(Series::new(tone, Mark::Dots, points).named(name));
    }
    for (name, tone, dash, y) in looks {
        all.push(Series::new(tone, Mark::Line(dash), means(&order, x, y, bins)).named(name));
    }
    all
}

/// Means over bins of equal numbers of rows.
fn means(order: &[usize], x: &[f64], y: &[f64], most: usize) -> Vec<(f64, f64)> {
    let bins = most.min(order.len() / 8).max(1);
    (0..bins)
        .map(|b| {
            let bin = &order[b * order.len() / bins..(b + 1) * order.len() / bins];
            let mean = |v: &[f64]| bin.iter().map(|k| v[*k]).sum::<f64>() / bin.len() as f64;
            (mean(x), mean(y))
        })
        .collect()
}

/// Amplitude of the residual at each order of the motor's turn, over the rows where the filter lets it pass.
fn spectrum(report: &Report, turns: bool) -> Panel {
    let p = &report.pictures;
    let mut panel = Panel {
        x: "order: periods in a turn of the motor".into(),
        y: Axis::linear(format!("amplitude of the residual [{}]", report.unit)),
        empty: "the logs do not turn far enough".into(),
        ..Panel::default()
    };
    let angles = p.angle.iter().copied();
    let (low, high) = angles.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(a), h.max(a)));
    let known = p.angle.iter().chain(&p.speed).all(|v| v.is_finite());
    if !turns || !known || high - low <= std::f64::consts::TAU {
        return panel;
    }
    let band = report.band.unwrap_or(f64::INFINITY) * std::f64::consts::TAU;
    let amplitude = |y: &[f64], order: usize| {
        let h = order as f64;
        let (mut a, mut b, mut count) = (0.0, 0.0, 0.0);
        for k in (0..y.len()).filter(|k| (h * p.speed[*k]).abs() < 0.8 * band) {
            let (sine, cosine) = (h * p.angle[k]).sin_cos();
            a += y[k] * cosine;
            b += y[k] * sine;
            count += 1.0;
        }
        if count >= 50.0 { 2.0 * f64::hypot(a, b) / count } else { f64::NAN }
    };
    panel.series = [(BEFORE, Tone::Orange, &p.before), (AFTER, Tone::Blue, &p.after)]
        .into_iter()
        .map(|(name, tone, y)| {
            let points = (1..=ORDERS).map(|h| (h as f64, amplitude(y, h))).collect();
            Series::new(tone, Mark::Bars, points).named(name)
        })
        .collect();
    panel
}
