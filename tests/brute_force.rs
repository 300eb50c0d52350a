//! An independent check of the ratio program: random joints are solved by `design::optimize`, and again
//! here by looking at thousands of ratios, one after the other, straight from the raw waveforms.
//!
//! Nothing of the crate's model is called for the reference: shaft torque, current, voltage, power, means
//! over time, efficiency, friction and every limit are computed below in the plainest way, without
//! polynomials in the ratio, convexity or solver. Only data types are shared. Case `i` is drawn from the
//! generator seeded with `i`, so a failure is reproduced by its number.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use gearwise::catalog::convention::{BackEmfConvention, Commutation, CurrentConvention, Modulation, Terminals};
use gearwise::catalog::{Catalog, Conventions, Identity, Motor, Printed, Sheet, SourceKind};
use gearwise::design::optimize::{Reason, optimize};
use gearwise::design::program::{Certificate, Infeasible};
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// Ratios that are looked at before refining.
const RATIOS: usize = 2001;
/// Cases whose least violation is nearer to zero than this, or whose windows are all narrower than
/// `NARROW` (relative), are too close to call.
const CLOSE: f64 = 1e-7;
const NARROW: f64 = 1e-6;

// ------------------------------------------------------------------ the model, from raw waveforms

/// A sample at the gear's input: what is left when the ratio is taken out. `load` is φ τ and φ τ̇, `own`
/// is (J_m + J_g) α + b ω and its rate.
struct Wave {
    load: [f64; 2],
    own: [f64; 2],
    speed: f64,
    weight: f64,
    dwell: f64,
}

/// The largest demands over the samples at one ratio, and the means over time.
#[derive(Default)]
struct Demands {
    torque: f64,
    voltage: f64,
    power: f64,
    back: f64,
    square: f64,
    standstill_square: f64,
    mean_power: f64,
    ripple_torque: f64,
    ripple_voltage: f64,
}

/// A motor at the only joint of a robot, the motion sample by sample, and what follows from it.
struct Case {
    motor: Motor,
    robot: Robot,
    time: Vec<f64>,
    raw: Vec<Point>,
    waves: Vec<Wave>,
    rippled: Vec<Wave>,
    inductance: f64,
    poles: f64,
    friction: f64,
}

