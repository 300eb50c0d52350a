//! The objective over the ratio, by the declared row and as measured: how far the best ratio moves, and what that is worth.

use super::{Axis, Dash, Figure, Group, Label, Mark, Panel, Series, Tone, objective_axis};
use crate::number;
use gearwise_select::remake::{Choice, Remade};

/// A panel for each joint whose ratio is free; `None` where there is none.
pub fn figure(remade: &[Remade]) -> Option<Figure> {
    let panels: Vec<Panel> = remade.iter().filter_map(panel).collect();
    let group =
        Group { title: "The choice made again: the measured motor over the ratio".into(), panels, ..Group::default() };
    (!group.panels.is_empty()).then(|| Figure { groups: vec![group], columns: 2, ..Figure::default() })
}

fn panel(one: &Remade) -> Option<Panel> {
    let [declared, fitted] = &one.curves;
    let all = || declared.iter().chain(fitted);
    let least = all().map(|p| p.1).fold(f64::INFINITY, f64::min);
    if !least.is_finite() {
        return None;
    }
    let ends = all().fold((f64::INFINITY, 0.0_f64), |(low, high), p| (low.min(p.0), high.max(p.0)));
    let mut panel = Panel {
        title: format!("{}: {}", one.joint.name, one.motor),
        x: Axis::log("ratio N").within(ends.0, ends.1),
        y: objective_axis(&one.joint.objective),
        empty: "no ratio keeps all limits".into(),
        ..Panel::default()
    };
    if least > 0.0 {
        let most = all().map(|p| p.1).fold(0.0, f64::max);
        panel.y.range = Some((0.0, (1.06 * most).min(5.0 * least)));
    }
    let looks = [
        ("by its row", declared, one.before.as_ref(), Tone::Orange, Dash::Dashed),
        ("as measured", fitted, Some(&one.after), Tone::Blue, Dash::Solid),
    ];
    for (name, curve, choice, tone, dash) in looks {
        panel.series.push(Series::new(tone, Mark::Line(dash), curve.clone()).named(name));
        if let Some(Choice { outcome: Ok(best), .. }) = choice {
            let at = (best.ratio, best.objective);
            panel.series.push(Series::new(tone, Mark::Dots, vec![at]).named(format!("best {name}")));
            panel.labels.push(Label { at, text: format!("N* = {}", number(best.ratio)), chosen: false });
        }
    }
    Some(panel)
}
