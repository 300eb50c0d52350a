//! What each row of the shipped catalogue costs at each joint: `cargo bench --bench rows -- REQUIREMENT...`, by default the shipped
//! requirements. One thread; of three runs of a row the quickest counts. A line for each joint: the sum over the rows, the
//! median, and the dearest rows as multiples of the median.

use std::path::{Path, PathBuf};
use std::time::Instant;

use gearwise::catalog::Catalog;
use gearwise::design::optimize::optimize_with;
use gearwise::design::options::Options;
use gearwise::requirement::{self, Robot};

/// Rows that are told.
const TOLD: usize = 4;

fn shipped() -> Vec<PathBuf> {
    let folder = std::fs::read_dir("requirements").expect("the folder of shipped requirements");
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.expect("an entry").path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    files.sort();
    files
}

/// How long a motor takes at a joint [ms].
fn cost(robot: &Robot, catalog: &Catalog) -> f64 {
    let start = Instant::now();
    std::hint::black_box(optimize_with(robot, catalog, Options::default()).expect("nobody stops it"));
    start.elapsed().as_secs_f64() * 1e3
}

fn main() {
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let files = if given.is_empty() { shipped() } else { given.iter().map(|f| Path::new(f).to_path_buf()).collect() };
    let times = std::env::var("ROWS_TIMES").ok().and_then(|t| t.parse().ok()).unwrap_or(3);
    let all = Catalog::builtin().expect("the shipped catalogue is sound");
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one_thread.install(|| {
        for file in files {
            let robot = match requirement::read(&file) {
                Ok(robot) => robot,
                Err(_) => {
                    println!("{}: cannot be read", file.display());
                    continue;
                }
            };
            for joint in &robot.joints {
                let alone = Robot {
                    joints: vec![gearwise::requirement::Joint { carries: Vec::new(), ..joint.clone() }],
                    ..robot.clone()
                };
                let mut costs: Vec<(f64, &str)> = Vec::new();
                for motor in &all.motors {
                    let single = Catalog::of(vec![motor.clone()], all.gears.clone());
                    let least = (0..times).map(|_| cost(&alone, &single)).fold(f64::INFINITY, f64::min);
                    costs.push((least, &motor.id));
                }
                costs.sort_by(|a, b| b.0.total_cmp(&a.0));
                let (sum, median) = (costs.iter().map(|c| c.0).sum::<f64>(), costs[costs.len() / 2].0);
                let dearest: Vec<String> =
                    costs.iter().take(TOLD).map(|(c, id)| format!("{id} {c:.2} ms ({:.0})", c / median)).collect();
                let name = file.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
                println!(
                    "{name}/{}: {} samples, {sum:.0} ms in all, median {median:.3} ms; {}",
                    joint.name,
                    joint.motion.len(),
                    dearest.join(", ")
                );
            }
        }
    });
}
