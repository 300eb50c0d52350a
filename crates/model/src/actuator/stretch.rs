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
/// use gearwise_model::actuator::stretch::{Piece, longest};
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
    let mut pieces: Vec<(f64, f64)> = Vec::with_capacity(course.len() + 8);
    for piece in course {
        let (whole, rest) = of_one_sign(piece, limit);
        pieces.push(whole);
        pieces.extend(rest);
    }
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

/// The largest response \[A²\] of a first-order lag with a time constant \[s\] to the squared current: in the state that
/// repeats, or from zero where the motion happens once. A slower lag, or several in a row, respond by no more.
///
/// ```
/// use gearwise_model::actuator::stretch::{Piece, lagged};
///
/// // A step of 4 A² for one time constant, from zero: 4 (1 − 1/e).
/// let step = [Piece { duration: 5.0, from: 4.0, to: 4.0 }];
/// assert!((lagged(&step, 5.0, false) - 4.0 * (1.0 - (-1.0_f64).exp())).abs() < 1e-12);
/// ```
pub fn lagged(course: &[Piece], time_constant: f64, repeats: bool) -> f64 {
    let over = |start: f64| {
        course.iter().fold((start, start), |(value, largest), piece| {
            let slope = if piece.duration > 0.0 { (piece.to - piece.from) / piece.duration } else { 0.0 };
            // y = from − s τ + s t + (y_0 − from + s τ) exp(−t/τ)
            let (lag, away) = (slope * time_constant, value - piece.from + slope * time_constant);
            let at = |t: f64| piece.from - lag + slope * t + away * (-t / time_constant).exp();
            // It turns where s τ = away exp(−t/τ).
            let turns = -time_constant * (lag / away).ln();
            let within = turns.is_finite() && 0.0 < turns && turns < piece.duration;
            let end = at(piece.duration);
            (end, largest.max(end).max(if within { at(turns) } else { end }))
        })
    };
    let lasts: f64 = course.iter().map(|piece| piece.duration).sum();
    let start = match repeats && lasts > 0.0 {
        true => over(0.0).0 / -(-lasts / time_constant).exp_m1(),
        false => 0.0,
    };
    over(start).1
}

/// How long a course lasts \[s\], and the mean of its squared current \[A²\]: zero where it lasts no time.
pub(crate) fn mean(course: &[Piece]) -> (f64, f64) {
    let sum = |(lasts, sum): (f64, f64), piece: &Piece| {
        (lasts + piece.duration, sum + 0.5 * piece.duration * (piece.from + piece.to))
    };
    let (lasts, sum) = course.iter().fold((0.0, 0.0), sum);
    (lasts, if lasts > 0.0 { sum / lasts } else { 0.0 })
}

/// Whether [`lagged`] is within a steady limit \[A²\], of a course with this [mean](mean()) \[A²\].
pub(crate) fn lags_within(course: &[Piece], mean: f64, time_constant: f64, repeats: bool, limit: f64) -> bool {
    // In the state that repeats the response is at its mean at some time, from where it rises by no more than what is above
    // the mean, over the time constant; a motion that happens once starts below it.
    let above = |piece: &Piece| 0.5 * piece.duration * ((piece.from - mean).max(0.0) + (piece.to - mean).max(0.0));
    let most = mean + course.iter().map(above).sum::<f64>() / time_constant;
    is_within(most, limit) || is_within(lagged(course, time_constant, repeats), limit)
}

/// The piece, cut where it crosses the limit: how long each part lasts, and its excess over the limit \[A²·s\].
fn of_one_sign(piece: &Piece, limit: f64) -> ((f64, f64), Option<(f64, f64)>) {
    let (from, to) = (piece.from - limit, piece.to - limit);
    if from * to >= 0.0 {
        return ((piece.duration, 0.5 * piece.duration * (from + to)), None);
    }
    let first = piece.duration * from / (from - to);
    let rest = (piece.duration - first, 0.5 * (piece.duration - first) * to);
    ((first, 0.5 * first * from), Some(rest))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hold(duration: f64, squared: f64) -> Piece {
        Piece { duration, from: squared, to: squared }
    }

    #[test]
    fn a_lag_is_followed_exactly_over_ramps_and_periods() {
        let course =
            [Piece { duration: 3.0, from: 5.0, to: 0.5 }, hold(4.0, 0.2), Piece { duration: 2.0, from: 0.2, to: 5.0 }];
        for (tau, repeats) in [(1.3, false), (5.1, true), (0.2, true)] {
            // An independent integration in small steps, over many periods.
            let (mut y, mut largest) = (0.0_f64, 0.0_f64);
            for _ in 0..if repeats { 60 } else { 1 } {
                largest = 0.0;
                for piece in &course {
                    let steps = 40_000;
                    let dt = piece.duration / f64::from(steps);
                    for k in 0..steps {
                        let share = (f64::from(k) + 0.5) / f64::from(steps);
                        y += dt / tau * (piece.from + share * (piece.to - piece.from) - y);
                        largest = largest.max(y);
                    }
                }
            }
            let found = lagged(&course, tau, repeats);
            assert!((found / largest - 1.0).abs() < 1e-3, "{tau} {repeats}: {found} {largest}");
        }
    }

    #[test]
    fn a_slower_lag_responds_by_no_more() {
        let course = [hold(1.0, 7.0), hold(2.5, 0.0), Piece { duration: 1.0, from: 2.0, to: 9.0 }, hold(3.0, 0.0)];
        let of = |tau: f64| lagged(&course, tau, true);
        let taus = [0.3, 0.7, 1.5, 5.0, 40.0];
        assert!(taus.windows(2).all(|t| of(t[0]) >= of(t[1])));
    }

    #[test]
    fn what_is_shown_by_mean_and_excess_is_so_where_the_lag_is_followed() {
        let mut seed = 7_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut within, mut beyond) = (0, 0);
        for _ in 0..2000 {
            let mut from = 9.0 * random();
            let course: Vec<Piece> = (0..5)
                .map(|_| {
                    let to = 9.0 * random();
                    let piece = Piece { duration: 2.0 * random(), from, to };
                    from = if random() < 0.3 { 9.0 * random() } else { to };
                    piece
                })
                .collect();
            let (tau, limit, repeats) = (0.2 + 5.0 * random(), 2.0 + 5.0 * random(), random() < 0.5);
            let followed = lagged(&course, tau, repeats);
            let (lasts, mean) = mean(&course);
            assert_eq!(lags_within(&course, mean, tau, repeats, limit), is_within(followed, limit));
            // Neither says more than the lag that is followed, and no stretch is longer than all.
            assert!(!repeats || followed >= mean * (1.0 - 1e-9));
            let stretch = longest(&course, limit, repeats);
            assert!(stretch <= lasts * (1.0 + 1e-9) || (repeats && mean > limit));
            if is_within(followed, limit) { within += 1 } else { beyond += 1 }
        }
        assert!(within > 300 && beyond > 300, "{within} {beyond}");
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
