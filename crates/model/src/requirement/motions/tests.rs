//! Motions that are scaled, and motions that a program hands over finished.

use std::path::Path;
use std::sync::Arc;

use super::{FromDisk, Motions};
use crate::input::{Change, InputError, Source};
use crate::motion::{CarriedColumn, Course, Motion, Samples};
use crate::requirement::{Joint, Robot, read_changed};

/// A requirement with one joint, or two; `lines` are more of the first.
fn robot(lines: &str, more: &str) -> Arc<Source> {
    let text = format!(
        "name = \"leg\"\nbus = {{ voltage = \"24 V\" }}\n[[joint]]\nname = \"knee\"\nratio = {{ min = 3, max = 30 }}\n\
         motion = \"knee.csv\"\n{lines}\n{more}"
    );
    Arc::new(Source::new("robot.toml", text))
}

const MOTION: &str =
    "time [s],torque [N*m],velocity [rad/s]\n0,1,0.5\n0.1,2,1.5\n0.2,1.5,0.2\n0.3,-0.5,-1\n0.4,1,0.5\n";

/// The motion as a file, without a disk.
struct Beside(&'static str);

impl Motions for Beside {
    fn open(&mut self, path: &Path) -> Result<Arc<Source>, InputError> {
        Ok(Arc::new(Source::new(path.display().to_string(), self.0)))
    }
}

/// The motion handed over.
struct Given(Arc<Motion>, Vec<CarriedColumn>);

impl Motions for Given {
    fn given(&mut self, name: &str) -> Option<(Arc<Motion>, Vec<CarriedColumn>)> {
        assert_eq!(name, "knee.csv");
        Some((self.0.clone(), self.1.clone()))
    }
}

fn read(source: &Arc<Source>, changes: &[Change], motions: &mut dyn Motions) -> Result<Robot, Vec<String>> {
    read_changed(source, changes, motions)
        .map_err(|errors| errors.into_iter().flat_map(|e| e.problems).map(|p| p.message).collect())
}

fn knee(lines: &str) -> Joint {
    read(&robot(lines, ""), &[], &mut Beside(MOTION)).unwrap().joints.remove(0)
}

fn said(lines: &str) -> Vec<String> {
    read(&robot(lines, ""), &[], &mut Beside(MOTION)).unwrap_err()
}

#[test]
fn a_scale_is_the_scaled_motion() {
    let plain = knee("").motion;
    for (text, torque, speed) in [
        ("{ torque = 2, speed = 1.5 }", 2.0, 1.5),
        ("{ torque = 0.5 }", 0.5, 1.0),
        ("{ speed = 3 }", 1.0, 3.0),
        ("{}", 1.0, 1.0),
    ] {
        let scaled = knee(&format!("scale = {text}")).motion;
        assert_eq!(*scaled, Motion::clone(&plain).scaled(torque, speed), "{text}");
    }
    assert_eq!(knee("scale = {}").motion, plain);
    // What the shaft does at each moment: power goes with torque times speed, the work of a cycle with torque alone.
    let scaled = knee("scale = { torque = 2, speed = 1.5 }").motion;
    let power = |m: &Motion, k: usize| m.torque[k] * m.velocity[k];
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} {b}");
    for k in 0..plain.len() {
        near(power(&scaled, k), 3.0 * power(&plain, k));
    }
    near(scaled.duration().unwrap(), plain.duration().unwrap() / 1.5);
}

#[test]
fn a_scale_of_a_scale_is_their_product() {
    let twice = Motion::clone(&knee("scale = { torque = 2, speed = 2 }").motion).scaled(0.25, 0.5);
    let once = knee("scale = { torque = 0.5 }").motion;
    // Powers of two lose no digit.
    assert_eq!(twice, *once);
}

