//! Bench files and their logs: what they mean in SI, and what is said about each mistake. The benches of
//! real data read logs that are not ours to ship; without them their tests say that they are skipped.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use approx::assert_relative_eq;
use gearwise::effects::FittedEffect;
use gearwise::measured::read::{STANDARD_GRAVITY, read};
use gearwise::measured::{Bench, BenchKind, Channel, Use};

use crate::common::real::on_each;

/// q axis per ampere of phase amplitude, √(3/2).
const AMPLITUDE: f64 = 1.224_744_871_391_589;

const MOTORS: &str = "id,commutation,terminals,current,resistance [ohm],torque_constant [N*m/A],coulomb_friction [N*m],source,source_kind
outrunner,brushless,line_to_line,rms,0.5,0.05,0.004,a sheet,datasheet
brushed,brushed,line_to_line,dc,0.5,0.05,,a sheet,datasheet
";

const GEARS: &str = "id,kind,ratio,stages,efficiency,mass [g],inertia [g*cm^2],source,source_kind
planetary-9,planetary,9,2,0.8,150,5,a sheet,datasheet
";

/// A dynamometer bench that reads.
const BENCH: &str = r#"catalog = ["motors.csv", "gears.csv"]
actuator = { motor = "outrunner", ratio = 6 }
kind = "dynamometer"

[columns]
time = { name = "t_ms", unit = "ms" }
current = { name = "i", unit = "A", convention = "phase_amplitude" }
velocity = { name = "w", unit = "rpm", side = "motor" }
torque = { name = "tau", unit = "mN*m", side = "output", sign = -1 }

[[log]]
file = "log.csv"
"#;

const LOG: &str = "# a comment
t_ms, i, w, tau, run
0, 1.0, 60, -500, a
10, 2.0, 120, -1000, a
# another

20, 3.0, -60, 1500, b
30, 4.0, 0, 0, b
";

/// Writes the files into a folder and reads the bench; an error is the report that a person sees.
fn outcome(bench: &str, logs: &[(&str, &[u8])]) -> Result<Bench, String> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("bench.toml", bench.as_bytes());
    write("motors.csv", MOTORS.as_bytes());
    write("gears.csv", GEARS.as_bytes());
    for (name, bytes) in logs {
        write(name, bytes);
    }
    read(&folder.path().join("bench.toml")).map_err(|errors| {
        assert!(!errors.is_empty() && errors.iter().all(|e| !e.problems.is_empty()));
        errors.iter().map(ToString::to_string).collect()
    })
}

fn good(bench: &str, log: &str) -> Bench {
    outcome(bench, &[("log.csv", log.as_bytes())]).unwrap_or_else(|e| panic!("{e}"))
}

/// The report must have all of these in it.
fn refused(bench: &str, log: &[u8], parts: &[&str]) {
    let report = outcome(bench, &[("log.csv", log)]).expect_err("this must be refused");
    for part in parts {
        assert!(report.contains(part), "`{part}` is not in:\n{report}");
    }
}

fn spoilt(from: &str, to: &str) -> String {
    assert!(BENCH.contains(from), "{from}");
    BENCH.replace(from, to)
}

/// A channel of the first log.
fn channel(bench: &Bench, channel: Channel) -> &[f64] {
    bench.logs[0].channel(channel).unwrap_or_else(|| panic!("no {channel:?}"))
}

fn close(values: &[f64], expected: &[f64]) {
    assert_eq!(values.len(), expected.len());
    for (value, expected) in values.iter().zip(expected) {
        assert_relative_eq!(value, expected, max_relative = 1e-12, epsilon = 1e-15);
    }
}

#[test]
fn a_log_in_si_and_canonical_frames() {
    let bench = good(BENCH, LOG);
    assert_eq!(bench.name, "bench");
    assert_eq!(bench.declared.ratio, 6.0);
    assert_eq!(bench.declared.motor.as_ref().unwrap().id, "outrunner");
    assert_eq!(bench.catalog.motors.len(), 2);
    let log = &bench.logs[0];
    assert_eq!((log.kind, log.usage, log.name.as_str()), (BenchKind::Dynamometer, Use::Fit, "log.csv"));
    close(&log.time, &[0.0, 0.01, 0.02, 0.03]);
    close(channel(&bench, Channel::Current), &[1.0, 2.0, 3.0, 4.0].map(|i| i * AMPLITUDE));
    // 60 rpm is one turn per second.
    let turn = std::f64::consts::TAU;
    close(channel(&bench, Channel::MotorVelocity), &[turn, 2.0 * turn, -turn, 0.0]);
    close(channel(&bench, Channel::Torque), &[0.5, 1.0, -1.5, 0.0]);
    assert_eq!(log.channels.len(), 3, "the output's velocity is not derived here");
    assert!(log.remarks.is_empty(), "{:?}", log.remarks);
}

