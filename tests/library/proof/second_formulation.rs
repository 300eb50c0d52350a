//! The ratio program a second time, in another formulation: variables N and w = 1/N, not N² and its
//! powers.
//!
//! Shaft torque is affine, `T = φτ w + (J α + b ω) N + c sgn ω`, and so are current and quadrature voltage. The
//! product `N w` is one; `s = N²` stands between its tangent and its secant. A convex square is above its
//! tangent, a concave one above its secant over the range of its torque. So on an interval of N every limit and
//! every objective has an affine underestimate in (w, N), whose least value over the arc w = 1/N is at an end
//! or where it is flat. Intervals are halved until nothing better than the best point found can be left.
//! Neither the crate's polynomials nor a solver are used: the random cases and their raw waveforms only.

use gearwise::catalog::convention::{Commutation, Modulation};
use gearwise::design::answer::Reason;
use gearwise::requirement::*;
use rayon::prelude::*;

use crate::raw::{self, Case, Heat, draw};
use crate::solved;

/// `w` times the first, `N` times the second, and the third.
type Plane = [f64; 3];

fn add(a: Plane, b: Plane, times: f64) -> Plane {
    [0, 1, 2].map(|i| a[i] + times * b[i])
}

/// An interval of ratios, and the ratio at which planes touch.
#[derive(Clone, Copy)]
struct Interval {
    a: f64,
    b: f64,
    at: f64,
}

impl Interval {
    fn new(a: f64, b: f64) -> Interval {
        Interval { a, b, at: 0.5 * (a + b) }
    }

    /// Least value of a plane over the arc.
    fn least(&self, plane: Plane) -> f64 {
        let value = |n: f64| plane[0] / n + plane[1] * n + plane[2];
        let flat = (plane[0] / plane[1]).sqrt();
        let ends = value(self.a).min(value(self.b));
        if plane[0] > 0.0 && plane[1] > 0.0 && flat > self.a && flat < self.b { ends.min(value(flat)) } else { ends }
    }

    fn most(&self, plane: Plane) -> f64 {
        -self.least(plane.map(|c| -c))
    }

    /// Below N² times a factor.
    fn square_of_ratio(&self, factor: f64) -> Plane {
        let Interval { a, b, at } = *self;
        if factor >= 0.0 {
            [0.0, 2.0 * at * factor, -at * at * factor]
        } else {
            [0.0, (a + b) * factor, -a * b * factor]
        }
    }

    /// Below the square of a plane times a factor.
    fn square(&self, plane: Plane, factor: f64) -> Plane {
        if factor >= 0.0 {
            let here = plane[0] / self.at + plane[1] * self.at + plane[2];
            return add([0.0, 0.0, -here * here * factor], plane, 2.0 * here * factor);
        }
        let (low, high) = (self.least(plane), self.most(plane));
        add([0.0, 0.0, -low * high * factor], plane, (low + high) * factor)
    }

    /// Below the square of `c0 + c1 N + c2 N²`: above the tangent of the square, whose slope says on which side
    /// of N² to be.
    fn square_of_quadratic(&self, c: [f64; 3]) -> Plane {
        let here = c[0] + c[1] * self.at + c[2] * self.at * self.at;
        let linear = [0.0, 2.0 * here * c[1], 2.0 * here * c[0] - here * here];
        add(linear, self.square_of_ratio(2.0 * here * c[2]), 1.0)
    }
}

/// One sample: torque and quadrature voltage of the hottest and of the coldest winding as planes, and the output's speed.
struct Sample {
    torque: Plane,
    voltage: [Plane; 2],
    speed: f64,
    share: [f64; 2],
}

/// A limit: the demand's underestimate, and its bound in the same unit.
struct Problem<'a> {
    case: &'a Case,
    /// As limits see them, with friction either way at standstill, and as means do.
    most: Vec<Sample>,
    usual: Vec<Sample>,
    rippled: Vec<Sample>,
    copper: f64,
    hot_copper: f64,
    cold_copper: f64,
    emf: f64,
    cross: f64,
    inertia: f64,
    bounds: Bounds,
    duration: f64,
    min: f64,
    max: f64,
}

