//! Which samples are data, and whether they are of one machine: looked at before any effect is asked for.
//!
//! The one idea: a value that an instrument did not read is no sample. What a driver repeated, what a sensor could not
//! show and what stood still while the machine moved is taken out before the filter sees it, and said; channels that
//! contradict each other teach nothing until the bench file says which of them is right.

use super::machine;
use crate::answer::findings::{About, Finding};
use crate::bench::{Bench, BenchKind, Channel, Log};
use crate::signals;

/// Channels that an instrument reads from row to row, but for positions.
const VALUES: [Channel; 6] = [
    Channel::Current,
    Channel::Voltage,
    Channel::Torque,
    Channel::MotorVelocity,
    Channel::OutputVelocity,
    Channel::OutputAcceleration,
];
/// Positions, which go on where a value is left out.
const POSITIONS: [Channel; 2] = [Channel::MotorPosition, Channel::OutputPosition];

/// All of them.
fn measured() -> impl Iterator<Item = Channel> {
    VALUES.into_iter().chain(POSITIONS)
}

/// A channel that repeats more than this share of its rows may be held.
const REPEATS: f64 = 0.45;
/// One that repeats less is read afresh at every row.
const FRESH: f64 = 0.1;
/// The longest that a driver holds a value \[s\].
const HOLDS: f64 = 0.12;
/// A value that is held jumps by more than this many of its smallest steps.
const JUMPS: f64 = 1.5;
/// Least rows, and time \[s\], that a channel must stand to be stale.
const STALE: (usize, f64) = (6, 0.02);
/// How often a channel of coarse steps may repeat a value so often by chance, over a log.
const BY_CHANCE: f64 = 1e-9;
/// A position that leaps goes this many times as far as in any one of so many samples before and after.
const LEAP: f64 = 3.0;
const BESIDE: usize = 12;
/// What says that a machine moves.
const MOTION: [Channel; 4] =
    [Channel::MotorPosition, Channel::OutputPosition, Channel::MotorVelocity, Channel::OutputVelocity];
/// In times its noise, and in its smallest steps, how far a channel must go to move.
const MOVED: f64 = 8.0;
const STEPS: f64 = 3.0;
/// A spike is this many times further from its neighbours than samples usually are.
const SPIKE: f64 = 30.0;
/// Fewest samples of a log that is looked at.
const FEWEST: usize = 32;
/// Share of a log that may be left out.
const LEFT_OUT: f64 = 0.2;
/// So much later is another sample \[s\].
const JUST_AFTER: f64 = 1e-9;
/// Steps of time that differ by more, as a share of the usual one, are irregular.
const IRREGULAR: f64 = 0.25;

/// The bench with what is no data taken out, and what was found.
pub fn prepare(bench: &Bench) -> (Bench, Vec<Finding>) {
    let mut bench = bench.clone();
    let mut findings = Vec::new();
    let ratio = bench.declared.ratio;
    let linear = bench.declared.motor.is_none();
    let pole_pairs = bench.declared.motor.as_ref().and_then(|m| m.pole_pairs);
    for log in &mut bench.logs {
        let mut found: Vec<About> = log.estimated.iter().map(|c| About::Estimated(*c)).collect();
        found.extend(log.excluded.iter().zip(log.excluded_rows()).map(|(stretch, rows)| About::Excluded {
            from: stretch.start,
            to: stretch.end,
            rows: rows.len(),
        }));
        if log.kind != BenchKind::SteadyTable && log.len() >= FEWEST {
            found.extend(irregular(&log.time));
            found.extend(held(log));
            found.extend(spikes(log));
            found.extend(clipped(log));
            found.extend(stale(log, ratio));
            let mut contradictions = machine::contradictions(log, ratio, linear, pole_pairs);
            contradictions.extend(machine::controller(log, ratio, linear));
            // Of a servo the position is what is simulated.
            if contradictions.is_empty() && log.kind != BenchKind::Servo {
                found.extend(late(log, linear));
            }
            found.extend(contradictions);
            leave_out(log);
        }
        findings.extend(found.into_iter().map(|about| Finding { log: log.name.clone(), about }));
    }
    (bench, findings)
}

/// Brings a position to the time of its velocity, where one of the two is late: a lag that both have in common is for the
/// equation to find.
fn late(log: &mut Log, linear: bool) -> Option<About> {
    let (channel, against, lag) = machine::late(log, linear)?;
    let values = log.channels.get_mut(&channel)?;
    let opened = if linear { values.clone() } else { signals::unwrapped(values) };
    let known: Vec<(f64, f64)> =
        log.time.iter().copied().zip(opened.iter().copied()).filter(|(_, v)| v.is_finite()).collect();
    let mut after = 1;
    for (k, value) in values.iter_mut().enumerate().filter(|(_, v)| v.is_finite()) {
        let t = log.time[k] + lag;
        while after + 1 < known.len() && known[after].0 < t {
            after += 1;
        }
        while after > 1 && known[after - 1].0 > t {
            after -= 1;
        }
        let (a, b) = (known[after - 1], known[after]);
        // Beyond the ends it goes on as it was.
        *value = a.1 + (t - a.0) / (b.0 - a.0) * (b.1 - a.1);
    }
    Some(About::Late { channel, against, lag })
}

