//! Identification against a simulator that shares no code with it: which undeclared effect is named, and
//! how often a name is given where none should be.

use std::collections::BTreeMap;
use std::path::Path;

use gearwise::measured::identify::{ArtefactKind, Options, Report, Verdict, identify};

use crate::cases::few;
use crate::common::real::on_each;
use crate::simulator::{self, Bench, Kind, Truth, world::Effect};

/// Runs a simulated bench.
fn run(bench: &Bench) -> (Truth, Vec<Report>) {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = bench.write(folder.path());
    let read = gearwise::measured::read::read(&truth.bench).unwrap_or_else(|e| panic!("{e:?}"));
    let reports = identify(&read, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    (truth, reports)
}

fn names(reports: &[Report]) -> Vec<&'static str> {
    reports.iter().flat_map(|r| r.effects.iter().map(|e| e.name())).collect()
}

/// What became of one case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Right,
    LookAlike,
    Extra,
    Nothing,
    Unexplained,
    Wrong,
}

fn outcome(truth: &Truth, reports: &[Report]) -> Outcome {
    let given = names(reports);
    let wanted = truth.names();
    if given.is_empty() {
        return match reports.iter().any(|r| r.verdict == Verdict::UnexplainedStructure) {
            true => Outcome::Unexplained,
            false => Outcome::Nothing,
        };
    }
    let alike: Vec<&str> =
        reports.iter().flat_map(|r| &r.effects).flat_map(|e| e.confounded_with.iter().map(|e| e.name())).collect();
    let all = wanted.iter().all(|w| given.contains(w));
    match (all, given.len() > wanted.len()) {
        (true, false) => Outcome::Right,
        (true, true) => Outcome::Extra,
        _ if wanted.iter().all(|w| given.contains(w) || alike.contains(w)) => Outcome::LookAlike,
        _ => Outcome::Wrong,
    }
}

