//! Pictures: labels that never cover each other, boundaries that meet the equations, files that are whole.

use std::path::{Path, PathBuf};

use gearwise::actuator::envelope::Steady;
use gearwise::actuator::shaft::Flow;
use gearwise::actuator::waveform::Functional;
use gearwise::actuator::{Load, metrics};
use gearwise::catalog::Catalog;
use gearwise::design::{Mount, Prepared};
use gearwise::report::plot::{
    self, Along, Axis, Dash, Figure, Group, Label, Layout, Mark, Panel, Rule, Series, Shape, Stripe, Tone, Wanted,
};
use gearwise::report::rank::Ranking;
use gearwise::requirement;
use proptest::prelude::*;

use crate::common::run::gearwise;

const CHEETAH: &str = "requirements/quadruped_mini_cheetah.toml";

/// No two texts of a panel over each other, and none over a labelled point.
fn nothing_collides(layout: &Layout) {
    for (k, (a, first)) in layout.texts.iter().enumerate() {
        for (b, second) in &layout.texts[k + 1..] {
            assert!(!plot::overlap(first, second), "`{a}` {first:?} lies over `{b}` {second:?}");
        }
        for (x, y) in &layout.points {
            let covers = *x > first[0] && *x < first[2] && *y > first[1] && *y < first[3];
            assert!(!covers, "`{a}` {first:?} covers the point {x} {y}");
        }
        let framed = layout.frames.iter().any(|f| {
            first[0] >= f[0] - 1e-9 && first[1] >= f[1] - 1e-9 && first[2] <= f[2] + 1e-9 && first[3] <= f[3] + 1e-9
        });
        assert!(framed, "`{a}` {first:?} leaves its panel");
    }
}

proptest! {
    #[test]
    fn placed_labels_never_collide(
        points in prop::collection::vec((0.0..400.0_f64, 0.0..300.0_f64, 20.0..120.0_f64), 1..40),
        crowd in prop::collection::vec((0.0..400.0_f64, 0.0..300.0_f64), 0..60),
        taken in prop::collection::vec((0.0..350.0_f64, 0.0..280.0_f64), 0..4),
    ) {
        let frame = [0.0, 0.0, 400.0, 300.0];
        let wanted: Vec<Wanted> = points.iter().map(|(x, y, w)| Wanted { at: (*x, *y), size: (*w, 14.0) }).collect();
        let taken: Vec<_> = taken.iter().map(|(x, y)| [*x, *y, x + 50.0, y + 20.0]).collect();
        let placed = plot::place(&wanted, frame, &taken, &crowd);
        let rects: Vec<_> = placed.iter().flatten().map(|p| p.rect).collect();
        for (k, r) in rects.iter().enumerate() {
            prop_assert!(r[0] >= 0.0 && r[1] >= 0.0 && r[2] <= 400.0 && r[3] <= 300.0);
            prop_assert!(rects[k + 1..].iter().chain(&taken).all(|o| !plot::overlap(r, o)));
            prop_assert!(wanted.iter().all(|w| !(w.at.0 > r[0] && w.at.0 < r[2] && w.at.1 > r[1] && w.at.1 < r[3])));
        }
        prop_assert_eq!(plot::place(&wanted, frame, &taken, &crowd), placed);
    }

    #[test]
    fn a_few_labels_always_find_a_place(points in prop::collection::vec((40.0..560.0_f64, 40.0..360.0_f64), 1..8)) {
        let wanted: Vec<Wanted> = points.iter().map(|p| Wanted { at: *p, size: (80.0, 14.0) }).collect();
        prop_assert!(plot::place(&wanted, [0.0, 0.0, 600.0, 400.0], &[], &[]).iter().all(Option::is_some));
    }
}

