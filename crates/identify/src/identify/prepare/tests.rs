use super::super::steady::{CONSTANT, OVER_TIME, bench_of, noise};
use super::*;

/// A dynamometer's log in SI: what is done to a row of time, speed, current and torque.
fn found(change: impl Fn(usize, &mut Vec<f64>)) -> (Bench, Vec<About>) {
    let row = |k: usize| {
        let t = 2e-3 * k as f64;
        let w = 60.0 * (3.0 * t).sin() + 25.0 * (7.1 * t).cos() + 0.2 * noise(k);
        let i = 3.0 * (11.0 * t).sin() + 2.0 * (17.3 * t).cos() + 0.01 * noise(k + 7000);
        let mut row = vec![t, w, i, 6.0 * CONSTANT * i + 0.01 * noise(k + 9000)];
        change(k, &mut row);
        row
    };
    let rows: Vec<Vec<f64>> = (0..3000).map(row).collect();
    let (bench, findings) = prepare(&bench_of("dynamometer", 6.0, &OVER_TIME, &[rows], 0));
    (bench, findings.into_iter().map(|f| f.about).collect())
}

#[test]
fn a_good_log_is_left_as_it_is() {
    let (bench, found) = found(|_, _| {});
    assert_eq!(found, []);
    assert!(bench.logs[0].excluded.is_empty() && bench.logs[0].len() == 3000);
    assert!(bench.logs[0].channels.values().flatten().all(|v| v.is_finite()));
}

#[test]
fn a_current_that_stops_while_the_machine_moves_is_left_out() {
    let mut last = 0.0;
    let frozen = std::cell::RefCell::new(&mut last);
    let (bench, found) = found(|k, row| {
        if (1000..1040).contains(&k) {
            row[2] = **frozen.borrow();
        } else {
            **frozen.borrow_mut() = row[2];
        }
    });
    let [About::Stale { channel: Channel::Current, from, to }] = found[..] else { panic!("{found:?}") };
    assert!((from - 1.998).abs() < 1e-9 && (to - 2.078).abs() < 1e-9, "{from} {to}");
    let log = &bench.logs[0];
    assert!(log.channels[&Channel::Current][1020].is_nan() && log.channels[&Channel::Current][1050].is_finite());
}

#[test]
fn what_a_driver_repeats_is_no_sample() {
    // One channel, seven rows each.
    let held = std::cell::Cell::new(0.0);
    let (bench, some) = found(|k, row| {
        if k % 7 == 0 {
            held.set(row[3]);
        }
        row[3] = held.get();
    });
    assert_eq!(some, [About::Held { channels: vec![Channel::Torque], rows: 7.0, whole: false }]);
    let log = &bench.logs[0];
    assert_eq!(log.fresh[&Channel::Torque], 7.0);
    assert_eq!(log.channels[&Channel::Torque].iter().filter(|v| v.is_finite()).count(), 3000_usize.div_ceil(7));
    // All of them: only the fresh rows are data.
    let held = std::cell::RefCell::new(Vec::new());
    let (bench, all) = found(|k, row| {
        if k % 5 == 0 {
            *held.borrow_mut() = row[1..].to_vec();
        }
        row[1..].copy_from_slice(&held.borrow());
    });
    assert!(matches!(&all[..], [About::Held { channels, rows: 5.0, whole: true }] if channels.len() == 3), "{all:?}");
    assert_eq!(bench.logs[0].len(), 600);
    // A coarse reading of a slow signal goes step by step: it repeats, and is not held.
    let (_, coarse) = found(|_, row| row[3] = (row[3] / 0.4).round() * 0.4);
    assert!(!coarse.iter().any(|f| matches!(f, About::Held { .. })), "{coarse:?}");
}

