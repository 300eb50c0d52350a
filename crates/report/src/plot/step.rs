//! What a voltage step does to two motors: each as a share of its final speed, and at matched actuator inertia.

use super::{Along, Axis, Dash, Figure, Group, Mark, Panel, Rule, Series, Tone};
use crate::compare::Comparison;
use crate::number;
use gearwise_model::actuator::metrics::at_matched_inertia;
use gearwise_model::actuator::step_response::simulate_and_watch;
use gearwise_model::catalog::Motor;

/// Points of a curve.
const POINTS: usize = 400;

/// Which motor, whether with inductance, and the share of the final speed over time \[s\].
type Response = (usize, bool, Vec<(f64, f64)>);

/// The figure of a comparison.
pub fn figure(comparison: &Comparison) -> Figure {
    let [a, b] = comparison.motors;
    let responses: Vec<Response> = comparison
        .motors
        .iter()
        .enumerate()
        .flat_map(|(k, motor)| {
            let with = motor.inductance.map(|l| (k, true, response(motor, l)));
            [Some((k, false, response(motor, 0.0))), with].into_iter().flatten()
        })
        .filter(|(.., points)| !points.is_empty())
        .collect();
    // To where the slower one has come to rest.
    let settled = |points: &[(f64, f64)]| points.iter().rev().find(|p| (p.1 - 1.0).abs() > 0.02).map_or(0.0, |p| p.0);
    let end = 1.15 * responses.iter().map(|r| settled(&r.2)).fold(0.0, f64::max);
    let shares =
        panel(comparison, &responses, end, "each as a share of its final speed", "speed / final speed [1]", |_| {
            Some(1.0)
        });
    let mut panels = vec![shares];
    panels[0].rules.push(Rule {
        along: Along::Y,
        at: 1.0 - (-1.0_f64).exp(),
        tone: Tone::Grey,
        dash: Dash::Dotted,
        text: "63 %".into(),
    });
    // Matched: the speed that one volt gives at the output, through the ratio that matches the inertia.
    let final_speed = |motor: &Motor| {
        let matched = at_matched_inertia(motor, comparison.inertia).filter(|_| comparison.inertia > 0.0)?;
        Some(1.0 / (motor.back_emf_constant * matched.ratio))
    };
    let title = format!("matched actuator inertia, {} g·cm²", number(comparison.inertia * 1e7));
    panels.push(panel(comparison, &responses, end, &title, "speed of the output per volt [rad/(s·V)]", final_speed));
    Figure {
        groups: vec![Group {
            title: format!("Step of the voltage: {} and {}", a.id, b.id),
            caption: "The free motor at a step of the q-axis voltage, simulated. Without inductance the 63 % come after S_M. \
                      Matched: each motor behind the massless, lossless gear that gives both the same inertia at the output."
                .into(),
            own_legends: false,
            panels,
        }],
        columns: 2,
        panel: (480.0, 360.0),
        ..Figure::default()
    }
}

fn response(motor: &Motor, inductance: f64) -> Vec<(f64, f64)> {
    let mut points = vec![(0.0, 0.0)];
    if simulate_and_watch(motor, inductance, &mut |time, share| points.push((time, share))).is_none() {
        return Vec::new();
    }
    points
}

fn panel(
    comparison: &Comparison,
    responses: &[Response],
    end: f64,
    title: &str,
    y: &str,
    scale: impl Fn(&Motor) -> Option<f64>,
) -> Panel {
    let mut panel = Panel {
        title: title.into(),
        x: Axis::linear("time [ms]").within(0.0, (1e3 * end).max(1e-6)),
        y: Axis::linear(y),
        empty: "the rotor inertias are not known".into(),
        ..Panel::default()
    };
    for (k, inductance, points) in responses {
        let motor = comparison.motors[*k];
        let Some(scale) = scale(motor) else { continue };
        let shown: Vec<(f64, f64)> = points.iter().copied().filter(|p| p.0 <= end).collect();
        let step = shown.len().div_ceil(POINTS).max(1);
        let mut points: Vec<(f64, f64)> =
            shown.iter().step_by(step).map(|(t, share)| (1e3 * t, scale * share)).collect();
        // The simulation ends where the speed has settled.
        points.extend(shown.last().map(|last| (1e3 * end, scale * last.1)));
        let dash = match (k, inductance) {
            (0, true) => Dash::Solid,
            (0, false) => Dash::Dotted,
            (_, true) => Dash::Dashed,
            (_, false) => Dash::DashDotDot,
        };
        let tone = if *k == 0 { Tone::Blue } else { Tone::Vermilion };
        let how = if *inductance { "with inductance" } else { "without inductance" };
        let series = Series::new(tone, Mark::Line(dash), points).named(format!("{}, {how}", motor.id));
        panel.series.push(series.of(vec![motor.id.clone()]));
    }
    panel
}