/// What is allowed; infinite where nothing is asked.
struct Bounds {
    torque: f64,
    rippled_torque: f64,
    rms: f64,
    holding: f64,
    own: f64,
    voltage: f64,
    rippled_voltage: f64,
    power: f64,
    back: f64,
    rise: Option<f64>,
    mass: f64,
}

const NONE: f64 = f64::INFINITY;

impl<'a> Problem<'a> {
    /// `None` where a limit that no ratio changes is exceeded.
    fn new(case: &'a Case) -> Option<Problem<'a>> {
        let (motor, bus, joint) = (&case.motor, &case.robot.bus, &case.robot.joints[0]);
        let (gear, asked, r, k_t) = (&joint.gear, &joint.limits, motor.resistance, motor.torque_constant);
        let brushless = motor.conventions.commutation == Commutation::Brushless;
        let inductance = motor.inductance;
        let poles = motor.pole_pairs.filter(|_| brushless).map_or(0.0, f64::from);
        let (l, j) = (inductance.unwrap_or(0.0), motor.rotor_inertia? + gear.inertia);
        let (b, c) = (motor.viscous_friction.unwrap_or(0.0), motor.coulomb_friction.unwrap_or(0.0));
        // Power taken sees the winding at its hottest, power returned one at ambient temperature, and the voltage both.
        let r_hot = r * raw::hottest_factor(motor, asked.winding_temperature);
        let warmer = case.robot.ambient - motor.reference_temperature;
        let r_cold = r_hot.min(r * (1.0 + raw::copper(motor.reference_temperature) * warmer));
        let passed =
            |p: &Point| if p.torque * p.velocity < 0.0 { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
        let sample = |p: &Point, share: [f64; 2], rubs: f64, phi: f64| {
            let torque = [phi * p.torque, j * p.acceleration + b * p.velocity, rubs];
            let rate = [phi * p.torque_rate, j * p.jerk + b * p.acceleration, 0.0];
            let voltage = [r_hot, r_cold].map(|r| {
                let mut voltage = add(torque.map(|x| x * r / k_t), rate, l / k_t);
                voltage[1] += motor.emf_constant() * p.velocity;
                voltage
            });
            Sample { torque, voltage, speed: p.velocity, share }
        };
        let ways = |p: &Point| match p.velocity {
            v if v > 0.0 => vec![c],
            v if v < 0.0 => vec![-c],
            _ => vec![c, -c],
        };
        let every = |list: &[Point]| -> Vec<Sample> {
            list.iter()
                .flat_map(|p| ways(p).into_iter().map(|rubs| sample(p, [0.0; 2], rubs, passed(p))).collect::<Vec<_>>())
                .collect()
        };
        let moving = |p: &Point| if p.velocity == 0.0 { 0.0 } else { c.copysign(p.velocity) };
        let usual: Vec<Sample> = {
            let in_means = |p: &Point| if p.velocity == 0.0 { 1.0 } else { passed(p) };
            case.raw.iter().zip(&case.shares).map(|(p, s)| sample(p, *s, moving(p), in_means(p))).collect()
        };
        let timed = joint.motion.course != Course::Points(None);
        let steady = timed && !matches!(joint.motion.course, Course::Once(_));
        // What the phase that is worst off at standstill counts for more.
        let ways = (motor.sheet.thermal_resistance_winding_housing, motor.sheet.thermal_resistance_housing_ambient);
        let own = if let (Some(a), Some(b)) = ways { a.value / (a.value + b.value) } else { 1.0 };
        let least = |list: &[Option<f64>]| list.iter().flatten().copied().fold(NONE, f64::min);
        let amplitude = if brushless { 1.5_f64.sqrt() } else { 1.0 };
        let drive = joint.drive_current.or(bus.drive_current).map(|i| i * amplitude * k_t);
        let peak = least(&[motor.peak_current.map(|i| i * k_t), drive]);
        let circle = match (brushless, bus.modulation) {
            (false, _) => 1.0,
            (true, Modulation::Sine) => 0.375_f64.sqrt(),
            (true, Modulation::SpaceVector) => 0.5_f64.sqrt(),
        };
        let hot = raw::hottest(motor, asked.winding_temperature);
        let resistance = r * (1.0 + raw::copper(motor.reference_temperature) * (hot - motor.reference_temperature));
        let by_heat = motor.thermal_resistance.map(|r_th| ((hot - case.robot.ambient) / (r_th * resistance)).sqrt());
        let heating = least(&[motor.continuous_current, by_heat]) * k_t;
        let stands = brushless && case.shares.iter().any(|s| s[1] > 0.0);
        let volt = bus.voltage * bus.modulation_limit * circle;
        let ripples = asked.torque_bandwidth.is_some();
        let only = |bound: f64, applies: bool| if applies { bound } else { NONE };
        let bounds = Bounds {
            torque: peak.min(motor.peak_torque.unwrap_or(NONE)) / asked.safety,
            rippled_torque: only(peak / asked.safety, ripples),
            rms: only(heating.min(motor.continuous_torque.unwrap_or(NONE)), steady),
            holding: only(
                if heating < NONE { heating } else { motor.continuous_torque.unwrap_or(NONE) },
                steady && stands,
            ),
            own,
            voltage: volt,
            rippled_voltage: only(volt, ripples && inductance.is_some()),
            power: least(&[bus.power, bus.current.map(|i| i * bus.voltage)]) * bus.drive_efficiency,
            back: if let Regeneration::Limited(watt) = bus.regeneration { watt / bus.drive_efficiency } else { NONE },
            rise: case.nodes().map(|_| (hot - case.robot.ambient).max(0.0)),
            mass: asked.actuator_mass.unwrap_or(NONE),
        };
        // What no ratio changes, and what is a bound on the ratio itself.
        let fastest = case.raw.iter().map(|p| p.velocity.abs()).fold(0.0, f64::max);
        let strongest = case.raw.iter().map(|p| p.torque.abs()).fold(0.0, f64::max);
        let rms: f64 = case.raw.iter().zip(&case.shares).map(|(p, s)| s[0] * p.torque.powi(2)).sum();
        if asked.safety * strongest > gear.peak_torque.unwrap_or(NONE)
            || timed && rms.sqrt() > gear.continuous_torque.unwrap_or(NONE)
        {
            return None;
        }
        let RatioChoice::Continuous { min, max } = joint.ratio else { return None };
        let by_speed = least(&[motor.max_speed, gear.max_input_speed]) / fastest;
        let by_inertia = (asked.reflected_inertia.unwrap_or(NONE) / j).sqrt();
        Some(Problem {
            case,
            most: every(&case.raw),
            usual,
            rippled: every(&case.rippled),
            copper: r / (k_t * k_t),
            hot_copper: r_hot / (k_t * k_t),
            cold_copper: r_cold / (k_t * k_t),
            emf: motor.emf_constant() / k_t,
            cross: poles * l / k_t,
            inertia: j,
            bounds,
            duration: joint.motion.duration().unwrap_or(0.0),
            min,
            max: max.min(by_speed).min(by_inertia),
        })
    }

    /// Mass of gear and motor up to a ratio, which only steps.
    fn mass(&self, n: f64) -> f64 {
        let gear = &self.case.robot.joints[0].gear;
        let of_gear = match gear.mass_per_stage {
            Some((mass, ratio)) => mass * (0..99).map(f64::from).find(|k| n <= ratio.powf(k + 1e-12)).unwrap(),
            None => gear.mass.unwrap_or(0.0),
        };
        self.case.motor.mass.unwrap() + of_gear
    }

    /// Below the power of a sample times a factor: `R i² + K_B N ω i`, in which N T is `A + B N² + C N`.
    fn power(&self, on: &Interval, s: &Sample, factor: f64, copper: f64) -> Plane {
        let turning = factor * self.emf * s.speed;
        let copper = on.square(s.torque, factor * copper);
        let plane = add(copper, [0.0, turning * s.torque[2], turning * s.torque[0]], 1.0);
        add(plane, on.square_of_ratio(turning * s.torque[1]), 1.0)
    }

    fn power_at(&self, s: &Sample, n: f64, copper: f64) -> f64 {
        let torque = s.torque[0] / n + s.torque[1] * n + s.torque[2];
        copper * torque * torque + self.emf * n * s.speed * torque
    }

    /// Whether no ratio of an interval can keep all limits.
    fn is_out(&self, on: &Interval) -> bool {
        let b = &self.bounds;
        let torque = |list: &[Sample], bound: f64| {
            list.iter().any(|s| on.least(s.torque) > bound || on.least(s.torque.map(|x| -x)) > bound)
        };
        let voltage = |list: &[Sample], bound: f64| {
            bound < NONE
                && list.iter().any(|s| {
                    let d = self.cross * s.speed;
                    let direct = on.square_of_quadratic([d * s.torque[0], d * s.torque[2], d * s.torque[1]]);
                    s.voltage.iter().any(|own| on.least(add(on.square(*own, 1.0), direct, 1.0)) > bound * bound)
                })
        };
        let mean = |at_rest: f64| {
            let squares = self.usual.iter().map(|s| on.square(s.torque, s.share[0] + at_rest * s.share[1]));
            on.least(squares.fold([0.0; 3], |sum, plane| add(sum, plane, 1.0)))
        };
        torque(&self.most, b.torque)
            || torque(&self.rippled, b.rippled_torque)
            || voltage(&self.most, b.voltage)
            || voltage(&self.rippled, b.rippled_voltage)
            || b.power < NONE && self.most.iter().any(|s| on.least(self.power(on, s, 1.0, self.hot_copper)) > b.power)
            || b.back < NONE && self.most.iter().any(|s| on.least(self.power(on, s, -1.0, self.cold_copper)) > b.back)
            || b.rms < NONE && mean(0.0) > b.rms * b.rms
            || b.holding < NONE && mean(b.own) > b.holding * b.holding
            || self.mass(on.b) > b.mass && self.mass(on.a * (1.0 + 1e-9)) > b.mass
            || b.rise.is_some_and(|rise| self.coolest(on) > rise)
    }

    /// The rise that the least heat of every sample would lead to: more heat nowhere cools.
    fn coolest(&self, on: &Interval) -> f64 {
        let least = |s: &Sample| {
            let (low, high) = (on.least(s.torque), on.most(s.torque));
            self.copper * if low * high <= 0.0 { 0.0 } else { low.abs().min(high.abs()).powi(2) }
        };
        let mut samples = self.usual.iter();
        let heat: Heat = self.case.heat(self.min, |_| least(samples.next().unwrap()));
        self.case.nodes().map_or(0.0, |nodes| nodes.peak(&heat))
    }

    fn weight(&self, quantity: Quantity) -> f64 {
        self.case.robot.joints[0].objective.weight(quantity)
    }

    /// The objective at a ratio.
    fn objective(&self, n: f64) -> f64 {
        let torque = |s: &Sample| s.torque[0] / n + s.torque[1] * n + s.torque[2];
        let eta = self.case.robot.bus.drive_efficiency;
        let loss: f64 = self.usual.iter().map(|s| s.share[0] * self.copper * torque(s).powi(2)).sum();
        let drawn = |s: &Sample| (self.power_at(s, n, self.copper) / eta).max(self.power_at(s, n, self.copper) * eta);
        let energy: f64 = self.usual.iter().map(|s| s.share[0] * drawn(s)).sum();
        let current = self.most.iter().map(|s| torque(s).abs()).fold(0.0, f64::max) / self.case.motor.torque_constant;
        let power = self.most.iter().map(|s| self.power_at(s, n, self.hot_copper)).fold(0.0, f64::max) / eta;
        self.weight(Quantity::CopperLoss) * loss
            + self.weight(Quantity::Energy) * energy * self.duration
            + self.weight(Quantity::PeakCurrent) * current
            + self.weight(Quantity::PeakPower) * power
            + self.weight(Quantity::ReflectedInertia) * self.inertia * n * n
            + self.weight(Quantity::Mass) * self.mass(n)
    }

    /// Below the objective on an interval within one stage.
    fn bound(&self, on: &Interval) -> f64 {
        let weight = |quantity| self.weight(quantity);
        let eta = self.case.robot.bus.drive_efficiency;
        let mut plane = on.square_of_ratio(weight(Quantity::ReflectedInertia) * self.inertia);
        plane[2] += weight(Quantity::Mass) * self.mass(on.b);
        for s in &self.usual {
            plane = add(plane, on.square(s.torque, weight(Quantity::CopperLoss) * s.share[0] * self.copper), 1.0);
            if weight(Quantity::Energy) > 0.0 {
                let factor = if self.power_at(s, on.at, self.copper) > 0.0 { 1.0 / eta } else { eta };
                let factor = factor * s.share[0] * self.duration * weight(Quantity::Energy);
                plane = add(plane, self.power(on, s, factor, self.copper), 1.0);
            }
        }
        // A largest is above each of its samples: those that lead at the ends and in the middle.
        let mut planes = vec![plane];
        if weight(Quantity::PeakCurrent) > 0.0 {
            let leads = [on.a, on.at, on.b].map(|n| {
                let torque = |s: &Sample| s.torque[0] / n + s.torque[1] * n + s.torque[2];
                let lead = self.most.iter().max_by(|x, y| torque(x).abs().total_cmp(&torque(y).abs())).unwrap();
                (lead.torque, torque(lead).signum() * weight(Quantity::PeakCurrent) / self.case.motor.torque_constant)
            });
            planes = planes.iter().flat_map(|p| leads.map(|(torque, times)| add(*p, torque, times))).collect();
        }
        if weight(Quantity::PeakPower) > 0.0 {
            let leads = [on.a, on.at, on.b].map(|n| {
                let power = |s: &Sample| self.power_at(s, n, self.hot_copper);
                self.most.iter().max_by(|x, y| power(x).total_cmp(&power(y))).unwrap()
            });
            let factor = weight(Quantity::PeakPower) / eta;
            let with = |p: &Plane| leads.map(|lead| add(*p, self.power(on, lead, factor, self.hot_copper), 1.0));
            planes = planes.iter().flat_map(|p| with(p).into_iter().chain([*p])).collect();
        }
        planes.into_iter().map(|plane| on.least(plane)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The objective's size in the middle of the range, for where it vanishes.
    fn usual(&self) -> f64 {
        let ratios = [self.min, (self.min * self.max).sqrt(), self.max];
        ratios.map(|n| self.objective(n).abs()).into_iter().fold(0.0, f64::max)
    }

    /// The best ratio and its objective; `None` where there is none; an error where it cannot be told.
    fn solve(&self) -> Result<Option<(f64, f64)>, String> {
        if self.max < self.min {
            return Ok(None);
        }
        let mut cuts = vec![self.min, self.max];
        if let Some((_, ratio)) = self.case.robot.joints[0].gear.mass_per_stage {
            cuts.extend((0..40).map(|k| ratio.powi(k)).filter(|n| (self.min..self.max).contains(n)));
        }
        cuts.sort_by(f64::total_cmp);
        let mut best: Option<(f64, f64)> = None;
        let offer = |n: f64, best: &mut Option<(f64, f64)>| {
            let value = self.objective(n);
            if best.is_none_or(|(_, least)| value < least) && self.case.worst(n).0 <= 1e-12 {
                *best = Some((n, value));
            }
        };
        for n in &cuts {
            offer(*n, &mut best);
        }
        let mut open: Vec<(f64, Interval)> = Vec::new();
        for pair in cuts.windows(2) {
            let on = Interval::new(pair[0], pair[1]);
            open.push((f64::NEG_INFINITY, on));
        }
        // Worth nothing: also what rounding leaves of an objective that vanishes.
        let slack = |least: f64| 1e-8 * least.abs() + 1e-12 * self.usual();
        let mut undecided = 0;
        for _ in 0..200_000 {
            // The most promising first.
            let Some(i) = (0..open.len()).min_by(|i, j| open[*i].0.total_cmp(&open[*j].0)) else { break };
            let (bound, on) = open.swap_remove(i);
            if best.is_some_and(|(_, least)| bound >= least - slack(least)) {
                continue;
            }
            if on.b - on.a < 1e-13 * on.b {
                undecided += 1;
                continue;
            }
            for half in [Interval::new(on.a, on.at), Interval::new(on.at, on.b)] {
                if self.is_out(&half) {
                    continue;
                }
                offer(half.at, &mut best);
                offer(half.b, &mut best);
                let bound = self.bound(&half).max(bound);
                if best.is_none_or(|(_, least)| bound < least - slack(least)) {
                    open.push((bound, half));
                }
            }
        }
        match (best, open.len(), undecided) {
            (best, 0, 0) => Ok(best),
            (best, left, points) => Err(format!("{left} intervals left, {points} undecided, best {best:?}")),
        }
    }
}

/// Whether both agree; an error says how not.
fn compare(case: &Case) -> Result<Option<f64>, String> {
    let problem = Problem::new(case);
    let mine = problem.as_ref().map_or(Ok(None), Problem::solve)?;
    match (mine, solved::solve(&case.motor, &case.robot)) {
        (Some((_, value)), Ok(found)) => {
            let theirs = found.optimum.objective;
            let usual = problem.map_or(0.0, |problem| problem.usual());
            let size = value.abs().max(1e-6 * usual).max(f64::MIN_POSITIVE);
            Ok(Some((theirs - value) / size))
        }
        (None, Err(Reason::Infeasible(_))) => Ok(None),
        (mine, found) => Err(format!("{mine:?} {:?}", found.map(|found| found.optimum))),
    }
}

fn run(cases: std::ops::Range<u64>, convex: bool) {
    // Samples of this formulation stand or move at every ratio alike.
    let drawn = cases.into_par_iter().map(|i| (i, draw(i, convex))).filter(|(_, case)| !case.has_slow_motion());
    let found: Vec<_> = drawn.map(|(i, case)| (i, compare(&case))).collect();
    let apart: Vec<(u64, f64)> = found.iter().filter_map(|(i, f)| Some((*i, f.clone().ok()??))).collect();
    let most = apart.iter().map(|x| x.1.abs()).fold(0.0, f64::max);
    let undecided = found.iter().filter(|(_, f)| f.is_err()).count();
    println!(
        "{} cases, {} feasible, most apart {most:e}, {undecided} not the same or undecided",
        found.len(),
        apart.len()
    );
    for (i, why) in found.iter().filter_map(|(i, f)| Some((i, f.as_ref().err()?))).take(10) {
        println!("case {i}: {why}");
    }
    let wrong: Vec<_> = apart.iter().filter(|x| x.1.is_nan() || x.1.abs() > 1e-6).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(undecided == 0 && apart.len() * 5 > found.len() * 2);
}

#[test]
fn convex_programs_agree_with_a_formulation_in_the_ratio_and_its_inverse() {
    run(0..1000, true);
}

#[test]
fn other_programs_agree_with_a_formulation_in_the_ratio_and_its_inverse() {
    run(100_000..100_500, false);
}
