//! `characterize` against numbers that the paper states, against real logs, and against a simulated bench: are the
//! estimates unbiased, and do the intervals cover the truth as often as they say?

use approx::assert_relative_eq;
use gearwise::measured::bench::{Bench, BenchKind, Channel};
use gearwise::measured::characterize::estimate::{
    Combination, Estimate, combine, discrepancy, motor_constant, motor_constant_slopes, pool, rotor_inertia, thin_ring,
    thin_ring_slopes,
};
use gearwise::measured::characterize::{
    Characterization, Weight, backdrive, characterize, find, random_torque, stall, terminals,
};
use gearwise::measured::read::read_for_row;

use crate::motor_bench::{self, AMBIENT, DragTest, HeatTest, QUARTER, Random, RandomTest, SAMPLE, log};

/// Two significant digits, as the paper prints its ±.
fn two_digits(value: f64) -> String {
    format!("{value:.1e}")
}

/// Urs et al., "Alternative Metrics to Select Motors for Quasi-Direct Drive Actuators", section IV: the stated
/// measurements give the stated results, and its ± are linear sums.
#[test]
fn the_numbers_of_the_paper() {
    // J_r = (6.55 ± 0.95)e-4 and J_nr = (1.48 ± 0.08)e-4 kg·m² behind 7.5:1 give (9.01 ± 1.8)e-6.
    let (with, without) = (Estimate::stated(6.55e-4, 0.95e-4), Estimate::stated(1.48e-4, 0.08e-4));
    let rotor = rotor_inertia(with, without, 7.5);
    assert_relative_eq!(rotor.value, 9.01e-6, max_relative = 1e-3);
    let slope = 1.0 / (7.5 * 7.5);
    let parts = [(slope, 0.95e-4), (-slope, 0.08e-4)];
    assert_relative_eq!(rotor.half_width(), combine(Combination::RootSumSquare, &parts), max_relative = 1e-9);
    assert_eq!(two_digits(combine(Combination::RootSumSquare, &parts)), "1.7e-6");
    assert_eq!(two_digits(combine(Combination::Linear, &parts)), "1.8e-6", "this is the one that is printed");
    // Thin ring: 34 ± 0.5 g at 12.6 ± 0.5 mm give (5.4 ± 0.5)e-6.
    let ring = thin_ring(Estimate::stated(34e-3, 0.5e-3), Estimate::stated(12.6e-3, 0.5e-3));
    assert_eq!(two_digits(ring.value), "5.4e-6");
    let [by_mass, by_radius] = thin_ring_slopes(34e-3, 12.6e-3);
    let parts = [(by_mass, 0.5e-3), (by_radius, 0.5e-3)];
    assert_relative_eq!(ring.half_width(), combine(Combination::RootSumSquare, &parts), max_relative = 1e-9);
    assert_eq!(format!("{:.1}", 1e6 * combine(Combination::RootSumSquare, &parts)), "0.4");
    assert_eq!(format!("{:.1}", 1e6 * combine(Combination::Linear, &parts)), "0.5", "this is the one that is printed");
    // K_T = 0.105 ± 0.002, K_B = 0.094 ± 0.002, R = 0.705 ± 0.003 give K_M = 0.118 ± 0.003.
    let (k_t, k_b) = (Estimate::stated(0.105, 0.002), Estimate::stated(0.094, 0.002));
    let r = Estimate::stated(0.705, 0.003);
    let k_m = motor_constant(k_t, k_b, r);
    assert_eq!(format!("{:.3}", k_m.value), "0.118");
    let slopes = motor_constant_slopes(0.105, 0.094, 0.705);
    let parts: Vec<(f64, f64)> = slopes.into_iter().zip([0.002, 0.002, 0.003]).collect();
    assert_relative_eq!(k_m.half_width(), combine(Combination::RootSumSquare, &parts), max_relative = 1e-9);
    assert_eq!(format!("{:.3}", combine(Combination::RootSumSquare, &parts)), "0.002");
    assert_eq!(format!("{:.3}", combine(Combination::Linear, &parts)), "0.003", "this is the one that is printed");
    // K_T is 11.7 ± 3 % above K_B.
    let off = discrepancy(k_t, k_b);
    assert_eq!(format!("{:.1} {:.0}", 100.0 * off.value, 100.0 * off.half_width()), "11.7 3");
}

