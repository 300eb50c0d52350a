//! What each row of the shipped catalogue costs at each joint: `cargo bench --bench rows -- REQUIREMENT...`, by default of the
//! shipped requirements. One thread, what the rows share apart; a row is solved again and again for a while, in processor time where
//! the system tells it (in steps of some milliseconds). A line for each joint: the sum over the rows, the median over those that have a design (others are often
//! rejected by one look), and the dearest rows as multiples of it.

use std::hint::black_box;
use std::path::PathBuf;
use std::time::Instant;

use gearwise::catalog::Catalog;
use gearwise::design::best::best_design;
use gearwise::design::{JointDemand, Site};
use gearwise::requirement;

/// Rows that are told.
const TOLD: usize = 4;
/// How long a row is solved again and again \[ms\], and how often at most.
const LASTS: (f64, usize) = (25.0, 2000);

fn shipped() -> Vec<PathBuf> {
    let folder = std::fs::read_dir("requirements").expect("the folder of shipped requirements");
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    files.sort();
    files
}

/// What this thread has taken of the processor [ms]; where the system does not tell, the time of the clock.
fn now(started: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds: Option<f64> = told.and_then(|t| t.split_whitespace().next()?.parse().ok());
    nanoseconds.map_or(started.elapsed().as_secs_f64() * 1e3, |ns| ns * 1e-6)
}

fn main() {
    let started = Instant::now();
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let files = if given.is_empty() { shipped() } else { given.iter().map(PathBuf::from).collect() };
    let catalog = Catalog::builtin().expect("the shipped catalogue is sound");
    for file in files {
        let Ok(robot) = requirement::read(&file) else {
            println!("{}: cannot be read", file.display());
            continue;
        };
        for joint in &robot.joints {
            let start = now(started);
            let demand = JointDemand::new(joint, &catalog);
            let shared = now(started) - start;
            let site = Site::new(&robot, joint, &demand);
            let mut costs = Vec::new();
            for motor in &catalog.motors {
                let (start, mut runs, mut found) = (now(started), 0, false);
                while runs < LASTS.1 && now(started) - start < LASTS.0 {
                    found = black_box(best_design(site, motor, false)).is_ok();
                    runs += 1;
                }
                costs.push(((now(started) - start) / runs as f64, found, motor.id.as_str()));
            }
            costs.sort_by(|a, b| b.0.total_cmp(&a.0));
            let with_design: Vec<f64> = costs.iter().filter(|c| c.1).map(|c| c.0).collect();
            let (sum, median) = (
                costs.iter().map(|c| c.0).sum::<f64>(),
                with_design.get(with_design.len() / 2).copied().unwrap_or(f64::NAN),
            );
            let dearest = costs.iter().take(TOLD).map(|(c, _, id)| format!("{id} {c:.2} ms ({:.0})", c / median));
            println!(
                "{}/{}: {} samples, shared {shared:.1} ms, rows {sum:.0} ms, median of {} designs {median:.3} ms; {}",
                file.file_stem().unwrap_or_default().to_string_lossy(),
                joint.name,
                joint.motion.len(),
                with_design.len(),
                dearest.collect::<Vec<_>>().join(", ")
            );
        }
    }
}
