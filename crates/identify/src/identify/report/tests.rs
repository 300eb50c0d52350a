use super::super::numbers::Numbers;
use super::super::steady::{CONSTANT, OVER_TIME, add, bench, bench_of, noise, work};
use super::super::{Options, identify};
use super::*;
use crate::answer::{ArtefactKind, Hidden, On, Refused, Undecided};
use gearwise_model::effects::Named;
use gearwise_model::effects::{EFFECTS, Variable, effect};
use gearwise_model::numerics::sums::finite_sum;

/// What was found, with effects that the data cannot tell from it.
fn found(name: &'static str, confounded_with: &[&'static str]) -> Found {
    Found {
        effect: effect(name).unwrap(),
        parameters: Vec::new(),
        instances: Vec::new(),
        size: 1.0,
        held_out_before: None,
        held_out_after: None,
        confounded_with: confounded_with.iter().map(|name| effect(name).unwrap()).collect(),
    }
}

fn refused(name: &str, reason: &str) -> Refused {
    Refused::new(name, reason.into())
}

/// Every pair of effects, in either order, and the run that separates them: the first line that holds decides.
#[test]
fn every_pair_of_look_alikes_has_its_run() {
    let pairs: &[(&[&str], &[&str], &str)] = &[
        (&["coulomb_friction"], &["load_dependent_friction"], "another load"),
        (&["supply_sag"], &["torque_constant_saturation"], "voltage of the supply"),
        (&["torque_constant_temperature", "winding_temperature"], &[], "from cold and one from hot"),
        (&["torque_constant_saturation"], &[], "current steps up to the largest current"),
        (&["viscous_friction"], &["eddy_drag"], "higher speeds, beyond the knee"),
        (&["stribeck_friction"], &[], "from standstill to a tenth"),
        (&["cogging", "torque_ripple", "gear_ripple"], &[], "several revolutions at two different currents"),
        (&["direction_asymmetry", "torque_offset"], &[], "same speeds in both directions"),
        (&["inverter_dead_time", "supply_sag"], &[], "of both signs at standstill"),
    ];
    for (k, a) in EFFECTS.iter().enumerate() {
        for b in &EFFECTS[k + 1..] {
            let runs = [separating_run(*a, *b), separating_run(*b, *a)];
            let (a, b) = (a.name(), b.name());
            let holds = |(one, other, _): &&(&[&str], &[&str], &str)| {
                if other.is_empty() {
                    one.contains(&a) || one.contains(&b)
                } else {
                    one.contains(&a) && other.contains(&b) || one.contains(&b) && other.contains(&a)
                }
            };
            let words = pairs.iter().find(holds).map_or("vary independently", |p| p.2);
            for run in runs {
                assert!(run.contains(words), "{a} or {b}: {run}");
                assert!(run.ends_with("would separate them"));
            }
        }
    }
}

