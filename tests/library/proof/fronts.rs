//! Fronts of two and more quantities: random motors at random joints against dense scans of the raw waveforms, what follows on paper, and
//! where nothing may be called exact.

use std::sync::Arc;

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::options::Options;
use gearwise::design::pareto::{AS_GOOD, Front, FrontPoint, fronts};
use gearwise::design::sweep::sweep;
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::cases::{are_all, cases};
use crate::common;
use crate::raw::{Case, draw, golden};

/// Ratios of each motor along its own front.
const POINTS: usize = 13;
/// Ratios that the scan looks at over the whole range, and near what the program calls efficient.
const SCANNED: (usize, usize) = (140, 100);

fn catalog(motors: Vec<Motor>) -> Catalog {
    let row = "id,source,source_kind,terminals,current,resistance [ohm],torque_constant [N*m/A]\nm,-,derived,q_axis,q_axis,1,1";
    let mut catalog = Catalog::from_sources(vec![Arc::new(Source::new("motor.csv", row))]).unwrap();
    catalog.motors = motors;
    catalog
}

/// A motor at a joint as the raw waveforms see it.
struct Raw {
    case: Case,
    /// Ratios that keep every limit, with the quantities.
    dense: Vec<(f64, Vec<f64>)>,
}

/// What a ratio comes to in some quantities.
fn values(case: &Case, n: f64, quantities: &[Quantity]) -> Vec<f64> {
    let all = case.look(n).quantities;
    quantities.iter().map(|q| all[*q as usize]).collect()
}

/// Three motors like that of a case, with other windings, rotors and masses; each of them such that its heat can be judged, and most of
/// them with more current, torque and speed than the case has.
fn motors(case: &Case, i: u64) -> Vec<Motor> {
    let mut random = Pcg64::seed_from_u64(i + 5);
    let mut one = |k: usize| {
        let mut motor = Motor { id: format!("m{k}"), ..case.motor.clone() };
        let is_strong = random.random_bool(0.8);
        let mut around = |low: f64, high: f64| low * (high / low).powf(random.random_range(0.0..1.0));
        if is_strong {
            (motor.peak_current, motor.peak_torque, motor.max_speed) = (None, None, None);
            (motor.continuous_current, motor.continuous_torque) = (None, None);
            (motor.sheet.thermal_resistance_winding_housing, motor.thermal_resistance) = (None, None);
        }
        // The requirement states a temperature: something has to lead to it.
        motor.thermal_resistance = motor.thermal_resistance.or(Some(1e-12));
        if k > 0 {
            let (turns, rotor, mass) = (around(0.8, 1.25), around(0.4, 2.5), around(0.6, 1.6));
            // A small rotor and a light motor mostly cost more copper loss.
            let copper = around(0.8, 1.25) / (rotor * mass).powf(0.5);
            motor.torque_constant *= turns;
            motor.back_emf_constant *= turns;
            motor.resistance *= turns * turns * copper;
            motor.inductance = motor.inductance.map(|l| l * turns * turns);
            motor.rotor_inertia = motor.rotor_inertia.map(|j| j * rotor);
            motor.mass = motor.mass.map(|m| m * mass);
        }
        motor
    };
    (0..3).map(&mut one).collect()
}

/// So many different quantities of some, in any order; energy where there are durations.
fn some_of(case: &Case, from: &[Quantity], count: usize, i: u64) -> Vec<Quantity> {
    let mut random = Pcg64::seed_from_u64(i + 900);
    let timed = case.robot.joints[0].motion.has_durations();
    let mut from: Vec<Quantity> = from.iter().copied().filter(|q| *q != Quantity::Energy || timed).collect();
    (0..count).map(|_| from.remove(random.random_range(0..from.len()))).collect()
}

fn all_quantities() -> Vec<Quantity> {
    Quantity::NAMES.iter().map(|(_, quantity)| *quantity).collect()
}

/// Whether a point is nowhere above another and below it in something, both by more than rounding; `tie` is what equal may mean.
fn betters(a: &[f64], b: &[f64], size: &[f64], tie: f64, less: f64) -> bool {
    let pairs = || a.iter().zip(b).zip(size);
    pairs().all(|((a, b), size)| a - b <= tie * size) && pairs().any(|((a, b), size)| a - b < -less * size)
}

