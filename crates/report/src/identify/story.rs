//! The loop from logs to a new choice in six lines, for whoever reads nothing else.
//!
//! The one idea: each line has one subject (what was measured, what the model lacks, the error, the choice, what moves it, what
//! to do), and says that it is not known where it is not.

use super::{listed, overall, round, sentence::lacks};
use crate::remake::{part_title, regret_text};
use crate::said::margin_text;
use crate::{counted, number, with_unit};
use gearwise_identify::identify::{Report, Verdict};
use gearwise_identify::{Bench, Use};
use gearwise_select::remake::{Choice, Chosen, Remade, Share};

/// The six lines: each with its subject.
pub fn story(bench: &Bench, reports: &[Report], remade: Option<&[Remade]>) -> Vec<(&'static str, String)> {
    let told = told(remade);
    vec![
        ("Measured", measured(bench)),
        ("Missing", missing(reports)),
        ("Error", error(reports)),
        ("Choice", choice(remade, told)),
        ("Moved by", moved_by(remade, told)),
        ("Next", next(reports, told)),
    ]
}

/// The joint that is told of several: the one whose best ratio moves most.
fn told<'r, 'a>(remade: Option<&'r [Remade<'a>]>) -> Option<&'r Remade<'a>> {
    let moves = |one: &Remade| match (ratio(one.before.as_ref()), ratio(Some(&one.after))) {
        (Some(before), Some(after)) => (after / before).ln().abs(),
        (None, None) => 0.0,
        // A choice that comes or goes is more than any move.
        _ => f64::INFINITY,
    };
    remade?.iter().reduce(|a, b| if moves(b) > moves(a) { b } else { a })
}

fn chosen(choice: Option<&Choice>) -> Option<&Chosen> {
    choice?.outcome.as_ref().ok()
}

fn ratio(choice: Option<&Choice>) -> Option<f64> {
    chosen(choice).map(|chosen| chosen.ratio)
}

fn measured(bench: &Bench) -> String {
    let what = match &bench.declared.motor {
        Some(motor) => format!("{} at N = {}", motor.id, number(bench.declared.ratio)),
        None => "a linear axis".into(),
    };
    let held = bench.logs.iter().filter(|log| log.usage != Use::Fit).count();
    let held = if held == 0 { "none held out".to_string() } else { format!("{held} of them held out") };
    format!("{what}, {}, {held}.", counted(bench.logs.len(), "log"))
}

fn missing(reports: &[Report]) -> String {
    if reports.is_empty() || reports.iter().all(|report| report.evidence.teaches_nothing()) {
        return "not known: nothing can be learnt from these logs.".into();
    }
    let names = lacks(reports);
    match overall(reports) {
        Verdict::Explained => format!("{}.", listed(&names)),
        Verdict::UnexplainedStructure if names.is_empty() => {
            "something that none of the known effects explains.".into()
        }
        Verdict::UnexplainedStructure => {
            format!("{}, and something that none of the known effects explains.", listed(&names))
        }
        Verdict::NothingMissing => "nothing that these logs can show.".into(),
        Verdict::NoneOfThese => {
            "none of the effects that could be asked; whether something else is, is not known.".into()
        }
        Verdict::NotResolved if names.is_empty() => {
            "not certain: no effect could be named, and not all could be excluded.".into()
        }
        Verdict::NotResolved => format!("not certain: it may be {}.", listed(&names)),
    }
}

fn error(reports: &[Report]) -> String {
    let Some(report) = reports.iter().find(|r| !r.effects.is_empty()).or(reports.first()) else {
        return "not known.".into();
    };
    let (Some(from), Some(to)) = (report.stages.first(), report.stages.last()) else { return "not known.".into() };
    let (judge, a, b) = match (from.held_out, to.held_out) {
        (Some(a), Some(b)) => ("on logs that were held out", a, b),
        _ => ("on the logs that were fitted, since none was held out", from.fit, to.fit),
    };
    let noise = match report.evidence.held_out_times_the_noise().or(report.evidence.times_the_noise()) {
        Some(times) => format!("{} times the instrument's noise is left", number(round(times))),
        None => "the instrument's noise is not known".into(),
    };
    format!("{} before, {} after, {judge}; {noise}.", with_unit(a, report.unit), with_unit(b, report.unit))
}