#[test]
fn runs_are_proposed_for_what_is_open() {
    let points: Vec<[f64; 3]> = (0..200).map(|k| [50.0 * noise(k), 5.0 * noise(k + 500), 0.0]).collect();
    let (geared, direct) = (bench(6.0, std::slice::from_ref(&points), 0), bench(1.0, &[points], 0));
    let (geared, direct) = (work(&geared), work(&direct));
    let selection = |refused: Vec<Refused>| Selection { refused, ..Selection::default() };
    let none = selection(Vec::new());
    // Look-alikes are named together.
    let alike = found("cogging", &["torque_ripple", "gear_ripple"]);
    let runs = next_runs(&[alike], &none, &[], &geared);
    assert_eq!(runs.len(), 2);
    assert!(runs[0].starts_with("`cogging` or `torque_ripple`: slow turns"), "{runs:?}");
    assert!(runs[1].starts_with("`cogging` or `gear_ripple`: slow turns"));
    // Friction before or behind a gear, where there is one.
    for name in ["viscous_friction", "coulomb_friction", "stribeck_friction"] {
        let runs = next_runs(&[found(name, &[])], &none, &[], &geared);
        assert!(matches!(&runs[..], [run] if run.starts_with("friction before or behind the gear")), "{runs:?}");
        assert!(next_runs(&[found(name, &[])], &none, &[], &direct).is_empty());
    }
    assert!(next_runs(&[found("cogging", &[])], &none, &[], &geared).is_empty());
    assert!(next_runs(&[], &none, &[], &geared).is_empty());
    // A drift without a temperature: of what is left, or of what was refused.
    let left = |on: On| vec![Dependence { on, share: 0.2, detail: String::new() }];
    let cold = || Refused::hidden("winding_temperature", Hidden::Lacks(Variable::WindingTemperature));
    let drift = || Refused { ground: Ground::Drift, ..refused("torque_offset", "a drift in time explains it as well") };
    for (refusals, on, wanted) in [
        (vec![cold()], left(On::Time), true),
        (vec![cold()], left(On::TimeAndDirection), true),
        (vec![cold(), drift()], left(On::Variable(Variable::Speed)), true),
        (vec![cold(), drift()], Vec::new(), true),
        (vec![cold()], left(On::Variable(Variable::Speed)), false),
        (vec![cold()], Vec::new(), false),
        (vec![drift()], left(On::Time), false),
        (Vec::new(), left(On::Time), false),
    ] {
        let runs = next_runs(&[], &selection(refusals), &on, &geared);
        assert_eq!(!runs.is_empty(), wanted, "{on:?} {runs:?}");
        assert!(runs.iter().all(|r| r.starts_with("log winding and housing temperature")));
    }
}

/// A name is taken back where a free function of its own variable takes away more than a share of what the effect
/// does: 15 %, or 4 % where a shape bends the curve.
#[test]
fn a_name_of_the_wrong_shape_is_doubtful() {
    for (name, shape, tolerated) in [("viscous_friction", 0.0, 0.15), ("eddy_drag", 40.0, 0.04)] {
        let torque = |w: f64| match name {
            "viscous_friction" => 2e-4 * w,
            _ => 0.04 * (w / 40.0) / (1.0 + (w / 40.0).powi(2)),
        };
        let points = (0..800).map(|k| {
            let (w, i) = (100.0 * noise(k), 5.0 * noise(k + 5000));
            [w, i, 6.0 * (CONSTANT * i - torque(w)) + 0.05 * noise(k + 9000)]
        });
        let bench = bench(6.0, &[points.collect()], 0);
        let mut work = work(&bench);
        add(&mut work, name, shape);
        let now = finite_sum(&work.fit().left_out);
        let explains = finite_sum(&work.left_out_without(1)) - now;
        // The share of what is left that is just tolerated.
        let just = tolerated * explains / now;
        assert!(just < 1.0, "{name} explains {just}");
        let on = On::Variable;
        let speed = |share: f64| vec![(On::Time, 0.9), (on(Variable::Current), 0.9), (on(Variable::Speed), share)];
        let doubtful =
            |work: &Work, shares: &[(On, f64)]| structure::doubtful_by(work, shares).map(|s| (s.term, s.reason));
        assert_eq!(doubtful(&work, &speed(0.99 * just)), None);
        let (term, reason) = doubtful(&work, &speed(1.01 * just)).expect("it is doubtful");
        assert_eq!(term, 1);
        let told = format!("a free function of speed takes away {:.0} % more than it does", 101.0 * tolerated);
        assert!(reason.contains(&told), "{reason}");
        // What explains nothing is not doubted where nothing is left either.
        let kinds = [work.terms[1].clone()];
        let nothing = (0..40).any(|seed| {
            work.terms[1].columns = vec![(0..work.target.len()).map(|k| noise(k + 10_000 * (7 + seed))).collect()];
            finite_sum(&work.left_out_without(1)) < finite_sum(&work.fit().left_out)
        });
        assert!(nothing);
        assert_eq!(doubtful(&work, &speed(0.0)), None);
        let [own] = kinds;
        work.terms[1] = own;
        // Of other variables it knows nothing, and what was declared is not doubted.
        assert_eq!(doubtful(&work, &[(On::Time, 0.9), (on(Variable::Current), 0.9)]), None);
        work.terms[1].declared = Some(vec![1.0]);
        assert_eq!(doubtful(&work, &speed(1.01 * just)), None);
    }
}

