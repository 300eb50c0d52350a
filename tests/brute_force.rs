//! An independent check of the ratio program: random joints are solved by `design::optimize`, and again
//! here by looking at thousands of ratios, one after the other, straight from the raw waveforms.
//!
//! Nothing of the crate's model is called for the reference: shaft torque, current, voltage, power, means
//! over time, efficiency, friction and every limit are computed below in the plainest way, without
//! polynomials in the ratio, convexity or solver; only data types are shared. Case `i` is drawn from the
//! generator seeded with `i`, so a failure is reproduced by its number.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use gearwise::catalog::convention::{Commutation, Modulation};
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::optimize::{Reason, optimize};
use gearwise::design::program::{Certificate, Infeasible};
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// Ratios that are looked at before refining.
const RATIOS: usize = 2001;
/// Cases whose least violation is nearer to zero are too close to call …
const CLOSE: f64 = 1e-7;
/// … as are those whose windows are all narrower (relative).
const NARROW: f64 = 1e-6;

// ------------------------------------------------------------------ the model, from raw waveforms

/// A sample at the gear's input: what is left when the ratio is taken out. `load` is φ τ and φ τ̇, `own`
/// is (J_m + J_g) α + b ω and its rate, `weight` and `dwell` are shares of the time.
struct Wave {
    load: [f64; 2],
    own: [f64; 2],
    speed: f64,
    weight: f64,
    dwell: f64,
}

/// A motor at the only joint of a robot, the motion sample by sample, and what follows from it.
struct Case {
    motor: Motor,
    robot: Robot,
    time: Vec<f64>,
    raw: Vec<Point>,
    waves: Vec<Wave>,
    rippled: Vec<Wave>,
}

