//! An export written into a model that is there: attributes are replaced or added where they stand, everything
//! else of the text stays as it is. Written twice, the second time changes nothing.

use std::ops::Range;

use roxmltree::{Document, Node};

use super::{Exported, MARK, Origin, digits, escape, mjcf, urdf};
use crate::catalog::matches_pattern;
use crate::words::nearest;

/// Which joints of the model are meant: the design's joint, and a pattern of names in the model.
pub type Names = [(String, String)];

/// A model's new text, and what should be known of it.
#[derive(Debug)]
pub struct Patched {
    /// The text.
    pub text: String,
    /// Which joints were written, as `joint: names`.
    pub written: Vec<(String, Vec<String>)>,
    /// What was left alone, in words.
    pub remarks: Vec<String>,
}

/// Changes of a text that are put in all at once.
struct Edits<'a> {
    text: &'a str,
    changes: Vec<(Range<usize>, String)>,
}

impl<'a> Edits<'a> {
    /// Sets attributes of an element: present ones are replaced, others stand after the element's name.
    fn set(&mut self, node: Node, attributes: &[(&'static str, String)]) {
        let mut new = String::new();
        for (name, value) in attributes {
            match node.attribute_node(*name) {
                Some(present) => self.changes.push((present.range_value(), escape(value))),
                None => new.push_str(&format!(" {name}=\"{}\"", escape(value))),
            }
        }
        if !new.is_empty() {
            // After the attributes that are there; an element without any has them after its name.
            let at = node.attributes().map(|a| a.range().end).max().unwrap_or_else(|| self.name_end(node));
            self.changes.push((at..at, new));
        }
    }

    fn name_end(&self, node: Node) -> usize {
        let start = node.range().start + 1;
        let end = self.text[start..].find(|c: char| c.is_whitespace() || c == '/' || c == '>');
        start + end.unwrap_or(0)
    }

    /// Puts text before the end tag of an element, on lines of its own; an element without content is opened.
    fn append(&mut self, node: Node, tag: &str, inside: impl Fn(&str) -> String) {
        let outer = self.indent_of(node.range().start);
        let lines = inside(&format!("{outer}  "));
        let range = node.range();
        let whole = &self.text[range.clone()];
        match whole.rfind("</") {
            Some(at) if whole.ends_with('>') && !whole.trim_end().ends_with("/>") => {
                let at = range.start + at;
                let line = self.text[..at].rfind('\n').map_or(0, |n| n + 1);
                if self.text[line..at].trim().is_empty() {
                    self.changes.push((line..line, lines));
                } else {
                    self.changes.push((at..at, format!("\n{lines}{outer}")));
                }
            }
            _ => {
                let slash = range.end - 2;
                self.changes.push((slash..range.end, format!(">\n{lines}{outer}</{tag}>")));
            }
        }
    }

    fn indent_of(&self, at: usize) -> String {
        let line = self.text[..at].rfind('\n').map_or(0, |n| n + 1);
        self.text[line..at].chars().take_while(|c| matches!(c, ' ' | '\t')).collect()
    }

    /// The provenance, first thing in the root; one that stands there already is replaced.
    fn head(&mut self, root: Node, comment: &str) {
        let old = root.children().find(|c| c.is_comment() && c.text().is_some_and(|t| t.starts_with(MARK)));
        match old {
            Some(old) => self.changes.push((old.range(), comment.to_string())),
            None => {
                let first = root.first_child().map_or(root.range().end, |c| c.range().start);
                self.changes.push((first..first, format!("\n  {comment}")));
            }
        }
    }

    fn done(mut self) -> String {
        self.changes.sort_by_key(|(range, _)| (range.start, range.end));
        let mut out = String::with_capacity(self.text.len() + 1024);
        let mut from = 0;
        for (range, new) in &self.changes {
            out.push_str(&self.text[from..range.start]);
            out.push_str(new);
            from = range.end;
        }
        out.push_str(&self.text[from..]);
        out
    }
}

/// Writes designs into a model, MJCF or URDF by its root element.
///
/// # Errors
/// In words: not XML, neither of the two formats, a joint that is not there, a joint meant by two designs.
pub fn patch(text: &str, origin: &Origin, joints: &[Exported], names: &Names) -> Result<Patched, String> {
    let document = Document::parse(text).map_err(|error| format!("not XML: {error}"))?;
    let root = document.root_element();
    let is_mjcf = match root.tag_name().name() {
        "mujoco" => true,
        "robot" => false,
        other => return Err(format!("its root is <{other}>; expected <mujoco> (MJCF) or <robot> (URDF)")),
    };
    let own = if is_mjcf {
        let world = root.children().filter(|c| c.has_tag_name("worldbody"));
        world.flat_map(|w| w.descendants()).filter(|n| n.has_tag_name("joint")).collect::<Vec<_>>()
    } else {
        root.children().filter(|n| n.has_tag_name("joint")).collect()
    };
    if own.iter().all(|n| n.attribute("name").is_none()) {
        return Err("it has no joint with a name (included files are not followed)".into());
    }
    let mut edits = Edits { text, changes: Vec::new() };
    let mut patched = Patched { text: String::new(), written: Vec::new(), remarks: Vec::new() };
    let mut taken: Vec<(&str, &str)> = Vec::new();
    for e in joints {
        let patterns: Vec<&str> = names.iter().filter(|(joint, _)| joint == e.joint).map(|(_, p)| p.as_str()).collect();
        let patterns = if patterns.is_empty() { vec![e.joint] } else { patterns };
        let meant = |n: &&Node| n.attribute("name").is_some_and(|n| patterns.iter().any(|p| matches_pattern(p, n)));
        let found: Vec<Node> = own.iter().filter(meant).copied().collect();
        if found.is_empty() {
            let all: Vec<&str> = own.iter().filter_map(|n| n.attribute("name")).collect();
            let near =
                nearest(patterns[0], all.iter().copied()).map_or_else(String::new, |n| format!(" (`{n}` is near)"));
            let shown = all.iter().take(12).copied().collect::<Vec<_>>().join(", ");
            return Err(format!(
                "no joint matches `{}`{near}; its joints: {shown}; say which are meant with `--map {}=PATTERN`",
                patterns.join("`, `"),
                e.joint
            ));
        }
        let mut written = Vec::new();
        for node in found {
            let name = node.attribute("name").unwrap_or_default();
            if let Some((_, other)) = taken.iter().find(|(n, _)| *n == name) {
                return Err(format!("joint `{name}` is meant by `{other}` and by `{}`", e.joint));
            }
            taken.push((name, e.joint));
            if is_mjcf {
                into_mjcf(&mut edits, root, node, name, e, &mut patched.remarks);
            } else {
                into_urdf(&mut edits, root, node, name, e, &mut patched.remarks);
            }
            written.push(name.to_string());
        }
        patched.written.push((e.joint.to_string(), written));
    }
    if is_mjcf {
        add_motors(&mut edits, root, joints, &taken);
        edits.head(root, &mjcf::header(origin, joints));
    } else {
        add_transmissions(&mut edits, root, joints, &taken);
        edits.head(root, &urdf::header(origin, joints));
    }
    patched.text = edits.done();
    Ok(patched)
}

fn into_mjcf(edits: &mut Edits, root: Node, node: Node, name: &str, e: &Exported, remarks: &mut Vec<String>) {
    if node.attribute("type").is_some_and(|t| t != "hinge") {
        remarks.push(format!("joint `{name}` is no hinge: it was written as if it were"));
    }
    edits.set(node, &mjcf::joint_attributes(e));
    for actuator in actuators(root, name) {
        match actuator.tag_name().name() {
            "motor" => edits.set(actuator, &mjcf::motor_attributes(e)),
            other => remarks.push(format!(
                "the <{other}> of joint `{name}` is left as it is; `actuatorfrcrange` of the joint limits it"
            )),
        }
    }
}

fn actuators<'a>(root: Node<'a, 'a>, joint: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    let sections = root.children().filter(|c| c.has_tag_name("actuator"));
    sections.flat_map(|s| s.children()).filter(move |n| n.is_element() && n.attribute("joint") == Some(joint))
}

/// A motor for each joint that no actuator drives.
fn add_motors(edits: &mut Edits, root: Node, joints: &[Exported], taken: &[(&str, &str)]) {
    let missing: Vec<_> = taken.iter().filter(|(name, _)| actuators(root, name).next().is_none()).collect();
    if missing.is_empty() {
        return;
    }
    let lines = |indent: &str| {
        let motors = missing.iter().filter_map(|(name, joint)| {
            let e = joints.iter().find(|e| e.joint == *joint)?;
            let mut attributes = vec![("name", format!("{name}_motor")), ("joint", (*name).to_string())];
            attributes.extend(mjcf::motor_attributes(e));
            Some(format!("{indent}{}\n", mjcf::element("motor", &attributes)))
        });
        motors.collect::<String>()
    };
    match root.children().find(|c| c.has_tag_name("actuator")) {
        Some(section) => edits.append(section, "actuator", lines),
        None => edits.append(root, "mujoco", |indent| {
            format!("{indent}<actuator>\n{}{indent}</actuator>\n", lines(&format!("{indent}  ")))
        }),
    }
}

fn into_urdf(edits: &mut Edits, root: Node, node: Node, name: &str, e: &Exported, remarks: &mut Vec<String>) {
    match node.attribute("type") {
        Some("revolute" | "continuous") => {}
        other => remarks.push(format!(
            "joint `{name}` is {}, not revolute or continuous: it was written as if it were",
            other.unwrap_or("of no type")
        )),
    }
    let sets = [("limit", urdf::limit_attributes(e)), ("dynamics", urdf::dynamics_attributes(e))];
    let mut new = Vec::new();
    for (tag, attributes) in sets {
        match node.children().find(|c| c.has_tag_name(tag)) {
            Some(present) => edits.set(present, &attributes),
            None if attributes.is_empty() => {}
            None => new.push(mjcf::element(tag, &attributes)),
        }
    }
    if !new.is_empty() {
        edits.append(node, "joint", |indent| new.iter().map(|n| format!("{indent}{n}\n")).collect());
    }
    for transmission in transmissions(root, name) {
        let reductions = transmission.descendants().filter(|d| d.has_tag_name("mechanicalReduction"));
        for text in reductions.filter_map(|r| r.first_child()).filter(Node::is_text) {
            edits.changes.push((text.range(), digits(e.simulated.ratio)));
        }
        let rotor = e.simulated.inertias.map(|(rotor, gear)| ("rotor_inertia", rotor + gear));
        for (tag, value) in rotor.into_iter().chain([("gear_ratio", e.simulated.ratio)]) {
            let of_drake = |d: &Node| d.tag_name().name() == tag && d.tag_name().namespace() == Some(urdf::DRAKE);
            for element in transmission.descendants().filter(of_drake) {
                edits.set(element, &[("value", digits(value))]);
            }
        }
    }
}

fn transmissions<'a>(root: Node<'a, 'a>, joint: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    let all = root.children().filter(|c| c.has_tag_name("transmission"));
    all.filter(move |t| t.children().any(|c| c.has_tag_name("joint") && c.attribute("name") == Some(joint)))
}

/// A transmission for each joint that has none, and the namespace that its elements need.
fn add_transmissions(edits: &mut Edits, root: Node, joints: &[Exported], taken: &[(&str, &str)]) {
    let missing: Vec<_> = taken.iter().filter(|(name, _)| transmissions(root, name).next().is_none()).collect();
    if missing.is_empty() {
        return;
    }
    if root.lookup_prefix(urdf::DRAKE) != Some("drake") {
        let at = edits.name_end(root);
        edits.changes.push((at..at, format!(" xmlns:drake=\"{}\"", urdf::DRAKE)));
    }
    edits.append(root, "robot", |indent| {
        let all = missing.iter().filter_map(|(name, joint)| {
            let e = joints.iter().find(|e| e.joint == *joint)?;
            Some(urdf::transmission(e, name, indent))
        });
        all.collect()
    });
}
