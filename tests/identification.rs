//! Identification against a simulator that shares no code with it: which undeclared effect is named, and
//! how often a name is given where none should be.

mod simulator;

use std::collections::BTreeMap;
use std::path::Path;

use gearwise::measured::identify::{Options, Report, Verdict, identify};
use simulator::world::Effect;
use simulator::{Bench, Kind, Truth};

/// Runs a simulated bench.
fn run(bench: &Bench) -> (Truth, Vec<Report>) {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = bench.write(folder.path());
    let read = gearwise::measured::read::read(&truth.bench).unwrap_or_else(|e| panic!("{e:?}"));
    let reports = identify(&read, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    (truth, reports)
}

fn names(reports: &[Report]) -> Vec<&'static str> {
    reports.iter().flat_map(|r| r.effects.iter().map(|e| e.name)).collect()
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
        reports.iter().flat_map(|r| &r.effects).flat_map(|e| e.confounded_with.iter().copied()).collect();
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

/// The confusion table. Slow: run with `--release -- --ignored --nocapture confusion`.
#[test]
#[ignore = "slow: the score, not a check"]
fn confusion() {
    for size in [5.0, 1.5] {
        println!("size {size} x noise");
        let mut totals: BTreeMap<Outcome, usize> = BTreeMap::new();
        for effect in Effect::LIBRARY {
            if only().is_some_and(|o| !effect.name().contains(&o)) {
                continue;
            }
            let mut counts: BTreeMap<Outcome, usize> = BTreeMap::new();
            let mut details = Vec::new();
            for seed in seeds() {
                let (truth, reports) = run(&simulator::scenario(effect.name(), size, seed));
                let what = outcome(&truth, &reports);
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
        println!("total {totals:?}");
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
            r.noise_floor,
            last.fit,
            last.held_out.unwrap_or(f64::NAN),
            r.stages[2].fit
        );
        for e in &r.effects {
            text += &format!(" +{} {:?} ~{:?}", e.name, e.instances, e.confounded_with);
        }
        for a in r.artefacts.iter().filter(|a| a.kind != "zero") {
            text += &format!(" !{} {} {:.3e}", a.kind, a.channel, a.value);
        }
        for u in &r.unexplained {
            text += &format!(" ?{}: {}", u.depends_on, u.detail);
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
fn story(report: &Report) -> String {
    let mut text = format!(
        "{} [{}] {:?} band {:?} samples {:?} floor {:.4e}\n",
        report.target.name(),
        report.unit,
        report.verdict,
        report.band,
        report.samples,
        report.noise_floor
    );
    for s in &report.stages {
        text += &format!(
            "   {:34} fit {:.4e} ({:.2} %) held {:.4e} ({:.2} %)\n",
            s.name,
            s.fit,
            s.fit_vaf,
            s.held_out.unwrap_or(f64::NAN),
            s.held_out_vaf.unwrap_or(f64::NAN)
        );
    }
    for a in &report.artefacts {
        text += &format!("   artefact {} {} {:.4e} {}\n", a.kind, a.channel, a.value, a.unit);
    }
    for p in &report.parameters {
        text += &format!("   parameter {} {:?} -> {:.5e} ± {:?}\n", p.name, p.declared, p.fitted, p.standard_error);
    }
    for e in &report.effects {
        text += &format!("   effect {} ~{:?} size {:.3e}", e.name, e.confounded_with, e.size);
        for p in &e.parameters {
            text += &format!(" {}={:.4e}±{:.1e}", p.name, p.fitted, p.standard_error.unwrap_or(f64::NAN));
        }
        text += "\n";
    }
    for r in &report.refused {
        text += &format!("   refused {}: {}\n", r.name, r.reason);
    }
    for u in &report.unexplained {
        text += &format!("   left: {}: {}\n", u.depends_on, u.detail);
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
    for name in ["emps", "ri50_drag", "ri50_slow", "ri50_stall", "d5065", "xl330"] {
        if only().is_some_and(|o| !name.contains(&o)) {
            continue;
        }
        let start = std::time::Instant::now();
        let path = format!("tests/fixtures/benches/{name}.toml");
        match gearwise::measured::read::read(Path::new(&path)) {
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
    }
}

#[test]
fn the_simulator_writes_benches_that_can_be_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let truth = simulator::clean(Kind::Dynamometer, 1).write(folder.path());
    let bench = gearwise::measured::read::read(Path::new(&truth.bench)).unwrap();
    assert_eq!(bench.logs.len(), truth.logs.len());
}
