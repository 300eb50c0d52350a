//! The verdict over all equations of a bench, in a sentence that anyone understands.

use super::{channel_name, listed, overall, percent, refused, round, strength};
use crate::{number, plan};
use gearwise_identify::answer::Base;
use gearwise_identify::identify::evidence::AT_THE_NOISE;
use gearwise_identify::identify::{Ground, Report, Stage, Verdict};
use gearwise_identify::{Bench, Use};
use gearwise_model::effects;

/// Between which multiples of what is declared a number may lie; beyond them it is a column that is wrong.
const WILD: std::ops::Range<f64> = 0.2..5.0;
/// Numbers of which that holds.
const OF_ROW: [Base; 3] = [Base::TorqueConstant, Base::BackEmf, Base::Resistance];
/// The range of an inertia, which has all that hangs at the shaft.
const WILD_INERTIA: std::ops::Range<f64> = 0.2..20.0;

/// The verdict in a sentence that anyone understands, and what the bench does not show.
pub fn sentence(bench: &Bench, reports: &[Report]) -> String {
    said(bench, reports, unseen)
}

/// The verdict in a sentence, without what the bench does not show.
pub fn short(bench: &Bench, reports: &[Report]) -> String {
    said(bench, reports, |_| String::new())
}

/// Whether anything can be learnt from logs: channels move, agree with each other and have to do with the model.
pub fn is_learnt(reports: &[Report]) -> bool {
    let says_nothing =
        |report: &Report| report.evidence.dead.is_some() || report.evidence.contradicted || report.evidence.unrelated;
    !reports.is_empty() && !reports.iter().any(says_nothing)
}

fn said(bench: &Bench, reports: &[Report], unseen: impl Fn(&[Report]) -> String) -> String {
    let Some(first) = reports.first() else { return "Nothing can be learnt from these logs.".into() };
    if let Some(channel) = reports.iter().find_map(|r| r.evidence.dead) {
        return format!("Nothing can be learnt: the {} has one value throughout.", channel_name(channel));
    }
    if reports.iter().any(|r| r.evidence.contradicted) {
        let said = reports.iter().flat_map(|r| &r.findings).find(|f| f.about.contradicts());
        let said =
            said.map_or_else(String::new, |f| format!(" in {}: {}", f.log, super::finding_words(bench, &f.about)));
        return format!("Nothing can be learnt: channels contradict each other{said}.");
    }
    let nothing = |report: &&Report| report.evidence.unrelated;
    if let Some((report, channel)) = reports.iter().find(nothing).and_then(|r| Some((r, r.target.channel()?))) {
        if report.evidence.still {
            return format!(
                "Nothing can be learnt: what the {} does is no more than the instrument's own noise; speed or load must change.",
                channel_name(channel)
            );
        }
        let accounted = report.stages.last().and_then(|last| Stage::vaf(last.fit_vaf)).unwrap_or(0.0);
        return format!(
            "Nothing can be learnt: the {} does not follow the model, which accounts for {} % of its variance; check its \
             column, sign and time.",
            channel_name(channel),
            number(round(accounted.max(0.0)))
        );
    }
    let mut parts = Vec::new();
    let names = lacks(reports);
    let shifted: Vec<String> = reports
        .iter()
        .flat_map(|r| &r.parameters)
        .filter_map(|p| {
            let change = p.shift()?;
            let more = if change > 0.0 { "larger" } else { "smaller" };
            let times = 1.0 + change;
            let name = effects::in_words(&p.name);
            let is_of_row = OF_ROW.iter().any(|base| base.name() == p.name);
            let remedy = match p.name == Base::Inertia.name() {
                true if !WILD_INERTIA.contains(&times) => "check the columns' units and what hangs at the shaft",
                false if is_of_row && !WILD.contains(&times) => {
                    "no row is off by so much: check unit, side and scale of the columns"
                }
                _ => return Some(format!("{name} {} % {more}", number((1e3 * change.abs()).round() / 10.0))),
            };
            Some(format!("{name} {} times the declared one ({remedy})", plan::round(times)))
        })
        .collect();
    let errors = |report: &Report| -> Option<String> {
        let (from, to) = (report.stages.first()?, report.stages.last()?);
        let (judge, a, b) = match (from.held_out, to.held_out) {
            (Some(a), Some(b)) => ("on what was held out", a, b),
            _ => ("on the logs for fitting", from.fit, to.fit),
        };
        let judge = match report.evidence.far_off {
            Some(_) => format!("{judge}, where rows far off weigh less,"),
            None => judge.to_string(),
        };
        Some(format!("{judge} the error goes from {} to {} {}", number(a), number(b), report.unit))
    };
    let verdict = overall(reports);
    let off = format!("the declared numbers are off: the logs want {}", listed(&shifted));
    match verdict {
        Verdict::NothingMissing | Verdict::NoneOfThese => {
            let none = match verdict {
                Verdict::NothingMissing => "Nothing is missing that these logs can show".to_string(),
                _ => match asked(reports) {
                    1 => "The one effect that could be asked is not missing".into(),
                    count => format!("None of the {count} effects that could be asked is missing"),
                },
            };
            parts.push(if shifted.is_empty() { none } else { format!("{none}, but {off}") });
            let most = reports.iter().filter_map(|r| r.evidence.most()).fold(0.0, f64::max);
            parts.push(format!("alone or together they would lower the error by at most {} % (95 %)", percent(most)));
        }
        Verdict::NotResolved => {
            let strongest = reports.iter().filter_map(|r| Some((r, r.evidence.strongest()?)));
            let strongest = strongest.max_by(|a, b| a.1.gain.most().total_cmp(&b.1.gain.most()));
            if let Some(times) =
                reports.iter().filter(|r| r.evidence.is_below_the_noise()).find_map(|r| r.evidence.times_the_noise())
            {
                parts.push(format!(
                    "Less is left than the instrument's own noise ({} times): something explains noise, and no name is certain",
                    number(round(times))
                ));
            }
            if !names.is_empty() {
                go_on(&mut parts, &format!("The declared model seems to lack {}", listed(&names)));
            }
            for report in reports {
                if let Some(better) = report.evidence.better {
                    parts.push(format!(
                        "a model with effects whose values are not believed leaves {} instead of {} {}",
                        number(better),
                        number(report.evidence.left),
                        report.unit
                    ));
                }
            }
            if reports.iter().any(|r| r.evidence.owned) {
                go_on(&mut parts, "What owned the error was left out, and is not explained");
            }
            go_on(&mut parts, "No effect could be named with certainty, and not all could be excluded");
            parts.push(match strongest {
                Some((report, asked)) => {
                    format!("the strongest of what was refused: {}", effects::in_words(&strength(report, asked)))
                }
                None => "how much those that were refused could still explain was not bounded".into(),
            });
            if !shifted.is_empty() {
                parts.push(off);
            }
        }
        Verdict::Explained => parts.push(format!("The declared model lacks {}", listed(&names))),
        Verdict::UnexplainedStructure => {
            let mut on: Vec<String> = Vec::new();
            for left in reports.iter().flat_map(|r| &r.unexplained) {
                let name = left.depends_on.name().to_string();
                if !on.contains(&name) {
                    on.push(name);
                }
            }
            let lacks = if names.is_empty() {
                String::new()
            } else {
                format!("The declared model lacks {}, and ", listed(&names))
            };
            let start = if lacks.is_empty() { "Something" } else { "something" };
            parts.push(format!(
                "{lacks}{start} is left that none of the known effects explains: it depends on {}",
                listed(&on)
            ));
        }
    }
    if matches!(verdict, Verdict::Explained | Verdict::UnexplainedStructure) && !shifted.is_empty() {
        parts.push(format!("the logs want {}", listed(&shifted)));
    }
    let of_verdict = || reports.iter().find(|r| r.verdict == verdict);
    let told = reports.iter().find(|r| !r.effects.is_empty()).or_else(of_verdict).unwrap_or(first);
    parts.extend(errors(told));
    parts.push(left(told, verdict));
    let missing = bench.logs.iter().all(|l| l.usage == Use::Fit);
    let note = if missing { " No log was held out, so parts of the same logs judged." } else { "" };
    format!("{}.{}{note}", parts.join("; "), unseen(reports))
}

