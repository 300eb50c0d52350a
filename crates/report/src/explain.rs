//! The whole story of one motor at a joint.

use super::answer::is_of_range;
use super::optimize::{fitted_notes, proof, windows_text};
use super::reason::reason_text;
use super::said::{bind_text, per_cent};
use super::table::{Column, Table, paragraph};
use super::tint::Tint;
use super::{currents, heat_or, number, optimum_ratio, optional};
use gearwise_model::actuator::limits::UNBOUNDED;
use gearwise_model::actuator::metrics::{METRICS, Shown};
use gearwise_model::catalog::alternative::lines;
use gearwise_model::catalog::audit::{audit_motor, conventions_line};
use gearwise_model::requirement::Joint;
use gearwise_model::words::number_below;
use gearwise_select::answer::Reason;
use gearwise_select::evaluate::Margin;
use gearwise_select::explain::{Explanation, Forbidden, Remedy};
use gearwise_select::figures::{FIGURES, figure};
use gearwise_select::program::{Certificate, Optimum};

/// A share in per cent; the margin of an infinite demand is a word.
pub(super) fn percent(fraction: f64) -> String {
    if fraction <= UNBOUNDED {
        return "exceeded".to_string();
    }
    format!("{}{} %", if fraction > 0.0 { "+" } else { "" }, number((1e4 * fraction).round() / 100.0))
}