impl Case {
    fn new(motor: Motor, robot: Robot, time: Vec<f64>, raw: Vec<Point>) -> Case {
        let brushed = motor.conventions.commutation == Commutation::Brushed;
        let poles = if brushed { Some(0.0) } else { motor.pole_pairs.map(f64::from) };
        // Without inductance or pole pairs the voltage is that of resistance and back-EMF.
        let (inductance, poles) = motor.inductance.zip(poles).unwrap_or((0.0, 0.0));
        let friction = motor.coulomb_friction.unwrap_or(0.0);
        let (waves, rippled) = (Vec::new(), Vec::new());
        let mut case = Case { motor, robot, time, raw, waves, rippled, inductance, poles, friction };
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

    fn brushed(&self) -> bool {
        self.motor.conventions.commutation == Commutation::Brushed
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
            [(time[k] - before, (k + n - 1) % n), (after - time[k], (k + 1) % n)].map(|(t, at)| (0.5 * t / total, at));
        let at_rest = halves.iter().filter(|(_, neighbour)| still(k) && still(*neighbour)).map(|h| h.0).sum();
        (halves[0].0 + halves[1].0, at_rest)
    }

    /// Peak torque of a sample and the voltage it takes. At standstill friction opposes the motor.
    fn peak(&self, wave: &Wave, n: f64) -> (f64, f64) {
        let smooth = wave.load[0] / n + n * wave.own[0];
        let torque = smooth + self.friction.copysign(if wave.speed == 0.0 { smooth } else { wave.speed });
        let (i, rate) =
            (torque / self.motor.torque_constant, (wave.load[1] / n + n * wave.own[1]) / self.motor.torque_constant);
        let v_q = self.motor.resistance * i + self.inductance * rate + self.motor.back_emf_constant * n * wave.speed;
        let v_d = -self.poles * n * wave.speed * self.inductance * i;
        (torque, (v_q * v_q + v_d * v_d).sqrt())
    }

    fn power(&self, wave: &Wave, n: f64, torque: f64) -> f64 {
        let i = torque / self.motor.torque_constant;
        self.motor.resistance * i * i + self.motor.back_emf_constant * n * wave.speed * i
    }

    fn demands(&self, n: f64) -> Demands {
        let mut d = Demands { power: f64::MIN, back: f64::MIN, ..Demands::default() };
        for wave in &self.waves {
            let (torque, voltage) = self.peak(wave, n);
            let power = self.power(wave, n, torque);
            d.torque = d.torque.max(torque.abs());
            d.voltage = d.voltage.max(voltage);
            d.power = d.power.max(power);
            d.back = d.back.max(-power);
            // For means there is no friction at standstill.
            let usual = if wave.speed == 0.0 { wave.load[0] / n + n * wave.own[0] } else { torque };
            d.square += wave.weight * usual * usual;
            d.standstill_square += wave.dwell * usual * usual;
            d.mean_power += wave.weight * self.power(wave, n, usual);
        }
        for wave in &self.rippled {
            let (torque, voltage) = self.peak(wave, n);
            d.ripple_torque = d.ripple_torque.max(torque.abs());
            d.ripple_voltage = d.ripple_voltage.max(voltage);
        }
        d
    }

    fn mass(&self, n: f64) -> f64 {
        let gear = &self.joint().gear;
        let stages = |ratio: f64| (0..99).map(f64::from).find(|k| n <= ratio.powf(*k) * (1.0 + 1e-9)).unwrap();
        self.motor.mass.unwrap()
            + gear.mass_per_stage.map_or_else(|| gear.mass.unwrap(), |(mass, ratio)| mass * stages(ratio))
    }

    /// Radius of the q-axis voltage circle per volt of the bus, and q-axis ampere per ampere of the drive.
    fn drive_factors(&self) -> (f64, f64) {
        let circle =
            if self.robot.bus.modulation == Modulation::Sine { (3.0_f64 / 8.0).sqrt() } else { 0.5_f64.sqrt() };
        let (volt, ampere) = if self.brushed() { (1.0, 1.0) } else { (circle, 1.5_f64.sqrt()) };
        (volt * self.robot.bus.modulation_limit, ampere)
    }

    fn resistance_at(&self, kelvin: f64) -> f64 {
        self.motor.resistance * (1.0 + 0.0039 * (kelvin - self.motor.reference_temperature))
    }

    /// Every limit that applies: name, demand at a ratio, bound.
    fn limits(&self, d: &Demands, n: f64) -> Vec<(&'static str, f64, f64)> {
        let (motor, bus, gear, limits) = (&self.motor, &self.robot.bus, &self.joint().gear, &self.joint().limits);
        let (volt, ampere) = self.drive_factors();
        let least = |a: Option<f64>, b: Option<f64>| [a, b].into_iter().flatten().reduce(f64::min);
        let largest = |f: fn(&Point) -> f64| self.raw.iter().fold(0.0, |most: f64, p| most.max(f(p).abs()));
        let drive = self.joint().drive_current.or(bus.drive_current).map(|i| i * ampere);
        let peak = least(motor.peak_current, drive);
        let hot = least(motor.max_winding_temperature, limits.winding_temperature).zip(motor.thermal_resistance);
        let hot = hot.map(|(hot, r_th)| ((hot - self.robot.ambient) / (r_th * self.resistance_at(hot))).sqrt());
        let stands = !self.brushed() && self.waves.iter().any(|w| w.dwell > 0.0);
        let rippled = limits.torque_bandwidth.is_some();
        let inductive = motor.inductance.is_some() && motor.pole_pairs.is_some();
        let timed = self.joint().motion.course != Course::Points(None);
        let regeneration = if let Regeneration::Limited(watt) = bus.regeneration { Some(watt) } else { None };
        let (k_t, safety, power) = (motor.torque_constant, limits.safety, d.power / bus.drive_efficiency);
        let (rms, voltage) = (d.square.sqrt(), bus.voltage * volt);
        let load_square: f64 = self.waves.iter().zip(&self.raw).map(|(w, p)| w.weight * p.torque * p.torque).sum();
        let mass = if limits.actuator_mass.is_some() { self.mass(n) } else { 0.0 };
        [
            ("peak_current", safety * d.torque / k_t, peak),
            ("peak_torque", safety * d.torque, motor.peak_torque),
            ("continuous_current", rms / k_t, motor.continuous_current.filter(|_| timed)),
            ("continuous_torque", rms, motor.continuous_torque.filter(|_| timed)),
            ("winding_temperature", rms / k_t, hot.filter(|_| timed)),
            (
                "standstill_holding",
                (d.square + d.standstill_square).sqrt() / k_t,
                motor.continuous_current.or(hot).filter(|_| timed && stands),
            ),
            ("voltage", d.voltage, Some(voltage)),
            ("max_speed", n * largest(|p| p.velocity), motor.max_speed),
            ("gear_input_speed", n * largest(|p| p.velocity), gear.max_input_speed),
            ("gear_peak_torque", safety * largest(|p| p.torque), gear.peak_torque),
            ("gear_continuous_torque", load_square.sqrt(), gear.continuous_torque.filter(|_| timed)),
            ("reflected_inertia", n * n * self.inertia(), limits.reflected_inertia),
            ("torque_bandwidth_current", safety * d.ripple_torque / k_t, peak.filter(|_| rippled)),
            ("torque_bandwidth_voltage", d.ripple_voltage, Some(voltage).filter(|_| rippled && inductive)),
            ("bus_power", power, bus.power),
            ("bus_current", power / bus.voltage, bus.current),
            ("regeneration", d.back * bus.drive_efficiency, regeneration),
            ("actuator_mass", mass, limits.actuator_mass),
        ]
        .into_iter()
        .filter_map(|(name, demand, bound)| Some((name, demand, bound?)))
        .collect()
    }

    /// The worst limit at a ratio and by how much it is exceeded (absolutely, where nothing is allowed).
    fn worst(&self, n: f64) -> (f64, &'static str) {
        let over = |demand: f64, bound: f64| if bound > 0.0 { demand / bound - 1.0 } else { demand };
        let limits =
            self.limits(&self.demands(n), n).into_iter().map(|(name, demand, bound)| (over(demand, bound), name));
        limits.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    fn quantity(&self, quantity: Quantity, d: &Demands, n: f64) -> f64 {
        let k_t = self.motor.torque_constant;
        match quantity {
            Quantity::Loss => self.motor.resistance * d.square / (k_t * k_t),
            Quantity::ReflectedInertia => n * n * self.inertia(),
            Quantity::PeakCurrent => d.torque / k_t,
            Quantity::Mass => self.mass(n),
        }
    }

    fn objective(&self, n: f64) -> f64 {
        let d = self.demands(n);
        self.joint().objective.terms.iter().map(|(quantity, weight)| weight * self.quantity(*quantity, &d, n)).sum()
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
fn least_over(windows: &[[f64; 2]], grid: &[f64], f: impl Fn(f64) -> f64) -> (f64, f64) {
    let inside =
        |[a, b]: [f64; 2]| [a].into_iter().chain(grid.iter().copied().filter(move |n| a < *n && *n < b)).chain([b]);
    let seen: Vec<Vec<(f64, f64)>> = windows.iter().map(|w| inside(*w).map(|n| (f(n), n)).collect()).collect();
    let less = |a: (f64, f64), b: (f64, f64)| if b.0 < a.0 { b } else { a };
    let mut best = seen.iter().flatten().copied().reduce(less).unwrap();
    for window in seen {
        for i in 0..window.len() {
            let (before, after) = (window[i.saturating_sub(1)], window[(i + 1).min(window.len() - 1)]);
            if window[i].0 <= before.0.min(after.0) && window[i].0 <= best.0 * 1.01 {
                let n = golden(&f, before.1, after.1);
                best = less(best, (f(n), n));
            }
        }
    }
    best
}

/// Feasible intervals, the grid with the extrema of the violation added, and the least violation.
fn scan(case: &Case) -> (Vec<[f64; 2]>, Vec<f64>, (f64, &'static str)) {
    let RatioChoice::Continuous { min, max } = case.joint().ratio else { unreachable!() };
    let mut grid: Vec<f64> = (0..RATIOS).map(|i| min * (max / min).powf(i as f64 / (RATIOS - 1) as f64)).collect();
    grid[RATIOS - 1] = max;
    if let Some((_, ratio)) = case.joint().gear.mass_per_stage {
        grid.extend((0..30).map(|stages| ratio.powi(stages)).filter(|n| (min..max).contains(n)));
    }
    let order = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0);
    let mut seen: Vec<(f64, f64)> = grid.iter().map(|&n| (n, case.worst(n).0)).collect();
    seen.sort_by(order);
    let mut extrema = Vec::new();
    for (i, here) in seen.iter().enumerate() {
        // A feasible ratio may hide between infeasible ones, and the other way round.
        let sign = if here.1 > 0.0 { 1.0 } else { -1.0 };
        let (before, after) = (seen[i.saturating_sub(1)], seen[(i + 1).min(seen.len() - 1)]);
        if (i == 0 || sign * here.1 < sign * before.1) && sign * here.1 <= sign * after.1 {
            let n = golden(|n| sign * case.worst(n).0, before.0, after.0);
            extrema.push((n, case.worst(n).0));
        }
    }
    seen.extend(extrema);
    seen.sort_by(order);
    let edge = |mut bad: f64, mut good: f64| {
        for _ in 0..60 {
            let n = 0.5 * (bad + good);
            *(if case.worst(n).0 > 0.0 { &mut bad } else { &mut good }) = n;
        }
        good
    };
    let mut windows: Vec<[f64; 2]> = Vec::new();
    for (i, &(n, over)) in seen.iter().enumerate() {
        let before = i.checked_sub(1).map(|i| seen[i]);
        match (before.filter(|b| b.1 > 0.0), over > 0.0) {
            (Some(bad), false) => windows.push([edge(bad.0, n), n]),
            (None, false) if before.is_none() => windows.push([n, n]),
            (None, false) => windows.last_mut().unwrap()[1] = n,
            (None, true) if before.is_some() => windows.last_mut().unwrap()[1] = edge(n, before.unwrap().0),
            _ => {}
        }
    }
    let least = seen.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|at| case.worst(at.0)).unwrap();
    (windows, seen.into_iter().map(|s| s.0).collect(), least)
}

// ------------------------------------------------------------------ random cases

struct Draw(Pcg64);

impl Draw {
    fn within(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.0.random::<f64>()
    }

    /// Uniform in the logarithm.
    fn around(&mut self, a: f64, b: f64) -> f64 {
        a * (b / a).powf(self.0.random::<f64>())
    }

    fn chance(&mut self, share: f64) -> bool {
        self.0.random::<f64>() < share
    }

    fn maybe(&mut self, share: f64, value: f64) -> Option<f64> {
        self.chance(share).then_some(value)
    }

    /// A sum of harmonics of amplitude around one: value, first and second derivative by the time.
    fn wave(&mut self, period: f64) -> impl Fn(f64) -> [f64; 3] + use<> {
        let harmonics: Vec<[f64; 3]> = (0..1 + self.0.random::<u32>() % 4)
            .map(|_| {
                [self.within(0.1, 1.0), f64::from(1 + self.0.random::<u32>() % 5) * TAU / period, self.within(0.0, TAU)]
            })
            .collect();
        move |t| {
            harmonics.iter().fold([0.0; 3], |sum, [a, w, phase]| {
                let (sin, cos) = (w * t + phase).sin_cos();
                [sum[0] + a * sin, sum[1] + a * w * cos, sum[2] - a * w * w * sin]
            })
        }
    }

    /// A case. Limits are drawn around what a ratio in the middle of the range needs.
    fn case(&mut self, convex: bool, kind: u64) -> Case {
        // Motion: harmonics at uneven times, with stretches and single samples at standstill.
        let (period, speed) = (self.around(0.2, 3.0), self.around(0.5, 30.0));
        let rippled = self.chance(0.2);
        let form = self.within(0.0, 1.0);
        let count =
            if form > 0.75 { self.around(1.0, 12.0) } else { self.around(8.0, if rippled { 24.0 } else { 300.0 }) }
                as usize;
        let (inertia, gear_inertia) =
            (self.around(1e-7, 1e-3), self.around(1e-8, 1e-4) * f64::from(u8::from(self.chance(0.5))));
        let (matched, resistance) = (self.around(3.0, 60.0), self.around(0.02, 5.0));
        let torque = (inertia + gear_inertia) * speed * TAU / period * matched * matched * self.around(0.2, 5.0);
        let (load, turn, offset) =
            (self.wave(period), self.wave(period), self.within(-1.0, 1.0) * f64::from(u8::from(self.chance(0.5))));
        let (rest, rest_end) = (self.0.random_range(0..count), self.0.random_range(0..=count / 2));
        let rest = if self.chance(0.35) { rest..rest + rest_end } else { 0..0 };
        let time: Vec<f64> = (0..count).map(|k| period * (k as f64 + self.within(0.0, 0.5)) / count as f64).collect();
        let durations = form < 0.9;
        let raw: Vec<Point> = time
            .iter()
            .enumerate()
            .map(|(k, &t)| {
                let ([tau, rate, _], [omega, alpha, jerk]) = (load(t).map(|x| torque * x), turn(t).map(|x| speed * x));
                let moves = f64::from(u8::from(!rest.contains(&k)));
                let turns = moves * f64::from(u8::from(!self.chance(0.02)));
                Point {
                    torque: tau + torque * offset,
                    velocity: turns * omega,
                    acceleration: moves * alpha,
                    torque_rate: rate,
                    jerk: moves * jerk,
                    duration: durations.then(|| self.around(0.1, 2.0)),
                }
            })
            .collect();
        let column = |f: fn(&Point) -> f64| Some(raw.iter().map(f).collect::<Vec<f64>>());
        let samples = || Samples {
            time: time.clone(),
            torque: raw.iter().map(|p| p.torque).collect(),
            position: None,
            velocity: column(|p| p.velocity),
            acceleration: column(|p| p.acceleration),
            torque_rate: column(|p| p.torque_rate),
            jerk: column(|p| p.jerk),
        };
        let motion = match form {
            f if f < 0.55 => Motion::from_samples(samples(), Course::Periodic(period)),
            f if f < 0.75 => Motion::from_samples(samples(), Course::Once(time[count - 1] - time[0])),
            _ => Motion::from_points(&raw),
        };
        todo!()
    }
}
