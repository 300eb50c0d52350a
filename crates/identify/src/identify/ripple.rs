//! Ripple over an angle, at the full bandwidth of the logs.
//!
//! The one idea: what repeats with an angle is a line over that angle, however fast the machine turns. So it is looked
//! for before the band is narrowed to the motion, over orders that need not be whole, and not by its share of the time
//! but by the information that each sample has. What was found is taken out at full rate; the band then sees what is left.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

use super::balance::{Balance, Setting, visible};
use super::candidates::{Candidate, evaluate};
use super::flexible::of_speed;
use super::hats::hats;
use super::orders::{Line, Ripple};
use super::regression::covariance;
use super::travel;
use super::work::{Fit, Kind, Term, Work};
use crate::Bench;
use crate::answer::Target;
use crate::signals;
use gearwise_model::effects::{EFFECTS, Effect, Equation, FittedEffect, Shape, Variable};
use gearwise_model::input::limits;
use gearwise_model::numerics::line_search::golden_section;
use gearwise_model::numerics::sums::finite_sum;

/// Share of the sampling rate that is the full band.
const FULL: f64 = 0.4;
/// Most rows that are looked at.
const ROWS: usize = 60_000;
/// Fewest periods of an order.
const PERIODS: f64 = 5.0;
/// Highest order a turn that is looked for, where the geometry asks for no higher one.
const HIGHEST: f64 = 250.0;
/// A line is this many times the median of its neighbourhood; one that the geometry lets expect less.
const LINE: (f64, f64) = (25.0, 12.0);
/// Orders on either side that are a line's neighbourhood, in steps of the spectrum.
const NEIGHBOURS: usize = 60;
/// Least share of the squared error at full bandwidth that an order takes away, and that all orders of an effect do.
const WORTH: (f64, f64) = (0.02, 0.04);
/// In standard errors between blocks.
const SURE: f64 = 2.5;
/// The statistic of an order among all that are looked at.
const STATISTIC: f64 = 15.0;
/// Least share of the rows at which an order is slower than the band.
const PASSES: f64 = 0.1;
/// A speed, or a current, that varies by a smaller share of its mean is one speed, or one current.
const STEADY: f64 = 0.1;
/// To what part of one over the turns of the motor an order is known.
const RESOLVED: f64 = 0.25;
/// Most orders.
const MOST: usize = 10;
/// Rows of a span that are enough to tell a lag.
const ENOUGH: usize = 8000;
/// Lags that are tried on either side, and their step \[s\].
const LAGS: i32 = 20;
const LAG_STEP: f64 = 5e-4;
/// Turns of the motor that one spectrum spans.
const TURNS: f64 = 256.0;

