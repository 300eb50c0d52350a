//! The best ratios of one combination of motors on one bus: a convex program over all joints at once.
//!
//! Each joint brings an interval of u = N² that its own limits leave, and a convex objective; what all draw
//! together at an instant is a row over all joints, and on a supply that sags so is what a drive asks for beyond what
//! the others leave it. Rows and objective are added as cuts where they are broken.
//! The bound comes from the multipliers alone: for fixed ones the joints fall apart, and each is minimised
//! exactly.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::convex::{Convex, add, least_of_pieces, least_over, under};
use super::dual::{self, Separable};
use super::power::{self, Draws, Places, Profile, Schedule, largest, worst_drive};
use super::work::Work;
use crate::Prepared;
use crate::program::{RatioProgram, minimise, value};
use gearwise_model::actuator::Laurent;
use gearwise_model::requirement::Joint;

/// Rounds of adding cuts.
const ROUNDS: usize = 40;
/// A relative gap below this is none.
const CLOSED: f64 = 1e-6;
/// How often the ratios are narrowed to those that may be better before they are divided.
const CONTRACTIONS: usize = 3;
/// Pieces of a range of ratios that are looked at when it is narrowed.
const PIECES: usize = 32;
/// Boxes of ratios that are looked at where a program is not convex.
const BOXES: usize = 300;
/// The same where what comes back is limited.
const BOXES_RETURNING: usize = 600;
/// Ratios that draw little more than the least, relative to it, are as good as those that draw least.
const GENTLE: f64 = 0.01;
/// What draws more than the limit by this share certainly does.
const SURELY: f64 = 1e-7;
/// Halvings of the way to ratios that fit.
const HALVINGS: usize = 36;
/// Steps on the way to ratios that keep the power.
const STEPS: usize = 50;
/// Rounds without anything new after which a box is given up.
const STALLED: usize = 3;
/// Rows and columns of a cone program that take a step of [`Work`] in each iteration.
const CONE: usize = 2;
/// Steps of work per sample of returned power in a bound between two ratios.
const SAMPLE: usize = 5;
/// The power of all joints is kept to this relative accuracy.
pub(super) const POWER_TOLERANCE: f64 = 1e-9;

/// One joint of a combination.
pub(super) struct Part<'p> {
    pub prepared: &'p Prepared<'p>,
    pub joint: &'p Joint,
    pub profile: Profile,
    /// Ratios that the joint's own limits leave.
    pub ratios: (f64, f64),
    /// Its own best ratio, and the objective and its bound there.
    pub own: f64,
    pub objective: f64,
    pub lower: f64,
    /// Share of the objective in the total.
    pub scale: f64,
}

impl Part<'_> {
    fn moves(&self) -> bool {
        self.ratios.1 / self.ratios.0 - 1.0 > 1e-12
    }

    fn program(&self) -> RatioProgram<'_> {
        RatioProgram::new(self.prepared, &self.joint.objective, self.ratios.0, self.ratios.1)
    }

    /// The objective's share in the total at a ratio.
    fn value(&self, ratio: f64) -> f64 {
        if ratio == self.own { self.scale * self.objective } else { self.scale * self.program().objective_at(ratio) }
    }

    /// The ratios at which its share of the total may be at most so much: pieces at both ends at which it certainly is more are
    /// left out.
    fn within(&self, most: f64) -> (f64, f64) {
        let mut ratios = self.ratios;
        for _ in 0..3 {
            let (a, b) = ratios;
            let edge = |k: usize| if k == PIECES { b } else { a * (b / a).powf(k as f64 / PIECES as f64) };
            let may_be = |k: &usize| {
                let (low, high) = (edge(*k), edge(k + 1));
                let (polynomial, _) = self.program().objective_cut((low * high).sqrt());
                let mut least = under(&polynomial, (low, high), (low * high).sqrt());
                least[1] += self.program().objective_cut(self.ratios.1).1;
                let u = minimise(&least, low * low, high * high);
                self.scale * (value(&least, u) - 1e-13 * value(&least.map(f64::abs), u)) <= most
            };
            let Some(first) = (0..PIECES).find(may_be) else { break };
            let last = (0..PIECES).rev().find(may_be).unwrap_or(first);
            ratios = (edge(first), edge(last + 1));
        }
        ratios
    }

    /// The least of its share in the total at the ratios that it has now: where its own best is beyond them, it is at the nearer end.
    fn least(&self) -> f64 {
        let (a, b) = self.ratios;
        let all = self.scale * self.lower;
        if (a <= self.own && self.own <= b) || !self.moves() {
            return all;
        }
        all.max(least_over(&self.cut(if self.own < a { a } else { b }), (a, b)))
    }

    /// The share in the total as a polynomial that touches it at a ratio and is nowhere above it.
    fn cut(&self, ratio: f64) -> Laurent {
        let (polynomial, _) = self.program().objective_cut(ratio);
        // The mass by stages is the same all over the interval but at its start.
        let steps = self.program().objective_cut(self.ratios.1).1;
        (polynomial + Laurent::constant(steps)) * self.scale
    }

    /// The row of its share in the total that touches it at a ratio.
    fn epigraph(&self, joint: usize, ratio: f64) -> Cut {
        let parts = vec![Share::new(self, joint, self.cut(ratio), ratio)];
        Cut { epigraph: Some(joint), parts, places: None, most: 0.0, returned: Vec::new() }
    }
}

