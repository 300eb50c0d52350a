//! Whether the channels of a log are of one machine: position against velocity, one side of the gear against the other.

use crate::answer::findings::About;
use crate::bench::{BenchKind, Channel, Law, Log};
use crate::signals::{self, LowPass};

/// Scales that differ by less are not told: estimates and coarse encoders are off by some per cent.
const SCALE: f64 = 0.15;
/// Ratios of two positions, whose scales are exact, that differ by less are not told.
const OF_RATIO: f64 = 0.03;
/// Most that a ratio may leave of the motor's position, as a share of what it explains beyond the declared one.
const LEFT: f64 = 0.2;
/// Correlation from which two channels follow each other, and below which they do not.
const FOLLOWS: (f64, f64) = (0.9, 0.3);
/// Least times its noise that a speed must move to be compared.
const MOVES: f64 = 5.0;
/// A speed whose mean is this many times its changes is one speed.
const STEADY: f64 = 3.0;
/// Share of the sampling rate up to which speeds are compared.
const BAND: f64 = 0.05;
/// A controller is looked at below this share of its limit.
const INSIDE: f64 = 0.95;
/// A lag must leave at most this share of the squares by which two speeds differ.
const NEARER: f64 = 0.5;
/// Largest lag that is allowed for \[s\].
const LAG: f64 = 0.05;

/// What contradicts itself in a log of an actuator of a ratio.
pub fn contradictions(log: &Log, ratio: f64, linear: bool, pole_pairs: Option<u32>) -> Vec<About> {
    if matches!(log.kind, BenchKind::SteadyTable | BenchKind::Stall | BenchKind::ThermalStep) {
        return Vec::new();
    }
    let speeds: Vec<(Channel, Vec<f64>)> = [
        (Channel::MotorPosition, 1.0),
        (Channel::OutputPosition, ratio),
        (Channel::MotorVelocity, 1.0),
        (Channel::OutputVelocity, ratio),
    ]
    .into_iter()
    .filter_map(|(channel, factor)| Some((channel, speed(log, channel, factor, linear)?)))
    .collect();
    let Some(step) = longest(log).map(|r| signals::median_step(&log.time[r])) else { return Vec::new() };
    let across = across(log, ratio, linear);
    if let Some(Across::Another { factor }) = across {
        return vec![About::Scale {
            channel: Channel::OutputPosition,
            against: Channel::MotorPosition,
            factor,
            reads: reads(factor, ratio, pole_pairs).or(Some("as if the ratio were the declared one divided by that")),
        }];
    }
    // Each against the first position that there is, on its own side where the gear's yield is known; one contradiction is enough.
    let is_of_output = |c: Channel| matches!(c, Channel::OutputPosition | Channel::OutputVelocity);
    let mut found = speeds.iter().filter_map(|(channel, own)| {
        let is_near = |other: &Channel| across.is_none() || is_of_output(*other) == is_of_output(*channel);
        let (against, reference) = speeds.iter().find(|(other, _)| is_near(other)).filter(|(o, _)| o != channel)?;
        compare(*channel, own, *against, reference, step, ratio, pole_pairs)
    });
    found.next().into_iter().collect()
}

/// The two sides of a gear that yields.
enum Across {
    /// They turn by the declared ratio.
    Declared,
    /// They turn by another one, this factor off.
    Another { factor: f64 },
}

/// The ratio by which the positions on both sides of the gear turn, once the yield under its load is taken out:
/// `q_motor = N q_output + c τ + q_0`. `None` where positions or load are missing, or where that does not explain the motor's position.
fn across(log: &Log, ratio: f64, linear: bool) -> Option<Across> {
    let opened = |channel| log.channel(channel).map(|v| if linear { v.to_vec() } else { signals::unwrapped(v) });
    let [motor, output] = [opened(Channel::MotorPosition)?, opened(Channel::OutputPosition)?];
    let load = log.channel(Channel::Torque).or_else(|| log.channel(Channel::Current))?;
    let range = longest(log)?;
    let rows = || range.clone().map(|k| [output[k], load[k], motor[k]]).filter(|row| row.iter().all(|x| x.is_finite()));
    let count = rows().count() as f64;
    let means = rows().fold([0.0; 3], |sum, row| [0, 1, 2].map(|i| sum[i] + row[i] / count));
    let mut squares = [[0.0; 3]; 3];
    for row in rows() {
        let row: [f64; 3] = [0, 1, 2].map(|i| row[i] - means[i]);
        (0..9).for_each(|k| squares[k / 3][k % 3] += row[k / 3] * row[k % 3] / count);
    }
    let [[oo, ol, om], [_, ll, lm], [_, _, mm]] = squares;
    // Each apart from its part that follows the load.
    let (own, both, of_motor) = (oo - ol * ol / ll, om - ol * lm / ll, mm - lm * lm / ll);
    let found = both / own;
    let (apart, left) = ((found - ratio).abs() * own.sqrt(), (of_motor - found * both).max(0.0).sqrt());
    let factor = ratio / found;
    match (factor - 1.0).abs() > OF_RATIO {
        true => (factor > 0.0 && left < LEFT * apart).then_some(Across::Another { factor }),
        false => (left < LEFT * of_motor.sqrt()).then_some(Across::Declared),
    }
}

