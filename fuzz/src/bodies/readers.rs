//! Readers of texts: catalogues, requirements, motions, rules and locks, studies, descriptions of robots.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use gearwise::actuator::metrics::METRICS;
use gearwise::catalog::{Catalog, FIELDS, Gear, Motor, audit};
use gearwise::input::{Change, Source};
use gearwise::mechanism::{Mechanism, torques, trajectory};
use gearwise::requirement::{self, DesignFile};
use gearwise::rules::{self, RulesFile};
use gearwise::study;

use super::parts::Parts;
use super::sane::{self, accepted, accepted_one, finite, not_negative, positive};

fn source(name: &str, text: &str) -> Arc<Source> {
    Arc::new(Source::new(name, text))
}

/// Catalogue files, each under its name (a fitted actuator's ends in `.toml`).
pub fn catalogue(bytes: &[u8]) {
    let Some(parts) = Parts::new(bytes) else { return };
    let mut sources = vec![source("catalog.csv", parts.main)];
    sources.extend(parts.others.iter().map(|(name, text)| source(name, text)));
    // A fitted actuator alone has nothing before its name.
    if parts.main.is_empty() && sources.len() > 1 {
        sources.remove(0);
    }
    let Some(catalog) = accepted(Catalog::from_sources(sources)) else { return };
    catalog.motors.iter().for_each(motor);
    catalog.gears.iter().for_each(gear);
    for finding in audit::audit(&catalog) {
        assert!(!format!("{finding:?}").contains("NaN"), "{finding:?}");
    }
}

fn motor(motor: &Motor) {
    assert!(!motor.id.is_empty());
    positive("motor constant", [motor.resistance, motor.torque_constant, motor.back_emf_constant]);
    positive("reference temperature", [motor.reference_temperature]);
    let bounds = [motor.continuous_current, motor.peak_current, motor.continuous_torque, motor.peak_torque];
    positive("bound", bounds.into_iter().chain([motor.max_speed, motor.max_winding_temperature]).flatten());
    positive("mass and inertia", [motor.mass, motor.rotor_inertia, motor.thermal_resistance].into_iter().flatten());
    not_negative("friction", [motor.coulomb_friction, motor.viscous_friction, motor.inductance].into_iter().flatten());
    for field in FIELDS {
        let printed = (field.get)(&motor.sheet);
        finite(field.name, printed.iter().map(|p| p.value));
        not_negative(field.name, printed.and_then(|p| p.tolerance));
    }
    for metric in METRICS {
        if let Some(estimate) = metric.of(motor) {
            assert!(estimate.value > 0.0, "{} of {} is {}", metric.name, motor.id, estimate.value);
            not_negative(metric.name, estimate.independent);
        }
    }
    assert!(!rules::lock::Row::of_motor(motor).values.is_empty());
}

fn gear(gear: &Gear) {
    assert!(!gear.id.is_empty());
    positive("ratio", [gear.ratio]);
    positive(
        "gear",
        [gear.efficiency, gear.peak_torque, gear.continuous_torque, gear.max_input_speed].into_iter().flatten(),
    );
    not_negative("gear", [gear.mass, gear.inertia, gear.backlash, gear.stiffness].into_iter().flatten());
    assert!(gear.efficiency.is_none_or(|e| e <= 1.0) && gear.backdrive_efficiency.is_none_or(|e| e <= 1.0));
    assert!(!rules::lock::Row::of_gear(gear, &gearwise::catalog::Catalog::default()).values.is_empty());
}

/// A requirement with the files that it names.
pub fn requirement(bytes: &[u8]) {
    let Some(mut parts) = Parts::new(bytes) else { return };
    let source = source("requirement.toml", parts.main);
    if let Some(robot) = accepted(requirement::read_changed(&source, &[], &mut parts)) {
        sane::robot(&robot);
    }
}

/// A motion: periodic with its period in the file or beside it, and once.
pub fn motion(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let source = source("motion.csv", text);
    for (periodic, period) in [(true, None), (true, Some(2.0)), (false, None)] {
        if let Some(motion) = accepted_one(gearwise::motion::read(&source, periodic, period)) {
            sane::motion(&motion);
        }
    }
}

/// A file of the designs of the repository.
fn shipped(file: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().map(|a| a.join("requirements/designs"));
    path.into_iter().find(|p| p.is_dir()).expect("the designs of the repository").join(file)
}

/// What rules are applied to: a design of the built-in motors that keeps its limits.
fn kept() -> &'static (DesignFile, Catalog) {
    static DESIGN: OnceLock<(DesignFile, Catalog)> = OnceLock::new();
    DESIGN.get_or_init(|| {
        let design = DesignFile::read(&shipped("quadruped_mini_cheetah/design.toml")).expect("a design");
        (design, Catalog::builtin().expect("the built-in catalogue"))
    })
}

