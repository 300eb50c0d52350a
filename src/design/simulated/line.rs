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
    /// standstill on. A motor whose current is limited has no less than that.
    pub fn triangle(effort: f64, no_load: f64) -> Option<Line> {
        let line = Line::new(effort, no_load, |_| Some(0.0))?;
        Some(Line { excess: (0.0, 0.0), shortfall: (0.0, 0.0), is_assumed: true, ..line })
    }

    /// The highest line through the speed without load that promises nothing too much: it may start below e.
    #[must_use]
    pub fn below(&self, speed_at: impl Fn(f64) -> Option<f64>) -> Line {
        let stall = self.curve(&speed_at).map(|(speed, torque)| torque / (1.0 - speed / self.no_load));
        let stall = stall.fold(self.stall, f64::min);
        let effort = self.effort.min(stall);
        let corner = self.no_load * (1.0 - effort / stall);
        Line { effort, stall, corner, ..*self }.compared(&speed_at)
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

    /// Points of the motor's own curve: speed and torque, from the speed without load to the corner.
    fn curve<'a>(&'a self, speed_at: &'a impl Fn(f64) -> Option<f64>) -> impl Iterator<Item = (f64, f64)> + 'a {
        let torques = (1..=POINTS).map(|k| self.effort * k as f64 / POINTS as f64);
        torques.filter_map(move |torque| Some((speed_at(torque)?, torque))).filter(|(speed, _)| *speed < self.no_load)
    }

    fn compared(mut self, speed_at: &impl Fn(f64) -> Option<f64>) -> Line {
        let (mut excess, mut shortfall) = ((0.0, 0.0), (0.0, 0.0));
        for (speed, torque) in self.curve(speed_at) {
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
        let more = Line { stall: below.stall * 1.001, effort: line.effort, ..below }.compared(&speed_at);
        assert!(more.excess.1 > 0.0);
    }

    #[test]
    fn what_is_not_known_makes_no_line() {
        assert_eq!(Line::new(1.0, f64::INFINITY, |_| Some(1.0)), None);
        assert_eq!(Line::new(0.0, 1.0, |_| Some(1.0)), None);
        assert_eq!(Line::new(1.0, 1.0, |_| None), None);
    }
}
