//! The best ratios of a combination by prices alone: with prices on what is shared the joints fall apart, and each is minimised over
//! its ratios in one dimension, whatever the shape of its functions.
//!
//! The one idea: ratios of each joint that were looked at are mixed so that the shared rows are kept; the multipliers of that linear
//! program are prices, at which each joint has a new best ratio (Dantzig and Wolfe). The bound is made of polynomials that are
//! nowhere above what they stand for, so it holds whatever the solver said.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::convex::lowest;
use gearwise_model::actuator::Laurent;

/// Rounds of new prices.
const ROUNDS: usize = 40;
/// Rows and columns of a linear program that take a step of [`Work`](super::work::Work) in each iteration, and steps that the best ratio of a
/// joint takes with each row.
const LINEAR: usize = 4;
const LOWEST: usize = 50;
/// Where value and bound are this near, they are one.
const CLOSED: f64 = 1e-9;
/// How far to both sides of a ratio the polynomials are taken that bound a joint there, where it may have a corner.
const ASIDE: f64 = 1e-7;

/// Joints that share rows, each a sum over joints that may be at most a limit.
pub(super) trait Separable {
    type Row: Clone + PartialEq;
    /// The ratios that each joint may have.
    fn ratios(&self) -> Vec<(f64, f64)>;
    /// A joint's share of the total.
    fn value(&self, joint: usize, ratio: f64) -> f64;
    /// A polynomial that touches it at a ratio and is nowhere above it.
    fn cut(&self, joint: usize, ratio: f64) -> Laurent;
    /// A joint's share of a row.
    fn drawn(&self, row: &Self::Row, joint: usize, ratio: f64) -> f64;
    /// A polynomial that touches it at a ratio and is nowhere above it; `None` where there is none that is.
    fn drawn_cut(&self, row: &Self::Row, joint: usize, ratio: f64) -> Option<Laurent>;
    /// What a row may be at most.
    fn limit(&self, row: &Self::Row) -> f64;
    /// The least of a polynomial and of those rows at their prices that have none, over a joint's ratios, from below.
    fn least(&self, joint: usize, polynomial: &Laurent, rows: &[(&Self::Row, f64)]) -> f64;
    /// Counts steps of [`Work`](super::work::Work).
    fn count(&self, steps: usize);
    /// Ratios near some that keep all rows, and the row that these break most, where they break one.
    fn kept(&self, ratios: &[f64]) -> (Vec<f64>, Option<Self::Row>);
}

/// What came of it.
#[derive(Debug)]
pub(super) struct Priced<R> {
    pub ratios: Vec<f64>,
    pub value: f64,
    pub lower: f64,
    pub rows: Vec<(R, f64)>,
}

/// The best ratios that keep all rows, from some of which the first keep them; what is not below a threshold is not told from it.
pub(super) fn solve<S: Separable>(of: &S, start: &[Vec<f64>], threshold: f64) -> Priced<S::Row> {
    let ranges = of.ratios();
    let n = ranges.len();
    let total = |ratios: &[f64]| ratios.iter().enumerate().map(|(j, n)| of.value(j, *n)).sum::<f64>();
    let mut rows = Vec::new();
    let mut columns: Vec<Vec<f64>> = ranges.iter().map(|(a, b)| if a < b { vec![*a, *b] } else { vec![*a] }).collect();
    let mut best = Priced { ratios: Vec::new(), value: f64::INFINITY, lower: f64::NEG_INFINITY, rows: Vec::new() };
    let look = |ratios: &[f64], best: &mut Priced<S::Row>, rows: &mut Vec<S::Row>| {
        let (kept, broken) = of.kept(ratios);
        let value = total(&kept);
        if value < best.value {
            (best.value, best.ratios) = (value, kept);
        }
        let new = broken.filter(|row| !rows.contains(row));
        let is_new = new.is_some();
        rows.extend(new);
        is_new
    };
    for ratios in start {
        look(ratios, &mut best, &mut rows);
        columns.iter_mut().zip(ratios).for_each(|(column, ratio)| {
            include(column, *ratio);
        });
    }
    let mut looked = Looked::default();
    for _ in 0..ROUNDS {
        looked.at(of, &columns, &rows);
        let Some((shares, prices)) = mixed(of, &columns, &rows, &looked) else { break };
        let priced = rows.iter().zip(&prices).map(|(row, price)| (row, *price)).filter(|priced| priced.1 > 0.0);
        let priced: Vec<(&S::Row, f64)> = priced.collect();
        let (at, lower) = bounded(of, &priced);
        if lower > best.lower {
            best.lower = lower;
            best.rows = priced.iter().map(|(row, price)| ((*row).clone(), *price)).collect();
        }
        let mean = |j: usize| shares[j].iter().zip(&columns[j]).map(|(share, ratio)| share * ratio).sum::<f64>();
        let mean: Vec<f64> = (0..n).map(|j| mean(j).clamp(ranges[j].0, ranges[j].1)).collect();
        let before = rows.len();
        look(&at, &mut best, &mut rows);
        look(&mean, &mut best, &mut rows);
        if best.value - best.lower <= CLOSED * best.value.abs() || best.lower >= threshold {
            break;
        }
        let mut new = rows.len() > before;
        for j in 0..n {
            for ratio in [at[j], mean[j]] {
                new |= include(&mut columns[j], ratio);
            }
        }
        if !new {
            break;
        }
    }
    best.lower = best.lower.min(best.value);
    best
}

