//! The design file of `optimize`: what was chosen, at ratios that can be built, kept by the rules it will be checked by.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Failure;
use crate::catalog::Catalog;
use crate::design::answer::{Design, RobotResult};
use crate::design::buildable::{Built, built};
use crate::design::optimize::optimize_with;
use crate::design::options::Options;
use crate::design::robot::Choice;
use crate::input::Source;
use crate::report::design_file::{self, Written, way};
use crate::report::{number, optimize::without_choice};
use crate::requirement::{DesignFile, Robot};
use crate::rules::bounded::{Kept, bounded};
use crate::rules::lock::path_of;
use crate::rules::{RULES, RulesFile, Severity, Test, check, file};

/// The rules that a choice has to keep.
pub struct Ruled {
    /// The robot with its limits tightened by them.
    pub robot: Robot,
    /// Which rule tightens what.
    kept: Vec<Kept>,
    /// The rules; `None` where none are kept.
    rules: Option<RulesFile>,
    /// Their file; `None` for the default ones.
    path: Option<PathBuf>,
}

impl Ruled {
    /// The rules of a call: those of a file that it or the requirement names, else the default ones where a design is
    /// written, else none.
    ///
    /// # Errors
    /// A rules file that cannot be read.
    pub fn new(robot: Robot, path: Option<&Path>, writes: bool, none: bool) -> Result<Ruled, Failure> {
        let path = path.map(Path::to_path_buf).or_else(|| robot.rules.clone()).filter(|_| !none);
        let rules = match &path {
            Some(path) => Some(file::read(path).map_err(|e| vec![e])?),
            None => (writes && !none).then(RulesFile::default),
        };
        let (robot, kept) = match &rules {
            Some(rules) => bounded(&robot, rules),
            None => (robot, Vec::new()),
        };
        Ok(Ruled { robot, kept, rules, path })
    }

    /// What the rules cost each joint: its first choice against that without them.
    ///
    /// # Errors
    /// It was stopped.
    pub fn costs(&self, plain: &Robot, catalog: &Catalog, result: &RobotResult) -> Result<Vec<String>, Failure> {
        if self.kept.is_empty() {
            return Ok(Vec::new());
        }
        // By the same objective: what it is balanced from is found among designs that keep the rules.
        let mut plain = plain.clone();
        for (joint, ruled) in plain.joints.iter_mut().zip(&self.robot.joints) {
            (joint.objective, joint.balancing) = (ruled.objective.clone(), ruled.balancing.clone());
        }
        let free = optimize_with(&plain, catalog, Options { keep: Some(1), reasons: false, ..Options::default() })?;
        let line = |(with, free): (&crate::design::JointResult, &crate::design::JointResult)| {
            let name = &with.joint.name;
            match (with.candidates.first(), free.candidates.first()) {
                (None, Some(first)) => {
                    Some(format!("{name}: no design keeps the rules; without them {}", named(first)))
                }
                (Some(with), Some(free)) => self.cost(name, with, free),
                (_, None) => None,
            }
        };
        Ok(result.joints.iter().zip(&free.joints).filter_map(line).collect())
    }

    fn cost(&self, joint: &str, with: &Design, free: &Design) -> Option<String> {
        let (now, was) = (with.optimum.objective, free.optimum.objective);
        let same = with.motor.id == free.motor.id && with.gear == free.gear;
        if same && now <= was * (1.0 + 1e-6) {
            return None;
        }
        // What ends the ratios of the choice, or is used up there, and is a rule's.
        let tightest = with.evaluation.margins.iter().filter(|m| m.margin < 1e-6).map(|m| m.limit);
        let window = with.optimum.window();
        let binds: Vec<&str> = [window.low.limit, window.high.limit].into_iter().chain(tightest).collect();
        let mut rules: Vec<&str> = self
            .kept
            .iter()
            .filter(|kept| kept.joint == joint && binds.contains(&kept.limit))
            .map(|kept| kept.rule.as_str())
            .collect();
        rules.dedup();
        let because = if rules.is_empty() { "they rule it out".into() } else { format!("{} binds", rules.join(", ")) };
        let more = match was > 0.0 {
            true => format!("{:+.1} % of the objective", 100.0 * (now / was - 1.0)),
            false => format!("{} instead of {}", number(now), number(was)),
        };
        Some(format!("{joint}: the rules cost {more} ({because}); without them {}", named(free)))
    }