/// The longest stretch between gaps.
fn longest(log: &Log) -> Option<std::ops::Range<usize>> {
    signals::stretches(&log.time).into_iter().max_by_key(std::ops::Range::len).filter(|r| r.len() >= 200)
}

/// Speed of the motor's shaft as a channel has it, slow enough to be compared; `None` where it does not move.
fn speed(log: &Log, channel: Channel, factor: f64, linear: bool) -> Option<Vec<f64>> {
    let values = log.channel(channel)?;
    let range = longest(log)?;
    let step = signals::median_step(&log.time[range.clone()]);
    let is_position = matches!(channel, Channel::MotorPosition | Channel::OutputPosition);
    let opened = if is_position && !linear { signals::unwrapped(values) } else { values.to_vec() };
    let even =
        signals::on_grid(&log.time[range.clone()], &opened[range.clone()], log.time[range.start], step, range.len())?;
    let filter = LowPass::new(BAND);
    let speed = if is_position { signals::derivative(&even, step) } else { even };
    let noise = signals::noise_level(&speed) * filter.noise_gain().sqrt();
    let slow = filter.apply(&speed);
    let moves = size(&slow, mean(&slow)).max(mean(&slow).abs());
    (moves > MOVES * noise && moves > 0.0).then(|| slow.iter().map(|v| v * factor).collect())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Root mean square about a level.
fn size(values: &[f64], level: f64) -> f64 {
    (values.iter().map(|v| (v - level).powi(2)).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Correlation of what two speeds are beyond their levels, at the lag at which it is largest in size.
fn correlation(a: &[f64], b: &[f64], (of_a, of_b): (f64, f64), most: usize) -> f64 {
    let n = a.len();
    let at = |lag: isize| {
        let (from, to) = (lag.max(0) as usize, (n as isize + lag.min(0)) as usize);
        let (x, y) = (&a[from..to], &b[(from as isize - lag) as usize..(to as isize - lag) as usize]);
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for (x, y) in x.iter().zip(y) {
            xx += (x - of_a).powi(2);
            yy += (y - of_b).powi(2);
            xy += (x - of_a) * (y - of_b);
        }
        xy / (xx * yy).sqrt()
    };
    let most = most.min(n / 4) as isize;
    let step = (most / 8).max(1);
    let mut best = 0.0_f64;
    let mut lag = -most;
    while lag <= most {
        let value = at(lag);
        if value.abs() > best.abs() {
            best = value;
        }
        lag += step;
    }
    best
}

fn compare(
    channel: Channel,
    values: &[f64],
    against: Channel,
    reference: &[f64],
    step: f64,
    ratio: f64,
    pole_pairs: Option<u32>,
) -> Option<About> {
    // What turns at one speed says by its level what it is; what turns both ways by how it changes, whatever its zero.
    let turns = mean(reference).abs() > STEADY * size(reference, mean(reference));
    let levels = if turns { (0.0, 0.0) } else { (mean(values), mean(reference)) };
    let follows = correlation(values, reference, levels, (LAG / step) as usize);
    if follows.abs() < FOLLOWS.1 {
        return Some(About::Unrelated { channel, against });
    }
    if follows < -FOLLOWS.0 {
        return Some(About::Sign { channel, against });
    }
    let factor = size(values, levels.0) / size(reference, levels.1);
    (follows > FOLLOWS.0 && (factor - 1.0).abs() > SCALE).then(|| About::Scale {
        channel,
        against,
        factor,
        reads: reads(factor, ratio, pole_pairs),
    })
}

/// Whether the logged duty cycle is the declared controller's, but for a factor.
pub fn controller(log: &Log, ratio: f64, linear: bool) -> Option<About> {
    // With a current its torque is known, and nothing asks the controller.
    let (controller, duty) = (
        log.controller.filter(|c| c.law == Law::Duty && log.channel(Channel::Current).is_none())?,
        log.channel(Channel::Duty)?,
    );
    let opened = |c: Channel| log.channel(c).map(|v| if linear { v.to_vec() } else { signals::unwrapped(v) });
    let goal = opened(Channel::Goal)?;
    let position = opened(Channel::OutputPosition)
        .or_else(|| Some(opened(Channel::MotorPosition)?.iter().map(|q| q / ratio).collect()))?;
    let inside = |d: f64| d.abs() < INSIDE * controller.limit;
    let (mut aa, mut dd, mut ad) = (0.0, 0.0, 0.0);
    for k in 1..log.len().min(duty.len()).saturating_sub(1) {
        let speed = (position[k + 1] - position[k - 1]) / (log.time[k + 1] - log.time[k - 1]);
        let asked = controller.gain * (goal[k] - position[k]) - controller.damping * speed;
        // A drive that is off asks for nothing.
        if asked.is_finite() && duty[k].is_finite() && duty[k] != 0.0 && inside(asked) && inside(duty[k]) {
            (aa, dd, ad) = (aa + asked * asked, dd + duty[k] * duty[k], ad + asked * duty[k]);
        }
    }
    let (follows, factor) = (ad / (aa * dd).sqrt(), ad / aa);
    (follows.abs() > FOLLOWS.0 && (factor - 1.0).abs() > SCALE).then_some(About::Controller { factor })
}

/// A position that is late against the velocity of its own shaft, or early, and by how much.
pub fn late(log: &Log, linear: bool) -> Option<(Channel, Channel, f64)> {
    let shafts = [(Channel::MotorPosition, Channel::MotorVelocity), (Channel::OutputPosition, Channel::OutputVelocity)];
    // Two positions say how far one shaft leads the other: moving one of them would make that up.
    if shafts.iter().all(|(position, _)| log.channel(*position).is_some()) {
        return None;
    }
    let step = signals::median_step(&log.time[longest(log)?]);
    shafts.into_iter().find_map(|(position, velocity)| {
        let of_position = speed(log, position, 1.0, linear)?;
        let lag = step * lateness(&of_position, &speed(log, velocity, 1.0, linear)?, LAG / step)?;
        Some((position, velocity, lag))
    })
}

/// By how many samples one speed comes after another one of the same shaft, at most so many; `None` where they are not
/// surely nearer to each other for it.
fn lateness(values: &[f64], reference: &[f64], most: f64) -> Option<f64> {
    let n = values.len();
    let most = (most as usize).min(n / 8);
    let (inside, count) = (most..n - most, (n - 2 * most) as f64);
    let spread = size(&reference[inside.clone()], mean(&reference[inside.clone()]));
    // What is left of the reference when the other speed, so many samples later, takes its part of it.
    let left = |lag: isize| {
        let pairs = || inside.clone().map(|k| (values[(k as isize + lag) as usize], reference[k]));
        let (a, b) = pairs().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
        let (xx, xy, yy) = pairs().fold((0.0, 0.0, 0.0), |(xx, xy, yy), (x, y)| {
            (xx + (x - a).powi(2), xy + (x - a) * (y - b), yy + (y - b).powi(2))
        });
        yy - xy * xy / xx
    };
    let most = most as isize;
    let at = (-most..=most).min_by(|a, b| left(*a).total_cmp(&left(*b)))?;
    if spread == 0.0 || at.abs() == most || at.abs() < 2 || left(at) > NEARER * left(0) {
        return None;
    }
    // The vertex of the parabola through the best and its neighbours.
    let (before, best, after) = (left(at - 1), left(at), left(at + 1));
    let bend = before - 2.0 * best + after;
    let beside = if bend > 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Some(at as f64 + beside)
}

/// What a factor would be that two channels of one shaft differ by.
fn reads(factor: f64, ratio: f64, pole_pairs: Option<u32>) -> Option<&'static str> {
    use std::f64::consts::TAU;
    let poles = pole_pairs.map_or(f64::NAN, f64::from);
    let known = [
        (ratio, "the ratio: it is on the motor's side of the gear"),
        (1.0 / ratio, "one over the ratio: it is on the output's side of the gear"),
        (60.0 / TAU, "that of revolutions a minute for radians a second"),
        (TAU / 60.0, "that of radians a second for revolutions a minute"),
        (TAU, "that of radians for turns"),
        (1.0 / TAU, "that of turns for radians"),
        (360.0 / TAU, "that of degrees for radians"),
        (TAU / 360.0, "that of radians for degrees"),
        (1e3, "a thousand: a unit of time or angle"),
        (1e-3, "a thousandth: a unit of time or angle"),
        (poles, "the pole pairs: it is electrical"),
        (1.0 / poles, "one over the pole pairs: it is electrical"),
    ];
    known.into_iter().find(|(k, _)| (factor / k - 1.0).abs() < 0.03 && (k - 1.0).abs() > SCALE).map(|(_, what)| what)
}

#[cfg(test)]
mod tests {
    use super::super::steady::{bench_of, noise};
    use super::*;
    use crate::bench::Controller;

    /// A log of rows of time, position and velocity of the motor, current and torque.
    fn log_of(row: impl Fn(usize) -> Vec<f64>) -> Log {
        let columns = [
            "time = { name = \"0\", unit = \"s\" }",
            "motor_position = { name = \"1\", unit = \"rad\" }",
            "motor_velocity = { name = \"2\", unit = \"rad/s\" }",
            "current = { name = \"3\", unit = \"A\", convention = \"q_axis\" }",
            "torque = { name = \"4\", unit = \"N*m\", side = \"output\" }",
        ];
        bench_of("dynamometer", 9.0, &columns, &[(0..3000).map(row).collect()], 0).logs.remove(0)
    }

    /// What contradicts itself in such rows.
    fn of_rows(row: impl Fn(usize) -> Vec<f64>) -> Vec<About> {
        contradictions(&log_of(row), 9.0, false, Some(7))
    }

    /// Position and velocity of the motor, the velocity times a factor and with so much noise.
    fn said(factor: f64, wild: f64) -> Vec<About> {
        let row = |k: usize| {
            let t = 2e-3 * k as f64;
            let angle = 20.0 * (3.0 * t).sin() + 4.0 * (7.1 * t).cos();
            let speed = 60.0 * (3.0 * t).cos() - 28.4 * (7.1 * t).sin();
            let own = if wild > 0.0 { wild * (40.0 * t + 3.0 * (1.3 * t).sin()).sin() } else { speed };
            vec![t, angle, factor * own + 0.1 * noise(k), noise(k + 900), noise(k + 1900)]
        };
        of_rows(row)
    }

    #[test]
    fn a_velocity_that_is_not_that_of_its_position_contradicts_it() {
        assert_eq!(said(1.0, 0.0), []);
        // Ten per cent is what estimates are off by.
        assert_eq!(said(1.1, 0.0), []);
        for (factor, reads) in
            [(9.0, "the ratio"), (1.0 / 9.0, "one over the ratio"), (9.549, "revolutions"), (7.0, "pole pairs")]
        {
            let said = said(factor, 0.0);
            let [About::Scale { factor: told, reads: Some(what), .. }] = said[..] else { panic!("{factor}: {said:?}") };
            assert!((told / factor - 1.0).abs() < 0.02 && what.contains(reads), "{factor}: {told} {what}");
        }
        assert!(matches!(said(2.3, 0.0)[..], [About::Scale { reads: None, .. }]));
        assert!(matches!(said(-1.0, 0.0)[..], [About::Sign { channel: Channel::MotorVelocity, .. }]));
        assert!(matches!(said(1.0, 60.0)[..], [About::Unrelated { .. }]));
        assert!(said(-1.0, 0.0)[0].contradicts());
    }

    /// Positions on both sides of a gear of 9 that yields: a declared ratio of 8 is told, and the true one is not, however soft it is.
    #[test]
    fn positions_by_another_ratio_than_the_declared_contradict_it() {
        let said = |declared: f64, yields: f64, wild: f64| {
            let row = |k: usize| {
                let t = 2e-3 * k as f64;
                let output = 2.0 * (3.0 * t).sin() + 0.4 * (7.1 * t).cos();
                let torque = 5.0 * (2.1 * t).sin() + 4.0 * output;
                let motor = 9.0 * (output + yields * torque + wild * (11.0 * t).sin());
                let measured =
                    [motor + 1e-3 * noise(k), output + 1e-4 * noise(k + 900), torque + 0.1 * noise(k + 1900)];
                [t].into_iter().chain(measured).chain([torque / 9.0]).collect()
            };
            let columns = [
                "time = { name = \"0\", unit = \"s\" }",
                "motor_position = { name = \"1\", unit = \"rad\" }",
                "output_position = { name = \"2\", unit = \"rad\" }",
                "torque = { name = \"3\", unit = \"N*m\", side = \"output\" }",
                "current = { name = \"4\", unit = \"A\", convention = \"q_axis\" }",
            ];
            let log = bench_of("dynamometer", declared, &columns, &[(0..3000).map(row).collect()], 0).logs.remove(0);
            contradictions(&log, declared, false, Some(7))
        };
        for yields in [0.0, 1e-3, 2e-2, 0.1] {
            assert_eq!(said(9.0, yields, 0.0), []);
            let found = said(8.0, yields, 0.0);
            let [About::Scale { factor, .. }] = found[..] else { panic!("{found:?}") };
            assert!((factor / (8.0 / 9.0) - 1.0).abs() < 0.01, "{factor}");
        }
        // Another motion on top says nothing of a ratio.
        assert_eq!(said(8.6, 0.0, 0.2), []);
    }

    /// A duty that is a multiple of what the controller asks for contradicts it; its own does not, nor one that another law makes.
    #[test]
    fn a_duty_that_is_not_the_controllers_is_told() {
        let said = |of: &dyn Fn(f64, f64) -> f64| {
            let row = |k: usize| {
                let t = 5e-3 * k as f64;
                let (goal, position) = ((2.0 * t).sin(), (2.0 * t - 0.2).sin());
                vec![t, goal, position, of(2.0 * (goal - position), t) + 0.01 * noise(k)]
            };
            let columns = [
                "time = { name = \"0\", unit = \"s\" }",
                "goal = { name = \"1\", unit = \"rad\" }",
                "output_position = { name = \"2\", unit = \"rad\" }",
                "duty = { name = \"3\", unit = \"1\" }",
            ];
            let mut bench = bench_of("servo", 9.0, &columns, &[(0..2000).map(row).collect()], 0);
            bench.logs[0].controller =
                Some(Controller { law: Law::Duty, gain: 2.0, damping: 0.0, limit: 0.9, supply: Some(12.0) });
            controller(&bench.logs[0], 9.0, false)
        };
        assert_eq!(said(&|asked, _| asked), None);
        assert_eq!(said(&|_, t| 0.3 * (3.3 * t).cos()), None);
        for factor in [0.5, 2.0, -1.0] {
            let Some(About::Controller { factor: told }) = said(&|asked, _| factor * asked) else { panic!("{factor}") };
            assert!((told / factor - 1.0).abs() < 0.05, "{factor}: {told}");
        }
    }

    /// A position that comes late is told with its lag, one that does not is not: nor at one speed, where nothing shows it.
    #[test]
    fn a_position_that_is_late_is_told() {
        let said = |lag: f64, steady: bool| {
            let row = |k: usize| {
                let t = 2e-3 * k as f64;
                let angle = |t: f64| if steady { 40.0 * t } else { 20.0 * (3.0 * t).sin() + 4.0 * (7.1 * t).cos() };
                let speed = if steady { 40.0 } else { 60.0 * (3.0 * t).cos() - 28.4 * (7.1 * t).sin() };
                vec![t, angle(t - lag), speed + noise(k), noise(k + 900), noise(k + 1900)]
            };
            late(&log_of(row), false)
        };
        for lag in [0.011, -0.02] {
            let (channel, against, told) = said(lag, false).expect("a lag");
            assert_eq!((channel, against), (Channel::MotorPosition, Channel::MotorVelocity));
            assert!((told - lag).abs() < 5e-4, "{told}");
        }
        assert_eq!(said(0.0, false), None);
        // A sample more or less is how drivers form differences.
        assert_eq!(said(0.002, false), None);
        assert_eq!(said(0.011, true), None);
    }

    /// At one speed the level says what the velocity is.
    #[test]
    fn what_turns_at_one_speed_is_compared_by_its_level() {
        let said = |factor: f64| {
            let row = |k: usize| {
                let t = 2e-3 * k as f64;
                vec![t, 40.0 * t, factor * (40.0 + 0.2 * noise(k)), noise(k + 900), noise(k + 1900)]
            };
            of_rows(row)
        };
        assert_eq!(said(1.0), []);
        assert_eq!(said(1.1), []);
        assert!(matches!(said(9.0)[..], [About::Scale { reads: Some(_), .. }]));
        assert!(matches!(said(-1.0)[..], [About::Sign { .. }]));
    }
}
