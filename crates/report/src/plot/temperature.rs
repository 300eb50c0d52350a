//! Winding and housing temperature over the motion, with the limit.

use super::{Along, Axis, Dash, Label, Mark, Panel, Rule, Series, Tone, thinned};
use crate::number;
use gearwise_model::actuator::limits::{Candidate, Check, Demand, LIMITS};
use gearwise_model::requirement::Course;
use gearwise_model::units::in_unit;
use gearwise_select::Prepared;

/// Most points of a curve.
const POINTS: usize = 1500;

/// The panel; where the motor's row or the motion does not say enough to follow the temperature, it says so.
pub fn panel(prepared: &Prepared, ratio: f64) -> Panel {
    followed(prepared, ratio).unwrap_or_else(|| Panel {
        title: "temperature".into(),
        empty: format!("no thermal data: {}", lacking(&prepared.candidate)),
        ..Panel::default()
    })
}

/// What it takes to follow the temperature over the motion, and is not there.
fn lacking(candidate: &Candidate) -> &'static str {
    let unknown = LIMITS.iter().filter(|limit| limit.name == "winding_peak_temperature").find_map(|limit| match limit
        .check(candidate)
    {
        Check::Unknown(why) => Some(why),
        _ => None,
    });
    unknown.unwrap_or(match candidate.joint.motion.course {
        Course::Points(_) => "operating points have no order in time",
        _ => "the motor's row has no thermal resistances and time constants to follow the winding with",
    })
}

fn followed(prepared: &Prepared, ratio: f64) -> Option<Panel> {
    let asked = prepared.asked.iter().find(|a| matches!(a.demand, Demand::WindingPeak(_)))?;
    let Demand::WindingPeak(node) = asked.demand else { return None };
    let candidate = &prepared.candidate;
    let periodic = candidate.joint.motion.has_steady_heat();
    let mut panel = Panel {
        title: if periodic { "temperature, settled" } else { "temperature, from cold" }.into(),
        x: Axis::linear("time [s]"),
        y: Axis::linear("temperature [°C]"),
        empty: "thermal runaway: each period is hotter than the last".into(),
        ..Panel::default()
    };
    let celsius = |kelvin: f64| in_unit(kelvin, "degC");
    let look = |here: &Candidate| {
        // At the end of the motor's drag where it is hotter.
        let courses = here.each_actuator().flat_map(|one| {
            here.ends().map(|actuator| one.load.winding_course(actuator, &node, ratio)).collect::<Vec<_>>()
        });
        let courses: Option<Vec<_>> = courses.collect();
        let (times, course) = courses?.into_iter().max_by(|a, b| a.1.peak.total_cmp(&b.1.peak))?;
        let points = |of: &[f64]| thinned(of.len(), POINTS).map(|k| (times[k], celsius(of[k]))).collect::<Vec<_>>();
        let peak = (times[course.peak_sample], celsius(course.peak));
        Some((points(&course.winding), points(&course.housing), peak))
    };
    let course = if candidate.is_evaluated() { candidate.at_ratio(ratio, look) } else { look(candidate) };
    let Some((winding, housing, peak)) = course else { return Some(panel) };
    let limit = celsius(node.ambient + asked.bound);
    let low = winding.iter().chain(&housing).map(|p| p.1).fold(celsius(node.ambient), f64::min);
    let high = winding.iter().map(|p| p.1).fold(peak.1, f64::max);
    // A limit that is far above would squash the curve.
    let seen = limit - high < 3.0 * (high - low).max(5.0);
    let top = if seen { high.max(limit) } else { high };
    let room = 0.08 * (top - low).max(5.0);
    panel.y.range = Some((low - room, top + room));
    if seen {
        let text = format!("limit, {} °C", number(limit));
        panel.rules.push(Rule { along: Along::Y, at: limit, tone: Tone::Vermilion, dash: Dash::Solid, text });
    } else {
        panel.title.push_str(&format!(" (the limit is {} °C)", number(limit)));
    }
    let ambient = celsius(node.ambient);
    let text = format!("surroundings, {} °C", number(ambient));
    panel.rules.push(Rule { along: Along::Y, at: ambient, tone: Tone::Grey, dash: Dash::Dotted, text });
    panel.series.push(Series::new(Tone::Orange, Mark::Line(Dash::Dashed), housing).named("housing"));
    panel.series.push(Series::new(Tone::Blue, Mark::Line(Dash::Solid), winding).named("winding"));
    panel.labels.push(Label {
        at: peak,
        text: format!("{} °C", number((10.0 * peak.1).round() / 10.0)),
        chosen: false,
    });
    Some(panel)
}
