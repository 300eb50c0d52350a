//! An export written into a model that is there: attributes are replaced or added where they stand, everything
//! else of the text stays as it is. Written twice, the second time changes nothing.

use std::ops::Range;

use roxmltree::Node;

use super::{Exported, MARK, Origin, Wishes, dcmotor, digits, escape, mjcf, sdf, urdf};
use gearwise_model::catalog::matches_pattern;
use gearwise_model::mechanism::{document, stated};
use gearwise_model::words::nearest;

/// A model's new text, and what should be known of it.
#[derive(Debug)]
pub struct Patched {
    /// The text.
    pub text: String,
    /// Which joints were written, as `joint: names`.
    pub written: Vec<(String, Vec<String>)>,
    /// What was left alone, in words.
    pub remarks: Vec<String>,
    /// Name of the format that it was written as.
    pub format: &'static str,
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

    /// Sets the text of an element.
    fn set_text(&mut self, node: Node, text: &str) {
        match node.first_child().filter(Node::is_text) {
            Some(present) => self.changes.push((present.range(), escape(text))),
            None => {
                let range = node.range();
                let name = self.text[range.start + 1..self.name_end(node)].to_string();
                self.changes.push((range, format!("<{name}>{}</{name}>", escape(text))));
            }
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

/// A form of model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Mjcf,
    Urdf,
    Sdf,
}

impl Form {
    /// By the root element.
    fn of(root: Node) -> Result<Form, String> {
        match root.tag_name().name() {
            "mujoco" => Ok(Form::Mjcf),
            "robot" => Ok(Form::Urdf),
            "sdf" => Ok(Form::Sdf),
            other => {
                Err(format!("its root is <{other}>; expected <mujoco> (MJCF), <robot> (URDF) or <sdf> (SDFormat)"))
            }
        }
    }

    /// What it cannot be written with.
    fn refuse(self, wishes: &Wishes) -> Result<(), String> {
        match self {
            Form::Mjcf if wishes.for_drake => Err("`--drake` is for a URDF".into()),
            Form::Urdf | Form::Sdf if wishes.gear_joint => {
                Err("`--gear-joint` is for MJCF: there two joints of one body add up".into())
            }
            Form::Urdf | Form::Sdf if wishes.as_dcmotor => Err("`--to dcmotor` is for MJCF".into()),
            Form::Sdf if wishes.for_drake => Err("`--drake` is for a URDF".into()),
            _ => Ok(()),
        }
    }

    /// The joints of a model.
    fn joints<'a>(self, root: Node<'a, 'a>) -> Vec<Node<'a, 'a>> {
        match self {
            Form::Mjcf => {
                let world = root.children().filter(|c| c.has_tag_name("worldbody"));
                world.flat_map(|w| w.descendants()).filter(|n| n.has_tag_name("joint")).collect()
            }
            Form::Urdf => root.children().filter(|n| n.has_tag_name("joint")).collect(),
            Form::Sdf => {
                let in_model = |n: &Node| n.parent().is_some_and(|p| p.has_tag_name("model"));
                root.descendants().filter(|n| n.has_tag_name("joint") && in_model(n)).collect()
            }
        }
    }
}

/// Writes designs into a model, MJCF, URDF or SDFormat by its root element.
///
/// # Errors
/// In words: not XML, none of the formats, a joint that is not there, a joint meant by two designs.
pub fn patch(text: &str, origin: &Origin, joints: &[Exported], wishes: &Wishes) -> Result<Patched, String> {
    let document = document(text).map_err(|problem| format!("not XML: {}", problem.message))?;
    let root = document.root_element();
    let form = Form::of(root)?;
    form.refuse(wishes)?;
    let other = root.namespaces().find(|n| n.name() == Some("drake") && n.uri() != urdf::DRAKE);
    if let Some(other) = other.filter(|_| form != Form::Mjcf) {
        return Err(format!(
            "its prefix `drake` is the namespace \"{}\"; Drake's own is \"{}\": fix that first",
            other.uri(),
            urdf::DRAKE
        ));
    }
    let own = form.joints(root);
    if own.iter().all(|n| n.attribute("name").is_none()) {
        return Err("it has no joint with a name (included files are not followed)".into());
    }
    let mut edits = Edits { text, changes: Vec::new() };
    let mut patched = Patched {
        text: String::new(),
        written: Vec::new(),
        remarks: Vec::new(),
        format: match form {
            Form::Mjcf if wishes.as_dcmotor => dcmotor::FORMAT.name,
            Form::Mjcf => mjcf::FORMAT.name,
            Form::Urdf => urdf::FORMAT.name,
            Form::Sdf => sdf::FORMAT.name,
        },
    };
    let mut taken: Vec<(&str, &str)> = Vec::new();
    for e in joints {
        let patterns = wishes.patterns(e.joint);
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
            let remarks = &mut patched.remarks;
            match form {
                Form::Mjcf => into_mjcf(&mut edits, root, node, name, (e, wishes), remarks)?,
                Form::Urdf => into_urdf(&mut edits, root, node, name, e, remarks),
                Form::Sdf => into_sdf(&mut edits, node, name, e, remarks),
            }
            written.push(name.to_string());
        }
        patched.written.push((e.joint.to_string(), written));
    }
    match form {
        Form::Mjcf => {
            add_motors(&mut edits, root, joints, &taken, wishes)?;
            let header =
                if wishes.as_dcmotor { dcmotor::header(origin, joints, wishes) } else { mjcf::header(origin, joints) };
            edits.head(root, &header);
        }
        Form::Urdf => {
            add_transmissions(&mut edits, root, joints, &taken, wishes);
            edits.head(root, &urdf::header(origin, joints));
        }
        Form::Sdf => {
            if root.lookup_prefix(urdf::DRAKE) != Some("drake") {
                let at = edits.name_end(root);
                edits.changes.push((at..at, format!(" xmlns:drake=\"{}\"", urdf::DRAKE)));
            }
            edits.head(root, &sdf::header(origin, joints));
        }
    }
    patched.text = edits.done();
    Ok(patched)
}

