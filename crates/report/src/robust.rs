//! Designs that keep their limits over all tolerances, and how likely the first choice stays ahead.

use std::collections::BTreeMap;

use super::columns::{self, Entry, State};
use super::optimize::proof;
use super::reason::reason_text;
use super::said::window_texts;
use super::table::{Column, Table, paragraph};
use super::{csv_number, design_ratio, number, optimum_ratio};
use gearwise_model::requirement::Robot;
use gearwise_select::answer::{Design, JointResult};
use gearwise_select::program::Certificate;
use gearwise_select::robust::{RobustDesign, RobustJoint, SAMPLES, Taken, Toleranced, standard_error};

/// What stands beside a motor whose row has no tolerance.
const NOMINAL: &str = "no tolerances in the catalogue: nominal";

pub(super) fn percent(share: f64) -> String {
    match share {
        0.0 => "0 %".into(),
        1.0 => "100 %".into(),
        _ => format!("{:.1} % ± {:.1}", 100.0 * share, 100.0 * standard_error(share)),
    }
}

pub(super) fn tolerances_text(all: &[Toleranced]) -> String {
    if all.is_empty() {
        return NOMINAL.into();
    }
    let one = |t: &Toleranced| match t.value {
        0.0 => format!("{} ± {}", t.column, number(t.tolerance)),
        value => match t.published {
            Some([low, high]) => {
                let [low, high] = [low, high].map(|end| 100.0 * (end / value - 1.0));
                format!("{} {low:+.1} % to {high:+.1} % as published", t.column)
            }
            None => format!("{} ± {:.1} %", t.column, 100.0 * t.tolerance / value),
        },
    };
    all.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// The joints whose first design has no number with a tolerance.
pub fn without_tolerances<'j, 'a>(joints: &'j [RobustJoint<'a>]) -> impl Iterator<Item = &'j RobustJoint<'a>> {
    joints.iter().filter(|joint| joint.designs.first().is_some_and(|first| first.toleranced.is_empty()))
}

/// True if every joint has a design of which all limits are proven over tolerances that are known.
pub fn keeps_over_tolerances(joints: &[RobustJoint]) -> bool {
    let is_proven = |joint: &RobustJoint| joint.designs.first().is_some_and(|first| first.unproven.is_empty());
    joints.iter().all(is_proven) && without_tolerances(joints).next().is_none()
}

/// Numbers of designs with tolerances that are proven over them and that are not, in words.
pub(super) fn counted_at_worst(result: &RobustJoint) -> String {
    let with = |proven: bool| {
        result.designs.iter().filter(|d| !d.toleranced.is_empty() && d.unproven.is_empty() == proven).count()
    };
    let open = match with(false) {
        0 => String::new(),
        count => format!(", {count} not proven"),
    };
    format!("of those with tolerances {} also at worst{open}, {} not", with(true), result.lost.len())
}

/// The limits of a design that are not proven over its tolerances, in a sentence; `None` where all are.
pub(super) fn unproven_text(design: &RobustDesign) -> Option<String> {
    let limits = design.unproven.join(", ");
    let ended = if design.is_ended { " (the search ended after its share of the work)" } else { "" };
    (!limits.is_empty())
        .then(|| format!("NOT proven over the tolerances{ended}: {limits}; no tried motor exceeds a limit"))
}

/// For people.
pub fn text(robot: &Robot, joints: &[RobustJoint], top: usize, taken: &Taken) -> String {
    let heading = format!("{}: designs that keep all limits over the tolerances of the motors", robot.name);
    let mut out = paragraph(&heading, 0, 2);
    if let Some(share) = taken.tolerance {
        let line = "of every number whose row states no tolerance, temperatures apart";
        out.push_str(&paragraph(&format!("assumed: ± {} % {line}", number(100.0 * share)), 2, 4));
    }
    if taken.alternatives {
        let line = "taken as ±: the ends of what several sources print of a module's number, where they say side and \
                    convention and no other number of the row contradicts them";
        out.push_str(&paragraph(line, 2, 4));
    }
    for joint in joints {
        out.push('\n');
        out.push_str(&joint_text(joint, top));
    }
    out
}

