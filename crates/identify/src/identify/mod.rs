//! Declared model against logs: what the model lacks, by how much, and how sure that is.
//!
//! The one idea: every explanation has to earn its name. Corrections of the measurement come first, then
//! the parameters that the model has, then effects that it lacks, one at a time, each judged on what was
//! left out, against chance over everything that was tried, against what is physically plausible and
//! against explanations without a name (a drift, any function of speed, of current, of position). What is
//! left and still depends on something is reported as such.

pub mod artefacts;
pub(crate) mod balance;
mod band;
mod candidates;
mod flexible;
mod hats;
mod identified;
mod machine;
pub mod noise;
mod numbers;
mod orders;
pub(crate) mod origin;
mod owning;
pub mod plan;
pub(crate) mod prepare;
mod refit;
pub(crate) mod regression;
mod report;
mod ripple;
mod robust;
mod scores;
mod structure;
mod travel;
mod work;

pub use self::robust::FAR;
pub use crate::answer::evidence::{self, Evidence, Verdict};
pub use crate::answer::{
    About, Artefact, ArtefactKind, Finding, Found, Ground, On, Parameter, Pictures, Refused, Report, Stage, Step,
    Target, Unexplained,
};
pub use balance::{Balance, Corrections, Setting, targets};
pub use identified::Identified;

use self::identified::Final;
use self::orders::Ripple;
use self::work::{Kind, Term, Work};
use crate::answer::Base;
use crate::select::{self, Judge, Pruner};
use crate::{Bench, Use, simulate};
use gearwise_model::effects::{Effect, Shape};

/// What identification is run with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Cut-off of the filter \[Hz\]; chosen from the data where not given.
    pub band: Option<f64>,
}

/// A lag that makes the declared model this many times worse is none.
const HARM: f64 = 1.5;
/// Lags that are found again may leave so many times the squared error that was left with the first ones.
const WORSE_BY_LAGS: f64 = 1.02;
/// Fewest rows over time that are fitted: less would give numbers without a scatter between stretches that says their error.
pub(crate) const FEWEST: usize = 60;
/// How often the band is halved to find one that values do not depend on.
const NARROWED: usize = 2;
/// How often the torque that the gear transmits is computed again from the fitted torque constant.
const SHAFT_ROUNDS: usize = 3;
/// Most effects and orders that are added one after the other.
const STEPS: usize = 16;

/// Identifies every equation that the bench shows.
///
/// # Errors
/// In words, where the logs say nothing that can be compared.
pub fn identify(bench: &Bench, options: &Options) -> Result<Vec<Report>, String> {
    Ok(identified(bench, options)?.into_iter().map(|i| i.report).collect())
}

/// The same with the final model of each equation, for a plan of the next run.
///
/// # Errors
/// In words, where the logs say nothing that can be compared.
pub fn identified(bench: &Bench, options: &Options) -> Result<Vec<Identified>, String> {
    let (prepared, findings) = prepare::prepare(bench);
    of_prepared(&prepared, &findings, options)
}

/// What is left of the declared model, and nothing else; `None` where the equation has no rows.
pub(crate) fn as_declared(bench: &Bench, target: Target, options: &Options) -> Option<Stage> {
    let report = report::as_declared(bench, target, options, &[])?;
    report.stages.into_iter().next()
}