fn into_mjcf(
    edits: &mut Edits,
    root: Node,
    node: Node,
    name: &str,
    (e, wishes): (&Exported, &Wishes),
    remarks: &mut Vec<String>,
) -> Result<(), String> {
    if node.attribute("type").is_some_and(|t| t != "hinge") {
        remarks.push(format!("joint `{name}` is no hinge: it was written as if it were"));
    }
    match wishes.as_dcmotor {
        // What stood there of the joint itself would count twice.
        true => edits.set(node, &dcmotor::joint_attributes_in_model(e, wishes)?),
        false => edits.set(node, &mjcf::joint_attributes(e)),
    }
    if wishes.gear_joint {
        add_gear_joint(edits, root, node, name, e, remarks)?;
    }
    for actuator in actuators(root, name) {
        match (actuator.tag_name().name(), wishes.as_dcmotor) {
            ("motor", false) => edits.set(actuator, &turned_as(root, actuator, mjcf::motor_attributes(e))),
            ("dcmotor", true) => {
                edits.set(actuator, &turned_as(root, actuator, dcmotor::all_motor_attributes(e, wishes)?));
            }
            (other, true) => {
                return Err(format!(
                    "joint `{name}` is driven by a <{other}>: make it a <dcmotor> first, or write without `--to dcmotor`"
                ));
            }
            (other, false) => remarks.push(format!(
                "the <{other}> of joint `{name}` is left as it is; `actuatorfrcrange` of the joint limits it"
            )),
        }
    }
    Ok(())
}

/// The attributes of an actuator with the sign that its gear has in the model, also by its class: the direction in which its command
/// counts stays.
fn turned_as<'a>(
    root: Node<'a, 'a>,
    actuator: Node<'a, 'a>,
    mut attributes: Vec<(&'static str, String)>,
) -> Vec<(&'static str, String)> {
    let is_negative = stated::gear_of(root, actuator).is_some_and(|gear| gear < 0.0);
    for (_, gear) in
        attributes.iter_mut().filter(|(name, gear)| is_negative && *name == "gear" && !gear.starts_with('-'))
    {
        gear.insert(0, '-');
    }
    attributes
}