/// How much the power at some instants costs.
#[derive(Debug, Clone, Default)]
pub(super) struct Price {
    /// For each row the instant of each group, and its multiplier \[objective/W\].
    pub rows: Vec<(Places, f64)>,
}

impl Price {
    /// Of rows the power alone.
    fn of(rows: Vec<(Shared, f64)>) -> Price {
        let power = |(row, price)| match row {
            Shared::Power(places) => Some((places, price)),
            Shared::Returned(_) => None,
        };
        Price { rows: rows.into_iter().filter_map(power).collect() }
    }

    fn of_power(&self) -> Vec<(Shared, f64)> {
        self.rows.iter().map(|(places, price)| (Shared::Power(places.clone()), *price)).collect()
    }

    /// The rows of the power of all joints alone, without those of single drives.
    pub(super) fn of_all(&self) -> Price {
        Price { rows: self.rows.iter().filter(|(places, _)| places.drive.is_none()).cloned().collect() }
    }

    /// The same as shares of one.
    pub(super) fn shares(&self) -> Price {
        let all: f64 = self.rows.iter().map(|(_, price)| price).sum();
        Price { rows: self.rows.iter().map(|(places, price)| (places.clone(), price / all)).collect() }
    }
}

/// What came of a combination.
#[derive(Debug)]
pub(super) enum Outcome {
    Solved(Solved),
    /// The bus cannot feed it: the least power that it draws at its worst instant, and what shows it.
    TooMuch {
        least: f64,
        price: Price,
    },
    /// More comes back than the bus may take, at all ratios.
    ComesBack,
}

#[derive(Debug)]
pub(super) struct Solved {
    pub ratios: Vec<f64>,
    pub value: f64,
    pub lower: f64,
    pub price: Price,
}

impl Solved {
    /// Whether value and bound are not one yet.
    fn is_open(&self) -> bool {
        self.value == f64::INFINITY || self.value - self.lower > CLOSED * self.value.abs()
    }
}

/// What a joint has in a row: a polynomial in its ratio, and what is convex, nowhere above it and touches it.
struct Share {
    joint: usize,
    polynomial: Laurent,
    convex: Convex,
}

impl Share {
    fn new(part: &Part, joint: usize, polynomial: Laurent, ratio: f64) -> Share {
        Share { joint, polynomial, convex: under(&polynomial, part.ratios, ratio) }
    }
}

/// A row `Σ convex ≤ bound`, or `≤ z` of an epigraph.
struct Cut {
    epigraph: Option<usize>,
    parts: Vec<Share>,
    /// Of power: the instants that it is the row of.
    places: Option<Places>,
    /// What a row may be at most; nothing of an epigraph.
    most: f64,
    /// Of what comes back: joint, sample and weight. Its parts are tangents, which are above it.
    returned: Vec<(usize, usize, f64)>,
}

#[derive(Clone, Copy)]
struct Program<'p> {
    parts: &'p [Part<'p>],
    schedule: &'p Schedule,
    /// What may come back from all joints together \[W\].
    returned: Option<f64>,
    work: &'p Work,
    /// What is not below this is of no interest.
    threshold: f64,
    /// What power cost in other combinations.
    known: Known<'p>,
}

/// The constraints that all joints of a combination share.
#[derive(Clone, Copy)]
pub(super) struct Shares<'s> {
    pub schedule: &'s Schedule,
    /// Limit on the power of all joints \[W\]; infinite where there is none.
    pub limit: f64,
    /// Limit on the power returned by all joints \[W\].
    pub returned: Option<f64>,
    /// Counts what is done.
    pub work: &'s Work,
}

/// What is known of other combinations.
#[derive(Clone, Copy, Default)]
pub(super) struct Known<'k> {
    /// What power cost in them.
    pub prices: &'k [Price],
    /// What it cost in the last that the bus could not feed.
    pub too_much: Option<&'k Price>,
}

/// The joints of a program, each for itself.
struct Apart<'d> {
    program: &'d Program<'d>,
    programs: Vec<RatioProgram<'d>>,
    gentlest: &'d [f64],
    limit: f64,
    /// Nothing counts but what they draw.
    drawing: bool,
}

impl Apart<'_> {
    /// What a joint has in an instant of each group: samples and weights.
    fn of_joint<'p>(&'p self, places: &'p Places, joint: usize) -> impl Iterator<Item = (usize, f64)> + 'p {
        let parts = self.program.schedule.parts(places).filter(move |(j, ..)| *j == joint);
        parts.map(|(_, sample, weight)| (*sample, *weight))
    }
}

/// A row over all joints: what they draw at an instant of each group, or what comes back there.
#[derive(Debug, Clone, PartialEq)]
enum Shared {
    Power(Places),
    Returned(Places),
}

