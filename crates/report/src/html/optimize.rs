//! The page of the choice for each joint.

use super::{Bars, Page, Part, Section, Table, Verdict, asked, estimated, group_of, robot as robot_page, tightest};
use crate::answer::by_ratings;
use crate::explain::{limit_columns, limit_rows};
use crate::optimize::{
    bind_text, budget_lines, choice_text, joint_notes, notes, proof, ratio_text, rewound_text, verdict, without_choice,
};
use crate::outlook::{heading, near_gear_cells, no_gear};
use crate::plot::{design as plot, trade};
use crate::reason::reason_text;
use crate::said::gear_of_ratio;
use crate::{columns, design_ratio, different_motors, number, optional, spring};
use gearwise_model::actuator::metrics::METRICS;
use gearwise_model::catalog::Catalog;
use gearwise_model::requirement::{Joint, RatioChoice};
use gearwise_select::answer::{Design, JointResult, RobotResult};
use gearwise_select::outlook::Outlook;
use gearwise_select::robot::Choice;

/// The page; `outlooks` are those of the joints, in their order.
pub fn page(result: &RobotResult, outlooks: &[Outlook], whole: Option<&Choice>, catalog: &Catalog) -> Page {
    let robot = result.robot;
    let without: Vec<&str> =
        result.joints.iter().filter(|j| j.candidates.is_empty()).map(|j| j.joint.name.as_str()).collect();
    let headline = match (without.as_slice(), result.joints.as_slice()) {
        ([], [only]) => only.candidates.first().map_or_else(String::new, |d| format!("Take {}.", choice_text(d))),
        ([], joints) => {
            let motors = different_motors(result.distinct_motors());
            let unchecked =
                joints.iter().filter(|j| j.candidates.first().is_some_and(|d| !d.unchecked.is_empty())).count();
            let but = match unchecked {
                0 => String::new(),
                n => format!("; at {n} of them the first choice has limits that could not be checked"),
            };
            {
                let all = match joints.len() {
                    1 => "The joint".to_string(),
                    n => format!("Every one of {n} joints"),
                };
                format!("{all} can be built, with {motors}{but}.")
            }
        }
        _ => without_choice(result, "No").join(". ") + ".",
    };
    let headline = match whole.map(|whole| whole.combinations.first()) {
        None => headline,
        Some(None) => "No combination of motors keeps what the whole robot may have.".into(),
        Some(Some(best)) => {
            let how = if whole.is_some_and(|w| w.proof.certified()) { "proved to be the best" } else { "not proved" };
            let mass = best.mass.map_or_else(String::new, |mass| format!(", {} kg", number(mass)));
            format!(
                "{headline} The best combination for the whole robot ({how}) has {}{mass}.",
                different_motors(best.distinct_motors)
            )
        }
    };
    // The budgets are those of the combination, not of the first choices of joints.
    let mut summary = match whole {
        Some(whole) => robot_page::parts(whole),
        None => Vec::new(),
    };
    summary.push(Part::Table(choices(result, whole)));
    if whole.is_none() {
        summary.extend(budget(result).into_iter().map(Part::Text));
    }
    summary.extend(result.joints.iter().filter_map(by_ratings).map(Part::Text));
    let figure = plot::optimized(result, catalog);
    let mut sections = Vec::new();
    let mut warnings = Vec::new();
    for (k, joint) in result.joints.iter().enumerate() {
        let same = |j: &&JointResult| j.joint.asks_the_same(joint.joint);
        // Joints that ask the same share a section, as they share a group of the figure.
        if result.joints[..k].iter().any(|j| same(&j)) {
            continue;
        }
        let names: Vec<&str> = result.joints[k..].iter().filter(same).map(|j| j.joint.name.as_str()).collect();
        let names = names.join(", ");
        warnings.extend(warned(joint).into_iter().map(|line| format!("{names}: {line}")));
        sections.push(section(joint, outlooks.get(k), &names, group_of(&figure, sections.len())));
    }
    Page {
        command: "optimize",
        title: robot.name.clone(),
        verdict: Verdict::from(whole.map_or_else(|| result.satisfied(), |whole| !whole.combinations.is_empty())),
        asked: asked::of_robot(robot),
        headline,
        summary,
        sections,
        warnings,
        ..Page::default()
    }
}