/// Sizes that a difference is measured by: the value, or a millionth of what is usual.
fn sizes(value: &[f64], usual: &[f64]) -> Vec<f64> {
    value.iter().zip(usual).map(|(v, usual)| v.abs().max(1e-6 * usual).max(1e-300)).collect()
}

#[derive(Default, Debug)]
struct Seen {
    unjudged: usize,
    rejected: usize,
    of_several: usize,
    motors: usize,
    certified: usize,
    with_friction: usize,
    with_stages: usize,
    single: usize,
    points: usize,
    bettered_on_grids: usize,
    efficient: usize,
    matched: usize,
    hidden: usize,
}

impl Seen {
    fn plus(self, o: Seen) -> Seen {
        Seen {
            unjudged: self.unjudged + o.unjudged,
            rejected: self.rejected + o.rejected,
            of_several: self.of_several + o.of_several,
            motors: self.motors + o.motors,
            certified: self.certified + o.certified,
            with_friction: self.with_friction + o.with_friction,
            with_stages: self.with_stages + o.with_stages,
            single: self.single + o.single,
            points: self.points + o.points,
            bettered_on_grids: self.bettered_on_grids + o.bettered_on_grids,
            efficient: self.efficient + o.efficient,
            matched: self.matched + o.matched,
            hidden: self.hidden + o.hidden,
        }
    }
}

/// The front of a case in some quantities against a scan of each of its motors.
fn against_a_scan(case: Case, i: u64, quantities: Vec<Quantity>) -> Seen {
    let count = quantities.len();
    let catalog = catalog(motors(&case, i));
    let Case { robot, raw, .. } = case;
    let front = fronts(&robot, &catalog, &quantities, POINTS, Options::default()).unwrap().remove(0);
    assert_eq!(front.motors + front.unjudged.len() + front.rejected.len(), catalog.motors.len(), "{i}");
    let RatioChoice::Continuous { min, max } = robot.joints[0].ratio else { unreachable!() };
    let mut seen = Seen { unjudged: front.unjudged.len(), rejected: front.rejected.len(), ..Seen::default() };
    let mut on_front: Vec<&str> = front.points.iter().map(|p| p.motor.id.as_str()).collect();
    on_front.sort_unstable();
    on_front.dedup();
    seen.of_several = usize::from(on_front.len() > 1);
    let raws: Vec<Raw> = front
        .efficient
        .iter()
        .map(|of| {
            let case = Case::new(of.motor.clone(), robot.clone(), raw.clone());
            let between = |a: f64, b: f64, count: usize| {
                (0..=count).map(move |k| a * (b / a).powf(k as f64 / count as f64)).collect::<Vec<f64>>()
            };
            let mut ratios = between(min, max, SCANNED.0);
            ratios.extend(between((of.from / 1.2).max(min), (of.to * 1.2).min(max), SCANNED.1));
            ratios.extend([of.from, of.to]);
            ratios.extend(&of.stages);
            ratios.sort_by(f64::total_cmp);
            ratios.dedup();
            let keeps = |n: &f64| case.worst(*n).0 <= 0.0 || [of.from, of.to].contains(n) || of.stages.contains(n);
            let dense = ratios.into_iter().filter(keeps).map(|n| (n, values(&case, n, &quantities))).collect();
            Raw { case, dense }
        })
        .collect();
    let usual: Vec<f64> = (0..count)
        .map(|k| raws.iter().flat_map(|raw| &raw.dense).map(|(_, v)| v[k].abs()).fold(0.0, f64::max))
        .collect();
    for (of, raw) in front.efficient.iter().zip(&raws) {
        seen.motors += 1;
        if of.certified {
            seen.certified += 1;
            seen.with_friction += usize::from(of.motor.coulomb_friction.is_some());
            seen.with_stages += usize::from(!of.stages.is_empty());
            seen.single += usize::from(of.from == of.to);
            efficient_is_what_the_scan_shows(of, raw, &usual, i, &quantities);
        }
    }
    // What is shown is a design that keeps all limits, and what it says of it is true.
    let raw_of = |id: &str| front.efficient.iter().zip(&raws).find(|(of, _)| of.motor.id == id).unwrap();
    for p in &front.points {
        let (of, raw) = raw_of(&p.motor.id);
        let n = p.evaluation.ratio;
        let there = values(&raw.case, n, &quantities);
        let size = sizes(&there, &usual);
        for (k, size) in size.iter().enumerate() {
            assert!(
                (p.values[k] - there[k]).abs() <= 1e-8 * size,
                "{i}: {:?} {} {}",
                quantities[k],
                p.values[k],
                there[k]
            );
        }
        assert!(raw.case.worst(n).0 <= 1e-7, "{i}: {n} {:?}", raw.case.worst(n));
        assert_eq!(p.certified, of.certified, "{i}");
    }
    bettered_or_missing(&front, &raws, &usual, i, &mut seen);
    seen
}