/// The same of a bench of which what is no data was taken out, with what was found then.
///
/// # Errors
/// As of [`identified`].
pub(crate) fn of_prepared(bench: &Bench, findings: &[Finding], options: &Options) -> Result<Vec<Identified>, String> {
    let contradicted = findings.iter().any(|f| f.about.contradicts());
    let targets = targets(bench);
    let simulated = simulate::serves(bench);
    if targets.is_empty() && !simulated {
        let why = if simulate::lacks_supply(bench) {
            "of the servo logs the supply voltage is not known, so that a duty cycle is no voltage: a column `supply`, \
                    or `controller` with its `supply`, says it"
        } else {
            "no log for fitting has the channels of an equation: torque or a known load and a current, \
                    or a voltage, with a velocity or a position"
        };
        return Err(why.into());
    }
    if contradicted {
        let told = |target| report::as_declared(bench, target, options, findings);
        let mut reports: Vec<Report> = targets.into_iter().filter_map(told).collect();
        if reports.is_empty() {
            reports.push(report::contradicted(
                Target::Position,
                if bench.declared.motor.is_some() { "rad" } else { "m" },
                findings,
            ));
        }
        return Ok(reports.into_iter().map(Identified::without_model).collect());
    }
    let mut reports: Vec<Identified> = targets.into_iter().filter_map(|target| run(bench, target, options)).collect();
    if simulated {
        reports.extend(simulate::identify_servo(bench).map(Identified::without_model));
    }
    for Identified { report, .. } in &mut reports {
        report.mark_what_was_taken_back();
        report.findings.extend(findings.iter().cloned());
    }
    if reports.is_empty() {
        return Err(format!(
            "nothing can be learnt: of what is to be fitted fewer than {FEWEST} rows have all channels, move (at rest friction may hold \
             whatever the load asks for), and say something of their own within the band"
        ));
    }
    Ok(reports)
}

/// Identifies one equation; again without the few seconds that own the error, where there are such.
fn run(bench: &Bench, target: Target, options: &Options) -> Option<Identified> {
    let first = once(bench, target, options)?;
    let report = &first.report;
    let owning = owning::seconds(&report.pictures, |log| {
        bench.logs.iter().any(|l| l.name == report.pictures.names[log] && l.usage == Use::Fit)
    });
    if owning.is_empty() {
        return Some(first);
    }
    let mut without = bench.clone();
    let mut findings = Vec::new();
    for (log, span, share) in owning {
        let Some(log) = without.logs.iter_mut().find(|l| l.name == report.pictures.names[log]) else { continue };
        let start = log.time.first().copied().unwrap_or(0.0);
        let (from, to) = (start + span.start, start + span.end);
        log.excluded.push(from..to);
        prepare::leave_out(log);
        findings.push(Finding { log: log.name.clone(), about: About::Owns { from, to, share } });
    }
    let mut again = once(&without, target, options)?;
    again.report.findings.extend(findings);
    again.report.evidence.owned = true;
    again.report.verdict = evidence::verdict(&again.report.evidence);
    Some(again)
}

/// Identifies one equation, in a band in which the values of what is named do not depend on it.
fn once(bench: &Bench, target: Target, options: &Options) -> Option<Identified> {
    narrowed(bench, target, options, if options.band.is_some() { NARROWED } else { 0 })
}

