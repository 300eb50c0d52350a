//! One fitted actuator: made once, written, read back. Numbers on paper for how it follows from what was fitted.

use std::process::Command;
use std::sync::Arc;

use gearwise::catalog::Catalog;
use gearwise::catalog::fitted::{Fitted, read_actuator};
use gearwise::effects::FittedEffect;
use gearwise::effects::effect;
use gearwise::input::Source;
use gearwise::measured::fitted::{fitted_actuator, fitted_motor};
use gearwise::measured::identify::{Found, Options, Parameter, Report, Target, Verdict, identify};
use gearwise::measured::read::read;
use gearwise::measured::{Bench, Declared};
use gearwise::report::fitted::text;
use gearwise::requirement::GearModel;

use crate::common::real::on_each;
use crate::common::{motor, repository};
use crate::simulator;

fn back(text: &str) -> Fitted {
    read_actuator(&Arc::new(Source::new("fitted.toml", text))).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// Whether a name of the covariance is a number of the file: `effects.cogging.12.cosine` is in the table of order 12.
fn is_there(file: &toml::Table, name: &str) -> bool {
    let number = |table: &toml::Value, key: &str| table.get(key).is_some_and(|v| !v.is_table() && !v.is_array());
    let (place, key) = name.rsplit_once('.').unwrap();
    let mut parts = place.splitn(3, '.');
    let (root, name, order) = (parts.next().unwrap(), parts.next(), parts.next());
    let Some(name) = name else { return file.get(root).is_some_and(|t| number(t, key)) };
    let Some(found) = file.get(root).and_then(|t| t.get(name)) else { return false };
    match order {
        None => number(found, key),
        Some(order) => found.as_array().is_some_and(|list| {
            let is = |t: &&toml::Value| {
                let value = &t["order"];
                value.as_float().or(value.as_integer().map(|i| i as f64)) == order.parse().ok()
            };
            list.iter().filter(is).filter(|t| number(t, key)).count() == 1
        }),
    }
}

/// What holds for every fitted actuator and its file. The text, for more.
fn checked(bench: &Bench, reports: &[Report]) -> String {
    let actuator = fitted_actuator(bench, reports).unwrap();
    let text = text(&actuator, reports);
    // Number by number: the words of a float are its bits.
    assert_eq!(format!("{:?}", back(&text)), format!("{actuator:?}"), "{text}");
    let file: toml::Table = toml::from_str(&text).unwrap();
    let (fit, sheet) = match &actuator {
        Fitted::Motor(motor) => (motor.fit.clone().unwrap(), Some(&motor.sheet)),
        Fitted::Axis(axis) => (axis.fit.clone(), None),
    };
    for name in &fit.names {
        assert!(is_there(&file, name), "{name} is no number of the file\n{text}");
        assert_eq!(fit.names.iter().filter(|n| *n == name).count(), 1, "{name} twice");
    }
    for (a, row) in fit.covariance.iter().enumerate() {
        assert!(row.iter().all(|v| v.is_finite()));
        for (b, value) in row.iter().enumerate() {
            assert!((value - fit.covariance[b][a]).abs() <= 1e-7 * value.abs(), "not symmetric");
            let size = (fit.covariance[a][a] * fit.covariance[b][b]).sqrt();
            assert!(value.abs() <= size * (1.0 + 1e-6), "{} and {}", fit.names[a], fit.names[b]);
        }
        // Each ± is 1.96 square roots of the diagonal.
        let column = gearwise::catalog::FIELDS.iter().find(|f| format!("motor.{}", f.name) == fit.names[a]);
        let printed = column.zip(sheet).and_then(|(f, sheet)| (f.get)(sheet));
        if let Some(tolerance) = printed.and_then(|p| p.tolerance) {
            assert!((tolerance / 1.96 / row[a].sqrt() - 1.0).abs() < 1e-6, "{}", fit.names[a]);
        }
    }
    text
}

fn identified(bench: &Bench) -> String {
    let reports = identify(bench, &Options::default()).unwrap();
    checked(bench, &reports)
}

#[test]
fn the_shipped_bench_is_read_back() {
    // The other one is for `characterize`: it has no row to be fitted.
    identified(&read(&repository("requirements/bench/leg_actuator.toml")).unwrap());
}

/// The benches of real logs, where those are there.
#[test]
fn real_benches_are_read_back() {
    on_each(&["d5065", "emps", "ri50_drag", "ri50_slow", "ri50_stall", "xl330"], |name, path| {
        println!("{name}");
        identified(&read(path).unwrap());
    });
}

/// The suite's simulator, a bench of each kind, with effects with orders, with shapes and with columns of their own.
#[test]
fn simulated_benches_are_read_back() {
    use simulator::{Effect, Kind};
    for (kind, name) in [
        (Kind::Dynamometer, "cogging"),
        (Kind::Dynamometer, "eddy_drag"),
        (Kind::Free, "coulomb_friction"),
        (Kind::Electrical, "inverter_dead_time"),
        (Kind::Linear, "stribeck_friction"),
        (Kind::SteadyTable, "torque_constant_saturation"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let mut bench = simulator::Bench::new(kind, 3).with_noise(Effect::named(name).unwrap(), 5.0);
        if name == "coulomb_friction" {
            bench.declared.coulomb = None;
        }
        let bench = read(&bench.write(folder.path()).bench).unwrap();
        println!("{name}");
        identified(&bench);
    }
}

fn gearwise(arguments: &[&str]) -> serde_json::Value {
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise")).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap_or_default()
}

/// The choice made again in one run, and with the file that was written: of a servo, whose friction is in its damping.
#[test]
fn the_choice_made_again_is_the_same_through_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let truth = simulator::clean(simulator::Kind::Servo, 7).sampled(12.0, 200.0).write(folder.path());
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    // As servos are made: the row says nothing of friction.
    let row = std::fs::read_to_string(path("motors.csv")).unwrap();
    let mut lines = row.lines().map(|l| l.split(',').map(str::to_string).collect::<Vec<_>>());
    let (header, mut cells) = (lines.next().unwrap(), lines.next().unwrap());
    let friction = header.iter().position(|h| h.starts_with("viscous_friction")).unwrap();
    cells[friction] = String::new();
    std::fs::write(path("motors.csv"), format!("{}\n{}\n", header.join(","), cells.join(","))).unwrap();
    let requirement = "name = \"joint\"\n[bus]\nvoltage = \"7.4 V\"\nmodulation = \"space_vector\"\nregeneration = \"allowed\"\n\
        [[joint]]\nname = \"joint\"\nratio = { min = 20, max = 400 }\nobjective = \"loss\"\n\
        points = [\n  { torque = \"0.3 N*m\", speed = \"2 rad/s\" },\n  { torque = \"0.1 N*m\", speed = \"-1 rad/s\" },\n]\n";
    std::fs::write(path("joint.toml"), requirement).unwrap();
    let bench = truth.bench.to_str().unwrap();
    let made =
        gearwise(&["identify", bench, "--requirement", &path("joint.toml"), "--write", &path("fitted.toml"), "--json"]);
    let chosen = &made["design"]["joints"][0]["after"];
    let written = gearwise(&["optimize", &path("joint.toml"), "--catalog", &path("fitted.toml"), "--json"]);
    let through_the_file = &written["joints"][0]["candidates"][0];
    println!("{chosen}\n{through_the_file}");
    assert!(chosen["ratio"].is_f64());
    assert_eq!(chosen["ratio"], through_the_file["ratio"]);
    assert_eq!(chosen["objective"], through_the_file["objective"]);
    // The damping was seen, and is in the row.
    let Fitted::Motor(motor) = back(&std::fs::read_to_string(path("fitted.toml")).unwrap()) else { panic!() };
    assert!(motor.viscous_friction.is_some(), "{motor:?}");
}

// On paper. A motor of K_T = 0.1 N·m/A, R = 2 Ω, J = 1e-5 kg·m²; its row says no back-EMF, so K_B = K_T.

fn bench(cells: &[(&str, &str)], ratio: f64) -> Bench {
    let row = [("resistance [ohm]", "2"), ("torque_constant [N*m/A]", "0.1"), ("rotor_inertia [kg*m^2]", "1e-5")];
    let declared = Declared {
        motor: Some(motor(&[&row[..], cells].concat())),
        ratio,
        gear: GearModel::IDEAL,
        mass: None,
        force_gain: 1.0,
        viscous_friction: None,
        coulomb_friction: None,
        fixture_inertia: 0.0,
        effects: Vec::new(),
        without: Vec::new(),
    };
    let catalog = Catalog::of(declared.motor.clone().into_iter().collect(), Vec::new());
    let readings = gearwise::measured::bench::Readings::default();
    Bench {
        name: "paper".into(),
        path: "bench.toml".into(),
        catalog,
        declared,
        logs: Vec::new(),
        readings,
        files: Vec::new(),
    }
}

/// A report of parameters: name, value, standard error; names and covariance of what was fitted are those unless given.
fn report(target: Target, parameters: &[(&str, f64, f64)]) -> Report {
    let all = parameters.iter().map(|(name, fitted, error)| Parameter {
        name: (*name).into(),
        declared: None,
        fitted: *fitted,
        standard_error: Some(*error),
        undecided: None,
        unit: "1",
    });
    let variance = |k: usize| parameters[k].2.powi(2);
    let row = |a: usize| (0..parameters.len()).map(|b| if a == b { variance(a) } else { 0.0 }).collect();
    Report {
        target,
        unit: "N*m",
        band: None,
        samples: (0, 0),
        evidence: Default::default(),
        verdict: Verdict::Explained,
        stages: Vec::new(),
        findings: Vec::new(),
        artefacts: Vec::new(),
        parameters: all.collect(),
        effects: Vec::new(),
        refused: Vec::new(),
        unexplained: Vec::new(),
        next_runs: Vec::new(),
        remarks: Vec::new(),
        fitted_names: parameters.iter().map(|(name, ..)| (*name).into()).collect(),
        covariance: (0..parameters.len()).map(row).collect(),
        pictures: Default::default(),
    }
}

/// An effect that was found: parameters with their errors, and its instances.
fn found(name: &str, parameters: &[(&str, f64, f64)], instances: Vec<Vec<f64>>) -> Found {
    let effect = effect(name).unwrap();
    Found {
        effect,
        parameters: report(Target::Torque, parameters).parameters,
        instances,
        size: 0.0,
        held_out_before: None,
        held_out_after: None,
        confounded_with: Vec::new(),
    }
}

fn close(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} instead of {expected}");
}

