//! The report of one equation: its story, what was found, what is left, and what to measure next.

use super::balance::{Balance, Setting, applies};
use super::candidates::{Selection, held_look_alike};
use super::numbers::{errors, found, parameters};
use super::structure::{self, Dependence};
use super::work::Work;
use super::{Options, robust};
use crate::Bench;
use crate::answer::evidence::{Evidence, Gain, verdict};
use crate::answer::{
    Artefact, Base, Finding, Found, Ground, Parameter, Pictures, Report, Stage, Step, Target, Unexplained,
};
use gearwise_model::effects::{FittedEffect, Side, separating_run};

/// What is undecided is most of a ± from so many standard errors of the model on.
const MOSTLY: f64 = 2.0;
/// What does less than this many times the instrument's noise does nothing.
const STILL: f64 = 1.3;

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
    Stage::new(step, balance.rows.error(left, target, true), balance.rows.error(left, target, false))
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

/// What is said of logs whose channels contradict each other: their error as declared, and nothing else. `None` where the
/// equation has no rows.
pub fn as_declared(bench: &Bench, target: Target, options: &Options, findings: &[Finding]) -> Option<Report> {
    let mut balance = Balance::new(bench, target, &Setting::uncorrected(bench, options.band))?;
    robust::weigh(&mut balance);
    let declared = declared_stage(bench, &balance);
    let last = Stage { step: Step::Final, ..declared.clone() };
    let nothing = contradicted(target, balance.unit, findings);
    let evidence = Evidence { left: declared.fit, held_out: declared.held_out, ..nothing.evidence.clone() };
    Some(Report {
        band: balance.band,
        samples: (balance.samples(), balance.rows.len()),
        evidence,
        stages: vec![declared, last],
        remarks: balance.remarks.clone(),
        ..nothing
    })
}

/// A report that says nothing but what contradicts itself.
pub fn contradicted(target: Target, unit: &'static str, findings: &[Finding]) -> Report {
    let evidence = Evidence { contradicted: true, left: f64::NAN, ..Evidence::default() };
    Report {
        target,
        unit,
        band: None,
        samples: (0, 0),
        verdict: verdict(&evidence),
        evidence,
        stages: Vec::new(),
        findings: findings.to_vec(),
        artefacts: Vec::new(),
        parameters: Vec::new(),
        effects: Vec::new(),
        refused: Vec::new(),
        unexplained: Vec::new(),
        next_runs: Vec::new(),
        remarks: Vec::new(),
        fitted_names: Vec::new(),
        covariance: Vec::new(),
        pictures: Pictures::default(),
    }
}

/// Makes the report.
pub fn report(
    work: Work,
    mut selection: Selection,
    mut stages: Vec<Stage>,
    mut artefacts: Vec<Artefact>,
    held: Vec<Base>,
) -> Report {
    let (left, _) = structure::left(&work, &work.fit());
    let fit = work.fit();
    let last = work.stage(Step::Final, &fit);
    let accounted = (last.fit_vaf, last.held_out_vaf);
    stages.push(last);
    let (asked, together, undecided) = selection.asked(&work, &fit);
    let numbers = errors(&work);
    let effects = found(&work, &selection, &numbers, &undecided);
    let before = declared_residual(work.bench, &work.balance, false);
    let refitting = Gain::new(&block_squares(&work, &before), &fit.left_out);
    // Against a constant: what a model without any column would say.
    let mut constant = work.balance.target_column();
    let mean = constant.iter().sum::<f64>() / constant.len().max(1) as f64;
    constant.iter_mut().for_each(|value| *value -= mean);
    let explains = Gain::new(&block_squares(&work, &constant), &fit.left_out);
    let noise = super::noise::noise(&work.unfiltered(fit.solution.coefficients.as_slice()), work.balance.band);
    // Nor would the declared model have it do more.
    let expected: Vec<f64> = work.balance.target_column().iter().zip(&before).map(|(y, left)| y - left).collect();
    let is_noise = |values: &[f64]| {
        let does = work.balance.rows.error_alike(values, true);
        noise.floor().zip(does).is_some_and(|(floor, does)| does < STILL * floor)
    };
    let still = is_noise(&constant) && is_noise(&expected);
    let channel = work.balance.target.channel();
    let after = work.residual(&fit);
    let evidence = Evidence {
        found: effects.len(),
        unexplained: left.len(),
        left: work.of_all_rows(&after, &fit.left_out),
        far_off: robust::far_off(&work.balance.rows, &after),
        held_out: work.balance.rows.error_alike(&after, false),
        noise,
        still,
        asked,
        together: Some(together),
        better: selection.better(&fit.left_out).map(|left_out| work.of_all_rows(&after, left_out)),
        worse_by_refitting: refitting.is_harm(),
        contradicted: false,
        owned: false,
        worse_held_out: false,
        left_out: work.bench.declared.without.len(),
        dead: channel.filter(|channel| work.bench.is_dead(*channel)),
        unrelated: channel.is_some() && Evidence::does_not_follow(accounted.0, accounted.1, explains),
    };
    let (zeros, findings) = super::artefacts::zeros(&work);
    artefacts.extend(zeros);
    let parameters = parameters(&work, &numbers, &undecided, &held);
    let pictures = Pictures {
        time: work.balance.rows.time.clone(),
        log: work.balance.rows.log.clone(),
        names: work.balance.names.clone(),
        before,
        after,
        speed: work.balance.variable(false, |at| at.speed),
        angle: work.balance.variable(false, |at| at.angle),
        current: work.balance.variable(false, |at| at.current),
        temperature: work.balance.variable(false, |at| at.winding_rise),
    };
    let mut remarks = work.balance.remarks.clone();
    if work.balance.split_log {
        remarks.push("no log is held out: every fifth block of time judges instead".into());
    }
    remarks.extend(work.ripple.iter().flat_map(|r| r.said(work.balance.band, work.balance.unit)));
    for (effect, objection) in selection.objections.iter().filter(|(e, _)| effects.iter().any(|f| f.effect == *e)) {
        remarks.push(format!("{}: {objection}", effect.title()));
    }
    for (t, term) in work.terms.iter().enumerate().filter(|(_, t)| t.declared.is_none()) {
        let alike = term.effect().and_then(|(effect, _)| Some((effect, held_look_alike(&work, t, &held)?)));
        remarks.extend(alike.map(|(effect, which)| {
            format!(
                "`{}` is held as declared; another value of it would explain `{}` as well",
                which.name(),
                effect.name()
            )
        }));
    }
    remarks.extend(convention(&parameters));
    let named = effects.iter().flat_map(|e| e.parameters.iter().map(|p| (format!("{}.{}", e.name(), p.name), p)));
    remarks.extend(named.chain(parameters.iter().map(|p| (p.name.clone(), p))).filter_map(|(name, p)| loose(&name, p)));
    let next_runs = next_runs(&effects, &selection, &left, &work);
    // Another order of what was found is told with what the verdict rests on.
    selection.refused.retain(|r| !effects.iter().any(|e| e.name() == r.name));
    Report {
        target: work.balance.target,
        unit: work.balance.unit,
        band: work.balance.band,
        samples: (work.balance.samples(), work.balance.rows.len()),
        verdict: verdict(&evidence),
        evidence,
        stages,
        findings,
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
        fitted_names: numbers.names,
        covariance: numbers.covariance.row_iter().map(|r| r.iter().copied().collect()).collect(),
        pictures,
    }
}

