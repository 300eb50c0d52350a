//! The design file of `optimize`: what was chosen, at ratios that can be built, kept by the rules it will be checked by.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Failure;
use crate::catalog::Catalog;
use crate::design::answer::{Design, JointResult, Reason, Rejected, RobotResult};
use crate::design::buildable::built;
use crate::design::evaluate::FEASIBILITY_TOLERANCE;
use crate::design::families::settle;
use crate::design::mount::{JointDemand, Site};
use crate::design::optimize::optimize_with;
use crate::design::options::Options;
use crate::design::robot::{self, Choice};
use crate::input::Source;
use crate::report::design_file::{self, Made, Written, building_costs, way};
use crate::report::{design_ratio, number, optimize::without_choice};
use crate::requirement::{DesignFile, Joint, Robot};
use crate::rules::bounded::{Kept, bounded};
use crate::rules::lock::path_of;
use crate::rules::{RULES, RulesFile, Severity, Test, check, file};

/// By what names files are written into a design file.
#[derive(Debug, Clone, Copy)]
pub struct Names<'n> {
    /// The requirement.
    pub requirement: &'n Path,
    /// The requirement itself, where it is no file that could be read again.
    pub given: Option<&'n Arc<Source>>,
    /// Catalogue files; none for the built-in one.
    pub catalog: &'n [PathBuf],
}