/// The same after the band was halved so many times.
fn narrowed(bench: &Bench, target: Target, options: &Options, times: usize) -> Option<Identified> {
    let wide = Setting::uncorrected(bench, options.band);
    let mut first = Balance::new(bench, target, &wide)?;
    let mut band = options.band;
    if band.is_none()
        && let Some(narrower) = artefacts::band_of_structure(&first)
    {
        band = Some(narrower);
        first = Balance::new(bench, target, &Setting { band, ..wide })?;
    }
    if times == 0 && first.step() > 0.0 && first.fitting() < FEWEST {
        return None;
    }
    robust::weigh(&mut first);
    let setting = |corrections| Setting { corrections, ..Setting::uncorrected(bench, band) };
    let as_declared = report::declared_stage(bench, &first);
    let model = |c: &Corrections| Some(Work::new(bench, Balance::new(bench, target, &setting(c.clone()))?));
    let mut may_be_late = artefacts::shows_lags(bench, &first);
    let mut corrections = artefacts::find(bench, first, &setting);
    let mut work = model(&corrections)?;
    let mut stages = vec![as_declared, report::corrected_stage(&work)];
    if (corrections.target_lag, corrections.motion_lag) != (0.0, 0.0) && stages[1].fit > HARM * stages[0].fit {
        // Beside numbers that are free a lag may stand for one of them; the declared ones know.
        (corrections.target_lag, corrections.motion_lag, may_be_late) = (0.0, 0.0, false);
        work = model(&corrections)?;
        stages[1] = report::corrected_stage(&work);
    }
    let mut held = work.hold_what_is_not_seen();
    let refit = work.fit();
    stages.push(work.stage(Step::Refit, &refit));
    let mut ripple = ripple::find(bench, target, &setting(corrections.clone()), &work.balance, may_be_late);
    if ripple.is_none() && (corrections.motion_lag, corrections.target_lag) != (0.0, 0.0) {
        // Ripple that nobody expects looks like a lag: without it the orders may stand out.
        let early = Corrections { motion_lag: 0.0, target_lag: 0.0, ..corrections.clone() };
        ripple = ripple::find(bench, target, &setting(early.clone()), &work.balance, may_be_late);
        if ripple.is_some() {
            corrections = early;
            work = model(&corrections)?;
            held = work.hold_what_is_not_seen();
        }
    }
    if let Some(lag) = ripple.as_ref().map(|r| r.lag).filter(|lag| *lag != 0.0) {
        // Nothing tells a lag as sharply as teeth do.
        corrections.motion_lag += lag;
        work = model(&corrections)?;
        held = work.hold_what_is_not_seen();
    }
    let (inside, ripple) = ripple.map_or((Vec::new(), None), |r| r.split(&work.balance));
    if let Some(ripple) = &ripple {
        work.take_out(ripple);
        for line in &ripple.lines {
            let fit = work.fit();
            stages.push(work.stage(Step::Added(line.fitted.effect, line.fitted.values[2]), &fit));
        }
    }
    for fitted in inside {
        let Some(order) = fitted.values.last() else { continue };
        let columns = work.balance.effect_columns(fitted.effect, *order);
        work.terms.push(Term { kind: Kind::Effect(fitted.effect, *order), columns, declared: None });
        let fit = work.fit();
        stages.push(work.stage(Step::Added(fitted.effect, *order), &fit));
    }
    let mut selection = candidates::Selection::new(&work);
    explain(&mut work, &mut selection, &mut stages);
    // Lags are found again with the effects in: a late channel and friction look alike. What the gear
    // transmits follows from its loss.
    if work.fitted_weight().is_some() {
        // Of a load that nobody knows the inertia is seen once its weight is.
        let count = held.len();
        held.retain(|which| !work.release(*which));
        if held.len() < count {
            explain(&mut work, &mut selection, &mut stages);
        }
    }
    let gear_loss = work.gear_loss();
    let shaft = work.fitted_shaft().filter(|_| gear_loss > 0.0);
    let weight = work.fitted_weight();
    let refined = may_be_late.then(|| artefacts::refine(bench, &work, &corrections, &setting)).flatten();
    let lags_alone = refined.is_some() && gear_loss <= 0.02 && weight.is_none() && shaft.is_none();
    let before =
        lags_alone.then(|| (work.clone(), selection.clone(), stages.clone(), corrections.clone(), held.clone()));
    if refined.is_some() || gear_loss > 0.02 || weight.is_some() || shaft.is_some() {
        corrections = Corrections { gear_loss, weight, shaft, ..refined.unwrap_or(corrections) };
        let renewed = model(&corrections)?;
        selection.forget();
        if weight.is_some() {
            selection.open_what_is_visible(&renewed);
        }
        held = renew(&mut work, renewed, ripple.as_ref());
        if weight.is_some() {
            held.retain(|which| !work.release(*which));
        }
        for _ in 0..SHAFT_ROUNDS {
            // Torque constant and loss of the gear follow from each other.
            let Some(shaft) = work.fitted_shaft().filter(|_| work.gear_loss() > 0.0) else { break };
            corrections = Corrections { gear_loss: work.gear_loss(), shaft: Some(shaft), ..corrections };
            held = renew(&mut work, model(&corrections)?, ripple.as_ref());
        }
        explain(&mut work, &mut selection, &mut stages);
    }
    if let Some(before) = before.filter(|(old, ..)| old.left_out_per_row() * WORSE_BY_LAGS < work.left_out_per_row()) {
        // Lags that leave more than those before are not better for fitting one model of it.
        (work, selection, stages, corrections, held) = before;
    }
    selection.back_to_the_best(&mut work);
    // What was held before the effects were known may be seen beside them; an inertia that hides the scale of the load is held.
    held.retain(|which| !work.release(*which));
    held.extend(work.hold_what_hides_load());
    work.settle_saturation();
    select::backward(&mut OnBalance { work: &mut work, selection: &mut selection, stages: &mut stages });
    let here = Setting { band: work.balance.band, ..setting(corrections.clone()) };
    for depends in band::dependent(&work, &here) {
        let band = work.balance.band?;
        if times < NARROWED {
            let half = Options { band: Some(0.5 * band) };
            let mut again = narrowed(bench, target, &half, times + 1)?;
            again.report.remarks.insert(0, depends.narrowed(band));
            return Some(again);
        }
        if options.band.is_some() && times == NARROWED {
            let is_it = |t: &usize| work.terms[*t].effect().is_some_and(|(e, _)| e == depends.effect);
            if let Some(term) = (0..work.terms.len()).find(is_it) {
                let reason = depends.refused(band);
                selection.remove(&mut work, candidates::Superfluous { term, gain: 0.0, reason });
                explain(&mut work, &mut selection, &mut stages);
            }
        }
    }
    let found = artefacts::list(&work, &corrections);
    let model = Final::of(&work, &corrections, &held);
    Some(Identified { report: report::report(work, selection, stages, found, held), model: Some(model) })
}

