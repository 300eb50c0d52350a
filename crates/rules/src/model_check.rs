//! Robot models checked with the rules of models, as a rules file moves them.

use std::ops::Range as Span;

use super::file::RulesFile;
use super::models::ModelFacts;
use super::registry::{MODEL_RULES, SAME_LIMITS, UNUSED_ALLOW};
use super::rule::{Instead, Judgement, ModelRemark, Rule, Severity, Test};
use super::{Applied, Finding, Judged, Location, applied};
use gearwise_model::mechanism::stated::Change;

/// Rules whose answer a strict check does not do without: limits of torque and speed.
const ASKED_BY_STRICT: &[&str] = &["GW401", "GW403"];

/// What was checked of robot models, and what was found.
#[derive(Debug)]
pub struct ModelReport<'a> {
    /// The models with the hardware of their joints.
    pub facts: ModelFacts<'a>,
    /// The rules that were applied, in the order of their codes.
    pub rules: Vec<Applied>,
    /// The findings: by rule, then by joint.
    pub findings: Vec<Finding>,
    /// How each rule went.
    pub judged: Vec<Judged>,
    /// What fixes write.
    pub instead: Vec<Instead>,
}

impl ModelReport<'_> {
    /// Number of findings of a severity that no exception lets pass.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|f| f.severity == severity && f.allowed.is_none()).count()
    }

    /// Whether anything at all was compared with hardware.
    pub fn is_judged(&self) -> bool {
        self.judged.iter().any(|judged| judged.joint.is_some() && judged.skipped.is_none())
    }

    /// What could not be judged: rule, joint, why.
    pub fn not_judged(&self) -> impl Iterator<Item = (&Applied, &str, &'static str)> {
        self.judged.iter().filter_map(|judged| {
            Some((&self.rules[judged.rule], judged.joint.as_deref().unwrap_or("model"), judged.skipped?))
        })
    }

    /// Whether the models pass: something was judged, and nothing is an error; where `strict`, nothing is a warning, and
    /// torque and speed of every joint with hardware were judged.
    pub fn passes(&self, strict: bool) -> bool {
        let unknown = || self.not_judged().any(|(rule, ..)| ASKED_BY_STRICT.contains(&rule.code.as_str()));
        let strictly = || self.count(Severity::Warning) == 0 && !unknown();
        self.is_judged() && self.count(Severity::Error) == 0 && (!strict || strictly())
    }

    /// The rule of a finding.
    pub fn rule_of(&self, finding: &Finding) -> &Applied {
        &self.rules[finding.rule]
    }

    /// What fixes write into a model, by its index.
    pub fn changes(&self, model: usize) -> Vec<Change> {
        let first = self.facts.of_model(model).map(|(k, _)| k).next().unwrap_or(0);
        let of = self.instead.iter().filter(|instead| self.facts.joints[instead.joint].model == model);
        of.map(|i| Change { joint: i.joint - first, quantity: i.quantity, value: i.value }).collect()
    }
}

/// Checks robot models against the hardware of their joints.
pub fn check_models<'a>(mut facts: ModelFacts<'a>, rules: &RulesFile) -> ModelReport<'a> {
    // What a rule that is off would have found explains nothing.
    if rules.severity(&SAME_LIMITS, None).0 == Severity::Off {
        facts.same_limits.clear();
    }
    let mut report = ModelReport {
        facts,
        rules: MODEL_RULES.iter().copied().chain([&UNUSED_ALLOW]).map(applied).collect(),
        findings: Vec::new(),
        judged: Vec::new(),
        instead: Vec::new(),
    };
    let mut checker = Checker { file: rules, used: vec![false; rules.allows.len()] };
    for (index, rule) in MODEL_RULES.iter().enumerate() {
        match rule.test {
            Test::ModelJoint(look) => {
                for k in 0..report.facts.joints.len() {
                    let name = report.facts.joints[k].joint.name.clone();
                    let (remarks, skipped) = match look(&report.facts, k) {
                        Judgement::Judged(remarks) => (remarks, None),
                        Judgement::NotJudged(why) => (Vec::new(), Some(why)),
                        Judgement::NotAsked => continue,
                    };
                    checker.add(&mut report, (index, rule), Some(name), remarks, skipped);
                }
            }
            Test::Models(look) => {
                let remarks = look(&report.facts);
                checker.add(&mut report, (index, rule), None, remarks, None);
            }
            _ => {}
        }
    }
    checker.unused(&mut report);
    report
}

struct Checker<'a> {
    file: &'a RulesFile,
    used: Vec<bool>,
}

impl Checker<'_> {
    fn add(
        &mut self,
        report: &mut ModelReport,
        (index, rule): (usize, &Rule),
        joint: Option<String>,
        remarks: Vec<ModelRemark>,
        skipped: Option<&'static str>,
    ) {
        if self.file.severity(rule, joint.as_deref()).0 == Severity::Off {
            return;
        }
        let first = report.findings.len();
        for remark in remarks {
            let name = remark.joint.map(|k| report.facts.joints[k].joint.name.clone());
            let (severity, reason) = self.file.severity(rule, name.as_deref());
            let severity = if reason.is_none() { remark.severity.unwrap_or(severity) } else { severity };
            if severity == Severity::Off {
                continue;
            }
            let allows = self.file.allows.iter().zip(&mut self.used);
            let allowed = allows.filter(|(allow, _)| allow.is_of(rule.code, name.as_deref(), remark.subject)).map(
                |(allow, used)| {
                    *used = true;
                    allow.reason.clone()
                },
            );
            let allowed = allowed.reduce(|first, _| first);
            if allowed.is_none() {
                report.instead.extend(remark.instead);
            }
            let place = |(model, span): &(Option<usize>, Span<usize>)| {
                let source = model.map_or(&report.facts.file.source, |m| &report.facts.models[m].source);
                Location::of(source, span)
            };
            let finding = Finding {
                rule: index,
                severity,
                joint: name,
                subject: remark.subject.into(),
                message: remark.message,
                help: remark.help,
                reason: reason.map(String::from),
                location: place(&remark.at),
                asked: remark.against.as_ref().map(place),
                value: remark.value,
                bound: remark.bound,
                unit: Some(remark.unit),
                backing: remark.backing,
                allowed,
            };
            report.findings.push(finding);
        }
        let findings = (first..report.findings.len()).collect();
        report.judged.push(Judged { rule: index, joint, findings, skipped });
    }

    /// Exceptions of rules of models that met no finding.
    fn unused(&mut self, report: &mut ModelReport) {
        let Some(source) = &self.file.source else { return };
        let (severity, reason) = self.file.severity(&UNUSED_ALLOW, None);
        let of_models = |code: &str| MODEL_RULES.iter().any(|rule| rule.code == code);
        for (allow, used) in self.file.allows.iter().zip(&self.used) {
            if *used || severity == Severity::Off || !of_models(&allow.code) {
                continue;
            }
            report.findings.push(Finding {
                rule: MODEL_RULES.len(),
                severity,
                joint: None,
                subject: allow.code.clone(),
                message: format!("the exception from {} meets no finding: {}", allow.name, allow.reason),
                help: None,
                reason: reason.map(String::from),
                location: Location::of(source, &allow.span),
                asked: None,
                value: None,
                bound: None,
                unit: None,
                backing: None,
                allowed: None,
            });
        }
    }
}
