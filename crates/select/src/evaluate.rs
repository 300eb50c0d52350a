//! One design, looked at closely: every limit with its margin, and the figures people choose by.

use std::sync::Arc;

use super::options::Stop;
use gearwise_model::actuator::Load;
use gearwise_model::actuator::gear_figures::GearFigures;
use gearwise_model::actuator::limits::{Asked, Candidate, Check, Demand, Judge, Remark, Verdict};
use gearwise_model::actuator::load::Along;
use gearwise_model::actuator::losses::{LossTerms, Losses, UnknownLoss};
use gearwise_model::actuator::parts::{Cost, Whole};
use gearwise_model::actuator::shaft::{End, FEATURES, Feature, Flow};
use gearwise_model::actuator::supply::Drawn;
use gearwise_model::actuator::thermal::{self, Winding};
use gearwise_model::actuator::waveform::Functional;
use gearwise_model::actuator::weakening::Weakening;
use gearwise_model::actuator::{Actuator, Laurent, fitted};
use gearwise_model::catalog::module::Inside;
use gearwise_model::motion::Case;
use gearwise_model::requirement::{Course, Joint, Objective, Quantity};

/// A margin below this is a violation: what rounding leaves of a limit that binds exactly.
pub const FEASIBILITY_TOLERANCE: f64 = 1e-9;

/// A candidate whose limits were gathered once, to be evaluated at many ratios.
#[derive(Debug, Clone)]
pub struct Prepared<'a> {
    /// Motor, gear, joint.
    pub candidate: Candidate<'a>,
    /// The limits that apply.
    pub asked: Vec<Asked>,
    /// The limits that cannot be checked at any ratio, and why.
    pub unchecked: Vec<Remark>,
    /// What the limits assume at every ratio.
    assumed: Vec<Remark>,
    /// The limits that no ratio is rejected by.
    at_ratio: Vec<(&'static str, Judge)>,
    /// Means over the motion, at each end of the motor's drag.
    means: [Means; 2],
    /// Heat of the difference of torque between the ends of the motor's drag \[W\].
    bend: Laurent,
    /// What of its losses nobody knows.
    unknown_losses: Arc<[UnknownLoss]>,
    /// What is known of the price of its parts.
    price: Option<Cost>,
    /// What is known of the time until they are delivered.
    lead_time: Whole,
    /// Whether a search over it is to stop.
    pub(super) stop: Stop<'a>,
}

/// Means over the motion as polynomials in the ratio.
#[derive(Debug, Clone, Copy, Default)]
struct Means {
    torque_squared: Laurent,
    losses: LossTerms,
    /// Terminal power, with heat as if the iron did not saturate.
    power: Laurent,
}

impl Means {
    fn new(candidate: &Candidate, actuator: &Actuator) -> Means {
        Means {
            torque_squared: candidate.load.mean_torque_squared(actuator),
            losses: LossTerms::new(candidate.load, actuator, candidate.standby_power()),
            power: candidate.load.mean_power(actuator),
        }
    }
}

/// What is to be said of a design beside its margins.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Judged {
    /// Limits that could not be checked, and why.
    pub unchecked: Vec<Remark>,
    /// Limits that count as kept, and as far as what holds.
    pub assumed: Vec<Remark>,
}

/// How a design stands against one limit.
#[derive(Debug, Clone, Copy)]
pub struct Margin {
    /// Name of the limit.
    pub limit: &'static str,
    /// Unit of demand and bound.
    pub unit: &'static str,
    /// What the motion demands.
    pub demand: f64,
    /// What may be had.
    pub bound: f64,
    /// `1 − demand/bound`.
    pub margin: f64,
    /// The sample of the motion at which the demand is largest.
    pub sample: Option<usize>,
    /// Of which of two actuators that move two joints it is, counted from zero; `None` where it is of both.
    pub actuator: Option<usize>,
    /// Whose limit it is.
    pub owner: &'static str,
    /// The parts of the actuator that the demand is made of, where it is a limit on them.
    pub parts: Option<Whole>,
}

impl Margin {
    /// The load case that it is in, or the actuator that it is of, where the joint has several.
    pub fn case<'j>(&self, joint: &'j Joint) -> Option<&'j Case> {
        let cases = joint.motion.cases.as_deref()?;
        let of_actuator = || cases.list.get(self.actuator?).filter(|_| cases.together);
        self.sample.and_then(|k| cases.of(k)).or_else(of_actuator)
    }

    /// Of a limit that is asked of a candidate at a ratio, by its raw demand and the sample that makes it.
    pub(super) fn new(asked: &Asked, candidate: &Candidate, ratio: f64, (raw, sample): (f64, Option<usize>)) -> Margin {
        Margin {
            limit: asked.limit.name,
            unit: asked.limit.unit_for(candidate.robot),
            demand: asked.natural(raw),
            bound: asked.bound,
            margin: asked.margin(candidate, ratio, raw),
            sample,
            actuator: asked.actuator,
            owner: asked.owner,
            parts: asked.parts(),
        }
    }
}