/// One of everything.
fn example() -> Figure {
    let curve: Vec<(f64, f64)> = (1..=8).map(|k| (f64::from(k), f64::from(k * k))).collect();
    let panel = Panel {
        title: "one of everything".into(),
        x: Axis::log("frequency [Hz]"),
        y: Axis::log("gain [1]").within(0.5, 200.0),
        stripes: vec![Stripe { along: Along::X, from: 2.0, to: 4.0, tone: Tone::Blue, name: "window".into() }],
        rules: vec![Rule {
            along: Along::Y,
            at: 100.0,
            tone: Tone::Vermilion,
            dash: Dash::Dashed,
            text: "limit".into(),
        }],
        series: vec![
            Series::band(Tone::Sky, curve.iter().map(|(x, y)| (*x, 0.7 * y, 1.4 * y))).named("confidence"),
            Series::new(Tone::Blue, Mark::Line(Dash::Dashed), curve.clone()).named("model <& \"co\">").along("slope 2"),
            Series::new(Tone::Orange, Mark::Points(Shape::Diamond), curve.clone())
                .named("measured")
                .of(curve.iter().map(|p| format!("log <{}>", p.0)).collect()),
        ],
        labels: vec![Label { at: (4.0, 16.0), text: "chosen".into(), chosen: true }],
        empty: String::new(),
    };
    let bars = Series::new(Tone::Green, Mark::Bars, vec![(0.0, 1.0), (1.0, 3.0), (2.0, f64::NAN)]);
    let counted = Panel {
        x: Axis::named("", vec!["a".into(), "b".into(), "c".into()]),
        y: "count [1]".into(),
        series: vec![bars],
        ..Panel::default()
    };
    let nothing = Panel { x: "time [s]".into(), empty: "nothing was logged".into(), ..Panel::default() };
    let group = Group {
        title: "A figure".into(),
        caption: "What has to be known to read it.".into(),
        own_legends: false,
        panels: vec![panel, counted, nothing],
    };
    Figure { groups: vec![group], columns: 3, ..Figure::default() }
}

#[test]
fn the_drawing_is_as_it_was() {
    let (svg, layout) = plot::svg_and_layout(&example());
    nothing_collides(&layout);
    assert!(layout.left_out.is_empty());
    insta::with_settings!({ snapshot_path => "../../snapshots/plots", prepend_module_to_snapshot => false }, { insta::assert_snapshot!("the_drawing_is_as_it_was", svg) });
    assert_eq!(plot::svg(&example()), svg);
}

#[test]
fn names_are_text_and_never_markup() {
    let mut figure = example();
    figure.groups[0].panels[0].labels[0].text = "<script>alert(\"x\")</script>\u{1}".into();
    let svg = plot::svg(&figure);
    assert!(!svg.contains("<script") && !svg.contains('\u{1}'));
    assert!(svg.contains("&lt;script&gt;"));
    #[cfg(feature = "png")]
    plot::png(&figure).unwrap();
}

#[test]
fn values_without_end_draw_nothing_and_break_nothing() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e300, 1e-300] {
        let mut figure = example();
        figure.groups[0].panels[0].series[1].points[3] = (bad, bad);
        figure.groups[0].panels[0].series[2].points = vec![(bad, bad)];
        figure.groups[0].panels[0].labels[0].at = (bad, bad);
        let svg = plot::svg(&figure);
        assert!(!svg.contains("NaN") && !svg.contains("inf\""), "{bad}");
        #[cfg(feature = "png")]
        plot::png(&figure).unwrap();
    }
}

#[test]
fn every_motor_of_the_ranking_is_drawn_and_no_label_collides() {
    let catalog = Catalog::builtin().unwrap();
    let ranking = Ranking::new(&catalog.motors, metrics::metric("s_m").unwrap(), None);
    let marked = ["t-motor-ri50", "t-motor-u8"].map(|id| catalog.motor(id).unwrap());
    let figure = plot::rank::figure(&ranking, &marked);
    let drawn: usize = figure.groups[0].panels[0]
        .series
        .iter()
        .filter(|s| matches!(s.mark, Mark::Points(_)))
        .map(|s| s.points.len())
        .sum();
    assert_eq!(drawn, catalog.motors.iter().filter(|m| m.rotor_inertia.is_some()).count());
    let (svg, layout) = plot::svg_and_layout(&figure);
    nothing_collides(&layout);
    assert_eq!(layout.left_out, [""; 0]);
    for text in ["t-motor-ri50", "t-motor-u8"] {
        assert_eq!(layout.texts.iter().filter(|t| t.0 == text).count(), 2, "{text}");
    }
    assert!(svg.matches('<').count() < 40_000);
    // Isolines: S = J/K² at both ends.
    for series in figure.groups[0].panels[0].series.iter().filter(|s| !s.along.is_empty()) {
        let [a, b] = series.points[..] else { panic!("an isoline has two ends") };
        let of = |p: (f64, f64)| p.1 / (p.0 * p.0);
        assert!((of(a) / of(b) - 1.0).abs() < 1e-12);
        assert!((of(a).log10() - of(a).log10().round()).abs() < 1e-9);
    }
}

