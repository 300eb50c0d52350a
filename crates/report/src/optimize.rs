//! The choice for each joint, and why not the others.

use std::collections::{BTreeMap, BTreeSet};

pub use super::said::{Shown, bind_text, proof};
pub(super) use super::said::{choice_text, margin_at, with_gear};
pub(super) use super::said::{joint_notes, windows_text};

use super::columns::{self, Entry, State};
use super::reason::reason_text;
use super::table::{Column, Table, paragraph, wrap};
use super::{answer, design_ratio, different_motors, estimated, number, outlook, prune, turns, unjudged};
use gearwise_model::actuator::fitted::{self, Note};
use gearwise_model::actuator::limits::hottest;
use gearwise_model::actuator::metrics::{METRICS, Metric, metric};
use gearwise_model::catalog::Motor;
use gearwise_model::catalog::audit::{Finding, Severity, audit_motor};
use gearwise_model::requirement::{Joint, Quantity, RatioChoice};
use gearwise_select::answer::{Budgeted, Design, JointResult, Reason, Rejected, RobotResult, Unusable};
use gearwise_select::outlook::Outlook;
use gearwise_select::program::{Certificate, Optimum};

/// For people: the answer, and as much of the rest as is asked for. `outlooks` are those of the joints, in their order.
pub fn text(result: &RobotResult, outlooks: &[Outlook], of_rules: &[String], shown: Shown) -> String {
    let robot = result.robot;
    let motors = result.joints.first().map_or(0, JointResult::motors);
    let modules = robot.modules().next().is_some();
    let kind = match robot.joints.iter().all(|joint| joint.motors.only_modules) {
        true => "module",
        false if modules => "actuator",
        false => "motor",
    };
    let heading = format!(
        "{}: {}, {}, bus {} V; currents are phase amplitudes (DC if brushed)",
        robot.name,
        super::counted(robot.joints.len(), "joint"),
        super::counted(motors, kind),
        number(robot.bus.voltage)
    );
    let mut out = paragraph(&heading, 0, 2);
    if let Some(driven) = &robot.driven {
        out.push_str(&super::torques::driven_text(driven, robot));
    }
    let with_outlooks = || {
        let none = std::iter::repeat(None);
        result.joints.iter().zip(outlooks.iter().map(Some).chain(none))
    };
    if !shown.full {
        out.push('\n');
        out.push_str(&answer::text(result, outlooks));
        totals(result).iter().chain(of_rules).for_each(|line| out.push_str(&paragraph(line, 2, 4)));
        for (joint, outlook) in with_outlooks() {
            let why = if shown.why { outlook::text(joint, outlook) } else { String::new() };
            let rejected = if shown.rejected || joint.candidates.is_empty() {
                unjudged::text(joint, outlook, shown.rejected) + &rejected_text(joint, outlook, shown)
            } else {
                String::new()
            };
            if !(why.is_empty() && rejected.is_empty()) {
                let heading = format!("{} (×{}), {}:", joint.joint.name, joint.joint.count, verdict(joint));
                out.push_str(&format!("\n{}{why}{rejected}", paragraph(&heading, 0, 2)));
            }
        }
        out.push_str(&format!("\n{}", paragraph(answer::further(shown), 0, 2)));
        return out;
    }
    for (joint, outlook) in with_outlooks() {
        out.push('\n');
        out.push_str(&joint_text(joint, outlook, shown));
    }
    out.push('\n');
    out.push_str(&summary(result));
    of_rules.iter().for_each(|line| out.push_str(&paragraph(line, 0, 2)));
    out
}

/// The ratios that a joint may have.
pub(super) fn ratio_text(joint: &Joint) -> String {
    let modules = &joint.motors.modules;
    if joint.motors.only_modules {
        return format!("modules {}", modules.join(", "));
    }
    let motors = ratio_of_motors(joint);
    if modules.is_empty() { motors } else { format!("{motors}, or modules {}", modules.join(", ")) }
}

