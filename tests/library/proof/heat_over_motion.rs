//! What is said of heat over a motion: from cold, with rest, without time constants, in no order; and at standstill.
//! Numbers are from paper, or from an integration that shares no code with the model.

use std::sync::Arc;

use approx::assert_relative_eq;
use gearwise::actuator::Load;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::answer::Reason;
use gearwise::design::evaluate::Judged;
use gearwise::design::optimize::optimize;
use gearwise::design::program::RatioProgram;
use gearwise::design::{Evaluation, Mount, Prepared};
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// A motor of which everything is known but what a test leaves out: R = 1 Ω, K_T = 0.1 N·m/A, 10 A for ever. Over 0.4 and
/// 0.6 K/W at 25 °C, copper at the reference, 100 W would be 100 K.
fn motor(without: &[&str], with: &[(&str, &str)]) -> Motor {
    let all = [
        ("resistance [ohm]", "1"),
        ("inductance [mH]", "0.01"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [kg*m^2]", "1e-5"),
        ("mass [g]", "500"),
        ("pole_pairs", "7"),
        ("continuous_current [A]", "10"),
        ("peak_current [A]", "60"),
        ("max_speed [rpm]", "100000"),
        ("thermal_resistance_winding_housing [K/W]", "0.4"),
        ("thermal_resistance_housing_ambient [K/W]", "0.6"),
        ("thermal_time_constant_winding [s]", "40"),
        ("thermal_time_constant_housing [s]", "600"),
        ("max_winding_temperature [degC]", "200"),
        ("reference_temperature [degC]", "25"),
    ];
    let kept = all.iter().filter(|(name, _)| !without.iter().any(|w| name.starts_with(w)));
    let changed = kept.map(|(name, value)| (*name, with.iter().find(|w| w.0 == *name).map_or(*value, |w| w.1)));
    let (names, values): (Vec<&str>, Vec<&str>) = changed.unzip();
    let text = format!(
        "id,source,source_kind,terminals,current,{}\nm,-,derived,q_axis,q_axis,{}",
        names.join(","),
        values.join(",")
    );
    Catalog::from_sources(vec![Arc::new(Source::new("motor.csv", text))]).unwrap().motors.remove(0)
}

const TIMES: &[&str] = &["thermal_time_constant"];

/// A joint that asks for points, direct or with a ratio up to 2.
fn robot(points: &str) -> Robot {
    let text = format!(
        "name = 'r'\nambient = {{ temperature = '25 degC' }}\nbus = {{ voltage = '400 V', drive_current = '60 A' }}\n[[joint]]\nname = 'j'\nratio = {{ min = 1, max = 2 }}\nmotor_drag = 'off'\npoints = [{points}]\n"
    );
    read_source(&Arc::new(Source::new("robot.toml", text))).unwrap()
}

/// Holds of a current at a ratio of one [A], each for a time [s], at a crawl, as a motion.
fn holds(holds: &[(f64, f64)], course: impl Fn(f64) -> Course) -> Robot {
    let mut robot = robot("{ torque = '1 N*m', speed = '1 rad/s' }");
    let (mut time, mut torque, mut now) = (Vec::new(), Vec::new(), 0.0);
    for (lasts, current) in holds {
        time.extend([now, now + lasts - 1e-6]);
        torque.extend([0.1 * current; 2]);
        now += lasts;
    }
    let nothing = Some(vec![0.0; time.len()]);
    let samples = Samples {
        velocity: Some(vec![1.0; time.len()]),
        acceleration: nothing.clone(),
        torque_rate: nothing.clone(),
        jerk: nothing,
        position: None,
        time,
        torque,
    };
    robot.joints[0].motion = Motion::from_samples(samples, course(now)).into();
    robot
}

fn look(robot: &Robot, motor: &Motor, ratio: f64) -> (Evaluation, Judged) {
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    let prepared = Prepared::new(Mount::new(robot, joint, &load, motor).candidate().unwrap());
    (prepared.at(ratio), prepared.judged(ratio))
}

fn said<'a>(list: &'a [(&'static str, &'static str)], limit: &str) -> Option<&'a str> {
    list.iter().find(|(name, _)| *name == limit).map(|(_, what)| *what)
}

fn demand(evaluation: &Evaluation, limit: &str) -> Option<f64> {
    evaluation.margins.iter().find(|m| m.limit == limit).map(|m| m.demand)
}

/// Rises of winding and housing after heats [W at 25 °C] held one after the other, by the classic Runge-Kutta rule, and the
/// largest rise of the winding on the way. `hot` is copper's coefficient at 25 °C: 0.00393/(1 + 0.00393 · 5).
fn integrate(mut x: [f64; 2], holds: &[(f64, f64)]) -> ([f64; 2], f64) {
    let hot = 0.003_93 / (1.0 + 0.003_93 * 5.0);
    let (c_w, c_h) = (40.0 / 0.4, 600.0 / 0.6);
    let mut most = x[0];
    for (lasts, watt) in holds {
        let slope = |x: [f64; 2]| {
            let across = (x[0] - x[1]) / 0.4;
            [(watt * (1.0 + hot * x[0]) - across) / c_w, (across - x[1] / 0.6) / c_h]
        };
        let steps = (lasts / 0.2).ceil().max(4.0);
        let h = lasts / steps;
        for _ in 0..steps as usize {
            let moved = |k: [f64; 2], by: f64| [x[0] + by * k[0], x[1] + by * k[1]];
            let k1 = slope(x);
            let k2 = slope(moved(k1, 0.5 * h));
            let k3 = slope(moved(k2, 0.5 * h));
            let k4 = slope(moved(k3, h));
            x = [0, 1].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            most = most.max(x[0]);
        }
    }
    (x, most)
}