fn seeds() -> std::ops::Range<u64> {
    let count = std::env::var("GEARWISE_SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(3);
    let first = std::env::var("GEARWISE_FIRST_SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1000);
    first..first + count
}

fn only() -> Option<String> {
    std::env::var("GEARWISE_ONLY").ok()
}

/// Relative errors of the parameters that the simulator and the library have in common.
fn parameter_errors(truth: &Truth, reports: &[Report]) -> Vec<f64> {
    let mut errors = Vec::new();
    for effect in &truth.effects {
        let Some(found) = reports.iter().flat_map(|r| &r.effects).find(|e| e.name() == effect.name) else { continue };
        let values = &found.instances[0];
        let direct = match effect.name {
            "viscous_friction" | "coulomb_friction" | "load_dependent_friction" | "torque_offset" | "supply_sag" => 1,
            "stribeck_friction" | "eddy_drag" | "inverter_dead_time" => 2,
            _ => 0,
        };
        errors.extend((0..direct).map(|k| (values[k] / effect.parameters[k].1 - 1.0).abs()));
    }
    errors
}

/// The confusion table. Slow: run with `--release -- --ignored --nocapture confusion`.
#[test]
#[ignore = "slow: the score, not a check"]
fn confusion() {
    for size in [5.0, 1.5] {
        println!("size {size} x noise");
        let mut totals: BTreeMap<Outcome, usize> = BTreeMap::new();
        let (mut at_floor, mut cases, mut errors) = (0, 0, Vec::new());
        for effect in Effect::LIBRARY {
            if only().is_some_and(|o| !effect.name().contains(&o)) {
                continue;
            }
            let mut counts: BTreeMap<Outcome, usize> = BTreeMap::new();
            let mut details = Vec::new();
            for seed in seeds() {
                let (truth, reports) = run(&simulator::scenario(effect.name(), size, seed));
                let what = outcome(&truth, &reports);
                errors.extend(parameter_errors(&truth, &reports));
                for report in reports.iter().filter(|r| r.effects.iter().any(|e| e.name() == effect.name())) {
                    cases += 1;
                    let held = report.stages.last().and_then(|s| s.held_out).unwrap_or(f64::INFINITY);
                    at_floor += usize::from(report.evidence.noise.floor().is_some_and(|f| held <= 1.15 * f));
                }
                *counts.entry(what).or_default() += 1;
                *totals.entry(what).or_default() += 1;
                if what != Outcome::Right || only().is_some() {
                    details.push(detail(&truth, &reports));
                }
            }
            println!("{:28} {counts:?}", effect.name());
            for d in details {
                println!("      {d}");
            }
        }
        let near = errors.iter().filter(|e| **e < 0.1).count();
        println!(
            "total {totals:?}; held out within 1.15 x the floor in {at_floor} of {cases}; {near} of {} parameters within 10 %",
            errors.len()
        );
    }
}

fn detail(truth: &Truth, reports: &[Report]) -> String {
    let mut text = format!("seed {} noise {:.3e}: ", truth.seed, truth.noise_rms);
    for r in reports {
        let last = r.stages.last().unwrap();
        text += &format!(
            "[{} {:?} band {:.0} rows {} floor {:.3e} final {:.3e}/{:.3e} refit {:.3e}",
            r.target.name(),
            r.verdict,
            r.band.unwrap_or(0.0),
            r.samples.1,
            r.evidence.noise.floor().unwrap_or(f64::NAN),
            last.fit,
            last.held_out.unwrap_or(f64::NAN),
            r.stages[2].fit
        );
        for e in &r.effects {
            text += &format!(" +{} {:?} ~{:?}", e.name(), e.instances, e.confounded_with);
        }
        for a in r.artefacts.iter().filter(|a| a.kind != ArtefactKind::Zero) {
            text += &format!(" !{} {} {:.3e}", a.kind.name(), a.channel, a.value);
        }
        for u in &r.unexplained {
            text += &format!(" ?{}: {}", u.depends_on.name(), u.detail);
        }
        let wanted = truth.names();
        for refused in r.refused.iter().filter(|r| wanted.iter().any(|w| *w == r.name)) {
            text += &format!(" -{}: {}", refused.name, refused.reason);
        }
        text += "] ";
    }
    for e in &truth.effects {
        text += &format!("TRUE {:?} rms {:.3e} ", e.parameters, e.rms);
    }
    text
}

/// Two effects at once. Slow, as [`confusion`].
#[test]
#[ignore = "slow: the score, not a check"]
fn pairs() {
    let mut totals: BTreeMap<Outcome, usize> = BTreeMap::new();
    for (a, b) in [
        ("coulomb_friction", "viscous_friction"),
        ("coulomb_friction", "cogging"),
        ("viscous_friction", "torque_constant_saturation"),
        ("coulomb_friction", "torque_constant_temperature"),
        ("load_dependent_friction", "cogging"),
        ("stribeck_friction", "torque_ripple"),
        ("eddy_drag", "gear_ripple"),
        ("direction_asymmetry", "cogging"),
        ("gravity", "coulomb_friction"),
        ("torque_offset", "viscous_friction"),
        ("winding_temperature", "inverter_dead_time"),
    ] {
        let mut counts: BTreeMap<Outcome, usize> = BTreeMap::new();
        let mut details = Vec::new();
        for seed in seeds() {
            let (truth, reports) = run(&simulator::pair(a, b, 5.0, seed));
            let what = outcome(&truth, &reports);
            *counts.entry(what).or_default() += 1;
            *totals.entry(what).or_default() += 1;
            if what != Outcome::Right {
                details.push(detail(&truth, &reports));
            }
        }
        println!("{a} + {b}: {counts:?}");
        for d in details {
            println!("      {d}");
        }
    }
    println!("total {totals:?}");
}

/// Clean logs and logs with something that is not in the library. Slow, as [`confusion`].
#[test]
#[ignore = "slow: the score, not a check"]
fn nulls() {
    for kind in [Kind::Dynamometer, Kind::Free, Kind::Electrical, Kind::SteadyTable, Kind::Servo, Kind::Linear] {
        let mut false_names = 0;
        for seed in seeds() {
            let (truth, reports) = run(&simulator::clean(kind, seed));
            if !names(&reports).is_empty() {
                false_names += 1;
                println!("      {}", detail(&truth, &reports));
            }
        }
        println!("clean {kind:?}: {false_names} of {} named something", seeds().count());
    }
    for effect in Effect::OUTSIDE {
        let (mut named, mut unexplained) = (0, 0);
        for seed in seeds() {
            let (truth, reports) = run(&simulator::outside(effect.name(), seed));
            unexplained += usize::from(reports.iter().any(|r| r.verdict == Verdict::UnexplainedStructure));
            if !names(&reports).is_empty() {
                named += 1;
                println!("      {}", detail(&truth, &reports));
            }
        }
        println!("outside {}: {named} named, {unexplained} unexplained of {}", effect.name(), seeds().count());
    }
}

/// The story of a report, for reading.
pub(super) fn story(report: &Report) -> String {
    let mut text = format!(
        "{} [{}] {:?} band {:?} samples {:?} floor {:.4e}\n",
        report.target.name(),
        report.unit,
        report.verdict,
        report.band,
        report.samples,
        report.evidence.noise.floor().unwrap_or(f64::NAN)
    );
    for s in &report.stages {
        text += &format!(
            "   {:34} fit {:.4e} ({:.2} %) held {:.4e} ({:.2} %)\n",
            s.step.name(),
            s.fit,
            s.fit_vaf,
            s.held_out.unwrap_or(f64::NAN),
            s.held_out_vaf.unwrap_or(f64::NAN)
        );
    }
    for a in &report.artefacts {
        text += &format!("   artefact {} {} {:.4e} {}\n", a.kind.name(), a.channel, a.value, a.unit);
    }
    for p in &report.parameters {
        text += &format!("   parameter {} {:?} -> {:.5e} ± {:?}\n", p.name, p.declared, p.fitted, p.standard_error);
    }
    for e in &report.effects {
        text += &format!("   effect {} ~{:?} size {:.3e}", e.name(), e.confounded_with, e.size);
        for p in &e.parameters {
            text += &format!(" {}={:.4e}±{:.1e}", p.name, p.fitted, p.standard_error.unwrap_or(f64::NAN));
        }
        text += "\n";
    }
    for r in &report.refused {
        text += &format!("   refused {}: {}\n", r.name, r.reason);
    }
    for u in &report.unexplained {
        text += &format!("   left: {}: {}\n", u.depends_on.name(), u.detail);
    }
    for r in report.remarks.iter().take(5).chain(&report.next_runs) {
        text += &format!("   note: {r}\n");
    }
    text
}

/// The real sets, where they are at hand: their stories. Run with `-- --ignored --nocapture real`.
#[test]
#[ignore = "for reading"]
fn real_sets() {
    let all = ["emps", "ri50_drag", "ri50_slow", "ri50_stall", "d5065", "xl330"];
    let wanted: Vec<&str> = all.into_iter().filter(|n| only().is_none_or(|o| n.contains(&o))).collect();
    on_each(&wanted, |name, path| {
        let start = std::time::Instant::now();
        match gearwise::measured::read::read(path) {
            Err(errors) => println!("{name}: {}", errors.len()),
            Ok(bench) => {
                println!("=== {name}");
                let band = std::env::var("GEARWISE_BAND").ok().and_then(|b| b.parse().ok());
                match identify(&bench, &Options { band }) {
                    Ok(reports) => reports.iter().for_each(|r| println!("{}", story(r))),
                    Err(why) => println!("{why}"),
                }
            }
        }
        println!("    {:.1} s", start.elapsed().as_secs_f64());
    });
}

/// A shorter bench, for tests that run every time.
fn short(bench: Bench) -> Bench {
    bench.sampled(15.0, 400.0)
}

#[test]
fn undeclared_effects_are_named_and_measured() {
    let names = ["load_dependent_friction", "cogging", "coulomb_friction", "winding_temperature", "torque_offset"];
    for name in few(2, names) {
        let (truth, reports) = run(&short(simulator::scenario(name, 5.0, 77)));
        assert_eq!(outcome(&truth, &reports), Outcome::Right, "{}", detail(&truth, &reports));
        let report = reports.iter().find(|r| r.effects.iter().any(|e| e.name() == name)).expect("it was found");
        let (first, last) = (report.stages.first().unwrap(), report.stages.last().unwrap());
        let (before, after) = (first.held_out.unwrap(), last.held_out.unwrap());
        assert!(after < 0.7 * before, "{name}: {before} {after}");
        // Held out, the error is that of the fit where each block is left out in turn.
        assert!(after < 1.15 * report.evidence.left, "{name}: {after} {}", report.evidence.left);
        let found = &report.effects[0].instances[0];
        let of_truth = |key: &str| truth.effects[0].parameters.iter().find(|(n, _)| *n == key).map(|(_, v)| *v);
        let wanted = match name {
            "coulomb_friction" => of_truth("c"),
            "torque_offset" => of_truth("offset").or(of_truth("torque")),
            "load_dependent_friction" => of_truth("gamma"),
            _ => None,
        };
        if let Some(wanted) = wanted {
            assert!((found[0] / wanted - 1.0).abs() < 0.1, "{name}: {} against {wanted}", found[0]);
        }
    }
}

#[test]
fn no_effect_is_named_where_none_is_missing_or_none_of_the_library_is() {
    let benches = [
        simulator::clean(Kind::Free, 79),
        simulator::outside("hum", 82),
        simulator::clean(Kind::Dynamometer, 78),
        simulator::clean(Kind::Electrical, 80),
        simulator::outside("zero_step", 81),
        simulator::shuffled("coulomb_friction", 5.0, 83),
    ];
    for bench in few(2, benches) {
        let (truth, reports) = run(&short(bench));
        assert!(names(&reports).is_empty(), "{}", detail(&truth, &reports));
    }
}

#[test]
fn the_same_logs_say_the_same_with_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = simulator::scenario("cogging", 5.0, 84).sampled(6.0, 400.0).write(folder.path());
    let bench = gearwise::measured::read::read(&truth.bench).unwrap();
    let told = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| identify(&bench, &Options::default()).unwrap().iter().map(story).collect::<String>())
    };
    assert_eq!(told(1), told(4));
}

