//! What drives a machine between the rows of its log: held, as a digital drive holds a command, or going on, as what an
//! instrument reads.
//!
//! The servo here is this file's own, integrated by Runge and Kutta's method; it shares no line with the library or with
//! the suite's other simulator.

use std::fmt::Write as _;
use std::path::Path;

use gearwise::measured::identify::Report;
use gearwise::measured::read::read;
use gearwise::measured::simulate::{Input, Machine, State, Track, identify_servo};
use gearwise::measured::{Bench, Channel};

/// A machine that is an inertia alone, driven by a current.
fn rotor() -> Machine {
    Machine {
        ratio: 1.0,
        torque_constant: 2.0,
        resistance: 1.0,
        back_emf: 0.0,
        damping: 0.0,
        inertia: 0.5,
        lag: 0.0,
        terms: Vec::new(),
    }
}

fn driven(currents: &[f64], step: f64, held: bool) -> Vec<f64> {
    let time: Vec<f64> = (0..currents.len()).map(|k| k as f64 * step).collect();
    let track = Track {
        name: "rotor".into(),
        fits: true,
        position: vec![0.0; time.len()],
        input: Input::Current(currents.to_vec()),
        held,
        supply: Vec::new(),
        volts_per_duty: 1.0,
        off: Vec::new(),
        load_inertia: 0.0,
        load_gravity: 0.0,
        winding: Vec::new(),
        housing: Vec::new(),
        starts: vec![(0, State { position: 0.0, speed: 0.0 })],
        time,
    };
    track.simulate(&rotor())
}

/// On paper: a held current makes a parabola from row to row, one on a line a cubic.
#[test]
fn a_held_current_and_one_on_a_line_as_on_paper() {
    let (step, currents) = (0.01, [1.0, -2.0, 0.5, 3.0, 3.0, -1.0, 0.0, 2.0]);
    let acceleration = |k: usize| 2.0 * currents[k] / 0.5;
    let (mut held, mut line) = (vec![(0.0, 0.0)], vec![(0.0, 0.0)]);
    for k in 0..currents.len() - 1 {
        let (a, b) = (acceleration(k), acceleration(k + 1));
        let (q, w): (f64, f64) = held[k];
        held.push((q + w * step + 0.5 * a * step * step, w + a * step));
        let (q, w): (f64, f64) = line[k];
        line.push((q + w * step + (2.0 * a + b) * step * step / 6.0, w + 0.5 * (a + b) * step));
    }
    let (simulated, between) = (driven(&currents, step, true), driven(&currents, step, false));
    for k in 0..currents.len() {
        assert!((simulated[k] - held[k].0).abs() < 1e-12, "row {k}: {} against {}", simulated[k], held[k].0);
        // A cubic in parabolas of h = 0.5 ms with its acceleration in the middle: each is h³/12 of its slope ahead.
        let ahead: f64 = (0..k).map(|j| (acceleration(j + 1) - acceleration(j)) * 5e-4_f64.powi(2) / 12.0).sum();
        assert!((between[k] - ahead - line[k].0).abs() < 1e-12, "row {k}: {} against {}", between[k], line[k].0);
    }
}

/// A late command arrives late by that much, whether it falls on a row or between rows.
#[test]
fn a_late_command_is_the_same_parabola_later() {
    let (step, lag) = (0.01, 0.0137);
    // A step at the fourth row.
    let currents: Vec<f64> = (0..60).map(|k| if k >= 4 { 1.0 } else { 0.0 }).collect();
    let time: Vec<f64> = (0..currents.len()).map(|k| k as f64 * step).collect();
    let track = Track {
        name: "rotor".into(),
        fits: true,
        position: vec![0.0; time.len()],
        input: Input::Current(currents),
        held: true,
        supply: Vec::new(),
        volts_per_duty: 1.0,
        off: Vec::new(),
        load_inertia: 0.0,
        load_gravity: 0.0,
        winding: Vec::new(),
        housing: Vec::new(),
        starts: vec![(0, State { position: 0.0, speed: 0.0 })],
        time: time.clone(),
    };
    let simulated = track.simulate(&Machine { lag, ..rotor() });
    for (t, q) in time.iter().zip(&simulated) {
        let on = (t - 0.04 - lag).max(0.0);
        // The edge is spread over one internal step of 0.5 ms, its centre kept.
        assert!((q - 0.5 * 4.0 * on * on).abs() < 4.0 * 5e-4_f64.powi(2), "{t}: {q}");
    }
}

/// Where the duty comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Law {
    /// A loop at the rate of the rows that follows steps; its duty is held.
    Steps,
    /// The same, four times as stiff, after a smooth goal.
    Stiff,
    /// A smooth course of time: nothing is held.
    Smooth,
}

/// A servo with a pendulum, SI. The motor's inertia is what is looked for.
#[derive(Clone, Copy)]
struct Servo {
    inertia: f64,
    rate: f64,
    law: Law,
    /// Of the position \[rad\].
    noise: f64,
    seed: u64,
}