/// Looks for orders at full bandwidth. A lag that blurs them is found, too, where it `may_shift`.
pub fn find(bench: &Bench, target: Target, setting: &Setting, narrow: &Balance, may_shift: bool) -> Option<Ripple> {
    let step = narrow.slowest_fresh_step();
    if step <= 0.0 || target.equation() != Equation::Torque {
        return None;
    }
    let effects = visible_here(narrow, bench);
    if effects.is_empty() {
        return None;
    }
    let band = FULL / step;
    let balance = Balance::new(bench, target, &Setting { band: Some(band), rows: ROWS, ..setting.clone() })?;
    let mut work = Work::new(bench, balance);
    let whole = work.target.clone();
    let smooth = take_out_what_is_smooth(&mut work);
    let angles = Angles::new(&work)?;
    let geometry = Geometry::of(bench);
    let lag = angles.lag(&work, &geometry, &effects);
    if lag != 0.0 && may_shift {
        let mut corrections = setting.corrections.clone();
        corrections.motion_lag += lag;
        let setting = Setting { corrections, ..setting.clone() };
        return find(bench, target, &setting, narrow, false).map(|r| Ripple { lag, ..r });
    }
    for _ in 0..MOST {
        let Some((effect, order)) = next(&work, &angles, &geometry, &effects, band) else { break };
        let columns = work.balance.effect_columns(effect, order);
        work.terms.push(Term { kind: Kind::Effect(effect, order), columns, declared: None });
    }
    // An effect of which all orders together are worth too little has no name.
    let fit = work.fit();
    let total: f64 = finite_sum(&fit.left_out);
    let worth = |work: &Work, effect: &dyn Effect| {
        let without = work.fit_columns(&columns_without(work, effect)).left_out;
        1.0 - total / finite_sum(&without)
    };
    let small: Vec<&'static dyn Effect> =
        effects.iter().copied().filter(|e| has(&work, *e) && worth(&work, *e) < WORTH.1).collect();
    work.terms.retain(|t| !t.effect().is_some_and(|(e, _)| small.contains(&e)));
    if work.terms.is_empty() {
        return None;
    }
    // Values beside everything that is smooth, all at once.
    work.target = whole;
    let mut columns = work.columns();
    columns.extend(smooth.iter().map(Vec::as_slice));
    let fit = work.fit_columns(&columns);
    let matrix = covariance(&fit.blocks, &fit.solution, |b| work.fits(b));
    let mut lines = Vec::new();
    for (t, term) in work.terms.iter().enumerate() {
        let Some((effect, order)) = term.effect() else { continue };
        let k = work.offset(t);
        let values = vec![fit.solution.coefficients[k], fit.solution.coefficients[k + 1], order];
        let own = |i: usize, j: usize| matrix[(k + i, k + j)];
        let twins = effects.iter().copied().filter(|e| *e != effect && geometry.is_twin(effect, order, *e, &angles));
        lines.push(Line {
            fitted: FittedEffect { effect, values },
            covariance: [[own(0, 0), own(0, 1)], [own(1, 0), own(1, 1)]],
            twins: twins.collect(),
        });
    }
    let errors = |columns: &[&[f64]], fit: &Fit| {
        let error = |fitting| work.error(columns, fit, fitting).map(|e| e.0);
        (error(true), error(false))
    };
    let after = errors(&columns, &fit);
    let without = effects
        .iter()
        .filter(|e| has(&work, **e))
        .map(|e| {
            let mut columns = columns_without(&work, *e);
            columns.extend(smooth.iter().map(Vec::as_slice));
            let fit = work.fit_columns(&columns);
            let (fitted, held_out) = errors(&columns, &fit);
            (*e, fitted, held_out)
        })
        .collect();
    Some(Ripple { lines, lag: 0.0, band, after, without })
}

/// Effects with orders that a balance shows.
fn visible_here(balance: &Balance, bench: &Bench) -> Vec<&'static dyn Effect> {
    let shows = |e: &&'static dyn Effect| e.shape() == Shape::Order && visible(*e, balance, &bench.declared).is_ok();
    EFFECTS.iter().copied().filter(shows).collect()
}

/// Other effects that have the same columns as an order of one, by the geometry.
pub fn twins(work: &Work, effect: &'static dyn Effect, order: f64) -> Vec<&'static dyn Effect> {
    let (Some(angles), geometry) = (Angles::new(work), Geometry::of(work.bench)) else { return Vec::new() };
    let is_twin = |e: &&'static dyn Effect| *e != effect && geometry.is_twin(effect, order, *e, &angles);
    visible_here(&work.balance, work.bench).into_iter().filter(is_twin).collect()
}

fn has(work: &Work, effect: &dyn Effect) -> bool {
    work.terms.iter().any(|t| t.effect().is_some_and(|(e, _)| *e == *effect))
}

fn columns_without<'w>(work: &'w Work, effect: &dyn Effect) -> Vec<&'w [f64]> {
    let others = work.terms.iter().filter(|t| !t.effect().is_some_and(|(e, _)| *e == *effect));
    others.flat_map(|t| &t.columns).map(Vec::as_slice).collect()
}