impl Separable for Apart<'_> {
    type Row = Shared;

    fn ratios(&self) -> Vec<(f64, f64)> {
        let of = |part: &Part| if part.moves() { part.ratios } else { (part.own, part.own) };
        self.program.parts.iter().map(of).collect()
    }

    fn value(&self, joint: usize, ratio: f64) -> f64 {
        if self.drawing {
            return 0.0;
        }
        let part = &self.program.parts[joint];
        let objective = if ratio == part.own { part.objective } else { self.programs[joint].objective_at(ratio) };
        part.scale * objective
    }

    fn cut(&self, joint: usize, ratio: f64) -> Laurent {
        if self.drawing {
            return Laurent::default();
        }
        let part = &self.program.parts[joint];
        // What does not move is what it is.
        if part.moves() { part.cut(ratio) } else { Laurent::constant(part.scale * part.lower) }
    }

    fn drawn(&self, row: &Shared, joint: usize, ratio: f64) -> f64 {
        match row {
            Shared::Power(places) => self.program.share_of_power(places, joint, ratio, self.limit).0,
            Shared::Returned(places) => {
                let profile = &self.program.parts[joint].profile;
                let of_sample = |(k, weight)| {
                    self.program.work.count(1);
                    weight * profile.returned(k, ratio)
                };
                self.of_joint(places, joint).map(of_sample).sum()
            }
        }
    }

    fn drawn_cut(&self, row: &Shared, joint: usize, ratio: f64) -> Option<Laurent> {
        let Shared::Power(places) = row else { return None };
        Some(self.program.share_of_power(places, joint, ratio, self.limit).1)
    }

    fn limit(&self, row: &Shared) -> f64 {
        match row {
            Shared::Power(_) => self.limit,
            Shared::Returned(_) => self.program.returned.unwrap_or(f64::INFINITY),
        }
    }

    fn least(&self, joint: usize, polynomial: &Laurent, rows: &[(&Shared, f64)]) -> f64 {
        let mut priced: Vec<(usize, f64)> = Vec::new();
        for (row, price) in rows {
            let Shared::Returned(places) = row else { continue };
            priced.extend(self.of_joint(places, joint).map(|(sample, weight)| (sample, price * weight)));
        }
        match priced.is_empty() {
            true => least_over(polynomial, self.ratios()[joint]),
            false => self.program.least_with_returned(joint, polynomial, &priced),
        }
    }

    fn count(&self, steps: usize) {
        self.program.work.count(steps);
    }

    fn kept(&self, ratios: &[f64]) -> (Vec<f64>, Option<Shared>) {
        let (power, places) = self.program.power(ratios, self.limit);
        let kept = self.program.kept(ratios, power, self.gentlest, self.limit);
        let broken = (power > self.limit).then_some(Shared::Power(places));
        match self.program.beyond(&kept) {
            None => (kept, broken),
            Some(places) => {
                let fits = |at: &[f64]| self.program.fits(at, self.limit);
                (self.program.towards(&kept, self.gentlest, fits), Some(Shared::Returned(places)))
            }
        }
    }
}

/// Solves a combination under a limit on the power of all joints \[W\], and on what comes back from them \[W\]. Where a joint's program
/// is not convex (motor Coulomb friction), or what comes back is limited (the complement of a convex set), the intervals of ratios are
/// divided until the bounds meet, or none of them is below what is of interest, or until somebody ends it.
pub(super) fn solve(
    parts: &mut [Part],
    Shares { schedule, limit, returned, work }: Shares,
    (threshold, known): (f64, Known),
    ends: &dyn Fn() -> bool,
) -> Outcome {
    let solve_box = |parts: &[Part]| solve_box(Program { parts, schedule, returned, work, threshold, known }, limit);
    let first = match solve_box(parts) {
        Outcome::Solved(solved) if solved.is_open() && solved.lower < threshold => solved,
        done => return done,
    };
    let whole: Vec<(f64, f64)> = parts.iter().map(|p| p.ratios).collect();
    let mut best = first;
    // Near the best the bounds are nearer too.
    for _ in 0..CONTRACTIONS {
        contract(parts, best.value);
        match solve_box(parts) {
            Outcome::Solved(solved) => {
                let lower = solved.lower.min(best.value).max(best.lower);
                best = if solved.value < best.value { solved } else { best };
                best.lower = lower.min(best.value);
            }
            // Nothing there, and nothing better elsewhere.
            Outcome::TooMuch { .. } | Outcome::ComesBack => best.lower = best.value,
        }
        if !best.is_open() || best.lower >= threshold {
            break;
        }
    }
    let mut open = vec![(best.lower, parts.iter().map(|p| p.ratios).collect::<Vec<(f64, f64)>>())];
    // What was settled with a bound below the best value.
    let mut settled = f64::INFINITY;
    for _ in 0..if returned.is_some() { BOXES_RETURNING } else { BOXES } {
        let Some(place) = (0..open.len()).min_by(|a, b| open[*a].0.total_cmp(&open[*b].0)) else { break };
        let enough = threshold.min(best.value - 0.5 * CLOSED * best.value.abs());
        if open[place].0 >= enough || ends() {
            break;
        }
        let (_, boxed) = open.swap_remove(place);
        let bent = |j: &usize| {
            let part = &parts[*j];
            part.prepared.candidate.has_odd_powers() || (returned.is_some() && part.moves())
        };
        let width = |j: &usize| boxed[*j].1 / boxed[*j].0;
        let Some(split) = (0..boxed.len()).filter(bent).max_by(|a, b| width(a).total_cmp(&width(b))) else {
            settled = settled.min(best.lower);
            break;
        };
        let (a, b) = boxed[split];
        let middle = (a * b).sqrt();
        for half in [(a, middle), (middle, b)] {
            let mut boxed = boxed.clone();
            boxed[split] = half;
            for (part, ratios) in parts.iter_mut().zip(&boxed) {
                part.ratios = *ratios;
            }
            if let Outcome::Solved(solved) = solve_box(parts) {
                open.push((solved.lower, boxed));
                if solved.value < best.value {
                    best = solved;
                }
            }
        }
    }
    for (part, ratios) in parts.iter_mut().zip(whole) {
        part.ratios = ratios;
    }
    let left = open.iter().map(|o| o.0).fold(settled, f64::min);
    if best.value == f64::INFINITY && left == f64::INFINITY {
        return match returned {
            Some(_) => Outcome::ComesBack,
            None => Outcome::TooMuch { least: limit, price: best.price },
        };
    }
    best.lower = left.min(best.value);
    Outcome::Solved(best)
}

