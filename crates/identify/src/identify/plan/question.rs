//! What the logs of one equation leave open: pairs of models that are not told apart, ready to be asked of a run.

use nalgebra::{DMatrix, DVector};

use super::criterion::{Contest, Truth};
use super::facts::{Pair, Rival, Unplanned};
use crate::answer::Report;
use crate::answer::evidence::BOUND;
use crate::identify::balance::{Balance, visible};
use crate::identify::candidates::{evaluate_all, held_look_alike, window};
use crate::identify::identified::Final;
use crate::identify::regression::{Blocks, solve, squares};
use crate::identify::scores::Scores;
use crate::identify::work::{Kind, Work};
use crate::signals;
use gearwise_model::effects::{EFFECTS, Effect, Shape, Variable, effect};

/// Shapes of an effect that are tried over its window.
const SHAPES: usize = 16;
/// Of other effects every so many of them.
const GUARDS: usize = 3;
/// A truth this much less likely than the best of its side is none.
const UNLIKELY: f64 = 0.05;
/// The largest δ of models that are not separated: one is not worse than the other by two standard errors between blocks,
/// and a squared error that is larger by δ² scatters by 2 δ.
const NOT_APART: f64 = 4.0;
/// Most refused effects that are planned for.
const MOST_REFUSED: usize = 3;

