use std::cell::RefCell;

use super::super::steady::{CONSTANT, OVER_TIME, add, bench, bench_of, moving, noise, work, work_on};
use super::*;

/// Searches for lags where the error of each block is made up: of the lags that are tried, and the block.
fn found(bench: &Bench, target: Target, error: impl Fn(f64, f64, usize) -> f64) -> (Corrections, usize) {
    let tried = RefCell::new((Corrections::none(bench.logs.len()), 0));
    let setting = |corrections: Corrections| {
        let mut tried = tried.borrow_mut();
        *tried = (corrections.clone(), tried.1 + 1);
        Setting { corrections, band: None, rows: 24_000, samples: usize::MAX }
    };
    let errors = |_: &Balance| {
        let lags = tried.borrow().0.clone();
        (0..30).map(|block| error(lags.target_lag, lags.motion_lag, block)).collect()
    };
    let best = lags(bench, target, Corrections::none(bench.logs.len()), &setting, &errors);
    let looks = tried.borrow().1;
    (best, looks)
}

/// Blocks do not all have the same.
fn uneven(block: usize) -> f64 {
    1.0 + 0.1 * noise(block)
}

/// Both lags are found to a part of a sample wherever they lie in the range, which is forty samples; of a current that is
/// compared with a known load only the motion can be late.
#[test]
fn lags_are_where_the_error_is_least() {
    let bench = moving(600, false);
    for (late, motion) in [(0.004, 0.0), (-0.0113, 0.007), (0.03, -0.02), (0.0007, 0.0004), (0.037, 0.0)] {
        let valley = |t: f64, m: f64, block: usize| {
            let far = ((t - late) / 1e-3).powi(2) + ((m - motion) / 1e-3).powi(2) + 0.3 * (t - late) * (m - motion);
            (0.01 + far) * uneven(block)
        };
        let (best, looks) = found(&bench, Target::Torque, valley);
        assert!((best.target_lag - late).abs() < 1e-4, "{best:?} {late}");
        assert!((best.motion_lag - motion).abs() < 1e-4, "{best:?} {motion}");
        // Twice seventeen and twice five places and the steps of the search, and no more.
        assert!(looks < 110, "{looks}");
    }
    // What goes on to the end of the search is no lag.
    for late in [0.0395, 0.06] {
        let (best, _) = found(&bench, Target::Torque, |t, m, block| {
            (0.01 + ((t - late) / 1e-3).powi(2) + (m / 1e-3).powi(2)) * uneven(block)
        });
        assert_eq!((best.target_lag, best.motion_lag), (0.0, 0.0), "{late}");
    }
    let steep = |t: f64, m: f64, block: usize| {
        uneven(block) * (0.01 + ((t - 0.004) / 1e-3).powi(2) + ((m + 0.003) / 1e-3).powi(2))
    };
    let row = |k: usize| vec![1e-3 * k as f64, 40.0 * (0.03 * k as f64).sin() + noise(k), noise(k + 900)];
    let free = bench_of("free", 6.0, &OVER_TIME[..3], &[(0..600).map(row).collect()], 0);
    let (best, _) = found(&free, Target::Drive, steep);
    assert_eq!(best.target_lag, 0.0);
    assert!((best.motion_lag + 0.003).abs() < 1e-4, "{best:?}");
    let far = |t: f64, _: f64, block: usize| uneven(block) * (1.0 + 30.0 * (0.2 - t));
    let (best, _) = found(&bench, Target::Torque, far);
    assert_eq!(best.target_lag, 0.0);
}

/// A lag has to take away 2 % of the squared error, and more than scatter between blocks does.
#[test]
fn a_lag_is_worth_two_percent_and_no_chance() {
    let bench = moving(600, false);
    let late = 0.005;
    // Away from the place by more than two samples the error is whole.
    let well = |t: f64| (1.0 - ((t - late) / 2e-3).powi(2)).max(0.0);
    for (share, told) in [(0.019, false), (0.021, true), (0.2, true)] {
        let (best, _) = found(&bench, Target::Torque, |t, _, block| uneven(block) * (1.0 - share * well(t)));
        assert_eq!(best.target_lag != 0.0, told, "{share}: {best:?}");
        assert!(!told || (best.target_lag - late).abs() < 2e-4);
    }
    // A tenth less in sum, but from one block to the next it goes either way.
    for (scatter, told) in [(0.05, true), (6.0, false)] {
        let wild = |t: f64, _: f64, block: usize| 5.0 - (0.5 + scatter * noise(block)) * well(t);
        let (best, _) = found(&bench, Target::Torque, wild);
        assert_eq!(best.target_lag != 0.0, told, "{scatter}: {best:?}");
    }
}

