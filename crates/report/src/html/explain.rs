//! The page of an explanation.

use gearwise_model::words::{heat_or, with_unit};

use super::{Bars, Page, Part, Section, Table, Verdict};
use crate::currents::Q_AXIS;
use crate::explain::{
    RUNAWAY, best_line, capitalised, limit_columns, limit_rows, no_spring, percent, quantities, remedy_text, verdict,
    would_do,
};
use crate::optimize::fitted_notes;
use crate::plot::design as plot;
use crate::plot::torque_speed::CAPTION;
use crate::reason::reason_text;
use crate::said::gear_of_ratio;
use crate::{number, optional, spring};
use gearwise_model::catalog::audit::{audit_motor, conventions_line};
use gearwise_model::requirement::Robot;
use gearwise_select::explain::{Explanation, Remedy};

/// The page.
pub fn page(robot: &Robot, story: &Explanation) -> Page {
    let (e, joint, motor) = (&story.evaluation, story.joint, story.motor);
    let gear = story.gear.map_or_else(String::new, |g| format!(" with {}", g.id));
    let mut summary: Vec<Part> = tightest(story).map(Part::Text).into_iter().collect();
    if let Some(line) = gear_of_ratio(joint, e.ratio).filter(|_| story.gear.is_none()) {
        summary.push(Part::Text(format!("{}.", capitalised(&line))));
    }
    match &story.best {
        Some(Ok(optimum)) => summary.push(Part::Text(best_line(story, optimum))),
        Some(Err(reason)) => {
            summary.push(Part::Text(format!("No ratio of this motor will do: {}.", reason_text(reason, joint).1)));
        }
        None => {}
    }
    match &story.spring {
        Some(Ok(found)) => summary.push(Part::Text(format!("Parallel spring: {}.", spring::text(found, e.loss)))),
        Some(Err(why)) => summary.push(Part::Text(no_spring(story, why))),
        None => {}
    }
    if !story.remedies.is_empty() {
        let heading = if story.best.is_some() { would_do(story) } else { "What is exceeded" };
        summary.push(Part::Text(format!("{heading}:")));
        summary.push(Part::List(story.remedies.iter().map(remedy_text).collect()));
    }
    let mut sections = vec![
        Section::new("Figures", vec![Part::Figure(plot::explained(robot, story))]),
        Section::new("Limits", vec![Part::Table(limits(story)), Part::Text(Q_AXIS.into())]),
        Section::new("What it needs and weighs", vec![Part::Table(needs(story))]),
        Section::new("Where the loss is", losses(story)),
    ];
    if !story.sensitivities.is_empty() {
        let rows = story.sensitivities.iter().map(|s| {
            let change = s.objective.map_or_else(|| "no ratio is feasible".to_string(), percent);
            vec![s.parameter.to_string(), percent(s.change), change]
        });
        let goal = format!("change of {}", joint.goal());
        let table =
            Table::new("The ratio is chosen again each time", &["parameter", ">its change", &format!(">{goal}")]);
        sections.push(Section::new("If the motor were better", vec![Part::Table(table.rows(rows))]));
    }
    let row = format!("{}; {}", conventions_line(motor), motor.source);
    let lines = [row, motor.note.clone()].into_iter().filter(|line| !line.is_empty()).collect();
    sections.push(Section::new("The motor's row", vec![Part::List(lines)]));
    Page {
        command: "explain",
        title: format!("{}: {}{gear} at N = {}", joint.name, motor.id, ratio_text(story)),
        verdict: Verdict::from(story.is_choice()),
        asked: super::asked::parts(robot, &[joint]),
        headline: headline(story),
        summary,
        sections,
        warnings: warnings(story),
        ..Page::default()
    }
}

/// How a design stands, in a sentence.
pub fn headline(story: &Explanation) -> String {
    let gear = story.gear.map_or_else(String::new, |g| format!(" with {}", g.id));
    let (joint, motor, ratio) = (&story.joint.name, &story.motor.id, ratio_text(story));
    format!("At {joint}, {motor} at N = {ratio}{gear} {}.", verdict(story))
}

