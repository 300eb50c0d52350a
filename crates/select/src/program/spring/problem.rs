//! The joint with its spring left open: limits and objective at a point, and as forms on a region.

use super::conic::Row;
use super::form::{Affine, Form, Point, at, times};
use super::model::{self, Sample};
use super::region::Region;
use crate::evaluate::{Prepared, violation};
use crate::program::objective::why_not_convex;
use gearwise_model::actuator::limits::{Asked, Class, Demand};
use gearwise_model::actuator::load::{BANDWIDTH_PHASES, WindingPeak};
use gearwise_model::actuator::shaft::sign;
use gearwise_model::actuator::supply::{Drawn, Supply};
use gearwise_model::actuator::waveform::{FUNCTIONALS, Functional};
use gearwise_model::actuator::{Actuator, Load};
use gearwise_model::numerics::work;
use gearwise_model::requirement::{Joint, Motion, Objective, Quantity, Spring};

/// What is asked at a spring, which limit is meant: its place, and that of the sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Key {
    asked: usize,
    sample: usize,
}

/// A point as the model sees it.
#[derive(Debug, Clone)]
pub(super) struct Look {
    /// The objective, in the unit of the cuts.
    pub(super) value: f64,
    /// Largest relative excess over a limit.
    pub(super) excess: f64,
    /// The worst sample of every limit with its excess.
    pub(super) limits: Vec<(f64, Key)>,
}

/// What is largest over the samples at a point, by functional, with its sample, and the squared torque of each: at one end of
/// the motor's drag.
struct Seen {
    plain: [(f64, usize); FUNCTIONALS],
    rippled: [(f64, usize); FUNCTIONALS],
    squares: Vec<f64>,
}

/// A joint with the spring left open.
pub(super) struct Problem<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    pub(super) objective: &'a Objective,
    joint: &'a Joint,
    /// Inertia at the output that the gear's efficiency covers \[kg·m²\].
    covered: f64,
    /// Middle of the motion's positions \[rad\]; rest angles are counted from it.
    pub(super) middle: f64,
    means: Vec<Sample>,
    limits: Vec<Sample>,
    ripples: Vec<Sample>,
    /// Torque at the gear's output.
    output: Vec<Affine>,
    motion: &'a Motion,
    /// The stiffness is minimised instead of the objective.
    least_stiffness: bool,
}

impl<'a> Problem<'a> {
    /// Of a candidate whose joint asks for a spring; `None` without a position.
    pub(super) fn new(prepared: &'a Prepared<'a>, objective: &'a Objective, covered: f64) -> Option<Problem<'a>> {
        let joint = prepared.candidate.joint;
        let motion = &joint.motion;
        let pull = joint.pull()?;
        let position = pull.position;
        let (low, high) = position.iter().fold((f64::MAX, f64::MIN), |(l, h), q| (l.min(*q), h.max(*q)));
        let middle = 0.5 * (low + high);
        // With k and s = k (q_0 − middle).
        let affine = |torque: f64, [q, per]: [f64; 2]| [torque, q - middle * per, -per];
        let sample = |k: usize, torque: f64, rate: f64, sign: f64| Sample {
            torque: affine(torque + covered * motion.acceleration[k], pull.torque(k)),
            rate: affine(rate + covered * motion.jerk[k], pull.rate(k)),
            acceleration: motion.acceleration[k],
            jerk: motion.jerk[k],
            velocity: motion.velocity[k],
            sign,
            place: k,
        };
        let all = 0..motion.len();
        let signs = |k: usize| match sign(motion.velocity[k]) {
            0.0 => vec![1.0, -1.0],
            s => vec![s],
        };
        let means =
            all.clone().map(|k| sample(k, motion.torque[k], motion.torque_rate[k], sign(motion.velocity[k]))).collect();
        let mut limits = Vec::new();
        let mut ripples = Vec::new();
        for k in all.clone() {
            for s in signs(k) {
                limits.push(sample(k, motion.torque[k], motion.torque_rate[k], s));
            }
        }
        if let Some(ripple) = joint.ripple() {
            let asked = ripple.bandwidth;
            let omega = std::f64::consts::TAU * asked.frequency;
            for (k, phase) in all.clone().flat_map(|k| (0..BANDWIDTH_PHASES).map(move |phase| (k, phase))) {
                let angle = std::f64::consts::TAU * phase as f64 / BANDWIDTH_PHASES as f64;
                let (more, faster) = (asked.amplitude * angle.cos(), -asked.amplitude * omega * angle.sin());
                let (torque, rate) = ripple.superposed(motion, k, more, faster);
                ripples
                    .extend(signs(k).into_iter().map(|s| Sample { place: usize::MAX, ..sample(k, torque, rate, s) }));
            }
        }
        let output = all.map(|k| affine(motion.torque[k], pull.torque(k))).collect();
        Some(Problem {
            prepared,
            objective,
            joint,
            covered,
            middle,
            means,
            limits,
            ripples,
            output,
            motion,
            least_stiffness: false,
        })
    }

    /// The same with the stiffness as the objective.
    pub(super) fn for_least_stiffness(self) -> Problem<'a> {
        Problem { least_stiffness: true, ..self }
    }