/// One side of a pair.
#[derive(Debug, Clone)]
enum Side {
    /// An effect with each of its shapes.
    Effect(&'static dyn Effect, Vec<f64>),
    /// A parameter of the declared model.
    Parameter(usize),
}

/// A pair of models, and what the logs say of it.
#[derive(Debug, Clone)]
pub struct Question {
    /// The pair.
    pub pair: Pair,
    /// What both models have.
    common: Vec<Kind>,
    sides: Vec<Side>,
    /// How the two are compared; after the common columns one for the zero of the planned run where the target has one.
    pub contest: Contest,
    /// The same where every other effect that this equation shows may be the other model, so that the run brings up no third one.
    pub guarded: Contest,
    /// Sums of products of the logs that are there.
    pub existing: DMatrix<f64>,
    /// Time between rows of these logs \[s\].
    spacing: f64,
    has_zero: bool,
}

/// What one equation leaves open, and what of it cannot be planned.
pub fn questions(work: &Work, model: &Final, report: &Report) -> (Vec<Question>, Vec<(Pair, Unplanned)>) {
    let mut asked = Vec::new();
    let mut left = Vec::new();
    let target = report.target;
    let mut ask = |work: &Work, term: Option<usize>, pair: Pair, sides: Result<Vec<Side>, Unplanned>| {
        if asked.iter().any(|q: &Question| q.pair == pair) {
            return;
        }
        let made = sides.and_then(|sides| question(work, model, term, pair, sides).ok_or(Unplanned::Implausible));
        match made {
            Ok(question) => asked.push(question),
            Err(why) => left.push((pair, why)),
        }
    };
    for found in &report.effects {
        let term = (0..work.terms.len()).find(|t| {
            work.terms[*t].declared.is_none() && work.terms[*t].effect().is_some_and(|(e, _)| e == found.effect)
        });
        let Some((t, own)) = term.and_then(|t| Some((t, work.terms[t].effect()?))) else {
            continue;
        };
        for rival in &found.confounded_with {
            let pair = Pair { target, effect: own.0, rival: Rival::Effect(*rival) };
            let sides = rival_side(work, own, *rival).map(|rival| vec![side(work, own), rival]);
            ask(work, Some(t), pair, sides);
        }
        if let Some(base) = held_look_alike(work, t, &model.held) {
            let index = work.balance.base.iter().position(|b| b.which == base);
            let sides = index.map(|i| vec![side(work, own), Side::Parameter(i)]).ok_or(Unplanned::Implausible);
            ask(work, Some(t), Pair { target, effect: own.0, rival: Rival::Parameter(base) }, sides);
        }
    }
    for candidate in unresolved(report).filter_map(effect).filter(|e| e.shape() != Shape::Order).take(MOST_REFUSED) {
        // As large as these logs suggest, where that is at all what it can be.
        let fit = work.fit();
        let best = evaluate_all(work, &fit, &[candidate]).pop();
        let Some(best) = best.filter(|c| c.gain > 0.0 && candidate.plausible(&c.values, &work.balance.scale).is_ok())
        else {
            continue;
        };
        let pair = Pair { target, effect: candidate, rival: Rival::Nothing };
        ask(work, None, pair, Ok(vec![Side::Effect(candidate, vec![best.shape])]));
    }
    let above = work.ripple.iter().flat_map(|r| &r.lines);
    for line in above {
        let rivals = line.twins.iter().map(|twin| Rival::Effect(*twin));
        left.extend(rivals.map(|rival| (Pair { target, effect: line.fitted.effect, rival }, Unplanned::AboveTheBand)));
    }
    (asked, left)
}

/// Names of refused effects that may still lower the error by more than a verdict allows.
fn unresolved(report: &Report) -> impl Iterator<Item = &'static str> + '_ {
    let open = report.effects.is_empty() && !report.evidence.teaches_nothing();
    report.evidence.asked.iter().filter(move |a| open && a.gain.most() > BOUND).map(|a| a.name)
}

/// An effect of the model with the shapes that it may have.
fn side(work: &Work, (own, shape): (&'static dyn Effect, f64)) -> Side {
    match own.shape() {
        Shape::None | Shape::Order => Side::Effect(own, vec![shape]),
        Shape::Speed(_) | Shape::Current(_) => {
            let mut shapes = spread(work, own);
            shapes.push(shape);
            Side::Effect(own, shapes)
        }
    }
}

/// What is not told from it, with the shapes that it may have; of an order the same one on the same side of the gear.
///
/// # Errors
/// An order on the other side of the gear is told by more turns alone, whatever the motion.
fn rival_side(work: &Work, own: (&'static dyn Effect, f64), rival: &'static dyn Effect) -> Result<Side, Unplanned> {
    let of_output = |e: &dyn Effect| e.needs().contains(&Variable::OutputAngle);
    match (rival.shape(), own.0.shape()) {
        (Shape::None, _) => Ok(Side::Effect(rival, vec![0.0])),
        (Shape::Order, Shape::Order) if of_output(own.0) == of_output(rival) => Ok(Side::Effect(rival, vec![own.1])),
        (Shape::Order, _) => Err(Unplanned::MoreTurns),
        (Shape::Speed(_) | Shape::Current(_), _) => Ok(Side::Effect(rival, spread(work, rival))),
    }
}

/// Shapes over the window of an effect.
fn spread(work: &Work, own: &'static dyn Effect) -> Vec<f64> {
    let Some((low, high)) = window(work, own) else { return vec![0.0] };
    (0..SHAPES).map(|k| low * (high / low).powf(k as f64 / (SHAPES - 1) as f64)).collect()
}

/// A pair as a contest; `None` where no values of it are plausible.
fn question(work: &Work, model: &Final, term: Option<usize>, pair: Pair, sides: Vec<Side>) -> Option<Question> {
    let own = sides.len();
    let mut sides = sides;
    sides.extend(guards(work, term, &sides));
    let parameter = |index: usize| sides.iter().any(|s| matches!(s, Side::Parameter(i) if *i == index));
    let mut common: Vec<Kind> =
        work.terms.iter().enumerate().filter(|(t, _)| Some(*t) != term).map(|(_, t)| t.kind).collect();
    // What is held as declared may be seen in the planned run: it is fitted there.
    for which in &model.held {
        let index = work.balance.base.iter().position(|b| b.which == *which)?;
        if !parameter(index) && is_a_number(&work.balance.base_column(index)) {
            common.push(Kind::Base(index));
        }
    }
    let has_zero = work.balance.target.has_zero();
    let mut question = Question {
        pair,
        common,
        sides,
        contest: Contest::empty(),
        guarded: Contest::empty(),
        existing: DMatrix::zeros(0, 0),
        spacing: spacing(&work.balance, &work.balance.rows.time),
        has_zero,
    };
    let columns = question.columns(&work.balance, false);
    if !columns.iter().all(|c| is_a_number(c)) {
        return None;
    }
    let count = columns.len();
    let references: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let blocks = Blocks::new(&work.balance.rows, &references, &work.target);
    let total = blocks.total(|b| work.fits(b));
    question.existing = total.view((0, 0), (count, count)).into_owned();
    let width = |kind: &Kind| if let Kind::Effect(effect, _) = kind { effect.linear() } else { 1 };
    question.contest.common = question.common.iter().map(width).sum::<usize>() + usize::from(has_zero);
    let mut next = question.contest.common;
    for side in &question.sides {
        let (instances, width) = match side {
            Side::Effect(effect, shapes) => (shapes.len(), effect.linear()),
            Side::Parameter(_) => (1, 1),
        };
        let of_side = (0..instances).map(|k| (next + k * width..next + (k + 1) * width).collect()).collect();
        next += instances * width;
        question.contest.sides.push(of_side);
    }
    question.contest.variance = variance(work, &blocks, &question.contest, &total)?;
    question.contest.truths = question.truths(work, &total);
    question.contest.truths.retain(|t| t.side < own);
    question.guarded = question.contest.clone();
    question.contest.sides.truncate(own);
    if own == 1 {
        question.contest.sides.push(Vec::new());
    }
    // What identification does not separate is not apart, however little blocks of time scatter.
    question.contest.variance *= (question.square_now() / NOT_APART.powi(2)).max(1.0);
    question.guarded.variance = question.contest.variance;
    (!question.contest.truths.is_empty()).then_some(question)
}

/// Other effects that could be named instead: those that this equation shows and the model does not have.
fn guards(work: &Work, term: Option<usize>, sides: &[Side]) -> Vec<Side> {
    let is_side = |e: &dyn Effect| sides.iter().any(|s| matches!(s, Side::Effect(own, _) if **own == *e));
    let others = |t: &usize| Some(*t) != term;
    let has = |e: &dyn Effect| {
        (0..work.terms.len()).filter(others).any(|t| work.terms[t].effect().is_some_and(|(own, _)| own == e))
    };
    let asked = EFFECTS.iter().copied().filter(|e| {
        e.shape() != Shape::Order
            && !is_side(*e)
            && !has(*e)
            && visible(*e, &work.balance, &work.bench.declared).is_ok()
    });
    let one = |effect: &'static dyn Effect| {
        let shapes: Vec<f64> = match effect.shape() {
            Shape::None => vec![0.0],
            _ => spread(work, effect).into_iter().step_by(GUARDS).collect(),
        };
        let finite = |shape: &f64| work.balance.effect_columns(effect, *shape).iter().all(|c| is_a_number(c));
        shapes.iter().all(finite).then_some(Side::Effect(effect, shapes))
    };
    asked.filter_map(one).collect()
}

fn is_a_number(column: &[f64]) -> bool {
    column.iter().all(|v| v.is_finite())
}

/// Usual time between neighbouring rows \[s\]; one where there is no time axis.
fn spacing(balance: &Balance, time: &[f64]) -> f64 {
    let steps = time.windows(2).map(|w| w[1] - w[0]).filter(|s| *s > 0.0).collect();
    if balance.step() == 0.0 { 1.0 } else { signals::median(steps).unwrap_or(1.0) }
}

/// Columns of the common model, then those of one instance of a side, of sums of products that have the target last.
fn restricted(total: &DMatrix<f64>, common: usize, instance: &[usize]) -> DMatrix<f64> {
    let keep: Vec<usize> = (0..common).chain(instance.iter().copied()).chain([total.nrows() - 1]).collect();
    DMatrix::from_fn(keep.len(), keep.len(), |i, j| total[(keep[i], keep[j])])
}

/// Variance of what is left in units of information: white, or as blocks of time scatter about what they should say, where
/// that is more.
fn variance(work: &Work, blocks: &Blocks, contest: &Contest, total: &DMatrix<f64>) -> Option<f64> {
    let instances = contest.sides.first()?;
    let left = |instance: &[usize]| {
        let own = restricted(total, contest.common, instance);
        squares(&own, &solve(&own).coefficients)
    };
    let best = instances.iter().min_by(|a, b| left(a).total_cmp(&left(b)))?;
    let count = blocks.count(|b| work.fits(b)).saturating_sub(contest.common + best.len()).max(1);
    let white = left(best) / count as f64;
    let keep: Vec<usize> = (0..contest.common).chain(best.iter().copied()).collect();
    let scattered = Scores::new(&blocks.select(&keep), contest.common, |b| work.fits(b)).variance();
    let variance = white.max(if scattered.is_finite() { scattered } else { 0.0 });
    (variance > 0.0).then_some(variance)
}

impl Question {
    /// Its columns on a balance; of a run with the zero of the run as a column of its own.
    fn columns(&self, balance: &Balance, with_zero: bool) -> Vec<Vec<f64>> {
        let of_effect = |effect: &'static dyn Effect, shape: f64| -> Vec<Vec<f64>> {
            if !with_zero {
                return balance.effect_columns(effect, shape);
            }
            let unit = |j: usize| -> Vec<f64> {
                let mut values: Vec<f64> = (0..effect.linear()).map(|i| f64::from(u8::from(i == j))).collect();
                values.push(shape);
                values
            };
            (0..effect.linear()).map(|j| balance.effect_with_zero(effect, &unit(j))).collect()
        };
        let of_base =
            |index: usize| if with_zero { balance.base_column_with_zero(index) } else { balance.base_column(index) };
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for kind in &self.common {
            match *kind {
                Kind::Base(index) => columns.push(of_base(index)),
                Kind::Effect(effect, shape) => columns.extend(of_effect(effect, shape)),
            }
        }
        if self.has_zero {
            columns.push(vec![f64::from(u8::from(with_zero)); balance.rows.len()]);
        }
        for side in &self.sides {
            match side {
                Side::Effect(effect, shapes) => columns.extend(shapes.iter().flat_map(|s| of_effect(*effect, *s))),
                Side::Parameter(index) => columns.push(of_base(*index)),
            }
        }
        columns
    }

    /// What may be true: each instance of each side, fitted to the logs that are there, as likely as it fits.
    fn truths(&self, work: &Work, total: &DMatrix<f64>) -> Vec<Truth> {
        let contest = &self.contest;
        let mut truths = Vec::new();
        for (index, side) in self.sides.iter().enumerate() {
            let mut own: Vec<(f64, Truth)> = Vec::new();
            for (k, instance) in contest.sides[index].iter().enumerate() {
                let products = restricted(total, contest.common, instance);
                let solution = solve(&products);
                let values: Vec<f64> = solution.coefficients.iter().skip(contest.common).copied().collect();
                if let Side::Effect(effect, shapes) = side {
                    let mut all = values.clone();
                    all.extend((effect.shape() != Shape::None).then_some(shapes[k]));
                    if effect.plausible(&all, &work.balance.scale).is_err() {
                        continue;
                    }
                }
                let left = squares(&products, &solution.coefficients);
                let (columns, values) = (instance.clone(), DVector::from_vec(values));
                own.push((left, Truth { side: index, columns, values, weight: 0.0 }));
            }
            let least = own.iter().map(|(left, _)| *left).fold(f64::INFINITY, f64::min);
            for (left, mut truth) in own {
                truth.weight = (-0.5 * (left - least) / contest.variance).exp();
                if truth.weight > UNLIKELY {
                    truths.push(truth);
                }
            }
        }
        truths
    }

    /// Sums of products of a run's rows in parts, as `part` says of each row's time (`None` takes no part), in units of the
    /// information of the logs that are there. `None` where the run does not show the columns.
    pub fn of_run(
        &self,
        run: &Balance,
        parts: usize,
        part: impl Fn(f64) -> Option<usize>,
    ) -> Option<Vec<DMatrix<f64>>> {
        let columns = self.columns(run, true);
        if columns.len() != self.existing.nrows() || !columns.iter().all(|c| is_a_number(c)) {
            return None;
        }
        let scale = spacing(run, &run.rows.time) / self.spacing;
        let n = columns.len();
        let mut sums = vec![DMatrix::zeros(n, n); parts];
        for (k, time) in run.rows.time.iter().enumerate() {
            let Some(at) = part(*time).filter(|at| *at < parts) else { continue };
            for i in 0..n {
                let own = scale * columns[i][k];
                if own != 0.0 {
                    for j in 0..=i {
                        sums[at][(i, j)] += own * columns[j][k];
                    }
                }
            }
        }
        sums.iter_mut().for_each(|sum| sum.fill_upper_triangle_with_lower_triangle());
        Some(sums)
    }

    /// δ² with what a run adds to the logs that are there.
    pub fn square(&self, run: &DMatrix<f64>) -> f64 {
        self.contest.square(&(&self.existing + run))
    }

    /// The same against every other effect.
    pub fn square_guarded(&self, run: &DMatrix<f64>) -> f64 {
        self.guarded.square(&(&self.existing + run))
    }

    /// δ² of the logs that are there.
    pub fn square_now(&self) -> f64 {
        self.contest.square(&self.existing)
    }
}

/// Whether an effect of a pair depends on a temperature.
pub fn is_of_temperature(pair: &Pair) -> bool {
    let rival = if let Rival::Effect(rival) = pair.rival { rival.needs_temperature() } else { false };
    pair.effect.needs_temperature() || rival
}