/// The largest rise in the state that repeats.
fn repeated(holds: &[(f64, f64)]) -> f64 {
    let (mut x, mut peak) = ([0.0; 2], 0.0);
    for _ in 0..4000 {
        let (next, most) = integrate(x, holds);
        let moved = (next[0] - x[0]).abs() + (next[1] - x[1]).abs();
        (x, peak) = (next, most);
        if moved < 1e-7 || most > 5e3 {
            break;
        }
    }
    peak
}

/// 28 A for two minutes of an hour: 5.1 A in the mean, of 10 A allowed, and 784 W in the winding.
const LONG: &[(f64, f64)] = &[(120.0, 28.0), (3480.0, 0.0)];

#[test]
fn a_long_stretch_cannot_be_judged_without_time_constants() {
    let robot = holds(LONG, Course::Periodic);
    let unknown = motor(TIMES, &[]);
    let (evaluation, judged) = look(&robot, &unknown, 1.0);
    assert!(evaluation.feasible, "the means are kept");
    assert_relative_eq!(
        demand(&evaluation, "continuous_current").unwrap(),
        28.0 / 30.0_f64.sqrt(),
        max_relative = 1e-5
    );
    let why = said(&judged.unchecked, "winding_peak_temperature").expect("it is said");
    assert!(why.contains("time constants are not known") && why.contains("so long"), "{why}");
    assert_eq!(said(&judged.assumed, "winding_peak_temperature"), None);
    // Known, the same motor is rejected: knowing less does not win.
    let known = motor(&[], &[]);
    assert!(!look(&robot, &known, 1.0).0.feasible);
    let catalog = |motor: Motor| Catalog::of(vec![motor], Vec::new());
    let mut fixed = robot.clone();
    fixed.joints[0].ratio = RatioChoice::Continuous { min: 1.0, max: 1.001 };
    let with = catalog(unknown.clone());
    // Heat is always a limit: what cannot be judged is no choice.
    let found = &optimize(&fixed, &with).joints[0];
    assert!(found.candidates.is_empty() && found.rejected.is_empty());
    assert!(said(&found.unjudged[0].because, "winding_peak_temperature").is_some());
    let with = catalog(known);
    let reason = optimize(&fixed, &with).joints[0].rejected[0].reason.clone();
    assert!(matches!(reason, Reason::Infeasible(_)), "{reason:?}");
}

#[test]
fn what_is_said_of_heat_follows_the_ratio() {
    // At N the current is 28/N: within 10 A from N = 2.8 on.
    let robot = holds(LONG, Course::Periodic);
    let unknown = motor(TIMES, &[]);
    for (ratio, kept) in [(1.0, false), (2.7, false), (2.801, true), (5.0, true)] {
        let (_, judged) = look(&robot, &unknown, ratio);
        let said = (judged.unchecked.is_empty(), judged.assumed.is_empty());
        assert_eq!(said, (kept, true), "{ratio}: {judged:?}");
    }
}

#[test]
fn short_stretches_are_judged_by_the_mean_and_say_so() {
    let unknown = motor(TIMES, &[]);
    let of = |list: &[(f64, f64)]| look(&holds(list, Course::Periodic), &unknown, 1.0).1;
    let short = of(&[(0.4, 28.0), (9.6, 0.0)]);
    assert!(short.unchecked.is_empty(), "{short:?}");
    assert!(said(&short.assumed, "winding_peak_temperature").unwrap().starts_with("judged by its mean heat"));
    // Three in a row whose pauses make up for nothing are one of 1.26 s.
    let burst = [(0.4, 28.0), (0.03, 0.0), (0.4, 28.0), (0.03, 0.0), (0.4, 28.0), (20.0, 0.0)];
    assert!(said(&of(&burst).unchecked, "winding_peak_temperature").is_some());
    // A stretch over the end of the period.
    let over = [(0.6, 28.0), (20.0, 0.0), (0.6, 28.0)];
    assert!(said(&of(&over).unchecked, "winding_peak_temperature").is_some());
    // A winding that is quicker than any of the catalogue averages less.
    let quick = motor(&["thermal_time_constant_housing"], &[("thermal_time_constant_winding [s]", "1.5")]);
    let (_, judged) = look(&holds(&[(0.4, 28.0), (9.6, 0.0)], Course::Periodic), &quick, 1.0);
    assert!(said(&judged.unchecked, "winding_peak_temperature").is_some());
}

