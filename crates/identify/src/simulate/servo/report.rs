//! The report of servo logs.

use super::candidate::Candidate;
use super::judges::{ENOUGH_LOGS, Judges, covariance};
use super::left::{left, noise, speed};
use super::selection::{OnPosition, look_alikes};
use crate::answer::evidence::{self, Evidence};
use crate::answer::{Found, Parameter, Report, Target};
use crate::simulate::model::{Model, Slot, error};
use crate::simulate::track::{Input, Track};
use crate::{Bench, Use};
use gearwise_model::effects::separating_run;

/// What was held out may be so many times as far off as with the declared model.
const WORSE: f64 = 1.1;
/// Most rows of the pictures.
const ROWS: usize = 24_000;

/// The report of a selection that is done.
pub(super) fn report(
    bench: &Bench,
    all: &[Track],
    declared: &Model,
    held: Vec<String>,
    selection: OnPosition,
) -> Report {
    let OnPosition { judges, candidates, model, now, added, stages, refused, .. } = selection;
    let model = &model;
    let matrix = covariance(model, judges);
    let names: Vec<String> = model.slots.iter().map(|s| model.name(*s)).collect();
    let deviation = |wanted: &str| names.iter().position(|n| n == wanted).map(|k| matrix[(k, k)].max(0.0).sqrt());
    let mut parameters = Vec::new();
    let known = |slot: Slot| match slot {
        Slot::Inertia => {
            bench.declared.motor.as_ref().and_then(|m| m.rotor_inertia).map(|j| j + bench.declared.gear.inertia)
        }
        _ => Some(declared.get(slot)),
    };
    let mut own = vec![(Slot::TorqueConstant, "N*m/A"), (Slot::Damping, "N*m*s/rad"), (Slot::Inertia, "kg*m^2")];
    for (t, term) in declared.machine.terms.iter().enumerate() {
        own.extend((0..term.effect.linear()).map(|j| (Slot::Value(t, j), term.effect.parameters()[j].kind.si)));
    }
    for (slot, unit) in own {
        let called = model.name(slot);
        let standard_error = deviation(&called);
        if standard_error.is_some() || held.contains(&called) {
            parameters.push(Parameter {
                name: called,
                declared: known(slot),
                fitted: model.get(slot),
                standard_error,
                undecided: None,
                unit,
            });
        }
    }
    let everything: Vec<&Track> = all.iter().collect();
    let after = model.residuals(&everything);
    let held_after = error(&everything, &after, false).map(|e| e.0);
    let effects: Vec<Found> = added
        .iter()
        .filter_map(|c| {
            let Candidate::Effect(effect) = *c else { return None };
            let values = model.machine.terms.iter().find(|t| t.effect == effect)?.values.clone();
            let mut without = c.removed(model);
            let plain = without.residuals(&everything);
            judges.fit(&mut without, 15, 1e-4);
            let before = without.residuals(&everything);
            let change: Vec<f64> =
                plain.iter().flatten().zip(after.iter().flatten()).map(|(a, b)| (a - b).powi(2)).collect();
            Some(Found {
                effect,
                parameters: effect
                    .parameters()
                    .iter()
                    .zip(&values)
                    .map(|(p, v)| Parameter {
                        name: p.name.into(),
                        declared: None,
                        fitted: *v,
                        standard_error: deviation(&format!("{}.{}", effect.name(), p.name)),
                        undecided: None,
                        unit: p.kind.si,
                    })
                    .collect(),
                instances: vec![values],
                size: (change.iter().sum::<f64>() / change.len().max(1) as f64).sqrt(),
                held_out_before: error(&everything, &before, false).map(|e| e.0),
                held_out_after: held_after,
                confounded_with: look_alikes(*c, model, &now, &candidates, judges),
            })
        })
        .collect();
    let mut artefacts = Vec::new();
    // One that is not seen beside its error stays in the fit for the errors' sake, and is not told.
    let is_seen = deviation("lag").is_some_and(|e| model.machine.lag > 3.0 * e);
    if added.contains(&Candidate::Lag) && is_seen {
        let channel = if Track::are_of_voltage(all) { "duty" } else { "torque" };
        artefacts.push(Report::lag(channel, model.machine.lag));
    }
    let floor = noise(all);
    let unexplained = left(judges, &model.residuals(&judges.fit), floor);
    let declared_held = stages.first().and_then(|s| s.held_out);
    let worse_held_out = held_after.zip(declared_held).is_some_and(|(after, before)| after > WORSE * before);
    let unbounded = Evidence::unbounded(effects.len(), unexplained.len(), judges.error(&now));
    let evidence = Evidence { worse_held_out, ..unbounded };
    let next_runs = effects
        .iter()
        .flat_map(|e| e.confounded_with.iter().map(move |rival| (e.effect, *rival)))
        .map(|(own, rival)| format!("`{}` or `{}`: {}", own.name(), rival.name(), separating_run(own, rival)))
        .collect();
    let samples = all.iter().map(Track::len).sum();
    let mut report = Report {
        target: Target::Position,
        unit: "rad",
        band: None,
        samples: (samples, judges.samples),
        verdict: evidence::verdict(&evidence),
        evidence,
        stages,
        findings: Vec::new(),
        artefacts,
        parameters,
        effects,
        refused,
        unexplained,
        next_runs,
        remarks: remarks(all, judges, bench),
        fitted_names: names,
        covariance: matrix.row_iter().map(|r| r.iter().copied().collect()).collect(),
        pictures: Default::default(),
    };
    fill_pictures(&mut report, bench, all, declared, &after);
    report
}

