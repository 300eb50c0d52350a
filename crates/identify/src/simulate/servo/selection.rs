//! Which effects a simulated position asks for.

use super::candidate::Candidate;
use super::judges::{Judges, WORTH, chance};
use crate::answer::{Hidden, INTERVAL, Refused, Stage, Step, Target};
use crate::select::{CHANCE, Judge, Pruner};
use crate::simulate::model::{Model, error};
use crate::simulate::track::Track;
use gearwise_model::effects::{EFFECTS, Effect, Equation, Variable, View};

/// A fall \[%\] of the left-out error that is plain to see, and what chance it may have: few stretches may hold most of the error.
const PLAIN: f64 = 10.0;
const CHANCE_OF_PLAIN: f64 = 0.05;
/// Errors this close are a tie.
const TIE: f64 = 0.01;

/// The simulated position judges: by logs or stretches that are left out of the fit in turn.
pub(super) struct OnPosition<'a> {
    pub judges: &'a Judges<'a>,
    pub everything: &'a [&'a Track],
    pub candidates: Vec<Candidate>,
    pub model: Model,
    /// Left-out squared errors of the model.
    pub now: Vec<f64>,
    /// What was added and may be taken out again.
    pub added: Vec<Candidate>,
    /// Whether the model had a lag before anything was asked.
    pub is_late: bool,
    pub stages: Vec<Stage>,
    pub refused: Vec<Refused>,
}

/// A candidate that was tried.
pub(super) struct Tried {
    candidate: Candidate,
    model: Model,
    error: f64,
}

/// A candidate that was added, as it would be without.
pub(super) struct Spared {
    candidate: Candidate,
    without: Model,
    left_out: Vec<f64>,
}

impl OnPosition<'_> {
    fn refuse(&mut self, name: &str, reason: String) {
        self.refused.retain(|r| r.name != name);
        self.refused.push(Refused::new(name, reason));
    }

    /// Finds out what was added beyond the declared model's own terms.
    pub fn gather_added(&mut self, known_terms: usize) {
        let is_added = |candidate: &Candidate| match candidate {
            Candidate::Lag => candidate.is_in(&self.model),
            Candidate::Effect(effect) => self.model.machine.terms.iter().skip(known_terms).any(|t| t.effect == *effect),
        };
        self.added = self.candidates.iter().copied().filter(is_added).collect();
    }
}

impl Judge for OnPosition<'_> {
    type Candidate = Tried;

    fn next(&mut self) -> Option<Tried> {
        let (judges, model, now) = (self.judges, &self.model.clone(), &self.now.clone());
        let candidates = self.candidates.clone();
        let before = judges.error(now);
        let base = {
            let mut same = model.clone();
            judges.fit(&mut same, 3, 1e-3)
        };
        let mut fits: Vec<(Candidate, Model, f64)> = Vec::new();
        let open: Vec<Candidate> = candidates.iter().copied().filter(|c| !c.is_in(model)).collect();
        for candidate in &open {
            let Some((with, error)) = judges.fit_added(*candidate, model, 8, 2e-3) else { continue };
            let fall = 100.0 * (1.0 - error / base);
            if let Err(reason) = candidate.plausible(&with) {
                self.refuse(candidate.name(), reason.to_string());
            } else if error > (1.0 - WORTH) * base {
                let fall = fall.max(0.0);
                self.refuse(
                    candidate.name(),
                    format!("nothing: the error falls by {fall:.1} % even where it is fitted"),
                );
            } else {
                fits.push((*candidate, with, error));
            }
        }
        // Only the best are worth leaving logs out for.
        fits.sort_by(|a, b| a.2.total_cmp(&b.2));
        for (candidate, _, error) in fits.iter().skip(3) {
            let fall = 100.0 * (1.0 - error / base);
            self.refuse(candidate.name(), format!("others explain more: the error would fall by {fall:.1} %"));
        }
        fits.truncate(3);
        let judged = fits.len() as f64;
        let mut tried: Vec<Tried> = Vec::new();
        for (candidate, with, _) in fits {
            let left_out = judges.left_out(&with);
            let error = judges.error(&left_out);
            if error > (1.0 - WORTH) * before {
                let fall = 100.0 * (1.0 - error / before);
                self.refuse(
                    candidate.name(),
                    format!("on what was left out the error falls by {fall:.1} %, less than 3 %"),
                );
                continue;
            }
            let probability = chance(now, &left_out) * judged;
            let fall = 100.0 * (1.0 - error / before);
            let beyond = judges.beyond_its_error(&with, candidate);
            if beyond < INTERVAL {
                self.refuse(
                    candidate.name(),
                    format!("its value is not beyond its own error ({beyond:.1} standard errors)"),
                );
            } else if probability > if fall < PLAIN { CHANCE } else { CHANCE_OF_PLAIN } {
                self.refuse(
                    candidate.name(),
                    format!("the left-out error falls by {fall:.1} %, but by chance one of those tried would as well in {:.0} % of cases",
                        (100.0 * probability.min(1.0)).ceil()),
                );
            } else {
                self.refuse(candidate.name(), "another explains it better".into());
                tried.push(Tried { candidate, model: with, error });
            }
        }
        let best = tried.iter().map(|t| t.error).fold(f64::INFINITY, f64::min);
        // A tie goes to the simplest: the order of the candidates.
        let rank = |t: &Tried| candidates.iter().position(|c| c.name() == t.candidate.name());
        tried.into_iter().filter(|t| t.error <= (1.0 + TIE) * best).min_by_key(rank)
    }

    fn add(&mut self, tried: Tried) {
        let name = tried.candidate.name();
        self.refused.retain(|r| r.name != name);
        self.model = tried.model;
        self.judges.fit(&mut self.model, 15, 1e-4);
        self.now = self.judges.left_out(&self.model);
        self.stages.push(stage(tried.candidate.step(), self.everything, &self.model));
    }
}

