//! What an SDFormat model states of its joints: `axis/limit`, `axis/dynamics`, and Drake's rotor, as texts of elements.

use std::collections::{HashMap, HashSet};

use super::{Form, Joint, Link, Model, Quantity, Slot, Stated};
use crate::input::{Problem, Range};
use crate::mechanism::xml::{El, Sheet, children, span};

/// Namespace of Drake's extensions.
const DRAKE: &str = "http://drake.mit.edu";

pub(super) fn read(sheet: &Sheet, root: El) -> Model {
    let models = || root.descendants().filter(|n| n.has_tag_name("model"));
    let name = models().next().and_then(|m| m.attribute("name")).unwrap_or("model");
    let mut model = Model::blank(Form::Sdf, name);
    if root.descendants().any(|n| n.has_tag_name("include")) {
        model.notes.push("included models are not followed: their joints are missing".into());
    }
    let mut names = HashSet::new();
    for of in models() {
        let mut links: HashMap<&str, usize> = HashMap::new();
        for node in children(of).filter(|n| n.has_tag_name("link")) {
            let Some(name) = node.attribute("name") else { continue };
            links.entry(name).or_insert(model.links.len());
            let mass = child(node, "inertial").and_then(|inertial| child(inertial, "mass"));
            let mass = mass.and_then(|mass| Some((number(sheet, mass, Range::NonNegative)?, text_span(mass))));
            model.links.push(Link { name: name.into(), mass });
        }
        for node in children(of).filter(|n| n.has_tag_name("joint")) {
            let Some(mut joint) = Joint::of_type(sheet, node, &mut names) else { continue };
            let parent = child(node, "parent").and_then(|p| links.get(p.text()?.trim()).copied());
            joint.is_passive = child(node, "axis").and_then(|axis| child(axis, "mimic")).is_some();
            joint.parent = parent;
            if let Some(axis) = child(node, "axis") {
                for (section, key, quantity) in [
                    ("limit", "effort", Quantity::Effort),
                    ("limit", "velocity", Quantity::Velocity),
                    ("dynamics", "friction", Quantity::Friction),
                    ("dynamics", "damping", Quantity::Damping),
                ] {
                    let element = child(axis, section).and_then(|section| child(section, key));
                    let Some(element) = element else { continue };
                    // A limit below zero is none: so the format says.
                    let any = if section == "limit" { Range::Any } else { Range::NonNegative };
                    let Some(value) = number(sheet, element, any).filter(|value| *value >= 0.0) else { continue };
                    let (slot, span) = (Some(Slot::replace(text_span(element))), text_span(element));
                    joint.stated.push(Stated { quantity, value, span, called: key.into(), slot, by_gear: false });
                }
            }
            rotor(sheet, node, &mut joint);
            model.joints.push(joint);
        }
    }
    model
}

fn child<'a>(node: El<'a>, tag: &str) -> Option<El<'a>> {
    children(node).find(|c| c.tag_name().name() == tag && c.tag_name().namespace().is_none())
}

/// Where the text of an element is.
fn text_span(node: El) -> std::ops::Range<usize> {
    node.first_child().filter(|c| c.is_text()).map_or_else(|| span(node), |text| text.range())
}

/// The number that is the text of an element, in a range.
fn number(sheet: &Sheet, node: El, range: Range) -> Option<f64> {
    let tag = node.tag_name().name();
    let number = node.text().and_then(|text| text.trim().parse::<f64>().ok()).filter(|number| !number.is_nan());
    let problem = match number {
        // An infinite limit is none.
        Some(number) if number.is_infinite() => return None,
        Some(number) if range.contains(number) => return Some(number),
        Some(_) => {
            Problem::at(text_span(node), format!("`{tag}` is out of range"), format!("expected {}", range.expected()))
        }
        None => Problem::at(text_span(node), format!("`{tag}` is not a number"), "expected a number"),
    };
    sheet.note(problem);
    None
}

/// Rotor and ratio that Drake reads in a joint: armature = rotor_inertia × gear_ratio².
fn rotor(sheet: &Sheet, node: El, joint: &mut Joint) {
    let of_drake =
        |tag: &str| children(node).find(|c| c.tag_name().name() == tag && c.tag_name().namespace() == Some(DRAKE));
    let (Some(inertia), ratio) = (of_drake("rotor_inertia"), of_drake("gear_ratio")) else { return };
    let ratio = ratio.map_or(Some(1.0), |ratio| number(sheet, ratio, Range::Positive));
    let (Some(inner), Some(ratio)) = (number(sheet, inertia, Range::NonNegative), ratio) else { return };
    joint.stated.push(Stated {
        quantity: Quantity::Armature,
        value: inner * ratio * ratio,
        span: text_span(inertia),
        called: "rotor_inertia × gear_ratio²".into(),
        slot: Some(Slot { factor: 1.0 / (ratio * ratio), ..Slot::replace(text_span(inertia)) }),
        by_gear: false,
    });
}
