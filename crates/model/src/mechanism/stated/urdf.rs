//! What a URDF states of its joints: `limit`, `dynamics`, and the rotor in a transmission of Drake.

use std::collections::{HashMap, HashSet};

use super::{Form, Joint, Link, Model, Quantity, Slot, Stated};
use crate::input::Range;
use crate::mechanism::xml::{El, Sheet, children, span};

/// Namespace of Drake's extensions.
const DRAKE: &str = "http://drake.mit.edu";

pub(super) fn read(sheet: &Sheet, root: El) -> Model {
    let mut model = Model::blank(Form::Urdf, root.attribute("name").unwrap_or("robot"));
    let mut links: HashMap<&str, usize> = HashMap::new();
    for node in children(root).filter(|n| n.has_tag_name("link")) {
        let Some(name) = node.attribute("name") else { continue };
        links.entry(name).or_insert(model.links.len());
        model.links.push(Link { name: name.into(), mass: mass(sheet, node) });
    }
    let mut names = HashSet::new();
    for node in children(root).filter(|n| n.has_tag_name("joint")) {
        let Some(mut joint) = Joint::of_type(sheet, node, &mut names) else { continue };
        let child = |tag: &str| children(node).find(|c| c.has_tag_name(tag));
        let parent = child("parent").and_then(|p| links.get(p.attribute("link")?).copied());
        joint.is_passive = child("mimic").is_some();
        joint.parent = parent;
        for (tag, attributes) in [
            ("limit", [("effort", Quantity::Effort), ("velocity", Quantity::Velocity)]),
            ("dynamics", [("friction", Quantity::Friction), ("damping", Quantity::Damping)]),
        ] {
            let Some(element) = child(tag) else { continue };
            for (name, quantity) in attributes {
                take(sheet, &mut joint, element, name, quantity);
            }
        }
        rotor(sheet, root, &mut joint);
        model.joints.push(joint);
    }
    model
}

/// The mass of a link.
fn mass(sheet: &Sheet, link: El) -> Option<(f64, std::ops::Range<usize>)> {
    let inertial = children(link).find(|c| c.has_tag_name("inertial"))?;
    let value = children(inertial).find(|c| c.has_tag_name("mass"))?.attribute_node("value")?;
    Some((sheet.number(value, Range::NonNegative)?, value.range_value()))
}

/// Takes an attribute; where it is not there, its place is kept.
fn take(sheet: &Sheet, joint: &mut Joint, element: El, name: &'static str, quantity: Quantity) {
    let Some(attribute) = element.attribute_node(name) else {
        joint.blank.push((quantity, Slot::attribute(span(element).end, name)));
        return;
    };
    let Some(value) = sheet.number(attribute, Range::NonNegative) else { return };
    let slot = Some(Slot::replace(attribute.range_value()));
    let (span, called) = (attribute.range_value(), name.to_string());
    joint.stated.push(Stated { quantity, value, span, called, slot, by_gear: false });
}

/// Rotor and ratio that Drake reads in a transmission: armature = rotor_inertia × gear_ratio².
fn rotor(sheet: &Sheet, root: El, joint: &mut Joint) {
    let of_joint = |t: &El| children(*t).any(|c| c.has_tag_name("joint") && c.attribute("name") == Some(&joint.name));
    let transmission = children(root).filter(|c| c.has_tag_name("transmission")).find(of_joint);
    let of_drake = |tag: &str| {
        let mut inside = transmission?.descendants();
        let found = inside.find(|d| d.tag_name().name() == tag && d.tag_name().namespace() == Some(DRAKE));
        found?.attribute_node("value")
    };
    let (Some(inertia), ratio) = (of_drake("rotor_inertia"), of_drake("gear_ratio")) else { return };
    let ratio = ratio.map_or(Some(1.0), |ratio| sheet.number(ratio, Range::Positive));
    let (Some(inner), Some(ratio)) = (sheet.number(inertia, Range::NonNegative), ratio) else { return };
    let slot = Some(Slot { factor: 1.0 / (ratio * ratio), ..Slot::replace(inertia.range_value()) });
    joint.stated.push(Stated {
        quantity: Quantity::Armature,
        value: inner * ratio * ratio,
        span: inertia.range_value(),
        called: "rotor_inertia × gear_ratio²".into(),
        slot,
        by_gear: false,
    });
}
