//! What `identify` must not say: logs of a machine that is written here, with nothing of the library in it.
//!
//! A geared motor behind a torque sensor, or with a known inertia at its output. Each sentence that claims something has a
//! log here on which it would be false.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::fs;
use std::process::Command;

use serde_json::Value;

/// N, K_T \[N·m/A\], J \[kg·m²\] of the machine, as the row has them.
const MACHINE: (f64, f64, f64) = (9.0, 0.12, 3e-5);
const RATE: f64 = 500.0;
const SAMPLES: usize = 4000;
/// Inertia at the output where there is no sensor \[kg·m²\].
const LOAD: f64 = 0.05;

/// A generator of numbers between −1 and 1, and of nearly normal ones.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() / 2.0
    }
}

/// Two equal lags in series: everything above their corner \[Hz\] falls off.
fn lagged(values: &[f64], corner: f64) -> Vec<f64> {
    let keep = (-TAU * corner / RATE).exp();
    let (mut a, mut b) = (0.0, 0.0);
    let low = values.iter().map(|v| {
        a = v + (a - v) * keep;
        b = a + (b - a) * keep;
        b
    });
    scaled(low.collect())
}

/// To a deviation of one.
fn scaled(values: Vec<f64>) -> Vec<f64> {
    let rms = (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
    values.into_iter().map(|v| v / rms).collect()
}

#[derive(Clone, Copy, PartialEq)]
enum Colour {
    White,
    Blue,
    /// Behind an anti-alias filter.
    Filtered,
    /// Slow beside fast.
    Red,
}

#[derive(Clone, Copy)]
struct Bench {
    /// Torque sensor at the output, or a known inertia.
    sensor: bool,
    /// Side of the gear where motion is measured.
    output_side: bool,
    colour: Colour,
    /// Deviation of the noise at the output \[N·m\].
    noise: f64,
    /// Deviation of what no effect is: slow and random \[N·m\].
    disturbance: f64,
    /// Rows from one fresh value to the next.
    held: usize,
    /// Last digit of the target \[N·m\].
    digit: f64,
    /// Share of the time that the machine stands, at the start.
    stands: f64,
    /// Saturation current \[A\], ripple of order 6 and loss of K_T per kelvin.
    saturation: f64,
    ripple: f64,
    magnet: f64,
    /// Coulomb friction \[N·m\].
    coulomb: f64,
    /// Deviation of the noise of the speed, at the motor \[rad/s\].
    shake: f64,
    seed: u64,
}

const CLEAN: Bench = Bench {
    sensor: true,
    output_side: false,
    colour: Colour::White,
    noise: 0.05,
    disturbance: 0.0,
    held: 1,
    digit: 0.0,
    stands: 0.3,
    saturation: f64::INFINITY,
    ripple: 0.0,
    magnet: 0.0,
    coulomb: 0.0,
    shake: 0.0,
    seed: 1,
};

/// A sum of sines with its slope and its integral.
struct Motion(Vec<[f64; 3]>);

impl Motion {
    fn new(frequencies: &[f64], size: f64, random: &mut Random) -> Motion {
        let each = size / (frequencies.len() as f64).sqrt();
        Motion(
            frequencies.iter().map(|f| [each * (0.75 + 0.25 * random.next()), TAU * f, 3.0 * random.next()]).collect(),
        )
    }

    fn at(&self, t: f64) -> [f64; 3] {
        let sum = |f: &dyn Fn(&[f64; 3]) -> f64| self.0.iter().map(f).sum::<f64>();
        [
            sum(&|[a, w, p]| a * (w * t + p).sin()),
            sum(&|[a, w, p]| a * w * (w * t + p).cos()),
            sum(&|[a, w, p]| -a / w * (w * t + p).cos()),
        ]
    }
}

impl Bench {
    /// The motor's torque at a current \[N·m\].
    fn torque(&self, i: f64, angle: f64, rise: f64) -> f64 {
        let iron = if self.saturation.is_finite() { self.saturation * (i / self.saturation).tanh() } else { i };
        MACHINE.1 * iron * (1.0 + self.ripple * (6.0 * angle).cos()) * (1.0 - self.magnet * rise)
    }

    /// The current that makes a torque.
    fn current(&self, torque: f64, angle: f64, rise: f64) -> f64 {
        (0..200).fold(torque / MACHINE.1, |i, _| i + 0.7 * (torque - self.torque(i, angle, rise)) / MACHINE.1)
    }

    /// Speed, acceleration and angle: standing first, then within half a second under way.
    fn motion(&self, speed: &Motion, t: f64) -> [f64; 3] {
        let [w, a, q] = speed.at(t);
        let since = (t - self.stands * SAMPLES as f64 / RATE) / 0.5;
        if since <= 0.0 && self.stands > 0.0 {
            return [0.0, 0.0, 1.0];
        }
        if since >= 1.0 || self.stands == 0.0 {
            return [w, a, q];
        }
        let phase = 0.5 * TAU * since;
        let (share, rate) = (0.5 - 0.5 * phase.cos(), 0.5 * TAU * phase.sin());
        [share * w, share * a + rate * w, q]
    }

    fn noise(&self, random: &mut Random) -> Vec<f64> {
        let white: Vec<f64> = (0..=SAMPLES).map(|_| random.normal()).collect();
        match self.colour {
            Colour::White => scaled(white),
            Colour::Blue => scaled(white.windows(2).map(|w| w[1] - w[0]).collect()),
            Colour::Filtered => lagged(&white, 80.0),
            Colour::Red => {
                let slow = lagged(&white, 6.0);
                scaled(slow.iter().map(|s| 2.0 * s + random.normal()).collect())
            }
        }
    }

    fn log(&self, random: &mut Random) -> String {
        let (n, _, inertia) = MACHINE;
        let current = Motion::new(&[0.7, 1.9, 3.1, 4.7, 7.3], 6.0, random);
        let speed = Motion::new(&[0.23, 0.61, 1.3, 2.1], 90.0, random);
        let noise = self.noise(random);
        let white: Vec<f64> = (0..SAMPLES).map(|_| random.normal()).collect();
        let slow = lagged(&white, 4.0);
        let mut text = String::from("t,i,w,q,tau,temp\n");
        let mut held = 0.0;
        for k in 0..SAMPLES {
            let t = k as f64 / RATE;
            let [w, a, q] = self.motion(&speed, t);
            let rise = 40.0 * (1.0 - (-t / 4.0).exp());
            let beside = self.noise * noise[k] + self.disturbance * slow[k];
            let friction = self.coulomb * if w == 0.0 { 0.0 } else { w.signum() };
            let (mut i, mut tau) = (current.at(t)[0], 0.0);
            let target = if self.sensor {
                tau = n * (self.torque(i, q, rise) - inertia * a - friction) + beside;
                &mut tau
            } else {
                i = self.current((inertia + LOAD / n / n) * a + friction, q, rise) + beside / n / MACHINE.1;
                &mut i
            };
            if self.digit > 0.0 {
                *target = (*target / self.digit).round() * self.digit;
            }
            if k % self.held == 0 {
                held = *target;
            }
            *target = held;
            let side = if self.output_side { 1.0 / n } else { 1.0 };
            let speed = (w + self.shake * random.normal()) * side;
            writeln!(text, "{t:.4},{i:?},{speed:?},{:?},{tau:?},{:.2}", q * side, 25.0 + rise).unwrap();
        }
        text
    }

    /// Writes the bench and gives its folder.
    fn write(&self) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
        let (n, constant, inertia) = MACHINE;
        put(
            "motors.csv",
            &format!(
                "id,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],source,source_kind\n\
                 m,q_axis,q_axis,0.7,{constant},{inertia},-,derived\n"
            ),
        );
        let side = if self.output_side { "output" } else { "motor" };
        let (kind, load, sensor) = if self.sensor {
            ("dynamometer", String::new(), "torque = { name = \"tau\", unit = \"N*m\", side = \"output\" }\n")
        } else {
            ("free", format!("load = {{ inertia = \"{LOAD} kg*m^2\" }}\n"), "")
        };
        let mut bench = format!(
            "catalog = [\"motors.csv\"]\nactuator = {{ motor = \"m\", ratio = {n} }}\nkind = \"{kind}\"\n{load}[columns]\n\
             time = {{ name = \"t\", unit = \"s\" }}\ncurrent = {{ name = \"i\", unit = \"A\", convention = \"q_axis\" }}\n\
             velocity = {{ name = \"w\", unit = \"rad/s\", side = \"{side}\" }}\n\
             position = {{ name = \"q\", unit = \"rad\", side = \"{side}\" }}\n\
             winding_temperature = {{ name = \"temp\", unit = \"degC\" }}\n{sensor}"
        );
        let mut random = Random(self.seed);
        for log in 0..3 {
            put(&format!("{log}.csv"), &self.log(&mut random));
            let usage = if log == 2 { "held_out" } else { "fit" };
            writeln!(bench, "[[log]]\nfile = \"{log}.csv\"\nuse = \"{usage}\"").unwrap();
        }
        put("bench.toml", &bench);
        folder
    }

    /// What `identify --json` says, and the text and the page where they are asked for.
    fn told(&self, band: Option<&str>) -> Value {
        let folder = self.write();
        let mut arguments = vec!["--json"];
        arguments.extend(band.iter().flat_map(|b| ["--band", b]));
        let output = run(&folder, &arguments);
        serde_json::from_str(&output).unwrap_or_else(|e| panic!("{e}: {output}"))
    }
}

