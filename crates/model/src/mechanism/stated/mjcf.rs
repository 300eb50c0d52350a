//! What an MJCF model states of its joints and of the actuators that drive them, classes of defaults resolved: of an attribute
//! that stands in several places the one that counts is taken, with its place.

use std::collections::{HashMap, HashSet};

use roxmltree::Attribute;

use super::{Form, Joint, Link, Model, Quantity, Slot, Stated};
use crate::input::{Range, limits};
use crate::mechanism::xml::{El, Sheet, children, span};

/// Elements of `actuator` that drive a joint; in a class of defaults they are one.
const ACTUATORS: &[&str] = &[
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
    "dcmotor",
    "plugin",
];

/// Classes of defaults by name: each with the class that it inherits from, and its elements.
struct Classes<'a>(HashMap<&'a str, (Option<&'a str>, Vec<El<'a>>)>);

/// The first number of the `gear` of an actuator, its own or that of its class; `None` if neither states one.
pub fn gear_of<'a>(root: El<'a>, actuator: El<'a>) -> Option<f64> {
    let layers = Classes::of(root).layers(actuator, None, ACTUATORS);
    get(&layers, "gear")?.value().split_whitespace().next()?.parse().ok()
}

struct Reader<'a, 's> {
    sheet: &'s Sheet,
    classes: Classes<'a>,
    /// Whether a range limits where nothing says whether it does.
    auto_limits: bool,
    model: Model,
    names: HashSet<String>,
}

pub(super) fn read<'a>(sheet: &Sheet, root: El<'a>) -> Model {
    let mut reader = Reader {
        sheet,
        classes: Classes::of(root),
        auto_limits: true,
        model: Model::blank(Form::Mjcf, root.attribute("model").unwrap_or("MuJoCo Model")),
        names: HashSet::new(),
    };
    for node in children(root).filter(|n| n.has_tag_name("compiler")) {
        reader.auto_limits &= node.attribute("autolimits") != Some("false");
    }
    if root.descendants().any(|n| n.has_tag_name("include")) {
        reader
            .model
            .notes
            .push("included files are not followed: joints, actuators and defaults in them are missing".into());
    }
    for world in children(root).filter(|n| n.has_tag_name("worldbody")) {
        reader.inside(world, None, None, None, 0);
    }
    reader.actuators(root);
    reader.model
}

impl<'a> Classes<'a> {
    fn of(root: El<'a>) -> Classes<'a> {
        let mut classes = Classes(HashMap::from([("main", (None, Vec::new()))]));
        for node in children(root).filter(|n| n.has_tag_name("default")) {
            classes.class(node, None, 0);
        }
        classes
    }

    fn class(&mut self, node: El<'a>, inside: Option<&'a str>, depth: usize) {
        if depth > limits::DEPTH {
            return;
        }
        let name = node.attribute("class").unwrap_or("main");
        let parts: Vec<El> = children(node).filter(|n| !n.has_tag_name("default")).collect();
        let entry = self.0.entry(name).or_insert((inside, Vec::new()));
        entry.1.extend(&parts);
        // The outermost class may have a name of its own; it still holds for elements without a class.
        if inside.is_none()
            && name != "main"
            && let Some(main) = self.0.get_mut("main")
        {
            main.1.extend(&parts);
        }
        for inner in children(node).filter(|n| n.has_tag_name("default")) {
            self.class(inner, Some(name), depth + 1);
        }
    }

    /// An element, then the elements of its classes outwards whose tags are among `tags`; of one class the last comes first.
    fn layers(&self, node: El<'a>, childclass: Option<&'a str>, tags: &[&str]) -> Vec<El<'a>> {
        let mut all = vec![node];
        let mut at = Some(node.attribute("class").or(childclass).unwrap_or("main"));
        let mut steps = 0;
        while let Some((above, parts)) = at.and_then(|name| self.0.get(name)) {
            all.extend(parts.iter().rev().filter(|part| tags.contains(&part.tag_name().name())));
            (at, steps) = (*above, steps + 1);
            if steps > limits::DEPTH {
                break;
            }
        }
        all
    }
}