/// Between what voltages a bus moves whose supply has a resistance, and what heats that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BusVoltage {
    /// The lowest \[V\]; `None` where the supply cannot give the power.
    pub lowest: Option<f64>,
    /// The highest \[V\].
    pub highest: f64,
    /// Mean heat in the resistance \[W\], of the winding at the reference temperature, at the worse end of the motor's drag; `None`
    /// where the supply cannot give the power of some sample.
    pub heat: Option<f64>,
}

/// A design with all that is known of it. SI.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Ratio, N.
    pub ratio: f64,
    /// Whether every limit that could be checked is kept.
    pub feasible: bool,
    /// Every limit that applies.
    pub margins: Vec<Margin>,
    /// Mean of all losses that are known \[W\]: the larger at the ends of what is known of the motor's drag.
    pub loss: f64,
    /// The least that it may be \[W\].
    pub loss_low: f64,
    /// Where it is, at the end where it is larger.
    pub losses: Losses,
    /// What of it nobody knows.
    pub unknown_losses: Arc<[UnknownLoss]>,
    /// Mean copper loss at the reference temperature \[W\].
    pub copper_loss: f64,
    /// Largest q-axis current \[A\].
    pub peak_current: f64,
    /// Root mean square of the q-axis current \[A\].
    pub rms_current: f64,
    /// Inertia at the output \[kg·m²\].
    pub reflected_inertia: f64,
    /// Mass of motor and gear \[kg\].
    pub mass: Option<f64>,
    /// What is known of the price of its parts, in the currency of `[prices]`; `None` where the requirement has none.
    pub price: Option<Cost>,
    /// What is known of the time until its parts are delivered \[s\].
    pub lead_time: Whole,
    /// Mean electrical power at the motor's terminals \[W\].
    pub mean_power: f64,
    /// Energy drawn from the bus per cycle \[J\]: only where the objective counts it, and durations are
    /// known.
    pub energy: Option<f64>,
    /// Largest power drawn from the bus \[W\]: only where the objective counts it.
    pub peak_power: Option<f64>,
    /// What weakening of the field takes, where the requirement asks for it and it can be computed.
    pub weakening: Option<Weakening>,
    /// What is asked of the gear beside its limits.
    pub gear: GearFigures,
    /// Lowest and highest voltage of a bus whose supply has a resistance \[V\], by the power of this joint alone.
    pub bus_voltage: Option<BusVoltage>,
}

impl Evaluation {
    /// Without what a module's row does not let one know: such a figure is no number.
    fn of_module(self, inside: &Inside) -> Evaluation {
        let unless = |known: bool, value: f64| if known { value } else { f64::NAN };
        let (currents, loss) = (inside.says_currents(), inside.says_loss());
        let power = inside.says_whole_power();
        let inertia = unless(inside.says_inertia, self.reflected_inertia);
        let losses = match (currents, loss) {
            (false, _) => Losses::UNKNOWN,
            (true, false) => Losses { gear_load: f64::NAN, ..self.losses },
            (true, true) => self.losses,
        };
        Evaluation {
            loss: unless(loss, self.loss),
            loss_low: unless(loss, self.loss_low),
            losses,
            copper_loss: unless(currents, self.copper_loss),
            peak_current: unless(currents, self.peak_current),
            rms_current: unless(currents, self.rms_current),
            reflected_inertia: inertia,
            mean_power: unless(power, self.mean_power),
            bus_voltage: self.bus_voltage.filter(|_| power),
            ..self
        }
    }
}