/// The rules that a choice has to keep.
#[derive(Debug)]
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

    /// Sentences for the joints where `--write-design` would write another design than the recommended one: that design, and the rule that
    /// rejects the recommendation. Empty if the default rules accept all recommended designs, or if a joint has none.
    ///
    /// # Errors
    /// A search that was stopped.
    pub fn other_designs(
        result: &RobotResult,
        names: Names,
        ground: (&Robot, &Catalog),
        options: Options,
    ) -> Result<Vec<String>, Failure> {
        let (ruled, path) = (Ruled::new(result.robot.clone(), None, true, false)?, Path::new("design.toml"));
        let Some(rules) = &ruled.rules else { return Ok(Vec::new()) };
        // The requirement is the one that was read: a pipe cannot be read again.
        let read = Arc::new(Source::new(names.requirement.display().to_string(), ""));
        let names = Names { given: Some(names.given.unwrap_or(&read)), ..names };
        let Some(designs) = result.joints.iter().map(|of| of.candidates.first()).collect::<Option<Vec<&Design>>>()
        else {
            return Ok(Vec::new());
        };
        let make = |(of, design): (&JointResult, &&Design)| made_again(result.robot, of.joint, ground.1, design);
        let made: Vec<Option<Made>> = result.joints.iter().zip(&designs).map(make).collect();
        // Rules judge the ratios that are written.
        let written: Vec<String> = designs
            .iter()
            .zip(&made)
            .map(|(design, made)| match made.as_ref().filter(|made| made.ratio != design.evaluation.ratio) {
                Some(made) => format!("{} at N = {}, which can be built,", design.motor.id, number(made.ratio)),
                None => named(design),
            })
            .collect();
        let text = ruled.text(result, "First choices", designs.clone(), made, names, path);
        let none = |why: String| Ok(vec![format!("`--write-design` would write no design: {why}")]);
        let broken = match ruled.broken(&text.toml, path, ground, rules, names) {
            Ok(broken) if broken.is_empty() => return Ok(Vec::new()),
            Ok(broken) => broken,
            Err(why) => return none(why),
        };
        let options = Options { only_checked: options.only_checked, keep: None, reasons: false, ..options };
        let mut other = optimize_with(&ruled.robot, ground.1, options)?;
        if let Err(why) = ruled.keep(&mut other, names, ground, Some(path)) {
            return none(why);
        }
        let line = |(((of, design), written), other): (((&JointResult, &Design), &String), &JointResult)| {
            let name = &of.joint.name;
            let rule = broken.iter().find(|(joint, _)| joint.as_ref() == Some(name)).map(|(_, why)| why.as_str());
            let because = rule.map_or_else(String::new, |why| format!(" {written} violates rule {why}."));
            let Some(kept) = other.candidates.first() else {
                return Some(format!(
                    "{name}: `--write-design` would write no design.{because} `--no-rules` writes it."
                ));
            };
            let same = kept.motor.id == design.motor.id && kept.gear == design.gear;
            if same && (rule.is_none() || kept.evaluation.ratio == design.evaluation.ratio) {
                return None;
            }
            let mass = kept.evaluation.mass.map_or_else(String::new, |mass| format!("{} kg, ", number(mass)));
            let figures = format!("{mass}{} W", number(kept.evaluation.loss));
            Some(format!("{name}: `--write-design` would write {} ({figures}) instead.{because}", named(kept)))
        };
        Ok(result.joints.iter().zip(designs).zip(&written).zip(&other.joints).filter_map(line).collect())
    }

    /// Sentences for a whole robot whose best combination is another with `--write-design`: the combination that would be written, and the
    /// rule that rejects the best one. Empty if the default rules accept it.
    ///
    /// # Errors
    /// A search that was stopped.
    pub fn other_combination(
        result: &RobotResult,
        whole: &Choice,
        names: Names,
        ground: (&Robot, &Catalog),
        (options, of_robot): (Options, robot::Options),
    ) -> Result<Vec<String>, Failure> {
        let (ruled, path) = (Ruled::new(result.robot.clone(), None, true, false)?, Path::new("design.toml"));
        let (Some(rules), Some(first)) = (&ruled.rules, whole.combinations.first()) else { return Ok(Vec::new()) };
        let read = Arc::new(Source::new(names.requirement.display().to_string(), ""));
        let names = Names { given: Some(names.given.unwrap_or(&read)), ..names };
        let text = ruled.combined(result, whole, &first.joints, (names, ground.1), path);
        let because = match ruled.broken(&text.toml, path, ground, rules, names) {
            Ok(broken) => match broken.into_iter().next() {
                None => return Ok(Vec::new()),
                Some((Some(joint), why)) => format!("at {joint} this one violates rule {why}"),
                Some((None, why)) => format!("this one violates rule {why}"),
            },
            Err(why) => why,
        };
        // A second search would take as long as the first.
        if of_robot.enough.is_some() {
            return Ok(vec![format!("`--write-design` would write another combination, or none: {because}.")]);
        }
        let options = Options { keep: Some(1), reasons: false, ..options };
        let ruled_result = optimize_with(&ruled.robot, ground.1, options)?;
        let other = robot::choose(&ruled.robot, ground.1, of_robot)?;
        Ok(vec![match ruled.first_kept(&ruled_result, &other, names, ground, path) {
            Ok((place, _)) => {
                let pairs = result.robot.joints.iter().zip(&other.combinations[place].joints).zip(&first.joints);
                let differs = |((_, other), first): &((&Joint, &Design), &Design)| named(other) != named(first);
                let all: Vec<String> =
                    pairs.filter(differs).map(|((of, d), _)| format!("{}: {}", of.name, named(d))).collect();
                format!("`--write-design` would write another combination ({}); {because}.", all.join(", "))
            }
            Err(_) => format!("`--write-design` would write no combination: {because}."),
        }])
    }

    /// Whether there are rules to keep.
    pub fn keeps(&self) -> bool {
        self.rules.is_some()
    }

    /// What the rules cost each joint: its first choice against that without them.
    ///
    /// # Errors
    /// It was stopped.
    pub fn costs(
        &self,
        plain: &Robot,
        catalog: &Catalog,
        result: &RobotResult,
        options: Options,
    ) -> Result<Vec<String>, Failure> {
        if self.rules.is_none() {
            return Ok(Vec::new());
        }
        // By the same objective: what it is balanced from is found among designs that keep the rules.
        let mut plain = plain.clone();
        take_objectives(&mut plain, &self.robot);
        let options = Options { only_checked: false, keep: Some(1), reasons: false, ..options };
        let free = optimize_with(&plain, catalog, options)?;
        let line = |(with, free): (&JointResult, &JointResult)| {
            let name = &with.joint.name;
            match (with.candidates.first(), free.candidates.first()) {
                (None, Some(first)) => {
                    Some(format!("{name}: no design keeps the rules; without them {}", named(first)))
                }
                (Some(first), Some(free)) => self.cost(with.joint, first, free, catalog),
                (_, None) => None,
            }
        };
        Ok(result.joints.iter().zip(&free.joints).filter_map(line).collect())
    }

    /// What the limits that rules add cost a whole robot: its best combination against that without them; `None` where they cost nothing.
    ///
    /// # Errors
    /// It was stopped.
    pub fn cost_of_robot(
        &self,
        plain: &Robot,
        catalog: &Catalog,
        whole: &Choice,
        options: robot::Options,
    ) -> Result<Option<String>, Failure> {
        if self.kept.is_empty() {
            return Ok(None);
        }
        let mut plain = plain.clone();
        take_objectives(&mut plain, &self.robot);
        let options = robot::Options { budgets: false, runner_ups: 0, tick: &|| (), searched: &|_, _| (), ..options };
        let free = robot::choose(&plain, catalog, options)?;
        let Some(free) = free.combinations.first() else { return Ok(None) };
        let Some(with) = whole.combinations.first() else {
            return Ok(Some("The whole robot without the rules (`--no-rules`) has a combination.".into()));
        };
        let (now, was) = (with.objective, free.objective);
        if now <= was + 1e-6 * was.abs() {
            return Ok(None);
        }
        let less = match now > 0.0 {
            true => format!("{:+.1} % of the objective", 100.0 * (was / now - 1.0)),
            false => format!("{} instead of {}", number(was), number(now)),
        };
        let pairs = with.joints.iter().zip(&free.joints).zip(&plain.joints);
        let other = pairs.filter(|((with, free), _)| with.motor.id != free.motor.id || with.gear != free.gear);
        let other: Vec<String> = other.map(|((_, free), joint)| format!("{}: {}", joint.name, named(free))).collect();
        let instead = if other.is_empty() { "the same motors at other ratios".into() } else { other.join(", ") };
        Ok(Some(format!("The whole robot without the rules (`--no-rules`): {less}, with {instead}.")))
    }

    fn cost(&self, joint: &Joint, with: &Design, free: &Design, catalog: &Catalog) -> Option<String> {
        let (now, was) = (with.optimum.objective, free.optimum.objective);
        let same = with.motor.id == free.motor.id && with.gear == free.gear;
        if same && now <= was * (1.0 + 1e-6) {
            return None;
        }
        // What the choice without rules exceeds with them.
        let demand = JointDemand::new(joint, catalog);
        let mount = Site::new(&self.robot, joint, &demand).mount(free.motor, free.gear).ok();
        let exceeded: Vec<&str> = mount.and_then(|m| m.prepared().ok()).map_or_else(Vec::new, |prepared| {
            let there = prepared.at(free.evaluation.ratio);
            there.margins.iter().filter(|m| m.margin < -FEASIBILITY_TOLERANCE).map(|m| m.limit).collect()
        });
        let mut rules: Vec<&str> = self
            .kept
            .iter()
            .filter(|kept| kept.joint == joint.name && exceeded.contains(&kept.limit))
            .map(|kept| kept.rule.as_str())
            .collect();
        rules.dedup();
        let because = match rules.as_slice() {
            [] => "it breaks a rule that is looked at on the result".into(),
            rules => format!("it breaks {}", rules.join(" and ")),
        };
        let more = match was > 0.0 {
            true => format!("{:+.1} % of the objective", 100.0 * (now / was - 1.0)),
            false => format!("{} instead of {}", number(now), number(was)),
        };
        Some(format!("{}: the rules cost {more}; without them {}, but {because}", joint.name, named(free)))
    }

    /// Leaves out, of each joint, first designs that break a rule that is no limit of the program: they are rejected with it.
    /// What is left passes its check. With `path` the text of the design file, at ratios that can be built; without, that of
    /// the optima. `None` where a joint has no design left.
    ///
    /// # Errors
    /// In words, a rule about the robot as a whole that is broken.
    pub fn keep(
        &self,
        result: &mut RobotResult,
        names: Names,
        (plain, catalog): (&Robot, &Catalog),
        path: Option<&Path>,
    ) -> Result<Option<DesignText>, String> {
        loop {
            if result.joints.iter().any(|joint| joint.candidates.is_empty()) {
                return Ok(None);
            }
            let designs: Vec<&Design> = result.joints.iter().map(|joint| &joint.candidates[0]).collect();
            let make = |(joint, design): (&JointResult, &&Design)| {
                path.and_then(|_| made_again(result.robot, joint.joint, catalog, design))
            };
            let made = result.joints.iter().zip(&designs).map(make).collect();
            let at = path.unwrap_or(Path::new("design.toml"));
            let text = self.text(result, "First choices", designs, made, names, at);
            let Some(rules) = &self.rules else { return Ok(Some(text)) };
            let broken = self.broken(&text.toml, at, (plain, catalog), rules, names)?;
            let Some((joint, why)) = broken.into_iter().next() else { return Ok(Some(text)) };
            let place = joint.and_then(|name| result.joints.iter().position(|j| j.joint.name == name));
            let Some(place) = place else { return Err(format!("the rules are not kept: {why}")) };
            let joint = &mut result.joints[place];
            let Design { motor, gear, .. } = joint.candidates.remove(0);
            joint.rejected.push(Rejected { motor, gear, reason: Reason::Rule(why) });
        }
    }

    /// The text of the design file of a whole robot: the first combination that passes the rules.
    ///
    /// # Errors
    /// In words, why there is none.
    pub fn whole(
        &self,
        result: &RobotResult,
        whole: &Choice,
        names: Names,
        ground: (&Robot, &Catalog),
        path: &Path,
    ) -> Result<DesignText, String> {
        self.first_kept(result, whole, names, ground, path).map(|(_, text)| text)
    }

    /// The place of that combination among all, and the text.
    fn first_kept(
        &self,
        result: &RobotResult,
        whole: &Choice,
        names: Names,
        (plain, catalog): (&Robot, &Catalog),
        path: &Path,
    ) -> Result<(usize, DesignText), String> {
        let without = without_choice(result, "no");
        // What it carries may be what a joint needs.
        if !without.is_empty() && whole.combinations.is_empty() {
            return Err(without.join("; "));
        }
        let mut last = "no combination of motors keeps the robot's budgets".to_string();
        for (place, combination) in whole.combinations.iter().enumerate() {
            let text = self.combined(result, whole, &combination.joints, (names, catalog), path);
            let Some(rules) = &self.rules else { return Ok((place, text)) };
            match self.broken(&text.toml, path, (plain, catalog), rules, names)?.into_iter().next() {
                None => return Ok((place, text)),
                Some((joint, why)) => {
                    last = format!(
                        "no combination that was found keeps all rules; of the last one at {}: {why}",
                        joint.unwrap_or_default()
                    );
                }
            }
        }
        Err(last)
    }

    /// The text of the design file of a combination.
    fn combined(
        &self,
        result: &RobotResult,
        whole: &Choice,
        joints: &[Design],
        (names, catalog): (Names, &Catalog),
        path: &Path,
    ) -> DesignText {
        // Where joints depend on each other one of them is not solved again by itself.
        let alone = !result.robot.is_coupled();
        let make = |(design, of): (&Design, &JointResult)| {
            alone.then(|| made_again(result.robot, of.joint, catalog, design)).flatten()
        };
        let made = joints.iter().zip(&result.joints).map(make).collect();
        let name = match whole.proof.certified() {
            true => "Best combination",
            false => "Best combination that was found, not proved",
        };
        self.text(result, name, joints.iter().collect(), made, names, path)
    }

    fn text(
        &self,
        result: &RobotResult,
        what: &str,
        designs: Vec<&Design>,
        made: Vec<Option<Made>>,
        names: Names,
        path: &Path,
    ) -> DesignText {
        let folder = path.parent().unwrap_or(Path::new(""));
        let catalog: Vec<PathBuf> = names.catalog.iter().map(|p| way(folder, p)).collect();
        let rules = self.path.as_ref().map(|p| way(folder, p));
        let designs: Vec<_> = designs.into_iter().zip(made).collect();
        let costs = building_costs(result, &designs);
        let toml = design_file::toml(&Written {
            result,
            what,
            designs,
            requirement: &way(folder, names.requirement),
            catalog: &catalog,
            rules: rules.as_deref(),
        });
        DesignText { toml, costs }
    }

    /// What keeps a design from passing its rules: errors, and rules that bound a measure, with their joint.
    fn broken(
        &self,
        text: &str,
        path: &Path,
        (plain, catalog): (&Robot, &Catalog),
        rules: &RulesFile,
        names: Names,
    ) -> Result<Vec<(Option<String>, String)>, String> {
        let source = Arc::new(Source::new(path.display().to_string(), text));
        let failed = |errors: Vec<crate::input::InputError>| {
            let said = errors.iter().flat_map(|e| &e.problems).map(|p| p.message.clone()).collect::<Vec<_>>();
            format!("the design that was made cannot be read: {}", said.join("; "))
        };
        let read = match names.given {
            Some(requirement) => DesignFile::read_for(&source, requirement, plain),
            None => DesignFile::read_source(&source),
        };
        let mut design = read.map_err(failed)?;
        design.robot = settle(design.robot, catalog)?;
        take_objectives(&mut design.robot, &self.robot);
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
}

/// A design file, and what ratios that can be built cost.
#[derive(Debug)]
pub struct DesignText {
    /// Its text.
    pub toml: String,
    /// Sentences.
    pub costs: Vec<String>,
}

fn named(design: &Design) -> String {
    let gear = design.gear.map_or_else(String::new, |gear| format!(" with {gear}"));
    format!("{}{gear} at N = {}", design.motor.id, design_ratio(design))
}

/// A design as it is built: with its train of gears, its ratio and its spring; `None` as for [`built`].
fn made_again(robot: &Robot, joint: &Joint, catalog: &Catalog, design: &Design) -> Option<Made> {
    built(robot, joint, catalog, design).map(|b| Made {
        train: b.train,
        ratio: b.design.optimum.ratio,
        spring: b.design.spring,
        objective: b.design.optimum.objective,
    })
}

/// Gives each joint the objective of the same joint of another robot, with what it is balanced from.
fn take_objectives(robot: &mut Robot, from: &Robot) {
    for (joint, from) in robot.joints.iter_mut().zip(&from.joints) {
        (joint.objective, joint.balancing) = (from.objective.clone(), from.balancing.clone());
    }
}
