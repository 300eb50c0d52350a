//! Branch and bound over regions of ratios and springs. Where the program is convex the first region is
//! already the whole answer; else regions are halved until the bounds meet.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::conic::{self, Answer, IMPOSSIBLE, Row};
use super::form::{Form, Point};
use super::problem::{Key, Look, Problem};
use super::region::Region;
use crate::program::GAP_TOLERANCE;
use gearwise_model::requirement::Spring;

/// More regions than this are not looked at; what is left then is reported as a gap.
const MAX_REGIONS: usize = 4000;
/// Rounds of adding rows and cuts: on the first region, and on its parts.
const ROUNDS: [usize; 2] = [40, 6];
/// A limit is kept where its excess is no more.
const KEPT: f64 = 1e-10;
/// A row that is exceeded by more is added.
const EXCEEDED: f64 = 1e-9;
/// Shares of the whole region that a feasible point is refined on.
const REFINEMENTS: [f64; 8] = [0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 1e-4, 1e-5];

/// What a region came to.
enum Found {
    /// It holds nothing feasible.
    Nothing,
    /// A lower bound of the objective on it, where its program is least, and the limits that count.
    Bounded { bound: f64, z: Point, keys: Vec<Key> },
}

/// A region on the heap.
struct Node {
    region: Region,
    bound: f64,
    z: Point,
    keys: Vec<Key>,
    /// The order in which regions were made: ties are broken by it.
    number: usize,
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Node {}

impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Node {
    /// The heap gives the least bound first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.number.cmp(&self.number))
    }
}

/// What the search found.
pub(super) struct Verdict {
    /// The best feasible point and its value, in the unit of the cuts.
    pub(super) best: Option<(f64, Point)>,
    /// No feasible point is better.
    pub(super) bound: f64,
    /// What rounding can do to values of this size.
    pub(super) size: f64,
    /// Where nothing feasible was found: the point that comes nearest.
    pub(super) nearest: Point,
    /// Whether everything was ruled out.
    pub(super) impossible: bool,
}

pub(super) struct Search<'p, 'a> {
    problem: &'p Problem<'a>,
    spring: &'p Spring,
    whole: Region,
    exact: bool,
    best: Option<(f64, Point)>,
    nearest: Option<(f64, Point)>,
    size: f64,
}

/// Searches a region; `pieces` are ratios at which the objective steps.
pub(super) fn search(problem: &Problem, spring: &Spring, whole: Region, pieces: &[f64]) -> Verdict {
    let exact = problem.why_not_convex().is_none();
    let mut search = Search { problem, spring, whole: whole.clone(), exact, best: None, nearest: None, size: 0.0 };
    let (bound, impossible) = search.run(pieces);
    Verdict {
        best: search.best,
        bound,
        size: search.size,
        nearest: search.nearest.map_or(whole.middle(), |n| n.1),
        impossible: impossible && search.best.is_none(),
    }
}

impl Search<'_, '_> {
    fn run(&mut self, pieces: &[f64]) -> (f64, bool) {
        let mut heap = BinaryHeap::new();
        let mut number = 0;
        let mut settled = f64::INFINITY;
        let mut start = self.whole.ratio[0];
        for end in pieces.iter().copied().chain([self.whole.ratio[1]]) {
            let region = Region { ratio: [start, end], ..self.whole.clone() };
            start = end;
            if let Found::Bounded { bound, z, keys } = self.region(&region, &[], ROUNDS[0]) {
                self.refine(&region, z);
                if !self.exact && self.best.is_none() {
                    self.refine(&region, region.middle());
                }
                heap.push(Node { region, bound, z, keys, number });
                number += 1;
            }
        }
        let mut next_refinement = 8;
        for count in 0..MAX_REGIONS {
            if self.problem.is_stopped() {
                break;
            }
            let Some(node) = heap.pop() else {
                return (settled, settled == f64::INFINITY);
            };
            if node.bound >= self.target() {
                return (settled.min(node.bound), false);
            }
            let Some(parts) = self.parts(&node) else {
                settled = settled.min(node.bound);
                continue;
            };
            for region in parts {
                let Found::Bounded { bound, z, keys } = self.region(&region, &node.keys, ROUNDS[1]) else { continue };
                let bound = bound.max(node.bound);
                if bound >= self.target() {
                    settled = settled.min(bound);
                    continue;
                }
                if count >= next_refinement {
                    self.refine(&region, z);
                    next_refinement = count + count / 4 + 8;
                }
                heap.push(Node { region, bound, z, keys, number });
                number += 1;
            }
        }
        let left = heap.peek().map_or(f64::INFINITY, |n| n.bound);
        (settled.min(left), false)
    }