/// Steady points and standing shafts have no lag; what is found again has to move by a part of a sample.
#[test]
fn lags_are_looked_for_where_there_is_time() {
    let setting = |corrections: Corrections| Setting { corrections, band: None, rows: 24_000, samples: usize::MAX };
    let points: Vec<[f64; 3]> = (0..200).map(|k| [50.0 * noise(k), 5.0 * noise(k + 500), noise(k + 900)]).collect();
    let steady = bench(6.0, &[points], 0);
    let of_steady = work(&steady);
    assert_eq!(find(&steady, Balance::clone(&of_steady.balance), &setting), Corrections::none(1));
    assert_eq!(refine(&steady, &of_steady, &Corrections::none(1), &setting), None);
    // A late sensor, over time: found, and found again from nothing; from what was found it does not move.
    let row = |k: usize| {
        let t = 1e-3 * k as f64;
        let current = |t: f64| 3.0 * (11.0 * t).sin() + 2.0 * (37.3 * t).cos();
        let speed = |t: f64| 60.0 * (3.0 * t).sin() + 25.0 * (17.1 * t).cos();
        let torque = 6.0 * (CONSTANT * current(t - 0.006) - 1e-3 * speed(t - 0.006)) + 0.02 * noise(k);
        vec![t, speed(t) + 0.2 * noise(k + 7000), current(t), torque]
    };
    let late = bench_of("dynamometer", 6.0, &OVER_TIME, &[(0..3000).map(row).collect()], 0);
    let of_late = work(&late);
    let corrected = find(&late, Balance::clone(&of_late.balance), &setting);
    assert!((corrected.target_lag - 0.006).abs() < 2e-4 && corrected.gains == [1.0], "{corrected:?}");
    let mut with_friction = work(&late);
    add(&mut with_friction, "viscous_friction", 0.0);
    let refined = refine(&late, &with_friction, &Corrections::none(1), &setting).expect("it moves");
    assert!((refined.target_lag - 0.006).abs() < 1e-4, "{refined:?}");
    let again = refine(&late, &with_friction, &refined, &setting);
    assert!(again.is_none_or(|a| (a.target_lag - refined.target_lag).abs() > 5e-5));
    // A standing shaft: the same columns say nothing of time.
    let stall: Vec<Vec<f64>> = (0..400).map(|k| vec![1e-3 * k as f64, 2.0 * noise(k), 1.2 * noise(k)]).collect();
    let columns = [
        OVER_TIME[0],
        "current = { name = \"1\", unit = \"A\", convention = \"q_axis\" }",
        "torque = { name = \"2\", unit = \"N*m\", side = \"output\" }",
    ];
    let stall = bench_of("stall", 6.0, &columns, &[stall], 0);
    let corrected = find(&stall, Balance::clone(&work(&stall).balance), &setting);
    assert_eq!((corrected.target_lag, corrected.motion_lag), (0.0, 0.0));
    let balance = |bench: &Bench| work(bench).balance.clone();
    let shows = [&steady, &late, &stall].map(|bench| shows_lags(bench, &balance(bench)));
    assert_eq!(shows, [false, true, false]);
}

