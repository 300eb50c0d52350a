//! The next run: the excitation that would tell apart what these logs do not.
//!
//! The one idea: two models that explain the logs alike predict the same only where the logs have been. A run is made of
//! passages within the limits of the declared motor, chosen so that the nearest of all pairs of models becomes as far apart as
//! can be: the least of min over θ of ‖η_a − η_b(θ)‖²/σ², with σ as it is on this bench. The columns of the models come from
//! the balance of the log that the run would leave: through the same filter, with the same rows left out.

mod choose;
mod course;
mod criterion;
pub mod facts;
mod limit;
mod passage;
mod question;

pub use facts::{
    APART, Driven, Limit, NoPlan, Pair, Plan, Quantity, Rival, Separation, SetPoint, Source, Unplanned, Wanted,
};

use nalgebra::DMatrix;

use self::choose::Said;
use self::course::{Course, Expected, Like};
use self::limit::Limits;
use self::passage::{Passage, passages};
use self::question::{Question, is_of_temperature, questions};
use super::balance::{Balance, Corrections, Setting};
use super::identified::{Final, Identified};
use super::work::{Kind, Work};
use crate::answer::{Base, Target};
use crate::{Bench, BenchKind, Channel, Log, Use, signals};
use gearwise_model::effects::{Equation, FittedEffect};

/// How long a passage is, about \[s\].
const PASSAGE: f64 = 3.0;
/// Fewest passages of a run, and the shortest passage \[s\].
const FEWEST: (usize, f64) = (4, 1.0);
/// How long a run is by default, between these \[s\].
const USUAL: (f64, f64) = (20.0, 60.0);
/// A run repeated more often than this is none.
const REPEATED: f64 = 10.0;
/// Samples in a period of the filter's cut-off.
const SAMPLES: f64 = 8.0;
/// Time between set-points \[s\].
const SET_POINT: f64 = 0.01;
/// Share of a limit by which rounding may exceed it.
const ROUNDING: f64 = 1e-6;

/// Plans the run that tells most apart of what these logs leave open.
///
/// # Errors
/// Why there is no run.
pub fn plan(bench: &Bench, identified: &[Identified], wanted: &Wanted) -> Result<Plan, NoPlan> {
    if identified.iter().all(|i| i.report.evidence.teaches_nothing()) {
        return Err(NoPlan::TeachesNothing);
    }
    let works: Vec<(Work, &Final, &Identified)> =
        identified.iter().filter_map(|i| i.model.as_ref().map(|m| (m.work(bench), m, i))).collect();
    let mut unplanned: Vec<(Pair, Unplanned)> = identified
        .iter()
        .filter(|i| i.model.is_none())
        .flat_map(|i| i.report.effects.iter().map(move |e| (i, e)))
        .flat_map(|(i, e)| e.confounded_with.iter().map(move |rival| (i.report.target, e.effect, *rival)))
        .map(|(target, effect, rival)| (Pair { target, effect, rival: Rival::Effect(rival) }, Unplanned::Simulated))
        .collect();
    let mut asked: Vec<(usize, Question)> = Vec::new();
    for (index, (work, model, identified)) in works.iter().enumerate() {
        let (own, left) = questions(work, model, &identified.report);
        asked.extend(own.into_iter().map(|q| (index, q)));
        unplanned.extend(left);
    }
    let Some((first, _)) = asked.first() else {
        return Err(if unplanned.is_empty() { NoPlan::NothingOpen } else { NoPlan::Unplanned(unplanned) });
    };
    let Some(log) = longest(bench, &works[*first].0.balance) else { return Err(NoPlan::Unplanned(unplanned)) };
    let Some(driven) = driven(log) else {
        unplanned.extend(asked.iter().map(|(_, q)| (q.pair, Unplanned::Kind(log.kind))));
        return Err(NoPlan::Unplanned(unplanned));
    };
    let run = Run::new(bench, log, driven, &works, wanted)?;
    let said = |passages: &[Passage], asked: Vec<(usize, Question)>| run.said(&works, asked, passages);
    let (answered, other) = said(&run.passages, asked);
    unplanned.extend(other.into_iter().map(|q| (q.pair, Unplanned::OtherBench(log.kind))));
    if answered.is_empty() {
        return Err(NoPlan::Unplanned(unplanned));
    }
    let parts = answered.iter().map(|(_, q, parts)| (q, parts.clone())).collect();
    let chosen = Said::new(parts, run.count).choose(run.count);
    let chosen: Vec<Passage> = chosen.into_iter().map(|k| run.passages[k]).collect();
    let (played, _) = said(&chosen, answered.into_iter().map(|(index, q, _)| (index, q)).collect());
    let mut separations: Vec<Separation> = played.iter().map(|(_, q, parts)| separation(q, parts, run.each)).collect();
    separations.sort_by(|a, b| a.after.total_cmp(&b.after));
    let course = run.course(&chosen);
    let limits = run.used(&course);
    if separations.iter().all(|s| s.until.is_none()) {
        return Err(NoPlan::NothingSeparates { separations, limits, unplanned });
    }
    Ok(Plan {
        kind: log.kind,
        driven,
        duration: course.duration(),
        points: course.points(SET_POINT).into_iter().map(|(p, _)| p).collect(),
        is_at_one_temperature: separations.iter().any(|s| is_of_temperature(&s.pair)),
        separations,
        limits,
        unplanned,
    })
}