#[test]
fn a_grid_changes_the_scale_by_its_key() {
    let source = robot("", "");
    let change = |key: &str, text: &str| Change::new(key, 0..0, text, 0..text.len());
    let changes = [change("joint.knee.scale.torque", "2"), change("joint.*.scale.speed", "1.5")];
    let changed = read(&source, &changes, &mut Beside(MOTION)).unwrap();
    assert_eq!(changed.joints[0].motion, knee("scale = { torque = 2, speed = 1.5 }").motion);
    let wrong = read(&source, &[change("joint.hip.scale.torque", "2")], &mut Beside(MOTION)).unwrap_err();
    assert_eq!(wrong, ["the key `joint.hip.scale.torque` names no `joint` of the requirement"]);
}

#[test]
fn what_is_carried_weighs_the_same_and_runs_faster() {
    const CARRYING: &str = "time [s],torque [N*m],velocity [rad/s],torque_per_mass_foot [N*m/kg]\n0,1,0.5,1\n0.1,2,1.5,2\n\
                            0.2,1.5,0.2,1\n0.3,-0.5,-1,0.5\n0.4,1,0.5,1\n";
    let foot = "[[joint]]\nname = \"foot\"\nratio = { min = 3, max = 30 }\npoints = [{ torque = \"1 N*m\", speed = \"1 rad/s\" }]\n";
    let of =
        |lines: &str| read(&robot(lines, foot), &[], &mut Beside(CARRYING)).unwrap().joints.remove(0).carries.remove(0);
    let (plain, fast) = (of(""), of("scale = { torque = 5, speed = 2 }"));
    assert_eq!(plain.torque_per_mass, fast.torque_per_mass);
    assert_eq!(plain.rate.iter().map(|r| 2.0 * r).collect::<Vec<_>>(), fast.rate);
}

#[test]
fn a_scale_that_cannot_be() {
    assert_eq!(said("scale = { torque = 0 }"), ["`torque` of [scale] is out of range"]);
    assert_eq!(said("scale = { speed = 1e7 }"), ["`speed` of [scale] is out of range"]);
    assert_eq!(said("scale = { speed = \"2\" }"), ["`speed` of [scale] is a string"]);
    assert_eq!(said("scale = { sped = 2 }"), ["unknown key `sped` in [scale]"]);
    assert_eq!(said("scale = 2"), ["`scale` of [[joint]] is an integer"]);
    // Half as fast it lasts 0.6 s of a motion that is not periodic: it cannot be made again after 0.5 s.
    let once = "periodic = false\nrepeat_every = \"0.5 s\"\n";
    assert_eq!(knee(once).motion.repeat_every, Some(0.5));
    assert_eq!(said(&format!("{once}scale = {{ speed = 0.5 }}")).len(), 1);
}

#[test]
fn a_finished_motion_is_as_one_of_a_file() {
    let samples = Samples {
        time: vec![0.0, 0.1, 0.2, 0.3],
        torque: vec![1.0, 2.0, 1.5, -0.5],
        velocity: Some(vec![0.5, 1.5, 0.2, -1.0]),
        ..Samples::default()
    };
    let motion = Arc::new(Motion::from_samples(samples, Course::Periodic(0.4)));
    let of = |lines: &str, columns| read(&robot(lines, ""), &[], &mut Given(motion.clone(), columns));
    for lines in ["", "scale = { torque = 2, speed = 3 }"] {
        assert_eq!(of(lines, Vec::new()).unwrap().joints[0].motion, knee(lines).motion);
    }
    // It is the very motion, not a copy.
    assert!(Arc::ptr_eq(&of("", Vec::new()).unwrap().joints[0].motion, &motion));
    assert_eq!(
        of("periodic = true", Vec::new()).unwrap_err(),
        ["`periodic` says nothing of a motion that is handed over"]
    );
    let short = vec![("foot".to_string(), vec![1.0], vec![0.0])];
    assert_eq!(
        of("", short).unwrap_err(),
        ["the torque per mass of `foot` does not have as many entries as the motion has samples"]
    );
    let nobody = vec![("foot".to_string(), vec![1.0; motion.len()], vec![0.0; motion.len()])];
    assert_eq!(of("", nobody).unwrap_err(), ["`torque_per_mass` names a joint `foot`, but there is none"]);
}

#[test]
fn a_disk_hands_nothing_over() {
    assert!(FromDisk::default().given("knee.csv").is_none());
}
