//! The report of one equation: its story, what was found, what is left, and what to measure next.

use super::balance::{Balance, applies};
use super::candidates::Selection;
use super::numbers::{errors, found, parameters};
use super::structure::{self, Dependence};
use super::work::{Kind, Work};
use crate::effects::{FittedEffect, Shape, Side, separating_run};
use crate::measured::Bench;
use crate::measured::answer::evidence::{Evidence, Gain, verdict};
use crate::measured::answer::{Artefact, Base, Found, Ground, On, Pictures, Refused, Report, Stage, Step, Unexplained};
use crate::numerics::sums::finite_sum;

/// Residual of the declared model, with the zero of each log in it.
fn declared_residual(bench: &Bench, balance: &Balance, with_zero: bool) -> Vec<f64> {
    let mut left = if with_zero { balance.target_with_zero() } else { balance.target_column() };
    let mut subtract = |column: Vec<f64>| {
        for (l, c) in left.iter_mut().zip(column) {
            *l -= c;
        }
    };
    for (index, base) in balance.base.iter().enumerate() {
        if let Some(value) = base.declared.filter(|v| v.is_finite()) {
            let column = if with_zero { balance.base_column_with_zero(index) } else { balance.base_column(index) };
            subtract(column.into_iter().map(|c| value * c).collect());
        }
    }
    for FittedEffect { effect, values } in bench.declared.all_effects() {
        if applies(effect, balance, &bench.declared) {
            if with_zero {
                subtract(balance.effect_with_zero(effect, &values));
            } else {
                let factor = balance.conversion(effect);
                subtract(balance.function(|at| factor * effect.value(&values, at)));
            }
        }
    }
    left
}

fn stage_of(step: Step, balance: &Balance, left: &[f64], target: &[f64]) -> Stage {
    let error = |fitting: bool| {
        let (mut squares, mut total, mut count) = (0.0, 0.0, 0.0);
        for k in 0..left.len() {
            if balance.rows.block_fits[balance.rows.block[k]] == fitting {
                squares += left[k] * left[k];
                total += target[k] * target[k];
                count += 1.0;
            }
        }
        let vaf = if total > 0.0 { 100.0 * (1.0 - squares / total) } else { 0.0 };
        (count > 0.0).then(|| ((squares / count).sqrt(), vaf))
    };
    let (fit, held) = (error(true), error(false));
    Stage::new(step, fit, held)
}

/// The error as declared: nothing corrected.
pub(crate) fn declared_stage(bench: &Bench, balance: &Balance) -> Stage {
    stage_of(Step::Declared, balance, &declared_residual(bench, balance, true), &balance.target_column())
}

/// The error of the declared model after artefacts were taken out.
pub(crate) fn corrected_stage(work: &Work) -> Stage {
    let left = declared_residual(work.bench, &work.balance, false);
    stage_of(Step::Artefacts, &work.balance, &left, &work.balance.target_column())
}

/// Makes the report.
pub fn report(
    mut work: Work,
    mut selection: Selection,
    mut stages: Vec<Stage>,
    mut artefacts: Vec<Artefact>,
    held: Vec<Base>,
) -> Report {
    // Names that do not have the right shape are taken back: a wrong name is worse than none.
    let (mut left, mut shares) = structure::left(&work, &work.fit());
    while let Some((term, reason)) = doubtful(&work, &shares) {
        let removed = work.terms.remove(term);
        if let Kind::Effect(effect, _) = removed.kind {
            selection.refused.retain(|r| r.name != effect.name());
            selection.refused.push(Refused::new(effect.name(), reason));
        }
        (left, shares) = structure::left(&work, &work.fit());
    }
    let fit = work.fit();
    let last = work.stage(Step::Final, &fit);
    let held_out = last.held_out;
    let accounted = (last.fit_vaf, last.held_out_vaf);
    stages.push(last);
    let effects = found(&work, &selection);
    let (asked, together) = selection.asked(&work, &fit);
    let before = declared_residual(work.bench, &work.balance, false);
    let refitting = Gain::new(&block_squares(&work, &before), &fit.left_out);
    // Against a constant: what a model without any column would say.
    let mut constant = work.balance.target_column();
    let mean = constant.iter().sum::<f64>() / constant.len().max(1) as f64;
    constant.iter_mut().for_each(|value| *value -= mean);
    let explains = Gain::new(&block_squares(&work, &constant), &fit.left_out);
    let channel = work.balance.target.channel();
    let evidence = Evidence {
        found: effects.len(),
        unexplained: left.len(),
        left: work.left_out_error(&fit),
        held_out,
        noise: super::noise::noise(&work.unfiltered(fit.solution.coefficients.as_slice()), work.balance.band),
        asked,
        together: Some(together),
        worse_by_refitting: refitting.is_harm(),
        dead: channel.filter(|channel| work.bench.is_dead(*channel)),
        unrelated: channel.is_some() && Evidence::does_not_follow(accounted.0, accounted.1, explains),
    };
    artefacts.extend(super::artefacts::zeros(&work));
    let (names, matrix, solution, _) = errors(&work);
    let parameters = parameters(&work, &names, &matrix, &solution, &held);
    let pictures = Pictures {
        time: work.balance.rows.time.clone(),
        log: work.balance.rows.log.clone(),
        names: work.balance.names.clone(),
        before,
        after: work.residual(&fit),
        speed: work.balance.variable(false, |at| at.speed),
        angle: work.balance.variable(false, |at| at.angle),
        current: work.balance.variable(false, |at| at.current),
        temperature: work.balance.variable(false, |at| at.winding_rise),
    };
    let mut remarks = work.balance.remarks.clone();
    if work.balance.split_log {
        remarks.push("no log is held out: every fifth block of time judges instead".into());
    }
    let next_runs = next_runs(&effects, &selection, &left, &work);
    Report {
        target: work.balance.target,
        unit: work.balance.unit,
        band: work.balance.band,
        samples: (work.balance.samples(), work.balance.rows.len()),
        verdict: verdict(&evidence),
        evidence,
        stages,
        artefacts,
        parameters,
        effects,
        refused: selection.refused,
        unexplained: left
            .into_iter()
            .map(|Dependence { on, detail, .. }| Unexplained { depends_on: on, detail })
            .collect(),
        next_runs,
        remarks,
        fitted_names: names,
        covariance: matrix.row_iter().map(|r| r.iter().copied().collect()).collect(),
        pictures,
    }
}

