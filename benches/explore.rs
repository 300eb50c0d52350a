//! How long a page waits: `cargo bench --bench explore -- REQUIREMENT...`, by default of the shipped requirements. For each joint the
//! time from a question to the answer of the viewed joint, as the page gets it, and to the answer of all joints, over states that were
//! not asked before; beside the time that `optimize` takes for the whole robot in the same run, and the ratio of the two. On all threads.

use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use gearwise::ask::Rows;
use gearwise::catalog::Catalog;
use gearwise::design::optimize;
use gearwise::explore::{Explorer, Ground};
use gearwise::input::Source;
use gearwise::requirement::Settings;

/// States of each joint.
const STATES: usize = 21;
/// After so long no further state is asked.
const ENOUGH: Duration = Duration::from_secs(20);

fn main() {
    let given: Vec<PathBuf> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).map(PathBuf::from).collect();
    let mut files = given;
    if files.is_empty() {
        let folder = std::fs::read_dir("requirements").expect("the shipped requirements");
        files.extend(
            folder
                .map(|entry| entry.expect("an entry").path())
                .filter(|path| path.extension().is_some_and(|e| e == "toml")),
        );
        files.sort();
    }
    println!("viewed: from a question to the answer of the viewed joint; all: of every joint; ms, median / 95 % / n");
    let (mut every, mut number) = (Vec::new(), 0);
    for file in files {
        let source = Source::read(&file).unwrap_or_else(|why| panic!("{why}"));
        let rows = Rows::new(Catalog::builtin().expect("it is shipped"), true, false);
        let set = Settings::default();
        let ground =
            Ground { source: source.clone(), begin: Default::default(), rows: rows.clone(), words: Vec::new() };
        let explorer = Explorer::new(ground, |words| words.join(" ")).unwrap_or_else(|why| panic!("{why:?}"));
        let robot =
            gearwise::ask::ready(set.read(&source, None).expect("it was read"), rows.catalog()).expect("it is ready");
        let mut whole: Vec<f64> = (0..5)
            .map(|_| {
                let began = Instant::now();
                std::hint::black_box(optimize(&robot, rows.catalog()));
                1e3 * began.elapsed().as_secs_f64()
            })
            .collect();
        whole.sort_by(f64::total_cmp);
        for joint in &robot.joints {
            let (mut viewed, mut all) = (Vec::new(), Vec::new());
            let start = Instant::now();
            for k in 0..STATES {
                if start.elapsed() > ENOUGH {
                    break;
                }
                number += 1;
                let factor = 0.8 + 0.4 * k as f64 / STATES as f64 + 1e-6 * f64::from(number);
                let body = format!(
                    "{{\"tab\":\"bench\",\"ask\":{number},\"joint\":\"{}\",\"state\":{{\"scale.torque\":\"{factor}\"}}}}",
                    joint.name
                );
                let first: Arc<Mutex<Option<Instant>>> = Arc::default();
                let seen = first.clone();
                let began = Instant::now();
                let announce = move || {
                    seen.lock().expect("nobody panicked").get_or_insert_with(Instant::now);
                };
                let work = explorer.begin(&body, Box::new(announce)).expect("a question");
                explorer.run(&work);
                all.push(1e3 * began.elapsed().as_secs_f64());
                let first = first.lock().expect("nobody panicked").expect("an answer");
                viewed.push(1e3 * (first - began).as_secs_f64());
            }
            let told = |of: &mut Vec<f64>| {
                of.sort_by(f64::total_cmp);
                (of[of.len() / 2], of[(95 * of.len() / 100).min(of.len() - 1)])
            };
            let ((median, late), (of_all, all_late)) = (told(&mut viewed), told(&mut all));
            every.extend(&viewed);
            println!(
                "{} {}: viewed {median:.1} / {late:.1} / {}, all {of_all:.1} / {all_late:.1}; optimize {:.1}; viewed over optimize {:.2}",
                file.file_stem().unwrap_or_default().to_string_lossy(),
                joint.name,
                viewed.len(),
                whole[2],
                median / whole[2]
            );
        }
    }
    every.sort_by(f64::total_cmp);
    println!(
        "every joint: viewed {:.1} / {:.1} / {}",
        every[every.len() / 2],
        every[95 * every.len() / 100],
        every.len()
    );
}