/// A bench of a real set; `None`, said so, where the set is not at hand.
fn real(name: &str) -> Option<Report> {
    let report = |_: &str, path: &Path| {
        let bench = gearwise::measured::read::read(path).unwrap();
        identify(&bench, &Options::default()).unwrap().remove(0)
    };
    on_each(&[name], report).pop()
}

fn parameter(report: &Report, effect: &str, name: &str) -> f64 {
    let found = report.effects.iter().find(|e| e.name() == effect).unwrap_or_else(|| panic!("no {effect}"));
    found.parameters.iter().find(|p| p.name == name).unwrap_or_else(|| panic!("no {name}")).fitted
}

/// Janot, Gautier, Brunot 2019: M 95.1089 kg, Fv 203.5, Fc 20.39.
#[test]
fn emps_has_the_friction_that_its_authors_found() {
    let Some(report) = real("emps") else { return };
    let names: Vec<&str> = report.effects.iter().map(|e| e.name()).collect();
    // The published offset of −3.16 N is that of a symmetric model: next to the asymmetry it is not beyond its own error.
    assert_eq!(names, ["viscous_friction", "coulomb_friction", "direction_asymmetry"]);
    assert!(report.refused.iter().any(|r| r.name == "torque_offset"));
    let within = |value: f64, published: f64, share: f64| assert!((value / published - 1.0).abs() < share, "{value}");
    within(report.parameters[0].fitted, 95.1089, 0.005);
    within(parameter(&report, "viscous_friction", "coefficient"), 203.5, 0.03);
    within(parameter(&report, "coulomb_friction", "torque"), 20.39, 0.03);
    assert!(report.stages.last().unwrap().held_out.unwrap() < 2.0);
    assert!(report.refused.iter().any(|r| r.name == "stribeck_friction"));
}

