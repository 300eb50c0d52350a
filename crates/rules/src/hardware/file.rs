//! The file that says which hardware drives which joints (TOML).

use std::ops::Range as Span;
use std::path::Path;
use std::sync::Arc;

use gearwise_model::catalog::matches_pattern;
use gearwise_model::input::{Description, Form, InputError, Key, Problem, Range, Section, Source, key};
use gearwise_model::transmission::read::{Files, read_way};
use gearwise_model::units;

/// What of a motor is between it and the flange.
#[derive(Debug, Clone, PartialEq)]
pub enum Reduction {
    /// A gear of the catalogue.
    Gear(String, Span<usize>),
    /// A ratio N alone.
    Ratio(f64),
}

/// Which rows drive a joint.
#[derive(Debug, Clone, PartialEq)]
pub enum Which {
    /// A module, by its id.
    Module(String, Span<usize>),
    /// A motor, by its id, with what is behind it.
    Motor(String, Span<usize>, Reduction),
}

/// Turns of an actuator for one of its joint, r.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turns {
    /// The smallest over the joint's range.
    pub least: f64,
    /// The largest.
    pub most: f64,
}

/// Hardware at some joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Mount {
    /// Patterns of names of joints, each with its place.
    pub names: Vec<(String, Span<usize>)>,
    /// The rows.
    pub which: Which,
    /// Turns of the actuator for one of the joint, r.
    pub transmission: Turns,
    /// Supply voltage \[V\].
    pub voltage: Option<f64>,
    /// Largest current of the drive behind which a motor is, amplitude of a phase \[A\].
    pub drive_current: Option<f64>,
    /// Efficiency of a gear whose row gives none, or that has no row.
    pub efficiency: Option<f64>,
    /// Where it is.
    pub span: Span<usize>,
}

impl Mount {
    /// Whether it drives the joint of this name.
    pub fn drives(&self, joint: &str) -> bool {
        self.names.iter().any(|(pattern, _)| matches_pattern(pattern, joint))
    }
}

/// Two joints that two actuators drive together.
#[derive(Debug, Clone, PartialEq)]
pub struct Coupling {
    /// Names of the joints.
    pub joints: [String; 2],
    /// J: speeds of the actuators are J times the speeds of the joints.
    pub matrix: [[f64; 2]; 2],
    /// Where it is.
    pub span: Span<usize>,
}

/// By how much a model may differ, as shares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Torque and speed.
    pub limits: f64,
    /// Inertia.
    pub armature: f64,
    /// Friction.
    pub friction: f64,
}

impl Default for Tolerances {
    fn default() -> Tolerances {
        Tolerances { limits: 0.05, armature: 0.2, friction: 0.5 }
    }
}

/// A file of hardware.
#[derive(Debug, Clone)]
pub struct HardwareFile {
    /// The file.
    pub source: Arc<Source>,
    /// Hardware at joints, in the order of the file.
    pub mounts: Vec<Mount>,
    /// Joints that are driven together.
    pub couplings: Vec<Coupling>,
    /// By how much a model may differ.
    pub tolerances: Tolerances,
}

impl HardwareFile {
    /// Problems with joints that two entries name, one for each pair of entries.
    pub fn driven_twice<'n>(&self, joints: impl Iterator<Item = &'n str>) -> Vec<Problem> {
        let mut problems: Vec<Problem> = Vec::new();
        for joint in joints {
            let mut named = self.mounts.iter().filter(|mount| mount.drives(joint));
            let (Some(_), Some(second)) = (named.next(), named.next()) else { continue };
            let pattern = second.names.iter().find(|(pattern, _)| matches_pattern(pattern, joint));
            let span = pattern.map_or_else(|| second.span.clone(), |(_, span)| span.clone());
            if problems.iter().any(|p| p.span.as_ref() == Some(&span)) {
                continue;
            }
            let problem = Problem::at(span, format!("joint `{joint}` is named by two [[joint]]"), "second time");
            problems.push(problem.help("narrow one of the patterns: a joint has one hardware"));
        }
        problems
    }
}

