//! The forward check: position as simulated against position as measured, before and after.

use super::machine::{Machine, Term};
use super::model::{Counted, Model, Slot, declared_machine, error, scale};
use super::track::{Input, Track};
use crate::answer::{ArtefactKind, Report, Target};
use crate::select::{self, Pruner};
use crate::{Bench, BenchKind};
use gearwise_model::effects::{Equation, Named};

/// Root mean square error of the simulated position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// On the logs for fitting.
    pub fit: f64,
    /// On the logs that were held out.
    pub held_out: Option<f64>,
}

/// How well a model that is simulated forward follows the logs.
#[derive(Debug, Clone)]
pub struct ForwardCheck {
    /// Unit of the errors.
    pub unit: &'static str,
    /// With the declared model.
    pub before: Errors,
    /// With the fitted parameters and the effects that were found.
    pub after: Errors,
    /// With parameters fitted to the simulated position itself. A better model of force need not simulate
    /// better, so both are told.
    pub refitted: Option<Errors>,
    /// Parameters of that fit: name and value, SI.
    pub refitted_parameters: Vec<(String, f64)>,
    /// Effects that were found but do not help to simulate: left out of that fit, by left-out parts of the
    /// logs for fitting.
    pub without: Vec<&'static str>,
    /// Effects that were found and cannot be simulated here.
    pub not_simulated: Vec<&'static str>,
    /// Whether the controller's loop was closed in simulation.
    pub closed_loop: bool,
}

/// Parts that each log for fitting is cut into to choose what the model for simulation has.
const PARTS: usize = 5;
/// Share of the left-out error that an effect must take away to be kept.
const KEPT: f64 = 0.01;

/// The machine of a report: its parameters and effects on the declared ones.
pub(super) fn fitted_machine(bench: &Bench, report: &Report, is_voltage: bool) -> (Machine, Vec<&'static str>) {
    let mut machine = declared_machine(&bench.declared, is_voltage);
    for p in &report.parameters {
        match p.name.as_str() {
            "inertia" | "mass" => machine.inertia = p.fitted,
            "damping" => machine.damping = p.fitted,
            "torque_constant" => machine.torque_constant = p.fitted,
            name => {
                let Some(of) = Named::read(name) else { continue };
                for term in machine.terms.iter_mut().filter(|t| of.is_of(t.effect, &t.values)) {
                    term.values[of.index()] = p.fitted;
                }
            }
        }
    }
    // The back-EMF within it goes with the torque constant.
    if !report.parameters.iter().any(|p| p.name == "damping") {
        let declared = bench.declared.motor.as_ref().map_or(machine.torque_constant, |motor| motor.torque_constant);
        machine.damping *= machine.torque_constant / declared;
    }
    let mut not_simulated = Vec::new();
    for found in &report.effects {
        let effect = found.effect;
        if !effect.winds_up() && (effect.acts_on() == Equation::Torque || is_voltage) {
            machine.terms.extend(found.instances.iter().map(|v| Term::new(effect, v.clone())));
        } else {
            not_simulated.push(found.name());
        }
    }
    let of_simulation = report.target == Target::Position;
    for a in report.artefacts.iter().filter(|a| of_simulation && a.kind == ArtefactKind::Lag) {
        machine.lag = a.value;
    }
    (machine, not_simulated)
}

fn errors(tracks: &[&Track], model: &Model) -> Errors {
    let residuals = model.residuals(tracks);
    Errors {
        fit: error(tracks, &residuals, true).map_or(f64::NAN, |e| e.0),
        held_out: error(tracks, &residuals, false).map(|e| e.0),
    }
}

/// Simulates the logs of a bench forward from what was put in, with the declared model, with that of a
/// report, and with one fitted to the position itself. `None` where no log has both a known load (or a mass)
/// and what drives it, or where the report is of another equation than that of the drive.
pub fn forward_check(bench: &Bench, report: &Report) -> Option<ForwardCheck> {
    if !matches!(report.target, Target::Drive | Target::Position) || report.evidence.contradicted {
        return None;
    }
    let all: Vec<Track> = bench
        .logs
        .iter()
        .filter(|log| matches!(log.kind, BenchKind::Free | BenchKind::Linear | BenchKind::Servo))
        .filter_map(|log| Track::new(log, &bench.declared))
        .collect();
    let tracks: Vec<&Track> = all.iter().collect();
    if !tracks.iter().any(|t| t.fits) {
        return None;
    }
    let is_voltage = Track::are_of_voltage(&all);
    let declared = declared_machine(&bench.declared, is_voltage);
    let moved = |m: &Machine| all.iter().all(|t| m.inertia + t.load_inertia > 0.0);
    let (machine, not_simulated) = fitted_machine(bench, report, is_voltage);
    if !moved(&declared) || !moved(&machine) {
        return None;
    }
    let scale = scale(&all, &declared);
    let before = errors(&tracks, &Model { machine: declared, slots: Vec::new(), scale });
    let mut model = Model { machine, slots: Vec::new(), scale };
    let after = errors(&tracks, &model);
    model.slots = slots(&model.machine, report);
    let without = prune(&mut model, &all, bench);
    let fit: Vec<&Track> = all.iter().filter(|t| t.fits).collect();
    model.fit(&fit, &Counted::new(), 40, 1e-6);
    let refitted_parameters = model.slots.iter().map(|s| (model.name(*s), model.get(*s))).collect();
    Some(ForwardCheck {
        unit: if bench.declared.motor.is_some() { "rad" } else { "m" },
        before,
        after,
        refitted: Some(errors(&tracks, &model)),
        refitted_parameters,
        without,
        not_simulated,
        closed_loop: all.iter().any(|t| matches!(t.input, Input::Goal { .. })),
    })
}

