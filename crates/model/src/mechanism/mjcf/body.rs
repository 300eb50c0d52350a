//! Bodies with their joints and sites.

use nalgebra::{Isometry3, Translation3, Vector3};
use roxmltree::Attribute;

use super::words::*;
use super::{FromGeom, Layers, Reader};
use crate::input::{Problem, Range, limits};
use crate::mechanism::xml::{El, children, span};
use crate::mechanism::{Body, Inertia, Joint, Motion, pose};

impl<'a> Reader<'a, '_> {
    /// Reads what stands in a body, in a frame of it, or in the world (`body` none). `outer` is where the
    /// frame is in the body.
    pub(super) fn inside(
        &mut self,
        node: El<'a>,
        body: Option<usize>,
        class: Option<&'a str>,
        outer: Isometry3<f64>,
        masses: &mut Vec<Inertia>,
        depth: usize,
    ) {
        let sheet = self.sheet;
        if depth > limits::DEPTH {
            sheet.refuse(node, "bodies are nested too deep", "at most 200 deep");
            return;
        }
        let class = match node.attribute_node("childclass") {
            Some(a) => self.known_class(a).or(class),
            None => class,
        };
        for child in children(node) {
            match child.tag_name().name() {
                "body" => self.body(child, body, class, outer, depth + 1),
                "frame" => {
                    let Some(layers) = self.layers(child, None) else { continue };
                    let here = outer * pose(self.at(&layers), self.orientation(&layers));
                    self.inside(child, body, class, here, masses, depth + 1);
                }
                "geom" => {
                    if let Some(inertia) = body.and_then(|_| self.geom(child, class)) {
                        masses.push(inertia.at(&outer));
                    }
                }
                "site" => self.site(child, body, class, &outer),
                "freejoint" => self.refuse_free(child),
                // Read with the body that they belong to.
                "inertial" | "joint" if body.is_some() => {}
                "plugin" | "composite" | "flexcomp" | "replicate" | "attach" | "include" => {
                    let what = format!("`{}` in a body is not read", child.tag_name().name());
                    sheet.refuse(child, &what, "write out the bodies that it makes");
                }
                other if ASIDE.contains(&other) => {}
                _ => sheet.unknown(child, IN_BODY),
            }
        }
    }

    pub(super) fn refuse_free(&self, node: El) {
        self.sheet.refuse(
            node,
            "a free joint: the base of this model moves",
            "remove it: the base is then fixed, which is exact while the base moves without acceleration; forces on the feet are columns of the trajectory",
        );
    }

    /// All joints of a body, those in its frames with the frame.
    pub(super) fn joints(
        &mut self,
        node: El<'a>,
        class: Option<&'a str>,
        outer: Isometry3<f64>,
        found: &mut Vec<(Joint, Vector3<f64>)>,
    ) {
        for child in children(node) {
            if child.has_tag_name("frame") {
                let class = child.attribute("childclass").or(class);
                let Some(layers) = self.layers(child, None) else { continue };
                let here = outer * pose(self.at(&layers), self.orientation(&layers));
                self.joints(child, class, here, found);
            } else if child.has_tag_name("joint")
                && let Some((joint, at)) = self.joint(child, class)
            {
                let axis = outer.rotation * joint.axis;
                let at = (outer * nalgebra::Point3::from(at)).coords;
                found.push((Joint { axis, ..joint }, at));
            }
        }
    }

    pub(super) fn joint(&mut self, node: El<'a>, class: Option<&'a str>) -> Option<(Joint, Vector3<f64>)> {
        let sheet = self.sheet;
        sheet.only(node, OF_JOINT);
        let layers = self.layers(node, class)?;
        let kinds = [("hinge", Some(Motion::Turns)), ("slide", Some(Motion::Slides)), ("ball", None), ("free", None)];
        let kind = layers.get("type").map_or(Some(Some(Motion::Turns)), |a| self.choose(a, &kinds))?;
        let Some(motion) = kind else {
            if layers.word("type") == Some("free") {
                self.refuse_free(node);
            } else {
                sheet.refuse(node, "a ball joint has three degrees of freedom", "write it as three hinges");
            }
            return None;
        };
        let name = match node.attribute("name") {
            Some(name) => name.to_string(),
            None => format!("joint_{}", self.joint_names.len() + 1),
        };
        sheet.unique(node, "joints", &name, &mut self.joint_names);
        let axis = layers.get("axis").map_or(Some(Vector3::z_axis()), |a| sheet.direction(a))?;
        let unit = if motion == Motion::Turns { self.compiler.angle } else { 1.0 };
        let number = |name: &str, range| layers.get(name).and_then(|a| sheet.number(a, range)).unwrap_or(0.0);
        let mut joint = Joint::new(name, motion, axis);
        joint.reference = number("ref", Range::Any) * unit;
        joint.damping = number("damping", Range::NonNegative);
        joint.friction = number("frictionloss", Range::NonNegative);
        joint.stiffness = number("stiffness", Range::NonNegative);
        joint.spring_reference = number("springref", Range::Any) * unit;
        joint.armature = number("armature", Range::NonNegative);
        let range = layers.get("range").and_then(|a| sheet.numbers::<2>(a)).filter(|r| r[0] < r[1]);
        joint.range = range.filter(|_| layers.word("limited") != Some("false")).map(|r| r.map(|end| end * unit));
        for (name, zero) in [("springdamper", "0 0"), ("springyield", "0")] {
            let set =
                |a: &Attribute| a.value().split_whitespace().any(|w| w.parse() != Ok(0.0)) && a.value().trim() != zero;
            if let Some(a) = layers.get(name).filter(set) {
                let problem = Problem::at(a.range(), format!("`{name}` is not supported"), "changes the torques");
                sheet.note(problem.help("give `stiffness` and `damping`"));
            }
        }
        Some((joint, Vector3::from(self.at(&layers))))
    }

    pub(super) fn body(
        &mut self,
        node: El<'a>,
        parent: Option<usize>,
        class: Option<&'a str>,
        outer: Isometry3<f64>,
        depth: usize,
    ) {
        let sheet = self.sheet;
        sheet.only(node, OF_BODY);
        if node.attribute("mocap") == Some("true") {
            sheet.refuse(node, "a mocap body is moved from outside", "remove it, or make it fixed");
        }
        if let Some(a) = node.attribute_node("gravcomp").filter(|a| a.value().trim().parse() != Ok(0.0)) {
            let problem = Problem::at(
                a.range(),
                "`gravcomp` takes weight off the actuators without saying what carries it",
                "not supported",
            );
            sheet.note(problem.help("remove it, or give its force as an external force"));
        }
        let name = node.attribute("name").map(str::to_string);
        if let Some(name) = &name {
            sheet.unique(node, "bodies", name, &mut self.body_names);
        }
        let inner_class = match node.attribute_node("childclass") {
            Some(a) => self.known_class(a).or(class),
            None => class,
        };
        let own = Layers(vec![node]);
        let mut placement = outer * pose(self.at(&own), self.orientation(&own));
        let mut joints = Vec::new();
        self.joints(node, inner_class, Isometry3::identity(), &mut joints);
        // Each joint turns about its own point: go there, turn, and go back.
        let mut hangs_on = parent;
        for (joint, at) in joints {
            placement *= Translation3::from(at);
            self.bodies.push(Body {
                name: None,
                parent: hangs_on,
                placement,
                joint: Some(joint),
                inertia: Inertia::none(),
            });
            hangs_on = Some(self.bodies.len() - 1);
            placement = Translation3::from(-at).into();
        }
        let here = match hangs_on {
            // The last joint's frame is the body's where nothing lies between them.
            Some(last) if hangs_on != parent && placement.translation.vector == Vector3::zeros() => {
                self.bodies[last].name = name;
                last
            }
            _ => {
                self.bodies.push(Body { name, parent: hangs_on, placement, joint: None, inertia: Inertia::none() });
                self.bodies.len() - 1
            }
        };
        let mut of_geoms = Vec::new();
        self.inside(node, Some(here), class, Isometry3::identity(), &mut of_geoms, depth);
        let given: Vec<El> = children(node).filter(|n| n.has_tag_name("inertial")).collect();
        if let [_, second, ..] = given.as_slice() {
            sheet.note(Problem::at(span(*second), "two `inertial` of one body", "expected one"));
        }
        let use_geoms = match self.compiler.from_geom {
            FromGeom::Auto => given.is_empty(),
            FromGeom::Always => true,
            FromGeom::Never => false,
        };
        self.bodies[here].inertia = if use_geoms {
            of_geoms.iter().fold(Inertia::none(), |sum, part| sum.with(part))
        } else {
            given.first().map_or_else(Inertia::none, |node| self.inertial(*node))
        };
    }

    /// A site is a frame at which forces can act; it is placed when all bodies have their names.
    pub(super) fn site(&mut self, node: El<'a>, body: Option<usize>, class: Option<&'a str>, outer: &Isometry3<f64>) {
        let (Some(body), Some(name)) = (body, node.attribute("name")) else { return };
        let Some(layers) = self.layers(node, class) else { return };
        let here = outer * pose(self.at(&layers), self.orientation(&layers));
        self.sites.push((body, name.to_string(), here));
    }
}