/// Takes out what lies in the stretches that are excluded.
pub fn leave_out(log: &mut Log) {
    let rows: Vec<std::ops::Range<usize>> = log.excluded_rows().filter(|r| !r.is_empty()).collect();
    for rows in rows {
        for channel in VALUES {
            if let Some(values) = log.channels.get_mut(&channel) {
                values[rows.clone()].fill(f64::NAN);
            }
        }
    }
}

fn irregular(time: &[f64]) -> Option<About> {
    let steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    let usual = signals::median(steps.clone())?;
    let short = signals::quantile(steps.clone(), 0.05)?;
    let long = signals::quantile(steps, 0.95)?;
    (long - short > IRREGULAR * usual).then_some(About::Irregular { short, usual, long })
}

/// Places at which a channel has a value that differs from the last one, and the share of the others.
fn fresh(values: &[f64]) -> (Vec<usize>, f64) {
    let mut places = Vec::new();
    let (mut last, mut known) = (f64::NAN, 0_usize);
    for (k, v) in values.iter().enumerate().filter(|(_, v)| v.is_finite()) {
        known += 1;
        if *v != last {
            places.push(k);
        }
        last = *v;
    }
    let repeats = 1.0 - places.len() as f64 / known.max(1) as f64;
    (places, repeats)
}

/// Rows from one fresh value to the next, where a channel is held; not where a slow signal of few bits goes step by step.
fn hold(values: &[f64], step: f64) -> Option<(f64, Vec<usize>)> {
    let (places, repeats) = fresh(values);
    if repeats < REPEATS || places.len() < 16 {
        return None;
    }
    let gaps: Vec<f64> = places.windows(2).map(|w| (w[1] - w[0]) as f64).collect();
    let rows = signals::median(gaps)?;
    let jumps: Vec<f64> = places.windows(2).map(|w| (values[w[1]] - values[w[0]]).abs()).collect();
    let quantum = jumps.iter().copied().fold(f64::INFINITY, f64::min);
    let usual = signals::median(jumps)?;
    (rows >= 2.0 && rows * step < HOLDS && usual > JUMPS * quantum).then_some((rows, places))
}

/// Finds the channels that repeat their values, and leaves their fresh ones.
fn held(log: &mut Log) -> Vec<About> {
    let step = signals::median_step(&log.time);
    let measured: Vec<Channel> =
        log.channels.keys().copied().filter(|c| measured().any(|m| m == *c) && !log.held.contains(c)).collect();
    let holds: Vec<(Channel, f64, Vec<usize>)> =
        measured.iter().filter_map(|c| hold(&log.channels[c], step).map(|(rows, places)| (*c, rows, places))).collect();
    if holds.is_empty() {
        return Vec::new();
    }
    let rows = holds.iter().map(|h| h.1).fold(0.0, f64::max);
    let alike = holds.iter().all(|h| (h.1 - rows).abs() <= 1.0);
    // Whatever is there and moves is held by the same number of rows: only the fresh rows are data.
    let moves = |c: &Channel| fresh(&log.channels[c]).0.len() > 16;
    if alike && measured.iter().filter(|c| moves(c)).count() == holds.len() && holds.len() > 1 {
        let mut keep = vec![false; log.len()];
        holds.iter().flat_map(|h| &h.2).for_each(|k| keep[*k] = true);
        let channels = holds.iter().map(|h| h.0).collect();
        log.keep_rows(&keep);
        return vec![About::Held { channels, rows, whole: true }];
    }
    let mut found: Vec<About> = Vec::new();
    for (channel, rows, places) in holds {
        let mut own = vec![f64::NAN; log.len()];
        if let Some(values) = log.channels.get_mut(&channel) {
            places.iter().for_each(|k| own[*k] = values[*k]);
            *values = own;
        }
        log.fresh.insert(channel, rows);
        match found.iter_mut().find(|f| matches!(f, About::Held { rows: r, .. } if *r == rows)) {
            Some(About::Held { channels, .. }) => channels.push(channel),
            _ => found.push(About::Held { channels: vec![channel], rows, whole: false }),
        }
    }
    found
}

/// How far the middle one of three samples is from the mean of the others.
fn off_its_neighbours(three: &[f64]) -> f64 {
    (three[1] - 0.5 * (three[0] + three[2])).abs()
}

