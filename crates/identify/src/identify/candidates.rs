//! Forward selection: the best of what is left, if it is better than chance, plausible, and not a drift in
//! disguise.

use nalgebra::DMatrix;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal};

use super::balance::visible;
use super::flexible::{drift, order_scores};
use super::regression::{Blocks, covariance, projection, solve};
use super::scores::{Scores, informed};
use super::travel;
use super::work::{Fit, Kind, Term, Work};
use crate::answer::evidence::{Asked, Gain};
use crate::answer::{Base, Ground, INTERVAL, Refused, Undecided};
use crate::select::CHANCE;
use gearwise_model::effects::{EFFECTS, Effect, Shape, Variable};
use gearwise_model::numerics::sums::{finite_sum, paired};

/// Least share of the left-out squared error that an effect must take away to be worth a name: 2 % of the
/// error itself.
pub const WORTH: f64 = 0.04;
/// A gain must be this many standard errors above zero between blocks.
pub const SURE: f64 = 2.5;
/// Share of the error by which an effect must win over a simpler one to be told instead of it.
const NEAR: f64 = 0.02;
/// What holds 95 % of the lengths of two values of standard error one, as [`INTERVAL`] does of one.
const INTERVAL_OF_TWO: f64 = 2.45;
/// A shape this near to the end of its window, as a share, is not seen.
const EDGE: f64 = 0.03;
/// How many of the candidates that do not earn a name alone are asked two at a time.
const NEAR_ENOUGH: usize = 4;
/// Share of what an effect takes away that something else must, to look like it.
const RECOVERS: f64 = 0.7;
/// Repetitions with random signs.
const REPETITIONS: usize = 400;
/// Share of its gain that a candidate must keep beside a free drift in time.
const BESIDE_DRIFT: f64 = 0.4;

/// Whether an effect in the model is defined beyond this one, which therefore stays.
fn carries_another(work: &Work, effect: &dyn Effect) -> bool {
    let mut others = work.terms.iter().filter_map(Term::effect);
    // What is lost of the transmitted torque is nothing without the weight that is transmitted.
    others.any(|(e, _)| {
        e.beyond().is_some_and(|first| first == effect) || effect.is_weight() && e.needs().contains(&Variable::Torque)
    })
}

/// A candidate at its best shape.
#[derive(Clone)]
pub struct Candidate {
    /// The effect.
    pub effect: &'static dyn Effect,
    /// Its shape.
    pub shape: f64,
    /// Values: linear, then the shape.
    pub values: Vec<f64>,
    /// Left-out squared errors of the blocks with it.
    pub left_out: Vec<f64>,
    /// Share of the left-out squared error that it takes away.
    pub gain: f64,
    /// The gain in standard errors between blocks.
    pub sure: f64,
    /// What each block says of it.
    pub scores: Scores,
    /// Its columns.
    pub columns: Vec<Vec<f64>>,
    /// By how much each number of the model differs with it.
    pub shifts: Vec<f64>,
}

/// Two candidates that earn their names beside each other.
struct Pair {
    /// What is left with both, left out.
    left: f64,
    of: [Candidate; 2],
    /// What logs say against each.
    objections: [Option<String>; 2],
}

/// A term that can be spared.
pub(crate) struct Superfluous {
    pub term: usize,
    /// Share of the left-out squared error that it takes away.
    pub gain: f64,
    /// Why it can be spared.
    pub reason: String,
}

