//! What lies between the points of a motor.
//!
//! The one idea: along a motor whose quantities are shown to fall and then to rise, the ratios at which none of them is above given
//! values are one interval, and the largest excess over those values has one valley. So it is decided, and not sampled, whether some
//! ratio of such a motor betters a point; and from the values at two neighbouring points follows a corner that nothing between them is
//! below.

use super::dominance::{are_covered, is_nowhere_above};
use crate::Prepared;
use crate::mount::Mount;
use crate::program::RatioProgram;
use gearwise_model::numerics::line_search::{FULLY, golden_section};
use gearwise_model::requirement::Objective;

/// What is better by less than this share in some quantity is as good.
pub const AS_GOOD: f64 = 1e-9;
/// How often a piece is halved in the search for a ratio that is not bettered.
const HALVINGS: u32 = 6;

/// A quantity along the ratios of a motor.
#[derive(Debug)]
pub(super) struct Valley {
    /// The ratios at which it is least.
    pub least: (f64, f64),
    /// What it is nowhere below.
    pub bound: f64,
    /// Whether it goes up in steps.
    pub steps: bool,
}

/// A point of a motor: its ratio and its values.
pub(super) type Node = (f64, Vec<f64>);

/// A motor whose efficient ratios are one interval, by its points.
#[derive(Debug)]
pub(super) struct Line<'a, 'p> {
    /// The motor at the joint.
    pub mount: Mount<'a, 'p>,
    /// Its equations and limits.
    pub prepared: Prepared<'p>,
    /// Its points, by their ratios.
    pub nodes: Vec<Node>,
    /// Of each quantity what it is nowhere below on each piece between two points, and the piece where that is least.
    floors: Vec<(Vec<f64>, usize)>,
    /// Of each quantity the ratios at which it is least, and its least value.
    valleys: Vec<Valley>,
}

impl<'a, 'p> Line<'a, 'p> {
    /// From at least two points in the order of their ratios.
    pub fn new(mount: Mount<'a, 'p>, prepared: Prepared<'p>, nodes: Vec<Node>, valleys: Vec<Valley>) -> Line<'a, 'p> {
        let floors = |(k, valley): (usize, &Valley)| {
            let at = |node: &Node| (node.0, node.1[k]);
            let floors: Vec<f64> = nodes.windows(2).map(|ends| floor(valley, at(&ends[0]), at(&ends[1]))).collect();
            let least = (0..floors.len()).min_by(|a, b| floors[*a].total_cmp(&floors[*b])).unwrap_or(0);
            (floors, least)
        };
        let floors = valleys.iter().enumerate().map(floors).collect();
        Line { mount, prepared, nodes, floors, valleys }
    }

    /// The quantities at any ratio of it.
    fn values<'s>(&'s self, objectives: &'s [Objective]) -> impl Fn(f64) -> Vec<f64> + 's {
        let (min, max) = (self.nodes[0].0, self.nodes[self.nodes.len() - 1].0);
        let programs: Vec<_> = objectives.iter().map(|o| RatioProgram::new(&self.prepared, o, min, max)).collect();
        move |ratio| programs.iter().map(|program| program.objective_at(ratio)).collect()
    }

    /// A ratio between two of its points at which every quantity that goes with the ratio is less than these values, and no other is more.
    pub fn better_than(&self, asked: &[f64], objectives: &[Objective]) -> Option<f64> {
        let pieces = self.pieces_below(asked)?;
        let values = self.values(objectives);
        pieces.into_iter().find_map(|piece| self.better_between(piece, asked, &values))
    }

    /// The pieces on which no quantity's floor is above a value.
    fn pieces_below(&self, asked: &[f64]) -> Option<std::ops::Range<usize>> {
        let mut pieces = 0..self.nodes.len() - 1;
        for ((floors, least), most) in self.floors.iter().zip(asked) {
            // They fall to the piece with the least of them and rise beyond it.
            if floors[*least] > *most {
                return None;
            }
            let first = floors[..*least].partition_point(|floor| floor > most);
            let last = least + floors[*least..].partition_point(|floor| floor <= most);
            pieces = pieces.start.max(first)..pieces.end.min(last);
        }
        (!pieces.is_empty()).then_some(pieces)
    }