/// Takes out single samples far off both neighbours, which agree; not where another channel leaps at the same time: then it
/// is the machine that did.
fn spikes(log: &mut Log) -> Vec<About> {
    // Of each channel how far samples usually are off their neighbours, and where they are far off.
    let mut leaps: Vec<(Channel, f64, Vec<usize>)> = Vec::new();
    for channel in measured() {
        let Some(values) = log.channels.get(&channel).filter(|v| v.len() >= 64) else { continue };
        let off: Vec<f64> = values.windows(3).map(off_its_neighbours).collect();
        let usual = signals::quantile(off.clone(), 0.9).unwrap_or(0.0);
        let level = values.iter().filter(|v| v.is_finite()).map(|v| v.abs()).fold(0.0, f64::max);
        if usual > 1e-6 * level {
            let far = (0..off.len()).filter(|k| off[*k] > 0.25 * SPIKE * usual).map(|k| k + 1).collect();
            leaps.push((channel, usual, far));
        }
    }
    let mut found = Vec::new();
    for (channel, usual, at) in &leaps {
        if !VALUES.contains(channel) || log.fresh.contains_key(channel) {
            continue;
        }
        let elsewhere = |k: usize| {
            let mut others = leaps.iter().filter(|(c, ..)| c != channel).flat_map(|(.., at)| at);
            others.any(|o| o.abs_diff(k) <= 3)
        };
        let Some(values) = log.channels.get_mut(channel) else { continue };
        let is_wild = |k: &usize| {
            let off = off_its_neighbours(&values[k - 1..=k + 1]);
            off > SPIKE * usual && (values[k + 1] - values[k - 1]).abs() < 0.3 * off && !elsewhere(*k)
        };
        let alone: Vec<usize> = at.iter().copied().filter(is_wild).collect();
        if alone.is_empty() || alone.len() as f64 > 0.01 * values.len() as f64 {
            continue;
        }
        alone.iter().for_each(|k| values[*k] = f64::NAN);
        found.push(About::Spikes { channel: *channel, count: alone.len() });
    }
    found
}

/// Stretches in which a channel that is read afresh at every row rests at its largest or least value.
fn clipped(log: &mut Log) -> Vec<About> {
    let mut found = Vec::new();
    for (channel, values) in &log.channels {
        if !VALUES.contains(channel) || *channel == Channel::OutputAcceleration {
            continue;
        }
        let (_, repeats) = fresh(values);
        let known = || values.iter().copied().filter(|v| v.is_finite());
        let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        for at in [high, low] {
            let runs: Vec<_> = runs(values).into_iter().filter(|r| values[r.start] == at && r.len() >= 3).collect();
            let count: usize = runs.iter().map(std::ops::Range::len).sum();
            let share = count as f64 / values.len() as f64;
            // Other values must not repeat: a staircase rests everywhere.
            let others = repeats - share;
            if at == 0.0 || !(2e-3..=LEFT_OUT).contains(&share) || others > FRESH {
                continue;
            }
            for r in runs {
                log.excluded.push(log.time[r.start]..log.time[r.end - 1] + JUST_AFTER);
            }
            found.push(About::Clipped { channel: *channel, at, share });
        }
    }
    found
}

/// Stretches of equal values.
fn runs(values: &[f64]) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let mut start = 0;
    for k in 1..=values.len() {
        if k == values.len() || values[k] != values[start] {
            found.push(start..k);
            start = k;
        }
    }
    found
}

/// Whether a channel moves in a stretch, beyond its noise and its steps: a position from one end to the other, others also by
/// what they are if they go on about a speed.
fn moves(values: &[f64], stretch: &std::ops::Range<usize>, is_position: bool) -> bool {
    let own: Vec<f64> = values[stretch.clone()].iter().copied().filter(|v| v.is_finite()).collect();
    let steps = values.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0);
    let step = steps.fold(f64::INFINITY, f64::min);
    let known = (MOVED * signals::noise_level(values)).max(STEPS * step);
    // What begins at its last sample is no motion in it.
    let at = |share: f64| signals::quantile(own.clone(), share).unwrap_or(0.0);
    let level = if is_position { 0.0 } else { at(0.5).abs() };
    (at(0.9) - at(0.1)).max(level) > known
}

