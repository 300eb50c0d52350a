//! Declared model against logs: what the model lacks, by how much, and how sure that is.
//!
//! The one idea: every explanation has to earn its name. Corrections of the measurement come first, then
//! the parameters that the model has, then effects that it lacks, one at a time, each judged on what was
//! left out, against chance over everything that was tried, against what is physically plausible and
//! against explanations without a name (a drift, any function of speed, of current, of position). What is
//! left and still depends on something is reported as such.

pub mod artefacts;
pub(crate) mod balance;
mod candidates;
mod flexible;
pub mod noise;
mod numbers;
pub(crate) mod origin;
mod refit;
pub(crate) mod regression;
mod report;
mod structure;
mod work;

pub use crate::measured::answer::evidence::{self, Evidence, Verdict};
pub use crate::measured::answer::{
    Artefact, ArtefactKind, Found, Ground, On, Parameter, Pictures, Refused, Report, Stage, Step, Target, Unexplained,
};
pub use balance::{Balance, Corrections, Setting, targets};

use self::work::{Kind, Term, Work};
use crate::effects::Effect;
use crate::measured::select::{self, Judge, Pruner};
use crate::measured::{Bench, simulate};

/// What identification is run with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Cut-off of the filter \[Hz\]; chosen from the data where not given.
    pub band: Option<f64>,
}

/// Most rows that regressions see.
const ROWS: usize = 24_000;
/// Most effects and orders that are added one after the other.
const STEPS: usize = 16;

/// Identifies every equation that the bench shows.
///
/// # Errors
/// In words, where the logs say nothing that can be compared.
pub fn identify(bench: &Bench, options: &Options) -> Result<Vec<Report>, String> {
    let targets = targets(bench);
    let simulated = simulate::serves(bench);
    if targets.is_empty() && !simulated {
        return Err("no log for fitting has the channels of an equation: torque or a known load and a current, \
                    or a voltage, with a velocity or a position"
            .into());
    }
    let mut reports: Vec<Report> = targets.into_iter().filter_map(|target| run(bench, target, options)).collect();
    if simulated {
        reports.extend(simulate::identify_servo(bench));
    }
    if reports.is_empty() {
        return Err("nothing can be learnt: no log has 16 samples in a row with all channels, moving".into());
    }
    Ok(reports)
}

fn run(bench: &Bench, target: Target, options: &Options) -> Option<Report> {
    let wide = Setting {
        corrections: Corrections::none(bench.logs.len()),
        band: options.band,
        rows: ROWS,
        samples: usize::MAX,
    };
    let mut first = Balance::new(bench, target, &wide)?;
    let mut band = options.band;
    if band.is_none()
        && let Some(narrower) = artefacts::band_of_structure(&first)
    {
        band = Some(narrower);
        first = Balance::new(bench, target, &Setting { band, ..wide })?;
    }
    let setting = |corrections| Setting { corrections, band, rows: ROWS, samples: usize::MAX };
    let as_declared = report::declared_stage(bench, &first);
    let mut corrections = artefacts::find(bench, first, &setting);
    let balance = Balance::new(bench, target, &setting(corrections.clone()))?;
    let mut work = Work::new(bench, balance);
    let mut stages = vec![as_declared, report::corrected_stage(&work)];
    let held = work.hold_what_is_not_seen();
    let refit = work.fit();
    stages.push(work.stage(Step::Refit, &refit));
    let mut selection = candidates::Selection::new(&work);
    select::forward(&mut OnBalance { work: &mut work, selection: &mut selection, stages: &mut stages }, STEPS);
    // Lags are found again with the effects in: a late channel and friction look alike. What the gear
    // transmits follows from its loss.
    let gear_loss = work.gear_loss();
    let refined = artefacts::refine(bench, &work, &corrections, &setting);
    if refined.is_some() || gear_loss > 0.02 {
        corrections = Corrections { gear_loss, ..refined.unwrap_or(corrections) };
        let balance = Balance::new(bench, target, &setting(corrections.clone()))?;
        let terms = std::mem::take(&mut work.terms);
        work = Work::new(bench, balance);
        work.hold_what_is_not_seen();
        for term in terms {
            if let (Kind::Effect(effect, shape), None) = (term.kind, &term.declared) {
                let columns = work.balance.effect_columns(effect, shape);
                work.terms.push(Term { columns, ..term });
            }
        }
        work.refine_shapes();
    }
    select::backward(&mut OnBalance { work: &mut work, selection: &mut selection, stages: &mut stages });
    work.settle_saturation();
    let found = artefacts::list(&work, &corrections);
    Some(report::report(work, selection, stages, found, held))
}

/// The balance judges: by blocks of time that are left out of the fit in turn.
struct OnBalance<'w, 'b> {
    work: &'w mut Work<'b>,
    selection: &'w mut candidates::Selection,
    stages: &'w mut Vec<Stage>,
}

impl Judge for OnBalance<'_, '_> {
    type Candidate = (&'static dyn Effect, f64);

    fn next(&mut self) -> Option<Self::Candidate> {
        self.selection.next(self.work)
    }

    fn add(&mut self, (effect, shape): Self::Candidate) {
        let columns = self.work.balance.effect_columns(effect, shape);
        self.work.terms.push(Term { kind: Kind::Effect(effect, shape), columns, declared: None });
        self.work.refine_shapes();
        let fit = self.work.fit();
        self.stages.push(self.work.stage(Step::Added(effect, shape), &fit));
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