#[test]
fn what_is_missing_is_what_is_said_to_be() {
    let robot = holds(LONG, Course::Periodic);
    let (ways, current, end) = ("thermal_resistance", "continuous_current", "max_winding");
    for (without, expected) in [
        (vec![TIMES[0]], "the thermal time constants are not known"),
        (vec![TIMES[0], end], "the thermal time constants are not known"),
        (vec![TIMES[0], ways], "the thermal time constants are not known"),
        (vec![ways, current], "none of continuous current, continuous torque and thermal resistances"),
        (vec![TIMES[0], ways, current, end], "none of continuous current, continuous torque and thermal resistances"),
    ] {
        let (_, judged) = look(&robot, &motor(&without, &[]), 1.0);
        let why = said(&judged.unchecked, "winding_peak_temperature").unwrap_or("nothing");
        assert!(why.starts_with(expected), "{without:?}: {why}");
    }
    // Without a highest temperature 100 °C is assumed, and said.
    for without in [vec![end], vec![end, current]] {
        let (evaluation, judged) = look(&robot, &motor(&without, &[]), 1.0);
        let limit = evaluation.margins.iter().find(|m| m.limit == "winding_peak_temperature").expect("it is followed");
        assert_eq!((limit.bound, limit.owner), (75.0, "assumed"), "{without:?}");
        assert!(said(&judged.assumed, "winding_temperature").unwrap().contains("100 degC is assumed"));
    }
    // By the rated current alone, what never exceeds it is kept.
    let cool = holds(&[(120.0, 9.9), (3480.0, 0.0)], Course::Periodic);
    let (_, judged) = look(&cool, &motor(&[TIMES[0], ways, end], &[]), 1.0);
    assert_eq!(said(&judged.unchecked, "winding_peak_temperature"), None);
}

/// All orders of a list.
fn orders(list: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    if list.len() < 2 {
        return vec![list.to_vec()];
    }
    let with = |k: usize| {
        let mut rest = list.to_vec();
        let first = rest.remove(k);
        orders(&rest).into_iter().map(move |tail| [vec![first], tail].concat())
    };
    (0..list.len()).flat_map(with).collect()
}

#[test]
fn points_in_no_order_are_kept_only_where_every_order_is() {
    let mut rng = Pcg64::seed_from_u64(15);
    let motor = motor(&[], &[("continuous_current [A]", "40")]);
    let (mut kept, mut unknown, mut largest) = (0, 0, 0.0_f64);
    for _ in 0..60 {
        let count = rng.random_range(1..5);
        let points: Vec<(f64, f64)> =
            (0..count).map(|_| (rng.random_range(1.0..200.0), rng.random_range(0.0..18.0))).collect();
        let texts: Vec<String> = points
            .iter()
            .map(|(t, i)| format!("{{ torque = '{} N*m', speed = '1 rad/s', duration = '{t} s' }}", 0.1 * i))
            .collect();
        let robot = robot(&texts.join(", "));
        let (_, judged) = look(&robot, &motor, 1.0);
        let heats: Vec<(f64, f64)> = points.iter().map(|(t, i)| (*t, i * i)).collect();
        let worst = orders(&heats).iter().map(|order| repeated(order)).fold(0.0, f64::max);
        match said(&judged.unchecked, "winding_peak_temperature") {
            None => {
                assert!(worst <= 175.0 * (1.0 + 1e-6), "{points:?} {worst}");
                (kept, largest) = (kept + 1, largest.max(worst));
            }
            Some(why) => {
                assert!(why.starts_with("the order of the operating points is not known"), "{why}");
                // A bound: it gives away what copper would be cooler than at the limit, no more.
                assert!(worst > 90.0, "{points:?} {worst}");
                unknown += 1;
            }
        }
    }
    assert!(kept > 10 && unknown > 10 && largest > 110.0, "{kept} {unknown} {largest}");
}

#[test]
fn points_without_durations_are_kept_where_the_hottest_is_for_ever() {
    let motor = motor(&[], &[]);
    for (torque, kept) in [(0.99, true), (2.8, false)] {
        let robot = robot(&format!("{{ torque = '{torque} N*m', speed = '1 rad/s' }}"));
        let (_, judged) = look(&robot, &motor, 1.0);
        assert_eq!(said(&judged.unchecked, "winding_peak_temperature").is_none(), kept, "{judged:?}");
    }
}

#[test]
fn a_motion_that_happens_once_is_judged_from_cold() {
    // 30 A for half a second: 900 W into 100 J/K. At 20 rad/s it is not slow.
    let once = [(0.5, 30.0)];
    let mut robot = holds(&once, |_| Course::Once(0.5 - 1e-6));
    Arc::make_mut(&mut robot.joints[0].motion).velocity.iter_mut().for_each(|speed| *speed *= 20.0);
    let (evaluation, judged) = look(&robot, &motor(&[], &[]), 1.0);
    assert!(evaluation.feasible, "{:?}", evaluation.tightest());
    let rise = integrate([0.0; 2], &[(0.5, 900.0)]).1;
    assert!(rise > 4.4 && rise < 4.6);
    assert_relative_eq!(demand(&evaluation, "winding_peak_temperature").unwrap(), rise, max_relative = 1e-5);
    for steady in ["continuous_current", "winding_temperature", "standstill_holding", "continuous_torque"] {
        assert_eq!((demand(&evaluation, steady), said(&judged.unchecked, steady)), (None, None), "{steady}");
    }
    // The loss is the mean over the motion.
    assert_relative_eq!(evaluation.copper_loss, 900.0, max_relative = 1e-9);
    // Without time constants half a second counts as kept, two minutes cannot be judged.
    let unknown = motor(TIMES, &[]);
    let (_, judged) = look(&robot, &unknown, 1.0);
    assert!(said(&judged.assumed, "winding_peak_temperature").unwrap().contains("from cold"));
    let (_, judged) = look(&holds(LONG, Course::Once), &unknown, 1.0);
    assert!(said(&judged.unchecked, "winding_peak_temperature").is_some());
    let (_, judged) = look(&holds(&[(1e4, 9.9)], Course::Once), &unknown, 1.0);
    assert_eq!(judged, Judged::default());
}

