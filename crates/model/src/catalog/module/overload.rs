//! An overload table as the thermal answer of a winding.
//!
//! The one idea: if a constant torque T from ambient reaches the limit after t, and the rated torque never does, the answer of
//! the normalised temperature to a step of T² is s(t) = (T_r/T)², s(∞) = 1. A sum of lags through these points follows any
//! motion: `ẏ_i = (g_i (T/T_r)² − y_i)/τ_i`, with Σ y_i ≤ 1.

use crate::numerics::work;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

/// Time constants that lags are looked for among.
const LAGS: usize = 60;
/// By what its lags are made quicker at most, so that an answer is nowhere below the table.
const QUICKER: f64 = 0.9;
/// Lags of a smaller share of the answer are left out.
const LEAST_SHARE: f64 = 1e-6;
/// By how much a table may bend the wrong way: no passive body does, and times are rounded. An answer is nowhere below the points, so
/// that a bend costs reserve and no safety; more than this is a mistake in the table.
pub const BENDS: f64 = 0.5;

/// The answer of a winding to a step of the squared torque, over what the rated torque ends at.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Torque that never reaches the limit \[N·m\].
    pub rated: f64,
    /// Shares, which sum to one, and time constants \[s\], while the rotor turns.
    pub lags: Vec<(f64, f64)>,
    /// Shares and time constants \[s\] at standstill, where one phase carries two thirds of the heat: response to twice the squared torque.
    pub standing: Vec<(f64, f64)>,
}

/// Time over which squared torques go linearly from one value to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Duration \[s\].
    pub lasts: f64,
    /// Squared torque while the rotor turns, at the start and at the end \[N²·m²\].
    pub turning: [f64; 2],
    /// Twice the squared torque at standstill, at the start and at the end \[N²·m²\].
    pub standing: [f64; 2],
}

impl Response {
    /// The answer of a module with a rated torque \[N·m\], from the tables of overload while it turns and at standstill; `None` where neither
    /// is of use. A module with one of the two answers by that one: while it turns it bears a torque no shorter than at standstill, and at
    /// standstill one phase has at most twice the heat. How much less it is depends on the share that the winding has of the rise.
    pub fn of_tables(rated: f64, turning: &[[f64; 2]], standing: &[[f64; 2]]) -> Option<Response> {
        // At standstill less than the rated torque reaches the limit, which says nothing of turning.
        let of_standing = || standing.iter().copied().filter(|[torque, _]| *torque > rated).collect::<Vec<_>>();
        let turning = Response::fit(rated, turning).or_else(|| Response::fit(rated, &of_standing()));
        // The heat of the worst phase is twice the mean: it bears the rated torque over √2 continuously.
        let standing = Response::fit(rated * std::f64::consts::FRAC_1_SQRT_2, standing);
        match (turning, standing) {
            (Some(turning), Some(standing)) => Some(Response { standing: standing.lags, ..turning }),
            // One that says too little of turning is judged by the rated torque.
            (None, _) => None,
            (turning, None) => turning,
        }
    }

    /// The answer through the points of a table \[N·m, s\], nowhere below them; `None` where a table has less than two points or
    /// contradicts itself.
    ///
    /// The slowest lag is ten times as slow as the longest time; where that cannot follow the points, it is slower: what lies behind
    /// the table is then no faster than the table needs.
    pub fn fit(rated: f64, table: &[[f64; 2]]) -> Option<Response> {
        let excess = |of: &Response| {
            let points = table.iter().filter(|p| p[0] > rated);
            points.map(|[torque, time]| of.step(*time) * (torque / rated).powi(2)).fold(0.0, f64::max)
        };
        let mut best: Option<(f64, Response)> = None;
        for slowest in [10.0, 100.0, 1e3, 1e4] {
            let Some(found) = Response::fit_up_to(slowest, rated, table) else { continue };
            let over = excess(&found);
            if best.as_ref().is_none_or(|(least, _)| over < 0.98 * least) {
                best = Some((over, found));
            }
            if over < 1.02 {
                break;
            }
        }
        best.map(|(_, found)| found)
    }

