//! What one motor and gear cost a joint at least, over all loads that the actuators which it carries may make.
//!
//! The one idea: at a *fixed* ratio what a joint costs, and what its convex limits ask for, is convex in its load, and the load is a
//! straight line in the masses that are carried. So at every ratio the tangent at one load is below all others, and a tangent is a
//! polynomial in the ratio whose coefficients are straight lines in the masses: no convexity in the ratio is needed, and Coulomb
//! friction does no harm. With prices of a kilogram on the masses what is left is a search over the ratio alone.
//!
//! Power is held to the way in which it flows through the gear at the load of the tangent. A sample whose way may turn takes more torque
//! towards its motion than that, which heats less only where the motor brakes: by that much the tangent is lowered.

use super::convex::{lowest, under};
use crate::Prepared;
use crate::mount::Mount;
use crate::program::{Peak, RatioProgram, largest_ratio_within, minimise, value};
use gearwise_model::actuator::limits::{Asked, Class, Demand, GEAR_LIFE};
use gearwise_model::actuator::load::Along;
use gearwise_model::actuator::shaft::{End, Feature, Flow};
use gearwise_model::actuator::supply::Drawn;
use gearwise_model::actuator::waveform::{Functional, WavePoint};
use gearwise_model::actuator::{Actuator, Laurent};
use gearwise_model::requirement::{Objective, Quantity};

/// A bound that is nearer than this to a value is as good as it.
const CLOSE: f64 = 1e-10;
/// Ratios that are so near to one another are one.
const SAME: f64 = 1e-7;
/// What a limit may be exceeded by and still count as kept.
const KEPT: f64 = 1e-8;

/// What is carried, as a joint's load moves with it.
#[derive(Debug)]
pub(super) struct Directions {
    /// Torque and its rate at each sample, for a unit of each coordinate.
    pub courses: Vec<(Vec<f64>, Vec<f64>)>,
    /// For each carried joint the coordinate that its mass moves, and by how much a kilogram does.
    pub of_carried: Vec<(usize, f64)>,
}

/// Over what a bound is asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Over<'o> {
    /// For each carried joint how much lighter and heavier it may be than at the load of the tangent \[kg\].
    pub masses: &'o [(f64, f64)],
    /// For each carried joint the price of a kilogram \[objective/kg\].
    pub prices: &'o [f64],
    /// What is certainly beyond this need not be known better.
    pub enough: f64,
    /// How often the range of ratios is divided at most.
    pub divisions: usize,
}

/// A motor and gear at one load, with what its cost and its limits are near it.
pub(super) struct Tangent<'t> {
    prepared: Prepared<'t>,
    directions: &'t Directions,
    /// What means do along each coordinate.
    along: Vec<Along<'t>>,
    objective: &'t Objective,
    /// The same without what is the largest over samples.
    calm: Objective,
    range: (f64, f64),
    /// A limit that binds at this load with its multiplier, and the ratio at which it does.
    priced: Option<(usize, f64, f64)>,
    /// What the power that it draws from the bus at priced samples costs; `None` where none has a price.
    power: Option<Priced>,
}

/// Power at prices, as a plane that is nowhere above it at any ratio and load.
struct Priced {
    plane: Plane,
    /// The points that it is of, each with the end of the drag, and its price \[objective/W\].
    points: Vec<(WavePoint, usize, f64)>,
}

/// A polynomial and its slopes by the mass of each carried joint.
struct Plane {
    value: Laurent,
    slopes: Vec<Laurent>,
}

