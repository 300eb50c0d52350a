//! Bounds with a weakened field, on an interval of ratios.
//!
//! The one idea: at a ratio the current along d of every sample is the least that keeps the voltage, and a bound of its square
//! from below is a polynomial that holds on an interval ([`least_square`]). Added to the rows and cuts without weakening it
//! gives rows and cuts of the same kind, which the branch and bound takes as they are; they touch as intervals shrink. A row
//! in which such a current helps (power that comes back) is left out: what is ruled out is ruled out without it.

use std::collections::BTreeMap;

use super::objective::Goal;
use super::underestimate::Underestimator;
use super::{Class, Limited, RatioProgram};
use crate::actuator::limits::{Asked, Candidate, Demand};
use crate::actuator::supply::Drawn;
use crate::actuator::waveform::{Functional, WavePoint, Waveform};
use crate::actuator::weakening::{AlongD, braking_square, least_square, voltage_row};
use crate::actuator::{Actuator, Laurent};
use crate::design::evaluate::violation;
use crate::requirement::Quantity;

/// A lower bound of a sample's squared current along d, times K_T², on an interval: the better of both ends of the drag; nothing
/// where none is needed at the ratio inside.
fn direct_square(candidate: &Candidate, point: &WavePoint, ratio: f64, interval: (f64, f64)) -> Option<Laurent> {
    let (along, sample) = (candidate.along_d()?, (point.flow, &point.features));
    let bound = candidate.voltage_squared("voltage");
    let of_ends = candidate.ends().filter_map(|end| match along {
        AlongD::Weakening(_) => least_square(end, sample, bound, ratio, interval),
        AlongD::Braking { beyond, .. } => Some(braking_square(end, sample, beyond)),
    });
    let larger = of_ends.reduce(|x, y| if y.at(ratio) > x.at(ratio) { y } else { x });
    larger.filter(|square| square.at(ratio) > 0.0)
}

/// The cut of the objective at a ratio, from below on the interval around it.
pub(super) fn cut(program: &RatioProgram, goal: &Goal, ratio: f64, interval: (f64, f64)) -> Laurent {
    let candidate = &program.prepared.candidate;
    let weight = |quantity| program.objective.weight(quantity);
    let actuator = &candidate.actuator;
    let mut cut = goal.cut(ratio);
    if program.objective.sole() == Some(Quantity::PeakCurrent) {
        // In its square: that of the sample with the most.
        let (largest, of_peak) = peak(candidate, actuator, ratio, interval);
        return if largest > cut.at(ratio) { of_peak } else { cut };
    }
    let drawn = Drawn::new(&candidate.robot.bus);
    let copper = actuator.heating();
    let both = copper + actuator.conduction();
    let duration = candidate.load.duration.unwrap_or(0.0);
    for (point, share) in candidate.load.means() {
        let Some(square) = direct_square(candidate, point, ratio, interval) else { continue };
        let power = actuator.power(actuator.loss_given(), point.flow, &point.features).at(ratio);
        // What is drawn is convex in the power: its slope where nothing is added is the least.
        let (slope, _) = drawn.line(power);
        let each = weight(Quantity::CopperLoss) * copper
            + weight(Quantity::Loss) * both * slope
            + weight(Quantity::Energy) * duration * both * slope;
        cut = cut + square * (each * share);
    }
    cut
}

/// The largest squared current of all samples at a ratio, times K_T², and its bound on the interval.
fn peak(candidate: &Candidate, actuator: &Actuator, ratio: f64, interval: (f64, f64)) -> (f64, Laurent) {
    let waveform = &candidate.load.waveform;
    let mut best = (f64::NEG_INFINITY, Laurent::default());
    for point in (0..waveform.len()).map(|k| waveform.point(k)) {
        let own = actuator.torque_squared(point.flow, &point.features);
        let all = match direct_square(candidate, &point, ratio, interval) {
            Some(square) => own + square,
            None => own,
        };
        let here = all.at(ratio);
        if here > best.0 {
            best = (here, all);
        }
    }
    best
}

/// Of each sample the points among some that belong to it, as indices.
fn by_sample(waveform: &Waveform) -> BTreeMap<usize, Vec<usize>> {
    let mut points: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    (0..waveform.len()).for_each(|k| points.entry(waveform.origin(k)).or_default().push(k));
    points
}

/// The row of the squared voltage with currents that burn power that comes back, by its worst point at a ratio: with at most the
/// largest current that flows on the interval, at any point of the sample and either end of the drag.
fn braked_voltage(
    candidate: &Candidate,
    waveform: &Waveform,
    actuator: &Actuator,
    ratio: f64,
    interval: (f64, f64),
) -> Laurent {
    let Some(AlongD::Braking { beyond, .. }) = candidate.along_d() else { return Laurent::default() };
    let mut worst = (f64::NEG_INFINITY, Laurent::default());
    for points in by_sample(waveform).into_values() {
        let points: Vec<WavePoint> = points.into_iter().map(|k| waveform.point(k)).collect();
        let most = |point: &WavePoint| {
            let of_end = |end| most_of(&braking_square(end, (point.flow, &point.features), beyond), interval);
            candidate.ends().map(of_end).fold(0.0, f64::max)
        };
        let most = points.iter().map(most).fold(0.0, f64::max).sqrt();
        for point in &points {
            let row = match most > 0.0 {
                true => voltage_row(actuator, (point.flow, &point.features), most, ratio, interval),
                false => actuator.voltage_squared(point.flow, &point.features),
            };
            let here = row.at(ratio);
            if here > worst.0 {
                worst = (here, row);
            }
        }
    }
    worst.1
}

