//! The answer first: what to take at each joint, on one screen.

use super::balance;
use super::said::{Shown, bind_text, choice_text, gears_note, joint_notes, margin_at, per_cent, with_gear};
use super::table::{Column, Table, paragraph};
use super::tint::Tint;
use super::{design_ratio, estimated, number, number_between, optional, turns};
use gearwise_model::actuator::limits::ELECTRICAL;
use gearwise_model::requirement::{Balancing, Joint, Quantity};
use gearwise_select::answer::{Design, JointResult, RobotResult, Unjudged};
use gearwise_select::flatness::OwnBound;
use gearwise_select::outlook::Outlook;
use gearwise_select::program::{Bind, Certificate};

/// The first choice of every joint; where the objective is balanced, between the lightest design and the least loss.
pub(super) fn text(result: &RobotResult, outlooks: &[Outlook]) -> String {
    // Which of three designs a row is has to be said; that it is the least of what was asked for is known.
    let has_three = result.joints.iter().any(|of| matches!(of.joint.balancing, Balancing::Made(_)));
    let choice = Column::name("choice");
    let mut columns = vec![
        Column::name("joint"),
        Column::number("×", "").dropped(1),
        if has_three { choice } else { choice.dropped(2) },
        Column::name("motor"),
        Column::number("N", ""),
    ];
    // What is minimised has a column of its own where it is neither of the two that everybody asks for.
    let goals = result.joints.iter().map(|of| of.joint.goal());
    let other = goals.into_iter().find(|goal| !matches!(goal.as_str(), "balanced" | "loss" | "mass"));
    if other.is_some() {
        columns.push(Column::number("objective", "").dropped(4));
    }
    columns.push(Column::number("mass", "kg"));
    columns.push(Column::number("loss", "W"));
    let mut table = Table::new(columns).indented(2).also_in("`--json`");
    let mut notes: Vec<String> = Vec::new();
    for (place, of) in result.joints.iter().enumerate() {
        let outlook = outlooks.get(place);
        let mut title = [of.joint.name.clone(), of.joint.count.to_string()];
        for (name, row, details) in rows(of, outlook) {
            let [motor, ratio, objective, loss, mass] = row;
            let objective = other.is_some().then_some(objective);
            let cells = title.into_iter().chain([name, motor, ratio]).chain(objective).chain([mass, loss]);
            table.push(cells.collect(), details);
            // The name of a joint stands once.
            title = [String::new(), String::new()];
        }
        let note = match &of.joint.balancing {
            Balancing::Made(_) => {
                "Balanced: the least loss/L₀ + mass/M₀, between the lightest design and the least loss.".to_string()
            }
            Balancing::Cannot(why) => balance::cannot(why),
            Balancing::No | Balancing::Asked => continue,
        };
        if !notes.contains(&note) {
            notes.push(note);
        }
    }
    let mut unjudged = Vec::new();
    for of in result.joints.iter().filter(|of| !of.unjudged.is_empty() && !of.candidates.is_empty()) {
        let count = gearwise_model::words::counted(of.unjudged.len(), "motor");
        unjudged.push(format!("{count} at {}", of.joint.name));
    }
    if !unjudged.is_empty() {
        let line = format!("Cannot be judged, and no choice: {} (`--rejected` says why).", unjudged.join(", "));
        notes.push(Tint::Doubtful.on(&line));
    }
    for of in &result.joints {
        notes.extend(by_ratings(of).map(|line| Tint::Doubtful.on(&line)));
    }
    notes.extend(turns::summaries(result, outlooks));
    // What is true of several joints is said once.
    let mut told: Vec<(String, Vec<&str>)> = Vec::new();
    for of in &result.joints {
        let unlimited = balance::is_unlimited(of.joint).then(|| balance::NO_LIMIT.to_string());
        for note in joint_notes(of.joint, true).into_iter().chain(gears_note(of)).chain(unlimited) {
            match told.iter_mut().find(|(other, _)| *other == note) {
                Some((_, joints)) => joints.push(&of.joint.name),
                None => told.push((note, vec![&of.joint.name])),
            }
        }
    }
    notes.extend(told.into_iter().map(|(note, joints)| match joints.len() == result.joints.len() {
        true => note,
        false => format!("{}: {note}", joints.join(", ")),
    }));
    let mut out = table.text();
    if result.robot.is_coupled() {
        out.push_str(&paragraph("Each joint by itself, and carrying nothing.", 2, 4));
    }
    notes.iter().for_each(|note| out.push_str(&paragraph(note, 2, 4)));
    out
}

