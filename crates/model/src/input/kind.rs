//! What a file is, where it is not what was wanted: one line in place of all its keys.
//!
//! The one idea: nothing is refused for what it looks like. Only a file that could not be read as what was wanted is
//! looked at again, and only where it is plainly something else is that said in place of its mistakes.

use toml::de::{DeTable, DeValue};

use super::{InputError, Problem, Source};

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// What a robot asks for.
    Requirement,
    /// What was chosen.
    Design,
    /// Rules for designs.
    Rules,
    /// Logs of a test with what was tested.
    Bench,
    /// A grid over requirements.
    Study,
    /// The rows that a design used.
    Lock,
    /// A fitted actuator, in place of a row.
    Fitted,
    /// Rows of motors.
    Motors,
    /// Rows of gears.
    Gears,
    /// A family of gears, each a point of it.
    Family,
    /// The gears of a family over the ratio.
    GearMap,
    /// Torque and speed of a joint over time.
    Motion,
    /// Any other table over time: positions of joints, a log.
    OverTime,
    /// A description of a robot: URDF or MJCF.
    Description,
    /// Another table.
    Table,
    /// A result of gearwise, or another text for programs.
    Json,
    /// A picture.
    Picture,
    /// A page.
    Page,
    /// Another XML text.
    Xml,
    /// Nothing.
    Empty,
}

impl FileKind {
    /// What it is called, with its article.
    pub fn name(self) -> &'static str {
        match self {
            FileKind::Requirement => "a requirement",
            FileKind::Design => "a design",
            FileKind::Rules => "a rules file",
            FileKind::Bench => "a bench file",
            FileKind::Study => "a study file",
            FileKind::Lock => "the lock of a design",
            FileKind::Fitted => "a fitted actuator",
            FileKind::Motors => "a catalogue of motors",
            FileKind::Gears => "a catalogue of gears",
            FileKind::Family => "a gear family",
            FileKind::GearMap => "a gear map",
            FileKind::Motion => "a motion",
            FileKind::OverTime => "a table over time",
            FileKind::Description => "a description of a robot",
            FileKind::Table => "a table",
            FileKind::Json => "a JSON text",
            FileKind::Picture => "a picture",
            FileKind::Page => "a page",
            FileKind::Xml => "an XML text",
            FileKind::Empty => "an empty file",
        }
    }

    /// What it is called where it is wanted.
    fn wanted(self) -> &'static str {
        match self {
            FileKind::OverTime => "a trajectory (`time`, and a column for each joint)",
            FileKind::Motors => "a catalogue of motors or gears",
            FileKind::GearMap => "a gear map (`ratio`, and a column for each number of the gear)",
            other => other.name(),
        }
    }

    /// Where such a file is asked for.
    fn goes(self) -> Option<&'static str> {
        Some(match self {
            FileKind::Requirement => "`gearwise optimize`, `sweep`, `explain` and `study` take a requirement",
            FileKind::Design => "`gearwise check` and `export` take a design",
            FileKind::Rules => "`--rules` takes it, or `rules = ` in a design",
            FileKind::Bench => "`gearwise identify` and `characterize` take a bench file",
            FileKind::Study => "`gearwise study` takes a study file",
            FileKind::Lock => "`gearwise check` finds it next to the design",
            FileKind::Fitted => "`--also` takes it in place of a row, or `actuator = ` of a joint in a design",
            FileKind::Motors | FileKind::Gears => "`--also` and `--catalog` take a catalogue",
            FileKind::Family => "`--also` and `--catalog` take it, and a joint of a requirement names it: `family = `",
            FileKind::Motion => "a joint of a requirement names it: `motion = `",
            FileKind::GearMap => "the gear of a joint in a requirement names it: `map = `",
            FileKind::Description => "`gearwise torques` takes it, or `[mechanism]` in a requirement",
            _ => return None,
        })
    }
}

/// What a text plainly is, and what shows it; `None` where nothing does.
pub fn recognise(source: &Source) -> Option<(FileKind, String)> {
    let text = source.text().trim_start();
    match text.chars().next() {
        None => Some((FileKind::Empty, String::new())),
        Some('<') => xml(text),
        Some('{') => {
            let own = text.contains("\"schema_version\"") && text.contains("\"command\"");
            Some((FileKind::Json, if own { "a result of gearwise".into() } else { String::new() }))
        }
        _ => toml(source).or_else(|| table(source)),
    }
}