/// What a log would do for what the others leave open, as [`plan`] reckons it for its own run: the weakest first. Pairs that it
/// does not show are left out.
pub fn rated(bench: &Bench, identified: &[Identified], log: &Log) -> Vec<Separation> {
    let mut separations = Vec::new();
    for (model, report) in identified.iter().filter_map(|i| Some((i.model.as_ref()?, &i.report))) {
        let work = model.work(bench);
        let alone = Bench { logs: vec![Log { usage: Use::Fit, ..log.clone() }], ..bench.clone() };
        let Corrections { gear_loss, shaft, .. } = model.corrections;
        let corrections = Corrections { gear_loss, shaft, ..Corrections::none(1) };
        let setting = Setting { corrections, band: work.balance.band, rows: usize::MAX, samples: usize::MAX };
        let Some(balance) = Balance::new(&alone, work.balance.target, &setting) else { continue };
        for question in questions(&work, model, report).0 {
            let parts = question.of_run(&balance, 1, |_| Some(0));
            separations.extend(parts.map(|parts| separation(&question, &parts, length(log))));
        }
    }
    separations.sort_by(|a, b| a.after.total_cmp(&b.after));
    separations
}

/// The longest log for fitting that takes part in an equation.
fn longest<'b>(bench: &'b Bench, balance: &Balance) -> Option<&'b Log> {
    let fits = balance.logs.iter().map(|l| &bench.logs[*l]).filter(|l| l.usage == Use::Fit);
    fits.max_by(|a, b| length(a).total_cmp(&length(b)))
}

fn length(log: &Log) -> f64 {
    log.time.last().zip(log.time.first()).map_or(0.0, |(last, first)| last - first)
}

/// What a bench is told, where it has runs over time that can be planned.
fn driven(log: &Log) -> Option<Driven> {
    match log.kind {
        BenchKind::Dynamometer | BenchKind::Electrical if log.channel(Channel::Current).is_some() => Some(Driven::Both),
        BenchKind::Dynamometer
        | BenchKind::Electrical
        | BenchKind::Free
        | BenchKind::Linear
        | BenchKind::Servo
        | BenchKind::Drag
        | BenchKind::Backdrive
        | BenchKind::RandomTorque => Some(Driven::Motion),
        BenchKind::Stall => Some(Driven::Current),
        BenchKind::SteadyTable | BenchKind::Terminals | BenchKind::ThermalStep | BenchKind::Rotor => None,
    }
}

/// A bench that is to be played to, and the passages that it may play.
struct Run {
    like: Like,
    /// The bench without its logs.
    empty: Bench,
    expected: Expected,
    limits: Limits,
    passages: Vec<Passage>,
    /// How many passages, and how long each is \[s\].
    count: usize,
    each: f64,
    /// Sampling interval of the logs \[s\].
    step: f64,
}