/// The voltage circle at the boundary, by the equations of the machine written out again.
#[test]
fn the_voltage_boundary_meets_the_circle() {
    let mut robot = requirement::read(Path::new(CHEETAH)).unwrap();
    // Friction that a row declares is in the equations below, a bracket of drag is not.
    robot.joints.iter_mut().for_each(|joint| joint.motor_drag = requirement::MotorDrag::Off);
    let catalog = Catalog::builtin().unwrap();
    let mut checked = 0;
    for joint in &robot.joints {
        let load = Load::new(&joint.motion, joint.ripple());
        for motor in catalog.motors.iter().filter(|m| m.rotor_inertia.is_some()) {
            let candidate = Mount::new(&robot, joint, &load, motor).candidate().unwrap();
            let prepared = Prepared::new(candidate);
            let volts = prepared.asked.iter().find(|a| a.limit.name == "voltage").unwrap().raw_bound().sqrt();
            for n in [2.0, 9.0, 30.0] {
                let steady = Steady::new(&prepared.candidate, n);
                for (flow, speed) in
                    [Flow::Driving, Flow::Braking].into_iter().flat_map(|f| [0.0, 2.0, 15.0].map(|w| (f, w)))
                {
                    for inductance in [true, false] {
                        let steady = if inductance { steady } else { steady.without_inductance() };
                        let found = steady.largest_torque(Functional::VoltageSquared, volts * volts, flow, speed);
                        let Some(torque) = found.filter(|t| t.is_finite()) else { continue };
                        let gear = &joint.gear;
                        let (factor, friction) = match flow {
                            Flow::Driving => (1.0 / gear.efficiency, 1.0),
                            Flow::Holding => unreachable!("it is not asked"),
                            Flow::Braking => (gear.backdrive_efficiency, 1.0),
                        };
                        let shaft = factor * torque / n
                            + friction * motor.coulomb_friction.unwrap_or(0.0)
                            + motor.viscous_friction.unwrap_or(0.0) * n * speed;
                        // Beyond the largest torque of saturated iron the curve is a continuation.
                        let most = prepared.candidate.actuator.shortfall.largest_torque();
                        if most.is_some_and(|most| shaft.abs() > most) {
                            continue;
                        }
                        // Of saturated iron the drop has the whole current, i_s artanh(T/(K_T i_s)), where that is more.
                        let current = shaft / motor.torque_constant;
                        let with_iron = motor.saturation_current().map_or(current, |i_s| i_s * (current / i_s).atanh());
                        let poles = match (motor.inductance, motor.pole_pairs) {
                            (Some(l), Some(p)) if inductance => l * f64::from(p),
                            _ => 0.0,
                        };
                        // Of the hottest winding or of the coldest: tests/raw looks at how hot these are.
                        let actuator = &prepared.candidate.actuator;
                        let v_d = -poles * n * speed * current;
                        let reached = [actuator.hot_resistance, actuator.cold_resistance]
                            .map(|resistance| {
                                let of = |current: f64| resistance * current + motor.emf_constant() * n * speed;
                                of(with_iron).abs().max(of(current).abs()).hypot(v_d)
                            })
                            .into_iter()
                            .fold(0.0, f64::max);
                        assert!(
                            (reached / volts - 1.0).abs() < 1e-8,
                            "{} N {n} ω {speed}: {reached} of {volts} V",
                            motor.id
                        );
                        assert!(torque * if flow == Flow::Driving { 1.0 } else { -1.0 } >= 0.0);
                        checked += 1;
                    }
                }
            }
        }
    }
    assert!(checked > 500, "{checked}");
}

