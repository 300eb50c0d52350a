//! What was found in the logs before anything was asked, in words.

use super::{channel_name, percent, round};
use crate::number;
use gearwise_identify::identify::{About, Finding, Report};
use gearwise_identify::{Bench, Channel};
use gearwise_model::words::handy::handy;

/// More stretches of one log than these are told together.
const MANY: usize = 3;

/// One line for each finding; what several logs have in common once.
pub fn lines(bench: &Bench, reports: &[Report]) -> Vec<String> {
    let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
    for (report, finding) in reports.iter().flat_map(|r| r.findings.iter().map(move |f| (r, f))) {
        let text = stands_often(report, finding).unwrap_or_else(|| words(bench, &finding.about));
        match lines.iter_mut().find(|(t, _)| *t == text) {
            Some((_, logs)) if logs.contains(&finding.log.as_str()) => {}
            Some((_, logs)) => logs.push(&finding.log),
            None => lines.push((text, vec![&finding.log])),
        }
    }
    let of = |logs: &[&str]| match logs {
        [.., _] if logs.len() > 3 => format!("{} logs", logs.len()),
        _ => logs.join(", "),
    };
    lines.into_iter().map(|(text, logs)| format!("{}: {text}", of(&logs))).collect()
}

/// A channel that stands still in many stretches of a log, for any one of them.
fn stands_often(report: &Report, finding: &Finding) -> Option<String> {
    let About::Stale { channel, .. } = finding.about else { return None };
    let length = |other: &Finding| match other.about {
        About::Stale { channel: same, from, to } if same == channel && other.log == finding.log => Some(to - from),
        _ => None,
    };
    let lengths: Vec<f64> = report.findings.iter().filter_map(length).collect();
    (lengths.len() > MANY).then(|| {
        format!(
            "{} does not change in {} stretches, {} s together, while the machine moves: left out",
            channel_name(channel),
            lengths.len(),
            number(round(lengths.iter().sum()))
        )
    })
}

/// A finding in words.
pub fn words(bench: &Bench, about: &About) -> String {
    let seconds = |t: f64| format!("{} s", number((1e4 * t).round() / 1e4));
    let milli = |t: f64| number((1e4 * t).round() / 10.0);
    let list = |channels: &[_]| channels.iter().map(|c| channel_name(*c)).collect::<Vec<_>>().join(", ");
    match about {
        About::Scale { channel, against, factor, reads } => {
            let reads = reads.map_or_else(String::new, |what| format!(", {what}"));
            format!(
                "{} is {} times what {} says{reads}; check unit, side and scale of both columns",
                channel_name(*channel),
                number(*factor),
                channel_name(*against)
            )
        }
        About::Sign { channel, against } => format!(
            "{} has the other sign than {}: one of the two columns needs `sign = -1`",
            channel_name(*channel),
            channel_name(*against)
        ),
        About::Unrelated { channel, against } => {
            format!("{} does not follow {}; check both columns", channel_name(*channel), channel_name(*against))
        }
        About::Controller { factor } => format!(
            "the logged duty is {} times what the declared controller asks for; check its `gain` and the units of duty, goal and \
             position",
            number(*factor)
        ),
        About::Late { channel, against, lag } => {
            let (late, early) = if *lag > 0.0 { (channel, against) } else { (against, channel) };
            format!(
                "{} comes {} ms after {}: {} is brought to the time of {}",
                channel_name(*late),
                milli(lag.abs()),
                channel_name(*early),
                channel_name(*channel),
                channel_name(*against)
            )
        }
        About::Held { channels, rows, whole: true } => {
            format!("{} repeat each value for {} rows: only the fresh rows are data", list(channels), number(*rows))
        }
        About::Held { channels, rows, .. } => {
            format!(
                "{}: each value is repeated for {} rows; only the fresh ones are data",
                list(channels),
                number(*rows)
            )
        }
        About::Stale { channel, from, to } => format!(
            "{} does not change from {} to {} while the machine moves: left out",
            channel_name(*channel),
            seconds(*from),
            seconds(*to)
        ),
        About::Clipped { channel, at, share } => format!(
            "{} stops at {} in {} % of the samples: these are left out",
            channel_name(*channel),
            in_unit(bench, *channel, *at),
            percent(*share)
        ),
        About::Zero { channel, zero, most } => format!(
            "the zero of {} would be {}, more than all that it read (up to {}): no sensor has such a zero; check the signs of the \
             columns, and what hangs at the output",
            channel_name(*channel),
            in_unit(bench, *channel, *zero),
            in_unit(bench, *channel, *most)
        ),
        About::Excluded { from, to, rows } => {
            let from = if from.is_finite() { seconds(*from) } else { "the beginning".into() };
            let to = if to.is_finite() { seconds(*to) } else { "the end".into() };
            let rows = if *rows == 0 { "no row of this log lies in it".into() } else { format!("{rows} rows") };
            format!("`exclude` from {from} to {to}: {rows}")
        }
        About::Spikes { channel, count } => {
            let (samples, are) = if *count == 1 { ("sample", "is") } else { ("samples", "are") };
            format!("{}: {count} single {samples} far off both neighbours {are} left out", channel_name(*channel))
        }
        About::Irregular { short, usual, long } => format!(
            "samples come at uneven times: {} to {} ms for nine of ten, {} ms is usual",
            milli(*short),
            milli(*long),
            milli(*usual)
        ),
        About::Owns { from, to, share } => format!(
            "the time from {} to {} owns {} % of the squared error of all logs for fitting: left out",
            seconds(*from),
            seconds(*to),
            percent(*share)
        ),
        About::Estimated(channel) => {
            format!("{} is the driver's own estimate, made of its current, and no sensor's", channel_name(*channel))
        }
    }
}

/// A value of a channel in a unit that is handy.
fn in_unit(bench: &Bench, channel: Channel, value: f64) -> String {
    let unit = if bench.declared.motor.is_some() { unit_of(channel) } else { "" };
    let (value, unit) = handy(value, unit);
    format!("{} {unit}", number(value)).trim_end().to_string()
}

fn unit_of(channel: Channel) -> &'static str {
    match channel {
        Channel::Current => "A",
        Channel::Voltage => "V",
        Channel::Torque => "N*m",
        Channel::MotorVelocity | Channel::OutputVelocity => "rad/s",
        _ => "",
    }
}
