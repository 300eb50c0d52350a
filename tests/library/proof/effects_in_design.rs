//! Fitted effects in sweep and ratio program against a second look at them, straight from the raw waveforms:
//! torque, current, heat and voltage of every sample, effect by effect, in the plainest way.

use std::sync::Arc;

use gearwise::actuator::Load;
use gearwise::actuator::estimate::complete;
use gearwise::catalog::convention::Commutation;
use gearwise::catalog::fitted::FittedGear;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::answer::Reason;
use gearwise::design::optimize::optimize;
use gearwise::design::program::Certificate;
use gearwise::design::remake::remake;
use gearwise::design::{Evaluation, Mount, Prepared};
use gearwise::effects::FittedEffect;
use gearwise::input::Source;
use gearwise::measured::fitted::fitted_motor;
use gearwise::measured::identify::{Found, Parameter, Report, Target, Verdict};
use gearwise::measured::{Bench, Declared};
use gearwise::report::json::remake::Remade;
use gearwise::report::remake as report;
use gearwise::requirement::*;
use rayon::prelude::*;

use crate::cases::quarter;
use crate::raw::{self, Case, draw};
use crate::solved;

/// Effects that are tried, one after the other, and some together.
const KINDS: [&[&str]; 15] = [
    &["torque_offset"],
    &["direction_asymmetry"],
    &["viscous_friction", "coulomb_friction"],
    &["load_dependent_friction"],
    &["cogging", "cogging"],
    &["torque_ripple"],
    &["gear_ripple"],
    &["torque_constant_saturation"],
    &["torque_constant_temperature"],
    &["inverter_dead_time"],
    &["stribeck_friction"],
    &["eddy_drag"],
    &["cogging", "torque_ripple", "torque_constant_saturation", "inverter_dead_time"],
    &["direction_asymmetry", "torque_offset", "stribeck_friction", "eddy_drag"],
    &["load_dependent_friction", "torque_constant_saturation", "direction_asymmetry"],
];

/// A number between 0.2 and 1 that depends on its place alone.
fn chance(case: u64, place: u64) -> f64 {
    let mixed = (case * 97 + place * 31 + 7).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    0.2 + 0.8 * (mixed >> 40) as f64 / (1_u64 << 24) as f64
}

fn middle(case: &Case) -> f64 {
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    (min * max).sqrt()
}

/// Values of an effect that matter at the torques and speeds of a case.
fn values(case: &Case, name: &str, c: impl Fn(u64) -> f64) -> Vec<f64> {
    let motor = &case.motor;
    let (n, k_t) = (middle(case), motor.torque_constant);
    let current = (case.look(n).quantities[1] / motor.resistance).sqrt();
    let torque = k_t * current;
    let speed = n * case.raw.iter().map(|p| p.velocity.abs()).fold(1e-3, f64::max);
    match name {
        "torque_offset" => vec![0.2 * torque * c(0)],
        "coulomb_friction" => vec![0.2 * torque * c(0)],
        "viscous_friction" => vec![0.2 * torque / speed * c(0)],
        "direction_asymmetry" => vec![-0.1 * torque / speed * c(0)],
        "load_dependent_friction" => vec![0.2 * c(0)],
        "cogging" | "gear_ripple" => vec![0.1 * torque * c(0), -0.1 * torque * c(1), 12.0],
        "torque_ripple" => vec![0.05 * k_t * c(0), 0.05 * k_t * c(1), 6.0],
        "torque_constant_saturation" => vec![0.5 * k_t * c(0), 2.0 * current * c(1)],
        "torque_constant_temperature" => vec![0.002 * k_t * c(0)],
        "inverter_dead_time" => vec![0.03 * case.robot.bus.voltage * c(0), 0.1],
        "stribeck_friction" => vec![0.2 * torque * c(0), 0.1 * speed * c(1)],
        "eddy_drag" => vec![0.2 * torque * c(0), 0.3 * speed * c(1)],
        _ => unreachable!(),
    }
}

fn fitted(motor: &Motor, effects: Vec<(&str, Vec<f64>)>) -> Motor {
    let effects = effects.into_iter().map(|(name, values)| FittedEffect::new(name, values).unwrap()).collect();
    Motor { effects, ..motor.clone() }
}

