//! The straight line by which simulators let torque fall with speed.
//!
//! MuJoCo's `dcmotor`, Isaac Lab's `DCMotorCfg`, mjlab's `DcMotorActuatorCfg` and Newton's `DCMotorClamping` clip alike, at the
//! joint: `max(−e, s (−1 − ω/ω₀)) ≤ τ ≤ min(e, s (1 − ω/ω₀))`. The motor's own curve is a voltage circle, `(R i + K_B ω)² +
//! (p L i ω)² = V²`: with inductance it leaves e earlier than a line by the resistance would. So the line goes through the
//! corner, where the circle leaves e, and through the speed without load, and how far the two are apart is known.

/// The line, at the joint, before the gear's loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Largest torque, e \[N·m\].
    pub effort: f64,
    /// Torque of the line at standstill, s \[N·m\]: e or more.
    pub stall: f64,
    /// Speed without load, ω₀ \[rad/s\].
    pub no_load: f64,
    /// Speed up to which e can be had, ω_c \[rad/s\].
    pub corner: f64,
    /// Where the line promises most too much: speed \[rad/s\] and torque \[N·m\].
    pub excess: (f64, f64),
    /// Where it promises most too little, likewise.
    pub shortfall: (f64, f64),
    /// Whether nothing is known of the speed up to which e can be had: then the line falls from standstill on.
    pub is_assumed: bool,
}

/// Points at which line and circle are compared.
const POINTS: usize = 400;

/// A corner is no nearer to the speed without load than this share of it: a line is never upright.
const UPRIGHT: f64 = 0.999;

impl Line {
    /// The line of a largest torque \[N·m\] and a speed without load \[rad/s\], where `speed_at` says up to which speed
    /// \[rad/s\] a torque \[N·m\] can be had. `None` where one of them is no number above zero.
    pub fn new(effort: f64, no_load: f64, speed_at: impl Fn(f64) -> Option<f64>) -> Option<Line> {
        let usable = |value: f64| value.is_finite() && value > 0.0;
        if !usable(effort) || !usable(no_load) {
            return None;
        }
        let corner = speed_at(effort)?.clamp(0.0, UPRIGHT * no_load);
        let stall = effort / (1.0 - corner / no_load);
        let blank =
            Line { effort, stall, no_load, corner, excess: (0.0, 0.0), shortfall: (0.0, 0.0), is_assumed: false };
        Some(blank.compared(&speed_at))
    }

    /// The line of an actuator of which a largest torque \[N·m\] and a speed without load \[rad/s\] alone are known: it falls from
    /// standstill on. A motor without inductance whose current is limited has no less
    /// than that; with much of it, it may.
    pub fn triangle(effort: f64, no_load: f64) -> Option<Line> {
        let line = Line::new(effort, no_load, |_| Some(0.0))?;
        Some(Line { excess: (0.0, 0.0), shortfall: (0.0, 0.0), is_assumed: true, ..line })
    }

    /// The line that promises nothing too much, and of those the one with the most area under it: it passes along an edge of the
    /// lower convex hull of the motor's own curve, and may end before the speed without load.
    #[must_use]
    pub fn below(&self, speed_at: impl Fn(f64) -> Option<f64>) -> Line {
        let hull = lower_hull(self.curve(&speed_at).collect());
        let area = |line: &Line| line.effort * 0.5 * (line.corner + line.no_load);
        let through = |pair: &[(f64, f64)]| {
            let ((slow, more), (fast, less)) = (pair[0], pair[1]);
            let slope = (more - less) / (fast - slow);
            (slope > 0.0).then(|| self.falling(fast + less / slope, more + slope * slow))
        };
        // A curve that ends upright has one corner alone.
        let upright = hull.last().map(|(speed, _)| self.falling(*speed, self.effort / (1.0 - UPRIGHT)));
        let edges = hull.windows(2).filter_map(through).chain(upright.filter(|_| hull.len() == 1));
        let best = edges.reduce(|a, b| if area(&b) > area(&a) { b } else { a });
        best.unwrap_or(*self).compared_over(self.effort, &speed_at)
    }

    /// A line with another end and another torque at standstill.
    fn falling(&self, no_load: f64, stall: f64) -> Line {
        let effort = self.effort.min(stall);
        Line { effort, stall, no_load, corner: no_load * (1.0 - effort / stall), ..*self }
    }

    /// Largest torque that the line allows at a speed in the torque's own direction \[N·m\].
    pub fn at(&self, speed: f64) -> f64 {
        self.effort.min(self.stall * (1.0 - speed / self.no_load))
    }

    /// With torques and speeds of another side of a ratio: torque times, speed by `ratio`.
    #[must_use]
    pub fn behind(&self, ratio: f64) -> Line {
        let point = |(speed, torque): (f64, f64)| (speed / ratio, torque * ratio);
        Line {
            effort: self.effort * ratio,
            stall: self.stall * ratio,
            no_load: self.no_load / ratio,
            corner: self.corner / ratio,
            excess: point(self.excess),
            shortfall: point(self.shortfall),
            is_assumed: self.is_assumed,
        }
    }

    /// Points of the motor's own curve: speed and torque, from its end to the corner.
    fn curve<'a>(&'a self, speed_at: &'a impl Fn(f64) -> Option<f64>) -> impl Iterator<Item = (f64, f64)> + 'a {
        let last = self.no_load;
        curve(self.effort, speed_at).map(move |(speed, torque)| (speed.min(last), torque))
    }