/// Leaves each joint only the ratios at which it can have a part in a total of no more than `value`, the others at their least.
fn contract(parts: &mut [Part], value: f64) {
    if !value.is_finite() {
        return;
    }
    let least: f64 = parts.iter().map(|p| p.scale * p.lower).sum();
    for part in parts.iter_mut().filter(|p| p.moves()) {
        part.ratios = part.within(value - (least - part.scale * part.lower) + CLOSED * CLOSED * value.abs());
    }
}

fn solve_box(program: Program, limit: f64) -> Outcome {
    let parts = program.parts;
    let own: Vec<f64> = parts.iter().map(|p| p.own.clamp(p.ratios.0, p.ratios.1)).collect();
    let unmoved = own.iter().zip(parts).all(|(n, p)| *n == p.own);
    let beyond = program.beyond(&own);
    if beyond.as_ref().is_some_and(|places| program.comes_back(places)) {
        return Outcome::ComesBack;
    }
    if unmoved && beyond.is_none() && program.power(&own, limit).0 <= limit * (1.0 + POWER_TOLERANCE) {
        let value = parts.iter().map(|p| p.scale * p.objective).sum();
        let lower = parts.iter().map(|p| p.scale * p.lower).sum();
        return Outcome::Solved(Solved { ratios: own, value, lower, price: Price::default() });
    }
    let no_value = |ratios: Vec<f64>, lower: f64, price: Price| {
        Outcome::Solved(Solved { ratios, value: f64::INFINITY, lower, price })
    };
    let mut gentlest = own.clone();
    if limit < f64::INFINITY {
        let known = program.least_at_known_prices(limit);
        if known >= program.threshold {
            return no_value(own, known, Price::default());
        }
        if let Some(price) = program.known.too_much {
            let price = price.shares();
            let least = program.least_power_at(&price, limit);
            if least > limit * (1.0 + SURELY) {
                return Outcome::TooMuch { least, price };
            }
        }
        let (found, least, price) = program.least_power(&own, limit);
        gentlest = found;
        if program.power(&gentlest, limit).0 > limit * (1.0 + POWER_TOLERANCE) {
            if least > limit * (1.0 - 1e-7) {
                return Outcome::TooMuch { least, price };
            }
            return no_value(gentlest, parts.iter().map(Part::least).sum(), price);
        }
    }
    // Without the limit on returned power the joints are independent; an optimum that keeps the limit is also the optimum with it.
    let free = program.by_prices(&own, &gentlest, limit);
    match program.returned {
        None => Outcome::Solved(free),
        Some(_) if free.value < f64::INFINITY && program.fits(&free.ratios, limit) => Outcome::Solved(free),
        Some(_) if free.lower >= program.threshold => no_value(free.ratios, free.lower, free.price),
        Some(_) => program.best_returning(&own, &gentlest, free, limit),
    }
}

/// What each joint draws at these ratios.
pub(super) fn draws(parts: &[Part], schedule: &Schedule, ratios: &[f64]) -> Vec<Draws> {
    let (returned, work, known) = (Some(f64::INFINITY), &Work::endless(), Known::default());
    Program { parts, schedule, returned, work, threshold: f64::INFINITY, known }.draws(ratios)
}

