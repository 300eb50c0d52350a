//! Which points others better in every quantity: by division, in O(P (log P)^(n−1)) for P points of n quantities.
//!
//! The one idea: of points that are sorted by their first quantity the first half is nowhere above the second there. So each half is
//! looked at by itself, and between the halves one quantity fewer is left to compare; the same again along the next one.

/// Pairs of points that are compared one by one: fewer are not worth dividing.
const FEW: usize = 256;

/// Whether a point is nowhere above another.
pub(super) fn is_nowhere_above(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(a, b)| a <= b)
}

/// The places of the points of which no other is nowhere above them; of equal points the first by `order`, in that order. Values are
/// numbers.
pub(super) fn not_dominated(points: &[&[f64]], order: impl Fn(usize, usize) -> std::cmp::Ordering) -> Vec<usize> {
    let mut places: Vec<usize> = (0..points.len()).collect();
    places.sort_by(|a, b| lexicographic(points[*a], points[*b]).then_with(|| order(*a, *b)));
    let mut search = Search { points, covered: vec![false; points.len()] };
    search.within(&places, &|_| true, &|_| true);
    places.retain(|place| !search.covered[*place]);
    places
}

/// Of each point whether some other of `by` is nowhere above it. Values are numbers.
pub(super) fn are_covered(points: &[&[f64]], by: &[&[f64]]) -> Vec<bool> {
    // Of equal points those that cover come first.
    let all: Vec<&[f64]> = by.iter().chain(points).copied().collect();
    let mut places: Vec<usize> = (0..all.len()).collect();
    places.sort_by(|a, b| lexicographic(all[*a], all[*b]).then(a.cmp(b)));
    let mut search = Search { points: &all, covered: vec![false; all.len()] };
    search.within(&places, &|place| place < by.len(), &|place| place >= by.len());
    search.covered.split_off(by.len())
}

fn lexicographic(a: &[f64], b: &[f64]) -> std::cmp::Ordering {
    let differing = a.iter().zip(b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
    differing.unwrap_or(std::cmp::Ordering::Equal)
}

/// Whether a place takes part.
type Takes<'t> = &'t dyn Fn(usize) -> bool;

struct Search<'p> {
    points: &'p [&'p [f64]],
    covered: Vec<bool>,
}

impl Search<'_> {
    /// Marks what a place before it covers, of places that are sorted.
    fn within(&mut self, places: &[usize], covers: Takes, is_asked: Takes) {
        if places.len() < 2 {
            return;
        }
        let (first, second) = places.split_at(places.len() / 2);
        self.within(first, covers, is_asked);
        self.within(second, covers, is_asked);
        // What is covered itself is so by something that covers no less.
        let by: Vec<usize> = first.iter().copied().filter(|p| covers(*p) && !self.covered[*p]).collect();
        let of: Vec<usize> = second.iter().copied().filter(|p| is_asked(*p) && !self.covered[*p]).collect();
        self.between(by, of, 1);
    }

    /// Marks what some place of `by` is nowhere above, from a quantity on.
    fn between(&mut self, by: Vec<usize>, of: Vec<usize>, from: usize) {
        let points = self.points;
        let Some(last) = points.first().map_or(0, |point| point.len()).checked_sub(1) else { return };
        if by.is_empty() || of.is_empty() {
            return;
        }
        if from >= last {
            let least = by.iter().map(|p| points[*p].get(from).copied().unwrap_or(0.0)).fold(f64::INFINITY, f64::min);
            for place in of {
                self.covered[place] |= points[place].get(from).is_none_or(|value| least <= *value);
            }
            return;
        }
        if by.len() * of.len() <= FEW {
            for place in of {
                self.covered[place] |= by.iter().any(|p| is_nowhere_above(&points[*p][from..], &points[place][from..]));
            }
            return;
        }
        let value = |place: &usize| points[*place][from];
        let mut values: Vec<f64> = by.iter().chain(&of).map(value).collect();
        let middle = values.len() / 2;
        let (_, pivot, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
        let pivot = *pivot;
        let split = |places: Vec<usize>, below: &dyn Fn(f64) -> bool| -> (Vec<usize>, Vec<usize>) {
            places.into_iter().partition(|place| below(value(place)))
        };
        let none_below = values.iter().all(|v| *v >= pivot);
        if none_below && values.iter().all(|v| *v <= pivot) {
            return self.between(by, of, from + 1);
        }
        // What lies at the middle goes to the side that leaves something on the other.
        let below = |v: f64| if none_below { v <= pivot } else { v < pivot };
        let ((by_low, by_high), (of_low, of_high)) = (split(by, &below), split(of, &below));
        self.between(by_low.clone(), of_high.clone(), from + 1);
        self.between(by_low, of_low, from);
        self.between(by_high, of_high, from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    /// Random points, many of them equal in some quantity or in all, against every pair.
    #[test]
    fn what_is_left_is_what_no_pair_says_is_bettered() {
        let mut random = Pcg64::seed_from_u64(4);
        for round in 0..400 {
            let (count, quantities) = (random.random_range(1..160), 1 + round % 6);
            let coarse = round % 3 == 0;
            let mut draw = || -> Vec<f64> {
                let one = |_| random.random_range(0.0..1.0_f64);
                let raw: Vec<f64> = (0..quantities).map(one).collect();
                if coarse { raw.into_iter().map(|v| (5.0 * v).floor()).collect() } else { raw }
            };
            let points: Vec<Vec<f64>> = (0..count).map(|_| draw()).collect();
            let others: Vec<Vec<f64>> = (0..count / 2).map(|_| draw()).collect();
            let of = |points: &'_ [Vec<f64>]| points.iter().map(|p| p.to_vec()).collect::<Vec<_>>();
            let (points, others) = (of(&points), of(&others));
            let views: Vec<&[f64]> = points.iter().map(Vec::as_slice).collect();
            let mut kept = not_dominated(&views, |a, b| a.cmp(&b));
            let sorted = kept.windows(2).all(|w| lexicographic(views[w[0]], views[w[1]]).is_lt());
            assert!(sorted, "round {round}");
            kept.sort_unstable();
            let is_kept = |k: &usize| {
                let better = |j: usize| j != *k && is_nowhere_above(views[j], views[*k]);
                !(0..views.len()).any(|j| better(j) && (views[j] != views[*k] || j < *k))
            };
            assert_eq!(kept, (0..views.len()).filter(is_kept).collect::<Vec<_>>(), "round {round}");
            let by: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
            let covered: Vec<bool> = views.iter().map(|v| by.iter().any(|b| is_nowhere_above(b, v))).collect();
            assert_eq!(are_covered(&views, &by), covered, "round {round}");
        }
        assert!(not_dominated(&[], |_, _| std::cmp::Ordering::Equal).is_empty() && are_covered(&[], &[]).is_empty());
    }
}