/// The ratios of a motor that none of its own betters are those that are called so.
fn efficient_is_what_the_scan_shows(
    of: &gearwise::design::pareto::Efficient,
    raw: &Raw,
    usual: &[f64],
    i: u64,
    quantities: &[Quantity],
) {
    let tell = || format!("{i}: {quantities:?} {} {} to {}, {:?}", of.motor.id, of.from, of.to, of.stages);
    let near = 2e-3;
    for (n, z) in &raw.dense {
        let size = sizes(z, usual);
        let inside = of.from * (1.0 + near) < *n && *n < of.to * (1.0 - near);
        let outside = (*n < of.from * (1.0 - near) || of.to * (1.0 + near) < *n)
            && of.stages.iter().all(|stage| (n / stage - 1.0).abs() > near);
        let by = |tie: f64, less: f64| raw.dense.iter().find(|(_, y)| betters(y, z, &size, tie, less));
        // Rounding may take what is flat for falling.
        let better = if inside { by(0.0, 1e-9) } else { None };
        assert!(better.is_none(), "{}: {n} {z:?} is bettered by {better:?}", tell());
        let same = || raw.dense.iter().any(|(m, y)| (of.from..=of.to).contains(m) && betters(y, z, &size, 1e-9, -1e-8));
        assert!(!outside || by(1e-10, 1e-13).is_some() || same(), "{}: {n} {z:?} is not bettered", tell());
    }
}

/// No point is bettered by what is proved to have been compared, and what the scan shows to be on the front is near a point.
fn bettered_or_missing(front: &Front, raws: &[Raw], usual: &[f64], i: u64, seen: &mut Seen) {
    let mass = front.quantities.iter().position(|q| *q == Quantity::Mass);
    // Of a quantity that no ratio changes a tie is enough.
    let clearly = |y: &[f64], p: &[f64], by: f64| {
        let size = sizes(p, usual);
        let less = |k: usize| match mass {
            Some(mass) if mass == k => y[k] <= p[k] * (1.0 + AS_GOOD),
            _ => y[k] < p[k] - by * size[k],
        };
        (0..p.len()).all(less)
    };
    for p in &front.points {
        seen.points += 1;
        for (of, raw) in front.efficient.iter().zip(raws) {
            let better = raw.dense.iter().find(|(n, y)| {
                // The scan's ends of the range of efficient ratios are the program's own.
                *n != p.evaluation.ratio && clearly(y, &p.values, 1e-8)
            });
            if of.certified {
                let at = p.evaluation.ratio;
                assert!(better.is_none(), "{i}: {} at {at} {:?} by {} {better:?}", p.motor.id, p.values, of.motor.id);
            } else {
                seen.bettered_on_grids += usize::from(better.is_some());
            }
        }
    }
    for (of, raw) in front.efficient.iter().zip(raws).filter(|(of, _)| of.certified) {
        let spacing = (of.to / of.from).powf(1.0 / (POINTS - 1) as f64) * 1.001;
        for (n, z) in &raw.dense {
            let size = sizes(z, usual);
            let others = || {
                let of_scan = raws.iter().flat_map(|raw| raw.dense.iter().map(|(_, y)| y.as_slice()));
                of_scan.chain(front.points.iter().map(|p| p.values.as_slice()))
            };
            if others().any(|y| betters(y, z, &size, 1e-9, 1e-7)) {
                continue;
            }
            seen.efficient += 1;
            let is_near = |p: &&FrontPoint| {
                p.motor.id == of.motor.id && (p.evaluation.ratio / n).max(n / p.evaluation.ratio) <= spacing
            };
            let same = |p: &FrontPoint| betters(&p.values, z, &size, 1e-6, -1.0);
            if front.points.iter().any(|p| is_near(&p) || same(p)) {
                seen.matched += 1;
                continue;
            }
            // Between two ratios of the scan another motor may better it.
            let margin = raws.iter().map(|raw| margin(raw, z, &size, &front.quantities)).fold(f64::INFINITY, f64::min);
            let points =
                || front.points.iter().map(|p| (&p.motor.id, p.evaluation.ratio, &p.values)).collect::<Vec<_>>();
            let tell = || format!("{} to {}: {:?}", of.from, of.to, points());
            assert!(
                margin < 1e-3,
                "{i}: {:?} {} at {n} {z:?} is on the front\n{}",
                front.quantities,
                of.motor.id,
                tell()
            );
            seen.hidden += 1;
        }
    }
}