/// What choice it is; motor, N, objective, loss, mass; what is said of it.
type Row = (String, [String; 5], Vec<String>);

/// Rows of a joint.
fn rows(of: &JointResult, outlook: Option<&Outlook>) -> Vec<Row> {
    let first = of.candidates.first().map(|design| {
        let e = &design.evaluation;
        let mut details = vec![said(design, of.joint)];
        details.extend(super::said::gear_of_ratio(of.joint, design.optimum.ratio).filter(|_| design.gear.is_none()));
        details.extend(outlook.and_then(|o| o.own_bound.as_ref()).map(|bound| own_bound(bound, of.joint)));
        let objective = number(design.optimum.objective);
        let cells = [design.motor.id.clone(), design_ratio(design), objective, number(e.loss), optional(e.mass)];
        (goal_words(of.joint), cells, details)
    });
    let none = || {
        let cells = [Tint::Exceeded.on("none"), "–".into(), "–".into(), "–".into(), "–".into()];
        (goal_words(of.joint), cells, Vec::new())
    };
    let first = first.unwrap_or_else(none);
    let Balancing::Made(balance) = &of.joint.balancing else { return vec![first] };
    let all = balance::rows(of, balance);
    let end = |name: &str| {
        let (cells, gear) = all.iter().find(|(cells, _)| cells[0] == name)?;
        let cells = [cells[1].clone(), cells[2].clone(), "–".into(), cells[3].clone(), cells[4].clone()];
        Some((name.to_string(), cells, gear.iter().cloned().collect()))
    };
    // The same design is one row.
    let (lightest, least) = (end("lightest"), end("least loss"));
    let is_same = |end: &Row| end.1[..2] == first.1[..2] && end.1[3..] == first.1[3..];
    let too = match (lightest.as_ref().is_some_and(is_same), least.as_ref().is_some_and(is_same)) {
        (false, false) => None,
        (true, false) => Some("it is the lightest, too"),
        (false, true) => Some("it is that with the least loss, too"),
        (true, true) => Some("it is the lightest and that with the least loss, too"),
    };
    let lightest = lightest.filter(|end| !is_same(end));
    let least = least.filter(|end| !is_same(end));
    let (name, cells, mut details) = first;
    details.extend(too.map(str::to_string));
    let first = (name, cells, details);
    [lightest, Some(first), least].into_iter().flatten().collect()
}

/// What choice the first design is.
fn goal_words(joint: &Joint) -> String {
    match joint.balancing {
        Balancing::Made(_) => "balanced".into(),
        _ => joint.aim().replace('_', " "),
    }
}

/// What binds, the smallest margin, and what is not known or not measured.
fn said(design: &Design, joint: &Joint) -> String {
    let margin = design.evaluation.tightest();
    let margin = margin.map_or_else(
        || Tint::Doubtful.on("nothing could be checked"),
        |m| format!("smallest margin {}", Tint::of(m).on(&margin_at(m, joint))),
    );
    let gear = with_gear(design);
    let spring = design.spring.and_then(|s| s.rest_angle.map(|_| format!("spring {} N*m/rad", number(s.stiffness))));
    let unchecked = match design.unchecked.len() {
        0 => None,
        _ => {
            let names: Vec<String> = design.unchecked.iter().map(|(name, _)| name.replace('_', " ")).collect();
            Some(Tint::Doubtful.on(&format!("not checked: {}", names.join(", "))))
        }
    };
    let assumed = (!design.assumed.is_empty()).then(|| Tint::Doubtful.on(&format!("{} assumed", design.assumed.len())));
    let is_certified = matches!(design.optimum.certificate, Certificate::Certified { .. });
    let proof = (!is_certified).then(|| Tint::Doubtful.on("not certified"));
    // What binds is mostly what has the smallest margin: said once.
    let is_same = binding(design).zip(design.evaluation.tightest()).is_some_and(|(bind, m)| bind.limit == m.limit);
    let (bind, margin) = match is_same && joint.ratio.listed().is_none() {
        true => (None, format!("{margin}, it binds")),
        false => (Some(binds(design, joint)), margin),
    };
    let parts = [gear, bind, Some(margin), spring, unchecked, assumed, proof];
    let parts: Vec<String> = parts.into_iter().flatten().filter(|part| !part.is_empty()).collect();
    parts.join("; ") + &Tint::Doubtful.on(&estimated::text(design.motor))
}