fn joint_text(result: &RobustJoint, top: usize) -> String {
    let JointResult { joint, candidates, .. } = &result.nominal;
    let heading = format!(
        "{} (×{}), {}: {} can do it by the printed numbers{}; {}",
        joint.name,
        joint.count,
        joint.aim(),
        gearwise_model::words::counted(candidates.len(), "motor"),
        super::unjudged::counted(result.nominal.unjudged.len()),
        counted_at_worst(result)
    );
    let mut out = paragraph(&heading, 0, 2);
    super::family::note(joint).iter().for_each(|note| out.push_str(&paragraph(&format!("{note}."), 2, 4)));
    let columns = vec![
        Column::number("#", ""),
        Column::name("motor"),
        Column::number("N*\nnominal", ""),
        Column::number("N\nrobust", ""),
        Column::number(joint.goal().replace(" + ", "\n+ "), joint.objective.unit()),
        Column::number("at worst", joint.objective.unit()),
        Column::name("proof").dropped(1),
    ];
    let mut table = Table::new(columns).indented(2).also_in("`--csv`, `--json`");
    for (place, d) in result.designs.iter().take(top).enumerate() {
        let mut row = vec![(place + 1).to_string(), d.nominal.motor.id.clone()];
        row.extend([design_ratio(&d.nominal), optimum_ratio(&d.optimum, d.gear)]);
        row.push(number(d.optimum.objective));
        row.push(if d.toleranced.is_empty() { "–".into() } else { number(d.worst_objective) });
        row.push(proof(&d.optimum.certificate));
        table.push(row, vec![details(d, result)]);
    }
    if !table.is_empty() {
        out.push_str(&format!("\n{}", table.text()));
        for (note, places) in notes(result, top) {
            out.push_str(&paragraph(&format!("{}: {note}", places.join(" ")), 2, 4));
        }
        let hidden = result.designs.len().saturating_sub(top);
        if hidden > 0 {
            let line = format!("… and {hidden} more; `--top {}` shows all", result.designs.len());
            out.push_str(&paragraph(&line, 2, 4));
        }
    }
    for lost in &result.lost {
        let sentence = format!(
            "lost to its tolerances: {} (N* = {} by its printed numbers): {}",
            lost.nominal.motor.id,
            design_ratio(&lost.nominal),
            reason_text(&lost.reason, joint).1
        );
        out.push_str(&paragraph(&sentence, 2, 4));
    }
    out.push_str(&super::unjudged::reasons(&result.nominal, ""));
    if !result.contenders.is_empty() {
        let heading = format!(
            "The first {} of the nominal order with their numbers drawn at random, {SAMPLES} times (each ± is two \
             standard deviations; what has no ± stays):",
            result.contenders.len()
        );
        out.push_str(&format!("\n{}", paragraph(&heading, 2, 4)));
        out.push_str(&contenders(result));
    }
    out
}

/// What could not be checked and what was assumed of the first designs, each with the places that it is true of.
pub(super) fn notes(result: &RobustJoint, top: usize) -> BTreeMap<String, Vec<String>> {
    let mut notes: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (place, design) in result.designs.iter().take(top).enumerate() {
        for note in super::unjudged::sentences(&design.unchecked, &design.assumed) {
            notes.entry(note).or_default().push(format!("#{}", place + 1));
        }
    }
    notes
}

/// How likely each of the first keeps its limits and is first.
fn contenders(result: &RobustJoint) -> String {
    let columns = vec![
        Column::name("motor"),
        Column::number("keeps limits\nat N*", ""),
        Column::number("is first", ""),
        Column::number("keeps limits\nat N robust", ""),
        Column::number("is first\nthen", ""),
    ];
    let rows = result.contenders.iter().map(|c| {
        vec![
            c.motor.id.clone(),
            percent(c.feasible_nominal),
            percent(c.first_nominal),
            c.feasible_robust.map_or_else(|| "–".into(), percent),
            percent(c.first_robust),
        ]
    });
    Table::new(columns).indented(2).rows(rows).text()
}

fn details(design: &RobustDesign, result: &RobustJoint) -> String {
    let joint = result.nominal.joint;
    let mut out = tolerances_text(&design.toleranced);
    match design.unchecked.len() {
        0 => {}
        1 => out.push_str("; 1 thing not checked"),
        n => out.push_str(&format!("; {n} things not checked")),
    }
    if design.toleranced.is_empty() {
        return out;
    }
    match design.gear {
        Some(gear) => out.push_str(&format!("; with {gear}")),
        None => {
            let windows = window_texts(&design.optimum, joint).join(" and from ");
            out.push_str(&format!("; feasible at worst from {windows}"));
        }
    }
    if let Some(m) = &design.tightest {
        out.push_str(&format!("; tightest margin at worst {} {:.0} %", m.limit, (100.0 * m.margin).max(0.0)));
    }
    match (unproven_text(design), &design.optimum.certificate) {
        (Some(text), _) => out.push_str(&format!("; {text}")),
        (None, Certificate::NotCertified(why)) => out.push_str(&format!("; not certified: {why}")),
        _ => {}
    }
    out
}

/// As rows: every motor that can do it by its printed numbers, over its tolerances; with what those numbers alone give.
pub fn csv(joints: &[RobustJoint]) -> String {
    let more = ["nominal_only", "nominal_ratio", "nominal_objective", "worst_objective"];
    let rows = joints.iter().flat_map(|of| {
        let joint = of.nominal.joint;
        let nominal = |d: &Design| [d.optimum.ratio, d.optimum.objective].map(|x| csv_number(Some(x)));
        let designs = of.designs.iter().enumerate().map(move |(k, d)| {
            let [ratio, objective] = nominal(&d.nominal);
            let worst = csv_number(Some(d.worst_objective));
            let cells = vec![d.toleranced.is_empty().to_string(), ratio, objective, worst];
            (Entry::design(joint, State::Candidate, Some(k + 1), d.facts()), cells)
        });
        let lost = of.lost.iter().map(move |l| {
            let because = reason_text(&l.reason, joint).1;
            let [ratio, objective] = nominal(&l.nominal);
            let entry = Entry::without(joint, State::Rejected, l.nominal.motor, l.nominal.gear, because);
            (entry, vec!["false".into(), ratio, objective, String::new()])
        });
        designs.chain(lost).collect::<Vec<_>>()
    });
    columns::csv_with(&more, rows, false)
}