    /// The value from which on a region is of no interest.
    fn target(&self) -> f64 {
        self.best.map_or(f64::INFINITY, |(value, _)| value - 0.5 * GAP_TOLERANCE * value.abs().max(1e-6 * self.size))
    }

    fn offer(&mut self, z: Point, look: &Look) {
        if look.excess <= KEPT && look.value.is_finite() && self.best.is_none_or(|(best, _)| look.value < best) {
            self.best = Some((look.value, z));
        }
        if self.nearest.is_none_or(|(least, _)| look.excess < least) {
            self.nearest = Some((look.excess, z));
        }
    }

    /// Bounds the objective on a region.
    fn region(&mut self, region: &Region, inherited: &[Key], rounds: usize) -> Found {
        let mut z = region.middle();
        let mut look = self.problem.look(z);
        self.offer(z, &look);
        let mut cuts = vec![self.problem.cut(region, z, &look)];
        self.size = self.size.max(cuts[0].size(z) * f64::from(self.size == 0.0));
        let mut rows: Vec<(Key, Row)> = Vec::new();
        for key in inherited {
            rows.extend(self.problem.row(*key, region, z).map(|row| (*key, row)));
        }
        let mut bound = f64::NEG_INFINITY;
        let mut keys = Vec::new();
        for _ in 0..rounds {
            let plain: Vec<Row> = rows.iter().map(|r| r.1).collect();
            match conic::propose(region, &cuts, &plain) {
                Answer::Found(proposal) => {
                    z = self.problem.allowed(self.spring, proposal.z);
                    if proposal.bound > bound {
                        bound = proposal.bound;
                        let active = rows.iter().zip(&proposal.active).filter(|(_, active)| **active);
                        keys = active.map(|(row, _)| row.0).filter(|k| self.problem.can_be_inherited(*k)).collect();
                        keys.dedup();
                    }
                }
                Answer::Impossible => return Found::Nothing,
                Answer::Unknown => match nearest(region, &plain) {
                    Some((least, _)) if least > IMPOSSIBLE => return Found::Nothing,
                    Some((_, nearest)) => z = self.problem.allowed(self.spring, nearest),
                    None => break,
                },
            }
            if bound >= self.target() {
                break;
            }
            look = self.problem.look(z);
            self.offer(z, &look);
            let mut added = false;
            for (_, key) in look.limits.iter().filter(|l| l.0 > EXCEEDED) {
                let Some(row) = self.problem.row(*key, region, z) else { continue };
                let over = crate::evaluate::violation(row.form.at(z), row.bound);
                if over > EXCEEDED && !rows.iter().any(|r| r.1 == row) {
                    rows.push((*key, row));
                    added = true;
                }
            }
            let cut = self.problem.cut(region, z, &look);
            let known = cuts.iter().map(|c| c.at(z)).fold(f64::NEG_INFINITY, f64::max);
            let here = cut.at(z);
            if here > known + 1e-10 * known.abs().max(1e-6 * cut.size(z)) && !cuts.contains(&cut) {
                cuts.push(cut);
                added = true;
            }
            if !added {
                break;
            }
        }
        Found::Bounded { bound, z, keys }
    }

    /// Refines a point on ever smaller regions around it, on which bounds are ever nearer to the truth.
    fn refine(&mut self, within: &Region, z: Point) {
        let mut z = self.best.filter(|(_, best)| within.contains(*best)).map_or(z, |b| b.1);
        for share in REFINEMENTS {
            let Some(around) = self.around(within, z, share) else { continue };
            let before = self.best;
            let Found::Bounded { z: found, bound, .. } = self.refined(&around) else { continue };
            if let (Some((old, _)), Some((new, _))) = (before, self.best) {
                // No better point is near it.
                let little = 0.1 * GAP_TOLERANCE * new.abs().max(1e-6 * self.size);
                if new - bound <= little && old - new <= 1e-3 * little {
                    break;
                }
            }
            z = match (before, self.best) {
                (Some((old, _)), Some((new, best))) if new < old => best,
                (None, Some((_, best))) => best,
                _ => found,
            };
        }
    }