    /// The region of all ratios and springs.
    pub(super) fn whole(&self, ratio: [f64; 2], spring: &Spring) -> Region {
        Region::new(ratio, spring.stiffness, spring.rest_angle.map(|q| q - self.middle))
    }

    /// Largest torque that a spring at the corner of a region can change e by: what its sides are measured by.
    pub(super) fn spring_torque(&self, stiffness: f64, rest: f64) -> f64 {
        let reach = self.output.iter().fold(0.0_f64, |a, e| a.max(e[1].abs()));
        stiffness * (reach + rest.abs())
    }

    /// Stiffness and rest angle of a point, within what is allowed.
    pub(super) fn spring(&self, spring: &Spring, z: Point) -> (f64, f64) {
        let [q0, q1] = spring.rest_angle;
        let rest = if z[1] > 0.0 { self.middle + z[2] / z[1] } else { 0.5 * (q0 + q1) };
        (z[1].clamp(spring.stiffness[0], spring.stiffness[1]), rest.clamp(q0, q1))
    }

    /// The nearest spring that is allowed.
    pub(super) fn allowed(&self, spring: &Spring, z: Point) -> Point {
        let (k, rest) = self.spring(spring, z);
        [z[0], k, k * (rest - self.middle)]
    }

    /// The sample whose direction of power, left open, costs the bound most at a point: one that breaks a
    /// limit that could not be bounded, or one whose loss is underestimated by more than `most` in all.
    pub(super) fn worst_open(&self, region: &Region, z: Point, look: &Look, most: f64) -> Option<(usize, Affine)> {
        let actuator = self.actuator();
        for (_, key) in look.limits.iter().filter(|l| l.0 > 1e-9) {
            let asked = &self.prepared.asked[key.asked];
            if let Demand::Samples(_) = asked.demand {
                let sample = &self.limits[key.sample];
                if let Some(e) = model::open(actuator, sample, region) {
                    return Some((sample.place, e));
                }
            }
        }
        let mut worst: Option<(f64, usize, Affine)> = None;
        for (sample, share) in self.means.iter().zip(&self.motion.weight) {
            let Some(e) = model::open(actuator, sample, region) else { continue };
            let mut form = Form::default();
            model::add_torque_squared(actuator, sample, &mut form, *share, region, z);
            let missed = share * model::torque_at(actuator, sample, z).powi(2) - form.at(z);
            if worst.as_ref().is_none_or(|w| missed > w.0) {
                worst = Some((missed, sample.place, e));
            }
        }
        worst.filter(|w| w.0 * actuator.copper() > most).map(|(_, place, e)| (place, e))
    }