/// A steady torque that is asked of the shaft is the one that the sample asks.
#[test]
fn the_boundary_of_a_current_is_that_current() {
    let robot = requirement::read(Path::new(CHEETAH)).unwrap();
    let catalog = Catalog::builtin().unwrap();
    let joint = &robot.joints[0];
    let load = Load::new(&joint.motion, None);
    let motor = catalog.motor("t-motor-ri50").unwrap();
    let candidate = Mount::new(&robot, joint, &load, motor).candidate().unwrap();
    let steady = Steady::new(&candidate, 9.0);
    for shaft in [-1.5, -0.2, 0.3, 2.0] {
        for speed in [0.0, 5.0, 20.0] {
            let torque = steady.load_torque(shaft, speed).unwrap();
            let flow = if torque >= 0.0 { Flow::Driving } else { Flow::Braking };
            let squared = steady.at(Functional::TorqueSquared, flow, torque, speed);
            assert!((squared.sqrt() / shaft.abs() - 1.0).abs() < 1e-12);
        }
    }
}

/// The picture of a command.
fn picture(command: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.svg");
    let output = gearwise(&[command, &["--plot", file.to_str().unwrap()]].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{command:?}");
    std::fs::read_to_string(&file).unwrap()
}

proptest! {
    /// From fewer than three ticks nobody can tell that an axis is logarithmic.
    #[test]
    fn a_logarithmic_axis_has_three_ticks(low in -6.0..6.0_f64, decades in 0.01..9.0_f64, most in 1_usize..14) {
        let (low, high) = (10_f64.powf(low), 10_f64.powf(low + decades));
        let found = plot::ticks(&Axis::log(""), (low, high), most).labelled;
        prop_assert!(found.len() >= 3, "{found:?}");
        prop_assert!(found.iter().all(|t| t.0 >= low * 0.999_999 && t.0 <= high * 1.000_001));
        let texts: std::collections::HashSet<&String> = found.iter().map(|t| &t.1).collect();
        prop_assert_eq!(texts.len(), found.len(), "{:?}", found);
    }
}

fn fronts_figure(catalog: &Catalog, quantities: &[requirement::Quantity]) -> Figure {
    let robot = requirement::read(Path::new(CHEETAH)).unwrap();
    let fronts = gearwise::design::pareto::fronts(&robot, catalog, quantities, 33, Default::default()).unwrap();
    plot::pareto::figure(&fronts)
}

/// Between two motors there is no design: the front has a corner there, above and right of what can be had. Along one
/// motor there are designs at all ratios: no corner.
#[test]
fn a_front_is_a_step_between_motors_and_a_curve_along_one() {
    use requirement::Quantity::{Loss, Mass, ReflectedInertia};
    let catalog = Catalog::builtin().unwrap();
    for (quantities, mixed) in [([Loss, Mass], false), ([Loss, ReflectedInertia], true)] {
        let figure = fronts_figure(&catalog, &quantities);
        let mut sloped = 0;
        for panel in figure.groups[0].panels.iter().filter(|p| !p.series.is_empty()) {
            let [line, motors @ ..] = panel.series.as_slice() else { panic!("a front") };
            let of = |p: (f64, f64)| motors.iter().find(|s| s.points.contains(&p)).map(|s| s.ids[0].clone());
            for pair in line.points.windows(2) {
                let straight = pair[0].0 == pair[1].0 || pair[0].1 == pair[1].1;
                let same = of(pair[0]).is_some() && of(pair[0]) == of(pair[1]);
                assert!(straight || same, "{pair:?} of {}", panel.title);
                sloped += usize::from(!straight);
            }
            // Every motor is named with the ratio of its point.
            let named = |id: &str| panel.labels.iter().any(|l| l.text.starts_with(&format!("{id}, N = ")));
            assert!(motors.iter().filter(|s| !s.ids.is_empty()).all(|s| named(&s.ids[0])));
        }
        assert_eq!(sloped > 0, mixed, "{quantities:?}");
    }
}

/// Each pair of three quantities has its panel; what is large in it is the front of that pair, and nothing is drawn that is not on the
/// front of all three. Each axis is the same wherever its quantity is.
#[test]
fn a_front_of_three_quantities_is_a_matrix_of_pairs() {
    use requirement::Quantity::{Loss, Mass, ReflectedInertia};
    let catalog = Catalog::builtin().unwrap();
    let robot = requirement::read(Path::new(CHEETAH)).unwrap();
    let quantities = [Loss, Mass, ReflectedInertia];
    let fronts = gearwise::design::pareto::fronts(&robot, &catalog, &quantities, 33, Default::default()).unwrap();
    let figure = plot::pareto::figure(&fronts);
    assert_eq!((figure.columns, figure.groups.len()), (2, 2 * fronts.len()));
    assert_eq!(figure.groups.iter().filter(|g| !g.caption.is_empty()).count(), 1);
    for (k, front) in fronts.iter().enumerate() {
        let groups = &figure.groups[2 * k..2 * k + 2];
        let own = plot::pareto::of_joint(&figure, front, k).unwrap();
        assert_eq!(own.groups, groups);
        let panels: Vec<&Panel> = groups.iter().flat_map(|g| &g.panels).collect();
        assert_eq!((panels.len(), groups[0].panels.len()), (3, 1));
        assert!(groups[0].title.starts_with(&format!("{}: ", front.joint.name)));
        for (panel, [a, b]) in panels.iter().zip([[0, 1], [0, 2], [1, 2]]) {
            let label = |q: usize| quantities[q].name().replace('_', " ");
            assert!(panel.x.label.starts_with(&label(a)) && panel.y.label.starts_with(&label(b)));
            let all: Vec<(f64, f64)> = front.points.iter().map(|p| (p.values[a], p.values[b])).collect();
            let shown = |large: bool| {
                let of =
                    move |s: &&Series| matches!(s.mark, Mark::Points(_)) == large && !matches!(s.mark, Mark::Thin(_));
                panel.series.iter().filter(of).flat_map(|s| s.points.clone()).collect::<Vec<_>>()
            };
            let is_bettered = |p: &(f64, f64)| all.iter().any(|q| q != p && q.0 <= p.0 && q.1 <= p.1);
            assert!(!shown(true).is_empty() && shown(true).iter().all(|p| all.contains(p) && !is_bettered(p)));
            // Of two points in one place one is large.
            assert!(shown(false).iter().all(|p| all.contains(p) && (is_bettered(p) || shown(true).contains(p))));
        }
        for (first, second) in
            [(&panels[0].x, &panels[1].x), (&panels[1].y, &panels[2].y), (&panels[0].y, &panels[2].x)]
        {
            assert_eq!((&first.label, first.scale, first.range), (&second.label, second.scale, second.range));
        }
        // The legend has the motors with a look of their own, each once, and the others are said to be there.
        let named: Vec<&str> = panels[0].series.iter().map(|s| s.name.as_str()).filter(|n| !n.is_empty()).collect();
        let motors = gearwise::report::pareto::motors(front);
        assert_eq!(named.iter().filter(|n| motors.contains(n)).count(), motors.len().min(6));
        assert_eq!(named.contains(&"other motors"), motors.len() > 6);
        for (q, _) in quantities.iter().enumerate() {
            let best = gearwise::report::pareto::best_of(front.points.iter(), q).unwrap();
            assert!(named.contains(&best.motor.id.as_str()), "{}", best.motor.id);
        }
        assert!(panels[1..].iter().all(|p| p.series.iter().all(|s| s.name.is_empty())));
    }
    let (svg, layout) = plot::svg_and_layout(&figure);
    assert!(layout.frames.len() == 3 * fronts.len() && !svg.contains("NaN"));
    nothing_collides(&layout);
}

#[test]
fn a_mark_is_hollow_only_where_something_is_estimated() {
    use requirement::Quantity::{Loss, Mass};
    let plain = Catalog::builtin().unwrap();
    let estimated = gearwise::actuator::estimate::complete(Catalog::builtin().unwrap());
    for (catalog, any) in [(&plain, false), (&estimated, true)] {
        let figure = fronts_figure(catalog, &[Loss, Mass]);
        let mut hollow = 0;
        for series in figure.groups[0].panels.iter().flat_map(|p| &p.series).filter(|s| !s.ids.is_empty()) {
            let motor = catalog.motor(&series.ids[0]).unwrap();
            assert_eq!(series.hollow, !motor.estimates.is_empty(), "{}", motor.id);
            hollow += usize::from(series.hollow);
        }
        let svg = plot::svg(&figure);
        assert_eq!(hollow > 0, any);
        assert_eq!(svg.contains("hollow: rests on an estimate"), any);
    }
}

#[test]
fn a_line_says_what_it_bounds_and_that_safety_is_in_it() {
    let with = picture(&["explain", "t-motor-u8-lee@8", CHEETAH, "--joint", "hip"]);
    for name in ["motion ≤ peak current of the drive / safety 1.2", "motion ≤ voltage, with inductance", "load alone"]
    {
        assert!(with.contains(name), "{name}");
    }
    // Rated current and torque of this row are the same line; heat is another.
    assert!(with.contains("rms motion ≤ rated current = rated torque"));
    assert!(with.contains(">rms motion ≤ winding temperature<"));
    // Without a safety factor none is said; what is not the same line is not one entry.
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(CHEETAH).unwrap().replace("safety = 1.2", "safety = 1.0");
    let text = text.replace("motions/", &format!("{}/requirements/motions/", env!("CARGO_MANIFEST_DIR")));
    let plain = folder.path().join("plain.toml");
    std::fs::write(&plain, text).unwrap();
    let without = picture(&["explain", "tq-robodrive-ilm-85x04@18", plain.to_str().unwrap(), "--joint", "knee"]);
    assert!(without.contains("motion ≤ peak torque of the motor") && !without.contains("/ safety"));
    assert!(without.contains(">rms motion ≤ rated torque<"));
}

#[test]
fn the_limits_of_a_gear_hold_in_both_directions() {
    let gears = picture(&["optimize", "requirements/humanoid_hip_catalog_gears.toml"]);
    // Once with its text, and its mirror image without.
    let dashes = gears.matches("stroke-dasharray=\"14 5\"").count();
    assert!(gears.contains("load ≤ peak of the gear / safety 1.2") && dashes >= 2, "{dashes}");
}

#[test]
fn the_instant_at_which_a_limit_binds_is_labelled_and_no_other() {
    let binds = picture(&["optimize", CHEETAH, "--set", "joint.*.motor_drag=off", "--set", "bus.voltage=20 V"]);
    assert!(binds.contains("voltage binds, t = 0.3625 s") && binds.contains("where a limit binds"));
    // Here every limit on a sample leaves more than a twentieth.
    let free = picture(&["explain", "t-motor-u8-lee@8", CHEETAH, "--joint", "hip"]);
    assert!(!free.contains("where a limit binds") && !free.contains(" binds, t"));
}

#[test]
fn where_there_is_no_thermal_data_the_picture_says_so_and_only_there() {
    let without = picture(&["explain", "t-motor-ri50@13", CHEETAH, "--joint", "knee"]);
    assert!(without.contains("no thermal data"));
    let with = picture(&["explain", "t-motor-u8-lee@8", CHEETAH, "--joint", "hip"]);
    assert!(!with.contains("no thermal data") && with.contains("temperature, settled"));
}

#[test]
fn gears_of_a_catalogue_are_bars_and_continuous_ratios_a_curve() {
    let gears = picture(&["optimize", "requirements/humanoid_hip_catalog_gears.toml"]);
    assert!(gears.contains("N of the gear") && !gears.contains(">ratio N<") && !gears.contains("N* ="));
    let curves = picture(&["optimize", CHEETAH]);
    assert!(!curves.contains("N of the gear") && curves.contains(">ratio N<"));
}

#[test]
fn torque_is_in_newton_metres_everywhere() {
    let bench = ["characterize", "requirements/bench/motor_on_bench.toml"];
    for command in [&["explain", "t-motor-ri50@9", CHEETAH, "--joint", "knee"][..], &["rank"], &bench] {
        let svg = picture(command);
        assert!(svg.contains("N·m"), "{command:?}");
        assert!(!svg.contains("N*m") && !svg.contains("[Nm"), "{command:?}");
    }
}

/// Every command's picture, whole and of a bearable size; what cannot be drawn is said before any work.
#[test]
fn every_command_draws_its_picture() {
    let folder = tempfile::tempdir().unwrap();
    let commands: [&[&str]; 7] = [
        &["rank", "--mark", "t-motor-ri50"],
        &["explain", "t-motor-ri50@9", CHEETAH, "--joint", "knee"],
        &["optimize", CHEETAH],
        &["optimize", CHEETAH, "--pareto", "loss,reflected_inertia"],
        &["optimize", CHEETAH, "--pareto", "loss,copper_loss,mass,reflected_inertia,peak_current,energy,peak_power"],
        &["sweep", CHEETAH, "--ratios", "12"],
        &["compare", "t-motor-ri50", "t-motor-u8"],
    ];
    for (k, command) in commands.into_iter().enumerate() {
        let file = folder.path().join(format!("{k} ü.svg"));
        let with = |path: &str| gearwise(&[command, &["--plot", path]].concat());
        let output = with(file.to_str().unwrap());
        assert!(
            matches!(output.status.code(), Some(0 | 1)),
            "{command:?}: {}",
            String::from_utf8_lossy(&output.stderr)
        );
        let svg = std::fs::read_to_string(&file).unwrap();
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
        assert!(svg.contains("role=\"img\"") && svg.contains("<title>") && svg.contains("<desc>"));
        let elements = svg.lines().filter(|l| l.starts_with('<') && !l.starts_with("</")).count();
        assert!(elements < 20_000, "{command:?}: {elements} elements");
        assert!(!svg.contains("NaN"), "{command:?}");
        for (path, words) in [("x.pdf", ".svg or .png"), ("no/such/folder/x.svg", "cannot write")] {
            let output = with(path);
            assert_eq!(output.status.code(), Some(2), "{command:?} {path}");
            assert!(String::from_utf8_lossy(&output.stderr).contains(words), "{command:?} {path}");
        }
    }
    let output = gearwise(&["rank", "--plot", "x.svg", "--mark", "t-motor-ri5O"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("did you mean `t-motor-ri50`"));
}

/// The committed pictures are what the program draws: the script names each with its command.
#[test]
fn the_committed_pictures_are_what_the_program_draws() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let script = std::fs::read_to_string(root.join("docs/pictures.sh")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut drawn = 0;
    for line in script.lines().filter_map(|l| l.strip_prefix("draw ")) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [name, command @ ..] = words.as_slice() else { panic!("`{line}`") };
        let file = folder.path().join(name);
        let output = gearwise(&[command, &["--plot", file.to_str().unwrap()]].concat());
        assert!(matches!(output.status.code(), Some(0 | 1)), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        let committed = std::fs::read_to_string(root.join("docs/pictures").join(name)).unwrap();
        assert!(committed.len() < 200_000, "{name}: {} bytes", committed.len());
        let same = std::fs::read_to_string(&file).unwrap() == committed;
        assert!(same, "docs/pictures/{name} is not what the program draws: run docs/pictures.sh");
        drawn += 1;
    }
    // Photographs of pages are taken by a browser.
    let is_drawn = |path: &PathBuf| path.extension().is_some_and(|e| e == "svg");
    let kept = std::fs::read_dir(root.join("docs/pictures")).unwrap().map(|e| e.unwrap().path()).filter(is_drawn);
    assert_eq!(drawn, kept.count());
}