/// Reads a file of hardware (`-` is standard input).
///
/// # Errors
/// Every mistake in it.
pub fn read(path: &Path) -> Result<HardwareFile, Vec<InputError>> {
    let source = Source::argument(path).map_err(|e| vec![e])?;
    let mut errors = Vec::new();
    let read = Form::read(&source, |root| {
        read_root(root, &mut Files { open: &mut |path| Source::read(path), errors: &mut errors })
    });
    Form::with_others(read, errors)
}

/// What the reader asks for.
pub fn describe() -> Description {
    let skeleton = "[[joint]]\ntransmission = { four_bar = {}, lever = {} }\n[[coupling]]\n[limits]\n";
    Form::describe(skeleton, |root| {
        read_root(root, &mut Files { open: &mut |path| Source::read(path), errors: &mut Vec::new() })
    })
}

const JOINT: Key = key("joint", "hardware at joints of the model");
const MODULE: Key = key("module", "id of a module of the catalogue").value("id").or("motor");
const MOTOR: Key = key("motor", "id of a motor of the catalogue; with `gear` or `ratio`").value("id").or("module");
const GEAR: Key = key("gear", "id of a gear of the catalogue behind the motor").value("id").or("ratio");
const RATIO: Key = key("ratio", "ratio N behind the motor, where no gear is named");

/// Keys that go with a motor and not with a module.
const OF_MOTOR: &[&str] = &["gear", "ratio", "efficiency", "drive_current"];

fn read_root(root: &Section, files: &mut Files) -> Option<HardwareFile> {
    let sections = root.sections(JOINT);
    let mut mounts = Vec::new();
    if sections.is_empty() && root.noted() == 0 {
        root.missing("joint", "a [[joint]] with names = [\"*_knee\"] and module = \"robstride-rs04\"");
    }
    for section in sections {
        mounts.extend(mount(&section, files));
        section.finish();
    }
    let couplings = root.sections(key("coupling", "two joints that two actuators drive together"));
    let couplings = couplings.into_iter().filter_map(|section| {
        let read = coupling(&section);
        section.finish();
        read
    });
    let couplings = couplings.collect();
    let mut tolerances = Tolerances::default();
    if let Some(section) = root.section(key("limits", "by how much a model may differ")) {
        for (key, to) in [
            (key("tolerance", "share of torque and speed").default("0.05"), &mut tolerances.limits),
            (key("armature_tolerance", "share of inertia").default("0.2"), &mut tolerances.armature),
            (key("friction_tolerance", "share of friction").default("0.5"), &mut tolerances.friction),
        ] {
            *to = section.number(key, Range::Share).unwrap_or(*to);
        }
        section.finish();
    }
    Some(HardwareFile { source: root.source().clone(), mounts, couplings, tolerances })
}