#[test]
fn with_rest_it_is_judged_in_the_state_that_repeats() {
    let once = [(0.5, 30.0), (3.0, 12.0)];
    let mut robot = holds(&once, |lasts| Course::Once(lasts - 1e-6));
    Arc::make_mut(&mut robot.joints[0].motion).repeat_every = Some(60.0);
    let motor = motor(&[], &[]);
    let (evaluation, _) = look(&robot, &motor, 1.0);
    let with_rest = [(0.5, 900.0), (3.0, 144.0), (56.5, 0.0)];
    let rise = demand(&evaluation, "winding_peak_temperature").unwrap();
    assert_relative_eq!(rise, repeated(&with_rest), max_relative = 1e-5);
    let mean = (0.5 * 900.0 + 3.0 * 144.0) / 60.0;
    assert_relative_eq!(demand(&evaluation, "continuous_current").unwrap().powi(2), mean, max_relative = 1e-5);
    assert_relative_eq!(demand(&evaluation, "winding_temperature").unwrap().powi(2), mean, max_relative = 1e-5);
    // The loss stays the mean over the motion itself.
    assert_relative_eq!(evaluation.copper_loss, mean * 60.0 / 3.5, max_relative = 1e-5);
    // No rest at all is the motion that repeats.
    let mut dense = holds(&[(0.5, 20.0), (3.0, 8.0)], |lasts| Course::Once(lasts - 1e-6));
    Arc::make_mut(&mut dense.joints[0].motion).repeat_every = Some(3.5 - 1e-6);
    let rise = demand(&look(&dense, &motor, 1.0).0, "winding_peak_temperature").unwrap();
    assert_relative_eq!(rise, repeated(&[(0.5, 400.0), (3.0, 64.0)]), max_relative = 1e-5);
    // Without time constants the stretch is what counts: 3.5 s above 10 A, however long the rest.
    Arc::make_mut(&mut robot.joints[0].motion).repeat_every = Some(60.0);
    let unknown = look(&robot, &self::motor(TIMES, &[]), 1.0).1;
    assert!(said(&unknown.unchecked, "winding_peak_temperature").is_some());
}

#[test]
fn the_best_ratio_with_rest_is_that_of_a_scan() {
    // Heat for ever would forbid every ratio below 2.9; with rest the winding decides.
    let mut robot = holds(&[(6.0, 40.0), (20.0, 6.0)], |lasts| Course::Once(lasts - 1e-6));
    Arc::make_mut(&mut robot.joints[0].motion).repeat_every = Some(90.0);
    robot.joints[0].ratio = RatioChoice::Continuous { min: 0.2, max: 20.0 };
    robot.joints[0].objective = Objective::single(Quantity::ReflectedInertia);
    let motor = motor(&[], &[("continuous_current [A]", "30")]);
    let catalog = Catalog::of(vec![motor], Vec::new());
    let result = optimize(&robot, &catalog);
    let design = &result.joints[0].candidates[0];
    assert_eq!(design.optimum.window().low.limit, "winding_peak_temperature");
    let n = design.optimum.ratio;
    let square = |i: f64| (i / n).powi(2);
    let rise = repeated(&[(6.0, square(40.0)), (20.0, square(6.0)), (64.0, 0.0)]);
    assert_relative_eq!(rise, 175.0, max_relative = 1e-4);
}

#[test]
fn a_hold_needs_what_the_load_asks() {
    // 1 N·m at N = 2 is 5 A, whatever the gear loses when it turns; at the instant it may take 1/η of it.
    let mut robot = robot("{ torque = '1 N*m', speed = '0 rad/s', duration = '1 s' }");
    robot.joints[0].gear.efficiency = 0.75;
    let motor = motor(&[], &[]);
    let (evaluation, _) = look(&robot, &motor, 2.0);
    assert_relative_eq!(evaluation.copper_loss, 25.0, max_relative = 1e-12);
    assert_relative_eq!(demand(&evaluation, "continuous_current").unwrap(), 5.0, max_relative = 1e-12);
    assert_relative_eq!(demand(&evaluation, "peak_current").unwrap(), 5.0 / 0.75, max_relative = 1e-12);
    // The phase that is worst off warms over its own 0.4 of 1 K/W by twice as much, the housing by no more.
    assert_relative_eq!(demand(&evaluation, "standstill_holding").unwrap(), 5.0 * 1.4_f64.sqrt(), max_relative = 1e-12);
    assert_eq!(said(&look(&robot, &motor, 2.0).1.assumed, "standstill_holding"), None);
    // How the way divides is not known: all of it is the winding's, and that is said.
    let (evaluation, judged) = look(&robot, &self::motor(&["thermal_resistance"], &[]), 2.0);
    assert_relative_eq!(demand(&evaluation, "standstill_holding").unwrap(), 5.0 * 2.0_f64.sqrt(), max_relative = 1e-12);
    assert!(said(&judged.assumed, "standstill_holding").is_some());
}

