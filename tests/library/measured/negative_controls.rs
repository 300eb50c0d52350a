//! Logs in which there is nothing to find, and a part of them that may not matter.

use std::path::Path;

use gearwise::measured::identify::{ArtefactKind, Options, Report, Verdict, identify};
use gearwise::measured::read::read;

use crate::cases::few;
use crate::simulator::{Bench, Kind, clean, random::Random, scenario};

/// Reports of a bench whose logs were changed after they were written.
fn reports(bench: &Bench, change: impl Fn(usize, &Path)) -> Vec<Report> {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = bench.write(folder.path());
    for (number, log) in truth.logs.iter().enumerate() {
        change(number, &log.file);
    }
    let read = read(&truth.bench).unwrap_or_else(|e| panic!("{e:?}"));
    // A bench that teaches nothing names nothing.
    identify(&read, &Options::default()).unwrap_or_default()
}

/// Changes a column of a log.
fn change_column(log: &Path, name: &str, change: impl FnOnce(&mut Vec<f64>)) {
    let mut reader = csv::Reader::from_path(log).expect("the log");
    let header = reader.headers().expect("a header").clone();
    let at = header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no {name}"));
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("a row")).collect();
    let mut values: Vec<f64> = rows.iter().map(|r| r[at].parse().expect("a number")).collect();
    change(&mut values);
    let mut writer = csv::Writer::from_path(log).expect("the log");
    writer.write_record(&header).expect("a header");
    for (row, value) in rows.iter().zip(values) {
        let cell = format!("{value:.7e}");
        writer.write_record(row.iter().enumerate().map(|(c, old)| if c == at { &cell } else { old })).expect("a row");
    }
}

/// White noise of the size of what was there.
fn noise(values: &mut [f64], seed: u64) {
    let size = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    let mut random = Random::new(seed, "noise in place of a response");
    values.iter_mut().for_each(|v| *v = size * random.normal());
}

/// Benches with a clear effect, each with the column of its response.
fn benches() -> [(Bench, &'static str); 3] {
    [
        (scenario("coulomb_friction", 5.0, 301).sampled(10.0, 200.0), "tau_nm"),
        (Bench { kind: Kind::Free, ..scenario("gravity", 5.0, 302) }.sampled(10.0, 200.0), "iq_a"),
        (scenario("inverter_dead_time", 5.0, 303).sampled(10.0, 200.0), "vq_v"),
    ]
}

fn names(reports: &[Report]) -> Vec<&'static str> {
    reports.iter().flat_map(|r| r.effects.iter().map(|e| e.name())).collect()
}

fn claims_completeness(reports: &[Report]) -> bool {
    reports.iter().any(|r| matches!(r.verdict, Verdict::NothingMissing | Verdict::Explained))
}

#[test]
fn a_response_of_noise_has_no_effect() {
    for (bench, column) in benches() {
        let seed = bench.seed;
        let said = reports(&bench, |log, file| change_column(file, column, |v| noise(v, seed + 10 * log as u64)));
        assert!(names(&said).is_empty(), "{column}: {:?}", names(&said));
        assert!(!claims_completeness(&said), "{column}: {:?}", said.iter().map(|r| r.verdict).collect::<Vec<_>>());
    }
}

/// Turned round by a third of the log: far beyond five correlation times of the motion, and as smooth as before.
#[test]
fn a_response_of_another_time_has_no_effect() {
    for (bench, column) in benches() {
        let said = reports(&bench, |_, file| {
            change_column(file, column, |v| {
                let third = v.len() / 3;
                v.rotate_right(third);
            });
        });
        assert!(names(&said).is_empty(), "{column}: {:?}", names(&said));
        assert!(!claims_completeness(&said), "{column}: {:?}", said.iter().map(|r| r.verdict).collect::<Vec<_>>());
    }
}

/// What the logs for fitting say, without what was held out.
fn of_the_fit(reports: &[Report], held_out: &str) -> String {
    let mut text = String::new();
    for r in reports {
        text += &format!("{:?} band {:?} left {:e}\n", r.target, r.band, r.evidence.left);
        for s in &r.stages {
            text += &format!("{} {:e}\n", s.step.name(), s.fit);
        }
        for p in &r.parameters {
            text += &format!("{} {:e} {:?}\n", p.name, p.fitted, p.standard_error);
        }
        for e in &r.effects {
            text += &format!("{} {:?} {:?}\n", e.name(), e.instances, e.confounded_with);
        }
        let own =
            |a: &&gearwise::measured::identify::Artefact| a.kind != ArtefactKind::Zero || !a.channel.contains(held_out);
        for a in r.artefacts.iter().filter(own) {
            text += &format!("{} {} {:e}\n", a.kind.name(), a.channel, a.value);
        }
        for refused in &r.refused {
            text += &format!("{} {}\n", refused.name, refused.reason);
        }
    }
    text
}

/// What is said with a changed held-out log, against what is said without.
fn only_its_own_errors_change(bench: &Bench, change: impl Fn(&Path)) {
    let last = bench.logs - 1;
    let before = reports(bench, |_, _| {});
    let after = reports(bench, |log, file| {
        if log == last {
            change(file);
        }
    });
    let name = format!("log{}", last + 1);
    let kind = bench.kind.name();
    assert_eq!(of_the_fit(&before, &name), of_the_fit(&after, &name), "{kind}");
    let held_out = |reports: &[Report]| reports[0].stages.last().and_then(|s| s.held_out);
    assert_ne!(held_out(&before), held_out(&after), "{kind}: the noise was not read");
}

#[test]
fn a_held_out_response_of_noise_changes_nothing_but_its_own_errors() {
    for (bench, column) in few(1, benches()) {
        only_its_own_errors_change(&bench, |file| change_column(file, column, |v| noise(v, 7)));
    }
}

#[test]
fn a_held_out_log_of_noise_changes_nothing_but_its_own_errors() {
    for (bench, column) in few(1, benches()) {
        only_its_own_errors_change(&bench, |file| {
            for (k, name) in ["q_rad", "w_radps", "iq_a", column].into_iter().enumerate() {
                change_column(file, name, |v| noise(v, 7 + k as u64));
            }
        });
    }
}

#[test]
fn clean_logs_have_no_effect_in_any_band() {
    for kind in
        [Kind::Dynamometer, Kind::Free, Kind::Drag, Kind::RandomTorque, Kind::Electrical, Kind::Stall, Kind::Servo]
    {
        let (duration, rate) = match kind {
            Kind::Stall => (16.0, 100.0),
            Kind::Servo => (6.0, 200.0),
            _ => (6.0, 200.0),
        };
        let folder = tempfile::tempdir().expect("a folder");
        let truth = clean(kind, 304).sampled(duration, rate).write(folder.path());
        let bench = read(&truth.bench).unwrap_or_else(|e| panic!("{e:?}"));
        // The position of a servo is simulated: it has no band.
        let bands: &[f64] = if kind == Kind::Servo { &[20.0] } else { &[15.0, 40.0, 8.0, 25.0] };
        for band in few(1, bands) {
            let said = identify(&bench, &Options { band: Some(*band) }).unwrap_or_else(|e| panic!("{e}"));
            assert!(names(&said).is_empty(), "{kind:?} at {band} Hz: {:?}", names(&said));
        }
    }
}