/// The first choice of each joint, and the first with every limit checked where that is another.
fn choices(result: &RobotResult, whole: Option<&Choice>) -> Table {
    let header = [
        "joint",
        ">×",
        "choice",
        "motor",
        "gear",
        ">N",
        ">loss [W]",
        ">mass [kg]",
        ">J [kg*m^2]",
        "tightest",
        ">margin [%]",
        "estimated",
        ">not checked",
        "proof",
        "spring",
    ];
    let mut table = Table::new("First choices", &header);
    let best = whole.and_then(|whole| whole.combinations.first());
    for (j, joint) in result.joints.iter().enumerate() {
        let name = || vec![joint.joint.name.clone(), joint.joint.count.to_string()];
        let mut add = |what: &str, design: &Design| {
            let e = &design.evaluation;
            let mut cells = name();
            cells.extend([what.into(), design.motor.id.clone(), design.gear.unwrap_or("").into()]);
            cells.extend([design_ratio(design), number(e.loss), optional(e.mass), number(e.reflected_inertia)]);
            cells.extend(tightest(e));
            cells.extend([estimated(design.motor), design.unchecked.len().to_string()]);
            cells.push(proof(&design.optimum.certificate));
            cells.push(design.spring.as_ref().map_or_else(String::new, |s| spring::text(s, e.loss)));
            table.push(&design.motor.id, cells);
        };
        match joint.candidates.first() {
            None => {
                let mut cells = name();
                cells.extend([none_text(joint)].into_iter().chain((3..header.len()).map(|_| String::new())));
                table.push("", cells);
            }
            Some(first) => {
                add("best", first);
                if let Some(best) = best {
                    add("in the best combination", &best.joints[j]);
                }
                if let Some(checked) = joint.candidates.iter().find(|d| d.unchecked.is_empty())
                    && !first.unchecked.is_empty()
                {
                    add("best with every limit checked", checked);
                }
            }
        }
    }
    table
}

/// What stands in place of a choice.
pub(super) fn none_text(joint: &JointResult) -> String {
    match joint.unjudged.len() {
        0 => "none can do it".into(),
        count => format!("none that can be judged can do it ({count} cannot be judged)"),
    }
}

/// What the budget says, each in a sentence.
fn budget(result: &RobotResult) -> Vec<String> {
    let sentence = |line: String| {
        let mut letters = line.chars();
        let first: String = letters.next().into_iter().flat_map(char::to_uppercase).collect();
        format!("{first}{}.", letters.as_str())
    };
    budget_lines(result).into_iter().map(sentence).collect()
}

fn warned(result: &JointResult) -> Vec<String> {
    let joint = result.joint;
    let mut lines = Vec::new();
    lines.extend(joint_notes(joint, false));
    lines.extend(crate::said::gears_note(result));
    // Of many designs the places say little: the first few, and how many.
    for (note, places) in notes(result, result.candidates.len()) {
        let more = if places.len() > 4 { format!(" … ({} designs)", places.len()) } else { String::new() };
        lines.push(format!("{}{more}: {note}", places[..places.len().min(4)].join(" ")));
    }
    lines
}

