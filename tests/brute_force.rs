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
use gearwise::design::optimize::{Design, Reason, optimize};
use gearwise::design::program::{Certificate, Infeasible};
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

/// Ratios that are looked at before refining.
const RATIOS: usize = 2001;
/// A case is too close to call where the least violation is nearer to zero than this …
const CLOSE: f64 = 1e-7;
/// … or where no window is wider (relative). Window ends must agree as well.
const NARROW: f64 = 1e-6;

// ------------------------------------------------------------------ the model, from raw waveforms

/// A sample at the gear's input: what is left when the ratio is taken out. `load` is φ τ and φ τ̇, `own`
/// is (J_m + J_g) α + b ω and its rate.
struct Wave {
    load: [f64; 2],
    own: [f64; 2],
    speed: f64,
}

/// A motor at the only joint of a robot, the motion sample by sample, and what follows from it: each
/// sample's share of the time (in all, at rest), the waves, and those with the superposed torque.
struct Case {
    motor: Motor,
    robot: Robot,
    raw: Vec<Point>,
    shares: Vec<[f64; 2]>,
    waves: Vec<Wave>,
    rippled: Vec<Wave>,
}

/// What a ratio comes to: loss, inertia, peak current and mass; limits with name, demand and, where they
/// apply, bound.
struct Look {
    quantities: [f64; 4],
    objective: f64,
    limits: [(&'static str, f64, Option<f64>); 18],
}

/// Shares of the time by the trapezoid rule (points: by duration): half an interval for each of its ends.
/// It is at rest if it is so at both.
fn shares(raw: &[Point], time: &[f64], course: Course) -> Vec<[f64; 2]> {
    let (n, mut shares) = (raw.len(), vec![[0.0; 2]; raw.len()]);
    for k in 0..n {
        let (next, length) = match course {
            Course::Points(_) => (k, raw[k].duration.unwrap_or(1.0)),
            Course::Periodic(period) => ((k + 1) % n, (time[(k + 1) % n] - time[k]).rem_euclid(period)),
            Course::Once(_) => ((k + 1).min(n - 1), time[(k + 1).min(n - 1)] - time[k]),
        };
        let rests = raw[k].velocity == 0.0 && raw[next].velocity == 0.0;
        for end in [k, next] {
            shares[end] = [shares[end][0] + length, shares[end][1] + if rests { length } else { 0.0 }];
        }
    }
    let total: f64 = shares.iter().map(|share| share[0]).sum();
    shares.iter().map(|share| share.map(|length| length / total)).collect()
}

impl Case {
    fn new(motor: Motor, robot: Robot, raw: Vec<Point>) -> Case {
        let shares = shares(&raw, &robot.joints[0].motion.time, robot.joints[0].motion.course);
        let mut case = Case { motor, robot, raw, shares, waves: Vec::new(), rippled: Vec::new() };
        for k in 0..case.raw.len() {
            let p = case.raw[k];
            case.waves.push(case.wave(k, [p.torque, p.torque_rate]));
            let Some(TorqueBandwidth { frequency, amplitude }) = case.joint().limits.torque_bandwidth else { continue };
            for phase in (0..32).map(|step| TAU * f64::from(step) / 32.0) {
                let rate = p.torque_rate - amplitude * TAU * frequency * phase.sin();
                case.rippled.push(case.wave(k, [p.torque + amplitude * phase.cos(), rate]));
            }
        }
        case
    }

    fn joint(&self) -> &Joint {
        &self.robot.joints[0]
    }

    fn rotating_inertia(&self) -> f64 {
        self.motor.rotor_inertia.unwrap() + self.joint().gear.inertia
    }

    fn wave(&self, k: usize, tau: [f64; 2]) -> Wave {
        let (p, gear) = (self.raw[k], &self.joint().gear);
        let phi = if tau[0] * p.velocity < 0.0 { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
        let own = |rate, speed| self.rotating_inertia() * rate + self.motor.viscous_friction.unwrap_or(0.0) * speed;
        let own = [own(p.acceleration, p.velocity), own(p.jerk, p.acceleration)];
        Wave { load: tau.map(|t| phi * t), own, speed: p.velocity }
    }

    fn look(&self, n: f64) -> Look {
        let (motor, bus, joint) = (&self.motor, &self.robot.bus, self.joint());
        let (gear, asked, r, k_t) = (&joint.gear, &joint.limits, motor.resistance, motor.torque_constant);
        // A brushed motor has no d axis. Without inductance or pole pairs the voltage is R i + K_B N ω.
        let brushless = motor.conventions.commutation == Commutation::Brushless;
        let inductive = motor.inductance.zip(if brushless { motor.pole_pairs } else { Some(0) });
        let (l, poles) = inductive.unwrap_or((0.0, 0));
        // Shaft torque: at standstill friction is nothing in means, and opposes the motor in limits.
        let smooth = |w: &Wave| w.load[0] / n + n * w.own[0];
        let friction = |towards: f64| motor.coulomb_friction.unwrap_or(0.0).copysign(towards);
        let usual = |w: &Wave| smooth(w) + if w.speed == 0.0 { 0.0 } else { friction(w.speed) };
        let most = |w: &Wave| smooth(w) + friction(if w.speed == 0.0 { smooth(w) } else { w.speed });
        let power = |w: &Wave| r * (most(w) / k_t).powi(2) + motor.back_emf_constant * n * w.speed * most(w) / k_t;
        let voltage = |w: &Wave| {
            let (i, rate) = (most(w) / k_t, (w.load[1] / n + n * w.own[1]) / k_t);
            let v_q = r * i + l * rate + motor.back_emf_constant * n * w.speed;
            v_q.hypot(f64::from(poles) * n * w.speed * l * i)
        };
        fn largest<T>(list: &[T], f: impl Fn(&T) -> f64) -> f64 {
            list.iter().map(f).fold(f64::NEG_INFINITY, f64::max)
        }
        let torque = |waves: &[Wave]| largest(waves, |w| most(w).abs());
        let mean =
            |at: usize, f: &dyn Fn(usize) -> f64| (0..self.raw.len()).map(|k| self.shares[k][at] * f(k)).sum::<f64>();
        let square = mean(0, &|k| usual(&self.waves[k]).powi(2));
        let (rms, holding) = (square.sqrt(), (square + mean(1, &|k| usual(&self.waves[k]).powi(2))).sqrt());
        let watt = largest(&self.waves, power) / bus.drive_efficiency;
        let back = largest(&self.waves, |w| -power(w)) * bus.drive_efficiency;
        let speed = n * largest(&self.raw, |p| p.velocity.abs());
        let loads = asked.safety * largest(&self.raw, |p| p.torque.abs());
        let inertia = n * n * self.rotating_inertia();
        let stages = |ratio: f64| (0..99).map(f64::from).find(|k| n <= ratio.powf(k + 1e-12)).unwrap();
        let mass = motor.mass.unwrap() + gear.mass_per_stage.map_or(0.0, |(mass, ratio)| mass * stages(ratio));
        // Bounds.
        let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
        let amplitude = if brushless { 1.5_f64.sqrt() } else { 1.0 };
        let current = least(motor.peak_current, joint.drive_current.or(bus.drive_current).map(|i| i * amplitude));
        let circle = if bus.modulation == Modulation::Sine { 0.375_f64.sqrt() } else { 0.5_f64.sqrt() };
        let volt = Some(bus.voltage * bus.modulation_limit * if brushless { circle } else { 1.0 });
        let hot = least(motor.max_winding_temperature, asked.winding_temperature).zip(motor.thermal_resistance);
        let resistance = |kelvin: f64| r * (1.0 + 0.0039 * (kelvin - motor.reference_temperature));
        let hot = hot.map(|(hot, r_th)| ((hot - self.robot.ambient) / (r_th * resistance(hot))).sqrt());
        let timed = |bound: Option<f64>| bound.filter(|_| joint.motion.course != Course::Points(None));
        let stands = brushless && self.shares.iter().any(|share| share[1] > 0.0);
        let (ripples, safety) = (asked.torque_bandwidth.is_some(), asked.safety);
        let limits = [
            ("peak_current", safety * torque(&self.waves) / k_t, current),
            ("peak_torque", safety * torque(&self.waves), motor.peak_torque),
            ("continuous_current", rms / k_t, timed(motor.continuous_current)),
            ("continuous_torque", rms, timed(motor.continuous_torque)),
            ("winding_temperature", rms / k_t, timed(hot)),
            ("standstill_holding", holding / k_t, timed(motor.continuous_current.or(hot)).filter(|_| stands)),
            ("voltage", largest(&self.waves, voltage), volt),
            ("max_speed", speed, motor.max_speed),
            ("gear_input_speed", speed, gear.max_input_speed),
            ("gear_peak_torque", loads, gear.peak_torque),
            ("gear_continuous_torque", mean(0, &|k| self.raw[k].torque.powi(2)).sqrt(), timed(gear.continuous_torque)),
            ("reflected_inertia", inertia, asked.reflected_inertia),
            ("torque_bandwidth_current", safety * torque(&self.rippled) / k_t, current.filter(|_| ripples)),
            (
                "torque_bandwidth_voltage",
                largest(&self.rippled, voltage),
                volt.filter(|_| ripples && inductive.is_some()),
            ),
            ("bus_power", watt, bus.power),
            ("bus_current", watt / bus.voltage, bus.current),
            ("regeneration", back, if let Regeneration::Limited(most) = bus.regeneration { Some(most) } else { None }),
            ("actuator_mass", mass, asked.actuator_mass),
        ];
        let quantities = [r * square / (k_t * k_t), inertia, torque(&self.waves) / k_t, mass];
        let objective =
            joint.objective.terms.iter().map(|(quantity, weight)| weight * quantities[*quantity as usize]).sum();
        Look { quantities, objective, limits }
    }

    /// By how much each limit that applies is exceeded (absolutely, where nothing is allowed).
    fn excess(&self, n: f64) -> impl Iterator<Item = (f64, &'static str)> {
        let over = |demand: f64, bound: f64| if bound > 0.0 { demand / bound - 1.0 } else { demand };
        self.look(n).limits.into_iter().filter_map(move |(name, demand, bound)| Some((over(demand, bound?), name)))
    }

    fn worst(&self, n: f64) -> (f64, &'static str) {
        self.excess(n).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }
}

// ------------------------------------------------------------------ the scan

/// Golden section for the least of `f` between two ratios.
fn golden(f: impl Fn(f64) -> f64, [a, b]: [f64; 2]) -> f64 {
    let (a, b) = (0..60).fold((a, b), |(a, b), _| {
        let (c, d) = (b - 0.618_034 * (b - a), a + 0.618_034 * (b - a));
        if f(c) <= f(d) { (a, d) } else { (c, b) }
    });
    0.5 * (a + b)
}

/// The neighbours of each local minimum in a list of ratios with values.
fn dips(seen: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let around = |i: usize| [seen[i.saturating_sub(1)], seen[i], seen[(i + 1).min(seen.len() - 1)]];
    let dip = |[a, b, c]: [[f64; 2]; 3]| ((a == b || b[1] < a[1]) && b[1] <= c[1]).then_some([a[0], c[0]]);
    (0..seen.len()).filter_map(|i| dip(around(i))).collect()
}

/// The least of `f` over the windows: their ends, the grid between them, and refined around its dips.
fn least_over(windows: &[[f64; 2]], grid: &[f64], f: impl Fn(f64) -> f64) -> f64 {
    let mut least = f64::INFINITY;
    for &[a, b] in windows {
        let inside = grid.iter().copied().filter(|n| a < *n && *n < b);
        let seen: Vec<[f64; 2]> = [a].into_iter().chain(inside).chain([b]).map(|n| [n, f(n)]).collect();
        let refined = dips(&seen).into_iter().map(|between| f(golden(&f, between)));
        least = seen.iter().map(|at| at[1]).chain(refined).fold(least, f64::min);
    }
    least
}

/// The feasible intervals; the grid with the extrema of the violation, where a feasible ratio may hide
/// between infeasible ones or the other way round; the least violation.
fn scan(case: &Case, min: f64, max: f64) -> (Vec<[f64; 2]>, Vec<f64>, (f64, &'static str)) {
    let mut grid: Vec<f64> = (0..RATIOS).map(|i| min * (max / min).powf(i as f64 / (RATIOS - 1) as f64)).collect();
    grid[RATIOS - 1] = max;
    let per_stage = case.joint().gear.mass_per_stage;
    grid.extend(
        per_stage.iter().flat_map(|(_, ratio)| (0..30).map(|k| ratio.powi(k))).filter(|n| (min..max).contains(n)),
    );
    grid.sort_by(f64::total_cmp);
    let violation = |sign: f64| move |n: f64| sign * case.worst(n).0;
    for sign in [1.0, -1.0] {
        let seen: Vec<[f64; 2]> = grid.iter().map(|n| [*n, violation(sign)(*n)]).collect();
        grid.extend(dips(&seen).into_iter().map(|between| golden(violation(sign), between)));
        grid.sort_by(f64::total_cmp);
    }
    let over: Vec<f64> = grid.iter().map(|n| case.worst(*n).0).collect();
    // Bisection between an infeasible and a feasible ratio ends on the feasible side.
    let halve = |(bad, good), _| {
        let n = 0.5 * (bad + good);
        if case.worst(n).0 > 0.0 { (n, good) } else { (bad, n) }
    };
    let mut ends = Vec::new();
    ends.extend((over[0] <= 0.0).then_some(min));
    for i in 1..grid.len() {
        match (over[i - 1] > 0.0, over[i] > 0.0) {
            (true, false) => ends.push((0..60).fold((grid[i - 1], grid[i]), halve).1),
            (false, true) => ends.push((0..60).fold((grid[i], grid[i - 1]), halve).1),
            _ => {}
        }
    }
    ends.extend((over[grid.len() - 1] <= 0.0).then_some(max));
    let least = grid.iter().map(|n| case.worst(*n)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    (ends.chunks(2).map(|window| [window[0], window[1]]).collect(), grid, least)
}

// ------------------------------------------------------------------ random cases

/// What every case starts from.
const MOTOR: &str = "id,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A],mass [kg]\nmotor,none,derived,q_axis,q_axis,1,1,1";
const ROBOT: &str = "name='r'\n[bus]\nvoltage='1 V'\n[[joint]]\nname='j'\nratio={min=1,max=2}\npoints=[{torque='1 N*m',speed='1 rad/s'}]";

/// Uniform in the logarithm.
fn around(d: &mut Pcg64, a: f64, b: f64) -> f64 {
    a * (b / a).powf(d.random::<f64>())
}

/// One to four harmonics: value, first and second derivative by the time.
fn wave(d: &mut Pcg64, size: f64, period: f64) -> impl Fn(f64) -> [f64; 3] + use<> {
    let turns = |d: &mut Pcg64| TAU / period * f64::from(d.random_range(1..6));
    let draw = |d: &mut Pcg64| (size * d.random_range(0.1..1.0), turns(d), d.random_range(0.0..TAU));
    let harmonics: Vec<(f64, f64, f64)> = (0..d.random_range(1..5)).map(|_| draw(d)).collect();
    // Each derivative brings a factor w and a quarter of a turn.
    let turn = |k: i32, t: f64| {
        move |(a, w, phase): &(f64, f64, f64)| a * w.powi(k) * (w * t + phase + 0.25 * TAU * f64::from(k)).sin()
    };
    move |t| [0, 1, 2].map(|k| harmonics.iter().map(turn(k, t)).sum())
}

/// Draws a case: a motor and a motion that suit each other at some ratio, and limits around what is
/// needed near it. A convex one has neither Coulomb friction nor a regeneration limit nor a weighted
/// objective that bends the wrong way; the others have at least one of them.
fn draw(index: u64, convex: bool) -> Case {
    let d = &mut Pcg64::seed_from_u64(index);
    let [rubs, regenerates, peaked, stepped] =
        [0, 1, 2, 3].map(|kind| !convex && (index % 4 == kind || d.random_bool(0.15)));
    // The motion: harmonics at uneven times with stretches and single samples at standstill, or points.
    let (period, speed, matched) = (around(d, 0.2, 3.0), around(d, 0.5, 30.0), around(d, 3.0, 60.0));
    let (form, rippled) = (d.random_range(0.0..1.0), d.random_bool(0.2));
    let (fewest, most) = if form > 0.8 { (1.0, 12.0) } else { (8.0, if rippled { 24.0 } else { 301.0 }) };
    let count = around(d, fewest, most) as usize;
    let (rotor, of_gear) = (around(d, 1e-7, 1e-3), around(d, 1e-8, 1e-4) * f64::from(d.random_range(0..2)));
    let torque = (rotor + of_gear) * speed * TAU / period * matched * matched * around(d, 0.2, 5.0);
    let (load, turn, offset) = (wave(d, torque, period), wave(d, speed, period), d.random_range(-torque..torque));
    let rest = d.random_range(0..count);
    let rest = rest..rest + d.random_range(0..3) * count / 8;
    let (mut time, mut raw) = (Vec::new(), Vec::new());
    for k in 0..count {
        let t = period * (k as f64 + d.random_range(0.0..0.5)) / count as f64;
        let ([tau, torque_rate, _], turning) = (load(t), turn(t));
        let [velocity, acceleration, jerk] = if rest.contains(&k) { [0.0; 3] } else { turning };
        let velocity = if d.random_bool(0.02) { 0.0 } else { velocity };
        let duration = (form < 0.93).then(|| around(d, 0.1, 2.0));
        raw.push(Point { torque: tau + offset, velocity, acceleration, torque_rate, jerk, duration });
        time.push(t);
    }
    let course = if form < 0.55 { Course::Periodic(period) } else { Course::Once(time[count - 1] - time[0]) };
    let column = |f: fn(&Point) -> f64| raw.iter().map(f).collect::<Vec<f64>>();
    let (velocity, acceleration) = (Some(column(|p| p.velocity)), Some(column(|p| p.acceleration)));
    let (torque_rate, jerk) = (Some(column(|p| p.torque_rate)), Some(column(|p| p.jerk)));
    let given =
        Samples { time, torque: column(|p| p.torque), velocity, acceleration, torque_rate, jerk, position: None };
    // The motor: R i and K_B N ω of like size.
    let brushless = d.random_bool(0.9);
    let mut motor = Catalog::from_sources(vec![Arc::new(Source::new("motor.csv", MOTOR))]).unwrap().motors.remove(0);
    motor.conventions.commutation = if brushless { Commutation::Brushless } else { Commutation::Brushed };
    motor.resistance = around(d, 0.02, 5.0);
    motor.torque_constant = (motor.resistance * torque / speed * around(d, 0.5, 50.0)).sqrt() / matched;
    motor.back_emf_constant = motor.torque_constant * d.random_range(0.85_f64..1.15).min(1.0);
    motor.rotor_inertia = Some(rotor);
    motor.inductance =
        [None, Some(0.0), Some(motor.resistance * around(d, 1e-5, 4e-3))][d.random_range(0_usize..12).min(2)];
    motor.pole_pairs = if brushless { Some(d.random_range(1..23)).filter(|p| *p < 22) } else { Some(0) };
    motor.viscous_friction = d.random_bool(0.4).then(|| rotor * around(d, 0.1, 10.0));
    motor.coulomb_friction = rubs.then(|| torque / matched * around(d, 0.01, 0.5));
    motor.reference_temperature = d.random_range(288.0..300.0);
    // Bus and joint.
    let mut robot = read_source(&Arc::new(Source::new("robot.toml", ROBOT))).unwrap();
    robot.ambient = d.random_range(285.0..315.0);
    robot.bus.modulation = if d.random_bool(0.3) { Modulation::Sine } else { Modulation::SpaceVector };
    (robot.bus.modulation_limit, robot.bus.drive_efficiency) = (d.random_range(0.85..1.0), d.random_range(0.85..1.0));
    let joint = &mut robot.joints[0];
    joint.motion = if form > 0.8 { Motion::from_points(&raw) } else { Motion::from_samples(given, course) };
    joint.gear.efficiency = d.random_range(0.5_f64..1.3).min(1.0);
    joint.gear.backdrive_efficiency =
        [2.0 - 1.0 / joint.gear.efficiency, d.random_range(-0.2..1.0)][d.random_range(0..2)];
    joint.gear.inertia = of_gear;
    joint.gear.mass_per_stage =
        (stepped || d.random_bool(0.4)).then(|| (around(d, 0.05, 2.0), d.random_range(3.0..10.0)));
    let middle = matched * around(d, 0.4, 2.5);
    joint.ratio = RatioChoice::Continuous { min: middle * around(d, 0.01, 0.8), max: middle * around(d, 1.25, 100.0) };
    let ripple = TorqueBandwidth { frequency: around(d, 1.0, 60.0), amplitude: torque * around(d, 0.05, 1.0) };
    joint.limits.torque_bandwidth = rippled.then_some(ripple);
    joint.limits.safety = d.random_range(0.5_f64..1.5).max(1.0);
    // Limits: each is there or not, and allows more or less than the middle ratio needs.
    let mut case = Case::new(motor, robot, raw);
    let at = case.look(middle);
    let need: BTreeMap<&str, f64> = at.limits.iter().map(|limit| (limit.0, limit.1)).collect();
    let (often, low, high) =
        ([0.1, 0.25, 0.5][d.random_range(0..3)], [0.5, 0.95][d.random_range(0..2)], around(d, 1.1, 4.0));
    let mut allow =
        |name: &str| Some(need[name] * around(d, low, high)).filter(|bound| d.random_bool(often) && *bound > 0.0);
    let ripple =
        |name: &str| if rippled { format!("torque_bandwidth_{name}") } else { name.replace("current", "peak_current") };
    let (joint, bus, motor) = (&mut case.robot.joints[0], &mut case.robot.bus, &mut case.motor);
    bus.voltage = allow(&ripple("voltage")).unwrap_or(4.0 * need["voltage"]) / 0.6;
    bus.drive_current = allow(&ripple("current")).map(|i| i / 1.2);
    bus.power = allow("bus_power");
    bus.current = allow("bus_power").map(|watt| watt / bus.voltage);
    bus.regeneration =
        if regenerates { Regeneration::Limited(allow("regeneration").unwrap_or(0.0)) } else { Regeneration::Allowed };
    motor.peak_current = allow(&ripple("current"));
    motor.peak_torque = allow("peak_torque");
    motor.continuous_current = allow("standstill_holding");
    motor.continuous_torque = allow("continuous_torque");
    motor.max_speed = allow("max_speed");
    motor.thermal_resistance = allow("standstill_holding").map(|i| 60.0 / (i * i * motor.resistance));
    motor.max_winding_temperature = Some(400.0).filter(|_| index % 3 > 0);
    joint.limits.winding_temperature = Some(390.0 + (index % 20) as f64);
    joint.drive_current = allow(&ripple("current")).map(|i| i / 1.2);
    joint.gear.max_input_speed = allow("gear_input_speed");
    joint.gear.peak_torque = allow("gear_peak_torque").map(|bound| 1.6 * bound);
    joint.gear.continuous_torque = allow("gear_continuous_torque").map(|bound| 1.6 * bound);
    joint.limits.reflected_inertia = allow("reflected_inertia");
    joint.limits.actuator_mass = allow("actuator_mass").map(|bound| 1.2 * bound);
    let loss = (Quantity::Loss, 1.0);
    let mut and = |quantity: Quantity| {
        let share = at.quantities[0] / at.quantities[quantity as usize] * around(d, 0.2, 5.0);
        vec![loss, (quantity, share)]
    };
    joint.objective.terms = match index / 4 % 20 {
        _ if peaked => and(Quantity::PeakCurrent),
        _ if stepped => and(Quantity::Mass),
        0..10 => vec![loss],
        10..13 => and(Quantity::ReflectedInertia),
        13..16 => vec![(Quantity::PeakCurrent, 1.0)],
        16..18 => vec![(Quantity::ReflectedInertia, 1.0)],
        _ => vec![(Quantity::Mass, 1.0)],
    };
    case
}

// ------------------------------------------------------------------ the comparison

/// What came of a case: disagreements, the limits that bind, and how far numbers are apart.
#[derive(Default)]
struct Verdict {
    feasible: bool,
    close: bool,
    wrong: Vec<String>,
    binding: Vec<&'static str>,
    apart: Vec<(&'static str, f64)>,
}

impl Verdict {
    fn must(&mut self, holds: bool, what: String) {
        self.wrong.extend((!holds).then_some(what));
    }

    fn near(&mut self, what: &'static str, apart: f64, most: f64) {
        self.apart.push((what, apart));
        self.must(apart <= most, format!("{what}: {apart:e}"));
    }
}

fn compare(case: &Case, convex: bool) -> Verdict {
    let RatioChoice::Continuous { min, max } = case.joint().ratio else { unreachable!() };
    let (windows, grid, least) = scan(case, min, max);
    let close = least.0.abs() < CLOSE || !windows.is_empty() && windows.iter().all(|[a, b]| b / a - 1.0 < NARROW);
    let mut v = Verdict { feasible: !windows.is_empty(), close, ..Verdict::default() };
    let catalog = Catalog { motors: vec![case.motor.clone()], gears: Vec::new() };
    let result = optimize(&case.robot, &catalog);
    let reason = result.joints[0].rejected.first().map(|rejected| &rejected.reason);
    let excess =
        |limit: &str, n: f64| case.excess(n).find(|(_, name)| *name == limit).map_or(f64::NAN, |(over, _)| over);
    match (result.joints[0].candidates.first(), reason) {
        (Some(_), _) | (_, Some(Reason::Infeasible(_))) if close => {}
        (Some(design), _) if v.feasible => compare_designs(case, convex, design, &windows, &grid, &mut v),
        // What is said of the cause must hold: at every ratio, or just beyond the two that contradict.
        (_, Some(Reason::Infeasible(why))) if !v.feasible => {
            v.binding.push(least.1);
            v.must(
                match why {
                    Infeasible::Never { bind, least, .. } => {
                        *least > 1.0 && grid.iter().all(|n| excess(bind.limit, *n) >= least - 1.0 - 1e-9)
                    }
                    Infeasible::Contradiction { low, at_least, high, at_most } => {
                        let low = low.limit == "ratio_min" && *at_least == min
                            || excess(low.limit, at_least * (1.0 - NARROW)) > 0.0;
                        let high = high.limit == "ratio_max" && *at_most == max
                            || excess(high.limit, at_most * (1.0 + NARROW)) > 0.0;
                        low && high && at_least > at_most
                    }
                    Infeasible::Nowhere { .. } => !convex,
                },
                format!("not true: {why:?}"),
            );
        }
        _ => v.must(false, format!("{reason:?}, but the scan finds {windows:?}, least violation {least:?}")),
    }
    v
}

/// Everything that is said of the best design, against the windows and the grid of the scan.
fn compare_designs(case: &Case, convex: bool, design: &Design, windows: &[[f64; 2]], grid: &[f64], v: &mut Verdict) {
    let (n, optimum, evaluation) = (design.optimum.ratio, &design.optimum, &design.evaluation);
    let (at, usual) = (case.look(n), case.look((grid[0] * grid[grid.len() - 1]).sqrt()));
    // Relative; where a single operating point can be met without any torque, to what is usual.
    let above = |a: f64, b: f64, usual: f64| 0.5 * (a * a - b * b) / (b * b).max(1e-6 * usual * usual);
    let best = least_over(windows, grid, |n| case.look(n).objective);
    v.near("objective above the best", above(optimum.objective, best, usual.objective), 1e-6);
    v.near("objective below the best", -above(optimum.objective, best, usual.objective), 1e-8);
    v.near("objective at N*", above(optimum.objective, at.objective, usual.objective).abs(), 1e-9);
    if case.joint().objective.sole() == Some(Quantity::Mass) {
        // The declared tie-break: among the ratios of least mass the one of least loss.
        let lossy =
            |n| Some(case.look(n).quantities).filter(|q| q[3] <= best * (1.0 + 1e-12)).map_or(f64::INFINITY, |q| q[0]);
        v.near(
            "loss at least mass",
            above(at.quantities[0], least_over(windows, grid, lossy), usual.quantities[0]),
            1e-6,
        );
    }
    let worst = case.worst(n);
    v.must(evaluation.feasible && worst.0 <= CLOSE, format!("N* = {n} violates {worst:?}"));
    v.binding.extend((worst.0 > -CLOSE).then_some(worst.1));
    // Windows, and what ends them: beyond the end the limit that is named must be exceeded.
    let wide = |list: &[[f64; 2]]| list.iter().copied().filter(|[a, b]| b / a - 1.0 > NARROW).collect::<Vec<_>>();
    let theirs: Vec<[f64; 2]> = optimum.windows.iter().map(|w| [w.min, w.max]).collect();
    let (mine, theirs) = (wide(windows), wide(&theirs));
    v.must(
        mine.len() == theirs.len() && (!convex || mine.len() == 1),
        format!("windows {theirs:?}, but the scan has {mine:?}"),
    );
    for (a, b) in mine.iter().flatten().zip(theirs.iter().flatten()).filter(|_| mine.len() == theirs.len()) {
        v.near("window end", (a / b - 1.0).abs(), NARROW);
    }
    v.must(
        theirs.iter().any(|[a, b]| a * (1.0 - 1e-9) <= n && n <= b * (1.0 + 1e-9)),
        format!("N* = {n} outside {theirs:?}"),
    );
    for (bind, end, beyond) in
        optimum.windows.iter().flat_map(|w| [(&w.low, w.min, 1.0 - NARROW), (&w.high, w.max, 1.0 + NARROW)])
    {
        let edge = if beyond < 1.0 { ("ratio_min", grid[0]) } else { ("ratio_max", grid[grid.len() - 1]) };
        let named = case.excess(end * beyond).any(|(over, name)| name == bind.limit && over > 0.0);
        v.must(named || (bind.limit, end) == edge, format!("{bind:?} does not bind at {end}"));
        v.binding.extend(named.then_some(bind.limit));
    }
    // The proof.
    match optimum.certificate {
        Certificate::Certified { lower_bound, gap, .. } => {
            v.must(convex, "certified".into());
            v.near("lower bound above the best", above(lower_bound, best, usual.objective), 1e-9);
            v.near("gap", gap, 1e-6);
        }
        Certificate::NotCertified(why) => v.must(!convex, format!("not certified: {why}")),
    }
    // The figures and the margins.
    for (q, theirs) in [evaluation.loss, evaluation.reflected_inertia, evaluation.peak_current].into_iter().enumerate()
    {
        v.near("loss, inertia, current", above(theirs, at.quantities[q], usual.quantities[q]).abs(), 1e-9);
    }
    let asked: Vec<_> =
        at.limits.iter().filter_map(|(name, demand, bound)| Some((*name, *demand, (*bound)?))).collect();
    v.must(
        evaluation.margins.iter().map(|m| m.limit).eq(asked.iter().map(|a| a.0)),
        format!("limits {:?}", evaluation.margins),
    );
    for (margin, (_, demand, bound)) in evaluation.margins.iter().zip(asked).filter(|(_, (_, _, bound))| *bound > 0.0) {
        v.near("margin", (margin.margin - (1.0 - demand.max(0.0) / bound)).abs(), 1e-8);
    }
}

/// Compares cases in parallel and says how it went; `limits` is the number of limits that must bind somewhere.
fn run(cases: std::ops::Range<u64>, convex: bool, limits: usize) {
    let verdicts: Vec<(u64, Verdict)> = cases.into_par_iter().map(|i| (i, compare(&draw(i, convex), convex))).collect();
    let count = |f: fn(&Verdict) -> bool| verdicts.iter().filter(|(_, v)| f(v)).count();
    let (feasible, close) = (count(|v| v.feasible), count(|v| v.close));
    let (mut binding, mut apart) = (BTreeMap::new(), BTreeMap::new());
    for (_, v) in &verdicts {
        v.binding.iter().for_each(|limit| *binding.entry(limit).or_insert(0) += 1);
        for (what, x) in &v.apart {
            let most: &mut f64 = apart.entry(what).or_insert(*x);
            *most = most.max(*x);
        }
    }
    println!("{} cases, {feasible} feasible, {close} too close to call; binding: {binding:#?}", verdicts.len());
    println!("furthest apart: {apart:#?}");
    let wrong: Vec<_> = verdicts.iter().filter(|(_, v)| !v.wrong.is_empty()).collect();
    for (i, verdict) in wrong.iter() {
        println!(
            "SHORT {convex} {i} K={} obj={:?}: {:?}",
            draw(*i, convex).raw.len(),
            draw(*i, convex).joint().objective.terms,
            verdict.wrong
        );
    }
    for (i, v) in wrong.iter().take(5) {
        let case = draw(*i, convex);
        println!("case {i}: {:#?}\n{:?}\n{:?}\n{:?}", v.wrong, case.motor, case.robot, case.raw);
    }
    assert!(wrong.is_empty(), "{} cases disagree: {:?}", wrong.len(), wrong.iter().map(|w| w.0).collect::<Vec<_>>());
    assert!(close * 50 < verdicts.len() && feasible < verdicts.len() * 4 / 5 && binding.len() >= limits);
}

#[test]
fn convex_programs_agree_with_a_scan_of_the_raw_waveforms() {
    run(0..800, true, 17);
}

#[test]
fn other_programs_agree_with_a_scan_of_the_raw_waveforms() {
    run(1000..1300, false, 18);
}