    fn fit_up_to(slowest: f64, rated: f64, table: &[[f64; 2]]) -> Option<Response> {
        let points: Vec<(f64, f64)> =
            table.iter().filter(|p| p[0] > rated).map(|[torque, time]| (*time, (rated / torque).powi(2))).collect();
        if points.len() < 2 || bends(rated, table) > BENDS {
            return None;
        }
        let (least, most) = points.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), p| (a.min(p.0), b.max(p.0)));
        let (from, to) = (0.05 * least, slowest * most);
        let lags: Vec<f64> = (0..LAGS).map(|k| from * (to / from).powf(k as f64 / (LAGS - 1) as f64)).collect();
        let answer = |time: f64, lag: f64| -(-time / lag).exp_m1();
        // Least squares of relative misses, answers nowhere below the points, shares that sum to one.
        let rows: Vec<Vec<f64>> =
            points.iter().map(|(time, s)| lags.iter().map(|lag| answer(*time, *lag) / s).collect()).collect();
        let mut quadratic = vec![vec![0.0; LAGS]; LAGS];
        for row in &rows {
            for (i, line) in quadratic.iter_mut().enumerate() {
                line.iter_mut().zip(row).for_each(|(cell, b)| *cell += row[i] * b);
            }
        }
        for (i, line) in quadratic.iter_mut().enumerate() {
            line[i] += 1e-9;
            line[..i].fill(0.0);
        }
        let linear: Vec<f64> = (0..LAGS).map(|i| -rows.iter().map(|row| row[i]).sum::<f64>()).collect();
        let mut lines = vec![vec![1.0; LAGS]];
        let mut right = vec![1.0];
        for row in &rows {
            lines.push(row.iter().map(|x| -x).collect());
            right.push(-1.0);
        }
        for k in 0..LAGS {
            let mut line = vec![0.0; LAGS];
            line[k] = -1.0;
            lines.push(line);
            right.push(0.0);
        }
        let cones = [SupportedConeT::ZeroConeT(1), SupportedConeT::NonnegativeConeT(rows.len() + LAGS)];
        let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
        let (p, a) = (CscMatrix::from(&quadratic), CscMatrix::from(&lines));
        let mut solver = DefaultSolver::new(&p, &linear, &a, &right, &cones, settings).ok()?;
        solver.solve();
        if !matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved) {
            return None;
        }
        let shares: Vec<f64> = solver.solution.x.iter().map(|share| share.max(0.0)).collect();
        let kept = |share: &f64| *share > LEAST_SHARE;
        let all: f64 = shares.iter().filter(|s| kept(s)).sum();
        let lags: Vec<(f64, f64)> =
            shares.iter().zip(&lags).filter(|(s, _)| kept(s)).map(|(share, lag)| (share / all, *lag)).collect();
        let mut response = Response { rated, standing: lags.clone(), lags };
        // What the solver leaves is on the safe side: a quicker answer is a higher one.
        let undercuts = |of: &Response| points.iter().any(|(time, s)| of.step(*time) < *s);
        let solved = response.lags.clone();
        let quicker = |by: f64| {
            let lags: Vec<(f64, f64)> = solved.iter().map(|(share, lag)| (*share, by * lag)).collect();
            Response { rated, standing: lags.clone(), lags }
        };
        if undercuts(&response) {
            let (mut enough, mut too_slow) = (QUICKER, 1.0);
            for _ in 0..40 {
                let middle = 0.5 * (enough + too_slow);
                if undercuts(&quicker(middle)) { too_slow = middle } else { enough = middle }
            }
            response = quicker(enough);
        }
        (!response.lags.is_empty() && !undercuts(&response)).then_some(response)
    }

    /// The answer to a step after a time \[s\].
    pub fn step(&self, time: f64) -> f64 {
        self.lags.iter().map(|(share, lag)| -share * (-time / lag).exp_m1()).sum()
    }

    /// The largest normalised temperature over a course of the squared torque: in the state that repeats, or from cold.
    pub fn peak(&self, course: &[Piece], repeats: bool) -> f64 {
        let square = self.rated * self.rated;
        let end = |y: f64, (share, lag): (f64, f64), (lasts, decay): (f64, f64), [from, to]: [f64; 2]| {
            if lasts <= 0.0 {
                return y;
            }
            // y follows share·x with a lag; x is a ramp.
            let (a, slope) = (share * from / square, share * (to - from) / square / lasts);
            let settled = |t: f64| a + slope * (t - lag);
            settled(lasts) + (y - settled(0.0)) * decay
        };
        type Squares = fn(&Piece) -> [f64; 2];
        let (turning, standing): (Squares, Squares) = (|piece| piece.turning, |piece| piece.standing);
        let turning = self.lags.iter().map(|lag| (*lag, turning));
        let all: Vec<((f64, f64), Squares)> = turning.chain(self.standing.iter().map(|lag| (*lag, standing))).collect();
        let start = |(lag, squares): &((f64, f64), Squares)| {
            if !repeats {
                return 0.0;
            }
            // One period takes y to c + d y.
            let mut decay = Decay::of(lag.1);
            let after = course.iter().fold(0.0, |y, piece| end(y, *lag, decay.over(piece.lasts), squares(piece)));
            let lasts: f64 = course.iter().map(|piece| piece.lasts).sum();
            after / -(-lasts / lag.1).exp_m1()
        };
        let mut state: Vec<f64> = all.iter().map(start).collect();
        let mut peak: f64 = state.iter().sum();
        let mut decays: Vec<Decay> = all.iter().map(|((_, lag), _)| Decay::of(*lag)).collect();
        work::count(course.len() * LOOKS * all.len());
        for piece in course {
            for k in 0..LOOKS {
                for ((y, (lag, squares)), decay) in state.iter_mut().zip(&all).zip(&mut decays) {
                    let [from, to] = squares(piece);
                    let part = [k, k + 1].map(|look| from + (to - from) * look as f64 / LOOKS as f64);
                    *y = end(*y, *lag, decay.over(piece.lasts / LOOKS as f64), part);
                }
                peak = peak.max(state.iter().sum());
            }
        }
        peak
    }
}