#[test]
fn stages_have_their_words() {
    let stage = Stage::new(Step::Refit, Some((1.0, 90.0)), Some((2.0, 80.0)));
    let numbers = (stage.fit, stage.fit_vaf, stage.held_out, stage.held_out_vaf);
    assert_eq!(numbers, (1.0, 90.0, Some(2.0), Some(80.0)));
    let empty = Stage::new(Step::Refit, None, None);
    assert!(empty.fit.is_nan() && empty.fit_vaf.is_nan() && empty.held_out.is_none() && empty.held_out_vaf.is_none());
    let lag = Report::lag("velocity", 0.004);
    assert_eq!((lag.kind, lag.channel.as_str(), lag.value, lag.unit), (ArtefactKind::Lag, "velocity", 0.004, "s"));
    let effect = |name: &str| effect(name).unwrap();
    assert_eq!(Step::Added(effect("cogging"), 12.0).name(), "cogging order 12");
    assert_eq!(Step::Added(effect("eddy_drag"), 12.0).name(), "eddy_drag");
    assert_eq!(Named::new(effect("cogging"), Some(12.0), "sine").to_string(), "cogging.12.sine");
    assert_eq!(Named::new(effect("eddy_drag"), Some(12.0), "speed").to_string(), "eddy_drag.speed");
}

/// A load that seems scaled by s is a torque constant that is scaled by 1/s; what is held stays as declared.
#[test]
fn parameters_are_told_with_their_errors() {
    let points: Vec<[f64; 3]> = (0..200).map(|k| [50.0 * noise(k), 5.0 * noise(k + 500), noise(k + 900)]).collect();
    let bench = bench(6.0, &[points], 0);
    let mut work = work(&bench);
    let first = work.balance.base[0].which;
    let numbers = |name: &str| Numbers::independent(&[(name, 1.25, 4e-4)]);
    let undecided = Undecided { effect: effect("eddy_drag").unwrap(), beside: None, by: 0.05 };
    let told = parameters(&work, &numbers(first.name()), &[Some(undecided)], &[]);
    assert_eq!((told.len(), told[0].name.as_str(), told[0].declared), (1, "torque_constant", Some(CONSTANT)));
    assert_eq!((told[0].fitted, told[0].standard_error, told[0].unit), (1.25, Some(0.02), "N*m/A"));
    assert_eq!(told[0].undecided, Some(undecided));
    assert!((told[0].tolerance().unwrap() - 1.96 * 0.0029_f64.sqrt()).abs() < 1e-15);
    // 0.1/1.25 = 0.08, with 0.1 · 0.02/1.25².
    std::sync::Arc::make_mut(&mut work.balance).base[0].which = Base::LoadScale;
    let of_machine = numbers("load_scale").of_the_machine(CONSTANT, &[false]);
    let told = parameters(&work, &of_machine, &[Some(undecided)], &[]);
    assert_eq!((told.len(), told[0].name.as_str(), told[0].declared), (1, "torque_constant", Some(CONSTANT)));
    assert!((told[0].fitted - 0.08).abs() < 1e-15 && told[0].unit == "N*m/A");
    assert!((told[0].standard_error.unwrap() - 0.00128).abs() < 1e-15);
    assert!((told[0].undecided.unwrap().by - 0.0032).abs() < 1e-15);
    std::sync::Arc::make_mut(&mut work.balance).base[0].which = first;
    let held = parameters(&work, &numbers("nothing"), &[], &[first]);
    assert_eq!(
        (held.len(), held[0].declared, held[0].fitted, held[0].standard_error),
        (1, Some(CONSTANT), CONSTANT, None)
    );
    assert!(parameters(&work, &numbers("nothing"), &[], &[]).is_empty());
}

