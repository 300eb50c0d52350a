//! Search along a line.

/// Narrowings after which nothing but rounding is left.
pub const FULLY: usize = 80;

/// Bottom of a valley of `f` between `a` and `b`, by golden section: the best of what was looked at when the interval
/// has been narrowed to 0.618 of itself `steps` times, or to its last digits.
pub fn golden_section(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64, steps: usize) -> f64 {
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - share * (b - a), a + share * (b - a));
    let (mut fc, mut fd) = (f(c), f(d));
    for _ in 0..steps {
        if fc <= fd {
            (b, d, fd) = (d, c, fc);
            c = b - share * (b - a);
            fc = f(c);
        } else {
            (a, c, fc) = (c, d, fd);
            d = a + share * (b - a);
            fd = f(d);
        }
        if b - a <= 1e-13 * b.abs() {
            break;
        }
    }
    if fc <= fd { c } else { d }
}

/// Where `f` falls to zero between `outside`, where it is above, and `inside`, where it is not: the last places on both sides of
/// it, as close together as `within` (relative). By the ITP rule (Oliveira and Takahashi, ACM TOMS 47 (2020) 5): the secant, moved a
/// little to the middle, and hardly more looks than halving takes.
pub fn crossing(f: &impl Fn(f64) -> f64, outside: f64, inside: f64, within: f64) -> (f64, f64) {
    let (mut above, mut below) = ((outside, f(outside)), (inside, f(inside)));
    let whole = (outside - inside).abs();
    let enough = 0.5 * within * inside.abs().min(outside.abs());
    let mut reach = enough * (0.5 * whole / enough).log2().ceil().max(0.0).exp2() * 2.0;
    while (above.0 - below.0).abs() > 2.0 * enough {
        let (middle, half) = (0.5 * (above.0 + below.0), 0.5 * (above.0 - below.0).abs());
        let secant = (above.0 * below.1 - below.0 * above.1) / (below.1 - above.1);
        let (towards, shift) = ((middle - secant).signum(), 0.2 * (2.0 * half).powi(2) / whole);
        // Where `f` has no number there is no secant.
        let moved = if shift <= (middle - secant).abs() { secant + towards * shift } else { middle };
        let at = if (moved - middle).abs() <= reach - half { moved } else { middle - towards * (reach - half) };
        // At an end nothing more is seen: as far inside as it is to be known.
        let (low, high) = (above.0.min(below.0) + enough, above.0.max(below.0) - enough);
        let at = if at.is_finite() && low < high { at.clamp(low, high) } else { middle };
        if at == above.0 || at == below.0 {
            break;
        }
        let here = f(at);
        if here > 0.0 {
            above = (at, here)
        } else {
            below = (at, here)
        }
        reach *= 0.5;
    }
    (above.0, below.0)
}

/// Bottom of the only valley of `f` over a range of positive numbers that may span decades, its ends among what is
/// looked at.
pub fn least_in_range(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let inside = golden_section(&|ln: f64| f(ln.exp()), a.ln(), b.ln(), FULLY).exp().clamp(a, b);
    [a, b].into_iter().fold(inside, |best, end| if f(end) < f(best) { end } else { best })
}

/// Bottom of the only valley of `f` over a range of positive numbers, to 1e-9 of its place, for functions that take long to evaluate.
pub fn least_in_few_looks(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let inside = brent(&|ln: f64| f(ln.exp()), a.ln(), b.ln()).exp().clamp(a, b);
    [a, b].into_iter().fold(inside, |best, end| if f(end) < f(best) { end } else { best })
}