#[test]
fn damping_is_back_emf_and_viscous_friction() {
    // D = 0.0042, K_T = 0.08: b = D − K_T K_B/R = 0.0042 − 0.0064/2 = 0.001, and K_B = K_T.
    let bench = bench(&[], 1.0);
    let mut seen = report(Target::Position, &[("torque_constant", 0.08, 1e-3), ("damping", 0.0042, 1e-4)]);
    (seen.covariance[0][1], seen.covariance[1][0]) = (5e-8, 5e-8);
    let fitted = fitted_motor(&bench, &[seen.clone()]).unwrap();
    close(fitted.viscous_friction.unwrap(), 0.001);
    // What the row makes of a voltage opposes motion as was seen.
    let whole =
        fitted.viscous_friction.unwrap() + fitted.torque_constant * fitted.back_emf_constant / fitted.resistance;
    close(whole, 0.0042);
    // ∂b/∂K_T = −2 K_T/R = −0.08: variance 1e-8 + 0.08² 1e-6 − 2·0.08·5e-8.
    let variance: f64 = 1e-8 + 0.0064 * 1e-6 - 0.16 * 5e-8;
    close(fitted.sheet.viscous_friction.unwrap().tolerance.unwrap(), 1.96 * variance.sqrt());
    let text = checked(&bench, &[seen]);
    assert!(text.contains("motor.viscous_friction") && !text.contains("motor.damping"), "{text}");
    // Friction that the row declares was in the simulation beside the damping.
    let declared = bench_with_friction();
    let seen = report(Target::Position, &[("torque_constant", 0.08, 1e-3), ("damping", 0.0042, 1e-4)]);
    close(fitted_motor(&declared, &[seen]).unwrap().viscous_friction.unwrap(), 0.0015);
    // Less than the back-EMF: within two errors it is zero, else as declared.
    let less = |damping: f64| {
        let seen = report(Target::Position, &[("torque_constant", 0.08, 1e-4), ("damping", damping, 1e-4)]);
        checked(&bench, std::slice::from_ref(&seen));
        fitted_motor(&bench, &[seen]).unwrap()
    };
    assert_eq!(less(0.00315).viscous_friction, Some(0.0));
    assert_eq!(less(0.002).viscous_friction, None);
    assert!(less(0.002).note.contains("less than K_T K_B/R"));
}