fn run(folder: &tempfile::TempDir, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_gearwise"))
        .args(["identify", "bench.toml"])
        .args(arguments)
        .current_dir(folder.path())
        .output()
        .unwrap();
    let told = String::from_utf8(output.stdout).unwrap();
    // Where nothing can be learnt the exit status says so too.
    let expected = i32::from(told.contains("Nothing can be learnt"));
    assert_eq!(output.status.code(), Some(expected), "{}", String::from_utf8_lossy(&output.stderr));
    told
}

fn effects(told: &Value) -> Vec<&str> {
    told["effects"].as_array().unwrap().iter().map(|e| e["name"].as_str().unwrap()).collect()
}

fn refusal<'a>(told: &'a Value, name: &str) -> &'a Value {
    let list = told["refused"].as_array().unwrap();
    list.iter().find(|r| r["name"] == name).unwrap_or_else(|| panic!("{name} is not refused: {list:?}"))
}

fn claims_that_nothing_is_missing(told: &Value) -> bool {
    told["verdict"] == "nothing_missing" || told["sentence"].as_str().unwrap().contains("Nothing is missing")
}

/// The second derivative of a sensor's noise explains a good part of that noise: a compliance is not read out of it.
#[test]
fn a_sensor_does_not_explain_itself_by_its_second_derivative() {
    for (colour, band) in [(Colour::White, "100 Hz"), (Colour::Filtered, "100 Hz"), (Colour::Blue, "100 Hz")] {
        let told = Bench { output_side: true, colour, ..CLEAN }.told(Some(band));
        assert!(!effects(&told).contains(&"gear_compliance"), "{band}: {}", told["sentence"]);
        let refused = refusal(&told, "gear_compliance");
        assert_eq!(refused["made_of_the_response"], true);
        assert_eq!(refused["shown_by"], "positions on both sides of the gear");
    }
}