/// A design that may stand beside a shipped one, and what the rules say of it.
pub fn design(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let place = shipped("quadruped_mini_cheetah/design.toml");
    let Some(design) = accepted(DesignFile::read_source(&source(&place.to_string_lossy(), text))) else { return };
    let catalog = &kept().1;
    let Some(choices) = accepted_one(design.choices(catalog)) else { return };
    assert_eq!(choices.len(), design.robot.joints.len(), "a choice for each joint");
    positive("a ratio", choices.iter().map(|c| c.ratio));
    drop(choices);
    check(&RulesFile::default(), None, &design, catalog);
}

/// A rules file and the lock of a design, applied to it.
pub fn rules(bytes: &[u8]) {
    let Some(parts) = Parts::new(bytes) else { return };
    let lock = parts.text("design.lock").map(|text| source("design.lock", text));
    let (design, catalog) = kept();
    if let Some(lock) = &lock {
        accepted_one(rules::lock::Lock::read(lock, design));
    }
    let Some(file) = accepted_one(rules::file::read_source(&source("rules.toml", parts.main))) else { return };
    check(&file, lock.as_ref(), design, catalog);
}

fn check(file: &RulesFile, lock: Option<&Arc<Source>>, design: &DesignFile, catalog: &Catalog) {
    let report = rules::check(design, catalog, file, lock, Path::new("design.lock"));
    let Some(report) = accepted(report) else { return };
    for finding in &report.findings {
        assert!(!finding.message.is_empty() && !finding.message.contains("NaN"), "{finding:?}");
        finite("a finding", finding.value.into_iter().chain(finding.bound));
        assert!(!finding.identity(report.rule_of(finding)).is_empty());
    }
}

/// A study file, and the requirements that its grid makes of a small one.
pub fn study(bytes: &[u8]) {
    const BASE: &str = "name = 'r'\nbus = { voltage = '24 V' }\nbudget = { actuator_mass = '6 kg' }\n[[joint]]\nname = 'knee'\n\
        ratio = { min = 3, max = 30 }\ngear = { efficiency = 0.9, mass = '150 g' }\n\
        points = [{ torque = '5 N*m', speed = '1 rad/s' }]\nlimits = { safety = 1.2 }\n";
    let Some(mut parts) = Parts::new(bytes) else { return };
    let home = source("study.toml", parts.main);
    study::file::is_study_file(&home);
    let Some(file) = accepted_one(study::file::read(&home)) else { return };
    let points = file.grid.points();
    assert!(points > 0);
    let base = source("base.toml", BASE);
    for point in [0, 1, points / 2, points - 1] {
        let point = point.min(points - 1);
        assert!(file.grid.name(point).len() < 1 << 20);
        let (changes, scale) = file.grid.at(point);
        positive("scale", [scale.torque, scale.speed]);
        let read = requirement::read_changed(&base, &changes, &mut parts);
        if let Some(robot) = accepted(read.map_err(|errors| Change::send_home(errors, std::slice::from_ref(&home)))) {
            sane::robot(&robot);
        }
    }
}

/// A description of a robot, and the torques of a trajectory where there is one.
pub fn mechanism(bytes: &[u8]) {
    let Some(parts) = Parts::new(bytes) else { return };
    let Some(mechanism) = accepted_one(Mechanism::read_source(&source("robot.xml", parts.main))) else { return };
    for (at, body) in mechanism.bodies.iter().enumerate() {
        assert!(body.parent.is_none_or(|parent| parent < at), "parents come before their children");
        not_negative("a mass", [body.inertia.mass]);
        finite("a centre", body.inertia.centre.iter().copied());
        finite("an inertia", body.inertia.about_centre.iter().copied());
        finite(
            "a place",
            body.placement.translation.vector.iter().chain(body.placement.rotation.coords.iter()).copied(),
        );
    }
    for joint in mechanism.joints() {
        let numbers = [joint.damping, joint.friction, joint.stiffness, joint.armature];
        not_negative("a joint", numbers);
        finite("an axis", joint.axis.iter().copied());
        finite("a joint", [joint.reference, joint.spring_reference]);
        assert!(joint.range.is_none_or(|[low, high]| low <= high), "{joint:?}");
    }
    let Some(text) = parts.text("motion.csv") else { return };
    let read = trajectory::read(&source("motion.csv", text), &mechanism, true, None)
        .or_else(|_| trajectory::read(&source("motion.csv", text), &mechanism, false, None));
    let Some(trajectory) = accepted_one(read) else { return };
    let found = torques::torques(&mechanism, &trajectory, true);
    for joint in 0..mechanism.moving().len() {
        sane::motion(&found.motion(&trajectory, joint));
    }
    for carried in torques::torques_per_mass(&mechanism, &trajectory, &torques::actuator_places(&mechanism)) {
        finite("torque per mass", carried.coefficients);
    }
    torques::notes(&mechanism, &trajectory, &found);
}