/// By how much some quantity has to be more, at whatever ratio of a motor, where the others are no more than these values.
fn margin(raw: &Raw, z: &[f64], size: &[f64], quantities: &[Quantity]) -> f64 {
    let excess = |y: &[f64]| y.iter().zip(z).zip(size).map(|((y, z), size)| (y - z) / size).fold(f64::MIN, f64::max);
    let at =
        |n: f64| if raw.case.worst(n).0 <= 1e-9 { excess(&values(&raw.case, n, quantities)) } else { f64::INFINITY };
    let order = |a: &usize, b: &usize| excess(&raw.dense[*a].1).total_cmp(&excess(&raw.dense[*b].1));
    let best = (0..raw.dense.len()).min_by(order).filter(|_| raw.dense.iter().all(|(_, y)| y != z));
    // Of the motor itself nothing betters it.
    let Some(best) = best else { return f64::INFINITY };
    let around = [best.saturating_sub(1), (best + 1).min(raw.dense.len() - 1)].map(|k| raw.dense[k].0);
    excess(&raw.dense[best].1).min(at(golden(at, around)))
}

fn run(range: std::ops::Range<u64>, one: impl Fn(u64) -> (Case, Vec<Quantity>) + Sync) -> Seen {
    let one = |i: u64| {
        let (case, quantities) = one(i);
        against_a_scan(case, i, quantities)
    };
    let seen = range.into_par_iter().map(one).reduce(Seen::default, Seen::plus);
    println!("{seen:?}");
    assert!(seen.matched > 10 * seen.hidden, "{seen:?}");
    seen
}

/// A case on a bus of enough voltage.
fn on_a_bus(i: u64, convex: bool) -> Case {
    let Case { motor, mut robot, raw, .. } = draw(i, convex);
    robot.bus.voltage *= 2.0;
    (robot.bus.drive_current, robot.joints[0].drive_current) = (None, None);
    Case::new(motor, robot, raw)
}

/// Without friction a motor's own front is proved, but where its best ratio cannot be judged.
#[test]
fn fronts_of_three_quantities_without_friction_agree_with_a_scan() {
    let seen = run(cases(700_000, 260), |i| {
        let case = on_a_bus(i, true);
        let quantities = some_of(&case, &all_quantities(), 3, i);
        (case, quantities)
    });
    let often =
        50 * seen.certified > 49 * seen.motors && seen.of_several > 60 && seen.with_stages > 20 && seen.single > 20;
    assert!(!are_all() || often, "{seen:?}");
}

/// With friction, limits on what comes back and drives without a loss: exact is said where the means alone count.
#[test]
fn fronts_of_three_quantities_with_friction_agree_with_a_scan() {
    let means = [Quantity::Loss, Quantity::CopperLoss, Quantity::Mass, Quantity::ReflectedInertia];
    let seen = run(cases(720_000, 240), |i| {
        let mut case = on_a_bus(i, false);
        if i % 2 == 0 {
            (case.robot.bus.drive_efficiency, case.robot.bus.regeneration) = (1.0, Regeneration::Allowed);
            case = Case::new(case.motor, case.robot, case.raw);
        }
        let quantities = some_of(&case, &if i % 4 < 2 { means.to_vec() } else { all_quantities() }, 3, i);
        (case, quantities)
    });
    let often = seen.of_several > 50 && seen.with_friction > 50 && 20 * seen.certified < 19 * seen.motors;
    assert!(!are_all() || often, "{seen:?}");
}