fn ratio_of_motors(joint: &Joint) -> String {
    match &joint.ratio {
        RatioChoice::Continuous { min, max } => {
            let between = joint.family_map().map(|map| format!(", at and between the points of {}", map.family()));
            format!("ratio {} to {}{}", number(*min), number(*max), between.unwrap_or_default())
        }
        RatioChoice::Listed { teeth: Some(teeth), .. } => super::teeth::ratios(teeth),
        RatioChoice::Listed { values, step: Some(step), .. } => {
            let ends = (values.first().copied().unwrap_or(f64::NAN), values.last().copied().unwrap_or(f64::NAN));
            format!("ratio {} to {} in steps of {}", number(ends.0), number(ends.1), number(*step))
        }
        RatioChoice::Listed { values, step: None, .. } => {
            format!("ratio {}", values.iter().map(|n| n.to_string()).collect::<Vec<_>>().join(", "))
        }
        RatioChoice::Catalog { patterns, from, .. } => format!("{} {}", from.word(), patterns.join(", ")),
    }
}

/// How many motors can do a joint.
pub(super) fn verdict(result: &JointResult) -> String {
    match &result.pruned {
        None => {
            let can = result.candidates.len();
            format!("{} can do it, {}", gearwise_model::words::counted(can, "motor"), prune::refusals(result))
        }
        Some(pruned) => prune::verdict(result, pruned),
    }
}

fn joint_text(result: &JointResult, outlook: Option<&Outlook>, shown: Shown) -> String {
    let joint = result.joint;
    let (ratio, verdict) = (ratio_text(joint), verdict(result));
    let heading = format!("{} (×{}), {ratio}, {}: {verdict}", joint.name, joint.count, joint.aim());
    let mut out = paragraph(&heading, 0, 2);
    let notes = joint_notes(joint, false).into_iter().chain(super::said::gears_note(result));
    notes.for_each(|note| out.push_str(&paragraph(&note, 2, 4)));
    if let Some(spring) = &joint.limits.spring {
        out.push_str(&paragraph(&super::spring::asked(spring), 2, 2));
    }
    out.push_str(&super::balance::text(result));
    if !result.candidates.is_empty() {
        out.push('\n');
        out.push_str(&candidates_table(result, shown.top));
        out.push_str(&footnotes(result, shown.top));
        if shown.why {
            out.push_str(&outlook::text(result, outlook));
        }
    }
    out.push_str(&unjudged::text(result, outlook, shown.rejected));
    out.push_str(&rejected_text(result, outlook, shown));
    if let Some(pruned) = &result.pruned {
        out.push_str(&prune::text(joint, pruned));
    } else if result.candidates.len() >= 3 {
        let metrics = result.agreement.iter().filter_map(|a| {
            let symbol = METRICS.iter().find(|m| m.name == a.metric)?.symbol;
            Some(format!("{symbol} {}", a.tau.map_or_else(|| "?".into(), |t| format!("{t:+.2}"))))
        });
        let list = metrics.collect::<Vec<_>>().join(", ");
        out.push_str(&format!(
            "  {}\n",
            wrap(&format!("Order by metric against order by this task (Kendall's τ, 1 is the same order): {list}"), 4)
        ));
    }
    out
}

fn candidates_table(result: &JointResult, top: usize) -> String {
    let joint = result.joint;
    let (columns, with_objective) = candidate_columns(joint);
    let mut table = Table::new(columns).indented(2).also_in("`--csv`, `--json`");
    for (place, design) in result.candidates.iter().take(top).enumerate() {
        let facts = design.facts();
        let mut row = vec![(place + 1).to_string(), design.motor.id.clone(), design_ratio(design)];
        if with_objective {
            row.push(number(design.optimum.objective));
        }
        row.extend(columns::in_tables().map(|figure| columns::cell(figure, &facts)));
        row.push(columns::metric_cell(responsiveness(), design.motor));
        row.push(proof(&design.optimum.certificate));
        table.push(row, vec![details(design, joint)]);
    }
    let mut out = table.text();
    let hidden = result.candidates.len().saturating_sub(top);
    if hidden > 0 {
        let line = format!("… and {hidden} more; `--top {}` shows all", result.candidates.len());
        out.push_str(&paragraph(&line, 2, 4));
    }
    out
}