    fn compared(self, speed_at: &impl Fn(f64) -> Option<f64>) -> Line {
        self.compared_over(self.effort, speed_at)
    }

    /// Compared with the curve up to a torque.
    fn compared_over(mut self, most: f64, speed_at: &impl Fn(f64) -> Option<f64>) -> Line {
        let (mut excess, mut shortfall) = ((0.0, 0.0), (0.0, 0.0));
        // Of one speed the curve has its largest torque: below it, it ends upright.
        let mut largest: Vec<(f64, f64)> = Vec::new();
        for (speed, torque) in curve(most, speed_at) {
            match largest.last_mut() {
                Some(last) if last.0 <= speed => *last = (last.0, torque),
                _ => largest.push((speed, torque)),
            }
        }
        // Just beyond where it ends upright it has nothing.
        if let Some((end, _)) = largest.first().filter(|(end, torque)| *end < self.no_load && *torque > 0.0) {
            excess = (*end, self.at(*end));
        }
        for (speed, torque) in largest {
            let more = self.at(speed) - torque;
            if more > excess.1 {
                excess = (speed, more);
            }
            if -more > shortfall.1 {
                shortfall = (speed, -more);
            }
        }
        (self.excess, self.shortfall) = (excess, shortfall);
        self
    }
}

/// Points of a curve up to a torque: speed and torque, the fastest first.
fn curve(most: f64, speed_at: &impl Fn(f64) -> Option<f64>) -> impl Iterator<Item = (f64, f64)> {
    let torques = (0..=POINTS).map(move |k| most * k as f64 / POINTS as f64);
    torques.filter_map(move |torque| Some((speed_at(torque)?, torque)))
}

/// The lower convex hull of points, by rising speed.
fn lower_hull(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    // Of one speed the least torque: a curve that falls upright there promises no more.
    points.dedup_by(|next, first| next.0 - first.0 <= 1e-12 * first.0.abs());
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for point in points {
        let turns = |a: (f64, f64), b: (f64, f64)| (b.0 - a.0) * (point.1 - a.1) - (b.1 - a.1) * (point.0 - a.0);
        while hull.len() >= 2 && turns(hull[hull.len() - 2], hull[hull.len() - 1]) <= 0.0 {
            hull.pop();
        }
        hull.push(point);
    }
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor without inductance is its own line.
    #[test]
    fn without_inductance_line_and_circle_are_one() {
        // V = R i + K ω with V = 10 V, R = 0.5 ohm, K = 0.1: stall 2 N*m, no load 100 rad/s; at most 1.2 N*m.
        let speed_at = |torque: f64| Some((10.0 - 0.5 * torque / 0.1) / 0.1);
        let line = Line::new(1.2, 100.0, speed_at).unwrap();
        assert!((line.stall - 2.0).abs() < 1e-12 && (line.corner - 40.0).abs() < 1e-12);
        assert!(line.excess.1 < 1e-12 && line.shortfall.1 < 1e-12, "{line:?}");
        assert!((line.at(-20.0) - 1.2).abs() < 1e-12 && (line.at(70.0) - 0.6).abs() < 1e-12);
    }

    /// With inductance the circle lies below its chord or above it, and `below` promises nothing too much.
    #[test]
    fn the_line_below_promises_nothing_too_much() {
        let (r, k, l, v) = (0.5, 0.1, 2e-3, 10.0);
        let speed_at = move |torque: f64| {
            let i: f64 = torque / k;
            let (a, b, c) = (k * k + (l * i).powi(2), r * i * k, (r * i).powi(2) - v * v);
            Some((-b + (b * b - a * c).sqrt()) / a)
        };
        let line = Line::new(1.2, v / k, speed_at).unwrap();
        assert!((line.at(line.corner) - 1.2).abs() < 1e-12);
        let below = line.below(speed_at);
        assert!(below.excess.1 < 1e-9, "{below:?}");
        assert!(below.stall <= line.stall && below.effort <= line.effort);
        // It touches the curve: a little more would promise too much.
        let more = Line { stall: below.stall * 1.001, ..below }.compared_over(1.2, &speed_at);
        assert!(more.excess.1 > 0.0);
    }

    /// A curve that ends upright before the speed without load keeps its torque.
    #[test]
    fn a_curve_that_ends_upright_keeps_its_torque() {
        // 120 N*m up to 6 rad/s, falling to 10 N*m at 20 rad/s, then nothing; 21 rad/s without load.
        let speed_at = |torque: f64| Some(if torque <= 10.0 { 20.0 } else { 20.0 - (torque - 10.0) / 110.0 * 14.0 });
        let line = Line::new(120.0, 21.0, speed_at).unwrap();
        assert!(line.excess.1 > 1.0, "{line:?}");
        let below = line.below(speed_at);
        assert!(below.effort > 115.0 && below.no_load <= 20.0 + 1e-9, "{below:?}");
        assert!(below.excess.1 < 1e-6, "{below:?}");
        // A box stays one.
        let upright = |_: f64| Some(20.0);
        let below = Line::new(120.0, 20.0, upright).unwrap().below(upright);
        assert!(below.effort == 120.0 && below.corner > 19.9, "{below:?}");
    }

    #[test]
    fn what_is_not_known_makes_no_line() {
        assert_eq!(Line::new(1.0, f64::INFINITY, |_| Some(1.0)), None);
        assert_eq!(Line::new(0.0, 1.0, |_| Some(1.0)), None);
        assert_eq!(Line::new(1.0, 1.0, |_| None), None);
    }
}