/// Each artefact is told once, with its channel, its log where there are several, and its unit.
#[test]
fn artefacts_are_told_with_their_channels() {
    let told = |work: &Work, corrections: &Corrections| -> Vec<(String, String, f64, String)> {
        let found = list(work, corrections);
        found.into_iter().map(|a| (a.kind.name().into(), a.channel, a.value, a.unit.into())).collect()
    };
    let entry = |kind: &str, channel: &str, value: f64, unit: &str| (kind.into(), channel.into(), value, unit.into());
    let points: Vec<[f64; 3]> = (0..200).map(|k| [50.0 * noise(k), 5.0 * noise(k + 500), noise(k + 900)]).collect();
    let one = bench(6.0, std::slice::from_ref(&points), 0);
    let of_one = work(&one);
    let none = Corrections::none(1);
    assert_eq!(told(&of_one, &none), []);
    let wrong = Corrections { gains: vec![-0.5], target_lag: 0.004, motion_lag: -0.001, ..none };
    let expected = [
        entry("sign", "torque", -1.0, "1"),
        entry("gain", "torque", 2.0, "1"),
        entry("lag", "torque", 0.004, "s"),
        entry("lag", "velocity", -0.001, "s"),
    ];
    assert_eq!(told(&of_one, &wrong), expected);
    let four = bench(6.0, &[points.clone(), points.clone(), points.clone(), points], 0);
    let of_four = work(&four);
    let wrong = Corrections { gains: vec![1.0, -1.0, 0.8, -1.25], ..Corrections::none(4) };
    let expected = [
        entry("sign", "torque of 1.csv", -1.0, "1"),
        entry("gain", "torque of 2.csv", 1.25, "1"),
        entry("sign", "torque of 3.csv", -1.0, "1"),
        entry("gain", "torque of 3.csv", 0.8, "1"),
    ];
    assert_eq!(told(&of_four, &wrong), expected);
    // The channel that is compared depends on the equation.
    let mut of_one = of_one;
    let late = Corrections { target_lag: 0.002, ..Corrections::none(1) };
    for (target, channel) in [
        (Target::Torque, "torque"),
        (Target::Drive, "current"),
        (Target::Voltage, "voltage"),
        (Target::WindUp, "position"),
        (Target::Position, "position"),
    ] {
        std::sync::Arc::make_mut(&mut of_one.balance).target = target;
        assert_eq!(told(&of_one, &late), [entry("lag", channel, 0.002, "s")]);
    }
}

/// Signs and gains of logs are read off their slopes, for a torque sensor only, and only with a declared constant.
#[test]
fn gains_are_looked_for_where_a_sensor_says_them() {
    let log = |factor: f64, place: usize| -> Vec<[f64; 3]> {
        (place..place + 200)
            .map(|k| {
                let i = 5.0 * noise(k + 5000);
                [50.0 * noise(k), i, factor * 6.0 * CONSTANT * i + 0.02 * noise(k + 9000)]
            })
            .collect()
    };
    let bench = bench(6.0, &[log(1.0, 0), log(-1.0, 200), log(0.7, 400), log(1.05, 600)], 0);
    let mut of_logs = work_on(&bench, Target::Torque);
    let found = gains(&of_logs.balance);
    assert_eq!((found[0], found[1], found[3]), (1.0, -1.0, 1.0));
    assert!((found[2] * 0.7 - 1.0).abs() < 0.03, "{found:?}");
    std::sync::Arc::make_mut(&mut of_logs.balance).base[0].declared = None;
    assert_eq!(gains(&of_logs.balance), [1.0; 4]);
    std::sync::Arc::make_mut(&mut of_logs.balance).target = Target::Voltage;
    assert_eq!(gains(&of_logs.balance), [1.0; 4]);
}

/// The wind-up between two positions is compared as it is: a late one looks like a spring.
#[test]
fn positions_have_no_lag() {
    let setting = |corrections: Corrections| Setting { corrections, band: None, rows: 24_000, samples: usize::MAX };
    let columns = [
        "time = { name = \"0\", unit = \"s\" }",
        "torque = { name = \"1\", unit = \"N*m\", side = \"output\" }",
        "current = { name = \"2\", unit = \"A\", convention = \"q_axis\" }",
        "position = { name = \"3\", unit = \"rad\", side = \"motor\" }",
        "output_position = { name = \"4\", unit = \"rad\", side = \"output\" }",
    ];
    let row = |k: usize| {
        let t = 1e-3 * k as f64;
        let motor = |t: f64| 9.0 * (7.0 * t).sin() + 4.0 * (19.0 * t).cos();
        let torque = 2.0 * (5.0 * t).sin() + noise(k);
        vec![t, torque, torque / 0.6, motor(t), motor(t - 0.006) / 6.0]
    };
    let bench = bench_of("dynamometer", 6.0, &columns, &[(0..2000).map(row).collect()], 0);
    let work = work_on(&bench, Target::WindUp);
    assert!(!shows_lags(&bench, &work.balance) && shows_lags(&bench, &work_on(&bench, Target::Torque).balance));
    assert_eq!(find(&bench, Balance::clone(&work.balance), &setting), Corrections::none(1));
    assert_eq!(refine(&bench, &work, &Corrections::none(1), &setting), None);
}

