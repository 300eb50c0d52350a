//! Modules: what a row says, taken to the flange and the q axis, and its own limits against the raw samples.

use std::f64::consts::TAU;
use std::sync::Arc;

use gearwise::catalog::{Catalog, Motor};
use gearwise::design::{Evaluation, optimize};
use gearwise::input::Source;
use gearwise::requirement::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::common;

/// Samples of a motion.
const SAMPLES: usize = 24;

fn catalog(files: &[(&str, &str)]) -> Catalog {
    let sources = files.iter().map(|(name, text)| Arc::new(Source::new(*name, *text))).collect();
    Catalog::from_sources(sources).unwrap_or_else(|e| panic!("{:?}", e[0].problems))
}

/// A table of one module: pairs of header and cell.
fn module_table(cells: &[(&str, String)]) -> String {
    let quoted = |cell: &String| format!("\"{cell}\"");
    let (head, row): (Vec<&str>, Vec<String>) = cells.iter().map(|(name, cell)| (*name, quoted(cell))).unzip();
    format!(
        "id,drive,ratio,source,source_kind,{}\nthe-module,built_in,{}\n",
        head.join(","),
        std::iter::once("9,test,derived".to_string()).chain(row).collect::<Vec<_>>().join(",")
    )
}

/// The module of a table as the model computes with it.
fn module(cells: &[(&str, String)]) -> Motor {
    let all = catalog(&[("modules.csv", &module_table(cells))]).with_modules([&"*".to_string()].into_iter(), |m| m);
    all.motors[0].clone()
}