#[test]
fn an_inductance_without_pole_pairs_counts_where_the_current_changes() {
    // L di/dt = 2 mH · 100 A/s on top of R i + K_B ω = 3 + 0.1 · 50 V.
    let robot = robot("{ torque = '0.3 N*m', speed = '50 rad/s', torque_rate = '10 N*m/s' }");
    let with = [("inductance [mH]", "2")];
    let (evaluation, judged) = look(&robot, &motor(&["pole_pairs", "max_winding"], &with), 1.0);
    let v_q = 3.0 * hot(100.0) + 0.2 + 5.0;
    assert_relative_eq!(demand(&evaluation, "voltage").unwrap(), v_q, max_relative = 1e-9);
    assert!(said(&judged.unchecked, "inductance").unwrap().contains("without p N ω L i"));
    // With them, the current at speed stands across: p ω L i = 7 · 50 · 2 mH · 3 A.
    let (evaluation, judged) = look(&robot, &motor(&["max_winding"], &with), 1.0);
    assert_relative_eq!(demand(&evaluation, "voltage").unwrap(), v_q.hypot(2.1), max_relative = 1e-9);
    assert_eq!(said(&judged.unchecked, "inductance"), None);
}

/// Resistance at a temperature [°C] over that at 25 °C.
fn hot(celsius: f64) -> f64 {
    1.0 + (celsius - 25.0) / (1.0 / 0.003_93 + 5.0)
}

#[test]
fn voltage_and_power_see_the_winding_at_its_hottest() {
    // 3 A at 50 rad/s: R i + K_B ω = 3 + 5 V cold. At 200 °C the copper has 1 + 175 · 0.003854 times its resistance.
    let mut robot = robot("{ torque = '0.3 N*m', speed = '50 rad/s', duration = '1 s' }");
    robot.bus.power = Some(1e3);
    robot.bus.regeneration = Regeneration::Limited(1.0);
    let still = [("inductance [mH]", "0")];
    let look = |robot: &Robot, motor: &Motor| look(robot, motor, 1.0);
    let (evaluation, judged) = look(&robot, &motor(&[], &still));
    assert_relative_eq!(demand(&evaluation, "voltage").unwrap(), 3.0 * hot(200.0) + 5.0, max_relative = 1e-9);
    assert_relative_eq!(demand(&evaluation, "bus_power").unwrap(), 9.0 * hot(200.0) + 15.0, max_relative = 1e-9);
    // Loss and what comes back stay at the reference.
    assert_relative_eq!(evaluation.copper_loss, 9.0, max_relative = 1e-9);
    assert_eq!(said(&judged.assumed, "voltage"), None);
    // The requirement's limit is the lower; without any, 100 °C is assumed, and said.
    let mut cooler = robot.clone();
    cooler.joints[0].limits.winding_temperature = Some(373.15);
    let volts = demand(&look(&cooler, &motor(&[], &still)).0, "voltage").unwrap();
    assert_relative_eq!(volts, 3.0 * hot(100.0) + 5.0, max_relative = 1e-9);
    let volts = demand(&look(&robot, &motor(&["max_winding"], &still)).0, "voltage").unwrap();
    assert_relative_eq!(volts, 3.0 * hot(100.0) + 5.0, max_relative = 1e-9);
    let (evaluation, judged) = look(&robot, &motor(&["max_winding", "continuous_current"], &still));
    assert_relative_eq!(demand(&evaluation, "voltage").unwrap(), 3.0 * hot(100.0) + 5.0, max_relative = 1e-9);
    assert!(said(&judged.assumed, "winding_temperature").is_some());
    // Power that comes back: 5 · 3 − 9 W, cold.
    let back = self::robot("{ torque = '-0.3 N*m', speed = '50 rad/s', duration = '1 s' }");
    let back = Robot { bus: robot.bus, ..back };
    let (evaluation, _) = look(&back, &motor(&[], &still));
    assert_relative_eq!(demand(&evaluation, "regeneration").unwrap(), 15.0 - 9.0, max_relative = 1e-9);
}