/// The best ratios at prices, each joint for itself, and the bound of all ratios that they show.
pub(super) fn bounded<S: Separable>(of: &S, priced: &[(&S::Row, f64)]) -> (Vec<f64>, f64) {
    let of_joint = |(joint, range): (usize, &(f64, f64))| {
        let sum = Sum { of, joint, priced };
        let beside = |n: f64| sum.beside(n);
        let at = lowest(*range, |n| sum.cut(n), sum.is_bent().then_some(&beside), |n| sum.value(n));
        (at, sum.bound(at, *range))
    };
    of.count(of.ratios().len() * (1 + priced.len()) * LOWEST);
    let (at, bounds): (Vec<f64>, Vec<f64>) = of.ratios().iter().enumerate().map(of_joint).unzip();
    let bound = bounds.iter().sum::<f64>();
    let worth = priced.iter().map(|(row, price)| price * of.limit(row)).sum::<f64>();
    (at, bound - worth - 1e-14 * (bound.abs() + worth.abs()))
}

/// Takes a ratio in, unless it is there; whether it was taken.
fn include(column: &mut Vec<f64>, ratio: f64) -> bool {
    let new = column.iter().all(|known| (ratio / known - 1.0).abs() > 1e-12);
    if new {
        column.push(ratio);
    }
    new
}

/// A joint's share of everything at prices.
struct Sum<'s, S: Separable> {
    of: &'s S,
    joint: usize,
    priced: &'s [(&'s S::Row, f64)],
}

impl<S: Separable> Sum<'_, S> {
    fn value(&self, ratio: f64) -> f64 {
        let rows = self.priced.iter().map(|(row, price)| price * self.of.drawn(row, self.joint, ratio));
        self.of.value(self.joint, ratio) + rows.sum::<f64>()
    }

    fn cut(&self, ratio: f64) -> Laurent {
        let row = |(row, price): &(&S::Row, f64)| Some(self.of.drawn_cut(row, self.joint, ratio)? * *price);
        self.priced.iter().filter_map(row).fold(self.of.cut(self.joint, ratio), |sum, row| sum + row)
    }

    /// Whether some row has no polynomial below it.
    fn is_bent(&self) -> bool {
        self.priced.iter().any(|(row, _)| self.of.drawn_cut(row, self.joint, 1.0).is_none())
    }

    /// The rows that have none, at their prices.
    fn beside(&self, ratio: f64) -> f64 {
        let bent = self.priced.iter().filter(|(row, _)| self.of.drawn_cut(row, self.joint, ratio).is_none());
        bent.map(|(row, price)| price * self.of.drawn(row, self.joint, ratio)).sum()
    }

    /// A bound of it between two ratios, made at its best.
    fn bound(&self, at: f64, (a, b): (f64, f64)) -> f64 {
        let cut = self.cut(at);
        let least = |polynomial: &Laurent| self.of.least(self.joint, polynomial, self.priced);
        let here = least(&cut);
        let (below, above) = (at * (1.0 - ASIDE), at * (1.0 + ASIDE));
        if below <= a || above >= b || cut.at(at) + self.beside(at) - here <= CLOSED * here.abs() {
            return here;
        }
        // At a corner the polynomials of both sides are mixed so that they have no slope.
        let sides = [below, above].map(|n| self.cut(n));
        let bent = (self.beside(above) - self.beside(below)) / (above - below);
        let slopes = sides.map(|side| side.slope(at) + bent);
        let share = if slopes[0] < 0.0 && slopes[1] > 0.0 { slopes[1] / (slopes[1] - slopes[0]) } else { 0.5 };
        here.max(least(&(sides[0] * share + sides[1] * (1.0 - share))))
    }
}