/// The row of the squared current with the superposed torque, times K_T²: of a sample the largest along q and the largest that
/// burns power.
fn braked_ripple(candidate: &Candidate, actuator: &Actuator, ratio: f64, interval: (f64, f64)) -> Option<Laurent> {
    let waveform = candidate.load.bandwidth.as_ref()?;
    let larger = |a: Laurent, b: Laurent| if b.at(ratio) > a.at(ratio) { b } else { a };
    let of_sample = |points: Vec<usize>| {
        let points = || points.iter().map(|k| waveform.point(*k));
        let along_q = points().map(|p| actuator.torque_squared(p.flow, &p.features)).reduce(larger)?;
        let along_d = points().filter_map(|p| direct_square(candidate, &p, ratio, interval)).reduce(larger);
        Some(along_d.map_or(along_q, |square| along_q + square))
    };
    by_sample(waveform).into_values().filter_map(of_sample).reduce(larger)
}

/// A bound of a polynomial from above on an interval of ratios.
fn most_of(polynomial: &Laurent, (a, b): (f64, f64)) -> f64 {
    let under = Underestimator::new(&(*polynomial * -1.0), a, b);
    1e-12 * under.size - under.at(under.minimum(a, b))
}

/// The most violated row at a ratio, where one is: it holds on the interval.
pub(super) fn worst_row(program: &RatioProgram, ratio: f64, interval: (f64, f64)) -> Option<(Laurent, f64)> {
    program.most_violated(|_, Limited { candidate, asked }| {
        if asked.limit.class != Class::Convex {
            return None;
        }
        let row = row(candidate, asked, ratio, interval)?;
        Some((row, violation(row.at(ratio), asked.raw_bound())))
    })
}

/// The row of a limit, by its worst sample at a ratio.
fn row(candidate: &Candidate, asked: &Asked, ratio: f64, interval: (f64, f64)) -> Option<Laurent> {
    let actuator = candidate.end(asked.end);
    let load = candidate.load;
    let squares = |standing: f64| {
        let shares = load.means().zip(load.rests()).map(|((point, share), (_, rest))| (point, share + standing * rest));
        let mut sum = Laurent::default();
        for (point, share) in shares.filter(|(_, share)| *share > 0.0) {
            if let Some(square) = direct_square(candidate, point, ratio, interval) {
                sum = sum + square * share;
            }
        }
        sum * load.share_of_time
    };
    match asked.demand {
        Demand::Samples(functional @ Functional::LeastVoltage(most)) => {
            let point = load.waveform.point(load.waveform.largest(functional, actuator, ratio).index);
            Some(voltage_row(actuator, (point.flow, &point.features), most, ratio, interval))
        }
        Demand::Samples(Functional::VoltageSquared) => {
            Some(braked_voltage(candidate, &load.waveform, actuator, ratio, interval))
        }
        // The motor's torque has no part in it, the current has.
        Demand::Samples(Functional::TorqueSquared) if asked.limit.is_q_axis() => {
            Some(peak(candidate, actuator, ratio, interval).1)
        }
        Demand::Samples(Functional::Power) => {
            let point = load.waveform.point(load.waveform.largest(Functional::Power, actuator, ratio).index);
            let own = actuator.power(actuator.loss_taken(), point.flow, &point.features);
            let more = direct_square(candidate, &point, ratio, interval);
            Some(more.map_or(own, |square| own + square * actuator.loss_taken()))
        }
        // Means of heat.
        Demand::Polynomial(mean, _) => Some(mean + squares(asked.standing)),
        // All phases have one current; that each has its own is less to ask for.
        Demand::Bandwidth(Functional::VoltageSquared) => {
            let waveform = load.bandwidth.as_ref()?;
            let Some(most) = candidate.weakening().map(|most| most * actuator.torque_constant) else {
                return Some(braked_voltage(candidate, waveform, actuator, ratio, interval));
            };
            let point = waveform.point(waveform.largest(Functional::LeastVoltage(most), actuator, ratio).index);
            Some(voltage_row(actuator, (point.flow, &point.features), most, ratio, interval))
        }
        Demand::Bandwidth(Functional::TorqueSquared) if candidate.weakening().is_none() => {
            braked_ripple(candidate, actuator, ratio, interval)
        }
        _ => asked.polynomial_at(candidate, ratio).map(|(row, _)| row),
    }
}