/// The bench file of real RI50 runs: `(run, kind)`.
fn ri50(runs: &[(&str, &str)], more: &str) -> Option<Bench> {
    let data = crate::common::real::data()?.join("embir_ri50_direct/embir_ri50_direct.csv");
    if !data.exists() {
        println!("not run: 1 sets");
        return None;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = data.canonicalize().unwrap();
    let logs: String = runs
        .iter()
        .map(|(run, kind)| {
            format!(
                "[[log]]\nfile = {:?}\nkind = \"{kind}\"\nselect = {{ column = \"run\", equals = \"{run}\" }}\n",
                file.display().to_string()
            )
        })
        .collect();
    // The paper takes its K_T as the q axis' (K_T = K_B is its ideal): the same here.
    let text = format!(
        "name = \"RI50\"\n{more}\n[columns]\ntime = {{ name = \"t_s\", unit = \"s\" }}\ncurrent = {{ name = \"iq1_a\", unit = \
         \"A\", convention = \"q_axis\" }}\nvelocity = {{ name = \"w1_radps\", unit = \"rad/s\" }}\ntorque = {{ name = \
         \"tau_sensor_nm\", unit = \"N*m\" }}\nwinding_temperature = {{ name = \"t_motor_c\", unit = \"degC\" }}\n{logs}"
    );
    let path = folder.path().join("bench.toml");
    std::fs::write(&path, text).unwrap();
    Some(read_for_row(&path, None, Vec::new()).unwrap_or_else(|e| panic!("{}", e[0])))
}

fn warned(result: &Characterization, check: &str, part: &str) -> bool {
    result
        .outcomes
        .iter()
        .flat_map(|o| &o.findings)
        .any(|f| f.check == check && f.weight == Weight::Warning && f.text.contains(part))
}

#[test]
fn real_stall_logs() {
    let runs = ["stall_1112a", "stall_11b", "stall_12", "stall_13", "stall_24b_badgain", "stall_24c"];
    let Some(bench) = ri50(&runs.map(|r| (r, "stall")), "") else { return };
    let result = characterize(&bench).unwrap();
    let outcome = &result.outcomes[0];
    for entry in &outcome.logs {
        eprintln!("{entry:?}");
    }
    let k = find(&result.outcomes, "torque_constant").unwrap();
    eprintln!("K_T = {} ± {}", k.value, k.half_width());
    // What was wrong is found out and named, and nothing else is.
    assert!(warned(&result, "sign", "stall_11b"));
    assert!(warned(&result, "gain", "stall_24b_badgain"));
    let named = |check: &str| outcome.findings.iter().filter(|f| f.check == check).count();
    assert_eq!((named("sign"), named("gain")), (1, 1));
    let used: Vec<&str> = outcome.logs.iter().filter(|l| l.used).map(|l| l.log.as_str()).collect();
    assert_eq!(used.len(), 5, "{used:?}");
    for entry in outcome.logs.iter().filter(|l| l.used) {
        let slope = entry.values[0].1.value.abs();
        assert!((0.095..0.111).contains(&slope), "{}: {slope}", entry.log);
    }
    // The spread between days is in the interval: it covers the paper's 0.105, and is no wider than the logs are apart.
    let (low, high) = k.interval();
    assert!(low < 0.105 && 0.105 < high, "{low} {high}");
    assert!(k.half_width() > 0.002 && k.half_width() < 0.010, "{}", k.half_width());
}

/// The real drag test: one machine drives in one direction and the other in the other, which is found out; one
/// direction alone shows the drag that flattens.
#[test]
fn real_drag_log() {
    let Some(bench) = ri50(&[("drag", "drag")], "") else { return };
    let both = characterize(&bench).unwrap();
    assert!(warned(&both, "direction", "same in both directions"));
    assert!(find(&both.outcomes, "coulomb_friction").is_none());
    let mut one = bench.clone();
    let log = &mut one.logs[0];
    let speed = log.channels[&Channel::OutputVelocity].clone();
    let kept: Vec<usize> = (0..log.len()).filter(|k| speed[*k] > 5.0).collect();
    log.time = kept.iter().map(|k| log.time[*k]).collect();
    for values in log.channels.values_mut() {
        *values = kept.iter().map(|k| values[*k]).collect();
    }
    let result = characterize(&one).unwrap();
    let outcome = &result.outcomes[0];
    let form = outcome.findings.iter().find(|f| f.check == "friction_form");
    assert!(form.is_some_and(|f| f.text.contains("the drag flattens")), "{:?}", outcome.findings);
    // Neither rest nor the other direction: the zero of the sensor counts as Coulomb friction, and that is said.
    assert!(warned(&result, "zero", "turn both ways"));
    // The README of the set has 0.053 N·m at 116 rad/s, from all speeds of both machines.
    let peak = find(&result.outcomes, "eddy_drag.torque").unwrap();
    assert!(peak.value > 0.03 && peak.value < 0.08, "{peak:?}");
}

/// Repeats of a chance of 95 %: how many of `n` must and may be inside for a test that fails by chance once in a
/// thousand (binomial).
fn bounds(n: u64, least: f64, most: f64) -> (u64, u64) {
    use statrs::distribution::{Binomial, DiscreteCDF};
    let low = Binomial::new(least, n).unwrap().inverse_cdf(5e-4);
    let high = Binomial::new(most, n).unwrap().inverse_cdf(1.0 - 5e-4);
    (low, high)
}

/// Counts how often the interval holds the truth, and the mean relative error with its own standard error.
#[derive(Debug, Default)]
struct Score {
    inside: u64,
    errors: Vec<f64>,
}

impl Score {
    fn add(&mut self, estimate: Estimate, truth: f64) {
        let (low, high) = estimate.interval();
        self.inside += u64::from(low <= truth && truth <= high);
        self.errors.push(estimate.value / truth - 1.0);
    }

    fn bias(&self) -> (f64, f64) {
        let n = self.errors.len() as f64;
        let mean = self.errors.iter().sum::<f64>() / n;
        let variance = self.errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    }

    fn count(&self) -> u64 {
        self.errors.len() as u64
    }

    fn share(&self) -> f64 {
        self.inside as f64 / self.count() as f64
    }
}

impl std::fmt::Display for Score {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (bias, error) = self.bias();
        write!(
            f,
            "{}/{} inside ({:.1} %), bias {:+.2e} ± {:.1e}",
            self.inside,
            self.count(),
            100.0 * self.share(),
            bias,
            error
        )
    }
}

