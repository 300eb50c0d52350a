//! What a robot model states of its joints: limits, inertia, friction, gear, each number with its place.
//!
//! The one idea: nothing is simulated, so nothing of a model is a mistake that does not touch these numbers. Closed loops,
//! tendons, joints that follow others, meshes and classes of defaults are read past or resolved; a number that is none is
//! refused at its place.

mod limits;
mod mjcf;
mod sdf;
mod urdf;
mod write;
pub use mjcf::gear_of;
pub use write::{Change, Written};

use std::collections::HashSet;
use std::ops::Range as Span;
use std::path::Path;
use std::sync::Arc;

use super::xml::{El, Sheet, span};
use crate::input::kind::{self, FileKind};
use crate::input::{InputError, Problem, Source};

/// What a model states of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Largest torque at the joint \[N·m\].
    Effort,
    /// Largest speed of the joint \[rad/s\].
    Velocity,
    /// Inertia of the actuator at the joint \[kg·m²\].
    Armature,
    /// Coulomb friction at the joint \[N·m\].
    Friction,
    /// Viscous friction at the joint \[N·m·s/rad\].
    Damping,
    /// Torque at the joint per unit of the actuator's force.
    Gear,
    /// Torque at standstill of the torque–speed line at the joint \[N·m\].
    Saturation,
}

impl Quantity {
    /// All with their names, which are the keys of a JSON file of limits.
    pub const NAMES: &[(&str, Quantity)] = &[
        ("effort", Quantity::Effort),
        ("velocity", Quantity::Velocity),
        ("armature", Quantity::Armature),
        ("friction", Quantity::Friction),
        ("damping", Quantity::Damping),
        ("gear", Quantity::Gear),
        ("saturation", Quantity::Saturation),
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        Quantity::NAMES.iter().find(|(_, q)| *q == self).map_or("", |(name, _)| name)
    }

    /// Its SI unit; `1` for a pure number.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Effort | Quantity::Friction | Quantity::Saturation => "N*m",
            Quantity::Velocity => "rad/s",
            Quantity::Armature => "kg*m^2",
            Quantity::Damping => "N*m*s/rad",
            Quantity::Gear => "1",
        }
    }
}

/// A number that a model states of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// What of the joint.
    pub quantity: Quantity,
    /// Its value at the joint, SI.
    pub value: f64,
    /// Where it is.
    pub span: Span<usize>,
    /// What it is called there, in words: `effort`, `forcerange × gear`.
    pub called: String,
    /// How it is written again; `None` where it cannot be.
    pub slot: Option<Slot>,
    /// Whether the actuator's gear is a factor of it.
    pub by_gear: bool,
}

/// A place in a model's text where a number can be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Slot {
    /// What is replaced; empty where something is put in.
    pub at: Span<usize>,
    /// What is written before the number.
    pub before: String,
    /// What is written behind it.
    pub after: String,
    /// What a value at the joint is multiplied with.
    pub factor: f64,
    /// Whether it is written as a range, `-x x`.
    pub is_range: bool,
}

impl Slot {
    /// In the place of a number that is there.
    fn replace(at: Span<usize>) -> Slot {
        Slot { at, before: String::new(), after: String::new(), factor: 1.0, is_range: false }
    }

    /// A new attribute.
    fn attribute(at: usize, name: &str) -> Slot {
        Slot { at: at..at, before: format!(" {name}=\""), after: "\"".into(), factor: 1.0, is_range: false }
    }

    /// The text that is written for a value at the joint (SI).
    pub fn text(&self, value: f64) -> String {
        let number = crate::words::number(value * self.factor);
        let number = if self.is_range { format!("-{number} {number}") } else { number };
        format!("{}{number}{}", self.before, self.after)
    }
}

/// A joint of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Where its name is.
    pub span: Span<usize>,
    /// Whether it turns; else it slides.
    pub turns: bool,
    /// Whether it follows another joint, or nothing drives it.
    pub is_passive: bool,
    /// Index of the link that it hangs on; `None` for the world, and where the model does not say it.
    pub parent: Option<usize>,
    /// Every number that the model states; of one quantity there may be several.
    pub stated: Vec<Stated>,
    /// Where a number can be written that is not stated.
    pub blank: Vec<(Quantity, Slot)>,
}

impl Joint {
    /// A joint of which nothing is stated yet.
    fn blank(name: &str, span: Span<usize>, turns: bool) -> Joint {
        let (stated, blank) = (Vec::new(), Vec::new());
        Joint { name: name.into(), span, turns, is_passive: false, parent: None, stated, blank }
    }

