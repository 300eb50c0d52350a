#![doc = include_str!("../README.md")]

pub mod bounded;
pub mod facts;
pub mod file;
pub mod hardware;
pub mod lock;
pub mod measure;
pub mod model_check;
pub mod models;
pub mod place;
mod registry;
mod rule;

use std::sync::Arc;

pub use file::RulesFile;
pub use model_check::{ModelReport, check_models};
pub use place::{Location, Place, clean};
pub use registry::{MODEL_RULES, RULES, every_rule, rule};
pub use rule::{Backing, Remark, Rule, Severity, Test};

use facts::{JointFacts, RobotFacts};
use file::Selection;
use gearwise_model::actuator::limits::LIMITS;
use gearwise_model::actuator::parts::{PartKind, Whole};
use gearwise_model::catalog::Catalog;
use gearwise_model::input::{InputError, Source};
use gearwise_model::requirement::{Choice, DesignFile};
use gearwise_model::words::{heat_or, with_unit};
use gearwise_select::Unusable;
use gearwise_select::evaluate::FEASIBILITY_TOLERANCE;
use gearwise_select::examine::{Examined, best_ratios, examine};
use lock::{Lock, LockState};
use measure::{Measure, measure};
use place::{Places, asked_for};

/// A rule as it was applied: one of gearwise, or one of a rules file.
#[derive(Debug, Clone, PartialEq)]
pub struct Applied {
    /// Code; the name of a rule of one's own.
    pub code: String,
    /// Name.
    pub name: String,
    /// One line.
    pub summary: String,
    /// The whole text.
    pub help: String,
    /// Severity where no joint has another.
    pub severity: Severity,
}

/// What a rule found.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Index of the rule in [`Report::rules`].
    pub rule: usize,
    /// How much it weighs.
    pub severity: Severity,
    /// The joint; `None` for the robot as a whole and the rules file.
    pub joint: Option<String>,
    /// What of it: a limit, a measure, a row.
    pub subject: String,
    /// What is wrong, with numbers.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// Why the bound is as it is, where the rules file says so.
    pub reason: Option<String>,
    /// Where it stands.
    pub location: Location,
    /// Where what it breaks is asked for.
    pub asked: Option<Location>,
    /// The value that was compared, SI.
    pub value: Option<f64>,
    /// What it was compared with, SI.
    pub bound: Option<f64>,
    /// SI unit of both, where it is not that of the subject.
    pub unit: Option<&'static str>,
    /// The row of the hardware that a finding about a robot model rests on.
    pub backing: Option<Backing>,
    /// The reason of the exception that lets it pass.
    pub allowed: Option<String>,
}

/// How a rule went at a joint, or at the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Index of the rule in [`Report::rules`].
    pub rule: usize,
    /// The joint; `None` for the robot.
    pub joint: Option<String>,
    /// Indices of its findings in [`Report::findings`].
    pub findings: Vec<usize>,
    /// Why it was not judged; then there are no findings.
    pub skipped: Option<&'static str>,
}

/// What was checked, and what was found.
#[derive(Debug)]
pub struct Report<'a> {
    /// The design with its evaluation.
    pub facts: RobotFacts<'a>,
    /// The rules that were applied, in the order of their codes, one's own last.
    pub rules: Vec<Applied>,
    /// The findings: by joint, then by rule.
    pub findings: Vec<Finding>,
    /// How each rule went.
    pub judged: Vec<Judged>,
    /// The lock as the catalogue is now.
    pub lock: Lock,
}

impl Report<'_> {
    /// Number of findings of a severity that no exception lets pass.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|f| f.severity == severity && f.allowed.is_none()).count()
    }

    /// Whether the design passes: no error, and where `strict` no warning.
    pub fn passes(&self, strict: bool) -> bool {
        self.count(Severity::Error) == 0 && (!strict || self.count(Severity::Warning) == 0)
    }

    /// The rule of a finding.
    pub fn rule_of(&self, finding: &Finding) -> &Applied {
        &self.rules[finding.rule]
    }
}

impl Finding {
    /// What makes it the same finding in another run, whatever its numbers and lines: rule, joint and subject.
    pub fn identity(&self, rule: &Applied) -> String {
        format!("{}/{}/{}", rule.code, self.joint.as_deref().unwrap_or(""), self.subject)
    }
}

