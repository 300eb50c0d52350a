//! Bounds with a weakened field, on an interval of ratios.
//!
//! The one idea: at a ratio the current along d of every sample is the least that keeps the voltage, and a bound of its square
//! from below is a polynomial that holds on an interval ([`least_square`]). Added to the rows and cuts without weakening it
//! gives rows and cuts of the same kind, which the branch and bound takes as they are; they touch as intervals shrink. A row
//! in which such a current helps (power that comes back) is left out: what is ruled out is ruled out without it.

use super::objective::Goal;
use super::underestimate::Underestimator;
use super::{Class, Limited, RatioProgram};
use crate::evaluate::violation;
use gearwise_model::actuator::limits::{Asked, Candidate, Demand};
use gearwise_model::actuator::supply::Drawn;
use gearwise_model::actuator::waveform::{Functional, WavePoint, Waveform};
use gearwise_model::actuator::weakening::{AlongD, braking_square, least_square, voltage_row};
use gearwise_model::actuator::{Actuator, Laurent};
use gearwise_model::requirement::Quantity;

/// A point with a lower bound of its squared current along d, times K_T², on an interval.
type Square = (usize, Laurent);

/// Where bounds are made: they touch at a ratio inside an interval.
#[derive(Clone, Copy)]
struct At {
    ratio: f64,
    interval: (f64, f64),
}

impl At {
    /// A lower bound of a point's squared current along d: the better of both ends of the drag; nothing where none is needed at the
    /// ratio inside.
    fn square(self, candidate: &Candidate, along: AlongD, point: &WavePoint) -> Option<Laurent> {
        let sample = (point.flow, &point.features);
        let bound = candidate.voltage_squared("voltage");
        let of_end = |end: &Actuator| match along {
            AlongD::Weakening(_) => {
                let rows = end.windings().map(|end| least_square(&end, sample, bound, self.ratio, self.interval));
                rows.into_iter().flatten().reduce(|x, y| self.larger(x, y))
            }
            AlongD::Braking { beyond, .. } => Some(braking_square(end, sample, beyond)),
        };
        let larger = candidate.ends().filter_map(of_end).reduce(|x, y| self.larger(x, y));
        larger.filter(|square| square.at(self.ratio) > 0.0)
    }

    /// Those of all points that need one at the ratio inside.
    fn squares(self, candidate: &Candidate, waveform: &Waveform) -> Vec<Square> {
        let Some(along) = candidate.along_d() else { return Vec::new() };
        let square = |k: usize| Some((k, self.square(candidate, along, &waveform.point(k))?));
        let points = candidate.needs_along_d(self.ratio).map_or(Vec::new(), |needs| needs.points(waveform));
        points.into_iter().filter_map(square).collect()
    }

    fn larger(self, a: Laurent, b: Laurent) -> Laurent {
        if b.at(self.ratio) > a.at(self.ratio) { b } else { a }
    }

    /// The row of the least squared voltage that a current of at most `most` \[N·m\] along d leaves, by its worst point and winding.
    fn least_voltage(self, actuator: &Actuator, waveform: &Waveform, most: f64) -> Laurent {
        let point = waveform.point(waveform.largest(Functional::LeastVoltage(most), actuator, self.ratio).index);
        let sample = (point.flow, &point.features);
        let [hot, cold] =
            actuator.windings().map(|winding| voltage_row(&winding, sample, most, self.ratio, self.interval));
        self.larger(hot, cold)
    }

    /// The largest squared current of all samples, times K_T².
    fn peak(self, candidate: &Candidate, actuator: &Actuator, squares: &[Square]) -> Laurent {
        let waveform = &candidate.load.waveform;
        let own = |k: usize| {
            let point = waveform.point(k);
            actuator.torque_squared(point.flow, &point.features)
        };
        let plain = own(waveform.largest(Functional::TorqueSquared, actuator, self.ratio).index);
        squares.iter().map(|(k, square)| own(*k) + *square).fold(plain, |a, b| self.larger(a, b))
    }

    /// The row of the squared voltage with currents that burn power that comes back, by its worst point: with at most the largest
    /// current that flows on the interval, at any point of the sample and either end of the drag.
    fn braked_voltage(self, candidate: &Candidate, waveform: &Waveform, asked: &Asked) -> Option<Laurent> {
        let Some(AlongD::Braking { beyond, .. }) = candidate.along_d() else { return None };
        let actuator = candidate.end(asked.end);
        let windings = actuator.windings();
        let burns = |k: usize| {
            let point = waveform.point(k);
            let of_end = |end| most_of(&braking_square(end, (point.flow, &point.features), beyond), self.interval);
            candidate.ends().map(of_end).fold(0.0, f64::max)
        };
        let most_of_sample = |sample| waveform.of_sample(sample).iter().map(|k| burns(*k)).fold(0.0, f64::max).sqrt();
        let mut worst: Option<Laurent> = None;
        let mut offer = |row| worst = Some(worst.map_or(row, |worst| self.larger(worst, row)));
        for sample in waveform.samples() {
            let most = most_of_sample(sample);
            for k in waveform.of_sample(sample) {
                let point = waveform.point(*k);
                for winding in &windings {
                    offer(match most > 0.0 {
                        true => voltage_row(winding, (point.flow, &point.features), most, self.ratio, self.interval),
                        false => winding.voltage_squared_near(point.flow, &point.features, self.ratio),
                    });
                }
            }
        }
        worst
    }