impl Run {
    fn new(
        bench: &Bench,
        log: &Log,
        driven: Driven,
        works: &[(Work, &Final, &Identified)],
        wanted: &Wanted,
    ) -> Result<Run, NoPlan> {
        let duration = wanted.time.unwrap_or(length(log).clamp(USUAL.0, USUAL.1));
        let count = ((duration / PASSAGE).round() as usize).max(FEWEST.0);
        // Set-points meet where passages do.
        let each = (duration / count as f64 / SET_POINT + ROUNDING).floor() * SET_POINT;
        if each < FEWEST.1 {
            return Err(NoPlan::TooShort(FEWEST.0 as f64 * FEWEST.1));
        }
        let expected = expected(bench, log, works);
        let (moves, loads) = (driven != Driven::Current, driven != Driven::Motion);
        let nothing = |limits| NoPlan::NothingSeparates { separations: Vec::new(), limits, unplanned: Vec::new() };
        let limits = Limits::of(bench, wanted, moves, loads, !expected.is_free).ok_or_else(|| nothing(Vec::new()))?;
        let bounds = limits.bounds(expected.ratio, expected.constant);
        let all = passages(&bounds, each, moves, loads);
        let mut run = Run {
            like: Like::of(log, bench),
            empty: Bench { logs: Vec::new(), ..bench.clone() },
            expected,
            limits,
            passages: Vec::new(),
            count,
            each,
            step: signals::median_step(&log.time),
        };
        run.passages = all.into_iter().filter(|p| run.keeps(p)).collect();
        if run.passages.is_empty() {
            return Err(nothing(run.limits.list));
        }
        Ok(run)
    }

    fn course<'a>(&'a self, passages: &'a [Passage]) -> Course<'a> {
        Course { passages, each: self.each, expected: &self.expected, middle: self.limits.middle }
    }

    /// What a run reaches of each limit: heat of its hottest passage.
    fn used(&self, course: &Course) -> Vec<Limit> {
        let points = course.points(SET_POINT.min(self.each / 300.0));
        let most = |of: &dyn Fn(&SetPoint, f64) -> f64| points.iter().map(|(p, a)| of(p, *a).abs()).fold(0.0, f64::max);
        let (e, ratio) = (&self.expected, self.expected.ratio);
        let hottest = (0..course.passages.len()).map(|k| {
            let own = points.iter().filter(|(p, _)| (p.time / self.each).floor() as usize == k).map(|(p, _)| p.current);
            let count = own.clone().count().max(1);
            (own.map(|i| i * i).sum::<f64>() / count as f64).sqrt()
        });
        let reached = |of: Quantity| match of {
            Quantity::Speed => most(&|p, _| p.speed),
            Quantity::Acceleration => most(&|_, a| a),
            Quantity::Torque => most(&|p, _| e.constant * p.current),
            Quantity::Angle => course.passages.iter().map(|p| p.travel(self.each)).fold(0.0, f64::max) / ratio,
            Quantity::Heat => hottest.clone().fold(0.0, f64::max),
            Quantity::Voltage => most(&|p, _| e.resistance * p.current + e.back_emf * p.speed),
        };
        self.limits.list.iter().map(|l| Limit { used: reached(l.of), ..*l }).collect()
    }

    /// Whether a passage keeps every limit.
    fn keeps(&self, passage: &Passage) -> bool {
        let one = [*passage];
        self.used(&self.course(&one)).iter().all(|l| l.used <= l.most * (1.0 + ROUNDING) + f64::MIN_POSITIVE)
    }

    /// What passages, played one after the other, say of questions; and questions that this bench does not answer.
    #[expect(clippy::type_complexity, reason = "a list of three and a list")]
    fn said(
        &self,
        works: &[(Work, &Final, &Identified)],
        asked: Vec<(usize, Question)>,
        passages: &[Passage],
    ) -> (Vec<(usize, Question, Vec<DMatrix<f64>>)>, Vec<Question>) {
        let course = self.course(passages);
        let mut balances: Vec<(usize, Option<Balance>)> = Vec::new();
        let (mut answered, mut other) = (Vec::new(), Vec::new());
        for (index, question) in asked {
            if !balances.iter().any(|(i, _)| *i == index) {
                balances.push((index, self.balance(&course, &works[index].0, works[index].1)));
            }
            let balance = balances.iter().find(|(i, _)| *i == index).and_then(|(_, b)| b.as_ref());
            let part = |time: f64| Some((time / self.each).floor() as usize);
            match balance.and_then(|b| question.of_run(b, passages.len(), part)) {
                Some(parts) => answered.push((index, question, parts)),
                None => other.push(question),
            }
        }
        (answered, other)
    }