    /// The text of the design file: the first designs that pass the rules, at ratios that can be built.
    ///
    /// # Errors
    /// In words, why there is none.
    pub fn written(
        &self,
        result: &RobotResult,
        whole: Option<&Choice>,
        requirement: &Path,
        catalog: (&Catalog, &[PathBuf]),
        path: &Path,
    ) -> Result<String, String> {
        let without = without_choice(result);
        if !without.is_empty() {
            return Err(without.join("; ").replace("NO ", "no "));
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let catalog_files: Vec<PathBuf> = catalog.1.iter().map(|p| way(folder, p)).collect();
        let rules_file = self.path.as_ref().map(|p| way(folder, p));
        // Designs that are left out, by joint: of a whole robot, combinations.
        let mut next = vec![0; result.joints.len()];
        let mut combination = 0;
        loop {
            let (what, designs): (&str, Vec<&Design>) = match whole {
                None => {
                    let all = result.joints.iter().zip(&next).map(|(joint, k)| &joint.candidates[*k]);
                    ("First choices", all.collect())
                }
                Some(whole) => {
                    let found = whole.combinations.get(combination);
                    let why = "no combination of motors keeps the robot's budgets";
                    ("Best combination", found.ok_or(why)?.joints.iter().collect())
                }
            };
            // Where joints depend on each other one of them is not solved again by itself.
            let coupled = whole.is_some() && result.robot.is_coupled();
            let mut built_ones: Vec<Option<Built>> = Vec::new();
            for (joint, design) in result.joints.iter().zip(&designs) {
                built_ones.push(if coupled { None } else { built(result.robot, joint.joint, catalog.0, design) });
            }
            let text = design_file::toml(&Written {
                result,
                what,
                designs: designs.iter().copied().zip(built_ones).collect(),
                requirement: &way(folder, requirement),
                catalog: &catalog_files,
                rules: rules_file.as_deref(),
            });
            let Some(rules) = &self.rules else { return Ok(text) };
            let broken = broken(&text, path, catalog.0, rules, &self.robot)?;
            let Some((joint, why)) = broken.first() else { return Ok(text) };
            let Some(place) = joint.as_ref().and_then(|name| result.joints.iter().position(|j| j.joint.name == *name))
            else {
                return Err(format!("the rules are not kept: {why}"));
            };
            match whole {
                Some(_) => combination += 1,
                None => next[place] += 1,
            }
            let left = match whole {
                Some(whole) => combination < whole.combinations.len(),
                None => next[place] < result.joints[place].candidates.len(),
            };
            if !left {
                let name = joint.as_deref().unwrap_or_default();
                return Err(format!("no design that was found keeps all rules; of the last one at {name}: {why}"));
            }
        }
    }
}

fn named(design: &Design) -> String {
    let gear = design.gear.map_or_else(String::new, |gear| format!(" with {gear}"));
    format!("{}{gear} at N = {}", design.motor.id, number(design.evaluation.ratio))
}

/// What keeps a design from passing its rules: errors, and rules that bound a measure, with their joint.
fn broken(
    text: &str,
    path: &Path,
    catalog: &Catalog,
    rules: &RulesFile,
    robot: &Robot,
) -> Result<Vec<(Option<String>, String)>, String> {
    let source = Arc::new(Source::new(path.display().to_string(), text));
    let failed = |errors: Vec<crate::input::InputError>| {
        let said = errors.iter().flat_map(|e| &e.problems).map(|p| p.message.clone()).collect::<Vec<_>>();
        format!("the design that was made cannot be read: {}", said.join("; "))
    };
    let mut design = DesignFile::read_source(&source).map_err(failed)?;
    for (joint, ruled) in design.robot.joints.iter_mut().zip(&robot.joints) {
        (joint.objective, joint.balancing) = (ruled.objective.clone(), ruled.balancing.clone());
    }
    let report = check(&design, catalog, rules, None, &path_of(path)).map_err(failed)?;
    let bounds = |code: &str| match RULES.iter().find(|rule| rule.code == code) {
        Some(rule) => matches!(rule.test, Test::Bounds { .. }),
        // One's own.
        None => true,
    };
    let blocks = report.findings.iter().filter(|f| {
        let code = &report.rule_of(f).code;
        let counts = f.severity == Severity::Error || f.severity == Severity::Warning && bounds(code);
        f.allowed.is_none() && counts
    });
    Ok(blocks.map(|f| (f.joint.clone(), format!("{}: {}", report.rule_of(f).name, f.message))).collect())
}
