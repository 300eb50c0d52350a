//! Rules files: bounds and severities of rules moved, rules of one's own, and exceptions, each with its reason.

use std::ops::Range as Span;
use std::path::Path;
use std::sync::Arc;

use super::measure::{Measure, measure, measures};
use super::registry::{every_rule, rule};
use super::rule::{Rule, Severity, Test};
use gearwise_model::catalog::matches_pattern;
use gearwise_model::input::kind::{self, FileKind};
use gearwise_model::input::{Description, Form, InputError, Key, Problem, Range, Section, Source, key};

/// A rules file.
#[derive(Debug, Clone, Default)]
pub struct RulesFile {
    /// The file; `None` where the default rules stand alone.
    pub source: Option<Arc<Source>>,
    /// Rules that were moved, in the order of the file: a later one wins.
    pub tunings: Vec<Tuning>,
    /// Rules of one's own.
    pub own: Vec<OwnRule>,
    /// Exceptions.
    pub allows: Vec<Allow>,
}

/// Which joints are meant.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Selection {
    /// Patterns of names, each with its place; empty for all.
    pub patterns: Vec<(String, Span<usize>)>,
}

impl Selection {
    /// Whether a joint is meant.
    pub fn has(&self, joint: &str) -> bool {
        self.patterns.is_empty() || self.patterns.iter().any(|(pattern, _)| matches_pattern(pattern, joint))
    }

    /// Whether it is restricted to some joints.
    pub fn is_some(&self) -> bool {
        !self.patterns.is_empty()
    }

    /// Whether it is of a joint, or, without one, of what is no joint's.
    pub fn is_of(&self, joint: Option<&str>) -> bool {
        joint.map_or(!self.is_some(), |name| self.has(name))
    }
}

/// Another bound or severity for a rule.
#[derive(Debug, Clone)]
pub struct Tuning {
    /// The rule.
    pub rule: &'static Rule,
    /// Least value, in place of the rule's.
    pub min: Option<f64>,
    /// Largest value, in place of the rule's.
    pub max: Option<f64>,
    /// Severity, in place of the rule's.
    pub severity: Option<Severity>,
    /// At which joints.
    pub joints: Selection,
    /// Why.
    pub reason: String,
    /// Where it stands.
    pub span: Span<usize>,
}

/// A rule of one's own.
#[derive(Debug, Clone)]
pub struct OwnRule {
    /// Its name, also its code.
    pub name: String,
    /// What it measures.
    pub measure: &'static Measure,
    /// Least value, SI.
    pub min: Option<f64>,
    /// Largest value, SI.
    pub max: Option<f64>,
    /// How much it weighs.
    pub severity: Severity,
    /// At which joints.
    pub joints: Selection,
    /// Why.
    pub reason: String,
    /// Where it stands.
    pub span: Span<usize>,
}

/// An exception.
#[derive(Debug, Clone)]
pub struct Allow {
    /// Code of the rule (name of one's own).
    pub code: String,
    /// Name of the rule.
    pub name: String,
    /// At which joints.
    pub joints: Selection,
    /// Only this subject (a limit, a measure, a finding's code), where one is named.
    pub subject: Option<String>,
    /// Why it is all right.
    pub reason: String,
    /// Where it stands.
    pub span: Span<usize>,
}

impl Allow {
    /// Whether it is of what a rule finds at a joint, or at none.
    pub(super) fn is_of(&self, code: &str, joint: Option<&str>, subject: &str) -> bool {
        self.code == code && self.joints.is_of(joint) && self.subject.as_ref().is_none_or(|own| own == subject)
    }
}

impl RulesFile {
    fn tunings(&self, rule: &Rule, joint: Option<&str>) -> impl Iterator<Item = &Tuning> {
        self.tunings.iter().filter(move |t| t.rule.code == rule.code && t.joints.is_of(joint))
    }

    /// Severity of a rule at a joint, or at none, and why it is another than the rule's own.
    pub(super) fn severity(&self, rule: &Rule, joint: Option<&str>) -> (Severity, Option<&str>) {
        self.tunings(rule, joint)
            .fold((rule.severity, None), |(own, _), t| (t.severity.unwrap_or(own), Some(t.reason.as_str())))
    }

    /// The bounds of a rule at a joint, in place of its own.
    pub(super) fn bounds(&self, rule: &Rule, joint: &str, own: [Option<f64>; 2]) -> [Option<f64>; 2] {
        self.tunings(rule, Some(joint)).fold(own, |[min, max], t| [t.min.or(min), t.max.or(max)])
    }
}

/// Reads a rules file; `-` is standard input.
///
/// # Errors
/// Every mistake in it.
pub fn read(path: &Path) -> Result<RulesFile, InputError> {
    read_source(&Source::argument(path)?)
}

/// Reads rules from a source.
///
/// # Errors
/// As [`read`].
pub fn read_source(source: &Arc<Source>) -> Result<RulesFile, InputError> {
    Form::read(source, read_root).map_err(|error| kind::instead(error, &[FileKind::Rules]))
}