/// Leaves of the target what neither the declared model nor any function of speed or of current makes up; the columns that
/// were taken out.
fn take_out_what_is_smooth(work: &mut Work) -> Vec<Vec<f64>> {
    let balance = work.balance.clone();
    let mut smooth = of_speed(work);
    smooth.push(balance.function(|_| 1.0));
    if balance.variables.contains(&Variable::Current) && !balance.is_response(Variable::Current) {
        let values = balance.variable(false, |at| at.current);
        smooth.extend(hats(&balance.rows, &values).iter().map(|hat| balance.function(|at| hat(at.current))));
    }
    smooth.retain(|c| c.iter().all(|v| v.is_finite()) && c.iter().any(|v| *v != 0.0));
    let mut columns = work.columns();
    columns.extend(smooth.iter().map(Vec::as_slice));
    let fit = work.fit_columns(&columns);
    let left = work.left_by(&columns, &fit);
    let taken = columns.into_iter().map(<[f64]>::to_vec).collect();
    work.target = left;
    work.terms.clear();
    taken
}

/// What the declared geometry says of orders.
struct Geometry {
    poles: f64,
    ratio: f64,
}

impl Geometry {
    fn of(bench: &Bench) -> Geometry {
        let poles = bench.declared.motor.as_ref().and_then(|m| m.pole_pairs).map_or(0.0, f64::from);
        Geometry { poles, ratio: bench.declared.ratio }
    }

    /// The highest order of the motor.
    fn highest(&self) -> f64 {
        HIGHEST.max(12.0 * self.poles).max(2.0 * self.ratio).min(limits::ORDER)
    }

    /// Whether an order of the motor is one that a motor of these poles, or a gear, usually has.
    fn expects(&self, order: f64, resolution: f64) -> bool {
        let of_poles = [1.0, 2.0, 6.0, 12.0].map(|k| k * self.poles);
        let usual = [1.0, 2.0, 4.0, 1.0 / self.ratio, 2.0 / self.ratio];
        of_poles.into_iter().chain(usual).any(|h| h > 0.0 && (order - h).abs() < 2.0 * resolution)
    }

    /// Whether another effect has the same columns in these logs: on the other side of the gear, or with a current that hardly
    /// changes.
    fn is_twin(&self, effect: &dyn Effect, order: f64, other: &dyn Effect, angles: &Angles) -> bool {
        let of_current = |e: &dyn Effect| e.needs().contains(&Variable::Current);
        if of_current(effect) != of_current(other) && !angles.one_current {
            return false;
        }
        if of_output(effect) == of_output(other) {
            return of_current(effect) != of_current(other);
        }
        let seen = if of_output(effect) { order / self.ratio } else { order * self.ratio };
        // An order is known to a part of one over the turns that were made.
        let known = RESOLVED / angles.turns.max(1.0) * if of_output(other) { self.ratio } else { 1.0 };
        (seen - seen.round()).abs() < (1e-3 * seen.max(1.0)).max(known.min(0.2)) && seen.round() >= 1.0
    }
}

/// The angle of the motor at each row, and where a log's rows lie.
struct Angles {
    angle: Vec<f64>,
    speed: Vec<f64>,
    current: Vec<f64>,
    /// Rows of one spectrum each.
    spans: Vec<Vec<usize>>,
    /// Turns of the widest span.
    turns: f64,
    /// Whether speed, and current, hardly change: then an order is a line in time too, and the current a number.
    one_speed: bool,
    one_current: bool,
}

impl Angles {
    fn new(work: &Work) -> Option<Angles> {
        let rows = &work.balance.rows;
        let angle = work.balance.variable(false, |at| at.angle);
        let speed = work.balance.variable(false, |at| at.speed);
        let current = work.balance.variable(false, |at| if at.current.is_finite() { at.current } else { 0.0 });
        let mut spans: Vec<Vec<usize>> = Vec::new();
        for log in 0..rows.logs() {
            let own: Vec<usize> =
                (0..rows.len()).filter(|k| rows.log[*k] == log && work.fits(rows.block[*k])).collect();
            let mut span: Vec<usize> = Vec::new();
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for k in own {
                if !angle[k].is_finite() {
                    return None;
                }
                (low, high) = (low.min(angle[k]), high.max(angle[k]));
                if high - low > TURNS * TAU {
                    spans.push(std::mem::take(&mut span));
                    (low, high) = (angle[k], angle[k]);
                }
                span.push(k);
            }
            spans.push(span);
        }
        spans.retain(|s| s.len() > 64);
        let turns = spans.iter().map(|s| width(&angle, s) / TAU).fold(0.0, f64::max);
        let steady = |values: &[f64]| {
            let all: Vec<f64> = spans.iter().flatten().map(|k| values[*k]).collect();
            let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
            let square = all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / all.len().max(1) as f64;
            square.sqrt() < STEADY * mean.abs()
        };
        let (one_speed, one_current) = (steady(&speed), steady(&current));
        (turns > 0.0).then_some(Angles { angle, speed, current, spans, turns, one_speed, one_current })
    }