fn section(result: &JointResult, outlook: Option<&Outlook>, names: &str, figure: Option<Part>) -> Section {
    let joint = result.joint;
    let mut parts = vec![Part::Text(asked_of(result))];
    parts.extend(crate::balance::sentences(result).into_iter().map(Part::Text));
    parts.extend(figure);
    parts.extend(candidates(result, names).part());
    if result.candidates.len() > 1 {
        parts.push(folded(
            "What there is to trade: loss, inertia and mass of every design",
            Part::Figure(trade::figure(result)),
        ));
    }
    parts.extend(losses(result, names));
    if let Some(first) = result.candidates.first() {
        let teeth = gear_of_ratio(joint, first.optimum.ratio).filter(|_| first.gear.is_none());
        parts.extend(teeth.map(|line| Part::Text(format!("{}: {line}.", choice_text(first)))));
        let name = format!("{names}: limits of the first choice, {}", choice_text(first));
        let limits = Table::of(name, &limit_columns()).rows(limit_rows(&first.evaluation.margins, joint));
        parts
            .extend(limits.part().map(|part| folded("Limits of the first choice (on currents: q-axis amperes)", part)));
        let rows = first.optimum.shadow_prices.iter().map(|p| vec![p.limit.to_string(), number(p.elasticity)]);
        let change = format!(">change of {} [%]", joint.goal());
        let prices = Table::new(format!("{names}: what one per cent more of a limit changes"), &["limit", &change]);
        parts.extend(prices.rows(rows).part().map(|part| folded("What wider limits would bring", part)));
    }
    parts.extend(outlook.and_then(|outlook| near_gears(result, outlook, names)));
    parts.extend(others(result, outlook, names));
    let rows = result.agreement.iter().filter_map(|a| {
        let metric = METRICS.iter().find(|m| m.name == a.metric)?;
        let tau = a.tau.map_or_else(|| "–".into(), |t| format!("{t:+.2}"));
        Some(vec![metric.symbol.to_string(), tau, a.motors.to_string(), metric.meaning.to_string()])
    });
    let agreement = Table::new(
        format!("{names}: order by metric against order by this task (Kendall's τ, 1 is the same order)"),
        &["metric", ">τ", ">motors", "meaning"],
    );
    parts.extend(agreement.rows(rows).part().map(|part| folded("Would a metric have chosen the same?", part)));
    Section::new(names, parts)
}

/// The motors of a joint that are no choice, each with why: tables that are closed at first.
pub fn others(result: &JointResult, outlook: Option<&Outlook>, names: &str) -> Vec<Part> {
    let joint = result.joint;
    let mut parts: Vec<Part> = super::unjudged::of_joint(names, result).into_iter().collect();
    let mut rejected = Table::new(
        format!("{names}: why not the others"),
        &["motor", "gear", "because", "another number of turns", "in short"],
    );
    for r in &result.rejected {
        let (class, sentence) = reason_text(&r.reason, joint);
        let turns = rewound_text(result, outlook, r);
        rejected.push(&r.motor.id, vec![r.motor.id.clone(), r.gear.unwrap_or("").into(), sentence, turns, class]);
    }
    let count = rejected.rows.len();
    parts.extend(rejected.part().map(|part| folded(&format!("Why not the others ({count})"), part)));
    if let Some(pruned) = &result.pruned {
        let reason = |bound: f64| crate::prune::reason(joint, pruned.keep, bound);
        let mut table = Table::new(format!("{names}: not solved"), &["motor", "because"]);
        for (motor, bound) in &pruned.not_solved {
            table.push(&motor.id, vec![motor.id.clone(), reason(*bound)]);
        }
        let count = table.rows.len();
        parts.extend(table.part().map(|part| folded(&format!("Not solved ({count})"), part)));
    }
    parts
}

/// Which ratios a joint may have, what it aims at, and how many motors can do it.
pub fn asked_of(result: &JointResult) -> String {
    format!("{}, {}: {}.", ratio_text(result.joint), result.joint.aim(), verdict(result))
}

fn folded(title: &str, part: Part) -> Part {
    Part::Folded(title.into(), Box::new(part))
}