/// The ratio of a design; the best one so that it keeps its limits when it is typed again.
pub fn ratio_text(story: &Explanation) -> String {
    let ratio = story.evaluation.ratio;
    match &story.best {
        Some(Ok(best)) if best.ratio == ratio => crate::optimum_ratio(best, None),
        _ => number(ratio),
    }
}

/// What a remedy is in the requirement's own numbers, where its limit goes with one of them: limits are in q-axis volts and amperes.
fn in_own_terms(robot: &Robot, story: &Explanation, remedy: &Remedy) -> Option<String> {
    let times = (remedy.needed / remedy.bound).max(1.0);
    let (bus, drive) = (&robot.bus, story.joint.drive_current.or(robot.bus.drive_current));
    // A supply with a resistance sags under the power; what it then needs is another question.
    let stiff = times.is_finite() && bus.internal_resistance.is_none();
    match remedy.limit {
        "voltage" | "torque_bandwidth_voltage" if remedy.owner == "bus" && stiff => {
            let needed = up(bus.voltage * times);
            let most = bus.max_voltage.filter(|most| bus.voltage * times >= *most);
            let more =
                most.map_or_else(String::new, |most| format!(", more than its max_voltage of {} V", number(most)));
            Some(format!("a bus of {needed} V in place of {} V{more}", number(bus.voltage)))
        }
        "peak_current" | "torque_bandwidth_current" if remedy.owner == "drive" && times.is_finite() => {
            drive.map(|own| format!("a drive of {} A (phase amplitude) in place of {} A", up(own * times), number(own)))
        }
        _ => None,
    }
}

/// A number of four digits that is no less than another one.
fn up(value: f64) -> String {
    let step = 10_f64.powi(value.abs().max(f64::MIN_POSITIVE).log10().floor() as i32 - 3);
    number((value / step).ceil() * step)
}

/// The limit that leaves least, or that is exceeded most.
fn tightest(story: &Explanation) -> Option<String> {
    let margin = story.evaluation.tightest()?;
    Some(match story.evaluation.feasible {
        true => {
            format!("Tightest: {}, {} left.", margin.limit, percent(margin.margin.max(0.0)).trim_start_matches('+'))
        }
        false => format!("Most exceeded: {}, {}.", margin.limit, crate::demand_of(margin)),
    })
}

/// Every limit of a design.
fn limits(story: &Explanation) -> Table {
    Table::of("Limits, the tightest first", &limit_columns()).rows(limit_rows(&story.evaluation.margins, story.joint))
}

/// Of a joint with load cases: which limits ask most in which case; nothing where there are none.
fn cases(story: &Explanation) -> Option<Table> {
    let cases = story.joint.motion.cases.as_deref()?;
    let rows = cases.list.iter().map(|case| {
        let mut here: Vec<_> = story
            .evaluation
            .margins
            .iter()
            .filter(|m| m.case(story.joint).is_some_and(|of| of.name == case.name))
            .map(|m| (m.margin, m.limit))
            .collect();
        here.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(b.1)));
        let least = here.first().map_or_else(String::new, |(margin, _)| percent(*margin));
        let names: Vec<&str> = here.iter().map(|(_, limit)| *limit).collect();
        vec![case.name.clone(), number(100.0 * case.share), least, names.join(", ")]
    });
    Some(Table::new("Load cases", &["case", ">share [%]", ">least margin", "limits that ask most in it"]).rows(rows))
}

