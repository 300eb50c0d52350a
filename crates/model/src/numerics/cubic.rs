//! A cubic between two places, by its values and slopes there.

/// `c_0 + c_1 s + c_2 s² + c_3 s³` from one sample, s = 0, to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cubic([f64; 4]);

impl Cubic {
    /// Through values and slopes at both ends of an interval.
    pub(crate) fn between(length: f64, [y0, d0]: [f64; 2], [y1, d1]: [f64; 2]) -> Cubic {
        let secant = (y1 - y0) / length;
        Cubic([y0, d0, (3.0 * secant - 2.0 * d0 - d1) / length, (d0 + d1 - 2.0 * secant) / (length * length)])
    }

    /// The value.
    pub(crate) fn at(&self, s: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + s * (b + s * (c + s * d))
    }

    /// The first derivative.
    pub(crate) fn slope(&self, s: f64) -> f64 {
        let [_, b, c, d] = self.0;
        b + s * (2.0 * c + s * 3.0 * d)
    }

    /// The second derivative.
    pub(crate) fn bend(&self, s: f64) -> f64 {
        2.0 * self.0[2] + 6.0 * self.0[3] * s
    }

    /// The third derivative, which is one number.
    pub(crate) fn third(&self) -> f64 {
        6.0 * self.0[3]
    }

    /// The integral from zero.
    pub(crate) fn integral(&self, s: f64) -> f64 {
        let [a, b, c, d] = self.0;
        s * (a + s * (b / 2.0 + s * (c / 3.0 + s * d / 4.0)))
    }

    /// Its derivative, as another one.
    pub(crate) fn derivative(&self) -> Cubic {
        let [_, b, c, d] = self.0;
        Cubic([b, 2.0 * c, 3.0 * d, 0.0])
    }

    /// Where the slope is zero inside of (0, length), in order.
    fn turns(&self, length: f64) -> Vec<f64> {
        let [_, b, c, d] = self.0;
        // 3 d s² + 2 c s + b = 0, without cancellation.
        let root = c * c - 3.0 * d * b;
        let mut turns = Vec::new();
        if root >= 0.0 {
            let q = -(c + root.sqrt().copysign(c));
            turns.extend([q / (3.0 * d), b / q].into_iter().filter(|s| *s > 0.0 && *s < length));
            turns.sort_by(f64::total_cmp);
        }
        turns
    }

    /// The largest magnitude on [0, length].
    pub(crate) fn largest(&self, length: f64) -> f64 {
        self.turns(length).into_iter().chain([0.0, length]).map(|s| self.at(s).abs()).fold(0.0, f64::max)
    }

    /// Where it changes its sign inside of (0, length), in order.
    pub(crate) fn zeros(&self, length: f64) -> Vec<f64> {
        let mut ends = vec![0.0];
        ends.extend(self.turns(length));
        ends.push(length);
        let crosses = |w: &&[f64]| self.at(w[0]) * self.at(w[1]) < 0.0;
        ends.windows(2).filter(crosses).map(|w| self.zero_within(w[0], w[1])).collect()
    }

    fn zero_within(&self, mut a: f64, mut b: f64) -> f64 {
        let rises = self.at(b) > 0.0;
        loop {
            let middle = 0.5 * (a + b);
            if middle <= a || middle >= b {
                return middle;
            }
            if (self.at(middle) > 0.0) == rises { b = middle } else { a = middle }
        }
    }
}