/// Of a log that is driven from outside: torque that rises with the speed both ways has the wrong sign; one way, or about one
/// speed, nothing says so.
#[test]
fn the_sign_of_a_passive_torque_needs_both_ways() {
    let columns = [OVER_TIME[0], OVER_TIME[1], "torque = { name = \"2\", unit = \"N*m\", side = \"output\" }"];
    let sign = |mean: f64, swing: f64, factor: f64| {
        let row = |k: usize| {
            let t = 2e-3 * k as f64;
            let speed = mean + swing * (2.0 * t).sin() + 0.05 * noise(k);
            // What the sensor at the output reads of an actuator that brakes.
            let braked = -6.0 * (0.02 * speed / 5.0 + 0.05 * (speed / 0.5).tanh());
            vec![t, speed, factor * braked + 0.01 * noise(k + 40_000)]
        };
        let bench = bench_of("drag", 6.0, &columns, &[(0..4000).map(row).collect()], 0);
        passive_signs(&bench, &work(&bench).balance)
    };
    assert_eq!(sign(0.0, 50.0, 1.0), [1.0]);
    assert_eq!(sign(0.0, 50.0, -1.0), [-1.0]);
    // One way only, and wavering about a speed.
    assert_eq!(sign(60.0, 40.0, -1.0), [1.0]);
    assert_eq!(sign(60.0, 2.0, -1.0), [1.0]);
}

/// A wrong sign of the current makes a zero that is twice what the sensor holds; an offset of a sensor is in what it reads.
#[test]
fn a_zero_beyond_all_that_was_read_is_said() {
    let found = |sign: f64, offset: f64| {
        let point = |k: usize| {
            let i = 5.0 + 0.5 * noise(k + 300);
            [50.0 * noise(k), sign * i, 6.0 * CONSTANT * i + offset + 0.01 * noise(k + 900)]
        };
        let bench = bench(6.0, &[(0..400).map(point).collect()], 0);
        let mut work = work(&bench);
        let none = Work { terms: Vec::new(), ..work.clone() };
        work.hold_as(&none);
        let (zeros, findings) = zeros(&work);
        assert_eq!(zeros.len(), 1);
        findings.into_iter().map(|f| f.about).collect::<Vec<_>>()
    };
    assert_eq!(found(1.0, 0.0), []);
    assert_eq!(found(1.0, 4.0), []);
    let [About::Zero { channel: Channel::Torque, zero, most }] = found(-1.0, 0.0)[..] else { panic!("it is said") };
    assert!((zero.abs() - 6.0).abs() < 0.1 && (most - 3.3).abs() < 0.05, "{zero} {most}");
}

/// The channel with the other sign of a machine with inertia and friction: of torque, current and motion one is turned, and two of
/// them are the third.
#[test]
fn the_channel_of_the_other_sign_is_told() {
    let setting = |corrections: Corrections| Setting { corrections, band: None, rows: 24_000, samples: usize::MAX };
    let told = |[of_motion, of_current, of_torque]: [f64; 3], inertia: f64, drag: f64| {
        let row = |k: usize| {
            let t = 1e-3 * k as f64;
            let current = 3.0 * (11.0 * t).sin() + 2.0 * (37.3 * t).cos();
            let (speed, change) =
                (60.0 * (3.0 * t).sin() + 25.0 * (17.1 * t).cos(), 180.0 * (3.0 * t).cos() - 427.5 * (17.1 * t).sin());
            let torque = 6.0 * (CONSTANT * current - inertia * change - drag * speed) + 0.02 * noise(k);
            vec![t, of_motion * (speed + 0.02 * noise(k + 7000)), of_current * current, of_torque * torque]
        };
        let bench = bench_of("dynamometer", 6.0, &OVER_TIME, &[(0..3000).map(row).collect()], 0);
        let corrected = find(&bench, Balance::clone(&work(&bench).balance), &setting);
        [corrected.signs[0].motion, corrected.signs[0].current, corrected.gains[0]]
    };
    for (inertia, drag) in [(1e-3, 0.0), (0.0, 2e-3), (5e-4, 1e-3)] {
        for turned in [[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]] {
            assert_eq!(told(turned, inertia, drag), turned, "{inertia} {drag}");
            let two = turned.map(|sign| -sign);
            assert_eq!(told(two, inertia, drag), turned, "{inertia} {drag}");
        }
    }
    // Nothing but the torque of the current: whose sign it is nobody knows, and the sensor's is taken.
    assert_eq!(told([1.0, -1.0, 1.0], 0.0, 0.0), [1.0, 1.0, -1.0]);
    assert_eq!(told([-1.0, 1.0, 1.0], 0.0, 0.0), [1.0, 1.0, 1.0]);
}
