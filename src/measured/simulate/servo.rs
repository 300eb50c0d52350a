//! Servo logs with only duty cycle (or goal) and position: identified by the error of the simulated
//! position.
//!
//! The same story as the regression's, told in position: the declared model, its own parameters refitted,
//! then effects one at a time, each judged on logs (or, with few logs, stretches of time) that were left
//! out, against chance over all that were tried, and against what is plausible.

use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::check::name;
use super::model::{Counted, LONGEST_LAG, Model, Slot, declared_machine, error, scale};
use super::track::{Input, Track};
use crate::effects::{EFFECTS, Effect, Equation, Shape, effect};
use crate::measured::identify::{
    CHANCE, Evidence, Found, Parameter, Refused, Report, Stage, Target, Unexplained, evidence,
};
use crate::measured::{Bench, BenchKind, Channel, Use, signals};

/// Effects that a position can show, the simplest first.
const CANDIDATES: &[&str] = &[
    "coulomb_friction",
    "load_dependent_friction",
    "stribeck_friction",
    "direction_asymmetry",
    "gravity",
    "torque_offset",
    "eddy_drag",
    "supply_sag",
    "inverter_dead_time",
];
/// Least share of the left-out error that an effect must take away.
const WORTH: f64 = 0.03;
/// Errors this close are a tie.
const TIE: f64 = 0.01;
/// Length of the stretches of time that judge, several times what the error of a closed loop remembers \[s\].
const BLOCK: f64 = 1.5;
/// So many logs are left out as wholes.
const ENOUGH_LOGS: usize = 4;
/// So many logs judge as wholes: stretches of one log are not independent.
const MANY_LOGS: usize = 8;
/// Most folds.
const FOLDS: usize = 6;
/// Draws of the test by random signs.
const DRAWS: usize = 20_000;
/// Most effects that are added.
const STEPS: usize = 6;
/// Relative standard error beyond which a declared parameter is not seen.
const UNSEEN: f64 = 0.3;
/// Least lag that is one \[s\], and where the search for one starts.
const LEAST_LAG: f64 = 2e-4;
const FIRST_LAG: f64 = 0.003;
/// Share of the longest lag that is looked for beyond which it is none: it lies at the end of its range.
const MOST_OF_LAG: f64 = 0.95;
/// Most rows of the pictures.
const ROWS: usize = 24_000;
/// Error over the noise of the sensor beyond which something is left.
const LEFT: f64 = 3.0;

/// Whether a bench has servo logs that simulation can identify: no current, but a duty cycle, or a goal
/// through a declared controller, and the supply.
pub fn serves(bench: &Bench) -> bool {
    tracks(bench).iter().any(|t| t.fits)
}

fn tracks(bench: &Bench) -> Vec<Track> {
    if bench.declared.motor.is_none() {
        return Vec::new();
    }
    bench
        .logs
        .iter()
        .filter(|log| log.kind == BenchKind::Servo && log.channel(Channel::Current).is_none())
        .filter_map(|log| Track::new(log, &bench.declared))
        .collect()
}

/// Something that may be added to the model.
#[derive(Clone, Copy)]
enum Candidate {
    Effect(&'static dyn Effect),
    Lag,
}

impl Candidate {
    fn name(self) -> &'static str {
        match self {
            Candidate::Effect(effect) => effect.name(),
            Candidate::Lag => "lag",
        }
    }

    fn is_in(self, model: &Model) -> bool {
        match self {
            Candidate::Effect(effect) => model.machine.terms.iter().any(|t| t.effect.name() == effect.name()),
            Candidate::Lag => model.slots.contains(&Slot::Lag),
        }
    }

