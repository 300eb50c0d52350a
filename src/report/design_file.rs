//! A design file from the first choices of an optimisation.

use std::path::{Component, Path, PathBuf};

use super::number;
use crate::design::optimize::RobotResult;

/// The way from a folder to a file, both as they are on disk; the file's own path where one of them is not there.
pub fn way(folder: &Path, file: &Path) -> PathBuf {
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

/// The text of a design with the first choice of every joint.
///
/// # Errors
/// Names of the joints that no motor can do.
pub fn toml(result: &RobotResult, requirement: &Path, catalog: &[PathBuf]) -> Result<String, Vec<String>> {
    let without: Vec<String> =
        result.joints.iter().filter(|j| j.candidates.is_empty()).map(|j| j.joint.name.clone()).collect();
    if !without.is_empty() {
        return Err(without);
    }
    let text = |text: &str| toml::Value::String(text.into()).to_string();
    // A name in a comment stays in its line: names have no control characters.
    let mut out = format!(
        "# First choices of `gearwise optimize` {} for {}. Check with `gearwise check`.\nrequirement = {}\n",
        env!("CARGO_PKG_VERSION"),
        result.robot.name,
        quoted(requirement)
    );
    if !catalog.is_empty() {
        let paths: Vec<String> = catalog.iter().map(|p| quoted(p)).collect();
        out.push_str(&format!("catalog = [{}]\n", paths.join(", ")));
    }
    for joint in &result.joints {
        let design = &joint.candidates[0];
        let objective = &joint.joint.objective;
        let window = design.optimum.window();
        out.push_str(&format!(
            "\n# {} {} {}; first of {} motors that can do it",
            objective.name(),
            number(design.optimum.objective),
            objective.unit(),
            joint.candidates.len()
        ));
        if design.gear.is_none() {
            out.push_str(&format!("; feasible from {} to {}", number(window.min), number(window.max)));
        }
        out.push_str(&format!("\n[[joint]]\nname = {}\nmotor = {}\n", text(&joint.joint.name), text(&design.motor.id)));
        match design.gear {
            Some(gear) => out.push_str(&format!("gear = {}\n", text(gear))),
            None => out.push_str(&format!("ratio = {:?}\n", design.optimum.ratio)),
        }
        if let Some((stiffness, angle)) = design.spring.and_then(|s| Some((s.stiffness, s.rest_angle?))) {
            out.push_str(&format!(
                "spring = {{ stiffness = \"{stiffness:?} N*m/rad\", rest_angle = \"{angle:?} rad\" }}\n"
            ));
        }
    }
    Ok(out)
}