/// What forbids the ratios right beside the best one; of two ends a limit before the end of the requirement's range.
fn binding<'d>(design: &'d Design) -> Option<&'d Bind> {
    let (ratio, window) = (design.optimum.ratio, design.optimum.window());
    let stands_at = |end: f64| (ratio - end).abs() <= 1e-9 * ratio;
    let ends = [(window.max, &window.high), (window.min, &window.low)];
    let here = || ends.iter().filter(|(end, _)| stands_at(*end) && design.gear.is_none()).map(|(_, bind)| *bind);
    here().find(|bind| !is_of_range(bind.limit)).or_else(|| here().next())
}

/// Whether a limit is an end of the requirement's range of ratios.
pub(super) fn is_of_range(limit: &str) -> bool {
    matches!(limit, "ratio_min" | "ratio_max")
}

/// What a module that its ratings let do the task may lack, so that it cannot be ranked.
const OF_RANKING: [&str; 4] = ["module_constants", "module_gear_loss", "module_back_emf", "motor_drag"];
/// Modules that are named.
const NAMED: usize = 4;

/// Modules that can do a joint by all that their rows rate, and cannot be ranked: by mass, each with its smallest margin.
pub(super) fn by_ratings(of: &JointResult) -> Option<String> {
    let is_undecided = |u: &Unjudged| {
        let unchecked = u.design.as_ref().map_or(&[][..], |design| &design.unchecked);
        unchecked.iter().any(|(name, _)| *name == "module_curve")
    };
    let can = |u: &&Unjudged| u.because.iter().all(|(name, _)| OF_RANKING.contains(name)) && !is_undecided(u);
    // Of a robot's power each joint's counts, whatever its own objective is.
    let of_aim = |q: &Quantity| of.joint.objective.weight(*q) > 0.0;
    let unknown = match ELECTRICAL.iter().any(of_aim) {
        true => of.joint.objective.name(),
        false => "power".into(),
    };
    let modules = of.unjudged.iter().filter(|u| u.motor.inside.is_some()).filter(can);
    let mut found: Vec<(f64, String)> = modules
        .filter_map(|u| {
            let evaluation = &u.design.as_ref()?.evaluation;
            let mass = evaluation.mass.unwrap_or(f64::INFINITY);
            let weighs = evaluation.mass.map_or_else(|| "mass not known".into(), |kg| format!("{} kg", number(kg)));
            let margin = evaluation.tightest().map_or_else(String::new, |m| format!(", {}", margin_at(m, of.joint)));
            Some((mass, format!("{} ({weighs}{margin})", u.motor.id)))
        })
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let count = found.len();
    let shown: Vec<String> = found.into_iter().take(NAMED).map(|(_, text)| text).collect();
    let more = if count > NAMED { format!(" and {} more", count - NAMED) } else { String::new() };
    (count > 0).then(|| {
        format!(
            "{}: by their ratings {} can do it, and their {} is not known: {}{more}.",
            of.joint.name,
            gearwise_model::words::counted(count, "module"),
            unknown,
            shown.join(", ")
        )
    })
}

