//! A study as a whole: how often each motor wins, and what each parameter does.

use std::collections::BTreeMap;

use super::number;
use super::plot::{Figure, Group, Mark, Panel, Series, Tone};
use super::table::{table, wrap};
use crate::study::effects::Effect;
use crate::study::summary::{JointSummary, Summary};

/// Motors of a joint that the text lists.
const LISTED: usize = 5;
/// Effects that the text lists.
const EFFECTS: usize = 60;
/// Motors that the picture has bars for.
const BARS: usize = 20;

/// For people.
pub fn text(summary: &Summary) -> String {
    let mut out =
        format!("{}, {} could not be worked on, {} rows\n", robots(summary.robots), summary.broken, summary.rows);
    for joint in &summary.joints {
        out.push_str(&joint_text(joint, summary.top));
    }
    out.push_str(&effects_text(&summary.effects));
    out
}

fn robots(count: u64) -> String {
    if count == 1 { "1 robot".into() } else { format!("{count} robots") }
}

fn joint_text(joint: &JointSummary, top: Option<u32>) -> String {
    let mut out = format!("\n{}: {}", joint.joint, robots(joint.robots));
    if joint.without_design > 0 {
        out.push_str(&format!(", in {} of them no motor can do it", joint.without_design));
    }
    if let (Some(least), Some(mean), Some(most)) = (joint.least_loss_w, joint.mean_loss_w, joint.largest_loss_w) {
        let [least, mean, most] = [least, mean, most].map(number);
        out.push_str(&format!("; loss of the first choice {least} to {most} W, mean {mean} W"));
    }
    out.push_str("\n\n");
    let among = top.map_or_else(|| ">can do it".to_string(), |k| format!(">among first {k}"));
    let header = ["motor", ">first choice", ">share", among.as_str(), ">cannot"];
    let rows: Vec<Vec<String>> = joint
        .motors
        .iter()
        .take(LISTED)
        .map(|m| {
            let share = format!("{} %", number((1000.0 * m.first as f64 / joint.robots as f64).round() / 10.0));
            vec![m.motor.clone(), m.first.to_string(), share, m.among.to_string(), m.cannot.to_string()]
        })
        .collect();
    if !rows.is_empty() {
        for line in table(&header, &rows).lines() {
            out.push_str(&format!("  {line}\n"));
        }
    }
    if joint.motors.len() > LISTED {
        out.push_str(&format!("  and {} more\n", joint.motors.len() - LISTED));
    }
    out
}

fn effects_text(effects: &[Effect]) -> String {
    if effects.is_empty() {
        return String::new();
    }
    let mut out = String::from("\nWhat the parameters do, all else equal:\n\n");
    let header =
        ["parameter", "value", "against", "joint", ">loss times", ">other first choice", ">gained", ">lost", ">pairs"];
    let rows: Vec<Vec<String>> = effects
        .iter()
        .take(EFFECTS)
        .map(|e| {
            let share = |n: u64| {
                if e.pairs == 0 { "–".to_string() } else { format!("{:.0} %", 100.0 * n as f64 / e.pairs as f64) }
            };
            vec![
                e.parameter.clone(),
                e.value.clone(),
                e.reference.clone(),
                e.joint.clone(),
                super::optional(e.loss_ratio),
                share(e.other_first_choice),
                e.gained.to_string(),
                e.lost.to_string(),
                e.pairs.to_string(),
            ]
        })
        .collect();
    for line in table(&header, &rows).lines() {
        out.push_str(&format!("  {line}\n"));
    }
    if effects.len() > EFFECTS {
        out.push_str(&format!("  and {} more, see summary.json\n", effects.len() - EFFECTS));
    }
    let note = "Loss times: geometric mean over the pairs of points that differ in this parameter alone and have a design at both \
                values. Gained, lost: points that have a design at this value only, or at the other only.";
    out.push_str(&format!("\n  {}\n", wrap(note, 2)));
    out
}

/// For programs.
pub fn json_text(summary: &Summary) -> String {
    super::json_text(&serde_json::to_value(summary).unwrap_or_default())
}