impl<'a> Reader<'a, '_> {
    /// What hangs in a body, or in the world.
    fn inside(
        &mut self,
        node: El<'a>,
        link: Option<usize>,
        parent: Option<usize>,
        class: Option<&'a str>,
        depth: usize,
    ) {
        if depth > limits::DEPTH {
            return;
        }
        let class = node.attribute("childclass").or(class);
        for child in children(node) {
            match child.tag_name().name() {
                "body" => {
                    let name = child.attribute("name").unwrap_or("a body without a name").to_string();
                    let mass = self.mass(child);
                    self.model.links.push(Link { name, mass });
                    let own = self.model.links.len() - 1;
                    self.inside(child, Some(own), link, class, depth + 1);
                }
                "frame" => self.inside(child, link, parent, class, depth + 1),
                "joint" => self.joint(child, parent, class),
                _ => {}
            }
        }
    }

    /// The mass that a body states.
    fn mass(&self, body: El) -> Option<(f64, std::ops::Range<usize>)> {
        let inertial = children(body).find(|n| n.has_tag_name("inertial"))?;
        let mass = inertial.attribute_node("mass")?;
        Some((self.sheet.number(mass, Range::NonNegative)?, mass.range_value()))
    }

    fn joint(&mut self, node: El<'a>, parent: Option<usize>, class: Option<&'a str>) {
        let layers = self.classes.layers(node, class, &["joint"]);
        let turns = match get(&layers, "type").map_or("hinge", |a| a.value()) {
            "hinge" => true,
            "slide" => false,
            _ => return,
        };
        let Some(name) = node.attribute_node("name").filter(|n| !n.value().is_empty()) else { return };
        self.sheet.unique(node, "joints", name.value(), &mut self.names);
        let mut joint = Joint { is_passive: true, parent, ..Joint::blank(name.value(), name.range_value(), turns) };
        for (name, quantity) in
            [("armature", Quantity::Armature), ("frictionloss", Quantity::Friction), ("damping", Quantity::Damping)]
        {
            match get(&layers, name) {
                Some(attribute) => {
                    let first = self.sheet.list(attribute).and_then(|numbers| numbers.first().copied());
                    let Some(value) = first.filter(|value| self.is_positive(attribute, *value)) else { continue };
                    let slot = slot(node, attribute, name);
                    let (span, called) = (attribute.range_value(), name.to_string());
                    joint.stated.push(Stated { quantity, value, span, called, slot: Some(slot), by_gear: false });
                }
                None => joint.blank.push((quantity, Slot::attribute(span(node).end, name))),
            }
        }
        if let Some((attribute, value)) = self.limit(&layers, "actuatorfrcrange", "actuatorfrclimited") {
            joint.stated.push(Stated {
                quantity: Quantity::Effort,
                value,
                span: attribute.range_value(),
                called: JOINT_RANGE.into(),
                slot: Some(Slot { is_range: true, ..slot(node, attribute, "actuatorfrcrange") }),
                by_gear: false,
            });
        }
        self.model.joints.push(joint);
    }

    fn is_positive(&self, attribute: Attribute, value: f64) -> bool {
        value >= 0.0 || self.sheet.number(attribute, Range::NonNegative).is_some()
    }

    /// The larger end of a range that limits.
    fn limit(&self, layers: &[El<'a>], range: &str, limited: &str) -> Option<(Attribute<'a, 'a>, f64)> {
        let attribute = get(layers, range)?;
        let limits = match get(layers, limited).map(|a| a.value()) {
            Some("true") => true,
            Some("false") => false,
            _ => self.auto_limits,
        };
        let [least, most] = self.sheet.numbers::<2>(attribute)?;
        limits.then(|| (attribute, least.abs().max(most.abs())))
    }

    fn actuators(&mut self, root: El<'a>) {
        // Of each joint what its actuators give at most, each: `None` without a limit.
        let mut forces: Vec<Vec<Option<Stated>>> = vec![Vec::new(); self.model.joints.len()];
        let sections = children(root).filter(|n| n.has_tag_name("actuator"));
        for node in sections.flat_map(children) {
            let kind = node.tag_name().name();
            let named = node.attribute("joint").or_else(|| node.attribute("jointinparent"));
            let Some(k) = named.and_then(|name| self.model.joints.iter().position(|j| j.name == name)) else {
                continue;
            };
            let layers = self.classes.layers(node, None, ACTUATORS);
            let gear = get(&layers, "gear").and_then(|a| Some((a, *self.sheet.list(a)?.first()?)));
            let factor = gear.map_or(1.0, |(_, gear)| gear.abs());
            let mut found = Vec::new();
            if let Some((attribute, gear)) = gear {
                found.push(Stated {
                    quantity: Quantity::Gear,
                    value: gear.abs(),
                    span: attribute.range_value(),
                    called: "gear".into(),
                    slot: None,
                    by_gear: true,
                });
            }
            let added = [("armature", Quantity::Armature), ("damping", Quantity::Damping)].map(|(name, quantity)| {
                let attribute = get(&layers, name)?;
                let own =
                    self.sheet.list(attribute)?.first().copied().filter(|own| self.is_positive(attribute, *own))?;
                Some((name, quantity, attribute, own * factor * factor))
            });
            if let Some(attribute) = get(&layers, "saturation").filter(|_| kind == "dcmotor")
                && let Some(torque) = self.sheet.list(attribute).and_then(|list| list.first().copied())
                && torque > 0.0
            {
                found.push(Stated {
                    quantity: Quantity::Effort,
                    value: torque * factor,
                    span: attribute.range_value(),
                    called: "saturation × gear".into(),
                    slot: None,
                    by_gear: true,
                });
            }
            let mut effort = |range: &str, limited: &str, gain: f64| {
                let Some((attribute, force)) = self.limit(&layers, range, limited) else { return };
                let factor = factor * gain;
                let called = if factor == 1.0 { range.to_string() } else { format!("{range} × gear") };
                let at = slot(node, attribute, range);
                let slot = (factor > 0.0).then(|| Slot { factor: 1.0 / factor, is_range: true, ..at });
                found.push(Stated {
                    quantity: Quantity::Effort,
                    value: force * factor,
                    span: attribute.range_value(),
                    called,
                    slot,
                    by_gear: factor != 1.0,
                });
            };
            effort("forcerange", "forcelimited", 1.0);
            // The command of a motor is its force; that of a servo is an angle or a speed.
            let gain = match kind {
                "motor" => Some(1.0),
                "general" if get(&layers, "biastype").is_none_or(|a| a.value() == "none") => {
                    get(&layers, "gainprm").map_or(Some(1.0), |a| self.sheet.list(a)?.first().copied())
                }
                _ => None,
            };
            if let Some(gain) = gain.filter(|gain| *gain > 0.0) {
                effort("ctrlrange", "ctrllimited", gain);
            }
            let (efforts, others): (Vec<Stated>, Vec<Stated>) =
                found.into_iter().partition(|s| s.quantity == Quantity::Effort);
            forces[k].push(efforts.iter().min_by(|a, b| a.value.total_cmp(&b.value)).cloned());
            let joint = &mut self.model.joints[k];
            joint.is_passive = false;
            for (name, quantity, attribute, value) in added.into_iter().flatten() {
                // It counts with what the joint itself states.
                let own = joint.get(quantity).map_or(0.0, |own| own.value);
                joint.stated.retain(|stated| stated.quantity != quantity);
                let squared = factor * factor;
                let slot = (own == 0.0 && squared > 0.0)
                    .then(|| Slot { factor: 1.0 / squared, ..slot(node, attribute, name) });
                joint.stated.push(Stated {
                    quantity,
                    value: own + value,
                    span: attribute.range_value(),
                    called: format!("{name} × gear²"),
                    slot,
                    by_gear: false,
                });
            }
            joint.stated.extend(others);
            if forces[k].len() == 1 {
                joint.stated.extend(efforts);
            }
        }
        for (joint, forces) in self.model.joints.iter_mut().zip(forces).filter(|(_, forces)| forces.len() > 1) {
            // Forces of several actuators add up; one without a limit leaves none.
            joint.stated.retain(|s| s.quantity != Quantity::Effort || s.called == JOINT_RANGE);
            let Some(all) = forces.into_iter().collect::<Option<Vec<Stated>>>() else { continue };
            joint.stated.push(Stated {
                value: all.iter().map(|s| s.value).sum(),
                called: format!("the sum of {} actuators", all.len()),
                slot: None,
                by_gear: all.iter().any(|s| s.by_gear),
                ..all[0].clone()
            });
        }
    }
}

/// What limits the forces of all actuators of a joint together.
const JOINT_RANGE: &str = "actuatorfrcrange";

/// The attribute that counts.
fn get<'a>(layers: &[El<'a>], name: &str) -> Option<Attribute<'a, 'a>> {
    layers.iter().find_map(|node| node.attribute_node(name))
}

/// Where an attribute of an element is written: in its own place, or, where it is inherited, on the element itself.
fn slot(node: El, attribute: Attribute, name: &str) -> Slot {
    match node.attribute_node(name) {
        Some(_) => Slot::replace(attribute.range_value()),
        None => Slot::attribute(span(node).end, name),
    }
}
