//! Interval arithmetic with derivatives: bounds of a function over a box, of its first and of its second derivative along each
//! coordinate.
//!
//! The one idea: an equation that is evaluated with these numbers says by itself whether it is monotone or convex in a coordinate
//! over the whole box. Ends are not rounded outwards: [`ROUNDING`] and the tolerance of feasibility cover that.

use std::ops::{Add, Mul, Neg, Sub};

/// Interval [low, high].
pub type Interval = [f64; 2];

/// Share of its size that rounding may leave of a derivative that vanishes.
const ROUNDING: f64 = 1e-12;

/// Everything: no bound is known.
const WHOLE: Interval = [f64::NEG_INFINITY, f64::INFINITY];

/// Behaviour of a function along one coordinate over the whole box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// Independent of the coordinate.
    Constant,
    /// Largest at the upper end.
    Rising,
    /// Largest at the lower end.
    Falling,
    /// Convex: largest at one of the ends.
    Convex,
    /// None of these is shown.
    Unknown,
}

/// A number over a box, with its derivatives along the coordinates. Coordinates beyond the stored ones have derivative zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    /// Bounds of the value.
    pub value: Interval,
    first: Vec<Interval>,
    second: Vec<Interval>,
}

fn sum(a: Interval, b: Interval) -> Interval {
    let [low, high] = [a[0] + b[0], a[1] + b[1]];
    [if low.is_nan() { f64::NEG_INFINITY } else { low }, if high.is_nan() { f64::INFINITY } else { high }]
}