/// Checks a design with the rules of gearwise, as a rules file moves them, and with its own.
///
/// `lock` is the lock file beside the design, where there is one; `lock_path` is where it is or would be.
///
/// # Errors
/// Motors and gears that the catalogue does not have; a lock that cannot be read or is of another design.
pub fn check<'a>(
    design: &'a DesignFile,
    catalog: &'a Catalog,
    rules: &RulesFile,
    lock: Option<&Arc<Source>>,
    lock_path: &std::path::Path,
) -> Result<Report<'a>, Vec<InputError>> {
    let choices = design.choices(catalog).map_err(|e| vec![e])?;
    let now = Lock::of(design, &choices, catalog);
    let state = match lock {
        None => LockState::Missing(lock_path.to_path_buf()),
        Some(source) => {
            let locked = Lock::read(source, design).map_err(|e| vec![e])?;
            LockState::Compared { path: lock_path.to_path_buf(), differences: locked.differences(&now, &choices) }
        }
    };
    let mut examined = examine(&design.robot, &choices);
    best_under_rules(design, &choices, rules, &mut examined);
    let joints: Vec<JointFacts> = choices
        .into_iter()
        .zip(examined)
        .map(|(choice, examined)| JointFacts { robot: &design.robot, examined, choice })
        .collect();
    let facts = RobotFacts { design, joints, lock: state };
    let mut checker = Checker {
        places: Places { design, rules: rules.source.as_ref() },
        file: rules,
        rules: Vec::new(),
        findings: Vec::new(),
        judged: Vec::new(),
        used: vec![false; rules.allows.len()],
    };
    checker.run(&facts);
    let Checker { rules, findings, judged, .. } = checker;
    Ok(Report { facts, rules, findings, judged, lock: now })
}

/// Compares with the best ratio under the same rules: a rule does not advise against what another one asks for.
fn best_under_rules(
    design: &DesignFile,
    choices: &[Choice],
    rules: &RulesFile,
    examined: &mut [Result<Examined, Unusable>],
) {
    let (robot, kept) = bounded::bounded(&design.robot, rules);
    if kept.is_empty() {
        return;
    }
    let own = |choice: &Choice| robot.joints.iter().find(|joint| joint.name == choice.joint.name);
    let ruled = choices.iter().filter_map(|choice| Some(Choice { joint: own(choice)?, ..*choice }));
    for (examined, ruled) in examined.iter_mut().zip(best_ratios(&robot, &ruled.collect::<Vec<_>>())) {
        if let (Ok(examined), Some(best)) = (examined, ruled) {
            examined.best = best;
        }
    }
}

struct Checker<'a> {
    places: Places<'a>,
    file: &'a RulesFile,
    rules: Vec<Applied>,
    findings: Vec<Finding>,
    judged: Vec<Judged>,
    used: Vec<bool>,
}

/// Bounds as they stand at a joint.
struct Bounds {
    min: Option<f64>,
    max: Option<f64>,
}