/// Parts of a piece at whose ends the temperature is computed: within a piece it may be higher than at its ends.
const LOOKS: usize = 16;

/// Decay of a lag over times, of which equal ones often follow each other.
struct Decay {
    lag: f64,
    /// The last time \[s\] and its decay.
    last: (f64, f64),
}

impl Decay {
    fn of(lag: f64) -> Decay {
        Decay { lag, last: (0.0, 1.0) }
    }

    /// A time \[s\] and the decay over it.
    fn over(&mut self, lasts: f64) -> (f64, f64) {
        if lasts != self.last.0 {
            self.last = (lasts, (-lasts / self.lag).exp());
        }
        self.last
    }
}

/// By how much an overload table bends the wrong way: the largest share by which a time exceeds what its neighbours leave, of the
/// concave answer that any passive body has. Zero where it bends nowhere.
pub fn bends(rated: f64, table: &[[f64; 2]]) -> f64 {
    // Of rising time: the table goes from the least torque, and the longest time, on.
    let mut points: Vec<(f64, f64)> =
        table.iter().map(|[torque, time]| (*time, (rated / torque).powi(2).min(1.0))).collect();
    points.push((0.0, 0.0));
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let over = |w: &[(f64, f64)]| {
        let [(t0, s0), (t1, s1), (t2, s2)] = [w[0], w[1], w[2]];
        // The chord of the neighbours reaches s1 at this time; a concave answer is there earlier.
        let chord = t0 + (t2 - t0) * (s1 - s0) / (s2 - s0);
        if s2 > s0 && chord > 0.0 { t1 / chord - 1.0 } else { 0.0 }
    };
    points.windows(3).map(over).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_two_nodes_is_followed_as_the_nodes_are() {
        // Shares and time constants of a body that shares no code: 0.3 with 8 s, 0.7 with 300 s.
        let s = |t: f64| 0.3 * (1.0 - (-t / 8.0_f64).exp()) + 0.7 * (1.0 - (-t / 300.0_f64).exp());
        let rated = 10.0;
        let times = [400.0, 90.0, 20.0, 4.0];
        let table: Vec<[f64; 2]> = times.iter().map(|t| [rated / s(*t).sqrt(), *t]).collect();
        let response = Response::fit(rated, &table).unwrap();
        for [torque, time] in &table {
            let miss = response.step(*time) / (rated / torque).powi(2) - 1.0;
            assert!((0.0..5e-3).contains(&miss), "{torque}: {miss}");
        }
        // A duty of 20 s at twice the rated torque in 200 s, by small steps.
        let (mut hot, mut slow, mut peak, dt) = (0.0, 0.0, 0.0_f64, 1e-3);
        for k in 0..2_000_000 {
            let t = k as f64 * dt % 200.0;
            let x = if t < 20.0 { 4.0 } else { 0.0 };
            hot += dt * (0.3 * x - hot) / 8.0;
            slow += dt * (0.7 * x - slow) / 300.0;
            if k > 1_800_000 {
                peak = peak.max(hot + slow);
            }
        }
        let hold = |lasts, square: f64| Piece { lasts, turning: [square; 2], standing: [0.0; 2] };
        let found = response.peak(&[hold(20.0, 400.0), hold(180.0, 0.0)], true);
        assert!((found / peak - 1.0).abs() < 0.01, "{found} {peak}");
        assert!(found > peak * (1.0 - 1e-3));
    }

    #[test]
    fn a_hold_reaches_the_limit_when_the_table_of_its_kind_says() {
        let (turning, standing) =
            ([[25.0, 900.0], [30.0, 393.0], [40.0, 60.0]], [[20.0, 190.0], [30.0, 25.0], [40.0, 9.0]]);
        let response = Response::of_tables(20.0, &turning, &standing).unwrap();
        for ([torque, time], stands) in turning.map(|p| (p, false)).into_iter().chain(standing.map(|p| (p, true))) {
            let square = torque * torque;
            let hold = match stands {
                true => Piece { lasts: time, turning: [0.0; 2], standing: [2.0 * square; 2] },
                false => Piece { lasts: time, turning: [square; 2], standing: [0.0; 2] },
            };
            let peak = response.peak(&[hold], false);
            assert!((1.0 - 1e-9..1.25).contains(&peak), "{torque} N·m for {time} s: {peak}");
        }
        // Without a table at standstill twice the heat answers, as while it turns.
        let alone = Response::of_tables(20.0, &turning, &[]).unwrap();
        assert_eq!(alone.standing, alone.lags);
        assert_eq!(Response::of_tables(20.0, &[], &standing).unwrap().standing, response.standing);
        assert!(Response::of_tables(20.0, &[], &[]).is_none());
        // 15 N·m is above the rating at standstill, but below it while turning: a single usable point gives no response.
        assert!(Response::of_tables(20.0, &[], &[[15.0, 600.0], [30.0, 25.0]]).is_none());
    }

    #[test]
    fn a_table_at_standstill_alone_promises_nothing_too_much_of_turning() {
        let rated = 10.0;
        for winding in [0.05, 0.1, 0.3, 0.6, 0.95] {
            for quick in [3.0, 8.0, 30.0] {
                // A winding before a housing; at standstill one phase has twice the mean heat over its own way.
                let s = |t: f64, times: f64| {
                    times * winding * (1.0 - (-t / quick).exp()) + (1.0 - winding) * (1.0 - (-t / 300.0).exp())
                };
                let table = [200.0, 60.0, 20.0, 6.0, 2.0].map(|t| [rated / s(t, 2.0).sqrt(), t]);
                let Some(response) = Response::of_tables(rated, &[], &table) else { continue };
                for time in [4.0, 10.0, 40.0, 150.0] {
                    let hold = Piece { lasts: time, turning: [900.0; 2], standing: [0.0; 2] };
                    let truth = s(time, 1.0) * 9.0;
                    let found = response.peak(&[hold], false);
                    assert!(found > truth * (1.0 - 1e-3), "{winding} {quick} {time}: {found} {truth}");
                }
            }
        }
    }

    #[test]
    fn a_table_that_bends_the_wrong_way_is_refused() {
        let concave = [[6.0, 285.0], [7.0, 94.0], [8.0, 53.0], [10.0, 20.0]];
        assert!(bends(5.0, &concave) < BENDS && Response::fit(5.0, &concave).is_some());
        // 40 N·m for 126 s between 50 for 12 s and 30 for 189 s, as one sheet of 2025 had it.
        let table = [[30.0, 189.0], [40.0, 126.0], [50.0, 12.0]];
        assert!(bends(20.0, &table) > BENDS, "{}", bends(20.0, &table));
        assert!(Response::fit(20.0, &table).is_none());
    }
}