fn remarks(all: &[Track], judges: &Judges, bench: &Bench) -> Vec<String> {
    let closed = all.iter().any(|t| matches!(t.input, Input::Goal { .. }));
    let how = if closed { "the goal through the declared controller" } else { "the logged duty cycle" };
    let means = match Track::are_of_voltage(all) {
        true => "K_T means K_T/R: only that is identifiable",
        false => "the drive makes the torque of its law by the declared torque constant",
    };
    let mut remarks = vec![format!("errors are of the simulated position, from {how}; {means}")];
    let off = all.iter().filter(|t| !t.off.is_empty()).count();
    if off > 0 {
        remarks.push(format!(
            "in {off} logs the duty cycle is zero although the controller asks for more: taken for a drive that is off, with \
             open terminals"
        ));
    }
    if judges.fit.len() < ENOUGH_LOGS {
        remarks.push("logs are few: stretches of 1.5 s are left out in turn, not logs".into());
    }
    if !bench.logs.iter().any(|l| l.usage == Use::HeldOut) {
        remarks.push("no log is held out: the errors are of logs that were fitted".into());
    }
    remarks
}

fn fill_pictures(report: &mut Report, bench: &Bench, all: &[Track], declared: &Model, after: &[Vec<f64>]) {
    let everything: Vec<&Track> = all.iter().collect();
    let before = declared.residuals(&everything);
    let total: usize = all.iter().map(Track::len).sum();
    let every = total.div_ceil(ROWS).max(1);
    let n = bench.declared.ratio;
    let pictures = &mut report.pictures;
    pictures.names = all.iter().map(|t| t.name.clone()).collect();
    for (index, track) in all.iter().enumerate() {
        let speed = speed(track);
        for k in (0..track.len()).step_by(every) {
            pictures.time.push(track.time[k] - track.time[0]);
            pictures.log.push(index);
            pictures.before.push(before[index][k]);
            pictures.after.push(after[index][k]);
            pictures.speed.push(n * speed[k]);
            pictures.angle.push(n * track.position[k]);
            pictures.current.push(f64::NAN);
            pictures.temperature.push(track.winding.get(k).copied().unwrap_or(f64::NAN));
        }
    }
}