/// The drag of the idle RI50 flattens: its README has T 0.0531 N*m and a knee at 115.6 rad/s.
#[test]
fn the_drag_of_the_ri50_is_that_of_eddy_currents() {
    let Some(report) = real("ri50_drag") else { return };
    assert!((parameter(&report, "eddy_drag", "torque") / 0.0531 - 1.0).abs() < 0.05);
    assert!((parameter(&report, "eddy_drag", "speed") / 115.6 - 1.0).abs() < 0.05);
    assert!(report.effects.iter().all(|e| ["eddy_drag", "cogging"].contains(&e.name())));
}

#[test]
fn slow_turns_of_the_ri50_show_the_cogging_of_its_twelve_slots() {
    let Some(report) = real("ri50_slow") else { return };
    assert!(parameter(&report, "cogging", "12.cosine").hypot(parameter(&report, "cogging", "12.sine")) > 0.005);
    assert!(report.refused.iter().any(|r| r.name == "torque_offset" && r.reason.contains("zero")));
}

/// One log has the wrong sign, one a gain of 0.69 that its authors mended the same day.
#[test]
fn stall_logs_of_the_ri50_show_the_wrong_sign_and_the_wrong_gain() {
    let Some(report) = real("ri50_stall") else { return };
    let of = |kind: &str| report.artefacts.iter().filter(|a| a.kind.name() == kind).collect::<Vec<_>>();
    assert!(matches!(of("sign")[..], [a] if a.channel.contains("stall_11b")));
    assert!(matches!(of("gain")[..], [a] if a.channel.contains("badgain") && (a.value - 0.69).abs() < 0.03));
    assert!(report.effects.is_empty());
    // 0.1064 N*m per ampere of phase amplitude.
    let slope = report.parameters[0].fitted / (2.0_f64 / 3.0).sqrt();
    assert!((0.097..0.109).contains(&slope), "{slope}");
}