fn text(cells: &[(&'static str, &str)]) -> Vec<(&'static str, String)> {
    cells.iter().map(|(name, cell)| (*name, cell.to_string())).collect()
}

/// A robot of one joint that takes modules alone, in a motion that repeats.
fn robot(seed: u64, size: f64, speed: f64) -> Robot {
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut within = |a: f64, b: f64| generator.random_range(a..b);
    let (a, b, c, turn) = (size * within(0.3, 1.0), within(0.0, TAU), size * within(-0.4, 0.4), within(0.0, TAU));
    let period = within(0.5, 2.0);
    let w = TAU / period;
    let time: Vec<f64> = (0..SAMPLES).map(|k| period * k as f64 / SAMPLES as f64).collect();
    let speed = speed * within(0.3, 1.0);
    let samples = Samples {
        torque: time.iter().map(|t| a * (w * t + b).sin() + c).collect(),
        velocity: Some(time.iter().map(|t| speed * (w * t + turn).sin() + 1e-3).collect()),
        acceleration: Some(time.iter().map(|t| speed * w * (w * t + turn).cos()).collect()),
        time,
        ..Samples::default()
    };
    let motion = Motion::from_samples(samples, Course::Periodic(period));
    let mut robot = common::robot(motion, GearModel::IDEAL);
    let joint = &mut robot.joints[0];
    joint.ratio = RatioChoice::gears(Vec::new(), EfficiencyCovers::Load);
    joint.motors.modules = vec!["*".into()];
    joint.motors.only_modules = true;
    robot
}

fn at(robot: &Robot, motor: &Motor) -> Evaluation {
    common::evaluate(robot, motor, 9.0)
}

const PAIR: &str = "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [g*cm^2],mass [g],peak_current [A],continuous_torque [N*m],reference_temperature [degC],inductance [mH],pole_pairs,coulomb_friction [N*m],source,source_kind
inner,line_to_line,rms,0.6,0.12,600,310,40,1.2,25,0.3,14,0.01,test,derived
";
const GEAR: &str =
    "id,kind,ratio,efficiency,mass [g],inertia [g*cm^2],continuous_torque [N*m],peak_torque [N*m],source,source_kind
inner-gear,planetary,9,0.9,150,40,30,60,test,derived
";

#[test]
fn a_module_of_known_insides_is_the_pair_to_the_last_bit() {
    let table = "id,drive,ratio,motor,gear,source,source_kind\nthe-module,built_in,9,inner,inner-gear,test,derived\n";
    let plain = catalog(&[("motors.csv", PAIR), ("gears.csv", GEAR), ("modules.csv", table)]);
    let with = plain.clone().with_modules([&"*".to_string()].into_iter(), |m| m);
    for seed in 0..40 {
        let inside = robot(seed, 8.0, 6.0);
        let mut pair = inside.clone();
        pair.joints[0].ratio = RatioChoice::gears(vec!["*".into()], EfficiencyCovers::Load);
        pair.joints[0].motors = Filter::default();
        let (one, other) = (optimize(&inside, &with), optimize(&pair, &plain));
        let (a, b) = (&one.joints[0].candidates, &other.joints[0].candidates);
        assert_eq!(a.len(), b.len());
        let Some((a, b)) = a.first().zip(b.first()) else { continue };
        assert_eq!((a.motor.id.as_str(), b.motor.id.as_str()), ("the-module", "inner"));
        let bits = |e: &Evaluation| {
            let figures = [e.ratio, e.loss, e.copper_loss, e.peak_current, e.reflected_inertia, e.mean_power];
            figures.map(f64::to_bits)
        };
        assert_eq!(bits(&a.evaluation), bits(&b.evaluation));
        assert_eq!(a.evaluation.mass, b.evaluation.mass);
        let of = |e: &Evaluation, name: &str| e.margins.iter().find(|m| m.limit == name).map(|m| m.demand.to_bits());
        for margin in &b.evaluation.margins {
            assert_eq!(of(&a.evaluation, margin.limit), Some(margin.demand.to_bits()), "{}", margin.limit);
        }
    }
}

/// The same machine: constants at the flange on the q axis.
const AT_FLANGE: [(&str, &str); 18] = [
    ("peak_torque [N*m]", "40"),
    ("rated_torque [N*m]", "12"),
    ("no_load_speed [rad/s]", "30"),
    ("voltage [V]", "48"),
    ("armature [kg*m^2]", "0.0081"),
    ("armature_side", "output"),
    ("torque_constant [N*m/A]", "1.5"),
    ("torque_constant_current", "q_axis"),
    ("torque_constant_side", "output"),
    ("torque_constant_loss", "nominal"),
    ("back_emf_constant [V*s/rad]", "1.5"),
    ("back_emf_convention", "q_axis"),
    ("back_emf_side", "output"),
    ("resistance [ohm]", "0.2"),
    ("terminals", "q_axis"),
    ("pole_pairs", "14"),
    ("efficiency", "0.9"),
    ("mass [g]", "800"),
];

fn changed(changes: &[(&'static str, String)]) -> Vec<(&'static str, String)> {
    let mut cells = text(&AT_FLANGE);
    for (name, cell) in changes {
        let place = cells.iter_mut().find(|(of, _)| of == name).unwrap_or_else(|| panic!("{name}"));
        place.1 = cell.clone();
    }
    cells
}

#[test]
fn one_machine_is_one_result_at_either_side_and_in_every_convention() {
    let n = 9.0_f64;
    let side = |what: &'static str| (what, "motor".to_string());
    let rewritten = [
        vec![side("armature_side"), ("armature [kg*m^2]", (0.0081 / (n * n)).to_string())],
        vec![side("torque_constant_side"), ("torque_constant [N*m/A]", (1.5 / n).to_string())],
        vec![side("back_emf_side"), ("back_emf_constant [V*s/rad]", (1.5 / n).to_string())],
        vec![
            ("torque_constant_current", "rms".into()),
            ("torque_constant [N*m/A]", (1.5 * 3.0_f64.sqrt()).to_string()),
        ],
        vec![
            ("torque_constant_current", "phase_amplitude".into()),
            ("torque_constant [N*m/A]", (1.5 * 1.5_f64.sqrt()).to_string()),
        ],
        vec![("back_emf_convention", "line_to_line_rms".into())],
        vec![
            ("back_emf_convention", "phase_peak".into()),
            ("back_emf_constant [V*s/rad]", (1.5 / 1.5_f64.sqrt()).to_string()),
        ],
        vec![("terminals", "line_to_line".into()), ("resistance [ohm]", "0.4".into())],
    ];
    for seed in 0..20 {
        let robot = robot(seed, 10.0, 8.0);
        let first = at(&robot, &module(&text(&AT_FLANGE)));
        for changes in &rewritten {
            let other = at(&robot, &module(&changed(changes)));
            for (a, b) in [
                (first.loss, other.loss),
                (first.copper_loss, other.copper_loss),
                (first.peak_current, other.peak_current),
                (first.reflected_inertia, other.reflected_inertia),
                (first.mean_power, other.mean_power),
            ] {
                assert!((a - b).abs() <= 1e-12 * a.abs(), "{changes:?}: {a} {b}");
            }
            for (a, b) in first.margins.iter().zip(&other.margins) {
                assert!(a.limit == b.limit && (a.demand - b.demand).abs() <= 1e-12 * a.demand.abs(), "{changes:?}");
            }
        }
    }
}

#[test]
fn what_goes_in_is_what_comes_out_and_what_is_lost() {
    for seed in 0..50 {
        let robot = robot(seed, 10.0, 8.0);
        let found = at(&robot, &module(&text(&AT_FLANGE)));
        let motion = &robot.joints[0].motion;
        let out = (0..SAMPLES).map(|k| motion.torque[k] * motion.velocity[k]).sum::<f64>() / SAMPLES as f64;
        let turned: f64 =
            (0..SAMPLES).map(|k| 0.0081 * motion.acceleration[k] * motion.velocity[k]).sum::<f64>() / SAMPLES as f64;
        let lost = found.losses.copper + found.losses.gear_load;
        let scale = found.mean_power.abs() + lost;
        assert!((found.mean_power - lost - out - turned).abs() < 1e-12 * scale, "{seed}");
    }
}

/// A curve at a speed, nothing behind its end.
fn on(curve: &[(f64, f64)], speed: f64) -> f64 {
    for pair in curve.windows(2) {
        let ((a, low), (b, high)) = (pair[0], pair[1]);
        if a <= speed && speed <= b {
            return low + (high - low) * (speed - a) / (b - a);
        }
    }
    0.0
}

#[test]
fn the_limits_of_a_module_are_those_of_the_raw_samples() {
    let (mut kept, mut exceeded, mut undecided) = (0, 0, 0);
    for seed in 0..1000 {
        let mut generator = Pcg64::seed_from_u64(seed);
        let mut within = |a: f64, b: f64| generator.random_range(a..b);
        let (peak, free) = (within(4.0, 30.0), within(4.0, 20.0));
        let knee = free * within(0.3, 0.9);
        let braking = peak * within(1.0, 1.3);
        let (rated, inertia) = (peak * within(0.3, 0.7), within(1e-4, 0.05));
        let volt = within(20.0, 90.0);
        let driving = [(0.0, peak), (knee, peak), (free, 0.0)];
        let against = [(0.0, braking), (knee, braking), (free, 0.0)];
        let curve =
            |points: &[(f64, f64)]| points.iter().map(|(a, b)| format!("{a}:{b}")).collect::<Vec<_>>().join(" ");
        let (low, high) = (within(15.0, 40.0), within(45.0, 60.0));
        let cells = [
            ("rated_torque [N*m]", rated.to_string()),
            ("no_load_speed [rad/s]", free.to_string()),
            ("voltage [V]", "48".to_string()),
            ("min_voltage [V]", low.to_string()),
            ("max_voltage [V]", high.to_string()),
            ("driving_curve [rad/s : N*m]", curve(&driving)),
            ("braking_curve [rad/s : N*m]", curve(&against)),
            ("armature [kg*m^2]", inertia.to_string()),
            ("armature_side", "output".to_string()),
            ("mass [g]", "500".to_string()),
            // So many that no turning point counts as standstill.
            ("pole_pairs", "2000".to_string()),
        ];
        let mut robot = robot(seed, 12.0, 9.0);
        robot.bus.voltage = volt;
        robot.joints[0].objective = Objective::single(Quantity::Mass);
        robot.joints[0].limits.safety = 1.0 + 0.3 * (seed % 2) as f64;
        let motor = module(&cells);
        let found = at(&robot, &motor);
        let motion = &robot.joints[0].motion;
        let torque = |k: usize| motion.torque[k] + inertia * motion.acceleration[k];
        // A machine without inductance: with less voltage the curve moves by what is lost of the speed without load.
        let moved = if volt < 48.0 { free * (1.0 - volt / 48.0) } else { 0.0 };
        // With more it is at least the curve, and certainly no more than the peak, up to as much more speed as there is voltage.
        let share = |k: usize| {
            let (t, w) = (torque(k), motion.velocity[k]);
            let asked = robot.joints[0].limits.safety * t.abs();
            let curve = if t * w < 0.0 { &against } else { &driving };
            let sure = on(curve, w.abs() + moved);
            let most = match (volt > 48.0 && t * w >= 0.0, w.abs() > free * volt / 48.0) {
                (false, _) => sure,
                (true, true) => 0.0,
                (true, false) => peak,
            };
            if asked > most { Some(asked / most) } else { Some(asked / sure).filter(|share| *share <= 1.0) }
        };
        let worst = (0..SAMPLES).filter_map(share).fold(0.0, f64::max);
        let open = worst <= 1.0 && (0..SAMPLES).any(|k| share(k).is_none());
        let rms = ((0..SAMPLES).map(|k| torque(k).powi(2)).sum::<f64>() / SAMPLES as f64).sqrt();
        let close = |a: f64, b: f64| (a.is_infinite() && b.is_infinite()) || (a - b).abs() <= 1e-9 * b.abs();
        assert!(close(common::demand(&found, "rated_torque"), rms), "{seed}: {rms}");
        if open {
            undecided += 1;
            assert!(found.margins.iter().all(|m| m.limit != "torque_speed"), "{seed}");
            continue;
        }
        assert!(close(common::demand(&found, "torque_speed"), worst), "{seed}: {worst}");
        let keeps = worst <= 1.0 && rms <= rated && low <= volt && volt <= high;
        assert_eq!(found.feasible, keeps, "{seed}: {worst} {rms} {rated} {volt} {low} {high}");
        assert!(found.loss.is_nan() && found.peak_current.is_nan());
        kept += usize::from(keeps);
        exceeded += usize::from(!keeps);
    }
    println!("{kept} keep all, {exceeded} do not, {undecided} are not decided");
    assert!(kept * 10 > exceeded && exceeded * 10 > kept && undecided >= 3);
}

#[test]
fn without_a_curve_only_what_is_certain_counts_as_kept_or_exceeded() {
    let (mut kept, mut exceeded, mut open) = (0, 0, 0);
    for seed in 0..300 {
        let mut generator = Pcg64::seed_from_u64(seed);
        let (peak, free) = (generator.random_range(6.0..20.0), generator.random_range(5.0..15.0));
        let cells = [
            ("peak_torque [N*m]", peak.to_string()),
            ("rated_torque [N*m]", (0.99 * peak).to_string()),
            ("no_load_speed [rad/s]", free.to_string()),
            ("voltage [V]", "48".to_string()),
            ("armature [kg*m^2]", "1e-9".to_string()),
            ("armature_side", "output".to_string()),
        ];
        let mut robot = robot(seed, 12.0, 9.0);
        robot.bus.voltage = 48.0;
        robot.joints[0].objective = Objective::single(Quantity::ReflectedInertia);
        let motor = module(&cells);
        let motion = &robot.joints[0].motion;
        let (mut inside, mut beyond) = (true, false);
        for k in 0..SAMPLES {
            let (t, w, drives) =
                (motion.torque[k].abs(), motion.velocity[k].abs(), motion.torque[k] * motion.velocity[k] >= 0.0);
            let line = if drives { peak * (1.0 - w / free) } else { peak };
            // Beyond the no-load speed nothing can be controlled.
            inside &= t <= line && w <= free;
            beyond |= t > peak || w > free;
        }
        let result = optimize(
            &robot,
            &catalog(&[("m.csv", &module_table(&cells))]).with_modules([&"*".into()].into_iter(), |m| m),
        )
        .joints
        .remove(0)
        .candidates
        .len();
        let found = at(&robot, &motor);
        let checked = found.margins.iter().any(|m| m.limit == "torque_speed");
        match (inside, beyond) {
            (true, _) => assert!(checked && found.feasible && result == 1, "{seed}"),
            (_, true) => assert!(!found.feasible, "{seed}"),
            // Neither is said: whether the torque is there cannot be judged, and it is no choice.
            _ => assert!(!checked && result == 0, "{seed}"),
        }
        kept += usize::from(inside);
        exceeded += usize::from(beyond);
        open += usize::from(!inside && !beyond);
    }
    assert!(kept > 10 && exceeded > 10 && open > 10, "{kept} {exceeded} {open}");
}

#[test]
fn what_a_row_does_not_say_is_not_known_and_no_choice_by_it() {
    let ratings = [
        ("peak_torque [N*m]", "100".to_string()),
        ("rated_torque [N*m]", "60".to_string()),
        ("no_load_speed [rad/s]", "100".to_string()),
        ("voltage [V]", "48".to_string()),
        ("mass [g]", "500".to_string()),
    ];
    let all = catalog(&[("m.csv", &module_table(&ratings))]).with_modules([&"*".into()].into_iter(), |m| m);
    let mut robot = robot(3, 10.0, 6.0);
    robot.bus.voltage = 48.0;
    for objective in [Quantity::Loss, Quantity::CopperLoss, Quantity::Energy, Quantity::ReflectedInertia] {
        robot.joints[0].objective = Objective::single(objective);
        let result = optimize(&robot, &all);
        let joint = &result.joints[0];
        assert!(joint.candidates.is_empty(), "{objective:?}");
        assert_eq!(joint.unjudged.len(), 1, "{objective:?}");
        let design = joint.unjudged[0].design.as_ref().expect("it keeps its ratings");
        assert!(!design.optimum.objective.is_finite() || objective == Quantity::Mass, "{objective:?}");
    }
    robot.joints[0].objective = Objective::single(Quantity::Mass);
    let result = optimize(&robot, &all);
    let best = &result.joints[0].candidates[0];
    assert_eq!(best.evaluation.mass, Some(0.5));
    let e = &best.evaluation;
    // No metric is made of what is not known.
    let metric = |name: &str| gearwise::actuator::metrics::metric(name).and_then(|m| m.value(best.motor));
    assert!(["s_m", "s_t", "k_m"].iter().all(|name| metric(name).is_none_or(f64::is_nan)));
    assert!(e.loss.is_nan() && e.reflected_inertia.is_nan() && e.mean_power.is_nan() && e.rms_current.is_nan());
    assert!(e.peak_power.is_none_or(f64::is_nan) && e.energy.is_none_or(f64::is_nan));
    assert!(!best.unchecked.is_empty(), "its own inertia is not known");
    // A temperature that the requirement states is not known of ratings.
    robot.joints[0].limits.winding_temperature = Some(373.15);
    assert!(optimize(&robot, &all).joints[0].candidates.is_empty());
}

#[test]
fn the_nine_motors_inside_modules_have_their_modules() {
    let all = Catalog::builtin().unwrap();
    let inside: Vec<&Motor> = all.motors.iter().filter(|m| !m.about.only_inside.is_empty()).collect();
    assert_eq!(inside.len(), 9);
    for motor in inside {
        assert!(all.modules.iter().any(|module| module.motor == motor.id), "{}", motor.id);
    }
    assert!(all.modules.len() >= 72, "{}", all.modules.len());
    for module in &all.modules {
        assert!(!module.source.is_empty() && !module.source_date.is_empty(), "{}", module.id);
    }
}