/// The columns of the candidates, and whether one of them is the objective's alone. What is minimised is never dropped.
fn candidate_columns(joint: &Joint) -> (Vec<Column>, bool) {
    let sole = joint.objective.sole().map_or("", Quantity::name);
    // What tables show anyway has its column; else what is minimised has one of its own.
    let shown = columns::in_tables().any(|figure| figure.name == sole || figure.name == format!("{sole}_phase"));
    let objective = (!shown).then(|| match sole {
        "" => Column::number("objective", ""),
        _ => Column::number(joint.goal(), joint.objective.unit()),
    });
    let with_objective = objective.is_some();
    let geared = matches!(joint.ratio, RatioChoice::Catalog { .. });
    let ratio = if geared { "N" } else { "N*" };
    let kept = if sole == "peak_current" { "peak_current_phase" } else { sole };
    let mut shown = vec![Column::number("#", ""), Column::name("motor"), Column::number(ratio, "")];
    shown.extend(objective);
    shown.extend(columns::in_tables().map(|figure| columns::heading(figure, kept)));
    shown.push(columns::metric_heading(responsiveness(), "", 1));
    shown.push(Column::name("proof").dropped(2));
    (shown, with_objective)
}

/// The metric that tables of designs show.
fn responsiveness() -> &'static Metric {
    metric("s_m").expect("a metric of the list")
}

/// Which ratios are feasible and what ends them, and which limit is nearest.
fn details(design: &Design, joint: &Joint) -> String {
    let tightest = design
        .evaluation
        .tightest()
        .map_or_else(|| "nothing could be checked".into(), |m| format!("tightest margin {}", margin_at(m, joint)));
    let tightest = match design.unchecked.len() {
        0 => tightest,
        1 => format!("{tightest}; 1 thing not checked"),
        n => format!("{tightest}; {n} things not checked"),
    };
    let tightest = tightest + &estimated::text(design.motor);
    let tightest = match &design.spring {
        Some(spring) => format!("{tightest}; {}", super::spring::text(spring, design.evaluation.loss)),
        None => tightest,
    };
    if let Some(gear) = with_gear(design) {
        return format!("{gear}; {tightest}");
    }
    match windows_text(&design.optimum, joint) {
        Some(windows) => format!("feasible from {windows}; {tightest}"),
        None => tightest,
    }
}

/// What cannot be judged beyond the windows of an optimum, each once.
fn beyond(optimum: &Optimum) -> BTreeSet<(&'static str, &'static str)> {
    let ends = optimum.windows.iter().flat_map(|w| [&w.low, &w.high]);
    ends.filter_map(|bind| Some((bind.limit, bind.unjudged?))).collect()
}

/// What could not be checked or certified for the candidates shown, as lines.
fn footnotes(result: &JointResult, top: usize) -> String {
    let lines = notes(result, top)
        .into_iter()
        .map(|(note, places)| format!("  {}\n", wrap(&format!("{}: {note}", places.join(" ")), 4)));
    lines.collect()
}

/// What could not be checked or certified for the first candidates, each with the places that it is true of.
pub(super) fn notes(result: &JointResult, top: usize) -> BTreeMap<String, Vec<String>> {
    let mut notes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut add = |note: String, place: usize| notes.entry(note).or_default().push(format!("#{}", place + 1));
    for (place, design) in result.candidates.iter().take(top).enumerate() {
        for finding in contradictions(design.motor) {
            add(format!("the row contradicts itself (`gearwise audit`): {finding}"), place);
        }
        for note in unjudged::sentences(&design.unchecked, &design.assumed) {
            add(note, place);
        }
        for (limit, why) in beyond(&design.optimum) {
            add(format!("beyond its ratios {limit} cannot be judged: {why}"), place);
        }
        for note in fitted_notes(design.motor, result.joint) {
            add(format!("fitted: {} {}", note.effect, note.how), place);
        }
        if let Certificate::NotCertified(why) = &design.optimum.certificate {
            let found = match design.spring.map(|s| s.gap) {
                Some(Some(gap)) => format!("the best that was found; it {}", super::may_be_beaten(gap)),
                Some(None) => "the best that was found, without a bound".into(),
                None => "the best of a refined grid".into(),
            };
            add(format!("not certified: {why}; {found}"), place);
        }
        if design.winding_temperature.runs_away() {
            add("thermal runaway: the copper's resistance rises faster than heat flows off".into(), place);
        }
        if design.reversal_time.is_some_and(|t| t.is_infinite()) {
            add("no voltage is left to turn the current round where the motion reverses".into(), place);
        }
    }
    notes
}