/// For people.
pub fn text(story: &Explanation) -> String {
    let e = &story.evaluation;
    let joint = story.joint;
    let gear = story.gear.map_or_else(String::new, |g| format!(" with {}", g.id));
    let verdict = verdict(story);
    let at = match &story.best {
        Some(Ok(best)) if best.ratio == e.ratio => optimum_ratio(best, None),
        _ => number(e.ratio),
    };
    let heading = format!("{}: {} at N = {at}{gear} {verdict}", joint.name, story.motor.id);
    let mut out = format!("{}\n", paragraph(&heading, 0, 2));
    out.push_str(&limits(story));
    out.push('\n');
    let quantities = quantities(story);
    let room = quantities.iter().map(|(what, ..)| what.chars().count() + 2).fold(24, usize::max);
    // A module that says ratings alone has few of them.
    let ratings_alone = story.motor.inside.as_deref().is_some_and(|inside| !inside.says_currents());
    let mut unknown: Vec<&str> = Vec::new();
    for (what, value, unit) in quantities {
        if ratings_alone && value.is_none_or(f64::is_nan) {
            unknown.extend(Some(what).filter(|what| unknown.last() != Some(what)));
            continue;
        }
        let value = value.map_or_else(
            || format!("{} {unit}", optional(None)),
            |value| match heat_or(value, unit) {
                hot if hot != super::with_unit(value, unit) => hot,
                _ => format!("{} {unit}", number(value)),
            },
        );
        out.push_str(&format!("  {what:<room$}{value}\n"));
        if what == figure("winding_temperature_k").words && story.winding_temperature.runs_away() {
            out.push_str(&paragraph(RUNAWAY, 2, 4));
        }
    }
    if !unknown.is_empty() {
        out.push_str(&paragraph(&format!("not known, since its row has no constants: {}", unknown.join(", ")), 2, 4));
    }
    if let Some(line) = super::said::gear_of_ratio(joint, e.ratio).filter(|_| story.gear.is_none()) {
        out.push_str(&format!("\n{}", paragraph(&capitalised(&line), 0, 2)));
    }
    if !ratings_alone {
        out.push_str(&format!("\n{}", paragraph(&format!("Of the {}.", super::losses::sentence(e)), 0, 2)));
    }
    for line in super::losses::of_supply(e) {
        out.push_str(&paragraph(&capitalised(&line), 0, 2));
    }
    match &story.spring {
        Some(Ok(spring)) => {
            let line = format!("With a {}", super::spring::text(spring, e.loss));
            let line = if spring.rest_angle.is_some() { line } else { super::spring::text(spring, e.loss) };
            out.push_str(&format!("\n{}", paragraph(&line, 0, 0)));
            let line = "shadow prices, sensitivities and what would have to change are those at this spring";
            out.push_str(&paragraph(line, 2, 4));
        }
        Some(Err(why)) => {
            let line = no_spring(story, why);
            out.push_str(&format!("\n{}", paragraph(&line, 0, 0)));
        }
        None => {}
    }
    match &story.best {
        Some(Ok(optimum)) => out.push_str(&best(story, optimum)),
        Some(Err(reason)) => {
            let line = format!("No ratio of this motor will do: {}.", reason_text(reason, joint).1);
            out.push_str(&format!("\n{}", paragraph(&line, 0, 0)));
        }
        None => {}
    }
    if !story.remedies.is_empty() {
        let heading = if story.best.is_some() { would_do(story) } else { "What is exceeded" };
        out.push_str(&format!("\n{heading}:\n"));
        for remedy in &story.remedies {
            out.push_str(&paragraph(&remedy_text(remedy), 2, 4));
        }
    } else if matches!(story.best, Some(Err(_))) {
        let line = "No single limit, widened alone, would make it feasible.";
        out.push_str(&format!("\n{}", paragraph(line, 0, 2)));
    }
    if let Some(line) = story.turns.and_then(|turns| super::turns::here(&turns, story.motor)) {
        out.push_str(&format!("\n{}", paragraph(&line, 0, 2)));
    }
    let fitted = fitted_notes(story.motor, joint);
    if !fitted.is_empty() {
        out.push_str("\nFitted to this actuator:\n");
        for note in fitted {
            out.push_str(&paragraph(&format!("{}: {}", note.effect, note.how), 2, 4));
        }
    }
    if !story.unchecked.is_empty() {
        out.push_str("\nNot checked:\n");
        for (limit, why) in &story.unchecked {
            out.push_str(&paragraph(&format!("{limit}: {why}"), 2, 4));
        }
    }
    if !story.assumed.is_empty() {
        out.push_str("\nAssumed:\n");
        for (limit, what) in &story.assumed {
            out.push_str(&paragraph(&format!("{limit}: {what}"), 2, 4));
        }
    }
    if !joint.carries.is_empty() {
        let line = "This joint carries other actuators, whose masses are not in its load here: the choice of the whole robot has them.";
        out.push_str(&format!("\n{}", paragraph(line, 0, 2)));
    }
    for (place, note) in super::motion::notes(joint).into_iter().enumerate() {
        out.push_str(if place == 0 { "\n" } else { "" });
        out.push_str(&paragraph(&format!("{note}."), 0, 2));
    }
    let line = format!("The row: {}; {}", conventions_line(story.motor), story.motor.source);
    out.push_str(&format!("\n{}", paragraph(&line, 0, 2)));
    if !story.motor.note.is_empty() {
        out.push_str(&paragraph(&story.motor.note, 2, 2));
    }
    if let Some(gear) = story.gear {
        let of = super::catalog::card::sourced(&gear.source, &gear.source_date, gear.source_kind);
        out.push_str(&paragraph(&format!("The gear's row, {}: {of}", gear.id), 0, 2));
        if !gear.note.is_empty() {
            out.push_str(&paragraph(&gear.note, 2, 2));
        }
    }
    for assumption in &story.motor.assumptions {
        out.push_str(&paragraph(&format!("assumed: {assumption}"), 2, 4));
    }
    for finding in audit_motor(story.motor) {
        out.push_str(&paragraph(&format!("audit [{}]: {}", finding.code, finding.message), 2, 4));
    }
    let elsewhere = story.motor.inside.as_deref().map_or_else(Vec::new, |inside| lines(&inside.alternatives));
    if !elsewhere.is_empty() {
        out.push_str(&paragraph("Other sources say (not computed with; `catalog show` names them):", 2, 4));
    }
    elsewhere.iter().for_each(|line| out.push_str(&paragraph(line, 4, 6)));
    out
}

/// A line as a sentence: with a capital letter and a full stop.
pub(super) fn capitalised(line: &str) -> String {
    let rest = line.chars().next().map_or(0, char::len_utf8);
    format!("{}{}.", line[..rest].to_uppercase(), &line[rest..])
}