/// `N K_0 i = s (load + J α + c)` with s = K_0/K_T: every torque against a known load is s times the machine's.
#[test]
fn numbers_are_those_of_the_machine() {
    let equation =
        [("load_scale", 0.8, 0.0064_f64.powi(2)), ("inertia", 8e-6, 1e-16), ("stribeck_friction.speed", 3.0, 0.01)];
    let machine = Numbers::independent(&equation).of_the_machine(0.1, &[false, true, false]);
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
    assert_eq!(machine.names, ["torque_constant", "inertia", "stribeck_friction.speed"]);
    for (value, expected) in machine.values.iter().zip([0.125, 1e-5, 3.0]) {
        close(*value, expected);
    }
    close(machine.covariance[(0, 0)].sqrt(), 0.1 / 0.64 * 0.0064);
    // J = J_s/s: variance (σ/s)² + (J_s σ_s/s²)².
    close(machine.covariance[(1, 1)], (1e-8_f64 / 0.8).powi(2) + (8e-6 * 0.0064 / 0.64_f64).powi(2));
    // A larger scale is a smaller torque constant and a smaller inertia.
    close(machine.covariance[(0, 1)], 0.1 / 0.64 * 8e-6 / 0.64 * 0.0064_f64.powi(2));
    close(machine.covariance[(2, 2)], 0.01);
}

/// The conventions differ by √(3/2), √3 and √2 and by one over them. What is off by something else, by nothing, or not surely,
/// is no convention, and neither is an inertia.
#[test]
fn a_torque_constant_that_is_off_by_a_convention_says_so() {
    let one = |name: &str, ratio: f64, error: f64| {
        let (declared, fitted) = (Some(0.2), 0.2 * ratio);
        let standard_error = Some(0.2 * error);
        Parameter { name: name.into(), declared, fitted, standard_error, undecided: None, unit: "N*m/A" }
    };
    let of = |name: &str, ratio: f64, error: f64| convention(&[one(name, ratio, error)]);
    let told = |ratio: f64| of("torque_constant", ratio, 0.002);
    for (ratio, what) in [
        (1.5_f64.sqrt(), "phase amplitude that is taken for the q axis"),
        (3.0_f64.sqrt(), "phase current in rms that is taken for the q axis"),
        (2.0_f64.sqrt(), "rms that is taken for an amplitude"),
        (1.5_f64.sqrt().recip(), "q axis that is taken for a phase amplitude"),
        (3.0_f64.sqrt().recip(), "q axis that is taken for a phase current in rms"),
        (2.0_f64.sqrt().recip(), "amplitude that is taken for a current in rms"),
        (1.01 * 1.5_f64.sqrt(), "phase amplitude that is taken for the q axis"),
    ] {
        let told = told(ratio).unwrap_or_else(|| panic!("{ratio}"));
        assert!(told.contains(what) && told.contains("check `convention`"), "{ratio}: {told}");
    }
    for ratio in [1.0, 0.9, 1.1, 1.3, 1.5, 0.5, 2.0] {
        assert_eq!(told(ratio), None, "{ratio}");
    }
    // 22 % with a standard error of 10 % is not sure.
    assert_eq!(of("torque_constant", 1.5_f64.sqrt(), 0.1), None);
    assert_eq!(of("inertia", 1.5_f64.sqrt(), 0.002), None);
    // A resistance, where the inductance does not say otherwise.
    let both = |l: f64| convention(&[one("inductance", l, 0.01), one("resistance", 1.5_f64.sqrt(), 0.002)]);
    assert!(both(1.5_f64.sqrt()).unwrap().contains("phase amplitude that is taken for the q axis"));
    assert_eq!(both(1.0), None);
}

/// At a constant load the torque does what its sensor's noise does: nothing can be learnt, and the reason is not that it does
/// not follow the model. Where the load changes neither is said.
#[test]
fn what_does_no_more_than_its_noise_is_said_so() {
    let evidence = |change: f64| {
        let row = |k: usize| {
            let t = 1e-3 * k as f64;
            let i = 2.0 + change * (11.0 * t).sin();
            vec![t, 40.0 + 0.01 * noise(k), i + 0.1 * noise(k + 20_000), 0.6 * i + 0.05 * noise(k + 50_000)]
        };
        let bench = bench_of("dynamometer", 6.0, &OVER_TIME, &[(0..12_000).map(row).collect()], 0);
        identify(&bench, &Options::default()).unwrap().remove(0).evidence
    };
    let constant = evidence(0.0);
    assert!(constant.still && constant.teaches_nothing(), "{constant:?}");
    let moving = evidence(2.0);
    assert!(!moving.still && !moving.teaches_nothing(), "{moving:?}");
}