/// How what was fitted for a motor enters the limits of a joint.
pub fn fitted_notes(motor: &Motor, joint: &Joint) -> Vec<Note> {
    fitted::notes(motor, joint, Some(hottest(motor, joint).0))
}

/// What the audit calls an error in a motor's row, where its note does not explain it.
pub(super) fn contradictions(motor: &Motor) -> Vec<String> {
    let wrong = |f: &Finding| f.severity == Severity::Error && !f.accepted;
    audit_motor(motor).into_iter().filter(wrong).map(|f| f.message).collect()
}

/// What another number of turns would do for a motor that is rejected; empty where nothing is to be said.
pub fn rewound_text(result: &JointResult, outlook: Option<&Outlook>, rejected: &Rejected) -> String {
    let how = outlook.and_then(|outlook| outlook.rewinding(rejected.motor));
    how.map_or_else(String::new, |how| turns::refused(how, Some(&rejected.reason), rejected.motor, result.joint))
}

fn rejected_text(result: &JointResult, outlook: Option<&Outlook>, shown: Shown) -> String {
    if result.rejected.is_empty() {
        return String::new();
    }
    let mut out = String::new();
    let is_asked = |rejected: &&Rejected| rejected.reason != Reason::Unusable(Unusable::NotAllowed);
    if shown.rejected {
        out.push_str("\n  Rejected:\n");
        for rejected in result.rejected.iter().filter(is_asked) {
            let Rejected { motor, reason, .. } = rejected;
            let why = reason_text(reason, result.joint).1;
            let turns = match rewound_text(result, outlook, rejected) {
                none if none.is_empty() => none,
                sentence => format!("; {sentence}"),
            };
            out.push_str(&format!(
                "    {}\n",
                wrap(&format!("{}: {why}{turns}{}", motor.id, estimated::text(motor)), 6)
            ));
        }
        let ids: Vec<&str> = result.rejected.iter().filter(|r| !is_asked(r)).map(|r| r.motor.id.as_str()).collect();
        if !ids.is_empty() {
            let why = reason_text(&Reason::Unusable(Unusable::NotAllowed), result.joint).1;
            out.push_str(&format!("    {}\n", wrap(&format!("{} × {why}: {}", ids.len(), ids.join(", ")), 6)));
        }
        return out;
    }
    let mut classes: BTreeMap<String, Vec<&Rejected>> = BTreeMap::new();
    for rejected in result.rejected.iter().filter(is_asked) {
        classes.entry(reason_text(&rejected.reason, result.joint).0).or_default().push(rejected);
    }
    let mut classes: Vec<_> = classes.into_iter().collect();
    classes.sort_by(|a, b| b.1.len().cmp(&a.1.len()).then(a.0.cmp(&b.0)));
    if !classes.is_empty() {
        out.push_str("\n  Why not the others (`--rejected` lists each):\n");
    }
    for (class, members) in classes {
        let ids: Vec<&str> = members.iter().take(3).map(|r| r.motor.id.as_str()).collect();
        let more = if members.len() > 3 { ", …" } else { "" };
        out.push_str(&format!(
            "    {}\n",
            wrap(&format!("{:>3} × {class}: {}{more}", members.len(), ids.join(", ")), 10)
        ));
    }
    out
}

/// What the first choices come to, and what the budgets of the requirement say of it.
pub(super) fn budget_lines(result: &RobotResult) -> Vec<String> {
    let several = different_motors(result.distinct_motors());
    let mut lines = vec![match result.mass_budget() {
        Budgeted::Within(mass, limit) => {
            format!("actuator mass {} kg, within the budget of {} kg", number(mass), number(limit))
        }
        Budgeted::Over(mass, limit) => {
            format!("actuator mass {} kg, OVER the budget of {} kg", number(mass), number(limit))
        }
        Budgeted::Unknown(limit) => {
            format!(
                "the actuator mass budget of {} kg cannot be checked: a mass is missing, or a joint has no choice",
                number(limit)
            )
        }
        Budgeted::NotAsked(Some(mass)) => format!("actuator mass {} kg, {several}", number(mass)),
        Budgeted::NotAsked(None) => {
            "the actuator mass is not known: a mass is missing, or a joint has no choice".into()
        }
    }];
    lines.extend(match result.motors_budget() {
        Budgeted::Within(_, limit) => {
            Some(format!("{several}, within the budget of {limit} (each joint chosen by itself)"))
        }
        Budgeted::Over(_, limit) => {
            Some(format!("{several}, OVER the budget of {limit} (each joint chosen by itself)"))
        }
        Budgeted::Unknown(_) | Budgeted::NotAsked(_) => None,
    });
    lines
}