/// Random-torque logs over a grid of truths. The velocity is a difference over `span` fine steps, which the log may say.
fn grid(command: bool, span: usize, declared: bool) -> Vec<RandomTest> {
    let mut tests = Vec::new();
    for inertia in [1.5e-4, 6.5e-4] {
        for damping in [5e-4, 4e-3] {
            for snr in [4.0, 40.0] {
                for (lag, duration) in [(0.004, 20.0), (0.0, 40.0), (-0.0015, 20.0)] {
                    tests.push(RandomTest {
                        inertia,
                        damping,
                        snr,
                        lag,
                        duration,
                        command,
                        counts: 131_072.0,
                        span,
                        declared,
                        coulomb: 0.0,
                        held: false,
                    });
                }
            }
        }
    }
    tests
}

#[test]
fn random_torque_intervals_hold_the_truth() {
    let (mut inertia, mut damping) = (Score::default(), Score::default());
    for (index, test) in grid(true, QUARTER, true).iter().enumerate() {
        for repeat in 0..2 {
            let log = test.log(1000 * index as u64 + repeat);
            let found = random_torque::identify(&log, 1.0).unwrap_or_else(|e| panic!("{test:?}: {e}"));
            inertia.add(found.result.inertia, test.inertia);
            damping.add(found.result.damping, test.damping);
            assert!((found.result.lag.value - test.lag).abs() < 5e-4, "{test:?}: {:?}", found.result.lag);
        }
    }
    eprintln!("inertia {inertia}\ndamping {damping}");
    let (least, most) = bounds(inertia.count(), 0.90, 0.98);
    for score in [&inertia, &damping] {
        assert!((least..=most).contains(&score.inside), "{score}, expected {least}…{most}");
        let (bias, error) = score.bias();
        assert!(bias.abs() < 3.3 * error, "{score}: biased");
    }
}