/// Values and rows at the ratios that were looked at, each computed once.
#[derive(Default)]
struct Looked {
    /// The value at each ratio of each joint.
    values: Vec<Vec<f64>>,
    /// For each row the same.
    drawn: Vec<Vec<Vec<f64>>>,
}

impl Looked {
    /// Takes in the ratios and rows that are new; they are only ever appended.
    fn at<S: Separable>(&mut self, of: &S, columns: &[Vec<f64>], rows: &[S::Row]) {
        let complete = |known: &mut Vec<Vec<f64>>, value: &dyn Fn(usize, f64) -> f64| {
            known.resize(columns.len(), Vec::new());
            for (j, (known, column)) in known.iter_mut().zip(columns).enumerate() {
                let new = known.len();
                known.extend(column[new..].iter().map(|ratio| value(j, *ratio)));
            }
        };
        complete(&mut self.values, &|j, ratio| of.value(j, ratio));
        self.drawn.resize(rows.len(), Vec::new());
        for (known, row) in self.drawn.iter_mut().zip(rows) {
            complete(known, &|j, ratio| of.drawn(row, j, ratio));
        }
    }
}

/// The cheapest mixture of known ratios that keeps the rows, and the price of each row.
fn mixed<S: Separable>(
    of: &S,
    columns: &[Vec<f64>],
    rows: &[S::Row],
    looked: &Looked,
) -> Option<(Vec<Vec<f64>>, Vec<f64>)> {
    let all: Vec<(usize, f64)> =
        columns.iter().enumerate().flat_map(|(j, column)| column.iter().map(move |n| (j, *n))).collect();
    let (joints, width) = (columns.len(), all.len());
    let costs: Vec<f64> = looked.values.iter().flatten().copied().collect();
    let size = costs.iter().map(|c| c.abs()).fold(f64::MIN_POSITIVE, f64::max);
    let mut a: Vec<Vec<f64>> = (0..joints).map(|j| all.iter().map(|(k, _)| f64::from(*k == j)).collect()).collect();
    let mut b = vec![1.0; joints];
    let mut sizes = Vec::new();
    for (row, drawn) in rows.iter().zip(&looked.drawn) {
        let drawn: Vec<f64> = drawn.iter().flatten().copied().collect();
        let size = drawn.iter().fold(of.limit(row).abs().max(f64::MIN_POSITIVE), |most, drawn| most.max(drawn.abs()));
        a.push(drawn.iter().map(|drawn| drawn / size).collect());
        b.push(of.limit(row) / size);
        sizes.push(size);
    }
    for k in 0..width {
        let mut line = vec![0.0; width];
        line[k] = -1.0;
        a.push(line);
        b.push(0.0);
    }
    if a.iter().flatten().chain(&costs).any(|x| !x.is_finite()) {
        return None;
    }
    let q: Vec<f64> = costs.iter().map(|c| c / size).collect();
    let cones = [SupportedConeT::ZeroConeT(joints), SupportedConeT::NonnegativeConeT(rows.len() + width)];
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-12,
        tol_gap_rel: 1e-12,
        tol_feas: 1e-12,
        ..DefaultSettings::default()
    };
    let mut solver =
        DefaultSolver::new(&CscMatrix::zeros((width, width)), &q, &CscMatrix::from(&a), &b, &cones, settings).ok()?;
    solver.solve();
    let solution = &solver.solution;
    of.count(solution.iterations as usize * (b.len() + width) / LINEAR);
    let usable = matches!(
        solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress
    );
    if !usable || solution.x.iter().chain(&solution.z).any(|x| !x.is_finite()) {
        return None;
    }
    let mut shares = columns.iter().map(|_| Vec::new()).collect::<Vec<Vec<f64>>>();
    all.iter().zip(&solution.x).for_each(|((j, _), share)| shares[*j].push(share.max(0.0)));
    for shares in &mut shares {
        let sum = shares.iter().sum::<f64>();
        shares.iter_mut().for_each(|share| *share /= sum);
    }
    let of_rows = &solution.z[joints..joints + rows.len()];
    let prices: Vec<f64> = of_rows.iter().zip(&sizes).map(|(price, of)| price.max(0.0) * size / of).collect();
    // What is as good as nothing is nothing.
    let most = prices.iter().copied().fold(0.0, f64::max);
    Some((shares, prices.into_iter().map(|price| if price > 1e-9 * most { price } else { 0.0 }).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::convex::least_over;
    use gearwise_model::numerics::line_search::least_in_range;

    /// Joints `a/N² + b N² + c N` that draw `d N` each: not convex in N², and one with a corner.
    struct Toy {
        limit: f64,
    }

    impl Toy {
        fn drawn_in_all(&self, ratios: &[f64]) -> f64 {
            (0..3).map(|j| self.drawn(&0, j, ratios[j])).sum()
        }
    }

    impl Separable for Toy {
        type Row = usize;

        fn ratios(&self) -> Vec<(f64, f64)> {
            vec![(1.0, 20.0), (1.0, 20.0), (4.0, 4.0)]
        }

        fn value(&self, joint: usize, ratio: f64) -> f64 {
            let corner = if joint == 0 { (ratio - 6.0).max(0.0) } else { 0.0 };
            800.0 / ratio.powi(2) + 0.1 * ratio.powi(2) + ratio + corner
        }

        fn cut(&self, joint: usize, ratio: f64) -> Laurent {
            let smooth = Laurent::monomial(800.0, -2) + Laurent::of_terms(0.0, 0.0, 1.0) + Laurent::monomial(0.1, 2);
            match joint == 0 && ratio > 6.0 {
                true => smooth + Laurent::of_terms(0.0, -6.0, 1.0),
                false => smooth,
            }
        }

        fn drawn(&self, _: &usize, joint: usize, ratio: f64) -> f64 {
            (2.0 + joint as f64) * ratio
        }

        fn drawn_cut(&self, _: &usize, joint: usize, _: f64) -> Option<Laurent> {
            Some(Laurent::of_terms(0.0, 0.0, 2.0 + joint as f64))
        }

        fn limit(&self, _: &usize) -> f64 {
            self.limit
        }

        fn least(&self, joint: usize, polynomial: &Laurent, _: &[(&usize, f64)]) -> f64 {
            least_over(polynomial, self.ratios()[joint])
        }

        fn count(&self, _: usize) {}

        fn kept(&self, ratios: &[f64]) -> (Vec<f64>, Option<usize>) {
            if self.drawn_in_all(ratios) <= self.limit * (1.0 + 1e-12) {
                return (ratios.to_vec(), None);
            }
            let least = [1.0, 1.0, 4.0];
            let (low, high) = (self.drawn_in_all(&least), self.drawn_in_all(ratios));
            let share = (self.limit - low) / (high - low);
            (least.iter().zip(ratios).map(|(a, b)| a + share * (b - a)).collect(), Some(0))
        }
    }

    #[test]
    fn value_and_bound_meet_where_joints_share_a_row() {
        for limit in [32.0, 36.0, 44.0, 50.0, 80.0] {
            let toy = Toy { limit };
            let found = solve(&toy, &[vec![1.0, 1.0, 4.0]], f64::INFINITY);
            assert!(toy.drawn_in_all(&found.ratios) <= limit * (1.0 + 1e-9));
            assert!(
                found.value - found.lower <= 1e-8 * found.value && found.lower <= found.value,
                "{limit}: {found:?}"
            );
            // No ratios on a fine grid are better.
            let grid = (0..=1900).map(|k| 1.0 + 0.01 * f64::from(k));
            let of = |n: f64| {
                let left = ((limit - 16.0 - 2.0 * n) / 3.0).min(20.0);
                let free = least_in_range(&|m| toy.value(1, m), 1.0, 20.0);
                (left >= 1.0).then(|| toy.value(0, n) + toy.value(1, free.min(left)) + toy.value(2, 4.0))
            };
            let least = grid.filter_map(of).fold(f64::INFINITY, f64::min);
            assert!(found.lower <= least && found.value <= least + 1e-9, "{limit}: {found:?} {least}");
        }
    }
}