/// A design that is looked at among others: how it stands, its diagrams, its limits, what it needs, where its loss is. The
/// diagrams have no title, so that those of another design can take their place.
pub fn looked_at(robot: &Robot, story: &Explanation) -> Vec<Part> {
    let mut parts: Vec<Part> = tightest(story).map(Part::Text).into_iter().collect();
    match &story.best {
        Some(Ok(optimum)) => parts.push(Part::Text(best_line(story, optimum))),
        // Of a joint with a spring the same is said below.
        Some(Err(reason)) if story.spring.is_none() => {
            parts.push(Part::Text(format!("No ratio of this motor will do: {}.", reason_text(reason, story.joint).1)));
        }
        _ => {}
    }
    match &story.spring {
        Some(Ok(found)) => {
            parts.push(Part::Text(format!("Parallel spring: {}.", spring::text(found, story.evaluation.loss))));
        }
        Some(Err(why)) => parts.push(Part::Text(no_spring(story, why))),
        None => {}
    }
    parts.extend(
        gear_of_ratio(story.joint, story.evaluation.ratio)
            .filter(|_| story.gear.is_none())
            .map(|line| Part::Text(format!("{}.", capitalised(&line).trim_end_matches('.')))),
    );
    if !story.remedies.is_empty() {
        parts.push(Part::Text("What is exceeded at this ratio, and what would have to be in its place:".into()));
        let with = |remedy: &Remedy| match in_own_terms(robot, story, remedy) {
            Some(own) => format!("{}: {own}", remedy_text(remedy)),
            None => remedy_text(remedy),
        };
        parts.push(Part::List(story.remedies.iter().map(with).collect()));
    }
    parts.push(Part::Figure(plot::looked_at(robot, story)));
    parts.extend(super::folded("How to read torque over speed", Some(Part::Text(CAPTION.into()))));
    parts.push(Part::Table(limits(story)));
    parts.push(Part::Text(Q_AXIS.into()));
    parts.extend(cases(story).map(Part::Table));
    parts.extend(losses(story));
    parts.extend(super::folded("What it needs and weighs", Some(Part::Table(needs(story)))));
    let warnings = warnings(story);
    if !warnings.is_empty() {
        parts.extend(super::folded(
            &format!("What to know before it is used ({})", warnings.len()),
            Some(Part::List(warnings)),
        ));
    }
    parts
}

/// The parts of the loss, drawn where there are any and in words, with what nobody knows of it.
fn losses(story: &Explanation) -> Vec<Part> {
    let e = &story.evaluation;
    let name = format!("{} at N = {}", story.motor.id, number(e.ratio));
    let bars = Bars::of_losses("Mean over the motion".into(), &[(name, &e.losses)]);
    let sentence = format!("Of the {}.", crate::losses::sentence(e));
    let supply = crate::losses::of_supply(e).into_iter().map(|line| capitalised(&line));
    bars.map(Part::Bars).into_iter().chain(std::iter::once(sentence).chain(supply).map(Part::Text)).collect()
}

fn needs(story: &Explanation) -> Table {
    let rows = quantities(story).into_iter().map(|(what, value, unit)| {
        match value.filter(|v| heat_or(*v, unit) != with_unit(*v, unit)) {
            Some(hot) => vec![what.to_string(), heat_or(hot, unit), String::new()],
            None => vec![what.to_string(), optional(value), unit.to_string()],
        }
    });
    Table::new("At this ratio", &["quantity", ">value", "unit"]).rows(rows)
}

fn warnings(story: &Explanation) -> Vec<String> {
    let mut all = Vec::new();
    if story.winding_temperature.runs_away() {
        all.push(RUNAWAY.to_string());
    }
    all.extend(crate::motion::notes(story.joint));
    all.extend(story.unchecked.iter().map(|(limit, why)| format!("not checked: {limit}: {why}")));
    all.extend(story.assumed.iter().map(|(limit, what)| format!("assumed: {limit}: {what}")));
    all.extend(fitted_notes(story.motor, story.joint).into_iter().map(|n| format!("fitted: {}: {}", n.effect, n.how)));
    all.extend(story.motor.assumptions.iter().map(|what| format!("assumed: {what}")));
    all.extend(audit_motor(story.motor).into_iter().map(|f| format!("audit [{}]: {}", f.code, f.message)));
    all
}
