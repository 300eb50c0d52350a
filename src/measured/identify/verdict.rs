//! What identification says in the end: stages, parameters, effects, refusals, what is left.

use super::artefacts::Artefact;
use super::balance::{Balance, Hidden, Target, applies, declared_effects};
use super::candidates::Selection;
use super::evidence::{Evidence, Gain, Verdict, verdict};
use super::regression::{Blocks, Solution, covariance, finite_sum};
use super::structure::{self, Dependence};
use super::{Kind, Term, Work};
use crate::effects::{Effect, Enters, Shape};
use crate::measured::Bench;

/// Error at one point of the story, root mean square in the unit of the target.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// `declared`, `artefacts`, `refit`, the effect that was added, or `final`.
    pub name: String,
    /// On the logs for fitting.
    pub fit: f64,
    /// Variance accounted for \[%\].
    pub fit_vaf: f64,
    /// On what was held out.
    pub held_out: Option<f64>,
    /// Variance accounted for \[%\].
    pub held_out_vaf: Option<f64>,
}

impl Stage {
    /// From error and variance accounted for \[%\] on either part; without data to fit they are not numbers.
    pub fn new(name: &str, fit: Option<(f64, f64)>, held_out: Option<(f64, f64)>) -> Stage {
        Stage {
            name: name.into(),
            fit: fit.map_or(f64::NAN, |e| e.0),
            fit_vaf: fit.map_or(f64::NAN, |e| e.1),
            held_out: held_out.map(|e| e.0),
            held_out_vaf: held_out.map(|e| e.1),
        }
    }
}

/// A parameter of the declared model, refitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Declared value.
    pub declared: Option<f64>,
    /// Fitted value; the declared one where the data do not show it.
    pub fitted: f64,
    /// Standard error; `None` where it was held.
    pub standard_error: Option<f64>,
    /// SI unit.
    pub unit: &'static str,
}

/// An effect that the model lacked.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Name in the library.
    pub name: &'static str,
    /// Equation.
    pub equation: &'static str,
    /// Its parameters, over all orders.
    pub parameters: Vec<Parameter>,
    /// Values of each instance (several orders), in the order of the effect's parameters.
    pub instances: Vec<Vec<f64>>,
    /// Root mean square of what it adds to the target.
    pub size: f64,
    /// Held-out error without it.
    pub held_out_before: Option<f64>,
    /// Held-out error with it.
    pub held_out_after: Option<f64>,
    /// Effects that the data cannot tell from it.
    pub confounded_with: Vec<&'static str>,
    /// How it enters the limits of the model.
    pub enters: Enters,
}

/// An effect that was not added.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused {
    /// Name.
    pub name: String,
    /// Why.
    pub reason: String,
    /// What kind of reason that is.
    pub ground: Ground,
}

/// On what ground an effect was not added.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ground {
    /// It was asked and did not earn its name.
    Judged,
    /// Another equation of the actuator has it.
    Elsewhere,
    /// The bench does not show it.
    Bench,
    /// Its regressor is made of the response; this measurement would show it.
    Response(&'static str),
}

impl Refused {
    /// Of an effect that was asked.
    pub fn new(name: &str, reason: String) -> Refused {
        Refused { name: name.into(), reason, ground: Ground::Judged }
    }

    /// Of an effect that cannot be asked.
    pub fn hidden(name: &str, hidden: Hidden) -> Refused {
        let (reason, ground) = match hidden {
            Hidden::Elsewhere => ("this bench does not measure its equation".to_string(), Ground::Elsewhere),
            Hidden::Bench(why) => (why.to_string(), Ground::Bench),
            Hidden::Response(shown_by) => (
                format!(
                    "cannot be seen on this bench: its regressor is made of the response, which would explain itself; \
                     {shown_by} would show it"
                ),
                Ground::Response(shown_by),
            ),
        };
        Refused { name: name.into(), reason, ground }
    }
}

/// What is left and on what it depends.
#[derive(Debug, Clone, PartialEq)]
pub struct Unexplained {
    /// The variable.
    pub depends_on: String,
    /// In words.
    pub detail: String,
}