impl<'t> Tangent<'t> {
    /// Of a mount over a range of ratios; `None` where it is not known how it moves with the load.
    pub(super) fn new(
        mount: Mount<'t, 't>,
        directions: &'t Directions,
        objective: &'t Objective,
        range: (f64, f64),
    ) -> Option<Tangent<'t>> {
        let prepared = mount.prepared().ok()?;
        // A bound may count what stands at the largest ratio: at others it is no less.
        let prepared = match prepared.candidate.by_ratio {
            Some(_) => prepared.with_candidate(prepared.candidate.standing_at(range.1)),
            None => prepared,
        };
        let candidate = &prepared.candidate;
        let saturates = candidate.ends().any(|end| end.shortfall.saturates());
        let unknown = saturates && objective.weight(Quantity::PeakPower) > 0.0
            || candidate.has_evaluated_effects()
            || candidate.whole_map().is_some()
            || candidate.joint.limits.spring.is_some()
            || !passes_more_when_driving(&candidate.actuator);
        if unknown {
            return None;
        }
        let ends = [&candidate.actuator, candidate.other.as_ref().unwrap_or(&candidate.actuator)];
        let along = directions.courses.iter().map(|(torque, _)| candidate.load.along(ends, torque)).collect();
        let max = prepared.asked.iter().filter_map(upper_end).fold(range.1, f64::min);
        let peaks = [Quantity::PeakCurrent, Quantity::PeakPower];
        let terms = objective.terms.iter().copied().filter(|(quantity, _)| !peaks.contains(quantity)).collect();
        let range = (range.0, max);
        Some(Tangent {
            prepared,
            directions,
            along,
            objective,
            calm: Objective { terms },
            range,
            priced: None,
            power: None,
        })
    }

    /// The same with prices on the power that it draws from the bus at some samples \[objective/W\].
    pub(super) fn with_power(mut self, power: &[(usize, f64)]) -> Tangent<'t> {
        if power.is_empty() {
            return self;
        }
        let middle = (self.range.0 * self.range.1.max(self.range.0)).sqrt();
        let candidate = &self.prepared.candidate;
        let (drawn, standby) = (Drawn::new(&candidate.robot.bus), candidate.standby_power());
        let nothing = vec![Laurent::default(); self.directions.of_carried.len()];
        let mut priced = Priced { plane: Plane { value: Laurent::default(), slopes: nothing }, points: Vec::new() };
        for (sample, price) in power {
            let wave = &candidate.load.waveform;
            let points = wave.of_sample(*sample).iter().map(|k| wave.point(*k));
            let ends = || candidate.ends().map(Actuator::unsaturated).enumerate();
            let all = points.flat_map(|point| ends().map(move |(end, of)| (point, end, of)));
            let here = |(point, end, of): (WavePoint, usize, Actuator)| {
                let power = Functional::Power.polynomial(&of, &point, middle);
                (power.at(middle), power, point, end)
            };
            let worst = all.map(here).reduce(|a, b| if b.0 > a.0 { b } else { a });
            let Some((watts, power, point, end)) = worst else { continue };
            // What is drawn is convex in the power: this line is below it whatever the power is.
            let factor = drawn.per_power(watts);
            let actuator = candidate.ends().nth(end).unwrap_or(&candidate.actuator).unsaturated();
            let of = |point: &WavePoint| Functional::Power.polynomial(&actuator, point, middle) * factor;
            let value = power * factor + Laurent::constant(standby);
            let slopes = self.by_mass(self.of_point(&point, of));
            priced.plane.count(&Plane { value, slopes }, *price);
            priced.points.push((point, end, *price));
        }
        self.power = Some(priced);
        self
    }

    /// The same with a price on the limit that ends the ratios at the best one of this load.
    pub(super) fn with_price(mut self, ratio: f64, limit: &str) -> Tangent<'t> {
        let same = |asked: &&(usize, &Asked)| asked.1.limit.name == limit && self.may_be_priced(asked.1);
        let all = self.prepared.asked.iter().enumerate();
        let raw = |asked: &Asked| asked.raw_demand(&self.prepared.candidate, ratio).0;
        let worst = all.filter(|a| same(&a)).max_by(|a, b| raw(a.1).total_cmp(&raw(b.1)));
        let Some((index, _)) = worst else { return self };
        let Some(row) = self.row(index, ratio).map(|(plane, _)| plane) else { return self };
        let multiplier = -self.with_power_at(ratio).slope(ratio) / row.value.slope(ratio);
        if multiplier.is_finite() && multiplier > 0.0 {
            self.priced = Some((index, multiplier, ratio));
        }
        self
    }

    /// The best ratio of this load between two, with the power that it draws at prices; `own` is that without.
    pub(super) fn best_between(&self, (a, b): (f64, f64), own: f64) -> f64 {
        let Some(power) = &self.power else { return own };
        let value = |n: f64| self.program(self.objective).objective_at(n) + power.plane.value.at(n);
        lowest((a, b), |n| self.with_power_at(n), None, value)
    }

    /// The best of all ratios at this load, with the power that it draws at prices.
    pub(super) fn best_of_all(&self) -> f64 {
        self.best_between(self.range, self.range.0)
    }

    fn with_power_at(&self, ratio: f64) -> Laurent {
        let power = self.power.as_ref().map_or_else(Laurent::default, |power| power.plane.value);
        self.cut(self.objective, ratio) + power
    }

    /// What a kilogram more of each carried joint costs at a ratio, with what is priced.
    pub(super) fn slopes(&self, ratio: f64) -> Vec<f64> {
        let mut plane = self.goal(self.objective, ratio, &self.program(self.objective).peaks(ratio));
        if let Some((index, multiplier, at)) = self.priced
            && let Some((row, _)) = self.row(index, at)
        {
            plane.count(&row, multiplier);
        }
        self.power.iter().for_each(|power| plane.count(&power.plane, 1.0));
        plane.slopes.iter().map(|slope| slope.at(ratio)).collect()
    }

    /// Least cost, less what the masses are worth at their prices, over the ratios and masses; infinite where none keeps the limits.
    pub(super) fn least(&self, over: Over) -> f64 {
        let (min, max) = self.range;
        if min > max * (1.0 + SAME) || self.is_too_much(over) {
            return f64::INFINITY;
        }
        let mut open = vec![self.piece((min, max.max(min)), over)];
        for _ in 0..over.divisions {
            let Some(place) = (0..open.len()).min_by(|a, b| open[*a].bound.total_cmp(&open[*b].bound)) else { break };
            let lowest = &open[place];
            let (a, b) = lowest.ratios;
            let close = lowest.value - lowest.bound <= CLOSE * lowest.value.abs();
            if lowest.bound >= over.enough || close || b / a - 1.0 < SAME {
                break;
            }
            let middle = (a * b).sqrt();
            open.swap_remove(place);
            for half in [(a, middle), (middle, b)] {
                let piece = self.piece(half, over);
                if piece.bound < f64::INFINITY {
                    open.push(piece);
                }
            }
        }
        open.iter().map(|piece| piece.bound).fold(f64::INFINITY, f64::min)
    }

    /// Whether a limit that no ratio changes is exceeded by all loads.
    fn is_too_much(&self, over: Over) -> bool {
        let motion = &self.prepared.candidate.joint.motion;
        self.prepared.asked.iter().any(|asked| match asked.demand {
            Demand::Fixed(value, Some(sample)) if value == motion.torque[sample].abs() => {
                let (low, high) = self.reach(motion.torque[sample], sample, over);
                let least = if low > 0.0 { low } else { (-high).max(0.0) };
                least > asked.raw_bound() * (1.0 + KEPT)
            }
            _ => false,
        })
    }

    /// Lowest and highest torque at a sample that is a torque at the load of the tangent.
    fn reach(&self, torque: f64, sample: usize, over: Over) -> (f64, f64) {
        let mut reach = (torque, torque);
        for ((coordinate, factor), (low, high)) in self.directions.of_carried.iter().zip(over.masses) {
            let per_mass = factor * self.directions.courses[*coordinate].0[sample];
            reach.0 += (per_mass * low).min(per_mass * high);
            reach.1 += (per_mass * low).max(per_mass * high);
        }
        reach
    }

    /// Whether power may flow through the gear in another way at some load.
    fn may_turn(&self, point: &WavePoint, over: Over) -> bool {
        let speed = point.features[Feature::Velocity as usize];
        let (low, high) = self.reach(point.features[Feature::Load as usize], point.origin, over);
        point.flow != Flow::Holding && [low, high].iter().any(|torque| Flow::of(*torque, speed) != point.flow)
    }

    /// By how much the squared torque at the shaft \[N²·m²\] may be below that with power flowing as it does, and by how much the power
    /// through the gear may be above it \[W\], at a sample whose way may turn.
    fn turned(&self, actuator: &Actuator, point: &WavePoint, (low, high): (f64, f64), over: Over) -> (f64, f64) {
        let features = &point.features;
        let torque = features[Feature::Load as usize];
        let towards = features[Feature::Velocity as usize].signum();
        let reach = self.reach(torque, point.origin, over);
        let [_, constant, inertial] = actuator.torque_terms(point.flow, features);
        let passed = actuator.torque_form(point.flow)[Feature::Load];
        let least = |x: f64, a: f64, b: f64| (x * a).min(x * b);
        let load = [reach.0, reach.1].map(|e| least(towards * passed * e, 1.0 / low, 1.0 / high));
        let least_torque = load[0].min(load[1]) + towards * constant + least(towards * inertial, low, high);
        let other_side = [reach.0, reach.1].into_iter().filter(|e| Flow::of(*e, towards) != point.flow);
        let furthest = other_side.map(f64::abs).fold(0.0, f64::max);
        let jump =
            actuator.torque_form(Flow::Driving)[Feature::Load] - actuator.torque_form(Flow::Braking)[Feature::Load];
        let squared = 2.0 * (-least_torque).max(0.0) * furthest * jump / low;
        (squared, features[Feature::Velocity as usize].abs() * furthest * jump)
    }

    /// The same of means over the motion.
    fn turning(&self, ratios: (f64, f64), over: Over) -> (f64, f64) {
        let candidate = &self.prepared.candidate;
        let of_end = |actuator: &Actuator| {
            let mut sums = (0.0, 0.0);
            for (point, weight) in candidate.load.means().filter(|(point, _)| self.may_turn(point, over)) {
                let (squared, power) = self.turned(actuator, point, ratios, over);
                sums.0 += weight * squared;
                sums.1 += weight * power;
            }
            sums
        };
        candidate.ends().map(of_end).fold((0.0, 0.0), |most: (f64, f64), of| (most.0.max(of.0), most.1.max(of.1)))
    }

    /// By how much the objective's cut at a ratio may be below that with power flowing as it does, for what [`Tangent::turning`] gives.
    fn lowered(&self, (squared, power): (f64, f64), ratio: f64) -> f64 {
        let candidate = &self.prepared.candidate;
        let of_end = |actuator: &Actuator| {
            let heating = actuator.heating() * candidate.load.steepest_heat(actuator, ratio);
            let taken = Drawn::new(&candidate.robot.bus).per_power(1.0).max(1.0);
            let drawn = (heating * actuator.with_leads() + actuator.conduction()) * taken;
            let weight = |quantity| self.objective.weight(quantity);
            // Of power that is not kept the loss is counted less what the motor turned into it.
            let excess = (actuator.back_emf_constant / actuator.torque_constant - 1.0).max(0.0);
            let duration = candidate.load.duration.unwrap_or(0.0);
            squared
                * (weight(Quantity::CopperLoss) * heating
                    + (weight(Quantity::Loss) + weight(Quantity::Energy) * duration) * drawn)
                + power * excess * weight(Quantity::Loss)
        };
        candidate.ends().map(of_end).fold(0.0, f64::max)
    }

    fn program<'s>(&'s self, objective: &'s Objective) -> RatioProgram<'s> {
        RatioProgram::under(&self.prepared, objective, self.range, Vec::new())
    }

    fn cut(&self, objective: &Objective, ratio: f64) -> Laurent {
        self.program(objective).objective_cut(ratio).0
    }

    /// The objective's cut at a ratio, with what it counts of single samples.
    fn goal(&self, objective: &Objective, ratio: f64, peaks: &[Peak]) -> Plane {
        let mut slopes = vec![Laurent::default(); self.along.len()];
        let mut count = |more: Vec<Laurent>, weight: f64| {
            slopes.iter_mut().zip(more).for_each(|(slope, more)| *slope = *slope + more * weight);
        };
        for quantity in [Quantity::CopperLoss, Quantity::Loss, Quantity::Energy] {
            let weight = objective.weight(quantity);
            if weight > 0.0 {
                count(self.prepared.mean_slopes(quantity, ratio, &self.along), weight);
            }
        }
        for peak in peaks {
            let actuator = &peak.actuator;
            let of = match peak.quantity {
                Quantity::PeakCurrent => {
                    let here = actuator.torque_form(peak.point.flow).polynomial(&peak.point.features).at(ratio);
                    let slope = match actuator.shortfall.is_nothing() {
                        true => 1.0 / actuator.torque_constant,
                        false => actuator.shortfall.peak_current_slope(here.abs()),
                    };
                    self.of_point(&peak.point, |point| {
                        actuator.torque_form(point.flow).polynomial(&point.features) * (slope * here.signum())
                    })
                }
                _ => {
                    let efficiency = self.prepared.candidate.robot.bus.drive_efficiency;
                    let power = |point: &WavePoint| Functional::Power.polynomial(actuator, point, ratio);
                    self.of_point(&peak.point, |point| power(point) * (1.0 / efficiency))
                }
            };
            count(of, peak.weight);
        }
        Plane { value: self.cut(objective, ratio), slopes: self.by_mass(slopes) }
    }

    /// The row of a limit over which a ratio goes most, and the point that it is of, where it is one of samples.
    fn row(&self, index: usize, ratio: f64) -> Option<(Plane, Option<WavePoint>)> {
        let asked = &self.prepared.asked[index];
        let candidate = &self.prepared.candidate;
        if let Demand::Polynomial(value, _) = asked.demand {
            // A mean squared torque, with the share of that at standstill that counts once more.
            let end = usize::from(asked.end == End::Other);
            let of = |along: &Along| {
                (along.squared[end] + along.at_rest[end] * asked.standing) * candidate.load.share_of_time
            };
            return Some((Plane { value, slopes: self.by_mass(self.along.iter().map(of).collect()) }, None));
        }
        let (functional, point) = asked.point_at(candidate, ratio)?;
        // The winding that decides here: of no load the largest demand is below that of this one.
        let demand = |winding: &Actuator| functional.polynomial(winding, &point, ratio).at(ratio);
        let windings = functional.windings(candidate.end(asked.end));
        let actuator = windings.into_iter().max_by(|a, b| demand(a).total_cmp(&demand(b)))?;
        let of = |point: &WavePoint| functional.polynomial(&actuator, point, ratio);
        Some((Plane { value: of(&point), slopes: self.by_mass(self.of_point(&point, of)) }, Some(point)))
    }

    /// How a parabola in the load of one point moves along each coordinate.
    fn of_point(&self, point: &WavePoint, of: impl Fn(&WavePoint) -> Laurent) -> Vec<Laurent> {
        let slope = |(torque, rate): &(Vec<f64>, Vec<f64>)| {
            let moved = |amount: f64| {
                let mut moved = *point;
                moved.features[Feature::Load as usize] += amount * torque[point.origin];
                moved.features[Feature::LoadRate as usize] += amount * rate[point.origin];
                of(&moved)
            };
            (moved(1.0) + moved(-1.0) * -1.0) * 0.5
        };
        self.directions.courses.iter().map(slope).collect()
    }

    /// Slopes by the mass of each carried joint, from those along coordinates.
    fn by_mass(&self, along: Vec<Laurent>) -> Vec<Laurent> {
        self.directions.of_carried.iter().map(|(coordinate, factor)| along[*coordinate] * *factor).collect()
    }

    fn piece(&self, ratios: (f64, f64), over: Over) -> Piece {
        let middle = (ratios.0 * ratios.1).sqrt();
        let turning = self.turning(ratios, over);
        if self.is_beyond_a_limit(ratios, middle, turning.0, over) {
            return Piece { ratios, bound: f64::INFINITY, value: f64::INFINITY };
        }
        let peaks = self.program(self.objective).peaks(middle);
        // What is the largest of samples is at least nothing.
        let mut plane = match peaks.iter().any(|peak| self.may_turn(&peak.point, over)) {
            true => self.goal(&self.calm, middle, &[]),
            false => self.goal(self.objective, middle, &peaks),
        };
        let mut lowered = self.lowered(turning, middle);
        // What steps with the ratio rises with it.
        let steps = self.program(self.objective).objective_cut(ratios.0).1;
        plane.value = plane.value + Laurent::constant(steps);
        if let Some((index, multiplier, at)) = self.priced
            && let Some((row, point)) = self.row(index, at)
            && !point.is_some_and(|point| self.may_turn(&point, over))
        {
            let bound = self.prepared.asked[index].raw_bound();
            let share = self.prepared.candidate.load.share_of_time;
            lowered += if point.is_none() { multiplier * turning.0 * share } else { 0.0 };
            plane.count(&row, multiplier);
            plane.value = plane.value + Laurent::constant(-(bound + KEPT * bound.abs()) * multiplier);
        }
        if let Some(power) = &self.power {
            plane.count(&power.plane, 1.0);
            let candidate = &self.prepared.candidate;
            // A sample whose way may turn takes more towards its motion than with power flowing as it does, and heats less by so much.
            let taken = Drawn::new(&candidate.robot.bus).per_power(1.0).max(1.0);
            for (point, end, price) in power.points.iter().filter(|(point, ..)| self.may_turn(point, over)) {
                let end = candidate.ends().nth(*end).unwrap_or(&candidate.actuator);
                lowered += price * taken * end.loss_taken() * self.turned(end, point, ratios, over).0;
            }
        }
        let (bound, value) = plane.least(ratios, middle, over.masses, over.prices);
        Piece { ratios, bound: bound - lowered, value: value - lowered }
    }

    /// True if a limit is convex in the load at every ratio, and as a parabola.
    fn may_be_priced(&self, asked: &Asked) -> bool {
        let parabola = match asked.demand {
            Demand::Samples(functional) | Demand::Bandwidth(functional) => {
                matches!(
                    functional,
                    Functional::TorqueSquared
                        | Functional::CurrentSquared
                        | Functional::VoltageSquared
                        | Functional::Power
                ) && !functional.touches(self.prepared.candidate.end(asked.end))
            }
            Demand::Polynomial(..) => true,
            _ => false,
        };
        parabola && asked.limit.class == Class::Convex
    }

    /// Whether a limit is exceeded all over a piece by all loads.
    fn is_beyond_a_limit(&self, ratios: (f64, f64), middle: f64, turning: f64, over: Over) -> bool {
        let share = self.prepared.candidate.load.share_of_time;
        let beyond = |index: usize, asked: &Asked| {
            let bound = asked.raw_bound() + KEPT * asked.raw_bound().abs();
            if asked.raw_demand(&self.prepared.candidate, middle).0 <= bound {
                return false;
            }
            let Some((row, point)) = self.row(index, middle) else { return false };
            if point.is_some_and(|point| self.may_turn(&point, over)) {
                return false;
            }
            let lowered = if point.is_none() { turning * share } else { 0.0 };
            let nothing = vec![0.0; over.prices.len()];
            row.least(ratios, middle, over.masses, &nothing).0 - lowered > bound
        };
        let convex = self.prepared.asked.iter().enumerate().filter(|(_, asked)| self.may_be_priced(asked));
        convex.into_iter().any(|(index, asked)| beyond(index, asked))
    }
}