    /// The row of the squared current with the superposed torque, times K_T²: of a sample the largest along q and the largest that
    /// burns power.
    fn braked_ripple(self, candidate: &Candidate, actuator: &Actuator) -> Option<Laurent> {
        let waveform = candidate.load.bandwidth.as_ref()?;
        let own = |k: usize| {
            let point = waveform.point(k);
            actuator.torque_squared(point.flow, &point.features)
        };
        let plain = own(waveform.largest(Functional::TorqueSquared, actuator, self.ratio).index);
        let of_sample = |(k, square): Square| {
            let points = waveform.of_sample(waveform.origin(k)).iter();
            points.map(|k| own(*k)).reduce(|a, b| self.larger(a, b)).map(|along_q| along_q + square)
        };
        Some(self.squares(candidate, waveform).into_iter().filter_map(of_sample).fold(plain, |a, b| self.larger(a, b)))
    }

    /// The row of a limit, by its worst sample.
    fn row(self, candidate: &Candidate, asked: &Asked, squares: &[Square]) -> Option<Laurent> {
        let At { ratio, .. } = self;
        let actuator = candidate.end(asked.end);
        let load = candidate.load;
        match asked.demand {
            Demand::Samples(Functional::LeastVoltage(most)) => Some(self.least_voltage(actuator, &load.waveform, most)),
            Demand::Samples(Functional::VoltageSquared) => self.braked_voltage(candidate, &load.waveform, asked),
            // The motor's torque has no part in it, the current has.
            Demand::Samples(Functional::TorqueSquared) if asked.limit.is_q_axis() => {
                Some(self.peak(candidate, actuator, squares))
            }
            Demand::Samples(Functional::Power) => {
                let index = load.waveform.largest(Functional::Power, actuator, ratio).index;
                let point = load.waveform.point(index);
                let own = actuator.power_near(actuator.loss_taken(), point.flow, &point.features, ratio);
                let more = squares.iter().find(|(k, _)| *k == index);
                Some(more.map_or(own, |(_, square)| own + *square * actuator.loss_taken()))
            }
            // Means of heat.
            Demand::Polynomial(mean, _) => {
                let share = |k: usize| load.share(load.waveform.origin(k), asked.standing) * load.share_of_time;
                Some(squares.iter().fold(mean, |sum, (k, square)| sum + *square * share(*k)))
            }
            // All phases have one current; that each has its own is less to ask for.
            Demand::Bandwidth(Functional::VoltageSquared) => {
                let waveform = load.bandwidth.as_ref()?;
                let Some(most) = candidate.weakening().map(|most| most * actuator.torque_constant) else {
                    return self.braked_voltage(candidate, waveform, asked);
                };
                Some(self.least_voltage(actuator, waveform, most))
            }
            Demand::Bandwidth(Functional::TorqueSquared) if candidate.weakening().is_none() => {
                self.braked_ripple(candidate, actuator)
            }
            _ => asked.polynomial_at(candidate, ratio).map(|(row, _)| row),
        }
    }
}

/// The cut of the objective at a ratio, from below on the interval around it.
pub(super) fn cut(program: &RatioProgram, goal: &Goal, ratio: f64, interval: (f64, f64)) -> Laurent {
    let (at, candidate) = (At { ratio, interval }, &program.prepared.candidate);
    let weight = |quantity| program.objective.weight(quantity);
    let actuator = &candidate.actuator;
    let load = candidate.load;
    let squares = at.squares(candidate, &load.waveform);
    let mut cut = goal.cut(ratio);
    if program.objective.sole() == Some(Quantity::PeakCurrent) {
        // In its square: that of the sample with the most.
        return at.larger(cut, at.peak(candidate, actuator, &squares));
    }
    let drawn = Drawn::new(&candidate.robot.bus);
    let copper = actuator.heating();
    let both = copper + actuator.conduction();
    let duration = load.duration.unwrap_or(0.0);
    for (k, square) in squares {
        let point = load.waveform.point(k);
        let power = actuator.power(actuator.loss_given(), point.flow, &point.features).at(ratio);
        // What is drawn is convex in the power: its slope where nothing is added is the least.
        let (slope, _) = drawn.line(power);
        let each = weight(Quantity::CopperLoss) * copper
            + weight(Quantity::Loss) * both * slope
            + weight(Quantity::Energy) * duration * both * slope;
        cut = cut + square * (each * load.share(point.origin, 0.0));
    }
    cut
}

/// A bound of a polynomial from above on an interval of ratios.
fn most_of(polynomial: &Laurent, (a, b): (f64, f64)) -> f64 {
    let under = Underestimator::new(&(*polynomial * -1.0), a, b);
    1e-12 * under.size - under.at(under.minimum(a, b))
}

/// The most violated row at a ratio, where one is: it holds on the interval.
pub(super) fn worst_row(program: &RatioProgram, ratio: f64, interval: (f64, f64)) -> Option<(Laurent, f64)> {
    let at = At { ratio, interval };
    let mut of_candidates: Vec<(&Candidate, Vec<Square>)> = Vec::new();
    for Limited { candidate, .. } in &program.limits {
        if !of_candidates.iter().any(|(known, _)| std::ptr::eq(*known, *candidate)) {
            of_candidates.push((candidate, at.squares(candidate, &candidate.load.waveform)));
        }
    }
    let none = Vec::new();
    program.most_violated(|_, Limited { candidate, asked }| {
        if asked.limit.class != Class::Convex {
            return None;
        }
        let own = of_candidates.iter().find(|(known, _)| std::ptr::eq(*known, *candidate));
        let row = at.row(candidate, asked, own.map_or(&none, |(_, squares)| squares))?;
        Some((row, violation(row.at(ratio), asked.raw_bound())))
    })
}