fn bench_with_friction() -> Bench {
    bench(&[("viscous_friction [N*m*s/rad]", "5e-4")], 1.0)
}

#[test]
fn of_two_equations_the_surer_is_used_alone_and_the_other_told() {
    let bench = bench(&[], 1.0);
    let mut torque = report(Target::Torque, &[("torque_constant", 0.09, 1e-3), ("inertia", 1.2e-5, 1e-7)]);
    let mut drive = report(Target::Drive, &[("inertia", 1.1e-5, 5e-8)]);
    torque.effects =
        vec![found("stribeck_friction", &[("torque", 0.01, 1e-3), ("speed", 8.0, 0.5)], vec![vec![0.01, 8.0]])];
    drive.effects =
        vec![found("stribeck_friction", &[("torque", 0.02, 1e-3), ("speed", 9.0, 0.5)], vec![vec![0.02, 9.0]])];
    for reports in [[torque.clone(), drive.clone()], [drive, torque]] {
        let fitted = fitted_motor(&bench, &reports).unwrap();
        // In whatever order they come: neither the first nor the last.
        close(fitted.torque_constant, 0.09);
        close(fitted.rotor_inertia.unwrap(), 1.1e-5);
        close(fitted.sheet.rotor_inertia.unwrap().tolerance.unwrap(), 0.98e-7);
        assert_eq!(fitted.effects, [FittedEffect::new("stribeck_friction", vec![0.02, 9.0]).unwrap()]);
        assert!(fitted.note.contains("surer is used for inertia"), "{}", fitted.note);
        assert!(fitted.note.contains("which disagrees"), "{}", fitted.note);
        let text = checked(&bench, &reports);
        assert_eq!(text.matches("[effects.stribeck_friction]").count(), 1, "{text}");
    }
}