/// Bottom of a valley of `f` between `a` and `b` to 1e-9, by parabolas through three points and golden sections where these do not
/// shrink the interval: a fifth of the looks of [`golden_section`] where `f` is smooth (Brent, *Algorithms for Minimization without
/// Derivatives*, 1973, chapter 5).
fn brent(f: &impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    const ENOUGH: f64 = 1e-9;
    let share = 0.5 * (3.0 - 5.0_f64.sqrt());
    // The best point, the second and the one before, with their values.
    let mut best = a + share * (b - a);
    let mut least = f(best);
    let (mut second, mut third) = ((best, least), (best, least));
    let (mut step, mut before): (f64, f64) = (0.0, 0.0);
    for _ in 0..2 * FULLY {
        let (middle, enough) = (0.5 * (a + b), ENOUGH * (1.0 + best.abs()));
        if (best - middle).abs() <= 2.0 * enough - 0.5 * (b - a) {
            break;
        }
        let r = (best - second.0) * (least - third.1);
        let q = (best - third.0) * (least - second.1);
        let (rise, fall) = ((best - third.0) * q - (best - second.0) * r, 2.0 * (q - r));
        let parabola = -rise / fall;
        // Less than half of the step before the last, and inside.
        let is_short = parabola.abs() < 0.5 * before.abs();
        before = step;
        if is_short && best + parabola > a && best + parabola < b {
            step = parabola;
            if best + step - a < 2.0 * enough || b - best - step < 2.0 * enough {
                step = enough.copysign(middle - best);
            }
        } else {
            before = if best < middle { b - best } else { a - best };
            step = share * before;
        }
        let at = if step.abs() >= enough { best + step } else { best + enough.copysign(step) };
        let here = f(at);
        if here <= least {
            if at < best {
                b = best
            } else {
                a = best
            }
            (third, second) = (second, (best, least));
            (best, least) = (at, here);
        } else {
            if at < best {
                a = at
            } else {
                b = at
            }
            if here <= second.1 || second.0 == best {
                (third, second) = (second, (at, here));
            } else if here <= third.1 || third.0 == best || third.0 == second.0 {
                third = (at, here);
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_value_over_decades_may_be_at_an_end() {
        for (place, least) in [(30.0, 30.0), (0.02, 0.02), (1e-5, 1e-3), (1e7, 1e4), (1e-3, 1e-3), (1e4, 1e4)] {
            let found = least_in_range(&|x: f64| (x / place).ln().powi(2), 1e-3, 1e4);
            assert!((found / least - 1.0).abs() < 1e-6, "{found} {least}");
        }
        // The ends are reached exactly.
        assert_eq!((least_in_range(&|x: f64| x, 0.3, 7.1), least_in_range(&|x: f64| -x, 0.3, 7.1)), (0.3, 7.1));
        assert_eq!(least_in_range(&|x: f64| x, 2.3, 2.3), 2.3);
    }

    /// A smooth valley takes few looks, a kink no more than golden sections, and places without a number none too many.
    #[test]
    fn a_valley_is_found_in_few_looks() {
        let looks = std::cell::Cell::new(0);
        let of = |f: &dyn Fn(f64) -> f64, place: f64, within: f64| {
            looks.set(0);
            let counted = |x: f64| {
                looks.set(looks.get() + 1);
                f(x)
            };
            let found = least_in_few_looks(&counted, 1.0, 1000.0);
            assert!((found / place - 1.0).abs() <= within, "{found} {place}");
            looks.get()
        };
        for place in [1.7_f64, 20.0, 333.0] {
            let smooth = of(&|x| (place / x).powi(2) + (x / place).powi(2), place, 1e-6);
            assert!(smooth <= 25, "{smooth}");
            let kink = of(&|x| (place / x).max(x / place), place, 1e-8);
            assert!(kink <= 65, "{kink}");
            let none = of(&|x| if x < place { f64::INFINITY } else { x }, place, 1e-8);
            assert!(none <= 65, "{none}");
        }
        assert!(of(&|_| f64::NAN, 1.0, f64::INFINITY) < 2 * FULLY);
    }

    /// To the last places on both sides, with few looks where the function is smooth, and where it has no slope or no number.
    #[test]
    fn a_crossing_is_found_from_both_sides() {
        let looks = std::cell::Cell::new(0);
        let of = |f: &dyn Fn(f64) -> f64, outside: f64, inside: f64, place: f64| {
            looks.set(0);
            let counted = |x: f64| {
                looks.set(looks.get() + 1);
                f(x)
            };
            let (above, below) = crossing(&counted, outside, inside, 1e-12);
            assert!(f(above) > 0.0 && f(below) <= 0.0, "{above} {below}");
            assert!((above - below).abs() <= 1e-12 * below.abs() && (below - place).abs() <= 1e-11 * place, "{below}");
            looks.get()
        };
        for place in [1.1, 2.0, 7.3, 9.99] {
            assert!(of(&|x| x - place, 10.0, 1.0, place) < 15);
            assert!(of(&|x| place / x - 1.0, 1.0, 10.0, place) < 20);
            // Steps have no slope; beyond some place there is no number: as many as halving takes.
            let most = 2 + 3 + (9.0_f64 / 1e-12).log2().ceil() as usize;
            assert!(of(&|x| (place / x).powi(6) - 1.0, 1.0, 10.0, place) <= most);
            assert!(of(&|x| if x > place { 1.0 } else { -1.0 }, 10.0, 1.0, place) <= most);
            assert!(of(&|x| if x > place { f64::INFINITY } else { x - place - 1e-9 }, 10.0, 1.0, place) <= most);
        }
    }

    #[test]
    fn the_bottom_of_a_valley_is_found_to_the_root_of_rounding() {
        let cases = [(2.0, 1.0, 10.0), (9.9, 1.0, 10.0), (1.01, 1.0, 10.0), (-3.0, -7.0, 1.0), (5e6, 1.0, 1e7)];
        for (place, a, b) in cases.into_iter().chain([(2e-6, 1e-6, 1e-5), (-3e-9, -7e-9, -1e-9)]) {
            let found = golden_section(&|x: f64| (x - place).powi(2), a, b, FULLY);
            assert!((found - place).abs() < 1e-7 * (b - a), "{found} {place}");
            // A kink is found to its last digits.
            let found = golden_section(&|x: f64| (x - place).abs(), a, b, FULLY);
            assert!((found - place).abs() < 1e-12 * b.abs().max(a.abs()), "{found} {place}");
        }
        // Monotone functions have their least value at an end.
        assert!(golden_section(&|x: f64| x, 1.0, 2.0, FULLY) < 1.0 + 1e-12);
        assert!(golden_section(&|x: f64| -x, 1.0, 2.0, FULLY) > 2.0 - 1e-12);
    }

    /// Two looks at first and one for each step, each narrowing to the golden share; the best of the last two.
    #[test]
    fn few_steps_look_at_few_points() {
        let share = 0.5 * (5.0_f64.sqrt() - 1.0);
        for steps in [0, 1, 5, 10] {
            for place in [0.2, 0.5, 0.9] {
                let looks = std::cell::RefCell::new(Vec::new());
                let f = |x: f64| {
                    looks.borrow_mut().push(x);
                    (x - place).abs()
                };
                let found = golden_section(&f, 0.0, 1.0, steps);
                let looks = looks.into_inner();
                assert_eq!(looks.len(), 2 + steps);
                let nearest = looks.iter().map(|x| (x - place).abs()).fold(f64::INFINITY, f64::min);
                assert_eq!((found - place).abs(), nearest, "{steps} {place}");
                assert!(nearest <= share.powi(1 + steps as i32), "{steps} {place}");
            }
        }
    }
}
