//! What the ratio program says beside its best ratio: bounds without solving, verdicts without solving, prices where
//! nothing is convex, and what binds. Against solving, against re-solving with limits moved, and against the scan of
//! the raw waveforms.

use gearwise::actuator::Load;
use gearwise::catalog::Motor;
use gearwise::design::program::{Certificate, Infeasible, Optimum, RatioProgram, Refusal};
use gearwise::design::{Mount, Prepared};
use gearwise::effects::FittedEffect;
use gearwise::numerics::work;
use gearwise::requirement::*;

use crate::raw::{self, Case, draw};
use crate::solved;

fn range(case: &Case) -> (f64, f64) {
    let RatioChoice::Continuous { min, max } = case.robot.joints[0].ratio else { unreachable!() };
    (min, max)
}

/// Looks at the program of a case.
fn with_program<T>(case: &Case, look: impl FnOnce(&RatioProgram) -> T) -> T {
    let joint = &case.robot.joints[0];
    let load = Load::new(&joint.motion, joint.ripple());
    let prepared = Prepared::new(Mount::new(&case.robot, joint, &load, &case.motor).candidate().unwrap());
    let (min, max) = range(case);
    look(&RatioProgram::new(&prepared, &joint.objective, min, max))
}

/// The optimum, and the bound of each limit there.
fn solved(case: &Case) -> Option<(Optimum, Vec<(&'static str, f64)>)> {
    let found = solved::solve(&case.motor, &case.robot).ok()?;
    Some((found.optimum, found.evaluation.margins.iter().map(|m| (m.limit, m.bound)).collect()))
}

/// The bound without solving is never above the optimum, and near it as a rule; where there is none, there is no
/// ratio either, as a rule.
#[test]
fn bounds_without_solving_are_bounds_and_no_empty_ones() {
    for (first, convex) in [(0, true), (100_000, false)] {
        let (mut near, mut all, mut silent) = (Vec::new(), 0, 0);
        for i in first..first + 250 {
            let case = draw(i, convex);
            let (bound, outcome) = with_program(&case, |p| (p.lower_bound(), p.solve()));
            let Ok(optimum) = outcome else {
                continue;
            };
            all += 1;
            let Some(bound) = bound else {
                silent += 1;
                continue;
            };
            let size = optimum.objective.abs().max(1e-9);
            assert!(bound <= optimum.objective + 1e-9 * size, "{i}: {bound} {}", optimum.objective);
            near.push((optimum.objective - bound) / size);
        }
        near.sort_by(f64::total_cmp);
        // Six pieces of the range leave little, where the range is not wide.
        let (half, most) = (near[near.len() / 2], near[near.len() * 9 / 10]);
        println!("{all} programs, bound below the optimum by {half} (half of them), {most} (nine of ten)");
        assert!(all > 80 && silent == 0 && half < 0.1 && most < 0.6, "{all} {silent} {half} {most}");
    }
}

/// A program that is ended early, after shares of the work that fall to nothing, claims nothing false: its ratio is feasible, no bound
/// is above the optimum, and nothing is called infeasible that is not. The same share gives the same answer.
#[test]
fn a_program_that_ends_early_claims_nothing_false() {
    let (mut ended, mut certified, mut unknown) = (0, 0, 0);
    for i in (0..150).chain(100_000..100_350) {
        let case = draw(i, i < 100_000);
        let all = with_program(&case, |p| p.solve());
        for share in [0, 300, 3_000, 30_000, 300_000] {
            let solve = || with_program(&case, |p| work::within(share, || p.solve()).0);
            let early = solve();
            assert_eq!(format!("{early:?}"), format!("{:?}", solve()), "{i} {share}");
            match (&early, &all) {
                (Ok(early), Ok(all)) => {
                    let size = all.objective.abs().max(1e-9);
                    assert!(case.worst(early.ratio).0 < 1e-7, "{i} {share}: N = {} is not feasible", early.ratio);
                    assert!(early.objective >= all.objective - 1e-6 * size, "{i} {share}: better than the optimum");
                    match &early.certificate {
                        Certificate::Certified { lower_bound, gap, .. } => {
                            assert!(*lower_bound <= all.objective + 1e-6 * size && *gap <= 1e-6, "{i} {share}");
                            certified += 1;
                        }
                        Certificate::NotCertified(_) => ended += 1,
                    }
                }
                (Ok(early), Err(why)) => {
                    let is_open = !matches!(why, Refusal::Infeasible(_));
                    assert!(is_open && case.worst(early.ratio).0 < 1e-7, "{i} {share}: feasible, but {why:?}");
                }
                (Err(Refusal::Infeasible(why)), Ok(all)) => {
                    panic!("{i} {share}: {why:?} though N = {} is feasible", all.ratio)
                }
                (Err(_), Ok(_)) => unknown += 1,
                (Err(_), Err(_)) => {}
            }
        }
    }
    println!("{ended} ended early, {certified} certified in time, {unknown} without an answer");
    assert!(ended > 100 && certified > 500 && unknown < ended, "{ended} {certified} {unknown}");
}

/// What is called impossible has no solution; and of what has none, most is called so, where nothing is convex.
#[test]
fn what_is_called_impossible_is() {
    let (mut called, mut missed) = (0, 0);
    for i in 100_000..100_250 {
        let case = draw(i, false);
        let (impossible, outcome) = with_program(&case, |p| (p.is_impossible(), p.solve()));
        match outcome {
            Err(Refusal::Infeasible(_)) => {
                called += usize::from(impossible);
                missed += usize::from(!impossible);
            }
            _ => assert!(!impossible, "{i}"),
        }
    }
    println!("{called} called impossible, {missed} only found to be");
    assert!(called > 2 * missed && called > 50, "{called} {missed}");
    for i in 0..60 {
        assert!(!with_program(&draw(i, true), |p| p.is_impossible()), "nothing is tried where all is convex: {i}");
    }
}

/// Moves a limit of a name by a factor; `false` where this test does not know how.
fn moved(case: &mut Case, limit: &str, factor: f64) -> bool {
    let (motor, bus, joint) = (&mut case.motor, &mut case.robot.bus, &mut case.robot.joints[0]);
    let RatioChoice::Continuous { min, max } = joint.ratio else { unreachable!() };
    let times = |x: &mut Option<f64>| *x = x.map(|v| v * factor);
    match limit {
        "voltage" | "torque_bandwidth_voltage" => bus.voltage *= factor,
        "peak_current" | "torque_bandwidth_current" => {
            times(&mut motor.peak_current);
            times(&mut bus.drive_current);
            times(&mut joint.drive_current);
        }
        "peak_torque" => times(&mut motor.peak_torque),
        "continuous_torque" => times(&mut motor.continuous_torque),
        "max_speed" => times(&mut motor.max_speed),
        "gear_input_speed" => times(&mut joint.gear.max_input_speed),
        "reflected_inertia" => times(&mut joint.limits.reflected_inertia),
        "bus_power" => times(&mut bus.power),
        "bus_current" => times(&mut bus.current),
        "ratio_min" => joint.ratio = RatioChoice::Continuous { min: min * factor, max },
        "ratio_max" => joint.ratio = RatioChoice::Continuous { min, max: max * factor },
        _ => return false,
    }
    true
}

/// Prices against solving again with the limit moved: where two limits bind, to one side only.
fn prices_are_differences(cases: impl Iterator<Item = Case>, step: f64, near: f64) -> (usize, usize) {
    let (mut checked, mut free) = (0, 0);
    for case in cases {
        let Some((optimum, bounds)) = solved(&case) else { continue };
        let value = optimum.objective;
        if value <= 0.0 {
            continue;
        }
        free += usize::from(optimum.shadow_prices.is_empty());
        for price in &optimum.shadow_prices {
            let at = |factor: f64| {
                let mut other = Case::new(case.motor.clone(), case.robot.clone(), case.raw.clone());
                if !moved(&mut other, price.limit, factor) {
                    return None;
                }
                solved(&other).map(|(optimum, _)| optimum.objective)
            };
            let (Some(wider), Some(tighter)) = (at(1.0 + step), at(1.0 - step)) else { continue };
            let (up, down) = ((wider - value) / (value * step), (value - tighter) / (value * step));
            let differences = [up, down, 0.5 * (up + down)];
            let fits = differences.iter().any(|d| (d - price.elasticity).abs() <= near * price.elasticity.abs() + 1e-4);
            assert!(fits, "{price:?} {differences:?}");
            // The same in SI: per unit of the limit itself.
            if let Some((_, bound)) = bounds.iter().find(|b| b.0 == price.limit) {
                assert!((price.price * bound / value / price.elasticity - 1.0).abs() < 1e-9, "{price:?} {bound}");
            }
            checked += 1;
        }
    }
    (checked, free)
}

#[test]
fn prices_of_programs_that_are_not_convex_are_differences() {
    let (checked, free) = prices_are_differences((100_000..100_250).map(|i| draw(i, false)), 1e-5, 0.02);
    println!("{checked} prices, {free} programs without one");
    assert!(checked > 25 && free > 20, "{checked} {free}");
}

/// Effects that are evaluated at each ratio have prices, too.
#[test]
fn prices_of_evaluated_programs_are_differences() {
    let cases = (0..80).map(|i| {
        let mut case = draw(i, true);
        let (min, max) = range(&case);
        let n = (min * max).sqrt();
        let current = (case.look(n).quantities[1] / case.motor.resistance).sqrt();
        let speed = n * case.raw.iter().map(|p| p.velocity.abs()).fold(1e-3, f64::max);
        let drag = FittedEffect::new("eddy_drag", vec![0.1 * case.motor.torque_constant * current, 0.4 * speed]);
        case.motor = Motor { effects: vec![drag.unwrap()], ..case.motor };
        case.robot.joints[0].objective = Objective::single(Quantity::CopperLoss);
        case
    });
    let (checked, free) = prices_are_differences(cases, 1e-4, 0.03);
    println!("{checked} prices, {free} programs without one");
    assert!(checked > 6 && free > 5, "{checked} {free}");
}

/// Convex programs are proved by duality, in pieces where the heat at standstill depends on the ratio, others along 1/N or by branch
/// and bound, all tightly; the windows are the scan's.
#[test]
fn certificates_say_how_and_are_tight() {
    let others: &[&str] = &["branch and bound", "convex in 1/N"];
    for (first, convex, how) in
        [(0, true, &["conic duality", "pieces of constant standstill"][..]), (100_000, false, others)]
    {
        let mut ways = std::collections::BTreeMap::new();
        let (mut own, mut all, mut loose, mut small) = (0, 0, 0, 0);
        for i in first..first + 150 {
            let case = draw(i, convex);
            let Ok(optimum) = with_program(&case, |p| p.solve()) else { continue };
            let Certificate::Certified { lower_bound, gap, method } = optimum.certificate else {
                panic!("{i} is not certified")
            };
            assert!(lower_bound <= optimum.objective && (0.0..=1e-6).contains(&gap));
            // Relative to the objective, however small: heat is a sum of squares, in which nothing cancels. (Nothing but rounding
            // is no heat.)
            if optimum.objective > f64::EPSILON
                && matches!(case.robot.joints[0].objective.terms.as_slice(), [(Quantity::CopperLoss, _)])
            {
                let own = (optimum.objective - lower_bound) / optimum.objective;
                assert!((own - gap).abs() < 1e-9 || own <= gap, "{i}: {own} {gap} {} {lower_bound}", optimum.objective);
                small += usize::from(optimum.objective < 0.1);
            }
            all += 1;
            own += usize::from(how.contains(&method));
            *ways.entry(method).or_insert(0) += 1;
            loose += usize::from(gap > 3e-7);
            let inside = |w: &gearwise::design::program::Window| {
                w.min <= optimum.ratio * (1.0 + 1e-9) && optimum.ratio <= w.max * (1.0 + 1e-9)
            };
            assert!(optimum.windows.iter().any(inside) && inside(optimum.window()));
            // Windows lie apart, from left to right.
            assert!(optimum.windows.windows(2).all(|pair| pair[0].max < pair[1].min), "{i}: {:?}", optimum.windows);
        }
        println!("{own} of {all} by {ways:?}, {loose} with a gap beyond 3e-7, {small} of less than 0.1 W");
        assert!(small > 1, "{small}");
        // Some objectives have a proof of their own (least mass); those of a third kind would be a fallback.
        // Each way is taken by a good part of what it is for.
        assert!(how.iter().all(|way| ways.get(way).is_some_and(|n| n * 8 > all)), "{ways:?}");
        assert!(all > 60 && own * 10 > all * 8 && loose * 20 < all, "{ways:?}: {own} of {all}, {loose}");
    }
}

/// What is told of a joint that cannot be met: the limit, how far it is exceeded and where, from the raw waveforms.
#[test]
fn refusals_have_the_numbers_of_the_raw_waveforms() {
    let (mut never, mut contradiction, mut nowhere, mut compared) = (0, 0, 0, 0);
    for i in (0..360).chain(100_000..100_700) {
        let case = draw(i, i < 1000);
        let Err(Refusal::Infeasible(why)) = with_program(&case, |p| p.solve()) else { continue };
        let (min, max) = range(&case);
        let over = |limit: &str, n: f64| {
            let at = case.look(n).limits.into_iter().find(|l| l.0 == limit).unwrap();
            at.1 / at.2.unwrap()
        };
        let grid: Vec<f64> = (0..=400).map(|k| min * (max / min).powf(f64::from(k) / 400.0)).collect();
        let least = |limit: &str| grid.iter().map(|n| over(limit, *n)).fold(f64::INFINITY, f64::min);
        match why {
            Infeasible::Never { bind, least: told, ratio, .. } => {
                never += 1;
                assert!(ratio >= min * (1.0 - 1e-9) && ratio <= max * (1.0 + 1e-9));
                assert!(
                    told.is_infinite() || (over(bind.limit, ratio) / told - 1.0).abs() < 1e-6,
                    "{i} {bind:?} {told}"
                );
                let scanned = least(bind.limit);
                assert!(told > 1.0 && told <= scanned * (1.0 + 1e-6), "{i} {bind:?}: {told} {scanned}");
            }
            Infeasible::Contradiction { low, at_least, high, at_most } => {
                contradiction += 1;
                assert!(at_least > at_most * (1.0 - 1e-6), "{i}");
                // Below its ratio the one is broken, above its own the other.
                if low.limit != "ratio_min" {
                    assert!(over(low.limit, at_least * 0.999) > 1.0 - 1e-6, "{i} {low:?}");
                }
                if high.limit != "ratio_max" && high.limit != "actuator_mass" {
                    assert!(over(high.limit, at_most * 1.001) > 1.0 - 1e-6, "{i} {high:?}");
                }
            }
            Infeasible::Nowhere { bind, least: told, ratio, .. } => {
                nowhere += 1;
                if bind.limit.starts_with("ratio") {
                    continue;
                }
                let here = over(bind.limit, ratio);
                assert!(here == told || (here - told).abs() <= 1e-6 * told.abs(), "{i} {bind:?} {told}");
                // Of a limit of zero there are no shares.
                if case.robot.bus.regeneration == Regeneration::Limited(0.0) {
                    continue;
                }
                compared += 1;
                // No ratio comes nearer, as people read the limits: most of them squares to the program.
                // Of the ratios that keep what ends the range.
                let ends = ["max_speed", "gear_input_speed", "reflected_inertia", "actuator_mass"];
                let kept = |n: f64| case.excess(n).all(|(excess, name)| excess <= 0.0 || !ends.contains(&name));
                let within = grid.iter().filter(|n| kept(**n));
                let nearest = within.map(|n| case.worst(*n).0).fold(f64::INFINITY, f64::min);
                assert!(told - 1.0 <= nearest * (1.0 + 1e-6) + 1e-9, "{i} {bind:?}: {told} {nearest}");
                let worst = case.worst(ratio).0 + 1.0;
                assert!(worst == told || (worst / told - 1.0).abs() <= 1e-6, "{i} {bind:?}: {worst} {told}");
            }
        }
    }
    println!("{never} never, {contradiction} contradictions, {nowhere} nowhere, {compared} compared");
    assert!(compared > 5, "{compared}");
    assert!(never > 10 && contradiction > 20 && nowhere > 5, "{never} {contradiction} {nowhere}");
}

/// A joint without any limit but those that are set afterwards.
fn free(i: u64) -> Case {
    let mut case = draw(i, true);
    let (motor, bus, joint) = (&mut case.motor, &mut case.robot.bus, &mut case.robot.joints[0]);
    (motor.peak_current, motor.peak_torque, motor.continuous_current, motor.continuous_torque) =
        (None, None, None, None);
    (motor.max_speed, motor.thermal_resistance, motor.max_winding_temperature) = (None, None, None);
    motor.sheet = gearwise::catalog::Sheet::default();
    (bus.drive_current, bus.power, bus.current, bus.voltage) = (None, None, None, 1e9);
    joint.drive_current = None;
    joint.limits = Limits { safety: 1.0, ..Limits::default() };
    (joint.gear.peak_torque, joint.gear.continuous_torque, joint.gear.max_input_speed) = (None, None, None);
    joint.objective = Objective::single(Quantity::CopperLoss);
    joint.ratio = RatioChoice::Continuous { min: 1.0, max: 1000.0 };
    Case::new(case.motor, case.robot, case.raw)
}

/// A limit on mass that stages meet exactly allows them, however it was rounded; a hair less does not.
#[test]
fn stages_that_meet_the_mass_exactly_are_allowed() {
    let mut case = free(7);
    for (motor, stage) in [(0.3, 0.1), (0.7, 0.1), (0.1, 0.7), (1.1, 0.3), (0.123, 0.457)] {
        case.motor.mass = Some(motor);
        case.robot.joints[0].gear.mass_per_stage = Some((stage, 3.0));
        for stages in 1..6 {
            case.robot.joints[0].limits.actuator_mass = Some(motor + f64::from(stages) * stage);
            let window = |case: &Case| match with_program(case, |p| p.solve()) {
                Ok(optimum) => optimum.window().clone(),
                other => panic!("{other:?}"),
            };
            let whole = window(&case);
            assert!((whole.max / 3.0_f64.powi(stages) - 1.0).abs() < 1e-12, "{motor} {stage} {stages}: {}", whole.max);
            assert_eq!((whole.high.limit, whole.low.limit, whole.min), ("actuator_mass", "ratio_min", 1.0));
            case.robot.joints[0].limits.actuator_mass = Some((motor + f64::from(stages) * stage) * (1.0 - 1e-6));
            assert!((window(&case).max / 3.0_f64.powi(stages - 1) - 1.0).abs() < 1e-12);
        }
        case.robot.joints[0].limits.actuator_mass = Some(0.5 * motor);
        match with_program(&case, |p| p.solve()) {
            Err(Refusal::Infeasible(Infeasible::Never { bind, least, ratio, .. })) => {
                assert_eq!((bind.limit, bind.sample, ratio), ("actuator_mass", None, 1.0));
                assert!((least - 2.0).abs() < 1e-12);
            }
            other => panic!("{other:?}"),
        }
        // Without stages the mass is the same at every ratio: all or none.
        case.robot.joints[0].gear.mass_per_stage = None;
        case.robot.joints[0].gear.mass = Some(0.2);
        for (bound, allowed) in [(motor + 0.2, true), ((motor + 0.2) * (1.0 - 1e-6), false)] {
            case.robot.joints[0].limits.actuator_mass = Some(bound);
            assert_eq!(with_program(&case, |p| p.solve()).is_ok(), allowed, "{motor}");
        }
    }
}

/// Upper bounds of the ratio: `N max|ω| ≤ ω_max`, `N² J ≤ J_max`; the tightest binds, with its price.
#[test]
fn upper_bounds_of_the_ratio_are_those_on_paper() {
    for i in 0..20 {
        let mut case = free(i);
        let fastest = case.raw.iter().map(|p| p.velocity.abs()).fold(0.0, f64::max);
        if fastest == 0.0 {
            continue;
        }
        let inertia = case.motor.rotor_inertia.unwrap() + case.robot.joints[0].gear.inertia;
        for (speed, reflected, gear, name, most) in [
            (Some(5.0), None, None, "max_speed", 5.0),
            (Some(5.0), None, Some(4.0), "gear_input_speed", 4.0),
            (Some(5.0), Some(3.0), Some(4.0), "reflected_inertia", 3.0),
            (None, Some(7.0), Some(9.0), "reflected_inertia", 7.0),
            (None, None, None, "ratio_max", 1000.0),
        ] {
            case.motor.max_speed = speed.map(|n: f64| n * fastest);
            case.robot.joints[0].gear.max_input_speed = gear.map(|n: f64| n * fastest);
            case.robot.joints[0].limits.reflected_inertia = reflected.map(|n: f64| n * n * inertia);
            let Ok(optimum) = with_program(&case, |p| p.solve()) else { panic!("{i}") };
            let window = optimum.window();
            assert!((window.max / most - 1.0).abs() < 1e-12, "{i} {name}: {}", window.max);
            assert_eq!(window.high.limit, name);
        }
        // Below the smallest ratio that the requirement wants they contradict it.
        case.motor.max_speed = Some(0.9 * fastest);
        case.robot.joints[0].limits.reflected_inertia = None;
        match with_program(&case, |p| p.solve()) {
            Err(Refusal::Infeasible(Infeasible::Contradiction { low, at_least, high, at_most })) => {
                assert_eq!((low.limit, at_least, high.limit), ("ratio_min", 1.0, "max_speed"));
                assert!((at_most - 0.9).abs() < 1e-12);
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Least mass: at the smallest feasible ratio, and of all ratios of that mass the one of least loss.
#[test]
fn least_mass_takes_the_least_loss_of_its_stages() {
    for i in 0..40 {
        let mut case = free(i);
        let (motor, stage, step) = (case.motor.mass.unwrap(), 0.4, 5.0);
        case.robot.joints[0].gear.mass_per_stage = Some((stage, step));
        case.robot.joints[0].objective = Objective::single(Quantity::Mass);
        for smallest in [1.0, 2.0, 7.0, 30.0] {
            case.robot.joints[0].ratio = RatioChoice::Continuous { min: smallest, max: 1000.0 };
            let Ok(optimum) = with_program(&case, |p| p.solve()) else { panic!("{i}") };
            let stages = (0..9).find(|k| smallest <= step.powi(*k) * (1.0 + 1e-12)).unwrap();
            assert!((optimum.objective - (motor + f64::from(stages) * stage)).abs() < 1e-12);
            let most = step.powi(stages).max(smallest);
            assert!(optimum.ratio >= smallest * (1.0 - 1e-9) && optimum.ratio <= most * (1.0 + 1e-9), "{i} {smallest}");
            let loss = |n: f64| case.look(n).quantities[0];
            let grid = (0..=200).map(|k| smallest * (most / smallest).powf(f64::from(k) / 200.0));
            let least = grid.map(loss).fold(f64::INFINITY, f64::min);
            assert!(loss(optimum.ratio) <= least * (1.0 + 1e-9), "{i} {smallest}: {} {least}", loss(optimum.ratio));
            assert!(matches!(optimum.certificate, Certificate::Certified { lower_bound, gap, method }
                if lower_bound == optimum.objective && gap == 0.0 && method == "mass does not fall with the ratio"));
        }
    }
}

/// Where what is allowed is a hair from what is asked at most, the window has a gap that is narrower than any grid; where
/// it is a hair above what is asked at least, it is a window as narrow. The ends are where the raw demand meets the bound.
#[test]
#[ignore = "long: `.ci/cases` runs it"]
fn gaps_and_windows_narrower_than_the_grid_are_seen() {
    let back = |case: &Case, n: f64| case.look(n).limits.iter().find(|l| l.0 == "regeneration").unwrap().1;
    let watt = |case: &Case, n: f64| case.look(n).limits.iter().find(|l| l.0 == "bus_power").unwrap().1;
    let inner = |f: &dyn Fn(f64) -> f64| {
        // The bottom of the lowest valley inside of the range, refined in ln N.
        let at = |k: f64| (1e3_f64.ln() * k / 400.0).exp();
        let k = (1..400).min_by(|a, b| f(at(f64::from(*a))).total_cmp(&f(at(f64::from(*b))))).unwrap();
        (10..390)
            .contains(&k)
            .then(|| raw::golden(|ln| f(ln.exp()), [at(f64::from(k - 1)).ln(), at(f64::from(k + 1)).ln()]).exp())
    };
    let (mut gaps, mut slits) = (0, 0);
    for i in 0..30 {
        let mut case = free(i);
        case.robot.bus.drive_efficiency = 0.9;
        if let Some(top) = inner(&|n| -back(&case, n)).filter(|n| back(&case, *n) > 1e-3) {
            for hair in [1e-6, 1e-8] {
                let bound = back(&case, top) * (1.0 - hair);
                case.robot.bus.regeneration = Regeneration::Limited(bound);
                let outcome = with_program(&case, |p| p.solve());
                let Ok(optimum) = outcome else { panic!("{i}: {outcome:?}") };
                // On either side of the top there is a window that ends where power flowing back is what is allowed.
                let ends = (
                    optimum.windows.iter().find(|w| (w.max / top - 1.0).abs() < 1e-2 && w.max < top),
                    optimum.windows.iter().find(|w| (w.min / top - 1.0).abs() < 1e-2 && w.min > top),
                );
                let (Some(below), Some(above)) = ends else { panic!("{i} {hair} {top}: {:?}", optimum.windows) };
                assert_eq!((below.high.limit, above.low.limit), ("regeneration", "regeneration"));
                for n in [below.max, above.min] {
                    let off = (back(&case, n) / bound - 1.0).abs();
                    assert!(off < 0.1 * hair, "{i} {hair}: {n} of {top}, {off:e}");
                }
                gaps += 1;
            }
        }
        // A regeneration limit that never binds makes the program one that is not convex.
        case.robot.bus.regeneration = Regeneration::Limited(1e12);
        case.robot.joints[0].gear.backdrive_efficiency = case.robot.joints[0].gear.efficiency;
        if let Some(bottom) = inner(&|n| watt(&case, n)).filter(|n| watt(&case, *n) > 1e-3) {
            for hair in [1e-6, 1e-8] {
                let bound = watt(&case, bottom) * (1.0 + hair);
                case.robot.bus.power = Some(bound);
                let outcome = with_program(&case, |p| p.solve());
                let Ok(optimum) = outcome else { panic!("{i} {hair}: {outcome:?}") };
                let [window] = optimum.windows.as_slice() else { panic!("{i}: {:?}", optimum.windows) };
                assert_eq!((window.low.limit, window.high.limit), ("bus_power", "bus_power"));
                assert!(window.min < bottom && bottom < window.max, "{window:?} {bottom}");
                for n in [window.min, window.max] {
                    let off = (watt(&case, n) / bound - 1.0).abs();
                    assert!(off < 0.1 * hair, "{i} {hair}: {n} of {bottom}, {off:e}");
                }
                slits += 1;
            }
            case.robot.bus.power = None;
        }
    }
    println!("{gaps} gaps, {slits} slits");
    assert!(gaps > 3 && slits > 20, "{gaps} {slits}");
}

/// Where evaluated effects stand, the end of the range that holds the ratio has its price: the slope of the objective
/// there. An end that does not hold it has none.
#[test]
fn the_end_of_the_range_has_its_price_where_ratios_are_evaluated() {
    let mut checked = 0;
    for i in 0..5 {
        let mut case = free(i);
        let current = (case.look(30.0).quantities[1] / case.motor.resistance).sqrt();
        let speed = 30.0 * case.raw.iter().map(|p| p.velocity.abs()).fold(1e-3, f64::max);
        let drag = FittedEffect::new("eddy_drag", vec![0.05 * case.motor.torque_constant * current, speed]).unwrap();
        case.motor.effects = vec![drag];
        let best = |case: &Case| solved(case).unwrap().0;
        let whole = best(&case);
        if !(2.0..500.0).contains(&whole.ratio) {
            continue;
        }
        assert!(whole.shadow_prices.is_empty(), "{i}: {:?}", whole.shadow_prices);
        for (min, max, end) in [(1.0, 0.6 * whole.ratio, "ratio_max"), (1.7 * whole.ratio, 1000.0, "ratio_min")] {
            case.robot.joints[0].ratio = RatioChoice::Continuous { min, max };
            let held = best(&case);
            let at = if end == "ratio_max" { max } else { min };
            assert!((held.ratio / at - 1.0).abs() < 1e-9, "{i}: {} {at}", held.ratio);
            let [price] = held.shadow_prices.as_slice() else { panic!("{i}: {:?}", held.shadow_prices) };
            assert_eq!(price.limit, end);
            let mut moved = |factor: f64| {
                let range = if end == "ratio_max" { (min, max * factor) } else { (min * factor, max) };
                case.robot.joints[0].ratio = RatioChoice::Continuous { min: range.0, max: range.1 };
                best(&Case::new(case.motor.clone(), case.robot.clone(), case.raw.clone())).objective
            };
            let slope = (moved(1.0 + 1e-5) - moved(1.0 - 1e-5)) / (2e-5 * at);
            assert!((price.price / slope - 1.0).abs() < 1e-3, "{i} {end}: {price:?} {slope}");
            assert!((price.elasticity / (price.price * at / held.objective) - 1.0).abs() < 1e-9);
            checked += 1;
        }
    }
    assert!(checked > 3, "{checked}");
}

/// A limit that is no end of the range has its price where ratios are evaluated, and the peak current has one where iron
/// saturates: the objective's difference over the bound's.
#[test]
fn limits_have_their_prices_where_effects_are_fitted() {
    let mut checked = std::collections::BTreeMap::new();
    for (i, effect, quantity) in (0..6).flat_map(|i| {
        [(i, "eddy_drag", Quantity::CopperLoss), (i, "torque_constant_saturation", Quantity::PeakCurrent)]
    }) {
        let mut case = free(i);
        let look = case.look(30.0);
        let current = (look.quantities[1] / case.motor.resistance).sqrt();
        let speed = 30.0 * case.raw.iter().map(|p| p.velocity.abs()).fold(1e-3, f64::max);
        let k_t = case.motor.torque_constant;
        let values = if effect == "eddy_drag" {
            vec![0.05 * k_t * current, speed]
        } else {
            vec![0.3 * k_t, 3.0 * look.quantities[3]]
        };
        case.motor.effects = vec![FittedEffect::new(effect, values).unwrap()];
        case.robot.joints[0].objective = Objective::single(quantity);
        let whole = solved(&case).unwrap().0;
        if !(2.0..500.0).contains(&whole.ratio) {
            continue;
        }
        let top = case.raw.iter().map(|p| p.velocity.abs()).fold(0.0, f64::max);
        let bound = 0.7 * whole.ratio * top;
        let mut best = |bound: f64| {
            case.motor.max_speed = Some(bound);
            solved(&case).unwrap().0
        };
        let held = best(bound);
        assert!((held.ratio * top / bound - 1.0).abs() < 1e-9, "{i} {effect}");
        let [price] = held.shadow_prices.as_slice() else { panic!("{i}: {:?}", held.shadow_prices) };
        assert_eq!(price.limit, "max_speed");
        let slope = (best(bound * (1.0 + 1e-5)).objective - best(bound * (1.0 - 1e-5)).objective) / (2e-5 * bound);
        assert!((price.price / slope - 1.0).abs() < 2e-3, "{i} {effect}: {price:?} {slope}");
        assert!((price.elasticity / (price.price * bound / held.objective) - 1.0).abs() < 1e-9);
        *checked.entry(effect).or_insert(0) += 1;
    }
    assert!(checked.len() == 2 && checked.values().all(|n| *n > 2), "{checked:?}");
}

/// What makes a program one that is not convex, and what does not: how it is proved tells.
#[test]
fn what_is_not_convex_in_n_squared_is_proved_otherwise() {
    let how = |case: &Case| match with_program(case, |p| p.solve()) {
        Ok(Optimum { certificate: Certificate::Certified { method, .. }, .. }) => method,
        other => panic!("{other:?}"),
    };
    let weighted = |a: Quantity, b: Quantity| Objective { terms: vec![(a, 1.0), (b, 1.0)] };
    let mut case = free(3);
    (case.motor.coulomb_friction, case.robot.bus.regeneration) = (None, Regeneration::Allowed);
    (case.robot.joints[0].gear.efficiency, case.robot.joints[0].gear.backdrive_efficiency) = (1.0, 1.0);
    assert_eq!(how(&case), "conic duality");
    case.robot.joints[0].objective = weighted(Quantity::CopperLoss, Quantity::Mass);
    (case.robot.joints[0].gear.mass, case.robot.joints[0].gear.mass_per_stage) = (Some(0.1), None);
    assert_eq!(how(&case), "conic duality");
    case.robot.joints[0].gear.mass_per_stage = Some((0.1, 3.0));
    assert_eq!(how(&case), "convex in 1/N");
    case.robot.joints[0].objective = weighted(Quantity::CopperLoss, Quantity::ReflectedInertia);
    assert_eq!(how(&case), "conic duality");
    // A modulus is not convex in 1/N; the one sample of its cut may be.
    case.robot.joints[0].objective = weighted(Quantity::CopperLoss, Quantity::PeakCurrent);
    assert_eq!(how(&case), "convex in 1/N");
    case.robot.joints[0].objective = Objective::single(Quantity::PeakCurrent);
    assert_eq!(how(&case), "conic duality");
    case.robot.joints[0].objective = Objective::single(Quantity::CopperLoss);
    case.robot.bus.regeneration = Regeneration::Limited(1e12);
    assert_eq!(how(&case), "branch and bound");
    case.robot.bus.regeneration = Regeneration::Allowed;
    case.motor.coulomb_friction = Some(1e-3);
    assert_eq!(how(&case), "convex in 1/N");
    case.robot.bus.regeneration = Regeneration::Limited(1e12);
    assert_eq!(how(&case), "branch and bound");
}

/// The same for a limit that every sample has a part in: the voltage, where a drag is evaluated.
#[test]
fn the_voltage_has_its_price_where_ratios_are_evaluated() {
    let mut checked = 0;
    for i in 0..16 {
        let mut case = free(i);
        let look = case.look(30.0);
        let current = (look.quantities[1] / case.motor.resistance).sqrt();
        let speed = 30.0 * case.raw.iter().map(|p| p.velocity.abs()).fold(1e-3, f64::max);
        let drag = FittedEffect::new("eddy_drag", vec![0.05 * case.motor.torque_constant * current, speed]).unwrap();
        case.motor.effects = vec![drag];
        let whole = solved(&case).unwrap().0;
        let voltage = |case: &Case, n: f64| {
            let demand = case.look(n).limits.into_iter().find(|l| l.0 == "voltage").unwrap();
            demand.1 / demand.2.unwrap() * case.robot.bus.voltage
        };
        // A bus that allows two thirds of the ratio.
        let bus = voltage(&case, 0.66 * whole.ratio);
        if !(2.0..500.0).contains(&whole.ratio) || voltage(&case, whole.ratio) < 1.05 * bus {
            continue;
        }
        let mut best = |factor: f64| {
            case.robot.bus.voltage = bus * factor;
            solved(&case).map(|s| s.0)
        };
        let Some(held) = best(1.0) else { continue };
        let Some(price) = held.shadow_prices.iter().find(|p| p.limit == "voltage") else { continue };
        let (Some(wider), Some(tighter)) = (best(1.0 + 1e-5), best(1.0 - 1e-5)) else { continue };
        let elasticity = (wider.objective - tighter.objective) / (2e-5 * held.objective);
        assert!((price.elasticity / elasticity - 1.0).abs() < 5e-3, "{i}: {price:?} {elasticity}");
        checked += 1;
    }
    println!("{checked} checked");
    assert!(checked > 2, "{checked}");
}