/// Some ratios, with a bound over them and a value that is reached at one of them.
struct Piece {
    ratios: (f64, f64),
    bound: f64,
    value: f64,
}

impl Plane {
    /// Adds another one at a price.
    fn count(&mut self, other: &Plane, price: f64) {
        self.value = self.value + other.value * price;
        self.slopes.iter_mut().zip(&other.slopes).for_each(|(slope, of_other)| *slope = *slope + *of_other * price);
    }

    /// A bound over ratios and masses at prices, and the value in the middle.
    fn least(&self, ratios: (f64, f64), middle: f64, masses: &[(f64, f64)], prices: &[f64]) -> (f64, f64) {
        let mut sum = self.value;
        let (mut constant, mut at_middle) = (0.0, 0.0);
        for ((slope, (low, high)), price) in self.slopes.iter().zip(masses).zip(prices) {
            let slope = *slope + Laurent::constant(-price);
            let here = slope.at(middle);
            let (least, most) = range(&slope, ratios);
            if least >= 0.0 {
                sum = sum + slope * *low;
            } else if most <= 0.0 {
                sum = sum + slope * *high;
            } else {
                let products = [least * low, least * high, most * low, most * high];
                constant += products.into_iter().fold(f64::INFINITY, f64::min);
                at_middle += (here * low).min(here * high);
            }
        }
        let convex = under(&sum, ratios, middle);
        let u = minimise(&convex, ratios.0 * ratios.0, ratios.1 * ratios.1);
        let rounding = 1e-13 * value(&convex.map(f64::abs), u);
        (value(&convex, u) + constant - rounding, sum.at(middle) + at_middle)
    }
}

/// Lowest and highest that a polynomial may be between two ratios.
fn range(polynomial: &Laurent, (low, high): (f64, f64)) -> (f64, f64) {
    let mut range = (0.0, 0.0);
    for power in -2..=4 {
        let ends = [low, high].map(|n| polynomial[power] * n.powi(power));
        range.0 += ends[0].min(ends[1]);
        range.1 += ends[0].max(ends[1]);
    }
    range
}

/// The largest ratio that a limit leaves which does not depend on the load.
fn upper_end(asked: &Asked) -> Option<f64> {
    match asked.demand {
        Demand::Polynomial(polynomial, _)
            if asked.limit.class == Class::UpperBound && asked.limit.name != GEAR_LIFE =>
        {
            Some(largest_ratio_within(&polynomial, asked.raw_bound()) * (1.0 + KEPT))
        }
        _ => None,
    }
}

/// Whether the gear asks the motor for more where it drives: only then is the torque convex in the load.
fn passes_more_when_driving(actuator: &Actuator) -> bool {
    let passed = |flow| actuator.torque_form(flow)[Feature::Load];
    passed(Flow::Driving) >= passed(Flow::Braking)
}

#[cfg(test)]
mod tests;