fn read_root(root: &Section) -> Option<RulesFile> {
    let mut file = RulesFile { source: Some(root.source().clone()), ..RulesFile::default() };
    for section in root.sections(key("rule", "rules that are moved, and rules of your own")) {
        match (section.has(RULE), section.has(MEASURE)) {
            (true, false) => file.tunings.extend(read_tuning(&section)),
            (false, true) => {
                let own = read_own(&section);
                if let Some(own) = &own
                    && file.own.iter().any(|o| o.name == own.name)
                {
                    let message = format!("two rules are called `{}`", own.name);
                    section.note(Problem::at(section.span_of("name"), message, "second time"));
                }
                file.own.extend(own);
            }
            (true, true) => section.note(Problem::at(
                section.span_of("measure"),
                "a [[rule]] has `rule` (one of gearwise, moved) or `measure` (one of your own), not both",
                "remove one of the two",
            )),
            (false, false) => {
                section.missing("rule", "\"voltage-headroom\", or measure = \"loss\" for a rule of your own");
                // The other keys are not the mistake.
                for key in ["name", "min", "max", "severity", "joints", "reason"] {
                    section.has(key);
                }
            }
        }
        section.finish();
    }
    for section in root.sections(key("allow", "findings that are all right")) {
        file.allows.extend(read_allow(&section, &file.own));
        section.finish();
    }
    Some(file)
}

const RULE: Key = key("rule", "a rule of the [list](rules.md) to be moved").value("code or name").or("measure");
const MEASURE: Key =
    key("measure", "what a rule of your own bounds; see [measures](rules.md#measures)").value("name").or("rule");
const JOINTS: Key = key("joints", "at which joints").value("list of patterns").default("all");
const SEVERITY: Key = key("severity", "how much it weighs");
const MIN: Key = key("min", "least value").value("number or quantity");
const MAX: Key = key("max", "largest value").value("number or quantity");

/// What the reader asks for.
pub fn describe() -> Description {
    let skeleton = "[[rule]]\nname = 'a'\nmeasure = 'loss'\njoints = []\n[[rule]]\nrule = 'voltage-headroom'\n[[allow]]\njoints = []\n";
    Form::describe(skeleton, read_root)
}

fn reason(section: &Section) -> Option<String> {
    section
        .required_text(key("reason", "why, for whoever reads it next"), "\"why, for whoever reads it next\"")
        .map(|r| r.into_inner())
}

fn joints(section: &Section) -> Selection {
    if !section.has(JOINTS) {
        return Selection::default();
    }
    let texts = section.texts(JOINTS).unwrap_or_default();
    Selection { patterns: texts.into_iter().map(|t| (t.get_ref().clone(), t.span())).collect() }
}

/// Names of gearwise's rules, of one's own, and codes.
fn known<'a>(own: &'a [OwnRule]) -> Vec<&'a str> {
    let mut names: Vec<&'a str> = own.iter().map(|o| o.name.as_str()).collect();
    names.extend(every_rule().map(|r| r.name));
    names.extend(every_rule().map(|r| r.code));
    names
}

fn read_tuning(section: &Section) -> Option<Tuning> {
    let name = section.required_text("rule", "\"voltage-headroom\"");
    let found = name.as_ref().and_then(|name| {
        let found = rule(name.get_ref());
        if found.is_none() {
            let message = format!("there is no rule `{}`", name.get_ref());
            section.note(
                Problem::at(name.span(), message, "not a name or code of a rule").suggest(name.get_ref(), known(&[])),
            );
        }
        found
    });
    let severity = section.choice(SEVERITY, Severity::NAMES);
    let (joints, reason) = (joints(section), reason(section));
    // A rule that nobody knows has bounds that nobody can judge.
    let Some(rule) = found else {
        section.has("min");
        section.has("max");
        return None;
    };
    let (mut min, mut max) = (None, None);
    if let Test::Bounds { measures, min: least, max: most } = &rule.test {
        let measure = measure(measures[0])?;
        (min, max) = bounds(section, measure)?;
        for (key, given, has) in [("min", min, least), ("max", max, most)] {
            if given.is_some() && has.is_none() {
                let message = format!("the rule {} has no `{key}`", rule.name);
                let other = if key == "min" { "max" } else { "min" };
                section.note(
                    Problem::at(section.span_of(key), message, format!("it has `{other}`"))
                        .help("write a rule of your own with `measure` for another bound"),
                );
                return None;
            }
        }
    } else {
        for key in ["min", "max"] {
            if section.has(key) {
                let message = format!("the rule {} has no bounds to move", rule.name);
                section.note(
                    Problem::at(section.span_of(key), message, "only `severity` and `joints` can be changed")
                        .help(format!("see `gearwise rule {}`", rule.code)),
                );
            }
        }
    }
    if min.is_none() && max.is_none() && severity.is_none() && !section.has("severity") {
        let message = format!("nothing is changed about the rule {}", rule.name);
        section.note(Problem::at(section.span(), message, "expected `severity`, `min` or `max`"));
    }
    if severity == Some(Severity::Off) && matches!(rule.test, Test::Limit(_)) {
        section.note(
            Problem::at(
                section.span_of("severity"),
                format!("the limit {} cannot be switched off", rule.name),
                "not `off`",
            )
            .help("write an [[allow]] with a reason for the joints where it may be broken"),
        );
        return None;
    }
    Some(Tuning { rule, min, max, severity, joints, reason: reason?, span: section.span() })
}

