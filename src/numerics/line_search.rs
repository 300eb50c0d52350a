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

/// Bottom of the only valley of `f` over a range of positive numbers that may span decades, its ends among what is
/// looked at.
pub fn least_in_range(f: &impl Fn(f64) -> f64, a: f64, b: f64) -> f64 {
    let inside = golden_section(&|ln: f64| f(ln.exp()), a.ln(), b.ln(), FULLY).exp().clamp(a, b);
    [a, b].into_iter().fold(inside, |best, end| if f(end) < f(best) { end } else { best })
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