/// Every design keeps its voltage at the temperature that it is itself predicted to have.
#[test]
fn no_design_breaks_its_voltage_at_its_own_temperature() {
    let catalog = Catalog::builtin().unwrap();
    let mut bound = 0;
    for (torque, speed) in [(20.0, 10.0), (5.0, 30.0), (60.0, 2.0), (10.0, 15.0), (2.0, 60.0), (30.0, 6.0)] {
        let text = format!(
            "name='r'\nbus={{voltage='24 V'}}\n[[joint]]\nname='j'\nmotor_drag='off'\nratio={{min=1,max=300}}\nobjective='loss'\npoints=[{{torque='{torque} N*m',speed='{speed} rad/s',duration='1 s'}}]\n"
        );
        let robot = read_source(&Arc::new(Source::new("robot.toml", text))).unwrap();
        for design in &optimize(&robot, &catalog).joints[0].candidates {
            let (motor, n) = (design.motor, design.optimum.ratio);
            let (Some(kelvin), false) =
                (design.winding_temperature.kelvin(), design.assumed.iter().any(|a| a.0 == "voltage"))
            else {
                continue;
            };
            let voltage = design.evaluation.margins.iter().find(|m| m.limit == "voltage").unwrap();
            bound += usize::from(voltage.margin < 1e-6);
            let alpha = 1.0 / (1.0 / 0.003_93 + motor.reference_temperature - 293.15);
            let r = motor.resistance * (1.0 + alpha * (kelvin - motor.reference_temperature));
            let c = motor.coulomb_friction.unwrap_or(0.0) + motor.viscous_friction.unwrap_or(0.0) * n * speed;
            let i = (torque / n + c) / motor.torque_constant;
            let v_q = r * i + motor.emf_constant() * n * speed;
            let poles = f64::from(motor.pole_pairs.unwrap_or(0));
            let v_d = poles * n * speed * motor.inductance.unwrap_or(0.0) * i;
            assert!(
                v_q.hypot(v_d) <= voltage.bound * (1.0 + 1e-8),
                "{}: {} {}",
                motor.id,
                v_q.hypot(v_d),
                voltage.bound
            );
        }
    }
    assert!(bound > 10, "{bound}");
}

#[test]
fn magnets_are_not_judged_by_the_drive() {
    let robot = robot("{ torque = '0.3 N*m', speed = '1 rad/s', duration = '1 s' }");
    assert_eq!(said(&look(&robot, &motor(&[], &[]), 1.0).1.unchecked, "demagnetisation"), None);
    let without = motor(&["peak_current"], &[]);
    assert!(said(&look(&robot, &without, 1.0).1.unchecked, "demagnetisation").is_some());
    let mut bare = robot.clone();
    bare.bus.drive_current = None;
    let judged = look(&bare, &without, 1.0).1;
    assert!(said(&judged.unchecked, "peak_current").is_some());
    assert_eq!(said(&judged.unchecked, "demagnetisation"), None);
}

#[test]
fn a_speed_constant_tells_the_back_emf() {
    let catalog = Catalog::builtin().unwrap();
    let of = |id: &str| catalog.motors.iter().find(|m| m.id == id).unwrap();
    // K_T 0.14 N·m/A of phase amplitude, 60/(2π)/100 V·s/rad line to line, peak (K_v = 100 rpm/V).
    let u8 = of("t-motor-u8-lee");
    let kv = u8.sheet.speed_constant.unwrap().value;
    assert_relative_eq!(u8.back_emf_constant, 1.0 / kv / 2.0_f64.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(u8.back_emf_constant / u8.torque_constant, 1.0235, max_relative = 1e-4);
    // What rounding explains changes nothing: 0.14 % here.
    let near = of("faulhaber-4221g018bxth");
    assert!(near.sheet.speed_constant.is_some() && near.back_emf_constant == near.torque_constant);
    // No row makes energy because of its speed constant; a back-EMF constant of the sheet counts before it.
    for motor in &catalog.motors {
        if motor.sheet.back_emf_constant.is_none() {
            assert!(motor.back_emf_constant >= motor.torque_constant, "{}", motor.id);
        }
    }
    let printed = of("t-motor-ak80-6").sheet.back_emf_constant.unwrap().value;
    assert!((of("t-motor-ak80-6").back_emf_constant / printed - 1.0).abs() < 0.5);
}

#[test]
fn repeat_every_is_read_and_refused_where_it_means_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let csv = "time [s], torque [N*m], velocity [rad/s]\n0,1,0.5\n0.1,2,1.5\n0.2,1.5,0.2\n0.3,-0.5,-1\n0.4,1,0.5\n";
    std::fs::write(folder.path().join("m.csv"), csv).unwrap();
    let read = |keys: &str| {
        let text = format!("name='r'\nbus={{voltage='48 V'}}\n[[joint]]\nname='j'\nratio={{min=1,max=9}}\n{keys}\n");
        let path = folder.path().join("robot.toml");
        std::fs::write(&path, text).unwrap();
        gearwise::requirement::read(&path).map_err(|errors| errors[0].problems[0].message.clone())
    };
    let robot = read("motion='m.csv'\nperiodic=false\nrepeat_every='60 s'").unwrap();
    let motion = &robot.joints[0].motion;
    assert_eq!((motion.repeat_every, motion.duration()), (Some(60.0), Some(0.4)));
    assert_relative_eq!(motion.share_of_time(), 0.4 / 60.0);
    // Played at a hundredth of the speed it lasts 40 s; at a thousandth it would not be over.
    assert_eq!(Motion::clone(motion).scaled(1.0, 0.01).repeat_every, Some(60.0));
    assert_eq!(Motion::clone(motion).scaled(1.0, 0.001).repeat_every, Some(400.0));
    for (keys, expected) in [
        (
            "motion='m.csv'\nperiodic=false\nrepeat_every='0.3 s'",
            "the motion lasts 0.4 s, but is to be made again after 0.3 s",
        ),
        ("motion='m.csv'\nrepeat_every='60 s'", "`repeat_every` needs a motion that happens once"),
        (
            "points=[{torque='1 N*m',speed='0 rad/s'}]\nrepeat_every='60 s'",
            "`repeat_every` needs a motion that happens once",
        ),
    ] {
        assert_eq!(read(keys).unwrap_err(), expected);
    }
}