/// Whether a position should have gone on in a stretch by more than its steps, as another channel of motion has it, and then
/// shows that it did.
fn goes_on(log: &Log, position: Channel, other: Channel, ratio: f64, stretch: &std::ops::Range<usize>) -> bool {
    let of_motor = |c: Channel| matches!(c, Channel::MotorPosition | Channel::MotorVelocity);
    let factor = match (of_motor(position), of_motor(other)) {
        (true, false) => ratio,
        (false, true) => 1.0 / ratio,
        _ => 1.0,
    };
    // Last digits are no steps.
    let step_of = |c: Channel| {
        let steps = log.channels[&c].windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0).collect();
        signals::quantile(steps, 0.25).unwrap_or(f64::INFINITY)
    };
    let values = &log.channels[&other][stretch.clone()];
    let mut resolved = factor * step_of(other);
    let path: Vec<f64> = if POSITIONS.contains(&other) {
        values.iter().filter(|v| v.is_finite()).map(|v| factor * v).collect()
    } else {
        resolved *= signals::median_step(&log.time);
        let steps = values.iter().zip(&log.time[stretch.clone()]).zip(&log.time[stretch.start + 1..]);
        let mut at = 0.0;
        let step = |((v, from), to): ((&f64, &f64), &f64)| {
            at += if v.is_finite() { factor * v * (to - from) } else { 0.0 };
            at
        };
        steps.map(step).collect()
    };
    let (low, high) = path.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let least = STEPS * step_of(position).max(resolved);
    // Where it is read again it has what it missed: a shaft that another one winds up against stood.
    let catches_up = || {
        let own = &log.channels[&position];
        let (Some(after), Some(first), Some(last)) = (own.get(stretch.end), path.first(), path.last()) else {
            return true;
        };
        let (leap, went) = (after - own[stretch.start], last - first);
        went.abs() > least && (leap - went).abs() < 0.5 * (high - low)
    };
    high - low > least && catches_up()
}

/// Whether a position leaps at the end of a stretch in which it stood, further than it goes from one sample to the next before
/// and after: it went on meanwhile.
fn leaps(values: &[f64], stretch: &std::ops::Range<usize>) -> bool {
    let steps = |from: usize, to: usize| values[from..to].windows(2).map(|w| (w[1] - w[0]).abs());
    let before = steps(stretch.start.saturating_sub(BESIDE), stretch.start + 1);
    let after = steps(stretch.end.min(values.len()), (stretch.end + BESIDE).min(values.len()));
    let largest = before.chain(after).filter(|d| d.is_finite()).fold(0.0, f64::max);
    let is_far = |after: &f64| (after - values[stretch.start]).abs() > LEAP * largest;
    largest > 0.0 && values.get(stretch.end).is_some_and(is_far)
}

/// Stretches in which a channel that is read afresh at every row stands, while the machine moves.
fn stale(log: &mut Log, ratio: f64) -> Vec<About> {
    let step = signals::median_step(&log.time);
    let least = STALE.0.max((STALE.1 / step).ceil() as usize);
    let readable: Vec<(Channel, f64)> = measured()
        .filter_map(|c| Some((c, fresh(log.channels.get(&c)?).1)))
        .filter(|(_, repeats)| *repeats < REPEATS)
        .collect();
    let mut found = Vec::new();
    let mut excluded = Vec::new();
    for (channel, repeats) in &readable {
        let values = &log.channels[channel];
        // One of coarse steps repeats a value now and then: so long it does not, in any log.
        let by_chance = (BY_CHANCE / values.len() as f64).ln() / repeats.ln();
        let least = if *repeats < FRESH { least } else { least.max(by_chance.ceil() as usize) };
        let mut long: Vec<std::ops::Range<usize>> =
            runs(values).into_iter().filter(|r| r.len() >= least && values[r.start].is_finite()).collect();
        // What is left out already needs no second reason.
        long.retain(|r| !log.excluded.iter().any(|e| e.contains(&log.time[r.start])));
        // At rest a channel may stand as it likes: another one moves meanwhile, beyond its noise and its steps.
        let of_motion = MOTION.into_iter().filter(|c| c != channel && log.channels.contains_key(c));
        let mut asked: Vec<Channel> = of_motion.collect();
        if asked.is_empty() {
            asked.extend(readable.iter().map(|(c, _)| *c).filter(|c| c != channel));
        }
        let is_position = POSITIONS.contains(channel);
        if is_position && *repeats >= FRESH {
            // An encoder of coarse steps stands as it likes.
            asked.clear();
        }
        long.retain(|r| {
            is_position && leaps(values, r)
                || asked.iter().any(|c| match is_position && MOTION.contains(c) {
                    true => goes_on(log, *channel, *c, ratio, r),
                    false => moves(&log.channels[c], r, POSITIONS.contains(c)),
                })
        });
        let all: usize = long.iter().map(std::ops::Range::len).sum();
        if all as f64 > LEFT_OUT * values.len() as f64 {
            continue;
        }
        for r in long {
            let (from, to) = (log.time[r.start], log.time[r.end - 1]);
            excluded.push(from..to + 0.5 * step);
            found.push(About::Stale { channel: *channel, from, to });
        }
    }
    log.excluded.extend(excluded);
    found
}

#[cfg(test)]
mod tests;
