//! A design file from what an optimisation chose.

use std::path::{Component, Path, PathBuf};

use super::said::per_cent;
use super::{design_ratio, number};
use gearwise_model::catalog::is_word;
use gearwise_model::requirement::{Joint, Stage, Train};
use gearwise_model::words::range_inwards;
use gearwise_select::answer::{Design, JointResult, RobotResult, SpringChoice};

/// The way from a folder to a file, both as they are on disk; the file's own path where one of them is not there.
pub fn way(folder: &Path, file: &Path) -> PathBuf {
    if file.to_str().is_some_and(is_word) {
        return file.to_path_buf();
    }
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let (Ok(from), Ok(to)) = (folder.canonicalize(), file.canonicalize()) else { return file.to_path_buf() };
    let (from, to): (Vec<Component>, Vec<Component>) = (from.components().collect(), to.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    // Another drive cannot be reached by going up.
    if common == 0 {
        return file.to_path_buf();
    }
    let up = from[common..].iter().map(|_| Component::ParentDir);
    up.chain(to[common..].iter().copied()).collect()
}

fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    toml::Value::String(if cfg!(windows) { text.replace('\\', "/") } else { text }).to_string()
}

/// A ratio that can be built.
#[derive(Debug, Clone)]
pub struct Made {
    /// Its gear, where one was found.
    pub train: Option<Train>,
    /// The ratio.
    pub ratio: f64,
    /// The spring there.
    pub spring: Option<SpringChoice>,
    /// The objective there.
    pub objective: f64,
}

/// What the ratios that can be built cost, a sentence for each joint that has one.
pub fn building_costs(result: &RobotResult, designs: &[(&Design, Option<Made>)]) -> Vec<String> {
    let of = |(joint, (design, made)): (&JointResult, &(&Design, Option<Made>))| {
        let made = made.as_ref()?;
        let (now, least) = (made.objective, design.optimum.objective);
        let (name, ratio, best) = (&joint.joint.name, number(made.ratio), design_ratio(design));
        let cost = match now / least - 1.0 {
            more if least > 0.0 && more > 0.0 => {
                format!("{} more {} than at N* = {best}", per_cent(more), joint.joint.goal())
            }
            _ => format!("{} {}, and {} at N* = {best}", joint.joint.goal(), number(now), number(least)),
        };
        Some(format!("{name}: written with N = {ratio}, which can be built: {cost}"))
    };
    result.joints.iter().zip(designs).filter_map(of).collect()
}

/// What a design file is made of.
#[derive(Debug)]
pub struct Written<'a, 'd> {
    /// What was found for the robot.
    pub result: &'a RobotResult<'a>,
    /// What the designs are, as in "First choices".
    pub what: &'a str,
    /// One design for each joint, and where its ratio was made buildable, that.
    pub designs: Vec<(&'a Design<'d>, Option<Made>)>,
    /// The way to the requirement.
    pub requirement: &'a Path,
    /// The ways to the catalogue's files; none for the built-in ones.
    pub catalog: &'a [PathBuf],
    /// The way to the rules file.
    pub rules: Option<&'a Path>,
}

/// The text of a design file.
pub fn toml(written: &Written) -> String {
    let Written { result, what, designs, requirement, catalog, rules } = written;
    let text = |text: &str| toml::Value::String(text.into()).to_string();
    // A name in a comment stays in its line: names have no control characters.
    let mut out = format!(
        "# {what} of `gearwise optimize` {} for {}. Check with `gearwise check`.\nrequirement = {}\n",
        env!("CARGO_PKG_VERSION"),
        result.robot.name,
        quoted(requirement)
    );
    if !result.robot.set.is_empty() {
        let set: Vec<String> = result.robot.set.iter().map(|(key, value)| format!("{} = {value}", text(key))).collect();
        out.push_str(&format!("set = {{ {} }}\n", set.join(", ")));
    }
    if !catalog.is_empty() {
        let paths: Vec<String> = catalog.iter().map(|p| quoted(p)).collect();
        out.push_str(&format!("catalog = [{}]\n", paths.join(", ")));
    }
    if let Some(rules) = rules {
        out.push_str(&format!("rules = {}\n", quoted(rules)));
    }
    for (joint, (optimal, built)) in result.joints.iter().zip(designs) {
        let objective = &joint.joint.objective;
        let (ratio, spring, value) = match built {
            Some(made) => (made.ratio, made.spring, made.objective),
            None => (optimal.optimum.ratio, optimal.spring, optimal.optimum.objective),
        };
        let design = optimal;
        let window = optimal.optimum.window();
        let least = match built {
            Some(_) => {
                format!(" ({} at `optimal_ratio`)", super::with_unit(design.optimum.objective, objective.unit()))
            }
            None => String::new(),
        };
        out.push_str(&format!(
            "\n# {} {}{least}; {} can do it alone",
            joint.joint.goal(),
            super::with_unit(value, objective.unit()),
            gearwise_model::words::counted(joint.candidates.len(), "motor")
        ));
        let gear = design.gear.or_else(|| super::family::point(joint.joint, ratio));
        if gear.is_none() {
            let [from, to] = range_inwards(window.min, window.max);
            out.push_str(&format!("; feasible from {from} to {to}"));
        }
        out.push_str(&format!("\n[[joint]]\nname = {}\nmotor = {}\n", text(&joint.joint.name), text(&design.motor.id)));
        match gear {
            Some(gear) => out.push_str(&format!("gear = {}\n", text(gear))),
            None => {
                let built = built_text(built.as_ref(), joint.joint, ratio);
                let among =
                    super::family::of_ratio(joint.joint, ratio).map_or_else(String::new, |line| format!("# {line}\n"));
                out.push_str(&format!("{among}ratio = {ratio:?}{built}\n"));
            }
        }
        if built.is_some() {
            out.push_str(&format!("optimal_ratio = {:?}\n", optimal.optimum.ratio));
        }
        if let Some((stiffness, angle)) = spring.and_then(|s| Some((s.stiffness, s.rest_angle?))) {
            out.push_str(&format!(
                "spring = {{ stiffness = \"{stiffness:?} N*m/rad\", rest_angle = \"{angle:?} rad\" }}\n"
            ));
        }
    }
    out
}

/// How a ratio can be built, as a comment behind it.
fn built_text(built: Option<&Made>, joint: &Joint, ratio: f64) -> String {
    let listed = joint.ratio.toothed(ratio).map(|gear| &gear.train);
    let Some(train) = built.and_then(|built| built.train.as_ref()).or(listed) else { return String::new() };
    let stage = |stage: &Stage| format!("sun {}, ring {}", stage.sun, stage.ring);
    let stages: Vec<String> = train.stages.iter().map(stage).collect();
    let example = if listed.is_some() { "" } else { "for example " };
    format!("  # {example}planetary: {}", stages.join("; "))
}