/// Which conventions of ampere the declared numbers would be off by as much as they are, where that is sure: K_T against a
/// sensor or a known load; R, where L says the same.
fn convention(parameters: &[Parameter]) -> Option<String> {
    let of_current = [
        (1.5_f64.sqrt(), "a phase amplitude that is taken for the q axis"),
        (3.0_f64.sqrt(), "a phase current in rms that is taken for the q axis"),
        (2.0_f64.sqrt(), "a current in rms that is taken for an amplitude"),
        (1.5_f64.sqrt().recip(), "a current of the q axis that is taken for a phase amplitude"),
        (3.0_f64.sqrt().recip(), "a current of the q axis that is taken for a phase current in rms"),
        (2.0_f64.sqrt().recip(), "an amplitude that is taken for a current in rms"),
    ];
    // A hint to check, no claim: what is undecided does not hide it.
    let alone = |p: &Parameter| Parameter { undecided: None, ..p.clone() };
    let named = |base: Base| parameters.iter().find(|p| p.name == base.name()).map(alone);
    let off = |p: &Parameter| Some((1.0 + p.shift()?, p.tolerance()? / p.declared?));
    let is = |(ratio, error): (f64, f64), factor: f64| (ratio / factor - 1.0).abs() < 0.015 + error.min(0.01);
    let inductance = named(Base::Inductance).and_then(|p| Some((p.fitted / p.declared?, p.tolerance()? / p.declared?)));
    let alike = |factor: f64| inductance.is_none_or(|(l, e)| (l / factor - 1.0).abs() < 0.03 + e);
    let (base, ratio, what) = [Base::TorqueConstant, Base::Resistance].into_iter().find_map(|base| {
        let (ratio, error) = off(&named(base)?)?;
        let is_it = |f: f64| is((ratio, error), f) && (base != Base::Resistance || alike(f));
        let (_, what) = of_current.into_iter().find(|(f, _)| is_it(*f))?;
        Some((base, ratio, what))
    })?;
    let name = base.name().replace('_', " ");
    Some(format!("the {name} comes out {ratio:.3} times the declared one, as {what} would make it: check `convention`"))
}

/// What the ± of a number is mostly made of, where that is not the scatter of these logs.
fn loose(name: &str, parameter: &Parameter) -> Option<String> {
    let undecided =
        parameter.undecided.filter(|u| parameter.standard_error.is_some_and(|error| u.by > MOSTLY * error))?;
    let effect = undecided.effect.name();
    Some(format!(
        "the ± of `{name}` is mostly what `{effect}` would make of it, which these logs neither show nor rule out"
    ))
}

/// Squared residuals of each block that is for fitting; NaN of the others.
fn block_squares(work: &Work, residual: &[f64]) -> Vec<f64> {
    let mut sums: Vec<f64> = work.folds.iter().map(|fold| fold.map_or(f64::NAN, |_| 0.0)).collect();
    let rows = &work.balance.rows;
    for (k, r) in residual.iter().enumerate() {
        sums[rows.block[k]] += rows.weight(k) * r * r;
    }
    sums
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