/// A second joint of the same body about the same axis: angles of joints of one body add up, so that this one is what the output
/// lags the motor by, and the armature is on the motor's side of it.
fn add_gear_joint(
    edits: &mut Edits,
    root: Node,
    node: Node,
    name: &str,
    e: &Exported,
    remarks: &mut Vec<String>,
) -> Result<(), String> {
    let s = &e.simulated;
    if node.attribute("type").is_some_and(|t| t != "hinge") {
        return Err(format!("`--gear-joint`: joint `{name}` is no hinge"));
    }
    let new = format!("{name}_gear");
    let is_there = Form::Mjcf.joints(root).into_iter().find(|n| n.attribute("name") == Some(&new));
    // One angle more would shift what keyframes say of all joints behind it.
    let is_keyed =
        root.descendants().any(|n| n.has_tag_name("key") && (n.has_attribute("qpos") || n.has_attribute("qvel")));
    if is_keyed && is_there.is_none() {
        return Err(
            "`--gear-joint`: the model has keyframes, and a joint more would shift their angles: take them out first"
                .into(),
        );
    }
    let mut attributes: Vec<(&'static str, String)> = vec![("name", new.clone())];
    for copied in ["class", "type", "axis", "pos"] {
        attributes.extend(node.attribute(copied).map(|value| (copied, value.to_string())));
    }
    // What its class would give it.
    let none = [
        ("armature", "0"),
        ("damping", "0"),
        ("frictionloss", "0"),
        ("ref", "0"),
        ("springref", "0"),
        ("springdamper", "0 0"),
        ("actuatorfrclimited", "false"),
    ];
    attributes.extend(none.map(|(key, value)| (key, value.to_string())));
    match (s.stiffness, s.backlash) {
        (Some(stiffness), backlash) => {
            attributes.push(("stiffness", digits(stiffness)));
            attributes.push(("limited", "false".into()));
            if backlash.is_some() {
                remarks.push(format!("joint `{new}` has the gear's elasticity; its play has no place next to it"));
            }
        }
        (None, Some(play)) => {
            // The last one counts.
            let compilers = root.children().filter(|c| c.has_tag_name("compiler"));
            let angle = compilers.filter_map(|c| c.attribute("angle")).next_back();
            if angle.is_none() && root.descendants().any(|n| n.has_tag_name("include")) {
                let why = "whether angles of the model are degrees is said in a file that it includes: say it in its own <compiler angle=…>";
                return Err(format!("`--gear-joint`: {why}"));
            }
            let radian = angle == Some("radian");
            let half = if radian { 0.5 * play } else { (0.5 * play).to_degrees() };
            attributes.push(("stiffness", "0".into()));
            attributes.push(("limited", "true".into()));
            attributes.push(("range", super::range(half)));
        }
        (None, None) => {
            return Err(format!(
                "`--gear-joint`: neither stiffness nor play of the gear of joint `{}` is known",
                e.joint
            ));
        }
    }
    remarks.push(format!(
        "joint `{new}` is the gear: `{name}` is the motor's angle over N now, the link's is the sum of both; no damping of it is known, give it some"
    ));
    match is_there {
        Some(there) => edits.set(there, &attributes),
        None => {
            let (at, indent) = (node.range().end, edits.indent_of(node.range().start));
            edits.changes.push((at..at, format!("\n{indent}{}", mjcf::element("joint", &attributes))));
        }
    }
    Ok(())
}

fn actuators<'a>(root: Node<'a, 'a>, joint: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    let sections = root.children().filter(|c| c.has_tag_name("actuator"));
    let drives = move |n: &Node| n.attribute("joint").or_else(|| n.attribute("jointinparent")) == Some(joint);
    sections.flat_map(|s| s.children()).filter(move |n| n.is_element() && drives(n))
}

