//! What holds for the whole model: compiler, option and classes of defaults.

use nalgebra::Vector3;
use roxmltree::Attribute;

use super::words::*;
use super::{FromGeom, Layers, Reader};
use crate::input::{Problem, Range, limits};
use crate::mechanism::xml::{El, children};

impl<'a> Reader<'a, '_> {
    pub(super) fn choose<T: Copy>(&self, attribute: Attribute, choices: &[(&'static str, T)]) -> Option<T> {
        let found = choices.iter().find(|(word, _)| *word == attribute.value());
        if found.is_none() {
            let shown: String = attribute.value().chars().take(40).collect();
            let message = format!("`{}` cannot be `{shown}`", attribute.name());
            let names = choices.iter().map(|(word, _)| *word);
            self.sheet
                .note(Problem::at(attribute.range_value(), message, "not one of the choices").suggest(&shown, names));
        }
        found.map(|(_, value)| *value)
    }

    pub(super) fn compiler(&mut self, node: El) {
        let sheet = self.sheet;
        sheet.only(node, OF_COMPILER);
        let get = |name: &str| node.attribute_node(name);
        if let Some(a) = get("angle") {
            let unit = self.choose(a, &[("degree", 1.0_f64.to_radians()), ("radian", 1.0)]);
            self.compiler.angle = unit.unwrap_or(self.compiler.angle);
        }
        if let Some(a) = get("eulerseq") {
            let letters: Vec<char> = a.value().chars().collect();
            match <[char; 3]>::try_from(letters) {
                Ok(letters) if letters.iter().all(|c| "xyzXYZ".contains(*c)) => self.compiler.sequence = letters,
                _ => sheet.note(Problem::at(
                    a.range_value(),
                    "`eulerseq` is not a sequence of axes",
                    "expected three of xyzXYZ",
                )),
            }
        }
        if let Some(a) = get("inertiafromgeom") {
            let choices = [("auto", FromGeom::Auto), ("true", FromGeom::Always), ("false", FromGeom::Never)];
            self.compiler.from_geom = self.choose(a, &choices).unwrap_or(FromGeom::Auto);
        }
        if let Some(groups) = get("inertiagrouprange").and_then(|a| sheet.numbers::<2>(a)) {
            self.compiler.groups = groups;
        }
        if let Some(total) = get("settotalmass").and_then(|a| sheet.number(a, Range::Any)) {
            self.compiler.total_mass = Some(total).filter(|t| *t > 0.0);
        }
        for name in ["boundmass", "boundinertia"] {
            if let Some(a) = get(name).filter(|a| a.value().trim().parse::<f64>().is_ok_and(|v| v > 0.0)) {
                let problem = Problem::at(a.range(), format!("`{name}` changes masses of the model"), "not supported");
                sheet.note(problem.help("write the masses that are meant into the bodies"));
            }
        }
        for (name, value) in [("balanceinertia", "true"), ("coordinate", "global")] {
            if let Some(a) = get(name).filter(|a| a.value() == value) {
                let message = format!("`{name}=\"{value}\"` changes bodies of the model");
                sheet.note(Problem::at(a.range(), message, "not supported").help("save the model compiled by MuJoCo"));
            }
        }
    }

    pub(super) fn option(&mut self, node: El, gravity: &mut Vector3<f64>) {
        let sheet = self.sheet;
        if let Some(given) = node.attribute_node("gravity").and_then(|a| sheet.numbers::<3>(a)) {
            *gravity = Vector3::from(given);
        }
        for name in ["density", "viscosity"] {
            if let Some(a) =
                node.attribute_node(name).filter(|a| a.value().trim().parse::<f64>().is_ok_and(|v| v != 0.0))
            {
                let problem = Problem::at(a.range(), "forces of a fluid are not modelled", "not supported");
                sheet.note(problem.help("remove it, or give its force as an external force"));
            }
        }
        for flag in children(node).filter(|n| n.has_tag_name("flag")) {
            if flag.attribute("gravity") == Some("disable") {
                *gravity = Vector3::zeros();
            }
            for name in ["spring", "damper", "passive"] {
                if let Some(a) = flag.attribute_node(name).filter(|a| a.value() == "disable") {
                    let problem =
                        Problem::at(a.range(), format!("`{name}=\"disable\"` is not supported"), "changes the torques");
                    sheet.note(problem.help("remove springs and damping of the joints instead"));
                }
            }
        }
    }

    pub(super) fn class(&mut self, node: El<'a>, inside: Option<&'a str>, depth: usize) {
        if depth > limits::DEPTH {
            self.sheet.refuse(node, "default classes are nested too deep", "at most 200 deep");
            return;
        }
        let name = match (node.attribute("class"), inside) {
            (Some(name), _) => name,
            (None, None) => "main",
            (None, Some(_)) => {
                self.sheet.required(node, "class");
                return;
            }
        };
        let above = inside.and_then(|name| self.classes.get_key_value(name).map(|(key, _)| *key));
        // The outermost class may have a name of its own; it still stands for elements without a class.
        let entry = self.classes.entry(name).or_insert((above, Vec::new()));
        let parts: Vec<El> = children(node).filter(|n| !n.has_tag_name("default")).collect();
        entry.1.extend(&parts);
        if inside.is_none()
            && name != "main"
            && let Some(main) = self.classes.get_mut("main")
        {
            main.1.extend(&parts);
        }
        for part in parts {
            match part.tag_name().name() {
                "joint" => self.sheet.only(part, OF_JOINT),
                "geom" => self.sheet.only(part, OF_GEOM),
                _ => {}
            }
        }
        for inner in children(node).filter(|n| n.has_tag_name("default")) {
            self.class(inner, Some(name), depth + 1);
        }
    }

    /// The elements whose attributes hold for an element of a body.
    pub(super) fn layers(&self, node: El<'a>, child_class: Option<&str>) -> Option<Layers<'a>> {
        let mut layers = vec![node];
        let mut class = match node.attribute_node("class") {
            Some(a) => Some(self.known_class(a)?),
            None => Some(child_class.unwrap_or("main")),
        };
        while let Some((above, parts)) = class.and_then(|name| self.classes.get(name)) {
            // What stands later in a class wins.
            layers.extend(parts.iter().rev().filter(|p| p.tag_name() == node.tag_name()));
            class = *above;
        }
        Some(Layers(layers))
    }

    pub(super) fn known_class(&self, attribute: Attribute<'a, 'a>) -> Option<&'a str> {
        let name = attribute.value();
        let found = self.classes.get_key_value(name).map(|(key, _)| *key);
        if found.is_none() {
            let shown: String = name.chars().take(60).collect();
            let mut names: Vec<&str> = self.classes.keys().copied().collect();
            names.sort_unstable();
            self.sheet.note(
                Problem::at(attribute.range_value(), format!("there is no default class `{shown}`"), "named here")
                    .suggest(&shown, names),
            );
        }
        found
    }
}