#[test]
fn the_d5065_saturates_and_its_temperature_term_is_refused() {
    let Some(report) = real("d5065") else { return };
    assert_eq!(report.effects.iter().map(|e| e.name()).collect::<Vec<_>>(), ["torque_constant_saturation"]);
    assert!(report.refused.iter().any(|r| r.name == "torque_constant_temperature"));
    assert!(report.stages.last().unwrap().held_out.unwrap() < 0.016);
}

/// The motor as it really is: the declared row with the effect that was put in.
fn true_motor(declared: &gearwise::catalog::Motor, truth: &Truth) -> gearwise::catalog::Motor {
    use gearwise::effects::FittedEffect;
    let mut motor = declared.clone();
    for effect in &truth.effects {
        let value = |n: usize| effect.parameters[n].1;
        match effect.name {
            "viscous_friction" => motor.viscous_friction = Some(value(0)),
            "coulomb_friction" => motor.coulomb_friction = Some(value(0)),
            "load_dependent_friction" => {
                motor.effects.extend(FittedEffect::new("load_dependent_friction", vec![value(0)]));
            }
            "eddy_drag" => motor.effects.extend(FittedEffect::new("eddy_drag", vec![value(0), value(1)])),
            "stribeck_friction" => {
                motor.effects.extend(FittedEffect::new("stribeck_friction", vec![value(0), value(1)]))
            }
            other => panic!("{other} has no true motor"),
        }
    }
    motor
}

/// The loop closed: the choice made with what was identified against the choice under the truth. Slow, as
/// [`confusion`].
#[test]
#[ignore = "slow: the score, not a check"]
fn the_choice_made_again_is_that_under_the_truth() {
    use gearwise::design::remake::remake;
    let mut robot = gearwise::requirement::read("requirements/bench/leg_joint.toml".as_ref()).unwrap();
    robot.joints[0].limits.actuator_mass = None;
    robot.joints[0].limits.reflected_inertia = None;
    let (mut same, mut cases, mut changed) = (0, 0, 0);
    let (mut before, mut after) = (Vec::new(), Vec::new());
    for name in ["viscous_friction", "coulomb_friction", "load_dependent_friction", "eddy_drag", "stribeck_friction"] {
        for seed in seeds() {
            let folder = tempfile::tempdir().expect("a folder");
            let truth = simulator::scenario(name, 5.0, seed).write(folder.path());
            let bench = gearwise::measured::read::read(&truth.bench).unwrap();
            let reports = identify(&bench, &Options::default()).unwrap();
            let fitted = gearwise::measured::fitted::fitted_motor(&bench, &reports).unwrap();
            let declared = bench.declared.motor.clone().unwrap();
            // Only this motor and a heavier rival: the choice is N*, and between the two.
            let mut catalog = bench.catalog.clone();
            let mut rival = declared.clone();
            rival.id = "rival".into();
            rival.resistance *= 1.3;
            catalog.motors.push(rival);
            let real = true_motor(&declared, &truth);
            let by_fit = remake(&robot, &catalog, &declared.id, &fitted);
            let by_truth = remake(&robot, &catalog, &declared.id, &real);
            let (Some(a), Some(b)) = (&by_fit[0].first_after, &by_truth[0].first_after) else { continue };
            cases += 1;
            // The fitted motor has another id than its row.
            let own = |id: &str| id != "rival";
            let agree = own(&a.motor) == own(&b.motor) && (a.ratio / b.ratio - 1.0).abs() < 0.02;
            same += usize::from(agree);
            if let Some(first) = &by_truth[0].first_before {
                changed +=
                    usize::from(own(&first.motor) != own(&b.motor) || (first.ratio / b.ratio - 1.0).abs() > 0.02);
            }
            if !agree {
                println!("{name} {seed}: {} {} against {} {}", a.motor, a.ratio, b.motor, b.ratio);
            }
            before.extend(by_truth[0].regret.as_ref().and_then(|r| r.relative));
            // What the choice by the fit costs under the truth: the same motor at the other ratio.
            after.push((a.objective / b.objective - 1.0).abs());
        }
    }
    let mean = |v: &[f64]| 100.0 * v.iter().sum::<f64>() / v.len().max(1) as f64;
    println!("{same} of {cases} choices the same as under the truth; the truth changes {changed} of them");
    println!(
        "regret of the choice before: {:.2} % on average; objective by the fit within {:.3} %",
        mean(&before),
        mean(&after)
    );
}