    /// Power over orders of the motor, equally spaced, of what is left times a factor.
    fn spectrum(&self, left: &[f64], factor: impl Fn(usize) -> f64, highest: f64) -> (f64, Vec<f64>) {
        // So many bins a turn that the highest order keeps its power, and so many turns that orders are resolved.
        let bins = 4.0 * highest;
        let length = ((2.0 * self.turns.max(1.0)) * bins).max(64.0) as usize;
        let length = length.next_power_of_two();
        let spacing = bins / length as f64;
        let mut planner = RealFftPlanner::<f64>::new();
        let fft = planner.plan_fft_forward(length);
        let count = ((highest / spacing) as usize).min(length / 2);
        let mut power = vec![0.0; count];
        for span in &self.spans {
            let low = span.iter().map(|k| self.angle[*k]).fold(f64::INFINITY, f64::min);
            let mut over = vec![0.0; length];
            for k in span {
                let at = ((self.angle[*k] - low) / TAU * bins) as usize;
                over[at.min(length - 1)] += left[*k] * factor(*k);
            }
            let mut out = fft.make_output_vec();
            if fft.process(&mut over, &mut out).is_ok() {
                power.iter_mut().zip(&out).for_each(|(p, c)| *p += c.norm_sqr());
            }
        }
        (spacing, power)
    }

    /// The lag \[s\] at which an order that the geometry lets expect stands out, where without it none does.
    fn lag(&self, work: &Work, geometry: &Geometry, effects: &[&'static dyn Effect]) -> f64 {
        let with_current = effects.iter().any(|e| e.needs().contains(&Variable::Current));
        let left = &work.weighed(work.target.clone());
        let orders = [2.0, 6.0, 12.0].map(|k| k * geometry.poles);
        let (mut best, mut now) = ((0.0, 0.0_f64), 0.0_f64);
        for order in orders.into_iter().filter(|h| *h > 0.0) {
            for of_current in [false, true] {
                if of_current && !with_current {
                    continue;
                }
                let factor = |k: usize| if of_current { self.current[k] } else { 1.0 };
                // What stands beside the order says how much is chance.
                let beside: Vec<f64> = [-7.3, -4.6, -3.1, 3.4, 4.9, 7.7]
                    .map(|d| self.power(left, &factor, order + d / self.turns.max(1.0), 0.0, ENOUGH))
                    .to_vec();
                let usual = signals::median(beside).unwrap_or(0.0);
                if usual <= 0.0 {
                    continue;
                }
                for k in -LAGS..=LAGS {
                    let lag = f64::from(k) * LAG_STEP;
                    let times = self.power(left, &factor, order, lag, ENOUGH) / usual;
                    if k == 0 {
                        now = now.max(times);
                    }
                    if times > best.1 {
                        best = (lag, times);
                    }
                }
            }
        }
        if best.1 > 2.0 * LINE.0 && best.1 > 1.5 * now { best.0 } else { 0.0 }
    }

    /// Share of the rows at which an order is slower than the band: what is faster is seen as something slower.
    fn passes(&self, order: f64, band: f64) -> f64 {
        let rows = || self.spans.iter().flatten();
        let slow = rows().filter(|k| order * self.speed[**k].abs() < TAU * band).count();
        slow as f64 / rows().count().max(1) as f64
    }

    /// Power of what is left at one order, with the angle so much later \[s\], over at most so many rows of a span.
    fn power(&self, left: &[f64], factor: &dyn Fn(usize) -> f64, order: f64, lag: f64, most: usize) -> f64 {
        let one = |span: &Vec<usize>| {
            let (mut a, mut b) = (0.0, 0.0);
            for k in span.iter().step_by(1 + span.len() / most) {
                let (sine, cosine) = (order * (self.angle[*k] + lag * self.speed[*k])).sin_cos();
                let value = left[*k] * factor(*k);
                a += value * cosine;
                b += value * sine;
            }
            a * a + b * b
        };
        self.spans.iter().map(one).sum()
    }
}

fn width(angle: &[f64], span: &[usize]) -> f64 {
    let (low, high) =
        span.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), k| (l.min(angle[*k]), h.max(angle[*k])));
    high - low
}