#[test]
fn fronts_of_two_and_of_five_quantities_agree_with_a_scan() {
    for (first, all, count) in [(740_000, 80, 2), (750_000, 60, 5)] {
        run(cases(first, all), |i| {
            let case = on_a_bus(i, i % 3 > 0);
            let quantities = some_of(&case, &all_quantities(), count, i);
            (case, quantities)
        });
    }
}

fn front_of<'a>(robot: &'a Robot, catalog: &'a Catalog, quantities: &[Quantity]) -> Front<'a> {
    fronts(robot, catalog, quantities, 33, Options::default()).unwrap().remove(0)
}

fn row(id: &str, cells: &[(&str, &str)]) -> Motor {
    let usual = [("torque_constant [N*m/A]", "0.1"), ("resistance [ohm]", "0.5"), ("mass [kg]", "0.4")];
    let rest = usual.into_iter().chain([("rotor_inertia [kg*m^2]", "1e-3")]);
    let rest = rest.filter(|(name, _)| !cells.iter().any(|(n, _)| n == name));
    let cells: Vec<(&str, &str)> = cells.iter().copied().chain(rest).collect();
    Motor { id: id.into(), ..common::motor(&cells) }
}

/// T = 10/N + 0.1 N − 3: braking friction makes the current vanish at two ratios, with a hump between. From 2 to the first of them
/// current and inertia are traded; between the two nothing is efficient, although both may be called the best in current.
#[test]
fn where_friction_makes_two_valleys_nothing_is_called_exact() {
    let mut robot = common::robot(common::hold(10.0, -1.0, 100.0), common::gear(1.0));
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 40.0 };
    let all = catalog(vec![row("rubs", &[("coulomb_friction [N*m]", "3")])]);
    let first = (3.0 - 5.0_f64.sqrt()) / 0.2;
    for quantities in [
        &[Quantity::PeakCurrent, Quantity::ReflectedInertia][..],
        &[Quantity::Mass, Quantity::ReflectedInertia, Quantity::PeakCurrent],
        &[Quantity::PeakCurrent, Quantity::Energy, Quantity::PeakPower],
    ] {
        let front = front_of(&robot, &all, quantities);
        assert!(!front.points.is_empty() && front.points.iter().all(|p| !p.certified), "{quantities:?}");
        assert!(front.efficient.iter().all(|of| !of.certified), "{:?}", front.efficient);
    }
    let front = front_of(&robot, &all, &[Quantity::PeakCurrent, Quantity::ReflectedInertia, Quantity::Mass]);
    for p in &front.points {
        let n = p.evaluation.ratio;
        assert!(n < 1.2 * first || p.values[0] < 1e-6, "{n} {:?}", p.values);
    }
    assert!(front.points.iter().any(|p| p.evaluation.ratio == 2.0));
    // Of the only sample the copper loss is the square of that torque: it has two valleys, too, and is not convex in 1/N.
    let front = front_of(&robot, &all, &[Quantity::CopperLoss, Quantity::ReflectedInertia, Quantity::Mass]);
    assert!(!front.points.is_empty() && front.efficient.iter().all(|of| !of.certified), "{:?}", front.efficient);
}

