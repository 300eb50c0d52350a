//! A region of ratios and springs, and what bounds a term that is not convex on it.

use super::form::{Affine, Form, Point, at, times};
use gearwise_model::actuator::shaft::Flow;

/// Ratios `[a, b]` times a convex polygon in (k, s), `s = k q_rest`. At first it is the trapezoid of all
/// springs; parts are clipped from it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Region {
    /// Ratios.
    pub(super) ratio: [f64; 2],
    /// The polygon's corners (k, s).
    pub(super) corners: Vec<(f64, f64)>,
    /// Linear functions that are not negative on it.
    pub(super) planes: Vec<Affine>,
    /// Linear functions that vanish on it.
    pub(super) equations: Vec<Affine>,
    /// Samples of the motion whose direction of power is the same on it: whether the motor drives.
    pub(super) sides: Vec<(usize, bool)>,
}

impl Region {
    /// Ratios, stiffness \[N·m/rad\], and rest angle \[rad\] counted from the motion's middle.
    pub(super) fn new(ratio: [f64; 2], [k0, k1]: [f64; 2], [q0, q1]: [f64; 2]) -> Region {
        let corners = vec![(k0, k0 * q0), (k1, k1 * q0), (k1, k1 * q1), (k0, k0 * q1)];
        let (mut planes, mut equations) = (Vec::new(), Vec::new());
        if k1 > k0 {
            planes.extend([[-k0, 1.0, 0.0], [k1, -1.0, 0.0]]);
        } else {
            equations.push([-k0, 1.0, 0.0]);
        }
        if q1 > q0 {
            planes.extend([[0.0, -q0, 1.0], [0.0, q1, -1.0]]);
        } else {
            equations.push([0.0, -q0, 1.0]);
        }
        Region { ratio, corners, planes, equations, sides: Vec::new() }
    }

    /// The part on which a linear function is not negative; `None` if there is none.
    pub(super) fn clip(&self, plane: &Affine) -> Option<Region> {
        let value = |c: &(f64, f64)| at(plane, c.0, c.1);
        let mut corners = Vec::with_capacity(self.corners.len() + 1);
        for (i, here) in self.corners.iter().enumerate() {
            let next = &self.corners[(i + 1) % self.corners.len()];
            let (a, b) = (value(here), value(next));
            if a >= 0.0 {
                corners.push(*here);
            }
            if (a < 0.0) != (b < 0.0) {
                let share = a / (a - b);
                corners.push((here.0 + share * (next.0 - here.0), here.1 + share * (next.1 - here.1)));
            }
        }
        if corners.is_empty() {
            return None;
        }
        let mut planes = self.planes.clone();
        planes.push(*plane);
        Some(Region { corners, planes, ..self.clone() })
    }

    /// The part on which a sample's torque in the direction of motion is not negative (`driving`), or not
    /// positive: where it is zero the motor drives, which is left to the part where it does.
    pub(super) fn side(&self, sample: usize, e: &Affine, driving: bool) -> Option<Region> {
        let mut part = self.clip(&times(e, if driving { 1.0 } else { -1.0 }))?;
        part.sides.push((sample, driving));
        Some(part)
    }

    /// Range of the stiffness.
    pub(super) fn stiffness(&self) -> [f64; 2] {
        self.corners.iter().fold([f64::MAX, f64::MIN], |[l, h], c| [l.min(c.0), h.max(c.0)])
    }

    /// Range of the rest angle, counted from the motion's middle; zero without stiffness.
    pub(super) fn rest(&self) -> [f64; 2] {
        let angles = self.corners.iter().filter(|c| c.0 > 0.0).map(|c| c.1 / c.0);
        let [l, h] = angles.fold([f64::MAX, f64::MIN], |[l, h], q| [l.min(q), h.max(q)]);
        // A single rest angle stays one: rounding opens no range.
        if l > h {
            [0.0, 0.0]
        } else if h - l <= 1e-13 * l.abs().max(h.abs()) {
            [l, l]
        } else {
            [l, h]
        }
    }