/// Squared residuals of each block that is for fitting; NaN of the others.
fn block_squares(work: &Work, residual: &[f64]) -> Vec<f64> {
    let mut sums: Vec<f64> = work.folds.iter().map(|fold| fold.map_or(f64::NAN, |_| 0.0)).collect();
    for (r, block) in residual.iter().zip(&work.balance.rows.block) {
        sums[*block] += r * r;
    }
    sums
}

/// An effect whose own variable still explains much of what is left, measured by what the effect itself
/// explains.
fn doubtful(work: &Work, shares: &[(On, f64)]) -> Option<(usize, String)> {
    let fit = work.fit();
    let now = finite_sum(&fit.left_out);
    (0..work.terms.len()).find_map(|t| {
        let term = &work.terms[t];
        let (effect, _) = term.effect()?;
        if term.declared.is_some() || effect.shape() == Shape::Order {
            return None;
        }
        let explains = finite_sum(&work.left_out_without(t)) - now;
        let is_its_own = |on: On| matches!(on, On::Variable(v) if effect.needs().contains(&v));
        let (on, share) = shares.iter().find(|(on, _)| is_its_own(*on))?;
        let left = share * now;
        // A shape parameter bends a wrong curve nearly right: what it leaves weighs more.
        let tolerated = if effect.shape() == Shape::None { 0.15 } else { 0.04 };
        (left > tolerated * explains && left > 0.0).then(|| {
            let name = on.name();
            (
                t,
                format!(
                    "it has not the right shape: a free function of {name} takes away {:.0} % more than it does",
                    100.0 * left / explains.max(f64::MIN_POSITIVE)
                ),
            )
        })
    })
}

/// Runs that would tell look-alikes apart, or show what this bench hides.
fn next_runs(effects: &[Found], selection: &Selection, left: &[Dependence], work: &Work) -> Vec<String> {
    let mut runs: Vec<String> = Vec::new();
    for effect in effects {
        for rival in &effect.confounded_with {
            let run = separating_run(effect.effect, *rival);
            runs.push(format!("`{}` or `{}`: {run}", effect.name(), rival.name()));
        }
    }
    if effects.iter().any(|e| e.effect.side() == Side::Either) && work.bench.declared.ratio != 1.0 {
        runs.push(
            "friction before or behind the gear: with one ratio they look alike, and N* depends on it; a run of the motor \
             without its gear would separate them"
                .into(),
        );
    }
    let refused = |is: fn(Ground) -> bool| selection.refused.iter().any(|r| is(r.ground));
    let drifts = left.iter().any(|d| d.on.drifts()) || refused(|ground| ground == Ground::Drift);
    if drifts && refused(|ground| matches!(ground, Ground::Lacks(v) if v.is_temperature())) {
        runs.push("log winding and housing temperature, so that warm-up and drift can be separated".into());
    }
    runs.dedup();
    runs
}

#[cfg(test)]
mod tests;
