//! A parallel spring chosen together with the ratio, against scans of ratio, stiffness and rest angle
//! straight from the raw waveforms.
//!
//! The reference below knows neither rows nor cones: torque, current, voltage and power of every sample
//! are computed in the plainest way at one ratio and one spring, and many of them are looked at. The number
//! of a case is the seed it is drawn from.

use std::cell::RefCell;
use std::f64::consts::TAU;

use approx::assert_relative_eq;
use gearwise::actuator::Load;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::answer::Design;
use gearwise::design::optimize::optimize;
use gearwise::design::program::Certificate;
use gearwise::design::robot;
use gearwise::requirement::{
    Course, EfficiencyCovers, GearModel, Motion, Objective, Quantity, RatioChoice, Regeneration, Robot, Samples,
    Spring, backdrive_efficiency,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::common;

/// A motor, a robot with one joint and a spring, and the raw samples.
struct Case {
    motor: Motor,
    robot: Robot,
    raw: Samples,
    period: f64,
    /// The motion as the library has it, weighed as with a spring, for the degrees to which slow samples are at rest.
    load: Load,
}

/// What one ratio with one spring comes to.
struct Look {
    objective: f64,
    loss: f64,
    /// Largest demand over its limit, minus one.
    excess: f64,
}

impl Case {
    fn look(&self, n: f64, stiffness: f64, rest: f64) -> Look {
        let (motor, joint, bus) = (&self.motor, &self.robot.joints[0], &self.robot.bus);
        let (gear, raw) = (&joint.gear, &self.raw);
        let (r, k_t, l) = (motor.resistance, motor.torque_constant, motor.inductance.unwrap_or(0.0));
        let poles = f64::from(motor.pole_pairs.unwrap_or(0));
        // The winding at its hottest, where that is known: here by a highest temperature or not at all.
        let (t_0, hottest) = (motor.reference_temperature, joint.limits.winding_temperature);
        assert!(motor.max_winding_temperature.is_none() && motor.thermal_resistance.is_none());
        // 100 °C where nothing says it.
        let t = hottest.unwrap_or(373.15);
        let at = |t: f64| r * (1.0 + (t - t_0) / (1.0 / 0.003_93 + t_0 - 293.15));
        // The voltage is that of the hottest or of the coldest winding.
        let (r_hot, r_cold) = (at(t), at(self.robot.ambient).min(at(t)));
        let j = motor.rotor_inertia.unwrap() + gear.inertia;
        let (b, c) = (motor.viscous_friction.unwrap_or(0.0), motor.coulomb_friction.unwrap_or(0.0));
        let count = raw.time.len();
        let slow = self.load.standing(2.0 * if poles > 0.0 { poles } else { 2.0 } * n, 5.1);
        let mut standing = 0.0;
        let column = |values: &Option<Vec<f64>>, k: usize| values.as_ref().unwrap()[k];
        let (mut mean, mut peak, mut volt, mut watt, mut back, mut out) =
            (0.0, 0.0_f64, 0.0_f64, f64::MIN, f64::MIN, 0.0_f64);
        let (mut drawn, mut lost, mut wear, mut fast) = (0.0, 0.0, 0.0, 0.0);
        for k in 0..count {
            let (q, omega) = (column(&raw.position, k), column(&raw.velocity, k));
            let (alpha, jerk) = (column(&raw.acceleration, k), column(&raw.jerk, k));
            let tau = raw.torque[k] + stiffness * (q - rest);
            let rate = column(&raw.torque_rate, k) + stiffness * omega;
            let phi = if tau * omega < 0.0 { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
            let t = phi * tau / n + n * (j * alpha + b * omega) + c * omega.signum();
            let t_rate = phi * rate / n + n * (j * jerk + b * alpha);
            let i = t / k_t;
            let [v_hot, v_cold] = [r_hot, r_cold].map(|r| r * i + l * t_rate / k_t + motor.emf_constant() * n * omega);
            let v_q = v_hot.abs().max(v_cold.abs());
            let v_d = poles * n * omega * l * i;
            let work = motor.emf_constant() * n * omega * i;
            let (power, taken) = (r * i * i + work, r_hot * i * i + work);
            // The trapezoid rule, periodic.
            let before =
                if k > 0 { raw.time[k] - raw.time[k - 1] } else { self.period + raw.time[0] - raw.time[count - 1] };
            let after =
                if k + 1 < count { raw.time[k + 1] - raw.time[k] } else { self.period + raw.time[0] - raw.time[k] };
            let share = 0.5 * (before + after) / self.period;
            mean += share * i * i;
            standing += (slow.share(k, 1.0) - slow.share(k, 0.0)) * i * i;
            wear += share * omega.abs() * tau.abs().powi(3);
            fast += share * omega.abs();
            let from_bus = power * if power > 0.0 { 1.0 / bus.drive_efficiency } else { bus.drive_efficiency };
            drawn += share * from_bus;
            // Copper, what the gear takes, what rubs, and what the drive takes.
            let speed = n * omega.abs();
            let parts = [r * i * i, (phi - 1.0) * tau * omega, speed * (c + b * speed), from_bus - power];
            lost += share * parts.iter().sum::<f64>();
            (peak, volt, out) = (peak.max(i.abs()), volt.max(v_q.hypot(v_d)), out.max(tau.abs()));
            (watt, back) = (watt.max(taken), back.max(-(r_cold * i * i + work)));
        }
        let inertia = n * n * j;
        let mut excess = f64::MIN;
        let mut limit = |demand: f64, bound: Option<f64>| {
            if let Some(bound) = bound {
                excess = excess.max(if bound > 0.0 { demand / bound - 1.0 } else { demand });
            }
        };
        limit(peak, motor.peak_current);
        limit((mean + standing).sqrt(), motor.continuous_current);
        limit(volt, Some(bus.voltage * 0.5_f64.sqrt()));
        limit(out, gear.peak_torque);
        limit((wear / fast).cbrt(), gear.ratings.average_torque);
        limit(inertia, joint.limits.reflected_inertia);
        limit(watt / bus.drive_efficiency, bus.power);
        if let Regeneration::Limited(bound) = bus.regeneration {
            limit(back * bus.drive_efficiency, Some(bound));
        }
        let loss = r * mean;
        let quantity = |q: Quantity| match q {
            Quantity::CopperLoss => loss,
            Quantity::Loss => lost,
            Quantity::ReflectedInertia => inertia,
            Quantity::PeakCurrent => peak,
            Quantity::Energy => drawn * self.period,
            Quantity::PeakPower => watt.max(0.0) / bus.drive_efficiency,
            Quantity::Mass => {
                let (mass, stage) = gear.mass_per_stage.unwrap();
                motor.mass.unwrap() + mass * (0..9).find(|k| n <= stage.powi(*k) * (1.0 + 1e-12)).map_or(9.0, f64::from)
            }
        };
        let objective = joint.objective.terms.iter().map(|(q, w)| w * quantity(*q)).sum();
        Look { objective, loss, excess }
    }

    fn ranges(&self) -> [[f64; 2]; 3] {
        let joint = &self.robot.joints[0];
        let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
        let spring = joint.limits.spring.unwrap();
        [[min.ln(), max.ln()], spring.stiffness, spring.rest_angle]
    }

    /// The best feasible of a grid over ratio, stiffness and rest angle, then of ever finer grids around
    /// the best so far.
    fn scan(&self, coarse: [usize; 3], levels: usize) -> Option<(f64, [f64; 3])> {
        let whole = self.ranges();
        let mut around = whole;
        let mut best: Option<(f64, [f64; 3])> = None;
        for level in 0..=levels {
            let count = if level == 0 { coarse } else { coarse.map(|c| c.min(7)) };
            let x = |d: usize, i: usize| match count[d] {
                1 => 0.5 * (around[d][0] + around[d][1]),
                n => around[d][0] + (around[d][1] - around[d][0]) * i as f64 / (n - 1) as f64,
            };
            for i in 0..count[0] {
                for j in 0..count[1] {
                    for m in 0..count[2] {
                        let at = [x(0, i), x(1, j), x(2, m)];
                        let look = self.look(at[0].exp(), at[1], at[2]);
                        if look.excess <= 0.0 && best.is_none_or(|(f, _)| look.objective < f) {
                            best = Some((look.objective, at));
                        }
                    }
                }
            }
            let centre = best?.1;
            for d in 0..3 {
                let reach = 0.5 * (whole[d][1] - whole[d][0]) * 0.4 * 0.75_f64.powi(level as i32);
                around[d] = [(centre[d] - reach).max(whole[d][0]), (centre[d] + reach).min(whole[d][1])];
            }
        }
        best
    }
}

/// What may be in a case besides a spring.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Convex,
    Efficiency,
    Coulomb,
    Regeneration,
    WeightedPeak,
    SteppedMass,
    AverageTorque,
}

fn draw(seed: u64, kind: Kind) -> Case {
    let generator = RefCell::new(Pcg64::seed_from_u64(seed));
    let within = |a: f64, b: f64| generator.borrow_mut().random_range(a..b);
    let around = |a: f64, b: f64| a * (b / a).powf(within(0.0, 1.0));
    let chance = |share: f64| within(0.0, 1.0) < share;
    let (period, matched, rotor) = (around(0.4, 3.0), around(4.0, 40.0), around(1e-6, 1e-4));
    let count = within(8.0, 40.0) as usize;
    let harmonics: Vec<[f64; 3]> =
        (0..3).map(|h| [within(0.1, 0.8) / (h + 1) as f64, TAU / period * (h + 1) as f64, within(0.0, TAU)]).collect();
    let offset = within(-1.0, 1.0);
    let turn = |t: f64, d: i32| {
        let sum: f64 =
            harmonics.iter().map(|[a, w, x]| a * w.powi(d) * (w * t + x + f64::from(d) * TAU / 4.0).sin()).sum();
        sum + if d == 0 { offset } else { 0.0 }
    };
    let reach = rotor * matched * matched * (TAU / period).powi(2) * around(0.5, 6.0);
    let (pull, rest, wave, constant) =
        (reach * within(0.2, 2.0), within(-0.8, 0.8), within(0.0, 0.6), within(-0.5, 0.5));
    let (w, x) = (TAU / period * within(1.0, 4.0).floor(), within(0.0, TAU));
    let time: Vec<f64> = (0..count).map(|k| period * (k as f64 + within(0.0, 0.5)) / count as f64).collect();
    let column = |f: &dyn Fn(f64) -> f64| time.iter().map(|t| f(*t)).collect::<Vec<f64>>();
    let raw = Samples {
        torque: column(&|t| -pull * (turn(t, 0) - rest) + reach * (constant + wave * (w * t + x).sin())),
        position: Some(column(&|t| turn(t, 0))),
        velocity: Some(column(&|t| turn(t, 1))),
        acceleration: Some(column(&|t| turn(t, 2))),
        torque_rate: Some(column(&|t| -pull * turn(t, 1) + reach * wave * w * (w * t + x).cos())),
        jerk: Some(column(&|t| turn(t, 3))),
        time: time.clone(),
    };
    let mut motor = common::motor(&[
        ("resistance [ohm]", "1"),
        ("torque_constant [N*m/A]", "1"),
        ("rotor_inertia [kg*m^2]", "1e-5"),
    ]);
    motor.rotor_inertia = Some(rotor);
    motor.resistance = around(0.05, 2.0);
    let speed = harmonics.iter().map(|[a, w, _]| a * w).sum::<f64>();
    motor.torque_constant = (motor.resistance * reach / speed * around(1.0, 20.0)).sqrt() / matched;
    motor.back_emf_constant = motor.torque_constant;
    motor.pole_pairs = chance(0.7).then_some(7);
    motor.inductance = chance(0.7).then(|| motor.resistance * around(1e-4, 3e-3));
    motor.viscous_friction = chance(0.4).then(|| rotor * around(0.1, 5.0));
    motor.coulomb_friction = (kind == Kind::Coulomb).then(|| reach / matched * around(0.02, 0.3));
    let efficiency = if kind == Kind::Efficiency { within(0.6, 0.97) } else { 1.0 };
    let gear = GearModel { efficiency, backdrive_efficiency: backdrive_efficiency(efficiency), ..GearModel::IDEAL };
    let motion = Motion::from_samples(raw.clone(), Course::Periodic(period));
    let mut robot = common::robot(motion, gear);
    robot.bus.drive_efficiency = within(0.85, 1.0);
    let joint = &mut robot.joints[0];
    if kind == Kind::SteppedMass {
        motor.mass = Some(0.3);
        joint.gear.mass_per_stage = Some((0.4, 6.0));
    }
    joint.ratio = RatioChoice::Continuous { min: matched * within(0.2, 0.7), max: matched * within(1.5, 5.0) };
    let stiffness = [if chance(0.6) { 0.0 } else { pull * within(0.1, 0.9) }, pull * within(1.0, 3.0)];
    joint.limits.spring =
        Some(Spring { stiffness, rest_angle: [within(-1.5, -0.2), within(0.0, 1.5)], ..common::SPRING });
    let single = [Quantity::CopperLoss, Quantity::Loss, Quantity::PeakCurrent, Quantity::Energy, Quantity::PeakPower];
    joint.objective = match kind {
        Kind::WeightedPeak => Objective {
            terms: vec![
                (Quantity::CopperLoss, 1.0),
                (Quantity::PeakCurrent, motor.resistance * reach / matched / motor.torque_constant),
            ],
        },
        Kind::SteppedMass => Objective {
            terms: vec![
                (Quantity::Loss, 1.0),
                (Quantity::Mass, 0.3 * motor.resistance * (reach / matched / motor.torque_constant).powi(2)),
            ],
        },
        _ => Objective::single(single[within(0.0, 5.0) as usize]),
    };
    let motion = Motion { sprung: true, ..Motion::clone(&robot.joints[0].motion) };
    let load = Load::new(&motion, None);
    let mut case = Case { motor, robot, raw, period, load };
    // Every third case has a given ratio, every third a given rest angle: plane scans see those densely.
    let n = matched * around(0.6, 1.6);
    let joint = &mut case.robot.joints[0];
    match seed % 3 {
        0 => joint.ratio = RatioChoice::Continuous { min: n, max: n },
        1 => joint.limits.spring.as_mut().unwrap().rest_angle = [0.5 * rest; 2],
        _ => {}
    }
    // Limits around what the best ratio and spring without them need.
    let [n, k, rest] = case.scan([[1, 15, 15], [15, 15, 1], [11, 9, 9]][(seed % 3) as usize], 6).unwrap().1;
    let need = |f: &dyn Fn(&mut Case)| {
        let mut other = Case {
            motor: case.motor.clone(),
            robot: case.robot.clone(),
            raw: case.raw.clone(),
            period,
            load: case.load.clone(),
        };
        f(&mut other);
        other.look(n.exp(), k, rest).excess + 1.0
    };
    let current = need(&|c| c.motor.peak_current = Some(1.0));
    let thermal = need(&|c| c.motor.continuous_current = Some(1.0));
    let volt = need(&|c| c.robot.bus.voltage = 2.0_f64.sqrt());
    let torque = need(&|c| c.robot.joints[0].gear.peak_torque = Some(1.0));
    let average = need(&|c| c.robot.joints[0].gear.ratings.average_torque = Some(1.0));
    let watt = need(&|c| c.robot.bus.power = Some(1.0));
    let back = need(&|c| c.robot.bus.regeneration = Regeneration::Limited(1.0));
    case.motor.peak_current = chance(0.6).then(|| current * around(0.85, 1.1));
    case.motor.continuous_current = chance(0.3).then(|| thermal * around(0.95, 1.2));
    case.robot.bus.voltage = volt * 2.0_f64.sqrt() * if chance(0.5) { around(0.85, 1.2) } else { 5.0 };
    case.robot.joints[0].gear.peak_torque = chance(0.3).then(|| torque * around(0.8, 1.3));
    case.robot.bus.power = chance(0.2).then(|| watt.max(0.1) * around(0.8, 1.3));
    if kind == Kind::Regeneration {
        case.robot.bus.regeneration = Regeneration::Limited(back.max(0.0) * around(0.6, 1.2));
    }
    if kind == Kind::AverageTorque {
        case.robot.joints[0].gear.peak_torque = None;
        case.robot.joints[0].gear.ratings.average_torque = Some(average * around(0.94, 1.02));
    }
    case
}

fn solved<T>(case: &Case, then: impl FnOnce(Result<&Design, String>) -> T) -> T {
    let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
    let result = optimize(&case.robot, &catalog);
    let joint = &result.joints[0];
    match joint.designs().next() {
        Some(design) => then(Ok(design)),
        None => then(Err(format!("{:?}", joint.rejected[0].reason))),
    }
}

/// What neither ratio nor spring changes is compared with its own bound: a motor's size, a gear's backlash and stiffness.
#[test]
fn sizes_are_no_torques() {
    let mut case = draw(4, Kind::Convex);
    (case.motor.peak_current, case.motor.continuous_current) = (None, None);
    (case.robot.joints[0].gear.peak_torque, case.robot.bus.power) = (None, None);
    case.robot.bus.voltage *= 10.0;
    let plain = solved(&case, |found| found.unwrap().optimum.objective);
    let with = |diameter: f64, backlash: f64, shock: f64| {
        let (mut motor, mut robot) = (case.motor.clone(), case.robot.clone());
        motor.sheet.outer_diameter = Some(gearwise::catalog::Printed::exact(1e-6));
        let joint = &mut robot.joints[0];
        (joint.limits.outer_diameter, joint.limits.max_backlash) = (Some(diameter), Some(backlash));
        (joint.limits.min_stiffness, joint.limits.shock_torque) = (Some(1e-6), Some(shock));
        (joint.gear.backlash, joint.gear.stiffness) = (Some(1e-6), Some(2e-6));
        joint.gear.ratings.momentary_peak_torque = Some(2e-6);
        let case = Case { motor, robot, raw: case.raw.clone(), period: case.period, load: case.load.clone() };
        solved(&case, |found| found.map(|design| design.optimum.objective))
    };
    let found = with(2e-6, 2e-6, 1e-6).unwrap();
    assert!((found / plain - 1.0).abs() < 1e-9, "{found} {plain}");
    for (diameter, backlash, shock) in [(5e-7, 2e-6, 1e-6), (2e-6, 5e-7, 1e-6), (2e-6, 2e-6, 3e-6)] {
        assert!(with(diameter, backlash, shock).is_err());
    }
}

#[derive(Default)]
struct Tally {
    feasible: usize,
    certified: usize,
    not_solved: usize,
    infeasible: usize,
    binding: usize,
    agree: usize,
    gap: f64,
    above_scan: f64,
    below_scan: f64,
    wrong: Vec<String>,
}

fn check(seed: u64, kind: Kind) -> Tally {
    let case = draw(seed, kind);
    let coarse = [[1, 81, 81], [81, 81, 1], [21, 13, 13]][(seed % 3) as usize];
    let scan = case.scan(coarse, 45);
    let mut tally = Tally::default();
    let mut wrong = Vec::new();
    solved(&case, |found| match found {
        Ok(design) => {
            let spring = design.spring.expect("a spring was asked for");
            let (n, f) = (design.optimum.ratio, design.optimum.objective);
            let here = case.look(n, spring.stiffness, spring.rest_angle.unwrap_or(0.0));
            tally.feasible = 1;
            tally.binding = usize::from(here.excess > -1e-6);
            if here.excess > 1e-8 {
                wrong.push(format!("a limit is exceeded by {:e}", here.excess));
            }
            if (here.objective / f - 1.0).abs() > 1e-8 || (here.loss / design.evaluation.copper_loss - 1.0).abs() > 1e-8
            {
                wrong.push(format!("objective {f} is {} from the waveforms", here.objective));
            }
            let [_, [k0, k1], [q0, q1]] = case.ranges();
            let rest = spring.rest_angle.unwrap_or(q0);
            if !(k0..=k1).contains(&spring.stiffness) || !(q0..=q1).contains(&rest) {
                wrong.push(format!("the spring {spring:?} is outside its range"));
            }
            match &design.optimum.certificate {
                Certificate::Certified { lower_bound, gap, .. } => {
                    tally.certified = 1;
                    tally.gap = *gap;
                    if *gap > 1e-6 {
                        wrong.push(format!("gap {gap}"));
                    }
                    if scan.is_some_and(|(best, _)| best < lower_bound - 1e-9 * lower_bound.abs()) {
                        wrong.push(format!("the scan found {scan:?}, less than the bound {lower_bound}"));
                    }
                }
                Certificate::NotCertified(why) => {
                    tally.gap = spring.gap.unwrap_or(f64::INFINITY);
                    if kind == Kind::Convex {
                        wrong.push(format!("not certified: {why}, {spring:?}"));
                    }
                    if let (Some(bound), Some((best, _))) = (spring.lower_bound, scan)
                        && best < bound - 1e-9 * bound.abs()
                    {
                        wrong.push(format!("the scan found {best}, less than the bound {bound}"));
                    }
                }
            }
            if let Some((best, at)) = scan {
                let apart = (f - best) / best.abs();
                tally.agree = usize::from(apart.abs() < 1e-5);
                (tally.above_scan, tally.below_scan) = (apart.max(0.0), (-apart).max(0.0));
                if apart > 2e-6 {
                    wrong.push(format!("the scan found {best} at {at:?}, less than {f} at {n} {spring:?}"));
                }
            }
        }
        Err(why) => {
            tally.infeasible = usize::from(why.contains("Infeasible"));
            tally.not_solved = usize::from(why.contains("NotSolved"));
            if let Some((best, at)) = scan {
                wrong.push(format!("rejected: {why}; the scan found {best} at {at:?}"));
            }
        }
    });
    tally.wrong = wrong.into_iter().map(|w| format!("case {seed}: {w}")).collect();
    tally
}

fn run(cases: std::ops::Range<u64>, kind: Kind) -> Tally {
    let tallies: Vec<Tally> = cases.into_par_iter().map(|seed| check(seed, kind)).collect();
    let mut sum = Tally::default();
    let all = tallies.len();
    for mut t in tallies {
        sum.feasible += t.feasible;
        sum.certified += t.certified;
        sum.not_solved += t.not_solved;
        sum.infeasible += t.infeasible;
        sum.binding += t.binding;
        sum.agree += t.agree;
        sum.gap = sum.gap.max(t.gap);
        sum.above_scan = sum.above_scan.max(t.above_scan);
        sum.below_scan = sum.below_scan.max(t.below_scan);
        sum.wrong.append(&mut t.wrong);
    }
    println!(
        "{all} cases, {} feasible, {} infeasible, {} not solved, {} certified, {} with a limit that binds, {} within 1e-5 of \
         the scan; largest gap {:.1e}; above the scan by at most {:.1e}, below by {:.1e}",
        sum.feasible,
        sum.infeasible,
        sum.not_solved,
        sum.certified,
        sum.binding,
        sum.agree,
        sum.gap,
        sum.above_scan,
        sum.below_scan
    );
    for w in &sum.wrong {
        println!("{w}");
    }
    assert!(sum.wrong.is_empty(), "{} findings", sum.wrong.len());
    sum
}

/// Every case is solved and certified or refused, many have a limit that binds, and most scans come as near as
/// their resolution lets them (on a ridge between limits a scan stays behind, it is never ahead).
fn expect(sum: &Tally, all: usize) {
    assert_eq!(sum.certified, sum.feasible);
    assert_eq!(sum.feasible + sum.infeasible, all);
    assert!(5 * sum.feasible > 2 * all && 6 * sum.binding > sum.feasible && 2 * sum.agree > sum.feasible);
}

#[test]
fn ratio_and_spring_agree_with_a_scan_where_the_program_is_convex() {
    expect(&run(0..200, Kind::Convex), 200);
}

#[test]
fn ratio_and_spring_agree_with_a_scan_where_efficiency_flips() {
    expect(&run(1000..1080, Kind::Efficiency), 80);
}

#[test]
fn ratio_and_spring_agree_with_a_scan_with_coulomb_friction() {
    expect(&run(2000..2030, Kind::Coulomb), 30);
}

#[test]
fn ratio_and_spring_agree_with_a_scan_with_a_regeneration_limit() {
    expect(&run(3000..3021, Kind::Regeneration), 21);
}

#[test]
fn ratio_and_spring_agree_with_a_scan_with_peak_current_in_a_weighted_sum() {
    expect(&run(4000..4030, Kind::WeightedPeak), 30);
}

#[test]
fn ratio_and_spring_agree_with_a_scan_with_a_mass_that_steps_by_stages() {
    expect(&run(5000..5030, Kind::SteppedMass), 30);
}

#[test]
fn ratio_and_spring_agree_with_a_scan_with_an_average_torque_of_the_gear() {
    expect(&run(6000..6040, Kind::AverageTorque), 40);
}

/// An inverted pendulum, linearised: gravity asks for τ = −G q, with G = m g l, and a spring of stiffness G at
/// rest upright carries it.
#[test]
fn a_spring_cancels_gravity_on_paper() {
    let (gravity, swing, omega, period): (f64, f64, f64, f64) = (12.0, 0.3, 5.0, TAU / 5.0);
    let time: Vec<f64> = (0..64).map(|k| period * f64::from(k) / 64.0).collect();
    let column = |f: &dyn Fn(f64) -> f64| Some(time.iter().map(|t| f(*t)).collect::<Vec<f64>>());
    let q = |t: f64| swing * (omega * t).sin();
    let samples = Samples {
        torque: time.iter().map(|t| -gravity * q(*t)).collect(),
        position: column(&q),
        velocity: column(&|t| swing * omega * (omega * t).cos()),
        acceleration: column(&|t| -omega * omega * q(t)),
        torque_rate: column(&|t| -gravity * swing * omega * (omega * t).cos()),
        jerk: column(&|t| -swing * omega.powi(3) * (omega * t).cos()),
        time: time.clone(),
    };
    let motor = common::motor(&[
        ("resistance [ohm]", "0.3"),
        ("torque_constant [N*m/A]", "0.06"),
        ("rotor_inertia [kg*m^2]", "2e-5"),
    ]);
    let mut robot = common::robot(Motion::from_samples(samples.clone(), Course::Periodic(period)), GearModel::IDEAL);
    robot.joints[0].ratio = RatioChoice::Continuous { min: 10.0, max: 10.0 };
    robot.joints[0].limits.spring = Some(Spring { stiffness: [0.0, 30.0], rest_angle: [-1.0, 1.0], ..common::SPRING });
    let motion = Motion { sprung: true, ..Motion::clone(&robot.joints[0].motion) };
    let load = Load::new(&motion, None);
    let case = Case { motor, robot, raw: samples, period, load };
    solved(&case, |design| {
        let design = design.unwrap();
        let spring = design.spring.unwrap();
        // The motor's own inertia J N² α is in phase with −q too: the best spring carries it as well, with
        // k = G + J N² ω², and nothing is left.
        let stiffness = gravity + 2e-5 * 100.0 * omega * omega;
        assert_relative_eq!(spring.stiffness, stiffness, max_relative = 1e-5);
        assert!(spring.rest_angle.unwrap().abs() < 1e-6);
        let without = spring.without.unwrap();
        // On paper: mean of T² is (G + J N² ω²)² A²/2/N².
        let loss = 0.3 / 0.06_f64.powi(2) * (stiffness * swing / 10.0).powi(2) / 2.0;
        assert_relative_eq!(without.loss, loss, max_relative = 1e-9);
        assert!(design.evaluation.copper_loss < 1e-9 * loss, "{} of {loss}", design.evaluation.copper_loss);
    });
    // Gravity alone in the spring's range: what is left is the inertia's.
    let mut bound = Case {
        robot: case.robot.clone(),
        motor: case.motor.clone(),
        raw: case.raw.clone(),
        period,
        load: case.load.clone(),
    };
    bound.robot.joints[0].limits.spring =
        Some(Spring { stiffness: [0.0, gravity], rest_angle: [-1.0, 1.0], ..common::SPRING });
    solved(&bound, |design| {
        let design = design.unwrap();
        assert_relative_eq!(design.spring.unwrap().stiffness, gravity, max_relative = 1e-6);
        let inertia = 0.3 / 0.06_f64.powi(2) * (2e-5 * 10.0 * omega * omega * swing).powi(2) / 2.0;
        assert_relative_eq!(design.evaluation.copper_loss, inertia, max_relative = 1e-5);
    });
}

/// A spring that is given is nothing but more torque in the motion.
#[test]
fn a_given_spring_equals_a_motion_with_its_torque() {
    for (seed, kind) in
        [(0, Kind::Convex), (3, Kind::Convex), (1001, Kind::Efficiency), (2003, Kind::Coulomb), (5, Kind::Convex)]
    {
        let mut case = draw(seed, kind);
        let (k, rest) = (case.ranges()[1][1] * 0.4, 0.1);
        case.robot.joints[0].limits.spring =
            Some(Spring { stiffness: [k, k], rest_angle: [rest, rest], ..common::SPRING });
        let mut by_hand = case.raw.clone();
        for i in 0..by_hand.time.len() {
            by_hand.torque[i] += k * (case.raw.position.as_ref().unwrap()[i] - rest);
            by_hand.torque_rate.as_mut().unwrap()[i] += k * case.raw.velocity.as_ref().unwrap()[i];
        }
        let mut plain = case.robot.clone();
        plain.joints[0].limits.spring = None;
        plain.joints[0].motion = Motion::from_samples(by_hand, Course::Periodic(case.period)).into();
        let catalog = Catalog::of(vec![case.motor.clone()], Vec::new());
        let expected = optimize(&plain, &catalog);
        let expected = expected.joints[0].designs().next().map(|d| (d.optimum.ratio, d.optimum.objective));
        let found = solved(&case, |d| d.ok().map(|d| (d.optimum.ratio, d.optimum.objective)));
        assert_eq!(found, expected, "case {seed}");
    }
}

/// With gears of the catalogue the spring is solved for with each, and the efficiency may cover the gear.
#[test]
fn every_gear_has_its_own_spring() {
    let header = "id,manufacturer,model,kind,ratio,efficiency,inertia [kg*m^2],mass [g],source,source_kind";
    let rows = [
        "g10,m,a,planetary,10,0.9,2e-6,100,test,derived",
        "g20,m,b,planetary,20,0.85,1e-6,150,test,derived",
        "g35,m,c,planetary,35,0.8,1e-6,200,test,derived",
    ];
    let text = format!("{header}\n{}\n", rows.join("\n"));
    let source = std::sync::Arc::new(gearwise::input::Source::new("gears.csv", text));
    let gears = Catalog::from_sources(vec![source]).unwrap_or_else(|e| panic!("{}", e[0])).gears;
    for covers in [EfficiencyCovers::Load, EfficiencyCovers::LoadAndGear] {
        let mut case = draw(1002, Kind::Efficiency);
        (case.motor.peak_current, case.motor.continuous_current, case.robot.bus.power) = (None, None, None);
        case.robot.bus.voltage = 1e4;
        let joint = &mut case.robot.joints[0];
        joint.objective = Objective::single(Quantity::CopperLoss);
        joint.ratio = RatioChoice::gears(vec!["g*".into()], covers);
        let catalog = Catalog::of(vec![case.motor.clone()], gears.clone());
        let result = optimize(&case.robot, &catalog);
        let design = result.joints[0].designs().next().expect("a gear will do");
        let spring = design.spring.unwrap();
        assert!(matches!(design.optimum.certificate, Certificate::Certified { gap, .. } if gap <= 1e-6));
        // In a robot with an ample budget it is the same design, and it draws what it draws alone.
        let mut robot = case.robot.clone();
        robot.budget.power = Some(1e9);
        let options = robot::Options { budgets: false, ..robot::Options::default() };
        let choice = robot::choose(&robot, &catalog, options).unwrap();
        let together = &choice.combinations[0];
        assert_relative_eq!(together.objective, design.optimum.objective, max_relative = 1e-9);
        let alone = design.evaluation.peak_power.unwrap();
        assert_relative_eq!(together.peak_power, alone, max_relative = 1e-9);
        // The same with the spring's torque in the motion, and springs beside it: none is better.
        let with = |stiffness: f64, rest: f64| {
            let mut robot = case.robot.clone();
            robot.joints[0].limits.spring = None;
            robot.joints[0].motion = robot.joints[0].motion.with_spring(stiffness, rest).unwrap().into();
            let found = optimize(&robot, &catalog);
            found.joints[0].designs().next().map(|d| (d.gear.map(String::from), d.optimum.objective))
        };
        let rest = spring.rest_angle.unwrap();
        let (gear, loss) = with(spring.stiffness, rest).unwrap();
        assert_eq!(gear.as_deref(), design.gear);
        assert_relative_eq!(loss, design.optimum.objective, max_relative = 1e-12);
        let asked = case.robot.joints[0].limits.spring.unwrap();
        let share = |[a, b]: [f64; 2], i: i32| a + (b - a) * f64::from(i) / 20.0;
        for (i, j) in (0..=20).flat_map(|i| (0..=20).map(move |j| (i, j))) {
            if let Some((_, other)) = with(share(asked.stiffness, i), share(asked.rest_angle, j)) {
                assert!(other >= design.optimum.objective * (1.0 - 1e-6));
            }
        }
    }
}

/// Where the objective does not look at the spring, the softest that keeps the limits is taken.
#[test]
fn a_spring_that_does_not_matter_is_the_softest() {
    let mut case = draw(2, Kind::Convex);
    case.robot.joints[0].objective = Objective::single(Quantity::ReflectedInertia);
    case.robot.joints[0].limits.spring.as_mut().unwrap().stiffness[0] = 0.0;
    (case.motor.peak_current, case.motor.continuous_current) = (None, None);
    (case.robot.joints[0].gear.peak_torque, case.robot.bus.power) = (None, None);
    case.robot.bus.voltage *= 10.0;
    solved(&case, |design| {
        let spring = design.unwrap().spring.unwrap();
        assert_eq!((spring.stiffness, spring.rest_angle), (0.0, None));
    });
}
