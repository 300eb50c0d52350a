//! How long heat stays above what can be carried for ever, over a motion.
//!
//! Where a motor's heat capacity is not known, its mean heat tells the winding's temperature only as long as the
//! winding averages what happens. The one idea: a bucket fills with the heat above the steady limit, and empties with
//! what is below it. A *stretch* goes from where the bucket begins to fill until it is fullest, so that pauses too
//! short to make up for what went before count with it.

/// A time over which a squared current goes linearly from one value to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// How long it lasts \[s\], not negative.
    pub duration: f64,
    /// Squared current at its start \[A²\].
    pub from: f64,
    /// Squared current at its end \[A²\].
    pub to: f64,
}

/// What a binding limit may be exceeded by (relative) and still count as kept.
const ROUNDING: f64 = 1e-6;

/// Whether a squared current is within a steady limit \[A²\].
pub(crate) fn is_within(squared: f64, limit: f64) -> bool {
    squared <= limit * (1.0 + ROUNDING)
}

/// The longest stretch above a steady limit of the squared current \[A²\], in seconds: zero where it is nowhere
/// above, infinite where a motion that repeats never makes up for it.
///
/// ```
/// use gearwise::actuator::stretch::{Piece, longest};
///
/// let hold = |duration, squared| Piece { duration, from: squared, to: squared };
/// // 0.4 s above, a pause that makes up for a tenth of it, 0.4 s above: one stretch.
/// let course = [hold(0.4, 3.0), hold(0.08, 0.0), hold(0.4, 3.0), hold(10.0, 0.0)];
/// assert!((longest(&course, 1.0, true) - 0.88).abs() < 1e-9);
/// // A pause that makes up for all of it parts them.
/// let course = [hold(0.4, 3.0), hold(0.9, 0.0), hold(0.4, 3.0), hold(10.0, 0.0)];
/// assert!((longest(&course, 1.0, true) - 0.4).abs() < 1e-9);
/// ```
pub fn longest(course: &[Piece], limit: f64, repeats: bool) -> f64 {
    let limit = limit * (1.0 + ROUNDING);
    let mut pieces: Vec<(f64, f64)> = course.iter().flat_map(|piece| of_one_sign(piece, limit)).collect();
    if repeats {
        if pieces.iter().map(|piece| piece.1).sum::<f64>() > 0.0 {
            return f64::INFINITY;
        }
        // Where the sum from any start is least the bucket is empty, in the state that repeats.
        let (mut sum, mut least, mut start) = (0.0, 0.0, 0);
        for (k, (_, excess)) in pieces.iter().enumerate() {
            sum += excess;
            if sum < least {
                (least, start) = (sum, k + 1);
            }
        }
        pieces.rotate_left(start);
    }
    let (mut time, mut bucket, mut begun, mut fullest, mut stretch) = (0.0, 0.0, 0.0, 0.0, 0.0_f64);
    for (duration, excess) in pieces {
        if bucket <= 0.0 {
            (bucket, fullest, begun) = (0.0, 0.0, time);
        }
        (time, bucket) = (time + duration, bucket + excess);
        if bucket > fullest {
            fullest = bucket;
            stretch = stretch.max(time - begun);
        }
    }
    stretch
}

/// The piece, cut where it crosses the limit: how long each part lasts, and its excess over the limit \[A²·s\].
fn of_one_sign(piece: &Piece, limit: f64) -> impl Iterator<Item = (f64, f64)> {
    let (from, to) = (piece.from - limit, piece.to - limit);
    let crosses = from * to < 0.0;
    let first = if crosses { piece.duration * from / (from - to) } else { piece.duration };
    let whole = (first, 0.5 * first * if crosses { from } else { from + to });
    let rest = (piece.duration - first, 0.5 * (piece.duration - first) * to);
    [Some(whole), crosses.then_some(rest)].into_iter().flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hold(duration: f64, squared: f64) -> Piece {
        Piece { duration, from: squared, to: squared }
    }

    #[test]
    fn what_is_within_the_limit_has_no_stretch() {
        assert_eq!(longest(&[hold(5.0, 1.0), hold(7.0, 0.2)], 1.0, true), 0.0);
        // A hold that binds exactly, but for rounding.
        assert_eq!(longest(&[hold(5.0, 1.0 + 1e-9)], 1.0, true), 0.0);
    }

    #[test]
    fn a_ramp_counts_from_where_it_crosses() {
        let ramp = [Piece { duration: 4.0, from: 0.0, to: 4.0 }, hold(20.0, 0.0)];
        assert!((longest(&ramp, 1.0, false) - 3.0).abs() < 1e-4);
    }

    #[test]
    fn a_stretch_goes_over_the_end_of_the_period() {
        let course = [hold(0.3, 4.0), hold(20.0, 0.0), hold(0.4, 4.0)];
        assert!((longest(&course, 1.0, true) - 0.7).abs() < 1e-9);
        assert!((longest(&course, 1.0, false) - 0.4).abs() < 1e-9);
    }

    #[test]
    fn what_is_never_made_up_for_has_no_end() {
        let course = [hold(0.5, 4.0), hold(0.5, 0.0)];
        assert_eq!(longest(&course, 1.0, true), f64::INFINITY);
        // Once, it lasts as long as it does.
        assert!((longest(&course, 1.0, false) - 0.5).abs() < 1e-9);
    }
}