/// From duty K_T/R is seen: with a resistance that another equation shows it is another K_T.
#[test]
fn a_quotient_takes_the_resistance_that_was_seen() {
    let bench = bench(&[], 1.0);
    let position = report(Target::Position, &[("torque_constant", 0.08, 8e-4), ("damping", 0.0042, 1e-4)]);
    let voltage = report(Target::Voltage, &[("resistance", 2.5, 0.025)]);
    let reports = [position.clone(), voltage];
    let fitted = fitted_motor(&bench, &reports).unwrap();
    close(fitted.torque_constant, 0.08 * 2.5 / 2.0);
    close(fitted.resistance, 2.5);
    // One per cent each.
    close(fitted.sheet.torque_constant.unwrap().tolerance.unwrap(), 1.96 * 0.1 * 0.01 * 2.0_f64.sqrt());
    checked(&bench, &reports);
    // An equation that sees K_T itself goes before, however unsure.
    let torque = report(Target::Torque, &[("torque_constant", 0.11, 5e-3)]);
    close(fitted_motor(&bench, &[position, torque]).unwrap().torque_constant, 0.11);
}

#[test]
fn a_gear_and_orders_have_their_places() {
    let bench = bench(&[], 7.5);
    let mut seen = report(
        Target::Torque,
        &[
            ("load_dependent_friction.factor", 0.25, 0.01),
            ("cogging.12.cosine", 3e-3, 1e-4),
            ("cogging.12.sine", -4e-3, 1e-4),
        ],
    );
    seen.parameters.truncate(1);
    seen.effects =
        vec![found("cogging", &[("12.cosine", 3e-3, 1e-4), ("12.sine", -4e-3, 1e-4)], vec![vec![3e-3, -4e-3, 12.0]])];
    let fitted = fitted_motor(&bench, std::slice::from_ref(&seen)).unwrap();
    let gear = fitted.fitted_gear.unwrap();
    assert_eq!((gear.ratio, gear.efficiency, gear.backdrive_efficiency), (Some(7.5), Some(0.8), Some(0.75)));
    let fit = fitted.fit.unwrap();
    assert_eq!(
        fit.names,
        ["gear.efficiency", "gear.backdrive_efficiency", "effects.cogging.12.cosine", "effects.cogging.12.sine"]
    );
    // ∂η/∂γ = −1/1.25² = −0.64, ∂η_b/∂γ = −1.
    close(fit.covariance[0][0], 0.4096e-4);
    close(fit.covariance[0][1], 0.64e-4);
    let expected = [
        ("gear.efficiency", 0.012544),
        ("gear.backdrive_efficiency", 0.0196),
        ("cogging.12.cosine", 1.96e-4),
        ("cogging.12.sine", 1.96e-4),
    ];
    assert_eq!(fit.tolerances, expected.map(|(name, tolerance)| (name.to_string(), tolerance)));
    let text = checked(&bench, &[seen]);
    assert!(text.contains("efficiency = 0.8\nefficiency_tolerance = 0.012544\n"), "{text}");
}