#[test]
fn a_sensor_that_stops_at_its_end_and_a_wild_sample_are_left_out() {
    let (bench, ends) = found(|_, row| row[3] = row[3].min(2.5));
    let [About::Clipped { channel: Channel::Torque, at: 2.5, share }] = ends[..] else { panic!("{ends:?}") };
    assert!(share > 0.002 && share < 0.2 && !bench.logs[0].excluded.is_empty(), "{share}");
    let (bench, wild) = found(|k, row| row[3] += if k == 1500 { 40.0 } else { 0.0 });
    assert_eq!(wild, [About::Spikes { channel: Channel::Torque, count: 1 }]);
    assert!(bench.logs[0].channels[&Channel::Torque][1500].is_nan());
    // Where two channels leap together it is the machine.
    let (_, both) = found(|k, row| {
        if k == 1500 {
            (row[2], row[3]) = (60.0, 40.0);
        }
    });
    assert_eq!(both, []);
}

#[test]
fn uneven_times_are_said() {
    let (_, found) = found(|k, row| row[0] += 6e-4 * (noise(k + 100) + 1.0));
    let [About::Irregular { short, usual, long }] = found[..] else { panic!("{found:?}") };
    assert!(short < usual && usual < long && (usual / 2e-3 - 1.0).abs() < 0.05);
}

/// A machine at rest: its encoder stands, while the velocity and the torque have their noise. Then it turns, and the encoder
/// stands again.
#[test]
fn an_encoder_that_stands_at_rest_is_not_stale() {
    let stale = |stuck: bool| {
        let position = "motor_position = { name = \"4\", unit = \"rad\" }";
        let columns: Vec<&str> = OVER_TIME.iter().copied().chain([position]).collect();
        let row = |k: usize| {
            let t = 2e-3 * k as f64;
            let (speed, angle) = if t < 0.5 { (0.0, 0.0) } else { (20.0, 20.0 * (t - 0.5)) };
            let angle = if stuck && (1000..1040).contains(&k) { 30.0 } else { angle };
            let i = 0.01 * noise(k + 3000) + if t < 0.5 { 0.0 } else { (3.0 * t).sin() };
            vec![t, speed + 0.1 * noise(k), i, 0.6 * i + 0.01 * noise(k + 9000), (angle / 1e-3).round() * 1e-3]
        };
        let bench = bench_of("dynamometer", 6.0, &columns, &[(0..3000).map(row).collect()], 0);
        let found = prepare(&bench).1.into_iter().map(|f| f.about);
        found.filter(|about| matches!(about, About::Stale { .. })).collect::<Vec<_>>()
    };
    assert_eq!(stale(false), []);
    assert!(matches!(stale(true)[..], [About::Stale { channel: Channel::MotorPosition, from, .. }] if from == 2.0));
}

/// A position alone that stands and then leaps by what it missed is stale; one that a coarse encoder lets stand at a slow turn,
/// or that rests, is not. A torque of coarse steps repeats a value now and then, but not for long.
#[test]
fn what_leaps_after_it_stood_was_stale() {
    let stale = |stuck: bool, rests: bool| {
        let columns = [
            "time = { name = \"0\", unit = \"s\" }",
            "duty = { name = \"1\", unit = \"1\" }",
            "output_position = { name = \"2\", unit = \"rad\" }",
            "supply = { name = \"3\", unit = \"V\" }",
        ];
        let row = |k: usize| {
            let t = 5e-3 * k as f64;
            let at = |t: f64| if rests { (2.0 * t).sin().max(0.0) } else { (2.0 * t).sin() };
            let angle = if stuck && (620..700).contains(&k) { at(5e-3 * 620.0) } else { at(t) };
            vec![t, (2.0 * t).cos(), (angle / 1e-3).round() * 1e-3, 12.0]
        };
        let bench = bench_of("servo", 6.0, &columns, &[(0..3000).map(row).collect()], 0);
        let found = prepare(&bench).1.into_iter().map(|f| f.about);
        found.filter(|about| matches!(about, About::Stale { .. })).collect::<Vec<_>>()
    };
    assert!(matches!(stale(true, false)[..], [About::Stale { channel: Channel::OutputPosition, .. }]));
    assert_eq!(stale(false, false), []);
    assert_eq!(stale(false, true), []);
    let (_, coarse) = found(|_, row| row[3] = (row[3] / 0.02).round() * 0.02);
    assert_eq!(coarse, []);
}