    /// The model with it, at each place to start from.
    fn added(self, model: &Model) -> Vec<Model> {
        let mut with = model.clone();
        match self {
            Candidate::Lag => {
                with.machine.lag = FIRST_LAG;
                with.slots.push(Slot::Lag);
                vec![with]
            }
            Candidate::Effect(effect) => {
                let scale = &model.scale;
                let shapes: Vec<f64> = match effect.shape() {
                    Shape::Speed if effect.name() == "eddy_drag" => vec![0.3 * scale.speed, 0.8 * scale.speed],
                    Shape::Speed => vec![0.03 * scale.speed, 0.1 * scale.speed],
                    Shape::Current => vec![0.05 * scale.current],
                    Shape::None | Shape::Order => vec![f64::NAN],
                };
                let mut starts = Vec::new();
                for shape in shapes {
                    for share in [0.2, 1.0] {
                        let mut start = model.clone();
                        let mut values = vec![0.0; effect.linear()];
                        if shape.is_finite() {
                            values.push(shape);
                        }
                        start.add(effect, values);
                        let term = start.machine.terms.len() - 1;
                        let first = start.slots.iter().position(|s| *s == Slot::Value(term, 0)).unwrap_or(0);
                        let unknown = &start.unknowns(&[])[first];
                        // A tenth of the largest torque and a fiftieth, where its sign is known.
                        let value = if unknown.lower == 0.0 { share * unknown.scale } else { 0.0 };
                        start.machine.terms[term].values[0] = value;
                        starts.push(start);
                    }
                }
                starts
            }
        }
    }

    fn removed(self, model: &Model) -> Model {
        let mut without = model.clone();
        match self {
            Candidate::Lag => {
                without.machine.lag = 0.0;
                without.slots.retain(|s| *s != Slot::Lag);
            }
            Candidate::Effect(effect) => {
                if let Some(t) = without.machine.terms.iter().position(|t| t.effect.name() == effect.name()) {
                    without.remove(t);
                }
            }
        }
        without
    }

    fn plausible(self, model: &Model) -> Result<(), String> {
        match self {
            Candidate::Lag if model.machine.lag <= LEAST_LAG => Err("it would be zero".into()),
            Candidate::Lag if !is_a_lag(model.machine.lag) => Err("it would be at the end of its range".into()),
            Candidate::Lag => Ok(()),
            Candidate::Effect(effect) => {
                let values = model.machine.terms.iter().find(|t| t.effect.name() == effect.name());
                effect.plausible(values.map_or(&[], |t| &t.values), &model.scale)
            }
        }
    }
}

/// Whether a lag \[s\] is one: above zero, and not at the end of its range.
fn is_a_lag(lag: f64) -> bool {
    (LEAST_LAG..MOST_OF_LAG * LONGEST_LAG).contains(&lag)
}

/// The logs and how they judge.
struct Judges<'a> {
    fit: Vec<&'a Track>,
    /// Unit of each sample of each track.
    unit: Vec<Vec<usize>>,
    /// Fold of each unit.
    fold: Vec<usize>,
    folds: usize,
    samples: usize,
}