fn choice(remade: Option<&[Remade]>, told: Option<&Remade>) -> String {
    let (Some(all), Some(one)) = (remade, told) else {
        return "not made again: `--requirement robot.toml` makes it.".into();
    };
    let goal =
        |chosen: &Chosen| format!("{} {}", one.joint.goal(), with_unit(chosen.objective, one.joint.objective.unit()));
    let at = |chosen: &Chosen| format!("N* = {}, {}", number(chosen.ratio), goal(chosen));
    let own = match (chosen(one.before.as_ref()), chosen(Some(&one.after))) {
        (Some(before), Some(after)) => format!("{} goes from {} to {}", one.motor, at(before), at(after)),
        (Some(before), None) => format!("{} was one at {}; as measured it cannot do it", one.motor, at(before)),
        (None, Some(after)) => format!("{} could not do it by its row; as measured it can at {}", one.motor, at(after)),
        (None, None) => format!("{} cannot do it, by its row and as measured", one.motor),
    };
    let first = match (&one.first_before, &one.first_after) {
        (Some(before), Some(after)) if before.motor == after.motor => format!("{} stays the first choice", after.motor),
        (Some(before), Some(after)) => {
            format!("the first choice is now {} at N* = {}, before {}", after.motor, number(after.ratio), before.motor)
        }
        (None, Some(after)) => format!("the first choice is now {}; before there was none", after.motor),
        (_, None) => "no motor is a choice now".into(),
    };
    let others = match all.len() {
        1 => String::new(),
        n => format!(" (It is the joint that moves most; {} more below.)", n - 1),
    };
    format!("at {}, {own}; {first}.{others}", one.joint.name)
}

/// How far a share moves the ratio of a fitted motor, as the logarithm of a factor.
fn moves(share: &Share, after: &Chosen) -> f64 {
    share.without.as_ref().map_or(f64::INFINITY, |without| (after.ratio / without.ratio).ln().abs())
}

fn moved_by(remade: Option<&[Remade]>, told: Option<&Remade>) -> String {
    if remade.is_none() {
        return "not known: the choice was not made again.".into();
    }
    let Some((one, after)) = told.and_then(|one| Some((one, chosen(Some(&one.after))?))) else {
        return "nothing can be compared: as measured the motor is no choice.".into();
    };
    let most = one.shares.iter().reduce(|a, b| if moves(b, after) > moves(a, after) { b } else { a });
    let Some(share) = most else { return "nothing: no part of what was fitted enters the choice.".into() };
    let name = part_title(&share.part);
    match &share.without {
        Err(_) => format!("{name}: without it the motor would be no choice."),
        Ok(without) => {
            let margin = match (without.tightest(), after.tightest()) {
                (Some(a), Some(b)) => {
                    format!("; smallest margin {} without it, {} with it", margin_text(a), margin_text(b))
                }
                _ => String::new(),
            };
            format!(
                "most by {name}: N* = {} without it, {} with it; loss {} W and {} W{margin}.",
                number(without.ratio),
                number(after.ratio),
                number(without.loss),
                number(after.loss)
            )
        }
    }
}

fn next(reports: &[Report], told: Option<&Remade>) -> String {
    let mut all = Vec::new();
    if let Some(Remade { output_side: Some(output), after, .. }) = told
        && let (Some(output), Some(motor)) = (ratio(Some(output)), ratio(Some(after)))
    {
        all.push(format!(
            "one ratio cannot separate friction of the motor (N* = {}) from friction at the output (N* = {})",
            number(motor),
            number(output)
        ));
    } else if let Some((one, regret)) = told.and_then(|one| Some((one, one.own_regret.as_ref()?))) {
        all.push(format!("what was chosen by the row comes to {}", regret_text(regret, one.joint)));
    }
    all.extend(reports.iter().flat_map(|report| &report.next_runs).next().cloned());
    if all.is_empty() {
        return "no run is known that would show more.".into();
    }
    format!("{}.", all.join("; "))
}