/// The mistakes of a file that was read as one of `wanted`, the first of which is what was asked for; or the one line that it
/// is something else.
pub fn instead(error: InputError, wanted: &[FileKind]) -> InputError {
    // What could not be opened or is no text has no text to look at.
    let unread = error.source.text().is_empty() && error.problems.iter().all(|p| p.span.is_none());
    let (Some((found, shown)), Some(first)) = (recognise(&error.source).filter(|_| !unread), wanted.first()) else {
        return error;
    };
    if wanted.contains(&found) {
        return error;
    }
    let shown = if shown.is_empty() { shown } else { format!(" ({shown})") };
    let problem = Problem::whole(format!("this is {}{shown}; {} is wanted", found.name(), first.wanted()));
    let problem = match found.goes() {
        Some(goes) => problem.help(goes),
        None => problem,
    };
    InputError { source: error.source, problems: vec![problem] }
}

/// The same for the mistakes of a file and of those that it names: where it is something else, that alone is said.
pub fn instead_of_all(errors: Vec<InputError>, source: &Source, wanted: &[FileKind]) -> Vec<InputError> {
    let own = errors.iter().position(|e| std::ptr::eq(&*e.source, source));
    let Some(error) = own.map(|k| errors[k].clone()) else { return errors };
    let (before, told) = (error.problems.clone(), instead(error, wanted));
    if told.problems == before { errors } else { vec![told] }
}

fn xml(text: &str) -> Option<(FileKind, String)> {
    let mut rest = text;
    // Past declarations and comments.
    while rest.starts_with("<?") || rest.starts_with("<!") {
        let end = if rest.starts_with("<!--") { "-->" } else { ">" };
        rest = rest[rest.find(end)? + end.len()..].trim_start();
    }
    let root: String = rest.strip_prefix('<')?.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    let kind = match root.to_ascii_lowercase().as_str() {
        "robot" | "mujoco" => FileKind::Description,
        "svg" => FileKind::Picture,
        "html" => FileKind::Page,
        _ => FileKind::Xml,
    };
    Some((kind, format!("root element `{root}`")))
}

/// The first line that is neither blank nor a comment.
fn first_line(source: &Source) -> Option<&str> {
    source.text().lines().find(|line| !line.starts_with('#') && !line.trim().is_empty())
}

fn toml(source: &Source) -> Option<(FileKind, String)> {
    // The parser takes some 25 times the memory of a table to find that it is no TOML.
    first_line(source).filter(|line| line.contains('=') || line.trim_start().starts_with(['[', '#']))?;
    let (table, errors) = DeTable::parse_recoverable(source.text());
    let table = table.get_ref();
    if !errors.is_empty() || table.is_empty() {
        return None;
    }
    let has = |key: &str| table.contains_key(key);
    let list = |key: &str| table.get(key).is_some_and(|v| v.get_ref().as_array().is_some());
    let of_joint = |key: &str| {
        let joints = table.get("joint").and_then(|v| v.get_ref().as_array());
        let has = |joint: &DeValue| joint.as_table().is_some_and(|t| t.contains_key(key));
        joints.is_some_and(|all| all.iter().any(|joint| has(joint.get_ref())))
    };
    let shown =
        |keys: &[&str]| format!("keys {}", keys.iter().map(|k| format!("`{k}`")).collect::<Vec<_>>().join(", "));
    let known: &[(FileKind, bool, &[&str])] = &[
        (FileKind::Lock, has("version") && has("design") && has("robot"), &["version", "robot", "design"]),
        (FileKind::Study, has("grid"), &["grid"]),
        (FileKind::Study, has("requirements"), &["requirements"]),
        (FileKind::Design, has("requirement") && list("joint"), &["requirement", "joint"]),
        (FileKind::Study, has("requirement"), &["requirement"]),
        (FileKind::Bench, list("log"), &["log"]),
        (FileKind::Bench, has("terminals"), &["terminals"]),
        (FileKind::Bench, has("kind") && has("actuator"), &["kind", "actuator"]),
        (FileKind::Design, !has("bus") && (of_joint("motor") || of_joint("actuator")), &["joint"]),
        (FileKind::Requirement, has("bus") && has("joint"), &["bus", "joint"]),
        (FileKind::Requirement, list("joint"), &["joint"]),
        (FileKind::Requirement, has("bus"), &["bus"]),
        (FileKind::Rules, list("rule"), &["rule"]),
        (FileKind::Rules, list("allow"), &["allow"]),
        (FileKind::Motors, list("motor"), &["motor"]),
        (FileKind::Gears, list("gear"), &["gear"]),
        (FileKind::Family, list("point"), &["point"]),
        (FileKind::Fitted, has("motor"), &["motor"]),
        (FileKind::Fitted, has("axis"), &["axis"]),
    ];
    known.iter().find(|(_, is, _)| *is).map(|(kind, _, keys)| (*kind, shown(keys)))
}

