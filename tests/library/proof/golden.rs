//! What is chosen first is what an experienced engineer would build: the classes of `tests/golden/expected.toml`, written with
//! their reasons before the code; and no first choice of any requirement overheats.

use std::f64::consts::PI;
use std::fs;

use gearwise::actuator::estimate::complete;
use gearwise::actuator::limits::{Candidate, Check, LIMITS};
use gearwise::catalog::convention::word;
use gearwise::catalog::estimate::Estimated;
use gearwise::catalog::{Catalog, Construction, Motor};
use gearwise::design::answer::Design;
use gearwise::design::balance::balanced;
use gearwise::design::optimize::optimize_with;
use gearwise::design::options::Options;
use gearwise::design::{JointDemand, Site, optimize};
use gearwise::requirement::{self, Balancing, RatioChoice, Robot};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::common::repository;

/// The built-in catalogue as one chooses from it.
fn choice() -> Catalog {
    complete(Catalog::builtin().unwrap().free(false))
}

/// The outer diameter [m], at least: that of the gap counts where nothing else is known.
fn diameter(motor: &Motor) -> Option<f64> {
    let outer = motor.sheet.outer_diameter.map(|p| p.value);
    outer.or(motor.sheet.gap_radius.map(|p| 2.0 * p.value))
}