    /// The joint with the spring's torque added to its motion.
    pub(super) fn joint_with(&self, stiffness: f64, rest_angle: f64) -> Joint {
        self.joint.with_spring(stiffness, rest_angle).unwrap_or_else(|| self.joint.clone())
    }

    /// The load of a joint, with what the gear's efficiency covers.
    pub(super) fn load(&self, joint: &Joint) -> Load {
        Load::with_inertia(&joint.motion, joint.ripple(), self.covered)
    }

    /// True if the search is to end; counts the work of a region.
    pub(super) fn is_stopped(&self) -> bool {
        work::count(100_000 + 50 * self.means.len());
        self.prepared.stop.ends_program()
    }

    fn actuator(&self) -> &Actuator {
        &self.prepared.candidate.actuator
    }

    /// Why the program is not the convex one, if there is a reason.
    pub(super) fn why_not_convex(&self) -> Option<&'static str> {
        use gearwise_model::actuator::shaft::{Feature, Flow};
        let load = |flow| self.actuator().torque_form(flow)[Feature::Load];
        if self.prepared.candidate.has_odd_powers() {
            return Some("motor Coulomb friction makes the limits non-convex");
        }
        if self.prepared.asked.iter().any(|a| a.limit.class == Class::ReverseConvex) {
            return Some("a regeneration limit is reverse-convex");
        }
        if let Some(why) = why_not_convex(self.objective) {
            return Some(why);
        }
        if load(Flow::Driving) != load(Flow::Braking) {
            return Some("the gear's efficiency flips with a spring that is free");
        }
        if self.has_steps() {
            return Some("a mass that steps by stages is not convex");
        }
        None
    }

    /// Whether forms depend on the width of the ratios.
    pub(super) fn bends_in_ratio(&self) -> bool {
        self.prepared.candidate.has_odd_powers()
            || self.prepared.asked.iter().any(|a| a.limit.class == Class::ReverseConvex)
            || why_not_convex(self.objective).is_some()
    }

    /// Whether the objective has a mass that steps by stages.
    pub(super) fn has_steps(&self) -> bool {
        self.objective.weight(Quantity::Mass) > 0.0 && self.prepared.candidate.gear.mass_per_stage.is_some()
    }

    fn squared_peak(&self) -> bool {
        self.objective.sole() == Some(Quantity::PeakCurrent)
    }

    /// From the unit of the cuts to the objective's own.
    pub(super) fn natural(&self, value: f64) -> f64 {
        if self.squared_peak() { value.max(0.0).sqrt() / self.actuator().torque_constant } else { value }
    }

    /// The other way.
    pub(super) fn raw(&self, objective: f64) -> f64 {
        if self.squared_peak() { (objective * self.actuator().torque_constant).powi(2) } else { objective }
    }

    fn heat_row(&self, asked: &Asked, k: usize) -> f64 {
        let candidate = &self.prepared.candidate;
        candidate.load.share_of_time * candidate.load.share(k, asked.standing)
    }

    /// The point as the model sees it.
    pub(super) fn look(&self, z: Point) -> Look {
        let candidate = &self.prepared.candidate;
        let supplies = ["voltage", "torque_bandwidth_voltage"]
            .map(|limit| candidate.supply(candidate.joint.limits.reserve(limit)));
        let worst = |actuator: &Actuator, samples: &[Sample], supply: Option<Supply>| {
            let mut best = [(f64::NEG_INFINITY, 0_usize); FUNCTIONALS];
            let windings = actuator.windings();
            for (i, sample) in samples.iter().enumerate() {
                let torque = model::torque_at(actuator, sample, z);
                let [hot, cold] = [0, 1].map(|k| model::terminals_at(&windings[k], sample, torque, z));
                let needed = supply
                    .map_or(f64::NEG_INFINITY, |supply| supply.needed(hot.0, hot.1).max(supply.needed(cold.0, cold.1)));
                let back = -model::power_at((actuator, actuator.loss_returned()), sample, torque, z);
                for (best, value) in best.iter_mut().zip([torque * torque, hot.0.max(cold.0), hot.1, back, needed]) {
                    if value > best.0 {
                        *best = (value, i);
                    }
                }
            }
            best
        };
        let squares = |actuator| self.means.iter().map(|s| model::torque_at(actuator, s, z).powi(2)).collect();
        let seen: Vec<Seen> = self
            .ends()
            .map(|actuator| Seen {
                plain: worst(actuator, &self.limits, supplies[0]),
                rippled: worst(actuator, &self.ripples, supplies[1]),
                squares: squares(actuator),
            })
            .collect();
        let mut limits = Vec::new();
        let mut costly = Vec::new();
        for (index, asked) in self.prepared.asked.iter().enumerate() {
            let Seen { plain, rippled, squares } = &seen[(asked.end as usize).min(seen.len() - 1)];
            let (raw, sample) = match asked.demand {
                Demand::Samples(f) => plain[f.place()],
                Demand::Bandwidth(f) => rippled[f.place()],
                Demand::Polynomial(..) if asked.limit.class == Class::Convex => {
                    (squares.iter().enumerate().map(|(k, t)| self.heat_row(asked, k) * t).sum(), 0)
                }
                // No sample has it: it is a mean over all.
                Demand::Fixed(_, None) => {
                    let square = |(k, e): (usize, &Affine)| self.motion.weight[k] * at(e, z[1], z[2]).powi(2);
                    (self.output.iter().enumerate().map(square).sum::<f64>().sqrt(), 0)
                }
                Demand::Fixed(..) => {
                    let torques = self.output.iter().enumerate().map(|(k, e)| (at(e, z[1], z[2]).abs(), k));
                    torques.fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a })
                }
                Demand::AverageTorque(_) => (self.average_torque(z).0, 0),
                Demand::WindingPeak(_) => {
                    costly.push(index);
                    continue;
                }
                _ => continue,
            };
            limits.push((violation(raw, asked.raw_bound()), Key { asked: index, sample }));
        }
        let excess = |limits: &[(f64, Key)]| limits.iter().map(|l| l.0).fold(f64::NEG_INFINITY, f64::max);
        if !costly.is_empty() && excess(&limits) <= 1e-9 {
            let load = self.load_at(z);
            let load = load.standing_as(self.prepared.candidate.load);
            let candidate = crate::Candidate { load, ..self.prepared.candidate };
            for index in costly {
                let asked = &self.prepared.asked[index];
                let ratio = z[0].sqrt();
                if asked.is_certainly_kept(&candidate, ratio) {
                    continue;
                }
                let raw = asked.raw_demand(&candidate, ratio).0;
                limits.push((violation(raw, asked.raw_bound()), Key { asked: index, sample: 0 }));
            }
        }
        Look { value: self.value(z, &seen), excess: excess(&limits), limits }
    }

    fn load_at(&self, z: Point) -> Load {
        let rest = if z[1] > 0.0 { z[2] / z[1] } else { 0.0 };
        self.load(&self.joint_with(z[1], rest + self.middle))
    }

    /// The objective at a point, in the unit of the cuts.
    fn value(&self, z: Point, seen: &[Seen]) -> f64 {
        let actuator = self.actuator();
        let candidate = &self.prepared.candidate;
        let weight = |q| self.objective.weight(q);
        let most = |of: &dyn Fn(&Actuator, &Seen) -> f64| {
            self.ends().zip(seen).map(|(actuator, seen)| of(actuator, seen)).fold(f64::NEG_INFINITY, f64::max)
        };
        let peak = |f: Functional| most(&|_, seen| seen.plain[f.place()].0);
        if self.least_stiffness {
            return z[1];
        }
        if self.squared_peak() {
            return peak(Functional::TorqueSquared);
        }
        let mut value = 0.0;
        if weight(Quantity::CopperLoss) > 0.0 {
            let mean = |seen: &Seen| seen.squares.iter().zip(&self.motion.weight).map(|(t, w)| w * t).sum::<f64>();
            value += weight(Quantity::CopperLoss) * most(&|actuator, seen| actuator.copper() * mean(seen));
        }
        if weight(Quantity::Loss) > 0.0 {
            value += weight(Quantity::Loss) * most(&|actuator, _| self.loss_of(actuator, z));
        }
        if weight(Quantity::ReflectedInertia) > 0.0 {
            value += weight(Quantity::ReflectedInertia) * candidate.reflected_inertia().at(z[0].sqrt());
        }
        if weight(Quantity::PeakCurrent) > 0.0 {
            value += weight(Quantity::PeakCurrent) * peak(Functional::TorqueSquared).sqrt() / actuator.torque_constant;
        }
        if weight(Quantity::Mass) > 0.0 {
            value += weight(Quantity::Mass) * candidate.mass_at(z[0].sqrt()).unwrap_or(f64::NAN);
        }
        if weight(Quantity::Energy) > 0.0 {
            value += weight(Quantity::Energy) * most(&|actuator, _| self.energy_of(actuator, z));
        }
        if weight(Quantity::PeakPower) > 0.0 {
            let drawn = peak(Functional::Power).max(0.0) / candidate.robot.bus.drive_efficiency;
            value += weight(Quantity::PeakPower) * (drawn + candidate.standby_power());
        }
        value
    }

    /// Mean of all losses at a point \[W\], at one end of the motor's drag.
    fn loss_of(&self, actuator: &Actuator, z: Point) -> f64 {
        let at = |(sample, weight): (&Sample, &f64)| {
            weight * model::loss_at(actuator, self.drawn(), sample, model::torque_at(actuator, sample, z), z)
        };
        self.means.iter().zip(&self.motion.weight).map(at).sum::<f64>() + self.prepared.candidate.standby_power()
    }

    /// Energy drawn per cycle at a point \[J\], at one end of the motor's drag.
    fn energy_of(&self, actuator: &Actuator, z: Point) -> f64 {
        let sum: f64 = self.means.iter().enumerate().map(|(k, s)| self.energy_share(actuator, k, s, z).1).sum();
        self.motion.duration().unwrap_or(f64::NAN) * (sum + self.prepared.candidate.standby_power())
    }

    fn drawn(&self) -> Drawn {
        Drawn::new(&self.prepared.candidate.robot.bus)
    }

    /// The equations at each end of what is known of the motor's drag.
    fn ends(&self) -> impl Iterator<Item = &Actuator> {
        self.prepared.candidate.ends()
    }

    /// The end of the motor's drag at which something is largest.
    fn worst_end(&self, of: impl Fn(&Actuator) -> f64) -> &Actuator {
        let first = self.actuator();
        match &self.prepared.candidate.other {
            Some(other) if of(other) > of(first) => other,
            _ => first,
        }
    }

    /// A sample's weight in the energy at a point with the constant that goes with it, and what it adds to the mean power
    /// drawn \[W\].
    fn energy_share(&self, actuator: &Actuator, k: usize, sample: &Sample, z: Point) -> ([f64; 2], f64) {
        let torque = model::torque_at(actuator, sample, z);
        let power = model::power_at((actuator, actuator.loss_given()), sample, torque, z);
        let (factor, kept) = self.drawn().line(power);
        let [factor, kept] = [factor, kept].map(|x| self.motion.weight[k] * x);
        ([factor, kept], factor * power + kept)
    }

    /// A form that is nowhere above the objective on a region, and touches it at `z` where the program is
    /// convex.
    pub(super) fn cut(&self, region: &Region, z: Point, look: &Look) -> Form {
        let actuator = self.actuator();
        let candidate = &self.prepared.candidate;
        let weight = |q| self.objective.weight(q);
        let peak = |f: Functional| {
            let at = |actuator: &Actuator, s: &Sample| {
                let torque = model::torque_at(actuator, s, z);
                match f {
                    Functional::Power => model::power_at((actuator, actuator.loss_taken()), s, torque, z),
                    _ => torque * torque,
                }
            };
            let values = self.ends().flat_map(|end| self.limits.iter().map(move |s| (at(end, s), s, end)));
            let first = (f64::NEG_INFINITY, &self.limits[0], actuator);
            values.fold(first, |a, b| if b.0 > a.0 { b } else { a })
        };
        let mut form = Form::default();
        if self.least_stiffness {
            form.add_affine(&[0.0, 1.0, 0.0]);
            return form;
        }
        if self.squared_peak() {
            let (_, sample, actuator) = peak(Functional::TorqueSquared);
            model::add_torque_squared(actuator, sample, &mut form, 1.0, region, z);
            return form;
        }
        if weight(Quantity::CopperLoss) > 0.0 {
            let copper = |actuator: &Actuator| -> f64 {
                let square = |(s, w): (&Sample, &f64)| w * model::torque_at(actuator, s, z).powi(2);
                self.means.iter().zip(&self.motion.weight).map(square).sum()
            };
            let actuator = self.worst_end(copper);
            let each = weight(Quantity::CopperLoss) * actuator.copper();
            for (sample, share) in self.means.iter().zip(&self.motion.weight) {
                model::add_torque_squared(actuator, sample, &mut form, each * share, region, z);
            }
        }
        if weight(Quantity::Loss) > 0.0 {
            let each = weight(Quantity::Loss);
            let actuator = self.worst_end(|actuator| self.loss_of(actuator, z));
            for (sample, share) in self.means.iter().zip(&self.motion.weight) {
                model::add_loss(actuator, self.drawn(), sample, &mut form, each * share, region, z);
            }
            form.add_constant(each * candidate.standby_power());
        }
        let reflected = candidate.reflected_inertia();
        form.add_u(weight(Quantity::ReflectedInertia) * reflected.coefficient(2));
        form.add_constant(weight(Quantity::ReflectedInertia) * reflected.coefficient(0));
        if weight(Quantity::PeakCurrent) > 0.0 {
            let each = weight(Quantity::PeakCurrent) / actuator.torque_constant;
            let (_, sample, actuator) = peak(Functional::TorqueSquared);
            form.add(each, &model::torque_magnitude(actuator, sample, region, z));
        }
        if weight(Quantity::Mass) > 0.0 {
            // Regions end where a stage begins: the mass is that of their upper end.
            let mass = candidate.mass_at(region.ratio[1]).unwrap_or(f64::NAN);
            form.add_constant(weight(Quantity::Mass) * mass);
        }
        if weight(Quantity::Energy) > 0.0 {
            let each = weight(Quantity::Energy) * self.motion.duration().unwrap_or(f64::NAN);
            let actuator = self.worst_end(|actuator| self.energy_of(actuator, z));
            for (k, sample) in self.means.iter().enumerate() {
                let [factor, kept] = self.energy_share(actuator, k, sample, z).0;
                form.add_constant(each * kept);
                model::add_power((actuator, actuator.loss_given()), sample, &mut form, each * factor, region, z);
            }
            form.add_constant(each * candidate.standby_power());
        }
        if weight(Quantity::PeakPower) > 0.0 {
            let (power, sample, actuator) = peak(Functional::Power);
            form.add_constant(weight(Quantity::PeakPower) * candidate.standby_power());
            // Where nothing is drawn at any instant the peak is that of standby.
            if power > 0.0 {
                let each = weight(Quantity::PeakPower) / candidate.robot.bus.drive_efficiency;
                model::add_power((actuator, actuator.loss_taken()), sample, &mut form, each, region, z);
            }
        }
        // At the start of a piece of ratios the mass is still that of the piece before.
        debug_assert!(
            !region.contains(z)
                || (self.has_steps() && z[0] <= region.ratio[0].powi(2) * (1.0 + 1e-7))
                || look.value.is_nan()
                || form.at(z) <= look.value + 1e-6 * (form.size(z) + look.value.abs())
        );
        form
    }

    /// The row of a limit at its worst sample; `None` where it has none on this region.
    pub(super) fn row(&self, key: Key, region: &Region, z: Point) -> Option<Row> {
        let asked = &self.prepared.asked[key.asked];
        let actuator = self.prepared.candidate.end(asked.end);
        let bound = asked.raw_bound();
        let of = |samples: &[Sample], f| {
            Some(Row { form: model::functional(f, actuator, &samples[key.sample], region, z)?, bound })
        };
        match asked.demand {
            Demand::Samples(f) => of(&self.limits, f),
            Demand::Bandwidth(f) => of(&self.ripples, f),
            // Only of motors with fitted effects, which springs are not chosen for.
            Demand::MeanCurrentSquared(_) => None,
            Demand::Polynomial(..) => {
                let mut form = Form::default();
                for (k, sample) in self.means.iter().enumerate() {
                    model::add_torque_squared(actuator, sample, &mut form, self.heat_row(asked, k), region, z);
                }
                Some(Row { form, bound })
            }
            Demand::Fixed(_, sample) => {
                let mut form = Form::default();
                let mut add = |weight, e: &Affine| form.add_square(weight, &[e[0], e[1], e[2], 0.0]);
                if sample.is_none() {
                    self.output.iter().zip(&self.motion.weight).for_each(|(e, w)| add(*w, e));
                } else {
                    add(1.0, &self.output[key.sample]);
                }
                Some(Row { form, bound: bound * bound })
            }
            Demand::AverageTorque(_) => {
                let mut form = Form::default();
                let (average, slopes) = self.average_torque(z);
                let mut here = 0.0;
                for (e, slope) in self.output.iter().zip(slopes) {
                    form.add_affine(&times(e, slope));
                    here += slope * at(e, z[1], z[2]);
                }
                form.add_constant(average - here);
                Some(Row { form, bound })
            }
            Demand::WindingPeak(node) => {
                let WindingPeak { rise, gradient, .. } =
                    self.load_at(z).winding_peak_gradient(actuator, &node, z[0].sqrt(), bound);
                let mut form = Form::default();
                let mut here = 0.0;
                for (sample, per_watt) in self.means.iter().zip(gradient) {
                    let weight = per_watt * actuator.copper();
                    model::add_torque_squared(actuator, sample, &mut form, weight.max(0.0), region, z);
                    here += weight * model::torque_at(actuator, sample, z).powi(2);
                }
                form.add_constant(rise - here);
                Some(Row { form, bound })
            }
            // Neither ratio nor spring changes it.
            Demand::Constant(_) | Demand::Parts(_) | Demand::Mass => None,
        }
    }

    /// The average torque at the gear's output \[N·m\], and how it rises with the torque of each sample. It is a norm of the
    /// torques, so that it is nowhere below its tangent.
    fn average_torque(&self, z: Point) -> (f64, Vec<f64>) {
        let speeds = self.motion.velocity.iter().zip(&self.motion.weight).map(|(v, w)| v.abs() * w);
        let shares: Vec<f64> = speeds.collect();
        let all: f64 = shares.iter().sum();
        let torques: Vec<f64> = self.output.iter().map(|e| at(e, z[1], z[2])).collect();
        let cube: f64 = torques.iter().zip(&shares).map(|(t, share)| share * t.abs().powi(3)).sum();
        if !(cube > 0.0 && all > 0.0) {
            return (0.0, vec![0.0; torques.len()]);
        }
        let average = (cube / all).cbrt();
        let slope = |(t, share): (&f64, &f64)| share / all * t * t.abs() / (average * average);
        (average, torques.iter().zip(&shares).map(slope).collect())
    }

    /// Whether a key can be used again on another region.
    pub(super) fn can_be_inherited(&self, key: Key) -> bool {
        !matches!(self.prepared.asked[key.asked].demand, Demand::WindingPeak(_))
    }
}