fn table(source: &Source) -> Option<(FileKind, String)> {
    let header = first_line(source)?;
    if header.contains('=') || header.starts_with('[') || !header.contains(',') {
        return None;
    }
    let names: Vec<&str> = header.split(',').map(|c| c.split('[').next().unwrap_or("").trim()).collect();
    if names.iter().any(|n| n.is_empty() || n.chars().count() > 60) {
        return None;
    }
    let has = |name: &str| names.contains(&name);
    let kind = if has("id") && has("ratio") && !has("torque_constant") && !has("terminals") {
        FileKind::Gears
    } else if has("id") && ["torque_constant", "terminals", "resistance"].iter().any(|n| has(n)) {
        FileKind::Motors
    } else if has("ratio") && !has("id") && !has("time") {
        FileKind::GearMap
    } else if has("torque") && has("time") {
        FileKind::Motion
    } else if has("time") {
        FileKind::OverTime
    } else {
        FileKind::Table
    };
    let shown: Vec<String> = names.iter().take(3).map(|n| format!("`{n}`")).collect();
    let more = if names.len() > 3 { ", …" } else { "" };
    Some((kind, format!("columns {}{more}", shown.join(", "))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(text: &str) -> Option<FileKind> {
        recognise(&Source::new("x", text)).map(|(kind, _)| kind)
    }

    #[test]
    fn a_text_is_known_by_what_only_it_has() {
        for (text, is) in [
            ("name = 'a'\n[bus]\nvoltage = '48 V'\n[[joint]]\nname = 'k'", FileKind::Requirement),
            ("requirement = 'r.toml'\n[[joint]]\nmotor = 'm'", FileKind::Design),
            ("requirement = 'r.toml'\n[grid]\n'bus.voltage' = ['24 V']", FileKind::Study),
            ("[[rule]]\nrule = 'GW106'", FileKind::Rules),
            ("kind = 'free'\nactuator = { ratio = 3 }\n[[log]]\nfile = 'a.csv'", FileKind::Bench),
            ("version = 1\nrobot = 'r'\ndesign = 'd.toml'", FileKind::Lock),
            ("[motor]\nid = 'a'", FileKind::Fitted),
            ("name = 'a'\n[[point]]\nratio = 4", FileKind::Family),
            ("time [s], torque [N*m], velocity [rad/s]\n0,1,2", FileKind::Motion),
            ("# who\n\nid,kind,ratio\n", FileKind::Gears),
            ("id,terminals,torque_constant [N*m/A]\n", FileKind::Motors),
            ("ratio,efficiency,mass [g]\n", FileKind::GearMap),
            ("time [s], knee [rad]\n", FileKind::OverTime),
            ("<?xml version='1.0'?>\n<!-- a -->\n<robot name='a'/>", FileKind::Description),
            ("<mujoco/>", FileKind::Description),
            ("<svg xmlns='a'/>", FileKind::Picture),
            ("{\"schema_version\": 1, \"command\": \"optimize\"}", FileKind::Json),
            (" \n", FileKind::Empty),
        ] {
            assert_eq!(kind(text), Some(is), "{text}");
        }
        // A file with a slip is not another kind of file.
        for text in ["hello", "name = 'a, b'\n[bus\n", "name = 'leg'", "[bus\nvoltage = 1, 2", "a;b\n1;2"] {
            assert_eq!(kind(text), None, "{text}");
        }
    }

    #[test]
    fn what_was_wanted_keeps_its_mistakes() {
        let error = |text: &str| {
            let source = std::sync::Arc::new(Source::new("x", text));
            InputError { source, problems: vec![Problem::at(0..1, "first", ""), Problem::at(0..1, "second", "")] }
        };
        let told = |text: &str, wanted: &[FileKind]| instead(error(text), wanted).problems;
        assert_eq!(told("[bus]\nvoltag = 1", &[FileKind::Requirement]).len(), 2);
        assert_eq!(told("knee", &[FileKind::Requirement]).len(), 2);
        let [one] = &told("time [s],torque [N*m]\n", &[FileKind::Requirement])[..] else { panic!("one line") };
        assert_eq!(one.message, "this is a motion (columns `time`, `torque`); a requirement is wanted");
    }
}