/// Twice 0.5 W per cm² of the motor's outer surface; where its size is not known, twice the 90th percentile of W/kg of the
/// rows of known heat.
fn most_heat(motor: &Motor, catalog: &Catalog) -> f64 {
    let sizes = (diameter(motor), motor.sheet.length.map(|p| p.value));
    if let (Some(d), Some(l)) = sizes {
        return 2.0 * 5000.0 * (PI * d * l + 0.5 * PI * d * d);
    }
    let mut all: Vec<f64> = catalog
        .motors
        .iter()
        .filter(|m| m.estimates.is_empty())
        .filter_map(|m| {
            let rated = m.continuous_current.map(|i| i * i * m.resistance);
            let torque = m.continuous_torque.map(|t| (t / m.torque_constant).powi(2) * m.resistance);
            let path = m.thermal_resistance.map(|r_th| 75.0 / r_th / 1.29);
            Some([rated, torque, path].into_iter().flatten().reduce(f64::min)? / m.mass?)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    2.0 * all[all.len() * 9 / 10] * motor.mass.expect("a first choice that says nothing of its size")
}

/// Heat is a limit that was judged, or one that was and counts as kept.
fn heat_is_judged(robot: &Robot, catalog: &Catalog, joint: usize, design: &Design) -> bool {
    const HEAT: &[&str] = &[
        "continuous_current",
        "continuous_torque",
        "winding_temperature",
        "winding_peak_temperature",
        "standstill_holding",
    ];
    let joint = &robot.joints[joint];
    let demand = JointDemand::new(joint, catalog);
    let mount = Site::new(robot, joint, &demand).mount(design.motor, design.gear).unwrap();
    let candidate: Candidate = mount.candidate().unwrap();
    let witness = candidate.steady_current().is_some();
    let unknown = LIMITS.iter().any(|l| HEAT.contains(&l.name) && matches!(l.check(&candidate), Check::Unknown(_)));
    witness && !unknown && design.unchecked.iter().all(|(name, _)| !HEAT.contains(name))
}

fn number(table: &toml::Table, key: &str) -> (f64, f64) {
    let of = |k: usize| table[key][k].as_integer().map(|i| i as f64).or(table[key][k].as_float()).unwrap();
    (of(0), of(1))
}

#[test]
fn first_choices_are_of_the_class_that_an_engineer_would_build() {
    let catalog = choice();
    let text = fs::read_to_string(repository("tests/golden/expected.toml")).unwrap();
    let expected: toml::Table = text.parse().unwrap();
    assert!(expected.len() >= 3);
    for (name, class) in &expected {
        let class = class.as_table().unwrap();
        let robot = requirement::read(&repository(&format!("tests/golden/{name}.toml"))).unwrap();
        // No objective is stated: what the tool puts first is the balanced choice.
        let robot = balanced(&robot, &catalog, Options::default()).unwrap();
        assert!(matches!(robot.joints[0].balancing, Balancing::Made(_)), "{name}");
        let result = optimize(&robot, &catalog);
        for (k, joint) in result.joints.iter().enumerate() {
            let best = joint.candidates.first().unwrap_or_else(|| panic!("{name} has no choice"));
            let near = |d: &&Design| {
                let open = best.motor.is_estimated(Estimated::Drag) && d.motor.is_estimated(Estimated::Drag);
                open && d.optimum.objective <= 1.01 * best.optimum.objective
            };
            let found = std::iter::once(best).chain(joint.candidates.iter().skip(1).filter(near));
            let outside = |design: &Design| -> Option<String> {
                let motor = design.motor;
                let what = format!("{name}: {} {:?} at {}", motor.id, design.gear, design.evaluation.ratio);
                let built = word(Construction::NAMES, &motor.about.construction?);
                let allowed = class["construction"].as_array().unwrap();
                let is_allowed = allowed.iter().any(|c| c.as_str() == Some(built));
                let within = |value: f64, key: &str| {
                    let (low, high) = number(class, key);
                    low <= value && value <= high
                };
                let is_of_class = is_allowed
                    && diameter(motor).is_some_and(|d| within(1e3 * d, "diameter"))
                    && motor.mass.is_some_and(|m| within(m, "motor_mass"))
                    && within(design.evaluation.ratio, "ratio");
                (!is_of_class).then_some(what)
            };
            let misses: Vec<Option<String>> = found.clone().map(outside).collect();
            assert!(misses.iter().any(Option::is_none), "{misses:?}");
            let first = best;
            let motor = first.motor;
            let what = format!("{name}: {} {:?} at {}", motor.id, first.gear, first.evaluation.ratio);
            if class.contains_key("spring") {
                let spring = first.spring.expect(&what);
                assert!(
                    spring.stiffness > 0.0 && spring.saving(first.evaluation.loss).is_none_or(|s| s > 0.0),
                    "{what}"
                );
            }
            assert!(heat_is_judged(&robot, &catalog, k, first), "{what}");
            let most = most_heat(motor, &catalog);
            assert!(first.evaluation.copper_loss <= most, "{what}: {} W of {most} W", first.evaluation.copper_loss);
        }
    }
}

#[test]
fn no_first_choice_of_a_shipped_requirement_overheats() {
    let catalog = choice();
    let mut looked = 0;
    for entry in fs::read_dir(repository("requirements")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let robot = requirement::read(&path).unwrap();
        let one = Options { keep: Some(1), reasons: false, ..Options::default() };
        for (k, joint) in optimize_with(&robot, &catalog, one).unwrap().joints.iter().enumerate() {
            let first = joint.candidates.first().unwrap_or_else(|| panic!("{} {}", path.display(), joint.joint.name));
            let what = format!("{} {}: {}", path.display(), joint.joint.name, first.motor.id);
            assert!(heat_is_judged(&robot, &catalog, k, first), "{what}");
            let most = most_heat(first.motor, &catalog);
            assert!(first.evaluation.copper_loss <= most, "{what}: {} W of {most} W", first.evaluation.copper_loss);
            looked += 1;
        }
    }
    assert!(looked >= 15, "{looked}");
}

/// Random joints: whatever is asked, no first choice is one whose heat nobody knows, and a wider reserve never adds a
/// design nor makes one better.
#[test]
fn whatever_is_asked_heat_is_judged_and_a_wider_reserve_adds_nothing() {
    let catalog = choice();
    let mut generator = Pcg64::seed_from_u64(18);
    let mut random = move || (generator.next_u64() >> 11) as f64 * 2.0_f64.powi(-53);
    let (mut found, mut fewer) = (0, 0);
    for round in 0..12 {
        let mut between = |low: f64, high: f64| low * (high / low).powf(random());
        let (torque, speed) = (between(1.0, 60.0), between(1.0, 15.0));
        let text = format!(
            "name = \"x\"\n[bus]\nvoltage = \"48 V\"\ndrive_current = \"60 A\"\n[[joint]]\nname = \"j\"\n\
             ratio = {{ min = 3, max = 100 }}\ngear = {{ efficiency = 0.9, mass = \"200 g\", inertia = \"5e-6 kg*m^2\" }}\n\
             points = [ {{ torque = \"{torque} N*m\", speed = \"{speed} rad/s\", duration = \"0.2 s\" }}, \
             {{ torque = \"{} N*m\", speed = \"0 rad/s\", duration = \"{} s\" }} ]\n",
            0.1 * torque,
            between(0.1, 3.0)
        );
        let source = std::sync::Arc::new(gearwise::input::Source::new("robot.toml", text));
        let mut robot = requirement::read_source(&source).unwrap();
        let mut before: Option<Vec<(String, f64)>> = None;
        for share in [0.0, 0.05, 0.2, 0.5] {
            for limit in requirement::LIMIT_NAMES {
                robot.joints[0].limits.keep_reserve(limit, share);
            }
            let result = optimize(&robot, &catalog);
            for design in &result.joints[0].candidates {
                assert!(heat_is_judged(&robot, &catalog, 0, design), "{round}: {}", design.motor.id);
                let RatioChoice::Continuous { min, max } = robot.joints[0].ratio else { unreachable!() };
                assert!(min <= design.evaluation.ratio && design.evaluation.ratio <= max);
            }
            let now: Vec<(String, f64)> =
                result.joints[0].candidates.iter().map(|d| (d.motor.id.clone(), d.optimum.objective)).collect();
            if let Some(before) = &before {
                for (motor, objective) in &now {
                    let wider = before.iter().find(|b| b.0 == *motor);
                    let (_, was) = wider.unwrap_or_else(|| panic!("{round}: {share} adds {motor}"));
                    assert!(*objective >= was * (1.0 - 1e-9), "{round}: {share} makes {motor} better");
                }
                fewer += before.len() - now.len();
            }
            found += now.len();
            before = Some(now);
        }
    }
    assert!(found > 200 && fewer > 50, "{found} designs, {fewer} ruled out");
}