/// The state of the selection: what was refused and why.
#[derive(Clone, Default)]
pub struct Selection {
    /// Every refusal, the last word for each effect.
    pub refused: Vec<Refused>,
    /// Effects that can be seen on this bench.
    pub open: Vec<&'static dyn Effect>,
    /// What was taken back: it is not asked for again. Of an effect with orders, that order.
    pub(super) barred: Vec<(&'static dyn Effect, f64)>,
    /// What logs say against each other of an effect that was accepted.
    pub objections: Vec<(&'static dyn Effect, String)>,
    /// The stage with the least left-out error of those whose effects all hold: its terms, and its errors.
    pub(super) best: Option<(Vec<Term>, Vec<f64>)>,
    /// The least left-out squared errors of any stage.
    pub(super) least: Option<Vec<f64>>,
}

impl Selection {
    /// All effects that the bench can show.
    pub fn new(work: &Work) -> Selection {
        let mut selection = Selection::default();
        for effect in EFFECTS {
            let declared = work
                .terms
                .iter()
                .any(|t| t.effect().is_some_and(|(e, _)| e == *effect) && effect.shape() != Shape::Order)
                || work.fixed.iter().any(|f| f.effect == *effect);
            if declared {
                continue;
            }
            match visible(*effect, &work.balance, &work.bench.declared) {
                Ok(()) => selection.open.push(*effect),
                Err(hidden) => selection.refused.push(Refused::hidden(effect.name(), hidden)),
            }
        }
        selection
    }

    fn refuse(&mut self, name: &'static str, reason: String) {
        self.refuse_on(Ground::Judged, name, reason);
    }

    fn refuse_on(&mut self, ground: Ground, name: &'static str, reason: String) {
        self.refused.retain(|r| r.name != name);
        self.refused.push(Refused { ground, ..Refused::new(name, reason) });
    }

    /// What every effect that could be asked and is not in the model would still take away, the strongest first, and
    /// all of them together; and what they leave undecided of each number of the model. What could not be asked after all is
    /// refused with its reason.
    pub fn asked(&mut self, work: &Work, fit: &Fit) -> (Vec<Asked>, Gain, Vec<Option<Undecided>>) {
        let out = |e: &&'static dyn Effect| e.shape() == Shape::Order || !work.terms.iter().any(|t| is(t, *e));
        let open: Vec<&'static dyn Effect> = self.open.iter().copied().filter(out).collect();
        let candidates = evaluate_all(work, fit, &open);
        for effect in open.iter().filter(|e| !work.terms.iter().any(|t| is(t, **e))) {
            let asked = candidates.iter().any(|c| c.effect == *effect);
            if !asked && !self.refused.iter().any(|r| r.name == effect.name()) {
                self.refuse(effect.name(), "these logs cannot separate it from what the model has".into());
            }
        }
        let mut columns = work.columns();
        columns.extend(candidates.iter().flat_map(|c| &c.columns).map(Vec::as_slice));
        let together = Gain::new(&fit.left_out, &work.fit_columns(&columns).left_out);
        let one = |c: &Candidate| Asked { name: c.effect.name(), gain: Gain::new(&fit.left_out, &c.left_out) };
        let mut asked: Vec<Asked> = candidates.iter().map(one).collect();
        asked.sort_by(|a, b| b.gain.share.total_cmp(&a.gain.share));
        (asked, together, undecided(work, fit, &candidates))
    }

    fn is_barred(&self, effect: &dyn Effect, shape: f64) -> bool {
        self.barred.iter().any(|(e, s)| *e == effect && (effect.shape() != Shape::Order || *s == shape))
    }

    /// What to add next: an effect with its shape, or two of which each is hidden by what the other leaves.
    pub fn next(&mut self, work: &Work) -> Vec<(&'static dyn Effect, f64)> {
        let asked = Asking::new(work, &self.open);
        let mut candidates = asked.candidates.clone();
        candidates.retain(|c| !self.is_barred(c.effect, c.shape));
        candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let basics = self.basics_suffice(work, &asked.fit, &candidates);
        let (mut accepted, mut hidden) = self.best_of(work, &asked, &candidates, basics);
        if basics && accepted.is_none() {
            // Each of them is hidden by what another one leaves.
            (accepted, hidden) = self.best_of(work, &asked, &candidates, false);
        }
        let found = match accepted {
            Some(one) => vec![one],
            None => self.two_at_once(work, &asked, &hidden),
        };
        self.refused.retain(|r| !found.iter().any(|c| c.effect.name() == r.name));
        found.into_iter().map(|c| (c.effect, c.shape)).collect()
    }

    /// The candidate that is to be added, and those that do not earn a name; of the basic ones alone, or of all.
    fn best_of(
        &mut self,
        work: &Work,
        asked: &Asking,
        candidates: &[Candidate],
        basics: bool,
    ) -> (Option<Candidate>, Vec<Candidate>) {
        let mut accepted: Option<Candidate> = None;
        let mut hidden: Vec<Candidate> = Vec::new();
        for candidate in candidates {
            let name = candidate.effect.name();
            let already = work.terms.iter().any(|t| is(t, candidate.effect));
            if already && candidate.effect.shape() != Shape::Order {
                continue;
            }
            if basics && !candidate.effect.is_basic() {
                continue;
            }
            if let Some(first) = self.comes_after(work, &asked.fit, candidate.effect) {
                self.refuse(name, format!("`{first}` comes first"));
                continue;
            }
            match asked.earns(work, candidate) {
                Err((ground, reason)) => {
                    if !already {
                        self.refuse_on(ground, name, reason);
                        hidden.push(candidate.clone());
                    }
                }
                Ok(_) if accepted.as_ref().is_some_and(|best| !is_told_instead(candidate, best)) => {
                    let best = accepted.as_ref().map_or("", |best| best.effect.name());
                    if !already {
                        self.refuse(name, format!("`{best}` explains more"));
                    }
                }
                Ok(objection) => {
                    self.objects(candidate.effect, objection);
                    accepted = Some(candidate.clone());
                }
            }
        }
        (accepted, hidden)
    }

    /// Keeps in mind what logs say against each other of an effect.
    fn objects(&mut self, effect: &'static dyn Effect, objection: Option<String>) {
        self.objections.retain(|(e, _)| *e != effect);
        self.objections.extend(objection.map(|o| (effect, o)));
    }

    /// Two effects of which none earns its name alone, because what the other leaves hides it: where each does beside the
    /// other, those that take away most together.
    ///
    /// One of the two may be in the model already, with a shape that stands for both: it is found again beside the other.
    fn two_at_once(&mut self, work: &Work, asked: &Asking, hidden: &[Candidate]) -> Vec<Candidate> {
        let fit = &asked.fit;
        // What all of them cannot take away together, no two can.
        let all: Vec<Vec<f64>> = hidden.iter().flat_map(|c| c.columns.iter().cloned()).collect();
        let is_shaped = |t: &&Term| {
            t.declared.is_none() && t.effect().is_some_and(|(e, _)| !matches!(e.shape(), Shape::None | Shape::Order))
        };
        let shaped: Vec<&Term> = work.terms.iter().filter(is_shaped).collect();
        if shaped.is_empty() && gain_of(work, fit, &all) < WORTH {
            return Vec::new();
        }
        let mut best: Option<Pair> = None;
        let near: Vec<&Candidate> = hidden.iter().filter(|c| c.gain > 0.5 * WORTH).take(NEAR_ENOUGH).collect();
        let open: Vec<&'static dyn Effect> = hidden.iter().map(|c| c.effect).collect();
        for (k, first) in near.iter().enumerate() {
            let later: Vec<_> = open.iter().copied().filter(|e| !near[..=k].iter().any(|c| c.effect == *e)).collect();
            self.pair(work, first, &later, asked.threshold, &mut best);
        }
        for (effect, _) in shaped.iter().filter_map(|t| t.effect()) {
            let mut without = work.clone();
            without.terms.retain(|t| !is(t, effect));
            let now = finite_sum(&fit.left_out);
            for first in hidden.iter().filter(|c| c.effect.shape() != Shape::Order) {
                let mut own = None;
                self.pair(&without, first, &[effect], asked.threshold, &mut own);
                // More than the one alone, and surely.
                let gains = |p: &Pair| p.left < (1.0 - WORTH) * now && paired(&fit.left_out, &p.of[1].left_out) > SURE;
                best = own.filter(|p| gains(p) && best.as_ref().is_none_or(|b| p.left < b.left)).or(best);
            }
        }
        let Some(Pair { of, objections, .. }) = best else { return Vec::new() };
        for (candidate, objection) in of.iter().zip(objections) {
            self.objects(candidate.effect, objection);
        }
        of.to_vec()
    }

    /// A candidate with the best of others beside it, where each earns its name beside the other and both leave less than
    /// what is the best so far. Chance is that of all that were asked.
    fn pair(
        &self,
        work: &Work,
        first: &Candidate,
        others: &[&'static dyn Effect],
        threshold: f64,
        best: &mut Option<Pair>,
    ) {
        let with = model_with(work, first);
        let beside = Asking::new(&with, others).at_least(threshold);
        for second in &beside.candidates {
            let left = finite_sum(&second.left_out);
            if best.as_ref().is_some_and(|b| b.left <= left) || self.is_barred(second.effect, second.shape) {
                continue;
            }
            let Ok(own) = beside.earns(&with, second) else { continue };
            let other = model_with(work, second);
            let back = Asking::new(&other, &[first.effect]).at_least(threshold);
            let Some((first, Ok(its))) = back.candidates.first().map(|c| (c, back.earns(&other, c))) else { continue };
            *best = Some(Pair { left, of: [first.clone(), second.clone()], objections: [its, own] });
        }
    }

    /// What an effect is defined beyond, where that is not in the model yet and worth it: asymmetry is what
    /// differs between directions beyond a constant.
    fn comes_after(&self, work: &Work, fit: &Fit, effect: &dyn Effect) -> Option<&'static str> {
        let first = effect.beyond()?;
        let open = self.open.iter().find(|e| **e == first)?;
        if work.terms.iter().any(|t| is(t, *open)) {
            return None;
        }
        (gain_of(work, fit, &work.balance.effect_columns(*open, 0.0)) > WORTH).then(|| first.name())
    }

    /// Whether plain friction and a constant together explain as much as the best single effect: then they
    /// come first, however well one curve with a free shape imitates two of them.
    fn basics_suffice(&self, work: &Work, fit: &Fit, candidates: &[Candidate]) -> bool {
        let Some(best) = candidates
            .iter()
            .find(|c| !c.effect.is_basic() && c.effect.plausible(&c.values, &work.balance.scale).is_ok())
        else {
            return false;
        };
        let left: Vec<&&'static dyn Effect> =
            self.open.iter().filter(|e| e.is_basic() && !work.terms.iter().any(|t| is(t, **e))).collect();
        if left.is_empty() {
            return false;
        }
        let extra: Vec<Vec<f64>> = left.iter().flat_map(|e| work.balance.effect_columns(**e, 0.0)).collect();
        let mut columns = work.columns();
        columns.extend(extra.iter().map(Vec::as_slice));
        let together = work.fit_columns(&columns).left_out;
        let gain = 1.0 - finite_sum(&together) / finite_sum(&fit.left_out).max(f64::MIN_POSITIVE);
        gain > WORTH && paired(&together, &best.left_out) < 2.0
    }

    /// What later effects made superfluous: the term that takes away least, of those that take away too little, not surely,
    /// or with a value that is not believed.
    pub fn superfluous(&self, work: &Work) -> Option<Superfluous> {
        let fit = work.fit();
        (0..work.terms.len())
            .filter(|t| work.terms[*t].effect().is_some() && work.terms[*t].declared.is_none())
            // One that another is defined beyond stays; but of what may have either sign nothing is left where its own value is
            // not believed.
            .filter(|t| {
                let carries = work.terms[*t].effect().filter(|(e, _)| carries_another(work, *e));
                carries.is_none_or(|(e, _)| e.is_signed() && believed(work, *t).is_err())
            })
            .filter_map(|t| {
                let without = work.left_out_without(t);
                let gain = 1.0 - finite_sum(&fit.left_out) / finite_sum(&without);
                let scores = scores_of(work, t);
                let sure = informed(&without, &fit.left_out, &scores.expected_falls(), scores.variance());
                let reason = if gain < 0.5 * WORTH || sure < SURE - 0.5 {
                    "what was found later made it superfluous".to_string()
                } else {
                    believed(work, t).err().map(|doubt| format!("with all that was found, {doubt}"))?
                };
                Some(Superfluous { term: t, gain, reason })
            })
            .min_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    /// Takes it out, with its reason. It is not asked for again.
    pub fn remove(&mut self, work: &mut Work, superfluous: Superfluous) {
        let term = work.terms.remove(superfluous.term);
        if let Some((effect, shape)) = term.effect() {
            self.barred.push((effect, shape));
            if !work.terms.iter().any(|t| is(t, effect)) {
                self.refuse(effect.name(), superfluous.reason);
            }
        }
    }

    /// Keeps a stage in mind.
    pub fn remember(&mut self, work: &Work) {
        let left_out = work.fit().left_out;
        let is_less = |than: &Vec<f64>| finite_sum(&left_out) < finite_sum(than);
        if self.least.as_ref().is_none_or(is_less) {
            self.least = Some(left_out.clone());
        }
        let holds = (0..work.terms.len()).all(|t| work.terms[t].declared.is_some() || believed(work, t).is_ok());
        if holds && self.best.as_ref().is_none_or(|(_, than)| is_less(than)) {
            self.best = Some((work.terms.clone(), left_out));
        }
    }

    /// Goes back to the best stage whose effects all held, where the last one is worse by more than blocks scatter.
    pub fn back_to_the_best(&mut self, work: &mut Work) {
        let now = work.fit().left_out;
        let Some((terms, left_out)) = self.best.take() else { return };
        if paired(&now, &left_out) > 1.0 && finite_sum(&left_out) < finite_sum(&now) {
            work.terms = terms;
        }
    }

    /// The left-out squared errors of a stage whose effects did not all hold, where it was better than the last by more than
    /// blocks scatter.
    pub fn better(&self, now: &[f64]) -> Option<&[f64]> {
        let least = self.least.as_deref()?;
        (paired(now, least) > 1.0 && finite_sum(least) < (1.0 - WORTH) * finite_sum(now)).then_some(least)
    }

    /// Another balance: what was remembered has other rows.
    pub fn forget(&mut self) {
        (self.best, self.least) = (None, None);
    }

    /// What the balance shows now and did not before may be asked for.
    pub fn open_what_is_visible(&mut self, work: &Work) {
        for effect in EFFECTS.iter().filter(|e| visible(**e, &work.balance, &work.bench.declared).is_ok()) {
            let is_in = |t: &Term| is(t, *effect) && effect.shape() != Shape::Order;
            if !self.open.contains(effect)
                && !work.terms.iter().any(is_in)
                && !work.fixed.iter().any(|f| f.effect == *effect)
            {
                self.open.push(*effect);
                self.refused.retain(|r| r.name != effect.name());
            }
        }
    }

    /// Effects that explain a term's part about as well: not significantly worse, and plausible.
    pub fn look_alikes(&self, work: &Work, term: usize) -> Vec<&'static dyn Effect> {
        let Some((own, _)) = work.terms[term].effect() else { return Vec::new() };
        let fit = work.fit();
        let mut without = work.clone();
        without.terms.remove(term);
        let base = without.fit();
        let lost = finite_sum(&base.left_out) - finite_sum(&fit.left_out);
        let rivals: Vec<&'static dyn Effect> =
            self.open.iter().copied().filter(|e| *e != own && !without.terms.iter().any(|t| is(t, *e))).collect();
        evaluate_all(&without, &base, &rivals)
            .into_iter()
            .filter(|c| {
                let recovered = finite_sum(&base.left_out) - finite_sum(&c.left_out);
                let worse = paired(&c.left_out, &fit.left_out);
                c.effect.plausible(&c.values, &work.balance.scale).is_ok() && worse < 2.0 && recovered > RECOVERS * lost
            })
            .map(|c| c.effect)
            .collect()
    }
}

/// A parameter that is held as declared, another value of which would explain an effect's part about as well.
pub fn held_look_alike(work: &Work, term: usize, held: &[Base]) -> Option<Base> {
    if held.is_empty() {
        return None;
    }
    let fit = work.fit();
    let without = work.columns_without(term);
    let base = finite_sum(&work.fit_columns(&without).left_out);
    let lost = base - finite_sum(&fit.left_out);
    let index = |which: &Base| work.balance.base.iter().position(|b| b.which == *which);
    held.iter().copied().find(|which| {
        let Some(column) = index(which).map(|i| work.balance.base_column(i)) else { return false };
        let columns: Vec<&[f64]> = without.iter().copied().chain([column.as_slice()]).collect();
        let with = work.fit_columns(&columns).left_out;
        base - finite_sum(&with) > RECOVERS * lost && paired(&with, &fit.left_out) < 2.0
    })
}

/// What effects would do for a model, and what they have to beat.
struct Asking {
    fit: Fit,
    /// Each at its best shape.
    candidates: Vec<Candidate>,
    /// The statistic that the best of all reaches by chance.
    threshold: f64,
    /// A free drift in time, and the share of the left-out error that it takes away.
    drift: (Vec<Vec<f64>>, f64),
}

impl Asking {
    fn new(work: &Work, open: &[&'static dyn Effect]) -> Asking {
        let fit = work.fit();
        let candidates = evaluate_all(work, &fit, open);
        let threshold = chance_threshold(work, &candidates);
        let drift = drift(work);
        let gain = gain_of(work, &fit, &drift);
        Asking { fit, candidates, threshold, drift: (drift, gain) }
    }

    /// With a statistic of chance that is not less than another one.
    fn at_least(mut self, threshold: f64) -> Asking {
        self.threshold = self.threshold.max(threshold);
        self
    }

    /// Whether a candidate earns its name beside the model, and what logs say against each other of it all the same.
    ///
    /// # Errors
    /// Why not.
    fn earns(&self, work: &Work, candidate: &Candidate) -> Result<Option<String>, (Ground, String)> {
        let judged = |reason: String| (Ground::Judged, reason);
        let statistic = candidate.scores.statistic();
        lacks(candidate.gain, candidate.sure, statistic, self.threshold).map_or(Ok(()), |r| Err(judged(r)))?;
        candidate.effect.plausible(&candidate.values, &work.balance.scale).map_err(|d| judged(d.to_string()))?;
        holds(work, candidate).map_err(judged)?;
        let (drift, drift_gain) = &self.drift;
        let beside = gain_beside(work, candidate, drift);
        if *drift_gain > 1.15 * candidate.gain && beside < BESIDE_DRIFT * candidate.gain {
            return Err((Ground::Drift, "a drift in time explains it as well".into()));
        }
        travel::of(work, &candidate.columns).map_err(judged)
    }
}

/// A model with a candidate.
fn model_with<'w>(work: &Work<'w>, candidate: &Candidate) -> Work<'w> {
    let mut with = work.clone();
    with.terms.push(Term {
        kind: Kind::Effect(candidate.effect, candidate.shape),
        columns: candidate.columns.clone(),
        declared: None,
    });
    with
}

/// What a candidate lacks to earn a name: a gain that is worth it, surer than its scatter between blocks, and a statistic
/// beyond what the best of all reaches by chance.
fn lacks(gain: f64, sure: f64, statistic: f64, threshold: f64) -> Option<String> {
    let percent = 100.0 * (1.0 - (1.0 - gain).max(0.0).sqrt());
    if gain < WORTH {
        return Some(if percent < 0.05 {
            "it would not lower the left-out error".into()
        } else {
            format!("it would lower the left-out error by {percent:.1} %, less than 2 %")
        });
    }
    if sure < SURE {
        return Some(format!(
            "the left-out error falls by {percent:.1} %, but not beyond its scatter between blocks ({sure:.1} standard errors)"
        ));
    }
    (statistic < threshold).then(|| {
        format!("the best of all candidates does as well by chance in more than {} % of trials", 100.0 * CHANCE)
    })
}

/// Whether an effect is told instead of another with a larger gain: the simpler of two that the data cannot tell apart.
fn is_told_instead(candidate: &Candidate, best: &Candidate) -> bool {
    let tied = candidate.gain > 0.85 * best.gain && paired(&candidate.left_out, &best.left_out) < 2.0;
    let near = finite_sum(&candidate.left_out) < (1.0 + NEAR).powi(2) * finite_sum(&best.left_out);
    (tied || near) && rank(candidate.effect) < rank(best.effect)
}

/// Scores of a term's columns beside all others.
fn scores_of(work: &Work, term: usize) -> Scores {
    let mut columns = work.columns_without(term);
    let p = columns.len();
    columns.extend(work.terms[term].columns.iter().map(Vec::as_slice));
    Scores::new(&Blocks::new(&work.balance.rows, &columns, &work.target), p, |b| work.fits(b))
}

/// Whether a candidate's values hold beside the model: beyond their own error, within the window of the shape, and with
/// numbers of the declared model that keep a sign they can have.
fn holds(work: &Work, candidate: &Candidate) -> Result<(), String> {
    let with = model_with(work, candidate);
    believed(&with, with.terms.len() - 1)
}

/// Whether the values of a term are believed.
///
/// # Errors
/// Why not.
pub fn believed(work: &Work, term: usize) -> Result<(), String> {
    let Some((effect, shape)) = work.terms[term].effect() else { return Ok(()) };
    let has_constant = work.balance.base.iter().any(|b| b.which == Base::TorqueConstant);
    if effect.is_of_torque_constant()
        && has_constant
        && !(0..work.terms.len()).any(|t| work.is_base(t, Base::TorqueConstant))
    {
        return Err("these logs do not show the torque constant itself".into());
    }
    let fit = work.fit();
    let offset = work.offset(term);
    let coefficients: Vec<f64> = (0..effect.linear()).map(|j| fit.solution.coefficients[offset + j]).collect();
    let values = values_of(effect, shape, coefficients.iter().copied());
    effect.plausible(&values, &work.balance.scale).map_err(|doubt| doubt.to_string())?;
    let covariance = covariance(&fit.blocks, &fit.solution, |b| work.fits(b));
    // Two amplitudes are one value with a direction.
    let own = covariance.view((offset, offset), (effect.linear(), effect.linear())).into_owned();
    let beyond = if effect.linear() == 2 {
        let value = nalgebra::DVector::from_vec(coefficients.clone());
        own.cholesky().map_or(f64::INFINITY, |c| value.dot(&c.solve(&value))).sqrt() / INTERVAL_OF_TWO * INTERVAL
    } else {
        coefficients[0].abs() / own[(0, 0)].sqrt().max(f64::MIN_POSITIVE)
    };
    if beyond < INTERVAL {
        return Err(format!("its value is not beyond its own error ({beyond:.1} standard errors)"));
    }
    if let Some((low, high)) = window(work, effect)
        && !effect.is_of_torque_constant()
        && (shape < low * (1.0 + EDGE) || shape > high * (1.0 - EDGE))
    {
        return Err("its shape lies at the end of what was searched".into());
    }
    // What was negative without it is not its doing.
    let without = work.fit_columns(&work.columns_without(term)).solution.coefficients;
    let negative = (0..work.terms.len()).filter(|t| *t != term).find_map(|t| {
        let column = work.offset(t);
        let before = without[if t > term { column - work.terms[term].columns.len() } else { column }];
        let one = work.terms[t].columns.len() == 1;
        let (value, error) = (fit.solution.coefficients[column], covariance[(column, column)].sqrt());
        let declared = work.terms[t].declared.as_ref().is_none_or(|d| d[0] >= 0.0);
        let may = work.terms[t].effect().is_some_and(|(e, _)| e.is_signed());
        (one && declared && !may && before >= 0.0 && value < -2.0 * error).then(|| work.name(t))
    });
    match negative {
        Some(name) => Err(format!("it needs a negative {name}")),
        None => Ok(()),
    }
}

/// Between which values the shape of an effect is looked for.
pub(super) fn window(work: &Work, effect: &dyn Effect) -> Option<(f64, f64)> {
    let scale = &work.balance.scale;
    match effect.shape() {
        Shape::Speed(search) => Some((search.from * scale.speed, search.to * scale.speed)),
        Shape::Current(search) => Some((search.from * scale.current, search.to * scale.current)),
        Shape::None | Shape::Order => None,
    }
}

fn is(term: &Term, effect: &dyn Effect) -> bool {
    matches!(term.kind, Kind::Effect(e, _) if *e == *effect)
}

fn rank(effect: &dyn Effect) -> usize {
    EFFECTS.iter().position(|e| *e == effect).unwrap_or(usize::MAX)
}

fn values_of(effect: &dyn Effect, shape: f64, linear: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = linear.collect();
    if effect.shape() != Shape::None {
        values.push(shape);
    }
    values
}

/// Shapes to try.
fn shapes(work: &Work, fit: &Fit, effect: &'static dyn Effect) -> Vec<f64> {
    let spaced = |n: usize| -> Vec<f64> {
        let Some((low, high)) = window(work, effect) else { return Vec::new() };
        (0..n).map(|k| low * (high / low).powf(k as f64 / (n - 1) as f64)).collect()
    };
    match effect.shape() {
        Shape::None => vec![0.0],
        Shape::Speed(_) => spaced(10),
        Shape::Current(_) => spaced(8),
        Shape::Order => {
            let mut orders = order_scores(work, fit, effect);
            orders.retain(|(order, _)| {
                !work.terms.iter().any(|t| matches!(t.kind, Kind::Effect(e, s) if e == effect && s == *order))
            });
            orders.sort_by(|a, b| b.1.total_cmp(&a.1));
            orders.into_iter().take(3).map(|(order, _)| order).collect()
        }
    }
}

/// Every effect at its best shape.
pub(crate) fn evaluate_all(work: &Work, fit: &Fit, effects: &[&'static dyn Effect]) -> Vec<Candidate> {
    let tasks: Vec<(&'static dyn Effect, f64)> =
        effects.iter().flat_map(|e| shapes(work, fit, *e).into_iter().map(move |s| (*e, s))).collect();
    let all: Vec<Option<Candidate>> = tasks.par_iter().map(|(e, s)| evaluate(work, fit, *e, *s)).collect();
    let mut best: Vec<Candidate> = Vec::new();
    for candidate in all.into_iter().flatten() {
        let judged = |c: &Candidate| (c.effect.plausible(&c.values, &work.balance.scale).is_ok(), c.gain);
        match best.iter_mut().find(|b| b.effect == candidate.effect) {
            Some(b) => {
                if is_preferred(judged(&candidate), judged(b)) {
                    *b = candidate;
                }
            }
            None => best.push(candidate),
        }
    }
    best
}

/// Which of two shapes of an effect, each plausible or not and with its gain: a plausible one where it does nearly as
/// well.
fn is_preferred((plausible, gain): (bool, f64), (other_plausible, other_gain): (bool, f64)) -> bool {
    match (plausible, other_plausible) {
        (true, false) => gain > 0.8 * other_gain,
        (false, true) => 0.8 * gain > other_gain,
        _ => gain > other_gain,
    }
}

pub fn evaluate(work: &Work, fit: &Fit, effect: &'static dyn Effect, shape: f64) -> Option<Candidate> {
    let columns = work.balance.effect_columns(effect, shape);
    if columns.iter().any(|c| c.iter().any(|v| !v.is_finite()) || c.iter().all(|v| *v == 0.0)) {
        return None;
    }
    let mut all = work.columns();
    let p = all.len();
    all.extend(columns.iter().map(Vec::as_slice));
    let blocks = Blocks::new(&work.balance.rows, &all, &work.target);
    let total = blocks.total(|b| work.fits(b));
    // A column that the model's own columns make up says nothing new.
    if own_shares(&total, p, columns.len()).iter().any(|share| *share < 1e-6) {
        return None;
    }
    let solution = solve(&total);
    let left_out = blocks.left_out(&work.folds);
    let before = finite_sum(&fit.left_out);
    let gain = if before > 0.0 { 1.0 - finite_sum(&left_out) / before } else { 0.0 };
    let scores = Scores::new(&blocks, p, |b| work.fits(b));
    let sure = informed(&fit.left_out, &left_out, &scores.expected_falls(), scores.variance());
    let values = values_of(effect, shape, (0..columns.len()).map(|j| solution.coefficients[p + j]));
    let shifts = (0..p).map(|j| solution.coefficients[j] - fit.solution.coefficients[j]).collect();
    Some(Candidate { effect, shape, values, left_out, gain, sure, scores, columns, shifts })
}

/// What effects that are not in the model would make of each of its numbers: of each the one, or the two, that move it most, as far
/// as the mean of both models, each as likely as it is better on other data (S. T. Buckland, K. P. Burnham and N. H. Augustin,
/// *Biometrics* 53, 1997). Two, because friction that grows with speed and friction that falls hide each other.
fn undecided(work: &Work, fit: &Fit, candidates: &[Candidate]) -> Vec<Option<Undecided>> {
    let is_plausible = |effect: &dyn Effect, values: &[f64]| effect.plausible(values, &work.balance.scale).is_ok();
    let columns = work.columns().len();
    let mut models: Vec<(Undecided, Vec<f64>)> = Vec::new();
    let mut add = |effect, beside, sure: f64, shifts: Vec<f64>| {
        let by = Normal::standard().cdf(sure);
        if by.is_finite() {
            models.push((Undecided { effect, beside, by }, shifts));
        }
    };
    for candidate in candidates.iter().filter(|c| is_plausible(c.effect, &c.values)) {
        add(candidate.effect, None, candidate.sure, candidate.shifts.clone());
    }
    for first in candidates.iter().filter(|c| c.effect.is_basic()) {
        let mut with = work.clone();
        with.terms.push(Term {
            kind: Kind::Effect(first.effect, first.shape),
            columns: first.columns.clone(),
            declared: None,
        });
        let beside = with.fit();
        let others: Vec<&'static dyn Effect> =
            candidates.iter().map(|c| c.effect).filter(|e| *e != first.effect && e.shape() != Shape::Order).collect();
        for second in evaluate_all(&with, &beside, &others) {
            let now = |j: usize| beside.solution.coefficients[j] + second.shifts[j];
            let own = values_of(first.effect, first.shape, (columns..second.shifts.len()).map(now));
            if is_plausible(first.effect, &own) && is_plausible(second.effect, &second.values) {
                let shifts = (0..columns).map(|j| now(j) - fit.solution.coefficients[j]).collect();
                add(second.effect, Some(first.effect), paired(&fit.left_out, &second.left_out), shifts);
            }
        }
    }
    let of = |j: usize| {
        let all = models.iter().map(|(model, shifts)| Undecided { by: model.by * shifts[j].abs(), ..*model });
        all.filter(|u| u.by.is_finite() && u.by > 0.0).max_by(|a, b| a.by.total_cmp(&b.by))
    };
    (0..columns).map(of).collect()
}

/// What share of the square of each extra column the model's `p` columns do not make up.
fn own_shares(total: &DMatrix<f64>, p: usize, extra: usize) -> Vec<f64> {
    let onto = projection(total, p, extra);
    let made_up = |j: usize| total.view((0, p + j), (p, 1)).dot(&onto.column(j));
    (0..extra).map(|j| 1.0 - made_up(j) / total[(p + j, p + j)]).collect()
}

/// What the best of all candidates reaches by chance: what each leaves in the blocks, with random signs.
fn chance_threshold(work: &Work, candidates: &[Candidate]) -> f64 {
    let blocks = work.folds.iter().flatten().count();
    let mut random = Pcg64Mcg::seed_from_u64(0x6765_6172_7769_7365);
    let mut largest: Vec<f64> = (0..REPETITIONS)
        .map(|_| {
            let signs: Vec<f64> = (0..blocks).map(|_| if random.next_u32() & 1 == 0 { 1.0 } else { -1.0 }).collect();
            candidates.iter().map(|c| c.scores.by_chance(&signs)).fold(0.0, f64::max)
        })
        .collect();
    largest.sort_by(f64::total_cmp);
    largest[((1.0 - CHANCE) * (REPETITIONS - 1) as f64) as usize]
}

/// The share of the left-out error that columns take away.
fn gain_of(work: &Work, fit: &Fit, extra: &[Vec<f64>]) -> f64 {
    let mut columns = work.columns();
    columns.extend(extra.iter().map(Vec::as_slice));
    1.0 - finite_sum(&work.fit_columns(&columns).left_out) / finite_sum(&fit.left_out).max(f64::MIN_POSITIVE)
}

/// The gain of a candidate beside other columns, as a share of the error without both.
fn gain_beside(work: &Work, candidate: &Candidate, others: &[Vec<f64>]) -> f64 {
    let mut columns = work.columns();
    columns.extend(others.iter().map(Vec::as_slice));
    let without = work.fit_columns(&columns).left_out;
    columns.extend(candidate.columns.iter().map(Vec::as_slice));
    let with = work.fit_columns(&columns).left_out;
    let reference = finite_sum(&work.fit().left_out);
    (finite_sum(&without) - finite_sum(&with)) / reference.max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests;