/// The next order that stands out, as the effect that explains it best.
fn next(
    work: &Work,
    angles: &Angles,
    geometry: &Geometry,
    effects: &[&'static dyn Effect],
    band: f64,
) -> Option<(&'static dyn Effect, f64)> {
    let fit = work.fit();
    let left = work.weighed(work.residual(&fit));
    let highest = geometry.highest();
    let least = PERIODS / angles.turns;
    let with_current = effects.iter().any(|e| e.needs().contains(&Variable::Current));
    let mut orders: Vec<(f64, f64)> = Vec::new();
    for of_current in [false, true] {
        if of_current && !with_current {
            continue;
        }
        let factor = |k: usize| if of_current { angles.current[k] } else { 1.0 };
        let (spacing, power) = angles.spectrum(&left, factor, highest);
        let resolution = 1.0 / angles.turns.max(1.0);
        for (at, times) in peaks(&power) {
            let order = at as f64 * spacing;
            let needed = if geometry.expects(order, resolution) { LINE.1 } else { LINE.0 };
            if order < least || times < needed || angles.passes(order, band) < PASSES {
                continue;
            }
            let score = |h: f64| -angles.power(&left, &factor, h, 0.0, usize::MAX);
            let refined = golden_section(&score, order - spacing, order + spacing, 18);
            orders.push((refined, times));
        }
    }
    orders.sort_by(|a, b| b.1.total_cmp(&a.1));
    orders.truncate(6);
    let mut best: Option<Candidate> = None;
    for (order, _) in orders {
        for effect in effects.iter().copied() {
            let Some(order) = on_side(effect, order, geometry, angles) else { continue };
            // Once a turn of the output is gravity first: the band is for that.
            if of_output(effect) && order < 1.5 {
                continue;
            }
            let taken = work.terms.iter().any(|t| {
                t.effect()
                    .is_some_and(|(e, h)| e == effect && (h - order).abs() < 1.5 / angles.turns * scale_of(e, geometry))
            });
            if taken {
                continue;
            }
            let Some(candidate) = evaluate(work, &fit, effect, order) else { continue };
            let earns = candidate.gain > WORTH.0 && candidate.sure > SURE && candidate.scores.statistic() > STATISTIC;
            if !earns || candidate.effect.plausible(&candidate.values, &work.balance.scale).is_err() {
                continue;
            }
            // The simpler of two that do nearly as well: they are in that order.
            if best.as_ref().is_some_and(|b| candidate.gain < 1.02 * b.gain + 1e-3) {
                continue;
            }
            if travel::of(work, &candidate.columns).is_ok() {
                best = Some(candidate);
            }
        }
    }
    best.map(|c| (c.effect, c.shape))
}

fn of_output(effect: &dyn Effect) -> bool {
    effect.needs().contains(&Variable::OutputAngle)
}

/// Orders of an effect a turn of the motor.
fn scale_of(effect: &dyn Effect, geometry: &Geometry) -> f64 {
    if of_output(effect) { geometry.ratio } else { 1.0 }
}

/// An order of the motor as one of an effect: whole where it is whole within what the logs resolve. What is no whole order of
/// the motor is none of its magnets and slots.
fn on_side(effect: &dyn Effect, order: f64, geometry: &Geometry, angles: &Angles) -> Option<f64> {
    let scale = scale_of(effect, geometry);
    let own = order * scale;
    let resolution = scale / angles.turns.max(1.0);
    let whole = own.round();
    let off = (own - whole).abs();
    let is_whole = whole >= 1.0 && off < (0.6 * resolution).max(1e-3 * own).min(0.2);
    let snapped = if whole >= 1.0 && off < RESOLVED * resolution && off < 0.2 { whole } else { own };
    // At one speed a line over the angle is a line in time, which only a whole order tells from a hum.
    if angles.one_speed && (whole < 1.0 || off > 0.6 * resolution) {
        return None;
    }
    match (!of_output(effect), is_whole) {
        (true, true) | (false, _) => Some(snapped),
        (true, false) => None,
    }
}

/// Peaks of a spectrum with how many times the median of their neighbourhood they are, the highest first.
fn peaks(power: &[f64]) -> Vec<(usize, f64)> {
    let mut found = Vec::new();
    for k in 2..power.len().saturating_sub(2) {
        let p = power[k];
        if p <= 0.0 || p < power[k - 1] || p <= power[k + 1] || p < power[k - 2] || p < power[k + 2] {
            continue;
        }
        // A cheap look first: most peaks are none.
        let near: f64 = power[k.saturating_sub(12)..(k + 13).min(power.len())].iter().sum::<f64>() / 25.0;
        if p < 2.0 * near {
            continue;
        }
        let (from, to) = (k.saturating_sub(NEIGHBOURS), (k + NEIGHBOURS + 1).min(power.len()));
        let around = (from..to).filter(|j| j.abs_diff(k) > 3).map(|j| power[j]).collect();
        let usual = signals::median(around).unwrap_or(0.0);
        if usual > 0.0 {
            found.push((k, p / usual));
        }
    }
    found.sort_by(|a: &(usize, f64), b| b.1.total_cmp(&a.1));
    found.truncate(24);
    found
}

#[cfg(test)]
mod tests {
    use super::super::steady::{CONSTANT, OVER_TIME, bench_of, noise};
    use super::*;

    /// Effects and orders that are found where torque at the output waves so much \[N·m\] so often a turn of the motor.
    fn found(amplitude: f64, order: f64, ratio: f64) -> Vec<(&'static str, f64)> {
        let row = |k: usize| {
            let t = 2e-3 * k as f64;
            let (speed, angle) = (6.0 + 2.0 * (0.9 * t).sin(), 6.0 * t - 2.0 / 0.9 * (0.9 * t).cos());
            let i = 2.0 * (1.7 * t).sin();
            let torque = ratio * (CONSTANT * i + amplitude * (order * angle).cos());
            vec![t, speed, i, torque + 0.02 * noise(k), angle]
        };
        let position = "motor_position = { name = \"4\", unit = \"rad\" }";
        let columns: Vec<&str> = OVER_TIME.iter().copied().chain([position]).collect();
        let bench = bench_of("dynamometer", ratio, &columns, &[(0..10_000).map(row).collect()], 0);
        // The band ends far below what order 42 has at 6 rad/s: 40 Hz.
        let setting = Setting::uncorrected(&bench, Some(8.0));
        let narrow = Balance::new(&bench, Target::Torque, &setting).expect("rows");
        let found = find(&bench, Target::Torque, &setting, &narrow, false);
        found.iter().flat_map(|r| &r.lines).map(|l| (l.fitted.effect.name(), l.fitted.values[2])).collect()
    }

    #[test]
    fn orders_far_above_the_band_are_found_and_none_where_nothing_waves() {
        for order in [42.0, 137.0] {
            let [(name, told)] = found(0.01, order, 6.0)[..] else { panic!("{order}") };
            assert!(name == "cogging" && told == order, "{name} {told}");
        }
        assert!(found(0.0, 42.0, 6.0).is_empty());
    }

    #[test]
    fn an_order_of_the_output_is_one_of_the_gear() {
        let [(name, told)] = found(0.01, 15.0 / 6.3, 6.3)[..] else { panic!("one") };
        assert!(name == "gear_ripple" && (told - 15.0).abs() < 0.05, "{name} {told}");
    }
}