/// Writes a large bench for timing: `GEARWISE_OUT` says where, `GEARWISE_RATE` how many samples a second of
/// three logs of 30 s.
#[test]
#[ignore = "writes files for timing"]
fn large_bench() {
    let folder = std::env::var("GEARWISE_OUT").expect("GEARWISE_OUT");
    let rate = std::env::var("GEARWISE_RATE").ok().and_then(|r| r.parse().ok()).unwrap_or(1000.0);
    simulator::scenario("cogging", 5.0, 1).sampled(30.0, rate).write(Path::new(&folder));
}

#[test]
fn the_simulator_writes_benches_that_can_be_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = simulator::clean(Kind::Dynamometer, 1).write(folder.path());
    let bench = gearwise::measured::read::read(Path::new(&truth.bench)).unwrap();
    assert_eq!(bench.logs.len(), truth.logs.len());
}

/// Iron that saturates and a magnet that warms hide each other: neither earns its name alone.
#[test]
fn two_effects_that_hide_each_other_are_found_together() {
    for seed in [31, 32, 33] {
        let bench = Bench::new(Kind::Stall, seed)
            .sampled(20.0, 100.0)
            .with_noise(Effect::TorqueConstantSaturation, 3.0)
            .with_noise(Effect::TorqueConstantTemperature, 3.0);
        let (_, reports) = run(&bench);
        let mut found = names(&reports);
        found.sort_unstable();
        assert_eq!(found, ["torque_constant_saturation", "torque_constant_temperature"], "{seed}");
    }
}

/// What is excluded has no part in a simulated position either: the sensor was touched for a second.
#[test]
fn what_is_excluded_does_not_judge_a_simulated_position() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = Bench::servo(7).sampled(12.0, 200.0).write(folder.path());
    let log = folder.path().join("log1.csv");
    let text = std::fs::read_to_string(&log).expect("it was written");
    let touched: Vec<String> = text
        .lines()
        .map(|line| {
            let mut cells: Vec<String> = line.split(',').map(str::to_string).collect();
            if let (Ok(t), Ok(q)) = (cells[0].parse::<f64>(), cells[1].parse::<f64>())
                && (3.0..4.0).contains(&t)
            {
                cells[1] = format!("{:.6}", q + 0.5);
            }
            cells.join(",")
        })
        .collect();
    let error = |exclude: &str| {
        let bench = std::fs::read_to_string(&truth.bench).expect("it was written");
        let with = bench.replacen("file = \"log1.csv\"\n", &format!("file = \"log1.csv\"\n{exclude}"), 1);
        let path = folder.path().join("other.toml");
        std::fs::write(&path, with).expect("it can be written");
        let read = gearwise::measured::read::read(&path).unwrap_or_else(|e| panic!("{e:?}"));
        identify(&read, &Options::default()).expect("it is identified")[0].stages.last().expect("a stage").fit
    };
    let untouched = error("");
    std::fs::write(&log, touched.join("\n") + "\n").expect("it can be written");
    assert!(error("") > 5.0 * untouched);
    assert!(error("exclude = [{ from = \"2.9 s\", to = \"4.1 s\" }]\n") < 1.2 * untouched);
}