impl<'a> Judges<'a> {
    fn new(all: &'a [Track]) -> Judges<'a> {
        let fit: Vec<&Track> = all.iter().filter(|t| t.fits).collect();
        let whole = fit.len() >= ENOUGH_LOGS;
        let (mut unit, mut fold, mut count) = (Vec::new(), Vec::new(), 0);
        for (index, track) in fit.iter().enumerate() {
            let length = track.time[track.len() - 1] - track.time[0];
            let blocks = if fit.len() >= MANY_LOGS { 1 } else { ((length / BLOCK).round() as usize).max(1) };
            let at = |t: f64| (((t - track.time[0]) / length * blocks as f64) as usize).min(blocks - 1);
            unit.push(track.time.iter().map(|t| count + at(*t)).collect());
            // With few logs neighbouring stretches are in different folds.
            fold.extend((0..blocks).map(|b| if whole { index } else { b }));
            count += blocks;
        }
        let folds = fold.iter().max().map_or(1, |m| m + 1).min(FOLDS);
        fold.iter_mut().for_each(|f| *f %= folds);
        let samples = fit.iter().map(|t| t.count()).sum::<usize>().max(1);
        Judges { fit, unit, fold, folds, samples }
    }

    fn counted(&self, fold: usize) -> Counted {
        self.unit.iter().map(|units| units.iter().map(|u| self.fold[*u] != fold).collect()).collect()
    }

    /// Squared error of each unit, simulated with what the other folds say.
    fn left_out(&self, model: &Model) -> Vec<f64> {
        let mut squares = vec![0.0; self.fold.len()];
        for fold in 0..self.folds {
            let mut trial = model.clone();
            let counted = self.counted(fold);
            let seen: Vec<usize> = (0..self.fit.len()).filter(|t| counted[*t].iter().any(|c| *c)).collect();
            let part: Vec<&Track> = seen.iter().map(|t| self.fit[*t]).collect();
            trial.fit(&part, &seen.iter().map(|t| counted[*t].clone()).collect(), 5, 2e-3);
            let judged: Vec<usize> = (0..self.fit.len()).filter(|t| counted[*t].iter().any(|c| !c)).collect();
            let residuals = trial.residuals(&judged.iter().map(|t| self.fit[*t]).collect::<Vec<_>>());
            for (t, residual) in judged.iter().zip(&residuals) {
                for ((r, c), u) in residual.iter().zip(&counted[*t]).zip(&self.unit[*t]) {
                    if !c {
                        squares[*u] += r * r;
                    }
                }
            }
        }
        squares
    }

    fn error(&self, squares: &[f64]) -> f64 {
        (squares.iter().sum::<f64>() / self.samples as f64).sqrt()
    }

    fn fit(&self, model: &mut Model, rounds: usize, enough: f64) -> f64 {
        let cost = model.fit(&self.fit, &Counted::new(), rounds, enough);
        (cost / self.samples as f64).sqrt()
    }

    /// The best fit over the places to start from.
    fn fit_added(&self, candidate: Candidate, model: &Model, rounds: usize, enough: f64) -> Option<(Model, f64)> {
        let starts = candidate.added(model);
        let squares = |m: &Model| m.residuals(&self.fit).iter().flatten().map(|r| r * r).sum::<f64>();
        let costs: Vec<f64> = starts.iter().map(squares).collect();
        let best = (0..starts.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
        let mut with = starts[best].clone();
        let error = self.fit(&mut with, rounds, enough);
        Some((with, error))
    }
}

/// Probability that gains as large as these come about where there is none: signs at random, stretch by
/// stretch.
fn chance(before: &[f64], after: &[f64]) -> f64 {
    let gains: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    let sum: f64 = gains.iter().sum();
    if gains.len() < 2 || sum <= 0.0 {
        return 1.0;
    }
    let mut random = Pcg64::seed_from_u64(1);
    let as_large = (0..DRAWS)
        .filter(|_| {
            let mut word = 0;
            let drawn: f64 = gains
                .iter()
                .enumerate()
                .map(|(k, g)| {
                    if k % 64 == 0 {
                        word = random.next_u64();
                    }
                    let sign = (word >> (k % 64)) & 1;
                    if sign == 1 { *g } else { -g }
                })
                .sum();
            drawn >= sum * (1.0 - 1e-12)
        })
        .count();
    (as_large + 1) as f64 / (DRAWS + 1) as f64
}

/// A candidate that was tried.
struct Tried {
    candidate: Candidate,
    model: Model,
    error: f64,
}

/// What selection says.
struct Story {
    stages: Vec<Stage>,
    refused: Vec<Refused>,
}

impl Story {
    fn refuse(&mut self, name: &str, reason: String) {
        self.refused.retain(|r| r.name != name);
        self.refused.push(Refused::new(name, reason));
    }
}

/// Identifies the servo logs of a bench by the error of the simulated position. `None` where there are none
/// that simulation can tell anything of ([`serves`]). The report's errors are of position \[rad\].
pub fn identify_servo(bench: &Bench) -> Option<Report> {
    let all = tracks(bench);
    if !all.iter().any(|t| t.fits && t.count() >= 16) {
        return None;
    }
    let judges = Judges::new(&all);
    let everything: Vec<&Track> = all.iter().collect();
    let machine = declared_machine(&bench.declared, true);
    let scale = scale(&all, &machine);
    let declared = Model { machine, slots: Vec::new(), scale };
    let mut story = Story { stages: vec![stage("declared", &everything, &declared)], refused: Vec::new() };
    let known_terms = declared.machine.terms.len();
    let (mut model, held) = refit(&declared, &judges, &all, bench);
    story.stages.push(stage("refit", &everything, &model));
    let late = model.slots.contains(&Slot::Lag);
    let candidates = candidates(&all, &mut story);
    let mut now = judges.left_out(&model);
    for _ in 0..STEPS {
        let Some(tried) = next(&candidates, &model, &now, &judges, &mut story) else { break };
        let name = tried.candidate.name();
        story.refused.retain(|r| r.name != name);
        model = tried.model;
        judges.fit(&mut model, 15, 1e-4);
        now = judges.left_out(&model);
        story.stages.push(stage(name, &everything, &model));
    }
    // What later ones made superfluous.
    let mut added: Vec<Candidate> = candidates.iter().copied().filter(|c| is_added(*c, &model, known_terms)).collect();
    loop {
        // A lag from the beginning is no discovery: without it the inertia would answer for it.
        let asked: Vec<Candidate> = added.iter().copied().filter(|c| !late || !matches!(c, Candidate::Lag)).collect();
        if asked.len() < 2 {
            break;
        }
        let trials: Vec<(Candidate, Model, Vec<f64>)> = asked
            .iter()
            .map(|c| {
                let mut without = c.removed(&model);
                judges.fit(&mut without, 10, 1e-3);
                let left = judges.left_out(&without);
                (*c, without, left)
            })
            .collect();
        let least = trials.into_iter().min_by(|a, b| judges.error(&a.2).total_cmp(&judges.error(&b.2)));
        let Some((candidate, without, left)) =
            least.filter(|t| judges.error(&now) > (1.0 - WORTH) * judges.error(&t.2))
        else {
            break;
        };
        let fall = 100.0 * (1.0 - judges.error(&now) / judges.error(&left));
        story.refuse(
            candidate.name(),
            format!("superfluous beside the others: it takes {fall:.1} % of the left-out error"),
        );
        (model, now) = (without, left);
        added.retain(|c| c.name() != candidate.name());
    }
    judges.fit(&mut model, 30, 1e-7);
    if model.slots.contains(&Slot::Lag) && !is_a_lag(model.machine.lag) {
        model = Candidate::Lag.removed(&model);
        added.retain(|c| !matches!(c, Candidate::Lag));
        judges.fit(&mut model, 30, 1e-7);
    }
    story.stages.push(stage("final", &everything, &model));
    Some(report(bench, &all, &judges, &declared, &model, &added, &candidates, held, story, &now))
}

fn is_added(candidate: Candidate, model: &Model, known_terms: usize) -> bool {
    match candidate {
        Candidate::Lag => candidate.is_in(model),
        Candidate::Effect(effect) => {
            model.machine.terms.iter().skip(known_terms).any(|t| t.effect.name() == effect.name())
        }
    }
}

fn stage(name: &str, tracks: &[&Track], model: &Model) -> Stage {
    let residuals = model.residuals(tracks);
    let (fit, held) = (error(tracks, &residuals, true), error(tracks, &residuals, false));
    Stage::new(name, fit, held)
}

/// The declared model's own parameters refitted; those that the logs don't show stay as declared. An input that comes
/// late and an inertia answer for the same phase, so they are fitted together, before any effect can take the place of
/// either. Like an effect, a lag has to earn its place on what was left out.
fn refit(declared: &Model, judges: &Judges, all: &[Track], bench: &Bench) -> (Model, Vec<String>) {
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
    model.slots.extend([Slot::Inertia, Slot::Damping]);
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
        held.push(name(&model, slot));
        let mut back = model.clone();
        back.slots = vec![slot];
        model.machine = back.with(&[declared.get(slot)]);
    }
}

/// Covariance of the unknowns, from the logs or stretches as independent judges.
fn covariance(model: &Model, judges: &Judges) -> nalgebra::DMatrix<f64> {
    let n = model.slots.len();
    let (at, columns) = model.derivatives(&judges.fit);
    let mut normal = nalgebra::DMatrix::<f64>::zeros(n, n);
    let mut scores = nalgebra::DMatrix::<f64>::zeros(n, judges.fold.len());
    for (t, units) in judges.unit.iter().enumerate() {
        for (k, unit) in units.iter().enumerate() {
            for a in 0..n {
                scores[(a, *unit)] += columns[t][a][k] * at[t][k];
                for b in 0..=a {
                    normal[(a, b)] += columns[t][a][k] * columns[t][b][k];
                }
            }
        }
    }
    normal.fill_upper_triangle_with_lower_triangle();
    // Scaled, so that inversion does not see units.
    let size: Vec<f64> = (0..n).map(|j| normal[(j, j)].sqrt().max(f64::MIN_POSITIVE)).collect();
    let scaled = nalgebra::DMatrix::from_fn(n, n, |a, b| normal[(a, b)] / (size[a] * size[b]));
    let Some(inverse) = scaled.try_inverse() else { return nalgebra::DMatrix::from_element(n, n, f64::NAN) };
    let inverse = nalgebra::DMatrix::from_fn(n, n, |a, b| inverse[(a, b)] / (size[a] * size[b]));
    let units = judges.fold.len() as f64;
    let spread = &scores * scores.transpose() * (units / (units - 1.0).max(1.0));
    &inverse * spread * &inverse
}

/// What can be tried on these logs; the rest is refused with its reason.
fn candidates(all: &[Track], story: &mut Story) -> Vec<Candidate> {
    let measured_supply = all.iter().any(|t| t.supply.windows(2).any(|w| w[0] != w[1]));
    let mut list = Vec::new();
    for effect in EFFECTS {
        let reason = match effect.name() {
            "viscous_friction" => "with duty alone it cannot be told from the back-EMF: both are in `damping`",
            "supply_sag" if measured_supply => "the voltage is measured, sag and all",
            name if CANDIDATES.contains(&name) => continue,
            _ if effect.acts_on() == Equation::Angle || effect.name() == "gear_compliance" => {
                "both sides of the gear would have to be measured"
            }
            "torque_constant_temperature" | "winding_temperature" => {
                "a simulated position is not asked for temperatures: a log with current would show it"
            }
            _ => "a simulated position is not asked for it: a log with current or torque would show it",
        };
        story.refuse(effect.name(), reason.into());
    }
    for wanted in CANDIDATES {
        if let Some(effect) = effect(wanted)
            && !story.refused.iter().any(|r| r.name == *wanted)
        {
            list.push(Candidate::Effect(effect));
        }
    }
    list.push(Candidate::Lag);
    list
}

/// The next effect, where one deserves it.
fn next(candidates: &[Candidate], model: &Model, now: &[f64], judges: &Judges, story: &mut Story) -> Option<Tried> {
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
            story.refuse(candidate.name(), reason);
        } else if error > (1.0 - WORTH) * base {
            let fall = fall.max(0.0);
            story.refuse(candidate.name(), format!("nothing: the error falls by {fall:.1} % even where it is fitted"));
        } else {
            fits.push((*candidate, with, error));
        }
    }
    // Only the best are worth leaving logs out for.
    fits.sort_by(|a, b| a.2.total_cmp(&b.2));
    for (candidate, _, error) in fits.iter().skip(3) {
        let fall = 100.0 * (1.0 - error / base);
        story.refuse(candidate.name(), format!("others explain more: the error would fall by {fall:.1} %"));
    }
    fits.truncate(3);
    let judged = fits.len() as f64;
    let mut tried: Vec<Tried> = Vec::new();
    for (candidate, with, _) in fits {
        let left_out = judges.left_out(&with);
        let error = judges.error(&left_out);
        let probability = chance(now, &left_out) * judged;
        if error > (1.0 - WORTH) * before {
            let fall = 100.0 * (1.0 - error / before);
            story.refuse(
                candidate.name(),
                format!("on what was left out the error falls by {fall:.1} %, less than 3 %"),
            );
        } else if probability > CHANCE {
            let fall = 100.0 * (1.0 - error / before);
            story.refuse(
                candidate.name(),
                format!("the left-out error falls by {fall:.1} %, but by chance one of those tried would as well in {:.0} % of cases",
                    100.0 * probability.min(1.0)),
            );
        } else {
            story.refuse(candidate.name(), "another explains it better".into());
            tried.push(Tried { candidate, model: with, error });
        }
    }
    let best = tried.iter().map(|t| t.error).fold(f64::INFINITY, f64::min);
    // A tie goes to the simplest: the order of the candidates.
    let rank = |t: &Tried| candidates.iter().position(|c| c.name() == t.candidate.name());
    tried.into_iter().filter(|t| t.error <= (1.0 + TIE) * best).min_by_key(rank)
}