/// Nor does a known load, whose acceleration is noisy: that noise stands beside the current, and its second derivative
/// explains it.
#[test]
fn a_known_load_does_not_explain_its_own_noise() {
    let told = Bench { sensor: false, output_side: true, noise: 0.02, shake: 0.05, ..CLEAN }.told(Some("40 Hz"));
    assert!(!effects(&told).contains(&"gear_compliance"), "{}", told["sentence"]);
    assert_eq!(refusal(&told, "gear_compliance")["shown_by"], "positions on both sides of the gear");
}

/// Without a torque sensor the current is the response, and what is proportional to it explains anything: true effects of
/// that kind are said to be out of sight, with what would show them, in text, JSON and page.
#[test]
fn a_current_does_not_explain_itself() {
    let free = Bench { sensor: false, noise: 0.02, ..CLEAN };
    for (name, bench) in [
        ("torque_constant_saturation", Bench { saturation: 8.0, ..free }),
        ("torque_ripple", Bench { ripple: 0.05, ..free }),
        ("torque_constant_temperature", Bench { magnet: 1e-3, ..free }),
        ("torque_constant_saturation", Bench { coulomb: 0.02, ..free }),
    ] {
        let told = bench.told(None);
        assert!(!effects(&told).contains(&name), "{name}: {}", told["sentence"]);
        assert!(!claims_that_nothing_is_missing(&told), "{name}: {}", told["sentence"]);
        let refused = refusal(&told, name);
        assert_eq!(
            (refused["made_of_the_response"].as_bool(), refused["equation"].as_str()),
            (Some(true), Some("drive_torque"))
        );
        assert_eq!(refused["shown_by"], "a torque sensor at the output");
        let words = "regressor is made of the response";
        assert!(
            refused["reason"].as_str().unwrap().starts_with("not identifiable on this bench: its regressor is made")
        );
        let sentence = told["sentence"].as_str().unwrap();
        assert!(sentence.contains(words) && sentence.contains(&name.replace('_', " ")), "{sentence}");
        if bench.coulomb > 0.0 {
            assert_eq!(effects(&told), ["coulomb_friction"]);
            let folder = bench.write();
            let text = run(&folder, &["--html", "page.html"]);
            let page = fs::read_to_string(folder.path().join("page.html")).unwrap();
            let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
            for whole in [plain(&text), plain(&page)] {
                assert!(
                    whole.contains("not identifiable on this bench: its regressor is made of the response"),
                    "{whole}"
                );
                assert!(whole.contains("a torque sensor at the output would show"), "{whole}");
            }
        }
    }
    // With a sensor the same iron is found.
    let seen = Bench { saturation: 8.0, ..CLEAN }.told(None);
    assert_eq!(effects(&seen), ["torque_constant_saturation"], "{}", seen["sentence"]);
}