/// A random joint with some effects, and an objective that they show in.
fn with_effects(i: u64, convex: bool) -> Case {
    let mut case = draw(i, convex);
    let kind = KINDS[i as usize % KINDS.len()];
    let effects =
        kind.iter().enumerate().map(|(place, name)| (*name, values(&case, name, |k| chance(i, 10 * place as u64 + k))));
    case.motor = fitted(&case.motor, effects.collect());
    let quantity = match i % 4 {
        0 => Quantity::PeakCurrent,
        1 if case.robot.joints[0].motion.has_durations() => Quantity::Energy,
        _ => Quantity::CopperLoss,
    };
    case.robot.joints[0].objective = Objective::single(quantity);
    case
}

/// What a ratio comes to, effect by effect.
struct Own {
    loss: f64,
    peak_current: f64,
    energy: f64,
    /// Name, demand and bound of the limits that effects change.
    limits: Vec<(&'static str, f64, f64)>,
}

fn own(case: &Case, n: f64) -> Own {
    let (motor, robot, joint) = (&case.motor, &case.robot, &case.robot.joints[0]);
    let of =
        |name: &str| motor.effects.iter().filter(|e| e.name() == name).map(|e| e.values.clone()).collect::<Vec<_>>();
    let sum = |name: &str| of(name).iter().map(|v| v[0]).sum::<f64>();
    let hot = [motor.max_winding_temperature, joint.limits.winding_temperature].into_iter().flatten().reduce(f64::min);
    let rise = hot.map_or(0.0, |t| (t - motor.reference_temperature).max(0.0));
    let (r, k) = (motor.resistance, motor.torque_constant - sum("torque_constant_temperature") * rise);
    let k_b = motor.emf_constant();
    // The gear: its friction in proportion to torque is its loss.
    let gamma = sum("load_dependent_friction");
    let (driving, braking) = if gamma > 0.0 {
        (1.0 + gamma, 1.0 - gamma)
    } else {
        (1.0 / joint.gear.efficiency, joint.gear.backdrive_efficiency)
    };
    let j = motor.rotor_inertia.unwrap() + joint.gear.inertia;
    let b = motor.viscous_friction.unwrap_or(0.0) + sum("viscous_friction");
    let c = motor.coulomb_friction.unwrap_or(0.0) + sum("coulomb_friction");
    let (a, offset) = (sum("direction_asymmetry"), sum("torque_offset"));
    let drag = |w: f64, s: f64| {
        let stribeck: f64 = of("stribeck_friction").iter().map(|v| v[0] * s * (-(w / v[1]) * (w / v[1])).exp()).sum();
        let eddy: f64 =
            of("eddy_drag").iter().map(|v| if w == 0.0 { 0.0 } else { 2.0 * v[0] / (w / v[1] + v[1] / w) }).sum();
        stribeck + eddy
    };
    let phi = |p: &Point| if p.torque * p.velocity < 0.0 { braking } else { driving };
    let torque_through = |phi: f64, p: &Point, s: f64| {
        let w = n * p.velocity;
        phi * p.torque / n + n * j * p.acceleration + b * w + c * s + offset + a * w.abs() + drag(w, s)
    };
    let torque = |p: &Point, s: f64| torque_through(phi(p), p, s);
    let rate = |p: &Point, s: f64| {
        let (w, step) = (n * p.velocity, 1e-4 * (1.0 + n * p.velocity.abs()) * 1e-1);
        let slope = (drag(w + step, s) - drag(w - step, s)) / (2.0 * step);
        phi(p) * p.torque_rate / n + n * (j * p.jerk + b * p.acceleration + (a * s + slope) * p.acceleration)
    };
    let signs = |p: &Point| if p.velocity == 0.0 { vec![1.0, -1.0] } else { vec![p.velocity.signum()] };
    // What stands needs no more and no less than the load, in means.
    let usual = |p: &Point| match p.velocity {
        0.0 => torque_through(1.0, p, 0.0),
        v => torque(p, v.signum()),
    };
    let largest = |list: &[Point], f: &dyn Fn(&Point, f64) -> f64| {
        list.iter()
            .flat_map(|p| signs(p).into_iter().map(move |s| f(p, s)).collect::<Vec<_>>())
            .fold(f64::NEG_INFINITY, f64::max)
    };
    // Ripple and saturation.
    let ripples: Vec<f64> = [of("cogging"), of("gear_ripple")].concat().iter().map(|v| v[0].hypot(v[1])).collect();
    let (ripple, ripple_square) = (ripples.iter().sum::<f64>(), ripples.iter().map(|x| x * x / 2.0).sum::<f64>());
    let shares: Vec<f64> = of("torque_ripple").iter().map(|v| v[0].hypot(v[1]) / k).collect();
    let (share, factor) = (shares.iter().sum::<f64>(), (1.0 - shares.iter().map(|x| x * x).sum::<f64>()).powf(-1.5));
    let curve =
        |i: f64| of("torque_constant_saturation").iter().fold(k * i, |t, v| t - v[0] * (i - v[1] * (i / v[1]).tanh()));
    let current = |t: f64| {
        let (mut low, mut high) = (0.0, 4.0 * t / k + 1e-9);
        while curve(high) < t {
            high *= 2.0;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if curve(middle) < t { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    let heating = |p: &Point| current(((usual(p).powi(2) + ripple_square) * factor).sqrt()).powi(2);
    let shares_here = case.shares_at(n);
    let timed = || case.raw.iter().zip(&shares_here);
    let mean = |f: &dyn Fn(&Point) -> f64| timed().map(|(p, s)| s[0] * f(p)).sum::<f64>();
    let squared_current = mean(&heating);
    let at_rest = timed().map(|(p, s)| s[1] * heating(p)).sum::<f64>();
    // Voltage and power taken, of the winding at its hottest.
    let r_hot = r * raw::hottest_factor(motor, joint.limits.winding_temperature);
    let brushless = motor.conventions.commutation == Commutation::Brushless;
    let (l, poles) = (motor.inductance.unwrap_or(0.0), motor.pole_pairs.filter(|_| brushless).unwrap_or(0));
    // Or at ambient, with cold magnets.
    let r_cold = (r * raw::ambient_factor(motor, robot.ambient)).min(r_hot);
    let voltage = |p: &Point, s: f64| {
        // Flux saturates with the torque, the ohmic drop has the whole current; where it opposes the rest the larger value counts.
        let v_q = |per_torque: f64| {
            let straight = per_torque * torque(p, s) + l * rate(p, s) / k + k_b * n * p.velocity;
            let more = per_torque * (k * current(torque(p, s).abs()) - torque(p, s).abs());
            straight.abs().max((straight + more.copysign(torque(p, s))).abs())
        };
        let most = v_q(r_hot / k).max(v_q(r_cold / motor.torque_constant));
        most.hypot(f64::from(poles) * n * p.velocity * l * torque(p, s) / k)
    };
    let power =
        |p: &Point, s: f64| r_hot * current(torque(p, s).abs()).powi(2) + k_b * n * p.velocity * torque(p, s) / k;
    let magnitude = |p: &Point, s: f64| torque(p, s).abs();
    let most = largest(&case.raw, &magnitude);
    let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
    let amplitude = if brushless { 1.5_f64.sqrt() } else { 1.0 };
    let safety = joint.limits.safety;
    let left = |largest: f64| (largest * (1.0 - share) - safety * ripple).max(0.0);
    let current_bound =
        least(motor.peak_current, joint.drive_current.or(robot.bus.drive_current).map(|i| i * amplitude));
    let current_bound = current_bound.map(|i| left(curve(i)) / k);
    let circle = if robot.bus.modulation == gearwise::catalog::convention::Modulation::Sine {
        0.375_f64.sqrt()
    } else {
        0.5_f64.sqrt()
    };
    let volt = robot.bus.voltage * robot.bus.modulation_limit * if brushless { circle } else { 1.0 }
        - sum("inverter_dead_time");
    let watt = largest(&case.raw, &power) / robot.bus.drive_efficiency;
    let mut limits = Vec::new();
    let mut limit = |name, demand, bound: Option<f64>| limits.extend(bound.map(|bound| (name, demand, bound)));
    limit("peak_current", safety * most / k, current_bound);
    limit("peak_torque", safety * most, motor.peak_torque.map(left));
    let ways = [motor.sheet.thermal_resistance_winding_housing, motor.sheet.thermal_resistance_housing_ambient];
    let own = if let [Some(a), Some(b)] = ways { a.value / (a.value + b.value) } else { 1.0 };
    // A motion that happens once, from cold, has no steady state of heat.
    let steady = !matches!(joint.motion.course, Course::Once(_));
    let continuous_current = motor.continuous_current.filter(|_| steady);
    limit("continuous_current", squared_current.sqrt(), continuous_current);
    limit(
        "continuous_torque",
        (mean(&|p| usual(p).powi(2)) + ripple_square).sqrt(),
        motor.continuous_torque.filter(|_| steady),
    );
    limit("standstill_holding", (squared_current + own * at_rest).sqrt(), continuous_current);
    limit("voltage", largest(&case.raw, &voltage), Some(volt));
    limit("bus_power", watt, robot.bus.power);
    if !case.rippled.is_empty() {
        limit("torque_bandwidth_current", safety * largest(&case.rippled, &magnitude) / k, current_bound);
        limit("torque_bandwidth_voltage", largest(&case.rippled, &voltage), Some(volt));
    }
    if let Some(nodes) = case.nodes() {
        let bound = hot.map(|t| (t - robot.ambient).max(0.0));
        limit("winding_peak_temperature", nodes.peak(&case.heat(n, |p| r * heating(p))), bound);
    }
    let drawn = |p: &Point| {
        let watt = r * heating(p) + k_b * n * p.velocity * usual(p) / k;
        (watt / robot.bus.drive_efficiency).max(watt * robot.bus.drive_efficiency)
    };
    let energy = joint.motion.duration().unwrap_or(0.0) * mean(&drawn);
    Own { loss: r * squared_current, peak_current: current((most + ripple) / (1.0 - share)), energy, limits }
}

fn evaluate(case: &Case, n: f64) -> Evaluation {
    let joint = &case.robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    Prepared::new(Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap()).at(n)
}

fn near(a: f64, b: f64, most: f64) -> bool {
    a == b || (a - b).abs() <= most * a.abs().max(b.abs()).max(1e-12)
}

/// Every figure that effects change, at ratios across the range.
#[test]
fn every_sample_of_every_effect_agrees_with_a_plain_loop() {
    let wrong: Vec<String> = (0..300_u64)
        .into_par_iter()
        .flat_map_iter(|i| {
            let case = with_effects(i, i % 2 == 0);
            let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
            let mut wrong = Vec::new();
            for share in [0.05, 0.35, 0.6, 0.95] {
                let n = min * (max / min).powf(share);
                let (theirs, ours) = (evaluate(&case, n), own(&case, n));
                let kind = KINDS[i as usize % KINDS.len()];
                let mut tell =
                    |what: &str, a: f64, b: f64| wrong.push(format!("case {i} {kind:?} N = {n}: {what} {a} {b}"));
                if !near(theirs.copper_loss, ours.loss, 1e-8) {
                    tell("copper loss", theirs.copper_loss, ours.loss);
                }
                // Beyond the largest torque the saturated current is a continuation.
                if !near(theirs.peak_current, ours.peak_current, 1e-8) {
                    tell("peak current", theirs.peak_current, ours.peak_current);
                }
                for margin in &theirs.margins {
                    let Some((_, demand, bound)) = ours.limits.iter().find(|l| l.0 == margin.limit) else { continue };
                    if !near(margin.demand, *demand, 1e-6) && (margin.demand - demand).abs() > 1e-9 * bound {
                        tell(margin.limit, margin.demand, *demand);
                    }
                    if margin.limit != "standstill_holding" && !near(margin.bound, *bound, 1e-9) {
                        tell(margin.limit, margin.bound, *bound);
                    }
                }
            }
            wrong
        })
        .collect();
    assert!(wrong.is_empty(), "{} disagree:\n{}", wrong.len(), wrong[..wrong.len().min(20)].join("\n"));
}

fn objective(case: &Case, own: &Own) -> f64 {
    match case.robot.joints[0].objective.sole() {
        Some(Quantity::PeakCurrent) => own.peak_current,
        Some(Quantity::Energy) => own.energy,
        _ => own.loss,
    }
}

/// The best ratio of the program against the best of many, and its certificate.
#[test]
fn the_best_ratio_is_the_best_of_many() {
    let counted: Vec<(bool, bool, Vec<String>)> = quarter(1000, 150)
        .into_par_iter()
        .map(|i| {
            let case = with_effects(i, i % 2 == 0);
            let kind = KINDS[i as usize % KINDS.len()];
            let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
            let result = solved::solve(&case.motor, &case.robot);
            let mut wrong = Vec::new();
            let grid: Vec<f64> = (0..=200).map(|k| min * (max / min).powf(f64::from(k) / 200.0)).collect();
            // What the sweep says of feasibility is checked above; here only the search is.
            let feasible: Vec<f64> = grid.into_iter().filter(|n| evaluate(&case, *n).feasible).collect();
            let best = feasible.iter().map(|n| objective(&case, &own(&case, *n))).fold(f64::INFINITY, f64::min);
            let evaluated = kind.contains(&"stribeck_friction") || kind.contains(&"eddy_drag");
            let mut tell = |what: String| wrong.push(format!("case {i} {kind:?}: {what}"));
            // A single point can be met without any torque: measured by what is usual, as rounding is by its terms.
            let usual = objective(&case, &own(&case, middle(&case))).abs();
            let above = |a: f64, b: f64| match a.min(b) {
                least if least < 0.0 => (a - b) / b.abs().max(1e-3 * usual),
                _ => 0.5 * (a * a - b * b) / (b * b).max(1e-6 * usual * usual),
            };
            match &result {
                Ok(design) => {
                    let here = objective(&case, &own(&case, design.optimum.ratio));
                    if above(design.optimum.objective, here).abs() > 1e-7 {
                        tell(format!("objective {} but {here}", design.optimum.objective));
                    }
                    if best.is_finite() && above(design.optimum.objective, best) > 1e-6 {
                        tell(format!("objective {} but {best} was found", design.optimum.objective));
                    }
                    if !design.evaluation.feasible {
                        tell(format!("N* = {} is not feasible", design.optimum.ratio));
                    }
                    match &design.optimum.certificate {
                        Certificate::NotCertified(why) if evaluated => {
                            let why = why.to_string();
                            if !kind.iter().any(|name| why.contains(name)) || !why.contains("grid of ratios") {
                                tell(format!("marked as {why}"));
                            }
                        }
                        Certificate::Certified { lower_bound, .. } if !evaluated => {
                            if best.is_finite() && above(*lower_bound, best) > 1e-8 {
                                tell(format!("lower bound {lower_bound} above {best}"));
                            }
                        }
                        other => tell(format!("certificate {other:?}")),
                    }
                }
                Err(why) if !feasible.is_empty() => tell(format!("{why:?}, but N = {} will do", feasible[0])),
                Err(why) => {
                    if matches!(why, Reason::NotSolved(_) | Reason::Unbounded) {
                        tell(format!("{why:?}"));
                    }
                }
            }
            (result.is_err(), evaluated, wrong)
        })
        .collect();
    let wrong: Vec<&String> = counted.iter().flat_map(|c| &c.2).collect();
    let feasible = counted.iter().filter(|c| !c.0).count();
    println!("{} cases, {feasible} feasible", counted.len());
    assert!(wrong.is_empty(), "{} disagree:\n{wrong:#?}", wrong.len());
    assert!(4 * feasible > counted.len(), "{feasible} feasible");
}

/// Two cases that must come to the same at every ratio.
fn same(a: &Case, b: &Case, most: f64) {
    let RatioChoice::Continuous { min, max } = a.robot.joints[0].ratio else { unreachable!() };
    for share in [0.1, 0.5, 0.9] {
        let n = min * (max / min).powf(share);
        let (x, y) = (evaluate(a, n), evaluate(b, n));
        assert!(
            near(x.loss, y.loss, most)
                && near(x.copper_loss, y.copper_loss, most)
                && near(x.peak_current, y.peak_current, most),
            "{x:?}\n{y:?}"
        );
        for (p, q) in x.margins.iter().zip(&y.margins) {
            assert_eq!(p.limit, q.limit);
            assert!(near(p.demand, q.demand, most) && near(p.bound, q.bound, most), "{p:?}\n{q:?}");
        }
    }
}

#[test]
fn effects_that_are_nothing_change_nothing() {
    for i in 0..60 {
        let plain = draw(i, true);
        let nothing: [(&str, Vec<f64>, f64); 7] = [
            ("direction_asymmetry", vec![0.0], 0.0),
            ("torque_offset", vec![0.0], 0.0),
            ("cogging", vec![0.0, 0.0, 12.0], 0.0),
            ("torque_ripple", vec![0.0, 0.0, 12.0], 0.0),
            ("torque_constant_saturation", vec![0.5 * plain.motor.torque_constant, 1e9], 1e-9),
            ("stribeck_friction", vec![0.0, 1.0], 1e-9),
            ("gear_compliance", vec![1e-3], 0.0),
        ];
        for (name, values, most) in nothing {
            let other = Case { motor: fitted(&plain.motor, vec![(name, values)]), ..draw(i, true) };
            same(&plain, &other, most);
        }
    }
}

#[test]
fn load_dependent_friction_is_the_gears_efficiency() {
    for i in 0..60 {
        let mut geared = draw(i, true);
        let gamma = 0.3 * chance(i, 1);
        geared.robot.joints[0].gear.efficiency = 1.0 / (1.0 + gamma);
        geared.robot.joints[0].gear.backdrive_efficiency = backdrive_efficiency(1.0 / (1.0 + gamma));
        // The requirement's own efficiency is replaced, whatever it is.
        let mut found = draw(i, true);
        found.motor = fitted(&found.motor, vec![("load_dependent_friction", vec![gamma])]);
        same(&geared, &found, 1e-12);
        // So is it by the fitted gear.
        let mut of_file = draw(i, true);
        let efficiency = Some(1.0 / (1.0 + gamma));
        of_file.motor.fitted_gear = Some(FittedGear { efficiency, ..FittedGear::default() });
        same(&geared, &of_file, 1e-12);
    }
}

const FITTED: &str = r#"gearwise = "0.1.0"
[motor]
id = "t-motor-ri50-fitted"
manufacturer = "T-Motor"
terminals = "q_axis"
current = "q_axis"
back_emf_convention = "q_axis"
resistance = "0.7 ohm"
inductance = "0.6 mH"
torque_constant = "0.1 N*m/A"
torque_constant_tolerance = "0.002 N*m/A"
back_emf_constant = "0.1 V*s/rad"
rotor_inertia = "90 g*cm^2"
mass = "193 g"
mass_tolerance = "2 %"
pole_pairs = 7
peak_current = "30 A"
coulomb_friction = "0.01 N*m"
[gear]
efficiency = 0.93
inertia = "1e-6 kg*m^2"
[effects.stribeck_friction]
torque = "0.01 N*m"
torque_tolerance = "0.0004 N*m"
speed = "8 rad/s"
[[effects.cogging]]
cosine = "0.004 N*m"
sine = "0.003 N*m"
order = 12
[[effects.cogging]]
cosine = "-0.001 N*m"
sine = "0 N*m"
order = 24
[covariance]
names = ["torque_constant", "inertia"]
matrix = [[1e-6, 0.0], [0.0, 1e-12]]
[[provenance]]
log = "g1711.csv"
sha256 = "00ff"
use = "fit"
"#;

fn read(text: &str) -> Result<Catalog, String> {
    let source = Arc::new(Source::new("fitted.toml", text));
    Catalog::from_sources(vec![source]).map_err(|e| e.iter().map(ToString::to_string).collect())
}

#[test]
fn a_fitted_actuator_is_read_as_a_motor() {
    let catalog = read(FITTED).unwrap();
    let motor = catalog.motor("t-motor-ri50-fitted").unwrap();
    assert!(near(motor.torque_constant, 0.1, 1e-12) && near(motor.rotor_inertia.unwrap(), 9e-6, 1e-12));
    assert!(near(motor.sheet.mass.unwrap().tolerance.unwrap(), 0.00386, 1e-9));
    let expected = [
        FittedEffect::new("cogging", vec![0.004, 0.003, 12.0]).unwrap(),
        FittedEffect::new("cogging", vec![-0.001, 0.0, 24.0]).unwrap(),
        FittedEffect::new("stribeck_friction", vec![0.01, 8.0]).unwrap(),
    ];
    assert_eq!(motor.effects, expected);
    assert_eq!(motor.fitted_gear.unwrap().efficiency, Some(0.93));
    let fit = motor.fit.as_ref().unwrap();
    assert_eq!((fit.version.as_str(), fit.names.len(), fit.covariance[1][1]), ("0.1.0", 2, 1e-12));
    assert_eq!(fit.tolerances, [("stribeck_friction.torque".to_string(), 0.0004)]);
    assert_eq!((fit.provenance[0].log.as_str(), fit.provenance[0].usage.as_deref()), ("g1711.csv", Some("fit")));
}

#[test]
fn mistakes_in_fitted_files_are_said_with_their_place() {
    for (from, to, expected) in [
        ("[effects.stribeck_friction]", "[effects.stribek_friction]", "did you mean `stribeck_friction`"),
        ("torque = \"0.01 N*m\"\ntorque_t", "torque = 0.01\ntorque_t", "has no unit"),
        ("mass = \"193 g\"", "mass = \"-193 g\"", "`mass` of [motor] is out of range"),
        ("speed = \"8 rad/s\"", "", "`speed` of [stribeck_friction] is missing"),
        ("speed = \"8 rad/s\"", "speed = \"8 N*m\"", "`speed`"),
        ("terminals = \"q_axis\"\n", "", "`terminals` of [motor] is missing"),
        ("resistance = \"0.7 ohm\"\n", "", "`resistance` of [motor] is missing"),
        ("[[1e-6, 0.0], [0.0, 1e-12]]", "[[1e-6, 0.0]]", "the covariance does not fit its names"),
        ("efficiency = 0.93", "efficiency = 93", "out of range"),
        ("[gear]", "[gears]", "unknown key `gears`"),
        (
            "[effects.stribeck_friction]\ntorque = \"0.01 N*m\"\ntorque_tolerance = \"0.0004 N*m\"\nspeed = \"8 rad/s\"",
            "[effects.coulomb_friction]\ntorque = \"0.01 N*m\"",
            "duplicate",
        ),
        ("gearwise = \"0.1.0\"\n", "", "`gearwise` is missing"),
    ] {
        let text = FITTED.replacen(from, to, 1);
        assert_ne!(text, FITTED, "{from}");
        let error = read(&text).expect_err(to);
        assert!(error.contains(expected), "{to}: {error}");
        assert!(error.contains("fitted.toml:"), "{error}");
    }
}

/// A fitted motor in place of its row: what changes, and what the old choice costs.
#[test]
fn the_choice_is_made_again() {
    let mut seen = 0;
    for i in 0..120 {
        let case = draw(i, true);
        let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
        let id = case.motor.id.as_str();
        // The same motor: nothing changes, and no regret.
        let again = &remake(&case.robot, &catalog, id, &case.motor)[0];
        let (Some(before), Ok(after)) = (&again.before, &again.after.outcome) else { continue };
        let before = before.outcome.as_ref().unwrap();
        assert_eq!((before.ratio, before.objective, again.after.rank), (after.ratio, after.objective, Some(1)));
        assert!(again.regret.as_ref().unwrap().relative.is_none_or(|r| r.abs() < 1e-9) && again.output_side.is_none());
        // Friction behind a gear: the program's own choice, and another where the friction is the output's.
        let mut motor = case.motor.clone();
        motor.coulomb_friction =
            Some(motor.coulomb_friction.unwrap_or(0.0) + values(&case, "coulomb_friction", |_| 1.0)[0]);
        motor.fitted_gear = Some(FittedGear { ratio: Some(0.3 * middle(&case)), ..FittedGear::default() });
        let remade = &remake(&case.robot, &catalog, id, &motor)[0];
        let alone = complete(Catalog::of(vec![motor], Vec::new()));
        let solved = optimize(&case.robot, &alone);
        match (&remade.after.outcome, solved.joints[0].candidates.first()) {
            (Ok(chosen), Some(design)) => {
                assert_eq!(chosen.ratio, design.optimum.ratio);
                let own = remade.own_regret.as_ref().unwrap();
                assert!(own.broken.is_some() || own.relative.is_none_or(|r| r > -1e-6), "{own:?}");
                let (text, json) = (
                    report::text(std::slice::from_ref(remade)),
                    serde_json::to_value(Remade::new(std::slice::from_ref(remade))),
                );
                assert!(text.contains("as declared") && text.contains("as fitted") && text.contains(id), "{text}");
                let json = &json.unwrap()["joints"][0];
                assert_eq!(json["after"]["ratio"].as_f64(), Some(chosen.ratio));
                assert_eq!(json["own_regret"]["feasible"].as_bool(), Some(own.broken.is_none()));
                if let Some(Ok(output)) = remade.output_side.as_ref().map(|c| &c.outcome) {
                    seen += usize::from((output.ratio / chosen.ratio - 1.0).abs() > 1e-6);
                }
            }
            (Err(_), None) => {}
            other => panic!("{other:?}"),
        }
    }
    assert!(seen > 5, "only {seen} cases in which the side of the friction matters");
}

fn parameter(name: &str, fitted: f64, standard_error: Option<f64>) -> Parameter {
    Parameter { name: name.into(), declared: None, fitted, standard_error, undecided: None, unit: "1" }
}

/// What identification reports becomes the motor of the bench with other numbers.
#[test]
fn reports_make_a_fitted_motor() {
    let catalog = Catalog::builtin().unwrap();
    let motor = catalog.motor("t-motor-ri50").unwrap().clone();
    let gear = GearModel { inertia: 1e-6, ..GearModel::IDEAL };
    let declared = Declared {
        motor: Some(motor.clone()),
        ratio: 7.5,
        gear,
        mass: None,
        force_gain: 1.0,
        viscous_friction: None,
        coulomb_friction: None,
        fixture_inertia: 0.0,
        effects: vec![FittedEffect::new("eddy_drag", vec![0.01, 100.0]).unwrap()],
        without: Vec::new(),
    };
    let readings = gearwise::measured::bench::Readings::default();
    let bench = Bench {
        name: "bench".into(),
        path: "bench.toml".into(),
        catalog,
        declared,
        logs: Vec::new(),
        readings,
        files: Vec::new(),
    };
    let found = |name, instances: Vec<Vec<f64>>| {
        let effect = gearwise::effects::effect(name).unwrap();
        Found {
            effect,
            parameters: vec![parameter("torque", instances[0][0], Some(1e-4))],
            instances,
            size: 0.0,
            held_out_before: None,
            held_out_after: None,
            confounded_with: Vec::new(),
        }
    };
    let report = Report {
        target: Target::Torque,
        unit: "N*m",
        band: None,
        samples: (0, 0),
        evidence: Default::default(),
        verdict: Verdict::Explained,
        stages: Vec::new(),
        findings: Vec::new(),
        artefacts: Vec::new(),
        parameters: vec![
            parameter("torque_constant", 0.09, Some(0.001)),
            parameter("inertia", 11e-6, Some(1e-7)),
            parameter("resistance", 9.0, None),
            parameter("eddy_drag.torque", 0.02, Some(1e-3)),
        ],
        effects: vec![
            found("coulomb_friction", vec![vec![0.03]]),
            found("cogging", vec![vec![0.01, 0.0, 12.0], vec![0.0, 0.02, 24.0]]),
        ],
        refused: Vec::new(),
        unexplained: Vec::new(),
        next_runs: Vec::new(),
        remarks: Vec::new(),
        fitted_names: Vec::new(),
        covariance: Vec::new(),
        pictures: Default::default(),
    };
    let fitted = fitted_motor(&bench, &[report]).unwrap();
    assert!(near(fitted.torque_constant, 0.09, 1e-12) && near(fitted.rotor_inertia.unwrap(), 1e-5, 1e-12));
    // What was held stays as declared; the row is on the q axis.
    assert_eq!(fitted.resistance, motor.resistance);
    let printed = fitted.sheet.torque_constant.unwrap();
    assert_eq!((printed.value, printed.tolerance), (0.09, Some(0.00196)));
    assert_eq!((fitted.coulomb_friction, fitted.fitted_gear.unwrap().ratio), (Some(0.03), Some(7.5)));
    let expected = [
        FittedEffect::new("cogging", vec![0.01, 0.0, 12.0]).unwrap(),
        FittedEffect::new("cogging", vec![0.0, 0.02, 24.0]).unwrap(),
        FittedEffect::new("eddy_drag", vec![0.02, 100.0]).unwrap(),
    ];
    assert_eq!(fitted.effects, expected);
}