/// A ratio, looked at: what it is worth, and every limit with name, demand and, where it applies, bound.
struct Look {
    objective: f64,
    loss: f64,
    peak_current: f64,
    limits: [(&'static str, f64, Option<f64>); 18],
}

impl Case {
    fn new(motor: Motor, robot: Robot, time: Vec<f64>, raw: Vec<Point>) -> Case {
        let mut case = Case { motor, robot, time, raw, waves: Vec::new(), rippled: Vec::new() };
        for k in 0..case.raw.len() {
            let p = case.raw[k];
            case.waves.push(case.wave(k, [p.torque, p.torque_rate]));
            // The superposed torque at 32 phases.
            let Some(TorqueBandwidth { frequency, amplitude }) = case.joint().limits.torque_bandwidth else { continue };
            for step in 0..32 {
                let (sin, cos) = (TAU * f64::from(step) / 32.0).sin_cos();
                let tau = [p.torque + amplitude * cos, p.torque_rate - amplitude * TAU * frequency * sin];
                case.rippled.push(case.wave(k, tau));
            }
        }
        case
    }

    fn joint(&self) -> &Joint {
        &self.robot.joints[0]
    }

    fn inertia(&self) -> f64 {
        self.motor.rotor_inertia.unwrap() + self.joint().gear.inertia
    }

    fn wave(&self, k: usize, tau: [f64; 2]) -> Wave {
        let (p, gear) = (self.raw[k], &self.joint().gear);
        let phi = if tau[0] * p.velocity < 0.0 { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
        let own = |rate, speed| self.inertia() * rate + self.motor.viscous_friction.unwrap_or(0.0) * speed;
        let own = [own(p.acceleration, p.velocity), own(p.jerk, p.acceleration)];
        let (weight, dwell) = self.shares(k);
        Wave { load: tau.map(|t| phi * t), own, speed: p.velocity, weight, dwell }
    }

    /// Which share of the time sample k stands for: half of the intervals before and after it (points:
    /// their duration); and which share in intervals that stand still at both ends.
    fn shares(&self, k: usize) -> (f64, f64) {
        let (n, still, time) = (self.raw.len(), |k: usize| self.raw[k].velocity == 0.0, &self.time);
        let (before, after, total) = match self.joint().motion.course {
            Course::Points(_) => {
                let all: f64 = self.raw.iter().map(|p| p.duration.unwrap_or(1.0)).sum();
                let share = self.raw[k].duration.unwrap_or(1.0) / all;
                return (share, if still(k) { share } else { 0.0 });
            }
            Course::Periodic(period) => {
                let before = if k > 0 { time[k - 1] } else { time[n - 1] - period };
                (before, if k + 1 < n { time[k + 1] } else { time[0] + period }, period)
            }
            Course::Once(_) => (time[k.max(1) - 1], time[(k + 1).min(n - 1)], time[n - 1] - time[0]),
        };
        let halves =
            [(0.5 * (time[k] - before) / total, (k + n - 1) % n), (0.5 * (after - time[k]) / total, (k + 1) % n)];
        (halves[0].0 + halves[1].0, halves.iter().filter(|half| still(k) && still(half.1)).map(|half| half.0).sum())
    }

    fn mass(&self, n: f64) -> f64 {
        let gear = &self.joint().gear;
        let stages = |ratio: f64| (0..99).map(f64::from).find(|k| n <= ratio.powf(*k) * (1.0 + 1e-9)).unwrap();
        let of_gear = gear.mass_per_stage.map_or_else(|| gear.mass.unwrap(), |(mass, ratio)| mass * stages(ratio));
        self.motor.mass.unwrap() + of_gear
    }

    fn brushless(&self) -> bool {
        self.motor.conventions.commutation == Commutation::Brushless
    }

    /// q-axis volt per volt of the bus, q-axis ampere per ampere of the drive.
    fn drive(&self) -> (f64, f64) {
        let (bus, brushless) = (&self.robot.bus, self.brushless());
        let circle = if bus.modulation == Modulation::Sine { (3.0_f64 / 8.0).sqrt() } else { 0.5_f64.sqrt() };
        (bus.modulation_limit * if brushless { circle } else { 1.0 }, if brushless { 1.5_f64.sqrt() } else { 1.0 })
    }

    fn resistance_at(&self, kelvin: f64) -> f64 {
        self.motor.resistance * (1.0 + 0.0039 * (kelvin - self.motor.reference_temperature))
    }

    fn look(&self, n: f64) -> Look {
        let (motor, bus, joint) = (&self.motor, &self.robot.bus, self.joint());
        let (gear, asked, r, k_t) = (&joint.gear, &joint.limits, motor.resistance, motor.torque_constant);
        // Without inductance or pole pairs the voltage is that of resistance and back-EMF.
        let poles = if self.brushless() { motor.pole_pairs.map(f64::from) } else { Some(0.0) };
        let inductive = motor.inductance.zip(poles);
        let (l, p) = inductive.unwrap_or((0.0, 0.0));
        let friction = motor.coulomb_friction.unwrap_or(0.0);
        let smooth = |w: &Wave| w.load[0] / n + n * w.own[0];
        // Peak torque of a sample and the voltage it takes. At standstill friction opposes the motor.
        let peak = |w: &Wave| {
            let torque = smooth(w) + friction.copysign(if w.speed == 0.0 { smooth(w) } else { w.speed });
            let (i, rate) = (torque / k_t, (w.load[1] / n + n * w.own[1]) / k_t);
            let v_q = r * i + l * rate + motor.back_emf_constant * n * w.speed;
            let v_d = -p * n * w.speed * l * i;
            (torque, (v_q * v_q + v_d * v_d).sqrt())
        };
        let (mut torque, mut voltage, mut power, mut back) = (0.0_f64, 0.0_f64, f64::MIN, f64::MIN);
        let (mut square, mut at_rest, mut load_square, mut fastest, mut strongest) = (0.0, 0.0, 0.0, 0.0_f64, 0.0_f64);
        let mut stands = false;
        for (w, raw) in self.waves.iter().zip(&self.raw) {
            let (t, v) = peak(w);
            let watt = r * (t / k_t) * (t / k_t) + motor.back_emf_constant * n * w.speed * t / k_t;
            (torque, voltage, power, back) = (torque.max(t.abs()), voltage.max(v), power.max(watt), back.max(-watt));
            // For heat there is no friction at standstill.
            let heating = if w.speed == 0.0 { smooth(w) } else { t };
            square += w.weight * heating * heating;
            at_rest += w.dwell * heating * heating;
            load_square += w.weight * raw.torque * raw.torque;
            (fastest, strongest) = (fastest.max(w.speed.abs()), strongest.max(raw.torque.abs()));
            stands |= w.dwell > 0.0 && self.brushless();
        }
        let (mut ripple_torque, mut ripple_voltage) = (0.0_f64, 0.0_f64);
        for (t, v) in self.rippled.iter().map(peak) {
            (ripple_torque, ripple_voltage) = (ripple_torque.max(t.abs()), ripple_voltage.max(v));
        }
        // The bounds.
        let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
        let max_current =
            least(motor.peak_current, joint.drive_current.or(bus.drive_current).map(|i| i * self.drive().1));
        let hot = least(motor.max_winding_temperature, asked.winding_temperature).zip(motor.thermal_resistance);
        let hot = hot.map(|(hot, r_th)| ((hot - self.robot.ambient) / (r_th * self.resistance_at(hot))).sqrt());
        let (rippled, timed) = (asked.torque_bandwidth.is_some(), joint.motion.course != Course::Points(None));
        let regeneration = if let Regeneration::Limited(watt) = bus.regeneration { Some(watt) } else { None };
        let max_voltage = Some(bus.voltage * self.drive().0);
        let mass = motor.mass.map_or(0.0, |_| self.mass(n));
        let (rms, power, reflected) = (square.sqrt(), power / bus.drive_efficiency, n * n * self.inertia());
        let holding = motor.continuous_current.or(hot).filter(|_| stands && timed);
        let limits = [
            ("peak_current", asked.safety * torque / k_t, max_current),
            ("peak_torque", asked.safety * torque, motor.peak_torque),
            ("continuous_current", rms / k_t, motor.continuous_current.filter(|_| timed)),
            ("continuous_torque", rms, motor.continuous_torque.filter(|_| timed)),
            ("winding_temperature", rms / k_t, hot.filter(|_| timed)),
            ("standstill_holding", (square + at_rest).sqrt() / k_t, holding),
            ("voltage", voltage, max_voltage),
            ("max_speed", n * fastest, motor.max_speed),
            ("gear_input_speed", n * fastest, gear.max_input_speed),
            ("gear_peak_torque", asked.safety * strongest, gear.peak_torque),
            ("gear_continuous_torque", load_square.sqrt(), gear.continuous_torque.filter(|_| timed)),
            ("reflected_inertia", reflected, asked.reflected_inertia),
            ("torque_bandwidth_current", asked.safety * ripple_torque / k_t, max_current.filter(|_| rippled)),
            ("torque_bandwidth_voltage", ripple_voltage, max_voltage.filter(|_| rippled && inductive.is_some())),
            ("bus_power", power, bus.power),
            ("bus_current", power / bus.voltage, bus.current),
            ("regeneration", back * bus.drive_efficiency, regeneration),
            ("actuator_mass", mass, asked.actuator_mass),
        ];
        let (loss, peak_current) = (r * square / (k_t * k_t), torque / k_t);
        let quantity = |quantity| match quantity {
            Quantity::Loss => loss,
            Quantity::ReflectedInertia => reflected,
            Quantity::PeakCurrent => peak_current,
            Quantity::Mass => mass,
        };
        let objective = joint.objective.terms.iter().map(|(q, weight)| weight * quantity(*q)).sum();
        Look { objective, loss, peak_current, limits }
    }

    /// By how much the worst limit is exceeded (absolutely, where nothing is allowed), and which it is.
    fn worst(&self, n: f64) -> (f64, &'static str) {
        let over = |demand: f64, bound: f64| if bound > 0.0 { demand / bound - 1.0 } else { demand };
        let limits =
            self.look(n).limits.into_iter().filter_map(|(name, demand, bound)| Some((over(demand, bound?), name)));
        limits.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }
}

// ------------------------------------------------------------------ the scan

/// Golden section for the least of `f` between two ratios.
fn golden(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    for _ in 0..60 {
        let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
        (a, b) = if f(c) <= f(d) { (a, d) } else { (c, b) };
    }
    0.5 * (a + b)
}

/// The least of `f` over the grid within the windows and their ends, refined between neighbours.
fn least_over(windows: &[[f64; 2]], grid: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let within =
        |[a, b]: [f64; 2]| [a].into_iter().chain(grid.iter().copied().filter(move |n| a < *n && *n < b)).chain([b]);
    let seen: Vec<Vec<[f64; 2]>> = windows.iter().map(|w| within(*w).map(|n| [n, f(n)]).collect()).collect();
    let mut best = seen.iter().flatten().map(|at| at[1]).fold(f64::INFINITY, f64::min);
    for window in seen {
        for (i, here) in window.iter().enumerate() {
            let (before, after) = (window[i.saturating_sub(1)], window[(i + 1).min(window.len() - 1)]);
            if here[1] <= before[1].min(after[1]) && here[1] <= best * 1.01 {
                best = best.min(f(golden(&f, before[0], after[0])));
            }
        }
    }
    best
}

/// Feasible intervals, the grid with the extrema of the violation added, and the least violation.
fn scan(case: &Case, min: f64, max: f64) -> (Vec<[f64; 2]>, Vec<f64>, (f64, &'static str)) {
    let mut grid: Vec<f64> = (0..RATIOS).map(|i| min * (max / min).powf(i as f64 / (RATIOS - 1) as f64)).collect();
    grid[RATIOS - 1] = max;
    let per_stage = case.joint().gear.mass_per_stage;
    grid.extend(
        per_stage.iter().flat_map(|(_, ratio)| (0..30).map(|k| ratio.powi(k))).filter(|n| (min..max).contains(n)),
    );
    grid.sort_by(f64::total_cmp);
    let mut seen: Vec<[f64; 2]> = grid.iter().map(|&n| [n, case.worst(n).0]).collect();
    let mut extrema = Vec::new();
    for (i, here) in seen.iter().enumerate() {
        // A feasible ratio may hide between infeasible ones, and the other way round.
        let sign = if here[1] > 0.0 { 1.0 } else { -1.0 };
        let (before, after) = (seen[i.saturating_sub(1)], seen[(i + 1).min(seen.len() - 1)]);
        if (i == 0 || sign * here[1] < sign * before[1]) && sign * here[1] <= sign * after[1] {
            let n = golden(|n| sign * case.worst(n).0, before[0], after[0]);
            extrema.push([n, case.worst(n).0]);
        }
    }
    seen.extend(extrema);
    seen.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let edge = |mut bad: f64, mut good: f64| {
        for _ in 0..60 {
            let n = 0.5 * (bad + good);
            *(if case.worst(n).0 > 0.0 { &mut bad } else { &mut good }) = n;
        }
        good
    };
    let mut windows: Vec<[f64; 2]> = Vec::new();
    for (i, &[n, over]) in seen.iter().enumerate() {
        let before = seen[i.saturating_sub(1)];
        match (before[1] > 0.0, over > 0.0) {
            (true, false) => windows.push([edge(before[0], n), n]),
            (false, false) if i == 0 => windows.push([n, n]),
            (false, false) => windows.last_mut().unwrap()[1] = n,
            (false, true) => windows.last_mut().unwrap()[1] = edge(n, before[0]),
            (true, true) => {}
        }
    }
    let least = seen.iter().min_by(|a, b| a[1].total_cmp(&b[1])).map(|at| case.worst(at[0])).unwrap();
    (windows, seen.into_iter().map(|at| at[0]).collect(), least)
}

// ------------------------------------------------------------------ random cases

/// What the cases start from; every number is replaced.
const MOTOR: &str = "id,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A]
m,s,derived,q_axis,q_axis,1,1
";
const ROBOT: &str = "name = 'r'
[bus]
voltage = '1 V'
[[joint]]
name = 'j'
ratio = { min = 1, max = 2 }
points = [ { torque = '1 N*m', speed = '1 rad/s' } ]
";

/// Uniform in the logarithm.
fn around(d: &mut Pcg64, a: f64, b: f64) -> f64 {
    a * (b / a).powf(d.random::<f64>())
}

/// One to four harmonics: value, first and second derivative by the time.
fn wave(d: &mut Pcg64, amplitude: f64, period: f64) -> impl Fn(f64) -> [f64; 3] + use<> {
    let (count, turns) = (d.random_range(1..5), TAU / period);
    let harmonic = |_| {
        [d.random_range(0.1..1.0) * amplitude, d.random_range(1.0_f64..6.0).floor() * turns, d.random_range(0.0..TAU)]
    };
    let harmonics: Vec<[f64; 3]> = (0..count).map(harmonic).collect();
    let derivative =
        |[a, w, phase]: [f64; 3], t: f64, k: i32| a * w.powi(k) * (w * t + phase + 0.25 * TAU * f64::from(k)).sin();
    move |t| [0, 1, 2].map(|k| harmonics.iter().map(|h| derivative(*h, t, k)).sum())
}

/// Draws a case: a motor and a motion that suit each other at some ratio, and limits around what is
/// needed near it. A convex one has neither Coulomb friction nor a regeneration limit nor a weighted
/// objective that bends the wrong way; the others have at least one of them.
fn draw(index: u64, convex: bool) -> Case {
    let d = &mut Pcg64::seed_from_u64(index);
    let bent = [0, 1, 2, 3].map(|kind| !convex && (index % 4 == kind || d.random_bool(0.15)));
    let [rubs, regenerates, peaked, stepped] = bent;
    // The motion: harmonics at uneven times with stretches and single samples at standstill, or points.
    let (period, speed, matched) = (around(d, 0.2, 3.0), around(d, 0.5, 30.0), around(d, 3.0, 60.0));
    let (form, rippled) = (d.random_range(0.0..1.0), d.random_bool(0.2));
    let points = form > 0.8;
    let (fewest, most) = if points { (1.0, 12.0) } else { (8.0, if rippled { 24.0 } else { 301.0 }) };
    let count = around(d, fewest, most) as usize;
    let (rotor, of_gear) = (around(d, 1e-7, 1e-3), around(d, 1e-8, 1e-4) * d.random_range(0_u8..2) as f64);
    let torque = (rotor + of_gear) * speed * TAU / period * matched * matched * around(d, 0.2, 5.0);
    let (load, turn, offset) = (wave(d, torque, period), wave(d, speed, period), d.random_range(-torque..torque));
    let rest = d.random_range(0..count);
    let rest = rest..rest + d.random_range(0..3) * count / 8;
    let time: Vec<f64> = (0..count).map(|k| period * (k as f64 + d.random_range(0.0..0.5)) / count as f64).collect();
    let mut sample = |(k, t): (usize, &f64)| {
        let ([tau, torque_rate, _], [omega, alpha, j]) = (load(*t), turn(*t));
        let [velocity, acceleration, jerk] = if rest.contains(&k) { [0.0; 3] } else { [omega, alpha, j] };
        let velocity = if d.random_bool(0.02) { 0.0 } else { velocity };
        let duration = (form < 0.93).then(|| around(d, 0.1, 2.0));
        Point { torque: tau + offset, velocity, acceleration, torque_rate, jerk, duration }
    };
    let raw: Vec<Point> = time.iter().enumerate().map(&mut sample).collect();
    let column = |f: fn(&Point) -> f64| Some(raw.iter().map(f).collect::<Vec<f64>>());
    let (velocity, acceleration) = (column(|p| p.velocity), column(|p| p.acceleration));
    let (torque_rate, jerk, torques) = (column(|p| p.torque_rate), column(|p| p.jerk), column(|p| p.torque).unwrap());
    let samples =
        Samples { time: time.clone(), torque: torques, position: None, velocity, acceleration, torque_rate, jerk };
    let course = if form < 0.55 { Course::Periodic(period) } else { Course::Once(time[count - 1] - time[0]) };
    // The motor: R i and K_B N ω of like size.
    let (resistance, brushless) = (around(d, 0.02, 5.0), d.random_bool(0.9));
    let k_t = (resistance * torque / (matched * matched * speed) * around(d, 0.5, 50.0)).sqrt();
    let mut motor = Catalog::from_sources(vec![Arc::new(Source::new("motor.csv", MOTOR))]).unwrap().motors.remove(0);
    motor.conventions.commutation = if brushless { Commutation::Brushless } else { Commutation::Brushed };
    (motor.resistance, motor.torque_constant) = (resistance, k_t);
    motor.back_emf_constant = k_t * d.random_range(0.85_f64..1.15).clamp(0.9, 1.0);
    motor.rotor_inertia = Some(rotor);
    motor.inductance = [None, Some(0.0), Some(resistance * around(d, 1e-5, 4e-3))][d.random_range(0_usize..12).min(2)];
    motor.pole_pairs = if brushless { Some(d.random_range(1..23)).filter(|p| *p < 22) } else { Some(0) };
    motor.viscous_friction = d.random_bool(0.4).then(|| rotor * around(d, 0.1, 10.0));
    motor.coulomb_friction = rubs.then(|| torque / matched * around(d, 0.01, 0.5));
    motor.mass = Some(around(d, 0.05, 2.0));
    motor.reference_temperature = d.random_range(288.0..300.0);
    // Joint and bus.
    let mut robot = read_source(&Arc::new(Source::new("robot.toml", ROBOT))).unwrap();
    let joint = &mut robot.joints[0];
    joint.motion = if points { Motion::from_points(&raw) } else { Motion::from_samples(samples, course) };
    joint.gear.efficiency = d.random_range(0.5_f64..1.3).min(1.0);
    joint.gear.backdrive_efficiency =
        if d.random_bool(0.6) { 2.0 - 1.0 / joint.gear.efficiency } else { d.random_range(-0.2..1.0) };
    joint.gear.inertia = of_gear;
    joint.gear.mass_per_stage =
        (stepped || d.random_bool(0.4)).then(|| (around(d, 0.05, 1.0), d.random_range(3.0..10.0)));
    let middle = matched * around(d, 0.4, 2.5);
    joint.ratio = RatioChoice::Continuous { min: middle * around(d, 0.01, 0.8), max: middle * around(d, 1.25, 100.0) };
    let ripple = TorqueBandwidth { frequency: around(d, 1.0, 60.0), amplitude: torque * around(d, 0.05, 1.0) };
    joint.limits.torque_bandwidth = rippled.then_some(ripple);
    joint.limits.safety = d.random_range(0.5_f64..1.5).max(1.0);
    robot.bus.modulation = if d.random_bool(0.3) { Modulation::Sine } else { Modulation::SpaceVector };
    robot.bus.modulation_limit = d.random_range(0.85..1.0);
    robot.bus.drive_efficiency = d.random_range(0.85..1.0);
    robot.ambient = d.random_range(285.0..315.0);
    // Limits: each is there or not, and allows more or less than the middle ratio needs.
    let mut case = Case::new(motor, robot, time, raw);
    let (at, (volt, ampere), mass) = (case.look(middle), case.drive(), case.mass(middle));
    let (density, low) = ([0.1, 0.25, 0.5][d.random_range(0..3)], [0.6, 0.95][d.random_range(0..2)]);
    let most = if d.random_bool(0.5) { 1.3 } else { 3.0 };
    let need: BTreeMap<&str, f64> = at.limits.iter().map(|(name, demand, _)| (*name, *demand)).collect();
    let mut allow = |name: &str| {
        let allowed = need[name] * around(d, low, most);
        (d.random_bool(density) && allowed > 0.0).then_some(allowed)
    };
    let current = if rippled { "torque_bandwidth_current" } else { "peak_current" };
    let voltage = if rippled { "torque_bandwidth_voltage" } else { "voltage" };
    case.robot.bus.voltage = need[voltage] / volt * 3.0;
    case.robot.bus.voltage = allow(voltage).map_or(case.robot.bus.voltage, |v| v / volt);
    case.robot.bus.drive_current = allow(current).map(|i| i / ampere);
    case.robot.bus.power = allow("bus_power");
    case.robot.bus.current = allow("bus_power").map(|watt| watt / case.robot.bus.voltage);
    case.motor.peak_current = allow(current);
    case.motor.peak_torque = allow("peak_torque");
    case.motor.continuous_current = allow("standstill_holding");
    case.motor.continuous_torque = allow("continuous_torque");
    case.motor.max_speed = allow("max_speed");
    let thermal = allow("standstill_holding");
    let joint = &mut case.robot.joints[0];
    joint.drive_current = allow(current).map(|i| i / ampere);
    joint.gear.max_input_speed = allow("max_speed");
    joint.gear.peak_torque = allow("gear_peak_torque").map(|x| x * 1.5);
    joint.gear.continuous_torque = allow("gear_continuous_torque").map(|x| x * 1.5);
    joint.limits.reflected_inertia = allow("reflected_inertia");
    joint.limits.actuator_mass = allow("actuator_mass").map(|_| mass * 1.05);
    let back = allow("regeneration").unwrap_or(0.0);
    if regenerates {
        case.robot.bus.regeneration = Regeneration::Limited(back);
    }
    let hot = d.random_range(360.0..420.0);
    [case.motor.max_winding_temperature, joint.limits.winding_temperature] =
        [[Some(hot), None], [None, Some(hot)], [Some(hot), Some(hot + 9.0)]][d.random_range(0..3)];
    case.motor.thermal_resistance = thermal.map(|i| (hot - case.robot.ambient) / (i * i * case.resistance_at(hot)));
    let kind = d.random_range(0..20);
    let mut weigh = |quantity, scale: f64| (quantity, around(d, 0.2, 5.0) / scale);
    let loss = weigh(Quantity::Loss, at.loss);
    let terms = match kind {
        _ if peaked => vec![loss, weigh(Quantity::PeakCurrent, at.peak_current)],
        _ if stepped => vec![loss, weigh(Quantity::Mass, mass)],
        0..10 => vec![(Quantity::Loss, 1.0)],
        10..13 => vec![loss, weigh(Quantity::ReflectedInertia, middle * middle * case.inertia())],
        13..16 => vec![(Quantity::PeakCurrent, 1.0)],
        16 | 17 => vec![(Quantity::ReflectedInertia, 1.0)],
        _ => vec![(Quantity::Mass, 1.0)],
    };
    case.robot.joints[0].objective = Objective { terms };
    case
}

// ------------------------------------------------------------------ the comparison

/// What came of a case: disagreements, limits that bind in the reference, largest deviations.
#[derive(Default)]
struct Verdict {
    wrong: Vec<String>,
    feasible: bool,
    close: bool,
    binding: Vec<&'static str>,
    deviations: [f64; 5],
}

impl Verdict {
    /// Notes a deviation of a kind, which must not be larger than `most`.
    fn near(&mut self, kind: usize, what: &str, deviation: f64, most: f64) {
        self.deviations[kind] = self.deviations[kind].max(deviation);
        self.must(deviation <= most, || format!("{what} deviates by {deviation:e}"));
    }

    fn must(&mut self, holds: bool, what: impl Fn() -> String) {
        if !holds {
            self.wrong.push(what());
        }
    }
}

fn compare(case: &Case, convex: bool) -> Verdict {
    let RatioChoice::Continuous { min, max } = case.joint().ratio else { unreachable!() };
    let (windows, grid, least) = scan(case, min, max);
    let widest = windows.iter().map(|[a, b]| b / a - 1.0).fold(0.0, f64::max);
    let close = least.0.abs() < CLOSE || !windows.is_empty() && widest < NARROW;
    let mut v = Verdict { feasible: !windows.is_empty(), close, ..Verdict::default() };
    let catalog = Catalog { motors: vec![case.motor.clone()], gears: Vec::new() };
    let result = &optimize(&case.robot, &catalog).joints[0];
    let filled = |limit: &str, n: f64| {
        let (_, demand, bound) = *case.look(n).limits.iter().find(|l| l.0 == limit).unwrap();
        demand / bound.unwrap()
    };
    let Some(design) = result.candidates.first() else {
        v.must(!v.feasible || close, || format!("rejected, but {windows:?} are feasible"));
        v.binding.push(least.1);
        let reason = &result.rejected[0].reason;
        match reason {
            _ if close => {}
            // The claims about why there is no ratio hold at every ratio of the grid, or at the two named.
            Reason::Infeasible(Infeasible::Never { bind, least, .. }) => {
                let true_least = grid.iter().map(|n| filled(bind.limit, *n)).fold(f64::INFINITY, f64::min);
                v.must(*least > 1.0 && *least <= true_least * (1.0 + 1e-9), || {
                    format!("{reason:?}, true: {true_least}")
                });
            }
            Reason::Infeasible(Infeasible::Contradiction { low, at_least, high, at_most }) => {
                let low =
                    low.limit == "ratio_min" && *at_least == min || filled(low.limit, at_least * (1.0 - NARROW)) > 1.0;
                let high =
                    high.limit == "ratio_max" && *at_most == max || filled(high.limit, at_most * (1.0 + NARROW)) > 1.0;
                v.must(low && high && at_least > at_most, || format!("{reason:?} is not true"));
            }
            Reason::Infeasible(Infeasible::Nowhere { .. }) => v.must(!convex, || format!("{reason:?}")),
            _ => v.must(false, || format!("{reason:?}")),
        }
        return v;
    };
    v.must(v.feasible || close, || format!("found N = {}, but {least:?} is violated", design.optimum.ratio));
    if close {
        return v;
    }
    // The optimum.
    let (n, optimum, evaluation) = (design.optimum.ratio, &design.optimum, &design.evaluation);
    let best = least_over(&windows, &grid, |n| case.look(n).objective);
    let at = case.look(n);
    v.near(0, "N* above the best", optimum.objective / best - 1.0, 1e-6);
    v.near(1, "N* below the best", 1.0 - optimum.objective / best, 1e-8);
    v.near(4, "the objective", (optimum.objective / at.objective - 1.0).abs(), 1e-9);
    if case.joint().objective.sole() == Some(Quantity::Mass) {
        // Among the ratios of least mass the one of least loss is taken.
        let lossy = |n| if case.mass(n) > best * (1.0 + 1e-12) { f64::INFINITY } else { case.look(n).loss };
        v.near(0, "loss at least mass", at.loss / least_over(&windows, &grid, lossy) - 1.0, 1e-6);
    }
    v.must(evaluation.feasible && case.worst(n).0 <= CLOSE, || format!("N* = {n} violates {:?}", case.worst(n)));
    if case.worst(n).0 > -CLOSE {
        v.binding.push(case.worst(n).1);
    }
    // The windows, and what ends them.
    let wide = |list: Vec<[f64; 2]>| list.into_iter().filter(|[a, b]| b / a - 1.0 > NARROW).collect::<Vec<_>>();
    let mine = wide(windows);
    let theirs = wide(optimum.windows.iter().map(|w| [w.min, w.max]).collect());
    v.must(mine.len() == theirs.len() && (!convex || mine.len() == 1), || {
        format!("windows {theirs:?}, true: {mine:?}")
    });
    for (a, b) in mine.iter().flatten().zip(theirs.iter().flatten()) {
        v.near(2, "a window", (a / b - 1.0).abs(), 1e-6);
    }
    let inside = |w: &[f64; 2]| w[0] * (1.0 - 1e-9) <= n && n <= w[1] * (1.0 + 1e-9);
    v.must(theirs.iter().any(inside), || format!("N* = {n} is outside {theirs:?}"));
    for (bind, end, own) in optimum.windows.iter().flat_map(|w| [(&w.low, w.min, min), (&w.high, w.max, max)]) {
        let own_end = bind.limit.starts_with("ratio_") && (end / own - 1.0).abs() < 1e-9;
        v.must(own_end || filled(bind.limit, end) > 1.0 - 1e-6, || format!("{bind:?} does not bind at {end}"));
        v.binding.extend(if own_end { None } else { Some(case.worst(end).1) });
    }
    // The proof.
    match optimum.certificate {
        Certificate::Certified { lower_bound, gap, .. } => {
            v.must(convex && lower_bound <= best * (1.0 + 1e-9), || format!("bound {lower_bound}, best {best}"));
            v.near(3, "the certificate", gap.max(1.0 - lower_bound / optimum.objective), 1e-6);
        }
        Certificate::NotCertified(why) => v.must(!convex, || format!("not certified: {why}")),
    }
    // The figures.
    let inertia = n * n * case.inertia();
    let figures = [
        (evaluation.loss, at.loss),
        (evaluation.peak_current, at.peak_current),
        (evaluation.reflected_inertia, inertia),
    ];
    for (theirs, mine) in figures {
        v.near(4, "a figure", (theirs / mine - 1.0).abs(), 1e-9);
    }
    let asked: Vec<_> =
        at.limits.iter().filter_map(|(name, demand, bound)| Some((*name, *demand, (*bound)?))).collect();
    let names: Vec<&str> = evaluation.margins.iter().map(|m| m.limit).collect();
    v.must(names == asked.iter().map(|a| a.0).collect::<Vec<_>>(), || format!("limits {names:?}"));
    for (margin, (name, demand, bound)) in evaluation.margins.iter().zip(asked) {
        if bound > 0.0 {
            v.near(4, name, (margin.margin - (1.0 - demand.max(0.0) / bound)).abs(), 1e-8);
        }
    }
    v
}

/// Compares cases in parallel and says how it went.
fn run(cases: std::ops::Range<u64>, convex: bool) {
    let count = (cases.end - cases.start) as usize;
    let verdicts: Vec<(u64, Verdict)> = cases.into_par_iter().map(|i| (i, compare(&draw(i, convex), convex))).collect();
    let close = verdicts.iter().filter(|(_, v)| v.close).count();
    let feasible = verdicts.iter().filter(|(_, v)| v.feasible).count();
    let largest = [0, 1, 2, 3, 4].map(|kind| verdicts.iter().map(|(_, v)| v.deviations[kind]).fold(0.0, f64::max));
    let mut binding: BTreeMap<&str, usize> = BTreeMap::new();
    verdicts.iter().flat_map(|(_, v)| &v.binding).for_each(|name| *binding.entry(name).or_default() += 1);
    println!("{count} cases, {feasible} feasible, {close} too close to call; binding: {binding:?}");
    println!("largest deviations: above and below the best, windows, gap, figures: {largest:?}");
    let wrong: Vec<_> = verdicts.iter().filter(|(_, v)| !v.wrong.is_empty()).collect();
    for (i, verdict) in wrong.iter() {
        println!(
            "SHORT {convex} {i} K={} obj={:?}: {:?}",
            draw(*i, convex).raw.len(),
            draw(*i, convex).joint().objective.terms,
            verdict.wrong
        );
    }
    for (i, verdict) in wrong.iter().take(5) {
        let case = draw(*i, convex);
        println!(
            "case {i}: {:#?}
{:?}
{:?}
{:?}",
            verdict.wrong, case.motor, case.robot, case.raw
        );
    }
    assert!(
        wrong.is_empty(),
        "{} of {count} cases disagree: {:?}",
        wrong.len(),
        wrong.iter().map(|w| w.0).collect::<Vec<_>>()
    );
    assert!(close * 50 < count, "{close} of {count} cases are too close to call");
}

#[test]
fn convex_programs_agree_with_a_scan_of_the_raw_waveforms() {
    run(0..640, true);
}

#[test]
fn other_programs_agree_with_a_scan_of_the_raw_waveforms() {
    run(1000..1240, false);
}