fn product(a: Interval, b: Interval) -> Interval {
    // Zero times any interval is zero.
    let times = |x: f64, y: f64| if x == 0.0 || y == 0.0 { 0.0 } else { x * y };
    let all = [times(a[0], b[0]), times(a[0], b[1]), times(a[1], b[0]), times(a[1], b[1])];
    match all.iter().any(|x| x.is_nan()) {
        true => WHOLE,
        false => {
            [all.iter().copied().fold(f64::INFINITY, f64::min), all.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
        }
    }
}

fn scaled([low, high]: Interval, factor: f64) -> Interval {
    match factor {
        0.0 => [0.0; 2],
        _ if factor < 0.0 => [high * factor, low * factor],
        _ => [low * factor, high * factor],
    }
}

fn squared([low, high]: Interval) -> Interval {
    let (a, b) = (low * low, high * high);
    [if low <= 0.0 && high >= 0.0 { 0.0 } else { a.min(b) }, a.max(b)]
}

fn hull(a: Interval, b: Interval) -> Interval {
    [a[0].min(b[0]), a[1].max(b[1])]
}

/// True if an interval is not negative but for rounding.
fn is_positive(low: f64, high: f64) -> bool {
    low >= 0.0 || high.is_finite() && low >= -ROUNDING * high.abs()
}

impl Number {
    /// A constant.
    pub fn constant(value: f64) -> Number {
        Number { value: [value; 2], first: Vec::new(), second: Vec::new() }
    }

    /// The coordinate of a place, between two values, with the derivative `slope`.
    pub fn coordinate(place: usize, value: Interval, slope: f64) -> Number {
        let mut first = vec![[0.0; 2]; place + 1];
        first[place] = [slope; 2];
        Number { value, first, second: Vec::new() }
    }

    /// A number of which only bounds are known and no coordinate changes it.
    pub fn between(value: Interval) -> Number {
        Number { value, first: Vec::new(), second: Vec::new() }
    }

    fn at(of: &[Interval], place: usize) -> Interval {
        of.get(place).copied().unwrap_or([0.0; 2])
    }

    /// A function of this number, by bounds of its value and of its derivatives.
    fn chain(&self, value: Interval, slope: Interval, bend: Interval) -> Number {
        let first = self.first.iter().map(|f| product(slope, *f)).collect();
        let second = (0..self.first.len())
            .map(|i| sum(product(bend, squared(self.first[i])), product(slope, Number::at(&self.second, i))))
            .collect();
        Number { value, first, second }
    }

    /// Both numbers side by side, each derivative made of theirs.
    fn with(
        &self,
        other: &Number,
        value: Interval,
        first: impl Fn(Interval, Interval) -> Interval,
        second: impl Fn([Interval; 2], [Interval; 2]) -> Interval,
    ) -> Number {
        let count = self.first.len().max(other.first.len());
        let of = |number: &Number, i: usize| [Number::at(&number.first, i), Number::at(&number.second, i)];
        Number {
            value,
            first: (0..count).map(|i| first(of(self, i)[0], of(other, i)[0])).collect(),
            second: (0..count).map(|i| second(of(self, i), of(other, i))).collect(),
        }
    }

    /// Adds a multiple of another.
    pub fn add_scaled(&mut self, other: &Number, factor: f64) {
        let add = |to: &mut Vec<Interval>, from: &[Interval]| {
            to.resize(to.len().max(from.len()), [0.0; 2]);
            to.iter_mut().zip(from).for_each(|(to, from)| *to = sum(*to, scaled(*from, factor)));
        };
        self.value = sum(self.value, scaled(other.value, factor));
        add(&mut self.first, &other.first);
        add(&mut self.second, &other.second);
    }

    /// The square.
    #[must_use]
    pub fn square(&self) -> Number {
        self.chain(squared(self.value), product([2.0; 2], self.value), [2.0; 2])
    }

    /// One over it; unbounded where it may be zero.
    #[must_use]
    pub fn recip(&self) -> Number {
        let [low, high] = self.value;
        if low <= 0.0 && high >= 0.0 {
            return self.chain(WHOLE, WHOLE, WHOLE);
        }
        let over = [1.0 / high, 1.0 / low];
        let slope = squared(over).map(|x| -x);
        self.chain(over, [slope[1], slope[0]], product([2.0; 2], product(over, squared(over))))
    }

    /// The root of it, of zero where it is negative.
    #[must_use]
    pub fn sqrt(&self) -> Number {
        let [low, high] = self.value.map(|x| x.max(0.0).sqrt());
        if low == 0.0 {
            return self.chain([low, high], if high == 0.0 { WHOLE } else { [0.0, f64::INFINITY] }, WHOLE);
        }
        let slope = [0.5 / high, 0.5 / low];
        let bend = [-0.25 / (low * low * low), -0.25 / (high * high * high)];
        self.chain([low, high], slope, bend)
    }

    /// The larger of both.
    #[must_use]
    pub fn max(&self, other: &Number) -> Number {
        if self.value[0] >= other.value[1] {
            return self.clone();
        }
        if other.value[0] >= self.value[1] {
            return other.clone();
        }
        let value = [self.value[0].max(other.value[0]), self.value[1].max(other.value[1])];
        // Where they cross, the larger bends upwards.
        self.with(other, value, hull, |a, b| [a[1][0].min(b[1][0]), f64::INFINITY])
    }

    /// The smaller of both.
    #[must_use]
    pub fn min(&self, other: &Number) -> Number {
        -&(-self).max(&-other)
    }

    /// One of both, not known which.
    #[must_use]
    pub fn either(&self, other: &Number) -> Number {
        self.with(other, hull(self.value, other.value), |_, _| WHOLE, |_, _| WHOLE)
    }

    /// Behaviour along a coordinate over the box.
    pub fn along(&self, place: usize) -> Along {
        let [low, high] = Number::at(&self.first, place);
        match () {
            () if low == 0.0 && high == 0.0 => Along::Constant,
            () if is_positive(low, high) => Along::Rising,
            () if is_positive(-high, -low) => Along::Falling,
            () if self.is_convex(place) => Along::Convex,
            () => Along::Unknown,
        }
    }

    /// True if it is convex along a coordinate over the box.
    pub fn is_convex(&self, place: usize) -> bool {
        let [bend, most] = Number::at(&self.second, place);
        is_positive(bend, most)
    }

    /// Bounds of the first derivative along a coordinate.
    pub fn slope(&self, place: usize) -> Interval {
        Number::at(&self.first, place)
    }
}

impl Add for &Number {
    type Output = Number;

    fn add(self, other: &Number) -> Number {
        self.with(other, sum(self.value, other.value), sum, |a, b| sum(a[1], b[1]))
    }
}

impl Neg for &Number {
    type Output = Number;

    fn neg(self) -> Number {
        let minus = |[low, high]: Interval| [-high, -low];
        Number {
            value: minus(self.value),
            first: self.first.iter().copied().map(minus).collect(),
            second: self.second.iter().copied().map(minus).collect(),
        }
    }
}

impl Sub for &Number {
    type Output = Number;

    fn sub(self, other: &Number) -> Number {
        self + &-other
    }
}

impl Mul for &Number {
    type Output = Number;

    fn mul(self, other: &Number) -> Number {
        let (a, b) = (self.value, other.value);
        let twice = |f: Interval, g: Interval| product([2.0; 2], product(f, g));
        self.with(
            other,
            product(a, b),
            |f, g| sum(product(f, b), product(a, g)),
            |f, g| sum(sum(product(f[1], b), product(a, g[1])), twice(f[0], g[0])),
        )
    }
}

impl Mul<f64> for &Number {
    type Output = Number;

    fn mul(self, factor: f64) -> Number {
        let of = |all: &[Interval]| all.iter().map(|x| scaled(*x, factor)).collect();
        Number { value: scaled(self.value, factor), first: of(&self.first), second: of(&self.second) }
    }
}

impl Add<f64> for &Number {
    type Output = Number;

    fn add(self, more: f64) -> Number {
        Number { value: sum(self.value, [more; 2]), ..self.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function of two coordinates in which every operation occurs.
    fn function(x: &Number, y: &Number) -> Number {
        let root = (&x.square() + 1.0).sqrt();
        let part = &(&root * &y.recip()) - &(x * &(y * 0.5));
        part.max(&(x - y)).min(&(y * 3.0))
    }

    fn plain(x: f64, y: f64) -> f64 {
        ((x * x + 1.0).sqrt() / y - x * 0.5 * y).max(x - y).min(3.0 * y)
    }

    #[test]
    fn values_and_derivatives_lie_within_their_bounds() {
        let boxes =
            [[[0.1, 0.4], [1.0, 1.3]], [[-1.0, 2.0], [0.5, 4.0]], [[2.0, 3.0], [0.2, 0.3]], [[5.0, 9.0], [1.0, 2.0]]];
        for [xs, ys] in boxes {
            let (x, y) = (Number::coordinate(0, xs, 1.0), Number::coordinate(1, ys, 1.0));
            let f = function(&x, &y);
            let step = 1e-4;
            for i in 0..=20 {
                for j in 0..=20 {
                    let inside = |[a, b]: Interval, k: i32| a + step + (b - a - 2.0 * step) * f64::from(k) / 20.0;
                    let (u, v) = (inside(xs, i), inside(ys, j));
                    let here = plain(u, v);
                    assert!(f.value[0] <= here && here <= f.value[1], "{here} {:?}", f.value);
                    for (place, [a, b]) in
                        [[plain(u - step, v), plain(u + step, v)], [plain(u, v - step), plain(u, v + step)]]
                            .into_iter()
                            .enumerate()
                    {
                        let slope = (b - a) / (2.0 * step);
                        let [low, high] = f.slope(place);
                        assert!(low - 1e-6 <= slope && slope <= high + 1e-6, "{slope} {low} {high}");
                        let bend = (a + b - 2.0 * here) / (step * step);
                        match f.along(place) {
                            Along::Rising => assert!(b >= a - 1e-12),
                            Along::Falling => assert!(b <= a + 1e-12),
                            Along::Convex => assert!(bend >= -1e-5, "{bend}"),
                            Along::Constant => assert_eq!(a, b),
                            Along::Unknown => {}
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn monotone_and_convex_functions_are_known_as_such() {
        let k = Number::coordinate(0, [0.9, 1.1], 1.0);
        assert_eq!(k.recip().along(0), Along::Falling);
        assert_eq!(k.square().along(0), Along::Rising);
        // |v|² in the constant of torque and back-EMF: a²/K² + 2 a e + e² K².
        let both = &(&k.recip() * 1.0) + &(&k * 1.0);
        assert_eq!(both.along(0), Along::Convex);
        assert_eq!((&both * -1.0).along(0), Along::Unknown);
        assert_eq!(both.along(1), Along::Constant);
    }
}