impl Checker<'_> {
    fn run(&mut self, facts: &RobotFacts) {
        let file = self.file;
        self.rules = RULES.iter().map(|rule| applied(rule)).collect();
        self.rules.extend(file.own.iter().map(applied_own));
        for joint in &facts.joints {
            for (index, rule) in RULES.iter().enumerate() {
                self.joint_rule(index, rule, joint);
            }
            for (k, own) in file.own.iter().enumerate() {
                if own.measure.of_robot() || !own.joints.has(&joint.choice.joint.name) {
                    continue;
                }
                let bounds = Bounds { min: own.min, max: own.max };
                let judged = within(&[own.measure], &bounds, |m| m.at(joint));
                self.add(RULES.len() + k, own.severity, Some(joint), judged, Some(&own.reason));
            }
        }
        for (index, rule) in RULES.iter().enumerate() {
            if let Test::Robot(look) = rule.test {
                let (severity, reason) = self.file.severity(rule, None);
                if severity != Severity::Off {
                    self.add(index, severity, None, Ok(look(facts)), reason);
                }
            }
        }
        for (k, own) in file.own.iter().enumerate().filter(|(_, own)| own.measure.of_robot()) {
            let bounds = Bounds { min: own.min, max: own.max };
            let judged = within(&[own.measure], &bounds, |m| m.of(facts));
            self.add(RULES.len() + k, own.severity, None, judged, Some(&own.reason));
        }
        self.rules_file(facts);
    }

    fn joint_rule(&mut self, index: usize, rule: &'static Rule, joint: &JointFacts) {
        let (severity, reason) = self.file.severity(rule, Some(&joint.choice.joint.name));
        if severity == Severity::Off {
            return;
        }
        let judged = match &rule.test {
            Test::Limit(limit) => limit_remarks(limit, joint),
            Test::Bounds { measures, min, max } => {
                let named: Vec<&Measure> = measures.iter().filter_map(|name| measure(name)).collect();
                let [min, max] = self.file.bounds(rule, &joint.choice.joint.name, [*min, *max]);
                let bounds = Bounds { min, max };
                // A limit that is exceeded is an error already; its reserve has nothing to add.
                within(&named, &bounds, |m| m.at(joint).filter(|_| !m.is_exceeded(joint)))
            }
            Test::Joint(look) => Ok(look(joint)),
            Test::Robot(_) | Test::RulesFile | Test::ModelJoint(_) | Test::Models(_) => return,
        };
        self.add(index, severity, Some(joint), judged, reason);
    }

    fn add(
        &mut self,
        rule: usize,
        severity: Severity,
        joint: Option<&JointFacts>,
        judged: Result<Vec<Remark>, &'static str>,
        reason: Option<&str>,
    ) {
        let name = joint.map(|j| j.choice.joint.name.clone());
        let (remarks, skipped) = match judged {
            Ok(remarks) => (remarks, None),
            Err(why) => (Vec::new(), Some(why)),
        };
        if severity == Severity::Off {
            return;
        }
        let first = self.findings.len();
        for remark in remarks {
            self.find(rule, severity, joint, remark, reason);
        }
        let findings = (first..self.findings.len()).collect();
        self.judged.push(Judged { rule, joint: name, findings, skipped });
    }

    fn find(
        &mut self,
        rule: usize,
        severity: Severity,
        joint: Option<&JointFacts>,
        remark: Remark,
        reason: Option<&str>,
    ) {
        let name = joint.map(|j| j.choice.joint.name.clone());
        let at = remark.at_joint.as_ref();
        let of_joint = at.and_then(|name| self.places.design.joints.iter().find(|j| j.name == *name));
        let design = joint.map(|j| j.choice.design).or(of_joint);
        let code = &self.rules[rule].code;
        let allowed = self.file.allows.iter().zip(&mut self.used).find_map(|(allow, used)| {
            allow.is_of(code, name.as_deref(), &remark.subject).then(|| {
                *used = true;
                allow.reason.clone()
            })
        });
        self.findings.push(Finding {
            rule,
            severity,
            joint: name,
            location: self.places.locate(&remark.place, design),
            asked: remark.asked.as_ref().map(|place| self.places.locate(place, design)),
            subject: remark.subject,
            message: remark.message,
            help: remark.help,
            reason: reason.map(String::from),
            value: remark.value,
            bound: remark.bound,
            unit: remark.unit,
            backing: None,
            allowed,
        });
    }

    /// What the rules file itself gets wrong about this robot.
    fn rules_file(&mut self, facts: &RobotFacts) {
        let file = self.file;
        let nothing: Vec<Remark> = file
            .allows
            .iter()
            .zip(&self.used)
            .filter(|(allow, used)| !**used && !is_of_models(&allow.code))
            .map(|(allow, _)| {
                let message = format!("the exception from {} meets no finding: {}", allow.name, allow.reason);
                Remark::new(message, allow.code.clone(), Place::Rules(allow.span.clone()))
            })
            .collect();
        let names: Vec<&str> = facts.joints.iter().map(|j| j.choice.joint.name.as_str()).collect();
        let tunings = file.tunings.iter().filter(|t| !is_of_models(t.rule.code)).map(|t| &t.joints);
        let allows = file.allows.iter().filter(|a| !is_of_models(&a.code)).map(|a| &a.joints);
        let selections = tunings.chain(file.own.iter().map(|o| &o.joints)).chain(allows);
        let patterns = selections.flat_map(|s: &Selection| &s.patterns);
        let unmatched =
            patterns.filter(|(pattern, _)| !names.iter().any(|n| gearwise_model::catalog::matches_pattern(pattern, n)));
        let selects: Vec<Remark> = unmatched
            .map(|(pattern, span)| {
                let message = format!("`{pattern}` matches no joint of the robot");
                let help = match gearwise_model::words::nearest(pattern, names.iter().copied()) {
                    Some(near) => format!("did you mean `{near}`?"),
                    None => format!("there are: {}", names.join(", ")),
                };
                Remark { help: Some(help), ..Remark::new(message, pattern.clone(), Place::Rules(span.clone())) }
            })
            .collect();
        if file.source.is_none() {
            return;
        }
        for (wanted, remarks) in [(registry::UNUSED_ALLOW, nothing), (registry::SELECTS_NOTHING, selects)] {
            let Some(index) = RULES.iter().position(|r| r.code == wanted.code) else { continue };
            let (severity, reason) = self.file.severity(&wanted, None);
            self.add(index, severity, None, Ok(remarks), reason);
        }
    }
}

/// Whether a code is that of a rule of robot models, which `check-model` asks.
fn is_of_models(code: &str) -> bool {
    MODEL_RULES.iter().any(|rule| rule.code == code)
}

fn applied(rule: &Rule) -> Applied {
    Applied {
        code: rule.code.into(),
        name: rule.name.into(),
        summary: rule.summary.into(),
        help: format!("{}\n\nWhy: {}\n\nExample: {}\n\nHow to fix it: {}", rule.what, rule.why, rule.example, rule.fix),
        severity: rule.severity,
    }
}