impl Program<'_> {
    /// What all draw at their worst instant \[W\]. On a supply that sags a drive asks for so much less than a limit on it as it asks
    /// for less than there is.
    fn power(&self, ratios: &[f64], limit: f64) -> (f64, Places) {
        let draws = self.draws(ratios);
        let powers: Vec<&[f64]> = draws.iter().map(|draws| draws.power.as_slice()).collect();
        let of_all = largest(self.schedule, &powers);
        match worst_drive(self.schedule, &draws) {
            Some((beyond, places)) if limit + beyond > of_all.0 => (limit + beyond, places),
            _ => of_all,
        }
    }

    fn draws(&self, ratios: &[f64]) -> Vec<Draws> {
        // What comes back takes time to find.
        let comes_back = self.returned.is_some();
        self.parts.iter().zip(ratios).map(|(p, n)| p.profile.draws(*n, comes_back)).collect()
    }

    /// The instants at which more comes back than may; `None` where none is.
    fn beyond(&self, ratios: &[f64]) -> Option<Places> {
        let most = self.returned?;
        let (returned, places) = power::most_returned(self.schedule, &self.draws(ratios));
        (returned > most + POWER_TOLERANCE * most.max(1.0)).then_some(places)
    }

    /// Whether more comes back at an instant of each group than may, at all ratios: the ratio of each joint has its own part in it.
    fn comes_back(&self, places: &Places) -> bool {
        let most = self.returned.unwrap_or(f64::INFINITY);
        let least = |(j, sample, weight): &(usize, usize, f64)| {
            weight * self.parts[*j].profile.least_returned(*sample, self.parts[*j].ratios)
        };
        self.schedule.parts(places).map(least).sum::<f64>() > most + POWER_TOLERANCE * most.max(1.0)
    }

    /// The row of what comes back at an instant of each group, by its tangents at some ratios: what keeps them keeps it.
    fn returned_row(&self, places: &Places, ratios: &[f64]) -> Cut {
        let mut sums: Vec<Option<Laurent>> = vec![None; self.parts.len()];
        let returned: Vec<(usize, usize, f64)> = self.schedule.parts(places).copied().collect();
        for (j, sample, weight) in &returned {
            let (n, profile) = (ratios[*j], &self.parts[*j].profile);
            let slope = profile.returned_slope(*sample, n) / (2.0 * n);
            let constant = Laurent::constant(profile.returned(*sample, n) - slope * n * n);
            count(&mut sums[*j], constant + Laurent::monomial(slope, 2), *weight);
        }
        let parts = self.shares(sums, ratios);
        Cut { epigraph: None, parts, places: None, most: self.returned.unwrap_or(f64::INFINITY), returned }
    }

    /// Shares of joints in a row that touch what they stand for at some ratios.
    fn shares(&self, sums: Vec<Option<Laurent>>, ratios: &[f64]) -> Vec<Share> {
        let of = |(j, sum): (usize, Option<Laurent>)| Some(Share::new(&self.parts[j], j, sum?, ratios[j]));
        sums.into_iter().enumerate().filter_map(of).collect()
    }

    /// The least of a joint's share over its ratios, with what comes back at prices.
    fn least_with_returned(&self, j: usize, sum: &Laurent, priced: &[(usize, f64)]) -> f64 {
        let part = &self.parts[j];
        least_of_pieces(part.ratios, |(a, b)| {
            self.work.count(SAMPLE * priced.len());
            let middle = (a * b).sqrt();
            let mut least = under(sum, (a, b), middle);
            for (sample, price) in priced {
                let cut = part.profile.returned_cut(*sample, middle, (a, b));
                add(&mut least, &under(&cut, (a, b), middle), *price);
            }
            let of_priced = |n: f64| priced.iter().map(|(k, price)| price * part.profile.returned(*k, n)).sum::<f64>();
            (least, Box::new(move |n| sum.at(n) + of_priced(n)))
        })
    }

    /// Whether some ratios keep what all share.
    fn fits(&self, ratios: &[f64], limit: f64) -> bool {
        self.beyond(ratios).is_none()
            && (limit == f64::INFINITY || self.power(ratios, limit).0 <= limit * (1.0 + POWER_TOLERANCE))
    }

    /// Ratios near some at which no more comes back than may: on the way to where each joint gives back least at an instant.
    fn returning(&self, ratios: &[f64], limit: f64) -> Option<Vec<f64>> {
        let fits = |ratios: &[f64]| self.fits(ratios, limit);
        let Some(places) = self.beyond(ratios) else { return Some(ratios.to_vec()) };
        let mut at_ends = vec![(0.0, 0.0); self.parts.len()];
        for (j, sample, weight) in self.schedule.parts(&places) {
            let part = &self.parts[*j];
            let (a, b) = part.ratios;
            at_ends[*j].0 += weight * part.profile.returned(*sample, a);
            at_ends[*j].1 += weight * part.profile.returned(*sample, b);
        }
        let gentle = |(part, (a, b)): (&Part, (f64, f64))| if a <= b { part.ratios.0 } else { part.ratios.1 };
        let gentle: Vec<f64> = self.parts.iter().zip(at_ends).map(gentle).collect();
        fits(&gentle).then(|| self.towards(ratios, &gentle, fits))
    }

    /// The nearest ratios on the way from some to others that fit, in u = N²; the others fit.
    fn towards(&self, from: &[f64], to: &[f64], fits: impl Fn(&[f64]) -> bool) -> Vec<f64> {
        let at = |share: f64| self.between(from, to, share);
        let (mut bad, mut good) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (bad + good);
            if fits(&at(middle)) { good = middle } else { bad = middle }
        }
        if good == 1.0 { to.to_vec() } else { at(good) }
    }

    /// A joint's share in the row of an instant of each group \[W\], and the polynomial that touches it at a ratio and is nowhere above it.
    fn share_of_power(&self, places: &Places, joint: usize, ratio: f64, limit: f64) -> (f64, Laurent) {
        let profile = &self.parts[joint].profile;
        let (mut value, mut polynomial) = (0.0, Laurent::default());
        let mut count = |(power, cut): (f64, Laurent), weight: f64| {
            value += power * weight;
            polynomial = polynomial + cut * weight;
        };
        for (_, sample, weight) in self.schedule.parts(places).filter(|(j, ..)| *j == joint) {
            match places.drive {
                None => count(profile.at(*sample, ratio), *weight),
                Some(_) => count(profile.taken(*sample, ratio), *weight),
            }
        }
        for (sample, share) in places.drive.iter().filter(|drive| drive.joint == joint).flat_map(|drive| &drive.samples)
        {
            let Some((beyond, cut)) = profile.beyond(*sample, ratio) else { continue };
            // Its own power is in what it asks for.
            count(profile.taken(*sample, ratio), -share);
            count((beyond + limit, cut + Laurent::constant(limit)), *share);
        }
        (value, polynomial)
    }

    /// The row of an instant of each group.
    fn row(&self, places: &Places, ratios: &[f64], epigraph: Option<usize>, limit: f64) -> Cut {
        let has_part = |j: &usize| {
            self.schedule.parts(places).any(|(joint, ..)| joint == j)
                || places.drive.as_ref().is_some_and(|drive| drive.joint == *j)
        };
        let of = |j: usize| {
            let polynomial = self.share_of_power(places, j, ratios[j], limit).1;
            Share::new(&self.parts[j], j, polynomial, ratios[j])
        };
        let parts = (0..self.parts.len()).filter(has_part).map(of).collect();
        Cut { epigraph, parts, places: Some(places.clone()), most: limit, returned: Vec::new() }
    }

    /// Ratios of the least peak, a bound below it, and the rows that show the bound.
    fn least_power(&self, start: &[f64], limit: f64) -> (Vec<f64>, f64, Price) {
        let mut ratios = start.to_vec();
        let (mut best, mut bound, mut price) = ((f64::INFINITY, ratios.clone()), f64::NEG_INFINITY, Price::default());
        let mut cuts: Vec<Cut> = Vec::new();
        for _ in 0..ROUNDS {
            let (power, places) = self.power(&ratios, limit);
            if power < best.0 {
                best = (power, ratios.clone());
            }
            cuts.push(self.row(&places, &ratios, Some(0), limit));
            let Some((next, multipliers)) = self.propose(&cuts, 1) else { break };
            let lower = self.bound(&cuts, &multipliers);
            if lower > bound {
                bound = lower;
                price = prices(&cuts, &multipliers);
            }
            // What can be fed needs no more than ratios on the safe side.
            let enough = if best.0 <= limit { GENTLE } else { 1e-8 };
            if best.0 - bound <= enough * best.0.abs() || next == ratios {
                break;
            }
            ratios = next;
        }
        (best.1, bound.min(best.0), price)
    }

    /// A bound at what power cost in other combinations: of those that are alike it says most.
    fn least_at_known_prices(&self, limit: f64) -> f64 {
        let apart = self.apart(&[], limit);
        let mut best = f64::NEG_INFINITY;
        for price in self.known.prices {
            let rows = price.of_power();
            let rows: Vec<(&Shared, f64)> = rows.iter().map(|(row, price)| (row, *price)).collect();
            best = best.max(dual::bounded(&apart, &rows).1);
            if best >= self.threshold {
                break;
            }
        }
        best
    }

    /// The least that all joints draw at prices of instants that sum to one \[W\].
    fn least_power_at(&self, price: &Price, limit: f64) -> f64 {
        let rows = price.of_power();
        let rows: Vec<(&Shared, f64)> = rows.iter().map(|(row, price)| (row, *price)).collect();
        // What the budget is worth at them is the budget.
        dual::bounded(&Apart { drawing: true, ..self.apart(&[], limit) }, &rows).1 + limit
    }

    fn apart<'d>(&'d self, gentlest: &'d [f64], limit: f64) -> Apart<'d> {
        Apart {
            program: self,
            programs: self.parts.iter().map(Part::program).collect(),
            gentlest,
            limit,
            drawing: false,
        }
    }

    /// The best ratios by prices alone, from some that keep the limit on power, whatever comes back.
    fn by_prices(&self, own: &[f64], gentlest: &[f64], limit: f64) -> Solved {
        let whatever = Program { returned: None, ..*self };
        let apart = whatever.apart(gentlest, limit);
        let priced = dual::solve(&apart, &[gentlest.to_vec(), own.to_vec()], self.threshold);
        let free = self.parts.iter().map(Part::least).sum::<f64>();
        let lower = priced.lower.max(free).min(priced.value);
        Solved { ratios: priced.ratios, value: priced.value, lower, price: Price::of(priced.rows) }
    }

    /// Find the best ratios under a limit on returned power, from the best without that limit: by prices and, where these leave a gap, by
    /// tangents. Returned power is concave in the ratios, so that its tangents at ratios that keep the limit bound a convex part of those
    /// that do: the best of that part is the next iterate. The bound is that of the limit itself at the multipliers.
    fn best_returning(&self, own: &[f64], gentlest: &[f64], free: Solved, limit: f64) -> Outcome {
        let total = |ratios: &[f64]| self.parts.iter().zip(ratios).map(|(p, n)| p.value(*n)).sum::<f64>();
        let Solved { ratios: start, lower: mut bound, mut price, .. } = free;
        let Some(mut at) = [start.as_slice(), gentlest].into_iter().find_map(|start| self.returning(start, limit))
        else {
            return Outcome::Solved(Solved { ratios: gentlest.to_vec(), value: f64::INFINITY, lower: bound, price });
        };
        let mut best = total(&at);
        // The convex relaxation may be loose: prices alone give a tighter bound.
        let apart = self.apart(&at, limit);
        let priced = dual::solve(&apart, &[at.clone(), start], self.threshold);
        if priced.value < best {
            (best, at) = (priced.value, priced.ratios);
        }
        bound = bound.max(priced.lower).min(best);
        let solved = Solved { ratios: at.clone(), value: best, lower: bound, price: price.clone() };
        if !solved.is_open() || bound >= self.threshold {
            return Outcome::Solved(solved);
        }
        let mut stalled = 0;
        let mut instants: Vec<Places> = self.beyond(own).into_iter().collect();
        let mut cuts: Vec<Cut> = Vec::new();
        for (j, part) in self.parts.iter().enumerate().filter(|(_, p)| p.moves()) {
            cuts.extend([part.ratios.0, part.ratios.1].map(|n| part.epigraph(j, n)));
        }
        self.add_objective(&mut cuts, own);
        self.add_objective(&mut cuts, &at);
        for _ in 0..ROUNDS {
            let valid = cuts.len();
            cuts.extend(instants.iter().map(|places| self.returned_row(places, &at)));
            let proposed = self.propose(&cuts, self.parts.len());
            let lower = proposed.as_ref().map_or(f64::NEG_INFINITY, |(_, multipliers)| self.bound(&cuts, multipliers));
            let better_bound = lower > bound + 1e-10 * lower.abs();
            if lower > bound {
                bound = lower;
                price = proposed.as_ref().map_or_else(Price::default, |(_, multipliers)| prices(&cuts, multipliers));
            }
            cuts.truncate(valid);
            let Some((next, _)) = proposed else { break };
            let (power, places) = self.power(&next, limit);
            if power > limit {
                cuts.push(self.row(&places, &next, None, limit));
            }
            let beyond = self.beyond(&next);
            let new = beyond.filter(|places| !instants.contains(places));
            if new.as_ref().is_some_and(|places| self.comes_back(places)) {
                return Outcome::ComesBack;
            }
            self.add_objective(&mut cuts, &next);
            let kept = self.returning(&self.kept(&next, power, gentlest, limit), limit);
            let value = kept.as_ref().map_or(f64::INFINITY, |kept| total(kept));
            let better = value < best * (1.0 - 1e-12 * best.signum());
            if let Some(kept) = kept.filter(|_| value < best) {
                (best, at) = (value, kept);
            }
            stalled = if better || better_bound || new.is_some() { 0 } else { stalled + 1 };
            instants.extend(new);
            if best - bound <= 1e-9 * best.abs() || bound >= self.threshold || stalled >= STALLED {
                break;
            }
        }
        Outcome::Solved(Solved { ratios: at, value: best, lower: bound.min(best), price })
    }

    fn add_objective(&self, cuts: &mut Vec<Cut>, ratios: &[f64]) {
        for (j, part) in self.parts.iter().enumerate().filter(|(_, p)| p.moves()) {
            let cut = part.epigraph(j, ratios[j]);
            if !cuts.iter().any(|c| c.epigraph == Some(j) && c.parts[0].convex == cut.parts[0].convex) {
                cuts.push(cut);
            }
        }
    }

    /// The ratios themselves where they keep the limit, else the nearest that do on the way to the gentlest.
    fn kept(&self, ratios: &[f64], power: f64, gentlest: &[f64], limit: f64) -> Vec<f64> {
        if power <= limit * (1.0 + POWER_TOLERANCE) {
            return ratios.to_vec();
        }
        let tolerance = POWER_TOLERANCE * limit;
        let excess = |share: f64| self.power(&self.between(ratios, gentlest, share), limit).0 - limit;
        // The power is nearly convex on the way: a chord ends where it is kept.
        let (mut bad, mut good) = ((0.0, power - limit), (1.0, excess(1.0)));
        for _ in 0..STEPS {
            if good.1 >= -tolerance || good.0 - bad.0 <= f64::EPSILON {
                break;
            }
            let share = (bad.0 + (good.0 - bad.0) * bad.1 / (bad.1 - good.1)).clamp(bad.0, good.0);
            let here = (share, excess(share));
            if here.1 <= tolerance {
                // The end that stays counts half, so that it does not stay for long.
                (good, bad.1) = (here, 0.5 * bad.1);
            } else {
                bad = here;
            }
        }
        if good.0 == 1.0 { gentlest.to_vec() } else { self.between(ratios, gentlest, good.0) }
    }

    /// Ratios on the way from some to others, in u = N².
    fn between(&self, from: &[f64], to: &[f64], share: f64) -> Vec<f64> {
        let u = from.iter().zip(to).map(|(a, b)| (a * a * (1.0 - share) + b * b * share).sqrt());
        u.zip(self.parts).map(|(n, p)| n.clamp(p.ratios.0, p.ratios.1)).collect()
    }

    /// For multipliers that sum to one over each epigraph: the least value of all joints together.
    fn bound(&self, cuts: &[Cut], multipliers: &[f64]) -> f64 {
        let epigraphs = cuts.iter().filter_map(|c| c.epigraph).max().map_or(0, |e| e + 1);
        let mut totals = vec![0.0; epigraphs];
        for (cut, m) in cuts.iter().zip(multipliers) {
            if let Some(e) = cut.epigraph {
                totals[e] += m.max(0.0);
            }
        }
        let mut sums = vec![Laurent::default(); self.parts.len()];
        let mut priced: Vec<Vec<(usize, f64)>> = vec![Vec::new(); self.parts.len()];
        let mut constant = 0.0;
        for (cut, m) in cuts.iter().zip(multipliers) {
            let share = match cut.epigraph {
                Some(e) if totals[e] > 0.0 => m.max(0.0) / totals[e],
                Some(_) => 0.0,
                None => {
                    constant -= m.max(0.0) * cut.most;
                    m.max(0.0)
                }
            };
            match cut.returned.is_empty() {
                true => {
                    cut.parts.iter().for_each(|of| sums[of.joint] = sums[of.joint] + of.polynomial * share);
                }
                false if share > 0.0 => {
                    cut.returned.iter().for_each(|(j, sample, weight)| priced[*j].push((*sample, share * weight)));
                }
                false => {}
            }
        }
        let sole = epigraphs == 1 && cuts.iter().all(|c| c.epigraph.is_some());
        for (j, (part, sum)) in self.parts.iter().zip(&sums).enumerate() {
            constant += match priced[j].is_empty() {
                true => least_over(sum, part.ratios),
                false => self.least_with_returned(j, sum, &priced[j]),
            };
            // What does not move has no cuts: its objective is what it is.
            if !sole && !part.moves() {
                constant += part.scale * part.lower;
            }
        }
        constant - 1e-14 * constant.abs()
    }

    /// Solves the program with the cuts so far; gives ratios and the multiplier of each cut.
    fn propose(&self, cuts: &[Cut], epigraphs: usize) -> Option<(Vec<f64>, Vec<f64>)> {
        let joints = self.parts.len();
        let middle: Vec<f64> = self.parts.iter().map(|p| p.ratios.0 * p.ratios.1).collect();
        let width = 3 * joints + epigraphs;
        let mut size = 0.0_f64;
        let scaled = |j: usize, c: &Convex| [c[0] / middle[j], c[1], c[2] * middle[j], c[3] * middle[j] * middle[j]];
        for cut in cuts.iter().filter(|c| c.epigraph.is_some()) {
            let of = |share: &Share| scaled(share.joint, &share.convex).iter().map(|x| x.abs()).sum::<f64>();
            let here: f64 = cut.parts.iter().map(of).sum();
            size = size.max(here);
        }
        let reference = if size > 0.0 { size } else { 1.0 };
        let (mut a, mut b, mut norms): (Vec<Vec<f64>>, Vec<f64>, Vec<f64>) = Default::default();
        for cut in cuts {
            let mut line = vec![0.0; width];
            let mut right = cut.most;
            if cut.epigraph.is_some() {
                right = 0.0;
            }
            for Share { joint: j, convex, .. } in &cut.parts {
                if !self.parts[*j].moves() {
                    right -= value(convex, middle[*j]);
                    continue;
                }
                let c = scaled(*j, convex);
                line[3 * j] = c[2];
                line[3 * j + 1] = c[0];
                line[3 * j + 2] = c[3];
                right -= c[1];
            }
            if let Some(e) = cut.epigraph {
                line[3 * joints + e] = -reference;
            }
            let norm = line.iter().map(|x| x * x).sum::<f64>().sqrt();
            let norm = if norm > 0.0 { norm } else { 1.0 };
            a.push(line.iter().map(|x| x / norm).collect());
            b.push(right / norm);
            norms.push(norm);
        }
        let unit = |at: usize, value: f64| {
            let mut line = vec![0.0; width];
            line[at] = value;
            line
        };
        for (j, part) in self.parts.iter().enumerate() {
            let ends = match part.moves() {
                true => [part.ratios.1.powi(2) / middle[j], -part.ratios.0.powi(2) / middle[j]],
                // Held between numbers that leave the solver room; no cut reads it.
                false => [2.0, -0.5],
            };
            a.push(unit(3 * j, 1.0));
            b.push(ends[0]);
            a.push(unit(3 * j, -1.0));
            b.push(ends[1]);
        }
        let with_cut = |e: usize| cuts.iter().any(|c| c.epigraph == Some(e));
        // An epigraph without a cut has nothing to rest on.
        for e in (0..epigraphs).filter(|e| !with_cut(*e)) {
            a.push(unit(3 * joints + e, -1.0));
            b.push(0.0);
        }
        let mut cones = vec![SupportedConeT::NonnegativeConeT(a.len())];
        for j in 0..joints {
            // u w ≥ 1, then t ≥ u².
            let two = |x: f64, y: f64| {
                let mut line = unit(3 * j, x);
                line[3 * j + 1] = y;
                line
            };
            a.extend([two(-1.0, -1.0), two(-1.0, 1.0), vec![0.0; width]]);
            b.extend([0.0, 0.0, 2.0]);
            a.extend([unit(3 * j + 2, -1.0), unit(3 * j + 2, -1.0), unit(3 * j, -2.0)]);
            b.extend([1.0, -1.0, 0.0]);
            cones.extend([SupportedConeT::SecondOrderConeT(3), SupportedConeT::SecondOrderConeT(3)]);
        }
        if a.iter().flatten().chain(&b).any(|x| !x.is_finite()) {
            return None;
        }
        let mut q = vec![0.0; width];
        q[3 * joints..].fill(1.0);
        // A breath of weight on what nothing holds keeps the solver's variables in place.
        q[..3 * joints].iter_mut().for_each(|x| *x = 1e-12);
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: 1e-11,
            tol_gap_rel: 1e-11,
            tol_feas: 1e-11,
            ..DefaultSettings::default()
        };
        let matrix = CscMatrix::from(&a);
        let p = CscMatrix::zeros((width, width));
        let mut solver = DefaultSolver::new(&p, &q, &matrix, &b, &cones, settings).ok()?;
        solver.solve();
        let solution = &solver.solution;
        self.work.count(solution.iterations as usize * (b.len() + width) / CONE);
        let usable = matches!(
            solution.status,
            SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress
        );
        if !usable || solution.x.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let ratio = |(j, part): (usize, &Part)| match part.moves() {
            true => (solution.x[3 * j] * middle[j]).max(0.0).sqrt().clamp(part.ratios.0, part.ratios.1),
            false => part.own,
        };
        let ratios = self.parts.iter().enumerate().map(ratio).collect();
        let multipliers = norms.iter().enumerate().map(|(i, norm)| solution.z[i] * reference / norm).collect();
        Some((ratios, multipliers))
    }
}

fn count(sum: &mut Option<Laurent>, more: Laurent, weight: f64) {
    *sum = Some(sum.unwrap_or_default() + more * weight);
}

fn prices(cuts: &[Cut], multipliers: &[f64]) -> Price {
    let rows = cuts.iter().zip(multipliers).filter(|(_, m)| **m > 0.0);
    let rows: Vec<(Places, f64)> = rows.filter_map(|(c, m)| Some((c.places.clone()?, *m))).collect();
    let most = rows.iter().map(|r| r.1).fold(0.0, f64::max);
    Price { rows: rows.into_iter().filter(|r| r.1 > 1e-6 * most).collect() }
}