/// Effects that do about as well in the place of one that was found.
fn look_alikes(
    found: Candidate,
    model: &Model,
    now: &[f64],
    candidates: &[Candidate],
    judges: &Judges,
) -> Vec<&'static str> {
    let without = found.removed(model);
    let error = judges.error(now);
    let mut list = Vec::new();
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
            list.push(effect.name());
        }
    }
    list
}

#[allow(clippy::too_many_arguments, reason = "everything that the story gathered goes into the report")]
fn report(
    bench: &Bench,
    all: &[Track],
    judges: &Judges,
    declared: &Model,
    model: &Model,
    added: &[Candidate],
    candidates: &[Candidate],
    held: Vec<String>,
    story: Story,
    now: &[f64],
) -> Report {
    let matrix = covariance(model, judges);
    let names: Vec<String> = model.slots.iter().map(|s| name(model, *s)).collect();
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
        let called = name(model, slot);
        let standard_error = deviation(&called);
        if standard_error.is_some() || held.contains(&called) {
            parameters.push(Parameter {
                name: called,
                declared: known(slot),
                fitted: model.get(slot),
                standard_error,
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
            let values = model.machine.terms.iter().find(|t| t.effect.name() == effect.name())?.values.clone();
            let mut without = c.removed(model);
            let plain = without.residuals(&everything);
            judges.fit(&mut without, 15, 1e-4);
            let before = without.residuals(&everything);
            let change: Vec<f64> =
                plain.iter().flatten().zip(after.iter().flatten()).map(|(a, b)| (a - b).powi(2)).collect();
            Some(Found {
                name: effect.name(),
                equation: effect.equation(),
                parameters: effect
                    .parameters()
                    .iter()
                    .zip(&values)
                    .map(|(p, v)| Parameter {
                        name: p.name.into(),
                        declared: None,
                        fitted: *v,
                        standard_error: deviation(&format!("{}.{}", effect.name(), p.name)),
                        unit: p.kind.si,
                    })
                    .collect(),
                instances: vec![values],
                size: (change.iter().sum::<f64>() / change.len().max(1) as f64).sqrt(),
                held_out_before: error(&everything, &before, false).map(|e| e.0),
                held_out_after: held_after,
                confounded_with: look_alikes(*c, model, now, candidates, judges),
                enters: effect.enters(),
            })
        })
        .collect();
    let mut artefacts = Vec::new();
    // One that is not seen beside its error stays in the fit for the errors' sake, and is not told.
    let is_seen = deviation("lag").is_some_and(|e| model.machine.lag > 3.0 * e);
    if added.iter().any(|c| matches!(c, Candidate::Lag)) && is_seen {
        artefacts.push(Report::lag("duty", model.machine.lag));
    }
    let floor = noise(all);
    let unexplained = left(judges, &model.residuals(&judges.fit), floor);
    let evidence = Evidence::unbounded(effects.len(), unexplained.len(), judges.error(now));
    let next_runs = effects
        .iter()
        .flat_map(|e| e.confounded_with.iter().map(move |r| (e.name, *r)))
        .map(|(name, rival)| {
            format!("`{name}` or `{rival}`: a run at another load and other speeds would separate them")
        })
        .collect();
    let samples = all.iter().map(Track::len).sum();
    let mut report = Report {
        target: Target::Position,
        unit: "rad",
        band: None,
        samples: (samples, judges.samples),
        verdict: evidence::verdict(&evidence),
        evidence,
        stages: story.stages,
        artefacts,
        parameters,
        effects,
        refused: story.refused,
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
    let mut remarks =
        vec![format!("errors are of the simulated position, from {how}; K_T stands for K_T/R, which alone is seen")];
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

/// Noise of the measured positions \[rad\], from what does not go on from sample to sample.
fn noise(all: &[Track]) -> f64 {
    let levels: Vec<f64> = all
        .iter()
        .map(|t| {
            let squares: Vec<f64> =
                t.position.windows(4).map(|w| (w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).powi(2)).collect();
            (signals::quantile(squares.clone(), 0.5).unwrap_or(0.0) / 0.455 / 20.0)
                .max(0.25 * squares.iter().filter(|v| v.is_finite()).sum::<f64>() / 20.0 / squares.len().max(1) as f64)
                .sqrt()
        })
        .collect();
    signals::median(levels).unwrap_or(0.0)
}

/// What is left and what it goes with: means over classes of speed and position, and of each log.
fn left(judges: &Judges, residuals: &[Vec<f64>], floor: f64) -> Vec<Unexplained> {
    let all: Vec<f64> = residuals.iter().flatten().copied().collect();
    let total: f64 = all.iter().map(|r| r * r).sum();
    let error = (total / all.len().max(1) as f64).sqrt();
    if error.is_nan() || error <= LEFT * floor {
        return Vec::new();
    }
    let speeds: Vec<f64> = judges.fit.iter().flat_map(|t| speed(t)).collect();
    let positions: Vec<f64> = judges.fit.iter().flat_map(|t| t.position.clone()).collect();
    let share = |variable: &[f64]| {
        const CLASSES: usize = 24;
        let mut sorted: Vec<f64> = variable.iter().copied().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let mut sums = [(0.0, 0.0); CLASSES];
        for (v, r) in variable.iter().zip(&all).filter(|(v, _)| v.is_finite()) {
            let rank = sorted.partition_point(|s| s < v) * CLASSES / sorted.len().max(1);
            let class = &mut sums[rank.min(CLASSES - 1)];
            *class = (class.0 + r, class.1 + 1.0);
        }
        sums.iter().filter(|s| s.1 > 0.0).map(|s| s.0 * s.0 / s.1).sum::<f64>() / total
    };
    let mut found: Vec<(&str, f64)> = vec![("speed", share(&speeds)), ("output position", share(&positions))];
    found.retain(|f| f.1 > 0.1);
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let times = error / floor.max(f64::MIN_POSITIVE);
    let mut list: Vec<Unexplained> = found
        .into_iter()
        .map(|(on, share)| Unexplained {
            depends_on: on.into(),
            detail: format!(
                "a free function of {on} takes away {:.0} % of the squared error that is left",
                100.0 * share
            ),
        })
        .collect();
    if list.is_empty() {
        list.push(Unexplained {
            depends_on: "time".into(),
            detail: format!("the error of the simulated position is {times:.0} times the sensor's noise"),
        });
    }
    list
}

/// Speed at the output from the measured position, over some 20 ms.
fn speed(track: &Track) -> Vec<f64> {
    let step = signals::median_step(&track.time).max(f64::MIN_POSITIVE);
    let over = signals::covering(0.01 / step);
    let last = track.len() - 1;
    (0..track.len())
        .map(|k| {
            let (a, b) = (k.saturating_sub(over), (k + over).min(last));
            (track.position[b] - track.position[a]) / (track.time[b] - track.time[a])
        })
        .collect()
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