    fn better_between(&self, piece: usize, asked: &[f64], values: &impl Fn(f64) -> Vec<f64>) -> Option<f64> {
        let [(from, first), (to, second)] = [&self.nodes[piece], &self.nodes[piece + 1]];
        // A quantity that steps has the value of the piece's end on all of it but its start, which is a point of its own.
        let is_fixed = |valley: &Valley| valley.steps || valley.least.0 <= *from && *to <= valley.least.1;
        let (fixed, free): (Vec<usize>, Vec<usize>) = (0..asked.len()).partition(|k| is_fixed(&self.valleys[*k]));
        if fixed.iter().any(|k| second[*k] > asked[*k] + AS_GOOD * asked[*k].abs()) {
            return None;
        }
        let size = |k: &usize| asked[*k].abs().max(first[*k].abs()).max(second[*k].abs()).max(f64::MIN_POSITIVE);
        let sizes: Vec<f64> = free.iter().map(size).collect();
        let excess = |ln: f64| {
            let here = values(ln.exp());
            let over = free.iter().zip(&sizes).map(|(k, size)| (here[*k] - asked[*k]) / size);
            over.fold(f64::NEG_INFINITY, f64::max)
        };
        let best = golden_section(&excess, from.ln(), to.ln(), FULLY);
        (excess(best) < -AS_GOOD).then(|| best.exp().clamp(*from, *to))
    }

    /// Ratios within pieces of which neither end is on the front that nothing on it (`on_front`, by its values) betters, one for each such
    /// piece, as far as halving shows them; `own` are the ratios of the motor that are on it, from the smallest.
    pub fn missing(&self, on_front: &[&[f64]], own: &[f64], objectives: &[Objective]) -> Vec<f64> {
        let is_on = |node: usize| own.binary_search_by(|ratio| ratio.total_cmp(&self.nodes[node].0)).is_ok();
        let pieces: Vec<usize> =
            (0..self.nodes.len() - 1).filter(|piece| !is_on(*piece) && !is_on(piece + 1)).collect();
        let corners: Vec<Vec<f64>> =
            pieces.iter().map(|piece| self.floors.iter().map(|(floors, _)| floors[*piece]).collect()).collect();
        let views: Vec<&[f64]> = corners.iter().map(Vec::as_slice).collect();
        let covered = are_covered(&views, on_front);
        let values = self.values(objectives);
        let uncovered = pieces.iter().zip(covered).filter(|(_, covered)| !covered);
        let within = |piece: usize| {
            let [a, b] = [piece, piece + 1].map(|k| (self.nodes[k].0, self.nodes[k].1.clone()));
            self.not_bettered((&a, &b), on_front, &values, HALVINGS)
        };
        uncovered.filter_map(|(piece, _)| within(*piece)).collect()
    }

    /// A ratio between two that nothing on the front betters.
    fn not_bettered(
        &self,
        (a, b): (&Node, &Node),
        on_front: &[&[f64]],
        values: &impl Fn(f64) -> Vec<f64>,
        halvings: u32,
    ) -> Option<f64> {
        let corner: Vec<f64> =
            self.valleys.iter().enumerate().map(|(k, v)| floor(v, (a.0, a.1[k]), (b.0, b.1[k]))).collect();
        let betters = |point: &[f64]| on_front.iter().any(|p| is_nowhere_above(p, point));
        if halvings == 0 || betters(&corner) {
            return None;
        }
        let ratio = (a.0 * b.0).sqrt();
        let middle = (ratio, values(ratio));
        if !betters(&middle.1) {
            return Some(ratio);
        }
        let search = |a, b| self.not_bettered((a, b), on_front, values, halvings - 1);
        search(a, &middle).or_else(|| search(&middle, b))
    }
}

/// What a quantity is nowhere below between two ratios, from its values there.
fn floor(valley: &Valley, (from, first): (f64, f64), (to, second): (f64, f64)) -> f64 {
    let holds_least = from <= valley.least.1 && valley.least.0 <= to;
    if holds_least { valley.bound.min(first).min(second) } else { first.min(second) }
}