/// The score over hundreds of replicates: `--release -- --ignored --nocapture`.
#[test]
#[ignore = "slow: the score, not a check"]
fn random_torque_score() {
    let repeats: u64 = std::env::var("GEARWISE_SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(25);
    let cases = [
        (false, SAMPLE, true),
        (false, QUARTER, true),
        (false, SAMPLE, false),
        (true, SAMPLE, true),
        (true, QUARTER, true),
        (true, SAMPLE, false),
        (true, QUARTER, false),
    ];
    for (command, span, declared) in cases {
        let (mut all_inertia, mut all_damping) = (Score::default(), Score::default());
        for (index, test) in grid(command, span, declared).iter().enumerate() {
            let (mut inertia, mut damping) = (Score::default(), Score::default());
            let (mut h1, mut vaf) = (0.0, 0.0);
            for repeat in 0..repeats {
                let log = test.log(1_000_000 + 1000 * index as u64 + repeat);
                let found = random_torque::identify(&log, 1.0).unwrap_or_else(|e| panic!("{test:?}: {e}"));
                for scores in [&mut inertia, &mut all_inertia] {
                    scores.add(found.result.inertia, test.inertia);
                }
                for scores in [&mut damping, &mut all_damping] {
                    scores.add(found.result.damping, test.damping);
                }
                h1 += found.gain.0 / test.inertia / repeats as f64;
                vaf += found.refined.0 / test.inertia / repeats as f64;
            }
            println!(
                "J {:.1e} B {:.1e} snr {:2} lag {:+.1} ms {} s command {command}: J {inertia}; B {damping}; gain {h1:.4} vaf {vaf:.4}",
                test.inertia,
                test.damping,
                test.snr,
                1e3 * test.lag,
                test.duration
            );
        }
        println!("command {command} span {span} declared {declared}: J {all_inertia}; B {all_damping}");
        assert!(all_inertia.share() >= 0.90 && all_damping.share() >= 0.90);
        if command {
            assert!(all_inertia.share() <= 0.98 && all_damping.share() <= 0.98);
            let (bias, error) = all_inertia.bias();
            assert!(bias.abs() < 5e-3 + 3.0 * error, "{all_inertia}");
        }
    }
}

/// Without a command H1 and H2 bracket the truth, H1 by the noise of the torque sensor.
#[test]
fn noise_biases_h1_and_the_command_does_not() {
    let test = RandomTest {
        inertia: 6.5e-4,
        damping: 2e-3,
        snr: 8.0,
        lag: 0.004,
        duration: 40.0,
        command: true,
        counts: 131_072.0,
        span: QUARTER,
        declared: true,
        coulomb: 0.0,
        held: false,
    };
    let found = random_torque::identify(&test.log(5), 1.0).unwrap();
    let [h1, h2] = found.bracket;
    // The sensor's noise is white up to 550 Hz, the torque within 40: in the band the ratio is far better than 8.
    assert!(h1.inertia.value > 1.005 * test.inertia, "{:?}", h1.inertia);
    assert!(h2.inertia.value < h1.inertia.value);
    assert!((found.result.inertia.value / test.inertia - 1.0).abs() < 0.01, "{:?}", found.result.inertia);
    let blind = random_torque::identify(&RandomTest { command: false, ..test }.log(5), 1.0).unwrap();
    let (low, high) = blind.result.inertia.interval();
    assert!(low < test.inertia && test.inertia < high);
    assert!(blind.result.inertia.standard_uncertainty > found.result.inertia.standard_uncertainty);
}

/// A velocity that is a difference of counts over a whole sample reads low at high frequency. It is taken out where the
/// log says so, found where it does not (with a command), and in the bracket without.
#[test]
fn a_differenced_velocity_does_not_pass_for_inertia() {
    let said = RandomTest {
        inertia: 1.5e-4,
        damping: 5e-4,
        snr: 4000.0,
        lag: 0.0,
        duration: 40.0,
        command: true,
        counts: 1_048_576.0,
        span: SAMPLE,
        declared: true,
        coulomb: 0.0,
        held: false,
    };
    let silent = RandomTest { declared: false, ..said };
    let blind = RandomTest { command: false, ..silent };
    for (test, averaging) in [
        (said, random_torque::Averaging::Declared),
        (silent, random_torque::Averaging::Fitted),
        (blind, random_torque::Averaging::Bracketed),
    ] {
        let found = random_torque::identify(&test.log(3), 1.0).unwrap();
        assert_eq!(found.averaging, averaging);
        let (low, high) = found.result.inertia.interval();
        assert!(low < test.inertia && test.inertia < high, "{averaging:?}: {:?}", found.result.inertia);
        if averaging == random_torque::Averaging::Fitted {
            let ms = 1e3 * found.result.averaging.value.sqrt();
            assert!((ms - 1e3 / motor_bench::RATE).abs() < 0.1, "{ms} ms");
        }
    }
    // What it is good for: with nothing said of it and nothing done, J is beyond its ±.
    let wrong = gearwise::measured::Log { difference: Some(0.0), ..said.log(3) };
    let found = random_torque::identify(&wrong, 1.0).unwrap().result.inertia;
    assert!(found.interval().0 > said.inertia, "{found:?}");
}

/// Inertia over logs of one machine, each with its own noise.
fn inertia_score(test: RandomTest, seeds: std::ops::Range<u64>) -> Score {
    let mut score = Score::default();
    for seed in seeds {
        let found = random_torque::identify(&test.log(seed), 1.0).unwrap_or_else(|e| panic!("{test:?}: {e}"));
        score.add(found.result.inertia, test.inertia);
    }
    score
}

/// What is no linear machine with a smooth torque: Coulomb friction makes a random torque's answer look heavier, and
/// near half the sampling rate a torque that is held does. Neither is in the inertia.
#[test]
fn friction_and_a_held_torque_do_not_pass_for_inertia() {
    let smooth = RandomTest {
        inertia: 6.5e-4,
        damping: 2e-3,
        snr: 40.0,
        lag: 0.0,
        duration: 30.0,
        command: true,
        counts: 131_072.0,
        span: QUARTER,
        declared: true,
        coulomb: 0.04,
        held: false,
    };
    let held = RandomTest { coulomb: 0.0, held: true, declared: false, ..smooth };
    for test in [smooth, held] {
        let score = inertia_score(test, 7_000..7_020);
        eprintln!("{test:?}: {score}");
        let (least, _) = bounds(score.count(), 0.90, 0.98);
        assert!(score.inside >= least, "{test:?}: {score}");
        // Of a torque that is white up to half the sampling rate 0.2 % remain, within the ±: there the count alone judges.
        assert!(test.held || score.bias().0.abs() < 1.5e-3, "{test:?}: {score}");
    }
    let found = random_torque::identify(&smooth.log(7_100), 1.0).unwrap();
    let friction = found.result.friction.unwrap();
    assert_relative_eq!(friction.value, smooth.coulomb, max_relative = 0.1);
}

/// Without a command every log has its torque's noise to the same side: more logs do not make that smaller.
#[test]
fn a_bracket_does_not_average_out_over_logs() {
    let with = RandomTest {
        inertia: 6.5e-4,
        damping: 2e-3,
        snr: 6.0,
        lag: 0.0,
        duration: 20.0,
        command: false,
        counts: 131_072.0,
        span: QUARTER,
        declared: true,
        coulomb: 0.0,
        held: false,
    };
    let without = RandomTest { inertia: 1.5e-4, ..with };
    let empty = bench_of(Vec::new());
    for repeat in 0..3 {
        let seeds = || (0..4).map(|k| 9_000 + 10 * repeat + k);
        let removed = seeds().map(|s| gearwise::measured::Log { rotor: false, ..without.log(s + 5) });
        let logs = seeds().map(|s| with.log(s)).chain(removed).collect();
        let found = characterize(&Bench { logs, ..empty.clone() }).unwrap();
        for (name, truth) in [
            ("output_inertia_with_rotor", with.inertia),
            ("output_inertia_without_rotor", without.inertia),
            ("rotor_inertia", with.inertia - without.inertia),
        ] {
            let estimate = find(&found.outcomes, name).unwrap();
            let (low, high) = estimate.interval();
            assert!(low < truth && truth < high, "{name}: {low} {truth} {high}");
        }
    }
}

/// A bench without a motor's row, with these logs alone.
fn bench_of(logs: Vec<gearwise::measured::Log>) -> Bench {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bench.toml");
    let text = "ambient = \"22 degC\"\n[terminals]\nwinding = \"wye\"\nresistance = [\"1.4 ohm\", \"1.4 ohm\", \"1.4 \
                ohm\"]\nresistance_tolerance = \"0 ohm\"\ntemperature = \"25 degC\"\n";
    std::fs::write(&path, text).unwrap();
    let bench = read_for_row(&path, None, Vec::new()).unwrap_or_else(|e| panic!("{}", e[0]));
    assert_relative_eq!(bench.readings.ambient.unwrap(), AMBIENT, max_relative = 1e-12);
    Bench { logs, ..bench }
}

/// Coulomb and viscous friction over repeats of drag tests: both ways, with rests, with little and with no viscous part.
fn drag_coverage(repeats: u64) -> Vec<(String, Score)> {
    let mut scores = Vec::new();
    let empty = bench_of(Vec::new());
    for (viscous, scatter, both) in
        [(1.2e-4, 1e-3, true), (1.2e-4, 1e-3, false), (2e-5, 1e-3, true), (2e-5, 2e-3, false)]
    {
        let test = DragTest { coulomb: 0.015, viscous, scatter, both };
        let (mut coulomb, mut slope) = (Score::default(), Score::default());
        let mut r = Random::new(10, "drag");
        for _ in 0..repeats {
            let bench = Bench { logs: vec![test.log(&mut r)], ..empty.clone() };
            let found = characterize(&bench).unwrap();
            coulomb.add(find(&found.outcomes, "coulomb_friction").unwrap(), test.coulomb);
            if let Some(found) = find(&found.outcomes, "viscous_friction") {
                slope.add(found, viscous);
            }
        }
        scores.push((format!("Coulomb of {test:?}"), coulomb));
        // A viscous part that is often not found is right only when chance makes it large: no fair count.
        if slope.count() == repeats {
            scores.push((format!("viscous of {test:?}"), slope));
        }
    }
    scores
}

/// Rest is no fixed speed: rows of a table, a slow sweep and steps show the same friction of a joint as of its motor.
#[test]
fn drag_of_a_slow_joint_is_found() {
    let (coulomb, viscous) = (0.572, 0.522);
    let tables: [fn(usize) -> f64; 3] = [
        // Three rows at each tenth of a rad/s, through zero.
        |k| ((k / 3) as f64 - 15.0) / 10.0,
        // A triangle from −1.5 to 1.5 rad/s and back.
        |k| 1.5 - 3.0 * (k as f64 / 200.0 - 1.0).abs(),
        // Steps of four seconds, with rest between them.
        |k| if k / 40 % 2 == 0 { 0.0 } else { 0.3 * ((k / 80) as f64 - 1.5) },
    ];
    for (rows, table) in [93, 401, 400].into_iter().zip(tables) {
        for factor in [1.0, 0.1, 30.0] {
            let mut r = Random::new(rows, "slow drag");
            let speed: Vec<f64> = (0..rows as usize).map(|k| factor * (table(k) + 0.004 * r.normal())).collect();
            let drag = |k: usize| {
                let w: f64 = table(k);
                let sign = if w == 0.0 { 0.0 } else { w.signum() };
                coulomb * sign + viscous * w + 0.1
            };
            let torque = (0..rows as usize).map(|k| drag(k) + 0.02 * r.normal()).collect();
            let time = (0..rows).map(|k| 0.1 * k as f64).collect();
            let log = log(BenchKind::Drag, time, vec![(Channel::MotorVelocity, speed), (Channel::Torque, torque)]);
            let found = characterize(&bench_of(vec![log])).unwrap();
            let of = |name| find(&found.outcomes, name).unwrap_or_else(|| panic!("{rows} {factor}: {name}"));
            for (estimate, truth) in [(of("coulomb_friction"), coulomb), (of("viscous_friction"), viscous / factor)] {
                assert_relative_eq!(estimate.value, truth, max_relative = 0.05);
                assert!((estimate.value - truth).abs() < 2.0 * estimate.half_width(), "{rows} {factor}: {estimate:?}");
            }
        }
    }
}

/// Thermal resistances and time constants over repeats of steps of current: with and without cooling, with sensors that
/// wander.
fn heat_coverage(repeats: u64) -> Vec<(String, Score)> {
    let names = [
        "thermal_resistance_winding_housing",
        "thermal_resistance_housing_ambient",
        "thermal_time_constant_winding",
        "thermal_time_constant_housing",
    ];
    let mut scores = Vec::new();
    let empty = bench_of(Vec::new());
    // Rows are two seconds apart: at 1201 s the current is switched between two of them.
    let durations = [(1200.0, 1800.0), (1200.0, 1800.0), (2000.0, 2000.0), (1201.0, 1800.0)];
    for (duration, wander) in durations.into_iter().zip([0.0, 0.2, 0.2, 0.0]) {
        let test =
            HeatTest { resistances: (1.6, 2.4), constants: (28.0, 420.0), copper: 0.7, current: 5.0, duration, wander };
        let mut r = Random::new(11, "heat");
        let mut own = names.map(|name| (format!("{name} of {duration:?} s, wander {wander} K"), Score::default()));
        for _ in 0..repeats {
            let bench = Bench { logs: vec![test.log(&mut r)], ..empty.clone() };
            let found = characterize(&bench).unwrap();
            for ((name, truth), (_, score)) in names.iter().zip([1.6, 2.4, 28.0, 420.0]).zip(&mut own) {
                score.add(find(&found.outcomes, name).unwrap(), truth);
            }
        }
        scores.extend(own);
    }
    scores
}

#[test]
fn intervals_of_friction_and_heat_hold_the_truth() {
    for (name, score) in drag_coverage(150).into_iter().chain(heat_coverage(25)) {
        eprintln!("{name}: {score}");
        let (least, most) = bounds(score.count(), 0.90, 0.98);
        assert!((least..=most).contains(&score.inside), "{name}: {score}, expected {least}…{most}");
    }
}

#[test]
#[ignore = "slow: the score, not a check"]
fn score_of_friction_and_heat() {
    for (name, score) in drag_coverage(2000).into_iter().chain(heat_coverage(400)) {
        println!("{name}: {score}");
        assert!((0.90..=0.98).contains(&score.share()), "{name}: {score}");
    }
}

/// A calibration that is stated is in the ±, once, and does not average out over logs.
#[test]
fn a_gain_that_is_not_exact_is_in_the_interval() {
    let mut r = Random::new(12, "gain");
    let logs: Vec<gearwise::measured::Log> = (0..4).map(|_| stall_log(&mut r, 0.1, 0.001)).collect();
    let exact = characterize(&bench_of(logs.clone())).unwrap();
    let said =
        logs.into_iter().map(|l| gearwise::measured::Log { gains: [(Channel::Torque, 0.02)].into(), ..l }).collect();
    let stated = characterize(&bench_of(said)).unwrap();
    let k = |c: &Characterization| find(&c.outcomes, "torque_constant").unwrap();
    assert_relative_eq!(k(&exact).value, k(&stated).value, max_relative = 1e-12);
    assert!(k(&exact).relative() < 0.01, "{:?}", k(&exact));
    assert!(k(&stated).relative() > 0.0199 && k(&stated).relative() < 0.023, "{:?}", k(&stated));
    let notes = |c: &Characterization| {
        let stall = c.outcomes.iter().find(|o| o.test == "stall").unwrap();
        stall.findings.iter().filter(|f| f.check == "calibration").map(|f| f.text.clone()).collect::<Vec<_>>()
    };
    assert!(notes(&exact)[0].contains("the torque and of the current"), "{:?}", notes(&exact));
    assert!(notes(&stated)[0].contains("the gain of the current counts as exact"), "{:?}", notes(&stated));
}

/// A stalled log: steps of current with noise on samples, and a scatter from step to step (position, hysteresis).
fn stall_log(r: &mut Random, slope: f64, scatter: f64) -> gearwise::measured::Log {
    let zero = 0.05 * r.normal();
    let (mut time, mut current, mut torque) = (Vec::new(), Vec::new(), Vec::new());
    for step in 0..17 {
        let i = f64::from(step) - 8.0;
        let off = scatter * r.normal();
        for k in 0..150 {
            time.push((f64::from(step) * 150.0 + f64::from(k)) * 0.02);
            // The current needs a while.
            let settled = i - 0.8 * (-f64::from(k) / 5.0).exp();
            current.push(settled + 0.03 * r.normal());
            torque.push(slope * settled + zero + off + 0.01 * r.normal());
        }
    }
    log(BenchKind::Stall, time, vec![(Channel::Current, current), (Channel::Torque, torque)])
}

fn stall_coverage(repeats: u64) -> (Score, Score) {
    let (mut single, mut pooled) = (Score::default(), Score::default());
    let mut r = Random::new(7, "stall");
    for _ in 0..repeats {
        let truth = 0.1;
        let slope = |log: &gearwise::measured::Log| {
            let (points, moved) = stall::points(log, 1.0);
            assert!((15..=17).contains(&points.len()) && moved == 0, "{} steps", points.len());
            gearwise::measured::characterize::line::Line::through(points).unwrap().slope()
        };
        single.add(slope(&stall_log(&mut r, truth, 0.004)), truth);
        // Five logs whose own slopes differ by 4 %.
        let logs: Vec<Estimate> = (0..5)
            .map(|_| {
                let own = truth * (1.0 + 0.04 * r.normal());
                slope(&stall_log(&mut r, own, 0.004))
            })
            .collect();
        pooled.add(pool(&logs).unwrap().estimate, truth);
    }
    (single, pooled)
}

fn terminal_coverage(repeats: u64) -> Score {
    let mut score = Score::default();
    let mut r = Random::new(8, "terminals");
    for _ in 0..repeats {
        // An instrument of ± 0.4 % (95 %), common to the three, and contacts that scatter by 0.2 %.
        let truth = 1.41;
        let common = 0.004 / 1.96 * r.normal();
        let readings: Vec<f64> = (0..3).map(|_| truth * (1.0 + common + 0.002 * r.normal())).collect();
        score.add(terminals::mean(&readings, Some(0.004 * truth)).unwrap(), truth);
    }
    score
}

fn backdrive_coverage(repeats: u64) -> Score {
    let mut score = Score::default();
    let mut r = Random::new(9, "backdrive");
    for _ in 0..repeats {
        let truth = 0.094;
        let speed: Vec<f64> = (1..=8).map(|k| 20.0 * f64::from(k) * if k % 2 == 0 { -1.0 } else { 1.0 }).collect();
        let voltage: Vec<f64> = speed.iter().map(|w| truth * w.abs() + 0.05 + 0.06 * r.normal()).collect();
        let time = (0..8).map(f64::from).collect();
        let log = log(BenchKind::Backdrive, time, vec![(Channel::MotorVelocity, speed), (Channel::Voltage, voltage)]);
        score.add(backdrive::line(&log, 1.0).unwrap().slope(), truth);
    }
    score
}

#[test]
fn intervals_of_lines_and_readings_hold_the_truth() {
    let (single, pooled) = stall_coverage(150);
    for (name, score) in [
        ("stall", single),
        ("pooled", pooled),
        ("terminals", terminal_coverage(400)),
        ("backdrive", backdrive_coverage(400)),
    ] {
        eprintln!("{name}: {score}");
        let (least, most) = bounds(score.count(), 0.90, 0.98);
        assert!((least..=most).contains(&score.inside), "{name}: {score}, expected {least}…{most}");
        let (bias, error) = score.bias();
        assert!(bias.abs() < 4.0 * error, "{name}: {score}");
    }
}

#[test]
#[ignore = "slow: the score, not a check"]
fn score_of_lines_and_readings() {
    let (single, pooled) = stall_coverage(1000);
    for (name, score) in [
        ("stall", single),
        ("pooled", pooled),
        ("terminals", terminal_coverage(4000)),
        ("backdrive", backdrive_coverage(4000)),
    ] {
        println!("{name}: {score}");
        assert!((0.90..=0.98).contains(&score.share()), "{name}: {score}");
    }
}