/// Coulomb friction in a motion to and fro: loss, mass and inertia are exact; with the peak of anything they are not.
#[test]
fn friction_leaves_means_exact_and_peaks_not() {
    let points = [(6.0, 4.0, 30.0), (-5.0, -4.0, -20.0), (3.0, 1.0, -10.0)].map(|(torque, velocity, acceleration)| {
        Point { torque, velocity, acceleration, duration: Some(1.0), ..Point::default() }
    });
    let mut robot = common::robot(Motion::from_points(&points), common::gear(0.9));
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 200.0 };
    // So many poles that no point is slow.
    let poles = ("pole_pairs", "70");
    let rows =
        vec![row("rubs", &[("coulomb_friction [N*m]", "0.02"), poles]), row("free", &[("mass [kg]", "0.3"), poles])];
    let all = catalog(rows);
    let front = front_of(&robot, &all, &[Quantity::Loss, Quantity::Mass, Quantity::ReflectedInertia]);
    assert!(front.efficient.iter().all(|of| of.certified && of.from == 2.0 && of.to > 5.0), "{:?}", front.efficient);
    // The end is where the loss of a scan is least.
    let loss = |n: f64| common::evaluate(&robot, &all.motors[0], n).loss;
    let least = (0..=100_000).map(|k| 2.0 * 100.0_f64.powf(f64::from(k) / 100_000.0));
    let least = least.min_by(|a, b| loss(*a).total_cmp(&loss(*b))).unwrap();
    let rubs = front.efficient.iter().find(|of| of.motor.id == "rubs").unwrap();
    assert!((rubs.to / least - 1.0).abs() < 1e-3, "{} {least}", rubs.to);
    for peak in [Quantity::PeakCurrent, Quantity::PeakPower, Quantity::Energy] {
        let front = front_of(&robot, &all, &[Quantity::Loss, peak, Quantity::ReflectedInertia]);
        for of in &front.efficient {
            assert_eq!(of.certified, of.motor.id == "free", "{peak:?}");
        }
    }
}

/// A drive that loses something, and an effect that is evaluated, prove nothing with friction, and nothing at all.
#[test]
fn what_is_evaluated_is_not_exact() {
    let mut robot = common::robot(common::hold(8.0, 3.0, 50.0), common::gear(0.9));
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 60.0 };
    let quantities = [Quantity::Loss, Quantity::Mass, Quantity::ReflectedInertia];
    let rubs = catalog(vec![row("rubs", &[("coulomb_friction [N*m]", "0.02")])]);
    robot.bus.drive_efficiency = 0.9;
    assert!(front_of(&robot, &rubs, &quantities).points.iter().all(|p| !p.certified));
    robot.bus.drive_efficiency = 1.0;
    assert!(front_of(&robot, &rubs, &quantities).points.iter().all(|p| p.certified));
    // A family of gears: each ratio has its own.
    let map_row = |ratio: f64| MapRow {
        ratio,
        mass: Some(0.1),
        inertia: Some(0.0),
        driving: Some(1.1),
        braking: Some(0.9),
        no_load_torque: None,
        peak_torque: None,
        continuous_torque: None,
        max_input_speed: None,
    };
    robot.joints[0].gear_map = Some(Arc::new(GearMap::new(&[map_row(2.0), map_row(60.0)]).unwrap()));
    let free = catalog(vec![row("free", &[])]);
    let front = front_of(&robot, &free, &quantities);
    assert!(!front.points.is_empty() && front.points.iter().all(|p| !p.certified));
}

/// Mass of one kilogram a stage of at most 5: by the load alone the largest ratio is the best, so that the efficient ones are the best
/// ratio and the last of each stage below it, whatever grid is asked for.
#[test]
fn stages_end_where_mass_steps() {
    let gear = GearModel { mass: None, mass_per_stage: Some((1.0, 5.0)), ..common::gear(0.9) };
    let mut robot = common::robot(common::hold(10.0, 0.0, 0.0), gear);
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 60.0 };
    let all = catalog(vec![row("only", &[])]);
    for quantities in [
        &[Quantity::CopperLoss, Quantity::Mass][..],
        &[Quantity::Mass, Quantity::CopperLoss],
        &[Quantity::CopperLoss, Quantity::Mass, Quantity::PeakCurrent],
    ] {
        let front = front_of(&robot, &all, quantities);
        let mut ratios: Vec<f64> = front.points.iter().map(|p| p.evaluation.ratio).collect();
        ratios.sort_by(f64::total_cmp);
        assert_eq!(ratios.len(), 3, "{ratios:?}");
        let apart = ratios.iter().zip([5.0, 25.0, 60.0]).map(|(a, b): (&f64, f64)| (a / b - 1.0).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-9 && front.points.iter().all(|p| p.certified), "{ratios:?}");
        let of = &front.efficient[0];
        assert!(of.stages == [5.0, 25.0] && of.certified && of.from == of.to);
    }
    // With the inertia all ratios are traded, and the stages are among the points.
    let front = front_of(&robot, &all, &[Quantity::CopperLoss, Quantity::Mass, Quantity::ReflectedInertia]);
    let of = &front.efficient[0];
    assert!((of.from, of.stages.len()) == (2.0, 0) && (of.to / 60.0 - 1.0).abs() < 1e-9 && of.certified);
    assert!([5.0, 25.0].iter().all(|n| front.points.iter().any(|p| p.evaluation.ratio == *n)));
}