    /// A region's program without a target: the point is wanted, not the bound.
    fn refined(&mut self, region: &Region) -> Found {
        let best = self.best.take();
        let found = self.region(region, &[], 12);
        if let Some((value, _)) = best
            && self.best.is_none_or(|(new, _)| value <= new)
        {
            self.best = best;
        }
        found
    }

    /// The part of a region around a point, a share of the whole wide.
    fn around(&self, within: &Region, z: Point, share: f64) -> Option<Region> {
        let reach = |[a, b]: [f64; 2]| 0.5 * share * (b - a);
        let (n, k) = (z[0].sqrt(), z[1]);
        let spread = (self.whole.ratio[1] / self.whole.ratio[0]).powf(0.5 * share);
        let mut part = within.clone();
        part.ratio = [n / spread, n * spread].map(|n| n.clamp(within.ratio[0], within.ratio[1]));
        if self.whole.equations.len() == 2 {
            return Some(part);
        }
        let by_stiffness = reach(self.whole.stiffness());
        if by_stiffness > 0.0 {
            part = part.clip(&[by_stiffness - k, 1.0, 0.0])?.clip(&[by_stiffness + k, -1.0, 0.0])?;
        }
        let by_rest = reach(self.whole.rest());
        if by_rest > 0.0 && k > 0.0 {
            let rest = z[2] / k;
            part = part.clip(&[0.0, by_rest - rest, 1.0])?.clip(&[0.0, by_rest + rest, -1.0])?;
        }
        Some(part)
    }

    /// A region's parts: on either side of the line on which power changes its direction at a sample, where
    /// that is what the bound suffers from, else halved where it is widest. `None` where it is too narrow.
    fn parts(&mut self, node: &Node) -> Option<Vec<Region>> {
        let region = &node.region;
        if !self.exact {
            let look = self.problem.look(node.z);
            let gap = (self.target() - node.bound).max(0.0);
            let most = if gap.is_finite() { 0.05 * gap } else { 0.0 };
            if let Some((sample, e)) = self.problem.worst_open(region, node.z, &look, most) {
                return Some([true, false].into_iter().filter_map(|d| region.side(sample, &e, d)).collect());
            }
        }
        let [a, b] = region.ratio;
        let ([k0, k1], [q0, q1]) = (region.stiffness(), region.rest());
        let far = |[q0, q1]: [f64; 2]| q0.abs().max(q1.abs());
        let most = self.problem.spring_torque(self.whole.stiffness()[1], far(self.whole.rest()));
        let by_stiffness = self.problem.spring_torque(k1 - k0, far([q0, q1])) / most;
        let by_rest = k1 * (q1 - q0) / most;
        let by_ratio = (b / a).ln() * if self.problem.bends_in_ratio() { 1.0 } else { 0.02 };
        let widest = by_stiffness.max(by_rest).max(by_ratio);
        if widest.is_nan() || widest <= 1e-10 {
            return None;
        }
        let halves = if by_ratio == widest {
            let middle = (a * b).sqrt();
            let half = |ratio| Some(Region { ratio, ..region.clone() });
            [half([a, middle]), half([middle, b])]
        } else if by_stiffness == widest {
            let middle = 0.5 * (k0 + k1);
            [region.clip(&[middle, -1.0, 0.0]), region.clip(&[-middle, 1.0, 0.0])]
        } else {
            let middle = 0.5 * (q0 + q1);
            [region.clip(&[0.0, middle, -1.0]), region.clip(&[0.0, -middle, 1.0])]
        };
        Some(halves.into_iter().flatten().collect())
    }
}

/// The least excess over the rows that any point of the region has (a lower bound), and where.
fn nearest(region: &Region, rows: &[Row]) -> Option<(f64, Point)> {
    if rows.is_empty() {
        return None;
    }
    let excesses: Vec<Form> = rows
        .iter()
        .map(|row| {
            let size = row.size(region);
            let mut form = Form::default();
            form.add(1.0 / size, &row.form);
            form.add_constant(-row.bound / size);
            form
        })
        .collect();
    match conic::propose(region, &excesses, &[]) {
        Answer::Found(p) => Some((p.bound, p.z)),
        _ => None,
    }
}