/// Replaces the equation and keeps the terms. Returns what is held because the logs do not show it.
fn renew<'b>(work: &mut Work<'b>, mut renewed: Work<'b>, ripple: Option<&Ripple>) -> Vec<Base> {
    let held = renewed.hold_what_is_not_seen();
    if let Some(ripple) = ripple {
        renewed.take_out(ripple);
    }
    renewed.add_again(std::mem::take(&mut work.terms));
    renewed.refine_shapes();
    *work = renewed;
    held
}

/// Adds effects and takes them back until nothing more is to be said with certainty.
fn explain(work: &mut Work, selection: &mut candidates::Selection, stages: &mut Vec<Stage>) {
    for _ in 0..STEPS {
        select::in_turn(&mut OnBalance { work, selection, stages }, STEPS);
        selection.remember(work);
        // Names that do not have the right shape are taken back: a wrong name is worse than none.
        let Some(doubtful) = structure::doubtful(work) else { return };
        selection.remove(work, doubtful);
    }
}

/// The balance judges: by blocks of time that are left out of the fit in turn.
struct OnBalance<'w, 'b> {
    work: &'w mut Work<'b>,
    selection: &'w mut candidates::Selection,
    stages: &'w mut Vec<Stage>,
}

impl Judge for OnBalance<'_, '_> {
    type Candidate = Vec<(&'static dyn Effect, f64)>;

    fn next(&mut self) -> Option<Self::Candidate> {
        Some(self.selection.next(self.work)).filter(|found| !found.is_empty())
    }

    fn add(&mut self, found: Self::Candidate) {
        for (effect, shape) in found {
            let columns = self.work.balance.effect_columns(effect, shape);
            // One whose shape stood for two is found again.
            if effect.shape() != Shape::Order {
                self.work.terms.retain(|t| t.declared.is_some() || t.effect().is_none_or(|(e, _)| e != effect));
            }
            self.work.terms.push(Term { kind: Kind::Effect(effect, shape), columns, declared: None });
            self.work.refine_shapes();
            let fit = self.work.fit();
            self.stages.push(self.work.stage(Step::Added(effect, shape), &fit));
        }
    }
}

impl Pruner for OnBalance<'_, '_> {
    type Term = candidates::Superfluous;

    fn superfluous(&mut self) -> Option<Self::Term> {
        self.selection.superfluous(self.work)
    }

    fn remove(&mut self, term: Self::Term) {
        self.selection.remove(self.work, term);
    }
}

#[cfg(test)]
pub(crate) mod steady;