/// What keeps the ratio where it is.
pub(super) fn binds(design: &Design, joint: &Joint) -> String {
    match design.gear {
        Some(_) if design.motor.inside.is_some() => "its ratio is its own".into(),
        Some(_) => "the best of the gears".into(),
        None => bound_by(binding(design), joint),
    }
}

/// What keeps a ratio that is free or of a list.
fn bound_by(bind: Option<&Bind>, joint: &Joint) -> String {
    match (bind, joint.ratio.listed()) {
        (None, _) => "no limit binds".into(),
        (Some(bind), Some(_)) if is_of_range(bind.limit) => "no limit binds".into(),
        (Some(bind), None) if is_of_range(bind.limit) => "at the end of the range of ratios".into(),
        (Some(bind), Some(_)) if bind.unjudged.is_some() => {
            format!("with the next allowed ratio {} cannot be judged", bind.limit)
        }
        (Some(bind), Some(_)) => format!("the next allowed ratio exceeds {}", bind_text(bind, joint)),
        (Some(bind), None) if bind.unjudged.is_some() => format!("beyond this ratio {} cannot be judged", bind.limit),
        (Some(bind), None) => format!("{} binds", bind_text(bind, joint)),
    }
}

/// That the requirement's own range of ratios decided, and what it costs.
pub(super) fn own_bound(bound: &OwnBound, joint: &Joint) -> String {
    let range = if joint.ratio.is_list() { "list of ratios" } else { "bound on the ratio" };
    let (low, high) = if bound.is_largest { (bound.ratio, bound.beyond) } else { (bound.beyond, bound.ratio) };
    format!(
        "your own {range} decides: N = {}; N = {} would save {} ({})",
        number(bound.ratio),
        number_between(bound.beyond, low, high),
        per_cent(bound.saves),
        joint.goal(),
    )
}

/// The best design with every limit checked, where the first has not.
pub(super) fn checked(of: &JointResult) -> Option<String> {
    let first = of.candidates.first().filter(|first| !first.unchecked.is_empty())?;
    let checked = of.candidates.iter().find(|design| design.unchecked.is_empty());
    let line = match checked {
        Some(checked) if checked.motor.id != first.motor.id => choice_text(checked),
        _ => return None,
    };
    Some(format!("best with every limit checked: {line}"))
}

/// Which options say more.
pub(super) fn further(shown: Shown) -> &'static str {
    match (shown.why, shown.rejected) {
        (false, false) => {
            "More: `--why` what binds, what is near and how sure it is; `--rejected` why not the others; `--full` all tables."
        }
        (true, false) => "More: `--rejected` why not the others; `--full` all tables.",
        (false, true) => "More: `--why` what binds, what is near and how sure it is; `--full` all tables.",
        (true, true) => "More: `--full` all tables.",
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Bind, bound_by};
    use gearwise_model::input::Source;
    use gearwise_model::requirement::read_source;

    /// A limit that cannot be judged beyond a ratio is not said to be exceeded there, and the other way round.
    #[test]
    fn what_cannot_be_judged_is_not_exceeded() {
        let told = |ratio: &str, unjudged| {
            let points = "points = [{ torque = '1 N*m', speed = '1 rad/s' }]";
            let text =
                format!("name = 'r'\nbus = {{ voltage = '1 V' }}\n[[joint]]\nname = 'j'\nratio = {ratio}\n{points}");
            let robot = read_source(&Arc::new(Source::new("robot.toml", text))).unwrap();
            bound_by(Some(&Bind { unjudged, ..Bind::of("winding_temperature", None) }), &robot.joints[0])
        };
        for ratio in ["{ min = 1, max = 9 }", "{ min = 1, max = 9, step = 2 }", "{ values = [3, 5] }"] {
            let (open, known) = (told(ratio, Some("why")), told(ratio, None));
            assert!(
                open.contains("cannot be judged") && !open.contains("exceeds") && !open.contains("binds"),
                "{open}"
            );
            assert!(!known.contains("judged") && (known.contains("exceeds") || known.contains("binds")), "{known}");
        }
    }
}