const RATIO: f64 = 10.0;
const CONSTANT: f64 = 0.05;
const RESISTANCE: f64 = 1.0;
const SUPPLY: f64 = 12.0;
const VISCOUS: f64 = 2e-5;
const MASS: f64 = 0.5;
const LENGTH: f64 = 0.1;
const DURATION: f64 = 10.0;

/// Numbers between 0 and 1, by Marsaglia's xorshift.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Nearly normal, deviation 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

impl Servo {
    fn acceleration(&self, duty: f64, q: f64, w: f64) -> f64 {
        let current = (duty * SUPPLY - CONSTANT * RATIO * w) / RESISTANCE;
        let torque = RATIO * CONSTANT * current - RATIO * RATIO * VISCOUS * w - MASS * 9.806_65 * LENGTH * q.sin();
        torque / (MASS * LENGTH * LENGTH + RATIO * RATIO * self.inertia)
    }

    /// Rows of time, position as read, duty and goal.
    fn log(&self, number: u64) -> Vec<[f64; 4]> {
        let mut chance =
            Chance(0x9e37_79b9_7f4a_7c15 ^ (self.seed * 131 + number + 1).wrapping_mul(0x2545_f491_4f6c_dd1d));
        let mut goals = vec![(0.0, 0.0)];
        while goals[goals.len() - 1].0 < DURATION {
            goals.push((goals[goals.len() - 1].0 + 0.2 + 0.7 * chance.next(), 2.4 * chance.next() - 1.2));
        }
        let waves: Vec<[f64; 3]> =
            (0..6).map(|_| [0.3 + 2.7 * chance.next(), 0.05 + 0.15 * chance.next(), 6.3 * chance.next()]).collect();
        let smooth = |t: f64| waves.iter().map(|[f, a, p]| a * (std::f64::consts::TAU * f * t + p).sin()).sum::<f64>();
        let parts = (10_000.0 / self.rate).round().max(20.0);
        let h = 1.0 / (self.rate * parts);
        let (mut q, mut w) = (0.0_f64, 0.0_f64);
        let count = (DURATION * self.rate) as usize;
        let mut rows = Vec::with_capacity(count);
        for k in 0..count {
            let t = k as f64 / self.rate;
            let goal = goals.iter().take_while(|(at, _)| *at <= t).last().map_or(0.0, |g| g.1);
            let duty = match self.law {
                Law::Steps => (1.5 * (goal - q) - 0.01 * w).clamp(-1.0, 1.0),
                Law::Stiff => (6.0 * (1.2 * (smooth(t) - smooth(0.0)) - q) - 0.02 * w).clamp(-1.0, 1.0),
                Law::Smooth => smooth(t),
            };
            let count = std::f64::consts::TAU / 16384.0;
            rows.push([t, ((q + self.noise * chance.normal()) / count).round() * count, duty, goal]);
            for part in 0..parts as usize {
                let at =
                    |share: f64| if self.law == Law::Smooth { smooth(t + (part as f64 + share) * h) } else { duty };
                let f = |share: f64, q: f64, w: f64| (w, self.acceleration(at(share), q, w));
                let a = f(0.0, q, w);
                let b = f(0.5, q + 0.5 * h * a.0, w + 0.5 * h * a.1);
                let c = f(0.5, q + 0.5 * h * b.0, w + 0.5 * h * b.1);
                let d = f(1.0, q + h * c.0, w + h * c.1);
                q += h / 6.0 * (a.0 + 2.0 * b.0 + 2.0 * c.0 + d.0);
                w += h / 6.0 * (a.1 + 2.0 * b.1 + 2.0 * c.1 + d.1);
            }
        }
        rows
    }

    /// Writes three logs, the last held out, and the bench file; `more` goes into the column of the duty.
    fn write(&self, folder: &Path, more: &str) -> Bench {
        let mut bench = format!(
            "kind = \"servo\"\ncatalog = [\"motors.csv\"]\nactuator = {{ motor = \"sim\", ratio = {RATIO} }}\n\
             pendulum = {{ mass = \"{MASS} kg\", length = \"{LENGTH} m\" }}\n[columns]\ntime = {{ name = \"t\", unit = \"s\" }}\n\
             position = {{ name = \"q\", unit = \"rad\", side = \"output\" }}\nduty = {{ name = \"duty\"{more} }}\n\
             supply = {{ name = \"supply\", unit = \"V\" }}\n"
        );
        for number in 0..3 {
            let mut text = String::from("t,q,duty,supply\n");
            for [t, q, duty, _] in self.log(number) {
                let _ = writeln!(text, "{t:.6},{q:.8},{duty:.8},{SUPPLY}");
            }
            std::fs::write(folder.join(format!("log{number}.csv")), text).unwrap();
            let usage = if number == 2 { "held_out" } else { "fit" };
            let _ = writeln!(bench, "[[log]]\nfile = \"log{number}.csv\"\nuse = \"{usage}\"");
        }
        // A fifth more than there is: what is found is not what was declared.
        let row = format!(
            "id,commutation,terminals,current,resistance [ohm],torque_constant [N*m/A],rotor_inertia [kg*m^2],source,source_kind\n\
             sim,brushed,line_to_line,dc,{RESISTANCE},{CONSTANT},{:e},simulated,measured\n",
            1.2 * self.inertia
        );
        std::fs::write(folder.join("motors.csv"), row).unwrap();
        std::fs::write(folder.join("bench.toml"), bench).unwrap();
        read(&folder.join("bench.toml")).unwrap_or_else(|e| panic!("{e:?}"))
    }