fn mount(section: &Section, files: &mut Files) -> Option<Mount> {
    let noted = section.noted();
    if !section.has("names") {
        section.missing("names", "[\"*_knee\"]");
    }
    let names = section.texts(key("names", "names of joints, `*` for any run of characters").required());
    let names: Vec<_> = names.unwrap_or_default().into_iter().map(|n| (n.get_ref().clone(), n.span())).collect();
    let id = |key: Key| section.has(key).then(|| section.required_text(key, "\"an-id\"")).flatten();
    let (module, motor) = (id(MODULE), id(MOTOR));
    let (gear, ratio) = (id(GEAR), section.number(RATIO, Range::Positive));
    let voltage = section.quantity(
        key("voltage", "of the supply; a lower one than the row's takes from the speed").default("that of the row"),
        &units::VOLTAGE,
        Range::Positive,
    );
    let drive_current = section.quantity(
        key("drive_current", "largest of a motor's drive, amplitude of a phase: it bounds the peak torque"),
        &units::CURRENT,
        Range::Positive,
    );
    let efficiency = section
        .number(key("efficiency", "of the gear behind a motor, where no row gives it").default("1"), Range::Fraction);
    let transmission = match section.section(key("transmission", "what is between the actuator and the joint")) {
        Some(inner) => {
            let read = turns(&inner, files);
            inner.finish();
            read?
        }
        None => Turns { least: 1.0, most: 1.0 },
    };
    let wrong = |key: &'static str, message: &str, label: &str| {
        section.note(Problem::at(section.span_of(key), message, label));
        None
    };
    let which = match (module, motor) {
        (Some(_), Some(_)) => {
            return wrong("motor", "a joint has a `module` or a `motor`, not both", "remove one of the two");
        }
        (Some(_), None) if OF_MOTOR.iter().any(|key| section.has(*key)) => {
            let key = OF_MOTOR.iter().find(|key| section.has(**key)).copied().unwrap_or("ratio");
            let label = "write `transmission = { ratio = … }` for what is behind it";
            return wrong(key, "a module has its gear inside", label);
        }
        (Some(module), None) => Which::Module(module.get_ref().clone(), module.span()),
        (None, Some(motor)) => {
            let reduction = match (gear, ratio) {
                (Some(_), Some(_)) => {
                    return wrong("ratio", "a joint has a `gear` or a `ratio`, not both", "remove one of the two");
                }
                (Some(gear), None) => Reduction::Gear(gear.get_ref().clone(), gear.span()),
                (None, Some(ratio)) => Reduction::Ratio(ratio),
                (None, None) => {
                    if section.noted() == noted {
                        section.missing("gear", "\"a-gear\", or ratio = 9, or ratio = 1 where there is no gear");
                    }
                    return None;
                }
            };
            Which::Motor(motor.get_ref().clone(), motor.span(), reduction)
        }
        (None, None) => {
            if section.noted() == noted {
                section.missing("module", "\"robstride-rs04\", or motor = \"t-motor-ri50\" with gear or ratio");
            }
            return None;
        }
    };
    Some(Mount { names, which, transmission, voltage, drive_current, efficiency, span: section.span() })
}

/// How many turns of the actuator make one of the joint, over its range where that matters.
fn turns(section: &Section, files: &mut Files) -> Option<Turns> {
    let about = "with what is no `ratio`: the joint's range, over which r is looked at";
    let range = section.quantity_range(key("range", about), &units::ANGLE, Range::Any);
    let way = read_way(section, files)?;
    if let Some(ratio) = way.constant() {
        return Some(Turns { least: ratio.abs(), most: ratio.abs() });
    }
    if !section.has("range") {
        section.missing("range", "[\"-40 deg\", \"30 deg\"]");
    }
    let [low, high] = range?;
    let way = way.around(0.5 * (low + high));
    match way.ratios(low, high) {
        Ok([least, most]) => Some(Turns { least, most }),
        Err(fault) => {
            let problem = Problem::at(section.span_of("range"), fault.to_string(), "in this range");
            let help = "compare the range with the transmission's: their zero, their unit, their direction";
            section.note(problem.help(help));
            None
        }
    }
}

fn coupling(section: &Section) -> Option<Coupling> {
    for (key, example) in
        [("joints", "[\"left_ankle_pitch\", \"left_ankle_roll\"]"), ("matrix", "[[1, 0.5], [1, -0.5]]")]
    {
        if !section.has(key) {
            section.missing(key, example);
        }
    }
    let joints = section.texts(key("joints", "names of the two joints").required());
    let matrix = section.matrix(
        key("matrix", "J, two rows of two: speeds of the actuators are J times those of the joints").required(),
    );
    let joints: Vec<String> = joints?.into_iter().map(|t| t.into_inner()).collect();
    let Ok(joints) = <[String; 2]>::try_from(joints) else {
        section.note(Problem::at(section.span_of("joints"), "`joints` of a coupling are two", "expected two names"));
        return None;
    };
    let rows: Vec<[f64; 2]> = matrix?.into_iter().filter_map(|row| <[f64; 2]>::try_from(row).ok()).collect();
    let matrix = <[[f64; 2]; 2]>::try_from(rows).ok();
    let matrix = matrix.filter(|m| (m[0][0] * m[1][1] - m[0][1] * m[1][0]).abs() > 1e-9);
    if matrix.is_none() {
        let label = "expected two rows of two numbers that are no multiples of each other";
        section.note(Problem::at(section.span_of("matrix"), "`matrix` of a coupling cannot be inverted", label));
    }
    Some(Coupling { joints, matrix: matrix?, span: section.span() })
}