#[test]
fn the_hash_is_that_of_the_file() {
    let log = "t_ms,i,w,tau\n0,1,1,1\n1,1,1,1\n2,1,1,1\n";
    let bench = good(BENCH, log);
    // sha256sum of these bytes.
    assert_eq!(bench.logs[0].hash, HASH);
    assert_ne!(good(BENCH, &log.replace("2,1,1,1", "2,1,1,2")).logs[0].hash, HASH);
}
const HASH: &str = "41808ba749a748281b000dc920ae5b8a78273fa7f35f82e1e7c9485224f520b8";

#[test]
fn line_ends_and_byte_order_mark_do_not_matter() {
    let plain = good(BENCH, LOG);
    let header = LOG.trim_start_matches("# a comment\n");
    let marked = good(BENCH, &format!("\u{feff}{header}"));
    assert_eq!(marked.logs[0].channels, plain.logs[0].channels);
    let windows = good(BENCH, &LOG.replace('\n', "\r\n"));
    assert_eq!(windows.logs[0].channels, plain.logs[0].channels);
}

#[test]
fn conventions_of_current_and_voltage() {
    let columns = |current: &str, voltage: &str| {
        BENCH
            .replace("\"dynamometer\"", "\"electrical\"")
            .replace(", convention = \"phase_amplitude\" }", &format!("{current} }}"))
            .replace(
                "torque = { name = \"tau\", unit = \"mN*m\", side = \"output\", sign = -1 }",
                &format!("voltage = {{ name = \"tau\", unit = \"mV\"{voltage} }}"),
            )
    };
    let factor = |bench: &str, c: Channel| channel(&good(bench, LOG), c)[0];
    let said = |word: &str| format!(", convention = \"{word}\"");
    for (word, expected) in [
        ("q_axis", 1.0),
        ("phase_amplitude", AMPLITUDE),
        ("rms", 3.0_f64.sqrt()),
        ("dc", 3.0 * 2.0_f64.sqrt() / std::f64::consts::PI),
    ] {
        assert_relative_eq!(factor(&columns(&said(word), ""), Channel::Current), expected, max_relative = 1e-12);
    }
    for (word, expected) in [
        ("q_axis", 1.0),
        ("phase_peak", AMPLITUDE),
        ("phase_rms", 3.0_f64.sqrt()),
        ("line_to_line_peak", 0.5_f64.sqrt()),
        ("line_to_line_rms", 1.0),
    ] {
        let volts = factor(&columns("", &said(word)), Channel::Voltage);
        assert_relative_eq!(volts, -0.5 * expected, max_relative = 1e-12);
    }
    // Nothing said: the row's own convention (rms), and the q axis; both are remarked.
    let silent = good(&columns("", ""), LOG);
    assert_relative_eq!(channel(&silent, Channel::Current)[0], 3.0_f64.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(channel(&silent, Channel::Voltage)[0], -0.5, max_relative = 1e-12);
    let remarks = silent.logs[0].remarks.join("\n");
    assert!(
        remarks.contains("taken as that of the motor's row, rms") && remarks.contains("on the q axis"),
        "{remarks}"
    );
    // Brushes: an ampere is an ampere.
    let brushed = good(&columns("", "").replace("outrunner", "brushed"), LOG);
    assert_relative_eq!(channel(&brushed, Channel::Current)[0], 1.0);
    assert!(brushed.logs[0].remarks.is_empty());
    refused(&columns(&said("phase"), ""), LOG.as_bytes(), &["`convention`", "cannot be `phase`", "phase_amplitude"]);
}

#[test]
fn sides_of_the_gear() {
    let bench = good(
        &spoilt(
            "velocity = { name = \"w\", unit = \"rpm\", side = \"motor\" }",
            "velocity = [{ name = \"w\", unit = \"rad/s\", side = \"motor\" }, { name = \"tau\", unit = \"rad/s\", side = \"output\" }]
acceleration = { name = \"w\", unit = \"rad/s^2\", side = \"motor\" }
position = { name = \"w\", unit = \"deg\" }",
        )
        .replace("side = \"output\", sign = -1", "side = \"motor\""),
        LOG,
    );
    assert_relative_eq!(channel(&bench, Channel::MotorVelocity)[0], 60.0);
    assert_relative_eq!(channel(&bench, Channel::OutputVelocity)[0], -500.0);
    assert_relative_eq!(channel(&bench, Channel::OutputAcceleration)[0], 10.0, max_relative = 1e-12);
    assert_relative_eq!(channel(&bench, Channel::OutputPosition)[0], std::f64::consts::PI / 3.0, max_relative = 1e-12);
    // A sensor at the motor's shaft, brought to the output: N times.
    assert_relative_eq!(channel(&bench, Channel::Torque)[0], -3.0, max_relative = 1e-12);
    let remarks = bench.logs[0].remarks.join("\n");
    assert!(remarks.contains("`position` names no side and is taken at the output"), "{remarks}");
    assert!(remarks.contains("`torque` was measured at the motor"), "{remarks}");
    let twice = spoilt("velocity =", "motor_velocity = { name = \"w\", unit = \"rad/s\" }\nvelocity =");
    refused(&twice, LOG.as_bytes(), &["two columns for one channel", "`velocity` and `motor_velocity`"]);
}

#[test]
fn temperatures_duty_scale_and_words() {
    let bench = good(
        &spoilt(
            "torque = {",
            "temperature = { name = \"i\", unit = \"degC\" }
magnet_temperature = { name = \"i\", unit = \"K\" }
duty = { name = \"w\", unit = \"%\" }
supply = { name = \"d\", unit = \"V\", scale = 0.5, bits = 16 }
torque = {",
        ),
        "t_ms,i,w,tau,d\n0,120,50,1,65535\n1,121,50,1,32767\n2,122,50,1,0\n3,123,50,1,32768\n",
    );
    close(channel(&bench, Channel::WindingTemperature), &[393.15, 394.15, 395.15, 396.15]);
    close(channel(&bench, Channel::HousingTemperature), &[120.0, 121.0, 122.0, 123.0]);
    close(channel(&bench, Channel::Duty), &[0.5; 4]);
    close(channel(&bench, Channel::Supply), &[-0.5, 16383.5, 0.0, -16384.0]);
}

#[test]
fn a_linear_axis() {
    let axis = r#"name = "axis"
actuator = { mass = "95 kg", force_gain = "35 N/V", viscous_friction = "200 N*s/m", coulomb_friction = "20 N" }
kind = "linear"
load = { mass = "5 kg" }
[columns]
time = { name = "t_ms", unit = "ms" }
position = { name = "w", unit = "mm" }
voltage = { name = "i", unit = "V" }
[[log]]
file = "log.csv"
"#;
    let bench = good(axis, LOG);
    assert!(bench.declared.motor.is_none());
    assert_eq!((bench.declared.mass, bench.declared.force_gain), (Some(95.0), 35.0));
    assert_eq!((bench.declared.viscous_friction, bench.declared.coulomb_friction), (Some(200.0), Some(20.0)));
    assert_eq!(bench.logs[0].load.inertia, Some(5.0));
    close(channel(&bench, Channel::Current), &[1.0, 2.0, 3.0, 4.0]);
    close(channel(&bench, Channel::OutputPosition), &[0.06, 0.12, -0.06, 0.0]);
    // A force is what the gain would have made of the drive.
    let force = axis.replace("voltage = { name = \"i\", unit = \"V\" }", "force = { name = \"i\", unit = \"kN\" }");
    close(channel(&good(&force, LOG), Channel::Current), &[1.0, 2.0, 3.0, 4.0].map(|f| f * 1000.0 / 35.0));
    let plain = force.replace("force_gain = \"35 N/V\", ", "");
    close(channel(&good(&plain, LOG), Channel::Current), &[1000.0, 2000.0, 3000.0, 4000.0]);
    let mute = axis.replace("force_gain = \"35 N/V\", ", "");
    refused(&mute, LOG.as_bytes(), &["kind `linear` needs `force`, or the column that `force_gain` is for"]);
    refused(&axis.replace("35 N/V", "35 N/W"), LOG.as_bytes(), &["`force_gain` cannot be `35 N/W`", "35.15 N/V"]);
    refused(&axis.replace("\"mm\"", "\"rad\""), LOG.as_bytes(), &["`rad` is not a unit of length"]);
    refused(&axis.replace("kind = \"linear\"", "kind = \"free\""), LOG.as_bytes(), &["this axis is linear"]);
}

#[test]
fn the_declared_actuator() {
    let actuator = |inside: &str| BENCH.replace("motor = \"outrunner\", ratio = 6", inside);
    let declared = |inside: &str| good(&actuator(inside), LOG).declared;
    let geared = declared("motor = \"outrunner\", gear = \"planetary-9\", fixture_inertia = \"10 kg*cm^2\"");
    assert_eq!((geared.ratio, geared.gear.efficiency, geared.gear.mass), (9.0, 0.8, Some(0.15)));
    assert_relative_eq!(geared.gear.backdrive_efficiency, 0.75, max_relative = 1e-12);
    assert_relative_eq!(geared.gear.inertia, 5e-7, max_relative = 1e-12);
    assert_relative_eq!(geared.fixture_inertia, 1e-3, max_relative = 1e-12);
    let given = declared(
        "motor = \"outrunner\", ratio = 7.5, efficiency = 0.9, backdrive_efficiency = 0.85, gear_inertia = \"1e-6 kg*m^2\"",
    );
    assert_eq!((given.ratio, given.gear.efficiency, given.gear.backdrive_efficiency), (7.5, 0.9, 0.85));
    assert_eq!(given.gear.inertia, 1e-6);
    let effects =
        declared("motor = \"outrunner\", ratio = 6, effects = { coulomb_friction = { torque = \"10 mN*m\" } }");
    assert_eq!(effects.effects, vec![FittedEffect::new("coulomb_friction", vec![0.01]).unwrap()]);
    let listed = declared("motor = \"outrunner\", ratio = 6, effects = [\"coulomb_friction\"]");
    assert_eq!(listed.effects, vec![FittedEffect::new("coulomb_friction", vec![0.004]).unwrap()]);

    let bad = |inside: &str, parts: &[&str]| refused(&actuator(inside), LOG.as_bytes(), parts);
    bad("motor = \"outruner\", ratio = 6", &["there is no motor `outruner`", "did you mean `outrunner`?"]);
    bad("motor = \"outrunner\", gear = \"planetary\"", &["there is no gear `planetary`", "planetary-9"]);
    bad("motor = \"outrunner\"", &["`ratio` of [actuator] is missing", "1 for direct drive"]);
    bad("ratio = 6", &["`motor` of [actuator] is missing"]);
    bad(
        "motor = \"outrunner\", ratio = 6, efficency = 0.9",
        &["unknown key `efficency`", "did you mean `efficiency`?"],
    );
    bad("motor = \"outrunner\", ratio = 6, effects = [\"columb_friction\"]", &["did you mean `coulomb_friction`?"]);
    bad(
        "motor = \"outrunner\", ratio = 6, effects = { coulomb_friction = { torqe = \"1 N*m\" } }",
        &["unknown key `torqe`", "did you mean `torque`?", "`torque` of [coulomb_friction] is missing"],
    );
    bad(
        "motor = \"brushed\", ratio = 6, effects = [\"coulomb_friction\"]",
        &["the row of `brushed` does not say how large its coulomb_friction is", "give its values"],
    );
}

#[test]
fn loads_pendulums_and_controllers_of_each_log() {
    let bench = BENCH
        .replace(
            "\"dynamometer\"",
            "\"servo\"\nload = { inertia = \"0.02 kg*m^2\" }\ncontroller = { gain = \"0.5 1/rad\" }",
        )
        .replace("velocity =", "position =")
        .replace("rpm", "deg")
        .replace(
            "torque = { name = \"tau\", unit = \"mN*m\", side = \"output\", sign = -1 }",
            "goal = { name = \"tau\", unit = \"deg\" }",
        )
        + r#"select = { column = "run", equals = "a" }
[[log]]
file = "log.csv"
select = { column = "run", equals = "b" }
use = "held_out"
pendulum = { mass = "0.5 kg", length = "0.1 m", arm_mass = "60 g" }
controller = { gain = 0.25, damping = "0.01 s/rad", limit = 0.8 }
[[log]]
file = "log2.csv"
load = { mass = "2 kg", distance = "0.5 m" }
kind = "free"
columns = { current = { name = "tau", unit = "A", convention = "q_axis" } }
"#;
    let log = LOG.replace("30, 4.0, 0, 0, b", "30, 4.0, 0, 0, b\n40,1,1,1,a\n50,1,1,1,b");
    let bench =
        outcome(&bench, &[("log.csv", log.as_bytes()), ("log2.csv", log.as_bytes())]).unwrap_or_else(|e| panic!("{e}"));
    let [first, second, third] = bench.logs.as_slice() else { panic!("three logs") };
    assert_eq!((first.name.as_str(), second.name.as_str()), ("log.csv, run a", "log.csv, run b"));
    assert_eq!((first.usage, second.usage), (Use::Fit, Use::HeldOut));
    assert_eq!((first.len(), second.len(), third.len()), (3, 3, 6));
    assert_eq!(first.hash, third.hash);
    assert_eq!((first.load.inertia, first.load.gravity_torque), (Some(0.02), None));
    assert_eq!(first.controller.map(|c| (c.gain, c.damping, c.limit)), Some((0.5, 0.0, 1.0)));
    assert_relative_eq!(second.load.inertia.unwrap(), 0.52 * 0.01, max_relative = 1e-12);
    assert_relative_eq!(second.load.gravity_torque.unwrap(), 0.53 * STANDARD_GRAVITY * 0.1, max_relative = 1e-12);
    assert_eq!(second.controller.map(|c| (c.gain, c.damping, c.limit)), Some((0.25, 0.01, 0.8)));
    assert_eq!(third.kind, BenchKind::Free);
    assert_relative_eq!(third.load.inertia.unwrap(), 0.5, max_relative = 1e-12);
    assert_relative_eq!(third.load.gravity_torque.unwrap(), STANDARD_GRAVITY, max_relative = 1e-12);
    assert_eq!(third.channel(Channel::Current).unwrap()[0], -500.0, "the log's own column wins");
    assert_eq!(first.channel(Channel::Current).unwrap()[0], AMPLITUDE);
}

#[test]
fn a_steady_table_needs_no_time() {
    let table =
        BENCH.replace("\"dynamometer\"", "\"steady_table\"").replace("time = { name = \"t_ms\", unit = \"ms\" }\n", "");
    let bench = good(&table, LOG);
    assert_eq!(bench.logs[0].time, [0.0, 1.0, 2.0, 3.0]);
    refused(
        &spoilt("time = { name = \"t_ms\", unit = \"ms\" }\n", ""),
        LOG.as_bytes(),
        &["kind `dynamometer` needs `time`"],
    );
}

#[test]
fn selections_by_several_values_and_by_size() {
    let with = |select: &str| format!("{BENCH}select = {select}\n");
    let log = "t_ms,i,w,tau,run,n\n0,1,1,1,a,1\n1,1,1,1,b,2.0\n2,1,1,1,c,3\n3,1,1,1,a,4\n4,1,1,1,b,5\n5,1,1,1,c,-6\n";
    let times =
        |select: &str| good(&with(select), log).logs[0].time.iter().map(|t| (t * 1000.0).round()).collect::<Vec<_>>();
    assert_eq!(times("{ column = \"run\", equals = [\"a\", \"c\"] }"), [0.0, 2.0, 3.0, 5.0]);
    assert_eq!(times("{ column = \"n\", equals = [2, 3.0, 5] }"), [1.0, 2.0, 4.0]);
    assert_eq!(times("{ column = \"n\", min = 2, max = 4 }"), [1.0, 2.0, 3.0]);
    assert_eq!(
        times("[{ column = \"n\", min = -10 }, { column = \"run\", equals = [\"b\", \"c\"] }]"),
        [1.0, 2.0, 4.0, 5.0]
    );
    refused(
        &with("{ column = \"run\", equals = \"d\" }"),
        log.as_bytes(),
        &["no row of", "values of `run`: a, b, c", "bench.toml:13"],
    );
    refused(
        &with("{ column = \"runs\", equals = \"a\" }"),
        log.as_bytes(),
        &["there is no column `runs`", "did you mean `run`?"],
    );
    refused(&with("{ column = \"run\" }"), log.as_bytes(), &["`equals` of [select] is missing"]);
    refused(&with("{ column = \"run\", min = 3 }"), log.as_bytes(), &["selects by size", "`a`"]);
    let both = format!("{BENCH}use = \"held_out\"\n[[log]]\nfile = \"log.csv\"\n");
    refused(&both, log.as_bytes(), &["6 rows of", "both to fit and held out"]);
}

/// Rows that count twice make every ± too small; two parts of one file are two logs.
#[test]
fn a_log_is_read_once() {
    let again = |more: &str| format!("{BENCH}[[log]]\nfile = \"log.csv\"\n{more}");
    refused(&again(""), LOG.as_bytes(), &["log `log.csv` is here twice, with the same rows", "bench.toml:14:8"]);
    let parts = again("select = { column = \"t_ms\", max = 20 }\n");
    assert_eq!(good(&parts, LOG).logs.len(), 2);
}

#[test]
fn what_is_missing_or_repeated_is_counted() {
    let bench = good(
        BENCH,
        "t_ms,i,w,tau\n0,1,1,1\n0,9,9,9\n1,,nan,1\n2,NaN,inf,1\n,1,1,1\n2,7,7,7\n3,1,1,-Infinity\n4,1,1,1\n",
    );
    let log = &bench.logs[0];
    close(&log.time, &[0.0, 0.001, 0.002, 0.003, 0.004]);
    let current = channel(&bench, Channel::Current);
    assert!(current[1].is_nan() && current[2].is_nan() && current[3].is_finite());
    assert_eq!(
        log.remarks,
        [
            "2 rows with a repeated time were left out",
            "1 row without time was left out",
            "2 of 5 cells of `current` are missing",
            "2 of 5 cells of `velocity` are missing",
            "1 of 5 cells of `torque` are missing",
        ]
    );
}

#[test]
fn hostile_logs() {
    let bad = |log: &str, parts: &[&str]| refused(BENCH, log.as_bytes(), parts);
    // Text in the middle, with line and column although comments and blank lines stand before it.
    bad(
        "# c\nt_ms,i,w,tau\n0,1,1,1\n# c\n\n1,2, ERR ,1\n2,1,1,1\n",
        &["`w` is not a number: `ERR`", "log.csv:6:6", "1,2, ERR ,1"],
    );
    bad("t_ms,i,w,tau\n0,1 A,1,1\n", &["`i` is not a number: `1 A`", "a bare number; its unit is `unit`"]);
    bad("t_ms,i,w,tau\n0,\"1,5\",1,1\n", &["decimal point, not a comma"]);
    bad("t_ms,i,w,tau\n0,1,5,1,1,0\n", &["this row has 6 cells, the header has 4", "decimal point, not a comma"]);
    bad("t_ms,i,w,tau\n0,1,1,1\n1,1\n", &["this row has 2 cells, the header has 4", "cut off", "log.csv:3"]);
    bad("t_ms;i;w;tau\n0;1;1;1\n", &["separated by semicolons", "log.csv:1"]);
    bad("t_ms\ti\tw\ttau\n0\t1\t1\t1\n", &["separated by tabs"]);
    bad("", &["the file is empty"]);
    bad("# nothing\n\n", &["the file is empty"]);
    bad("t_ms,i,w,tau\n", &["nothing can be learnt from 0 rows"]);
    bad("t_ms,i,w,tau\n0,1,1,1\n1,1,1,1\n", &["nothing can be learnt from 2 rows"]);
    bad(
        "t_ms,i,w,tau\n0,1,1,1\n0,1,1,1\n0,1,1,1\n0,1,1,1\n",
        &["nothing can be learnt from 1 row", "3 rows repeat their time"],
    );
    bad(
        "t_ms,i,w,tau\n0,1,1,1\n2,1,1,1\n1,1,1,1\n",
        &["time goes backwards", "from 0.002 s to 0.001 s", "log.csv:4:1", "select ="],
    );
    bad("t_ms,i,w,tau,w\n0,1,1,1,1\n", &["duplicate column `w`", "log.csv:1:14"]);
    bad("t_ms,i,omega,tau\n0,1,1,1\n", &["there is no column `w`", "its columns: t_ms, i, omega, tau", "bench.toml"]);
    bad("t_ms,i,w,taus\n0,1,1,1\n", &["there is no column `tau`", "did you mean `taus`?"]);
    bad("t_ms,i,w,tau\n0,1,1,1e300\n1,1,1,1\n", &["`tau` is out of range"]);
    let empty_channel = "t_ms,i,w,tau\n0,1,1,\n1,1,1,nan\n2,1,1,\n";
    bad(empty_channel, &["kind `dynamometer` needs `torque`", "none of its 3 cells holds a number"]);
    // Every mistake of the file in one report.
    bad(
        "t_ms,i,w,tau\n0,a,1,1\n1,b,1,1\n2,1,1\n",
        &["`a`", "`b`", "has 3 cells", "log.csv:2:3", "log.csv:3:3", "log.csv:4:1"],
    );
    // A column that no log uses may hold anything, twice.
    good(BENCH, "t_ms,i,w,tau,x,x\n0,1,1,1,ERR,\n1,1,1,1,,\n2,1,1,1,,\n");
    // Rows that are not selected may be broken.
    good(
        &format!("{BENCH}select = {{ column = \"x\", equals = \"a\" }}"),
        "t_ms,i,w,tau,x\n0,1,1,1,a\n9,E,1,1,b\n1,1,1,1,a\n2,1,1,1,a\n",
    );
    refused(BENCH, b"\xff\xfet\x00_\x00", &["not UTF-8"]);
}

#[test]
fn ten_megabytes_of_noise() {
    use rand::{Rng, SeedableRng};
    let mut noise = vec![0_u8; 10_000_000];
    rand_pcg::Pcg64::seed_from_u64(7).fill_bytes(&mut noise);
    let report = outcome(BENCH, &[("log.csv", &noise)]).expect_err("noise");
    assert!(report.len() < 100_000 && report.contains("log.csv"), "{}", report.len());
    // The same behind a good header, and as one line of digits.
    let headed = [b"t_ms,i,w,tau\n0,1,1,1\n".as_slice(), &noise].concat();
    let report = outcome(BENCH, &[("log.csv", &headed)]).expect_err("noise");
    assert!(report.len() < 2_000_000 && report.contains("the header has 4"), "{}", report.len());
    let digits: Vec<u8> = noise.iter().map(|b| b'0' + b % 10).collect();
    let headed = [b"t_ms,i,w,tau\n".as_slice(), &digits].concat();
    let report = outcome(BENCH, &[("log.csv", &headed)]).expect_err("noise");
    assert!(report.len() < 100_000 && report.contains("this row has 1 cells"), "{report:.300}");
}

#[test]
fn mistakes_of_the_bench_file() {
    let bad = |bench: &str, parts: &[&str]| refused(bench, LOG.as_bytes(), parts);
    bad(&spoilt("\"dynamometer\"", "\"dynamo\""), &["`kind` cannot be `dynamo`", "dynamometer"]);
    bad(&spoilt("kind = \"dynamometer\"\n", ""), &["`kind` of [[log]] is missing"]);
    bad(&spoilt("\"dynamometer\"", "\"rotor\""), &["a log cannot be of kind `rotor`"]);
    bad(&spoilt("\"dynamometer\"", "\"linear\""), &["`mass` of [actuator] is missing", "a linear axis has no motor"]);
    bad(
        &spoilt("log.csv", "lock.csv"),
        &["log `lock.csv`: cannot read the file: there is no such file", "there is `log.csv`", "bench.toml:12"],
    );
    bad(&spoilt("log.csv", "."), &["this is a folder"]);
    bad(&spoilt("[[log]]\nfile = \"log.csv\"\n", ""), &["`log` is missing"]);
    bad(&spoilt("torque =", "torqe ="), &["unknown key `torqe`", "did you mean `torque`?", "needs `torque`"]);
    bad(
        &spoilt("\"rpm\"", "\"N*m\""),
        &["`unit` of `velocity`: `N*m` is not a unit of speed", "unit = \"rpm\"", "bench.toml:8"],
    );
    bad(&spoilt(", unit = \"rpm\"", ""), &["the column of `velocity` has no unit"]);
    bad(&spoilt("sign = -1", "sign = -2"), &["`sign` of `torque` cannot be -2", "`scale`"]);
    bad(&spoilt("sign = -1", "scale = 0"), &["`scale` of `torque` is zero"]);
    bad(&spoilt("side = \"motor\"", "side = \"input\""), &["cannot be `input`", "motor, output"]);
    bad(&spoilt("name = \"i\",", ""), &["`name` of [current] is missing"]);
    bad(&spoilt("torque = {", "force = { name = \"tau\", unit = \"N\" }\ntorque = {"), &["only a linear axis"]);
    bad(&spoilt("[columns]", "[load]\nmass = \"1 kg\"\n[columns]"), &["`distance` of [load] is missing"]);
    bad(&spoilt("[columns]", "[load]\n[pendulum]\n[columns]"), &["`load` or `pendulum`, not both"]);
    bad(&spoilt("[columns]", "[controller]\nlimit = 1\n[columns]"), &["`gain` of [controller] is missing"]);
    bad(&spoilt("gears.csv", "gear.csv"), &["gear.csv", "there is `gears.csv`"]);
    bad(&format!("{BENCH}use = \"train\""), &["`use` of [[log]] cannot be `train`"]);
    // All at once, those of the log among them.
    let report = outcome(&spoilt("sign = -1", "sgn = -1").replace("\"w\"", "\"v\""), &[("log.csv", LOG.as_bytes())])
        .unwrap_err();
    assert!(report.contains("unknown key `sgn`") && report.contains("there is no column `v`"), "{report}");
}

#[test]
fn a_long_log_with_many_columns() {
    // Twenty columns, of which four are read: the rest may be anything.
    let mut log = String::from("t_ms,i,w,tau");
    (4..20).for_each(|k| write!(log, ",x{k}").unwrap());
    log.push('\n');
    for row in 0..50_000 {
        write!(log, "{row},{},{},1", f64::from(row) * 0.5, -row).unwrap();
        log.push_str(&",text".repeat(16));
        log.push('\n');
    }
    let bench = good(BENCH, &log);
    assert_eq!(bench.logs[0].len(), 50_000);
    assert_relative_eq!(channel(&bench, Channel::Current)[49_999], 24_999.5 * AMPLITUDE, max_relative = 1e-12);
}

/// Reads a bench of real data, or says that the data are not there.
fn real(name: &str) -> Option<Bench> {
    let bench = |_: &str, path: &Path| {
        read(path).unwrap_or_else(|errors| panic!("{}", errors.iter().map(ToString::to_string).collect::<String>()))
    };
    on_each(&[name], bench).pop()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The mean of a channel of a log, against a sum over the file that the library had no part in.
fn has_mean(bench: &Bench, log: usize, channel: Channel, expected: f64) {
    let values = bench.logs[log].channel(channel).unwrap_or_else(|| panic!("no {channel:?}"));
    assert_relative_eq!(mean(values), expected, max_relative = 1e-9);
}

#[test]
fn ri50_drag() {
    let Some(bench) = real("ri50_drag") else { return };
    assert_eq!(bench.logs.iter().map(|l| l.len()).collect::<Vec<_>>(), [4741]);
    assert_eq!(bench.logs[0].kind, BenchKind::Backdrive);
    // Motor 2 is under test: what it delivers is what the sensor has, negative.
    has_mean(&bench, 0, Channel::Torque, -0.05026956338325265);
    has_mean(&bench, 0, Channel::OutputVelocity, 60.23233267267618);
    has_mean(&bench, 0, Channel::WindingTemperature, 273.15 + 24.449763616114623);
}

#[test]
fn ri50_slow_turns() {
    let Some(bench) = real("ri50_slow") else { return };
    assert_eq!(bench.logs.iter().map(|l| l.len()).collect::<Vec<_>>(), [4924, 1666]);
    has_mean(&bench, 0, Channel::Torque, -0.01935371405361495);
    has_mean(&bench, 1, Channel::Torque, -0.010714282833133257);
    assert_eq!((bench.logs[0].usage, bench.logs[1].usage), (Use::Fit, Use::HeldOut));
}

#[test]
fn ri50_stall() {
    let Some(bench) = real("ri50_stall") else { return };
    assert_eq!(bench.logs.iter().map(|l| l.len()).collect::<Vec<_>>(), [3935, 4146, 7268, 9785, 2244, 1636]);
    has_mean(&bench, 0, Channel::Torque, 0.3432291296060991);
    has_mean(&bench, 1, Channel::Torque, -0.3122366136034732);
    has_mean(&bench, 2, Channel::Torque, 0.19084866882223445);
    has_mean(&bench, 3, Channel::Torque, -0.04853225600408789);
    has_mean(&bench, 4, Channel::Torque, 0.23110873440285207);
    has_mean(&bench, 5, Channel::Torque, 0.36060635696821514);
    assert!(bench.logs.iter().all(|l| l.kind == BenchKind::Stall && l.remarks.is_empty()));
}

#[test]
fn emps() {
    let Some(bench) = real("emps") else { return };
    assert_eq!(bench.logs.iter().map(|l| l.len()).collect::<Vec<_>>(), [24841, 24841]);
    has_mean(&bench, 0, Channel::Current, -3.2438308777980516);
    has_mean(&bench, 0, Channel::OutputPosition, 0.1237644152047019);
    has_mean(&bench, 1, Channel::Current, -3.2918781246349784);
    has_mean(&bench, 1, Channel::OutputPosition, 0.12382981835427888);
    assert_eq!((bench.declared.mass, bench.declared.force_gain), (Some(95.1089), 1.0));
}

#[test]
fn d5065() {
    let Some(bench) = real("d5065") else { return };
    assert_eq!(bench.logs.iter().map(|l| l.len()).collect::<Vec<_>>(), [261, 81]);
    has_mean(&bench, 0, Channel::Torque, 0.7301578544061302);
    has_mean(&bench, 0, Channel::Current, AMPLITUDE * 25.986025148773944);
    has_mean(&bench, 1, Channel::Torque, 0.729779012345679);
    has_mean(&bench, 1, Channel::Current, AMPLITUDE * 25.97923611728395);
    assert_eq!(bench.logs[1].time.last(), Some(&80.0));
}

#[test]
fn xl330() {
    let Some(bench) = real("xl330") else { return };
    assert_eq!(
        bench.logs.iter().map(|l| l.len()).collect::<Vec<_>>(),
        [1124, 1510, 1116, 1116, 1116, 1513, 1120, 1110, 1125, 1499, 1123, 1131, 1117, 1509, 1113, 1110]
    );
    has_mean(&bench, 0, Channel::Duty, 0.005721092948911273);
    has_mean(&bench, 0, Channel::OutputPosition, -0.006728225132117441);
    has_mean(&bench, 11, Channel::Duty, 0.042704071692967076);
    has_mean(&bench, 11, Channel::OutputPosition, 0.07236021982581786);
    // The firmware's law, which the bench file declares, gives the duty cycle that was logged.
    for log in &bench.logs {
        let controller = log.controller.unwrap();
        let (duty, goal) = (log.channel(Channel::Duty).unwrap(), log.channel(Channel::Goal).unwrap());
        let position = log.channel(Channel::OutputPosition).unwrap();
        let errors: Vec<f64> = (0..log.len())
            .filter(|k| duty[*k] != 0.0)
            .map(|k| {
                let law = (controller.gain * (goal[k] - position[k])).clamp(-controller.limit, controller.limit);
                (duty[k] - law).powi(2)
            })
            .collect();
        assert!(mean(&errors).sqrt() < 0.03, "{}: {}", log.name, mean(&errors).sqrt());
        assert_relative_eq!(log.load.gravity_torque.unwrap(), 0.49 * STANDARD_GRAVITY * 0.1, max_relative = 1e-12);
    }
    assert_eq!(bench.logs.iter().filter(|l| l.usage == Use::HeldOut).count(), 4);
}
