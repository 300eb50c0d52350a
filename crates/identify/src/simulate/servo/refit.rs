//! The declared model's own parameters, fitted to the simulated position.

use super::candidate::{Candidate, FIRST_LAG, is_a_lag};
use super::judges::{Judges, WORTH, chance, covariance};
use crate::Bench;
use crate::select::CHANCE;
use crate::simulate::model::{Model, Slot};
use crate::simulate::track::Track;

/// Relative standard error beyond which a declared parameter is not seen.
const UNSEEN: f64 = 0.3;

/// The declared model's own parameters refitted; those that the logs don't show stay as declared. An input that comes
/// late and an inertia answer for the same phase, so they are fitted together, before any effect can take the place of
/// either. Like an effect, a lag has to earn its place on what was left out.
pub(super) fn refit(declared: &Model, judges: &Judges, all: &[Track], bench: &Bench) -> (Model, Vec<String>) {
    let plain = refit_from(declared.clone(), declared, judges, all, bench);
    let mut late = declared.clone();
    late.machine.lag = FIRST_LAG;
    late.slots = vec![Slot::Lag];
    let late = refit_from(late, declared, judges, all, bench);
    if !late.0.slots.contains(&Slot::Lag) {
        return plain;
    }
    let (before, after) = (judges.left_out(&plain.0), judges.left_out(&late.0));
    let worth = judges.error(&after) <= (1.0 - WORTH) * judges.error(&before);
    if worth && chance(&before, &after) <= CHANCE { late } else { plain }
}

fn refit_from(start: Model, declared: &Model, judges: &Judges, all: &[Track], bench: &Bench) -> (Model, Vec<String>) {
    let mut model = start;
    // Without a known load only ratios to the drive's gain are seen.
    if all.iter().any(|t| t.fits && t.load_gravity + t.load_inertia > 0.0) {
        model.slots.push(Slot::TorqueConstant);
    }
    model.slots.push(Slot::Inertia);
    // Beside a current there is no back-EMF that damps.
    if Track::are_of_voltage(all) {
        model.slots.push(Slot::Damping);
    }
    for (t, term) in model.machine.terms.iter().enumerate() {
        model.slots.extend((0..term.effect.linear()).map(|j| Slot::Value(t, j)));
    }
    if bench.declared.motor.as_ref().is_none_or(|m| m.rotor_inertia.is_none()) {
        let n = model.machine.ratio;
        let load = all.iter().map(|t| t.load_inertia).fold(0.0, f64::max);
        model.machine.inertia = model.machine.inertia.max(0.1 * load / (n * n));
    }
    let mut held = Vec::new();
    loop {
        judges.fit(&mut model, 25, 1e-5);
        if model.slots.contains(&Slot::Lag) && !is_a_lag(model.machine.lag) {
            model = Candidate::Lag.removed(&model);
            continue;
        }
        let matrix = covariance(&model, judges);
        let worst = (0..model.slots.len())
            .filter_map(|k| {
                let slot = model.slots[k];
                let reference = declared.get(slot).abs().max(0.5 * model.get(slot).abs());
                let doubt = matrix[(k, k)].max(0.0).sqrt() / reference.max(f64::MIN_POSITIVE);
                let declared_anyway = declared.get(slot) != 0.0 || slot == Slot::Inertia;
                (doubt.is_nan() || doubt > UNSEEN && declared_anyway).then_some((k, doubt))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((k, _)) = worst else { return (model, held) };
        let slot = model.slots.remove(k);
        held.push(model.name(slot));
        let mut back = model.clone();
        back.slots = vec![slot];
        model.machine = back.with(&[declared.get(slot)]);
    }
}