    /// A joint that turns or slides by its `type`, as URDF and SDFormat name it; `None` of others, and of one without a name.
    fn of_type(sheet: &Sheet, node: El, names: &mut HashSet<String>) -> Option<Joint> {
        let turns = match node.attribute("type")? {
            "revolute" | "continuous" => true,
            "prismatic" => false,
            _ => return None,
        };
        let name = sheet.required(node, "name")?;
        sheet.unique(node, "joints", name, names);
        let at = node.attribute_node("name").map_or_else(|| span(node), |a| a.range_value());
        Some(Joint::blank(name, at, turns))
    }

    /// What counts of a quantity: the least effort, else the only value.
    pub fn get(&self, quantity: Quantity) -> Option<&Stated> {
        self.stated.iter().filter(|s| s.quantity == quantity).min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Every statement of a quantity.
    pub fn all(&self, quantity: Quantity) -> impl Iterator<Item = &Stated> {
        self.stated.iter().filter(move |s| s.quantity == quantity)
    }

    /// Where a quantity can be written: where it is stated, else where it would be.
    pub fn slot(&self, quantity: Quantity) -> Option<&Slot> {
        match self.get(quantity) {
            Some(stated) => stated.slot.as_ref(),
            None => self.blank.iter().find(|(q, _)| *q == quantity).map(|(_, slot)| slot),
        }
    }
}

/// A link or body of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// Its mass with its place, where the model states one \[kg\].
    pub mass: Option<(f64, Span<usize>)>,
}

/// Which form a model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// URDF.
    Urdf,
    /// MJCF.
    Mjcf,
    /// SDFormat.
    Sdf,
    /// A table of limits (JSON).
    Limits,
}

impl Form {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Form::Urdf => "URDF",
            Form::Mjcf => "MJCF",
            Form::Sdf => "SDFormat",
            Form::Limits => "limits (JSON)",
        }
    }

    /// Whether a model of this form can state a quantity at all.
    pub fn has(self, quantity: Quantity) -> bool {
        match self {
            Form::Limits => true,
            Form::Urdf | Form::Sdf => !matches!(quantity, Quantity::Armature | Quantity::Gear | Quantity::Saturation),
            Form::Mjcf => !matches!(quantity, Quantity::Velocity | Quantity::Saturation),
        }
    }
}

/// What a model states of its joints.
#[derive(Debug, Clone)]
pub struct Model {
    /// The file.
    pub source: Arc<Source>,
    /// Its form.
    pub form: Form,
    /// Name of the robot.
    pub name: String,
    /// Its joints that move, in the order of the file.
    pub joints: Vec<Joint>,
    /// Its links.
    pub links: Vec<Link>,
    /// What was passed over and may hold something.
    pub notes: Vec<String>,
}

impl Model {
    /// Reads a model (`-` is standard input): JSON where it begins with a brace, else MJCF, URDF or SDFormat by its root.
    ///
    /// # Errors
    /// Numbers that are none, names that are not unique, and files that are no model.
    pub fn read(path: &Path) -> Result<Model, InputError> {
        Model::read_source(&Source::argument(path)?)
    }

    /// As [`Model::read`], from a source at hand.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn read_source(source: &Arc<Source>) -> Result<Model, InputError> {
        let model = if source.text().trim_start().starts_with('{') {
            limits::read(source)?
        } else {
            let read =
                Sheet::parse(source, |sheet, root| match root.tag_name().name() {
                    "robot" => Some(urdf::read(sheet, root)),
                    "mujoco" => Some(mjcf::read(sheet, root)),
                    "sdf" => Some(sdf::read(sheet, root)),
                    other => {
                        let message = format!("`{other}` is not a robot model");
                        let problem = Problem::at(span(root), message, "the root");
                        sheet.note(problem.help(
                            "expected `robot` (URDF), `mujoco` (MJCF), `sdf` (SDFormat), or a JSON table of limits",
                        ));
                        None
                    }
                });
            let wanted = [FileKind::Description, FileKind::Xml];
            let (found, _) = read.map_err(|error| kind::instead(error, &wanted))?;
            Model { source: source.clone(), ..found }
        };
        if model.joints.is_empty() {
            let problem = Problem::whole("the model has no joint that moves and has a name");
            return Err(InputError { source: source.clone(), problems: vec![problem] });
        }
        Ok(model)
    }

    /// A model without content, to be filled.
    fn blank(form: Form, name: &str) -> Model {
        let source = Arc::new(Source::new("", ""));
        let (joints, links, notes) = (Vec::new(), Vec::new(), Vec::new());
        Model { source, form, name: name.into(), joints, links, notes }
    }
}