/// What the report fitted is fitted again.
fn slots(machine: &Machine, report: &Report) -> Vec<Slot> {
    let seen = |name: &str| report.parameters.iter().any(|p| p.name == name && p.standard_error.is_some());
    let mut slots = Vec::new();
    if seen("inertia") || seen("mass") {
        slots.push(Slot::Inertia);
    }
    if seen("damping") {
        slots.push(Slot::Damping);
    }
    if seen("torque_constant") {
        slots.push(Slot::TorqueConstant);
    }
    if machine.lag > 0.0 {
        slots.push(Slot::Lag);
    }
    for (t, term) in machine.terms.iter().enumerate() {
        slots.extend((0..term.effect.linear()).map(|j| Slot::Value(t, j)));
    }
    slots
}

/// Leaves out effects that do not help on parts that were left out. The parts start from their measured
/// state.
fn prune(model: &mut Model, all: &[Track], bench: &Bench) -> Vec<&'static str> {
    let parts: Vec<Track> = all.iter().filter(|t| t.fits).flat_map(|t| t.parts(PARTS)).collect();
    let declared = declared_machine(&bench.declared, false).terms.len();
    let now = left_out(model, &parts);
    let mut on_parts = OnParts { model, parts, declared, now, without: Vec::new() };
    select::backward(&mut on_parts);
    on_parts.without
}

/// Parts of the logs judge.
struct OnParts<'a> {
    model: &'a mut Model,
    parts: Vec<Track>,
    /// Terms that the declared model has.
    declared: usize,
    now: f64,
    without: Vec<&'static str>,
}

impl Pruner for OnParts<'_> {
    /// A term, and the error without it.
    type Term = (usize, f64);

    fn superfluous(&mut self) -> Option<(usize, f64)> {
        let trials = (self.declared..self.model.machine.terms.len()).map(|t| {
            let mut trial = self.model.clone();
            trial.remove(t);
            (t, left_out(&trial, &self.parts))
        });
        trials.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, error)| *error * (1.0 - KEPT) < self.now)
    }

    fn remove(&mut self, (term, error): (usize, f64)) {
        self.without.push(self.model.machine.terms[term].effect.name());
        self.model.remove(term);
        self.now = error;
    }
}

/// Root mean square error of the parts, each simulated with what the others say.
fn left_out(model: &Model, parts: &[Track]) -> f64 {
    let folds = parts.len().min(PARTS);
    let (mut squares, mut count) = (0.0, 0);
    let mut whole = model.clone();
    let everything: Vec<&Track> = parts.iter().collect();
    whole.fit(&everything, &Counted::new(), 12, 1e-3);
    for fold in 0..folds {
        let mut trial = whole.clone();
        let others: Vec<&Track> = parts.iter().enumerate().filter(|(k, _)| k % folds != fold).map(|(_, t)| t).collect();
        trial.fit(&others, &Counted::new(), 8, 1e-3);
        for part in parts.iter().skip(fold).step_by(folds) {
            squares += part.residual(&trial.machine).iter().map(|r| r * r).sum::<f64>();
            count += part.count();
        }
    }
    (squares / count.max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Parameter;
    use crate::identify::steady::moving;
    use crate::identify::{Options, identify};
    use gearwise_model::effects::{FittedEffect, effect};

    /// Fitted numbers of declared effects reach the machine: of an effect with orders, those of the order that was meant.
    #[test]
    fn fitted_numbers_of_an_order_are_simulated() {
        let mut bench = moving(2000, false);
        let order = |order: f64| FittedEffect { effect: effect("cogging").unwrap(), values: vec![0.1, 0.2, order] };
        bench.declared.effects.extend([order(6.0), order(12.0)]);
        let mut report = identify(&bench, &Options::default()).unwrap().remove(0);
        report.parameters = vec![Parameter {
            name: "cogging.12.sine".into(),
            declared: Some(0.2),
            fitted: 0.7,
            standard_error: Some(0.01),
            undecided: None,
            unit: "N*m",
        }];
        report.effects.clear();
        let (machine, _) = fitted_machine(&bench, &report, false);
        let cogging = |order: f64| {
            let mut of = machine.terms.iter().filter(|t| t.effect.name() == "cogging");
            of.find(|t| t.values[2] == order).unwrap().values.clone()
        };
        assert_eq!((cogging(6.0), cogging(12.0)), (vec![0.1, 0.2, 6.0], vec![0.1, 0.7, 12.0]));
    }
}