/// What no ratio changes moves nothing, and where all have one best ratio there is one point.
#[test]
fn what_no_ratio_changes_moves_no_end() {
    let mut robot = common::robot(common::hold(8.0, 3.0, 0.0), common::gear(0.9));
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 60.0 };
    let all = catalog(vec![row("only", &[("viscous_friction [N*m*s/rad]", "1e-4")])]);
    let two = front_of(&robot, &all, &[Quantity::Loss, Quantity::ReflectedInertia]);
    for quantities in [
        [Quantity::Loss, Quantity::Mass, Quantity::ReflectedInertia],
        [Quantity::Mass, Quantity::ReflectedInertia, Quantity::Loss],
    ] {
        let three = front_of(&robot, &all, &quantities);
        let ends = |front: &Front| (front.efficient[0].from, front.efficient[0].to);
        assert_eq!(ends(&three), ends(&two));
        assert_eq!(three.points.len(), two.points.len());
    }
    let one = front_of(&robot, &all, &[Quantity::Mass, Quantity::ReflectedInertia]);
    assert_eq!((one.points.len(), one.points[0].evaluation.ratio, one.points[0].certified), (1, 2.0, true));
    // No torque and no speed: nothing is lost and nothing drawn at any ratio, and the least inertia decides.
    let still = common::robot(common::hold(0.0, 0.0, 0.0), common::gear(0.9));
    let still = {
        let mut still = still;
        still.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 60.0 };
        still
    };
    let all = catalog(vec![row("only", &[])]);
    let front =
        front_of(&still, &all, &[Quantity::Loss, Quantity::PeakPower, Quantity::Mass, Quantity::ReflectedInertia]);
    let ratios: Vec<f64> = front.points.iter().map(|p| p.evaluation.ratio).collect();
    assert_eq!(ratios, [2.0], "{:?}", front.efficient);
}

/// Of two motors of one mass and rotor that with less resistance betters the other at every ratio, and also between the points of both:
/// their grids have no ratio in common.
#[test]
fn a_winding_of_less_resistance_betters_its_like_between_their_points() {
    let points = [(6.0, 4.0, 30.0), (-5.0, -4.0, -20.0)].map(|(torque, velocity, acceleration)| Point {
        torque,
        velocity,
        acceleration,
        duration: Some(1.0),
        ..Point::default()
    });
    let mut robot = common::robot(Motion::from_points(&points), common::gear(0.9));
    robot.joints[0].ratio = RatioChoice::Continuous { min: 2.0, max: 200.0 };
    let drag = ("viscous_friction [N*m*s/rad]", "1e-4");
    let all = catalog(vec![row("worse", &[drag, ("resistance [ohm]", "0.505")]), row("better", &[drag])]);
    for quantities in [
        &[Quantity::Loss, Quantity::ReflectedInertia][..],
        &[Quantity::Loss, Quantity::Mass, Quantity::ReflectedInertia],
    ] {
        let front = front_of(&robot, &all, quantities);
        assert_eq!((front.motors, front.efficient.len()), (2, 2));
        assert!(front.points.iter().all(|p| p.motor.id == "better"), "{quantities:?}");
        assert!(front.points.len() >= 33);
    }
}