/// 600 s at standstill warm the phase that carries two thirds of the heat by R_wh times the heat more than the mean of the
/// three, though the mean over a long cycle is small: what is followed over the motion does not show it.
#[test]
fn a_long_hold_at_standstill_is_judged_by_the_hottest_phase() {
    let held = |current: f64| {
        let mut robot = holds(&[(600.0, current), (2400.0, 0.5)], Course::Periodic);
        let motion = &mut robot.joints[0].motion;
        let nothing = Some(vec![0.0; motion.len()]);
        let samples = Samples {
            time: motion.time.clone(),
            torque: motion.torque.clone(),
            velocity: nothing.clone(),
            acceleration: nothing.clone(),
            torque_rate: nothing.clone(),
            jerk: nothing,
            position: None,
        };
        *motion = Motion::from_samples(samples, motion.course).into();
        robot
    };
    // 11 A: 121 W at 25 °C. The mean of the phases stays below 175 K; the worst phase has 0.4 K/W of that heat, hot 1.66 times as much, on
    // top, and is beyond it.
    let (evaluation, _) = look(&held(11.0), &motor(&[], &[]), 1.0);
    assert!(!evaluation.feasible && demand(&evaluation, "winding_peak_temperature").unwrap() > 175.0, "{evaluation:?}");
    // Half of that current leaves room for the worst phase, and nothing is said.
    let (evaluation, judged) = look(&held(6.0), &motor(&[], &[]), 1.0);
    assert!(evaluation.feasible && said(&judged.unchecked, "standstill_holding").is_none(), "{judged:?}");
}

/// A continuous current says nothing of a temperature that the requirement states: it cannot be judged, once too.
#[test]
fn a_stated_temperature_is_not_kept_by_a_continuous_current() {
    for course in [Course::Once as fn(f64) -> Course, Course::Periodic] {
        let mut robot = holds(&[(4000.0, 7.5)], course);
        robot.joints[0].limits.winding_temperature = Some(273.15 + 60.0);
        let bare = motor(&["thermal", "max_winding"], &[]);
        let (_, judged) = look(&robot, &bare, 1.0);
        assert!(said(&judged.unchecked, "winding_peak_temperature").is_some(), "{judged:?}");
        let catalog = Catalog::of(vec![bare], Vec::new());
        let joint = &optimize(&robot, &catalog).joints[0];
        assert!(joint.candidates.is_empty() && joint.unjudged.len() == 1, "{joint:?}");
    }
}

/// 200 A for 0.95 s against 10 A for ever: 380 times the heat of the steady limit. Short as it is, no winding takes that.
#[test]
fn a_short_stretch_far_above_the_limit_is_not_assumed_to_be_kept() {
    let burst = |current: f64| holds(&[(0.95, current), (4000.0, 0.1)], Course::Periodic);
    let (_, judged) = look(&burst(200.0), &motor(TIMES, &[]), 1.0);
    assert!(said(&judged.assumed, "winding_peak_temperature").is_none(), "{judged:?}");
    assert!(said(&judged.unchecked, "winding_peak_temperature").is_some(), "{judged:?}");
    let (_, judged) = look(&burst(20.0), &motor(TIMES, &[]), 1.0);
    assert!(said(&judged.assumed, "winding_peak_temperature").is_some(), "{judged:?}");
}

/// A rise of 10^56 K is cut off where a limit of 80 K still has digits: the cut is nowhere above the rise.
#[test]
fn a_rise_beyond_all_measure_is_cut_off_near_its_bound() {
    use gearwise::actuator::thermal_motion::{Course, Heat, TwoNode};
    let node = TwoNode {
        resistance_winding_housing: 868.0,
        resistance_housing_ambient: 875.0,
        time_constant_winding: 1.0,
        time_constant_housing: 13.5,
        ambient: 308.4,
        reference: 297.6,
        phases: true,
    };
    let times = [0.0, 0.2, 0.4];
    let rise = |heat: &[f64]| {
        node.from_cold(&Heat { times: &times, period_or_duration: 0.64, heat, settling: &[], phase: &[] }).peak
            - node.ambient
    };
    let far = [60.0, 30.0, 50.0];
    let heat = Heat { times: &times, period_or_duration: 0.64, heat: &far, settling: &[], phase: &[] };
    let temperature = node.from_cold(&heat);
    let [gradient, _] = node.peak_gradient(&heat, Course::FromCold, &temperature);
    let (value, gradient) = node.far_beyond(temperature.peak - node.ambient, gradient, 80.0);
    assert!(temperature.peak > 1e10 && value > 80.0 && value < 1e5, "{value}");
    let mut rng = Pcg64::seed_from_u64(3);
    for _ in 0..2000 {
        let scale: f64 = rng.random_range(0.0..1.2);
        let other = far.map(|q| scale * q * rng.random_range(0.5..1.5));
        let cut: f64 = value + gradient.iter().zip(other.iter().zip(&far)).map(|(g, (a, b))| g * (a - b)).sum::<f64>();
        assert!(cut <= rise(&other) * (1.0 + 1e-9) + 1e-6, "{cut} {}", rise(&other));
    }
}

