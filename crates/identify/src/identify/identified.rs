//! A report with the model that it tells of, as it stands in the end.

use std::sync::Arc;

use super::balance::{Balance, Corrections};
use super::orders::Ripple;
use super::work::{Term, Work};
use crate::Bench;
use crate::answer::{Base, Report};
use gearwise_model::effects::FittedEffect;

/// What identification says of one equation, and the model behind it.
#[derive(Debug, Clone)]
pub struct Identified {
    /// What is said.
    pub report: Report,
    /// The final model; `None` of an equation that is simulated, and of logs that contradict themselves.
    pub(crate) model: Option<Final>,
}

impl Identified {
    /// A report without a model that one could ask further.
    pub(super) fn without_model(report: Report) -> Identified {
        Identified { report, model: None }
    }
}

/// The final model of one equation, without its bench.
#[derive(Debug, Clone)]
pub(crate) struct Final {
    balance: Arc<Balance>,
    target: Vec<f64>,
    terms: Vec<Term>,
    fixed: Vec<FittedEffect>,
    ripple: Option<Arc<Ripple>>,
    folds: Vec<Option<usize>>,
    /// Corrections of the measurement that its balance was built with.
    pub corrections: Corrections,
    /// Parameters that are held as declared.
    pub held: Vec<Base>,
}

impl Final {
    /// Of the work as it stands.
    pub fn of(work: &Work, corrections: &Corrections, held: &[Base]) -> Final {
        Final {
            balance: work.balance.clone(),
            target: work.target.clone(),
            terms: work.terms.clone(),
            fixed: work.fixed.clone(),
            ripple: work.ripple.clone(),
            folds: work.folds.clone(),
            corrections: corrections.clone(),
            held: held.to_vec(),
        }
    }

    /// The work, to be asked further.
    pub fn work<'b>(&self, bench: &'b Bench) -> Work<'b> {
        Work {
            bench,
            balance: self.balance.clone(),
            target: self.target.clone(),
            terms: self.terms.clone(),
            fixed: self.fixed.clone(),
            ripple: self.ripple.clone(),
            folds: self.folds.clone(),
        }
    }
}