    /// The equation of the log that a run would leave.
    fn balance(&self, course: &Course, work: &Work, model: &Final) -> Option<Balance> {
        let band = work.balance.band?;
        let step = self.step.max(1.0 / (SAMPLES * band));
        let bench = Bench { logs: vec![course.log(&self.like, step)], ..self.empty.clone() };
        let Corrections { gear_loss, shaft, .. } = model.corrections;
        let corrections = Corrections { gear_loss, shaft, ..Corrections::none(1) };
        let setting = Setting { corrections, band: Some(band), rows: usize::MAX, samples: usize::MAX };
        Balance::new(&bench, work.balance.target, &setting)
    }
}

/// What is expected of the machine: as fitted where the logs show it, as declared elsewhere.
fn expected(bench: &Bench, log: &Log, works: &[(Work, &Final, &Identified)]) -> Expected {
    let declared = &bench.declared;
    let motor = declared.motor.as_ref();
    let torque = works.iter().find(|(w, ..)| matches!(w.balance.target, Target::Torque | Target::Drive));
    let mut inertia =
        motor.map_or(declared.mass, |m| m.rotor_inertia.map(|j| j + declared.gear.inertia)).unwrap_or(0.0);
    let mut drag = Vec::new();
    if let Some((work, ..)) = torque {
        let fit = work.fit();
        drag.extend(work.fixed.iter().cloned());
        for (t, term) in work.terms.iter().enumerate() {
            let offset = work.offset(t);
            let own = fit.solution.coefficients.as_slice()[offset..offset + term.columns.len()].to_vec();
            match term.kind {
                Kind::Base(i) if matches!(work.balance.base[i].which, Base::Inertia | Base::Mass) && own[0] > 0.0 => {
                    inertia = own[0];
                }
                Kind::Effect(effect, shape) if effect.acts_on() == Equation::Torque => {
                    let values = own.into_iter().chain([shape]).collect();
                    drag.push(FittedEffect { effect, values });
                }
                _ => {}
            }
        }
    }
    let moves_itself = match log.kind {
        BenchKind::Free | BenchKind::Linear | BenchKind::Servo => true,
        // An idle motor that its own drive turns.
        BenchKind::Drag => log.channel(Channel::Torque).is_none(),
        _ => false,
    };
    Expected {
        constant: motor.map_or(declared.force_gain, |m| m.torque_constant),
        back_emf: motor.map_or(0.0, |m| m.back_emf_constant),
        resistance: motor.map_or(0.0, |m| m.resistance),
        inertia,
        ratio: declared.ratio,
        drag,
        is_free: moves_itself,
        load: (log.load.inertia.unwrap_or(0.0), log.load.gravity_torque.unwrap_or(0.0)),
    }
}

/// What a run does for a pair, passage by passage.
fn separation(question: &Question, parts: &[DMatrix<f64>], each: f64) -> Separation {
    let wanted = APART * APART;
    let now = question.square_now();
    let mut sum = DMatrix::zeros(question.existing.nrows(), question.existing.nrows());
    let (mut last, mut until) = (now, (now >= wanted).then_some(0.0));
    for (k, part) in parts.iter().enumerate() {
        sum += part;
        let next = question.square(&sum);
        if until.is_none() && next >= wanted {
            until = Some((k + 1) as f64 * each);
        }
        last = next;
    }
    let duration = each * parts.len() as f64;
    // Repeated, the run says the same again.
    let repeated = duration * (wanted - now) / (last - now).max(f64::MIN_POSITIVE);
    let until = until.or((repeated <= REPEATED * duration).then_some(repeated));
    Separation { pair: question.pair, now: now.max(0.0).sqrt(), after: last.max(0.0).sqrt(), until }
}

#[cfg(test)]
mod tests;