/// A wheel that turns at 20 rad/s with next to no load, behind a ratio, with all of its motor's drag.
fn wheel(ratio: f64, limit: &str) -> Robot {
    let text = format!(
        "name = 'wheel'\nambient = {{ temperature = '25 degC' }}\nbus = {{ voltage = '400 V', drive_current = '60 A' }}\n[[joint]]\nname = 'j'\nratio = {{ values = [{ratio}] }}\nobjective = 'loss'\npoints = [{{ torque = '1 N*m', speed = '20 rad/s', duration = '1 s' }}]\nlimits = {{ winding_temperature = '{limit}' }}\n"
    );
    read_source(&Arc::new(Source::new("wheel.toml", text))).unwrap()
}

#[test]
fn a_winding_that_drag_could_heat_beyond_its_limit_is_not_said_to_stay_below_it() {
    // b = 2e-4 N·m·s/rad: at 20 N rad/s of the rotor that is 0.08 N² W, over 1 K/W.
    // The order of points is not known, so that all of the resistance counts.
    let dragging = |motor: Motor| Motor { coulomb_friction: Some(0.0), viscous_friction: Some(2e-4), ..motor };
    let housing = 1.0;
    let mut seen = [0, 0, 0];
    for motor in [motor(&[], &[]), motor(TIMES, &[])].map(dragging) {
        for ratio in [2.0, 5.0, 8.0, 12.0, 20.0, 28.0, 32.0, 40.0] {
            let mut catalog = Catalog::default();
            catalog.motors.push(motor.clone());
            let robot = wheel(ratio, "110 degC");
            let result = optimize(&robot, &catalog);
            let joint = &result.joints[0];
            let said = |remarks: &[(&str, &str)]| remarks.iter().any(|(name, _)| *name == "drag_heat");
            // The balance on paper: copper's heat by its own temperature, drag's in the housing.
            let (drag, current) = (2e-4 * (20.0 * ratio).powi(2), (1.0 / ratio + 2e-4 * 20.0 * ratio) / 0.1);
            let mut rise = 0.0;
            for _ in 0..200 {
                rise =
                    housing * drag - 1.0 + 1.0 * current * current * (1.0 + 0.003_93 / (1.0 + 0.003_93 * 5.0) * rise);
            }
            let first = joint.candidates.first();
            match (rise > 85.0, housing * drag < 1.0) {
                (true, _) => {
                    seen[0] += 1;
                    assert!(first.is_none(), "{ratio}: {rise}");
                    assert!(joint.unjudged.iter().any(|u| said(&u.because)), "{ratio}: {rise}");
                }
                (false, false) => {
                    seen[1] += 1;
                    assert!(first.is_some_and(|d| said(&d.assumed) && d.unchecked.is_empty()), "{ratio}: {rise}");
                }
                (false, true) => {
                    seen[2] += 1;
                    assert!(first.is_some_and(|d| !said(&d.assumed)), "{ratio}: {rise}");
                }
            }
        }
    }
    assert!(seen.iter().all(|n| *n >= 2), "{seen:?}");
}

/// A winding of 3 s in 1000 s: near the smallest ratio its temperature leaves all numbers, and beyond that no ratio may be lost for it.
#[test]
fn a_rise_beyond_all_numbers_forbids_its_own_ratios_alone() {
    let samples = |time: Vec<f64>| {
        let zeros = Some(vec![0.0; time.len()]);
        let torque = vec![6.0, 8.6, 4.3, 6.0];
        Samples {
            time,
            torque,
            position: None,
            velocity: zeros.clone(),
            acceleration: zeros.clone(),
            torque_rate: zeros.clone(),
            jerk: zeros,
        }
    };
    let motion = Motion::from_samples(samples(vec![0.0, 333.0, 667.0, 1000.0]), Course::Once(1000.0));
    let mut robot = robot("{ torque = '1 N*m', speed = '1 rad/s' }");
    robot.bus.voltage = 480.0;
    robot.joints[0].motion = motion.into();
    robot.joints[0].ratio = RatioChoice::Continuous { min: 1.2, max: 34.0 };
    let short = [
        ("thermal_time_constant_winding [s]", "3"),
        ("thermal_time_constant_housing [s]", "800"),
        ("thermal_resistance_winding_housing [K/W]", "1"),
        ("thermal_resistance_housing_ambient [K/W]", "2"),
    ];
    let motor = motor(&[], &short);
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    let prepared = Prepared::new(Mount::new(&robot, joint, &load, &motor).candidate().unwrap());
    let found = RatioProgram::new(&prepared, &joint.objective, 1.2, 34.0).solve().expect("34:1 keeps every limit");
    assert!(prepared.at(34.0).feasible && found.window().max >= 34.0 * (1.0 - 1e-9));
    let low = found.window().min;
    assert!(!prepared.at(0.999 * low).feasible && prepared.at(1.001 * low).feasible, "from {low}");
}