/// Gears that one can buy near the best ratio of the first design.
pub(super) fn near_gears(result: &JointResult, outlook: &Outlook, names: &str) -> Option<Part> {
    let (design, nearby) = (result.candidates.first()?, outlook.nearby.as_ref()?);
    if let Some(gap) = &nearby.gap {
        return Some(Part::Text(format!("{}.", no_gear(gap))));
    }
    let name = format!("{names}: {} {}", heading(nearby), choice_text(design));
    let columns = ["gear", ">N", ">loss [W]", ">mass [kg]", "against the best", "limits"];
    let mut table = Table::new(name, &columns);
    for near in &nearby.gears {
        let [cost, mass, kept] = near_gear_cells(near, design, result.joint);
        let loss = near.evaluation.as_ref().map(|there| there.loss);
        let more: Vec<String> = [cost, mass].into_iter().filter(|text| !text.is_empty()).collect();
        let mass = near.evaluation.as_ref().and_then(|there| there.mass);
        let cells =
            vec![near.gear.id.clone(), number(near.gear.ratio), optional(loss), optional(mass), more.join(", "), kept];
        table.push(&near.gear.id, cells);
    }
    table.part().map(|part| folded("Gears of the catalogue near the best ratio", part))
}

/// Designs whose losses are drawn.
const DRAWN: usize = 8;

/// Where the loss of the first designs is; nothing where none has any.
fn losses(result: &JointResult, names: &str) -> Option<Part> {
    let first = &result.candidates[..result.candidates.len().min(DRAWN)];
    let losses: Vec<_> = first.iter().map(|design| (choice_text(design), &design.evaluation.losses)).collect();
    Bars::of_losses(format!("{names}: where the loss is, mean over the motion"), &losses).map(Part::Bars)
}

/// The designs of a joint, the best first.
pub fn candidates(result: &JointResult, names: &str) -> Table {
    let joint = result.joint;
    let geared = matches!(joint.ratio, RatioChoice::Catalog { .. });
    let sprung = joint.limits.spring.is_some();
    let goal = match joint.objective.unit() {
        "1" => format!(">{}", joint.goal()),
        unit => format!(">{} [{unit}]", joint.goal()),
    };
    let mut header = vec![">#", "motor"];
    header.extend(geared.then_some("gear"));
    header.push(if geared { ">N" } else { ">N*" });
    // A single quantity is a figure like any other.
    let own_column = joint.objective.sole().is_none();
    if own_column {
        header.push(&goal);
    }
    let currency = result.candidates.first().and_then(|design| design.evaluation.price).map(|cost| cost.currency);
    let figures = [true, false].map(|at_once| columns::of_pages(at_once, currency));
    header.extend(figures[0].iter().map(String::as_str));
    header.extend(["tightest", ">margin [%]", "estimated", ">not checked", "proof"]);
    if !geared {
        header.extend([">N from", ">N to"]);
    }
    // What an engineer looks at first; the rest where it is asked for.
    let main = header.len();
    if !geared {
        header.push("what ends the ratios");
    }
    if sprung {
        header.push("spring");
    }
    header.extend(figures[1].iter().map(String::as_str));
    let mut table = Table::new(format!("{names}: designs, the best first"), &header).mainly(main);
    for (place, design) in result.candidates.iter().enumerate() {
        let e = &design.evaluation;
        let window = design.optimum.window();
        let mut cells = vec![(place + 1).to_string(), design.motor.id.clone()];
        if geared {
            cells.push(design.gear.unwrap_or("").into());
        }
        cells.push(design_ratio(design));
        if own_column {
            cells.push(number(design.optimum.objective));
        }
        cells.extend(columns::cells_of_pages(true, &design.facts()));
        cells.extend(tightest(e));
        cells.extend([estimated(design.motor), design.unchecked.len().to_string()]);
        cells.push(proof(&design.optimum.certificate));
        if !geared {
            cells.extend([window.min, window.max].map(number));
        }
        if !geared {
            cells.push(ends(design, joint));
        }
        if sprung {
            cells.push(design.spring.as_ref().map_or_else(String::new, |s| spring::text(s, e.loss)));
        }
        cells.extend(columns::cells_of_pages(false, &design.facts()));
        table.push(&design.motor.id, cells);
    }
    table
}

/// What ends the window of ratios on both sides.
fn ends(design: &Design, joint: &Joint) -> String {
    let one =
        |w: &gearwise_select::program::Window| format!("{} … {}", bind_text(&w.low, joint), bind_text(&w.high, joint));
    design.optimum.windows.iter().map(one).collect::<Vec<_>>().join("; ")
}
