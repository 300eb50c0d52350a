//! Limits and means between the samples of a motion: sinusoids on paper, and a dense look at the declared spline that
//! shares no code with the crate.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use gearwise::actuator::Load;
use gearwise::catalog::{Catalog, Motor};
use gearwise::design::optimize;
use gearwise::input::Source;
use gearwise::motion;
use gearwise::report;
use gearwise::requirement::{Between, Course, GearModel, Motion, RatioChoice, Robot, Samples};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::common::{self, demand, evaluate, gear, robot};

/// R 1 Ω, K 0.1 V·s/rad, J 1e-4 kg·m²; L 1 mH and 7 pole pairs.
fn motor() -> Motor {
    common::motor(&[
        ("resistance [ohm]", "1"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [kg*m^2]", "1e-4"),
        ("peak_current [A]", "1000"),
        ("inductance [mH]", "1"),
        ("pole_pairs", "7"),
    ])
}

/// A periodic motion from torque and speed at `count` instants, the first of them `late` steps after zero.
fn sampled(count: usize, period: f64, late: f64, torque: impl Fn(f64) -> f64, velocity: impl Fn(f64) -> f64) -> Motion {
    let time: Vec<f64> = (0..count).map(|k| period * (k as f64 + late) / count as f64).collect();
    let samples = Samples {
        torque: time.iter().map(|t| torque(*t)).collect(),
        velocity: Some(time.iter().map(|t| velocity(*t)).collect()),
        time,
        ..Samples::default()
    };
    Motion::from_samples(samples, Course::Periodic(period))
}

/// Torque a cos(wt + x) and speed V sin(wt): the shaft's torque is a sinusoid whose size is known. The peak lies half-way
/// between two samples, where 8 samples a period lose 1 − cos(π/8) = 7.6 %.
#[test]
fn the_peak_of_a_sinusoid_is_that_on_paper() {
    let (period, ratio, inertia) = (0.5, 10.0, 1e-4);
    let w = TAU / period;
    // What the cubic spline through a sine itself misses: value and slope half-way between two samples around
    // the peak, from its slopes 3 sin θ/(θ (2 + cos θ)) times those of the sine at the samples.
    let spline_misses = |count: usize| {
        let h = TAU / count as f64;
        let slope = 3.0 * h.sin() / (h * (2.0 + h.cos()));
        let value = (0.5 * h).cos() + h / 4.0 * slope * (0.5 * h).sin();
        let rate = 1.5 * (0.5 * h).sin() / (0.5 * h) - 0.5 * slope * (0.5 * h).cos();
        (value - 1.0).abs().max((rate - 1.0).abs())
    };
    for count in [8, 12, 20, 100, 1261] {
        for (load, speed) in [(5.0, 0.0), (0.0, 20.0), (5.0, 20.0), (2.0, 60.0)] {
            let motion = sampled(count, period, 0.5, |t| load * (w * t).cos(), |t| speed * (w * t).sin());
            let peak = load / ratio + ratio * inertia * speed * w;
            let found = demand(&evaluate(&robot(motion, GearModel::IDEAL), &motor(), ratio), "peak_current") * 0.1;
            let allowed = 1e-3 + spline_misses(count);
            assert!((found / peak - 1.0).abs() < allowed, "{count}, {load}, {speed}: {found} for {peak}");
        }
    }
    assert!(spline_misses(8) < 1.2e-3 && spline_misses(12) < 3e-4);
}

/// The cubic spline with period, in the form with second derivatives at the knots ("moments"), relaxed by Gauss and Seidel.
struct Spline {
    time: Vec<f64>,
    value: Vec<f64>,
    moment: Vec<f64>,
    period: f64,
}

impl Spline {
    fn new(time: &[f64], value: &[f64], period: f64) -> Spline {
        let n = time.len();
        let h = |i: usize| if i + 1 < n { time[i + 1] - time[i] } else { time[0] + period - time[n - 1] };
        let mut moment = vec![0.0; n];
        for _ in 0..200 {
            for i in 0..n {
                let (before, next) = ((i + n - 1) % n, (i + 1) % n);
                let (h0, h1) = (h(before), h(i));
                let bend = 6.0 * ((value[next] - value[i]) / h1 - (value[i] - value[before]) / h0);
                moment[i] = (bend - h0 * moment[before] - h1 * moment[next]) / (2.0 * (h0 + h1));
            }
        }
        Spline { time: time.to_vec(), value: value.to_vec(), moment, period }
    }

    /// Value, first and second derivative.
    fn at(&self, t: f64) -> [f64; 3] {
        let n = self.time.len();
        let t = self.time[0] + (t - self.time[0]).rem_euclid(self.period);
        let i = self.time.partition_point(|x| *x <= t) - 1;
        let (next, end) = if i + 1 < n { (i + 1, self.time[i + 1]) } else { (0, self.time[0] + self.period) };
        let h = end - self.time[i];
        let (a, b) = ((end - t) / h, (t - self.time[i]) / h);
        let (m0, m1) = (self.moment[i], self.moment[next]);
        let bulge = (a.powi(3) - a) * m0 + (b.powi(3) - b) * m1;
        let slope = -(3.0 * a * a - 1.0) * m0 + (3.0 * b * b - 1.0) * m1;
        [
            a * self.value[i] + b * self.value[next] + bulge * h * h / 6.0,
            (self.value[next] - self.value[i]) / h + slope * h / 6.0,
            a * m0 + b * m1,
        ]
    }
}

/// A random motion of 5 to 60 samples at uneven times, its splines, and a period.
fn random(seed: u64) -> (Motion, Spline, Spline, f64) {
    let mut generator = Pcg64::seed_from_u64(seed);
    let mut within = |a: f64, b: f64| generator.random_range(a..b);
    let (count, period) = (within(5.0, 60.0) as usize, within(0.2, 2.0));
    let time: Vec<f64> = (0..count).map(|k| period * (k as f64 + within(0.0, 0.5)) / count as f64).collect();
    let mut wave = |size: f64| {
        let terms: Vec<[f64; 3]> = (0..3)
            .map(|_| [size * within(0.1, 1.0), within(1.0, 5.0).floor() * TAU / period, within(0.0, TAU)])
            .collect();
        time.iter().map(|t| terms.iter().map(|[a, w, x]| a * (w * t + x).sin()).sum()).collect::<Vec<f64>>()
    };
    let (torque, velocity) = (wave(5.0), wave(8.0));
    let splines = (Spline::new(&time, &torque, period), Spline::new(&time, &velocity, period));
    let samples = Samples { time, torque, velocity: Some(velocity), ..Samples::default() };
    (Motion::from_samples(samples, Course::Periodic(period)), splines.0, splines.1, period)
}

/// 10 000 instants of a period, and those just beside its changes of sign, where efficiency flips.
fn dense(torque: &Spline, velocity: &Spline, period: f64) -> Vec<f64> {
    let mut all: Vec<f64> = (0..10_000).map(|i| period * f64::from(i) / 10_000.0).collect();
    for i in 0..10_000 {
        for spline in [torque, velocity] {
            let (mut a, mut b) = (all[i], all[i] + period / 10_000.0);
            let positive = |t: f64| spline.at(t)[0] > 0.0;
            if positive(a) != positive(b) {
                for _ in 0..30 {
                    let middle = 0.5 * (a + b);
                    if positive(middle) == positive(a) { a = middle } else { b = middle }
                }
                all.extend([a, b]);
            }
        }
    }
    all
}

/// Current, voltage, power drawn and given back, speed at 10 000 instants of the declared spline: none exceeds what is
/// reported by more than 0.1 % (of its largest terms, where terms cancel), and what is reported is there.
#[test]
fn no_instant_of_the_declared_spline_exceeds_what_is_reported() {
    let (motor, gear) = (motor(), gear(0.8));
    let (mut coarse, mut worst) = (0, 0.0_f64);
    for seed in 0..40 {
        let (motion, torque, velocity, period) = random(seed);
        assert_eq!(motion.between, Between::Spline(1e-3), "{seed}: {} samples", motion.len());
        let mut robot = robot(motion, gear);
        robot.bus.power = Some(1e6);
        robot.bus.regeneration = gearwise::requirement::Regeneration::Limited(1e6);
        let dense = dense(&torque, &velocity, period);
        // Copper at ambient over that at the reference, which the hottest winding has.
        let (zero, hot) = (293.15, motor.reference_temperature);
        let line = |kelvin: f64| 1.0 + 0.003_93 * (kelvin - zero);
        let cold = line(robot.ambient) / line(hot);
        for ratio in [2.0, 8.0, 30.0] {
            let evaluation = evaluate(&robot, &motor, ratio);
            // The terms at some φ: φ τ/N, N J α, φ τ̇/N, N J j, N ω.
            let terms = |t: f64, phi: f64| {
                let ([tau, rate, _], [v, a, j]) = (torque.at(t), velocity.at(t));
                [phi * tau / ratio, ratio * 1e-4 * a, phi * rate / ratio, ratio * 1e-4 * j, ratio * v]
            };
            let look = |t: f64| {
                let braking = torque.at(t)[0] * velocity.at(t)[0] < 0.0;
                let phi = if braking { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
                let [load, own, rate, jerk, speed] = terms(t, phi);
                let shaft = load + own;
                let quadrature = |winding: f64| 10.0 * winding * shaft + 0.01 * (rate + jerk) + 0.1 * speed;
                let power = |winding: f64| 100.0 * winding * shaft * shaft + speed * shaft;
                let most = quadrature(1.0).abs().max(quadrature(cold).abs());
                [shaft.abs() / 0.1, most.hypot(0.07 * speed * shaft), power(1.0), -power(cold)]
            };
            let (mut most, mut largest) = ([0.0_f64; 4], [0.0_f64; 5]);
            for t in &dense {
                most.iter_mut().zip(look(*t)).for_each(|(m, value)| *m = m.max(value));
                let driven = terms(*t, 1.0 / gear.efficiency);
                largest.iter_mut().zip(driven).for_each(|(l, term)| *l = l.max(term.abs()));
            }
            // The largest of the terms, added up; the load's as if it were driven, as the largest may come back.
            let [load, own, rate, jerk, speed] = largest;
            let shaft = load + own;
            let power = 100.0 * shaft * shaft + speed * shaft;
            let voltage = 10.0 * shaft + 0.01 * (rate + jerk) + 0.1 * speed + 0.07 * speed * shaft;
            let sizes = [shaft / 0.1, voltage, power, power];
            let mut seen = [0.0_f64; 4];
            for t in &torque.time {
                seen.iter_mut().zip(look(*t)).for_each(|(s, value)| *s = s.max(value));
            }
            for (i, limit) in ["peak_current", "voltage", "bus_power", "regeneration"].into_iter().enumerate() {
                let (found, dense, size) = (demand(&evaluation, limit).max(0.0), most[i], sizes[i]);
                let over = (dense - found) / size;
                worst = worst.max(over);
                assert!(over < 1e-3, "{seed}, {ratio}, {limit}: {found} for {dense}, of terms up to {size}");
                assert!(found < dense + 1e-3 * size, "{seed}, {ratio}, {limit}: {found} for {dense}");
                if i == 0 {
                    assert!(dense < found * (1.0 + 2e-3), "{seed}, {ratio}, {limit}: {found} for {dense}");
                    coarse += usize::from(seen[i] < 0.99 * dense);
                }
            }
        }
    }
    println!("most over: {worst:.2e}; the samples alone lose more than 1 % of the current in {coarse} of 120");
    assert!(coarse > 40);
}

/// Means are those of the declared spline, with efficiency by the direction of power at every instant.
#[test]
fn means_are_those_of_the_declared_spline() {
    let (motor, gear) = (motor(), gear(0.7));
    for seed in 100..140 {
        let (motion, torque, velocity, period) = random(seed);
        let robot = robot(motion, gear);
        for ratio in [2.0, 8.0, 30.0] {
            let square = |i: u32| {
                let t = period * (f64::from(i) + 0.5) / 20_000.0;
                let ([tau, ..], [v, a, _]) = (torque.at(t), velocity.at(t));
                let phi = if tau * v < 0.0 { gear.backdrive_efficiency } else { 1.0 / gear.efficiency };
                (phi * tau / ratio + ratio * 1e-4 * a).powi(2)
            };
            let loss = 100.0 * (0..20_000).map(square).sum::<f64>() / 20_000.0;
            let found = evaluate(&robot, &motor, ratio).copper_loss;
            assert!((found / loss - 1.0).abs() < 2e-3, "{seed}, {ratio}: {found} for {loss}");
        }
    }
}

/// A constant torque drives exactly half of the time if the speed is a sinusoid, whatever the samples.
#[test]
fn efficiency_flips_at_the_zero_of_power() {
    let gear = gear(0.8);
    let (driving, braking) = (1.0 / gear.efficiency, gear.backdrive_efficiency);
    for (count, late) in [(7, 0.3), (8, 0.0), (8, 0.1), (9, 0.25), (31, 0.7)] {
        let robot = robot(sampled(count, 1.0, late, |_| 5.0, |t| 1e-6 * (TAU * t).sin()), gear);
        let loss = evaluate(&robot, &motor(), 10.0).copper_loss;
        let paper = 100.0 * 0.25 * 0.5 * (driving * driving + braking * braking);
        assert!((loss / paper - 1.0).abs() < 1e-3, "{count}, {late}: {loss} for {paper}");
        // The torque is largest where the motor begins to drive.
        let robot =
            common::robot(sampled(count, 1.0, late, |t| 5.0 * (TAU * t).cos(), |t| 1e-6 * (TAU * t).sin()), gear);
        let current = demand(&evaluate(&robot, &motor(), 10.0), "peak_current");
        let spline = 2e-3 * (8.0 / count as f64).powi(4);
        assert!((current / (5.0 * driving) - 1.0).abs() < 1e-3 + spline, "{count}, {late}: {current}");
    }
}

/// A torque that rises through zero while the joint turns one way: T is straight on both sides, and its mean square is known.
#[test]
fn a_torque_that_changes_its_sign_flips_there() {
    let gear = gear(0.5);
    let time: Vec<f64> = (0..6).map(f64::from).collect();
    // −2.5 … 2.5: zero half-way between the third and the fourth sample.
    let torque: Vec<f64> = time.iter().map(|t| t - 2.5).collect();
    let samples = Samples { time, torque, velocity: Some(vec![1e-6; 6]), ..Samples::default() };
    let robot = robot(Motion::from_samples(samples, Course::Once(5.0)), gear);
    // ∫ τ² over one half is 2.5³/3; η_b = 2 − 1/η = 0.
    let paper = 100.0 * 4.0 * (2.5_f64.powi(3) / 3.0) / 5.0;
    let found = evaluate(&robot, &motor(), 1.0).copper_loss;
    assert!((found / paper - 1.0).abs() < 1e-6, "{found} for {paper}");
}

/// A hold stays a hold, and takes the share of the time that it had.
#[test]
fn a_joint_that_stands_stands_between_its_samples() {
    let velocity = |t: f64| if t > 0.45 { (TAU * (t - 0.5) / 0.5).sin() } else { 0.0 };
    let motion = sampled(10, 1.0, 0.0, |t| 2.0 + (TAU * t).sin(), velocity);
    // At rest at 0, 0.1 … 0.5: five of ten ways from sample to sample.
    assert!((motion.dwell.iter().sum::<f64>() - 0.5).abs() < 1e-12);
    assert!((motion.weight.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    for (k, t) in motion.time.iter().enumerate() {
        assert!(*t > 0.5 || motion.velocity[k] == 0.0, "at {t}");
        assert!(*t < 0.5 + 1e-6 || *t > 1.0 - 1e-6 || motion.velocity[k] != 0.0 || (t - 0.75).abs() < 0.26);
    }
}

/// A hold is a hold, whether it is written as two rows or as hundreds, and whatever acceleration the motion has beside it:
/// while it stands the shaft takes what the load asks, on paper T = τ/N.
#[test]
fn the_rows_of_a_hold_change_nothing() {
    let (swing, hold, period) = (0.4, 10.0, 10.8);
    // Up and down by triangles of speed, with a hold of 2 N·m between.
    let speed = |t: f64| match t {
        t if t < swing => 10.0 * (1.0 - (2.0 * t / swing - 1.0).abs()),
        t if t > swing + hold => -10.0 * (1.0 - (2.0 * (t - swing - hold) / swing - 1.0).abs()),
        _ => 0.0,
    };
    let slope = |t: f64| if t < 0.5 * swing || t > period - 0.5 * swing { 50.0 } else { -50.0 };
    let motion = |rows: usize, given: bool| {
        let moves = (0..12).map(|k| swing * f64::from(k) / 12.0);
        let holds = (0..rows).map(|k| swing + hold * k as f64 / rows as f64);
        let back = (0..12).map(|k| swing + hold + swing * f64::from(k) / 12.0);
        let time: Vec<f64> = moves.chain(holds).chain(back).collect();
        let samples = Samples {
            torque: vec![2.0; time.len()],
            velocity: Some(time.iter().map(|t| speed(*t)).collect()),
            acceleration: given.then(|| time.iter().map(|t| slope(*t)).collect()),
            time,
            ..Samples::default()
        };
        Motion::from_samples(samples, Course::Periodic(period))
    };
    for given in [false, true] {
        let mean = |rows: usize| {
            let motion = motion(rows, given);
            assert!((motion.weight.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            assert!((motion.dwell.iter().sum::<f64>() - hold / period).abs() < 1e-9, "{given} {rows}");
            // Of the hold alone: nothing but the load.
            let at_rest = motion.dwell.iter().zip(&motion.acceleration).map(|(share, a)| share * a * a).sum::<f64>();
            assert!(at_rest < 1e-2, "{given} {rows}: {at_rest}");
            motion.weight.iter().zip(&motion.acceleration).map(|(share, a)| share * a * a).sum::<f64>()
        };
        let dense = mean(400);
        for rows in [1, 2, 4, 8, 32] {
            assert!((mean(rows) / dense - 1.0).abs() < 0.01, "{given} {rows}: {} {dense}", mean(rows));
        }
    }
}

/// A smooth motion of many samples is taken as it is, but for its changes of sign.
#[test]
fn a_dense_motion_stays_as_it_is() {
    let motion = sampled(1000, 1.0, 0.3, |t| 5.0 + (TAU * t).sin(), |t| 8.0 + (TAU * t).cos());
    assert_eq!(motion.len(), 1000);
    let motion = sampled(1000, 1.0, 0.3, |t| 5.0 + (TAU * t).sin(), |t| 8.0 * (TAU * t).cos());
    assert_eq!(motion.len(), 1004);
    assert!(motion.time.is_sorted() && motion.time.iter().zip(&motion.time[1..]).all(|(a, b)| a < b));
}

fn choice(file: &str, look: impl FnOnce(&Robot, String, serde_json::Value)) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("motion.csv"), file).unwrap();
    let text = "name = \"r\"\nbus = { voltage = \"48 V\", drive_current = \"60 A\" }\n[[joint]]\nname = \"j\"\n\
                ratio = { min = 5, max = 50 }\nmotor_drag = \"off\"\nmotion = \"motion.csv\"\n";
    std::fs::write(folder.path().join("r.toml"), text).unwrap();
    let robot = gearwise::requirement::read(&folder.path().join("r.toml")).unwrap();
    let catalog = Catalog::of(vec![motor()], Vec::new());
    let result = optimize(&robot, &catalog);
    let shown = report::optimize::text(
        &result,
        &[],
        &[],
        report::optimize::Shown { top: 3, rejected: false, why: false, full: true },
    );
    look(&robot, shown, report::json::optimize::json(&result, &[], None));
}

/// Rows of a motion file; with accelerations where `given`.
fn file(count: usize, given: bool) -> String {
    let mut text = String::from("time [s],torque [N*m],velocity [rad/s]");
    text.push_str(if given { ",acceleration [rad/s^2]\n" } else { "\n" });
    for k in 0..=count {
        let x = TAU * ((k % count) as f64 + 0.5) / count as f64;
        text.push_str(&format!("{},{},{}", k as f64 / count as f64, 5.0 * x.cos(), 6.0 * x.sin()));
        text.push_str(&if given { format!(",{}\n", 6.0 * TAU * x.cos()) } else { "\n".into() });
    }
    text
}

/// "Not resolved" is said of coarse motions that give their rates, and of no other.
#[test]
fn not_resolved_is_said_where_rates_are_given_and_it_matters() {
    const WORDS: &str = "Not resolved between samples";
    let flat = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    for (count, given, said) in
        [(8, true, true), (20, true, true), (8, false, false), (200, true, false), (200, false, false)]
    {
        choice(&file(count, given), |robot, text, json| {
            assert_eq!(flat(&text).contains(WORDS), said, "{count}, {given}: {text}");
            assert_eq!(json["joints"][0]["between_samples"]["by"], if given { "not_resolved" } else { "spline" });
            assert!(
                !given || robot.joints[0].motion.len() == count,
                "nothing is put between samples whose rates are given"
            );
            if (count, given) == (8, true) {
                // The cosine is 1/cos(π/8) times its value at the samples; the cubic through given rates has 1 to 3e-3.
                let share = json["joints"][0]["between_samples"]["missed_share"].as_f64().unwrap();
                assert!((share - (1.0 / (PI / 8.0).cos() - 1.0)).abs() < 5e-3, "{share}");
            }
        });
    }
}

/// What binds between two samples says when.
#[test]
fn a_limit_that_binds_between_samples_says_when() {
    choice(&file(8, false), |_, text, json| {
        let design = &json["joints"][0]["candidates"][0];
        let limits = design["limits"].as_array().unwrap();
        let current = limits.iter().find(|l| l["limit"] == "peak_current").unwrap();
        // The torque is largest half a step before the first sample, or half a period before that.
        let time = current["time_s"].as_f64().unwrap();
        let away = (time - 7.5 / 8.0).abs().min((time - 3.5 / 8.0).abs());
        assert!(away < 0.02, "{current}");
        assert!(current["sample"].is_null() && current["at"] == format!("t = {} s", report::number(time)), "{current}");
        assert!(text.contains("peak_current") || text.contains("voltage"));
    });
    // The sample after which it is named where it is one.
    choice(&file(200, true), |_, _, json| {
        for limit in json["joints"][0]["candidates"][0]["limits"].as_array().unwrap() {
            if let Some(sample) = limit["sample"].as_u64() {
                assert!((limit["time_s"].as_f64().unwrap() - sample as f64 / 200.0).abs() < 1e-9, "{limit}");
            }
        }
    });
}

/// What carried actuators weigh has its own spline at every instant.
#[test]
fn columns_of_torque_per_mass_are_known_at_every_instant() {
    let mut text = String::from("time [s],torque [N*m],velocity [rad/s],torque_per_mass_knee [N*m/kg]\n");
    for k in 0..=16 {
        let x = TAU * f64::from(k % 16) / 16.0;
        text.push_str(&format!("{},{},{},{}\n", f64::from(k) / 16.0, 5.0 * x.cos(), 6.0 * x.sin(), 3.0 * x.sin()));
    }
    let source = Arc::new(Source::new("motion.csv", text));
    let (motion, carried) = motion::read_carrying(&source, true, None, &["knee".to_string()]).unwrap();
    let (_, values, rates) = &carried[0];
    assert!(motion.len() > 40 && values.len() == motion.len() && rates.len() == motion.len());
    for (k, t) in motion.time.iter().enumerate() {
        assert!((values[k] - 3.0 * (TAU * t).sin()).abs() < 3e-3, "at {t}: {}", values[k]);
        assert!((rates[k] - 3.0 * TAU * (TAU * t).cos()).abs() < 0.03, "at {t}: {}", rates[k]);
    }
}

/// Positions go with the instants: a spring that carries the load leaves nothing of it.
#[test]
fn a_spring_is_known_at_every_instant() {
    let time: Vec<f64> = (0..12).map(|k| f64::from(k) / 12.0).collect();
    let samples = Samples {
        torque: time.iter().map(|t| -4.0 * (TAU * t).sin()).collect(),
        position: Some(time.iter().map(|t| 0.5 * (TAU * t).sin()).collect()),
        time,
        ..Samples::default()
    };
    let motion = Motion::from_samples(samples, Course::Periodic(1.0));
    assert!(motion.len() > 40);
    let sprung = motion.with_spring(8.0, 0.0).unwrap();
    let left = sprung.torque.iter().fold(0.0_f64, |a, t| a.max(t.abs()));
    assert!(left < 4.0 * 1e-4, "{left}");
}

/// The ends of the window keep the limit at every instant: the ratio at which the current is at its limit is that on paper.
#[test]
fn the_window_ends_where_the_peak_between_samples_is_at_the_limit() {
    let mut robot = robot(sampled(12, 1.0, 0.5, |t| 5.0 * (TAU * t).cos(), |_| 1e-9), GearModel::IDEAL);
    robot.joints[0].ratio = RatioChoice::Continuous { min: 1.0, max: 100.0 };
    let motor = common::motor(&[
        ("resistance [ohm]", "1"),
        ("torque_constant [N*m/A]", "0.1"),
        ("rotor_inertia [kg*m^2]", "1e-4"),
        ("peak_current [A]", "10"),
    ]);
    let load = Load::new(&robot.joints[0].motion, None);
    assert!(load.peak_torque.0 > 4.99);
    let catalog = Catalog::of(vec![motor], Vec::new());
    let result = optimize(&robot, &catalog);
    let window = result.joints[0].candidates[0].optimum.window();
    assert!((window.min / 5.0 - 1.0).abs() < 1.5e-3, "{}", window.min);
}
