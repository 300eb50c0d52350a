//! A design file from what an optimisation chose.

use std::path::{Component, Path, PathBuf};

use super::number;
use super::optimize::without_choice;
use crate::design::answer::{Design, RobotResult};
use crate::design::robot::Choice;

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

/// The text of a design with the best combination for the whole robot, where one was looked for, else with the
/// first choice of every joint.
///
/// # Errors
/// In words, why there is none.
pub fn toml(
    result: &RobotResult,
    whole: Option<&Choice>,
    requirement: &Path,
    catalog: &[PathBuf],
) -> Result<String, String> {
    let without = without_choice(result);
    if !without.is_empty() {
        return Err(without.join("; ").replace("NO ", "no "));
    }
    let (what, designs): (_, Vec<&Design>) = match whole {
        None => ("First choices", result.joints.iter().map(|j| &j.candidates[0]).collect()),
        Some(whole) => {
            let best = whole.combinations.first().ok_or("no combination of motors keeps the robot's budgets")?;
            ("Best combination", best.joints.iter().collect())
        }
    };
    let text = |text: &str| toml::Value::String(text.into()).to_string();
    // A name in a comment stays in its line: names have no control characters.
    let mut out = format!(
        "# {what} of `gearwise optimize` {} for {}. Check with `gearwise check`.\nrequirement = {}\n",
        env!("CARGO_PKG_VERSION"),
        result.robot.name,
        quoted(requirement)
    );
    if !catalog.is_empty() {
        let paths: Vec<String> = catalog.iter().map(|p| quoted(p)).collect();
        out.push_str(&format!("catalog = [{}]\n", paths.join(", ")));
    }
    for (joint, design) in result.joints.iter().zip(designs) {
        let objective = &joint.joint.objective;
        let window = design.optimum.window();
        out.push_str(&format!(
            "\n# {} {}; {} can do it alone",
            objective.name(),
            super::with_unit(design.optimum.objective, objective.unit()),
            crate::words::counted(joint.candidates.len(), "motor")
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
