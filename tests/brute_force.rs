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

/// A ratio, looked at: what it is worth, and every limit that applies with name, demand and bound.
struct Look {
    objective: f64,
    loss: f64,
    peak_current: f64,
    limits: Vec<(&'static str, f64, f64)>,
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
        let limits = limits.into_iter().filter_map(|(name, demand, bound)| Some((name, demand, bound?))).collect();
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
        let limits = self.look(n).limits.into_iter().map(|(name, demand, bound)| (over(demand, bound), name));
        limits.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }
}

// ------------------------------------------------------------------ the scan

/// Golden section for the least of `f` between two ratios.
fn golden(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut c, mut d) = (b - share * (b - a), a + share * (b - a));
    let (mut at_c, mut at_d) = (f(c), f(d));
    for _ in 0..60 {
        if at_c <= at_d {
            (b, d, at_d) = (d, c, at_c);
            c = b - share * (b - a);
            at_c = f(c);
        } else {
            (a, c, at_c) = (c, d, at_d);
            d = a + share * (b - a);
            at_d = f(d);
        }
    }
    if at_c <= at_d { c } else { d }
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

struct Draw(Pcg64);

impl Draw {
    fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    fn within(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.0.random::<f64>()
    }

    /// Uniform in the logarithm.
    fn around(&mut self, a: f64, b: f64) -> f64 {
        a * (b / a).powf(self.0.random::<f64>())
    }

    /// One to four harmonics: value, first and second derivative by the time.
    fn wave(&mut self, amplitude: f64, period: f64) -> impl Fn(f64) -> [f64; 3] + use<> {
        let harmonic = |d: &mut Draw| {
            [amplitude * d.within(0.1, 1.0), d.within(1.0, 6.0).floor() * TAU / period, d.within(0.0, TAU)]
        };
        let harmonics: Vec<[f64; 3]> = (0..self.0.random_range(1..5)).map(|_| harmonic(self)).collect();
        move |t| {
            let at = |[a, w, phase]: [f64; 3]| {
                [a * (w * t + phase).sin(), a * w * (w * t + phase).cos(), -a * w * w * (w * t + phase).sin()]
            };
            harmonics.iter().map(|h| at(*h)).fold([0.0; 3], |sum, x| [sum[0] + x[0], sum[1] + x[1], sum[2] + x[2]])
        }
    }
}