impl Pruner for OnPosition<'_> {
    type Term = Spared;

    fn superfluous(&mut self) -> Option<Spared> {
        // A lag from the beginning is no discovery: without it the inertia would answer for it.
        let is_asked = |c: &Candidate| !self.is_late || *c != Candidate::Lag;
        let asked: Vec<Candidate> = self.added.iter().copied().filter(is_asked).collect();
        if asked.len() < 2 {
            return None;
        }
        let judges = self.judges;
        let trials: Vec<Spared> = asked
            .into_iter()
            .map(|candidate| {
                let mut without = candidate.removed(&self.model);
                judges.fit(&mut without, 10, 1e-3);
                let left_out = judges.left_out(&without);
                Spared { candidate, without, left_out }
            })
            .collect();
        let error = |s: &Spared| judges.error(&s.left_out);
        let least = trials.into_iter().min_by(|a, b| error(a).total_cmp(&error(b)));
        least.filter(|s| judges.error(&self.now) > (1.0 - WORTH) * error(s))
    }

    fn remove(&mut self, spared: Spared) {
        let fall = 100.0 * (1.0 - self.judges.error(&self.now) / self.judges.error(&spared.left_out));
        self.refuse(
            spared.candidate.name(),
            format!("superfluous next to the others: it takes {fall:.1} % of the left-out error"),
        );
        (self.model, self.now) = (spared.without, spared.left_out);
        self.added.retain(|c| *c != spared.candidate);
    }
}

/// Where the story stands.
pub(super) fn stage(step: Step, tracks: &[&Track], model: &Model) -> Stage {
    let residuals = model.residuals(tracks);
    let (fit, held) = (error(tracks, &residuals, true), error(tracks, &residuals, false));
    Stage::new(step, fit, held)
}

/// What can be tried on these logs; the rest is refused with its reason.
pub(super) fn candidates(all: &[Track], without: &[&'static dyn Effect], refused: &mut Vec<Refused>) -> Vec<Candidate> {
    let measures_supply = all.iter().any(|t| t.supply.windows(2).any(|w| w[0] != w[1]));
    let view = View {
        equation: Target::Position.equation(),
        has_free_zero: false,
        sees_load: true,
        has_gear: true,
        measures_supply,
        fits_damping: true,
    };
    let mut list: Vec<(u32, Candidate)> = Vec::new();
    for effect in EFFECTS {
        let of_voltage = effect.acts_on() == Equation::Voltage;
        let why = match (effect.hidden(&view), effect.rank_in_position()) {
            _ if without.contains(effect) => Hidden::LeftOut,
            _ if of_voltage && !Track::are_of_voltage(all) => {
                Hidden::Bench("the drive is asked for torque: what a voltage does is not identifiable")
            }
            (Some(why), _) => Hidden::Bench(why),
            (None, Some(rank)) => {
                list.push((rank, Candidate::Effect(*effect)));
                continue;
            }
            _ if effect.winds_up() => Hidden::Lacks(Variable::TorqueCurvature),
            _ if effect.needs_temperature() => {
                Hidden::Bench("a simulated position is not asked for temperatures: a log with current would show it")
            }
            _ => Hidden::Bench("a simulated position is not asked for it: a log with current or torque would show it"),
        };
        refused.push(Refused::hidden(effect.name(), why));
    }
    list.sort_by_key(|(rank, _)| *rank);
    let mut list: Vec<Candidate> = list.into_iter().map(|(_, candidate)| candidate).collect();
    list.push(Candidate::Lag);
    list
}

/// Effects that do about as well in the place of one that was found, and the one that it looks like where that cannot be
/// asked.
pub(super) fn look_alikes(
    found: Candidate,
    model: &Model,
    now: &[f64],
    candidates: &[Candidate],
    judges: &Judges,
) -> Vec<&'static dyn Effect> {
    let without = found.removed(model);
    let error = judges.error(now);
    let Candidate::Effect(own) = found else { return Vec::new() };
    let cannot_be_asked = |e: &&'static dyn Effect| !candidates.contains(&Candidate::Effect(*e));
    let mut list: Vec<&'static dyn Effect> = own.mimics().map(|m| m.of).filter(cannot_be_asked).into_iter().collect();
    for rival in candidates {
        let Candidate::Effect(effect) = rival else { continue };
        if rival.is_in(model) {
            continue;
        }
        let Some((with, fitted)) = judges.fit_added(*rival, &without, 10, 1e-3) else { continue };
        if rival.plausible(&with).is_err() || fitted > 1.1 * error {
            continue;
        }
        let left_out = judges.left_out(&with);
        let close = judges.error(&left_out) < (1.0 + WORTH) * error;
        if close || chance(&left_out, now) > 0.1 {
            list.push(*effect);
        }
    }
    list
}