/// It can be said: white noise, and nothing else.
#[test]
fn nothing_is_missing_where_only_white_noise_is_left() {
    let told = CLEAN.told(None);
    assert_eq!(told["verdict"], "nothing_missing", "{told:#}");
    let evidence = &told["evidence"];
    assert!(evidence["times_the_noise"].as_f64().unwrap() < 1.15);
    assert!(evidence["refused_together"]["at_most_percent"].as_f64().unwrap() <= 3.0);
    // The noise that was put in, as much as passes the band: 2 f/f_s (1 − 1/8) (π/8)/sin(π/8).
    let band = told["band_hz"].as_f64().unwrap();
    let passes = 2.0 * band / RATE * 0.875 * (TAU / 16.0) / (TAU / 16.0).sin();
    let floor = told["noise_floor"].as_f64().unwrap();
    assert!((floor / (CLEAN.noise * passes.sqrt()) - 1.0).abs() < 0.15, "{floor} {band}");
}

/// It must not be said, though the error of the final model is all that the model can do.
#[test]
fn nothing_is_missing_is_not_said_of_what_was_not_shown() {
    // Of white noise this much passes a tenth of the sampling rate.
    let passes = (0.2 * 0.898_f64).sqrt();
    for (what, band, bench) in [
        // Slow, random, on no list: half of the error.
        ("disturbance", Some("50 Hz"), Bench { disturbance: 0.62 * passes * CLEAN.noise, stands: 0.0, ..CLEAN }),
        ("slow noise", None, Bench { colour: Colour::Red, stands: 0.0, ..CLEAN }),
        ("blue noise", None, Bench { colour: Colour::Blue, stands: 0.0, ..CLEAN }),
        ("a held channel", None, Bench { held: 15, ..CLEAN }),
        ("few digits", None, Bench { digit: 1.0, noise: 0.01, ..CLEAN }),
    ] {
        let told = bench.told(band);
        assert!(!claims_that_nothing_is_missing(&told), "{what}: {}", told["sentence"]);
        let text = told["sentence"].as_str().unwrap();
        assert!(!text.contains("down to") && !text.contains("noise floor"), "{text}");
    }
}

/// An effect that is too weak for its name is told as the strongest that was refused, with how sure it is.
#[test]
fn the_strongest_refusal_is_told() {
    let told = Bench { coulomb: 0.0006, seed: 5, ..CLEAN }.told(None);
    let list = told["evidence"]["refused"].as_array().unwrap();
    let falls: Vec<f64> = list.iter().map(|r| r["error_falls_percent"].as_f64().unwrap()).collect();
    assert!(falls.windows(2).all(|w| w[0] >= w[1]), "{falls:?}");
    assert!(list.iter().all(|r| r["at_most_percent"].as_f64() >= r["error_falls_percent"].as_f64()));
    assert!(effects(&told).is_empty(), "{}", told["sentence"]);
    let text = run(&Bench { coulomb: 0.0006, seed: 5, ..CLEAN }.write(), &[]);
    let strongest = format!("strongest of what was refused: {}", list[0]["name"].as_str().unwrap());
    let plain = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(plain.contains(&strongest) && plain.contains("standard errors)"), "{plain}");
}

/// A sensor that is stuck shows nothing, and excludes nothing.
#[test]
fn a_stuck_sensor_excludes_nothing() {
    let told = Bench { digit: 1e6, ..CLEAN }.told(None);
    assert_eq!(told["verdict"], "not_resolved", "{}", told["sentence"]);
    assert!(!claims_that_nothing_is_missing(&told));
}