    /// Its middle.
    pub(super) fn middle(&self) -> Point {
        let count = self.corners.len() as f64;
        let (k, s) = self.corners.iter().fold((0.0, 0.0), |(a, b), c| (a + c.0 / count, b + c.1 / count));
        [self.ratio[0] * self.ratio[1], k, s]
    }

    /// Whether a point lies in it, but for rounding.
    pub(super) fn contains(&self, [u, k, s]: Point) -> bool {
        let n = u.sqrt();
        let not_negative = |p: &Affine| at(p, k, s) >= -1e-12 * (p[0].abs() + (p[1] * k).abs() + (p[2] * s).abs());
        n >= self.ratio[0] * (1.0 - 1e-12) && n <= self.ratio[1] * (1.0 + 1e-12) && self.planes.iter().all(not_negative)
    }

    /// Smallest and largest value of a linear function, a little too wide.
    pub(super) fn range(&self, p: &Affine) -> (f64, f64) {
        let (mut low, mut high, mut size) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for (k, s) in &self.corners {
            let value = at(p, *k, *s);
            low = low.min(value);
            high = high.max(value);
            size = size.max(p[0].abs() + (p[1] * k).abs() + (p[2] * s).abs());
        }
        (low - 1e-15 * size, high + 1e-15 * size)
    }

    /// Adds a lower bound of `c u^(p/2)`, touching it at `z` where it is convex: its tangent, else its
    /// secant.
    pub(super) fn add_power(&self, form: &mut Form, c: f64, p: i32, z: Point) {
        if c == 0.0 {
            return;
        }
        let r = 0.5 * f64::from(p);
        let value = |u: f64| c * u.powf(r);
        let (a, b) = (self.ratio[0].powi(2), self.ratio[1].powi(2));
        let convex = c * r * (r - 1.0) >= 0.0;
        let (through, slope) = if convex {
            let u = z[0].clamp(a, b);
            (u, c * r * u.powf(r - 1.0))
        } else {
            (a, if b > a { (value(b) - value(a)) / (b - a) } else { 0.0 })
        };
        form.add_u(slope);
        form.add_constant(value(through) - slope * through);
    }

    /// Adds a lower bound of `c y N^p` for a linear y, p = ±1: one of McCormick's facets, the one that is
    /// higher at `z`.
    pub(super) fn add_product(&self, form: &mut Form, c: f64, y: &Affine, p: i32, z: Point) {
        if c == 0.0 {
            return;
        }
        // A negative factor goes into y: only under-facets are needed.
        let y = times(y, c);
        let (y_low, y_high) = self.range(&y);
        let (g_a, g_b) = (self.ratio[0].powi(p), self.ratio[1].powi(p));
        let (g_low, g_high) = (g_a.min(g_b), g_a.max(g_b));
        let facet = |of_g: f64, of_y: f64| {
            let mut facet = Form::default();
            self.add_power(&mut facet, of_g, p, z);
            facet.add_affine(&times(&y, of_y));
            facet.add_constant(-of_g * of_y);
            facet
        };
        let (one, other) = (facet(y_low, g_low), facet(y_high, g_high));
        form.add(1.0, if one.at(z) >= other.at(z) { &one } else { &other });
    }
}

/// The load torque behind the gear, `h = φ e`: with the direction of motion as the positive one it is
/// `max(e/η, η_b e)`, convex in e.
#[derive(Debug, Clone, Copy)]
pub(super) enum Geared {
    /// The direction of power is the same everywhere on the region: h is linear.
    Fixed(Flow, Affine),
    /// It is not: the torque e in the direction of motion, its range, and both efficiencies.
    Open {
        e: Affine,
        range: (f64, f64),
        /// 1/η.
        driving: f64,
        /// η_b.
        braking: f64,
    },
}