/// Draws a case: a motor and a motion that suit each other at some ratio, and limits around what is
/// needed there. A convex one has neither Coulomb friction nor a regeneration limit nor a weighted
/// objective that bends the wrong way; the others have at least one of them.
fn draw(index: u64, convex: bool) -> Case {
    let mut d = Draw(Pcg64::seed_from_u64(index));
    let bent = if convex { [false; 4] } else { [0, 1, 2, 3].map(|kind| index % 4 == kind || d.chance(0.15)) };
    let [rubs, regenerates, peaked, stepped] = bent;
    // The motion: harmonics at uneven times with stretches and single samples at standstill, or points.
    let (period, speed, matched, form) =
        (d.around(0.2, 3.0), d.around(0.5, 30.0), d.around(3.0, 60.0), d.within(0.0, 1.0));
    let rippled = d.chance(0.2);
    let most = if form > 0.8 {
        12.0
    } else if rippled {
        24.0
    } else {
        301.0
    };
    let count = d.around(if form > 0.8 { 1.0 } else { 8.0 }, most) as usize;
    let (rotor, gear_inertia) = (d.around(1e-7, 1e-3), if d.chance(0.5) { d.around(1e-8, 1e-4) } else { 0.0 });
    let torque = (rotor + gear_inertia) * speed * TAU / period * matched * matched * d.around(0.2, 5.0);
    let (load, turn) = (d.wave(torque, period), d.wave(speed, period));
    let offset = if d.chance(0.5) { d.within(-torque, torque) } else { 0.0 };
    let rest = d.0.random_range(0..count);
    let rest = rest..if d.chance(0.35) { rest + 1 + count / 4 } else { rest };
    let time: Vec<f64> = (0..count).map(|k| period * (k as f64 + d.within(0.0, 0.5)) / count as f64).collect();
    let mut raw = Vec::new();
    for (k, t) in time.iter().enumerate() {
        let ([tau, torque_rate, _], [omega, alpha, j]) = (load(*t), turn(*t));
        let [velocity, acceleration, jerk] = if rest.contains(&k) { [0.0; 3] } else { [omega, alpha, j] };
        let velocity = if d.chance(0.02) { 0.0 } else { velocity };
        let duration = (form < 0.93).then(|| d.around(0.1, 2.0));
        raw.push(Point { torque: tau + offset, velocity, acceleration, torque_rate, jerk, duration });
    }
    let column = |f: fn(&Point) -> f64| raw.iter().map(f).collect::<Vec<f64>>();
    let [velocity, acceleration, torque_rate, jerk] =
        [column(|p| p.velocity), column(|p| p.acceleration), column(|p| p.torque_rate), column(|p| p.jerk)].map(Some);
    let (time_given, torques) = (time.clone(), column(|p| p.torque));
    let samples =
        Samples { time: time_given, torque: torques, velocity, acceleration, torque_rate, jerk, position: None };
    let course = if form < 0.55 { Course::Periodic(period) } else { Course::Once(time[count - 1] - time[0]) };
    let motion = if form > 0.8 { Motion::from_points(&raw) } else { Motion::from_samples(samples, course) };
    // The motor: R i and K_B N ω of like size.
    let (resistance, commutation) = (d.around(0.02, 5.0), if d.chance(0.1) { "brushed" } else { "brushless" });
    let k_t = (resistance * torque / (matched * matched * speed) * d.around(0.5, 50.0)).sqrt();
    let k_b = k_t * if d.chance(0.5) { 1.0 } else { d.within(0.85, 1.03) };
    let text = "id,source,source_kind,terminals,current,back_emf_convention,commutation,resistance [ohm],torque_constant [N*m/A],back_emf_constant [V*s/rad]";
    let text = format!("{text}\nmotor,none,derived,q_axis,q_axis,q_axis,{commutation},{resistance},{k_t},{k_b}\n");
    let mut motor = Catalog::from_sources(vec![Arc::new(Source::new("motors.csv", text))]).unwrap().motors.remove(0);
    assert_eq!([motor.resistance, motor.torque_constant, motor.back_emf_constant], [resistance, k_t, k_b]);
    motor.rotor_inertia = Some(rotor);
    motor.inductance =
        if d.chance(0.1) { None } else { Some(if d.chance(0.15) { 0.0 } else { resistance * d.around(1e-5, 4e-3) }) };
    motor.pole_pairs =
        if commutation == "brushed" { Some(0) } else { (!d.chance(0.05)).then(|| d.0.random_range(1..22)) };
    motor.viscous_friction = d.chance(0.4).then(|| rotor * d.around(0.1, 10.0));
    motor.coulomb_friction =
        if rubs { Some(torque / matched * d.around(0.01, 0.5)) } else { Some(0.0).filter(|_| d.chance(0.5)) };
    motor.mass = Some(d.around(0.05, 2.0));
    motor.reference_temperature = d.within(288.0, 300.0);
    // Gear and robot.
    let efficiency = if d.chance(0.3) { 1.0 } else { d.within(0.5, 1.0) };
    let backdrive_efficiency = if d.chance(0.6) { 2.0 - 1.0 / efficiency } else { d.within(-0.2, 1.0) };
    let mass = d.around(0.05, 1.0);
    let mass_per_stage = if stepped || d.chance(0.4) { Some((mass, d.within(3.0, 10.0))) } else { None };
    let gear = GearModel {
        efficiency,
        backdrive_efficiency,
        mass: Some(mass),
        mass_per_stage,
        inertia: gear_inertia,
        ..GearModel::IDEAL
    };
    let middle = matched * d.around(0.4, 2.5);
    let ratio = RatioChoice::Continuous { min: middle * d.around(0.01, 0.8), max: middle * d.around(1.25, 100.0) };
    let bandwidth = TorqueBandwidth { frequency: d.around(1.0, 60.0), amplitude: torque * d.around(0.05, 1.0) };
    let safety = if d.chance(0.4) { d.within(1.0, 1.5) } else { 1.0 };
    let limits = Limits { torque_bandwidth: rippled.then_some(bandwidth), safety, ..Limits::default() };
    let objective = Objective { terms: Vec::new() };
    let joint = Joint { name: "joint".into(), count: 1, ratio, gear, motion, objective, limits, drive_current: None };
    let modulation = if d.chance(0.3) { Modulation::Sine } else { Modulation::SpaceVector };
    let (modulation_limit, drive_efficiency) = (d.within(0.85, 1.0), d.within(0.85, 1.0));
    let bus = Bus {
        voltage: 1.0,
        modulation,
        modulation_limit,
        drive_current: None,
        power: None,
        current: None,
        regeneration: Regeneration::Allowed,
        drive_efficiency,
    };
    let robot = Robot {
        name: "robot".into(),
        bus,
        ambient: d.within(285.0, 315.0),
        budget: Budget::default(),
        joints: vec![joint],
    };
    let mut case = Case::new(motor, robot, time, raw);
    todo!()
}