    fn identified(&self, more: &str) -> Report {
        let folder = tempfile::tempdir().unwrap();
        identify_servo(&self.write(folder.path(), more)).unwrap()
    }
}

/// Fitted inertia and its standard error.
fn inertia(report: &Report) -> (f64, f64) {
    let found = report.parameters.iter().find(|p| p.name == "inertia").unwrap();
    (found.fitted, found.standard_error.expect("the inertia is seen"))
}

/// The true inertia lies within three standard errors, and the errors are no excuse: below 5 %. Nothing is said of lag
/// where there is none.
fn finds_it(servo: Servo, more: &str) {
    let report = servo.identified(more);
    let (found, error) = inertia(&report);
    let lag = report.artefacts.iter().map(|a| a.value).next();
    println!(
        "{} Hz, {:.0} g*cm^2: {:.1} ± {:.1}, lag {lag:?}, {:?}",
        servo.rate,
        1e7 * servo.inertia,
        1e7 * found,
        1e7 * error,
        report.effects.iter().map(|e| e.name()).collect::<Vec<_>>()
    );
    assert!((found - servo.inertia).abs() < 3.0 * error, "{found} ± {error} for {}", servo.inertia);
    assert!(error < 0.05 * servo.inertia, "{error} of {}", servo.inertia);
    assert_eq!(lag, None);
    assert!(report.effects.is_empty(), "{:?}", report.effects);
}

#[test]
fn a_digital_servo_tells_its_inertia_at_100_hz() {
    finds_it(Servo { inertia: 2e-5, rate: 100.0, law: Law::Steps, noise: 2e-4, seed: 1 }, "");
    finds_it(Servo { inertia: 6e-5, rate: 100.0, law: Law::Steps, noise: 2e-4, seed: 2 }, "");
}

#[test]
fn a_digital_servo_tells_its_inertia_at_200_hz() {
    finds_it(Servo { inertia: 2e-5, rate: 200.0, law: Law::Steps, noise: 2e-4, seed: 3 }, "");
    finds_it(Servo { inertia: 6e-5, rate: 200.0, law: Law::Steps, noise: 2e-4, seed: 4 }, "");
}

#[test]
fn a_digital_servo_tells_its_inertia_at_500_hz() {
    finds_it(Servo { inertia: 2e-5, rate: 500.0, law: Law::Steps, noise: 2e-4, seed: 5 }, "");
}

/// Behind a stiff loop a duty on a line between rows makes no lag that shows: all of it goes into the inertia.
#[test]
fn a_stiff_digital_servo_tells_its_inertia() {
    finds_it(Servo { inertia: 2e-5, rate: 200.0, law: Law::Stiff, noise: 1e-3, seed: 8 }, "");
}

#[test]
fn a_smooth_duty_that_is_said_to_be_no_held_one_tells_the_inertia() {
    finds_it(Servo { inertia: 2e-5, rate: 100.0, law: Law::Smooth, noise: 2e-4, seed: 6 }, ", held = false");
    finds_it(Servo { inertia: 6e-5, rate: 200.0, law: Law::Smooth, noise: 2e-4, seed: 7 }, ", held = false");
}

/// What is held unless said, and what the file can say.
#[test]
fn what_is_held_by_default() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("log.csv"), "t,q,u,g,i\n0,0,0,0,0\n0.1,0,0,0,0\n0.2,0,0,0,0\n").unwrap();
    let held = |duty: &str, goal: &str, current: &str| {
        let text = format!(
            "kind = \"servo\"\nactuator = {{ motor = \"t-motor-ri50\", ratio = 5 }}\n[columns]\n\
             time = {{ name = \"t\", unit = \"s\" }}\nposition = {{ name = \"q\", unit = \"rad\" }}\n\
             duty = {{ name = \"u\"{duty} }}\ngoal = {{ name = \"g\", unit = \"rad\"{goal} }}\n\
             current = {{ name = \"i\", unit = \"A\"{current} }}\n[[log]]\nfile = \"log.csv\"\n"
        );
        std::fs::write(folder.path().join("bench.toml"), text).unwrap();
        read(&folder.path().join("bench.toml")).map(|b| b.logs[0].held.iter().copied().collect::<Vec<_>>())
    };
    assert_eq!(held("", "", "").unwrap(), [Channel::Duty, Channel::Goal]);
    assert_eq!(held(", held = false", "", ", held = true").unwrap(), [Channel::Current, Channel::Goal]);
    let wrong = held(", held = \"yes\"", "", "").unwrap_err();
    assert!(wrong[0].to_string().contains("held"), "{}", wrong[0]);
}
