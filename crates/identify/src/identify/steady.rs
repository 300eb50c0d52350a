//! Benches for the tests of this room, most of steady points: no filter stands between what is written here and the
//! rows of the regression.

use std::fmt::Write;

use super::Target;
use super::balance::{Balance, Setting};
use super::work::{Kind, Term, Work};
use crate::{Bench, read};
use gearwise_model::effects::effect;

/// Torque constant of the declared motor \[N·m/A\].
pub const CONSTANT: f64 = 0.1;

/// Columns of a log over time on a dynamometer; without the last, of a motor that runs free.
pub(crate) const OVER_TIME: [&str; 4] = [
    "time = { name = \"0\", unit = \"s\" }",
    "velocity = { name = \"1\", unit = \"rad/s\", side = \"motor\" }",
    "current = { name = \"2\", unit = \"A\", convention = \"q_axis\" }",
    "torque = { name = \"3\", unit = \"N*m\", side = \"output\" }",
];

/// A number between −1 and 1 that depends on its place alone.
pub fn noise(place: usize) -> f64 {
    let mut x = (place as u64).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Logs of speed \[rad/s\], current \[A\] and torque at the sensor \[N·m\]; the last `held_out` of them only judge.
pub fn bench(ratio: f64, logs: &[Vec<[f64; 3]>], held_out: usize) -> Bench {
    let columns = [
        "velocity = { name = \"0\", unit = \"rad/s\", side = \"motor\" }",
        "current = { name = \"1\", unit = \"A\", convention = \"q_axis\" }",
        "torque = { name = \"2\", unit = \"N*m\", side = \"output\" }",
    ];
    let logs: Vec<Vec<Vec<f64>>> = logs.iter().map(|log| log.iter().map(|row| row.to_vec()).collect()).collect();
    bench_of("steady_table", ratio, &columns, &logs, held_out)
}

/// Logs of a kind whose columns are described by lines of `[columns]`, named by their places.
pub fn bench_of(kind: &str, ratio: f64, columns: &[&str], logs: &[Vec<Vec<f64>>], held_out: usize) -> Bench {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("it can be written");
    write(
        "motors.csv",
        &format!(
            "id,terminals,current,resistance [ohm],torque_constant [N*m/A],source,source_kind\n\
             m,q_axis,q_axis,0.5,{CONSTANT},-,derived\n"
        ),
    );
    let mut text = format!(
        "catalog = [\"motors.csv\"]\nactuator = {{ motor = \"m\", ratio = {ratio} }}\nkind = \"{kind}\"\n[columns]\n{}\n",
        columns.join("\n")
    );
    let line = |row: &mut dyn Iterator<Item = String>| row.collect::<Vec<String>>().join(",") + "\n";
    for (k, log) in logs.iter().enumerate() {
        let mut rows = line(&mut (0..columns.len()).map(|c| c.to_string()));
        for row in log {
            rows += &line(&mut row.iter().map(|v| format!("{v:?}")));
        }
        write(&format!("{k}.csv"), &rows);
        let usage = if k + held_out < logs.len() { "fit" } else { "held_out" };
        writeln!(text, "[[log]]\nfile = \"{k}.csv\"\nuse = \"{usage}\"").expect("text grows");
    }
    write("bench.toml", &text);
    read::read(&folder.path().join("bench.toml")).unwrap_or_else(|e| panic!("{e:?}"))
}

/// Speed, current, torque and, where `warm`, winding temperature over time, a kilosample a second; two logs.
pub fn moving(samples: usize, warm: bool) -> Bench {
    moving_at(1.0, samples, warm)
}

/// The same with faster turns.
pub(crate) fn moving_at(pace: f64, samples: usize, warm: bool) -> Bench {
    let mut columns = OVER_TIME.to_vec();
    if warm {
        columns.push("winding_temperature = { name = \"4\", unit = \"degC\" }");
    }
    let logs: Vec<Vec<Vec<f64>>> = (0..2)
        .map(|log| {
            let row = |k: usize| {
                let t = 1e-3 * k as f64;
                let phase = log as f64;
                let w = 60.0 * (3.0 * pace * t + phase).sin()
                    + 25.0 * (7.1 * pace * t).cos()
                    + 0.3 * noise(k + 90_000 * (log + 1));
                let i = 3.0 * (11.0 * t + 2.0 * phase).sin() + 2.0 * (17.3 * t).cos();
                let tau = 6.0 * CONSTANT * i + 0.01 * noise(k + 50_000 * (log + 1));
                let mut row = vec![t, w, i, tau];
                row.extend(warm.then(|| 25.0 + 30.0 * (1.0 + (0.9 * t + phase).sin())));
                row
            };
            (0..samples).map(row).collect()
        })
        .collect();
    bench_of("dynamometer", 6.0, &columns, &logs, 0)
}

/// The model of a bench before anything is looked for.
pub fn work(bench: &Bench) -> Work<'_> {
    work_on(bench, Target::Torque)
}

/// The same of another equation.
pub(crate) fn work_on(bench: &Bench, target: Target) -> Work<'_> {
    Work::new(bench, Balance::new(bench, target, &Setting::uncorrected(bench, None)).expect("rows"))
}

/// Adds an effect that the declared model lacks.
pub fn add(work: &mut Work, name: &str, shape: f64) {
    let effect = effect(name).expect("an effect");
    let columns = work.balance.effect_columns(effect, shape);
    work.terms.push(Term { kind: Kind::Effect(effect, shape), columns, declared: None });
}