fn applied_own(own: &file::OwnRule) -> Applied {
    let bound = match (own.min, own.max) {
        (Some(min), Some(max)) => format!("from {} to {}", own.measure.show(min), own.measure.show(max)),
        (Some(min), None) => format!("at least {}", own.measure.show(min)),
        (None, Some(max)) => format!("at most {}", own.measure.show(max)),
        (None, None) => String::new(),
    };
    Applied {
        code: own.name.clone(),
        name: own.name.clone(),
        summary: format!("{} is {bound}", own.measure.name),
        help: format!("{}: {}. Reason: {}", own.measure.name, own.measure.meaning, own.reason),
        severity: own.severity,
    }
}

/// A limit of the model at a joint.
fn limit_remarks(limit: &'static str, joint: &JointFacts) -> Result<Vec<Remark>, &'static str> {
    let examined = joint.examined.as_ref().map_err(|_| "the design cannot be evaluated")?;
    if let Some((_, why)) = examined.unchecked.iter().find(|(name, _)| *name == limit) {
        return Err(why);
    }
    let margin = examined.evaluation.least(limit).ok_or("nobody asks for it")?;
    if margin.margin >= -FEASIBILITY_TOLERANCE {
        return Ok(Vec::new());
    }
    let number = gearwise_model::words::number;
    let at = margin.sample.map_or_else(String::new, |k| format!(" at {}", joint.choice.joint.motion.name_sample(k)));
    let hot = heat_or(margin.demand, margin.unit) != with_unit(margin.demand, margin.unit);
    let over = if margin.bound > 0.0 && margin.demand.is_finite() && !hot {
        format!(" ({} % over)", number((1000.0 * (margin.demand / margin.bound - 1.0)).round() / 10.0))
    } else {
        String::new()
    };
    // What a drive is bought by is the phase's amplitude: which ampere is meant is said.
    let q_axis = LIMITS.iter().any(|l| l.name == limit && l.is_q_axis());
    let unit = if q_axis { format!("{} (q axis)", margin.unit) } else { margin.unit.to_string() };
    let least = if margin.parts.is_some_and(|parts| parts.missing.is_some()) { "at least " } else { "" };
    let part = margin.parts.and_then(|parts| parts.part).map(|part| format!(" of the {}", part.word()));
    let part = part.unwrap_or_default();
    let message = format!(
        "`{limit}` is exceeded: {least}{}{part} where the {} allows {} {unit}{over}{at}",
        if hot { heat_or(margin.demand, margin.unit) } else { format!("{} {unit}", number(margin.demand)) },
        margin.owner,
        number(margin.bound),
    );
    // What is too heavy, too large or too dear is the motor, unless it is the gear alone; all else is decided with the ratio.
    let place = match margin.parts {
        Some(Whole { part: Some(PartKind::Gear), .. }) => Place::Reduction,
        Some(_) => Place::Motor,
        None if limit == "actuator_mass" => Place::Motor,
        None => Place::Reduction,
    };
    let mut remark = Remark::new(message, limit, place);
    remark.asked = match (joint.choice.gear, asked_for(limit, margin.owner)) {
        // A gear of the catalogue brings its own ratings.
        (Some(_), Some(Place::JointKey(["gear", _]))) => None,
        (_, asked) => asked,
    };
    (remark.value, remark.bound, remark.unit) = (Some(margin.demand), Some(margin.bound), Some(margin.unit));
    Ok(vec![remark])
}

/// Measures that leave their bounds.
fn within(
    measures: &[&'static Measure],
    bounds: &Bounds,
    value: impl Fn(&'static Measure) -> Option<f64>,
) -> Result<Vec<Remark>, &'static str> {
    let known: Vec<(&'static Measure, f64)> = measures.iter().filter_map(|m| Some((*m, value(m)?))).collect();
    if known.is_empty() {
        return Err("what it measures is not known or not asked for");
    }
    let mut remarks = Vec::new();
    for (measure, value) in known {
        // What rounding leaves of a value at its bound is no finding.
        let slack = |bound: f64| FEASIBILITY_TOLERANCE * bound.abs().max(f64::MIN_POSITIVE);
        let below = bounds.min.filter(|min| value < *min - slack(*min));
        let above = bounds.max.filter(|max| value > *max + slack(*max));
        let Some((bound, word)) = below.map(|b| (b, "least")).or(above.map(|b| (b, "most"))) else { continue };
        let message =
            format!("`{}` is {}, at {word} {} is asked", measure.name, measure.show(value), measure.show(bound));
        let mut remark = Remark::new(message, measure.name.clone(), measure.place());
        (remark.value, remark.bound) = (Some(value), Some(bound));
        remarks.push(remark);
    }
    Ok(remarks)
}