impl Geared {
    /// Of a torque e, in the direction of motion; at standstill `moves` is false and the motor holds.
    pub(super) fn new(region: &Region, sample: usize, e: Affine, moves: bool, driving: f64, braking: f64) -> Geared {
        let fixed = |flow, factor| Geared::Fixed(flow, times(&e, factor));
        if !moves || driving == braking {
            // Which way power flows makes no difference.
            return fixed(Flow::Driving, driving);
        }
        match region.sides.iter().find(|side| side.0 == sample) {
            Some((_, true)) => return fixed(Flow::Driving, driving),
            Some((_, false)) => return fixed(Flow::Braking, braking),
            None => {}
        }
        let range = region.range(&e);
        if range.0 >= 0.0 {
            fixed(Flow::Driving, driving)
        } else if range.1 < 0.0 {
            fixed(Flow::Braking, braking)
        } else {
            Geared::Open { e, range, driving, braking }
        }
    }

    /// A linear function that is nowhere above `c h`, for the sign of c: the piece that is active at `z`,
    /// or the secant.
    pub(super) fn below(&self, c: f64, z: Point) -> Affine {
        match self {
            Geared::Fixed(_, h) => *h,
            Geared::Open { e, driving, braking, .. } if c >= 0.0 => {
                times(e, if at(e, z[1], z[2]) >= 0.0 { *driving } else { *braking })
            }
            Geared::Open { e, range: (low, high), driving, braking } => {
                let slope = (driving * high - braking * low) / (high - low);
                let mut secant = times(e, slope);
                secant[0] += (braking - slope) * low;
                secant
            }
        }
    }

    /// Adds a lower bound of `h²/u` that touches it at `z`. Where the direction of power is open, h² is the smaller of the two
    /// squares everywhere and more on one side, which is convex in (u, e): its tangent.
    pub(super) fn add_square_over_u(&self, form: &mut Form, weight: f64, z: Point) {
        match self {
            Geared::Fixed(_, h) => form.add_over_u(weight, h),
            Geared::Open { e, driving, braking, .. } => {
                let (forth, back) = (driving * driving, braking * braking);
                form.add_over_u(weight * forth.min(back), e);
                let here = at(e, z[1], z[2]);
                let more = if here >= 0.0 { forth - back } else { back - forth };
                if more > 0.0 {
                    let slope = here / z[0];
                    form.add_affine(&times(e, 2.0 * weight * more * slope));
                    form.add_u(-weight * more * slope * slope);
                }
            }
        }
    }

    /// Range of h over the region.
    pub(super) fn range(&self, region: &Region) -> (f64, f64) {
        match self {
            Geared::Fixed(_, h) => region.range(h),
            Geared::Open { range: (low, high), driving, braking, .. } => {
                // With a negative η_b the torque is positive on both sides.
                ((braking * low).min(0.0), (driving * high).max(braking * low))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the direction of power is open the bound of h²/u touches it at any point and is nowhere above it, whichever way
    /// costs more.
    #[test]
    fn the_square_of_a_geared_torque_that_flips_is_bounded_by_what_touches_it() {
        for (driving, braking) in [(1.25, 0.75), (2.5, -0.5), (1.0, 1.5)] {
            let h = |e: f64| if e >= 0.0 { driving * e } else { braking * e };
            let geared = Geared::Open { e: [1.0, 1.0, -1.0], range: (-9.0, 11.0), driving, braking };
            let points =
                || (0..9).flat_map(|i| (0..9).map(move |j| [0.5 + 2.0 * f64::from(j), f64::from(i) - 5.0, 0.5]));
            let mut strict = 0;
            for z in points() {
                let mut form = Form::default();
                geared.add_square_over_u(&mut form, 3.0, z);
                for other in points() {
                    let exact = 3.0 * h(1.0 + other[1] - other[2]).powi(2) / other[0];
                    assert!(form.at(other) <= exact + 1e-9 * (1.0 + exact));
                    strict += usize::from(form.at(other) < 0.9 * exact);
                }
                let exact = 3.0 * h(1.0 + z[1] - z[2]).powi(2) / z[0];
                assert!((form.at(z) - exact).abs() <= 1e-9 * (1.0 + exact));
            }
            assert!(strict > 0);
        }
    }
}
