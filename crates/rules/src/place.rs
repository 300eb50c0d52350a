//! Where a finding stands: a part of the design, of the requirement, or of the rules file, turned into file,
//! line and column.

use std::ops::Range;
use std::sync::Arc;

use gearwise_model::actuator::limits::{Key, asked_by};
use gearwise_model::input::{Source, Step, key_path, locate};
use gearwise_model::requirement::{DesignFile, JointDesign};

/// A part of the input that a finding is about.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// The motor of the joint in the design.
    Motor,
    /// Ratio or gear of the joint in the design.
    Reduction,
    /// The joint's table in the design.
    Joint,
    /// Where the design names its requirement.
    Design,
    /// Keys of the joint in the requirement; as deep as they are there.
    JointKey(&'static [&'static str]),
    /// Keys at the top of the requirement.
    RobotKey(&'static [&'static str]),
    /// Bytes of the rules file.
    Rules(Range<usize>),
}

/// A place in a file. Lines and columns from 1, columns in characters; the end is the first column that no
/// longer belongs to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Location {
    /// The file as it was named.
    pub file: String,
    /// First line.
    pub line: usize,
    /// First column.
    pub column: usize,
    /// Last line.
    pub end_line: usize,
    /// Column behind the last.
    pub end_column: usize,
    /// Of values of a program, which have no lines for people: the path of the key.
    pub key: Option<String>,
}

impl Location {
    /// The place of bytes in a source.
    pub fn of(source: &Source, span: &Range<usize>) -> Location {
        let (line, column) = source.position(span.start);
        let (mut end_line, mut end_column) = source.position(span.end.max(span.start));
        // A table may span many lines: its first says where it is.
        if end_line != line {
            let first = source.text()[span.start.min(source.text().len())..].lines().next().unwrap_or("");
            (end_line, end_column) = (line, column + first.trim_end().chars().count());
        }
        let key = source.is_of_values().then(|| key_path(source.text(), span));
        Location { file: clean(source.name()), line, column, end_line, end_column, key }
    }
}

/// A path without `.` and `folder/..` in it, with forward slashes: what the rest of a tool chain calls the file.
pub fn clean(path: &str) -> String {
    let path = if cfg!(windows) { path.replace('\\', "/") } else { path.to_string() };
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "." => {}
            ".." if parts.last().is_some_and(|p| !p.is_empty() && *p != "..") => {
                parts.pop();
            }
            "" if !parts.is_empty() => {}
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

/// Turns places into locations.
#[derive(Debug, Clone, Copy)]
pub struct Places<'a> {
    /// The design.
    pub design: &'a DesignFile,
    /// The rules file, where there is one.
    pub rules: Option<&'a Arc<Source>>,
}

impl Places<'_> {
    /// Where a place is; of a joint where it belongs to one.
    pub fn locate(&self, place: &Place, joint: Option<&JointDesign>) -> Location {
        let design = self.design;
        let in_design = |span: &Range<usize>| Location::of(&design.source, span);
        let in_requirement = |steps: &[Step]| {
            let names = steps.iter().map(|(Step::Key(name) | Step::Named(name))| *name);
            if let Some((source, span)) = design.set.written(&names.collect::<Vec<_>>()) {
                return Location::of(source, &span);
            }
            let span = locate(&design.requirement, steps).unwrap_or(0..0);
            Location::of(&design.requirement, &span)
        };
        match (place, joint) {
            (Place::Motor, Some(joint)) => in_design(&joint.motor_span),
            (Place::Reduction, Some(joint)) => in_design(&joint.reduction_span),
            (Place::Joint, Some(joint)) => in_design(&joint.span),
            (Place::JointKey(keys), Some(joint)) => {
                let mut steps = vec![Step::Key("joint"), Step::Named(&joint.name)];
                steps.extend(keys.iter().map(|key| Step::Key(key)));
                in_requirement(&steps)
            }
            (Place::RobotKey(keys), _) => in_requirement(&keys.iter().map(|k| Step::Key(k)).collect::<Vec<_>>()),
            (Place::Rules(span), _) => match self.rules {
                Some(source) => Location::of(source, span),
                None => in_design(&design.requirement_span),
            },
            _ => in_design(&design.requirement_span),
        }
    }
}

/// Where the requirement asks for a limit, by the limit's name and owner; `None` where a data sheet does.
pub(crate) fn asked_for(limit: &str, owner: &str) -> Option<Place> {
    asked_by(limit, owner).map(|key| match key {
        Key::Robot(keys) => Place::RobotKey(keys),
        Key::Joint(keys) => Place::JointKey(keys),
    })
}

#[cfg(test)]
mod tests {
    use super::clean;

    #[test]
    fn paths_are_cleaned() {
        assert_eq!(clean("./robots/leg/../robot.toml"), "robots/robot.toml");
        assert_eq!(clean("../robot.toml"), "../robot.toml");
        assert_eq!(clean("/a//b/./c.toml"), "/a/b/c.toml");
        assert_eq!(clean("/../c.toml"), "/../c.toml");
    }
}