/// A motor for each joint that no actuator drives.
fn add_motors(
    edits: &mut Edits,
    root: Node,
    joints: &[Exported],
    taken: &[(&str, &str)],
    wishes: &Wishes,
) -> Result<(), String> {
    let missing: Vec<_> = taken.iter().filter(|(name, _)| actuators(root, name).next().is_none()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let mut motors = Vec::new();
    for (name, joint) in missing {
        let Some(e) = joints.iter().find(|e| e.joint == *joint) else { continue };
        let mut attributes = vec![("name", format!("{name}_motor")), ("joint", (*name).to_string())];
        let (tag, own) = match wishes.as_dcmotor {
            true => ("dcmotor", dcmotor::motor_attributes(e, wishes)?),
            false => ("motor", mjcf::motor_attributes(e)),
        };
        attributes.extend(own);
        motors.push(mjcf::element(tag, &attributes));
    }
    let lines = |indent: &str| motors.iter().map(|motor| format!("{indent}{motor}\n")).collect::<String>();
    match root.children().find(|c| c.has_tag_name("actuator")) {
        Some(section) => edits.append(section, "actuator", lines),
        None => edits.append(root, "mujoco", |indent| {
            format!("{indent}<actuator>\n{}{indent}</actuator>\n", lines(&format!("{indent}  ")))
        }),
    }
    Ok(())
}

fn into_sdf(edits: &mut Edits, node: Node, name: &str, e: &Exported, remarks: &mut Vec<String>) {
    match node.attribute("type") {
        Some("revolute" | "continuous") => {}
        other => remarks.push(format!(
            "joint `{name}` is {}, not revolute or continuous: it was written as if it were",
            other.unwrap_or("of no type")
        )),
    }
    let child = |of: Node<'_, '_>, tag: &str| of.children().find(|c| c.has_tag_name(tag)).map(|c| c.id());
    let document = node.document();
    let Some(axis) = child(node, "axis").and_then(|id| document.get_node(id)) else {
        remarks.push(format!("joint `{name}` has no axis: only Drake's elements were written"));
        edits.append(node, "joint", |indent| drake_lines(e, indent));
        return;
    };
    let mut new = String::new();
    let inner = format!("{}  ", edits.indent_of(axis.range().start));
    for (tag, elements) in [("limit", sdf::limits(e)), ("dynamics", sdf::dynamics(e))] {
        let Some(section) = child(axis, tag).and_then(|id| document.get_node(id)) else {
            new.push_str(&sdf::section(tag, &elements, &inner));
            continue;
        };
        let mut missing = Vec::new();
        for (key, value) in elements {
            match child(section, key).and_then(|id| document.get_node(id)) {
                Some(present) => edits.set_text(present, &value),
                None => missing.push((key, value)),
            }
        }
        if !missing.is_empty() {
            edits.append(section, tag, |indent| {
                missing.iter().map(|(key, value)| format!("{indent}{}\n", mjcf::element_of(key, value))).collect()
            });
        }
    }
    if !new.is_empty() {
        edits.append(axis, "axis", |_| new.clone());
    }
    let is_of_drake =
        |c: &Node, key: &str| c.tag_name().namespace() == Some(urdf::DRAKE) && key.ends_with(c.tag_name().name());
    let mut missing = String::new();
    let indent = format!("{}  ", edits.indent_of(node.range().start));
    for (key, value) in sdf::of_drake(e) {
        match node.children().find(|c| is_of_drake(c, key)) {
            Some(present) => edits.set_text(present, &value),
            None => missing.push_str(&format!("{indent}{}\n", mjcf::element_of(key, &value))),
        }
    }
    if !missing.is_empty() {
        edits.append(node, "joint", |_| missing.clone());
    }
}

fn drake_lines(e: &Exported, indent: &str) -> String {
    sdf::of_drake(e).iter().map(|(key, value)| format!("{indent}{}\n", mjcf::element_of(key, value))).collect()
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
        let mut missing = Vec::new();
        for (tag, value) in rotor.into_iter().chain([("gear_ratio", e.simulated.ratio)]) {
            let of_drake = |d: &Node| d.tag_name().name() == tag && d.tag_name().namespace() == Some(urdf::DRAKE);
            let mut there = transmission.descendants().filter(of_drake).peekable();
            if there.peek().is_none() {
                missing.push(format!("<drake:{tag} value=\"{}\"/>", digits(value)));
            }
            there.for_each(|element| edits.set(element, &[("value", digits(value))]));
        }
        if let Some(actuator) =
            transmission.children().find(|c| c.has_tag_name("actuator")).filter(|_| !missing.is_empty())
        {
            edits.append(actuator, "actuator", |indent| {
                missing.iter().map(|line| format!("{indent}{line}\n")).collect()
            });
        }
    }
}

fn transmissions<'a>(root: Node<'a, 'a>, joint: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    let all = root.children().filter(|c| c.has_tag_name("transmission"));
    all.filter(move |t| t.children().any(|c| c.has_tag_name("joint") && c.attribute("name") == Some(joint)))
}

/// A transmission for each joint that has none, and the namespace that its elements need.
fn add_transmissions(edits: &mut Edits, root: Node, joints: &[Exported], taken: &[(&str, &str)], wishes: &Wishes) {
    let missing: Vec<_> = taken.iter().filter(|(name, _)| transmissions(root, name).next().is_none()).collect();
    if root.lookup_prefix(urdf::DRAKE) != Some("drake") {
        let at = edits.name_end(root);
        edits.changes.push((at..at, format!(" xmlns:drake=\"{}\"", urdf::DRAKE)));
    }
    if missing.is_empty() {
        return;
    }
    edits.append(root, "robot", |indent| {
        let all = missing.iter().filter_map(|(name, joint)| {
            let e = joints.iter().find(|e| e.joint == *joint)?;
            Some(urdf::transmission(e, name, indent, wishes))
        });
        all.collect()
    });
}