/// The effects that the model lacks, each once, with those that look the same.
pub(super) fn lacks(reports: &[Report]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for effect in reports.iter().flat_map(|r| &r.effects) {
        let name = effect.effect.title();
        let alike: Vec<String> = effect.confounded_with.iter().map(|e| e.title()).collect();
        let text = if alike.is_empty() {
            name
        } else {
            format!("{name} (or {}, which looks the same here)", alike.join(" or "))
        };
        if !names.contains(&text) {
            names.push(text);
        }
    }
    names
}

/// A part that begins the sentence, or goes on with it.
fn go_on(parts: &mut Vec<String>, text: &str) {
    let (first, rest) = text.split_at(1);
    parts.push(if parts.is_empty() { text.to_string() } else { first.to_lowercase() + rest });
}

/// How many effects were asked and refused.
fn asked(reports: &[Report]) -> usize {
    reports.iter().map(|r| r.evidence.asked.len()).sum()
}

/// What is left, in times of the instrument's noise.
fn left(report: &Report, verdict: Verdict) -> String {
    match report.evidence.times_the_noise() {
        Some(times) => {
            let held = report.evidence.held_out_times_the_noise();
            let also =
                held.map_or_else(String::new, |h| format!(", {} times it of what was held out", number(round(h))));
            let left =
                format!("of the logs for fitting {} times the instrument's noise is left{also}", number(round(times)));
            match verdict {
                Verdict::NoneOfThese if times > AT_THE_NOISE || held.is_some() => {
                    format!("{left}: unrepeatable, or not on the list")
                }
                _ => left,
            }
        }
        None if matches!(verdict, Verdict::NoneOfThese | Verdict::NotResolved) => {
            "it is not known whether more than the instrument's noise is left".into()
        }
        None => "the instrument's noise is not known".into(),
    }
}

/// Effects that the response would explain by itself, and what would show them: sentences of their own.
fn unseen(reports: &[Report]) -> String {
    let mut ways: Vec<(&str, Vec<String>)> = Vec::new();
    for (refusal, _) in refused(reports) {
        let Ground::Response(by) = refusal.ground else { continue };
        match ways.iter_mut().find(|(way, _)| *way == by) {
            Some((_, names)) => names.push(effects::in_words(&refusal.name)),
            None => ways.push((by, vec![effects::in_words(&refusal.name)])),
        }
    }
    let one = |(by, names): &(&str, Vec<String>)| {
        let (are, their, them) = if names.len() == 1 { ("is", "its", "it") } else { ("are", "their", "them") };
        format!(
            " On this bench {} {are} not identifiable: {their} regressor is made of the response; {by} would show {them}.",
            listed(names)
        )
    };
    let left_out: Vec<String> = refused(reports)
        .into_iter()
        .filter(|(refusal, _)| refusal.ground == Ground::LeftOut)
        .map(|(refusal, _)| effects::in_words(&refusal.name))
        .collect();
    let not_asked = match left_out.as_slice() {
        [] => String::new(),
        all => format!(" Not asked for, as the bench file says: {}.", listed(all)),
    };
    format!("{}{not_asked}", ways.iter().map(one).collect::<String>())
}