/// What identification says about one equation.
#[derive(Debug, Clone)]
pub struct Report {
    /// The equation.
    pub target: Target,
    /// Unit of errors.
    pub unit: &'static str,
    /// Cut-off of the filter \[Hz\].
    pub band: Option<f64>,
    /// Samples that were read, and rows that the regression saw.
    pub samples: (usize, usize),
    /// What the verdict rests on: what is left, the instrument's noise, what was asked.
    pub evidence: Evidence,
    /// The verdict.
    pub verdict: Verdict,
    /// The story, first as declared, last as it stands.
    pub stages: Vec<Stage>,
    /// Artefacts of the measurement.
    pub artefacts: Vec<Artefact>,
    /// Parameters of the declared model.
    pub parameters: Vec<Parameter>,
    /// Effects that the model lacked.
    pub effects: Vec<Found>,
    /// Effects that were not added.
    pub refused: Vec<Refused>,
    /// What is left.
    pub unexplained: Vec<Unexplained>,
    /// What to measure next.
    pub next_runs: Vec<String>,
    /// What should be known.
    pub remarks: Vec<String>,
    /// Names of all fitted numbers, in the order of `covariance`.
    pub fitted_names: Vec<String>,
    /// Their covariance, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Residual as declared (corrected) and in the end, for the pictures.
    pub pictures: Pictures,
}

impl Report {
    /// A lag of a channel \[s\], as the list of artefacts has it.
    pub(crate) fn lag(channel: &str, value: f64) -> Artefact {
        Artefact { kind: "lag", channel: channel.into(), value, unit: "s" }
    }
}

/// Columns for the pictures: one entry for each row of the regression.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    /// Time in its log \[s\].
    pub time: Vec<f64>,
    /// Log of each row.
    pub log: Vec<usize>,
    /// Names of the logs.
    pub names: Vec<String>,
    /// Residual of the declared model after corrections \[unit\].
    pub before: Vec<f64>,
    /// Residual in the end \[unit\].
    pub after: Vec<f64>,
    /// Motor speed \[rad/s\].
    pub speed: Vec<f64>,
    /// Motor angle \[rad\].
    pub angle: Vec<f64>,
    /// Current \[A\].
    pub current: Vec<f64>,
    /// Winding temperature over the reference \[K\].
    pub temperature: Vec<f64>,
}