/// The ± of a gear in a file without a covariance.
#[test]
fn the_tolerance_of_a_gear_is_read_without_a_covariance() {
    let bench = bench(&[], 7.5);
    let seen = report(Target::Torque, &[("load_dependent_friction.factor", 0.25, 0.01)]);
    let text = text(&fitted_actuator(&bench, std::slice::from_ref(&seen)).unwrap(), &[seen]);
    let (table, _) = text.split_once("[covariance]").unwrap();
    let table = table.replace("_tolerance = 0.012544", "_tolerance = 0.04");
    let Fitted::Motor(read) = back(&table) else { panic!("{table}") };
    let fit = read.fit.unwrap();
    assert!(fit.names.is_empty());
    close(fit.tolerance("gear.efficiency").unwrap(), 0.04);
    close(fit.tolerance("gear.backdrive_efficiency").unwrap(), 0.0196);
}

/// A number that a file cannot hold stays as declared: the file can be read.
#[test]
fn a_sign_that_cannot_be_stays_out() {
    let mut bench = bench(&[("coulomb_friction [N*m]", "0.02")], 1.0);
    bench.declared.effects = vec![FittedEffect::new("eddy_drag", vec![0.01, 100.0]).unwrap()];
    let seen = report(
        Target::Torque,
        &[("torque_constant", -0.1, 1e-3), ("coulomb_friction.torque", -0.01, 1e-3), ("eddy_drag.torque", -0.5, 0.1)],
    );
    let fitted = fitted_motor(&bench, std::slice::from_ref(&seen)).unwrap();
    assert_eq!((fitted.torque_constant, fitted.coulomb_friction), (0.1, Some(0.02)));
    assert_eq!(fitted.effects, [FittedEffect::new("eddy_drag", vec![0.01, 100.0]).unwrap()]);
    checked(&bench, &[seen]);
}

/// A linear axis has a file too: it is read back, and refused as a motor in words.
#[test]
fn a_linear_axis_is_no_motor() {
    let mut bench = bench(&[], 1.0);
    bench.declared.motor = None;
    bench.declared.mass = Some(95.0);
    let mut seen = report(Target::Drive, &[("mass", 95.2, 0.1)]);
    seen.effects = vec![
        found("viscous_friction", &[("coefficient", 200.0, 2.0)], vec![vec![200.0]]),
        found("torque_offset", &[("torque", -3.2, 0.1)], vec![vec![-3.2]]),
    ];
    assert!(fitted_motor(&bench, std::slice::from_ref(&seen)).is_none());
    let text = checked(&bench, std::slice::from_ref(&seen));
    let Fitted::Axis(axis) = back(&text) else { panic!("{text}") };
    assert_eq!((axis.mass.unwrap().value, axis.viscous_friction.unwrap().value), (95.2, 200.0));
    assert_eq!(axis.effects, [FittedEffect::new("torque_offset", vec![-3.2]).unwrap()]);
    assert!(text.contains("torque = \"-3.2 N\""), "{text}");
    let error = Catalog::from_sources(vec![Arc::new(Source::new("fitted.toml", text.as_str()))]).unwrap_err();
    assert!(error[0].to_string().contains("a linear axis cannot be chosen"), "{}", error[0]);
}