/// How the design stands.
pub(super) fn verdict(story: &Explanation) -> String {
    if let Some(why) = story.forbidden() {
        let judged = if story.evaluation.feasible {
            "keeps the limits that could be checked, but"
        } else {
            "is not feasible, and"
        };
        return match why {
            Forbidden::Ratio(min, max) => format!(
                "{judged} is outside of the ratios that the requirement allows, {} to {}",
                number(min),
                number(max)
            ),
            Forbidden::NotListed => format!("{judged} has a ratio that the requirement does not list"),
            Forbidden::Gear => format!("{judged} has a gear that the requirement does not allow"),
            Forbidden::DoesNotFit => format!("{judged} has a gear that is not made for this motor"),
        };
    }
    match (story.evaluation.feasible, story.unjudged.is_empty()) {
        (false, _) => "is not feasible".into(),
        (true, true) => "keeps every limit that could be checked".into(),
        (true, false) => format!(
            "{}. The requirement asks for that, so it is no choice; all else that could be checked is kept",
            super::unjudged::sentence(&story.unjudged)
        ),
    }
}

/// That no spring will do, and with which one all else is.
pub(super) fn no_spring(story: &Explanation, why: &Reason) -> String {
    let with = match story.nearest_spring {
        None => "without a spring".into(),
        Some((stiffness, rest)) => format!(
            "with the allowed spring that came nearest, {} N*m/rad with its rest at {} deg",
            number(stiffness),
            number(rest.to_degrees())
        ),
    };
    format!("No spring will do: {}. All else is {with}.", reason_text(why, story.joint).1)
}

/// What is said where the winding has no steady temperature.
pub(super) const RUNAWAY: &str = "thermal runaway: the copper's resistance rises faster than heat flows off";

/// What the design needs and weighs: name, value, unit.
pub(super) fn quantities(story: &Explanation) -> Vec<(&'static str, Option<f64>, &'static str)> {
    let facts = story.facts();
    let said = FIGURES.iter().filter(|f| f.is_of_every_design() || f.value(&facts).is_some());
    let figures = said.map(|f| (f.words, f.shown(&facts), f.unit_of(&facts)));
    // Of a price that is not known whole it is said what is known.
    let part = facts.evaluation.price.filter(|cost| cost.whole.missing.is_some() && cost.whole.known > 0.0);
    let part = part.map(|cost| ("price, at least", Some(cost.whole.known), cost.currency.code()));
    let metrics = METRICS.iter().filter(|m| m.shown == Shown::AsOrder);
    let metrics =
        metrics.map(|m| (m.symbol, m.value(story.motor).map(|v| gearwise_model::units::in_unit(v, m.unit)), m.unit));
    figures.chain(part).chain(metrics).collect()
}

/// What widening one limit would bring: no more than what can be judged is promised.
pub(super) fn would_do(story: &Explanation) -> &'static str {
    match story.unchecked.is_empty() && !story.remedies.iter().any(|remedy| remedy.at_least) {
        true => "Any one of these would make it feasible",
        false => "With any one of these it would keep every limit that can be judged, not those that are not checked",
    }
}

pub(super) fn remedy_text(remedy: &Remedy) -> String {
    // Of a limit of zero there are no shares.
    let more = match remedy.bound == 0.0 {
        true => String::new(),
        false => format!("{}, ", percent(remedy.needed / remedy.bound - 1.0)),
    };
    format!(
        "{} of at least {} instead of {} ({}{}'s), at N = {}",
        remedy.limit,
        gearwise_model::words::with_unit(remedy.needed, remedy.unit),
        number(remedy.bound),
        more,
        remedy.owner,
        number(remedy.ratio)
    )
}

/// The columns of [`limit_rows`].
pub(super) fn limit_columns() -> Vec<Column> {
    vec![
        Column::name("limit"),
        Column::number("demand", ""),
        Column::number("limit", ""),
        Column::name("unit"),
        Column::number("margin", ""),
        Column::name("whose").dropped(1),
        Column::name("at").dropped(2),
    ]
}

fn limits(story: &Explanation) -> String {
    let mut rows = limit_rows(&story.evaluation.margins, story.joint);
    for (row, margin) in rows.iter_mut().zip(tightest_first(&story.evaluation.margins)) {
        row[4] = Tint::of(margin).on(&row[4]);
    }
    let table = Table::new(limit_columns()).also_in("`--json`").rows(rows).text();
    format!("{table}\n{}", paragraph(currents::Q_AXIS, 2, 2))
}