/// Label of an effect in the story.
pub fn label(effect: &dyn Effect, shape: f64) -> String {
    match effect.shape() {
        Shape::Order => format!("{} order {shape}", effect.name()),
        _ => effect.name().to_string(),
    }
}

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
    for (effect, values) in declared_effects(&bench.declared) {
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

fn stage_of(name: &str, balance: &Balance, left: &[f64], target: &[f64]) -> Stage {
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
    Stage::new(name, fit, held)
}

/// The error as declared: nothing corrected.
pub fn declared_stage(bench: &Bench, balance: &Balance) -> Stage {
    stage_of("declared", balance, &declared_residual(bench, balance, true), &balance.target_column())
}

/// The error of the declared model after artefacts were taken out.
pub fn corrected_stage(work: &Work) -> Stage {
    let left = declared_residual(work.bench, &work.balance, false);
    stage_of("artefacts", &work.balance, &left, &work.balance.target_column())
}

/// Makes the report.
pub fn report(
    mut work: Work,
    mut selection: Selection,
    mut stages: Vec<Stage>,
    mut artefacts: Vec<Artefact>,
    held: Vec<&'static str>,
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
    let mut last = work.stage("final".into(), &fit);
    last.name = "final".into();
    stages.push(last.clone());
    let effects = found(&work, &selection);
    let (asked, together) = selection.asked(&work, &fit);
    let before = declared_residual(work.bench, &work.balance, false);
    let refitting = Gain::new(&block_squares(&work, &before), &fit.left_out);
    let evidence = Evidence {
        found: effects.len(),
        unexplained: left.len(),
        left: work.left_out_error(&fit),
        held_out: last.held_out,
        noise: super::noise::noise(&work, fit.solution.coefficients.as_slice()),
        asked,
        together: Some(together),
        worse_by_refitting: refitting.is_harm(),
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
fn doubtful(work: &Work, shares: &[(Option<crate::effects::Variable>, f64)]) -> Option<(usize, String)> {
    let fit = work.fit();
    let now = finite_sum(&fit.left_out);
    (0..work.terms.len()).find_map(|t| {
        let term = &work.terms[t];
        let (effect, _) = term.effect()?;
        if term.declared.is_some() || effect.shape() == Shape::Order {
            return None;
        }
        let explains = finite_sum(&work.left_out_without(t)) - now;
        let (variable, share) = shares.iter().find(|(v, _)| v.is_some_and(|v| effect.needs().contains(&v)))?;
        let left = share * now;
        // A shape parameter bends a wrong curve nearly right: what it leaves weighs more.
        let tolerated = if effect.shape() == Shape::None { 0.15 } else { 0.04 };
        (left > tolerated * explains && left > 0.0).then(|| {
            let name = variable.map_or("its variable", |v| v.name());
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

/// Names, covariance and values of every fitted number; shape parameters by their derivative.
fn errors(work: &Work) -> (Vec<String>, nalgebra::DMatrix<f64>, Vec<f64>, Solution) {
    let fit = work.fit();
    let mut names = Vec::new();
    let mut values: Vec<f64> = Vec::new();
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for (t, term) in work.terms.iter().enumerate() {
        let offset = work.offset(t);
        let coefficients: Vec<f64> = (0..term.columns.len()).map(|j| fit.solution.coefficients[offset + j]).collect();
        columns.extend(term.columns.iter().cloned());
        values.extend(&coefficients);
        match term.kind {
            Kind::Base(index) => names.push(work.balance.base[index].name.to_string()),
            Kind::Effect(effect, shape) => {
                for parameter in &effect.parameters()[..effect.linear()] {
                    names.push(number_name(effect, shape, parameter.name));
                }
                if effect.name() == "torque_constant_saturation" {
                    // Slope and current are one number where saturation is weak: the current follows the slope.
                    continue;
                }
                if !matches!(effect.shape(), Shape::None | Shape::Order) {
                    let h = 1e-3 * shape;
                    let (up, down) = (
                        work.balance.effect_columns(effect, shape + h),
                        work.balance.effect_columns(effect, shape - h),
                    );
                    let slope = (0..work.balance.rows.len())
                        .map(|k| {
                            coefficients.iter().enumerate().map(|(j, c)| c * (up[j][k] - down[j][k])).sum::<f64>()
                                / (2.0 * h)
                        })
                        .collect();
                    columns.push(slope);
                    names.push(number_name(effect, shape, effect.parameters()[effect.linear()].name));
                    values.push(shape);
                }
            }
        }
    }
    // The residual is that of the fit: linearised at its values, the shape's own step is zero.
    let residual = work.residual(&fit);
    let references: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let blocks = Blocks::new(&work.balance.rows, &references, &residual);
    let solution = super::regression::solve(&blocks.total(|b| work.fits(b)));
    let matrix = covariance(&blocks, &solution, |b| work.fits(b));
    (names, matrix, values, solution)
}

fn number_name(effect: &dyn Effect, shape: f64, parameter: &str) -> String {
    match effect.shape() {
        Shape::Order => format!("{}.{shape}.{parameter}", effect.name()),
        _ => format!("{}.{parameter}", effect.name()),
    }
}

fn parameters(
    work: &Work,
    names: &[String],
    matrix: &nalgebra::DMatrix<f64>,
    values: &[f64],
    held: &[&'static str],
) -> Vec<Parameter> {
    let mut list = Vec::new();
    let error = |name: &str| names.iter().position(|n| n == name).map(|i| (values[i], matrix[(i, i)].max(0.0).sqrt()));
    for base in &work.balance.base {
        match error(base.name) {
            // A load that seems scaled is a torque constant that is.
            Some((value, error)) if base.name == "load_scale" => {
                let constant = work.balance.scale.torque_constant;
                list.push(Parameter {
                    name: "torque_constant".into(),
                    declared: Some(constant),
                    fitted: constant / value,
                    standard_error: Some(constant * error / (value * value)),
                    unit: "N*m/A",
                });
            }
            Some((value, error)) => list.push(Parameter {
                name: base.name.into(),
                declared: base.declared,
                fitted: value,
                standard_error: Some(error),
                unit: base.unit,
            }),
            None if held.contains(&base.name) => {
                if let Some(declared) = base.declared {
                    list.push(Parameter {
                        name: base.name.into(),
                        declared: base.declared,
                        fitted: declared,
                        standard_error: None,
                        unit: base.unit,
                    });
                }
            }
            None => {}
        }
    }
    for term in work.terms.iter().filter(|t| t.declared.is_some()) {
        let Some((effect, shape)) = term.effect() else { continue };
        for (j, parameter) in effect.parameters()[..effect.linear()].iter().enumerate() {
            let name = number_name(effect, shape, parameter.name);
            if let Some((value, error)) = error(&name) {
                list.push(Parameter {
                    name,
                    declared: term.declared.as_ref().map(|d| d[j]),
                    fitted: value,
                    standard_error: Some(error),
                    unit: parameter.kind.si,
                });
            }
        }
    }
    list
}

fn found(work: &Work, selection: &Selection) -> Vec<Found> {
    let fit = work.fit();
    let (names, matrix, values, _) = errors(work);
    let mut list: Vec<Found> = Vec::new();
    let missing = |t: &Term| t.declared.is_none() && t.effect().is_some();
    for (t, term) in work.terms.iter().enumerate().filter(|(_, t)| missing(t)) {
        let Some((effect, shape)) = term.effect() else { continue };
        let offset = work.offset(t);
        let mut instance: Vec<f64> = (0..effect.linear()).map(|j| fit.solution.coefficients[offset + j]).collect();
        let mut parameters = Vec::new();
        for parameter in effect.parameters() {
            let name = number_name(effect, shape, parameter.name);
            if effect.name() == "torque_constant_saturation" && parameter.name == "current" {
                // Its depth goes with slope over current squared.
                let slope =
                    parameters.first().map_or((1.0, 0.0), |p: &Parameter| (p.fitted, p.standard_error.unwrap_or(0.0)));
                parameters.push(Parameter {
                    name: parameter.name.into(),
                    declared: None,
                    fitted: shape,
                    standard_error: Some(0.5 * shape * slope.1 / slope.0.abs().max(f64::MIN_POSITIVE)),
                    unit: parameter.kind.si,
                });
            } else if let Some(i) = names.iter().position(|n| *n == name) {
                parameters.push(Parameter {
                    name: name.trim_start_matches(effect.name()).trim_start_matches('.').to_string(),
                    declared: None,
                    fitted: values[i],
                    standard_error: Some(matrix[(i, i)].max(0.0).sqrt()),
                    unit: parameter.kind.si,
                });
            }
        }
        if effect.shape() != Shape::None {
            instance.push(shape);
        }
        let part: Vec<f64> = (0..work.balance.rows.len())
            .map(|k| (0..effect.linear()).map(|j| instance[j] * term.columns[j][k]).sum())
            .collect();
        let square = part.iter().map(|v| v * v).sum::<f64>() / part.len().max(1) as f64;
        match list.iter_mut().find(|f| f.name == effect.name()) {
            Some(same) => {
                same.parameters.extend(parameters);
                same.instances.push(instance);
                same.size = same.size.hypot(square.sqrt());
            }
            None => list.push(Found {
                name: effect.name(),
                equation: effect.equation(),
                parameters,
                instances: vec![instance],
                size: square.sqrt(),
                held_out_before: None,
                held_out_after: work.error(&fit, false).map(|e| e.0),
                confounded_with: selection.look_alikes(work, t),
                enters: effect.enters(),
            }),
        }
    }
    for entry in &mut list {
        // Without all orders of the effect.
        let columns: Vec<&[f64]> = work
            .terms
            .iter()
            .filter(|t| !(t.declared.is_none() && t.effect().is_some_and(|(e, _)| e.name() == entry.name)))
            .flat_map(|t| &t.columns)
            .map(Vec::as_slice)
            .collect();
        let without = work.fit_columns(&columns);
        entry.held_out_before = work.error(&without, false).map(|e| e.0);
    }
    list
}

/// Runs that would tell look-alikes apart, or show what this bench hides.
fn next_runs(effects: &[Found], selection: &Selection, left: &[Dependence], work: &Work) -> Vec<String> {
    let mut runs: Vec<String> = Vec::new();
    for effect in effects {
        for rival in &effect.confounded_with {
            runs.push(format!("`{}` or `{rival}`: {}", effect.name, separating_run(effect.name, rival)));
        }
    }
    if effects.iter().any(|e| matches!(e.name, "viscous_friction" | "coulomb_friction" | "stribeck_friction"))
        && work.bench.declared.ratio != 1.0
    {
        runs.push(
            "friction before or behind the gear: with one ratio they look alike, and N* depends on it; a run of the motor \
             without its gear would separate them"
                .into(),
        );
    }
    let drifts = left.iter().any(|d| d.on.contains("time"))
        || selection.refused.iter().any(|r| r.reason.contains("drift in time"));
    if drifts && selection.refused.iter().any(|r| r.reason.contains("no temperature")) {
        runs.push("log winding and housing temperature, so that warm-up and drift can be told apart".into());
    }
    runs.dedup();
    runs
}

fn separating_run(a: &str, b: &str) -> &'static str {
    let pair = |x: &str, y: &str| (a == x && b == y) || (a == y && b == x);
    let either = |x: &str| a == x || b == x;
    if pair("coulomb_friction", "load_dependent_friction") {
        "the load hardly changed; a run at another load would separate them"
    } else if either("torque_constant_temperature") || either("winding_temperature") {
        "a run from cold and one from hot at the same currents would separate them"
    } else if either("torque_constant_saturation") {
        "a run with current steps up to the largest current at constant temperature would separate them"
    } else if pair("viscous_friction", "eddy_drag") {
        "a run to higher speeds, beyond the knee, would separate them"
    } else if either("stribeck_friction") {
        "a slow run in both directions, from standstill to a tenth of the speed, would separate them"
    } else if either("cogging") || either("torque_ripple") || either("gear_ripple") {
        "slow turns of several revolutions at two different currents would separate them"
    } else if either("direction_asymmetry") || either("torque_offset") {
        "the same speeds in both directions, in several logs, would separate them"
    } else if either("inverter_dead_time") || either("supply_sag") {
        "slow current steps of both signs at standstill would separate them"
    } else {
        "a run in which speed, load and current vary independently would separate them"
    }
}

#[cfg(test)]
mod tests;