impl<'a> Prepared<'a> {
    /// Gathers the limits of a candidate.
    pub fn new(candidate: Candidate<'a>) -> Prepared<'a> {
        let (mut asked, mut unchecked, mut at_ratio) = (Vec::new(), Vec::new(), Vec::new());
        for (limit, check) in candidate.checks() {
            match check {
                Check::Asked(limit) => asked.push(limit),
                Check::Unknown(why) => unchecked.push((limit.name, why)),
                Check::AtRatio(judge) => at_ratio.push((limit.name, judge)),
                Check::NotAsked => {}
            }
        }
        // What is said of both of two actuators is said once.
        unchecked.dedup();
        at_ratio.dedup_by_key(|(name, _)| *name);
        unchecked.extend(candidate.lacking());
        at_ratio.extend(candidate.told_at_a_ratio());
        let assumed = candidate.assumptions(&asked);
        let mut means = [Means::new(&candidate, &candidate.actuator); 2];
        if let Some(other) = candidate.at_other_end() {
            means[1] = Means::new(&candidate, &other.actuator);
            // What the drag has no part in is the same at both ends.
            asked.extend(other.checks().filter_map(|(limit, check)| match check {
                Check::Asked(asked) if limit.depends.is_of_drag() => Some(Asked { end: End::Other, ..asked }),
                _ => None,
            }));
        }
        let form = |actuator: &Actuator, flow| *actuator.torque_form(flow);
        let bend = candidate.other.map_or_else(Laurent::default, |other| {
            let difference = |flow| form(&other, flow).plus(-1.0, &form(&candidate.actuator, flow));
            candidate.load.mean_squared_difference(difference) * (other.heating() + other.conduction())
        });
        let unknown_losses = candidate.unknown_losses().into();
        let (price, lead_time) = (candidate.price(), candidate.lead_time());
        let stop = Stop::NEVER;
        Prepared { candidate, asked, unchecked, assumed, at_ratio, means, bend, unknown_losses, price, lead_time, stop }
    }

    /// The same for searches that may be stopped.
    pub fn stopping(self, stop: Stop<'a>) -> Prepared<'a> {
        Prepared { stop, ..self }
    }

    /// What could not be checked at a ratio, and what was assumed there.
    pub fn judged(&self, ratio: f64) -> Judged {
        if self.candidate.whole_map().is_some() || self.candidate.by_ratio.is_some() {
            return self.at_ratio(ratio, |here| here.judged(ratio));
        }
        let mut judged = self.judged_anywhere();
        let other = self.candidate.at_other_end();
        for (limit, judge) in &self.at_ratio {
            let ends = std::iter::once(&self.candidate).chain(&other).flat_map(Candidate::each_actuator);
            let verdicts = ends.map(|end| judge(&end, ratio));
            match verdicts.max().unwrap_or(Verdict::Kept) {
                Verdict::Kept => {}
                Verdict::Assumed(what) => judged.assumed.push((limit, what)),
                Verdict::Unknown(why) => judged.unchecked.push((limit, why)),
            }
        }
        judged
    }

    /// What can be checked at no ratio, and what is assumed at every ratio.
    pub fn judged_anywhere(&self) -> Judged {
        Judged { unchecked: self.unchecked.clone(), assumed: self.assumed.clone() }
    }

    /// The limits of which it depends on the ratio whether they can be checked.
    pub fn judged_at_ratio(&self) -> impl Iterator<Item = &'static str> + '_ {
        self.at_ratio.iter().map(|(name, _)| *name)
    }

    /// What could not be checked of the design at a ratio, and why.
    pub fn unchecked_at(&self, ratio: f64) -> Vec<Remark> {
        self.judged(ratio).unchecked
    }

    /// The same without one limit.
    pub fn without(&self, limit: &str) -> Prepared<'a> {
        let mut other = self.clone();
        other.asked.retain(|a| a.limit.name != limit);
        other
    }

    /// The functional's value of a limit at a ratio, at the end of the motor's drag where it is larger.
    pub(super) fn raw_demand(&self, of: &Asked, ratio: f64) -> f64 {
        let same = self.asked.iter().filter(|asked| asked.limit.name == of.limit.name);
        same.map(|asked| asked.raw_demand(&self.candidate, ratio).0).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The same limits for another load of the same motor and gear. A limit that was left out stays out.
    pub fn with_candidate<'b>(&self, candidate: Candidate<'b>) -> Prepared<'b>
    where
        'a: 'b,
    {
        let mut other = Prepared::new(candidate).stopping(self.stop);
        other.asked.retain(|a| self.asked.iter().any(|b| b.limit.name == a.limit.name));
        other
    }

    /// Evaluates the design at a ratio, the costlier figures too.
    pub fn at_in_full(&self, ratio: f64) -> Evaluation {
        Evaluation { energy: self.energy(ratio), peak_power: Some(self.peak_power(ratio)), ..self.at(ratio) }
    }

    /// The ends of what is known of the motor's drag, each with its equations and means.
    fn ends(&self) -> impl Iterator<Item = (&Actuator, &Means)> {
        self.candidate.ends().zip(&self.means)
    }

    /// Mean copper loss as a polynomial in N \[W\], that at the first end of the motor's drag; where the iron saturates, as if
    /// it did not.
    pub fn copper_loss(&self) -> Laurent {
        self.means[0].torque_squared * self.candidate.actuator.heating()
    }

    /// The polynomial that equals the mean copper loss at a ratio \[W\] and is nowhere above it.
    pub(super) fn copper_cut(&self, ratio: f64) -> Laurent {
        self.larger(ratio, |actuator, means| self.copper_of(actuator, means, ratio))
    }

    /// The polynomial that equals the mean of all losses at a ratio \[W\] and is nowhere above it.
    pub(super) fn loss_cut(&self, ratio: f64) -> Laurent {
        self.larger(ratio, |actuator, means| self.loss_of(actuator, means, ratio))
    }

    /// Derivative of the mean of all losses by the ratio \[W\], at the end of the motor's drag where they are larger; `None` where the
    /// motor has effects that are evaluated at each ratio, or is a module that does not say its loss.
    pub fn loss_slope(&self, ratio: f64) -> Option<f64> {
        let says_loss = self.candidate.motor.inside.as_deref().is_none_or(|inside| inside.says_loss());
        (says_loss && !self.candidate.is_evaluated()).then(|| self.loss_cut(ratio).slope(ratio))
    }

    /// How the cut of a mean at a ratio moves with the load along some directions, by the torque \[N·m\] that each adds to the samples of
    /// the motion, with power flowing through the gear and drawn from the bus as it is there.
    pub(super) fn mean_slopes(&self, quantity: Quantity, ratio: f64, along: &[Along]) -> Vec<Laurent> {
        let load = self.candidate.load;
        let value = |actuator: &Actuator, means: &Means| match quantity {
            Quantity::CopperLoss => self.copper_of(actuator, means, ratio).at(ratio),
            Quantity::Loss => self.loss_of(actuator, means, ratio).at(ratio),
            _ => load.drawn_cut(actuator, self.drawn(), ratio).at(ratio),
        };
        let ends = self.ends().enumerate().map(|(end, (actuator, means))| (value(actuator, means), end));
        let Some((_, end)) = ends.reduce(|a, b| if b.0 > a.0 { b } else { a }) else { return Vec::new() };
        let actuator = self.candidate.ends().nth(end).unwrap_or(&self.candidate.actuator);
        let drawn = || load.drawn_slopes(actuator, self.drawn(), ratio, along);
        let copper: Vec<Laurent> = match actuator.shortfall.saturates() {
            true => {
                let slopes = load.current_squared_slopes(actuator, ratio, along);
                slopes.into_iter().map(|slope| slope * actuator.resistance).collect()
            }
            false => along.iter().map(|of| of.squared[end] * actuator.heating()).collect(),
        };
        match quantity {
            Quantity::CopperLoss => copper,
            Quantity::Loss if self.drawn().is_lossless() => {
                copper.iter().zip(along).map(|(copper, of)| *copper * actuator.with_leads() + of.gear).collect()
            }
            Quantity::Loss => {
                // What is drawn, less what the motor makes of it, and what the gear takes.
                let emf = actuator.back_emf_constant / actuator.torque_constant;
                let kept = along.iter().map(|of| of.gear + of.shaft * -emf);
                drawn().into_iter().zip(kept).map(|(drawn, kept)| drawn + kept).collect()
            }
            _ => drawn().into_iter().map(|drawn| drawn * load.duration.unwrap_or(f64::NAN)).collect(),
        }
    }

    /// Of the polynomials of both ends that which is larger at a ratio.
    fn larger(&self, ratio: f64, of: impl Fn(&Actuator, &Means) -> Laurent) -> Laurent {
        let cuts = self.ends().map(|(actuator, means)| of(actuator, means));
        let larger = cuts.map(|cut| (cut.at(ratio), cut)).reduce(|a, b| if b.0 > a.0 { b } else { a });
        larger.map_or_else(Laurent::default, |(_, cut)| cut)
    }

    fn copper_of(&self, actuator: &Actuator, means: &Means, ratio: f64) -> Laurent {
        match actuator.shortfall.saturates() {
            true => self.candidate.load.mean_current_squared_cut(actuator, 0.0, ratio) * actuator.resistance,
            false => means.torque_squared * actuator.heating(),
        }
    }

    fn loss_of(&self, actuator: &Actuator, means: &Means, ratio: f64) -> Laurent {
        let plain = self.copper_of(actuator, means, ratio) * actuator.with_leads() + means.losses.sum();
        match self.by_efficiency(self.drawn(), actuator, means, ratio) {
            Some(drive) => plain + drive,
            None => plain,
        }
    }

    /// The copper loss or the loss as polynomials in the ratio \[W\], one at each end of the motor's drag, the larger of which counts at
    /// each ratio; `None` where it is none.
    pub(super) fn losses_at_ends(&self, quantity: Quantity) -> Option<Vec<Laurent>> {
        let saturates = self.ends().any(|(actuator, _)| actuator.shortfall.saturates());
        let of_end = |(actuator, means)| match quantity {
            Quantity::CopperLoss => Some(self.copper_of(actuator, means, 1.0)),
            Quantity::Loss if self.drawn().is_lossless() => Some(self.loss_of(actuator, means, 1.0)),
            _ => None,
        };
        if saturates { None } else { self.ends().map(of_end).collect() }
    }

    /// What the bus makes of power at the terminals.
    fn drawn(&self) -> Drawn {
        Drawn::new(&self.candidate.robot.bus)
    }

    /// What the drive's efficiency takes and what of the power that comes back is not kept, as a cut of what is drawn less
    /// what goes on to motor and leads; `None` where that is nothing.
    fn by_efficiency(&self, drawn: Drawn, actuator: &Actuator, means: &Means, ratio: f64) -> Option<Laurent> {
        if drawn.is_lossless() {
            return None;
        }
        let drawn = self.candidate.load.drawn_cut(actuator, drawn, ratio);
        // The mean power has the heat as if the iron did not saturate.
        let heat = self.copper_of(actuator, means, ratio) * actuator.with_leads();
        let behind = means.power + means.torque_squared * -actuator.heating() + heat;
        Some(drawn + behind * -1.0)
    }

    /// Where the losses are at a ratio, at one end of the motor's drag; and what of them the bus takes by its efficiencies.
    fn losses_of(&self, actuator: &Actuator, means: &Means, ratio: f64) -> (Losses, f64) {
        let at = |polynomial: &Laurent| polynomial.at(ratio);
        let terms = &means.losses;
        let taken = |drawn| self.by_efficiency(drawn, actuator, means, ratio).map_or(0.0, |taken| taken.at(ratio));
        let (drawn, by_drive) = (self.drawn(), self.drawn().by_drive());
        let all = taken(drawn);
        let drive = if drawn == by_drive { all } else { taken(by_drive) };
        let copper = self.copper_at(actuator, means, ratio);
        let losses = Losses {
            copper,
            motor_drag: at(&terms.motor_drag),
            gear_load: at(&terms.gear_load),
            gear_no_load: at(&terms.gear_no_load),
            // The same current heats leads and drive.
            drive: copper * (actuator.with_leads() - 1.0) + at(&terms.standby) + drive,
            braking: (all - drive).max(0.0),
        };
        (losses, all)
    }

    fn copper_at(&self, actuator: &Actuator, means: &Means, ratio: f64) -> f64 {
        if actuator.shortfall.saturates() {
            return actuator.resistance * self.candidate.load.mean_current_squared(actuator, 0.0, ratio);
        }
        means.torque_squared.at(ratio).max(0.0) * actuator.heating()
    }

    /// Looks at the candidate with its evaluated effects at one ratio, and the same limits.
    pub(super) fn at_ratio<T>(&self, ratio: f64, look: impl FnOnce(&Prepared) -> T) -> T {
        self.candidate.at_ratio(ratio, |here| {
            let mut prepared = Prepared::new(*here);
            prepared.asked.retain(|a| self.asked.iter().any(|b| b.limit.name == a.limit.name));
            look(&prepared)
        })
    }

    /// Mean of all losses at a ratio \[W\]: the value of [`Prepared::loss_cut`], without a cut where that takes walks over all samples.
    pub(super) fn loss_at(&self, ratio: f64) -> f64 {
        let drawn = self.drawn();
        let loss = |(actuator, means): (&Actuator, &Means)| {
            if !actuator.shortfall.saturates() {
                return self.loss_of(actuator, means, ratio).at(ratio);
            }
            let heat = self.copper_at(actuator, means, ratio) * actuator.with_leads();
            let plain = heat + means.losses.sum().at(ratio);
            if drawn.is_lossless() {
                return plain;
            }
            let behind = (means.power + means.torque_squared * -actuator.heating()).at(ratio) + heat;
            plain + self.candidate.load.mean_drawn(actuator, drawn, ratio) - behind
        };
        self.ends().map(loss).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Mean copper loss at a ratio \[W\].
    pub(super) fn copper_loss_at(&self, ratio: f64) -> f64 {
        self.ends().map(|(actuator, means)| self.copper_at(actuator, means, ratio)).fold(0.0, f64::max)
    }

    /// Where the losses are at a ratio, at the end of the motor's drag where they are larger, and the least that they come
    /// to along what is known of it.
    fn losses(&self, ratio: f64) -> (Losses, f64) {
        let candidate = &self.candidate;
        let (first, of_first) = self.losses_of(&candidate.actuator, &self.means[0], ratio);
        let Some(end) = &candidate.other else { return (first, first.total()) };
        let (other, of_other) = self.losses_of(end, &self.means[1], ratio);
        let larger = if other.total() > first.total() { other } else { first };
        // Along the segment the torque is linear, so that the loss is a parabola through its ends; its bend is the heat of the
        // difference. What the drive's efficiency takes is none: of that it is at least nothing.
        let bend = self.bend.at(ratio).max(0.0);
        let (a, b) = (first.total() - of_first, other.total() - of_other);
        let least = |s: f64| a + (b - a - bend) * s + bend * s * s;
        let vertex = if bend > 0.0 { ((a + bend - b) / (2.0 * bend)).clamp(0.0, 1.0) } else { 0.0 };
        (larger, a.min(b).min(least(vertex)))
    }

    /// Root mean square current at a ratio \[A\].
    fn rms_current(&self, ratio: f64) -> f64 {
        let each = self.candidate.load.actuators();
        if !each.is_empty() {
            let of = |(load, actuator): (&Load, &Actuator)| match actuator.shortfall.saturates() {
                true => load.mean_current_squared(actuator, 0.0, ratio).sqrt(),
                false => load.mean_torque_squared(actuator).at(ratio).max(0.0).sqrt() / actuator.torque_constant,
            };
            let all = each.iter().flat_map(|load| self.candidate.ends().map(move |end| (load, end)));
            return all.map(of).fold(0.0, f64::max);
        }
        let of = |(actuator, means): (&Actuator, &Means)| match actuator.shortfall.is_nothing() {
            true => means.torque_squared.at(ratio).max(0.0).sqrt() / actuator.torque_constant,
            false => (self.copper_at(actuator, means, ratio) / actuator.resistance).sqrt(),
        };
        self.ends().map(of).fold(0.0, f64::max)
    }

    /// Whether the gear is known at a ratio: a family of gears says nothing beyond its rows.
    pub fn says_gear_at(&self, ratio: f64) -> bool {
        self.candidate.whole_map().is_none_or(|map| map.covers(ratio))
    }

    /// Evaluates the design at a ratio.
    pub fn at(&self, ratio: f64) -> Evaluation {
        let evaluation = self.as_if_known(ratio);
        match self.candidate.motor.inside.as_deref() {
            Some(inside) => evaluation.of_module(inside),
            None => evaluation,
        }
    }

    /// Margins of all limits at a ratio, true if they keep them all, and the peak current \[A\] in proportion to the torque.
    fn margins(&self, ratio: f64) -> (Vec<Margin>, bool, f64) {
        let candidate = &self.candidate;
        let waveform = &candidate.load.waveform;
        let current = waveform.of_current();
        let of_end = |actuator| waveform.largest(current, actuator, ratio);
        let first = of_end(&candidate.actuator);
        let peaks = [first, candidate.other.as_ref().map_or(first, of_end)];
        let mut margins: Vec<Margin> = Vec::with_capacity(self.asked.len());
        let mut feasible = true;
        for asked in &self.asked {
            let (raw, sample) = match asked.demand {
                // Current and torque limits share the search that has been made already.
                Demand::Samples(functional) if functional == current => {
                    let peak = peaks[asked.end as usize];
                    (peak.value, Some(waveform.origin(peak.index)))
                }
                _ => asked.raw_demand(candidate, ratio),
            };
            let margin = Margin::new(asked, candidate, ratio, (raw, sample));
            feasible &= margin.margin >= -FEASIBILITY_TOLERANCE;
            let is_of = |m: &Margin| m.limit == margin.limit && m.actuator == margin.actuator;
            let same = |m: &&mut Margin| asked.end == End::Other && is_of(m);
            match margins.iter_mut().find(same) {
                // Of both ends of the drag the worse one.
                Some(of_first) if (margin.margin, -margin.demand) < (of_first.margin, -of_first.demand) => {
                    *of_first = margin;
                }
                Some(_) => {}
                None => margins.push(margin),
            }
        }
        (margins, feasible, peaks[0].value.max(peaks[1].value).max(0.0).sqrt())
    }

    /// The objective at a ratio, as [`at`](Self::at) tells it; `None` where that needs a mass that is not known.
    pub fn objective_at(&self, objective: &Objective, ratio: f64) -> Option<f64> {
        let is_mass = objective.terms.iter().all(|(quantity, _)| *quantity == Quantity::Mass);
        if !is_mass {
            return self.at(ratio).objective(objective);
        }
        let mass = self.candidate.mass_at(ratio);
        objective.terms.iter().map(|(_, weight)| Some(weight * mass?)).sum()
    }

    /// The objective at a ratio where it keeps all limits.
    pub fn kept_objective_at(&self, objective: &Objective, ratio: f64) -> Option<f64> {
        let feasible = match self.candidate.is_evaluated() {
            true => self.says_gear_at(ratio) && self.at_ratio(ratio, |here| here.margins(ratio).1),
            false => self.margins(ratio).1,
        };
        feasible.then(|| self.objective_at(objective, ratio)).flatten()
    }

    /// True if it is a module whose power is not known.
    fn lacks_power(&self) -> bool {
        !self.candidate.motor.inside.as_deref().is_none_or(Inside::says_whole_power)
    }

    /// Evaluation at a ratio, with the unknown numbers of a module computed as if they were known.
    fn as_if_known(&self, ratio: f64) -> Evaluation {
        if self.candidate.is_evaluated() {
            let there = self.at_ratio(ratio, |here| here.at(ratio));
            return Evaluation { feasible: there.feasible && self.says_gear_at(ratio), ..there };
        }
        let (margins, feasible, peak) = self.margins(ratio);
        let candidate = &self.candidate;
        let actuator = &candidate.actuator;
        let (losses, loss_low) = self.losses(ratio);
        let copper_loss = self.copper_loss_at(ratio);
        // The polynomial of the mean power has the heat as if the iron did not saturate.
        let saturated = if actuator.shortfall.saturates() { copper_loss - self.copper_loss().at(ratio) } else { 0.0 };
        let mean_power = self.ends().map(|(_, means)| means.power.at(ratio)).fold(f64::MIN, f64::max);
        Evaluation {
            ratio,
            feasible,
            margins,
            loss: losses.total(),
            loss_low,
            losses,
            unknown_losses: Arc::clone(&self.unknown_losses),
            copper_loss,
            peak_current: actuator.shortfall.peak_current(peak),
            rms_current: self.rms_current(ratio),
            reflected_inertia: candidate.reflected_inertia().at(ratio),
            mass: candidate.mass_at(ratio),
            price: self.price,
            lead_time: self.lead_time,
            mean_power: mean_power + saturated,
            energy: self.counts(Quantity::Energy).then(|| self.energy(ratio)).flatten(),
            peak_power: self.counts(Quantity::PeakPower).then(|| self.peak_power(ratio)),
            gear: candidate.gear_figures(ratio),
            bus_voltage: self.bus_voltage(ratio),
            weakening: candidate.what_weakening_takes(),
        }
    }

    fn counts(&self, quantity: Quantity) -> bool {
        self.candidate.joint.objective.weight(quantity) > 0.0
    }

    /// Energy drawn from the bus per cycle at a ratio \[J\]; `None` without durations.
    pub fn energy(&self, ratio: f64) -> Option<f64> {
        if self.lacks_power() {
            return Some(f64::NAN);
        }
        if self.candidate.is_evaluated() {
            return self.at_ratio(ratio, |here| here.energy(ratio));
        }
        Some(self.energy_cut(ratio)?.at(ratio))
    }

    /// The polynomial that equals the energy drawn per cycle at a ratio \[J\] and is nowhere above it; `None` without
    /// durations.
    pub(super) fn energy_cut(&self, ratio: f64) -> Option<Laurent> {
        let load = self.candidate.load;
        let drawn = self.larger(ratio, |actuator, _| load.drawn_cut(actuator, self.drawn(), ratio));
        let standby = Laurent::constant(self.candidate.standby_power());
        load.duration.map(|duration| (drawn + standby) * duration)
    }

    /// Largest power drawn from the bus at a ratio \[W\].
    pub fn peak_power(&self, ratio: f64) -> f64 {
        if self.lacks_power() {
            return f64::NAN;
        }
        if self.candidate.is_evaluated() {
            return self.at_ratio(ratio, |here| here.peak_power(ratio));
        }
        let candidate = &self.candidate;
        let of_end = |actuator| candidate.load.waveform.largest(Functional::Power, actuator, ratio).value;
        let peak = candidate.ends().map(of_end).fold(0.0, f64::max);
        peak / candidate.robot.bus.drive_efficiency + candidate.standby_power()
    }

    /// The samples at which current and power are largest at a ratio.
    pub(super) fn peak_samples(&self, ratio: f64) -> Vec<usize> {
        let waveform = &self.candidate.load.waveform;
        let of = |functional, actuator| waveform.origin(waveform.largest(functional, actuator, ratio).index);
        let ends = self.candidate.ends();
        ends.flat_map(|end| [of(waveform.of_current(), end), of(Functional::Power, end)]).collect()
    }

    /// Lowest and highest voltage of the bus at a ratio, where the supply has a resistance.
    fn bus_voltage(&self, ratio: f64) -> Option<BusVoltage> {
        let supply = self.candidate.supply(0.0)?;
        let waveform = &self.candidate.load.waveform;
        let most = |functional| {
            let of_end = |actuator| waveform.largest(functional, actuator, ratio).value;
            self.candidate.ends().map(of_end).fold(f64::NEG_INFINITY, f64::max)
        };
        let (taken, back) = (most(Functional::Power), most(Functional::PowerBack));
        let heat = |actuator| self.candidate.load.mean_of_power(actuator, ratio, |power| supply.heat(power));
        let heat = self.candidate.ends().map(heat).reduce(|a, b| Some(a?.max(b?))).flatten();
        Some(BusVoltage { lowest: supply.voltage(taken), highest: supply.lifted(back), heat })
    }

    /// Winding temperature in steady state at a ratio.
    pub fn winding_temperature(&self, ratio: f64) -> Winding {
        let motor = self.candidate.motor;
        let Some(r_th) = self.candidate.thermal_resistance().filter(|_| self.candidate.load.has_steady_heat) else {
            return Winding::NotAsked;
        };
        if self.candidate.is_evaluated() {
            return self.at_ratio(ratio, |here| here.winding_temperature(ratio));
        }
        let of_end = |(actuator, means): (&Actuator, &Means)| match actuator.shortfall.is_nothing() {
            true if self.candidate.load.actuators().is_empty() => {
                means.torque_squared.at(ratio).max(0.0) / actuator.torque_constant.powi(2)
            }
            _ => self.rms_current(ratio).powi(2),
        };
        let mean = self.ends().map(of_end).fold(0.0, f64::max);
        let settles = thermal::winding_temperature(
            mean * self.candidate.load.share_of_time,
            motor.resistance,
            motor.reference_temperature,
            r_th,
            self.candidate.robot.ambient,
        );
        settles.map_or(Winding::Runaway, Winding::At)
    }

    /// Longest time that the current needs for its jumps where the motion reverses \[s\]:
    /// `L |Δi|/(V − R |i|)`. Efficiency and Coulomb friction jump there; voltage rows leave the jump
    /// out. `None` where the inductance is unknown; infinite where no voltage is left for it.
    pub fn reversal_time(&self, ratio: f64) -> Option<f64> {
        if self.candidate.whole_map().is_some() {
            return self.at_ratio(ratio, |here| here.reversal_time(ratio));
        }
        let candidate = &self.candidate;
        let inductance = candidate.motor.inductance?;
        let motion = &candidate.joint.motion;
        let torque = |actuator: &Actuator, flow, k: usize, sign: f64| {
            let mut features = [0.0; FEATURES];
            features[Feature::Load as usize] = motion.torque[k];
            features[Feature::Acceleration as usize] = motion.acceleration[k];
            features[Feature::Velocity as usize] = motion.velocity[k];
            features[Feature::Sign as usize] = sign;
            features[Feature::Speed as usize] = motion.velocity[k].abs();
            features[Feature::One as usize] = 1.0;
            let drag = fitted::drag(candidate.motor, ratio * motion.velocity[k], sign).0;
            actuator.torque_form(flow).polynomial(&features).at(ratio) + drag
        };
        // The sample before each change of direction, standstill in between included, in each case by itself.
        let in_time = motion.courses().into_iter().filter(|(_, course)| !matches!(course, Course::Points(_)));
        let pairs = in_time.flat_map(|(samples, course)| {
            let moving: Vec<usize> = samples.filter(|k| motion.velocity[*k] != 0.0).collect();
            let closing = moving.last().copied().zip(moving.first().copied());
            let closing = closing.filter(|_| matches!(course, Course::Periodic(_)));
            moving.windows(2).map(|w| (w[0], w[1])).chain(closing).collect::<Vec<_>>()
        });
        let mut longest = 0.0_f64;
        for (before, after) in pairs {
            let (was, is) = (motion.velocity[before].signum(), motion.velocity[after].signum());
            if was == is {
                continue;
            }
            for (actuator, k) in candidate.ends().flat_map(|actuator| [(actuator, before), (actuator, after)]) {
                let at = |sign| torque(actuator, Flow::of(motion.torque[k], sign), k, sign);
                let sides = [was, is].map(|sign| at(sign) / actuator.torque_constant);
                let jump = (sides[0] - sides[1]).abs();
                let left = candidate.voltage() - actuator.hot_resistance * sides[0].abs().max(sides[1].abs());
                longest = longest.max(match () {
                    () if jump == 0.0 => 0.0,
                    () if left > 0.0 => inductance * jump / left,
                    () => f64::INFINITY,
                });
            }
        }
        Some(longest)
    }
}

/// Relative excess of a functional over its bound; for a bound of zero or less, the excess itself.
pub fn violation(raw: f64, bound: f64) -> f64 {
    if bound > 0.0 { raw / bound - 1.0 } else { raw - bound }
}

impl Evaluation {
    /// The objective's value: in its own unit for a single quantity, a pure number for a weighted
    /// sum. `None` where it needs a mass that is not known.
    pub fn objective(&self, objective: &Objective) -> Option<f64> {
        objective.terms.iter().map(|(quantity, weight)| Some(weight * self.quantity(*quantity)?)).sum()
    }

    /// One quantity.
    pub fn quantity(&self, quantity: Quantity) -> Option<f64> {
        match quantity {
            Quantity::Loss => Some(self.loss),
            Quantity::CopperLoss => Some(self.copper_loss),
            Quantity::ReflectedInertia => Some(self.reflected_inertia),
            Quantity::PeakCurrent => Some(self.peak_current),
            Quantity::Mass => self.mass,
            Quantity::Energy => self.energy,
            Quantity::PeakPower => self.peak_power,
        }
    }

    /// The smallest margin of a limit: of one that is asked several times (of each actuator, at each end of the drag) the least counts.
    pub fn least(&self, limit: &str) -> Option<&Margin> {
        let of = self.margins.iter().filter(|margin| margin.limit == limit);
        of.min_by(|a, b| a.margin.total_cmp(&b.margin))
    }

    /// The limit with the smallest margin.
    pub fn tightest(&self) -> Option<&Margin> {
        self.margins.iter().min_by(|a, b| a.margin.total_cmp(&b.margin))
    }
}
