use super::super::flexible::of_speed;
use super::super::hats::{KNOTS, hats_over};
use super::super::steady::{OVER_TIME, bench, bench_of, moving, moving_at, noise, work, work_on};
use super::*;

/// Hats over knots at quantiles: one at their own knot, zero at the others, together one everywhere.
#[test]
fn hats_are_a_partition_of_unity() {
    let values: Vec<f64> = (0..=80).map(|k| (f64::from(k) / 10.0).powi(2)).collect();
    let knots: Vec<f64> = (0..KNOTS).map(|k| (k as f64).powi(2)).collect();
    let hats = hats_over(values.clone());
    assert_eq!(hats.len(), KNOTS);
    for (i, hat) in hats.iter().enumerate() {
        for (j, knot) in knots.iter().enumerate() {
            assert!((hat(*knot) - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j}");
        }
        // Halfway to a neighbour a half, beyond it nothing.
        if i > 0 {
            assert!((hat(0.5 * (knots[i] + knots[i - 1])) - 0.5).abs() < 1e-12);
        }
    }
    // Beyond the ends straight lines stay straight: nothing grows there that was nothing within.
    for x in [-5.0, 3.3, 40.0, 70.0] {
        let line: f64 = hats.iter().zip(&knots).map(|(hat, knot)| hat(x) * knot).sum();
        assert!((line - x).abs() < 1e-9, "{x} {line}");
    }
    for x in [-3.0, 0.0, 0.3, 7.7, 30.0, 64.0, 99.0] {
        assert!((hats.iter().map(|h| h(x)).sum::<f64>() - 1.0).abs() < 1e-12, "{x}");
    }
    // Equal quantiles are one knot; with two of them there is no free function.
    assert!(hats_over(vec![1.0; 30]).is_empty() && hats_over(Vec::new()).is_empty());
    assert!(hats_over(vec![1.0, 2.0, 2.0, 1.0]).is_empty());
    assert_eq!(hats_over(vec![1.0, 2.0, 3.0]).len(), 3);
}

/// The variable of the operating point, where it is one.
fn variable(on: On) -> Option<Variable> {
    match on {
        On::Variable(variable) => Some(variable),
        _ => None,
    }
}

#[test]
fn what_a_bench_shows_is_offered() {
    let names = |work: &Work| offers(work).into_iter().map(|(on, _)| (variable(on), on.name())).collect::<Vec<_>>();
    let plain = moving(4000, false);
    let with_current = [
        (None, "time"),
        (Some(Variable::Speed), "speed"),
        (Some(Variable::Current), "current"),
        (Some(Variable::Torque), "transmitted torque"),
        (None, "time and direction"),
        (None, "acceleration"),
    ];
    assert_eq!(names(&work(&plain)), with_current);
    let warm = moving(4000, true);
    let mut with_heat = with_current.to_vec();
    with_heat.insert(4, (Some(Variable::WindingTemperature), "winding temperature"));
    assert_eq!(names(&work(&warm)), with_heat);
    // Steady points have no time, and no acceleration.
    let points: Vec<[f64; 3]> = (0..200).map(|k| [50.0 * noise(k), 5.0 * noise(k + 500), noise(k + 900)]).collect();
    let steady = bench(6.0, &[points], 0);
    assert_eq!(names(&work(&steady))[1..], with_current[1..4]);
    // Where a load is known and the current is the target, a free function of it would explain its noise, and what is
    // transmitted is the load.
    let swing = |k: usize| {
        let t = 1e-3 * k as f64;
        vec![
            t,
            40.0 * (5.0 * t).sin() + 20.0 * (13.0 * t).cos() + 0.1 * noise(k),
            (3.0 * t).sin() + 0.1 * noise(k + 9000),
        ]
    };
    let free = bench_of("free", 6.0, &OVER_TIME[..3], &[(0..4000).map(swing).collect()], 0);
    let of_free = names(&work_on(&free, Target::Drive));
    assert!(!of_free.iter().any(|(v, _)| *v == Some(Variable::Current)), "{of_free:?}");
    assert!(of_free.iter().any(|(v, _)| *v == Some(Variable::Speed)));
    assert_eq!(of_free.last(), Some(&(None, "acceleration")));
}

/// A target that is a kinked function of one variable and a little noise: that variable is told first, with nearly all
/// of what is left, and with the word of its effects.
#[test]
fn what_is_left_is_traced_to_its_variable() {
    let bench = moving(6000, true);
    let mut work = work(&bench);
    let balance = work.balance.clone();
    let acceleration = balance.acceleration();
    let time = balance.rows.time.clone();
    let constant = balance.scale.torque_constant;
    let variables: [(&str, Option<Variable>, Vec<f64>); 6] = [
        ("speed", Some(Variable::Speed), balance.variable(true, |at| at.speed)),
        ("current", Some(Variable::Current), balance.variable(true, |at| at.current)),
        (
            "transmitted torque",
            Some(Variable::Torque),
            balance.variable(true, |at| constant * at.current * at.direction),
        ),
        ("winding temperature", Some(Variable::WindingTemperature), balance.variable(true, |at| at.winding_rise)),
        ("acceleration", None, acceleration),
        ("time", None, time.clone()),
    ];
    let kinked = |values: &[f64]| -> Vec<f64> {
        let middle = signals::median(values.to_vec()).unwrap();
        let spread = signals::quantile(values.to_vec(), 0.9).unwrap() - middle;
        let mut column: Vec<f64> =
            values.iter().enumerate().map(|(k, v)| ((v - middle) / spread).abs() + 0.02 * noise(k)).collect();
        balance.rows.without_means(&mut column);
        column
    };
    for (name, variable, values) in &variables {
        work.target = kinked(values);
        let (found, shares) = left(&work, &work.fit());
        assert_eq!(found.first().map(|d| d.on.name()), Some(*name), "{found:?}");
        assert!(found[0].share > 0.8 && found[0].share <= 1.0, "{name}: {}", found[0].share);
        assert!(found.windows(2).all(|pair| pair[0].share >= pair[1].share), "the strongest first");
        let percent = 100.0 * (1.0 - (1.0 - found[0].share).sqrt());
        assert!(found[0].detail.ends_with(&format!("of {name} would lower the left-out error by {percent:.0} %")));
        assert!(shares.contains(&(found[0].on, found[0].share)), "{shares:?}");
        assert_eq!(super::tests::variable(found[0].on), *variable);
    }
    // Noise depends on nothing.
    work.target = (0..balance.rows.len()).map(noise).collect();
    assert_eq!(left(&work, &work.fit()), (Vec::new(), Vec::new()));
}

/// Friction that grows in the course of each log, where the motion often turns back: beside a constant friction it is
/// told by time and direction together.
#[test]
fn friction_that_changes_is_told() {
    let bench = moving_at(10.0, 6000, false);
    let mut work = work(&bench);
    let direction = work.balance.variable(true, |at| at.direction);
    let times = work.balance.rows.time.iter().zip(&direction).enumerate();
    let mut target: Vec<f64> = times.map(|(k, (t, d))| t * d + 0.02 * noise(k)).collect();
    work.balance.rows.without_means(&mut target);
    work.target = target;
    super::super::steady::add(&mut work, "coulomb_friction", 0.0);
    let (found, shares) = left(&work, &work.fit());
    assert_eq!(found[0].on, On::TimeAndDirection, "{found:?}");
    assert!(found[0].share > 0.8 && shares.contains(&(On::TimeAndDirection, found[0].share)), "{found:?}");
}

/// A drift is free in each log, and has no mean there: hats over its own times, all but the first.
#[test]
fn a_drift_is_free_in_each_log() {
    let bench = moving(3000, false);
    let work = work(&bench);
    let rows = &work.balance.rows;
    let columns = drift(&work);
    assert_eq!(columns.len(), 2 * (KNOTS - 1));
    for (c, column) in columns.iter().enumerate() {
        let own = c / (KNOTS - 1);
        let of = |log: usize| (0..rows.len()).filter(move |k| rows.log[*k] == log).map(|k| column[k]);
        assert!(of(1 - own).all(|v| v == 0.0));
        assert!(of(own).sum::<f64>().abs() < 1e-9 && of(own).map(|v| v * v).sum::<f64>() > 1.0);
    }
    // Knots are at the log's own times, wherever those of the other lie.
    let mut apart = super::super::steady::work(&bench);
    for k in 0..rows.len() {
        if rows.log[k] == 1 {
            std::sync::Arc::make_mut(&mut apart.balance).rows.time[k] = 40.0 + 3.0 * rows.time[k];
        }
    }
    for (column, same) in drift(&apart).iter().zip(&columns) {
        assert!(column.iter().zip(same).all(|(a, b)| (a - b).abs() < 1e-9));
    }
    // A line in time of one log is in their span, a line through both logs' times too.
    let projected = |target: Vec<f64>| {
        let mut work = super::super::steady::work(&bench);
        work.terms.clear();
        work.target = target;
        work.balance.rows.without_means(&mut work.target);
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let fit = work.fit_columns(&columns);
        finite_sum(&fit.left_out) / work.target.iter().map(|v| v * v).sum::<f64>()
    };
    assert!(projected(rows.time.clone()) < 1e-9);
    assert!(projected((0..rows.len()).map(|k| if rows.log[k] == 1 { rows.time[k] } else { 0.0 }).collect()) < 1e-9);
    assert!(projected(rows.time.iter().map(|t| (9.0 * t).sin()).collect()) > 0.1);
}

/// Any function of speed: kinks at its quantiles and a jump at the reversal.
#[test]
fn a_free_function_of_speed_has_kinks_and_a_jump() {
    let points: Vec<[f64; 3]> = (0..400).map(|k| [50.0 * noise(k), 5.0 * noise(k + 500), noise(k + 900)]).collect();
    let bench = bench(6.0, &[points], 0);
    let mut work = work(&bench);
    let speed = work.balance.variable(false, |at| at.speed);
    let columns = of_speed(&work);
    assert_eq!(columns.len(), KNOTS + 1);
    let of_fit = (0..speed.len()).filter(|k| work.fits(work.balance.rows.block[*k])).map(|k| speed[k]).collect();
    let middle = signals::quantile(of_fit, 0.25).unwrap();
    let target = |f: &dyn Fn(f64) -> f64| speed.iter().map(|w| f(*w)).collect::<Vec<f64>>();
    for (f, inside) in [
        (&(|w: f64| (w - middle).max(0.0)) as &dyn Fn(f64) -> f64, true),
        (&|w| 3.0 * w, true),
        (&|w| w.signum(), true),
        (&|w| (0.5 * w).sin(), false),
    ] {
        work.terms.clear();
        work.target = target(f);
        work.balance.rows.without_means(&mut work.target);
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let fit = work.fit_columns(&columns);
        let total = fit.blocks.total(|b| work.fits(b));
        let last = total.nrows() - 1;
        let share = super::super::regression::squares(&total, &fit.solution.coefficients) / total[(last, last)];
        assert_eq!(share < 1e-6, inside, "{share}");
        assert!(inside || share > 0.1);
    }
    // Where nothing turns there is none.
    std::sync::Arc::make_mut(&mut work.balance).variables.retain(|v| *v != Variable::Speed);
    assert!(of_speed(&work).is_empty());
}

/// A hum takes 256 rows of a log to be told from noise, and stands in the rows as they are told.
#[test]
fn a_hum_takes_some_rows() {
    let rows_of = |samples: usize| {
        let bench = moving(samples, false);
        let rows = work(&bench).balance.rows.clone();
        (0..rows.len()).filter(|k| rows.log[*k] == 0).count()
    };
    let some = rows_of(600);
    let enough = 600 + 256 - some;
    assert_eq!((rows_of(enough), rows_of(enough - 1)), (256, 255));
    for (samples, told) in [(enough, true), (enough - 1, false)] {
        let bench = moving(samples, false);
        let mut work = work(&bench);
        for (k, y) in work.target.iter_mut().enumerate() {
            *y = (std::f64::consts::TAU * 110.0 * work.balance.rows.time[k]).sin() + 0.3 * noise(k);
        }
        let found = hum(&work, &work.fit());
        assert_eq!(found.is_some(), told, "{found:?}");
        if let Some((frequency, share)) = found {
            assert!((frequency - 110.0).abs() < 4.0 && share > 0.5, "{frequency} {share}");
        }
    }
    // A hum of one log of two may be anything.
    let one = moving(enough, false);
    let mut work_of_one = work(&one);
    for k in 0..work_of_one.target.len() {
        let rows = &work_of_one.balance.rows;
        let hum = if rows.log[k] == 0 { (std::f64::consts::TAU * 110.0 * rows.time[k]).sin() } else { 0.0 };
        work_of_one.target[k] = hum + 0.3 * noise(k);
    }
    assert_eq!(hum(&work_of_one, &work_of_one.fit()), None);
    let steady: Vec<[f64; 3]> = (0..400).map(|k| [50.0 * noise(k), 5.0 * noise(k + 500), noise(k + 900)]).collect();
    let steady = bench(6.0, &[steady], 0);
    let of_steady = work(&steady);
    assert_eq!(hum(&of_steady, &of_steady.fit()), None);
}

/// Orders of a position that stand out are told with it, from 8 % of what is left on.
#[test]
fn orders_of_a_position_stand_out() {
    let columns = [
        "velocity = { name = \"0\", unit = \"rad/s\", side = \"motor\" }",
        "current = { name = \"1\", unit = \"A\", convention = \"q_axis\" }",
        "torque = { name = \"2\", unit = \"N*m\", side = \"output\" }",
        "position = { name = \"3\", unit = \"rad\", side = \"motor\" }",
    ];
    let row = |k: usize| vec![5.0 * noise(k), 3.0 * noise(k + 700), noise(k + 1400), 0.037 * k as f64];
    let bench = bench_of("steady_table", 6.0, &columns, &[(0..2000).map(row).collect()], 0);
    let mut work = work(&bench);
    let angle = work.balance.variable(false, |at| at.angle);
    let cogging = gearwise_model::effects::effect("cogging").unwrap();
    let mut outcomes = [0; 2];
    for step in 0..30 {
        let size = 0.02 * f64::from(step);
        work.target = (0..angle.len()).map(|k| size * (7.0 * angle[k] + 0.3).cos() + noise(k + 3000)).collect();
        work.balance.rows.without_means(&mut work.target);
        let fit = work.fit();
        let mut scores = order_scores(&work, &fit, cogging);
        scores.sort_by(|a, b| b.1.total_cmp(&a.1));
        let first: Vec<f64> = scores[..4].iter().map(|s| s.0).collect();
        let extra: Vec<Vec<f64>> = first.iter().flat_map(|h| work.balance.effect_columns(cogging, *h)).collect();
        let mut all = work.columns();
        all.extend(extra.iter().map(Vec::as_slice));
        let with = work.fit_columns(&all).left_out;
        let share = 1.0 - finite_sum(&with) / finite_sum(&fit.left_out);
        let stands_out = share > SAID && paired(&fit.left_out, &with) > SURE;
        let (found, shares) = left(&work, &fit);
        let told = found.iter().find(|d| d.on == On::Variable(Variable::Angle));
        assert_eq!(told.is_some(), stands_out, "{size} {share}");
        assert_eq!(shares.iter().any(|s| s.0 == On::Variable(Variable::Angle)), stands_out);
        outcomes[usize::from(stands_out)] += 1;
        if let Some(told) = told {
            assert_eq!(first[0], 7.0);
            assert!(
                told.detail.starts_with("orders 7, ")
                    && told.detail.ends_with("of the motor position are above the rest")
            );
            assert!((told.share - share).abs() < 1e-12);
        }
    }
    assert!(outcomes.iter().all(|n| *n > 3), "{outcomes:?}");
}