/// With two points for each motor both those of the second are bettered, at 4 and at 16; about 8 it is the better one. By hand, with N² for
/// the inertia: 400/N² + 0.06 N of the one that rubs against 410/N² + 0.004 N² of the other.
#[test]
fn a_motor_that_is_the_best_between_its_points_is_not_missing() {
    let hold = Point { torque: 4.0, duration: Some(1.0), ..Point::default() };
    let turn = Point { velocity: 10.0, duration: Some(1.0), ..Point::default() };
    let mut robot = common::robot(Motion::from_points(&[hold, turn]), common::gear(1.0));
    robot.joints[0].ratio = RatioChoice::Continuous { min: 4.0, max: 16.0 };
    let rubs = row("rubs", &[("coulomb_friction [N*m]", "0.012")]);
    let drags = row("drags", &[("viscous_friction [N*m*s/rad]", "8e-5"), ("resistance [ohm]", "0.5125")]);
    let all = catalog(vec![rubs, drags]);
    let loss = |k: usize, n: f64| common::evaluate(&robot, &all.motors[k], n).loss;
    assert!(loss(0, 4.0) < loss(1, 4.0) && loss(1, 8.0) < 0.995 * loss(0, 8.0) && loss(0, 16.0) < loss(1, 16.0));
    let quantities = [Quantity::Loss, Quantity::ReflectedInertia];
    let front = fronts(&robot, &all, &quantities, 2, Options::default()).unwrap().remove(0);
    assert!(front.efficient.iter().all(|of| of.certified && (of.from, of.to) == (4.0, 16.0)), "{:?}", front.efficient);
    let of =
        |id: &str| front.points.iter().filter(|p| p.motor.id == id).map(|p| p.evaluation.ratio).collect::<Vec<_>>();
    assert!([4.0, 16.0].iter().all(|n| of("rubs").contains(n)), "{:?}", of("rubs"));
    assert!(!of("drags").is_empty() && of("drags").iter().all(|n| (6.5..14.5).contains(n)), "{:?}", of("drags"));
}

/// All gears of a catalogue, and all ratios of a list: the front is what no other pair of a sweep betters.
#[test]
fn gears_and_listed_ratios_are_those_of_a_sweep() {
    let builtin = Catalog::builtin().unwrap();
    let gears = read(&common::repository("requirements/humanoid_hip_catalog_gears.toml")).unwrap();
    let mut listed = read(&common::repository("requirements/exoskeleton_hip.toml")).unwrap();
    listed.joints[0].ratio =
        RatioChoice::Listed { values: vec![10.0, 16.0, 25.0, 40.0, 50.0], step: None, teeth: None };
    for robot in [gears, listed] {
        let quantities = [Quantity::Loss, Quantity::Mass, Quantity::ReflectedInertia, Quantity::PeakCurrent];
        let front = front_of(&robot, &builtin, &quantities);
        assert!(front.efficient.is_empty() && front.points.iter().all(|p| p.certified));
        let swept = sweep(&robot, &builtin, 5).remove(0);
        let all: Vec<(String, Vec<f64>)> = swept
            .designs
            .iter()
            .filter(|d| d.is_choice())
            .filter_map(|d| {
                let values = quantities.iter().map(|q| d.evaluation.quantity(*q)).collect::<Option<Vec<f64>>>()?;
                Some((format!("{} {:?} {}", d.motor.id, d.gear, d.evaluation.ratio), values))
            })
            .collect();
        let is_bettered = |z: &[f64]| all.iter().any(|(_, y)| y != z && y.iter().zip(z).all(|(y, z)| y <= z));
        let mut expected: Vec<Vec<f64>> = all.iter().filter(|(_, z)| !is_bettered(z)).map(|(_, z)| z.clone()).collect();
        expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
        expected.dedup();
        let shown: Vec<Vec<f64>> = front.points.iter().map(|p| p.values.clone()).collect();
        assert_eq!(shown, expected, "{}", robot.name);
        assert!(shown.len() > 3, "{}", shown.len());
    }
}

/// The same front for any number of threads.
#[test]
fn threads_change_no_front() {
    let catalog = Catalog::builtin().unwrap();
    let robot = read(&common::repository("requirements/quadruped_mini_cheetah.toml")).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let quantities = [Quantity::Loss, Quantity::Mass, Quantity::ReflectedInertia];
            let all = fronts(&robot, &catalog, &quantities, 9, Options::default()).unwrap();
            let report = gearwise::report::json::pareto::json(&robot, &all);
            gearwise::report::json_text(&report) + &gearwise::report::pareto::text(&all, 10)
        })
    };
    assert_eq!(run(1), run(4));
}