fn summary(result: &RobotResult) -> String {
    let robot = result.robot;
    let mut out = String::from(match robot.is_coupled() {
        true => "First choices, each joint by itself and carrying nothing:",
        false => "First choices:",
    });
    out.push('\n');
    for joint in &result.joints {
        let choice = joint.candidates.first().map_or_else(|| "none".to_string(), choice_text);
        out.push_str(&paragraph(&format!("{} ×{}: {choice}", joint.joint.name, joint.joint.count), 2, 4));
        let checked = joint.candidates.iter().find(|d| d.unchecked.is_empty());
        let line = match (joint.candidates.first(), checked) {
            (Some(first), Some(checked)) if !first.unchecked.is_empty() => {
                format!("best with every limit checked: {}", choice_text(checked))
            }
            (Some(first), None) if !first.unchecked.is_empty() && joint.pruned.is_some() => {
                "none of the first has every limit checked; the others were not looked at".into()
            }
            (Some(first), None) if !first.unchecked.is_empty() => {
                "no motor of which every limit could be checked can do it".into()
            }
            _ => continue,
        };
        out.push_str(&paragraph(&line, 4, 6));
    }
    totals(result).iter().for_each(|line| out.push_str(&paragraph(line, 2, 4)));
    out
}

/// What is said of all joints together.
fn totals(result: &RobotResult) -> Vec<String> {
    let robot = result.robot;
    let mut lines = budget_lines(result);
    let several = robot.joints.iter().map(|j| j.count).sum::<u32>() > 1;
    if several && robot.shared_power().is_none() && (robot.bus.power.is_some() || robot.bus.current.is_some()) {
        let line = "the bus's power and current are kept by each joint alone; `power` in [budget] limits all together";
        lines.push(line.into());
    }
    lines.extend(without_choice(result, "NO"));
    lines
}

/// What is said of joints that have no choice.
pub fn without_choice(result: &RobotResult, no: &str) -> Vec<String> {
    let without = result.joints.iter().filter(|j| j.candidates.is_empty());
    let told = |j: &'_ JointResult<'_>| unjudged::left_out(j.rejected.iter().map(|r| &r.reason));
    let without =
        without.map(|j| unjudged::Without { joint: &j.joint.name, unjudged: j.unjudged.len(), unchecked: told(j) });
    unjudged::without_choice(without, no)
}

/// As rows: every motor at every joint, feasible or not.
pub fn csv(result: &RobotResult) -> String {
    let sprung = result.joints.iter().any(|j| j.joint.limits.spring.is_some());
    columns::csv(result.joints.iter().flat_map(entries), sprung)
}

/// The motors of a joint as rows: designs, what cannot be judged, what cannot do it, what was not solved.
fn entries<'a>(result: &'a JointResult<'a>) -> Vec<Entry<'a>> {
    let joint = result.joint;
    let mut all = designs(result);
    all.extend(result.unjudged.iter().map(|u| {
        let because = unjudged::sentence(&u.because);
        match &u.design {
            Some(design) => Entry::design(joint, State::Unjudged, None, design.facts()).because(because),
            None => Entry::without(joint, State::Unjudged, u.motor, u.gear, because),
        }
    }));
    all.extend(
        result
            .rejected
            .iter()
            .map(|r| Entry::without(joint, State::Rejected, r.motor, r.gear, reason_text(&r.reason, joint).1)),
    );
    if let Some(pruned) = &result.pruned {
        all.extend(pruned.not_solved.iter().map(|(motor, bound)| {
            let because = prune::reason(joint, pruned.keep, *bound);
            Entry::without(joint, State::NotSolved, motor, None, because)
        }));
    }
    all
}

/// The candidates of a joint as rows.
pub fn designs<'a>(result: &'a JointResult<'a>) -> Vec<Entry<'a>> {
    let ranked = result.candidates.iter().enumerate();
    ranked.map(|(k, d)| Entry::design(result.joint, State::Candidate, Some(k + 1), d.facts())).collect()
}