fn read_own(section: &Section) -> Option<OwnRule> {
    let name =
        section
            .required_text(
                key("name", "of a rule of your own; with `measure`").value("text").or("rule"),
                "\"battery-life\"",
            )
            .filter(|name| {
                let text = name.get_ref();
                let odd = |c: char| !(c.is_alphanumeric() || matches!(c, '-' | '_' | '.'));
                if text.contains(odd) {
                    let message = format!("`{text}` is not a name for a rule");
                    section.note(Problem::at(name.span(), message, "expected letters, digits, `-`, `_` and `.`"));
                    return false;
                }
                if let Some(taken) = rule(text) {
                    let message = format!("`{text}` is already the name of a rule, {}", taken.code);
                    section.note(Problem::at(name.span(), message, "choose another name").help(format!(
                        "to change that rule write rule = \"{}\" in place of name and measure",
                        taken.name
                    )));
                    return false;
                }
                true
            });
    let measured = section.required_text("measure", "\"loss\"").and_then(|text| {
        let found = measure(text.get_ref());
        if found.is_none() {
            let names: Vec<&str> = measures().iter().map(|m| m.name.as_str()).collect();
            let message = format!("there is no measure `{}`", text.get_ref());
            let mut problem = Problem::at(text.span(), message, "not a measure").suggest(text.get_ref(), names);
            if problem.help.as_ref().is_some_and(|h| !h.starts_with("did")) {
                problem.help = Some("`gearwise rule --measures` lists them".into());
            }
            section.note(problem);
        }
        found
    });
    let severity = section.choice(SEVERITY, Severity::NAMES);
    let (joints, reason) = (joints(section), reason(section));
    let Some(measure) = measured else {
        section.has("min");
        section.has("max");
        return None;
    };
    if measure.of_robot() && joints.is_some() {
        let message = format!("`{}` is a measure of the whole robot", measure.name);
        section.note(Problem::at(section.span_of("joints"), message, "it has no joints to choose from"));
    }
    let (min, max) = bounds(section, measure)?;
    if min.is_none() && max.is_none() && !section.has("min") && !section.has("max") {
        section.missing("max", &format!("{} (or min)", example(measure)));
        return None;
    }
    let severity = severity.unwrap_or(Severity::Error);
    Some(OwnRule {
        name: name?.into_inner(),
        measure,
        min,
        max,
        severity,
        joints,
        reason: reason?,
        span: section.span(),
    })
}

fn example(measure: &Measure) -> String {
    measure.kind.map_or_else(|| "0.2".to_string(), |kind| format!("\"{}\"", kind.example))
}

/// `min` and `max` in SI; `None` where they are the wrong way round.
fn bounds(section: &Section, measure: &Measure) -> Option<(Option<f64>, Option<f64>)> {
    let read = |key: Key| match measure.kind {
        Some(kind) => section.quantity(key, kind, Range::Any),
        // A bare number is in the measure's unit.
        None => section.number(key, Range::Any).map(|x| if measure.unit == "1" { x } else { measure.to_si(x) }),
    };
    let (min, max) = (read(MIN), read(MAX));
    if let (Some(least), Some(most)) = (min, max)
        && least > most
    {
        let message = format!("min = {} is more than max = {}", measure.show(least), measure.show(most));
        section.note(Problem::at(section.span_of("min"), message, "nothing lies between them").help("swap the two"));
        return None;
    }
    Some((min, max))
}

fn read_allow(section: &Section, own: &[OwnRule]) -> Option<Allow> {
    let name = section.required_text(key("rule", "what may be broken").value("code or name"), "\"voltage-headroom\"");
    let (joints, reason) = (joints(section), reason(section));
    let subject =
        section.text(key("subject", "only this limit, measure or finding").default("all")).map(|s| s.into_inner());
    let name = name?;
    let found = match rule(name.get_ref()) {
        Some(rule) => Some((rule.code.to_string(), rule.name.to_string())),
        None => own.iter().find(|o| o.name == *name.get_ref()).map(|o| (o.name.clone(), o.name.clone())),
    };
    let Some((code, of)) = found else {
        let message = format!("there is no rule `{}`", name.get_ref());
        section.note(
            Problem::at(name.span(), message, "not a name or code of a rule").suggest(name.get_ref(), known(own)),
        );
        return None;
    };
    Some(Allow { code, name: of, joints, subject, reason: reason?, span: section.span() })
}