/// Margins, the tightest first.
fn tightest_first(margins: &[Margin]) -> Vec<&Margin> {
    let mut margins: Vec<_> = margins.iter().collect();
    margins.sort_by(|a, b| a.margin.total_cmp(&b.margin).then(a.limit.cmp(b.limit)));
    margins
}

/// The limits of a design, tightest first.
pub(super) fn limit_rows(margins: &[Margin], joint: &Joint) -> Vec<Vec<String>> {
    tightest_first(margins)
        .iter()
        .map(|m| {
            let case = || m.case(joint).map_or_else(String::new, |case| case.name.clone());
            let at = m.sample.map_or_else(case, |k| joint.motion.name_sample(k));
            vec![
                m.limit.into(),
                // A cell: the word alone.
                match heat_or(m.demand, m.unit) {
                    hot if hot != super::with_unit(m.demand, m.unit) => hot,
                    _ => number(m.demand),
                },
                number(m.bound),
                m.unit.into(),
                percent(m.margin),
                whose(m, joint),
                at,
            ]
        })
        .collect()
}

/// Whose limit it is, which part of the actuator it is on, and what is kept of it in reserve.
fn whose(margin: &Margin, joint: &Joint) -> String {
    let part = margin.parts.and_then(|parts| parts.part).map(|part| format!(" on the {}", part.word()));
    let owner = format!("{}{}", margin.owner, part.unwrap_or_default());
    match joint.limits.reserve(margin.limit) {
        share if share > 0.0 => format!("{owner}, less {} reserve", per_cent(share)),
        _ => owner,
    }
}

/// The best ratio in a sentence.
pub(super) fn best_line(story: &Explanation, optimum: &Optimum) -> String {
    let joint = story.joint;
    let windows = windows_text(optimum, joint);
    format!(
        "Best ratio for {}: N* = {} with {} ({}){}.",
        joint.aim(),
        optimum_ratio(optimum, None),
        super::with_unit(optimum.objective, joint.objective.unit()),
        proof(&optimum.certificate),
        windows.map_or_else(String::new, |windows| format!("; feasible from {windows}"))
    )
}

/// What holds an optimum at which no limit has a price.
fn unpriced(optimum: &Optimum, joint: &Joint) -> String {
    let window = optimum.window();
    let is_at = |end: f64| (end / optimum.ratio - 1.0).abs() <= AT_AN_END;
    let bind = is_at(window.max).then_some(&window.high).or_else(|| is_at(window.min).then_some(&window.low));
    match bind {
        None => "no limit binds at N*: every shadow price is zero".into(),
        Some(bind) if is_of_range(bind.limit) => {
            "N* is at the end of the ratios: nothing is known of what lies beyond".into()
        }
        Some(bind) if bind.unjudged.is_some() => format!("beyond N* {} cannot be judged", bind.limit),
        Some(bind) => format!("{} binds at N*; it has no shadow price here", bind_text(bind, joint)),
    }
}

/// As near to the end of its window an optimum is at that end (relative).
const AT_AN_END: f64 = 1e-6;

fn best(story: &Explanation, optimum: &Optimum) -> String {
    let joint = story.joint;
    let line = best_line(story, optimum);
    let mut out = format!("\n{}", paragraph(&line, 0, 0));
    if let Certificate::Certified { lower_bound, method, .. } = &optimum.certificate {
        let unit = if joint.objective.unit() == "1" { String::new() } else { format!(" {}", joint.objective.unit()) };
        let line = format!("no ratio is better than {}{unit} ({method})", number_below(*lower_bound));
        out.push_str(&paragraph(&line, 2, 4));
    }
    if optimum.shadow_prices.is_empty() {
        out.push_str(&paragraph(&unpriced(optimum, joint), 2, 4));
    }
    for price in &optimum.shadow_prices {
        let change = percent(price.elasticity / 100.0);
        out.push_str(&paragraph(&format!("{} +1 %: {} {change}", price.limit, joint.goal()), 2, 4));
    }
    out.push_str("\nIf the motor were better, with the ratio chosen again:\n");
    for s in &story.sensitivities {
        let change = s
            .objective
            .map_or_else(|| "no ratio is feasible".to_string(), |o| format!("{} {}", joint.goal(), percent(o)));
        out.push_str(&paragraph(&format!("{} {}: {change}", s.parameter, percent(s.change)), 2, 4));
    }
    out
}