/// Who wins, and a row of panels for each parameter.
pub fn figure(summary: &Summary) -> Figure {
    let mut wins: BTreeMap<&str, u64> = BTreeMap::new();
    for motor in summary.joints.iter().flat_map(|j| &j.motors).filter(|m| m.first > 0) {
        *wins.entry(&motor.motor).or_default() += motor.first;
    }
    let mut wins: Vec<(&str, u64)> = wins.into_iter().collect();
    wins.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    let all: u64 = wins.iter().map(|w| w.1).sum();
    let share = |n: u64| 100.0 * n as f64 / all as f64;
    let bars = wins.iter().take(BARS).enumerate().map(|(k, w)| ((k + 1) as f64, share(w.1))).collect();
    let mut sum = 0;
    let running = wins.iter().take(BARS).enumerate().map(|(k, w)| {
        sum += w.1;
        ((k + 1) as f64, share(sum))
    });
    let running: Vec<(f64, f64)> = running.collect();
    let panel = |y: &str, series: Vec<Series>| Panel {
        x: "motor, the most frequent first choice first".into(),
        y: y.into(),
        series,
        empty: "no joint has a design".into(),
        ..Panel::default()
    };
    let leader = wins.first().map_or_else(String::new, |(motor, n)| {
        format!(": {motor} leads with {} %", number((10.0 * share(*n)).round() / 10.0))
    });
    let mut groups = vec![Group {
        title: format!("First choices of {} robots, {} motors{leader}", summary.robots, wins.len()),
        legend: Vec::new(),
        panels: vec![
            panel("joints it wins [%]", vec![series(Tone::Dark, Mark::Bars, bars)]),
            panel(
                "joints won up to it [%]",
                vec![series(Tone::Dark, Mark::Line, running.clone()), series(Tone::Dark, Mark::Dots, running)],
            ),
        ],
    }];
    let mut parameters: Vec<&str> = summary.effects.iter().map(|e| e.parameter.as_str()).collect();
    parameters.dedup();
    groups.extend(parameters.into_iter().map(|p| parameter(p, &summary.effects)));
    Figure { groups, columns: 2 }
}

fn series(tone: Tone, mark: Mark, points: Vec<(f64, f64)>) -> Series {
    Series { tone, mark, points }
}

/// All joints together: the loss at each value against the first, and who else wins.
fn parameter(name: &str, effects: &[Effect]) -> Group {
    let of: Vec<&Effect> = effects.iter().filter(|e| e.parameter == name).collect();
    let mut values: Vec<&str> = of.iter().map(|e| e.value.as_str()).collect();
    values.dedup();
    let reference = of.first().map_or("", |e| e.reference.as_str());
    let leading = |text: &str| text.split_whitespace().next().and_then(|t| t.parse::<f64>().ok());
    let unit = reference.split_once(' ').map_or("", |(_, unit)| unit.trim());
    // Numbers where all are in one unit; else the place in the list.
    let same_unit = values.iter().all(|v| v.split_once(' ').map_or("", |(_, u)| u.trim()) == unit);
    let numbers: Option<Vec<f64>> = std::iter::once(reference)
        .chain(values.iter().copied())
        .map(leading)
        .collect::<Option<_>>()
        .filter(|_| same_unit);
    let x = |k: usize| numbers.as_ref().map_or(k as f64 + 1.0, |n| n[k]);
    let (mut loss, mut other, mut lost) = (vec![(x(0), 1.0)], vec![(x(0), 0.0)], vec![(x(0), 0.0)]);
    for (k, value) in values.iter().enumerate() {
        let here = || of.iter().filter(|e| e.value == *value);
        let pairs: u64 = here().map(|e| e.pairs).sum();
        let logs: f64 = here().filter_map(|e| Some(e.pairs as f64 * e.loss_ratio?.ln())).sum();
        let share = |n: u64, of: u64| 100.0 * n as f64 / of as f64;
        loss.push((x(k + 1), (logs / pairs as f64).exp()));
        other.push((x(k + 1), share(here().map(|e| e.other_first_choice).sum(), pairs)));
        let gone: u64 = here().map(|e| e.lost).sum();
        lost.push((x(k + 1), share(gone, pairs + gone)));
    }
    let label = match (&numbers, unit) {
        (None, _) => format!("{name}, place in the list"),
        (Some(_), "") => name.to_string(),
        (Some(_), unit) => format!("{name} [{unit}]"),
    };
    let panel = |y: String, series| Panel {
        x: label.clone(),
        y,
        series,
        empty: "no difference between the values".into(),
        ..Panel::default()
    };
    let by_x = |mut points: Vec<(f64, f64)>| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let (loss, other, lost) = (by_x(loss), by_x(other), by_x(lost));
    Group {
        title: format!("{name}, against {reference}, all else equal"),
        legend: vec![(Tone::Dark, "loss; other first choice".into()), (Tone::Light, "no design any more".into())],
        panels: vec![
            panel(
                format!("loss over loss at {reference}"),
                vec![series(Tone::Dark, Mark::Line, loss.clone()), series(Tone::Dark, Mark::Dots, loss)],
            ),
            panel(
                "share of joints [%]".into(),
                vec![series(Tone::Light, Mark::Line, lost), series(Tone::Dark, Mark::Line, other)],
            ),
        ],
    }
}
