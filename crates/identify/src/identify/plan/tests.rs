use super::*;
use crate::identify::steady::{CONSTANT, OVER_TIME, bench_of, noise};
use crate::identify::{Options, identified};

/// Two logs of a dynamometer whose motor has a friction of 0.05 N·m that its row does not have, at a speed \[rad/s\] and a
/// current \[A\] of the time.
fn bench(speed: fn(f64) -> f64, current: fn(f64) -> f64, friction: f64) -> Bench {
    let logs: Vec<Vec<Vec<f64>>> = (0..2)
        .map(|log| {
            let row = |k: usize| {
                let t = 5e-3 * k as f64;
                let w = speed(t + 0.3 * f64::from(log)) + 0.02 * noise(k + 70_000 * (log as usize + 1));
                let i = current(t);
                let torque = 6.0 * (CONSTANT * i - friction * w.signum());
                vec![t, w, i, torque + 0.02 * noise(k + 50_000 * (log as usize + 1))]
            };
            (0..1400).map(row).collect()
        })
        .collect();
    bench_of("dynamometer", 6.0, &OVER_TIME, &logs, 0)
}

/// One current, so that friction may go with the load or not.
fn one_current(t: f64) -> f64 {
    3.0 + 1e-3 * (37.0 * t).sin()
}

fn any_speed(t: f64) -> f64 {
    40.0 * (3.0 * t).sin() * (0.7 * t).cos()
}

fn any_current(t: f64) -> f64 {
    2.0 * (5.0 * t).sin() + 1.5 * (11.3 * t).cos()
}

fn planned(bench: &Bench, wanted: &Wanted) -> Result<Plan, NoPlan> {
    let said = identified(bench, &Options::default()).expect("an answer");
    plan(bench, &said, wanted)
}

/// At one current friction may go with the load or not; the run has other currents, none larger than the logs had, because the row
/// has no rating, and says so.
#[test]
fn a_confounded_name_gets_a_run_within_what_the_logs_reached() {
    let bench = bench(any_speed, one_current, 0.05);
    let plan = planned(&bench, &Wanted::default()).unwrap_or_else(|why| panic!("{why:?}"));
    assert_eq!((plan.kind, plan.driven), (BenchKind::Dynamometer, Driven::Both));
    assert!(plan.duration <= 20.0 && plan.duration > 19.9, "{}", plan.duration);
    assert_eq!(plan.points.len(), (plan.duration / 0.01).round() as usize + 1);
    for s in &plan.separations {
        assert!(s.now < s.after, "{s:?}");
        assert!(s.until.is_some_and(|t| (t <= plan.duration) == s.is_apart()), "{s:?}");
    }
    assert!(plan.separations.iter().all(Separation::is_apart), "{:?}", plan.separations);
    for limit in &plan.limits {
        let assumed = limit.of == Quantity::Acceleration && limit.source == Source::Assumed;
        assert!(limit.source == Source::Reached || assumed, "{limit:?}");
        assert!(limit.used <= limit.most * (1.0 + 1e-6), "{limit:?}");
    }
    let has = |of: Quantity| plan.limits.iter().any(|l| l.of == of);
    assert!([Quantity::Speed, Quantity::Angle, Quantity::Torque, Quantity::Heat].into_iter().all(has));
    let largest = plan.points.iter().map(|p| p.speed.abs()).fold(0.0, f64::max);
    assert!(largest < 40.1 && plan.limits.iter().any(Limit::bounds), "{largest} {:?}", plan.limits);
    // Less travel is kept too.
    let wanted = Wanted { time: Some(12.0), travel: Some(0.5) };
    let short = planned(&bench, &wanted).unwrap_or_else(|why| panic!("{why:?}"));
    let angles = || short.points.iter().map(|p| p.angle / 6.0);
    let travel = angles().fold(f64::NEG_INFINITY, f64::max) - angles().fold(f64::INFINITY, f64::min);
    assert!(travel <= 0.501 && (short.duration - 12.0).abs() < 1e-9, "{travel}");
    assert!(short.limits.iter().any(|l| l.of == Quantity::Angle && l.source == Source::Asked));
}

/// The same set-points whatever the number of threads.
#[test]
fn the_plan_is_the_same_for_any_number_of_threads() {
    let bench = bench(any_speed, one_current, 0.05);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| planned(&bench, &Wanted { time: Some(8.0), travel: None }))
    };
    let plan = with(1);
    assert!(plan.is_ok(), "{plan:?}");
    assert_eq!(plan, with(3));
}

/// Where the name is certain, or nothing can be learnt, there is no run; nor is one shorter than four passages.
#[test]
fn without_a_question_there_is_no_run() {
    let certain = bench(any_speed, any_current, 0.05);
    assert_eq!(planned(&certain, &Wanted::default()), Err(NoPlan::NothingOpen));
    let open = bench(any_speed, one_current, 0.05);
    let short = Wanted { time: Some(3.0), travel: None };
    assert_eq!(planned(&open, &short), Err(NoPlan::TooShort(4.0)));
    assert_eq!(plan(&open, &[], &Wanted::default()), Err(NoPlan::TeachesNothing));
}

/// Ratings of the row bound the run where it has them.
#[test]
fn ratings_of_the_row_come_first() {
    let mut bench = bench(any_speed, one_current, 0.05);
    if let Some(motor) = bench.declared.motor.as_mut() {
        (motor.max_speed, motor.peak_current, motor.continuous_current) = (Some(25.0), Some(2.0), Some(1.0));
    }
    let plan = planned(&bench, &Wanted::default()).unwrap_or_else(|why| panic!("{why:?}"));
    let limit = |of: Quantity| plan.limits.iter().find(|l| l.of == of).copied().expect("a limit");
    let speed = limit(Quantity::Speed);
    assert_eq!((speed.most, speed.source), (25.0, Source::Declared("max_speed")));
    let heat = limit(Quantity::Heat);
    assert_eq!((heat.most, heat.source), (1.0, Source::Declared("continuous_current")));
    assert!((limit(Quantity::Torque).most - 2.0 * CONSTANT).abs() < 1e-12);
    assert!(plan.points.iter().all(|p| p.speed.abs() <= 25.0 + 1e-6 && p.current.abs() <= 2.0 + 1e-6));
}
